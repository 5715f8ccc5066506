/* SPDX-License-Identifier: BSD-3-Clause */
/* The scene of a frame: one walk over all that changes with time. */
#include "motion.h"

/* @return half the height of the picture (see sc_camera) of a frame, before the zoom. @param sight
 * of that frame. */
static double half_height_at(const sc_timeline *t, const sc_sight *sight)
{
    const sc_orbit *orbit = &t->animation.camera;
    double scale = sight->tangent / tan(orbit->fov_deg * M_PI / 360);

    if (!orbit->tracks.fov.count && !orbit->tracks.distance.count)
        return t->half_height;
    if (orbit->projection != SC_ORTHOGRAPHIC)
        return sight->tangent;
    if (orbit->tracks.distance.count)
        scale *= sight->distance_mm / orbit->tracks.distance.keys[0].value.x;
    return orbit->fixed || orbit->has_distance ? scale * t->half_height : t->half_height;
}

/* A camera on its way. */
typedef struct view {
    sc_sight sight;
    double half_height, zoom; /* the picture shows half_height / zoom */
} view;

/* Move a view towards what a frame asks for. The picture grows or shrinks evenly to the eye, and
 * the target moves with its size, so that what is between the two targets stays in the picture. */
static void go_to_frame(const sc_timeline *t, const sc_move *move, double share, view *v)
{
    const bool is_perspective = t->animation.camera.projection != SC_ORTHOGRAPHIC;
    const double distance_mm = is_perspective ? v->sight.distance_mm : 1;
    const double size = v->half_height / v->zoom * distance_mm;
    const double ratio = move->half_height * (is_perspective ? move->distance_mm : 1) / size;
    const double way = fabs(ratio - 1) > 1e-6 ? (pow(ratio, share) - 1) / (ratio - 1) : share;

    v->sight.target_mm =
        sc_vec3_along(v->sight.target_mm, way, sc_vec3_sub(move->target_mm, v->sight.target_mm));
    v->sight.distance_mm *= pow(move->distance_mm / v->sight.distance_mm, share);
    v->half_height *= pow(move->half_height / v->half_height, share);
    v->zoom *= pow(1 / v->zoom, share);
}

/* Change a view by the verbs zoom, dolly and frame, each from where those before have left it. */
static void apply_moves(const sc_timeline *t, double at, view *v)
{
    for (int i = 0; i < t->animation.move_count; i++) {
        const sc_verb *verb = &t->moves[i].verb;
        const double share = sc_progress(verb->begin, verb->end, verb->ease, at);

        if (share <= 0)
            continue;
        if (verb->kind == SC_VERB_ZOOM)
            v->zoom *= pow(verb->to / v->zoom, share);
        else if (verb->kind == SC_VERB_DOLLY)
            v->sight.distance_mm *= pow(verb->to, share);
        else if (verb->kind == SC_VERB_FRAME)
            go_to_frame(t, &t->moves[i], share, v);
    }
}

/* @return the camera of frame @p k, which need not be whole. @param inside set to whether it flies,
 * @param around_mm then as of sc_scene. */
static sc_camera camera_at(const sc_timeline *t, double k, bool *inside, double *around_mm)
{
    const sc_orbit *orbit = &t->animation.camera;
    const double at = sc_frame_time(k, t->animation.frames);
    view v = {.sight = sc_sight_at(t, k),
              .zoom = sc_number_at(&orbit->tracks.zoom, orbit->zoom, at)};
    sc_vec3 base_mm, position_mm, target_mm, up;
    double half_height;
    sc_camera camera;

    v.half_height = half_height_at(t, &v.sight);
    base_mm = v.sight.target_mm;
    apply_moves(t, at, &v);
    half_height = v.half_height / v.zoom;
    *inside = sc_fly_camera(t, at, v.zoom, &camera, around_mm);
    if (*inside)
        return camera;
    if (orbit->fixed && !t->animation.move_count) {
        sc_fixed_camera_at(orbit, at, &position_mm, &target_mm, &up);
        return sc_camera_look(position_mm, target_mm, up, orbit->projection, half_height);
    }
    if (orbit->projection == SC_ORTHOGRAPHIC && !orbit->fixed) /* rays begin outside of all */
        v.sight.distance_mm =
            orbit->distance_mm + sc_vec3_length(sc_vec3_sub(v.sight.target_mm, base_mm));
    position_mm = sc_vec3_along(v.sight.target_mm, v.sight.distance_mm, v.sight.away);
    return sc_camera_look(position_mm, v.sight.target_mm, v.sight.up, orbit->projection,
                          half_height);
}

/* Let a camera look in all directions, or give it its aperture, and focus it on what the job asks
 * for: on a plane across its direction of view. Of what has a size that is half way between its
 * middle and the side of the box around it which faces the camera: what is seen of it lies there.
 */
static void set_optics(const sc_timeline *t, const sc_scene *scene, sc_camera *camera)
{
    const sc_optics *o = &t->animation.camera.optics;
    const sc_vec3 half = o->half_mm, forward = camera->forward;
    const double reach_mm =
        fabs(half.x * forward.x) + fabs(half.y * forward.y) + fabs(half.z * forward.z);
    sc_vec3 focus_mm = o->focus_mm;

    if (t->animation.camera.projection == SC_EQUIRECTANGULAR) {
        camera->projection = SC_EQUIRECTANGULAR;
        camera->half_height = M_PI / 2;
    }
    if (camera->projection != SC_PERSPECTIVE || !(o->aperture_mm > 0))
        return;
    if (o->focus == SC_FOCUS_TISSUE && scene->offsets_mm)
        focus_mm = sc_vec3_add(focus_mm, scene->offsets_mm[o->tissue]);
    camera->aperture_mm = o->aperture_mm;
    camera->focus_mm =
        fmax(sc_vec3_dot(sc_vec3_sub(focus_mm, camera->position_mm), forward) - reach_mm / 2,
             o->aperture_mm); /* a lens cannot be focused on what lies within it */
}

/* @return the point in which the slices meet at a time. */
static sc_vec3 point_at(const sc_timeline *t, double at)
{
    const sc_slices *slices = &t->animation.slices;

    if (slices->has_point)
        return sc_value_at(&slices->point_track, slices->point_mm, at);
    return sc_vec3_along(t->low_mm, sc_number_at(&slices->share_track, slices->share, at),
                         sc_vec3_sub(t->high_mm, t->low_mm));
}

/* @return whether a plane cuts at a time, 0 to 1. */
static bool is_active(const sc_sweep *sweep, double at)
{
    if (sweep->active_track.count)
        return sc_track_step(&sweep->active_track, at).x > 0;
    return !sweep->has_active || sweep->active;
}

/* @return the span of the exceptions of a plane in which a time lies: before the first key frame
 * its exceptions hold, too. */
static int span_of(const sc_sweep *sweep, double at)
{
    int span = 0;

    while (span + 1 < sweep->except_count && sweep->except_at[span + 1] <= at)
        span++;
    return span;
}

/* Fill in the planes that cut at a time, and which tissues each of them cuts. */
static void set_planes(const sc_timeline *t, double at, sc_scene *scene)
{
    const sc_animation *a = &t->animation;

    scene->clip.mode = a->clip_mode;
    scene->clip.set_count = t->clip_set_count;
    for (int i = 0; i < a->sweep_count; i++) {
        const int span = span_of(&a->sweeps[i], at);

        if (!is_active(&a->sweeps[i], at))
            continue;
        for (int g = 0; g < t->clip_set_count; g++) {
            const bool spares = t->clip_sets[g].spares[i] >> span & 1u;

            scene->clip.sets[g] |= (spares ? 0u : 1u) << scene->clip.count;
        }
        scene->clip.which |= 1u << i;
        scene->clip.planes[scene->clip.count++] = sc_plane_at(t, i, at);
    }
}

/* Fill in the look at a time. */
static void set_look(const sc_timeline *t, double at, sc_scene *scene)
{
    const sc_looks *l = &t->looks;
    const sc_grey_tracks *grey = l->grey;
    sc_look *look = &scene->look;
    const sc_vec3 window = sc_value_at(
        &grey->window_track, (sc_vec3){l->grey_window.level, l->grey_window.width, 0}, at);

    scene->has_look = true;
    look->light = sc_light_at(l->light, l->light_tracks, at);
    sc_find_background(l->background, at, look->background);
    look->grey_caps = sc_number_at(&grey->caps_track, grey->caps, at);
    look->grey_slices = sc_number_at(&grey->slices_track, grey->slices, at);
    look->grey_backdrop = sc_number_at(&grey->backdrop_track, grey->backdrop, at);
    look->grey_window = (sc_grey_window){window.x, window.y};
}

/* Set the colours of the tissues whose values change with time. */
static void set_column_colors(const sc_looks *l, double at, float (*out)[3])
{
    const int count = l->label_count;
    const double where = sc_track_value(l->column_steps, at).x;
    const int from = (int)where, to = from + 1 < l->column_steps->count ? from + 1 : from;
    uint8_t rgb[3];

    for (int id = 1; id < count; id++) {
        if (l->tissues[id].color_by_rule)
            continue;
        sc_color_scale_between(l->scale, l->column_values[from * count + id],
                               l->column_values[to * count + id], where - from, rgb);
        for (int c = 0; c < 3; c++)
            out[id][c] = l->level_linear[rgb[c]];
    }
}

/* Fill in what changes of tissues. */
static void set_tissues(const sc_looks *l, double at, const sc_scene_room *room, sc_scene *scene)
{
    bool fades = false;

    if (l->color_tones || l->column_values)
        scene->colors = (const float(*)[3])room->colors;
    for (int id = 0; id < l->label_count; id++) {
        const sc_tissue *tissue = &l->tissues[id];

        fades = fades || tissue->fade_group;
        if (tissue->color_track)
            sc_track_color(&l->color_tones[tissue->color_track - 1], at, room->colors[id]);
        else
            memcpy(room->colors[id], tissue->rgb_linear, sizeof tissue->rgb_linear);
    }
    if (l->column_values)
        set_column_colors(l, at, room->colors);
    if (fades) {
        sc_fades_at(l, at, room->fades);
        scene->fades = room->fades;
    }
    if (l->shift_count && sc_offsets_at(l, at, room->offsets_mm))
        scene->offsets_mm = room->offsets_mm;
}

sc_scene sc_timeline_scene(const sc_timeline *t, double k, const sc_scene_room *room)
{
    const double at = sc_frame_time(k, t->animation.frames);
    const int frame = (int)floor(k + 0.5);
    sc_scene scene = {.frame = frame, .time = at, .point_mm = point_at(t, at)};

    scene.camera = camera_at(t, k, &scene.inside, &scene.around_mm);
    set_planes(t, at, &scene);
    if (t->looks.light) {
        set_look(t, at, &scene);
        scene.dark_text = sc_find_dark_text(t, frame);
    }
    if (room)
        set_tissues(&t->looks, at, room, &scene);
    set_optics(t, &scene, &scene.camera);
    if (t->looks.divider)
        scene.divider = sc_number_at(t->looks.divider_track, *t->looks.divider, at);
    return scene;
}
