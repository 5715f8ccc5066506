/* SPDX-License-Identifier: BSD-3-Clause */
/* Voxels at the borders between labels, block by block: how many of a sample would get another
 * label, and new labels for all of them. */
#include "borders.h"

enum {
    CHUNK_VOXELS = 1 << 13, /* that a thread takes at once, if that is a block or more */
    MOST_SIDE = 64 + 2,     /* of a block and the voxels beside it */
    ROUND_SAMPLES = 2       /* blocks that are looked at together, as a multiple of the sample */
};

/* What the threads share. The arrays are owned, but for has_border. */
typedef struct border_work {
    const drawn_view *view;
    const border_method *method;
    size_t blocks[3];      /* along each axis */
    size_t chunk;          /* of blocks that a thread takes at once */
    border_block *scratch; /* [threads] */
    int threads;
    size_t *sample;        /* blocks to measure, or NULL */
    size_t first_looked;   /* number of the first block that look_for_borders looks at */
    uint8_t *has_border;   /* of the team: may each block that is looked at be in the sample? */
    uint64_t (*counts)[3]; /* [threads]: voxels at borders, those that change, and flat ones */
    void *out;             /* ids of the result, or NULL */
} border_work;

/* ---- blocks ---- */

/* Fetch the ids of a block and those beside it. */
static void fetch_block(const border_work *w, border_block *b)
{
    const drawn_view *view = w->view;
    const int *edge = w->method->edge;
    const int last = edge[0] + 1;
    size_t along_x[MOST_SIDE];
    uint16_t *to = b->ids;
    bool is_run; /* do the voxels of a row follow each other in memory? */

    for (int x = 0; x < edge[0] + 2; x++)
        along_x[x] = border_offset(view, 0, (ptrdiff_t)b->low[0] + x - 1);
    is_run = along_x[last - 1] - along_x[1] + 1 == (size_t)edge[0];
    for (int z = 0; z < edge[2] + 2; z++) {
        const size_t slice = border_offset(view, 2, (ptrdiff_t)b->low[2] + z - 1);

        for (int y = 0; y < edge[1] + 2; y++) {
            const size_t row = slice + border_offset(view, 1, (ptrdiff_t)b->low[1] + y - 1);

            if (is_run) {
                to[0] = (uint16_t)id_of_voxel(view->v, row + along_x[0]);
                read_ids(view->v, row + along_x[1], edge[0], to + 1);
                to[last] = (uint16_t)id_of_voxel(view->v, row + along_x[last]);
            } else {
                for (int x = 0; x <= last; x++)
                    to[x] = (uint16_t)id_of_voxel(view->v, row + along_x[x]);
            }
            to += edge[0] + 2;
        }
    }
}

/* @return the entry of a label of the block, which is added if it is new; BORDER_LABELS: no room.
 */
static int entry_of(border_block *b, uint16_t label)
{
    int i = 0;

    while (i < b->label_count && b->labels[i] != label)
        i++;
    if (i == b->label_count && i < BORDER_LABELS)
        b->labels[b->label_count++] = label;
    return i;
}

/* Mark the voxels of a row of @p count that lie at a border. @param row_ids, slice_ids how far the
 * next row and the next slice lie. @return whether there are any. */
static bool mark_row(const uint16_t *row, int count, int row_ids, int slice_ids,
                     uint16_t *restrict marks)
{
    /* nothing is written through these: told so by restrict, compilers use vector instructions */
    const uint16_t *restrict below = row - slice_ids, *restrict above = row + slice_ids,
                             *restrict low = row - row_ids, *restrict high = row + row_ids;
    uint16_t any = 0;

    for (int x = 0; x < count; x++)
        marks[x] = (uint16_t)((row[x] ^ row[x - 1]) | (row[x] ^ row[x + 1]) | (row[x] ^ low[x]) |
                              (row[x] ^ high[x]) | (row[x] ^ below[x]) | (row[x] ^ above[x]));
    for (int x = 0; x < count; x++)
        any |= marks[x];
    return any != 0;
}

/* Add a voxel that lies at a border. @param id its own. @return false if the block holds too many
 * labels. */
static bool add_voxel(border_block *b, const int at[3], const uint16_t *id, const int around[6])
{
    border_voxel voxel = {.at = {(uint8_t)at[0], (uint8_t)at[1], (uint8_t)at[2]}};

    voxel.own = (uint8_t)entry_of(b, *id);
    for (int i = 0; i < 6; i++) {
        const int entry = entry_of(b, id[around[i]]);

        if (entry == BORDER_LABELS)
            return false;
        voxel.others[i] = (uint8_t)entry;
    }
    voxel.chosen = voxel.own;
    b->voxels[b->voxel_count++] = voxel;
    return voxel.own < BORDER_LABELS;
}

/* Add the voxels of a row that lie at borders. @param begin place of its first of @p count voxels
 * in the block. @return false if the block holds too many labels. */
static bool add_row(border_block *b, const int begin[3], int count, const uint16_t *row,
                    const int around[6])
{
    uint16_t marks[MOST_SIDE];
    bool fits = true;

    if (!mark_row(row, count, around[3], around[5], marks))
        return true;
    for (int x = 0; x < count && fits; x++)
        fits = !marks[x] || add_voxel(b, (int[3]){x, begin[1], begin[2]}, row + x, around);
    return fits;
}

/* Find the voxels at borders of a block whose ids were fetched, and their labels. There are none
 * where too many labels meet. */
static void find_voxels(const border_work *w, border_block *b)
{
    const int row_ids = w->method->edge[0] + 2, slice_ids = row_ids * (w->method->edge[1] + 2);
    const int around[6] = {-1, 1, -row_ids, row_ids, -slice_ids, slice_ids};
    bool fits = true;
    int end[3];

    b->voxel_count = b->label_count = 0;
    for (int i = 0; i < 3; i++)
        end[i] = (int)fmin(w->method->edge[i], (double)((size_t)w->view->size[i] - b->low[i]));
    for (int z = 0; z < end[2] && fits; z++) {
        for (int y = 0; y < end[1] && fits; y++) {
            const uint16_t *row = b->ids + (z + 1) * slice_ids + (y + 1) * row_ids + 1;

            fits = add_row(b, (int[3]){0, y, z}, end[0], row, around);
        }
    }
    if (!fits)
        b->voxel_count = 0;
}

/* Find the voxels at borders of block @p n. @return whether there are any. */
static bool open_block(const border_work *w, size_t n, border_block *b)
{
    const border_method *method = w->method;
    const size_t at[3] = {n % w->blocks[0], n / w->blocks[0] % w->blocks[1],
                          n / w->blocks[0] / w->blocks[1]};

    for (int i = 0; i < 3; i++)
        b->low[i] = at[i] * (size_t)method->edge[i];
    if (method->may_hold && !method->may_hold(method->self, b->low))
        return false;
    fetch_block(w, b);
    find_voxels(w, b);
    return b->voxel_count > 0;
}

/* Add the voxels of a block to the counts of a thread. */
static void count_voxels(const border_block *b, uint64_t counts[3])
{
    counts[0] += (uint64_t)b->voxel_count;
    for (int i = 0; i < b->voxel_count; i++) {
        counts[1] += b->voxels[i].chosen != b->voxels[i].own;
        counts[2] += b->voxels[i].is_flat;
    }
}

/* Write the labels that were chosen for the voxels of a block to the result. */
static void write_voxels(const border_work *w, const border_block *b)
{
    const drawn_view *view = w->view;

    for (int i = 0; i < b->voxel_count; i++) {
        const border_voxel *voxel = &b->voxels[i];
        const size_t at = view->offset[0][b->low[0] + voxel->at[0]] +
                          view->offset[1][b->low[1] + voxel->at[1]] +
                          view->offset[2][b->low[2] + voxel->at[2]];

        if (view->v->label_bytes == 1)
            ((uint8_t *)w->out)[at] = (uint8_t)b->labels[voxel->chosen];
        else
            ((uint16_t *)w->out)[at] = b->labels[voxel->chosen];
    }
}

/* Do all blocks of [begin, end), or those of the sample; an sc_range_fn on border_work. */
static void do_blocks(void *user, size_t begin, size_t end, int thread)
{
    const border_work *w = user;
    border_block *b = &w->scratch[thread];

    for (size_t n = begin; n < end; n++) {
        if (!open_block(w, w->sample ? w->sample[n] : n, b))
            continue;
        w->method->choose(w->method->self, b, thread);
        count_voxels(b, w->counts[thread]);
        if (w->out)
            write_voxels(w, b);
    }
}

/* ---- the sample ---- */

/* @return the block that is looked at as number @p n: in steps of the golden ratio, so that any
 * first few lie all over the volume. */
static size_t looked_at(const border_work *w, size_t n)
{
    const size_t all = w->blocks[0] * w->blocks[1] * w->blocks[2];

    return (size_t)(fmod((double)n * 0.6180339887498949, 1) * (double)all);
}

/* Note which of the blocks that are looked at, from first_looked on, may be in the sample; an
 * sc_range_fn on border_work. */
static void look_for_borders(void *user, size_t begin, size_t end, int thread)
{
    const border_work *w = user;
    const border_method *method = w->method;
    border_block *b = &w->scratch[thread];

    for (size_t n = w->first_looked + begin; n < w->first_looked + end; n++) {
        w->has_border[n] = open_block(w, looked_at(w, n), b) &&
                           (!method->is_sampled || method->is_sampled(method->self, b, thread));
    }
}

/* Allocate what the threads work with. @return SC_ERR_MEMORY. */
static sc_status make_work(const sc_ctx *ctx, const drawn_view *view, const border_method *method,
                           int threads, border_work *w)
{
    size_t voxels = 1, ids = 1; /* of a block */
    void *block;
    sc_status status;

    *w = (border_work){.view = view, .method = method, .threads = threads};
    for (int i = 0; i < 3; i++) {
        const size_t edge = (size_t)method->edge[i];

        w->blocks[i] = ((size_t)view->size[i] + edge - 1) / edge;
        voxels *= edge;
        ids *= edge + 2;
    }
    w->chunk = voxels < CHUNK_VOXELS ? CHUNK_VOXELS / voxels : 1;
    SC_TRY(sc_zalloc(ctx, (size_t)threads, sizeof *w->counts, &block));
    w->counts = block;
    SC_TRY(sc_zalloc(ctx, (size_t)threads, sizeof *w->scratch, &block));
    w->scratch = block;
    for (int t = 0; t < threads; t++) {
        SC_TRY(sc_alloc(ctx, voxels, sizeof *w->scratch->voxels, &block));
        w->scratch[t].voxels = block;
        SC_TRY(sc_alloc(ctx, ids, sizeof *w->scratch->ids, &block));
        w->scratch[t].ids = block;
    }
out:
    return status;
}

static void clear_work(border_work *w)
{
    for (int t = 0; t < w->threads && w->scratch; t++) {
        sc_free(w->scratch[t].voxels);
        sc_free(w->scratch[t].ids);
    }
    sc_free(w->scratch);
    sc_free(w->counts);
    sc_free(w->sample);
}

/* Look for the blocks of the sample, some at a time until there are enough. Collective in the team,
 * the same result on all its ranks. @param looked at how many blocks to look at most. @return how
 * many are in the sample. */
static size_t find_sample(sc_team *team, border_work *w, size_t looked)
{
    const size_t wanted = (size_t)w->method->sample_blocks;
    size_t count = 0;

    for (size_t begin = 0; begin < looked && count < wanted; begin += ROUND_SAMPLES * wanted) {
        const size_t end =
            begin + ROUND_SAMPLES * wanted < looked ? begin + ROUND_SAMPLES * wanted : looked;

        w->first_looked = begin;
        sc_team_for(team, end - begin, w->chunk, look_for_borders, w);
        for (size_t n = begin; n < end && count < wanted; n++) {
            if (w->has_border[n])
                w->sample[count++] = looked_at(w, n);
        }
    }
    return count;
}

/* Add up what all threads of all ranks have counted. Collective in the team. */
static sc_status add_counts(const sc_ctx *ctx, sc_team *team, const border_work *w,
                            uint64_t counts[3])
{
    const int ranks = sc_team_ranks(team);
    uint64_t mine[3] = {0, 0, 0};
    const uint64_t *all;
    void *block = NULL;
    sc_status status;

    for (int t = 0; t < w->threads; t++) {
        for (int i = 0; i < 3; i++)
            mine[i] += w->counts[t][i];
    }
    SC_TRY(sc_team_collect(ctx, team, mine, sizeof mine, &block));
    all = block;
    for (int i = 0; i < 3; i++) {
        counts[i] = 0;
        for (int rank = 0; rank < ranks; rank++)
            counts[i] += all[3 * rank + i];
    }
    sc_team_free(team, block);
out:
    return status;
}

sc_status sc_borders_measure(const sc_ctx *ctx, sc_team *team, const drawn_view *view,
                             const border_method *method, border_shares *out)
{
    border_work w;
    size_t looked, count;
    uint64_t counts[3];
    void *block = NULL, *has_border = NULL;
    sc_status status = make_work(ctx, view, method, sc_team_threads(team), &w);

    if (status == SC_OK)
        status = sc_alloc(ctx, (size_t)method->sample_blocks, sizeof *w.sample, &block);
    w.sample = block;
    SC_TRY(sc_team_agree(team, status));
    looked = w.blocks[0] * w.blocks[1] * w.blocks[2];
    looked = looked < (size_t)method->looked_at ? looked : (size_t)method->looked_at;
    SC_TRY(sc_team_alloc(ctx, team, looked, 1, &has_border));
    w.has_border = has_border;
    count = find_sample(team, &w, looked);
    sc_team_for(team, count, 1, do_blocks, &w);
    SC_TRY(add_counts(ctx, team, &w, counts));
    out->changed = counts[0] ? (double)counts[1] / (double)counts[0] : 0;
    out->flat = counts[0] ? (double)counts[2] / (double)counts[0] : 0;
out:
    sc_team_free(team, has_border);
    clear_work(&w);
    return status;
}

sc_status sc_borders_relabel(const sc_ctx *ctx, sc_volume *v, const drawn_view *view,
                             const border_method *method, int threads)
{
    const size_t bytes = sc_volume_voxels(v) * (size_t)v->label_bytes;
    border_work w;
    sc_status status;

    SC_TRY(make_work(ctx, view, method, threads, &w));
    SC_TRY(sc_alloc(ctx, bytes, 1, &w.out));
    memcpy(w.out, v->ids, bytes);
    sc_parallel_for(threads, w.blocks[0] * w.blocks[1] * w.blocks[2], w.chunk, do_blocks, &w);
    sc_free(v->ids);
    v->ids = w.out;
out:
    clear_work(&w);
    return status;
}
