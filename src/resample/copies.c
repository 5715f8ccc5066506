/* SPDX-License-Identifier: BSD-3-Clause */
/* Finds voxels that were copied from coarser ones, and removes the copies. A plane across an axis
 * is an edge if any of its voxels differs from that of the plane before it. In a volume that was
 * copied up, edges lie only where coarse voxels begin. Nothing is estimated: every edge must fit.
 */
#include "internal.h"

enum {
    FEWEST_EDGES = 8,    /* fewer say nothing: a few boxes have edges on many a regular grid */
    TRIALS_PER_LINE = 8, /* steps that are tried differ by a plane over so many regular planes times
                            their number: the last one is then moved by an eighth of a plane */
    REFINEMENTS = 16,    /* steps that are tried on either side of one that nearly fits: where all
                            planes are edges, a step must be right to a ten-thousandth */
    FIRST_LOOK = 8,      /* edges after which it is first asked whether a step can still fit */
    BUCKETS = 16 /* parts of a step among which residues are sorted: arcs that are looked for
                    leave a gap of at least a quarter of FEWEST_COPIES, so of every step */
};
/* The share of the regular planes between the first and the last edge that must be edges. */
#define LEAST_FILLED 0.5
/* The finest drawn voxels that are looked for, in voxels: below it, planes in turn single and
 * double are hard to tell from chance. */
#define FEWEST_COPIES 1.5
/* How much the edges may lie off regular planes, together: whole planes are less than 1 off, and
 * the programs that copy round in several ways. */
#define ROUNDING 0.999

/* The edges along each axis, as each thread has met them: flag n says that plane n differs from
 * plane n - 1. */
typedef struct edge_work {
    const sc_volume *v;
    uint8_t *of_threads; /* [threads][size x + size y + size z] */
} edge_work;

/* @return the place of the flags along @p axis among those of a thread. */
static size_t flags_at(const sc_volume *v, int axis)
{
    size_t at = 0;

    for (int i = 0; i < axis; i++)
        at += (size_t)v->size[i];
    return at;
}

/* Mark in @p edges, [count], where a row of @p count ids of @p bytes bytes differs from itself one
 * voxel before. */
static void mark_row(const void *row, int bytes, int count, uint8_t *edges)
{
    if (bytes == 1) {
        const uint8_t *ids = row;

        for (int x = 1; x < count; x++)
            edges[x] |= ids[x] ^ ids[x - 1];
    } else {
        const uint16_t *ids = row;

        for (int x = 1; x < count; x++)
            edges[x] |= ids[x] != ids[x - 1];
    }
}

/* Mark the edges that show in the slices [begin, end); an sc_range_fn on edge_work. Rows and slices
 * are compared until a difference is found. */
static void mark_slices(void *user, size_t begin, size_t end, int thread)
{
    const edge_work *w = user;
    const sc_volume *v = w->v;
    const size_t row = (size_t)v->size[0] * (size_t)v->label_bytes,
                 slice = row * (size_t)v->size[1];
    uint8_t *flags = w->of_threads + (size_t)thread * flags_at(v, 3);
    uint8_t *along_y = flags + flags_at(v, 1), *along_z = flags + flags_at(v, 2);

    for (size_t z = begin; z < end; z++) {
        const uint8_t *ids = (const uint8_t *)v->ids + z * slice;

        along_z[z] = z > 0 && memcmp(ids, ids - slice, slice) != 0;
        for (int y = 0; y < v->size[1]; y++) {
            mark_row(ids + (size_t)y * row, v->label_bytes, v->size[0], flags);
            if (y > 0 && !along_y[y])
                along_y[y] = memcmp(ids + (size_t)y * row, ids + (size_t)(y - 1) * row, row) != 0;
        }
    }
}

/* Where residues lie on the circle of circumference `step`: the least and the greatest of each of
 * its parts. Empty parts have a negative greatest one. */
typedef struct circle {
    double step, least[BUCKETS], greatest[BUCKETS];
} circle;

/* @return the length of the arc on which all residues lie: what the widest gap between them leaves.
 * Right if that gap is wider than a part of the circle, else too long, and longer than all parts
 * but one. @param begin receives where the arc begins. */
static double arc_of(const circle *c, double *begin)
{
    double first = -1, last = 0, widest = 0, widest_end = 0;

    for (int b = 0; b < BUCKETS; b++) {
        if (c->greatest[b] < 0)
            continue;
        if (first < 0) {
            first = c->least[b];
        } else if (c->least[b] - last > widest) {
            widest = c->least[b] - last;
            widest_end = c->least[b];
        }
        last = c->greatest[b];
    }
    if (first + c->step - last >= widest) {
        widest = first + c->step - last;
        widest_end = first;
    }
    *begin = widest_end;
    return c->step - widest;
}

/* The arc on which the residues of all edges lie. More edges never make it shorter, so it is
 * measured after 8 edges, 16, 32, and so on, until it is too long. Only about one in k of the steps
 * that are tried still fits k edges, wherever these lie (the large sieve inequality), so that all
 * trials together look at O(n log n) edges.
 * @param at [count], at least 1. @param most arcs from this length on do not matter; at most 15 /
 * 16 of the step. @param begin receives where the arc begins.
 * @return its length, or HUGE_VAL if it is @p most or longer. */
static double arc_of_edges(const int *at, int count, double step, double most, double *begin)
{
    circle c = {.step = step};
    double arc = 0;

    for (int b = 0; b < BUCKETS; b++) {
        c.least[b] = step;
        c.greatest[b] = -1;
    }
    for (int i = 0, next = FIRST_LOOK; i < count; i++) {
        const double residue = fmod(at[i], step);
        const int part = (int)(residue / step * BUCKETS), b = part < BUCKETS ? part : BUCKETS - 1;

        c.least[b] = residue < c.least[b] ? residue : c.least[b];
        c.greatest[b] = residue > c.greatest[b] ? residue : c.greatest[b];
        if (i + 1 != next && i + 1 != count)
            continue;
        next *= 2;
        arc = arc_of(&c, begin);
        if (arc >= most)
            return HUGE_VAL;
    }
    return arc;
}

/* Planes @p step apart, one of which lies at @p phase, and how far edges lie off them, together. */
typedef struct planes {
    double step, phase, spread;
} planes;

/* @return the planes @p step apart that are nearest to the edges. The spread is HUGE_VAL if it is
 * @p most or more, or if too few of the planes are edges. @param at [count] rising. */
static planes planes_of(const int *at, int count, double step, double most)
{
    double begin, arc;

    if (step < FEWEST_COPIES || count < LEAST_FILLED * ((at[count - 1] - at[0]) / step + 1))
        return (planes){.step = step, .spread = HUGE_VAL};
    arc = arc_of_edges(at, count, step, most, &begin);
    return (planes){step, begin + arc / 2, arc};
}

/* @return the best of the planes whose step differs from that of @p p by at most @p range / 2; @p p
 * itself if the spread of none is less than @p most. */
static planes refine(const int *at, int count, planes p, double range, double most)
{
    planes best = p;

    for (int n = -REFINEMENTS; n <= REFINEMENTS; n++) {
        const double step = p.step + n * range / (2 * REFINEMENTS);
        const planes tried = planes_of(at, count, step, fmin(best.spread, most));

        if (tried.spread < best.spread)
            best = tried;
    }
    return best;
}

/* @return whether all edges lie on the planes, each rounded to a whole one. */
static bool fits(const planes *p)
{
    return p->spread < (p->step > floor(p->step) ? ROUNDING : 1e-6);
}

/* Find the planes on which all edges along an axis lie. The least distance of two edges is that of
 * the planes, rounded. Of several steps that fit, the one with the least spread is taken.
 * @param at [count] edges, rising. @param grid gets copies and phase of the axis, which are left
 * alone if there are none. */
static void find_planes(const int *at, int count, int axis, sc_drawn_grid *grid)
{
    const double nearly = ROUNDING + 1.0 / TRIALS_PER_LINE;
    planes best = {.spread = HUGE_VAL};
    int least, trials;

    if (count < FEWEST_EDGES)
        return;
    least = at[1] - at[0];
    for (int i = 2; i < count; i++)
        least = at[i] - at[i - 1] < least ? at[i] - at[i - 1] : least;
    trials = TRIALS_PER_LINE * ((at[count - 1] - at[0]) / least + 1);
    for (int n = 0; n <= trials && best.spread > 0; n++) { /* the whole number first */
        const double range = 1.0 / (trials + 1);
        planes tried = planes_of(at, count, n == 0 ? least : least + 1 - n * range, nearly);

        if (n > 0 && tried.spread < nearly)
            tried = refine(at, count, tried, range, fmin(best.spread, ROUNDING));
        if (fits(&tried) && tried.spread < best.spread)
            best = tried;
    }
    if (best.spread == HUGE_VAL)
        return;
    grid->copies[axis] = best.step;
    grid->phase[axis] = fmod(best.phase, best.step);
    if (grid->phase[axis] > 1e-9)
        grid->phase[axis] -= best.step;
}

/* Set those of @p flags [count] that are set in any of @p parts [part_count][count]. */
static void add_flags(uint8_t *flags, const uint8_t *parts, int part_count, size_t count)
{
    for (size_t i = 0; i < (size_t)part_count * count; i++)
        flags[i % count] |= parts[i];
}

sc_status sc_resample_find_copies(const sc_ctx *ctx, sc_team *team, const sc_volume *v,
                                  sc_drawn_grid *grid)
{
    const size_t flags = flags_at(v, 3);
    const int threads = sc_team_threads(team);
    SC_OWN(sc_free_at) uint8_t *of_threads = NULL;
    SC_OWN(sc_free_at) int *at = NULL;
    edge_work w = {v, NULL};
    void *all;
    sc_status status = SC_ZALLOC(ctx, (size_t)threads * flags, &of_threads);

    w.of_threads = of_threads;
    if (status == SC_OK)
        status = SC_ALLOC(ctx, flags, &at);
    SC_PASS(sc_team_agree(team, status));
    sc_team_for(team, (size_t)v->size[2], 1, mark_slices, &w);
    add_flags(w.of_threads, w.of_threads + flags, threads - 1, flags);
    SC_PASS(sc_team_collect(ctx, team, w.of_threads, flags, &all));
    add_flags(w.of_threads, all, sc_team_ranks(team), flags);
    for (int axis = 0; axis < 3; axis++) {
        int count = 0;

        for (int n = 0; n < v->size[axis]; n++) {
            if (w.of_threads[flags_at(v, axis) + (size_t)n])
                at[count++] = n;
        }
        find_planes(at, count, axis, grid);
    }
    sc_team_free(team, all);
    return SC_OK;
}

/* @return the number of the first drawn voxel that has a plane of its own, which ends behind the
 * outer face of the volume: 0, or 1 where the first one is cut off. */
static int first_drawn(double copies, double phase)
{
    return floor(phase + copies + 0.5) < 1;
}

int sc_resample_drawn_within(int size, double copies, double phase)
{
    if (copies <= 1)
        return size;
    return (int)ceil((size - 0.5 - phase) / copies) - first_drawn(copies, phase);
}

int sc_resample_plane_of(int size, double copies, double phase, int n)
{
    const double middle = phase + (n + first_drawn(copies, phase) + 0.5) * copies;

    return copies <= 1 ? n : (int)fmin(fmax(floor(middle), 0), size - 1);
}

sc_status sc_resample_remove_copies(const sc_ctx *ctx, sc_volume *v, int axis, double copies,
                                    double phase)
{
    const int first = first_drawn(copies, phase),
              count = sc_resample_drawn_within(v->size[axis], copies, phase);
    const size_t voxels = sc_volume_voxels(v) / (size_t)v->size[axis] * (size_t)count;
    int size[3] = {v->size[0], v->size[1], v->size[2]};
    size_t stride = (size_t)v->label_bytes, group;
    void *block;
    uint8_t *to;

    SC_PASS(sc_alloc(ctx, voxels, (size_t)v->label_bytes, &block));
    to = block;
    for (int i = 0; i < axis; i++)
        stride *= (size_t)size[i];
    group = stride * (size_t)size[axis];
    for (size_t begin = 0; begin < sc_volume_voxels(v) * (size_t)v->label_bytes; begin += group) {
        for (int n = 0; n < count; n++, to += stride) {
            const int plane = sc_resample_plane_of(size[axis], copies, phase, n);

            memcpy(to, (const uint8_t *)v->ids + begin + (size_t)plane * stride, stride);
        }
    }
    sc_resample_set_planes(v, block, axis, count, phase + (first + 0.5) * copies - 0.5, copies);
    return SC_OK;
}
