/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to prepare: what is done for groups of bricks, of SC_CUBE vertices along each axis, once
 * the fields of borders are known: sides and tissues of vertices first, their records then. Vertex
 * q is voxel q - 1. */
#ifndef SC_PREPARE_BORDER_GROUP_H
#define SC_PREPARE_BORDER_GROUP_H

#include "border/border.h"

enum {
    SC_GROUP_EDGE = SC_CUBE / SC_BRICK, /* bricks along an edge of a group */
    SC_GROUP_BRICKS = SC_GROUP_EDGE * SC_GROUP_EDGE * SC_GROUP_EDGE,
    SC_IDS_EDGE = SC_CUBE + 2, /* edge of the labels of a group and those around */
    SC_IDS_ROW = 24            /* numbers for which a row of ids has room */
};

/* What the fields say of the vertices of a brick, as bits. */
typedef struct sc_brick_sides {
    uint64_t tissue; /* those on the side of tissue */
    uint64_t moved; /* those whose tissue is that of another place: its code is not SC_TISSUE_OWN */
} sc_brick_sides;

/* What the threads share: the fields, and the numbers of wanted bricks, by which the arrays below
 * are sorted. */
typedef struct sc_record_writer {
    const sc_borders *b;
    sc_preparation *p;
    sc_affine to_voxel; /* RAS mm -> voxel */
    int groups[3];
    uint64_t *wanted; /* [brick_count]: not 0 for bricks that hold, or touch, a vertex near one */
    const uint32_t *number; /* [brick_count]: which of the arrays below a brick has, from 1 on; 0:
                               all its vertices, and those around it, have the same label, side by
                               it, and tissue */
    sc_brick_sides *sides;
    uint8_t (*codes)[SC_BRICK_VERTICES]; /* the tissue of a vertex, see sc_tissue_code */
    uint8_t (*inner)[SC_BRICK_VERTICES]; /* value of the record; 0 if it has not been found */
} sc_record_writer;

/* Labels of a group and around it; beyond the volume those of the nearest voxels. */
typedef struct sc_group_ids {
    uint16_t at[SC_IDS_EDGE][SC_IDS_EDGE][SC_IDS_ROW];
} sc_group_ids;

/* @return the number that the constant of sc_tiles.beside stands for; 0 for a tile. */
static inline float sc_beside_value(uint32_t beside)
{
    return beside == SC_BESIDE(SC_BESIDE_HIGH)  ? SC_FAR
           : beside == SC_BESIDE(SC_BESIDE_LOW) ? -SC_FAR
                                                : 0;
}

/* @return the value of the field of @p label at a voxel. @param place its index within the block.
 */
static inline float sc_field_at(const sc_borders *b, size_t block, int place, uint32_t label)
{
    const uint32_t tile = sc_tile_of(b, block, label);

    if (tile >= SC_BESIDE(0))
        return sc_beside_value(tile);
    return tile & SC_MIRRORED ? -sc_of_fine(b->fine[tile & ~SC_MIRRORED][place])
                              : sc_of_fine(b->fine[tile][place]);
}

/* Read numbers of the field of @p label, of the @p edge voxels along each axis from @p low on, to
 * @p out, beyond the volume going on linearly. @return false if its border is out of reach of all
 * of them. */
bool sc_read_field(const sc_borders *b, uint32_t label, const int low[3], int edge, float *out);

/* Read the labels of a group whose lowest voxel is @p low, and of those around. */
void sc_read_group_ids(const sc_volume *v, const int low[3], sc_group_ids *out);

/* Where the places of codes stand in the labels of a group, from the lowest around a vertex on. */
#define PLACE(code) (((code) / 9 * SC_IDS_EDGE + (code) / 3 % 3) * SC_IDS_ROW + (code) % 3)
static const int sc_places[SC_TISSUE_CODES] = {
    PLACE(0),  PLACE(1),  PLACE(2),  PLACE(3),  PLACE(4),  PLACE(5),  PLACE(6),
    PLACE(7),  PLACE(8),  PLACE(9),  PLACE(10), PLACE(11), PLACE(12), PLACE(13),
    PLACE(14), PLACE(15), PLACE(16), PLACE(17), PLACE(18), PLACE(19), PLACE(20),
    PLACE(21), PLACE(22), PLACE(23), PLACE(24), PLACE(25), PLACE(26)};

/* @return the label at the place of @p code from vertex (x, y, z) of a group. */
static inline uint16_t sc_id_around(const sc_group_ids *ids, int x, int y, int z, int code)
{
    return (&ids->at[0][0][0])[(z * SC_IDS_EDGE + y) * SC_IDS_ROW + x + sc_places[code]];
}

/* Write the lowest vertex of a group to @p low. @return whether any of its bricks has a bit in one
 * of
 * @p masks. */
bool sc_begin_group(const sc_record_writer *w, const uint64_t *masks[2], size_t group, int low[3]);
/* @return the brick of number @p n of a group, or SIZE_MAX if there is none. */
static inline size_t sc_brick_of_group(const sc_record_writer *w, const int low[3], int n)
{
    const int x = low[0] / SC_BRICK + n % SC_GROUP_EDGE,
              y = low[1] / SC_BRICK + n / SC_GROUP_EDGE % SC_GROUP_EDGE,
              z = low[2] / SC_BRICK + n / (SC_GROUP_EDGE * SC_GROUP_EDGE);

    if (x >= w->p->bricks[0] || y >= w->p->bricks[1] || z >= w->p->bricks[2])
        return SIZE_MAX;
    return sc_brick_index(w->p->bricks, x, y, z);
}

/* @return the value of a record of the outer field. */
static inline int sc_outer_value(float field)
{
    const float steps = field * SC_BORDER_STEPS;
    const int value = (int)(steps < 0 ? steps - 0.5f : steps + 0.5f);

    return value > SC_VALUE_MAX    ? SC_VALUE_MAX
           : value < -SC_VALUE_MAX ? -SC_VALUE_MAX
           : value                 ? value
                                   : 1;
}

/* @return the value of a record of the inner field. @param values of sc_largest_tissue. */
static inline uint8_t sc_inner_value(const float values[2])
{
    const int value = sc_outer_value(0.5f * (values[0] - values[1]));

    return (uint8_t)(value < 1 ? 1 : value);
}

/* @return the code of the tissue that has the largest number at vertex @p at of a group, of those
 * around it; of equal ones the nearest. A vertex in the background takes only tissues that steps
 * through background lead to: numbers there go on freely from the tissue, and what lies beneath a
 * skin one voxel thick would show through it. @param voxel of the vertex.
 * @param values [2] set to the largest number of all tissues around, -2 SC_FAR if there is none,
 * and to the largest other one of all tissues that have a field there, around or not, but at most
 * the first: beside a gap of one voxel a vertex may have only one tissue around, whose vote still
 * has to end where that of the other one begins. */
int sc_largest_tissue(const sc_borders *b, const sc_group_ids *ids, const int at[3],
                      const int voxel[3], float values[2]);
/* Find sides, codes and inner of all groups; collective in the team. */
void sc_find_sides(const sc_ctx *ctx, sc_record_writer *w);
/* Find which vertices have records and number them: outer and inner of the preparation, whose
 * records are allocated. Needs sides. Collective in the team. Returns SC_ERR_MEMORY. */
sc_status sc_mark_borders(const sc_ctx *ctx, const sc_record_writer *w);

#endif
