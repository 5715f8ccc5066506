/* SPDX-License-Identifier: BSD-3-Clause */
/* Lets the camera and planes follow a hand. To make the session of a job anew takes tens of
 * milliseconds, most of them for framing. While a hand moves, the job is read and checked, and what
 * it says of camera and planes is put into the timeline as it is, with the framing that there is;
 * when the hand rests, the session is made anew. */
#include "desk.h"

/* @return whether changes are of camera and planes alone. */
static bool are_simple(const json_t *pairs)
{
    for (size_t i = 0; i < json_array_size(pairs); i++) {
        const char *path = json_string_value(json_array_get(json_array_get(pairs, i), 0));

        if (!path || (!strstr(path, "animation.camera.") && !strstr(path, "animation.clip[")))
            return false;
    }
    return true;
}

/* Put the camera of a job into a timeline. @return false if its framing would be another one. */
static bool take_camera(const sc_orbit *from, sc_orbit *to)
{
    const sc_orbit old = *to;

    if (from->fixed != old.fixed || from->projection != SC_PERSPECTIVE ||
        old.projection != SC_PERSPECTIVE || from->tracks.fov.count || old.tracks.fov.count ||
        from->tracks.distance.count || old.tracks.distance.count || from->fov_deg != old.fov_deg)
        return false;
    *to = *from;
    if (!from->fixed && !from->has_target)
        to->target_mm = old.target_mm;
    if (!from->has_distance)
        to->distance_mm = old.distance_mm;
    return true;
}

/* Put a plane of a job into a timeline. @param at_mm where it lies there. @return false if
 * that needs the extent of what is visible. */
static bool take_plane(const sc_sweep *from, sc_sweep *to, double *at_mm)
{
    const bool stays = from->at.percent == to->at.percent && from->at.value == to->at.value;

    if (from->at_track.count || from->normal_track.count || to->at_track.count ||
        to->normal_track.count || from->except_count != to->except_count ||
        (from->at.percent && !stays))
        return false;
    if (!from->at.percent)
        *at_mm = from->at.value;
    *to = *from;
    return true;
}

/* Put what an animation says of camera and planes into a timeline. @return false if it is more. */
static bool take(const sc_animation *from, sc_timeline *to)
{
    sc_animation *own = &to->animation;

    if (from->frames != own->frames || from->sweep_count != own->sweep_count ||
        from->clip_mode != own->clip_mode || !take_camera(&from->camera, &own->camera))
        return false;
    for (int i = 0; i < own->sweep_count; i++) {
        if (!take_plane(&from->sweeps[i], &own->sweeps[i], &to->at_mm[i]))
            return false;
    }
    return true;
}

sc_status sc_desk_nudge(sc_desk *desk, const json_t *pairs, const sc_edits *edits, bool *done)
{
    SC_OWN(sc_job_clear) sc_job job = {0};
    int frame;
    sc_panel *panel = sc_session_panel(desk->sessions.now, desk->frame, &frame);
    const size_t shot = (size_t)(panel - desk->sessions.now->panels);
    sc_timeline before = panel->timeline;

    *done = false;
    if (!are_simple(pairs) || desk->sessions.now->compare || panel->phases != 1)
        return SC_OK;
    SC_PASS(sc_desk_read(desk, edits, &job));
    if (desk->sessions.now->spans && shot >= job.film.shot_count)
        return SC_OK;
    *done = take(desk->sessions.now->spans ? &job.film.shots[shot].job.animation : &job.animation,
                 &panel->timeline);
    if (!*done)
        panel->timeline = before;
    desk->sessions.is_nudged = desk->sessions.is_nudged || *done;
    return SC_OK;
}

void sc_desk_settle(sc_desk *desk)
{
    const bool is_lit = desk->sessions.is_lit; /* moves of the camera leave light as it is */

    if (!desk->sessions.is_nudged)
        return;
    desk->sessions.is_nudged = false;
    if (sc_desk_follow(desk, &desk->steps.now) == SC_OK) {
        desk->sessions.is_lit = is_lit;
        return;
    }
    if (sc_steps_go(&desk->steps, true)) /* such a job has no pictures: as before the hand moved */
        (void)sc_desk_follow(desk, &desk->steps.now);
    desk->revision++;
}
