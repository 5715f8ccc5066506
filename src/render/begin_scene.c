/* SPDX-License-Identifier: BSD-3-Clause */
/* What the rays of a frame meet beside the volume: lamps, depth cue, rims of cut faces and clip
 * planes, from its scene. */
#include "internal.h"

#include <string.h>

/* Width of the dark rims of cut faces, as a share of the height of the picture, but not less than
 * so many pixels, where voxels are larger than that. */
#define RIM_SHARE 0.008
#define RIM_LEAST_PX 4.0

/* The fill light, as a share of the key light, whose shades it softens: 0.1 of the usual 0.76. */
#define FILL_SHARE (5.0 / 38)
/* The least intensity of a sky, which is seen by nobody: shares of it are taken. */
#define SKY_LEAST 1e-6f

/* Within a vessel of known radius: how far the lamp at the eye reaches before its light falls off,
 * in radii, and how much brighter it is than the others together. So a wall beside the camera is as
 * bright as one outside of vessels, and one ten radii ahead can still be seen. */
#define LAMP_RADII 2.0
#define LAMP_GAIN 1.3f

/* Convert a vector to three floats. */
static void to_floats(sc_vec3 v, float out[3])
{
    out[0] = (float)v.x;
    out[1] = (float)v.y;
    out[2] = (float)v.z;
}

/* Where light is gathered or comes by paths, the key light is a lamp that stands to the volume, and
 * what comes from everywhere comes from the sky, which fills the shadows, too. Within a vessel
 * neither is seen. */
static void set_sky(sc_renderer *r, bool inside)
{
    sc_march_light *light = &r->march.light;

    light->sky = light->lamp = 0;
    if ((!r->light.gather && !r->light.traces) || r->hurries || inside)
        return;
    light->sky = fmaxf(light->ambient, SKY_LEAST);
    light->has_map = r->light.sky.map;
    memcpy(light->around, r->light.sky.around, sizeof light->around);
    light->lamp = light->key;
    light->key *= (float)r->light.sky.lamp.mean_cosine;
    light->ambient = light->fill = 0;
    for (int i = 0; i < 3; i++)
        light->key_direction[i] = (float)r->light.sky.lamp.middle[i];
}

/* Set the lamps in r->march.light. The key light stands above the viewer's left shoulder, the fill
 * light low on the right. Within a vessel they would stand behind its wall: there the light at the
 * eye has the strength of all three, and highlights are its; if the radius there is known, its
 * light falls off with it, so that what is far is dark, and the wall tells how far it is. What is
 * blurred for shades and occlusion is wider than many vessels, which would be dark throughout. */
static void set_lamps(sc_renderer *r, const sc_scene *scene)
{
    const sc_camera *c = &scene->camera;
    const sc_lighting *l = scene->has_look ? &scene->look.light : &r->settings.light;
    const sc_vec3 back = sc_vec3_scale(c->forward, -1);
    const bool inside = scene->inside;
    const double fill = l->key * FILL_SHARE;

    r->march.light.ambient = (float)l->ambient;
    r->march.light.edges = (float)l->edges;
    r->march.light.cue = (float)l->depth_cue;
    r->march.light.key = inside ? 0 : (float)l->key;
    r->march.light.fill = inside ? 0 : (float)fill;
    r->march.light.head = (float)(inside ? l->key + fill + l->head : l->head);
    r->march.light.lamp_mm = inside ? (float)(LAMP_RADII * scene->around_mm) : 0;
    if (r->march.light.lamp_mm > 0)
        r->march.light.head *= LAMP_GAIN;
    r->march.light.shadow = inside ? 0 : (float)l->shadows;
    r->march.light.occlusion = inside ? 0 : (float)l->occlusion;
    to_floats(inside
                  ? back
                  : sc_vec3_unit(sc_vec3_along(sc_vec3_along(back, -0.55, c->right), 0.75, c->up)),
              r->march.light.key_direction);
    to_floats(inside
                  ? back
                  : sc_vec3_unit(sc_vec3_along(sc_vec3_along(back, 1.1, c->right), -0.35, c->up)),
              r->march.light.fill_direction);
    sc_lamp_place(&r->light.sky, &l->lamp, c);
    set_sky(r, inside);
}

/* Set the colour behind the tissues, into which depth cueing fades; there may be none. */
static void set_background(sc_renderer *r, const sc_scene *scene)
{
    const sc_render_settings *s = &r->settings;
    const uint8_t *rgb = scene->has_look ? scene->look.background : s->background;

    for (int i = 0; i < 3; i++) {
        const float linear = s->transparent ? 0 : (float)sc_srgb_to_linear(rgb[i] / 255.0);

        r->march.light.cue_rgb[i] = linear;
        r->behind.tone[i] = sqrtf(linear);
        r->behind.empty[i] = sc_srgb_level(&r->srgb, linear);
    }
}

/* Set the distances from the eye between which depth cueing grows: those of the sphere around
 * what is visible. They stay as they are if nothing is. */
static void set_depth_cue(sc_renderer *r, const sc_camera *c)
{
    const sc_box3 *box = &r->bounds.hull_box;
    const sc_vec3 middle = sc_vec3_scale(sc_vec3_add(box->low, box->high), 0.5);
    const sc_vec3 to_middle = sc_vec3_sub(middle, c->position_mm);
    const double radius = sc_vec3_length(sc_vec3_sub(box->high, box->low)) / 2;
    const double depth = c->projection == SC_ORTHOGRAPHIC ? sc_vec3_dot(to_middle, c->forward)
                                                          : sc_vec3_length(to_middle);

    if (!(radius > 0))
        return;
    r->march.light.cue_near_mm = (float)(depth - radius);
    r->march.light.cue_far_mm = (float)(depth + radius);
}

/* Set how wide the rims of cut faces are in r->march: the same share of the height of the picture,
 * however coarse the volume. @param height_px of the picture. */
static void set_rims(sc_renderer *r, const sc_camera *c, int height_px)
{
    const float width = (float)(fmax(RIM_SHARE, RIM_LEAST_PX / height_px) * 2 * c->half_height);
    const bool even = c->projection == SC_ORTHOGRAPHIC;
    double sum_mm = 0;

    for (int i = 0; i < 3; i++)
        sum_mm += sc_vec3_length(sc_affine_column(&r->volume->to_ras_mm, i));
    r->march.voxel_mm = (float)(sum_mm / 3);
    r->march.cut_faces.rim_mm = even ? width : 0;
    r->march.cut_faces.rim_per_mm = even ? 0 : width;
}

/* Set the clip planes and how cut faces are drawn in r->march, from the scene. */
static void set_planes(sc_renderer *r, const sc_scene *scene)
{
    const sc_affine *to_mm = &r->volume->to_ras_mm;
    const sc_vec3 first = sc_affine_point(to_mm, (sc_vec3){-1, -1, -1}); /* grid vertex 0 */

    r->march.planes.count = scene->clip.count;
    r->march.planes.cut_away = scene->clip.mode == SC_CLIP_CUT;
    r->march.cut_faces.only = scene->slice;
    r->march.cut_faces.are_drawn = scene->slice || r->settings.caps;
    for (int i = 0; i < scene->clip.count; i++) {
        const sc_plane *plane = &scene->clip.planes[i];

        to_floats(plane->normal, r->march.planes.normals[i]);
        for (int axis = 0; axis < 3; axis++)
            r->march.planes.equations[i][axis] =
                (float)sc_vec3_dot(plane->normal, sc_affine_column(to_mm, axis));
        r->march.planes.equations[i][3] =
            (float)(sc_vec3_dot(plane->normal, first) + plane->offset_mm);
    }
}

void sc_begin_tissues(sc_renderer *r, const sc_scene *scene)
{
    sc_set_fades(r, scene->fades);
    sc_set_colors(r, scene->colors);
    sc_set_clip_sets(r, scene);
}

void sc_begin_scene(sc_renderer *r, const sc_scene *scene, int height_px)
{
    set_lamps(r, scene);
    set_background(r, scene);
    set_depth_cue(r, &scene->camera);
    set_rims(r, &scene->camera, height_px);
    set_planes(r, scene);
    sc_set_grey(r, scene);
    r->light.floor.is_shown = r->settings.floor && r->march.light.sky > 0 && !scene->slice;
}
