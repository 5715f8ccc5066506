/* SPDX-License-Identifier: BSD-3-Clause */
/* Points and lines one voxel thick, as of landmarks, centre lines and thin vessels, and what is
 * left of them in pictures. */
#include "rulers.h"

#include <stdlib.h>
#include <string.h>

enum {
    EDGE = 60,    /* voxels along an edge of the volume */
    FINE = 4,     /* samples along a voxel */
    STEPS = 8000, /* along a line, to find its voxels */
    LINE = 1,     /* its label */
    AROUND = 2,   /* the label of tissue around a part of it */
    POINTS = 4    /* along each axis */
};

/* A line: its voxels share faces (6-connected), or faces, edges and corners (26). */
typedef struct line_kind {
    const char *name;
    sc_vec3 (*at)(double u); /* @p u from 0 to 1, in voxels; NULL: points */
    bool by_faces;
    bool in_tissue; /* half of the volume is other tissue */
} line_kind;

/* A line along an axis. */
static sc_vec3 straight(double u)
{
    return (sc_vec3){8 + 44 * u, 30, 30};
}

/* A line that rises by a third of its way. */
static sc_vec3 slanting(double u)
{
    return (sc_vec3){8 + 44 * u, 22 + 44 / 3.0 * u, 30};
}

/* The diagonal of a face of the volume. */
static sc_vec3 face_diagonal(double u)
{
    return (sc_vec3){8 + 44 * u, 8 + 44 * u, 30};
}

/* The diagonal of the volume. */
static sc_vec3 space_diagonal(double u)
{
    return (sc_vec3){8 + 44 * u, 8 + 44 * u, 8 + 44 * u};
}

/* Two turns of a helix of radius 14. */
static sc_vec3 helix(double u)
{
    return (sc_vec3){30.2 + 14 * cos(4 * M_PI * u), 29.7 + 14 * sin(4 * M_PI * u), 8 + 44 * u};
}

static const line_kind kinds[] = {
    {.name = "points"},
    {.name = "straight", .at = straight},
    {.name = "slanting, 6-connected", .at = slanting, .by_faces = true},
    {.name = "slanting, 26-connected", .at = slanting},
    {.name = "diagonal of a face, 6-connected", .at = face_diagonal, .by_faces = true},
    {.name = "diagonal of a face, 26-connected", .at = face_diagonal},
    {.name = "diagonal in space, 6-connected", .at = space_diagonal, .by_faces = true},
    {.name = "diagonal in space, 26-connected", .at = space_diagonal},
    {.name = "helix, 6-connected", .at = helix, .by_faces = true},
    {.name = "helix, 26-connected", .at = helix},
    {.name = "helix half in tissue, 6-connected", .at = helix, .by_faces = true, .in_tissue = true},
    {.name = "helix half in tissue, 26-connected", .at = helix, .in_tissue = true}};

size_t line_count(void)
{
    return SC_COUNT_OF(kinds);
}

/* The voxels of a line, one after the other. */
typedef struct path {
    int (*at)[3]; /* [count] */
    size_t count;
    double length; /* of the true line with half a voxel at either end, in voxels */
} path;

/* Do the voxels share a corner at least? */
static bool touch(const int a[3], const int b[3])
{
    return abs(a[0] - b[0]) <= 1 && abs(a[1] - b[1]) <= 1 && abs(a[2] - b[2]) <= 1;
}

/* Append a voxel, unless it is the last one already; with @p thin instead of that one, if it
 * touches the one before. */
static void append(path *p, const int at[3], bool thin)
{
    if (p->count && !memcmp(p->at[p->count - 1], at, sizeof *p->at))
        return;
    if (thin && p->count > 1 && touch(p->at[p->count - 2], at))
        p->count--;
    memcpy(p->at[p->count++], at, sizeof *p->at);
}

/* Find the voxels of a line: those that its points fall into, and with by_faces as many between
 * them that each shares a face with the next. @p out has room for 4 STEPS. */
static void trace(const line_kind *kind, path *out)
{
    sc_vec3 before = kind->at(0);

    out->length = 1;
    for (int n = 0; n <= STEPS; n++) {
        const sc_vec3 here = kind->at((double)n / STEPS);
        const int at[3] = {(int)floor(here.x + 0.5), (int)floor(here.y + 0.5),
                           (int)floor(here.z + 0.5)};

        for (int i = 0; i < 3 && kind->by_faces && out->count; i++) {
            int between[3];

            memcpy(between, out->at[out->count - 1], sizeof between);
            between[i] = at[i];
            append(out, between, false);
        }
        append(out, at, !kind->by_faces);
        out->length += sc_vec3_length(sc_vec3_sub(here, before));
        before = here;
    }
}

/* Single voxels, far from each other, as a path. */
static void scatter(path *out)
{
    for (int n = 0; n < POINTS * POINTS * POINTS; n++) {
        const int at[3] = {10 + 12 * (n % POINTS), 10 + 12 * (n / POINTS % POINTS),
                           10 + 12 * (n / POINTS / POINTS)};

        append(out, at, false);
    }
}

/* Make the volume of a path. Caller owns @p out: sc_volume_clear. @return SC_ERR_MEMORY. */
static sc_status make_volume(const sc_ctx *ctx, const line_kind *kind, const path *p,
                             sc_volume *out)
{
    const int labels = kind->in_tissue ? 3 : 2;
    SC_OWN(sc_volume_clear)
    sc_volume v = {.label_bytes = 1, .label_count = labels, .oriented = true};
    uint8_t *ids;

    for (int i = 0; i < 3; i++) {
        v.size[i] = EDGE;
        v.to_ras_mm.m[i][i] = 1;
    }
    SC_PASS(sc_zalloc(ctx, sc_volume_voxels(&v), 1, &v.ids));
    SC_PASS(SC_ZALLOC(ctx, (size_t)labels, &v.labels));
    for (int id = 1; id < labels; id++) {
        v.labels[id] = (sc_label){.value = id, .rgb = {200, (uint8_t)(60 * id), 60}, .opacity = -1};
        strcpy(v.labels[id].name, id == LINE ? "line" : "tissue");
    }
    ids = v.ids;
    if (kind->in_tissue) {
        for (size_t n = 0; n < sc_volume_voxels(&v); n++)
            ids[n] = n % EDGE >= EDGE / 2 ? AROUND : 0;
    }
    for (size_t n = 0; n < p->count; n++)
        ids[(p->at[n][2] * EDGE + p->at[n][1]) * EDGE + p->at[n][0]] = LINE;
    SC_HAND_OVER(v, out);
    return SC_OK;
}

/* Count the connected parts of the samples that are set, of which there are @p edge along each axis
 * (those on the outside are not set). They are cleared. @p waiting: room for as many indices. */
static int count_pieces(uint8_t *samples, size_t edge, size_t *waiting)
{
    const size_t steps[3] = {1, edge, edge * edge};
    int pieces = 0;

    for (size_t n = 0; n < edge * edge * edge; n++) {
        size_t count = 0;

        if (!samples[n])
            continue;
        pieces++;
        samples[n] = 0;
        waiting[count++] = n;
        while (count) {
            const size_t at = waiting[--count];

            for (int k = 0; k < 6; k++) {
                const size_t next = k % 2 ? at + steps[k / 2] : at - steps[k / 2];

                if (!samples[next])
                    continue;
                samples[next] = 0;
                waiting[count++] = next;
            }
        }
    }
    return pieces;
}

/* Set pieces and the drawn volume, in voxels, of the line. @return SC_ERR_MEMORY. */
static sc_status measure_pieces(const sc_ctx *ctx, const stage *st, survivors *out, double *volume)
{
    const size_t edge = FINE * (EDGE - 1) + 1, count = edge * edge * edge;
    SC_OWN(sc_free_at) void *samples = NULL, *waiting = NULL;
    uint8_t *set;

    SC_PASS(sc_zalloc(ctx, count, 1, &samples));
    SC_PASS(sc_alloc(ctx, count, sizeof(size_t), &waiting));
    set = samples;
    *volume = 0;
    for (size_t n = 0; n < count; n++) {
        const size_t at[3] = {n % edge, n / edge % edge, n / edge / edge};
        const sc_vec3 mm = {(double)at[0] / FINE, (double)at[1] / FINE, (double)at[2] / FINE};
        bool outermost = false;

        for (int i = 0; i < 3; i++)
            outermost = outermost || at[i] == 0 || at[i] + 1 == edge;
        set[n] = !outermost && owner_at(st, mm) == LINE;
        *volume += set[n];
    }
    *volume /= FINE * FINE * FINE;
    out->pieces = count_pieces(set, edge, waiting);
    return SC_OK;
}

sc_status measure_lines(const sc_ctx *ctx, size_t n, const drawing *how, survivors *out)
{
    const line_kind *kind = &kinds[n];
    SC_OWN(sc_volume_clear) sc_volume volume = {0};
    SC_OWN(stage_close) stage st = {0};
    path p = {0};
    double kept = 0, links = 0, drawn;
    SC_OWN(sc_free_at) void *block = NULL;

    SC_PASS(sc_alloc(ctx, 4 * STEPS + 4, sizeof *p.at, &block));
    p.at = block;
    if (kind->at)
        trace(kind, &p);
    else
        scatter(&p);
    SC_PASS(make_volume(ctx, kind, &p, &volume));
    SC_PASS(stage_open(ctx, &volume, how, 1, 0.1, &st));
    for (size_t i = 0; i < p.count; i++) {
        const sc_vec3 here = {p.at[i][0], p.at[i][1], p.at[i][2]};

        kept += owner_at(&st, here) == LINE;
        if (i && kind->at) {
            const sc_vec3 before = {p.at[i - 1][0], p.at[i - 1][1], p.at[i - 1][2]};

            links += owner_at(&st, sc_vec3_scale(sc_vec3_add(before, here), 0.5)) == LINE;
        }
    }
    *out = (survivors){.name = kind->name,
                       .voxels = kept / (double)p.count,
                       .links = kind->at ? links / (double)(p.count - 1) : NAN,
                       .true_pieces = kind->at ? 1 : (int)p.count};
    SC_PASS(measure_pieces(ctx, &st, out, &drawn));
    out->width = kind->at ? sqrt(drawn / p.length) : cbrt(drawn / (double)p.count);
    return SC_OK;
}
