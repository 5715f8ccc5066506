/* SPDX-License-Identifier: BSD-3-Clause */
/* The input is a volume of Neuroglancer's precomputed format with one scale, "s": the file "info",
 * a NUL byte, the properties of its segments, a NUL byte, and the only chunk of a volume of 8 x 8 x
 * 8 voxels, which is also the only shard. */
#include "volume.h"

#include <sys/stat.h>

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    static const char *const directories[] = {"volume", "volume/s", "volume/names"};

    (void)argc;
    (void)argv;
    for (size_t i = 0; i < SC_COUNT_OF(directories); i++) {
        const char *path = fuzz_path(directories[i]);

        FUZZ_CHECK(!mkdir(path, 0777));
    }
    return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const uint8_t *parts[3] = {data, NULL, NULL};
    size_t sizes[3] = {size, 0, 0};

    for (int i = 0; i < 2 && parts[i]; i++) {
        const uint8_t *end = sizes[i] ? memchr(parts[i], 0, sizes[i]) : NULL;

        if (!end)
            break;
        parts[i + 1] = end + 1;
        sizes[i + 1] = sizes[i] - (size_t)(end + 1 - parts[i]);
        sizes[i] = (size_t)(end - parts[i]);
    }
    (void)fuzz_write("volume/info", parts[0], sizes[0]);
    (void)fuzz_write("volume/names/info", parts[1] ? parts[1] : data, sizes[1]);
    (void)fuzz_write("volume/s/0-8_0-8_0-8", parts[2] ? parts[2] : data, sizes[2]);
    (void)fuzz_write("volume/s/0.shard", parts[2] ? parts[2] : data, sizes[2]);
    fuzz_read_volume(fuzz_path("volume"));
    fuzz_read_grey(fuzz_path("volume"));
    return 0;
}
