/* SPDX-License-Identifier: BSD-3-Clause */
/* How much of the light of a point inside a tissue reaches the camera, by a ray through voxels: a
 * step along the ray is at most a voxel long, and of each other tissue both sides count. The
 * picture is drawn more finely; for a name it is enough. */
#include "internal.h"

#include <math.h>

#define DARK 0.01 /* less is nothing */

/* A ray from the camera to a point, and the parts of it that clip planes keep. */
typedef struct ray {
    sc_vec3 origin_mm, direction;
    double length_mm;
    sc_interval kept[SC_CLIP_SETS_MAX][2]; /* by clip set */
    int kept_count[SC_CLIP_SETS_MAX];
} ray;

/* @return the part of the ray that the clip planes of a set keep and in which the point at @p t_mm
 * lies, or NULL. */
static const sc_interval *part_at(const ray *r, int set, double t_mm)
{
    for (int i = 0; i < r->kept_count[set]; i++) {
        if (t_mm >= r->kept[set][i].begin_mm && t_mm <= r->kept[set][i].end_mm)
            return &r->kept[set][i];
    }
    return NULL;
}

/* Begin the ray to @p point_mm, which lies before the camera. */
static ray ray_to(const sc_scene *scene, sc_vec3 point_mm)
{
    const sc_camera *c = &scene->camera;
    const double depth_mm = sc_vec3_dot(sc_vec3_sub(point_mm, c->position_mm), c->forward);
    ray r = {.origin_mm = c->position_mm, .direction = c->forward, .length_mm = depth_mm};

    if (c->projection == SC_ORTHOGRAPHIC)
        r.origin_mm = sc_vec3_along(point_mm, -depth_mm, c->forward);
    else {
        r.length_mm = sc_vec3_length(sc_vec3_sub(point_mm, c->position_mm));
        r.direction = sc_vec3_unit(sc_vec3_sub(point_mm, c->position_mm));
    }
    for (int set = 0; set < scene->clip.set_count; set++)
        r.kept_count[set] = sc_clip_ray(scene->clip.planes, scene->clip.sets[set], scene->clip.mode,
                                        r.origin_mm, r.direction, 0, r.length_mm, r.kept[set]);
    return r;
}

/* @return what is left of light that passes one side of a tissue. */
static double passes(const sc_annotations *a, const sc_scene *scene, uint32_t id)
{
    const double fade = scene->fades ? (double)scene->fades[id] : 1;

    return id ? 1 - fmin(1, a->tissues[id].opacity * fade) : 1;
}

/* @return the tissue at a point of the ray, 0 where none is seen. @param at the point in voxels.
 * @param is_cap set to whether the ray enters it there through a cut face. */
static uint32_t tissue_at(const sc_annotations *a, const ray *r, sc_vec3 at, double t_mm,
                          double step_mm, bool *is_cap)
{
    const uint32_t id = sc_id_at_vertex(a->volume, (int)floor(at.x + 1.5), (int)floor(at.y + 1.5),
                                        (int)floor(at.z + 1.5));
    const sc_interval *part;

    *is_cap = false;
    if (!id || !a->tissues[id].visible)
        return 0;
    part = part_at(r, a->tissues[id].clip_set, t_mm);
    *is_cap = part && part->begin_plane >= 0 && t_mm - part->begin_mm < step_mm;
    return part ? id : 0;
}

/* As sc_light_of, with all tissues in their places, but through those of one part alone.
 * @param part -1: through all. */
static double light_through(const sc_annotations *a, const sc_affine *from_ras_mm,
                            const sc_scene *scene, int id, sc_vec3 point_mm, int part)
{
    const bool is_own = part < 0 || a->tissues[id].part == part;
    const ray r = ray_to(scene, point_mm);
    const sc_vec3 begin = sc_affine_point(from_ras_mm, r.origin_mm);
    const sc_vec3 step = sc_affine_vector(from_ras_mm, r.direction); /* voxels for a mm */
    const double step_mm = 1 / fmax(fabs(step.x), fmax(fabs(step.y), fabs(step.z)));
    const sc_box3 box = {{-1, -1, -1},
                         {a->volume->size[0], a->volume->size[1], a->volume->size[2]}};
    double from_mm = 0, to_mm = r.length_mm, light = 1;
    uint32_t before = 0;

    if (is_own && !part_at(&r, a->tissues[id].clip_set, r.length_mm))
        return 0; /* a plane has taken the point away */
    if (!sc_box3_clip_line(&box, begin, step, &from_mm, &to_mm))
        return 1;
    for (double t_mm = from_mm; t_mm < to_mm && light > DARK; t_mm += step_mm) {
        bool is_cap;
        uint32_t now = tissue_at(a, &r, sc_vec3_along(begin, t_mm, step), t_mm, step_mm, &is_cap);
        bool is_other;

        if (part >= 0 && a->tissues[now].part != part)
            now = 0;
        is_other = now && now != (uint32_t)id;
        if (now == before)
            continue;
        if (before != (uint32_t)id)
            light *= passes(a, scene, before);
        if (is_other)
            light *= is_cap && passes(a, scene, now) < 1 ? 0 : passes(a, scene, now);
        before = now;
    }
    return light;
}

double sc_light_of(const sc_annotations *a, const sc_affine *from_ras_mm, const sc_scene *scene,
                   int id, sc_vec3 point_mm)
{
    bool done[SC_PARTS_MAX] = {false};
    double light = 1;

    if (!scene->offsets_mm)
        return light_through(a, from_ras_mm, scene, id, point_mm, -1);
    for (int other = 1; other < a->volume->label_count && light > DARK; other++) {
        const int part = a->tissues[other].part;
        const sc_vec3 offset_mm = scene->offsets_mm[other];
        sc_scene seen = *scene;

        if (done[part])
            continue;
        done[part] = true;
        seen.camera.position_mm = sc_vec3_sub(scene->camera.position_mm, offset_mm);
        light *= light_through(a, from_ras_mm, &seen, id,
                               sc_vec3_add(point_mm, sc_vec3_sub(scene->offsets_mm[id], offset_mm)),
                               part);
    }
    return light;
}
