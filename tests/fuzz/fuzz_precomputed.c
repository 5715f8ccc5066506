/* SPDX-License-Identifier: BSD-3-Clause */
/* The input is a volume of Neuroglancer's precomputed format with one scale, "s": the file "info",
 * a NUL byte, the properties of its segments, a NUL byte, and the only chunk of a volume of 8 x 8 x
 * 8 voxels, which is also the only shard. */
#include "volume.h"

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    static const char *const directories[] = {"volume", "volume/s", "volume/names"};

    fuzz_make_directories(directories, SC_COUNT_OF(directories));
    return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const uint8_t *parts[3];
    size_t sizes[3];

    fuzz_split(data, size, parts, sizes);
    (void)fuzz_write("volume/info", parts[0], sizes[0]);
    (void)fuzz_write("volume/names/info", parts[1], sizes[1]);
    (void)fuzz_write("volume/s/0-8_0-8_0-8", parts[2], sizes[2]);
    (void)fuzz_write("volume/s/0.shard", parts[2], sizes[2]);
    fuzz_read_volume(fuzz_path("volume"));
    fuzz_read_grey(fuzz_path("volume"));
    return 0;
}
