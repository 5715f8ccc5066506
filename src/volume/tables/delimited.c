/* SPDX-License-Identifier: BSD-3-Clause */
/* Records of delimited text. */
#include "tables/label_table.h"

#include <string.h>

/* Take the field at *at apart: without its quotation marks, or without the blanks around it, as a
 * text of its own. *at moves behind it, to the separator, the end of the line or of the text, which
 * may be overwritten: *behind is what stood there. */
static char *next_field(char **at, char delimiter, char *behind, int *lines)
{
    const char stops[] = {delimiter, '\r', '\n', '\0'};
    char *from = *at + strspn(*at, delimiter == '\t' ? " " : " \t"), *field = from, *to;

    if (*from == '"') {
        field = to = ++from;
        while (*from && (*from != '"' || from[1] == '"')) {
            *lines += *from == '\n';
            from += *from == '"'; /* two of them stand for one */
            *to++ = *from++;
        }
        from += *from == '"';
        from += strcspn(from, stops);
    } else {
        from += strcspn(from, stops);
        for (to = from; to > field && to[-1] == ' ';)
            to--;
    }
    *behind = *from;
    *to = '\0';
    *at = from;
    return field;
}

size_t sc_delimited_record(char **at, char delimiter, char **fields, size_t most, int *lines)
{
    size_t count = 0;
    char behind;

    do {
        char *field = next_field(at, delimiter, &behind, lines);

        if (count < most)
            fields[count++] = field;
        *at += behind != '\0';
    } while (behind == delimiter);
    *at += behind == '\r' && **at == '\n';
    ++*lines;
    if (!behind)
        *at = NULL;
    return count;
}

const char *sc_delimited_skip_comments(const char *text, int *lines)
{
    while (*text) {
        const char *first = text + strspn(text, " \t"), *end = first + strcspn(first, "\r\n");

        if (first != end && *first != '#')
            return text;
        text = end + (*end != '\0') + (end[0] == '\r' && end[1] == '\n');
        ++*lines;
    }
    return text;
}

char *sc_delimited_next_line(char *line)
{
    char *end = line + strcspn(line, "\r\n");

    return *end ? end + 1 + (end[0] == '\r' && end[1] == '\n') : NULL;
}
