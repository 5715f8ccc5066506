/* SPDX-License-Identifier: BSD-3-Clause */
/* Lets the camera and planes follow a hand. To make the session of a job anew takes tens of
 * milliseconds, most of them for framing. While a hand moves, the values that it changes are put
 * into the timeline, and the framing stays; when it rests, the session is made anew. */
#include "desk.h"

#include <stdlib.h>
#include <string.h>

/* @return whether a value of JSON is a number, or a text that holds nothing but one and @p unit. */
static bool read_number(const json_t *value, const char *unit, double *out)
{
    const char *text = json_string_value(value);
    char *end;

    if (json_is_number(value) && !unit[0]) {
        *out = json_number_value(value);
        return true;
    }
    if (!text)
        return false;
    *out = strtod(text, &end);
    return end != text && !strcmp(end, unit);
}

/* @return whether a value is a text such as "[1, 2, 3]". */
static bool read_vector(const json_t *value, sc_vec3 *out)
{
    const char *text = json_string_value(value);
    int used = 0;

    return text && sscanf(text, "[%lf, %lf, %lf]%n", &out->x, &out->y, &out->z, &used) == 3 &&
           used && !text[used];
}

/* Set a number of the camera, unless it has key frames. */
static bool set_number(const sc_track *track, const json_t *value, double *out)
{
    return !track->count && read_number(value, "", out);
}

/* Change a key of the camera. @return false if that is not so simple. */
static bool nudge_camera(sc_orbit *c, const char *key, const json_t *value)
{
    const bool is_free = !c->fixed && c->projection == SC_PERSPECTIVE;

    if (!strcmp(key, "zoom"))
        return set_number(&c->zoom_track, value, &c->zoom);
    if (!strcmp(key, "orbit.angle") && !c->fixed)
        return set_number(&c->angle_track, value, &c->angle_deg);
    if (!strcmp(key, "orbit.elevation") && !c->fixed)
        return set_number(&c->elevation_track, value, &c->elevation_deg);
    if (!strcmp(key, "orbit.distance_mm") && is_free)
        return set_number(&c->distance_track, value, &c->distance_mm);
    if (!strcmp(key, "orbit.target_mm") && is_free && !c->target_track.count)
        return read_vector(value, &c->target_mm);
    if (!strcmp(key, "fixed.target_mm") && c->fixed && !c->target_track.count)
        return read_vector(value, &c->target_mm);
    return !strcmp(key, "fixed.position_mm") && c->fixed && !c->position_track.count &&
           read_vector(value, &c->position_mm);
}

/* @return whether some entry of the list of planes is a box, or may be: then the numbers of the list
 * are not those of planes. */
static bool may_have_box(const sc_desk *desk)
{
    bool found = strstr(desk->plan->text, "box") != NULL;

    for (size_t i = 0; i < desk->steps.now.count; i++)
        found = found || strstr(desk->steps.now.all[i].value, "box");
    return found;
}

/* Change a key of a plane. @param path what follows "animation.clip". */
static bool nudge_plane(sc_timeline *t, const char *path, const json_t *value)
{
    int i = -1, used = 0;
    sc_sweep *sweep;
    sc_vec3 normal;

    if (sscanf(path, "[%d].%n", &i, &used) != 1 || !used || i < 0 || i >= t->animation.sweep_count)
        return false;
    sweep = &t->animation.sweeps[i];
    if (sweep->at_track.count || sweep->normal_track.count)
        return false;
    if (!strcmp(path + used, "at") && read_number(value, " mm", &t->from_mm[i])) {
        t->to_mm[i] = t->from_mm[i];
        return true;
    }
    if (strcmp(path + used, "normal") != 0 || !read_vector(value, &normal) ||
        !(sc_vec3_length(normal) > 0))
        return false;
    sweep->normal = sc_vec3_unit(normal);
    return true;
}

/* Change a key. */
static bool nudge(const sc_desk *desk, sc_timeline *t, const char *path, const json_t *value)
{
    static const char camera[] = "animation.camera.", clip[] = "animation.clip";

    if (!strncmp(path, camera, sizeof camera - 1))
        return nudge_camera(&t->animation.camera, path + sizeof camera - 1, value);
    return !strncmp(path, clip, sizeof clip - 1) && !may_have_box(desk) &&
           nudge_plane(t, path + sizeof clip - 1, value);
}

bool sc_desk_nudge(sc_desk *desk, const json_t *pairs)
{
    int frame, shot = -1, used;
    sc_panel *panel = sc_session_panel(desk->now, desk->frame, &frame);
    sc_timeline before = panel->timeline;

    if (desk->now->compare || panel->phases != 1)
        return false;
    for (size_t i = 0; i < json_array_size(pairs); i++) {
        const json_t *pair = json_array_get(pairs, i);
        const char *path = json_string_value(json_array_get(pair, 0));

        used = 0;
        if (path && desk->now->spans && sscanf(path, "shots[%d].%n", &shot, &used) == 1 &&
            shot != (int)(panel - desk->now->panels))
            path = NULL;
        if (!path || (desk->now->spans && !used) ||
            !nudge(desk, &panel->timeline, path + used, json_array_get(pair, 1))) {
            panel->timeline = before;
            return false;
        }
    }
    desk->is_nudged = true;
    return true;
}

void sc_desk_settle(sc_desk *desk)
{
    if (!desk->is_nudged)
        return;
    desk->is_nudged = false;
    if (sc_desk_follow(desk, &desk->steps.now) == SC_OK)
        return;
    if (sc_steps_undo(&desk->steps)) /* a value was none; as before it was set */
        (void)sc_desk_follow(desk, &desk->steps.now);
    desk->revision++;
}
