/* SPDX-License-Identifier: BSD-3-Clause */
/* Label tables whose columns have headings: what the headings mean, and rows of fields. */
#include "segcast/image.h"
#include "tables/label_table.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum {
    COLOR_LEVELS = 3,
    OPACITY = 3,      /* index of the opacity among the levels of a row */
    NUMBER_BYTES = 64 /* room for a number as text */
};

/* Headings, without case, blanks and punctuation, that programs write: BIDS (index, name,
 * abbreviation, color), 3D Slicer (LabelValue, Name, Color_R), FastSurfer (ID, LabelName, R, G, B,
 * A), NiiVue (I, labels, R, G, B, A), OME-Zarr (label-value, rgba), the Allen Institute (id, name,
 * acronym, color_hex_triplet), and what people write by hand. */
static const struct {
    const char *heading;
    sc_column column;
} headings[] = {{"labelvalue", SC_COLUMN_VALUE},
                {"value", SC_COLUMN_VALUE},
                {"index", SC_COLUMN_VALUE},
                {"idx", SC_COLUMN_VALUE},
                {"i", SC_COLUMN_VALUE},
                {"id", SC_COLUMN_VALUE},
                {"labelid", SC_COLUMN_VALUE},
                {"labelindex", SC_COLUMN_VALUE},
                {"labelnumber", SC_COLUMN_VALUE},
                {"segmentid", SC_COLUMN_VALUE},
                {"segid", SC_COLUMN_VALUE},
                {"structureid", SC_COLUMN_VALUE},
                {"regionid", SC_COLUMN_VALUE},
                {"key", SC_COLUMN_VALUE},
                {"no", SC_COLUMN_VALUE},
                {"number", SC_COLUMN_VALUE},
                {"num", SC_COLUMN_VALUE},
                {"nr", SC_COLUMN_VALUE},
                {"voxelvalue", SC_COLUMN_VALUE},
                {"pixelvalue", SC_COLUMN_VALUE},
                {"greyvalue", SC_COLUMN_VALUE},
                {"grayvalue", SC_COLUMN_VALUE},
                {"maskvalue", SC_COLUMN_VALUE},
                {"name", SC_COLUMN_NAME},
                {"labelname", SC_COLUMN_NAME},
                {"segmentname", SC_COLUMN_NAME},
                {"segmentlabel", SC_COLUMN_NAME},
                {"structurename", SC_COLUMN_NAME},
                {"structname", SC_COLUMN_NAME},
                {"regionname", SC_COLUMN_NAME},
                {"structure", SC_COLUMN_NAME},
                {"region", SC_COLUMN_NAME},
                {"tissue", SC_COLUMN_NAME},
                {"organ", SC_COLUMN_NAME},
                {"label", SC_COLUMN_LABEL},
                {"labels", SC_COLUMN_LABEL},
                {"roi", SC_COLUMN_LABEL},
                {"segment", SC_COLUMN_LABEL},
                {"abbreviation", SC_COLUMN_SHORT},
                {"acronym", SC_COLUMN_SHORT},
                {"description", SC_COLUMN_SHORT},
                {"segmentdescription", SC_COLUMN_SHORT},
                {"anatomy", SC_COLUMN_SHORT},
                {"title", SC_COLUMN_SHORT},
                {"term", SC_COLUMN_SHORT},
                {"material", SC_COLUMN_SHORT},
                {"class", SC_COLUMN_SHORT},
                {"color", SC_COLUMN_COLOR},
                {"rgb", SC_COLUMN_COLOR},
                {"rgba", SC_COLUMN_COLOR},
                {"hex", SC_COLUMN_COLOR},
                {"html", SC_COLUMN_COLOR},
                {"hexcode", SC_COLUMN_COLOR},
                {"hextriplet", SC_COLUMN_COLOR},
                {"rgbtriplet", SC_COLUMN_COLOR},
                {"rgbvalue", SC_COLUMN_COLOR},
                {"recommendeddisplayrgbvalue", SC_COLUMN_COLOR},
                {"colorhextriplet", SC_COLUMN_COLOR},
                {"r", SC_COLUMN_RED},
                {"red", SC_COLUMN_RED},
                {"colorr", SC_COLUMN_RED},
                {"g", SC_COLUMN_GREEN},
                {"green", SC_COLUMN_GREEN},
                {"colorg", SC_COLUMN_GREEN},
                {"b", SC_COLUMN_BLUE},
                {"blue", SC_COLUMN_BLUE},
                {"colorb", SC_COLUMN_BLUE},
                {"a", SC_COLUMN_ALPHA},
                {"alpha", SC_COLUMN_ALPHA},
                {"colora", SC_COLUMN_ALPHA},
                {"opacity", SC_COLUMN_OPACITY},
                {"opacity3d", SC_COLUMN_OPACITY},
                {"transparency", SC_COLUMN_TRANSPARENCY},
                {"visible", SC_COLUMN_VISIBLE},
                {"visibility", SC_COLUMN_VISIBLE},
                {"show", SC_COLUMN_VISIBLE},
                {"typecodemeaning", SC_COLUMN_MEANING},
                {"typemodifiercodemeaning", SC_COLUMN_MODIFIER}};

/* Words before which headings put what the label is of: "segment_name", "ROI number". */
static const char *const things[] = {
    "label",  "segment", "region", "roi",  "structure", "anatomical", "class",    "tissue", "organ",
    "parcel", "atlas",   "brain",  "full", "long",      "display",    "material", "object", "area"};
/* What stands behind them. */
static const struct {
    const char *ending;
    sc_column column;
} endings[] = {
    {"value", SC_COLUMN_VALUE},   {"id", SC_COLUMN_VALUE},     {"index", SC_COLUMN_VALUE},
    {"idx", SC_COLUMN_VALUE},     {"number", SC_COLUMN_VALUE}, {"num", SC_COLUMN_VALUE},
    {"no", SC_COLUMN_VALUE},      {"nr", SC_COLUMN_VALUE},     {"name", SC_COLUMN_NAME},
    {"text", SC_COLUMN_NAME},     {"title", SC_COLUMN_NAME},   {"region", SC_COLUMN_NAME},
    {"structure", SC_COLUMN_NAME}};
/* Headings of columns with whole colours consist of "color" and one of these words. */
static const char *const color_words[] = {"label", "segment", "display", "html",  "web",
                                          "rgb",   "rgba",    "hex",     "value", "code"};

/* @return what a heading of two words holds: "roi" and "name", "color" and "red". */
static sc_column column_of_two(const char *letters)
{
    const char *color = strstr(letters, "color");
    char rest[32];

    for (size_t i = 0; i < SC_COUNT_OF(things); i++) {
        const size_t bytes = strlen(things[i]);

        for (size_t k = 0; k < SC_COUNT_OF(endings); k++) {
            if (!strncmp(letters, things[i], bytes) && !strcmp(letters + bytes, endings[k].ending))
                return endings[k].column;
        }
    }
    if (!color)
        return SC_COLUMN_OTHER;
    snprintf(rest, sizeof rest, "%.*s%s", (int)(color - letters), letters, color + strlen("color"));
    for (size_t i = 0; i < SC_COUNT_OF(color_words); i++) {
        if (!strcmp(rest, color_words[i]))
            return SC_COLUMN_COLOR;
    }
    for (size_t i = 0; i < SC_COUNT_OF(headings); i++) {
        if (headings[i].column >= SC_COLUMN_RED && headings[i].column <= SC_COLUMN_ALPHA &&
            !strcmp(rest, headings[i].heading))
            return headings[i].column;
    }
    return SC_COLUMN_OTHER;
}

static char lower(char c)
{
    return c >= 'A' && c <= 'Z' ? (char)(c - 'A' + 'a') : c;
}

/* Copy the letters and digits of a heading to letters[bytes], in lower case, without what stands in
 * brackets, a unit or a range as in "R (0-255)". @return false if there are too many. */
static bool copy_letters(const char *heading, char *letters, size_t bytes)
{
    size_t count = 0;

    for (; *heading && count < bytes - 1; heading++) {
        if ((*heading == '(' || *heading == '[') && count)
            heading += strcspn(heading, ")]");
        if (!*heading)
            break;
        if (isalnum((unsigned char)*heading))
            letters[count++] = lower(*heading);
    }
    letters[count] = '\0';
    return !*heading;
}

sc_column sc_column_of(const char *heading)
{
    char letters[32];
    char *british;

    if (!copy_letters(heading, letters, sizeof letters)) /* longer than any that is known */
        return SC_COLUMN_OTHER;
    british = strstr(letters, "colour");
    if (british)
        memmove(british + 4, british + 5, strlen(british + 5) + 1);
    for (size_t i = 0; i < SC_COUNT_OF(headings); i++) {
        if (!strcmp(letters, headings[i].heading))
            return headings[i].column;
    }
    return column_of_two(letters);
}

static bool has_column(const sc_column *columns, size_t count, sc_column wanted)
{
    for (size_t i = 0; i < count; i++) {
        if (columns[i] == wanted)
            return true;
    }
    return false;
}

/* Let columns of the kind @p from be of the kind @p to if there is none yet, else of no use. */
static void settle(sc_column *columns, size_t count, sc_column from, sc_column to)
{
    const sc_column now = has_column(columns, count, to) ? SC_COLUMN_OTHER : to;

    for (size_t i = 0; i < count; i++) {
        if (columns[i] == from)
            columns[i] = now;
    }
}

bool sc_columns_settle(sc_column *columns, size_t count)
{
    const bool named =
        has_column(columns, count, SC_COLUMN_NAME) || has_column(columns, count, SC_COLUMN_SHORT);

    settle(columns, count, SC_COLUMN_LABEL,
           named && !has_column(columns, count, SC_COLUMN_VALUE) ? SC_COLUMN_VALUE
                                                                 : SC_COLUMN_NAME);
    settle(columns, count, SC_COLUMN_SHORT, SC_COLUMN_NAME);
    for (size_t i = 0; i < count; i++) {
        if (columns[i] != SC_COLUMN_OTHER && has_column(columns, i, columns[i]))
            columns[i] = SC_COLUMN_OTHER;
    }
    return has_column(columns, count, SC_COLUMN_VALUE) &&
           (has_column(columns, count, SC_COLUMN_NAME) ||
            has_column(columns, count, SC_COLUMN_MEANING) ||
            has_column(columns, count, SC_COLUMN_COLOR) ||
            has_column(columns, count, SC_COLUMN_RED));
}

/* ---- fields ---- */

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
    end += strspn(end, " ");
    if (*end == '%') {
        *out /= 100;
        end += 1 + strspn(end + 1, " ");
    }
    return !*end && isfinite(*out);
}

/* Read a label's number. */
static bool read_value(const char *text, int64_t *out)
{
    double number;

    if (strpbrk(text, ",%") || !read_number(text, &number) || number != floor(number) ||
        fabs(number) > 9e15)
        return false;
    *out = (int64_t)number;
    return true;
}

bool sc_hexadecimal_read(const char *text, float level[4])
{
    const size_t digits = strlen(text), each = digits == 3 ? 1 : 2;

    if ((digits != 3 && digits != 6 && digits != 8) ||
        strspn(text, "0123456789abcdefABCDEF") != digits)
        return false;
    for (size_t i = 0; i < digits / each; i++) {
        const char digit[3] = {text[each * i], each == 2 ? text[each * i + 1] : '\0'};

        level[i] = (float)strtol(digit, NULL, 16) * (each == 1 ? 17.0F : 1.0F);
    }
    return true;
}

/* Read three or four numbers, between which blanks, commas or semicolons stand, and around which
 * brackets and "rgb" may. The fourth of rgba(...) goes from 0 to 1, as in CSS. */
static bool read_levels(const char *text, float level[4])
{
    const bool is_css = !strncasecmp(text, "rgb", 3);
    int count = 0;

    text += is_css ? 3 + (text[3] == 'a' || text[3] == 'A') : 0;
    text += strspn(text, "([ ");
    while (count < 4 && *text && !strchr(")]", *text)) {
        char *end;

        level[count] = strtof(text, &end);
        if (end == text || !isfinite(level[count]))
            return false;
        count++;
        text = end + strspn(end, " ,;");
    }
    if (is_css && count == 4)
        level[OPACITY] *= 255;
    return count >= COLOR_LEVELS && !text[strspn(text, ")] ")];
}

/* Read the text of a whole colour: its name in CSS, digits, or levels. @return whether it is one.
 */
static bool read_color(const char *text, float level[4])
{
    uint8_t rgb[3];
    char plain[SC_COLOR_NAME_BYTES];

    text += strspn(text, " ");
    if (sc_color_by_name(text, plain, rgb)) {
        for (int c = 0; c < COLOR_LEVELS; c++)
            level[c] = rgb[c];
        level[OPACITY] = NAN;
        return true;
    }
    return (*text == '#' && sc_hexadecimal_read(text + 1, level)) ||
           sc_hexadecimal_read(text, level) || read_levels(text, level);
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

sc_column_rows sc_column_rows_begin(sc_label_table *table)
{
    return (sc_column_rows){.table = table, .first = table->count};
}

/* Give room to the levels of one row more. */
static sc_status reserve_levels(const sc_ctx *ctx, sc_column_rows *rows, size_t count)
{
    const size_t capacity = rows->level_capacity ? 2 * rows->level_capacity : 64;
    sc_status status;
    void *levels;

    if (count < rows->level_capacity)
        return SC_OK;
    status = sc_alloc(ctx, capacity, sizeof *rows->levels, &levels);
    if (status != SC_OK)
        return status;
    if (count)
        memcpy(levels, rows->levels, count * sizeof *rows->levels);
    sc_free(rows->levels);
    rows->levels = levels;
    rows->level_capacity = capacity;
    return SC_OK;
}

/* Count a colour, or a level of one, that cannot be read. */
static void count_bad_color(sc_column_rows *rows, const char *field)
{
    if (rows->bad_colors++ == 0)
        (void)sc_copy_name(field, rows->bad_color, sizeof rows->bad_color);
}

/* Read one field of a row that is no number of a label. */
static void read_field(sc_column_rows *rows, sc_column column, const char *field, sc_label *row,
                       float level[4])
{
    double number;

    if (!*field)
        return;
    if (column == SC_COLUMN_NAME) {
        sc_name_read(strcasecmp(field, "n/a") ? field : "", row->name, &rows->names);
    } else if (column == SC_COLUMN_VISIBLE) {
        row->hidden = !is_shown(field);
    } else if (column == SC_COLUMN_COLOR && strcasecmp(field, "n/a")) {
        float color[4] = {NAN, NAN, NAN, NAN};

        if (read_color(field, color)) {
            memcpy(level, color, (isnan(color[OPACITY]) ? 3 : 4) * sizeof *level);
            rows->alpha = isnan(color[OPACITY]) ? rows->alpha : SC_COLUMN_COLOR;
        } else {
            count_bad_color(rows, field);
        }
    } else if (column >= SC_COLUMN_RED && column <= SC_COLUMN_TRANSPARENCY &&
               strcasecmp(field, "n/a")) {
        if (!read_number(field, &number)) {
            count_bad_color(rows, field);
            return;
        }
        level[column <= SC_COLUMN_BLUE ? column - SC_COLUMN_RED : OPACITY] = (float)number;
        rows->alpha = column >= SC_COLUMN_ALPHA ? column : rows->alpha;
    }
}

/* Count what tells the meaning of levels. */
static void weigh_levels(sc_column_rows *rows, const float level[4])
{
    for (int i = 0; i < COLOR_LEVELS; i++)
        rows->most[0] = level[i] > rows->most[0] ? level[i] : rows->most[0];
    rows->most[1] = level[OPACITY] > rows->most[1] ? level[OPACITY] : rows->most[1];
    rows->clear += level[OPACITY] == 0;
    rows->full += level[OPACITY] == 255;
}

/* @return the field of a column of the kind @p wanted; "" if there is none. */
static const char *field_of(const sc_column *columns, const char *const *fields, size_t count,
                            sc_column wanted)
{
    for (size_t i = 0; i < count; i++) {
        if (columns[i] == wanted)
            return fields[i];
    }
    return "";
}

/* Name a row that has no name by its terminology: "Kidney, Left". */
static void name_by_meaning(sc_column_rows *rows, const sc_column *columns,
                            const char *const *fields, size_t count, sc_label *row)
{
    const char *meaning = field_of(columns, fields, count, SC_COLUMN_MEANING);
    const char *modifier = field_of(columns, fields, count, SC_COLUMN_MODIFIER);
    char name[2 * SC_NAME_BYTES];

    if (row->name[0] || !*meaning)
        return;
    snprintf(name, sizeof name, "%.*s%s%.*s", SC_NAME_BYTES, meaning, *modifier ? ", " : "",
             SC_NAME_BYTES / 2, modifier);
    sc_name_read(name, row->name, &rows->names);
}

sc_status sc_column_rows_add(const sc_ctx *ctx, sc_column_rows *rows, const sc_column *columns,
                             const char *const *fields, size_t count, bool *read)
{
    const size_t place = rows->table->count - rows->first;
    sc_label row = {.opacity = -1};
    float level[4] = {NAN, NAN, NAN, NAN};
    sc_status status;

    *read = false;
    for (size_t i = 0; i < count; i++) {
        if (columns[i] == SC_COLUMN_VALUE)
            *read = read_value(fields[i], &row.value);
    }
    if (!*read || row.value == 0) /* of the background name and colour do not matter */
        return SC_OK;
    if (rows->table->count == SC_TABLE_ROWS_MAX)
        return SC_ERR_DATA;
    status = reserve_levels(ctx, rows, place);
    if (status != SC_OK)
        return status;
    for (size_t i = 0; i < count; i++)
        read_field(rows, columns[i], fields[i], &row, level);
    name_by_meaning(rows, columns, fields, count, &row);
    status = sc_label_table_add(ctx, rows->table, &row);
    if (status != SC_OK)
        return status;
    memcpy(rows->levels[place], level, sizeof level);
    weigh_levels(rows, level);
    return SC_OK;
}

/* @return a level as a share of @p full, clamped to 0 to 1. */
static float share_of(float level, float full, sc_name_count *mended)
{
    return (float)sc_level_mend((double)level, (double)full, false, mended) / full;
}

/* Give one row its colour and opacity. @param full the levels of full colour and opacity. */
static void apply_levels(const float level[4], const float full[2], bool transparency,
                         sc_name_count *mended, sc_label *row)
{
    if (!isnan(level[0]) && !isnan(level[1]) && !isnan(level[2])) {
        for (int i = 0; i < COLOR_LEVELS; i++)
            row->rgb[i] = (uint8_t)(share_of(level[i], full[0], mended) * 255 + 0.5F);
        row->has_color = true;
    }
    if (!isnan(level[OPACITY])) {
        const float share = share_of(level[OPACITY], full[1], mended);
        const float opacity = transparency ? 1 - share : share;

        row->opacity = opacity < 1 ? opacity : -1; /* full opacity counts as not given */
        row->hidden = row->hidden || opacity == 0;
    }
}

void sc_column_rows_end(const sc_ctx *ctx, const char *path, sc_column_rows *rows)
{
    const bool transparency =
        rows->alpha == SC_COLUMN_TRANSPARENCY ||
        (rows->alpha == SC_COLUMN_ALPHA && rows->most[1] != 1 && rows->clear > rows->full);

    const bool percent =
        (rows->alpha == SC_COLUMN_OPACITY || rows->alpha == SC_COLUMN_TRANSPARENCY) &&
        rows->most[1] <= 100;
    const float full[2] = {rows->most[0] <= 1 ? 1 : 255, rows->most[1] <= 1 ? 1
                                                         : percent          ? 100
                                                                            : 255};

    for (size_t i = rows->first; i < rows->table->count && i - rows->first < rows->level_capacity;
         i++)
        apply_levels(rows->levels[i - rows->first], full, transparency, &rows->names,
                     &rows->table->rows[i]);
    sc_name_warn(ctx, path, &rows->names);
    if (rows->bad_colors)
        sc_warn(ctx,
                "%s: %zu colour%s cannot be read, such as \"%s\"; expected for example #ff8000 or "
                "255,128,0",
                path, rows->bad_colors, rows->bad_colors == 1 ? "" : "s", rows->bad_color);
    if (percent && rows->most[1] > 1)
        sc_info(ctx, "%s: its opacities, up to %g, are read as percent", path,
                (double)rows->most[1]);
    if (transparency && rows->alpha == SC_COLUMN_ALPHA)
        sc_info(ctx,
                "%s: its column of opacities, most of which are 0, holds transparencies, as "
                "FreeSurfer writes them",
                path);
    sc_free(rows->levels);
    *rows = (sc_column_rows){0};
}
