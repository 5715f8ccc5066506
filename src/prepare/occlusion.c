/* SPDX-License-Identifier: BSD-3-Clause */
/* How much of each brick is filled with visible tissue, blurred by Gaussians of two widths. A brick
 * without an interface holds one label only, so that the vertices of all others alone are visited.
 */
#include "segcast/prepare.h"

#include <string.h>

/* Widths of the blurs in bricks of equal sides. */
#define NARROW_BRICKS 0.8
#define WIDE_BRICKS 3.0
enum { REACH = 9 /* bricks: the largest half width of the filter */ };

/* A blur that is being computed; its threads share it. */
typedef struct blur {
    const sc_prepared *volume;
    const float *opacity;      /* [label_count], 0 to 1 */
    int size[3];               /* bricks along x, y, z, the frame included */
    float *from, *to;          /* source and target of a pass, [z][y][x] */
    int axis;                  /* axis of the present pass */
    float taps[2 * REACH + 1]; /* of its filter: taps[REACH + i] for -reach <= i <= reach */
    int reach;                 /* half width of that filter, in bricks */
    uint8_t (*filled)[2];      /* the results, as of sc_occlusion */
    int which;                 /* which result is being computed: 0 narrow, 1 wide */
} blur;

/* @return the sum of the opacities at all vertices of a brick, all of which must be voxels of the
 * volume. @param low its lowest vertex. */
static float sum_inside(const blur *b, const int low[3])
{
    const sc_prepared *v = b->volume;
    const size_t nx = (size_t)v->size[0], plane = nx * (size_t)v->size[1];
    const size_t base =
        (size_t)(low[2] - 1) * plane + (size_t)(low[1] - 1) * nx + (size_t)(low[0] - 1);
    float sum = 0;

    for (int row = 0; row < SC_BRICK_LAYER; row++) {
        const size_t at = base + (size_t)(row / SC_BRICK) * plane + (size_t)(row % SC_BRICK) * nx;

        for (size_t x = 0; x < SC_BRICK; x++)
            sum += b->opacity[v->label_bytes == 1 ? ((const uint8_t *)v->ids)[at + x]
                                                  : ((const uint16_t *)v->ids)[at + x]];
    }
    return sum;
}

/* @return the mean opacity of the vertices of a brick, those outside the volume being background.
 * @param low its lowest vertex. */
static float occupancy(const blur *b, size_t brick, const int low[3])
{
    const int *size = b->volume->size;
    float sum = 0;

    /* One label only: asked for one vertex further in, as the lowest may lie outside the volume. */
    if (!b->volume->boundary.masks[brick])
        return b->opacity[sc_id_at_vertex(b->volume, low[0] + 1, low[1] + 1, low[2] + 1)];
    if (low[0] > 0 && low[1] > 0 && low[2] > 0 && low[0] + SC_BRICK <= size[0] + 1 &&
        low[1] + SC_BRICK <= size[1] + 1 && low[2] + SC_BRICK <= size[2] + 1)
        return sum_inside(b, low) / SC_BRICK_VERTICES;
    for (int bit = 0; bit < SC_BRICK_VERTICES; bit++)
        sum += b->opacity[sc_id_at_vertex(b->volume, low[0] + sc_bit_x(bit), low[1] + sc_bit_y(bit),
                                          low[2] + sc_bit_z(bit))];
    return sum / SC_BRICK_VERTICES;
}

/* Write the occupancy of bricks [begin, end) (without the frame) to b->from; an sc_range_fn on a
 * blur. The frame must be zero already. */
static void fill_occupancy(void *user, size_t begin, size_t end, int thread)
{
    const blur *b = user;

    for (size_t brick = begin; brick < end; brick++) {
        int at[3], low[3];

        sc_brick_at(b->volume->bricks, brick, at);
        sc_brick_low(b->volume->bricks, brick, low);
        b->from[sc_framed_index(b->size[0], b->size[0] * b->size[1], at[0], at[1], at[2])] =
            occupancy(b, brick, low);
    }
}

/* Write rows of bricks [begin, end) of b->to from b->from, filtered along b->axis; an sc_range_fn
 * on a blur. Outside of the array everything is empty. One tap of the filter is added after the
 * other, so that the inner loop runs along x. */
static void blur_rows(void *user, size_t begin, size_t end, int thread)
{
    const blur *b = user;
    const ptrdiff_t nx = b->size[0], strides[3] = {1, nx, nx * b->size[1]};

    for (size_t row = begin; row < end; row++) {
        const int y = (int)(row % (size_t)b->size[1]), z = (int)(row / (size_t)b->size[1]);
        const int at = b->axis == 1 ? y : z;
        float *to = b->to + (ptrdiff_t)row * nx;

        memset(to, 0, (size_t)nx * sizeof *to);
        for (int i = -b->reach; i <= b->reach; i++) {
            const float tap = b->taps[i + REACH];
            const float *from = b->from + (ptrdiff_t)row * nx + i * strides[b->axis];
            const ptrdiff_t low = b->axis == 0 && i < 0 ? -i : 0;
            const ptrdiff_t high = b->axis == 0 && i > 0 ? nx - i : nx;

            if (b->axis > 0 && (at + i < 0 || at + i >= b->size[b->axis]))
                continue;
            for (ptrdiff_t x = low; x < high; x++)
                to[x] += tap * from[x];
        }
    }
}

/* Round rows [begin, end) of b->from, 0 to 1, to 255ths and store them in b->filled; an sc_range_fn
 * on a blur. */
static void store_rows(void *user, size_t begin, size_t end, int thread)
{
    const blur *b = user;

    for (size_t at = begin * (size_t)b->size[0]; at < end * (size_t)b->size[0]; at++)
        b->filled[at][b->which] = (uint8_t)(b->from[at] * 255 + 0.5f);
}

/* Set reach and taps to a Gaussian whose taps add up to 1. @param width its standard deviation, in
 * bricks; the filter ends at three of them or at REACH. */
static void fill_taps(blur *b, double width)
{
    double taps[2 * REACH + 1], sum = 0;

    b->reach = (int)ceil(3 * width) < REACH ? (int)ceil(3 * width) : REACH;
    for (int i = -b->reach; i <= b->reach; i++) {
        taps[i + REACH] = exp(-i * i / (2 * width * width));
        sum += taps[i + REACH];
    }
    for (int i = -b->reach; i <= b->reach; i++)
        b->taps[i + REACH] = (float)(taps[i + REACH] / sum);
}

/* Blur b->from by a Gaussian of this standard deviation along all axes and store the result in
 * b->filled at b->which. It stays in b->from too; b->to is overwritten. The two may be exchanged.
 * @param brick_mm edges of a brick. */
static void run_blur(sc_team *team, blur *b, const double brick_mm[3], double width_mm)
{
    const size_t rows = (size_t)b->size[1] * (size_t)b->size[2];

    for (b->axis = 0; b->axis < 3; b->axis++) {
        float *swap = b->from;

        fill_taps(b, fmax(width_mm / brick_mm[b->axis], 0.2));
        sc_team_for(team, rows, 64, blur_rows, b);
        b->from = b->to;
        b->to = swap;
    }
    sc_team_for(team, rows, 64, store_rows, b);
}

/* @return whether what is stored with the volume was made for these opacities. */
static bool is_stored(const sc_prepared *volume, const float *opacity)
{
    const float *stored = volume->stored.opacity;
    bool same = stored != NULL;

    for (int id = 0; id < volume->label_count && same; id++)
        same = stored[id] >= opacity[id] && stored[id] <= opacity[id];
    return same;
}

/* Fill in the occlusion: b->filled. @param brick_mm edges of a brick. @param mean_mm of an edge of
 * equal bricks. Return code as of sc_occlusion_build. */
static sc_status fill(const sc_ctx *ctx, sc_team *team, blur *b, const double brick_mm[3],
                      double mean_mm)
{
    const size_t count = sc_brick_count(b->size);
    void *from = NULL, *to = NULL, *filled;
    sc_status status;

    SC_TRY(sc_team_alloc(ctx, team, count, sizeof(float), &from));
    SC_TRY(sc_team_alloc(ctx, team, count, sizeof(float), &to));
    SC_TRY(sc_team_alloc(ctx, team, count + SC_GATHER_BYTES, 2, &filled));
    b->from = from;
    b->to = to;
    b->filled = filled;
    sc_team_for(team, sc_brick_count(b->volume->bricks), 4096, fill_occupancy, b);
    run_blur(team, b, brick_mm, NARROW_BRICKS * mean_mm);
    b->which = 1; /* blurring the narrow result further: variances add up */
    run_blur(team, b, brick_mm,
             sqrt(WIDE_BRICKS * WIDE_BRICKS - NARROW_BRICKS * NARROW_BRICKS) * mean_mm);
out:
    sc_team_free(team, from);
    sc_team_free(team, to);
    return status;
}

sc_status sc_occlusion_build(const sc_ctx *ctx, sc_team *team, const sc_prepared *volume,
                             const float *opacity, sc_occlusion *out)
{
    blur b = {.volume = volume, .opacity = opacity};
    const uint8_t(*filled)[2] = volume->stored.occlusion;
    double brick_mm[3], mean_mm, least_mm = HUGE_VAL;

    sc_framed_size(volume->bricks, b.size);
    for (int i = 0; i < 3; i++) {
        brick_mm[i] = SC_BRICK * sc_vec3_length(sc_affine_column(&volume->to_ras_mm, i));
        least_mm = fmin(least_mm, brick_mm[i]);
    }
    mean_mm = cbrt(brick_mm[0] * brick_mm[1] * brick_mm[2]);
    if (!is_stored(volume, opacity)) {
        SC_PASS(fill(ctx, team, &b, brick_mm, mean_mm));
        filled = (const uint8_t(*)[2])b.filled;
    }
    *out = (sc_occlusion){.filled = filled,
                          .brick_offset = 1 - (SC_BRICK - 1) / (2.0f * SC_BRICK),
                          .narrow_mm = NARROW_BRICKS * mean_mm,
                          .wide_mm = WIDE_BRICKS * mean_mm,
                          .mm_per_step = least_mm};
    memcpy(out->size, b.size, sizeof out->size);
    return SC_OK;
}
