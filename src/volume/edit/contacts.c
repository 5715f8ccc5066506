/* SPDX-License-Identifier: BSD-3-Clause */
/* How large the area is on which the labels of a volume touch each other: one pass over the voxels,
 * which compares eight bytes of labels at a time. And which labels lie near each other. */
#include "source.h"

#include <math.h>

/* What the threads that count share. */
typedef struct counter {
    const sc_volume *volume;
    uint64_t *areas;    /* [threads][label_count][label_count]: each pair with the smaller id first
                         */
    uint64_t weight[3]; /* of a face across each axis */
} counter;

/* Add @p weight to the areas of every two different labels, neither of them background, of voxels
 * a + i and b + i, i being 0 to n - 1. */
static void compare_rows(const sc_volume *v, size_t a, size_t b, size_t n, uint64_t weight,
                         uint64_t *areas)
{
    const size_t each = (size_t)v->label_bytes, stride = 8 / each;
    const char *ids = v->ids;

    for (size_t i = 0; i < n; i += stride) {
        const size_t some = n - i < stride ? n - i : stride;

        if (some == stride) {
            uint64_t word, other;

            memcpy(&word, ids + (a + i) * each, sizeof word);
            memcpy(&other, ids + (b + i) * each, sizeof other);
            if (word == other)
                continue;
        }
        for (size_t k = i; k < i + some; k++) {
            const uint32_t p = sc_volume_id(v, a + k), q = sc_volume_id(v, b + k);

            if (p != q && p && q)
                areas[p < q ? p * (size_t)v->label_count + q : q * (size_t)v->label_count + p] +=
                    weight;
        }
    }
}

/* Count the faces of the voxels of layers [begin, end) along z towards higher coordinates; an
 * sc_range_fn on a counter. */
static void count_layers(void *user, size_t begin, size_t end, int thread)
{
    const counter *c = user;
    const sc_volume *v = c->volume;
    const size_t nx = (size_t)v->size[0], ny = (size_t)v->size[1], nz = (size_t)v->size[2];
    uint64_t *areas = c->areas + (size_t)thread * (size_t)v->label_count * (size_t)v->label_count;

    for (size_t z = begin; z < end; z++) {
        for (size_t y = 0; y < ny; y++) {
            const size_t row = (z * ny + y) * nx;

            compare_rows(v, row, row + 1, nx - 1, c->weight[0], areas);
            if (y + 1 < ny)
                compare_rows(v, row, row + nx, nx, c->weight[1], areas);
            if (z + 1 < nz)
                compare_rows(v, row, row + ny * nx, nx, c->weight[2], areas);
        }
    }
}

/* Make the first of @p copies matrices the sum of all, and symmetric. */
static void sum_up(uint64_t *areas, size_t count, size_t copies)
{
    for (size_t copy = 1; copy < copies; copy++) {
        for (size_t i = 0; i < count * count; i++)
            areas[i] += areas[copy * count * count + i];
    }
    for (size_t p = 0; p < count; p++) {
        for (size_t q = p + 1; q < count; q++)
            areas[q * count + p] = areas[p * count + q];
    }
}

sc_status sc_count_contacts(const sc_ctx *ctx, const sc_volume *volume, int threads, uint64_t **out)
{
    const size_t count = (size_t)volume->label_count;
    const int most = 1 + (int)(((size_t)32 << 20) / (count * count * sizeof(uint64_t)));
    counter c = {.volume = volume};
    double area[3], largest = 0;

    threads = threads < most ? threads : most; /* each has a matrix of its own */
    SC_PASS(sc_zalloc(ctx, (size_t)threads * count * count, sizeof(uint64_t), &c.areas));
    for (int i = 0; i < 3; i++) {
        area[i] = sc_vec3_length(sc_affine_column(&volume->to_ras_mm, (i + 1) % 3)) *
                  sc_vec3_length(sc_affine_column(&volume->to_ras_mm, (i + 2) % 3));
        largest = fmax(largest, area[i]);
    }
    for (int i = 0; i < 3; i++)
        c.weight[i] = 1 + (uint64_t)(1000 * area[i] / largest);
    sc_parallel_for(threads, (size_t)volume->size[2], 1, count_layers, &c);
    sum_up(c.areas, count, (size_t)threads);
    *out = c.areas;
    return SC_OK;
}

/* Blocks of a volume, as nearly cubes as whole voxels allow, and which labels are in each. */
typedef struct blocks {
    int step[3];    /* every so many voxels along each axis, one is looked at */
    size_t size[3]; /* blocks along each axis */
    size_t words;   /* of a set of labels: a bit for each dense id */
    uint64_t *sets; /* [z][y][x][words] */
} blocks;

enum { BLOCKS = 32 /* along the longest axis */, SAMPLES = 4 /* voxels of a block, each way */ };

/* Lay blocks over a volume. */
static blocks lay_blocks(const sc_volume *v)
{
    blocks b = {.words = (size_t)v->label_count / 64 + 1};
    double spacing_mm[3], longest_mm = 0;

    for (int i = 0; i < 3; i++) {
        spacing_mm[i] = sc_vec3_length(sc_affine_column(&v->to_ras_mm, i));
        longest_mm = fmax(longest_mm, spacing_mm[i] * v->size[i]);
    }
    for (int i = 0; i < 3; i++) {
        const double step = longest_mm / (BLOCKS * SAMPLES) / spacing_mm[i];

        b.step[i] = 1 + (int)fmin(step, v->size[i] - 1);
        b.size[i] = ((size_t)v->size[i] - 1) / ((size_t)b.step[i] * SAMPLES) + 1;
    }
    return b;
}

/* Note in which blocks the labels are. */
static void fill_blocks(const sc_volume *v, blocks *b)
{
    for (int z = 0; z < v->size[2]; z += b->step[2]) {
        for (int y = 0; y < v->size[1]; y += b->step[1]) {
            const size_t row = ((size_t)z * (size_t)v->size[1] + (size_t)y) * (size_t)v->size[0];
            const size_t block_row = ((size_t)(z / b->step[2] / SAMPLES) * b->size[1] +
                                      (size_t)(y / b->step[1] / SAMPLES)) *
                                     b->size[0];

            for (int x = 0; x < v->size[0]; x += b->step[0]) {
                const uint32_t id = sc_volume_id(v, row + (size_t)x);
                const size_t block = block_row + (size_t)(x / b->step[0] / SAMPLES);

                b->sets[block * b->words + id / 64] |= (uint64_t)1 << id % 64;
            }
        }
    }
}

/* Write the labels of the block (x, y, z) and of the 26 about it to around[words]. */
static void gather_around(const blocks *b, const size_t at[3], uint64_t *around)
{
    size_t begin[3], end[3];

    memset(around, 0, b->words * sizeof *around);
    for (int i = 0; i < 3; i++) {
        begin[i] = at[i] > 0 ? at[i] - 1 : 0;
        end[i] = at[i] + 2 < b->size[i] ? at[i] + 2 : b->size[i];
    }
    for (size_t z = begin[2]; z < end[2]; z++) {
        for (size_t y = begin[1]; y < end[1]; y++) {
            const uint64_t *sets = b->sets + (z * b->size[1] + y) * b->size[0] * b->words;

            for (size_t x = begin[0]; x < end[0]; x++) {
                for (size_t i = 0; i < b->words; i++)
                    around[i] |= sets[x * b->words + i];
            }
        }
    }
}

/* @return whether a set has a label. */
static bool has_label(const uint64_t *set, size_t id)
{
    return set[id / 64] >> id % 64 & 1;
}

sc_status sc_count_near(const sc_ctx *ctx, const sc_volume *volume, uint32_t **out)
{
    const size_t count = (size_t)volume->label_count;
    blocks b = lay_blocks(volume);
    SC_OWN(sc_free_at) void *sets = NULL, *near = NULL, *around = NULL;

    SC_PASS(sc_zalloc(ctx, b.size[0] * b.size[1] * b.size[2] * b.words, sizeof(uint64_t), &sets));
    SC_PASS(sc_zalloc(ctx, count * count, sizeof(uint32_t), &near));
    SC_PASS(sc_zalloc(ctx, b.words, sizeof(uint64_t), &around));
    b.sets = sets;
    fill_blocks(volume, &b);
    for (size_t i = 0; i < b.size[0] * b.size[1] * b.size[2]; i++) {
        const size_t at[3] = {i % b.size[0], i / b.size[0] % b.size[1], i / b.size[0] / b.size[1]};

        gather_around(&b, at, around);
        for (size_t p = 1; p < count; p++) {
            for (size_t q = 1; q < count && has_label(b.sets + i * b.words, p); q++)
                ((uint32_t *)near)[p * count + q] += has_label(around, q);
        }
    }
    *out = near;
    near = NULL;
    return SC_OK;
}
