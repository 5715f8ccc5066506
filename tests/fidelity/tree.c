/* SPDX-License-Identifier: BSD-3-Clause */
/* Lists of tiles, and the nearest of them to a point, by a tree of boxes. */
#include "against.h"

#include <stdlib.h>

enum { LEAF = 8 };

/* The smaller and the larger of two numbers; fminf and fmaxf are calls of the library. */
static inline float least(float a, float b)
{
    return a < b ? a : b;
}

/* See least. */
static inline float most(float a, float b)
{
    return a > b ? a : b;
}

void tiles_add(tiles *t, const tile *piece)
{
    if (t->count == t->capacity) {
        t->capacity = t->capacity ? 2 * t->capacity : 1024;
        t->list = realloc(t->list, t->capacity * sizeof *t->list);
        if (!t->list)
            abort();
    }
    t->list[t->count++] = *piece;
}

void tiles_free(tiles *t)
{
    free(t->list);
    *t = (tiles){0};
}

/* A box along the axes; empty if low is above high. */
typedef struct box {
    float low[3], high[3];
} box;

/* A binary tree in an array: the root is boxes[1], the children of i are 2 i and 2 i + 1, and the
 * last `leaves` boxes hold LEAF tiles each, in order. */
struct tree {
    const tiles *t;
    size_t leaves; /* a power of two */
    box *boxes;    /* [2 * leaves] */
};

/* The box without any point. */
static const box nothing = {{HUGE_VALF, HUGE_VALF, HUGE_VALF},
                            {-HUGE_VALF, -HUGE_VALF, -HUGE_VALF}};

/* Grow a box by @p reach round the point @p p. */
static void grow(box *b, const float p[3], const float reach[3])
{
    for (int i = 0; i < 3; i++) {
        b->low[i] = least(b->low[i], p[i] - reach[i]);
        b->high[i] = most(b->high[i], p[i] + reach[i]);
    }
}

/* Exchange two tiles. */
static void swap(tile *a, tile *b)
{
    const tile kept = *a;

    *a = *b;
    *b = kept;
}

/* Order the tiles [@p first, @p end) of a list so that none before @p split lies farther along
 * @p axis than any behind it (quickselect, Hoare 1961). */
static void part(tile *list, size_t first, size_t end, size_t split, int axis)
{
    while (end - first > 1) {
        const float pivot = list[first + (end - first - 1) / 2].middle[axis];
        size_t i = first, j = end - 1;

        while (true) {
            while (list[i].middle[axis] < pivot)
                i++;
            while (list[j].middle[axis] > pivot)
                j--;
            if (i >= j)
                break;
            swap(&list[i++], &list[j--]);
        }
        /* None of [first, j] lies beyond the pivot, none of (j, end) before it; the pivot is not
         * the last of several, so j < end - 1. */
        if (split <= j)
            end = j + 1;
        else
            first = j + 1;
    }
}

/* Order the tiles under a node, which is the root of @p leaves leaves and whose first tile is
 * @p first: those under its left child lie on one side, along the longest edge of their box, of
 * those under its right child, and so on. */
static void order_tiles(tiles *t, size_t first, size_t leaves)
{
    static const float none[3];
    const size_t split = first + leaves / 2 * LEAF;
    const size_t end = first + leaves * LEAF < t->count ? first + leaves * LEAF : t->count;
    box around = nothing;
    int axis = 0;

    if (leaves < 2 || first >= t->count)
        return;
    for (size_t i = first; i < end; i++)
        grow(&around, t->list[i].middle, none);
    for (int i = 1; i < 3; i++) {
        if (around.high[i] - around.low[i] > around.high[axis] - around.low[axis])
            axis = i;
    }
    if (split < end)
        part(t->list, first, end, split, axis);
    order_tiles(t, first, leaves / 2);
    order_tiles(t, split, leaves / 2);
}

sc_status tree_build(const sc_ctx *ctx, tiles *t, tree **out)
{
    void *block = NULL;
    tree *made = NULL;
    sc_status status;

    SC_TRY(sc_zalloc(ctx, 1, sizeof *made, &block));
    made = block;
    made->t = t;
    made->leaves = 1;
    while (made->leaves * LEAF < t->count)
        made->leaves *= 2;
    SC_TRY(sc_alloc(ctx, 2 * made->leaves, sizeof *made->boxes, &block));
    made->boxes = block;
    order_tiles(t, 0, made->leaves);
    for (size_t i = 0; i < 2 * made->leaves; i++)
        made->boxes[i] = nothing;
    for (size_t i = 0; i < t->count; i++) {
        const tile *piece = &t->list[i];
        float reach[3];

        for (int k = 0; k < 3; k++)
            reach[k] = fabsf(piece->a[k]) + fabsf(piece->b[k]);
        grow(&made->boxes[made->leaves + i / LEAF], piece->middle, reach);
    }
    for (size_t i = made->leaves; i-- > 1;) {
        const box *second = &made->boxes[2 * i + 1];
        static const float none[3];

        made->boxes[i] = made->boxes[2 * i]; /* filled before the second one is */
        if (second->low[0] <= second->high[0]) {
            grow(&made->boxes[i], second->low, none);
            grow(&made->boxes[i], second->high, none);
        }
    }
    *out = made;
    made = NULL;
out:
    tree_free(made);
    return status;
}

void tree_free(tree *t)
{
    if (t)
        sc_free(t->boxes);
    sc_free(t);
}

/* The square of the distance of the point @p p from a box; HUGE_VALF from an empty one. */
static float box_distance(const box *b, const float p[3])
{
    float sum = 0;

    if (b->low[0] > b->high[0])
        return HUGE_VALF;
    for (int i = 0; i < 3; i++) {
        const float off = most(0, most(b->low[i] - p[i], p[i] - b->high[i]));

        sum += off * off;
    }
    return sum;
}

/* The square of the distance of the point @p p from a tile. */
static float tile_distance(const tile *piece, const float p[3])
{
    float off[3], s = 0, t = 0, aa = 0, bb = 0, sum = 0;

    for (int i = 0; i < 3; i++) {
        off[i] = p[i] - piece->middle[i];
        s += off[i] * piece->a[i];
        t += off[i] * piece->b[i];
        aa += piece->a[i] * piece->a[i];
        bb += piece->b[i] * piece->b[i];
    }
    s = aa > 0 ? least(1, most(-1, s / aa)) : 0;
    t = bb > 0 ? least(1, most(-1, t / bb)) : 0;
    for (int i = 0; i < 3; i++) {
        const float rest = off[i] - s * piece->a[i] - t * piece->b[i];

        sum += rest * rest;
    }
    return sum;
}

double tree_distance(const tree *t, sc_vec3 mm)
{
    const float p[3] = {(float)mm.x, (float)mm.y, (float)mm.z};
    size_t waiting[128], count = 0;
    float best = HUGE_VALF;

    waiting[count++] = 1;
    while (count) {
        size_t node = waiting[--count];

        if (box_distance(&t->boxes[node], p) >= best)
            continue;
        if (node < t->leaves) {
            const bool second =
                box_distance(&t->boxes[2 * node + 1], p) < box_distance(&t->boxes[2 * node], p);

            waiting[count++] = 2 * node + !second; /* the farther one waits longer */
            waiting[count++] = 2 * node + second;
            continue;
        }
        node -= t->leaves;
        for (size_t i = node * LEAF; i < (node + 1) * LEAF && i < t->t->count; i++)
            best = least(best, tile_distance(&t->t->list[i], p));
    }
    return sqrt((double)best);
}
