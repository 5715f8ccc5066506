/* SPDX-License-Identifier: BSD-3-Clause */
/* Waves in the borders of labels. A segmentation that was made on coarser voxels and brought to
 * finer ones smoothly, not by copies, shows the steps of the coarse ones as waves that are one or
 * two voxels high and many long: too long for the filter that takes away noise. A voxel at a border
 * gets another label if it lies deeper in that by a filter that averages such waves away, and if
 * the border is nearly flat over the width of this filter. So vessels and edges stay.
 *
 * The filter lets the displacement of a border pass as 1 - (1 - G)^3, for a Gaussian G: flat-topped
 * as that of noise.c, but weighted so that borders curved over its width stay in place, too. As it
 * is wide, it works on cells of about 6 x 6 x 6 voxels, in which the share of each label is
 * counted. Between the middles of cells values are interpolated by the cubics of Catmull and Rom.
 * Beyond the faces of the volume a share is twice that of the last cell minus that of the mirrored
 * one, so that a border that meets a face at an angle goes straight on.
 *
 * What was drawn on its own voxels has steps of less than a voxel, and these stay. Where anatomy is
 * fine against the voxels, little of its border is flat over so wide a filter. So the share of flat
 * borders, and the share of their voxels that lie beyond the smoothed border, tell whether there
 * are waves. */
#include "borders.h"

enum {
    GAUSSIANS = 3,  /* that the filter is the sum of; the second one tells what is flat */
    CELL_STEPS = 6, /* edge of a cell, about, in steps of the finest axis */
    REACH = 8,      /* of the Gaussians, in cells */
    CELLS = 8,      /* edge of a block */
    SUPPORT = 2,    /* cells beside a block from which is interpolated */
    FIELD = CELLS + 2 * SUPPORT,
    WINDOW = FIELD + 2 * REACH,
    NEAR_FACE = 10,            /* voxels from a face of the volume that are near it */
    CELL_LABELS = 4,           /* that a cell can hold; blocks near one with more are left alone */
    EDGE = CELLS * CELL_STEPS, /* of a block, in voxels; less along coarser axes */
    RUN = 96,                  /* voxels of a row that are looked at together */
    LEAST_CELL = 96            /* voxels that a cell has at least */
};

/* Standard deviation of G, in steps of the finest axis. */
#define WIDTH 8.0
/* The least gradient of a border that counts as flat, as a share of that of a plane: to measure
 * waves, and to remove them. */
#define FLAT_MEASURED 0.95f
#define FLAT_REMOVED 0.5f
/* How far beyond a smoothed border a voxel must lie, in steps of the finest axis: to count as
 * a wave, and to get another label. */
#define MARGIN_MEASURED 0.5f
#define MARGIN_REMOVED 0.15f

/* Square of the cosine of those 63 degrees: see flatness_at. */
#define NEAR_COSINE_SQUARE 0.2f

/* A Gaussian of variance n WIDTH^2 tells the depth of a place in a label near a border: what it has
 * more than half of the share, over its slope at a plane, from which a curved border lies off by
 * a distance proportional to n. In 3 - 3 + 1 times the three depths this cancels. The slope at
 * a plane is 1 / (WIDTH sqrt(2 pi n)). */
static const float depth_of[GAUSSIANS] = {(float)(3 * 2.506628275 * WIDTH),
                                          (float)(-3 * 3.544907702 * WIDTH),
                                          (float)(4.341607527 * WIDTH)};

/* What a cell holds: labels, and how many of its voxels carry them. */
typedef struct cell {
    uint16_t label[CELL_LABELS];
    uint8_t count[CELL_LABELS];
} cell;

/* Numbers that processors work on together. */
enum { QUAD = 4 };
typedef float quad __attribute__((vector_size(QUAD * sizeof(float))));
_Static_assert(FIELD % QUAD == 0, "a row of a field is filled by quads");
_Static_assert(QUAD == 4, "cubics go through four values");

typedef float field[FIELD][FIELD][FIELD]; /* [z][y][x], of the cells of a block and SUPPORT more */

/* What a thread works with. */
typedef struct wave_block {
    float shares[WINDOW][WINDOW][WINDOW]; /* of one label */
    float along_x[WINDOW][WINDOW][FIELD]; /* filtered along x */
    float along_y[WINDOW][FIELD][FIELD];  /* and y */
    field gaussians[GAUSSIANS];
    field depth[BORDER_LABELS], flat[BORDER_LABELS]; /* of the labels of the block */
} wave_block;

/* How values at the voxels of a block along an axis come from those of cells. */
typedef struct interpolation {
    int first[EDGE];                      /* of four cells, in a field */
    float value[EDGE][4], slope[EDGE][4]; /* weights */
} interpolation;

/* The filters, and what the threads work with. The cells and the scratch memory are owned. */
typedef struct waves {
    const drawn_view *view; /* of a volume without copied voxels */
    bool is_measured;       /* are waves measured, not removed? */
    float least_flat;       /* least gradient of a border that counts as flat */
    float margin;           /* how far beyond the smoothed border voxels must lie, in steps */
    int cell_size[3];       /* voxels of a cell along each axis */
    int cell_count[3];      /* cells of the volume */
    cell *cells;            /* [z][y][x]; of the team while waves are measured */
    wave_block *scratch;    /* [threads] */
    float weights[GAUSSIANS][3][2 * REACH + 1]; /* of each Gaussian along each axis, of sum 1 */
    float plane[3]; /* what a difference between cells is multiplied with to be 1 at a plane */
    interpolation between[3];
} waves;

/* ---- cells ---- */

static inline cell *cell_at(const waves *w, const int at[3])
{
    return w->cells +
           (((size_t)at[2] * (size_t)w->cell_count[1] + (size_t)at[1]) * (size_t)w->cell_count[0] +
            (size_t)at[0]);
}

/* Count a voxel in a cell, unless that holds too many labels. */
static void count_voxel(cell *c, uint16_t label)
{
    for (int i = 0; i < CELL_LABELS; i++) {
        if (c->count[i] == 0)
            c->label[i] = label;
        if (c->label[i] == label) {
            c->count[i]++;
            return;
        }
    }
}

/* @return how many voxels of a cell are counted: all of them, unless it holds too many labels. */
static inline int counted(const cell *c)
{
    return c->count[0] + c->count[1] + c->count[2] + c->count[3];
}

static int voxels_of_cell(const waves *w)
{
    return w->cell_size[0] * w->cell_size[1] * w->cell_size[2];
}

/* Count the voxels of cell @p at; the last voxels of the volume are repeated beyond its faces. */
static void count_cell(const waves *w, const int at[3], cell *c)
{
    *c = (cell){.count = {0}};
    for (int z = 0; z < w->cell_size[2]; z++) {
        const size_t slice = border_offset(w->view, 2, (ptrdiff_t)at[2] * w->cell_size[2] + z);

        for (int y = 0; y < w->cell_size[1]; y++) {
            const size_t row =
                slice + border_offset(w->view, 1, (ptrdiff_t)at[1] * w->cell_size[1] + y);

            for (int x = 0; x < w->cell_size[0]; x++) {
                const size_t i =
                    row + border_offset(w->view, 0, (ptrdiff_t)at[0] * w->cell_size[0] + x);

                count_voxel(c, (uint16_t)id_of_voxel(w->view->v, i));
            }
        }
    }
}

/* Find which of the voxels @p at, a row of @p count, differ from those around that are in the same
 * rows of cells: 0 in @p differs if none does. @param first receives the ids of the row. */
static void compare_rows(const waves *w, const size_t at[3], int count, uint16_t *restrict first,
                         uint16_t *restrict differs)
{
    const drawn_view *view = w->view;
    uint16_t ids[RUN];

    read_ids(view->v, view->offset[2][at[2]] + view->offset[1][at[1]] + at[0], count, first);
    for (int x = 0; x < count; x++)
        differs[x] = 0;
    for (int z = 0; z < w->cell_size[2]; z++) {
        for (int y = 0; y < w->cell_size[1]; y++) {
            read_ids(view->v,
                     view->offset[2][at[2] + (size_t)z] + view->offset[1][at[1] + (size_t)y] +
                         at[0],
                     count, ids);
            for (int x = 0; x < count; x++)
                differs[x] |= ids[x] ^ first[x];
        }
    }
}

/* Count a run of @p count cells of a row, from @p at on, all within the volume. */
static void count_run(const waves *w, const int at[3], int count, cell *cells)
{
    const int wide = w->cell_size[0];
    size_t low[3];
    uint16_t first[RUN], differs[RUN];

    for (int i = 0; i < 3; i++)
        low[i] = (size_t)at[i] * (size_t)w->cell_size[i];
    compare_rows(w, low, count * wide, first, differs);
    for (int n = 0; n < count; n++) {
        const uint16_t label = first[n * wide];
        bool same = true;

        for (int x = n * wide; x < (n + 1) * wide; x++)
            same = same && !differs[x] && first[x] == label;
        if (same)
            cells[n] = (cell){.label = {label}, .count = {(uint8_t)voxels_of_cell(w)}};
        else
            count_cell(w, (int[3]){at[0] + n, at[1], at[2]}, &cells[n]);
    }
}

/* @return how many cells along an axis lie within the volume with all of their voxels. */
static int whole_cells(const waves *w, int axis)
{
    return w->view->size[axis] / w->cell_size[axis];
}

/* Count rows of cells; an sc_range_fn on waves. */
static void count_rows(void *user, size_t begin, size_t end, int thread)
{
    const waves *w = user;
    const int most = RUN / w->cell_size[0], whole = whole_cells(w, 0);

    (void)thread;
    for (size_t n = begin; n < end; n++) {
        int at[3] = {0, (int)(n % (size_t)w->cell_count[1]), (int)(n / (size_t)w->cell_count[1])};
        cell *row = w->cells + n * (size_t)w->cell_count[0];
        const bool is_whole = at[1] < whole_cells(w, 1) && at[2] < whole_cells(w, 2);

        while (is_whole && at[0] < whole) {
            const int count = at[0] + most < whole ? most : whole - at[0];

            count_run(w, at, count, row + at[0]);
            at[0] += count;
        }
        for (; at[0] < w->cell_count[0]; at[0]++)
            count_cell(w, at, row + at[0]);
    }
}

/* @return whether a block and the cells beside it hold more than one label; of border_method. */
static bool may_hold(const void *self, const size_t low[3])
{
    const waves *w = self;
    const int voxels = voxels_of_cell(w);
    int begin[3], end[3];
    const cell *first;

    for (int i = 0; i < 3; i++) {
        const int at = (int)(low[i] / (size_t)w->cell_size[i]);

        begin[i] = at > 0 ? at - 1 : 0;
        end[i] = at + CELLS + 1 < w->cell_count[i] ? at + CELLS + 1 : w->cell_count[i];
    }
    first = cell_at(w, begin);
    for (int z = begin[2]; z < end[2]; z++) {
        for (int y = begin[1]; y < end[1]; y++) {
            const cell *row = cell_at(w, (int[3]){begin[0], y, z});

            for (int x = 0; x < end[0] - begin[0]; x++) {
                if (row[x].count[0] != voxels || row[x].label[0] != first->label[0])
                    return true;
            }
        }
    }
    return false;
}

/* ---- fields ---- */

/* The part of a window that lies in the volume: [begin, end) along each axis. */
typedef struct inside {
    int first[3]; /* the cell with which the window begins; negative beyond the volume */
    int begin[3], end[3];
} inside;

static inside find_inside(const waves *w, const border_block *block)
{
    inside in;

    for (int i = 0; i < 3; i++) {
        in.first[i] = (int)(block->low[i] / (size_t)w->cell_size[i]) - SUPPORT - REACH;
        in.begin[i] = in.first[i] < 0 ? -in.first[i] : 0;
        in.end[i] =
            in.first[i] + WINDOW > w->cell_count[i] ? w->cell_count[i] - in.first[i] : WINDOW;
    }
    return in;
}

/* @return the cells of a row of the window, of which those in the volume may be read. */
static const cell *cells_of_row(const waves *w, const inside *in, int y, int z)
{
    const ptrdiff_t row = (ptrdiff_t)(in->first[2] + z) * w->cell_count[1] + in->first[1] + y;

    return w->cells + (row * w->cell_count[0] + in->first[0]);
}

/* Does a cell of the window hold more labels than it can count? */
static bool is_crowded(const waves *w, const inside *in)
{
    const int voxels = voxels_of_cell(w);

    for (int z = in->begin[2]; z < in->end[2]; z++) {
        for (int y = in->begin[1]; y < in->end[1]; y++) {
            const cell *row = cells_of_row(w, in, y, z);

            for (int x = in->begin[0]; x < in->end[0]; x++) {
                if (counted(&row[x]) < voxels)
                    return true;
            }
        }
    }
    return false;
}

/* Reflect values beyond the cells [begin, end) of a line of WINDOW values, @p stride apart. */
static void reflect(float *line, size_t stride, int begin, int end)
{
    const int last = end - 1;

    for (int i = 0; i < begin; i++) {
        const int mirror = 2 * begin - i < last ? 2 * begin - i : last;

        line[(size_t)i * stride] = 2 * line[(size_t)begin * stride] - line[(size_t)mirror * stride];
    }
    for (int i = end; i < WINDOW; i++) {
        const int mirror = 2 * last - i > begin ? 2 * last - i : begin;

        line[(size_t)i * stride] = 2 * line[(size_t)last * stride] - line[(size_t)mirror * stride];
    }
}

/* Set the shares of a label in the cells of the window, and reflect them beyond the volume. */
static void set_shares(const waves *w, const inside *in, uint16_t label, wave_block *b)
{
    const float scale = 1 / (float)voxels_of_cell(w);

    for (int z = in->begin[2]; z < in->end[2]; z++) {
        for (int y = in->begin[1]; y < in->end[1]; y++) {
            const cell *row = cells_of_row(w, in, y, z);

            for (int x = in->begin[0]; x < in->end[0]; x++) {
                int count = 0;

                for (int i = 0; i < CELL_LABELS; i++)
                    count += row[x].label[i] == label ? row[x].count[i] : 0;
                b->shares[z][y][x] = (float)count * scale;
            }
            reflect(b->shares[z][y], 1, in->begin[0], in->end[0]);
        }
        for (int x = 0; x < WINDOW; x++)
            reflect(&b->shares[z][0][x], WINDOW, in->begin[1], in->end[1]);
    }
    for (int n = 0; n < WINDOW * WINDOW; n++)
        reflect(&b->shares[0][0][0] + n, (size_t)WINDOW * WINDOW, in->begin[2], in->end[2]);
}

/* Filter FIELD values that follow each other: sums of those @p stride apart with weights. */
static inline void filter_row(const float *restrict from, size_t stride,
                              const float *restrict weights, float *restrict to)
{
    quad sums[FIELD / QUAD] = {{0}};

    for (size_t n = 0; n < 2 * REACH + 1; n++) {
        for (size_t i = 0; i < FIELD / QUAD; i++) {
            quad values;

            memcpy(&values, from + n * stride + i * QUAD, sizeof values);
            sums[i] += weights[n] * values;
        }
    }
    memcpy(to, sums, sizeof sums);
}

/* Smooth the shares by Gaussian number @p n. */
static void smooth(const waves *w, int n, wave_block *b)
{
    for (int z = 0; z < WINDOW; z++) {
        for (int y = 0; y < WINDOW; y++)
            filter_row(b->shares[z][y], 1, w->weights[n][0], b->along_x[z][y]);
        for (int y = 0; y < FIELD; y++)
            filter_row(b->along_x[z][y], FIELD, w->weights[n][1], b->along_y[z][y]);
    }
    for (int z = 0; z < FIELD; z++) {
        for (int y = 0; y < FIELD; y++)
            filter_row(b->along_y[z][y], (size_t)FIELD * FIELD, w->weights[n][2],
                       b->gaussians[n][z][y]);
    }
}

/* Fill the fields of an entry of the block from the shares of its label: how deep in the label
 * places lie, in steps of the finest axis, and what tells where its border is flat. */
static void set_fields(const waves *w, int entry, wave_block *b)
{
    const float *g[GAUSSIANS];
    float *depth = b->depth[entry][0][0], *flat = b->flat[entry][0][0];

    for (int n = 0; n < GAUSSIANS; n++) {
        smooth(w, n, b);
        g[n] = b->gaussians[n][0][0];
    }
    for (int i = 0; i < FIELD * FIELD * FIELD; i++) {
        depth[i] = depth_of[0] * (g[0][i] - 0.5f) + depth_of[1] * (g[1][i] - 0.5f) +
                   depth_of[2] * (g[2][i] - 0.5f);
        flat[i] = g[1][i];
    }
}

/* ---- voxels ---- */

/* @return the value of a field at a voxel of the block, with weights for each axis. */
static float value_at(const waves *w, const field f, const uint8_t at[3],
                      const float *const weights[3])
{
    const int x = w->between[0].first[at[0]], y = w->between[1].first[at[1]],
              z = w->between[2].first[at[2]];
    float sum = 0;
    quad along_x = {0};

    for (int k = 0; k < 4; k++) {
        for (int j = 0; j < 4; j++) {
            quad row;

            memcpy(&row, &f[z + k][y + j][x], sizeof row);
            along_x += weights[2][k] * weights[1][j] * row;
        }
    }
    for (int i = 0; i < QUAD; i++)
        sum += weights[0][i] * along_x[i];
    return sum;
}

/* @return how deep in an entry a voxel lies. */
static float depth_at(const waves *w, const wave_block *b, int entry, const uint8_t at[3])
{
    const float *weights[3];

    for (int i = 0; i < 3; i++)
        weights[i] = w->between[i].value[at[i]];
    return value_at(w, b->depth[entry], at, weights);
}

/* Is a voxel near one of the faces of the volume across an axis? */
static bool is_near_face(const waves *w, const border_block *block, const uint8_t at[3], int axis)
{
    const int place = (int)block->low[axis] + at[axis];

    return place < NEAR_FACE || place >= w->view->size[axis] - NEAR_FACE;
}

/* @return the gradient of an entry at a voxel, as a share of that at a plane; 0 near a face of
 * the volume that the border meets at less than 63 degrees: nothing tells how such a border goes on
 * beyond the face. */
static float flatness_at(const waves *w, const border_block *block, const wave_block *b, int entry,
                         const uint8_t at[3])
{
    float square = 0, parallel = 0;

    for (int axis = 0; axis < 3; axis++) {
        const float *weights[3];
        float slope;

        for (int i = 0; i < 3; i++)
            weights[i] = i == axis ? w->between[i].slope[at[i]] : w->between[i].value[at[i]];
        slope = value_at(w, b->flat[entry], at, weights) * w->plane[axis];
        square += slope * slope;
        if (is_near_face(w, block, at, axis))
            parallel = fmaxf(parallel, slope * slope);
    }
    return parallel > NEAR_COSINE_SQUARE * square ? 0 : sqrtf(square);
}

/* Choose the label of a voxel: that in which it lies deepest, if the border is flat there. */
static void choose_one(const waves *w, const border_block *block, const wave_block *b,
                       border_voxel *voxel)
{
    const float own = depth_at(w, b, voxel->own, voxel->at);
    float most = -HUGE_VALF;
    int best = voxel->own;
    bool contested;

    for (int entry = 0; entry < block->label_count; entry++) {
        if (entry != voxel->own && border_contends(voxel, entry)) {
            const float depth = depth_at(w, b, entry, voxel->at);

            best = depth > most ? entry : best;
            most = depth > most ? depth : most;
        }
    }
    contested = most > own + 2 * w->margin;
    voxel->is_flat = (contested || w->is_measured) &&
                     flatness_at(w, block, b, voxel->own, voxel->at) >= w->least_flat &&
                     flatness_at(w, block, b, best, voxel->at) >= w->least_flat;
    if (contested && voxel->is_flat)
        voxel->chosen = (uint8_t)best;
}

/* Choose labels for the voxels of a block; of border_method. */
static void choose(const void *self, border_block *block, int thread)
{
    const waves *w = self;
    wave_block *b = &w->scratch[thread];
    const inside in = find_inside(w, block);

    for (int i = 0; i < block->voxel_count; i++)
        block->voxels[i].is_flat = false;
    if (is_crowded(w, &in))
        return;
    for (int entry = 0; entry < block->label_count; entry++) {
        set_shares(w, &in, block->labels[entry], b);
        set_fields(w, entry, b);
    }
    for (int i = 0; i < block->voxel_count; i++)
        choose_one(w, block, b, &block->voxels[i]);
}

/* ---- filters ---- */

/* Set the weights of all Gaussians along an axis. @param cell_steps length of a cell, in steps of
 * the finest axis. */
static void set_weights(waves *w, int axis, double cell_steps)
{
    /* of the voxels within a cell */
    const double inner = (1 - 1 / ((double)w->cell_size[axis] * w->cell_size[axis])) / 12;

    for (int n = 0; n < GAUSSIANS; n++) {
        const double variance = (n + 1) * (WIDTH / cell_steps) * (WIDTH / cell_steps) - inner;
        double sum = 0;

        for (int i = -REACH; i <= REACH; i++)
            sum += exp(-i * i / (2 * variance));
        for (int i = -REACH; i <= REACH; i++)
            w->weights[n][axis][i + REACH] = (float)(exp(-i * i / (2 * variance)) / sum);
    }
    w->plane[axis] = (float)(sqrt(4 * M_PI) * WIDTH / cell_steps);
}

/* Set the weights of the voxels of a block along an axis: cubics of Catmull and Rom. */
static void set_between(interpolation *b, int cell_size)
{
    for (int i = 0; i < CELLS * cell_size; i++) {
        const double at = (i + 0.5) / cell_size - 0.5, t = at - floor(at);
        const double value[4] = {((-0.5 * t + 1) * t - 0.5) * t, (1.5 * t - 2.5) * t * t + 1,
                                 ((-1.5 * t + 2) * t + 0.5) * t, (0.5 * t - 0.5) * t * t};
        const double slope[4] = {(-1.5 * t + 2) * t - 0.5, (4.5 * t - 5) * t,
                                 (-4.5 * t + 4) * t + 0.5, (1.5 * t - 1) * t};

        b->first[i] = (int)floor(at) - 1 + SUPPORT;
        for (int k = 0; k < 4; k++) {
            b->value[i][k] = (float)value[k];
            b->slope[i][k] = (float)slope[k];
        }
    }
}

/* Set everything but cells and scratch memory for a volume. @param drawn_mm lengths of its voxels,
 * none more than SC_THICK_RATIO times the shortest. */
static waves make_waves(const drawn_view *view, const double drawn_mm[3], bool is_measured)
{
    const double shortest = fmin(drawn_mm[0], fmin(drawn_mm[1], drawn_mm[2]));
    waves w = {.view = view,
               .is_measured = is_measured,
               .least_flat = is_measured ? FLAT_MEASURED : FLAT_REMOVED,
               .margin = is_measured ? MARGIN_MEASURED : MARGIN_REMOVED};

    for (int i = 0; i < 3; i++) {
        const double step = drawn_mm[i] / shortest;

        w.cell_size[i] = (int)fmax(1, round(CELL_STEPS / step));
        w.cell_count[i] = (view->size[i] + w.cell_size[i] - 1) / w.cell_size[i];
        set_weights(&w, i, w.cell_size[i] * step);
        set_between(&w.between[i], w.cell_size[i]);
    }
    return w;
}

/* Make the scratch memory. @return SC_ERR_MEMORY. */
static sc_status make_scratch(const sc_ctx *ctx, int threads, waves *w)
{
    void *block;
    sc_status status;

    SC_TRY(sc_zalloc(ctx, (size_t)threads, sizeof *w->scratch, &block));
    w->scratch = block;
out:
    return status;
}

/* @return how many rows of cells there are. */
static size_t rows_of(const waves *w)
{
    return (size_t)w->cell_count[1] * (size_t)w->cell_count[2];
}

/* @return the method, for sc_borders_measure and sc_borders_relabel. */
static border_method method_of(const waves *w)
{
    border_method method = {
        .sample_blocks = 128, .looked_at = 512, .self = w, .may_hold = may_hold, .choose = choose};

    for (int i = 0; i < 3; i++)
        method.edge[i] = CELLS * w->cell_size[i];
    return method;
}

sc_status sc_resample_measure_waves(const sc_ctx *ctx, sc_team *team, const drawn_view *view,
                                    const double drawn_mm[3], double *share, double *flat)
{
    waves w = make_waves(view, drawn_mm, true);
    const border_method method = method_of(&w);
    void *cells = NULL;
    border_shares shares;
    sc_status status;

    SC_TRY(sc_team_agree(team, make_scratch(ctx, sc_team_threads(team), &w)));
    SC_TRY(
        sc_team_alloc(ctx, team, rows_of(&w) * (size_t)w.cell_count[0], sizeof *w.cells, &cells));
    w.cells = cells;
    sc_team_for(team, rows_of(&w), 16, count_rows, &w);
    SC_TRY(sc_borders_measure(ctx, team, view, &method, &shares));
    *share = shares.changed;
    *flat = shares.flat;
out:
    sc_team_free(team, cells);
    sc_free(w.scratch);
    return status;
}

sc_status sc_resample_remove_waves(const sc_ctx *ctx, sc_volume *v, const double drawn_mm[3],
                                   int threads)
{
    const sc_drawn_grid whole = {.copies = {1, 1, 1}};
    drawn_view view = {0};
    waves w = {0};
    border_method method;
    void *cells = NULL;
    sc_status status;

    SC_TRY(sc_drawn_view_make(ctx, v, &whole, &view));
    w = make_waves(&view, drawn_mm, false);
    method = method_of(&w);
    SC_TRY(make_scratch(ctx, threads, &w));
    SC_TRY(sc_alloc(ctx, rows_of(&w) * (size_t)w.cell_count[0], sizeof *w.cells, &cells));
    w.cells = cells;
    sc_parallel_for(threads, rows_of(&w), 16, count_rows, &w);
    status = sc_borders_relabel(ctx, v, &view, &method, threads);
out:
    sc_free(cells);
    sc_free(w.scratch);
    sc_drawn_view_clear(&view);
    return status;
}

double sc_resample_waves_bytes(const sc_volume *v, int threads)
{
    return (double)sc_volume_voxels(v) * sizeof(cell) / LEAST_CELL +
           threads * (double)sizeof(wave_block);
}
