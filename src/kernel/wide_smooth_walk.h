/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: the first part of the template wide_smooth_tmpl.c, which alone includes it:
 * the packets of rays, and their way across empty space to the next cell that has to be searched.
 */
#ifndef SC_KERNEL_WIDE_SMOOTH_WALK_H
#define SC_KERNEL_WIDE_SMOOTH_WALK_H

#include "lanes/lanes_cell.h"
#include "lanes/lanes_shade.h"
#include "smooth_ray.h"
#include "variants.h"

#include MARCH_EMPTY

/* The next crossing of each lane in its cell, and the further ones of the lanes that have
 * several. It persists between cells: only the lanes searched are overwritten. */
typedef struct crossings {
    vi left, entered; /* the two labels */
    vi face;          /* see sc_crossing */
    vf u;             /* how far along the way through the cell: 0 to 1 */
    vf normal[3];     /* as of sc_cell_normal */
    /* lanes with a single crossing: the packed cell, and the difference of the two votes along the
     * way, see sc_bernstein */
    vi values[2], labels;
    vf coefficients[4];
    /* lanes whose cell may have several crossings: all of them */
    sc_cell cells[LANES];
    sc_crossing list[LANES][SC_CROSSINGS_MAX];
    int count[LANES], next[LANES]; /* of the list: how long it is, and which comes next */
    uint32_t listed;               /* those lanes, as bits */
} crossings;

/* The stretch of each ray that is being marched: see next_stretch(). Distances are in mm from the
 * ray's origin. */
typedef struct stretch {
    vf near, far;   /* where the ray enters and leaves the box of the march */
    vf end;         /* where it ends */
    vf rounding[3]; /* bound on the rounding error of a position on it, in grid coordinates */
    vi active;      /* the clip sets kept on it, as bits */
    float last_end[LANES]; /* where the stretch before it ended */
    bool is_only;          /* no ray has another stretch */
} stretch;

/* The way through the present cell of each ray: from position a to b, leaving at distance t1
 * through axis1. */
typedef struct chord {
    vf a[3], b[3], t1;
    vi axis1;
} chord;

/* LANES rays that are marched side by side. init_packet sets what lasts, start_packet the rays.
 * Distances are in mm from the ray's origin, positions in grid coordinates. */
typedef struct packet {
    const sc_march *m;
    const sc_ray *rays;
    sc_way *ways; /* NULL: rays go to their ends at once */
    vf limit_mm;  /* with ways: rays stop before what is not nearer to the eye than this */
    v_radiance light;
    v_ray ray;
    vm parallel[3]; /* the coordinate does not change: the ray never crosses a grid plane of the
                       axis */
    stretch stretch;
    /* the walk from cell to cell; see cursor of smooth_ray.h */
    vi q[3], axis;
    vf t;
    v_place place; /* what the skip method remembers of it */
    chord chord;
    vm alive;     /* rays that are not finished */
    vm walking;   /* on the way to a marked cell */
    vm at_marked; /* in a marked cell that has yet to be searched for crossings */
    vm found;     /* in a cell with a crossing */
    crossings x;
    sc_march_counters counters;
} packet;

enum {
    PACKETS = 2,                 /* packets that a loop works on in turn */
    ENOUGH_LANES = LANES * 3 / 8 /* so many in marked cells are worth the search for crossings */
};

/* Distance at which the rays meet grid plane number @p plane of axis @p i; see plane_mm(). */
static inline vf v_plane_mm(const packet *p, int i, vi plane)
{
    return (f_of(plane) - p->ray.origin[i]) * p->ray.inverse[i];
}

/* Distance at which the rays leave their present cells along axis @p i. */
static inline vf v_exit_mm(const packet *p, int i)
{
    return v_plane_mm(p, i, i_pick(p->ray.forward[i], p->q[i] + 1, p->q[i]));
}

/* The nearest of three planes, one of each axis, at the distances @p mm: its distance to @p t
 * and its axis to @p axis; of equally near ones that of the lowest axis. */
static inline void nearest_plane(const vf mm[3], vf *t, vi *axis)
{
    const vm one = f_below(mm[1], mm[0]);
    const vf lower = f_pick(one, mm[1], mm[0]);
    const vm two = f_below(mm[2], lower);

    *t = f_pick(two, mm[2], lower);
    *axis = i_pick(two, i_set(2), i_pick(one, i_set(1), i_set(0)));
}

/* Where in lanes of @p on the planes beside a cell are out of order with the ray, move p->q one
 * cell ahead or back along axis @p i; see the loops of locate_cell(). @return whether any lane
 * did, so that it has to be called again. */
static inline bool correct_cell(packet *p, int i, vm on)
{
    const vm earlier = i_below(i_set(i), p->axis), later = i_below(p->axis, i_set(i));
    const vi step = i_pick(p->ray.forward[i], i_set(1), i_set(-1));
    const vf out = v_exit_mm(p, i);
    const vf in = v_plane_mm(p, i, i_pick(p->ray.forward[i], p->q[i], p->q[i] + 1));
    const vm ahead = m_and(on, m_or(f_below(out, p->t), m_and(f_equal(out, p->t), earlier)));
    const vm behind = m_and(on, m_or(f_below(p->t, in), m_and(f_equal(in, p->t), later)));

    if (!m_any(m_or(ahead, behind)))
        return false;
    p->q[i] = i_pick(ahead, p->q[i] + step, i_pick(behind, p->q[i] - step, p->q[i]));
    return true;
}

/* Set p->q in the lanes of @p on to the cells at distance p->t, except along p->axis, where the
 * caller has set it; see locate_cell(). Only where a position is so close to a grid plane that
 * rounding could have moved it across, the distances of the planes are compared. */
static inline void v_locate_cells(packet *p, vm on)
{
    for (int i = 0; i < 3; i++) {
        const vm here = m_without(on, i_equal(p->axis, i_set(i)));
        const vf at = p->ray.origin[i] + p->ray.direction[i] * p->t;
        const vi cell = i_floor(at);
        const vf within = at - f_of(cell);
        const vm close = m_or(f_below(within, p->stretch.rounding[i]),
                              f_below(1 - p->stretch.rounding[i], within));

        p->q[i] = i_pick(here, cell, p->q[i]);
        if (m_any(m_and(here, close))) {
            while (correct_cell(p, i, m_without(here, p->parallel[i])))
                continue;
        }
    }
}

/* Index of the present cell's brick in the arrays with a frame. */
static inline vi v_brick(const packet *p)
{
    return v_framed_index(p->m->marked.row, p->m->marked.layer, p->q[0], p->q[1], p->q[2]);
}

/* Step out of a box of cells around the present ones of the lanes of @p on: see v_empty for its
 * @p mask, @p ahead and @p back. Sets p->q, p->t and p->axis. @param leaps the lanes of @p on whose
 * box has more than one cell. */
static inline void leave_box(packet *p, vi mask, vi ahead, vi back, vm leaps, vm on)
{
    vf mm[3], t;
    vi plane[3], axis;

    for (int i = 0; i < 3; i++) {
        plane[i] = (p->q[i] & mask) + i_pick(p->ray.forward[i], ahead, back);
        mm[i] = v_plane_mm(p, i, plane[i]);
    }
    nearest_plane(mm, &t, &axis);
    p->t = f_pick(on, t, p->t);
    p->axis = i_pick(on, axis, p->axis);
    for (int i = 0; i < 3; i++)
        p->q[i] = i_pick(m_and(on, i_equal(axis, i_set(i))),
                         i_pick(p->ray.forward[i], plane[i], plane[i] - 1), p->q[i]);
    if (m_any(leaps))
        v_locate_cells(p, leaps);
}

/* Step out of the present cells of the lanes of @p on. */
static inline void leave_cell(packet *p, vm on)
{
    leave_box(p, i_set(-1), i_set(1), i_set(0), m_none(), on);
}

/* Set p->t and p->axis of the lanes of @p on to where the ray has entered the cell p->q; it has not
 * begun there. */
static inline void find_entry(packet *p, vm on)
{
    vf t = f_set(-SC_NEVER_MM);
    vi axis = i_set(-1);

    for (int i = 0; i < 3; i++) {
        const vf mm = v_plane_mm(p, i, i_pick(p->ray.forward[i], p->q[i], p->q[i] + 1));
        const vm later = m_without(f_at_most(t, mm), p->parallel[i]);

        t = f_pick(later, mm, t);
        axis = i_pick(later, i_set(i), axis);
    }
    p->t = f_pick(on, t, p->t);
    p->axis = i_pick(on, axis, p->axis);
}

/* Step out of the present cells of the lanes of @p on, and in those of @p leaps as far as it is
 * certain that all cells on the way are less than @p far away by the city-block distance. That
 * distance grows by 1 with every grid plane that the ray crosses: at the distance at which the sum
 * of the ways along the three axes, counted from where the ray would have entered the cell, is @p
 * far, it has crossed that many at most. Sets p->q, p->t and p->axis. */
static inline void leave_ball(packet *p, vi far, vm leaps, vm on)
{
    const vi from[3] = {p->q[0], p->q[1], p->q[2]};
    vi next[3], next_axis, apart = i_set(0);
    vf way = f_of(far), reach, next_t;
    vm beyond;

    for (int i = 0; i < 3; i++) {
        const vf at = p->ray.origin[i] + p->ray.direction[i] * p->t - f_of(p->q[i]);

        way -= f_pick(p->parallel[i], f_set(0), f_pick(p->ray.forward[i], at, 1 - at));
    }
    reach = p->t + way * p->ray.mm_per_city_block;
    reach = f_pick(f_below(p->stretch.end, reach), p->stretch.end, reach);
    leave_cell(p, on);
    leaps = m_and(leaps, f_below(p->t, reach));
    if (!m_any(leaps))
        return;
    for (int i = 0; i < 3; i++)
        next[i] = p->q[i];
    next_t = p->t;
    next_axis = p->axis;
    p->t = f_pick(leaps, reach, p->t);
    p->axis = i_pick(leaps, i_set(-1), p->axis);
    v_locate_cells(p, leaps);
    find_entry(p, leaps);
    for (int i = 0; i < 3; i++)
        apart += i_pick(i_below(p->q[i], from[i]), from[i] - p->q[i], p->q[i] - from[i]);
    beyond = m_and(leaps, i_below(far, apart));
    if (!m_any(beyond))
        return;
    /* Rounding has led too far: a step of one cell. */
    for (int i = 0; i < 3; i++)
        p->q[i] = i_pick(beyond, next[i], p->q[i]);
    p->t = f_pick(beyond, next_t, p->t);
    p->axis = i_pick(beyond, next_axis, p->axis);
}

/* One step of the lanes that are walking. Those in a marked cell stop walking and join
 * p->at_marked; those at the end of their stretch stop walking. Counts cell visits and steps across
 * empty space. */
static inline void step(packet *p)
{
    const vm seek = m_and(p->walking, f_below(p->t, p->stretch.end));
    const v_empty e = v_look(p->m, p->q, &p->place, seek);

    p->counters.cell_visits += m_count(m_without(seek, e.leaps));
    p->counters.brick_steps += m_count(e.leaps);
    p->at_marked = m_or(p->at_marked, e.marked);
    p->walking = m_without(seek, e.marked);
    if (!m_any(p->walking))
        return;
    if (EMPTY_IS_BALL)
        leave_ball(p, e.ahead, e.leaps, p->walking);
    else
        leave_box(p, e.mask, e.ahead, e.back, e.leaps, p->walking);
}

/* Is any lane walking, and are fewer than ENOUGH_LANES in marked cells? */
static inline bool walk_on(const packet *p)
{
    return m_any(p->walking) && m_count(p->at_marked) < ENOUGH_LANES;
}

/* Walk until enough lanes are in marked cells, or no lane is walking. Two packets take turns: while
 * one waits for memory or for the results of its arithmetic, the processor works on the other. */
static void walk(packet p[PACKETS])
{
    bool first = walk_on(&p[0]), second = walk_on(&p[1]);

    while (first || second) {
        if (first)
            step(&p[0]);
        if (second)
            step(&p[1]);
        first = walk_on(&p[0]);
        second = walk_on(&p[1]);
    }
}

#endif
