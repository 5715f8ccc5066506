/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: one ray on its way through either surface, and where it ends or stops. */
#ifndef SC_KERNEL_CURSOR_H
#define SC_KERNEL_CURSOR_H

#include "cell.h"
#include "shade.h"

/* One ray on its way. The caller sets m, ray, light, and with a way limit_mm; start_walk sets
 * direction, inverse and step, and locate_cell sets cell.q, t and axis. */
typedef struct cursor {
    const sc_march *m;
    const sc_ray *ray;
    sc_way *way;    /* NULL: the ray goes to its end at once */
    float limit_mm; /* with a way: the ray stops before what is not nearer to the eye than this */
    sc_radiance light;
    uint64_t cell_visits, contributions; /* see sc_march_counters */
    /* the walk through a smooth surface */
    sc_cell cell;
    float direction[3]; /* the ray's; 0 where it is too small ever to leave a cell */
    float inverse[3];   /* 1 / direction: ray length in mm between two grid planes */
    int step[3];        /* 1 or -1: towards which neighbouring cell the ray goes along each axis */
    float t;            /* distance in mm at which the ray has entered the cell */
    int axis;           /* axis of the grid plane through which it came in; -1: it began here */
} cursor;

/* Is the ray at its end, because it is opaque, or has met the surface that it looks for? */
static inline bool is_over(const cursor *c)
{
    return c->light.transmittance < c->m->opaque_below ||
           c->light.transmittance < c->ray->ends_below;
}

/* With a way: is the ray to stop before what it meets at distance @p t? The way notes which. */
static inline bool stops_before(cursor *c, float t)
{
    const float depth_mm = c->ray->base_mm + t;

    if (depth_mm < c->limit_mm) {
        c->limit_mm = c->way->limit_mm;
        c->way->passed = true;
        return false;
    }
    c->way->next_mm = depth_mm;
    return true;
}

#endif
