/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: a cell of the smooth surface model, the cube between 2x2x2 neighbouring grid
 * vertices, and the crossings that a straight line makes in it.
 *
 * At a point, each label's vote is the trilinear sum of the weights of the corners that carry it,
 * and the largest vote owns the point; of equal votes the lower id wins. Along a line the
 * difference of two votes is a cubic. Its Bernstein coefficients come from the corners of the box
 * that the line spans. If their signs do not change, neither does the owner; two changes within a
 * cell (a thin sheet) are separated by the extrema of the cubic.
 *
 * On a face shared by two cells both compute the same bits, because interpolation by 0 and 1 is
 * exact and labels that are not on the face have no vote there. So no ray slips through between
 * cells. */
#ifndef SC_KERNEL_CELL_H
#define SC_KERNEL_CELL_H

#include "segcast/kernel.h"

enum { SC_CORNERS = 8 }; /* corner x + 2 y + 4 z */

/* One cell. The caller sets q; sc_cell_labels fills in the labels, and sc_cell_fill the rest of
 * those cells whose labels differ. */
typedef struct sc_cell {
    int q[3];                      /* the lowest grid vertex, which names the cell */
    uint32_t labels[SC_CORNERS];   /* dense ids */
    uint32_t records[SC_CORNERS];  /* vertex records; only the lower 24 bits count */
    float weights[SC_CORNERS];     /* of the votes: 1 to SC_WEIGHT_MAX */
    uint32_t distinct[SC_CORNERS]; /* the different labels, in rising order */
    int distinct_count;
    size_t record_index[SC_CORNERS]; /* of records, in sc_prepared.records */
    unsigned border; /* which faces of the volume pass through the middle of the cell, as bits: bit
                        i where axis i begins, bit 3 + i where it ends; beyond them is background */
    uint8_t ends[SC_CORNERS]; /* only if there is a border: sc_end_at_vertex of the corners outside
                                 of the volume, 0 of all others */
} sc_cell;

/* A point where the owner changes from one label (dense id) to another. */
typedef struct sc_crossing {
    uint32_t left, entered;
    float u;  /* how far along the way through the cell: 0 to 1 */
    int face; /* 0, or 1 + axis: this is a face of the volume, across that axis */
} sc_crossing;
enum {
    SC_CROSSINGS_WITHIN = 24, /* between labels of the volume */
    SC_CROSSINGS_MAX = SC_CROSSINGS_WITHIN + 2
};

/* The search for a root ends after so many steps, or where the difference of the votes (of weights
 * up to SC_WEIGHT_MAX) is as small as this. Guesses stay this share of the interval away from its
 * ends. */
#define SC_ROOT_STEPS_MAX 16
#define SC_ROOT_TOLERANCE 0.002f
#define SC_ROOT_MARGIN 0.02f
/* The cells whose corners lie outside of the volume along some axis, but not all of them, are cut
 * in two by a face of the volume. The corners outside of it count as copies of those opposite,
 * which are voxels, so that tissue goes straight on to the face; beyond the face all is background.
 * But where tissue ends before the face (sc_end_at_vertex), the corner is background, of a weight
 * that puts the border between it and the voxel opposite where the tissue ends. */

/* The bits of sc_cell.border for the cell @p q. */
static inline unsigned sc_cell_border(const sc_prepared *v, const int q[3])
{
    unsigned border = 0;

    for (int i = 0; i < 3; i++)
        border |= (q[i] == 0 ? 1u : 0) << i | (q[i] == v->size[i] ? 8u : 0) << i;
    return border;
}

/* The vertex nearest to corner number @p corner of the cell @p q that is a voxel, to @p out. */
static inline void sc_cell_vertex(const sc_prepared *v, const int q[3], int corner, int out[3])
{
    for (int i = 0; i < 3; i++) {
        const int at = q[i] + (corner >> i & 1);

        out[i] = at < 1 ? 1 : at > v->size[i] ? v->size[i] : at;
    }
}

/* The height at which tissue ends at corner number @p corner of the cell @p q, in which there is a
 * voxel; 0 if the corner is not outside of the volume, or tissue goes on there.
 * @param voxel [3] the vertex of the voxel nearest to the corner: see sc_cell_vertex. */
static inline int sc_cell_end(const sc_prepared *v, const int q[3], int corner, const int voxel[3])
{
    const int x = q[0] + (corner & 1), y = q[1] + (corner >> 1 & 1), z = q[2] + (corner >> 2);

    return x == voxel[0] && y == voxel[1] && z == voxel[2] ? 0 : sc_end_at_vertex(v, x, y, z);
}

/* Read the labels at the corners of a cell at the border of the volume, and c->ends; the rest is as
 * in sc_cell_labels. A cell without a voxel is background. */
static inline bool sc_cell_border_labels(const sc_prepared *v, sc_cell *c)
{
    uint32_t any = 0;
    bool outside = false;

    for (int i = 0; i < 3; i++)
        outside = outside || c->q[i] < 0 || c->q[i] > v->size[i];
    c->border = outside ? 0 : sc_cell_border(v, c->q);
    for (int i = 0; i < SC_CORNERS; i++) {
        int at[3];

        sc_cell_vertex(v, c->q, i, at);
        c->labels[i] = outside ? 0 : sc_id_at_vertex(v, at[0], at[1], at[2]);
        c->ends[i] = c->labels[i] ? (uint8_t)sc_cell_end(v, c->q, i, at) : 0;
        any |= c->labels[i];
    }
    for (int i = 0; i < SC_CORNERS; i++)
        c->labels[i] = c->ends[i] ? 0 : c->labels[i];
    return any != 0;
}

/* Read the labels at the corners of the cell c->q into c->labels, and set c->border; nothing else
 * of the cell is changed. @p label_bytes: that of the volume, as a constant of the caller. @return
 * whether there is more than one label in the cell. */
static inline bool sc_cell_labels(const sc_prepared *v, int label_bytes, sc_cell *c)
{
    const int x = c->q[0], y = c->q[1], z = c->q[2];
    const size_t row = (size_t)v->size[0], layer = row * (size_t)v->size[1];
    const size_t base = (size_t)(z - 1) * layer + (size_t)(y - 1) * row + (size_t)(x - 1);
    uint32_t differ = 0;

    if (x < 1 || y < 1 || z < 1 || x >= v->size[0] || y >= v->size[1] || z >= v->size[2])
        return sc_cell_border_labels(v, c);
    c->border = 0;
    for (int i = 0; i < SC_CORNERS; i++) {
        const size_t at = base + (size_t)(i & 1) + (i & 2 ? row : 0) + (i & 4 ? layer : 0);

        c->labels[i] =
            label_bytes == 1 ? ((const uint8_t *)v->ids)[at] : ((const uint16_t *)v->ids)[at];
    }
    for (int i = 1; i < SC_CORNERS; i++)
        differ |= c->labels[i] ^ c->labels[0];
    return differ != 0;
}

/* Set c->weights, c->distinct and c->distinct_count from c->labels, c->records, c->border and
 * c->ends. */
static inline void sc_cell_sort(sc_cell *c)
{
    c->distinct_count = 0;
    for (int i = 0; i < SC_CORNERS; i++) {
        const uint32_t label = c->labels[i];
        int at = 0;

        c->weights[i] = (float)sc_record_weight(c->records[i]);
        if (c->border && c->ends[i]) /* its record is a copy of that of the voxel inside */
            c->weights[i] *= (float)(SC_RECORD_END_STEPS - c->ends[i]) / (float)c->ends[i];
        while (at < c->distinct_count && c->distinct[at] < label)
            at++;
        if (at < c->distinct_count && c->distinct[at] == label)
            continue;
        for (int k = c->distinct_count++; k > at; k--)
            c->distinct[k] = c->distinct[k - 1];
        c->distinct[at] = label;
    }
}

/* Set c->records, c->record_index, c->weights, c->distinct and c->distinct_count. Only for a cell
 * for which sc_cell_labels has returned true: the corners of others may have no vertex records. */
static inline void sc_cell_fill(const sc_prepared *v, sc_cell *c)
{
    for (int i = 0; i < SC_CORNERS; i += 2) {
        int low[3], high[3];

        sc_cell_vertex(v, c->q, i, low);
        sc_cell_vertex(v, c->q, i + 1, high);
        c->record_index[i] = sc_record_index(v, low[0], low[1], low[2]);
        /* All corners of such a cell have records, so that those of neighbours along x in the same
         * brick stand side by side. */
        c->record_index[i + 1] = (low[0] & SC_BRICK_MASK) < SC_BRICK_MASK || high[0] == low[0]
                                     ? c->record_index[i] + (size_t)(high[0] - low[0])
                                     : sc_record_index(v, high[0], high[1], high[2]);
    }
    for (int i = 0; i < SC_CORNERS; i++) {
        c->records[i] = sc_record_read(v->records, c->record_index[i]);
        if (c->border && c->ends[i])
            c->records[i] = sc_record_shortest(c->records[i]);
    }
    sc_cell_sort(c);
}

/* At each corner: the vote of label @p first minus that of label @p second, that is, the weight,
 * the negated weight, or 0 where a third label stands. */
static inline void sc_cell_difference(const sc_cell *c, uint32_t first, uint32_t second,
                                      float out[SC_CORNERS])
{
    for (int n = 0; n < SC_CORNERS; n++)
        out[n] = c->labels[n] == first    ? c->weights[n]
                 : c->labels[n] == second ? -c->weights[n]
                                          : 0;
}

/* Linear interpolation: exactly @p low for @p at 0 and exactly @p high for 1. */
static inline float sc_lerp(float low, float high, float at)
{
    return low * (1 - at) + high * at;
}

/* The value at the point @p a of a cell, each coordinate in [0, 1], of a function given at its
 * corners. */
static inline float sc_trilinear(const float s[SC_CORNERS], const float a[3])
{
    const float y0 = sc_lerp(sc_lerp(s[0], s[1], a[0]), sc_lerp(s[2], s[3], a[0]), a[1]);
    const float y1 = sc_lerp(sc_lerp(s[4], s[5], a[0]), sc_lerp(s[6], s[7], a[0]), a[1]);

    return sc_lerp(y0, y1, a[2]);
}

/* The four Bernstein coefficients of a trilinear function, given by its values @p s at the
 * corners of a cell, along the line from the point @p a of the cell to @p b. Because the
 * function is linear in each coordinate, its polar form (blossom) takes each coordinate from one
 * end or the other. */
static inline void sc_bernstein(const float s[SC_CORNERS], const float a[3], const float b[3],
                                float out[4])
{
    float x[2][4], xy[2][2][2], f[2][2][2]; /* [end of x][end of y][end of z or corner] */

    for (int row = 0; row < 4; row++) {
        x[0][row] = sc_lerp(s[2 * row], s[2 * row + 1], a[0]);
        x[1][row] = sc_lerp(s[2 * row], s[2 * row + 1], b[0]);
    }
    for (int i = 0; i < 2; i++) {
        for (int z = 0; z < 2; z++) {
            xy[i][0][z] = sc_lerp(x[i][2 * z], x[i][2 * z + 1], a[1]);
            xy[i][1][z] = sc_lerp(x[i][2 * z], x[i][2 * z + 1], b[1]);
        }
        for (int j = 0; j < 2; j++) {
            f[i][j][0] = sc_lerp(xy[i][j][0], xy[i][j][1], a[2]);
            f[i][j][1] = sc_lerp(xy[i][j][0], xy[i][j][1], b[2]);
        }
    }
    out[0] = f[0][0][0];
    out[1] = (f[1][0][0] + f[0][1][0] + f[0][0][1]) * (1.0f / 3);
    out[2] = (f[1][1][0] + f[1][0][1] + f[0][1][1]) * (1.0f / 3);
    out[3] = f[1][1][1];
}

/* The value at @p u in [0, 1] of the cubic with Bernstein coefficients @p b. */
static inline float sc_cubic(const float b[4], float u)
{
    const float v = 1 - u;

    return v * v * (v * b[0] + 3 * u * b[1]) + u * u * (3 * v * b[2] + u * b[3]);
}

/* The root of a cubic between @p low and @p high, where its values @p at_low and @p at_high have
 * different signs: false position with the Illinois rule (Dowell and Jarratt 1971), which does
 * not stall at one end. @return a point strictly between the two: the first that is within
 * SC_ROOT_TOLERANCE, or the last of SC_ROOT_STEPS_MAX guesses. Guesses are kept away from the
 * ends, because on a face that holds neither of the two labels their difference is zero although
 * the owner does not change. */
static inline float sc_root_between(const float b[4], float low, float high, float at_low,
                                    float at_high)
{
    float u = low;
    int side = 0;

    for (int i = 0; i < SC_ROOT_STEPS_MAX; i++) {
        const float margin = SC_ROOT_MARGIN * (high - low);
        float f;

        u = low + (high - low) * (at_low / (at_low - at_high));
        u = u < low + margin ? low + margin : u > high - margin ? high - margin : u;
        f = sc_cubic(b, u);
        if (f > -SC_ROOT_TOLERANCE && f < SC_ROOT_TOLERANCE)
            break;
        if ((f < 0) == (at_low < 0)) {
            low = u;
            at_low = f;
            at_high *= side < 0 ? 0.5f : 1;
            side = -1;
        } else {
            high = u;
            at_high = f;
            at_low *= side > 0 ? 0.5f : 1;
            side = 1;
        }
    }
    return u;
}

/* The points of (0, 1) where the slope of the cubic with Bernstein coefficients @p b changes its
 * sign, in rising order, to @p out. @return how many: 0 to 2. */
static inline int sc_extrema(const float b[4], float out[2])
{
    const float d0 = b[1] - b[0], d1 = b[2] - b[1], d2 = b[3] - b[2];
    const float a = d0 - 2 * d1 + d2, half = d1 - d0, discriminant = half * half - a * d0;
    float q, roots[2];
    int count = 0;

    if (!(discriminant > 0))
        return 0;
    q = half < 0 ? sqrtf(discriminant) - half : -sqrtf(discriminant) - half;
    roots[0] = a != 0 ? q / a : -1;
    roots[1] = q != 0 ? d0 / q : -1;
    if (roots[1] < roots[0]) {
        const float swap = roots[0];

        roots[0] = roots[1];
        roots[1] = swap;
    }
    for (int i = 0; i < 2; i++) {
        if (roots[i] > 0 && roots[i] < 1)
            out[count++] = roots[i];
    }
    return count;
}

/* The points of [0, 1] where the cubic with Bernstein coefficients @p b changes sign (0 counts
 * as positive), in rising order, to @p out. @return how many, 0 to 3; even if and only if the
 * first and the last coefficient have the same sign. */
static inline int sc_sign_changes(const float b[4], float out[3])
{
    const int variations =
        ((b[0] < 0) != (b[1] < 0)) + ((b[1] < 0) != (b[2] < 0)) + ((b[2] < 0) != (b[3] < 0));
    float extrema[2], low = 0, at_low = b[0];
    int count = 0, extremum_count = 0;

    if (variations == 0)
        return 0;
    if (variations > 1)
        extremum_count = sc_extrema(b, extrema);
    for (int i = 0; i <= extremum_count; i++) {
        const float high = i < extremum_count ? extrema[i] : 1;
        const float at_high = i < extremum_count ? sc_cubic(b, high) : b[3];

        if ((at_low < 0) != (at_high < 0))
            out[count++] = sc_root_between(b, low, high, at_low, at_high);
        low = high;
        at_low = at_high;
    }
    return count;
}

/* The dense id of the label that owns the point @p a of the cell, each coordinate in [0, 1]. The
 * cell must have been filled by sc_cell_fill or sc_cell_sort. */
static inline uint32_t sc_cell_owner(const sc_cell *c, const float a[3])
{
    uint32_t best = c->distinct[0];

    for (int k = 1; k < c->distinct_count; k++) {
        float difference[SC_CORNERS];

        sc_cell_difference(c, best, c->distinct[k], difference);
        if (sc_trilinear(difference, a) < 0)
            best = c->distinct[k];
    }
    return best;
}

/* How far the point @p a of the cell lies inside of the volume, along axis @p i, in voxels;
 * negative outside. c->border must have a bit of that axis. */
static inline float sc_cell_inside(const sc_cell *c, int i, const float a[3])
{
    return c->border >> i & 1 ? a[i] - 0.5f : 0.5f - a[i];
}

/* The dense id of the label that owns the point @p a of the cell, by sc_cell_owner and the border
 * of the volume. */
static inline uint32_t sc_cell_owner_at(const sc_cell *c, const float a[3])
{
    for (int i = 0; i < 3; i++) {
        if ((c->border | c->border >> 3) >> i & 1 && sc_cell_inside(c, i, a) < 0)
            return 0;
    }
    return sc_cell_owner(c, a);
}

/* Find the first point after *@p u, on the way from @p a (0) to @p b (1), where another label
 * takes over from @p owner, and set *@p u to it. @return that label, or @p owner if there is
 * none, with *@p u unchanged. */
static inline uint32_t sc_next_owner(const sc_cell *c, const float a[3], const float b[3],
                                     uint32_t owner, float *u)
{
    uint32_t next = owner;
    float first = 2;

    for (int k = 0; k < c->distinct_count; k++) {
        float difference[SC_CORNERS], coefficients[4], changes[3];
        const uint32_t other = c->distinct[k];
        /* Always the lower label minus the higher, so that rays in both directions find the same
         * point. */
        const uint32_t low = owner < other ? owner : other, high = owner < other ? other : owner;
        bool low_owns;
        int count;

        if (other == owner)
            continue;
        sc_cell_difference(c, low, high, difference);
        sc_bernstein(difference, a, b, coefficients);
        count = sc_sign_changes(coefficients, changes);
        low_owns = !(coefficients[0] < 0);
        for (int i = 0; i < count; i++) {
            low_owns = !low_owns;
            if (low_owns == (other == low) && changes[i] > *u && changes[i] < first) {
                first = changes[i];
                next = other;
            }
        }
    }
    if (next != owner)
        *u = first;
    return next;
}

/* List the crossings between labels of the volume on the way from the point @p a of the cell to its
 * point @p b; the rest is as in sc_cell_crossings. */
static inline int sc_crossings_within(const sc_cell *c, const float a[3], const float b[3],
                                      sc_crossing out[SC_CROSSINGS_WITHIN])
{
    uint32_t owner, last;
    float u = -1;
    int count = 0;

    if (c->distinct_count == 2) {
        float difference[SC_CORNERS], coefficients[4], changes[3];
        int side;

        sc_cell_difference(c, c->distinct[0], c->distinct[1], difference);
        sc_bernstein(difference, a, b, coefficients);
        count = sc_sign_changes(coefficients, changes);
        side = coefficients[0] < 0;
        for (int i = 0; i < count; i++, side ^= 1)
            out[i] = (sc_crossing){c->distinct[side], c->distinct[side ^ 1], changes[i], 0};
        return count;
    }
    owner = sc_cell_owner(c, a);
    last = sc_cell_owner(c, b);
    while (count < SC_CROSSINGS_WITHIN - 1) {
        const uint32_t next = sc_next_owner(c, a, b, owner, &u);

        if (next == owner)
            break;
        out[count++] = (sc_crossing){owner, next, u, 0};
        owner = next;
    }
    if (owner != last) /* rounding hid the last change; the next cell will start from this owner */
        out[count++] = (sc_crossing){owner, last, 1, 0};
    return count;
}

/* The part of the way from the point @p a of the cell to its point @p b that lies inside of the
 * volume, from share u[0] to share u[1], and the faces (of sc_crossing) at which it begins and
 * ends; 0 where it begins at @p a or ends at @p b. @return false if it all lies outside. */
static inline bool sc_part_inside(const sc_cell *c, const float a[3], const float b[3], float u[2],
                                  int faces[2])
{
    u[0] = 0;
    u[1] = 1;
    faces[0] = faces[1] = 0;
    for (int i = 0; i < 3; i++) {
        float at[2], share;

        if (!((c->border | c->border >> 3) >> i & 1))
            continue;
        at[0] = sc_cell_inside(c, i, a);
        at[1] = sc_cell_inside(c, i, b);
        if (at[0] < 0 && at[1] < 0)
            return false;
        share = at[0] / (at[0] - at[1]);
        if (at[0] < 0 && share >= u[0]) {
            u[0] = share;
            faces[0] = 1 + i;
        }
        if (at[1] < 0 && share <= u[1]) {
            u[1] = share;
            faces[1] = 1 + i;
        }
    }
    return u[0] <= u[1];
}

/* List all crossings on the way from the point @p a of the cell to its point @p b, in their
 * order, in @p out. The cell must have been filled by sc_cell_fill or sc_cell_sort. @return how
 * many; 0 if the owner does not change. Should there be more than fit, the last one listed leads
 * to the owner of @p b. */
static inline int sc_cell_crossings(const sc_cell *c, const float a[3], const float b[3],
                                    sc_crossing out[SC_CROSSINGS_MAX])
{
    sc_crossing within[SC_CROSSINGS_WITHIN];
    float ends[2][3], u[2];
    uint32_t first, last;
    int faces[2], count, n = 0;

    if (!c->border)
        return sc_crossings_within(c, a, b, out);
    if (!sc_part_inside(c, a, b, u, faces))
        return 0;
    for (int i = 0; i < 3; i++) {
        for (int e = 0; e < 2; e++)
            ends[e][i] = faces[e] ? sc_lerp(a[i], b[i], u[e]) : e ? b[i] : a[i];
    }
    count = sc_crossings_within(c, ends[0], ends[1], within);
    first = count ? within[0].left : sc_cell_owner(c, ends[0]);
    last = count ? within[count - 1].entered : first;
    if (faces[0] && first)
        out[n++] = (sc_crossing){0, first, u[0], faces[0]};
    for (int i = 0; i < count; i++) {
        out[n] = within[i];
        out[n++].u = u[0] + (u[1] - u[0]) * within[i].u;
    }
    if (faces[1] && last)
        out[n++] = (sc_crossing){last, 0, u[1], faces[1]};
    return n;
}

/* The slope along each axis, per voxel, of the trilinear function with values @p s at the corners,
 * at the point @p a, to @p slope. */
static inline void sc_cell_slope(const float s[SC_CORNERS], const float a[3], float slope[3])
{
    for (int i = 0; i < 3; i++) {
        float ends[2][3];

        for (int e = 0; e < 2; e++) {
            for (int j = 0; j < 3; j++)
                ends[e][j] = j == i ? (float)e : a[j];
        }
        slope[i] = sc_trilinear(s, ends[1]) - sc_trilinear(s, ends[0]);
    }
}

#endif
