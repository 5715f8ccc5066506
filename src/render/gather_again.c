/* SPDX-License-Identifier: BSD-3-Clause */
/* Which rays need not be followed anew once planes have moved that do not keep what is convex, as
 * when a tissue is spared: those before whose hit nothing can have come back, and whose hit cannot
 * have gone. What is asked for is enough for that, so that hits are those of rays that are all
 * followed anew. */
#include "gather.h"
#include "internal.h"

/* So far from a plane, in voxels, a place lies on its side for sure together with the vertex that a
 * ray meets there: that may be one beside the vertex of the place, which lies up to 0.9 away. */
#define SAFE_VOXELS 4.0f

/* What is known of a place. */
enum { KEPT_NOW = 1, KEPT_BOTH = 2 /* now, and when the hits were found */ };

/* @return whether a point lies deep within what all planes keep. */
static bool is_deep(const float equations[][4], int count, const float at[3])
{
    for (int i = 0; i < count; i++) {
        const float *e = equations[i];

        if (!(sc_dot(e, at) + e[3] >= SAFE_VOXELS * sqrtf(sc_dot(e, e))))
            return false;
    }
    return true;
}

/* Note of places [begin, end) what the planes keep: an sc_range_fn on a gather. */
static void find_kept(void *user, size_t begin, size_t end, int thread)
{
    sc_gather *g = user;
    const int count = g->march.plane_count;

    for (size_t at = begin; at < end; at++) {
        const float *p = g->places[at].at;
        const bool now = is_deep((const float(*)[4])g->march.plane_equations, count, p);
        const bool before = is_deep((const float(*)[4])g->planes_before, count, p);

        g->kept[at] = (uint8_t)((now ? KEPT_NOW : 0) | (now && before ? KEPT_BOTH : 0));
    }
}

/* @return whether the planes keep nothing now that they did not keep before. */
static bool only_cut_more(const sc_gather *g)
{
    for (int i = 0; i < g->march.plane_count; i++) {
        const float *now = g->march.plane_equations[i], *before = g->planes_before[i];

        if (now[0] != before[0] || now[1] != before[1] || now[2] != before[2] ||
            !(now[3] <= before[3]))
            return false;
    }
    return true;
}

bool sc_gather_compare_planes(sc_gather *g)
{
    bool moved = false;

    for (int i = 0; i < 4 * g->march.plane_count; i++)
        moved = moved || g->march.plane_equations[i / 4][i % 4] != g->planes_before[i / 4][i % 4];
    if (!moved)
        return false;
    g->cuts_more = only_cut_more(g);
    sc_gather_for(g, g->count, 4096, find_kept);
    return true;
}

/* @return whether a direction, RAS, leads away from what a plane takes. */
static bool leads_away(const sc_plane *plane, const float d[3])
{
    return plane->normal.x * (double)d[0] + plane->normal.y * (double)d[1] +
               plane->normal.z * (double)d[2] >=
           0;
}

bool sc_gather_hit_stays(const sc_gather *g, const sc_scene *scene, size_t at, int i)
{
    const int32_t hit = g->hits[i][at];
    float d[3];

    if (hit == SC_GATHER_LOST)
        return false;
    if (g->cuts_more)
        return hit == SC_GATHER_FREE || g->kept[hit] & KEPT_NOW;
    if (!(g->kept[at] & KEPT_BOTH))
        return false;
    if (hit != SC_GATHER_FREE)
        return g->kept[hit] & KEPT_BOTH;
    sc_gather_direction(g, &g->places[at], i, d);
    for (int k = 0; k < scene->plane_count; k++) {
        if (!leads_away(&scene->planes[k], d) || !leads_away(&g->scene.planes[k], d))
            return false;
    }
    return true;
}
