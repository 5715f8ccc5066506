/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to job: what libyaml finds wrong with a text, in words for who wrote the text. */
#ifndef SC_JOB_YAML_WORDS_H
#define SC_JOB_YAML_WORDS_H

#include "segcast/base.h"

#include <yaml.h>

/* Log why @p parser has stopped with an error in text[bytes], which messages call @p origin, as
 * "origin:line:column: what is wrong; what to write instead". @return SC_ERR_DATA, or SC_ERR_MEMORY
 * if memory ran out. */
sc_status sc_yaml_explain(const sc_ctx *ctx, const char *origin, const char *text, size_t bytes,
                          const yaml_parser_t *parser);

/* @return where the value begins in a line such as "fps:30", which YAML takes for a single word:
 * the blank behind the colon is missing. NULL if @p line begins with nothing of this kind. */
const char *sc_yaml_lost_blank(const char *line);
/* The words that tell it, for the arguments name with its colon (as %.*s) and value. */
#define SC_LOST_BLANK "a blank is missing behind the colon; expected \"%.*s %s\""

#endif
