/* SPDX-License-Identifier: BSD-3-Clause */
/* The fields of fields.c for stronger smoothing, and for tissues that are smoothed differently.
 *
 * The border between two labels is smoothed by one filter, seen from either side: the weaker of
 * their two strengths, and next to the background that of the tissue. So what is smoothed little is
 * not rounded off by a neighbour, and no border moves because one side's filter is wider. The
 * weight of a vertex is the least of its margins over the other labels, each by the filter of that
 * border. Weights of different filters must be comparable, because they vote against each other
 * where three labels meet, and five bits must do for wide filters, whose margins are small. So each
 * filter is scaled: beside a flat border it gives the weight that strength 1 gives. Between crisp
 * tissues all weights are that one.
 *
 * Tissue that is thinner than a strong filter would be torn. Where the gradient says that it is
 * thin, the filter of strength 1 is blended in, and where it is very thin replaces the wide one.
 *
 * Normals of strong smoothing come from a wider Gaussian, too, so that light does not show what
 * outlines do not. Where tissue is thin for it, a narrower one is blended in, by stages.
 *
 * A window can hold thousands of labels, each of which would be filtered over all of it, and
 * compared with all others. No strong smoothing can be seen among labels as small as that. So
 * bricks whose window holds more than LABELS_MAX of them are left to fields.c: all of their labels
 * are smoothed by strength 1, or by the weakest one if that is less. The labels alone decide. */
#include "wide_filters.h"

#include <string.h>
#ifdef __SSE2__
#include <emmintrin.h>
#endif

enum {
    ANY_KIND = -1,
    LABELS_MAX = 128 /* in a window that is smoothed here */
};

/* Less than any membership: those of filters with negative values may be a little below 0. */
#define NO_RIVAL (-1.0f)

/* ---- one brick ---- */

/* The work on one brick. "The current label" is the one that is being filtered. */
typedef struct brick_work {
    uint16_t ids[ROWS][WINDOW];           /* labels of the window, [z and y][x] */
    uint8_t bits[ROWS][CHUNKS];           /* which vertices of a row carry the current label */
    quad value[ROWS], along_x[ROWS];      /* [z][y]: rows filtered along x */
    quad flat[WINDOW][SC_BRICK];          /* [z][y]: filtered along x and y */
    quad along_xy[WINDOW][SC_BRICK][2];   /* the derivatives along x and y */
    float gradient[SC_BRICK_VERTICES][3]; /* of the current label */
    uint16_t labels[LABELS_MAX];          /* [count] the distinct labels of the window: */
    int count, carried;                   /* first those that wanted vertices carry */
    int low[3];                           /* the brick's lowest vertex */
    bool by_border;                       /* of the volume: filters reach beyond it */
    uint64_t own_bits[SC_BRICK_VERTICES]; /* [carried]: which wanted vertices carry a label */
    float sum[SC_BRICK_VERTICES];         /* of the memberships of a vertex's rivals */
    float other[SC_BRICK_VERTICES];       /* the largest one of its rivals; NO_RIVAL: none */
    /* results */
    float margin[SC_BRICK_VERTICES];
    uint8_t kind[SC_BRICK_VERTICES];     /* by which strength a vertex is smoothed */
    float length[SC_BRICK_VERTICES];     /* of the gradient by the widest filter of that kind */
    float membership[SC_BRICK_VERTICES]; /* of the label of that gradient, by the same filter */
    float outward[SC_BRICK_VERTICES][3]; /* gradient of a vertex's own label, negated; mended beside
                                            the background: sc_mend_beside_background */
} brick_work;

/* @return the strength by which the border between two labels is smoothed, an index into kinds:
 * the weaker one; that of the tissue next to the background. */
static int kind_between(const sc_preparation *p, uint16_t a, uint16_t b)
{
    const int of_a = p->kind_of[a], of_b = p->kind_of[b];

    /* kinds are in their order, and the background has the last one */
    return of_a < of_b ? of_a : of_b;
}

/* Write the labels of the window around the brick whose lowest vertex is @p low to w->ids, as far
 * as the filters reach; vertices outside of the volume get the label of the nearest voxel. */
static void fetch_window(const filters *f, const int low[3], brick_work *w)
{
    const sc_volume *v = f->p->volume;
    const int x0 = low[0] - 1 - RADIUS, first = RADIUS - f->reach,
              end = RADIUS + SC_BRICK + f->reach;

    for (int row = first * WINDOW; row < end * WINDOW; row++) {
        const int y = low[1] - 1 - RADIUS + row % WINDOW, z = low[2] - 1 - RADIUS + row / WINDOW;

        if (row % WINDOW < first || row % WINDOW >= end)
            continue;
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

/* @return the vertices of a row of the window that carry @p id, as bits. @param ids [WINDOW]. */
#ifdef __SSE2__
static inline uint32_t row_bits(const uint16_t *ids, uint16_t id)
{
    const __m128i wanted = _mm_set1_epi16((int16_t)id);
    uint32_t bits = 0;

    for (int half = 0; half < 2; half++) {
        const __m128i *at = (const __m128i *)(const void *)(ids + half * WINDOW / 2);
        const __m128i low = _mm_cmpeq_epi16(_mm_loadu_si128(at), wanted);
        const __m128i high = _mm_cmpeq_epi16(_mm_loadu_si128(at + 1), wanted);

        bits |= (uint32_t)_mm_movemask_epi8(_mm_packs_epi16(low, high)) << half * WINDOW / 2;
    }
    return bits;
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
static void fill_bits(const filters *f, brick_work *w, uint16_t id)
{
    const int first = RADIUS - f->reach, end = RADIUS + SC_BRICK + f->reach;

    for (int z = first; z < end; z++) {
        for (int y = first; y < end; y++) {
            const int row = z * WINDOW + y;
            const uint32_t bits = row_bits(w->ids[row], id);

            for (int chunk = 0; chunk < CHUNKS; chunk++)
                w->bits[row][chunk] = (uint8_t)(bits >> chunk * CHUNK_BITS);
        }
    }
}

/* @return the label of the vertex of a bit of the brick. */
static uint16_t id_of_bit(const brick_work *w, int bit)
{
    return w
        ->ids[(sc_bit_z(bit) + RADIUS) * WINDOW + sc_bit_y(bit) + RADIUS][sc_bit_x(bit) + RADIUS];
}

/* Add the labels of a row that are not known yet to w->labels. @return false if there are too many.
 */
static bool add_labels(brick_work *w, int row)
{
    uint32_t known = 0;

    for (int i = 0; i < w->carried; i++)
        known |= row_bits(w->ids[row], w->labels[i]);
    while (~known) {
        const uint16_t id = w->ids[row][__builtin_ctz(~known)];
        int i = w->carried;

        while (i < w->count && w->labels[i] != id)
            i++;
        if (i == LABELS_MAX)
            return false;
        if (i == w->count)
            w->labels[w->count++] = id;
        known |= row_bits(w->ids[row], id);
    }
    return true;
}

/* Find the distinct labels of the window: fills labels, count, carried and own_bits. @param mask
 * the wanted vertices, not empty. @return false if there are more than LABELS_MAX. */
static bool find_labels(const filters *f, brick_work *w, uint64_t mask)
{
    const int first = RADIUS - f->reach, end = RADIUS + SC_BRICK + f->reach;

    w->carried = 0;
    for (uint64_t left = mask; left; left &= left - 1) {
        const int bit = __builtin_ctzll(left);
        const uint16_t id = id_of_bit(w, bit);
        int i = 0;

        while (i < w->carried && w->labels[i] != id)
            i++;
        if (i == w->carried) {
            w->labels[w->carried++] = id;
            w->own_bits[i] = 0;
        }
        w->own_bits[i] |= 1ull << bit;
    }
    w->count = w->carried;
    for (int z = first; z < end; z++) {
        for (int y = first; y < end; y++) {
            if (!add_labels(w, z * WINDOW + y))
                return false;
        }
    }
    return true;
}

/* ---- weights ---- */

/* Write the memberships of the current label, smoothed by @p s, at the sixteen vertices of layer @p
 * z of the brick to @p out, [y][x]. */
static void memberships_of(const weights *s, const brick_work *w, int z, quad out[SC_BRICK])
{
    const uint8_t(*bits)[CHUNKS] = w->bits + z * WINDOW;
    quad sum[SC_BRICK] = {{0}};

    for (int chunk = s->first_chunk; chunk <= s->last_chunk; chunk++) {
        for (int i = 0; i < s->row_count; i++) {
            const quad *sums = s->tables[s->rows[i].table][chunk];
            const uint8_t(*row)[CHUNKS] = bits + s->rows[i].offset;

            for (int y = 0; y < SC_BRICK; y++)
                sum[y] += sums[row[y][chunk]];
        }
    }
    memcpy(out, sum, sizeof sum);
}

/* Smooth the current label by @p s, and note its membership as a rival at the vertices of @p
 * rivals; at those of @p own, which carry it, note what is left to the only other label. */
static void update_memberships(const weights *s, brick_work *w, uint64_t own, uint64_t rivals)
{
    for (int first = 0; first < SC_BRICK_VERTICES; first += SC_BRICK_LAYER) {
        quad memberships[SC_BRICK];

        if (!((own | rivals) >> first & SC_BRICK_LAYER_BITS))
            continue;
        memberships_of(s, w, sc_bit_z(first), memberships);
        for (int bit = first; bit < first + SC_BRICK_LAYER; bit++) {
            float membership = memberships[sc_bit_y(bit)][sc_bit_x(bit)];

            if (!((own | rivals) >> bit & 1))
                continue;
            membership = own >> bit & 1 ? 1 - membership : membership;
            w->sum[bit] += membership;
            w->other[bit] = membership > w->other[bit] ? membership : w->other[bit];
        }
    }
}

/* Do labels number @p i and @p j of the window compete by a strength: is the border between them
 * smoothed by @p kind, or is that ANY_KIND? */
static bool compete(const filters *f, const brick_work *w, int i, int j, int kind)
{
    return i != j && (kind == ANY_KIND || kind_between(f->p, w->labels[i], w->labels[j]) == kind);
}

/* Set sum and other of the vertices of @p mask, smoothed by @p s, from those labels that compete by
 * @p kind. Other stays NO_RIVAL where there are none. If the window holds two labels, one tells
 * about both, as their memberships add up to 1. */
static void find_memberships(const filters *f, brick_work *w, const weights *s, int kind,
                             uint64_t mask)
{
    const bool two = w->count == 2;

    for (int bit = 0; bit < SC_BRICK_VERTICES; bit++) {
        w->sum[bit] = 0;
        w->other[bit] = NO_RIVAL;
    }
    for (int i = 0; i < (two ? 1 : w->count); i++) {
        uint64_t rivals = 0, own = 0;

        for (int j = 0; j < w->count; j++) {
            if (!compete(f, w, i, j, kind))
                continue;
            rivals |= j < w->carried ? w->own_bits[j] & mask : 0;
            own = two ? w->own_bits[i] & mask : 0;
        }
        if (!(own | rivals))
            continue;
        fill_bits(f, w, w->labels[i]);
        update_memberships(s, w, own, rivals);
    }
}

/* @return the margin of the vertex of a bit by a filter: by how much the membership of its own
 * label is above the largest one of its rivals. Labels that are no rivals by this filter count as
 * its own: of their borders other filters tell. */
static float margin_of(const weights *s, const brick_work *w, int bit)
{
    return fminf(1 - w->sum[bit] - w->other[bit], 1) * s->gain;
}

/* Set the margin and the kind of the wanted vertices at borders between crisp tissues, which is
 * kind
 * @p k. */
static void find_crisp_margins(const filters *f, brick_work *w, int k)
{
    for (int i = 0; i < w->carried; i++) {
        bool found = false;

        for (int j = 0; j < w->count && !found; j++)
            found = compete(f, w, i, j, k);
        for (uint64_t left = found ? w->own_bits[i] : 0; left; left &= left - 1) {
            w->margin[__builtin_ctzll(left)] = f->flat;
            w->kind[__builtin_ctzll(left)] = (uint8_t)k;
        }
    }
}

/* Set the margin and the kind of the vertices of @p mask, which are the wanted ones. */
static void find_margins(const filters *f, brick_work *w, uint64_t mask)
{
    for (uint64_t left = mask; left; left &= left - 1) {
        const int bit = __builtin_ctzll(left);

        w->margin[bit] = 1; /* nothing else is near */
        w->kind[bit] = f->p->kind_of[id_of_bit(w, bit)];
    }
    for (int k = 0; k < f->p->kind_count && w->count > 1; k++) {
        const weights *s = &f->weights[k];

        if (s->crisp) {
            find_crisp_margins(f, w, k);
            continue;
        }
        find_memberships(f, w, s, k, mask);
        for (uint64_t left = mask; left; left &= left - 1) {
            const int bit = __builtin_ctzll(left);
            const float margin = margin_of(s, w, bit);

            if (w->other[bit] <= NO_RIVAL || margin >= w->margin[bit])
                continue;
            w->margin[bit] = margin;
            w->kind[bit] = (uint8_t)k;
        }
    }
}

/* Blend the margins of the vertices of @p mask with those of a narrower filter where tissue is thin
 * for their own. Needs length. */
static void mend_thin_margins(const filters *f, brick_work *w, uint64_t mask)
{
    for (int k = 0; k < f->p->kind_count && w->count > 1; k++) {
        const weights *narrow = f->weights[k].thin < 0 ? NULL : &f->weights[f->weights[k].thin];
        uint64_t thin = 0;

        for (uint64_t left = narrow ? mask : 0; left; left &= left - 1) {
            const int bit = __builtin_ctzll(left);

            if (w->kind[bit] == k && w->length[bit] < SC_THIN_FROM)
                thin |= 1ull << bit;
        }
        if (!thin)
            continue;
        find_memberships(f, w, narrow, ANY_KIND, thin);
        for (; thin; thin &= thin - 1) {
            const int bit = __builtin_ctzll(thin);
            const float margin = margin_of(narrow, w, bit);

            w->margin[bit] += sc_thin_share(w->length[bit]) * (margin - w->margin[bit]);
        }
    }
}

/* ---- normals ---- */

/* Write the gradients of the current label at all vertices of the brick to w->gradient: filtered
 * along x by the tables, then along y and z tap by tap. */
static void find_gradients(const normals *n, brick_work *w)
{
    const int taps = 2 * n->radius + 1, skip = RADIUS - n->radius;
    const int end = RADIUS + SC_BRICK + n->radius;

    for (int z = skip; z < end; z++) {
        for (int row = z * WINDOW + skip; row < z * WINDOW + end; row++) {
            quad value = {0}, slope = {0};

            for (int chunk = 0; chunk < CHUNKS; chunk++) {
                value += n->table[chunk][w->bits[row][chunk]][0];
                slope += n->table[chunk][w->bits[row][chunk]][1];
            }
            w->value[row] = value;
            w->along_x[row] = slope;
        }
        for (int y = 0; y < SC_BRICK; y++) {
            const int row = z * WINDOW + y + skip;
            quad flat = {0}, along_x = {0}, along_y = {0};

            for (int i = 0; i < taps; i++) {
                flat += w->value[row + i] * n->value[1][i];
                along_y += w->value[row + i] * n->slope[1][i];
                along_x += w->along_x[row + i] * n->value[1][i];
            }
            w->flat[z][y] = flat;
            w->along_xy[z][y][0] = along_x;
            w->along_xy[z][y][1] = along_y;
        }
    }
    for (int bit = 0; bit < SC_BRICK_VERTICES; bit += SC_BRICK) {
        const int y = sc_bit_y(bit), z = sc_bit_z(bit) + skip;
        quad along[3] = {{0}, {0}, {0}};

        for (int i = 0; i < taps; i++) {
            along[0] += w->along_xy[z + i][y][0] * n->value[2][i];
            along[1] += w->along_xy[z + i][y][1] * n->value[2][i];
            along[2] += w->flat[z + i][y] * n->slope[2][i];
        }
        for (int x = 0; x < SC_BRICK; x++) {
            for (int axis = 0; axis < 3; axis++)
                w->gradient[bit + x][axis] = along[axis][x];
        }
    }
}

/* @return the membership of the current label at the vertex of a bit, smoothed by the filter @p n,
 * by which find_gradients has just found the gradients. */
static float membership_at(const normals *n, const brick_work *w, int bit)
{
    const int z = sc_bit_z(bit) + RADIUS - n->radius;
    float sum = 0;

    for (int i = 0; i <= 2 * n->radius; i++)
        sum += w->flat[z + i][sc_bit_y(bit)][sc_bit_x(bit)] * n->value[2][i];
    return sum;
}

/* Let the gradient of the vertex of a bit, found by a filter, go on beyond the border of the volume
 * as it does inside, in place. */
static void mend_at_border(const filters *f, const normals *n, const brick_work *w, int bit,
                           float gradient[3])
{
    const float *const slope[3] = {n->slope[0], n->slope[1], n->slope[2]};
    const int voxel[3] = {w->low[0] - 1 + sc_bit_x(bit), w->low[1] - 1 + sc_bit_y(bit),
                          w->low[2] - 1 + sc_bit_z(bit)};

    sc_gradient_at_border(f->p->volume, voxel, n->radius, slope, gradient);
}

/* Write the gradient @p from of a filter, whose length is @p length, to @p to as a normal of the
 * same length, and not as one that leans where the axes are smoothed by different strengths. */
static inline void set_upright(const normals *n, const float from[3], float length, float to[3])
{
    float scale;

    for (int i = 0; i < 3; i++)
        to[i] = from[i] * n->upright[i];
    scale = sc_gradient_length(to);
    scale = scale > 0 ? length / scale : 0;
    for (int i = 0; i < 3; i++)
        to[i] *= scale;
}

/* Set outward, length and membership of the vertices of @p mask against the rise of the current
 * label: by the widest filter of kind @p k, and where tissue is thin for it by the next narrower
 * one, and so on. Overwrites w->gradient. */
static void store_gradients(const filters *f, brick_work *w, int k, uint64_t mask)
{
    const int widest = f->normals[STANDARD + 1 + k].table ? STANDARD + 1 + k : STANDARD;
    float left_over[SC_BRICK_VERTICES]; /* share of the filters that follow */
    int level = widest;

    for (uint64_t left = mask; left; left &= left - 1)
        left_over[__builtin_ctzll(left)] = 1;
    while (mask) {
        uint64_t thin = 0;

        find_gradients(&f->normals[level], w);
        for (uint64_t left = mask; left; left &= left - 1) {
            const int bit = __builtin_ctzll(left);
            float normal[3], length, next;

            if (w->by_border)
                mend_at_border(f, &f->normals[level], w, bit, w->gradient[bit]);
            length = sc_gradient_length(w->gradient[bit]);
            next = level == NARROW ? 0 : sc_thin_share(length);
            set_upright(&f->normals[level], w->gradient[bit], length, normal);
            for (int i = 0; i < 3; i++) /* against the rise of the label */
                w->outward[bit][i] = (level == widest ? 0 : w->outward[bit][i]) -
                                     left_over[bit] * (1 - next) * normal[i];
            if (level == widest) {
                w->length[bit] = length;
                w->membership[bit] = membership_at(&f->normals[level], w, bit);
            }
            left_over[bit] *= next;
            thin |= next > 0 ? 1ull << bit : 0;
        }
        mask = thin;
        level = level > STANDARD ? STANDARD : NARROW;
    }
}

/* @return those vertices of @p mask that are smoothed by strength @p k. */
static uint64_t vertices_of_kind(const brick_work *w, int k, uint64_t mask)
{
    uint64_t of_kind = 0;

    for (; mask; mask &= mask - 1)
        of_kind |= (uint64_t)(w->kind[__builtin_ctzll(mask)] == k) << __builtin_ctzll(mask);
    return of_kind;
}

/* Set outward and length of the vertices of @p mask. Of two labels, one tells about both, as their
 * gradients are opposite. Needs kind. */
static void find_outward(const filters *f, brick_work *w, uint64_t mask)
{
    for (int k = 0; k < f->p->kind_count; k++) {
        const uint64_t of_kind = vertices_of_kind(w, k, mask);

        for (int i = 0; i < (w->count == 2 ? 1 : w->carried); i++) {
            const uint64_t own = of_kind & w->own_bits[i];

            if (!(w->count == 2 ? of_kind : own))
                continue;
            fill_bits(f, w, w->labels[i]);
            store_gradients(f, w, k, w->count == 2 ? of_kind : own);
            for (uint64_t left = w->count == 2 ? of_kind & ~own : 0; left; left &= left - 1) {
                for (int axis = 0; axis < 3; axis++)
                    w->outward[__builtin_ctzll(left)][axis] *= -1;
            }
        }
    }
}

/* Mend outward of those vertices of @p mask that carry tissue beside the background, which becomes
 * the current label. Needs kind, outward and length. */
static void mend_beside_background(const filters *f, brick_work *w, uint64_t mask)
{
    uint64_t at_seam;
    const uint64_t beside = mask & sc_beside_background(f->p->volume, w->low, &at_seam);
    float own[SC_BRICK_VERTICES][3], length[SC_BRICK_VERTICES];

    if (!beside)
        return;
    memcpy(own, w->outward, sizeof own);
    memcpy(length, w->length, sizeof length);
    fill_bits(f, w, 0);
    for (int k = 0; k < f->p->kind_count; k++) {
        const uint64_t of_kind = vertices_of_kind(w, k, beside);

        if (of_kind)
            store_gradients(f, w, k, of_kind);
    }
    for (uint64_t left = beside; left; left &= left - 1) {
        const int bit = __builtin_ctzll(left);

        sc_mend_beside_background(w->outward[bit], w->membership[bit], at_seam >> bit & 1,
                                  own[bit]);
    }
    memcpy(w->outward, own, sizeof own);
    memcpy(w->length, length, sizeof length);
}

/* Fill the records of bricks [begin, end), but mark crowded ones instead; an sc_range_fn on
 * filters.
 */
static void fields_of_bricks(void *user, size_t begin, size_t end, int thread)
{
    const filters *f = user;
    brick_work w;

    (void)thread;
    for (size_t brick = begin; brick < end; brick++) {
        const uint64_t mask = f->p->near[brick];
        size_t index = f->p->near_start[brick];

        if (!mask)
            continue;
        sc_brick_low(f->p->bricks, brick, w.low);
        w.by_border = sc_is_by_border(f->p->volume, w.low, f->reach);
        fetch_window(f, w.low, &w);
        if (!find_labels(f, &w, mask)) {
            f->crowded[brick] = 1;
            continue;
        }
        find_margins(f, &w, mask);
        find_outward(f, &w, mask);
        if (w.count > 2)
            mend_beside_background(f, &w, mask);
        mend_thin_margins(f, &w, mask);
        for (uint64_t left = mask; left; left &= left - 1) {
            const int bit = __builtin_ctzll(left);
            const float scaled = w.margin[bit] * SC_WEIGHT_MAX + 0.5f;
            const int weight = !(scaled > SC_WEIGHT_LEAST) ? SC_WEIGHT_LEAST
                               : scaled < SC_WEIGHT_MAX    ? (int)scaled
                                                           : SC_WEIGHT_MAX;

            sc_record_write(f->p->records, index++,
                            sc_field_record(f->to_mm, weight, w.outward[bit]));
        }
    }
}

/* Fill the records of the crowded bricks, if there are any. No label is smoothed more than its own
 * strength says, and weights are scaled as those of the other bricks. Returns SC_ERR_MEMORY. */
static sc_status fill_crowded(const sc_ctx *ctx, const filters *f)
{
    const sc_preparation *p = f->p;
    sc_vec3 strength = {1, 1, 1};
    sc_weight_filter w;
    double steps[3], total;
    size_t crowded = 0, bricks = 0;

    for (size_t brick = 0; brick < p->brick_count; brick++) {
        crowded += f->crowded[brick];
        bricks += p->near[brick] != 0;
    }
    if (!crowded)
        return SC_OK;
    sc_warn(
        sc_team_is_first(p->team) ? ctx : NULL,
        "more than %d labels meet in %zu of %zu blocks of 4 x 4 x 4 voxels at borders, too many "
        "for strong smoothing; they are smoothed by a strength of at most 1",
        LABELS_MAX, crowded, bricks);
    for (int k = 0; k < p->kind_count; k++)
        strength = (sc_vec3){fmin(strength.x, p->kinds[k].x), fmin(strength.y, p->kinds[k].y),
                             fmin(strength.z, p->kinds[k].z)};
    sc_filter_steps(p->volume, steps);
    w = sc_weight_filter_of(steps, strength);
    return sc_find_fields_of_bricks(
        ctx, p, strength, (float)(f->flat / fmin(sc_flat_margin(&w, &total), 1)), f->crowded);
}

sc_status sc_find_wide_fields(const sc_ctx *ctx, sc_preparation *p)
{
    uint8_t *crowded = NULL;
    filters *f = NULL;
    void *block;
    sc_status status;

    SC_TRY(sc_team_alloc(ctx, p->team, p->near_count, SC_RECORD_BYTES, &block));
    p->records = block;
    SC_TRY(sc_team_alloc(ctx, p->team, p->brick_count, sizeof *crowded, &block));
    crowded = block;
    status = sc_zalloc(ctx, 1, sizeof *f, &block);
    if (status == SC_OK) {
        f = block;
        f->p = p;
        f->crowded = crowded;
        status = sc_wide_filters_fill(ctx, f);
    }
    SC_TRY(sc_team_agree(p->team, status));
    sc_team_stage_for(ctx, SC_WORTH_FIELDS, p->team, p->brick_count, 64, fields_of_bricks, f);
    SC_TRY(fill_crowded(ctx, f));
out:
    sc_team_free(p->team, crowded);
    if (f)
        sc_wide_filters_clear(f);
    sc_free(f);
    return status;
}
