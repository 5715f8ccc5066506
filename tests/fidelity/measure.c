/* SPDX-License-Identifier: BSD-3-Clause */
/* Compares segcast's own surfaces with the known ones, by rays of the kernels that draw pictures
 * and by the labels that own sampled points. */
#include "fidelity.h"

#include <stdlib.h>
#include <string.h>

enum { RAYS = 200000, BATCH = 512, VIEWS = 3, SILHOUETTE_PX = 400, NEAR_SAMPLES = 4 };

void errors_add(errors *e, double position, double angle_deg)
{
    if (e->count == e->capacity) {
        e->capacity = e->capacity ? 2 * e->capacity : 4096;
        e->position = realloc(e->position, e->capacity * sizeof(double));
        e->angle = realloc(e->angle, e->capacity * sizeof(double));
        if (!e->position || !e->angle)
            abort();
    }
    e->position[e->count] = position;
    e->angle[e->count++] = angle_deg;
}

/* Order of two doubles, for qsort. */
static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;

    return (x > y) - (x < y);
}

void errors_finish(errors *e, fidelity *out)
{
    double squares = 0, angles = 0;

    for (size_t i = 0; i < e->count; i++) {
        e->position[i] = fabs(e->position[i]);
        squares += e->position[i] * e->position[i];
        angles += e->angle[i] * e->angle[i];
    }
    qsort(e->position, e->count, sizeof(double), compare);
    out->hits = e->count;
    if (e->count) {
        out->position_rms = sqrt(squares / (double)e->count);
        out->position_95 = e->position[(size_t)(0.95 * (double)e->count)];
        out->position_max = e->position[e->count - 1];
        out->normal_rms = sqrt(angles / (double)e->count);
    }
    free(e->position);
    free(e->angle);
    *e = (errors){0};
}

/* Add the errors of what a ray from @p eye has met (@p light) to @p e: the distance of the hit
 * from the true surface, and the angle between the normals. Rays without a hit are passed over. */
static void add_hit(const shape *s, sc_vec3 eye, sc_vec3 direction, const sc_radiance *light,
                    errors *e)
{
    sc_vec3 hit, normal;
    const sc_vec3 n = {(double)light->normal[0], (double)light->normal[1],
                       (double)light->normal[2]};
    double distance, cosine;

    if (!light->label)
        return;
    hit = sc_vec3_along(eye, (double)light->depth_mm, direction);
    distance = shape_distance(s, hit, &normal);
    cosine = fmin(1, fmax(-1, sc_vec3_dot(n, normal)));
    errors_add(e, distance, acos(cosine) * 180 / M_PI);
}

/* Measure errors of positions and normals, to @p out (see errors_finish), by rays in random
 * directions through a ball around the shape. */
static void measure_hits(const stage *st, const shape *s, fidelity *out)
{
    static sc_ray rays[BATCH];
    static sc_radiance light[BATCH];
    static sc_vec3 eyes[BATCH], directions[BATCH];
    sc_march_counters counters = {0};
    uint64_t seed = 11;
    errors e = {0};

    for (int n = 0; n < RAYS; n += BATCH) {
        for (int i = 0; i < BATCH; i++) {
            directions[i] = random_line(st, &seed, &eyes[i]);
            make_ray(st, eyes[i], directions[i], &rays[i]);
        }
        st->kernel->march(&st->march, rays, NULL, BATCH, light, &counters);
        for (int i = 0; i < BATCH; i++)
            add_hit(s, eyes[i], directions[i], &light[i], &e);
    }
    errors_finish(&e, out);
}

/* Does the line meet the shape? Found by sphere tracing: each step is as long as the distance. */
static bool line_meets(const stage *st, const shape *s, sc_vec3 eye, sc_vec3 direction)
{
    double t = 0;

    while (t < 2 * st->reach_mm) {
        sc_vec3 normal;
        const double d = shape_distance(s, sc_vec3_along(eye, t, direction), &normal);

        if (d < 1e-4)
            return true;
        t += d * s->unit_mm;
    }
    return false;
}

/* Measure the mean distance between the drawn and the true outline, to out->silhouette in
 * units: the area by which they differ, divided by the outline's length; with parallel rays
 * from three sides. */
static void measure_silhouette(const stage *st, const shape *s, fidelity *out)
{
    const double px_mm = 2 * st->reach_mm / SILHOUETTE_PX;
    uint64_t seed = 5;
    double differing = 0, edges = 0;

    for (int view = 0; view < VIEWS; view++) {
        const sc_vec3 d = random_direction(&seed), right = sc_vec3_perpendicular(d);
        const sc_vec3 up = sc_vec3_cross(d, right);
        bool row[SILHOUETTE_PX] = {false};

        for (int y = 0; y < SILHOUETTE_PX; y++) {
            bool before = false;

            for (int x = 0; x < SILHOUETTE_PX; x++) {
                const double across = (x + 0.5) * px_mm - st->reach_mm;
                const double upward = (y + 0.5) * px_mm - st->reach_mm;
                const sc_vec3 eye = sc_vec3_along(
                    sc_vec3_along(sc_vec3_along(st->middle_mm, across, right), upward, up),
                    -st->reach_mm, d);
                const bool truth = line_meets(st, s, eye, d);
                sc_march_counters counters = {0};
                sc_radiance light;
                sc_ray ray;

                make_ray(st, eye, d, &ray);
                st->kernel->march(&st->march, &ray, NULL, 1, &light, &counters);
                differing += truth != (light.label != 0);
                edges += (truth != before) + (truth != row[x]);
                row[x] = before = truth;
            }
        }
    }
    /* On average over all directions, the pixel edges along a line are 4/pi times as long as the
     * line. */
    out->silhouette = differing / (edges * M_PI / 4) * px_mm / s->unit_mm;
}

/* A random point, in mm, of the block of @p every voxels along each axis that begins at voxel
 * (@p x, @p y, @p z). */
static sc_vec3 point_in_block(const stage *st, int x, int y, int z, int every, uint64_t *seed)
{
    const double i = x + every * random_of(seed) - 0.5;
    const double j = y + every * random_of(seed) - 0.5;
    const double k = z + every * random_of(seed) - 0.5;

    return sc_affine_point(&st->voxels->to_ras_mm, (sc_vec3){i, j, k});
}

/* Measure the share of points with a wrong owner, farther than half a unit from the border, to
 * out->owner_errors, by a random point in every block of voxels. */
static void measure_owners(const stage *st, const shape *s, fidelity *out)
{
    uint64_t seed = 17;
    double samples = 0, wrong = 0;
    enum { EVERY = 2 };

    for (int z = 0; z < s->size[2]; z += EVERY) {
        for (int y = 0; y < s->size[1]; y += EVERY) {
            for (int x = 0; x < s->size[0]; x += EVERY) {
                const sc_vec3 mm = point_in_block(st, x, y, z, EVERY, &seed);
                sc_vec3 normal;
                const double distance = shape_distance(s, mm, &normal);

                if (fabs(distance) <= 0.5)
                    continue;
                samples++;
                wrong += owner_at(st, mm) != (distance < 0);
            }
        }
    }
    out->owner_errors = 1e6 * wrong / samples;
}

/* Measure the share of the volume that is kept, to out->volume_kept, by NEAR_SAMPLES
 * random points in each voxel within three units, or three slices, of the surface. */
static void measure_kept(const stage *st, const shape *s, fidelity *out)
{
    const double near = 3 * fmax(1, s->slice_mm / s->unit_mm);
    uint64_t seed = 19;
    double inside = 0;

    for (int z = 0; z < s->size[2]; z++) {
        for (int y = 0; y < s->size[1]; y++) {
            for (int x = 0; x < s->size[0]; x++) {
                const sc_vec3 mm = sc_affine_point(&st->voxels->to_ras_mm, (sc_vec3){x, y, z});
                sc_vec3 normal;
                const double d = shape_distance(s, mm, &normal);
                int own = 0;

                if (d > near)
                    continue;
                for (int i = 0; i < NEAR_SAMPLES && d > -near; i++)
                    own += owner_at(st, point_in_block(st, x, y, z, 1, &seed));
                inside += d > -near ? (double)own / NEAR_SAMPLES : 1;
            }
        }
    }
    out->volume_kept = inside * s->slice_mm / s->volume;
}

sc_status measure_volume(const sc_ctx *ctx, const shape *s, const drawing *how, fidelity *out)
{
    SC_OWN(sc_volume_clear) sc_volume volume = {0};
    SC_OWN(stage_close) stage st = {0};

    SC_PASS(shape_volume(ctx, s, how->threads, &volume));
    SC_PASS(stage_open(ctx, &volume, how, 1.12 / 1.5, 0.05 * fmin(1, s->unit_mm), &st));
    measure_hits(&st, s, out);
    measure_owners(&st, s, out);
    measure_kept(&st, s, out);
    measure_silhouette(&st, s, out);
    out->gaps = s->radius > 0 ? 0 : -1;
    for (int i = 0; i < 3600 && s->radius > 0; i++)
        out->gaps += owner_at(&st, shape_middle(s, i / 3600.0)) != 1;
    return SC_OK;
}
