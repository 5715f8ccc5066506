/* SPDX-License-Identifier: BSD-3-Clause */
/* Label tables in JSON: the properties of segments of Neuroglancer, the metadata of label images of
 * OME-Zarr, ontologies of the Allen Institute and BrainGlobe, the colour maps of NiiVue, the labels
 * of a data set of nnU-Net, the segments of dcmqi, and plain lists and maps. Objects become rows of
 * columns, whose headings are the names of their members. */
#include "tables/label_table.h"

#include <jansson.h>
#include <string.h>

enum { NUMBERS_BYTES = 128 /* room for a number, or for those of a colour, as text */ };

/* The table while the document is read. */
typedef struct json_reading {
    const sc_ctx *ctx;
    const char *path; /* for messages */
    sc_column_rows rows;
    bool any;      /* a label was read */
    size_t unread; /* entries that are no label */
    sc_status status;
} json_reading;

/* One row on its way into the table: a field for each column. */
typedef struct json_row {
    sc_column columns[SC_COLUMNS_MAX];
    const char *fields[SC_COLUMNS_MAX];
    char numbers[SC_COLUMNS_MAX][NUMBERS_BYTES]; /* fields that are no strings of the document */
    size_t count;
} json_row;

/* @return level @p i of a colour whose levels are the members of @p object: {"r": 255, ...}; NULL
 * if there is none. */
static const json_t *level_of(const json_t *object, size_t i)
{
    static const char *const names[4][3] = {
        {"r", "red", "R"}, {"g", "green", "G"}, {"b", "blue", "B"}, {"a", "alpha", "A"}};
    const json_t *level = NULL;

    for (size_t k = 0; k < SC_COUNT_OF(names[0]) && !level; k++)
        level = json_object_get(object, names[i][k]);
    return level;
}

/* Write a number, a list of numbers, or the levels of a colour, to out[NUMBERS_BYTES]; an empty
 * text for anything else, and for more than there is room for. */
static void print_numbers(const json_t *value, char *out)
{
    const bool is_color = json_is_object(value);
    const size_t count = json_is_array(value) ? json_array_size(value)
                         : is_color           ? (level_of(value, 3) ? 4 : 3)
                                              : 1;
    size_t used = 0;

    out[0] = '\0';
    for (size_t i = 0; i < count; i++) {
        const json_t *number = json_is_array(value) ? json_array_get(value, i)
                               : is_color           ? level_of(value, i)
                                                    : value;

        if (!json_is_number(number) || used >= NUMBERS_BYTES - 32) {
            out[0] = '\0';
            return;
        }
        used += (size_t)(json_is_integer(number) ? snprintf(out + used, 32, "%s%lld", i ? "," : "",
                                                            (long long)json_integer_value(number))
                                                 : snprintf(out + used, 32, "%s%.17g", i ? "," : "",
                                                            json_real_value(number)));
    }
}

/* Add a field; nothing if the row is full. @param value NULL: the field is empty. */
static void add_field(json_row *row, sc_column column, const json_t *value)
{
    char *numbers;

    if (row->count == SC_COLUMNS_MAX)
        return;
    numbers = row->numbers[row->count];
    row->columns[row->count] = column;
    row->fields[row->count] = numbers;
    if (json_is_string(value))
        row->fields[row->count] = json_string_value(value);
    else if (json_is_boolean(value))
        snprintf(numbers, NUMBERS_BYTES, "%s", json_is_true(value) ? "yes" : "no");
    else
        print_numbers(value, numbers);
    row->count++;
}

/* As add_field, for a text. */
static void add_text(json_row *row, sc_column column, const char *text)
{
    if (row->count == SC_COLUMNS_MAX)
        return;
    row->columns[row->count] = column;
    row->fields[row->count++] = text;
}

/* Give a row to the table. */
static void finish_row(json_reading *r, json_row *row)
{
    bool read = false;

    if (sc_columns_settle(row->columns, row->count) && r->status == SC_OK)
        r->status =
            sc_column_rows_add(r->ctx, &r->rows, row->columns, row->fields, row->count, &read);
    r->any = r->any || read;
    r->unread += !read;
}

/* Add the members of @p object, whose names are headings. */
static void add_members(json_row *row, json_t *object)
{
    const char *key;
    json_t *value;

    json_object_foreach(object, key, value) add_field(row, sc_column_of(key), value);
}

/* Is @p text a whole number? */
static bool is_number(const char *text)
{
    return *text && strspn(text, "0123456789") == strlen(text);
}

/* Read a list of labels: objects, or names in the order of the numbers from 0 on. */
static void read_list(json_reading *r, const json_t *list)
{
    const size_t count = json_array_size(list);

    for (size_t i = 0; i < count && r->status == SC_OK; i++) {
        json_t *item = json_array_get(list, i), *data = json_object_get(item, "data");
        char number[32];
        json_row row;

        row.count = 0;
        snprintf(number, sizeof number, "%zu", i);
        if (json_is_string(item)) {
            if (!json_string_length(item)) /* there is no label of this number */
                continue;
            add_text(&row, SC_COLUMN_VALUE, number);
            add_field(&row, SC_COLUMN_NAME, item);
        } else if (json_is_object(item)) {
            add_members(&row, json_is_object(data) ? data : item); /* ABBA: a node and its data */
        }
        finish_row(r, &row);
    }
}

/* Read a list of labels, or one, and the lists "children" in them, as ontologies have them: level
 * by level, since a document may be deeper than a stack. */
static void read_tree(json_reading *r, json_t *top)
{
    json_t *nodes = json_is_array(top) ? json_copy(top) : json_pack("[O]", top);
    int failed = !nodes;

    for (size_t i = 0; i < json_array_size(nodes) && !failed; i++) {
        json_t *children = json_object_get(json_array_get(nodes, i), "children");

        failed = json_array_size(children) && json_array_extend(nodes, children);
    }
    if (failed)
        r->status = sc_fail(r->ctx, SC_ERR_MEMORY, "%s: out of memory", r->path);
    read_list(r, nodes);
    json_decref(nodes);
}

/* Read a map: from numbers to names, colours or objects, or from names to numbers or to objects. */
static void read_map(json_reading *r, json_t *map)
{
    const char *key;
    json_t *value;

    json_object_foreach(map, key, value)
    {
        const bool numbered = is_number(key);
        json_row row;

        row.count = 0;
        if (json_is_object(value)) {
            add_text(&row, numbered ? SC_COLUMN_VALUE : SC_COLUMN_NAME, key);
            add_members(&row, value);
        } else if (numbered && json_is_string(value)) {
            add_text(&row, SC_COLUMN_VALUE, key);
            add_field(&row, *json_string_value(value) == '#' ? SC_COLUMN_COLOR : SC_COLUMN_NAME,
                      value);
        } else if (!numbered && json_is_integer(value)) {
            add_field(&row, SC_COLUMN_VALUE, value);
            add_text(&row, SC_COLUMN_NAME, key);
        }
        finish_row(r, &row);
        if (r->status != SC_OK)
            return;
    }
}

/* Read an object of columns, lists whose names are headings, if @p object is one: colours and names
 * of NiiVue, in which the column of numbers may be missing. @return whether it is. */
static bool read_columns(json_reading *r, json_t *object)
{
    const json_t *lists[SC_COLUMNS_MAX];
    sc_column columns[SC_COLUMNS_MAX];
    size_t count = 0, rows = 0;
    bool numbered = false;
    const char *key;
    json_t *value;

    json_object_foreach(object, key, value)
    {
        const sc_column column = sc_column_of(key);

        if (count == SC_COLUMNS_MAX || column == SC_COLUMN_OTHER || !json_is_array(value) ||
            json_is_object(json_array_get(value, 0)))
            continue;
        rows = count && rows < json_array_size(value) ? rows : json_array_size(value);
        numbered = numbered || column == SC_COLUMN_VALUE;
        lists[count] = value;
        columns[count++] = column;
    }
    if (count < 2)
        return false;
    for (size_t i = 0; i < rows && r->status == SC_OK; i++) {
        char number[32];
        json_row row;

        row.count = 0;
        snprintf(number, sizeof number, "%zu", i);
        if (!numbered)
            add_text(&row, SC_COLUMN_VALUE, number);
        for (size_t k = 0; k < count; k++)
            add_field(&row, columns[k], json_array_get(lists[k], i));
        finish_row(r, &row);
    }
    return true;
}

/* Read the segments of Neuroglancer: ids, and the names at the same places of the property of the
 * type "label", or else of the first one that holds texts. */
static void read_neuroglancer(json_reading *r, const json_t *segments)
{
    const json_t *ids = json_object_get(segments, "ids"), *names = NULL;
    const json_t *properties = json_object_get(segments, "properties");

    for (size_t i = 0; i < json_array_size(properties); i++) {
        const json_t *property = json_array_get(properties, i);
        const json_t *values = json_object_get(property, "values");
        const char *type = json_string_value(json_object_get(property, "type"));
        const bool is_label = type && !strcmp(type, "label");

        if (is_label || (!names && json_is_string(json_array_get(values, 0))))
            names = values;
        if (is_label)
            break;
    }
    for (size_t i = 0; i < json_array_size(ids) && r->status == SC_OK; i++) {
        json_row row;

        row.count = 0;
        add_field(&row, SC_COLUMN_VALUE, json_array_get(ids, i));
        add_field(&row, SC_COLUMN_NAME, json_array_get(names, i));
        finish_row(r, &row);
    }
}

/* @return the metadata of a label image of OME-Zarr in @p root, whatever the version; NULL if there
 * is none. */
static const json_t *ome_labels(const json_t *root)
{
    const json_t *attributes = json_object_get(root, "attributes"); /* of Zarr 3 */
    const json_t *at = attributes ? attributes : root;
    const json_t *ome = json_object_get(at, "ome"); /* since OME-Zarr 0.5 */

    return json_object_get(ome ? ome : at, "image-label");
}

/* @return the list "total", or else the first, if the members of @p root are all maps from numbers
 * to names, as the class lists of TotalSegmentator are; NULL if they are something else. */
static json_t *class_list(const json_reading *r, json_t *root)
{
    const char *key, *chosen = NULL;
    json_t *value, *list = NULL;

    json_object_foreach(root, key, value)
    {
        const void *first = json_object_iter(value);

        if (!first || !is_number(json_object_iter_key((void *)first)) ||
            !json_is_string(json_object_iter_value((void *)first)) || is_number(key))
            return NULL;
        if (!chosen || !strcmp(key, "total")) {
            chosen = key;
            list = value;
        }
    }
    if (chosen && json_object_size(root) > 1)
        sc_info(r->ctx, "%s: of its %zu lists of classes, \"%s\" is read", r->path,
                json_object_size(root), chosen);
    return list;
}

/* Read the segments of DICOM as dcmqi describes them: a list of lists of objects. */
static void read_segment_attributes(json_reading *r, const json_t *lists)
{
    for (size_t i = 0; i < json_array_size(lists) && r->status == SC_OK; i++)
        read_list(r, json_array_get(lists, i));
}

/* @return the map from numbers to colours of a state of Neuroglancer, or of one of its layers; NULL
 * if there is none. */
static json_t *segment_colors(json_t *root)
{
    const json_t *layers = json_object_get(root, "layers");
    json_t *colors = json_object_get(root, "segmentColors");

    for (size_t i = 0; i < json_array_size(layers) && !colors; i++)
        colors = json_object_get(json_array_get(layers, i), "segmentColors");
    return colors;
}

/* Read a document of one of the programs whose JSON is told by its members. @return whether it is
 * one. */
static bool read_known(json_reading *r, json_t *root)
{
    const json_t *ome = ome_labels(root), *inner = json_object_get(root, "inline");
    const json_t *attributes = json_object_get(root, "segmentAttributes");

    if (ome) {
        read_list(r, json_object_get(ome, "colors"));
        read_list(r, json_object_get(ome, "properties"));
    } else if (json_object_get(inner, "ids")) {
        read_neuroglancer(r, inner);
    } else if (attributes) {
        read_segment_attributes(r, attributes);
    } else if (segment_colors(root)) {
        read_map(r, segment_colors(root));
    } else {
        return false;
    }
    return true;
}

/* Read the document by what it holds. */
static void read_document(json_reading *r, json_t *root)
{
    static const char *const names[] = {"labels",  "segments",    "tissues", "structures",
                                        "regions", "label_table", "rois",    "msg"};
    json_t *classes, *top = json_object_get(root, "root");

    top = json_object_get(top, "children") ? top : root;
    if (json_is_array(top) || json_is_array(json_object_get(top, "children"))) {
        read_tree(r, top);
        return;
    }
    if (read_known(r, root) || read_columns(r, root))
        return;
    for (size_t i = 0; i < SC_COUNT_OF(names); i++) {
        json_t *labels = json_object_get(root, names[i]);

        if (json_is_array(labels)) {
            read_tree(r, labels);
            return;
        }
        if (json_is_object(labels)) {
            read_map(r, labels);
            return;
        }
    }
    classes = class_list(r, root);
    read_map(r, classes ? classes : root);
}

/* Read the text as JSON. @return SC_ERR_DATA, SC_ERR_MEMORY, logged. Caller owns *out. */
static sc_status load(const sc_ctx *ctx, const char *path, const char *text, size_t bytes,
                      json_t **out)
{
    json_error_t error;

    if (bytes > SC_JSON_BYTES_MAX)
        return sc_fail(
            ctx, SC_ERR_DATA,
            "%s: has %zu bytes of JSON; expected at most %d: keep the rows of the labels "
            "in the volume",
            path, bytes, SC_JSON_BYTES_MAX);
    *out = json_loadb(text, bytes, 0, &error);
    if (*out)
        return SC_OK;
    if (json_error_code(&error) == json_error_out_of_memory)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", path);
    return sc_fail(ctx, SC_ERR_DATA, "%s:%d: is no JSON: %s", path, error.line, error.text);
}

sc_status sc_label_json_parse(const sc_ctx *ctx, const char *path, const char *text, size_t bytes,
                              sc_label_table *table)
{
    json_t *root = NULL;
    sc_status status = load(ctx, path, text, bytes, &root);

    if (status == SC_OK)
        status = sc_label_json_read(ctx, path, root, table);
    json_decref(root);
    return status;
}

sc_status sc_label_json_read(const sc_ctx *ctx, const char *path, json_t *root,
                             sc_label_table *table)
{
    json_reading r = {.ctx = ctx, .path = path, .rows = sc_column_rows_begin(table)};

    read_document(&r, root);
    sc_column_rows_end(ctx, path, &r.rows);
    if (r.status == SC_ERR_DATA)
        return sc_fail(
            ctx, r.status,
            "%s: more than %d rows, but a volume has at most %d labels; keep the rows of "
            "the labels in the volume",
            path, SC_TABLE_ROWS_MAX, SC_LABELS_MAX - 1);
    if (r.status == SC_OK && !r.any)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: holds no label table that segcast knows; expected for example "
                       "[{\"value\": 1, \"name\": \"aorta\", \"color\": \"#ff0000\"}]",
                       path);
    if (r.status == SC_OK && r.unread)
        sc_warn(ctx, "%s: %zu entr%s no number and name or colour of a label and %s not used", path,
                r.unread, r.unread == 1 ? "y has" : "ies have", r.unread == 1 ? "is" : "are");
    return r.status;
}
