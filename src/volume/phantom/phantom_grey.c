/* SPDX-License-Identifier: BSD-3-Clause */
/* A synthetic CT image of the phantom, as with contrast agent in the left heart: Hounsfield units
 * of each tissue, grain by a hash of the place of the voxel, and both blurred as a scanner does.
 * Whole numbers only, so that every machine makes the same. */
#include "phantom/phantom_model.h"

enum {
    LOWEST_HU = -1024,
    LUNG_HU = -820,        /* around the heart */
    GRAIN_HU = 110,        /* most by which a voxel differs before it is blurred */
    BLOCK_VOXELS = 1 << 16 /* that a thread fills at a time */
};

/* What the threads share. */
typedef struct image {
    const uint8_t *ids;
    uint16_t *codes;
    size_t size[3];
    int hu[256]; /* by dense id */
} image;

/* Noise of voxel @p i, of about a bell-shaped distribution. */
static int grain(size_t i)
{
    uint64_t bits = (uint64_t)i + 0x9e3779b97f4a7c15u; /* splitmix64 (Steele et al. 2014) */
    int sum = 0;

    bits = (bits ^ bits >> 30) * 0xbf58476d1ce4e5b9u;
    bits = (bits ^ bits >> 27) * 0x94d049bb133111ebu;
    bits ^= bits >> 31;
    for (int k = 0; k < 4; k++)
        sum += (int)(bits >> 16 * k & 0xff) - 127;
    return sum * GRAIN_HU / 512;
}

/* An sc_range_fn over voxels: Hounsfield units and grain. */
static void fill_voxels(void *user, size_t begin, size_t end, int thread)
{
    const image *m = user;

    for (size_t i = begin; i < end; i++)
        m->codes[i] = (uint16_t)(m->hu[m->ids[i]] + grain(i) - LOWEST_HU);
}

/* Blur a line of codes, @p step apart, by 1 2 1. */
static void blur_line(uint16_t *line, size_t count, size_t step)
{
    unsigned before = line[0];

    for (size_t i = 0; i < count; i++) {
        const unsigned here = line[i * step], after = i + 1 < count ? line[(i + 1) * step] : here;

        line[i * step] = (uint16_t)((before + 2 * here + after + 2) / 4);
        before = here;
    }
}

/* sc_range_fns that blur along an axis: over rows and columns of slices, and over rows of z. */
static void blur_slices(void *user, size_t begin, size_t end, int thread)
{
    const image *m = user;
    const size_t nx = m->size[0], ny = m->size[1];

    for (size_t z = begin; z < end; z++) {
        for (size_t y = 0; y < ny; y++)
            blur_line(m->codes + (z * ny + y) * nx, nx, 1);
        for (size_t x = 0; x < nx; x++)
            blur_line(m->codes + z * ny * nx + x, ny, nx);
    }
}

static void blur_across(void *user, size_t begin, size_t end, int thread)
{
    const image *m = user;
    const size_t nx = m->size[0], slice = nx * m->size[1];

    for (size_t y = begin; y < end; y++) {
        for (size_t x = 0; x < nx; x++)
            blur_line(m->codes + y * nx + x, m->size[2], slice);
    }
}

sc_status sc_phantom_grey(const sc_ctx *ctx, const sc_phantom *phantom, int threads, sc_grey *grey)
{
    SC_OWN(sc_volume_clear) sc_volume volume = {0};
    image m = {.codes = grey->codes};

    SC_PASS(sc_phantom_volume(ctx, phantom, grey->size, threads, &volume));
    m.ids = volume.ids;
    for (int i = 0; i < 3; i++)
        m.size[i] = (size_t)volume.size[i];
    for (int id = 0; id < volume.label_count; id++)
        m.hu[id] = id ? sc_phantom_hu(id) : LUNG_HU;
    sc_parallel_for(threads, sc_volume_voxels(&volume), BLOCK_VOXELS, fill_voxels, &m);
    sc_parallel_for(threads, m.size[2], 1, blur_slices, &m);
    sc_parallel_for(threads, m.size[1], 1, blur_across, &m);
    grey->to_ras_mm = volume.to_ras_mm;
    grey->low = LOWEST_HU;
    grey->per_code = 1;
    return SC_OK;
}
