/* SPDX-License-Identifier: BSD-3-Clause */
/* In which of several pieces that do not touch a line lies, and what is said if there is none. */
#include "internal.h"

/* What is known of the pieces. */
typedef struct pieces {
    const sc_region *region;
    int orders;        /* numbers of the order: 1 to this one */
    uint8_t *has;      /* [parts][orders]: whether a piece has voxels of a number; owned */
    uint8_t *is_there; /* [orders]: whether any has; owned */
    uint32_t *voxels;  /* [parts], owned */
} pieces;

/* Fill in what is known. @param p zeroed, with the region. */
static sc_status look_at(const sc_ctx *ctx, pieces *p)
{
    const sc_region *r = p->region;

    for (int id = 1; id < r->request->volume->label_count; id++)
        p->orders = r->request->order[id] > p->orders ? r->request->order[id] : p->orders;
    SC_PASS(sc_zalloc(ctx, r->parts, (size_t)p->orders, &p->has));
    SC_PASS(sc_zalloc(ctx, (size_t)p->orders, 1, &p->is_there));
    SC_PASS(SC_ZALLOC(ctx, r->parts, &p->voxels));
    for (uint32_t n = 0; n < r->count; n++) {
        const int order = sc_region_order(r, n) - 1;

        p->has[r->part[n] * (size_t)p->orders + (size_t)order] = 1;
        p->is_there[order] = 1;
        p->voxels[r->part[n]]++;
    }
    return SC_OK;
}

/* @return whether a piece lacks a number of the order, less 1, of which there are voxels. */
static bool lacks(const pieces *p, uint32_t part, int i)
{
    return p->is_there[i] && !p->has[part * (size_t)p->orders + (size_t)i];
}

/* @return whether a piece lacks any. */
static bool lacks_any(const pieces *p, uint32_t part)
{
    for (int i = 0; i < p->orders; i++) {
        if (lacks(p, part, i))
            return true;
    }
    return false;
}

/* @return the voxel of a number of the order that is nearest to a point in RAS mm. */
static uint32_t nearest_of(const sc_region *r, int order, sc_vec3 point_mm)
{
    uint32_t out = SC_NO_VOXEL;
    double least = HUGE_VAL;

    for (uint32_t n = 0; n < r->count; n++) {
        double distance;

        if (sc_region_order(r, n) != order)
            continue;
        distance = sc_vec3_length(sc_vec3_sub(sc_region_point(r, n), point_mm));
        if (distance < least) {
            least = distance;
            out = n;
        }
    }
    return out;
}

/* A gap between the largest piece and a tissue. */
typedef struct gap {
    sc_vec3 from, to; /* in the piece; in the tissue; RAS mm */
    double length_mm;
} gap;

/* @return the narrowest gap to the tissues of a number of the order, nearly: it is looked for from
 * the one to the other and back, where it becomes narrower each time. */
static gap gap_to(const sc_region *r, int order)
{
    enum { ROUNDS = 4 };
    gap out = {.from = sc_region_point(r, 0)};

    for (int i = 0; i < ROUNDS; i++) {
        out.to = sc_region_point(r, nearest_of(r, order, out.from));
        out.from = sc_region_point(r, sc_region_nearest(r, out.to, r->largest_part));
    }
    out.length_mm = sc_vec3_length(sc_vec3_sub(out.to, out.from));
    return out;
}

/* Refuse tissues that are in no common piece: say where the largest piece ends before the nearest
 * tissue that it lacks. */
static sc_status fail_apart(const sc_ctx *ctx, const pieces *p)
{
    const sc_region *r = p->region;
    const sc_centerline_request *q = r->request;
    gap least = {.length_mm = HUGE_VAL};
    const char *name = NULL;

    for (int i = 0; i < p->orders; i++) {
        gap found;

        if (!lacks(p, r->largest_part, i))
            continue;
        found = gap_to(r, i + 1);
        if (found.length_mm < least.length_mm) {
            least = found;
            name = q->names ? q->names[i] : NULL;
        }
    }
    return sc_fail(ctx, SC_ERR_DATA,
                   "%s%s%s do not touch one another, so that there is no way through all of them: "
                   "the largest piece ends at (%.1f, %.1f, %.1f), %.1f mm before %s%s%s at (%.1f, "
                   "%.1f, %.1f); name the tissues in between, too",
                   q->where, q->where[0] ? ": " : "", q->what, least.from.x, least.from.y,
                   least.from.z, least.length_mm, name ? "\"" : "", name ? name : "another one",
                   name ? "\"" : "", least.to.x, least.to.y, least.to.z);
}

sc_status sc_piece_choose(const sc_ctx *ctx, const sc_region *region, uint32_t *part)
{
    pieces p = {.region = region};
    bool found = false;
    sc_status status;

    *part = region->largest_part;
    if (region->parts == 1)
        return SC_OK;
    SC_TRY(look_at(ctx, &p));
    for (uint32_t i = 0; i < region->parts; i++) {
        if (lacks_any(&p, i) || (found && p.voxels[i] <= p.voxels[*part]))
            continue;
        *part = i;
        found = true;
    }
    if (!found)
        status = fail_apart(ctx, &p);
out:
    sc_free(p.has);
    sc_free(p.is_there);
    sc_free(p.voxels);
    return status;
}
