/* SPDX-License-Identifier: BSD-3-Clause */
/* Values that change with time: easing, and key frames. */
#include "key.h"
#include "segcast/timeline.h"

#include <string.h>

/* ---- easing ---- */

static const char *const ease_words[] = {"linear", "smooth", "in", "out"}; /* by sc_ease_kind */

/* sc_ease: one of the words, or the four numbers of a curve. */
static sc_status read_ease(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    sc_ease ease = {.kind = SC_EASE_BEZIER};

    if (node->kind == SC_YAML_SCALAR) {
        for (int i = 0; i < (int)SC_COUNT_OF(ease_words); i++) {
            if (!strcmp(node->text, ease_words[i])) {
                *(sc_ease *)value = (sc_ease){.kind = (sc_ease_kind)i};
                return SC_OK;
            }
        }
        return sc_no_such_word(ctx, key, node, node->text, ease_words, SC_COUNT_OF(ease_words));
    }
    if (node->kind != SC_YAML_LIST || node->count != SC_COUNT_OF(ease.bezier))
        return sc_wrong_type(ctx, node, key->type->expected);
    for (size_t i = 0; i < SC_COUNT_OF(ease.bezier); i++) {
        double *number = &ease.bezier[i];

        if (!sc_parse_number(node->items[i], number) || *number < 0 || *number > 1)
            return sc_wrong_type(ctx, node, key->type->expected);
    }
    *(sc_ease *)value = ease;
    return SC_OK;
}

static sc_status write_ease(const sc_ctx *ctx, const sc_key *key, const void *value, int indent,
                            sc_text *text)
{
    const sc_ease *ease = value;

    (void)key;
    (void)indent;
    if (ease->kind != SC_EASE_BEZIER)
        return sc_text_add(ctx, text, "%s", ease_words[ease->kind]);
    return sc_write_numbers(ctx, ease->bezier, 4, text);
}

static json_t *ease_schema(const sc_key *key)
{
    (void)key;
    return json_pack("{s:[o, o]}", "anyOf", sc_words_schema(ease_words, SC_COUNT_OF(ease_words)),
                     sc_list_schema("number", 0, 1, 4));
}

const sc_value_type sc_type_ease = {
    .name = "linear, smooth, in, out or [x1, y1, x2, y2]",
    .expected = "linear, smooth, in, out, or the points [x1, y1, x2, y2] of a curve, each from 0 "
                "to 1",
    .read = read_ease,
    .write = write_ease,
    .schema = ease_schema,
};

/* ---- the time of a key frame ---- */

/* A share of the animation, from 0 to 1: other times have become shares before (sc_times_resolve).
 */
static sc_status read_time(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    const sc_key share = {.name = key->name, .type = key->type};

    return sc_type_share.read(ctx, &share, node, value);
}

static sc_status write_time(const sc_ctx *ctx, const sc_key *key, const void *value, int indent,
                            sc_text *text)
{
    return sc_type_share.write(ctx, key, value, indent, text);
}

static json_t *time_schema(const sc_key *key)
{
    (void)key;
    return json_pack("{s:s, s:s}", "type", "string", "pattern",
                     "^([0-9.]+ *(%|f|frames?|s|ms|min)|[0-9]+:[0-5][0-9](\\.[0-9]+)?)$");
}

const sc_value_type sc_type_time = {
    .name = "time",
    .expected = "a time of the animation with its unit, such as 2s, 0:10, 45f or 50%",
    .read = read_time,
    .write = write_time,
    .schema = time_schema,
};

/* As of sc_key_frame.at: a share or, of a film outside of its shots, minus a time in seconds. */
static sc_status read_key_time(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                               void *value)
{
    double seconds;

    if (!sc_time_in_seconds(node, &seconds))
        return read_time(ctx, key, node, value);
    *(double *)value = seconds > 0 ? -seconds : 0;
    return SC_OK;
}

static sc_status write_key_time(const sc_ctx *ctx, const sc_key *key, const void *value, int indent,
                                sc_text *text)
{
    const double at = *(const double *)value;

    return at < 0 ? sc_write_number(ctx, -at, 1, "s", text)
                  : write_time(ctx, key, value, indent, text);
}

const sc_value_type sc_type_key_time = {
    .name = "time",
    .expected = "a time of the animation with its unit, such as 2s, 0:10, 45f or 50%",
    .read = read_key_time,
    .write = write_key_time,
    .schema = time_schema,
};

/* ---- key frames ---- */

enum { ROWS = 4 };

/* Fill in the table of one key frame. @param value the row whose values they have. */
static void fill_rows(const sc_key *value, const sc_value_type *type, sc_key rows[ROWS])
{
    rows[0] = (sc_key){"at", &sc_type_key_time, offsetof(sc_key_frame, at), .help = "when",
                       .required = true};
    rows[1] = (sc_key){"value",
                       type,
                       offsetof(sc_key_frame, value),
                       .help = "what it is then",
                       .low = value->low,
                       .high = value->high,
                       .required = true};
    rows[2] = (sc_key){"ease", &sc_type_ease, offsetof(sc_key_frame, ease), "linear",
                       .help = "how the change from the key frame before begins and ends"};
    rows[type->steps ? 2 : 3] = (sc_key){0};
}

/* @return the type of the values of key frames of a row. */
static const sc_value_type *type_of(const sc_key *value)
{
    return value->type->of_key_frames      ? value->type->of_key_frames
           : value->type == &sc_type_share ? &sc_type_share
                                           : &sc_type_real;
}

bool sc_track_rises(double before, double at)
{
    if (before < 0 && at < 0) /* seconds */
        return at < before;
    return (before < 0) != (at < 0) || at > before;
}

sc_status sc_track_disorder(const sc_ctx *ctx, const sc_yaml *list, size_t i)
{
    const char *texts[2] = {"", ""};

    for (size_t j = 0; j < 2; j++) {
        const sc_yaml *at = sc_yaml_member(list->items[i - 1 + j], "at");

        texts[j] = !at ? "" : at->given ? at->given : at->text;
    }
    return sc_yaml_fail(ctx, list->items[i],
                        "%s: key frame %zu, at %s, does not come after key frame %zu, at %s; "
                        "expected rising times, each once",
                        list->key, i + 1, texts[1], i, texts[0]);
}

/* Read key frame @p i of the list into keys[i]; it has to come after the one before it. @return the
 * first mistake; all are logged. */
static sc_status read_key_frame(const sc_ctx *ctx, const sc_key *rows, const sc_yaml *list,
                                size_t i, sc_key_frame *keys)
{
    const sc_yaml *node = list->items[i];
    sc_status status;

    if (node->kind != SC_YAML_MAP) {
        sc_yaml named = *node;

        named.key = list->key; /* for the message: items of a list have no key of their own */
        return sc_wrong_type(ctx, &named, "a key frame, such as {at: 2s, value: 10}");
    }
    status = sc_keys_read(ctx, rows, node, &keys[i]);
    if (status != SC_OK || i == 0 || sc_track_rises(keys[i - 1].at, keys[i].at))
        return status;
    return sc_track_disorder(ctx, list, i);
}

sc_status sc_read_track(const sc_ctx *ctx, const sc_key *value, const sc_yaml *node,
                        struct sc_track *track)
{
    sc_track read = {.count = (int)node->count};
    sc_key rows[ROWS];
    sc_status status = SC_OK;

    if (node->count == 0 || node->count > SC_KEY_FRAMES_MAX)
        return sc_yaml_fail(ctx, node, "%s has %zu key frames, expected 1 to %d", node->key,
                            node->count, SC_KEY_FRAMES_MAX);
    fill_rows(value, type_of(value), rows);
    for (size_t i = 0; i < node->count; i++) {
        const sc_status found = read_key_frame(ctx, rows, node, i, read.keys);

        if (!sc_goes_on(&status, found))
            return status;
        if (found != SC_OK && (i > 0 || node->items[i]->kind != SC_YAML_MAP))
            break; /* the times that follow would be compared with a wrong one */
    }
    if (status == SC_OK)
        *track = read;
    return status;
}

sc_status sc_write_track(const sc_ctx *ctx, const sc_key *value, const struct sc_track *track,
                         sc_text *text)
{
    sc_key rows[ROWS];
    sc_status status;

    fill_rows(value, type_of(value), rows);
    SC_TRY(sc_text_add(ctx, text, "["));
    for (int i = 0; i < track->count; i++) {
        SC_TRY(sc_text_add(ctx, text, "%s", i ? ", " : ""));
        SC_TRY(sc_keys_write_flow(ctx, rows, &track->keys[i], text));
    }
    status = sc_text_add(ctx, text, "]");
out:
    return status;
}

json_t *sc_track_schema(const sc_key *value)
{
    sc_key rows[ROWS];

    fill_rows(value, type_of(value), rows);
    return json_pack("{s:s, s:i, s:i, s:o}", "type", "array", "minItems", 1, "maxItems",
                     SC_KEY_FRAMES_MAX, "items", sc_keys_schema(rows));
}

/* ---- values that may have key frames ---- */

/* @return the track of a row. */
static sc_track *track_of(const sc_key *key, void *value)
{
    return (sc_track *)((char *)value + key->track);
}

bool sc_is_track(const sc_yaml *node)
{
    bool has_map = false;

    if (node->kind != SC_YAML_LIST)
        return false;
    for (size_t i = 0; i < node->count; i++)
        has_map = has_map || node->items[i]->kind == SC_YAML_MAP;
    return has_map || node->count == 0;
}

/* A number or a point, or key frames of it. */
static sc_status read_tracked(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                              void *value)
{
    if (sc_is_track(node) || (node->kind == SC_YAML_LIST && key->type == &sc_type_tracked))
        return sc_read_track(ctx, key, node, track_of(key, value));
    if (node->kind == SC_YAML_MAP)
        return sc_wrong_type(ctx, node, key->type->expected);
    return type_of(key)->read(ctx, key, node, value);
}

static sc_status write_tracked(const sc_ctx *ctx, const sc_key *key, const void *value, int indent,
                               sc_text *text)
{
    const sc_track *track = (const sc_track *)((const char *)value + key->track);

    return track->count ? sc_write_track(ctx, key, track, text)
                        : type_of(key)->write(ctx, key, value, indent, text);
}

static json_t *tracked_schema(const sc_key *key)
{
    return json_pack("{s:[o, o]}", "anyOf", type_of(key)->schema(key), sc_track_schema(key));
}

const sc_value_type sc_type_tracked = {
    .name = "number or key frames",
    .expected = "a number, or key frames such as [{at: 0s, value: 10}, {at: 4s, value: 60}]",
    .read = read_tracked,
    .write = write_tracked,
    .schema = tracked_schema,
};
const sc_value_type sc_type_tracked_point = {
    .name = "[R, A, S] or key frames",
    .of_key_frames = &sc_type_point,
    .expected = "[R, A, S] in millimetres, or key frames such as [{at: 0s, value: [0, 0, 10]}, "
                "{at: 4s, value: [0, 0, 60]}]",
    .read = read_tracked,
    .write = write_tracked,
    .schema = tracked_schema,
};

/* ---- true or false ---- */

/* A bool in the place of a number: 1 or 0. */
static sc_status read_key_bool(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                               void *value)
{
    bool on = false;
    const sc_status status = sc_type_bool.read(ctx, key, node, &on);

    if (status == SC_OK)
        *(sc_vec3 *)value = (sc_vec3){on, 0, 0};
    return status;
}

static sc_status write_key_bool(const sc_ctx *ctx, const sc_key *key, const void *value, int indent,
                                sc_text *text)
{
    const bool on = ((const sc_vec3 *)value)->x > 0;

    return sc_type_bool.write(ctx, key, &on, indent, text);
}

static json_t *key_bool_schema(const sc_key *key)
{
    return sc_type_bool.schema(key);
}

const sc_value_type sc_type_key_bool = {
    .name = "true or false",
    .expected = "true or false",
    .steps = true,
    .read = read_key_bool,
    .write = write_key_bool,
    .schema = key_bool_schema,
};

/* bool; or key frames of such, of which it becomes whether any of them is true. */
static sc_status read_tracked_bool(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                                   void *value)
{
    sc_track *track = track_of(key, value);
    bool any = false;
    sc_status status;

    if (!sc_is_track(node))
        return sc_type_bool.read(ctx, key, node, value);
    status = sc_read_track(ctx, key, node, track);
    for (int i = 0; i < track->count; i++)
        any = any || track->keys[i].value.x > 0;
    *(bool *)value = any;
    return status;
}

static sc_status write_tracked_bool(const sc_ctx *ctx, const sc_key *key, const void *value,
                                    int indent, sc_text *text)
{
    const sc_track *track = (const sc_track *)((const char *)value + key->track);

    return track->count ? sc_write_track(ctx, key, track, text)
                        : sc_type_bool.write(ctx, key, value, indent, text);
}

const sc_value_type sc_type_tracked_bool = {
    .name = "true, false or key frames",
    .expected = "true, false, or key frames such as [{at: 0s, value: true}, {at: 4s, value: "
                "false}]",
    .of_key_frames = &sc_type_key_bool,
    .read = read_tracked_bool,
    .write = write_tracked_bool,
    .schema = tracked_schema,
};

/* double: a number, or true for 1 and false for 0. */
static sc_status read_strength(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                               void *value)
{
    double number;

    if (node->kind == SC_YAML_SCALAR &&
        (!strcmp(node->text, "true") || !strcmp(node->text, "false"))) {
        *(double *)value = !strcmp(node->text, "true");
        return SC_OK;
    }
    if (!sc_parse_number(node, &number) || !(number >= key->low && number <= key->high))
        return sc_wrong_type(ctx, node, key->type->expected);
    *(double *)value = number;
    return SC_OK;
}

/* As they have always been written, so that the identity of jobs stays the same. */
static sc_status write_strength(const sc_ctx *ctx, const sc_key *key, const void *value, int indent,
                                sc_text *text)
{
    const double number = *(const double *)value;

    (void)key;
    (void)indent;
    if (number == 0 || number == 1)
        return sc_text_add(ctx, text, number > 0 ? "true" : "false");
    return sc_write_number(ctx, number, 1, "", text);
}

static json_t *strength_schema(const sc_key *key)
{
    return json_pack("{s:[{s:s}, {s:s, s:f, s:f}]}", "anyOf", "type", "boolean", "type", "number",
                     "minimum", key->low, "maximum", key->high);
}

static const sc_value_type type_strength = {
    .name = "true, false or number",
    .expected = "true, false, or a number from 0 to 1",
    .read = read_strength,
    .write = write_strength,
    .schema = strength_schema,
};
const sc_value_type sc_type_tracked_strength = {
    .name = "true, false, number or key frames",
    .expected = "true, false, a number from 0 to 1, or key frames such as [{at: 0s, value: 0}, "
                "{at: 4s, value: 1}]",
    .of_key_frames = &type_strength,
    .read = read_tracked,
    .write = write_tracked,
    .schema = tracked_schema,
};

/* ---- directions ---- */

/* sc_vec3 of length 1: a direction; or key frames of directions, of which it becomes the first, and
 * none of which is the opposite of the one before. */
static sc_status read_tracked_direction(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                                        void *value)
{
    sc_track *track = track_of(key, value);
    const sc_key_frame *keys = track->keys;
    sc_status status;

    if (!sc_is_track(node))
        return sc_type_direction.read(ctx, key, node, value);
    status = sc_read_track(ctx, key, node, track);
    for (int i = 1; i < track->count && status == SC_OK; i++) {
        if (sc_vec3_length(sc_vec3_add(keys[i].value, keys[i - 1].value)) < 1e-6)
            status =
                sc_yaml_fail(ctx, node->items[i],
                             "%s: the directions of key frames %d and %d are opposite, so that "
                             "no way between them is the shortest; put another one between "
                             "them",
                             key->name, i, i + 1);
    }
    if (status == SC_OK)
        *(sc_vec3 *)value = keys[0].value;
    return status;
}

const sc_value_type sc_type_tracked_direction = {
    .name = "direction or key frames",
    .expected = "an anatomical word, [x, y, z], or key frames of such",
    .of_key_frames = &sc_type_direction,
    .read = read_tracked_direction,
    .write = write_tracked,
    .schema = tracked_schema,
};
