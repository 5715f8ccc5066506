/* SPDX-License-Identifier: BSD-3-Clause */
/* Which voxels and cells a picture can show. */
#include "corners.h"

/* What the threads that build masks share. */
typedef struct mask_builder {
    const sc_prepared *volume;
    const uint8_t *show; /* as of sc_visible_masks */
    bool interior;       /* some label shows its interior */
    bool all_shown;      /* every label with voxels shows its boundary, so that every cell with more
                            than one label has one that is shown */
    uint64_t *masks;     /* the result, with a frame; zero before */
} mask_builder;

/* @return the vertices of a brick that are voxels of the volume, as bits. @param low its lowest
 * vertex. */
static uint64_t inside_bits(const sc_prepared *v, const int low[3])
{
    uint64_t bits = 0;

    for (int bit = 0; bit < SC_BRICK_VERTICES; bit++) {
        const int x = low[0] + sc_bit_x(bit), y = low[1] + sc_bit_y(bit),
                  z = low[2] + sc_bit_z(bit);

        if (x > 0 && y > 0 && z > 0 && x <= v->size[0] && y <= v->size[1] && z <= v->size[2])
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

    (void)thread;
    for (size_t brick = begin; brick < end; brick++) {
        int low[3];
        const uint64_t boundary = v->near[brick];
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

/* @return those of the cells @p near of a brick whose corners do not all have the same value in @p
 * at, as bits. */
static uint64_t mixed_cells(uint64_t near, const int32_t at[SC_CORNERS][SC_CORNERS][SC_CORNER_ROW])
{
    uint64_t bits = 0;

    for (int row = 0; row < SC_BRICK_LAYER; row++) {
        const int y = row % SC_BRICK, z = row / SC_BRICK;
        const int32_t *a = at[z][y], *b = at[z][y + 1], *c = at[z + 1][y], *d = at[z + 1][y + 1];
        int32_t other[SC_CORNER_ROW];

        if (!(near >> (row * SC_BRICK) & SC_BRICK_ROW_BITS))
            continue;
        for (int x = 0; x < SC_CORNER_ROW; x++)
            other[x] = (a[x] ^ b[x]) | (a[x] ^ c[x]) | (a[x] ^ d[x]);
        for (int x = 0; x < SC_BRICK; x++)
            bits |= (uint64_t)((other[x] | other[x + 1] | (a[x] ^ a[x + 1])) != 0)
                    << (row * SC_BRICK + x);
    }
    return bits & near;
}

/* @return the cells of a brick at least one corner of which has a label that is shown, as bits. */
static uint64_t shown_cells(const mask_builder *b, const sc_corner_labels *labels)
{
    uint64_t bits = 0;

    for (int bit = 0; bit < SC_BRICK_VERTICES; bit++) {
        const int x = sc_bit_x(bit), y = sc_bit_y(bit), z = sc_bit_z(bit);
        int shown = 0;

        for (int i = 0; i < 8; i++)
            shown |= b->show[labels->at[z + (i >> 2)][y + (i >> 1 & 1)][x + (i & 1)]];
        bits |= (uint64_t)(shown & SC_SHOW_BOUNDARY) << bit;
    }
    return bits;
}

/* Store the masks of visible cells of bricks [begin, end) (without the frame); an sc_range_fn on a
 * mask_builder. All corners of a cell with more than one label are near an interface, so that only
 * bricks that hold such a vertex need to be examined. */
static void build_cells(void *user, size_t begin, size_t end, int thread)
{
    const mask_builder *b = user;
    const sc_prepared *v = b->volume;

    (void)thread;
    for (size_t brick = begin; brick < end; brick++) {
        sc_corner_labels labels;
        uint64_t mask;
        int low[3];

        if (!v->near[brick])
            continue;
        sc_brick_low(v->bricks, brick, low);
        sc_corner_labels_fetch(v, low, &labels);
        mask = mixed_cells(v->near[brick], labels.at);
        if (mask && !b->all_shown)
            mask &= shown_cells(b, &labels);
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
    sc_status status;

    sc_framed_size(volume->bricks, framed);
    status = sc_team_alloc(ctx, team, sc_brick_count(framed), sizeof(uint64_t), &block);
    if (status != SC_OK)
        return status;
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
