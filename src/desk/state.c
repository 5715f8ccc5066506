/* SPDX-License-Identifier: BSD-3-Clause */
/* What pages show of the job, as JSON. */
#include "desk.h"

#include <math.h>

static json_t *of_vector(sc_vec3 v)
{
    return json_pack("[f,f,f]", v.x, v.y, v.z);
}

/* @return the planes that cut in a scene, each with its number in the job. */
static json_t *of_planes(const sc_scene *scene)
{
    json_t *list = json_array();

    for (int i = 0, at = 0; i < SC_PLANES_MAX && at < scene->clip.count; i++) {
        const sc_plane *plane = &scene->clip.planes[at];

        if (!(scene->clip.which >> i & 1u))
            continue;
        json_array_append_new(list,
                              json_pack("{s:i, s:o, s:f}", "index", i, "normal",
                                        of_vector(plane->normal), "offset", plane->offset_mm));
        at++;
    }
    return list;
}

static json_t *of_camera(const sc_camera *c)
{
    return json_pack("{s:o, s:o, s:o, s:o, s:f, s:b}", "position", of_vector(c->position_mm),
                     "right", of_vector(c->right), "up", of_vector(c->up), "forward",
                     of_vector(c->forward), "halfHeight", c->half_height, "orthographic",
                     c->projection == SC_ORTHOGRAPHIC);
}

json_t *sc_desk_view_of(const sc_desk *desk, const sc_scene *scene, bool more)
{
    return json_pack("{s:i, s:b, s:b, s:i, s:o, s:o, s:o}", "revision", (int)desk->revision, "fits",
                     desk->volumes.fit, "more", more, "frame", desk->frame, "camera",
                     of_camera(&scene->camera), "planes", of_planes(scene), "point",
                     of_vector(scene->point_mm));
}

json_t *sc_desk_view(sc_desk *desk, bool more)
{
    int frame;
    sc_panel *panel = sc_session_panel(desk->sessions.now, desk->frame, &frame);
    const sc_scene scene = sc_panel_scene(panel, frame);

    return sc_desk_view_of(desk, &scene, more);
}

/* @return the key by which a job calls a tissue, as a part of a path. */
static json_t *key_of(const sc_prepared *v, int id)
{
    const sc_label *label = &v->labels[id];

    if (sc_label_name_is_clear(v->labels, v->label_count, id) && !strchr(label->name, '"'))
        return json_sprintf("\"%s\"", label->name);
    return json_sprintf("%lld", (long long)label->value);
}

/* @return a colour as CSS writes it. */
static json_t *color_of(const sc_srgb_table *levels, const sc_tissue *tissue)
{
    const float *c = tissue->rgb_linear;

    return json_sprintf("#%02x%02x%02x", sc_srgb_level(levels, c[0]), sc_srgb_level(levels, c[1]),
                        sc_srgb_level(levels, c[2]));
}

/* @return which planes do not cut a tissue: a bit for each. */
static int spared_by(const sc_panel *panel, const sc_tissue *tissue)
{
    int spared = 0;

    for (int i = 0; i < SC_PLANES_MAX && tissue->clip_set < panel->looks.clip_set_count; i++)
        spared |= (panel->looks.clip_sets[tissue->clip_set].spares[i] != 0) << i;
    return spared;
}

/* @return a tissue of a panel. */
static json_t *of_tissue(const sc_panel *panel, const sc_srgb_table *levels, int id)
{
    const sc_prepared *v = &panel->volume;
    const sc_label *label = &v->labels[id];
    const sc_tissue *t = &panel->looks.tissues[id];
    const double ml =
        (double)v->stats[id].voxels * fabs(sc_affine_determinant(&v->to_ras_mm)) / 1e3;
    json_t *name = json_string(label->name);

    if (!name || !label->name[0]) {
        json_decref(name);
        name = json_sprintf("label %lld", (long long)label->value);
    }
    return json_pack("{s:b, s:i, s:o, s:o, s:I, s:o, s:f, s:b, s:b, s:i, s:f, s:f}", "known",
                     v->stats[id].voxels > 0 || !t->visible, "id", id, "name", name, "key",
                     key_of(v, id), "label", (json_int_t)label->value, "color", color_of(levels, t),
                     "opacity", t->opacity, "auto", t->opacity_auto, "visible", t->visible,
                     "spared", spared_by(panel, t), "ml", ml, "mm",
                     (double)v->stats[id].thickness_mm);
}

/* @return the tissues of a panel. Those are known that have voxels, or have lost them because they
 * are hidden; of the others that is known once the volume is prepared as the job asks. */
static json_t *of_tissues(const sc_panel *panel)
{
    json_t *list = json_array();
    sc_srgb_table levels;

    sc_srgb_table_init(&levels);
    for (int id = 1; id < panel->volume.label_count && panel->looks.tissues; id++)
        json_array_append_new(list, of_tissue(panel, &levels, id));
    return list;
}

/* @return numbers of the camera in a frame of a panel, as keys of the job call them. */
static json_t *of_orbit(const sc_panel *panel, int frame)
{
    const sc_orbit *o = &panel->timeline.animation.camera;
    const double at = sc_frame_time(frame, panel->timeline.animation.frames);
    const double turned = 360 * o->turns * frame / panel->timeline.animation.frames;

    return json_pack("{s:f, s:b, s:o, s:f, s:f, s:f, s:o, s:f, s:f, s:f, s:b, s:b}", "turned",
                     o->fixed ? 0 : turned, "fixed", o->fixed, "axis", of_vector(o->axis), "angle",
                     sc_number_at(&o->tracks.angle, o->angle_deg, at), "elevation",
                     sc_number_at(&o->tracks.elevation, o->elevation_deg, at), "turns", o->turns,
                     "target", of_vector(sc_value_at(&o->tracks.target, o->target_mm, at)),
                     "distance", sc_number_at(&o->tracks.distance, o->distance_mm, at), "zoom",
                     sc_number_at(&o->tracks.zoom, o->zoom, at), "fov",
                     sc_number_at(&o->tracks.fov, o->fov_deg, at), "hasTarget", o->has_target,
                     "hasDistance", o->has_distance);
}

/* @return what stands in the job, as it is written there; null after a mistake. */
static json_t *tree_of(sc_desk *desk)
{
    SC_OWN(sc_free_at) sc_setting *settings = NULL;
    SC_OWN(sc_text_clear) sc_text text = {0};
    const sc_edits *edits = &desk->steps.now;
    sc_job_sources sources;

    if (SC_ALLOC(&desk->ctx, edits->count + 1, &settings) != SC_OK)
        return json_null();
    sources = sc_desk_sources(desk, edits, settings);
    if (sc_job_write_tree(&desk->ctx, &sources, &text) != SC_OK)
        return json_null();
    return json_loads(text.data, 0, NULL);
}

/* @return all keys of the job with the values that they have, also by a look or by default; null
 * after a mistake. */
static json_t *values_of(sc_desk *desk)
{
    SC_OWN(sc_text_clear) sc_text text = {0};

    if (sc_job_write_json(&desk->ctx, &desk->sessions.now->job, &text) != SC_OK)
        return json_null();
    return json_loads(text.data, 0, NULL);
}

json_t *sc_desk_state(sc_desk *desk)
{
    int frame;
    sc_panel *panel = sc_session_panel(desk->sessions.now, desk->frame, &frame);
    const sc_job *job = &desk->sessions.now->job;
    const char *path = desk->file.path;

    return json_pack(
        "{s:i, s:s, s:s, s:b, s:b, s:i, s:i, s:i, s:i, s:i, s:i, s:[ii], s:o, s:o, "
        "s:o, s:o, s:o, s:o, s:O, s:b}",
        "revision", (int)desk->revision, "name", sc_file_name(path), "path", path, "isNew",
        desk->file.on_disk == NULL, "unsaved", sc_desk_is_unsaved(desk), "shot",
        (int)(panel - desk->sessions.now->panels), "undo", desk->steps.undo_count, "redo",
        desk->steps.redo_count, "frame", desk->frame, "frames", job->animation.frames, "fps",
        job->output.fps, "size", desk->size_px[0], desk->size_px[1], "job", tree_of(desk), "values",
        values_of(desk), "tissues", of_tissues(panel), "orbit", of_orbit(panel, frame), "low",
        of_vector(panel->timeline.low_mm), "high", of_vector(panel->timeline.high_mm), "notes",
        desk->notes.list, "fits", desk->volumes.fit);
}
