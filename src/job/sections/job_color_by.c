/* SPDX-License-Identifier: BSD-3-Clause */
/* Colours by values: which values, and how they become colours. */
#include "key.h"
#include "segcast/job.h"

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
        return sc_yaml_fail(
            ctx, node,
            "range is [%.12g, %.12g], expected the smaller value first and another one behind it",
            ends[0], ends[1]);
    by->low = ends[0];
    by->high = ends[1];
    return SC_OK;
}

static sc_status write_range(const sc_ctx *ctx, const sc_key *key, const void *value, sc_text *text)
{
    const sc_color_by *by = value;

    return by->range_auto ? sc_text_add(ctx, text, "auto")
                          : sc_text_add(ctx, text, "[%.17g, %.17g]", by->low, by->high);
}

static const sc_value_type type_range = {
    .name = "auto or [low, high]",
    .expected = "auto, or the values of both ends of the colours, such as [0, 5]",
    .read = read_range,
    .write = write_range,
    .schema = "{anyOf: [{enum: [auto]}, " SC_SCHEMA_LIST("{type: number}", 2) "]}",
};

/* ---- the column, or key frames of columns ---- */

/* @return where the key frames of a row lie: columns[i] is the value of key frame i. */
static sc_track_room room_of(sc_column_track *track)
{
    return (sc_track_room){track->steps.keys, track->columns, sizeof *track->columns,
                           &track->steps.count, SC_KEY_FRAMES_MAX};
}

/* @return the row of the column with the type of its values. */
static sc_key heading_of(const sc_key *key)
{
    sc_key out = *key;

    out.type = &sc_type_text;
    return out;
}

/* char[]: a heading; or key frames of headings. */
static sc_status read_columns(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                              void *value)
{
    sc_column_track *track = (sc_column_track *)((char *)value + key->track);
    const sc_track_room room = room_of(track);
    const sc_key heading = heading_of(key);
    sc_status status;

    if (!sc_is_track(node))
        return sc_type_text.read(ctx, key, node, value);
    status = sc_read_key_frames(ctx, &heading, node, &room);
    for (int i = 0; i < track->steps.count; i++)
        track->steps.keys[i].value.x = i;
    return status;
}

static sc_status write_columns(const sc_ctx *ctx, const sc_key *key, const void *value,
                               sc_text *text)
{
    sc_column_track track = *(const sc_column_track *)((const char *)value + key->track);
    const sc_track_room room = room_of(&track);
    const sc_key heading = heading_of(key);

    return track.steps.count ? sc_write_key_frames(ctx, &heading, &room, text)
                             : sc_type_text.write(ctx, key, value, text);
}

static const sc_value_type type_columns = {
    .name = "text or key frames",
    .expected = "a text, or key frames such as {0s: age_20, 4s: age_40}",
    .read = read_columns,
    .write = write_columns,
    .of_key_frames = &sc_type_text,
    .schema = "{anyOf: [$text, $track]}",
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

/* A measure, or the path of a table. @p value is the whole sc_color_by. */
static sc_status read_values(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    sc_color_by *by = value;

    for (const sc_choice *one = measures; one->word && node->kind == SC_YAML_SCALAR; one++)
        by->has_measure = by->has_measure || !strcmp(one->word, node->text);
    return by->has_measure ? sc_type_choice.read(ctx, key, node, &by->measure)
                           : sc_type_text.read(ctx, key, node, by->table);
}

static sc_status write_values(const sc_ctx *ctx, const sc_key *key, const void *value,
                              sc_text *text)
{
    const sc_color_by *by = value;

    return by->has_measure ? sc_type_choice.write(ctx, key, &by->measure, text)
                           : sc_type_text.write(ctx, key, by->table, text);
}

static const sc_value_type type_values = {
    .name = "volume, thickness, surface or text",
    .expected = "volume, thickness, surface, or the path of a table",
    .read = read_values,
    .write = write_values,
    .schema = "$text",
};

#define BY(member) offsetof(sc_color_by, member)
_Static_assert(sizeof(((sc_color_by *)0)->table) == SC_PATH_BYTES, "a path of a job fits");

const sc_key sc_color_by_keys[] = {
    {"values", &type_values, 0, NULL,
     .help = "what segcast measures itself: volume, (mean) thickness or surface of the tissue; or "
             "a table of values (CSV or TSV) with a line of headings, one of which names the "
             "number or the name of the tissue",
     .bytes = SC_PATH_BYTES, .choices = measures, .required = true, .scope.outside_identity = true},
    {"column", &type_columns, BY(column), "\"\"",
     .help = "heading of the values in the table; empty: the only column that can hold them; may "
             "have key frames, and between two of them every tissue goes from its value in one "
             "column to that in the other",
     .bytes = sizeof(((sc_color_by *)0)->column),
     .track = offsetof(sc_job, color_columns) - offsetof(sc_job, color_by) - BY(column),
     .scope.outside_identity = true},
    {"map", &sc_type_choice, BY(map), "viridis",
     .help = "colours from the least to the greatest value; coolwarm is for values on both sides "
             "of a middle, such as changes",
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
