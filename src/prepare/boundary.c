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
} finder;

/* Write to @p out, an array of labels of the width of the volume's, for each voxel of row (y, z)
 * the bits in which it differs from its neighbours. The row must not lie on a face of the volume.
 * Columns 0 and size x - 1 become 0. */
static void difference_of_row(const sc_volume *v, int y, int z, void *out)
{
    const size_t nx = (size_t)v->size[0], each = (size_t)v->label_bytes;
    const char *ids = v->ids;
    const char *row = ids + ((size_t)z * (size_t)v->size[1] + (size_t)y) * nx * each;

    memset(out, 0, nx * each);
    for (int dz = -1; dz <= 1; dz++) {
        for (int dy = -1; dy <= 1; dy++) {
            const char *other =
                ids + ((size_t)(z + dz) * (size_t)v->size[1] + (size_t)(y + dy)) * nx * each;

            if (each == 1)
                row_difference_8((const uint8_t *)row, (const uint8_t *)other, nx, out);
            else
                row_difference_16((const uint16_t *)row, (const uint16_t *)other, nx, out);
        }
    }
}

/* Does the 3x3x3 neighbourhood of a voxel hold another label? The voxel may lie on a face of the
 * volume or just outside it. */
static bool is_near(const sc_volume *v, int x, int y, int z)
{
    const uint32_t id = sc_id_or_background(v, x, y, z);

    for (int n = 0; n < 27; n++) {
        if (sc_id_or_background(v, x + n % 3 - 1, y + n / 3 % 3 - 1, z + n / 9 - 1) != id)
            return true;
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
    const uint32_t id = sc_id_at(v, row + (size_t)x);
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
    while (end < v->size[0] && sc_id_at(v, row + (size_t)end) == id)
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
        const uint32_t id = sc_id_at(v, row + (size_t)x);

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
    const bool on_face = y < 1 || z < 1 || y > v->size[1] - 2 || z > v->size[2] - 2;
    const bool by_words =
        !on_face && nx > 2; /* columns 1 to nx - 2, all neighbours of which exist */
    uint64_t *masks = masks_of_row(f, y, z);

    if (y >= 0 && y < v->size[1] && z >= 0 && z < v->size[2])
        count_row(f, y, z, stats);
    for (int x = -1; x <= nx; x++) {
        if (by_words && x == 1)
            x = nx - 1;
        if (is_near(v, x, y, z))
            mark(v, masks, x, y, z, stats);
    }
    if (!by_words)
        return;
    difference_of_row(v, y, z, difference);
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

/* Add the statistics of all threads to those of the preparation. */
static void merge_stats(const finder *f)
{
    const int labels = f->p->volume->label_count;

    for (int thread = 0; thread < f->p->settings.threads; thread++) {
        for (int id = 0; id < labels; id++) {
            const sc_label_stats *from = &f->stats[thread * labels + id];
            sc_label_stats *to = &f->p->stats[id];

            to->voxels += from->voxels;
            to->boundary_voxels += from->boundary_voxels;
            for (int i = 0; i < 3; i++) {
                to->low[i] = from->low[i] < to->low[i] ? from->low[i] : to->low[i];
                to->high[i] = from->high[i] > to->high[i] ? from->high[i] : to->high[i];
            }
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

sc_status sc_find_boundary(const sc_ctx *ctx, sc_preparation *p)
{
    const sc_volume *v = p->volume;
    const size_t labels = (size_t)v->label_count, threads = (size_t)p->settings.threads;
    finder f = {.p = p};
    void *block = NULL, *rows = NULL, *stats = NULL;
    sc_status status;

    SC_TRY(sc_zalloc(ctx, p->brick_count, sizeof(uint64_t), &block));
    p->near = block;
    SC_TRY(sc_alloc(ctx, labels, sizeof(sc_label_stats), &block));
    p->stats = block;
    SC_TRY(sc_alloc(ctx, labels * threads, sizeof(sc_label_stats), &stats));
    SC_TRY(sc_alloc(ctx, threads * (size_t)v->size[0], sizeof(uint16_t), &rows));
    f.stats = stats;
    f.rows = rows;
    clear_stats(p->stats, labels);
    clear_stats(f.stats, labels * threads);
    sc_stage_for(ctx, SC_WORTH_BOUNDARY, p->settings.threads, (size_t)p->bricks[2], 1, find_layers,
                 &f);
    merge_stats(&f);
out:
    sc_free(stats);
    sc_free(rows);
    return status;
}

sc_status sc_index_boundary(const sc_ctx *ctx, sc_preparation *p)
{
    void *block;
    sc_status status = sc_alloc(ctx, p->brick_count, sizeof(uint32_t), &block);

    if (status != SC_OK)
        return status;
    p->near_start = block;
    for (size_t brick = 0; brick < p->brick_count; brick++) {
        p->near_start[brick] = (uint32_t)p->near_count;
        p->near_count += sc_count_bits(p->near[brick]);
        if (p->near_count > UINT32_MAX)
            return sc_fail(ctx, SC_ERR_MEMORY,
                           "more than %u grid vertices lie near an interface, but their indices "
                           "have 32 bits; crop or coarsen the volume",
                           UINT32_MAX);
    }
    for (int id = 1; id < p->volume->label_count; id++)
        p->boundary_count += p->stats[id].boundary_voxels;
    return SC_OK;
}

void sc_each_boundary(const sc_preparation *p, size_t begin, size_t end, sc_boundary_fn *visit,
                      void *user)
{
    const sc_volume *volume = p->volume;

    for (size_t brick = begin; brick < end; brick++) {
        uint64_t mask = p->near[brick];
        sc_boundary_voxel voxel = {.record = p->near_start[brick]};
        int low[3];

        sc_brick_low(p->bricks, brick, low);
        for (; mask; mask &= mask - 1, voxel.record++) {
            const int bit = __builtin_ctzll(mask);

            voxel.x = low[0] + sc_bit_x(bit) - 1;
            voxel.y = low[1] + sc_bit_y(bit) - 1;
            voxel.z = low[2] + sc_bit_z(bit) - 1;
            voxel.id = sc_id_or_background(volume, voxel.x, voxel.y, voxel.z);
            if (!voxel.id)
                continue; /* background; it has a vertex record, which was counted above */
            visit(user, &voxel);
        }
    }
}
