/* SPDX-License-Identifier: BSD-3-Clause */
/* The scene of each frame, from the animation and the extent of the visible tissues. */
#include "framing.h"

#include <string.h>
#include <strings.h>

/* Anatomical words and, in the same order, the directions that they stand for, RAS. */
static const char *const words[] = {"right",    "left",  "anterior", "posterior", "superior",
                                    "inferior", "front", "back",     "head",      "feet"};
static const sc_vec3 directions[] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},  {0, -1, 0}, {0, 0, 1},
                                     {0, 0, -1}, {0, 1, 0},  {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};

const char *const *sc_anatomical_words(size_t *count)
{
    *count = SC_COUNT_OF(words);
    return words;
}

bool sc_anatomical_direction(const char *word, sc_vec3 *out)
{
    for (size_t i = 0; i < SC_COUNT_OF(words); i++) {
        if (!strcasecmp(word, words[i])) {
            *out = directions[i];
            return true;
        }
    }
    return false;
}

double sc_ease_value(sc_ease ease, double u)
{
    switch (ease) {
    case SC_EASE_SMOOTH:
        return u * u * (3 - 2 * u);
    case SC_EASE_IN:
        return u * u;
    case SC_EASE_OUT:
        return u * (2 - u);
    case SC_EASE_LINEAR:
        break;
    }
    return u;
}

double sc_progress(double begin, double end, sc_ease ease, int k, int frames)
{
    const double at = frames > 1 ? (double)k / (frames - 1) : 0;
    const double u = end > begin ? (at - begin) / (end - begin) : at >= begin;

    return sc_ease_value(ease, u < 0 ? 0 : u > 1 ? 1 : u);
}

/* @return a plane position in mm along the normal. @param low and @param high the extent of the
 * visible tissues along it, in mm. */
static double position_mm(const sc_plane_position *position, double low, double high)
{
    return position->percent ? low + position->value / 100 * (high - low) : position->value;
}

void sc_timeline_resolve(const sc_animation *animation, const sc_vec3 *points, size_t point_count,
                         double aspect, sc_timeline *out)
{
    sc_timeline t = {.animation = *animation, .clip_set_count = 1};

    sc_extent(points, point_count, (sc_vec3){1, 0, 0}, &t.low_mm.x, &t.high_mm.x);
    sc_extent(points, point_count, (sc_vec3){0, 1, 0}, &t.low_mm.y, &t.high_mm.y);
    sc_extent(points, point_count, (sc_vec3){0, 0, 1}, &t.low_mm.z, &t.high_mm.z);
    sc_frame_orbit(&t.animation.camera, points, point_count, aspect, &t.half_height);
    for (int i = 0; i < animation->sweep_count; i++) {
        const sc_sweep *sweep = &animation->sweeps[i];
        double low, high;

        sc_extent(points, point_count, sweep->normal, &low, &high);
        t.from_mm[i] = position_mm(&sweep->from, low, high);
        t.to_mm[i] = position_mm(&sweep->to, low, high);
        t.clip_sets[0] |= 1u << i;
    }
    *out = t;
}

/* @return the camera of frame @p k, in [0, frames). */
static sc_camera camera_at(const sc_timeline *t, int k)
{
    const sc_orbit *orbit = &t->animation.camera;
    const sc_ramp *zoom = &orbit->zoom;
    const double factor =
        zoom->from + (zoom->to - zoom->from) *
                         sc_progress(zoom->begin, zoom->end, zoom->ease, k, t->animation.frames);
    const double half_height = t->half_height / factor;
    const double elevation = orbit->elevation_deg * M_PI / 180;
    double angle;
    sc_vec3 away, position;

    if (orbit->fixed)
        return sc_camera_look(orbit->position_mm, orbit->target_mm, orbit->up, orbit->projection,
                              half_height);
    angle = (orbit->start_deg + 360 * orbit->turns * k / t->animation.frames) * M_PI / 180;
    away = sc_vec3_rotate(sc_orbit_reference(orbit->axis), orbit->axis, angle);
    away = sc_vec3_along(sc_vec3_scale(away, cos(elevation)), sin(elevation), orbit->axis);
    position = sc_vec3_along(orbit->target_mm, orbit->distance_mm, away);
    return sc_camera_look(position, orbit->target_mm, orbit->axis, orbit->projection, half_height);
}

sc_vec3 sc_timeline_point(const sc_timeline *timeline, int k)
{
    const sc_slices *slices = &timeline->animation.slices;
    const sc_ramp *ramp = &slices->share;
    const double share =
        ramp->from + (ramp->to - ramp->from) * sc_progress(ramp->begin, ramp->end, ramp->ease, k,
                                                           timeline->animation.frames);

    if (slices->has_point)
        return slices->point_mm;
    return sc_vec3_along(timeline->low_mm, share, sc_vec3_sub(timeline->high_mm, timeline->low_mm));
}

sc_scene sc_timeline_scene(const sc_timeline *timeline, int k)
{
    const sc_animation *a = &timeline->animation;
    sc_scene scene = {.camera = camera_at(timeline, k),
                      .plane_count = a->sweep_count,
                      .clip_mode = a->clip_mode,
                      .clip_set_count = timeline->clip_set_count};

    for (int i = 0; i < a->sweep_count; i++) {
        const sc_sweep *sweep = &a->sweeps[i];
        const double u = sc_progress(sweep->begin, sweep->end, sweep->ease, k, a->frames);

        scene.planes[i].normal = sweep->normal;
        scene.planes[i].offset_mm =
            -(timeline->from_mm[i] + u * (timeline->to_mm[i] - timeline->from_mm[i]));
    }
    memcpy(scene.clip_sets, timeline->clip_sets, sizeof scene.clip_sets);
    return scene;
}
