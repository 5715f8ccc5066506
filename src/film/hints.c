/* SPDX-License-Identifier: BSD-3-Clause */
/* Warnings of jobs that can run, but do not make what was probably meant. */
#include "panels.h"

#include <math.h>

/* ---- a zoom that crops ---- */

/* Is a point removed by a clip plane? Only for scenes in which all planes cut all tissues. */
static bool is_clipped(const sc_scene *scene, sc_vec3 p)
{
    for (int i = 0; i < scene->clip.count; i++) {
        if (sc_vec3_dot(scene->clip.planes[i].normal, p) + scene->clip.planes[i].offset_mm < 0)
            return true;
    }
    return false;
}

/* @return how far the points that are not clipped reach, as a multiple of half the picture: above 1
 * some are outside of it. @param step look at every so many points only. */
static double reach_of(const sc_scene *scene, bool clips, double aspect, const sc_vec3 *points,
                       size_t count, size_t step)
{
    const sc_camera *camera = &scene->camera;
    double most = 0;

    for (size_t i = 0; i < count; i += step) {
        const sc_vec3 d = sc_vec3_sub(points[i], camera->position_mm);
        const double depth = sc_vec3_dot(d, camera->forward);
        const double scale =
            camera->half_height * (camera->projection == SC_PERSPECTIVE ? depth : 1);
        double reach;

        if (clips && is_clipped(scene, points[i]))
            continue;
        reach =
            fmax(fabs(sc_vec3_dot(d, camera->right)) / aspect, fabs(sc_vec3_dot(d, camera->up)));
        most = fmax(most, scale > 0 ? reach / scale : HUGE_VAL);
    }
    return most;
}

/* What may be cropped. */
typedef struct shown_points {
    const sc_panel *panel;
    const sc_vec3 *points; /* [count], around the tissues in their places */
    size_t count, step;    /* step: look at every so many points only */
    sc_vec3 *moved;        /* room for the corners of tissues that verbs move; NULL: none moves */
    double aspect;
    bool clips; /* all clip planes cut all tissues */
} shown_points;

/* @return how far everything reaches in frame @p k, as @p scene shows it: see reach_of. */
static double reach_at(const shown_points *shown, const sc_scene *scene, int k)
{
    const double at = sc_frame_time(k, shown->panel->timeline.animation.frames);
    double most =
        reach_of(scene, shown->clips, shown->aspect, shown->points, shown->count, shown->step);

    for (int i = 0; shown->moved && i < shown->panel->group.count; i++) {
        const sc_panel *one = &shown->panel->group.all[i];
        const size_t count = sc_shifts_reach_at(&one->volume, one->looks.shifts,
                                                one->looks.shift_count, at, shown->moved);

        most = fmax(most, reach_of(scene, shown->clips, shown->aspect, shown->moved, count, 1));
    }
    return most;
}

/* Make room for shown_points.moved. Caller owns *out: sc_free. */
static sc_status make_room(const sc_ctx *ctx, const sc_panel_group *group, sc_vec3 **out)
{
    size_t shifts = 0;

    for (int i = 0; i < group->count; i++)
        shifts =
            group->all[i].looks.shift_count > shifts ? group->all[i].looks.shift_count : shifts;
    return shifts ? SC_ALLOC(ctx, 8 * shifts, out) : SC_OK;
}

/* Does a verb bring only a part of what is shown into the picture, on purpose? */
static bool shows_part(const sc_timeline *t)
{
    for (int i = 0; i < t->animation.move_count; i++) {
        if (t->moves[i].verb.kind == SC_VERB_FRAME || t->moves[i].verb.kind == SC_VERB_FLY)
            return true;
    }
    return t->animation.camera.tracks.fov.count > 0;
}

/* Take all zooms out of a timeline, and what verbs do to the distance of the camera. */
static void take_zooms_out(sc_timeline *t)
{
    int kept = 0;

    t->animation.camera.zoom = 1;
    t->animation.camera.tracks.zoom.count = 0;
    for (int i = 0; i < t->animation.move_count; i++) {
        if (t->moves[i].verb.kind != SC_VERB_ZOOM && t->moves[i].verb.kind != SC_VERB_DOLLY)
            t->moves[kept++] = t->moves[i];
    }
    t->animation.move_count = kept;
}

/* @return the verb zoom or dolly that has begun last at frame @p k; NULL if none has. */
static const sc_verb *last_zoom(const sc_timeline *t, int k)
{
    const sc_verb *last = NULL;

    for (int i = 0; i < t->animation.move_count; i++) {
        const sc_verb *verb = &t->moves[i].verb;

        if ((verb->kind == SC_VERB_ZOOM || verb->kind == SC_VERB_DOLLY) &&
            sc_progress(verb->begin, verb->end, verb->ease, sc_frame_time(k, t->animation.frames)) >
                0)
            last = verb;
    }
    return last;
}

/* Tell that what is shown is cropped most in frame @p k, where it reaches @p reach times as far as
 * the picture: as a warning of the zoom of the camera, and without one of a verb, which enlarges a
 * part on purpose. Without a renderer, and of tissues that are moved, only the boxes around them
 * are known. */
static void tell_zoom(const sc_app *app, const shown_points *shown, int k, double reach)
{
    const sc_panel *panel = shown->panel;
    const char *about = panel->renderers && !shown->moved ? "" : "about ";
    const sc_timeline *t = &panel->timeline;
    const sc_verb *verb = last_zoom(t, k);
    const char *where = verb ? verb->where : panel->job.lines.zoom;
    const char *colon = where[0] ? ": " : "";
    const int frame = k + (panel->shot ? panel->shot->span.first : 0);
    const double time_s = (double)frame / panel->job.output.fps;
    const double zoom = t->half_height / sc_timeline_scene(t, k, NULL).camera.half_height;

    if (verb && verb->kind == SC_VERB_DOLLY)
        sc_info(app->ctx,
                "%s%sthe dolly to %.3g shows a part of what is visible, least of all in frame %d "
                "(%.3g s), where all of it reaches %s%.3g times as far as the picture",
                where, colon, verb->to, frame, time_s, about, reach);
    else if (verb)
        sc_info(app->ctx,
                "%s%sthe zoom of %.3g shows a part of what is visible, least of all in frame %d "
                "(%.3g s); up to %s%.3g all of it would be in the picture there",
                where, colon, zoom, frame, time_s, about, floor(100 * zoom / reach) / 100);
    else
        sc_warn(app->ctx,
                "%s%sthe zoom of %.3g crops what is shown, most of all in frame %d (%.3g s); up to "
                "%s%.3g all of it would be in the picture there",
                where, colon, zoom, frame, time_s, about, floor(100 * zoom / reach) / 100);
}

sc_status sc_warn_of_zoom(const sc_app *app, const sc_panel *panel, double aspect,
                          const sc_vec3 *points, size_t count)
{
    enum { FRAMES = 24, POINTS = 20000 }; /* at how many to look; all frames and points are alike */
    static const double rim = 1.005;      /* a reach of less is within the rim of a tissue */
    const sc_timeline *t = &panel->timeline;
    const int frames = t->animation.frames;
    shown_points shown = {.panel = panel,
                          .points = points,
                          .count = count,
                          .step = count / POINTS + 1,
                          .aspect = aspect,
                          .clips =
                              t->animation.clip_mode == SC_CLIP_KEEP && t->clip_set_count == 1};
    SC_OWN(sc_free_at) sc_timeline *plain = NULL;
    double worst = rim;
    SC_OWN(sc_free_at) sc_vec3 *moved = NULL;
    int at = -1;

    if (shows_part(t))
        return SC_OK;
    SC_PASS(make_room(app->ctx, &panel->group, &moved));
    shown.moved = moved;
    SC_PASS(SC_ALLOC(app->ctx, 1, &plain));
    *plain = *t;
    take_zooms_out(plain);
    for (int i = 0; i < FRAMES && i < frames; i++) {
        const int k = frames <= FRAMES ? i : (int)((double)i * (frames - 1) / (FRAMES - 1));
        const sc_scene scene = sc_timeline_scene(t, k, NULL),
                       whole = sc_timeline_scene(plain, k, NULL);
        const double reach = reach_at(&shown, &scene, k);

        /* Without the zoom it would fit. */
        if (reach > worst && reach_at(&shown, &whole, k) <= rim) {
            worst = reach;
            at = k;
        }
    }
    if (at >= 0)
        tell_zoom(app, &shown, at, worst);
    return SC_OK;
}

/* ---- a wide picture of a long body ---- */

void sc_tell_shape(const sc_app *app, const sc_panel *panel)
{
    static const double least = 1.5; /* times as high as wide */
    const sc_timeline *t = &panel->timeline;
    const sc_camera camera = sc_timeline_scene(t, 0, NULL).camera;
    const sc_vec3 size = sc_vec3_sub(t->high_mm, t->low_mm);
    const sc_vec3 level = sc_vec3_cross(camera.right, t->animation.camera.axis);
    const sc_vec3 sides[] = {camera.up, camera.right, level};
    double extent[3]; /* of the box, in these directions */

    for (int i = 0; i < 3; i++)
        extent[i] =
            fabs(sides[i].x) * size.x + fabs(sides[i].y) * size.y + fabs(sides[i].z) * size.z;
    if (!t->animation.camera.alone) /* of a film that turns, every side */
        extent[1] = fmax(extent[1], extent[2]);
    if (panel->shot || panel->group.count > 1 || panel->job.output.layout != SC_LAYOUT_PICTURE ||
        panel->job.output.size_px[0] <= panel->job.output.size_px[1] || t->animation.camera.fixed ||
        extent[0] < least * extent[1])
        return;
    sc_info(app->ctx,
            "what is visible is %.1f times as high as wide: with --size vertical (output.size: "
            "vertical) it would be shown larger",
            extent[0] / extent[1]);
}

/* ---- tissues that are hardly seen ---- */

void sc_tell_thin(const sc_app *app, const sc_panel *panel)
{
    const sc_timeline *t = &panel->timeline;
    const sc_camera camera = sc_timeline_scene(t, 0, NULL).camera;
    const sc_vec3 middle = sc_vec3_scale(sc_vec3_add(t->low_mm, t->high_mm), 0.5);
    const double depth = sc_vec3_dot(sc_vec3_sub(middle, camera.position_mm), camera.forward);
    const double height_mm =
        2 * camera.half_height * (camera.projection == SC_PERSPECTIVE ? depth : 1);
    const double pixel_mm = height_mm / panel->job.output.size_px[1];
    const sc_label *label = NULL;
    int count = 0;

    if (panel->job.output.layout != SC_LAYOUT_PICTURE || panel->group.count > 1 || shows_part(t))
        return;
    for (int i = 1; i < panel->volume.label_count; i++) {
        const sc_tissue *tissue = &panel->looks.tissues[i];
        const double width_mm = 2 * panel->volume.stats[i].thickness_mm; /* of a rod; 0: unknown */

        if (tissue->visible && tissue->opacity > 0 && width_mm > 0 && width_mm < pixel_mm &&
            !count++)
            label = &panel->volume.labels[i];
    }
    if (count)
        sc_info(app->ctx,
                "%d tissue%s thinner than a pixel, which is %.3g mm wide, and hardly seen, such as "
                "\"%s\" (label %lld): in a larger picture (--size), or where it alone is framed "
                "(--tissue), more is seen of it",
                count, count > 1 ? "s are" : " is", pixel_mm, label->name, (long long)label->value);
}

/* ---- tissues that are hidden by their names ---- */

void sc_tell_rests(const sc_app *app, const sc_panel *panel)
{
    for (int i = 1; i < panel->volume.label_count; i++) {
        const sc_label *label = &panel->volume.labels[i];

        if (panel->looks.tissues[i].is_rest)
            sc_info(app->ctx,
                    "\"%s\" (label %lld) is hidden, because its name calls it left over: 'tissues: "
                    "{%lld: {visible: true}}' shows it",
                    label->name, (long long)label->value, (long long)label->value);
    }
}

/* ---- warnings of clip planes that cut nothing or everything ---- */

/* Find the extent of a box along the unit vector @p n. */
static void range_along(sc_vec3 n, sc_vec3 low, sc_vec3 high, double *from_mm, double *to_mm)
{
    const sc_vec3 near = {n.x > 0 ? low.x : high.x, n.y > 0 ? low.y : high.y,
                          n.z > 0 ? low.z : high.z};
    const sc_vec3 far = {n.x > 0 ? high.x : low.x, n.y > 0 ? high.y : low.y,
                         n.z > 0 ? high.z : low.z};

    *from_mm = sc_vec3_dot(n, near);
    *to_mm = sc_vec3_dot(n, far);
}

/* In how many frames a plane removes all of what is shown, and in how many nothing of it. */
typedef struct plane_effect {
    double from_mm, to_mm; /* extent of what is shown along the plane's normal */
    int removes_all, removes_nothing;
} plane_effect;

/* Fill effects[i] for each plane i. @return in how many frames some plane removes everything.
 * @param first the first of them, and @param which plane it is; not written if there is none. */
static int find_effects(const sc_timeline *t, plane_effect *effects, int *first, int *which)
{
    int empty = 0;

    for (int i = 0; i < t->animation.sweep_count; i++) {
        effects[i] = (plane_effect){0};
        range_along(t->animation.sweeps[i].normal, t->low_mm, t->high_mm, &effects[i].from_mm,
                    &effects[i].to_mm);
    }
    for (int k = 0; k < t->animation.frames && t->animation.sweep_count > 0; k++) {
        const sc_scene scene = sc_timeline_scene(t, k, NULL);
        int remover = -1; /* the first plane that removes everything */
        int at = 0;       /* in the scene, which holds only planes that cut */

        for (int i = 0; i < t->animation.sweep_count; i++) {
            const bool cuts = scene.clip.which & 1u << i;
            const sc_plane *plane = cuts ? &scene.clip.planes[at++] : NULL;
            const double at_mm = plane ? -plane->offset_mm : -HUGE_VAL;
            double from_mm = 0, to_mm = 0;

            if (plane)
                range_along(plane->normal, t->low_mm, t->high_mm, &from_mm, &to_mm);
            effects[i].removes_all += at_mm > to_mm;
            effects[i].removes_nothing += at_mm < from_mm;
            remover = remover < 0 && at_mm > to_mm ? i : remover;
        }
        if (remover >= 0 && empty++ == 0) {
            *first = k;
            *which = remover;
        }
    }
    return empty;
}

/* Is a position of the plane given in mm? A plane at a share of what is shown lies within it and
 * needs no warning. @param sweep as the job has it. */
static bool is_in_mm(const sc_sweep *sweep)
{
    const int count = sweep->at_track.count;

    return !sweep->at.percent || (count && !(sweep->at_track.keys[count - 1].value.y > 0));
}

/* Does another plane have the opposite normal? Then both are sides of a box or slab, and one of
 * them may well lie outside of what is shown. */
static bool has_opposite(const sc_animation *animation, int plane)
{
    const sc_vec3 n = animation->sweeps[plane].normal;

    for (int i = 0; i < animation->sweep_count; i++) {
        if (sc_vec3_length(sc_vec3_add(animation->sweeps[i].normal, n)) < 1e-9)
            return true;
    }
    return false;
}

/* Warn of plane @p plane of a panel: say where it lies and where it should. Its position is
 * measured along its normal, which users mistake for a patient coordinate. @param what what is
 * wrong with it. */
static void tell_position(const sc_app *app, const sc_panel *panel, int plane,
                          const plane_effect *effect, const char *what)
{
    const sc_timeline *t = &panel->timeline;
    const char *where = panel->job.lines.clip[plane];
    const sc_vec3 n = t->animation.sweeps[plane].normal;
    const sc_length_unit unit = sc_length_unit_for((effect->to_mm - effect->from_mm) / 10);
    const sc_track *track = &t->animation.sweeps[plane].at_track;
    const double from_mm = t->at_mm[plane],
                 to_mm = track->count ? track->keys[track->count - 1].value.x : from_mm;
    char at[640]; /* room for two of the longest numbers */

    snprintf(at, sizeof at, "%.1f", sc_no_negative_zero(from_mm / unit.mm, 1));
    if (from_mm != to_mm && !t->animation.sweeps[plane].normal_track.count)
        snprintf(at + strlen(at), sizeof at - strlen(at), " to %.1f",
                 sc_no_negative_zero(to_mm / unit.mm, 1));
    sc_warn(app->ctx,
            "%s%sclip plane %d, at %s %s along its normal (%.3f, %.3f, %.3f), %s: what is shown "
            "lies from %.1f to %.1f %s along that normal; a plane through a point in patient "
            "coordinates, as `segcast still --sheet slices` prints them, is at: [R, A, S]",
            where, where[0] ? ": " : "", plane + 1, at, unit.name, sc_no_negative_zero(n.x, 3),
            sc_no_negative_zero(n.y, 3), sc_no_negative_zero(n.z, 3), what,
            sc_no_negative_zero(effect->from_mm / unit.mm, 1),
            sc_no_negative_zero(effect->to_mm / unit.mm, 1), unit.name);
}

void sc_warn_of_planes(const sc_app *app, const sc_panel *panel)
{
    const sc_timeline *t = &panel->timeline;
    const bool keeps = t->animation.clip_mode == SC_CLIP_KEEP;
    plane_effect effects[SC_PLANES_MAX];
    int first = 0, which = 0;
    const int empty = find_effects(t, effects, &first, &which);
    const char *where = panel->job.lines.clip[which];

    for (int i = 0; i < t->animation.sweep_count; i++) {
        if (!is_in_mm(&panel->job.animation.sweeps[i]))
            continue;
        if (keeps && effects[i].removes_all == t->animation.frames)
            tell_position(app, panel, i, &effects[i], "removes everything");
        else if (effects[i].removes_nothing == t->animation.frames &&
                 !has_opposite(&t->animation, i))
            tell_position(app, panel, i, &effects[i], "removes nothing");
    }
    if (empty && keeps && t->clip_set_count == 1)
        sc_warn(app->ctx,
                "%s%sthe clip plane removes everything in %d frame%s, from frame %d on: they will "
                "be empty",
                where, where[0] ? ": " : "", empty, empty == 1 ? "" : "s",
                first + (panel->shot ? panel->shot->span.first : 0));
}
