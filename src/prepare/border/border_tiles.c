/* SPDX-License-Identifier: BSD-3-Clause */
/* The tiles of the fields of borders: which there are, and reading regions of them. */
#include "border/border.h"

enum {
    SUB = SC_SUB,
    SUB_PER_CUBE = SC_CUBE / SUB,
    SUB_LABELS = SC_SUB_LABELS,
    MOST_LABELS = 256 /* where there are more around a block, its tissues have no fields, and are
                         drawn as their voxels are: memory stays bounded */
};

/* What the threads share that look for tiles. */
typedef struct finder {
    sc_borders *b;
    uint32_t *counts; /* [cube_count], of the team: tiles of each block */
} finder;

/* A set of labels, in rising order. Of more than MOST_LABELS it holds the smallest. */
typedef struct label_set {
    int count;
    bool crowded; /* there were more than MOST_LABELS */
    uint16_t ids[MOST_LABELS];
} label_set;

/* Add a label to a set. */
static void add_label(label_set *set, uint16_t id)
{
    int at = set->count;

    while (at > 0 && set->ids[at - 1] > id)
        at--;
    if (at > 0 && set->ids[at - 1] == id)
        return;
    if (set->count == MOST_LABELS) {
        set->crowded = true;
        if (at == MOST_LABELS)
            return;
        set->count--;
    }
    memmove(set->ids + at + 1, set->ids + at, (size_t)(set->count - at) * sizeof *set->ids);
    set->ids[at] = id;
    set->count++;
}

/* Add the labels of the voxels of the volume in the cube of SUB voxels at @p low to a set. */
static void add_cube(const sc_volume *v, const int low[3], label_set *set)
{
    uint32_t last = SC_NO_LABEL;
    int begin[3], high[3];

    for (int i = 0; i < 3; i++) {
        begin[i] = low[i] > 0 ? low[i] : 0;
        high[i] = low[i] + SUB < v->size[i] ? low[i] + SUB : v->size[i];
    }
    for (int z = begin[2]; z < high[2]; z++) {
        for (int y = begin[1]; y < high[1]; y++) {
            const size_t row = ((size_t)z * (size_t)v->size[1] + (size_t)y) * (size_t)v->size[0];

            for (int x = begin[0]; x < high[0]; x++) {
                const uint32_t id = sc_volume_id(v, row + (size_t)x);

                if (id != last)
                    add_label(set, (uint16_t)id);
                last = id;
            }
        }
    }
}

/* Are all voxels of a cube that lies within the volume, whose labels have one byte, the same? */
static bool is_uniform(const sc_volume *v, const int low[3])
{
    const size_t row = (size_t)v->size[0], layer = row * (size_t)v->size[1];
    const uint8_t *ids =
        (const uint8_t *)v->ids + (size_t)low[2] * layer + (size_t)low[1] * row + (size_t)low[0];
    const uint32_t same = ids[0] * 0x01010101u;
    uint32_t differ = 0;

    for (size_t i = 0; i < SUB * SUB; i++) {
        uint32_t word;

        memcpy(&word, ids + i / SUB * layer + i % SUB * row, sizeof word);
        differ |= word ^ same;
    }
    _Static_assert(sizeof same == SUB, "a word is a row of a cube");
    return !differ;
}

/* List the labels of the cubes [begin, end); an sc_range_fn on a finder. */
static void list_cubes(void *user, size_t begin, size_t end, int thread)
{
    const finder *f = user;
    const sc_volume *v = f->b->p->volume;

    for (size_t i = begin; i < end; i++) {
        sc_sub_labels *list = &f->b->subs.lists[i];
        label_set set = {.count = 0};
        bool inside = v->label_bytes == 1;
        int low[3];

        sc_brick_at(f->b->subs.size, i, low);
        for (int k = 0; k < 3; k++) {
            low[k] = low[k] * SUB - f->b->phase[k];
            inside = inside && low[k] >= 0 && low[k] + SUB <= v->size[k];
        }
        if (inside && is_uniform(v, low)) {
            list->count = 1;
            list->ids[0] =
                ((const uint8_t *)v->ids)[((size_t)low[2] * (size_t)v->size[1] + (size_t)low[1]) *
                                              (size_t)v->size[0] +
                                          (size_t)low[0]];
            continue;
        }
        add_cube(v, low, &set);
        list->count = (uint16_t)(set.count > SUB_LABELS ? SUB_LABELS + 1 : set.count);
        for (int k = 0; k < set.count && k < SUB_LABELS; k++)
            list->ids[k] = set.ids[k];
    }
}

/* Collect the labels within @p reach times SUB voxels of a block. SUB is the farthest that a
 * distance tells of. */
static void labels_around(const finder *f, size_t block, int reach, label_set *set)
{
    int at[3], low[3], high[3];

    set->count = 0;
    set->crowded = false;
    sc_brick_at(f->b->cubes, block, at);
    for (int i = 0; i < 3; i++) {
        low[i] = at[i] > 0 ? SUB_PER_CUBE * at[i] - reach : 0;
        high[i] = SUB_PER_CUBE * (at[i] + 1) + reach;
        high[i] = high[i] < f->b->subs.size[i] ? high[i] : f->b->subs.size[i];
    }
    for (int z = low[2]; z < high[2]; z++) {
        for (int y = low[1]; y < high[1]; y++) {
            for (int x = low[0]; x < high[0]; x++) {
                const sc_sub_labels *list =
                    &f->b->subs.lists[sc_brick_index(f->b->subs.size, x, y, z)];

                if (list->count > SUB_LABELS)
                    add_cube(f->b->p->volume,
                             (const int[3]){x * SUB - f->b->phase[0], y * SUB - f->b->phase[1],
                                            z * SUB - f->b->phase[2]},
                             set);
                for (int k = 0; k < list->count && list->count <= SUB_LABELS; k++)
                    add_label(set, list->ids[k]);
            }
        }
    }
}

/* @return how many tissues are in a set. */
static int tissues_of(const label_set *set)
{
    return set->count - (set->count > 0 && set->ids[0] == 0);
}

/* @return the tissue around a block, for sc_cube. The fields of two tissues are the opposite of
 * each other only if there is no third one farther away, either, which one of them may meet. */
static uint16_t tissue_around(const finder *f, size_t block, const label_set *set)
{
    const int tissues = tissues_of(set);
    label_set wide;

    if (tissues < 2)
        return tissues ? set->ids[set->count - 1] : 0;
    if (tissues > 2)
        return SC_MANY_TISSUES;
    labels_around(f, block, 2, &wide);
    return tissues_of(&wide) == 2 ? SC_TWO_TISSUES : SC_MANY_TISSUES;
}

/* @return how many tiles a block with these labels around has. */
static uint32_t count_of(const label_set *set, uint16_t tissue)
{
    const int tissues = tissues_of(set);
    const uint32_t outer = tissues > 0 && tissues < set->count;

    return outer + (set->crowded || tissue < SC_TWO_TISSUES ? 0
                    : tissue == SC_TWO_TISSUES              ? 1
                                                            : (uint32_t)tissues);
}

/* Count the tiles of cubes [begin, end), and fill around; an sc_range_fn on a finder. */
static void count_tiles(void *user, size_t begin, size_t end, int thread)
{
    const finder *f = user;

    for (size_t block = begin; block < end; block++) {
        sc_cube *around = &f->b->around[block];
        label_set set;

        labels_around(f, block, 1, &set);
        around->tissue = tissue_around(f, block, &set);
        around->second = set.crowded ? SC_NO_LABEL : set.count ? set.ids[set.count - 1] : 0;
        f->counts[block] = count_of(&set, around->tissue);
    }
}

/* Name the tiles of cubes [begin, end); an sc_range_fn on a finder. */
static void name_tiles(void *user, size_t begin, size_t end, int thread)
{
    const finder *f = user;

    for (size_t block = begin; block < end; block++) {
        uint32_t tile = f->b->start[block];
        label_set set;

        if (!f->counts[block])
            continue;
        labels_around(f, block, 1, &set);
        for (int k = 0; tile < f->b->start[block + 1]; k++) {
            if (!set.ids[k] ? set.count == 1 : f->b->around[block].tissue < SC_TWO_TISSUES)
                continue;
            f->b->tiles.labels[tile] = set.ids[k];
            f->b->tiles.cube_of[tile++] = (uint32_t)block;
        }
    }
}

/* Find what lies beside the tiles [begin, end); an sc_range_fn on sc_borders. */
static void find_beside(void *user, size_t begin, size_t end, int thread)
{
    const sc_borders *b = user;

    for (size_t tile = begin; tile < end; tile++) {
        int at[3];

        sc_brick_at(b->cubes, b->tiles.cube_of[tile], at);
        for (int n = 0; n < 27; n++) {
            const int x = at[0] + n % 3 - 1, y = at[1] + n / 3 % 3 - 1, z = at[2] + n / 9 - 1;
            const bool within =
                x >= 0 && y >= 0 && z >= 0 && x < b->cubes[0] && y < b->cubes[1] && z < b->cubes[2];
            const size_t block = within ? sc_brick_index(b->cubes, x, y, z) : 0;

            b->tiles.beside[tile][n] =
                within ? sc_tile_of(b, block, b->tiles.labels[tile]) : SC_BESIDE(SC_BESIDE_VOLUME);
        }
    }
}

/* Allocate an array of @p count elements for the borders. @return SC_ERR_MEMORY. */
#define ALLOCATE(ctx, b, member, count)                                                            \
    sc_team_alloc(ctx, (b)->p->team, (count) ? (count) : 1, sizeof *(b)->member,                   \
                  (void **)&(b)->member)

/* @return how many voxels of the first cube along an axis lie before the volume. Cubes begin at
 * every SC_CUBE-th voxel from the origin of the patient on, counted to the right, to the front and
 * up, so that they lie at the same places whichever way the axes of a volume lead, and in whatever
 * part of it was cut out. The nearest voxel is the one up to three quarters below, as origins lie
 * in the middle of a voxel or between two. */
static int phase_of(const sc_affine *to_ras_mm, int axis)
{
    const sc_vec3 column = sc_affine_column(to_ras_mm, axis);
    const double along[3] = {column.x, column.y, column.z};
    const double length = sc_vec3_length(column);
    double at = 0;
    int most = 0, voxel;

    for (int i = 0; i < 3; i++) {
        most = fabs(along[i]) > fabs(along[most]) ? i : most;
        at += to_ras_mm->m[i][3] * along[i] / (length * length);
    }
    at = floor((along[most] < 0 ? -at : at) + 0.25);
    voxel = (int)fmod(at, SC_CUBE); /* exact, however far away the origin is */
    voxel = voxel < 0 ? voxel + SC_CUBE : voxel;
    return along[most] < 0 ? SC_CUBE - 1 - voxel : voxel;
}

sc_status sc_find_tiles(const sc_ctx *ctx, sc_borders *b)
{
    finder f = {.b = b};
    void *lists = NULL, *counts = NULL;
    size_t cubes = 1;
    sc_status status;

    for (int i = 0; i < 3; i++) {
        const int size = b->p->volume->size[i];

        b->phase[i] = phase_of(&b->p->volume->to_ras_mm, i);
        b->cubes[i] = (size + b->phase[i] + SC_CUBE - 1) / SC_CUBE;
        b->subs.size[i] = (size + b->phase[i] + SUB - 1) / SUB;
        cubes *= (size_t)b->subs.size[i];
    }
    b->cube_count = sc_brick_count(b->cubes);
    SC_TRY(sc_team_alloc(ctx, b->p->team, cubes, sizeof *b->subs.lists, &lists));
    b->subs.lists = lists;
    SC_TRY(sc_team_alloc(ctx, b->p->team, b->cube_count, sizeof *f.counts, &counts));
    f.counts = counts;
    SC_TRY(ALLOCATE(ctx, b, around, b->cube_count));
    SC_TRY(ALLOCATE(ctx, b, start, b->cube_count + 1));
    sc_team_stage_for(ctx, SC_WORTH_TILES, b->p->team, cubes, 256, list_cubes, &f);
    sc_team_for(b->p->team, b->cube_count, 64, count_tiles, &f);
    for (size_t i = 0; i < b->cube_count; i++)
        b->tiles.count += f.counts[i];
    if (sc_team_is_first(b->p->team)) {
        for (size_t i = 0; i < b->cube_count; i++)
            b->start[i + 1] = b->start[i] + f.counts[i];
    }
    SC_TRY(sc_team_agree(b->p->team, SC_OK));
    SC_TRY(ALLOCATE(ctx, b, tiles.labels, b->tiles.count));
    SC_TRY(ALLOCATE(ctx, b, tiles.cube_of, b->tiles.count));
    sc_team_for(b->p->team, b->cube_count, 64, name_tiles, &f);
out:
    sc_team_free(b->p->team, counts);
    return status;
}

sc_status sc_find_beside(const sc_ctx *ctx, sc_borders *b)
{
    SC_PASS(ALLOCATE(ctx, b, tiles.beside, b->tiles.count));
    sc_team_for(b->p->team, b->tiles.count, 64, find_beside, b);
    return SC_OK;
}

/* Let the numbers of a region go on linearly beyond [begin, end) along an axis. */
void sc_extrapolate_along(float *region, int edge, int axis, int begin, int end)
{
    const int step = axis == 0 ? 1 : axis == 1 ? edge : edge * edge;
    const int across[2] = {axis == 0 ? edge : 1, axis == 2 ? edge : edge * edge};

    for (int k = 0; k < edge * edge; k++) {
        float *line = region + k % edge * across[0] + k / edge * across[1];

        for (int i = begin - 1; i >= 0; i--)
            line[i * step] = end - begin > 1 ? 2 * line[(i + 1) * step] - line[(i + 2) * step]
                                             : line[(i + 1) * step];
        for (int i = end; i < edge; i++)
            line[i * step] = end - begin > 1 ? 2 * line[(i - 1) * step] - line[(i - 2) * step]
                                             : line[(i - 1) * step];
    }
}

void sc_extrapolate(const sc_borders *b, size_t tile, int each, int halo, float *region)
{
    const int edge = each + 2 * halo, voxels = SC_CUBE / each;
    int low[3];

    sc_cube_low(b, b->tiles.cube_of[tile], low);
    for (int i = 0; i < 3; i++) {
        const int size = b->p->volume->size[i];
        int begin = 0, end = edge;

        while (low[i] + (begin - halo + 1) * voxels <= 0)
            begin++;
        while (low[i] + (end - 1 - halo) * voxels >= size)
            end--;

        if (begin > 0 || end < edge)
            sc_extrapolate_along(region, edge, i, begin, end);
    }
}
