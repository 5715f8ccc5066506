/* SPDX-License-Identifier: BSD-3-Clause */
/* Where the names beside the tissues stand, in all frames of a film. */
#include "internal.h"

#include <math.h>

#define FADE_S 0.4      /* time in which a name appears or disappears */
#define FADE_FRAMES 30  /* ... but at most so many frames, */
#define FADE_SHARE 24.0 /* and at most one frame of so many of the film */

/* What the threads fill. */
typedef struct planner {
    const sc_ctx *ctx;
    sc_name_film *film;
    sc_name_plan *plan;
    sc_status *statuses; /* [count] of the anchors */
    int fade_frames;
} planner;

/* Find the anchors of some names. sc_range_fn. */
static void find_anchors(void *user, size_t begin, size_t end, int thread)
{
    const planner *p = user;

    for (size_t n = begin; n < end; n++)
        p->statuses[n] = sc_find_anchors(p->ctx, p->film->a->volume, p->film->words[n]->number,
                                         &p->film->anchors[n]);
}

/* The names of one side of a frame, the largest tissue first, and then from top to bottom. */
typedef struct side_names {
    int count, names[SC_NAMES_MAX];
    double shown[SC_NAMES_MAX], room[SC_NAMES_MAX], alpha[SC_NAMES_MAX];
} side_names;

/* Sort the names of a side, which have their room, from top to bottom. */
static void sort_names(const sc_name_state *states, side_names *s)
{
    for (int i = 1; i < s->count; i++) {
        const int name = s->names[i];
        const double room = s->room[i], alpha = s->alpha[i];
        int j = i;

        for (; j > 0 && states[s->names[j - 1]].dot_px[1] > states[name].dot_px[1]; j--) {
            s->names[j] = s->names[j - 1];
            s->room[j] = s->room[j - 1];
            s->alpha[j] = s->alpha[j - 1];
        }
        s->names[j] = name;
        s->room[j] = room;
        s->alpha[j] = alpha;
    }
}

/* Place the names of one side of a frame. @param shown of all names of the film. */
static void place_side(const planner *p, int k, int side, const double *shown)
{
    const sc_name_film *film = p->film;
    const sc_name_state *states = &film->states[k * film->count];
    const sc_columns *columns = &film->columns[k];
    const double rows = (film->high_px[side] - film->low_px[side]) / film->row_px;
    double want_px[SC_NAMES_MAX], at_px[SC_NAMES_MAX];
    side_names s = {0};

    for (int n = 0; n < film->count; n++) {
        if (states[n].anchor < 0 || states[n].right != side)
            continue;
        s.shown[s.count] = shown[n];
        s.names[s.count++] = n;
    }
    sc_share_rows(s.shown, s.count, rows, s.room, s.alpha);
    sort_names(states, &s);
    for (int i = 0; i < s.count; i++) {
        want_px[i] = (double)states[s.names[i]].dot_px[1];
        s.room[i] *= film->row_px;
    }
    sc_spread(want_px, s.room, s.count, film->low_px[side], film->high_px[side], at_px);
    for (int i = 0; i < s.count; i++) {
        sc_name_place *place =
            &p->plan->places[(size_t)k * (size_t)film->count + (size_t)s.names[i]];

        memcpy(place->dot_px, states[s.names[i]].dot_px, sizeof place->dot_px);
        place->elbow_px = (float)columns->elbow_px[side];
        place->label_px[0] = (float)columns->edge_px[side];
        place->label_px[1] = (float)at_px[i];
        place->alpha = (uint8_t)(255 * s.alpha[i] + 0.5);
        place->is_right = (uint8_t)side;
        place->is_crowded = s.alpha[i] <= 0 && shown[s.names[i]] > 0.9;
    }
}

/* Place the names of some frames. sc_range_fn. */
static void place_frames(void *user, size_t begin, size_t end, int thread)
{
    const planner *p = user;

    for (size_t k = begin; k < end; k++) {
        double shown[SC_NAMES_MAX];

        sc_name_fades(p->film, (int)k, p->fade_frames, shown);
        place_side(p, (int)k, 0, shown);
        place_side(p, (int)k, 1, shown);
    }
}

/* Let the columns end before a rectangle that overlays take at a place, if it reaches into them. A
 * column is taken to be as wide as its half of the picture, as its edge follows the camera. */
static void end_before(const sc_viewport *taken, int place, int margin_px, sc_name_film *film)
{
    const sc_viewport *within = &film->a->within;
    const int middle_px = within->x_px + within->width_px / 2;
    const int begin_px[2] = {within->x_px, middle_px};
    const int end_px[2] = {middle_px, within->x_px + within->width_px};
    const int bottom_px = taken->y_px + taken->height_px;

    if (taken->y_px >= within->y_px + within->height_px || bottom_px <= within->y_px)
        return;
    for (int side = 0; side < 2; side++) {
        if (taken->x_px >= end_px[side] || taken->x_px + taken->width_px <= begin_px[side])
            continue;
        if (place <= SC_PLACE_TOP_RIGHT)
            film->low_px[side] = fmax(film->low_px[side], bottom_px + margin_px);
        else
            film->high_px[side] = fmin(film->high_px[side], taken->y_px - margin_px);
    }
}

/* Let the columns end before the overlays @p a: where they stand, and where a caption does in any
 * frame. @return SC_ERR_MEMORY. */
static sc_status end_before_overlays(const sc_ctx *ctx, const sc_annotations *a, sc_name_film *film)
{
    sc_image none = {.width_px = a->within.x_px + a->within.width_px,
                     .height_px = a->within.y_px + a->within.height_px};
    const sc_rows rows = {0, 0}; /* nothing is drawn: only the room that is taken matters */
    const sc_scene scene = sc_timeline_scene(a->timeline, 0, NULL);
    sc_drawing d = sc_drawing_begin(a, &scene, &none, &rows);
    sc_viewport taken[SC_PLACE_COUNT] = {{0, 0, 0, 0}};
    const sc_status status = sc_draw_fixed(ctx, &d, &scene);

    for (int place = SC_PLACE_TOP_LEFT; place < SC_PLACE_COUNT; place++) {
        if (d.taken[place].width_px)
            film->taken[film->taken_count++] = d.taken[place];
    }
    for (int k = 0; k < film->frames; k++) {
        sc_drawing with = d;

        sc_draw_captions(&with, sc_frame_time(k, film->frames));
        for (int place = SC_PLACE_TOP_LEFT; place < SC_PLACE_COUNT; place++)
            sc_hold(&taken[place], &with.taken[place]);
    }
    for (int place = SC_PLACE_TOP_LEFT; place < SC_PLACE_COUNT; place++) {
        if (taken[place].width_px)
            end_before(&taken[place], place, d.margin_px, film);
    }
    return status;
}

/* Find the height of the columns: names do not stand where other overlays do, of their own picture
 * or over the one that it is a part of. @return SC_ERR_MEMORY. */
static sc_status find_heights(const sc_ctx *ctx, sc_name_film *film)
{
    const sc_annotations *a = film->a;
    const int margin_px = sc_margin_px(a);

    for (int side = 0; side < 2; side++) {
        film->low_px[side] = a->within.y_px + margin_px;
        film->high_px[side] = a->within.y_px + a->within.height_px - margin_px;
    }
    SC_PASS(end_before_overlays(ctx, a, film));
    if (a->over && a->over->lettering)
        return end_before_overlays(ctx, a->over, film);
    return SC_OK;
}

/* @return whether there is room between the columns in any frame. */
static bool is_wide_enough(const sc_name_film *film)
{
    int k = 0;

    while (k < film->frames && film->columns[k].elbow_px[0] >= film->columns[k].elbow_px[1])
        k++;
    return k < film->frames;
}

/* Tell of names that are shown in no frame, and of those for which there is no room at times. */
static sc_status tell_left_out(const sc_ctx *ctx, const sc_name_film *film,
                               const sc_name_plan *plan)
{
    int crowded = 0, hidden = 0;
    SC_OWN(sc_text_clear) sc_text text = {0};

    if (film->count && !is_wide_enough(film)) {
        sc_warn(
            ctx,
            "overlays.names: a picture of %d x %d pixels has no room for names of tissues beside "
            "what it shows, so that none is shown; make it larger, or overlays.names_size smaller",
            film->a->within.width_px, film->a->within.height_px);
        return SC_OK;
    }
    for (int n = 0; n < film->count; n++) {
        const sc_label *label = &film->a->volume->labels[film->words[n]->number];
        bool is_named = false, is_crowded = false;

        for (int k = 0; k < film->frames; k++) {
            is_named = is_named || plan->places[k * film->count + n].alpha > 0;
            is_crowded = is_crowded || plan->places[k * film->count + n].is_crowded;
        }
        crowded += is_crowded;
        if (is_named || is_crowded)
            continue;
        SC_PASS(sc_text_add(ctx, &text, "%s", hidden++ ? ", " : ""));
        if (label->name[0])
            SC_PASS(sc_text_add(ctx, &text, "%s", label->name));
        else
            SC_PASS(sc_text_add(ctx, &text, "label %lld", (long long)label->value));
    }
    if (crowded)
        sc_warn(ctx,
                "overlays.names: in some frames there is no room for %d of %d names; name fewer "
                "tissues, or make overlays.names_size smaller",
                crowded, film->count);
    if (hidden)
        sc_info(ctx, "names that no frame shows, because their tissues are hidden%s: %s",
                film->a->divided_px ? " or behind the divider" : "", text.data);
    return SC_OK;
}

/* Fill what the places of names follow from, but for the states. @return SC_ERR_MEMORY. */
static sc_status begin_film(const sc_ctx *ctx, const sc_annotations *a, sc_name_film *film)
{
    *film = (sc_name_film){.a = a, .frames = a->timeline->animation.frames};
    for (uint64_t i = 0; i < a->lettering->count && film->count < SC_NAMES_MAX; i++) {
        const sc_word *word = &a->lettering->words[i];

        if (word->kind != SC_WORD_NAME)
            continue;
        film->words[film->count++] = word;
        film->row_px = fmax(film->row_px, word->line_px);
        film->widest_px = fmax(film->widest_px, word->advance_px);
    }
    if (!sc_affine_invert(&a->volume->to_ras_mm, &film->from_ras_mm))
        film->count = 0; /* readers refuse such a volume */
    SC_PASS(SC_ZALLOC(ctx, (size_t)film->frames, &film->columns));
    SC_PASS(SC_ZALLOC(ctx, (size_t)film->frames * (size_t)film->count + 1, &film->states));
    return find_heights(ctx, film);
}

sc_status sc_annotations_plan_names(const sc_ctx *ctx, const sc_annotations *annotations,
                                    int threads, sc_name_plan **out)
{
    const double fade_frames =
        fmin(FADE_S * annotations->fps, annotations->timeline->animation.frames / FADE_SHARE);
    sc_status statuses[SC_NAMES_MAX] = {SC_OK};
    sc_name_film film;
    planner p = {.ctx = ctx, .film = &film, .statuses = statuses};
    uint64_t bytes;
    SC_OWN(sc_free_at) void *block = NULL;
    sc_status status;

    SC_TRY(begin_film(ctx, annotations, &film));
    p.fade_frames = (int)fmax(1, fmin(FADE_FRAMES, fade_frames));
    bytes =
        sizeof *p.plan + (uint64_t)film.frames * (uint64_t)film.count * sizeof p.plan->places[0];
    SC_TRY(sc_zalloc(ctx, bytes, 1, &block));
    p.plan = block;
    p.plan->bytes = bytes;
    p.plan->frames = film.frames;
    p.plan->count = film.count;
    sc_parallel_for(threads, (size_t)film.count, 1, find_anchors, &p);
    for (int n = 0; n < film.count; n++)
        SC_TRY(statuses[n]);
    SC_TRY(sc_find_name_states(ctx, threads, &film));
    sc_parallel_for(threads, (size_t)film.frames, 1, place_frames, &p);
    SC_TRY(tell_left_out(ctx, &film, p.plan));
    *out = p.plan;
    block = NULL;
out:
    sc_free(film.columns);
    sc_free(film.states);
    return status;
}
