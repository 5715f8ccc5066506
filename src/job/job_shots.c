/* SPDX-License-Identifier: BSD-3-Clause */
/* A film as a list of shots. Each is read as a job of its own, from the tree of the film into which
 * its keys are merged. */
#include "key.h"
#include "segcast/job.h"

#include <math.h>
#include <string.h>

/* ---- the keys that only shots have ---- */

#define TRANSITION(member) offsetof(sc_shot_transition, member)

const sc_key sc_transition_keys[] = {
    {"cross_fade", &sc_type_duration, TRANSITION(seconds), NULL,
     .help = "the shot before is replaced step by step, in linear light: both overlap for this "
             "long, by which the film is shorter",
     .given = SC_GIVEN(sc_shot_transition, is_cross_fade), .alternative = "cross_fade or fade",
     .required = true},
    {"fade", &sc_type_duration, TRANSITION(seconds), NULL,
     .help = "half of this time the shot before fades to the background, and in the other half the "
             "shot appears from its own; the first shot only appears",
     .given = SC_GIVEN(sc_shot_transition, is_fade), .alternative = "cross_fade or fade",
     .required = true},
    {0}};

/* Read "cut", or a map of transition_keys, into an sc_shot_transition. */
static sc_status read_transition(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                                 void *value)
{
    *(sc_shot_transition *)value = (sc_shot_transition){0};
    if (node->kind == SC_YAML_SCALAR && !strcmp(node->text, "cut"))
        return SC_OK;
    if (node->kind != SC_YAML_MAP)
        return sc_wrong_type(ctx, node, key->type->expected);
    return sc_keys_read(ctx, key->keys, node, value);
}

static sc_status write_transition(const sc_ctx *ctx, const sc_key *key, const void *value,
                                  int indent, sc_text *text)
{
    const sc_shot_transition *transition = value;

    (void)indent;
    if (!transition->is_cross_fade && !transition->is_fade)
        return sc_text_add(ctx, text, "cut");
    return sc_keys_write_flow(ctx, key->keys, value, text);
}

static json_t *transition_schema(const sc_key *key)
{
    return json_pack("{s:[{s:[s]}, o]}", "anyOf", "enum", "cut", sc_keys_schema(key->keys));
}

const sc_value_type sc_type_transition = {
    .name = "cut or map",
    .expected = "cut, {cross_fade: 1 s} or {fade: 1 s}",
    .read = read_transition,
    .write = write_transition,
    .schema = transition_schema,
    .container = SC_CONTAINER_MAP,
};

#define CARD(member) offsetof(sc_card, member)

const sc_key sc_card_keys[] = {
    {"title", &sc_type_caption_text, CARD(title), NULL,
     .help = "what is written; \\n in double quotes begins a new line", .required = true},
    {"subtitle", &sc_type_caption_text, CARD(subtitle), NULL, .help = "smaller, below the title",
     .given = SC_GIVEN(sc_card, has_subtitle), .without = "none"},
    {0}};

/* ---- reading ---- */

/* Refuse keys in and below @p node that hold for the whole film. @param keys, container as of
 * sc_key: what the node is. @return the first mistake; all are logged. */
static sc_status check_film_keys(const sc_ctx *ctx, const sc_key *keys, sc_container container,
                                 const sc_yaml *node)
{
    sc_status status = SC_OK;

    for (size_t i = 0; i < node->count; i++) {
        const sc_yaml *item = node->items[i];
        const sc_key *key =
            container == SC_CONTAINER_MAP && item->key ? sc_key_find(keys, item->key) : NULL;

        if (key && key->of_film)
            (void)sc_goes_on(&status,
                             sc_yaml_fail(ctx, item,
                                          "%s holds for the whole film, not for one of its shots; "
                                          "write it outside of shots",
                                          item->key));
        else if (key && key->keys)
            (void)sc_goes_on(&status, check_film_keys(ctx, key->keys, key->type->container, item));
        else if (container == SC_CONTAINER_DICT)
            (void)sc_goes_on(&status, check_film_keys(ctx, keys, SC_CONTAINER_MAP, item));
    }
    return status;
}

/* Read one key of a shot: what is its own; those of the job are checked only. */
static sc_status read_item(const sc_ctx *ctx, const sc_yaml *item, sc_shot *shot)
{
    const sc_key *key = sc_key_find(sc_shot_keys, item->key);
    const sc_key *film = sc_key_find(sc_job_keys, item->key);
    sc_status status;

    if (!key && film)
        return sc_yaml_fail(ctx, item,
                            "%s holds for the whole film, not for one of its shots; write it "
                            "outside of shots",
                            item->key);
    if (!key)
        return sc_key_unknown(ctx, sc_shot_keys, item);
    if (key->of_job)
        return key->keys ? check_film_keys(ctx, key->keys, key->type->container, item) : SC_OK;
    status = key->type->read(ctx, key, item, (char *)shot + key->offset);
    if (status == SC_OK && key->given)
        *((bool *)shot + key->given - 1) = true;
    return status;
}

/* Read the keys of a shot that are its own. @return the first mistake; all are logged. */
static sc_status read_shot(const sc_ctx *ctx, const sc_yaml *node, sc_shot *shot)
{
    sc_status status = SC_OK;

    sc_note_where(node, shot->where, sizeof shot->where);
    sc_note_where(node, shot->card.where, sizeof shot->card.where);
    SC_TRY(sc_keys_set_defaults(ctx, sc_job_keys, &shot->job));
    if (node->kind != SC_YAML_MAP)
        return sc_wrong_type(ctx, node, "a shot: a map of its keys, such as animation");
    for (size_t i = 0; i < node->count; i++) {
        if (!sc_goes_on(&status, read_item(ctx, node->items[i], shot)))
            break;
    }
out:
    return status;
}

/* Read the list of shots. @p value is the whole sc_job. There is a shot for each item then, also
 * after a mistake in it. */
static sc_status read_shots(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    sc_job *job = value;
    void *shots;
    sc_status status;

    if (node->kind != SC_YAML_LIST)
        return sc_wrong_type(ctx, node, key->type->expected);
    if (node->count == 0 || node->count > SC_SHOTS_MAX)
        return sc_yaml_fail(ctx, node,
                            "shots has %zu items, expected 1 to %d; without shots, the "
                            "key is left out",
                            node->count, SC_SHOTS_MAX);
    SC_TRY(sc_zalloc(ctx, node->count, sizeof *job->shots, &shots));
    job->shots = shots;
    job->shot_count = node->count;
    for (size_t i = 0; i < node->count; i++) {
        if (!sc_goes_on(&status, read_shot(ctx, node->items[i], &job->shots[i])))
            break;
    }
out:
    return status;
}

/* ---- what shots take from the film ---- */

/* Move the members of the map "tissues" of @p shot behind those of @p tree, where there may be some
 * of the same name: a later entry wins key by key. */
static sc_status move_tissues(const sc_ctx *ctx, sc_yaml *tree, sc_yaml *shot)
{
    sc_yaml *from = sc_yaml_member(shot, "tissues"), *to = sc_yaml_member(tree, "tissues");
    sc_status status = SC_OK;

    if (!from || !to || from->kind != SC_YAML_MAP || to->kind != SC_YAML_MAP)
        return SC_OK;
    for (size_t i = 0; i < from->count && status == SC_OK; i++) {
        sc_yaml *member = from->items[i];

        from->items[i] = NULL;
        status = sc_yaml_append(ctx, to, member);
    }
    sc_yaml_remove(shot, sc_yaml_index(shot, "tissues"));
    return status;
}

/* Remove keys that hold for the whole film, which have been refused, so that nothing else is said
 * of them. @param keys, container as of check_film_keys. */
static void drop_refused(const sc_key *keys, sc_container container, sc_yaml *node)
{
    for (size_t i = node->count; i-- > 0;) {
        sc_yaml *item = node->items[i];
        const sc_key *key =
            container == SC_CONTAINER_MAP && item->key ? sc_key_find(keys, item->key) : NULL;

        if (key && key->of_film)
            sc_yaml_remove(node, i);
        else if (key && key->keys)
            drop_refused(key->keys, key->type->container, item);
        else if (container == SC_CONTAINER_DICT)
            drop_refused(keys, SC_CONTAINER_MAP, item);
    }
}

/* Remove from the tree of the film what a title card has no use for: all of the animation but its
 * length. Times of the film may well lie behind the end of a card. */
static void drop_animation(sc_yaml *tree)
{
    sc_yaml *animation = sc_yaml_member(tree, "animation");

    for (size_t i = animation ? animation->count : 0;
         animation && animation->kind == SC_YAML_MAP && i-- > 0;) {
        if (strcmp(animation->items[i]->key, "frames") &&
            strcmp(animation->items[i]->key, "duration"))
            sc_yaml_remove(animation, i);
    }
}

/* Make the tree of a shot's job: that of the film with the keys of the shot. Caller owns *out:
 * sc_yaml_free. */
static sc_status merge_shot(const sc_ctx *ctx, const sc_yaml *base, const sc_yaml *node,
                            sc_yaml **out)
{
    sc_yaml *tree = NULL, *shot = NULL, *keys;
    sc_status status;

    SC_TRY(sc_yaml_copy(ctx, base, &tree));
    SC_TRY(sc_yaml_copy(ctx, node, &shot));
    if (sc_yaml_member(shot, "card"))
        drop_animation(tree);
    for (size_t i = shot->count; i-- > 0;) {
        const sc_key *key = sc_key_find(sc_shot_keys, shot->items[i]->key);

        if (!key || !key->of_job)
            sc_yaml_remove(shot, i);
    }
    drop_refused(sc_job_keys, SC_CONTAINER_MAP, shot);
    SC_TRY(move_tissues(ctx, tree, shot));
    keys = shot;
    shot = NULL;
    SC_TRY(sc_settings_merge(ctx, sc_job_keys, tree, keys));
    *out = tree;
    tree = NULL;
out:
    sc_yaml_free(tree);
    sc_yaml_free(shot);
    return status;
}

/* Pictures of one film are all transparent, or none is. Another background of the shot is replaced
 * by that of the film. */
static sc_status check_background(const sc_ctx *ctx, const sc_yaml *node, const sc_job *film,
                                  sc_job *job)
{
    if (job->render.background.is_none == film->render.background.is_none)
        return SC_OK;
    job->render.background = film->render.background;
    return sc_yaml_fail(ctx, sc_key_node(node, "render.background"),
                        "background: either all shots have none, or no shot has; write none "
                        "outside of shots");
}

/* Read the job of a shot. @return the first mistake; all are logged. */
static sc_status load_shot(const sc_ctx *ctx, const sc_job_sources *sources, const sc_yaml *base,
                           const sc_yaml *node, const sc_job *film, sc_shot *shot)
{
    sc_job *job = &shot->job;
    sc_yaml *tree = NULL;
    sc_status status;

    if (node->kind != SC_YAML_MAP)
        return SC_OK; /* which has been told */
    SC_TRY(merge_shot(ctx, base, node, &tree));
    if (sc_goes_on(&status, sc_times_resolve(ctx, job, tree)) &&
        sc_goes_on(&status, sc_keys_read(ctx, sc_job_keys, tree, job)) &&
        sc_goes_on(&status, check_background(ctx, node, film, job)))
        (void)sc_goes_on(&status, sc_job_check(ctx, sources, tree, job));
    job->film_rules = film->rule_count < job->rule_count ? film->rule_count : job->rule_count;
out:
    sc_yaml_free(tree);
    return status;
}

/* ---- where they lie in the film ---- */

/* @return the number of frames of a transition. */
static double transition_frames(const sc_shot *shot, int fps)
{
    const sc_shot_transition *t = &shot->transition;

    return t->is_cross_fade || t->is_fade ? floor(t->seconds * fps + 0.5) : 0;
}

/* Fill in the span of shot @p i, but not yet its first frame. @return SC_ERR_DATA, logged, if it
 * cannot begin as it is to. */
static sc_status find_span(const sc_ctx *ctx, const sc_job *film, size_t i)
{
    sc_shot *shot = &film->shots[i];
    const sc_shot_transition *t = &shot->transition;
    const double frames = transition_frames(shot, film->output.fps);

    if (t->is_cross_fade && i == 0)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: the first shot has a cross-fade, but there is no shot before it; "
                       "expected cut, or fade",
                       shot->where);
    if ((t->is_cross_fade || t->is_fade) && (frames < 1 || frames > SC_JOB_FRAMES_MAX))
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: the transition of shot %zu is %g s, which makes %.0f frames at %d "
                       "frames per second, expected 1 or more",
                       shot->where, i + 1, t->seconds, frames, film->output.fps);
    shot->span = (sc_shot_span){.frames = shot->job.animation.frames,
                                .transition = t->is_cross_fade ? SC_TRANSITION_CROSS_FADE
                                              : t->is_fade     ? SC_TRANSITION_FADE
                                                               : SC_TRANSITION_CUT,
                                .transition_frames = (int)frames};
    return SC_OK;
}

/* Refuse shots that are shorter than their transitions. @param spans [shot_count]. @return the
 * first mistake; all are logged. */
static sc_status check_lengths(const sc_ctx *ctx, const sc_job *film, const sc_shot_span *spans)
{
    sc_status status = SC_OK;

    for (size_t i = 0; i < film->shot_count; i++) {
        const int used = sc_shot_transitions(spans, (int)film->shot_count, (int)i);

        if (used > spans[i].frames)
            (void)sc_goes_on(&status,
                             sc_fail(ctx, SC_ERR_DATA,
                                     "%s: shot %zu has %d frame%s (%.3g s), but the transitions at "
                                     "its beginning and its end take %d; make it longer, or them "
                                     "shorter",
                                     film->shots[i].where, i + 1, spans[i].frames,
                                     spans[i].frames > 1 ? "s" : "",
                                     (double)spans[i].frames / film->output.fps, used));
    }
    return status;
}

/* Place the shots in the film. @return the first mistake; all are logged. */
static sc_status place_shots(const sc_ctx *ctx, const sc_yaml *node, sc_job *film)
{
    sc_shot_span spans[SC_SHOTS_MAX];
    double frames = 0;
    bool all_cards = true;
    sc_status status = SC_OK;

    for (size_t i = 0; i < film->shot_count; i++) {
        (void)sc_goes_on(&status, find_span(ctx, film, i));
        spans[i] = film->shots[i].span;
        frames += spans[i].frames;
        all_cards = all_cards && film->shots[i].has_card;
    }
    if (status == SC_OK && frames > SC_JOB_FRAMES_MAX)
        return sc_yaml_fail(ctx, node, "the shots have %.0f frames, expected at most %d", frames,
                            SC_JOB_FRAMES_MAX);
    if (all_cards)
        (void)sc_goes_on(&status, sc_yaml_fail(ctx, node,
                                               "all shots are title cards; expected at least one "
                                               "that shows the volume"));
    if (status == SC_OK)
        status = check_lengths(ctx, film, spans);
    if (status != SC_OK)
        return status;
    film->animation.frames = sc_shots_place(spans, (int)film->shot_count);
    for (size_t i = 0; i < film->shot_count; i++)
        film->shots[i].span = spans[i];
    return SC_OK;
}

sc_status sc_shots_resolve(const sc_ctx *ctx, const sc_job_sources *sources, const sc_yaml *base,
                           const sc_yaml *shots, sc_job *job)
{
    sc_status status = SC_OK;

    for (size_t i = 0; i < job->shot_count; i++) {
        if (!sc_goes_on(&status,
                        load_shot(ctx, sources, base, shots->items[i], job, &job->shots[i])))
            break;
    }
    return status == SC_OK && job->shot_count ? place_shots(ctx, shots, job) : status;
}

/* ---- writing ---- */

/* Write all shots of the sc_job @p value, each with all keys that it may have. */
static sc_status write_shots(const sc_ctx *ctx, const sc_key *key, const void *value, int indent,
                             unsigned parts, sc_text *text)
{
    const sc_job *job = value;
    sc_status status = SC_OK;

    for (size_t i = 0; i < job->shot_count && status == SC_OK; i++) {
        const size_t at = text->length_bytes;

        status =
            sc_keys_write(ctx, key->keys, &job->shots[i], indent + 4, parts | SC_WRITE_SHOT, text);
        if (status == SC_OK)
            text->data[at + (size_t)indent + 2] = '-'; /* in the blanks before its first key */
    }
    return status;
}

/* Remove from the schema of a map what a shot cannot have. */
static void drop_film_keys(const sc_key *keys, json_t *schema)
{
    json_t *properties = json_object_get(schema, "properties");

    for (const sc_key *key = keys; key->name && properties; key++) {
        if (key->of_film)
            json_object_del(properties, key->name);
        else if (key->keys && key->type->container == SC_CONTAINER_MAP)
            drop_film_keys(key->keys, json_object_get(properties, key->name));
        else if (key->keys && key->type->container == SC_CONTAINER_DICT)
            drop_film_keys(key->keys, json_object_get(json_object_get(properties, key->name),
                                                      "additionalProperties"));
    }
}

static json_t *shots_schema(const sc_key *key)
{
    json_t *shot = sc_keys_schema(key->keys);

    drop_film_keys(key->keys, shot);
    return json_pack("{s:s, s:i, s:i, s:o}", "type", "array", "minItems", 1, "maxItems",
                     SC_SHOTS_MAX, "items", shot);
}

const sc_value_type sc_type_shots = {
    .name = "list of shots",
    .expected = "a list of shots, each a map of its keys",
    .read = read_shots,
    .write_lines = write_shots,
    .schema = shots_schema,
    .container = SC_CONTAINER_LIST,
};
