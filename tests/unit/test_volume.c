/* SPDX-License-Identifier: BSD-3-Clause */
/* The readers and label tables, on files that this test writes itself: every type of voxel, byte
 * order, encoding and orientation, and what is refused. */
#include "check.h"

#include "segcast/volume.h"

#include <math.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

enum { NX = 7, NY = 5, NZ = 4, VOXELS = NX * NY * NZ };

static int64_t value_of(int i)
{
    return i % 11 == 0 ? 0 : (i * 7) % 100;
}

static void write_file(const char *path, const char *head, const void *data, size_t bytes,
                       bool packed)
{
    FILE *file = fopen(path, "wb");

    assert_non_null(file);
    fputs(head, file);
    fflush(file);
    if (packed) {
        gzFile gz = gzdopen(dup(fileno(file)), "wb");

        gzwrite(gz, data, (unsigned)bytes);
        gzclose(gz);
    } else {
        fwrite(data, 1, bytes, file);
    }
    fclose(file);
}

static uint32_t id_at(const sc_volume *v, int i)
{
    return v->label_bytes == 1 ? ((uint8_t *)v->ids)[i] : ((uint16_t *)v->ids)[i];
}

static void expect_values(const sc_volume *v)
{
    assert_int_equal(v->size[0], NX);
    assert_int_equal(v->size[1], NY);
    assert_int_equal(v->size[2], NZ);
    for (int i = 0; i < VOXELS; i++)
        assert_int_equal(v->labels[id_at(v, i)].value, value_of(i));
}

/* Write the test's values to @p out as numbers of type @p type, with their bytes swapped if asked
 * for.
 * @return how many bytes they take. */
static size_t store(char *out, const char *type, bool swapped)
{
    const size_t each = !strcmp(type, "double") || strstr(type, "64")  ? 8
                        : !strcmp(type, "float") || strstr(type, "32") ? 4
                        : strstr(type, "16")                           ? 2
                                                                       : 1;

    for (int i = 0; i < VOXELS; i++) {
        const int64_t value = value_of(i);
        const double real = (double)value;
        const float single = (float)value;
        char *to = out + (size_t)i * each;

        memcpy(to,
               !strcmp(type, "double")  ? (const void *)&real
               : !strcmp(type, "float") ? (const void *)&single
                                        : (const void *)&value,
               each);
        for (size_t a = 0, b = each - 1; swapped && a < b; a++, b--) {
            const char swap = to[a];

            to[a] = to[b];
            to[b] = swap;
        }
    }
    return each * VOXELS;
}

TEST(nrrd_of_every_type_encoding_and_byte_order_is_read)
{
    static const char *const types[] = {"int8",   "uint8", "int16",  "uint16", "int32",
                                        "uint32", "int64", "uint64", "float",  "double"};
    char data[VOXELS * 8], head[512];

    for (size_t t = 0; t < SC_COUNT_OF(types); t++) {
        for (int variant = 0; variant < 4; variant++) {
            const bool swapped = variant & 1, packed = variant & 2;
            const size_t bytes = store(data, types[t], swapped);
            SC_OWN(sc_volume_clear) sc_volume v = {0};

            snprintf(head, sizeof head,
                     "NRRD0004\ntype: %s\ndimension: 3\nspace: left-posterior-superior\n"
                     "sizes: 7 5 4\nspace directions: (0.5,0,0) (0,0.5,0) (0,0,2)\n"
                     "space origin: (1,2,3)\nencoding: %s\nendian: %s\n\n",
                     types[t], packed ? "gzip" : "raw", swapped ? "big" : "little");
            write_file("t.nrrd", head, data, bytes, packed);
            assert_ok(sc_volume_read(&quiet, "t.nrrd", &v));
            expect_values(&v);
            assert_near(v.to_ras_mm.m[0][0], -0.5,
                        0); /* the axes to the left and posterior become right and anterior */
            assert_near(v.to_ras_mm.m[1][3], -2, 0);
            assert_near(v.to_ras_mm.m[2][2], 2, 0);
            assert_true(v.oriented);
        }
    }
    unlink("t.nrrd");
}

/* Lengths in micrometres as Fiji, atlases of the fly's brain and pynrrd write them. */
TEST(nrrd_units_are_read_of_the_space_and_of_axes)
{
#define MICRONS "space dimension: 3\nspace directions: (0.4,0,0) (0,0.4,0) (0,0,0.4)\nspace units: "
    static const struct {
        const char *fields;
        double mm;
        bool told;
    } cases[] = {{MICRONS "\"microns\" \"microns\" \"microns\"\n", 4e-4, false},
                 {MICRONS "\"micrometers\" \"micrometers\" \"micrometers\"\n", 4e-4, false},
                 {"spacings: 0.4 0.4 0.4\nunits: \"um\" \"um\" \"um\"\n", 4e-4, false},
                 {"spacings: 400 400 400\nunits: \"nanometers\" \"nm\" \"nm\"\n", 4e-4, false},
                 {"spacings: 0.4 0.4 0.4\nunits: \"\" \"\" \"\"\n", 0.4, false},
                 {MICRONS "\"cubits\" \"cubits\" \"cubits\"\n", 0.4, true},
                 {"spacings: 0.4 0.4 0.4\nunits: \"cubits\" \"cubits\" \"cubits\"\n", 0.4, true}};
#undef MICRONS
    char data[VOXELS * 8], head[512];
    const size_t bytes = store(data, "int16", false);

    for (size_t c = 0; c < SC_COUNT_OF(cases); c++) {
        const sc_ctx *ctx = listening_anew();
        SC_OWN(sc_volume_clear) sc_volume v = {0};

        snprintf(head, sizeof head,
                 "NRRD0004\ntype: int16\ndimension: 3\nsizes: 7 5 4\nencoding: raw\n"
                 "endian: little\n%s\n",
                 cases[c].fields);
        write_file("t.nrrd", head, data, bytes, false);
        assert_ok(sc_volume_read(ctx, "t.nrrd", &v));
        for (int i = 0; i < 3; i++)
            assert_near(v.to_ras_mm.m[i][i], cases[c].mm, 1e-12);
        assert_int_equal(said.warnings > 3, cases[c].told); /* one for each axis */
    }
    unlink("t.nrrd");
}

/* A header that names a file of voxels may end with an empty line, as pynrrd writes it. */
TEST(an_nrrd_with_a_file_of_its_own_is_read)
{
    static char data[4 * VOXELS];
    const size_t bytes = store(data, "int16", false);
    FILE *file = fopen("t.txt", "w");

    for (int i = 0; i < VOXELS; i++)
        fprintf(file, "%d ", (int)value_of(i));
    fclose(file);
    for (int i = 0; i < 6; i++) {
        static const char *const files[] = {"encoding: ascii\ndata file: t.txt\n",
                                            "encoding: raw\nendian: little\ndata file: t.raw\n",
                                            "encoding: gzip\nendian: little\ndata file: t.raw\n"};
        char header[256];
        const sc_ctx *ctx = listening_anew();
        SC_OWN(sc_volume_clear) sc_volume v = {0};

        write_file("t.raw", "", data, bytes, i / 2 == 2);
        snprintf(header, sizeof header,
                 "NRRD0004\ntype: short\ndimension: 3\nsizes: 7 5 4\nspacings: 1 1 2\n%s%s",
                 files[i / 2], i % 2 ? "\n" : "");
        write_file("t.nhdr", header, "", 0, false);
        assert_ok(sc_volume_read(ctx, "t.nhdr", &v));
        expect_values(&v);
        assert_false(v.oriented);
        assert_near(v.to_ras_mm.m[2][2], 2, 0);
        assert_null(strstr(said.text, "gzip"));
    }
    unlink("t.nhdr");
    unlink("t.txt");
    unlink("t.raw");
}

/* The bytes of a NIfTI-1 header, written field by field from the standard's offsets. */
static void nifti_header(unsigned char h[352], int datatype, int bits)
{
    const int32_t size = 348;

    memset(h, 0, 352);
    memcpy(h, &size, 4);
    put16(h + 40, 3);
    put16(h + 42, NX);
    put16(h + 44, NY);
    put16(h + 46, NZ);
    for (size_t i = 48; i < 56; i += 2)
        put16(h + i, 1);
    put16(h + 70, datatype);
    put16(h + 72, bits);
    for (size_t i = 76; i < 92; i += 4)
        put_real(h + i, 1);
    put_real(h + 108, 352);
    memcpy(h + 344, "n+1", 4);
    h[123] = 2; /* mm */
}

static void set_sform(unsigned char h[352], const float m[12])
{
    put16(h + 254, 1);
    for (size_t i = 0; i < 12; i++)
        put_real(h + 280 + 4 * i, m[i]);
}

static void write_nifti(const char *path, const unsigned char h[352], const void *data,
                        size_t bytes, bool packed)
{
    char whole[352 + VOXELS * 8];

    memcpy(whole, h, 352);
    memcpy(whole + 352, data, bytes);
    write_file(path, "", whole, 352 + bytes, packed);
}

TEST(nifti_geometry_comes_from_sform_then_qform_then_pixdim)
{
    static const float m[12] = {-2, 0, 0, 10, 0, 0, 3, 20, 0, -1, 0, 30};
    unsigned char h[352];
    char data[VOXELS * 8];
    const size_t bytes = store(data, "int16", false);
    sc_volume v;

    nifti_header(h, 4, 16);
    write_nifti("t.nii", h, data, bytes, false);
    assert_ok(sc_volume_read(&quiet, "t.nii", &v));
    expect_values(&v);
    assert_false(v.oriented);
    sc_volume_clear(&v);
    put16(h + 252, 1); /* qform: a half turn about z */
    put_real(h + 264, 1);
    put_real(h + 268, 7);
    write_nifti("t.nii", h, data, bytes, false);
    assert_ok(sc_volume_read(&quiet, "t.nii", &v));
    assert_near(v.to_ras_mm.m[0][0], -1, 1e-6);
    assert_near(v.to_ras_mm.m[0][3], 7, 1e-6);
    assert_true(v.oriented);
    sc_volume_clear(&v);
    set_sform(h, m);
    write_nifti("t.nii.gz", h, data, bytes, true);
    assert_ok(sc_volume_read(&quiet, "t.nii.gz", &v));
    expect_values(&v);
    for (int i = 0; i < 12; i++)
        assert_near(v.to_ras_mm.m[i / 4][i % 4], m[i], 1e-6);
    sc_volume_clear(&v);
    unlink("t.nii");
    unlink("t.nii.gz");
}

static void swap_bytes(unsigned char *at, size_t each, size_t count)
{
    for (; count; count--, at += each) {
        for (size_t a = 0, b = each - 1; a < b; a++, b--) {
            const unsigned char swap = at[a];

            at[a] = at[b];
            at[b] = swap;
        }
    }
}

TEST(nifti_of_the_other_byte_order_is_read)
{
    static const float m[12] = {-2, 0, 0, 10, 0, 0, 3, 20, 0, -1, 0, 30};
    unsigned char h[352];
    char data[VOXELS * 8];
    const size_t bytes = store(data, "int16", true);
    SC_OWN(sc_volume_clear) sc_volume v = {0};

    nifti_header(h, 4, 16);
    set_sform(h, m);
    swap_bytes(h, 4, 1);        /* sizeof_hdr */
    swap_bytes(h + 40, 2, 8);   /* dim */
    swap_bytes(h + 70, 2, 2);   /* datatype, bitpix */
    swap_bytes(h + 76, 4, 9);   /* pixdim, vox_offset */
    swap_bytes(h + 252, 2, 2);  /* qform_code, sform_code */
    swap_bytes(h + 280, 4, 12); /* srow_x, srow_y, srow_z */
    write_nifti("t.nii", h, data, bytes, false);
    assert_ok(sc_volume_read(&quiet, "t.nii", &v));
    expect_values(&v);
    assert_near(v.to_ras_mm.m[1][2], 3, 0);
    unlink("t.nii");
}

TEST(fractions_and_infinities_are_refused_with_their_voxel)
{
    unsigned char h[352];
    float data[VOXELS] = {0};
    SC_OWN(sc_volume_clear) sc_volume v = {0};

    nifti_header(h, 16, 32);
    data[NX * NY + 2] = 1.5f;
    write_nifti("t.nii", h, data, sizeof data, false);
    assert_int_equal(sc_volume_read(&listening, "t.nii", &v), SC_ERR_DATA);
    assert_non_null(strstr(said.text, "voxel (2, 0, 1) holds 1.5"));
    data[NX * NY + 2] = NAN;
    write_nifti("t.nii", h, data, sizeof data, false);
    assert_int_equal(sc_volume_read(&listening, "t.nii", &v), SC_ERR_DATA);
    data[NX * NY + 2] = 3e9f;
    write_nifti("t.nii", h, data, sizeof data, false);
    assert_ok(sc_volume_read(&listening, "t.nii", &v));
    assert_int_equal(v.labels[1].value, 3000000000);
    unlink("t.nii");
}

/* Labels that a writer has put into the whole range of an integer type, with the slope and
 * intercept that bring them back: NumPy's floats in a NIfTI with a header of integers. */
TEST(whole_labels_with_a_slope_are_rounded_and_probabilities_are_not)
{
    static const struct {
        int datatype, bits;
        double labels[3], lowest; /* lowest: the stored number of label 0 */
    } cases[] = {{4, 16, {1, 2, 3}, -32768},
                 {2, 8, {1, 2, 3}, 0},
                 {2, 8, {2, 53, 105}, 0},
                 {4, 16, {17, 1001, 2035}, -32768},
                 {2, 8, {0.1, 0.5, 1}, 0}};

    for (size_t c = 0; c < SC_COUNT_OF(cases); c++) {
        const double slope = cases[c].labels[2] / (cases[c].bits == 8 ? 255 : 65535);
        unsigned char h[352], data[VOXELS * 2];
        const sc_ctx *ctx = listening_anew();
        SC_OWN(sc_volume_clear) sc_volume v = {0};

        nifti_header(h, cases[c].datatype, cases[c].bits);
        put_real(h + 112, (float)slope);
        put_real(h + 116, (float)(-cases[c].lowest * slope));
        for (size_t i = 0; i < VOXELS; i++) {
            const double label = i % 4 ? cases[c].labels[i % 4 - 1] : 0;
            const int stored = (int)lround(label / slope + cases[c].lowest);

            if (cases[c].bits == 8)
                data[i] = (unsigned char)stored;
            else
                put16(data + 2 * i, stored);
        }
        write_nifti("t.nii", h, data, VOXELS * (size_t)cases[c].bits / 8, false);
        if (cases[c].labels[0] < 1) {
            assert_int_equal(sc_volume_read(ctx, "t.nii", &v), SC_ERR_DATA);
            assert_non_null(strstr(said.text, "a fraction"));
            assert_null(strstr(said.text, "rounded"));
            continue;
        }
        assert_ok(sc_volume_read(ctx, "t.nii", &v));
        assert_int_equal(v.label_count, 4);
        for (int i = 1; i < 4; i++)
            assert_int_equal(v.labels[i].value, (int)cases[c].labels[i - 1]);
        assert_non_null(strstr(said.text, "rounded to whole numbers"));
    }
    unlink("t.nii");
}

/* 300 x 300 x 1 voxels with as many labels as wanted, signed and sparse. */
static sc_status read_labels(int distinct, sc_volume *out)
{
    enum { SIDE = 300 };
    static int32_t data[SIDE * SIDE];
    const sc_ctx *ctx = listening_anew();

    for (int i = 0; i < SIDE * SIDE; i++)
        data[i] = i % (distinct + 1) ? (i % (distinct + 1) - 40000) * 3 + 1 : 0;
    write_file("t.nrrd",
               "NRRD0004\ntype: int\ndimension: 3\nsizes: 300 300 1\nencoding: raw\n"
               "endian: little\n\n",
               data, sizeof data, false);
    return sc_volume_read(ctx, "t.nrrd", out);
}

/* Write a volume of noise with long runs to t.nrrd: more than 256 labels, the first of those beyond
 * in the middle, and at voxel @p bad a fraction. Large enough for several threads. */
enum { MANY_X = 125, MANY_Y = 131, MANY_Z = 161, MANY = MANY_X * MANY_Y * MANY_Z };
static void write_many(const char *encoding, size_t bad)
{
    float *data = malloc(MANY * sizeof *data);
    uint64_t random = 7;
    char head[256];

    assert_non_null(data);
    for (size_t i = 0, end; i < MANY; i = end) {
        const uint64_t bits = random_bits(&random);
        const int most = i < MANY / 2 ? 200 : 3000;

        end = i + 1 + bits % 400 < MANY ? i + 1 + bits % 400 : MANY;
        for (size_t k = i; k < end; k++)
            data[k] = bits >> 60 < 6 ? 0 : (float)((int)(bits >> 20) % most - 100);
    }
    for (size_t i = bad; i < MANY; i++)
        data[i] += 0.5F;
    snprintf(head, sizeof head,
             "NRRD0004\ntype: float\ndimension: 3\nsizes: %d %d %d\nspacings: 1 1 1\n"
             "encoding: %s\nendian: little\n\n",
             MANY_X, MANY_Y, MANY_Z, encoding);
    write_file("t.nrrd", head, data, MANY * sizeof *data, encoding[0] == 'g');
    free(data);
}

TEST_OF_THREADS(threads_do_not_change_what_is_read)
{
    for (int packed = 0; packed < 2; packed++) {
        SC_OWN(sc_volume_clear) sc_volume first = {0};
        SC_OWN(sc_volume_clear) sc_volume tallies = {0};

        write_many(packed ? "gzip" : "raw", MANY);
        assert_ok(sc_volume_read(&quiet, "t.nrrd", &first));
        assert_ok(sc_volume_read_by(&quiet, "t.nrrd", &(sc_read_choice){.depth = SC_READ_TALLIES},
                                    &tallies));
        assert_int_equal(first.label_bytes, 2);
        assert_true(first.label_count > 2000);
        for (int threads = 2; threads < 6; threads++) {
            sc_ctx ctx = quiet;
            SC_OWN(sc_volume_clear) sc_volume v = {0};
            SC_OWN(sc_volume_clear) sc_volume scan = {0};

            ctx.threads = threads;
            assert_ok(sc_volume_read(&ctx, "t.nrrd", &v));
            assert_ok(sc_volume_read_by(&ctx, "t.nrrd", &(sc_read_choice){.depth = SC_READ_TALLIES},
                                        &scan));
            assert_int_equal(v.label_count, first.label_count);
            assert_memory_equal(v.ids, first.ids, 2 * (size_t)MANY);
            for (int id = 0; id < v.label_count; id++)
                assert_int_equal(v.labels[id].value, first.labels[id].value);
            assert_memory_equal(scan.tallies, tallies.tallies,
                                (size_t)v.label_count * sizeof *scan.tallies);
        }
    }
    write_many("raw", MANY - 700000);
    for (int threads = 1; threads < 5; threads++) { /* the first of many fractions is named */
        sc_ctx ctx = *listening_anew();
        sc_volume v;
        const int at = MANY - 700000;
        char voxel[64];

        ctx.threads = threads;
        assert_int_equal(sc_volume_read(&ctx, "t.nrrd", &v), SC_ERR_DATA);
        snprintf(voxel, sizeof voxel, "voxel (%d, %d, %d) holds", at % MANY_X, at / MANY_X % MANY_Y,
                 at / MANY_X / MANY_Y);
        assert_non_null(strstr(said.text, voxel));
        assert_int_equal(said.errors, 1);
    }
    unlink("t.nrrd");
}

/* The same labels, in runs that begin and end anywhere in blocks and rows, as each type of voxel
 * that is looked at as it is stored, and as one that is not. */
TEST(runs_of_every_type_are_found)
{
    enum { X = 131, Y = 67, Z = 70, COUNT = X * Y * Z };
    static const struct {
        const char *name, *endian;
        size_t bytes;
        bool swapped;
    } types[] = {{"int8", "little", 1, false},  {"uint8", "little", 1, false},
                 {"int16", "little", 2, false}, {"uint16", "little", 2, false},
                 {"int32", "little", 4, false}, {"uint32", "little", 4, false},
                 {"int64", "little", 8, false}, {"uint64", "little", 8, false},
                 {"int32", "big", 4, true}};
    const sc_read_choice box = {.box = SC_READ_VOXELS, .voxels = {{40, 129}, {0, 66}, {3, 69}}};
    unsigned char *labels = malloc(COUNT), *stored = malloc((size_t)COUNT * 8);
    uint64_t random = 3;

    assert_non_null(labels);
    assert_non_null(stored);
    for (size_t i = 0, end; i < COUNT; i = end) {
        const uint64_t bits = random_bits(&random);

        end = i + 1 + (bits & 1 ? bits >> 8 & 7 : bits >> 8 & 511);
        end = end < COUNT ? end : COUNT;
        memset(labels + i, (int)(bits >> 40 & 127), end - i);
    }
    for (size_t t = 0; t < SC_COUNT_OF(types); t++) {
        const size_t each = types[t].bytes;
        char head[256];

        memset(stored, 0, COUNT * each);
        for (size_t i = 0; i < COUNT; i++)
            stored[i * each + (types[t].swapped ? each - 1 : 0)] = labels[i];
        snprintf(head, sizeof head,
                 "NRRD0004\ntype: %s\ndimension: 3\nsizes: %d %d %d\nspacings: 1 1 1\n"
                 "encoding: %s\nendian: %s\n\n",
                 types[t].name, X, Y, Z, t % 2 ? "gzip" : "raw", types[t].endian);
        write_file("t.nrrd", head, stored, COUNT * each, t % 2);
        for (int threads = 1; threads < 4; threads++) {
            sc_ctx ctx = quiet;
            SC_OWN(sc_volume_clear) sc_volume v = {0}, part = {0};

            ctx.threads = threads;
            assert_ok(sc_volume_read(&ctx, "t.nrrd", &v));
            assert_int_equal(v.label_count, 128);
            assert_memory_equal(v.ids, labels, COUNT); /* the ids are the labels here */
            assert_ok(sc_volume_read_by(&ctx, "t.nrrd", &box, &part));
            assert_int_equal(part.label_count, 128);
            for (size_t i = 0; i < sc_volume_voxels(&part); i++) {
                const size_t x = i % 89 + 40, y = i / 89 % 66, z = i / 89 / 66 + 3;

                assert_int_equal(((const uint8_t *)part.ids)[i], labels[(z * Y + y) * X + x]);
            }
        }
    }
    free(labels);
    free(stored);
    unlink("t.nrrd");
}

/* What is damaged behind the first batch is told by its own message, whichever thread reads it. */
TEST_OF_THREADS(damage_that_is_read_ahead_is_told)
{
    FILE *file;

    write_many("gzip", MANY);
    file = fopen("t.nrrd", "rb+");
    assert_non_null(file);
    assert_int_equal(fseek(file, -3000, SEEK_END), 0);
    for (int i = 0; i < 1000; i++)
        assert_int_equal(fputc(0xff, file), 0xff);
    assert_int_equal(fclose(file), 0);
    for (int threads = 1; threads < 4; threads++) {
        sc_ctx ctx = *listening_anew();
        sc_volume v = {0};

        ctx.threads = threads;
        assert_int_equal(sc_volume_read(&ctx, "t.nrrd", &v), SC_ERR_DATA);
        assert_int_equal(said.errors, 1);
        assert_non_null(strstr(said.text, "t.nrrd: ends after"));
        assert_non_null(strstr(said.text, "; ")); /* the reason of zlib */
        assert_null(strstr(said.text, "<fd:"));   /* which knows the file by a number only */
    }
    unlink("t.nrrd");
}

TEST(there_may_be_65533_labels_of_any_value)
{
    sc_volume v = {0};

    assert_ok(read_labels(255, &v));
    assert_int_equal(v.label_bytes, 1);
    assert_int_equal(v.label_count, 256);
    sc_volume_clear(&v);
    assert_ok(read_labels(256, &v));
    assert_int_equal(v.label_bytes, 2);
    sc_volume_clear(&v);
    assert_ok(read_labels(65533, &v));
    assert_int_equal(v.label_count, 65534);
    assert_int_equal(v.labels[0].value, 0);
    for (int i = 2; i < v.label_count; i++)
        assert_true(v.labels[i].value > v.labels[i - 1].value);
    assert_true(v.labels[1].value < 0);
    sc_volume_clear(&v);
    assert_int_equal(read_labels(65534, &v), SC_ERR_DATA);
    unlink("t.nrrd");
}

TEST(slicer_keys_name_and_colour_labels)
{
    char data[VOXELS];
    SC_OWN(sc_volume_clear) sc_volume v = {0};

    memset(data, 3, sizeof data);
    data[0] = 9;
    write_file("t.seg.nrrd",
               "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 7 5 4\nencoding: raw\n"
               "Segment0_ID:=a\nSegment0_Name:=left atrium\nSegment0_LabelValue:=9\n"
               "Segment0_Color:=1 0.5 0\nSegment1_ID:=b\nSegment1_LabelValue:=3\n"
               "Segment1_Color:=red\n\n",
               data, sizeof data, false);
    assert_ok(sc_volume_read(&quiet, "t.seg.nrrd", &v));
    assert_int_equal(v.label_count, 3);
    assert_string_equal(v.labels[2].name, "left atrium");
    assert_int_equal(v.labels[2].rgb[0], 255);
    assert_int_equal(v.labels[2].rgb[1], 128);
    assert_string_equal(v.labels[1].name, "");
    unlink("t.seg.nrrd");
}

/* MITK has the names and colours of labels as JSON in the header, in groups; several groups are the
 * components of voxels. */
TEST(groups_of_mitk_name_and_colour_labels)
{
    static const char *const headers[] = {
        "dimension: 3\nsizes: 7 5 4\nkinds: domain domain domain\n"
        "space directions: (1,0,0) (0,1,0) (0,0,1)\n",
        "dimension: 4\nsizes: 2 7 5 4\n"
        "kinds: vector domain domain domain\n"
        "space directions: none (1,0,0) (0,1,0) (0,0,1)\n"};
#define LABEL(name, value, color)                                                                  \
    "{\"color\": {\"type\": \"ColorProperty\", \"value\": [" color                                 \
    "]}, \"locked\": true, \"name\": \"" name "\", \"opacity\": 0.6, \"value\": " value            \
    ", \"visible\": true}"
    static const char *const groups[] = {
        "[{\"labels\": [" LABEL("Torso", "1", "0.1, 0.7, 0.1") ", " LABEL("Nose", "4",
                                                                          "0.9, 0.9, 0.1") "]}]",
        "[{\"labels\": [" LABEL("Torso", "1", "0.1, 0.7, 0.1") "]}, {\"labels\": [" LABEL(
            "Nose", "4", "0.9, 0.9, 0.1") "]}]"};
#undef LABEL
    char header[2048], data[2 * VOXELS];
    sc_volume v;

    for (int several = 0; several < 2; several++) {
        memset(data, 0, sizeof data);
        data[0] = 1;
        data[several ? 3 : 1] = 4; /* the second component of the second voxel, or that voxel */
        snprintf(header, sizeof header,
                 "NRRD0004\ntype: uchar\nspace: LPS\n%sencoding: raw\n"
                 "modality:=org.mitk.multilabel.segmentation\n"
                 "org.mitk.multilabel.segmentation.labelgroups:=%s\n\n",
                 headers[several], groups[several]);
        write_file("t.nrrd", header, data, VOXELS << several, false);
        assert_ok(sc_volume_read(&quiet, "t.nrrd", &v));
        assert_int_equal(v.label_count, 3);
        assert_string_equal(v.labels[1].name, "Torso");
        assert_int_equal(v.labels[2].value, 4);
        assert_string_equal(v.labels[2].name, "Nose");
        assert_true(v.labels[2].rgb[0] == 230 && v.labels[2].rgb[2] == 26);
        assert_true(v.labels[2].opacity < 0 && !v.labels[2].hidden);
        sc_volume_clear(&v);
    }
    write_file("t.nrrd",
               "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 7 5 4\nencoding: raw\n"
               "org.mitk.multilabel.segmentation.labelgroups:=[{\n\n",
               data, VOXELS, false);
    assert_int_equal(sc_volume_read(&listening, "t.nrrd", &v), SC_ERR_DATA);
    assert_non_null(strstr(said.text, "its label groups of MITK are no JSON"));
    unlink("t.nrrd");
}

static void expect_table(sc_table_format format, const char *text, float opacity, bool hidden)
{
    SC_OWN(sc_label_table_clear) sc_label_table table = {0};

    write_file("t.txt", text, "", 0, false);
    assert_ok(sc_label_table_read(&quiet, "t.txt", format, &table));
    assert_int_equal(table.count, 1);
    assert_int_equal(table.rows[0].value, 4);
    assert_string_equal(table.rows[0].name, "left atrium");
    assert_int_equal(table.rows[0].rgb[2], 30);
    assert_near(table.rows[0].opacity, opacity, 0.003);
    assert_int_equal(table.rows[0].hidden, hidden);
}

/* The sixth number of a row is opacity in tables of Slicer, but transparency in those of
 * FreeSurfer. */
TEST(tables_of_three_programs_are_read)
{
    sc_label_table table = {0};

    expect_table(SC_TABLE_AUTO, "# x\n4 left_atrium 10 20 30 255\n", -1, false);
    expect_table(SC_TABLE_SLICER, "4 left_atrium 10 20 30 51\n", 0.2f, false);
    expect_table(SC_TABLE_SLICER, "4 left_atrium 10 20 30 0\n", 0, true);
    expect_table(SC_TABLE_AUTO,
                 "\xef\xbb\xbf# ITK-SnAP Label Description File\r\n"
                 "4 10 20 30 0.5 1 1 \"left atrium\"\r\n",
                 0.5f, false);
    expect_table(SC_TABLE_ITKSNAP, "4 10 20 30 1 1 0 \"left atrium\"\n", -1, true);
    write_file("t.txt", "4 10 20 30 1 1 0 \"the \\\"left\\\" atrium \"A\"\"\n", "", 0, false);
    assert_ok(sc_label_table_read(&quiet, "t.txt", SC_TABLE_ITKSNAP, &table));
    assert_string_equal(table.rows[0].name, "the \"left\" atrium \"A\"");
    sc_label_table_clear(&table);
    write_file("t.txt", "4 Left-Atrium 10 20 30 0\n5 b 1 2 3 0\n", "", 0, false);
    assert_ok(sc_label_table_read(&listening, "t.txt", SC_TABLE_AUTO, &table));
    assert_non_null(strstr(said.text, "FreeSurfer"));
    assert_false(table.rows[0].hidden);
    sc_label_table_clear(&table);
    write_file("t.txt", "4 left_atrium\nnonsense\n", "", 0, false);
    assert_int_equal(sc_label_table_read(&listening, "t.txt", SC_TABLE_SLICER, &table),
                     SC_ERR_DATA);
    assert_non_null(strstr(said.text, "t.txt:1:"));
    write_file("t.txt", "# no label\n\n", "", 0, false);
    assert_int_equal(sc_label_table_read(&listening, "t.txt", SC_TABLE_AUTO, &table), SC_ERR_DATA);
    assert_non_null(strstr(said.text, "has no labels"));
    write_file("t.txt", "0 background 0 0 0 0\n", "", 0, false);
    assert_ok(sc_label_table_read(&listening, "t.txt", SC_TABLE_AUTO, &table));
    assert_int_equal(table.count, 0);
    sc_label_table_clear(&table);
    unlink("t.txt");
}

/* Names that are no UTF-8 or too long are mended where they are read, told by one warning. */
TEST(names_are_valid_utf8_whatever_the_file_holds)
{
    enum { NAME = SC_NAME_BYTES - 2 }; /* a character of two bytes behind so many has no room */
    char text[1024], letters[NAME + 1], data[VOXELS] = {0};
    sc_label_table table = {0};
    SC_OWN(sc_volume_clear) sc_volume v = {0};

    memset(letters, 'x', NAME);
    letters[NAME] = '\0';
    snprintf(text, sizeof text,
             "1 %s\xc3\xa9\xc3\xa9 1 2 3 255\n2 \xff 1 2 3 255\n3 ok 1 2 3 255\n", letters);
    write_file("t.txt", text, "", 0, false);
    assert_ok(sc_label_table_read(&listening, "t.txt", SC_TABLE_SLICER, &table));
    assert_string_equal(table.rows[0].name, letters);
    assert_string_equal(table.rows[1].name, "\xef\xbf\xbd");
    assert_non_null(strstr(said.text, "2 names are not UTF-8 or longer"));
    sc_label_table_clear(&table);
    snprintf(text, sizeof text, "4 1 2 3 1 1 1 \"%s\xc3\xa9\"\n5 1 2 3 1 1 1 \"b\x9b\"\n", letters);
    write_file("t.txt", text, "", 0, false);
    assert_ok(sc_label_table_read(&listening, "t.txt", SC_TABLE_ITKSNAP, &table));
    assert_string_equal(table.rows[0].name, letters);
    assert_string_equal(table.rows[1].name, "b\xef\xbf\xbd");
    sc_label_table_clear(&table);
    unlink("t.txt");
    data[0] = 1;
    snprintf(text, sizeof text,
             "NRRD0004\ntype: uchar\ndimension: 3\nspace: RAS\nsizes: 7 5 4\n"
             "space directions: (1,0,0) (0,1,0) (0,0,1)\nencoding: raw\n"
             "Segment0_ID:=a\nSegment0_Name:=%s\xc3\xa9\n\n",
             letters);
    write_file("t.seg.nrrd", text, data, sizeof data, false);
    assert_ok(sc_volume_read(&listening, "t.seg.nrrd", &v));
    assert_int_equal(strlen(v.labels[1].name), 254);
    assert_string_equal(v.labels[1].name, letters);
    assert_non_null(strstr(said.text, "1 name is not UTF-8 or longer"));
    unlink("t.seg.nrrd");
}

TEST(an_allocation_that_fails_is_reported_and_frees_all)
{
    char data[VOXELS * 8];
    const size_t bytes = store(data, "int16", false);

    write_file("t.nrrd",
               "NRRD0004\ntype: short\ndimension: 3\nsizes: 7 5 4\nencoding: raw\n"
               "endian: little\nSegment0_ID:=a\nSegment0_LabelValue:=9\n\n",
               data, bytes, false);
    for (long n = 0;; n++) {
        long budget = n;
        sc_ctx ctx = *listening_anew();
        sc_volume v = {0};
        sc_status status;

        ctx.alloc_budget = &budget;
        status = sc_volume_read(&ctx, "t.nrrd", &v);
        if (status == SC_OK) {
            assert_true(n > 2);
            sc_volume_clear(&v);
            break;
        }
        assert_int_equal(status, SC_ERR_MEMORY);
        assert_int_equal(said.errors, 1);
        assert_null(v.ids);
    }
    unlink("t.nrrd");
}

/* A volume whose header could not be read for want of memory may still be the one that reads a
 * file: that is told, never "no". */
TEST(whether_a_volume_reads_a_file_is_never_guessed)
{
    bool reads = false;

    write_file("t.raw", "x", "", 0, false);
    write_file("t.nhdr",
               "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 1 1 1\nencoding: raw\n"
               "data file: t.raw\n",
               "", 0, false);
    for (long n = 0; !reads; n++) {
        long budget = n;
        sc_ctx ctx = *listening_anew();

        ctx.alloc_budget = &budget;
        if (sc_volume_reads(&ctx, "t.nhdr", "t.raw", &reads) == SC_OK) {
            assert_true(reads && n > 0);
        } else {
            assert_int_equal(budget, -1);
            assert_int_equal(said.errors, 1);
        }
    }
    assert_ok(sc_volume_reads(&quiet, "t.nhdr", "t.nhdr", &reads));
    assert_true(reads);
    assert_ok(sc_volume_reads(&quiet, "t.raw", "t.nhdr", &reads));
    assert_false(reads);
    assert_ok(sc_volume_reads(&quiet, "t.gone", "t.nhdr", &reads));
    assert_false(reads);
    unlink("t.raw");
    unlink("t.nhdr");
}

/* Check that a scan finds the labels that reading finds, and where each lies, and that reading the
 * header finds the label table. */
static void expect_same_scan(const char *path)
{
    SC_OWN(sc_volume_clear) sc_volume scan = {0}, header = {0};
    SC_OWN(sc_volume_clear) sc_volume v = {0};

    assert_ok(sc_volume_read(&quiet, path, &v));
    assert_ok(sc_volume_read_by(&quiet, path, &(sc_read_choice){.depth = SC_READ_TALLIES}, &scan));
    assert_ok(sc_volume_read_by(&quiet, path, &(sc_read_choice){.depth = SC_READ_HEADER}, &header));
    assert_null(scan.ids);
    assert_memory_equal(scan.size, v.size, sizeof v.size);
    assert_memory_equal(header.size, v.size, sizeof v.size);
    assert_memory_equal(&scan.to_ras_mm, &v.to_ras_mm, sizeof v.to_ras_mm);
    assert_memory_equal(&header.to_ras_mm, &v.to_ras_mm, sizeof v.to_ras_mm);
    assert_int_equal(scan.label_count, v.label_count);
    assert_memory_equal(scan.labels, v.labels, (size_t)v.label_count * sizeof *v.labels);
    assert_null(header.tallies);
    for (int id = 0; id < v.label_count; id++) {
        sc_label_tally t = {0, {NX, NY, NZ}, {-1, -1, -1}};

        for (int i = 0; i < VOXELS; i++) {
            const int at[3] = {i % NX, i / NX % NY, i / NX / NY};

            for (int axis = 0; axis < 3 && id_at(&v, i) == (uint32_t)id; axis++) {
                t.low[axis] = at[axis] < t.low[axis] ? at[axis] : t.low[axis];
                t.high[axis] = at[axis] > t.high[axis] ? at[axis] : t.high[axis];
            }
            t.voxels += id_at(&v, i) == (uint32_t)id;
        }
        assert_int_equal(scan.tallies[id].voxels, t.voxels);
        assert_memory_equal(scan.tallies[id].low, t.low, sizeof t.low);
        assert_memory_equal(scan.tallies[id].high, t.high, sizeof t.high);
    }
}

TEST(a_scan_finds_the_labels_of_every_encoding)
{
    static const char *const encodings[] = {"raw", "gzip", "ascii"};
    char data[VOXELS * 8], text[VOXELS * 8] = "", head[512];
    unsigned char h[352];

    for (int i = 0; i < VOXELS; i++)
        snprintf(text + strlen(text), sizeof text - strlen(text), "%d ", (int)value_of(i));
    for (size_t e = 0; e < SC_COUNT_OF(encodings); e++) {
        const size_t bytes = store(data, "int16", true);

        snprintf(head, sizeof head,
                 "NRRD0004\ntype: int16\ndimension: 3\nsizes: 7 5 4\nencoding: %s\n"
                 "endian: big\nSegment0_ID:=a\nSegment0_Name:=seven\nSegment0_LabelValue:=7\n\n",
                 encodings[e]);
        write_file("t.nrrd", head, e < 2 ? data : text, e < 2 ? bytes : strlen(text), e == 1);
        expect_same_scan("t.nrrd");
    }
    nifti_header(h, 4, 16);
    write_nifti("t.nii.gz", h, data, store(data, "int16", false), true);
    expect_same_scan("t.nii.gz");
    write_file("t.mha",
               "NDims = 3\nDimSize = 7 5 4\nElementType = MET_FLOAT\nElementDataFile = LOCAL\n",
               data, store(data, "float", false), false);
    expect_same_scan("t.mha");
    unlink("t.nrrd");
    unlink("t.nii.gz");
    unlink("t.mha");
}

TEST(nrrd_lines_and_bytes_before_the_voxels_are_skipped)
{
    char data[64 + VOXELS * 8] = "one line\n12345";
    const size_t before = strlen(data);
    const size_t bytes = store(data + before, "int16", false);
    sc_volume v;

    write_file("t.raw", "", data, before + bytes, false);
    write_file("t.nhdr",
               "NRRD0004\ntype: short\ndimension: 3\nsizes: 7 5 4\nencoding: raw\nendian: little\n"
               "line skip: 1\nbyte skip: 5\ndata file: t.raw\n",
               "", 0, false);
    assert_ok(sc_volume_read(&quiet, "t.nhdr", &v));
    expect_values(&v);
    sc_volume_clear(&v);
    write_file("t.nhdr",
               "NRRD0004\ntype: short\ndimension: 3\nsizes: 7 5 4\nencoding: raw\nendian: little\n"
               "byte skip: -1\ndata file: t.raw\n",
               "", 0, false);
    assert_ok(sc_volume_read(&quiet, "t.nhdr", &v));
    expect_values(&v);
    sc_volume_clear(&v);
    write_file("t.raw", "one line\n", data + 9, before - 9 + bytes, true);
    write_file("t.nhdr",
               "NRRD0004\ntype: short\ndimension: 3\nsizes: 7 5 4\nencoding: gzip\nendian: little\n"
               "line skip: 1\nbyte skip: 5\ndata file: t.raw\n",
               "", 0, false);
    assert_ok(sc_volume_read(&quiet, "t.nhdr", &v));
    expect_values(&v);
    sc_volume_clear(&v);
    unlink("t.raw");
    unlink("t.nhdr");
}

TEST(a_header_and_a_table_name_labels_together)
{
    sc_label rows[] = {{.value = 12, .name = "twelve", .opacity = -1},
                       {.value = 3, .name = "three", .opacity = -1},
                       {.value = 12, .name = "not this", .opacity = -1}};
    const sc_label_table table = {rows, SC_COUNT_OF(rows), SC_COUNT_OF(rows)};
    SC_OWN(sc_volume_clear) sc_volume scan = {0};
    char data[VOXELS] = {0};

    write_file("t.nrrd",
               "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 7 5 4\nencoding: raw\n"
               "Segment0_ID:=a\nSegment0_Name:=seven\nSegment0_LabelValue:=7\n\n",
               data, sizeof data, false);
    assert_ok(
        sc_volume_read_by(&quiet, "t.nrrd", &(sc_read_choice){.depth = SC_READ_HEADER}, &scan));
    assert_int_equal(scan.label_count, 2);
    assert_ok(sc_volume_add_labels(&quiet, &scan, &table));
    assert_int_equal(scan.label_count, 4);
    assert_string_equal(scan.labels[1].name, "three");
    assert_string_equal(scan.labels[2].name, "seven");
    assert_string_equal(scan.labels[3].name, "twelve");
    unlink("t.nrrd");
}

/* A scan holds only a block of voxels in memory, not the volume. */
TEST(a_scan_needs_little_memory)
{
    enum { SIDE = 512, MOST_BYTES = 16 << 20 };
    uint64_t before;
    SC_OWN(sc_volume_clear) sc_volume scan = {0};
    FILE *file = fopen("t.nrrd", "wb");

    assert_non_null(file);
    fprintf(file, "NRRD0004\ntype: uint8\ndimension: 3\nsizes: %d %d %d\nencoding: raw\n\n", SIDE,
            SIDE, SIDE / 2);
    fflush(file);
    assert_int_equal(ftruncate(fileno(file), ftell(file) + (off_t)SIDE * SIDE * SIDE / 2), 0);
    fclose(file);
    before = sc_peak_rss();
    assert_ok(
        sc_volume_read_by(&quiet, "t.nrrd", &(sc_read_choice){.depth = SC_READ_TALLIES}, &scan));
    assert_true(sc_peak_rss() - before < MOST_BYTES);
    assert_int_equal(scan.tallies[0].voxels, SIDE * SIDE * SIDE / 2);
    unlink("t.nrrd");
}

#ifdef __linux__
/* @return the pages of this process that are in memory. */
static long pages_in_memory(void)
{
    FILE *file = fopen("/proc/self/statm", "r");
    long all, there = 0;

    assert_non_null(file);
    assert_int_equal(fscanf(file, "%ld %ld", &all, &there), 2);
    fclose(file);
    return there;
}
#endif

/* Do pages that were only read take no memory? Not with the thread sanitizer, which notes every
 * access, nor with kernels that give each such page memory of its own. */
static bool counts_memory(void)
{
#if defined __has_feature
#if __has_feature(thread_sanitizer)
    return false;
#endif
#endif
#ifdef __linux__
    enum { BYTES = 1 << 25, PAGE_BYTES = 4096 };
    const long before = pages_in_memory();
    volatile char *block;
    long after;
    int sum = 0;

    assert_ok(sc_zalloc(&quiet, BYTES, 1, &block));
    for (size_t i = 0; i < BYTES; i += PAGE_BYTES)
        sum += block[i];
    after = pages_in_memory();
    sc_free((void *)(uintptr_t)block);
    return sum == 0 && after - before < BYTES / PAGE_BYTES / 2;
#else
    return false;
#endif
}

/* Where a volume holds background alone, its ids take no memory (on Linux). Labels in falling order
 * are numbered anew, and more than 256 take wider ids, which must not touch it either. */
TEST(background_takes_little_memory)
{
    enum { SIDE = 512, MOST_BYTES = 24 << 20, LABELS = 300 };

    for (int labels = 1; labels <= LABELS; labels += LABELS - 1) {
        const size_t voxels = (size_t)SIDE * SIDE * SIDE / 4;
        uint64_t before;
        size_t colored = 0;
        SC_OWN(sc_volume_clear) sc_volume v = {0};
        FILE *file = fopen("t.nrrd", "wb");

        assert_non_null(file);
        fprintf(file,
                "NRRD0004\ntype: uint16\nendian: little\ndimension: 3\nsizes: %d %d %d\n"
                "encoding: raw\n\n",
                SIDE, SIDE, SIDE / 4);
        for (int i = 0; i < labels; i++) {
            fputc((labels - i) & 255, file);
            fputc((labels - i) >> 8, file);
        }
        fflush(file);
        assert_int_equal(ftruncate(fileno(file), ftell(file) + (off_t)(voxels - labels) * 2), 0);
        fclose(file);
        before = sc_peak_rss();
        assert_ok(sc_volume_read(&quiet, "t.nrrd", &v));
        if (counts_memory())
            assert_true(sc_peak_rss() - before < MOST_BYTES);
        for (int i = 0; i < labels; i++)
            assert_int_equal(v.labels[id_at(&v, i)].value, labels - i);
        for (size_t i = 0; i < voxels; i++)
            colored += (v.label_bytes == 1 ? ((uint8_t *)v.ids)[i] : ((uint16_t *)v.ids)[i]) != 0;
        assert_int_equal(colored, labels);
    }
    unlink("t.nrrd");
}

/* For sc_ctx.write: keep the last warning in @p user. */
static void warned(void *user, sc_log_level level, const char *text)
{
    if (level == SC_LOG_WARN)
        snprintf(user, 512, "%s", text);
}

static const char *warning_of(const int16_t *data, int nx, int ny, int nz, const char *spacings)
{
    static char text[512];
    const sc_ctx ctx = {.level = SC_LOG_INFO, .write = warned, .user = text};
    char head[512];
    SC_OWN(sc_volume_clear) sc_volume v = {0};

    snprintf(head, sizeof head,
             "NRRD0004\ntype: int16\ndimension: 3\nspace: right-anterior-superior\nsizes: %d %d "
             "%d\nspace directions: %s\nencoding: raw\nendian: little\n\n",
             nx, ny, nz, spacings);
    write_file("t.nrrd", head, data, (size_t)nx * (size_t)ny * (size_t)nz * 2, false);
    text[0] = '\0';
    assert_ok(sc_volume_read(&ctx, "t.nrrd", &v));
    unlink("t.nrrd");
    return text;
}

TEST(what_is_hardly_a_label_volume_gets_a_warning)
{
    enum { SIDE = 20 };
    static const char mm[] = "(1,0,0) (0,1,0) (0,0,1)";
    static int16_t data[SIDE * SIDE * SIDE];
    uint64_t seed = 1;

    for (int i = 0; i < SIDE * SIDE * SIDE;
         i++) /* noise added to a ramp, with padding of one value */
        data[i] = (int16_t)(i % SIDE < 8 ? 1000 : i / 100 + (int)(random_bits(&seed) % 16));
    assert_non_null(strstr(warning_of(data, SIDE, SIDE, SIDE, mm), "grey-value image"));
    for (int i = 0; i < SIDE * SIDE * SIDE; i++) /* 400 labels in blocks, as in an atlas */
        data[i] = (int16_t)(i / SIDE);
    assert_string_equal(warning_of(data, SIDE, SIDE, SIDE, mm), "");
    for (int i = 0; i < SIDE * SIDE * SIDE; i++) /* few labels in random order */
        data[i] = (int16_t)(random_bits(&seed) % 16);
    assert_string_equal(warning_of(data, SIDE, SIDE, SIDE, mm), "");
    data[0] = -3;
    assert_non_null(strstr(warning_of(data, SIDE, SIDE, SIDE, mm), "negative values, down to -3"));
    data[0] = 3;
    assert_non_null(strstr(warning_of(data, SIDE, SIDE, SIDE, "(5e7,0,0) (0,5e7,0) (0,0,5e7)"),
                           "is the unit of its spacing right"));
    assert_non_null(strstr(warning_of(data, SIDE, SIDE, SIDE, "(1,0,0) (0,1,0) (0,0,0.001)"),
                           "is the spacing right"));
    assert_string_equal(warning_of(data, SIDE, SIDE, SIDE, "(4e-6,0,0) (0,4e-6,0) (0,0,4e-5)"), "");
}

/* Files that are no label volumes are refused with a message that says what to do instead. */
TEST(what_is_refused_is_told_what_to_do)
{
    static const int16_t two[2 * VOXELS]; /* volumes */
    static const struct {
        const char *bytes;
        size_t count;
        const char *advice;
    } files[] = {
        {"version https://git-lfs.github.com/spec/v1\n", 43, "git lfs pull"},
        {"\0\0\0\1\0\0\0\1\0\0\0\1\0\0", 14, "ends after 14 bytes, expected a header of 284"},
        {"II*\0\10\0\0\0", 8, "Fiji"},
        {"MM\0*\0\0\0\10", 8, "Fiji"},
        {"\x93NUMPY\1\0", 8, "pynrrd"},
        {"PK\3\4aaaa", 8, "unpack"},
        {"\xfd"
         "7zXZ\0aa",
         8, "unxz"},
        {"NDims = 4\nDimSize = 7 5 4 2\nElementType = MET_CHAR\nElementDataFile = LOCAL\n", 76,
         "image[:, :, :, 0]"},
        {"NDims = 3\nDimSize = 7 5 4\nElementType = MET_CHAR\nElementDataFile = LIST\n", 73,
         "expected one for each of the slices"},
        {"NRRD0004\ntype: uint8\ndimension: 4\nsizes: 2 7 5 4\nkinds: complex domain domain "
         "domain\n"
         "encoding: raw\n\n",
         100, "unu slice -a 0"},
        {"nothing known", 13, "3D Slicer and ITK-SNAP"},
    };
    char dicom[140] = {0};
    unsigned char h[352];
    sc_volume v;

    for (size_t i = 0; i < SC_COUNT_OF(files); i++) {
        write_file("t.bin", "", files[i].bytes, files[i].count, false);
        assert_int_equal(sc_volume_read(&listening, "t.bin", &v), SC_ERR_DATA);
        if (!strstr(said.text, files[i].advice))
            fail_msg("file %zu: \"%s\", expected advice with \"%s\"", i, said.text,
                     files[i].advice);
    }
    write_file("t.STL", "solid a", "", 0, false);
    assert_int_equal(sc_volume_read(&listening, "t.STL", &v), SC_ERR_DATA);
    assert_non_null(strstr(said.text, "t.STL: is a mesh"));
    unlink("t.STL");
    memcpy(dicom + 128, "DICM", 4);
    write_file("t.bin", "", dicom, sizeof dicom, false);
    assert_int_equal(sc_volume_read(&listening, "t.bin", &v), SC_ERR_DATA);
    assert_true(strstr(said.text, "of the class (none is named), expected a segmentation") ||
                strstr(said.text, "libdcmtk-dev"));
    nifti_header(h, 4, 16);
    put16(h + 40, 4);
    put16(h + 48, 2);
    write_nifti("t.nii", h, two, sizeof two, false);
    assert_int_equal(sc_volume_read(&listening, "t.nii", &v), SC_ERR_DATA);
    assert_non_null(strstr(said.text, "phase: N}"));
    unlink("t.bin");
    unlink("t.nii");
}

TEST(directories_are_told_what_to_do)
{
    static const struct {
        const char *file, *advice;
    } kinds[] = {{"t.dir/1.dcm", "dcm2niix"}, {"t.dir/x", "give the path"}};
    sc_volume v;

    assert_int_equal(mkdir("t.dir", 0777), 0);
    for (size_t i = 0; i < SC_COUNT_OF(kinds); i++) {
        write_file(kinds[i].file, "x", "", 0, false);
        assert_int_equal(sc_volume_read(&listening, "t.dir", &v), SC_ERR_MISSING);
        assert_non_null(strstr(said.text, "t.dir: is a directory"));
        assert_non_null(strstr(said.text, kinds[i].advice));
        unlink(kinds[i].file);
    }
    rmdir("t.dir");
}

/* The values in the file are label values, for any width of the ids. */
TEST(a_written_nrrd_holds_the_label_values)
{
    static const int64_t most[] = {200, 60000, 100000, 5000000000, -70000};

    for (size_t i = 0; i < SC_COUNT_OF(most); i++) {
        uint8_t ids[VOXELS];
        sc_label labels[3] = {{.value = 0}, {.value = 7}, {.value = most[i]}};
        sc_volume v = {.size = {NX, NY, NZ},
                       .label_bytes = 1,
                       .ids = ids,
                       .label_count = 3,
                       .labels = labels,
                       .to_ras_mm = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}}};
        SC_OWN(sc_volume_clear) sc_volume back = {0};

        for (int k = 0; k < VOXELS; k++)
            ids[k] = (uint8_t)(k % 3);
        assert_ok(sc_volume_save_nrrd(&quiet, &v, "t.nrrd", true));
        assert_ok(sc_volume_read(&quiet, "t.nrrd", &back));
        for (int k = 0; k < VOXELS; k++)
            assert_int_equal(back.labels[id_at(&back, k)].value, labels[k % 3].value);
    }
    unlink("t.nrrd");
}

/* The bounds of what can be drawn: a spacing, the ratio of two, the distance of the origin, and
 * axes that hardly differ. Beyond them rays would end nowhere, or outside of the volume. */
TEST(geometries_that_cannot_be_drawn_are_refused)
{
    static const struct {
        double mm[3], origin_mm, shear;
        sc_status wanted;
    } cases[] = {{{1, 1, 1}, 0, 0, SC_OK},
                 {{1, 1, 1e4}, 0, 0, SC_OK},
                 {{SC_SPACING_LEAST_MM, SC_SPACING_LEAST_MM, SC_SPACING_LEAST_MM}, 0, 0, SC_OK},
                 {{SC_SPACING_MOST_MM, SC_SPACING_MOST_MM, SC_SPACING_MOST_MM}, 0, 0, SC_OK},
                 {{1e-10, 1e-10, 1e-10}, 0, 0, SC_ERR_DATA},
                 {{1e-10, 1e-9, 1e-9}, 0, 0, SC_ERR_DATA},
                 {{2e8, 2e8, 2e8}, 0, 0, SC_ERR_DATA},
                 {{1e8, 1e8, 2e8}, 0, 0, SC_ERR_DATA},
                 {{1e-6, 1e8, 1e8}, 0, 0, SC_ERR_DATA},
                 {{1e-4, 1, 1e4}, 0, 0, SC_ERR_DATA},
                 {{1, 1, 1e5}, 0, 0, SC_ERR_DATA},
                 {{0.1, 0.1, 0.1}, 3e8, 0, SC_OK},
                 {{0.1, 0.1, 0.1}, 5e8, 0, SC_ERR_DATA},
                 {{1, 1, 1}, NAN, 0, SC_ERR_DATA},
                 {{1, 1, 1}, 0, 50, SC_OK},
                 {{1, 1, 1}, 0, 1e3, SC_ERR_DATA}};
    static const int size[3] = {20, 20, 20};
    int wrong = 0;

    for (size_t i = 0; i < SC_COUNT_OF(cases); i++) {
        const double *mm = cases[i].mm;
        const sc_affine to_mm = {{{mm[0], mm[1] * cases[i].shear, 0, cases[i].origin_mm},
                                  {0, mm[1], 0, 0},
                                  {0, 0, mm[2], 0}}};

        if (sc_geometry_check(NULL, "case", size, &to_mm) != cases[i].wanted) {
            print_error("case %zu is judged otherwise\n", i);
            wrong++;
        }
    }
    assert_int_equal(wrong, 0);
}

RUN_TESTS(NULL, NULL)
