/* SPDX-License-Identifier: BSD-3-Clause */
/* Label tables: which format a text has, and those of one label a line: colour tables of 3D Slicer,
 * look-up tables of FreeSurfer, descriptions of ITK-SNAP. The first two look alike but mean the
 * opposite by their sixth number. */
#include "tables/label_table.h"
#include "tables/label_xml.h"

#include <ctype.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* The next word of a line, which blanks or tabs separate, as a string of its own: the text is
 * cut behind it, and *at moves behind that. NULL at the end of the line. */
static char *next_word(char **at)
{
    char *word;

    while (**at == ' ' || **at == '\t')
        (*at)++;
    if (!**at)
        return NULL;
    word = *at;
    while (**at && **at != ' ' && **at != '\t')
        (*at)++;
    if (**at)
        *(*at)++ = '\0';
    return word;
}

/* Read the next word as a finite number into *out. The text is cut and *at moves as in
 * next_word, also if there is no number: false, and *out may have changed. */
static bool next_number(char **at, double *out)
{
    char *word = next_word(at), *end;

    if (!word)
        return false;
    *out = strtod(word, &end);
    return end != word && !*end && isfinite(*out);
}

/* Round a colour level, and clamp it to 0 to 255. */
static uint8_t level(double value, sc_name_count *mended)
{
    return (uint8_t)sc_level_mend(value, 255, true, mended);
}

/* Drop the quotation marks around a name, as 3D Slicer does. */
static void drop_quotes(char *name)
{
    const size_t bytes = strlen(name);

    if (bytes > 2 && name[0] == '\'' && name[bytes - 1] == '\'') {
        memmove(name, name + 1, bytes - 2);
        name[bytes - 2] = '\0';
    }
}

/* Read a row "id name R G B [A]" as the parsers below do. @p transparency: the last number is
 * 255 minus the opacity, and underscores belong to the name; else it is the opacity, and they
 * stand for blanks. Colours and opacity are clamped to 0 to 255. */
static bool parse_named(char *line, bool transparency, sc_label *row, sc_name_count *names)
{
    double id, rgb[3], last;
    char *at = line, *name;

    if (!next_number(&at, &id) || id != floor(id) || fabs(id) > 9e15 || !(name = next_word(&at)) ||
        !next_number(&at, &rgb[0]) || !next_number(&at, &rgb[1]) || !next_number(&at, &rgb[2]))
        return false;
    row->value = (int64_t)id;
    if (!transparency)
        drop_quotes(name);
    sc_name_read(strcmp(name, "_") ? name : "", row->name, names);
    for (char *c = row->name; *c && !transparency; c++)
        *c = *c == '_' ? ' ' : *c;
    for (int i = 0; i < 3; i++)
        row->rgb[i] = level(rgb[i], names);
    row->has_color = true;
    if (next_number(&at, &last)) {
        const int read = level(last, names);
        const double opacity = (transparency ? 255 - read : read) / 255.0;

        /* Tables without opacities have 255 in all rows, so that full opacity counts as not given.
         */
        row->opacity = opacity < 1 ? (float)opacity : -1;
        row->hidden = opacity == 0;
    }
    return true;
}

/* The parsers of the formats: read one line, which is cut into words, into @p row, whose
 * opacity is -1 and all else zero. They set value, name, rgb and has_color, opacity if it is
 * given and below 1, and hidden. @p names counts names that were mended. @return false if the line
 * has not this form; @p row may have changed then. */
static bool parse_slicer(char *line, sc_label *row, sc_name_count *names)
{
    return parse_named(line, false, row, names);
}

static bool parse_freesurfer(char *line, sc_label *row, sc_name_count *names)
{
    return parse_named(line, true, row, names);
}

/* Remove the backslashes before quotation marks, in place. */
static void unescape_quotes(char *text)
{
    char *to = text;

    for (; *text; text++) {
        if (text[0] != '\\' || text[1] != '"')
            *to++ = *text;
    }
    *to = '\0';
}

/* A row: id R G B A VIS MSH "name", with an id from 0 to 65535. A is the opacity from 0 to 1;
 * MSH says whether the label is shown in 3D; VIS, whether it is shown in slices, is not used. */
static bool parse_itksnap(char *line, sc_label *row, sc_name_count *names)
{
    double number[7];
    char *at = line, *quote, *end;

    for (int i = 0; i < 7; i++) {
        if (!next_number(&at, &number[i]))
            return false;
    }
    quote = strchr(at, '"');
    end = quote ? strrchr(quote + 1, '"') : NULL; /* quotation marks within a name stay */
    if (!end || number[0] != floor(number[0]) || number[0] < 0 || number[0] > 65535)
        return false;
    *end = '\0';
    unescape_quotes(quote + 1);
    row->value = (int64_t)number[0];
    sc_name_read(quote + 1, row->name, names);
    for (int i = 0; i < 3; i++)
        row->rgb[i] = level(number[i + 1], names);
    row->has_color = true;
    number[4] = sc_level_mend(number[4], 1, false, names);
    row->opacity = number[4] < 1 ? (float)number[4] : -1;
    row->hidden = number[6] == 0;
    return true;
}

/* Read a line, cut off, into @p row. @return false if it has another form. */
typedef bool parse_fn(char *line, sc_label *row, sc_name_count *names);

/* By sc_table_format: the name for messages, and the parser of lines, where a label is a line. */
static const struct {
    const char *name;
    parse_fn *parse;
} formats[] = {[SC_TABLE_AUTO] = {"", NULL},
               [SC_TABLE_SLICER] = {"Slicer", parse_slicer},
               [SC_TABLE_FREESURFER] = {"FreeSurfer", parse_freesurfer},
               [SC_TABLE_ITKSNAP] = {"ITK-SNAP", parse_itksnap},
               [SC_TABLE_XML] = {"GIFTI, Connectome Workbench or FSL (XML)", NULL},
               [SC_TABLE_DELIMITED] = {"CSV or TSV", NULL},
               [SC_TABLE_JSON] = {"JSON", NULL},
               [SC_TABLE_NAMES] = {"number-and-name", sc_class_parse},
               [SC_TABLE_WORKBENCH] = {"Connectome Workbench", NULL}};

static bool is_blank_or_comment(const char *line)
{
    while (isspace((unsigned char)*line))
        line++;
    return !*line || *line == '#';
}

/* Is the line seven numbers and a name in quotes? */
static bool looks_like_itksnap(const char *line)
{
    int end = -1;

    (void)sscanf(line, "%*d %*d %*d %*d %*f %*d %*d %n", &end);
    return end > 0 && line[end] == '"';
}

/* What the lines read so far say about the format of a table. */
typedef struct evidence {
    bool itksnap;                /* a line has the form of ITK-SNAP */
    bool freesurfer, slicer;     /* a comment is the one with which they begin their tables */
    size_t sixth;                /* rows with a sixth number */
    size_t opaque_255, opaque_0; /* those in which it is 255, or 0 */
    size_t colored;              /* rows of a number, a word and three numbers */
    size_t classes;              /* other rows that begin with a number, as those of class lists */
    size_t columned;             /* those of them with more than a number, a name and a colour */
    size_t spaced;               /* those of them with a colour behind a name of several words */
} evidence;

/* Add what one line, cut off, says. */
static void weigh_line(const char *line, evidence *e)
{
    double last = 0;
    bool more_fields, has_color;
    int end = -1;

    (void)sscanf(line, "%*d %*s %*f %*f %*f%n", &end);
    if (end > 0) {
        e->colored++;
    } else if (sc_class_is(line, &has_color, &more_fields)) {
        e->classes++;
        e->columned += more_fields;
        e->spaced += has_color;
    }
    e->itksnap = e->itksnap || strstr(line, "ITK-SnAP") || strstr(line, "ITK-SNAP") ||
                 looks_like_itksnap(line);
    e->freesurfer = e->freesurfer || strstr(line, "Label Name:");
    e->slicer = e->slicer || strstr(line, "Color table file");
    if (!is_blank_or_comment(line) && strtoll(line, NULL, 10) != 0 &&
        sscanf(line, "%*d %*s %*d %*d %*d %lf", &last) == 1) {
        e->sixth++;
        e->opaque_255 += last == 255;
        e->opaque_0 += last == 0;
    }
}

/* Is the text a map of Python, in which numbers stand without quotes, as in {1: 'spleen', ...}? */
static bool is_python_map(const char *text)
{
    text += strspn(text, " \t\r\n");
    if (*text != '{')
        return false;
    text += 1 + strspn(text + 1, " \t\r\n");
    return *text >= '0' && *text <= '9';
}

/* Give each entry of a map of Python a line of its own. */
static void split_python_map(char *text)
{
    char quote = '\0';

    for (; *text; text++) {
        if (quote)
            quote = *text == quote ? '\0' : quote;
        else if (*text == '"' || *text == '\'')
            quote = *text;
        else if (*text == ',' || *text == '{' || *text == '}')
            *text = '\n';
    }
}

/* @return the format of the table @p text, SC_TABLE_AUTO if no line looks like one of a table; the
 * text is cut into lines during the call and whole again after it. XML begins with an element or
 * its declaration, JSON with a bracket (of Python, if a number follows without quotes), and CSV
 * with a line of headings that name a number and a name or a colour; Connectome Workbench writes
 * two lines for a label. ITK-SNAP is known by its header or by names in quotes. The tables of
 * Slicer and FreeSurfer look alike. They are told by the comments that both programs write, unless
 * every label would be invisible then; else by this: most labels are opaque, which is 255 in the
 * one and 0 in the other. If neither is more frequent, Slicer is taken. */
static sc_table_format guess(char *text)
{
    evidence e = {0};
    const char first = text[strspn(text, " \t\r\n")];
    char delimiter;

    if (first == '<')
        return SC_TABLE_XML;
    if (is_python_map(text))
        return SC_TABLE_NAMES;
    if (first == '{' || first == '[')
        return SC_TABLE_JSON;
    if (sc_label_delimited_is(text, &delimiter))
        return SC_TABLE_DELIMITED;
    if (sc_label_workbench_is(text))
        return SC_TABLE_WORKBENCH;
    for (char *line = text; line && !e.itksnap;) {
        char *end = line + strcspn(line, "\r\n");
        const char ending = *end;
        char *next = sc_label_cut_line(line);

        weigh_line(line, &e);
        *end = ending;
        line = next;
    }
    if (e.itksnap)
        return SC_TABLE_ITKSNAP;
    if (!e.colored && !e.classes && !e.freesurfer && !e.slicer)
        return SC_TABLE_AUTO;
    /* Names of several words are read by that parser only; it does not know transparency. */
    if (10 * e.spaced > e.colored && e.opaque_0 <= e.opaque_255)
        return SC_TABLE_NAMES;
    if (e.classes && !e.colored) /* further fields mean nothing without headings */
        return e.columned == e.classes ? SC_TABLE_DELIMITED : SC_TABLE_NAMES;
    if (e.freesurfer && e.opaque_255 < e.sixth)
        return SC_TABLE_FREESURFER;
    if (e.slicer && e.opaque_0 < e.sixth)
        return SC_TABLE_SLICER;
    return e.opaque_0 > e.opaque_255 ? SC_TABLE_FREESURFER : SC_TABLE_SLICER;
}

/* Append the rows of @p text, which is cut into lines and words, to @p table. Blank lines,
 * comments and label 0 are left out. Lines of another form are left out with one warning;
 * SC_ERR_DATA with the first of them if there is no row but that of label 0, and for a text without
 * any row. @param format SC_TABLE_AUTO: of no format that is known. @return also SC_ERR_MEMORY. */
static sc_status parse_lines(const sc_ctx *ctx, const char *path, sc_table_format format,
                             char *text, sc_label_table *table)
{
    parse_fn *parse = formats[format].parse ? formats[format].parse : parse_slicer;
    int number = 0, skipped = 0, first_skipped = 0;
    bool has_rows = false;
    sc_name_count names = {0};
    sc_status status = SC_OK;

    for (char *line = text, *next; status == SC_OK && line; line = next) {
        sc_label row = {.opacity = -1};

        number++;
        next = sc_label_cut_line(line);
        if (format == SC_TABLE_NAMES && table->count && line[strspn(line, " \t")] == '}')
            break; /* further lists of a file in Python follow */
        if (is_blank_or_comment(line))
            continue;
        if (!parse(line, &row, &names)) {
            first_skipped = skipped++ ? first_skipped : number;
            continue;
        }
        has_rows = true;
        if (row.value == 0) /* background is never shown: its name and colour do not matter */
            continue;
        if (table->count == SC_TABLE_ROWS_MAX)
            return sc_fail(ctx, SC_ERR_DATA,
                           "%s:%d: more than %d rows, but a volume has at most %d labels; keep the "
                           "rows of the labels in the volume",
                           path, number, SC_TABLE_ROWS_MAX, SC_LABELS_MAX - 1);
        status = sc_label_table_add(ctx, table, &row);
    }
    if (status == SC_OK)
        sc_name_warn(ctx, path, &names);
    if (status == SC_OK && skipped && table->count == 0)
        return format == SC_TABLE_AUTO
                   ? sc_fail(ctx, SC_ERR_DATA,
                             "%s:%d: is not a line of any label table that segcast knows; "
                             "expected a number, a name and perhaps a colour in each line, "
                             "such as: 1 aorta 255 0 0 255, or a line of headings first, such "
                             "as: value,name,color",
                             path, first_skipped)
                   : sc_fail(ctx, SC_ERR_DATA, "%s:%d: is not a line of a %s label table", path,
                             first_skipped, formats[format].name);
    if (status == SC_OK && !has_rows)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: has no labels; expected one a line, such as: 1 aorta 255 0 0 255",
                       path);
    if (status == SC_OK && skipped)
        sc_warn(ctx, "%s:%d: %d line%s not of the form of a %s label table and not used", path,
                first_skipped, skipped, skipped == 1 ? " is" : "s are", formats[format].name);
    return status;
}

/* Read a table in XML as parse_lines reads others. */
static sc_status parse_xml(const sc_ctx *ctx, const char *path, const char *text,
                           sc_label_table *table)
{
    const char *begin = text + strspn(text, " \t\r\n"); /* before which XML allows no blanks */
    char why[SC_XML_WHY_BYTES];
    const sc_status status = sc_label_xml_parse(ctx, path, begin, strlen(begin), table, why);

    return status == SC_ERR_DATA
               ? sc_fail(ctx, status, "%s: is not a label table in XML: %s", path, why)
               : status;
}

sc_status sc_label_table_read(const sc_ctx *ctx, const char *path, sc_table_format format,
                              sc_label_table *out)
{
    sc_label_table table = {0};
    char *text = NULL;
    size_t bytes;
    sc_status status;

    SC_TRY(sc_file_read(ctx, path, SC_TABLE_BYTES_MAX, &text, &bytes));
    SC_TRY(sc_label_text_decode(ctx, path, &text, &bytes));
    if (strstr(text, "# Color procedural file")) {
        status =
            sc_fail(ctx, SC_ERR_DATA, "%s: is a procedural colour file, not a label table", path);
        goto out;
    }
    if (format == SC_TABLE_AUTO) {
        format = guess(text);
        if (format != SC_TABLE_AUTO)
            sc_info(ctx, "%s: read as %s %s label table", path,
                    strchr("AEIO", formats[format].name[0]) ? "an" : "a", formats[format].name);
    }
    if (format == SC_TABLE_NAMES && is_python_map(text))
        split_python_map(text);
    if (format == SC_TABLE_XML)
        SC_TRY(parse_xml(ctx, path, text, &table));
    else if (format == SC_TABLE_DELIMITED)
        SC_TRY(sc_label_delimited_parse(ctx, path, text, &table));
    else if (format == SC_TABLE_JSON)
        SC_TRY(sc_label_json_parse(ctx, path, text, bytes, &table));
    else if (format == SC_TABLE_WORKBENCH)
        SC_TRY(sc_label_workbench_parse(ctx, path, text, &table));
    else
        SC_TRY(parse_lines(ctx, path, format, text, &table));
    *out = table;
    table = (sc_label_table){0};
out:
    sc_label_table_clear(&table);
    sc_free(text);
    return status;
}
