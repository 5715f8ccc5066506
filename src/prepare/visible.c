/* SPDX-License-Identifier: BSD-3-Clause */
/* Which voxels and cells a picture can show, and the points that their convex hull is made of. */
#include "segcast/prepare.h"

/* What the threads that build masks share. */
typedef struct mask_builder {
    const sc_prepared *volume;
    const uint8_t *show; /* as of sc_visible_masks */
    bool interior;       /* some label shows its interior */
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

/* Does the cell whose lowest vertex is (x, y, z) hold more than one label, one of them shown? */
static bool is_visible_cell(const mask_builder *b, int x, int y, int z)
{
    const uint32_t first = sc_id_at_vertex(b->volume, x, y, z);
    bool mixed = false, shown = b->show[first] & SC_SHOW_BOUNDARY;

    for (int corner = 1; corner < 8; corner++) {
        const uint32_t id =
            sc_id_at_vertex(b->volume, x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2));

        mixed = mixed || id != first;
        shown = shown || b->show[id] & SC_SHOW_BOUNDARY;
    }
    return mixed && shown;
}

/* Store the masks of visible cells of bricks [begin, end) (without the frame); an sc_range_fn on a
 * mask_builder. All corners of a cell with more than one label are near an interface, so that only
 * cells whose lowest vertex is need to be examined. */
static void build_cells(void *user, size_t begin, size_t end, int thread)
{
    const mask_builder *b = user;
    const sc_prepared *v = b->volume;

    (void)thread;
    for (size_t brick = begin; brick < end; brick++) {
        int low[3];
        uint64_t mask = 0;

        sc_brick_low(v->bricks, brick, low);
        for (uint64_t left = v->near[brick]; left; left &= left - 1) {
            const int bit = __builtin_ctzll(left);

            if (is_visible_cell(b, low[0] + sc_bit_x(bit), low[1] + sc_bit_y(bit),
                                low[2] + sc_bit_z(bit)))
                mask |= 1ull << bit;
        }
        b->masks[framed_index(v, low)] = mask;
    }
}

/* Allocate masks and have @p body, build_masks or build_cells, fill them. Parameters, return code
 * and owner are those of sc_visible_masks. */
static sc_status build(const sc_ctx *ctx, const sc_prepared *volume, const uint8_t *show,
                       int threads, sc_range_fn *body, uint64_t **out)
{
    mask_builder builder = {.volume = volume, .show = show};
    int framed[3];
    void *block;
    sc_status status;

    sc_framed_size(volume->bricks, framed);
    status = sc_zalloc(ctx, sc_brick_count(framed), sizeof(uint64_t), &block);
    if (status != SC_OK)
        return status;
    builder.masks = block;
    for (int id = 1; id < volume->label_count; id++)
        builder.interior = builder.interior || show[id] & SC_SHOW_INTERIOR;
    sc_parallel_for(threads, sc_brick_count(volume->bricks), 4096, body, &builder);
    *out = builder.masks;
    return SC_OK;
}

sc_status sc_visible_masks(const sc_ctx *ctx, const sc_prepared *volume, const uint8_t *show,
                           int threads, uint64_t **out)
{
    return build(ctx, volume, show, threads, build_masks, out);
}

sc_status sc_visible_cells(const sc_ctx *ctx, const sc_prepared *volume, const uint8_t *show,
                           int threads, uint64_t **out)
{
    return build(ctx, volume, show, threads, build_cells, out);
}

/* @return the x of the first (or the last) vertex of row (y, z) of the grid that is set in @p
 * masks, which have a frame; -1 if there is none. */
static int row_end(const sc_prepared *v, const uint64_t *masks, int y, int z, bool last)
{
    const int shift = sc_brick_bit(0, y, z);
    const uint64_t *row = masks + framed_index(v, (const int[3]){0, y, z});

    for (int i = 0; i < v->bricks[0]; i++) {
        const int brick = last ? v->bricks[0] - 1 - i : i;
        const unsigned bits = (unsigned)(row[brick] >> shift) & SC_BRICK_ROW_BITS;

        if (bits)
            return brick * SC_BRICK + (last ? 31 - __builtin_clz(bits) : __builtin_ctz(bits));
    }
    return -1;
}

sc_status sc_hull_points(const sc_ctx *ctx, const sc_prepared *volume, const uint64_t *masks,
                         sc_vec3 **out, size_t *count)
{
    const size_t rows = (size_t)(volume->size[1] + 2) * (size_t)(volume->size[2] + 2);
    sc_vec3 *points;
    size_t found = 0;
    void *block;
    sc_status status = sc_alloc(ctx, 2 * rows, sizeof(sc_vec3), &block);

    if (status != SC_OK)
        return status;
    points = block;
    for (int z = 0; z < volume->size[2] + 2; z++) {
        for (int y = 0; y < volume->size[1] + 2; y++) {
            const int first = row_end(volume, masks, y, z, false);
            const int last = first < 0 ? -1 : row_end(volume, masks, y, z, true);

            if (first >= 0)
                points[found++] =
                    sc_affine_point(&volume->to_ras_mm, (sc_vec3){first - 1, y - 1, z - 1});
            if (last > first)
                points[found++] =
                    sc_affine_point(&volume->to_ras_mm, (sc_vec3){last - 1, y - 1, z - 1});
        }
    }
    *out = points;
    *count = found;
    return SC_OK;
}
