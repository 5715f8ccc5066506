/* SPDX-License-Identifier: BSD-3-Clause */
/* Reading the fields of borders at voxels, whatever tiles they lie in. Beyond the volume they go on
 * linearly, so that what ends at its border ends round. */
#include "border/border_group.h"

/* How much farther than half a voxel beyond its last voxels tissue ends that goes on beyond the
 * volume, in voxels, about. */
#define LIFT 0.25f

/* Raise the outer field of a region by LIFT beyond voxels of the volume in tissue: what would go on
 * there is cut off by the face of the volume, and what only touches it ends round. */
static void lift_beyond(const sc_borders *b, const int low[3], int edge, float *region)
{
    const int *size = b->p->volume->size;
    bool inside = true;

    for (int i = 0; i < 3; i++)
        inside = inside && low[i] >= 0 && low[i] + edge <= size[i];
    for (int i = 0; i < edge * edge * edge && !inside; i++) {
        const int x = low[0] + i % edge, y = low[1] + i / edge % edge,
                  z = low[2] + i / (edge * edge);
        const int last = ((sc_nearest_voxel(z, size[2]) - low[2]) * edge +
                          sc_nearest_voxel(y, size[1]) - low[1]) *
                             edge +
                         sc_nearest_voxel(x, size[0]) - low[0];

        if (last != i && region[last] > 0)
            region[i] += LIFT;
    }
}

/* The part of a row of a region that lies in one cube. */
typedef struct row_part {
    const int16_t *from; /* numbers of the first row of the cube */
    int step;            /* 1; 0 if all rows are the same */
    int at, count;       /* where it stands in the row of the region */
    float by;            /* what numbers are multiplied by */
} row_part;

enum { PARTS = 4 /* of a row of up to 3 SC_CUBE voxels */ };

/* Rows of the numbers that stand for fields without a tile: what is far on the positive side, far
 * on the other one, or free. */
typedef int16_t far_rows[3][SC_CUBE];

/* Write the numbers of a part of a row to @p out: SC_CUBE of them, which may be too many, unless it
 * is the last of a region. */
SC_ALWAYS_INLINE void read_part(const row_part *part, int row, bool last, float *out)
{
    const int16_t *from = part->from + part->step * row * SC_CUBE;
    float numbers[SC_CUBE];

    for (int x = 0; x < SC_CUBE; x++)
        numbers[x] = part->by * (float)from[x];
    if (last)
        memcpy(out + part->at, numbers, (size_t)part->count * sizeof *out);
    else
        memcpy(out + part->at, numbers, sizeof numbers);
}

/* Find the parts of rows of a region along x, in the cubes at (y, z). @return how many there are.
 * @param end of the region, or of the volume. @param any set to true if one of them has a tile of
 * the field. */
static int find_parts(const sc_borders *b, uint32_t label, const int low[3], const int end[3],
                      const int yz[2], const far_rows far, row_part parts[PARTS], bool *any)
{
    int count = 0;

    for (int x = low[0] < 0 ? 0 : low[0]; x < end[0];) {
        const int cube = (x + b->phase[0]) / SC_CUBE, within = (x + b->phase[0]) % SC_CUBE;
        const uint32_t tile = sc_tile_of(b, sc_brick_index(b->cubes, cube, yz[0], yz[1]), label);
        const bool is = tile < SC_BESIDE(0);
        row_part *part = &parts[count++];

        part->from = is ? b->fine[tile & ~SC_MIRRORED] + within
                        : far[tile == SC_BESIDE(SC_BESIDE_HIGH)  ? 0
                              : tile == SC_BESIDE(SC_BESIDE_LOW) ? 1
                                                                 : 2];
        part->step = is;
        part->by = is && tile & SC_MIRRORED ? -1 / SC_FINE_STEPS : 1 / SC_FINE_STEPS;
        part->at = x - low[0];
        part->count = SC_CUBE - within < end[0] - x ? SC_CUBE - within : end[0] - x;
        *any = *any || is;
        x += part->count;
    }
    return count;
}

SC_WIDE_VECTORS bool sc_read_field(const sc_borders *b, uint32_t label, const int low[3], int edge,
                                   float *out)
{
    const int *size = b->p->volume->size;
    int end[3], parts_at[2] = {-1, -1}, count = 0;
    row_part parts[PARTS];
    far_rows far = {{0}};
    bool any = false;

    for (int x = 0; x < SC_CUBE; x++) {
        far[0][x] = (int16_t)(SC_FAR * SC_FINE_STEPS);
        far[1][x] = -(int16_t)(SC_FAR * SC_FINE_STEPS);
    }
    for (int i = 0; i < 3; i++)
        end[i] = low[i] + edge < size[i] ? low[i] + edge : size[i];
    for (int z = low[2] < 0 ? 0 : low[2]; z < end[2]; z++) {
        for (int y = low[1] < 0 ? 0 : low[1]; y < end[1]; y++) {
            const int yz[2] = {(y + b->phase[1]) / SC_CUBE, (z + b->phase[2]) / SC_CUBE};
            const int row = (z + b->phase[2]) % SC_CUBE * SC_CUBE + (y + b->phase[1]) % SC_CUBE;

            if (yz[0] != parts_at[0] || yz[1] != parts_at[1])
                count =
                    find_parts(b, label, low, end, yz, (const int16_t(*)[SC_CUBE])far, parts, &any);
            memcpy(parts_at, yz, sizeof yz);
            for (int i = 0; i < count; i++)
                read_part(&parts[i], row, z + 1 == end[2] && y + 1 == end[1],
                          out + ((z - low[2]) * edge + y - low[1]) * edge);
        }
    }
    for (int axis = 0; axis < 3 && any; axis++) {
        const int begin = low[axis] < 0 ? -low[axis] : 0;

        if (begin > 0 || end[axis] < low[axis] + edge)
            sc_extrapolate_along(out, edge, axis, begin, end[axis] - low[axis]);
    }
    if (any && !label)
        lift_beyond(b, low, edge, out);
    return any;
}

void sc_read_group_ids(const sc_volume *v, const int low[3], sc_group_ids *out)
{
    for (int k = 0; k < SC_IDS_EDGE * SC_IDS_EDGE; k++) {
        const int y = sc_nearest_voxel(low[1] + k % SC_IDS_EDGE - 1, v->size[1]);
        const int z = sc_nearest_voxel(low[2] + k / SC_IDS_EDGE - 1, v->size[2]);
        const size_t row = ((size_t)z * (size_t)v->size[1] + (size_t)y) * (size_t)v->size[0];
        uint16_t *to = out->at[k / SC_IDS_EDGE][k % SC_IDS_EDGE];

        if (low[0] >= 1 && low[0] - 1 + SC_IDS_ROW <= v->size[0]) {
            sc_volume_read_ids(v, row + (size_t)(low[0] - 1), SC_IDS_ROW, to);
            continue;
        }
        for (int x = 0; x < SC_IDS_EDGE; x++)
            to[x] = (uint16_t)sc_volume_id(
                v, row + (size_t)sc_nearest_voxel(low[0] + x - 1, v->size[0]));
    }
}

bool sc_begin_group(const sc_record_writer *w, const uint64_t *masks[2], size_t group, int low[3])
{
    bool any = false;

    sc_brick_at(w->groups, group, low);
    for (int i = 0; i < 3; i++)
        low[i] *= SC_CUBE;
    for (int n = 0; n < SC_GROUP_BRICKS; n++) {
        const int x = low[0] / SC_BRICK + n % SC_GROUP_EDGE,
                  y = low[1] / SC_BRICK + n / SC_GROUP_EDGE % SC_GROUP_EDGE,
                  z = low[2] / SC_BRICK + n / (SC_GROUP_EDGE * SC_GROUP_EDGE);

        if (x < w->p->bricks[0] && y < w->p->bricks[1] && z < w->p->bricks[2]) {
            const size_t brick = sc_brick_index(w->p->bricks, x, y, z);

            any = any || masks[0][brick] || masks[1][brick];
        }
    }
    return any;
}
