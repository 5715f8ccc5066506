/* SPDX-License-Identifier: BSD-3-Clause */
/* The input is a Radiance file. */
#include "fuzz.h"
#include "segcast/panorama.h"

#include <math.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    SC_OWN(sc_panorama_clear) sc_panorama panorama = {0};
    const sc_status status =
        sc_panorama_load(&fuzz_ctx, fuzz_write("input.hdr", data, size), &panorama);

    FUZZ_CHECK(status == SC_OK || status == SC_ERR_DATA);
    if (status == SC_OK) {
        const int pixels = panorama.width_px * panorama.height_px;

        FUZZ_CHECK(pixels > 0 && panorama.width_px <= SC_PANORAMA_WIDTH_MOST);
        for (int i = 0; i < pixels; i++)
            FUZZ_CHECK(panorama.rgb[i][0] >= 0 && isfinite(panorama.rgb[i][0]));
    }
    return 0;
}
