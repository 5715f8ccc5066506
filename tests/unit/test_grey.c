/* SPDX-License-Identifier: BSD-3-Clause */
/* Grey volumes, read from files that this test writes itself: values of every kind of type, what is
 * refused, and the window that is chosen. */
#include "check.h"

#include "segcast/grey.h"

#include <math.h>
#include <unistd.h>

enum { NX = 5, NY = 4, NZ = 3, VOXELS = NX * NY * NZ };

static const sc_affine identity = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};

/* Write grey.nrrd with VOXELS values of the type, in the given byte order. */
static void write_nrrd(const char *type, const char *endian, const void *data, size_t bytes)
{
    char head[256];

    snprintf(head, sizeof head,
             "NRRD0004\ntype: %s\ndimension: 3\nsizes: %d %d %d\nspace: RAS\n"
             "space directions: (2,0,0) (0,3,0) (0,0,4)\nspace origin: (-1,5,7)\n"
             "encoding: raw\nendian: %s\n\n",
             type, NX, NY, NZ, endian);
    write_bytes("grey.nrrd", head, data, bytes);
}

/* Read grey.nrrd into codes[VOXELS]. */
static sc_status read_nrrd(const sc_ctx *ctx, const sc_grey_window *window, uint16_t *codes,
                           sc_grey *out)
{
    sc_status status = sc_grey_read_header(ctx, "grey.nrrd", out);

    if (status != SC_OK)
        return status;
    assert_int_equal(sc_grey_bytes(out), VOXELS * sizeof *codes);
    out->codes = codes;
    return sc_grey_read(ctx, "grey.nrrd", window, out);
}

static double value_at(const sc_grey *grey, int i)
{
    return grey->low + grey->per_code * grey->codes[i];
}

TEST(short_values_are_exact_in_both_byte_orders)
{
    int16_t values[VOXELS], swapped[VOXELS];
    uint16_t codes[VOXELS];
    sc_grey grey;

    for (int i = 0; i < VOXELS; i++) {
        values[i] = (int16_t)(i * 1100 - 32768);
        swapped[i] = (int16_t)((uint16_t)values[i] >> 8 | (uint16_t)((uint16_t)values[i] << 8));
    }
    write_nrrd("int16", "little", values, sizeof values);
    assert_ok(read_nrrd(&quiet, NULL, codes, &grey));
    assert_int_equal(grey.size[0], NX);
    assert_int_equal(grey.size[2], NZ);
    assert_near(grey.to_ras_mm.m[1][1], 3, 0);
    assert_near(grey.to_ras_mm.m[2][3], 7, 0);
    for (int i = 0; i < VOXELS; i++)
        assert_near(value_at(&grey, i), values[i], 0);
    write_nrrd("int16", "big", swapped, sizeof swapped);
    assert_ok(read_nrrd(&quiet, NULL, codes, &grey));
    for (int i = 0; i < VOXELS; i++)
        assert_near(value_at(&grey, i), values[i], 0);
    unlink("grey.nrrd");
}

TEST(a_scaled_nifti_holds_scaled_values)
{
    unsigned char h[352 + VOXELS] = {0};
    const int32_t size = 348;
    const int16_t dim[8] = {3, NX, NY, NZ, 1, 1, 1, 1}, type = 2 /* uint8 */, bits = 8;
    const float one[4] = {1, 1, 1, 1}, offset = 352, slope = -2.5f, intercept = 10;
    uint16_t codes[VOXELS];
    sc_grey grey;

    memcpy(h, &size, 4);
    memcpy(h + 40, dim, sizeof dim);
    memcpy(h + 70, &type, 2);
    memcpy(h + 72, &bits, 2);
    memcpy(h + 76, one, sizeof one);
    memcpy(h + 108, &offset, 4);
    memcpy(h + 112, &slope, 4);
    memcpy(h + 116, &intercept, 4);
    memcpy(h + 344, "n+1", 4);
    for (int i = 0; i < VOXELS; i++)
        h[352 + i] = (unsigned char)(4 * i);
    write_bytes("grey.nii", "", h, sizeof h);
    assert_ok(sc_grey_read_header(&quiet, "grey.nii", &grey));
    grey.codes = codes;
    assert_ok(sc_grey_read(&quiet, "grey.nii", NULL, &grey));
    for (int i = 0; i < VOXELS; i++)
        assert_near(value_at(&grey, i), 10 - 2.5 * (4 * i), 1e-9);
    unlink("grey.nii");
}

TEST(fractions_are_held_to_a_65535th_of_their_range)
{
    float values[VOXELS];
    uint16_t codes[VOXELS];
    sc_grey grey;

    for (int i = 0; i < VOXELS; i++)
        values[i] = sinf((float)i) * 300;
    write_nrrd("float", "little", values, sizeof values);
    assert_ok(read_nrrd(&quiet, NULL, codes, &grey));
    for (int i = 0; i < VOXELS; i++)
        assert_near(value_at(&grey, i), values[i], 600 / 65535.0);
    unlink("grey.nrrd");
}

TEST(what_is_no_number_is_the_lowest_and_told)
{
    double values[VOXELS];
    uint16_t codes[VOXELS];
    sc_grey grey;

    for (int i = 0; i < VOXELS; i++)
        values[i] = i + 0.5;
    values[7] = NAN;
    values[8] = INFINITY;
    values[9] = -INFINITY;
    write_nrrd("double", "little", values, sizeof values);
    assert_ok(read_nrrd(&listening, NULL, codes, &grey));
    assert_int_equal(said.warnings, 1);
    assert_non_null(strstr(said.text,
                           "no number (NaN): 1, shown as the lowest value; infinite ones: "
                           "2, shown as the lowest or the highest"));
    assert_near(value_at(&grey, 7), 0.5, 1e-3);
    assert_near(value_at(&grey, 8), VOXELS - 0.5, 1e-3);
    assert_near(value_at(&grey, 9), 0.5, 1e-3);
    values[7] = 7;
    write_nrrd("double", "little", values, sizeof values);
    assert_ok(read_nrrd(&listening, NULL, codes, &grey));
    assert_non_null(strstr(said.text, "infinite voxels: 2, shown as the lowest or the highest"));
    for (int i = 0; i < VOXELS; i++)
        values[i] = NAN;
    write_nrrd("double", "little", values, sizeof values);
    assert_int_equal(read_nrrd(&listening, NULL, codes, &grey), SC_ERR_DATA);
    assert_non_null(strstr(said.text, "no voxel holds a finite number"));
    unlink("grey.nrrd");
}

/* A single voxel of 1e30 must not take the precision of all others. */
TEST(extreme_values_cost_no_precision)
{
    enum { SIDE = 40, MANY = SIDE * SIDE * SIDE };
    static float values[MANY];
    static uint16_t codes[MANY];
    const sc_grey_window window = {50, 100};
    char head[200];
    sc_grey grey;

    snprintf(head, sizeof head,
             "NRRD0004\ntype: float\ndimension: 3\nsizes: %d %d %d\nencoding: raw\n"
             "endian: little\n\n",
             SIDE, SIDE, SIDE);
    for (int i = 0; i < MANY; i++)
        values[i] = (float)(i % 1000) * 0.1f;
    values[11] = 1e30f;
    write_bytes("grey.nrrd", head, values, sizeof values);
    for (int known = 0; known < 2; known++) {
        assert_ok(sc_grey_read_header(&quiet, "grey.nrrd", &grey));
        grey.codes = codes;
        assert_ok(sc_grey_read(&quiet, "grey.nrrd", known ? &window : NULL, &grey));
        for (int i = 0; i < MANY; i++)
            assert_near(value_at(&grey, i), i == 11 ? value_at(&grey, 11) : values[i], 0.01);
        assert_true(value_at(&grey, 11) > 99.9);
    }
    unlink("grey.nrrd");
}

TEST(colours_and_series_and_too_much_memory_are_refused)
{
    const uint8_t data[3 * VOXELS] = {0};
    sc_ctx ctx = *listening_anew();
    sc_grey grey;

    write_bytes(
        "grey.nrrd",
        "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 3 5 4 3\nkinds: RGB-color domain domain "
        "domain\nencoding: raw\n\n",
        data, sizeof data);
    assert_int_equal(sc_grey_read_header(&ctx, "grey.nrrd", &grey), SC_ERR_DATA);
    assert_int_equal(said.errors, 1);
    write_nrrd("uint8", "little", data, VOXELS);
    ctx.memory_max_bytes = VOXELS;
    assert_int_equal(sc_grey_read_header(&ctx, "grey.nrrd", &grey), SC_ERR_SYSTEM);
    assert_non_null(strstr(said.text, "--max-memory"));
    ctx.memory_max_bytes = 2 * VOXELS;
    assert_ok(sc_grey_read_header(&ctx, "grey.nrrd", &grey));
    write_nrrd("uint8", "little", data, VOXELS - 1);
    {
        uint16_t codes[VOXELS];

        assert_int_equal(read_nrrd(&ctx, NULL, codes, &grey), SC_ERR_DATA);
    }
    unlink("grey.nrrd");
}

TEST(a_file_that_changes_its_size_meanwhile_is_refused)
{
    const uint8_t data[VOXELS] = {0};
    uint16_t codes[VOXELS];
    sc_grey grey;

    write_nrrd("uint8", "little", data, sizeof data);
    assert_ok(sc_grey_read_header(&quiet, "grey.nrrd", &grey));
    write_bytes("grey.nrrd",
                "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 60 1 1\nencoding: raw\n\n", data,
                sizeof data);
    grey.codes = codes;
    assert_int_equal(sc_grey_read(&quiet, "grey.nrrd", NULL, &grey), SC_ERR_DATA);
    unlink("grey.nrrd");
}

TEST(an_allocation_that_fails_is_reported_and_frees_all)
{
    const uint8_t data[VOXELS] = {0};
    uint16_t codes[VOXELS];

    write_nrrd("uint8", "little", data, sizeof data);
    for (long n = 0;; n++) {
        long budget = n;
        sc_ctx ctx = *listening_anew();
        sc_grey grey;
        sc_status status;

        ctx.alloc_budget = &budget;
        status = read_nrrd(&ctx, NULL, codes, &grey);
        if (status == SC_OK) {
            assert_true(n > 3);
            break;
        }
        assert_int_equal(status, SC_ERR_MEMORY);
        assert_int_equal(said.errors, 1);
    }
    unlink("grey.nrrd");
}

TEST(what_is_written_is_read_again)
{
    uint16_t codes[VOXELS], again[VOXELS];
    sc_grey grey = {.size = {NX, NY, NZ}, .to_ras_mm = identity, .low = -1024, .per_code = 1};
    sc_grey other;

    grey.to_ras_mm.m[0][1] = 0.25;
    grey.codes = codes;
    for (int i = 0; i < VOXELS; i++)
        codes[i] = (uint16_t)(i * 37);
    assert_ok(sc_grey_save_nrrd(&quiet, &grey, "grey.nrrd", true));
    assert_ok(read_nrrd(&quiet, NULL, again, &other));
    assert_near(other.to_ras_mm.m[0][1], 0.25, 0);
    for (int i = 0; i < VOXELS; i++)
        assert_near(value_at(&other, i), value_at(&grey, i), 0);
    unlink("grey.nrrd");
}

/* Labels on a part of the image: the values elsewhere do not matter. */
TEST(the_window_follows_the_values_of_tissues)
{
    enum { SIDE = 32, MANY = SIDE * SIDE * SIDE };
    static uint16_t codes[MANY];
    static uint8_t ids[MANY];
    sc_grey grey = {
        .size = {SIDE, SIDE, SIDE}, .to_ras_mm = identity, .per_code = 1, .codes = codes};
    sc_volume labels = {.size = {SIDE, SIDE, SIDE},
                        .label_bytes = 1,
                        .ids = ids,
                        .label_count = 2,
                        .to_ras_mm = identity};
    sc_grey_window window = {-1, -1};
    sc_box3 box;
    bool found;

    grey.low = -1000;
    for (int i = 0; i < MANY; i++) {
        codes[i] = (uint16_t)(i % SIDE < 16 ? 0 : 1000 + i % 101); /* air; tissue of 0 to 100 */
        ids[i] = i % SIDE >= 16;
    }
    assert_ok(sc_grey_auto_window(&quiet, &grey, &labels, &window, &found));
    assert_true(found);
    assert_near(window.level, 50, 1.5);
    assert_near(window.width, 98, 3);
    labels.to_ras_mm.m[0][3] = 2 * SIDE;
    assert_ok(sc_grey_auto_window(&quiet, &grey, &labels, &window, &found));
    assert_false(found);
    assert_near(window.width, 65535, 0);
    box = sc_grid_box_mm(labels.size, &labels.to_ras_mm);
    assert_near(box.low.x, 2 * SIDE - 0.5, 1e-12);
    assert_near(box.high.x, 3 * SIDE - 0.5, 1e-12);
}

RUN_TESTS(NULL, NULL)
