/* SPDX-License-Identifier: BSD-3-Clause */
/* Template: rays through a grey volume that is translucent, each in a SIMD lane, with steps across
 * empty bricks. Compiled once per variant, under the name MARCH_NAME. What a ray brings back is the
 * same, bit for bit, as by backdrop.c: the samples that are passed over would add exactly nothing.
 */
#include "variants.h"

#include "backdrop.h"
#include "lanes/lanes.h"

/* How far, in voxels, a ray stays from the border of what is known to be empty: coordinates are
 * rounded. */
#define SLACK_VOXELS 0.0625f

/* Rays on their way, and what is the same for all of them. */
typedef struct packet {
    const sc_march_backdrop *b;
    vf origin[3], direction[3]; /* as of sc_backdrop_ray */
    vf base_mm;
    vf steps_per_voxel; /* that a ray takes along the axis along which it moves fastest */
    vf tone, transmittance, faded;
} packet;

/* The cells that hold a sample of each ray. */
typedef struct cells {
    vi low[3];   /* index of the voxel at the corner with the lowest x, y and z */
    vf share[3]; /* of the way from there to the next voxels */
} cells;

/* Put up to LANES rays into a packet; the other lanes get copies of the first. */
static void start_packet(packet *p, const sc_march_backdrop *b, const sc_backdrop_ray *rays,
                         int lanes)
{
    *p = (packet){.b = b, .transmittance = f_set(1)};
    for (int lane = 0; lane < LANES; lane++) {
        const sc_backdrop_ray *ray = &rays[lane < lanes ? lane : 0];
        float fastest = 0;

        for (int i = 0; i < 3; i++) {
            const float speed = ray->direction[i] < 0 ? -ray->direction[i] : ray->direction[i];

            p->origin[i][lane] = ray->origin[i];
            p->direction[i][lane] = ray->direction[i];
            fastest = speed > fastest ? speed : fastest;
        }
        p->base_mm[lane] = ray->base_mm;
        p->steps_per_voxel[lane] = 1 / (fastest * b->step_mm);
    }
}

/* Find the cells in which the rays are at the distances @p t. */
static inline void find_cells(const packet *p, vf t, cells *c)
{
    for (int i = 0; i < 3; i++) {
        const int size = p->b->grey->size[i];
        const vf last = f_set((float)(size - 1));
        const vi most = i_set(sc_lowest_max(size));
        vf x = p->origin[i] + p->direction[i] * t;
        vi low;

        x = f_pick(f_below(x, f_set(0)), f_set(0), f_pick(f_below(x, last), x, last));
        low = i_of(x);
        c->low[i] = i_pick(i_below(low, most), low, most);
        c->share[i] = x - f_of(c->low[i]);
    }
}

/* Of the lanes @p m, the distances of the bricks in which the cells lie. */
static inline vi distances_of(const packet *p, const cells *c, vm m)
{
    const int *n = p->b->bricks;
    const vi bx = (vi)((vu)c->low[0] >> 2), by = (vi)((vu)c->low[1] >> 2),
             bz = (vi)((vu)c->low[2] >> 2);
    const vi brick = (bz + SC_BRICK_FRAME) * sc_framed_layer(n) +
                     (by + SC_BRICK_FRAME) * sc_framed_row(n) + bx + SC_BRICK_FRAME;

    return i_gather(p->b->distances, brick, m) & 0xff;
}

/* Of the lanes @p m, the values in codes, as value_at of backdrop.c finds them. */
static inline vf values_in(const packet *p, const cells *c, vm m)
{
    const sc_march_grey *g = p->b->grey;
    const int row = g->size[0], layer = g->size[0] * g->size[1];
    const int up = g->size[1] > 1 ? 2 * row : 0, over = g->size[2] > 1 ? 2 * layer : 0;
    const vi first = 2 * (c->low[0] + c->low[1] * row + c->low[2] * layer);
    vf lines[4];

    for (int k = 0; k < 4; k++) {
        const vi both = i_gather(g->codes, first + ((k & 1 ? up : 0) + (k & 2 ? over : 0)), m);

        lines[k] = f_lerp(f_of(both & 0xffff), f_of((vi)((vu)both >> 16)), c->share[0]);
    }
    return f_lerp(f_lerp(lines[0], lines[1], c->share[1]), f_lerp(lines[2], lines[3], c->share[1]),
                  c->share[2]);
}

/* Add the samples of the lanes @p m, at the distances @p t. @param part of a step for which each
 * stands. */
static inline void add_samples(packet *p, const cells *c, vf t, vf part, vm m)
{
    const sc_march_backdrop *b = p->b;
    const vf value = values_in(p, c, m);
    const vf place =
        f_clamp01((value - b->grey->black) * b->grey->white_less) * (float)SC_BACKDROP_STEPS + 0.5f;
    const vi index =
        4 * i_pick(f_below(place, f_set(SC_BACKDROP_STEPS)), i_of(place), i_set(SC_BACKDROP_STEPS));
    const vf alpha = f_gather(b->alphas, index, m), tone = f_gather(b->tones, index, m);
    const vf share = p->transmittance * part;
    const vf away = b->cue * f_clamp01((p->base_mm + t - b->cue_near_mm) * b->cue_per_mm);

    p->tone = f_pick(m, p->tone + share * tone * (1 - away), p->tone);
    p->faded = f_pick(m, p->faded + share * alpha * away, p->faded);
    p->transmittance = f_pick(m, p->transmittance * (1 - part * alpha), p->transmittance);
}

/* Follow stretch number @p stretch of the rays that have one. */
static void follow(packet *p, const sc_backdrop_ray *rays, int lanes, int stretch)
{
    const sc_march_backdrop *b = p->b;
    const float steps_per_mm = 1 / b->step_mm;
    vf begin = {0}, length = {0};
    vi k = {0};

    for (int lane = 0; lane < lanes; lane++) {
        if (stretch >= rays[lane].stretches)
            continue;
        begin[lane] = rays[lane].begin_mm[stretch];
        length[lane] = rays[lane].end_mm[stretch] - rays[lane].begin_mm[stretch];
    }
    for (;;) {
        const vf from = f_of(k) * b->step_mm, left = (length - from) * steps_per_mm;
        const vf part = f_pick(f_below(left, f_set(1)), left, f_set(1));
        const vf t = begin + (from + part * (0.5f * b->step_mm));
        const vm alive =
            m_and(f_below(from, length), f_at_most(f_set(SC_OPAQUE), p->transmittance));
        cells c;
        vi distance, steps;
        vm found;

        if (!m_any(alive))
            break;
        find_cells(p, t, &c);
        distance = distances_of(p, &c, alive);
        found = m_and(alive, i_equal(distance, i_set(0)));
        if (m_any(found))
            add_samples(p, &c, t, part, found);
        /* Whatever lies in bricks that are nearer than the distance is empty. */
        steps = i_of((f_of(distance - 1) * (float)SC_BRICK - SLACK_VOXELS) * p->steps_per_voxel);
        k += i_pick(i_below(i_set(1), steps), steps, i_set(1));
    }
}

/* The kernel: see sc_backdrop_fn. */
void MARCH_NAME(const sc_march_backdrop *backdrop, const sc_backdrop_ray *rays, size_t count,
                sc_backdrop_light *out)
{
    for (size_t i = 0; i < count; i += LANES) {
        const int lanes = count - i < LANES ? (int)(count - i) : LANES;
        packet p;

        start_packet(&p, backdrop, rays + i, lanes);
        for (int stretch = 0; stretch < 2; stretch++)
            follow(&p, rays + i, lanes, stretch);
        for (int lane = 0; lane < lanes; lane++)
            out[i + (size_t)lane] =
                (sc_backdrop_light){p.tone[lane], p.transmittance[lane] + p.faded[lane]};
    }
}
