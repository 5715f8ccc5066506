/* SPDX-License-Identifier: BSD-3-Clause */
/* Labels that are left out or merged, and volumes that are cropped: against what is done voxel by
 * voxel. */
#include "check.h"

#include "segcast/volume.h"

enum { LABELS = 7, WIDTH = 11, DEPTH = 7, HEIGHT = 9, VOXELS = WIDTH * DEPTH * HEIGHT };

/* Fill @p v with random labels, of which 5 has no voxel, in oblique voxels. @param bytes of an id.
 */
static void make_volume(int bytes, sc_volume *v)
{
    uint64_t seed = 5;

    *v = (sc_volume){.size = {WIDTH, DEPTH, HEIGHT},
                     .label_bytes = bytes,
                     .label_count = LABELS,
                     .to_ras_mm = {{{0.8, 0.1, 0, -20}, {-0.1, 0.9, 0.3, 30}, {0, -0.2, 2, 40}}}};
    assert_ok(sc_zalloc(&quiet, VOXELS, (size_t)bytes, &v->ids));
    assert_ok(SC_ZALLOC(&quiet, LABELS, &v->labels));
    for (int id = 0; id < LABELS; id++) {
        v->labels[id].value = 10 * id;
        snprintf(v->labels[id].name, SC_NAME_BYTES, "tissue %d", id);
        v->labels[id].has_color = id == 4;
        v->labels[id].rgb[0] = (uint8_t)id;
    }
    for (int i = 0; i < VOXELS; i++) {
        const int x = i % WIDTH, id = (int)(random_bits(&seed) % LABELS);
        const int used = x < 2 || id == 5 ? 0 : id;

        if (bytes == 1)
            ((uint8_t *)v->ids)[i] = (uint8_t)used;
        else
            ((uint16_t *)v->ids)[i] = (uint16_t)used;
    }
}

static int id_of(const sc_volume *v, int x, int y, int z)
{
    const int i = (z * v->size[1] + y) * v->size[0] + x;

    return v->label_bytes == 1 ? ((const uint8_t *)v->ids)[i] : ((const uint16_t *)v->ids)[i];
}

/* Find what a scan of the voxels would. */
static void scan_of(const sc_volume *v, sc_volume *out)
{
    void *block;

    *out = *v;
    out->ids = NULL;
    assert_ok(sc_alloc(&quiet, (size_t)v->label_count, sizeof(sc_label), &block));
    memcpy(block, v->labels, (size_t)v->label_count * sizeof(sc_label));
    out->labels = block;
    assert_ok(SC_ZALLOC(&quiet, (size_t)v->label_count, &out->tallies));
    for (int id = 0; id < v->label_count; id++) {
        bool which[LABELS] = {false};
        sc_label_tally *tally = &out->tallies[id];

        for (int i = 0; i < v->size[0] * v->size[1] * v->size[2]; i++)
            tally->voxels += id_of(v, i % v->size[0], i / v->size[0] % v->size[1],
                                   i / v->size[0] / v->size[1]) == id;
        which[id] = true;
        if (id && tally->voxels) {
            const sc_voxel_box box = sc_volume_box(v, which);

            memcpy(tally->low, box.low, sizeof box.low);
            memcpy(tally->high, box.high, sizeof box.high);
        } else if (!tally->voxels) {
            *tally = (sc_label_tally){0, {0, 0, 0}, {-1, -1, -1}};
        }
    }
}

/* Compare what two scans have found of all tissues. */
static void assert_same_scan(const sc_volume *a, const sc_volume *b)
{
    assert_int_equal(a->label_count, b->label_count);
    for (int id = 1; id < a->label_count; id++) {
        assert_int_equal(a->tallies[id].voxels, b->tallies[id].voxels);
        assert_memory_equal(a->tallies[id].low, b->tallies[id].low, sizeof a->tallies[id].low);
        assert_memory_equal(a->tallies[id].high, b->tallies[id].high, sizeof a->tallies[id].high);
    }
}

/* 1 and 4 and the empty 5 become a part of 2, which gets a name and the colour of 4; 3 is left out.
 */
TEST(labels_are_merged_and_left_out)
{
    static const int into[LABELS] = {0, 2, 2, 0, 2, 2, 6};
    static const int64_t values[] = {0, 20, 60};
    static const int to[LABELS] = {0, 1, 1, 0, 1, 1, 2};
    const char *names[LABELS] = {[2] = "all"};

    for (int bytes = 1; bytes <= 2; bytes++) {
        SC_OWN(sc_relabel_clear) sc_relabel relabel = {0}, again = {0};
        SC_OWN(sc_volume_clear) sc_volume scan = {0}, expected = {0};
        SC_OWN(sc_volume_clear) sc_volume v = {0}, before = {0};

        make_volume(bytes, &before);
        make_volume(bytes, &v);
        scan_of(&before, &scan);
        assert_ok(sc_relabel_make(&quiet, v.labels, LABELS, into, names, &relabel));
        assert_ok(sc_relabel_make(&quiet, v.labels, LABELS, into, names, &again));
        assert_ok(sc_volume_relabel(&quiet, &v, &relabel, 3));
        assert_int_equal(v.label_count, 3);
        for (int id = 0; id < 3; id++)
            assert_int_equal(v.labels[id].value, values[id]);
        assert_string_equal(v.labels[1].name, "all");
        assert_true(v.labels[1].has_color && v.labels[1].rgb[0] == 4);
        assert_false(v.labels[2].has_color);
        for (int i = 0; i < VOXELS; i++) {
            const int x = i % WIDTH, y = i / WIDTH % DEPTH, z = i / WIDTH / DEPTH;

            assert_int_equal(id_of(&v, x, y, z), to[id_of(&before, x, y, z)]);
        }
        assert_ok(sc_volume_relabel(&quiet, &scan, &again, 1));
        scan_of(&v, &expected);
        assert_same_scan(&scan, &expected);
    }
}

TEST(a_box_holds_all_voxels_and_no_more)
{
    const bool which[LABELS] = {[0] = true, [1] = true, [6] = true}, none[LABELS] = {[5] = true};
    sc_voxel_box box;
    SC_OWN(sc_volume_clear) sc_volume v = {0};

    make_volume(1, &v);
    memset(v.ids, 0, VOXELS);
    box = sc_volume_box(&v, which);
    assert_true(box.low[0] > box.high[0] && box.low[1] > box.high[1] && box.low[2] > box.high[2]);
    ((uint8_t *)v.ids)[(2 * DEPTH + 6) * WIDTH + 4] = 6;
    ((uint8_t *)v.ids)[(7 * DEPTH + 1) * WIDTH + 9] = 1;
    ((uint8_t *)v.ids)[0] = 2;
    box = sc_volume_box(&v, which);
    assert_int_equal(box.low[0], 4);
    assert_int_equal(box.high[0], 9);
    assert_int_equal(box.low[1], 1);
    assert_int_equal(box.high[1], 6);
    assert_int_equal(box.low[2], 2);
    assert_int_equal(box.high[2], 7);
    box = sc_volume_box(&v, none);
    assert_true(box.low[2] > box.high[2]);
}

/* Each voxel that stays has its label, at its place in patient space. */
TEST(what_is_cropped_stays_where_it_was)
{
    static const sc_voxel_box boxes[] = {{{0, 0, 0}, {WIDTH - 1, DEPTH - 1, HEIGHT - 1}},
                                         {{3, 1, 2}, {8, 5, 7}},
                                         {{10, 6, 8}, {10, 6, 8}},
                                         {{0, 3, 0}, {WIDTH - 1, 3, HEIGHT - 1}}};

    for (size_t b = 0; b < SC_COUNT_OF(boxes) * 2; b++) {
        const sc_voxel_box *box = &boxes[b / 2];
        SC_OWN(sc_volume_clear) sc_volume scan = {0};
        SC_OWN(sc_volume_clear) sc_volume v = {0}, before = {0};

        make_volume(1 + (int)(b % 2), &before);
        make_volume(1 + (int)(b % 2), &v);
        scan_of(&v, &scan);
        sc_volume_crop(&v, box);
        for (int i = 0; i < v.size[0] * v.size[1] * v.size[2]; i++) {
            const int x = i % v.size[0], y = i / v.size[0] % v.size[1];
            const int z = i / v.size[0] / v.size[1];
            const sc_vec3 here = sc_affine_point(&v.to_ras_mm, (sc_vec3){x, y, z});
            const sc_vec3 there = sc_affine_point(
                &before.to_ras_mm, (sc_vec3){x + box->low[0], y + box->low[1], z + box->low[2]});

            assert_int_equal(id_of(&v, x, y, z),
                             id_of(&before, x + box->low[0], y + box->low[1], z + box->low[2]));
            assert_near(sc_vec3_length(sc_vec3_sub(here, there)), 0, 1e-9);
        }
        for (int axis = 0; axis < 3; axis++)
            assert_int_equal(v.size[axis], box->high[axis] - box->low[axis] + 1);
        sc_volume_crop(&scan, box);
        assert_memory_equal(scan.size, v.size, sizeof v.size);
        assert_memory_equal(&scan.to_ras_mm, &v.to_ras_mm, sizeof v.to_ras_mm);
        for (int id = 1; id < LABELS; id++) {
            for (int axis = 0; axis < 3 && scan.tallies[id].voxels; axis++) {
                assert_in_range(scan.tallies[id].low[axis], 0, v.size[axis] - 1);
                assert_in_range(scan.tallies[id].high[axis], scan.tallies[id].low[axis],
                                v.size[axis] - 1);
            }
        }
    }
}

/* Too little memory changes nothing. */
TEST(out_of_memory_is_told)
{
    static const int into[LABELS] = {0, 1, 2, 3, 4, 5, 6};
    SC_OWN(sc_volume_clear) sc_volume v = {0};

    make_volume(1, &v);
    for (long budget = 0; budget < 2; budget++) {
        long left = budget;
        const sc_ctx ctx = {.rank = 0, .alloc_budget = &left};
        sc_relabel relabel = {0};

        assert_int_equal(sc_relabel_make(&ctx, v.labels, LABELS, into, NULL, &relabel),
                         SC_ERR_MEMORY);
        assert_null(relabel.to);
    }
}

RUN_TESTS(NULL, NULL)
