/* SPDX-License-Identifier: BSD-3-Clause */
/* Noise at the borders of labels: single voxels, contours that jump. A voxel at a border gets
 * another label if that has the larger membership there, smoothed over so wide a ball that the
 * noise is averaged away, and if the border is nearly flat over this ball; where it is not, a
 * narrower ball decides; and where even over that the tissue is thin or strongly curved, the voxel
 * stays as it is. Borders of voxelised smooth shapes are left alone by this, all but a few voxels
 * in a thousand, so the share of voxels that would change is a measure of the noise.
 *
 * The filter is 1 - (1 - G)^4 for a Gaussian G, a flat-topped low-pass: a single Gaussian would
 * move curved borders inward. Over how wide a ball a border is flat tells the gradient of the
 * membership smoothed by a Gaussian: over a flat border it has its largest value, over a bend, a
 * sheet or a tube it is smaller. */
#include "borders.h"
#include "rows.h"

enum {
    GAUSSIANS = 4, /* that the filter is the sum of */
    SCALES = 2,    /* widths of the ball: wide, narrow */
    BLOCK_VOXELS = ROW_BLOCK * ROW_BLOCK * ROW_BLOCK
};

/* Standard deviations of the first Gaussian of the filter, in steps of the finest axis. */
static const double filter_width[SCALES] = {2.0, 1.2};
/* Standard deviations of the Gaussian that tells whether borders are flat. */
static const double flat_width[SCALES] = {2.5, 1.55};
/* The least gradient of a border that counts as flat, as a share of that of a plane. */
static const double flat_least[SCALES] = {0.85, 0.7};
/* Filters end at so many widths of that Gaussian. */
#define REACH_WIDTHS 3.6
/* By how much another label's membership must be the larger one. */
static const float margin[SCALES] = {0.12f, 0.12f};

/* The filters of a scale. */
typedef struct scale {
    row_filter membership;   /* of sum 1 */
    row_filter value, slope; /* the Gaussian, and that times the distance along x */
    float flat[3]; /* what the gradient along each axis is multiplied with to be 1 over a plane */
} scale;

/* What is measured at a voxel. */
typedef struct measures {
    uint8_t best[SCALES]; /* entry of the strongest other label */
    float own_share[SCALES], best_share[SCALES];
    float gradient[SCALES][2]; /* lengths of those of own and best */
} measures;

/* What a thread works with. */
typedef struct noise_block {
    uint16_t ids[ROW_WINDOW * ROW_COUNT];      /* [z][y][x] of the window, edges repeated outside */
    uint32_t window[BORDER_LABELS][ROW_COUNT]; /* bits of the labels of the block */
    measures measured[BLOCK_VOXELS];           /* one for each voxel at a border */
} noise_block;

/* The filters, and what the threads work with. The array is owned. */
typedef struct noise {
    const drawn_view *view;
    scale scales[SCALES];
    noise_block *scratch; /* [threads] */
} noise;

/* ---- filters ---- */

/* Weights: see row_weight_fn. */
static double flat_topped(double square, double x, double width)
{
    static const double binomial[GAUSSIANS] = {4, -6, 4, -1};
    double sum = 0;

    (void)x;
    for (int n = 0; n < GAUSSIANS; n++) {
        const double variance = (n + 1) * width * width;

        sum += binomial[n] * pow(variance, -1.5) * exp(-square / (2 * variance));
    }
    return sum;
}

static double gaussian(double square, double x, double width)
{
    (void)x;
    return exp(-square / (2 * width * width));
}

static double gaussian_slope(double square, double x, double width)
{
    return x * gaussian(square, x, width);
}

/* @return the sum of the weights of a filter; with an axis instead of -1 that of the weights times
 * the distance along it, in voxels, on one side. */
static double sum_of_weights(row_weight_fn *weight, double width, double reach,
                             const double steps[3], int axis)
{
    double sum = 0;

    for (int z = -ROW_REACH; z <= ROW_REACH; z++) {
        for (int y = -ROW_REACH; y <= ROW_REACH; y++) {
            for (int x = -ROW_REACH; x <= ROW_REACH; x++) {
                const double at[3] = {x * steps[0], y * steps[1], z * steps[2]};
                const double square = at[0] * at[0] + at[1] * at[1] + at[2] * at[2];
                const double along = axis < 0 ? 1 : fmax(at[axis], 0) / steps[axis];

                if (square <= reach * reach)
                    sum += along * weight(square, 0, width);
            }
        }
    }
    return sum;
}

/* Make the filters of a scale. @param steps as of sc_row_filter_make. */
static sc_status make_scale(const sc_ctx *ctx, int n, const double steps[3], scale *s)
{
    const double width = filter_width[n], flat = flat_width[n];
    const double reach = fmin(REACH_WIDTHS * flat, ROW_REACH);
    sc_status status;

    SC_TRY(sc_row_filter_make(ctx, flat_topped, width, reach, steps,
                              1 / sum_of_weights(flat_topped, width, reach, steps, -1),
                              &s->membership));
    SC_TRY(sc_row_filter_make(ctx, gaussian, flat, reach, steps, 1, &s->value));
    SC_TRY(sc_row_filter_make(ctx, gaussian_slope, flat, reach, steps, 1 / steps[0], &s->slope));
    for (int i = 0; i < 3; i++) {
        const double plane = sum_of_weights(gaussian, flat, reach, steps, i);

        s->flat[i] = plane > 0 ? (float)(1 / plane) : 0;
    }
    status = SC_OK;
out:
    return status;
}

/* ---- windows ---- */

/* Fill the window around a block. */
static void fetch_ids(const drawn_view *view, const size_t low[3], noise_block *b)
{
    uint16_t *to = b->ids;
    size_t along_x[ROW_WINDOW];

    for (int x = 0; x < ROW_WINDOW; x++)
        along_x[x] = border_offset(view, 0, (ptrdiff_t)low[0] + x - ROW_REACH);
    for (int z = 0; z < ROW_WINDOW; z++) {
        const size_t slice = border_offset(view, 2, (ptrdiff_t)low[2] + z - ROW_REACH);

        for (int y = 0; y < ROW_WINDOW; y++) {
            const size_t row = slice + border_offset(view, 1, (ptrdiff_t)low[1] + y - ROW_REACH);

            for (int x = 0; x < ROW_WINDOW; x++)
                *to++ = (uint16_t)id_of_voxel(view->v, row + along_x[x]);
        }
    }
}

/* Set the bits of the window that tell which voxels carry the labels of the block. */
static void set_windows(const border_block *block, noise_block *b)
{
    memset(b->window, 0, (size_t)block->label_count * sizeof *b->window);
    for (int row = 0; row < ROW_COUNT; row++) {
        const uint16_t *ids = b->ids + row * ROW_WINDOW;
        int end;

        for (int begin = 0; begin < ROW_WINDOW; begin = end) {
            int entry = 0;

            for (end = begin + 1; end < ROW_WINDOW && ids[end] == ids[begin];)
                end++;
            while (entry < block->label_count && block->labels[entry] != ids[begin])
                entry++;
            if (entry < block->label_count)
                b->window[entry][row] |= ((1u << (end - begin)) - 1) << begin;
        }
    }
}
_Static_assert(ROW_WINDOW < 32, "the bits of a row fit in 32");

/* Is a place of the window outside of the volume? */
static bool is_outside(const drawn_view *view, const size_t low[3], const int at[3])
{
    bool outside = false;

    for (int i = 0; i < 3; i++) {
        const ptrdiff_t place = (ptrdiff_t)low[i] + at[i] - ROW_REACH;

        outside = outside || place < 0 || place >= view->size[i];
    }
    return outside;
}

/* Does only one label lie at the faces of the volume within the window of a block? Where shapes are
 * cut off by a face their borders bend, and that is no noise. Of border_method. */
static bool is_whole(const void *self, const border_block *block, int thread)
{
    const noise *w = self;
    const int first[3] = {0, 0, 0}, last[3] = {ROW_WINDOW - 1, ROW_WINDOW - 1, ROW_WINDOW - 1};
    noise_block *b = &w->scratch[thread];
    int label = -1;

    if (!is_outside(w->view, block->low, first) && !is_outside(w->view, block->low, last))
        return true;
    fetch_ids(w->view, block->low, b);
    for (int z = 0; z < ROW_WINDOW; z++) {
        for (int y = 0; y < ROW_WINDOW; y++) {
            for (int x = 0; x < ROW_WINDOW; x++) {
                const int id = b->ids[(z * ROW_WINDOW + y) * ROW_WINDOW + x];

                if (!is_outside(w->view, block->low, (int[3]){x, y, z}))
                    continue;
                if (label >= 0 && id != label)
                    return false;
                label = id;
            }
        }
    }
    return true;
}

/* ---- voxels ---- */

/* Measure the membership of the label of an entry at a voxel. */
static void measure_share(const noise *w, const noise_block *b, int entry,
                          const border_voxel *voxel, measures *m)
{
    for (int s = 0; s < SCALES; s++) {
        const float share = sc_row_filter_sum(&w->scales[s].membership, b->window[entry],
                                              voxel->at[0], voxel->at[1], voxel->at[2]);

        if (entry == voxel->own) {
            m->own_share[s] = share;
        } else if (share > m->best_share[s]) {
            m->best_share[s] = share;
            m->best[s] = (uint8_t)entry;
        }
    }
}

/* Would another label take a voxel at a scale, were the border flat? */
static inline bool is_contested(const measures *m, int s)
{
    return m->best_share[s] > m->own_share[s] + margin[s];
}

/* Measure the gradient of the label of an entry at a voxel. */
static void measure_gradient(const noise *w, const noise_block *b, int entry,
                             const border_voxel *voxel, measures *m)
{
    const uint8_t *at = voxel->at;

    for (int s = 0; s < SCALES; s++) {
        const scale *f = &w->scales[s];
        float along[3];

        if (entry != voxel->own && entry != m->best[s])
            continue;
        along[0] = sc_row_filter_sum(&f->slope, b->window[entry], at[0], at[1], at[2]);
        sc_row_filter_moments(&f->value, b->window[entry], at[0], at[1], at[2], along + 1);
        for (int i = 0; i < 3; i++)
            along[i] *= f->flat[i];
        m->gradient[s][entry != voxel->own] =
            sqrtf(along[0] * along[0] + along[1] * along[1] + along[2] * along[2]);
    }
}

/* @return the entry of the label that a voxel gets. @param own entry of the one that it carries. */
static uint8_t decide(const measures *m, uint8_t own)
{
    for (int s = 0; s < SCALES; s++) {
        if (fmin(m->gradient[s][0], m->gradient[s][1]) >= flat_least[s])
            return is_contested(m, s) ? m->best[s] : own;
    }
    return own;
}

/* Choose labels for the voxels of a block; of border_method. */
static void choose(const void *self, border_block *block, int thread)
{
    const noise *w = self;
    noise_block *b = &w->scratch[thread];

    fetch_ids(w->view, block->low, b);
    set_windows(block, b);
    for (int i = 0; i < block->voxel_count; i++)
        b->measured[i] = (measures){.best_share = {-1, -1}};
    for (int entry = 0; entry < block->label_count; entry++) {
        for (int i = 0; i < block->voxel_count; i++) {
            if (border_contends(&block->voxels[i], entry))
                measure_share(w, b, entry, &block->voxels[i], &b->measured[i]);
        }
    }
    for (int entry = 0; entry < block->label_count; entry++) {
        for (int i = 0; i < block->voxel_count; i++) {
            measures *m = &b->measured[i];

            if (is_contested(m, 0) || is_contested(m, 1))
                measure_gradient(w, b, entry, &block->voxels[i], m);
        }
    }
    for (int i = 0; i < block->voxel_count; i++)
        block->voxels[i].chosen = decide(&b->measured[i], block->voxels[i].own);
}

/* ---- volumes ---- */

/* Make the filters and the scratch memory for a volume. @return SC_ERR_MEMORY. */
static sc_status make_noise(const sc_ctx *ctx, const drawn_view *view, const double drawn_mm[3],
                            int threads, noise *w)
{
    double shortest = HUGE_VAL, steps[3];
    void *block;
    sc_status status;

    *w = (noise){.view = view};
    for (int i = 0; i < 3; i++)
        shortest = fmin(shortest, drawn_mm[i]);
    for (int i = 0; i < 3; i++)
        steps[i] = drawn_mm[i] / shortest;
    for (int s = 0; s < SCALES; s++)
        SC_TRY(make_scale(ctx, s, steps, &w->scales[s]));
    SC_TRY(sc_zalloc(ctx, (size_t)threads, sizeof *w->scratch, &block));
    w->scratch = block;
out:
    return status;
}

static void clear_noise(noise *w)
{
    for (int s = 0; s < SCALES; s++) {
        sc_row_filter_clear(&w->scales[s].membership);
        sc_row_filter_clear(&w->scales[s].value);
        sc_row_filter_clear(&w->scales[s].slope);
    }
    sc_free(w->scratch);
}

/* @return the method, for sc_borders_measure and sc_borders_relabel. */
static border_method method_of(const noise *w)
{
    return (border_method){.edge = {ROW_BLOCK, ROW_BLOCK, ROW_BLOCK},
                           .sample_blocks = 512,
                           .looked_at = 1 << 14,
                           .self = w,
                           .is_sampled = is_whole,
                           .choose = choose};
}

sc_status sc_resample_measure_noise(const sc_ctx *ctx, sc_team *team, const drawn_view *view,
                                    const double drawn_mm[3], double *share)
{
    noise w;
    const border_method method = method_of(&w);
    border_shares shares;
    sc_status status = make_noise(ctx, view, drawn_mm, sc_team_threads(team), &w);

    SC_TRY(sc_team_agree(team, status));
    SC_TRY(sc_borders_measure(ctx, team, view, &method, &shares));
    *share = shares.changed;
out:
    clear_noise(&w);
    return status;
}

sc_status sc_resample_remove_noise(const sc_ctx *ctx, sc_volume *v, const double drawn_mm[3],
                                   int threads)
{
    const sc_drawn_grid whole = {.copies = {1, 1, 1}};
    drawn_view view = {0};
    noise w = {0};
    const border_method method = method_of(&w);
    sc_status status;

    SC_TRY(sc_drawn_view_make(ctx, v, &whole, &view));
    SC_TRY(make_noise(ctx, &view, drawn_mm, threads, &w));
    status = sc_borders_relabel(ctx, v, &view, &method, threads);
out:
    clear_noise(&w);
    sc_drawn_view_clear(&view);
    return status;
}
