/* SPDX-License-Identifier: BSD-3-Clause */
/* Template: the smooth surface model, one ray per SIMD lane, with steps across empty space.
 * Compiled once per skip method (MARCH_EMPTY, its file), variant and label width (MARCH_LABEL)
 * under the name MARCH_NAME.
 *
 * Every lane does to its ray what march_smooth_tmpl.c does, with the same operations. Lanes wait
 * for each other before the costly steps, so that these are done for as many of them as possible.
 * A step across empty space ends in the very cell, and at the very distance, that single steps
 * would have led to. */
#include "lanes_normal.h"
#include "wide_smooth_walk.h"

/* Positions within the present cells at distance @p t, to @p out; see local_at(). */
static inline void v_local_at(const packet *p, vf t, vi axis, bool leaving, vf out[3])
{
    for (int i = 0; i < 3; i++) {
        const vf face = f_pick(p->forward[i], f_set(leaving), f_set(!leaving));

        out[i] = f_pick(i_equal(axis, i_set(i)), face,
                        f_clamp01(p->origin[i] + p->direction[i] * t - f_of(p->q[i])));
    }
}

/* List all crossings of one lane's cell, which v_cell_read has read, in x->list, by cell.h and
 * seam.h.
 * @return whether there are any. */
static bool list_crossings(const packet *p, crossings *x, int lane)
{
    float a[3], b[3];
    sc_cell cell;

    for (int i = 0; i < 3; i++) {
        a[i] = p->a[i][lane];
        b[i] = p->b[i][lane];
    }
    v_cell_get_lane(p->m->volume, &p->cell, lane, p->ends >> lane & 1, &cell);
    x->count[lane] = sc_cell_crossings(&cell, a, b, x->list[lane]);
    x->count[lane] = sc_seam_coats(p->m, &cell, a, b, x->list[lane], x->count[lane]);
    x->next[lane] = 0;
    return x->count[lane] > 0;
}

/* Unpack what sc_cells holds of the present cells, which must be marked, to @p out: at each
 * corner the vote of the lowest label minus that of the other one. @return the lanes of @p on
 * whose cells hold more than two labels, for which @p out is meaningless. @param ends set to those
 * of them in which tissue ends. */
static inline vm v_cell_differences(const packet *p, vm on, vf out[SC_CORNERS], vm *ends)
{
    enum { CELL_BYTES = sizeof *p->m->cells, WORD_BYTES = CELL_BYTES / 2 };
    vi half, words[2];
    vm many;
    const vi index = v_packed_index(p->m->visible, p->m->cell_start, v_brick(p),
                                    v_half_bit(p->q[0], p->q[1], p->q[2]), p->q[2], on, &half);

    words[0] = i_gather(p->m->cells, index * CELL_BYTES, on);
    words[1] = i_gather(p->m->cells, index * CELL_BYTES + WORD_BYTES, on);
    for (int i = 0; i < SC_CORNERS; i++)
        out[i] = f_of(v_signed_field(words[sc_cell_field_word(i)], sc_cell_field_shift(i),
                                     SC_CELL_FIELD_BITS));
    many = m_and(on, i_below(words[1], i_set(0))); /* SC_CELL_MANY is the sign of the upper word */
    *ends = m_and(many, i_below(words[1] << 1, i_set(0))); /* SC_CELL_ENDS, the bit below */
    return many;
}

/* Read the labels and vertex records of the present cells into p->cell, which the lanes share:
 * lanes outside of @p on lose theirs. */
static inline void v_cell_read(packet *p, vm on)
{
    for (int i = 0; i < 3; i++)
        p->cell.q[i] = p->q[i];
    v_cell_labels(p->m->volume, sizeof(MARCH_LABEL), &p->cell, on);
    v_cell_fill(p->m->volume, &p->cell, on);
    if (p->ends & m_bits(on))
        v_cell_set_ends(p->m->volume, &p->cell, m_of_bits(p->ends & m_bits(on)));
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
    vm once, listed, ends;
    uint32_t found;

    for (int i = 0; i < 3; i++)
        mm[i] = v_exit_mm(p, i);
    nearest_plane(mm, &p->t1, &p->axis1);
    p->axis1 = i_pick(f_below(p->t1, p->end), p->axis1, i_set(-1));
    p->t1 = f_pick(f_below(p->t1, p->end), p->t1, p->end);
    v_local_at(p, p->t, p->axis, false, p->a);
    v_local_at(p, p->t1, p->axis1, true, p->b);
    listed = v_cell_differences(p, on, difference, &ends);
    p->ends = (p->ends & ~m_bits(on)) | m_bits(ends);
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
    return f_pick(m_and(measured, f_below(f_set(0), weights)),
                  sum / weights *
                      v_tissue_floats(m, label, offsetof(sc_march_tissue, thickness_factor), on),
                  plain);
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
    return f_at_most(f_set(p->m->opaque_below), p->light.transmittance);
}

/* Set the normals and rims of the spots of the lanes of @p on whose crossings are faces of the
 * volume. @param at the points in their cells. */
static void set_faces(const packet *p, const crossings *x, const vf at[3], vm on, v_spot *spot)
{
    for (uint32_t left = m_bits(m_without(on, i_equal(x->face, i_set(0)))); left;
         left &= left - 1) {
        const int lane = __builtin_ctz(left);
        const uint32_t left_id = (uint32_t)x->left[lane], entered = (uint32_t)x->entered[lane];
        sc_spot one = {.depth_mm = spot->depth_mm[lane]};
        float a[3];
        sc_cell cell;

        sc_face_normal(p->m, x->face[lane] - 1, p->rays[lane].toward_eye, one.normal);
        for (int i = 0; i < 3; i++) {
            spot->normal[i][lane] = one.normal[i];
            one.point[i] = spot->point[i][lane];
            a[i] = at[i][lane];
        }
        if (!sc_has_rims(p->m))
            continue;
        v_cell_get_lane(p->m->volume, &p->cell, lane, p->ends >> lane & 1, &cell);
        spot->rim[lane] = sc_volume_face_rim(p->m, &cell, left_id ? left_id : entered, a, &one,
                                             x->face[lane] - 1);
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
    vf at[3], sides[2], length;

    if (!m_any(either))
        return;
    spot.depth_mm = p->base_mm + t;
    for (int i = 0; i < 3; i++) {
        spot.eye[i] = p->eye[i];
        at[i] = f_lerp(p->a[i], p->b[i], x->u);
        spot.point[i] = p->origin[i] + p->direction[i] * t;
    }
    if (p->m->fading)
        v_sides_left(p->m, x->entered, x->left, either, sides);
    v_cell_normal(&p->cell, x->entered, x->left, at, p->eye, p->m->fading ? sides : NULL,
                  spot.normal);
    if (p->m->fading && p->m->occlusion)
        v_turn_to_open(p->m, spot.point, sides, either, spot.normal);
    length = f_length(spot.normal);
    for (int i = 0; i < 3; i++)
        spot.normal[i] = f_pick(f_below(f_set(1e-3f), length), spot.normal[i] / length, p->eye[i]);
    v_face_eye(p->eye, spot.normal);
    spot.rim = f_set(0);
    set_faces(p, x, at, either, &spot);
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

/* Let the rays of the lanes @p on, as bits, go on where they have stopped within the stretches that
 * they begin. */
static void go_on(packet *p, uint32_t on)
{
    for (uint32_t left = p->ways ? on : 0; left; left &= left - 1) {
        const int lane = __builtin_ctz(left);
        sc_way *way = &p->ways[lane];

        if (!way->walks)
            continue;
        p->t[lane] = way->t_mm;
        p->axis[lane] = way->axis;
        for (int i = 0; i < 3; i++)
            p->q[i][lane] = way->at[i];
        way->walks = false;
    }
}

/* Add the cut faces at the beginning of the stretch of a lane, unless its ray is to stop before
 * them. @return false if it has stopped. */
static bool pass_lane_caps(packet *p, int lane, float begin)
{
    cursor c = {.m = p->m,
                .ray = &p->rays[lane],
                .way = p->ways ? &p->ways[lane] : NULL,
                .limit_mm = p->limit_mm[lane],
                .light = v_radiance_get_lane(&p->light, lane)};
    bool passed;

    start_walk(&c);
    passed = pass_caps(&c, begin);
    v_radiance_set_lane(&p->light, lane, &c.light);
    p->limit_mm[lane] = c.limit_mm;
    p->counters.contributions += c.contributions;
    return passed;
}

/* Begin the next stretch of the lanes of @p on, with the cut faces at its beginning: sets t,
 * end, active, axis, last_end and q. Rays that have none left, or are opaque, leave p->alive. */
static void begin_stretches(packet *p, vm on)
{
    uint32_t begun = 0;

    for (uint32_t left = m_bits(on); left; left &= left - 1) {
        const int lane = __builtin_ctz(left);
        float begin, end;
        uint32_t active;

        if (p->light.transmittance[lane] < p->m->opaque_below ||
            !next_stretch(&p->rays[lane], p->last_end[lane], &begin, &end, &active))
            continue;
        if (p->ways)
            p->ways[lane].from_mm = p->last_end[lane];
        if (p->m->caps && p->m->plane_count && !(p->ways && p->ways[lane].walks) &&
            !pass_lane_caps(p, lane, begin))
            continue;
        begun |= 1u << lane;
        p->last_end[lane] = end;
        begin = begin > p->near[lane] ? begin : p->near[lane];
        end = end < p->far[lane] ? end : p->far[lane];
        if (!(begin < end) || p->m->only_caps || p->light.transmittance[lane] < p->m->opaque_below)
            begin = end = 0; /* there is nothing to walk through */
        p->t[lane] = begin;
        p->end[lane] = end;
        p->active[lane] = (int32_t)active;
        p->axis[lane] = -1;
    }
    p->alive = m_or(m_without(p->alive, on), m_of_bits(begun));
    find_first_cells(p, m_of_bits(begun));
    go_on(p, begun);
}

/* Set the march of a packet and clear its counters and crossings, whose unused lanes take part
 * in the arithmetic, too. */
static void init_packet(packet *p, const sc_march *march)
{
    p->m = march;
    p->limit_mm = f_set(0);
    p->counters = (sc_march_counters){0};
    p->x.listed = 0;
    p->ends = 0;
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
    if (!p->m->plane_count)
        go_on(p, m_bits(p->alive));
    return !p->m->plane_count;
}

/* Load the rays [0, @p count) into the packet, at most LANES, and begin their first stretches;
 * lanes beyond are not alive. @p rays and @p ways stay borrowed until the next call. init_packet
 * has been called before. @param ways NULL, or of the rays. @param light with ways: what the rays
 * have brought back so far. */
static void start_packet(packet *p, const sc_ray *rays, sc_way *ways, const sc_radiance *light,
                         int count)
{
    vm all;

    p->rays = rays;
    p->ways = ways;
    p->light = v_no_light();
    p->alive = m_none();
    p->place = v_first_place();
    p->one_stretch = true;
    if (!count)
        return;
    all = m_of_bits((1u << count) - 1);
    if (ways) {
        p->limit_mm = v_begin_ways(ways, count, all);
        v_radiance_read(&p->light, light, count);
    }
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
        p->last_end[lane] = ways && lane < count ? ways[lane].from_mm : -HUGE_VALF;
    begin_stretches(p, all);
}

/* Walk until every living lane of the packets has found a cell with a crossing (p->found), or
 * reached the end of its stretch. */
static void find_next(packet p[PACKETS])
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

/* Stop the rays of the lanes of @p on before the cells in which they are. */
static void stop_rays(packet *p, vm on)
{
    for (uint32_t left = m_bits(on); left; left &= left - 1) {
        const int lane = __builtin_ctz(left);
        sc_way *way = &p->ways[lane];

        way->walks = true;
        way->t_mm = p->t[lane];
        way->axis = (int8_t)p->axis[lane];
        for (int i = 0; i < 3; i++)
            way->at[i] = p->q[i][lane];
    }
    p->alive = m_without(p->alive, on);
}

/* Ask in the lanes of @p on, in whose cells no crossing has contributed yet, whether rays stop
 * before the present one. @param asks what is left of the lanes that ask. @return the lanes of @p
 * on that have not stopped. */
static vm pass_crossings(packet *p, vm on, vm *asks)
{
    const crossings *x = &p->x;
    const vm here = m_and(on, *asks);
    const vm met = m_or(v_contributes(p, x->left, here), v_contributes(p, x->entered, here));
    vm stopped;

    if (!m_any(met))
        return on;
    stopped = m_without(
        met, v_pass(p->ways, p->base_mm + (p->t + (p->t1 - p->t) * x->u), &p->limit_mm, met));
    *asks = m_without(*asks, met);
    stop_rays(p, stopped);
    return m_without(on, stopped);
}

/* Add all crossings in the cells of p->found, which find_crossings has searched, unless rays stop
 * before them, and step out of these cells. */
static void add_cell_crossings(packet *p)
{
    crossings *x = &p->x;
    vm asks = p->ways ? p->found : m_none(), on;
    const vm single = m_without(p->found, m_of_bits(x->listed));
    const vm downward = f_below(x->coefficients[0], f_set(0));
    vi low, high;

    v_cell_read(p, p->found);
    v_label_range(&p->cell, &low, &high);
    x->left = i_pick(downward, high, low);
    x->entered = i_pick(downward, low, high);
    x->u = v_root(x->coefficients, single);
    x->face = i_set(0);
    for (on = m_or(single, next_crossings(x, p->found)); m_any(on);
         on = m_and(next_crossings(x, m_and(p->found, p->alive)), v_sees_on(p))) {
        if (m_any(asks))
            on = pass_crossings(p, on, &asks);
        add_crossings(p, x, on);
    }
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

#include "wide_loop.h"
