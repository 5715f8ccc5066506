/* SPDX-License-Identifier: BSD-3-Clause */
/* The rows and types of shots, and the keys that are their own. */
#include "key.h"
#include "segcast/job.h"

#include <math.h>

/* ---- how long a transition takes ---- */

/* Read a time as of sc_type_duration, or a number of frames such as "12f". */
static bool parse_length(const sc_yaml *node, sc_length *length)
{
    length->in_frames = node->kind == SC_YAML_SCALAR &&
                        sc_time_of_text(node->text, &length->value) == SC_TIME_FRAMES;
    return length->in_frames ? length->value > 0 && length->value == floor(length->value)
                             : sc_parse_duration(node, &length->value);
}

/* @p value is an sc_length. */
static sc_status read_length(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    return parse_length(node, value) ? SC_OK : sc_wrong_type(ctx, node, key->type->expected);
}

static sc_status write_length(const sc_ctx *ctx, const sc_key *key, const void *value,
                              sc_text *text)
{
    const sc_length *length = value;

    if (!length->in_frames)
        return sc_type_duration.write(ctx, key, &length->value, text);
    return sc_write_number(ctx, length->value, 1, "f", text);
}

const sc_value_type sc_type_length = {
    .name = "time or frames",
    .expected = "a time such as 1s, 500 ms or 0:10, or a number of frames such as 12f",
    .read = read_length,
    .write = write_length,
    .schema = "{anyOf: [$duration, {type: string, pattern: '^[0-9]+ *(f|frames?)$'}]}",
};

/* ---- how a shot follows, and title cards ---- */

static const struct {
    const char *word;
    sc_transition kind;
} transitions[] = {{"cross_fade", SC_TRANSITION_CROSS_FADE}, {"fade", SC_TRANSITION_FADE}};

/* Read "cut", or how the shot follows and how long that takes, such as "fade 1 s", into an
 * sc_shot_transition. */
static sc_status read_transition(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                                 void *value)
{
    sc_shot_transition read = {.kind = SC_TRANSITION_CUT};
    sc_yaml length = *node;
    size_t bytes;

    if (node->kind == SC_YAML_SCALAR && !strcmp(node->text, "cut")) {
        *(sc_shot_transition *)value = read;
        return SC_OK;
    }
    for (size_t i = 0; i < SC_COUNT_OF(transitions) && node->kind == SC_YAML_SCALAR; i++) {
        bytes = strlen(transitions[i].word);
        if (strncmp(node->text, transitions[i].word, bytes) != 0 || node->text[bytes] != ' ')
            continue;
        read.kind = transitions[i].kind;
        length.text = node->text + bytes + strspn(node->text + bytes, " ");
    }
    if (read.kind == SC_TRANSITION_CUT || !parse_length(&length, &read.length))
        return sc_wrong_type(ctx, node, key->type->expected);
    *(sc_shot_transition *)value = read;
    return SC_OK;
}

static sc_status write_transition(const sc_ctx *ctx, const sc_key *key, const void *value,
                                  sc_text *text)
{
    const sc_shot_transition *transition = value;

    if (transition->kind == SC_TRANSITION_CUT)
        return sc_text_add(ctx, text, "cut");
    for (size_t i = 0; i < SC_COUNT_OF(transitions); i++) {
        if (transitions[i].kind == transition->kind)
            SC_PASS(sc_text_add(ctx, text, "%s ", transitions[i].word));
    }
    return write_length(ctx, key, &transition->length, text);
}

const sc_value_type sc_type_transition = {
    .name = "cut, cross_fade or fade with a time",
    .expected = "cut, cross_fade 1s or fade 12f",
    .read = read_transition,
    .write = write_transition,
    .schema = "{type: string, pattern: '^(cut|(cross_fade|fade) +[0-9].*)$'}",
};

/* Read a title, or a list of a title and what is smaller below it, into an sc_card. */
static sc_status read_card(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    const size_t count = sc_yaml_length(node);
    sc_card *card = value;
    sc_status status = SC_OK;

    if (node->kind == SC_YAML_MAP || count < 1 || count > 2)
        return sc_wrong_type(ctx, node, key->type->expected);
    card->has_subtitle = count == 2;
    for (size_t i = 0; i < count; i++) {
        const sc_yaml named = sc_yaml_item(node, i);

        (void)sc_goes_on(
            &status, sc_type_caption_text.read(ctx, key, &named, i ? card->subtitle : card->title));
    }
    return status;
}

static sc_status write_card(const sc_ctx *ctx, const sc_key *key, const void *value, sc_text *text)
{
    const sc_card *card = value;

    if (!card->has_subtitle)
        return sc_type_caption_text.write(ctx, key, card->title, text);
    SC_PASS(sc_text_add(ctx, text, "["));
    SC_PASS(sc_type_caption_text.write(ctx, key, card->title, text));
    SC_PASS(sc_text_add(ctx, text, ", "));
    SC_PASS(sc_type_caption_text.write(ctx, key, card->subtitle, text));
    return sc_text_add(ctx, text, "]");
}

const sc_value_type sc_type_card = {
    .name = "text or [title, subtitle]",
    .expected = "a title that is not empty, or [title, subtitle]",
    .read = read_card,
    .write = write_card,
    .schema =
        "{anyOf: [{type: string}, {type: array, minItems: 1, maxItems: 2, items: {type: string}}]}",
};

/* ---- reading ---- */

/* Read the keys of a shot that are its own; the others are left to sc_shots_resolve. @param keys
 * the table of shots. @return the first mistake; all are logged. */
static sc_status read_shot(const sc_ctx *ctx, const sc_key *keys, const sc_yaml *node,
                           sc_shot *shot)
{
    sc_status status = SC_OK;

    sc_note_where(node, shot->where, sizeof shot->where);
    sc_note_where(node, shot->card.where, sizeof shot->card.where);
    SC_PASS(sc_keys_set_defaults(ctx, keys, shot));
    if (node->kind != SC_YAML_MAP)
        return sc_wrong_type(ctx, node, "a shot: a map of its keys, such as animation");
    for (size_t i = 0; i < node->count; i++) {
        const sc_yaml *item = node->items[i];
        const sc_key *key = sc_key_find(keys, item->key);
        sc_status found;

        if (!key || key->scope.of_job)
            continue;
        found = key->type->read(ctx, key, item, (char *)shot + key->offset);
        if (found == SC_OK && key->given)
            *((bool *)shot + key->given - 1) = true;
        if (!sc_goes_on(&status, found))
            break;
    }
    return status;
}

/* Read the list of shots. @p value is the whole sc_job. There is a shot for each item then, also
 * after a mistake in it. */
static sc_status read_shots(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    sc_job *job = value;

    sc_status status = SC_OK;

    if (node->kind != SC_YAML_LIST)
        return sc_wrong_type(ctx, node, key->type->expected);
    if (node->count == 0 || node->count > SC_SHOTS_MAX)
        return sc_yaml_fail(
            ctx, node, "shots has %zu items, expected 1 to %d; without shots, the key is left out",
            node->count, SC_SHOTS_MAX);
    SC_PASS(SC_ZALLOC(ctx, node->count, &job->film.shots));
    job->film.shot_count = node->count;
    for (size_t i = 0; i < node->count; i++) {
        if (!sc_goes_on(&status, read_shot(ctx, key->keys, node->items[i], &job->film.shots[i])))
            break;
    }
    return status;
}

/* ---- writing ---- */

/* Write all shots of the sc_job @p value, each with all keys that it may have. */
static sc_status write_shots(const sc_ctx *ctx, const sc_key *key, const void *value, int indent,
                             unsigned parts, sc_text *text)
{
    const sc_job *job = value;

    SC_PASS(sc_text_add(ctx, text, "\n"));
    for (size_t i = 0; i < job->film.shot_count; i++) {
        const size_t at = text->length_bytes;

        SC_PASS(sc_keys_write(ctx, key->keys, &job->film.shots[i], indent + 4,
                              parts | SC_WRITE_SHOT, text));
        text->data[at + (size_t)indent + 2] = '-'; /* in the blanks before its first key */
    }
    return SC_OK;
}

const sc_value_type sc_type_shots = {
    .name = "list of shots",
    .expected = "a list of shots, each a map of its keys",
    .read = read_shots,
    .write_lines = write_shots,
    .schema = "{type: array, minItems: 1, maxItems: $shots_most, items: $shot}",
    .container = SC_CONTAINER_LIST,
};
