/* SPDX-License-Identifier: BSD-3-Clause */
/* Label tables in the formats of other programs, and what of a table these cannot hold. */
#include "segcast/label_files.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* What a format holds of a label, beside its number and name. */
enum {
    HOLDS_COLOR = 1,
    HOLDS_OPACITY = 2,
    HOLDS_HIDDEN = 4,
    NEEDS_COLOR = 8,
    READS_BLANKS = 16 /* what stands for an unwanted character is read as that again */
};

struct sc_table_writer {
    const char *name, *title;
    const char *ending;      /* of files' names, ".tsv"; NULL: it does not tell */
    const char *unwanted;    /* characters that its names cannot have; "": all are allowed */
    const char *head, *foot; /* of the text, or NULL */
    /* Append one label, with levels from 0 to 255. @return SC_ERR_MEMORY. NULL: it is JSON. */
    sc_status (*print)(const sc_ctx *ctx, const sc_label *label, const uint8_t rgba[4],
                       sc_text *out);
    /* @return the document of all labels, NULL if there is no memory. Caller owns it. */
    json_t *(*to_json)(const sc_label *labels, size_t count);
    int64_t lowest, highest; /* numbers of labels; the highest that JSON holds exactly is 2^53 */
    unsigned holds;          /* the bits above */
    char wanted;             /* what stands for unwanted characters */
};

/* ---- one label a line ---- */

/* @return the name, or "_", which stands for none where a word must stand. */
static const char *word_of(const sc_label *label)
{
    return label->name[0] ? label->name : "_";
}

static sc_status print_slicer(const sc_ctx *ctx, const sc_label *label, const uint8_t rgba[4],
                              sc_text *out)
{
    return sc_text_add(ctx, out, "%lld %s %d %d %d %d\n", (long long)label->value, word_of(label),
                       rgba[0], rgba[1], rgba[2], rgba[3]);
}

static sc_status print_freesurfer(const sc_ctx *ctx, const sc_label *label, const uint8_t rgba[4],
                                  sc_text *out)
{
    return sc_text_add(ctx, out, "%-7lld %-40s %3d %3d %3d %d\n", (long long)label->value,
                       word_of(label), rgba[0], rgba[1], rgba[2], 255 - rgba[3]);
}

static sc_status print_itksnap(const sc_ctx *ctx, const sc_label *label, const uint8_t rgba[4],
                               sc_text *out)
{
    const double opacity = label->opacity >= 0 ? (double)label->opacity : 1;

    return sc_text_add(ctx, out, "%5lld %5d %4d %4d %8.4g %2d %2d    \"%s\"\n",
                       (long long)label->value, rgba[0], rgba[1], rgba[2], opacity, 1,
                       !label->hidden, label->name);
}

/* Append a field of a table of columns, in quotation marks where it needs them. */
static sc_status add_field(const sc_ctx *ctx, const char *text, char delimiter, sc_text *out)
{
    const char special[] = {delimiter, '"', '#', '\0'};
    sc_status status;

    if (!text[strcspn(text, special)] && text[0] != ' ')
        return sc_text_add(ctx, out, "%s", text);
    SC_TRY(sc_text_add(ctx, out, "\""));
    for (; *text; text++)
        SC_TRY(sc_text_add(ctx, out, "%s%c", *text == '"' ? "\"" : "", *text));
    status = sc_text_add(ctx, out, "\"");
out:
    return status;
}

/* As 3D Slicer reads and writes them. */
static sc_status print_csv(const sc_ctx *ctx, const sc_label *label, const uint8_t rgba[4],
                           sc_text *out)
{
    sc_status status;

    SC_TRY(sc_text_add(ctx, out, "%lld,", (long long)label->value));
    SC_TRY(add_field(ctx, label->name, ',', out));
    status = sc_text_add(ctx, out, ",%d,%d,%d,%d\n", rgba[0], rgba[1], rgba[2], rgba[3]);
out:
    return status;
}

/* As the Brain Imaging Data Structure has them: "n/a" for what is not known. */
static sc_status print_bids(const sc_ctx *ctx, const sc_label *label, const uint8_t rgba[4],
                            sc_text *out)
{
    sc_status status;

    SC_TRY(sc_text_add(ctx, out, "%lld\t", (long long)label->value));
    SC_TRY(add_field(ctx, label->name[0] ? label->name : "n/a", '\t', out));
    status = label->has_color
                 ? sc_text_add(ctx, out, "\t#%02x%02x%02x\n", rgba[0], rgba[1], rgba[2])
                 : sc_text_add(ctx, out, "\tn/a\n");
out:
    return status;
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

/* As the class lists of TotalSegmentator, and of people. */
static sc_status print_class(const sc_ctx *ctx, const sc_label *label, const uint8_t rgba[4],
                             sc_text *out)
{
    char name[SC_NAME_BYTES];

    (void)rgba;
    full_name(label, name);
    return sc_text_add(ctx, out, "%lld %s\n", (long long)label->value, name);
}

/* Two lines for a label, as `wb_command -volume-label-export-table` writes them. */
static sc_status print_workbench(const sc_ctx *ctx, const sc_label *label, const uint8_t rgba[4],
                                 sc_text *out)
{
    char name[SC_NAME_BYTES];

    full_name(label, name);
    return sc_text_add(ctx, out, "%s\n%lld %d %d %d %d\n", name, (long long)label->value, rgba[0],
                       rgba[1], rgba[2], rgba[3]);
}

/* ---- XML ---- */

static sc_status add_xml_text(const sc_ctx *ctx, const char *text, sc_text *out)
{
    sc_status status = SC_OK;

    for (; *text && status == SC_OK; text++) {
        const char *entity = *text == '&'   ? "&amp;"
                             : *text == '<' ? "&lt;"
                             : *text == '>' ? "&gt;"
                                            : NULL;

        status = entity ? sc_text_add(ctx, out, "%s", entity) : sc_text_add(ctx, out, "%c", *text);
    }
    return status;
}

static sc_status print_xml(const sc_ctx *ctx, const sc_label *label, const uint8_t rgba[4],
                           sc_text *out)
{
    sc_status status;

    SC_TRY(sc_text_add(ctx, out,
                       "<Label Key=\"%lld\" Red=\"%.4g\" Green=\"%.4g\" Blue=\"%.4g\" "
                       "Alpha=\"%.4g\">",
                       (long long)label->value, rgba[0] / 255.0, rgba[1] / 255.0, rgba[2] / 255.0,
                       rgba[3] / 255.0));
    SC_TRY(add_xml_text(ctx, label->name, out));
    status = sc_text_add(ctx, out, "</Label>\n");
out:
    return status;
}

/* ---- JSON; NULL: there is no memory ---- */

static json_t *list_json(const sc_label *labels, size_t count)
{
    json_t *list = json_array();

    for (size_t i = 0; i < count; i++) {
        const sc_label *label = &labels[i];
        json_t *item =
            json_pack("{s:I, s:s}", "value", (json_int_t)label->value, "name", label->name);
        char color[8];

        snprintf(color, sizeof color, "#%02x%02x%02x", label->rgb[0], label->rgb[1], label->rgb[2]);
        if (!item || (label->has_color && json_object_set_new(item, "color", json_string(color))) ||
            (label->opacity >= 0 &&
             json_object_set_new(item, "opacity", json_real((double)label->opacity))) ||
            (label->hidden && json_object_set_new(item, "visible", json_false())) ||
            json_array_append(list, item)) {
            json_decref(item);
            json_decref(list);
            return NULL;
        }
        json_decref(item);
    }
    return list;
}

static json_t *neuroglancer_json(const sc_label *labels, size_t count)
{
    json_t *ids = json_array(), *names = json_array();
    int failed = 0;

    for (size_t i = 0; i < count; i++) {
        char id[32];

        snprintf(id, sizeof id, "%lld", (long long)labels[i].value);
        failed |= json_array_append_new(ids, json_string(id)) |
                  json_array_append_new(names, json_string(labels[i].name));
    }
    if (failed) {
        json_decref(ids);
        json_decref(names);
        return NULL;
    }
    return json_pack("{s:s, s:{s:o, s:[{s:s, s:s, s:o}]}}", "@type",
                     "neuroglancer_segment_properties", "inline", "ids", ids, "properties", "id",
                     "label", "type", "label", "values", names);
}

static json_t *ome_json(const sc_label *labels, size_t count)
{
    json_t *colors = json_array(), *properties = json_array();
    int failed = 0;

    for (size_t i = 0; i < count; i++) {
        const sc_label *l = &labels[i];
        const int alpha = l->hidden ? 0 : l->opacity >= 0 ? (int)(l->opacity * 255 + 0.5F) : 255;

        if (l->has_color || alpha < 255)
            failed |= json_array_append_new(
                colors, json_pack("{s:I, s:[i,i,i,i]}", "label-value", (json_int_t)l->value, "rgba",
                                  l->rgb[0], l->rgb[1], l->rgb[2], alpha));
        failed |=
            json_array_append_new(properties, json_pack("{s:I, s:s}", "label-value",
                                                        (json_int_t)l->value, "name", l->name));
    }
    if (failed) {
        json_decref(colors);
        json_decref(properties);
        return NULL;
    }
    return json_pack("{s:{s:s, s:o, s:o}}", "image-label", "version", "0.4", "colors", colors,
                     "properties", properties);
}

/* The labels of a dataset.json of nnU-Net: names with numbers. A name that is missing or that an
 * earlier label has is made of the number, too. */
static json_t *nnunet_json(const sc_label *labels, size_t count)
{
    json_t *map = json_pack("{s:i}", "background", 0);
    int failed = !map;

    for (size_t i = 0; i < count && !failed; i++) {
        char name[SC_NAME_BYTES], longer[SC_NAME_BYTES + 32];
        const char *key = name;

        full_name(&labels[i], name);
        if (json_object_get(map, name)) {
            snprintf(longer, sizeof longer, "%s %lld", name, (long long)labels[i].value);
            key = longer;
        }
        failed = json_object_set_new(map, key, json_integer((json_int_t)labels[i].value));
    }
    if (failed) {
        json_decref(map);
        return NULL;
    }
    return json_pack("{s:o}", "labels", map);
}

/* ---- the table of formats ---- */

#define WHOLE ((int64_t)1 << 53)
#define ALL (HOLDS_COLOR | HOLDS_OPACITY | HOLDS_HIDDEN)

static const sc_table_writer writers[] = {
    {"slicer", "a colour table of 3D Slicer", ".ctbl", " ", "# Color table file\n", NULL,
     print_slicer, NULL, 0, 1000000, ALL | NEEDS_COLOR | READS_BLANKS, '_'},
    {"freesurfer", "a look-up table of FreeSurfer", NULL, " ",
     "#No.    Label Name:                                R   G   B   A\n", NULL, print_freesurfer,
     NULL, 0, INT32_MAX, ALL | NEEDS_COLOR, '_'},
    {"itksnap", "a label description of ITK-SNAP", NULL, "\"",
     "################################################\n# ITK-SnAP Label Description File\n"
     "# IDX  R G B  A  VIS  MSH  LABEL\n################################################\n",
     NULL, print_itksnap, NULL, 0, 65535, ALL | NEEDS_COLOR, '\''},
    {"xml", "a label table in XML, as of TotalSegmentator and Connectome Workbench", ".xml", "",
     "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<LabelTable>\n", "</LabelTable>\n", print_xml,
     NULL, INT32_MIN, INT32_MAX, ALL | NEEDS_COLOR, 0},
    {"csv", "a table of 3D Slicer with commas", ".csv", "",
     "LabelValue,Name,Color_R,Color_G,Color_B,Color_A\n", NULL, print_csv, NULL, -WHOLE, WHOLE,
     ALL | NEEDS_COLOR, 0},
    {"bids", "a dseg.tsv of BIDS", ".tsv", "", "index\tname\tcolor\n", NULL, print_bids, NULL,
     -WHOLE, WHOLE, HOLDS_COLOR, 0},
    {"json", "JSON", ".json", "", NULL, NULL, NULL, list_json, -WHOLE, WHOLE, ALL, 0},
    {"neuroglancer", "the segment properties of Neuroglancer", NULL, "", NULL, NULL, NULL,
     neuroglancer_json, 0, INT64_MAX, 0, 0},
    {"gifti", "a GIFTI file with a label table alone", ".gii", "",
     "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<GIFTI Version=\"1.0\" "
     "NumberOfDataArrays=\"0\">\n"
     "<LabelTable>\n",
     "</LabelTable>\n</GIFTI>\n", print_xml, NULL, INT32_MIN, INT32_MAX, ALL | NEEDS_COLOR, 0},
    {"workbench", "a label list of Connectome Workbench", NULL, "", NULL, NULL, print_workbench,
     NULL, INT32_MIN, INT32_MAX, ALL | NEEDS_COLOR, 0},
    {"names", "a class list, as of TotalSegmentator", NULL, "", NULL, NULL, print_class, NULL,
     -WHOLE, WHOLE, 0, 0},
    {"nnunet", "the dataset.json of nnU-Net", NULL, "", NULL, NULL, NULL, nnunet_json, 1, WHOLE, 0,
     0},
    {"ome-zarr", "the metadata of a label image of OME-Zarr", NULL, "", NULL, NULL, NULL, ome_json,
     -WHOLE, WHOLE, ALL, 0}};

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
    const size_t length = strlen(path);

    for (size_t i = 0; i < SC_COUNT_OF(writers); i++) {
        const size_t n = writers[i].ending ? strlen(writers[i].ending) : 0;

        if (n && length > n && !strcasecmp(path + length - n, writers[i].ending))
            return &writers[i];
    }
    return NULL;
}

const char *sc_table_writer_name(size_t i)
{
    return i < SC_COUNT_OF(writers) ? writers[i].name : NULL;
}

/* ---- rows ---- */

/* A row and its place in the table: rows of one value stay in order. */
typedef struct placed {
    const sc_label *row;
    size_t place;
} placed;

static int by_value_and_place(const void *a, const void *b)
{
    const placed *x = a, *y = b;

    if (x->row->value != y->row->value)
        return x->row->value < y->row->value ? -1 : 1;
    return x->place < y->place ? -1 : 1;
}

/* Fill in what @p label leaves open from a later row of its value. */
static void fill_in(sc_label *label, const sc_label *later)
{
    if (!label->name[0])
        memcpy(label->name, later->name, sizeof label->name);
    if (!label->has_color && later->has_color) {
        memcpy(label->rgb, later->rgb, sizeof label->rgb);
        label->has_color = true;
    }
    if (label->opacity < 0)
        label->opacity = later->opacity;
}

/* @return whether a later row of a number says something else than the label has. */
static bool differs(const sc_label *label, const sc_label *later)
{
    return (later->name[0] && strcmp(label->name, later->name) != 0) ||
           (later->has_color && memcmp(label->rgb, later->rgb, sizeof label->rgb) != 0) ||
           (later->opacity >= 0 &&
            (later->opacity < label->opacity || later->opacity > label->opacity));
}

/* List the labels of @p table by value, each once. *repeated is how many rows of numbers that stand
 * there before say something else, which is lost. Caller owns *out: sc_free.
 * @return SC_ERR_MEMORY. */
static sc_status sort_labels(const sc_ctx *ctx, const sc_label_table *table, sc_label **out,
                             size_t *count, size_t *repeated)
{
    void *order = NULL, *labels = NULL;
    placed *at;
    sc_status status;

    *count = 0;
    SC_TRY(sc_alloc(ctx, table->count + 1, sizeof(placed), &order));
    SC_TRY(sc_alloc(ctx, table->count + 1, sizeof(sc_label), &labels));
    at = order;
    for (size_t i = 0; i < table->count; i++)
        at[i] = (placed){&table->rows[i], i};
    qsort(at, table->count, sizeof *at, by_value_and_place);
    for (size_t i = 0; i < table->count; i++) {
        sc_label *last = (sc_label *)labels + *count - 1;

        if (*count && last->value == at[i].row->value) {
            fill_in(last, at[i].row);
            *repeated += differs(last, at[i].row);
        } else {
            ((sc_label *)labels)[(*count)++] = *at[i].row;
        }
    }
    *out = labels;
    labels = NULL;
out:
    sc_free(order);
    sc_free(labels);
    return status;
}

/* How many labels lose what in a format. */
typedef struct losses {
    size_t numbers, names, colors, opacities, hidden, palette;
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
    sc_text text = {0};
    sc_status status;

    SC_TRY(
        add_loss(ctx, lost->numbers, "the rows (their numbers are too large, or negative)", &text));
    SC_TRY(add_loss(ctx, lost->colors, "the colours", &text));
    SC_TRY(add_loss(ctx, lost->opacities, "the opacities", &text));
    SC_TRY(add_loss(ctx, lost->hidden, "that they are hidden,", &text));
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
    if (lost->palette)
        sc_warn(ctx,
                "%s: %zu label%s no colour, which %s needs; colours of segcast's palette are "
                "written",
                path, lost->palette, lost->palette == 1 ? " has" : "s have", writer->title);
out:
    sc_text_clear(&text);
    return status;
}

/* Append the labels as text. */
static sc_status print_lines(const sc_ctx *ctx, const sc_table_writer *writer,
                             const sc_label *labels, size_t count, sc_text *out)
{
    sc_status status = sc_text_add(ctx, out, "%s", writer->head ? writer->head : "");

    for (size_t i = 0; i < count && status == SC_OK; i++) {
        const sc_label *l = &labels[i];
        const float opacity = l->hidden ? 0 : l->opacity >= 0 ? l->opacity : 1;
        const uint8_t rgba[4] = {l->rgb[0], l->rgb[1], l->rgb[2], (uint8_t)(opacity * 255 + 0.5F)};

        status = writer->print(ctx, l, rgba, out);
    }
    if (status == SC_OK && writer->foot)
        status = sc_text_add(ctx, out, "%s", writer->foot);
    return status;
}

/* Append the labels as JSON. */
static sc_status print_json(const sc_ctx *ctx, const sc_table_writer *writer,
                            const sc_label *labels, size_t count, sc_text *out)
{
    json_t *json = writer->to_json(labels, count);
    char *text = json ? json_dumps(json, JSON_INDENT(1) | JSON_REAL_PRECISION(6)) : NULL;
    sc_status status = text ? sc_text_add(ctx, out, "%s\n", text)
                            : sc_fail(ctx, SC_ERR_MEMORY, "out of memory for a label table");

    free(text);
    json_decref(json);
    return status;
}

sc_status sc_label_table_print(const sc_ctx *ctx, const char *path, const sc_label_table *table,
                               const sc_table_writer *writer, sc_text *out)
{
    sc_label *labels = NULL;
    losses lost = {0};
    size_t count, repeated = 0;
    sc_status status;

    SC_TRY(sort_labels(ctx, table, &labels, &count, &repeated));
    if (repeated)
        sc_warn(ctx,
                "%s: %zu row%s of the table say%s something else of a number than a row before; "
                "the first row of a number is written",
                path, repeated, repeated == 1 ? "" : "s", repeated == 1 ? "s" : "");
    count = fit(writer, labels, count, &lost);
    if (count == 0) {
        status = sc_fail(ctx, SC_ERR_DATA, "%s: there is no label that %s can hold", path,
                         writer->title);
        goto out;
    }
    SC_TRY(tell_losses(ctx, path, writer, &lost));
    status = writer->print ? print_lines(ctx, writer, labels, count, out)
                           : print_json(ctx, writer, labels, count, out);
out:
    sc_free(labels);
    return status;
}
