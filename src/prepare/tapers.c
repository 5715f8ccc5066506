/* SPDX-License-Identifier: BSD-3-Clause */
/* Tissue that tapers below a voxel fades out, instead of ending in a ragged rim.
 *
 * Where a layer between two other labels becomes thinner than a voxel, only some of the places that
 * it covers hold the centre of a voxel of it. There its labels stand in rows and patches that
 * depend on how the layer lies in the grid, with gaps between them in which the other two labels
 * touch. How much of the layer is left at a place is how much of the area between those two labels
 * is covered by it, counted over the faces of voxels all around. The vertices of the layer note
 * what is missing, and the light of their surfaces is lessened by it: see SC_RECORD_FADES of
 * brick.h.
 *
 * A closed skin has no gaps, whatever its shape, and is never faded. A tissue that is thin in two
 * directions, such as a vessel on a wall, is not the end of a layer, although the labels touch on
 * either side of it: nothing is faded unless a closed part of the same layer is near. */
#include "internal.h"

#include <stdlib.h>
#include <string.h>
#ifdef __SSE2__
#include <emmintrin.h>
#endif

enum {
    RUN_MAX = 4, /* voxels: what is thicker along an axis is no thin layer */
    NEAR = 6,    /* voxels: how far around a vertex its cover is counted */
    FAR = 12,    /* voxels: a closed part of the layer must be within this distance */
    CLOSED = 2,  /* voxels: closed is where there is no gap within this distance */
    THICK = 1,   /* voxels: a layer is thin where nothing thick is within this distance */
    MARGIN = FAR + CLOSED,
    SIDE = SC_BRICK + 2 * MARGIN, /* edge of the block of voxels that a brick depends on: 32 */
    INNER = MARGIN - NEAR, /* rows of it at each side that tell nothing of gaps near the brick */
    /* of a brick, see find_layer */
    BEYOND = 1,
    HERE = 8,
    LAYERS = 4, /* of a brick; what others taper in it is left as it is */
    FACES = 3 * (SC_BRICK + 2 * NEAR) * (SC_BRICK + 2 * NEAR) * (SC_BRICK + 2 * NEAR)
};

/* Standard deviation, in voxels, of the Gaussian weights of the faces around a vertex. */
#define COVER_WIDTH 2.2
/* Nothing is faded where this share of the area is covered, and all where only COVER_LEAST is. */
#define COVER_ALL 0.95f
#define COVER_LEAST 0.45f
/* So many voxels of a closed part within FAR make sure that this is the end of a layer;
 * CLOSED_LEAST there may be where a vessel lies on a wall, since it crosses the whole of that way.
 */
#define CLOSED_ENOUGH 32.0f
#define CLOSED_LEAST 18.0f

/* A layer: voxels of one label between two others, low < high. */
typedef struct layer {
    uint32_t label, low, high;
} layer;

/* The voxels of a window that carry one label, or have some other property, as bits: [z][y], bit x.
 */
typedef uint32_t bit_block[SIDE][SIDE];

/* The place of a face in a window. */
typedef struct face {
    uint8_t x, y, z;
} face;

/* Faces of a window, in the order of their rows. */
typedef struct faces {
    face at[FACES];
    int count;
} faces;

/* The work on one brick. */
typedef struct brick_work {
    uint16_t ids[SIDE][SIDE][SIDE]; /* labels of the window, [z][y][x] */
    layer layers[LAYERS];
    int layer_count;
    uint8_t which[SC_BRICK_VERTICES]; /* the layer of a vertex, counted from 1; 0: none */
    bit_block changes[3];             /* by axis: voxels whose next has another label */
    bit_block own, low, high;         /* voxels of the three labels of the current layer */
    bit_block covered, meet, closed;  /* see find_covered and find_closed */
    faces covered_faces, gap_faces;
    float missing[SC_BRICK_VERTICES]; /* share of the current layer that is missing, by its faces */
    bool any_missing;                 /* it is more than 0 somewhere */
} brick_work;

/* What the threads share. */
typedef struct tapers {
    sc_preparation *p;      /* borrowed; its records are changed */
    uint8_t *found;         /* [brick_count], of the team: HERE and BEYOND, see find_layer */
    float weight[NEAR + 1]; /* Gaussian, by distance along an axis */
} tapers;

/* @return how many voxels, 1 to RUN_MAX, of a thin layer lie along an axis from a voxel on, the
 * first of it; 0 if it is none, or does not keep two labels apart. @param at the index of the
 * voxel.
 * @param step from voxel to voxel along the axis. */
static int layer_length(const sc_volume *v, size_t at, size_t step)
{
    const uint32_t id = sc_id_at(v, at), before = sc_id_at(v, at - step);

    if (before == id)
        return 0;
    for (int i = 1; i <= RUN_MAX; i++) {
        const uint32_t behind = sc_id_at(v, at + (size_t)i * step);

        if (behind != id)
            return behind != before ? i : 0;
    }
    return 0;
}

/* Note it, if a thin layer begins at a voxel: HERE for its brick, and BEYOND << axis if the layer
 * reaches into the next one. An sc_boundary_fn on tapers. Layers at the border of the volume are
 * passed over. */
static void find_layer(void *user, const sc_boundary_voxel *voxel)
{
    const tapers *t = user;
    const sc_volume *v = t->p->volume;
    const size_t row = (size_t)v->size[0], plane = row * (size_t)v->size[1];
    const size_t steps[3] = {1, row, plane};
    const int at[3] = {voxel->x, voxel->y, voxel->z};
    const size_t index = (size_t)at[2] * plane + (size_t)at[1] * row + (size_t)at[0];
    uint8_t found = 0;

    for (int axis = 0; axis < 3; axis++) {
        int length;

        if (at[axis] < 1 || at[axis] + RUN_MAX >= v->size[axis])
            continue;
        length = layer_length(v, index, steps[axis]);
        found |= length > 0 ? HERE : 0;
        if (length > 0 && ((at[axis] + 1) & SC_BRICK_MASK) + length > SC_BRICK)
            found |= (uint8_t)(BEYOND << axis);
    }
    if (found)
        t->found[sc_brick_index(t->p->bricks, sc_brick_of(at[0] + 1), sc_brick_of(at[1] + 1),
                                sc_brick_of(at[2] + 1))] |= found;
}

/* Fill found of bricks [begin, end); an sc_range_fn on tapers. */
static void find_layers(void *user, size_t begin, size_t end, int thread)
{
    tapers *t = user;

    (void)thread;
    sc_each_boundary(t->p, begin, end, find_layer, t);
}

/* Does the brick hold voxels of thin layers? */
static bool has_layers(const tapers *t, size_t brick)
{
    const int *bricks = t->p->bricks;
    const size_t steps[3] = {1, (size_t)bricks[0], (size_t)bricks[0] * (size_t)bricks[1]};
    int at[3];

    if (t->found[brick] & HERE)
        return true;
    sc_brick_at(bricks, brick, at);
    for (int axis = 0; axis < 3; axis++) {
        if (at[axis] > 0 && t->found[brick - steps[axis]] >> axis & BEYOND)
            return true;
    }
    return false;
}

/* The rows of a window on which something depends: y and z from first to last. */
typedef struct row_range {
    int first, last;
} row_range;

static const row_range all_rows = {0, SIDE - 1};
/* On these depend the layers of a brick and the gaps near it, to which the next row belongs. */
static const row_range inner_rows = {INNER, SIDE - INNER};
/* On these depend the faces that a layer covers near the brick. */
static const row_range middle_rows = {INNER - 1, SIDE - 1 - INNER + RUN_MAX};

/* Write the labels of some rows of the window around the brick whose lowest vertex is @p low to
 * w->ids; outside of the volume, those of the nearest voxels. */
static void fetch_window(const sc_volume *v, const int low[3], row_range rows, brick_work *w)
{
    const int count = rows.last - rows.first + 1;
    const int x0 = low[0] - 1 - MARGIN, y0 = low[1] - 1 - MARGIN, z0 = low[2] - 1 - MARGIN;
    const bool inner = x0 >= 0 && x0 + SIDE <= v->size[0];

    for (int row = 0; row < count * count; row++) {
        const int across = rows.first + row % count, up = rows.first + row / count;
        const int y = sc_nearest_voxel(y0 + across, v->size[1]),
                  z = sc_nearest_voxel(z0 + up, v->size[2]);
        const size_t at = ((size_t)z * (size_t)v->size[1] + (size_t)y) * (size_t)v->size[0] +
                          (size_t)(inner ? x0 : 0);
        uint16_t *to = w->ids[up][across];

        if (inner)
            sc_copy_ids(v, at, SIDE, to);
        for (int x = 0; x < SIDE && !inner; x++)
            to[x] = (uint16_t)sc_id_or_nearest(v, x0 + x, y, z);
    }
}

/* @return where two rows of SIDE labels are equal, as bits. */
#ifdef __SSE2__
static inline uint32_t equal_bits(const uint16_t *a, const uint16_t *b)
{
    uint32_t bits = 0;

    for (int x = 0; x < SIDE; x += 8) {
        const __m128i equal =
            _mm_cmpeq_epi16(_mm_loadu_si128((const __m128i *)(const void *)(a + x)),
                            _mm_loadu_si128((const __m128i *)(const void *)(b + x)));

        bits |= (uint32_t)_mm_movemask_epi8(_mm_packs_epi16(equal, _mm_setzero_si128())) << x;
    }
    return bits;
}
_Static_assert(SIDE % 8 == 0, "equal_bits reads eight labels at a time");
#else
static inline uint32_t equal_bits(const uint16_t *a, const uint16_t *b)
{
    uint32_t bits = 0;

    for (int x = 0; x < SIDE; x++)
        bits |= (uint32_t)(a[x] == b[x]) << x;
    return bits;
}
#endif

/* Fill w->changes from w->ids. The last voxels along an axis count as having no next one. */
static void find_changes(brick_work *w)
{
    const uint32_t all = (1u << (SIDE - 1)) - 1;

    memset(w->changes, 0, sizeof w->changes);
    for (int z = 0; z < SIDE - 1; z++) {
        for (int y = 0; y < SIDE - 1; y++) {
            const uint16_t *row = w->ids[z][y];

            w->changes[0][z][y] = all & ~equal_bits(row, row + 1);
            w->changes[1][z][y] = all & ~equal_bits(row, w->ids[z][y + 1]);
            w->changes[2][z][y] = all & ~equal_bits(row, w->ids[z + 1][y]);
        }
    }
}

/* @return the label at @p by voxels along an axis from the one at @p at, in the window. */
static uint32_t id_beside(const brick_work *w, const int at[3], int axis, int by)
{
    return w->ids[at[2] + (axis == 2 ? by : 0)][at[1] + (axis == 1 ? by : 0)]
                 [at[0] + (axis == 0 ? by : 0)];
}

/* Find the thin layer that the voxel at @p at of the window belongs to: along the first axis on
 * which it is thin. @return false if there is none. */
static bool layer_of(const brick_work *w, const int at[3], layer *out)
{
    const uint32_t id = id_beside(w, at, 0, 0);

    for (int axis = 0; axis < 3; axis++) {
        uint32_t before, behind;
        int first = 1, last = 1;

        while (first < RUN_MAX && id_beside(w, at, axis, -first) == id)
            first++;
        while (last < RUN_MAX && id_beside(w, at, axis, last) == id)
            last++;
        before = id_beside(w, at, axis, -first);
        behind = id_beside(w, at, axis, last);
        if (before == id || behind == id || before == behind || first + last - 1 > RUN_MAX)
            continue;
        *out = before < behind ? (layer){id, before, behind} : (layer){id, behind, before};
        return true;
    }
    return false;
}

/* Fill layers, layer_count and which of @p w for the vertices @p mask of the brick. */
static void list_layers(brick_work *w, uint64_t mask)
{
    w->layer_count = 0;
    memset(w->which, 0, sizeof w->which);
    for (; mask; mask &= mask - 1) {
        const int bit = __builtin_ctzll(mask);
        const int at[3] = {MARGIN + sc_bit_x(bit), MARGIN + sc_bit_y(bit), MARGIN + sc_bit_z(bit)};
        layer found;
        int i = 0;

        if (!id_beside(w, at, 0, 0) || !layer_of(w, at, &found))
            continue;
        while (i < w->layer_count &&
               (w->layers[i].label != found.label || w->layers[i].low != found.low ||
                w->layers[i].high != found.high))
            i++;
        if (i == LAYERS)
            continue;
        w->layers[i] = found;
        w->layer_count = i < w->layer_count ? w->layer_count : i + 1;
        w->which[bit] = (uint8_t)(i + 1);
    }
}

/* Fill some rows of a block with the voxels that carry @p id. */
static void fill_bits(const brick_work *w, uint32_t id, row_range rows, bit_block out)
{
    uint16_t ids[SIDE];

    for (int x = 0; x < SIDE; x++)
        ids[x] = (uint16_t)id;
    for (int z = rows.first; z <= rows.last; z++) {
        for (int y = rows.first; y <= rows.last; y++)
            out[z][y] = equal_bits(w->ids[z][y], ids);
    }
}

/* @return row (y, z) of a block, moved so that each bit is that of the voxel @p by further along an
 * axis. */
static uint32_t moved(const bit_block block, int z, int y, int axis, int by)
{
    if (axis == 0)
        return by < 0 ? block[z][y] << -by : block[z][y] >> by;
    return axis == 1 ? block[z][y + by] : block[z + by][y];
}

/* @return the voxels of a row with which the layer begins along an axis, and covers the way from
 * one of its neighbours to the other. */
static uint32_t covered_row(const brick_work *w, int z, int y, int axis)
{
    uint32_t own = w->own[z][y], begins = 0, low, high;

    if (!own)
        return 0;
    low = moved(w->low, z, y, axis, -1);
    high = moved(w->high, z, y, axis, -1);
    for (int length = 1; length <= RUN_MAX && own; length++) {
        const uint32_t to_low = moved(w->low, z, y, axis, length),
                       to_high = moved(w->high, z, y, axis, length);

        begins |= own & ((low & to_high) | (high & to_low));
        own &= moved(w->own, z, y, axis, length);
    }
    return begins;
}

/* @return the voxels of a row that have one of the layer's neighbours, where the next along an axis
 * has the other one. */
static uint32_t gap_row(const brick_work *w, int z, int y, int axis)
{
    return (w->low[z][y] & moved(w->high, z, y, axis, 1)) |
           (w->high[z][y] & moved(w->low, z, y, axis, 1));
}

/* Append the voxels of a row within NEAR of the brick to a list, those that are so along x, too. */
static void append_row(faces *list, uint32_t row, int z, int y)
{
    row &= (2u << (SIDE - 1 - INNER)) - (1u << INNER);
    for (; row; row &= row - 1)
        list->at[list->count++] = (face){(uint8_t)__builtin_ctz(row), (uint8_t)y, (uint8_t)z};
}

/* Find the gaps of the current layer near the brick, from low and high. @return how many there are.
 */
static int find_gaps(brick_work *w)
{
    w->gap_faces.count = 0;
    for (int z = INNER; z < SIDE - INNER; z++) {
        for (int y = INNER; y < SIDE - INNER; y++) {
            for (int axis = 0; axis < 3; axis++)
                append_row(&w->gap_faces, gap_row(w, z, y, axis), z, y);
        }
    }
    return w->gap_faces.count;
}

/* Find the faces that the current layer covers near the brick, from own, low and high. */
static void find_faces(brick_work *w)
{
    w->covered_faces.count = 0;
    for (int z = INNER; z < SIDE - INNER; z++) {
        for (int y = INNER; y < SIDE - INNER; y++) {
            for (int axis = 0; axis < 3 && w->own[z][y]; axis++)
                append_row(&w->covered_faces, covered_row(w, z, y, axis), z, y);
        }
    }
}

/* Find, in the whole window, the voxels with one or more faces that the current layer covers, and
 * for w->meet those with a face at which two labels other than the layer's meet. */
static void find_covered(brick_work *w)
{
    memset(w->covered, 0, sizeof w->covered);
    memset(w->meet, 0, sizeof w->meet);
    for (int z = 1; z < SIDE - RUN_MAX; z++) {
        for (int y = 1; y < SIDE - RUN_MAX; y++) {
            for (int axis = 0; axis < 3; axis++) {
                w->covered[z][y] |= covered_row(w, z, y, axis);
                w->meet[z][y] |=
                    w->changes[axis][z][y] & ~w->own[z][y] & ~moved(w->own, z, y, axis, 1);
            }
        }
    }
}

/* @return row (y, z) of the voxels with one of w->meet within CLOSED of them along all axes. */
static uint32_t near_meet(const brick_work *w, int z, int y)
{
    uint32_t any = 0, wide = 0;

    for (int dz = -CLOSED; dz <= CLOSED; dz++) {
        for (int dy = -CLOSED; dy <= CLOSED; dy++)
            any |= w->meet[z + dz][y + dy];
    }
    for (int dx = 0; dx <= CLOSED; dx++)
        wide |= any << dx | any >> dx;
    return wide;
}

/* Fill w->closed: the covered voxels with nothing else than the layer near that would keep two
 * labels apart, or fail to. */
static void find_closed(brick_work *w)
{
    memset(w->closed, 0, sizeof w->closed);
    for (int z = MARGIN - FAR; z < SIDE - (MARGIN - FAR); z++) {
        for (int y = MARGIN - FAR; y < SIDE - (MARGIN - FAR); y++)
            w->closed[z][y] = w->covered[z][y] ? w->covered[z][y] & ~near_meet(w, z, y) : 0;
    }
}

/* @return how many voxels of w->closed are within FAR of the voxel at @p at along all axes. */
static unsigned closed_around(const brick_work *w, const int at[3])
{
    const uint32_t columns = (2u << (at[0] + FAR)) - (1u << (at[0] - FAR));
    unsigned count = 0;

    for (int z = at[2] - FAR; z <= at[2] + FAR; z++) {
        for (int y = at[1] - FAR; y <= at[1] + FAR; y++)
            count += sc_count_bits(w->closed[z][y] & columns);
    }
    return count;
}

/* Is the layer thick near the voxel at @p at: is there within THICK of it, along all axes, a voxel
 * of it whose neighbours beyond its faces all belong to it? */
static bool is_thick(const brick_work *w, const int at[3])
{
    const uint32_t columns = (2u << (at[0] + THICK)) - (1u << (at[0] - THICK));
    uint32_t any = 0;

    for (int z = at[2] - THICK; z <= at[2] + THICK; z++) {
        for (int y = at[1] - THICK; y <= at[1] + THICK; y++) {
            uint32_t inner = w->own[z][y];

            for (int axis = 0; axis < 3; axis++)
                inner &= moved(w->own, z, y, axis, -1) & moved(w->own, z, y, axis, 1);
            any |= inner & columns;
        }
    }
    return any != 0;
}

/* @return the sum of the weights of faces around the voxel at @p at. */
static float weigh_faces(const tapers *t, const faces *list, const int at[3])
{
    float sum = 0;

    for (int i = 0; i < list->count; i++) {
        const int x = abs(list->at[i].x - at[0]), y = abs(list->at[i].y - at[1]),
                  z = abs(list->at[i].z - at[2]);

        if (x <= NEAR && y <= NEAR && z <= NEAR)
            sum += t->weight[x] * t->weight[y] * t->weight[z];
    }
    return sum;
}

/* @return @p x limited to [0, 1]. */
static float limited(float x)
{
    return x < 0 ? 0 : x > 1 ? 1 : x;
}

/* @return the share of the current layer that is missing at the voxel at @p at of the window, as
 * far as the faces near it tell. */
static float missing_at(const tapers *t, const brick_work *w, const int at[3])
{
    float covered, gaps;

    if (is_thick(w, at))
        return 0;
    covered = weigh_faces(t, &w->covered_faces, at);
    gaps = weigh_faces(t, &w->gap_faces, at);
    return limited((COVER_ALL - covered / (covered + gaps + 1e-6f)) / (COVER_ALL - COVER_LEAST));
}

/* Call @p visit for each vertex of @p near that belongs to a layer of a brick, with its place in
 * the window. */
typedef void vertex_fn(const tapers *t, brick_work *w, size_t brick, int bit, const int at[3]);
static void each_vertex(const tapers *t, brick_work *w, size_t brick, int number, vertex_fn *visit)
{
    for (uint64_t left = t->p->near[brick]; left; left &= left - 1) {
        const int bit = __builtin_ctzll(left);
        const int at[3] = {MARGIN + sc_bit_x(bit), MARGIN + sc_bit_y(bit), MARGIN + sc_bit_z(bit)};

        if (w->which[bit] == number + 1)
            visit(t, w, brick, bit, at);
    }
}

/* A vertex_fn. */
static void note_missing(const tapers *t, brick_work *w, size_t brick, int bit, const int at[3])
{
    (void)brick;
    w->missing[bit] = missing_at(t, w, at);
    w->any_missing |= w->missing[bit] > 0;
}

/* A vertex_fn: write what is missing of the current layer, 0 to SC_RECORD_FADES, where a closed
 * part of it makes sure that it is missing. */
static void write_fade(const tapers *t, brick_work *w, size_t brick, int bit, const int at[3])
{
    const size_t index = t->p->near_start[brick] + sc_brick_rank(t->p->near[brick], bit);
    float sure;

    if (!(w->missing[bit] > 0))
        return;
    sure = limited(((float)closed_around(w, at) - CLOSED_LEAST) / (CLOSED_ENOUGH - CLOSED_LEAST));
    sc_record_write(t->p->records, index,
                    sc_record_fade(sc_record_read(t->p->records, index),
                                   (uint32_t)(SC_RECORD_FADES * w->missing[bit] * sure + 0.5f)));
}

/* Fill own, low and high for a layer in some rows, which have been fetched. */
static void fill_layer(brick_work *w, const layer *l, row_range rows)
{
    fill_bits(w, l->low, rows, w->low);
    fill_bits(w, l->high, rows, w->high);
    fill_bits(w, l->label, rows, w->own);
}

/* Fetch more rows of the window. @param have those that have been fetched; becomes @p rows if that
 * is more. */
static void fetch_more(const tapers *t, const int low[3], row_range rows, row_range *have,
                       brick_work *w)
{
    if (have->first <= rows.first)
        return;
    fetch_window(t->p->volume, low, rows, w);
    *have = rows;
}

/* Note in the records of a brick what is missing of each of its layers. Nothing is of most layers;
 * the inner rows of the window tell so of many, and the middle ones of most others. */
static void fade_brick(const tapers *t, brick_work *w, size_t brick)
{
    row_range have = inner_rows;
    bool changes = false; /* those of the window have been found */
    int low[3];

    sc_brick_low(t->p->bricks, brick, low);
    fetch_window(t->p->volume, low, inner_rows, w);
    list_layers(w, t->p->near[brick]);
    for (int i = 0; i < w->layer_count; i++) {
        fill_bits(w, w->layers[i].low, inner_rows, w->low);
        fill_bits(w, w->layers[i].high, inner_rows, w->high);
        if (!find_gaps(w))
            continue;
        fetch_more(t, low, middle_rows, &have, w);
        fill_layer(w, &w->layers[i], middle_rows);
        find_faces(w);
        w->any_missing = false;
        each_vertex(t, w, brick, i, note_missing);
        if (!w->any_missing)
            continue;
        fetch_more(t, low, all_rows, &have, w);
        if (!changes)
            find_changes(w);
        changes = true;
        fill_layer(w, &w->layers[i], all_rows);
        find_covered(w);
        find_closed(w);
        each_vertex(t, w, brick, i, write_fade);
    }
}

/* Fade the layers of bricks [begin, end); an sc_range_fn on tapers. */
static void fade_bricks(void *user, size_t begin, size_t end, int thread)
{
    const tapers *t = user;
    brick_work w;

    (void)thread;
    for (size_t brick = begin; brick < end; brick++) {
        if (t->p->near[brick] && has_layers(t, brick))
            fade_brick(t, &w, brick);
    }
}

sc_status sc_fade_tapers(const sc_ctx *ctx, sc_preparation *p)
{
    tapers t = {.p = p};
    const uint64_t each = SC_WORTH_TAPERS / 2; /* there are so many loops */
    void *block;
    sc_status status;

    if (!sc_is_smoothed(p))
        return SC_OK;
    status = sc_team_alloc(ctx, p->team, p->brick_count, 1, &block);
    if (status != SC_OK)
        return status;
    t.found = block;
    for (int i = 0; i <= NEAR; i++)
        t.weight[i] = (float)exp(-i * i / (2 * COVER_WIDTH * COVER_WIDTH));
    sc_team_stage_for(ctx, each, p->team, p->brick_count, 4096, find_layers, &t);
    sc_team_stage_for(ctx, each, p->team, p->brick_count, 1024, fade_bricks, &t);
    sc_team_free(p->team, t.found);
    return SC_OK;
}
