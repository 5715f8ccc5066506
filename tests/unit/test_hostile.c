/* SPDX-License-Identifier: BSD-3-Clause */
/* Volumes and tables that were made to do harm: headers that name other files of the machine,
 * lengths that lie, numbers without end. They are refused with a message, at once and in little
 * memory. */
#include "check.h"

#include "segcast/volume.h"

#include <limits.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

enum { VOXELS = 4 * 4 * 4 };

static const char nrrd[] = "NRRD0005\ntype: uint8\ndimension: 3\nspace: RAS\nsizes: 4 4 4\n"
                           "space directions: (1,0,0) (0,1,0) (0,0,1)\nencoding: raw\n";
static const char meta[] = "NDims = 3\nDimSize = 4 4 4\nElementType = MET_UCHAR\n"
                           "TransformMatrix = 1 0 0 0 1 0 0 0 1\n";

/* Make the folder t.d with the voxels in t.d/in.raw, t.d/sub/in.raw and one file for each of two
 * slices, and what lies outside of it. */
static void make_folder(void)
{
    char data[VOXELS];

    for (int i = 0; i < VOXELS; i++)
        data[i] = (char)(i % 5);
    mkdir("t.d", 0777);
    mkdir("t.d/sub", 0777);
    write_bytes("t.d/in.raw", "", data, sizeof data);
    write_bytes("t.d/sub/in.raw", "", data, sizeof data);
    write_bytes("t.d/s01.raw", "", data, sizeof data / 2);
    write_bytes("t.d/s02.raw", "", data, sizeof data / 2);
    write_bytes("t.out.raw", "", data, sizeof data);
    assert_int_equal(symlink("../t.out.raw", "t.d/link.raw"), 0);
    assert_int_equal(symlink("in.raw", "t.d/inside.raw"), 0);
    assert_int_equal(symlink("t.d", "t.linked"), 0);
    assert_int_equal(mkfifo("t.d/pipe.raw", 0666), 0);
}

static void remove_folder(void)
{
    static const char *const files[] = {"t.d/in.raw",   "t.d/sub/in.raw", "t.d/s01.raw",
                                        "t.d/s02.raw",  "t.d/link.raw",   "t.d/inside.raw",
                                        "t.d/pipe.raw", "t.d/h.nhdr",     "t.d/h.mhd",
                                        "t.out.raw",    "t.linked",       "t.link.nhdr"};

    for (size_t i = 0; i < SC_COUNT_OF(files); i++)
        unlink(files[i]);
    rmdir("t.d/sub");
    rmdir("t.d");
}

static sc_status read_volume(const sc_ctx *ctx, const char *path)
{
    SC_OWN(sc_volume_clear) sc_volume v = {0};
    const sc_status status = sc_volume_read(ctx, path, &v);

    if (status == SC_OK)
        assert_int_equal(v.label_count, 5);
    return status;
}

/* Headers of both formats in t.d that name @p name for their voxels. */
static void expect(const char *name, sc_status wanted, const char *said_wanted)
{
    char text[PATH_MAX + 512];
    const sc_ctx *ctx = listening_anew();

    snprintf(text, sizeof text, "%sdata file: %s\n", nrrd, name);
    write_bytes("t.d/h.nhdr", text, "", 0);
    assert_int_equal(read_volume(ctx, "t.d/h.nhdr"), wanted);
    if (wanted != SC_OK && !strstr(said.text, said_wanted))
        fail_msg("\"%s\", expected: %s", said.text, said_wanted);
    if (strchr(name, '\n') || strchr(name, '%'))
        return; /* lists and patterns are of NRRD only */
    snprintf(text, sizeof text, "%sElementDataFile = %s\n", meta, name);
    write_bytes("t.d/h.mhd", text, "", 0);
    assert_int_equal(read_volume(ctx, "t.d/h.mhd"), wanted);
    if (wanted != SC_OK && !strstr(said.text, said_wanted))
        fail_msg("\"%s\", expected: %s", said.text, said_wanted);
}

TEST(voxels_come_from_the_folder_of_the_header_only)
{
    char folder[PATH_MAX], path[PATH_MAX + 32];

    remove_folder();
    make_folder();
    expect("in.raw", SC_OK, "");
    expect("./in.raw", SC_OK, "");
    expect("sub/in.raw", SC_OK, "");
    expect("inside.raw", SC_OK, "");
    expect("LIST\ns01.raw\ns02.raw", SC_ERR_DATA, "expected 4 filenames");
    expect("LIST 3\ns01.raw\ns02.raw", SC_OK, "");
    expect("s%02d.raw 1 2 1 3", SC_OK, "");
    expect("sub/../in.raw", SC_OK, "");
    expect("../t.d/in.raw", SC_OK, "");
    assert_non_null(realpath("t.d", folder));
    snprintf(path, sizeof path, "%s/sub/in.raw", folder);
    expect(path, SC_OK, "");
    snprintf(path, sizeof path, "LIST 3\ns01.raw\n%s/s02.raw", folder);
    expect(path, SC_OK, "");
    snprintf(path, sizeof path, "%s/link.raw", folder);
    expect(path, SC_ERR_DATA, "an absolute path");
    snprintf(path, sizeof path, "%s.other/none.raw", folder);
    expect(path, SC_ERR_DATA, "an absolute path");
    expect("../none.raw", SC_ERR_DATA, "outside the header's directory");
    expect("/etc/passwd", SC_ERR_DATA, "an absolute path");
    expect("../t.out.raw", SC_ERR_DATA, "outside the header's directory");
    expect("sub/../../t.out.raw", SC_ERR_DATA, "outside the header's directory");
    expect("-", SC_ERR_DATA, "standard input");
    expect("link.raw", SC_ERR_DATA, "a link out of the directory");
    expect("pipe.raw", SC_ERR_DATA, "no regular file");
    expect("sub", SC_ERR_DATA, "no regular file");
    expect("none.raw", SC_ERR_DATA, "No such file");
    expect("LIST 3\ns01.raw\n/etc/passwd", SC_ERR_DATA, "an absolute path");
    expect("../t.out.r%dw 1 2 1 3", SC_ERR_DATA, "outside the header's directory");
    expect("s%02d.raw 1 2000000000 1", SC_ERR_DATA, "names 2000000000 files");
    expect("s%n.raw 1 2 1", SC_ERR_DATA, "expected a pattern");
    expect("s%999999d.raw 1 2 1", SC_ERR_DATA, "expected a pattern");
    expect("s%d%s.raw 1 2 1", SC_ERR_DATA, "expected a pattern");
    remove_folder();
}

/* The user may name a volume by a link: in a folder that is a link, and by a link to the header. */
TEST(a_volume_may_be_named_by_a_link)
{
    char text[512];

    make_folder();
    snprintf(text, sizeof text, "%sdata file: in.raw\n", nrrd);
    write_bytes("t.d/h.nhdr", text, "", 0);
    assert_ok(read_volume(&quiet, "t.linked/h.nhdr"));
    assert_int_equal(symlink("t.d/h.nhdr", "t.link.nhdr"), 0);
    assert_ok(read_volume(&quiet, "t.link.nhdr"));
    remove_folder();
}

/* Opening a pipe would wait for its writer. */
TEST(a_pipe_is_no_volume_and_no_table)
{
    sc_label_table table = {0};

    assert_int_equal(mkfifo("h.pipe", 0666), 0);
    assert_int_equal(read_volume(&listening, "h.pipe"), SC_ERR_MISSING);
    assert_non_null(strstr(said.text, "is a pipe"));
    assert_int_equal(sc_label_table_read(&listening, "h.pipe", SC_TABLE_AUTO, &table),
                     SC_ERR_MISSING);
    assert_non_null(strstr(said.text, "is a pipe"));
    unlink("h.pipe");
}

/* Numbers of encoding ascii: one without end overflowed a buffer of Teem, and one that does not fit
 * the type became another label. */
TEST(numbers_in_text_are_bounded)
{
    enum { DIGITS = 200000 };
    static char text[DIGITS + 1024];
    size_t used;

    used = (size_t)snprintf(
        text, sizeof text,
        "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nencoding: ascii\n\n1 ");
    memset(text + used, '1', DIGITS);
    strcpy(text + used + DIGITS, " 2 3");
    write_bytes("h.nrrd", text, "", 0);
    assert_int_equal(read_volume(&listening, "h.nrrd"), SC_ERR_DATA);
    assert_non_null(strstr(said.text, "expected a whole number that fits"));
    strcpy(text + used, "256");
    for (int i = 2; i < VOXELS; i++)
        strcat(text, ",\t0");
    write_bytes("h.nrrd", text, "", 0);
    assert_int_equal(read_volume(&listening, "h.nrrd"), SC_ERR_DATA);
    memcpy(text + used, "  4", 3);
    memcpy(strrchr(text, '\t') - 7, ", 2, 3", 6);
    write_bytes("h.nrrd", text, "", 0);
    assert_ok(read_volume(&listening, "h.nrrd"));
    unlink("h.nrrd");
}

/* A comment of any length within the header, as some programs write them. */
TEST(long_lines_of_metaimage_are_read)
{
    static char text[100000];
    char data[VOXELS];
    size_t used = (size_t)snprintf(text, sizeof text, "%sComment = ", meta);

    for (int i = 0; i < VOXELS; i++)
        data[i] = (char)(i % 5);
    memset(text + used, 'c', 70000);
    strcpy(text + used + 70000, "\nElementDataFile = LOCAL\n");
    write_bytes("h.mha", text, data, sizeof data);
    assert_ok(read_volume(&quiet, "h.mha"));
    unlink("h.mha");
}

/* A MetaImage whose zlib stream was damaged: its check sum is verified, as that of gzip is. */
TEST(the_check_sum_of_zlib_is_verified)
{
    unsigned char data[VOXELS], packed[256];
    uLongf bytes = sizeof packed;
    char text[512];

    for (int i = 0; i < VOXELS; i++)
        data[i] = (unsigned char)(i % 5);
    assert_int_equal(compress(packed, &bytes, data, sizeof data), Z_OK);
    snprintf(text, sizeof text, "%sCompressedData = True\nElementDataFile = LOCAL\n", meta);
    write_bytes("h.mha", text, packed, bytes);
    assert_ok(read_volume(&listening, "h.mha"));
    write_bytes("h.mha", text, packed, bytes - 4);
    assert_int_equal(read_volume(&listening, "h.mha"), SC_ERR_DATA);
    assert_non_null(strstr(said.text, "unexpected end of file"));
    packed[bytes - 1] ^= 1;
    write_bytes("h.mha", text, packed, bytes);
    assert_int_equal(read_volume(&listening, "h.mha"), SC_ERR_DATA);
    assert_non_null(strstr(said.text, "incorrect data check"));
    unlink("h.mha");
}

/* A name with what NRRD takes for an escape is the same after writing and reading. */
TEST(names_survive_writing_and_reading)
{
    uint8_t ids[VOXELS] = {0};
    sc_label labels[2] = {{.value = 0}, {.value = 7, .name = "a\\nb\\\\c:=d # e: f"}};
    const sc_volume v = {.size = {4, 4, 4},
                         .label_bytes = 1,
                         .ids = ids,
                         .label_count = 2,
                         .labels = labels,
                         .to_ras_mm = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}}};
    SC_OWN(sc_volume_clear) sc_volume back = {0};

    ids[5] = 1;
    assert_ok(sc_volume_save_nrrd(&quiet, &v, "h.nrrd", true));
    assert_ok(sc_volume_read(&quiet, "h.nrrd", &back));
    assert_int_equal(back.label_count, 2);
    assert_string_equal(back.labels[1].name, labels[1].name);
    unlink("h.nrrd");
}

/* A volume that takes more memory than the limit is refused before any of it is allocated; a scan
 * keeps no voxels and needs none. */
TEST(what_takes_more_memory_than_the_limit_is_refused)
{
    static const char *const encodings[] = {"raw", "ascii"};
    char text[512], data[VOXELS];
    sc_ctx ctx = *listening_anew();
    sc_volume scan;

    for (int i = 0; i < VOXELS; i++)
        data[i] = (char)(i % 5);
    snprintf(text, sizeof text, "%s\n", nrrd);
    write_bytes("h.nrrd", text, data, sizeof data);
    ctx.memory_max_bytes = 4 * VOXELS;
    assert_ok(read_volume(&ctx, "h.nrrd"));
    ctx.memory_max_bytes--;
    assert_int_equal(read_volume(&ctx, "h.nrrd"), SC_ERR_SYSTEM);
    assert_non_null(strstr(said.text, "--max-memory"));
    assert_ok(
        sc_volume_read_by(&ctx, "h.nrrd", &(sc_read_choice){.depth = SC_READ_TALLIES}, &scan));
    sc_volume_clear(&scan);
    ctx.memory_max_bytes = 1 << 20;
    for (size_t i = 0; i < SC_COUNT_OF(encodings); i++) {
        FILE *file = fopen("h.nrrd", "wb");

        assert_non_null(file);
        fprintf(file, "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 100 100 100\nencoding: %s\n\n",
                encodings[i]);
        for (int k = 0; k < 1000000; k++)
            fputs(i ? "1 " : "1", file);
        fclose(file);
        assert_int_equal(read_volume(&ctx, "h.nrrd"), SC_ERR_SYSTEM);
    }
    unlink("h.nrrd");
}

RUN_TESTS(NULL, NULL)
