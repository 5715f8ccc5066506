/* SPDX-License-Identifier: BSD-3-Clause */
/* Template: the smooth surface model, one ray at a time, in plain C: the specification. Compiled
 * once per skip method (MARCH_SKIPS: 0 for SC_SKIP_NONE, 1 for SC_SKIP_INTERIOR) under the name
 * MARCH_NAME.
 *
 * A ray steps from cell to cell by whole numbers; the distances at which it crosses the planes
 * between them are computed from those numbers, never summed up, so that a step across an empty
 * brick ends in the very cell, and at the very distance, that single steps would have led to. */
#include "around.h"
#include "normal.h"
#include "smooth_ray.h"
#include "variants.h"

/* Add one side of a crossing to c->light: the surface of @p label, which is the label left or
 * the label entered, at the point @p at of the present cell. */
static void add_surface(cursor *c, uint32_t label, const float at[3], const sc_spot *spot)
{
    const sc_march_tissue *tissue = &c->m->tissues[label];
    const float alpha = sc_edge_alpha(&c->m->light, sc_surface_alpha(c->m, c->cell.q, label, at),
                                      sc_dot3(spot->normal, spot->eye));
    float rgb[3];

    sc_light(c->m, tissue, spot, rgb);
    sc_remember_surface(&c->light, label, alpha, spot->depth_mm, spot->normal, c->ray->ends_below);
    sc_blend(&c->light, rgb, alpha, c->ray->ends_below);
    c->contributions++;
}

/* Is the boundary of the label shown, and its clip set one of those kept (bits @p active)? */
static bool contributes(const cursor *c, uint32_t label, uint32_t active)
{
    const sc_march_tissue *tissue = &c->m->tissues[label];

    return tissue->show & SC_SHOW_BOUNDARY && active >> tissue->clip_set & 1;
}

/* Add both sides of a crossing to c->light, as far as they contribute and the ray is not opaque.
 * The ray passes the cell, which has been read, from the point @p a to @p b, and the crossing
 * lies @p t mm from its origin. @p active: the clip sets kept, as bits. */
static void add_crossing(cursor *c, const sc_crossing *x, const float a[3], const float b[3],
                         float t, uint32_t active)
{
    const bool left = contributes(c, x->left, active), entered = contributes(c, x->entered, active);
    sc_spot spot = {.eye = c->ray->toward_eye, .depth_mm = c->ray->base_mm + t};
    float at[3], length;

    if (!left && !entered)
        return;
    for (int i = 0; i < 3; i++)
        at[i] = sc_lerp(a[i], b[i], x->u);
    point_at(c, t, spot.point);
    if (x->face) {
        sc_face_normal(c->m, x->face - 1, c->ray->toward_eye, spot.normal);
        if (sc_has_rims(c->m))
            spot.rim = sc_volume_face_rim(c->m, &c->cell, x->left ? x->left : x->entered, at, &spot,
                                          x->face - 1);
    } else {
        sc_cell_normal(&c->cell, x->entered, x->left, at, spot.normal);
        length = sqrtf(sc_dot3(spot.normal, spot.normal));
        for (int i = 0; i < 3; i++)
            spot.normal[i] =
                length > SC_GRADIENT_LEAST ? spot.normal[i] / length : c->ray->toward_eye[i];
        sc_face_eye(c->ray->toward_eye, spot.normal);
        spot.has_around = c->m->light.sky > 0 && sc_around(c->m, !x->left || !x->entered, c->cell.q,
                                                           at, spot.normal, spot.around);
    }
    if (left)
        add_surface(c, x->left, at, &spot);
    if (entered && !is_over(c))
        add_surface(c, x->entered, at, &spot);
}

/* Add the crossings in the present cell, for which sc_cell_read has returned true, up to distance
 * @p t1, at which the ray leaves it through @p axis, or ends within it (@p axis -1). @return false
 * if the ray has stopped before the first that contributes. */
static bool add_cell_crossings(cursor *c, float t1, int axis, uint32_t active)
{
    sc_crossing crossings[SC_CROSSINGS_MAX];
    bool asks = c->way;
    float a[3], b[3];
    int count;

    local_at(c, c->t, c->axis, false, a);
    local_at(c, t1, axis, true, b);
    count = sc_cell_crossings(&c->cell, a, b, crossings);
    for (int i = 0; i < count && !is_over(c); i++) {
        const sc_crossing *x = &crossings[i];
        const float t = c->t + (t1 - c->t) * x->u;

        if (asks && (contributes(c, x->left, active) || contributes(c, x->entered, active))) {
            if (stops_before(c, t))
                return false;
            asks = false;
        }
        add_crossing(c, x, a, b, t, active);
    }
    return true;
}

#if MARCH_SKIPS
/* The mask of the present cell's brick, which may be one of the frame of empty bricks around the
 * volume, but not lie beyond them. */
static inline uint64_t brick_mask(const cursor *c)
{
    const int *q = c->cell.q;

    const sc_marked *marked = &c->m->marked;

    return marked->masks[sc_framed_index(marked->row, marked->layer, sc_brick_of(q[0]),
                                         sc_brick_of(q[1]), sc_brick_of(q[2]))];
}

/* Step out of the present brick, into the cell that single steps would have reached: sets
 * cell.q, t and axis. */
static inline void leave_brick(cursor *c)
{
    float best = 0;
    int axis = -1, plane = 0;

    for (int i = 0; i < 3; i++) {
        const int far = (c->cell.q[i] & ~SC_BRICK_MASK) + (c->step[i] > 0 ? SC_BRICK : 0);
        const float mm = plane_mm(c, i, far);

        if (axis < 0 || mm < best) {
            best = mm;
            axis = i;
            plane = far;
        }
    }
    c->cell.q[axis] = c->step[axis] > 0 ? plane : plane - 1;
    locate_cell(c, best, axis);
}
#endif

/* Read the present cell. @return whether it can contribute; if not, it may not have been read. */
static inline bool read_marked(cursor *c)
{
#if MARCH_SKIPS
    const int *q = c->cell.q;

    return brick_mask(c) >> sc_brick_bit(q[0], q[1], q[2]) & 1 &&
           sc_cell_read(c->m->volume, &c->cell);
#else
    return sc_cell_read(c->m->volume, &c->cell);
#endif
}

/* Begin the walk along a stretch at distance @p begin; or go on where the ray has stopped within
 * it.
 */
static void begin_walk(cursor *c, float begin)
{
    if (!c->way || !c->way->walks) {
        locate_cell(c, begin, -1);
        return;
    }
    c->t = c->way->t_mm;
    c->axis = c->way->axis;
    memcpy(c->cell.q, c->way->at, sizeof c->cell.q);
    c->way->walks = false;
}

/* Note where the ray has stopped: before the crossings of the present cell. */
static void stop_walk(cursor *c)
{
    c->way->walks = true;
    c->way->t_mm = c->t;
    c->way->axis = (int8_t)c->axis;
    memcpy(c->way->at, c->cell.q, sizeof c->cell.q);
}

/* March from @p begin to @p end (mm from the origin), cell by cell, and add all crossings to
 * c->light, until the ray is opaque. @p active: the clip sets kept on that stretch, as bits.
 * @return false if the ray has stopped before its end. */
static bool walk(cursor *c, float begin, float end, uint32_t active)
{
    if (!(begin < end))
        return true;
    begin_walk(c, begin);
    while (c->t < end && !is_over(c)) {
        float t[3];
        int axis;

        c->cell_visits++;
#if MARCH_SKIPS
        if (!brick_mask(c)) {
            leave_brick(c);
            continue;
        }
#endif
        for (int i = 0; i < 3; i++)
            t[i] = exit_mm(c, i);
        axis = t[0] <= t[1] ? (t[0] <= t[2] ? 0 : 2) : (t[1] <= t[2] ? 1 : 2);
        if (read_marked(c)) {
            const bool within = t[axis] < end;

            if (!add_cell_crossings(c, within ? t[axis] : end, within ? axis : -1, active)) {
                stop_walk(c);
                return false;
            }
        }
        c->t = t[axis];
        c->axis = axis;
        c->cell.q[axis] += c->step[axis];
    }
    return true;
}

/* March the cursor's ray, stretch by stretch, with the cut faces at their beginnings if
 * c->m->caps, and nothing else if c->m->only_caps. Ends when the ray is opaque, or where it stops.
 * The result is c->light. */
static void march_ray(cursor *c)
{
    float from = c->way ? c->way->from_mm : -HUGE_VALF, begin, end, near, far;
    uint32_t active;

    start_walk(c);
    sc_clip_to_box(c->m, c->ray->origin, c->inverse, 0, &near, &far);
    while (!is_over(c) && next_stretch(c->ray, from, &begin, &end, &active)) {
        const bool goes_on = c->way && c->way->walks;

        if (c->way)
            c->way->from_mm = from;
        if (c->m->cut_faces.are_drawn && !goes_on && !pass_caps(c, begin))
            return;
        if (!c->m->cut_faces.only &&
            !walk(c, begin > near ? begin : near, end < far ? end : far, active))
            return;
        from = end;
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
        march_ray(&c);
        out[i] = c.light;
        counters->cell_visits += c.cell_visits;
        counters->contributions += c.contributions;
    }
    counters->rays += count;
}
