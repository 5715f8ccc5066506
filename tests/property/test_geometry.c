/* SPDX-License-Identifier: BSD-3-Clause */
/* Pictures of volumes of every geometry that is accepted: voxels of all proportions and sizes,
 * sheared axes, origins far away, cameras and planes of all kinds. Each ends, touches no memory
 * that is not its own (seen by the sanitizers), and is the same by every kernel that this processor
 * can run.
 *
 * usage: test_geometry [VOLUMES [FIRST]]   number of random volumes, and the number of the first */
#include "check.h"
#include "compare_images.h"

#include "scenes.h"

#include <math.h>

enum { LABELS = 5, WIDTH_PX = 20, HEIGHT_PX = 14 };

static long volume_count = 600, first_volume = 0;

/* A number between @p low and @p high whose logarithm is evenly distributed. */
static double random_scale(uint64_t *seed, double low, double high)
{
    return exp(random_real(seed, log(low), log(high)));
}

/* One of 0 to @p count - 1. */
static int random_below(uint64_t *seed, int count)
{
    return (int)((random_bits(seed) >> 33) % (uint64_t)count);
}

static sc_vec3 random_direction(uint64_t *seed)
{
    return sc_vec3_unit((sc_vec3){random_real(seed, -1, 1), random_real(seed, -1, 1),
                                  random_real(seed, -1, 1) + 1e-3});
}

/* A geometry that sc_geometry_check accepts for a volume of @p size, as far from the usual as it
 * may be: most candidates lie beyond what is accepted. */
static sc_affine random_geometry(uint64_t *seed, const int size[3])
{
    const double scale_mm = random_scale(seed, SC_SPACING_LEAST_MM, SC_SPACING_MOST_MM);
    const sc_ctx *ctx = listening_anew();
    sc_affine to_mm = {0};

    do {
        const bool oblique = random_below(seed, 2);

        for (int i = 0; i < 3; i++) {
            const double spacing_mm = scale_mm * random_scale(seed, 1e-6, 1e6);
            sc_vec3 axis = {i == 0, i == 1, i == 2};

            if (oblique)
                axis = random_direction(seed);
            to_mm.m[0][i] = spacing_mm * axis.x;
            to_mm.m[1][i] = spacing_mm * axis.y;
            to_mm.m[2][i] = spacing_mm * axis.z;
            to_mm.m[i][3] = random_below(seed, 2) ? 0 : scale_mm * random_real(seed, -1e9, 1e9);
        }
    } while (sc_geometry_check(ctx, "random", size, &to_mm) != SC_OK);
    return to_mm;
}

static uint64_t noise_seed;

/* Noise in large and small lumps, with much background. */
static int noise(double x, double y, double z)
{
    const uint64_t lump =
        (uint64_t)(x / 3) * 7919 + (uint64_t)(y / 3) * 104729 + (uint64_t)(z / 3) * 1299709;
    uint64_t seed = noise_seed + lump * 77777 + 1;
    int id;

    random_bits(&seed);
    id = random_below(&seed, 2 * LABELS);
    if (id == LABELS) /* this lump is noise, voxel by voxel */
        id = (int)((uint64_t)(x * 31 + y * 17 + z * 13) % LABELS);
    return id < LABELS ? id : 0;
}

/* A scene of random size, geometry and settings; the caller frees it (free_scene). */
static small_scene random_scene(uint64_t *seed, sc_surface surface)
{
    const double one[3] = {1, 1, 1};
    int size[3];
    small_scene s;
    sc_volume volume;

    for (int i = 0; i < 3; i++)
        size[i] = 1 + (int)random_scale(seed, 1, random_below(seed, 4) ? 9 : 70);
    noise_seed = random_bits(seed);
    volume = shape_volume(size, one, 1 + random_below(seed, 2), LABELS, noise);
    volume.to_ras_mm = random_geometry(seed, size);
    tested_surface = surface;
    s = make_scene(volume, random_below(seed, 2) ? 1 : 0.4);
    s.settings.width_px = WIDTH_PX;
    s.settings.height_px = HEIGHT_PX;
    s.settings.cap_outline = random_below(seed, 2);
    s.settings.light.shadows = random_below(seed, 2);
    s.settings.light.depth_cue = random_below(seed, 2) ? 0.5 : 0;
    s.settings.local_thickness = random_below(seed, 2);
    return s;
}

/* A random orbit about what @p r shows, or a camera amid it, with up to two planes that cut it. */
static sc_timeline random_timeline(uint64_t *seed, const sc_renderer *r)
{
    sc_animation a = {
        .frames = 7,
        .camera = {.axis = random_direction(seed),
                   .turns = 1,
                   .elevation_deg = random_real(seed, -89.9, 89.9),
                   .fov_deg = random_below(seed, 2) ? 30 : random_scale(seed, 0.1, 170),
                   .projection = random_below(seed, 4) ? SC_PERSPECTIVE : SC_ORTHOGRAPHIC,
                   .zoom = 1}};

    if (random_below(seed, 3) == 0)
        a.camera.zoom = random_scale(seed, 0.01, 1000);
    if (random_below(seed, 4) == 0) {
        a.camera.has_distance = true;
        a.camera.distance_mm = random_scale(seed, 1e-3, 1e6);
    }
    a.sweep_count = random_below(seed, 3);
    for (int i = 0; i < a.sweep_count; i++)
        a.sweeps[i] = (sc_sweep){
            .normal = random_direction(seed),
            .at_track = {2, {{.at = 0, .value = {0, 1, 0}}, {.at = 1, .value = {100, 1, 0}}}}};
    return orbit_of(r, (double)WIDTH_PX / HEIGHT_PX, 7, &a);
}

/* @return whether the picture shows anything. */
static bool shows_something(const sc_image *image)
{
    for (size_t i = 1; i < sc_image_bytes(image); i++) {
        if (image->rgb[i] != image->rgb[0])
            return true;
    }
    return false;
}

/* Draw the frame with every skip method and every kernel that it has here; fail if one differs from
 * the first, the plain march. @return whether the picture shows anything. */
static bool expect_same_by_all_kernels(small_scene *s, const sc_scene *scene, long number)
{
    SC_OWN(sc_image_clear) sc_image plain = {0};
    bool any;

    s->settings.skip = SC_SKIP_NONE;
    s->settings.cpu = NULL;
    plain = draw_view(s, scene, NULL);
    for (sc_skip skip = SC_SKIP_INTERIOR; skip <= SC_SKIP_LEAP; skip++) {
        for (int i = 1; sc_cpu_names[i] && (i == 1 || sc_skip_is_wide(skip)); i++) {
            SC_OWN(sc_image_clear) sc_image other = {0};
            image_difference d;

            if (sc_skip_is_wide(skip) && !sc_cpu_has(sc_cpu_names[i]))
                continue;
            s->settings.skip = skip;
            s->settings.cpu = sc_skip_is_wide(skip) ? sc_cpu_names[i] : NULL;
            other = draw_view(s, scene, NULL);
            assert_true(compare_images(&plain, &other, &d));
            if (d.differing_px)
                fail_msg("volume %ld: skip method %d, %s, differs from the plain march in %zu "
                         "pixels",
                         number, (int)skip, s->settings.cpu ? s->settings.cpu : "plain C",
                         d.differing_px);
        }
    }
    any = shows_something(&plain);
    return any;
}

TEST(every_accepted_geometry_is_drawn_alike_by_all_kernels)
{
    long shown = 0;

    for (long n = first_volume; n < first_volume + volume_count; n++) {
        uint64_t seed = 0x9e3779b97f4a7c15u * (uint64_t)(n + 1);
        small_scene s;
        sc_renderer *r;
        sc_timeline t;

        random_bits(&seed);
        s = random_scene(&seed, n % 2 ? SC_SURFACE_SMOOTH : SC_SURFACE_VOXEL);
        assert_ok(sc_renderer_new(&quiet, &s.settings, &s.prepared.view, s.tissues, &r));
        for (int k = 0; k < 3; k++) {
            sc_scene scene;

            t = random_timeline(&seed, r);
            scene = sc_timeline_scene(&t, random_below(&seed, 7), NULL);
            shown += expect_same_by_all_kernels(&s, &scene, n);
        }
        sc_renderer_free(r);
        free_scene(&s);
    }
    print_message("%ld of %ld pictures show something\n", shown, 3 * volume_count);
    assert_true(shown > volume_count / 2);
}

int main(int argc, char **argv)
{
    if (argc > 1)
        volume_count = strtol(argv[1], NULL, 10);
    if (argc > 2)
        first_volume = strtol(argv[2], NULL, 10);
    return run_all_tests(NULL, NULL);
}
