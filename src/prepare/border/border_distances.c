/* SPDX-License-Identifier: BSD-3-Clause */
/* The data of the fields of borders: signed distances. The true surface lies within half a voxel of
 * the voxel centre on the other side that is nearest, along the normal: so the distance to the
 * border, in voxels, is that to the centre less one half. It is unbiased: neither does it move
 * curved surfaces, as a blur does, nor does it depend on what lies farther away. Counted in voxels,
 * a plane of any direction has the same distance in volumes whose voxels are longer than wide.
 *
 * Squared distances are whole numbers up to SC_REACH_SQUARED. They are found axis by axis (Saito
 * and Toriwaki 1994, "New algorithms for euclidean distance transformation"), for the voxels of a
 * block, from the labels within SC_REACH of it. */
#include "border/border.h"

enum {
    MARGIN = SC_REACH - 1, /* the farthest voxels that count */
    EDGE = SC_CUBE + 2 * MARGIN,
    FAR_SQUARED = SC_REACH_SQUARED,
    ROW = 32,            /* room for a row */
    CACHED = 6,          /* so many labels of a block are measured once */
    WINDOW = 8 + MARGIN, /* bits that decide about eight voxels of a row on one side */
    EMPTY = 0,           /* kinds of rows: no voxel is set, */
    FULL = 1,            /* all that count are, */
    MIXED = 2
};

/* Squared distances of eight voxels to the nearest set bit on one side, for all windows. */
typedef struct side_table {
    uint8_t at[1 << WINDOW][8];
} side_table;

/* Squared distances of the voxels of a block. */
typedef struct square_block {
    uint8_t at[SC_CUBE][SC_CUBE][SC_CUBE];
} square_block;

/* What the threads share. */
typedef struct measurer {
    sc_borders *b;
    side_table *low, *high; /* to the side of smaller x, itself included, and of larger x */
} measurer;

/* What a thread has for itself. */
typedef struct workspace {
    uint16_t ids[EDGE][EDGE][ROW]; /* labels around the block; SC_NO_LABEL beyond the volume */
    uint8_t rows[EDGE][EDGE][SC_CUBE];
    uint8_t kinds[EDGE][EDGE];
    uint8_t planes[EDGE][SC_CUBE][SC_CUBE];
    square_block background, tissue, nearest, second; /* nearest tissue, and nearest other one */
    square_block other;           /* the nearest one that is not that of the field */
    square_block own[CACHED + 1]; /* each tissue; the last for all further ones */
    uint16_t nearest_id[SC_TILE_VOXELS];
    uint16_t own_ids[SC_TILE_VOXELS]; /* labels of the block */
    int8_t is[SC_TILE_VOXELS];
    bool ranked;                             /* nearest, nearest_id and second are known */
    bool at_end;                             /* the block reaches beyond the volume */
    float voxels[SC_CUBE][SC_CUBE][SC_CUBE]; /* distances of one field */
    uint8_t moving[SC_TILE_VOXELS];          /* 0 where the border of the field is out of reach */
} workspace;

/* Fill the two tables. */
static void fill_tables(side_table *low, side_table *high)
{
    for (int bits = 0; bits < 1 << WINDOW; bits++) {
        for (int x = 0; x < 8; x++) {
            int below = FAR_SQUARED, above = FAR_SQUARED;

            for (int d = MARGIN; d >= 0; d--) {
                if (bits >> (x + MARGIN - d) & 1)
                    below = d * d;
                if (bits >> (x + d) & 1)
                    above = d * d;
            }
            low->at[bits][x] = (uint8_t)below;
            high->at[bits][x] = (uint8_t)above;
        }
    }
}

/* Read the labels around a block. */
static void read_labels(const sc_volume *v, const int low[3], workspace *w)
{
    const int x0 = low[0] - MARGIN;
    const int begin = x0 < 0 ? -x0 : 0;
    const int end = v->size[0] - x0 < EDGE ? v->size[0] - x0 : EDGE;

    for (int z = 0; z < EDGE; z++) {
        for (int y = 0; y < EDGE; y++) {
            const int vy = low[1] - MARGIN + y, vz = low[2] - MARGIN + z;
            uint16_t *to = w->ids[z][y];
            size_t row;

            if (begin > 0 || end < EDGE || vy < 0 || vz < 0 || vy >= v->size[1] || vz >= v->size[2])
                memset(to, 0xff, sizeof w->ids[z][y]);
            if (vy < 0 || vz < 0 || vy >= v->size[1] || vz >= v->size[2])
                continue;
            row = ((size_t)vz * (size_t)v->size[1] + (size_t)vy) * (size_t)v->size[0];
            if (end - begin == EDGE) /* a length that the compiler knows */
                sc_volume_read_ids(v, row + (size_t)x0, EDGE, to);
            else
                sc_volume_read_ids(v, row + (size_t)(x0 + begin), (size_t)(end - begin),
                                   to + begin);
        }
    }
    for (int k = 0; k < SC_CUBE * SC_CUBE; k++)
        memcpy(w->own_ids + k * SC_CUBE,
               w->ids[k / SC_CUBE + MARGIN][k % SC_CUBE + MARGIN] + MARGIN,
               SC_CUBE * sizeof *w->own_ids);
    w->at_end = false;
    for (int i = 0; i < 3; i++)
        w->at_end = w->at_end || low[i] < 0 || low[i] + SC_CUBE > v->size[i];
}

/* @return the voxels of a row of w->ids that are @p label, as bits. */
static uint32_t equal_bits(const uint16_t *ids, uint32_t label)
{
    uint32_t bits = 0;

    for (int x = 0; x < ROW; x += 8)
        bits |= sc_equal_bits(ids + x, label) << x;
    return bits & ((1u << EDGE) - 1);
}

/* As equal_bits; SC_MANY_TISSUES stands for any tissue. */
static uint32_t bits_of_row(const uint16_t *ids, uint32_t label)
{
    if (label != SC_MANY_TISSUES)
        return equal_bits(ids, label);
    return ((1u << EDGE) - 1) & ~equal_bits(ids, 0) & ~equal_bits(ids, SC_NO_LABEL);
}

/* Fill w->rows and w->kinds for a label: squared distances along x alone. */
static void measure_rows(const measurer *m, uint32_t label, workspace *w)
{
    const uint32_t all = (1u << EDGE) - 1, window = (1u << WINDOW) - 1;

    for (int z = 0; z < EDGE; z++) {
        for (int y = 0; y < EDGE; y++) {
            const uint32_t bits = bits_of_row(w->ids[z][y], label);
            uint8_t *to = w->rows[z][y];

            w->kinds[z][y] = bits == 0 ? EMPTY : bits == all ? FULL : MIXED;
            if (w->kinds[z][y] != MIXED)
                continue;
            for (int half = 0; half < 2; half++) {
                const uint8_t *below = m->low->at[bits >> (8 * half) & window];
                const uint8_t *above = m->high->at[bits >> (8 * half + MARGIN) & window];

                for (int x = 0; x < 8; x++)
                    to[8 * half + x] = below[x] < above[x] ? below[x] : above[x];
            }
        }
    }
}

/* A row of squared distances. */
typedef uint8_t row16 __attribute__((vector_size(SC_CUBE)));

/* @return the squared distances of a row, lowered to those of another row, @p square farther. */
static inline row16 lower(row16 row, const uint8_t *other, uint8_t square)
{
    row16 far, less;

    memcpy(&far, other, sizeof far);
    far += square;
    less = (row16)(far < row);
    return (far & less) | (row & ~less);
}

/* Find the squared distances of the voxels of a block to the nearest voxel of @p label, or of any
 * tissue (SC_MANY_TISSUES). */
SC_WIDE_VECTORS static void measure(const measurer *m, uint32_t label, workspace *w,
                                    square_block *out)
{
    static const uint8_t none[SC_CUBE] = {0};
    uint8_t any[EDGE][SC_CUBE];

    measure_rows(m, label, w);
    for (int z = 0; z < EDGE; z++) {
        for (int y = 0; y < SC_CUBE; y++) {
            const uint8_t *kinds = w->kinds[z] + y;
            row16 row = (row16){0} + FAR_SQUARED;

            any[z][y] = 0;
            for (int d = 0; d <= 2 * MARGIN; d++) {
                if (kinds[d] == EMPTY)
                    continue;
                any[z][y] = 1;
                row = lower(row, kinds[d] == FULL ? none : w->rows[z][y + d],
                            (uint8_t)((d - MARGIN) * (d - MARGIN)));
            }
            memcpy(w->planes[z][y], &row, sizeof row);
        }
    }
    for (int z = 0; z < SC_CUBE; z++) {
        for (int y = 0; y < SC_CUBE; y++) {
            row16 row = (row16){0} + FAR_SQUARED;

            for (int d = 0; d <= 2 * MARGIN; d++) {
                if (any[z + d][y])
                    row = lower(row, w->planes[z + d][y], (uint8_t)((d - MARGIN) * (d - MARGIN)));
            }
            memcpy(out->at[z][y], &row, sizeof row);
        }
    }
}

/* Let the voxels of a block go on linearly by one beyond the volume where it ends, or begins,
 * within a cell. @param begin, end of the volume within the block. */
static void go_on(float (*voxels)[SC_CUBE][SC_CUBE], const int begin[3], const int end[3])
{
    static const int steps[3] = {1, SC_CUBE, SC_CUBE * SC_CUBE};

    for (int axis = 0; axis < 3; axis++) {
        const int step = steps[axis], a = steps[(axis + 1) % 3], c = steps[(axis + 2) % 3];
        const bool more = end[axis] - begin[axis] > 1;

        for (int k = 0; k < SC_CUBE * SC_CUBE; k++) {
            float *line = (float *)voxels + k % SC_CUBE * a + k / SC_CUBE * c;
            float *last = line + (end[axis] - 1) * step, *first = line + begin[axis] * step;

            if (end[axis] % 2)
                last[step] = more ? 2 * last[0] - last[-step] : last[0];
            if (begin[axis] % 2)
                first[-step] = more ? 2 * first[0] - first[step] : first[0];
        }
    }
}

/* Set data and box of a tile from the distances of its voxels: the mean of the eight of a cell. A
 * cell is free if most of its voxels are; it is frozen if all voxels are out of reach.
 * @param moving [voxels]: 0 for those. */
SC_WIDE_VECTORS static void average(const sc_borders *b, size_t tile,
                                    float (*voxels)[SC_CUBE][SC_CUBE], const uint8_t *moving)
{
    const int8_t *squares = b->squares[tile];
    float *data = b->data[tile], *box = b->box[tile];
    int low[3], begin[3], end[3];
    bool odd = false;

    sc_cube_low(b, b->tiles.cube_of[tile], low);
    for (int i = 0; i < 3; i++) {
        begin[i] = low[i] < 0 ? -low[i] : 0;
        end[i] =
            b->p->volume->size[i] - low[i] < SC_CUBE ? b->p->volume->size[i] - low[i] : SC_CUBE;
        odd = odd || begin[i] % 2 || end[i] % 2;
    }
    if (odd)
        go_on(voxels, begin, end);
    for (int k = 0; k < SC_CUBE_CELLS * SC_CUBE_CELLS; k++) {
        const int y = 2 * (k % SC_CUBE_CELLS), z = 2 * (k / SC_CUBE_CELLS);
        float pair[SC_CUBE];
        int8_t free[SC_CUBE];
        uint8_t any[SC_CUBE];

        for (int x = 0; x < SC_CUBE; x++) {
            const int at = (z * SC_CUBE + y) * SC_CUBE + x;
            const int up = at + SC_CUBE, in = at + SC_CUBE * SC_CUBE;

            pair[x] = (voxels[z][y][x] + voxels[z + 1][y + 1][x]) +
                      (voxels[z][y + 1][x] + voxels[z + 1][y][x]);
            free[x] = (int8_t)((squares[at] == 0) + (squares[up] == 0) + (squares[in] == 0) +
                               (squares[in + SC_CUBE] == 0));
            any[x] = moving[at] | moving[up] | moving[in] | moving[in + SC_CUBE];
        }
        for (int x = 0; x < SC_CUBE; x += 2) {
            *data++ = 0.125f * (pair[x] + pair[x + 1]);
            *box++ = !(any[x] | any[x + 1]) || fabsf(data[-1]) >= SC_BAND ? SC_BOX_FROZEN
                     : free[x] + free[x + 1] > 4 && b->tiles.labels[tile] ? SC_BOX_FREE
                                                                          : SC_CELL_BOX;
        }
    }
}

/* Set squares of a tile and w->moving. @param inside, outside squared distances, of voxels on the
 * positive side and of others. @param is [voxels]: 1 on the positive side, 0 elsewhere. */
SC_WIDE_VECTORS static void set_squares(const uint8_t *restrict inside,
                                        const uint8_t *restrict outside, const int8_t *restrict is,
                                        int8_t *restrict squares, workspace *restrict w)
{
    float *voxels = (float *)w->voxels;

    for (int i = 0; i < SC_TILE_VOXELS; i++) {
        const int8_t high = (int8_t)(inside[i] & -is[i]);
        const int8_t low = (int8_t)(outside[i] & (is[i] - 1));

        squares[i] = (int8_t)(high - low);
        w->moving[i] = high + low < FAR_SQUARED;
    }
    sc_distances_of(squares, SC_TILE_VOXELS, voxels);
}

/* Set squares and data of the tile of background against all tissue. What lies beyond the volume is
 * not known, so that tissue goes on there. */
SC_WIDE_VECTORS static void set_outer(const measurer *m, size_t tile, workspace *w)
{
    int8_t *squares = m->b->squares[tile];

    measure(m, 0, w, &w->background);
    if (!w->ranked)
        measure(m, SC_MANY_TISSUES, w, &w->tissue);
    for (int i = 0; i < SC_TILE_VOXELS; i++)
        w->is[i] = w->own_ids[i] != 0;
    set_squares(w->background.at[0][0], w->tissue.at[0][0], w->is, squares, w);
    for (int i = 0; i < SC_TILE_VOXELS && w->at_end; i++)
        squares[i] = w->own_ids[i] == SC_NO_LABEL ? 0 : squares[i];
    average(m->b, tile, w->voxels, w->moving);
}

/* Write the squared distances to the nearest tissue that is not @p label. @param nearest, second to
 * the nearest tissue, @p nearest_id, and to the nearest other one. */
SC_ALWAYS_INLINE void find_other(const uint16_t *restrict nearest_id, uint16_t label,
                                 const uint8_t *restrict nearest, const uint8_t *restrict second,
                                 uint8_t *restrict out)
{
    for (int i = 0; i < SC_TILE_VOXELS; i++)
        out[i] = nearest_id[i] == label ? second[i] : nearest[i];
}

/* Let the field of a tissue be free in the background: there its voxels are half of the difference
 * of the distances to the others and to it, and squares are 0. @param moving set for all voxels.
 */
SC_ALWAYS_INLINE void set_free(const uint16_t *restrict ids, const uint8_t *restrict own,
                               const uint8_t *restrict other, int8_t *restrict squares,
                               float *restrict voxels, uint8_t *restrict moving)
{
    for (int i = 0; i < SC_TILE_VOXELS; i++) {
        const float between = 0.5f * (sqrtf((float)other[i]) - sqrtf((float)own[i]));
        const float far = own[i] < FAR_SQUARED ? SC_FAR : 0;
        const float near = own[i] < FAR_SQUARED ? between : -SC_FAR;
        const bool free = (uint16_t)(ids[i] + 1) < 2; /* 0 or SC_NO_LABEL */

        voxels[i] = free ? other[i] < FAR_SQUARED ? near : far : voxels[i];
    }
    for (int i = 0; i < SC_TILE_VOXELS; i++) {
        moving[i] = (own[i] < FAR_SQUARED) & (other[i] < FAR_SQUARED);
        squares[i] = (uint16_t)(ids[i] + 1) < 2 ? 0 : squares[i];
    }
}

/* Set squares and data of the tile of a tissue against the others. w->nearest, w->second and
 * w->nearest_id are known. @param number of the tissue among those of the block. */
SC_WIDE_VECTORS static void set_inner(const measurer *m, size_t tile, int number, workspace *w)
{
    const uint16_t label = m->b->tiles.labels[tile];
    const uint8_t *own = w->own[number < CACHED ? number : CACHED].at[0][0];
    int8_t *squares = m->b->squares[tile];

    if (number >= CACHED)
        measure(m, label, w, &w->own[CACHED]);
    find_other(w->nearest_id, label, w->nearest.at[0][0], w->second.at[0][0], w->other.at[0][0]);
    for (int i = 0; i < SC_TILE_VOXELS; i++)
        w->is[i] = w->own_ids[i] == label;
    set_squares(w->other.at[0][0], own, w->is, squares, w);
    set_free(w->own_ids, own, w->other.at[0][0], squares, (float *)w->voxels, w->moving);
    average(m->b, tile, w->voxels, w->moving);
}

/* Take a tissue, whose squared distances are @p own, into account in w->nearest, nearest_id and
 * second. */
SC_WIDE_VECTORS static void rank_tissue(workspace *w, uint16_t label, const uint8_t *restrict own)
{
    uint8_t *restrict nearest = w->nearest.at[0][0], *restrict second = w->second.at[0][0];

    for (int i = 0; i < SC_TILE_VOXELS; i++) {
        const bool nearer = own[i] < nearest[i];
        const uint8_t farther = nearer ? nearest[i] : own[i];

        second[i] = farther < second[i] ? farther : second[i];
        nearest[i] = nearer ? own[i] : nearest[i];
        w->nearest_id[i] = nearer ? label : w->nearest_id[i];
    }
}

/* Set the strengths at the cells of a tile: the mean of those of the tissue in the cells up to two
 * away, along each axis; where there is none, that of the strongest. */
static void set_strengths(const sc_borders *b, size_t tile, const workspace *w)
{
    enum { ALL = EDGE / 2 };
    float sums[ALL][ALL][ALL] = {{{0}}}, counts[ALL][ALL][ALL] = {{{0}}};

    for (int i = 0; i < EDGE * EDGE * EDGE; i++) {
        const int x = i % EDGE, y = i / EDGE % EDGE, z = i / (EDGE * EDGE);
        const uint16_t id = w->ids[z][y][x];

        if (!id || id == SC_NO_LABEL)
            continue;
        sums[z / 2][y / 2][x / 2] += sc_mean_strength(b->p->smooth[id]);
        counts[z / 2][y / 2][x / 2] += 1;
    }
    for (int i = 0; i < SC_TILE_CELLS; i++) {
        const int x = i % SC_CUBE_CELLS, y = i / SC_CUBE_CELLS % SC_CUBE_CELLS,
                  z = i / (SC_CUBE_CELLS * SC_CUBE_CELLS);
        float sum = 0, count = 0;

        for (int n = 0; n < 125; n++) {
            sum += sums[z + n / 25][y + n / 5 % 5][x + n % 5];
            count += counts[z + n / 25][y + n / 5 % 5][x + n % 5];
        }
        b->strengths[tile][i] = count > 0 ? sum / count : b->strength;
    }
}

/* Find for each voxel the distance to the nearest tissue, which that is, and the distance to the
 * nearest other one. */
static void rank_tissues(const measurer *m, size_t block, workspace *w)
{
    const size_t begin = m->b->start[block], end = m->b->start[block + 1];
    int number = 0;

    memset(&w->nearest, FAR_SQUARED, sizeof w->nearest);
    memset(&w->second, FAR_SQUARED, sizeof w->second);
    memset(w->nearest_id, 0, sizeof w->nearest_id);
    for (size_t tile = begin; tile < end; tile++) {
        const uint16_t label = m->b->tiles.labels[tile];
        square_block *measured = &w->own[number < CACHED ? number : CACHED];
        const uint8_t *own = measured->at[0][0];

        if (!label)
            continue;
        number++;
        measure(m, label, w, measured);
        rank_tissue(w, label, own);
    }
    if (m->b->around[block].tissue == SC_TWO_TISSUES) {
        measure(m, m->b->around[block].second, w, &w->own[CACHED]);
        rank_tissue(w, m->b->around[block].second, w->own[CACHED].at[0][0]);
    }
}

/* Set squares and data of the tiles of cubes [begin, end); an sc_range_fn on a measurer. */
SC_WIDE_VECTORS static void measure_cubes(void *user, size_t begin, size_t end, int thread)
{
    const measurer *m = user;
    const sc_borders *b = m->b;
    workspace w;

    for (size_t block = begin; block < end; block++) {
        const size_t first = b->start[block], last = b->start[block + 1];
        int low[3], number = 0;

        if (first == last)
            continue;
        sc_cube_low(b, block, low);
        read_labels(b->p->volume, low, &w);
        w.ranked = b->tiles.labels[last - 1] != 0;
        if (w.ranked)
            rank_tissues(m, block, &w);
        if (w.ranked)
            w.tissue = w.nearest;
        for (size_t tile = first; tile < last; tile++) {
            const int this = b->tiles.labels[tile] ? number++ : 0;

            if (b->strengths)
                set_strengths(b, tile, &w);
            if (b->tiles.labels[tile])
                set_inner(m, tile, this, &w);
            else
                set_outer(m, tile, &w);
        }
    }
}

/* Place the arrays of cells that no stage after sc_weigh_cells reads in the memory of those of
 * voxels. */
static void share_fine(sc_borders *b)
{
    float(*cells)[SC_TILE_CELLS] = (void *)b->fine;
    float(**const arrays[])[SC_TILE_CELLS] = {&b->data, &b->box, &b->spare[0], &b->spare[1]};
    enum { ARRAYS = sizeof arrays / sizeof arrays[0] };

    _Static_assert(ARRAYS * sizeof *cells == sizeof *b->fine, "they fill it");
    for (size_t i = 0; i < ARRAYS; i++)
        *arrays[i] = cells + i * (b->tiles.count + 1);
}

sc_status sc_measure_distances(const sc_ctx *ctx, sc_borders *b)
{
    measurer m = {.b = b};
    SC_OWN(sc_free_at) void *low = NULL, *high = NULL;
    void *block;

    SC_PASS(sc_team_agree(b->p->team, sc_alloc(ctx, 1, sizeof *m.low, &low)));
    SC_PASS(sc_team_agree(b->p->team, sc_alloc(ctx, 1, sizeof *m.high, &high)));
    m.low = low;
    m.high = high;
    fill_tables(m.low, m.high);
    SC_PASS(sc_team_alloc(ctx, b->p->team, b->tiles.count + 1, sizeof *b->squares, &block));
    b->squares = block;
    b->strength = sc_mean_strength(b->p->kinds[b->p->kind_count - 1]);
    if (b->p->kind_count > 1) {
        SC_PASS(sc_team_alloc(ctx, b->p->team, b->tiles.count + 1, sizeof *b->strengths, &block));
        b->strengths = block;
    }
    SC_PASS(sc_team_alloc(ctx, b->p->team, b->tiles.count + 1, sizeof *b->fine, &block));
    b->fine = block;
    share_fine(b);
    sc_team_stage_for(ctx, SC_WORTH_DISTANCES, b->p->team, b->cube_count, 16, measure_cubes, &m);
    return sc_find_beside(ctx, b);
}
