/* SPDX-License-Identifier: BSD-3-Clause */
/* Colours by values: which values, and how they become colours. */
#include "key.h"
#include "segcast/job.h"

#include <string.h>

/* "auto", or the values of both ends. @p value is the whole sc_color_by. */
static sc_status read_range(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    sc_color_by *by = value;
    double ends[2];

    by->range_auto = node->kind == SC_YAML_SCALAR && !strcmp(node->text, "auto");
    if (by->range_auto)
        return SC_OK;
    if (node->kind != SC_YAML_LIST || node->count != 2 ||
        !sc_parse_number(node->items[0], &ends[0]) || !sc_parse_number(node->items[1], &ends[1]))
        return sc_wrong_type(ctx, node, key->type->expected);
    if (!(ends[0] < ends[1]))
        return sc_yaml_fail(ctx, node,
                            "range is [%.12g, %.12g], expected the smaller value first and another "
                            "one behind it",
                            ends[0], ends[1]);
    by->low = ends[0];
    by->high = ends[1];
    return SC_OK;
}

static sc_status write_range(const sc_ctx *ctx, const sc_key *key, const void *value, int indent,
                             sc_text *text)
{
    const sc_color_by *by = value;

    (void)key;
    (void)indent;
    return by->range_auto ? sc_text_add(ctx, text, "auto")
                          : sc_text_add(ctx, text, "[%.17g, %.17g]", by->low, by->high);
}

static json_t *range_schema(const sc_key *key)
{
    (void)key;
    return json_pack("{s:[{s:[s]}, {s:s, s:{s:s}, s:i, s:i}]}", "anyOf", "enum", "auto", "type",
                     "array", "items", "type", "number", "minItems", 2, "maxItems", 2);
}

static const sc_value_type type_range = {
    .name = "auto or [low, high]",
    .expected = "auto, or the values of both ends of the colours, such as [0, 5]",
    .read = read_range,
    .write = write_range,
    .schema = range_schema,
};

/* ---- the column, or key frames of columns ---- */

/* A key frame while it is read and written. */
typedef struct column_key {
    sc_key_frame frame;
    char column[SC_NAME_BYTES];
} column_key;

static const sc_key column_rows[] = {
    {"at", &sc_type_key_time, offsetof(column_key, frame.at), .help = "when", .required = true},
    {"value", &sc_type_text, offsetof(column_key, column), .help = "heading of the values then",
     .bytes = SC_NAME_BYTES, .required = true},
    {"ease", &sc_type_ease, offsetof(column_key, frame.ease), "linear",
     .help = "how the change from the key frame before begins and ends"},
    {0}};

/* Read key frame @p i of a list; it has to come after the one before it. @return the first mistake;
 * all are logged. */
static sc_status read_column_key(const sc_ctx *ctx, const sc_key *key, const sc_yaml *list,
                                 size_t i, sc_column_track *track)
{
    sc_key_frame *keys = track->steps.keys;
    column_key read = {0};
    sc_status status;

    if (list->items[i]->kind != SC_YAML_MAP)
        return sc_wrong_type(ctx, list, key->type->expected);
    status = sc_keys_read(ctx, column_rows, list->items[i], &read);
    if (status != SC_OK)
        return status;
    keys[i] = read.frame;
    keys[i].value.x = (double)i;
    memcpy(track->columns[i], read.column, sizeof read.column);
    return i == 0 || sc_track_rises(keys[i - 1].at, keys[i].at) ? SC_OK
                                                                : sc_track_disorder(ctx, list, i);
}

/* char[]: a heading; or key frames of headings. */
static sc_status read_columns(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                              void *value)
{
    sc_column_track *track = (sc_column_track *)((char *)value + key->track);
    sc_status status = SC_OK;

    if (!sc_is_track(node))
        return sc_type_text.read(ctx, key, node, value);
    if (node->count == 0 || node->count > SC_KEY_FRAMES_MAX)
        return sc_yaml_fail(ctx, node, "%s has %zu key frames, expected 1 to %d", node->key,
                            node->count, SC_KEY_FRAMES_MAX);
    for (size_t i = 0; i < node->count && status == SC_OK; i++)
        status = read_column_key(ctx, key, node, i, track);
    if (status == SC_OK)
        track->steps.count = (int)node->count;
    return status;
}

static sc_status write_columns(const sc_ctx *ctx, const sc_key *key, const void *value, int indent,
                               sc_text *text)
{
    const sc_column_track *track = (const sc_column_track *)((const char *)value + key->track);
    sc_status status = SC_OK;

    if (!track->steps.count)
        return sc_type_text.write(ctx, key, value, indent, text);
    for (int i = 0; i < track->steps.count && status == SC_OK; i++) {
        column_key written = {.frame = track->steps.keys[i]};

        memcpy(written.column, track->columns[i], sizeof written.column);
        SC_TRY(sc_text_add(ctx, text, i ? ", " : "["));
        status = sc_keys_write_flow(ctx, column_rows, &written, text);
    }
    if (status == SC_OK)
        status = sc_text_add(ctx, text, "]");
out:
    return status;
}

static json_t *columns_schema(const sc_key *key)
{
    return json_pack("{s:[o, {s:s, s:i, s:i, s:o}]}", "anyOf", sc_type_text.schema(key), "type",
                     "array", "minItems", 1, "maxItems", SC_KEY_FRAMES_MAX, "items",
                     sc_keys_schema(column_rows));
}

static const sc_value_type type_columns = {
    .name = "text or key frames",
    .expected = "a text, or key frames such as [{at: 0s, value: age_20}, {at: 4s, value: age_40}]",
    .read = read_columns,
    .write = write_columns,
    .schema = columns_schema,
};

/* ---- measures and maps ---- */

static const sc_choice measures[] = {{"volume", SC_MEASURE_VOLUME},
                                     {"thickness", SC_MEASURE_THICKNESS},
                                     {"surface", SC_MEASURE_SURFACE},
                                     {NULL, 0}};
static const sc_choice color_maps[] = {{"viridis", SC_MAP_VIRIDIS},
                                       {"cividis", SC_MAP_CIVIDIS},
                                       {"magma", SC_MAP_MAGMA},
                                       {"inferno", SC_MAP_INFERNO},
                                       {"plasma", SC_MAP_PLASMA},
                                       {"coolwarm", SC_MAP_COOLWARM},
                                       {NULL, 0}};

#define BY(member) offsetof(sc_color_by, member)
_Static_assert(sizeof(((sc_color_by *)0)->table) == SC_PATH_BYTES, "a path of a job fits");

const sc_key sc_color_by_keys[] = {
    {"table", &sc_type_text, BY(table), NULL,
     .help = "table of values (CSV or TSV) with a line of headings, one of which names the number "
             "or the name of the tissue",
     .bytes = SC_PATH_BYTES, .alternative = "table or measure", .required = true,
     .outside_identity = true, .without = "none"},
    {"column", &type_columns, BY(column), "\"\"",
     .help = "heading of the values in the table; empty: the only column that can hold them; may "
             "have key frames, and between two of them every tissue goes from its value in one "
             "column to that in the other",
     .bytes = sizeof(((sc_color_by *)0)->column),
     .track = offsetof(sc_job, color_columns) - offsetof(sc_job, color_by) - BY(column),
     .outside_identity = true},
    {"measure", &sc_type_choice, BY(measure), NULL,
     .help = "what segcast measures itself, instead of a table: volume, mean thickness or surface "
             "of the tissue",
     .choices = measures, .alternative = "table or measure",
     .given = SC_GIVEN(sc_color_by, has_measure), .without = "the table"},
    {"map", &sc_type_choice, BY(map), "viridis",
     .help =
         "colours from the least to the greatest value; coolwarm is for values on both sides of "
         "a middle, such as changes",
     .choices = color_maps},
    {"range", &type_range, 0, "auto",
     .help = "values of the ends of the map; auto: those of the tissues that are shown, with 0 in "
             "the middle of coolwarm if there are values on both sides of it"},
    {"missing", &sc_type_color, BY(missing), "[176, 176, 176]",
     .help = "colour of tissues without a value"},
    {"title", &sc_type_text, BY(title), "\"\"",
     .help = "title of the colour bar; empty: the heading of the column (of the first and the last "
             "one), or the measure",
     .bytes = sizeof(((sc_color_by *)0)->title)},
    {0}};
