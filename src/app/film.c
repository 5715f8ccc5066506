/* SPDX-License-Identifier: BSD-3-Clause */
/* The shots of a film: each has a session of its own, which borrows the volume. A frame of the film
 * is one of a shot, or two mixed. A job without shots is its own only shot. */
#include "app.h"

#include <string.h>

struct sc_film {
    int count;           /* of shots */
    sc_session *shots;   /* [count], owned */
    sc_shot_span *spans; /* [count], owned */
    sc_mixer mixer;      /* the same on all ranks */
    sc_image other;      /* the second picture of a cross-fade; empty until the first one */
};

int sc_film_shot_count(const sc_session *session)
{
    return session->film ? session->film->count : 1;
}

sc_session *sc_film_shot(sc_session *session, int i)
{
    return session->film ? &session->film->shots[i] : session;
}

sc_renderer *sc_film_renderer(const sc_session *session, int i)
{
    const int phases = sc_session_phase_count(session);

    if (session->compare) {
        const sc_session *part = sc_compare_part(session, i);

        return part ? part->renderer : NULL; /* what is written beside the pictures has none */
    }
    if (!session->film)
        return i < phases ? sc_session_phase_renderer(session, i) : NULL;
    for (int s = 0; s < session->film->count; s++) {
        const sc_session *shot = &session->film->shots[s];

        if (!shot->renderer || shot->borrows_renderer)
            continue;
        if (i < phases)
            return sc_session_phase_renderer(shot, i);
        i -= phases;
    }
    return NULL;
}

uint64_t sc_film_renderer_bytes(const sc_session *session, uint64_t *derived)
{
    sc_renderer *renderer;
    uint64_t bytes = 0;

    *derived = 0;
    for (int i = 0; (renderer = sc_film_renderer(session, i)) != NULL; i++) {
        bytes += sc_renderer_bytes(renderer);
        *derived += sc_renderer_derived_bytes(renderer);
    }
    return bytes;
}

/* ---- messages that name the shot ---- */

/* What a shot does with a message. */
typedef struct speaker {
    sc_app app; /* as that of the film, but with the context below */
    sc_ctx ctx;
    sc_app *film; /* borrowed */
    const sc_shot *shot;
    int number; /* of the shot, from 1 */
} speaker;

/* Pass a message on, for sc_ctx.write: an error or a warning with the number and the name of the
 * shot, unless it begins with the file in which the shot stands, so that it tells its place
 * already. */
static void write_with_shot(void *user, sc_log_level level, const char *text)
{
    const speaker *s = user;
    const sc_ctx *ctx = s->film->ctx;
    const char *name = s->shot->name, *colon = strrchr(s->shot->where, ':');
    const size_t length = colon ? (size_t)(colon - s->shot->where) : 0;

    if (level > SC_LOG_WARN || (length > 0 && !strncmp(text, s->shot->where, length)))
        ctx->write(ctx->user, level, text);
    else if (level == SC_LOG_WARN)
        sc_warn(ctx, "shot %d%s%s%s: %s", s->number, name[0] ? " (" : "", name, name[0] ? ")" : "",
                text);
    else
        (void)sc_fail(ctx, SC_ERR_INTERNAL, "shot %d%s%s%s: %s", s->number, name[0] ? " (" : "",
                      name, name[0] ? ")" : "", text);
}

/* Begin to speak for shot @p i of a session. */
static void begin_to_speak(sc_app *app, const sc_film *film, int i, speaker *out)
{
    *out = (speaker){
        .app = *app, .ctx = *app->ctx, .film = app, .shot = film->shots[i].shot, .number = i + 1};
    out->app.ctx = &out->ctx;
    if (!app->ctx->write)
        return;
    out->ctx.rank = 0; /* that of the film's context is told */
    out->ctx.write = write_with_shot;
    out->ctx.user = out;
}

/* Keep what the film is to know of what was said. */
static void end_to_speak(speaker *s)
{
    s->film->font_told = s->app.font_told;
}

/* ---- making it ---- */

/* Leave out of a title card what belongs to a volume. */
static void strip_card(sc_job *job)
{
    sc_overlays *o = &job->overlays;

    o->scale_bar = o->color_bar = o->orientation = o->legend = SC_PLACE_NONE;
    job->overlay_tissue_count = 0;
    job->output.layout = SC_LAYOUT_PICTURE;
}

/* Begin the session of a shot. What it borrows is the film's. */
static void begin_shot(const sc_session *session, const sc_shot *shot, sc_session *out)
{
    *out = (sc_session){.measure = session->measure,
                        .job = shot->job,
                        .mapped = session->mapped,
                        .mapped_bytes = session->mapped_bytes,
                        .shared_bytes = session->shared_bytes,
                        .labels = session->labels,
                        .stats = session->stats,
                        .volume = session->volume,
                        .phases = session->phases,
                        .grey = session->grey,
                        .grey_window = session->grey_window,
                        .grey_hash = session->grey_hash,
                        .shot = shot};
    /* The command may have changed what holds for the whole film. */
    out->job.output = session->job.output;
    out->job.output.layout = shot->job.output.layout;
    out->job.farm = session->job.farm;
    out->job.render.cpu = session->job.render.cpu;
    out->job.render.skip = session->job.render.skip;
    if (shot->has_card)
        strip_card(&out->job);
}

/* Allocate the film of a session. */
static sc_status new_film(const sc_ctx *ctx, sc_session *session)
{
    const size_t count = session->job.shot_count;
    sc_film *film;
    void *block;
    sc_status status;

    SC_TRY(sc_zalloc(ctx, 1, sizeof *film, &block));
    session->film = film = block;
    SC_TRY(sc_zalloc(ctx, count, sizeof *film->shots, &block));
    film->shots = block;
    SC_TRY(sc_zalloc(ctx, count, sizeof *film->spans, &block));
    film->spans = block;
    for (size_t i = 0; i < count; i++) {
        film->spans[i] = session->job.shots[i].span;
        begin_shot(session, &session->job.shots[i], &film->shots[i]);
    }
    film->count = (int)count;
out:
    return status;
}

/* Give all shots that leave their background to be chosen the one that was chosen for @p from. */
static void share_background(sc_film *film, const sc_session *from)
{
    for (int i = 0; i < film->count; i++) {
        sc_background *background = &film->shots[i].job.render.background;

        if (!background->is_auto)
            continue;
        memmove(background->rgb, from->job.render.background.rgb, sizeof background->rgb);
        background->is_auto = false;
    }
}

sc_status sc_film_open(sc_app *app, sc_session *session)
{
    const bool first = sc_comm_rank(app->comm) == 0;
    speaker voice;
    sc_film *film;
    bool chosen = false;
    sc_status status = SC_OK;

    if (!session->job.shot_count)
        return SC_OK;
    SC_TRY(sc_comm_agree(app->comm, new_film(app->ctx, session)));
    film = session->film;
    if (first)
        sc_mixer_init(&film->mixer);
    sc_comm_broadcast(app->comm, &film->mixer, sizeof film->mixer);
    for (int i = 0; i < film->count; i++) {
        sc_session *shot = &film->shots[i];

        if (shot->shot->has_card)
            continue;
        begin_to_speak(app, film, i, &voice);
        SC_TRY(sc_session_tissues(&voice.app, shot));
        if (!chosen) /* for title cards, also if the shot has one of its own */
            share_background(film, shot);
        chosen = true;
    }
out:
    return status;
}

/* ---- renderers ---- */

static bool are_same_bytes(const void *a, const void *b, size_t bytes)
{
    return memcmp(a, b, bytes) == 0;
}

/* Do two shots, whose tissues are resolved, draw in the same way? All keys that are added later are
 * compared, too. Should bytes between two members differ without a reason, each has its renderer,
 * and draws the same. */
static bool draws_alike(const sc_session *a, const sc_session *b)
{
    const sc_grey_tracks *grey = &a->job.image.shown, *other = &b->job.image.shown;

    return !a->shot->has_card &&
           are_same_bytes(&a->job.render, &b->job.render, sizeof a->job.render) &&
           are_same_bytes(&a->job.light, &b->job.light, sizeof a->job.light) &&
           are_same_bytes(&a->job.light_tracks, &b->job.light_tracks, sizeof a->job.light_tracks) &&
           are_same_bytes(&grey->caps, &other->caps, sizeof grey->caps) &&
           are_same_bytes(&grey->slices, &other->slices, sizeof grey->slices) &&
           sc_track_most(&grey->backdrop_track, grey->backdrop) ==
               sc_track_most(&other->backdrop_track, other->backdrop) &&
           are_same_bytes(a->tissues, b->tissues,
                          (size_t)a->volume.label_count * sizeof *a->tissues);
}

/* Fill the renderer of shot @p i: that of an earlier one, if it draws in the same way. */
static sc_status find_renderer(sc_app *app, sc_film *film, int i)
{
    sc_session *shot = &film->shots[i];
    int same = 0;

    if (sc_comm_rank(app->comm) == 0) {
        while (same < i && !draws_alike(&film->shots[same], shot))
            same++;
    }
    sc_comm_broadcast(app->comm, &same, sizeof same);
    if (same == i)
        return sc_shot_renderer(app, shot);
    shot->renderer = film->shots[same].renderer;
    shot->phase_renderers = film->shots[same].phase_renderers;
    shot->borrows_renderer = true;
    return SC_OK;
}

/* Make all that a title card needs to be drawn. */
static sc_status make_card(sc_app *app, sc_session *shot)
{
    sc_timeline_resolve(&shot->job.animation, NULL, 0, sc_session_aspect(shot), &shot->timeline);
    sc_session_looks(shot);
    return sc_session_letter(app, shot);
}

/* Make all that the shots of a film need to be drawn. */
static sc_status make_shots(sc_app *app, sc_session *session)
{
    sc_film *film = session->film;
    speaker voice;
    sc_status status = SC_OK;

    for (int i = 0; i < film->count; i++) {
        sc_session *shot = &film->shots[i];

        if (shot->shot->has_card) {
            SC_TRY(make_card(app, shot));
            continue;
        }
        SC_TRY(find_renderer(app, film, i));
        begin_to_speak(app, film, i, &voice);
        status = sc_shot_timeline(&voice.app, shot);
        end_to_speak(&voice);
        if (status != SC_OK)
            return status;
        if (!session->renderer) /* for those who ask about drawing at all */
            session->renderer = shot->renderer;
        session->borrows_renderer = true;
    }
out:
    return status;
}

sc_status sc_session_scene(sc_app *app, sc_session *session)
{
    double wall_s, cpu_s;
    sc_status status;

    if (session->job.has_compare && !session->compare)
        SC_TRY(sc_compare_load(app, session));
    wall_s = sc_wall_s();
    cpu_s = sc_cpu_s();
    if (session->compare)
        SC_TRY(sc_compare_grey(app, session));
    else
        SC_TRY(sc_session_grey(app, session));
    sc_stage_begin(app->ctx, "preparing the light", 0, 0);
    SC_TRY(sc_film_open(app, session));
    if (session->film) {
        SC_TRY(make_shots(app, session));
    } else if (session->compare) {
        SC_TRY(sc_compare_scene(app, session));
    } else {
        SC_TRY(sc_session_tissues(app, session));
        SC_TRY(sc_shot_renderer(app, session));
        SC_TRY(sc_shot_timeline(app, session));
    }
    sc_session_unload_phase(session, 0); /* names and flights look into its voxels */
    sc_add_time(app, &session->times, SC_PHASE_PREPARE, wall_s, cpu_s);
out:
    return status;
}

sc_status sc_session_volume(sc_app *app, sc_session *session)
{
    const sc_status status = sc_session_load(app, session);

    return status == SC_OK ? sc_session_scene(app, session) : status;
}

/* ---- drawing ---- */

/* As sc_shot_draw, of a title card. */
static sc_status draw_card(const sc_app *app, sc_session *session, const sc_scene *scene,
                           const sc_rows *rows, sc_image *image, sc_render_stats *stats)
{
    const sc_annotations annotations = sc_session_annotations(session);

    *stats = (sc_render_stats){0};
    sc_draw_background(scene, rows, image);
    return sc_annotations_draw(app->ctx, &annotations, scene, image, rows);
}

static sc_status draw_shot(const sc_app *app, sc_session *shot, const sc_scene *scene,
                           const sc_rows *rows, sc_image *image, sc_render_stats *stats)
{
    return (shot->shot && shot->shot->has_card ? draw_card : sc_shot_draw)(app, shot, scene, rows,
                                                                           image, stats);
}

/* Draw the shot that goes, mix it into @p image, and add what that took to @p stats. */
static sc_status mix_before(const sc_app *app, sc_film *film, const sc_film_frame *at,
                            const sc_rows *part, sc_image *image, sc_render_stats *stats)
{
    sc_session *before = &film->shots[at->before];
    const sc_scene scene = sc_session_scene_at(before, at->before_frame);
    sc_render_stats more;
    sc_status status = SC_OK;

    if (!film->other.rgb)
        SC_TRY(sc_image_init_alpha(app->ctx, image->width_px, image->height_px, image->alpha,
                                   &film->other));
    SC_TRY(draw_shot(app, before, &scene, part, &film->other, &more));
    sc_render_stats_add(stats, &more);
    sc_image_mix(&film->mixer, &film->other, at->share, part->first, part->end, image);
out:
    return status;
}

/* @return what frame @p k shows: as of sc_film_frame_at, also where there are no shots. */
static sc_film_frame film_frame_at(const sc_session *session, int k)
{
    const sc_film *film = session->film;

    return film ? sc_film_frame_at(film->spans, film->count, k)
                : (sc_film_frame){.frame = k, .before = -1, .share = 1};
}

sc_status sc_session_draw(const sc_app *app, sc_session *session, int k, const sc_rows *rows,
                          sc_image *image, sc_render_stats *stats)
{
    const int first = rows && rows->first > 0 ? rows->first : 0;
    const sc_rows part = {first,
                          rows && rows->end < image->height_px ? rows->end : image->height_px};
    sc_film *film = session->film;
    const sc_film_frame at = film_frame_at(session, k);
    sc_session *shot = sc_film_shot(session, at.shot);
    sc_scene scene;
    sc_status status;

    if (session->compare)
        return sc_compare_draw(app, session, k, rows, image, stats);
    scene = sc_session_scene_at(shot, at.frame);
    SC_TRY(draw_shot(app, shot, &scene, rows, image, stats));
    if (at.before >= 0)
        SC_TRY(mix_before(app, film, &at, &part, image, stats));
    else if (at.share < 1)
        sc_image_fade(&film->mixer, scene.look.background, at.share, part.first, part.end, image);
out:
    return status;
}

sc_status sc_session_draw_frame(const sc_app *app, sc_session *session, int k, const sc_rows *rows,
                                sc_image *image, sc_frame_result *result)
{
    sc_render_stats stats = {0};
    const sc_status status = sc_session_draw(app, session, k, rows, image, &stats);

    result->frame = k;
    result->render_wall_s = stats.wall_s;
    result->render_cpu_s = stats.cpu_s;
    result->rays = stats.counters.rays;
    result->samples = stats.counters.cell_visits;
    result->contributions = stats.counters.contributions;
    /* The renderer leaves tiles out when the frame is to be given up. */
    return status == SC_OK && *sc_signals_give_up() ? SC_ERR_INCOMPLETE : status;
}

void sc_session_counts(sc_session *session, int k, const int size_px[2], sc_march_counters *out,
                       sc_render_stats *stats)
{
    const sc_film_frame at = film_frame_at(session, k);
    sc_session *shot = sc_film_shot(session, at.shot);
    sc_scene scene;

    if (session->compare) {
        sc_compare_counts(session, k, size_px, out, stats);
        return;
    }
    if (shot->renderer) {
        scene = sc_session_scene_at(shot, at.frame);
        sc_render_counts(sc_session_begin_frame(shot, at.frame), &scene, size_px[0], size_px[1],
                         out, stats);
        return;
    }
    memset(out, 0, (size_t)size_px[0] * (size_t)size_px[1] * sizeof *out); /* a title card */
    *stats = (sc_render_stats){0};
}

/* ---- the end ---- */

void sc_session_move_volume(sc_session *from, sc_session *to)
{
    sc_phases_unload(from->phases);
    to->shared = from->shared;
    to->shared_bytes = from->shared_bytes;
    to->mapped = from->mapped;
    to->mapped_bytes = from->mapped_bytes;
    to->watched = from->watched;
    to->labels = from->labels;
    to->volume = from->volume;
    to->phases = from->phases;
    from->shared = NULL;
    from->mapped = NULL;
    from->mapped_bytes = 0;
    from->watched = NULL;
    from->labels = NULL;
    from->phases = NULL;
}

/* Free a film; NULL is allowed. */
static void free_film(sc_film *film)
{
    if (!film)
        return;
    for (int i = 0; i < film->count; i++)
        sc_shot_clear(&film->shots[i]); /* those that lend a renderer do not use it any more */
    sc_free(film->shots);
    sc_free(film->spans);
    sc_image_clear(&film->other);
    sc_free(film);
}

void sc_session_clear(sc_session *session)
{
    free_film(session->film);
    sc_compare_free(session);
    sc_shot_clear(session);
    sc_phases_free(session->phases);
    sc_shared_free(session->grey_codes);
    sc_session_clear_volume(session);
    sc_job_clear(&session->job);
    *session = (sc_session){0};
}
