/* SPDX-License-Identifier: BSD-3-Clause */
/* A volume on voxels of another size: each label votes for each new voxel, and the largest vote has
 * it, so that no label is invented and borders stay smooth. A vote is the share of a label among
 * the old voxels around the new centre, by a separable kernel: along axes that become finer the
 * cubic B-spline, which smooths the stairs of the old voxels, and along those that become coarser
 * the cubic of Catmull and Rom, as wide as the new voxels, which keeps volumes. What is so thin
 * that the B-spline would tear it is interpolated linearly instead, or, as lines are, keeps its
 * voxels. */
#include "internal.h"

/* The share of a label, by the B-spline at the centre of a voxel that has it, is 0.58 at the corner
 * of a block, 0.54 where a line begins on a surface, 0.5 in a sheet along a diagonal, 0.46 in a
 * voxel that juts out of a surface, and 0.44 in a line. Below THIN_SHARE the vote is interpolated
 * linearly, below LINE_SHARE the voxel keeps its label. */
#define THIN_SHARE 0.57
#define LINE_SHARE 0.455

/* The weights of the old voxels along one axis for all new ones. */
typedef struct vote_axis {
    int count;       /* new voxels */
    double first;    /* where the centre of the first lies, in old voxels */
    double step;     /* old voxels from one to the next */
    int taps;        /* old voxels that each looks at */
    int *begin;      /* [count]: the first of them; owned */
    int *nearest;    /* [count]: the old voxel that its centre lies in; owned */
    double *weights; /* [count][taps], 0 outside of the volume, the sum 1; owned */
    double *linear;  /* the same of linear interpolation, where the axis becomes finer; owned */
} vote_axis;

/* What one thread works on. */
typedef struct vote_room {
    double *votes; /* [labels], all 0 between voxels; owned */
    bool *seen;    /* [labels], all false between voxels: is there a vote? owned */
    uint32_t *met; /* [labels]: those with a vote; owned */
} vote_room;

/* What the threads share. */
typedef struct vote_work {
    const sc_volume *from;
    vote_axis axes[3];
    bool refines;     /* along some axis */
    void *ids;        /* of the new volume */
    vote_room *rooms; /* [threads], owned */
} vote_work;

static double b_spline(double x)
{
    x = fabs(x);
    if (x < 1)
        return 2.0 / 3 - x * x + x * x * x / 2;
    return x < 2 ? (2 - x) * (2 - x) * (2 - x) / 6 : 0;
}

static double catmull_rom(double x)
{
    x = fabs(x);
    if (x < 1)
        return (1.5 * x - 2.5) * x * x + 1;
    return x < 2 ? ((-0.5 * x + 2.5) * x - 4) * x + 2 : 0;
}

/* Find how many new voxels there are along an axis, and where: the middle of the volume stays. */
static vote_axis place_axis(const sc_volume *v, int axis, double spacing_mm)
{
    const double old_mm = sc_vec3_length(sc_affine_column(&v->to_ras_mm, axis));
    const double ratio = spacing_mm / old_mm;
    const double step = fabs(ratio - 1) < 1e-6 || v->size[axis] == 1 ? 1 : ratio;
    const double count = fmin(fmax(1, round(v->size[axis] / step)), INT32_MAX / 2);

    return (vote_axis){.count = (int)count,
                       .first = (v->size[axis] - count * step) / 2 + step / 2 - 0.5,
                       .step = step,
                       .taps = step == 1 ? 1 : (int)ceil(4 * fmax(1, step))};
}

void sc_resample_votes_grid(const sc_volume *volume, const double spacing_mm[3], int size[3],
                            sc_affine *to_ras_mm)
{
    sc_volume moved = *volume; /* of which only size and geometry are used */

    for (int i = 0; i < 3; i++) {
        const vote_axis a = place_axis(volume, i, spacing_mm[i]);

        sc_resample_set_axis(&moved, i, a.count, a.first, a.step);
    }
    memcpy(size, moved.size, sizeof moved.size);
    *to_ras_mm = moved.to_ras_mm;
}

static double tent(double x)
{
    return fmax(0, 1 - fabs(x));
}

/* Write the weights of new voxel @p n along an axis of @p size old voxels to out[taps]. */
static void weigh(const vote_axis *a, int size, int n, double (*kernel)(double), double *out)
{
    const double centre = a->first + n * a->step, width = fmax(1, a->step);
    double sum = 0;

    for (int i = 0; i < a->taps; i++) {
        if (a->begin[n] + i >= 0 && a->begin[n] + i < size)
            out[i] = a->taps == 1 ? 1 : kernel((a->begin[n] + i - centre) / width);
        sum += out[i];
    }
    for (int i = 0; i < a->taps; i++)
        out[i] /= sum;
}

/* Compute the weights of an axis of @p size old voxels. */
static sc_status weigh_axis(const sc_ctx *ctx, int size, vote_axis *a)
{
    SC_PASS(SC_ALLOC(ctx, (size_t)a->count, &a->begin));
    SC_PASS(SC_ALLOC(ctx, (size_t)a->count, &a->nearest));
    SC_PASS(SC_ZALLOC(ctx, (size_t)a->count * (size_t)a->taps, &a->weights));
    SC_PASS(SC_ZALLOC(ctx, (size_t)a->count * (size_t)a->taps, &a->linear));
    for (int n = 0; n < a->count; n++) {
        const double centre = a->first + n * a->step, width = fmax(1, a->step);
        const size_t row = (size_t)n * (size_t)a->taps;

        a->nearest[n] = (int)fmin(fmax(0, floor(centre + 0.5)), size - 1);
        a->begin[n] = a->taps == 1 ? a->nearest[n] : (int)ceil(centre - 2 * width);
        weigh(a, size, n, a->step < 1 ? b_spline : catmull_rom, a->weights + row);
        weigh(a, size, n, a->step < 1 ? tent : catmull_rom, a->linear + row);
    }
    return SC_OK;
}

/* @return the share of the label @p id around the old voxel @p at, which has it, by the B-spline
 * along axes that become finer; beyond the volume there is none. */
static double share_of(const vote_work *w, const int at[3], uint32_t id)
{
    static const double weights[3] = {1.0 / 6, 2.0 / 3, 1.0 / 6};
    const sc_volume *v = w->from;
    double share = 0;
    int reach[3];

    for (int i = 0; i < 3; i++)
        reach[i] = w->axes[i].step < 1;
    for (int z = at[2] - reach[2]; z <= at[2] + reach[2]; z++) {
        for (int y = at[1] - reach[1]; y <= at[1] + reach[1]; y++) {
            for (int x = at[0] - reach[0]; x <= at[0] + reach[0]; x++) {
                const double weight = (reach[0] ? weights[x - at[0] + 1] : 1) *
                                      (reach[1] ? weights[y - at[1] + 1] : 1) *
                                      (reach[2] ? weights[z - at[2] + 1] : 1);

                if (x < 0 || y < 0 || z < 0 || x >= v->size[0] || y >= v->size[1] ||
                    z >= v->size[2])
                    continue;
                if (sc_volume_id(v,
                                 ((size_t)z * (size_t)v->size[1] + (size_t)y) * (size_t)v->size[0] +
                                     (size_t)x) == id)
                    share += weight;
            }
        }
    }
    return share;
}

/* @return the label with the largest vote for the new voxel @p at; of equal ones that with the
 * smallest id. @param linear by linear interpolation? */
static uint32_t elect(const vote_work *w, vote_room *room, const int at[3], bool linear)
{
    const sc_volume *v = w->from;
    const vote_axis *a = w->axes;
    const double *weights[3];
    uint32_t best = UINT32_MAX;
    size_t met = 0;

    for (int i = 0; i < 3; i++)
        weights[i] = (linear ? a[i].linear : a[i].weights) + (size_t)at[i] * (size_t)a[i].taps;

    for (int k = 0; k < a[2].taps; k++) {
        const double wz = weights[2][k];

        for (int j = 0; j < a[1].taps && wz != 0; j++) {
            const double wy = wz * weights[1][j];
            const size_t row = ((size_t)(a[2].begin[at[2]] + k) * (size_t)v->size[1] +
                                (size_t)(a[1].begin[at[1]] + j)) *
                               (size_t)v->size[0];

            for (int i = 0; i < a[0].taps && wy != 0; i++) {
                uint32_t id;

                if (weights[0][i] == 0)
                    continue;
                id = sc_volume_id(v, row + (size_t)(a[0].begin[at[0]] + i));
                if (!room->seen[id])
                    room->met[met++] = id;
                room->seen[id] = true;
                room->votes[id] += wy * weights[0][i];
            }
        }
    }
    for (size_t i = 0; i < met; i++) {
        const uint32_t id = room->met[i];

        if (best == UINT32_MAX || room->votes[id] > room->votes[best] ||
            (room->votes[id] == room->votes[best] && id < best))
            best = id;
    }
    for (size_t i = 0; i < met; i++) {
        room->votes[room->met[i]] = 0;
        room->seen[room->met[i]] = false;
    }
    return best;
}

/* sc_range_fn: fill the new rows [begin, end), counted through all slices. */
static void fill_rows(void *user, size_t begin, size_t end, int thread)
{
    const vote_work *w = user;
    const vote_axis *a = w->axes;
    const sc_volume *v = w->from;

    for (size_t row = begin; row < end; row++) {
        int at[3] = {0, (int)(row % (size_t)a[1].count), (int)(row / (size_t)a[1].count)};

        for (; at[0] < a[0].count; at[0]++) {
            const int old[3] = {a[0].nearest[at[0]], a[1].nearest[at[1]], a[2].nearest[at[2]]};
            const size_t to = row * (size_t)a[0].count + (size_t)at[0];
            const uint32_t nearest = sc_volume_id(
                v, ((size_t)old[2] * (size_t)v->size[1] + (size_t)old[1]) * (size_t)v->size[0] +
                       (size_t)old[0]);
            uint32_t id = elect(w, &w->rooms[thread], at, false);

            if (id != nearest && w->refines) {
                const double share = share_of(w, old, nearest);

                if (share < THIN_SHARE)
                    id = share < LINE_SHARE ? nearest : elect(w, &w->rooms[thread], at, true);
            }
            if (v->label_bytes == 1)
                ((uint8_t *)w->ids)[to] = (uint8_t)id;
            else
                ((uint16_t *)w->ids)[to] = (uint16_t)id;
        }
    }
}

/* Allocate what the threads work on. */
static sc_status make_rooms(const sc_ctx *ctx, int threads, vote_work *w)
{
    SC_PASS(SC_ZALLOC(ctx, (size_t)threads, &w->rooms));
    for (int i = 0; i < threads; i++) {
        SC_PASS(sc_zalloc(ctx, (size_t)w->from->label_count, sizeof(double), &w->rooms[i].votes));
        SC_PASS(sc_zalloc(ctx, (size_t)w->from->label_count, sizeof(bool), &w->rooms[i].seen));
        SC_PASS(sc_alloc(ctx, (size_t)w->from->label_count, sizeof(uint32_t), &w->rooms[i].met));
    }
    return SC_OK;
}

sc_status sc_resample_votes(const sc_ctx *ctx, sc_volume *volume, const double spacing_mm[3],
                            int threads)
{
    vote_work w = {.from = volume};
    size_t rows = 1;
    sc_status status;

    threads = threads > 1 ? threads : 1;
    for (int i = 0; i < 3; i++) {
        w.axes[i] = place_axis(volume, i, spacing_mm[i]);
        w.refines = w.refines || w.axes[i].step < 1;
        SC_TRY(weigh_axis(ctx, volume->size[i], &w.axes[i]));
        rows *= i ? (size_t)w.axes[i].count : 1;
    }
    SC_TRY(make_rooms(ctx, threads, &w));
    SC_TRY(sc_alloc(ctx, rows * (size_t)w.axes[0].count, (size_t)volume->label_bytes, &w.ids));
    sc_stage_begin(ctx, "resampling", 0, rows);
    sc_stage_for(ctx, rows, threads, rows, 16, fill_rows, &w);
    sc_free(volume->ids);
    volume->ids = w.ids;
    for (int i = 0; i < 3; i++)
        sc_resample_set_axis(volume, i, w.axes[i].count, w.axes[i].first, w.axes[i].step);
out:
    for (int i = 0; i < 3; i++) {
        sc_free(w.axes[i].begin);
        sc_free(w.axes[i].nearest);
        sc_free(w.axes[i].weights);
        sc_free(w.axes[i].linear);
    }
    for (int i = 0; i < threads && w.rooms; i++) {
        sc_free(w.rooms[i].votes);
        sc_free(w.rooms[i].seen);
        sc_free(w.rooms[i].met);
    }
    sc_free(w.rooms);
    return status;
}
