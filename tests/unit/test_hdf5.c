/* SPDX-License-Identifier: BSD-3-Clause */
/* What segcast makes of what the program sends that reads HDF5, without the program. */
#include "check.h"
#include "formats/hdf5_process.h"

#include <math.h>
#include <unistd.h>

static char message[1024];

static void keep(void *user, sc_log_level level, const char *text)
{
    snprintf(message, sizeof message, "%s", text);
}

static const sc_ctx ctx = {.level = SC_LOG_ERROR, .write = keep};

/* A pipe, one end of which is a process to segcast, and the other is written to. */
static sc_hdf5_process begin(int *writes)
{
    int ends[2];

    assert_int_equal(pipe(ends), 0);
    message[0] = '\0';
    *writes = ends[1];
    return (sc_hdf5_process){.out = ends[0], .path = "a.h5", .silence_s = 0.1};
}

static void put(int writes, const void *bytes, size_t count)
{
    assert_int_equal(write(writes, bytes, count), (ssize_t)count);
}

static sc_hdf5_answer volume(void)
{
    sc_hdf5_answer answer = {
        .kind = SC_HDF5_VOLUME, .text_bytes = 2, .size = {3, 2, 1}, .slope = 1};

    memcpy(answer.magic, SC_HDF5_MAGIC, sizeof answer.magic);
    for (int i = 0; i < 3; i++)
        answer.to_ras_mm[i][i] = 1;
    return answer;
}

TEST(silence_is_an_error)
{
    int writes;
    sc_hdf5_process process = begin(&writes);
    sc_hdf5_answer answer = volume();
    char text[SC_HDF5_TEXT_BYTES + 1];

    put(writes, &answer, sizeof answer - 1);
    assert_int_equal(sc_hdf5_read_answer(&ctx, &process, &answer, text), SC_ERR_DATA);
    assert_non_null(strstr(message, "a.h5: the HDF5 library was awaited for 0 s in vain"));
    assert_int_equal(process.out, -1);
    close(writes);
}

TEST(voxels_come_in_blocks)
{
    const uint64_t blocks[2] = {4, 2};
    const char why[] = "slices 0 to 1 cannot be read";
    const uint64_t none = 0;
    int writes;
    sc_hdf5_process process = begin(&writes);
    sc_hdf5_answer answer = volume(),
                   last = {.kind = SC_HDF5_DAMAGED, .text_bytes = sizeof why - 1};
    char text[SC_HDF5_TEXT_BYTES + 1], voxels[8] = "";

    memcpy(last.magic, SC_HDF5_MAGIC, sizeof last.magic);
    put(writes, &answer, sizeof answer);
    put(writes, "/a", 2);
    put(writes, &blocks[0], sizeof none);
    put(writes, "abcd", 4);
    put(writes, &blocks[1], sizeof none);
    put(writes, "ef", 2);
    put(writes, &none, sizeof none);
    put(writes, &last, sizeof last);
    put(writes, why, sizeof why - 1);
    assert_int_equal(sc_hdf5_read_answer(&ctx, &process, &answer, text), SC_OK);
    assert_string_equal(text, "/a");
    assert_int_equal(sc_hdf5_read_voxels(&ctx, &process, 3, voxels), SC_OK);
    assert_int_equal(sc_hdf5_read_voxels(&ctx, &process, 3, voxels + 3), SC_OK);
    assert_string_equal(voxels, "abcdef");
    assert_int_equal(sc_hdf5_read_voxels(&ctx, &process, 1, voxels), SC_ERR_DATA);
    assert_string_equal(message, "a.h5: slices 0 to 1 cannot be read");
    close(writes);
}

/* Answers that are refused, by what is changed. */
TEST(nonsense_is_refused)
{
    for (int i = 0; i < 9; i++) {
        int writes;
        sc_hdf5_process process = begin(&writes);
        sc_hdf5_answer answer = volume();
        char text[SC_HDF5_TEXT_BYTES + 1];

        switch (i) {
        case 0:
            answer.magic[7]++;
            break;
        case 1:
            answer.kind = 0;
            break;
        case 2:
            answer.kind = SC_HDF5_LIMIT + 1;
            break;
        case 3:
            answer.text_bytes = SC_HDF5_TEXT_BYTES + 1;
            break;
        case 4:
            answer.type = SC_HDF5_TYPES;
            break;
        case 5:
            answer.flags = SC_HDF5_FLAGS + 1;
            break;
        case 6:
            answer.size[1] = UINT64_MAX;
            break;
        case 7:
            answer.to_ras_mm[2][3] = NAN;
            break;
        default:
            answer.slope = INFINITY;
            break;
        }
        put(writes, &answer, sizeof answer);
        put(writes, "/a", 2);
        assert_int_equal(sc_hdf5_read_answer(&ctx, &process, &answer, text), SC_ERR_DATA);
        if (!strstr(message, "the program that reads HDF5 has answered with"))
            fail_msg("%d: %s", i, message);
        close(writes);
    }
}

RUN_TESTS(NULL, NULL)
