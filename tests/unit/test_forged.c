/* SPDX-License-Identifier: BSD-3-Clause */
/* Prepared files whose contents were changed and whose checksum was made to fit again: each is
 * refused, or can be drawn without a crash, which the sanitizers watch. */
#include "check.h"

#include "scenes.h"

/* For its header, and to make the checksum fit. */
#include "../../src/prepare/pack.c"

enum { WIDTH = 24, HEIGHT = 18, RANDOM_FORGERIES = 1000 };

/* A prepared file in memory, aligned as a mapped one is. */
typedef struct forged {
    char *block;
    size_t bytes;
} forged;

/* @return the looks with which draw() draws a volume; caller owns. */
static sc_tissue *looks_of(const sc_prepared *v)
{
    const sc_tissue_rule rule = {.pattern = "*", .has.opacity = true, .opacity = 0.6};
    void *tissues;

    assert_ok(sc_alloc(&quiet, (size_t)v->label_count, sizeof(sc_tissue), &tissues));
    sc_transfer_resolve(v, &rule, v->label_count % 2, SC_OPACITY_PAPER, tissues);
    return tissues;
}

/* Derive what a file stores, for the opacities with which draw() draws it. */
static void derive(sc_preparation *preparation)
{
    const sc_prepared v = sc_preparation_view(preparation);
    SC_OWN(sc_free_at) sc_tissue *tissues = looks_of(&v);
    float *opacity;
    SC_OWN(sc_free_at) void *block = NULL;

    assert_ok(sc_zalloc(&quiet, (size_t)v.label_count, sizeof *opacity, &block));
    opacity = block;
    for (int id = 1; id < v.label_count; id++)
        opacity[id] = tissues[id].visible ? (float)tissues[id].opacity : 0;
    assert_ok(sc_preparation_derive(&quiet, preparation, opacity));
}

static forged prepared_file(bool wide)
{
    const int size[3] = {wide ? 11 : 23, 17, 19};
    const sc_prepare_settings settings = {
        .smooth = {1, 1, 1}, .local_thickness = true, .threads = 1};
    SC_OWN(sc_phantom_free_at) sc_phantom *phantom = NULL;
    sc_volume volume;
    sc_preparation *preparation;
    forged out;
    SC_OWN(sc_free_at) char *text = NULL;
    void *block;

    assert_ok(sc_phantom_new(&quiet, &phantom));
    assert_ok(sc_phantom_volume(&quiet, phantom, size, 1, &volume));
    if (wide) { /* ids of two bytes */
        const size_t voxels = sc_volume_voxels(&volume);

        assert_ok(sc_alloc(&quiet, voxels, 2, &block));
        for (size_t i = 0; i < voxels; i++)
            ((uint16_t *)block)[i] = ((const uint8_t *)volume.ids)[i];
        sc_free(volume.ids);
        volume.ids = block;
        volume.label_bytes = 2;
    }
    assert_ok(sc_prepare(&quiet, &volume, &settings, &preparation));
    derive(preparation);
    assert_ok(sc_preparation_save(&quiet, preparation, "forged.segc", true, true));
    sc_preparation_free(preparation);
    sc_volume_clear(&volume);
    assert_ok(sc_file_read(&quiet, "forged.segc", 1 << 28, &text, &out.bytes));
    assert_ok(sc_alloc(&quiet, out.bytes, 1, &block)); /* without a byte behind its end */
    memcpy(block, text, out.bytes);
    out.block = block;
    assert_int_equal(remove("forged.segc"), 0);
    return out;
}

/* Make the checksum of a file fit its contents, if its header says where they are. */
static void repair(forged *file)
{
    const void *sections[SECTIONS];
    uint64_t bytes[SECTIONS];
    block_header h;

    memcpy(&h, file->block, sizeof h);
    if (!is_sound(&h) || h.total_bytes != file->bytes)
        return;
    lay_out(&h, bytes);
    h.checksum = 0;
    for (int i = 0; i < SECTIONS; i++)
        sections[i] = file->block + h.offset[i];
    h.checksum = checksum_of(&h, sections, bytes);
    memcpy(file->block, &h, sizeof h);
}

/* Draw a picture, if there can be a renderer. @param scene what it shows, found first if it is all
 * zero, which takes longer than to draw it. @param derived_bytes set to what the renderer has
 * derived from the volume, unless NULL. @return the hash of its pixels; 0: there is none. */
static uint64_t draw(const sc_prepared *v, const sc_render_settings *settings, sc_scene *scene,
                     uint64_t *derived_bytes)
{
    SC_OWN(sc_free_at) sc_tissue *tissues = looks_of(v);
    sc_animation a = {0};
    sc_renderer *renderer;
    sc_render_stats stats;
    sc_timeline timeline;
    sc_image image;
    uint64_t hash = 0;

    if (sc_renderer_new(&quiet, settings, v, tissues, &renderer) == SC_OK) {
        if (scene->camera.half_height == 0) {
            timeline = orbit_of(renderer, (double)WIDTH / HEIGHT, 8, &a);
            *scene = sc_timeline_scene(&timeline, 1, NULL);
        }
        assert_ok(sc_image_init(&quiet, WIDTH, HEIGHT, &image));
        sc_render_view(renderer, scene, NULL, NULL, NULL, &image, &stats);
        hash = sc_image_hash(&image);
        if (derived_bytes)
            *derived_bytes = sc_renderer_derived_bytes(renderer);
        sc_image_clear(&image);
        sc_renderer_free(renderer);
    }
    return hash;
}

/* Read a file, and draw it if it is accepted. @return whether it was. */
static bool use(const forged *file, bool every_way)
{
    static const sc_skip skips[] = {SC_SKIP_LEAP,       SC_SKIP_OCTREE,   SC_SKIP_PROXIMITY,
                                    SC_SKIP_CHESSBOARD, SC_SKIP_INTERIOR, SC_SKIP_NONE};
    sc_render_settings settings = {.width_px = WIDTH,
                                   .height_px = HEIGHT,
                                   .sampling.samples = 1,
                                   .step_voxels = 0.5,
                                   .caps = true,
                                   .light = {.ambient = 0.3, .key = 0.6, .occlusion = 0.8},
                                   .local_thickness = true,
                                   .work = {.tile_px = 8, .threads = 1}};
    const sc_ctx *ctx = listening_anew();
    sc_scene scene = {0};
    sc_prepared v;
    const sc_status status =
        sc_prepared_file_view(ctx, "forged.segc", file->block, file->bytes, &v);

    if (status != SC_OK) {
        assert_int_equal(status, SC_ERR_DATA);
        assert_int_equal(said.errors, 1);
        assert_non_null(strstr(said.text, "forged.segc: "));
        return false;
    }
    for (int surface = 0; surface < 2; surface++) {
        for (size_t skip = 0; skip < (every_way ? SC_COUNT_OF(skips) : 1); skip++) {
            settings.surface = surface ? SC_SURFACE_VOXEL : SC_SURFACE_SMOOTH;
            settings.skip = skips[skip];
            settings.local_thickness = v.thickness != NULL;
            (void)draw(&v, &settings, &scene, NULL);
        }
    }
    return true;
}

/* Overwrite @p bytes bytes at offset @p at of a copy of @p from, let its checksum fit, and use it.
 * @return whether it was accepted. */
static bool accepts(const forged *from, size_t at, const void *with, size_t bytes)
{
    forged copy = *from;
    void *block;
    bool accepted;

    assert_ok(sc_alloc(&quiet, copy.bytes, 1, &block));
    copy.block = block;
    memcpy(copy.block, from->block, copy.bytes);
    memcpy(copy.block + at, with, bytes);
    repair(&copy);
    accepted = use(&copy, false);
    sc_free(copy.block);
    return accepted;
}

TEST(a_file_with_a_repaired_checksum_is_accepted)
{
    for (int wide = 0; wide < 2; wide++) {
        forged file = prepared_file(wide);

        repair(&file);
        assert_true(use(&file, true));
        sc_free(file.block);
    }
}

/* What is stored is used where it fits, and that does not change a picture. */
TEST(stored_and_derived_pictures_are_the_same)
{
    for (int wide = 0; wide < 2; wide++) {
        const sc_render_settings settings = {
            .surface = SC_SURFACE_SMOOTH,
            .skip = SC_SKIP_LEAP,
            .width_px = WIDTH,
            .height_px = HEIGHT,
            .sampling.samples = 1,
            .step_voxels = 0.5,
            .light = {.ambient = 0.3, .key = 0.6, .occlusion = 0.8},
            .work = {.tile_px = 8, .threads = 1}};
        forged file = prepared_file(wide);
        uint64_t derived_bytes[3], hashes[3];
        float *opacity;
        SC_OWN(sc_free_at) void *block = NULL;
        sc_prepared v;

        assert_ok(sc_prepared_file_view(&quiet, "now.segc", file.block, file.bytes, &v));
        assert_non_null(v.stored.masks);
        assert_true(v.stored.cell_count > 100 && v.stored.hull_count > 100);
        hashes[1] = draw(&v, &settings, &(sc_scene){0}, &derived_bytes[1]);
        assert_ok(sc_alloc(&quiet, (size_t)v.label_count, sizeof *opacity, &block));
        opacity = block;
        memcpy(opacity, v.stored.opacity, (size_t)v.label_count * sizeof *opacity);
        opacity[v.label_count - 1] /= 2; /* the occlusion was made for others than are drawn */
        v.stored.opacity = opacity;
        hashes[2] = draw(&v, &settings, &(sc_scene){0}, &derived_bytes[2]);
        v.stored = (sc_stored){0};
        hashes[0] = draw(&v, &settings, &(sc_scene){0}, &derived_bytes[0]);
        for (int i = 1; i < 3; i++)
            assert_true(hashes[i] == hashes[0]);
        assert_true(derived_bytes[1] < derived_bytes[2] && derived_bytes[2] < derived_bytes[0]);
        sc_free(file.block);
    }
}

/* Files of other versions are refused, however short they are, and say what to do. */
TEST(files_of_other_versions_are_refused)
{
    forged file = prepared_file(false);
    static const uint32_t versions[] = {0, VERSION - 1, VERSION + 1, UINT32_MAX};

    for (size_t i = 0; i < SC_COUNT_OF(versions); i++) {
        char text[64];
        const sc_ctx *ctx = listening_anew();
        sc_prepared v;

        memcpy(file.block + offsetof(block_header, format.version), &versions[i], 4);
        assert_int_equal(
            sc_prepared_file_view(ctx, "a.segc", file.block, i % 2 ? 64 : file.bytes, &v),
            SC_ERR_DATA);
        snprintf(text, sizeof text, "version %u, this segcast reads version %d; prepare it again",
                 (unsigned)versions[i], (int)VERSION);
        assert_non_null(strstr(said.text, text));
    }
    for (size_t bytes = 0; bytes <= sizeof(block_header); bytes += 8) {
        const uint32_t version = bytes & 8 ? VERSION - 1 : VERSION;
        forged cut = {NULL, bytes};
        SC_OWN(sc_free_at) void *block = NULL;

        assert_ok(sc_alloc(&quiet, bytes + !bytes, 1, &block));
        cut.block = block;
        memcpy(cut.block, file.block, bytes);
        if (bytes >= 12)
            memcpy(cut.block + offsetof(block_header, format.version), &version, 4);
        assert_false(use(&cut, false));
    }
    sc_free(file.block);
}

/* What is stored for drawing can lead to no other memory than that of the volume. */
TEST(stored_contents_out_of_range_are_refused)
{
    static const double far_points[] = {NAN, INFINITY, -1e300, 1e9};
    const uint64_t ones = ~0ull, none = 0;
    const uint32_t wrong = 12345678, beyond[2] = {200, 200u << SC_CELL_LABEL_BITS};
    forged file = prepared_file(false);
    block_header h;
    uint64_t bytes[SECTIONS];

    memcpy(&h, file.block, sizeof h);
    lay_out(&h, bytes);
    assert_int_equal(h.stored.parts, STORED_CELLS | STORED_OCCLUSION);
    /* in the frame at its begin and end, between rows, and within */
    assert_false(accepts(&file, h.offset[CELL_MASKS], &ones, 8));
    assert_false(accepts(&file, h.offset[CELL_MASKS] + bytes[CELL_MASKS] - 8, &ones, 8));
    for (uint64_t at = 0; at < bytes[CELL_MASKS]; at += 8) {
        uint64_t before;

        memcpy(&before, file.block + h.offset[CELL_MASKS] + at, 8);
        assert_false(accepts(&file, h.offset[CELL_MASKS] + at, before ? &none : &ones, 8));
        assert_false(accepts(&file, h.offset[CELL_START] + at / 2, &wrong, 4));
    }
    for (int i = 0; i < 2; i++) /* labels of a packed cell */
        assert_false(
            accepts(&file, h.offset[CELLS] + offsetof(sc_packed_cell, labels), &beyond[i], 4));
    for (size_t i = 0; i < SC_COUNT_OF(far_points); i++)
        assert_false(accepts(&file, h.offset[HULL] + bytes[HULL] / 16 * 8, &far_points[i], 8));
    sc_free(file.block);
}

/* Values that a field may be forged with. */
static const int64_t numbers[] = {0,         1,          -1,        2,         3,
                                  255,       256,        65535,     65536,     INT32_MAX,
                                  INT32_MIN, UINT32_MAX, INT64_MAX, INT64_MIN, INT32_MAX - 4};

TEST(every_word_of_the_header_can_be_forged)
{
    int accepted = 0, tried = 0;

    for (int wide = 0; wide < 2; wide++) {
        forged file = prepared_file(wide);

        for (size_t at = 0; at < offsetof(block_header, checksum); at += 4) {
            for (size_t i = (size_t)wide; i < SC_COUNT_OF(numbers); i += 2, tried++) {
                const size_t bytes = at % 8 || at + 8 > sizeof(block_header) ? 4 : 8;

                accepted += accepts(&file, at, &numbers[i], bytes);
                if (bytes == 8)
                    accepted += accepts(&file, at, &numbers[i], 4);
            }
        }
        sc_free(file.block);
    }
    print_message("%d forged headers, %d accepted\n", tried, accepted);
}

/* Damage that the kernels would follow out of their arrays, or compute with for ever. */
TEST(contents_out_of_range_are_refused)
{
    static const float bad_floats[] = {NAN, INFINITY, -INFINITY, 2};
    static const double bad_numbers[] = {NAN, INFINITY, -1, 1e300};
    static const unsigned char two = 2, all = 255;
    static const int64_t background_value = 0; /* the value of background */
    forged file = prepared_file(false);
    const uint64_t ones = ~0ull;
    block_header h;
    uint64_t bytes[SECTIONS];

    memcpy(&h, file.block, sizeof h);
    lay_out(&h, bytes);
    assert_false(accepts(&file, h.offset[IDS] + bytes[IDS] / 2, &all, 1));
    assert_false(accepts(&file, h.offset[NEAR], &ones, 8));
    assert_false(accepts(&file, h.offset[NEAR] + bytes[NEAR] - 8, &ones, 8));
    assert_false(accepts(&file, h.offset[NEAR_START] + bytes[NEAR_START] / 8 * 4, &ones, 4));
    assert_false(accepts(&file, h.offset[HIDDEN], &two, 1));
    for (size_t i = 0; i < 6; i++) { /* the first record, one within, the last of either field */
        const int section = i < 3 ? OUTER_RECORDS : INNER_RECORDS;
        const size_t last = bytes[section] / SC_RECORD_BYTES - 1;
        const size_t at = h.offset[section] + last * (i % 3) / 2 * SC_RECORD_BYTES;
        const uint32_t wrong[3] = {13u << SC_RECORD_TISSUE_SHIFT, 27u << SC_RECORD_TISSUE_SHIFT | 1,
                                   13u << SC_RECORD_TISSUE_SHIFT | 0x80};

        for (int k = 0; k < 3; k++)
            assert_false(accepts(&file, at, &wrong[k], sizeof wrong[k]));
    }
    assert_false(accepts(&file, h.offset[OUTER_MASKS] + bytes[OUTER_MASKS] - 8, &ones, 8));
    assert_false(accepts(&file, h.offset[INNER_START] + bytes[INNER_START] / 8 * 4, &ones, 4));
    for (size_t i = 0; i < 3; i++) {
        const size_t label = h.offset[LABELS] + i * sizeof(sc_label);
        const size_t stats = h.offset[STATS] + i * sizeof(sc_label_stats);
        char name[SC_NAME_BYTES];
        sc_label_stats absent; /* a label without voxels, whose box is outside all the same */

        memcpy(&absent, (const char *)file.block + stats, sizeof absent);
        absent.voxels = absent.boundary_voxels = 0;
        absent.low[2] = -9;
        assert_false(accepts(&file, stats, &absent, sizeof absent));
        memset(name, 'x', sizeof name);
        assert_false(accepts(&file, label + offsetof(sc_label, name), name, sizeof name));
        assert_false(accepts(&file, label + offsetof(sc_label, name), "\x1b[2J", 5));
        assert_false(accepts(&file, label + offsetof(sc_label, name), "\xc3", 2));
        assert_false(accepts(&file, label + offsetof(sc_label, has_color), &two, 1));
        assert_false(accepts(&file, label + offsetof(sc_label, hidden), &all, 1));
        if (i > 0)
            assert_false(accepts(&file, label, &background_value, 8));
        for (size_t n = 0; n < SC_COUNT_OF(bad_floats); n++)
            assert_false(accepts(&file, label + offsetof(sc_label, opacity), &bad_floats[n], 4));
        for (size_t n = 0; n < SC_COUNT_OF(bad_numbers); n++) {
            assert_false(
                accepts(&file, stats + offsetof(sc_label_stats, thickness_mm), &bad_numbers[n], 8));
            assert_false(
                accepts(&file, stats + offsetof(sc_label_stats, surface_mm2), &bad_numbers[n], 8));
        }
        assert_false(accepts(&file, stats, &ones, 8));
    }
    for (size_t n = 0; n < 3 * SC_COUNT_OF(bad_numbers); n++) /* strengths along three axes */
        assert_false(
            accepts(&file, h.offset[SMOOTH] + sizeof(sc_vec3) + n % 3 * 8, &bad_numbers[n / 3], 8));
    for (size_t n = 0; n < 12; n++)
        assert_false(
            accepts(&file, offsetof(block_header, to_ras_mm) + n * 8, &bad_numbers[n & 1], 8));
    sc_free(file.block);
}

TEST(files_forged_at_random_do_not_crash)
{
    uint64_t random = 11;
    int accepted = 0;

    for (int i = 0; i < RANDOM_FORGERIES; i++) {
        static forged file;
        const bool anew = i % (RANDOM_FORGERIES / 2) == 0;
        uint64_t bytes[SECTIONS], with = random_bits(&random);
        block_header h;
        int section;
        size_t at, count;

        if (anew && i)
            sc_free(file.block);
        if (anew)
            file = prepared_file(i > 0);
        memcpy(&h, file.block, sizeof h);
        lay_out(&h, bytes);
        section = (int)(random_bits(&random) % SECTIONS);
        count = 1 + random_bits(&random) % 8;
        if (bytes[section] < count)
            continue;
        at = h.offset[section] + random_bits(&random) % (bytes[section] - count + 1);
        if (i % 4 == 0)
            with &= 0x0303030303030303u; /* small numbers get past more checks */
        accepted += accepts(&file, at, &with, count);
        if (i == RANDOM_FORGERIES - 1)
            sc_free(file.block);
    }
    print_message("%d files forged at random, %d accepted\n", RANDOM_FORGERIES, accepted);
    assert_true(accepted > RANDOM_FORGERIES / 20); /* else nothing was drawn */
}

RUN_TESTS(NULL, NULL)
