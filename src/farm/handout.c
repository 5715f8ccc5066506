/* SPDX-License-Identifier: BSD-3-Clause */
#include "segcast/farm.h"

int sc_handout_next(sc_handout *handout)
{
    if (handout->stopped || handout->next == handout->total)
        return SC_HANDOUT_END;
    if (handout->next >= handout->taken + handout->window)
        return SC_HANDOUT_WAIT;
    handout->out++;
    return handout->next++;
}

void sc_handout_back(sc_handout *handout)
{
    handout->out--;
}

bool sc_handout_finished(const sc_handout *handout)
{
    return handout->out == 0 && (handout->stopped || handout->next == handout->total);
}

int sc_handout_window(int ranks, size_t frame_bytes)
{
    const size_t memory_bytes = (size_t)128 << 20;
    const size_t affordable = memory_bytes / (frame_bytes ? frame_bytes : 1);
    int window = 3 * ranks + 1; /* one in work and one waiting per rank, and some slack */

    if ((size_t)window > affordable)
        window = (int)affordable;
    return window < 2 ? 2 : window;
}
