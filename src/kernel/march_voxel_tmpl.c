/* SPDX-License-Identifier: BSD-3-Clause */
/* Template: the voxel surface model, one ray at a time, in plain C: the specification. Compiled
 * once per skip method (MARCH_SKIPS: 0 for SC_SKIP_NONE, 1 for SC_SKIP_INTERIOR) under the name
 * MARCH_NAME.
 *
 * Without skipping, a sample is classified from the labels around it, and nothing that
 * preprocessing has found is used; with skipping, one bit of the visible masks decides. Both must
 * agree. */
#include "variants.h"
#include "voxel_ray.h"

#if !MARCH_SKIPS
/* The paper's rule (section 2.3): does the 3x3x3 neighbourhood of the voxel hold a label other
 * than @p label, its own, or reach out of the volume? @param bytes v->label_bytes: a constant where
 * this is inlined, so that the width is not asked for 27 times. */
static inline bool is_boundary(const sc_prepared *v, int bytes, int x, int y, int z, uint32_t label)
{
    for (int dz = -1; dz <= 1; dz++) {
        for (int dy = -1; dy <= 1; dy++) {
            for (int dx = -1; dx <= 1; dx++) {
                if (!in_volume(v, x + dx, y + dy, z + dz) ||
                    label_at(v, bytes, x + dx, y + dy, z + dz) != label)
                    return true;
            }
        }
    }
    return false;
}
#endif

/* @return what the voxel contributes: SC_SHOW_BOUNDARY, SC_SHOW_INTERIOR or 0 (nothing, or
 * outside of the volume). @param label is set to its label, unless 0 is returned. */
static inline int classify(const sc_march *m, int x, int y, int z, uint32_t *label)
{
    const sc_prepared *v = m->volume;
#if MARCH_SKIPS
    /* is_marked() has found that the voxel is visible. */
    *label = label_at(v, v->label_bytes, x, y, z);
    return sc_is_near(v, x + 1, y + 1, z + 1) ? SC_SHOW_BOUNDARY : SC_SHOW_INTERIOR;
#else
    bool boundary;

    if (!in_volume(v, x, y, z))
        return 0;
    *label = label_at(v, v->label_bytes, x, y, z);
    if (!m->tissues[*label].show)
        return 0;
    boundary = v->label_bytes == 1 ? is_boundary(v, 1, x, y, z, *label)
                                   : is_boundary(v, 2, x, y, z, *label);
    return m->tissues[*label].show & (boundary ? SC_SHOW_BOUNDARY : SC_SHOW_INTERIOR);
#endif
}

#if MARCH_SKIPS
/* Is the voxel of sample @p k visible by the masks? The frame of empty bricks around them makes
 * bounds checks unnecessary. */
static inline bool is_marked(const cursor *c, int k)
{
    const sc_march *m = c->m;
    const float t = ((float)k + 0.5f) * m->step_mm;
    const int x = (int)(c->ray->origin[0] + c->ray->direction[0] * t) + SC_BRICK;
    const int y = (int)(c->ray->origin[1] + c->ray->direction[1] * t) + SC_BRICK;
    const int z = (int)(c->ray->origin[2] + c->ray->direction[2] * t) + SC_BRICK;
    const int brick =
        sc_brick_of(z) * m->marked.layer + sc_brick_of(y) * m->marked.row + sc_brick_of(x);

    return m->marked.masks[brick] >> sc_brick_bit(x, y, z) & 1;
}
#endif

/* The first sample from @p k on that has to be classified, or @p last; without skipping always
 * @p k. Counts the samples passed over. */
static inline int find_sample(cursor *c, int k, int last)
{
#if MARCH_SKIPS
    const int begin = k;

    while (k < last && !is_marked(c, k))
        k++;
    c->cell_visits += (uint64_t)(k - begin);
#else
#endif
    return k;
}

/* Add sample @p k, of a boundary voxel of @p tissue, to c->light, with the voxel's own normal,
 * which preprocessing has found (paper, section 2.3), and its own opacity. @p p: position of the
 * sample in grid coordinates plus 1/2. */
static void add_boundary(cursor *c, int k, const sc_march_tissue *tissue, const float p[3])
{
    const sc_march *m = c->m;
    const uint32_t label = (uint32_t)(tissue - m->tissues);
    const bool measured = tissue->by_thickness && m->volume->thickness;
    const int vertex[3] = {(int)p[0], (int)p[1], (int)p[2]};
    const int voxel[3] = {vertex[0] - 1, vertex[1] - 1, vertex[2] - 1};
    sc_spot spot = {.eye = c->ray->toward_eye,
                    .depth_mm = c->ray->base_mm + ((float)k + 0.5f) * m->step_mm};
    float rgb[3], alpha = tissue->boundary_alpha;

    if (measured)
        alpha = m->thickness_alpha[m->volume->thickness[sc_near_index(m->volume, vertex[0],
                                                                      vertex[1], vertex[2])]] *
                tissue->thickness_factor;
    sc_voxel_normal(m, sc_voxel_record(m->volume, vertex[0], vertex[1], vertex[2]), voxel,
                    c->ray->toward_eye, spot.normal);
    for (int i = 0; i < 3; i++)
        spot.point[i] = p[i] - 0.5f;
    sc_face_eye(c->ray->toward_eye, spot.normal);
    sc_light(m, tissue, &spot, rgb);
    sc_remember_surface(&c->light, label, alpha, spot.depth_mm, spot.normal, c->ray->ends_below);
    sc_blend(&c->light, rgb, alpha, c->ray->ends_below);
}

/* Add a sample of the interior of @p tissue to c->light. That has no face: of a ray with ends_below
 * it looks towards the eye. */
static void add_interior(cursor *c, const sc_march_tissue *tissue, float depth_mm)
{
    const float ends_below = c->ray->ends_below;

    if (ends_below > 0)
        sc_remember_surface(&c->light, (uint32_t)(tissue - c->m->tissues), tissue->interior_alpha,
                            depth_mm, c->ray->toward_eye, ends_below);
    sc_blend(&c->light, tissue->rgb, tissue->interior_alpha, ends_below);
}

/* Classify sample @p k and add it to c->light, unless it is not shown or its clip set does not
 * keep it. @return false if the ray has stopped before it. */
static bool add_sample(cursor *c, int k)
{
    const sc_march *m = c->m;
    const float t = ((float)k + 0.5f) * m->step_mm;
    const sc_march_tissue *tissue;
    float p[3];
    int x, y, z, kind;
    uint32_t label;

    position(c->ray, t, p);
    x = (int)p[0] - 1;
    y = (int)p[1] - 1;
    z = (int)p[2] - 1;
    c->cell_visits++;
    kind = classify(m, x, y, z, &label);
    if (!kind)
        return true;
    tissue = &m->tissues[label];
    /* The masks still have what has faded away in this frame. */
    if (!tissue->show || !kept(c->ray, tissue->clip_set, k))
        return true;
    if (c->way && stops_before(c, t))
        return false;
    c->contributions++;
    if (kind == SC_SHOW_INTERIOR)
        add_interior(c, tissue, c->ray->base_mm + t);
    else
        add_boundary(c, k, tissue, p);
    return true;
}

/* March the cursor's ray, part by part, with the cut faces at their beginnings if @p caps, and
 * nothing else if c->m->only_caps. Ends when the ray is opaque, or where it stops. The result is
 * c->light. */
static void march_ray(cursor *c, bool caps)
{
    int from = c->way ? c->way->at[1] : INT32_MIN, k, last, nearest, farthest;

    samples_in_box(c->m, c->ray, &nearest, &farthest);
    while (!is_over(c) && next_part(c->ray, from, &k, &last)) {
        const bool goes_on = c->way && c->way->walks;
        int at = goes_on ? c->way->at[0] : k > nearest ? k : nearest, end;

        if (c->way) {
            c->way->at[1] = from;
            c->way->walks = false;
        }
        if (caps && !goes_on && !pass_caps_before(c, k))
            return;
        last = next_event(c->ray, k, last);
        end = last < farthest ? last : farthest;
        from = last;
        if (c->m->cut_faces.only)
            continue;
        while (!is_over(c) && (at = find_sample(c, at, end)) < end) {
            if (!add_sample(c, at)) {
                c->way->walks = true;
                c->way->at[0] = at;
                return;
            }
            at++;
        }
    }
}

/* The kernel: see sc_march_fn. Rays are marched one after the other. */
void MARCH_NAME(const sc_march *march, const sc_ray *rays, sc_way *ways, size_t count,
                sc_radiance *out, sc_march_counters *counters)
{
    for (size_t i = 0; i < count; i++) {
        cursor c = {.m = march, .ray = &rays[i], .light = ways ? out[i] : sc_no_light()};

        if (ways) {
            c.way = &ways[i];
            c.limit_mm = c.way->before_mm;
            c.way->next_mm = HUGE_VALF;
            c.way->passed = false;
        }
        march_ray(&c, march->cut_faces.are_drawn);
        out[i] = c.light;
        counters->cell_visits += c.cell_visits;
        counters->contributions += c.contributions;
    }
    counters->rays += count;
}
