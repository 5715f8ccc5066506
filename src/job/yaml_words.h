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

#endif
