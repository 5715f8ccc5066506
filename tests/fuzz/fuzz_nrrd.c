/* SPDX-License-Identifier: BSD-3-Clause */
/* The input is a file of the format NRRD. Beside it lie in.raw, in01.raw and in02.raw,
 * which it may name for its voxels. */
#include "volume.h"

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    static const uint8_t voxels[64] = {0, 1, 2, 3, 4};

    (void)argc;
    (void)argv;
    fuzz_write("in.raw", voxels, sizeof voxels);
    fuzz_write("in01.raw", voxels, sizeof voxels);
    fuzz_write("in02.raw", voxels, sizeof voxels);
    return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_volume("input.nhdr", data, size);
    return 0;
}
