/* SPDX-License-Identifier: BSD-3-Clause */
/* Local thickness at boundary voxels, from a Euclidean distance transform of all labels at once:
 * along rows first, then by lower envelopes of parabolas along y and z (Felzenszwalb and
 * Huttenlocher 2012, "Distance transforms of sampled functions"). Lines are cut wherever the label
 * changes, so that every voxel gets the distance to the nearest voxel of another label.
 *
 * Distances are kept in 16 bits, in units of 1/128 of the smallest spacing. That
 * is finer than the codes of thicknesses, and depths of up to 512 voxels fit. */
#include "internal.h"

enum {
    UNITS_PER_VOXEL = 128,
    UNITS_MAX = UINT16_MAX,
    COLUMNS = 64, /* lines that are processed side by side: they share cache lines */
    TOGETHER = 8  /* voxels of lines that are copied together */
};

/* The transform that is being computed; its threads share it. The arrays belong to
 * sc_measure_thickness. */
typedef struct transform {
    const sc_preparation *p; /* borrowed; thickness is filled */
    uint16_t *distance;      /* [size z][y][x], of the team, in units; 0 in the background */
    double step_units[3];    /* length of one voxel along each axis */
    int axis;                /* axis of the present pass: 1 or 2 */
    float *half_inverse;     /* [longest axis + 2]: 1 / (2 i) */
    char *scratch;           /* [threads][scratch_bytes] */
    size_t scratch_bytes;    /* of one workspace */
    double smallest_mm;      /* the smallest spacing */
} transform;

double sc_thickness_mm(int code)
{
    return SC_THICKNESS_LEAST_MM * exp2((double)code / SC_THICKNESS_STEPS);
}

/* Round a positive number of units; what does not fit becomes UNITS_MAX. */
static uint16_t to_units(double value)
{
    return value < UNITS_MAX ? (uint16_t)(value + 0.5) : UNITS_MAX;
}

/* First pass, along x: set the distance of the voxels of rows [begin, end) to that from the nearest
 * voxel of another label in the row, those beyond its ends included; an sc_range_fn on a transform.
 */
static void rows_pass(void *user, size_t begin, size_t end, int thread)
{
    const transform *t = user;
    const sc_volume *v = t->p->volume;
    const size_t nx = (size_t)v->size[0];

    for (size_t row = begin; row < end; row++) {
        for (size_t x = row * nx, stop; x < (row + 1) * nx; x = stop) {
            const uint32_t id = sc_volume_id(v, x);

            for (stop = x; stop < (row + 1) * nx && sc_volume_id(v, stop) == id; stop++) {
            }
            for (size_t i = x; i < stop; i++) {
                const size_t left = i - x + 1, right = stop - i;

                t->distance[i] =
                    id ? to_units(t->step_units[0] * (double)(left < right ? left : right)) : 0;
            }
        }
    }
}

/* Memory of one thread: COLUMNS lines, copied so that each is contiguous, and the envelope of the
 * present run of equal labels. */
typedef struct workspace {
    int n;                    /* length of a line */
    uint16_t *ids, *distance; /* [COLUMNS][n] */
    float *f;                 /* [n + 2]: f[0] and f[run + 1] stand for the voxels beyond the run */
    float *bound;             /* [n + 3]: where each parabola of the envelope begins */
    int *root;                /* [n + 2]: where the parabolas of the envelope have their vertices */
} workspace;

/* @return the size of a workspace for lines of @p n voxels. */
static size_t workspace_bytes(int n)
{
    return (size_t)n * COLUMNS * 2 * sizeof(uint16_t) + ((size_t)n + 3) * 3 * sizeof(float);
}

/* @return a workspace whose arrays lie in @p block, of workspace_bytes(n), which stays borrowed. */
static workspace lay_out_workspace(char *block, int n)
{
    workspace w = {.n = n, .ids = (uint16_t *)(void *)block};

    w.distance = w.ids + (size_t)n * COLUMNS;
    w.f = (float *)(void *)(w.distance + (size_t)n * COLUMNS);
    w.bound = w.f + n + 3;
    w.root = (int *)(void *)(w.bound + n + 3);
    return w;
}

/* Write the lower envelope of the parabolas w->f[q] + step^2 (x - q)^2, q being 0 to count - 1, to
 * w->root and w->bound, from left to right; the last bound is count.
 * The first and the last f must be zero, so that voxels beyond them cannot matter.
 * @param inverse_step2 one over the squared length of a voxel. */
static void build_envelope(const transform *t, const workspace *w, int count, float inverse_step2)
{
    int top = 0;

    w->root[0] = 0;
    w->bound[0] = -1;
    for (int q = 1; q < count; q++) {
        float cross;

        for (;;) {
            const int r = w->root[top];

            cross = ((w->f[q] - w->f[r]) * inverse_step2 + (float)((q - r) * (q + r))) *
                    t->half_inverse[q - r];
            if (cross > w->bound[top] || top == 0)
                break;
            top--;
        }
        w->root[++top] = q;
        w->bound[top] = cross;
    }
    w->bound[top + 1] = (float)count;
}

/* Transform one line of w->n voxels along t->axis, a run of equal labels at a time: @p distance, in
 * units, holds the result of the passes before, and then also of this one. Uses the envelope of @p
 * w as scratch. */
static void line_pass(const transform *t, const workspace *w, const uint16_t *ids,
                      uint16_t *distance)
{
    const float step2 = (float)(t->step_units[t->axis] * t->step_units[t->axis]);

    for (int begin = 0, end; begin < w->n; begin = end) {
        const uint16_t id = ids[begin];
        int at = 0;

        for (end = begin; end < w->n && ids[end] == id; end++)
            w->f[end - begin + 1] = (float)distance[end] * (float)distance[end];
        if (!id)
            continue;
        w->f[0] = w->f[end - begin + 1] = 0;
        build_envelope(t, w, end - begin + 2, 1 / step2);
        for (int q = 1; q <= end - begin; q++) {
            int away;

            while (w->bound[at + 1] < (float)q)
                at++;
            away = q - w->root[at];
            distance[begin + q - 1] =
                to_units(sqrtf(w->f[w->root[at]] + step2 * (float)(away * away)));
        }
    }
}

/* Lines that lie side by side in a volume: [length] voxels of [columns] lines. */
typedef struct lines {
    size_t base, stride; /* index of the first voxel, and from voxel to voxel of a line */
    size_t columns, length;
} lines;

/* Let the processor fetch the labels and distances of the lines at voxel @p i, if there is one:
 * processors do not foresee steps as long as a plane. */
static inline void fetch_ahead(const transform *t, const lines *l, size_t i)
{
    const sc_volume *v = t->p->volume;
    const size_t at = l->base + i * l->stride;

    if (i >= l->length)
        return;
    __builtin_prefetch(t->distance + at);
    if (v->label_bytes == 1)
        __builtin_prefetch((const uint8_t *)v->ids + at);
    else
        __builtin_prefetch((const uint16_t *)v->ids + at);
}

/* Copy the voxels from @p i on, TOGETHER of them or as many as there are, from rows of voxels that
 * lie side by side to @p to [columns][length], in which each line is contiguous. */
static inline void rows_to_lines(const lines *l, size_t i, uint16_t rows[TOGETHER][COLUMNS],
                                 uint16_t *to)
{
    const size_t count = l->length - i < TOGETHER ? l->length - i : TOGETHER;

    for (size_t x = 0; x < l->columns; x++) {
        for (size_t k = 0; k < count; k++)
            to[x * l->length + i + k] = rows[k][x];
    }
}

/* Copy labels and distances of lines to a workspace. @return whether any label is not that of the
 * background. */
static bool fetch_lines(const transform *t, const lines *l, const workspace *w)
{
    uint16_t ids[TOGETHER][COLUMNS], distance[TOGETHER][COLUMNS];
    uint32_t any = 0;

    for (size_t i = 0; i < l->length; i += TOGETHER) {
        for (size_t k = 0; k < TOGETHER && i + k < l->length; k++) {
            const size_t at = l->base + (i + k) * l->stride;

            fetch_ahead(t, l, i + k + TOGETHER);
            sc_volume_read_ids(t->p->volume, at, l->columns, ids[k]);
            memcpy(distance[k], t->distance + at, l->columns * sizeof distance[0][0]);
            for (size_t x = 0; x < l->columns; x++)
                any |= ids[k][x];
        }
        rows_to_lines(l, i, ids, w->ids);
        rows_to_lines(l, i, distance, w->distance);
    }
    return any != 0;
}

/* Copy the distances of lines back from a workspace. */
static void store_lines(const transform *t, const lines *l, const workspace *w)
{
    for (size_t i = 0; i < l->length; i += TOGETHER) {
        const size_t count = l->length - i < TOGETHER ? l->length - i : TOGETHER;
        uint16_t rows[TOGETHER][COLUMNS];

        for (size_t x = 0; x < l->columns; x++) {
            for (size_t k = 0; k < count; k++)
                rows[k][x] = w->distance[x * l->length + i + k];
        }
        for (size_t k = 0; k < count; k++)
            memcpy(t->distance + l->base + (i + k) * l->stride, rows[k],
                   l->columns * sizeof rows[0][0]);
    }
}

/* Second and third pass, in place in t->distance: lines along t->axis, y or z. An item of
 * [begin, end) is COLUMNS lines that are neighbours in x, or fewer at the end of a row. An
 * sc_range_fn on a transform. */
static void lines_pass(void *user, size_t begin, size_t end, int thread)
{
    const transform *t = user;
    const sc_volume *v = t->p->volume;
    const size_t nx = (size_t)v->size[0], plane = nx * (size_t)v->size[1];
    const size_t blocks = (nx + COLUMNS - 1) / COLUMNS;
    const workspace w =
        lay_out_workspace(t->scratch + (size_t)thread * t->scratch_bytes, v->size[t->axis]);

    for (size_t item = begin; item < end; item++) {
        const size_t across = item / blocks, x0 = item % blocks * COLUMNS;
        const lines l = {.base = across * (t->axis == 1 ? plane : nx) + x0,
                         .stride = t->axis == 1 ? nx : plane,
                         .columns = nx - x0 < COLUMNS ? nx - x0 : COLUMNS,
                         .length = (size_t)w.n};

        if (!fetch_lines(t, &l, &w))
            continue;
        for (size_t x = 0; x < l.columns; x++)
            line_pass(t, &w, w.ids + x * l.length, w.distance + x * l.length);
        store_lines(t, &l, &w);
    }
}

/* Move @p at, a voxel x, y, z, to its deepest neighbour of the same label. @return false, with @p
 * at unchanged, if none is deeper than the voxel. */
static bool climb(const transform *t, int at[3])
{
    const sc_volume *v = t->p->volume;
    const size_t nx = (size_t)v->size[0], plane = nx * (size_t)v->size[1];
    const size_t index = (size_t)at[2] * plane + (size_t)at[1] * nx + (size_t)at[0];
    const uint32_t id = sc_volume_id(v, index);
    uint16_t deepest = t->distance[index];
    int best = -1;

    for (int n = 0; n < 27; n++) {
        const int i = at[0] + n % 3 - 1, j = at[1] + n / 3 % 3 - 1, k = at[2] + n / 9 - 1;
        size_t other;

        if (i < 0 || j < 0 || k < 0 || i >= v->size[0] || j >= v->size[1] || k >= v->size[2])
            continue;
        other = (size_t)k * plane + (size_t)j * nx + (size_t)i;
        if (t->distance[other] > deepest && sc_volume_id(v, other) == id) {
            deepest = t->distance[other];
            best = n;
        }
    }
    if (best < 0)
        return false;
    at[0] += best % 3 - 1;
    at[1] += best / 3 % 3 - 1;
    at[2] += best / 9 - 1;
    return true;
}

/* @return the code nearest to a thickness: the inverse of sc_thickness_mm, clamped to 0 to 255. */
static uint8_t thickness_code(double mm)
{
    const double code = SC_THICKNESS_STEPS * log2(mm / SC_THICKNESS_LEAST_MM) + 0.5;

    return code < 0 ? 0 : code > 255 ? 255 : (uint8_t)code;
}

/* @return the code of the local thickness at voxel @p at, which is not background and is moved to
 * where the steepest ascent ends: twice the depth there, less half a voxel on either side, because
 * depth is measured to the centre of the next tissue's voxel. */
static uint8_t local_code(const transform *t, int at[3])
{
    const sc_volume *v = t->p->volume;
    size_t index;

    while (climb(t, at)) {
    }
    index =
        ((size_t)at[2] * (size_t)v->size[1] + (size_t)at[1]) * (size_t)v->size[0] + (size_t)at[0];
    return thickness_code(t->smallest_mm * (2.0 * t->distance[index] / UNITS_PER_VOXEL - 1));
}

/* Store the local thickness at the boundary voxels of bricks [begin, end); an sc_range_fn on a
 * transform. */
static void local_bricks(void *user, size_t begin, size_t end, int thread)
{
    const transform *t = user;
    const sc_preparation *p = t->p;

    for (size_t brick = begin; brick < end; brick++) {
        uint8_t *thickness = p->thickness + p->near_start[brick];
        int low[3];

        sc_brick_low(p->bricks, brick, low);
        for (uint64_t left = p->near[brick]; left; left &= left - 1, thickness++) {
            const int bit = __builtin_ctzll(left);
            int at[3] = {low[0] + sc_bit_x(bit) - 1, low[1] + sc_bit_y(bit) - 1,
                         low[2] + sc_bit_z(bit) - 1};

            if (sc_id_or_background(p->volume, at[0], at[1], at[2]))
                *thickness = local_code(t, at);
        }
    }
}

/* Fill t->distance, then the local thickness. All other members must be set. */
static void run_passes(const sc_ctx *ctx, transform *t)
{
    const sc_volume *v = t->p->volume;
    const size_t rows = (size_t)v->size[1] * (size_t)v->size[2];
    const size_t blocks = ((size_t)v->size[0] + COLUMNS - 1) / COLUMNS;
    sc_team *team = t->p->team;
    const uint64_t each = SC_WORTH_THICKNESS / 4; /* four loops report progress */

    sc_team_stage_for(ctx, each, team, rows, 64, rows_pass, t);
    t->axis = 1;
    sc_team_stage_for(ctx, each, team, blocks * (size_t)v->size[2], 8, lines_pass, t);
    t->axis = 2;
    sc_team_stage_for(ctx, each, team, blocks * (size_t)v->size[1], 8, lines_pass, t);
    sc_team_stage_for(ctx, each, team, t->p->brick_count, 1024, local_bricks, t);
}

sc_status sc_measure_thickness(const sc_ctx *ctx, sc_preparation *p)
{
    const sc_volume *v = p->volume;
    transform t = {.p = p};
    SC_OWN(sc_free_at) char *scratch = NULL;
    SC_OWN(sc_free_at) float *inverse = NULL;
    void *distance, *block;
    double spacing_mm[3];
    int longest = 0;
    sc_status status;

    for (int i = 0; i < 3; i++) {
        spacing_mm[i] = sc_vec3_length(sc_affine_column(&v->to_ras_mm, i));
        t.smallest_mm = i ? fmin(t.smallest_mm, spacing_mm[i]) : spacing_mm[i];
        longest = v->size[i] > longest ? v->size[i] : longest;
    }
    for (int i = 0; i < 3; i++)
        t.step_units[i] = UNITS_PER_VOXEL * spacing_mm[i] / t.smallest_mm;
    t.scratch_bytes = (workspace_bytes(longest) + 63) / 64 * 64;
    SC_PASS(sc_team_alloc(ctx, p->team, p->near_count, 1, &block));
    p->thickness = block;
    if (!p->boundary_count) { /* background alone, of which a small file can promise a lot */
        sc_stage_add(ctx, SC_WORTH_THICKNESS);
        return SC_OK;
    }
    status = SC_ALLOC(ctx, t.scratch_bytes * (size_t)p->settings.threads, &scratch);
    if (status == SC_OK)
        status = SC_ALLOC(ctx, (size_t)longest + 2, &inverse);
    SC_PASS(sc_team_agree(p->team, status));
    SC_PASS(sc_team_alloc(ctx, p->team, sc_volume_voxels(v), sizeof(uint16_t), &distance));
    t.distance = distance;
    t.scratch = scratch;
    t.half_inverse = inverse;
    for (int i = 0; i < longest + 2; i++)
        t.half_inverse[i] = i ? 0.5f / (float)i : 0;
    run_passes(ctx, &t);
    sc_team_free(p->team, distance);
    return SC_OK;
}
