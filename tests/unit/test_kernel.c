/* SPDX-License-Identifier: BSD-3-Clause */
/* The accelerated kernels must give the same bits as the plain march, which does not use the
 * results of preprocessing. */
#include "check.h"
#include "compare_images.h"

#include "random_fields.h"
#include "scenes.h"

#include <math.h>

static int speckles(double x, double y, double z)
{
    uint64_t seed =
        1 + (uint64_t)(x / 5) * 7919 + (uint64_t)(y / 3) * 104729 + (uint64_t)(z / 4) * 1299709;

    random_bits(&seed);
    return (int)((random_bits(&seed) >> 40) % 9) % 6;
}

static void expect_same(sc_image *a, sc_image *b)
{
    image_difference d;

    assert_true(compare_images(a, b, &d));
    assert_int_equal(d.differing_px, 0);
}

static bool is_blank(const sc_image *image)
{
    for (size_t i = 0; i < sc_image_bytes(image); i++) {
        if (image->rgb[i] != 255)
            return false;
    }
    return true;
}

/* A camera at a random position, sometimes inside the volume, sometimes looking along an axis or
 * within a plane of the grid. */
static sc_scene random_scene(uint64_t *seed, int n, sc_vec3 middle)
{
    const sc_vec3 axes[3] = {{60, 0, 0}, {0, -60, 0}, {0, 0, 60}};
    sc_vec3 from = {random_real(seed, -60, 60), random_real(seed, -60, 60),
                    random_real(seed, -60, 60)};
    sc_scene scene = {
        .clip.count = n % 4, .clip.mode = n & 1 ? SC_CLIP_CUT : SC_CLIP_KEEP, .clip.set_count = 2};

    if (n % 5 == 0)
        from = axes[n % 3];
    if (n % 7 == 0)
        from = sc_vec3_scale(from, 0.1); /* inside the volume */
    scene.camera = sc_camera_look(sc_vec3_add(middle, from), middle, (sc_vec3){0, 0.1, 1},
                                  n % 3 ? SC_PERSPECTIVE : SC_ORTHOGRAPHIC, n % 3 ? 0.5 : 21);
    for (int i = 0; i < scene.clip.count; i++) {
        const sc_vec3 normal = {random_real(seed, -1, 1), random_real(seed, -1, 1),
                                n % 6 == 0 ? 0 : random_real(seed, -1, 1)};

        scene.clip.planes[i].normal = sc_vec3_unit(normal);
        scene.clip.planes[i].offset_mm =
            random_real(seed, -8, 8) - sc_vec3_dot(scene.clip.planes[i].normal, middle);
    }
    scene.clip.sets[0] = (1u << scene.clip.count) - 1;
    scene.clip.sets[1] = scene.clip.sets[0] & 1;
    return scene;
}

/* Draw by the wide method @p skip with every variant that this processor can run: the picture must
 * be @p expected, and the counters must be equal. @param work that of SC_SKIP_INTERIOR. @param most
 * steps that the method may take. */
static void expect_all_variants_to_agree(small_scene *s, const sc_scene *scene, sc_skip skip,
                                         sc_image *expected, const sc_march_counters *work,
                                         uint64_t most)
{
    sc_march_counters first = {0};

    s->settings.skip = skip;
    for (int i = 1; sc_cpu_names[i]; i++) {
        sc_render_stats stats;
        sc_image image;

        if (!sc_cpu_has(sc_cpu_names[i]))
            continue;
        s->settings.cpu = sc_cpu_names[i];
        image = draw_view(s, scene, &stats);
        expect_same(expected, &image);
        sc_image_clear(&image);
        assert_int_equal(stats.counters.contributions, work->contributions);
        assert_true(stats.counters.cell_visits + stats.counters.brick_steps <= most);
        if (first.rays)
            assert_memory_equal(&stats.counters, &first, sizeof first);
        first = stats.counters;
    }
    s->settings.cpu = NULL;
}

/* Draw with rays that go on behind what is opaque: the picture must be @p expected. @param fast the
 * work of SC_SKIP_INTERIOR with rays that end. @return whether the others met more. */
static bool meet_more_to_the_end(small_scene *s, const sc_scene *scene, sc_image *expected,
                                 const sc_march_counters *fast)
{
    sc_render_stats stats;
    sc_image image;

    s->settings.sampling.to_the_end = true;
    s->settings.skip = SC_SKIP_INTERIOR;
    image = draw_view(s, scene, &stats);
    expect_same(expected, &image);
    sc_image_clear(&image);
    assert_true(stats.counters.contributions >= fast->contributions);
    assert_true(stats.counters.cell_visits >= fast->cell_visits);
    expect_all_variants_to_agree(s, scene, SC_SKIP_LEAP, expected, &stats.counters,
                                 stats.counters.cell_visits);
    s->settings.sampling.to_the_end = false;
    return stats.counters.contributions > fast->contributions;
}

TEST(all_skip_methods_and_variants_give_the_same_bits)
{
    const int size[3] = {37, 26, 31};
    const double spacing[3] = {1, 1.3, 0.8};
    uint64_t seed = 23;
    int blank = 0, more = 0;

    for (int n = 0; n < 11 * 24; n += 11) { /* all remainders of what n is divided by below */
        small_scene s =
            make_scene(shape_volume(size, spacing, 1 + n / 2 % 2, 6, speckles), n % 4 ? 0.4 : 1);
        const sc_scene scene = random_scene(&seed, n, (sc_vec3){18, 17, 12.4});
        sc_render_stats plain, fast;
        sc_image a, b;

        if (n % 3 != 1) {
            sc_free(s.prepared.block);
            s.prepared = prepare_random_fields(&s.volume, (uint64_t)n);
        }
        s.settings.surface = n % 2 ? SC_SURFACE_VOXEL : SC_SURFACE_SMOOTH;
        s.settings.cap_outline = n % 9 ? 0 : 0.7;
        s.settings.light.shadows = n % 5 == 1;
        s.settings.light.depth_cue = n % 5 == 2 ? 0.5 : 0;
        s.settings.sampling.everywhere = n % 3 != 0;
        s.settings.sampling.samples = 1 + n % 4;
        s.settings.step_voxels = n % 3 ? 0.5 : 0.83;
        s.settings.caps = n % 8 != 0;
        for (int id = 1; id < 6; id++) {
            s.tissues[id].visible = (n + id) % 5 != 0;
            s.tissues[id].interior_opacity = (n + id) % 3 ? 0 : 0.02;
            s.tissues[id].clip_set = id == 4;
        }
        s.settings.skip = SC_SKIP_NONE;
        a = draw_view(&s, &scene, &plain);
        s.settings.skip = SC_SKIP_INTERIOR;
        b = draw_view(&s, &scene, &fast);
        expect_same(&a, &b);
        assert_int_equal(plain.counters.contributions, fast.counters.contributions);
        assert_true(fast.counters.cell_visits <= plain.counters.cell_visits);
        /* leap, and one of the others. Distances of cells say less than masks of bricks where
         * bricks are empty only just. */
        for (sc_skip skip = SC_SKIP_OCTREE; skip <= SC_SKIP_LEAP; skip++) {
            if (skip == SC_SKIP_LEAP || n / 8 % 3 == (int)(skip - SC_SKIP_OCTREE))
                expect_all_variants_to_agree(&s, &scene, skip, &a, &fast.counters,
                                             sc_skip_has_cell_distances(skip)
                                                 ? plain.counters.cell_visits
                                                 : fast.counters.cell_visits);
        }
        if (n % 3 == 0 && meet_more_to_the_end(&s, &scene, &a, &fast.counters))
            more++;
        blank += is_blank(&a);
        sc_image_clear(&a);
        sc_image_clear(&b);
        free_scene(&s);
    }
    assert_true(blank < 9);
    assert_true(more > 3);
}

/* Columns of a picture that are drawn alone, in a part of an image, are those of the whole, and
 * nothing else is written. */
TEST(columns_alone_are_those_of_the_whole)
{
    SC_OWN(free_scene) small_scene s = make_scene(small_phantom(), 0.5);
    const sc_scene scene = front_view(&s);
    const int width = s.settings.width_px, height = s.settings.height_px, border = 5;
    const int ends[] = {0, 37, 38, width / 2 + 3, width};
    const sc_image first = draw_view(&s, &scene, NULL);
    const sc_viewport view = {border, border, width, height};
    sc_render_stats stats;
    uint64_t rays = 0, all;
    sc_renderer *r;
    SC_OWN(sc_image_clear) sc_image image = {0};

    assert_ok(sc_renderer_new(&quiet, &s.settings, &s.prepared.view, s.tissues, &r));
    assert_ok(sc_image_init(&quiet, width + 2 * border, height + 2 * border, &image));
    sc_render_view(r, &scene, &view, NULL, NULL, &image, &stats);
    all = stats.counters.rays;
    memset(image.rgb, 7, sc_image_bytes(&image));
    for (size_t i = 0; i + 1 < SC_COUNT_OF(ends); i++) {
        const sc_columns_px columns = {border + ends[i], border + ends[i + 1]};

        sc_render_view(r, &scene, &view, &columns, NULL, &image, &stats);
        assert_true(stats.counters.rays < all);
        rays += stats.counters.rays;
        for (int y = 0; y < height; y++) {
            const uint8_t *row = pixel(&image, border, border + y);

            assert_memory_equal(row, pixel(&first, 0, y), 3 * (size_t)ends[i + 1]);
            for (int x = 3 * ends[i + 1]; x < 3 * (width + border); x++)
                assert_int_equal(row[x], 7);
        }
    }
    assert_true(rays >= all);
    sc_render_view(r, &scene, &view, &(sc_columns_px){0, border}, NULL, &image, &stats);
    assert_int_equal(stats.counters.rays, 0);
    sc_renderer_free(r);
    sc_image_clear(&(sc_image){.rgb = first.rgb});
}

/* The counters depend on the scene alone: if they change, the method has changed. */
TEST(the_counted_work_of_known_frames_does_not_change)
{
    /* rays, cell visits, brick steps, contributions; the last bit of a cosine may change them a
     * little */
    static const uint64_t known[][4] = {
        {4112, 22162, 14295, 1880},
        {4368, 19784, 15243, 1852},
        {9631, 64200, 31879, 5939},
        {11463, 273088, 54963, 56131},
        {4112, 145515, 0, 1880},
        {4368, 41096, 0, 1850},
        {9631, 105551, 0, 5939},
        {11463, 341100, 0, 56131}, /* the rest are of octree, proximity and chessboard */
        {4112, 7688, 17019, 1880},
        {4368, 9283, 19069, 1852},
        {9631, 34413, 44254, 5939},
        {11463, 182282, 95626, 56131},
        {4112, 7714, 16596, 1880},
        {4368, 10053, 21671, 1852},
        {9631, 36833, 50235, 5939},
        {11463, 191917, 128689, 56131},
        {4112, 11503, 15025, 1880},
        {4368, 12339, 15896, 1852},
        {9631, 44057, 35184, 5939},
        {11463, 223579, 68343, 56131}};
    static const sc_skip skips[] = {SC_SKIP_LEAP, SC_SKIP_INTERIOR, SC_SKIP_OCTREE,
                                    SC_SKIP_PROXIMITY, SC_SKIP_CHESSBOARD};
    small_scene scenes[2] = {make_scene(small_phantom(), 0.3), make_scene(small_phantom(), 1)};

    for (int way = 0; way < (int)SC_COUNT_OF(known); way++) {
        small_scene *s = &scenes[way % 4 < 3];
        const sc_scene scene = front_view(s);
        sc_render_stats stats;
        SC_OWN(sc_image_clear) sc_image image = {0};
        uint64_t found[4];

        s->settings.surface = way % 4 ? SC_SURFACE_SMOOTH : SC_SURFACE_VOXEL;
        s->settings.skip = skips[way / 4];
        s->settings.sampling.everywhere = way % 4 < 2;
        s->settings.sampling.samples = way % 4 < 2 ? 1 : 4;
        image = draw_view(s, &scene, &stats);
        found[0] = stats.counters.rays;
        found[1] = stats.counters.cell_visits;
        found[2] = stats.counters.brick_steps;
        found[3] = stats.counters.contributions;
        for (int i = 0; i < 4; i++) {
            const uint64_t slack = known[way][i] / 200;

            if (found[i] < known[way][i] - slack || found[i] > known[way][i] + slack)
                fail_msg("way %d: found %llu rays, %llu cell visits, %llu brick steps, %llu "
                         "contributions; "
                         "expected %llu, %llu, %llu, %llu",
                         way, (unsigned long long)found[0], (unsigned long long)found[1],
                         (unsigned long long)found[2], (unsigned long long)found[3],
                         (unsigned long long)known[way][0], (unsigned long long)known[way][1],
                         (unsigned long long)known[way][2], (unsigned long long)known[way][3]);
        }
    }
    free_scene(&scenes[0]);
    free_scene(&scenes[1]);
}

/* The same where tissues have moved apart: how many rays go through the parts, and how many cells
 * they visit there. If there are more, maps of parts have become wider, or hide less. */
TEST(the_counted_work_of_moved_tissues_does_not_change)
{
    static const uint64_t known[2][2] = {{7680, 79906},
                                         {16069, 202314}}; /* opaque, translucent: rays, visits */
    static const sc_vec3 ways[4] = {{0, 0, 0}, {9, 2, 0}, {-5, 9, 3}, {0, 5, 9}};
    sc_vec3 offsets_mm[64];

    for (int way = 0; way < 2; way++) {
        small_scene s = make_scene(small_phantom(), way ? 0.3 : 1);
        sc_scene scene = front_view(&s);
        sc_render_stats stats;
        SC_OWN(sc_image_clear) sc_image image = {0};

        for (int id = 0; id < s.prepared.view.label_count; id++) {
            s.tissues[id].part = (uint8_t)(id % 4);
            offsets_mm[id] = ways[id % 4];
        }
        scene.offsets_mm = offsets_mm;
        image = draw_view(&s, &scene, &stats);
        for (int i = 0; i < 2; i++) {
            const uint64_t found = i ? stats.counters.cell_visits : stats.counters.rays;
            const uint64_t slack = known[way][i] / 200;

            if (found < known[way][i] - slack || found > known[way][i] + slack)
                fail_msg("way %d: found %llu %s, expected %llu", way, (unsigned long long)found,
                         i ? "cell visits" : "rays", (unsigned long long)known[way][i]);
        }
        free_scene(&s);
    }
}

/* A wall, and a box behind it as seen from low y. */
static int wall_and_box(double x, double y, double z)
{
    const bool in_wall = fabs(x - 20) < 15 && fabs(z - 20) < 15;

    if (in_wall && y > 8 && y < 14)
        return 1;
    return fabs(x - 20) < 5 && fabs(z - 20) < 5 && y > 20 && y < 30 ? 2 : 0;
}

/* Of a tissue so faint that it is no surface of its own, a wall that stands before it hides all,
 * also where the tissue has moved. */
TEST(faint_tissues_stay_behind_what_hides_them)
{
    static const int size[3] = {40, 40, 40};
    static const double spacing[3] = {1, 1, 1};
    static const sc_vec3 offsets_mm[3] = {{0, 0, 0}, {0, 0, 0}, {0, 0, 2}};
    sc_image images[2];

    for (int faint = 0; faint < 2; faint++) {
        SC_OWN(free_scene)
        small_scene s = make_scene(shape_volume(size, spacing, 1, 3, wall_and_box), 1);
        const sc_affine *to_mm = &s.prepared.view.to_ras_mm;
        const sc_vec3 eye_mm = sc_affine_point(to_mm, (sc_vec3){20, -80, 20});
        const sc_vec3 middle_mm = sc_affine_point(to_mm, (sc_vec3){20, 20, 20});
        sc_render_stats stats;
        sc_scene scene;

        s.settings.light = (sc_lighting){.method = SC_LIGHT_FLAT};
        scene = front_view(&s);
        scene.camera = sc_camera_look(eye_mm, middle_mm, (sc_vec3){0, 0, 1}, SC_PERSPECTIVE, 0.2);
        s.tissues[2].part = 1;
        s.tissues[2].opacity = 0.02;
        s.tissues[2].visible = faint;
        scene.offsets_mm = offsets_mm;
        images[faint] = draw_view(&s, &scene, &stats);
        assert_true(stats.counters.contributions > 1000);
    }
    expect_same(&images[0], &images[1]);
    sc_image_clear(&images[0]);
    sc_image_clear(&images[1]);
}

/* A ball that is cut in half shows a flat disc of one colour, but for its rim, with caps, and the
 * inside of its far wall without. */
TEST(cut_faces_are_solid)
{
    const int size[3] = {41, 41, 41};
    const double spacing[3] = {1, 1, 1};
    SC_OWN(free_scene)
    small_scene s = make_scene(shape_volume(size, spacing, 1, 2, large_ball), 0.1);
    sc_scene scene = {.clip.count = 1, .clip.set_count = 1, .clip.sets = {1}};
    sc_image image;

    s.settings.width_px = s.settings.height_px = 81;
    scene.camera = sc_camera_look((sc_vec3){20, 100, 20}, (sc_vec3){20, 20, 20}, (sc_vec3){0, 0, 1},
                                  SC_ORTHOGRAPHIC, 20);
    scene.clip.planes[0] = (sc_plane){{0, -1, 0}, 20.25}; /* keeps the back half */
    image = draw_view(&s, &scene, NULL);
    for (int x = 24; x <= 56; x++)
        assert_memory_equal(pixel(&image, x, 40), pixel(&image, 40, 40), 3);
    assert_memory_not_equal(pixel(&image, 40, 40), "\xff\xff\xff", 3);
    assert_memory_equal(pixel(&image, 2, 40), "\xff\xff\xff", 3);
    sc_image_clear(&image);
    s.settings.caps = false;
    image = draw_view(&s, &scene, NULL);
    assert_memory_not_equal(pixel(&image, 40, 40), pixel(&image, 60, 40), 3);
    sc_image_clear(&image);
}

/* March one ray through a small scene whose tissues all have the opacity @p alpha. */
static sc_radiance trace(const small_scene *s, const uint64_t *cells, float alpha, sc_vec3 from,
                         sc_vec3 direction, float length, uint64_t *contributions)
{
    const sc_prepared *v = &s->prepared.view;
    const sc_kernel *kernel = sc_kernel_find(SC_SURFACE_SMOOTH, SC_SKIP_INTERIOR, v, NULL);
    sc_march_tissue tissues[8];
    sc_march_counters counters = {0};
    sc_radiance light;
    const sc_march march = {
        .volume = v,
        .marked = {.masks = cells,
                   .row = sc_framed_row(v->bricks),
                   .layer = sc_framed_layer(v->bricks)},
        .box_low = {-1.5f, -1.5f, -1.5f},
        .box_high = {(float)v->size[0] + 2.5f, (float)v->size[1] + 2.5f, (float)v->size[2] + 2.5f},
        .tissues = tissues,
        .opaque_below = SC_OPAQUE,
        .light = {.flat = true}};
    const sc_ray ray = {
        .origin = {(float)from.x + 1, (float)from.y + 1, (float)from.z + 1},
        .direction = {(float)direction.x, (float)direction.y, (float)direction.z},
        .toward_eye = {(float)-direction.x, (float)-direction.y, (float)-direction.z},
        .clip_sets = 1,
        .part_count = {1},
        .parts = {{{.end_mm = length, .cap_plane = -1}}}};

    for (int id = 0; id < 8; id++)
        tissues[id] = (sc_march_tissue){.boundary_alpha = alpha,
                                        .thickness_factor = 1,
                                        .show = id ? SC_SHOW_BOUNDARY : 0,
                                        .shininess = 1};
    kernel->march(&march, &ray, NULL, 1, &light, &counters);
    *contributions = counters.contributions;
    return light;
}

static int wall(double x, double y, double z)
{
    return fabs(0.3 * y + 0.95 * z - 16.1) < 0.56 || (y == 9 && z == 9);
}

/* Every crossing along a ray is found, also where a sheet one voxel thick is entered and left
 * within one cell. Expected are the changes between the owners of points close together on the ray.
 */
TEST(no_crossing_is_missed)
{
    const int size[3] = {31, 27, 29};
    const double spacing[3] = {1, 1, 1};
    int (*const shapes[3])(double, double, double) = {wall, speckles, speckles};
    const uint8_t show[8] = {0, 1, 1, 1, 1, 1, 1, 1};
    uint64_t seed = 77, found = 0, expected = 0, within_a_cell = 0;

    for (int which = 0; which < 3; which++) {
        SC_OWN(free_scene)
        small_scene s = make_scene(shape_volume(size, spacing, 1, which ? 6 : 2, shapes[which]), 1);
        sc_team *team;
        uint64_t *cells;

        if (which == 2) {
            sc_free(s.prepared.block);
            s.prepared = prepare_random_fields(&s.volume, seed);
        }
        assert_ok(sc_team_open(&quiet, NULL, 1, NULL, &team));
        assert_ok(sc_visible_cells(&quiet, team, &s.prepared.view, show, &cells));
        for (int n = 0; n < 500; n++) {
            const sc_vec3 from = {random_real(&seed, 0, 30), random_real(&seed, 0, 26),
                                  random_real(&seed, 0, 28)};
            const sc_vec3 to = {random_real(&seed, 0, 30), random_real(&seed, 0, 26),
                                random_real(&seed, 0, 28)};
            const double length = sc_vec3_length(sc_vec3_sub(to, from));
            const sc_vec3 d = sc_vec3_scale(sc_vec3_sub(to, from), 1 / length);
            uint32_t last = 0;
            uint64_t contributions, sampled = 0;
            double entered = -1;

            for (int k = 0; k <= 4000; k++) {
                const sc_vec3 p = sc_vec3_along(from, length * k / 4000, d);
                const float point[3] = {(float)p.x + 1, (float)p.y + 1, (float)p.z + 1};
                const uint32_t owner = sc_kernel_owner(&s.prepared.view, point);

                if (k && owner != last) {
                    sampled += (owner != 0) + (last != 0);
                    within_a_cell += entered >= 0 && length * k / 4000 - entered < 0.5;
                    entered = length * k / 4000;
                }
                last = owner;
            }
            (void)trace(&s, cells, 1e-6f, from, d, (float)length, &contributions);
            assert_true(contributions >=
                        sampled); /* sheets thinner than the distance of the points are missed */
            found += contributions;
            expected += sampled;
        }
        sc_team_close(team);
    }
    assert_true(expected > 3300 && within_a_cell > 100);
    assert_in_range(found, expected, expected + expected / 500);
}

/* A vessel one voxel thick, whose voxels in part share only an edge. */
static int thread_of_voxels(double x, double y, double z)
{
    return x == floor(13 + 6 * sin(z / 5)) && y == floor(12 + 5 * cos(z / 4));
}

TEST(every_voxel_keeps_its_label_where_borders_are_crisp_or_tissue_thin)
{
    const int size[3] = {31, 27, 29};
    const double spacing[3] = {1, 1, 2.5};
    static const double strengths[] = {0, 0.3, 1, SC_SMOOTH_MAX};

    for (int n = 0; n < 8; n += n == 0 ? 1 : n == 1 ? 1 : 2) { /* speckles at strength 0 alone */
        sc_volume volume =
            shape_volume(size, spacing, 1, n & 1 ? 6 : 2, n & 1 ? speckles : thread_of_voxels);
        const sc_prepare_settings settings = {
            .smooth = {strengths[n / 2], strengths[n / 2], strengths[n / 2]}, .threads = 2};
        const prepared_copy p = prepare_as(&volume, &settings);

        for (int i = 0; i < size[0] * size[1] * size[2]; i++) {
            const float point[3] = {(float)(i % size[0] + 1), (float)(i / size[0] % size[1] + 1),
                                    (float)(i / size[0] / size[1] + 1)};

            assert_int_equal(sc_kernel_owner(&p.view, point), ((uint8_t *)volume.ids)[i]);
        }
        sc_free(p.block);
        sc_volume_clear(&volume);
    }
}

TEST(every_listed_kernel_is_found)
{
    size_t count;
    const sc_kernel *all = sc_kernel_all(&count);

    assert_true(count >= 6); /* none, interior and leap in plain C, of both surfaces */
    for (size_t i = 0; i < count; i++) {
        const sc_kernel *found = sc_kernel_find(all[i].surface, all[i].skip, NULL, all[i].cpu);

        if (sc_cpu_has(all[i].cpu))
            assert_ptr_equal(found, &all[i]);
        else
            assert_null(found);
    }
}

TEST(a_volume_too_large_for_the_wide_kernels_is_marched_by_the_others)
{
    const sc_prepared voxels = {
        .size = {2000, 2000, 2000}, .bricks = {501, 501, 501}, .label_bytes = 1};
    const sc_prepared records = {.size = {9, 9, 9}, .label_bytes = 1, .outer = {.count = 1u << 30}};
    /* The masks are within reach, but not the distances of the cells as well. */
    const sc_prepared cells = {
        .size = {1289, 1289, 1289}, .bricks = {323, 323, 323}, .label_bytes = 1};
    const sc_prepared masks = {
        .size = {2600, 2600, 2600}, .bricks = {651, 651, 651}, .label_bytes = 1};

    assert_null(sc_kernel_find(SC_SURFACE_VOXEL, SC_SKIP_LEAP, &voxels, NULL));
    assert_non_null(sc_kernel_find(SC_SURFACE_SMOOTH, SC_SKIP_LEAP, &voxels, NULL));
    assert_null(sc_kernel_find(SC_SURFACE_VOXEL, SC_SKIP_LEAP, &records, "c"));
    assert_null(sc_kernel_find(SC_SURFACE_VOXEL, SC_SKIP_OCTREE, &records, "c"));
    assert_non_null(sc_kernel_find(SC_SURFACE_SMOOTH, SC_SKIP_OCTREE, &cells, "c"));
    assert_null(sc_kernel_find(SC_SURFACE_SMOOTH, SC_SKIP_PROXIMITY, &cells, "c"));
    assert_null(sc_kernel_find(SC_SURFACE_VOXEL, SC_SKIP_CHESSBOARD, &cells, "c"));
    assert_null(sc_kernel_find(SC_SURFACE_SMOOTH, SC_SKIP_LEAP, &masks, NULL));
    assert_non_null(sc_kernel_find(SC_SURFACE_SMOOTH, SC_SKIP_INTERIOR, &masks, NULL));
}

RUN_TESTS(NULL, NULL)
