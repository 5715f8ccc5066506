/* SPDX-License-Identifier: BSD-3-Clause */
#include "internal.h"

/* Kept parts of the ray per clip group. Distances in mm from the eye come in, from the ray's
 * origin go out. @return false if nothing is kept. */
static bool fill_parts(const sc_renderer *r, const sc_scene *scene, sc_vec3 eye, sc_vec3 direction,
                       double begin, double end, double base, sc_ray *ray)
{
    const double step = r->march.step_mm;
    bool any = false;

    ray->groups = (uint8_t)scene->group_count;
    for (int g = 0; g < scene->group_count; g++) {
        sc_interval kept[2];

        ray->parts[g] = (uint8_t)sc_clip_ray(scene->planes, scene->groups[g], scene->clip_mode, eye,
                                             direction, begin, end, kept);
        for (int i = 0; i < ray->parts[g]; i++) {
            ray->first[g][i] = (int32_t)ceil(kept[i].begin_mm / step - 0.5);
            ray->last[g][i] = (int32_t)ceil(kept[i].end_mm / step - 0.5);
            ray->begin_mm[g][i] = (float)(kept[i].begin_mm - base);
            ray->end_mm[g][i] = (float)(kept[i].end_mm - base);
            ray->cap_plane[g][i] = (int8_t)kept[i].begin_plane;
            any = true;
        }
    }
    return any;
}

bool sc_make_ray(const sc_renderer *r, const sc_scene *scene, const sc_viewport *viewport,
                 double x_px, double y_px, sc_ray *ray)
{
    const sc_render_settings *s = &r->settings;
    /* Samples of the voxel surface lie on a grid that begins at the eye. The smooth one has no
     * grid; its rays begin at the volume, where a float tells 1/30,000 of a voxel. That place must
     * not depend on the skip method, nor on what is visible. */
    const bool from_eye = s->surface == SC_SURFACE_VOXEL;
    const double shift = from_eye ? 1.5 : 1;
    sc_vec3 eye, direction, origin, along;
    double begin = 0, end = 1e12, base;

    sc_camera_ray(&scene->camera, 2 * x_px / viewport->width_px - 1,
                  1 - 2 * y_px / viewport->height_px,
                  (double)viewport->width_px / viewport->height_px, &eye, &direction);
    origin = sc_affine_point(&r->to_voxel, eye);
    along = sc_affine_vector(&r->to_voxel, direction);
    if (!sc_box3_clip_line(&r->whole, origin, along, &begin, &end))
        return false;
    base = from_eye ? 0 : begin;
    if (!sc_box3_clip_line(&r->box, origin, along, &begin, &end))
        return false;
    ray->base_mm = (float)base;
    ray->origin[0] = (float)(origin.x + base * along.x + shift);
    ray->origin[1] = (float)(origin.y + base * along.y + shift);
    ray->origin[2] = (float)(origin.z + base * along.z + shift);
    ray->direction[0] = (float)along.x;
    ray->direction[1] = (float)along.y;
    ray->direction[2] = (float)along.z;
    ray->toward_eye[0] = (float)-direction.x;
    ray->toward_eye[1] = (float)-direction.y;
    ray->toward_eye[2] = (float)-direction.z;
    return fill_parts(r, scene, eye, direction, begin, end, base, ray);
}
