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

/* @return the value of a number at a time. @param constant it, if the track has no key frames. */
static double number_at(const sc_track *track, double constant, double at)
{
    return track->count ? sc_track_value(track, at).x : constant;
}

sc_sight sc_sight_at(const sc_animation *animation, double k)
{
    const sc_orbit *orbit = &animation->camera;
    const double at = sc_frame_time(k, animation->frames);
    const double turned = orbit->has_angle ? number_at(&orbit->angle_track, orbit->angle_deg, at)
                                           : 360 * orbit->turns * k / animation->frames;
    sc_sight out = {.target_mm = orbit->target_track.count
                                     ? sc_track_value(&orbit->target_track, at)
                                     : orbit->target_mm,
                    .distance_mm = number_at(&orbit->distance_track, orbit->distance_mm, at),
                    .tangent = tan(number_at(&orbit->fov_track, orbit->fov_deg, at) * M_PI / 360)};

    set_direction(orbit, (orbit->start_deg + turned) * M_PI / 180,
                  number_at(&orbit->elevation_track, orbit->elevation_deg, at), &out);
    return out;
}

/* Does a camera do nothing but turn evenly? */
static bool turns_only(const sc_orbit *orbit)
{
    return !orbit->has_angle && !orbit->elevation_track.count && !orbit->target_track.count &&
           !orbit->fov_track.count;
}

int sc_sights_of(const sc_animation *animation, sc_sight out[SC_SIGHTS_MAX])
{
    const sc_orbit *orbit = &animation->camera;
    const bool part = fabs(orbit->turns) < 1, even = turns_only(orbit);
    const int count = even                                ? ANGLES
                      : animation->frames < SC_SIGHTS_MAX ? animation->frames
                                                          : SC_SIGHTS_MAX;

    for (int i = 0; i < count; i++) {
        const double turn = part ? orbit->turns * i / (ANGLES - 1) : (double)i / ANGLES;

        out[i] = sc_sight_at(animation,
                             count > 1 ? (double)i * (animation->frames - 1) / (count - 1) : 0);
        if (even)
            set_direction(orbit, orbit->start_deg * M_PI / 180 + 2 * M_PI * turn,
                          orbit->elevation_deg, &out[i]);
    }
    return count;
}
