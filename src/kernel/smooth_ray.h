/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: a ray on its own through the smooth surface model: its walk from cell to cell,
 * its kept stretches, and the cut faces at their begins. Shared by the templates that march one ray
 * at a time and by those that march many. MARCH_LABEL is the type of the labels. */
#ifndef SC_KERNEL_SMOOTH_RAY_H
#define SC_KERNEL_SMOOTH_RAY_H

#include "cell.h"
#include "shade.h"

enum { LABEL_BYTES = sizeof(MARCH_LABEL) };

typedef struct cursor {
    const sc_march *m;
    const sc_ray *ray;
    sc_radiance light;
    uint64_t samples, contributions;
    /* the walk */
    sc_cell cell;
    float direction[3]; /* the ray's, but 0 for what is so small that it never leaves a cell */
    float inverse[3];   /* mm per place */
    int step[3];
    float t;  /* where the ray has entered the cell */
    int axis; /* the plane it came through; -1: none */
} cursor;

/* Distance at which the ray meets the plane at a whole place. */
static inline float plane_mm(const cursor *c, int axis, int plane)
{
    return ((float)plane - c->ray->origin[axis]) * c->inverse[axis];
}

/* Where the ray leaves the cell along one axis. */
static inline float exit_mm(const cursor *c, int axis)
{
    return plane_mm(c, axis, c->cell.q[axis] + (c->step[axis] > 0));
}

static inline void start_walk(cursor *c)
{
    for (int i = 0; i < 3; i++) {
        const float d = c->ray->direction[i];
        const bool still = d > -1e-20f && d < 1e-20f; /* never leaves along this axis */

        c->direction[i] = still ? 0 : d;
        c->inverse[i] = still ? 1e30f : 1 / d;
        c->step[i] = d < 0 && !still ? -1 : 1;
    }
}

/* Find the cell in which single steps would be after the plane (t, axis): planes are crossed in
 * the order of their distances, those at the same distance in the order of their axes. */
static inline void locate(cursor *c, float t, int axis)
{
    c->t = t;
    c->axis = axis;
    for (int i = 0; i < 3; i++) {
        int *q = &c->cell.q[i];
        float mm;

        if (i == axis)
            continue;
        *q = (int)floorf(c->ray->origin[i] + c->direction[i] * t);
        if (c->inverse[i] == 1e30f)
            continue;
        while ((mm = exit_mm(c, i)) < t || (mm == t && i < axis))
            *q += c->step[i];
        while ((mm = plane_mm(c, i, *q + (c->step[i] < 0))) > t || (mm == t && i > axis))
            *q -= c->step[i];
    }
}

/* Position within the cell at distance @p t; @p axis: the coordinate that is known exactly. */
static inline void local_at(const cursor *c, float t, int axis, bool leaving, float out[3])
{
    for (int i = 0; i < 3; i++) {
        if (i == axis)
            out[i] = (c->step[i] > 0) == leaving ? 1 : 0;
        else
            out[i] = sc_clamp01(c->ray->origin[i] + c->direction[i] * t - (float)c->cell.q[i]);
    }
}

static inline void place_at(const cursor *c, float t, float out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = c->ray->origin[i] + c->direction[i] * t;
}

/* How dark the line between two tissues is at the point @p a of a cut face: 1 on it, 0 beyond its
 * width. The distance to the border is the difference of the votes by its slope in the plane. */
static inline float outline_at(const cursor *c, uint32_t owner, const float a[3], const float n[3])
{
    const sc_cell *cell = &c->cell;
    float nearest = 1e9f;

    for (int k = 0; k < cell->kind_count; k++) {
        float s[SC_CORNERS], slope[3], across = 0, square = 0, ends[2][3], distance;

        if (cell->kinds[k] == owner)
            continue;
        sc_cell_difference(cell, owner, cell->kinds[k], s);
        for (int i = 0; i < 3; i++) {
            for (int e = 0; e < 2; e++) {
                for (int j = 0; j < 3; j++)
                    ends[e][j] = j == i ? (float)e : a[j];
            }
            slope[i] = sc_trilinear(s, ends[1]) - sc_trilinear(s, ends[0]);
        }
        for (int i = 0; i < 3; i++)
            across += slope[i] * n[i];
        for (int i = 0; i < 3; i++)
            square += (slope[i] - across * n[i]) * (slope[i] - across * n[i]);
        distance = sc_trilinear(s, a) / (sqrtf(square) + 1e-6f);
        nearest = distance < nearest ? distance : nearest;
    }
    return sc_clamp01(1.5f - nearest / c->m->cap_outline);
}

/* Unit normal of a clip plane in the space of places. */
static inline void plane_in_places(const sc_march *m, int plane, float out[3])
{
    const float *p = m->plane_places[plane];
    const float length = sqrtf(sc_dot3(p, p));

    for (int i = 0; i < 3; i++)
        out[i] = p[i] / length;
}

/* The cut face at distance @p t: solid where a visible tissue of the group is cut. */
static inline void take_cap(cursor *c, int group, int plane, float t)
{
    const sc_march *m = c->m;
    const float depth_mm = c->ray->base_mm + t;
    float a[3], n[3], in_places[3], rgb[3], line = 0;
    uint32_t owner;

    locate(c, t, -1);
    local_at(c, t, -1, false, a);
    if (sc_cell_labels(m->volume, LABEL_BYTES, &c->cell)) {
        sc_cell_fill(m->volume, &c->cell);
        owner = sc_cell_owner(&c->cell, a);
        if (m->cap_outline > 0) {
            plane_in_places(m, plane, in_places);
            line = outline_at(c, owner, a, in_places);
        }
    } else {
        owner = c->cell.labels[0];
    }
    if (!m->tissues[owner].show || m->tissues[owner].clip_group != group)
        return;
    for (int i = 0; i < 3; i++)
        n[i] = -m->plane_normals[plane][i];
    sc_light_cut(m, c->ray->toward_eye, n, depth_mm, m->tissues[owner].rgb, rgb);
    for (int i = 0; i < 3; i++)
        rgb[i] *= 1 - 0.75f * line;
    sc_note(&c->light, owner, 1, depth_mm, n);
    sc_blend(&c->light, rgb, 1);
    c->contributions++;
}

/* The next stretch of the ray from @p t on with the same groups kept. */
static inline bool next_span(const sc_ray *ray, float t, float *begin, float *end, uint32_t *active)
{
    if (ray->groups == 1 && ray->part_count[0] == 1) { /* no plane: nearly always */
        *begin = ray->parts[0][0].begin_mm > t ? ray->parts[0][0].begin_mm : t;
        *end = ray->parts[0][0].end_mm;
        *active = 1;
        return *begin < *end;
    }
    *begin = HUGE_VALF;
    for (int g = 0; g < ray->groups; g++) {
        for (int i = 0; i < ray->part_count[g]; i++) {
            const float from = ray->parts[g][i].begin_mm > t ? ray->parts[g][i].begin_mm : t;

            if (from < ray->parts[g][i].end_mm && from < *begin)
                *begin = from;
        }
    }
    *end = HUGE_VALF;
    *active = 0;
    for (int g = 0; g < ray->groups; g++) {
        for (int i = 0; i < ray->part_count[g]; i++) {
            const float from = ray->parts[g][i].begin_mm, to = ray->parts[g][i].end_mm;
            const bool kept = from <= *begin && *begin < to;

            *active |= kept ? 1u << g : 0;
            if (kept && to < *end)
                *end = to;
            if (from > *begin && from < *end)
                *end = from;
        }
    }
    return *begin < HUGE_VALF;
}

static inline void take_caps(cursor *c, float begin)
{
    const sc_ray *ray = c->ray;

    for (int g = 0; g < ray->groups; g++) {
        for (int i = 0; i < ray->part_count[g]; i++) {
            if (ray->parts[g][i].cap_plane >= 0 && ray->parts[g][i].begin_mm == begin &&
                c->light.transmittance >= SC_OPAQUE)
                take_cap(c, g, ray->parts[g][i].cap_plane, begin);
        }
    }
}

#endif
