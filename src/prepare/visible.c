/* SPDX-License-Identifier: BSD-3-Clause */
/* Which voxels and cells a picture can show. */
#include "corners.h"

/* What the threads that build masks share. */
typedef struct mask_builder {
    const sc_prepared *volume;
    const uint8_t *show; /* as of sc_visible_masks */
    bool interior;       /* some label shows its interior */
    bool all_shown;      /* every label with voxels shows its boundary, so that every cell with a
                            border has one that is shown */
    uint64_t *masks;     /* the result, with a frame; zero before */
} mask_builder;

/* @return the vertices of a brick that are voxels of the volume, as bits. @param low its lowest
 * vertex. */
static uint64_t inside_bits(const sc_prepared *v, const int low[3])
{
    uint64_t bits = 0;

    for (int bit = 0; bit < SC_BRICK_VERTICES; bit++) {
        if (sc_is_voxel(v, low[0] + sc_bit_x(bit), low[1] + sc_bit_y(bit), low[2] + sc_bit_z(bit)))
            bits |= 1ull << bit;
    }
    return bits;
}

/* @return the cells of a brick that lie within the label grid, as bits. @param low its lowest
 * vertex. */
static uint64_t cells_of_grid(const sc_prepared *v, const int low[3])
{
    uint64_t bits = 0;

    if (low[0] + SC_BRICK <= v->size[0] && low[1] + SC_BRICK <= v->size[1] &&
        low[2] + SC_BRICK <= v->size[2])
        return ~0ull;
    for (int bit = 0; bit < SC_BRICK_VERTICES; bit++) {
        if (low[0] + sc_bit_x(bit) <= v->size[0] && low[1] + sc_bit_y(bit) <= v->size[1] &&
            low[2] + sc_bit_z(bit) <= v->size[2])
            bits |= 1ull << bit;
    }
    return bits;
}

/* @return the index, in an array with a frame, of the brick that holds vertex @p low. */
static size_t framed_index(const sc_prepared *v, const int low[3])
{
    return (size_t)sc_framed_index(sc_framed_row(v->bricks), sc_framed_layer(v->bricks),
                                   sc_brick_of(low[0]), sc_brick_of(low[1]), sc_brick_of(low[2]));
}

/* Store the masks of visible voxels of bricks [begin, end) (without the frame); an sc_range_fn on a
 * mask_builder. */
static void build_masks(void *user, size_t begin, size_t end, int thread)
{
    const mask_builder *b = user;
    const sc_prepared *v = b->volume;

    for (size_t brick = begin; brick < end; brick++) {
        int low[3];
        const uint64_t boundary = v->boundary.masks[brick];
        uint64_t left, mask = 0;

        sc_brick_low(v->bricks, brick, low);
        left = b->interior ? inside_bits(v, low) : boundary;
        for (; left; left &= left - 1) {
            const int bit = __builtin_ctzll(left);
            const uint32_t id = sc_id_at_vertex(v, low[0] + sc_bit_x(bit), low[1] + sc_bit_y(bit),
                                                low[2] + sc_bit_z(bit));
            const int needs = boundary >> bit & 1 ? SC_SHOW_BOUNDARY : SC_SHOW_INTERIOR;

            if (b->show[id] & needs)
                mask |= 1ull << bit;
        }
        b->masks[framed_index(v, low)] = mask;
    }
}

/* Which cells of a brick are of a kind, as bits. */
typedef struct cell_kinds {
    uint64_t outer;  /* corners on both sides */
    uint64_t tissue; /* a corner on the side of tissue */
    uint64_t inner;  /* the corners that have a tissue do not all have the same */
} cell_kinds;

/* Find the kinds of the cells of row (y, z) of a brick, to the four lowest bits. */
static cell_kinds kinds_of_row(const sc_corner_fields *f, int y, int z)
{
    int32_t any[SC_CORNER_ROW], all[SC_CORNER_ROW], least[SC_CORNER_ROW], most[SC_CORNER_ROW];
    cell_kinds out = {0};

    for (int x = 0; x < SC_CORNER_ROW; x++) {
        any[x] = 0;
        all[x] = -1;
        least[x] = INT32_MAX;
        most[x] = 0;
    }
    for (int i = 0; i < 4; i++) {
        const int32_t *outer = f->outer[z + (i >> 1)][y + (i & 1)];
        const int32_t *tissue = f->tissue[z + (i >> 1)][y + (i & 1)];

        for (int x = 0; x < SC_CORNER_ROW; x++) {
            any[x] |= ~outer[x]; /* the sign is that of the side, and values are not 0 */
            all[x] &= ~outer[x];
            least[x] = tissue[x] && tissue[x] < least[x] ? tissue[x] : least[x];
            most[x] = tissue[x] > most[x] ? tissue[x] : most[x];
        }
    }
    for (int x = 0; x < SC_BRICK; x++) {
        const bool some = (any[x] | any[x + 1]) < 0, full = (all[x] & all[x + 1]) < 0;
        const int32_t low = least[x] < least[x + 1] ? least[x] : least[x + 1];
        const int32_t high = most[x] > most[x + 1] ? most[x] : most[x + 1];

        out.tissue |= (uint64_t)some << x;
        out.outer |= (uint64_t)(some && !full) << x;
        out.inner |= (uint64_t)(low < high) << x;
    }
    return out;
}

/* @return the cells of @p mask, which reach across the border of the volume, that have a corner in
 * it on the side of tissue, as bits. @param low the lowest vertex of the brick. */
static uint64_t with_tissue_inside(const sc_prepared *v, const int low[3],
                                   const sc_corner_fields *f, uint64_t mask)
{
    uint64_t bits = 0;

    for (uint64_t left = mask; left; left &= left - 1) {
        const int bit = __builtin_ctzll(left);

        for (int i = 0; i < 8; i++) {
            const int x = sc_bit_x(bit) + (i & 1), y = sc_bit_y(bit) + (i >> 1 & 1),
                      z = sc_bit_z(bit) + (i >> 2);

            if (sc_is_voxel(v, low[0] + x, low[1] + y, low[2] + z) && f->outer[z][y][x] > 0)
                bits |= 1ull << bit;
        }
    }
    return bits;
}

/* @return the cells of a brick at least one corner of which has a tissue that is shown, as bits. */
static uint64_t shown_cells(const mask_builder *b, const sc_corner_fields *fields)
{
    uint64_t bits = 0;

    for (int bit = 0; bit < SC_BRICK_VERTICES; bit++) {
        const int x = sc_bit_x(bit), y = sc_bit_y(bit), z = sc_bit_z(bit);
        int shown = 0;

        for (int i = 0; i < 8; i++)
            shown |= b->show[fields->tissue[z + (i >> 2)][y + (i >> 1 & 1)][x + (i & 1)]];
        bits |= (uint64_t)(shown & SC_SHOW_BOUNDARY) << bit;
    }
    return bits;
}

/* Store the masks of visible cells of bricks [begin, end) (without the frame); an sc_range_fn on a
 * mask_builder. All corners of a cell that holds a border have records, so that only bricks that
 * hold such a vertex, and those at the border of the volume, need to be examined. */
static void build_cells(void *user, size_t begin, size_t end, int thread)
{
    const mask_builder *b = user;
    const sc_prepared *v = b->volume;

    for (size_t brick = begin; brick < end; brick++) {
        sc_corner_fields fields;
        uint64_t mask = 0, border;
        int at[3], low[3];

        sc_brick_at(v->bricks, brick, at);
        border = sc_border_cells(v, at);
        if (!(v->outer.masks[brick] | v->inner.masks[brick]) &&
            !(border && v->boundary.masks[brick]))
            continue;
        sc_brick_low(v->bricks, brick, low);
        sc_corner_fields_fetch(v, at, &fields);
        for (int row = 0; row < SC_BRICK_LAYER; row++) {
            const cell_kinds k = kinds_of_row(&fields, row % SC_BRICK, row / SC_BRICK);

            mask |= (k.outer | (k.inner & k.tissue)) << (row * SC_BRICK);
        }
        mask = (mask & cells_of_grid(v, low)) | with_tissue_inside(v, low, &fields, border & ~mask);
        if (mask && !b->all_shown)
            mask &= shown_cells(b, &fields);
        b->masks[framed_index(v, low)] = mask;
    }
}

/* Allocate masks and have @p body, build_masks or build_cells, fill them. Parameters, return code
 * and owner are those of sc_visible_masks. */
static sc_status build(const sc_ctx *ctx, sc_team *team, const sc_prepared *volume,
                       const uint8_t *show, sc_range_fn *body, uint64_t **out)
{
    mask_builder builder = {.volume = volume, .show = show, .all_shown = true};
    int framed[3];
    void *block;

    sc_framed_size(volume->bricks, framed);
    SC_PASS(sc_team_alloc(ctx, team, sc_brick_count(framed), sizeof(uint64_t), &block));
    builder.masks = block;
    for (int id = 1; id < volume->label_count; id++) {
        builder.interior = builder.interior || show[id] & SC_SHOW_INTERIOR;
        if (volume->stats[id].voxels && !(show[id] & SC_SHOW_BOUNDARY))
            builder.all_shown = false;
    }
    sc_team_for(team, sc_brick_count(volume->bricks), 4096, body, &builder);
    *out = builder.masks;
    return SC_OK;
}

sc_status sc_visible_masks(const sc_ctx *ctx, sc_team *team, const sc_prepared *volume,
                           const uint8_t *show, uint64_t **out)
{
    return build(ctx, team, volume, show, build_masks, out);
}

sc_status sc_visible_cells(const sc_ctx *ctx, sc_team *team, const sc_prepared *volume,
                           const uint8_t *show, uint64_t **out)
{
    return build(ctx, team, volume, show, build_cells, out);
}
