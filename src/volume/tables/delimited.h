/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to volume: text in which commas, semicolons, tabs or bars separate fields (RFC 4180, but
 * for the separator). */
#ifndef SC_VOLUME_DELIMITED_H
#define SC_VOLUME_DELIMITED_H

#include <stddef.h>

/* What may separate fields. */
#define SC_DELIMITERS "\t,;|"

/* Take the line at *at apart; a field in quotation marks may go over several. @param fields [most];
 * what is beyond is left out. *at moves to the next line; NULL behind the last one. @param lines
 * counts the lines that were read. @return the number of fields. */
size_t sc_delimited_record(char **at, char delimiter, char **fields, size_t most, int *lines);
/* @return the line behind @p line, whatever quotation marks are in that; NULL behind the last one.
 */
char *sc_delimited_next_line(char *line);
/* @return the first line that is neither blank nor a comment. @param lines counts those before. */
const char *sc_delimited_skip_comments(const char *text, int *lines);

#endif
