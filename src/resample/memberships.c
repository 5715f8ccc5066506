/* SPDX-License-Identifier: BSD-3-Clause */
/* Gaussians across slices, by taps, on the middles of blocks of pixels; and along the stack. */
#include "memberships.h"

#include <string.h>

/* The least width of a Gaussian in nodes: blocks are as large as this allows. The memberships
 * between nodes, interpolated, are then right to less than a hundredth. */
#define LEAST_WIDTH_NODES 2.0
/* Taps end at so many standard deviations. */
#define TAPS_REACH 3.0

sc_status sc_stack_set_filter(const sc_ctx *ctx, stack *s, double width)
{
    void *block;
    sc_status status = SC_OK;

    s->width = width;
    for (int i = 0; i < 2; i++) {
        const double pixels = width * s->step_mm[2] / s->step_mm[i];
        double nodes, sum = 0;

        s->block[i] = (int)fmax(1, floor(pixels / LEAST_WIDTH_NODES));
        s->nodes[i] = (s->size[i] + s->block[i] - 1) / s->block[i];
        nodes = pixels / s->block[i];
        s->radius[i] = (int)ceil(TAPS_REACH * nodes);
        SC_TRY(sc_alloc(ctx, (size_t)(2 * s->radius[i] + 1), sizeof(float), &block));
        s->taps[i] = block;
        for (int n = -s->radius[i]; n <= s->radius[i]; n++)
            sum += exp(-n * n / (2 * nodes * nodes));
        for (int n = -s->radius[i]; n <= s->radius[i]; n++)
            s->taps[i][n + s->radius[i]] = (float)(exp(-n * n / (2 * nodes * nodes)) / sum);
    }
out:
    return status;
}

void sc_stack_clear(stack *s)
{
    sc_free(s->ids);
    sc_free(s->taps[0]);
    sc_free(s->taps[1]);
    *s = (stack){0};
}

/* ---- boxes ---- */

/* What the threads that look for the boxes of labels share: [threads][label_count] boxes in voxels.
 */
typedef struct box_work {
    const stack *s;
    int label_count;
    sc_label_tally *boxes;
} box_work;

/* Grow the boxes of the labels in the slices [begin, end); an sc_range_fn on box_work. */
static void box_slices(void *user, size_t begin, size_t end, int thread)
{
    const box_work *w = user;
    sc_label_tally *boxes = w->boxes + (size_t)thread * (size_t)w->label_count;
    const int nx = w->s->size[0], ny = w->s->size[1];

    for (int z = (int)begin; z < (int)end; z++) {
        for (int y = 0; y < ny; y++) {
            const uint16_t *row = w->s->ids + ((size_t)z * (size_t)ny + (size_t)y) * (size_t)nx;

            for (int x = 0, last; x < nx; x = last + 1) {
                sc_label_tally *box = &boxes[row[x]];

                for (last = x; last + 1 < nx && row[last + 1] == row[x];)
                    last++;
                if (!box->voxels)
                    *box = (sc_label_tally){0, {x, y, z}, {last, y, z}};
                box->voxels += (uint64_t)(last - x + 1);
                box->low[0] = x < box->low[0] ? x : box->low[0];
                box->low[1] = y < box->low[1] ? y : box->low[1];
                box->low[2] = z < box->low[2] ? z : box->low[2];
                box->high[0] = last > box->high[0] ? last : box->high[0];
                box->high[1] = y > box->high[1] ? y : box->high[1];
                box->high[2] = z > box->high[2] ? z : box->high[2];
            }
        }
    }
}

/* Join the boxes of a label that the threads have found in boxes[id]. */
static void join_boxes(const box_work *w, int threads, int id)
{
    sc_label_tally *all = &w->boxes[id];

    for (int t = 1; t < threads; t++) {
        const sc_label_tally *box = &w->boxes[(size_t)t * (size_t)w->label_count + (size_t)id];

        if (!box->voxels)
            continue;
        if (!all->voxels)
            *all = *box;
        all->voxels += box->voxels;
        for (int i = 0; i < 3; i++) {
            all->low[i] = box->low[i] < all->low[i] ? box->low[i] : all->low[i];
            all->high[i] = box->high[i] > all->high[i] ? box->high[i] : all->high[i];
        }
    }
}

/* @return how many nodes the box is long along an axis, or slices. */
static size_t length_of(const memberships *m, int axis)
{
    return (size_t)m->high[axis] - (size_t)m->low[axis] + 1;
}

/* Set the box of @p m: where the filters across the slices reach from the voxels of its label. At
 * the border of the volume the labels go on outside as they are there. */
static void set_box(const stack *s, const sc_label_tally *box, memberships *m)
{
    for (int i = 0; i < 2; i++) {
        const int reach = GAUSSIANS * s->radius[i];
        const int low = box->low[i] / s->block[i] - reach,
                  high = box->high[i] / s->block[i] + reach;

        m->low[i] = low > 0 ? low : 0;
        m->high[i] = high < s->nodes[i] - 1 ? high : s->nodes[i] - 1;
    }
    m->low[2] = box->low[2];
    m->high[2] = box->high[2];
}

/* ---- smoothing within slices ---- */

/* What the threads that smooth share. */
typedef struct smooth_work {
    const stack *s;
    memberships *m;
    float *scratch; /* [threads][room] */
    size_t room;
} smooth_work;

/* Write to @p out the share of each block of slice @p z in the box that carries the label. */
static void fill_blocks(const stack *s, const memberships *m, int z, float *out)
{
    const int nx = s->size[0], ny = s->size[1];

    for (int j = m->low[1]; j <= m->high[1]; j++) {
        const int y_end = (j + 1) * s->block[1] < ny ? (j + 1) * s->block[1] : ny;

        for (int i = m->low[0]; i <= m->high[0]; i++) {
            const int x_end = (i + 1) * s->block[0] < nx ? (i + 1) * s->block[0] : nx;
            int carry = 0, all = 0;

            for (int y = j * s->block[1]; y < y_end; y++) {
                const uint16_t *row = s->ids + ((size_t)z * (size_t)ny + (size_t)y) * (size_t)nx;

                for (int x = i * s->block[0]; x < x_end; x++)
                    carry += row[x] == m->id;
                all += x_end - i * s->block[0];
            }
            *out++ = (float)carry / (float)all;
        }
    }
}

/* @return node @p n of a line of the box along an axis: beyond the volume that at its border, or -1
 * for one outside of the box, where the membership is 0. */
static int node_within(const stack *s, const memberships *m, int axis, int n)
{
    n = n < 0 ? 0 : n > s->nodes[axis] - 1 ? s->nodes[axis] - 1 : n;
    return n < m->low[axis] || n > m->high[axis] ? -1 : n - m->low[axis];
}

/* Smooth a slice of the box once along x and once along y. @param from, out [y][x]. @param between
 * scratch of the same size. */
static void smooth_slice(const stack *s, const memberships *m, const float *from, float *between,
                         float *out)
{
    const size_t nx = length_of(m, 0), ny = length_of(m, 1);

    memset(between, 0, nx * ny * sizeof *between);
    memset(out, 0, nx * ny * sizeof *out);
    for (size_t y = 0; y < ny; y++) {
        for (int t = -s->radius[1]; t <= s->radius[1]; t++) {
            const int row = node_within(s, m, 1, (int)y + m->low[1] + t);
            const float tap = s->taps[1][t + s->radius[1]];

            for (size_t x = 0; row >= 0 && x < nx; x++)
                between[y * nx + x] += tap * from[(size_t)row * nx + x];
        }
    }
    for (int t = -s->radius[0]; t <= s->radius[0]; t++) {
        const float tap = s->taps[0][t + s->radius[0]];

        for (size_t y = 0; y < ny; y++) {
            const float *row = between + y * nx;
            size_t x = 0;

            for (; x < nx && (int)x + t < 0; x++) {
                const int n = node_within(s, m, 0, (int)x + m->low[0] + t);

                out[y * nx + x] += n < 0 ? 0 : tap * row[n];
            }
            for (; x < nx && (int)x + t < (int)nx; x++)
                out[y * nx + x] += tap * row[(size_t)((int)x + t)];
            for (; x < nx; x++) {
                const int n = node_within(s, m, 0, (int)x + m->low[0] + t);

                out[y * nx + x] += n < 0 ? 0 : tap * row[n];
            }
        }
    }
}

/* Smooth the memberships of a label in the slices [begin, end) of its box; an sc_range_fn. */
static void smooth_slices(void *user, size_t begin, size_t end, int thread)
{
    const smooth_work *w = user;
    const size_t plane = length_of(w->m, 0) * length_of(w->m, 1);
    float *blocks = w->scratch + (size_t)thread * w->room, *between = blocks + plane;

    for (size_t z = begin; z < end; z++) {
        float *values = w->m->values + z * GAUSSIANS * plane;

        fill_blocks(w->s, w->m, w->m->low[2] + (int)z, blocks);
        for (size_t n = 0; n < GAUSSIANS; n++)
            smooth_slice(w->s, w->m, n ? values + (n - 1) * plane : blocks, between,
                         values + n * plane);
    }
}

/* Fill the values of a label whose box is set. @return SC_ERR_MEMORY. */
static sc_status smooth_label(const sc_ctx *ctx, const stack *s, int threads, memberships *m)
{
    const size_t plane = length_of(m, 0) * length_of(m, 1);
    smooth_work w = {.s = s, .m = m, .room = 2 * plane};
    void *block;
    sc_status status;

    SC_TRY(sc_alloc(ctx, length_of(m, 2) * GAUSSIANS * plane, sizeof(float), &block));
    m->values = block;
    SC_TRY(sc_alloc(ctx, (size_t)threads * w.room, sizeof(float), &block));
    w.scratch = block;
    sc_parallel_for(threads, length_of(m, 2), 1, smooth_slices, &w);
out:
    sc_free(w.scratch);
    return status;
}

sc_status sc_memberships_find(const sc_ctx *ctx, const stack *s, int label_count, int threads,
                              memberships **out, int *count)
{
    box_work boxes = {s, label_count, NULL};
    void *block;
    sc_status status;

    *out = NULL;
    *count = 0;
    SC_TRY(sc_zalloc(ctx, (size_t)threads * (size_t)label_count, sizeof *boxes.boxes, &block));
    boxes.boxes = block;
    SC_TRY(sc_zalloc(ctx, (size_t)label_count, sizeof **out, &block));
    *out = block;
    sc_parallel_for(threads, (size_t)s->size[2], 1, box_slices, &boxes);
    for (int id = 1; id < label_count; id++) {
        memberships *m = &(*out)[*count];

        join_boxes(&boxes, threads, id);
        if (!boxes.boxes[id].voxels)
            continue;
        m->id = id;
        set_box(s, &boxes.boxes[id], m);
        (*count)++;
        SC_TRY(smooth_label(ctx, s, threads, m));
    }
out:
    sc_free(boxes.boxes);
    return status;
}

void sc_memberships_free(memberships *all, int count)
{
    for (int i = 0; i < count; i++)
        sc_free(all[i].values);
    sc_free(all);
}

/* ---- along the stack ---- */

plane_taps sc_plane_taps_of(const stack *s, double offset)
{
    static const double share[GAUSSIANS] = {4, -6, 4, -1};
    plane_taps taps;

    for (int n = 0; n < GAUSSIANS; n++) {
        const double square = s->width * s->width * (n + 1);
        double value[2 * SLICE_REACH + 1], sum = 0;

        for (int i = -SLICE_REACH; i <= SLICE_REACH; i++)
            sum += value[i + SLICE_REACH] = exp(-(i - offset) * (i - offset) / (2 * square));
        for (int i = 0; i <= 2 * SLICE_REACH; i++)
            taps.weight[n][i] = (float)(share[n] * value[i] / sum);
    }
    return taps;
}

void sc_memberships_in_plane(const memberships *m, const stack *s, const plane_taps *taps, int z,
                             float *out)
{
    const size_t plane = length_of(m, 0) * length_of(m, 1);

    memset(out, 0, plane * sizeof *out);
    for (int i = -SLICE_REACH; i <= SLICE_REACH; i++) {
        const int slice = z + i < 0 ? 0 : z + i > s->size[2] - 1 ? s->size[2] - 1 : z + i;

        if (slice < m->low[2] || slice > m->high[2])
            continue;
        for (int n = 0; n < GAUSSIANS; n++) {
            const float weight = taps->weight[n][i + SLICE_REACH];
            const float *values =
                m->values + ((size_t)(slice - m->low[2]) * GAUSSIANS + (size_t)n) * plane;

            for (size_t at = 0; at < plane; at++)
                out[at] += weight * values[at];
        }
    }
}
