/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: cell.h for one cell per SIMD lane. Cells of two labels that are crossed at
 * most once, which nearly all cells are, are handled side by side; the others one by one, by
 * cell.h. A function does the same operations in the same order as its namesake there (v_x for sc_x
 * or sc_cell_x), so that every lane gets the same bits. In all of them @p on are the lanes in use.
 */
#ifndef SC_KERNEL_LANES_CELL_H
#define SC_KERNEL_LANES_CELL_H

#include "cell.h"
#include "lanes/lanes_brick.h"

/* Read the records at the corners of the cells @p q, of the outer field in the lanes of @p outer,
 * else of the inner one, to @p out; 0 in lanes outside of @p on. One by one, which is faster than
 * to gather. */
static inline void v_cell_records(const sc_prepared *v, const vi q[3], vm outer, vm on,
                                  vi out[SC_CORNERS])
{
    const uint32_t is_outer = m_bits(outer);

    memset(out, 0, SC_CORNERS * sizeof *out);
    for (uint32_t left = m_bits(on); left; left &= left - 1) {
        const int lane = __builtin_ctz(left);
        const int at[3] = {q[0][lane], q[1][lane], q[2][lane]};
        uint32_t records[SC_CORNERS];

        (void)sc_cell_records(v, is_outer >> lane & 1 ? &v->outer : &v->inner, at, records);
        for (int i = 0; i < SC_CORNERS; i++)
            out[i][lane] = (int32_t)records[i];
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

/* The length of the gradient of a vertex record; see sc_record_eighths of brick.h. */
static inline vf v_record_eighths(vi record)
{
    return f_of((vi)((vu)record >> SC_RECORD_LENGTH_SHIFT) + 1);
}

/* The gradient of a vertex record: its direction times its length; see sc_record_normal of
 * brick.h. */
static inline void v_record_normal(vi record, vf out[3])
{
    vf share;

    v_record_octant(record, out);
    share = v_record_eighths(record) / f_sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2]);
    for (int i = 0; i < 3; i++)
        out[i] *= share;
}

/* The trilinear weight, 0 to 1, of corner number @p corner at the point @p a of the cell. */
static inline vf v_corner_share(int corner, const vf a[3])
{
    return (corner & 1 ? a[0] : 1 - a[0]) * (corner & 2 ? a[1] : 1 - a[1]) *
           (corner & 4 ? a[2] : 1 - a[2]);
}

#endif
