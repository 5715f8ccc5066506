/* SPDX-License-Identifier: BSD-3-Clause */
/* The light of places, from what their rays have met, and that of the vertices between which
 * kernels interpolate. */
#include "gather.h"
#include "internal.h"

enum {
    BOUNCES = 5, /* where nine tenths are given back, and half of the rays meet something, a sixth
                    one would add less than 1 % */
    BLOCK = 2048 /* places that are done together */
};
/* No surface gives back more. */
#define ALBEDO_MOST 0.95f

/* Add what a ray number @p i of a place in direction @p d brings, if it is free, to @p sum. Those
 * that go all around are the denser the steeper they are; those to the lamp are not. */
static inline void add_free(const sc_gather *g, const sc_gather_place *p, int i, const float d[3],
                            float sum[3])
{
    const float cosine = i < SC_GATHER_DIRECTIONS ? 0 : sc_dot(p->normal, d);
    float rgb[3];

    for (int k = 0; k < 3 && cosine > 0; k++)
        sum[k] += g->known.lamp_strength * cosine / SC_GATHER_LAMP;
    if (i >= SC_GATHER_DIRECTIONS)
        return;
    sc_sky_blurred(&g->renderer->light.sky, d, rgb);
    for (int k = 0; k < 3; k++)
        sum[k] += g->known.sky_strength * rgb[k] / SC_GATHER_DIRECTIONS;
}

/* Find what comes to points of the floor if all of their rays are free. */
static void sum_floor(sc_gather *g)
{
    for (int k = 0; k < SC_FLOOR_SIDE * SC_FLOOR_PARTS; k++) {
        const int row = k / SC_FLOOR_PARTS, column = k % SC_FLOOR_PARTS;
        const sc_gather_place *p =
            &g->places[g->floor.first + (size_t)row * SC_FLOOR_SIDE + (size_t)column];
        float *sum = g->floor.free[row][column];

        sum[0] = sum[1] = sum[2] = 0;
        for (int i = 0; i < sc_gather_rays(g); i++) {
            float d[3];

            sc_gather_direction(g, p, i, d);
            add_free(g, p, i, d, sum);
        }
    }
}

/* Sum up what free rays bring to places [begin, end), and begin the iteration with it: an
 * sc_range_fn on a gather. */
static void sum_sky(void *user, size_t begin, size_t end, int thread)
{
    sc_gather *g = user;

    for (size_t at = begin; at < end; at++)
        g->light.sky[at][0] = g->light.sky[at][1] = g->light.sky[at][2] = 0;
    for (int i = 0; i < sc_gather_rays(g); i++) {
        const int32_t *hits = g->hits[i];

        for (size_t at = begin; at < end; at++) {
            float d[3];

            if (hits[at] != SC_GATHER_FREE && (hits[at] < 0 || !g->light.gone[hits[at]]))
                continue;
            sc_gather_direction(g, &g->places[at], i, d);
            add_free(g, &g->places[at], i, d, g->light.sky[at]);
        }
    }
    for (size_t at = begin; at < end; at++) {
        for (int k = 0; k < 3; k++)
            g->light.all[at][k] = g->light.sky[at][k];
    }
}

/* Set what places [begin, end) give back of their light: an sc_range_fn on a gather. */
static void reflect(void *user, size_t begin, size_t end, int thread)
{
    sc_gather *g = user;

    for (size_t at = begin; at < end; at++) {
        const sc_march_tissue *tissue = &g->renderer->tissues[g->places[at].tissue];

        for (int k = 0; k < 3; k++) {
            const float albedo = tissue->rgb[k];

            g->light.radiosity[at][k] =
                (albedo < ALBEDO_MOST ? albedo : ALBEDO_MOST) * g->light.all[at][k];
        }
    }
}

/* Set the light of places [begin, end), at most BLOCK, to that of the sky and what the places that
 * they see give back: an sc_range_fn on a gather. A ray whose hit has no place brings what an
 * average one of the others does. */
static void bounce(void *user, size_t begin, size_t end, int thread)
{
    sc_gather *g = user;
    float sums[BLOCK][3] = {{0}};
    uint8_t found[BLOCK] = {0}, lost[BLOCK] = {0};

    for (int i = 0; i < SC_GATHER_DIRECTIONS; i++) {
        const int32_t *hits = g->hits[i] + begin;

        for (size_t at = 0; at < end - begin; at++) {
            lost[at] += hits[at] == SC_GATHER_LOST;
            if (hits[at] < 0 || g->light.gone[hits[at]])
                continue;
            found[at]++;
            for (int k = 0; k < 3; k++)
                sums[at][k] += g->light.radiosity[hits[at]][k];
        }
    }
    for (size_t at = begin; at < end; at++) {
        const float more =
            found[at - begin] ? 1 + (float)lost[at - begin] / (float)found[at - begin] : 1;

        for (int k = 0; k < 3; k++)
            g->light.all[at][k] =
                g->light.sky[at][k] + sums[at - begin][k] * more / SC_GATHER_DIRECTIONS;
    }
}

/* Note which of places [begin, end) are cut away: an sc_range_fn on a gather. */
static void cut(void *user, size_t begin, size_t end, int thread)
{
    sc_gather *g = user;
    const sc_march *m = &g->renderer->march;

    for (size_t at = begin; at < end; at++) {
        const float *p = g->places[at].at;

        g->light.gone[at] = false;
        for (int i = 0; i < m->planes.count && g->known.is_convex; i++) {
            const float *e = m->planes.equations[i];

            g->light.gone[at] =
                g->light.gone[at] || e[0] * p[0] + e[1] * p[1] + e[2] * p[2] + e[3] < 0;
        }
    }
}

/* The mean light around vertex @p q of the places within a vertex of it along each axis, weighted
 * by how near they are and how alike their normals are to @p n, to @p out. Also those that are cut
 * away count, beside a plane: their light is what it would be there. Where none looks that way, as
 * in creases, all count alike. */
static void spread_to(const sc_gather *g, const sc_gather_field *f, const int q[3],
                      const float n[3], float out[3])
{
    const int *size = g->renderer->volume->size;
    float alike[3] = {0}, all[3] = {0}, alike_weights = 0, all_weights = 0;

    for (int i = 0; i < 27; i++) {
        const int d[3] = {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
        const int at[3] = {q[0] + d[0], q[1] + d[1], q[2] + d[2]};
        const float near = 1 - 0.25f * (float)(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        float cosine, weight;
        int32_t place;

        if (at[0] < 0 || at[1] < 0 || at[2] < 0 || at[0] > size[0] + 1 || at[1] > size[1] + 1 ||
            at[2] > size[2] + 1)
            continue;
        place = sc_gather_place_at(g, f, at);
        if (place == SC_GATHER_LOST)
            continue;
        cosine = sc_dot(g->places[place].normal, n);
        weight = cosine > 0 ? near * near * cosine * cosine : 0;
        alike_weights += weight;
        all_weights += near * near;
        for (int k = 0; k < 3; k++) {
            alike[k] += weight * g->light.all[place][k];
            all[k] += near * near * g->light.all[place][k];
        }
    }
    for (int k = 0; k < 3; k++)
        out[k] = alike_weights > 0 ? alike[k] / alike_weights
                 : all_weights > 0
                     ? all[k] / all_weights
                     : 0.5f * g->known.sky_strength * (SC_SKY_MEAN + SC_SKY_UP * (2.0f / 3) * n[2]);
}

/* Spread the light of places to the records of bricks [begin, end): an sc_range_fn on a gather. */
static void spread(void *user, size_t begin, size_t end, int thread)
{
    sc_gather *g = user;

    for (int k = 0; k < SC_GATHER_FIELDS; k++) {
        const sc_gather_field *f = &g->fields[k];

        for (size_t brick = begin; f->masks && brick < end; brick++) {
            uint32_t at = f->border->start[brick];
            int low[3];

            sc_brick_low(g->renderer->volume->bricks, brick, low);
            for (uint64_t left = f->border->masks[brick]; left; left &= left - 1, at++) {
                const int bit = __builtin_ctzll(left);
                const int q[3] = {low[0] + sc_bit_x(bit), low[1] + sc_bit_y(bit),
                                  low[2] + sc_bit_z(bit)};
                float n[3], light[3], length;

                sc_record_normal(f->border->records[at], n);
                length = sqrtf(sc_dot(n, n));
                for (int i = 0; i < 3; i++)
                    n[i] /= length;
                spread_to(g, f, q, n, light);
                f->around[at] = sc_around_pack(light);
            }
        }
    }
}

void sc_gather_sum(sc_gather *g)
{
    sc_gather_for(g, g->count, BLOCK, cut);
    sc_gather_for(g, g->count, BLOCK, sum_sky);
    for (int i = 0; i < BOUNCES; i++) {
        sc_gather_for(g, g->count, BLOCK, reflect);
        sc_gather_for(g, g->count, BLOCK, bounce);
    }
    sc_gather_for(g, sc_brick_count(g->renderer->volume->bricks), 1024, spread);
    if (g->floor.light)
        sum_floor(g);
    sc_gather_for(g, g->count - g->floor.first, 4096, sc_floor_spread);
}
