/* SPDX-License-Identifier: BSD-3-Clause */
/* Reading the fields of borders at voxels, whatever tiles they lie in. Beyond the volume they go on
 * linearly, so that what ends at its border ends round. */
#include "border/border_group.h"

/* How much farther than half a voxel beyond its last voxels tissue ends that goes on beyond the
 * volume, in voxels, about. */
#define LIFT 0.25f

/* Raise the outer field of a region by LIFT beyond the volume: tissue that would continue there is
 * then cut off by the face of the volume, and tissue that only touches the face ends round. */
static void lift_beyond(const sc_borders *b, const int low[3], int edge, float *region)
{
    const int *size = b->p->volume->size;
    bool inside = true;

    for (int i = 0; i < 3; i++)
        inside = inside && low[i] >= 0 && low[i] + edge <= size[i];
    for (int i = 0; i < edge * edge * edge && !inside; i++) {
        const int x = low[0] + i % edge, y = low[1] + i / edge % edge,
                  z = low[2] + i / (edge * edge);

        if (x < 0 || y < 0 || z < 0 || x >= size[0] || y >= size[1] || z >= size[2])
            region[i] += LIFT;
    }
}

/* Read the part of a region that lies in the cube at @p at, in cubes. @return whether it has a tile
 * of the field of @p label. */
static bool read_cube(const sc_borders *b, uint32_t label, const int at[3], const int low[3],
                      int edge, float *out)
{
    const uint32_t tile = sc_tile_of(b, sc_brick_index(b->cubes, at[0], at[1], at[2]), label);
    const bool is = tile < SC_BESIDE(0);
    const float sign = is && tile & SC_MIRRORED ? -1 / SC_FINE_STEPS : 1 / SC_FINE_STEPS;
    const float far = sc_beside_value(tile);
    int begin[3], end[3];

    for (int i = 0; i < 3; i++) {
        const int first = at[i] * SC_CUBE - b->phase[i];

        begin[i] = first > low[i] ? first : low[i];
        end[i] = first + SC_CUBE < low[i] + edge ? first + SC_CUBE : low[i] + edge;
    }
    for (int z = begin[2]; z < end[2]; z++) {
        for (int y = begin[1]; y < end[1]; y++) {
            float *to = out + ((z - low[2]) * edge + y - low[1]) * edge + begin[0] - low[0];
            const int16_t *from =
                b->fine[is ? tile & ~SC_MIRRORED : 0] +
                ((z + b->phase[2]) % SC_CUBE * SC_CUBE + (y + b->phase[1]) % SC_CUBE) * SC_CUBE +
                (begin[0] + b->phase[0]) % SC_CUBE;

            for (int x = 0; x < end[0] - begin[0]; x++)
                to[x] = is ? sign * (float)from[x] : far;
        }
    }
    return is;
}

bool sc_read_field(const sc_borders *b, uint32_t label, const int low[3], int edge, float *out)
{
    const int *size = b->p->volume->size;
    int first[3], count[3];
    bool any = false;

    for (int i = 0; i < 3; i++) {
        const int high = low[i] + edge - 1 < size[i] ? low[i] + edge - 1 : size[i] - 1;

        first[i] = ((low[i] < 0 ? 0 : low[i]) + b->phase[i]) / SC_CUBE;
        count[i] = (high + b->phase[i]) / SC_CUBE - first[i] + 1;
    }
    for (int n = 0; n < count[0] * count[1] * count[2]; n++) {
        const int at[3] = {first[0] + n % count[0], first[1] + n / count[0] % count[1],
                           first[2] + n / (count[0] * count[1])};

        any = read_cube(b, label, at, low, edge, out) || any;
    }
    for (int axis = 0; axis < 3 && any; axis++) {
        const int begin = low[axis] < 0 ? -low[axis] : 0;
        const int end = low[axis] + edge < size[axis] ? edge : size[axis] - low[axis];

        if (begin > 0 || end < edge)
            sc_extrapolate_along(out, edge, axis, begin, end);
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
            sc_copy_ids(v, row + (size_t)(low[0] - 1), SC_IDS_ROW, to);
            continue;
        }
        for (int x = 0; x < SC_IDS_EDGE; x++)
            to[x] =
                (uint16_t)sc_id_at(v, row + (size_t)sc_nearest_voxel(low[0] + x - 1, v->size[0]));
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
