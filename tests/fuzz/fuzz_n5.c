/* SPDX-License-Identifier: BSD-3-Clause */
/* The input is a group of N5 with one level, s0: the attributes of the group, a NUL byte, those of
 * the level, a NUL byte, and its first block. */
#include "volume.h"

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    static const char *const directories[] = {"store", "store/s0", "store/s0/0", "store/s0/0/0"};

    fuzz_make_directories(directories, SC_COUNT_OF(directories));
    return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const uint8_t *parts[3];
    size_t sizes[3];

    fuzz_split(data, size, parts, sizes);
    (void)fuzz_write("store/attributes.json", parts[0], sizes[0]);
    (void)fuzz_write("store/s0/attributes.json", parts[1], sizes[1]);
    (void)fuzz_write("store/s0/0/0/0", parts[2], sizes[2]);
    fuzz_read_volume(fuzz_path("store"));
    fuzz_read_grey(fuzz_path("store"));
    return 0;
}
