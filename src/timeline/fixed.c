/* SPDX-License-Identifier: BSD-3-Clause */
/* A fixed camera, whose position, target and up direction are constants or follow key frames. At
 * the key frames it is upright. Where the view becomes nearly parallel to the up direction, as
 * above the head of a body, an upright camera would roll by half a turn within a frame. There the
 * up direction is instead rotated along with the view (parallel transport), and the roll that then
 * remains to be upright at the next key frame away from the pole is spread over the time until
 * then. */
#include "segcast/timeline.h"

#include <math.h>

enum {
    SAMPLES = 128, /* of a way between key frames, where it is asked whether it comes near */
    STEPS = 256    /* of the ways on which "up" is carried */
};
#define NEAR_DEG 10.0 /* from this angle between the view and "up" on, they are not near */

/* @return the direction of view at a time, unit; 0 if the camera stands where it looks. */
static sc_vec3 direction_at(const sc_orbit *c, double at)
{
    const sc_vec3 position = sc_value_at(&c->tracks.position, c->position_mm, at);
    const sc_vec3 target = sc_value_at(&c->tracks.target, c->target_mm, at);
    const sc_vec3 way = sc_vec3_sub(target, position);

    return sc_vec3_length(way) > 0 ? sc_vec3_unit(way) : way;
}

/* @return whether the view at a time is near to "up", or its opposite. */
static bool is_near(const sc_orbit *c, double at)
{
    const double sine = sc_vec3_length(sc_vec3_cross(direction_at(c, at), sc_vec3_unit(c->up)));

    return sine < sin(NEAR_DEG * M_PI / 180);
}

/* Narrow [*begin, *end), which holds @p at, to what lies between two key frames of a track. */
static void narrow(const sc_track *track, double at, double *begin, double *end)
{
    for (int i = 0; i < track->count; i++) {
        const double time = track->keys[i].at;

        if (time <= at)
            *begin = fmax(*begin, time);
        else
            *end = fmin(*end, time);
    }
}

/* Find the time between two key frames of the camera in which @p at lies; the first key frame
 * belongs to it. */
static void segment_at(const sc_orbit *c, double at, double *begin, double *end)
{
    *begin = 0;
    *end = 1;
    narrow(&c->tracks.position, at, begin, end);
    narrow(&c->tracks.target, at, begin, end);
}

/* @return the time of the last key frame before @p at, or 0. */
static double key_before(const sc_orbit *c, double at)
{
    double begin, end;

    segment_at(c, nextafter(at, -1), &begin, &end);
    return begin;
}

/* Find the time in which "up" is carried: from a key frame that is not near, or the first, to the
 * next one that is not, or the last. @return false if the way at @p at comes near nowhere. */
static bool carried_time(const sc_orbit *c, double at, double *begin, double *end)
{
    bool comes_near = false;
    double same;

    segment_at(c, at, begin, end);
    for (int i = 0; i <= SAMPLES && !comes_near; i++)
        comes_near = is_near(c, *begin + (*end - *begin) * i / SAMPLES);
    while (comes_near && *begin > 0 && is_near(c, *begin))
        *begin = key_before(c, *begin);
    while (comes_near && *end < 1 && is_near(c, *end))
        segment_at(c, *end, &same, end);
    return comes_near;
}

/* @return the up direction of the upright camera at a time, perpendicular to the view. */
static sc_vec3 upright_at(const sc_orbit *c, double at)
{
    const sc_vec3 away = sc_vec3_scale(direction_at(c, at), -1);

    return sc_camera_look(away, (sc_vec3){0, 0, 0}, c->up, SC_PERSPECTIVE, 1).up;
}

/* Carry @p up from one time to another, in either order, in steps of @p step. */
static sc_vec3 carry(const sc_orbit *c, double from, double to, double step, sc_vec3 up)
{
    sc_vec3 before = direction_at(c, from);
    bool last = false;

    for (int i = 1; !last; i++) {
        const double way = step * i;
        const sc_vec3 direction =
            direction_at(c, way < fabs(to - from) ? from + copysign(way, to - from) : to);
        const sc_vec3 across = sc_vec3_cross(before, direction);
        const double sine = sc_vec3_length(across);

        if (sine > 0)
            up = sc_vec3_rotate(up, sc_vec3_scale(across, 1 / sine),
                                atan2(sine, sc_vec3_dot(before, direction)));
        before = direction;
        last = way >= fabs(to - from);
    }
    return up;
}

/* @return the up direction at a time: that of the job, or near the pole the transported one. */
static sc_vec3 up_at(const sc_orbit *c, double at)
{
    double begin, end, share, roll, step;
    sc_vec3 up, whole, wanted, direction;

    if (!carried_time(c, at, &begin, &end))
        return c->up;
    step = (end - begin) / STEPS;
    if (!(step > 0))
        return c->up;
    if (is_near(c, begin) && !is_near(c, end)) /* the end says what is upright */
        return carry(c, end, at, step, upright_at(c, end));
    up = upright_at(c, begin);
    whole = carry(c, begin, end, step, up);
    up = carry(c, begin, at, step, up);
    if (is_near(c, end))
        return up;
    wanted = upright_at(c, end);
    direction = direction_at(c, end);
    roll = atan2(sc_vec3_dot(sc_vec3_cross(whole, wanted), direction), sc_vec3_dot(whole, wanted));
    share = (at - begin) / (end - begin);
    return sc_vec3_rotate(up, direction_at(c, at), roll * share * share * (3 - 2 * share));
}

void sc_fixed_camera_at(const sc_orbit *camera, double at, sc_vec3 *position_mm, sc_vec3 *target_mm,
                        sc_vec3 *up)
{
    const sc_orbit *c = camera;

    *position_mm = sc_value_at(&c->tracks.position, c->position_mm, at);
    *target_mm = sc_value_at(&c->tracks.target, c->target_mm, at);
    if (c->tracks.up.count)
        *up = sc_track_direction(&c->tracks.up, at);
    else
        *up = c->tracks.position.count || c->tracks.target.count ? up_at(c, at) : c->up;
}
