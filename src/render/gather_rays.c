/* SPDX-License-Identifier: BSD-3-Clause */
/* The rays along which light is gathered, and what they meet: the vertices on the side of tissue,
 * instead of the smooth surface that passes beside them, which takes a tenth of the time. */
#include "directions.h"
#include "gather.h"
#include "internal.h"

#include <string.h>

/* So much of each ray is free, in voxels: between tissues, where rays are not let past the corners
 * of vertices, these reach out by half the diagonal of a voxel from the border that they belong to.
 */
#define START_VOXELS 0.9f

/* @return the vertices of a brick that are on the side of tissue. */
static uint64_t tissue_side(const sc_prepared *v, size_t brick, const int low[3])
{
    const bool uniform = !v->boundary.masks[brick] && !v->outer.masks[brick];
    uint64_t mask = 0;

    for (int bit = 0; bit < SC_BRICK_VERTICES; bit++) {
        const int x = low[0] + sc_bit_x(bit), y = low[1] + sc_bit_y(bit),
                  z = low[2] + sc_bit_z(bit);

        if (!sc_is_voxel(v, x, y, z))
            continue;
        if (uniform ? sc_id_at_vertex(v, x, y, z) : sc_vertex_at(v, x, y, z).outer_value > 0)
            mask |= 1ull << bit;
        else if (uniform)
            break;
    }
    return mask;
}

/* Sort the vertices of @p brick on the side of tissue by label, as parts. Of tissue that the
 * smoothing has put where none was, label 0 is met always. @return how many parts there are. */
static uint32_t find_parts(const sc_prepared *v, size_t brick, sc_gather_part *out)
{
    uint64_t left;
    uint32_t count = 0;
    int low[3];

    sc_brick_low(v->bricks, brick, low);
    for (left = tissue_side(v, brick, low); left; left &= left - 1) {
        const int bit = __builtin_ctzll(left);
        const uint16_t label = (uint16_t)sc_id_at_vertex(
            v, low[0] + sc_bit_x(bit), low[1] + sc_bit_y(bit), low[2] + sc_bit_z(bit));
        uint32_t i = 0;

        if (!v->boundary.masks[brick]) {
            out[0] = (sc_gather_part){left, label};
            return 1;
        }
        while (i < count && out[i].label != label)
            i++;
        if (i == count)
            out[count++] = (sc_gather_part){0, label};
        out[i].mask |= left & -left;
    }
    return count;
}

/* Count the parts of bricks [begin, end): an sc_range_fn on a gather. */
static void count_parts(void *user, size_t begin, size_t end, int thread)
{
    sc_gather *g = user;
    sc_gather_part parts[SC_BRICK_VERTICES];

    for (size_t brick = begin; brick < end; brick++)
        g->targets.first_part[brick] = find_parts(g->renderer->volume, brick, parts);
}

/* Fill in the parts of bricks [begin, end): an sc_range_fn on a gather. */
static void fill_parts(void *user, size_t begin, size_t end, int thread)
{
    sc_gather *g = user;

    for (size_t brick = begin; brick < end; brick++) {
        if (g->targets.first_part[brick] < g->targets.first_part[brick + 1])
            (void)find_parts(g->renderer->volume, brick,
                             g->targets.parts + g->targets.first_part[brick]);
    }
}

/* @return the vertices of the brick whose lowest one is @p low that a plane keeps. */
static uint64_t kept_by(const float e[4], const int low[3])
{
    const float middle = e[0] * ((float)low[0] + 1.5f) + e[1] * ((float)low[1] + 1.5f) +
                         e[2] * ((float)low[2] + 1.5f) + e[3];
    const float reach = 2 * (fabsf(e[0]) + fabsf(e[1]) + fabsf(e[2]));
    uint64_t mask = 0;

    if (fabsf(middle) > reach)
        return middle > 0 ? ~0ull : 0;
    for (int bit = 0; bit < SC_BRICK_VERTICES; bit++) {
        const float at[3] = {(float)(low[0] + sc_bit_x(bit)), (float)(low[1] + sc_bit_y(bit)),
                             (float)(low[2] + sc_bit_z(bit))};

        mask |= (uint64_t)(sc_dot(e, at) + e[3] >= 0) << bit;
    }
    return mask;
}

/* @return the vertices of a tissue with which its planes leave it, as sc_march tells. @param keeps
 * [plane_count] those that each plane keeps. */
static uint64_t left_of(const sc_gather *g, uint16_t label, const uint64_t *keeps)
{
    const sc_march *m = &g->renderer->march;
    uint64_t left = m->planes.cut_away ? 0 : ~0ull;

    for (int i = 0; i < m->planes.count; i++) {
        const uint64_t kept = g->targets.cuts[label] >> i & 1 ? keeps[i] : ~0ull;

        left = m->planes.cut_away ? left | kept : left & kept;
    }
    return left;
}

/* Set the masks of bricks [begin, end) to what is met now, and where one is empty let rays step
 * across it: an sc_range_fn on a gather. */
static void mark_occupied(void *user, size_t begin, size_t end, int thread)
{
    const sc_gather *g = user;
    const int *bricks = g->renderer->volume->bricks;
    const int planes = g->known.is_convex ? 0 : g->renderer->march.planes.count;

    for (size_t brick = begin; brick < end; brick++) {
        const uint32_t first = g->targets.first_part[brick],
                       last = g->targets.first_part[brick + 1];
        uint64_t mask = 0, keeps[SC_PLANES_MAX];
        int at[3], low[3];
        size_t framed;

        if (first == last)
            continue; /* it stays empty */
        sc_brick_low(bricks, brick, low);
        for (int i = 0; i < planes; i++)
            keeps[i] = kept_by(g->renderer->march.planes.equations[i], low);
        for (uint32_t i = first; i < last; i++) {
            const uint16_t label = g->targets.parts[i].label;

            if (!g->batch.absent[label])
                mask |= g->targets.parts[i].mask & (planes ? left_of(g, label, keeps) : ~0ull);
        }
        sc_brick_at(bricks, brick, at);
        framed = (size_t)sc_framed_index(sc_framed_row(bricks), sc_framed_layer(bricks), at[0],
                                         at[1], at[2]);
        g->targets.occupied[framed] = mask;
        g->targets.distances[framed] = mask                     ? 0
                                       : g->targets.far[framed] ? g->targets.far[framed]
                                                                : 1;
    }
}

/* Rays of one direction of several places, which are followed together. */
typedef struct volley {
    sc_gather_ray rays[SC_RAY_BATCH];
    sc_gather_hit hits[SC_RAY_BATCH];
    float directions[SC_RAY_BATCH][3]; /* unit, RAS */
    uint32_t from[SC_RAY_BATCH];       /* places */
    size_t count;
} volley;

/* Fill in the ray of a place in direction @p d (RAS). */
static void make_ray(const sc_gather *g, const sc_gather_place *p, const float d[3],
                     sc_gather_ray *ray)
{
    float length;

    for (int k = 0; k < 3; k++)
        ray->direction[k] = sc_dot(g->renderer->march.grid_per_mm[k], d);
    length = sqrtf(sc_dot(ray->direction, ray->direction));
    for (int k = 0; k < 3; k++) {
        ray->direction[k] /= length;
        ray->origin[k] = p->at[k] + START_VOXELS * ray->direction[k];
    }
}

/* Let a ray from a point of the floor begin where it comes into the volume, and into what planes
 * keep that is convex, if it does: else beside the volume. What it meets behind that is gone. */
static void enter(const sc_gather *g, sc_gather_ray *ray)
{
    const sc_gather_march *m = &g->march;
    const sc_march *cut = &g->renderer->march;
    float near = 0, far = HUGE_VALF;

    for (int k = 0; k < 3; k++) {
        const float low = (m->box_low[k] - 0.5f - ray->origin[k]) / ray->direction[k];
        const float high = (m->box_high[k] - 0.5f - ray->origin[k]) / ray->direction[k];

        near = fmaxf(near, fminf(low, high));
        far = fminf(far, fmaxf(low, high));
    }
    for (int i = 0; i < cut->planes.count && g->known.is_convex; i++) {
        const float *e = cut->planes.equations[i];
        const float speed = sc_dot(e, ray->direction), above = sc_dot(e, ray->origin) + e[3];

        if (above < 0)
            near = speed > 0 ? fmaxf(near, -above / speed) : HUGE_VALF;
    }
    for (int k = 0; k < 3 && near > 0; k++)
        ray->origin[k] = near < far ? ray->origin[k] + (near + 1.0f / 64) * ray->direction[k] : -9;
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
        g->hits[i][v->from[k]] =
            v->hits[k].at[0] < 0 ? SC_GATHER_FREE : place_met(g, v->hits[k].at, v->directions[k]);
    }
    v->count = 0;
}

/* Trace the rays of direction g->batch.direction of places [begin, end) from g->batch.first on: an
 * sc_range_fn on a gather. */
static void trace(void *user, size_t begin, size_t end, int thread)
{
    sc_gather *g = user;
    const sc_renderer *r = g->renderer;
    volley v;

    v.count = 0;
    for (size_t at = g->batch.first + begin; at < g->batch.first + end; at++) {
        const sc_gather_place *p = &g->places[at];

        if ((at < g->floor.first && !r->tissues[p->tissue].show) ||
            (g->batch.direction >= SC_GATHER_DIRECTIONS &&
             sc_dot(g->directions[p->part][g->batch.direction], p->normal) <= 0)) {
            g->hits[g->batch.direction][at] = SC_GATHER_FREE;
            continue;
        }
        v.from[v.count] = (uint32_t)at;
        sc_gather_direction(g, p, g->batch.direction, v.directions[v.count]);
        make_ray(g, p, v.directions[v.count], &v.rays[v.count]);
        if (at >= g->floor.first)
            enter(g, &v.rays[v.count]);
        v.count++;
        if (v.count == SC_RAY_BATCH)
            follow_volley(g, &g->march, g->batch.direction, &v);
    }
    follow_volley(g, &g->march, g->batch.direction, &v);
}

/* Set which tissues the rays of each direction do not meet: those that are hidden, and of those
 * that let light through, each by its opacity, a share of the directions. */
static void set_absent(sc_gather *g)
{
    const sc_renderer *r = g->renderer;

    for (int i = 0; i < SC_GATHER_RAYS; i++) {
        bool *absent = g->targets.absent + (size_t)i * (size_t)r->volume->label_count;

        absent[0] = false;
        for (int id = 1; id < r->volume->label_count; id++) {
            double point[2];

            sc_sobol_point((uint32_t)i, sc_mix((uint32_t)id, 2), point);
            absent[id] = !r->tissues[id].show || point[0] >= r->tissues[id].boundary_alpha;
        }
    }
}

/* Mark what may be shown in bricks [begin, end): an sc_range_fn on a gather. */
static void mark_shown(void *user, size_t begin, size_t end, int thread)
{
    sc_gather *g = user;
    const sc_renderer *r = g->renderer;
    const int *bricks = r->volume->bricks;

    for (size_t brick = begin; brick < end; brick++) {
        uint64_t mask = 0;
        int at[3];

        for (uint32_t i = g->targets.first_part[brick]; i < g->targets.first_part[brick + 1]; i++) {
            const uint16_t label = g->targets.parts[i].label;

            mask |= !label || r->looks[label].show ? g->targets.parts[i].mask : 0;
        }
        sc_brick_at(bricks, brick, at);
        g->targets.shown[sc_framed_index(sc_framed_row(bricks), sc_framed_layer(bricks), at[0],
                                         at[1], at[2])] = mask;
    }
}

sc_status sc_gather_find_parts(const sc_ctx *ctx, sc_gather *g)
{
    const sc_renderer *r = g->renderer;
    const int *size = r->volume->bricks;
    const size_t bricks = sc_brick_count(size);
    uint32_t total;
    int framed[3];
    void *data;

    SC_PASS(sc_team_alloc(ctx, r->team, bricks + 1, sizeof *g->targets.first_part, &data));
    g->targets.first_part = data;
    sc_gather_for(g, bricks, 1024, count_parts);
    total = sc_gather_number(g, 0, g->targets.first_part);
    SC_PASS(sc_team_alloc(ctx, r->team, (size_t)total + 1, sizeof *g->targets.parts, &data));
    g->targets.parts = data;
    sc_gather_for(g, bricks, 1024, fill_parts);
    sc_framed_size(size, framed);
    SC_PASS(sc_team_alloc(ctx, r->team, sc_brick_count(framed), sizeof *g->targets.shown, &data));
    g->targets.shown = data;
    sc_gather_for(g, bricks, 1024, mark_shown);
    return sc_brick_distances(ctx, r->team, size, g->targets.shown, &g->targets.far);
}

void sc_gather_trace(const sc_ctx *ctx, sc_gather *g, const sc_scene *scene, bool again,
                     size_t first)
{
    const sc_renderer *r = g->renderer;
    const size_t labels = (size_t)r->volume->label_count;
    const bool *marked = NULL; /* what is met now */

    g->batch.first = first;
    set_absent(g);
    for (size_t id = 0; id < labels; id++)
        g->targets.cuts[id] = scene->clip.sets[r->tissues[id].clip_set];
    for (g->batch.direction = 0; g->batch.direction < sc_gather_rays(g) && !sc_gather_ends(g);
         g->batch.direction++) {
        const size_t row = (size_t)g->batch.direction * labels;
        const bool *absent = g->targets.absent + row;

        if (!again || (g->known.lamp_moves && g->batch.direction >= SC_GATHER_DIRECTIONS) ||
            memcmp(absent, g->targets.absent_before + row, labels) != 0) {
            if (!marked || memcmp(absent, marked, labels) != 0) {
                g->batch.absent = absent;
                sc_gather_for(g, sc_brick_count(r->volume->bricks), 4096, mark_occupied);
            }
            marked = absent;
            sc_gather_for(g, g->count - g->batch.first, 4096, trace);
        }
        if (ctx)
            sc_stage_add(ctx, 1);
    }
    memcpy(g->targets.absent_before, g->targets.absent,
           SC_GATHER_RAYS * labels * sizeof *g->targets.absent);
}
