/* SPDX-License-Identifier: BSD-3-Clause */
/* Segments in layers, as 3D Slicer writes those that overlap: each voxel has one value for each
 * layer, and the same value means another segment in another layer. Two passes over the voxels: the
 * first counts what each segment covers, the second gives each voxel to one of them. */
#include "source.h"

#include <stdlib.h>

/* The segments while they are read. The arrays belong to sc_load_layers. */
typedef struct layering {
    sc_claims *claims;
    sc_source *source;
    size_t count;     /* of segments */
    int64_t *last;    /* [layers]: the value that was looked up last in each layer, */
    size_t *found;    /* [layers]: and its segment; count: none has it */
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
static void count_voxel(layering *l, const int64_t *values)
{
    for (int i = 0; i < l->source->layers; i++) {
        const size_t segment = values[i] ? find_segment(l, i, values[i]) : l->count;

        if (segment < l->count)
            l->claims->voxels[segment]++;
        else
            l->unnamed += values[i] != 0;
    }
}

/* @return the row of the segment that gets a voxel with these values; l->count if none. */
static size_t paint_voxel(layering *l, const int64_t *values)
{
    size_t best = l->count;
    bool several = false;

    for (int i = 0; i < l->source->layers; i++) {
        const size_t segment = values[i] ? find_segment(l, i, values[i]) : l->count;

        if (segment == l->count || segment == best || l->claims->rule->left_out[segment])
            continue;
        several = several || best < l->count;
        best = best < l->count ? sc_claims_settle(l->claims, segment, best) : segment;
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
static sc_status pass(layering *l, bool paints, int64_t *block)
{
    const sc_ctx *ctx = l->claims->ctx;
    const int layers = l->source->layers;
    const size_t total = sc_source_voxels(l->source), most = (size_t)(SC_STREAM_BLOCK / layers);
    sc_source stored = *l->source; /* a row of it holds the layers of each voxel side by side */
    SC_OWN(sc_stream_close_at) sc_voxel_stream *stream = NULL;

    stored.size[0] *= layers;
    SC_PASS(sc_stream_open(ctx, l->claims->path, &stored, &stream));
    for (size_t begin = 0; begin < total; begin += most) {
        const size_t count = total - begin < most ? total - begin : most;

        SC_PASS(sc_stream_next(stream, count * (size_t)layers, block));
        for (size_t i = 0; i < count; i++) {
            const int64_t *values = block + i * (size_t)layers;
            const size_t place = paints ? place_in_part(l->source, begin + i) : SIZE_MAX;
            size_t row = l->count;

            if (!paints)
                count_voxel(l, values);
            if (place != SIZE_MAX)
                row = paint_voxel(l, values);
            if (row < l->count)
                l->claims->labels[place] = (uint16_t)l->source->table.rows[row].value;
        }
        sc_stage_add(ctx, count);
    }
    return sc_stream_finish(stream);
}

sc_status sc_load_layers(const sc_ctx *ctx, const char *path, const sc_overlap_rule *rule,
                         sc_source *source)
{
    const size_t layers = (size_t)source->layers;
    SC_OWN(sc_claims_clear) sc_claims claims = {0};
    layering l = {.claims = &claims, .source = source, .count = source->table.count};
    SC_OWN(sc_free_at) int64_t *last = NULL, *block = NULL;
    SC_OWN(sc_free_at) size_t *found = NULL;

    SC_PASS(sc_claims_begin(ctx, path, rule, source, &claims));
    SC_PASS(SC_ZALLOC(ctx, layers, &last)); /* 0, which is not looked up */
    SC_PASS(SC_ZALLOC(ctx, layers, &found));
    SC_PASS(SC_ALLOC(ctx, SC_STREAM_BLOCK, &block));
    l.last = last;
    l.found = found;
    qsort(source->segments, l.count, sizeof *source->segments, by_place);
    sc_stage_begin(ctx, "reading", 0, 2 * sc_source_voxels(source));
    SC_PASS(pass(&l, false, block));
    SC_PASS(pass(&l, true, block));
    if (l.unnamed)
        sc_warn(ctx,
                "%s: %llu voxels of its layers hold a value that no segment has; they are "
                "left out",
                path, (unsigned long long)l.unnamed);
    return sc_claims_end(&claims);
}
