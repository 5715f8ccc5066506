/* SPDX-License-Identifier: BSD-3-Clause */
#include "check.h"

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
static void clipped_rays_agree_with_the_half_spaces(void **state)
{
    uint64_t seed = 17;

    (void)state;
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

static void one_plane_cuts_the_same_in_both_modes(void **state)
{
    const sc_plane plane = {{0, 0, 1}, -2};
    sc_interval a[2], b[2];

    (void)state;
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
    (void)y;
    (void)z;
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

static void rules_match_by_name_glob_and_number_and_the_last_one_wins(void **state)
{
    sc_volume volume;
    prepared_copy p = striped(&volume);
    sc_tissue tissues[5];
    const sc_tissue_rule rules[] = {
        {.pattern = "*", .has_opacity = true, .opacity = 0.5},
        {.pattern = "left *", .has_visible = true, .visible = false},
        {.pattern = "LEFT atrium", .has_visible = true, .visible = true},
        {.pattern = "9", .has_color = true, .rgb = {255, 0, 0}},
        {.pattern = "12", .has_visible = true, .visible = true},
    };

    (void)state;
    assert_ok(sc_transfer_resolve(&quiet, &p.view, rules, 4, tissues));
    assert_false(tissues[0].visible);
    assert_true(tissues[1].visible);
    assert_false(tissues[2].visible);
    assert_near(tissues[3].rgb_linear[0], 1, 1e-6);
    assert_near(tissues[3].opacity, 0.5, 0);
    assert_false(tissues[4].visible); /* the table makes it invisible */
    assert_ok(sc_transfer_resolve(&quiet, &p.view, rules, 5, tissues));
    assert_true(tissues[4].visible);
    sc_free(p.block);
    sc_volume_clear(&volume);
}

static void a_rule_that_matches_nothing_is_refused_with_the_nearest_name(void **state)
{
    sc_volume volume;
    prepared_copy p = striped(&volume);
    sc_tissue tissues[5];
    heard h;
    sc_ctx ctx = listening(&h);
    const sc_tissue_rule rule = {.pattern = "left ventrical", .where = "job.yaml:7"};

    (void)state;
    assert_int_equal(sc_transfer_resolve(&ctx, &p.view, &rule, 1, tissues), SC_ERR_DATA);
    assert_string_equal(h.text, "job.yaml:7: tissue \"left ventrical\" matches no label of the "
                                "volume; did you mean \"left ventricle\"?");
    sc_free(p.block);
    sc_volume_clear(&volume);
}

static void thicker_tissues_are_more_opaque(void **state)
{
    (void)state;
    assert_near(sc_auto_opacity(1, 1, 30), 0.3, 1e-12);
    assert_near(sc_auto_opacity(30, 1, 30), 0.9, 1e-12);
    assert_true(sc_auto_opacity(3, 1, 30) < sc_auto_opacity(4, 1, 30));
    assert_near(sc_auto_opacity(5, 5, 5), 0.9, 0);
}

static void tissues_with_the_same_exceptions_share_a_clip_set(void **state)
{
    sc_volume volume;
    prepared_copy p = striped(&volume);
    sc_tissue tissues[5] = {0};
    const sc_clip_exception exceptions[] = {{0, "left *", ""}, {1, "left atrium", ""}};
    uint32_t clip_sets[SC_CLIP_SETS_MAX];
    int count;

    (void)state;
    assert_ok(sc_clip_sets_find(&quiet, &p.view, 2, exceptions, 2, tissues, clip_sets, &count));
    assert_int_equal(count, 3);
    assert_int_equal(clip_sets[tissues[1].clip_set], 0);
    assert_int_equal(clip_sets[tissues[2].clip_set], 2);
    assert_int_equal(clip_sets[tissues[3].clip_set], 3);
    sc_free(p.block);
    sc_volume_clear(&volume);
}

/* Labels that are invisible or have no opacity are hidden. The thickness is needed only if the
 * opacity of a label that is not hidden follows it. */
static void hidden_labels_are_found(void **state)
{
    const sc_label labels[6] = {{.value = 0, .opacity = -1},
                                {.value = 1, .name = "auto", .opacity = -1},
                                {.value = 2, .name = "glass", .opacity = 0},
                                {.value = 3, .name = "off", .opacity = 1, .hidden = true},
                                {.value = 4, .name = "ruled out", .opacity = 1},
                                {.value = 5, .name = "inside", .opacity = 0}};
    const sc_tissue_rule rules[] = {
        {.pattern = "ruled out", .has_visible = true, .visible = false},
        {.pattern = "inside", .has_interior_opacity = true, .interior_opacity = 0.1},
        {.pattern = "auto", .has_opacity = true, .opacity = 0.5}};
    const bool expected[6] = {false, false, true, true, true, false};
    bool hidden[6], thickness;

    (void)state;
    sc_hidden_labels(labels, 6, rules, 3, hidden, &thickness);
    for (int id = 0; id < 6; id++)
        assert_int_equal(hidden[id], expected[id]);
    assert_false(thickness);
    sc_hidden_labels(labels, 6, rules, 2, hidden, &thickness);
    assert_true(thickness);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hidden_labels_are_found),
        cmocka_unit_test(clipped_rays_agree_with_the_half_spaces),
        cmocka_unit_test(one_plane_cuts_the_same_in_both_modes),
        cmocka_unit_test(rules_match_by_name_glob_and_number_and_the_last_one_wins),
        cmocka_unit_test(a_rule_that_matches_nothing_is_refused_with_the_nearest_name),
        cmocka_unit_test(thicker_tissues_are_more_opaque),
        cmocka_unit_test(tissues_with_the_same_exceptions_share_a_clip_set),
    };

    return RUN(tests);
}
