/* SPDX-License-Identifier: BSD-3-Clause */
/* Label tables in XML, read with Expat. Without Expat, which is optional, they are refused with a
 * reason, and all else works. */
#include "tables/label_xml.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

#if SC_HAVE_EXPAT

#include <errno.h>
#include <expat.h>

enum { NAME_READ_BYTES = 4 * SC_NAME_BYTES /* of a longer name the rest is not kept */ };

/* The document while Expat reads it. */
typedef struct xml_reading {
    const sc_ctx *ctx;
    XML_Parser parser;
    sc_label_table *table;
    sc_name_count names;
    sc_label row;               /* of the label that is open */
    bool row_good;              /* it has a key */
    char name[NAME_READ_BYTES]; /* of the label that is open, with a NUL byte behind it */
    size_t name_bytes;
    int tables;              /* label tables begun so far; only the first is read */
    bool in_table, in_label; /* within the first table, and within a label of it */
    bool is_atlas;           /* of FSL: the table is "data", and a label of it "label" */
    bool in_type;            /* within the type of the atlas */
    bool counts_from_0;      /* voxels have the value index + 1, as index begins with 0 */
    int bad;                 /* labels of which something cannot be read */
    unsigned long bad_line;  /* the first of them */
    sc_status status;        /* SC_OK, or why the handlers have stopped the parser */
    const char *refused;     /* the reason for SC_ERR_DATA */
} xml_reading;

/* Stop the parser. @p refused: the reason for SC_ERR_DATA; else NULL. */
static void stop(xml_reading *r, sc_status status, const char *refused)
{
    r->status = status;
    r->refused = refused;
    XML_StopParser(r->parser, XML_FALSE);
}

/* The value of the attribute @p name among @p attributes (name, value, ..., NULL); NULL without. */
static const char *attribute(const char **attributes, const char *name)
{
    for (; attributes[0]; attributes += 2) {
        if (!strcmp(attributes[0], name))
            return attributes[1];
    }
    return NULL;
}

/* Read @p text as a level from 0 to 1. @return false if it is NULL or something else. */
static bool read_level(const char *text, double *out)
{
    char *end;

    if (!text)
        return false;
    *out = strtod(text, &end);
    return end != text && !end[strspn(end, " \t\r\n")] && *out >= 0 && *out <= 1;
}

/* Read @p text as a whole number. @return false if it is NULL or something else. */
static bool read_whole(const char *text, int64_t *out)
{
    char *end;

    if (!text)
        return false;
    errno = 0;
    *out = strtoll(text, &end, 10);
    return end != text && !end[strspn(end, " \t\r\n")] && !errno;
}

/* Fill r->row from the attributes of a label. The first GIFTI called the key Index. */
static void begin_label(xml_reading *r, const char **attributes)
{
    static const char *const channels[] = {"Red", "Green", "Blue"};
    const char *key = attribute(attributes, "Key"), *alpha = attribute(attributes, "Alpha");
    double level = 1;
    int found = 0;

    r->row = (sc_label){.opacity = -1};
    r->name_bytes = 0;
    if (!key)
        key = attribute(attributes, r->is_atlas ? "index" : "Index");
    r->row_good = read_whole(key, &r->row.value) && r->row.value < INT64_MAX;
    r->row.value += r->row_good && r->counts_from_0;
    for (int i = 0; i < 3; i++) {
        if (read_level(attribute(attributes, channels[i]), &level)) {
            r->row.rgb[i] = (uint8_t)(level * 255 + 0.5);
            found++;
        }
    }
    r->row.has_color = found == 3;
    if (alpha && read_level(alpha, &level) && level < 1) {
        r->row.opacity = (float)level;
        r->row.hidden = level == 0;
    }
    /* Colours may be left out, but not in part. */
    if (!r->row_good || (found < 3 && attribute(attributes, "Red")) ||
        (alpha && !read_level(alpha, &level))) {
        if (r->bad++ == 0)
            r->bad_line = XML_GetCurrentLineNumber(r->parser);
    }
}

/* Append the label that is open to the table, but for background, which is never shown. */
static void end_label(xml_reading *r)
{
    char *name = r->name;
    sc_status status;

    if (!r->row_good || r->row.value == 0)
        return;
    if (r->table->count == SC_TABLE_ROWS_MAX) {
        stop(r, SC_ERR_DATA, "it has more than 1048576 labels");
        return;
    }
    while (r->name_bytes && strchr(" \t\r\n", name[r->name_bytes - 1]))
        r->name_bytes--;
    name[r->name_bytes] = '\0';
    sc_name_read(name + strspn(name, " \t\r\n"), r->row.name, &r->names);
    status = sc_label_table_add(r->ctx, r->table, &r->row);
    if (status != SC_OK)
        stop(r, status, NULL);
}

/* The handlers of Expat; @p user is an xml_reading. */
static void XMLCALL on_start(void *user, const XML_Char *element, const XML_Char **attributes)
{
    xml_reading *r = user;

    if (!r->tables && !strcmp(element, "atlas")) {
        r->is_atlas = true;
    } else if (r->is_atlas && !r->tables && !strcmp(element, "type")) {
        r->in_type = true;
        r->name_bytes = 0;
    } else if (!strcmp(element, r->is_atlas ? "data" : "LabelTable")) {
        r->in_table = r->tables++ == 0;
    } else if (r->in_table && !r->in_label && !strcmp(element, r->is_atlas ? "label" : "Label")) {
        r->in_label = true;
        begin_label(r, attributes);
    }
}

/* An atlas of FSL whose type is not "Label" holds probabilities. Its labels count these images from
 * 0; in the image of the most probable labels 0 is background, and each label is 1 more (FSL,
 * Atlases, "reference file specification"). */
static void end_type(xml_reading *r)
{
    r->name[r->name_bytes] = '\0';
    r->counts_from_0 = !strstr(r->name, "Label");
    r->in_type = false;
}

static void XMLCALL on_end(void *user, const XML_Char *element)
{
    xml_reading *r = user;

    if (!strcmp(element, r->is_atlas ? "data" : "LabelTable")) {
        r->in_table = false;
    } else if (r->in_type && !strcmp(element, "type")) {
        end_type(r);
    } else if (r->in_label && !strcmp(element, r->is_atlas ? "label" : "Label")) {
        r->in_label = false;
        end_label(r);
    }
}

static void XMLCALL on_text(void *user, const XML_Char *text, int bytes)
{
    xml_reading *r = user;
    const size_t room = NAME_READ_BYTES - 1 - r->name_bytes;
    const size_t count = (size_t)bytes < room ? (size_t)bytes : room;

    if (!r->in_label && !r->in_type)
        return;
    memcpy(r->name + r->name_bytes, text, count);
    r->name_bytes += count;
}

/* No table needs declarations of its own, which stand in the internal subset of the DOCTYPE: a few
 * entities, nested, stand for a text of any length. What is declared elsewhere is not read. */
static void XMLCALL on_doctype(void *user, const XML_Char *name, const XML_Char *system_id,
                               const XML_Char *public_id, int has_internal_subset)
{
    (void)name;
    (void)system_id;
    (void)public_id;
    if (has_internal_subset)
        stop(user, SC_ERR_DATA, "its DOCTYPE declares entities, which no label table needs");
}

/* Let Expat read the document. @return as sc_label_xml_parse. */
static sc_status run(xml_reading *r, const char *path, const char *text, size_t bytes, char *why)
{
    enum XML_Error error;

    XML_SetUserData(r->parser, r);
    XML_SetElementHandler(r->parser, on_start, on_end);
    XML_SetCharacterDataHandler(r->parser, on_text);
    XML_SetStartDoctypeDeclHandler(r->parser, on_doctype);
    if (XML_Parse(r->parser, text, (int)bytes, 1) == XML_STATUS_OK && r->tables > 0)
        return SC_OK;
    error = XML_GetErrorCode(r->parser);
    if (r->status != SC_OK && r->status != SC_ERR_DATA)
        return r->status;
    if (error == XML_ERROR_NO_MEMORY)
        return sc_fail(r->ctx, SC_ERR_MEMORY, "%s: out of memory while its XML was read", path);
    if (error == XML_ERROR_NONE)
        snprintf(why, SC_XML_WHY_BYTES,
                 "the XML has no LabelTable, and no data of an atlas of FSL");
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
    xml_reading r = {.ctx = ctx, .table = table, .status = SC_OK};
    sc_status status;

    if (bytes > SC_TABLE_BYTES_MAX) {
        snprintf(why, SC_XML_WHY_BYTES, "the XML has %zu bytes, expected at most %d", bytes,
                 SC_TABLE_BYTES_MAX);
        return SC_ERR_DATA;
    }
    /* Both have been decoded before, whatever the declaration still says. */
    r.parser = XML_ParserCreate(is_said_to_be_wide(text, bytes) ? "UTF-8" : NULL);
    if (!r.parser)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory while its XML was read", path);
    status = run(&r, path, text, bytes, why);
    XML_ParserFree(r.parser);
    if (status != SC_OK) {
        table->count = before;
        return status;
    }
    sc_name_warn(ctx, path, &r.names);
    if (r.bad)
        sc_warn(ctx,
                "%s: line %lu of its XML: %d label%s no whole number as Key, or no levels from 0 "
                "to 1 as Red, Green, Blue and Alpha; what cannot be read is not used",
                path, r.bad_line, r.bad, r.bad == 1 ? " has" : "s have");
    return SC_OK;
}

#else

sc_status sc_label_xml_parse(const sc_ctx *ctx, const char *path, const char *text, size_t bytes,
                             sc_label_table *table, char why[SC_XML_WHY_BYTES])
{
    (void)ctx;
    (void)path;
    (void)text;
    (void)bytes;
    (void)table;
    snprintf(why, SC_XML_WHY_BYTES,
             "segcast was built without Expat, which reads XML (Debian: libexpat1-dev)");
    return SC_ERR_DATA;
}

#endif
