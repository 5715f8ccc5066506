/* SPDX-License-Identifier: BSD-3-Clause */
/* Labels of any width become dense ids: background 0 first, then the other values in rising order.
 * One pass over the voxels numbers the labels in the order of their first voxel; the ids are put
 * into the final order afterwards. Neighbouring voxels mostly agree, so that a label is looked up
 * once per run of equal values along x. */
#include "source.h"

#include <stdlib.h>
#include <string.h>

enum {
    SLOT_BITS = 18,
    SLOTS = 1 << SLOT_BITS, /* four times the most labels there can be: searches stay short */
    NARROW_LABELS = 256     /* so many distinct labels fit into ids of one byte */
};

/* Open-addressing set of label values, each with its first id: the number that it got when it was
 * first met. */
typedef struct value_set {
    int64_t *values; /* [SLOTS] */
    int32_t *ids;    /* [SLOTS], first ids; -1: slot free */
    int count;       /* distinct values so far */
} value_set;

/* The pass over the voxels. The arrays are owned by sc_read_labels. */
typedef struct label_pass {
    const sc_ctx *ctx;
    const char *path;
    const sc_source *source;
    size_t voxels;
    value_set set;
    sc_label_tally *tallies; /* [SC_LABELS_MAX], by first id */
    uint64_t *runs;          /* [SC_LABELS_MAX], by first id: runs of equal voxels along x */
    bool keep_ids;
    int id_bytes; /* 1 or 2 */
    void *ids;    /* [voxels] of id_bytes each, first ids, zero until set; NULL unless keep_ids */
} label_pass;

/* The slot that holds @p value, or else the free one where it belongs: Fibonacci hashing
 * (Knuth, volume 3, section 6.4), then linear probing. */
static size_t slot_of(const value_set *set, int64_t value)
{
    size_t slot = (size_t)(((uint64_t)value * 0x9e3779b97f4a7c15u) >> (64 - SLOT_BITS));

    while (set->ids[slot] >= 0 && set->values[slot] != value)
        slot = (slot + 1) & (SLOTS - 1);
    return slot;
}

/* Replace pass->ids by ids of two bytes, of which the first @p done are copied, since one byte
 * per id no longer suffices. @return SC_ERR_MEMORY; nothing has changed then. */
static sc_status widen_ids(label_pass *pass, size_t done)
{
    void *block;
    sc_status status = sc_zalloc(pass->ctx, pass->voxels, sizeof(uint16_t), &block);
    uint16_t *wide = block;

    if (status != SC_OK)
        return status;
    for (size_t i = 0; i < done; i++) {
        if (((const uint8_t *)pass->ids)[i])
            wide[i] = ((const uint8_t *)pass->ids)[i];
    }
    sc_free(pass->ids);
    pass->ids = wide;
    pass->id_bytes = sizeof(uint16_t);
    return SC_OK;
}

/* Write the first id of a value to *id. A new value is added to the set with an empty tally;
 * ids become wider when needed, of which the first @p done are valid. @return SC_ERR_DATA for
 * more than SC_LABELS_MAX labels, SC_ERR_MEMORY. */
static sc_status id_of(label_pass *pass, int64_t value, size_t done, int32_t *id)
{
    value_set *set = &pass->set;
    const size_t slot = slot_of(set, value);

    *id = set->ids[slot];
    if (*id >= 0)
        return SC_OK;
    if (set->count == SC_LABELS_MAX)
        return sc_fail(pass->ctx, SC_ERR_DATA,
                       "%s: more than %d different labels; is this a grey-value image?", pass->path,
                       SC_LABELS_MAX - 1);
    set->values[slot] = value;
    *id = set->ids[slot] = set->count++;
    for (int i = 0; i < 3; i++) {
        pass->tallies[*id].low[i] = pass->source->size[i];
        pass->tallies[*id].high[i] = -1;
    }
    return set->count == NARROW_LABELS + 1 && pass->keep_ids ? widen_ids(pass, done) : SC_OK;
}

static int least(int a, int b)
{
    return a < b ? a : b;
}

static int most(int a, int b)
{
    return a > b ? a : b;
}

/* Add a run of @p length voxels along x, the first of which lies at @p first, to the tally. */
static void count_run(sc_label_tally *tally, const int first[3], int length)
{
    tally->voxels += (uint64_t)length;
    tally->low[0] = least(tally->low[0], first[0]);
    tally->high[0] = most(tally->high[0], first[0] + length - 1);
    for (int i = 1; i < 3; i++) {
        tally->low[i] = least(tally->low[i], first[i]);
        tally->high[i] = most(tally->high[i], first[i]);
    }
}

/* Set the ids of @p length voxels from voxel @p begin on to @p id. pass->ids is not NULL. */
static void fill_ids(label_pass *pass, size_t begin, int length, int32_t id)
{
    if (pass->id_bytes == 1) {
        memset((uint8_t *)pass->ids + begin, id, (size_t)length);
    } else {
        uint16_t *ids = (uint16_t *)pass->ids + begin;

        for (int i = 0; i < length; i++)
            ids[i] = (uint16_t)id;
    }
}

/* Tally voxels [begin, begin + count), which hold @p values, and set their ids if they are
 * kept. @p at: where the first of them lies, moved on to where the next one will. The value 0
 * has the first id 0 already. @return the errors of id_of. */
static sc_status visit_block(label_pass *pass, const int64_t *values, size_t begin, int count,
                             int at[3])
{
    const int *size = pass->source->size;
    int64_t last = 0;
    int32_t id = 0;

    for (int i = 0, end; i < count; i = end) {
        const int row_end = least(count - i, size[0] - at[0]) + i;

        for (end = i + 1; end < row_end && values[end] == values[i]; end++) {
        }
        if (values[i] != last) {
            const sc_status status = id_of(pass, values[i], begin + (size_t)i, &id);

            if (status != SC_OK)
                return status;
            last = values[i];
        }
        count_run(&pass->tallies[id], at, end - i);
        pass->runs[id]++;
        if (pass->keep_ids && id != 0) /* pages of background alone are never touched */
            fill_ids(pass, begin + (size_t)i, end - i, id);
        at[0] += end - i;
        if (at[0] == size[0]) {
            at[0] = 0;
            at[2] += at[1] + 1 == size[1];
            at[1] = at[1] + 1 == size[1] ? 0 : at[1] + 1;
        }
    }
    return SC_OK;
}

/* Read all voxels into the set, the tallies, the runs and, if kept, the ids of @p pass.
 * Background gets the first id 0, also if no voxel has it. @return the errors of the stream and
 * of id_of. */
static sc_status visit_voxels(label_pass *pass)
{
    sc_voxel_stream *stream = NULL;
    void *block = NULL;
    int at[3] = {0, 0, 0};
    int32_t background;
    sc_status status;

    SC_TRY(id_of(pass, 0, 0, &background));
    SC_TRY(sc_alloc(pass->ctx, SC_STREAM_BLOCK, sizeof(int64_t), &block));
    SC_TRY(sc_stream_open(pass->ctx, pass->path, pass->source, &stream));
    sc_stage_begin(pass->ctx, "reading", 0, pass->voxels);
    for (size_t begin = 0; begin < pass->voxels; begin += SC_STREAM_BLOCK) {
        const size_t left = pass->voxels - begin;
        const size_t count = left < SC_STREAM_BLOCK ? left : SC_STREAM_BLOCK;

        SC_TRY(sc_stream_next(stream, count, block));
        SC_TRY(visit_block(pass, block, begin, (int)count, at));
        sc_stage_add(pass->ctx, count);
    }
    status = sc_stream_finish(stream);
out:
    sc_stream_close(stream);
    sc_free(block);
    return status;
}

/* For qsort of sc_label: rising by value. */
static int by_value(const void *a, const void *b)
{
    const int64_t x = ((const sc_label *)a)->value, y = ((const sc_label *)b)->value;

    return (x > y) - (x < y);
}

/* Make the labels in their final order: labels and label_count of @p volume, and *tallies,
 * [label_count]. The caller owns and frees them, also after an error. @param final
 * [SC_LABELS_MAX], receives the dense id of each first id. @return SC_ERR_MEMORY. */
static sc_status order_labels(const label_pass *pass, sc_volume *volume, sc_label_tally **tallies,
                              uint16_t *final)
{
    const value_set *set = &pass->set;
    sc_label *labels;
    void *block;
    sc_status status = sc_zalloc(pass->ctx, (size_t)set->count, sizeof *labels, &block);

    if (status != SC_OK)
        return status;
    volume->labels = labels = block;
    volume->label_count = set->count;
    status = sc_alloc(pass->ctx, (size_t)set->count, sizeof **tallies, &block);
    if (status != SC_OK)
        return status;
    *tallies = block;
    for (size_t slot = 0; slot < SLOTS; slot++) {
        if (set->ids[slot] >= 0)
            labels[set->ids[slot]] = sc_label_new(set->values[slot]);
    }
    qsort(labels + 1, (size_t)set->count - 1, sizeof *labels, by_value);
    for (int i = 0; i < set->count; i++) {
        const int32_t first = set->ids[slot_of(set, labels[i].value)];

        final[first] = (uint16_t)i;
        (*tallies)[i] = pass->tallies[first];
    }
    return SC_OK;
}

/* Turn the first ids in pass->ids, which is not NULL, into dense ids by @p final (of
 * order_labels). */
static void renumber(label_pass *pass, const uint16_t *final)
{
    bool in_order = true;

    for (int i = 0; i < pass->set.count; i++)
        in_order = in_order && final[i] == i;
    if (in_order)
        return;
    if (pass->id_bytes == 1) {
        uint8_t *ids = pass->ids;

        for (size_t i = 0; i < pass->voxels; i++) {
            if (ids[i]) /* background keeps its id */
                ids[i] = (uint8_t) final[ids[i]];
        }
    } else {
        uint16_t *ids = pass->ids;

        for (size_t i = 0; i < pass->voxels; i++) {
            if (ids[i])
                ids[i] = final[ids[i]];
        }
    }
}

/* The marks of a grey-value image: more labels than this, and shorter runs, in voxels, than this.
 */
enum { GREY_LABELS = 32, GREY_RUN_VOXELS = 2 };

/* Does the volume look like a grey-value image? Equal values seldom lie side by side in noise.
 * Neither background nor the commonest other value counts: a grey-value image is often padded
 * with a value of its own. */
static bool looks_grey(const label_pass *pass)
{
    uint64_t voxels = 0, runs = 0;
    int commonest = 1;

    if (pass->set.count <= GREY_LABELS)
        return false;
    for (int id = 2; id < pass->set.count; id++) {
        if (pass->tallies[id].voxels > pass->tallies[commonest].voxels)
            commonest = id;
    }
    for (int id = 1; id < pass->set.count; id++) {
        voxels += id == commonest ? 0 : pass->tallies[id].voxels;
        runs += id == commonest ? 0 : pass->runs[id];
    }
    return voxels < GREY_RUN_VOXELS * runs;
}

/* Warn if the volume looks like a grey-value image, or else if it has negative values.
 * @p volume has its labels in their final order. */
static void warn_of_grey_values(const label_pass *pass, const sc_volume *volume)
{
    const int64_t lowest = volume->label_count > 1 ? volume->labels[1].value : 0;
    const int64_t highest = volume->labels[volume->label_count - 1].value;

    if (looks_grey(pass))
        sc_warn(pass->ctx,
                "%s: looks like a grey-value image, not like a segmentation: %d different values "
                "from %lld to %lld, and equal ones seldom lie side by side; each value is shown as "
                "a tissue of its own",
                pass->path, volume->label_count - 1, (long long)(lowest < 0 ? lowest : 0),
                (long long)highest);
    else if (lowest < 0)
        sc_warn(pass->ctx,
                "%s: holds negative values, down to %lld, which segmentations seldom have; they "
                "are shown as tissues of their own",
                pass->path, (long long)lowest);
}

sc_status sc_read_labels(const sc_ctx *ctx, const char *path, const sc_source *source,
                         bool keep_ids, sc_volume *volume, sc_label_tally **tallies)
{
    label_pass pass = {.ctx = ctx,
                       .path = path,
                       .source = source,
                       .voxels = sc_source_voxels(source),
                       .keep_ids = keep_ids,
                       .id_bytes = 1};
    sc_volume found = {.size = {source->size[0], source->size[1], source->size[2]}};
    sc_label_tally *final_tallies = NULL;
    void *values = NULL, *ids = NULL, *first_tallies = NULL, *runs = NULL, *final = NULL;
    sc_status status;

    SC_TRY(sc_alloc(ctx, SLOTS, sizeof(int64_t), &values));
    SC_TRY(sc_alloc(ctx, SLOTS, sizeof(int32_t), &ids));
    SC_TRY(sc_zalloc(ctx, SC_LABELS_MAX, sizeof(sc_label_tally), &first_tallies));
    SC_TRY(sc_zalloc(ctx, SC_LABELS_MAX, sizeof(uint64_t), &runs));
    SC_TRY(sc_alloc(ctx, SC_LABELS_MAX, sizeof(uint16_t), &final));
    memset(ids, 0xff, SLOTS * sizeof(int32_t));
    pass.set = (value_set){.values = values, .ids = ids};
    pass.tallies = first_tallies;
    pass.runs = runs;
    if (keep_ids)
        SC_TRY(sc_zalloc(ctx, pass.voxels, 1, &pass.ids));
    SC_TRY(visit_voxels(&pass));
    SC_TRY(order_labels(&pass, &found, &final_tallies, final));
    warn_of_grey_values(&pass, &found);
    if (keep_ids)
        renumber(&pass, final);
    found.label_bytes = found.label_count <= NARROW_LABELS ? 1 : 2;
    found.ids = pass.ids;
    pass.ids = NULL;
    *volume = found;
    found = (sc_volume){0};
    *tallies = final_tallies;
    final_tallies = NULL;
out:
    sc_volume_clear(&found);
    sc_free(final_tallies);
    sc_free(pass.ids);
    sc_free(values);
    sc_free(ids);
    sc_free(first_tallies);
    sc_free(runs);
    sc_free(final);
    return status;
}
