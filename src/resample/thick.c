/* SPDX-License-Identifier: BSD-3-Clause */
/* Layers between thick slices, by shape-based interpolation (Raya and Udupa, Shape-Based
 * Interpolation of Multidimensional Objects, 1990): of each label the signed distances from its
 * border within the slices are interpolated, and a voxel gets the label in which it lies deepest.
 * So a tilted plane comes back as one, and not as stairs. The slices themselves stay as they are.
 * Distances are interpolated by cubic Hermite splines over four slices, as borders are curved.
 * Where a part of a label ends between two slices, the other slice tells nothing of it: it may hold
 * another part of the label, far away, or none. So the distance there is limited to what the slices
 * before let expect: spline.h. Thin walls that move sideways are kept: walls.h. Sheets one voxel
 * thick are closed afterwards.
 * A slice also stands for half the way to where the next would be, beyond the first and the last:
 * there the distances go on as between the last two slices.
 * Each label costs time in all of its box. Labels scattered over the slices, as no tissue is, would
 * cost that of all labels in all voxels, so that the sum of all boxes is limited: beyond that, the
 * labels that fill the least of their boxes are copied from the nearer slice instead. */
#include "distances.h"
#include "internal.h"
#include "spline.h"
#include "walls.h"

#include <stdlib.h>

enum {
    BOXES_MAX = 48,           /* of the sum of all boxes, in volumes of the stack */
    GAPS = 8,                 /* between slices, which are filled at a time */
    SLOTS = GAPS + AROUND - 1 /* slices whose distances are held at a time */
};

/* The work on a stack. */
typedef struct thick_work {
    const stack *s;
    distances d;
    int gap, gaps;  /* which are being filled: gap z lies between slices z and z + 1 */
    bool *copied;   /* [label_count]: the label is copied, not interpolated; NULL: none is */
    uint8_t *sheet; /* [z][y][x] 1 for voxels of sheets one voxel thick */
    int split;      /* layers of a slice */
    void *out;      /* ids of out_bytes each */
    int out_bytes;
    size_t stride[3]; /* in out, in voxels, of x, y and a layer */
    float *least;     /* [threads][y][x] scratch: the least distance of all labels */
    uint32_t *winner; /* [threads][y][x] scratch: the label to which it belongs */
    float *open;      /* [threads][y][x] scratch: for walls */
    size_t pixels;    /* of a slice */
} thick_work;

/* Let a label contend for the pixels of row @p y of a layer @p t slices beyond the slice @p end,
 * the first or the last of at least two. @param least, winner of the first pixel of the label's
 * box. */
static void contend_beyond(const thick_work *w, const label_box *box, int end, float t, int y,
                           float *least, uint32_t *winner)
{
    const int nx = box->high[0] - box->low[0] + 1;
    const float *here = sc_distances_row(&w->d, box, end, y);
    const float *before = sc_distances_row(&w->d, box, end > 0 ? end - 1 : 1, y);

    for (int x = 0; x < nx; x++) {
        const float distance = extrapolate(before[x], here[x], t);
        const bool wins = distance < least[x];

        least[x] = wins ? distance : least[x];
        winner[x] = wins ? (uint32_t)box->id : winner[x];
    }
}

/* Let a label contend for the pixels of row @p y of a layer behind slice @p z. @param least, winner
 * of the first pixel of the label's box. */
static void contend_in_row(const thick_work *w, const label_box *box, const blend *layer, int z,
                           int y, float *least, uint32_t *winner)
{
    const uint32_t id = (uint32_t)box->id;
    const int nx = box->high[0] - box->low[0] + 1;
    const float *rows[AROUND];

    rows_around(&w->d, box, z, y, rows);
    for (int x = 0; x < nx; x++) {
        const float distance = interpolate(rows[0][x], rows[1][x], rows[2][x], rows[3][x], layer);
        const bool wins = distance < least[x];

        least[x] = wins ? distance : least[x];
        winner[x] = wins ? id : winner[x];
    }
}

/* Find the label of each pixel of a layer behind slice @p z: the one in which it lies deepest, or a
 * wall that passes over it. @param nearer the slice from which labels are copied. */
static void find_winners(const thick_work *w, const blend *layer, int z, int nearer, int thread)
{
    float *least = w->least + (size_t)thread * w->pixels;
    uint32_t *winner = w->winner + (size_t)thread * w->pixels;
    const uint16_t *ids = w->s->ids + (size_t)nearer * w->pixels;

    for (size_t at = 0; at < w->pixels; at++)
        least[at] = HUGE_VALF;
    for (int n = 0; n < w->d.count; n++) {
        const label_box *box = &w->d.boxes[n];

        if (z + 1 < box->low[2] || z > box->high[2])
            continue;
        for (int y = box->low[1]; y <= box->high[1]; y++) {
            const size_t row = (size_t)y * (size_t)w->s->size[0] + (size_t)box->low[0];

            contend_in_row(w, box, layer, z, y, least + row, winner + row);
        }
    }
    sc_walls_keep(&w->d, layer, z, least, w->open + (size_t)thread * w->pixels, winner);
    for (size_t at = 0; at < w->pixels && w->copied; at++)
        winner[at] = w->copied[ids[at]] ? ids[at] : winner[at];
}

/* Write the ids of a layer to layer @p layer of the result. */
static void store_layer(const thick_work *w, const uint32_t *ids, size_t layer)
{
    const size_t nx = (size_t)w->s->size[0];

    for (size_t at = 0; at < w->pixels; at++) {
        const size_t to = at % nx * w->stride[0] + at / nx * w->stride[1] + layer * w->stride[2];

        if (w->out_bytes == 1)
            ((uint8_t *)w->out)[to] = (uint8_t)ids[at];
        else
            ((uint16_t *)w->out)[to] = (uint16_t)ids[at];
    }
}

/* Write the labels of a voxel of the stack and of its neighbours to @p ids; background outside. */
static void fetch_around(const stack *s, int x, int y, int z, uint32_t ids[SC_AROUND])
{
    for (int i = 0; i < SC_AROUND; i++) {
        const int at[3] = {x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1};
        bool inside = true;

        for (int axis = 0; axis < 3; axis++)
            inside = inside && at[axis] >= 0 && at[axis] < s->size[axis];
        ids[i] =
            inside
                ? s->ids[((size_t)at[2] * (size_t)s->size[1] + (size_t)at[1]) * (size_t)s->size[0] +
                         (size_t)at[0]]
                : 0;
    }
}

/* Does a voxel of tissue belong to a sheet one voxel thick? */
static bool is_sheet(const stack *s, int x, int y, int z)
{
    static const int faces[6] = {4, 10, 12, 14, 16, 22};
    uint32_t ids[SC_AROUND];
    int others = 0;

    fetch_around(s, x, y, z, ids);
    for (int i = 0; i < 6 && ids[SC_AROUND_CENTRE]; i++)
        others += ids[faces[i]] != ids[SC_AROUND_CENTRE];
    return others > 1 && sc_sheet_keeps_apart(ids);
}

/* Fill w->sheet of the slices [begin, end); an sc_range_fn on thick_work. */
static void find_sheets(void *user, size_t begin, size_t end, int thread)
{
    const thick_work *w = user;
    const stack *s = w->s;

    for (int z = (int)begin; z < (int)end; z++) {
        for (int y = 0; y < s->size[1]; y++) {
            for (int x = 0; x < s->size[0]; x++) {
                const size_t at =
                    (size_t)z * w->pixels + (size_t)y * (size_t)s->size[0] + (size_t)x;

                w->sheet[at] = s->ids[at] && is_sheet(s, x, y, z);
            }
        }
    }
}

/* @return whether a voxel of a sheet lies in slice @p z or the next one, at most one pixel away. */
static bool is_beside_sheet(const thick_work *w, int x, int y, int z)
{
    const int *size = w->s->size;

    for (int k = z; k <= z + 1; k++) {
        for (int j = y > 0 ? y - 1 : 0; j <= y + 1 && j < size[1]; j++) {
            for (int i = x > 0 ? x - 1 : 0; i <= x + 1 && i < size[0]; i++) {
                if (w->sheet[(size_t)k * w->pixels + (size_t)j * (size_t)size[0] + (size_t)i])
                    return true;
            }
        }
    }
    return false;
}

/* A pixel of a layer, in the slices below and above it. */
typedef struct column {
    uint32_t id[2];
    bool sheet[2]; /* the voxel belongs to a sheet */
} column;

static inline column column_at(const thick_work *w, int z, size_t at)
{
    const size_t below = (size_t)z * w->pixels + at, above = below + w->pixels;

    return (column){{w->s->ids[below], w->s->ids[above]}, {w->sheet[below], w->sheet[above]}};
}

/* The ids of a layer while its sheets are being closed: the low half of each word is the one that
 * was interpolated, the high half the one that takes its place. */
#define INTERPOLATED 0xffffu
#define REPLACED_SHIFT 16

/* @return whether a pixel that carries @p own in a layer, but the sheet @p sheet in one of the
 * slices, leaves a gap in the sheet beside its neighbour, of label @p id. There is none if they
 * touch in the other slice too: there the sheet has ended. @param side in which of the slices. */
static bool leaves_gap(const thick_work *w, int z, uint32_t own, uint32_t sheet, int side,
                       size_t neighbour, uint32_t id)
{
    const uint32_t other = column_at(w, z, neighbour).id[1 - side];

    if (id == sheet)
        return false;
    return id == own ? other == sheet : other != id;
}

/* @return the label that closes the sheets round pixel (@p x, @p y) of a layer behind slice @p z,
 * or its own. */
static uint32_t closing_label(const thick_work *w, int x, int y, int z, const uint32_t *ids)
{
    const int nx = w->s->size[0], ny = w->s->size[1];
    const size_t at = (size_t)y * (size_t)nx + (size_t)x;
    const column c = column_at(w, z, at);
    const uint32_t own = ids[at] & INTERPOLATED;
    const bool inside[4] = {x > 0, x + 1 < nx, y > 0, y + 1 < ny};
    const ptrdiff_t steps[4] = {-1, 1, -nx, nx};

    for (int side = 0; side < 2; side++) {
        if (!c.sheet[side] || own == c.id[side] || c.sheet[1 - side])
            continue;
        for (int i = 0; i < 4; i++) {
            const size_t neighbour = (size_t)((ptrdiff_t)at + steps[i]);

            if (inside[i] &&
                leaves_gap(w, z, own, c.id[side], side, neighbour, ids[neighbour] & INTERPOLATED))
                return c.id[side];
        }
    }
    return own;
}

/* Keep sheets one voxel thick closed in a layer @p t slices behind slice @p z. Beside them a pixel
 * keeps one of the labels that it has in the slices, so that a way up or down leads through none
 * but those of the file. Where two pixels side by side have different labels, and one of them
 * carries the sheet in a slice, it carries it here too. */
static void keep_sheets(const thick_work *w, int z, double t, uint32_t *ids)
{
    const int nx = w->s->size[0], ny = w->s->size[1];

    for (size_t at = 0; at < w->pixels; at++) {
        const column c = column_at(w, z, at);

        if (ids[at] != c.id[0] && ids[at] != c.id[1] &&
            is_beside_sheet(w, (int)(at % (size_t)nx), (int)(at / (size_t)nx), z))
            ids[at] = c.id[t > 0.5];
    }
    for (int y = 0; y < ny; y++) {
        for (int x = 0; x < nx; x++)
            ids[(size_t)y * (size_t)nx + (size_t)x] |= closing_label(w, x, y, z, ids)
                                                       << REPLACED_SHIFT;
    }
    for (size_t at = 0; at < w->pixels; at++)
        ids[at] >>= REPLACED_SHIFT;
}

/* Fill the layers numbered [begin, end) of those in the current gaps; an sc_range_fn on thick_work.
 */
static void fill_gaps(void *user, size_t begin, size_t end, int thread)
{
    const thick_work *w = user;
    const size_t layers = (size_t)w->split - 1;
    uint32_t *winner = w->winner + (size_t)thread * w->pixels;

    for (size_t n = begin; n < end; n++) {
        const int z = w->gap + (int)(n / layers), step = (int)(n % layers) + 1;
        const blend layer = blend_at((float)step / (float)w->split);

        find_winners(w, &layer, z, z + (2 * step > w->split), thread);
        keep_sheets(w, z, (double)step / w->split, winner);
        store_layer(w, winner, (size_t)z * (size_t)w->split + (size_t)(w->split / 2 + step));
    }
}

/* Fill the layers numbered [begin, end) of those beyond slice w->gap, the first or the last one; an
 * sc_range_fn on thick_work. Beside sheets one voxel thick, and of labels that are copied, they are
 * as that slice. */
static void fill_end(void *user, size_t begin, size_t end, int thread)
{
    const thick_work *w = user;
    const int nx = w->s->size[0], last = w->s->size[2] - 1;
    const uint16_t *ids = w->s->ids + (size_t)w->gap * w->pixels;
    float *least = w->least + (size_t)thread * w->pixels;
    uint32_t *winner = w->winner + (size_t)thread * w->pixels;

    for (size_t n = begin; n < end; n++) {
        const int step = (int)n + 1, middle = w->gap * w->split + w->split / 2;

        for (size_t at = 0; at < w->pixels; at++)
            least[at] = HUGE_VALF;
        for (int i = 0; i < w->d.count; i++) {
            const label_box *box = &w->d.boxes[i];

            if (w->gap < box->low[2] || w->gap > box->high[2])
                continue;
            for (int y = box->low[1]; y <= box->high[1]; y++) {
                const size_t row = (size_t)y * (size_t)nx + (size_t)box->low[0];

                contend_beyond(w, box, w->gap, (float)step / (float)w->split, y, least + row,
                               winner + row);
            }
        }
        for (size_t at = 0; at < w->pixels; at++) {
            const bool copied = w->copied && w->copied[ids[at]];

            if (winner[at] != ids[at] &&
                (copied || is_beside_sheet(w, (int)(at % (size_t)nx), (int)(at / (size_t)nx),
                                           w->gap > 0 ? last - 1 : 0)))
                winner[at] = ids[at];
        }
        store_layer(w, winner, (size_t)(w->gap > 0 ? middle + step : middle - step));
    }
}

/* Copy the slices [begin, end) to their layers, a single one also to those outside of it; an
 * sc_range_fn on thick_work. */
static void copy_slices(void *user, size_t begin, size_t end, int thread)
{
    const thick_work *w = user;
    const size_t split = (size_t)w->split, slices = (size_t)w->s->size[2];
    uint32_t *ids = w->winner + (size_t)thread * w->pixels;

    for (size_t z = begin; z < end; z++) {
        const size_t first = z * split + (slices > 1 ? split / 2 : 0);
        const size_t last = z * split + (slices > 1 ? split / 2 : split - 1);

        for (size_t at = 0; at < w->pixels; at++)
            ids[at] = w->s->ids[z * w->pixels + at];
        for (size_t layer = first; layer <= last; layer++)
            store_layer(w, ids, layer);
    }
}

/* Fill all layers, a few gaps at a time. */
static void fill_layers(thick_work *w, int threads)
{
    const int slices = w->s->size[2];
    const size_t beyond = (size_t)w->split / 2; /* layers beyond the first slice, or the last */

    sc_parallel_for(threads, (size_t)slices, 1, find_sheets, w);
    sc_parallel_for(threads, (size_t)slices, 1, copy_slices, w);
    for (w->gap = 0; w->gap < slices - 1; w->gap += w->gaps) {
        const int end = w->gap + GAPS < slices - 1 ? w->gap + GAPS : slices - 1;

        w->gaps = end - w->gap;
        sc_distances_measure(&w->d, end + 2 < slices ? end + 2 : slices);
        if (w->gap == 0)
            sc_parallel_for(threads, beyond, 1, fill_end, w);
        sc_parallel_for(threads, (size_t)w->gaps * (size_t)(w->split - 1), 1, fill_gaps, w);
    }
    w->gap = slices - 1;
    if (slices > 1)
        sc_parallel_for(threads, beyond, 1, fill_end, w);
}

/* The axes of a volume in the order of those of its stack of slices across one of them. */
typedef struct axes {
    int of[3];
} axes;

static axes axes_across(int axis)
{
    return (axes){{axis == 0, axis == 2 ? 1 : 2, axis}};
}

/* @return a stack without ids, the volume with @p axis last. */
static stack stack_of(const sc_volume *v, int axis)
{
    const axes order = axes_across(axis);
    const double distance_mm = sc_vec3_length(sc_affine_column(&v->to_ras_mm, axis));
    stack s = {.ids = NULL};

    for (int i = 0; i < 3; i++)
        s.size[i] = v->size[order.of[i]];
    for (int i = 0; i < 2; i++) {
        const sc_vec3 width = sc_affine_column(&v->to_ras_mm, order.of[i]);

        s.step[i] = (float)(sc_vec3_length(width) / distance_mm);
    }
    return s;
}

/* @return a box of a volume along the axes of its stack. */
static sc_label_tally turned_box(const sc_label_tally *box, int axis)
{
    const axes order = axes_across(axis);
    sc_label_tally turned = {.voxels = box->voxels};

    for (int i = 0; i < 3; i++) {
        turned.low[i] = box->low[order.of[i]];
        turned.high[i] = box->high[order.of[i]];
    }
    return turned;
}

/* How much of the box around it a label fills. */
typedef struct filling {
    int id;
    double box, share; /* voxels of the box with its margin; what part of them the label has */
} filling;

/* For qsort: those that fill the least first. */
static int compare_fillings(const void *a, const void *b)
{
    const filling *one = a, *other = b;

    if (one->share != other->share)
        return one->share < other->share ? -1 : 1;
    return one->id < other->id ? -1 : 1;
}

/* If the boxes are too large in all, mark labels to be copied in *copied, which is made for that,
 * and set their numbers of voxels to 0. @return SC_ERR_MEMORY. Caller owns *copied: sc_free. */
static sc_status leave_out_scattered(const sc_ctx *ctx, const stack *s, int label_count,
                                     sc_label_tally *boxes, bool **copied)
{
    const double most = (double)BOXES_MAX * s->size[0] * s->size[1] * s->size[2];
    double sum = 0;
    int count = 0, left_out = 0;
    SC_OWN(sc_free_at) filling *all = NULL;

    SC_PASS(SC_ALLOC(ctx, (size_t)label_count, &all));
    for (int id = 0; id < label_count; id++) {
        double box;

        if (!boxes[id].voxels)
            continue;
        box = sc_distances_bytes(s, &boxes[id], 1, 1, 0) / sizeof(float) *
              (boxes[id].high[2] - boxes[id].low[2] + 1);
        all[count++] = (filling){id, box, (double)boxes[id].voxels / box};
        sum += box;
    }
    if (sum <= most)
        return SC_OK;
    SC_PASS(SC_ZALLOC(ctx, (size_t)label_count, copied));
    qsort(all, (size_t)count, sizeof *all, compare_fillings);
    while (sum > most && left_out < count) {
        sum -= all[left_out].box;
        (*copied)[all[left_out].id] = true;
        boxes[all[left_out++].id].voxels = 0;
    }
    sc_warn(ctx,
            "%d of %d labels are scattered over the slices; between slices they are copied, not "
            "interpolated",
            left_out, count);
    return SC_OK;
}

/* Fill the ids of a stack. @return SC_ERR_MEMORY. */
static sc_status fill_stack(const sc_ctx *ctx, const sc_volume *v, int axis, stack *s)
{
    const size_t strides[3] = {1, (size_t)v->size[0], (size_t)v->size[0] * (size_t)v->size[1]};
    const axes order = axes_across(axis);
    uint16_t *to;

    SC_PASS(SC_ALLOC(ctx, sc_volume_voxels(v), &to));
    s->ids = to;
    for (size_t z = 0; z < (size_t)s->size[2]; z++) {
        for (size_t y = 0; y < (size_t)s->size[1]; y++) {
            for (size_t x = 0; x < (size_t)s->size[0]; x++)
                *to++ =
                    (uint16_t)sc_volume_id(v, x * strides[order.of[0]] + y * strides[order.of[1]] +
                                                  z * strides[order.of[2]]);
        }
    }
    return SC_OK;
}

/* Set where the result is written: a volume like @p v with more planes along @p axis. */
static void set_strides(const sc_volume *v, int axis, int split, thick_work *w)
{
    const axes order = axes_across(axis);
    size_t strides[3] = {1, 1, 1};

    for (int i = 1; i < 3; i++)
        strides[i] = strides[i - 1] * (size_t)v->size[i - 1] * (size_t)(i - 1 == axis ? split : 1);
    for (int i = 0; i < 3; i++)
        w->stride[i] = strides[order.of[i]];
}

sc_status sc_resample_split_slices(const sc_ctx *ctx, sc_volume *v, int axis, int split,
                                   int threads)
{
    stack s = stack_of(v, axis);
    sc_label_tally *boxes = NULL;
    thick_work w = {.s = &s, .split = split, .out_bytes = v->label_bytes};
    sc_status status;

    w.pixels = (size_t)s.size[0] * (size_t)s.size[1];
    SC_TRY(fill_stack(ctx, v, axis, &s));
    SC_TRY(sc_resample_find_boxes(ctx, v, threads, &boxes));
    for (int id = 0; id < v->label_count; id++)
        boxes[id] = turned_box(&boxes[id], axis);
    SC_TRY(leave_out_scattered(ctx, &s, v->label_count, boxes, &w.copied));
    SC_TRY(sc_distances_open(ctx, &s, boxes, v->label_count, SLOTS, threads, &w.d));
    SC_TRY(sc_alloc(ctx, sc_volume_voxels(v), 1, &w.sheet));
    SC_TRY(SC_ALLOC(ctx, (size_t)threads * w.pixels, &w.least));
    SC_TRY(SC_ALLOC(ctx, (size_t)threads * w.pixels, &w.winner));
    SC_TRY(SC_ALLOC(ctx, (size_t)threads * w.pixels, &w.open));
    SC_TRY(sc_alloc(ctx, sc_volume_voxels(v), (size_t)split * (size_t)v->label_bytes, &w.out));
    set_strides(v, axis, split, &w);
    fill_layers(&w, threads);
    sc_resample_set_planes(v, w.out, axis, v->size[axis] * split, 0.5 / split - 0.5, 1.0 / split);
out:
    sc_distances_clear(&w.d);
    sc_free(boxes);
    sc_free(s.ids);
    sc_free(w.copied);
    sc_free(w.sheet);
    sc_free(w.least);
    sc_free(w.winner);
    sc_free(w.open);
    return status;
}

double sc_resample_split_bytes(const sc_volume *v, const sc_label_tally *boxes, int axis,
                               int threads)
{
    const stack s = stack_of(v, axis);
    const double pixels = (double)s.size[0] * s.size[1];
    double bytes = pixels * s.size[2] * (sizeof *s.ids + 1); /* and the marks of sheets */

    for (int id = 0; id < v->label_count; id++) {
        const sc_label_tally box = turned_box(&boxes[id], axis);

        bytes += sc_distances_bytes(&s, &box, 1, SLOTS, 0);
    }
    return bytes + threads * (pixels * (2 * sizeof(float) + sizeof(uint32_t)) +
                              3.0 * s.size[0] * sizeof(float));
}
