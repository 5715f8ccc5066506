/* SPDX-License-Identifier: BSD-3-Clause */
/* Calmer gradients where a surface is flat at large: segmentations are often finer than what they
 * were drawn on, and show its steps as rings in the light. The directions of each label are summed
 * over blocks of 8^3 places; a place looks at the 27 blocks around it through a quadratic B-spline.
 * Where the directions there agree, the sum is as long as they are many, and their mean replaces
 * the place's own; over a bend, a thin tube or the two sides of a sheet it is shorter, and the
 * place keeps what it has. */
#include "internal.h"

#include <string.h>

enum { BLOCK = 8, ENTRIES = 4 };

#define AGREE_LEAST 0.90f /* length of the mean from which on it counts */
#define AGREE_ALL 0.965f  /* and from which on it replaces */

typedef struct entry {
    float sum[3], count;
    uint32_t label;
} entry;

typedef struct polish {
    const sc_preparation *p;
    int blocks[3];
    size_t block_count;
    entry *entries; /* [blocks][ENTRIES]; labels beyond the fourth of a block are left as they are */
    float weights[BLOCK][3]; /* of the three blocks along an axis, by the place within its own */
} polish;

static uint32_t record_at(const sc_preparation *p, size_t index)
{
    const uint8_t *at = p->records + index * SC_RECORD_BYTES;

    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16;
}

/* The direction alone. */
static void direction_of(uint32_t record, float out[3])
{
    sc_record_normal(record & ~0xc0u, out);
}

static uint32_t id_of_place(const sc_preparation *p, size_t brick, int bit)
{
    const size_t bx = (size_t)p->bricks[0], by = (size_t)p->bricks[1];

    return sc_id_or_background(p->volume, (int)(brick % bx) * SC_BRICK - 1 + (bit & 3),
                               (int)(brick / bx % by) * SC_BRICK - 1 + (bit >> 2 & 3),
                               (int)(brick / bx / by) * SC_BRICK - 1 + (bit >> 4));
}

/* The block's entry for a label; NULL if it has none and no room. */
static entry *entry_of(entry *entries, uint32_t label)
{
    for (int i = 0; i < ENTRIES; i++) {
        if (entries[i].count > 0 && entries[i].label != label)
            continue;
        entries[i].label = label;
        return &entries[i];
    }
    return NULL;
}

static void sum_brick(const polish *w, size_t brick, entry *entries)
{
    size_t index = w->p->near_start[brick];

    for (uint64_t left = w->p->near[brick]; left; left &= left - 1, index++) {
        entry *e = entry_of(entries, id_of_place(w->p, brick, __builtin_ctzll(left)));
        float n[3];

        if (!e)
            continue;
        direction_of(record_at(w->p, index), n);
        for (int i = 0; i < 3; i++)
            e->sum[i] += n[i];
        e->count++;
    }
}

static void sum_blocks(void *user, size_t begin, size_t end, int thread)
{
    const polish *w = user;
    const size_t bx = (size_t)w->blocks[0], by = (size_t)w->blocks[1];

    (void)thread;
    for (size_t block = begin; block < end; block++) {
        const int low[3] = {2 * (int)(block % bx), 2 * (int)(block / bx % by),
                            2 * (int)(block / bx / by)};

        for (int i = 0; i < 8; i++) {
            const int x = low[0] + (i & 1), y = low[1] + (i >> 1 & 1), z = low[2] + (i >> 2);

            if (x < w->p->bricks[0] && y < w->p->bricks[1] && z < w->p->bricks[2])
                sum_brick(w,
                          ((size_t)z * (size_t)w->p->bricks[1] + (size_t)y) *
                                  (size_t)w->p->bricks[0] +
                              (size_t)x,
                          w->entries + block * ENTRIES);
        }
    }
}

/* Sums of one label in the 27 blocks around the block at @p at. */
static void gather_label(const polish *w, const int at[3], uint32_t label, float out[27][4])
{
    memset(out, 0, 27 * sizeof *out);
    for (int n = 0; n < 27; n++) {
        const int x = at[0] + n % 3 - 1, y = at[1] + n / 3 % 3 - 1, z = at[2] + n / 9 - 1;
        const entry *entries;

        if (x < 0 || y < 0 || z < 0 || x >= w->blocks[0] || y >= w->blocks[1] ||
            z >= w->blocks[2])
            continue;
        entries = w->entries + (((size_t)z * (size_t)w->blocks[1] + (size_t)y) *
                                    (size_t)w->blocks[0] +
                                (size_t)x) *
                                   ENTRIES;
        for (int i = 0; i < ENTRIES; i++) {
            if (entries[i].count > 0 && entries[i].label == label)
                memcpy(out[n], entries[i].sum, sizeof out[n]);
        }
    }
}

/* The mean direction around a place. @return how much of the place's own it replaces. */
static float mean_direction(const polish *w, const int q[3], float sums[27][4], float out[3])
{
    const float *x = w->weights[q[0] % BLOCK], *y = w->weights[q[1] % BLOCK];
    const float *z = w->weights[q[2] % BLOCK];
    float total[4] = {0}, length, agree;

    for (int n = 0; n < 27; n++) {
        const float weight = x[n % 3] * y[n / 3 % 3] * z[n / 9];

        for (int i = 0; i < 4; i++)
            total[i] += weight * sums[n][i];
    }
    length = sqrtf(total[0] * total[0] + total[1] * total[1] + total[2] * total[2]);
    agree = (length / total[3] - AGREE_LEAST) / (AGREE_ALL - AGREE_LEAST);
    if (!(agree > 0))
        return 0;
    for (int i = 0; i < 3; i++)
        out[i] = total[i] / length;
    agree = agree < 1 ? agree : 1;
    return agree * agree * (3 - 2 * agree);
}

static void polish_place(const polish *w, const int q[3], size_t index, float sums[27][4])
{
    const double smooth = w->p->settings.smooth < 1 ? w->p->settings.smooth : 1;
    const uint32_t old = record_at(w->p, index);
    float own[3], mean[3] = {0, 0, 0};
    const double share = smooth * (double)mean_direction(w, q, sums, mean);
    sc_vec3 mixed;
    uint32_t record;

    if (!(share > 0))
        return;
    direction_of(old, own);
    mixed = sc_vec3_unit((sc_vec3){own[0] + share * (mean[0] - own[0]),
                                   own[1] + share * (mean[1] - own[1]),
                                   own[2] + share * (mean[2] - own[2])});
    record = (sc_record_pack(0, mixed, 1) & ~0xffu) | (old & 0xffu);
    for (int i = 0; i < SC_RECORD_BYTES; i++)
        w->p->records[index * SC_RECORD_BYTES + (size_t)i] = (uint8_t)(record >> (8 * i));
}

static void polish_brick(const polish *w, size_t brick, const int at[3])
{
    const int block[3] = {at[0] / 2, at[1] / 2, at[2] / 2};
    uint64_t left = w->p->near[brick];

    while (left) {
        const uint32_t label = id_of_place(w->p, brick, __builtin_ctzll(left));
        float sums[27][4];

        gather_label(w, block, label, sums);
        for (uint64_t mask = left; mask; mask &= mask - 1) {
            const int bit = __builtin_ctzll(mask);
            const int q[3] = {at[0] * SC_BRICK + (bit & 3), at[1] * SC_BRICK + (bit >> 2 & 3),
                              at[2] * SC_BRICK + (bit >> 4)};

            if (id_of_place(w->p, brick, bit) != label)
                continue;
            left &= ~(1ull << bit);
            polish_place(w, q,
                         w->p->near_start[brick] +
                             sc_count_bits(w->p->near[brick] & ((1ull << bit) - 1)),
                         sums);
        }
    }
}

static void polish_bricks(void *user, size_t begin, size_t end, int thread)
{
    const polish *w = user;
    const size_t bx = (size_t)w->p->bricks[0], by = (size_t)w->p->bricks[1];

    (void)thread;
    for (size_t brick = begin; brick < end; brick++) {
        const int at[3] = {(int)(brick % bx), (int)(brick / bx % by), (int)(brick / bx / by)};

        if (w->p->near[brick])
            polish_brick(w, brick, at);
    }
}

sc_status sc_polish_fields(const sc_ctx *ctx, sc_preparation *p)
{
    polish w = {.p = p, .block_count = 1};
    void *block;
    sc_status status;

    if (!(p->settings.smooth > 0))
        return SC_OK;
    for (int i = 0; i < 3; i++) {
        w.blocks[i] = (p->bricks[i] + 1) / 2;
        w.block_count *= (size_t)w.blocks[i];
    }
    status = sc_zalloc(ctx, w.block_count * ENTRIES, sizeof(entry), &block);
    if (status != SC_OK)
        return status;
    w.entries = block;
    for (int i = 0; i < BLOCK; i++) {
        const float t = ((float)i + 0.5f) / BLOCK - 0.5f;

        w.weights[i][0] = 0.5f * (0.5f - t) * (0.5f - t);
        w.weights[i][1] = 0.75f - t * t;
        w.weights[i][2] = 0.5f * (0.5f + t) * (0.5f + t);
    }
    sc_parallel_for(p->settings.threads, w.block_count, 512, sum_blocks, &w);
    sc_parallel_for(p->settings.threads, p->brick_count, 4096, polish_bricks, &w);
    sc_free(block);
    return SC_OK;
}
