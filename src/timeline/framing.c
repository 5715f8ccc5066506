/* SPDX-License-Identifier: BSD-3-Clause */
/* Framing of an orbit: see framing.h. The tissues are given by points, in RAS mm.
 *
 * The camera turns about the line around which the points keep within the narrowest cylinder, so
 * that the body stays in the middle of the width. From each direction of view the picture has four
 * edges. An edge holds if no point lies beyond a plane through the eye, so that it asks for some
 * distance of the camera, which is linear in the target. The target lies on that line where
 * there is as much room above as below, and the distance is the largest that any edge asks for:
 * the tightest picture that is safe for the whole turn. A picture alone has as much room at the
 * right as at the left, too. */
#include "framing.h"

enum {
    ANGLES = 128,              /* directions about the axis */
    EDGES = 4 * SC_SIGHTS_MAX, /* for each direction of view: right, left, top, bottom */
    BLOCKS = 1024,             /* of points, which are searched as a whole */
    STEPS = 48 /* of a search along a line: to 1e-10 of its length, so that where nothing else
                  decides rounding does not either */
};
#define EVENNESS 1e-3 /* how much evenness counts beside the radius */
#define MARGIN 1.05   /* the picture shows this multiple of what must be in it */

void sc_extent(const sc_vec3 *points, size_t count, sc_vec3 direction, double *low, double *high)
{
    *low = count ? HUGE_VAL : -0.5;
    *high = count ? -HUGE_VAL : 0.5;
    for (size_t i = 0; i < count; i++) {
        const double at = sc_vec3_dot(points[i], direction);

        *low = at < *low ? at : *low;
        *high = at > *high ? at : *high;
    }
}

/* Consecutive points, and the box around them. */
typedef struct block {
    size_t begin, end;
    sc_box3 box;
} block;

/* Divide the points into @p blocks. @return how many there are, at most BLOCKS. */
static size_t make_blocks(const sc_vec3 *points, size_t count, block blocks[BLOCKS])
{
    const size_t each = count / BLOCKS + 1;
    size_t n = 0;

    for (size_t begin = 0; begin < count; begin += each, n++) {
        block b = {begin, begin + each < count ? begin + each : count, SC_BOX3_EMPTY};

        for (size_t i = begin; i < b.end; i++)
            sc_box3_hold(&b.box, points[i]);
        blocks[n] = b;
    }
    return n;
}

/* @return the largest value of n . p in the box of a block. */
static double bound_of(const block *b, sc_vec3 n)
{
    return n.x * (n.x > 0 ? b->box.high.x : b->box.low.x) +
           n.y * (n.y > 0 ? b->box.high.y : b->box.low.y) +
           n.z * (n.z > 0 ? b->box.high.z : b->box.low.z);
}

/* @return the larger of @p most and n . p of all points p of a block. */
static double search_block(const sc_vec3 *points, const block *b, sc_vec3 n, double most)
{
    for (size_t i = b->begin; i < b->end; i++) {
        const double at = sc_vec3_dot(points[i], n);

        most = at > most ? at : most;
    }
    return most;
}

/* @return the largest n . p of all points p, of which there is at least one: only blocks whose box
 * reaches further than what has been found are searched, beginning with the one that reaches
 * furthest. */
static double support(const sc_vec3 *points, const block *blocks, size_t count, sc_vec3 n)
{
    double furthest = -HUGE_VAL, most;
    size_t first = 0;

    for (size_t i = 0; i < count; i++) {
        const double bound = bound_of(&blocks[i], n);

        if (bound > furthest) {
            furthest = bound;
            first = i;
        }
    }
    most = search_block(points, &blocks[first], n, -HUGE_VAL);
    for (size_t i = 0; i < count; i++) {
        if (bound_of(&blocks[i], n) > most)
            most = search_block(points, &blocks[i], n, most);
    }
    return most;
}

/* What the edges of the pictures of an orbit ask for: edge i the distance (perspective) or half
 * height (orthographic) reach[i] - normal[i] . target, in mm. */
typedef struct edges {
    int count; /* of the edges */
    sc_vec3 normal[EDGES];
    double reach[EDGES];
} edges;

/* From where the points are seen, in which pictures. */
typedef struct seen {
    const sc_sight *sights; /* [count] */
    int count;
    bool orthographic;
    double aspect; /* width of the picture divided by its height */
} seen;

/* The points that are framed. */
typedef struct cloud {
    const sc_vec3 *points; /* [count] */
    size_t count, block_count;
    block blocks[BLOCKS]; /* [block_count] of them */
} cloud;

/* Fill in edges 0 and 1 (right and left) or 2 and 3 (top and bottom) of all directions of view.
 * @param c with no points, a ball of 1 mm at the origin is framed. @param margin how much larger
 * the picture is than what must be in it. */
static void find_edges(const seen *s, const cloud *c, int first, double margin, edges *out)
{
    out->count = 4 * s->count;
    for (int i = 0; i < s->count; i++) {
        const sc_sight *sight = &s->sights[i];
        const double scale =
            (s->orthographic ? margin : margin / sight->tangent) / (first == 0 ? s->aspect : 1);
        const sc_camera camera =
            sc_camera_look(sight->away, (sc_vec3){0, 0, 0}, sight->up, SC_ORTHOGRAPHIC, 1);

        for (int edge = first; edge < first + 2; edge++) {
            const sc_vec3 side =
                sc_vec3_scale(first == 0 ? camera.right : camera.up, edge & 1 ? -scale : scale);
            const sc_vec3 n = s->orthographic ? side : sc_vec3_add(side, sight->away);

            out->normal[4 * i + edge] = n;
            out->reach[4 * i + edge] = c->count ? support(c->points, c->blocks, c->block_count, n)
                                                : 0.5 * sc_vec3_length(n);
        }
    }
}

/* @return the distance or half height, in mm, that edges @p from to @p to of every direction ask
 * for. */
static double needed(const edges *e, sc_vec3 target, int from, int to)
{
    double most = 1e-3;

    for (int i = 0; i < e->count; i += 4) {
        for (int k = i + from; k <= i + to; k++) {
            const double need = e->reach[k] - sc_vec3_dot(e->normal[k], target);

            most = need > most ? need : most;
        }
    }
    return most;
}

/* The same of all edges, with a target that moves: that of each sight. */
static double needed_on_the_way(const edges *e, const seen *s)
{
    double most = 1e-3;

    for (int i = 0; i < e->count; i++)
        most = fmax(most, e->reach[i] - sc_vec3_dot(e->normal[i], s->sights[i / 4].target_mm));
    return most;
}

/* What is to be made small by the choice of a point along a line: a convex function. */
typedef double cost_fn(const void *user, double at);

/* @return where in [low, high] the least cost is: a golden-section search. */
static double least_cost(cost_fn *cost, const void *user, double low, double high)
{
    const double golden = 0.61803398874989485;
    double at[2] = {high - golden * (high - low), low + golden * (high - low)};
    double costs[2] = {cost(user, at[0]), cost(user, at[1])};

    for (int step = 0; step < STEPS; step++) {
        const int kept = costs[0] <= costs[1] ? 0 : 1; /* the other one becomes the end */

        if (kept == 0)
            high = at[1];
        else
            low = at[0];
        at[!kept] = at[kept];
        costs[!kept] = costs[kept];
        at[kept] = kept ? low + golden * (high - low) : high - golden * (high - low);
        costs[kept] = cost(user, at[kept]);
    }
    return at[costs[1] < costs[0]];
}

/* A search for the line about which the points turn within the narrowest cylinder. */
typedef struct narrowest {
    sc_vec3 side, other;                 /* unit, perpendicular to the axis and to each other */
    double low, high;                    /* of the points along other */
    double reach[ANGLES];                /* of the points in each direction from the axis */
    double cosine[ANGLES], sine[ANGLES]; /* of these directions */
    double along_side;                   /* where the line lies */
} narrowest;

/* @return the radius of the cylinder about the line at along_side and @p at along other, and a
 * little of the mean square of what lies in each direction: of several lines with the same radius,
 * the one in the middle is the best, so that it does not depend on how the search goes. */
static double radius_at(const void *user, double at)
{
    const narrowest *n = user;
    double most = 0, squares = 0;

    for (int i = 0; i < ANGLES; i++) {
        const double reach = n->reach[i] - n->along_side * n->cosine[i] - at * n->sine[i];

        most = fmax(most, reach);
        squares += reach * reach;
    }
    return most + EVENNESS * squares / (ANGLES * (n->high - n->low + 1));
}

/* @return the least radius of all lines at @p at along side. */
static double least_radius_at(const void *user, double at)
{
    narrowest n = *(const narrowest *)user;

    n.along_side = at;
    return radius_at(&n, least_cost(radius_at, &n, n.low, n.high));
}

/* @return the point of the plane through the origin, across the axis, where the line of that search
 * meets it. So a body that turns stays in the middle of the width. */
static sc_vec3 middle_across(const sc_orbit *orbit, const cloud *c)
{
    narrowest n = {.side = sc_orbit_reference(orbit->axis)};
    double low, high;
    sc_vec3 out;

    n.other = sc_vec3_cross(orbit->axis, n.side);
    for (int i = 0; i < ANGLES; i++) {
        const double turn = 2 * M_PI * i / ANGLES;
        const sc_vec3 direction =
            sc_vec3_along(sc_vec3_scale(n.side, cos(turn)), sin(turn), n.other);

        n.cosine[i] = cos(turn);
        n.sine[i] = sin(turn);
        n.reach[i] = c->count ? support(c->points, c->blocks, c->block_count, direction) : 0.5;
    }
    low = -n.reach[ANGLES / 2];
    high = n.reach[0];
    n.low = -n.reach[3 * ANGLES / 4];
    n.high = n.reach[ANGLES / 4];
    n.along_side = least_cost(least_radius_at, &n, low, high);
    out = sc_vec3_scale(n.side, n.along_side);
    return sc_vec3_along(out, least_cost(radius_at, &n, n.low, n.high), n.other);
}

/* A search along a line for the target with as much room at one edge as at the opposite one. */
typedef struct level {
    const edges *e;
    int first; /* 0: right and left edges, 2: upper and lower ones */
    sc_vec3 axis, from;
} level;

/* @return what these edges ask for with the target at @p at along the axis. */
static double room_at(const void *user, double at)
{
    const level *l = user;

    return needed(l->e, sc_vec3_along(l->from, at, l->axis), l->first, l->first + 1);
}

/* @return the same of the other two edges. */
static double other_room_at(const level *l, double at)
{
    return needed(l->e, sc_vec3_along(l->from, at, l->axis), 2 - l->first, 3 - l->first);
}

/* Move a target along the axis of @p l, from where it begins, so that there is as much room at both
 * of its edges. If the other two decide about the distance, there is more room than the margin: as
 * much as makes these ask for the same distance. @param e l->e, edges with MARGIN; those of @p l
 * are changed. @return the target. */
static sc_vec3 balance(const level *l, const cloud *c, const seen *s, edges *e)
{
    enum { TRIES = 24 };
    double low, high, margin = MARGIN, step = 8 * MARGIN, room, at;

    sc_extent(c->points, c->count, l->axis, &low, &high);
    low -= sc_vec3_dot(l->from, l->axis);
    high -= sc_vec3_dot(l->from, l->axis);
    room = needed(e, sc_vec3_along(l->from, 0.5 * (low + high), l->axis), 0, 3) / 4;
    low -= room; /* a flat body is seen from above: its near side reaches far below it */
    high += room;
    at = least_cost(room_at, l, low, high);
    for (int i = 0; i < TRIES; i++) {
        double tried = margin + step;

        step /= 2;
        if (i == 0 && room_at(l, at) >= other_room_at(l, at))
            break;
        find_edges(s, c, l->first, tried, e);
        at = least_cost(room_at, l, low, high);
        if (room_at(l, at) < other_room_at(l, at))
            margin = tried;
    }
    return sc_vec3_along(l->from, at, l->axis);
}

/* Choose the target of a camera that sees the points from one place: they lie in the middle of the
 * picture. The edges that decide about the distance are known when the others are in balance.
 * @param e as of balance. */
static sc_vec3 centre(const sc_orbit *orbit, const cloud *c, const seen *s, edges *e)
{
    enum { ROUNDS = 2 };
    const sc_vec3 up = s->sights->up, away = s->sights->away;
    const sc_camera camera = sc_camera_look(away, (sc_vec3){0, 0, 0}, up, SC_ORTHOGRAPHIC, 1);
    sc_vec3 target = middle_across(orbit, c);
    double low, high;

    sc_extent(c->points, c->count, orbit->axis, &low, &high);
    target = sc_vec3_along(target, 0.5 * (low + high), orbit->axis);
    for (int i = 0; i < 2 * ROUNDS; i++) {
        const level l = {e, i & 1 ? 2 : 0, i & 1 ? camera.up : camera.right, target};

        target = balance(&l, c, s, e);
        find_edges(s, c, l.first, MARGIN, e);
    }
    return target;
}

/* Choose the target of an orbit: on the line of middle_across, with as much room above as below.
 * @param e as of balance. */
static sc_vec3 choose_target(const sc_orbit *orbit, const cloud *c, const seen *s, edges *e)
{
    const level l = {e, 2, orbit->axis, middle_across(orbit, c)};

    return balance(&l, c, s, e);
}

void sc_frame_orbit(sc_orbit *orbit, const sc_sight *sights, int sight_count, const sc_vec3 *points,
                    size_t count, double aspect, double *half_height)
{
    const double tangent = tan(orbit->fov_deg * M_PI / 360);
    const bool orthographic = orbit->projection == SC_ORTHOGRAPHIC;
    const seen s = {sights, sight_count, orthographic, aspect};
    cloud c = {.points = points, .count = count};
    double need, low, high;
    edges e;

    *half_height = tangent;
    if (orbit->fixed) {
        if (orthographic) /* the half height of the field of view at the target */
            *half_height =
                tangent * sc_vec3_length(sc_vec3_sub(orbit->target_mm, orbit->position_mm));
        return;
    }
    c.block_count = make_blocks(points, count, c.blocks);
    find_edges(&s, &c, 0, MARGIN, &e);
    find_edges(&s, &c, 2, MARGIN, &e);
    if (!orbit->has_target) {
        edges scratch = e;

        orbit->target_mm = (orbit->alone ? centre : choose_target)(orbit, &c, &s, &scratch);
    }
    need =
        orbit->tracks.target.count ? needed_on_the_way(&e, &s) : needed(&e, orbit->target_mm, 0, 3);
    if (orthographic) {
        *half_height = orbit->has_distance ? tangent * orbit->distance_mm : need;
        sc_extent(points, count, orbit->axis, &low, &high);
        orbit->distance_mm = 2 * (need * (1 + aspect) + high - low) + 1; /* outside of all */
    } else if (!orbit->has_distance) {
        orbit->distance_mm = need;
    }
}

double sc_fit_height(const sc_sight *sights, int sight_count, sc_vec3 target_mm, double distance_mm,
                     const sc_vec3 *points, size_t count, double aspect)
{
    double most = 1e-6;

    for (int i = 0; i < sight_count; i++) {
        const sc_sight *s = &sights[i];
        const sc_camera c = sc_camera_look(sc_vec3_along(target_mm, distance_mm, s->away),
                                           target_mm, s->up, SC_PERSPECTIVE, 1);

        for (size_t k = 0; k < count; k++) {
            const sc_vec3 d = sc_vec3_sub(points[k], c.position_mm);
            const double across =
                fmax(fabs(sc_vec3_dot(d, c.right)) / aspect, fabs(sc_vec3_dot(d, c.up)));

            most = fmax(most, across / sc_vec3_dot(d, c.forward));
        }
    }
    return MARGIN * most;
}
