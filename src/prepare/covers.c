/* SPDX-License-Identifier: BSD-3-Clause */
/* Which tissues lie outside, and which of them enclose and hide the others: skin, or what a
 * segmentation calls "other". */
#include "internal.h"

#include <string.h>

/* What rays along the axes of the volume meet, in both directions. */
typedef struct tally {
    uint64_t hides; /* rays that meet this tissue first, and another one behind it */
    uint64_t only;  /* rays that meet this tissue alone */
} tally;

/* Follow a ray of @p count voxels from @p index on. @param removed tissues through which it passes.
 * @return whether it meets anything. */
static bool follow(const sc_volume *v, const bool *removed, size_t index, ptrdiff_t step, int count,
                   tally *tallies)
{
    int first = 0;

    for (int i = 0; i < count; i++, index += (size_t)step) {
        const int id = (int)sc_id_at(v, index);

        if (id == 0 || removed[id] || id == first)
            continue;
        if (first) {
            tallies[first].hides++;
            return true;
        }
        first = id;
    }
    if (first)
        tallies[first].only++;
    return first != 0;
}

/* Send rays along @p axis in both directions. @return how many of them meet anything. */
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

            met += follow(v, removed, begin, step, count, tallies);
            met += follow(v, removed, end, -step, count, tallies);
        }
    }
    return met;
}

/* @return the tissue that hides others on the largest share of the rays that meet others at all, if
 * that share is at least @p least; otherwise 0. @param tallies room for label_count. */
static int find_cover(const sc_volume *v, const bool *removed, double least, tally *tallies)
{
    uint64_t met = 0;
    double most = least;
    int best = 0;

    memset(tallies, 0, (size_t)v->label_count * sizeof *tallies);
    for (int axis = 0; axis < 3; axis++)
        met += send_rays(v, axis, removed, tallies);
    for (int id = 1; id < v->label_count; id++) {
        const uint64_t others = met - tallies[id].only; /* rays that meet another tissue */
        const double share = others ? (double)tallies[id].hides / (double)others : 0;

        if (share >= most && others * 50 > met) {
            most = share;
            best = id;
        }
    }
    return best;
}

/* Write the share of the rays that meet anything which meet each tissue first, to @p shown. */
static void share_out(const tally *tallies, size_t count, double *shown)
{
    uint64_t met = 0;

    for (size_t id = 1; id < count; id++)
        met += tallies[id].hides + tallies[id].only;
    shown[0] = 0;
    for (size_t id = 1; id < count; id++)
        shown[id] = met ? (double)(tallies[id].hides + tallies[id].only) / (double)met : 0;
}

sc_status sc_find_covers(const sc_ctx *ctx, const sc_volume *volume, const bool *hidden,
                         int *layers, double *shown)
{
    const double least = 0.55; /* of the rays: skin and skull hide more, half of a brain less */
    const size_t count = (size_t)volume->label_count;
    bool *removed;
    void *flags = NULL, *tallies = NULL;
    int layer = 0;
    sc_status status;

    SC_TRY(sc_zalloc(ctx, count, sizeof *removed, &flags));
    SC_TRY(sc_alloc(ctx, count, sizeof(tally), &tallies));
    removed = flags;
    for (size_t id = 0; id < count; id++) {
        removed[id] = hidden && hidden[id];
        layers[id] = 0;
    }
    while (layer < SC_COVERS_MAX) {
        const int cover = find_cover(volume, removed, least, tallies);

        if (layer == 0 && shown)
            share_out(tallies, count, shown);
        if (!cover)
            break;
        layers[cover] = ++layer;
        removed[cover] = true;
    }
out:
    sc_free(flags);
    sc_free(tallies);
    return status;
}

sc_status sc_measure_covers(const sc_ctx *ctx, sc_preparation *p)
{
    const size_t count = (size_t)p->volume->label_count;
    void *layers = NULL, *shown = NULL;
    sc_status status;

    SC_TRY(sc_alloc(ctx, count, sizeof(int), &layers));
    SC_TRY(sc_alloc(ctx, count, sizeof(double), &shown));
    SC_TRY(sc_find_covers(ctx, p->volume, NULL, layers, shown));
    for (size_t id = 0; id < count; id++) {
        p->stats[id].cover_layer = ((const int *)layers)[id];
        p->stats[id].shown = ((const double *)shown)[id];
    }
out:
    sc_free(layers);
    sc_free(shown);
    return status;
}
