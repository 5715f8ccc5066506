/* SPDX-License-Identifier: BSD-3-Clause */
/* Values that change with time: easing, and tracks, which are maps of times and values. */
#include "key.h"
#include "segcast/timeline.h"

#include <stdlib.h>

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

static sc_status write_ease(const sc_ctx *ctx, const sc_key *key, const void *value, sc_text *text)
{
    const sc_ease *ease = value;

    if (ease->kind != SC_EASE_BEZIER)
        return sc_text_add(ctx, text, "%s", ease_words[ease->kind]);
    return sc_write_numbers(ctx, ease->bezier, 4, text);
}

static size_t list_eases(const sc_key *key, const char **words)
{
    memcpy(words, ease_words, sizeof ease_words);
    return SC_COUNT_OF(ease_words);
}

const sc_value_type sc_type_ease = {
    .name = "linear, smooth, in, out or [x1, y1, x2, y2]",
    .expected =
        "linear, smooth, in, out, or the points [x1, y1, x2, y2] of a curve, each from 0 to 1",
    .read = read_ease,
    .write = write_ease,
    .list_words = list_eases,
    .schema = "{anyOf: [$words, " SC_SCHEMA_LIST("{type: number, minimum: 0, maximum: 1}", 4) "]}",
};

/* ---- tracks ---- */

/* A key frame that says how the change from the one before it begins and ends: {value: 60, ease:
 * smooth}. */
typedef struct eased {
    const sc_yaml *value; /* borrowed */
    sc_ease ease;
} eased;

static sc_status keep_node(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    *(const sc_yaml **)value = node;
    return SC_OK;
}

static const sc_value_type type_node = {.name = "value", .expected = "a value", .read = keep_node};
static const sc_key eased_keys[] = {{"value", &type_node, offsetof(eased, value), NULL,
                                     .help = "what it is then", .required = true},
                                    {"ease", &sc_type_ease, offsetof(eased, ease), NULL,
                                     .help = "how the change before begins and ends"},
                                    {0}};

const sc_value_type *sc_type_of_frames(const sc_key *value)
{
    return value->type->of_key_frames ? value->type->of_key_frames : &sc_type_real;
}

/* @return whether the time of a key frame lies behind that of the one before it, as far as that is
 * known: seconds and shares can only be compared in a shot. */
static bool rises(double before, double at)
{
    if (before < 0 && at < 0) /* seconds */
        return at < before;
    return (before < 0) != (at < 0) || at > before;
}

/* Read the time of a key frame, a share or, of a film outside of its shots, minus a time in
 * seconds. @param before that of the one before it, at which *at lies; NULL: it is not known.
 * @return as sc_yaml_fail. */
static sc_status read_time(const sc_ctx *ctx, const sc_yaml *track, const sc_yaml *item,
                           const sc_yaml *before, double *at)
{
    const double last = *at;
    sc_yaml time = *item;
    bool is_time;

    time.kind = SC_YAML_SCALAR;
    time.text = item->key;
    SC_PASS(sc_read_time(ctx, track->key, &time, at, &is_time));
    if (!is_time)
        return sc_yaml_fail(ctx, item,
                            "%s: \"%s\" is no time of the animation with its unit, such as 2s, "
                            "0:10, 45f or 50%%",
                            track->key, item->key);
    if (before && !rises(last, *at))
        return sc_yaml_fail(ctx, item,
                            "%s: the key frame at %s does not come after that at %s; expected "
                            "rising times, each once",
                            track->key, item->key, before->key);
    return SC_OK;
}

/* Read the value of a key frame, and its ease, if it has one of its own. @param key the row of the
 * track, with the type of its values. @param to as of sc_read_key_frames. */
static sc_status read_value(const sc_ctx *ctx, const sc_key *key, const sc_yaml *item, void *to,
                            sc_ease *ease)
{
    eased read = {.value = item, .ease = *ease};
    char name[128];
    sc_yaml named;
    sc_key row = *key;

    if (item->kind == SC_YAML_MAP && !key->type->steps)
        SC_PASS(sc_keys_read(ctx, eased_keys, item, &read));
    *ease = read.ease;
    snprintf(name, sizeof name, "%s at %s", strcmp(key->name, "at") ? key->name : "position",
             item->key);
    named = *read.value; /* for messages: the value is called as the track, and not as its time */
    named.key = name;
    row.name = name;
    return key->type->read(ctx, &row, &named, to);
}

sc_status sc_read_key_frames(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                             const sc_track_room *room)
{
    static const sc_key ease_key = {.name = "ease", .type = &sc_type_ease};
    const sc_yaml *ease_node = key->type->steps ? NULL : sc_yaml_member(node, "ease");
    const size_t count = node->count - (ease_node != NULL);
    const sc_yaml *before = NULL;
    sc_ease ease = {.kind = SC_EASE_LINEAR};
    sc_status status = SC_OK, found;
    double at = 0;

    if (count < 1 || count > (size_t)room->most)
        return sc_yaml_fail(ctx, node, "%s has %zu key frames, expected 1 to %d", node->key, count,
                            room->most);
    if (ease_node)
        status = sc_type_ease.read(ctx, &ease_key, ease_node, &ease);
    for (size_t i = 0, frame = 0; i < node->count; i++) {
        const sc_yaml *item = node->items[i];
        sc_key_frame *to = &room->frames[frame];

        if (item == ease_node)
            continue;
        found = read_time(ctx, node, item, before, &at);
        if (!sc_goes_on(&status, found))
            return status;
        if (found != SC_OK) {
            before = NULL; /* the next time is not compared with a wrong one */
            continue;
        }
        *to = (sc_key_frame){.at = at};
        if (before)
            to->ease = ease;
        before = item;
        if (!sc_goes_on(&status,
                        read_value(ctx, key, item, (char *)room->values + frame * room->value_bytes,
                                   &to->ease)))
            return status;
        frame++;
    }
    if (status == SC_OK)
        *room->count = (int)count;
    return status;
}

sc_status sc_read_track(const sc_ctx *ctx, const sc_key *value, const sc_yaml *node,
                        struct sc_track *track)
{
    sc_key key = *value;
    sc_track read = {0};

    key.type = sc_type_of_frames(value);
    SC_PASS(sc_read_key_frames(ctx, &key, node,
                               &(sc_track_room){read.keys, &read.keys[0].value, sizeof *read.keys,
                                                &read.count, SC_KEY_FRAMES_MAX}));
    *track = read;
    return SC_OK;
}

sc_status sc_write_key_frames(const sc_ctx *ctx, const sc_key *key, const sc_track_room *room,
                              sc_text *text)
{
    SC_PASS(sc_text_add(ctx, text, "{"));
    for (int i = 0; i < *room->count; i++) {
        const sc_key_frame *frame = &room->frames[i];
        const bool is_eased = frame->ease.kind != SC_EASE_LINEAR;

        SC_PASS(sc_text_add(ctx, text, "%s", i ? ", " : ""));
        SC_PASS(frame->at < 0 ? sc_write_number(ctx, -frame->at, 1, "s", text)
                              : sc_write_number(ctx, frame->at, 100, "%", text));
        SC_PASS(sc_text_add(ctx, text, "%s", is_eased ? ": {value: " : ": "));
        SC_PASS(key->type->write(ctx, key,
                                 (const char *)room->values + (size_t)i * room->value_bytes, text));
        if (is_eased) {
            SC_PASS(sc_text_add(ctx, text, ", ease: "));
            SC_PASS(sc_type_ease.write(ctx, key, &frame->ease, text));
            SC_PASS(sc_text_add(ctx, text, "}"));
        }
    }
    return sc_text_add(ctx, text, "}");
}

sc_status sc_write_track(const sc_ctx *ctx, const sc_key *value, const struct sc_track *track,
                         sc_text *text)
{
    sc_track copy = *track;
    sc_key key = *value;

    key.type = sc_type_of_frames(value);
    return sc_write_key_frames(ctx, &key,
                               &(sc_track_room){copy.keys, &copy.keys[0].value, sizeof *copy.keys,
                                                &copy.count, SC_KEY_FRAMES_MAX},
                               text);
}

/* ---- values that may have key frames ---- */

sc_track *sc_track_of(const sc_key *key, void *value)
{
    return (sc_track *)((char *)value + key->track);
}

const sc_value_type *sc_constant_of(const sc_key *key)
{
    return key->type->constant ? key->type->constant : sc_type_of_frames(key);
}

bool sc_is_track(const sc_yaml *node)
{
    return node->kind == SC_YAML_MAP;
}

sc_status sc_read_tracked(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    if (!sc_is_track(node))
        return sc_constant_of(key)->read(ctx, key, node, value);
    SC_PASS(sc_read_track(ctx, key, node, sc_track_of(key, value)));
    return key->type->take_track ? key->type->take_track(ctx, key, node, value) : SC_OK;
}

sc_status sc_write_tracked(const sc_ctx *ctx, const sc_key *key, const void *value, sc_text *text)
{
    const sc_track *track = (const sc_track *)((const char *)value + key->track);

    return track->count ? sc_write_track(ctx, key, track, text)
                        : sc_constant_of(key)->write(ctx, key, value, text);
}

const sc_value_type sc_type_tracked = {
    .name = "number or key frames",
    .expected = "a number, or key frames such as {0s: 10, 4s: 60}",
    .read = sc_read_tracked,
    .write = sc_write_tracked,
    .schema = SC_SCHEMA_TRACKED,
};
const sc_value_type sc_type_tracked_share = {
    .name = "share or key frames",
    .of_key_frames = &sc_type_share,
    .expected = "a share from 0% to 100%, or key frames such as {0s: 0%, 4s: 60%}",
    .read = sc_read_tracked,
    .write = sc_write_tracked,
    .schema = SC_SCHEMA_TRACKED,
};
const sc_value_type sc_type_tracked_point = {
    .name = "[R, A, S] or key frames",
    .of_key_frames = &sc_type_point,
    .expected = "[R, A, S] in millimetres, or key frames such as {0s: [0, 0, 10], 4s: [0, 0, 60]}",
    .read = sc_read_tracked,
    .write = sc_write_tracked,
    .schema = SC_SCHEMA_TRACKED,
};

/* ---- true or false ---- */

/* A bool in the place of a number: 1 or 0. */
static sc_status read_key_bool(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                               void *value)
{
    bool on;

    SC_PASS(sc_type_bool.read(ctx, key, node, &on));
    *(sc_vec3 *)value = (sc_vec3){on, 0, 0};
    return SC_OK;
}

static sc_status write_key_bool(const sc_ctx *ctx, const sc_key *key, const void *value,
                                sc_text *text)
{
    const bool on = ((const sc_vec3 *)value)->x > 0;

    return sc_type_bool.write(ctx, key, &on, text);
}

const sc_value_type sc_type_key_bool = {
    .name = "true or false",
    .expected = "true or false",
    .steps = true,
    .read = read_key_bool,
    .write = write_key_bool,
    .schema = "$bool",
};

/* A bool becomes whether any of its key frames is true. */
static sc_status take_any(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    const sc_track *track = sc_track_of(key, value);
    bool any = false;

    for (int i = 0; i < track->count; i++)
        any = any || track->keys[i].value.x > 0;
    *(bool *)value = any;
    return SC_OK;
}

const sc_value_type sc_type_tracked_bool = {
    .name = "true, false or key frames",
    .expected = "true, false, or key frames such as {0s: true, 4s: false}",
    .of_key_frames = &sc_type_key_bool,
    .constant = &sc_type_bool,
    .take_track = take_any,
    .read = sc_read_tracked,
    .write = sc_write_tracked,
    .schema = SC_SCHEMA_TRACKED,
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
static sc_status write_strength(const sc_ctx *ctx, const sc_key *key, const void *value,
                                sc_text *text)
{
    const double number = *(const double *)value;

    if (number == 0 || number == 1)
        return sc_text_add(ctx, text, number > 0 ? "true" : "false");
    return sc_write_number(ctx, number, 1, "", text);
}

static const sc_value_type type_strength = {
    .name = "true, false or number",
    .expected = "true, false, or a number from 0 to 1",
    .read = read_strength,
    .write = write_strength,
    .schema = "{anyOf: [{type: boolean}, " SC_SCHEMA_NUMBER "]}",
};
const sc_value_type sc_type_tracked_strength = {
    .name = "true, false, number or key frames",
    .expected = "true, false, a number from 0 to 1, or key frames such as {0s: 0, 4s: 1}",
    .of_key_frames = &type_strength,
    .read = sc_read_tracked,
    .write = sc_write_tracked,
    .schema = SC_SCHEMA_TRACKED,
};

/* ---- directions ---- */

/* A direction becomes the first of its key frames, none of which is the opposite of the one before.
 */
static sc_status take_first(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    const sc_track *track = sc_track_of(key, value);
    const sc_key_frame *keys = track->keys;

    for (int i = 1; i < track->count; i++) {
        if (sc_vec3_length(sc_vec3_add(keys[i].value, keys[i - 1].value)) < 1e-6)
            return sc_yaml_fail(ctx, node,
                                "%s: the directions of key frames %d and %d are opposite, so that "
                                "no way between them is the shortest; put another one between them",
                                key->name, i, i + 1);
    }
    *(sc_vec3 *)value = keys[0].value;
    return SC_OK;
}

const sc_value_type sc_type_tracked_direction = {
    .name = "direction or key frames",
    .expected = "an anatomical word, [x, y, z], or key frames of such",
    .of_key_frames = &sc_type_direction,
    .take_track = take_first,
    .read = sc_read_tracked,
    .write = sc_write_tracked,
    .schema = SC_SCHEMA_TRACKED,
};
