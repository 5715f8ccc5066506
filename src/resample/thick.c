/* SPDX-License-Identifier: BSD-3-Clause */
/* Layers between thick slices. Their voxels get the label whose membership, smoothed as far in
 * every direction as the slices are apart, is the largest; so a tilted plane comes back as one, and
 * not as stairs. Within a slice nothing is changed: where the smoothed memberships would give a
 * voxel another label than its own, that of its own is raised by twice what it lacks, and in the
 * layers around by less and less down to nothing at the next slice. So tissue that is too thin for
 * the filter lives on, up to half of the way to the next slices, as it would if voxels were copied.
 * Sheets one voxel thick would still be torn where one slice passes on to the next, so beside them
 * layers are copied from their slice. */
#include "internal.h"
#include "memberships.h"

#include <string.h>

/* Standard deviation of the Gaussian, in distances of slices. */
#define WIDTH 0.8
/* A voxel's code is how much its own label lacks, in steps of 1 / CODES_PER_UNIT; 0: nothing. */
#define CODES_PER_UNIT 160.0f

/* The work on a stack. */
typedef struct thick_work {
    const stack *s;
    const memberships *labels; /* [count] */
    int count;
    uint8_t *lack;  /* [z][y][x] codes */
    uint8_t *sheet; /* [z][y][x] 1 for voxels of sheets one voxel thick */
    int split;      /* layers of a slice */
    void *out;      /* ids of out_bytes each */
    int out_bytes;
    size_t stride[3]; /* in out, in voxels, of x, y and a layer */
    float *scratch;   /* [threads][room] */
    size_t room, pixels;
} thick_work;

/* A plane of the stack, and what a thread knows of it. */
typedef struct plane {
    plane_taps taps;
    int z;                  /* the slice that it belongs to */
    const uint16_t *ids[2]; /* of the slices below and above it, [y][x] */
    const uint8_t *lack[2];
    float share[2];    /* how much of their lack is made up for here */
    float *nodes;      /* memberships of one label */
    float *line;       /* [nodes x] */
    float *best, *sum; /* [y][x]: the largest membership; that of all but background */
    float *own;        /* [y][x]: that of the label in ids[0] */
    uint16_t *winner;  /* [y][x] */
} plane;

/* @return how much the label @p id is raised at pixel @p at of a plane. */
static inline float raise_of(const plane *p, size_t at, int id)
{
    float raise = 0;

    for (int i = 0; i < 2; i++) {
        if (p->lack[i] && p->lack[i][at] && p->ids[i][at] == id)
            raise += p->share[i] * 2 * (float)p->lack[i][at] / CODES_PER_UNIT;
    }
    return raise;
}

/* @return where the middle of pixel @p n lies among the nodes of a line, within the first and the
 * last. */
static double node_of(const stack *s, int axis, int n)
{
    return fmin(fmax((n + 0.5) / s->block[axis] - 0.5, 0), s->nodes[axis] - 1);
}

/* Interpolate the memberships of the box of @p m between the two rows of nodes around pixel row @p
 * y.
 * @return false if the row is beyond the box. */
static bool interpolate_rows(const thick_work *w, const memberships *m, plane *p, int y)
{
    const double at = node_of(w->s, 1, y);
    const int row = (int)at, width = m->high[0] - m->low[0] + 1;
    const float part = (float)(at - row);
    const bool has_first = row >= m->low[1] && row <= m->high[1];
    const bool has_second = row + 1 >= m->low[1] && row + 1 <= m->high[1] && part > 0;
    const float *first = p->nodes + (ptrdiff_t)(row - m->low[1]) * width, *second = first + width;

    if (!has_first && !has_second)
        return false;
    for (int i = 0; i < width; i++)
        p->line[i] = (has_first ? (1 - part) * first[i] : 0) + (has_second ? part * second[i] : 0);
    return true;
}

/* Let a label, whose memberships are in p->nodes, contend for the pixels of row @p y. */
static void contend_in_row(const thick_work *w, const memberships *m, plane *p, int y)
{
    const stack *s = w->s;
    const int block = s->block[0], width = m->high[0] - m->low[0] + 1;
    const int begin = m->low[0] * block - block, end = (m->high[0] + 2) * block;
    const size_t row = (size_t)y * (size_t)s->size[0];

    for (int x = begin < 0 ? 0 : begin; x < end && x < s->size[0]; x++) {
        const double at = node_of(s, 0, x);
        const int node = (int)at - m->low[0];
        const float part = (float)(at - (int)at), a = node >= 0 && node < width ? p->line[node] : 0;
        const float b = node + 1 >= 0 && node + 1 < width ? p->line[node + 1] : 0;
        float value = a + part * (b - a);

        p->sum[row + (size_t)x] += value;
        if (p->ids[0][row + (size_t)x] == m->id)
            p->own[row + (size_t)x] = value;
        value += raise_of(p, row + (size_t)x, m->id);
        if (value > p->best[row + (size_t)x]) {
            p->best[row + (size_t)x] = value;
            p->winner[row + (size_t)x] = (uint16_t)m->id;
        }
    }
}

/* Find the label with the largest membership for each pixel of a plane: p->winner and p->best. */
static void find_winners(const thick_work *w, plane *p)
{
    const stack *s = w->s;

    for (size_t at = 0; at < w->pixels; at++) {
        p->best[at] = -1e9f;
        p->sum[at] = p->own[at] = 0;
        p->winner[at] = 0;
    }
    for (int n = 0; n < w->count; n++) {
        const memberships *m = &w->labels[n];

        if (p->z < m->low[2] - SLICE_REACH || p->z > m->high[2] + SLICE_REACH)
            continue;
        sc_memberships_in_plane(m, s, &p->taps, p->z, p->nodes);
        for (int y = 0; y < s->size[1]; y++) {
            if (interpolate_rows(w, m, p, y))
                contend_in_row(w, m, p, y);
        }
    }
    for (size_t at = 0; at < w->pixels; at++) {
        const float background = 1 - p->sum[at] + raise_of(p, at, 0);

        if (p->ids[0][at] == 0)
            p->own[at] = background;
        if (background > p->best[at]) {
            p->best[at] = background;
            p->winner[at] = 0;
        }
    }
}

/* @return a plane with the scratch memory of a thread. */
static plane plane_of_thread(const thick_work *w, int thread)
{
    float *scratch = w->scratch + (size_t)thread * w->room;
    plane p = {.nodes = scratch};

    p.line = p.nodes + (size_t)w->s->nodes[0] * (size_t)w->s->nodes[1];
    p.best = p.line + w->s->nodes[0];
    p.sum = p.best + w->pixels;
    p.own = p.sum + w->pixels;
    p.winner = (uint16_t *)(void *)(p.own + w->pixels);
    return p;
}

/* Note in w->lack what the voxels of the slices [begin, end) lack; an sc_range_fn on thick_work. */
static void find_lack(void *user, size_t begin, size_t end, int thread)
{
    const thick_work *w = user;
    plane p = plane_of_thread(w, thread);

    p.taps = sc_plane_taps_of(w->s, 0);
    for (size_t z = begin; z < end; z++) {
        uint8_t *lack = w->lack + z * w->pixels;

        p.z = (int)z;
        p.ids[0] = w->s->ids + z * w->pixels;
        find_winners(w, &p);
        for (size_t at = 0; at < w->pixels; at++) {
            const float code = CODES_PER_UNIT * (p.best[at] - p.own[at]);

            lack[at] = p.winner[at] == p.ids[0][at] ? 0 : code < 254 ? (uint8_t)(code + 1) : 255;
        }
    }
}

/* Set what a plane of the slice @p z, @p offset slices behind it, has of that slice and of the next
 * one on the side of the offset. */
static void set_plane(const thick_work *w, plane *p, int z, double offset)
{
    const int next = z + (offset < 0 ? -1 : 1);
    const bool has_next = next >= 0 && next < w->s->size[2];

    p->taps = sc_plane_taps_of(w->s, offset);
    p->z = z;
    p->ids[0] = w->s->ids + (size_t)z * w->pixels;
    p->lack[0] = w->lack + (size_t)z * w->pixels;
    p->share[0] = 1 - (float)fabs(offset);
    p->ids[1] = has_next ? w->s->ids + (size_t)next * w->pixels : NULL;
    p->lack[1] = has_next ? w->lack + (size_t)next * w->pixels : NULL;
    p->share[1] = (float)fabs(offset);
}

/* Write the winners of a plane to layer @p layer of the result. */
static void store_layer(const thick_work *w, const plane *p, size_t layer)
{
    const size_t nx = (size_t)w->s->size[0];

    for (size_t at = 0; at < w->pixels; at++) {
        const size_t to = at % nx * w->stride[0] + at / nx * w->stride[1] + layer * w->stride[2];

        if (w->out_bytes == 1)
            ((uint8_t *)w->out)[to] = (uint8_t)p->winner[at];
        else
            ((uint16_t *)w->out)[to] = p->winner[at];
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

    (void)thread;
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

/* @return whether a voxel at most one pixel and one slice away from (x, y, z) belongs to a sheet.
 */
static bool is_beside_sheet(const thick_work *w, int x, int y, int z)
{
    const int *size = w->s->size;

    for (int k = z > 0 ? z - 1 : 0; k <= z + 1 && k < size[2]; k++) {
        for (int j = y > 0 ? y - 1 : 0; j <= y + 1 && j < size[1]; j++) {
            for (int i = x > 0 ? x - 1 : 0; i <= x + 1 && i < size[0]; i++) {
                if (w->sheet[(size_t)k * w->pixels + (size_t)j * (size_t)size[0] + (size_t)i])
                    return true;
            }
        }
    }
    return false;
}

/* Give the pixels of a plane that lie beside a sheet, or in it, the labels of its slice. */
static void copy_sheets(const thick_work *w, plane *p)
{
    const int nx = w->s->size[0];

    for (size_t at = 0; at < w->pixels; at++) {
        if (p->winner[at] != p->ids[0][at] &&
            is_beside_sheet(w, (int)(at % (size_t)nx), (int)(at / (size_t)nx), p->z))
            p->winner[at] = p->ids[0][at];
    }
}

/* Fill the layers of the slices [begin, end); an sc_range_fn on thick_work. */
static void fill_layers(void *user, size_t begin, size_t end, int thread)
{
    const thick_work *w = user;
    plane p = plane_of_thread(w, thread);

    for (size_t z = begin; z < end; z++) {
        for (int layer = 0; layer < w->split; layer++) {
            const int from_middle = layer - w->split / 2;

            set_plane(w, &p, (int)z, (double)from_middle / w->split);
            find_winners(w, &p);
            copy_sheets(w, &p);
            store_layer(w, &p, z * (size_t)w->split + (size_t)layer);
        }
    }
}

/* Fill size, steps and ids of a stack: the volume with @p axis last. @param stride receives the
 * distance of neighbours along the stack's axes in the volume, in voxels. @return SC_ERR_MEMORY. */
static sc_status make_stack(const sc_ctx *ctx, const sc_volume *v, int axis, stack *s)
{
    const size_t strides[3] = {1, (size_t)v->size[0], (size_t)v->size[0] * (size_t)v->size[1]};
    const int order[3] = {axis == 0, axis == 2 ? 1 : 2, axis};
    void *block;
    sc_status status = sc_alloc(ctx, sc_volume_voxels(v), sizeof *s->ids, &block);
    uint16_t *to = block;

    if (status != SC_OK)
        return status;
    s->ids = block;
    for (int i = 0; i < 3; i++) {
        s->size[i] = v->size[order[i]];
        s->step_mm[i] = sc_vec3_length(sc_affine_column(&v->to_ras_mm, order[i]));
    }
    for (size_t z = 0; z < (size_t)s->size[2]; z++) {
        for (size_t y = 0; y < (size_t)s->size[1]; y++) {
            for (size_t x = 0; x < (size_t)s->size[0]; x++)
                *to++ = (uint16_t)id_of_voxel(v, x * strides[order[0]] + y * strides[order[1]] +
                                                     z * strides[order[2]]);
        }
    }
    return SC_OK;
}

/* Set where the result is written: a volume like @p v with more planes along @p axis. */
static void set_strides(const sc_volume *v, int axis, int split, thick_work *w)
{
    const int order[3] = {axis == 0, axis == 2 ? 1 : 2, axis};
    size_t strides[3] = {1, 1, 1};

    for (int i = 1; i < 3; i++)
        strides[i] = strides[i - 1] * (size_t)v->size[i - 1] * (size_t)(i - 1 == axis ? split : 1);
    for (int i = 0; i < 3; i++)
        w->stride[i] = strides[order[i]];
}

sc_status sc_resample_split_slices(const sc_ctx *ctx, sc_volume *v, int axis, int split,
                                   int threads)
{
    stack s = {0};
    memberships *labels = NULL;
    thick_work w = {.s = &s, .split = split, .out_bytes = v->label_bytes};
    void *block;
    sc_status status;

    SC_TRY(make_stack(ctx, v, axis, &s));
    SC_TRY(sc_stack_set_filter(ctx, &s, WIDTH));
    w.pixels = (size_t)s.size[0] * (size_t)s.size[1];
    w.room = (size_t)s.nodes[0] * (size_t)s.nodes[1] + (size_t)s.nodes[0] + 4 * w.pixels;
    SC_TRY(sc_memberships_find(ctx, &s, v->label_count, threads, &labels, &w.count));
    w.labels = labels;
    SC_TRY(sc_alloc(ctx, sc_volume_voxels(v), 1, &block));
    w.lack = block;
    SC_TRY(sc_alloc(ctx, sc_volume_voxels(v), 1, &block));
    w.sheet = block;
    SC_TRY(sc_alloc(ctx, (size_t)threads * w.room, sizeof(float), &block));
    w.scratch = block;
    SC_TRY(sc_alloc(ctx, sc_volume_voxels(v), (size_t)split * (size_t)v->label_bytes, &w.out));
    set_strides(v, axis, split, &w);
    sc_parallel_for(threads, (size_t)s.size[2], 1, find_lack, &w);
    sc_parallel_for(threads, (size_t)s.size[2], 1, find_sheets, &w);
    sc_parallel_for(threads, (size_t)s.size[2], 1, fill_layers, &w);
    sc_resample_set_planes(v, w.out, axis, v->size[axis] * split, 0.5 / split - 0.5, 1.0 / split);
out:
    sc_memberships_free(labels, w.count);
    sc_stack_clear(&s);
    sc_free(w.lack);
    sc_free(w.sheet);
    sc_free(w.scratch);
    return status;
}
