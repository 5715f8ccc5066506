/* SPDX-License-Identifier: BSD-3-Clause */
/* Normals of boundary voxels: the gradient of the voxel's own label, smoothed by a bell over a
 * round window 11 wide. A row of the window becomes 11 bits ("is it my label?"), and a table
 * gives its weighted sum and its weighted derivative, so that a voxel costs 109 look-ups. */
#include "internal.h"

#include <stddef.h>
#include <string.h>

enum { RADIUS = 5, WIDTH = 2 * RADIUS + 1 };

/* A row of the window: where it lies and what its sum and derivative count for. */
typedef struct window_row {
    int dy, dz;
    ptrdiff_t offset; /* in voxels, from the voxel to the begin of the row */
    float along_x, along_y, along_z;
} window_row;

typedef struct normal_tables {
    const sc_preparation *p;
    window_row rows[WIDTH * WIDTH];
    int row_count;
    float sum[1 << WIDTH], derivative[1 << WIDTH]; /* of a row, by its bits */
    double to_mm[3][3];                            /* index-space gradient -> RAS */
} normal_tables;

/* A bell that ends smoothly at the rim of the window, (1 - u^2)^3: a cut-off Gaussian would let the
 * staircase through. Its standard deviation is a third of its radius, 2 voxels. */
static double bell(double x)
{
    const double u = x / (RADIUS + 1), v = 1 - u * u;

    return v * v * v;
}

static double bell_slope(double x)
{
    const double u = x / (RADIUS + 1), v = 1 - u * u;

    return u * v * v;
}

static void fill_rows(normal_tables *t)
{
    const ptrdiff_t nx = t->p->volume->size[0], plane = nx * t->p->volume->size[1];

    for (int dz = -RADIUS; dz <= RADIUS; dz++) {
        for (int dy = -RADIUS; dy <= RADIUS; dy++) {
            if (dy * dy + dz * dz >= (RADIUS + 1) * (RADIUS + 1))
                continue;
            t->rows[t->row_count++] = (window_row){.dy = dy,
                                                   .dz = dz,
                                                   .offset = dz * plane + dy * nx - RADIUS,
                                                   .along_x = (float)(bell(dy) * bell(dz)),
                                                   .along_y = (float)(bell_slope(dy) * bell(dz)),
                                                   .along_z = (float)(bell(dy) * bell_slope(dz))};
        }
    }
}

static void fill_tables(normal_tables *t)
{
    sc_affine inverse = {0};

    fill_rows(t);
    for (int bits = 0; bits < 1 << WIDTH; bits++) {
        double sum = 0, derivative = 0;

        for (int i = 0; i < WIDTH; i++) {
            sum += bits >> i & 1 ? bell(i - RADIUS) : 0;
            derivative += bits >> i & 1 ? bell_slope(i - RADIUS) : 0;
        }
        t->sum[bits] = (float)sum;
        t->derivative[bits] = (float)derivative;
    }
    /* Gradients map by the transposed inverse; the reader has checked that it exists. */
    (void)sc_affine_invert(&t->p->volume->to_ras_mm, &inverse);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            t->to_mm[i][j] = inverse.m[j][i];
    }
}

/* Bit i is set where byte i of @p x is zero. */
static unsigned zero_bytes(uint64_t x)
{
    const uint64_t low7 = 0x7f7f7f7f7f7f7f7fu;
    const uint64_t zero = ~(((x & low7) + low7) | x | low7); /* 0x80 in every zero byte */

    return (unsigned)(((zero >> 7) * 0x0102040810204080u) >> 56);
}

/* "Is it my label?" for the WIDTH voxels from @p row on. */
static unsigned row_bits(const sc_volume *v, size_t row, uint32_t id)
{
    unsigned bits = 0;

    if (v->label_bytes == 1) {
        const uint64_t wanted = id * 0x0101010101010101u;
        uint64_t words[2];

        memcpy(words, (const uint8_t *)v->ids + row, sizeof words);
        bits = zero_bytes(words[0] ^ wanted) | zero_bytes(words[1] ^ wanted) << 8;
        return bits & ((1u << WIDTH) - 1);
    }
    for (int i = 0; i < WIDTH; i++)
        bits |= (unsigned)(((const uint16_t *)v->ids)[row + (size_t)i] == id) << i;
    return bits;
}

/* The same at the faces of the volume, where part of the window lies outside. */
static unsigned row_bits_clipped(const sc_volume *v, int x, int y, int z, uint32_t id)
{
    const size_t row = ((size_t)z * (size_t)v->size[1] + (size_t)y) * (size_t)v->size[0];
    unsigned bits = 0;

    if (y < 0 || z < 0 || y >= v->size[1] || z >= v->size[2])
        return 0;
    for (int i = 0; i < WIDTH; i++) {
        const int at = x + i - RADIUS;

        if (at >= 0 && at < v->size[0])
            bits |= (unsigned)(sc_id_at(v, row + (size_t)at) == id) << i;
    }
    return bits;
}

static void gradient(const normal_tables *t, const sc_boundary_voxel *voxel, float g[3])
{
    const sc_volume *v = t->p->volume;
    /* Columns to spare: sixteen bytes are read for a row of eleven. */
    const bool inside = voxel->x >= RADIUS && voxel->x - RADIUS + 16 <= v->size[0] &&
                        voxel->y >= RADIUS && voxel->y + RADIUS < v->size[1] &&
                        voxel->z >= RADIUS && voxel->z + RADIUS < v->size[2];

    g[0] = g[1] = g[2] = 0;
    for (int i = 0; i < t->row_count; i++) {
        const window_row *row = &t->rows[i];
        unsigned bits;

        if (inside)
            bits = row_bits(v, (size_t)((ptrdiff_t)voxel->index + row->offset), voxel->id);
        else
            bits = row_bits_clipped(v, voxel->x, voxel->y + row->dy, voxel->z + row->dz, voxel->id);
        g[0] += row->along_x * t->derivative[bits];
        g[1] += row->along_y * t->sum[bits];
        g[2] += row->along_z * t->sum[bits];
    }
}

static void take_normal(void *user, const sc_boundary_voxel *voxel)
{
    const normal_tables *t = user;
    double n[3], length;
    float g[3];

    gradient(t, voxel, g);
    for (int i = 0; i < 3; i++) /* outward: against the rise of the own label */
        n[i] = -(t->to_mm[i][0] * g[0] + t->to_mm[i][1] * g[1] + t->to_mm[i][2] * g[2]);
    length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    t->p->normals[voxel->normal] =
        length > 1e-6 ? sc_normal_pack(n[0] / length, n[1] / length, n[2] / length) : 0;
}

static void normals_of_bricks(void *user, size_t begin, size_t end, int thread)
{
    const normal_tables *t = user;

    (void)thread;
    sc_each_boundary(t->p, begin, end, take_normal, user);
}

uint32_t sc_normal_pack(double x, double y, double z)
{
    const double n[3] = {x, y, z};
    uint32_t packed = 0;

    for (int i = 0; i < 3; i++) {
        const int32_t level = (int32_t)(n[i] * 511 + (n[i] < 0 ? -0.5 : 0.5));

        packed |= ((uint32_t)level & 0x3ff) << (10 * i);
    }
    return packed;
}

sc_status sc_find_normals(const sc_ctx *ctx, sc_preparation *p)
{
    normal_tables t = {.p = p};
    void *block;
    sc_status status = sc_alloc(ctx, p->boundary_count, sizeof(uint32_t), &block);

    if (status != SC_OK)
        return status;
    p->normals = block;
    fill_tables(&t);
    sc_parallel_for(p->threads, p->brick_count, 4096, normals_of_bricks, &t);
    return SC_OK;
}
