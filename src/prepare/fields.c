/* SPDX-License-Identifier: BSD-3-Clause */
/* The fields from which smooth surfaces are drawn, at every vertex near an interface. The
 * membership of a label is 1 at vertices that carry it and 0 elsewhere. Smoothed, it gives two
 * things.
 *
 * The weight of a vertex is half of the difference between the smoothed membership of its own label
 * and the largest one of any other label. Between two labels that is the membership less one half;
 * where three meet, their surfaces end in a smooth line. The filter is a flat-topped low-pass: a
 * Gaussian of width s moves a curved surface inward, and multiplying its spectrum by the first
 * terms of the series of exp(c k^2), with c = s^2 / 2, undoes that. The first two orders do most of
 * it. Here three quarters of the third are added, and c is a little larger: this keeps tubes of
 * radius 1 as well, and makes up for the shrinking by the trilinear interpolation of the weights.
 *
 * The gradient, for light, is that of the membership smoothed by a wider Gaussian.
 *
 * To be fast, one label at a time is filtered for all vertices of a brick. Each row of the window
 * around the brick becomes 16 bits that say which vertices carry the label. Tables hold, for every
 * pattern of 16 bits, the weighted sums for the four vertices of the brick along the row. */
#include "filters.h"

#include <string.h>
#ifdef __SSE2__
#include <emmintrin.h>
#endif

enum {
    RADIUS = 6,                     /* of both filters, in vertices */
    WINDOW = SC_BRICK + 2 * RADIUS, /* edge of the block of vertices that a brick depends on: 16 */
    TAPS = 2 * RADIUS + 1,
    PATTERNS = 1 << WINDOW,
    ROWS = WINDOW * WINDOW
};

typedef sc_quad quad;

/* A row of the window in which the filter for weights is not 0. */
typedef struct weight_row {
    int offset;       /* rows of the window before it, for the brick's vertices at y = z = 0 */
    int table;        /* which table applies to it: rows at the same distance share one */
    const quad *sums; /* that table, [PATTERNS], borrowed from filters.weight_tables */
} weight_row;

/* A filter for normals: a Gaussian and its derivative, scaled so that the gradient at a flat
 * interface has length 1. */
typedef struct normal_filter {
    quad (*table)[2];     /* [PATTERNS], owned: a row's smoothed value and derivative along x */
    float value[3][TAPS]; /* taps of the Gaussian along each axis, of sum 1 */
    float slope[3][TAPS]; /* taps of its derivative along each axis */
} normal_filter;

/* The filters of a volume, which the threads share. The tables are owned. */
typedef struct filters {
    const sc_preparation *p;
    sc_vec3 strength;             /* of all labels */
    float gain;                   /* what weights are multiplied by */
    const uint8_t *marked;        /* [brick_count], borrowed: which bricks to do; NULL: all */
    weight_row rows[TAPS * TAPS]; /* [row_count] of them */
    int row_count, table_count;
    quad *weight_tables; /* [table_count][PATTERNS]; NULL where surfaces are crisp (smooth 0) */
    normal_filter wide, narrow;
    double to_mm[3][3]; /* gradient per reference voxel along the axes of the grid -> RAS */
} filters;

static double squared(double x)
{
    return x * x;
}

/* Fill a table: for every pattern of a row and each of the four vertices x along it, the sum of the
 * taps whose bits are set; the taps of vertex x begin at bit x.
 * @param stride quads from the sums of a pattern to those of the next. */
static void fill_table(quad *table, size_t stride, const float taps[TAPS])
{
    table[0] = (quad){0, 0, 0, 0};
    for (int bits = 1; bits < PATTERNS; bits++) {
        const int column = __builtin_ctz((unsigned)bits);
        quad sum = table[(size_t)(bits & (bits - 1)) * stride];

        for (int x = 0; x < SC_BRICK; x++)
            sum[x] += column >= x && column - x < TAPS ? taps[column - x] : 0;
        table[(size_t)bits * stride] = sum;
    }
}

/* Fill rows, row_count, table_count and weight_tables of @p f, which must be zero. @param steps of
 * steps_of. Returns SC_ERR_MEMORY. */
static sc_status fill_weights(const sc_ctx *ctx, filters *f, const double steps[3])
{
    const sc_weight_filter w = sc_weight_filter_of(steps, f->strength);
    double squares[TAPS * TAPS], total = 0;
    void *block;
    sc_status status;

    for (int dz = -RADIUS; dz <= RADIUS; dz++) {
        for (int dy = -RADIUS; dy <= RADIUS; dy++) {
            const double square = squared(dy * w.steps[1]) + squared(dz * w.steps[2]);

            if (sc_weight_filter_at(&w, square) != 0)
                f->rows[f->row_count++] =
                    (weight_row){(dz + RADIUS) * WINDOW + dy + RADIUS,
                                 sc_filter_table_of(squares, &f->table_count, square), NULL};
        }
    }
    status = sc_alloc(ctx, (size_t)f->table_count * PATTERNS, sizeof(quad), &block);
    if (status != SC_OK)
        return status;
    f->weight_tables = block;
    for (int i = 0; i < f->row_count; i++) {
        f->rows[i].sums = f->weight_tables + (size_t)f->rows[i].table * PATTERNS;
        for (int x = -RADIUS; x <= RADIUS; x++)
            total += sc_weight_filter_at(&w, squares[f->rows[i].table] + squared(x * w.steps[0]));
    }
    for (int t = 0; t < f->table_count; t++) {
        float taps[TAPS];

        for (int x = -RADIUS; x <= RADIUS; x++)
            taps[x + RADIUS] =
                (float)(sc_weight_filter_at(&w, squares[t] + squared(x * w.steps[0])) / total);
        fill_table(f->weight_tables + (size_t)t * PATTERNS, 1, taps);
    }
    return SC_OK;
}

/* Fill @p b with the filter for normals of a given width: a Gaussian and its derivative.
 * @param steps of sc_filter_steps. @param width standard deviation in reference voxels. Returns
 * SC_ERR_MEMORY. */
static sc_status fill_normal_filter(const sc_ctx *ctx, normal_filter *b, const double steps[3],
                                    double width)
{
    void *block;
    sc_status status = sc_alloc(ctx, PATTERNS, sizeof *b->table, &block);

    if (status != SC_OK)
        return status;
    b->table = block;
    for (int axis = 0; axis < 3; axis++)
        sc_normal_taps(RADIUS, steps[axis], width, b->value[axis], b->slope[axis]);
    fill_table(&b->table[0][0], 2, b->value[0]);
    fill_table(&b->table[0][1], 2, b->slope[0]);
    return SC_OK;
}

/* Fill the tables and to_mm of @p f, which must be zero. Returns SC_ERR_MEMORY; the caller frees
 * the tables in any case. */
static sc_status fill_filters(const sc_ctx *ctx, filters *f)
{
    const sc_volume *v = f->p->volume;
    double steps[3];
    sc_status status;

    sc_filter_steps(v, steps);
    if (sc_most_strength(f->strength) > 0)
        SC_TRY(fill_weights(ctx, f, steps));
    SC_TRY(fill_normal_filter(ctx, &f->wide, steps, SC_NORMAL_WIDTH));
    SC_TRY(fill_normal_filter(ctx, &f->narrow, steps, SC_NARROW_WIDTH));
    sc_gradient_to_mm(v, steps, f->to_mm);
out:
    return status;
}

/* The work on one brick. "The current label" is the one that is being filtered. */
typedef struct brick_work {
    uint16_t ids[ROWS][WINDOW];           /* labels of the window, [z and y][x] */
    uint32_t bits[ROWS];                  /* which vertices of a row carry the current label */
    quad value[ROWS], along_x[ROWS];      /* [z][y]: rows filtered along x */
    quad flat[WINDOW][SC_BRICK];          /* [z][y]: filtered along x and y */
    quad along_xy[WINDOW][SC_BRICK][2];   /* the derivatives along x and y, in the same layout */
    float gradient[SC_BRICK_VERTICES][3]; /* of the current label, per reference voxel, along the
                                             axes of the grid */
    uint16_t labels[ROWS * WINDOW];       /* the distinct labels of the window */
    /* results */
    float own[SC_BRICK_VERTICES];        /* smoothed membership of a vertex's own label */
    float other[SC_BRICK_VERTICES];      /* the largest one of any other label */
    float outward[SC_BRICK_VERTICES][3]; /* gradient of a vertex's own label, negated */
} brick_work;

/* Write the labels of the window around the brick whose lowest vertex is @p low to w->ids; vertices
 * outside of the volume get the label of the nearest voxel. */
static void fetch_window(const sc_volume *v, const int low[3], brick_work *w)
{
    const int x0 = low[0] - 1 - RADIUS;

    for (int row = 0; row < ROWS; row++) {
        const int y = low[1] - 1 - RADIUS + row % WINDOW, z = low[2] - 1 - RADIUS + row / WINDOW;

        if (x0 >= 0 && x0 + WINDOW <= v->size[0] && y >= 0 && z >= 0 && y < v->size[1] &&
            z < v->size[2]) {
            sc_copy_ids(
                v, ((size_t)z * (size_t)v->size[1] + (size_t)y) * (size_t)v->size[0] + (size_t)x0,
                WINDOW, w->ids[row]);
            continue;
        }
        for (int x = 0; x < WINDOW; x++)
            w->ids[row][x] = (uint16_t)sc_id_or_nearest(v, x0 + x, y, z);
    }
}

/* @return the vertices of a row of the window that carry @p id, as bits. @param ids [WINDOW]
 * labels. */
#ifdef __SSE2__
static inline uint32_t row_bits(const uint16_t *ids, uint16_t id)
{
    const __m128i wanted = _mm_set1_epi16((int16_t)id);
    const __m128i low =
        _mm_cmpeq_epi16(_mm_loadu_si128((const __m128i *)(const void *)ids), wanted);
    const __m128i high =
        _mm_cmpeq_epi16(_mm_loadu_si128((const __m128i *)(const void *)(ids + 8)), wanted);

    return (uint32_t)_mm_movemask_epi8(_mm_packs_epi16(low, high));
}
#else
static inline uint32_t row_bits(const uint16_t *ids, uint16_t id)
{
    uint32_t bits = 0;

    for (int x = 0; x < WINDOW; x++)
        bits |= (uint32_t)(ids[x] == id) << x;
    return bits;
}
#endif

/* Make @p id the current label: fill w->bits. Needs w->ids. */
static void fill_bits(brick_work *w, uint16_t id)
{
    for (int row = 0; row < ROWS; row++)
        w->bits[row] = row_bits(w->ids[row], id);
}

/* Write the gradients of the current label (w->bits) at all vertices of the brick to w->gradient:
 * filtered along x by the table, then along y and z tap by tap. */
static void find_gradients(const normal_filter *b, brick_work *w)
{
    for (int row = 0; row < ROWS; row++) {
        const quad *sums = b->table[w->bits[row]];

        w->value[row] = sums[0];
        w->along_x[row] = sums[1];
    }
    for (int z = 0; z < WINDOW; z++) {
        for (int y = 0; y < SC_BRICK; y++) {
            const int row = z * WINDOW + y;
            quad flat = {0}, along_x = {0}, along_y = {0};

            for (int i = 0; i < TAPS; i++) {
                flat += w->value[row + i] * b->value[1][i];
                along_y += w->value[row + i] * b->slope[1][i];
                along_x += w->along_x[row + i] * b->value[1][i];
            }
            w->flat[z][y] = flat;
            w->along_xy[z][y][0] = along_x;
            w->along_xy[z][y][1] = along_y;
        }
    }
    for (int bit = 0; bit < SC_BRICK_VERTICES; bit += SC_BRICK) {
        const int y = sc_bit_y(bit), z = sc_bit_z(bit);
        quad along[3] = {{0}, {0}, {0}};

        for (int i = 0; i < TAPS; i++) {
            along[0] += w->along_xy[z + i][y][0] * b->value[2][i];
            along[1] += w->along_xy[z + i][y][1] * b->value[2][i];
            along[2] += w->flat[z + i][y] * b->slope[2][i];
        }
        for (int x = 0; x < SC_BRICK; x++) {
            for (int axis = 0; axis < 3; axis++)
                w->gradient[bit + x][axis] = along[axis][x];
        }
    }
}

/* Write the smoothed memberships of the current label at the sixteen vertices of layer @p z of the
 * brick to @p out, [y][x]. The four sums do not depend on each other, so that the processor adds to
 * all of them at once. */
static void memberships_of(const filters *f, const brick_work *w, int z, quad out[SC_BRICK])
{
    const uint32_t *bits = w->bits + z * WINDOW;
    quad sum[SC_BRICK] = {{0}};

    for (int i = 0; i < f->row_count; i++) {
        const quad *sums = f->rows[i].sums;
        const uint32_t *row = bits + f->rows[i].offset;

        for (int y = 0; y < SC_BRICK; y++)
            sum[y] += sums[row[y]];
    }
    memcpy(out, sum, sizeof sum);
}

/* @return the label, in w->ids, of the vertex of a bit of the brick. */
static uint16_t id_of_bit(const brick_work *w, int bit)
{
    return w
        ->ids[(sc_bit_z(bit) + RADIUS) * WINDOW + sc_bit_y(bit) + RADIUS][sc_bit_x(bit) + RADIUS];
}

/* @return those vertices of @p mask that carry @p id. */
static uint64_t vertices_of(const brick_work *w, uint64_t mask, uint16_t id)
{
    uint64_t vertices = 0;

    for (; mask; mask &= mask - 1) {
        const int bit = __builtin_ctzll(mask);

        if (id_of_bit(w, bit) == id)
            vertices |= 1ull << bit;
    }
    return vertices;
}

/* Set w->own of the vertices of @p own, which carry the current label, to its smoothed membership,
 * and raise w->other of all others to it. Does nothing where surfaces are crisp.
 * @param mask vertices near an interface; whole layers without one are left out. */
static void update_memberships(const filters *f, brick_work *w, uint64_t mask, uint64_t own)
{
    for (int first = 0; first < SC_BRICK_VERTICES && f->weight_tables; first += SC_BRICK_LAYER) {
        quad memberships[SC_BRICK];

        if (!(mask >> first & SC_BRICK_LAYER_BITS))
            continue;
        memberships_of(f, w, sc_bit_z(first), memberships);
        for (int bit = first; bit < first + SC_BRICK_LAYER; bit++) {
            const float membership = memberships[sc_bit_y(bit)][sc_bit_x(bit)];

            if (own >> bit & 1)
                w->own[bit] = membership;
            else if (membership > w->other[bit])
                w->other[bit] = membership;
        }
    }
}

/* Set w->outward of the vertices of @p mask against the rise of the current label: by the wide
 * filter, and where tissue is thin, by a blend with the narrow one. Overwrites w->gradient. */
static void store_gradients(const filters *f, brick_work *w, uint64_t mask)
{
    uint64_t thin = 0;

    find_gradients(&f->wide, w);
    for (uint64_t left = mask; left; left &= left - 1) {
        const int bit = __builtin_ctzll(left);

        for (int i = 0; i < 3; i++)
            w->outward[bit][i] = -w->gradient[bit][i]; /* against the rise of the label */
        if (sc_gradient_length(w->outward[bit]) < SC_THIN_FROM)
            thin |= 1ull << bit;
    }
    if (!thin)
        return;
    find_gradients(&f->narrow, w);
    for (; thin; thin &= thin - 1) {
        const int bit = __builtin_ctzll(thin);
        const float share = sc_thin_share(sc_gradient_length(w->outward[bit]));

        for (int i = 0; i < 3; i++)
            w->outward[bit][i] += share * (-w->gradient[bit][i] - w->outward[bit][i]);
    }
}

/* Reverse w->outward of the vertices of @p mask. */
static void turn_gradients(brick_work *w, uint64_t mask)
{
    for (; mask; mask &= mask - 1) {
        for (int i = 0; i < 3; i++)
            w->outward[__builtin_ctzll(mask)][i] *= -1;
    }
}

/* Write the distinct labels of the window to w->labels. Those that vertices of @p mask carry come
 * first, and the first one becomes the current label. @param mask not empty. @return how many there
 * are. */
static int find_labels(brick_work *w, uint64_t mask)
{
    int count = 0, carried;

    for (; mask; mask &= ~vertices_of(w, mask, w->labels[count - 1]))
        w->labels[count++] = id_of_bit(w, __builtin_ctzll(mask));
    carried = count;
    for (int row = 0; row < ROWS; row++) {
        uint32_t known = w->bits[row] = row_bits(w->ids[row], w->labels[0]);

        for (int i = 1; i < carried; i++)
            known |= row_bits(w->ids[row], w->labels[i]);
        for (uint32_t left = ~known & (PATTERNS - 1); left; left &= left - 1) {
            const uint16_t id = w->ids[row][__builtin_ctz(left)];
            int i = carried;

            while (i < count && w->labels[i] != id)
                i++;
            if (i == count)
                w->labels[count++] = id;
        }
    }
    return count;
}

/* Write own, other and outward of @p w at the vertices of @p mask, from w->ids. If the window holds
 * two labels, one label tells about both: their memberships add up to 1, and their gradients are
 * opposite. */
static void filter_brick(const filters *f, brick_work *w, uint64_t mask)
{
    const int count = find_labels(w, mask);

    memset(w->other, 0, sizeof w->other);
    for (int i = 0; i < count; i++) {
        const uint64_t own = vertices_of(w, mask, w->labels[i]);

        if (i > 0)
            fill_bits(w, w->labels[i]);
        update_memberships(f, w, mask, own);
        if (count == 2)
            store_gradients(f, w, mask);
        else if (own)
            store_gradients(f, w, own);
        if (count == 2) {
            turn_gradients(w, mask & ~own);
            for (uint64_t left = mask; left; left &= left - 1) {
                const int bit = __builtin_ctzll(left);

                if (own >> bit & 1)
                    w->other[bit] = 1 - w->own[bit];
                else
                    w->own[bit] = 1 - w->other[bit];
            }
            return;
        }
    }
}

/* @return the vertex record of the vertex of a bit, from own, other and outward of @p w. The weight
 * is kept within SC_WEIGHT_LEAST and SC_WEIGHT_MAX; where surfaces are crisp, it is the gain. */
static uint32_t record_of(const filters *f, const brick_work *w, int bit)
{
    const float margin = f->weight_tables ? w->own[bit] - w->other[bit] : 1;
    const float scaled = margin * f->gain * SC_WEIGHT_MAX + 0.5f;
    const int weight = !(scaled > SC_WEIGHT_LEAST) ? SC_WEIGHT_LEAST
                       : scaled < SC_WEIGHT_MAX    ? (int)scaled
                                                   : SC_WEIGHT_MAX;

    return sc_field_record(f->to_mm, weight, w->outward[bit]);
}

/* Write the records of a brick's vertices near an interface to the preparation. */
static void store_records(const filters *f, const brick_work *w, size_t brick)
{
    size_t index = f->p->near_start[brick];

    for (uint64_t left = f->p->near[brick]; left; left &= left - 1)
        sc_record_write(f->p->records, index++, record_of(f, w, __builtin_ctzll(left)));
}

/* Fill the records of bricks [begin, end); an sc_range_fn on filters. */
static void fields_of_bricks(void *user, size_t begin, size_t end, int thread)
{
    const filters *f = user;
    brick_work w;

    (void)thread;
    for (size_t brick = begin; brick < end; brick++) {
        int low[3];

        if (!f->p->near[brick] || (f->marked && !f->marked[brick]))
            continue;
        sc_brick_low(f->p->bricks, brick, low);
        fetch_window(f->p->volume, low, &w);
        filter_brick(f, &w, f->p->near[brick]);
        store_records(f, &w, brick);
    }
}

/* Fill the records of the bricks by filters of which p, strength, gain and marked are set, the rest
 * being zero. @param worth as of sc_stage_for. Returns SC_ERR_MEMORY. */
static sc_status fill_records(const sc_ctx *ctx, filters *f, uint64_t worth)
{
    const sc_status status = sc_team_agree(f->p->team, fill_filters(ctx, f));

    if (status == SC_OK)
        sc_team_stage_for(ctx, worth, f->p->team, f->p->brick_count, 1024, fields_of_bricks, f);
    sc_free(f->weight_tables);
    sc_free(f->wide.table);
    sc_free(f->narrow.table);
    return status;
}

sc_status sc_find_fields(const sc_ctx *ctx, sc_preparation *p)
{
    filters f = {.p = p, .strength = p->kinds[0], .gain = 1};
    void *block;
    sc_status status;

    SC_TRY(sc_team_alloc(ctx, p->team, p->near_count, SC_RECORD_BYTES, &block));
    p->records = block;
    SC_TRY(fill_records(ctx, &f, SC_WORTH_FIELDS));
out:
    return status;
}

sc_status sc_find_fields_of_bricks(const sc_ctx *ctx, const sc_preparation *p, sc_vec3 strength,
                                   float gain, const uint8_t *marked)
{
    filters f = {.p = p, .strength = strength, .gain = gain, .marked = marked};

    return fill_records(ctx, &f, 0);
}
