/* SPDX-License-Identifier: BSD-3-Clause */
/* Finding the boundary voxels, by the rule that the 3x3x3 neighbourhood of a boundary voxel holds
 * another label (paper, section 2.3). This goes a row at a time: the bits in which a voxel differs
 * from its 26 neighbours are collected by OR over nine rows, which compilers turn into vector
 * instructions. Rows are then searched for differences eight bytes at a time. */
#include "internal.h"

#include <string.h>

/* Rows of labels are compared eight bytes at a time. A word is only compared with zero or with a
 * word of eight equal bytes (four equal pairs), so that the byte order does not matter. */
_Static_assert(sizeof(uint64_t) == 8 * sizeof(uint8_t) && sizeof(uint64_t) == 4 * sizeof(uint16_t),
               "a word holds eight labels of one byte or four of two");

/* Define a function that ORs into @p out[x] the bits in which row[x] differs from other[x - 1],
 * other[x] and other[x + 1]. Columns 0 and n - 1, which lie on the faces of the volume, are left to
 * the caller. */
/* NOLINTBEGIN(bugprone-macro-parentheses): the argument is a type */
#define DEFINE_ROW_DIFFERENCE(name, type)                                                          \
    static void name(const type *row, const type *other, size_t n, type *out)                      \
    {                                                                                              \
        for (size_t x = 1; x + 1 < n; x++)                                                         \
            out[x] = (type)(out[x] | (row[x] ^ other[x - 1]) | (row[x] ^ other[x]) |               \
                            (row[x] ^ other[x + 1]));                                              \
    }
/* NOLINTEND(bugprone-macro-parentheses) */
DEFINE_ROW_DIFFERENCE(row_difference_8, uint8_t)
DEFINE_ROW_DIFFERENCE(row_difference_16, uint16_t)

/* What the threads that find the boundary share. */
typedef struct finder {
    sc_preparation *p;     /* borrowed; its masks are filled */
    sc_label_stats *stats; /* [threads][label_count]: of the voxels that each thread has visited */
    uint16_t *rows;        /* [threads][size x]: room for the differences of one row each */
    uint16_t *background;  /* [size x]: a row outside of the volume */
} finder;

/* @return the labels of row (y, z), which may lie outside of the volume. */
static const void *row_or_background(const finder *f, int y, int z)
{
    const sc_volume *v = f->p->volume;

    if (y < 0 || z < 0 || y >= v->size[1] || z >= v->size[2])
        return f->background;
    return (const char *)v->ids + ((size_t)z * (size_t)v->size[1] + (size_t)y) *
                                      (size_t)v->size[0] * (size_t)v->label_bytes;
}

/* Write to @p out, an array of labels of the width of the volume's, for each voxel of row (y, z)
 * the bits in which it differs from its neighbours. Columns 0 and size x - 1 become 0. */
static void difference_of_row(const finder *f, int y, int z, void *out)
{
    const size_t nx = (size_t)f->p->volume->size[0], each = (size_t)f->p->volume->label_bytes;
    const void *row = row_or_background(f, y, z);

    memset(out, 0, nx * each);
    for (int dz = -1; dz <= 1; dz++) {
        for (int dy = -1; dy <= 1; dy++) {
            const void *other = row_or_background(f, y + dy, z + dz);

            if (each == 1)
                row_difference_8(row, other, nx, out);
            else
                row_difference_16(row, other, nx, out);
        }
    }
}

/* Does the 3x3x3 neighbourhood of a vertex on a face of the volume, or just outside it, hold two
 * labels? Part of it lies outside and is background, so that any other label makes two. */
static bool is_near_outside(const sc_volume *v, int x, int y, int z)
{
    const int at[3] = {x, y, z};
    int low[3], high[3];

    for (int i = 0; i < 3; i++) {
        low[i] = at[i] > 0 ? at[i] - 1 : 0;
        high[i] = at[i] + 1 < v->size[i] ? at[i] + 1 : v->size[i] - 1;
    }
    for (int k = low[2]; k <= high[2]; k++) {
        for (int j = low[1]; j <= high[1]; j++) {
            const size_t row = ((size_t)k * (size_t)v->size[1] + (size_t)j) * (size_t)v->size[0];

            for (int i = low[0]; i <= high[0]; i++) {
                if (sc_volume_id(v, row + (size_t)i))
                    return true;
            }
        }
    }
    return false;
}

/* The masks, [bricks x] in p->near, of the bricks that the row of voxels (y, z) passes through. */
static uint64_t *masks_of_row(const finder *f, int y, int z)
{
    return f->p->near + sc_brick_index(f->p->bricks, 0, sc_brick_of(y + 1), sc_brick_of(z + 1));
}

/* Extend a label's bounding box by the voxels x0 to x1 of row (y, z). */
static void extend_box(sc_label_stats *s, int x0, int x1, int y, int z)
{
    const int low[3] = {x0, y, z}, high[3] = {x1, y, z};

    for (int i = 0; i < 3; i++) {
        s->low[i] = low[i] < s->low[i] ? low[i] : s->low[i];
        s->high[i] = high[i] > s->high[i] ? high[i] : s->high[i];
    }
}

/* @return the column after the run of equal labels that begins at column @p x of a row. @param row
 * index of the voxel in column 0. */
static int end_of_run(const sc_volume *v, size_t row, int x)
{
    const uint32_t id = sc_volume_id(v, row + (size_t)x);
    const size_t each = (size_t)v->label_bytes, stride = 8 / each;
    const uint64_t same = id * (each == 1 ? 0x0101010101010101u : 0x0001000100010001u);
    const char *ids = (const char *)v->ids + row * each;
    int end = x + 1;

    while ((size_t)end + stride <= (size_t)v->size[0]) {
        uint64_t word;

        memcpy(&word, ids + (size_t)end * each, sizeof word);
        if (word != same)
            break;
        end += (int)stride;
    }
    while (end < v->size[0] && sc_volume_id(v, row + (size_t)end) == id)
        end++;
    return end;
}

/* Add the voxels of row (y, z) to voxels and boxes of @p stats [label_count], a run of equal labels
 * at a time. */
static void count_row(const finder *f, int y, int z, sc_label_stats *stats)
{
    const sc_volume *v = f->p->volume;
    const int nx = v->size[0];
    const size_t row = ((size_t)z * (size_t)v->size[1] + (size_t)y) * (size_t)nx;

    for (int x = 0, end; x < nx; x = end) {
        const uint32_t id = sc_volume_id(v, row + (size_t)x);

        end = end_of_run(v, row, x);
        stats[id].voxels += (uint64_t)(end - x);
        extend_box(&stats[id], x, end - 1, y, z);
    }
}

/* Set the bit of a voxel near an interface in the masks of its row, and count it in @p stats
 * [label_count] unless it is background. */
static void mark(const sc_volume *v, uint64_t *masks, int x, int y, int z, sc_label_stats *stats)
{
    const uint32_t id = sc_id_or_background(v, x, y, z);

    masks[sc_brick_of(x + 1)] |= 1ull << sc_brick_bit(x + 1, y + 1, z + 1);
    stats[id].boundary_voxels += id != 0;
}

/* @return the first column from @p x on with a difference; the last column of the row if there is
 * none before it. @param difference of difference_of_row. */
static int next_difference(const sc_volume *v, const uint16_t *difference, int x)
{
    const int end = v->size[0] - 1, stride = 8 / v->label_bytes;
    const char *bytes = (const char *)difference;

    while (x < end) {
        uint64_t word = 0;

        if (x + stride <= end)
            memcpy(&word, bytes + (size_t)x * (size_t)v->label_bytes, sizeof word);
        if (x + stride <= end && !word)
            x += stride;
        else if (v->label_bytes == 1 ? bytes[x] != 0 : difference[x] != 0)
            return x;
        else
            x++;
    }
    return end;
}

/* Set the bits of the vertices of one row that are near an interface in the masks, and add its
 * voxels to @p stats. @p y and @p z are voxels: as the label grid is one vertex wider than the
 * volume, they run from -1 to their sizes, and so do the columns. @param difference scratch. */
static void mark_row(finder *f, int y, int z, uint16_t *difference, sc_label_stats *stats)
{
    const sc_volume *v = f->p->volume;
    const int nx = v->size[0];
    uint64_t *masks = masks_of_row(f, y, z);

    if (y >= 0 && y < v->size[1] && z >= 0 && z < v->size[2])
        count_row(f, y, z, stats);
    for (int x = -1; x <= nx; x++) {
        if (x == 1 && nx > 2)
            x = nx - 1;
        if (is_near_outside(v, x, y, z))
            mark(v, masks, x, y, z, stats);
    }
    difference_of_row(f, y, z, difference);
    for (int x = 1; x < nx - 1; x++) {
        x = next_difference(v, difference, x);
        if (x < nx - 1)
            mark(v, masks, x, y, z, stats);
    }
}

/* Mark and count layers of bricks [begin, end) along z; an sc_range_fn on a finder. A layer belongs
 * to one thread, so that no two threads write to the same mask. */
static void find_layers(void *user, size_t begin, size_t end, int thread)
{
    finder *f = user;
    const sc_volume *v = f->p->volume;
    uint16_t *difference = f->rows + (size_t)thread * (size_t)v->size[0];
    sc_label_stats *stats = f->stats + (size_t)thread * (size_t)v->label_count;
    const int last = (int)end * SC_BRICK < v->size[2] + 2 ? (int)end * SC_BRICK : v->size[2] + 2;

    for (int z = (int)begin * SC_BRICK - 1; z < last - 1; z++) {
        for (int y = -1; y <= v->size[1]; y++)
            mark_row(f, y, z, difference, stats);
    }
}

/* Add @p parts statistics of all labels, [parts][label_count], to @p sums [label_count]. */
static void add_stats(const sc_label_stats *stats, int parts, int labels, sc_label_stats *sums)
{
    for (int i = 0; i < parts * labels; i++) {
        const sc_label_stats *from = &stats[i];
        sc_label_stats *to = &sums[i % labels];

        to->voxels += from->voxels;
        to->boundary_voxels += from->boundary_voxels;
        for (int axis = 0; axis < 3; axis++) {
            to->low[axis] = from->low[axis] < to->low[axis] ? from->low[axis] : to->low[axis];
            to->high[axis] = from->high[axis] > to->high[axis] ? from->high[axis] : to->high[axis];
        }
    }
}

/* Set @p count statistics to those of no voxels. */
static void clear_stats(sc_label_stats *stats, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        stats[i] = (sc_label_stats){.low = {INT32_MAX, INT32_MAX, INT32_MAX}, .high = {-1, -1, -1}};
    }
}

/* Add the statistics of all threads of all ranks to those of the preparation. @param sums room for
 * those of all labels on this rank. Returns SC_ERR_MEMORY. */
static sc_status merge_stats(const sc_ctx *ctx, const finder *f, sc_label_stats *sums)
{
    const int labels = f->p->volume->label_count;
    void *all;

    clear_stats(sums, (size_t)labels);
    add_stats(f->stats, f->p->settings.threads, labels, sums);
    SC_PASS(sc_team_collect(ctx, f->p->team, sums, (size_t)labels * sizeof *sums, &all));
    add_stats(all, sc_team_ranks(f->p->team), labels, f->p->stats);
    sc_team_free(f->p->team, all);
    return SC_OK;
}

sc_status sc_find_boundary(const sc_ctx *ctx, sc_preparation *p)
{
    const sc_volume *v = p->volume;
    const size_t labels = (size_t)v->label_count, threads = (size_t)p->settings.threads;
    finder f = {.p = p};
    SC_OWN(sc_free_at) uint16_t *rows = NULL, *background = NULL;
    SC_OWN(sc_free_at) sc_label_stats *stats = NULL, *sums = NULL;
    void *block;
    sc_status status = SC_ALLOC(ctx, labels, &p->stats);

    if (status == SC_OK)
        status = SC_ALLOC(ctx, labels, &sums);
    if (status == SC_OK)
        status = SC_ALLOC(ctx, labels * threads, &stats);
    if (status == SC_OK)
        status = SC_ALLOC(ctx, threads * (size_t)v->size[0], &rows);
    if (status == SC_OK)
        status = SC_ZALLOC(ctx, (size_t)v->size[0], &background);
    SC_PASS(sc_team_agree(p->team, status));
    SC_PASS(sc_team_alloc(ctx, p->team, p->brick_count, sizeof(uint64_t), &block));
    p->near = block;
    f.stats = stats;
    f.rows = rows;
    f.background = background;
    clear_stats(p->stats, labels);
    clear_stats(f.stats, labels * threads);
    if (sc_team_is_first(p->team)) /* while the others begin with the loop */
        p->volume_hash = sc_volume_hash(v);
    sc_team_stage_for(ctx, SC_WORTH_BOUNDARY, p->team, (size_t)p->bricks[2], 1, find_layers, &f);
    return merge_stats(ctx, &f, sums);
}

enum { NUMBERED = 4096 /* bricks that a thread numbers at a time */ };

/* A numbering of bricks, which the threads share. */
typedef struct numbering {
    const uint64_t *masks;
    bool by_vertex;   /* count vertices that are marked; else bricks with such a vertex */
    uint64_t *counts; /* [chunks], of the team */
    uint32_t *out;    /* as of sc_number_bricks, or of sc_number_vertices if by_vertex */
} numbering;

/* @return what a brick counts. */
static uint32_t count_of(const numbering *n, size_t brick)
{
    const uint64_t mask = n->masks[brick];

    return n->by_vertex ? sc_count_bits(mask) : mask != 0;
}

/* Count what is in the bricks [begin, end), which are one chunk; an sc_range_fn on a numbering. */
static void count_bricks(void *user, size_t begin, size_t end, int thread)
{
    const numbering *n = user;
    uint64_t count = 0;

    for (size_t brick = begin; brick < end; brick++)
        count += count_of(n, brick);
    n->counts[begin / NUMBERED] = count;
}

/* Number the bricks [begin, end), which are one chunk; an sc_range_fn on a numbering. */
static void number_chunk(void *user, size_t begin, size_t end, int thread)
{
    const numbering *n = user;
    uint64_t count = 0;

    for (size_t chunk = 0; chunk < begin / NUMBERED; chunk++)
        count += n->counts[chunk];
    for (size_t brick = begin; brick < end; brick++) {
        const uint32_t more = count_of(n, brick);

        n->out[brick] = n->by_vertex ? (uint32_t)count : more ? (uint32_t)count + 1 : 0;
        count += more;
    }
}

/* As sc_number_bricks, or as sc_number_vertices if @p by_vertex, without its limit. */
static sc_status number(const sc_ctx *ctx, const sc_preparation *p, const uint64_t *masks,
                        bool by_vertex, uint32_t **out, uint64_t *count)
{
    const size_t chunks = (p->brick_count + NUMBERED - 1) / NUMBERED;
    numbering n = {.masks = masks, .by_vertex = by_vertex};
    void *block = NULL, *counts = NULL;
    uint64_t sum = 0;
    sc_status status;

    SC_TRY(sc_team_alloc(ctx, p->team, chunks, sizeof *n.counts, &counts));
    n.counts = counts;
    SC_TRY(sc_team_alloc(ctx, p->team, p->brick_count, sizeof **out, &block));
    n.out = block;
    sc_team_for(p->team, p->brick_count, NUMBERED, count_bricks, &n);
    for (size_t chunk = 0; chunk < chunks; chunk++)
        sum += n.counts[chunk];
    sc_team_for(p->team, p->brick_count, NUMBERED, number_chunk, &n);
    *out = n.out;
    *count = sum;
out:
    sc_team_free(p->team, counts);
    return status;
}

sc_status sc_number_bricks(const sc_ctx *ctx, const sc_preparation *p, const uint64_t *masks,
                           uint32_t **out, uint64_t *count)
{
    return number(ctx, p, masks, false, out, count);
}

sc_status sc_number_vertices(const sc_ctx *ctx, const sc_preparation *p, const uint64_t *masks,
                             uint32_t **start, uint64_t *count)
{
    const sc_status status = number(ctx, p, masks, true, start, count);

    if (status == SC_OK && *count > UINT32_MAX)
        return sc_fail(ctx, SC_ERR_MEMORY,
                       "more than %u grid vertices lie near an interface, but their indices "
                       "have 32 bits; crop or coarsen the volume",
                       UINT32_MAX);
    return status;
}

sc_status sc_index_boundary(const sc_ctx *ctx, sc_preparation *p)
{
    SC_PASS(sc_number_vertices(ctx, p, p->near, &p->near_start, &p->near_count));
    for (int id = 1; id < p->volume->label_count; id++)
        p->boundary_count += p->stats[id].boundary_voxels;
    return SC_OK;
}
