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
 * them is the same on any processor. */
#include "wide_filters.h"

enum {
    TIMES = 6,
    AROUND = SC_AROUND,
    HALO = 2, /* vertices around a brick that two binomial filters reach */
    SIDE = SC_BRICK + 2 * HALO,
    LAYER = SIDE * SIDE,
    POINTS = SIDE * LAYER,
    PAD = SIDE,   /* around a window: rows are also read one place to the left and the right */
    ONE = 4096,   /* a weight of SC_WEIGHT_MAX */
    THIN_MAX = 2, /* neighbours that are thin, at which a vertex still counts as thick */
    BLOCKED = 27, /* of a thin mark: no neighbour may change */
    EXCESS = 23,  /* (1 + e) in EXCESS_ONE-ths */
    EXCESS_ONE = 16
};
/* Along an axis whose voxels are longer than this, in reference voxels, B is (1 6 1) / 8. */
#define LONG_STEP 1.2

/* Eight numbers of a window that are side by side along x. */
typedef int16_t row __attribute__((vector_size(2 * SIDE)));
/* One number for each of the 64 vertices of a brick, in the order of the bits of its mask. */
typedef int16_t page[SC_BRICK_VERTICES];

/* What the threads share. The arrays are of the team, and have one entry for each slot. */
typedef struct relax {
    const sc_preparation *p; /* borrowed; its records are changed in the end */
    uint32_t *slot;  /* of sc_number_bricks: slot 0 is that of all bricks far from borders */
    page *values;    /* weights in ONE-ths of the largest; ONE away from interfaces */
    page *next;      /* of the time that is being computed; first the marks of thin vertices */
    uint64_t *thick; /* the vertices that change */
    uint8_t *simple; /* 1 if the window of a brick holds two labels: one tells about both */
    int shift[3];    /* B along an axis adds the second difference, shifted right by this */
    float gain;      /* what weights are multiplied by in the end */
} relax;

/* A brick and what is around it, [z][y][x]. */
typedef struct window {
    uint16_t ids[POINTS];
    int16_t values[POINTS];
    int16_t own[PAD + POINTS + PAD];     /* the values, negative where the label is another */
    int16_t once[PAD + POINTS + PAD];    /* B of own, */
    int16_t twice[PAD + POINTS + PAD];   /* and B of that, but HALO vertices at the edges */
    int16_t between[PAD + POINTS + PAD]; /* filtered along some axes */
} window;

static inline row load(const int16_t *from)
{
    row out;

    memcpy(&out, from, sizeof out);
    return out;
}

static inline void store(int16_t *to, row value)
{
    memcpy(to, &value, sizeof value);
}

/* @return the index in a window of the vertex of a bit of its brick. */
static inline int point_of(int bit)
{
    return (sc_bit_z(bit) + HALO) * LAYER + (sc_bit_y(bit) + HALO) * SIDE + sc_bit_x(bit) + HALO;
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
        const int z = sc_nearest_voxel(low[2] - HALO + i / LAYER - 1, v->size[2]);
        const size_t brick = sc_brick_index(r->p->bricks, sc_brick_of(x + 1), sc_brick_of(y + 1),
                                            sc_brick_of(z + 1));

        w->ids[i] = (uint16_t)sc_id_or_nearest(v, x, y, z);
        w->values[i] = pages[r->slot[brick]][sc_brick_bit(x + 1, y + 1, z + 1)];
    }
}

/* As fetch_near_border, for any brick: that of index @p brick. */
static void fetch(const relax *r, const page *pages, size_t brick, window *w)
{
    const sc_volume *v = r->p->volume;
    const size_t line = (size_t)v->size[0], layer = line * (size_t)v->size[1];
    const ptrdiff_t brick_row = r->p->bricks[0], brick_layer = brick_row * r->p->bricks[1];
    const int16_t *around[AROUND];
    size_t voxel;
    int low[3];

    sc_brick_low(r->p->bricks, brick, low);
    if (!is_inside(v, low)) {
        fetch_near_border(r, pages, low, w);
        return;
    }
    voxel = (size_t)(low[2] - HALO - 1) * layer + (size_t)(low[1] - HALO - 1) * line +
            (size_t)(low[0] - HALO - 1);
    for (int i = 0; i < AROUND; i++)
        around[i] = pages[r->slot[(size_t)((ptrdiff_t)brick + (i / 9 - 1) * brick_layer +
                                           (i / 3 % 3 - 1) * brick_row + i % 3 - 1)]];
    for (int i = 0; i < POINTS; i += SIDE) {
        const int y = i / SIDE % SIDE - HALO, z = i / LAYER - HALO; /* from the brick */
        const int bit = sc_brick_bit(0, y, z);
        const int16_t *const *from = around + (sc_brick_of(z) + 1) * 9 + (sc_brick_of(y) + 1) * 3;
        int16_t *to = w->values + i;

        sc_copy_ids(v, voxel + (size_t)(i / LAYER) * layer + (size_t)(i / SIDE % SIDE) * line, SIDE,
                    w->ids + i);
        memcpy(to, from[0] + bit + SC_BRICK - HALO, HALO * sizeof *to);
        memcpy(to + HALO, from[1] + bit, SC_BRICK * sizeof *to);
        memcpy(to + HALO + SC_BRICK, from[2] + bit, HALO * sizeof *to);
    }
}

/* @return the number that follows from those of B and of B of B, each time. */
static inline int relaxed(int once, int twice)
{
    return once + (once - twice) * EXCESS / EXCESS_ONE;
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
 * around for which @p from has no numbers. Overwrites w->between. */
static void filter(const relax *r, const int16_t *from, int edge, window *w, int16_t *to)
{
    int16_t *between = w->between + PAD;

    for (int z = edge; z < SIDE - edge; z++) {
        for (int i = z * LAYER + (edge - 1) * SIDE; i < z * LAYER + (SIDE - edge + 1) * SIDE;
             i += SIDE)
            store(between + i, binomial_of(load(from + i - LAYER), load(from + i),
                                           load(from + i + LAYER), r->shift[2]));
        row below = load(between + z * LAYER + (edge - 1) * SIDE);
        for (int i = z * LAYER + edge * SIDE; i < z * LAYER + (SIDE - edge) * SIDE; i += SIDE) {
            const row here = load(between + i);

            store(between + i, binomial_of(below, here, load(between + i + SIDE), r->shift[1]));
            below = here;
            store(to + i, binomial_of(load(between + i - 1), load(between + i),
                                      load(between + i + 1), r->shift[0]));
        }
    }
}

/* Set w->own, once and twice for the label @p id. */
static void filter_label(const relax *r, uint16_t id, window *w)
{
    for (int i = 0; i < POINTS; i += SIDE) {
        const row differs = load((const int16_t *)(w->ids + i)) != (row){0} + (int16_t)id;

        store(w->own + PAD + i, (load(w->values + i) ^ differs) - differs); /* negated if it does */
    }
    filter(r, w->own + PAD, 1, w, w->once + PAD);
    filter(r, w->once + PAD, 2, w, w->twice + PAD);
}

/* Are there two labels in the window, that of its first vertex and another? Then that is written to
 * @p other; it is the first one's if there is none. */
static bool has_two_labels(const window *w, uint16_t *other)
{
    const uint16_t first = w->ids[0];

    *other = first;
    for (int i = 0; i < POINTS; i++) {
        if (w->ids[i] != first && w->ids[i] != *other && *other != first)
            return false;
        *other = w->ids[i] != first ? w->ids[i] : *other;
    }
    return true;
}

/* Does a third label lie within HALO of the vertex of a bit? */
static bool is_by_junction(const window *w, int bit)
{
    const int middle = point_of(bit);
    uint16_t other = w->ids[middle];

    for (int z = -HALO; z <= HALO; z++) {
        for (int y = -HALO; y <= HALO; y++) {
            for (int x = -HALO; x <= HALO; x++) {
                const uint16_t id = w->ids[middle + z * LAYER + y * SIDE + x];

                if (id != w->ids[middle] && id != other && other != w->ids[middle])
                    return true;
                other = id != w->ids[middle] ? id : other;
            }
        }
    }
    return false;
}

/* @return the vertices of @p mask, bits of the window's brick, that carry a label. */
static uint64_t vertices_of(const window *w, uint64_t mask, uint16_t id)
{
    uint64_t vertices = 0;

    for (uint64_t left = mask; left; left &= left - 1) {
        const int bit = __builtin_ctzll(left);

        vertices |= (uint64_t)(w->ids[point_of(bit)] == id) << bit;
    }
    return vertices;
}

/* Smooth the weights of the thick vertices of a brick once, from values to next. If the window
 * holds two labels, one tells about both. */
static void relax_brick(const relax *r, size_t brick, window *w)
{
    const uint32_t slot = r->slot[brick];
    uint64_t left = r->thick[slot];

    memcpy(r->next[slot], r->values[slot], sizeof(page));
    if (!left)
        return;
    fetch(r, r->values, brick, w);
    while (left) {
        const uint16_t id = w->ids[point_of(__builtin_ctzll(left))];
        const uint64_t own = vertices_of(w, left, id), done = r->simple[slot] ? left : own;

        filter_label(r, id, w);
        for (uint64_t some = done; some; some &= some - 1) {
            const int bit = __builtin_ctzll(some), at = PAD + point_of(bit);
            int value = relaxed(w->once[at], w->twice[at]);

            value = own >> bit & 1 ? value : -value;
            r->next[slot][bit] = (int16_t)(value < 1 ? 1 : value < ONE ? value : ONE);
        }
        left &= ~done;
    }
}

/* Smooth the bricks [begin, end) once; an sc_range_fn on a relax. */
static void relax_bricks(void *user, size_t begin, size_t end, int thread)
{
    const relax *r = user;
    window w = {.values = {0}};

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

/* Leave out of thick, in bricks [begin, end), the vertices with too many thin neighbours and those
 * near a third label; fill simple. An sc_range_fn on a relax. */
static void leave_out_thin(void *user, size_t begin, size_t end, int thread)
{
    const relax *r = user;
    window w = {.values = {0}};
    uint16_t other;

    (void)thread;
    for (size_t brick = begin; brick < end; brick++) {
        const uint32_t slot = r->slot[brick];

        if (!r->thick[slot])
            continue;
        fetch(r, r->next, brick, &w);
        r->simple[slot] = has_two_labels(&w, &other);
        for (uint64_t left = r->thick[slot]; left; left &= left - 1) {
            const int bit = __builtin_ctzll(left);
            int thin = 0;

            for (int i = 0; i < AROUND; i++)
                thin += w.values[point_of(bit) + (i / 9 - 1) * LAYER + (i / 3 % 3 - 1) * SIDE +
                                 i % 3 - 1];
            if (thin > THIN_MAX || (!r->simple[slot] && is_by_junction(&w, bit)))
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
    return status;
}
