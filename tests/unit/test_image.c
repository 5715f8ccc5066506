/* SPDX-License-Identifier: BSD-3-Clause */
/* PNG files, hashes and comparison of pictures, and the conversion of linear light to sRGB. */
#include "check.h"
#include "compare_images.h"

#include <math.h>
#include <unistd.h>

static sc_image noise(int width, int height, uint64_t seed)
{
    sc_image image;

    assert_ok(sc_image_init(&quiet, width, height, &image));
    for (size_t i = 0; i < sc_image_bytes(&image); i++)
        image.rgb[i] = (uint8_t)(random_bits(&seed) >> 56);
    return image;
}

TEST(a_png_file_keeps_every_pixel)
{
    SC_OWN(sc_image_clear) sc_image image = noise(37, 23, 5), back = {0};
    image_difference d;

    assert_ok(sc_image_save_png(&quiet, &image, "noise.png", true));
    assert_ok(sc_image_load_png(&quiet, "noise.png", &back));
    assert_true(compare_images(&image, &back, &d));
    assert_int_equal(d.differing_px, 0);
    back.rgb[100] ^= 4;
    assert_true(compare_images(&image, &back, &d));
    assert_int_equal(d.differing_px, 1);
    assert_int_equal(d.largest, 4);
    unlink("noise.png");
}

TEST(the_hash_depends_on_size_and_pixels)
{
    SC_OWN(sc_image_clear) sc_image wide = noise(8, 4, 9), tall = noise(4, 8, 9);
    uint64_t before = sc_image_hash(&wide);

    assert_memory_equal(wide.rgb, tall.rgb, 96);
    assert_int_not_equal(sc_image_hash(&wide), sc_image_hash(&tall));
    wide.rgb[95] ^= 1;
    assert_int_not_equal(sc_image_hash(&wide), before);
}

/* A picture with alpha is another one than without, also where it is opaque. */
TEST(a_png_file_keeps_alpha)
{
    sc_image image, back, opaque;
    image_difference d;
    uint64_t seed = 7, before;

    assert_ok(sc_image_init_alpha(&quiet, 37, 23, true, &image));
    assert_int_equal(sc_image_bytes(&image), 37 * 23 * 4);
    for (size_t i = 0; i < sc_image_bytes(&image); i++)
        image.rgb[i] = (uint8_t)(random_bits(&seed) >> 56);
    assert_ok(sc_image_save_png(&quiet, &image, "clear.png", true));
    assert_ok(sc_image_load_png(&quiet, "clear.png", &back));
    assert_true(compare_images(&image, &back, &d));
    assert_int_equal(d.differing_px, 0);
    assert_int_equal(sc_image_hash(&back), sc_image_hash(&image));
    before = sc_image_hash(&image);
    image.rgb[4 * (37 * 23 - 1) + 3] ^= 1; /* alpha of the last pixel */
    assert_int_not_equal(sc_image_hash(&image), before);
    assert_true(compare_images(&image, &back, &d));
    assert_int_equal(d.differing_px, 1);

    opaque = noise(37, 23, 5);
    assert_false(compare_images(&opaque, &back, &d));
    assert_ok(sc_image_save_png(&quiet, &opaque, "clear.png", true));
    sc_image_clear(&back);
    assert_ok(sc_image_load_png(&quiet, "clear.png", &back));
    assert_false(back.alpha);
    unlink("clear.png");
    sc_image_clear(&image);
    sc_image_clear(&back);
    sc_image_clear(&opaque);
}

TEST(flattening_puts_a_colour_behind)
{
    static const uint8_t pixels[] = {10, 20, 30, 255, 200, 100, 0, 51, 0, 0, 0, 0};
    static const uint8_t behind[3] = {0, 200, 255};
    static const uint8_t expected[] = {10, 20, 30, 40, 180, 204, 0, 200, 255};
    SC_OWN(sc_image_clear) sc_image image = {0};

    assert_ok(sc_image_init_alpha(&quiet, 3, 1, true, &image));
    memcpy(image.rgb, pixels, sizeof pixels);
    sc_image_flatten(&image, behind);
    assert_false(image.alpha);
    assert_memory_equal(image.rgb, expected, sizeof expected);
    sc_image_flatten(&image, pixels); /* an opaque picture stays as it is */
    assert_memory_equal(image.rgb, expected, sizeof expected);
}

TEST(every_srgb_level_converts_to_linear_light_and_back)
{
    sc_srgb_table table;

    sc_srgb_table_init(&table);
    for (int level = 0; level < 256; level++)
        assert_int_equal(sc_srgb_level(&table, (float)sc_srgb_to_linear(level / 255.0)), level);
    assert_int_equal(sc_srgb_level(&table, -1), 0);
    assert_int_equal(sc_srgb_level(&table, 7), 255);
    assert_int_equal(sc_srgb_level(&table, (float)NAN), 0);
    for (int i = 1; i < 100000; i++) /* brighter light never gives a lower level */
        assert_true(sc_srgb_level(&table, (float)i / 100000) >=
                    sc_srgb_level(&table, (float)(i - 1) / 100000));
}

/* A header that says more than the file can hold is refused before the pixels are allocated. */
TEST(a_png_too_short_for_its_size_is_refused)
{
    static const unsigned char png[] = {
        0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48,
        0x44, 0x52, 0x00, 0x00, 0xea, 0x60, 0x00, 0x00, 0xea, 0x60, 0x01, 0x00, 0x00, 0x00,
        0x00, 0xa8, 0xa9, 0x48, 0xef, 0x00, 0x00, 0x00, 0x09, 0x49, 0x44, 0x41, 0x54, 0x78,
        0x9c, 0x63, 0x00, 0x00, 0x00, 0x01, 0x00, 0x01, 0x5e, 0xff, 0x7d, 0xf9};
    long allocations = 0;
    sc_ctx ctx = *listening_anew();
    sc_image image = {0};

    ctx.alloc_budget = &allocations;
    assert_ok(sc_file_write(&quiet, "huge.png", png, sizeof png));
    assert_int_equal(sc_image_load_png(&ctx, "huge.png", &image), SC_ERR_DATA);
    assert_non_null(strstr(said.text, "60000 x 60000"));
    unlink("huge.png");
}

/* A chunk that says it is longer than the file (1.9 GB) is not allocated. */
TEST(a_png_with_a_chunk_beyond_its_end_is_refused)
{
    static const unsigned char png[] = {
        0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44,
        0x52, 0x00, 0x00, 0x00, 0x03, 0x00, 0x00, 0x00, 0x02, 0x08, 0x02, 0x00, 0x00, 0x00, 0x12,
        0x16, 0xf1, 0x4d, 0x73, 0x50, 0x4c, 0x54, 0x69, 0x54, 0x58, 0x74, 0x49, 0x44, 0x41, 0x54};
    sc_image image = {0};

    assert_ok(sc_file_write(&quiet, "chunk.png", png, sizeof png));
    assert_int_equal(sc_image_load_png(&listening, "chunk.png", &image), SC_ERR_DATA);
    assert_non_null(strstr(said.text, "cut off"));
    unlink("chunk.png");
}

TEST(pictures_mix_in_linear_light)
{
    SC_OWN(sc_image_clear) sc_image a = noise(7, 5, 1), b = noise(7, 5, 2), mixed = noise(7, 5, 1);
    const uint8_t grey[3] = {100, 150, 200};
    sc_mixer mixer;

    sc_mixer_init(&mixer);
    sc_image_mix(&mixer, &b, 0.25F, 1, 4, &mixed);
    for (size_t i = 0; i < sc_image_bytes(&a); i++) {
        const double light =
            0.25 * sc_srgb_to_linear(a.rgb[i] / 255.0) + 0.75 * sc_srgb_to_linear(b.rgb[i] / 255.0);
        const double level = sc_srgb_to_linear(mixed.rgb[i] / 255.0);

        if (i < 21 || i >= 84) /* another row */
            assert_int_equal(mixed.rgb[i], a.rgb[i]);
        else
            assert_true(fabs(level - light) < 0.006); /* half a level */
    }
    sc_image_mix(&mixer, &b, 0, 0, 5, &mixed);
    assert_memory_equal(mixed.rgb, b.rgb, sc_image_bytes(&b));
    sc_image_mix(&mixer, &a, 1, 0, 5, &mixed);
    assert_memory_equal(mixed.rgb, b.rgb, sc_image_bytes(&b));
    sc_image_fade(&mixer, grey, 0, 0, 1, &mixed);
    assert_memory_equal(mixed.rgb, grey, 3);
    assert_memory_equal(mixed.rgb + 21, b.rgb + 21, 84);
}

/* Of pixels with alpha, what covers more counts more, and what covers nothing has no colour. */
TEST(clear_pictures_mix_by_what_they_cover)
{
    uint8_t mine[12] = {200, 10, 30, 255, 0, 0, 0, 0, 50, 60, 70, 128};
    uint8_t theirs[12] = {0, 0, 0, 0, 0, 0, 0, 0, 50, 60, 70, 128};
    static const uint8_t expected[12] = {200, 10, 30, 128, 0, 0, 0, 0, 50, 60, 70, 128};
    const sc_image other = {3, 1, theirs, true};
    sc_image image = {3, 1, mine, true};
    sc_mixer mixer;

    sc_mixer_init(&mixer);
    sc_image_mix(&mixer, &other, 0.5F, 0, 1, &image);
    assert_memory_equal(mine, expected, 12);
    sc_image_fade(&mixer, theirs, 0.5F, 0, 1, &image);
    assert_int_equal(mine[0], 200);
    assert_int_equal(mine[3], 64);
}

RUN_TESTS(NULL, NULL)
