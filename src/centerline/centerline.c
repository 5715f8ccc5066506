/* SPDX-License-Identifier: BSD-3-Clause */
/* Centre lines: the ends, the way between them, and its smoothing. See centerline.h. */
#include "internal.h"

/* A way while it becomes a line, in voxel coordinates of the volume. */
typedef struct way {
    uint32_t *voxels;         /* [count], from the begin to the end */
    sc_vec3 *points, *smooth; /* [count] */
    double *reach;            /* [count]: how many voxels to each side the average takes */
    uint32_t count, room;
} way;

/* What the line is found with. */
typedef struct finder {
    const sc_centerline_request *request;
    sc_region region;
    sc_search search;
    uint32_t *ends; /* [end_count]: the voxels that the line connects, at least 2 */
    size_t end_count;
    sc_affine to_voxel; /* from RAS mm */
    way way;
} finder;

/* The begin of a message: "file:line: ". */
#define WHERE(q) (q)->where, (q)->where[0] ? ": " : ""

/* ---- ends ---- */

/* Refuse a point outside of the tissues. @param number from 1, for the message. */
static sc_status fail_outside(const sc_ctx *ctx, const finder *f, size_t number)
{
    const sc_centerline_request *q = f->request;
    const sc_vec3 p = q->through[number - 1];
    const sc_vec3 near = sc_region_point(&f->region, sc_region_nearest(&f->region, p, SC_NO_VOXEL));

    return sc_fail(ctx, SC_ERR_DATA,
                   "%s%spoint %zu (%.1f, %.1f, %.1f) lies outside of %s; the nearest place in it "
                   "is (%.1f, %.1f, %.1f), %.1f mm away",
                   WHERE(q), number, p.x, p.y, p.z, q->what, near.x, near.y, near.z,
                   sc_vec3_length(sc_vec3_sub(near, p)));
}

/* Refuse two points that no way connects. @param number of the first of them, from 1. */
static sc_status fail_no_way(const sc_ctx *ctx, const finder *f, size_t number)
{
    const sc_centerline_request *q = f->request;
    const sc_vec3 from = q->through[number - 1], to = q->through[number];
    const sc_vec3 last = sc_region_point(
        &f->region, sc_region_nearest(&f->region, to, f->region.part[f->ends[number - 1]]));

    return sc_fail(ctx, SC_ERR_DATA,
                   "%s%sthere is no way within %s from point %zu (%.1f, %.1f, %.1f) to point %zu "
                   "(%.1f, %.1f, %.1f): from there it ends at (%.1f, %.1f, %.1f), %.1f mm before "
                   "that point; name the tissues in between, too",
                   WHERE(q), q->what, number, from.x, from.y, from.z, number + 1, to.x, to.y, to.z,
                   last.x, last.y, last.z, sc_vec3_length(sc_vec3_sub(last, to)));
}

/* Find the voxels of the given points. */
static sc_status find_given(const sc_ctx *ctx, finder *f)
{
    const sc_centerline_request *q = f->request;

    for (size_t i = 0; i < q->through_count; i++) {
        const uint32_t voxel =
            sc_region_voxel(&f->region, sc_affine_point(&f->to_voxel, q->through[i]));

        if (voxel == SC_NO_VOXEL)
            return fail_outside(ctx, f, i + 1);
        f->ends[i] = voxel;
        if (i && f->region.part[voxel] != f->region.part[f->ends[i - 1]])
            return fail_no_way(ctx, f, i);
    }
    return SC_OK;
}

/* Find the two voxels of a piece that are farthest from each other along ways within it, nearly:
 * the one farthest from any, and the one farthest from that. */
static void find_farthest(finder *f, uint32_t part)
{
    const sc_region *r = &f->region;
    uint32_t first = 0, a, b;
    bool swap;

    while (r->part[first] != part)
        first++;
    a = sc_search_run(&f->search, r, first, SC_NO_VOXEL, true);
    b = sc_search_run(&f->search, r, a, SC_NO_VOXEL, true);
    swap = sc_region_order(r, a) != sc_region_order(r, b)
               ? sc_region_order(r, b) < sc_region_order(r, a)
               : sc_region_point(r, b).z > sc_region_point(r, a).z;
    f->ends[0] = swap ? b : a;
    f->ends[1] = swap ? a : b;
}

/* Fill f->ends, each in the middle of the tissue. */
static sc_status find_ends(const sc_ctx *ctx, finder *f)
{
    const size_t given = f->request->through_count;
    uint32_t part = 0;

    f->end_count = given > 2 ? given : 2;
    SC_PASS(SC_ALLOC(ctx, f->end_count, &f->ends));
    SC_PASS(find_given(ctx, f));
    if (given == 0) {
        SC_PASS(sc_piece_choose(ctx, &f->region, &part));
        find_farthest(f, part);
    } else if (given == 1)
        f->ends[1] = sc_search_run(&f->search, &f->region, f->ends[0], SC_NO_VOXEL, true);
    for (size_t i = 0; i < f->end_count; i++)
        f->ends[i] = sc_region_middle(&f->region, f->ends[i]);
    return SC_OK;
}

/* ---- the way ---- */

/* Append the way of the last search, which ended at @p end, without its first voxel unless it is
 * the first way. @return SC_ERR_MEMORY. */
static sc_status append_way(const sc_ctx *ctx, finder *f, uint32_t end)
{
    way *w = &f->way;
    uint32_t more = 0, at;

    for (uint32_t v = end; v != SC_NO_VOXEL; v = f->search.from[v])
        more++;
    if (w->count)
        more--;
    if (w->count + more > w->room) {
        SC_PASS(SC_RESIZE(ctx, w->count, w->count + more, &w->voxels));
        w->room = w->count + more;
    }
    at = w->count += more;
    for (uint32_t v = end; more > 0; v = f->search.from[v], more--)
        w->voxels[--at] = v;
    return SC_OK;
}

/* Find the way that connects the ends, as voxels and points. */
static sc_status find_way(const sc_ctx *ctx, finder *f)
{
    const sc_centerline_request *q = f->request;
    way *w = &f->way;

    for (size_t i = 0; i + 1 < f->end_count; i++) {
        sc_search_run(&f->search, &f->region, f->ends[i], f->ends[i + 1], false);
        SC_PASS(append_way(ctx, f, f->ends[i + 1]));
    }
    if (w->count < 2)
        return sc_fail(
            ctx, SC_ERR_DATA,
            "%s%s%s: the ends of the line lie at one place in the middle, so that there is "
            "no line between them; give points that are farther from each other",
            WHERE(q), q->what);
    SC_PASS(SC_ALLOC(ctx, w->count, &w->points));
    SC_PASS(SC_ALLOC(ctx, w->count, &w->smooth));
    SC_PASS(SC_ALLOC(ctx, w->count, &w->reach));
    for (uint32_t i = 0; i < w->count; i++)
        w->points[i] = sc_affine_point(&f->to_voxel, sc_region_point(&f->region, w->voxels[i]));
    return SC_OK;
}

/* ---- smoothing ---- */

/* Set how far the average at each point reaches, in points: a third of the depth, at least 2
 * points, and no farther than to the ends of the line, which stay where they are. */
static void set_reach(finder *f)
{
    way *w = &f->way;

    for (uint32_t i = 0; i < w->count; i++) {
        const double depth = (double)f->region.depth_mm[w->voxels[i]] / f->region.least_mm;
        const uint32_t back = i, ahead = w->count - 1 - i;

        w->reach[i] = fmin(fmax(2, depth / 3), back < ahead ? back : ahead);
    }
}

/* @return the average of the points around point @p i, with weights that fall evenly to 0. */
static sc_vec3 average_at(const way *w, uint32_t i)
{
    const double reach = w->reach[i] + 1;
    const int64_t most = (int64_t)w->reach[i];
    sc_vec3 sum = {0, 0, 0};
    double total = 0;

    for (int64_t k = -most; k <= most; k++) {
        const double weight = 1 - (double)(k < 0 ? -k : k) / reach;

        sum = sc_vec3_along(sum, weight, w->points[(int64_t)i + k]);
        total += weight;
    }
    return sc_vec3_scale(sum, 1 / total);
}

/* Smooth the way. A point that would come too near to the border, or leave the tissue, goes only a
 * part of its way. */
static void smooth_way(finder *f)
{
    enum { PASSES = 2, TRIES = 4 };
    way *w = &f->way;

    set_reach(f);
    for (int pass = 0; pass < PASSES; pass++) {
        for (uint32_t i = 0; i < w->count; i++) {
            const double least = f->request->clearance * (double)f->region.depth_mm[w->voxels[i]];
            const sc_vec3 off = sc_vec3_sub(average_at(w, i), w->points[i]);
            double share = 1;

            w->smooth[i] = sc_vec3_add(w->points[i], off);
            for (int t = 0;
                 t < TRIES && (sc_region_voxel(&f->region, w->smooth[i]) == SC_NO_VOXEL ||
                               sc_region_depth(&f->region, w->smooth[i]) < least);
                 t++) {
                share = t + 1 < TRIES ? share / 2 : 0;
                w->smooth[i] = sc_vec3_along(w->points[i], share, off);
            }
        }
        memcpy(w->points, w->smooth, w->count * sizeof *w->points);
    }
}

/* ---- sampling ---- */

/* @return the radius at a point of voxel coordinates. Between voxels the depth is less than the
 * true distance, as much as the middle of the first voxel outside lies beyond the border. */
static double radius_at(const sc_region *r, sc_vec3 at)
{
    return fmax(sc_region_depth(r, at), 0.5 * r->least_mm);
}

/* Sample the way evenly, about as finely as the voxels are. */
static sc_status sample_way(const sc_ctx *ctx, const finder *f, sc_centerline *out)
{
    const way *w = &f->way;
    const sc_affine *to_ras_mm = &f->request->volume->to_ras_mm;
    double done_mm = 0, edge_mm = 0, length_mm = 0;
    sc_vec3 from, to = sc_affine_point(to_ras_mm, w->points[0]);
    uint32_t edge = 0;
    size_t steps;
    sc_centerline_point *points;

    for (uint32_t i = 1; i < w->count; i++) {
        from = to;
        to = sc_affine_point(to_ras_mm, w->points[i]);
        length_mm += sc_vec3_length(sc_vec3_sub(to, from));
    }
    steps = (size_t)fmax(1, ceil(length_mm / f->region.least_mm));
    SC_PASS(SC_ALLOC(ctx, steps + 1, &points));
    *out = (sc_centerline){.points = points,
                           .count = steps + 1,
                           .length_mm = length_mm,
                           .parts = (int)f->region.parts};
    for (size_t i = 0; i <= steps; i++) {
        const double at_mm = length_mm * (double)i / (double)steps;
        double share;
        sc_vec3 voxel;

        while (edge + 1 < w->count && (edge_mm <= 0 || done_mm + edge_mm < at_mm)) {
            done_mm += edge_mm;
            edge++;
            edge_mm = sc_vec3_length(
                sc_affine_vector(to_ras_mm, sc_vec3_sub(w->points[edge], w->points[edge - 1])));
        }
        share = edge_mm > 0 ? fmin((at_mm - done_mm) / edge_mm, 1) : 1;
        voxel = sc_vec3_along(w->points[edge - 1], share,
                              sc_vec3_sub(w->points[edge], w->points[edge - 1]));
        out->points[i] =
            (sc_centerline_point){sc_affine_point(to_ras_mm, voxel), radius_at(&f->region, voxel)};
    }
    return SC_OK;
}

/* @return whether the tissues end ahead of the last point of a line, straight on, within two of its
 * radii. The way there is that from the last point a radius before. */
static bool ends_at_wall(const finder *f, const sc_centerline *line)
{
    const sc_centerline_point *last = &line->points[line->count - 1], *before = last;
    const double step_mm = 0.5 * f->region.least_mm;
    sc_vec3 ahead;

    while (before > line->points &&
           sc_vec3_length(sc_vec3_sub(last->at_mm, before->at_mm)) < last->radius_mm)
        before--;
    ahead = sc_vec3_unit(sc_vec3_sub(last->at_mm, before->at_mm));
    for (int i = 0; i * step_mm <= 2 * last->radius_mm; i++) {
        const sc_vec3 at_mm = sc_vec3_along(last->at_mm, i * step_mm, ahead);

        if (sc_region_voxel(&f->region, sc_affine_point(&f->to_voxel, at_mm)) == SC_NO_VOXEL)
            return true;
    }
    return false;
}

sc_status sc_centerline_find(const sc_ctx *ctx, const sc_centerline_request *request,
                             sc_centerline *out)
{
    finder f = {.request = request};
    sc_status status;

    if (!sc_affine_invert(&request->volume->to_ras_mm, &f.to_voxel))
        return sc_fail(ctx, SC_ERR_DATA, "%s%sthe axes of the volume are not independent",
                       WHERE(request));
    SC_TRY(sc_region_make(ctx, request, &f.region));
    SC_TRY(sc_search_open(ctx, &f.region, &f.search));
    SC_TRY(find_ends(ctx, &f));
    SC_TRY(find_way(ctx, &f));
    smooth_way(&f);
    SC_TRY(sample_way(ctx, &f, out));
    out->ends_at_wall = ends_at_wall(&f, out);
out:
    sc_free(f.way.voxels);
    sc_free(f.way.points);
    sc_free(f.way.smooth);
    sc_free(f.way.reach);
    sc_free(f.ends);
    sc_search_clear(&f.search);
    sc_region_clear(&f.region);
    return status;
}

sc_status sc_centerline_middle(const sc_ctx *ctx, const sc_centerline_request *request,
                               sc_vec3 *out)
{
    const float thick = 0.9F; /* of the greatest depth: a slab or a tube has it in many places */
    sc_vec3 center_mm = {0, 0, 0};
    double least_mm = HUGE_VAL;
    float deepest_mm = 0;
    SC_OWN(sc_region_clear) sc_region region = {0};

    SC_PASS(sc_region_make(ctx, request, &region));
    for (uint32_t n = 0; n < region.count; n++) {
        deepest_mm = fmaxf(deepest_mm, region.depth_mm[n]);
        center_mm = sc_vec3_along(center_mm, 1.0 / region.count, sc_region_point(&region, n));
    }
    for (uint32_t n = 0; n < region.count; n++) {
        const sc_vec3 at_mm = sc_region_point(&region, n);
        const double off_mm = sc_vec3_length(sc_vec3_sub(at_mm, center_mm));

        if (region.depth_mm[n] < thick * deepest_mm || off_mm >= least_mm)
            continue;
        least_mm = off_mm;
        *out = at_mm;
    }
    return SC_OK;
}

void sc_centerline_clear(sc_centerline *line)
{
    sc_free(line->points);
    *line = (sc_centerline){0};
}
