/* SPDX-License-Identifier: BSD-3-Clause */
/* The grey volume on a slice where it shows no tissue. */
#include "shade.h"

bool sc_kernel_grey(const sc_march *march, const float point[3], float depth_mm, float tone[3])
{
    float rgb[3], here;

    if (!sc_grey_tone(march->cut_faces.grey, point, &here))
        return false;
    for (int i = 0; i < 3; i++)
        rgb[i] = here * here;
    if (march->light.cue > 0)
        sc_depth_cue(&march->light, depth_mm, rgb);
    for (int i = 0; i < 3; i++)
        tone[i] = sqrtf(rgb[i]);
    return true;
}
