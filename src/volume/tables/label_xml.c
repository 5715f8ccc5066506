/* SPDX-License-Identifier: BSD-3-Clause */
/* Label tables in XML, read with Expat. Without Expat, which is optional, they are refused with a
 * reason, and all else works. */
#include "tables/label_table.h"

#include <stdlib.h>
#include <strings.h>

#if SC_HAVE_EXPAT

#include <expat.h>

/* Tables, by the elements in which their labels stand, and what stands around those. */
static const struct {
    const char *table, *around;
    sc_dialect dialect;
} tables[] = {
#define PLACE .where = {": line ", " of its XML"}, .rows = {"label", "labels"}
    {"LabelTable",
     NULL,
     {.full = {1, 1},
      .is_strict = true,
      PLACE,
      .lack = "no whole number as Key, or no levels from 0 to 1 as Red, Green, Blue and Alpha"}},
    {"data", "atlas", {PLACE, .lack = "no whole number as index"}},
    {"labelset", NULL, {PLACE, .lack = "no whole number as id, or a colour that is none"}},
#undef PLACE
};

/* The document while Expat reads it. */
typedef struct xml_reading {
    XML_Parser parser;
    sc_rows rows;
    sc_row row;                /* of the label that is open */
    char name[SC_FIELD_BYTES]; /* the text of that label itself */
    char type[SC_FIELD_BYTES]; /* of an atlas */
    char *text;                /* where text goes, of SC_FIELD_BYTES; NULL: nowhere */
    const char *table;         /* the element of the table; only the first is read */
    bool is_atlas;             /* of FSL */
    bool in_table, in_label;   /* within the table, and within a label of it */
    int depth;                 /* elements open within the label */
    const char *refused;       /* why the handlers have stopped the parser; NULL: rows.status */
} xml_reading;

/* Stop the parser. @p refused: the reason for SC_ERR_DATA. */
static void stop(xml_reading *r, sc_status status, const char *refused)
{
    r->rows.status = status;
    r->refused = refused;
    XML_StopParser(r->parser, XML_FALSE);
}

/* Begin a label, with its attributes as fields (name, value, ..., NULL). */
static void begin_label(xml_reading *r, const char **attributes)
{
    r->in_label = true;
    r->row.count = 0;
    r->row.line = (int)XML_GetCurrentLineNumber(r->parser);
    for (; attributes[0]; attributes += 2) {
        char *text = sc_row_add(&r->row, sc_column_of(attributes[0]), NULL);

        if (text)
            snprintf(text, SC_FIELD_BYTES, "%s", attributes[1]);
    }
    r->text = r->name;
    r->text[0] = '\0';
}

/* An atlas of FSL whose type is not "Label" holds probabilities. Its labels count these images from
 * 0; in the image of the most probable labels 0 is background, and each label is 1 more (FSL,
 * Atlases, "reference file specification"). */
static void count_from_1(sc_row *row)
{
    for (size_t i = 0; i < row->count; i++) {
        char *end;
        const long long value = strtoll(row->fields[i], &end, 10);

        if (row->columns[i] == SC_COLUMN_VALUE && end != row->fields[i] && value < INT32_MAX)
            snprintf(row->texts[i], SC_FIELD_BYTES, "%lld%s", value + 1, end);
    }
}

/* Give the label that is open to the table. */
static void end_label(xml_reading *r)
{
    const char *name = sc_label_trim(r->name);

    r->in_label = false;
    r->text = NULL;
    for (size_t i = 0; i < r->row.count; i++)
        r->row.fields[i] = sc_label_trim(r->row.texts[i]);
    if (*name)
        (void)sc_row_add(&r->row, SC_COLUMN_NAME, name);
    if (r->is_atlas && !strstr(r->type, "Label"))
        count_from_1(&r->row);
    (void)sc_columns_settle(r->row.columns, r->row.count);
    sc_rows_add(&r->rows, &r->row);
    if (r->rows.status != SC_OK)
        stop(r, r->rows.status, "it has too many labels");
}

/* The handlers of Expat; @p user is an xml_reading. */
static void XMLCALL on_start(void *user, const XML_Char *element, const XML_Char **attributes)
{
    xml_reading *r = user;

    if (r->in_label) {
        if (r->depth++ == 0)
            r->text = sc_row_add(&r->row, sc_column_of(element), NULL);
    } else if (r->in_table && !strcasecmp(element, "label")) {
        begin_label(r, attributes);
    } else if (!r->table && !strcmp(element, "atlas")) {
        r->is_atlas = true;
    } else if (!r->table && r->is_atlas && !strcmp(element, "type")) {
        r->text = r->type;
        r->type[0] = '\0';
    }
    for (size_t i = 0; i < SC_COUNT_OF(tables) && !r->table; i++) {
        if (!strcmp(element, tables[i].table) && r->is_atlas == (tables[i].around != NULL)) {
            r->table = tables[i].table;
            r->rows.dialect = &tables[i].dialect;
            r->in_table = true;
        }
    }
}

static void XMLCALL on_end(void *user, const XML_Char *element)
{
    xml_reading *r = user;

    if (r->in_label) {
        if (r->depth == 0)
            end_label(r);
        else if (--r->depth == 0)
            r->text = r->name;
    } else {
        r->in_table = r->in_table && strcmp(element, r->table) != 0;
        r->text = NULL;
    }
}

static void XMLCALL on_text(void *user, const XML_Char *text, int bytes)
{
    xml_reading *r = user;
    const size_t used = r->text ? strlen(r->text) : 0, room = SC_FIELD_BYTES - 1 - used;

    if (r->text)
        snprintf(r->text + used, SC_FIELD_BYTES - used, "%.*s",
                 (size_t)bytes < room ? bytes : (int)room, text);
}

/* No table needs declarations of its own, which stand in the internal subset of the DOCTYPE: a few
 * entities, nested, stand for a text of any length. What is declared elsewhere is not read. */
static void XMLCALL on_doctype(void *user, const XML_Char *name, const XML_Char *system_id,
                               const XML_Char *public_id, int has_internal_subset)
{
    if (has_internal_subset)
        stop(user, SC_ERR_DATA, "its DOCTYPE declares entities, which no label table needs");
}

/* Let Expat read the document. @return as sc_label_xml_parse. */
static sc_status run(xml_reading *r, const char *text, size_t bytes, char *why)
{
    enum XML_Error error;

    XML_SetUserData(r->parser, r);
    XML_SetElementHandler(r->parser, on_start, on_end);
    XML_SetCharacterDataHandler(r->parser, on_text);
    XML_SetStartDoctypeDeclHandler(r->parser, on_doctype);
    if (XML_Parse(r->parser, text, (int)bytes, 1) == XML_STATUS_OK && r->table)
        return SC_OK;
    error = XML_GetErrorCode(r->parser);
    if (r->rows.status != SC_OK && r->rows.status != SC_ERR_DATA)
        return r->rows.status;
    if (error == XML_ERROR_NO_MEMORY)
        return sc_fail(r->rows.ctx, SC_ERR_MEMORY, "%s: out of memory while its XML was read",
                       r->rows.path);
    if (error == XML_ERROR_NONE)
        snprintf(why, SC_XML_WHY_BYTES,
                 "the XML has no LabelTable, and no data of an atlas of FSL or labelset of "
                 "BrainSuite");
    else
        snprintf(why, SC_XML_WHY_BYTES, "line %lu of the XML: %s",
                 (unsigned long)XML_GetCurrentLineNumber(r->parser),
                 r->refused ? r->refused : XML_ErrorString(error));
    return SC_ERR_DATA;
}

/* @return whether the XML declaration at the begin of @p text names UTF-16 or UTF-32. A text that
 * begins with "<" and a byte other than NUL is neither. */
static bool is_said_to_be_wide(const char *text, size_t bytes)
{
    static const char *const names[] = {"UTF-16", "UTF-32"};

    for (size_t i = 0; i + 7 <= bytes && i < 128 && text[i] != '>'; i++) {
        if (!strncasecmp(text + i, names[0], 6) || !strncasecmp(text + i, names[1], 6))
            return text[0] == '<' && text[1] == '?';
    }
    return false;
}

sc_status sc_label_xml_parse(const sc_ctx *ctx, const char *path, const char *text, size_t bytes,
                             sc_label_table *table, char why[SC_XML_WHY_BYTES])
{
    const size_t before = table->count;
    xml_reading r = {.rows = sc_rows_begin(ctx, path, &tables[0].dialect, table)};

    if (bytes > SC_TABLE_BYTES_MAX) {
        snprintf(why, SC_XML_WHY_BYTES, "the XML has %zu bytes, expected at most %d", bytes,
                 SC_TABLE_BYTES_MAX);
        return SC_ERR_DATA;
    }
    /* Both have been decoded before, whatever the declaration still says. */
    r.parser = XML_ParserCreate(is_said_to_be_wide(text, bytes) ? "UTF-8" : NULL);
    if (!r.parser)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory while its XML was read", path);
    r.rows.status = run(&r, text, bytes, why);
    XML_ParserFree(r.parser);
    if (r.rows.status != SC_OK)
        table->count = before;
    return sc_rows_end(&r.rows);
}

#else

sc_status sc_label_xml_parse(const sc_ctx *ctx, const char *path, const char *text, size_t bytes,
                             sc_label_table *table, char why[SC_XML_WHY_BYTES])
{
    snprintf(why, SC_XML_WHY_BYTES,
             "segcast was built without Expat, which reads XML (Debian: libexpat1-dev)");
    return SC_ERR_DATA;
}

#endif
