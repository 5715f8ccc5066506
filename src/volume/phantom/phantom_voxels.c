/* SPDX-License-Identifier: BSD-3-Clause */
/* Voxelising by recursive subdivision: a block whose centre is farther from every surface than its
 * corners are from its centre belongs to one tissue and is filled at once. All others are halved,
 * and only tissues whose surface may pass through the half are examined again. */
#include "phantom/phantom_model.h"

enum {
    BLOCK_VOXELS = 32,
    TISSUES_MAX = 64,
    SIZE_MAX_VOXELS = 4096, /* along an axis */
    SCAN_VOXELS = 64        /* along an axis, of the coarse grid of sc_phantom_scan_labels */
};

/* What the threads of sc_phantom_volume share; all is borrowed. */
typedef struct voxeliser {
    const sc_phantom *phantom;
    int size[3];   /* voxels along x, y, z */
    int blocks[3]; /* blocks of BLOCK_VOXELS along x, y, z, the last one maybe smaller */
    double spacing_mm[3];
    sc_vec3 origin_mm; /* centre of voxel (0, 0, 0) */
    uint8_t *ids;      /* [size z][size y][size x], the result */
} voxeliser;

/* A box of voxels: the lowest one, and how many along each axis. */
typedef struct block {
    int low[3], extent[3];
} block;

/* Set the ids of all voxels of the block to @p label. */
static void fill(const voxeliser *v, const block *b, uint8_t label)
{
    for (int z = b->low[2]; z < b->low[2] + b->extent[2]; z++) {
        for (int y = b->low[1]; y < b->low[1] + b->extent[1]; y++)
            memset(v->ids + ((size_t)z * (size_t)v->size[1] + (size_t)y) * (size_t)v->size[0] +
                       b->low[0],
                   label, (size_t)b->extent[0]);
    }
}

/* Write those of @p count candidates (labels in order of precedence) that may own some voxel of
 * the block to @p kept, in the same order, with room for all. @return how many; none: the block
 * is background. *settled: the first one kept owns the whole block. */
static int prune(const voxeliser *v, const block *b, const uint8_t *candidates, int count,
                 uint8_t *kept, bool *settled)
{
    double centre[3], reach2 = 0, reach;
    int left = 0;

    for (int i = 0; i < 3; i++) {
        const double half = 0.5 * (b->extent[i] - 1) * v->spacing_mm[i];

        centre[i] = b->low[i] * v->spacing_mm[i] + half;
        reach2 += half * half;
    }
    reach = SC_SHAPE_LIPSCHITZ * sqrt(reach2);
    *settled = false;
    for (int i = 0; i < count; i++) {
        const sc_vec3 offset = {centre[0], centre[1], centre[2]};
        const double field =
            sc_phantom_field(v->phantom, candidates[i], sc_vec3_add(v->origin_mm, offset), reach);

        if (field >= reach && field >= 0)
            continue;
        kept[left++] = candidates[i];
        if (field < -reach || (reach == 0 && field < 0)) {
            *settled = left == 1;
            break; /* whatever is listed later owns nothing here */
        }
    }
    return left;
}

/* Set the ids of all voxels of the block, each of which belongs to one of @p count candidates
 * (labels in order of precedence) or to background. Halves the block along each axis until one
 * of them owns the whole. */
static void descend(const voxeliser *v, const block *b, const uint8_t *candidates, int count)
{
    uint8_t kept[TISSUES_MAX];
    bool settled;
    const int left = prune(v, b, candidates, count, kept, &settled);

    if (left == 0 || settled) {
        fill(v, b, left ? kept[0] : 0);
        return;
    }
    for (int part = 0; part < 8; part++) {
        block child;
        bool empty = false;

        for (int i = 0; i < 3; i++) {
            const int half = (b->extent[i] + 1) / 2;
            const bool upper = part >> i & 1;

            child.low[i] = b->low[i] + (upper ? half : 0);
            child.extent[i] = upper ? b->extent[i] - half : half;
            empty = empty || child.extent[i] == 0;
        }
        if (!empty)
            descend(v, &child, kept, left);
    }
}

/* An sc_range_fn over blocks, numbered with x fastest: sets the ids of their voxels. @p user is
 * a voxeliser. */
static void voxelise_blocks(void *user, size_t begin, size_t end, int thread)
{
    const voxeliser *v = user;
    uint8_t all[TISSUES_MAX];
    const int count = sc_phantom_tissue_count(v->phantom);

    for (int i = 0; i < count; i++)
        all[i] = (uint8_t)(i + 1);
    for (size_t n = begin; n < end; n++) {
        const size_t at[3] = {n % (size_t)v->blocks[0],
                              n / (size_t)v->blocks[0] % (size_t)v->blocks[1],
                              n / (size_t)v->blocks[0] / (size_t)v->blocks[1]};
        block b;

        for (int i = 0; i < 3; i++) {
            const int rest = v->size[i] - (int)at[i] * BLOCK_VOXELS;

            b.low[i] = (int)at[i] * BLOCK_VOXELS;
            b.extent[i] = rest < BLOCK_VOXELS ? rest : BLOCK_VOXELS;
        }
        descend(v, &b, all, count);
    }
}

/* Set labels, label_count and label_bytes of @p volume, which owns them: background and the
 * tissues. @return SC_ERR_MEMORY. */
static sc_status make_labels(const sc_ctx *ctx, const sc_phantom *phantom, sc_volume *volume)
{
    const int count = sc_phantom_tissue_count(phantom) + 1;
    void *labels;

    SC_PASS(sc_zalloc(ctx, (size_t)count, sizeof(sc_label), &labels));
    volume->labels = labels;
    volume->label_count = count;
    volume->label_bytes = 1;
    for (int i = 1; i < count; i++)
        volume->labels[i] = *sc_phantom_label(phantom, i);
    return SC_OK;
}

sc_affine sc_phantom_geometry(const int size[3])
{
    static const double grid_mm[3] = {SC_PHANTOM_WIDTH / 3.0, SC_PHANTOM_DEPTH / 3.0,
                                      SC_PHANTOM_HEIGHT / 3.0};
    sc_affine out = {0};

    for (int i = 0; i < 3; i++) {
        const double spacing_mm = grid_mm[i] / size[i];

        out.m[i][i] = spacing_mm;
        out.m[i][3] = 0.5 * (spacing_mm - grid_mm[i]);
    }
    return out;
}

/* Set size, to_ras_mm and oriented of @p volume, which is zero: the grid covers the same part
 * of space at any size. @return SC_ERR_USAGE for sizes out of range. */
static sc_status make_grid(const sc_ctx *ctx, const int size[3], sc_volume *volume)
{
    volume->oriented = true;
    for (int i = 0; i < 3; i++) {
        if (size[i] < 2 || size[i] > SIZE_MAX_VOXELS)
            return sc_fail(ctx, SC_ERR_USAGE,
                           "a phantom of %d x %d x %d voxels; expected 2 to "
                           "%d along each axis",
                           size[0], size[1], size[2], SIZE_MAX_VOXELS);
        volume->size[i] = size[i];
    }
    volume->to_ras_mm = sc_phantom_geometry(size);
    return SC_OK;
}

sc_status sc_phantom_volume(const sc_ctx *ctx, const sc_phantom *phantom, const int size[3],
                            int threads, sc_volume *out)
{
    voxeliser v = {.phantom = phantom};
    SC_OWN(sc_volume_clear) sc_volume volume = {0};
    const sc_affine *m = &volume.to_ras_mm;
    size_t blocks;

    SC_PASS(make_grid(ctx, size, &volume));
    for (int i = 0; i < 3; i++) {
        v.size[i] = size[i];
        v.blocks[i] = (size[i] + BLOCK_VOXELS - 1) / BLOCK_VOXELS;
        v.spacing_mm[i] = m->m[i][i];
    }
    v.origin_mm = (sc_vec3){m->m[0][3], m->m[1][3], m->m[2][3]};
    SC_PASS(make_labels(ctx, phantom, &volume));
    SC_PASS(sc_alloc(ctx, sc_volume_voxels(&volume), 1, &volume.ids));
    v.ids = volume.ids;
    blocks = (size_t)v.blocks[0] * (size_t)v.blocks[1] * (size_t)v.blocks[2];
    sc_stage_begin(ctx, "making the phantom", 0, blocks);
    sc_stage_for(ctx, blocks, threads, blocks, 1, voxelise_blocks, &v);
    SC_HAND_OVER(volume, out);
    return SC_OK;
}

/* Count one voxel of the coarse volume, and let the box of its label, in voxels of a grid of @p
 * size over the same part of space, hold it. */
static void tally_voxel(const sc_volume *coarse, const int at[3], const int size[3],
                        sc_label_tally *tally)
{
    tally->voxels++;
    for (int i = 0; i < 3; i++) {
        const int low = (int)((int64_t)at[i] * size[i] / coarse->size[i]);
        const int high = (int)((int64_t)(at[i] + 1) * size[i] / coarse->size[i]) - 1;

        tally->low[i] = low < tally->low[i] ? low : tally->low[i];
        tally->high[i] = high > tally->high[i] ? high : tally->high[i];
    }
}

/* Fill tallies[coarse->label_count]: count the voxels and find the boxes in a coarse volume,
 * and convert both to voxels of a grid of @p size, which covers the same part of space. */
static void tally_labels(const sc_volume *coarse, const int size[3], sc_label_tally *tallies)
{
    const uint8_t *id = coarse->ids;
    double scale = 1;

    for (int i = 0; i < 3; i++)
        scale *= (double)size[i] / coarse->size[i];
    for (int i = 0; i < coarse->label_count; i++)
        tallies[i] = (sc_label_tally){0, {size[0], size[1], size[2]}, {-1, -1, -1}};
    for (int z = 0; z < coarse->size[2]; z++) {
        for (int y = 0; y < coarse->size[1]; y++) {
            for (int x = 0; x < coarse->size[0]; x++)
                tally_voxel(coarse, (const int[3]){x, y, z}, size, &tallies[*id++]);
        }
    }
    for (int i = 0; i < coarse->label_count; i++)
        tallies[i].voxels = (uint64_t)((double)tallies[i].voxels * scale);
}

sc_status sc_phantom_scan_labels(const sc_ctx *ctx, const sc_phantom *phantom, const int size[3],
                                 int threads, sc_volume *out)
{
    SC_OWN(sc_volume_clear) sc_volume grid = {0}, coarse = {0};
    int coarse_size[3];

    SC_PASS(make_grid(ctx, size, &grid));
    for (int i = 0; i < 3; i++)
        coarse_size[i] = size[i] < SCAN_VOXELS ? size[i] : SCAN_VOXELS;
    SC_PASS(sc_phantom_volume(ctx, phantom, coarse_size, threads, &coarse));
    SC_PASS(SC_ALLOC(ctx, (size_t)coarse.label_count, &grid.tallies));
    tally_labels(&coarse, size, grid.tallies);
    grid.label_count = coarse.label_count;
    SC_HAND_OVER(coarse.labels, &grid.labels);
    SC_HAND_OVER(grid, out);
    return SC_OK;
}
