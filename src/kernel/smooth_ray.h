/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: one ray through the smooth surface model: its walk from cell to cell, the
 * stretches of it that the clip planes leave, and the cut faces at which these begin. Used by the
 * template that marches one ray at a time and, for cut faces, by the one that marches many. */
#ifndef SC_KERNEL_SMOOTH_RAY_H
#define SC_KERNEL_SMOOTH_RAY_H

#include "cursor.h"
#include "rim.h"

#include <string.h>

/* How much of the light an outline on a cut face takes. */
#define OUTLINE_DARK 0.75f

/* Distance in mm at which the ray meets a grid plane: those of its points whose coordinate along
 * @p axis is @p plane. */
static inline float plane_mm(const cursor *c, int axis, int plane)
{
    return ((float)plane - c->ray->origin[axis]) * c->inverse[axis];
}

/* Distance in mm at which the ray leaves the present cell along one axis. */
static inline float exit_mm(const cursor *c, int axis)
{
    return plane_mm(c, axis, c->cell.q[axis] + (c->step[axis] > 0));
}

/* Set direction, inverse and step of the cursor from its ray, before anything else is done with
 * it. */
static inline void start_walk(cursor *c)
{
    for (int i = 0; i < 3; i++) {
        const float d = c->ray->direction[i];
        const bool parallel = d > -SC_PARALLEL && d < SC_PARALLEL; /* to the grid planes */

        c->direction[i] = parallel ? 0 : d;
        c->inverse[i] = parallel ? SC_NEVER_MM : 1 / d;
        c->step[i] = d < 0 && !parallel ? -1 : 1;
    }
}

/* Set c->cell.q to the cell that single steps would have reached after crossing the grid plane
 * of @p axis at distance @p t, and c->t and c->axis. Along @p axis the caller has set cell.q
 * itself; -1: the ray begins at @p t, and all of it is set. Planes are crossed in the order of
 * their distances, and those at the same distance in the order of their axes. The position gives
 * a first guess of the cell; the loops correct what rounding made of it. */
static inline void locate_cell(cursor *c, float t, int axis)
{
    c->t = t;
    c->axis = axis;
    for (int i = 0; i < 3; i++) {
        int *q = &c->cell.q[i];
        float mm;

        if (i == axis)
            continue;
        *q = (int)floorf(c->ray->origin[i] + c->direction[i] * t);
        if (c->inverse[i] == SC_NEVER_MM)
            continue;
        while ((mm = exit_mm(c, i)) < t || (mm == t && i < axis))
            *q += c->step[i];
        while ((mm = plane_mm(c, i, *q + (c->step[i] < 0))) > t || (mm == t && i > axis))
            *q -= c->step[i];
    }
}

/* Position within the present cell at distance @p t, each coordinate in [0, 1], to @p out. Along
 * @p axis (-1: none) the ray is exactly on a face of the cell: the one it leaves through if @p
 * leaving, else the one it entered. */
static inline void local_at(const cursor *c, float t, int axis, bool leaving, float out[3])
{
    for (int i = 0; i < 3; i++) {
        if (i == axis)
            out[i] = (c->step[i] > 0) == leaving ? 1 : 0;
        else
            out[i] = sc_clamp01(c->ray->origin[i] + c->direction[i] * t - (float)c->cell.q[i]);
    }
}

/* The position at distance @p t in grid coordinates, to @p out. */
static inline void point_at(const cursor *c, float t, float out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = c->ray->origin[i] + c->direction[i] * t;
}

/* How dark the outline of tissues is at the point @p a of a cut face in the present cell, for which
 * sc_cell_read has returned true: 1 up to half of cap_outline from where the owner ends, falling to
 * 0 at 1.5 times cap_outline. That distance is what the owner leads by divided by the slope of that
 * within the plane with unit normal @p n (in grid coordinates). */
static inline float outline_at(const cursor *c, uint32_t owner, const float a[3], const float n[3])
{
    uint32_t others[SC_CORNERS + 1];
    const int count = sc_cell_others(&c->cell, owner, others);
    float nearest = 1e9f;

    for (int k = 0; k < count; k++) {
        float lead[SC_CORNERS], slope[3], across = 0, square = 0, distance;

        sc_cell_lead(&c->cell, owner, others[k], lead);
        sc_cell_slope(lead, a, slope);
        for (int i = 0; i < 3; i++)
            across += slope[i] * n[i];
        for (int i = 0; i < 3; i++)
            square += (slope[i] - across * n[i]) * (slope[i] - across * n[i]);
        distance = sc_trilinear(lead, a) / (sqrtf(square) + 1e-6f);
        nearest = distance < nearest ? distance : nearest;
    }
    return sc_clamp01(1.5f - nearest / c->m->cut_faces.outline);
}

/* Draw the line between tissues, whose strength is @p line, on a cut face of the linear colour @p
 * rgb: dark; but over a grey volume, by its share, in the colour of the tissue, which tells whose
 * border it is. */
static inline void draw_outline(const sc_march *m, const sc_march_tissue *tissue, bool shows_grey,
                                float line, float rgb[3])
{
    const float own = shows_grey ? m->cut_faces.grey_share * line : 0;

    for (int i = 0; i < 3; i++) {
        rgb[i] *= 1 - OUTLINE_DARK * line;
        if (shows_grey)
            rgb[i] += own * (tissue->rgb[i] - rgb[i]);
    }
}

/* Unit normal of clip plane number @p plane in grid coordinates, to @p out. */
static inline void plane_in_grid(const sc_march *m, int plane, float out[3])
{
    const float *p = m->planes.equations[plane];
    const float length = sqrtf(sc_dot3(p, p));

    for (int i = 0; i < 3; i++)
        out[i] = p[i] / length;
}

/* Add the cut face of clip plane number @p plane at distance @p t to c->light: it is solid where
 * a visible tissue of the clip set is cut; elsewhere nothing is added. Moves the cursor to that
 * cell. */
static inline void add_cap(cursor *c, int clip_set, int plane, float t)
{
    const sc_march *m = c->m;
    sc_spot spot = {.eye = c->ray->toward_eye, .depth_mm = c->ray->base_mm + t};
    float a[3], in_grid[3], rgb[3], line = 0;
    uint32_t owner;
    bool mixed, shows_grey;

    locate_cell(c, t, -1);
    local_at(c, t, -1, false, a);
    mixed = sc_cell_read(m->volume, &c->cell);
    owner = sc_cell_owner_at(&c->cell, a);
    if (!m->tissues[owner].show || m->tissues[owner].clip_set != clip_set)
        return;
    if (mixed && m->cut_faces.outline > 0) {
        plane_in_grid(m, plane, in_grid);
        line = outline_at(c, owner, a, in_grid);
    }
    for (int i = 0; i < 3; i++)
        spot.normal[i] = -m->planes.normals[plane][i];
    point_at(c, t, spot.point);
    if (sc_has_rims(m) && !m->cut_faces.only)
        sc_set_cut_rim(m, &c->cell, mixed, owner, a, &spot);
    shows_grey = sc_light_cut(m, &m->tissues[owner], &spot, rgb);
    draw_outline(m, &m->tissues[owner], shows_grey, line, rgb);
    sc_remember_surface(&c->light, owner, m->tissues[owner].cap_alpha, spot.depth_mm, spot.normal,
                        c->ray->ends_below);
    sc_blend(&c->light, rgb, m->tissues[owner].cap_alpha, c->ray->ends_below);
    c->contributions++;
}

/* The next stretch of the ray after the distance @p t on which the same clip sets are kept, to
 * @p begin and @p end (mm from the origin). @param active those clip sets: bit i for clip set i.
 * @return false if there is none; the results are then meaningless. */
static inline bool next_stretch(const sc_ray *ray, float t, float *begin, float *end,
                                uint32_t *active)
{
    if (ray->clip_sets == 1 && ray->part_count[0] == 1) { /* the usual case: no clip planes */
        *begin = ray->parts[0][0].begin_mm > t ? ray->parts[0][0].begin_mm : t;
        *end = ray->parts[0][0].end_mm;
        *active = 1;
        return *begin < *end;
    }
    *begin = HUGE_VALF;
    for (int g = 0; g < ray->clip_sets; g++) {
        for (int i = 0; i < ray->part_count[g]; i++) {
            const float from = ray->parts[g][i].begin_mm > t ? ray->parts[g][i].begin_mm : t;

            if (from < ray->parts[g][i].end_mm && from < *begin)
                *begin = from;
        }
    }
    *end = HUGE_VALF;
    *active = 0;
    for (int g = 0; g < ray->clip_sets; g++) {
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

/* Add the cut faces of all parts that begin exactly at distance @p begin, until the ray is
 * opaque. Moves the cursor. */
static inline void add_caps(cursor *c, float begin)
{
    const sc_ray *ray = c->ray;

    for (int g = 0; g < ray->clip_sets; g++) {
        for (int i = 0; i < ray->part_count[g]; i++) {
            if (ray->parts[g][i].cap_plane >= 0 && ray->parts[g][i].begin_mm == begin &&
                !is_over(c))
                add_cap(c, g, ray->parts[g][i].cap_plane, begin);
        }
    }
}

/* The same, unless the ray is to stop before them. @return false if it has stopped. */
static inline bool pass_caps(cursor *c, float begin)
{
    const sc_radiance before = c->light;
    const uint64_t contributions = c->contributions;

    add_caps(c, begin);
    if (!c->way || c->contributions == contributions || !stops_before(c, begin))
        return true;
    c->light = before;
    c->contributions = contributions;
    c->way->walks = false;
    return false;
}

#endif
