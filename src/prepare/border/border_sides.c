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
    const uint32_t *start = b->start;
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
    values[0] = most;
    values[1] = -SC_FAR;
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
    for (uint32_t tile = start[block]; tile <= start[block + 1]; tile++) { /* what lies farther */
        const bool last = tile == start[block + 1];
        const uint16_t id = last ? b->around[block].second : b->tiles.labels[tile];
        bool known = !id || (last && b->around[block].tissue != SC_TWO_TISSUES);

        for (int i = 0; i < count && !known; i++)
            known = seen[i] == id;
        if (!known)
            values[1] = fmaxf(values[1], fminf(values[0], sc_field_at(b, block, place, id)));
    }
    return best;
}

/* Vertices of a group, as bits: x of each row along y and z. */
typedef uint16_t vertex_rows[SC_CUBE][SC_CUBE];

enum { LAYER = SC_IDS_EDGE * SC_IDS_ROW /* ids of a layer of a group */ };

static inline uint16_t lesser(uint16_t a, uint16_t c)
{
    return a < c ? a : c;
}

static inline uint16_t larger(uint16_t a, uint16_t c)
{
    return a > c ? a : c;
}

/* Write the least of the ids of 3 x 3 places from each of a layer on, less one, by which background
 * is larger than all, and the largest. Rows follow each other, so that all are found side by side;
 * what lies beyond a row is of no use. */
SC_ALWAYS_INLINE void find_extremes(const uint16_t *ids, uint16_t least[LAYER],
                                    uint16_t most[LAYER])
{
    enum { ROW = SC_IDS_ROW };
    uint16_t low[LAYER], high[LAYER];

    for (int i = 0; i < LAYER - 2; i++) {
        const uint16_t a = (uint16_t)(ids[i] - 1), c = (uint16_t)(ids[i + 1] - 1);

        low[i] = lesser(lesser(a, c), (uint16_t)(ids[i + 2] - 1));
        high[i] = larger(larger(ids[i], ids[i + 1]), ids[i + 2]);
    }
    for (int i = 0; i < LAYER - 2 * ROW - 2; i++) {
        least[i] = lesser(lesser(low[i], low[i + ROW]), low[i + 2 * ROW]);
        most[i] = larger(larger(high[i], high[i + ROW]), high[i + 2 * ROW]);
    }
}

/* Write of which vertices of a group there is tissue around, and of which there are different ones.
 */
SC_ALWAYS_INLINE void find_tissues(const sc_group_ids *ids, vertex_rows any, vertex_rows several)
{
    uint16_t least[3][LAYER] = {{0}}, most[3][LAYER] = {{0}}, differ[LAYER], all[LAYER];

    for (int z = -2; z < SC_CUBE; z++) {
        find_extremes(ids->at[z + 2][0], least[(z + 2) % 3], most[(z + 2) % 3]);
        if (z < 0)
            continue;
        for (int i = 0; i < LAYER; i++) {
            const uint16_t low = lesser(lesser(least[0][i], least[1][i]), least[2][i]);

            all[i] = larger(larger(most[0][i], most[1][i]), most[2][i]);
            differ[i] = (uint16_t)(low + 1) ^ all[i];
        }
        for (int y = 0; y < SC_CUBE; y++) {
            const uint16_t *some = all + y * SC_IDS_ROW, *other = differ + y * SC_IDS_ROW;

            any[z][y] = (uint16_t) ~(sc_equal_bits(some, 0) | sc_equal_bits(some + 8, 0) << 8);
            several[z][y] =
                (uint16_t) ~(sc_equal_bits(other, 0) | sc_equal_bits(other + 8, 0) << 8);
        }
    }
}

/* What is known of a group while its bricks are looked at. */
typedef struct group_sides {
    sc_group_ids ids;
    vertex_rows any, several;           /* tissue around; different ones */
    vertex_rows own;                    /* of several those whose own tissue is the one */
    uint8_t inner[SC_TILE_VOXELS];      /* of those, the value of the record; 0 of others */
    float field[SIDED * SIDED * SIDED]; /* outer, from BEFORE voxels before the group on */
    bool has_field;                     /* or sides are those of the labels */
} group_sides;

/* The two largest fields at the vertices of a group, of the tissues around each, and the field of
 * its own tissue. */
typedef struct rivals {
    float most[SC_TILE_VOXELS], next[SC_TILE_VOXELS], own[SC_TILE_VOXELS];
} rivals;

/* Find the vertices of a group, as bits, around which @p label is, to @p around. */
static void find_around(const sc_group_ids *ids, uint16_t label, vertex_rows around)
{
    uint32_t rows[SC_IDS_EDGE][SC_IDS_EDGE];

    for (int k = 0; k < SC_IDS_EDGE * SC_IDS_EDGE; k++) {
        const uint16_t *row = ids->at[k / SC_IDS_EDGE][k % SC_IDS_EDGE];
        const uint32_t bits = sc_equal_bits(row, label) | sc_equal_bits(row + 8, label) << 8 |
                              sc_equal_bits(row + 16, label) << 16;

        rows[k / SC_IDS_EDGE][k % SC_IDS_EDGE] = bits | bits >> 1 | bits >> 2;
    }
    for (int z = 0; z < SC_CUBE; z++) {
        for (int y = 0; y < SC_CUBE; y++) {
            uint32_t bits = 0;

            for (int n = 0; n < 9; n++)
                bits |= rows[z + n / 3][y + n % 3];
            around[z][y] = (uint16_t)bits;
        }
    }
}

/* Take the field of a tissue into account, as the largest where that is around. @param field
 * [SC_CUBE] along each axis. @param around of vertices as bits. */
SC_ALWAYS_INLINE void rank_field(const group_sides *g, uint16_t label, const float *field,
                                 const vertex_rows around, rivals *r)
{
    for (int k = 0; k < SC_CUBE * SC_CUBE; k++) {
        const int y = k % SC_CUBE, z = k / SC_CUBE, at = k * SC_CUBE;
        const uint16_t *ids = g->ids.at[z + 1][y + 1] + 1;
        const int32_t bits = around[z][y];
        float value[SC_CUBE], less[SC_CUBE];

        if (!g->several[z][y])
            continue;
        for (int x = 0; x < SC_CUBE; x++) {
            value[x] = bits >> x & 1 ? field[at + x] : -2 * SC_FAR;
            r->own[at + x] = ids[x] == label ? value[x] : r->own[at + x];
        }
        for (int x = 0; x < SC_CUBE; x++) {
            less[x] = bits >> x & 1 ? fminf(value[x], r->most[at + x]) : field[at + x];
            r->most[at + x] = fmaxf(value[x], r->most[at + x]);
        }
        for (int x = 0; x < SC_CUBE; x++)
            r->next[at + x] = fmaxf(less[x], r->next[at + x]);
    }
}

enum { MOST_RIVALS = 256 };
/* List the tissues whose fields the vertices of a group have, to @p out. @param voxel the lowest of
 * the group, all of which lies in the volume. @return how many there are; 0 if these are too many,
 * or some have no field. */
static int list_rivals(const sc_borders *b, const int voxel[3], uint16_t out[MOST_RIVALS])
{
    int count = 0;

    for (int n = 0; n < 8; n++) {
        const int x = (voxel[0] + b->phase[0] + (n & 1) * (SC_CUBE - 1)) / SC_CUBE,
                  y = (voxel[1] + b->phase[1] + (n >> 1 & 1) * (SC_CUBE - 1)) / SC_CUBE,
                  z = (voxel[2] + b->phase[2] + (n >> 2) * (SC_CUBE - 1)) / SC_CUBE;
        const size_t block = sc_brick_index(b->cubes, x, y, z);
        const sc_cube *around = &b->around[block];

        if (around->tissue == SC_MANY_TISSUES && around->second == SC_NO_LABEL)
            return 0;
        for (uint32_t tile = b->start[block]; tile <= b->start[block + 1]; tile++) {
            const uint16_t id = tile < b->start[block + 1]         ? b->tiles.labels[tile]
                                : around->tissue == SC_TWO_TISSUES ? around->second
                                                                   : 0;
            int i = 0;

            while (i < count && out[i] != id)
                i++;
            if (!id || i < count)
                continue;
            if (count == MOST_RIVALS)
                return 0;
            out[count++] = id;
        }
    }
    return count;
}

/* Find at which vertices of a group the tissue of its own label has the largest field, of those
 * around: g->own, and inner there; which are most vertices between tissues. Where that is asked for
 * beyond the volume none is found. @param voxel the lowest of the group. */
SC_ALWAYS_INLINE void find_own(const sc_borders *b, const int voxel[3], group_sides *g)
{
    const int *size = b->p->volume->size;
    float field[SC_TILE_VOXELS];
    uint16_t labels[MOST_RIVALS];
    vertex_rows around;
    rivals r;
    int count;

    memset(g->own, 0, sizeof g->own);
    memset(g->inner, 0, sizeof g->inner);
    for (int i = 0; i < 3; i++) {
        if (voxel[i] < 0 || voxel[i] + SC_CUBE > size[i])
            return;
    }
    count = list_rivals(b, voxel, labels);
    if (!count)
        return;
    for (int i = 0; i < SC_TILE_VOXELS; i++) {
        r.most[i] = r.own[i] = -2 * SC_FAR;
        r.next[i] = -SC_FAR;
    }
    for (int i = 0; i < count; i++) {
        (void)sc_read_field(b, labels[i], voxel, SC_CUBE, field);
        find_around(&g->ids, labels[i], around);
        rank_field(g, labels[i], field, (const uint16_t(*)[SC_CUBE])around, &r);
    }
    for (int i = 0; i < SC_TILE_VOXELS; i++) {
        const int x = i % SC_CUBE, y = i / SC_CUBE % SC_CUBE, z = i / (SC_CUBE * SC_CUBE);

        if (!(g->several[z][y] >> x & 1) || !g->ids.at[z + 1][y + 1][x + 1] || r.own[i] < r.most[i])
            continue;
        g->own[z][y] |= (uint16_t)(1u << x);
        g->inner[i] = sc_inner_value((const float[2]){r.most[i], fminf(r.next[i], r.most[i])});
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

/* @return the code of vertex @p at of a group, around which there is tissue. @param inner set to
 * the value of its record of the inner field if there are several. */
static uint8_t find_code(const sc_record_writer *w, const group_sides *g, const int voxel[3],
                         const int at[3], uint8_t *inner)
{
    int k = 0;

    if (g->several[at[2]][at[1]] >> at[0] & 1) {
        const int here[3] = {voxel[0] + at[0], voxel[1] + at[1], voxel[2] + at[2]};
        float values[2];
        const int code = sc_largest_tissue(w->b, &g->ids, at, here, values);

        *inner = sc_inner_value(values);
        return (uint8_t)code;
    }
    while (!sc_id_around(&g->ids, at[0], at[1], at[2], nearest_first[k]))
        k++;
    return nearest_first[k];
}

/* @return which of the labels of a row of a brick are not background, as bits. */
static inline unsigned labelled_bits(const uint16_t ids[SC_BRICK])
{
    unsigned bits = 0;

    for (int x = 0; x < SC_BRICK; x++)
        bits |= (unsigned)(ids[x] != 0) << x;
    return bits;
}

/* Find sides and codes of brick @p n of a group, whose lowest vertex is @p low. */
static void find_brick(const sc_record_writer *w, const group_sides *g, const int low[3], int n)
{
    const size_t brick = sc_brick_of_group(w, low, n);
    const int corner[3] = {n % SC_GROUP_EDGE * SC_BRICK,
                           n / SC_GROUP_EDGE % SC_GROUP_EDGE * SC_BRICK,
                           n / (SC_GROUP_EDGE * SC_GROUP_EDGE) * SC_BRICK};
    const int voxel[3] = {low[0] - 1, low[1] - 1, low[2] - 1};
    sc_brick_sides sides = {0, 0};
    uint8_t *codes, *inner;

    if (brick == SIZE_MAX || !w->number[brick])
        return;
    codes = w->codes[w->number[brick] - 1];
    inner = w->inner[w->number[brick] - 1];
    memset(codes, SC_TISSUE_OWN, SC_BRICK_VERTICES);
    for (int row = 0; row < SC_BRICK_LAYER; row++) {
        const int y = corner[1] + row % SC_BRICK, z = corner[2] + row / SC_BRICK;
        const uint16_t *own = g->ids.at[z + 1][y + 1] + corner[0] + 1;
        const float *field = g->field + sided((const int[3]){corner[0], y, z});
        const unsigned is = labelled_bits(own);
        /* where the tissue may be another one than that of the label */
        const unsigned open = (g->any[z][y] & ~g->own[z][y]) >> corner[0] &
                              (g->several[z][y] >> corner[0] | ~is) & SC_BRICK_ROW_BITS;

        for (int x = 0; x < SC_BRICK; x++)
            sides.tissue |= (uint64_t)(g->has_field ? is_tissue(field[x]) : is >> x & 1)
                            << (row * SC_BRICK + x);
        memcpy(inner + row * SC_BRICK, g->inner + (z * SC_CUBE + y) * SC_CUBE + corner[0],
               SC_BRICK);
        for (unsigned left = open; left; left &= left - 1) {
            const int x = __builtin_ctz(left), bit = row * SC_BRICK + x;

            codes[bit] = find_code(w, g, voxel, (const int[3]){corner[0] + x, y, z}, &inner[bit]);
            sides.moved |= (uint64_t)(codes[bit] != SC_TISSUE_OWN) << bit;
        }
    }
    w->sides[w->number[brick] - 1] = sides;
}

/* Find sides and codes of groups [begin, end); an sc_range_fn on a writer. */
SC_WIDE_VECTORS static void find_groups(void *user, size_t begin, size_t end, int thread)
{
    const sc_record_writer *w = user;
    const uint64_t *masks[2] = {w->wanted, w->wanted};
    group_sides g;

    for (size_t group = begin; group < end; group++) {
        int low[3], voxel[3], before[3];

        if (!sc_begin_group(w, masks, group, low))
            continue;
        for (int i = 0; i < 3; i++) {
            voxel[i] = low[i] - 1;
            before[i] = voxel[i] - BEFORE;
        }
        sc_read_group_ids(w->p->volume, voxel, &g.ids);
        find_tissues(&g.ids, g.any, g.several);
        find_own(w->b, voxel, &g);
        g.has_field = sc_read_field(w->b, 0, before, SIDED, g.field);
        for (int n = 0; n < SC_GROUP_BRICKS; n++)
            find_brick(w, &g, low, n);
    }
}

void sc_find_sides(const sc_ctx *ctx, sc_record_writer *w)
{
    sc_team_stage_for(ctx, SC_WORTH_SIDES, w->p->team, sc_brick_count(w->groups), 4, find_groups,
                      w);
}
