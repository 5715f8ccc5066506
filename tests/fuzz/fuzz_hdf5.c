/* SPDX-License-Identifier: BSD-3-Clause */
/* The input is what the program that reads HDF5 sends: an answer, and blocks of voxels. */
#include "formats/hdf5_process.h"
#include "fuzz.h"

#include <fcntl.h>
#include <math.h>

enum { MOST_BYTES = 4096 };

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static unsigned char voxels[MOST_BYTES];
    static char text[SC_HDF5_TEXT_BYTES + 1];
    const char *path = fuzz_write("stream", data, size);
    sc_hdf5_process process = {.out = open(path, O_RDONLY), .path = path, .silence_s = 1};
    sc_hdf5_answer answer;
    sc_status status = sc_hdf5_read_answer(&fuzz_ctx, &process, &answer, text);

    if (status == SC_OK) {
        FUZZ_CHECK(answer.type < SC_HDF5_TYPES && strlen(text) <= SC_HDF5_TEXT_BYTES);
        for (int i = 0; i < 12; i++)
            FUZZ_CHECK(isfinite(answer.to_ras_mm[i / 4][i % 4]));
        for (size_t bytes = 1; bytes <= MOST_BYTES && status == SC_OK; bytes *= 3)
            status = sc_hdf5_read_voxels(&fuzz_ctx, &process, bytes, voxels);
    }
    FUZZ_CHECK(status == SC_OK || status == SC_ERR_DATA || status == SC_ERR_MISSING ||
               status == SC_ERR_SYSTEM);
    FUZZ_CHECK(status == SC_OK || process.out == -1);
    sc_hdf5_end(&process);
    return 0;
}
