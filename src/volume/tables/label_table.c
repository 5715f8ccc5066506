/* SPDX-License-Identifier: BSD-3-Clause */
/* Label tables: which dialect a text has, and what is said of those in lines. The tables of 3D
 * Slicer and FreeSurfer look alike but mean the opposite by their sixth number. */
#include "tables/label_table.h"

#include <stdlib.h>

/* How a text in lines is read. */
typedef struct line_dialect {
    sc_dialect rows;
    sc_row_cut *cut;
} line_dialect;

#define NO_LABELS "has no labels; expected one a line, such as: 1 aorta 255 0 0 255"
#define UNKNOWN                                                                                    \
    "is not a line of any label table that segcast knows; expected a number, a name and perhaps "  \
    "a colour in each line, such as: 1 aorta 255 0 0 255, or a line of headings first, such as: "  \
    "value,name,color"
#define LINES .where = {":", ""}, .rows = {"line", "lines"}
/* A dialect of lines whose levels go to 255, its opacity to @p clear. */
#define DIALECT(title, order, least, clear, last, none, tokens)                                    \
    {                                                                                              \
        {.name = (title),                                                                          \
         .headings = (order),                                                                      \
         .columns_least = (least),                                                                 \
         .full = {255, clear},                                                                     \
         .highest = (last),                                                                        \
         LINES,                                                                                    \
         .lack = "not the form of a " title " label table",                                        \
         .refused = "is not a line of a " title " label table",                                    \
         .empty = (none)},                                                                         \
            tokens                                                                                 \
    }

/* By sc_table_format. Those of XML and JSON, whose rows are no lines, have a name only. */
static const line_dialect dialects[] = {
    [SC_TABLE_AUTO] = {{"",
                        "value name r g b opacity",
                        5,
                        {255, 255},
                        LINES,
                        .refused = UNKNOWN,
                        .empty = NO_LABELS},
                       sc_row_cut_words},
    [SC_TABLE_SLICER] =
        DIALECT("Slicer", "value name r g b opacity", 5, 255, 0, NO_LABELS, sc_row_cut_words),
    [SC_TABLE_FREESURFER] = DIALECT("FreeSurfer", "value name r g b transparency", 5, 255, 0,
                                    NO_LABELS, sc_row_cut_words),
    [SC_TABLE_ITKSNAP] = DIALECT("ITK-SNAP", "value r g b opacity in_slices visible name", 8, 1,
                                 65535, NO_LABELS, sc_row_cut_words),
    [SC_TABLE_XML] = {{.name = "GIFTI, Connectome Workbench, FSL or BrainSuite (XML)"}, NULL},
    [SC_TABLE_DELIMITED] = {{"CSV or TSV", LINES,
                             .lack = "no whole number in the column of the label's number",
                             .refused = "has no whole number in the column of the label's number",
                             .empty = "has headings, but no labels below them"},
                            sc_row_cut_delimited},
    [SC_TABLE_JSON] = {{.name = "JSON"}, NULL},
    [SC_TABLE_NAMES] = DIALECT("number-and-name", NULL, 0, 255, 0, NO_LABELS, sc_row_cut_class),
    [SC_TABLE_WORKBENCH] = DIALECT("Connectome Workbench", "name value r g b opacity", 6, 255, 0,
                                   "has no labels; expected two lines for each, its name and its "
                                   "key with a colour",
                                   sc_row_cut_pair)};

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
static void weigh_line(char *line, evidence *e)
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
    if (strtoll(line, NULL, 10) != 0 && sscanf(line, "%*d %*s %*d %*d %*d %lf", &last) == 1) {
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
    sc_text_reading t = {0};

    if (first == '<')
        return SC_TABLE_XML;
    if (is_python_map(text))
        return SC_TABLE_NAMES;
    if (first == '{' || first == '[')
        return SC_TABLE_JSON;
    if (sc_headings_find(text, &t))
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

/* Cut the columns of the text, or name those of the dialect, and go to the first row. */
static sc_status begin_rows(const sc_ctx *ctx, const char *path, const line_dialect *dialect,
                            char *text, sc_text_reading *t)
{
    SC_OWN(sc_text_clear) sc_text unused = {0};

    t->at = text;
    t->columns_least = dialect->rows.columns_least;
    if (dialect->cut != sc_row_cut_delimited) {
        char headings[64], *at = headings;

        snprintf(headings, sizeof headings, "%s",
                 dialect->rows.headings ? dialect->rows.headings : "");
        for (char *word; (word = strtok_r(at, " ", &at)) != NULL;)
            t->columns[t->column_count++] = sc_column_of(word);
        return SC_OK;
    }
    if (sc_headings_find(text, t)) {
        for (size_t i = 0; i < t->column_count; i++) {
            if (t->columns[i] == SC_COLUMN_OTHER && t->headings[i][0])
                SC_PASS(sc_text_add(ctx, &unused, "%s\"%.40s\"", unused.length_bytes ? ", " : "",
                                    t->headings[i]));
        }
        if (unused.length_bytes)
            sc_info(ctx, "%s: columns that are not used: %s", path, unused.data);
    } else if (!sc_headings_guess(text, t)) {
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: has no line of headings that name a number and a name or a colour; "
                       "expected for example: value,name,color",
                       path);
    }
    return SC_OK;
}

/* Is the next line blank or a comment? */
static bool is_no_row(const sc_text_reading *t, bool has_comments)
{
    const char *first = t->at + strspn(t->at, " \t");

    return !*first || *first == '\r' || *first == '\n' || (has_comments && *first == '#');
}

/* Append the rows of @p text, which is cut into fields, to @p table. Blank lines, comments and
 * label 0 are left out, and lines of another form with one warning. @param format SC_TABLE_AUTO: of
 * no format that is known. @return SC_ERR_DATA if there is no row; SC_ERR_MEMORY. */
static sc_status read_rows(const sc_ctx *ctx, const char *path, sc_table_format format, char *text,
                           sc_label_table *table)
{
    const line_dialect *dialect = &dialects[format];
    sc_text_reading t = {.is_slicer = format <= SC_TABLE_SLICER};
    sc_rows rows = sc_rows_begin(ctx, path, &dialect->rows, table);
    bool has_comments;

    rows.status = begin_rows(ctx, path, dialect, text, &t);
    has_comments = format != SC_TABLE_WORKBENCH && t.columns[0] != SC_COLUMN_COLOR;
    while (t.at && rows.status == SC_OK) {
        if (is_no_row(&t, has_comments)) {
            t.at = sc_delimited_next_line(t.at);
            t.line++;
            continue;
        }
        if (format == SC_TABLE_NAMES && table->count && t.at[strspn(t.at, " \t")] == '}')
            break; /* further lists of a file in Python follow */
        t.row.line = t.line + 1;
        if (dialect->cut(&t))
            sc_rows_add(&rows, &t.row);
        else if (format != SC_TABLE_WORKBENCH)
            sc_rows_skip(&rows, t.row.line);
        else
            rows.status = sc_fail(
                ctx, SC_ERR_DATA,
                "%s:%d: is \"%.80s\", expected the key of the label \"%.80s\" and its red, green, "
                "blue and opacity from 0 to 255, such as: 1 255 0 0 255",
                path, t.row.line + 1, t.row.fields[1], t.row.fields[0]);
    }
    return sc_rows_end(&rows);
}

/* Read a table in XML as read_rows reads others. */
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
    SC_OWN(sc_label_table_clear) sc_label_table table = {0};
    SC_OWN(sc_free_at) char *text = NULL;
    size_t bytes;

    SC_PASS(sc_file_read(ctx, path, SC_TABLE_BYTES_MAX, &text, &bytes));
    SC_PASS(sc_label_text_decode(ctx, path, &text, &bytes));
    if (strstr(text, "# Color procedural file"))
        return sc_fail(ctx, SC_ERR_DATA, "%s: is a procedural colour file, not a label table",
                       path);
    if (format == SC_TABLE_AUTO) {
        format = guess(text);
        if (format != SC_TABLE_AUTO)
            sc_info(ctx, "%s: read as %s %s label table", path,
                    strchr("AEIO", dialects[format].rows.name[0]) ? "an" : "a",
                    dialects[format].rows.name);
    }
    if (format == SC_TABLE_NAMES && is_python_map(text))
        split_python_map(text);
    if (format == SC_TABLE_XML)
        SC_PASS(parse_xml(ctx, path, text, &table));
    else if (format == SC_TABLE_JSON)
        SC_PASS(sc_label_json_parse(ctx, path, text, bytes, &table));
    else
        SC_PASS(read_rows(ctx, path, format, text, &table));
    SC_HAND_OVER(table, out);
    return SC_OK;
}
