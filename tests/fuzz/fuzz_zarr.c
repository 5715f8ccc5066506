/* SPDX-License-Identifier: BSD-3-Clause */
/* The input is a store of OME-Zarr with one array: the metadata of the array, a NUL byte, the
 * attributes of its group, a NUL byte, and the first chunk. Metadata that begin with a blank are
 * those of version 3. */
#include "volume.h"

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    static const char *const directories[] = {"store", "store/0", "store/0/c", "store/0/c/0",
                                              "store/0/c/0/0"};
    static const char group[] = "{\"zarr_format\": 2}";

    fuzz_make_directories(directories, SC_COUNT_OF(directories));
    (void)fuzz_write("store/.zgroup", group, sizeof group - 1);
    return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const uint8_t *parts[3];
    size_t sizes[3];
    const bool third = size && data[0] == ' ';

    fuzz_split(data, size, parts, sizes);
    unlink(fuzz_path(third ? "store/0/.zarray" : "store/0/zarr.json"));
    (void)fuzz_write(third ? "store/0/zarr.json" : "store/0/.zarray", parts[0], sizes[0]);
    (void)fuzz_write("store/.zattrs", parts[1], sizes[1]);
    (void)fuzz_write(third ? "store/0/c/0/0/0" : "store/0/0.0.0", parts[2], sizes[2]);
    fuzz_read_volume(fuzz_path("store"));
    fuzz_read_grey(fuzz_path("store"));
    return 0;
}
