/* SPDX-License-Identifier: BSD-3-Clause */
/* Colours by values: maps, scales, and whose value a row of a table is. */
#include "check.h"

#include "segcast/color_by.h"

#include <math.h>
#include <unistd.h>

enum { LABELS = 6 };

/* A volume of five tissues with voxels of 1000 mm3. Two names differ by case only. */
static sc_label labels[LABELS] = {
    {.name = "background"},        {.value = 3, .name = "Left_Atrium"},
    {.value = 7, .name = "aorta"}, {.value = 8, .name = "Aorta"},
    {.value = 20, .name = ""},     {.value = 21, .name = "fat"}};
static sc_label_stats stats[LABELS] = {{.voxels = 100}, {.voxels = 5},  {.voxels = 2},
                                       {.voxels = 1},   {.voxels = 10}, {.voxels = 0}};

static sc_prepared make_volume(void)
{
    sc_prepared v = {.label_count = LABELS, .labels = labels, .stats = stats};

    v.to_ras_mm.m[0][0] = v.to_ras_mm.m[1][1] = v.to_ras_mm.m[2][2] = 10;
    return v;
}

/* Find the values of a table with this text. */
static sc_status values_of(const char *text, double values[LABELS])
{
    const sc_ctx *ctx = listening_anew();
    const sc_color_by by = {.table = "c.csv"};
    const sc_prepared volume = make_volume();
    char title[SC_NAME_BYTES];
    sc_status status;

    write_text("c.csv", text);
    status = sc_color_values(ctx, &by, &volume, values, title);
    unlink("c.csv");
    if (status == SC_OK)
        assert_string_equal(title, "x");
    return status;
}

TEST(rows_find_their_labels)
{
    double v[LABELS];

    assert_int_equal(values_of("id,x\n21,5\n3,1\n0,9\n20,n/a\n", v), SC_OK);
    assert_true(v[1] == 1 && isnan(v[2]) && isnan(v[3]) && isnan(v[4]) && v[5] == 5);
    assert_int_equal(said.warnings, 0);
    assert_int_equal(values_of("id,name,x\n3,LEFT ATRIUM,1\n7,fat,1\n", v), SC_OK);
    assert_non_null(strstr(said.text, "c.csv:3: label 7 is \"fat\" in the table, but \"aorta\""));
    /* Names: as they are written, or by their words. */
    assert_int_equal(values_of("name,x\nleft-atrium,1\nAorta,2\naorta,3\n", v), SC_OK);
    assert_true(v[1] == 1 && v[2] == 3 && v[3] == 2 && isnan(v[0]));
    assert_int_equal(values_of("name,x\nAORTA,4\nliver,9\nspleen,9\n", v), SC_OK);
    assert_true(v[2] == 4 && v[3] == 4 && isnan(v[1]));
    assert_non_null(strstr(said.text, "c.csv:3: \"liver\" is no label of the volume; 2 such rows"));
}

TEST(mistakes_in_rows_are_told)
{
    double v[LABELS];

    assert_int_equal(values_of("id,x\n3,1\n7,1\n3,2\n", v), SC_ERR_DATA);
    assert_non_null(strstr(said.text, "c.csv:4: is a second row of \"Left_Atrium\" (label 3), "
                                      "which line 2 has already"));
    assert_int_equal(values_of("name,x\nAORTA,1\naorta,2\n", v), SC_ERR_DATA);
    assert_int_equal(values_of("name,x\nliver,1\n", v), SC_ERR_DATA);
    assert_non_null(strstr(said.text, "nor is any other row"));
}

TEST(measures_have_units)
{
    const sc_ctx ctx = {0};
    sc_color_by by = {.has_measure = true, .measure = SC_MEASURE_VOLUME};
    sc_prepared volume = make_volume();
    double v[LABELS];
    char title[SC_NAME_BYTES];

    assert_int_equal(sc_color_values(&ctx, &by, &volume, v, title), SC_OK);
    assert_true(v[1] == 5 && v[4] == 10 && isnan(v[5]) && isnan(v[0]));
    assert_string_equal(title, "Volume (ml)");
    by.measure = SC_MEASURE_THICKNESS;
    stats[1].thickness_mm = 4;
    assert_int_equal(sc_color_values(&ctx, &by, &volume, v, title), SC_OK);
    assert_true(v[1] == 4 && isnan(v[5]));
    by.measure = SC_MEASURE_SURFACE;
    stats[1].surface_mm2 = 250;
    assert_int_equal(sc_color_values(&ctx, &by, &volume, v, title), SC_OK);
    assert_true(v[1] == 2.5);
}

TEST(maps_end_where_they_should)
{
    uint8_t rgb[3];

    sc_color_map_at(SC_MAP_VIRIDIS, -1, rgb);
    assert_true(rgb[0] == 0x44 && rgb[1] == 0x01 && rgb[2] == 0x54);
    sc_color_map_at(SC_MAP_CIVIDIS, 2, rgb);
    assert_true(rgb[0] == 0xff && rgb[1] == 0xea && rgb[2] == 0x46);
    sc_color_map_at(SC_MAP_COOLWARM, 0.5, rgb);
    assert_true(rgb[0] == 0xdd && rgb[1] == 0xdd && rgb[2] == 0xdd);
    sc_color_map_at(SC_MAP_MAGMA, 0.5, rgb); /* as matplotlib has it, 183, 55, 121 */
    assert_true(abs(rgb[0] - 183) < 3 && abs(rgb[1] - 55) < 3 && abs(rgb[2] - 121) < 3);
}

/* @return the brightness of a colour, in linear light. */
static double luminance(const uint8_t rgb[3])
{
    return 0.2126 * pow(rgb[0] / 255.0, 2.2) + 0.7152 * pow(rgb[1] / 255.0, 2.2) +
           0.0722 * pow(rgb[2] / 255.0, 2.2);
}

TEST(sequential_maps_grow_brighter)
{
    for (sc_color_map map = SC_MAP_VIRIDIS; map <= SC_MAP_PLASMA; map++) {
        double before = -1;

        for (int i = 0; i <= 40; i++) {
            uint8_t rgb[3];

            sc_color_map_at(map, i / 40.0, rgb);
            assert_true(luminance(rgb) > before);
            before = luminance(rgb);
        }
    }
}

TEST(scales_follow_the_values_shown)
{
    sc_color_by by = {.range_auto = true, .map = SC_MAP_COOLWARM, .missing = {1, 2, 3}};
    double v[LABELS] = {NAN, -1, 3, 2, NAN, 50}; /* the last has no voxels */
    const uint8_t hidden[LABELS] = {0, 0, 1, 0, 0, 0};
    sc_prepared volume = make_volume();
    sc_color_scale scale;
    uint8_t rgb[3];

    sc_color_scale_find(&by, &volume, v, 1, "title", &scale);
    assert_true(scale.low == -3 && scale.high == 3 && scale.lacks_some && scale.is_used);
    assert_string_equal(scale.title, "title");
    sc_color_scale_at(&scale, NAN, rgb);
    assert_true(rgb[0] == 1 && rgb[1] == 2 && rgb[2] == 3);
    v[1] = -4;
    sc_color_scale_find(&by, &volume, v, 1, "", &scale);
    assert_true(scale.low == -4 && scale.high == 4);
    v[1] = -1;
    by.map = SC_MAP_VIRIDIS;
    volume.how.hidden = hidden;
    sc_color_scale_find(&by, &volume, v, 1, "", &scale);
    assert_true(scale.low == -1 && scale.high == 2);
    by.range_auto = false;
    by.low = 0;
    by.high = 10;
    sc_color_scale_find(&by, &volume, v, 1, "", &scale);
    sc_color_scale_at(&scale, 10, rgb);
    assert_true(scale.low == 0 && scale.high == 10 && rgb[0] == 0xfd);
    by.range_auto = true;
    v[1] = -1e308; /* whose distance is no finite number */
    v[3] = 1e308;
    sc_color_scale_find(&by, &volume, v, 1, "", &scale);
    sc_color_scale_at(&scale, 1e308, rgb);
    assert_true(rgb[0] == 0xfd);
    for (int id = 0; id < LABELS; id++)
        v[id] = 4; /* all the same: the middle of the map */
    by.range_auto = true;
    sc_color_scale_find(&by, &volume, v, 1, "", &scale);
    sc_color_scale_at(&scale, 4, rgb);
    assert_true(scale.low == 4 && scale.high == 4 && !scale.lacks_some && rgb[0] == 0x21);
}

TEST(values_change_along_the_map)
{
    sc_color_by by = {.range_auto = true, .missing = {0, 0, 100}};
    double v[2 * LABELS] = {NAN, 0, 1, 1, 1, 1, /* the second column: */ NAN, 1, 1, 10, NAN, 1};
    sc_prepared volume = make_volume();
    sc_color_scale scale;
    uint8_t rgb[3], other[3];

    sc_color_scale_find(&by, &volume, v, 2, "", &scale);
    assert_true(scale.low == 0 && scale.high == 10 && scale.lacks_some);
    for (int i = 0; i <= 20; i++) { /* never a mixture of the colours of both ends */
        sc_color_scale_between(&scale, 2, 8, i / 20.0, rgb);
        sc_color_scale_at(&scale, 2 + 6 * (i / 20.0), other);
        for (int c = 0; c < 3; c++)
            assert_true(abs(rgb[c] - other[c]) <= 1);
    }
    sc_color_scale_between(&scale, NAN, NAN, 0.5, rgb);
    assert_memory_equal(rgb, by.missing, 3);
    sc_color_scale_between(&scale, NAN, 10, 0.5, rgb); /* half way from 0x000064 to 0xfde725 */
    assert_true(rgb[0] == 127 && rgb[1] == 116 && abs(rgb[2] - 69) <= 1);
    sc_color_scale_between(&scale, 10, NAN, 1, rgb);
    assert_memory_equal(rgb, by.missing, 3);
}

RUN_TESTS(NULL, NULL)
