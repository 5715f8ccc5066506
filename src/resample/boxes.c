/* SPDX-License-Identifier: BSD-3-Clause */
/* The boxes of all labels of a volume. */
#include "internal.h"

/* What the threads that look for boxes share: [threads][label_count] boxes in voxels. */
typedef struct box_work {
    const sc_volume *v;
    sc_label_tally *boxes;
} box_work;

/* Grow the box of a label by the voxels from @p x to @p last of a row. */
static void grow_box(sc_label_tally *box, int x, int last, int y, int z)
{
    if (!box->voxels)
        *box = (sc_label_tally){0, {x, y, z}, {last, y, z}};
    box->voxels += (uint64_t)(last - x + 1);
    box->low[0] = x < box->low[0] ? x : box->low[0];
    box->low[1] = y < box->low[1] ? y : box->low[1];
    box->low[2] = z < box->low[2] ? z : box->low[2];
    box->high[0] = last > box->high[0] ? last : box->high[0];
    box->high[1] = y > box->high[1] ? y : box->high[1];
    box->high[2] = z > box->high[2] ? z : box->high[2];
}

/* Grow the boxes of the labels in the layers [begin, end) along z; an sc_range_fn on box_work. */
static void box_layers(void *user, size_t begin, size_t end, int thread)
{
    const box_work *w = user;
    const sc_volume *v = w->v;
    sc_label_tally *boxes = w->boxes + (size_t)thread * (size_t)v->label_count;

    for (int z = (int)begin; z < (int)end; z++) {
        for (int y = 0; y < v->size[1]; y++) {
            const size_t row = ((size_t)z * (size_t)v->size[1] + (size_t)y) * (size_t)v->size[0];

            for (int x = 0, last; x < v->size[0]; x = last + 1) {
                const uint32_t id = sc_volume_id(v, row + (size_t)x);

                for (last = x;
                     last + 1 < v->size[0] && sc_volume_id(v, row + (size_t)last + 1) == id;)
                    last++;
                grow_box(&boxes[id], x, last, y, z);
            }
        }
    }
}

/* Add what a thread has found of a label to @p all. */
static void join_box(sc_label_tally *all, const sc_label_tally *box)
{
    if (!box->voxels)
        return;
    if (!all->voxels)
        *all = (sc_label_tally){
            0, {box->low[0], box->low[1], box->low[2]}, {box->high[0], box->high[1], box->high[2]}};
    all->voxels += box->voxels;
    for (int i = 0; i < 3; i++) {
        all->low[i] = box->low[i] < all->low[i] ? box->low[i] : all->low[i];
        all->high[i] = box->high[i] > all->high[i] ? box->high[i] : all->high[i];
    }
}

sc_status sc_resample_find_boxes(const sc_ctx *ctx, const sc_volume *v, int threads,
                                 sc_label_tally **out)
{
    const size_t labels = (size_t)v->label_count;
    box_work w = {v, NULL};

    SC_PASS(SC_ZALLOC(ctx, (size_t)threads * labels, &w.boxes));
    sc_parallel_for(threads, (size_t)v->size[2], 1, box_layers, &w);
    for (int t = 1; t < threads; t++) {
        for (size_t id = 0; id < labels; id++)
            join_box(&w.boxes[id], &w.boxes[(size_t)t * labels + id]);
    }
    for (size_t id = 0; id < labels; id++) {
        if (!w.boxes[id].voxels)
            w.boxes[id] = (sc_label_tally){0, {v->size[0], v->size[1], v->size[2]}, {-1, -1, -1}};
    }
    *out = w.boxes;
    return SC_OK;
}
