/* SPDX-License-Identifier: BSD-3-Clause */
/* Reads the voxels of a directory of masks. As many masks are read side by side as there are
 * threads, each once: what a mask covers is kept as bits until its size is known. */
#include "source.h"

enum { AT_A_TIME = 8 /* most masks that are read side by side: each takes a bit for a voxel */ };

/* One mask while it is read: by one thread, beside others. */
typedef struct mask_reading {
    sc_source source;
    uint64_t *bits; /* which voxels of the part it covers; owned */
    int64_t *block; /* [2 * SC_STREAM_BLOCK]: values, and room; owned */
    int64_t value;  /* of its voxels; 0: none so far */
    sc_status status;
} mask_reading;

/* The masks while they are read. Owns its arrays: clear_painting. */
typedef struct painting {
    const sc_ctx *ctx;
    const char *path;
    const sc_overlap_rule *rule;
    sc_source *source;
    size_t voxels;          /* of the part that is wanted */
    int bytes;              /* of a label: 1 or 2 */
    void *labels;           /* [voxels] of so many bytes: the labels found so far */
    mask_reading *readings; /* [threads] */
    size_t threads;         /* so many masks are read at a time */
    size_t *wanted;         /* [masks]: those that are not left out, in their order */
    size_t first;           /* which of them is that of the first reading */
    uint64_t *twice;        /* bits: what more than one mask covers */
    uint64_t *lost; /* [mask_count + 1]: of a mask, the voxels of each earlier one that it takes, or
                       leaves to it */
} painting;

/* @return how many voxels the file of a mask has. */
static size_t voxels_of(const sc_mask *mask)
{
    return (size_t)mask->size[0] * (size_t)mask->size[1] * (size_t)mask->size[2];
}

static size_t words_of(size_t voxels)
{
    return (voxels + 63) / 64;
}

/* Set the bits [begin, end). */
static void set_bits(uint64_t *bits, size_t begin, size_t end)
{
    for (size_t next; begin < end; begin = next) {
        const size_t word = begin / 64;
        uint64_t set = ~(uint64_t)0 << begin % 64;

        next = (word + 1) * 64;
        if (next > end) {
            set &= ~(uint64_t)0 >> (next - end);
            next = end;
        }
        bits[word] |= set;
    }
}

/* Note that a mask which is stored along other axes, or has not all the voxels, covers the voxels
 * [begin, end) of its file, as far as they are wanted. */
static void cover_placed(const painting *p, const sc_mask *mask, uint64_t *bits, size_t begin,
                         size_t end)
{
    const size_t nx = (size_t)mask->size[0], ny = (size_t)mask->size[1];
    const int *low = p->source->low, *part = p->source->part;

    for (size_t voxel = begin; voxel < end; voxel++) {
        const int stored[3] = {(int)(voxel % nx), (int)(voxel / nx % ny), (int)(voxel / nx / ny)};
        int at[3];
        size_t bit;

        for (int i = 0; i < 3; i++) {
            const int a = mask->axis[i];

            at[a] =
                (mask->flip[i] ? mask->size[i] - 1 - stored[i] : stored[i]) + mask->low[a] - low[a];
        }
        if (at[0] < 0 || at[0] >= part[0] || at[1] < 0 || at[1] >= part[1] || at[2] < 0 ||
            at[2] >= part[2])
            continue;
        bit = ((size_t)at[2] * (size_t)part[1] + (size_t)at[1]) * (size_t)part[0] + (size_t)at[0];
        bits[bit / 64] |= (uint64_t)1 << bit % 64;
    }
}

/* Note that a mask covers the voxels [begin, end) of the source, as far as they are wanted. */
static void cover_rows(const painting *p, uint64_t *bits, size_t begin, size_t end)
{
    const int *size = p->source->size, *low = p->source->low, *part = p->source->part;
    const size_t nx = (size_t)size[0], ny = (size_t)size[1];

    if (!memcmp(size, part, sizeof p->source->size)) {
        set_bits(bits, begin, end);
        return;
    }
    for (size_t row = begin / nx; row * nx < end; row++) {
        const int64_t y = (int64_t)(row % ny) - low[1], z = (int64_t)(row / ny) - low[2];
        const int64_t from = begin > row * nx ? (int64_t)(begin - row * nx) : 0;
        const int64_t to = end < (row + 1) * nx ? (int64_t)(end - row * nx) : (int64_t)nx;
        const int64_t a = (from > low[0] ? from : low[0]) - low[0];
        const int64_t b = (to < low[0] + part[0] ? to : low[0] + part[0]) - low[0];

        if (a < b && y >= 0 && y < part[1] && z >= 0 && z < part[2]) {
            const size_t at = ((size_t)z * (size_t)part[1] + (size_t)y) * (size_t)part[0];

            set_bits(bits, at + (size_t)a, at + (size_t)b);
        }
    }
}

/* Note that a mask covers the voxels [begin, end) of its file, which has all voxels of the source
 * in their order or others. */
static void cover(const painting *p, sc_mask *mask, uint64_t *bits, size_t begin, size_t end)
{
    mask->voxels += end - begin;
    if (sc_mask_is_placed(p->source, mask))
        cover_placed(p, mask, bits, begin, end);
    else
        cover_rows(p, bits, begin, end);
}

/* Add @p count values of a mask of integers of type @p type, the first of which is voxel @p begin.
 * @return SC_ERR_DATA, logged, for a second label. */
static sc_status add_values(const painting *p, const sc_ctx *ctx, sc_mask *mask, mask_reading *r,
                            sc_voxel_type type, const void *values, size_t begin, size_t count)
{
    for (int i = 0, end; i < (int)count; i = end) {
        int64_t value;

        end = sc_run_end(type, values, i, (int)count, &value);
        if (!value)
            continue;
        if (value != r->value && r->value)
            return sc_fail(
                ctx, SC_ERR_DATA,
                "%s: holds the labels %lld and %lld, expected the mask of one tissue, as "
                "the files of a directory are; give the path of the file to show it "
                "alone, or move it out of the directory; if masks are soft, say from which share "
                "of "
                "the largest value on a voxel is tissue, such as --set volume.threshold=50%%",
                mask->file, (long long)r->value, (long long)value);
        r->value = value;
        cover(p, mask, r->bits, begin + (size_t)i, begin + (size_t)end);
    }
    return SC_OK;
}

/* Add a batch of @p count voxels as they are stored at @p raw, the first of which is voxel @p
 * begin.
 * @return also SC_ERR_DATA, logged, for a voxel that is no label. */
static sc_status add_batch(const painting *p, const sc_ctx *ctx, sc_mask *mask, mask_reading *r,
                           sc_voxel_stream *stream, const unsigned char *raw, size_t begin,
                           size_t count)
{
    const size_t each = sc_voxel_type_bytes(r->source.type);
    sc_status status = SC_OK;

    if (sc_stream_is_plain(&r->source))
        return add_values(p, ctx, mask, r, r->source.type, raw, begin, count);
    for (size_t i = 0, some; i < count && status == SC_OK; i += some) {
        size_t good;

        some = count - i < SC_STREAM_BLOCK ? count - i : SC_STREAM_BLOCK;
        good = sc_stream_values(stream, raw + i * each, some, r->block + SC_STREAM_BLOCK, r->block);
        status = add_values(p, ctx, mask, r, SC_VOXEL_INT64, r->block, begin + i, good);
        if (status == SC_OK && good < some)
            status = sc_stream_refuse(stream, raw + (i + good) * each, begin + i + good);
    }
    return status;
}

/* Go through the values of a soft mask: find the largest, *most, or if @p covers cover the voxels
 * from
 * @p least on. Numbers that are none belong to nothing. */
static sc_status pass_soft(const painting *p, const sc_ctx *ctx, sc_mask *mask, mask_reading *r,
                           bool covers, double least, double *most)
{
    const size_t voxels = voxels_of(mask);
    double *values = (double *)(void *)r->block; /* as wide as its numbers */
    SC_OWN(sc_stream_close_at) sc_voxel_stream *stream = NULL;

    SC_PASS(sc_stream_open(ctx, mask->file, &r->source, &stream));
    for (size_t begin = 0, count; begin < voxels; begin += count) {
        count = voxels - begin < SC_STREAM_BLOCK ? voxels - begin : SC_STREAM_BLOCK;
        SC_PASS(sc_stream_next_numbers(stream, count, values));
        for (size_t i = 0, end; i < count; i = end) {
            end = i + 1;
            if (!covers)
                *most = isfinite(values[i]) && values[i] > *most ? values[i] : *most;
            if (!covers || !(values[i] >= least))
                continue;
            while (end < count && values[end] >= least)
                end++;
            cover(p, mask, r->bits, begin + i, begin + end);
        }
    }
    return sc_stream_finish(stream);
}

/* Read a soft mask, in two passes. */
static sc_status read_soft(const painting *p, const sc_ctx *ctx, sc_mask *mask, mask_reading *r)
{
    double most = 0;

    SC_PASS(pass_soft(p, ctx, mask, r, false, 0, &most));
    if (most > 0)
        SC_PASS(pass_soft(p, ctx, mask, r, true, p->source->mask_files.threshold * most, &most));
    sc_stage_add(p->ctx, voxels_of(mask));
    return SC_OK;
}

/* Read a mask of labels, in one pass. */
static sc_status read_labels(const painting *p, const sc_ctx *ctx, sc_mask *mask, mask_reading *r)
{
    const size_t voxels = sc_source_voxels(&r->source);
    SC_OWN(sc_stream_close_at) sc_voxel_stream *stream = NULL;

    SC_PASS(sc_stream_open(ctx, mask->file, &r->source, &stream));
    for (size_t begin = 0, count; begin < voxels; begin += count) {
        const void *raw;

        SC_PASS(sc_stream_next_raw(stream, &raw, &count));
        SC_PASS(add_batch(p, ctx, mask, r, stream, raw, begin, count));
        sc_stage_add(p->ctx, count);
    }
    return sc_stream_finish(stream);
}

/* Read mask @p i, whose header has been read, into the bits of @p r, and count its voxels; the
 * source is closed. Errors are logged to @p ctx. Threads: any, each with a reading of its own. */
static sc_status read_mask(const painting *p, const sc_ctx *ctx, size_t i, mask_reading *r)
{
    sc_mask *mask = &p->source->mask_files.masks[i];
    sc_status status;

    memset(r->bits, 0, words_of(p->voxels) * sizeof *r->bits);
    mask->voxels = 0;
    r->value = 0;
    status = (p->source->mask_files.threshold > 0 ? read_soft : read_labels)(p, ctx, mask, r);
    sc_source_clear(&r->source);
    return status;
}

/* Read the header of mask @p i, and its voxels if a library reads both together. One thread: such
 * libraries keep global state. */
static sc_status open_mask(const painting *p, size_t i, mask_reading *r)
{
    const sc_mask *mask = &p->source->mask_files.masks[i];
    sc_ctx errors = *p->ctx;

    errors.level = SC_LOG_ERROR; /* its warnings were given when the headers were read */
    r->source = (sc_source){.slope = 1};
    SC_PASS(sc_open_mask(&errors, mask->file, false, &r->source));
    SC_PASS(sc_mask_place(p->ctx, p->source, i, &r->source)); /* it may have changed */
    return SC_OK;
}

/* sc_range_fn: read the masks of the readings [begin, end), without messages. */
static void read_some(void *user, size_t begin, size_t end, int thread)
{
    painting *p = user;
    const sc_ctx quiet = sc_quiet(p->ctx);

    for (size_t k = begin; k < end; k++)
        p->readings[k].status = read_mask(p, &quiet, p->wanted[p->first + k], &p->readings[k]);
}

/* Read @p count of the wanted masks, from p->first on, side by side. One that cannot be read is
 * read once more, for the message. */
static sc_status read_masks(painting *p, size_t count)
{
    sc_ctx errors = *p->ctx;

    errors.level = SC_LOG_ERROR;
    for (size_t k = 0; k < count; k++)
        SC_PASS(open_mask(p, p->wanted[p->first + k], &p->readings[k]));
    sc_parallel_for((int)p->threads, count, 1, read_some, p);
    for (size_t k = 0; k < count; k++) {
        mask_reading *r = &p->readings[k];

        if (r->status == SC_OK)
            continue;
        SC_PASS(open_mask(p, p->wanted[p->first + k], r));
        SC_PASS(read_mask(p, &errors, p->wanted[p->first + k], r));
    }
    return SC_OK;
}

/* @return whether mask @p i has what it and mask @p other cover. */
static bool wins_over(const painting *p, size_t i, size_t other)
{
    const sc_mask *masks = p->source->mask_files.masks;

    return sc_overlap_wins(p->rule, (sc_contender){masks[i].voxels, i, i},
                           (sc_contender){masks[other].voxels, other, other});
}

/* Give the voxels of mask @p i, by its bits, its label, but for those that an earlier one keeps. */
static sc_status paint(painting *p, size_t i, const uint64_t *mask)
{
    const size_t words = words_of(p->voxels);
    uint8_t *narrow = p->bytes == 1 ? p->labels : NULL;
    uint16_t *wide = p->bytes == 1 ? NULL : p->labels;

    memset(p->lost, 0, (i + 1) * sizeof *p->lost);
    for (size_t word = 0; word < words; word++) {
        for (uint64_t bits = mask[word]; bits; bits &= bits - 1) {
            const size_t at = word * 64 + (size_t)__builtin_ctzll(bits);
            const size_t earlier = narrow ? narrow[at] : wide[at];

            if (earlier) {
                p->twice[word] |= bits & -bits;
                p->lost[earlier]++;
                if (!wins_over(p, i, earlier - 1))
                    continue;
            }
            if (narrow)
                narrow[at] = (uint8_t)(i + 1);
            else
                wide[at] = (uint16_t)(i + 1);
        }
    }
    for (size_t k = 0; k < i; k++) {
        const bool wins = wins_over(p, i, k);

        SC_PASS(sc_overlap_add(p->ctx, wins ? i : k, wins ? k : i, p->lost[k + 1],
                               &p->source->overlaps));
    }
    return SC_OK;
}

/* Tell which masks are empty, and what overlaps. */
static sc_status report(painting *p)
{
    const sc_label *rows = p->source->table.rows;
    SC_OWN(sc_text_clear) sc_text names = {0};
    size_t empty = 0;

    for (size_t i = 0; i < words_of(p->voxels); i++)
        p->source->overlaps.voxels += (uint64_t)__builtin_popcountll(p->twice[i]);
    for (size_t i = 0; i < p->source->mask_files.count; i++) {
        p->source->overlaps.covers[i] = p->source->mask_files.masks[i].voxels > 0;
        if (!p->rule->left_out[i] && p->source->mask_files.masks[i].voxels == 0 && empty++ < 8)
            SC_PASS(sc_text_add(p->ctx, &names, "%s%s", empty > 1 ? ", " : "", rows[i].name));
    }
    if (empty)
        sc_info(p->ctx, "%s: %zu of %zu masks %s empty: %s%s", p->path, empty,
                p->source->mask_files.count, empty == 1 ? "is" : "are", names.data,
                empty > 8 ? ", ..." : "");
    return SC_OK;
}

/* Allocate what the threads work on, and share. */
static sc_status alloc_all(painting *p)
{
    SC_PASS(SC_ZALLOC(p->ctx, p->threads, &p->readings));
    for (size_t k = 0; k < p->threads; k++) {
        SC_PASS(SC_ALLOC(p->ctx, words_of(p->voxels), &p->readings[k].bits));
        SC_PASS(SC_ALLOC(p->ctx, 2 * SC_STREAM_BLOCK, &p->readings[k].block));
    }
    SC_PASS(sc_zalloc(p->ctx, p->voxels, (size_t)p->bytes, &p->labels));
    SC_PASS(SC_ZALLOC(p->ctx, words_of(p->voxels), &p->twice));
    return SC_ALLOC(p->ctx, p->source->mask_files.count + 1, &p->lost);
}

/* For SC_OWN. */
static void clear_painting(painting *p)
{
    for (size_t k = 0; k < p->threads && p->readings; k++) {
        sc_source_clear(&p->readings[k].source);
        sc_free(p->readings[k].bits);
        sc_free(p->readings[k].block);
    }
    sc_free(p->readings);
    sc_free(p->labels);
    sc_free(p->twice);
    sc_free(p->lost);
    sc_free(p->wanted);
}

/* @return how many masks are read at a time. */
static size_t threads_for(const sc_ctx *ctx, size_t masks)
{
    const size_t most = masks < AT_A_TIME ? masks : AT_A_TIME;

    return ctx->threads < 1 ? 1 : (size_t)ctx->threads < most ? (size_t)ctx->threads : most;
}

sc_status sc_load_masks(const sc_ctx *ctx, const char *path, const sc_overlap_rule *rule,
                        sc_source *source)
{
    const int *part = source->part;
    size_t masks = 0, voxels_of_masks = 0;
    SC_OWN(clear_painting)
    painting p = {.ctx = ctx,
                  .path = path,
                  .rule = rule,
                  .source = source,
                  .voxels = (size_t)part[0] * (size_t)part[1] * (size_t)part[2],
                  .bytes = source->mask_files.count > UINT8_MAX ? 2 : 1};

    SC_PASS(SC_ALLOC(ctx, source->mask_files.count, &p.wanted));
    for (size_t i = 0; i < source->mask_files.count; i++) {
        if (!rule->left_out[i])
            voxels_of_masks += voxels_of(&source->mask_files.masks[p.wanted[masks++] = i]);
    }
    p.threads = threads_for(ctx, masks);
    SC_PASS(sc_volume_memory_check(ctx, path, part,
                                   (double)p.voxels * (p.bytes + 0.125 * (double)(1 + p.threads))));
    SC_PASS(sc_overlap_count_begin(ctx, source->mask_files.count, &source->overlaps));
    SC_PASS(alloc_all(&p));
    sc_stage_begin(ctx, "reading", 0, voxels_of_masks);
    for (size_t count; p.first < masks; p.first += count) {
        count = masks - p.first < p.threads ? masks - p.first : p.threads;
        SC_PASS(read_masks(&p, count));
        for (size_t k = 0; k < count; k++)
            SC_PASS(paint(&p, p.wanted[p.first + k], p.readings[k].bits));
    }
    SC_PASS(report(&p));
    sc_source_set_labels(source, p.bytes == 1 ? SC_VOXEL_UINT8 : SC_VOXEL_UINT16, p.labels);
    p.labels = NULL;
    return SC_OK;
}
