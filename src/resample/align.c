/* SPDX-License-Identifier: BSD-3-Clause */
/* Slices that were moved against each other, as by breath between them, or because each was drawn
 * by itself. The shift from each slice to the next is the one by which most voxels near borders
 * meet their own label. The shifts added up are the path of the slices, which follows oblique
 * anatomy, too; the place of a slice is how far it lies off the straight line that fits the path
 * around it. Slices that jump to and fro give jumps of alternating sign, anatomy does not: that
 * tells one from the other. */
#include "internal.h"

#include <limits.h>

enum {
    MOST_SHIFT = 6, /* pixels from one slice to the next that are looked for */
    SHIFTS = 2 * MOST_SHIFT + 1,
    COMPARED = 16,      /* labels side by side: SHIFTS, and some whose result is not used */
    FEWEST_PIXELS = 64, /* near borders; slices with fewer say nothing */
    FEWEST_SLICES = 12,
    FEW_PAIRS = 24, /* of slices that tell whether the others are looked at */
    AROUND = 12     /* slices on either side that tell what is usual around one */
};
/* A shift counts as a jump from this many pixels on, and slices jump if at least this share of them
 * do, and if neighbouring shifts are correlated at most so much (independent jumps: -0.5). */
#define LEAST_JUMP 0.75
#define LEAST_JUMPING 0.2
#define MOST_CORRELATED (-0.3)
/* Shifts are alike if the matches differ by at most this share of the pixels. */
#define ALIKE 0.012

/* The stack of slices across an axis. */
typedef struct slices {
    const drawn_view *view;
    int axes[3];        /* of the view: along x and y of the slices, across them */
    uint16_t *scratch;  /* [threads][2][y][x] */
    uint32_t *borders;  /* [threads][pixels] */
    size_t pixels;      /* of a slice */
    size_t step;        /* every so manyeth slice is looked at */
    int threads;        /* that have scratch memory */
    bool together;      /* all ranks of the team look at slices */
    double (*shift)[2]; /* [slices], of the team: from the slice before, in pixels; NAN: unknown */
} slices;

/* Copy the labels of a slice to @p to, [y][x]. */
static void fetch_slice(const slices *s, size_t z, uint16_t *to)
{
    const drawn_view *view = s->view;
    const size_t *along_x = view->offset[s->axes[0]], *along_y = view->offset[s->axes[1]];
    const int nx = view->size[s->axes[0]], ny = view->size[s->axes[1]];
    /* do the voxels of a row follow each other in memory? */
    const bool is_run = along_x[nx - 1] - along_x[0] + 1 == (size_t)nx;

    for (int y = 0; y < ny; y++) {
        const size_t row = view->offset[s->axes[2]][z] + along_y[y];

        if (is_run) {
            sc_volume_read_ids(view->v, row + along_x[0], (size_t)nx, to);
        } else {
            for (int x = 0; x < nx; x++)
                to[x] = (uint16_t)sc_volume_id(view->v, row + along_x[x]);
        }
        to += nx;
    }
}

/* Write the indices of the pixels of a slice beside another label to @p at. Those at most
 * MOST_SHIFT from an edge are left out, so that COMPARED labels around each lie in a slice. @return
 * how many there are. */
static int find_borders(const slices *s, const uint16_t *slice, uint32_t *at)
{
    const int nx = s->view->size[s->axes[0]], ny = s->view->size[s->axes[1]];
    int count = 0;

    for (int y = MOST_SHIFT + 1; y < ny - MOST_SHIFT - 1; y++) {
        const uint16_t *row = slice + (ptrdiff_t)y * nx;

        for (int x = MOST_SHIFT + 1; x < nx - MOST_SHIFT - 1; x++) {
            const uint16_t id = row[x];

            if (id != row[x - 1] || id != row[x + 1] || id != row[x - nx] || id != row[x + nx])
                at[count++] = (uint32_t)(y * nx + x);
        }
    }
    return count;
}

/* Count, for each shift along x, the pixels @p at that have the same label in @p before, shifted by
 * that and by @p step pixels. For each pixel the labels around it are compared side by side, which
 * compilers turn into vector instructions. @param found [SHIFTS], from -MOST_SHIFT on. */
static void count_matches(const uint16_t *slice, const uint16_t *before, const uint32_t *at,
                          int count, ptrdiff_t step, int found[SHIFTS])
{
    memset(found, 0, SHIFTS * sizeof *found);
    for (int begin = 0; begin < count; begin += UINT16_MAX) {
        const int end = count - begin < UINT16_MAX ? count : begin + UINT16_MAX;
        uint16_t same[COMPARED] = {0}; /* of at most UINT16_MAX pixels */

        for (int i = begin; i < end; i++) {
            const uint16_t *around = before + (ptrdiff_t)at[i] + step - MOST_SHIFT;
            const uint16_t id = slice[at[i]];

            for (int x = 0; x < COMPARED; x++)
                same[x] = (uint16_t)(same[x] + (around[x] == id));
        }
        for (int x = 0; x < SHIFTS; x++)
            found[x] += same[x];
    }
}

/* @return where the parabola through three values has its top, from -0.5 to 0.5. */
static double top_of(int before, int middle, int after)
{
    const int bend = 2 * middle - before - after;

    return bend > 0 ? fmin(fmax(0.5 * (after - before) / bend, -0.5), 0.5) : 0;
}

/* Find the middle of the shifts that are about as good as the best one, to @p shift. A contour that
 * has grown or shrunk by some pixels lies within the other at many shifts; the one with the most
 * matches among them is an accident. @param count the pixels that were compared.
 * @return false if the best shift stands alone. */
static bool find_middle(int found[SHIFTS][SHIFTS], int best, int count, double shift[2])
{
    const int least = best - (int)(ALIKE * count);
    double sum[2] = {0, 0};
    int alike = 0;

    for (int y = 0; y < SHIFTS; y++) {
        for (int x = 0; x < SHIFTS; x++) {
            if (found[y][x] < least)
                continue;
            sum[0] += x - MOST_SHIFT;
            sum[1] += y - MOST_SHIFT;
            alike++;
        }
    }
    shift[0] = sum[0] / alike;
    shift[1] = sum[1] / alike;
    return alike > 1;
}

/* Find the shift from the slice @p before at which most pixels beside another label match; NAN if
 * it is not less than MOST_SHIFT - 1 along both axes.
 * @param at room for the indices of a slice's pixels. */
static void find_shift(const slices *s, const uint16_t *slice, const uint16_t *before, uint32_t *at,
                       double shift[2])
{
    const int nx = s->view->size[s->axes[0]], count = find_borders(s, slice, at);
    int found[SHIFTS][SHIFTS], best[2] = {MOST_SHIFT, MOST_SHIFT};

    shift[0] = shift[1] = NAN;
    if (count < FEWEST_PIXELS)
        return;
    for (int y = 0; y < SHIFTS; y++)
        count_matches(slice, before, at, count, (ptrdiff_t)(y - MOST_SHIFT) * nx, found[y]);
    for (int y = 1; y < SHIFTS - 1; y++) {
        for (int x = 1; x < SHIFTS - 1; x++) {
            if (found[y][x] > found[best[1]][best[0]]) {
                best[0] = x;
                best[1] = y;
            }
        }
    }
    for (int i = 0; i < 2; i++) {
        if (best[i] == 1 || best[i] == SHIFTS - 2)
            return; /* the best one may lie farther off */
    }
    if (find_middle(found, found[best[1]][best[0]], count, shift))
        return;
    shift[0] =
        best[0] - MOST_SHIFT +
        top_of(found[best[1]][best[0] - 1], found[best[1]][best[0]], found[best[1]][best[0] + 1]);
    shift[1] =
        best[1] - MOST_SHIFT +
        top_of(found[best[1] - 1][best[0]], found[best[1]][best[0]], found[best[1] + 1][best[0]]);
}

/* Find the shifts of the slices [begin, end), or of two in each step, from those before them; an
 * sc_range_fn on slices. */
static void find_shifts(void *user, size_t begin, size_t end, int thread)
{
    const slices *s = user;
    uint16_t *slice = s->scratch + (size_t)thread * 2 * s->pixels, *before = slice + s->pixels;
    size_t fetched = 0; /* which slice stands in slice; 0: none */

    for (size_t n = begin; n < end; n++) {
        const size_t z = s->step > 1 ? n / 2 * s->step + n % 2 : n;
        uint16_t *last = slice;

        s->shift[z][0] = s->shift[z][1] = NAN;
        if (z == 0)
            continue;
        slice = before;
        before = last;
        if (fetched != z - 1 || fetched == 0)
            fetch_slice(s, z - 1, before);
        fetch_slice(s, z, slice);
        fetched = z;
        find_shift(s, slice, before, s->borders + (size_t)thread * s->pixels, s->shift[z]);
    }
}

/* Write the places of the slices along @p i, from what is usual around each, to @p places, [count].
 * What is usual is a straight line through the places around. @param path scratch, [count]. */
static void find_places(const slices *s, int count, int i, double *path, double *places)
{
    for (int z = 0; z < count; z++) {
        const double shift = isnan(s->shift[z][i]) ? 0 : s->shift[z][i];

        path[z] = z > 0 ? path[z - 1] - shift : 0;
    }
    for (int z = 0; z < count; z++) {
        const int begin = z < AROUND ? 0 : z - AROUND,
                  end = z + AROUND < count ? z + AROUND : count - 1, n = end - begin + 1;
        const double middle = (begin + end) / 2.0;
        double sum = 0, slope = 0;

        for (int at = begin; at <= end; at++) {
            sum += path[at];
            slope += (at - middle) * path[at];
        }
        slope *= 12 / ((double)n * ((double)n * n - 1));
        places[z] = path[z] - sum / n - slope * (z - middle);
    }
}

/* Do slices jump to and fro? @param places [2][count] along both axes. */
static bool do_jump(const slices *s, int count, const double *places)
{
    double products = 0, squares = 0;
    int known = 0, jumping = 0;

    for (int z = 1; z < count; z++) {
        double jump[2], next[2];

        for (int i = 0; i < 2; i++) {
            const double *place = places + i * count + z;

            jump[i] = place[0] - place[-1];
            next[i] = z + 1 < count ? place[1] - place[0] : 0;
            products += jump[i] * next[i];
            squares += jump[i] * jump[i];
        }
        known += !isnan(s->shift[z][0]);
        jumping += fabs(jump[0]) >= LEAST_JUMP || fabs(jump[1]) >= LEAST_JUMP;
    }
    return known >= FEWEST_SLICES && jumping >= LEAST_JUMPING * known &&
           products <= MOST_CORRELATED * squares;
}

/* Do @p count items of find_shifts: by all ranks of the team; or by the first alone, with few
 * threads, if the slices of all would take too much memory. Collective in the team. */
static void find_all_shifts(sc_team *team, slices *s, size_t count, size_t chunk)
{
    if (s->together) {
        sc_team_for(team, count, chunk, find_shifts, s);
        return;
    }
    if (sc_team_is_first(team))
        sc_parallel_for(s->threads, count, chunk, find_shifts, s);
    sc_team_for(team, 0, 1, find_shifts, s); /* the others wait for it */
}

/* Look at pairs of slices here and there. @return whether they are moved to and fro so much that
 * all are worth a look. */
static bool may_jump(sc_team *team, slices *s, int count)
{
    double products = 0;
    int known = 0, moved = 0, pairs;

    s->step = (size_t)count / FEW_PAIRS;
    if (s->step < 4) {
        s->step = 1;
        return true;
    }
    pairs = (count - 2) / (int)s->step + 1;
    find_all_shifts(team, s, 2 * (size_t)pairs, 2);
    for (int n = 1; n < pairs; n++) {
        const double *a = s->shift[(size_t)n * s->step], *b = a + 2;

        if (isnan(a[0]) || isnan(b[0]))
            continue;
        known++;
        moved += fmax(fabs(a[0]), fabs(a[1])) >= LEAST_JUMP;
        products += a[0] * b[0] + a[1] * b[1];
    }
    s->step = 1;
    return products < 0 && moved >= LEAST_JUMPING / 2 * known;
}

/* @return a place in whole pixels. */
static int place_of(double exact)
{
    return (int)lround(fmin(fmax(exact, -MOST_SHIFT), MOST_SHIFT));
}

/* @return how many of @p threads to use, so that what they need for their slices is not more than
 * what the volume takes; at least one. */
static int least_threads(const drawn_view *view, size_t pixels, int threads)
{
    const double bytes = (double)sc_volume_voxels(view->v) * view->v->label_bytes,
                 each = (double)pixels * (2 * sizeof(uint16_t) + sizeof(uint32_t));

    return (int)fmax(1, fmin(threads, bytes / each));
}

/* Set threads and together of @p s. Collective in the team. */
static void share_work(sc_team *team, slices *s)
{
    const int threads = sc_team_threads(team), ranks = sc_team_ranks(team);
    /* That all ranks have as many threads as this one is near enough. */
    const bool fits = least_threads(s->view, s->pixels, threads * ranks) == threads * ranks;

    s->together = sc_team_agree(team, fits ? SC_OK : SC_ERR_MEMORY) == SC_OK;
    s->threads = s->together ? threads : least_threads(s->view, s->pixels, threads);
}

/* Allocate scratch and borders of @p s, and room for @p count * 3 numbers at *exact. Returns
 * SC_ERR_MEMORY; the caller frees in any case. */
static sc_status allocate(const sc_ctx *ctx, slices *s, int count, double **exact)
{
    SC_PASS(SC_ALLOC(ctx, (size_t)s->threads * 2 * s->pixels, &s->scratch));
    SC_PASS(SC_ALLOC(ctx, (size_t)s->threads * s->pixels, &s->borders));
    return SC_ALLOC(ctx, (size_t)count * 3, exact);
}

sc_status sc_resample_find_moved(const sc_ctx *ctx, sc_team *team, const drawn_view *view, int axis,
                                 int *places, int *moved)
{
    const int count = view->size[axis];
    slices s = {.view = view, .axes = {axis == 0, axis == 2 ? 1 : 2, axis}};
    double *exact = NULL;
    void *block;
    bool jumps;
    sc_status status;

    *moved = 0;
    memset(places, 0, (size_t)count * 2 * sizeof *places);
    s.step = 1;
    s.pixels = (size_t)view->size[s.axes[0]] * (size_t)view->size[s.axes[1]];
    if (count < FEWEST_SLICES || s.pixels > INT_MAX)
        return SC_OK;
    share_work(team, &s);
    SC_TRY(sc_team_agree(team, allocate(ctx, &s, count, &exact)));
    SC_TRY(sc_team_alloc(ctx, team, (size_t)count, sizeof *s.shift, &block));
    s.shift = block;
    jumps = may_jump(team, &s, count);
    SC_TRY(sc_team_agree(team, SC_OK)); /* all have read the shifts, which are found anew */
    if (!jumps)
        goto out;
    find_all_shifts(team, &s, (size_t)count, 4);
    for (int i = 0; i < 2; i++)
        find_places(&s, count, i, exact + 2 * count, exact + i * count);
    if (do_jump(&s, count, exact)) {
        for (int z = 0; z < count; z++) {
            places[2 * z] = place_of(exact[z]);
            places[2 * z + 1] = place_of(exact[count + z]);
            *moved += places[2 * z] || places[2 * z + 1];
        }
    }
out:
    sc_free(s.scratch);
    sc_free(s.borders);
    sc_team_free(team, s.shift);
    sc_free(exact);
    return status;
}

/* What moving slices back needs. */
typedef struct moving {
    const slices *s;
    const int *places;
    const size_t *strides; /* of the volume, by axis, in voxels */
    sc_volume *v;
} moving;

/* @return @p at, or the nearest of [0, size). */
static inline int within(int at, int size)
{
    return at < 0 ? 0 : at >= size ? size - 1 : at;
}

/* Move the slices [begin, end) back; an sc_range_fn on moving. */
static void move_slices(void *user, size_t begin, size_t end, int thread)
{
    const moving *m = user;
    const slices *s = m->s;
    const int nx = s->view->size[s->axes[0]], ny = s->view->size[s->axes[1]];
    uint16_t *slice = s->scratch + (size_t)thread * s->pixels;

    for (size_t z = begin; z < end; z++) {
        const int dx = m->places[2 * z], dy = m->places[2 * z + 1];

        if (!dx && !dy)
            continue;
        fetch_slice(s, z, slice);
        for (int y = 0; y < ny; y++) {
            const uint16_t *row = slice + (ptrdiff_t)within(y + dy, ny) * nx;
            const size_t to = z * m->strides[s->axes[2]] + (size_t)y * m->strides[s->axes[1]];

            for (int x = 0; x < nx; x++) {
                const size_t at = to + (size_t)x * m->strides[s->axes[0]];

                if (m->v->label_bytes == 1)
                    ((uint8_t *)m->v->ids)[at] = (uint8_t)row[within(x + dx, nx)];
                else
                    ((uint16_t *)m->v->ids)[at] = row[within(x + dx, nx)];
            }
        }
    }
}

sc_status sc_resample_move_slices(const sc_ctx *ctx, sc_volume *v, int axis, int threads)
{
    const sc_drawn_grid whole = {.copies = {1, 1, 1}};
    const size_t strides[3] = {1, (size_t)v->size[0], (size_t)v->size[0] * (size_t)v->size[1]};
    drawn_view view = {0};
    slices s = {.view = &view, .axes = {axis == 0, axis == 2 ? 1 : 2, axis}};
    moving m = {&s, NULL, strides, v};
    SC_OWN(sc_team_close_at) sc_team *team = NULL;
    int moved;
    void *block;
    sc_status status;

    SC_TRY(sc_team_open(ctx, NULL, threads, NULL, &team));
    SC_TRY(sc_drawn_view_make(ctx, v, &whole, &view));
    SC_TRY(sc_alloc(ctx, (size_t)v->size[axis], 2 * sizeof *m.places, &block));
    m.places = block;
    SC_TRY(sc_resample_find_moved(ctx, team, &view, axis, block, &moved));
    s.pixels = (size_t)view.size[s.axes[0]] * (size_t)view.size[s.axes[1]];
    threads = least_threads(&view, s.pixels, threads);
    SC_TRY(sc_alloc(ctx, (size_t)threads * s.pixels, sizeof *s.scratch, &block));
    s.scratch = block;
    sc_parallel_for(threads, (size_t)v->size[axis], 1, move_slices, &m);
out:
    sc_free((void *)(uintptr_t)m.places);
    sc_free(s.scratch);
    sc_drawn_view_clear(&view);
    return status;
}
