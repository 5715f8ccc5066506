/* SPDX-License-Identifier: BSD-3-Clause */
/* What the shots of a film show, and when: each is read as a job of its own, from the tree of the
 * film into which its keys are merged, and placed behind those before it. */
#include "key.h"
#include "segcast/job.h"

#include <math.h>

/* ---- keys that shots cannot have ---- */

/* Log that a key holds for the whole film. @return as sc_yaml_fail. */
static sc_status refuse_film_key(const sc_ctx *ctx, const sc_yaml *item)
{
    return sc_yaml_fail(
        ctx, item,
        "%s holds for the whole film, not for one of its shots; write it outside of shots",
        item->key);
}

/* Refuse keys in and below @p node that hold for the whole film, and remove them, so that nothing
 * else is said of them. @param keys, container as of sc_key: what the node is. @return the first
 * mistake; all are logged. */
static sc_status refuse_film_keys(const sc_ctx *ctx, const sc_key *keys, sc_container container,
                                  sc_yaml *node)
{
    sc_status status = SC_OK;

    for (size_t i = 0; i < node->count;) {
        sc_yaml *item = node->items[i];
        const sc_key *key =
            container == SC_CONTAINER_MAP && item->key ? sc_key_find(keys, item->key) : NULL;

        if (key && key->scope.of_film) {
            (void)sc_goes_on(&status, refuse_film_key(ctx, item));
            sc_yaml_remove(node, i);
            continue;
        }
        if (key && key->keys)
            (void)sc_goes_on(&status, refuse_film_keys(ctx, key->keys, key->type->container, item));
        else if (container == SC_CONTAINER_DICT)
            (void)sc_goes_on(&status, refuse_film_keys(ctx, keys, SC_CONTAINER_MAP, item));
        i++;
    }
    return status;
}

/* Leave only those keys of a shot that it has from the job, and may have. @return the first mistake
 * in them, or of an unknown key; all are logged. */
static sc_status keep_job_keys(const sc_ctx *ctx, sc_yaml *shot)
{
    sc_status status = SC_OK;

    for (size_t i = 0; i < shot->count;) {
        sc_yaml *item = shot->items[i];
        const sc_key *key = sc_key_find(sc_shot_keys, item->key);

        if (key && key->scope.of_job) {
            (void)sc_goes_on(&status, refuse_film_keys(ctx, key->keys, key->type->container, item));
            i++;
            continue;
        }
        if (!key)
            (void)sc_goes_on(&status, sc_key_find(sc_job_keys, item->key)
                                          ? refuse_film_key(ctx, item)
                                          : sc_key_unknown(ctx, sc_shot_keys, item));
        sc_yaml_remove(shot, i);
    }
    return status;
}

/* ---- what shots take from the film ---- */

/* Move the members of the map "tissues" of @p shot behind those of @p tree, where there may be some
 * of the same name: a later entry wins key by key. */
static sc_status move_tissues(const sc_ctx *ctx, sc_yaml *tree, sc_yaml *shot)
{
    sc_yaml *from = sc_yaml_member(shot, "tissues"), *to = sc_yaml_member(tree, "tissues");

    if (!from || !to || from->kind != SC_YAML_MAP || to->kind != SC_YAML_MAP)
        return SC_OK;
    for (size_t i = 0; i < from->count; i++) {
        sc_yaml *member = from->items[i];

        from->items[i] = NULL;
        SC_PASS(sc_yaml_append(ctx, to, member));
    }
    sc_yaml_remove(shot, sc_yaml_index(shot, "tissues"));
    return SC_OK;
}

/* Remove the key @p name from a tree, if it is there. */
static void drop(sc_yaml *tree, const char *name)
{
    if (sc_yaml_member(tree, name))
        sc_yaml_remove(tree, sc_yaml_index(tree, name));
}

/* Remove all keys but @p name from the map @p of of a tree, if it is there. */
static void drop_others(sc_yaml *tree, const char *of, const char *name)
{
    sc_yaml *map = sc_yaml_member(tree, of);

    for (size_t i = map && map->kind == SC_YAML_MAP ? map->count : 0; i-- > 0;) {
        if (strcmp(map->items[i]->key, name))
            sc_yaml_remove(map, i);
    }
}

/* Remove from the tree of the film what a title card has no use for: light, floor, tissues, colours
 * by values with their bar, all of the animation but its length, and all of the image but its path,
 * which the card's own keys of the image ask for. Times of the film may well lie behind the end of
 * a card. */
static void drop_unused(sc_yaml *tree)
{
    sc_yaml *overlays = sc_yaml_member(tree, "overlays"), *render = sc_yaml_member(tree, "render");

    drop_others(tree, "animation", "frames");
    drop_others(tree, "image", "path");
    if (overlays && overlays->kind == SC_YAML_MAP)
        drop(overlays, "color_bar");
    if (render && render->kind == SC_YAML_MAP)
        drop(render, "stage");
    drop(tree, "color_by");
    drop(tree, "light");
    drop(tree, "tissues");
}

/* Make the tree of a shot's job: that of the film with the keys of the shot. Caller owns *out:
 * sc_yaml_free. *mistakes becomes the first mistake in these keys; all are logged. */
static sc_status merge_shot(const sc_ctx *ctx, const sc_yaml *base, const sc_yaml *node,
                            sc_yaml **out, sc_status *mistakes)
{
    SC_OWN(sc_yaml_free_at) sc_yaml *tree = NULL, *shot = NULL;
    sc_yaml *keys;

    SC_PASS(sc_yaml_copy(ctx, base, &tree));
    SC_PASS(sc_yaml_copy(ctx, node, &shot));
    if (sc_yaml_member(shot, "card"))
        drop_unused(tree);
    *mistakes = keep_job_keys(ctx, shot);
    SC_PASS(move_tissues(ctx, tree, shot));
    SC_HAND_OVER(shot, &keys);
    SC_PASS(sc_settings_merge(ctx, sc_job_keys, tree, keys));
    SC_HAND_OVER(tree, out);
    return SC_OK;
}

/* Pictures of one film are all transparent, or none is. Another background of the shot is replaced
 * by that of the film. */
static sc_status check_background(const sc_ctx *ctx, const sc_yaml *node, const sc_job *film,
                                  sc_job *job)
{
    if (job->render.background.is_none == film->render.background.is_none)
        return SC_OK;
    job->render.background = film->render.background;
    return sc_yaml_fail(
        ctx, sc_key_node(node, "render.background"),
        "background: either all shots have none, or no shot has; write none outside of shots");
}

/* Read the job of a shot. @return the first mistake; all are logged. */
static sc_status load_shot(const sc_ctx *ctx, const sc_job_sources *sources, const sc_yaml *base,
                           const sc_yaml *node, const sc_job *film, sc_shot *shot)
{
    sc_job *job = &shot->job;
    SC_OWN(sc_yaml_free_at) sc_yaml *tree = NULL;
    sc_status status = SC_OK, mistakes;
    sc_clock clock;

    if (node->kind != SC_YAML_MAP)
        return SC_OK; /* which has been told */
    SC_PASS(sc_keys_set_defaults(ctx, sc_job_keys, job));
    SC_PASS(merge_shot(ctx, base, node, &tree, &mistakes));
    SC_PASS(sc_look_apply(ctx, tree));
    sc_clock_start(job, false, tree, &clock);
    if (sc_goes_on(&status, mistakes) &&
        sc_goes_on(&status, sc_keys_read(ctx, sc_job_keys, tree, job)) &&
        sc_goes_on(&status, check_background(ctx, node, film, job)))
        (void)sc_goes_on(&status, sc_job_check(ctx, sources, tree, job));
    /* A card has none of the film: see drop_unused. */
    job->tissues.film_rules = sc_yaml_member(node, "card") ? 0
                              : film->tissues.rule_count < job->tissues.rule_count
                                  ? film->tissues.rule_count
                                  : job->tissues.rule_count;
    return status;
}

/* ---- where they lie in the film ---- */

/* @return a length in frames. */
static double frames_of(const sc_length *length, int fps)
{
    return length->in_frames ? length->value : floor(length->value * fps + 0.5);
}

/* @return the unit in which a length was given. */
static const char *unit_of(const sc_length *length)
{
    return length->in_frames ? "frames" : "s";
}

/* @return the number of frames of a transition. */
static double transition_frames(const sc_shot *shot, int fps)
{
    const sc_shot_transition *t = &shot->transition;

    return t->kind != SC_TRANSITION_CUT ? frames_of(&t->length, fps) : 0;
}

/* Fill in how long shot @p i fades out, if it does so. */
static sc_status find_fade_out(const sc_ctx *ctx, const sc_job *film, size_t i, sc_shot_span *span)
{
    const sc_shot *shot = &film->film.shots[i];
    const sc_shot_transition *next =
        &film->film.shots[i + 1 < film->film.shot_count ? i + 1 : i].transition;
    const double frames = frames_of(&shot->fade_out, film->output.fps);

    if (!shot->has_fade_out)
        return SC_OK;
    if (i + 1 < film->film.shot_count && next->kind != SC_TRANSITION_CUT)
        return sc_fail(
            ctx, SC_ERR_DATA,
            "%s: shot %zu has a fade_out, but shot %zu follows with a %s; leave one of the two out",
            shot->where, i + 1, i + 2, next->kind == SC_TRANSITION_FADE ? "fade" : "cross_fade");
    if (frames < 1 || frames > SC_JOB_FRAMES_MAX)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: the fade_out of shot %zu is %g %s, which makes %.0f frames at %d "
                       "frames per second, expected 1 or more",
                       shot->where, i + 1, shot->fade_out.value, unit_of(&shot->fade_out), frames,
                       film->output.fps);
    span->fade_out_frames = (int)frames;
    return SC_OK;
}

/* Fill in the span of shot @p i, but not yet its first frame. @return SC_ERR_DATA, logged, if it
 * cannot begin as it is to. */
static sc_status find_span(const sc_ctx *ctx, const sc_job *film, size_t i)
{
    sc_shot *shot = &film->film.shots[i];
    const sc_shot_transition *t = &shot->transition;
    const double frames = transition_frames(shot, film->output.fps);

    if (t->kind == SC_TRANSITION_CROSS_FADE && i == 0)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: the first shot has a cross-fade, but there is no shot before it; "
                       "expected cut, or fade",
                       shot->where);
    if (t->kind != SC_TRANSITION_CUT && (frames < 1 || frames > SC_JOB_FRAMES_MAX))
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: the transition of shot %zu is %g %s, which makes %.0f frames at %d "
                       "frames per second, expected 1 or more",
                       shot->where, i + 1, t->length.value, unit_of(&t->length), frames,
                       film->output.fps);
    shot->span = (sc_shot_span){.frames = shot->job.animation.frames,
                                .transition = t->kind,
                                .transition_frames = (int)frames};
    return find_fade_out(ctx, film, i, &shot->span);
}

/* Refuse shots that are shorter than their transitions. @param spans [shot_count]. @return the
 * first mistake; all are logged. */
static sc_status check_lengths(const sc_ctx *ctx, const sc_job *film, const sc_shot_span *spans)
{
    sc_status status = SC_OK;

    for (size_t i = 0; i < film->film.shot_count; i++) {
        const int used = sc_shot_transitions(spans, (int)film->film.shot_count, (int)i);

        if (used > spans[i].frames)
            (void)sc_goes_on(
                &status, sc_fail(ctx, SC_ERR_DATA,
                                 "%s: shot %zu has %d frame%s (%.3g s), but the transitions at its "
                                 "beginning and its end take %d; make it longer, or them shorter",
                                 film->film.shots[i].where, i + 1, spans[i].frames,
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

    for (size_t i = 0; i < film->film.shot_count; i++) {
        (void)sc_goes_on(&status, find_span(ctx, film, i));
        spans[i] = film->film.shots[i].span;
        frames += spans[i].frames;
        all_cards = all_cards && film->film.shots[i].has_card;
    }
    if (status == SC_OK && frames > SC_JOB_FRAMES_MAX)
        return sc_yaml_fail(ctx, node, "the shots have %.0f frames, expected at most %d", frames,
                            SC_JOB_FRAMES_MAX);
    if (all_cards)
        (void)sc_goes_on(
            &status,
            sc_yaml_fail(ctx, node,
                         "all shots are title cards; expected at least one that shows the volume"));
    SC_PASS(status);
    SC_PASS(check_lengths(ctx, film, spans));
    film->animation.frames = sc_shots_place(spans, (int)film->film.shot_count);
    for (size_t i = 0; i < film->film.shot_count; i++)
        film->film.shots[i].span = spans[i];
    return SC_OK;
}

sc_status sc_shots_resolve(const sc_ctx *ctx, const sc_job_sources *sources, const sc_yaml *base,
                           const sc_yaml *shots, sc_job *job)
{
    sc_status status = SC_OK;

    for (size_t i = 0; i < job->film.shot_count; i++) {
        if (!sc_goes_on(&status,
                        load_shot(ctx, sources, base, shots->items[i], job, &job->film.shots[i])))
            break;
    }
    return status == SC_OK && job->film.shot_count ? place_shots(ctx, shots, job) : status;
}
