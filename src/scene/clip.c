/* SPDX-License-Identifier: BSD-3-Clause */
/* Clipping of one ray by planes (paper, section 2.2). The paper's formula for the distance t of the
 * crossing lacks the minus sign. */
#include "segcast/scene.h"

/* Cut *kept down to the side of a plane on which sign (normal . p + offset) >= 0; where it begins
 * at the plane then, begin_plane becomes @p index. A ray parallel to the plane is kept or removed
 * whole. @param sign 1 or -1. @param direction unit. @return whether anything is left; if not,
 * *kept is unspecified. */
static bool clip_by_plane(const sc_plane *plane, int index, double sign, sc_vec3 origin,
                          sc_vec3 direction, sc_interval *kept)
{
    const double height = sign * (sc_vec3_dot(plane->normal, origin) + plane->offset_mm);
    const double slope = sign * sc_vec3_dot(plane->normal, direction);
    double crossing;

    if (slope == 0)
        return height >= 0;
    crossing = -height / slope;
    if (slope > 0 && crossing > kept->begin_mm) {
        kept->begin_mm = crossing;
        kept->begin_plane = index;
    } else if (slope < 0 && crossing < kept->end_mm) {
        kept->end_mm = crossing;
    }
    return kept->begin_mm < kept->end_mm;
}

/* SC_CLIP_KEEP: write the part of @p whole that all planes of the set @p which keep to out[0].
 * @return how many parts are kept: 0 or 1. */
static int keep_all(const sc_plane *planes, uint32_t which, sc_vec3 origin, sc_vec3 direction,
                    sc_interval whole, sc_interval out[2])
{
    for (int i = 0; i < SC_PLANES_MAX; i++) {
        if (which >> i & 1 && !clip_by_plane(&planes[i], i, 1, origin, direction, &whole))
            return 0;
    }
    out[0] = whole;
    return 1;
}

/* @return the plane of the set @p which through which the ray leaves the removed part: the one that
 * it crosses, towards what it keeps, nearest to @p end_mm, where that part ends; -1 if there is
 * none. */
static int leaving_plane(const sc_plane *planes, uint32_t which, sc_vec3 origin, sc_vec3 direction,
                         double end_mm)
{
    int best = -1;
    double best_gap = HUGE_VAL;

    for (int i = 0; i < SC_PLANES_MAX; i++) {
        const double slope = which >> i & 1 ? sc_vec3_dot(planes[i].normal, direction) : 0;
        double gap;

        if (slope <= 0)
            continue;
        gap = fabs(end_mm + (sc_vec3_dot(planes[i].normal, origin) + planes[i].offset_mm) / slope);
        if (gap < best_gap) {
            best_gap = gap;
            best = i;
        }
    }
    return best;
}

/* SC_CLIP_CUT: write the parts of @p whole outside of what all planes of the set @p which remove to
 * @p out. The set must not be empty. @return how many parts are kept: 0 to 2. */
static int cut_away(const sc_plane *planes, uint32_t which, sc_vec3 origin, sc_vec3 direction,
                    sc_interval whole, sc_interval out[2])
{
    sc_interval removed = whole;
    int count = 0;

    for (int i = 0; i < SC_PLANES_MAX; i++) {
        if (which >> i & 1 && !clip_by_plane(&planes[i], i, -1, origin, direction, &removed)) {
            out[0] = whole; /* the ray does not meet what is removed */
            return 1;
        }
    }
    if (removed.begin_mm > whole.begin_mm)
        out[count++] = (sc_interval){whole.begin_mm, removed.begin_mm, whole.begin_plane};
    if (removed.end_mm < whole.end_mm)
        out[count++] =
            (sc_interval){removed.end_mm, whole.end_mm,
                          leaving_plane(planes, which, origin, direction, removed.end_mm)};
    return count;
}

int sc_clip_ray(const sc_plane *planes, uint32_t which, sc_clip_mode mode, sc_vec3 origin_mm,
                sc_vec3 direction, double begin_mm, double end_mm, sc_interval out[2])
{
    const sc_interval whole = {begin_mm, end_mm, -1};

    if (!(begin_mm < end_mm))
        return 0;
    if (mode == SC_CLIP_CUT && which)
        return cut_away(planes, which, origin_mm, direction, whole, out);
    return keep_all(planes, which, origin_mm, direction, whole, out);
}
