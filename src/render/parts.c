/* SPDX-License-Identifier: BSD-3-Clause */
/* Tissues that move from their places. Those that do so together form a part, which is drawn as if
 * there were no other tissues: from masks, distances and a map of its own, by a camera that is
 * moved the opposite way. march.c puts together what a ray meets in the parts.
 *
 * As long as parts touch, they shade each other as before; the further they are apart, the more of
 * that shade goes. */
#include "internal.h"

#include <string.h>

/* So far apart, in voxels, parts do not shade each other: two widths of the wide blur of the
 * occlusion. */
#define APART_VOXELS 24.0
enum { WHOLE = 256 /* of the weights with which occlusions are mixed */ };

/* ---- making ---- */

/* @return the bytes of an occlusion as the march reads it; those beyond the bricks are 0. */
static size_t occlusion_bytes(const sc_renderer *r)
{
    return 2 * (sc_brick_count(r->derived.occlusion.size) + SC_GATHER_BYTES);
}

/* Make what the rank has for itself of part @p p, but for what is derived from the volume. @param
 * mine [label_count] the looks of its tissues, all others being invisible. */
static sc_status begin_part(const sc_ctx *ctx, sc_renderer *r, const sc_tissue *mine, sc_part *part,
                            uint8_t *show, float *opacity)
{
    const size_t labels = (size_t)r->volume->label_count;
    sc_renderer *own;

    SC_PASS(SC_ZALLOC(ctx, 1, &own));
    part->renderer = own;
    own->settings = r->settings;
    own->volume = r->volume;
    own->kernel = r->kernel;
    own->team = r->team;
    own->space.to_voxel = r->space.to_voxel;
    own->fades.groups = r->fades.groups;
    own->bounds.has_tight_blocks = true;
    SC_PASS(SC_ALLOC(ctx, labels, &own->tissues));
    SC_PASS(SC_ZALLOC(ctx, labels, &own->looks));
    SC_PASS(sc_alloc(ctx, SC_COVER_SIDE, SC_COVER_SIDE, &own->cover.squares));
    if (r->derived.occlusion.filled) {
        SC_PASS(sc_zalloc(ctx, occlusion_bytes(r), 1, &part->mixed));
    }
    sc_fill_tissues(own, mine, show, opacity);
    sc_fill_boxes(own);
    return SC_OK;
}

/* Derive from the volume what part @p p is drawn from. Collective in r->team. */
static sc_status derive_part(const sc_ctx *ctx, const sc_renderer *r, sc_part *part,
                             const uint8_t *show, const float *opacity)
{
    sc_renderer *own = part->renderer;

    SC_PASS(sc_find_visible(ctx, own, show));
    if (r->derived.occlusion.filled) {
        SC_PASS(sc_occlusion_build(ctx, r->team, r->volume, opacity, &own->derived.occlusion));
        part->filled = own->derived.occlusion.filled;
    }
    sc_decide_cover(own);
    if (!own->cover.covers_all)
        SC_PASS(sc_find_blocks(ctx, own));
    return SC_OK;
}

/* Note which tissues are those of part @p p: sets label and amount. @param mine as of begin_part.
 * @return whether there are any that can be seen. */
static bool choose_tissues(const sc_renderer *r, const sc_tissue *tissues, int p, sc_part *part,
                           sc_tissue *mine)
{
    for (int id = 0; id < r->volume->label_count; id++) {
        mine[id] = tissues[id];
        mine[id].visible = tissues[id].visible && tissues[id].part == p;
        if (!id || tissues[id].part != p || !r->tissues[id].show || !r->volume->stats[id].voxels)
            continue;
        part->label = id;
        part->amount += tissues[id].opacity * (double)r->volume->stats[id].voxels;
    }
    return part->label > 0;
}

/* Make all parts. @param mine, show, opacity room for [label_count]. Collective in r->team. */
static sc_status make_all(const sc_ctx *ctx, sc_renderer *r, const sc_tissue *tissues,
                          sc_tissue *mine, uint8_t *show, float *opacity)
{
    for (int p = 0; p < r->parts->count; p++) {
        sc_part *part = &r->parts->list[p];

        if (!choose_tissues(r, tissues, p, part, mine))
            continue;
        /* No rank begins what all do together before all have come as far. */
        SC_PASS(sc_team_agree(r->team, begin_part(ctx, r, mine, part, show, opacity)));
        SC_PASS(derive_part(ctx, r, part, show, opacity));
    }
    return SC_OK;
}

/* Allocate r->parts, with the rooms of the threads. @param count of parts. */
static sc_status allocate(const sc_ctx *ctx, sc_renderer *r, int count)
{
    const size_t threads = (size_t)r->settings.work.threads;

    SC_PASS(SC_ZALLOC(ctx, 1, &r->parts));
    r->parts->count = count;
    SC_PASS(SC_ALLOC(ctx, threads, &r->parts->rooms));
    SC_PASS(SC_ALLOC(ctx, threads * (size_t)count * SC_APART_BATCH, &r->parts->ways));
    for (size_t i = 0; i < threads; i++)
        r->parts->rooms[i].ways = r->parts->ways + i * (size_t)count * SC_APART_BATCH;
    return SC_ALLOC(ctx, (size_t)SC_COVER_SIDE * SC_COVER_SIDE, &r->parts->met);
}

sc_status sc_parts_make(const sc_ctx *ctx, sc_renderer *r, const sc_tissue *tissues)
{
    const size_t labels = (size_t)r->volume->label_count;
    int count = 1;
    SC_OWN(sc_free_at) sc_tissue *mine = NULL;
    SC_OWN(sc_free_at) uint8_t *show = NULL;
    SC_OWN(sc_free_at) float *opacity = NULL;
    sc_status status;

    for (size_t id = 1; id < labels; id++)
        count = tissues[id].part >= count ? tissues[id].part + 1 : count;
    if (count == 1)
        return SC_OK;
    status = allocate(ctx, r, count);
    if (status == SC_OK)
        status = SC_ALLOC(ctx, labels, &mine);
    if (status == SC_OK)
        status = SC_ALLOC(ctx, labels, &show);
    if (status == SC_OK)
        status = SC_ALLOC(ctx, labels, &opacity);
    SC_PASS(sc_team_agree(r->team, status));
    return make_all(ctx, r, tissues, mine, show, opacity);
}

void sc_parts_free(sc_renderer *r)
{
    if (!r->parts)
        return;
    for (int p = 0; p < r->parts->count; p++) {
        sc_part *part = &r->parts->list[p];

        sc_free(part->mixed);
        if (!part->renderer)
            continue;
        sc_free(part->renderer->tissues);
        sc_free(part->renderer->looks);
        sc_free(part->renderer->cover.squares);
        sc_free(part->renderer);
    }
    sc_free(r->parts->rooms);
    sc_free(r->parts->ways);
    sc_free(r->parts->met);
    sc_free(r->parts);
    r->parts = NULL;
}

uint64_t sc_parts_bytes(const sc_renderer *r)
{
    const uint64_t labels = (uint64_t)r->volume->label_count;
    uint64_t bytes = 0;

    if (!r->parts)
        return 0;
    for (int p = 0; p < r->parts->count; p++) {
        if (r->parts->list[p].renderer)
            bytes += sizeof *r + labels * (sizeof *r->tissues + sizeof *r->looks) +
                     (uint64_t)SC_COVER_SIDE * SC_COVER_SIDE +
                     (r->parts->list[p].mixed ? occlusion_bytes(r) : 0);
    }
    return bytes + sizeof *r->parts +
           (uint64_t)SC_COVER_SIDE * SC_COVER_SIDE * sizeof *r->parts->met +
           (uint64_t)r->settings.work.threads *
               (sizeof *r->parts->rooms +
                (uint64_t)r->parts->count * SC_APART_BATCH * sizeof *r->parts->ways);
}

/* ---- the occlusion of a part ---- */

/* A mixture of two occlusions, which threads share. */
typedef struct mixture {
    const uint8_t (*all)[2], (*own)[2];
    int all_weight, own_weight; /* in 256ths */
    uint8_t (*to)[2];
} mixture;

/* Mix bricks [begin, end); an sc_range_fn on a mixture. */
static void mix_bricks(void *user, size_t begin, size_t end, int thread)
{
    const mixture *m = user;
    const uint8_t *all = m->all[begin], *own = m->own[begin];
    uint8_t *to = m->to[begin];
    /* Together at most WHOLE: so 16 bits are enough, and the loop is vectorised. */
    const uint16_t all_weight = (uint16_t)m->all_weight, own_weight = (uint16_t)m->own_weight;

    for (size_t i = 0; i < 2 * (end - begin); i++) {
        to[i] =
            (uint8_t)((uint16_t)(all[i] * all_weight + own[i] * own_weight + WHOLE / 2) / WHOLE);
    }
}

/* @return how far part @p p is from the others, 0 to 1: the mean over all of them, by how much
 * there is of each. */
static double apartness(const sc_renderer *r, int p, const sc_vec3 *offsets_mm)
{
    const double most_mm = APART_VOXELS * (double)r->march.voxel_mm;
    double sum = 0, amount = 0;

    for (int q = 0; q < r->parts->count; q++) {
        const sc_part *a = &r->parts->list[p], *b = &r->parts->list[q];
        double share;

        if (q == p || !b->renderer)
            continue;
        share = fmin(1, sc_vec3_length(sc_vec3_sub(offsets_mm[a->label], offsets_mm[b->label])) /
                            most_mm);
        sum += b->amount * share * share * (3 - 2 * share);
        amount += b->amount;
    }
    return amount > 0 ? sum / amount : 0;
}

/* @return how much of a part is left while its tissues fade: the mean, by how much there is of
 * each, at most 1. */
static double share_left(const sc_renderer *own, const float *factors)
{
    double left = 0, amount = 0;

    for (int id = 1; id < own->volume->label_count && factors; id++) {
        const double each = own->looks[id].show
                                ? own->looks[id].opacity * (double)own->volume->stats[id].voxels
                                : 0;

        left += each * fmin(1, (double)factors[id]);
        amount += each;
    }
    return amount > 0 ? left / amount : 1;
}

/* Set the occlusion of part @p p: that of all tissues as long as the part is among them, and its
 * own when it is far from them. @param share of apartness(). */
static void set_occlusion(const sc_renderer *r, int p, double share, const sc_scene *scene)
{
    sc_part *part = &r->parts->list[p];
    sc_occlusion *to = &part->renderer->derived.occlusion;
    int weights[2 + SC_FADE_GROUPS_MAX] = {0};
    mixture m = {.all = r->derived.occlusion.filled, .own = part->filled, .to = part->mixed};

    if (!r->derived.occlusion.filled)
        return;
    m.all_weight = WHOLE - (int)floor(WHOLE * share + 0.5);
    m.own_weight =
        (int)floor((WHOLE - m.all_weight) * share_left(part->renderer, scene->fades) + 0.5);
    to->filled = r->derived.occlusion.filled;
    if (m.all_weight == WHOLE)
        return;
    weights[0] = m.all_weight;
    weights[1] = m.own_weight;
    if (r->derived.occlusion.filled != r->fades.base)
        memcpy(weights + 2, r->fades.mixed_weights, sizeof r->fades.mixed_weights);
    if (memcmp(weights, part->mixed_weights, sizeof weights) != 0) {
        memcpy(part->mixed_weights, weights, sizeof weights);
        sc_parallel_for(r->settings.work.threads, sc_brick_count(to->size), 16384, mix_bricks, &m);
    }
    to->filled = (const uint8_t(*)[2])part->mixed;
}

/* ---- for each view ---- */

/* Set the march of a part to that of all, but for what follows from its tissues. */
static void set_march(const sc_renderer *r, sc_renderer *own)
{
    const sc_box3 *box = &own->space.box;

    own->march = r->march;
    own->march.marked.masks = own->derived.visible;
    own->march.marked.distances = own->derived.distances;
    own->march.marked.pyramid = &own->derived.pyramid;
    own->march.marked.cell_distances = own->derived.cell_distances;
    own->march.marked.cell_start = own->derived.cell_start;
    own->march.marked.cells = own->derived.cells;
    own->march.tissues = own->tissues;
    own->march.occlusion = r->march.occlusion ? &own->derived.occlusion : NULL;
    for (int i = 0; i < 3; i++) { /* grid coordinates are those of voxels plus one */
        own->march.box_low[i] = (float)(i == 0 ? box->low.x : i == 1 ? box->low.y : box->low.z) + 1;
        own->march.box_high[i] = (float)(i == 0   ? box->high.x
                                         : i == 1 ? box->high.y
                                                  : box->high.z) +
                                 1;
    }
}

/* Set part @p p up for a view. */
static void begin_view(sc_renderer *r, int p, const sc_scene *scene, const sc_viewport *viewport)
{
    sc_part *part = &r->parts->list[p];
    sc_renderer *own = part->renderer;
    const double share = apartness(r, p, scene->offsets_mm);

    set_march(r, own);
    own->march.around_share = (float)(1 - share); /* it was gathered where the tissues touch */
    sc_set_fades(own, scene->fades);
    sc_set_colors(own, scene->colors);
    sc_set_clip_sets(own, scene);
    set_occlusion(r, p, share, scene);
    own->behind.on_white = own->march;
    for (int i = 0; i < 3; i++)
        own->behind.on_white.light.cue_rgb[i] = 1;
    part->is_shown = false;
    for (int id = 1; id < r->volume->label_count; id++)
        part->is_shown = part->is_shown || own->tissues[id].show;
    part->scene = *scene;
    part->scene.camera.position_mm =
        sc_vec3_sub(scene->camera.position_mm, scene->offsets_mm[part->label]);
    sc_lens_init(&part->lens, own, &part->scene, viewport);
    sc_cover_view(own, &part->scene, viewport);
    part->cover = own->cover.map;
}

/* @return how far the middle of a part is from the camera, in mm along the direction of view. */
static double depth_of(const sc_part *part)
{
    const sc_box3 *box = &part->renderer->space.box;
    const sc_vec3 middle = sc_affine_point(&part->renderer->volume->to_ras_mm,
                                           sc_vec3_scale(sc_vec3_add(box->low, box->high), 0.5));
    const sc_camera *camera = &part->scene.camera;

    return sc_vec3_dot(sc_vec3_sub(middle, camera->position_mm), camera->forward);
}

/* Set parts->met from the maps of all that are shown. */
static void find_met(sc_parts *parts)
{
    const size_t squares = (size_t)parts->layout.columns * (size_t)parts->layout.rows;

    memset(parts->met, 0, squares * sizeof *parts->met);
    for (int k = 0; k < parts->shown_count; k++) {
        const uint8_t *levels = parts->list[parts->shown[k]].cover.squares;
        const uint64_t bit = (uint64_t)1 << parts->shown[k];

        for (size_t i = 0; i < squares; i++)
            parts->met[i] |= levels[i] ? bit : 0;
    }
}

void sc_parts_begin(sc_renderer *r, const sc_scene *scene, const sc_viewport *viewport)
{
    sc_parts *parts = r->parts;

    if (!parts)
        return;
    parts->are_apart = false;
    parts->shown_count = 0;
    for (int p = 1; p < parts->count && scene->offsets_mm; p++) {
        const sc_part *part = &parts->list[p];

        parts->are_apart = parts->are_apart ||
                           (part->renderer && sc_vec3_length(scene->offsets_mm[part->label]) > 0);
    }
    for (int p = 0; p < parts->count && parts->are_apart; p++) {
        int at = parts->shown_count;

        if (!parts->list[p].renderer)
            continue;
        begin_view(r, p, scene, viewport);
        if (!parts->list[p].is_shown)
            continue;
        for (; at > 0 && depth_of(&parts->list[parts->shown[at - 1]]) > depth_of(&parts->list[p]);
             at--)
            parts->shown[at] = parts->shown[at - 1];
        parts->shown[at] = p;
        parts->shown_count++;
    }
    parts->layout = r->cover.map;              /* of the same view */
    parts->are_apart = parts->shown_count > 0; /* all may have faded away */
    if (parts->are_apart)
        find_met(parts);
}
