/* SPDX-License-Identifier: BSD-3-Clause */
/* The input is a file of the format NIfTI. Beside it lies the other file of a pair,
 * which it may name for its voxels. */
#include "volume.h"

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    static const uint8_t voxels[64] = {0, 1, 2, 3, 4};

    (void)argc;
    (void)argv;
    fuzz_write("input.img", voxels, sizeof voxels);
    return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    fuzz_volume("input.hdr", data, size);
    return 0;
}
