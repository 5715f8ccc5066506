/* SPDX-License-Identifier: BSD-3-Clause */
/* Light that is gathered: its memory, and when it has to be gathered anew. */
#include "gather.h"

#include "directions.h"
#include "internal.h"

#include <string.h>

/* Make the directions of all parts. */
static void make_directions(sc_gather *g)
{
    for (uint32_t i = 0; i < SC_GATHER_PARTS * SC_GATHER_DIRECTIONS; i++) {
        double point[2], direction[3];

        sc_sobol_point(i, 1, point);
        sc_cosine_direction(point, direction);
        for (int k = 0; k < 3; k++)
            g->local[i / SC_GATHER_DIRECTIONS][i % SC_GATHER_DIRECTIONS][k] = (float)direction[k];
    }
}

/* Allocate what does not depend on the number of places. */
static sc_status allocate_fields(const sc_ctx *ctx, bool inner, sc_gather *g)
{
    const sc_renderer *r = g->renderer;
    const size_t bricks = sc_brick_count(r->volume->bricks),
                 labels = (size_t)r->volume->label_count;

    SC_PASS(SC_ALLOC(ctx, SC_GATHER_PARTS, &g->local));
    SC_PASS(SC_ALLOC(ctx, SC_GATHER_DIRECTIONS * labels, &g->absent));
    SC_PASS(SC_ALLOC(ctx, labels, &g->cuts));
    SC_PASS(SC_ZALLOC(ctx, labels, &g->tissues));
    g->fields[0].border = &r->volume->outer;
    g->fields[1].border = &r->volume->inner;
    for (int k = 0; k < (inner ? SC_GATHER_FIELDS : 1); k++) {
        SC_PASS(SC_ALLOC(ctx, bricks, &g->fields[k].masks));
        SC_PASS(SC_ALLOC(ctx, bricks, &g->fields[k].start));
        SC_PASS(SC_ZALLOC(ctx, g->fields[k].border->count + 1, &g->fields[k].around));
    }
    return SC_OK;
}

/* Allocate what belongs to places. */
static sc_status allocate_places(const sc_ctx *ctx, sc_gather *g)
{
    const size_t count = g->count + 1; /* there may be none */

    SC_PASS(SC_ALLOC(ctx, count, &g->places));
    for (int i = 0; i < SC_GATHER_DIRECTIONS; i++)
        SC_PASS(SC_ALLOC(ctx, count, &g->hits[i]));
    SC_PASS(SC_ALLOC(ctx, count, &g->sky));
    SC_PASS(SC_ALLOC(ctx, count, &g->light));
    SC_PASS(SC_ALLOC(ctx, count, &g->radiosity));
    return SC_ZALLOC(ctx, count, &g->gone);
}

/* Free the gather at @p g. For SC_OWN. */
static void free_at(sc_gather **g)
{
    sc_gather_free(*g);
}

/* Do what a rank does for itself. */
static sc_status begin(const sc_ctx *ctx, bool inner, sc_gather *g)
{
    SC_PASS(allocate_fields(ctx, inner, g));
    make_directions(g);
    sc_gather_mark_places(g);
    SC_PASS(allocate_places(ctx, g));
    sc_gather_fill_places(g);
    return sc_gather_mark_occupied(ctx, g);
}

sc_status sc_gather_new(const sc_ctx *ctx, const sc_renderer *r, bool inner, sc_gather **out)
{
    SC_OWN(free_at) sc_gather *g = NULL;
    sc_status status = SC_ZALLOC(ctx, 1, &g);

    if (status == SC_OK) {
        g->renderer = r;
        status = begin(ctx, inner, g);
    }
    /* No rank begins what all do together before all have come as far. */
    SC_PASS(sc_team_agree(r->team, status));
    SC_PASS(sc_gather_find_distances(ctx, g));
    SC_HAND_OVER(g, out);
    return SC_OK;
}

/* @return whether what the planes of a scene keep is convex, the same for all tissues. */
static bool is_convex(const sc_scene *scene)
{
    for (int set = 1; set < scene->clip_set_count; set++) {
        if (scene->clip_sets[set] != scene->clip_sets[0])
            return false;
    }
    return scene->clip_mode == SC_CLIP_KEEP || scene->plane_count < 2;
}

static bool same_plane(const sc_plane *a, const sc_plane *b)
{
    return a->normal.x == b->normal.x && a->normal.y == b->normal.y && a->normal.z == b->normal.z &&
           a->offset_mm == b->offset_mm;
}

/* @return whether two scenes are cut in the same way. */
static bool same_planes(const sc_scene *a, const sc_scene *b)
{
    bool same = a->plane_count == b->plane_count && a->clip_mode == b->clip_mode &&
                a->clip_set_count == b->clip_set_count;

    for (int i = 0; same && i < a->plane_count; i++)
        same = same_plane(&a->planes[i], &b->planes[i]);
    for (int i = 0; same && i < a->clip_set_count; i++)
        same = a->clip_sets[i] == b->clip_sets[i];
    return same;
}

static bool same_color(const sc_march_tissue *a, const sc_march_tissue *b)
{
    return a->diffuse == b->diffuse && a->rgb[0] == b->rgb[0] && a->rgb[1] == b->rgb[1] &&
           a->rgb[2] == b->rgb[2];
}

/* @return whether the tissues of the march let through as much light as those of the last scene; @p
 * colors_too: and have their colours. */
static bool same_tissues(const sc_gather *g, bool colors_too)
{
    const sc_renderer *r = g->renderer;
    bool same = true;

    for (int id = 1; same && id < r->volume->label_count; id++) {
        const sc_march_tissue *a = &r->tissues[id], *b = &g->tissues[id];

        same = a->show == b->show && a->clip_set == b->clip_set &&
               a->boundary_alpha == b->boundary_alpha && (!colors_too || same_color(a, b));
    }
    return same;
}

void sc_gather_scene(sc_gather *g, sc_renderer *r, const sc_scene *scene)
{
    const bool convex = is_convex(scene);
    const bool traced = g->is_known && same_tissues(g, false) && convex == g->is_convex &&
                        (convex || same_planes(scene, &g->scene));
    const bool summed = traced && same_tissues(g, true) && same_planes(scene, &g->scene);

    for (int k = 0; k < SC_GATHER_FIELDS; k++)
        r->march.around[k] = g->fields[k].around;
    if (summed)
        return;
    g->is_convex = convex;
    g->is_known = false;
    if (!traced)
        sc_gather_trace(g, scene);
    if (sc_is_given_up(r))
        return;
    sc_gather_sum(g);
    memcpy(g->tissues, r->tissues, (size_t)r->volume->label_count * sizeof *r->tissues);
    g->scene = *scene;
    g->is_known = true;
}

void sc_gather_free(sc_gather *g)
{
    if (!g)
        return;
    for (int k = 0; k < SC_GATHER_FIELDS; k++) {
        sc_free(g->fields[k].masks);
        sc_free(g->fields[k].start);
        sc_free(g->fields[k].around);
    }
    sc_free(g->local);
    sc_free(g->absent);
    sc_free(g->cuts);
    sc_free(g->sides);
    sc_free(g->occupied);
    sc_free(g->distances);
    sc_free(g->tissues);
    sc_free(g->places);
    for (int i = 0; i < SC_GATHER_DIRECTIONS; i++)
        sc_free(g->hits[i]);
    sc_free(g->sky);
    sc_free(g->light);
    sc_free(g->radiosity);
    sc_free(g->gone);
    sc_free(g);
}

uint64_t sc_gather_bytes(const sc_gather *g)
{
    const sc_prepared *v = g ? g->renderer->volume : NULL;
    uint64_t bytes = 0;

    for (int k = 0; g && k < SC_GATHER_FIELDS; k++) {
        if (g->fields[k].masks)
            bytes += sc_brick_count(v->bricks) * (sizeof(uint64_t) + sizeof(uint32_t)) +
                     g->fields[k].border->count * sizeof(uint32_t);
    }
    return g ? bytes + g->count * (sizeof *g->places + SC_GATHER_DIRECTIONS * sizeof *g->hits[0] +
                                   3 * sizeof *g->sky + sizeof *g->gone)
             : 0;
}
