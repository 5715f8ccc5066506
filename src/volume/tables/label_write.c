/* SPDX-License-Identifier: BSD-3-Clause */
/* Label tables in the formats of other programs, and what of a table these cannot hold. */
#include "segcast/label_files.h"

#include <jansson.h>
#include <stdlib.h>
#include <strings.h>

/* What a format holds of a label, beside its number and name. */
enum {
    HOLDS_COLOR = 1,
    HOLDS_OPACITY = 2,
    HOLDS_HIDDEN = 4,
    NEEDS_COLOR = 8,
    READS_BLANKS = 16, /* what stands for an unwanted character is read as that again */
    HAS_CELLS = 32     /* it is opened in spreadsheets */
};

struct sc_table_writer {
    const char *name, *title;
    const char *ending;   /* of files' names, ".tsv"; NULL: it does not tell */
    const char *unwanted; /* characters that its names cannot have; "": all are allowed */
    const char *head;     /* of the text, or the document without labels of JSON; NULL: none */
    const char *row;      /* of a label, as add_part tells; NULL: it is JSON */
    const char *foot;
    int (*append)(json_t *root, const sc_label *label); /* to JSON; not 0: there is no memory */
    int64_t lowest, highest; /* numbers of labels; the highest that JSON holds exactly is 2^53 */
    unsigned holds;          /* the bits above */
    char wanted;             /* what stands for unwanted characters */
};

/* ---- text ---- */

/* Append a field of a table of columns, in quotation marks where it needs them. */
static sc_status add_field(const sc_ctx *ctx, const char *text, char delimiter, sc_text *out)
{
    const char special[] = {delimiter, '"', '#', '\0'};

    return sc_text_add_field(ctx, out, text, text[0] == ' ' ? NULL : special);
}

static sc_status add_xml_text(const sc_ctx *ctx, const char *text, sc_text *out)
{
    for (; *text; text++) {
        const char *entity = *text == '&'   ? "&amp;"
                             : *text == '<' ? "&lt;"
                             : *text == '>' ? "&gt;"
                                            : NULL;

        SC_PASS(entity ? sc_text_add(ctx, out, "%s", entity) : sc_text_add(ctx, out, "%c", *text));
    }
    return SC_OK;
}

/* Write the name, or "label 5" for none, to out[SC_NAME_BYTES]: for formats that have names alone.
 */
static void full_name(const sc_label *label, char out[SC_NAME_BYTES])
{
    if (label->name[0])
        memcpy(out, label->name, SC_NAME_BYTES);
    else
        snprintf(out, SC_NAME_BYTES, "label %lld", (long long)label->value);
}

/* Append what a letter in the row of a format stands for: "v" the number; "r", "g", "b", "a" levels
 * of colour and opacity from 0 to 255, "t" of transparency, "R" to "A" from 0 to 1; "h" a
 * hexadecimal colour or n/a; "o" opacity from 0 to 1; "s" whether it is shown; the name: "n" as it
 * is, "w" with _ for none, "f" in full, "c" for commas, "q" for tabs with n/a for none, "x" for
 * XML.
 * @param width of letters, negative for those at the left. */
static sc_status add_part(const sc_ctx *ctx, char letter, int width, const sc_label *label,
                          const uint8_t rgba[4], sc_text *out)
{
    static const char levels[] = "rgbaRGBA";
    const char *level = strchr(levels, letter);
    char full[SC_NAME_BYTES];

    if (level && level < levels + 4)
        return sc_text_add(ctx, out, "%*d", width, rgba[level - levels]);
    if (level)
        return sc_text_add(ctx, out, "%.4g", rgba[level - levels - 4] / 255.0);
    full_name(label, full);
    switch (letter) {
    case 'v':
        return sc_text_add(ctx, out, "%*lld", width, (long long)label->value);
    case 't':
        return sc_text_add(ctx, out, "%d", 255 - rgba[3]);
    case 'h':
        return label->has_color ? sc_text_add(ctx, out, "#%02x%02x%02x", rgba[0], rgba[1], rgba[2])
                                : sc_text_add(ctx, out, "n/a");
    case 'o':
        return sc_text_add(ctx, out, "%*.4g", width,
                           label->opacity >= 0 ? (double)label->opacity : 1);
    case 's':
        return sc_text_add(ctx, out, "%*d", width, !label->hidden);
    case 'w':
        return sc_text_add(ctx, out, "%*s", width, label->name[0] ? label->name : "_");
    case 'c':
        return add_field(ctx, label->name, ',', out);
    case 'q':
        return add_field(ctx, label->name[0] ? label->name : "n/a", '\t', out);
    case 'x':
        return add_xml_text(ctx, label->name, out);
    default:
        return sc_text_add(ctx, out, "%s", letter == 'f' ? full : label->name);
    }
}

/* Append one label. */
static sc_status print_row(const sc_ctx *ctx, const char *row, const sc_label *label, sc_text *out)
{
    const float opacity = label->hidden ? 0 : label->opacity >= 0 ? label->opacity : 1;
    const uint8_t rgba[4] = {label->rgb[0], label->rgb[1], label->rgb[2],
                             (uint8_t)(opacity * 255 + 0.5F)};

    for (; *row; row++) {
        char *letter;
        long width;

        if (*row != '%') {
            SC_PASS(sc_text_add(ctx, out, "%c", *row));
            continue;
        }
        width = strtol(row + 1, &letter, 10);
        row = letter;
        SC_PASS(add_part(ctx, *row, (int)width, label, rgba, out));
    }
    return SC_OK;
}

/* ---- JSON; a failure to make or to append anything is not 0 ---- */

static int append_item(json_t *root, const sc_label *label)
{
    json_t *item = json_pack("{s:I, s:s}", "value", (json_int_t)label->value, "name", label->name);
    char color[8];
    int failed = 0;

    snprintf(color, sizeof color, "#%02x%02x%02x", label->rgb[0], label->rgb[1], label->rgb[2]);
    if (label->has_color)
        failed |= json_object_set_new(item, "color", json_string(color));
    if (label->opacity >= 0)
        failed |= json_object_set_new(item, "opacity", json_real((double)label->opacity));
    if (label->hidden)
        failed |= json_object_set_new(item, "visible", json_false());
    return failed | json_array_append_new(root, item);
}

static int append_neuroglancer(json_t *root, const sc_label *label)
{
    json_t *lists = json_object_get(root, "inline");
    json_t *names = json_array_get(json_object_get(lists, "properties"), 0);
    char id[32];

    snprintf(id, sizeof id, "%lld", (long long)label->value);
    return json_array_append_new(json_object_get(lists, "ids"), json_string(id)) |
           json_array_append_new(json_object_get(names, "values"), json_string(label->name));
}

static int append_ome(json_t *root, const sc_label *label)
{
    json_t *lists = json_object_get(root, "image-label");
    const int alpha = label->hidden         ? 0
                      : label->opacity >= 0 ? (int)(label->opacity * 255 + 0.5F)
                                            : 255;
    int failed = 0;

    if (label->has_color || alpha < 255)
        failed |= json_array_append_new(json_object_get(lists, "colors"),
                                        json_pack("{s:I, s:[i,i,i,i]}", "label-value",
                                                  (json_int_t)label->value, "rgba", label->rgb[0],
                                                  label->rgb[1], label->rgb[2], alpha));
    return failed | json_array_append_new(json_object_get(lists, "properties"),
                                          json_pack("{s:I, s:s}", "label-value",
                                                    (json_int_t)label->value, "name", label->name));
}

/* Names with numbers. A name that is missing or that an earlier label has is made of the number,
 * too. */
static int append_nnunet(json_t *root, const sc_label *label)
{
    json_t *map = json_object_get(root, "labels");
    char name[SC_NAME_BYTES], longer[SC_NAME_BYTES + 32];

    full_name(label, name);
    snprintf(longer, sizeof longer, "%s %lld", name, (long long)label->value);
    return json_object_set_new(map, json_object_get(map, name) ? longer : name,
                               json_integer((json_int_t)label->value));
}

/* ---- the table of formats ---- */

#define WHOLE ((int64_t)1 << 53)
#define ALL (HOLDS_COLOR | HOLDS_OPACITY | HOLDS_HIDDEN)

#define XML_ROW "<Label Key=\"%v\" Red=\"%R\" Green=\"%G\" Blue=\"%B\" Alpha=\"%A\">%x</Label>\n"
#define XML_HEAD "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"

static const sc_table_writer writers[] = {
    {"slicer", "a colour table of 3D Slicer", ".ctbl", " ", "# Color table file\n",
     "%v %w %r %g %b %a\n", NULL, NULL, 0, 1000000, ALL | NEEDS_COLOR | READS_BLANKS, '_'},
    {"freesurfer", "a look-up table of FreeSurfer", NULL, " ",
     "#No.    Label Name:                                R   G   B   A\n",
     "%-7v %-40w %3r %3g %3b %t\n", NULL, NULL, 0, INT32_MAX, ALL | NEEDS_COLOR, '_'},
    {"itksnap", "a label description of ITK-SNAP", NULL, "\"",
     "################################################\n# ITK-SnAP Label Description File\n"
     "# IDX  R G B  A  VIS  MSH  LABEL\n################################################\n",
     "%5v %5r %4g %4b %8o  1 %2s    \"%n\"\n", NULL, NULL, 0, 65535, ALL | NEEDS_COLOR, '\''},
    {"xml", "a label table in XML, as of TotalSegmentator and Connectome Workbench", ".xml", "",
     XML_HEAD "<LabelTable>\n", XML_ROW, "</LabelTable>\n", NULL, INT32_MIN, INT32_MAX,
     ALL | NEEDS_COLOR, 0},
    {"csv", "a table of 3D Slicer with commas", ".csv", "",
     "LabelValue,Name,Color_R,Color_G,Color_B,Color_A\n", "%v,%c,%r,%g,%b,%a\n", NULL, NULL, -WHOLE,
     WHOLE, ALL | NEEDS_COLOR | HAS_CELLS, 0},
    {"bids", "a dseg.tsv of BIDS", ".tsv", "", "index\tname\tcolor\n", "%v\t%q\t%h\n", NULL, NULL,
     -WHOLE, WHOLE, HOLDS_COLOR | HAS_CELLS, 0},
    {"json", "JSON", ".json", "", "[]", NULL, NULL, append_item, -WHOLE, WHOLE, ALL, 0},
    {"neuroglancer", "the segment properties of Neuroglancer", NULL, "",
     "{\"@type\": \"neuroglancer_segment_properties\", \"inline\": {\"ids\": [], \"properties\": "
     "[{\"id\": \"label\", \"type\": \"label\", \"values\": []}]}}",
     NULL, NULL, append_neuroglancer, 0, INT64_MAX, 0, 0},
    {"gifti", "a GIFTI file with a label table alone", ".gii", "",
     XML_HEAD "<GIFTI Version=\"1.0\" NumberOfDataArrays=\"0\">\n<LabelTable>\n", XML_ROW,
     "</LabelTable>\n</GIFTI>\n", NULL, INT32_MIN, INT32_MAX, ALL | NEEDS_COLOR, 0},
    {"workbench", "a label list of Connectome Workbench", NULL, "", NULL, "%f\n%v %r %g %b %a\n",
     NULL, NULL, INT32_MIN, INT32_MAX, ALL | NEEDS_COLOR, 0},
    {"names", "a class list, as of TotalSegmentator", NULL, "", NULL, "%v %f\n", NULL, NULL, -WHOLE,
     WHOLE, 0, 0},
    {"nnunet", "the dataset.json of nnU-Net", NULL, "", "{\"labels\": {\"background\": 0}}", NULL,
     NULL, append_nnunet, 1, WHOLE, 0, 0},
    {"ome-zarr", "the metadata of a label image of OME-Zarr", NULL, "",
     "{\"image-label\": {\"version\": \"0.4\", \"colors\": [], \"properties\": []}}", NULL, NULL,
     append_ome, -WHOLE, WHOLE, ALL, 0}};

const sc_table_writer *sc_table_writer_find(const char *name)
{
    for (size_t i = 0; i < SC_COUNT_OF(writers); i++) {
        if (!strcasecmp(name, writers[i].name))
            return &writers[i];
    }
    return NULL;
}

const sc_table_writer *sc_table_writer_for(const char *path)
{
    for (size_t i = 0; i < SC_COUNT_OF(writers); i++) {
        if (writers[i].ending && sc_stem_length(path, &writers[i].ending, 1))
            return &writers[i];
    }
    return NULL;
}

const char *sc_table_writer_name(size_t i)
{
    return i < SC_COUNT_OF(writers) ? writers[i].name : NULL;
}

/* ---- rows ---- */

/* @return whether a row says something else than the label of its number has. */
static bool differs(const sc_label *label, const sc_label *row)
{
    return (row->name[0] && strcmp(label->name, row->name) != 0) ||
           (row->has_color && memcmp(label->rgb, row->rgb, sizeof label->rgb) != 0) ||
           (row->opacity >= 0 && (row->opacity < label->opacity || row->opacity > label->opacity));
}

/* List the labels of @p table by value, each once, behind background. *repeated is how many rows of
 * numbers that stand there before say something else, which is lost. Caller owns *out:
 * sc_volume_clear. @return SC_ERR_MEMORY. */
static sc_status sort_labels(const sc_ctx *ctx, const sc_label_table *table, sc_volume *out,
                             size_t *repeated)
{
    SC_PASS(SC_ZALLOC(ctx, 1, &out->labels));
    out->label_count = 1;
    SC_PASS(sc_volume_add_labels(ctx, out, table));
    for (size_t i = 0; i < table->count; i++) {
        const sc_label *label = sc_volume_label(out, table->rows[i].value);

        *repeated += label && differs(label, &table->rows[i]);
    }
    return SC_OK;
}

/* How many labels lose what in a format. */
typedef struct losses {
    size_t numbers, names, colors, opacities, hidden, palette, formulas;
    const char *formula; /* the first name that is taken as one */
} losses;

/* Change @p labels to what the format can hold, and count what is lost. @return how many are left.
 */
static size_t fit(const sc_table_writer *writer, sc_label *labels, size_t count, losses *lost)
{
    size_t kept = 0;

    for (size_t i = 0; i < count; i++) {
        sc_label *l = &labels[kept];
        bool renamed;

        *l = labels[i];
        if (l->value < writer->lowest || l->value > writer->highest) {
            lost->numbers++;
            continue;
        }
        renamed = (writer->holds & READS_BLANKS) && strchr(l->name, writer->wanted);
        for (char *c = l->name; *c; c++) {
            if (strchr(writer->unwanted, *c)) {
                *c = writer->wanted;
                renamed = renamed || !(writer->holds & READS_BLANKS);
            }
        }
        lost->names += renamed;
        if ((writer->holds & HAS_CELLS) && l->name[0] && strchr("=+-@\t\r", l->name[0]) &&
            lost->formulas++ == 0)
            lost->formula = l->name;
        lost->colors += l->has_color && !(writer->holds & HOLDS_COLOR);
        lost->opacities += l->opacity >= 0 && !l->hidden && !(writer->holds & HOLDS_OPACITY);
        lost->hidden += l->hidden && !(writer->holds & HOLDS_HIDDEN);
        if (!l->has_color) {
            lost->palette += (writer->holds & NEEDS_COLOR) != 0;
            sc_label_base_color(l->value, l->rgb);
        }
        kept++;
    }
    return kept;
}

/* Append ", N LABELS WHAT" if there are any. */
static sc_status add_loss(const sc_ctx *ctx, size_t count, const char *what, sc_text *out)
{
    if (!count)
        return SC_OK;
    return sc_text_add(ctx, out, "%s%s of %zu label%s", out->length_bytes ? "; " : "", what, count,
                       count == 1 ? "" : "s");
}

/* Warn of what the format cannot hold. */
static sc_status tell_losses(const sc_ctx *ctx, const char *path, const sc_table_writer *writer,
                             const losses *lost)
{
    SC_OWN(sc_text_clear) sc_text text = {0};

    SC_PASS(
        add_loss(ctx, lost->numbers, "the rows (their numbers are too large, or negative)", &text));
    SC_PASS(add_loss(ctx, lost->colors, "the colours", &text));
    SC_PASS(add_loss(ctx, lost->opacities, "the opacities", &text));
    SC_PASS(add_loss(ctx, lost->hidden, "that they are hidden,", &text));
    if (text.data)
        sc_warn(ctx, "%s: %s cannot hold, and does not have: %s", path, writer->title, text.data);
    if (lost->names && (writer->holds & READS_BLANKS))
        sc_warn(ctx, "%s: %zu name%s \"%c\", for which programs that read %s show a blank", path,
                lost->names, lost->names == 1 ? " has" : "s have", writer->wanted, writer->title);
    else if (lost->names)
        sc_warn(ctx,
                "%s: %zu name%s changed, because %s allows no %s in names: \"%c\" stands there",
                path, lost->names, lost->names == 1 ? " is" : "s are", writer->title,
                writer->unwanted[0] == ' ' ? "blanks" : "quotation marks", writer->wanted);
    if (lost->formulas)
        sc_warn(
            ctx,
            "%s: %zu name%s as a formula does, such as \"%s\": spreadsheets compute what a cell "
            "with it says; import the columns as text, or rename the tissues",
            path, lost->formulas, lost->formulas == 1 ? " begins" : "s begin", lost->formula);
    if (lost->palette)
        sc_warn(ctx,
                "%s: %zu label%s no colour, which %s needs; colours of segcast's palette are "
                "written",
                path, lost->palette, lost->palette == 1 ? " has" : "s have", writer->title);
    return SC_OK;
}

/* Append the labels as text. */
static sc_status print_lines(const sc_ctx *ctx, const sc_table_writer *writer,
                             const sc_label *labels, size_t count, sc_text *out)
{
    SC_PASS(sc_text_add(ctx, out, "%s", writer->head ? writer->head : ""));
    for (size_t i = 0; i < count; i++)
        SC_PASS(print_row(ctx, writer->row, &labels[i], out));
    return sc_text_add(ctx, out, "%s", writer->foot ? writer->foot : "");
}

/* Append the labels as JSON. */
static sc_status print_json(const sc_ctx *ctx, const sc_table_writer *writer,
                            const sc_label *labels, size_t count, sc_text *out)
{
    json_auto_t *json = json_loads(writer->head, 0, NULL);
    int failed = !json;
    SC_OWN(sc_free_at) char *text = NULL;

    for (size_t i = 0; i < count && !failed; i++)
        failed = writer->append(json, &labels[i]);
    if (!failed)
        text = json_dumps(json, JSON_INDENT(1) | JSON_REAL_PRECISION(6));
    return text ? sc_text_add(ctx, out, "%s\n", text)
                : sc_fail(ctx, SC_ERR_MEMORY, "out of memory for a label table");
}

sc_status sc_label_table_print(const sc_ctx *ctx, const char *path, const sc_label_table *table,
                               const sc_table_writer *writer, sc_text *out)
{
    SC_OWN(sc_volume_clear) sc_volume all = {0};
    losses lost = {0};
    size_t count, repeated = 0;
    sc_label *labels;

    SC_PASS(sort_labels(ctx, table, &all, &repeated));
    labels = all.labels + 1;
    if (repeated)
        sc_warn(ctx,
                "%s: %zu row%s of the table say%s something else of a number than a row before; "
                "the first row of a number is written",
                path, repeated, repeated == 1 ? "" : "s", repeated == 1 ? "s" : "");
    count = fit(writer, labels, (size_t)all.label_count - 1, &lost);
    if (count == 0)
        return sc_fail(ctx, SC_ERR_DATA, "%s: there is no label that %s can hold", path,
                       writer->title);
    SC_PASS(tell_losses(ctx, path, writer, &lost));
    return writer->row ? print_lines(ctx, writer, labels, count, out)
                       : print_json(ctx, writer, labels, count, out);
}
