/* SPDX-License-Identifier: BSD-3-Clause */
/* The input is a list of changes (fuzz_patch) to a valid prepared file, whose checksum is made to
 * fit; before it, a byte that chooses the file and how it is drawn if it is accepted. */
#include "fuzz.h"
#include "segcast/phantom.h"
#include "segcast/render.h"
#include "segcast/timeline.h"

/* For its header, and to make the checksum fit. */
#include "../../src/prepare/pack.c"

#include <math.h>

enum { WIDTH = 16, HEIGHT = 12 };

/* Prepared files in memory: with ids of one byte, and of two. */
static char *files[2];
static size_t file_bytes[2];

/* Prepare a small phantom, and write it to @p path under its name when it is whole. @param wide
 * with ids of two bytes. */
static void make_file(int wide, const char *path)
{
    const sc_prepare_settings settings = {
        .smooth = {1, 1, 1}, .local_thickness = true, .threads = 1};
    const int size[3] = {wide ? 11 : 15, 13, 12};
    float opacity[256] = {0}; /* as draw() gives it to all tissues, for one half of the inputs */
    sc_preparation *preparation;
    sc_phantom *phantom;
    SC_OWN(sc_volume_clear) sc_volume v = {0};

    FUZZ_CHECK(sc_phantom_new(&fuzz_ctx, &phantom) == SC_OK);
    FUZZ_CHECK(sc_phantom_volume(&fuzz_ctx, phantom, size, 1, &v) == SC_OK);
    if (wide) {
        uint8_t *ids = v.ids;

        FUZZ_CHECK(sc_alloc(&fuzz_ctx, sc_volume_voxels(&v), 2, &v.ids) == SC_OK);
        for (size_t i = 0; i < sc_volume_voxels(&v); i++)
            ((uint16_t *)v.ids)[i] = ids[i];
        sc_free(ids);
        v.label_bytes = 2;
    }
    FUZZ_CHECK(sc_prepare(&fuzz_ctx, &v, &settings, &preparation) == SC_OK);
    FUZZ_CHECK(v.label_count <= 256);
    for (int id = 1; id < v.label_count; id++)
        opacity[id] = 0.6f;
    FUZZ_CHECK(sc_preparation_derive(&fuzz_ctx, preparation, opacity) == SC_OK);
    FUZZ_CHECK(sc_preparation_save(&fuzz_ctx, preparation, path, true, true) == SC_OK);
    sc_preparation_free(preparation);
    sc_phantom_free(phantom);
}

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    static const char *const names[2] = {"narrow.segc", "wide.segc"};

    for (int wide = 0; wide < 2; wide++) {
        const char *path = fuzz_kept_path(names[wide]);

        if (access(path, F_OK))
            make_file(wide, path);
        FUZZ_CHECK(sc_file_read(&fuzz_ctx, path, 1 << 28, &files[wide], &file_bytes[wide]) ==
                   SC_OK);
    }
    return 0;
}

/* Put the camera where it sees all points, roughly. Framing, which does it well, takes longer than
 * all else that is tried here. */
static void set_camera(const sc_vec3 *points, size_t count, sc_orbit *camera)
{
    sc_vec3 low = count ? points[0] : (sc_vec3){0, 0, 0}, high = low;

    for (size_t i = 1; i < count; i++) {
        low =
            (sc_vec3){fmin(low.x, points[i].x), fmin(low.y, points[i].y), fmin(low.z, points[i].z)};
        high = (sc_vec3){fmax(high.x, points[i].x), fmax(high.y, points[i].y),
                         fmax(high.z, points[i].z)};
    }
    camera->has_target = camera->has_distance = true;
    camera->target_mm = sc_vec3_scale(sc_vec3_add(low, high), 0.5);
    camera->distance_mm = 2 * sc_vec3_length(sc_vec3_sub(high, low)) + 1e-3;
}

/* Draw one small picture; @p how chooses surface and skip method, frame and camera. */
static void draw(const sc_prepared *v, int how)
{
    static const sc_skip skips[] = {SC_SKIP_LEAP,   SC_SKIP_INTERIOR,  SC_SKIP_NONE,
                                    SC_SKIP_OCTREE, SC_SKIP_PROXIMITY, SC_SKIP_CHESSBOARD};
    const sc_render_settings settings = {.width_px = WIDTH,
                                         .height_px = HEIGHT,
                                         .sampling.samples = 1,
                                         .step_voxels = 0.5,
                                         .caps = true,
                                         .surface = how & 1 ? SC_SURFACE_VOXEL : SC_SURFACE_SMOOTH,
                                         .skip = skips[how / 2 % 6],
                                         .light = {.ambient = 0.3, .key = 0.6, .occlusion = 0.8},
                                         .local_thickness = v->thickness != NULL,
                                         .work = {.tile_px = 8, .threads = 1}};
    const sc_tissue_rule rule = {.pattern = "*", .has.opacity = true, .opacity = 0.6};
    sc_animation a = {
        .frames = 8,
        .camera = {.axis = {0, 0, 1}, .turns = 1, .elevation_deg = 14, .fov_deg = 30, .zoom = 1}};
    sc_renderer *renderer;
    SC_OWN(sc_free_at) void *tissues = NULL;

    FUZZ_CHECK(sc_alloc(&fuzz_ctx, (size_t)v->label_count, sizeof(sc_tissue), &tissues) == SC_OK);
    sc_transfer_resolve(v, &rule, how & 8 ? 1 : 0, SC_OPACITY_MEASURED, tissues);
    if (sc_renderer_new(&fuzz_ctx, &settings, v, tissues, &renderer) == SC_OK) {
        size_t count;
        const sc_vec3 *hull = sc_renderer_hull(renderer, &count);
        sc_timeline timeline;
        sc_render_stats stats;
        sc_scene scene;
        SC_OWN(sc_image_clear) sc_image image = {0};

        if ((how & 0x70) != 0x40)
            set_camera(hull, count, &a.camera);
        sc_timeline_resolve(&a, hull, count, (double)WIDTH / HEIGHT, &timeline);
        scene = sc_timeline_scene(&timeline, 1 + how / 16 % 4, NULL);
        FUZZ_CHECK(sc_image_init(&fuzz_ctx, WIDTH, HEIGHT, &image) == SC_OK);
        sc_render_view(renderer, &scene, NULL, NULL, NULL, &image, &stats);
        sc_renderer_free(renderer);
    }
}

/* Make the checksum of a file fit its contents, if its header says where they are. */
static void repair(char *file, size_t total)
{
    const void *sections[SECTIONS];
    uint64_t bytes[SECTIONS];
    block_header h;

    memcpy(&h, file, sizeof h);
    if (!is_sound(&h) || h.total_bytes != total)
        return;
    lay_out(&h, bytes);
    h.checksum = 0;
    for (int i = 0; i < SECTIONS; i++)
        sections[i] = file + h.offset[i];
    h.checksum = checksum_of(&h, sections, bytes);
    memcpy(file, &h, sizeof h);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const int how = size ? data[0] : 0, wide = how >> 7;
    fuzz_region regions[SECTIONS + 1] = {{0, offsetof(block_header, checksum)}};
    uint64_t bytes[SECTIONS];
    block_header h;
    sc_prepared v;
    SC_OWN(sc_free_at) void *copy = NULL;

    FUZZ_CHECK(sc_alloc(&fuzz_ctx, file_bytes[wide], 1, &copy) == SC_OK);
    memcpy(copy, files[wide], file_bytes[wide]);
    memcpy(&h, copy, sizeof h);
    lay_out(&h, bytes);
    for (int i = 0; i < SECTIONS; i++)
        regions[i + 1] = (fuzz_region){h.offset[i], bytes[i]};
    if (size)
        fuzz_patch(copy, regions, SC_COUNT_OF(regions), data + 1, size - 1);
    repair(copy, file_bytes[wide]);
    if (sc_prepared_file_view(&fuzz_ctx, "p.segc", copy, file_bytes[wide], &v) == SC_OK)
        draw(&v, how);
    return 0;
}
