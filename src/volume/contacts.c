/* SPDX-License-Identifier: BSD-3-Clause */
/* How large the area is on which the labels of a volume touch each other: one pass over the voxels,
 * which compares eight bytes of labels at a time. */
#include "source.h"

#include <math.h>
#include <string.h>

/* What the threads that count share. */
typedef struct counter {
    const sc_volume *volume;
    uint64_t *areas;    /* [threads][label_count][label_count]: each pair with the smaller id first
                         */
    uint64_t weight[3]; /* of a face across each axis */
} counter;

/* The dense id of a voxel. */
static uint32_t id_at(const sc_volume *v, size_t index)
{
    return v->label_bytes == 1 ? ((const uint8_t *)v->ids)[index]
                               : ((const uint16_t *)v->ids)[index];
}

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
            const uint32_t p = id_at(v, a + k), q = id_at(v, b + k);

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
    void *block;
    sc_status status;

    threads = threads < most ? threads : most; /* each has a matrix of its own */
    status = sc_zalloc(ctx, (size_t)threads * count * count, sizeof(uint64_t), &block);
    if (status != SC_OK)
        return status;
    c.areas = block;
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
