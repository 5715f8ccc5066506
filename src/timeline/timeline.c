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
    sc_sight sights[SC_SIGHTS_MAX];
    const int sight_count = sc_sights_of(animation, sights);
    sc_orbit *camera = &t.animation.camera;

    sc_extent(points, point_count, (sc_vec3){1, 0, 0}, &t.low_mm.x, &t.high_mm.x);
    sc_extent(points, point_count, (sc_vec3){0, 1, 0}, &t.low_mm.y, &t.high_mm.y);
    sc_extent(points, point_count, (sc_vec3){0, 0, 1}, &t.low_mm.z, &t.high_mm.z);
    if (camera->fov_track.count)
        camera->fov_deg = camera->fov_track.keys[0].value.x;
    if (camera->distance_track.count)
        camera->distance_mm = camera->distance_track.keys[0].value.x;
    sc_frame_orbit(camera, sights, sight_count, points, point_count, aspect, &t.half_height);
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

/* @return what the picture is scaled by at frame @p k. */
static double zoom_at(const sc_animation *a, int k)
{
    const sc_ramp *zoom = &a->camera.zoom;

    if (a->camera.zoom_track.count)
        return sc_track_value(&a->camera.zoom_track, sc_frame_time(k, a->frames)).x;
    return zoom->from +
           (zoom->to - zoom->from) * sc_progress(zoom->begin, zoom->end, zoom->ease, k, a->frames);
}

/* @return half the height of the picture (see sc_camera) at frame @p k, before the zoom. @param
 * sight of that frame. */
static double half_height_at(const sc_timeline *t, const sc_sight *sight)
{
    const sc_orbit *orbit = &t->animation.camera;
    double scale = sight->tangent / tan(orbit->fov_deg * M_PI / 360);

    if (!orbit->fov_track.count && !orbit->distance_track.count)
        return t->half_height;
    if (orbit->projection == SC_PERSPECTIVE)
        return sight->tangent;
    if (orbit->distance_track.count)
        scale *= sight->distance_mm / orbit->distance_track.keys[0].value.x;
    return orbit->fixed || orbit->has_distance ? scale * t->half_height : t->half_height;
}

/* @return the camera of frame @p k, in [0, frames). */
static sc_camera camera_at(const sc_timeline *t, int k)
{
    const sc_orbit *orbit = &t->animation.camera;
    const sc_sight sight = sc_sight_at(&t->animation, k);
    const double half_height = half_height_at(t, &sight) / zoom_at(&t->animation, k);
    /* Rays of an orthographic camera begin outside of all tissues. */
    const double distance_mm =
        orbit->projection == SC_PERSPECTIVE ? sight.distance_mm : orbit->distance_mm;

    if (orbit->fixed)
        return sc_camera_look(orbit->position_mm, orbit->target_mm, orbit->up, orbit->projection,
                              half_height);
    return sc_camera_look(sc_vec3_along(sight.target_mm, distance_mm, sight.away), sight.target_mm,
                          sight.up, orbit->projection, half_height);
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
