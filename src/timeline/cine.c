/* SPDX-License-Identifier: BSD-3-Clause */
/* Which phase of a beat a frame shows. */
#include "segcast/timeline.h"

int sc_cine_phase(const sc_cine *cine, int phases, int fps, int k)
{
    /* Phases that have passed. Both products are of whole numbers for usual rates, and the quotient
     * is rounded correctly by IEEE 754, so that any machine finds the same phase. What is added
     * keeps a frame that lies on the beginning of a phase from falling into the one before for a
     * rate that is no binary fraction. */
    const double passed = floor((double)k * cine->bpm * phases / (60.0 * fps) + 1e-9);

    if (cine->beats && passed >= (double)cine->beats * phases - 1 - cine->between)
        return phases - 1 - cine->between;
    return (int)fmod(passed, phases);
}
