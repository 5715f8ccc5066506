/* SPDX-License-Identifier: BSD-3-Clause */
/* The input is one mask of a directory, in which there is another of 4 x 4 x 4 voxels. */
#include "volume.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const char beside[] = "NRRD0004\ntype: uint8\ndimension: 3\nspace: RAS\nsizes: 4 4 4\n"
                                 "space directions: (1,0,0) (0,1,0) (0,0,1)\n"
                                 "space origin: (0,0,0)\nencoding: raw\n\n"
                                 "0000000000000000000000000000000000000000000000000000000000000000";
    SC_OWN(sc_volume_clear) sc_volume volume = {0};
    sc_status status;

    (void)fuzz_write("beside.nrrd", beside, sizeof beside - 1);
    (void)fuzz_write("input.nrrd", data, size);
    status = sc_volume_read(&fuzz_ctx, fuzz_folder, &volume);
    FUZZ_CHECK(status == SC_OK || status == SC_ERR_DATA || status == SC_ERR_SYSTEM);
    if (status == SC_OK) {
        fuzz_check_labels(&volume);
        FUZZ_CHECK(volume.label_count <= 3);
    }
    return 0;
}
