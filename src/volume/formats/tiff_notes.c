/* SPDX-License-Identifier: BSD-3-Clause */
/* The ImageDescription of TIFF files of ImageJ, lines of the form key=value, and of OME-TIFF, an
 * XML document, which is read with Expat. Sources: ImageJ's ij/io/FileInfo.java and
 * TiffDecoder.java; the OME data model, 2016-06. */
#include "formats/tiff_notes.h"
#include "tables/label_table.h"

#include <errno.h>
#include <stdlib.h>

/* Read @p text as a finite number above 0. @return 0 if it is NULL or something else. */
static double positive(const char *text)
{
    char *end;
    const double value = text ? strtod(text, &end) : 0;

    return text && end != text && !end[strspn(end, " \t\r\n")] && isfinite(value) && value > 0
               ? value
               : 0;
}

/* Read @p text as a whole number. @return 0 if it is NULL or something else. */
static int64_t whole(const char *text)
{
    char *end;
    long long value;

    if (!text)
        return 0;
    errno = 0;
    value = strtoll(text, &end, 10);
    return end != text && !end[strspn(end, " \t\r\n")] && !errno ? value : 0;
}

/* ---- ImageJ ---- */

/* Copy what stands behind "@p key=" at the beginning of a line to out[size]; cut if it is longer.
 * @return false, out empty, if there is no such line. */
static bool line_of(const char *text, const char *key, char *out, size_t size)
{
    const size_t length = strlen(key);

    out[0] = '\0';
    for (const char *line = text; line; line = strchr(line, '\n')) {
        line += *line == '\n';
        if (!strncmp(line, key, length) && line[length] == '=') {
            const char *value = line + length + 1;
            const size_t bytes = strcspn(value, "\r\n");

            snprintf(out, size, "%.*s", (int)(bytes < size ? bytes : size - 1), value);
            return true;
        }
    }
    return false;
}

static int64_t whole_line(const char *text, const char *key, int64_t otherwise)
{
    char value[64];

    return line_of(text, key, value, sizeof value) ? whole(value) : otherwise;
}

/* The pixels per unit are in the file's tags, all else is in the text. */
static void read_imagej(const char *text, const double pixels_per_unit[2], sc_tiff_notes *out)
{
    char unit[64], units[3][64], value[64];
    double spacing[3] = {0, 0, 0};

    out->program = "ImageJ";
    out->images = whole_line(text, "images", 0);
    out->slices = whole_line(text, "slices", 0);
    out->channels = whole_line(text, "channels", 1);
    out->frames = whole_line(text, "frames", 1);
    line_of(text, "unit", unit, sizeof unit);
    for (int i = 0; i < 3; i++)
        snprintf(units[i], sizeof units[i], "%s", unit);
    if (line_of(text, "yunit", value, sizeof value))
        snprintf(units[1], sizeof units[1], "%s", value);
    if (line_of(text, "zunit", value, sizeof value))
        snprintf(units[2], sizeof units[2], "%s", value);
    for (int i = 0; i < 2; i++)
        spacing[i] = pixels_per_unit[i] > 0 ? 1 / pixels_per_unit[i] : 0;
    if (line_of(text, "spacing", value, sizeof value))
        spacing[2] = value[0] == '-' ? positive(value + 1) : positive(value);
    for (int i = 0; i < 3; i++) {
        const double mm = sc_length_unit_mm(units[i]);

        out->unit_missing = out->unit_missing || (mm == 0 && spacing[i] > 0);
        out->spacing_mm[i] = spacing[i] * (mm > 0 ? mm : 1);
    }
}

/* ---- OME-XML ---- */

#if SC_HAVE_EXPAT

#include <expat.h>

/* The document while Expat reads it. Elements may have a prefix, as in "OME:Pixels". */
typedef struct ome_reading {
    XML_Parser parser;
    sc_tiff_notes *notes;
    bool in_pixels; /* within those of the first image */
    const char *refused;
} ome_reading;

static const char *attribute(const char **attributes, const char *name)
{
    for (; attributes[0]; attributes += 2) {
        if (!strcmp(attributes[0], name))
            return attributes[1];
    }
    return NULL;
}

/* Fill the notes from the attributes of the element Pixels of the first image. */
static void read_pixels(ome_reading *r, const char **attributes)
{
    static const char *const sizes[] = {"PhysicalSizeX", "PhysicalSizeY", "PhysicalSizeZ"};
    static const char *const units[] = {"PhysicalSizeXUnit", "PhysicalSizeYUnit",
                                        "PhysicalSizeZUnit"};
    sc_tiff_notes *notes = r->notes;

    notes->width = whole(attribute(attributes, "SizeX"));
    notes->height = whole(attribute(attributes, "SizeY"));
    notes->slices = whole(attribute(attributes, "SizeZ"));
    notes->channels = whole(attribute(attributes, "SizeC"));
    notes->frames = whole(attribute(attributes, "SizeT"));
    for (int i = 0; i < 3; i++) {
        const char *unit = attribute(attributes, units[i]);
        const double mm = sc_length_unit_mm(unit ? unit : "um"); /* the model's default */
        const double spacing = positive(attribute(attributes, sizes[i]));

        notes->unit_missing = notes->unit_missing || (mm == 0 && spacing > 0);
        notes->spacing_mm[i] = spacing * (mm > 0 ? mm : 1);
    }
}

static void XMLCALL on_start(void *user, const XML_Char *element, const XML_Char **attributes)
{
    ome_reading *r = user;
    const char *colon = strrchr(element, ':'), *name = colon ? colon + 1 : element;

    if (!strcmp(name, "Image")) {
        r->notes->images++;
    } else if (!strcmp(name, "Pixels") && r->notes->images == 1) {
        r->in_pixels = true;
        read_pixels(r, attributes);
    } else if (!strcmp(name, "TiffData") && r->in_pixels) {
        const char *page = attribute(attributes, "IFD");

        r->notes->reordered =
            r->notes->reordered || (page && whole(page) != whole(attribute(attributes, "FirstZ")));
    }
}

static void XMLCALL on_end(void *user, const XML_Char *element)
{
    ome_reading *r = user;
    const char *colon = strrchr(element, ':');

    if (!strcmp(colon ? colon + 1 : element, "Pixels"))
        r->in_pixels = false;
}

/* As for label tables: a few nested entities would stand for a text of any length. */
static void XMLCALL on_doctype(void *user, const XML_Char *name, const XML_Char *system_id,
                               const XML_Char *public_id, int has_internal_subset)
{
    ome_reading *r = user;

    if (!has_internal_subset)
        return;
    r->refused = "its DOCTYPE declares entities, which OME-XML does not need";
    XML_StopParser(r->parser, XML_FALSE);
}

static sc_status read_ome(const sc_ctx *ctx, const char *path, const char *text, sc_tiff_notes *out)
{
    ome_reading r = {.parser = XML_ParserCreate(NULL), .notes = out};
    const size_t bytes = strlen(text);
    sc_status status = SC_OK;

    if (!r.parser)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory while its XML was read", path);
    XML_SetUserData(r.parser, &r);
    XML_SetElementHandler(r.parser, on_start, on_end);
    XML_SetStartDoctypeDeclHandler(r.parser, on_doctype);
    out->program = "OME-XML";
    if (bytes > SC_TABLE_BYTES_MAX)
        status = sc_fail(ctx, SC_ERR_DATA, "%s: has %zu bytes of OME-XML, expected at most %d",
                         path, bytes, SC_TABLE_BYTES_MAX);
    else if (XML_Parse(r.parser, text, (int)bytes, 1) != XML_STATUS_OK)
        status = sc_fail(
            ctx, XML_GetErrorCode(r.parser) == XML_ERROR_NO_MEMORY ? SC_ERR_MEMORY : SC_ERR_DATA,
            "%s: line %lu of its OME-XML: %s; save it anew, for example with Fiji", path,
            (unsigned long)XML_GetCurrentLineNumber(r.parser),
            r.refused ? r.refused : XML_ErrorString(XML_GetErrorCode(r.parser)));
    XML_ParserFree(r.parser);
    return status;
}

#else

static sc_status read_ome(const sc_ctx *ctx, const char *path, const char *text, sc_tiff_notes *out)
{
    sc_warn(ctx,
            "%s: its OME-XML, which may give the spacing, is not read: segcast was built without "
            "Expat (Debian: libexpat1-dev)",
            path);
    return SC_OK;
}

#endif

sc_status sc_tiff_notes_read(const sc_ctx *ctx, const char *path, const char *text,
                             const double pixels_per_unit[2], sc_tiff_notes *out)
{
    sc_tiff_notes notes = {.channels = 1, .frames = 1};

    if (text && !strncmp(text, "ImageJ=", 7))
        read_imagej(text, pixels_per_unit, &notes);
    else if (text && strstr(text, "<OME") && text[strspn(text, " \t\r\n\xef\xbb\xbf")] == '<')
        SC_PASS(read_ome(ctx, path, text, &notes));
    *out = notes;
    return SC_OK;
}
