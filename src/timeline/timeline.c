/* SPDX-License-Identifier: BSD-3-Clause */
/* An animation that is resolved: placed by the extent of the visible tissues. */
#include "framing.h"

#include <strings.h>

#define WORD(word, order) word,
#define ORDER(word, order) SC_ORDER_##order,
static const char *const words[] = {SC_DIRECTION_WORDS(WORD)};
static const sc_verb_order orders[] = {SC_DIRECTION_WORDS(ORDER)};

const char *const *sc_anatomical_words(size_t *count)
{
    *count = SC_COUNT_OF(words);
    return words;
}

sc_vec3 sc_order_direction(sc_verb_order order)
{
    static const sc_vec3 directions[] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                         {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};

    return directions[order - SC_ORDER_RIGHT];
}

bool sc_anatomical_direction(const char *word, sc_vec3 *out)
{
    for (size_t i = 0; i < SC_COUNT_OF(words); i++) {
        if (!strcasecmp(word, words[i])) {
            *out = sc_order_direction(orders[i]);
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

/* Copy the moves of @p animation into @p t, by the time at which they begin; those that begin at
 * the same time stay in their order. */
static void sort_moves(const sc_animation *animation, sc_timeline *t)
{
    for (int i = 0; i < animation->move_count; i++) {
        int at = i;

        for (; at > 0 && t->moves[at - 1].verb.begin > animation->moves[i].verb.begin; at--)
            t->moves[at] = t->moves[at - 1];
        t->moves[at] = animation->moves[i];
    }
    t->animation.moves = NULL;
    t->animation.framed = NULL;
}

/* Fill in where move @p i, a frame, brings the camera: so that its tissues fill the picture, and
 * stay in it, until the next one begins. The camera comes no nearer than it stands before, where
 * that is enough: it would often come to stand within other tissues. */
static void place_frame(const sc_timeline *t, double aspect, int i, sc_move *move)
{
    const int last_frame = t->animation.frames - 1;
    const sc_orbit *camera = &t->animation.camera;
    sc_orbit orbit = *camera;
    double until = 1;
    sc_sight sights[SC_SIGHTS_MAX];
    int count;

    for (int next = t->animation.move_count - 1; next > i; next--)
        until = t->moves[next].verb.kind == SC_VERB_FRAME ? t->moves[next].verb.begin : until;
    count = sc_sights_between(t, move->verb.begin * last_frame, until * last_frame, sights);
    if (orbit.fixed)
        orbit.axis = sc_vec3_unit(orbit.up);
    orbit.fixed = orbit.has_target = orbit.has_distance = false;
    orbit.tracks.target.count = 0;
    sc_frame_orbit(&orbit, sights, count, move->points, move->point_count, aspect,
                   &move->half_height);
    move->target_mm = orbit.target_mm;
    move->distance_mm =
        fmax(orbit.distance_mm, camera->fixed ? sights[0].distance_mm : camera->distance_mm);
    if (orbit.projection != SC_ORTHOGRAPHIC && move->point_count)
        move->half_height = sc_fit_height(sights, count, move->target_mm, move->distance_mm,
                                          move->points, move->point_count, aspect);
    move->points = NULL;
}

/* Place the camera: what the job leaves open, and all moves that are frames. */
static void place_camera(const sc_vec3 *points, size_t point_count, double aspect, sc_timeline *t)
{
    sc_orbit *camera = &t->animation.camera;
    sc_sight sights[SC_SIGHTS_MAX];
    const int sight_count = sc_sights_of(t, sights);

    if (camera->tracks.fov.count)
        camera->fov_deg = camera->tracks.fov.keys[0].value.x;
    if (camera->tracks.distance.count)
        camera->distance_mm = camera->tracks.distance.keys[0].value.x;
    sc_frame_orbit(camera, sights, sight_count, points, point_count, aspect, &t->half_height);
    for (int i = 0; i < t->animation.move_count; i++) {
        if (t->moves[i].verb.kind == SC_VERB_FRAME)
            place_frame(t, aspect, i, &t->moves[i]);
        if (t->moves[i].verb.kind == SC_VERB_FLY)
            t->moves[i].half_height = tan(t->moves[i].verb.fly.fov_deg * M_PI / 360);
    }
}

/* @return where a plane lies, in mm, at the time @p at, to which its position holds: see
 * sc_sweep.at_track. */
static double resting_mm(const sc_sweep *sweep, const sc_plane_position *position, double at,
                         const sc_vec3 *points, size_t point_count)
{
    const sc_vec3 normal =
        sweep->normal_track.count ? sc_track_direction(&sweep->normal_track, at) : sweep->normal;
    double low, high, mm;

    sc_extent(points, point_count, normal, &low, &high);
    mm = position_mm(position, low, high);
    return sweep->normal_track.count ? mm - sc_vec3_dot(normal, sweep->point_mm) : mm;
}

/* Turn the key frames of a plane, of which there are some, into mm. One with key frames of its
 * normal alone stays at its place, whatever its normal. */
static void resolve_tracks(const sc_vec3 *points, size_t point_count, sc_vec3 middle_mm,
                           sc_sweep *sweep)
{
    sc_track *track = &sweep->at_track;
    const bool stays = track->count == 0;

    if (!sweep->has_point)
        sweep->point_mm = middle_mm;
    if (stays)
        *track = sweep->normal_track;
    for (int i = 0; i < track->count; i++) {
        const sc_vec3 *value = &track->keys[i].value;
        const sc_plane_position at =
            stays ? sweep->at : (sc_plane_position){.value = value->x, .percent = value->y > 0};

        track->keys[i].value =
            (sc_vec3){stays && sweep->has_point
                          ? 0
                          : resting_mm(sweep, &at, track->keys[i].at, points, point_count),
                      0, 0};
    }
}

/* Fill in where plane @p i lies. */
static void place_plane(const sc_vec3 *points, size_t point_count, int i, sc_timeline *t)
{
    sc_sweep *sweep = &t->animation.sweeps[i];
    const sc_vec3 middle_mm = sc_vec3_scale(sc_vec3_add(t->low_mm, t->high_mm), 0.5);
    double low, high;

    sc_extent(points, point_count, sweep->normal, &low, &high);
    t->at_mm[i] = position_mm(&sweep->at, low, high);
    if (sweep->at_track.count || sweep->normal_track.count)
        resolve_tracks(points, point_count, middle_mm, sweep);
}

void sc_timeline_resolve(const sc_animation *animation, const sc_vec3 *points, size_t point_count,
                         double aspect, sc_timeline *out)
{
    sc_timeline t = {.animation = *animation, .clip_set_count = 1};

    sort_moves(animation, &t);
    sc_extent(points, point_count, (sc_vec3){1, 0, 0}, &t.low_mm.x, &t.high_mm.x);
    sc_extent(points, point_count, (sc_vec3){0, 1, 0}, &t.low_mm.y, &t.high_mm.y);
    sc_extent(points, point_count, (sc_vec3){0, 0, 1}, &t.low_mm.z, &t.high_mm.z);
    place_camera(animation->framed ? animation->framed : points,
                 animation->framed ? animation->framed_count : point_count, aspect, &t);
    for (int i = 0; i < animation->sweep_count; i++)
        place_plane(points, point_count, i, &t);
    if (animation->camera.optics.focus == SC_FOCUS_MIDDLE) {
        t.animation.camera.optics.focus_mm = sc_vec3_scale(sc_vec3_add(t.low_mm, t.high_mm), 0.5);
        t.animation.camera.optics.half_mm = sc_vec3_scale(sc_vec3_sub(t.high_mm, t.low_mm), 0.5);
    }
    *out = t;
}
