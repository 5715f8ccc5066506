/* SPDX-License-Identifier: BSD-3-Clause */
#include "segcast/annotate.h"

#include <math.h>

void sc_time_code(int k, int fps, char out[SC_TIME_CODE_BYTES])
{
    const int decimals = fps <= 50 ? 2 : 3;
    const double unit = decimals == 2 ? 100 : 1000;
    const double rounded_s = floor((double)k / fps * unit + 0.5) / unit;
    const int minutes = (int)(rounded_s / 60);

    snprintf(out, SC_TIME_CODE_BYTES, "%d:%0*.*f", minutes, decimals + 3, decimals,
             fmax(0, rounded_s - 60.0 * minutes));
}
