/* SPDX-License-Identifier: BSD-3-Clause */
/* Label tables as spreadsheets write them: a line of headings, and fields that commas, semicolons
 * or tabs separate (RFC 4180, but for the separator). */
#include "label_table.h"

#include <string.h>

static const char delimiters[] = "\t,;";

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

/* Take the line at *at apart. @param fields [SC_COLUMNS_MAX]; what is beyond is left out. *at moves
 * to the next line; NULL behind the last one. @return the number of fields. */
static size_t next_record(char **at, char delimiter, char **fields, int *lines)
{
    size_t count = 0;
    char behind;

    do {
        char *field = next_field(at, delimiter, &behind, lines);

        if (count < SC_COLUMNS_MAX)
            fields[count++] = field;
        *at += behind != '\0';
    } while (behind == delimiter);
    *at += behind == '\r' && **at == '\n';
    ++*lines;
    if (!behind)
        *at = NULL;
    return count;
}

/* @return the first line that is neither blank nor a comment. @param lines counts those before. */
static const char *skip_comments(const char *text, int *lines)
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

/* Read the headings at *at, which is taken apart and moves behind them.
 * @param columns [SC_COLUMNS_MAX]. @return how many there are; 0 if they are not those of a label
 * table. */
static size_t read_headings(char **at, char delimiter, sc_column *columns, int *lines)
{
    char *fields[SC_COLUMNS_MAX];
    const size_t count = next_record(at, delimiter, fields, lines);

    for (size_t i = 0; i < count; i++)
        columns[i] = sc_column_of(fields[i]);
    return sc_columns_settle(columns, count) ? count : 0;
}

bool sc_label_delimited_is(const char *text, char *delimiter)
{
    char line[8192];
    int lines = 0;
    size_t bytes;

    text = skip_comments(text, &lines);
    bytes = strcspn(text, "\r\n");
    if (bytes >= sizeof line)
        return false;
    for (const char *d = delimiters; *d; d++) {
        sc_column columns[SC_COLUMNS_MAX];
        char *at = line;

        memcpy(line, text, bytes);
        line[bytes] = '\0';
        if (read_headings(&at, *d, columns, &lines)) {
            *delimiter = *d;
            return true;
        }
    }
    return false;
}

/* The lines below the headings while they are read. */
typedef struct record_reading {
    sc_column columns[SC_COLUMNS_MAX]; /* [column_count] */
    size_t column_count;
    sc_column_rows rows;
    char delimiter;
    bool any;         /* a label was read */
    int line;         /* number of the last line read, counted from 1 */
    int unread;       /* lines that are no labels */
    int first_unread; /* the first of them */
} record_reading;

/* Read the lines behind the headings. @param at NULL: there are none. @return as
 * sc_column_rows_add.
 */
static sc_status read_records(const sc_ctx *ctx, char *at, record_reading *r)
{
    sc_status status = SC_OK;

    while (at && status == SC_OK) {
        const int line = r->line + 1;
        const bool comment = *at == '#' && r->columns[0] != SC_COLUMN_COLOR;
        char *fields[SC_COLUMNS_MAX];
        size_t count = next_record(&at, r->delimiter, fields, &r->line);
        bool read;

        if (comment || (count == 1 && !*fields[0]))
            continue;
        count = count < r->column_count ? count : r->column_count;
        status = sc_column_rows_add(ctx, &r->rows, r->columns, (const char *const *)fields, count,
                                    &read);
        r->any = r->any || read;
        if (!read && r->unread++ == 0)
            r->first_unread = line;
    }
    return status;
}

sc_status sc_label_delimited_parse(const sc_ctx *ctx, const char *path, char *text,
                                   sc_label_table *table)
{
    record_reading r = {.rows = sc_column_rows_begin(table)};
    char *at;
    sc_status status;

    if (!sc_label_delimited_is(text, &r.delimiter))
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: has no line of headings that name a number and a name or a colour; "
                       "expected for example: value,name,color",
                       path);
    at = text + (skip_comments(text, &r.line) - text);
    r.column_count = read_headings(&at, r.delimiter, r.columns, &r.line);
    status = read_records(ctx, at, &r);
    sc_column_rows_end(ctx, path, &r.rows);
    if (status == SC_ERR_DATA)
        return sc_fail(
            ctx, status,
            "%s: more than %d rows, but a volume has at most %d labels; keep the rows of "
            "the labels in the volume",
            path, SC_TABLE_ROWS_MAX, SC_LABELS_MAX - 1);
    if (status == SC_OK && !r.any)
        return r.unread
                   ? sc_fail(ctx, SC_ERR_DATA,
                             "%s:%d: has no whole number in the column of the label's number", path,
                             r.first_unread)
                   : sc_fail(ctx, SC_ERR_DATA, "%s: has headings, but no labels below them", path);
    if (status == SC_OK && r.unread)
        sc_warn(ctx,
                "%s:%d: %d line%s no whole number in the column of the label's number and %s not "
                "used",
                path, r.first_unread, r.unread, r.unread == 1 ? " has" : "s have",
                r.unread == 1 ? "is" : "are");
    return status;
}
