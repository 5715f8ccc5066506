/* SPDX-License-Identifier: BSD-3-Clause */
/* The weights of thick tissue are smoothed once more, so that outlines do not show the voxels.
 *
 * A filter that is narrow enough for a thin vessel leaves the longer waves of the staircase of
 * voxels in the border of a large organ. Where voxels cover several pixels, its outline wobbles,
 * while its light, whose normals come from a wider filter, is smooth. So here the weights are taken
 * as a field, positive where a label is and negative elsewhere, and low-pass filtered TIMES times
 * by B + (1 + e) (B - B^2), where B is the binomial filter (1 2 1) / 4 along each axis (Taubin
 * 1995, "A signal processing approach to fair surface design", does the same with vertices of
 * meshes). B - B^2 undoes to second order that B alone moves curved surfaces inward; e, that it
 * still does so because weights do not go on rising away from the border.
 *
 * After each time a vertex keeps its sign, so that every voxel still owns its centre: the border
 * stays within the voxels that say where it is, and what one voxel tells is not lost.
 *
 * Where tissue is thin nothing changes. There the length of the gradient is less than that at a
 * flat border (its code in the record is not 0) at a vertex, or at more than THIN_MAX of its
 * neighbours. Nor does anything change within two voxels of a third label, where a groove would
 * deepen between the two others, or beside tissue that is smoothed by a strength below 1.
 *
 * The weights that come out rise more slowly away from the border. They are multiplied so that
 * beside a flat border a vertex has the weight that it had: vertices that change and others meet in
 * one cell, where their weights are compared.
 *
 * A row of the window around a brick is eight vertices long: one vector of 16-bit numbers. Rounding
 * them is the same on any processor. Most windows hold two labels: which of them stands where is
 * kept as bits, so that labels are read once and not each time. */
#include "wide_filters.h"

enum {
    TIMES = 6,
    AROUND = SC_AROUND,
    HALO = 2, /* vertices around a brick that two binomial filters reach */
    SIDE = SC_BRICK + 2 * HALO,
    LINES = SIDE * SIDE, /* of a window: row (y, z) is z * SIDE + y */
    POINTS = SIDE * LINES,
    BRICK_LINES = SC_BRICK * SC_BRICK,
    ONE = 4096,   /* a weight of SC_WEIGHT_MAX */
    THIN_MAX = 2, /* neighbours that are thin, at which a vertex still counts as thick */
    BLOCKED = 27, /* of a thin mark: no neighbour may change */
    EXCESS = 7,   /* e in 2^-EXCESS_SHIFT */
    EXCESS_SHIFT = 4
};
/* Along an axis whose voxels are longer than this, in reference voxels, B is (1 6 1) / 8. */
#define LONG_STEP 1.2

/* Eight numbers of a window that are side by side along x. */
typedef int16_t row __attribute__((vector_size(2 * SIDE)));
/* One number for each of the 64 vertices of a brick, in the order of the bits of its mask. */
typedef int16_t page[SC_BRICK_VERTICES];
/* One bit for each vertex of a window: bit x of byte z * SIDE + y. */
typedef uint8_t sides[LINES];

/* What the threads share. The arrays are of the team, and have one entry for each slot. */
typedef struct relax {
    const sc_preparation *p; /* borrowed; its records are changed in the end */
    uint32_t *slot;  /* of sc_number_bricks: slot 0 is that of all bricks far from borders */
    page *values;    /* weights in ONE-ths of the largest; ONE away from interfaces */
    page *next;      /* of the time that is being computed; first the marks of thin vertices */
    uint64_t *thick; /* the vertices that change */
    uint8_t *simple; /* 1 if the window of a brick lies within the volume and holds at most two
                        labels: one tells about both */
    sides *differ;   /* of simple windows: where another label stands than at its first vertex */
    int shift[3];    /* B along an axis adds the second difference, shifted right by this */
    float gain;      /* what weights are multiplied by in the end */
} relax;

/* A brick and what is around it, in rows along x. */
typedef struct window {
    uint16_t ids[LINES][SIDE];
    row values[LINES];
    row differ[LINES]; /* -1 where the label is not the one that own is about, else 0 */
    row own[LINES];    /* the values, negative where the label is another */
    row once[LINES];   /* B of own, */
    row twice[LINES];  /* and B of that, but the vertices at the edges that these need */
} window;

/* @return the row of a window in which row 0 to BRICK_LINES - 1 of its brick lies, in the order of
 * the bits: HALO vertices, those of the brick, and HALO more. */
static inline int row_of(int brick_row)
{
    return (brick_row / SC_BRICK + HALO) * SIDE + brick_row % SC_BRICK + HALO;
}

/* @return a row whose lanes are those of @p bits: -1 where the bit is set, else 0. */
static inline row spread_bits(uint32_t bits)
{
    const row lanes = {1, 2, 4, 8, 16, 32, 64, 128};

    return ((lanes & (int16_t)bits) == lanes);
}

/* @return the lanes of a row, each 0 or -1, that are not 0, as bits. */
static inline uint32_t bits_of(row lanes)
{
#ifdef __SSE2__
    return (uint32_t)_mm_movemask_epi8(_mm_packs_epi16((__m128i)lanes, _mm_setzero_si128()));
#else
    uint32_t bits = 0;

    for (int x = 0; x < SIDE; x++)
        bits |= (uint32_t)(lanes[x] != 0) << x;
    return bits;
#endif
}

/* @return the labels @p ids of a row, where they are other than @p id. */
static inline row other_ids(const uint16_t ids[SIDE], uint16_t id)
{
    row out;

    memcpy(&out, ids, sizeof out);
    return out != (row){0} + (int16_t)id;
}

/* @return a row moved by one vertex along x: each lane has the number of the one before it. The
 * first has none. */
static inline row from_before(row a)
{
#ifdef __SSE2__
    return (row)_mm_slli_si128((__m128i)a, sizeof a[0]);
#else
    return (row){0, a[0], a[1], a[2], a[3], a[4], a[5], a[6]};
#endif
}

/* As from_before: each lane has the number of the one behind it, and the last has none. */
static inline row from_behind(row a)
{
#ifdef __SSE2__
    return (row)_mm_srli_si128((__m128i)a, sizeof a[0]);
#else
    return (row){a[1], a[2], a[3], a[4], a[5], a[6], a[7], 0};
#endif
}

/* Does the window around the brick whose lowest vertex is @p low lie within the volume? */
static bool is_inside(const sc_volume *v, const int low[3])
{
    for (int i = 0; i < 3; i++) {
        if (low[i] - HALO < 1 || low[i] + SC_BRICK + HALO > v->size[i] + 1)
            return false;
    }
    return true;
}

/* Fill ids and values of the window around the brick whose lowest vertex is @p low, from @p pages.
 * Outside of the volume they are those of the nearest voxel. */
static void fetch_near_border(const relax *r, const page *pages, const int low[3], window *w)
{
    const sc_volume *v = r->p->volume;

    for (int i = 0; i < POINTS; i++) {
        const int x = sc_nearest_voxel(low[0] - HALO + i % SIDE - 1, v->size[0]);
        const int y = sc_nearest_voxel(low[1] - HALO + i / SIDE % SIDE - 1, v->size[1]);
        const int z = sc_nearest_voxel(low[2] - HALO + i / LINES - 1, v->size[2]);
        const size_t brick = sc_brick_index(r->p->bricks, sc_brick_of(x + 1), sc_brick_of(y + 1),
                                            sc_brick_of(z + 1));

        w->ids[i / SIDE][i % SIDE] = (uint16_t)sc_id_or_nearest(v, x, y, z);
        w->values[i / SIDE][i % SIDE] = pages[r->slot[brick]][sc_brick_bit(x + 1, y + 1, z + 1)];
    }
}

/* @return a row of eight numbers: the last HALO of four, four, and the first HALO of four more. */
#ifdef __SSE2__
static inline row join(const int16_t *before, const int16_t *here, const int16_t *behind)
{
    /* put together in registers: memory that was just written in parts is slow to read as a whole
     */
    const __m128i first = _mm_loadl_epi64((const __m128i *)(const void *)before),
                  second = _mm_loadl_epi64((const __m128i *)(const void *)here),
                  third = _mm_loadl_epi64((const __m128i *)(const void *)behind);

    return (row)_mm_or_si128(_mm_srli_epi64(first, 32),
                             _mm_slli_si128(_mm_unpacklo_epi64(second, third), 4));
}
_Static_assert(SC_BRICK == 4 && HALO == 2, "join moves by HALO numbers");
#else
static inline row join(const int16_t *before, const int16_t *here, const int16_t *behind)
{
    return (row){before[2], before[3], here[0], here[1], here[2], here[3], behind[0], behind[1]};
}
#endif

/* Fill the values of the window around a brick, which lies within the volume, from @p pages. */
static void fetch_values(const relax *r, const page *pages, size_t brick, window *w)
{
    const ptrdiff_t brick_row = r->p->bricks[0], brick_layer = brick_row * r->p->bricks[1];
    /* which rows the window has of the brick before its own, of its own, and of the one behind */
    static const int first[3] = {SC_BRICK - HALO, 0, 0}, end[3] = {SC_BRICK, SC_BRICK, HALO};
    const int16_t *around[AROUND];
    row *to = w->values;

    for (int i = 0; i < AROUND; i++)
        around[i] = pages[r->slot[(size_t)((ptrdiff_t)brick + (i / 9 - 1) * brick_layer +
                                           (i / 3 % 3 - 1) * brick_row + i % 3 - 1)]];
    for (int layer = 0; layer < SIDE; layer++) {
        const int z = layer - HALO; /* from the brick */
        const int16_t *const *slice = around + (sc_brick_of(z) + 1) * 9;

        for (int part = 0; part < 3; part++) { /* the bricks along y */
            const int16_t *const *from = slice + part * 3;

            for (int y = first[part]; y < end[part]; y++) {
                const int bit = sc_brick_bit(0, y, z);

                *to++ = join(from[0] + bit, from[1] + bit, from[2] + bit);
            }
        }
    }
}

/* Fill the labels of the window around the brick whose lowest vertex is @p low, which lies within
 * the volume. */
static void fetch_ids(const sc_volume *v, const int low[3], window *w)
{
    const size_t line = (size_t)v->size[0], layer = line * (size_t)v->size[1];
    const size_t voxel = (size_t)(low[2] - HALO - 1) * layer + (size_t)(low[1] - HALO - 1) * line +
                         (size_t)(low[0] - HALO - 1);

    for (int i = 0; i < LINES; i++)
        sc_copy_ids(v, voxel + (size_t)(i / SIDE) * layer + (size_t)(i % SIDE) * line, SIDE,
                    w->ids[i]);
}

/* Fill ids and values, from @p pages, of the window around the brick of index @p brick. @return
 * whether it lies within the volume. */
static bool fetch(const relax *r, const page *pages, size_t brick, window *w)
{
    int low[3];

    sc_brick_low(r->p->bricks, brick, low);
    if (!is_inside(r->p->volume, low)) {
        fetch_near_border(r, pages, low, w);
        return false;
    }
    fetch_ids(r->p->volume, low, w);
    fetch_values(r, pages, brick, w);
    return true;
}

/* @return the number that follows from those of B and of B of B, each time. Their difference is at
 * most two thirds of a weight, so that nothing overflows. Rounded towards zero. */
static inline row relaxed_row(row once, row twice)
{
    const row excess = (once - twice) * EXCESS;

    return once + (once - twice) +
           ((excess + ((excess >> 15) & ((1 << EXCESS_SHIFT) - 1))) >> EXCESS_SHIFT);
}

/* As relaxed_row, for one vertex. */
static inline int relaxed(int once, int twice)
{
    return relaxed_row((row){(int16_t)once}, (row){(int16_t)twice})[0];
}

/* @return B of the row @p b, of which @p a and @p c are the neighbours along one axis. Rounded
 * alike for either sign, so that it does not matter which of two labels is the positive one. */
static inline row binomial_of(row a, row b, row c, int shift)
{
    const int16_t half = (int16_t)(1 << (shift - 1));
    const row second = a + c - b - b;

    return b + ((second + half + (second >> 15)) >> (int16_t)shift);
}

/* Write B of a window to @p to, but for the outermost @p edge vertices, 1 at least, and for those
 * around for which @p from has no numbers. */
static void filter(const int shift[3], const row from[LINES], int edge, row to[LINES])
{
    for (int z = edge; z < SIDE - edge; z++) {
        const row *low = from + (z - 1) * SIDE, *middle = low + SIDE, *high = middle + SIDE;
        row below = binomial_of(low[edge - 1], middle[edge - 1], high[edge - 1], shift[2]);
        row here = binomial_of(low[edge], middle[edge], high[edge], shift[2]);

        for (int y = edge; y < SIDE - edge; y++) {
            const row above = binomial_of(low[y + 1], middle[y + 1], high[y + 1], shift[2]);
            const row b = binomial_of(below, here, above, shift[1]);

            to[z * SIDE + y] = binomial_of(from_before(b), b, from_behind(b), shift[0]);
            below = here;
            here = above;
        }
    }
}

/* Set w->own, once and twice from values and differ. */
static void filter_label(const relax *r, window *w)
{
    for (int i = 0; i < LINES; i++)
        w->own[i] = (w->values[i] ^ w->differ[i]) - w->differ[i]; /* negated if it differs */
    filter(r->shift, w->own, 1, w->once);
    filter(r->shift, w->once, 2, w->twice);
}

/* Write to @p out which vertices of a window have another label than the first. @return whether
 * these all have the same one. */
static bool has_two_labels(const window *w, sides out)
{
    const uint16_t first = w->ids[0][0];
    uint16_t second = first;
    row third = {0};

    for (int i = 0; i < LINES; i++) {
        out[i] = (uint8_t)bits_of(other_ids(w->ids[i], first));
        if (second == first && out[i])
            second = w->ids[i][__builtin_ctz(out[i])];
    }
    for (int i = 0; i < LINES; i++)
        third |= other_ids(w->ids[i], first) & other_ids(w->ids[i], second);
    return !bits_of(third);
}

/* Does a third label lie within HALO of the vertex of a bit? */
static bool is_by_junction(const window *w, int bit)
{
    const int line = row_of(bit / SC_BRICK), middle = sc_bit_x(bit) + HALO;
    const uint16_t own = w->ids[line][middle];
    uint16_t other = own;

    for (int z = -HALO; z <= HALO; z++) {
        for (int y = -HALO; y <= HALO; y++) {
            for (int x = -HALO; x <= HALO; x++) {
                const uint16_t id = w->ids[line + z * SIDE + y][middle + x];

                if (id != own && id != other && other != own)
                    return true;
                other = id != own ? id : other;
            }
        }
    }
    return false;
}

/* @return the vertices of @p mask, bits of the window's brick, that do not differ. */
static uint64_t alike(const window *w, uint64_t mask)
{
    uint64_t differ = 0;

    for (int i = 0; i < BRICK_LINES; i++)
        differ |= (uint64_t)(bits_of(w->differ[row_of(i)]) >> HALO & 15) << (i * SC_BRICK);
    return mask & ~differ;
}

/* Write to @p to, the page of a window's brick, what once and twice give for the vertices @p mask.
 */
static void write_page(const window *w, uint64_t mask, page to)
{
    const row one = (row){0} + ONE, least = (row){0} + 1;

    for (int i = 0; i < BRICK_LINES; i++, mask >>= SC_BRICK) {
        const int at = row_of(i);
        const row chosen = spread_bits((uint32_t)(mask & 15) << HALO);
        int16_t *numbers = to + (size_t)i * SC_BRICK;
        row value, old = {0};

        if (!(mask & 15))
            continue;
        value = relaxed_row(w->once[at], w->twice[at]);
        value = (value ^ w->differ[at]) - w->differ[at];
        value = (value & (value > least)) | (least & (value <= least));
        value = (value & (value < one)) | (one & (value >= one));
        memcpy((int16_t *)&old + HALO, numbers, SC_BRICK * sizeof *numbers);
        value = (value & chosen) | (old & ~chosen);
        memcpy(numbers, (int16_t *)&value + HALO, SC_BRICK * sizeof *numbers);
    }
}

/* Smooth the weights of the thick vertices of a brick once, from values to next. If the window is
 * simple, all of them, else the labels one after the other. */
static void relax_brick(const relax *r, size_t brick, window *w)
{
    const uint32_t slot = r->slot[brick];
    uint64_t left = r->thick[slot];

    memcpy(r->next[slot], r->values[slot], sizeof(page));
    if (!left)
        return;
    if (r->simple[slot]) {
        fetch_values(r, r->values, brick, w);
        for (int i = 0; i < LINES; i++)
            w->differ[i] = spread_bits(r->differ[slot][i]);
        filter_label(r, w);
        write_page(w, left, r->next[slot]);
        return;
    }
    fetch(r, r->values, brick, w);
    while (left) {
        const int bit = __builtin_ctzll(left);
        const uint16_t id = w->ids[row_of(bit / SC_BRICK)][sc_bit_x(bit) + HALO];
        uint64_t own;

        for (int i = 0; i < LINES; i++)
            w->differ[i] = other_ids(w->ids[i], id);
        own = alike(w, left);
        filter_label(r, w);
        write_page(w, own, r->next[slot]);
        left &= ~own;
    }
}

/* Smooth the bricks [begin, end) once; an sc_range_fn on a relax. */
static void relax_bricks(void *user, size_t begin, size_t end, int thread)
{
    const relax *r = user;
    window w = {.values = {{0}}};

    (void)thread;
    for (size_t brick = begin; brick < end; brick++) {
        if (r->slot[brick])
            relax_brick(r, brick, &w);
    }
}

/* Does the vertex (x, y, z) of the grid lie in the volume? */
static bool in_volume(const sc_volume *v, int x, int y, int z)
{
    return x > 0 && y > 0 && z > 0 && x <= v->size[0] && y <= v->size[1] && z <= v->size[2];
}

/* @return how much the vertex of a record, in the volume, counts as thin: 0, 1, or BLOCKED. */
static int16_t thin_mark(const sc_preparation *p, uint32_t record, uint32_t id)
{
    if (id && sc_least_strength(p->kinds[p->kind_of[id]]) < 1)
        return BLOCKED;
    return sc_record_length_code(record) != 0;
}

/* Fill the pages of bricks [begin, end): values with the weights, next with the marks of thin
 * vertices, thick with the vertices that are near an interface and have no mark. An sc_range_fn on
 * a relax. */
static void begin_bricks(void *user, size_t begin, size_t end, int thread)
{
    const relax *r = user;
    const sc_preparation *p = r->p;

    (void)thread;
    for (size_t brick = begin; brick < end; brick++) {
        const uint32_t slot = r->slot[brick];
        size_t index = p->near_start[brick];
        int low[3];

        if (!slot)
            continue;
        sc_brick_low(p->bricks, brick, low);
        for (int bit = 0; bit < SC_BRICK_VERTICES; bit++)
            r->values[slot][bit] = ONE;
        for (uint64_t left = p->near[brick]; left; left &= left - 1, index++) {
            const int bit = __builtin_ctzll(left);
            const int x = low[0] + sc_bit_x(bit), y = low[1] + sc_bit_y(bit),
                      z = low[2] + sc_bit_z(bit);
            const uint32_t record = sc_record_read(p->records, index);

            if (!in_volume(p->volume, x, y, z))
                continue;
            r->values[slot][bit] = (int16_t)(sc_record_weight(record) * ONE / SC_WEIGHT_MAX);
            r->next[slot][bit] =
                thin_mark(p, record, sc_id_or_background(p->volume, x - 1, y - 1, z - 1));
            r->thick[slot] |= (uint64_t)!r->next[slot][bit] << bit;
        }
    }
}

/* @return the vertices of the window's brick around which, and at which, the values add up to more
 * than THIN_MAX. */
static uint64_t among_thin(const window *w)
{
    row sums[LINES]; /* of three layers */
    uint64_t out = 0;

    for (int i = SIDE; i < LINES - SIDE; i++)
        sums[i] = w->values[i - SIDE] + w->values[i] + w->values[i + SIDE];
    for (int i = 0; i < BRICK_LINES; i++) {
        const row *at = sums + row_of(i);
        const row along = at[-1] + at[0] + at[1];
        const row sum = from_before(along) + along + from_behind(along);

        out |= (uint64_t)(bits_of(sum > THIN_MAX) >> HALO & 15) << (i * SC_BRICK);
    }
    return out;
}

/* Leave out of thick, in bricks [begin, end), the vertices with too many thin neighbours and those
 * near a third label; fill simple and differ. An sc_range_fn on a relax. */
static void leave_out_thin(void *user, size_t begin, size_t end, int thread)
{
    const relax *r = user;
    window w = {.values = {{0}}};

    (void)thread;
    for (size_t brick = begin; brick < end; brick++) {
        const uint32_t slot = r->slot[brick];
        bool inside, two;

        if (!r->thick[slot])
            continue;
        inside = fetch(r, r->next, brick, &w);
        two = has_two_labels(&w, r->differ[slot]);
        r->simple[slot] = inside && two;
        r->thick[slot] &= ~among_thin(&w);
        for (uint64_t left = two ? 0 : r->thick[slot]; left; left &= left - 1) {
            const int bit = __builtin_ctzll(left);

            if (is_by_junction(&w, bit))
                r->thick[slot] &= ~(1ull << bit);
        }
    }
}

/* Write the new weights of bricks [begin, end) to the records; an sc_range_fn on a relax. */
static void end_bricks(void *user, size_t begin, size_t end, int thread)
{
    const relax *r = user;
    const sc_preparation *p = r->p;

    (void)thread;
    for (size_t brick = begin; brick < end; brick++) {
        const uint32_t slot = r->slot[brick];

        for (uint64_t left = r->thick[slot]; left; left &= left - 1) {
            const int bit = __builtin_ctzll(left);
            const size_t index = p->near_start[brick] + sc_brick_rank(p->near[brick], bit);
            const uint32_t old = sc_record_read(p->records, index);
            const float scaled = r->gain * r->values[slot][bit] * SC_WEIGHT_MAX / ONE + 0.5f;
            const int weight = scaled < 1               ? 1
                               : scaled < SC_WEIGHT_MAX ? (int)scaled
                                                        : SC_WEIGHT_MAX;

            sc_record_write(p->records, index,
                            (old & ~(uint32_t)SC_RECORD_WEIGHT_MASK) | (uint32_t)weight);
        }
    }
}

/* Allocate the arrays, which are zero, and fill page 0 of the values. Returns SC_ERR_MEMORY; what
 * has been allocated until then is in @p r, for the caller to free. */
static sc_status allocate(const sc_ctx *ctx, relax *r)
{
    uint64_t used = 0;
    void *block;
    sc_status status;

    SC_TRY(sc_number_bricks(ctx, r->p, &r->slot, &used));
    SC_TRY(sc_team_alloc(ctx, r->p->team, (size_t)used + 1, sizeof *r->values, &block));
    r->values = block;
    SC_TRY(sc_team_alloc(ctx, r->p->team, (size_t)used + 1, sizeof *r->next, &block));
    r->next = block;
    SC_TRY(sc_team_alloc(ctx, r->p->team, (size_t)used + 1, sizeof *r->thick, &block));
    r->thick = block;
    SC_TRY(sc_team_alloc(ctx, r->p->team, (size_t)used + 1, sizeof *r->simple, &block));
    r->simple = block;
    SC_TRY(sc_team_alloc(ctx, r->p->team, (size_t)used + 1, sizeof *r->differ, &block));
    r->differ = block;
out:
    return status;
}

/* Fill page 0 of the values, once; an sc_range_fn on a relax. */
static void begin_empty(void *user, size_t begin, size_t end, int thread)
{
    const relax *r = user;

    (void)begin;
    (void)end;
    (void)thread;
    for (int bit = 0; bit < SC_BRICK_VERTICES; bit++)
        r->values[0][bit] = ONE;
}

/* @return by what all this lessens the weight of the first vertex beside a flat border, of @p
 * before ONE-ths of the largest, across an axis. The next vertices are not near an interface.
 * @param shift of that axis. */
static float flat_gain(int before, int shift)
{
    const int half = 1 << (shift - 1);
    int value = before;

    for (int i = 0; i < TIMES; i++) {
        /* on both sides of the border stand -ONE -ONE -value value ONE ONE */
        const int once = value + ((ONE - 3 * value + half) >> shift);
        const int next = ONE + ((value - ONE + half) >> shift);
        const int twice = once + ((next - 3 * once + half) >> shift);

        value = relaxed(once, twice);
    }
    return (float)before / (float)value;
}

/* Fill shift and gain. Of the axes, that which needs least decides: more would cut off weights. */
static void fill_filter(relax *r)
{
    double steps[3], margins[3], total;
    sc_weight_filter filter;

    sc_filter_steps(r->p->volume, steps);
    filter = sc_weight_filter_of(steps, (sc_vec3){1, 1, 1});
    sc_flat_margins(&filter, margins, &total);
    for (int i = 0; i < 3; i++) {
        float gain;

        r->shift[i] = steps[i] > LONG_STEP ? 3 : 2;
        gain = flat_gain((int)(fmin(margins[i], 1) * ONE), r->shift[i]);
        r->gain = i == 0 || gain < r->gain ? gain : r->gain;
    }
}

/* Is any tissue smoothed by a strength of 1 or more? */
static bool is_wanted(const sc_preparation *p)
{
    for (int k = 0; k < p->kind_count; k++) {
        if (sc_least_strength(p->kinds[k]) >= 1)
            return true;
    }
    return false;
}

sc_status sc_relax_weights(const sc_ctx *ctx, sc_preparation *p)
{
    relax r = {.p = p};
    const uint64_t each = SC_WORTH_RELAX / (TIMES + 3); /* there are so many loops */
    sc_status status;

    if (!is_wanted(p))
        return SC_OK;
    SC_TRY(allocate(ctx, &r));
    fill_filter(&r);
    sc_team_for(p->team, 1, 1, begin_empty, &r);
    sc_team_stage_for(ctx, each, p->team, p->brick_count, 4096, begin_bricks, &r);
    sc_team_stage_for(ctx, each, p->team, p->brick_count, 4096, leave_out_thin, &r);
    for (int i = 0; i < TIMES; i++) {
        page *swap = r.values;

        sc_team_stage_for(ctx, each, p->team, p->brick_count, 4096, relax_bricks, &r);
        r.values = r.next;
        r.next = swap;
        sc_team_for(p->team, 1, 1, begin_empty, &r); /* of the other array */
    }
    sc_team_stage_for(ctx, each, p->team, p->brick_count, 4096, end_bricks, &r);
out:
    sc_team_free(p->team, r.slot);
    sc_team_free(p->team, r.values);
    sc_team_free(p->team, r.next);
    sc_team_free(p->team, r.thick);
    sc_team_free(p->team, r.simple);
    sc_team_free(p->team, r.differ);
    return status;
}
