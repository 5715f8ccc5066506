/* SPDX-License-Identifier: BSD-3-Clause */
/* Template: the smooth surface model, MARCH_LANES rays side by side, leaping over empty bricks.
 * Compiled once per instruction set and label width (MARCH_LABEL) under the name MARCH_NAME.
 *
 * Every lane does what march_smooth_tmpl.c does with its ray, with the same operations; lanes wait
 * for each other at the costly places, so that those are entered with as many as possible. The
 * distance of a brick to the nearest one with something in it says how far a leap may go: it ends
 * in the very cell, at the very distance, that single steps would have led to. */
#include "lanes_cell.h"
#include "lanes_shade.h"
#include "smooth_ray.h"
#include "variants.h"

/* A change of owner per lane, in the cells at hand. */
typedef struct crossings {
    vi left, entered;
    vf u;
    /* of lanes that are not listed: the difference of the two votes on the way, see sc_bernstein */
    vf coefficients[4];
    /* of lanes whose cells need a list: all of them */
    sc_crossing list[LANES][SC_CROSSINGS_MAX];
    int count[LANES], next[LANES];
    uint32_t listed; /* lanes, as bits */
} crossings;

typedef struct packet {
    const sc_march *m;
    const sc_ray *rays;
    v_radiance light;
    /* the rays */
    vf origin[3], direction[3], inverse[3], eye[3], base_mm;
    vm forward[3], still[3];
    /* the stretch in work */
    vf end;
    vf near, far;       /* where the box of the march begins and ends */
    vf doubt[3];        /* how far rounding may move a position, generously, in voxels */
    vi active;          /* clip groups, as bits */
    float ended[LANES]; /* where the last one ended */
    bool together;      /* there is but this one */
    /* the walk */
    vi q[3], axis;
    vf t;
    /* the way through the cells at hand: from the places a to b, at t1 through axis1 */
    v_cell cell;
    vf a[3], b[3], t1;
    vi axis1;
    vm alive;
    vm walks, stands, found; /* to a marked cell, in one, in one with a change of owner */
    crossings x;
    sc_march_counters counters;
} packet;

/* Packets that take turns. */
enum { PACKETS = 2, ENOUGH = LANES * 3 / 8 };

static inline vf v_plane_mm(const packet *p, int i, vi plane)
{
    return (f_of(plane) - p->origin[i]) * p->inverse[i];
}

static inline vf v_exit_mm(const packet *p, int i)
{
    return v_plane_mm(p, i, i_pick(p->forward[i], p->q[i] + 1, p->q[i]));
}

/* The nearest of three planes; of equal ones the lowest axis. */
static inline void nearest(const vf mm[3], vf *t, vi *axis)
{
    const vm one = f_below(mm[1], mm[0]);
    const vf least = f_pick(one, mm[1], mm[0]);
    const vm two = f_below(mm[2], least);

    *t = f_pick(two, mm[2], least);
    *axis = i_pick(two, i_set(2), i_pick(one, i_set(1), i_set(0)));
}

/* See locate() of one ray: where the planes next to the cells are out of order, a step.
 * @return whether any lane took one. */
static inline bool correct(packet *p, int i, vm on)
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

/* Find the cells on the axes other than the one of the plane. Only where a position is so close to
 * a plane that rounding could have moved it across, the planes have to be asked. */
static inline void v_locate(packet *p, vm on)
{
    for (int i = 0; i < 3; i++) {
        const vm here = m_less(on, i_equal(p->axis, i_set(i)));
        const vf at = p->origin[i] + p->direction[i] * p->t;
        const vi cell = i_floor(at);
        const vf within = at - f_of(cell);
        const vm close = m_or(f_below(within, p->doubt[i]), f_below(1 - p->doubt[i], within));

        p->q[i] = i_pick(here, cell, p->q[i]);
        if (m_any(m_and(here, close))) {
            while (correct(p, i, m_less(here, p->still[i])))
                continue;
        }
    }
}

static inline vi v_brick(const packet *p)
{
    return v_framed_index(p->m->visible_row, p->m->visible_layer, p->q[0], p->q[1], p->q[2]);
}

/* Are the cells marked? */
static inline vm v_marked(const packet *p, vi brick, vm on)
{
    const vi half = v_half_mask(p->m->visible, brick, p->q[2], on);

    return v_bit_set(half, v_half_bit(p->q[0], p->q[1], p->q[2]), on);
}

/* One step: out of the cell, or where @p far > 0 out of the empty bricks around it. */
static inline void advance(packet *p, vi far, vm on)
{
    const vm leaps = m_and(on, i_below(i_set(0), far));
    const vi ahead = i_pick(leaps, far * SC_BRICK, i_set(1));
    const vi back = i_pick(leaps, (1 - far) * SC_BRICK, i_set(0));
    vf mm[3], t;
    vi plane[3], axis;

    for (int i = 0; i < 3; i++) {
        const vi base = i_pick(leaps, p->q[i] & ~SC_BRICK_MASK, p->q[i]);

        plane[i] = base + i_pick(p->forward[i], ahead, back);
        mm[i] = v_plane_mm(p, i, plane[i]);
    }
    nearest(mm, &t, &axis);
    p->t = f_pick(on, t, p->t);
    p->axis = i_pick(on, axis, p->axis);
    for (int i = 0; i < 3; i++)
        p->q[i] = i_pick(m_and(on, i_equal(axis, i_set(i))),
                         i_pick(p->forward[i], plane[i], plane[i] - 1), p->q[i]);
    if (m_any(leaps))
        v_locate(p, leaps);
}

/* A step of the lanes that walk, unless they stand in a marked cell or have reached their end. */
static inline void step(packet *p)
{
    const vm seek = m_and(p->walks, f_below(p->t, p->end));
    const vi brick = v_brick(p);
    const vi far = i_gather(p->m->distances, brick, seek) & 255;
    const vm here = m_and(seek, i_equal(far, i_set(0))), marked = v_marked(p, brick, seek);

    p->counters.samples += m_count(here);
    p->counters.leaps += m_count(m_less(seek, here));
    p->stands = m_or(p->stands, marked);
    p->walks = m_less(seek, marked);
    if (m_any(p->walks))
        advance(p, far, p->walks);
}

static inline bool walk_on(const packet *p)
{
    return m_any(p->walks) && m_count(p->stands) < ENOUGH;
}

/* Walk on until enough lanes stand in a marked cell, or all others have reached their end. What one
 * packet waits for in one step, memory and the latency of its arithmetic, the other has time to
 * do. */
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

/* Positions within the cells at distance @p t; see local_at(). */
static inline void v_local_at(const packet *p, vf t, vi axis, bool leaving, vf out[3])
{
    for (int i = 0; i < 3; i++) {
        const vf face = f_pick(p->forward[i], f_set(leaving), f_set(!leaving));

        out[i] = f_pick(i_equal(axis, i_set(i)), face,
                        f_clamp01(p->origin[i] + p->direction[i] * t - f_of(p->q[i])));
    }
}

/* All changes of owner of one cell, by cell.h. @return whether there are any. */
static bool list_crossings(const packet *p, crossings *x, int lane)
{
    float a[3], b[3];
    sc_cell cell;

    for (int i = 0; i < 3; i++) {
        a[i] = p->a[i][lane];
        b[i] = p->b[i][lane];
    }
    v_cell_lane(&p->cell, lane, &cell);
    x->count[lane] = sc_cell_crossings(&cell, a, b, x->list[lane]);
    x->next[lane] = 0;
    return x->count[lane] > 0;
}

/* What is packed of the cells stood in: the difference of the votes of the lowest label and of the
 * other at the corners. @return where there are more than two labels. */
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

static inline void v_cell_read(packet *p, vm on)
{
    for (int i = 0; i < 3; i++)
        p->cell.q[i] = p->q[i];
    v_cell_labels(p->m->volume, sizeof(MARCH_LABEL), &p->cell, on);
    v_cell_fill(p->m->volume, &p->cell, on);
}

/* Lists for the cells of @p on. @return those that have something on them. */
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

/* The changes of owner in the cells stood in. @return where there are any. */
static vm find_crossings(packet *p)
{
    crossings *x = &p->x;
    const vm on = p->stands;
    vf mm[3], difference[SC_CORNERS], coefficients[4];
    vi variations;
    vm once, listed;
    uint32_t found;

    for (int i = 0; i < 3; i++)
        mm[i] = v_exit_mm(p, i);
    nearest(mm, &p->t1, &p->axis1);
    p->axis1 = i_pick(f_below(p->t1, p->end), p->axis1, i_set(-1));
    p->t1 = f_pick(f_below(p->t1, p->end), p->t1, p->end);
    v_local_at(p, p->t, p->axis, false, p->a);
    v_local_at(p, p->t1, p->axis1, true, p->b);
    listed = v_cell_differences(p, on, difference);
    v_bernstein(difference, p->a, p->b, coefficients);
    variations = v_variations(coefficients);
    listed = m_or(listed, m_and(on, i_below(i_set(1), variations)));
    once = m_less(m_and(on, i_equal(variations, i_set(1))), listed);
    for (int i = 0; i < 4; i++)
        x->coefficients[i] = f_pick(once, coefficients[i], x->coefficients[i]);
    found = m_bits(once);
    x->listed &= ~m_bits(on);
    if (m_any(listed)) {
        const uint32_t long_ones = list_cells(p, listed);

        x->listed |= long_ones;
        found |= long_ones;
    }
    return m_of_bits(found);
}

/* Fetch the next change from the lists. @return the lanes that have one. */
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
        have |= 1u << lane;
    }
    return m_of_bits(have);
}

/* See alpha_here() of one ray. */
static vf v_alpha_here(const packet *p, vi label, const vf at[3], vm on)
{
    const sc_march *m = p->m;
    const vf plain = v_tissue_f(m, label, offsetof(sc_march_tissue, boundary_alpha), on);
    vf sum = {0}, weights = {0};
    vm measured;

    if (!m->volume->thickness)
        return plain;
    measured = m_less(
        on, i_equal(v_tissue(m, label, offsetof(sc_march_tissue, show), on) >> 16 & 255, i_set(0)));
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

static void v_take_surface(packet *p, vi label, const vf at[3], const v_spot *spot, vm on)
{
    vf alpha, rgb[3];

    if (!m_any(on))
        return;
    alpha =
        v_edge_alpha(&p->m->light, v_alpha_here(p, label, at, on), f_dot(spot->normal, spot->eye));
    v_light(p->m, label, spot, on, rgb);
    v_note(&p->light, label, alpha, spot, on);
    v_blend(&p->light, rgb, alpha, on);
    p->counters.contributions += m_count(on);
}

/* Where a label is shown and kept. */
static inline vm v_contributes(const packet *p, vi label, vm on)
{
    const vi bytes = v_tissue(p->m, label, offsetof(sc_march_tissue, show), on);
    const vm shown = m_less(on, i_equal(bytes & SC_SHOW_BOUNDARY, i_set(0)));

    return m_less(shown, i_equal(p->active >> (bytes >> 8 & 255) & 1, i_set(0)));
}

static inline vm v_sees_on(const packet *p)
{
    return f_at_most(f_set(SC_OPAQUE), p->light.transmittance);
}

/* One change of owner per lane of @p on. */
static void take_crossings(packet *p, const crossings *x, vm on)
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
        spot.place[i] = p->origin[i] + p->direction[i] * t;
    }
    v_face_eye(p->eye, spot.normal);
    v_light_spot(p->m, &spot, either);
    v_take_surface(p, x->left, at, &spot, left);
    v_take_surface(p, x->entered, at, &spot, m_and(entered, v_sees_on(p)));
}

/* The cells in which stretches begin. */
static void find_first_cells(packet *p, vm on)
{
    for (int i = 0; i < 3; i++)
        p->doubt[i] = (f_size(p->origin[i]) + f_size(p->direction[i]) * p->end) * 0x1p-20f;
    v_locate(p, on);
}

/* The next stretch of the rays of @p on, cut faces at its begin included. Lanes that have none left
 * die. */
static void begin_stretches(packet *p, vm on)
{
    uint32_t begun = 0;

    for (uint32_t left = m_bits(on); left; left &= left - 1) {
        const int lane = __builtin_ctz(left);
        cursor c = {.m = p->m, .ray = &p->rays[lane]};
        float begin, end;
        uint32_t active;

        if (p->light.transmittance[lane] < SC_OPAQUE ||
            !next_span(c.ray, p->ended[lane], &begin, &end, &active))
            continue;
        p->ended[lane] = end;
        begun |= 1u << lane;
        if (p->m->caps && p->m->plane_count) {
            c.light = v_radiance_of_lane(&p->light, lane);
            start_walk(&c);
            take_caps(&c, begin);
            v_radiance_set_lane(&p->light, lane, &c.light);
            p->counters.contributions += c.contributions;
        }
        begin = begin > p->near[lane] ? begin : p->near[lane];
        end = end < p->far[lane] ? end : p->far[lane];
        if (!(begin < end) || p->m->only_caps || p->light.transmittance[lane] < SC_OPAQUE)
            begin = end = 0; /* nothing to walk */
        p->t[lane] = begin;
        p->end[lane] = end;
        p->active[lane] = (int32_t)active;
        p->axis[lane] = -1;
    }
    p->alive = m_or(m_less(p->alive, on), m_of_bits(begun));
    find_first_cells(p, m_of_bits(begun));
}

static void init_packet(packet *p, const sc_march *march)
{
    p->m = march;
    p->counters = (sc_march_counters){0};
    p->x.listed = 0;
    for (int i = 0; i < 4; i++)
        p->x.coefficients[i] = f_set(0);
    p->x.u = f_set(0);
    p->x.left = p->x.entered = i_set(0);
}

/* Rays of one stretch each, as nearly all are without planes, begin it together. */
static bool begin_together(packet *p, int count, vm all)
{
    for (int lane = 0; lane < count; lane++) {
        if (p->rays[lane].groups != 1 || p->rays[lane].part_count[0] != 1)
            return false;
    }
    p->t = v_of_rays(p->rays, offsetof(sc_ray, parts[0][0].begin_mm), all);
    p->end = v_of_rays(p->rays, offsetof(sc_ray, parts[0][0].end_mm), all);
    p->t = f_pick(f_below(p->t, p->near), p->near, p->t);
    p->end = f_pick(f_below(p->far, p->end), p->far, p->end);
    p->active = i_set(1);
    p->alive = m_and(all, f_below(p->t, p->end));
    find_first_cells(p, p->alive);
    return !p->m->plane_count;
}

static void start_packet(packet *p, const sc_ray *rays, int count)
{
    vm all;

    p->rays = rays;
    p->light = v_darkness();
    p->alive = m_none();
    p->together = true;
    if (!count)
        return;
    all = m_of_bits((1u << count) - 1);
    for (int i = 0; i < 3; i++) {
        const size_t at = sizeof(float) * (size_t)i;

        p->origin[i] = v_of_rays(rays, offsetof(sc_ray, origin) + at, all);
        p->direction[i] = v_of_rays(rays, offsetof(sc_ray, direction) + at, all);
        p->eye[i] = v_of_rays(rays, offsetof(sc_ray, toward_eye) + at, all);
    }
    p->base_mm = v_of_rays(rays, offsetof(sc_ray, base_mm), all);
    for (int i = 0; i < 3; i++) {
        const vf d = p->direction[i];
        const vm back = f_below(d, f_set(0));

        p->still[i] = m_and(f_below(f_set(-1e-20f), d), f_below(d, f_set(1e-20f)));
        p->direction[i] = f_pick(p->still[i], f_set(0), d);
        p->inverse[i] = f_pick(p->still[i], f_set(1e30f), 1 / d);
        p->forward[i] = m_less(f_equal(d, d), m_less(back, p->still[i]));
        p->q[i] = p->cell.q[i] = i_set(0);
    }
    v_clip_to_box(p->m, p->origin, p->inverse, 0, &p->near, &p->far);
    p->t = p->end = f_set(0);
    p->active = i_set(0);
    p->axis = i_set(-1);
    p->together = begin_together(p, count, all);
    if (p->together)
        return;
    for (int lane = 0; lane < LANES; lane++)
        p->ended[lane] = -HUGE_VALF;
    begin_stretches(p, all);
}

/* Every lane finds a change of owner, or the end of its stretch. */
static void find(packet p[PACKETS])
{
    bool again = true;

    for (int k = 0; k < PACKETS; k++) {
        p[k].walks = p[k].alive;
        p[k].found = m_none();
    }
    while (again) {
        again = false;
        for (int k = 0; k < PACKETS; k++)
            p[k].stands = m_none();
        walk(p);
        for (int k = 0; k < PACKETS; k++) {
            const vm crossed = m_any(p[k].stands) ? find_crossings(&p[k]) : m_none();

            const vm passed = m_less(p[k].stands, crossed);

            p[k].found = m_or(p[k].found, crossed);
            p[k].walks = m_or(p[k].walks, passed);
            if (m_any(passed))
                advance(&p[k], i_set(0), passed);
            again = again || m_any(p[k].walks);
        }
    }
}

/* All changes of owner in the cells found, then out of them. */
static void take_cells(packet *p)
{
    crossings *x = &p->x;
    const vm single = m_less(p->found, m_of_bits(x->listed));
    const vm downward = f_below(x->coefficients[0], f_set(0));
    vi low, high;

    v_cell_read(p, p->found);
    v_cell_kinds(&p->cell, &low, &high);
    x->left = i_pick(downward, high, low);
    x->entered = i_pick(downward, low, high);
    x->u = v_root(x->coefficients, single);
    for (vm on = m_or(single, next_crossings(x, p->found)); m_any(on);
         on = m_and(next_crossings(x, p->found), v_sees_on(p)))
        take_crossings(p, x, on);
    advance(p, i_set(0), p->found);
}

/* And on to the next stretch at the end of one. */
static void take(packet *p)
{
    vm over;

    if (m_any(p->found))
        take_cells(p);
    over = m_less(p->alive, m_and(v_sees_on(p), f_below(p->t, p->end)));
    if (p->together)
        p->alive = m_less(p->alive, over);
    else
        begin_stretches(p, over);
}

static int least(size_t a, int b)
{
    return a < (size_t)b ? (int)a : b;
}

void MARCH_NAME(const sc_march *march, const sc_ray *rays, size_t count, sc_radiance *out,
                sc_march_counters *counters)
{
    packet p[PACKETS];

    for (int k = 0; k < PACKETS; k++)
        init_packet(&p[k], march);
    for (size_t i = 0; i < count; i += PACKETS * LANES) {
        const int lanes[PACKETS] = {least(count - i, LANES),
                                    count - i > LANES ? least(count - i - LANES, LANES) : 0};

        start_packet(&p[0], rays + i, lanes[0]);
        start_packet(&p[1], rays + i + LANES, lanes[1]);
        while (m_any(p[0].alive) || m_any(p[1].alive)) {
            find(p);
            take(&p[0]);
            take(&p[1]);
        }
        for (int k = 0; k < PACKETS; k++) {
            for (int lane = 0; lane < lanes[k]; lane++)
                out[i + (size_t)(k * LANES + lane)] = v_radiance_of_lane(&p[k].light, lane);
        }
    }
    counters->rays += count;
    for (int k = 0; k < PACKETS; k++)
        sc_add_counters(counters, &p[k].counters);
}
