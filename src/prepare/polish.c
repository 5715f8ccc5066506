/* SPDX-License-Identifier: BSD-3-Clause */
/* Calmer gradients where a surface is flat at large: segmentations are often finer than what they
 * were drawn on, and show its steps as rings in the light. The directions of each label are summed
 * over bricks, the sums are spread over neighbouring bricks, and every place looks at the 27 around
 * it through a quadratic B-spline: a bell 4.6 places wide in all. Where the directions there agree,
 * the sum is as long as they are many, and their mean replaces the place's own; over a bend, a thin
 * tube or the two sides of a sheet it is shorter, and the place keeps what it has. */
#include "internal.h"

#include <string.h>

enum {
    ENTRIES = 4, /* labels of a brick; places of a fifth one keep what they have */
    SPREADS = 2  /* times that the sums are spread, each by (1 2 1) / 4 along every axis */
};

#define AGREE_LEAST 0.90f /* length of the mean from which on it counts */
#define AGREE_ALL 0.965f  /* and from which on it replaces */

typedef float quad __attribute__((vector_size(16)));

typedef struct entry {
    float sum[3], count;
    uint32_t label;
} entry;

typedef struct polish {
    const sc_preparation *p;
    uint32_t *slot; /* [bricks]: where a brick's entries are; bricks without any share 0 */
    size_t slot_count;
    entry *entries, *spread; /* [slots][ENTRIES] */
    float weights[SC_BRICK_VERTICES]
                 [27]; /* of the 27 bricks around, by the place in the middle one */
} polish;

/* The unit direction of a record's gradient. */
static void direction_of(uint32_t record, float out[3])
{
    sc_record_normal(record & SC_RECORD_DIRECTION_BITS, out);
}

/* The labels of a brick's places near an interface. */
static void labels_of(const sc_preparation *p, size_t brick, uint16_t labels[SC_BRICK_VERTICES])
{
    int low[3];

    sc_brick_low(p->bricks, brick, low);
    for (uint64_t left = p->near[brick]; left; left &= left - 1) {
        const int bit = __builtin_ctzll(left);

        labels[bit] =
            (uint16_t)sc_id_or_background(p->volume, low[0] + sc_bit_x(bit) - 1,
                                          low[1] + sc_bit_y(bit) - 1, low[2] + sc_bit_z(bit) - 1);
    }
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
    uint16_t labels[SC_BRICK_VERTICES];

    labels_of(w->p, brick, labels);
    for (uint64_t left = w->p->near[brick]; left; left &= left - 1, index++) {
        entry *e = entry_of(entries, labels[__builtin_ctzll(left)]);
        float n[3];

        if (!e)
            continue;
        direction_of(sc_record_read(w->p->records, index), n);
        for (int i = 0; i < 3; i++)
            e->sum[i] += n[i];
        e->count++;
    }
}

static void sum_bricks(void *user, size_t begin, size_t end, int thread)
{
    const polish *w = user;

    (void)thread;
    for (size_t brick = begin; brick < end; brick++) {
        if (w->slot[brick])
            sum_brick(w, brick, w->entries + (size_t)w->slot[brick] * ENTRIES);
    }
}

/* Entries of the 27 bricks around a brick; those outside have none. */
static void find_neighbours(const polish *w, size_t brick, const entry *out[27])
{
    const sc_preparation *p = w->p;
    int at[3];

    sc_brick_at(p->bricks, brick, at);
    for (int n = 0; n < 27; n++) {
        const int x = at[0] + n % 3 - 1, y = at[1] + n / 3 % 3 - 1, z = at[2] + n / 9 - 1;
        const bool inside =
            x >= 0 && y >= 0 && z >= 0 && x < p->bricks[0] && y < p->bricks[1] && z < p->bricks[2];
        const size_t slot = inside ? w->slot[sc_brick_index(p->bricks, x, y, z)] : 0;

        out[n] = w->entries + slot * ENTRIES;
    }
}

static const entry *find_label(const entry *entries, uint32_t label)
{
    for (int i = 0; i < ENTRIES && entries[i].count > 0; i++) {
        if (entries[i].label == label)
            return &entries[i];
    }
    return NULL;
}

static void spread_bricks(void *user, size_t begin, size_t end, int thread)
{
    static const float share[3] = {0.25f, 0.5f, 0.25f};
    const polish *w = user;

    (void)thread;
    for (size_t brick = begin; brick < end; brick++) {
        const size_t first = (size_t)w->slot[brick] * ENTRIES;
        const entry *around[27];

        if (!first)
            continue;
        find_neighbours(w, brick, around);
        for (int i = 0; i < ENTRIES; i++) {
            entry sum = {.label = w->entries[first + (size_t)i].label};

            for (int n = 0; n < 27 && w->entries[first + (size_t)i].count > 0; n++) {
                const entry *from = find_label(around[n], sum.label);
                const float weight = share[n % 3] * share[n / 3 % 3] * share[n / 9];

                for (int k = 0; from && k < 3; k++)
                    sum.sum[k] += weight * from->sum[k];
                sum.count += from ? weight * from->count : 0;
            }
            w->spread[first + (size_t)i] = sum;
        }
    }
}

/* Sums of one label in the 27 bricks around; their number last. */
static void gather_label(const entry *const around[27], uint32_t label, quad out[27])
{
    for (int n = 0; n < 27; n++) {
        const entry *from = find_label(around[n], label);

        out[n] = from ? (quad){from->sum[0], from->sum[1], from->sum[2], from->count}
                      : (quad){0, 0, 0, 0};
    }
}

/* The mean direction around a place. @return how much of the place's own it replaces. */
static float mean_direction(const polish *w, int bit, const quad sums[27], float out[3])
{
    quad total = {0};
    float length, agree;

    for (int n = 0; n < 27; n++)
        total += w->weights[bit][n] * sums[n];
    length = sqrtf(total[0] * total[0] + total[1] * total[1] + total[2] * total[2]);
    agree = (length / total[3] - AGREE_LEAST) / (AGREE_ALL - AGREE_LEAST);
    if (!(agree > 0))
        return 0;
    for (int i = 0; i < 3; i++)
        out[i] = total[i] / length;
    agree = agree < 1 ? agree : 1;
    return agree * agree * (3 - 2 * agree);
}

static void polish_place(const polish *w, int bit, size_t index, const quad sums[27])
{
    const double smooth = w->p->settings.smooth < 1 ? w->p->settings.smooth : 1;
    const uint32_t old = sc_record_read(w->p->records, index);
    float own[3], mean[3] = {0, 0, 0};
    const double share = smooth * (double)mean_direction(w, bit, sums, mean);
    sc_vec3 mixed;
    uint32_t calmer;

    if (!(share > 0))
        return;
    direction_of(old, own);
    mixed = (sc_vec3){own[0] + share * (mean[0] - own[0]), own[1] + share * (mean[1] - own[1]),
                      own[2] + share * (mean[2] - own[2])};
    calmer = (sc_record_pack(0, mixed, 1) & SC_RECORD_DIRECTION_BITS) |
             (old & ~(uint32_t)SC_RECORD_DIRECTION_BITS);
    sc_record_write(w->p->records, index, calmer);
}

static void polish_brick(const polish *w, size_t brick)
{
    const entry *around[27];
    uint64_t left = w->p->near[brick];
    uint16_t labels[SC_BRICK_VERTICES];

    find_neighbours(w, brick, around);
    labels_of(w->p, brick, labels);
    while (left) {
        const uint32_t label = labels[__builtin_ctzll(left)];
        quad sums[27];

        gather_label(around, label, sums);
        for (uint64_t mask = left; mask; mask &= mask - 1) {
            const int bit = __builtin_ctzll(mask);

            if (labels[bit] != label)
                continue;
            left &= ~(1ull << bit);
            polish_place(w, bit, w->p->near_start[brick] + sc_brick_rank(w->p->near[brick], bit),
                         sums);
        }
    }
}

static void polish_bricks(void *user, size_t begin, size_t end, int thread)
{
    const polish *w = user;

    (void)thread;
    for (size_t brick = begin; brick < end; brick++) {
        if (w->slot[brick])
            polish_brick(w, brick);
    }
}

static sc_status allocate(const sc_ctx *ctx, polish *w)
{
    void *block;
    sc_status status;

    SC_TRY(sc_zalloc(ctx, w->p->brick_count, sizeof *w->slot, &block));
    w->slot = block;
    w->slot_count = 1;
    for (size_t brick = 0; brick < w->p->brick_count; brick++) {
        if (w->p->near[brick])
            w->slot[brick] = (uint32_t)w->slot_count++;
    }
    SC_TRY(sc_zalloc(ctx, w->slot_count * ENTRIES, sizeof(entry), &block));
    w->entries = block;
    SC_TRY(sc_zalloc(ctx, w->slot_count * ENTRIES, sizeof(entry), &block));
    w->spread = block;
out:
    return status;
}

/* The quadratic B-spline along each axis. */
static void fill_weights(polish *w)
{
    float along[SC_BRICK][3];

    for (int i = 0; i < SC_BRICK; i++) {
        const float t = ((float)i + 0.5f) / SC_BRICK - 0.5f;

        along[i][0] = 0.5f * (0.5f - t) * (0.5f - t);
        along[i][1] = 0.75f - t * t;
        along[i][2] = 0.5f * (0.5f + t) * (0.5f + t);
    }
    for (int bit = 0; bit < SC_BRICK_VERTICES; bit++) {
        for (int n = 0; n < 27; n++)
            w->weights[bit][n] = along[sc_bit_x(bit)][n % 3] * along[sc_bit_y(bit)][n / 3 % 3] *
                                 along[sc_bit_z(bit)][n / 9];
    }
}

sc_status sc_polish_fields(const sc_ctx *ctx, sc_preparation *p)
{
    polish w = {.p = p};
    const int threads = p->settings.threads;
    sc_status status;

    if (!(p->settings.smooth > 0))
        return SC_OK;
    SC_TRY(allocate(ctx, &w));
    fill_weights(&w);
    sc_parallel_for(threads, p->brick_count, 4096, sum_bricks, &w);
    for (int i = 0; i < SPREADS; i++) {
        entry *swap = w.entries;

        sc_parallel_for(threads, p->brick_count, 4096, spread_bricks, &w);
        w.entries = w.spread;
        w.spread = swap;
    }
    sc_parallel_for(threads, p->brick_count, 4096, polish_bricks, &w);
out:
    sc_free(w.slot);
    sc_free(w.entries);
    sc_free(w.spread);
    return status;
}
