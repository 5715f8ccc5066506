/* SPDX-License-Identifier: BSD-3-Clause */
/* MetaImage files whose voxels are in a file for each slice, behind a header of their own, or
 * written as digits. */
#include "check.h"

#include "segcast/volume.h"

#include <unistd.h>
#include <zlib.h>

enum { NX = 4, NY = 3, NZ = 3, SLICE = NX * NY, VOXELS = SLICE * NZ };

static char message[1024];

static void keep(void *user, sc_log_level level, const char *text)
{
    snprintf(message, sizeof message, "%s", text);
}

static const sc_ctx ctx = {.level = SC_LOG_ERROR, .write = keep};

static int value_of(int i)
{
    return (i * 5) % 7 + 300 * (i % 2);
}

/* Write m.mhd, whose last lines are @p lines. */
static void write_header(const char *lines)
{
    FILE *file = fopen("m.mhd", "w");

    assert_non_null(file);
    fprintf(file,
            "NDims = 3\nDimSize = %d %d %d\nElementType = MET_USHORT\n"
            "BinaryDataByteOrderMSB = True\nTransformMatrix = 1 0 0 0 1 0 0 0 1\n%s",
            NX, NY, NZ, lines);
    fclose(file);
}

/* Write slice @p z, with the highest byte first, behind @p before bytes, to @p path. */
static void write_slice(const char *path, int z, size_t before, bool packed)
{
    unsigned char data[64 + 2 * SLICE] = {0}, out[256];
    uLongf bytes = sizeof out;

    for (int i = 0; i < SLICE; i++) {
        data[before + 2 * (size_t)i] = (unsigned char)(value_of(z * SLICE + i) >> 8);
        data[before + 2 * (size_t)i + 1] = (unsigned char)value_of(z * SLICE + i);
    }
    if (packed) {
        assert_int_equal(compress(out, &bytes, data, 2 * SLICE), Z_OK);
        write_bytes(path, "", out, bytes);
    } else {
        write_bytes(path, "", data, before + 2 * SLICE);
    }
}

static void write_slices(size_t before, bool packed)
{
    static const char *const paths[NZ] = {"s08.raw", "s10.raw", "s12.raw"};

    for (int z = 0; z < NZ; z++)
        write_slice(paths[z], z, before, packed);
}

/* Read m.mhd as labels, and as a grey image. */
static void expect_values(void)
{
    SC_OWN(sc_volume_clear) sc_volume v = {0};

    assert_int_equal(sc_volume_read(&ctx, "m.mhd", &v), SC_OK);
    assert_int_equal(v.size[2], NZ);
    for (int i = 0; i < VOXELS; i++)
        assert_int_equal(v.labels[((uint8_t *)v.ids)[i]].value, value_of(i));
}

static void expect_refused(const char *lines, const char *why)
{
    sc_volume v = {0};

    write_header(lines);
    message[0] = '\0';
    assert_int_equal(sc_volume_read(&ctx, "m.mhd", &v), SC_ERR_DATA);
    if (!strstr(message, why))
        fail_msg("\"%s\", expected: %s", message, why);
}

static void remove_files(void)
{
    unlink("m.mhd");
    unlink("s08.raw");
    unlink("s10.raw");
    unlink("s12.raw");
}

TEST(each_slice_may_have_its_file)
{
    static const char list[] = "ElementDataFile = LIST\ns08.raw\r\n  s10.raw \n\ns12.raw";

    write_slices(0, false);
    write_header("ElementDataFile = s%02d.raw 8 12 2\n");
    expect_values();
    write_header(list);
    expect_values();
    write_header("ElementDataFile = LIST 2\ns08.raw\ns10.raw\ns12.raw\n");
    expect_values();
    write_slices(5, false); /* bytes in front of each slice */
    write_header("HeaderSize = 5\nElementDataFile = s%02d.raw 8 12 2\n");
    expect_values();
    write_header("HeaderSize = -1\nElementDataFile = s%02d.raw 8 12 2\n");
    expect_values();
    write_slices(0, true);
    write_header("CompressedData = True\nElementDataFile = s%02d.raw 8 12 2\n");
    expect_values();
    remove_files();
}

/* Write or remove the slices "s<number>.raw", the first of which has the number @p first. */
static void numbered(int first, bool writes)
{
    for (int z = 0; z < NZ; z++) {
        char path[16];

        snprintf(path, sizeof path, "s%d.raw", first + z);
        if (writes)
            write_slice(path, z, 0, false);
        else
            unlink(path);
    }
}

TEST(numbers_of_a_pattern_have_defaults)
{
    numbered(1, true);
    write_header("ElementDataFile = s%d.raw\n"); /* from 1 on */
    expect_values();
    numbered(1, false);
    numbered(7, true);
    write_header("ElementDataFile = s%d.raw 7\n"); /* as many as there are slices */
    expect_values();
    numbered(7, false);
    remove_files();
}

TEST(wrong_series_are_refused)
{
    write_slices(0, false);
    expect_refused("ElementDataFile = s%02d.raw 8 11 2\n", "names 2 files; expected one for each");
    expect_refused("ElementDataFile = s%02d.raw 8 12 1\n", "names 5 files; expected one for each");
    expect_refused("ElementDataFile = s%02d.raw 8 12 0\n", "names 0 files");
    expect_refused("ElementDataFile = s%02x.raw 8 12 2\n", "expected a pattern such as");
    expect_refused("ElementDataFile = s%999d.raw 8 12 2\n", "expected a pattern such as");
    expect_refused("ElementDataFile = s%02d%d.raw 8 12 2\n", "expected a pattern such as");
    expect_refused("ElementDataFile = ../s%02d.raw 8 12 2\n", "outside the header's directory");
    expect_refused("ElementDataFile = t%02d.raw 8 12 2\n", "t08.raw: No such file");
    expect_refused("ElementDataFile = LIST\ns08.raw\ns10.raw\n", "names 2 files; expected one");
    expect_refused("ElementDataFile = LIST\ns08.raw\ns10.raw\ns12.raw\ns12.raw\n",
                   "names more than 3 files");
    expect_refused("ElementDataFile = LIST 1\ns08.raw\n", "expected LIST or LIST 2");
    expect_refused("ElementDataFile = LIST\n/etc/passwd\n", "an absolute path");
    expect_refused("HeaderSize = 1\nElementDataFile = s%02d.raw 8 12 2\n",
                   "s08.raw has 24 bytes, fewer than its slice");
    expect_refused("DimSize = 1 1 2147483647\nElementDataFile = s%02d.raw\n",
                   "2147483647 slices, each in a file of its own");
    expect_refused("HeaderSize = -2\nElementDataFile = s%02d.raw 8 12 2\n", "HeaderSize is \"-2\"");
    expect_refused("BinaryData = False\nElementDataFile = s%02d.raw 8 12 2\n",
                   "BinaryData is False");
    expect_refused("CompressedData = True\nElementDataFile = s%02d.raw 8 12 2\n", "s08.raw");
    remove_files();
}

TEST(digits_are_read)
{
    char text[512 + VOXELS * 8] = "ElementDataFile = LOCAL\n";
    char *numbers = text + strlen(text);

    for (int i = 0; i < VOXELS; i++)
        snprintf(text + strlen(text), 8, i % NX ? "%d " : "%d\n", value_of(i));
    memmove(text + 20, text, strlen(text) + 1);
    memcpy(text, "BinaryData = False \n", 20);
    write_header(text);
    expect_values();
    numbers[20 + 9] = 'x';
    expect_refused(text, "is no number; expected numbers with blanks between them");
    numbers[20 + 9] = '\0';
    expect_refused(text, "the header promises 36 voxels");
    remove_files();
}

TEST(bytes_before_the_voxels_are_skipped)
{
    unsigned char data[3 + 2 * VOXELS] = "abc";

    for (int i = 0; i < VOXELS; i++) {
        data[3 + 2 * i] = (unsigned char)(value_of(i) >> 8);
        data[3 + 2 * i + 1] = (unsigned char)value_of(i);
    }
    write_bytes("s08.raw", "", data, sizeof data);
    write_header("HeaderSize = 3\nElementDataFile = s08.raw\n");
    expect_values();
    write_header("HeaderSize = -1\nElementDataFile = s08.raw\n");
    expect_values();
    expect_refused("HeaderSize = 4\nElementDataFile = s08.raw\n", "more than s08.raw can hold (71");
    remove_files();
}

/* MET_LONG has four bytes in MetaIO, whatever the machine's long has. */
TEST(long_numbers_have_four_bytes)
{
    unsigned char data[4 * VOXELS] = {0};

    for (int i = 0; i < VOXELS; i++) {
        data[4 * i + 2] = (unsigned char)(value_of(i) >> 8);
        data[4 * i + 3] = (unsigned char)value_of(i);
    }
    write_bytes("s08.raw", "", data, sizeof data);
    write_header("ElementType = MET_ULONG\nElementDataFile = s08.raw\n");
    expect_values();
    write_header("ElementType = MET_LONG\nElementDataFile = s08.raw\n");
    expect_values();
    remove_files();
}

/* Read m.mhd, and check the length of a voxel along z. */
static void expect_length(double mm)
{
    SC_OWN(sc_volume_clear) sc_volume v = {0};

    expect_values();
    assert_int_equal(sc_volume_read(&ctx, "m.mhd", &v), SC_OK);
    assert_near(v.to_ras_mm.m[2][2], mm, 1e-9);
}

/* Keys in other capitals, other units, and axes of one voxel behind the third are read. */
TEST(other_spellings_are_read)
{
    const sc_ctx told = {.level = SC_LOG_WARN, .write = keep};
    unsigned char data[2 * VOXELS] = {0};
    SC_OWN(sc_volume_clear) sc_volume v = {0};

    for (int i = 0; i < VOXELS; i++) {
        data[2 * i] = (unsigned char)(value_of(i) >> 8);
        data[2 * i + 1] = (unsigned char)value_of(i);
    }
    write_bytes("s08.raw", "", data, sizeof data);
    write_header("elementspacing = 1 2 3\nELEMENTDATAFILE = s08.raw\n");
    expect_length(3);
    write_header("ElementSpacing = 1 2 3\nDistanceUnits = um\nElementDataFile = s08.raw\n");
    expect_length(3e-3);
    write_header("ElementSpacing = 1 2 3\nDistanceUnits = ?\nElementDataFile = s08.raw\n");
    expect_length(3);
    write_header("NDims = 4\nDimSize = 4 3 3 1\nElementSpacing = 1 2 3 1\n"
                 "TransformMatrix = 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\nElementDataFile = s08.raw\n");
    expect_length(3);
    write_header("ElementDataFile = s08.raw\n");
    expect_length(1);
    message[0] = '\0';
    assert_int_equal(sc_volume_read(&told, "m.mhd", &v), SC_OK);
    assert_non_null(strstr(message, "does not give the spacing of its voxels"));
    expect_refused("ElementSpacing = 1 2 3\nDistanceUnits = parsec\nElementDataFile = s08.raw\n",
                   "DistanceUnits is \"parsec\"");
    expect_refused("NDims = 4\nDimSize = 4 3 3 2\nElementDataFile = s08.raw\n", "expected 3 axes");
    remove_files();
}

RUN_TESTS(NULL, NULL)
