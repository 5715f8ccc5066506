/* SPDX-License-Identifier: BSD-3-Clause */
/* Template: the smooth surface model, one ray per SIMD lane, with steps across empty space.
 * Compiled once per skip method (MARCH_EMPTY, its file) and variant under the name MARCH_NAME.
 *
 * Every lane does to its ray what march_smooth_tmpl.c does, with the same operations. Lanes wait
 * for each other before the costly steps, so that these are done for as many of them as possible.
 * A step across empty space ends in the very cell, and at the very distance, that single steps
 * would have led to. */
#include "around.h"
#include "lanes/lanes_normal.h"
#include "wide_smooth_walk.h"

/* Positions within the present cells at distance @p t, to @p out; see local_at(). */
static inline void v_local_at(const packet *p, vf t, vi axis, bool leaving, vf out[3])
{
    for (int i = 0; i < 3; i++) {
        const vf face = f_pick(p->ray.forward[i], f_set(leaving), f_set(!leaving));

        out[i] = f_pick(i_equal(axis, i_set(i)), face,
                        f_clamp01(p->ray.origin[i] + p->ray.direction[i] * t - f_of(p->q[i])));
    }
}

/* Read one lane's cell and list all its crossings, by cell.h: x->cells and x->list. @return whether
 * there are any. */
static bool list_crossings(const packet *p, crossings *x, int lane)
{
    sc_cell *cell = &x->cells[lane];
    float a[3], b[3];

    for (int i = 0; i < 3; i++) {
        cell->q[i] = p->q[i][lane];
        a[i] = p->chord.a[i][lane];
        b[i] = p->chord.b[i][lane];
    }
    x->next[lane] = 0;
    x->count[lane] =
        sc_cell_read(p->m->volume, cell) ? sc_cell_crossings(cell, a, b, x->list[lane]) : 0;
    return x->count[lane] > 0;
}

/* Read what sc_cells holds of the present cells, which must be marked in the lanes of @p on, to
 * @p values and @p labels; see sc_packed_cell. */
static inline void read_packed(const packet *p, vm on, vi values[2], vi *labels)
{
    const vi brick = v_brick(p);

    values[0] = values[1] = *labels = i_set(0);
    for (uint32_t left = m_bits(on); left; left &= left - 1) {
        const int lane = __builtin_ctz(left);
        const uint64_t mask = p->m->marked.masks[brick[lane]];
        const int bit = sc_brick_bit(p->q[0][lane], p->q[1][lane], p->q[2][lane]);
        const sc_packed_cell *cell =
            &p->m->marked.cells[p->m->marked.cell_start[brick[lane]] + sc_brick_rank(mask, bit)];

        values[0][lane] = (int32_t)cell->values[0];
        values[1][lane] = (int32_t)cell->values[1];
        (*labels)[lane] = (int32_t)cell->labels;
    }
}

/* Search the marked cells reached for crossings: sets a, b, t1 and axis1 (those of all lanes),
 * and for the lanes of p->at_marked coefficients or list of p->x. @return the lanes that have a
 * crossing. */
static vm find_crossings(packet *p)
{
    crossings *x = &p->x;
    const vm on = p->at_marked;
    vf mm[3], difference[SC_CORNERS], coefficients[4];
    vi variations, values[2], labels;
    vm general, once, listed;
    uint32_t found;

    for (int i = 0; i < 3; i++)
        mm[i] = v_exit_mm(p, i);
    nearest_plane(mm, &p->chord.t1, &p->chord.axis1);
    p->chord.axis1 = i_pick(f_below(p->chord.t1, p->stretch.end), p->chord.axis1, i_set(-1));
    p->chord.t1 = f_pick(f_below(p->chord.t1, p->stretch.end), p->chord.t1, p->stretch.end);
    v_local_at(p, p->t, p->axis, false, p->chord.a);
    v_local_at(p, p->chord.t1, p->chord.axis1, true, p->chord.b);
    read_packed(p, on, values, &labels);
    for (int i = 0; i < SC_CORNERS; i++)
        difference[i] = f_of(v_signed_field(values[i / SC_CELL_WORD_CORNERS],
                                            SC_CELL_VALUE_BITS * (i % SC_CELL_WORD_CORNERS),
                                            SC_CELL_VALUE_BITS));
    v_bernstein(difference, p->chord.a, p->chord.b, coefficients);
    variations = v_variations(coefficients);
    /* If the signs of the coefficients change once, there is exactly one crossing, which v_root
     * will find. Cells with more changes, and general ones, need a list, unless all is background.
     */
    general = m_and(on, i_equal(labels, i_set(0)));
    once = m_without(m_and(on, i_equal(variations, i_set(1))), general);
    listed = m_or(
        m_and(on, i_below(i_set(1), variations)),
        m_and(general, m_or(i_below(i_set(0), variations), f_below(coefficients[0], f_set(0)))));
    for (int i = 0; i < 4; i++)
        x->coefficients[i] = f_pick(once, coefficients[i], x->coefficients[i]);
    for (int i = 0; i < 2; i++)
        x->values[i] = i_pick(once, values[i], x->values[i]);
    x->labels = i_pick(once, labels, x->labels);
    found = m_bits(once);
    x->listed &= ~m_bits(on);
    for (uint32_t left = m_bits(listed); left; left &= left - 1) {
        const int lane = __builtin_ctz(left);

        if (list_crossings(p, x, lane)) {
            x->listed |= 1u << lane;
            found |= 1u << lane;
        }
    }
    return m_of_bits(found);
}

/* Set the normal of a crossing of one lane's list, in p->x.normal; at faces of the volume nothing
 * is set. */
static void find_listed_normal(packet *p, int lane, const sc_crossing *crossing)
{
    float at[3], normal[3];

    if (crossing->face)
        return;
    for (int i = 0; i < 3; i++)
        at[i] = sc_lerp(p->chord.a[i][lane], p->chord.b[i][lane], crossing->u);
    sc_cell_normal(&p->x.cells[lane], crossing->entered, crossing->left, at, normal);
    for (int i = 0; i < 3; i++)
        p->x.normal[i][lane] = normal[i];
}

/* Fetch the next crossing of the lanes of @p on that have a list, to x->left, entered, u, face and
 * normal. @return those that had one left; others keep the last. */
static vm next_crossings(packet *p, vm on)
{
    crossings *x = &p->x;
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
        find_listed_normal(p, lane, &x->list[lane][n]);
        have |= 1u << lane;
    }
    return m_of_bits(have);
}

/* See sc_surface_alpha: opacity of the surfaces of @p label at the points @p at of their cells. */
static vf v_surface_alpha(const packet *p, vi label, const vf at[3], vm on)
{
    const sc_march *m = p->m;
    vf alpha = v_tissue_floats(m, label, offsetof(sc_march_tissue, boundary_alpha), on);
    vm measured;

    if (!m->volume->thickness)
        return alpha;
    measured = v_by_thickness(v_tissue_bytes(m, label, on), on);
    for (uint32_t left = m_bits(measured); left; left &= left - 1) {
        const int lane = __builtin_ctz(left);
        const int q[3] = {p->q[0][lane], p->q[1][lane], p->q[2][lane]};
        const float a[3] = {at[0][lane], at[1][lane], at[2][lane]};

        alpha[lane] = sc_surface_alpha(m, q, (uint32_t)label[lane], a);
    }
    return alpha;
}

/* Add one side of a crossing, the surface of @p label, to the light of the lanes of @p on. The
 * spot has been completed by v_light_spot. */
static void v_add_surface(packet *p, vi label, const vf at[3], const v_spot *spot, vm on)
{
    vf alpha, rgb[3];

    if (!m_any(on))
        return;
    alpha = v_edge_alpha(&p->m->light, v_surface_alpha(p, label, at, on),
                         f_dot(spot->normal, spot->eye));
    v_light(p->m, label, spot, on, rgb);
    v_remember_surface(&p->light, label, alpha, spot, p->ray.seeks, on);
    v_blend(&p->light, rgb, alpha, p->ray.seeks, on);
    p->counters.contributions += m_count(on);
}

/* Lanes of @p on whose label is shown there and not cut away. */
static inline vm v_contributes(const packet *p, vi label, vm on)
{
    const vi bytes = v_tissue_bytes(p->m, label, on);

    return v_in_kept_set(bytes, p->stretch.active, v_shows(bytes, SC_SHOW_BOUNDARY, on));
}

/* Rays that are not yet opaque, of all lanes. */
static inline vm v_sees_on(const packet *p)
{
    return f_at_most(p->ray.ends_below, p->light.transmittance);
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

        sc_face_normal(p->m, x->face[lane] - 1, p->rays[lane].toward_eye, one.normal);
        for (int i = 0; i < 3; i++) {
            spot->normal[i][lane] = one.normal[i];
            one.point[i] = spot->point[i][lane];
            a[i] = at[i][lane];
        }
        if (!sc_has_rims(p->m))
            continue;
        spot->rim[lane] = sc_volume_face_rim(p->m, &x->cells[lane], left_id ? left_id : entered, a,
                                             &one, x->face[lane] - 1);
    }
}

/* Set the light around the spots of the lanes of @p on, as far as it is known. @return in which
 * lanes it is. */
static vm set_around(const packet *p, const crossings *x, const vf at[3], vm on, v_spot *spot)
{
    uint32_t known = 0;

    for (int i = 0; i < 3; i++)
        spot->around[i] = f_set(0);
    for (uint32_t left = p->m->light.sky > 0 ? m_bits(on) : 0; left; left &= left - 1) {
        const int lane = __builtin_ctz(left);
        const int q[3] = {p->q[0][lane], p->q[1][lane], p->q[2][lane]};
        float a[3], n[3], around[3];

        if (x->face[lane])
            continue;
        for (int i = 0; i < 3; i++) {
            a[i] = at[i][lane];
            n[i] = spot->normal[i][lane];
        }
        if (!sc_around(p->m, !x->left[lane] || !x->entered[lane], q, a, n, around))
            continue;
        known |= 1u << lane;
        for (int i = 0; i < 3; i++)
            spot->around[i][lane] = around[i];
    }
    return m_of_bits(known);
}

/* Add the present crossing of x to the light of each lane of @p on, as far as its labels
 * contribute. */
static void add_crossings(packet *p, const crossings *x, vm on)
{
    const vm left = v_contributes(p, x->left, on), entered = v_contributes(p, x->entered, on);
    const vf t = p->t + (p->chord.t1 - p->t) * x->u;
    const vm either = m_or(left, entered);
    v_spot spot;
    vf at[3], length;

    if (!m_any(either))
        return;
    spot.depth_mm = p->ray.base_mm + t;
    for (int i = 0; i < 3; i++) {
        spot.eye[i] = p->ray.eye[i];
        at[i] = f_lerp(p->chord.a[i], p->chord.b[i], x->u);
        spot.point[i] = p->ray.origin[i] + p->ray.direction[i] * t;
    }
    length = f_length(x->normal);
    for (int i = 0; i < 3; i++)
        spot.normal[i] =
            f_pick(f_below(f_set(SC_GRADIENT_LEAST), length), x->normal[i] / length, p->ray.eye[i]);
    v_face_eye(p->ray.eye, spot.normal);
    spot.rim = f_set(0);
    set_faces(p, x, at, either, &spot);
    spot.has_around = set_around(p, x, at, either, &spot);
    v_light_spot(p->m, &spot, either);
    v_add_surface(p, x->left, at, &spot, left);
    v_add_surface(p, x->entered, at, &spot, m_and(entered, v_sees_on(p)));
}

/* Set p->stretch.rounding and p->q: the cells in which the stretches of the lanes of @p on begin.
 * t, end and axis (-1) of these lanes have been set. */
static void find_first_cells(packet *p, vm on)
{
    /* 2^-20 is eight times the relative rounding error of a float. */
    for (int i = 0; i < 3; i++)
        p->stretch.rounding[i] =
            (f_abs(p->ray.origin[i]) + f_abs(p->ray.direction[i]) * p->stretch.end) * 0x1p-20f;
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

        if (p->light.transmittance[lane] < p->ray.ends_below[lane] ||
            !next_stretch(&p->rays[lane], p->stretch.last_end[lane], &begin, &end, &active))
            continue;
        if (p->ways)
            p->ways[lane].from_mm = p->stretch.last_end[lane];
        if (p->m->cut_faces.are_drawn && p->m->planes.count && !(p->ways && p->ways[lane].walks) &&
            !pass_lane_caps(p, lane, begin))
            continue;
        begun |= 1u << lane;
        p->stretch.last_end[lane] = end;
        begin = begin > p->stretch.near[lane] ? begin : p->stretch.near[lane];
        end = end < p->stretch.far[lane] ? end : p->stretch.far[lane];
        if (!(begin < end) || p->m->cut_faces.only ||
            p->light.transmittance[lane] < p->ray.ends_below[lane])
            begin = end = 0; /* there is nothing to walk through */
        p->t[lane] = begin;
        p->stretch.end[lane] = end;
        p->stretch.active[lane] = (int32_t)active;
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
    for (int i = 0; i < 4; i++)
        p->x.coefficients[i] = f_set(0);
    p->x.u = f_set(0);
    p->x.left = p->x.entered = p->x.face = p->x.labels = i_set(0);
    p->x.values[0] = p->x.values[1] = i_set(0);
    for (int i = 0; i < 3; i++)
        p->x.normal[i] = f_set(0);
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
    p->stretch.end = v_ray_floats(p->rays, offsetof(sc_ray, parts[0][0].end_mm), all);
    p->t = f_pick(f_below(p->t, p->stretch.near), p->stretch.near, p->t);
    p->stretch.end =
        f_pick(f_below(p->stretch.far, p->stretch.end), p->stretch.far, p->stretch.end);
    p->stretch.active = i_set(1);
    p->alive = m_and(all, f_below(p->t, p->stretch.end));
    find_first_cells(p, p->alive);
    if (!p->m->planes.count)
        go_on(p, m_bits(p->alive));
    return !p->m->planes.count;
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
    p->stretch.is_only = true;
    if (!count)
        return;
    all = m_of_bits((1u << count) - 1);
    if (ways) {
        p->limit_mm = v_begin_ways(ways, count, all);
        v_radiance_read(&p->light, light, count);
    }
    v_load_rays(p->m, rays, all, &p->ray);
    for (int i = 0; i < 3; i++) {
        const vf d = p->ray.direction[i];
        const vm back = f_below(d, f_set(0));

        p->parallel[i] = m_and(f_below(f_set(-SC_PARALLEL), d), f_below(d, f_set(SC_PARALLEL)));
        p->ray.direction[i] = f_pick(p->parallel[i], f_set(0), d);
        p->ray.inverse[i] = f_pick(p->parallel[i], f_set(SC_NEVER_MM), 1 / d);
        p->ray.forward[i] = m_without(f_equal(d, d), m_without(back, p->parallel[i]));
        p->q[i] = i_set(0);
    }
    p->ray.mm_per_city_block =
        1 / (f_abs(p->ray.direction[0]) + f_abs(p->ray.direction[1]) + f_abs(p->ray.direction[2]));
    v_clip_to_box(p->m, p->ray.origin, p->ray.inverse, 0, &p->stretch.near, &p->stretch.far);
    p->t = p->stretch.end = f_set(0);
    p->stretch.active = i_set(0);
    p->axis = i_set(-1);
    p->stretch.is_only = begin_at_once(p, count, all);
    if (p->stretch.is_only)
        return;
    for (int lane = 0; lane < LANES; lane++)
        p->stretch.last_end[lane] = ways && lane < count ? ways[lane].from_mm : -HUGE_VALF;
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
    stopped = m_without(met, v_pass(p->ways, p->ray.base_mm + (p->t + (p->chord.t1 - p->t) * x->u),
                                    &p->limit_mm, met));
    *asks = m_without(*asks, met);
    stop_rays(p, stopped);
    return m_without(on, stopped);
}

/* Find the only crossing in the cells of the lanes @p on: left, entered, u, face and normal of
 * p->x. Other lanes lose theirs. */
static void find_single(packet *p, vm on)
{
    crossings *x = &p->x;
    const vm downward = f_below(x->coefficients[0], f_set(0));
    const vi low = x->labels & ((1 << SC_CELL_LABEL_BITS) - 1);
    const vi high = (vi)((vu)x->labels >> SC_CELL_LABEL_BITS);
    vf at[3];

    x->left = i_pick(downward, high, low);
    x->entered = i_pick(downward, low, high);
    x->face = i_set(0);
    x->u = v_root(x->coefficients, on);
    for (int i = 0; i < 3; i++)
        at[i] = f_lerp(p->chord.a[i], p->chord.b[i], x->u);
    v_cell_normal(p->m->volume, p->q, x->values, i_equal(low, i_set(0)), m_without(on, downward),
                  at, on, x->normal);
}

/* Add all crossings in the cells of p->found, which find_crossings has searched, unless rays stop
 * before them, and step out of these cells. */
static void add_cell_crossings(packet *p)
{
    crossings *x = &p->x;
    const vm single = m_without(p->found, m_of_bits(x->listed));
    vm asks = p->ways ? p->found : m_none(), on;

    if (m_any(single))
        find_single(p, single);
    for (on = m_or(single, next_crossings(p, p->found)); m_any(on);
         on = m_and(next_crossings(p, m_and(p->found, p->alive)), v_sees_on(p))) {
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
    over = m_without(p->alive, m_and(v_sees_on(p), f_below(p->t, p->stretch.end)));
    if (p->stretch.is_only)
        p->alive = m_without(p->alive, over);
    else
        begin_stretches(p, over);
}

#include "wide_loop.h"
