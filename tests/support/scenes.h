/* SPDX-License-Identifier: BSD-3-Clause */
/* Small scenes for tests that draw. */
#ifndef SC_TEST_SCENES_H
#define SC_TEST_SCENES_H

#include "segcast/phantom.h"
#include "segcast/render.h"
#include "segcast/timeline.h"
#include "shapes.h"

/* A prepared volume with its tissues, and the settings to draw it with. */
typedef struct small_scene {
    sc_volume volume;
    prepared_copy prepared;
    sc_tissue tissues[SC_LABELS_MAX > 64 ? 64 : SC_LABELS_MAX];
    sc_render_settings settings;
} small_scene;

/* The three levels of a pixel of a picture without alpha. */
static inline const uint8_t *pixel(const sc_image *image, int x, int y)
{
    return image->rgb + ((size_t)y * (size_t)image->width_px + (size_t)x) * 3;
}

/* A ball with a radius of 15 in the middle of 41 voxels, for shape_volume. */
static inline int large_ball(double x, double y, double z)
{
    return (x - 20) * (x - 20) + (y - 20) * (y - 20) + (z - 20) * (z - 20) < 225;
}

static inline sc_volume phantom_of(const int size[3])
{
    SC_OWN(sc_phantom_free_at) sc_phantom *phantom = NULL;
    sc_volume volume;

    assert_ok(sc_phantom_new(&quiet, &phantom));
    assert_ok(sc_phantom_volume(&quiet, phantom, size, 2, &volume));
    return volume;
}

static inline sc_volume small_phantom(void)
{
    return phantom_of((const int[3]){59, 41, 61});
}

/* The surface model that make_scene sets. Tests that run for both models change it. */
static sc_surface tested_surface = SC_SURFACE_SMOOTH;

/* A scene in which every tissue has the given opacity. Takes ownership of @p volume. */
static inline small_scene make_scene(sc_volume volume, double opacity)
{
    small_scene s = {
        .volume = volume,
        .prepared = prepare_copy(&volume, 2),
        .settings = {
            .width_px = 90,
            .height_px = 70,
            .surface = tested_surface,
            .skip = SC_SKIP_INTERIOR,
            .sampling.samples = 1,
            .step_voxels = 0.5,
            .caps = true,
            .sampling.everywhere = true,
            .light = {.ambient = 0.36, .key = 0.62, .head = 0.22, .occlusion = 0.8, .edges = 0.5},
            .background = {255, 255, 255},
            .work = {.tile_px = 32, .threads = 1}}};
    const sc_tissue_rule rule = {.pattern = "*", .has.opacity = true, .opacity = opacity};

    sc_transfer_resolve(&s.prepared.view, &rule, 1, SC_OPACITY_PAPER, s.tissues);
    return s;
}

static inline void free_scene(small_scene *s)
{
    sc_free(s->prepared.block);
    sc_volume_clear(&s->volume);
}

/* The timeline of @p a; without frames in it, an orbit of @p frames frames is filled in. */
static inline sc_timeline orbit_of(const sc_renderer *renderer, double aspect, int frames,
                                   sc_animation *a)
{
    sc_timeline t;
    size_t count;
    const sc_vec3 *hull = sc_renderer_hull(renderer, &count);

    if (!a->frames)
        *a = (sc_animation){
            .frames = frames,
            .camera = {
                .axis = {0, 0, 1}, .turns = 1, .elevation_deg = 14, .fov_deg = 30, .zoom = 1}};
    sc_timeline_resolve(a, hull, count, aspect, &t);
    return t;
}

/* Draw one frame. The caller frees the picture; @p stats may be NULL. */
static inline sc_image draw_view(const small_scene *s, const sc_scene *scene,
                                 sc_render_stats *stats)
{
    sc_renderer *r;
    sc_image image;
    sc_render_stats local;

    assert_ok(sc_renderer_new(&quiet, &s->settings, &s->prepared.view, s->tissues, &r));
    assert_ok(sc_renderer_gather(&quiet, r, scene, SC_LIGHT_STAYS, NULL));
    assert_ok(sc_image_init_alpha(&quiet, s->settings.width_px, s->settings.height_px,
                                  s->settings.transparent, &image));
    sc_render_view(r, scene, NULL, NULL, NULL, &image, stats ? stats : &local);
    sc_renderer_free(r);
    return image;
}

/* Draw one frame by every skip method and variant that is built and that this processor can run,
 * with several threads and sizes of tiles; all must draw the same. Where the rivals of leap are not
 * built, they would only draw as interior does, which is of plain C. The caller frees the picture.
 */
static inline sc_image draw_by_all_kernels(const small_scene *scene_of, const sc_scene *scene)
{
    small_scene s = *scene_of;
    sc_image first;

    s.settings.skip = SC_SKIP_NONE;
    first = draw_view(&s, scene, NULL);
    for (sc_skip skip = SC_SKIP_INTERIOR; skip <= SC_SKIP_LEAP; skip++) {
        if (!SC_RIVALS && skip != SC_SKIP_INTERIOR && skip != SC_SKIP_LEAP)
            continue;
        for (int i = 1; sc_cpu_names[i] && (i == 1 || sc_skip_is_wide(skip)); i++) {
            SC_OWN(sc_image_clear) sc_image image = {0};

            if (sc_skip_is_wide(skip) && !sc_cpu_has(sc_cpu_names[i]))
                continue;
            s.settings.skip = skip;
            s.settings.cpu = sc_skip_is_wide(skip) ? sc_cpu_names[i] : NULL;
            s.settings.work.threads = 1 + (int)skip % 3;
            s.settings.work.tile_px = 8 + 13 * i;
            image = draw_view(&s, scene, NULL);
            assert_memory_equal(image.rgb, first.rgb, sc_image_bytes(&image));
        }
    }
    return first;
}

/* @return the scene that shows everything from the front: frame 0 of an orbit. */
static inline sc_scene front_view(const small_scene *s)
{
    sc_animation a = {0};
    sc_renderer *r;
    sc_timeline t;

    assert_ok(sc_renderer_new(&quiet, &s->settings, &s->prepared.view, s->tissues, &r));
    t = orbit_of(r, (double)s->settings.width_px / s->settings.height_px, 8, &a);
    sc_renderer_free(r);
    return sc_timeline_scene(&t, 0, NULL);
}

#endif
