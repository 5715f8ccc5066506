/* SPDX-License-Identifier: BSD-3-Clause */
/* Template: the voxel surface model, one ray at a time, in plain C: the specification. Compiled
 * once per skip method (MARCH_SKIPS) and label width (MARCH_LABEL) under the name MARCH_NAME.
 *
 * Without skipping, a sample is classified from the labels around it, using nothing that
 * preprocessing has found; with it, one bit of the visible masks decides. Both must agree. */
#include "variants.h"
#include "voxel_ray.h"

/* Mean of the normals of those of the eight nearest voxels that are boundary voxels of the same
 * label, by distance. @return false where they have no direction. */
static bool normal_at(const sc_prepared *v, const float p[3], MARCH_LABEL label, float n[3])
{
    const int low[3] = {(int)(p[0] - 0.5f) - 1, (int)(p[1] - 0.5f) - 1, (int)(p[2] - 0.5f) - 1};
    float upper[3], length;

    for (int i = 0; i < 3; i++)
        upper[i] = p[i] - 0.5f - (float)(low[i] + 1);
    n[0] = n[1] = n[2] = 0;
    for (int corner = 0; corner < 8; corner++) {
        const int x = low[0] + (corner & 1), y = low[1] + (corner >> 1 & 1);
        const int z = low[2] + (corner >> 2);
        const float weight = (corner & 1 ? upper[0] : 1 - upper[0]) *
                             (corner & 2 ? upper[1] : 1 - upper[1]) *
                             (corner & 4 ? upper[2] : 1 - upper[2]);
        uint64_t mask, bit;
        size_t brick;
        float each[3];

        if (!in_volume(v, x, y, z) || label_at(v, x, y, z) != label)
            continue;
        brick = brick_index(v, x + 1, y + 1, z + 1);
        mask = v->near[brick];
        bit = 1ull << brick_bit(x + 1, y + 1, z + 1);
        if (!(mask & bit))
            continue;
        sc_record_normal(sc_record_at(v, v->near_start[brick] + sc_count_bits(mask & (bit - 1))),
                         each);
        for (int i = 0; i < 3; i++)
            n[i] += weight * each[i];
    }
    length = sqrtf(sc_dot3(n, n));
    if (!(length > 0.02f))
        return false;
    for (int i = 0; i < 3; i++)
        n[i] /= length;
    return true;
}

#if !MARCH_SKIPS
/* The paper's rule: does the 3x3x3 neighbourhood hold another label? */
static bool is_boundary(const sc_prepared *v, int x, int y, int z, MARCH_LABEL label)
{
    for (int dz = -1; dz <= 1; dz++) {
        for (int dy = -1; dy <= 1; dy++) {
            for (int dx = -1; dx <= 1; dx++) {
                if (!in_volume(v, x + dx, y + dy, z + dz) ||
                    label_at(v, x + dx, y + dy, z + dz) != label)
                    return true;
            }
        }
    }
    return false;
}
#endif

/* What the voxel can contribute: SC_SHOW_BOUNDARY, SC_SHOW_INTERIOR or 0; its label. */
static inline int classify(const sc_march *m, int x, int y, int z, MARCH_LABEL *label)
{
    const sc_prepared *v = m->volume;
#if MARCH_SKIPS
    /* is_marked has found it visible */
    *label = label_at(v, x, y, z);
    return v->near[brick_index(v, x + 1, y + 1, z + 1)] >> brick_bit(x + 1, y + 1, z + 1) & 1
               ? SC_SHOW_BOUNDARY
               : SC_SHOW_INTERIOR;
#else
    int kind;

    if (!in_volume(v, x, y, z))
        return 0;
    *label = label_at(v, x, y, z);
    if (!m->tissues[*label].show)
        return 0;
    kind = is_boundary(v, x, y, z, *label) ? SC_SHOW_BOUNDARY : SC_SHOW_INTERIOR;
    return m->tissues[*label].show & kind;
#endif
}

#if MARCH_SKIPS
/* One bit of the masks, whose frame of empty bricks makes tests of the bounds needless. */
static inline bool is_marked(const cursor *c, int k)
{
    const sc_march *m = c->m;
    const float t = ((float)k + 0.5f) * m->step_mm;
    const int x = (int)(c->ray->origin[0] + c->ray->direction[0] * t) + SC_BRICK;
    const int y = (int)(c->ray->origin[1] + c->ray->direction[1] * t) + SC_BRICK;
    const int z = (int)(c->ray->origin[2] + c->ray->direction[2] * t) + SC_BRICK;
    const int brick = (z >> 2) * m->visible_layer + (y >> 2) * m->visible_row + (x >> 2);

    return m->visible[brick] >> brick_bit(x, y, z) & 1;
}
#endif

/* From sample @p k on, the first before @p last that has to be looked at closely. */
static inline int find_sample(cursor *c, int k, int last)
{
#if MARCH_SKIPS
    const int begin = k;

    while (k < last && !is_marked(c, k))
        k++;
    c->samples += (uint64_t)(k - begin);
#else
    (void)c;
    (void)last;
#endif
    return k;
}

/* Opacity of one sample of a boundary voxel. */
static float boundary_alpha(const sc_march *m, const sc_march_tissue *tissue, int x, int y, int z)
{
    const sc_prepared *v = m->volume;
    const size_t brick = brick_index(v, x + 1, y + 1, z + 1);
    const uint64_t bit = 1ull << brick_bit(x + 1, y + 1, z + 1);

    if (!tissue->by_thickness || !v->thickness)
        return tissue->boundary_alpha;
    return m->thickness_alpha[v->thickness[v->near_start[brick] +
                                           sc_count_bits(v->near[brick] & (bit - 1))]];
}

static void take_sample(cursor *c, int k)
{
    const sc_march *m = c->m;
    const sc_march_tissue *tissue;
    sc_spot spot = {.eye = c->ray->toward_eye};
    float p[3], rgb[3], alpha;
    int x, y, z, kind;
    MARCH_LABEL label;

    position(c->ray, ((float)k + 0.5f) * m->step_mm, p);
    x = (int)p[0] - 1;
    y = (int)p[1] - 1;
    z = (int)p[2] - 1;
    c->samples++;
    kind = classify(m, x, y, z, &label);
    if (!kind)
        return;
    tissue = &m->tissues[label];
    if (!kept(c->ray, tissue->clip_group, k))
        return;
    c->contributions++;
    if (kind == SC_SHOW_INTERIOR) {
        sc_blend(&c->light, tissue->rgb, tissue->interior_alpha);
        return;
    }
    if (!normal_at(m->volume, p, label, spot.normal)) {
        for (int i = 0; i < 3; i++)
            spot.normal[i] = c->ray->toward_eye[i];
    }
    sc_face_eye(c->ray->toward_eye, spot.normal);
    for (int i = 0; i < 3; i++)
        spot.place[i] = p[i] - 0.5f;
    spot.depth_mm = c->ray->base_mm + ((float)k + 0.5f) * m->step_mm;
    alpha = boundary_alpha(m, tissue, x, y, z);
    sc_light(m, tissue, &spot, rgb);
    sc_note(&c->light, label, alpha, spot.depth_mm, spot.normal);
    sc_blend(&c->light, rgb, alpha);
}

static void march_ray(cursor *c, bool caps)
{
    int k = INT32_MIN, last;

    while (c->light.transmittance >= SC_OPAQUE && next_part(c->ray, k, &k, &last)) {
        if (caps)
            take_caps_before(c, k);
        last = next_event(c->ray, k, last);
        if (c->m->only_caps) {
            k = last;
            continue;
        }
        while (c->light.transmittance >= SC_OPAQUE && (k = find_sample(c, k, last)) < last)
            take_sample(c, k++);
    }
}

void MARCH_NAME(const sc_march *march, const sc_ray *rays, size_t count, sc_radiance *out,
                sc_march_counters *counters)
{
    for (size_t i = 0; i < count; i++) {
        cursor c = {
            .m = march, .ray = &rays[i], .light = {.transmittance = 1, .depth_mm = HUGE_VALF}};

        march_ray(&c, march->caps);
        out[i] = c.light;
        counters->samples += c.samples;
        counters->contributions += c.contributions;
    }
    counters->rays += count;
}
