/* SPDX-License-Identifier: BSD-3-Clause */
/* Where a camera that turns stands: see motion.h.
 *
 * Angle and elevation turn a frame of three directions, so that the direction that points up in the
 * picture is known at every elevation and the picture goes smoothly through the poles. */
#include "motion.h"

enum {
    ANGLES = 128 /* directions of view in a turn: an edge between two of them errs by 0.03 % */
};
#define POLE_DEG 89.9 /* up to this elevation the axis shows what is up */

sc_vec3 sc_orbit_reference(sc_vec3 axis)
{
    const sc_vec3 front = {0, 1, 0}, above = {0, 0, 1};
    sc_vec3 out = sc_vec3_along(front, -sc_vec3_dot(front, axis), axis);

    if (sc_vec3_length(out) < 0.1)
        out = sc_vec3_along(above, -sc_vec3_dot(above, axis), axis);
    return sc_vec3_unit(out);
}

/* Set away and up of a camera at an angle about the axis, and an elevation. */
static void set_direction(const sc_orbit *orbit, double angle, double elevation_deg, sc_sight *out)
{
    const double elevation = elevation_deg * M_PI / 180;
    const sc_vec3 level = sc_vec3_rotate(sc_orbit_reference(orbit->axis), orbit->axis, angle);

    out->away = sc_vec3_along(sc_vec3_scale(level, cos(elevation)), sin(elevation), orbit->axis);
    out->up = orbit->axis;
    if (fabs(elevation_deg) > POLE_DEG) /* the same where both are good, but good everywhere */
        out->up = sc_vec3_along(sc_vec3_scale(orbit->axis, cos(elevation)), -sin(elevation), level);
}

/* @return how much of the time of a hold the camera has stood still, as a share of that time: at @p
 * x of it, 0 to 1. While it comes to rest its speed falls as an ease of kind smooth rises. */
static double rest_at(double x, double soft)
{
    double y = x;

    if (soft > 0 && x < soft) {
        y = x / soft;
        return soft * y * y * y * (1 - y / 2);
    }
    if (soft > 0 && x > 1 - soft) {
        y = (1 - x) / soft;
        return 1 - soft - soft * y * y * y * (1 - y / 2);
    }
    return x - soft / 2;
}

/* @return the frame at which an orbit would be without holds, when it is at frame @p k. */
static double without_holds(const sc_timeline *t, double k)
{
    const int frames = t->animation.frames;
    const double at = sc_frame_time(k, frames);
    double rested = 0, rest = 0;

    for (int i = 0; i < t->animation.move_count; i++) {
        const sc_verb *hold = &t->moves[i].verb;
        const double length = hold->end - hold->begin;

        if (hold->kind != SC_VERB_HOLD)
            continue;
        rest += length * (1 - hold->soft);
        if (at > hold->begin)
            rested += at < hold->end ? length * rest_at((at - hold->begin) / length, hold->soft)
                                     : length * (1 - hold->soft);
    }
    return rest > 0 ? (at - rested) / (1 - rest) * (frames - 1) : k;
}

/* Add to the angle and the elevation what verbs do to them at a time. */
static void add_swings(const sc_timeline *t, double at, double *angle_deg, double *elevation_deg)
{
    for (int i = 0; i < t->animation.move_count; i++) {
        const sc_verb *verb = &t->moves[i].verb;
        double share;

        if (verb->kind != SC_VERB_ORBIT && verb->kind != SC_VERB_ROCK)
            continue;
        share = sc_progress(verb->begin, verb->end, verb->ease, at);
        if (verb->kind == SC_VERB_ROCK) /* at rest after the last swing, and not by rounding */
            share = share < 1 ? sin(2 * M_PI * verb->times * share) : 0;
        *angle_deg += share * verb->angle_deg;
        *elevation_deg += share * verb->elevation_deg;
    }
}

/* Set distance, away and up of a camera that stands where the job says, but for what verbs do. */
static void set_sight_of_fixed(const sc_timeline *t, double at, sc_sight *out)
{
    const sc_orbit *c = &t->animation.camera;
    sc_vec3 position_mm, target_mm, up, axis;
    double angle_deg = 0, elevation_deg = 0;
    sc_camera camera;

    sc_fixed_camera_at(c, at, &position_mm, &target_mm, &up);
    camera = sc_camera_look(position_mm, target_mm, up, c->projection, 1);
    axis = sc_vec3_unit(c->tracks.up.count ? up : c->up);
    out->distance_mm = sc_vec3_length(sc_vec3_sub(position_mm, target_mm));
    add_swings(t, at, &angle_deg, &elevation_deg);
    out->away = sc_vec3_rotate(sc_vec3_scale(camera.forward, -1), camera.right,
                               -elevation_deg * M_PI / 180);
    out->away = sc_vec3_rotate(out->away, axis, angle_deg * M_PI / 180);
    out->up = sc_vec3_rotate(camera.up, camera.right, -elevation_deg * M_PI / 180);
    out->up = sc_vec3_rotate(out->up, axis, angle_deg * M_PI / 180);
}

sc_sight sc_sight_at(const sc_timeline *t, double k)
{
    const sc_orbit *orbit = &t->animation.camera;
    const double at = sc_frame_time(k, t->animation.frames);
    sc_sight out = {.target_mm = sc_value_at(&orbit->tracks.target, orbit->target_mm, at),
                    .distance_mm = sc_number_at(&orbit->tracks.distance, orbit->distance_mm, at),
                    .tangent =
                        tan(sc_number_at(&orbit->tracks.fov, orbit->fov_deg, at) * M_PI / 360)};
    double turned = 360 * orbit->turns * without_holds(t, k) / t->animation.frames;
    const double angle_deg = sc_number_at(&orbit->tracks.angle, orbit->angle_deg, at);
    double elevation_deg = sc_number_at(&orbit->tracks.elevation, orbit->elevation_deg, at);

    if (orbit->fixed) {
        set_sight_of_fixed(t, at, &out);
        return out;
    }
    add_swings(t, at, &turned, &elevation_deg);
    set_direction(orbit, (angle_deg + turned) * M_PI / 180, elevation_deg, &out);
    return out;
}

/* Does a camera do nothing but turn evenly, or pause? */
static bool turns_only(const sc_timeline *t)
{
    const sc_orbit *orbit = &t->animation.camera;
    bool swings = false;

    for (int i = 0; i < t->animation.move_count; i++)
        swings = swings || t->moves[i].verb.kind == SC_VERB_ORBIT ||
                 t->moves[i].verb.kind == SC_VERB_ROCK;
    return !swings && !orbit->tracks.angle.count && !orbit->tracks.elevation.count &&
           !orbit->tracks.target.count && !orbit->tracks.fov.count;
}

int sc_sights_between(const sc_timeline *timeline, double first, double last,
                      sc_sight out[SC_SIGHTS_MAX])
{
    const double frames = timeline->animation.camera.alone ? 1 : ceil(last - first) + 1;
    const int count = frames < SC_SIGHTS_MAX ? (int)frames : SC_SIGHTS_MAX;

    for (int i = 0; i < count; i++)
        out[i] =
            sc_sight_at(timeline, count > 1 ? first + (last - first) * i / (count - 1) : first);
    return count;
}

int sc_sights_of(const sc_timeline *timeline, sc_sight out[SC_SIGHTS_MAX])
{
    const sc_orbit *orbit = &timeline->animation.camera;
    const bool part = fabs(orbit->turns) < 1;

    if (orbit->fixed || orbit->alone || !turns_only(timeline))
        return sc_sights_between(timeline, 0, timeline->animation.frames - 1, out);
    for (int i = 0; i < ANGLES; i++) {
        const double turn = part ? orbit->turns * i / (ANGLES - 1) : (double)i / ANGLES;

        out[i] = sc_sight_at(timeline, 0);
        set_direction(orbit, orbit->angle_deg * M_PI / 180 + 2 * M_PI * turn, orbit->elevation_deg,
                      &out[i]);
    }
    return ANGLES;
}
