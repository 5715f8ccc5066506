/* SPDX-License-Identifier: BSD-3-Clause */
/* Compares segcast's own surfaces with the known ones, by rays of the kernels that draw pictures
 * and by the labels that own sampled points. */
#include "fidelity.h"

#include <stdlib.h>
#include <string.h>

enum {
    RAYS = 200000,
    PHANTOM_RAYS = 10000,
    BATCH = 512,
    VIEWS = 3,
    SILHOUETTE_PX = 400,
    NEAR_SAMPLES = 4
};

uint64_t random_bits_of(uint64_t *seed)
{
    uint64_t z = *seed += 0x9e3779b97f4a7c15u; /* splitmix64 */

    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

double random_of(uint64_t *seed)
{
    return (double)(random_bits_of(seed) >> 11) * 0x1p-53;
}

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

/* A prepared shape, and everything else that rays need. Pointers are borrowed. */
typedef struct stage {
    const shape *s;
    sc_prepared volume;
    sc_march march;
    const sc_kernel *kernel;
    sc_affine to_voxel;
    double reach_mm; /* radius of a ball around the whole volume */
    sc_vec3 middle_mm;
} stage;

/* Fill in a ray from @p eye along the unit vector @p direction, both in RAS mm; one that misses
 * the volume has no parts. */
static void make_ray(const stage *st, sc_vec3 eye, sc_vec3 direction, sc_ray *ray)
{
    const double shift = st->kernel->surface == SC_SURFACE_VOXEL ? 1.5 : 1;
    const sc_vec3 o = sc_affine_point(&st->to_voxel, eye);
    const sc_vec3 d = sc_affine_vector(&st->to_voxel, direction);
    const int *size = st->volume.size;
    const sc_box3 box = {{-2, -2, -2}, {size[0] + 1, size[1] + 1, size[2] + 1}};
    double begin = 0, end = 2 * st->reach_mm;
    const bool meets = sc_box3_clip_line(&box, o, d, &begin, &end);

    *ray = (sc_ray){.origin = {(float)(o.x + shift), (float)(o.y + shift), (float)(o.z + shift)},
                    .direction = {(float)d.x, (float)d.y, (float)d.z},
                    .toward_eye = {(float)-direction.x, (float)-direction.y, (float)-direction.z},
                    .clip_sets = 1,
                    .part_count = {meets}};
    ray->parts[0][0].begin_mm = (float)begin;
    ray->parts[0][0].end_mm = (float)end;
    ray->parts[0][0].first = (int32_t)ceil(begin / (double)st->march.step_mm);
    ray->parts[0][0].last = (int32_t)(end / (double)st->march.step_mm);
    ray->parts[0][0].cap_plane = -1;
}

/* A random unit vector, uniformly distributed over the sphere (Archimedes). */
static sc_vec3 random_direction(uint64_t *seed)
{
    const double z = 2 * random_of(seed) - 1, angle = 2 * M_PI * random_of(seed);
    const double across = sqrt(1 - z * z);

    return (sc_vec3){across * cos(angle), across * sin(angle), z};
}

/* Is the phantom's surface not determined by its voxels at this point? That is so for faces within
 * 8 degrees of a plane of the grid (a flat face may lie anywhere within a voxel, and its steps are
 * wider than any filter), and near an edge (two voxels) or a third tissue (three voxels). */
static bool is_undetermined(const stage *st, int label, sc_vec3 hit, sc_vec3 normal)
{
    const double mm = st->s->voxel_mm;
    const sc_vec3 side = sc_vec3_perpendicular(normal);
    int owners[2] = {label, -1};

    if (fmax(fabs(normal.x), fmax(fabs(normal.y), fabs(normal.z))) > 0.99)
        return true;

    for (int n = 0; n < 27; n++) {
        const sc_vec3 d = sc_vec3_unit((sc_vec3){n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1});
        const int owner = sc_phantom_owner(st->s->phantom, sc_vec3_along(hit, 3 * mm, d));

        if (owner == owners[0] || owner == owners[1])
            continue;
        if (owners[1] >= 0)
            return true;
        owners[1] = owner;
    }
    for (int n = 0; n < 8; n++) {
        const sc_vec3 along = sc_vec3_rotate(side, normal, n * M_PI / 4);
        sc_vec3 there;

        (void)shape_distance(st->s, label, sc_vec3_along(hit, 2 * mm, along), &there);
        if (sc_vec3_dot(there, normal) < 0.64) /* 50 degrees: a tube of radius 2.3 */
            return true;
    }
    return false;
}

/* Add the errors of what a ray from @p eye has met (@p light) to @p e: the distance of the hit
 * from the true surface, and the angle between the normals. Rays without a hit, and points of
 * the phantom that are undetermined, are passed over. */
static void add_hit(const stage *st, sc_vec3 eye, sc_vec3 direction, const sc_radiance *light,
                    errors *e)
{
    sc_vec3 hit, normal;
    const sc_vec3 n = {(double)light->normal[0], (double)light->normal[1],
                       (double)light->normal[2]};
    double distance, cosine;

    if (!light->label)
        return;
    hit = sc_vec3_along(eye, (double)light->depth_mm, direction);
    distance = shape_distance(st->s, (int)light->label, hit, &normal);
    if (st->s->phantom && is_undetermined(st, (int)light->label, hit, normal))
        return;
    cosine = fmin(1, fmax(-1, sc_vec3_dot(n, normal)));
    errors_add(e, distance, acos(cosine) * 180 / M_PI);
}

/* Measure errors of positions and normals, to @p out (see errors_finish), by rays in random
 * directions through a ball around the shape. */
static void measure_hits(const stage *st, fidelity *out)
{
    static sc_ray rays[BATCH];
    static sc_radiance light[BATCH];
    static sc_vec3 eyes[BATCH], directions[BATCH];
    sc_march_counters counters = {0};
    uint64_t seed = 11;
    errors e = {0};

    for (int n = 0; n < (st->s->phantom ? PHANTOM_RAYS : RAYS); n += BATCH) {
        for (int i = 0; i < BATCH; i++) {
            const sc_vec3 d = random_direction(&seed), side = sc_vec3_perpendicular(d);
            const double r = st->reach_mm * sqrt(random_of(&seed));
            const double angle = 2 * M_PI * random_of(&seed);
            const sc_vec3 through = sc_vec3_along(st->middle_mm, r, sc_vec3_rotate(side, d, angle));

            directions[i] = d;
            eyes[i] = sc_vec3_along(through, -st->reach_mm, d);
            make_ray(st, eyes[i], d, &rays[i]);
        }
        st->kernel->march(&st->march, rays, BATCH, light, &counters);
        for (int i = 0; i < BATCH; i++)
            add_hit(st, eyes[i], directions[i], &light[i], &e);
    }
    errors_finish(&e, out);
}

/* Does the line meet the shape? Found by sphere tracing: each step is as long as the distance. */
static bool line_meets(const stage *st, sc_vec3 eye, sc_vec3 direction)
{
    double t = 0;

    while (t < 2 * st->reach_mm) {
        sc_vec3 normal;
        const double d = shape_distance(st->s, 1, sc_vec3_along(eye, t, direction), &normal);

        if (d < 1e-4)
            return true;
        t += d;
    }
    return false;
}

/* Measure the mean distance between the drawn and the true outline, to out->silhouette in
 * voxels: the area by which they differ, divided by the outline's length; with parallel rays
 * from three sides. Not for the phantom. */
static void measure_silhouette(const stage *st, fidelity *out)
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
                const bool truth = line_meets(st, eye, d);
                sc_march_counters counters = {0};
                sc_radiance light;
                sc_ray ray;

                make_ray(st, eye, d, &ray);
                st->kernel->march(&st->march, &ray, 1, &light, &counters);
                differing += truth != (light.label != 0);
                edges += (truth != before) + (truth != row[x]);
                row[x] = before = truth;
            }
        }
    }
    /* On average over all directions, the pixel edges along a line are 4/pi times as long as the
     * line. */
    out->silhouette = differing / (edges * M_PI / 4) * px_mm / st->s->voxel_mm;
}

/* The label that segcast's surface model gives the point @p mm (RAS); 0 outside of the volume. */
static int owner_at(const stage *st, sc_vec3 mm)
{
    const sc_vec3 p = sc_affine_point(&st->to_voxel, mm);
    const float point[3] = {(float)(p.x + 1), (float)(p.y + 1), (float)(p.z + 1)};
    const sc_prepared *v = &st->volume;
    const int x = (int)floor(p.x + 0.5), y = (int)floor(p.y + 0.5), z = (int)floor(p.z + 0.5);

    if (st->kernel->surface == SC_SURFACE_SMOOTH)
        return (int)sc_kernel_owner(v, point);
    if (x < 0 || y < 0 || z < 0 || x >= v->size[0] || y >= v->size[1] || z >= v->size[2])
        return 0;
    return (
        (const uint8_t *)
            v->ids)[((size_t)z * (size_t)v->size[1] + (size_t)y) * (size_t)v->size[0] + (size_t)x];
}

/* Measure the share of points with a wrong owner (out->owner_errors) and of the volume kept
 * (out->volume_kept, NaN for the phantom), by jittered points: for the owners one in every block
 * of voxels, for the volume NEAR_SAMPLES in each voxel near the surface. */
static void measure_owners(const stage *st, fidelity *out)
{
    uint64_t seed = 17;
    double inside = 0, samples = 0, wrong = 0;
    const int every = st->s->phantom ? 9 : 2;

    for (int z = 0; z < st->s->size[2]; z += every) {
        for (int y = 0; y < st->s->size[1]; y += every) {
            for (int x = 0; x < st->s->size[0]; x += every) {
                const sc_vec3 mm = sc_affine_point(&st->volume.to_ras_mm,
                                                   (sc_vec3){x + every * (random_of(&seed) - 0.5),
                                                             y + every * (random_of(&seed) - 0.5),
                                                             z + every * (random_of(&seed) - 0.5)});
                double border;
                const int truth = shape_owner(st->s, mm, &border);

                if (border <= 0.5)
                    continue;
                samples++;
                wrong += owner_at(st, mm) != truth;
            }
        }
    }
    out->owner_errors = 1e6 * wrong / samples;
    out->volume_kept = NAN;
    if (st->s->phantom)
        return;
    for (int z = 0; z < st->s->size[2]; z++) {
        for (int y = 0; y < st->s->size[1]; y++) {
            for (int x = 0; x < st->s->size[0]; x++) {
                sc_vec3 normal;
                const double d = shape_distance(st->s, 1, (sc_vec3){x, y, z}, &normal);
                int own = 0;

                if (d > 3)
                    continue;
                for (int i = 0; i < NEAR_SAMPLES && d > -3; i++)
                    own += owner_at(st, (sc_vec3){x + random_of(&seed) - 0.5,
                                                  y + random_of(&seed) - 0.5,
                                                  z + random_of(&seed) - 0.5});
                inside += d > -3 ? (double)own / NEAR_SAMPLES : 1;
            }
        }
    }
    out->volume_kept = inside / st->s->volume;
}

/* Fill in the stage, whose s and volume have been set: kernel, geometry, and a march with flat
 * light. @p cells: masks of what is visible; like @p tissues, they stay borrowed. */
static void set_stage(stage *st, sc_surface surface, const uint64_t *cells,
                      const sc_march_tissue *tissues)
{
    const sc_prepared *v = &st->volume;
    const sc_vec3 corner = {v->size[0] - 1, v->size[1] - 1, v->size[2] - 1};
    const sc_vec3 low = sc_affine_point(&v->to_ras_mm, (sc_vec3){0, 0, 0});
    const sc_vec3 high = sc_affine_point(&v->to_ras_mm, corner);

    st->kernel = sc_kernel_find(surface, SC_SKIP_INTERIOR, v, NULL);
    (void)sc_affine_invert(&v->to_ras_mm, &st->to_voxel);
    st->middle_mm = sc_vec3_scale(sc_vec3_add(low, high), 0.5);
    st->reach_mm = 0.56 * sc_vec3_length(sc_vec3_sub(high, low)) / (st->s->phantom ? 1.3 : 1.5);
    st->march = (sc_march){
        .volume = v,
        .visible = cells,
        .visible_row = sc_framed_row(v->bricks),
        .visible_layer = sc_framed_layer(v->bricks),
        .box_low = {-1.5f, -1.5f, -1.5f},
        .box_high = {(float)v->size[0] + 2.5f, (float)v->size[1] + 2.5f, (float)v->size[2] + 2.5f},
        .tissues = tissues,
        .step_mm = (float)(0.05 * st->s->voxel_mm),
        .light = {.flat = true}};
}

/* Measure the packed prepared volume @p block of a shape and fill in @p out. @return errors of
 * viewing it and SC_ERR_MEMORY. */
static sc_status measure_prepared(const sc_ctx *ctx, const shape *s, sc_surface surface,
                                  int threads, const void *block, size_t bytes, fidelity *out)
{
    stage st = {.s = s};
    static sc_march_tissue tissues[256];
    uint8_t show[256];
    uint64_t *cells = NULL;
    sc_status status;

    SC_TRY(sc_prepared_view(ctx, block, bytes, &st.volume));
    for (int id = 0; id < 256; id++) {
        show[id] = id ? SC_SHOW_BOUNDARY : 0;
        tissues[id] = (sc_march_tissue){.boundary_alpha = 1, .show = show[id], .shininess = 1};
    }
    if (surface == SC_SURFACE_SMOOTH)
        SC_TRY(sc_visible_cells(ctx, &st.volume, show, threads, &cells));
    else
        SC_TRY(sc_visible_masks(ctx, &st.volume, show, threads, &cells));
    set_stage(&st, surface, cells, tissues);
    measure_hits(&st, out);
    measure_owners(&st, out);
    out->silhouette = NAN;
    if (!s->phantom)
        measure_silhouette(&st, out);
    out->gaps = s->radius > 0 ? 0 : -1;
    for (int i = 0; i < 3600 && s->radius > 0; i++)
        out->gaps += owner_at(&st, shape_middle(s, i / 3600.0)) != 1;
out:
    sc_free(cells);
    return status;
}

sc_status measure_volume(const sc_ctx *ctx, const shape *s, sc_surface surface, double smooth,
                         int threads, fidelity *out)
{
    const sc_prepare_settings settings = {.smooth = smooth, .threads = threads};
    sc_volume volume = {0};
    sc_preparation *preparation = NULL;
    void *block = NULL;
    size_t bytes;
    sc_status status;

    SC_TRY(shape_volume(ctx, s, threads, &volume));
    SC_TRY(sc_prepare(ctx, &volume, &settings, &preparation));
    bytes = sc_preparation_bytes(preparation);
    SC_TRY(sc_alloc(ctx, bytes, 1, &block));
    sc_preparation_pack(preparation, block);
    status = measure_prepared(ctx, s, surface, threads, block, bytes, out);
out:
    sc_preparation_free(preparation);
    sc_volume_clear(&volume);
    sc_free(block);
    return status;
}
