/* SPDX-License-Identifier: BSD-3-Clause */
/* Tables of values: the column of a spreadsheet, and whose value each line has. */
#include "segcast/value_table.h"

#include "tables/label_table.h"

#include <math.h>
#include <stdlib.h>
#include <strings.h>

enum {
    FIELDS_MAX = 4096, /* columns that are read: tables of statistics are wide */
    NO_COLUMN = FIELDS_MAX,
    OFFERED_MAX = 12 /* headings in a message */
};

/* A table while it is read. */
typedef struct value_reading {
    const char *path;
    char delimiter;
    size_t number, name, value; /* columns; NO_COLUMN: there is none */
    bool either;                /* the column of the name, "label", may hold the number instead */
    char *fields[FIELDS_MAX];
    char *at;                   /* what is still to be read; NULL: nothing */
    int line;                   /* number of the last line read, counted from 1 */
    int unnamed, first_unnamed; /* lines without number and name, and the first of them */
} value_reading;

void sc_value_table_clear(sc_value_table *table)
{
    sc_free(table->rows);
    sc_free(table->text);
    *table = (sc_value_table){0};
}

/* ---- headings ---- */

/* @return whether a column that could hold the numbers of labels may as well number the rows:
 * another one goes before it, such as SegId in statistics of FreeSurfer. */
static bool is_row_number(const char *heading)
{
    return !strcasecmp(heading, "index") || !strcasecmp(heading, "i") || !strcasecmp(heading, "no");
}

/* Find the columns that tell the tissue of a line; that of the values, @p wanted, is none of them.
 * The heading "value" means the values where another column has the names. @return whether there
 * are any. */
static bool find_keys(value_reading *r, size_t count, const char *wanted)
{
    r->number = r->name = NO_COLUMN;
    for (size_t i = count; i-- > 0;) {
        const sc_column column = sc_column_of(r->fields[i]);

        if (*wanted && !strcasecmp(r->fields[i], wanted))
            continue;
        if (column == SC_COLUMN_VALUE && !(r->number != NO_COLUMN && is_row_number(r->fields[i])))
            r->number = i;
        else if (column == SC_COLUMN_NAME || column == SC_COLUMN_LABEL)
            r->name = i;
    }
    r->either = r->name != NO_COLUMN && sc_column_of(r->fields[r->name]) == SC_COLUMN_LABEL;
    if (!*wanted && r->name != NO_COLUMN && r->number != NO_COLUMN &&
        !strcasecmp(r->fields[r->number], "value"))
        r->number = NO_COLUMN;
    for (size_t i = 0; i < count && r->name == NO_COLUMN; i++) {
        if (sc_column_of(r->fields[i]) == SC_COLUMN_SHORT)
            r->name = i;
    }
    return r->number != NO_COLUMN || r->name != NO_COLUMN;
}

/* @return the only column with this heading, in every letter or else but for case; NO_COLUMN if
 * there is none, or several. */
static size_t find_heading(const value_reading *r, size_t count, const char *column)
{
    int (*const compare[])(const char *, const char *) = {strcmp, strcasecmp};

    for (size_t c = 0; c < SC_COUNT_OF(compare); c++) {
        size_t found = NO_COLUMN, matches = 0;

        for (size_t i = 0; i < count; i++) {
            if (compare[c](r->fields[i], column) == 0) {
                found = i;
                matches++;
            }
        }
        if (matches)
            return matches == 1 ? found : NO_COLUMN;
    }
    return NO_COLUMN;
}

/* @return the only column that is none of a label table; NO_COLUMN if there is none, or several. */
static size_t find_other(const value_reading *r, size_t count)
{
    size_t found = NO_COLUMN, others = 0;

    for (size_t i = 0; i < count; i++) {
        const bool is_value = r->number == NO_COLUMN && !strcasecmp(r->fields[i], "value");

        if ((sc_column_of(r->fields[i]) == SC_COLUMN_OTHER && *r->fields[i]) || is_value) {
            found = i;
            others++;
        }
    }
    return others == 1 ? found : NO_COLUMN;
}

/* Log that the column of values cannot be told, with those that there are. */
static sc_status fail_column(const sc_ctx *ctx, const value_reading *r, size_t count,
                             const char *column)
{
    SC_OWN(sc_text_clear) sc_text text = {0};
    char heading[104];
    size_t offered = 0;

    for (size_t i = 0; i < count && offered < OFFERED_MAX; i++) {
        if (i == r->number || i == r->name || !*r->fields[i])
            continue;
        (void)sc_copy_name(r->fields[i], heading, sizeof heading);
        SC_PASS(sc_text_add(ctx, &text, "%s\"%s\"", offered++ ? ", " : "", heading));
    }
    return sc_fail(ctx, SC_ERR_DATA,
                   "%s:%d: has not exactly one column %s%s%s%s; expected as color_by.column the "
                   "heading of the values, one of: %s",
                   r->path, r->line, *column ? "\"" : "that may hold the values", column,
                   *column ? "\"" : "",
                   count == FIELDS_MAX ? " among the first 4096, which are read" : "",
                   offered ? text.data : "(none)");
}

/* Read the line of headings behind comments, for one delimiter after the other, until one parts
 * columns that tell the tissue from others. */
static sc_status read_headings(const sc_ctx *ctx, value_reading *r, char *text, const char *column,
                               sc_value_table *table)
{
    char *begin = text + (sc_delimited_skip_comments(text, &r->line) - text);
    const size_t bytes = strcspn(begin, "\r\n");
    const int before = r->line;
    size_t count = 0;
    SC_OWN(sc_free_at) char *copy = NULL;

    SC_PASS(SC_ALLOC(ctx, bytes + 1, &copy));
    for (const char *d = SC_DELIMITERS; *d; d++) {
        char *at = copy;

        memcpy(copy, begin, bytes);
        at[bytes] = '\0';
        r->line = before;
        r->delimiter = *d;
        count = sc_delimited_record(&at, *d, r->fields, FIELDS_MAX, &r->line);
        if (count > 1 && find_keys(r, count, column))
            break;
        count = 0;
    }
    if (!count)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s:%d: is no line of headings that name the number or the name of the "
                       "tissue and the values; expected for example: name,thickness_mm",
                       r->path, r->line);
    r->value = *column ? find_heading(r, count, column) : find_other(r, count);
    if (r->value == NO_COLUMN)
        return fail_column(ctx, r, count, column);
    (void)sc_copy_name(r->fields[r->value], table->column, sizeof table->column);
    r->at = begin[bytes] ? begin + bytes + 1 + (begin[bytes] == '\r' && begin[bytes + 1] == '\n')
                         : NULL;
    return SC_OK;
}

/* ---- lines ---- */

/* @return whether a field stands for a value that is not known. */
static bool is_missing(const char *text)
{
    static const char *const words[] = {"", "n/a", "na", "nan", "none", "null", "-"};

    for (size_t i = 0; i < SC_COUNT_OF(words); i++) {
        if (!strcasecmp(text, words[i]))
            return true;
    }
    return false;
}

/* Read the value of a line into @p row. */
static sc_status read_value(const sc_ctx *ctx, const value_reading *r, const char *field,
                            sc_value_row *row)
{
    const char *comma = strchr(field, ',');
    char *end;

    row->value = NAN;
    if (is_missing(field))
        return SC_OK;
    row->value = strtod(field, &end);
    if (end != field && !end[strspn(end, " ")] && isfinite(row->value))
        return SC_OK;
    return sc_fail(ctx, SC_ERR_DATA,
                   "%s:%d: the value is \"%.60s\", expected a number%s, or n/a where it is not "
                   "known",
                   r->path, row->line, field, comma ? " with a decimal point" : "");
}

/* Append a row. */
static sc_status add_row(const sc_ctx *ctx, const value_reading *r, const sc_value_row *row,
                         sc_value_table *table)
{
    if (table->count == SC_TABLE_ROWS_MAX)
        return sc_fail(ctx, SC_ERR_DATA, "%s:%d: more than %d rows; keep those of the tissues",
                       r->path, row->line, SC_TABLE_ROWS_MAX);
    SC_PASS(SC_GROW(ctx, table->count, &table->capacity, &table->rows));
    table->rows[table->count++] = *row;
    return SC_OK;
}

/* Read one line. */
static sc_status read_row(const sc_ctx *ctx, value_reading *r, sc_value_table *table)
{
    const bool comment = *r->at == '#';
    sc_value_row row = {.name = "", .line = r->line + 1};
    const size_t count = sc_delimited_record(&r->at, r->delimiter, r->fields, FIELDS_MAX, &r->line);
    sc_status status;

    if (comment || (count == 1 && !*r->fields[0]))
        return SC_OK;
    if (r->number < count)
        row.has_number = sc_label_value_read(r->fields[r->number], &row.number);
    if (r->name < count)
        row.name = r->fields[r->name];
    if (r->number == NO_COLUMN && r->either && *row.name)
        row.has_number = sc_label_value_read(row.name, &row.number);
    if (!row.has_number && !*row.name) {
        r->first_unnamed = r->unnamed++ ? r->first_unnamed : row.line;
        return SC_OK;
    }
    status = read_value(ctx, r, r->value < count ? r->fields[r->value] : "", &row);
    return status == SC_OK ? add_row(ctx, r, &row, table) : status;
}

sc_status sc_value_table_read(const sc_ctx *ctx, const char *path, const char *column,
                              sc_value_table *out)
{
    SC_OWN(sc_value_table_clear) sc_value_table table = {0};
    size_t bytes;
    SC_OWN(sc_free_at) value_reading *r = NULL;

    SC_PASS(SC_ZALLOC(ctx, 1, &r));
    r->path = path;
    SC_PASS(sc_file_read(ctx, path, SC_TABLE_BYTES_MAX, &table.text, &bytes));
    SC_PASS(sc_label_text_decode(ctx, path, &table.text, &bytes));
    SC_PASS(read_headings(ctx, r, table.text, column, &table));
    while (r->at && *r->at)
        SC_PASS(read_row(ctx, r, &table));
    if (!table.count)
        return sc_fail(ctx, SC_ERR_DATA, "%s: has headings, but no tissues below them", path);
    if (r->unnamed)
        sc_warn(ctx, "%s:%d: %d line%s neither number nor name of a tissue and %s not used", path,
                r->first_unnamed, r->unnamed, r->unnamed == 1 ? " has" : "s have",
                r->unnamed == 1 ? "is" : "are");
    SC_HAND_OVER(table, out);
    return SC_OK;
}
