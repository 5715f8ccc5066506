/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: one ray through the voxel surface model: where its samples lie, the parts of
 * it that the clip planes leave, and the cut faces at which these begin. Used by the template that
 * marches one ray at a time and, for cut faces, by the one that marches many. */
#ifndef SC_KERNEL_VOXEL_RAY_H
#define SC_KERNEL_VOXEL_RAY_H

#include "cursor.h"

/* Index of voxel (x, y, z) in the array of labels; it must lie in the volume. */
static inline size_t voxel_index(const sc_prepared *v, int x, int y, int z)
{
    return ((size_t)z * (size_t)v->size[1] + (size_t)y) * (size_t)v->size[0] + (size_t)x;
}

/* Is (x, y, z) a voxel of the volume? Any numbers are allowed. */
static inline bool in_volume(const sc_prepared *v, int x, int y, int z)
{
    return (unsigned)x < (unsigned)v->size[0] && (unsigned)y < (unsigned)v->size[1] &&
           (unsigned)z < (unsigned)v->size[2];
}

/* The label (dense id) of a voxel of the volume. @param bytes v->label_bytes. */
static inline uint32_t label_at(const sc_prepared *v, int bytes, int x, int y, int z)
{
    const size_t index = voxel_index(v, x, y, z);

    return bytes == 1 ? ((const uint8_t *)v->ids)[index] : ((const uint16_t *)v->ids)[index];
}

/* Position at the distance @p t in mm along the ray, in grid coordinates plus 1/2, to @p p. */
static inline void position(const sc_ray *ray, float t, float p[3])
{
    for (int i = 0; i < 3; i++)
        p[i] = ray->origin[i] + ray->direction[i] * t;
}

/* Number of the first sample within the box of the march, to @p first, and of the first one
 * beyond it, to @p last; both 0 if the ray misses the box. */
static inline void samples_in_box(const sc_march *m, const sc_ray *ray, int *first, int *last)
{
    float inverse[3], near, far;

    for (int i = 0; i < 3; i++) {
        const float d = ray->direction[i];

        inverse[i] = d > -SC_PARALLEL && d < SC_PARALLEL ? SC_NEVER_MM : 1 / d;
    }
    sc_clip_to_box(m, ray->origin, inverse, 0.5f, &near, &far);
    *first = near < far ? (int)ceilf(near / m->step_mm - 0.5f) : 0;
    *last = near < far ? (int)ceilf(far / m->step_mm - 0.5f) : 0;
}

/* Add to c->light the cut face at which part number @p part of the clip set begins, and whose
 * cap_plane is not -1: it is solid where a visible tissue of the clip set is cut; elsewhere
 * nothing is added. */
static inline void add_cap(cursor *c, int clip_set, int part)
{
    const sc_march *m = c->m;
    const int plane = c->ray->parts[clip_set][part].cap_plane;
    const float t = c->ray->parts[clip_set][part].begin_mm;
    sc_spot spot = {.eye = c->ray->toward_eye, .depth_mm = c->ray->base_mm + t};
    float p[3], rgb[3];
    uint32_t label;
    int x, y, z;

    position(c->ray, t, p);
    x = (int)p[0] - 1;
    y = (int)p[1] - 1;
    z = (int)p[2] - 1;
    if (!in_volume(m->volume, x, y, z))
        return;
    label = label_at(m->volume, m->volume->label_bytes, x, y, z);
    if (!m->tissues[label].show || m->tissues[label].clip_set != clip_set)
        return;
    for (int i = 0; i < 3; i++) {
        spot.normal[i] = -m->planes.normals[plane][i];
        spot.point[i] = p[i] - 0.5f;
    }
    if (sc_has_rims(m) && !m->cut_faces.only)
        spot.rim = sc_rim(m, &m->tissues[label], &spot);
    (void)sc_light_cut(m, &m->tissues[label], &spot, rgb);
    c->contributions++;
    sc_remember_surface(&c->light, label, m->tissues[label].cap_alpha, spot.depth_mm, spot.normal,
                        c->ray->ends_below);
    sc_blend(&c->light, rgb, m->tissues[label].cap_alpha, c->ray->ends_below);
}

/* Find the first sample from @p k on that any clip set keeps, to @p first, and the end of the
 * part that it belongs to, to @p last. @return false if there is none; *first is then INT32_MAX. */
static inline bool next_part(const sc_ray *ray, int k, int *first, int *last)
{
    *first = INT32_MAX;
    *last = 0;
    for (int g = 0; g < ray->clip_sets; g++) {
        for (int i = 0; i < ray->part_count[g]; i++) {
            const int begin = ray->parts[g][i].first > k ? ray->parts[g][i].first : k;

            if (begin >= ray->parts[g][i].last)
                continue;
            if (begin < *first) {
                *first = begin;
                *last = ray->parts[g][i].last;
            }
        }
    }
    return *first != INT32_MAX;
}

/* Add the cut faces that lie between samples k - 1 and k, front to back, to c->light. */
static inline void add_caps_before(cursor *c, int k)
{
    const sc_ray *ray = c->ray;

    for (int i = 0; i < 2; i++) {
        for (int g = 0; g < ray->clip_sets; g++) {
            if (i < ray->part_count[g] && ray->parts[g][i].cap_plane >= 0 &&
                ray->parts[g][i].first == k && !is_over(c))
                add_cap(c, g, i);
        }
    }
}

/* Add the cut faces that lie between samples k - 1 and k, unless the ray is to stop before them:
 * they count as if they lay in the middle. @return false if it has stopped. */
static inline bool pass_caps_before(cursor *c, int k)
{
    const sc_radiance before = c->light;
    const uint64_t contributions = c->contributions;

    add_caps_before(c, k);
    if (!c->way || c->contributions == contributions || !stops_before(c, (float)k * c->m->step_mm))
        return true;
    c->light = before;
    c->contributions = contributions;
    c->way->walks = false;
    return false;
}

/* The first sample after @p k at which a part of any clip set begins or ends, or @p last if
 * there is none before it. */
static inline int next_event(const sc_ray *ray, int k, int last)
{
    for (int g = 0; g < ray->clip_sets; g++) {
        for (int i = 0; i < ray->part_count[g]; i++) {
            if (ray->parts[g][i].first > k && ray->parts[g][i].first < last)
                last = ray->parts[g][i].first;
            if (ray->parts[g][i].last > k && ray->parts[g][i].last < last)
                last = ray->parts[g][i].last;
        }
    }
    return last;
}

/* Do the planes of the clip set leave sample @p k? */
static inline bool kept(const sc_ray *ray, int clip_set, int k)
{
    for (int i = 0; i < ray->part_count[clip_set]; i++) {
        if (k >= ray->parts[clip_set][i].first && k < ray->parts[clip_set][i].last)
            return true;
    }
    return false;
}

#endif
