/* SPDX-License-Identifier: BSD-3-Clause */
/* The verb fly: the way of a camera along a line, and where it is at a time. */
#include "motion.h"

enum { LAST = SC_WAY_POINTS - 1 };

/* @return a point of the centripetal Catmull-Rom curve from p[1] to p[2], which passes through both
 * without loops and without overshooting (Yuksel, Schaefer and Keyser 2011, "Parameterization and
 * applications of Catmull-Rom curves"; evaluated after Barry and Goldman 1988). @param knots of the
 * four points. @param t from knots[1] to knots[2]. */
static sc_vec3 curve_at(const sc_vec3 p[4], const double knots[4], double t)
{
    sc_vec3 level[4] = {p[0], p[1], p[2], p[3]};

    for (int k = 1; k < 4; k++) {
        for (int i = 0; i + k < 4; i++) {
            const int low = k < 3 ? i : 1, high = k < 3 ? i + k : 2;
            const double share = (t - knots[low]) / (knots[high] - knots[low]);

            level[i] = sc_vec3_along(level[i], share, sc_vec3_sub(level[i + 1], level[i]));
        }
    }
    return level[0];
}

size_t sc_way_curve(const sc_vec3 *through, int count, sc_vec3 *out)
{
    size_t n = 0;

    for (int i = 0; i + 1 < count; i++) {
        const sc_vec3 a = through[i], b = through[i + 1];
        const sc_vec3 p[4] = {
            i > 0 ? through[i - 1] : sc_vec3_along(a, -1, sc_vec3_sub(b, a)), a, b,
            i + 2 < count ? through[i + 2] : sc_vec3_along(b, 1, sc_vec3_sub(b, a))};
        double knots[4] = {0};

        for (int k = 1; k < 4; k++)
            knots[k] = knots[k - 1] + sqrt(sc_vec3_length(sc_vec3_sub(p[k], p[k - 1])));
        for (int k = 0; k < SC_WAY_STEPS; k++)
            out[n++] =
                curve_at(p, knots, knots[1] + (knots[2] - knots[1]) * k / (double)SC_WAY_STEPS);
    }
    out[n++] = through[count - 1];
    return n;
}

/* How far to both sides along the way the mean of radii is taken, in radii there: further than most
 * openings are long, so that it is not seen that light follows them. */
#define SMOOTH_RADII 2.0

/* Smooth the radii along the way: the mean over SMOOTH_RADII to both sides, twice. @param step from
 * a place to the next, in mm. */
static void smooth_radii(double step, sc_way_point *out)
{
    double sums[SC_WAY_POINTS + 1] = {0};

    for (int turn = 0; turn < 2 && step > 0; turn++) {
        for (int i = 0; i <= LAST; i++)
            sums[i + 1] = sums[i] + out[i].around_mm;
        for (int i = 0; i <= LAST; i++) {
            const int reach = (int)fmin(SMOOTH_RADII * out[i].around_mm / step, LAST);
            const int first = i > reach ? i - reach : 0, end = i + reach < LAST ? i + reach : LAST;

            out[i].around_mm = (sums[end + 1] - sums[first]) / (end + 1 - first);
        }
    }
}

/* Set the places of @p out, evenly along the line. @return its length. */
static double set_places(const sc_vec3 *points, const double *around_mm, size_t count,
                         sc_way_point *out)
{
    double length = 0, done = 0, edge = 0;
    size_t at = 0;

    for (size_t i = 1; i < count; i++)
        length += sc_vec3_length(sc_vec3_sub(points[i], points[i - 1]));
    for (int i = 0; i <= LAST; i++) {
        const double target = length * i / LAST;

        while (at + 1 < count && (edge <= 0 || done + edge < target)) {
            done += edge;
            at++;
            edge = sc_vec3_length(sc_vec3_sub(points[at], points[at - 1]));
        }
        out[i].at_mm = points[0];
        out[i].around_mm = around_mm ? around_mm[at] : 0;
        if (edge > 0)
            out[i].at_mm = sc_vec3_along(points[at - 1], fmin((target - done) / edge, 1),
                                         sc_vec3_sub(points[at], points[at - 1]));
    }
    smooth_radii(length / LAST, out);
    return length;
}

/* @return the place at sample @p i, which need not be whole; beyond the end straight on, the way
 * that the line has in its last part of length @p part. */
static sc_vec3 place_at(const sc_way_point *way, double i, double part)
{
    const int low = i < LAST ? (int)i : LAST - 1;
    const double back = fmax(1, fmin(part, LAST));
    const sc_vec3 end = way[LAST].at_mm;

    if (i <= LAST)
        return sc_vec3_along(way[low].at_mm, i - low,
                             sc_vec3_sub(way[low + 1].at_mm, way[low].at_mm));
    return sc_vec3_along(end, (i - LAST) / back, sc_vec3_sub(end, way[(int)(LAST - back)].at_mm));
}

void sc_way_make(const sc_vec3 *points, const double *around_mm, size_t count, double ahead,
                 sc_way_point *out)
{
    const double step = set_places(points, around_mm, count, out) / LAST,
                 reach = fmax(1, ahead * LAST);
    sc_vec3 up = {0, 0, 1};

    for (int i = 0; i <= LAST; i++) {
        sc_vec3 look = sc_vec3_sub(place_at(out, i + reach, reach / 2), out[i].at_mm);

        /* In a narrow bend the place ahead may lie beside the camera: then it looks along the line.
         */
        if (sc_vec3_length(look) < 0.2 * reach * step)
            look = sc_vec3_sub(place_at(out, i + 1, 1), out[i].at_mm);
        out[i].forward = sc_vec3_unit(look);
        if (sc_vec3_length(out[i].forward) < 0.5)
            out[i].forward = i ? out[i - 1].forward : (sc_vec3){0, 1, 0};
        if (i == 0 && fabs(out[i].forward.z) > 0.9)
            up = (sc_vec3){0, 1, 0};
        up = sc_vec3_unit(sc_vec3_along(up, -sc_vec3_dot(up, out[i].forward), out[i].forward));
        out[i].up = up;
    }
}

/* @return the move that the camera flies by at a time: the last of them that has begun, or NULL. */
static const sc_move *flight_at(const sc_timeline *t, double at)
{
    const sc_move *flight = NULL;

    for (int i = 0; i < t->animation.move_count; i++) {
        const sc_verb *verb = &t->moves[i].verb;

        if (verb->kind == SC_VERB_FLY && at >= verb->begin - 1e-9)
            flight = &t->moves[i];
    }
    return flight;
}

bool sc_fly_camera(const sc_timeline *t, double at, double zoom, sc_camera *out, double *around_mm)
{
    const sc_move *flight = flight_at(t, at);
    const sc_way_point *way, *from, *to;
    sc_vec3 place, forward, up;

    if (!flight || !t->ways)
        return false;
    way = &t->ways[(size_t)flight->way * SC_WAY_POINTS];
    at = LAST * sc_progress(flight->verb.begin, flight->verb.end, flight->verb.ease, at);
    from = &way[at < LAST ? (int)at : LAST - 1];
    to = from + 1;
    at -= (double)(from - way);
    place = sc_vec3_along(from->at_mm, at, sc_vec3_sub(to->at_mm, from->at_mm));
    forward = sc_vec3_along(from->forward, at, sc_vec3_sub(to->forward, from->forward));
    if (sc_vec3_length(forward) < 1e-6) /* half way between opposite directions */
        forward = from->forward;
    *around_mm = from->around_mm + at * (to->around_mm - from->around_mm);
    up = sc_vec3_along(from->up, at, sc_vec3_sub(to->up, from->up));
    *out = sc_camera_look(place, sc_vec3_add(place, forward), up, SC_PERSPECTIVE,
                          flight->half_height / zoom);
    return true;
}
