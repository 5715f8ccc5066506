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
#include "internal.h"
#include "rows.h"

#include <string.h>

enum {
    GAUSSIANS = 4,       /* that the filter is the sum of */
    SCALES = 2,          /* widths of the ball: wide, narrow */
    MOST_LABELS = 32,    /* of a block; where more meet nothing is flat, and it is left alone */
    SAMPLE_BLOCKS = 512, /* with borders, that are looked at to measure noise */
    LOOKED_AT = 1 << 14, /* blocks among which these are looked for */
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

/* A voxel that has a neighbour with another label by one of its faces. */
typedef struct candidate {
    uint8_t at[3];     /* in its block */
    uint8_t own;       /* entry of the label it carries */
    uint8_t others[6]; /* entries of its neighbours */
    uint8_t best[SCALES];
    float own_share[SCALES], best_share[SCALES];
    float gradient[SCALES][2]; /* lengths of those of own and best */
} candidate;

/* A block of voxels at work. */
typedef struct block {
    size_t low[3];
    uint16_t ids[ROW_WINDOW * ROW_COUNT]; /* [z][y][x] of the window, edges repeated outside */
    uint32_t window[ROW_COUNT];           /* bits of one label */
    uint16_t labels[MOST_LABELS];
    int label_count;
    candidate candidates[BLOCK_VOXELS];
    int candidate_count;
} block;

/* What the threads share. The arrays are owned, but for has_border. */
typedef struct noise_work {
    const drawn_view *view;
    scale scales[SCALES];
    size_t blocks[3];      /* along each axis */
    block *scratch;        /* [threads] */
    size_t *sample;        /* blocks to measure, or NULL */
    uint8_t *has_border;   /* of the team: of blocks that are looked at for the sample */
    uint64_t (*counts)[2]; /* [threads]: candidates, and those to change */
    void *out;             /* ids of the result, or NULL */
} noise_work;

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

/* ---- blocks ---- */

/* Set the first voxel of a block. */
static void place_block(const noise_work *w, size_t n, block *b)
{
    b->low[0] = n % w->blocks[0] * ROW_BLOCK;
    b->low[1] = n / w->blocks[0] % w->blocks[1] * ROW_BLOCK;
    b->low[2] = n / w->blocks[0] / w->blocks[1] * ROW_BLOCK;
}

/* @return what plane @p at along an axis adds to a voxel's index; the next plane's within. */
static inline size_t offset_of(const drawn_view *view, int axis, ptrdiff_t at)
{
    const ptrdiff_t last = view->size[axis] - 1;

    return view->offset[axis][at < 0 ? 0 : at > last ? last : at];
}

/* Fill a part of the window: the voxels that lie at most @p reach outside of the block. */
static void fetch_ids(const drawn_view *view, block *b, int reach)
{
    const int begin = ROW_REACH - reach, end = ROW_REACH + ROW_BLOCK + reach;
    size_t along_x[ROW_WINDOW];

    for (int x = begin; x < end; x++)
        along_x[x] = offset_of(view, 0, (ptrdiff_t)b->low[0] + x - ROW_REACH);
    for (int z = begin; z < end; z++) {
        const size_t slice = offset_of(view, 2, (ptrdiff_t)b->low[2] + z - ROW_REACH);

        for (int y = begin; y < end; y++) {
            const size_t row = slice + offset_of(view, 1, (ptrdiff_t)b->low[1] + y - ROW_REACH);
            uint16_t *to = b->ids + (z * ROW_WINDOW + y) * ROW_WINDOW;

            for (int x = begin; x < end; x++)
                to[x] = (uint16_t)id_of_voxel(view->v, row + along_x[x]);
        }
    }
}

/* @return the entry of a label of the block, which is added if it is new; MOST_LABELS: no room. */
static int entry_of(block *b, uint16_t label)
{
    int i = 0;

    while (i < b->label_count && b->labels[i] != label)
        i++;
    if (i == b->label_count && i < MOST_LABELS)
        b->labels[b->label_count++] = label;
    return i;
}

/* @return the id of the voxel of the window. */
static inline const uint16_t *id_in_window(const block *b, int x, int y, int z)
{
    return b->ids + ((z + ROW_REACH) * ROW_WINDOW + y + ROW_REACH) * ROW_WINDOW + x + ROW_REACH;
}

/* Add a voxel of the block to the candidates if it is one. @return false if the block holds too
 * many labels. */
static bool add_candidate(block *b, int x, int y, int z)
{
    static const int around[6] = {-1, 1, -ROW_WINDOW, ROW_WINDOW, -ROW_COUNT, ROW_COUNT};
    const uint16_t *id = id_in_window(b, x, y, z);
    candidate c = {.at = {(uint8_t)x, (uint8_t)y, (uint8_t)z}};
    bool differs = false;

    for (int i = 0; i < 6; i++)
        differs = differs || id[around[i]] != *id;
    if (!differs)
        return true;
    c.own = (uint8_t)entry_of(b, *id);
    for (int i = 0; i < 6; i++) {
        const int entry = entry_of(b, id[around[i]]);

        if (entry == MOST_LABELS)
            return false;
        c.others[i] = (uint8_t)entry;
    }
    for (int s = 0; s < SCALES; s++)
        c.best_share[s] = -1;
    b->candidates[b->candidate_count++] = c;
    return c.own < MOST_LABELS;
}

/* Find the candidates of a block, of which fetch_ids has fetched at least what lies 1 outside, and
 * their labels. There are none where too many labels meet. */
static void find_candidates(const noise_work *w, block *b)
{
    b->candidate_count = b->label_count = 0;
    for (int n = 0; n < BLOCK_VOXELS; n++) {
        const int at[3] = {n % ROW_BLOCK, n / ROW_BLOCK % ROW_BLOCK, n / ROW_BLOCK / ROW_BLOCK};
        bool inside = true;

        for (int i = 0; i < 3; i++)
            inside = inside && b->low[i] + (size_t)at[i] < (size_t)w->view->size[i];
        if (inside && !add_candidate(b, at[0], at[1], at[2])) {
            b->candidate_count = 0;
            return;
        }
    }
}

/* Set the bits of the window that tell which voxels carry a label. */
static void set_window(block *b, uint16_t label)
{
    for (int row = 0; row < ROW_COUNT; row++) {
        const uint16_t *ids = b->ids + row * ROW_WINDOW;
        uint32_t bits = 0;

        for (int x = 0; x < ROW_WINDOW; x++)
            bits |= (uint32_t)(ids[x] == label) << x;
        b->window[row] = bits;
    }
}

/* ---- candidates ---- */

/* Does the label of an entry contend for a candidate? */
static bool contends(const candidate *c, int entry)
{
    bool found = c->own == entry;

    for (int i = 0; i < 6; i++)
        found = found || c->others[i] == entry;
    return found;
}

/* Measure the membership of the label whose bits are in the window at a candidate. */
static void measure_share(const noise_work *w, const block *b, int entry, candidate *c)
{
    for (int s = 0; s < SCALES; s++) {
        const float share =
            sc_row_filter_sum(&w->scales[s].membership, b->window, c->at[0], c->at[1], c->at[2]);

        if (entry == c->own) {
            c->own_share[s] = share;
        } else if (share > c->best_share[s]) {
            c->best_share[s] = share;
            c->best[s] = (uint8_t)entry;
        }
    }
}

/* Would another label take a candidate at a scale, were the border flat? */
static inline bool is_contested(const candidate *c, int s)
{
    return c->best_share[s] > c->own_share[s] + margin[s];
}

/* Measure the gradient of the label whose bits are in the window at a candidate. */
static void measure_gradient(const noise_work *w, const block *b, int entry, candidate *c)
{
    for (int s = 0; s < SCALES; s++) {
        const scale *f = &w->scales[s];
        float along[3];

        if (entry != c->own && entry != c->best[s])
            continue;
        along[0] = sc_row_filter_sum(&f->slope, b->window, c->at[0], c->at[1], c->at[2]);
        sc_row_filter_moments(&f->value, b->window, c->at[0], c->at[1], c->at[2], along + 1);
        for (int i = 0; i < 3; i++)
            along[i] *= f->flat[i];
        c->gradient[s][entry != c->own] =
            sqrtf(along[0] * along[0] + along[1] * along[1] + along[2] * along[2]);
    }
}

/* @return the entry of the label that a candidate gets. */
static int decide(const candidate *c)
{
    for (int s = 0; s < SCALES; s++) {
        if (fmin(c->gradient[s][0], c->gradient[s][1]) >= flat_least[s])
            return is_contested(c, s) ? c->best[s] : c->own;
    }
    return c->own;
}

/* Find what the candidates of a block get: their own label becomes that in best[0].
 * @return how many get another one. */
static int decide_block(const noise_work *w, block *b)
{
    int changed = 0;

    fetch_ids(w->view, b, ROW_REACH);
    for (int entry = 0; entry < b->label_count; entry++) {
        set_window(b, b->labels[entry]);
        for (int i = 0; i < b->candidate_count; i++) {
            if (contends(&b->candidates[i], entry))
                measure_share(w, b, entry, &b->candidates[i]);
        }
    }
    for (int entry = 0; entry < b->label_count; entry++) {
        set_window(b, b->labels[entry]);
        for (int i = 0; i < b->candidate_count; i++) {
            if (is_contested(&b->candidates[i], 0) || is_contested(&b->candidates[i], 1))
                measure_gradient(w, b, entry, &b->candidates[i]);
        }
    }
    for (int i = 0; i < b->candidate_count; i++) {
        candidate *c = &b->candidates[i];

        c->best[0] = (uint8_t)decide(c);
        changed += c->best[0] != c->own;
    }
    return changed;
}

/* Do a block whose candidates are known. */
static void do_block(const noise_work *w, block *b, int thread)
{
    const drawn_view *view = w->view;
    const int changed = decide_block(w, b);

    w->counts[thread][0] += (uint64_t)b->candidate_count;
    w->counts[thread][1] += (uint64_t)changed;
    for (int i = 0; i < b->candidate_count && w->out; i++) {
        const candidate *c = &b->candidates[i];
        const size_t at = view->offset[0][b->low[0] + c->at[0]] +
                          view->offset[1][b->low[1] + c->at[1]] +
                          view->offset[2][b->low[2] + c->at[2]];

        if (view->v->label_bytes == 1)
            ((uint8_t *)w->out)[at] = (uint8_t)b->labels[c->best[0]];
        else
            ((uint16_t *)w->out)[at] = b->labels[c->best[0]];
    }
}

/* Do all blocks of [begin, end), or those of the sample; an sc_range_fn on noise_work. */
static void do_blocks(void *user, size_t begin, size_t end, int thread)
{
    const noise_work *w = user;
    block *b = &w->scratch[thread];

    for (size_t n = begin; n < end; n++) {
        place_block(w, w->sample ? w->sample[n] : n, b);
        fetch_ids(w->view, b, 1);
        find_candidates(w, b);
        if (b->candidate_count)
            do_block(w, b, thread);
    }
}

/* ---- the sample ---- */

/* @return the block that is looked at as number @p n: in steps of the golden ratio, so that any
 * first few lie all over the volume. */
static size_t looked_at(const noise_work *w, size_t n)
{
    const size_t all = w->blocks[0] * w->blocks[1] * w->blocks[2];

    return (size_t)(fmod((double)n * 0.6180339887498949, 1) * (double)all);
}

/* Is a place of the window outside of the volume? */
static bool is_outside(const drawn_view *view, const block *b, const int at[3])
{
    bool outside = false;

    for (int i = 0; i < 3; i++) {
        const ptrdiff_t place = (ptrdiff_t)b->low[i] + at[i] - ROW_REACH;

        outside = outside || place < 0 || place >= view->size[i];
    }
    return outside;
}

/* Does only one label lie at the faces of the volume within the window of a block? Where shapes are
 * cut off by a face their borders bend, and that is no noise. */
static bool is_whole(const drawn_view *view, block *b)
{
    const int first[3] = {0, 0, 0}, last[3] = {ROW_WINDOW - 1, ROW_WINDOW - 1, ROW_WINDOW - 1};
    int label = -1;

    if (!is_outside(view, b, first) && !is_outside(view, b, last))
        return true;
    fetch_ids(view, b, ROW_REACH);
    for (int z = 0; z < ROW_WINDOW; z++) {
        for (int y = 0; y < ROW_WINDOW; y++) {
            for (int x = 0; x < ROW_WINDOW; x++) {
                const int id = b->ids[(z * ROW_WINDOW + y) * ROW_WINDOW + x];

                if (!is_outside(view, b, (int[3]){x, y, z}))
                    continue;
                if (label >= 0 && id != label)
                    return false;
                label = id;
            }
        }
    }
    return true;
}

/* Note which of the blocks that are looked at hold borders; an sc_range_fn on noise_work. */
static void look_for_borders(void *user, size_t begin, size_t end, int thread)
{
    const noise_work *w = user;
    block *b = &w->scratch[thread];

    for (size_t n = begin; n < end; n++) {
        place_block(w, looked_at(w, n), b);
        fetch_ids(w->view, b, 1);
        find_candidates(w, b);
        w->has_border[n] = b->candidate_count > 0 && is_whole(w->view, b);
    }
}

/* Make the filters and the scratch memory for a volume. @return SC_ERR_MEMORY. */
static sc_status make_work(const sc_ctx *ctx, const drawn_view *view, const double drawn_mm[3],
                           int threads, noise_work *w)
{
    double shortest = HUGE_VAL, steps[3];
    void *block_;
    sc_status status;

    w->view = view;
    for (int i = 0; i < 3; i++) {
        w->blocks[i] = ((size_t)view->size[i] + ROW_BLOCK - 1) / ROW_BLOCK;
        shortest = fmin(shortest, drawn_mm[i]);
    }
    for (int i = 0; i < 3; i++)
        steps[i] = drawn_mm[i] / shortest;
    for (int s = 0; s < SCALES; s++)
        SC_TRY(make_scale(ctx, s, steps, &w->scales[s]));
    SC_TRY(sc_zalloc(ctx, (size_t)threads, sizeof *w->scratch, &block_));
    w->scratch = block_;
    SC_TRY(sc_zalloc(ctx, (size_t)threads, sizeof *w->counts, &block_));
    w->counts = block_;
out:
    return status;
}

static void clear_work(noise_work *w)
{
    for (int s = 0; s < SCALES; s++) {
        sc_row_filter_clear(&w->scales[s].membership);
        sc_row_filter_clear(&w->scales[s].value);
        sc_row_filter_clear(&w->scales[s].slope);
    }
    sc_free(w->scratch);
    sc_free(w->counts);
    sc_free(w->sample);
}

sc_status sc_resample_measure_noise(const sc_ctx *ctx, sc_team *team, const drawn_view *view,
                                    const double drawn_mm[3], double *share)
{
    const int threads = sc_team_threads(team), ranks = sc_team_ranks(team);
    noise_work w = {0};
    size_t looked, count = 0;
    uint64_t found[2] = {0, 0}; /* candidates, and those to change */
    const uint64_t *all;
    void *block_ = NULL, *has_border = NULL;
    sc_status status = make_work(ctx, view, drawn_mm, threads, &w);

    if (status == SC_OK)
        status = sc_alloc(ctx, SAMPLE_BLOCKS, sizeof *w.sample, &block_);
    w.sample = block_;
    SC_TRY(sc_team_agree(team, status));
    looked = w.blocks[0] * w.blocks[1] * w.blocks[2];
    looked = looked < LOOKED_AT ? looked : LOOKED_AT;
    SC_TRY(sc_team_alloc(ctx, team, looked, 1, &has_border));
    w.has_border = has_border;
    sc_team_for(team, looked, 64, look_for_borders, &w);
    for (size_t n = 0; n < looked && count < SAMPLE_BLOCKS; n++) {
        if (w.has_border[n])
            w.sample[count++] = looked_at(&w, n);
    }
    sc_team_for(team, count, 4, do_blocks, &w);
    for (int t = 0; t < threads; t++) {
        found[0] += w.counts[t][0];
        found[1] += w.counts[t][1];
    }
    SC_TRY(sc_team_collect(ctx, team, found, sizeof found, &block_));
    all = block_;
    found[0] = found[1] = 0;
    for (int rank = 0; rank < ranks; rank++) {
        found[0] += all[2 * rank];
        found[1] += all[2 * rank + 1];
    }
    sc_team_free(team, block_);
    *share = found[0] ? (double)found[1] / (double)found[0] : 0;
out:
    sc_team_free(team, has_border);
    clear_work(&w);
    return status;
}

sc_status sc_resample_remove_noise(const sc_ctx *ctx, sc_volume *v, const double drawn_mm[3],
                                   int threads)
{
    const sc_drawn_grid whole = {.copies = {1, 1, 1}};
    const size_t bytes = sc_volume_voxels(v) * (size_t)v->label_bytes;
    drawn_view view = {0};
    noise_work w = {0};
    sc_status status;

    SC_TRY(sc_drawn_view_make(ctx, v, &whole, &view));
    SC_TRY(make_work(ctx, &view, drawn_mm, threads, &w));
    SC_TRY(sc_alloc(ctx, bytes, 1, &w.out));
    memcpy(w.out, v->ids, bytes);
    sc_parallel_for(threads, w.blocks[0] * w.blocks[1] * w.blocks[2], 16, do_blocks, &w);
    sc_free(v->ids);
    v->ids = w.out;
out:
    clear_work(&w);
    sc_drawn_view_clear(&view);
    return status;
}
