/* SPDX-License-Identifier: BSD-3-Clause */
/* Which voxels a picture can show, and how far they reach. */
#include "segcast/prepare.h"

typedef struct mask_builder {
    const sc_prepared *volume;
    const uint8_t *show;
    bool interior; /* some label shows its interior */
    uint64_t *masks;
} mask_builder;

/* Places of the brick that are voxels of the volume. @p low: its first place. */
static uint64_t inside_bits(const sc_prepared *v, const int low[3])
{
    uint64_t bits = 0;

    for (int bit = 0; bit < 64; bit++) {
        const int x = low[0] + (bit & 3), y = low[1] + (bit >> 2 & 3), z = low[2] + (bit >> 4);

        if (x > 0 && y > 0 && z > 0 && x <= v->size[0] && y <= v->size[1] && z <= v->size[2])
            bits |= 1ull << bit;
    }
    return bits;
}

/* Where brick (x, y, z) stands within the frame of empty bricks. */
static size_t framed(const sc_prepared *v, size_t x, size_t y, size_t z)
{
    return ((z + 1) * (size_t)(v->bricks[1] + 2) + y + 1) * (size_t)(v->bricks[0] + 2) + x + 1;
}

/* The first place of a brick. */
static void low_of_brick(const sc_prepared *v, size_t brick, int low[3])
{
    const size_t bx = (size_t)v->bricks[0], by = (size_t)v->bricks[1];

    low[0] = (int)(brick % bx) * SC_BRICK;
    low[1] = (int)(brick / bx % by) * SC_BRICK;
    low[2] = (int)(brick / bx / by) * SC_BRICK;
}

static void build_masks(void *user, size_t begin, size_t end, int thread)
{
    const mask_builder *b = user;
    const sc_prepared *v = b->volume;

    (void)thread;
    for (size_t brick = begin; brick < end; brick++) {
        int low[3];
        const uint64_t boundary = v->near[brick];
        uint64_t left, mask = 0;

        low_of_brick(v, brick, low);
        left = b->interior ? inside_bits(v, low) : boundary;
        for (; left; left &= left - 1) {
            const int bit = __builtin_ctzll(left);
            const uint32_t id =
                sc_id_at_place(v, low[0] + (bit & 3), low[1] + (bit >> 2 & 3), low[2] + (bit >> 4));
            const int needs = boundary >> bit & 1 ? SC_SHOW_BOUNDARY : SC_SHOW_INTERIOR;

            if (b->show[id] & needs)
                mask |= 1ull << bit;
        }
        b->masks[framed(v, (size_t)low[0] / SC_BRICK, (size_t)low[1] / SC_BRICK,
                        (size_t)low[2] / SC_BRICK)] = mask;
    }
}

/* Does the cell hold more than one label, one of them shown? */
static bool is_visible_cell(const mask_builder *b, int x, int y, int z)
{
    const uint32_t first = sc_id_at_place(b->volume, x, y, z);
    bool mixed = false, shown = b->show[first] & SC_SHOW_BOUNDARY;

    for (int corner = 1; corner < 8; corner++) {
        const uint32_t id =
            sc_id_at_place(b->volume, x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2));

        mixed = mixed || id != first;
        shown = shown || b->show[id] & SC_SHOW_BOUNDARY;
    }
    return mixed && shown;
}

/* All corners of a mixed cell are near an interface: only their lowest ones need a look. */
static void build_cells(void *user, size_t begin, size_t end, int thread)
{
    const mask_builder *b = user;
    const sc_prepared *v = b->volume;

    (void)thread;
    for (size_t brick = begin; brick < end; brick++) {
        int low[3];
        uint64_t mask = 0;

        low_of_brick(v, brick, low);
        for (uint64_t left = v->near[brick]; left; left &= left - 1) {
            const int bit = __builtin_ctzll(left);

            if (is_visible_cell(b, low[0] + (bit & 3), low[1] + (bit >> 2 & 3),
                                low[2] + (bit >> 4)))
                mask |= 1ull << bit;
        }
        b->masks[framed(v, (size_t)low[0] / SC_BRICK, (size_t)low[1] / SC_BRICK,
                        (size_t)low[2] / SC_BRICK)] = mask;
    }
}

static sc_status build(const sc_ctx *ctx, const sc_prepared *volume, const uint8_t *show,
                       int threads, sc_range_fn *body, uint64_t **out)
{
    const size_t count =
        (size_t)volume->bricks[0] * (size_t)volume->bricks[1] * (size_t)volume->bricks[2];
    mask_builder builder = {.volume = volume, .show = show};
    void *block;
    sc_status status = sc_zalloc(ctx, framed(volume, 0, 0, (size_t)volume->bricks[2] + 1),
                                 sizeof(uint64_t), &block);

    if (status != SC_OK)
        return status;
    builder.masks = block;
    for (int id = 1; id < volume->label_count; id++)
        builder.interior = builder.interior || show[id] & SC_SHOW_INTERIOR;
    sc_parallel_for(threads, count, 4096, body, &builder);
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

/* First or last set place along x of row (y, z); -1 if there is none. */
static int row_end(const sc_prepared *v, const uint64_t *masks, int y, int z, bool last)
{
    const int shift = (y % SC_BRICK) * 4 + (z % SC_BRICK) * 16;
    const uint64_t *row = masks + framed(v, 0, (size_t)(y / SC_BRICK), (size_t)(z / SC_BRICK));

    for (int i = 0; i < v->bricks[0]; i++) {
        const int brick = last ? v->bricks[0] - 1 - i : i;
        const unsigned bits = (unsigned)(row[brick] >> shift) & 15u;

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
