/* SPDX-License-Identifier: BSD-3-Clause */
/* Colours of labels without a table: the palette, and how it is handed out. */
#include "check.h"
#include "shapes.h"

#include "segcast/image.h"

enum { PALETTE = 97, FIRST = 24 /* those of most segmentations */ };

static double least_distance(const sc_seen_color *a, const sc_seen_color *b)
{
    double least = 1;

    for (int vision = 0; vision < SC_VISION_COUNT; vision++)
        least = fmin(least, sc_color_distance(a, b, (sc_vision)vision));
    return least;
}

TEST(oklab_is_that_of_its_author)
{
    static const struct {
        uint8_t rgb[3];
        double lab[3];
    } known[] = {{{255, 255, 255}, {1, 0, 0}},
                 {{0, 0, 0}, {0, 0, 0}},
                 {{255, 0, 0}, {0.62796, 0.22486, 0.12585}},
                 {{0, 255, 0}, {0.86644, -0.23389, 0.17950}},
                 {{0, 0, 255}, {0.45201, -0.03246, -0.31153}}};

    for (size_t i = 0; i < SC_COUNT_OF(known); i++) {
        double lab[3];

        sc_oklab(known[i].rgb, SC_VISION_FULL, lab);
        for (int c = 0; c < 3; c++)
            assert_near(lab[c], known[i].lab[c], 2e-5);
    }
}

/* Greys look the same to everybody; red and green of the same lightness alike to those without the
 * cones for them. */
TEST(colour_blindness_keeps_greys_and_merges_red_and_green)
{
    const sc_seen_color red = sc_see_color((const uint8_t[3]){190, 100, 60}),
                        green = sc_see_color((const uint8_t[3]){120, 130, 50}),
                        grey = sc_see_color((const uint8_t[3]){128, 128, 128});

    for (int vision = 0; vision < SC_VISION_COUNT; vision++) {
        assert_near(grey.lab[vision][1], 0, 1e-3);
        assert_near(grey.lab[vision][2], 0, 1e-3);
    }
    assert_true(sc_color_distance(&red, &green, SC_VISION_FULL) > 0.13);
    assert_true(sc_color_distance(&red, &green, SC_VISION_DEUTERANOPIA) < 0.06);
}

TEST(the_first_colours_are_even_and_far_apart)
{
    const sc_seen_color white = sc_see_color((const uint8_t[3]){255, 255, 255}),
                        black = sc_see_color((const uint8_t[3]){0, 0, 0});
    sc_seen_color seen[FIRST];

    for (int i = 0; i < FIRST; i++) {
        uint8_t rgb[3];
        double chroma;

        sc_label_base_color(i + 1, rgb);
        seen[i] = sc_see_color(rgb);
        chroma = hypot(seen[i].lab[0][1], seen[i].lab[0][2]);
        assert_true(chroma > 0.095 && chroma < 0.12);
        assert_true(seen[i].lab[0][0] > 0.52 && seen[i].lab[0][0] < 0.81);
        assert_true(least_distance(&seen[i], &white) > 0.15);
        assert_true(least_distance(&seen[i], &black) > 0.45);
        for (int j = 0; j < i; j++) {
            assert_true(sc_color_distance(&seen[i], &seen[j], SC_VISION_FULL) > 0.059);
            assert_true(least_distance(&seen[i], &seen[j]) > 0.031);
        }
    }
}

/* All of the palette differ, and can be told from white and black; values next to each other, which
 * often touch, differ clearly. */
TEST(the_whole_palette_differs)
{
    const sc_seen_color white = sc_see_color((const uint8_t[3]){255, 255, 255}),
                        black = sc_see_color((const uint8_t[3]){0, 0, 0});
    sc_seen_color seen[PALETTE];
    uint8_t rgb[3], first[3];

    for (int i = 0; i < PALETTE; i++) {
        double chroma;

        sc_label_base_color(i + 1, rgb);
        seen[i] = sc_see_color(rgb);
        chroma = hypot(seen[i].lab[0][1], seen[i].lab[0][2]);
        assert_true(chroma > 0.085 && chroma < 0.145);
        assert_true(seen[i].lab[0][0] > 0.49 && seen[i].lab[0][0] < 0.85);
        assert_true(least_distance(&seen[i], &white) > 0.15);
        assert_true(least_distance(&seen[i], &black) > 0.42);
        for (int j = 0; j < i; j++) {
            assert_true(sc_color_distance(&seen[i], &seen[j], SC_VISION_FULL) > 0.03);
            assert_true(least_distance(&seen[i], &seen[j]) > 0.02);
        }
        if (i > 0) {
            assert_true(sc_color_distance(&seen[i], &seen[i - 1], SC_VISION_FULL) > 0.075);
            assert_true(least_distance(&seen[i], &seen[i - 1]) > 0.06);
        }
    }
    sc_label_base_color(1, first);
    sc_label_base_color(PALETTE + 1, rgb);
    assert_memory_equal(first, rgb, 3);
    sc_label_base_color(0, rgb);
    sc_label_base_color(-PALETTE, first);
    assert_memory_equal(first, rgb, 3);
}

enum { SEEDS = 40, SIDE = 48 };

/* The cell of a Voronoi diagram of scattered seeds in which a voxel lies, from 1 on. */
static int cell_of(double x, double y, double z)
{
    double least = HUGE_VAL;
    int best = 0;

    for (int i = 0; i < SEEDS; i++) {
        const double dx = x - i * 37 % SIDE, dy = y - i * 23 % SIDE, dz = z - i * 11 % SIDE;
        const double d = dx * dx + dy * dy + dz * dz;

        if (d < least) {
            least = d;
            best = i + 1;
        }
    }
    return best;
}

static sc_volume voronoi(void)
{
    return shape_volume((const int[3]){SIDE, SIDE, SIDE}, (const double[3]){1, 1, 2}, 1, SEEDS + 1,
                        cell_of);
}

/* @return the faces between two ids. */
static int faces_between(const sc_volume *v, int a, int b)
{
    const uint8_t *ids = v->ids;
    const int steps[3] = {1, SIDE, SIDE * SIDE};
    int faces = 0;

    for (int i = 0; i < SIDE * SIDE * SIDE; i++) {
        const int at[3] = {i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE};

        for (int axis = 0; axis < 3; axis++) {
            if (at[axis] + 1 < SIDE)
                faces += (ids[i] == a && ids[i + steps[axis]] == b) ||
                         (ids[i] == b && ids[i + steps[axis]] == a);
        }
    }
    return faces;
}

/* Of 40 cells that touch about five others each, those that share more than 30 faces differ clearly
 * for everybody, whatever the number of threads. */
TEST(labels_that_touch_differ)
{
    SC_OWN(sc_volume_clear) sc_volume v = voronoi(), again = voronoi();
    double least = 1, least_full = 1;
    int touching = 0;

    assert_ok(sc_volume_color(&quiet, &v, 0, SC_APPEARANCE_TABLE, 1));
    assert_ok(sc_volume_color(&quiet, &again, 0, SC_APPEARANCE_TABLE, 3));
    for (int a = 1; a <= SEEDS; a++) {
        const sc_seen_color one = sc_see_color(v.labels[a].rgb);

        assert_memory_equal(v.labels[a].rgb, again.labels[a].rgb, 3);
        for (int b = 1; b < a; b++) {
            const sc_seen_color other = sc_see_color(v.labels[b].rgb);

            if (faces_between(&v, a, b) <= 30)
                continue;
            touching++;
            least = fmin(least, least_distance(&one, &other));
            least_full = fmin(least_full, sc_color_distance(&one, &other, SC_VISION_FULL));
        }
    }
    printf("%d pairs touch: %.3f apart, %.3f for the colour-blind\n", touching, least_full, least);
    assert_true(touching > 2 * SEEDS);
    assert_true(least_full > 0.11);
    assert_true(least > 0.06);
}

/* A colour depends on the labels with smaller values alone; one that a table gives stays, and
 * labels that touch it keep away from it. */
TEST(colours_are_stable_and_heed_given_ones)
{
    SC_OWN(sc_volume_clear) sc_volume v = voronoi(), less = voronoi(), given = voronoi();
    uint8_t *ids = less.ids;
    sc_seen_color fixed;

    for (int i = 0; i < SIDE * SIDE * SIDE; i++)
        ids[i] = ids[i] > SEEDS / 2 ? 0 : ids[i];
    for (int id = SEEDS / 2 + 1; id <= SEEDS; id++)
        given.labels[id].has_color = true; /* the largest values */
    assert_ok(sc_volume_color(&quiet, &v, 0, SC_APPEARANCE_TABLE, 2));
    assert_ok(sc_volume_color(&quiet, &less, 0, SC_APPEARANCE_TABLE, 2));
    assert_ok(sc_volume_color(&quiet, &given, 0, SC_APPEARANCE_TABLE, 2));
    for (int id = 1; id <= SEEDS / 2; id++)
        assert_memory_equal(v.labels[id].rgb, less.labels[id].rgb, 3);
    for (int id = SEEDS / 2 + 1; id <= SEEDS; id++) {
        uint8_t rgb[3];

        sc_label_base_color(given.labels[id].value, rgb);
        assert_memory_equal(given.labels[id].rgb, rgb, 3);
        fixed = sc_see_color(rgb);
        for (int other = 1; other <= SEEDS / 2; other++) {
            const sc_seen_color seen = sc_see_color(given.labels[other].rgb);

            if (faces_between(&given, id, other) > 60)
                assert_true(least_distance(&fixed, &seen) > 0.03);
        }
    }
}

/* Clear the voxels of a Voronoi diagram for which keep() fails. */
static sc_volume part_of_voronoi(bool (*keep)(const int at[3], int id))
{
    sc_volume v = voronoi();
    uint8_t *ids = v.ids;

    for (int i = 0; i < SIDE * SIDE * SIDE; i++) {
        const int at[3] = {i % SIDE, i / SIDE % SIDE, i / SIDE / SIDE};

        if (!keep(at, ids[i]))
            ids[i] = 0;
    }
    return v;
}

static bool is_left(const int at[3], int id)
{
    return at[0] < SIDE / 2;
}

static bool is_behind(const int at[3], int id)
{
    return at[1] >= SIDE / 2;
}

static bool is_low(const int at[3], int id)
{
    return at[2] < SIDE / 2;
}

/* Half of a volume has the colours of the whole, but for a few along the cut. */
TEST(halves_keep_their_colours)
{
    bool (*const halves[])(const int[3], int) = {is_left, is_behind, is_low};
    SC_OWN(sc_volume_clear) sc_volume v = voronoi();
    int labels = 0, kept = 0;

    assert_ok(sc_volume_color(&quiet, &v, 0, SC_APPEARANCE_TABLE, 2));
    for (size_t i = 0; i < SC_COUNT_OF(halves); i++) {
        SC_OWN(sc_volume_clear) sc_volume half = part_of_voronoi(halves[i]);
        bool there[SEEDS + 1] = {false};

        for (int k = 0; k < SIDE * SIDE * SIDE; k++)
            there[((const uint8_t *)half.ids)[k]] = true;
        assert_ok(sc_volume_color(&quiet, &half, 0, SC_APPEARANCE_TABLE, 2));
        for (int id = 1; id <= SEEDS; id++) {
            labels += there[id];
            kept += there[id] && memcmp(half.labels[id].rgb, v.labels[id].rgb, 3) == 0;
        }
    }
    printf("%d of %d labels of halves keep their colour\n", kept, labels);
    assert_true(kept > 0.75 * labels);
}

enum { GAP_FROM = 20, GAP_TO = 28 };

/* Keep the cells that lie on one side of the gap alone, on both sides of it. */
static bool is_beside_the_gap(const int at[3], int id)
{
    const int x = (id - 1) * 37 % SIDE;

    return id > 0 && (at[0] < GAP_FROM ? x < GAP_FROM : at[0] >= GAP_TO && x >= GAP_TO);
}

static bool is_right_of_the_gap(const int at[3], int id)
{
    return at[0] >= GAP_TO && is_beside_the_gap(at, id);
}

/* What tissues on one side of a gap look like does not depend on what is on the other. */
TEST(colours_do_not_depend_on_what_is_far_away)
{
    sc_volume both = part_of_voronoi(is_beside_the_gap),
              right = part_of_voronoi(is_right_of_the_gap);
    bool there[SEEDS + 1] = {false};
    int moved = 0;

    for (int i = 0; i < SIDE * SIDE * SIDE; i++)
        there[((const uint8_t *)right.ids)[i]] = true;
    assert_ok(sc_volume_color(&quiet, &both, 0, SC_APPEARANCE_TABLE, 2));
    assert_ok(sc_volume_color(&quiet, &right, 0, SC_APPEARANCE_TABLE, 2));
    for (int id = 1; id <= SEEDS; id++) {
        uint8_t own[3];

        if (!there[id])
            continue;
        sc_label_base_color(both.labels[id].value, own);
        moved += memcmp(own, right.labels[id].rgb, 3) != 0;
        assert_memory_equal(both.labels[id].rgb, right.labels[id].rgb, 3);
    }
    assert_true(moved > 1);
    sc_volume_clear(&both);
    sc_volume_clear(&right);
}

/* The labels of most segmentations, some twenty in a row that do not touch, and many more all
 * differ. */
TEST(few_labels_have_the_colours_of_their_values)
{
    sc_volume v =
        shape_volume((const int[3]){4, 4, 4}, (const double[3]){1, 1, 1}, 2, PALETTE + 1, cell_of);

    memset(v.ids, 0, 2 * sc_volume_voxels(&v));
    for (int id = 1; id <= PALETTE; id++)
        v.labels[id].value = id + 2;
    assert_ok(sc_volume_color(&quiet, &v, 0, SC_APPEARANCE_TABLE, 1));
    for (int id = 1; id <= PALETTE; id++) {
        uint8_t rgb[3];

        sc_label_base_color(id + 2, rgb);
        assert_memory_equal(v.labels[id].rgb, rgb, 3);
    }
    sc_volume_clear(&v);
}

/* Twenty-five blocks in a row, four voxels apart; the last one, which has the place of the first in
 * the palette, lies above one of the others. */
enum { BLOCKS = FIRST + 1, PITCH = 8 };

static int above_the_first(double x, double y, double z)
{
    const int block = (int)x / PITCH, within = (int)x % PITCH;

    if (within >= PITCH / 2)
        return 0;
    return y < 4 ? block + 1 : y >= 8 && block == 0 ? BLOCKS : 0;
}

static int above_the_twelfth(double x, double y, double z)
{
    return y < 4 ? above_the_first(x, y, z) : x < 88 ? 0 : above_the_first(x - 88, y, z);
}

/* Labels that are near each other do not get the same colour, though they do not touch; labels far
 * from each other may. */
TEST(labels_that_are_near_differ)
{
    const int size[3] = {FIRST * PITCH, 12, 4};
    const double spacing_mm[3] = {1, 1, 1};
    sc_volume near = shape_volume(size, spacing_mm, 1, BLOCKS + 1, above_the_first),
              far = shape_volume(size, spacing_mm, 1, BLOCKS + 1, above_the_twelfth);
    sc_seen_color one, other;

    for (int id = 1; id < BLOCKS; id++)
        near.labels[id].value = far.labels[id].value = id;
    near.labels[BLOCKS].value = far.labels[BLOCKS].value = PALETTE + 1;
    assert_ok(sc_volume_color(&quiet, &near, 0, SC_APPEARANCE_TABLE, 2));
    assert_ok(sc_volume_color(&quiet, &far, 0, SC_APPEARANCE_TABLE, 2));
    one = sc_see_color(near.labels[1].rgb);
    other = sc_see_color(near.labels[BLOCKS].rgb);
    assert_true(sc_color_contrast(&one, &other) > 0.08);
    assert_memory_equal(far.labels[1].rgb, far.labels[BLOCKS].rgb, 3);
    sc_volume_clear(&near);
    sc_volume_clear(&far);
}

/* A tissue that encloses the others is pale, and none of the palette is near its colour. A colour
 * from a table stays. */
TEST(what_encloses_all_is_pale)
{
    const uint8_t given[3] = {10, 20, 30};
    SC_OWN(sc_volume_clear) sc_volume v = voronoi();
    sc_seen_color pale;

    assert_ok(sc_volume_color(&quiet, &v, 7, SC_APPEARANCE_TABLE, 2));
    pale = sc_see_color(v.labels[7].rgb);
    assert_true(hypot(pale.lab[0][1], pale.lab[0][2]) < 0.06);
    assert_true(pale.lab[0][0] < 0.83);
    for (int i = 0; i < PALETTE; i++) {
        sc_seen_color seen;
        uint8_t rgb[3];

        sc_label_base_color(i + 1, rgb);
        seen = sc_see_color(rgb);
        assert_true(sc_color_distance(&pale, &seen, SC_VISION_FULL) > 0.08);
        assert_true(least_distance(&pale, &seen) > 0.031);
    }
    v.labels[7].has_color = true;
    memcpy(v.labels[7].rgb, given, 3);
    assert_ok(sc_volume_color(&quiet, &v, 7, SC_APPEARANCE_TABLE, 2));
    assert_memory_equal(v.labels[7].rgb, given, 3);
}

/* Names as programs write them; the colours are looked at by hue, so that they may be tuned. */
TEST(names_have_the_colours_of_anatomy)
{
    static const char *const same[][2] = {
        {"heart_ventricle_left", "Left ventricle"},
        {"LeftVentricle", "left_ventricular_blood_pool"},
        {"heart_atrium_right", "right ventricle"},
        {"Left-Lateral-Ventricle", "4th-Ventricle"},
        {"Left-Inf-Lat-Vent", "CSF"},
        {"Right-choroid-plexus", "CSF"},
        {"pulmonary_artery", "Pulmonary Trunk"},
        {"aorta", "descending aorta"},
        {"portal_vein_and_splenic_vein", "Portal vein"},
        {"iliac_vena_left", "inferior_vena_cava"},
        {"superior sagittal sinus", "Internal jugular vein"},
        {"maxillary sinus", "trachea"},
        {"liver_vessels", "lung_vessels"},
        {"Hepar", "liver"},
        {"Lien", "spleen"},
        {"Ren dexter", "right kidney"},
        {"Vesica biliaris", "gallbladder"},
        {"Vesica urinaria", "urinary bladder"},
        {"Arteria femoralis", "femoral artery"},
        {"Musculus", "muscle"},
        {"Arteria pulmonalis", "pulmonary artery"},
        {"Venae pulmonales", "pulmonary vein"},
        {"Cartilagines costae", "costal cartilage"},
        {"Nervus opticus", "optic nerve"},
        {"Pulmones", "lung"},
        {"Renes", "kidneys"},
        {"vertebrae_L5", "rib_right_12"},
        {"VertebraC1", "femur left"},
        {"costal_cartilages", "intervertebral_discs"},
        {"kidney_left", "Right Kidney"},
        {"kidney_cyst_left", "cyst"},
        {"Liver tumor", "Lung nodule"},
        {"lung_upper_lobe_left", "Lung, right"},
        {"Left-Cerebral-White-Matter", "Right-Cerebellum-White-Matter"},
        {"CC_Posterior", "CC_Mid_Anterior"},
        {"CC_Central", "corpus callosum"},
        {"Left-Cerebral-WM", "Left-UnsegmentedWhiteMatter"},
        {"Left-VentralDC", "Right-Ventral-DC"},
        {"WM-hypointensities", "Left-non-WM-hypointensities"},
        {"Left-Substancia-Nigra", "substantia nigra"},
        {"Left-hippocampal_fissure", "Right-Hippocampus"},
        {"Cbm_Vermis", "Left-Cerebellum-Cortex"},
        {"gluteus_maximus_left", "skeletal muscle"},
        {"gallbladder", "bile duct"},
        {"urinary_bladder", "Bladder"},
        {"Postcava", "inferior vena cava"},
        {"precava", "SVC"},
        {"SMA", "superior mesenteric artery"},
        {"SMV", "mesenteric vein"},
        {"LAA", "atrial_appendage_left"},
        {"Ventriculus sinister", "left ventricle"},
        {"Os femoris", "vertebrae_L1"},
        {"heart_other", "unclassified"},
        {"Rest", "rest of the body"},
    };
    static const char *const unknown[] = {"",
                                          "label 7",
                                          "ctx-lh-superiorfrontal",
                                          "ctx-lh-insula",
                                          "wm-lh-insula",
                                          "cc",
                                          "anterior",
                                          "Precentral_L",
                                          "arterioventral",
                                          "ribosome",
                                          "background",
                                          "liverpool",
                                          "left",
                                          "_",
                                          "ventricle",
                                          "心臓"};
    uint8_t one[3], other[3];

    for (size_t i = 0; i < SC_COUNT_OF(same); i++) {
        if (!sc_anatomy_color(same[i][0], SC_NAMES_BODY, one) ||
            !sc_anatomy_color(same[i][1], SC_NAMES_BODY, other) || memcmp(one, other, 3) != 0)
            fail_msg("\"%s\" and \"%s\" have no colour, or not the same", same[i][0], same[i][1]);
    }
    for (size_t i = 0; i < SC_COUNT_OF(unknown); i++) {
        if (sc_anatomy_color(unknown[i], SC_NAMES_BODY, one))
            fail_msg("\"%s\" has a colour", unknown[i]);
    }
    assert_true(sc_anatomy_color("pulmonary_vein", SC_NAMES_BODY, one) && one[0] > one[2] + 60);
    assert_true(sc_anatomy_color("pulmonary_artery", SC_NAMES_BODY, one) && one[2] > one[0] + 60);
    assert_true(sc_anatomy_color("Left Atrium", SC_NAMES_BODY, one) && one[0] > one[2] + 60);
    assert_true(sc_anatomy_color("Auricular appendage, Left", SC_NAMES_BODY, one) &&
                one[0] > one[2] + 60);
    assert_true(sc_anatomy_color("Carpus", SC_NAMES_BODY, one) &&
                sc_anatomy_color("Tibia", SC_NAMES_BODY, other));
    assert_memory_equal(one, other, 3);
    assert_true(sc_anatomy_color("right_atrium", SC_NAMES_BODY, one) && one[2] > one[0] + 60);
}

/* LA is the left atrium where there are LV and RV, and a nucleus of the amygdala elsewhere. */
TEST(abbreviations_are_of_the_heart_among_its_chambers)
{
    static const char *const same[][2] = {{"LA", "Left atrium"},    {"RA", "right_atrium"},
                                          {"Ao", "aorta"},          {"PA", "pulmonary artery"},
                                          {"PV", "pulmonary_vein"}, {"LV", "Left ventricle"},
                                          {"LVM", "myocardium"},    {"RV", "right ventricle"}};
    sc_label labels[3] = {sc_label_new(0), sc_label_new(1), sc_label_new(2)};
    uint8_t one[3], other[3];

    for (size_t i = 0; i < SC_COUNT_OF(same); i++) {
        assert_true(sc_anatomy_color(same[i][0], SC_NAMES_HEART, one));
        assert_true(sc_anatomy_color(same[i][1], SC_NAMES_HEART, other));
        assert_memory_equal(one, other, 3);
    }
    assert_false(sc_anatomy_color("LA", SC_NAMES_BODY, one));
    assert_int_equal(sc_names_kind_of(labels, 3), SC_NAMES_BODY);
    snprintf(labels[1].name, sizeof labels[1].name, "LV");
    assert_int_equal(sc_names_kind_of(labels, 3), SC_NAMES_BODY);
    snprintf(labels[2].name, sizeof labels[2].name, "rv blood");
    assert_int_equal(sc_names_kind_of(labels, 3), SC_NAMES_HEART);
    snprintf(labels[1].name, sizeof labels[1].name, "Left-Lateral-Ventricle");
    snprintf(labels[2].name, sizeof labels[2].name, "Right-Lateral-Ventricle");
    assert_int_equal(sc_names_kind_of(labels, 3), SC_NAMES_BODY);
}

/* Volumes of FreeSurfer have no names of their own; where there are some, they decide. */
TEST(numbers_of_freesurfer_are_of_a_brain)
{
    static const int values[] = {0, 2, 3, 4, 7, 41, 42, 43, 46};
    enum { COUNT = SC_COUNT_OF(values) };
    sc_label labels[COUNT];

    for (int i = 0; i < COUNT; i++)
        labels[i] = sc_label_new(values[i]);
    assert_int_equal(sc_names_kind_of(labels, COUNT), SC_NAMES_BRAIN);
    assert_int_equal(sc_names_kind_of(labels, COUNT - 1), SC_NAMES_BODY); /* three pairs */
    labels[4].value = 6; /* a number that is none of FreeSurfer's */
    assert_int_equal(sc_names_kind_of(labels, COUNT), SC_NAMES_BODY);
    labels[4].value = 7;
    snprintf(labels[1].name, sizeof labels[1].name, "liver");
    assert_int_equal(sc_names_kind_of(labels, COUNT), SC_NAMES_BODY);
}

/* A name of the greatest length, each second letter large, is read within its room. */
TEST(a_long_name_is_read_within_its_room)
{
    char name[SC_NAME_BYTES];
    uint8_t rgb[3];

    for (int i = 0; i < SC_NAME_BYTES - 1; i++)
        name[i] = i % 2 ? 'B' : 'a';
    name[SC_NAME_BYTES - 1] = '\0';
    assert_false(sc_anatomy_color(name, SC_NAMES_BODY, rgb));
}

/* Layers of two voxels along z. */
static int layer_of(double x, double y, double z)
{
    return (int)z / 2 + 1;
}

/* Eight vertebrae in a row are of one hue, and each can be told from the next; two of them that do
 * not touch may be the same. */
TEST(neighbours_of_one_kind_have_shades)
{
    enum { COUNT = 8 };
    SC_OWN(sc_volume_clear)
    sc_volume v = shape_volume((const int[3]){8, 8, 2 * COUNT}, (const double[3]){1, 1, 1}, 1,
                               COUNT + 1, layer_of);
    uint8_t base[3];
    int as_base = 0;

    for (int id = 1; id <= COUNT; id++)
        snprintf(v.labels[id].name, SC_NAME_BYTES, "vertebrae_L%d", id);
    assert_true(sc_anatomy_color("vertebrae_L1", SC_NAMES_BODY, base));
    assert_ok(sc_volume_color(&quiet, &v, 0, SC_APPEARANCE_TABLE, 2));
    for (int id = 1; id <= COUNT; id++) {
        const sc_seen_color seen = sc_see_color(v.labels[id].rgb),
                            before = sc_see_color(v.labels[id > 1 ? id - 1 : 2].rgb);

        assert_true(sc_color_distance(&seen, &before, SC_VISION_FULL) > 0.03);
        assert_true(v.labels[id].rgb[0] > v.labels[id].rgb[2] + 10);
        as_base += memcmp(v.labels[id].rgb, base, 3) == 0;
    }
    assert_true(as_base >= COUNT / 2);
}

/* What a job wants: the table's colours, those of anatomy instead, or distinct ones. */
TEST(appearance_decides_between_table_and_anatomy)
{
    static const uint8_t given[3] = {10, 200, 30};
    SC_OWN(sc_volume_clear) sc_volume v = voronoi();
    uint8_t liver[3], distinct[3];

    assert_true(sc_anatomy_color("liver", SC_NAMES_BODY, liver));
    snprintf(v.labels[1].name, SC_NAME_BYTES, "liver");
    snprintf(v.labels[2].name, SC_NAME_BYTES, "something");
    for (int id = 1; id <= 2; id++) {
        v.labels[id].has_color = true;
        memcpy(v.labels[id].rgb, given, 3);
    }
    assert_ok(sc_volume_color(&quiet, &v, 0, SC_APPEARANCE_TABLE, 1));
    assert_memory_equal(v.labels[1].rgb, given, 3);
    assert_true(sc_volume_lacks_colors(&v, SC_APPEARANCE_ANATOMY));
    assert_ok(sc_volume_color(&quiet, &v, 0, SC_APPEARANCE_ANATOMY, 1));
    assert_memory_equal(v.labels[1].rgb, liver, 3);
    assert_memory_equal(v.labels[2].rgb, given, 3);
    assert_ok(sc_volume_color(&quiet, &v, 0, SC_APPEARANCE_DISTINCT, 1));
    sc_label_base_color(v.labels[1].value, distinct);
    assert_memory_equal(v.labels[1].rgb, distinct, 3);
    assert_true(memcmp(v.labels[2].rgb, given, 3) != 0);
}

/* Give the labels of a volume names, and colours by them. */
static void color_by_names(sc_volume *v, const char *const *names, sc_appearance appearance)
{
    for (int id = 1; id < v->label_count; id++)
        snprintf(v->labels[id].name, SC_NAME_BYTES, "%s", names[id - 1]);
    assert_ok(sc_volume_color(&quiet, v, 0, appearance, 1));
}

/* The tissue of layer_of at the same place, in a file that numbers from the other end. */
static int layer_from_above(double x, double y, double z)
{
    return 5 - layer_of(x, y, z);
}

/* A single file and a directory of masks number the same tissues differently. */
TEST(colours_of_anatomy_do_not_depend_on_numbers)
{
    static const char *const names[] = {"vertebrae_T12", "vertebrae_L1", "liver", "spleen"},
                             *const turned[] = {"spleen", "liver", "vertebrae_L1", "vertebrae_T12"};
    const int size[3] = {4, 4, 8};
    const double spacing[3] = {1, 1, 1};
    sc_volume v = shape_volume(size, spacing, 1, 5, layer_of),
              w = shape_volume(size, spacing, 1, 5, layer_from_above);

    color_by_names(&v, names, SC_APPEARANCE_TABLE);
    color_by_names(&w, turned, SC_APPEARANCE_TABLE);
    for (int id = 1; id <= 4; id++)
        assert_memory_equal(v.labels[id].rgb, w.labels[5 - id].rgb, 3);
    assert_true(memcmp(v.labels[1].rgb, v.labels[2].rgb, 3) != 0);
    sc_volume_clear(&v);
    sc_volume_clear(&w);
}

/* A muscle keeps its colour beside a heart that looks much like it. */
TEST(other_kinds_beside_a_tissue_do_not_change_its_colour)
{
    static const char *const names[] = {"muscle", "heart", "liver", "kidney_left"};
    SC_OWN(sc_volume_clear)
    sc_volume v = shape_volume((const int[3]){4, 4, 8}, (const double[3]){1, 1, 1}, 1, 5, layer_of);

    color_by_names(&v, names, SC_APPEARANCE_ANATOMY);
    for (int id = 1; id <= 4; id++) {
        uint8_t base[3];

        assert_true(sc_anatomy_color(names[id - 1], SC_NAMES_BODY, base));
        assert_memory_equal(v.labels[id].rgb, base, 3);
    }
}

/* Both sides of a pair look the same, be their names known or not, also where they touch; the sides
 * of a heart do not; and where all colours are to differ, none do. */
TEST(left_looks_as_right)
{
    static const char *const names[] = {"Precentral_L", "Precentral_R", "lung left", "Lung, right"},
                             *const chambers[] = {"left_atrium", "right_atrium", "a", "b"};
    SC_OWN(sc_volume_clear)
    sc_volume v = shape_volume((const int[3]){4, 4, 8}, (const double[3]){1, 1, 1}, 1, 5, layer_of);

    color_by_names(&v, names, SC_APPEARANCE_TABLE);
    assert_memory_equal(v.labels[1].rgb, v.labels[2].rgb, 3);
    assert_memory_equal(v.labels[3].rgb, v.labels[4].rgb, 3);
    assert_true(memcmp(v.labels[2].rgb, v.labels[3].rgb, 3) != 0);
    color_by_names(&v, names, SC_APPEARANCE_DISTINCT);
    assert_true(memcmp(v.labels[1].rgb, v.labels[2].rgb, 3) != 0);
    color_by_names(&v, chambers, SC_APPEARANCE_ANATOMY);
    assert_true(v.labels[1].rgb[0] > v.labels[1].rgb[2] + 60);
    assert_true(v.labels[2].rgb[2] > v.labels[2].rgb[0] + 60);
}

/* What is left over, and what lies around all, is told by its name; a tumour of it is not. */
TEST(names_tell_what_is_left_over_and_what_lies_outside)
{
    static const struct {
        sc_name_role role;
        const char *names[8];
    } known[] = {
        {SC_NAME_REST, {"heart_other", "Other", "unclassified", "rest", "Unknown", "remainder"}},
        {SC_NAME_OUTSIDE, {"soft tissue", "Skin", "body", "body_trunc"}},
        {SC_NAME_PART,
         {"", "heart", "forest", "mother cell", "body of C2", "skin tumor", "vertebral body"}},
    };

    for (size_t i = 0; i < SC_COUNT_OF(known); i++) {
        for (int k = 0; k < 8 && known[i].names[k]; k++) {
            if (sc_name_role_of(known[i].names[k]) != known[i].role)
                fail_msg("\"%s\" is not of role %d", known[i].names[k], known[i].role);
        }
    }
}

TEST(an_allocation_that_fails_is_reported)
{
    SC_OWN(sc_volume_clear) sc_volume v = voronoi();
    sc_status status = SC_ERR_MEMORY;

    for (long n = 0; status != SC_OK; n++) {
        long budget = n;
        sc_ctx ctx = {.alloc_budget = &budget};

        status = sc_volume_color(&ctx, &v, 0, SC_APPEARANCE_TABLE, 2);
        assert_true(status == SC_OK ? n == 9 : status == SC_ERR_MEMORY);
    }
}

RUN_TESTS(NULL, NULL)
