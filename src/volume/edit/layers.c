/* SPDX-License-Identifier: BSD-3-Clause */
/* Segments in layers, as 3D Slicer writes those that overlap: each voxel has one value for each
 * layer, and the same value means another segment in another layer. Two passes over the voxels: the
 * first counts what each segment covers, the second gives each voxel to one of them. */
#include "source.h"

#include <stdlib.h>
#include <string.h>

enum { PAIRS_MAX = 1024 /* for so many segments, voxels are counted for each two */ };

/* The segments while they are read. The arrays belong to sc_load_layers. */
typedef struct layering {
    const sc_ctx *ctx;
    const char *path;
    const sc_overlap_rule *rule;
    sc_source *source;
    size_t count;     /* of segments */
    int64_t *last;    /* [layers]: the value that was looked up last in each layer, */
    size_t *found;    /* [layers]: and its segment; count: none has it */
    uint16_t *label;  /* [voxels of the part that is wanted] */
    uint64_t *pairs;  /* [count][count]: voxels that the first took from the second; or NULL */
    uint64_t unnamed; /* values that no segment has */
} layering;

/* Is the segment @p s before this layer and value? */
static bool is_before(const sc_segment *s, int layer, int64_t value)
{
    return s->layer != layer ? s->layer < layer : s->value < value;
}

/* For qsort of sc_segment: rising by layer, value and number. */
static int by_place(const void *a, const void *b)
{
    const sc_segment *x = a, *y = b;

    if (x->layer != y->layer || x->value != y->value)
        return is_before(x, y->layer, y->value) ? -1 : 1;
    return (x->row > y->row) - (x->row < y->row);
}

/* @return the row of the segment that has @p value in @p layer; l->count if none has. */
static size_t find_segment(layering *l, int layer, int64_t value)
{
    const sc_segment *segments = l->source->segments;
    size_t low = 0, high = l->count;

    if (l->last[layer] == value)
        return l->found[layer];
    while (low < high) {
        const size_t middle = low + (high - low) / 2;

        if (is_before(&segments[middle], layer, value))
            low = middle + 1;
        else
            high = middle;
    }
    l->last[layer] = value;
    l->found[layer] = low < l->count && segments[low].layer == layer && segments[low].value == value
                          ? segments[low].row
                          : l->count;
    return l->found[layer];
}

/* Count the values of one voxel. */
static void count_voxel(layering *l, const int64_t *values, uint64_t *voxels)
{
    for (int i = 0; i < l->source->layers; i++) {
        const size_t segment = values[i] ? find_segment(l, i, values[i]) : l->count;

        if (segment < l->count)
            voxels[segment]++;
        else
            l->unnamed += values[i] != 0;
    }
}

/* @return the row of the segment that gets a voxel with these values; l->count if none. */
static size_t paint_voxel(layering *l, const int64_t *values, const uint64_t *voxels)
{
    size_t best = l->count;
    bool several = false;

    for (int i = 0; i < l->source->layers; i++) {
        const size_t segment = values[i] ? find_segment(l, i, values[i]) : l->count;
        size_t loser = best;

        if (segment == l->count || segment == best || l->rule->left_out[segment])
            continue;
        if (best == l->count ||
            sc_overlap_wins(l->rule, (sc_contender){voxels[segment], segment, segment},
                            (sc_contender){voxels[best], best, best}))
            best = segment;
        else
            loser = segment;
        if (loser == l->count)
            continue;
        several = true;
        l->source->overlaps.lost[loser] = true;
        if (l->pairs)
            l->pairs[best * l->count + loser]++;
    }
    l->source->overlaps.voxels += several;
    return best;
}

/* @return the place of voxel @p at of the file in the part that is wanted; SIZE_MAX: it is not. */
static size_t place_in_part(const sc_source *source, size_t at)
{
    const size_t nx = (size_t)source->size[0], ny = (size_t)source->size[1];
    const int *low = source->low, *part = source->part;
    const int x = (int)(at % nx) - low[0], y = (int)(at / nx % ny) - low[1];
    const int z = (int)(at / nx / ny) - low[2];

    if (x < 0 || x >= part[0] || y < 0 || y >= part[1] || z < 0 || z >= part[2])
        return SIZE_MAX;
    return ((size_t)z * (size_t)part[1] + (size_t)y) * (size_t)part[0] + (size_t)x;
}

/* Go once through the voxels: count them, or, if @p paints, give them labels. */
static sc_status pass(layering *l, bool paints, uint64_t *voxels, int64_t *block)
{
    const int layers = l->source->layers;
    const size_t total = sc_source_voxels(l->source), most = (size_t)(SC_STREAM_BLOCK / layers);
    sc_source stored = *l->source; /* a row of it holds the layers of each voxel side by side */
    sc_voxel_stream *stream = NULL;
    sc_status status;

    stored.size[0] *= layers;
    SC_TRY(sc_stream_open(l->ctx, l->path, &stored, &stream));
    for (size_t begin = 0; begin < total; begin += most) {
        const size_t count = total - begin < most ? total - begin : most;

        SC_TRY(sc_stream_next(stream, count * (size_t)layers, block));
        for (size_t i = 0; i < count; i++) {
            const int64_t *values = block + i * (size_t)layers;
            const size_t place = place_in_part(l->source, begin + i);
            size_t row;

            if (!paints) {
                count_voxel(l, values, voxels);
                continue;
            }
            if (place == SIZE_MAX)
                continue;
            row = paint_voxel(l, values, voxels);
            if (row < l->count)
                l->label[place] = (uint16_t)l->source->table.rows[row].value;
        }
        sc_stage_add(l->ctx, count);
    }
    status = sc_stream_finish(stream);
out:
    sc_stream_close(stream);
    return status;
}

/* Put the labels in the place of the layers. @p source takes ownership of them. */
static void replace_voxels(sc_source *source, void *labels)
{
    if (source->release)
        source->release(source->data);
    source->encoding = SC_ENCODING_LOADED;
    source->type = SC_VOXEL_UINT16;
    source->swapped = false;
    source->data = labels;
    source->release = sc_free;
    source->layers = 1;
}

sc_status sc_load_layers(const sc_ctx *ctx, const char *path, const sc_overlap_rule *rule,
                         sc_source *source)
{
    const size_t voxels = sc_source_voxels(source), count = source->table.count;
    const size_t layers = (size_t)source->layers;
    const size_t wanted =
        (size_t)source->part[0] * (size_t)source->part[1] * (size_t)source->part[2];
    layering l = {.ctx = ctx, .path = path, .rule = rule, .source = source, .count = count};
    void *last = NULL, *found = NULL, *counts = NULL, *block = NULL, *labels = NULL, *pairs = NULL;
    sc_status status;

    SC_TRY(sc_volume_memory_check(ctx, path, source->part, (double)wanted * sizeof(uint16_t)));
    SC_TRY(sc_zalloc(ctx, wanted, sizeof(uint16_t), &labels));
    SC_TRY(sc_zalloc(ctx, layers, sizeof(int64_t), &last)); /* 0, which is not looked up */
    SC_TRY(sc_zalloc(ctx, layers, sizeof(size_t), &found));
    SC_TRY(sc_zalloc(ctx, count, sizeof(uint64_t), &counts));
    SC_TRY(sc_alloc(ctx, SC_STREAM_BLOCK, sizeof(int64_t), &block));
    if (count <= PAIRS_MAX)
        SC_TRY(sc_zalloc(ctx, count * count, sizeof(uint64_t), &pairs));
    SC_TRY(sc_overlap_count_begin(ctx, count, &source->overlaps));
    l.last = last;
    l.found = found;
    l.label = labels;
    l.pairs = pairs;
    qsort(source->segments, count, sizeof *source->segments, by_place);
    sc_stage_begin(ctx, "reading", 0, 2 * voxels);
    SC_TRY(pass(&l, false, counts, block));
    SC_TRY(pass(&l, true, counts, block));
    for (size_t i = 0; i < count; i++)
        source->overlaps.covers[i] = ((const uint64_t *)counts)[i] > 0;
    SC_TRY(sc_overlap_add_all(ctx, l.pairs, count, &source->overlaps));
    if (l.unnamed)
        sc_warn(ctx,
                "%s: %llu voxels of its layers hold a value that no segment has; they are "
                "left out",
                path, (unsigned long long)l.unnamed);
    sc_source_keep_part(source);
    replace_voxels(source, labels);
    labels = NULL;
out:
    sc_free(labels);
    sc_free(last);
    sc_free(found);
    sc_free(counts);
    sc_free(block);
    sc_free(pairs);
    return status;
}
