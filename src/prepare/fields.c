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
 * The gradient, for light, is that of the membership smoothed by a wider Gaussian; at vertices of
 * tissue beside the background and no other tissue, that of the background, where its border is
 * flat.
 *
 * To be fast, one label at a time is filtered for all vertices of a brick. Each row of the window
 * around the brick becomes 16 bits that say which vertices carry the label. Tables hold, for every
 * pattern of 16 bits, the weighted sums for the four vertices of the brick along the row. */
#include "gradients.h"

#include <string.h>
#ifdef __SSE2__
#include <emmintrin.h>
#endif

enum {
    RADIUS = SC_FIELD_RADIUS,
    WINDOW = SC_FIELD_WINDOW,
    TAPS = SC_FIELD_TAPS,
    PATTERNS = SC_FIELD_PATTERNS,
    ROWS = SC_FIELD_ROWS,
    TABLES_MAX = (RADIUS + 1) * (RADIUS + 1) /* rows that lie as far off along y and z share one */
};

typedef sc_quad quad;

/* A row of the window in which the filter for weights is not 0. */
typedef struct weight_row {
    int offset; /* rows of the window before it, for the brick's vertices at y = z = 0 */
    int table;  /* which table applies to it: rows at the same distance share one */
} weight_row;

/* The filters of a volume, which the threads share. The tables are owned. */
typedef struct filters {
    const sc_preparation *p;
    sc_vec3 strength;             /* of all labels */
    float gain;                   /* what weights are multiplied by */
    const uint8_t *marked;        /* [brick_count], borrowed: which bricks to do; NULL: all */
    weight_row rows[TAPS * TAPS]; /* [row_count] of them */
    int row_count, table_count;
    quad *weight_tables; /* [PATTERNS][table_count], so that what is needed of a row lies together;
                            NULL where surfaces are crisp (smooth 0) */
    sc_normal_filter wide, narrow;
    sc_gradients_fn *find_gradients; /* the fastest for this processor */
    double to_mm[3][3]; /* gradient per reference voxel along the axes of the grid -> RAS */
} filters;

static double squared(double x)
{
    return x * x;
}

/* Fill @p count tables [PATTERNS][count]: for every pattern of a row and each of the four vertices
 * x along it, the sum of the taps whose bits are set; the taps of vertex x begin at bit x. Pattern
 * by pattern, since the tables together are larger than the caches.
 * @param taps [count], of each table. */
static void fill_tables(quad *tables, int count, const float (*taps)[TAPS])
{
    quad added[WINDOW][TABLES_MAX]; /* by the bit of a column */

    for (int column = 0; column < WINDOW; column++) {
        for (int t = 0; t < count; t++) {
            for (int x = 0; x < SC_BRICK; x++)
                added[column][t][x] = column >= x && column - x < TAPS ? taps[t][column - x] : 0;
        }
    }
    for (int t = 0; t < count; t++)
        tables[t] = (quad){0, 0, 0, 0};
    for (int bits = 1; bits < PATTERNS; bits++) {
        const quad *lowest = added[__builtin_ctz((unsigned)bits)];
        const quad *others = tables + (size_t)(bits & (bits - 1)) * (size_t)count;
        quad *sums = tables + (size_t)bits * (size_t)count;

        for (int t = 0; t < count; t++)
            sums[t] = others[t] + lowest[t];
    }
}

/* Fill rows, row_count, table_count and weight_tables of @p f, which must be zero. @param steps of
 * steps_of. Returns SC_ERR_MEMORY. */
static sc_status fill_weights(const sc_ctx *ctx, filters *f, const double steps[3])
{
    const sc_weight_filter w = sc_weight_filter_of(steps, f->strength);
    double squares[TAPS * TAPS], total = 0;
    float taps[TABLES_MAX][TAPS];
    void *block;
    sc_status status;

    for (int dz = -RADIUS; dz <= RADIUS; dz++) {
        for (int dy = -RADIUS; dy <= RADIUS; dy++) {
            const double square = squared(dy * w.steps[1]) + squared(dz * w.steps[2]);

            if (sc_weight_filter_at(&w, square) != 0)
                f->rows[f->row_count++] =
                    (weight_row){(dz + RADIUS) * WINDOW + dy + RADIUS,
                                 sc_filter_table_of(squares, &f->table_count, square)};
        }
    }
    status = sc_alloc(ctx, (size_t)f->table_count * PATTERNS, sizeof(quad), &block);
    if (status != SC_OK)
        return status;
    f->weight_tables = block;
    for (int i = 0; i < f->row_count; i++) {
        for (int x = -RADIUS; x <= RADIUS; x++)
            total += sc_weight_filter_at(&w, squares[f->rows[i].table] + squared(x * w.steps[0]));
    }
    for (int t = 0; t < f->table_count; t++) {
        for (int x = -RADIUS; x <= RADIUS; x++)
            taps[t][x + RADIUS] =
                (float)(sc_weight_filter_at(&w, squares[t] + squared(x * w.steps[0])) / total);
    }
    fill_tables(f->weight_tables, f->table_count, taps);
    return SC_OK;
}

/* Fill @p b with the filter for normals of a given width: a Gaussian and its derivative.
 * @param steps of sc_filter_steps. @param width standard deviation in reference voxels. Returns
 * SC_ERR_MEMORY. */
static sc_status fill_normal_filter(const sc_ctx *ctx, sc_normal_filter *b, const double steps[3],
                                    double width)
{
    float taps[2][TAPS]; /* of values, and of slopes */
    void *block;
    sc_status status = sc_alloc(ctx, PATTERNS, sizeof *b->table, &block);

    if (status != SC_OK)
        return status;
    b->table = block;
    for (int axis = 0; axis < 3; axis++)
        sc_normal_taps(RADIUS, steps[axis], width, b->value[axis], b->slope[axis]);
    memcpy(taps[0], b->value[0], sizeof taps[0]);
    memcpy(taps[1], b->slope[0], sizeof taps[1]);
    fill_tables(b->table[0], 2, taps);
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
    f->find_gradients = sc_gradients_fastest();
out:
    return status;
}

/* The work on one brick. "The current label" is the one that is being filtered. */
typedef struct brick_work {
    int low[3];                     /* the brick's lowest vertex */
    bool by_border;                 /* of the volume: the window reaches beyond it */
    uint16_t ids[ROWS][WINDOW];     /* labels of the window, [z and y][x] */
    uint32_t bits[ROWS];            /* which vertices of a row carry the current label */
    const quad *sums[ROWS];         /* [table_count] of weight_tables: of the row's bits */
    sc_gradients gradients;         /* of the current label */
    uint16_t labels[ROWS * WINDOW]; /* the distinct labels of the window */
    /* results */
    float own[SC_BRICK_VERTICES];        /* smoothed membership of a vertex's own label */
    float other[SC_BRICK_VERTICES];      /* the largest one of any other label */
    float outward[SC_BRICK_VERTICES][3]; /* gradient of a vertex's own label, negated; mended beside
                                            the background: sc_mend_beside_background */
} brick_work;

/* Does the window whose lowest voxel is @p low lie in the volume? */
static bool is_inside(const sc_volume *v, const int low[3])
{
    for (int i = 0; i < 3; i++) {
        if (low[i] < 0 || low[i] + WINDOW > v->size[i])
            return false;
    }
    return true;
}

/* Write the labels of the window around the brick whose lowest vertex is @p vertex to w->ids;
 * vertices outside of the volume get the label of the nearest voxel. */
static void fetch_window(const sc_volume *v, const int vertex[3], brick_work *w)
{
    const int low[3] = {vertex[0] - 1 - RADIUS, vertex[1] - 1 - RADIUS, vertex[2] - 1 - RADIUS};
    const size_t line = (size_t)v->size[0], layer = line * (size_t)v->size[1];
    const bool inside = is_inside(v, low);
    const size_t first =
        inside ? (size_t)low[2] * layer + (size_t)low[1] * line + (size_t)low[0] : 0;

    for (int row = 0; row < ROWS; row++) {
        const size_t y = (size_t)row % WINDOW, z = (size_t)row / WINDOW;

        if (inside)
            sc_copy_ids(v, first + z * layer + y * line, WINDOW, w->ids[row]);
        for (int x = 0; x < WINDOW && !inside; x++)
            w->ids[row][x] =
                (uint16_t)sc_id_or_nearest(v, low[0] + x, low[1] + (int)y, low[2] + (int)z);
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

/* Write the smoothed memberships of the current label at the vertices of layers @p z and z + 1 of
 * the brick to @p out, [z][y][x]. The eight sums do not depend on each other, so that the processor
 * adds to all of them at once. */
static void memberships_of(const filters *f, const brick_work *w, int z, quad out[2][SC_BRICK])
{
    const quad *const *sums = w->sums + z * WINDOW;
    quad sum[2][SC_BRICK] = {{{0}}};

    for (int i = 0; i < f->row_count; i++) {
        const quad *const *row = sums + f->rows[i].offset;
        const ptrdiff_t table = f->rows[i].table;

        for (int y = 0; y < SC_BRICK; y++) {
            sum[0][y] += row[y][table];
            sum[1][y] += row[WINDOW + y][table];
        }
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
 * @param mask vertices near an interface; pairs of layers without one are left out. */
static void update_memberships(const filters *f, brick_work *w, uint64_t mask, uint64_t own)
{
    for (int row = 0; row < ROWS && f->weight_tables; row++)
        w->sums[row] = f->weight_tables + (size_t)w->bits[row] * (size_t)f->table_count;
    for (int z = 0; z < SC_BRICK && f->weight_tables; z += 2) {
        const int first = sc_brick_bit(0, 0, z), end = first + 2 * SC_BRICK_LAYER;
        quad memberships[2][SC_BRICK];

        if (!(mask >> first &
              ((uint64_t)SC_BRICK_LAYER_BITS << SC_BRICK_LAYER | SC_BRICK_LAYER_BITS)))
            continue;
        memberships_of(f, w, z, memberships);
        for (int bit = first; bit < end; bit++) {
            const float membership = memberships[sc_bit_z(bit) - z][sc_bit_y(bit)][sc_bit_x(bit)];

            if (own >> bit & 1)
                w->own[bit] = membership;
            else if (membership > w->other[bit])
                w->other[bit] = membership;
        }
    }
}

/* Find the gradients of the current label at the vertices of @p mask, by the filter @p n, to
 * w->gradients. */
static void find_gradients(const filters *f, const sc_normal_filter *n, brick_work *w,
                           uint64_t mask)
{
    const float *const slope[3] = {n->slope[0], n->slope[1], n->slope[2]};

    f->find_gradients(n, w->bits, mask, &w->gradients);
    for (; w->by_border && mask; mask &= mask - 1) {
        const int bit = __builtin_ctzll(mask);
        const int voxel[3] = {w->low[0] - 1 + sc_bit_x(bit), w->low[1] - 1 + sc_bit_y(bit),
                              w->low[2] - 1 + sc_bit_z(bit)};
        float gradient[3];

        for (int i = 0; i < 3; i++)
            gradient[i] = w->gradients.along[i][bit];
        sc_gradient_at_border(f->p->volume, voxel, RADIUS, slope, gradient);
        for (int i = 0; i < 3; i++)
            w->gradients.along[i][bit] = gradient[i];
    }
}

/* @return the membership of the current label at the vertex of a bit, smoothed by the filter @p n,
 * by which find_gradients has just found gradients in its layer. */
static float membership_at(const sc_normal_filter *n, const brick_work *w, int bit)
{
    float sum = 0;

    for (int i = 0; i < TAPS; i++)
        sum += w->gradients.flat[sc_bit_z(bit) + i][sc_bit_y(bit)][sc_bit_x(bit)] * n->value[2][i];
    return sum;
}

/* Set @p outward of the vertices of @p mask against the rise of the current label: by the wide
 * filter, and where tissue is thin, by a blend with the narrow one. Overwrites w->gradients.
 * @param membership of the wide filter at these vertices, to be set; NULL: not needed. */
static void store_gradients(const filters *f, brick_work *w, uint64_t mask,
                            float outward[SC_BRICK_VERTICES][3], float *membership)
{
    const float(*along)[SC_BRICK_VERTICES] = w->gradients.along;
    uint64_t thin = 0;

    find_gradients(f, &f->wide, w, mask);
    for (uint64_t left = mask; left; left &= left - 1) {
        const int bit = __builtin_ctzll(left);

        for (int i = 0; i < 3; i++)
            outward[bit][i] = -along[i][bit]; /* against the rise of the label */
        if (membership)
            membership[bit] = membership_at(&f->wide, w, bit);
        if (sc_gradient_length(outward[bit]) < SC_THIN_FROM)
            thin |= 1ull << bit;
    }
    if (!thin)
        return;
    find_gradients(f, &f->narrow, w, thin);
    for (; thin; thin &= thin - 1) {
        const int bit = __builtin_ctzll(thin);
        const float share = sc_thin_share(sc_gradient_length(outward[bit]));

        for (int i = 0; i < 3; i++)
            outward[bit][i] += share * (-along[i][bit] - outward[bit][i]);
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
        for (uint32_t left = ~known & (PATTERNS - 1), found; left; left &= ~found) {
            const uint16_t id = w->ids[row][__builtin_ctz(left)];
            int i = carried;

            found = row_bits(w->ids[row], id);
            while (i < count && w->labels[i] != id)
                i++;
            if (i == count)
                w->labels[count++] = id;
        }
    }
    return count;
}

/* Set w->outward of those vertices of @p mask that carry background, which becomes the current
 * label, and mend that of tissue beside it. */
static void find_background_gradients(const filters *f, brick_work *w, uint64_t mask)
{
    const uint64_t own = vertices_of(w, mask, 0);
    uint64_t at_seam, beside = mask & sc_beside_background(f->p->volume, w->low, &at_seam);
    float outward[SC_BRICK_VERTICES][3], membership[SC_BRICK_VERTICES];

    if (!(own | beside))
        return;
    fill_bits(w, 0);
    store_gradients(f, w, own | beside, outward, membership);
    for (uint64_t left = own; left; left &= left - 1)
        memcpy(w->outward[__builtin_ctzll(left)], outward[__builtin_ctzll(left)],
               sizeof outward[0]);
    for (; beside; beside &= beside - 1) {
        const int bit = __builtin_ctzll(beside);

        sc_mend_beside_background(outward[bit], membership[bit], at_seam >> bit & 1,
                                  w->outward[bit]);
    }
}

/* Write own, other and outward of @p w at the vertices of @p mask, from w->ids. If the window holds
 * two labels, one label tells about both: their memberships add up to 1, and their gradients are
 * opposite. */
static void filter_brick(const filters *f, brick_work *w, uint64_t mask)
{
    const int count = find_labels(w, mask);
    bool background = false;

    memset(w->other, 0, sizeof w->other);
    for (int i = 0; i < count; i++) {
        const uint64_t own = vertices_of(w, mask, w->labels[i]);

        if (i > 0)
            fill_bits(w, w->labels[i]);
        update_memberships(f, w, mask, own);
        if (count == 2)
            store_gradients(f, w, mask, w->outward, NULL);
        else if (w->labels[i] == 0)
            background = true; /* other gradients must be known before */
        else if (own)
            store_gradients(f, w, own, w->outward, NULL);
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
    if (background)
        find_background_gradients(f, w, mask);
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
        const uint64_t mask = f->p->near[brick];

        if (!mask || (f->marked && !f->marked[brick]))
            continue;
        sc_brick_low(f->p->bricks, brick, w.low);
        w.by_border = sc_is_by_border(f->p->volume, w.low, RADIUS);
        fetch_window(f->p->volume, w.low, &w);
        filter_brick(f, &w, mask);
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
