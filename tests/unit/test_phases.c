/* SPDX-License-Identifier: BSD-3-Clause */
/* Files that hold the volumes of several phases (4-D): each phase is that of a file of its own,
 * wherever the axis of time stands, however the voxels are packed, with and without a store. */
#include "check.h"

#include "segcast/volume.h"

#include <unistd.h>
#include <zlib.h>

enum { NX = 7, NY = 5, NZ = 4, VOXELS = NX * NY * NZ, PHASES = 6 };

static int value_of(int phase, int i)
{
    return (i * 7 + phase * 13) % 10;
}

/* The values of all phases of 2 bytes each, one phase after the other or side by side. */
static void fill(int16_t values[PHASES * VOXELS], bool side_by_side)
{
    for (int phase = 0; phase < PHASES; phase++) {
        for (int i = 0; i < VOXELS; i++)
            values[side_by_side ? i * PHASES + phase : phase * VOXELS + i] =
                (int16_t)value_of(phase, i);
    }
}

/* Write @p head, and then the values in the encoding "raw", "gzip" or "ascii". */
static void write_values(const char *path, const void *head, size_t head_bytes,
                         const int16_t *values, const char *encoding)
{
    FILE *file = fopen(path, "wb");

    assert_non_null(file);
    fwrite(head, 1, head_bytes, file);
    for (int i = 0; i < PHASES * VOXELS && !strcmp(encoding, "ascii"); i++)
        fprintf(file, "%d\n", values[i]);
    if (!strcmp(encoding, "raw"))
        fwrite(values, 2, PHASES * VOXELS, file);
    fclose(file);
    if (!strcmp(encoding, "gzip")) {
        gzFile gz = gzopen(path, "ab");

        gzwrite(gz, values, 2 * PHASES * VOXELS);
        gzclose(gz);
    }
}

static void write_nrrd(const char *path, bool side_by_side, const char *encoding)
{
    int16_t values[PHASES * VOXELS];
    char head[512];

    fill(values, side_by_side);
    snprintf(head, sizeof head,
             "NRRD0005\ntype: int16\ndimension: 4\nspace: right-anterior-superior\nsizes: %s\n"
             "space directions: %s\nkinds: %s\nspace origin: (0,0,0)\nendian: little\n"
             "encoding: %s\n\n",
             side_by_side ? "6 7 5 4" : "7 5 4 6",
             side_by_side ? "none (1,0,0) (0,2,0) (0,0,1)" : "(1,0,0) (0,2,0) (0,0,1) none",
             side_by_side ? "list domain domain domain" : "domain domain domain time", encoding);
    write_values(path, head, strlen(head), values, encoding);
}

/* A NIfTI-1 file of all phases, 50 ms apart, the whole of it packed. */
static void write_nifti(const char *path)
{
    static const int dims[8] = {4, NX, NY, NZ, PHASES, 1, 1, 1};
    const int32_t size = 348;
    unsigned char whole[352 + 2 * PHASES * VOXELS] = {0};
    int16_t values[PHASES * VOXELS];
    gzFile gz = gzopen(path, "wb");

    memcpy(whole, &size, 4);
    for (int i = 0; i < 8; i++)
        put16(whole + 40 + 2 * i, dims[i]);
    put16(whole + 70, 4); /* int16 */
    put16(whole + 72, 16);
    for (int i = 0; i < 4; i++)
        put_real(whole + 76 + 4 * i, 1);
    put_real(whole + 92, 50);
    put_real(whole + 108, 352);
    whole[123] = 2 + 16; /* mm, ms */
    memcpy(whole + 344, "n+1", 4);
    fill(values, false);
    memcpy(whole + 352, values, sizeof values);
    gzwrite(gz, whole, sizeof whole);
    gzclose(gz);
}

static int value_at(const sc_volume *v, int i)
{
    return (int)v->labels[((const uint8_t *)v->ids)[i]].value;
}

/* Read a phase, counted from 0, and compare it with what was written. */
static void expect_phase(const sc_ctx *ctx, const char *path, int phase, sc_phase_store *store)
{
    const sc_read_choice choice = {.phase = phase + 1, .store = store};
    sc_read_choice less = choice;
    SC_OWN(sc_volume_clear) sc_volume v = {0};
    sc_volume scan = {0};

    assert_ok(sc_volume_read_by(ctx, path, &choice, &v));
    assert_int_equal(v.size[0], NX);
    assert_int_equal(v.size[1], NY);
    assert_int_equal(v.size[2], NZ);
    for (int i = 0; i < VOXELS; i++)
        assert_int_equal(value_at(&v, i), value_of(phase, i));
    less.depth = SC_READ_TALLIES;
    assert_ok(sc_volume_read_by(ctx, path, &less, &scan));
    assert_int_equal(scan.label_count, v.label_count);
    sc_volume_clear(&scan);
    less.depth = SC_READ_HEADER;
    assert_ok(sc_volume_read_by(ctx, path, &less, &scan));
    assert_int_equal(scan.size[2], NZ);
    sc_volume_clear(&scan);
}

/* All phases of a file, in an order that goes back, with and without a store. */
static void expect_phases(const char *path, const char *folder)
{
    static const int order[] = {3, 4, 5, 0, 1, 2, 5};
    const sc_ctx *ctx = listening_anew();
    sc_phase_store *store = NULL;
    double step_s;
    int count = 0;

    assert_ok(sc_volume_phases(ctx, path, &count, &step_s));
    assert_int_equal(count, PHASES);
    assert_ok(sc_phase_store_new(ctx, folder, &store));
    for (size_t i = 0; i < SC_COUNT_OF(order); i++) {
        expect_phase(ctx, path, order[i], NULL);
        expect_phase(ctx, path, order[i], store);
    }
    sc_phase_store_free(store);
    assert_int_equal(said.errors, 0);
}

TEST(phases_of_nrrd_are_read)
{
    static const char *const encodings[] = {"raw", "gzip", "ascii"};

    for (size_t i = 0; i < SC_COUNT_OF(encodings); i++) {
        write_nrrd("phases.nrrd", false, encodings[i]);
        expect_phases("phases.nrrd", ".");
        write_nrrd("phases.nrrd", true, encodings[i]);
        expect_phases("phases.nrrd", ".");
    }
    unlink("phases.nrrd");
}

/* More voxels than are read at a time, which are no whole number of voxels with all their phases.
 */
TEST(phases_of_a_large_file_are_sorted)
{
    enum { SIDE = 115, LARGE = SIDE * SIDE * SIDE };
    static const char head[] = "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 6 115 115 115\n"
                               "kinds: list domain domain domain\nencoding: raw\n\n";
    FILE *file = fopen("large.nrrd", "wb");
    sc_phase_store *store = NULL;

    fputs(head, file);
    for (int i = 0; i < PHASES * LARGE; i++)
        putc(value_of(i % PHASES, i / PHASES), file);
    assert_int_equal(fclose(file), 0);
    assert_ok(sc_phase_store_new(&quiet, ".", &store));
    for (int phase = 0; phase < PHASES; phase += 2) {
        const sc_read_choice choice = {.phase = phase + 1, .store = phase < 4 ? store : NULL};
        SC_OWN(sc_volume_clear) sc_volume v = {0};
        int wrong = 0;

        assert_ok(sc_volume_read_by(&quiet, "large.nrrd", &choice, &v));
        for (int i = 0; i < LARGE; i++)
            wrong += value_at(&v, i) != value_of(phase, i);
        assert_int_equal(wrong, 0);
    }
    sc_phase_store_free(store);
    unlink("large.nrrd");
}

TEST(phases_of_nifti_are_read)
{
    double step_s = 0;
    int count = 0;

    write_nifti("phases.nii.gz");
    expect_phases("phases.nii.gz", ".");
    assert_ok(sc_volume_phases(&quiet, "phases.nii.gz", &count, &step_s));
    assert_near(step_s, 0.05, 1e-7);
    unlink("phases.nii.gz");
    assert_ok(sc_volume_phases(&quiet, "phases.nii.gz", &count, &step_s)); /* a missing file */
    assert_int_equal(count, 1);
}

/* Without room for a store the phases are the same, and one warning tells of it. */
TEST(a_store_without_room_is_told)
{
    sc_phase_store *store = NULL;

    write_nrrd("phases.nrrd", true, "gzip");
    assert_ok(sc_phase_store_new(&listening, "no-such-folder", &store));
    said.warnings = 0;
    expect_phase(&listening, "phases.nrrd", 2, store);
    assert_non_null(strstr(said.text, "its 6 phases cannot be unpacked to no-such-folder"));
    expect_phase(&listening, "phases.nrrd", 1, store);
    assert_int_equal(said.warnings, 1);
    sc_phase_store_free(store);
    unlink("phases.nrrd");
}

static void expect_refused(const char *path, int phase, sc_phase_store *store, const char *message)
{
    const sc_ctx *ctx = listening_anew();
    sc_volume v = {0};

    assert_int_equal(
        sc_volume_read_by(ctx, path, &(sc_read_choice){.phase = phase, .store = store}, &v),
        SC_ERR_DATA);
    if (!strstr(said.text, message))
        print_error("expected \"%s\", found \"%s\"\n", message, said.text);
    assert_non_null(strstr(said.text, message));
    assert_int_equal(said.errors, 1);
}

/* Cut so many bytes off the end of a file. */
static void cut_off(const char *path, long bytes)
{
    FILE *file = fopen(path, "rb");

    assert_non_null(file);
    fseek(file, 0, SEEK_END);
    assert_int_equal(truncate(path, ftell(file) - bytes), 0);
    fclose(file);
}

TEST(mistakes_are_told)
{
    sc_phase_store *store = NULL;

    write_nrrd("phases.nrrd", false, "gzip");
    expect_refused("phases.nrrd", 0, NULL, "phases.nrrd: holds 6 volumes, one for each time (4-D)");
    expect_refused("phases.nrrd", PHASES + 1, NULL, "holds 6, expected 0 to 5");
    cut_off("phases.nrrd", 25);
    assert_ok(sc_phase_store_new(&quiet, ".", &store));
    expect_refused("phases.nrrd", 1, store, "bytes of voxels, in phase ");
    sc_phase_store_free(store);
    expect_refused("phases.nrrd", PHASES, NULL, "bytes of voxels of phase 5, expected 280");
    write_nrrd("phases.nrrd", false, "raw");
    cut_off("phases.nrrd", 100);
    expect_phase(&quiet, "phases.nrrd", 0, NULL); /* which is whole */
    expect_refused("phases.nrrd", PHASES, NULL,
                   "ends after 180 bytes of voxels of phase 5, expected 280");
    unlink("phases.nrrd");
}

RUN_TESTS(NULL, NULL)
