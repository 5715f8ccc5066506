/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: seams, the lines in which the surfaces of two tissues that touch meet.
 *
 * Where a ray meets the background, the largest vote says which tissue it meets. Along a seam that
 * answer follows the steps of the background: most cells that the surface passes have few corners
 * of tissue, and those alone decide. So the seam would look toothed. Here more voxels decide: a
 * linear function of the place is fitted to those of the 4x4x4 around the cell that carry one of
 * the two labels, 1 for the one and -1 for the other, by least squares with a ridge. Its sign tells
 * which tissue is seen.
 *
 * The surface stays where it is, and every point keeps its owner. The tissue that is seen is a coat
 * without thickness on the one that owns what is behind: a ray meets first the one and then, at the
 * same point, the other. So it still meets all that it would meet without the coat. A tissue coats
 * another only in cells in which voxels of both share a face with the background; so what lies
 * under a closed skin never shows, nor does a tissue appear where it has no vote. */
#ifndef SC_KERNEL_SEAM_H
#define SC_KERNEL_SEAM_H

#include "cell.h"

#include <string.h>

/* The voxels around a cell: SC_SEAM_EDGE along each axis, those at 1 and 2 being its corners. */
enum { SC_SEAM_EDGE = 4, SC_SEAM_VOXELS = SC_SEAM_EDGE * SC_SEAM_EDGE * SC_SEAM_EDGE };
/* The ridge, as a variance of the places in voxels squared. The smaller, the nearer is the seam to
 * the true one where the border of the tissues is aslant to the surface, and the more it wavers. */
#define SC_SEAM_RIDGE 0.3f
/* What the fit is multiplied by for its say, which is added to the difference of the two votes as a
 * share of their sum, and the most that it may be: so a vote four times as large always wins. */
#define SC_SEAM_GAIN 8.0f
#define SC_SEAM_SAY 0.6f
/* So far from its own seam, in voxels, the fit has no say. */
#define SC_SEAM_REACH 0.7f

/* Their labels, at x + 4 y + 16 z. */
typedef struct sc_seam_labels {
    uint16_t at[SC_SEAM_VOXELS];
} sc_seam_labels;

/* A mask of these voxels has bit j of byte n for number n + 8 j: byte x + 4 (y & 1), bit (y >> 1) +
 * 2 z. So it is made from vectors of eight labels. These are the voxels with a bit of a coordinate
 * set, by axis. */
static const uint64_t sc_seam_low[3] = {0xff00ff00ff00ff00u, 0xffffffff00000000u,
                                        0xccccccccccccccccu};
static const uint64_t sc_seam_high[3] = {0xffff0000ffff0000u, 0xaaaaaaaaaaaaaaaau,
                                         0xf0f0f0f0f0f0f0f0u};

/* A function of the point a of the cell, constant + slope . (2 a - 1): positive where the first of
 * two tissues is, negative where the second is. */
typedef struct sc_seam_fit {
    float constant, slope[3];
    float scale; /* positive: what the function has been multiplied by */
} sc_seam_fit;

/* Read the labels around the cell @p q; outside of the volume, those of the nearest voxels. */
static inline void sc_seam_read(const sc_prepared *v, const int q[3], sc_seam_labels *out)
{
    typedef uint8_t narrow __attribute__((vector_size(SC_SEAM_EDGE)));
    typedef uint16_t wide __attribute__((vector_size(2 * SC_SEAM_EDGE)));
    const size_t row = (size_t)v->size[0], layer = row * (size_t)v->size[1];
    bool inside = true;

    for (int i = 0; i < 3; i++)
        inside = inside && q[i] >= 2 && q[i] + 2 <= v->size[i];
    for (int n = 0; n < SC_SEAM_VOXELS; n += SC_SEAM_EDGE) {
        const int y = q[1] - 1 + n / SC_SEAM_EDGE % SC_SEAM_EDGE;
        const int z = q[2] - 1 + n / (SC_SEAM_EDGE * SC_SEAM_EDGE);
        const size_t at = (size_t)(z - 1) * layer + (size_t)(y - 1) * row + (size_t)(q[0] - 2);

        if (inside && v->label_bytes == 1) {
            narrow four;
            wide each;

            memcpy(&four, (const uint8_t *)v->ids + at, sizeof four);
            each = __builtin_convertvector(four, wide);
            memcpy(&out->at[n], &each, sizeof each);
        } else if (inside) {
            memcpy(&out->at[n], (const uint16_t *)v->ids + at, sizeof(wide));
        } else {
            for (int x = 0; x < SC_SEAM_EDGE; x++) {
                int near[3];

                sc_cell_vertex(v, (const int[3]){q[0] - 1 + x, y, z}, 0, near);
                out->at[n + x] = (uint16_t)sc_id_at_vertex(v, near[0], near[1], near[2]);
            }
        }
    }
}

/* The mask of the voxels that carry @p label. */
static inline uint64_t sc_seam_mask(const sc_seam_labels *labels, uint32_t label)
{
    typedef uint16_t eight __attribute__((vector_size(16)));
    typedef uint8_t bytes __attribute__((vector_size(8)));
    eight bits = {0};
    bytes packed;
    uint64_t mask;

    for (int j = 0; j < 8; j++) {
        eight each;

        memcpy(&each, &labels->at[8 * j], sizeof each);
        bits |= (eight)(each == (uint16_t)label) & (uint16_t)(1u << j);
    }
    packed = __builtin_convertvector(bits, bytes);
    memcpy(&mask, &packed, sizeof mask);
    return mask;
}

/* The sums of the coordinates of the voxels of @p mask, to @p out. Here and below they are counted
 * from the middle of the cell in halves of a voxel: -3, -1, 1 and 3. */
static inline void sc_seam_sums(uint64_t mask, int count, int out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = 4 * (int)sc_count_bits(mask & sc_seam_high[i]) +
                 2 * (int)sc_count_bits(mask & sc_seam_low[i]) - 3 * count;
}

/* The sum over the voxels of @p mask of the product of their coordinates along two different axes.
 * @param sums, count of the same mask. */
static inline int sc_seam_product(uint64_t mask, int i, int k, int count, const int sums[3])
{
    const uint64_t high = mask & sc_seam_high[i], low = mask & sc_seam_low[i];
    const int products = 16 * (int)sc_count_bits(high & sc_seam_high[k]) +
                         8 * (int)sc_count_bits(high & sc_seam_low[k]) +
                         8 * (int)sc_count_bits(low & sc_seam_high[k]) +
                         4 * (int)sc_count_bits(low & sc_seam_low[k]);

    return products - 3 * (sums[i] + sums[k]) - 9 * count;
}

/* Fit the function to the voxels of @p first (1) and @p second (-1), of which there must be one at
 * least. All sums are whole numbers, and nothing is divided: the function is multiplied by what is
 * positive anyway, the determinant of the normal equations and the number of voxels. */
static inline sc_seam_fit sc_seam_solve(uint64_t first, uint64_t second)
{
    const uint64_t both = first | second;
    const int count = (int)sc_count_bits(both), first_count = (int)sc_count_bits(first);
    const int balance = 2 * first_count - count;
    const float ridge = 4 * SC_SEAM_RIDGE * (float)(count * count);
    int sums[3], first_sums[3];
    float m[3][3], with[3], inverse[3][3], determinant = 0;
    sc_seam_fit fit;

    sc_seam_sums(both, count, sums);
    sc_seam_sums(first, first_count, first_sums);
    for (int i = 0; i < 3; i++) {
        const int k = (i + 1) % 3;
        const uint64_t outer = ~(sc_seam_high[i] ^ sc_seam_low[i]);
        const int square = count + 8 * (int)sc_count_bits(both & outer);

        m[i][i] = (float)(count * square - sums[i] * sums[i]) + ridge;
        m[i][k] = m[k][i] =
            (float)(count * sc_seam_product(both, i, k, count, sums) - sums[i] * sums[k]);
        with[i] = (float)(count * (2 * first_sums[i] - sums[i]) - balance * sums[i]);
    }
    for (int i = 0; i < 3; i++) {
        const int a = (i + 1) % 3, b = (i + 2) % 3;

        for (int k = 0; k < 3; k++) {
            const int c = (k + 1) % 3, d = (k + 2) % 3;

            inverse[i][k] = m[a][c] * m[b][d] - m[a][d] * m[b][c];
        }
    }
    for (int k = 0; k < 3; k++)
        determinant += m[0][k] * inverse[0][k];
    fit.constant = (float)balance * determinant;
    for (int i = 0; i < 3; i++) {
        const float slope =
            inverse[i][0] * with[0] + inverse[i][1] * with[1] + inverse[i][2] * with[2];

        fit.slope[i] = slope * (float)count;
        fit.constant -= slope * (float)sums[i];
    }
    fit.scale = determinant * (float)count;
    return fit;
}

/* How much the fit is for the first tissue (against: negative) at the point @p a of the cell: up to
 * SC_SEAM_SAY, and nothing where its own seam is SC_SEAM_REACH or more away, because then there are
 * more than the two tissues side by side to which it was fitted: a thin one between two others,
 * say. */
static inline float sc_seam_say(const sc_seam_fit *fit, const float a[3])
{
    float value = fit->constant, square = 0, near, say;

    for (int i = 0; i < 3; i++)
        value += fit->slope[i] * (2 * a[i] - 1);
    for (int i = 0; i < 3; i++)
        square += fit->slope[i] * fit->slope[i];
    square *= 4 * SC_SEAM_REACH * SC_SEAM_REACH;
    if (!(value * value < square))
        return 0;
    near = 1 - value * value / square;
    say = SC_SEAM_GAIN * value * near / fit->scale;
    return say > SC_SEAM_SAY ? SC_SEAM_SAY : say < -SC_SEAM_SAY ? -SC_SEAM_SAY : say;
}

/* Which corners of the cell share an edge of it with one of @p corners; both as bits. */
static inline unsigned sc_seam_beside(unsigned corners)
{
    return (corners & 0x55) << 1 | (corners & 0xaa) >> 1 | (corners & 0x33) << 2 |
           (corners & 0xcc) >> 2 | (corners & 0x0f) << 4 | (corners & 0xf0) >> 4;
}

/* The corners that carry @p label, as bits. */
static inline unsigned sc_seam_corners(const sc_cell *c, uint32_t label)
{
    unsigned bits = 0;

    for (int n = 0; n < SC_CORNERS; n++)
        bits |= (c->labels[n] == label ? 1u : 0) << n;
    return bits;
}

/* The tissues with a corner beside one of the background, in rising order, to @p out, and their
 * corners, as bits, to @p corners. @return how many. */
static inline int sc_seam_tissues(const sc_cell *c, uint32_t out[SC_CORNERS],
                                  unsigned corners[SC_CORNERS])
{
    const unsigned beside = sc_seam_beside(sc_seam_corners(c, 0));
    int count = 0;

    for (int k = 1; k < c->distinct_count; k++) {
        corners[count] = sc_seam_corners(c, c->distinct[k]);
        if (corners[count] & beside)
            out[count++] = c->distinct[k];
    }
    return count;
}

/* What is known of the seams in a cell. */
typedef struct sc_seam {
    int count; /* of the tissues that can be seen there: sc_seam_tissues */
    uint32_t tissues[SC_CORNERS];
    unsigned corners[SC_CORNERS];
    bool read; /* the labels around have been read */
    sc_seam_labels labels;
} sc_seam;

/* The vote at a point of those of the corners @p corners (bits), whose votes are @p votes. */
static inline float sc_seam_vote(const float votes[SC_CORNERS], unsigned corners)
{
    float sum = 0;

    for (unsigned left = corners; left; left &= left - 1)
        sum += votes[__builtin_ctz(left)];
    return sum;
}

/* May @p other be seen instead of @p owner? Both have to be shown and cut by the same planes.
 * @return how far, 0 to 1: while one of them fades, less and less, so that the seam does not jump.
 */
static inline float sc_seam_share(const sc_march *m, uint32_t owner, uint32_t other)
{
    const sc_march_tissue *a = &m->tissues[owner], *b = &m->tissues[other];

    if (!(a->show & b->show & SC_SHOW_BOUNDARY) || a->clip_set != b->clip_set)
        return 0;
    return a->cap_alpha < b->cap_alpha ? a->cap_alpha : b->cap_alpha;
}

/* Which tissue is seen at the point @p a of the cell, where @p owner owns what is behind. */
static inline uint32_t sc_seam_seen(const sc_march *m, const sc_cell *c, sc_seam *seam,
                                    uint32_t owner, const float a[3])
{
    float votes[SC_CORNERS], vote = 0;
    uint32_t seen = owner;

    for (int n = 0; n < SC_CORNERS; n++)
        votes[n] = c->weights[n] * (n & 1 ? a[0] : 1 - a[0]) * (n & 2 ? a[1] : 1 - a[1]) *
                   (n & 4 ? a[2] : 1 - a[2]);
    for (int k = 0; k < seam->count; k++) {
        if (seam->tissues[k] == owner)
            vote = sc_seam_vote(votes, seam->corners[k]);
    }
    for (int k = 0; k < seam->count && vote > 0; k++) {
        const uint32_t tissue = seam->tissues[k];
        const float other = sc_seam_vote(votes, seam->corners[k]);
        const float ahead = vote - other, all = vote + other;
        const float share =
            tissue == owner || ahead >= SC_SEAM_SAY * all ? 0 : sc_seam_share(m, owner, tissue);
        sc_seam_fit fit;

        if (!(share > 0))
            continue;
        if (!seam->read)
            sc_seam_read(m->volume, c->q, &seam->labels);
        seam->read = true;
        fit = sc_seam_solve(sc_seam_mask(&seam->labels, seen), sc_seam_mask(&seam->labels, tissue));
        if (ahead + share * sc_seam_say(&fit, a) * all < 0) {
            seen = tissue;
            vote = other;
        }
    }
    return seen;
}

/* As sc_seam_coats, for a cell that has coats perhaps. Not inlined: few cells are such, and kernels
 * are faster without this in their loops. */
static __attribute__((noinline)) int sc_seam_insert(const sc_march *m, const sc_cell *c,
                                                    const float a[3], const float b[3],
                                                    sc_crossing list[SC_CROSSINGS_MAX], int count)
{
    sc_seam seam;

    seam.read = false;
    seam.count = sc_seam_tissues(c, seam.tissues, seam.corners);
    for (int i = 0; i < count && count < SC_CROSSINGS_MAX && seam.count > 1; i++) {
        const uint32_t owner = list[i].left | list[i].entered; /* if the other is background */
        uint32_t seen;
        float at[3];

        if ((list[i].left && list[i].entered) || list[i].face)
            continue;
        for (int k = 0; k < 3; k++)
            at[k] = sc_lerp(a[k], b[k], list[i].u);
        seen = sc_seam_seen(m, c, &seam, owner, at);
        if (seen == owner)
            continue;
        for (int k = count++; k > i; k--)
            list[k] = list[k - 1];
        list[i].entered = list[i + 1].left = seen;
        i++;
    }
    return count;
}

/* Insert coats into the list of the @p count crossings of a cell, made by sc_cell_crossings for the
 * way from the point @p a to @p b of it. @return how many there are then. */
static inline int sc_seam_coats(const sc_march *m, const sc_cell *c, const float a[3],
                                const float b[3], sc_crossing list[SC_CROSSINGS_MAX], int count)
{
    if (!count || c->distinct_count < 3 || c->distinct[0])
        return count;
    return sc_seam_insert(m, c, a, b, list, count);
}

#endif
