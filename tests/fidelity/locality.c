/* SPDX-License-Identifier: BSD-3-Clause */
/* Whether what is drawn at a place depends on the voxels around it alone: crops of a volume, drawn
 * by themselves, must show the same bits. */
#include "rulers.h"

#include <string.h>

enum {
    CROPS = 12,
    EDGE = 64, /* voxels along an edge of what is compared of a crop */
    TRIES = 1000000,
    SAMPLES = 20000, /* points, and as many rays, in a crop */
    PARTS = 64,      /* of a voxel: places are whole multiples */
    HALVINGS = 3     /* of the components of directions */
};

/* A part of a volume, in voxels: from low to before high. */
typedef struct part {
    int low[3], high[3];
} part;

/* Choose at random a voxel at a border of two labels. @return false if none was found. */
static bool find_border(const sc_volume *v, uint64_t *seed, int at[3])
{
    for (int n = 0; n < TRIES; n++) {
        int id;

        for (int i = 0; i < 3; i++)
            at[i] = (int)(random_of(seed) * v->size[i]);
        id = id_at(v, at[0], at[1], at[2]);
        for (int i = 0; i < 3; i++) {
            int next[3] = {at[0], at[1], at[2]};

            next[i]++;
            if (next[i] < v->size[i] && id_at(v, next[0], next[1], next[2]) != id)
                return true;
        }
    }
    return false;
}

/* The part of the volume about @p middle that is compared, to @p inner, and with @p halo voxels
 * around it, as far as the volume reaches, to @p outer. */
static void choose_parts(const sc_volume *v, const int middle[3], int halo, part *inner,
                         part *outer)
{
    for (int i = 0; i < 3; i++) {
        const int low = middle[i] - EDGE / 2;

        inner->low[i] = low > 0 ? low : 0;
        inner->high[i] = low + EDGE < v->size[i] ? low + EDGE : v->size[i];
        outer->low[i] = low - halo > 0 ? low - halo : 0;
        outer->high[i] = low + EDGE + halo < v->size[i] ? low + EDGE + halo : v->size[i];
    }
}

/* Copy a part of a volume, with all its labels. Caller owns @p out, which must be {0}, even after
 * an error: sc_volume_clear. @return SC_ERR_MEMORY. */
static sc_status crop(const sc_ctx *ctx, const sc_volume *v, const part *p, sc_volume *out)
{
    const size_t bytes = (size_t)v->label_bytes;
    const sc_vec3 corner = {p->low[0], p->low[1], p->low[2]};
    const sc_vec3 origin = sc_affine_point(&v->to_ras_mm, corner);
    void *block;
    uint8_t *to;

    *out = *v;
    out->ids = out->labels = NULL;
    out->table = out->absent = out->outside = (sc_label_table){0}; /* not needed here */
    for (int i = 0; i < 3; i++)
        out->size[i] = p->high[i] - p->low[i];
    out->to_ras_mm.m[0][3] = origin.x;
    out->to_ras_mm.m[1][3] = origin.y;
    out->to_ras_mm.m[2][3] = origin.z;
    SC_PASS(sc_alloc(ctx, sc_volume_voxels(out), bytes, &out->ids));
    SC_PASS(sc_alloc(ctx, (size_t)v->label_count, sizeof *v->labels, &block));
    out->labels = memcpy(block, v->labels, (size_t)v->label_count * sizeof *v->labels);
    to = out->ids;
    for (int z = p->low[2]; z < p->high[2]; z++) {
        for (int y = p->low[1]; y < p->high[1]; y++) {
            const size_t line = (size_t)z * (size_t)v->size[1] + (size_t)y;
            const size_t at = line * (size_t)v->size[0] + (size_t)p->low[0];

            memcpy(to, (const uint8_t *)v->ids + at * bytes, (size_t)out->size[0] * bytes);
            to += (size_t)out->size[0] * bytes;
        }
    }
    return SC_OK;
}

/* A random place between the voxel centres of a part, in voxels: a multiple of 1 / PARTS, so that
 * it, and where rays meet the planes of the grid, are the same numbers counted from any corner. */
static void choose_place(const part *p, uint64_t *seed, float at[3])
{
    for (int i = 0; i < 3; i++) {
        const int steps = (p->high[i] - 1 - p->low[i]) * PARTS;

        at[i] = (float)p->low[i] + (float)(int)(random_of(seed) * steps) / PARTS;
    }
}

/* Fill in a ray from @p at that ends within the part, whose direction has components that are
 * powers of two, in voxels for each unit along it; the unit is no mm. */
static void choose_ray(const part *p, const float at[3], uint64_t *seed, sc_ray *ray)
{
    float most = 4 * EDGE;

    *ray = (sc_ray){.toward_eye = {1, 0, 0}, .clip_sets = 1, .part_count = {1}};
    for (int i = 0; i < 3; i++) {
        const int halvings = (int)(random_of(seed) * (HALVINGS + 1));
        const float sign = random_of(seed) < 0.5 ? -1 : 1;
        const float room = sign < 0 ? at[i] - (float)p->low[i] : (float)(p->high[i] - 1) - at[i];

        ray->origin[i] = at[i];
        ray->direction[i] = sign / (float)(1 << halvings);
        most = fminf(most, room * (float)(1 << halvings));
    }
    ray->parts[0][0] = (sc_ray_part){.end_mm = most, .cap_plane = -1};
}

/* The first surface that a ray, given in voxels of a volume whose voxel @p low is the first one of
 * the stage, meets. */
static sc_radiance meet(const stage *st, const int low[3], const sc_ray *ray)
{
    sc_march_counters counters = {0};
    sc_ray moved = *ray;
    sc_radiance light;

    for (int i = 0; i < 3; i++)
        moved.origin[i] = ray->origin[i] - (float)low[i] + 1;
    st->kernel->march(&st->march, &moved, NULL, 1, &light, &counters);
    return light;
}

/* The owner of a point of the same volume. */
static uint32_t owner_of(const stage *st, const int low[3], const float at[3])
{
    const float point[3] = {at[0] - (float)low[0] + 1, at[1] - (float)low[1] + 1,
                            at[2] - (float)low[2] + 1};

    return sc_kernel_owner(&st->volume, point);
}

/* Are the bits of @p n numbers the same? */
static bool is_same(const float *a, const float *b, int n)
{
    bool same = true;

    for (int i = 0; i < n; i++) {
        uint32_t bits[2];

        memcpy(&bits[0], &a[i], sizeof bits[0]);
        memcpy(&bits[1], &b[i], sizeof bits[1]);
        same = same && bits[0] == bits[1];
    }
    return same;
}

/* Compare what both stages draw of the part @p inner. @p low: the first voxel of the crop. */
static void compare_part(const stage *whole, const stage *part_of_it, const part *inner,
                         const int low[3], uint64_t *seed, locality *out)
{
    static const int none[3];

    for (int n = 0; n < SAMPLES; n++) {
        sc_radiance a, b;
        float at[3];
        sc_ray ray;

        choose_place(inner, seed, at);
        if (!is_uniform(whole, (sc_vec3){(double)at[0], (double)at[1], (double)at[2]})) {
            out->points++;
            out->points_off += owner_of(whole, none, at) != owner_of(part_of_it, low, at);
        }
        choose_ray(inner, at, seed, &ray);
        a = meet(whole, none, &ray);
        b = meet(part_of_it, low, &ray);
        if (!a.label && !b.label)
            continue;
        out->rays++;
        out->rays_off += a.label != b.label || !is_same(&a.depth_mm, &b.depth_mm, 1) ||
                         !is_same(a.normal, b.normal, 3);
    }
}

sc_status measure_locality(const sc_ctx *ctx, const sc_volume *volume, const drawing *how, int halo,
                           locality *out)
{
    const drawing smooth = {SC_SURFACE_SMOOTH, false, how->smooth, how->threads};
    uint64_t seed = 23;
    stage whole = {0}, part_of_it = {0};
    sc_volume cropped = {0};
    sc_status status;

    *out = (locality){0};
    SC_TRY(stage_open(ctx, volume, &smooth, 1.02, 0.1, &whole));
    for (int n = 0; n < CROPS; n++) {
        part inner, outer;
        int middle[3];

        if (!find_border(volume, &seed, middle))
            break;
        choose_parts(volume, middle, halo, &inner, &outer);
        SC_TRY(crop(ctx, volume, &outer, &cropped));
        SC_TRY(stage_open(ctx, &cropped, &smooth, 1.02, 0.1, &part_of_it));
        compare_part(&whole, &part_of_it, &inner, outer.low, &seed, out);
        stage_close(&part_of_it);
        sc_volume_clear(&cropped);
        out->crops++;
    }
out:
    stage_close(&part_of_it);
    stage_close(&whole);
    sc_volume_clear(&cropped);
    return status;
}
