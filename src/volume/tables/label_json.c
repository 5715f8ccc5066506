/* SPDX-License-Identifier: BSD-3-Clause */
/* Label tables in JSON: the properties of segments of Neuroglancer, the metadata of label images of
 * OME-Zarr, ontologies of the Allen Institute and BrainGlobe, the colour maps of NiiVue, the labels
 * of a data set of nnU-Net, the segments of dcmqi, the groups of labels of MITK, and plain lists
 * and maps. Objects become rows of columns, whose headings are the names of their members. */
#include "tables/label_table.h"

#include <jansson.h>
#include <stdlib.h>

/* The table while the document is read. */
typedef struct json_reading {
    sc_rows rows;
    sc_row row;
} json_reading;

#define UNKNOWN                                                                                    \
    "holds no label table that segcast knows; expected for example "                               \
    "[{\"value\": 1, \"name\": \"aorta\", \"color\": \"#ff0000\"}]"
static const sc_dialect dialect = {.where = {"", ""},
                                   .rows = {"entry", "entries"},
                                   .lack = "no number and name or colour of a label",
                                   .refused = UNKNOWN,
                                   .empty = UNKNOWN};

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

/* Write a number, a list of numbers, or the levels of a colour, to out[SC_FIELD_BYTES]; an empty
 * text for anything else, and for more than there is room for. */
static void print_numbers(const json_t *value, char *out)
{
    const json_t *inner = json_object_get(value, "value"); /* of a property of MITK */
    const bool is_color = json_is_object(value) && !inner;
    const json_t *from = inner ? inner : value;
    const size_t count = json_is_array(from) ? json_array_size(from)
                         : is_color          ? (level_of(from, 3) ? 4 : 3)
                                             : 1;
    size_t used = 0;

    for (size_t i = 0; i < count; i++) {
        const json_t *number = json_is_array(from) ? json_array_get(from, i)
                               : is_color          ? level_of(from, i)
                                                   : from;

        if (!json_is_number(number) || used >= SC_FIELD_BYTES - 32) {
            out[0] = '\0';
            return;
        }
        used += (size_t)(json_is_integer(number) ? snprintf(out + used, 32, "%s%lld", i ? "," : "",
                                                            (long long)json_integer_value(number))
                                                 : snprintf(out + used, 32, "%s%.17g", i ? "," : "",
                                                            json_real_value(number)));
    }
}

/* Add a field. @param value NULL: it is empty. */
static void add_field(json_reading *r, sc_column column, const json_t *value)
{
    char *text = sc_row_add(&r->row, column,
                            json_is_boolean(value) ? (json_is_true(value) ? "yes" : "no")
                                                   : json_string_value(value));

    if (text && !json_is_boolean(value))
        print_numbers(value, text);
}

/* Add a field with the number @p i. */
static void add_number(json_reading *r, size_t i)
{
    char *text = sc_row_add(&r->row, SC_COLUMN_VALUE, NULL);

    if (text)
        snprintf(text, SC_FIELD_BYTES, "%zu", i);
}

/* Add the members of @p object, whose names are headings. */
static void add_members(json_reading *r, json_t *object)
{
    const char *key;
    json_t *value;

    json_object_foreach(object, key, value) add_field(r, sc_column_of(key), value);
}

/* Give the row to the table, and begin the next one. @param may_lack it is not told if it is none.
 */
static void finish_row(json_reading *r, bool may_lack)
{
    if (sc_columns_settle(r->row.columns, r->row.count))
        sc_rows_add(&r->rows, &r->row);
    else if (!may_lack)
        sc_rows_skip(&r->rows, 0);
    r->row.count = 0;
}

/* Is @p text a whole number? */
static bool is_number(const char *text)
{
    return *text && strspn(text, "0123456789") == strlen(text);
}

/* @return the list in which the nodes below a node of a tree stand: it may be one itself. */
static json_t *nodes_below(json_t *node)
{
    json_t *children = json_object_get(node, "children");

    if (json_is_array(node))
        return node;
    return json_is_array(children) ? children : json_object_get(node, "labels"); /* of MITK */
}

/* Read a list of labels, or one, and the lists in them, as ontologies have them: objects, or names
 * in the order of the numbers from 0 on. It goes level by level, since a document may be deeper
 * than a stack. */
static void read_tree(json_reading *r, json_t *top)
{
    json_t *nodes = json_is_array(top) ? json_copy(top) : json_pack("[O]", top);
    int failed = !nodes;

    for (size_t i = 0; i < json_array_size(nodes) && !failed && r->rows.status == SC_OK; i++) {
        json_t *item = json_array_get(nodes, i), *data = json_object_get(item, "data");
        json_t *below = nodes_below(item);

        failed = json_array_size(below) && json_array_extend(nodes, below);
        if (json_is_array(item) || (json_is_string(item) && !json_string_length(item)))
            continue; /* there is no label of this number */
        if (json_is_string(item)) {
            add_number(r, i);
            add_field(r, SC_COLUMN_NAME, item);
        }
        add_members(r, json_is_object(data) ? data : item); /* ABBA: a node and its data */
        finish_row(r, json_is_array(below));
    }
    if (failed)
        r->rows.status = sc_fail(r->rows.ctx, SC_ERR_MEMORY, "%s: out of memory", r->rows.path);
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
        const bool is_name = json_is_string(value) && *json_string_value(value) != '#';

        if (json_is_object(value) || (numbered ? json_is_string(value) : json_is_integer(value))) {
            (void)sc_row_add(&r->row, numbered ? SC_COLUMN_VALUE : SC_COLUMN_NAME, key);
            if (json_is_object(value))
                add_members(r, value);
            else
                add_field(r,
                          !numbered ? SC_COLUMN_VALUE
                          : is_name ? SC_COLUMN_NAME
                                    : SC_COLUMN_COLOR,
                          value);
        }
        finish_row(r, false);
    }
}

static void read_any(json_reading *r, json_t *labels)
{
    if (json_is_array(labels))
        read_tree(r, labels);
    else
        read_map(r, labels);
}

/* Read columns, lists of fields. The numbers count the rows from 0 on if no column has them. */
static void read_lists(json_reading *r, const json_t *const *lists, const sc_column *columns,
                       size_t count, size_t rows)
{
    bool numbered = false;

    for (size_t k = 0; k < count; k++)
        numbered = numbered || columns[k] == SC_COLUMN_VALUE;
    for (size_t i = 0; i < rows; i++) {
        if (!numbered)
            add_number(r, i);
        for (size_t k = 0; k < count; k++)
            add_field(r, columns[k], json_array_get(lists[k], i));
        finish_row(r, false);
    }
}

/* Read an object of columns, lists whose names are headings, if @p object is one: colours and names
 * of NiiVue. @return whether it is. */
static bool read_columns(json_reading *r, json_t *object)
{
    const json_t *lists[SC_COLUMNS_MAX];
    sc_column columns[SC_COLUMNS_MAX];
    size_t count = 0, rows = 0;
    const char *key;
    json_t *value;

    json_object_foreach(object, key, value)
    {
        const sc_column column = sc_column_of(key);

        if (count == SC_COLUMNS_MAX || column == SC_COLUMN_OTHER || !json_is_array(value) ||
            json_is_object(json_array_get(value, 0)))
            continue;
        rows = count && rows < json_array_size(value) ? rows : json_array_size(value);
        lists[count] = value;
        columns[count++] = column;
    }
    if (count >= 2)
        read_lists(r, lists, columns, count, rows);
    return count >= 2;
}

/* Read the segments of Neuroglancer: ids, and the names at the same places of the property of the
 * type "label", or else of the first one that holds texts. */
static void read_neuroglancer(json_reading *r, const json_t *segments)
{
    static const sc_column columns[] = {SC_COLUMN_VALUE, SC_COLUMN_NAME};
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
    read_lists(r, (const json_t *const[]){ids, names}, columns, 2, json_array_size(ids));
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
 * to names, as the class lists of TotalSegmentator are; @p root if they are something else. */
static json_t *class_list(const json_reading *r, json_t *root)
{
    const char *key, *chosen = NULL;
    json_t *value, *list = root;

    json_object_foreach(root, key, value)
    {
        void *first = json_object_iter(value);

        if (!first || !is_number(json_object_iter_key(first)) ||
            !json_is_string(json_object_iter_value(first)) || is_number(key))
            return root;
        if (!chosen || !strcmp(key, "total")) {
            chosen = key;
            list = value;
        }
    }
    if (chosen && json_object_size(root) > 1)
        sc_info(r->rows.ctx, "%s: of its %zu lists of classes, \"%s\" is read", r->rows.path,
                json_object_size(root), chosen);
    return list;
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

/* Read the document by what it holds. */
static void read_document(json_reading *r, json_t *root)
{
    static const char *const names[] = {"segmentAttributes", "labels",     "segments",
                                        "tissues",           "structures", "regions",
                                        "label_table",       "rois",       "msg"};
    json_t *top = json_object_get(root, "root"), *inner = json_object_get(root, "inline");
    const json_t *ome = ome_labels(root);

    top = json_object_get(top, "children") ? top : root;
    if (json_is_array(top) || json_is_array(json_object_get(top, "children"))) {
        read_tree(r, top);
    } else if (ome) {
        read_any(r, json_object_get(ome, "colors"));
        read_any(r, json_object_get(ome, "properties"));
    } else if (json_object_get(inner, "ids")) {
        read_neuroglancer(r, inner);
    } else if (segment_colors(root)) {
        read_map(r, segment_colors(root));
    } else if (!read_columns(r, root)) {
        json_t *labels = NULL;

        for (size_t i = 0; i < SC_COUNT_OF(names) && !labels; i++) {
            labels = json_object_get(root, names[i]);
            labels = json_is_array(labels) || json_is_object(labels) ? labels : NULL;
        }
        read_any(r, labels ? labels : class_list(r, root));
    }
}

/* Whether jansson has been denied memory since the thread last began to read a document: it calls
 * that an invalid document. */
static _Thread_local bool is_denied;

static void *note_denied(size_t bytes)
{
    void *block = malloc(bytes);

    is_denied = is_denied || !block;
    return block;
}

json_t *sc_json_load(const char *text, size_t bytes, json_error_t *error)
{
    json_malloc_t now;
    json_free_t other;
    json_t *root;

    json_get_alloc_funcs(&now, &other);
    if (now != note_denied) /* once in a process: blocks of both are freed alike */
        json_set_alloc_funcs(note_denied, free);
    is_denied = false;
    root = json_loadb(text, bytes, 0, error);
    if (is_denied) { /* a string of more than 16 bytes may lack one then, and nothing tells it */
        json_decref(root);
        return NULL;
    }
    return root;
}

bool sc_json_lacks_memory(const json_error_t *error)
{
    return is_denied || !error->text[0] || json_error_code(error) == json_error_out_of_memory;
}

sc_status sc_label_json_parse(const sc_ctx *ctx, const char *path, const char *text, size_t bytes,
                              sc_label_table *table)
{
    json_auto_t *root = NULL;
    json_error_t error;

    if (bytes > SC_JSON_BYTES_MAX)
        return sc_fail(
            ctx, SC_ERR_DATA,
            "%s: has %zu bytes of JSON; expected at most %d: keep the rows of the labels "
            "in the volume",
            path, bytes, SC_JSON_BYTES_MAX);
    root = sc_json_load(text, bytes, &error);
    if (root)
        return sc_label_json_read(ctx, path, root, table);
    if (sc_json_lacks_memory(&error))
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", path);
    return sc_fail(ctx, SC_ERR_DATA, "%s:%d: is no JSON: %s", path, error.line, error.text);
}

sc_status sc_label_json_read(const sc_ctx *ctx, const char *path, json_t *root,
                             sc_label_table *table)
{
    json_reading r = {.rows = sc_rows_begin(ctx, path, &dialect, table)};

    read_document(&r, root);
    return sc_rows_end(&r.rows);
}
