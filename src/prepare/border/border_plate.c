/* SPDX-License-Identifier: BSD-3-Clause */
/* The smoothest field: the energy of a thin plate, |(I - B) field|^2 with the binomial filter B, is
 * lowered by projected gradient steps, field <- sc_clip(2 B field - B^2 field). The box to which it
 * is clipped is half a drawn step to both sides of the data, a drawn step being two voxels. Steps
 * have momentum (Nesterov 1983, Beck and Teboulle 2009), which makes six of them worth twice as
 * many. First all fields are made so at cells of two voxels. That is the answer where both sides of
 * the border are thick. Where one is thinner, voxels decide, from that answer on, in a box of half
 * a voxel, so that each keeps its side; between the two the fields are blended. */
#include "border/border.h"

enum {
    STEPS = 6,      /* of cells */
    FINE_STEPS = 2, /* of voxels */
    HALO = 2,       /* elements that one step reads beyond those that it writes */
    EDGE = SC_CUBE_CELLS + 2 * HALO,
    ONCE = EDGE - 2,
    FINE_HALO = HALO * FINE_STEPS,
    FINE_EDGE = SC_CUBE + 2 * FINE_HALO
};
typedef const float cell_array[SC_TILE_CELLS];

/* What the threads share in one step. */
typedef struct stepper {
    sc_borders *b;
    cell_array *from;
    float (*to)[SC_TILE_CELLS], (*other)[SC_TILE_CELLS];
    float momentum;
} stepper;

/* Take a step with row (y, z) of a tile. @param once, twice the filtered rows. */
static inline void step_row(const stepper *s, size_t tile, int row, const float *once,
                            const float *twice)
{
    const float *data = s->b->data[tile] + row, *box = s->b->box[tile] + row;
    float *value = s->b->value[tile] + row;
    const float momentum = s->momentum;
    float now[SC_CUBE_CELLS], next[SC_CUBE_CELLS];

    for (int x = 0; x < SC_CUBE_CELLS; x++) {
        now[x] = sc_clip(2 * once[x] - twice[x], data[x] - box[x], data[x] + box[x]);
        next[x] = now[x] + momentum * (now[x] - value[x]);
    }
    memcpy(value, now, sizeof now);
    memcpy(s->to[tile] + row, next, sizeof next);
}

/* Take a step with the cells of tiles [begin, end); an sc_range_fn on a stepper. */
SC_WIDE_VECTORS static void step_tiles(void *user, size_t begin, size_t end, int thread)
{
    const stepper *s = user;

    for (size_t tile = begin; tile < end; tile++) {
        float region[EDGE * EDGE * EDGE], once[ONCE * ONCE * ONCE], twice[SC_TILE_CELLS];

        if (s->b->still[tile])
            continue;
        sc_read_cells(s->b, s->from, tile, HALO, region);
        sc_binomial(region, EDGE, once);
        sc_binomial(once, ONCE, twice);
        for (int k = 0; k < SC_CUBE_CELLS * SC_CUBE_CELLS; k++) {
            const int y = k % SC_CUBE_CELLS, z = k / SC_CUBE_CELLS;

            step_row(s, tile, k * SC_CUBE_CELLS, once + ((z + 1) * ONCE + y + 1) * ONCE + 1,
                     twice + k * SC_CUBE_CELLS);
        }
    }
}

/* Begin with the data of tiles [begin, end); an sc_range_fn on a stepper. */
static void begin_tiles(void *user, size_t begin, size_t end, int thread)
{
    const stepper *s = user;

    for (size_t tile = begin; tile < end; tile++) {
        float most = SC_BOX_FROZEN;

        memcpy(s->b->value[tile], s->b->data[tile], sizeof *s->to);
        memcpy(s->to[tile], s->b->data[tile], sizeof *s->to);
        memcpy(s->other[tile], s->b->data[tile], sizeof *s->to);
        for (int i = 0; i < SC_TILE_CELLS; i++)
            most = s->b->box[tile][i] > most ? s->b->box[tile][i] : most;
        s->b->still[tile] = !(most > SC_BOX_FROZEN);
    }
}

/* Take one step with the voxels of a region, in place; it loses HALO elements on every side.
 * @param data, box [FINE_EDGE] along each axis. */
SC_ALWAYS_INLINE void step_voxels(float *region, int edge, const float *low, const float *high)
{
    float once[(FINE_EDGE - 2) * (FINE_EDGE - 2) * (FINE_EDGE - 2)];
    const int less = edge - 2 * HALO, off = (FINE_EDGE - less) / 2;

    sc_binomial(region, edge, once);
    sc_binomial(once, edge - 2, region);
    for (int z = 0; z < less; z++) {
        for (int y = 0; y < less; y++) {
            const int at = ((z + off) * FINE_EDGE + y + off) * FINE_EDGE + off;
            const float *one = once + ((z + 1) * (edge - 2) + y + 1) * (edge - 2) + 1;
            float *to = region + (z * less + y) * less;

            for (int x = 0; x < less; x++)
                to[x] = sc_clip(2 * one[x] - to[x], low[at + x], high[at + x]);
        }
    }
}

/* What refine_tiles works with. */
typedef struct refining {
    float cells[16 * 16 * 16], sharp[14 * 14 * 14], wide[26 * 26 * 26];
    int8_t squares[FINE_EDGE * FINE_EDGE * FINE_EDGE];
    float low[FINE_EDGE * FINE_EDGE * FINE_EDGE], high[FINE_EDGE * FINE_EDGE * FINE_EDGE];
    float region[FINE_EDGE * FINE_EDGE * FINE_EDGE];
} refining;

/* Fill the boxes of voxels around a tile: r->low and r->high. */
SC_ALWAYS_INLINE void find_boxes(const sc_borders *b, size_t tile, refining *r)
{
    enum { CELLS = FINE_EDGE / 2 };
    static const float none[SC_BESIDE_CONSTANTS] = {1, 1, 1, 1};
    float strengths[CELLS * CELLS * CELLS];

    if (b->strengths)
        sc_read_tile_shares(b, b->strengths[0], tile, FINE_HALO / 2, none, strengths);
    for (int k = 0; k < FINE_EDGE * FINE_EDGE; k++) {
        const float *row = strengths + (k / FINE_EDGE / 2 * CELLS + k % FINE_EDGE / 2) * CELLS;
        const int8_t *squares = r->squares + (size_t)(k * FINE_EDGE);
        float half[FINE_EDGE], middle[FINE_EDGE];

        for (int x = 0; x < FINE_EDGE; x++)
            half[x] = SC_VOXEL_BOX * sc_voxel_share(b->strengths ? row[x / 2] : b->strength);
        sc_distances_of(squares, FINE_EDGE, middle);
        for (int x = 0; x < FINE_EDGE; x++) {
            const float width = squares[x] ? half[x] : SC_BOX_FREE;

            r->low[k * FINE_EDGE + x] = middle[x] - width;
            r->high[k * FINE_EDGE + x] = middle[x] + width;
        }
    }
}

/* Store the field at voxels of a tile that cells alone make. */
SC_ALWAYS_INLINE void store_coarse(const sc_borders *b, size_t tile, refining *r)
{
    enum { CELLS = SC_CUBE_CELLS + 2, VOXELS = 2 * CELLS - 2 };
    const int8_t *squares = b->squares[tile];
    int16_t *to = b->fine[tile];

    sc_read_cells(b, (cell_array *)b->value, tile, 2, r->cells);
    sc_sharpen(r->cells, CELLS + 2, r->sharp);
    sc_upsample(r->sharp, CELLS, r->wide);
    for (int k = 0; k < SC_CUBE * SC_CUBE; k++) {
        const float *from = r->wide + ((k / SC_CUBE + 1) * VOXELS + k % SC_CUBE + 1) * VOXELS + 1;

        float middle[SC_CUBE];

        sc_distances_of(squares + k * SC_CUBE, SC_CUBE, middle);
        for (int x = 0; x < SC_CUBE; x++) {
            const float width = squares[k * SC_CUBE + x] ? SC_CELL_BOX : SC_BOX_FREE;

            to[k * SC_CUBE + x] =
                sc_to_fine(sc_clip(from[x], middle[x] - width, middle[x] + width));
        }
    }
}

/* Store the field at voxels of a tile, a blend of what cells and voxels make. Voxels begin with the
 * answer of cells within their box. An answer beyond it comes from something too thin for cells,
 * such as a lost rim or a filled gap. Voxels that began at the limit of their box would stay there,
 * since smoothing pulls in the same direction, and the limit follows the stairs of the voxels. So
 * the farther the answer lies beyond the box, the nearer to the data they begin. */
SC_ALWAYS_INLINE void store_blend(const sc_borders *b, size_t tile, refining *r)
{
    enum { WIDE = 26, SHARES = SC_CUBE_CELLS + 2 };
    static const int8_t constants[SC_BESIDE_CONSTANTS] = {0, SC_REACH_SQUARED, -SC_REACH_SQUARED,
                                                          0};
    const float cells = sc_cell_share(b->strength);
    const float beside[SC_BESIDE_CONSTANTS] = {cells, cells, cells, cells};
    float shares[SHARES * SHARES * SHARES], share[18 * 18 * 18];

    sc_read_cells(b, (cell_array *)b->value, tile, 4, r->cells);
    sc_sharpen(r->cells, 16, r->sharp);
    sc_upsample(r->sharp, 14, r->wide); /* voxels -5 to 20 */
    sc_read_tile_squares(b, b->squares[0], tile, FINE_HALO, constants, r->squares);
    find_boxes(b, tile, r);
    for (int k = 0; k < FINE_EDGE * FINE_EDGE; k++) {
        const int at = k * FINE_EDGE;
        float *from = r->wide + ((k / FINE_EDGE + 1) * WIDE + k % FINE_EDGE + 1) * WIDE + 1;

        for (int x = 0; x < FINE_EDGE; x++) {
            const float more = SC_CELL_BOX - SC_VOXEL_BOX;
            const float low = r->low[at + x], high = r->high[at + x];
            const float half = 0.5f * (high - low), middle = 0.5f * (low + high);
            const float off = from[x] - middle;
            const float back = sc_clip(2 * half - fabsf(off), 0, half);

            from[x] = sc_clip(from[x], low - more, high + more);
            r->region[at + x] = sc_clip(middle + sc_clip(off, -back, back), low, high);
        }
    }
    for (int i = 0; i < FINE_STEPS; i++)
        step_voxels(r->region, FINE_EDGE - 2 * HALO * i, r->low, r->high);
    sc_read_tile_shares(b, b->coarse[0], tile, 1, beside, shares);
    sc_upsample(shares, SHARES, share);
    for (int k = 0; k < SC_CUBE * SC_CUBE; k++) {
        const int y = k % SC_CUBE, z = k / SC_CUBE;
        const float *part = share + ((z + 1) * 18 + y + 1) * 18 + 1;
        const float *from = r->wide + ((z + 5) * WIDE + y + 5) * WIDE + 5;
        const float *own = r->region + k * SC_CUBE;
        int16_t *to = b->fine[tile] + k * SC_CUBE;

        for (int x = 0; x < SC_CUBE; x++)
            to[x] = sc_to_fine(own[x] + part[x] * (from[x] - own[x]));
    }
}

/* Lie any voxels of a tile so near the border that it is drawn from them, which gradients at it
 * are, too? */
static bool is_at_border(const int8_t *squares)
{
    enum { NEAR = 4 * 4 };
    int8_t any = 0;

    for (int i = 0; i < SC_TILE_VOXELS; i++)
        any |= (int8_t)(squares[i] >= -NEAR && squares[i] <= NEAR);
    return any;
}

/* Make the field at the voxels of tiles [begin, end); an sc_range_fn on sc_borders. */
SC_WIDE_VECTORS static void refine_tiles(void *user, size_t begin, size_t end, int thread)
{
    const sc_borders *b = user;
    refining r;

    for (size_t tile = begin; tile < end; tile++) {
        if (sc_is_coarse(b, tile) || !is_at_border(b->squares[tile]))
            store_coarse(b, tile, &r);
        else
            store_blend(b, tile, &r);
    }
}

/* Let the fields of cells be their data: value and spare. Allocates still, too. */
static sc_status begin_cells(const sc_ctx *ctx, stepper *s)
{
    sc_team *team = s->b->p->team;
    void *block;

    SC_PASS(sc_team_alloc(ctx, team, s->b->tiles.count + 1, sizeof *s->b->value, &block));
    s->b->value = block;
    SC_PASS(sc_team_alloc(ctx, team, s->b->tiles.count + 1, 1, &block));
    s->b->still = block;
    sc_team_for(team, s->b->tiles.count, 64, begin_tiles, s);
    return SC_OK;
}

sc_status sc_smooth_cells(const sc_ctx *ctx, sc_borders *b)
{
    stepper s = {.b = b, .to = b->spare[0], .other = b->spare[1]};
    sc_team *team = b->p->team;
    float pace = 1;

    SC_PASS(begin_cells(ctx, &s));
    for (int i = 0; i < STEPS; i++) {
        const float next = 0.5f * (1 + sqrtf(1 + 4 * pace * pace));

        s.from = (cell_array *)b->spare[i % 2];
        s.to = b->spare[(i + 1) % 2];
        s.momentum = (pace - 1) / next;
        pace = next;
        sc_team_stage_for(ctx, SC_WORTH_STEPS / STEPS, team, b->tiles.count, 64, step_tiles, &s);
    }
    return SC_OK;
}

void sc_smooth_voxels(const sc_ctx *ctx, sc_borders *b)
{
    sc_team_stage_for(ctx, SC_WORTH_REFINING, b->p->team, b->tiles.count, 16, refine_tiles, b);
}

sc_status sc_take_data(const sc_ctx *ctx, sc_borders *b)
{
    stepper s = {.b = b, .to = b->spare[0], .other = b->spare[1]};
    void *block;

    SC_PASS(sc_team_alloc(ctx, b->p->team, b->tiles.count + 1, sizeof *b->coarse, &block));
    b->coarse = block; /* all 0 */
    sc_stage_add(ctx, SC_WORTH_STEPS + SC_WORTH_VOLUME + SC_WORTH_WEIGHING);
    return begin_cells(ctx, &s);
}
