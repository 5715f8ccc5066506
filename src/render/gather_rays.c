/* SPDX-License-Identifier: BSD-3-Clause */
/* The rays along which light is gathered, and what they meet: the vertices on the side of tissue,
 * instead of the smooth surface that passes beside them, which takes a tenth of the time. */
#include "directions.h"
#include "gather.h"
#include "internal.h"

#include <string.h>

/* So much of each ray is free, in voxels: vertices reach out from the surface that they belong to
 * by half the diagonal of a voxel. */
#define START_VOXELS 0.9f

/* Note which vertices of bricks [begin, end) are on the side of tissue: an sc_range_fn on a gather.
 */
static void mark_sides(void *user, size_t begin, size_t end, int thread)
{
    const sc_gather *g = user;
    const sc_prepared *v = g->renderer->volume;

    (void)thread;
    for (size_t brick = begin; brick < end; brick++) {
        const bool uniform = !v->near[brick] && !v->outer.masks[brick];
        uint64_t mask = 0;
        int low[3];

        sc_brick_low(v->bricks, brick, low);
        for (int bit = 0; bit < SC_BRICK_VERTICES; bit++) {
            const int x = low[0] + sc_bit_x(bit), y = low[1] + sc_bit_y(bit),
                      z = low[2] + sc_bit_z(bit);

            if (sc_is_voxel(v, x, y, z) &&
                (uniform ? sc_id_at_vertex(v, x, y, z) : sc_vertex_at(v, x, y, z).outer_value > 0))
                mask |= 1ull << bit;
            else if (uniform && sc_is_voxel(v, x, y, z))
                break;
        }
        g->sides[brick] = mask;
    }
}

/* @return the vertices of a brick that are on the side of tissue that is met. */
static uint64_t occupied(const sc_gather *g, size_t brick, const int low[3])
{
    const sc_prepared *v = g->renderer->volume;
    uint64_t mask = g->sides[brick];

    if (!g->absent_now || !mask)
        return mask;
    if (!v->near[brick]) {
        const int bit = __builtin_ctzll(mask);

        return g->absent_now[sc_id_at_vertex(v, low[0] + sc_bit_x(bit), low[1] + sc_bit_y(bit),
                                             low[2] + sc_bit_z(bit))]
                   ? 0
                   : mask;
    }
    for (uint64_t left = mask; left; left &= left - 1) {
        const int bit = __builtin_ctzll(left);
        const uint32_t id = sc_id_at_vertex(v, low[0] + sc_bit_x(bit), low[1] + sc_bit_y(bit),
                                            low[2] + sc_bit_z(bit));

        if (g->absent_now[id]) /* tissue that the smoothing has put where none was counts as met */
            mask &= ~(1ull << bit);
    }
    return mask;
}

/* Set the masks of bricks [begin, end) to what is met now, and where one is empty let rays step
 * across it: an sc_range_fn on a gather. */
static void mark_occupied(void *user, size_t begin, size_t end, int thread)
{
    const sc_gather *g = user;
    const int *bricks = g->renderer->volume->bricks;

    (void)thread;
    for (size_t brick = begin; brick < end; brick++) {
        int low[3], at[3];
        size_t framed;

        sc_brick_at(bricks, brick, at);
        sc_brick_low(bricks, brick, low);
        framed = (size_t)sc_framed_index(sc_framed_row(bricks), sc_framed_layer(bricks), at[0],
                                         at[1], at[2]);
        g->occupied[framed] = occupied(g, brick, low);
        g->distances[framed] = g->occupied[framed] ? 0 : g->far[framed] ? g->far[framed] : 1;
    }
}

/* Rays of one direction of several places, which are followed together. */
typedef struct volley {
    sc_gather_ray rays[SC_RAY_BATCH];
    sc_gather_hit hits[SC_RAY_BATCH];
    uint32_t from[SC_RAY_BATCH]; /* places */
    size_t count;
} volley;

void sc_gather_direction(const sc_gather *g, const sc_gather_place *p, int i, float out[3])
{
    const double n[3] = {p->normal[0], p->normal[1], p->normal[2]};
    const float *local = g->local[p->part][i];
    double t[3], b[3];

    sc_frame_about(n, t, b);
    for (int k = 0; k < 3; k++)
        out[k] = (float)(local[0] * t[k] + local[1] * b[k] + local[2] * n[k]);
}

/* Fill in the ray number @p i of a place. */
static void make_ray(const sc_gather *g, const sc_gather_place *p, int i, sc_gather_ray *ray)
{
    float d[3], length;

    sc_gather_direction(g, p, i, d);
    for (int k = 0; k < 3; k++)
        ray->direction[k] = sc_dot(g->renderer->march.grid_per_mm[k], d);
    length = sqrtf(sc_dot(ray->direction, ray->direction));
    for (int k = 0; k < 3; k++) {
        ray->direction[k] /= length;
        ray->origin[k] = p->at[k] + START_VOXELS * ray->direction[k];
    }
}

/* @return the number of the place at vertex @p q that looks towards a ray in direction @p d (RAS):
 * that of the border to air, else that between tissues; SC_GATHER_LOST if none does. */
static int32_t place_facing(const sc_gather *g, const int32_t q[3], const float d[3])
{
    for (int k = 0; k < SC_GATHER_FIELDS; k++) {
        const int32_t place = sc_gather_place_at(g, &g->fields[k], q);

        if (place >= 0 && sc_dot(g->places[place].normal, d) < 0)
            return place;
    }
    return SC_GATHER_LOST;
}

/* @return the number of the place that a ray has met at vertex @p q; where that looks away, one
 * beside it, across a thin sheet; SC_GATHER_LOST if there is none. */
static int32_t place_met(const sc_gather *g, const int32_t q[3], const float d[3])
{
    const int *size = g->renderer->volume->size;
    int32_t place = place_facing(g, q, d);

    for (int i = 0; i < 6 && place == SC_GATHER_LOST; i++) {
        int32_t at[3] = {q[0], q[1], q[2]};

        at[i >> 1] += i & 1 ? 1 : -1;
        if (at[i >> 1] >= 0 && at[i >> 1] <= size[i >> 1] + 1)
            place = place_facing(g, at, d);
    }
    return place;
}

/* Follow the rays of a volley, of direction number @p i, and note what they meet. */
static void follow_volley(sc_gather *g, const sc_gather_march *march, int i, volley *v)
{
    g->follow(march, v->rays, v->count, v->hits);
    for (size_t k = 0; k < v->count; k++) {
        const uint32_t from = v->from[k];
        float d[3];

        g->hits[i][from] = SC_GATHER_FREE;
        if (v->hits[k].at[0] < 0)
            continue;
        sc_gather_direction(g, &g->places[from], i, d);
        g->hits[i][from] = place_met(g, v->hits[k].at, d);
    }
    v->count = 0;
}

/* Trace the rays of direction g->direction of places [begin, end): an sc_range_fn on a gather. */
static void trace(void *user, size_t begin, size_t end, int thread)
{
    sc_gather *g = user;
    const sc_renderer *r = g->renderer;
    volley v;

    (void)thread;
    v.count = 0;
    for (size_t at = begin; at < end; at++) {
        if (!r->tissues[g->places[at].tissue].show) {
            g->hits[g->direction][at] = SC_GATHER_FREE;
            continue;
        }
        v.from[v.count] = (uint32_t)at;
        make_ray(g, &g->places[at], g->direction, &v.rays[v.count++]);
        if (v.count == SC_RAY_BATCH)
            follow_volley(g, &g->march, g->direction, &v);
    }
    follow_volley(g, &g->march, g->direction, &v);
}

/* Set which tissues the rays of each direction do not meet: those that are hidden, and of those
 * that let light through, each by its opacity, a share of the directions. */
static void set_absent(sc_gather *g)
{
    const sc_renderer *r = g->renderer;

    for (int i = 0; i < SC_GATHER_DIRECTIONS; i++) {
        bool *absent = g->absent + (size_t)i * (size_t)r->volume->label_count;

        absent[0] = false;
        for (int id = 1; id < r->volume->label_count; id++) {
            double point[2];

            sc_sobol_point((uint32_t)i, sc_mix((uint32_t)id, 2), point);
            absent[id] = !r->tissues[id].show || point[0] >= r->tissues[id].boundary_alpha;
        }
    }
}

/* Set which planes cut which tissue. */
static void set_planes(sc_gather *g, const sc_scene *scene)
{
    const sc_renderer *r = g->renderer;
    const sc_march *m = &r->march;

    g->march.plane_count = g->is_convex ? 0 : m->plane_count;
    g->march.cut_away = m->cut_away;
    g->march.cuts = g->cuts;
    memcpy(g->march.plane_equations, m->plane_equations, sizeof m->plane_equations);
    for (int id = 0; id < r->volume->label_count; id++)
        g->cuts[id] = scene->clip_sets[r->tissues[id].clip_set];
}

sc_status sc_gather_mark_occupied(const sc_ctx *ctx, sc_gather *g)
{
    const sc_renderer *r = g->renderer;
    const sc_prepared *v = r->volume;
    const size_t bricks = sc_brick_count(v->bricks);
    int framed[3];
    size_t count;

    sc_framed_size(v->bricks, framed);
    count = sc_brick_count(framed);
    SC_PASS(SC_ALLOC(ctx, bricks, &g->sides));
    SC_PASS(SC_ZALLOC(ctx, count, &g->occupied));
    SC_PASS(SC_ZALLOC(ctx, count + SC_GATHER_BYTES, &g->distances));
    sc_parallel_for(r->settings.threads, bricks, 1024, mark_sides, g);
    for (int id = 0; id < v->label_count; id++)
        g->absent[id] = !r->looks[id].show;
    g->absent_now = g->absent;
    g->far = g->distances; /* not yet known */
    sc_parallel_for(r->settings.threads, bricks, 1024, mark_occupied, g);
    return SC_OK;
}

sc_status sc_gather_find_distances(const sc_ctx *ctx, sc_gather *g)
{
    const sc_renderer *r = g->renderer;
    const sc_prepared *v = r->volume;

    SC_PASS(sc_brick_distances(ctx, r->team, v->bricks, g->occupied, &g->far));
    g->march = (sc_gather_march){.volume = v,
                                 .masks = g->occupied,
                                 .distances = g->distances,
                                 .row = sc_framed_row(v->bricks),
                                 .layer = sc_framed_layer(v->bricks)};
    for (int i = 0; i < 3; i++) {
        g->march.box_low[i] = fmaxf(r->march.box_low[i], 0);
        g->march.box_high[i] = fminf(r->march.box_high[i] + 1, (float)(v->size[i] + 2));
    }
    g->follow = sc_gather_find(r->settings.cpu);
    return SC_OK;
}

void sc_gather_trace(sc_gather *g, const sc_scene *scene)
{
    const sc_renderer *r = g->renderer;
    const size_t labels = (size_t)r->volume->label_count;

    set_absent(g);
    set_planes(g, scene);
    for (g->direction = 0; g->direction < SC_GATHER_DIRECTIONS && !sc_is_given_up(r);
         g->direction++) {
        const bool *absent = g->absent + (size_t)g->direction * labels;

        if (!g->direction || memcmp(absent, absent - labels, labels) != 0) {
            g->absent_now = absent;
            sc_parallel_for(r->settings.threads, sc_brick_count(r->volume->bricks), 4096,
                            mark_occupied, g);
        }
        sc_parallel_for(r->settings.threads, g->count, 4096, trace, g);
    }
}
