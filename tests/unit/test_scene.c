/* SPDX-License-Identifier: BSD-3-Clause */
#include "check.h"

#include "segcast/image.h"
#include "segcast/scene.h"
#include "shapes.h"

#include <math.h>

static bool point_is_kept(const sc_plane *planes, int count, sc_clip_mode mode, sc_vec3 p)
{
    int kept = 0;

    for (int i = 0; i < count; i++)
        kept += sc_vec3_dot(planes[i].normal, p) + planes[i].offset_mm >= 0;
    return mode == SC_CLIP_KEEP ? kept == count : kept > 0;
}

static bool interval_holds(const sc_interval *kept, int count, double t)
{
    for (int i = 0; i < count; i++) {
        if (t >= kept[i].begin_mm && t < kept[i].end_mm)
            return true;
    }
    return false;
}

/* Random rays, some of them parallel to the planes, are clipped and compared with the half-spaces
 * at points along them. */
TEST(clipped_rays_agree_with_the_half_spaces)
{
    uint64_t seed = 17;

    for (int n = 0; n < 4000; n++) {
        sc_plane planes[3];
        const int count = 1 + n % 3;
        const sc_clip_mode mode = n & 1 ? SC_CLIP_CUT : SC_CLIP_KEEP;
        const sc_vec3 origin = {random_real(&seed, -9, 9), random_real(&seed, -9, 9), 0};
        sc_vec3 direction = {random_real(&seed, -1, 1), random_real(&seed, -1, 1), 1};
        sc_interval kept[2];
        int parts;

        if (n % 7 == 0)
            direction = (sc_vec3){0, 0, 1};
        direction = sc_vec3_unit(direction);
        for (int i = 0; i < count; i++) {
            const sc_vec3 normal = {random_real(&seed, -1, 1), random_real(&seed, -1, 1),
                                    n % 7 == 0 ? 0 : random_real(&seed, -1, 1)};

            planes[i] = (sc_plane){sc_vec3_unit(normal), random_real(&seed, -5, 5)};
        }
        parts = sc_clip_ray(planes, (1u << count) - 1, mode, origin, direction, -10, 10, kept);
        for (double t = -9.97; t < 10; t += 0.1) {
            bool near_an_end = false;

            for (int i = 0; i < parts; i++)
                near_an_end = near_an_end || fabs(t - kept[i].begin_mm) < 1e-9 ||
                              fabs(t - kept[i].end_mm) < 1e-9;
            if (!near_an_end)
                assert_int_equal(
                    interval_holds(kept, parts, t),
                    point_is_kept(planes, count, mode, sc_vec3_along(origin, t, direction)));
        }
        for (int i = 0; i < parts; i++) { /* a part that begins at a plane begins on it */
            const sc_plane *plane = &planes[kept[i].begin_plane < 0 ? 0 : kept[i].begin_plane];
            const sc_vec3 at = sc_vec3_along(origin, kept[i].begin_mm, direction);

            assert_int_equal(kept[i].begin_plane < 0, kept[i].begin_mm == -10);
            if (kept[i].begin_plane >= 0)
                assert_near(sc_vec3_dot(plane->normal, at) + plane->offset_mm, 0, 1e-9);
        }
    }
}

TEST(one_plane_cuts_the_same_in_both_modes)
{
    const sc_plane plane = {{0, 0, 1}, -2};
    sc_interval a[2], b[2];

    assert_int_equal(
        sc_clip_ray(&plane, 1, SC_CLIP_KEEP, (sc_vec3){0, 0, 0}, (sc_vec3){0, 0, 1}, 0, 9, a), 1);
    assert_int_equal(
        sc_clip_ray(&plane, 1, SC_CLIP_CUT, (sc_vec3){0, 0, 0}, (sc_vec3){0, 0, 1}, 0, 9, b), 1);
    assert_near(a[0].begin_mm, 2, 0);
    assert_near(b[0].begin_mm, 2, 0);
    assert_int_equal(a[0].begin_plane, 0);
    assert_int_equal(b[0].begin_plane, 0);
}

static int stripes(double x, double y, double z)
{
    return (int)x / 4;
}

static prepared_copy striped(sc_volume *volume)
{
    const int size[3] = {20, 6, 6};
    const double spacing[3] = {1, 1, 1};

    *volume = shape_volume(size, spacing, 1, 5, stripes);
    snprintf(volume->labels[1].name, SC_NAME_BYTES, "Left Atrium");
    snprintf(volume->labels[2].name, SC_NAME_BYTES, "left ventricle");
    snprintf(volume->labels[3].name, SC_NAME_BYTES, "right ventricle");
    volume->labels[4].hidden = true;
    return prepare_copy(volume, 1);
}

TEST(rules_match_by_name_glob_and_number_and_the_last_one_wins)
{
    SC_OWN(sc_volume_clear) sc_volume volume = {0};
    SC_OWN(clear_copy) prepared_copy p = striped(&volume);
    sc_tissue tissues[5];
    const sc_tissue_rule rules[] = {
        {.pattern = "*", .has.opacity = true, .opacity = 0.5},
        {.pattern = "left *", .has.visible = true, .visible = false},
        {.pattern = "LEFT atrium", .has.visible = true, .visible = true},
        {.pattern = "9", .has.color = true, .rgb = {255, 0, 0}},
        {.pattern = "12", .has.visible = true, .visible = true},
    };

    sc_transfer_resolve(&p.view, rules, 4, SC_OPACITY_MEASURED, tissues);
    assert_false(tissues[0].visible);
    assert_true(tissues[1].visible);
    assert_false(tissues[2].visible);
    assert_near(tissues[3].rgb_linear[0], 1, 1e-6);
    assert_near(tissues[3].opacity, 0.5, 0);
    assert_false(tissues[4].visible); /* the table makes it invisible */
    sc_transfer_resolve(&p.view, rules, 5, SC_OPACITY_MEASURED, tissues);
    assert_true(tissues[4].visible);
}

TEST(a_rule_that_matches_nothing_is_refused_with_the_nearest_name)
{
    SC_OWN(sc_volume_clear) sc_volume volume = {0};
    SC_OWN(clear_copy) prepared_copy p = striped(&volume);

    assert_int_equal(sc_pattern_check(&listening, &p.view, "left ventrical", "job.yaml:7"),
                     SC_ERR_DATA);
    assert_string_equal(said.text, "job.yaml:7: tissue \"left ventrical\" matches no label of the "
                                   "volume; did you mean \"left ventricle\"?");
}

/* @return the values of the labels that a pattern means, as the digits of a decimal number. */
static int meant(const char *pattern, const sc_label *labels, int count)
{
    const sc_pattern p = sc_pattern_of(pattern);
    const sc_match best = sc_pattern_match(labels, count, &p);
    int out = 0;

    for (int id = 1; id < count && best != SC_MATCH_NONE; id++)
        out = sc_label_match(&labels[id], &p) == best ? 10 * out + (int)labels[id].value : out;
    return out;
}

/* Names are found however words are separated and whatever their case, but a name that fits exactly
 * wins. */
TEST(names_match_however_they_are_written)
{
    const sc_label labels[8] = {
        {.value = 0},
        {.value = 1, .name = "left atrium"},
        {.value = 2, .name = "Left-Ventricle"},
        {.value = 3, .name = "left_ventricle_wall"},
        {.value = 4, .name = "Liver"},
        {.value = 5, .name = "liver"},
        {.value = 6},
        {.value = 7, .name = "a-b_c [x]"},
    };
    static const struct {
        const char *pattern;
        int values;
    } cases[] = {{"left atrium", 1},
                 {"left_atrium", 1},
                 {"LEFT-ATRIUM", 1},
                 {" left  atrium_", 1},
                 {"leftatrium", 0},
                 {"left_ventricle", 2},
                 {"left ventricle wall", 3},
                 {"left_*", 3}, /* it fits exactly here, as it always did */
                 {"LEFT *", 1},
                 {"left-ven*", 2},
                 {"left?ventricle*", 23},
                 {"*[x-z]entricle*", 0},
                 {"*[u-w]entricle wall", 3},
                 {"Liver", 4},
                 {"liver", 5},
                 {"LIVER", 45},
                 {"a-b_c [x]", 7},
                 {"A b c [x]", 7},
                 {"6", 6},
                 {"*", 1234567},
                 {"_", 0},
                 {"", 0}};

    for (size_t i = 0; i < SC_COUNT_OF(cases); i++) {
        if (meant(cases[i].pattern, labels, 8) != cases[i].values)
            fail_msg("\"%s\" means %d, expected %d", cases[i].pattern,
                     meant(cases[i].pattern, labels, 8), cases[i].values);
    }
}

/* Check that the pattern is refused with this message; NULL: that it is right. */
static void expect_message(const sc_label *labels, int count, const char *pattern,
                           const char *message)
{
    const sc_prepared volume = {.label_count = count, .labels = labels};
    const sc_ctx *ctx = listening_anew();
    const sc_status status = sc_pattern_check(ctx, &volume, pattern, "job.yaml:7");

    assert_int_equal(status, message ? SC_ERR_DATA : SC_OK);
    assert_string_equal(said.text, message ? message : "");
}

TEST(a_tissue_that_is_not_clear_is_told)
{
    const sc_label named[5] = {{.value = 0},
                               {.value = 1, .name = "left-atrium"},
                               {.value = 2, .name = "left_atrium"},
                               {.value = 3, .name = "vein"},
                               {.value = 4, .name = "vein"}};
    const sc_label nameless[3] = {{.value = 0}, {.value = 4}, {.value = 17}};

    expect_message(
        named, 5, "left atrium",
        "job.yaml:7: tissue \"left atrium\" could be \"left-atrium\" (label 1) or "
        "\"left_atrium\" (label 2); write the name exactly as it is there, or the number");
    expect_message(named, 5, "left_atrium", NULL);
    expect_message(named, 5, "left*", NULL);
    expect_message(named, 5, "Vein", NULL);
    expect_message(named, 5, "atrium",
                   "job.yaml:7: tissue \"atrium\" matches no label of the volume; did you mean "
                   "\"left-atrium\" or \"left_atrium\"?");
    expect_message(named, 5, "77", "job.yaml:7: tissue \"77\" matches no label of the volume");
    expect_message(nameless, 3, "aorta",
                   "job.yaml:7: tissue \"aorta\" cannot be found: the labels of the volume have no "
                   "names; name tissues by number (4 to 17), or give a table with their names "
                   "(labels:)");
    expect_message(nameless, 3, "17", NULL);
    expect_message(nameless, 1, "*", NULL);
}

TEST(thicker_tissues_are_more_opaque)
{
    const sc_opacity_scale scale = {0.3, 0.9, 1, 30}, point = {0.3, 0.9, 5, 5},
                           none = {0.3, 0.9, 0, 0};

    assert_near(sc_auto_opacity(&scale, 1), 0.3, 1e-12);
    assert_near(sc_auto_opacity(&scale, 30), 0.9, 1e-12);
    assert_near(sc_auto_opacity(&scale, 0.1), 0.3, 0);
    assert_near(sc_auto_opacity(&scale, 100), 0.9, 1e-12);
    assert_near(sc_auto_opacity(&scale, 0), 0.9, 0);
    assert_true(sc_auto_opacity(&scale, 3) < sc_auto_opacity(&scale, 4));
    assert_near(sc_auto_opacity(&point, 5), 0.9, 0);
    assert_near(sc_auto_opacity(&none, 5), 0.9, 0);
}

/* A tube whose radius, its mean thickness, is 15 mm is 30 mm thick everywhere; a skin of 1 mm is as
 * thin everywhere as on the whole. One tissue alone stays as opaque as it can be. */
TEST(local_opacities_are_those_of_diameters)
{
    const sc_opacity_scale local = sc_local_opacity_scale((sc_opacity_scale){0.5, 0.95, 1, 15});
    const sc_opacity_scale point = sc_local_opacity_scale((sc_opacity_scale){0.3, 0.9, 5, 5});

    assert_near(sc_auto_opacity(&local, 30), 0.95, 1e-12);
    assert_true(sc_auto_opacity(&local, 25) < 0.95);
    assert_near(sc_auto_opacity(&local, 1), 0.5, 1e-12);
    assert_near(sc_auto_opacity(&point, 5), 0.9, 0);
}

/* Eight vertebrae of 6.5 to 7.6 mm look alike, and a model of them in a tenth of the size looks
 * as they do; the paper's rule makes one of them a ghost. */
TEST(automatic_opacity_is_absolute)
{
    enum { COUNT = 9 };
    sc_label_stats stats[COUNT] = {{0}}, small[COUNT];
    sc_label labels[COUNT] = {{0}};
    sc_tissue tissues[COUNT], paper[COUNT], model[COUNT];
    sc_prepared volume = {.label_count = COUNT, .labels = labels, .stats = stats};

    for (int i = 0; i < 3; i++)
        volume.to_ras_mm.m[i][i] = 1.5;
    for (int id = 1; id < COUNT; id++) {
        labels[id] = (sc_label){.value = id, .opacity = -1};
        stats[id] = (sc_label_stats){.voxels = 100,
                                     .thickness_mm = 6.5 + (7.6 - 6.5) * (id - 1) / (COUNT - 2),
                                     .low = {0, 0, 20 * id},
                                     .high = {60, 60, 20 * id + 18}};
    }
    sc_transfer_resolve(&volume, NULL, 0, SC_OPACITY_MEASURED, tissues);
    sc_transfer_resolve(&volume, NULL, 0, SC_OPACITY_PAPER, paper);
    assert_near(tissues[1].opacity, 0.5 + 0.45 * log(6.5) / log(15), 1e-9);
    assert_true(tissues[COUNT - 1].opacity - tissues[1].opacity < 0.03);
    assert_near(paper[1].opacity, 0.3, 1e-9);
    assert_near(paper[COUNT - 1].opacity, 0.9, 1e-9);
    memcpy(small, stats, sizeof stats);
    for (int id = 1; id < COUNT; id++)
        small[id].thickness_mm *= 0.01;
    for (int i = 0; i < 3; i++)
        volume.to_ras_mm.m[i][i] *= 0.01;
    volume.stats = small;
    sc_transfer_resolve(&volume, NULL, 0, SC_OPACITY_MEASURED, model);
    assert_true(fabs(model[4].opacity - tissues[4].opacity) < 0.2);
    assert_true(model[COUNT - 1].opacity - model[1].opacity < 0.03);
}

/* Three shells about a core of two halves: the outermost is a veil, the next nearly invisible, the
 * halves are solid. Given opacities stay, and the paper knows no covers. */
static int onion(double x, double y, double z)
{
    const double r = sqrt((x - 20) * (x - 20) + (y - 20) * (y - 20) + (z - 20) * (z - 20));

    return r > 19 ? 0 : r > 15 ? 1 : r > 11 ? 2 : x < 20 ? 3 : 4;
}

TEST(covers_step_back)
{
    const sc_tissue_rule solid = {.pattern = "tissue 1", .has.opacity = true, .opacity = 1};
    SC_OWN(sc_volume_clear)
    sc_volume v = shape_volume((const int[3]){40, 40, 40}, (const double[3]){3, 3, 3}, 1, 5, onion);
    SC_OWN(clear_copy) prepared_copy p = prepare_copy(&v, 2);
    sc_tissue tissues[5];

    assert_int_equal(p.view.stats[1].cover_layer, 1);
    assert_int_equal(p.view.stats[2].cover_layer, 2);
    assert_int_equal(p.view.stats[3].cover_layer, 0);
    assert_near(p.view.stats[1].shown, 1, 0);
    assert_near(p.view.stats[2].shown, 0, 0);
    sc_transfer_resolve(&p.view, NULL, 0, SC_OPACITY_MEASURED, tissues);
    assert_true(tissues[1].is_cover && tissues[1].opacity > 0.1 && tissues[1].opacity < 0.2);
    assert_true(tissues[2].is_cover && tissues[2].opacity < 0.1);
    assert_true(!tissues[3].is_cover && tissues[3].opacity > 0.7);
    assert_near(tissues[3].opacity, tissues[4].opacity, 0.02);
    sc_transfer_resolve(&p.view, &solid, 1, SC_OPACITY_MEASURED, tissues);
    assert_near(tissues[1].opacity, 1, 0);
    sc_transfer_resolve(&p.view, NULL, 0, SC_OPACITY_PAPER, tissues);
    assert_true(!tissues[1].is_cover && tissues[1].opacity >= 0.3);
}

/* What a name calls left over is hidden, unless there is nothing else, or a rule or a table says
 * how it looks; and a brain, whose parts tile it, is opaque. */
TEST(names_decide_what_is_hidden_and_what_is_opaque)
{
    sc_label_stats stats[3] = {{0}};
    sc_label labels[3] = {{0}, {.value = 1, .opacity = -1}, {.value = 2, .opacity = -1}};
    const sc_prepared volume = {.label_count = 3, .labels = labels, .stats = stats};
    const sc_tissue_rule all = {.pattern = "*", .has.opacity = true, .opacity = 1};
    const sc_tissue_rule none = {.pattern = "aorta", .has.visible = true};
    const sc_tissue_rule shown = {.pattern = "*other", .has.visible = true, .visible = true};
    sc_tissue tissues[3];
    bool hidden[3];

    for (int id = 1; id < 3; id++)
        stats[id] = (sc_label_stats){.voxels = 9, .thickness_mm = 5, .high = {9, 9, 9}};
    snprintf(labels[1].name, SC_NAME_BYTES, "aorta");
    snprintf(labels[2].name, SC_NAME_BYTES, "heart_other");
    sc_transfer_resolve(&volume, NULL, 0, SC_OPACITY_MEASURED, tissues);
    assert_true(!tissues[1].is_cover && tissues[1].opacity > 0.7 && tissues[1].opacity < 1);
    assert_true(tissues[2].is_rest && !tissues[2].visible && tissues[2].opacity == 0);
    assert_ok(sc_hidden_labels(&quiet, labels, 3, NULL, 0, hidden));
    assert_true(!hidden[1] && hidden[2]);
    sc_transfer_resolve(&volume, &all, 1, SC_OPACITY_MEASURED, tissues);
    assert_true(!tissues[2].is_rest && tissues[2].visible);
    assert_near(tissues[2].opacity, 1, 0);
    sc_transfer_resolve(&volume, &shown, 1, SC_OPACITY_MEASURED, tissues);
    assert_true(tissues[2].visible && tissues[2].opacity > 0.7);
    sc_transfer_resolve(&volume, &none, 1, SC_OPACITY_MEASURED, tissues);
    assert_true(!tissues[1].visible && tissues[2].visible && tissues[2].opacity > 0.7);
    labels[2].opacity = 0.5F;
    sc_transfer_resolve(&volume, NULL, 0, SC_OPACITY_MEASURED, tissues);
    assert_near(tissues[2].opacity, 0.5, 0);
    labels[2].opacity = -1;
    snprintf(labels[1].name, SC_NAME_BYTES, "ctx-lh-bankssts");
    snprintf(labels[2].name, SC_NAME_BYTES, "Left-Cerebral-White-Matter");
    sc_transfer_resolve(&volume, NULL, 0, SC_OPACITY_MEASURED, tissues);
    assert_near(tissues[1].opacity, 1, 0);
    assert_near(tissues[2].opacity, 1, 0);
    sc_transfer_resolve(&volume, NULL, 0, SC_OPACITY_PAPER, tissues);
    assert_true(tissues[1].opacity < 1);
}

/* A veil round a skull in two layers, each with openings, round two halves; or ribs, bands round an
 * axis, instead of the skull. */
static int head(double x, double y, double z)
{
    const double r = sqrt((x - 20) * (x - 20) + (y - 20) * (y - 20) + (z - 20) * (z - 20));
    const int part = (int)(x / 5) + (int)(y / 5) + (int)(z / 5);

    return r > 19 ? 0 : r > 17 ? 1 : r > 13 ? 2 + part % 2 : x < 20 ? 4 : 5;
}

static int chest(double x, double y, double z)
{
    const double r = hypot(x - 20, y - 20);

    return r > 19 ? 0 : r > 17 ? 1 : r > 14 && (int)(z / 4) % 2 ? 2 : r > 14 ? 0 : x < 20 ? 4 : 5;
}

TEST(a_skull_in_parts_steps_back_and_ribs_do_not)
{
    const int size[3] = {40, 40, 40};
    SC_OWN(sc_volume_clear)
    sc_volume v = shape_volume(size, (const double[3]){3, 3, 3}, 1, 6, head);
    SC_OWN(sc_volume_clear)
    sc_volume w = shape_volume(size, (const double[3]){3, 3, 3}, 1, 6, chest);
    int layers[6], cover;

    assert_ok(sc_find_covers(&quiet, &v, NULL, layers, NULL));
    assert_int_equal(layers[1], 1);
    assert_ok(sc_find_outer_cover(&quiet, &v, &cover));
    assert_int_equal(cover, 1);
    assert_true(layers[2] > 1 && layers[3] > 1);
    assert_int_equal(layers[4] + layers[5], 0);
    assert_ok(sc_find_covers(&quiet, &w, NULL, layers, NULL));
    assert_int_equal(layers[1], 1);
    assert_int_equal(layers[2] + layers[4] + layers[5], 0);
}

/* Only where tissues as light as white are much of what is seen, white gives way to slate, from
 * which all colours of the palette keep away. */
TEST(white_tissues_get_a_dark_background)
{
    sc_label_stats stats[3] = {
        {.shown = 0}, {.voxels = 9, .shown = 0.95}, {.voxels = 9, .shown = 0.05}};
    const sc_prepared volume = {.label_count = 3, .stats = stats};
    sc_tissue tissues[3] = {{.visible = false},
                            {.visible = true, .rgb_linear = {0.5f, 0.1f, 0.1f}},
                            {.visible = true, .rgb_linear = {0.93f, 0.93f, 0.9f}}};
    sc_seen_color slate;
    uint8_t rgb[3];

    sc_choose_background(&volume, tissues, rgb);
    assert_int_equal(rgb[0], 255);
    stats[2].shown = 0.4;
    tissues[2].visible = false;
    sc_choose_background(&volume, tissues, rgb);
    assert_int_equal(rgb[0], 255);
    tissues[2].visible = true;
    sc_choose_background(&volume, tissues, rgb);
    assert_true(rgb[0] < 80);
    slate = sc_see_color(rgb);
    for (int i = 1; i <= 24; i++) {
        sc_seen_color seen;

        sc_label_base_color(i, rgb);
        seen = sc_see_color(rgb);
        for (int vision = 0; vision < SC_VISION_COUNT; vision++)
            assert_true(sc_color_distance(&slate, &seen, (sc_vision)vision) > 0.15);
    }
}

/* Colours that nobody has given keep away from any background; those that were given stay. */
TEST(automatic_colours_can_be_told_from_any_background)
{
    enum { COLORS = 24 };
    sc_tissue own[COLORS + 1] = {{0}}, tissues[COLORS + 1];
    sc_srgb_table table;
    int changed = 0;

    sc_srgb_table_init(&table);
    for (int i = 1; i <= COLORS; i++) {
        uint8_t rgb[3];

        sc_label_base_color(i, rgb);
        for (int c = 0; c < 3; c++)
            own[i].rgb_linear[c] = (float)sc_srgb_to_linear(rgb[c] / 255.0);
    }
    for (int n = 0; n < 216; n++) { /* backgrounds */
        const uint8_t background[3] = {(uint8_t)(n % 6 * 51), (uint8_t)(n / 6 % 6 * 51),
                                       (uint8_t)(n / 36 * 51)};
        const sc_seen_color behind = sc_see_color(background);

        memcpy(tissues, own, sizeof own);
        tissues[n % COLORS + 1].color_given = true;
        sc_part_from_background(COLORS + 1, background, tissues);
        for (int i = 1; i <= COLORS; i++) {
            sc_seen_color seen;
            uint8_t rgb[3];

            for (int c = 0; c < 3; c++)
                rgb[c] = sc_srgb_level(&table, tissues[i].rgb_linear[c]);
            seen = sc_see_color(rgb);
            if (tissues[i].color_given)
                assert_memory_equal(tissues[i].rgb_linear, own[i].rgb_linear, sizeof(float[3]));
            else
                assert_true(sc_color_contrast(&seen, &behind) >= SC_CONTRAST);
            changed += memcmp(tissues[i].rgb_linear, own[i].rgb_linear, sizeof(float[3])) != 0;
        }
    }
    assert_true(changed > 216 && changed < 216 * COLORS / 3); /* and only where it is needed */
}

TEST(tissues_with_the_same_exceptions_share_a_clip_set)
{
    SC_OWN(sc_volume_clear) sc_volume volume = {0};
    SC_OWN(clear_copy) prepared_copy p = striped(&volume);
    sc_tissue tissues[5] = {0};
    const sc_clip_exception exceptions[] = {{.plane = 0, .pattern = "left *"},
                                            {.plane = 1, .pattern = "left atrium"},
                                            {.plane = 1, .span = 2, .pattern = "left atrium"}};
    sc_clip_set clip_sets[SC_CLIP_SETS_MAX];
    int count;

    assert_ok(sc_clip_sets_find(&quiet, &p.view, exceptions, 3, tissues, clip_sets, &count));
    assert_int_equal(count, 3);
    assert_int_equal(clip_sets[tissues[1].clip_set].spares[0], 1);
    assert_int_equal(clip_sets[tissues[1].clip_set].spares[1], 5);
    assert_int_equal(clip_sets[tissues[2].clip_set].spares[0], 1);
    assert_int_equal(clip_sets[tissues[2].clip_set].spares[1], 0);
    assert_int_equal(tissues[3].clip_set, 0);
    assert_int_equal(clip_sets[0].spares[0], 0);
}

/* Labels that are invisible or have no opacity are hidden. */
TEST(hidden_labels_are_found)
{
    const sc_label labels[6] = {{.value = 0, .opacity = -1},
                                {.value = 1, .name = "auto", .opacity = -1},
                                {.value = 2, .name = "glass", .opacity = 0},
                                {.value = 3, .name = "off", .opacity = 1, .hidden = true},
                                {.value = 4, .name = "ruled out", .opacity = 1},
                                {.value = 5, .name = "inside", .opacity = 0}};
    const sc_tissue_rule rules[] = {
        {.pattern = "ruled out", .has.visible = true, .visible = false},
        {.pattern = "inside", .has.interior_opacity = true, .interior_opacity = 0.1},
        {.pattern = "auto", .has.opacity = true, .opacity = 0.5}};
    const bool expected[6] = {false, false, true, true, true, false};
    bool hidden[6];

    assert_ok(sc_hidden_labels(&quiet, labels, 6, rules, 3, hidden));
    for (int id = 0; id < 6; id++)
        assert_int_equal(hidden[id], expected[id]);
}

RUN_TESTS(NULL, NULL)

/* Whatever a picture follows from is told by its name, and nothing else is. */
TEST(what_differs_between_scenes_is_told)
{
    static const float half[] = {1, 0.5f}, one[] = {1, 1};
    static const float red[][3] = {{0, 0, 0}, {1, 0, 0}};
    static const sc_vec3 moved[] = {{0, 0, 0}, {0, 0, 1}};
    const sc_scene scene = {.clip.count = 1, .clip.set_count = 1, .fades = one};
    sc_scene other = scene;

#define EXPECT_CHANGE(what, bit)                                                                   \
    do {                                                                                           \
        other = scene;                                                                             \
        what;                                                                                      \
        assert_int_equal(sc_scene_changes(&scene, &other, 2), bit);                                \
        assert_int_equal(sc_scene_changes(&other, &scene, 2), bit);                                \
    } while (0)
    EXPECT_CHANGE(other.frame = 7, 0); /* what is written over the picture */
    EXPECT_CHANGE(other.camera.position_mm.x = 1, SC_CHANGED_CAMERA);
    EXPECT_CHANGE(other.camera.half_height = 1, SC_CHANGED_CAMERA);
    EXPECT_CHANGE(other.clip.planes[0].offset_mm = 1, SC_CHANGED_CUTS);
    EXPECT_CHANGE(other.clip.planes[1].offset_mm = 1, 0); /* there is none */
    EXPECT_CHANGE(other.clip.sets[0] = 1, SC_CHANGED_CUTS);
    EXPECT_CHANGE(other.point_mm.z = 1, SC_CHANGED_CUTS);
    EXPECT_CHANGE(other.look.light.ambient = 1, SC_CHANGED_LIGHT);
    EXPECT_CHANGE(other.look.light.depth_cue = 1, SC_CHANGED_LIGHT);
    EXPECT_CHANGE(other.look.grey_caps = 1, SC_CHANGED_GREY);
    EXPECT_CHANGE(other.look.grey_window.width = 1, SC_CHANGED_GREY);
    EXPECT_CHANGE(other.look.background[2] = 1, SC_CHANGED_COLORS);
    EXPECT_CHANGE(other.colors = red, SC_CHANGED_COLORS);
    EXPECT_CHANGE(other.fades = half, SC_CHANGED_OPACITIES);
    EXPECT_CHANGE(other.offsets_mm = moved, SC_CHANGED_PLACES);
#undef EXPECT_CHANGE
}
