/* SPDX-License-Identifier: BSD-3-Clause */
/* Tells from the neighbours of a voxel whether it belongs to a sheet one voxel thick. Sets of
 * neighbours are bits, in the order of the labels that sc_sheet_keeps_apart gets. */
#include "segcast/volume.h"

/* Those of the neighbours, as bits, that lie lowest along x, lowest along y, and beside a face; and
 * the corners of the lowest cell. */
#define LOW_X 0x1249249u /* x = 0 */
#define LOW_Y 0x01c0e07u /* y = 0 */
#define FACES (1u << 4 | 1u << 10 | 1u << 12 | 1u << 14 | 1u << 16 | 1u << 22)
#define CELL 0x361bu
#define ALL ((1u << SC_AROUND) - 1)

/* @return @p bits, a set of neighbours, and all that share a face with one of them. */
static inline uint32_t grow(uint32_t bits)
{
    return (bits | (bits & ~(LOW_X << 2)) << 1 | (bits & ~LOW_X) >> 1 |
            (bits & ~(LOW_Y << 6)) << 3 | (bits & ~LOW_Y) >> 3 | bits << 9 | bits >> 9) &
           ALL;
}

/* @return the part of the set @p of that is connected by faces with the lowest bit of @p seeds. */
static uint32_t part_of(uint32_t of, uint32_t seeds)
{
    uint32_t part = seeds & -seeds, last;

    do {
        last = part;
        part = grow(part) & of;
    } while (part != last);
    return part;
}

/* @return for two disjoint sets of neighbours: SC_APART_LABELS if a voxel of one has another label
 * than one of the other, together with SC_APART_SAME_LABEL if two have the same. */
static int compare_labels(const uint32_t ids[SC_AROUND], uint32_t a, uint32_t b)
{
    int out = 0;

    for (; a; a &= a - 1) {
        for (uint32_t left = b; left; left &= left - 1) {
            const bool equal = ids[__builtin_ctz(a)] == ids[__builtin_ctz(left)];

            out |= equal ? SC_APART_SAME_LABEL : SC_APART_LABELS;
        }
    }
    return out;
}

/* Is there a cell, of the eight round the voxel in the middle, within which the corners in @p
 * others fall into several parts? Only there a ray can pass between voxels of the sheet that are
 * joined by an edge or a corner alone. */
static bool has_split_cell(uint32_t others)
{
    for (int i = 0; i < 8; i++) {
        const int low = (i & 1) + 3 * (i >> 1 & 1) + 9 * (i >> 2);
        const uint32_t corners = others & CELL << low;

        if (corners && part_of(corners, corners) != corners)
            return true;
    }
    return false;
}

int sc_sheet_keeps_apart(const uint32_t ids[SC_AROUND])
{
    uint32_t others = 0, known, part;
    int out = 0;

    for (int i = 0; i < SC_AROUND; i++)
        others |= (uint32_t)(ids[i] != ids[SC_AROUND_CENTRE]) << i;
    known = part_of(others, others & FACES);
    if (!(others & FACES & ~known))
        return 0;
    for (uint32_t left = others & ~known; left & FACES; left &= ~part) {
        part = part_of(left, left & FACES);
        out |= compare_labels(ids, known, part);
        known |= part;
    }
    return has_split_cell(others) ? out : out & ~SC_APART_SAME_LABEL;
}
