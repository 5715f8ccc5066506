/* SPDX-License-Identifier: BSD-3-Clause */
/* Template: the voxel surface model, one ray per SIMD lane, with steps across empty space.
 * Compiled once per skip method (MARCH_EMPTY, its file) and variant under the name MARCH_NAME.
 *
 * Every lane takes the samples that march_voxel_tmpl.c takes, with the same operations. A step
 * across empty space goes to a sample whose predecessor still lies in it: coordinates along a ray
 * never turn back, so that all samples in between lie there, too. */
#include "lanes/lanes_cell.h"
#include "lanes/lanes_shade.h"
#include "variants.h"
#include "voxel_ray.h"

#include MARCH_EMPTY

/* LANES rays that are marched side by side; start_packet loads them. Positions are in grid
 * coordinates plus 1/2. */
typedef struct packet {
    const sc_march *m;
    const sc_ray *rays;
    sc_way *ways; /* NULL: rays go to their ends at once */
    vf limit_mm;  /* with ways: rays stop before what is not nearer to the eye than this */
    v_radiance light;
    v_ray ray;
    vi k, last;           /* the present sample, and the end of the part of the ray */
    vi kept;              /* the clip sets kept from k to last, as bits */
    vi nearest, farthest; /* the first sample within the box of the march, the first one beyond */
    int last_end[LANES];  /* where the part before ended */
    v_place place;        /* what the skip method remembers of the walk */
    vm alive;             /* rays that are not finished */
    vm walking;           /* on the way to a marked sample */
    vm found;             /* at a marked sample */
    sc_march_counters counters;
} packet;

enum {
    PACKETS = 2,             /* packets that a loop works on in turn */
    ENOUGH_LANES = LANES / 2 /* so many at marked samples are worth adding these */
};

/* Distance of sample @p k from the origin, in mm. */
static inline vf v_distance(const packet *p, vi k)
{
    return (f_of(k) + 0.5f) * p->m->step_mm;
}

/* The grid vertex nearest to sample @p k of each lane, to @p out. */
static inline void v_vertex(const packet *p, vi k, vi out[3])
{
    const vf t = v_distance(p, k);

    for (int i = 0; i < 3; i++)
        out[i] = i_of(p->ray.origin[i] + p->ray.direction[i] * t);
}

/* The lanes in which the vertex @p other lies outside of the empty space @p e around @p at. */
static inline vm v_is_outside(const v_empty *e, const vi at[3], const vi other[3])
{
    vi blocks = i_set(0);
    vm out = m_none();

    for (int i = 0; i < 3 && EMPTY_IS_BALL; i++)
        blocks += i_pick(i_below(other[i], at[i]), at[i] - other[i], other[i] - at[i]);
    if (EMPTY_IS_BALL)
        return i_below(e->ahead - 1, blocks);
    for (int i = 0; i < 3; i++) {
        const vi from = other[i] - (at[i] & e->mask);

        out = m_or(out, m_or(i_below(from, e->back), i_below(e->ahead - 1, from)));
    }
    return out;
}

/* Distance in mm, but for rounding, at which the ray leaves the empty space @p e around the vertex
 * @p at of sample p->k, if that is a box. */
static inline vf v_leaves_box(const packet *p, const vi at[3], const v_empty *e)
{
    vf t = f_set(SC_NEVER_MM);

    for (int i = 0; i < 3; i++) {
        const vi plane = (at[i] & e->mask) + i_pick(p->ray.forward[i], e->ahead, e->back);
        const vf mm = (f_of(plane) - p->ray.origin[i]) * p->ray.inverse[i];

        t = f_pick(f_below(mm, t), mm, t);
    }
    return t;
}

/* The same if it is a ball. The city-block distance grows by 1 where the position along an axis
 * comes to the next whole number: up to the distance returned no more often than that the ray is
 * still within. */
static inline vf v_leaves_ball(const packet *p, const vi at[3], const v_empty *e)
{
    const vf t = v_distance(p, p->k);
    vf way = f_of(e->ahead);

    for (int i = 0; i < 3; i++) {
        const vf within = p->ray.origin[i] + p->ray.direction[i] * t - f_of(at[i]);
        const vm stays = f_equal(p->ray.inverse[i], f_set(SC_NEVER_MM));

        way -= f_pick(stays, f_set(0), f_pick(p->ray.forward[i], within, 1 - within));
    }
    return t + way * p->ray.mm_per_city_block;
}

/* @return a sample beyond the empty space @p e around the vertex @p at (of v_vertex of sample
 * p->k): as far ahead as is safe, at least the next one, at most p->last. Other lanes than those of
 * @p on are meaningless. */
static vi step_over(const packet *p, const vi at[3], const v_empty *e, vm on)
{
    vf t = EMPTY_IS_BALL ? v_leaves_ball(p, at, e) : v_leaves_box(p, at, e);
    vi k;
    vm open;

    t = t * (1 / p->m->step_mm) + 0.5f;
    k = i_pick(f_below(t, f_of(p->last)), i_of(t), p->last);
    /* Rounding may have led too far: go back while the sample before lies outside of what is empty.
     */
    open = m_and(on, i_below(p->k + 1, k));
    while (m_any(open)) {
        vi before[3];

        v_vertex(p, k - 1, before);
        open = m_and(open, v_is_outside(e, at, before));
        k = i_pick(open, k - 1, k);
        open = m_and(open, i_below(p->k + 1, k));
    }
    return i_pick(i_below(p->k + 1, k), k, p->k + 1);
}

/* One step of the lanes that are walking: sets p->k. Those at a marked sample stop walking and
 * join p->found; those at the end of their part stop walking. Counts cell visits and steps across
 * empty space. */
static inline void step(packet *p)
{
    const vm seek = m_and(p->walking, i_below(p->k, p->last));
    vi at[3], next = p->k + 1;
    v_empty e;

    v_vertex(p, p->k, at);
    e = v_look(p->m, at, &p->place, seek);
    p->counters.cell_visits += m_count(m_without(seek, e.leaps));
    p->counters.brick_steps += m_count(e.leaps);
    p->found = m_or(p->found, e.marked);
    p->walking = m_without(seek, e.marked);
    if (m_any(e.leaps))
        next = i_pick(e.leaps, step_over(p, at, &e, e.leaps), next);
    p->k = i_pick(p->walking, next, p->k);
}

/* Is any lane walking, and are fewer than ENOUGH_LANES at marked samples? */
static inline bool walk_on(const packet *p)
{
    return m_any(p->walking) && m_count(p->found) < ENOUGH_LANES;
}

/* Walk until enough lanes of each packet are at marked samples (p->found), or none is walking:
 * sets p->k, p->found and p->walking. Two packets take turns: while one waits for memory, the
 * processor works on the other. */
static void find_next(packet p[PACKETS])
{
    bool first, second;

    for (int k = 0; k < PACKETS; k++) {
        p[k].walking = m_and(p[k].alive, f_at_most(p[k].ray.ends_below, p[k].light.transmittance));
        p[k].found = m_none();
    }
    first = walk_on(&p[0]);
    second = walk_on(&p[1]);
    while (first || second) {
        if (first)
            step(&p[0]);
        if (second)
            step(&p[1]);
        first = walk_on(&p[0]);
        second = walk_on(&p[1]);
    }
}

/* Labels (dense ids) of voxels @p at, which must lie within the volume in the lanes of @p on; 0
 * in other lanes. */
static inline vi v_label_at(const sc_prepared *v, const vi at[3], vm on)
{
    const vi index = (at[2] * v->size[1] + at[1]) * v->size[0] + at[0];

    return i_gather(v->ids, index << (v->label_bytes - 1), on) & ((1 << 8 * v->label_bytes) - 1);
}

/* Lanes of @p on whose voxels @p at are marked in @p masks. @param index is set to where what is
 * kept of them stands, see v_packed_index; meaningless in other lanes. */
static inline vm v_find_marked(const sc_prepared *v, const uint64_t *masks, const uint32_t *start,
                               const vi at[3], vm on, vi *index)
{
    const vi x = at[0] + 1, y = at[1] + 1, z = at[2] + 1;
    const vi bit = v_half_bit(x, y, z);
    vi half;

    *index = v_packed_index(masks, start, v_brick_index(v->bricks, x, y, z), bit, z, on, &half);
    return v_bit_set(half, bit, on);
}

/* See sc_voxel_record: the records of the voxels @p at, 0 where there are none. */
static vi v_voxel_record(const sc_prepared *v, const vi at[3], vm on)
{
    vi index, record;
    const vm outer = v_find_marked(v, v->outer.masks, v->outer.start, at, on, &index);
    vm inner = m_without(on, outer);

    record = i_gather(v->outer.records, index * SC_RECORD_BYTES, outer);
    if (!m_any(inner))
        return record;
    inner = v_find_marked(v, v->inner.masks, v->inner.start, at, inner, &index);
    return record | i_gather(v->inner.records, index * SC_RECORD_BYTES, inner);
}

/* Opacity of boundary voxels of @p label; see add_boundary() of march_voxel_tmpl.c. @param near
 * their indices in the thickness. */
static inline vf v_boundary_alpha(const sc_march *m, vi label, vi near, vm on)
{
    const vf plain = v_tissue_floats(m, label, offsetof(sc_march_tissue, boundary_alpha), on);
    vf factor;
    vm measured;
    vi code;

    if (!m->volume->thickness)
        return plain;
    measured = v_by_thickness(v_tissue_bytes(m, label, on), on);
    if (!m_any(measured))
        return plain;
    factor = v_tissue_floats(m, label, offsetof(sc_march_tissue, thickness_factor), measured);
    code = i_gather(m->volume->thickness, near, measured) & 255;
    return f_pick(measured, f_gather(m->thickness_alpha, code * 4, measured) * factor, plain);
}

/* Add the present samples of the lanes of @p on, which lie in the interior of @p label, to the
 * light; see add_interior() of march_voxel_tmpl.c. */
static void add_interior(packet *p, vi label, vm on)
{
    const vf alpha = v_tissue_floats(p->m, label, offsetof(sc_march_tissue, interior_alpha), on);
    v_spot spot = {.depth_mm = p->ray.base_mm + v_distance(p, p->k)};
    vf rgb[3];

    for (int i = 0; i < 3; i++) {
        rgb[i] = v_tissue_floats(p->m, label,
                                 offsetof(sc_march_tissue, rgb) + (size_t)i * sizeof(float), on);
        spot.normal[i] = p->ray.eye[i];
    }
    v_remember_surface(&p->light, label, alpha, &spot, p->ray.seeks, m_and(on, p->ray.seeks));
    v_blend(&p->light, rgb, alpha, p->ray.seeks, on);
}

/* See sc_voxel_normal: the normals of boundary voxels, to @p n. */
static void v_voxel_normal(const sc_march *m, vi record, const vi voxel[3], const vf eye[3],
                           vf n[3])
{
    const vm none = i_equal(record, i_set(0));
    vf length;

    v_record_normal(record, n);
    for (int k = 0; k < 3; k++)
        n[k] = f_pick(none, f_set(0), n[k]);
    for (int i = 0; i < 3; i++) {
        const float *row = m->grid_per_mm[i];
        const float across = SC_RECORD_LENGTH_STEPS / sqrtf(sc_dot3(row, row));
        const vm first = i_equal(voxel[i], i_set(0));
        const vm last = i_equal(voxel[i], i_set(m->volume->size[i] - 1));

        for (int k = 0; k < 3; k++)
            n[k] = f_pick(first, n[k] - row[k] * across, n[k]);
        for (int k = 0; k < 3; k++)
            n[k] = f_pick(last, n[k] + row[k] * across, n[k]);
    }
    length = f_length(n);
    for (int i = 0; i < 3; i++)
        n[i] = f_pick(f_below(f_set(0), length), n[i] / length, eye[i]);
}

/* Add the present samples of the lanes of @p on, which are of boundary voxels, to the light; see
 * add_boundary() of march_voxel_tmpl.c. @p at: their positions in grid coordinates plus 1/2.
 * @p near: indices in the thickness. */
static void v_add_boundary(packet *p, vi label, const vf at[3], vi near, vm on)
{
    v_spot spot;
    vf rgb[3], alpha;
    vi voxel[3];

    for (int i = 0; i < 3; i++) {
        spot.eye[i] = p->ray.eye[i];
        spot.point[i] = at[i] - 0.5f;
        voxel[i] = i_of(at[i]) - 1;
    }
    v_voxel_normal(p->m, v_voxel_record(p->m->volume, voxel, on), voxel, p->ray.eye, spot.normal);
    v_face_eye(p->ray.eye, spot.normal);
    spot.depth_mm = p->ray.base_mm + v_distance(p, p->k);
    spot.rim = f_set(0);
    spot.has_around = m_of_bits(0);
    for (int i = 0; i < 3; i++)
        spot.around[i] = f_set(0);
    alpha = v_boundary_alpha(p->m, label, near, on);
    v_light_spot(p->m, &spot, on);
    v_light(p->m, label, &spot, on, rgb);
    v_remember_surface(&p->light, label, alpha, &spot, p->ray.seeks, on);
    v_blend(&p->light, rgb, alpha, p->ray.seeks, on);
}

/* Stop the rays of the lanes of @p on before their present samples. */
static void stop_rays(packet *p, vm on)
{
    for (uint32_t left = m_bits(on); left; left &= left - 1) {
        const int lane = __builtin_ctz(left);

        p->ways[lane].walks = true;
        p->ways[lane].at[0] = p->k[lane];
    }
    p->alive = m_without(p->alive, on);
}

/* Add the present samples of the lanes of @p on, which are marked, to the light, as far as they
 * have not faded away, their clip sets are kept, and rays do not stop before them. */
static void add_samples(packet *p, vm on)
{
    const vf t = v_distance(p, p->k);
    vf at[3];
    vi voxel[3], label, bytes, near;
    vm boundary;

    for (int i = 0; i < 3; i++) {
        at[i] = p->ray.origin[i] + p->ray.direction[i] * t;
        voxel[i] = i_of(at[i]) - 1;
    }
    label = v_label_at(p->m->volume, voxel, on);
    bytes = v_tissue_bytes(p->m, label, on);
    on = v_in_kept_set(bytes, p->kept, v_shows(bytes, SC_SHOW_BOUNDARY | SC_SHOW_INTERIOR, on));
    if (p->ways) {
        const vm passed = v_pass(p->ways, p->ray.base_mm + t, &p->limit_mm, on);

        stop_rays(p, m_without(on, passed));
        on = passed;
    }
    p->counters.contributions += m_count(on);
    boundary = v_find_marked(p->m->volume, p->m->volume->boundary.masks,
                             p->m->volume->boundary.start, voxel, on, &near);
    if (m_any(m_without(on, boundary)))
        add_interior(p, label, m_without(on, boundary));
    if (m_any(boundary))
        v_add_boundary(p, label, at, near, boundary);
}

/* The clip sets that are kept from sample @p k on to the next event: bit i for clip set i. */
static int32_t clip_sets_kept(const sc_ray *ray, int k)
{
    int32_t sets = 0;

    for (int g = 0; g < ray->clip_sets; g++)
        sets |= kept(ray, g, k) ? 1 << g : 0;
    return sets;
}

/* Add the cut faces before sample @p k of a lane, unless its ray is to stop before them. @return
 * false if it has stopped. */
static bool pass_lane_caps(packet *p, int lane, int k)
{
    cursor c = {.m = p->m,
                .ray = &p->rays[lane],
                .way = p->ways ? &p->ways[lane] : NULL,
                .limit_mm = p->limit_mm[lane],
                .light = v_radiance_get_lane(&p->light, lane)};
    const bool passed = pass_caps_before(&c, k);

    v_radiance_set_lane(&p->light, lane, &c.light);
    p->limit_mm[lane] = c.limit_mm;
    p->counters.contributions += c.contributions;
    return passed;
}

/* Begin the next part of the rays of @p on, with the cut faces at its beginning: sets k, last,
 * kept and last_end. Rays that have none left, or are opaque, leave p->alive. */
static void begin_parts(packet *p, vm on)
{
    uint32_t begun = 0;

    for (uint32_t left = m_bits(on); left; left &= left - 1) {
        const int lane = __builtin_ctz(left);
        const sc_ray *ray = &p->rays[lane];
        sc_way *way = p->ways ? &p->ways[lane] : NULL;
        const bool goes_on = way && way->walks;
        int k, last;

        if (p->light.transmittance[lane] < p->ray.ends_below[lane] ||
            !next_part(ray, p->last_end[lane], &k, &last))
            continue;
        if (way) {
            way->at[1] = p->last_end[lane];
            way->walks = false;
        }
        if (p->m->cut_faces.are_drawn && p->m->planes.count && !goes_on &&
            !pass_lane_caps(p, lane, k))
            continue;
        begun |= 1u << lane;
        last = next_event(ray, k, last);
        p->last_end[lane] = last;
        p->k[lane] = goes_on ? way->at[0] : k > p->nearest[lane] ? k : p->nearest[lane];
        p->last[lane] = p->m->cut_faces.only       ? p->k[lane]
                        : last < p->farthest[lane] ? last
                                                   : p->farthest[lane];
        p->kept[lane] = clip_sets_kept(ray, k);
    }
    p->alive = m_or(m_without(p->alive, on), m_of_bits(begun));
}

/* Load the rays [0, @p count) into the packet, at most LANES, and begin their first parts; lanes
 * beyond are not alive. @p rays and @p ways stay borrowed until the next call. p->m has been set.
 * @param ways NULL, or of the rays. @param light with ways: what the rays have brought back so far.
 */
static void start_packet(packet *p, const sc_ray *rays, sc_way *ways, const sc_radiance *light,
                         int count)
{
    const vm all = m_of_bits((1u << count) - 1);
    vf near, far;

    p->rays = rays;
    p->ways = ways;
    p->light = v_no_light();
    p->alive = m_none();
    p->place = v_first_place();
    if (!count)
        return;
    if (ways) {
        p->limit_mm = v_begin_ways(ways, count, all);
        v_radiance_read(&p->light, light, count);
    }
    v_load_rays(p->m, rays, all, &p->ray);
    for (int i = 0; i < 3; i++) {
        const vf d = p->ray.direction[i];
        const vm parallel = m_and(f_below(f_set(-SC_PARALLEL), d), f_below(d, f_set(SC_PARALLEL)));

        p->ray.inverse[i] = f_pick(parallel, f_set(SC_NEVER_MM), 1 / d);
        p->ray.forward[i] = m_or(parallel, f_below(f_set(0), d));
    }
    p->ray.mm_per_city_block =
        1 / (f_abs(p->ray.direction[0]) + f_abs(p->ray.direction[1]) + f_abs(p->ray.direction[2]));
    v_clip_to_box(p->m, p->ray.origin, p->ray.inverse, 0.5f, &near, &far);
    p->nearest = i_ceil(near / p->m->step_mm - 0.5f);
    p->farthest = i_pick(f_below(near, far), i_ceil(far / p->m->step_mm - 0.5f), p->nearest);
    for (int lane = 0; lane < LANES; lane++)
        p->last_end[lane] = ways && lane < count ? ways[lane].at[1] : INT32_MIN;
    p->k = p->last = p->kept = i_set(0);
    begin_parts(p, all);
}

/* Add the samples of p->found and go on by one, and begin the next part in living lanes that
 * have neither found a sample nor are walking. */
static void add_found(packet *p)
{
    vm over;

    if (m_any(p->found)) {
        add_samples(p, p->found);
        p->k = i_pick(p->found, p->k + 1, p->k);
    }
    over = m_without(m_without(p->alive, p->found), p->walking);
    if (m_any(over))
        begin_parts(p, over);
}

/* Set the march of a packet and clear its counters. */
static void init_packet(packet *p, const sc_march *march)
{
    p->m = march;
    p->limit_mm = f_set(0);
    p->counters = (sc_march_counters){0};
}

#include "wide_loop.h"
