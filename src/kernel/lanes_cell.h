/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: cell.h for one cell per SIMD lane. Cells of two labels that are crossed at
 * most once, which nearly all cells are, are handled side by side; the others one by one, by
 * cell.h. A function does the same operations in the same order as its namesake there (v_x for sc_x
 * or sc_cell_x), so that every lane gets the same bits. In all of them @p on are the lanes in use.
 */
#ifndef SC_KERNEL_LANES_CELL_H
#define SC_KERNEL_LANES_CELL_H

#include "cell.h"
#include "lanes_brick.h"

/* One cell per lane: see sc_cell, and the indices of the vertex records in sc_prepared.records.
 * v_cell_labels and v_cell_fill fill in the rest from q. */
typedef struct v_cell {
    vi q[3];
    vi labels[SC_CORNERS], records[SC_CORNERS], record_index[SC_CORNERS];
} v_cell;

/* @p x limited to [1, @p last]: the nearest vertex that is a voxel. */
static inline vi v_nearest(vi x, int last)
{
    x = i_pick(i_below(x, i_set(1)), i_set(1), x);
    return i_pick(i_below(i_set(last), x), i_set(last), x);
}

/* Read the labels of the two corners of a cell at x and x + 1 in row (y, z) at once, to @p
 * out[0] and @p out[1]; outside of the volume, those of the nearest voxels; 0 in lanes outside of
 * @p on. */
static inline void v_row_labels(const sc_prepared *v, int label_bytes, vi x, vi y, vi z, vm on,
                                vi out[2])
{
    const int row = v->size[0], layer = row * v->size[1];
    const vi first = v_nearest(x, row);
    const vi at = (v_nearest(z, v->size[2]) - 1) * layer + (v_nearest(y, v->size[1]) - 1) * row;
    const vi two = i_gather(v->ids, (at + first - 1) * label_bytes, on);
    const int bits = 8 * label_bytes;
    const vi low = two & ((1 << bits) - 1), next = two >> bits & ((1 << bits) - 1);

    out[0] = low;
    out[1] = i_pick(i_equal(v_nearest(x + 1, row), first), low, next);
}

/* Read the labels at the corners of the cells c->q, which hold a voxel each, into c->labels; 0 in
 * lanes outside of @p on. */
static inline void v_cell_labels(const sc_prepared *v, int label_bytes, v_cell *c, vm on)
{
    for (int i = 0; i < SC_CORNERS; i += 2)
        v_row_labels(v, label_bytes, c->q[0], c->q[1] + (i >> 1 & 1), c->q[2] + (i >> 2), on,
                     &c->labels[i]);
}

/* Indices of the vertex records of grid vertices, which must be near an interface in the lanes
 * of @p on. */
static inline vi v_record_index(const sc_prepared *v, vi x, vi y, vi z, vm on)
{
    const vi brick = v_brick_index(v->bricks, x, y, z);
    vi half;

    return v_packed_index(v->near, v->near_start, brick, v_half_bit(x, y, z), z, on, &half);
}

/* Set c->record_index and c->records of the cells c->q, which must hold more than one label in
 * the lanes of @p on; in other lanes both are meaningless. */
static inline void v_cell_fill(const sc_prepared *v, v_cell *c, vm on)
{
    const vi low = v_nearest(c->q[0], v->size[0]), high = v_nearest(c->q[0] + 1, v->size[0]);
    const vm last = m_and(on, i_equal(low & SC_BRICK_MASK, i_set(SC_BRICK_MASK)));
    const vm across = m_without(last, i_equal(low, high));

    for (int i = 0; i < SC_CORNERS; i += 2) {
        const vi y = v_nearest(c->q[1] + (i >> 1 & 1), v->size[1]);
        const vi z = v_nearest(c->q[2] + (i >> 2), v->size[2]);

        c->record_index[i] = v_record_index(v, low, y, z, on);
        c->record_index[i + 1] = c->record_index[i] + (high - low);
        if (m_any(across))
            c->record_index[i + 1] =
                i_pick(across, v_record_index(v, high, y, z, across), c->record_index[i + 1]);
    }
    for (int i = 0; i < SC_CORNERS; i++)
        c->records[i] = i_gather(v->records, c->record_index[i] * SC_RECORD_BYTES, on);
}

/* Set labels and records of the cells of the lanes of @p on, which have been filled and in which
 * tissue ends (SC_CELL_ENDS), as sc_cell_fill does. */
static inline void v_cell_set_ends(const sc_prepared *v, v_cell *c, vm on)
{
    for (uint32_t left = m_bits(on); left; left &= left - 1) {
        const int lane = __builtin_ctz(left);
        sc_cell one;

        for (int i = 0; i < 3; i++)
            one.q[i] = c->q[i][lane];
        (void)sc_cell_border_labels(v, &one);
        for (int i = 0; i < SC_CORNERS; i++) {
            if (!one.ends[i])
                continue;
            c->labels[i][lane] = 0;
            c->records[i][lane] = (int32_t)sc_record_shortest((uint32_t)c->records[i][lane]);
        }
    }
}

/* Copy the cell of one lane to @p out, with its weights, distinct labels and border, for the
 * functions of cell.h. @param ends whether tissue ends in it. */
static inline void v_cell_get_lane(const sc_prepared *v, const v_cell *c, int lane, bool ends,
                                   sc_cell *out)
{
    for (int i = 0; i < 3; i++)
        out->q[i] = c->q[i][lane];
    if (ends) {
        (void)sc_cell_border_labels(v, out);
        sc_cell_fill(v, out);
        return;
    }
    for (int i = 0; i < SC_CORNERS; i++) {
        out->labels[i] = (uint32_t)c->labels[i][lane];
        out->records[i] = (uint32_t)c->records[i][lane];
        out->record_index[i] = (size_t)c->record_index[i][lane];
        out->ends[i] = 0;
    }
    out->border = sc_cell_border(v, out->q);
    sc_cell_sort(out);
}

/* The lowest and the highest label of each cell, from c->labels. */
static inline void v_label_range(const v_cell *c, vi *low, vi *high)
{
    *low = *high = c->labels[0];
    for (int i = 1; i < SC_CORNERS; i++) {
        *low = i_pick(i_below(c->labels[i], *low), c->labels[i], *low);
        *high = i_pick(i_below(*high, c->labels[i]), c->labels[i], *high);
    }
}

/* The Bernstein coefficients of sc_bernstein: of the function with values @p s at the corners,
 * along the line from @p a to @p b. */
static inline void v_bernstein(const vf s[SC_CORNERS], const vf a[3], const vf b[3], vf out[4])
{
    vf x[2][4], xy[2][2][2], f[2][2][2];

    for (int row = 0; row < 4; row++) {
        x[0][row] = f_lerp(s[2 * row], s[2 * row + 1], a[0]);
        x[1][row] = f_lerp(s[2 * row], s[2 * row + 1], b[0]);
    }
    for (int i = 0; i < 2; i++) {
        for (int z = 0; z < 2; z++) {
            xy[i][0][z] = f_lerp(x[i][2 * z], x[i][2 * z + 1], a[1]);
            xy[i][1][z] = f_lerp(x[i][2 * z], x[i][2 * z + 1], b[1]);
        }
        for (int j = 0; j < 2; j++) {
            f[i][j][0] = f_lerp(xy[i][j][0], xy[i][j][1], a[2]);
            f[i][j][1] = f_lerp(xy[i][j][0], xy[i][j][1], b[2]);
        }
    }
    out[0] = f[0][0][0];
    out[1] = (f[1][0][0] + f[0][1][0] + f[0][0][1]) * (1.0f / 3);
    out[2] = (f[1][1][0] + f[1][0][1] + f[0][1][1]) * (1.0f / 3);
    out[3] = f[1][1][1];
}

/* The value at @p u of the cubic with Bernstein coefficients @p b. */
static inline vf v_cubic(const vf b[4], vf u)
{
    const vf v = 1 - u;

    return v * v * (v * b[0] + 3 * u * b[1]) + u * u * (3 * v * b[2] + u * b[3]);
}

/* How often the sign changes from one Bernstein coefficient to the next: 0 to 3; 0 counts as
 * positive. */
static inline vi v_variations(const vf b[4])
{
    vi count = {0};

    for (int i = 0; i < 3; i++) {
        const vm a = f_below(b[i], f_set(0)), c = f_below(b[i + 1], f_set(0));

        count = i_pick(m_or(m_without(a, c), m_without(c, a)), count + 1, count);
    }
    return count;
}

/* The root of a cubic between 0 and 1 by sc_root_between, in the lanes of @p on, where the first
 * and the last coefficient must have different signs; 0 in other lanes. */
static inline vf v_root(const vf b[4], vm on)
{
    vf low = {0}, high = f_set(1), at_low = b[0], at_high = b[3], u = {0};
    vi side = {0};

    for (int i = 0; i < SC_ROOT_STEPS_MAX && m_any(on); i++) {
        const vf margin = SC_ROOT_MARGIN * (high - low);
        const vf guess = low + (high - low) * (at_low / (at_low - at_high));
        vf f;
        vm to_low, to_high, a;

        u = f_pick(on,
                   f_pick(f_below(guess, low + margin), low + margin,
                          f_pick(f_below(high - margin, guess), high - margin, guess)),
                   u);
        f = v_cubic(b, u);
        on = m_without(
            on, m_and(f_below(f_set(-SC_ROOT_TOLERANCE), f), f_below(f, f_set(SC_ROOT_TOLERANCE))));
        a = f_below(at_low, f_set(0));
        to_high = m_or(m_without(f_below(f, f_set(0)), a), m_without(a, f_below(f, f_set(0))));
        to_low = m_without(on, to_high);
        to_high = m_and(on, to_high);
        at_high = f_pick(m_and(to_low, i_below(side, i_set(0))), at_high * 0.5f, at_high);
        at_low = f_pick(m_and(to_high, i_below(i_set(0), side)), at_low * 0.5f, at_low);
        low = f_pick(to_low, u, low);
        at_low = f_pick(to_low, f, at_low);
        high = f_pick(to_high, u, high);
        at_high = f_pick(to_high, f, at_high);
        side = i_pick(to_low, i_set(-1), i_pick(to_high, i_set(1), side));
    }
    return u;
}

/* The field of @p bits bits from bit @p shift of @p word on, taken as a signed number. */
static inline vi v_signed_field(vi word, int shift, int bits)
{
    return (word << (32 - bits - shift)) >> (32 - bits);
}

/* The direction of a vertex record, as a point of an octahedron (not of unit length); see
 * sc_record_octant of brick.h. */
static inline void v_record_octant(vi record, vf out[3])
{
    const vf x = f_of(v_signed_field(record, SC_RECORD_X_SHIFT, SC_RECORD_OCTANT_BITS));
    const vf y = f_of(v_signed_field(record, SC_RECORD_Y_SHIFT, SC_RECORD_OCTANT_BITS));
    const vf z = SC_RECORD_OCTANT_ONE - f_abs(x) - f_abs(y);
    const vf fold = f_pick(f_below(z, f_set(0)), -z, f_set(0));

    out[0] = f_pick(f_below(x, f_set(0)), x + fold, x - fold);
    out[1] = f_pick(f_below(y, f_set(0)), y + fold, y - fold);
    out[2] = z;
}

/* The gradient of a vertex record: its direction times its length; see sc_record_normal of
 * brick.h. */
static inline void v_record_normal(vi record, vf out[3])
{
    vf inverse;
    vi code;

    v_record_octant(record, out);
    code = record >> SC_RECORD_LENGTH_SHIFT & SC_RECORD_LENGTH_MASK;
    code = i_pick(i_below(code, i_set(SC_RECORD_SHORTEST)), code,
                  2 * (SC_RECORD_LENGTH_MASK + 2 - code));
    inverse =
        1 / (f_of(i_set(1) << code) * f_sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2]));
    for (int i = 0; i < 3; i++)
        out[i] *= inverse;
}

/* The trilinear weight, 0 to 1, of corner number @p corner at the point @p a of the cell. */
static inline vf v_corner_share(int corner, const vf a[3])
{
    return (corner & 1 ? a[0] : 1 - a[0]) * (corner & 2 ? a[1] : 1 - a[1]) *
           (corner & 4 ? a[2] : 1 - a[2]);
}

#endif
