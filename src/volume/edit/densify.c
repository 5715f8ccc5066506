/* SPDX-License-Identifier: BSD-3-Clause */
/* Labels of any width become dense ids: background 0 first, then the other values in rising order.
 * One pass over the voxels numbers the labels as threads meet them; the ids are put into the final
 * order afterwards, so that it does not matter in which order that was. Neighbouring voxels mostly
 * agree, so that a label is looked up once per run of equal values along x. */
#include "source.h"

#include <stdlib.h>

enum {
    SLOT_BITS = 18,
    SLOTS = 1 << SLOT_BITS, /* four times the most labels there can be: searches stay short */
    NARROW_LABELS = 256,    /* so many distinct labels fit into ids of one byte */
    BLOCK_VOXELS = 4096,    /* whose values a thread looks at at a time: they stay in its cache */
    RANGE_VOXELS = 1 << 16, /* that a thread claims at a time */
    WORKER_VOXELS = 1 << 19 /* another thread is not worth its memory for fewer voxels */
};

/* What a slot of a value_set holds where there is no id. */
enum { SLOT_FREE = -1, SLOT_TAKEN = -2 /* a thread is writing the value */ };

/* Open-addressing set of label values, each with its first id: the number that it got when it was
 * first met. Several threads may look values up and add some. */
typedef struct value_set {
    int64_t *values;      /* [SLOTS] */
    _Atomic int32_t *ids; /* [SLOTS], first ids, or SLOT_FREE, SLOT_TAKEN */
    _Atomic int count;    /* distinct values so far; above SC_LABELS_MAX: there are too many */
} value_set;

/* What one thread works on. */
typedef struct label_worker {
    sc_label_tally *tallies; /* [SC_LABELS_MAX], by first id; no box without voxels; owned */
    uint64_t *runs;          /* [SC_LABELS_MAX], by first id: runs of equal voxels along x; owned */
    int64_t *values;         /* [2 * BLOCK_VOXELS]: those of a block, and room; owned. Not used if
                                the voxels are looked at as they are stored */
    int64_t last;            /* the value that was looked up last */
    int32_t last_id;         /* its first id */
    int64_t last_outside;    /* the value that was noted last outside of the part */
    size_t bad;              /* the first voxel met that is no label; SIZE_MAX: none */
} label_worker;

/* The pass over the voxels. Owns its arrays: clear_pass. */
typedef struct label_pass {
    const sc_ctx *ctx;
    const char *path;
    const sc_source *source;
    size_t voxels; /* of the file */
    size_t wanted; /* of the part that is wanted */
    int threads;
    label_worker *workers; /* [threads]; the first has the sum of all in the end */
    value_set set;
    value_set outside; /* values of voxels that are not wanted; empty arrays: all are wanted */
    bool keep_ids;
    int id_bytes; /* 1 or 2 */
    void *ids;    /* [wanted] of id_bytes each, first ids, zero until set; NULL unless keep_ids */
    /* The batch of voxels that is looked at. */
    sc_voxel_stream *stream;
    const unsigned char *batch; /* as stored */
    size_t begin;               /* the first voxel */
    bool as_stored;             /* the stored numbers are the labels */
    bool ahead;                 /* one thread reads the next batch meanwhile */
    bool recounts;              /* only ids are set, since the batch has been counted */
    atomic_bool too_wide;       /* there was an id that does not fit into pass->ids */
} label_pass;

/* The slot where @p value belongs in an empty set: Fibonacci hashing (Knuth, volume 3, section
 * 6.4). */
static size_t first_slot(int64_t value)
{
    return (size_t)(((uint64_t)value * 0x9e3779b97f4a7c15u) >> (64 - SLOT_BITS));
}

/* @return the first id of a value, which is added to the set if it is new; SC_LABELS_MAX if there
 * is no room for more labels. Threads: any. */
static int32_t id_of(value_set *set, int64_t value)
{
    size_t slot = first_slot(value);

    for (;;) {
        int32_t id = atomic_load_explicit(&set->ids[slot], memory_order_acquire);

        if (id == SLOT_FREE && atomic_compare_exchange_strong(&set->ids[slot], &id, SLOT_TAKEN)) {
            id = atomic_fetch_add(&set->count, 1);
            if (id >= SC_LABELS_MAX) { /* the slot stays free, so that searches end */
                atomic_store(&set->count, SC_LABELS_MAX + 1);
                atomic_store_explicit(&set->ids[slot], SLOT_FREE, memory_order_release);
                return SC_LABELS_MAX;
            }
            set->values[slot] = value;
            atomic_store_explicit(&set->ids[slot], id, memory_order_release);
            return id;
        }
        while (id == SLOT_TAKEN)
            id = atomic_load_explicit(&set->ids[slot], memory_order_acquire);
        if (id >= 0 && set->values[slot] == value)
            return id;
        if (id >= 0)
            slot = (slot + 1) & (SLOTS - 1);
    }
}

static int least(int a, int b)
{
    return a < b ? a : b;
}

static int most(int a, int b)
{
    return a > b ? a : b;
}

/* Set the ids of @p length voxels from voxel @p begin on to @p id, if they are kept and it fits. */
static void fill_ids(label_pass *pass, size_t begin, size_t length, int32_t id)
{
    if (!pass->keep_ids || id == 0) /* pages of background alone are never touched */
        return;
    if (pass->id_bytes == 1 && id >= NARROW_LABELS) {
        atomic_store_explicit(&pass->too_wide, true, memory_order_relaxed);
    } else if (pass->id_bytes == 1) {
        memset((uint8_t *)pass->ids + begin, id, length);
    } else {
        uint16_t *ids = (uint16_t *)pass->ids + begin;

        for (size_t i = 0; i < length; i++)
            ids[i] = (uint16_t)id;
    }
}

/* Tally @p count voxels of one row along x, the first of which is voxel @p begin of the part and
 * lies at @p first in it, by their values of type @p type, and set their ids. @return false if
 * there are too many labels. */
static bool visit_row(label_pass *pass, label_worker *w, sc_voxel_type type, const void *values,
                      size_t begin, const int first[3], int count)
{
    int at[3] = {first[0], first[1], first[2]}, last[3] = {first[0], first[1], first[2]};

    for (int i = 0, end; i < count; i = end) {
        int64_t value;

        end = sc_run_end(type, values, i, count, &value);
        if (value != w->last) {
            const int32_t id = id_of(&pass->set, value);

            if (id == SC_LABELS_MAX)
                return false;
            w->last = value;
            w->last_id = id;
        }
        if (!pass->recounts) {
            at[0] = first[0] + i;
            last[0] = first[0] + end - 1;
            sc_tally_add(&w->tallies[w->last_id], at, last, (uint64_t)(end - i));
            w->runs[w->last_id]++;
        }
        fill_ids(pass, begin + (size_t)i, (size_t)(end - i), w->last_id);
    }
    return true;
}

/* Note the values [begin, end), of type @p type, of voxels that are not wanted. */
static void note_outside(label_pass *pass, label_worker *w, sc_voxel_type type, const void *values,
                         int begin, int end)
{
    for (int i = begin, next; i < end; i = next) {
        int64_t value;

        next = sc_run_end(type, values, i, end, &value);
        if (value != w->last_outside)
            (void)id_of(&pass->outside, value);
        w->last_outside = value;
    }
}

/* Visit the voxels [@p x, + @p count) of the row @p y, @p z of the file, as far as they are wanted.
 * @return as visit_row. */
static bool visit_part(label_pass *pass, label_worker *w, const void *values, const int at[3],
                       int count)
{
    const sc_voxel_type type = pass->as_stored ? pass->source->type : SC_VOXEL_INT64;

    const int *low = pass->source->low, *part = pass->source->part;
    const int begin = most(at[0], low[0]), end = least(at[0] + count, low[0] + part[0]);
    const int first[3] = {begin - low[0], at[1] - low[1], at[2] - low[2]};
    size_t voxel;

    if (begin >= end || first[1] < 0 || first[1] >= part[1] || first[2] < 0 ||
        first[2] >= part[2]) {
        note_outside(pass, w, type, values, 0, count);
        return true;
    }
    note_outside(pass, w, type, values, 0, begin - at[0]);
    note_outside(pass, w, type, values, end - at[0], count);
    voxel = ((size_t)first[2] * (size_t)part[1] + (size_t)first[1]) * (size_t)part[0] +
            (size_t)first[0];
    values = (const unsigned char *)values + (size_t)(begin - at[0]) * sc_voxel_type_bytes(type);
    return visit_row(pass, w, type, values, voxel, first, end - begin);
}

/* Visit @p count voxels, the first of which is voxel @p from of the file, by their values: as they
 * are stored, or of type int64. @return as visit_row. */
static bool visit_values(label_pass *pass, label_worker *w, const unsigned char *values,
                         size_t from, size_t count)
{
    const size_t each = pass->as_stored ? sc_voxel_type_bytes(pass->source->type) : sizeof(int64_t);
    const size_t nx = (size_t)pass->source->size[0], ny = (size_t)pass->source->size[1];

    for (size_t i = 0, length; i < count; i += length) {
        const size_t voxel = from + i, x = voxel % nx;
        const int at[3] = {(int)x, (int)(voxel / nx % ny), (int)(voxel / nx / ny)};

        length = count - i < nx - x ? count - i : nx - x;
        if (!visit_part(pass, w, values + i * each, at, (int)length))
            return false;
    }
    return true;
}

/* sc_range_fn: tally voxels [begin, end) of the batch, counted from its first, and set their ids;
 * @p user is a label_pass. */
static void visit_range(void *user, size_t begin, size_t end, int thread)
{
    label_pass *pass = user;
    label_worker *w = &pass->workers[thread];
    const size_t each = sc_voxel_type_bytes(pass->source->type);

    if (pass->as_stored) {
        (void)visit_values(pass, w, pass->batch + begin * each, pass->begin + begin, end - begin);
        return;
    }
    for (size_t block = begin; block < end; block += BLOCK_VOXELS) {
        const size_t count = end - block < BLOCK_VOXELS ? end - block : BLOCK_VOXELS;
        const size_t good = sc_stream_values(pass->stream, pass->batch + block * each, count,
                                             w->values + BLOCK_VOXELS, w->values);

        if (!visit_values(pass, w, (const unsigned char *)w->values, pass->begin + block, good))
            return;
        if (good < count) {
            const size_t bad = pass->begin + block + good;

            w->bad = bad < w->bad ? bad : w->bad;
            return;
        }
    }
}

/* sc_range_fn: as visit_range, but the first RANGE_VOXELS are not of the batch: who gets them reads
 * the next batch, while others look at this one. */
static void read_or_visit(void *user, size_t begin, size_t end, int thread)
{
    label_pass *pass = user;

    if (begin == 0)
        sc_stream_read_ahead(pass->stream);
    else
        visit_range(pass, begin - RANGE_VOXELS, end - RANGE_VOXELS, thread);
}

/* Replace pass->ids by ids of two bytes, since one byte per id no longer suffices. @return
 * SC_ERR_MEMORY; nothing has changed then. */
static sc_status widen_ids(label_pass *pass)
{
    int same[NARROW_LABELS];

    for (int id = 0; id < NARROW_LABELS; id++)
        same[id] = id;
    return sc_ids_map(pass->ctx, pass->wanted, same, sizeof(uint16_t), pass->threads,
                      &pass->id_bytes, &pass->ids);
}

/* Tally the @p count voxels of the batch and set their ids. @return SC_ERR_DATA for the first voxel
 * that is no label, or else for more than SC_LABELS_MAX labels; SC_ERR_MEMORY. */
static sc_status visit_batch(label_pass *pass, size_t count)
{
    size_t bad = SIZE_MAX;

    if (pass->ahead)
        sc_stage_for(pass->ctx, count, pass->threads, RANGE_VOXELS + count, RANGE_VOXELS,
                     read_or_visit, pass);
    else
        sc_stage_for(pass->ctx, count, pass->threads, count, RANGE_VOXELS, visit_range, pass);
    for (int i = 0; i < pass->threads; i++)
        bad = pass->workers[i].bad < bad ? pass->workers[i].bad : bad;
    if (bad != SIZE_MAX)
        return sc_stream_refuse(
            pass->stream,
            pass->batch + (bad - pass->begin) * sc_voxel_type_bytes(pass->source->type), bad);
    if (atomic_load(&pass->set.count) > SC_LABELS_MAX)
        return sc_fail(
            pass->ctx, SC_ERR_DATA,
            "%s: holds more than %d different labels, expected at most so many; read a part of "
            "it (--set volume.box=...), or merge labels where it was made; a grey-value "
            "image, such as CT, is shown with a segmentation: --set image.path=FILE",
            pass->path, SC_LABELS_MAX - 1);
    if (!atomic_load(&pass->too_wide))
        return SC_OK;
    SC_PASS(widen_ids(pass));
    atomic_store(&pass->too_wide, false);
    pass->recounts = true;
    sc_parallel_for(pass->threads, count, RANGE_VOXELS, visit_range, pass);
    pass->recounts = false;
    return SC_OK;
}

/* Add what all threads have tallied to what the first one has; the box of a label without voxels is
 * low > high. */
static void add_up(label_pass *pass)
{
    label_worker *sum = &pass->workers[0];

    for (int id = 0; id < atomic_load(&pass->set.count); id++) {
        sc_label_tally *to = &sum->tallies[id];

        for (int i = 0; i < 3 && !to->voxels; i++) {
            to->low[i] = pass->source->part[i];
            to->high[i] = -1;
        }
        for (int i = 1; i < pass->threads; i++) {
            const sc_label_tally *from = &pass->workers[i].tallies[id];

            if (from->voxels)
                sc_tally_add(to, from->low, from->high, from->voxels);
            sum->runs[id] += pass->workers[i].runs[id];
        }
    }
}

/* Read all voxels into the set, the tallies, the runs and, if kept, the ids of @p pass.
 * Background gets the first id 0, also if no voxel has it. @return the errors of the stream and
 * of visit_batch. */
static sc_status visit_voxels(label_pass *pass)
{
    SC_OWN(sc_stream_close_at) sc_voxel_stream *stream = NULL;

    (void)id_of(&pass->set, 0);
    SC_PASS(sc_stream_open(pass->ctx, pass->path, pass->source, &stream));
    pass->stream = stream;
    pass->ahead = pass->threads > 1;
    sc_stage_begin(pass->ctx, "reading", 0, pass->voxels);
    for (size_t count; pass->begin < pass->voxels; pass->begin += count) {
        const void *raw;

        SC_PASS(sc_stream_next_raw(stream, &raw, &count));
        pass->batch = raw;
        SC_PASS(visit_batch(pass, count));
    }
    add_up(pass);
    return sc_stream_finish(stream);
}

/* For qsort of sc_label: rising by value. */
static int by_value(const void *a, const void *b)
{
    const int64_t x = ((const sc_label *)a)->value, y = ((const sc_label *)b)->value;

    return (x > y) - (x < y);
}

/* Make the labels in their final order: labels and label_count of @p volume, and its tallies, if it
 * gets no ids. @param final
 * [SC_LABELS_MAX], receives the dense id of each first id. @return SC_ERR_MEMORY. */
static sc_status order_labels(label_pass *pass, sc_volume *volume, int *final)
{
    value_set *set = &pass->set;
    const int count = atomic_load(&set->count);
    sc_label *labels;

    SC_PASS(SC_ZALLOC(pass->ctx, (size_t)count, &labels));
    volume->labels = labels;
    volume->label_count = count;
    if (!pass->keep_ids)
        SC_PASS(SC_ALLOC(pass->ctx, (size_t)count, &volume->tallies));
    for (size_t slot = 0; slot < SLOTS; slot++) {
        const int32_t id = atomic_load_explicit(&set->ids[slot], memory_order_relaxed);

        if (id >= 0)
            labels[id] = sc_label_new(set->values[slot]);
    }
    qsort(labels + 1, (size_t)count - 1, sizeof *labels, by_value);
    for (int i = 0; i < count; i++) {
        const int32_t first = id_of(set, labels[i].value);

        final[first] = i;
        if (volume->tallies)
            volume->tallies[i] = pass->workers[0].tallies[first];
    }
    return SC_OK;
}

/* Turn the first ids in pass->ids, which is not NULL, into dense ids by @p final (of
 * order_labels). */
static sc_status renumber(label_pass *pass, int count, const int *final)
{
    bool in_order = true;

    for (int i = 0; i < count; i++)
        in_order = in_order && final[i] == i;
    return in_order ? SC_OK
                    : sc_ids_map(pass->ctx, pass->wanted, final, pass->id_bytes, pass->threads,
                                 &pass->id_bytes, &pass->ids);
}

/* The marks of a grey-value image: more labels than this, and shorter runs, in voxels, than this.
 */
enum { GREY_LABELS = 32, GREY_RUN_VOXELS = 2 };

/* Does the volume look like a grey-value image? Equal values seldom lie side by side in noise.
 * Neither background nor the commonest other value counts: a grey-value image is often padded
 * with a value of its own. */
static bool looks_grey(const label_pass *pass, int count)
{
    const label_worker *sum = &pass->workers[0];
    uint64_t voxels = 0, runs = 0;
    int commonest = 1;

    if (count <= GREY_LABELS)
        return false;
    for (int id = 2; id < count; id++) {
        if (sum->tallies[id].voxels > sum->tallies[commonest].voxels)
            commonest = id;
    }
    for (int id = 1; id < count; id++) {
        voxels += id == commonest ? 0 : sum->tallies[id].voxels;
        runs += id == commonest ? 0 : sum->runs[id];
    }
    return voxels < GREY_RUN_VOXELS * runs;
}

/* Note and warn if the volume looks like a grey-value image, or else if it has negative values.
 * @p volume has its labels in their final order. */
static void warn_of_grey_values(const label_pass *pass, sc_volume *volume)
{
    const int64_t lowest = volume->label_count > 1 ? volume->labels[1].value : 0;
    const int64_t highest = volume->labels[volume->label_count - 1].value;

    volume->looks_grey = looks_grey(pass, volume->label_count);
    if (volume->looks_grey)
        sc_warn(pass->ctx,
                "%s: looks like a grey-value image, not like a segmentation: %d different values "
                "from %lld to %lld, and equal ones seldom lie side by side",
                pass->path, volume->label_count - 1, (long long)(lowest < 0 ? lowest : 0),
                (long long)highest);
    else if (lowest < 0)
        sc_warn(pass->ctx,
                "%s: holds negative values, down to %lld, which segmentations seldom have; they "
                "are shown as tissues of their own",
                pass->path, (long long)lowest);
}

/* Allocate an empty set. @return SC_ERR_MEMORY; what was allocated clear_pass frees. */
static sc_status begin_set(const sc_ctx *ctx, value_set *set)
{
    SC_PASS(SC_ALLOC(ctx, SLOTS, &set->values));
    SC_PASS(SC_ALLOC(ctx, SLOTS, &set->ids));
    for (size_t slot = 0; slot < SLOTS; slot++)
        atomic_init(&set->ids[slot], SLOT_FREE);
    return SC_OK;
}

static void end_set(value_set *set)
{
    sc_free(set->values);
    sc_free(set->ids);
}

/* List the values that occur only outside of the part that is wanted, in rising order. @param
 * volume has its labels. */
static sc_status list_outside(const label_pass *pass, sc_volume *volume)
{
    const value_set *set = &pass->outside;
    sc_label_table *table = &volume->outside;

    for (size_t slot = 0; set->values && slot < SLOTS; slot++) {
        const sc_label label = {.value = set->values[slot], .opacity = -1};

        if (set->ids[slot] >= 0 && !sc_volume_label(volume, label.value))
            SC_PASS(sc_label_table_add(pass->ctx, table, &label));
    }
    if (table->count)
        qsort(table->rows, table->count, sizeof *table->rows, by_value);
    return SC_OK;
}

/* Allocate what the threads work on. @return SC_ERR_MEMORY; what was allocated clear_pass frees. */
static sc_status begin_workers(label_pass *pass)
{
    SC_PASS(SC_ZALLOC(pass->ctx, (size_t)pass->threads, &pass->workers));
    for (int i = 0; i < pass->threads; i++) {
        label_worker *w = &pass->workers[i];

        w->bad = SIZE_MAX;
        SC_PASS(SC_ZALLOC(pass->ctx, SC_LABELS_MAX, &w->tallies));
        SC_PASS(SC_ZALLOC(pass->ctx, SC_LABELS_MAX, &w->runs));
        SC_PASS(sc_alloc(pass->ctx, BLOCK_VOXELS, 2 * sizeof *w->values, &w->values));
    }
    return SC_OK;
}

/* For SC_OWN. */
static void clear_pass(label_pass *pass)
{
    for (int i = 0; i < pass->threads && pass->workers; i++) {
        sc_free(pass->workers[i].tallies);
        sc_free(pass->workers[i].runs);
        sc_free(pass->workers[i].values);
    }
    sc_free(pass->workers);
    sc_free(pass->ids);
    end_set(&pass->set);
    end_set(&pass->outside);
}

/* @return how many threads look for labels: as many as may, if there is enough for each. */
static int threads_for(const sc_ctx *ctx, size_t voxels)
{
    const size_t useful = voxels / WORKER_VOXELS + 1;
    const size_t threads = ctx->threads > 1 ? (size_t)ctx->threads : 1;

    return (int)(threads < useful ? threads : useful);
}

sc_status sc_read_labels(const sc_ctx *ctx, const char *path, const sc_source *source,
                         bool keep_ids, sc_volume *volume)
{
    SC_OWN(clear_pass)
    label_pass pass = {.ctx = ctx,
                       .path = path,
                       .source = source,
                       .voxels = sc_source_voxels(source),
                       .wanted = (size_t)source->part[0] * (size_t)source->part[1] *
                                 (size_t)source->part[2],
                       .threads = threads_for(ctx, sc_source_voxels(source)),
                       .keep_ids = keep_ids,
                       .id_bytes = 1,
                       .as_stored = sc_stream_is_plain(source)};
    SC_OWN(sc_volume_clear)
    sc_volume found = {.size = {source->part[0], source->part[1], source->part[2]}};
    SC_OWN(sc_free_at) int *final = NULL;

    SC_PASS(begin_set(ctx, &pass.set));
    if (pass.wanted < pass.voxels)
        SC_PASS(begin_set(ctx, &pass.outside));
    SC_PASS(SC_ALLOC(ctx, SC_LABELS_MAX, &final));
    SC_PASS(begin_workers(&pass));
    if (keep_ids)
        SC_PASS(sc_zalloc(ctx, pass.wanted, 1, &pass.ids));
    SC_PASS(visit_voxels(&pass));
    SC_PASS(order_labels(&pass, &found, final));
    SC_PASS(list_outside(&pass, &found));
    warn_of_grey_values(&pass, &found);
    if (keep_ids)
        SC_PASS(renumber(&pass, found.label_count, final));
    found.label_bytes = found.label_count <= NARROW_LABELS ? 1 : 2;
    SC_HAND_OVER(pass.ids, &found.ids);
    SC_HAND_OVER(found, volume);
    return SC_OK;
}
