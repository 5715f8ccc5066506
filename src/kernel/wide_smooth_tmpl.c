/* SPDX-License-Identifier: BSD-3-Clause */
/* Template: the smooth surface model, one ray per SIMD lane, with steps across empty space.
 * Compiled once per skip method (MARCH_EMPTY, its file), variant and label width (MARCH_LABEL)
 * under the name MARCH_NAME.
 *
 * Every lane does to its ray what march_smooth_tmpl.c does, with the same operations. Lanes wait
 * for each other before the costly steps, so that these are done for as many of them as possible.
 * A step across empty space ends in the very cell, and at the very distance, that single steps
 * would have led to. */
#include "lanes_cell.h"
#include "lanes_shade.h"
#include "smooth_ray.h"
#include "variants.h"

#include MARCH_EMPTY

/* The next crossing of each lane in its cell, and the further ones of the lanes that have
 * several. It persists between cells: only the lanes searched are overwritten. */
typedef struct crossings {
    vi left, entered; /* the two labels */
    vi face;          /* see sc_crossing */
    vf u;             /* how far along the way through the cell: 0 to 1 */
    /* lanes with a single crossing: the difference of the two votes along the way, see sc_bernstein
     */
    vf coefficients[4];
    /* lanes whose cell may have several crossings: all of them */
    sc_crossing list[LANES][SC_CROSSINGS_MAX];
    int count[LANES], next[LANES]; /* of the list: how long it is, and which comes next */
    uint32_t listed;               /* those lanes, as bits */
} crossings;

/* LANES rays that are marched side by side. init_packet sets what lasts, start_packet the rays.
 * Distances are in mm from the ray's origin, positions in grid coordinates. */
typedef struct packet {
    const sc_march *m;
    const sc_ray *rays;
    v_radiance light;
    /* the rays */
    vf origin[3], direction[3], inverse[3], eye[3], base_mm; /* eye: sc_ray.toward_eye */
    vm forward[3];        /* the coordinate grows along the ray, or does not change */
    vm parallel[3];       /* it does not change: the ray never crosses a grid plane of this axis */
    vf near, far;         /* distances at which the ray enters and leaves the box of the march */
    vf mm_per_city_block; /* way by which the city-block distance from its begin grows by 1 */
    /* the stretch of the ray that is being marched: see next_stretch() */
    vf end;         /* where it ends */
    vf rounding[3]; /* bound on the rounding error of a position on it, in grid coordinates */
    vi active;      /* the clip sets kept on it, as bits */
    float last_end[LANES]; /* where the stretch before it ended */
    bool one_stretch;      /* no ray has another stretch */
    /* the walk from cell to cell; see cursor of smooth_ray.h */
    vi q[3], axis;
    vf t;
    v_place place; /* what the skip method remembers of it */
    /* the way through the present cell: from position a to b, leaving at distance t1 through axis1
     */
    v_cell cell;
    vf a[3], b[3], t1;
    vi axis1;
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
    return (f_of(plane) - p->origin[i]) * p->inverse[i];
}

/* Distance at which the rays leave their present cells along axis @p i. */
static inline vf v_exit_mm(const packet *p, int i)
{
    return v_plane_mm(p, i, i_pick(p->forward[i], p->q[i] + 1, p->q[i]));
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
    const vi step = i_pick(p->forward[i], i_set(1), i_set(-1));
    const vf out = v_exit_mm(p, i);
    const vf in = v_plane_mm(p, i, i_pick(p->forward[i], p->q[i], p->q[i] + 1));
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
        const vf at = p->origin[i] + p->direction[i] * p->t;
        const vi cell = i_floor(at);
        const vf within = at - f_of(cell);
        const vm close = m_or(f_below(within, p->rounding[i]), f_below(1 - p->rounding[i], within));

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
    return v_framed_index(p->m->visible_row, p->m->visible_layer, p->q[0], p->q[1], p->q[2]);
}

/* Step out of a box of cells around the present ones of the lanes of @p on: see v_empty for its
 * @p mask, @p ahead and @p back. Sets p->q, p->t and p->axis. @param leaps the lanes of @p on whose
 * box has more than one cell. */
static inline void leave_box(packet *p, vi mask, vi ahead, vi back, vm leaps, vm on)
{
    vf mm[3], t;
    vi plane[3], axis;

    for (int i = 0; i < 3; i++) {
        plane[i] = (p->q[i] & mask) + i_pick(p->forward[i], ahead, back);
        mm[i] = v_plane_mm(p, i, plane[i]);
    }
    nearest_plane(mm, &t, &axis);
    p->t = f_pick(on, t, p->t);
    p->axis = i_pick(on, axis, p->axis);
    for (int i = 0; i < 3; i++)
        p->q[i] = i_pick(m_and(on, i_equal(axis, i_set(i))),
                         i_pick(p->forward[i], plane[i], plane[i] - 1), p->q[i]);
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
        const vf mm = v_plane_mm(p, i, i_pick(p->forward[i], p->q[i], p->q[i] + 1));
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
        const vf at = p->origin[i] + p->direction[i] * p->t - f_of(p->q[i]);

        way -= f_pick(p->parallel[i], f_set(0), f_pick(p->forward[i], at, 1 - at));
    }
    reach = p->t + way * p->mm_per_city_block;
    reach = f_pick(f_below(p->end, reach), p->end, reach);
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
    const vm seek = m_and(p->walking, f_below(p->t, p->end));
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

/* Positions within the present cells at distance @p t, to @p out; see local_at(). */
static inline void v_local_at(const packet *p, vf t, vi axis, bool leaving, vf out[3])
{
    for (int i = 0; i < 3; i++) {
        const vf face = f_pick(p->forward[i], f_set(leaving), f_set(!leaving));

        out[i] = f_pick(i_equal(axis, i_set(i)), face,
                        f_clamp01(p->origin[i] + p->direction[i] * t - f_of(p->q[i])));
    }
}

/* List all crossings of one lane's cell, which v_cell_read has read, in x->list, by cell.h.
 * @return whether there are any. */
static bool list_crossings(const packet *p, crossings *x, int lane)
{
    float a[3], b[3];
    sc_cell cell;

    for (int i = 0; i < 3; i++) {
        a[i] = p->a[i][lane];
        b[i] = p->b[i][lane];
    }
    v_cell_get_lane(p->m->volume, &p->cell, lane, &cell);
    x->count[lane] = sc_cell_crossings(&cell, a, b, x->list[lane]);
    x->next[lane] = 0;
    return x->count[lane] > 0;
}

/* Unpack what sc_cells holds of the present cells, which must be marked, to @p out: at each
 * corner the vote of the lowest label minus that of the other one. @return the lanes of @p on
 * whose cells hold more than two labels, for which @p out is meaningless. */
static inline vm v_cell_differences(const packet *p, vm on, vf out[SC_CORNERS])
{
    enum { CELL_BYTES = sizeof *p->m->cells, WORD_BYTES = CELL_BYTES / 2 };
    vi half, words[2];
    const vi index = v_packed_index(p->m->visible, p->m->cell_start, v_brick(p),
                                    v_half_bit(p->q[0], p->q[1], p->q[2]), p->q[2], on, &half);

    words[0] = i_gather(p->m->cells, index * CELL_BYTES, on);
    words[1] = i_gather(p->m->cells, index * CELL_BYTES + WORD_BYTES, on);
    for (int i = 0; i < SC_CORNERS; i++)
        out[i] = f_of(v_signed_field(words[sc_cell_field_word(i)], sc_cell_field_shift(i),
                                     SC_CELL_FIELD_BITS));
    return m_and(on, i_below(words[1], i_set(0))); /* SC_CELL_MANY is the sign of the upper word */
}

/* Read the labels and vertex records of the present cells into p->cell, which the lanes share:
 * lanes outside of @p on lose theirs. */
static inline void v_cell_read(packet *p, vm on)
{
    for (int i = 0; i < 3; i++)
        p->cell.q[i] = p->q[i];
    v_cell_labels(p->m->volume, sizeof(MARCH_LABEL), &p->cell, on);
    v_cell_fill(p->m->volume, &p->cell, on);
}

/* Read the cells of the lanes @p on into p->cell, which other lanes lose, and set list, count and
 * next of p->x to their crossings; p->x.listed is left to the caller. @return the lanes that have
 * any, as bits. */
static uint32_t list_cells(packet *p, vm on)
{
    uint32_t found = 0;

    v_cell_read(p, on);
    for (uint32_t left = m_bits(on); left; left &= left - 1) {
        const int lane = __builtin_ctz(left);

        if (list_crossings(p, &p->x, lane))
            found |= 1u << lane;
    }
    return found;
}

/* Search the marked cells reached for crossings: sets a, b, t1 and axis1 (those of all lanes),
 * and for the lanes of p->at_marked coefficients or list of p->x. @return the lanes that have a
 * crossing. */
static vm find_crossings(packet *p)
{
    crossings *x = &p->x;
    const vm on = p->at_marked;
    vf mm[3], difference[SC_CORNERS], coefficients[4];
    vi variations;
    vm once, listed;
    uint32_t found;

    for (int i = 0; i < 3; i++)
        mm[i] = v_exit_mm(p, i);
    nearest_plane(mm, &p->t1, &p->axis1);
    p->axis1 = i_pick(f_below(p->t1, p->end), p->axis1, i_set(-1));
    p->t1 = f_pick(f_below(p->t1, p->end), p->t1, p->end);
    v_local_at(p, p->t, p->axis, false, p->a);
    v_local_at(p, p->t1, p->axis1, true, p->b);
    listed = v_cell_differences(p, on, difference);
    v_bernstein(difference, p->a, p->b, coefficients);
    variations = v_variations(coefficients);
    /* If the signs of two labels' coefficients change once, there is exactly one crossing, which
     * v_root will find. Cells with more changes, or more labels, need a list. */
    listed = m_or(listed, m_and(on, i_below(i_set(1), variations)));
    once = m_without(m_and(on, i_equal(variations, i_set(1))), listed);
    for (int i = 0; i < 4; i++)
        x->coefficients[i] = f_pick(once, coefficients[i], x->coefficients[i]);
    found = m_bits(once);
    x->listed &= ~m_bits(on);
    if (m_any(listed)) {
        const uint32_t nonempty = list_cells(p, listed);

        x->listed |= nonempty;
        found |= nonempty;
    }
    return m_of_bits(found);
}

/* Fetch the next crossing of the lanes of @p on that have a list, to x->left, x->entered and
 * x->u. @return those that had one left; others keep the last. */
static vm next_crossings(crossings *x, vm on)
{
    uint32_t have = 0;

    for (uint32_t left = m_bits(on) & x->listed; left; left &= left - 1) {
        const int lane = __builtin_ctz(left);
        const int n = x->next[lane]++;

        if (n >= x->count[lane])
            continue;
        x->left[lane] = (int32_t)x->list[lane][n].left;
        x->entered[lane] = (int32_t)x->list[lane][n].entered;
        x->u[lane] = x->list[lane][n].u;
        x->face[lane] = x->list[lane][n].face;
        have |= 1u << lane;
    }
    return m_of_bits(have);
}

/* Opacity of the surfaces of @p label at the points @p at of their cells; see
 * alpha_by_thickness() of march_smooth_tmpl.c. */
static vf v_alpha_by_thickness(const packet *p, vi label, const vf at[3], vm on)
{
    const sc_march *m = p->m;
    const vf plain = v_tissue_floats(m, label, offsetof(sc_march_tissue, boundary_alpha), on);
    vf sum = {0}, weights = {0};
    vm measured;

    if (!m->volume->thickness)
        return plain;
    measured = v_by_thickness(v_tissue_bytes(m, label, on), on);
    if (!m_any(measured))
        return plain;
    for (int i = 0; i < SC_CORNERS; i++) {
        const vf weight = v_corner_share(i, at);
        const vm own = m_and(measured, i_equal(p->cell.labels[i], label));
        const vi code = i_gather(m->volume->thickness, p->cell.record_index[i], own) & 255;
        const vf alpha = f_gather(m->thickness_alpha, code * 4, own);

        weights = f_pick(own, weights + weight, weights);
        sum = f_pick(own, sum + weight * alpha, sum);
    }
    return f_pick(m_and(measured, f_below(f_set(0), weights)), sum / weights, plain);
}

/* The share of the surfaces of @p label that is left at the points @p at of their cells; see
 * share_left() of march_smooth_tmpl.c. */
static vf v_share_left(const packet *p, vi label, const vf at[3], vm on)
{
    vi missing[SC_CORNERS];
    vf sum = {0}, weights = {0};
    vm any = m_none();

    for (int i = 0; i < SC_CORNERS; i++) {
        const vi code = p->cell.records[i] >> SC_RECORD_LENGTH_SHIFT & SC_RECORD_LENGTH_MASK;

        missing[i] = i_pick(i_below(i_set(SC_RECORD_SHORTEST), code),
                            SC_RECORD_LENGTH_MASK + 1 - code, i_set(0));
        any = m_or(any, m_and(i_equal(p->cell.labels[i], label),
                              i_below(i_set(SC_RECORD_SHORTEST), code)));
    }
    any = m_and(any, on);
    if (!m_any(any))
        return f_set(1);
    for (int i = 0; i < SC_CORNERS; i++) {
        const vm own = i_equal(p->cell.labels[i], label);
        const vf weight = v_corner_share(i, at);

        weights = f_pick(own, weights + weight, weights);
        sum = f_pick(own, sum + weight * f_of(missing[i]), sum);
    }
    return f_pick(m_and(any, f_below(f_set(0), weights)), 1 - sum / (weights * SC_RECORD_FADES),
                  f_set(1));
}

/* Add one side of a crossing, the surface of @p label, to the light of the lanes of @p on. The
 * spot has been completed by v_light_spot. */
static void v_add_surface(packet *p, vi label, const vf at[3], const v_spot *spot, vm on)
{
    vf alpha, rgb[3];

    if (!m_any(on))
        return;
    alpha = v_share_left(p, label, at, on) * v_edge_alpha(&p->m->light,
                                                          v_alpha_by_thickness(p, label, at, on),
                                                          f_dot(spot->normal, spot->eye));
    v_light(p->m, label, spot, on, rgb);
    v_remember_surface(&p->light, label, alpha, spot, on);
    v_blend(&p->light, rgb, alpha, on);
    p->counters.contributions += m_count(on);
}

/* Lanes of @p on whose label is shown there and not cut away. */
static inline vm v_contributes(const packet *p, vi label, vm on)
{
    const vi bytes = v_tissue_bytes(p->m, label, on);

    return v_in_kept_set(bytes, p->active, v_shows(bytes, SC_SHOW_BOUNDARY, on));
}

/* Rays that are not yet opaque, of all lanes. */
static inline vm v_sees_on(const packet *p)
{
    return f_at_most(f_set(SC_OPAQUE), p->light.transmittance);
}

/* Set the normals of the lanes of @p on whose crossings are faces of the volume. */
static void set_face_normals(const packet *p, const crossings *x, vm on, vf normal[3])
{
    for (uint32_t left = m_bits(m_without(on, i_equal(x->face, i_set(0)))); left;
         left &= left - 1) {
        const int lane = __builtin_ctz(left);
        float n[3];

        sc_face_normal(p->m, x->face[lane] - 1, p->rays[lane].toward_eye, n);
        for (int i = 0; i < 3; i++)
            normal[i][lane] = n[i];
    }
}

/* Add the present crossing of x (left, entered, u) to the light of each lane of @p on, as far as
 * its labels contribute. p->cell must have been read. */
static void add_crossings(packet *p, const crossings *x, vm on)
{
    const vm left = v_contributes(p, x->left, on), entered = v_contributes(p, x->entered, on);
    const vf t = p->t + (p->t1 - p->t) * x->u;
    const vm either = m_or(left, entered);
    v_spot spot;
    vf at[3], length;

    if (!m_any(either))
        return;
    spot.depth_mm = p->base_mm + t;
    for (int i = 0; i < 3; i++) {
        spot.eye[i] = p->eye[i];
        at[i] = f_lerp(p->a[i], p->b[i], x->u);
    }
    v_cell_normal(&p->cell, x->entered, x->left, at, spot.normal);
    length = f_length(spot.normal);
    for (int i = 0; i < 3; i++) {
        spot.normal[i] = f_pick(f_below(f_set(1e-3f), length), spot.normal[i] / length, p->eye[i]);
        spot.point[i] = p->origin[i] + p->direction[i] * t;
    }
    v_face_eye(p->eye, spot.normal);
    set_face_normals(p, x, either, spot.normal);
    v_light_spot(p->m, &spot, either);
    v_add_surface(p, x->left, at, &spot, left);
    v_add_surface(p, x->entered, at, &spot, m_and(entered, v_sees_on(p)));
}

/* Set p->rounding and p->q: the cells in which the stretches of the lanes of @p on begin. t, end
 * and axis (-1) of these lanes have been set. */
static void find_first_cells(packet *p, vm on)
{
    /* 2^-20 is eight times the relative rounding error of a float. */
    for (int i = 0; i < 3; i++)
        p->rounding[i] = (f_abs(p->origin[i]) + f_abs(p->direction[i]) * p->end) * 0x1p-20f;
    v_locate_cells(p, on);
}

/* Begin the next stretch of the lanes of @p on, with the cut faces at its beginning: sets t,
 * end, active, axis, last_end and q. Rays that have none left, or are opaque, leave p->alive. */
static void begin_stretches(packet *p, vm on)
{
    uint32_t begun = 0;

    for (uint32_t left = m_bits(on); left; left &= left - 1) {
        const int lane = __builtin_ctz(left);
        cursor c = {.m = p->m, .ray = &p->rays[lane]};
        float begin, end;
        uint32_t active;

        if (p->light.transmittance[lane] < SC_OPAQUE ||
            !next_stretch(c.ray, p->last_end[lane], &begin, &end, &active))
            continue;
        p->last_end[lane] = end;
        begun |= 1u << lane;
        if (p->m->caps && p->m->plane_count) {
            c.light = v_radiance_get_lane(&p->light, lane);
            start_walk(&c);
            add_caps(&c, begin);
            v_radiance_set_lane(&p->light, lane, &c.light);
            p->counters.contributions += c.contributions;
        }
        begin = begin > p->near[lane] ? begin : p->near[lane];
        end = end < p->far[lane] ? end : p->far[lane];
        if (!(begin < end) || p->m->only_caps || p->light.transmittance[lane] < SC_OPAQUE)
            begin = end = 0; /* there is nothing to walk through */
        p->t[lane] = begin;
        p->end[lane] = end;
        p->active[lane] = (int32_t)active;
        p->axis[lane] = -1;
    }
    p->alive = m_or(m_without(p->alive, on), m_of_bits(begun));
    find_first_cells(p, m_of_bits(begun));
}

/* Set the march of a packet and clear its counters and crossings, whose unused lanes take part
 * in the arithmetic, too. */
static void init_packet(packet *p, const sc_march *march)
{
    p->m = march;
    p->counters = (sc_march_counters){0};
    p->x.listed = 0;
    for (int i = 0; i < 4; i++)
        p->x.coefficients[i] = f_set(0);
    p->x.u = f_set(0);
    p->x.left = p->x.entered = p->x.face = i_set(0);
}

/* Begin all rays at once if each has a single stretch, which is nearly always so without clip
 * planes. @return whether that was all; if false, begin_stretches() has to begin them, because they
 * have several stretches, or may have cut faces. */
static bool begin_at_once(packet *p, int count, vm all)
{
    for (int lane = 0; lane < count; lane++) {
        if (p->rays[lane].clip_sets != 1 || p->rays[lane].part_count[0] != 1)
            return false;
    }
    p->t = v_ray_floats(p->rays, offsetof(sc_ray, parts[0][0].begin_mm), all);
    p->end = v_ray_floats(p->rays, offsetof(sc_ray, parts[0][0].end_mm), all);
    p->t = f_pick(f_below(p->t, p->near), p->near, p->t);
    p->end = f_pick(f_below(p->far, p->end), p->far, p->end);
    p->active = i_set(1);
    p->alive = m_and(all, f_below(p->t, p->end));
    find_first_cells(p, p->alive);
    return !p->m->plane_count;
}

/* Load the rays [0, @p count) into the packet, at most LANES, and begin their first stretches;
 * lanes beyond are not alive. @p rays stay borrowed until the next call. init_packet has been
 * called before. */
static void start_packet(packet *p, const sc_ray *rays, int count)
{
    vm all;

    p->rays = rays;
    p->light = v_no_light();
    p->alive = m_none();
    p->place = v_first_place();
    p->one_stretch = true;
    if (!count)
        return;
    all = m_of_bits((1u << count) - 1);
    for (int i = 0; i < 3; i++) {
        const size_t at = sizeof(float) * (size_t)i;

        p->origin[i] = v_ray_floats(rays, offsetof(sc_ray, origin) + at, all);
        p->direction[i] = v_ray_floats(rays, offsetof(sc_ray, direction) + at, all);
        p->eye[i] = v_ray_floats(rays, offsetof(sc_ray, toward_eye) + at, all);
    }
    p->base_mm = v_ray_floats(rays, offsetof(sc_ray, base_mm), all);
    for (int i = 0; i < 3; i++) {
        const vf d = p->direction[i];
        const vm back = f_below(d, f_set(0));

        p->parallel[i] = m_and(f_below(f_set(-SC_PARALLEL), d), f_below(d, f_set(SC_PARALLEL)));
        p->direction[i] = f_pick(p->parallel[i], f_set(0), d);
        p->inverse[i] = f_pick(p->parallel[i], f_set(SC_NEVER_MM), 1 / d);
        p->forward[i] = m_without(f_equal(d, d), m_without(back, p->parallel[i]));
        p->q[i] = p->cell.q[i] = i_set(0);
    }
    p->mm_per_city_block =
        1 / (f_abs(p->direction[0]) + f_abs(p->direction[1]) + f_abs(p->direction[2]));
    v_clip_to_box(p->m, p->origin, p->inverse, 0, &p->near, &p->far);
    p->t = p->end = f_set(0);
    p->active = i_set(0);
    p->axis = i_set(-1);
    p->one_stretch = begin_at_once(p, count, all);
    if (p->one_stretch)
        return;
    for (int lane = 0; lane < LANES; lane++)
        p->last_end[lane] = -HUGE_VALF;
    begin_stretches(p, all);
}

/* Walk until every living lane of the packets has found a cell with a crossing (p->found), or
 * reached the end of its stretch. */
static void find_next_cells(packet p[PACKETS])
{
    bool again = true;

    for (int k = 0; k < PACKETS; k++) {
        p[k].walking = p[k].alive;
        p[k].found = m_none();
    }
    while (again) {
        again = false;
        for (int k = 0; k < PACKETS; k++)
            p[k].at_marked = m_none();
        walk(p);
        for (int k = 0; k < PACKETS; k++) {
            const vm crossed = m_any(p[k].at_marked) ? find_crossings(&p[k]) : m_none();

            const vm passed = m_without(p[k].at_marked, crossed);

            p[k].found = m_or(p[k].found, crossed);
            p[k].walking = m_or(p[k].walking, passed);
            if (m_any(passed))
                leave_cell(&p[k], passed);
            again = again || m_any(p[k].walking);
        }
    }
}

/* Add all crossings in the cells of p->found, which find_crossings has searched, and step out of
 * these cells. */
static void add_cell_crossings(packet *p)
{
    crossings *x = &p->x;
    const vm single = m_without(p->found, m_of_bits(x->listed));
    const vm downward = f_below(x->coefficients[0], f_set(0));
    vi low, high;

    v_cell_read(p, p->found);
    v_label_range(&p->cell, &low, &high);
    x->left = i_pick(downward, high, low);
    x->entered = i_pick(downward, low, high);
    x->u = v_root(x->coefficients, single);
    x->face = i_set(0);
    for (vm on = m_or(single, next_crossings(x, p->found)); m_any(on);
         on = m_and(next_crossings(x, p->found), v_sees_on(p)))
        add_crossings(p, x, on);
    leave_cell(p, p->found);
}

/* Add the crossings found, and begin the next stretch in lanes that are at the end of one. */
static void add_found(packet *p)
{
    vm over;

    if (m_any(p->found))
        add_cell_crossings(p);
    over = m_without(p->alive, m_and(v_sees_on(p), f_below(p->t, p->end)));
    if (p->one_stretch)
        p->alive = m_without(p->alive, over);
    else
        begin_stretches(p, over);
}

/* Lanes that a packet uses when @p left rays are left: LANES at most. */
static int lanes_used(size_t left)
{
    return left < LANES ? (int)left : LANES;
}

/* The kernel: see sc_march_fn. Rays are marched in PACKETS * LANES at a time. */
void MARCH_NAME(const sc_march *march, const sc_ray *rays, size_t count, sc_radiance *out,
                sc_march_counters *counters)
{
    packet p[PACKETS];

    for (int k = 0; k < PACKETS; k++)
        init_packet(&p[k], march);
    for (size_t i = 0; i < count; i += PACKETS * LANES) {
        const int lanes[PACKETS] = {lanes_used(count - i),
                                    count - i > LANES ? lanes_used(count - i - LANES) : 0};

        start_packet(&p[0], rays + i, lanes[0]);
        start_packet(&p[1], rays + i + LANES, lanes[1]);
        while (m_any(p[0].alive) || m_any(p[1].alive)) {
            find_next_cells(p);
            add_found(&p[0]);
            add_found(&p[1]);
        }
        for (int k = 0; k < PACKETS; k++) {
            for (int lane = 0; lane < lanes[k]; lane++)
                out[i + (size_t)(k * LANES + lane)] = v_radiance_get_lane(&p[k].light, lane);
        }
    }
    counters->rays += count;
    for (int k = 0; k < PACKETS; k++)
        sc_add_counters(counters, &p[k].counters);
}
