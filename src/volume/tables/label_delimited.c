/* SPDX-License-Identifier: BSD-3-Clause */
/* Label tables as spreadsheets write them: a line of headings, and a line for each label. */
#include "tables/delimited.h"
#include "tables/label_table.h"

#include <string.h>

/* Read the headings at *at, which is taken apart and moves behind them.
 * @param fields [SC_COLUMNS_MAX] the headings, in *at. @param columns [SC_COLUMNS_MAX]. @return how
 * many there are; 0 if they are not those of a label table. */
static size_t read_headings(char **at, char delimiter, char **fields, sc_column *columns,
                            int *lines)
{
    const size_t count = sc_delimited_record(at, delimiter, fields, SC_COLUMNS_MAX, lines);

    for (size_t i = 0; i < count; i++)
        columns[i] = sc_column_of(fields[i]);
    return sc_columns_settle(columns, count) ? count : 0;
}

bool sc_label_delimited_is(const char *text, char *delimiter)
{
    char line[8192];
    int lines = 0;
    size_t bytes;

    text = sc_delimited_skip_comments(text, &lines);
    bytes = strcspn(text, "\r\n");
    if (bytes >= sizeof line)
        return false;
    for (const char *d = SC_DELIMITERS; *d; d++) {
        sc_column columns[SC_COLUMNS_MAX];
        char *fields[SC_COLUMNS_MAX], *at = line;

        memcpy(line, text, bytes);
        line[bytes] = '\0';
        if (read_headings(&at, *d, fields, columns, &lines)) {
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

/* Tell which columns are not used, such as the codes of terminologies. @param headings
 * [r->column_count]. */
static sc_status tell_unused(const sc_ctx *ctx, const char *path, const record_reading *r,
                             char *const *headings)
{
    sc_text names = {0};
    sc_status status = SC_OK;

    for (size_t i = 0; i < r->column_count; i++) {
        if (r->columns[i] == SC_COLUMN_OTHER && headings[i][0])
            SC_TRY(sc_text_add(ctx, &names, "%s\"%.40s\"", names.length_bytes ? ", " : "",
                               headings[i]));
    }
    if (names.length_bytes)
        sc_info(ctx, "%s: columns that are not used: %s", path, names.data);
out:
    sc_text_clear(&names);
    return status;
}

/* Read the lines behind the headings. @param at NULL: there are none. @return as
 * sc_column_rows_add.
 */
static sc_status read_records(const sc_ctx *ctx, char *at, record_reading *r)
{
    sc_status status = SC_OK;

    while (at && status == SC_OK) {
        const int line = r->line + 1;
        char *fields[SC_COLUMNS_MAX];
        size_t count;
        bool read;

        if (*at == '#' && r->columns[0] != SC_COLUMN_COLOR) {
            at = sc_delimited_next_line(at);
            r->line++;
            continue;
        }
        count = sc_delimited_record(&at, r->delimiter, fields, SC_COLUMNS_MAX, &r->line);
        if (count == 1 && !*fields[0])
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
    char *headings[SC_COLUMNS_MAX], *at;
    sc_status status;

    if (!sc_label_delimited_is(text, &r.delimiter))
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: has no line of headings that name a number and a name or a colour; "
                       "expected for example: value,name,color",
                       path);
    at = text + (sc_delimited_skip_comments(text, &r.line) - text);
    r.column_count = read_headings(&at, r.delimiter, headings, r.columns, &r.line);
    status = tell_unused(ctx, path, &r, headings);
    if (status == SC_OK)
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
