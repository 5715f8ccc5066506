/* SPDX-License-Identifier: BSD-3-Clause */
/* Which tissues lie outside, and which of them enclose and hide the others: skin, or what a
 * segmentation calls "other". */
#include "internal.h"

#include <string.h>

/* A tissue that hides others on this share of the rays that meet others is a cover: skin and skull
 * hide more, half of a brain less. */
#define HIDES_MOST 0.55
/* Behind a cover also one that hides them on this share, and encloses them, being in front of them
 * and behind them, on that of the rays along every axis: the parts of a skull, but no half of a
 * brain, and no ribs. */
#define HIDES_SOME 0.25
#define ENCLOSES 0.1

/* What rays along one axis of the volume meet, in both directions. */
typedef struct tally {
    uint64_t hides;    /* rays that meet this tissue first, and another one behind it */
    uint64_t encloses; /* ... and this one again behind all others */
    uint64_t only;     /* rays that meet this tissue alone */
} tally;

/* Follow a ray of @p count voxels from @p index on. @param removed tissues through which it passes.
 * @param hides set to whether it meets two tissues or more. @return the first one; 0: none. */
static int follow(const sc_volume *v, const bool *removed, size_t index, ptrdiff_t step, int count,
                  bool *hides)
{
    int first = 0;

    *hides = false;
    for (int i = 0; i < count; i++, index += (size_t)step) {
        const int id = (int)sc_volume_id(v, index);

        if (id == 0 || removed[id] || id == first)
            continue;
        if (first) {
            *hides = true;
            return first;
        }
        first = id;
    }
    return first;
}

/* Send rays along @p axis in both directions. @param removed tissues through which they pass.
 * @param tallies [label_count]. @return how many of them meet anything. */
static uint64_t send_rays(const sc_volume *v, int axis, const bool *removed, tally *tallies)
{
    enum { RAYS = 96 }; /* along each of the other two axes, at most */
    const size_t strides[3] = {1, (size_t)v->size[0], (size_t)v->size[0] * (size_t)v->size[1]};
    const int a = (axis + 1) % 3, b = (axis + 2) % 3, count = v->size[axis];
    const int step_a = v->size[a] / RAYS + 1, step_b = v->size[b] / RAYS + 1;
    const ptrdiff_t step = (ptrdiff_t)strides[axis];
    uint64_t met = 0;

    for (int i = 0; i < v->size[a]; i += step_a) {
        for (int j = 0; j < v->size[b]; j += step_b) {
            const size_t begin = (size_t)i * strides[a] + (size_t)j * strides[b];
            const size_t end = begin + (size_t)(count - 1) * strides[axis];
            bool hides;
            const int near = follow(v, removed, begin, step, count, &hides);
            const int far = near ? follow(v, removed, end, -step, count, &hides) : 0;

            if (near == 0)
                continue;
            met += 2;
            if (!hides) {
                tallies[near].only += 2;
                continue;
            }
            tallies[near].hides++;
            tallies[far].hides++;
            tallies[near].encloses += near == far ? 2 : 0;
        }
    }
    return met;
}

/* What is known of one tissue. */
typedef struct cover_shares {
    double hides;    /* of the rays that meet another tissue, those that meet this one before */
    double encloses; /* ... and also behind all others, along the axis with the smallest share */
    bool has_others; /* enough rays meet another tissue */
} cover_shares;

/* @return the shares of a tissue. @param tallies [3][count] by axis. @param met rays that meet
 * anything, by axis. */
static cover_shares shares_of(const tally *tallies, size_t count, const uint64_t met[3], size_t id)
{
    uint64_t hides = 0, only = 0, all = 0;
    cover_shares out = {.encloses = 1};

    for (int axis = 0; axis < 3; axis++) {
        const tally *t = &tallies[(size_t)axis * count + id];
        const uint64_t others = met[axis] - t->only;

        hides += t->hides;
        only += t->only;
        all += met[axis];
        out.encloses = fmin(out.encloses, others ? (double)t->encloses / (double)others : 0);
    }
    out.hides = all > only ? (double)hides / (double)(all - only) : 0;
    out.has_others = (all - only) * 50 > all;
    return out;
}

/* @return the tissue that hides others on the largest share of the rays that meet others at all, of
 * those that are covers; 0 if none is. @param is_inside a cover has been removed. @param tallies
 * room for [3][label_count]. @param met rays that meet anything, by axis. */
static int find_cover(const sc_volume *v, const bool *removed, bool is_inside, tally *tallies,
                      uint64_t met[3])
{
    const size_t count = (size_t)v->label_count;
    double most = 0;
    int best = 0;

    memset(tallies, 0, 3 * count * sizeof *tallies);
    for (int axis = 0; axis < 3; axis++)
        met[axis] = send_rays(v, axis, removed, tallies + (size_t)axis * count);
    for (size_t id = 1; id < count; id++) {
        const cover_shares s = shares_of(tallies, count, met, id);
        const bool is_cover =
            s.hides >= HIDES_MOST || (is_inside && s.hides >= HIDES_SOME && s.encloses >= ENCLOSES);

        if (is_cover && s.hides >= most && s.has_others) {
            most = s.hides;
            best = (int)id;
        }
    }
    return best;
}

/* Write the share of the rays that meet anything which meet each tissue first, to @p shown. */
static void share_out(const tally *tallies, size_t count, const uint64_t met[3], double *shown)
{
    const uint64_t all = met[0] + met[1] + met[2];

    shown[0] = 0;
    for (size_t id = 1; id < count; id++) {
        uint64_t first = 0;

        for (size_t axis = 0; axis < 3; axis++)
            first += tallies[axis * count + id].hides + tallies[axis * count + id].only;
        shown[id] = all ? (double)first / (double)all : 0;
    }
}

sc_status sc_find_covers(const sc_ctx *ctx, const sc_volume *volume, const bool *hidden,
                         int *layers, double *shown)
{
    uint64_t met[3];
    const size_t count = (size_t)volume->label_count;
    bool *removed;
    SC_OWN(sc_free_at) void *flags = NULL, *tallies = NULL;
    int layer = 0;

    SC_PASS(sc_zalloc(ctx, count, sizeof *removed, &flags));
    SC_PASS(sc_alloc(ctx, 3 * count, sizeof(tally), &tallies));
    removed = flags;
    for (size_t id = 0; id < count; id++) {
        removed[id] = hidden && hidden[id];
        layers[id] = 0;
    }
    while (layer < SC_COVERS_MAX) {
        const int cover = find_cover(volume, removed, layer > 0, tallies, met);

        if (layer == 0 && shown)
            share_out(tallies, count, met, shown);
        if (!cover)
            break;
        layers[cover] = ++layer;
        removed[cover] = true;
    }
    return SC_OK;
}

sc_status sc_find_outer_cover(const sc_ctx *ctx, const sc_volume *volume, int *cover)
{
    uint64_t met[3];
    const size_t count = (size_t)volume->label_count;
    SC_OWN(sc_free_at) void *removed = NULL, *tallies = NULL;

    SC_PASS(sc_zalloc(ctx, count, sizeof(bool), &removed));
    SC_PASS(sc_alloc(ctx, 3 * count, sizeof(tally), &tallies));
    *cover = find_cover(volume, removed, false, tallies, met);
    return SC_OK;
}

sc_status sc_measure_covers(const sc_ctx *ctx, sc_preparation *p)
{
    const size_t count = (size_t)p->volume->label_count;
    SC_OWN(sc_free_at) int *layers = NULL;
    SC_OWN(sc_free_at) double *shown = NULL;
    sc_status status = SC_ALLOC(ctx, count, &layers);

    if (status == SC_OK)
        status = SC_ALLOC(ctx, count, &shown);
    if (status == SC_OK)
        status = sc_find_covers(ctx, p->volume, NULL, layers, shown);
    SC_PASS(sc_team_agree(p->team, status));
    for (size_t id = 0; id < count; id++) {
        p->stats[id].cover_layer = layers[id];
        p->stats[id].shown = shown[id];
    }
    return SC_OK;
}
