/* SPDX-License-Identifier: BSD-3-Clause */
/* Makes rays from pixels: from the camera's geometry and the clip planes, in double precision. */
#include "directions.h"
#include "internal.h"

void sc_lens_init(sc_lens *lens, const sc_renderer *r, const sc_scene *scene,
                  const sc_viewport *viewport)
{
    const sc_camera *c = &scene->camera;
    /* Samples of the voxel surface lie at steps from the eye. Rays through the smooth surface begin
     * where they enter the sphere around the volume: from there a float resolves 1/20,000 of a
     * voxel. The beginning must depend neither on the skip method nor on what is visible. */
    const bool from_eye = r->settings.surface == SC_SURFACE_VOXEL;

    *lens = (sc_lens){
        .renderer = r,
        .scene = scene,
        .px_scale = 2 * c->half_height / viewport->height_px,
        .middle_px = {viewport->width_px / 2.0, viewport->height_px / 2.0},
        .from_eye = from_eye,
        .shift = from_eye ? 1.5 : 1,
        .eye = sc_affine_point(&r->space.to_voxel, c->position_mm),
        .forward = sc_affine_vector(&r->space.to_voxel, c->forward),
        .right = sc_affine_vector(&r->space.to_voxel, c->right),
        .up = sc_affine_vector(&r->space.to_voxel, c->up),
    };
}

/* Samples of the voxel surface are numbered from the eye where that is nearer than this number of
 * steps: a float then resolves 1/128 of a step. Rays from farther away begin with a later sample.
 */
#define STEPS_FROM_EYE_MOST 65536.0

/* Fill in clip_sets, part_count and parts of the ray: what each clip set keeps between @p begin
 * and @p end, in mm from the eye. @param eye and direction in RAS mm. @param base distance of
 * the ray's origin from the eye. @return false if nothing is kept. */
static bool fill_parts(const sc_lens *lens, sc_vec3 eye, sc_vec3 direction, double begin,
                       double end, double base, sc_ray *ray)
{
    const sc_scene *scene = lens->scene;
    const double step = lens->renderer->march.step_mm;
    bool any = false;

    ray->clip_sets = (uint8_t)scene->clip.set_count;
    for (int g = 0; g < scene->clip.set_count; g++) {
        sc_interval kept[2];

        if (scene->clip.sets[g]) {
            ray->part_count[g] =
                (uint8_t)sc_clip_ray(scene->clip.planes, scene->clip.sets[g], scene->clip.mode, eye,
                                     direction, begin, end, kept);
        } else { /* no plane cuts these tissues */
            ray->part_count[g] = begin < end;
            kept[0] = (sc_interval){begin, end, -1};
        }
        for (int i = 0; i < ray->part_count[g]; i++) {
            sc_ray_part *part = &ray->parts[g][i];

            part->begin_mm = (float)(kept[i].begin_mm - base);
            part->end_mm = (float)(kept[i].end_mm - base);
            part->cap_plane = (int8_t)kept[i].begin_plane;
            if (lens->from_eye) {
                part->first = (int32_t)ceil((kept[i].begin_mm - base) / step - 0.5);
                part->last = (int32_t)ceil((kept[i].end_mm - base) / step - 0.5);
            }
            any = true;
        }
    }
    return any;
}

/* @return the sum of the directions of the camera, each by its share of the direction of a ray. */
static sc_vec3 sum_of(const sc_sight *s, sc_vec3 forward, sc_vec3 right, sc_vec3 up)
{
    return sc_vec3_scale(
        sc_vec3_along(sc_vec3_along(sc_vec3_scale(forward, s->ahead), s->across, right), s->upward,
                      up),
        s->shorten);
}

/* Let a ray begin at a point of the aperture, and cross the plane in focus where it would from the
 * eye. */
static void look_through_aperture(const sc_camera *c, const sc_aim *aim, sc_sight *s)
{
    s->aside[0] = aim->right * c->aperture_mm / 2;
    s->aside[1] = aim->up * c->aperture_mm / 2;
    s->across -= s->aside[0] / c->focus_mm;
    s->upward -= s->aside[1] / c->focus_mm;
}

/* Turn longitude and latitude of a line of sight, in radians, into shares of its direction. */
static void look_around(sc_sight *s)
{
    double east, ahead, up, level;

    sc_sine_cosine(s->across, &east, &ahead);
    sc_sine_cosine(s->upward, &up, &level);
    s->across = level * east;
    s->ahead = level * ahead;
    s->upward = up;
}

sc_sight sc_line_of_sight(const sc_lens *lens, const sc_aim *aim)
{
    const sc_camera *c = &lens->scene->camera;
    sc_sight s = {.across = (aim->x_px - lens->middle_px[0]) * lens->px_scale,
                  .upward = (lens->middle_px[1] - aim->y_px) * lens->px_scale,
                  .ahead = 1,
                  .shorten = 1,
                  .eye_mm = c->position_mm,
                  .direction = c->forward};

    if (c->projection == SC_ORTHOGRAPHIC) {
        s.aside[0] = s.across;
        s.aside[1] = s.upward;
    } else if (c->projection == SC_EQUIRECTANGULAR) {
        look_around(&s);
        s.direction = sum_of(&s, c->forward, c->right, c->up);
    } else {
        if (c->aperture_mm > 0)
            look_through_aperture(c, aim, &s);
        s.shorten = 1 / sqrt(1 + s.across * s.across + s.upward * s.upward);
        s.direction = sum_of(&s, c->forward, c->right, c->up);
    }
    s.eye_mm = sc_vec3_along(sc_vec3_along(s.eye_mm, s.aside[0], c->right), s.aside[1], c->up);
    return s;
}

/* As sc_make_ray_from. @param origin, along the point and the direction in voxels. */
static bool make_ray(const sc_lens *lens, sc_vec3 eye, sc_vec3 direction, sc_vec3 origin,
                     sc_vec3 along, sc_ray *ray)
{
    const double radius = lens->renderer->space.radius_mm, step = lens->renderer->march.step_mm;
    double middle, begin, base;
    sc_vec3 beside;

    /* The ray lies within the sphere around the volume between these distances, or in less. */
    beside = sc_vec3_sub(lens->renderer->space.middle_mm, eye);
    middle = sc_vec3_dot(beside, direction);
    beside = sc_vec3_along(beside, -middle, direction);
    if (middle + radius <= 0 || sc_vec3_dot(beside, beside) > radius * radius)
        return false;
    begin = fmax(middle - radius, 0);
    base = begin;
    if (lens->from_eye)
        base = begin > STEPS_FROM_EYE_MOST * step ? floor(begin / step) * step : 0;
    ray->base_mm = (float)base;
    ray->ends_below = 0;
    ray->origin[0] = (float)(origin.x + base * along.x + lens->shift);
    ray->origin[1] = (float)(origin.y + base * along.y + lens->shift);
    ray->origin[2] = (float)(origin.z + base * along.z + lens->shift);
    ray->direction[0] = (float)along.x;
    ray->direction[1] = (float)along.y;
    ray->direction[2] = (float)along.z;
    ray->toward_eye[0] = (float)-direction.x;
    ray->toward_eye[1] = (float)-direction.y;
    ray->toward_eye[2] = (float)-direction.z;
    return fill_parts(lens, eye, direction, begin, middle + radius, base, ray);
}

bool sc_make_ray(const sc_lens *lens, const sc_aim *aim, sc_ray *ray)
{
    const sc_sight sight = sc_line_of_sight(lens, aim);
    const sc_vec3 origin = sc_vec3_along(sc_vec3_along(lens->eye, sight.aside[0], lens->right),
                                         sight.aside[1], lens->up);
    const sc_vec3 along = lens->scene->camera.projection == SC_ORTHOGRAPHIC
                              ? lens->forward
                              : sum_of(&sight, lens->forward, lens->right, lens->up);

    return make_ray(lens, sight.eye_mm, sight.direction, origin, along, ray);
}

bool sc_make_ray_from(const sc_lens *lens, const sc_line *line, sc_ray *ray)
{
    const sc_affine *to_voxel = &lens->renderer->space.to_voxel;

    if (!make_ray(lens, line->from_mm, line->direction, sc_affine_point(to_voxel, line->from_mm),
                  sc_affine_vector(to_voxel, line->direction), ray))
        return false;
    ray->ends_below = line->ends_below;
    return true;
}
