/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: a cell of the smooth surface model, the cube between 2x2x2 neighbouring grid
 * vertices, and the crossings that a straight line makes in it.
 *
 * sc_prepared tells who owns a point: the sign of the outer field decides between background and
 * tissue, and among tissues the largest vote. Equal votes go to the lower id, and 0 in the outer
 * field, therefore, to the background. Along a line the outer field and the difference of two votes
 * are cubics. Their Bernstein coefficients come from the corners of the box that the line spans. If
 * the signs of these do not change, neither does the owner; two changes within a cell (a thin
 * sheet) are separated by the extrema of the cubic.
 *
 * On a face shared by two cells both compute the same bits, because interpolation by 0 and 1 is
 * exact and tissues that are not on the face have no vote there. So no ray slips through between
 * cells. */
#ifndef SC_KERNEL_CELL_H
#define SC_KERNEL_CELL_H

#include "segcast/kernel.h"

#include <string.h>

enum { SC_CORNERS = 8, SC_ALL_CORNERS = 0xff }; /* corner x + 2 y + 4 z, and bits for all of them */

/* One cell. The caller sets q, and sc_cell_read the rest. */
typedef struct sc_cell {
    int q[3];        /* the lowest grid vertex, which names the cell */
    unsigned border; /* which faces of the volume pass through the middle of the cell, as bits: bit
                        i where axis i begins, bit 3 + i where it ends; beyond them is background */
    unsigned background;           /* the corners on the side of the background, as bits */
    uint32_t distinct[SC_CORNERS]; /* dense ids of the different tissues, in rising order */
    int distinct_count;
    /* only if there are corners on both sides */
    uint32_t outer_records[SC_CORNERS];
    float outer[SC_CORNERS]; /* of the outer field, but negative on the side of tissue */
    /* only if there are several tissues */
    uint32_t inner_records[SC_CORNERS], labels[SC_CORNERS]; /* labels: the tissues of the corners */
    float inner[SC_CORNERS];                                /* weights of the votes of these */
} sc_cell;

/* A point where the owner changes from one label (dense id) to another. */
typedef struct sc_crossing {
    uint32_t left, entered;
    float u;  /* how far along the way through the cell: 0 to 1 */
    int face; /* 0, or 1 + axis: this is a face of the volume, across that axis */
} sc_crossing;
enum {
    SC_OUTER_CROSSINGS = 3,  /* of the outer field: a cubic has no more roots */
    SC_INNER_CROSSINGS = 16, /* from one tissue to another */
    SC_CROSSINGS_WITHIN = SC_OUTER_CROSSINGS + SC_INNER_CROSSINGS,
    SC_CROSSINGS_MAX = SC_CROSSINGS_WITHIN + 2 /* and two faces of the volume */
};

/* The search for a root ends after so many steps, or where the value (which is up to SC_VALUE_MAX,
 * and changes by SC_BORDER_STEPS over a voxel) is as small as this. Guesses stay this share of the
 * interval away from its ends. */
#define SC_ROOT_STEPS_MAX 16
#define SC_ROOT_TOLERANCE 0.005f
#define SC_ROOT_MARGIN 0.02f
/* The cells whose corners lie outside of the volume along some axis, but not all of them, are cut
 * in two by a face of the volume, beyond which all is background. */

/* Read the records of one field at the corners of the cell @p q, which must lie in the label grid,
 * to
 * @p out; 0: there is none. @return whether all have one. */
static inline bool sc_cell_records(const sc_prepared *v, const sc_border *b, const int q[3],
                                   uint32_t out[SC_CORNERS])
{
    const bool across = sc_brick_of(q[0] + 1) != sc_brick_of(q[0]);
    bool all = true;

    for (int i = 0; i < SC_CORNERS; i += 2) {
        const int y = q[1] + (i >> 1 & 1), z = q[2] + (i >> 2), bit = sc_brick_bit(q[0], y, z);
        const size_t brick =
            sc_brick_index(v->bricks, sc_brick_of(q[0]), sc_brick_of(y), sc_brick_of(z));
        const uint64_t mask = b->masks[brick];
        const uint32_t *at = b->records + b->start[brick] + sc_brick_rank(mask, bit);
        const bool low = mask >> bit & 1;

        /* What stands behind the records may be read: SC_GATHER_BYTES. */
        out[i] = low ? at[0] : 0;
        if (across)
            out[i + 1] = sc_border_record(b, brick + 1, sc_brick_bit(q[0] + 1, y, z));
        else
            out[i + 1] = mask >> bit & 2 ? at[low] : 0;
        all = all && out[i] && out[i + 1];
    }
    return all;
}

/* Set c->distinct and c->distinct_count from c->labels. */
static inline void sc_cell_sort(sc_cell *c)
{
    c->distinct[0] = c->labels[0];
    c->distinct_count = 1;
    for (int i = 1; i < SC_CORNERS; i++) {
        const uint32_t label = c->labels[i];
        int at = 0;

        if (label == c->labels[i - 1])
            continue;
        while (at < c->distinct_count && c->distinct[at] < label)
            at++;
        if (at < c->distinct_count && c->distinct[at] == label)
            continue;
        for (int k = c->distinct_count++; k > at; k--)
            c->distinct[k] = c->distinct[k - 1];
        c->distinct[at] = label;
    }
    if (c->distinct_count > 1 && !c->distinct[0]) { /* a corner without a tissue, and a vote */
        c->distinct_count--;
        memmove(c->distinct, c->distinct + 1, (size_t)c->distinct_count * sizeof c->distinct[0]);
    }
}

/* The dense id of the voxel nearest to the place of a tissue's code, seen from corner @p corner of
 * the cell @p q. */
static inline uint32_t sc_cell_tissue_at(const sc_prepared *v, const int q[3], int corner, int code)
{
    return sc_id_near_vertex(v, q[0] + (corner & 1) + sc_tissue_step(code, 0),
                             q[1] + (corner >> 1 & 1) + sc_tissue_step(code, 1),
                             q[2] + (corner >> 2) + sc_tissue_step(code, 2));
}

/* Read what the outer field says of the cell, if its corners lie on both sides: then all have
 * records. */
static inline void sc_cell_read_outer(const sc_prepared *v, sc_cell *c)
{
    if (!sc_cell_records(v, &v->outer, c->q, c->outer_records))
        return;
    c->background = 0;
    for (int i = 0; i < SC_CORNERS; i++) {
        c->outer[i] = -(float)sc_record_value(c->outer_records[i]);
        c->background |= (c->outer[i] > 0 ? 1u : 0) << i;
    }
}

/* Read what the inner field says of the cell, if its corners do not all have the same tissue: then
 * all have records, unless all lie on the side of the background. */
static inline void sc_cell_read_inner(const sc_prepared *v, sc_cell *c)
{
    if (!sc_cell_records(v, &v->inner, c->q, c->inner_records))
        return;
    for (int i = 0; i < SC_CORNERS; i++) {
        const int code = sc_record_tissue(c->inner_records[i]);

        c->labels[i] = sc_cell_tissue_at(v, c->q, i, code);
        c->inner[i] = c->labels[i] ? (float)sc_record_value(c->inner_records[i]) : 0;
    }
    sc_cell_sort(c);
}

/* The corners of the cell c->q that are voxels of the volume, as bits. */
static inline unsigned sc_cell_voxels(const sc_prepared *v, const sc_cell *c)
{
    unsigned bits = 0;

    for (int i = 0; i < SC_CORNERS; i++)
        bits |=
            (sc_is_voxel(v, c->q[0] + (i & 1), c->q[1] + (i >> 1 & 1), c->q[2] + (i >> 2)) ? 1u : 0)
            << i;
    return bits;
}

/* Read the cell c->q, which may be any. @return whether it is one of those that sc_visible_cells
 * marks if all labels are shown. If not, it belongs to a single label. */
static inline bool sc_cell_read(const sc_prepared *v, sc_cell *c)
{
    const int *q = c->q;
    sc_vertex lowest;

    c->border = 0;
    c->background = SC_ALL_CORNERS;
    for (int i = 0; i < 3; i++) {
        if (q[i] < 0 || q[i] > v->size[i])
            return false;
        c->border |= (q[i] == 0 ? 1u : 0) << i | (q[i] == v->size[i] ? 8u : 0) << i;
    }
    lowest = sc_vertex_at(v, q[0], q[1], q[2]);
    c->background = lowest.outer_value < 0 ? SC_ALL_CORNERS : 0;
    c->distinct[0] = lowest.tissue;
    c->distinct_count = 1;
    if (lowest.outer)
        sc_cell_read_outer(v, c);
    if (c->background == SC_ALL_CORNERS)
        return false;
    if (lowest.inner)
        sc_cell_read_inner(v, c);
    /* The only tissue of a cell may be that of another corner. */
    for (int i = 1; i < SC_CORNERS && c->background && !c->distinct[0]; i++)
        c->distinct[0] = sc_cell_tissue_at(v, q, i, sc_record_tissue(c->outer_records[i]));
    return c->background || c->distinct_count > 1 ||
           (c->border && sc_cell_voxels(v, c) & ~c->background);
}

/* At each corner: the vote of tissue @p first minus that of tissue @p second, that is, the weight,
 * the negated weight, or 0 where a third one stands. */
static inline void sc_cell_difference(const sc_cell *c, uint32_t first, uint32_t second,
                                      float out[SC_CORNERS])
{
    for (int n = 0; n < SC_CORNERS; n++)
        out[n] = c->labels[n] == first ? c->inner[n] : c->labels[n] == second ? -c->inner[n] : 0;
}

/* A function, given at the corners, that is positive where @p owner, a tissue, has the better of @p
 * other, and whose slope tells how far it is to where that ends: to @p out. @param other may be the
 * background. */
static inline void sc_cell_lead(const sc_cell *c, uint32_t owner, uint32_t other,
                                float out[SC_CORNERS])
{
    if (other) {
        sc_cell_difference(c, owner, other, out);
        return;
    }
    for (int n = 0; n < SC_CORNERS; n++)
        out[n] = -c->outer[n];
}

/* The labels beside @p owner in the cell, to @p out. @return how many. */
static inline int sc_cell_others(const sc_cell *c, uint32_t owner, uint32_t out[SC_CORNERS + 1])
{
    int count = 0;

    if (c->background)
        out[count++] = 0;
    for (int k = 0; k < c->distinct_count; k++) {
        if (c->distinct[k] != owner && c->distinct[k])
            out[count++] = c->distinct[k];
    }
    return count;
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

/* The dense id of the tissue with the largest vote at the point @p a of the cell, each coordinate
 * in [0, 1]. */
static inline uint32_t sc_cell_tissue(const sc_cell *c, const float a[3])
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

/* The dense id of the label that owns the point @p a of the cell, but for the border of the
 * volume. */
static inline uint32_t sc_cell_owner(const sc_cell *c, const float a[3])
{
    if (c->background == SC_ALL_CORNERS || (c->background && !(sc_trilinear(c->outer, a) < 0)))
        return 0;
    return sc_cell_tissue(c, a);
}

/* How far the point @p a of the cell lies inside of the volume, along axis @p i, in voxels;
 * negative outside. c->border must have a bit of that axis. */
static inline float sc_cell_inside(const sc_cell *c, int i, const float a[3])
{
    return c->border >> i & 1 ? a[i] - 0.5f : 0.5f - a[i];
}

/* The dense id of the label that owns the point @p a of the cell, which has been read. */
static inline uint32_t sc_cell_owner_at(const sc_cell *c, const float a[3])
{
    for (int i = 0; i < 3; i++) {
        if ((c->border | c->border >> 3) >> i & 1 && sc_cell_inside(c, i, a) < 0)
            return 0;
    }
    return sc_cell_owner(c, a);
}

/* Find the first point after *@p u, on the way from @p a (0) to @p b (1), where another tissue
 * takes over from @p owner, and set *@p u to it. @return that tissue, or @p owner if there is
 * none, with *@p u unchanged. */
static inline uint32_t sc_next_tissue(const sc_cell *c, const float a[3], const float b[3],
                                      uint32_t owner, float *u)
{
    uint32_t next = owner;
    float first = 2;

    for (int k = 0; k < c->distinct_count; k++) {
        float difference[SC_CORNERS], coefficients[4], changes[3];
        const uint32_t other = c->distinct[k];
        /* Always the lower id minus the higher, so that rays in both directions find the same
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

/* List the changes from one tissue to another on the way from the point @p a of the cell to its
 * point
 * @p b, whichever side of the outer field they are on. @param first set to the tissue at @p a.
 * @return how many. */
static inline int sc_tissue_crossings(const sc_cell *c, const float a[3], const float b[3],
                                      uint32_t *first, sc_crossing out[SC_INNER_CROSSINGS])
{
    uint32_t owner, last;
    float u = -1;
    int count = 0;

    *first = c->distinct[0];
    if (c->distinct_count == 1)
        return 0;
    if (c->distinct_count == 2) {
        float difference[SC_CORNERS], coefficients[4], changes[3];
        int side;

        sc_cell_difference(c, c->distinct[0], c->distinct[1], difference);
        sc_bernstein(difference, a, b, coefficients);
        count = sc_sign_changes(coefficients, changes);
        side = coefficients[0] < 0;
        *first = c->distinct[side];
        for (int i = 0; i < count; i++, side ^= 1)
            out[i] = (sc_crossing){c->distinct[side], c->distinct[side ^ 1], changes[i], 0};
        return count;
    }
    *first = owner = sc_cell_tissue(c, a);
    last = sc_cell_tissue(c, b);
    while (count < SC_INNER_CROSSINGS - 1) {
        const uint32_t next = sc_next_tissue(c, a, b, owner, &u);

        if (next == owner)
            break;
        out[count++] = (sc_crossing){owner, next, u, 0};
        owner = next;
    }
    if (owner != last) /* rounding hid the last change; the next cell will start from this owner */
        out[count++] = (sc_crossing){owner, last, 1, 0};
    return count;
}

/* List the crossings on the way from the point @p a of the cell to its point @p b, but for the
 * border of the volume; the rest is as in sc_cell_crossings. */
static inline int sc_crossings_within(const sc_cell *c, const float a[3], const float b[3],
                                      sc_crossing out[SC_CROSSINGS_WITHIN])
{
    sc_crossing inner[SC_INNER_CROSSINGS];
    float outer[SC_OUTER_CROSSINGS], coefficients[4];
    int outer_count = 0, inner_count, count = 0, i = 0, k = 0;
    bool in_tissue = !c->background;
    uint32_t tissue;

    if (c->background && c->background != SC_ALL_CORNERS) {
        sc_bernstein(c->outer, a, b, coefficients);
        outer_count = sc_sign_changes(coefficients, outer);
        in_tissue = coefficients[0] < 0;
    }
    if (!outer_count && !in_tissue)
        return 0;
    inner_count = sc_tissue_crossings(c, a, b, &tissue, inner);
    while (i < outer_count || k < inner_count) {
        /* Where both change at the same point, tissues do so within the background. */
        const bool outer_first =
            k == inner_count ||
            (i < outer_count && (outer[i] < inner[k].u || (in_tissue && outer[i] == inner[k].u)));

        if (outer_first) {
            out[count++] =
                (sc_crossing){in_tissue ? tissue : 0, in_tissue ? 0 : tissue, outer[i++], 0};
            in_tissue = !in_tissue;
        } else {
            if (in_tissue)
                out[count++] = inner[k];
            tissue = inner[k++].entered;
        }
    }
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
 * order, in @p out. sc_cell_read must have returned true for the cell. @return how
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
