/* SPDX-License-Identifier: BSD-3-Clause */
/* Judges the fields of rows of label tables, whatever these are written in, and makes labels of
 * them. */
#include "segcast/image.h"
#include "tables/label_table.h"

#include <stdlib.h>
#include <strings.h>

enum {
    COLOR_LEVELS = 3,
    OPACITY = 3,      /* index of the opacity among the levels of a label */
    NUMBER_BYTES = 64 /* room for a number as text */
};

char *sc_row_add(sc_row *row, sc_column column, const char *field)
{
    char *text;

    if (row->count == SC_COLUMNS_MAX)
        return NULL;
    text = row->texts[row->count];
    text[0] = '\0';
    row->columns[row->count] = column;
    row->fields[row->count++] = field ? field : text;
    return text;
}

/* Read a text as a finite number and nothing else, in which a comma may stand for the point, as
 * spreadsheets write it in many countries; a percent sign behind it makes it hundredths. */
static bool read_number(const char *text, double *out)
{
    char copy[NUMBER_BYTES];
    char *end, *comma;

    if (snprintf(copy, sizeof copy, "%s", text) >= (int)sizeof copy)
        return false;
    comma = strchr(copy, ',');
    if (comma)
        *comma = '.';
    *out = strtod(copy, &end);
    if (end == copy)
        return false;
    end += strspn(end, " \t\r\n");
    if (*end == '%') {
        *out /= 100;
        end += 1 + strspn(end + 1, " ");
    }
    return !*end && isfinite(*out);
}

bool sc_label_value_read(const char *text, int64_t *out)
{
    double number;

    if (strpbrk(text, ",%") || !read_number(text, &number) || number != floor(number) ||
        fabs(number) > 9e15)
        return false;
    *out = (int64_t)number;
    return true;
}

/* Read the number of a label that the dialect can have. */
static bool read_value(const sc_dialect *dialect, const char *text, int64_t *out)
{
    return sc_label_value_read(text, out) &&
           (!dialect->highest || (*out >= 0 && *out <= dialect->highest));
}

/* Read rrggbb, rrggbbaa or rgb, hexadecimal, into levels from 0 to 255. @return whether it is one
 * of these; level[3] stays as it is without opacity. */
static bool read_hexadecimal(const char *text, double level[4])
{
    const size_t digits = strlen(text), each = digits == 3 ? 1 : 2;

    if ((digits != 3 && digits != 6 && digits != 8) ||
        strspn(text, "0123456789abcdefABCDEF") != digits)
        return false;
    for (size_t i = 0; i < digits / each; i++) {
        const char digit[3] = {text[each * i], each == 2 ? text[each * i + 1] : '\0'};

        level[i] = (double)strtol(digit, NULL, 16) * (each == 1 ? 17 : 1);
    }
    return true;
}

/* Read three or four numbers, between which blanks, commas or semicolons stand, and around which
 * brackets and "rgb" may. The fourth of rgba(...) goes from 0 to 1, as in CSS. */
static bool read_levels(const char *text, double level[4])
{
    const bool is_css = !strncasecmp(text, "rgb", 3);
    int count = 0;

    text += is_css ? 3 + (text[3] == 'a' || text[3] == 'A') : 0;
    text += strspn(text, "([ ");
    while (count < 4 && *text && !strchr(")]", *text)) {
        char *end;

        level[count] = strtod(text, &end);
        if (end == text || !isfinite(level[count]))
            return false;
        count++;
        text = end + strspn(end, " ,;");
    }
    if (is_css && count == 4)
        level[OPACITY] *= 255;
    return count >= COLOR_LEVELS && !text[strspn(text, ")] ")];
}

/* Read the text of a whole colour: its name in CSS, digits, or levels. @return whether it is one;
 * level[3] stays as it is without opacity. */
static bool read_color(const char *text, double level[4])
{
    uint8_t rgb[3];
    char plain[SC_COLOR_NAME_BYTES];

    text += strspn(text, " ");
    if (sc_color_by_name(text, plain, rgb)) {
        for (int c = 0; c < COLOR_LEVELS; c++)
            level[c] = rgb[c];
        return true;
    }
    if (*text == '#' || !strncasecmp(text, "0x", 2))
        return read_hexadecimal(text + (*text == '#' ? 1 : 2), level);
    return read_hexadecimal(text, level) || read_levels(text, level);
}

/* @return whether a label with this field in the column "visible" is shown. */
static bool is_shown(const char *text)
{
    static const char *const no[] = {"0", "no", "false", "off", "hidden", "n"};

    for (size_t i = 0; i < SC_COUNT_OF(no); i++) {
        if (!strcasecmp(text, no[i]))
            return false;
    }
    return true;
}

/* ---- rows ---- */

sc_rows sc_rows_begin(const sc_ctx *ctx, const char *path, const sc_dialect *dialect,
                      sc_label_table *table)
{
    return (sc_rows){
        .ctx = ctx, .path = path, .dialect = dialect, .table = table, .first = table->count};
}

void sc_rows_skip(sc_rows *rows, int line)
{
    if (rows->unread++ == 0)
        rows->first_unread = line;
}

/* Note that a field with a colour or a part of one cannot be read. */
static void count_bad_color(sc_rows *rows, const char *field, int line)
{
    if (rows->dialect->is_strict)
        sc_rows_skip(rows, line);
    else if (rows->bad_colors++ == 0)
        (void)sc_copy_name(field, rows->bad_color, sizeof rows->bad_color);
}

/* Read a field with a level of a colour or of opacity. */
static bool read_level(const sc_rows *rows, const char *field, bool of_opacity, double *level)
{
    double number;

    if (!read_number(field, &number) ||
        (rows->dialect->is_strict &&
         (number < 0 || number > (double)rows->dialect->full[of_opacity])))
        return false;
    *level = number;
    return true;
}

/* Read a field, unless it is the number of the label or empty, or stands for a value that is not
 * known. @p level receives red, green, blue and opacity. */
static void read_field(sc_rows *rows, sc_column column, const char *field, int line, sc_label *row,
                       double level[4])
{
    const bool is_color = column >= SC_COLUMN_COLOR && column <= SC_COLUMN_TRANSPARENCY;
    const bool is_opacity = column >= SC_COLUMN_ALPHA;
    double color[4] = {NAN, NAN, NAN, NAN};

    if (!*field || !strcasecmp(field, "n/a"))
        return;
    if (column == SC_COLUMN_NAME)
        sc_name_read(field, row->name, &rows->names);
    else if (column == SC_COLUMN_VISIBLE)
        row->hidden = !is_shown(field);
    if (!is_color)
        return;
    if (column == SC_COLUMN_COLOR && read_color(field, color)) {
        memcpy(level, color, (isnan(color[OPACITY]) ? 3 : 4) * sizeof *level);
        rows->alpha = isnan(color[OPACITY]) ? rows->alpha : SC_COLUMN_COLOR;
    } else if (column != SC_COLUMN_COLOR &&
               read_level(rows, field, is_opacity,
                          &level[is_opacity ? OPACITY : column - SC_COLUMN_RED])) {
        rows->alpha = is_opacity ? column : rows->alpha;
    } else {
        count_bad_color(rows, field, line);
    }
}

/* Count what tells the meaning of levels. */
static void weigh_levels(sc_rows *rows, const double level[4])
{
    for (int i = 0; i <= OPACITY; i++) {
        double *most = &rows->most[i == OPACITY];

        *most = level[i] > *most ? level[i] : *most;
    }
    rows->clear += level[OPACITY] == 0;
    rows->opaque += level[OPACITY] == 255;
}

/* @return the field of a column of the kind @p wanted; "" if there is none. */
static const char *field_of(const sc_row *row, sc_column wanted)
{
    for (size_t i = 0; i < row->count; i++) {
        if (row->columns[i] == wanted)
            return row->fields[i];
    }
    return "";
}

/* Name a label that has no name by its terminology, "Kidney, Left", or with its side. */
static void complete_name(sc_rows *rows, const sc_row *row, const char *side, sc_label *label)
{
    const char *meaning = field_of(row, SC_COLUMN_MEANING);
    const char *modifier = field_of(row, SC_COLUMN_MODIFIER);
    char name[2 * SC_NAME_BYTES];

    if (label->name[0] && *side)
        snprintf(name, sizeof name, "%s %s", side, label->name);
    else if (!label->name[0] && *meaning)
        snprintf(name, sizeof name, "%.*s%s%.*s", SC_NAME_BYTES, meaning, *modifier ? ", " : "",
                 SC_NAME_BYTES / 2, modifier);
    else
        return;
    sc_name_read(name, label->name, &rows->names);
}

/* Append the label @p value of a row. @param side "" or on which side it is. */
static void add_label(sc_rows *rows, const sc_row *row, int64_t value, const char *side)
{
    sc_label label = {.value = value, .opacity = -1};
    double level[4] = {NAN, NAN, NAN, NAN};
    const size_t unread = rows->unread;

    if (rows->status != SC_OK)
        return;
    rows->any = true;
    if (value == 0) /* of the background name and colour do not matter */
        return;
    rows->status =
        rows->table->count < SC_TABLE_ROWS_MAX
            ? SC_GROW(rows->ctx, rows->table->count - rows->first, &rows->level_capacity,
                      &rows->levels)
            : sc_fail(rows->ctx, SC_ERR_DATA,
                      "%s: more than %d rows, but a volume has at most %d labels; keep the rows "
                      "of the labels in the volume",
                      rows->path, SC_TABLE_ROWS_MAX, SC_LABELS_MAX - 1);
    if (rows->status != SC_OK)
        return;
    for (size_t i = 0; i < row->count; i++)
        read_field(rows, row->columns[i], row->fields[i], row->line, &label, level);
    rows->unread = rows->unread > unread ? unread + 1 : unread; /* a row counts once */
    complete_name(rows, row, side, &label);
    memcpy(rows->levels[rows->table->count - rows->first], level, sizeof level);
    weigh_levels(rows, level);
    rows->status = sc_label_table_add(rows->ctx, rows->table, &label);
}

void sc_rows_add(sc_rows *rows, const sc_row *row)
{
    const sc_dialect *dialect = rows->dialect;
    int64_t value = 0, right = 0, left = 0;
    const bool has_value = read_value(dialect, field_of(row, SC_COLUMN_VALUE), &value);
    const bool has_right = read_value(dialect, field_of(row, SC_COLUMN_RIGHT), &right);
    const bool has_left = read_value(dialect, field_of(row, SC_COLUMN_LEFT), &left);
    const bool is_middle = has_right && has_left && right == left;

    if (!has_value && !has_right && !has_left)
        sc_rows_skip(rows, row->line);
    if (has_value)
        add_label(rows, row, value, "");
    if (has_right)
        add_label(rows, row, right, is_middle ? "" : "right");
    if (has_left && !is_middle)
        add_label(rows, row, left, "left");
}

/* ---- when all rows are read ---- */

/* Give one label its colour and opacity. @param full the levels of full colour and opacity. */
static void apply_levels(const double level[4], const double full[2], bool transparency,
                         bool is_whole, sc_name_count *mended, sc_label *label)
{
    if (!isnan(level[0]) && !isnan(level[1]) && !isnan(level[2])) {
        for (int i = 0; i < COLOR_LEVELS; i++)
            label->rgb[i] =
                (uint8_t)(sc_level_mend(level[i], full[0], is_whole, mended) / full[0] * 255 + 0.5);
        label->has_color = true;
    }
    if (!isnan(level[OPACITY])) {
        const double read = sc_level_mend(level[OPACITY], full[1], is_whole && full[1] > 1, mended);
        const double opacity = (transparency ? full[1] - read : read) / full[1];

        label->opacity = opacity < 1 ? (float)opacity : -1; /* full opacity counts as not given */
        label->hidden = label->hidden || opacity == 0;
    }
}

/* Find out what the levels mean, and give the labels their colours and opacities. */
static void settle_levels(sc_rows *rows)
{
    const float *known = rows->dialect->full;
    const bool transparency =
        rows->alpha == SC_COLUMN_TRANSPARENCY || (rows->alpha == SC_COLUMN_ALPHA && !known[1] &&
                                                  rows->most[1] != 1 && rows->clear > rows->opaque);
    const bool percent =
        !known[1] && rows->most[1] > 1 && rows->most[1] <= 100 &&
        (rows->alpha == SC_COLUMN_OPACITY || rows->alpha == SC_COLUMN_TRANSPARENCY);
    const double full[2] = {known[0]             ? (double)known[0]
                            : rows->most[0] <= 1 ? 1
                                                 : 255,
                            known[1]             ? (double)known[1]
                            : rows->most[1] <= 1 ? 1
                            : percent            ? 100
                                                 : 255};

    for (size_t i = rows->first; i < rows->table->count; i++)
        apply_levels(rows->levels[i - rows->first], full, transparency, known[0] > 1, &rows->names,
                     &rows->table->rows[i]);
    if (percent)
        sc_info(rows->ctx, "%s: its opacities, up to %g, are read as percent", rows->path,
                rows->most[1]);
    if (transparency && rows->alpha == SC_COLUMN_ALPHA)
        sc_info(rows->ctx,
                "%s: its column of opacities, most of which are 0, holds transparencies, as "
                "FreeSurfer writes them",
                rows->path);
}

/* Warn of what could not be read. */
static void tell_unread(const sc_rows *rows, const char *place)
{
    const sc_dialect *dialect = rows->dialect;
    const bool one = rows->unread == 1;

    sc_name_warn(rows->ctx, rows->path, &rows->names);
    if (rows->bad_colors)
        sc_warn(rows->ctx,
                "%s: %zu colour%s cannot be read, such as \"%s\"; expected for example #ff8000 or "
                "255,128,0",
                rows->path, rows->bad_colors, rows->bad_colors == 1 ? "" : "s", rows->bad_color);
    if (rows->unread)
        sc_warn(rows->ctx, "%s%s: %zu %s %s %s; what cannot be read is not used", rows->path, place,
                rows->unread, dialect->rows[!one], one ? "has" : "have", dialect->lack);
}

sc_status sc_rows_end(sc_rows *rows)
{
    const sc_dialect *dialect = rows->dialect;
    const char *refused = !rows->unread ? dialect->empty : dialect->refused;
    char place[64] = "";
    sc_status status = rows->status;

    if (rows->first_unread)
        snprintf(place, sizeof place, "%s%d%s", dialect->where[0], rows->first_unread,
                 dialect->where[1]);
    if (status == SC_OK) {
        settle_levels(rows);
        if (!rows->any && refused)
            status = sc_fail(rows->ctx, SC_ERR_DATA, "%s%s: %s", rows->path, place, refused);
        else
            tell_unread(rows, place);
    }
    sc_free(rows->levels);
    rows->levels = NULL;
    return status;
}
