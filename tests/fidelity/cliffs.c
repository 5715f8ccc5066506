/* SPDX-License-Identifier: BSD-3-Clause */
/* Whether a small change of the voxels, or of the strength of smoothing, changes the drawn surface
 * little: a rule that sets in at a threshold shows as one step that is larger than the others. */
#include "rulers.h"

#include <stdlib.h>
#include <string.h>

enum { RAYS = 20000, NOISE_STEPS = 20, STRENGTH_STEPS = 12, STEPS_MAX = NOISE_STEPS, BATCH = 500 };
#define MOST_NOISE 0.2 /* share of the voxels at the border */
#define LEAST_STRENGTH 0.5
#define MOST_STRENGTH 2.0
/* Rays begin so many voxels outside of the true surface, and end as far inside. */
#define OUTSIDE 6.0

static const char *const names[] = {"ellipsoid", "torus-6"};

size_t cliff_count(void)
{
    return 2 * SC_COUNT_OF(names);
}

/* A ray along the normal of the true surface, inward, in mm. */
typedef struct probe {
    sc_vec3 eye, direction;
} probe;

/* Fill in RAYS probes, spread evenly over the surface of a shape. @p st: of its voxels, for the
 * random lines alone. */
static void choose_probes(const stage *st, const shape *s, probe *out)
{
    uint64_t seed = 37;

    for (int n = 0; n < RAYS;) {
        sc_vec3 eye, normal;
        const sc_vec3 direction = random_line(st, &seed, &eye);
        double t = 0, away = HUGE_VAL;

        while (t < 2 * st->reach_mm && away > 1e-4) {
            away = shape_distance(s, sc_vec3_along(eye, t, direction), &normal);
            t += away * s->unit_mm;
        }
        if (away > 1e-4)
            continue;
        out[n].direction = sc_vec3_scale(normal, -1);
        out[n].eye = sc_vec3_along(sc_vec3_along(eye, t, direction), OUTSIDE * s->unit_mm, normal);
        n++;
    }
}

/* Where the voxels of a shape, of which a share is flipped, are drawn: for each probe the depth in
 * voxels, to @p depths [RAYS]; NAN for those that meet nothing. @p voxels are as they were on
 * return. Without @p probes yet (@p chosen false) they are chosen first. @return errors of
 * preparing. */
static sc_status probe_shape(const sc_ctx *ctx, const shape *s, sc_volume *voxels,
                             const drawing *how, bool chosen, probe *probes, double *depths)
{
    const size_t bytes = sc_volume_voxels(voxels);
    SC_OWN(sc_free_at) void *clean = NULL;
    SC_OWN(stage_close) stage st = {0};
    sc_status status;

    SC_TRY(sc_alloc(ctx, bytes, 1, &clean));
    memcpy(clean, voxels->ids, bytes);
    SC_TRY(flip_voxels(ctx, voxels, s->flipped));
    status = stage_open(ctx, voxels, how, 1.12 / 1.5, 0.05, &st);
    memcpy(voxels->ids, clean, bytes);
    SC_TRY(status);
    if (!chosen)
        choose_probes(&st, s, probes);
    for (int n = 0; n < RAYS; n += BATCH) {
        sc_march_counters counters = {0};
        sc_ray rays[BATCH];
        sc_radiance light[BATCH];

        for (int i = 0; i < BATCH; i++)
            make_ray(&st, probes[n + i].eye, probes[n + i].direction, &rays[i]);
        st.kernel->march(&st.march, rays, NULL, BATCH, light, &counters);
        for (int i = 0; i < BATCH; i++) {
            const double depth = (double)light[i].depth_mm / s->unit_mm;

            depths[n + i] = light[i].label && depth <= 2 * OUTSIDE ? depth : NAN;
        }
    }
out:
    return status;
}

/* The mean of how far the surface has moved along the probes that meet it both times, in voxels. */
static double mean_change(const double *before, const double *after)
{
    double sum = 0, count = 0;

    for (int n = 0; n < RAYS; n++) {
        if (isnan(before[n]) || isnan(after[n]))
            continue;
        sum += fabs(after[n] - before[n]);
        count++;
    }
    return count > 0 ? sum / count : NAN;
}

/* Order of two doubles, for qsort. */
static int by_size(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;

    return (x > y) - (x < y);
}

/* Sum up the changes of the steps. They get sorted. */
static void sum_up(double *changes, int steps, cliff *out)
{
    out->at = 0;
    for (int n = 1; n < steps; n++)
        out->at = changes[n] > changes[out->at] ? n : out->at;
    out->largest = changes[out->at];
    out->at++;
    out->steps = steps;
    qsort(changes, (size_t)steps, sizeof *changes, by_size);
    out->median = (changes[(steps - 1) / 2] + changes[steps / 2]) / 2;
}

sc_status measure_cliff(const sc_ctx *ctx, size_t n, const drawing *how, cliff *out)
{
    const bool by_noise = n % 2 == 0;
    const int steps = by_noise ? NOISE_STEPS : STRENGTH_STEPS;
    shape s = *shape_find(names[n / 2]);
    drawing drawn = *how;
    SC_OWN(sc_volume_clear) sc_volume voxels = {0};
    double changes[STEPS_MAX], *depths[2];
    SC_OWN(sc_free_at) void *probes = NULL;
    SC_OWN(sc_free_at) double *both = NULL;

    *out = (cliff){.shape = s.name, .by_noise = by_noise};
    SC_PASS(sc_alloc(ctx, RAYS, sizeof(probe), &probes));
    SC_PASS(SC_ALLOC(ctx, 2 * RAYS, &both));
    depths[0] = both;
    depths[1] = both + RAYS;
    SC_PASS(shape_volume(ctx, &s, how->threads, &voxels));
    for (int i = 0; i <= steps; i++) {
        const double share = (double)i / steps;

        if (by_noise)
            s.flipped = MOST_NOISE * share;
        else
            drawn.smooth = LEAST_STRENGTH + (MOST_STRENGTH - LEAST_STRENGTH) * share;
        SC_PASS(probe_shape(ctx, &s, &voxels, &drawn, i > 0, probes, depths[i % 2]));
        if (i > 0)
            changes[i - 1] = mean_change(depths[(i - 1) % 2], depths[i % 2]);
    }
    sum_up(changes, steps, out);
    return SC_OK;
}
