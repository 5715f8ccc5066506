/* SPDX-License-Identifier: BSD-3-Clause */
/* Crisp borders: the two fields from the labels alone, as surfaces with smooth 0 are drawn. All
 * values are half a voxel, so that borders lie halfway between voxels; the tissue of a vertex of
 * the background is that of the nearest voxel around it; gradients are those of the 3x3x3, smoothed
 * across (Sobel). */
#include "internal.h"

enum { HALF = SC_BORDER_STEPS / 2, AROUND = 27 };
/* The gradient, in units of the sums of find_gradient, at a flat border between two layers of
 * voxels. */
#define FLAT_GRADIENT 32

/* What the threads share. The arrays are as of sc_fields. */
typedef struct crisp {
    const sc_preparation *p;
    sc_affine to_voxel; /* RAS mm -> voxel index */
    sc_fields fields;
    sc_brick_sides *sides;
    uint8_t (*codes)[SC_BRICK_VERTICES];
} crisp;

/* The places of the 3x3x3, as of sc_tissue_code: the nearest first, those that share a face before
 * those that share an edge or a corner. */
static const uint8_t nearest_first[AROUND] = {13, 4,  10, 12, 14, 16, 22, 1, 3, 5,  7,  9,  11, 15,
                                              17, 19, 21, 23, 25, 0,  2,  6, 8, 18, 20, 24, 26};
/* Where the places of a face, of an edge and of a corner end in that order. */
static const uint8_t ends[] = {7, 19, AROUND};

/* @return the row of a block, and set @p x to the place in it, of what lies at the place of @p code
 * from the vertex at @p bit of the brick. */
static int row_at(int bit, int code, int *x)
{
    *x = sc_bit_x(bit) + 1 + sc_tissue_step(code, 0);
    return (sc_bit_z(bit) + 1 + sc_tissue_step(code, 2)) * SC_BLOCK + sc_bit_y(bit) + 1 +
           sc_tissue_step(code, 1);
}

/* @return the code of the tissue of a vertex of the background: that of the nearest voxel of tissue
 * in its 3x3x3, of equally near ones the one with the lowest id; SC_TISSUE_OWN if there is none. */
static int nearest_tissue(uint16_t ids[SC_BLOCK_ROWS][SC_BLOCK_ROOM], int bit)
{
    int code = SC_TISSUE_OWN, k = 1;
    uint16_t least = UINT16_MAX;

    for (int ring = 0; ring < 3 && code == SC_TISSUE_OWN; ring++) {
        for (; k < ends[ring]; k++) {
            int x, row = row_at(bit, nearest_first[k], &x);

            if (ids[row][x] && (ids[row][x] < least || code == SC_TISSUE_OWN)) {
                least = ids[row][x];
                code = nearest_first[k];
            }
        }
    }
    return code;
}

/* Find sides and codes of bricks [begin, end); an sc_range_fn on a crisp. */
static void find_sides(void *user, size_t begin, size_t end, int thread)
{
    const crisp *c = user;

    (void)thread;
    for (size_t brick = begin; brick < end; brick++) {
        const uint32_t number = c->fields.number[brick];
        uint16_t ids[SC_BLOCK_ROWS][SC_BLOCK_ROOM];

        if (!number)
            continue;
        sc_fetch_ids(c->p, brick, ids);
        for (int bit = 0; bit < SC_BRICK_VERTICES; bit++) {
            int x, row = row_at(bit, SC_TISSUE_OWN, &x);

            const int code = ids[row][x] ? SC_TISSUE_OWN : nearest_tissue(ids, bit);

            c->sides[number - 1].tissue |= (uint64_t)(ids[row][x] != 0) << bit;
            c->sides[number - 1].moved |= (uint64_t)(code != SC_TISSUE_OWN) << bit;
            c->codes[number - 1][bit] = (uint8_t)code;
        }
    }
}

/* Pack the record of a vertex, of value @p value. @param inside by code: 1, -1 or 0 for those
 * around it that lie inside, outside or in neither. */
static uint32_t pack_gradient(const crisp *c, int value, const int inside[AROUND])
{
    int sums[3] = {0, 0, 0};
    sc_vec3 outward = {0, 0, 0};
    double square = 0;

    for (int code = 0; code < AROUND; code++) {
        for (int i = 0; i < 3; i++) {
            const int a = sc_tissue_step(code, (i + 1) % 3), b = sc_tissue_step(code, (i + 2) % 3);

            sums[i] -= inside[code] * sc_tissue_step(code, i) * (2 - a * a) * (2 - b * b);
        }
    }
    for (int i = 0; i < 3; i++) {
        const double *row = c->to_voxel.m[i];

        outward = sc_vec3_along(outward, sums[i], (sc_vec3){row[0], row[1], row[2]});
        square += sums[i] * sums[i];
    }
    return sc_record_pack(value, outward, sqrt(square) / FLAT_GRADIENT);
}

/* Write records: see sc_fields. */
static void fill(void *user, size_t brick, const uint64_t masks[2], uint32_t *const out[2])
{
    const crisp *c = user;
    uint32_t *outer = out[0], *inner = out[1];
    sc_block block;

    sc_fetch_block(c->p, &c->fields, brick, &block);
    for (uint64_t left = masks[0] | masks[1]; left; left &= left - 1) {
        const int bit = __builtin_ctzll(left);
        int sides[AROUND], same[AROUND], own, own_x;

        own = row_at(bit, SC_TISSUE_OWN, &own_x);
        for (int code = 0; code < AROUND; code++) {
            int x, row = row_at(bit, code, &x);
            const uint16_t tissue = block.tissue[row][x];

            sides[code] = block.sides[row] >> x & 1 ? 1 : -1;
            same[code] = !tissue ? 0 : tissue == block.tissue[own][own_x] ? 1 : -1;
        }
        if (masks[0] >> bit & 1)
            *outer++ = pack_gradient(c, block.sides[own] >> own_x & 1 ? HALF : -HALF, sides);
        if (masks[1] >> bit & 1)
            *inner++ = pack_gradient(c, HALF, same);
    }
}

sc_status sc_crisp_borders(const sc_ctx *ctx, sc_preparation *p)
{
    crisp c = {.p = p};
    uint32_t *number = NULL;
    void *sides = NULL, *codes = NULL;
    uint64_t count;
    sc_status status;

    (void)sc_affine_invert(&p->volume->to_ras_mm, &c.to_voxel); /* geometry has been checked */
    SC_TRY(sc_number_bricks(ctx, p, p->near, &number, &count));
    SC_TRY(sc_team_alloc(ctx, p->team, count, sizeof *c.sides, &sides));
    SC_TRY(sc_team_alloc(ctx, p->team, count, sizeof *c.codes, &codes));
    c.sides = sides;
    c.codes = codes;
    c.fields = (sc_fields){.number = number,
                           .sides = c.sides,
                           .codes = (const uint8_t(*)[SC_BRICK_VERTICES])codes,
                           .fill = fill,
                           .user = &c};
    sc_team_stage_for(ctx, SC_WORTH_FIELDS, p->team, p->brick_count, 1024, find_sides, &c);
    SC_TRY(sc_store_borders(ctx, p, &c.fields));
out:
    sc_team_free(p->team, number);
    sc_team_free(p->team, sides);
    sc_team_free(p->team, codes);
    return status;
}
