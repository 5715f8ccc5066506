/* SPDX-License-Identifier: BSD-3-Clause */
/* On which side of the border between background and tissue each vertex lies, and which tissue it
 * has. It may come to lie on another side than its voxel, or get another tissue, one of those
 * around it: about one vertex in a hundred does. */
#include "border/border_group.h"

enum {
    BEFORE = 2, /* voxels before a group from which its field goes on beyond the volume */
    SIDED = SC_CUBE + BEFORE
};

/* The places of the 3x3x3, as of sc_tissue_code: those that share a face first, then an edge, then
 * a corner. */
static const uint8_t nearest_first[SC_TISSUE_CODES] = {13, 4, 10, 12, 14, 16, 22, 1,  3,
                                                       5,  7, 9,  11, 15, 17, 19, 21, 23,
                                                       25, 0, 2,  6,  8,  18, 20, 24, 26};

/* @return the places, as bits by their codes, from which a step along an axis, away from the
 * vertex, leads to that of @p code; unless it is a corner, its own, too. */
static inline uint32_t places_before(int code)
{
    return 1u << (code - sc_tissue_step(code, 0)) | 1u << (code - 3 * sc_tissue_step(code, 1)) |
           1u << (code - 9 * sc_tissue_step(code, 2));
}

int sc_largest_tissue(const sc_borders *b, const sc_group_ids *ids, const int at[3],
                      const int voxel[3], float values[2])
{
    const uint16_t own = sc_id_around(ids, at[0], at[1], at[2], SC_TISSUE_OWN);
    uint32_t open = own ? UINT32_MAX : 1u << SC_TISSUE_OWN; /* places that have been reached */
    uint16_t seen[SC_TISSUE_CODES];
    float numbers[SC_TISSUE_CODES], most = -2 * SC_FAR;
    int count = 0, best = SC_TISSUE_OWN, within[3], cube[3], place;
    size_t block;

    for (int i = 0; i < 3; i++) { /* beyond the volume the nearest voxel */
        within[i] = sc_nearest_voxel(voxel[i], b->p->volume->size[i]) + b->phase[i];
        cube[i] = within[i] / SC_CUBE;
        within[i] %= SC_CUBE;
    }
    block = sc_brick_index(b->cubes, cube[0], cube[1], cube[2]);
    place = (within[2] * SC_CUBE + within[1]) * SC_CUBE + within[0];
    values[0] = values[1] = most;
    for (int k = 0; k < SC_TISSUE_CODES; k++) {
        const int code = nearest_first[k];
        const uint16_t id = sc_id_around(ids, at[0], at[1], at[2], code);
        const bool reached = open & places_before(code);
        int i = 0;

        if (!id) {
            open |= (uint32_t)reached << code;
            continue;
        }
        while (i < count && seen[i] != id)
            i++;
        if (i == count) {
            const float value = sc_field_at(b, block, place, id);
            const float less = value < values[0] ? value : values[0];

            seen[count] = id;
            numbers[count++] = value;
            values[0] = value > values[0] ? value : values[0];
            values[1] = less > values[1] ? less : values[1];
        }
        if (reached && numbers[i] > most) {
            most = numbers[i];
            best = code;
        }
    }
    return best;
}

/* Eight ids, side by side. */
typedef uint16_t eight_ids __attribute__((vector_size(8 * sizeof(uint16_t))));

static inline eight_ids lesser(eight_ids a, eight_ids c)
{
    const eight_ids is = (eight_ids)(a < c);

    return (a & is) | (c & ~is);
}

static inline eight_ids larger(eight_ids a, eight_ids c)
{
    return ~lesser(~a, ~c);
}

/* Write, for the bricks of a group, masks of the vertices around which there is tissue, and of
 * those around which there are different ones. */
static void find_tissues(const sc_group_ids *ids, uint64_t any[SC_GROUP_BRICKS],
                         uint64_t several[SC_GROUP_BRICKS])
{
    enum { EIGHT = 8, PER_EIGHT = EIGHT / SC_BRICK };
    eight_ids least[SC_CUBE / EIGHT][SC_IDS_EDGE]
                   [SC_IDS_EDGE]; /* less 1, so that none is larger than all */
    eight_ids most[SC_CUBE / EIGHT][SC_IDS_EDGE][SC_IDS_EDGE];

    for (int k = 0; k < SC_CUBE / EIGHT * SC_IDS_EDGE * SC_IDS_EDGE; k++) {
        const int y = k % SC_IDS_EDGE, z = k / SC_IDS_EDGE % SC_IDS_EDGE,
                  part = k / (SC_IDS_EDGE * SC_IDS_EDGE);
        eight_ids row[3];

        for (int x = 0; x < 3; x++)
            memcpy(&row[x], ids->at[z][y] + EIGHT * part + x, sizeof row[x]);
        least[part][z][y] = lesser(lesser(row[0] - 1, row[1] - 1), row[2] - 1);
        most[part][z][y] = larger(larger(row[0], row[1]), row[2]);
    }
    memset(any, 0, SC_GROUP_BRICKS * sizeof *any);
    memset(several, 0, SC_GROUP_BRICKS * sizeof *several);
    for (int k = 0; k < SC_CUBE / EIGHT * SC_CUBE * SC_CUBE; k++) {
        const int y = k % SC_CUBE, z = k / SC_CUBE % SC_CUBE, part = k / (SC_CUBE * SC_CUBE);
        const int brick =
            (z / SC_BRICK * SC_GROUP_EDGE + y / SC_BRICK) * SC_GROUP_EDGE + PER_EIGHT * part;
        eight_ids low = (eight_ids){0} - 1, high = {0};
        uint32_t none, same;

        for (int n = 0; n < 9; n++) {
            low = lesser(low, least[part][z + n / 3][y + n % 3]);
            high = larger(high, most[part][z + n / 3][y + n % 3]);
        }
        low = (low + 1) ^ high;
        none = sc_equal_bits((const uint16_t *)&high, 0);
        same = sc_equal_bits((const uint16_t *)&low, 0);
        for (int i = 0; i < PER_EIGHT; i++) {
            const int bit = sc_brick_bit(0, y, z), first = i * SC_BRICK;

            any[brick + i] |= (uint64_t)(~none >> first & SC_BRICK_ROW_BITS) << bit;
            several[brick + i] |= (uint64_t)(~same >> first & SC_BRICK_ROW_BITS) << bit;
        }
    }
}

/* @return whether sc_outer_value is positive. */
static inline bool is_tissue(float field)
{
    return field * SC_BORDER_STEPS - 0.5f > -1;
}

/* @return the index of vertex @p at of a group in the region of the field that find_brick reads. */
static inline int sided(const int at[3])
{
    return ((at[2] + BEFORE) * SIDED + at[1] + BEFORE) * SIDED + at[0] + BEFORE;
}

/* Find sides and codes of one brick of a group. @param field [SIDED] along each axis, of the outer
 * field from BEFORE voxels before the group on; NULL: sides are those of the labels. */
static void find_brick(const sc_record_writer *w, const sc_group_ids *ids, const int low[3], int n,
                       const float *field, uint64_t any, uint64_t several)
{
    const size_t brick = sc_brick_of_group(w, low, n);
    const int corner[3] = {n % SC_GROUP_EDGE * SC_BRICK,
                           n / SC_GROUP_EDGE % SC_GROUP_EDGE * SC_BRICK,
                           n / (SC_GROUP_EDGE * SC_GROUP_EDGE) * SC_BRICK};
    uint8_t *codes;
    uint8_t *inner;
    sc_brick_sides sides = {0, 0};

    if (brick == SIZE_MAX || !w->number[brick])
        return;
    codes = w->codes[w->number[brick] - 1];
    inner = w->inner[w->number[brick] - 1];
    for (int row = 0; row < SC_BRICK_LAYER; row++) {
        const int at[3] = {corner[0], corner[1] + row % SC_BRICK, corner[2] + row / SC_BRICK};
        const uint16_t *own = ids->at[at[2] + 1][at[1] + 1] + at[0] + 1;

        for (int x = 0; x < SC_BRICK; x++)
            sides.tissue |= (uint64_t)(field ? is_tissue(field[sided(at) + x]) : own[x] != 0)
                            << (row * SC_BRICK + x);
    }
    memset(codes, SC_TISSUE_OWN, SC_BRICK_VERTICES);
    for (uint64_t left = any; left; left &= left - 1) {
        const int bit = __builtin_ctzll(left);
        const int at[3] = {corner[0] + sc_bit_x(bit), corner[1] + sc_bit_y(bit),
                           corner[2] + sc_bit_z(bit)};
        const int voxel[3] = {low[0] + at[0] - 1, low[1] + at[1] - 1, low[2] + at[2] - 1};
        float values[2];

        if (several >> bit & 1) {
            codes[bit] = (uint8_t)sc_largest_tissue(w->b, ids, at, voxel, values);
            inner[bit] = sc_inner_value(values);
        } else if (!ids->at[at[2] + 1][at[1] + 1][at[0] + 1]) {
            for (int k = 1; codes[bit] == SC_TISSUE_OWN; k++)
                codes[bit] = sc_id_around(ids, at[0], at[1], at[2], nearest_first[k])
                                 ? nearest_first[k]
                                 : SC_TISSUE_OWN;
        }
        sides.moved |= (uint64_t)(codes[bit] != SC_TISSUE_OWN) << bit;
    }
    w->sides[w->number[brick] - 1] = sides;
}

/* Find sides and codes of groups [begin, end); an sc_range_fn on a writer. */
SC_WIDE_VECTORS static void find_groups(void *user, size_t begin, size_t end, int thread)
{
    const sc_record_writer *w = user;
    const uint64_t *masks[2] = {w->wanted, w->wanted};

    (void)thread;
    for (size_t group = begin; group < end; group++) {
        uint64_t any[SC_GROUP_BRICKS], several[SC_GROUP_BRICKS];
        float field[SIDED * SIDED * SIDED];
        sc_group_ids ids;
        int low[3], voxel[3], before[3];
        bool is;

        if (!sc_begin_group(w, masks, group, low))
            continue;
        for (int i = 0; i < 3; i++) {
            voxel[i] = low[i] - 1;
            before[i] = voxel[i] - BEFORE;
        }
        sc_read_group_ids(w->p->volume, voxel, &ids);
        find_tissues(&ids, any, several);
        is = sc_read_field(w->b, 0, before, SIDED, field);
        for (int n = 0; n < SC_GROUP_BRICKS; n++)
            find_brick(w, &ids, low, n, is ? field : NULL, any[n], several[n]);
    }
}

void sc_find_sides(const sc_ctx *ctx, sc_record_writer *w)
{
    sc_team_stage_for(ctx, SC_WORTH_SIDES, w->p->team, sc_brick_count(w->groups), 4, find_groups,
                      w);
}
