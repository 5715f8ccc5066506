/* SPDX-License-Identifier: BSD-3-Clause */
#include "check.h"

#include "phantom/phantom_model.h"

static sc_vec3 random_point(uint64_t *seed)
{
    return (sc_vec3){random_real(seed, -78, 78), random_real(seed, -54, 54),
                     random_real(seed, -81, 81)};
}

/* The label that owns a point: the first whose field is negative there; 0 outside the heart. */
static int owner_of(const sc_phantom *phantom, sc_vec3 point_mm)
{
    for (int label = 1; label <= sc_phantom_tissue_count(phantom); label++) {
        if (sc_phantom_field(phantom, label, point_mm, 0) < 0)
            return label;
    }
    return 0;
}

TEST(every_voxel_belongs_to_the_owner_of_its_centre)
{
    static const int sizes[][3] = {{59, 41, 61}, {33, 64, 2}};
    SC_OWN(sc_phantom_free_at) sc_phantom *phantom = NULL;

    assert_ok(sc_phantom_new(&quiet, &phantom));
    for (size_t s = 0; s < SC_COUNT_OF(sizes); s++) {
        const int *size = sizes[s];
        SC_OWN(sc_volume_clear) sc_volume v = {0}, again = {0};

        assert_ok(sc_phantom_volume(&quiet, phantom, size, 1, &v));
        assert_ok(sc_phantom_volume(&quiet, phantom, size, 3, &again));
        assert_memory_equal(v.ids, again.ids, sc_volume_voxels(&v));
        for (int i = 0; i < (int)sc_volume_voxels(&v); i++) {
            const sc_vec3 index = {i % size[0], i / size[0] % size[1], i / size[0] / size[1]};

            assert_int_equal(((uint8_t *)v.ids)[i],
                             owner_of(phantom, sc_affine_point(&v.to_ras_mm, index)));
        }
    }
}

TEST(all_tissues_are_there_with_names_and_colours)
{
    const int size[3] = {156, 108, 162};
    uint64_t voxels[256] = {0};
    SC_OWN(sc_phantom_free_at) sc_phantom *phantom = NULL;
    SC_OWN(sc_volume_clear) sc_volume v = {0};

    assert_ok(sc_phantom_new(&quiet, &phantom));
    assert_ok(sc_phantom_volume(&quiet, phantom, size, 2, &v));
    assert_true(v.label_count - 1 >= 14);
    for (size_t i = 0; i < sc_volume_voxels(&v); i++)
        voxels[((uint8_t *)v.ids)[i]]++;
    for (int id = 1; id < v.label_count; id++) {
        assert_true(voxels[id] > 500);
        assert_true(v.labels[id].name[0] && v.labels[id].has_color);
        assert_int_equal(v.labels[id].value, id);
    }
}

/* The apex lies to the left, in front of and below the base; right chambers lie to the right. */
TEST(the_heart_lies_as_in_a_chest)
{
    static const struct {
        const char *name;
        sc_vec3 inside;
    } places[] = {{"left ventricle", {-30, 8, -22}}, {"right ventricle", {12, 20, -5}},
                  {"left atrium", {5, -30, 20}},     {"right atrium", {45, -2, 12}},
                  {"aorta", {-23, -43, -30}},        {"superior vena cava", {34, -1, 60}}};
    SC_OWN(sc_phantom_free_at) sc_phantom *phantom = NULL;

    assert_ok(sc_phantom_new(&quiet, &phantom));
    for (size_t i = 0; i < SC_COUNT_OF(places); i++) {
        const int label = owner_of(phantom, places[i].inside);

        assert_int_not_equal(label, 0);
        assert_string_equal(sc_phantom_label(phantom, label)->name, places[i].name);
    }
}

TEST(saving_and_reading_gives_the_same_volume)
{
    const int size[3] = {30, 20, 31};
    SC_OWN(sc_phantom_free_at) sc_phantom *phantom = NULL;
    SC_OWN(sc_volume_clear) sc_volume v = {0}, back = {0};

    assert_ok(sc_phantom_new(&quiet, &phantom));
    assert_ok(sc_phantom_volume(&quiet, phantom, size, 1, &v));
    assert_ok(sc_volume_save_nrrd(&quiet, &v, "p.nrrd", true));
    assert_ok(sc_volume_read(&quiet, "p.nrrd", &back));
    for (size_t i = 0; i < sc_volume_voxels(&v); i++) {
        const sc_label *a = &v.labels[((uint8_t *)v.ids)[i]];
        const sc_label *b = &back.labels[((uint8_t *)back.ids)[i]];

        assert_int_equal(a->value, b->value);
        if (a->value == 0)
            continue; /* background has no colour or opacity */
        assert_string_equal(a->name, b->name);
        assert_memory_equal(a->rgb, b->rgb, 3);
    }
    assert_memory_equal(&v.to_ras_mm, &back.to_ras_mm, sizeof v.to_ras_mm);
    remove("p.nrrd");
}

/* A scan finds the bounding boxes of the labels without voxelising, exact to a voxel of its coarse
 * grid. */
TEST(a_scan_finds_the_boxes_of_the_tissues)
{
    const int size[3] = {156, 108, 162};
    SC_OWN(sc_phantom_free_at) sc_phantom *phantom = NULL;
    SC_OWN(sc_volume_clear) sc_volume scan = {0};
    SC_OWN(sc_volume_clear) sc_volume v = {0};

    assert_ok(sc_phantom_new(&quiet, &phantom));
    assert_ok(sc_phantom_volume(&quiet, phantom, size, 2, &v));
    assert_ok(sc_phantom_scan_labels(&quiet, phantom, size, 2, &scan));
    assert_memory_equal(scan.size, v.size, sizeof v.size);
    assert_memory_equal(&scan.to_ras_mm, &v.to_ras_mm, sizeof v.to_ras_mm);
    assert_int_equal(scan.label_count, v.label_count);
    for (int id = 0; id < v.label_count; id++) {
        int low[3] = {size[0], size[1], size[2]}, high[3] = {-1, -1, -1};

        for (int i = 0; i < (int)sc_volume_voxels(&v); i++) {
            const int at[3] = {i % size[0], i / size[0] % size[1], i / size[0] / size[1]};

            for (int axis = 0; axis < 3 && ((uint8_t *)v.ids)[i] == id; axis++) {
                low[axis] = at[axis] < low[axis] ? at[axis] : low[axis];
                high[axis] = at[axis] > high[axis] ? at[axis] : high[axis];
            }
        }
        assert_string_equal(scan.labels[id].name, v.labels[id].name);
        assert_true(scan.tallies[id].voxels > 0);
        for (int axis = 0; axis < 3; axis++) {
            assert_in_range(scan.tallies[id].low[axis] + 4, low[axis], low[axis] + 8);
            assert_in_range(scan.tallies[id].high[axis] + 4, high[axis], high[axis] + 8);
        }
    }
}

/* Fill voxels[id] with how many voxels of a coarse heart each tissue has at a phase of its beat.
 * @param v receives the volume. */
static void count_at(double phase, double voxels[32], sc_volume *v)
{
    const int size[3] = {117, 81, 121};
    SC_OWN(sc_phantom_free_at) sc_phantom *phantom = NULL;

    assert_ok(sc_phantom_new_beating(&quiet, phase, &phantom));
    assert_ok(sc_phantom_volume(&quiet, phantom, size, 2, v));
    assert_in_range(v->label_count, 2, 31);
    for (int id = 0; id < 32; id++)
        voxels[id] = 0;
    for (size_t i = 0; i < sc_volume_voxels(v); i++) {
        const int id = ((uint8_t *)v->ids)[i];

        voxels[id]++;
        if (i % 97 == 0) { /* blocks that are classified at once hold no other tissue */
            const sc_vec3 index = {(double)(i % 117), (double)(i / 117 % 81),
                                   (double)(i / 117 / 81)};

            assert_int_equal(owner_of(phantom, sc_affine_point(&v->to_ras_mm, index)), id);
        }
    }
}

/* @return the index of the tissue of that name. */
static int named(const sc_volume *v, const char *name)
{
    for (int id = 1; id < v->label_count; id++) {
        if (!strcmp(v->labels[id].name, name))
            return id;
    }
    fail_msg("no tissue is called %s", name);
    return 0;
}

/* The measures of a healthy heart: the left ventricle ejects 55 to 65 % of its blood (Lang et al.
 * 2015, J Am Soc Echocardiogr 28:1), the right one 45 to 65 %; muscle keeps its volume; the atria
 * fill meanwhile, and empty themselves before the next beat. */
TEST(chambers_eject_and_walls_keep_their_volume)
{
    double full[32], empty[32], late[32];
    SC_OWN(sc_volume_clear) sc_volume v = {0}, w = {0}, x = {0};
    int left, right, wall, septum, atrium;

    count_at(0, full, &v);
    count_at(0.42, empty, &w);
    count_at(0.91, late, &x);
    left = named(&v, "left ventricle");
    right = named(&v, "right ventricle");
    wall = named(&v, "left ventricular myocardium");
    septum = named(&v, "interventricular septum");
    atrium = named(&v, "left atrium");
    assert_true(empty[left] > 0.35 * full[left] && empty[left] < 0.45 * full[left]);
    assert_true(empty[right] > 0.35 * full[right] && empty[right] < 0.55 * full[right]);
    assert_near((empty[wall] + empty[septum]) / (full[wall] + full[septum]), 1, 0.1);
    assert_true(empty[atrium] > 1.5 * full[atrium]);
    assert_true(late[atrium] < 0.9 * full[atrium]);
    for (int id = 1; id < v.label_count; id++)
        assert_true(empty[id] > 100 && late[id] > 100);
}

static size_t differing_voxels(const sc_volume *a, const sc_volume *b)
{
    size_t count = 0;

    for (size_t i = 0; i < sc_volume_voxels(a); i++)
        count += ((uint8_t *)a->ids)[i] != ((uint8_t *)b->ids)[i];
    return count;
}

/* A beat begins with the heart that does not move, ends where it began, and never jumps. */
TEST(a_beat_is_smooth_and_periodic)
{
    double counts[32];
    sc_volume still, v, before;
    size_t moved_most = 0, whole = 0;

    count_at(0, counts, &still);
    count_at(7, counts, &v);
    assert_memory_equal(v.ids, still.ids, sc_volume_voxels(&v));
    sc_volume_clear(&v);
    count_at(0.42, counts, &v);
    whole = differing_voxels(&v, &still);
    sc_volume_clear(&v);
    before = still;
    for (int phase = 1; phase <= 50; phase++) {
        size_t moved;

        count_at(phase / 50.0 - 3, counts, &v);
        moved = differing_voxels(&v, &before);
        moved_most = moved > moved_most ? moved : moved_most;
        sc_volume_clear(&before);
        before = v;
    }
    /* The quickest phase covers three quarters of the way in 0.18 of a beat, at most 1.5 times as
     * fast as on the average: an eighth of the way in a fiftieth of a beat. */
    if (moved_most > whole / 5)
        fail_msg("%zu voxels change from one of 50 phases to the next, and %zu in all", moved_most,
                 whole);
    sc_volume_clear(&before);
}

/* Two courses, and the shape that is their union, less a half-space. */
enum { COURSE_POINTS = 8 };

static sc_shape two_tubes(uint64_t *seed, sc_vec3 points[2][COURSE_POINTS])
{
    sc_shape shape = {.part_count = 2, .cut_count = 1};

    for (int t = 0; t < 2; t++) {
        const sc_vec3 controls[] = {random_point(seed), random_point(seed), random_point(seed)};

        sc_spline_points(controls, 3, points[t], COURSE_POINTS);
        shape.parts[t] = (sc_part){.kind = SC_PART_TUBE,
                                   .blend_mm = 11,
                                   .points = points[t],
                                   .point_count = COURSE_POINTS,
                                   .radius_a_mm = random_real(seed, 1, 13),
                                   .radius_b_mm = random_real(seed, 1, 13)};
    }
    shape.cuts[0] = (sc_cut){random_point(seed), sc_vec3_unit(random_point(seed)), 3};
    sc_shape_measure(&shape);
    return shape;
}

/* The field of the tube's cones, each of which is looked at. */
static double field_of_cones(const sc_part *tube, sc_vec3 p)
{
    const double step = (tube->radius_b_mm - tube->radius_a_mm) / (COURSE_POINTS - 1);
    sc_shape cones = {.part_count = COURSE_POINTS - 1};

    for (int i = 0; i + 1 < COURSE_POINTS; i++) {
        const double radius = tube->radius_a_mm + step * i;

        cones.parts[i] = (sc_part){.kind = SC_PART_CONE,
                                   .a = tube->points[i],
                                   .b = tube->points[i + 1],
                                   .radius_a_mm = radius,
                                   .radius_b_mm = radius + step};
    }
    return sc_shape_field(&cones, p, HUGE_VAL);
}

TEST(fields_are_exact_below_their_limit)
{
    uint64_t seed = 77;
    int below = 0;

    for (int n = 0; n < 200; n++) {
        sc_vec3 points[2][COURSE_POINTS];
        const sc_shape shape = two_tubes(&seed, points);
        sc_shape alone = shape;

        alone.part_count = 1;
        alone.cut_count = 0;
        for (int i = 0; i < 200; i++) {
            const sc_vec3 p = random_point(&seed);
            const double field = sc_shape_field(&shape, p, HUGE_VAL);
            const double limit = field + random_real(&seed, -20, 20);
            const double limited = sc_shape_field(&shape, p, limit);

            assert_true(field < limit ? limited == field : limited >= limit);
            assert_true(fabs(sc_shape_field(&alone, p, HUGE_VAL) -
                             field_of_cones(&alone.parts[0], p)) < 1e-9);
            below += field < limit;
        }
    }
    assert_in_range(below, 10000, 30000);
}

RUN_TESTS(NULL, NULL)
