/* SPDX-License-Identifier: BSD-3-Clause */
/* The colour behind the tissues, and whether text over it is dark. */
#include "motion.h"

#include "segcast/image.h"

#include <stdlib.h>

void sc_find_background(const sc_background *background, double at, uint8_t rgb[3])
{
    sc_srgb_table table;
    sc_track tones;
    float linear[3];

    memcpy(rgb, background->rgb, sizeof background->rgb);
    if (!background->track.count)
        return;
    sc_srgb_table_init(&table);
    sc_track_tones(&background->track, &tones);
    sc_track_color(&tones, at, linear);
    for (int i = 0; i < 3; i++)
        rgb[i] = sc_srgb_level(&table, linear[i]);
}

/* @return whether a background is so light that text on it should be dark. */
static bool is_light(const uint8_t rgb[3])
{
    return 2 * rgb[0] + 5 * rgb[1] + rgb[2] > 8 * 110; /* luma of about 110 of 255 */
}

/* @return whether a background jumps from one colour to another: too far for a film in which the
 * colour changes by degrees. */
static bool jumps(const uint8_t a[3], const uint8_t b[3])
{
    enum { FAR = 48 };
    bool far = false;

    for (int i = 0; i < 3; i++)
        far = far || abs(a[i] - b[i]) > FAR;
    return far;
}

/* @return in how many of the @p reach frames before frame @p k, or behind it, the background is
 * light: where it jumps, or the film ends, it counts as if it stayed as it was. @param step -1
 * or 1. */
static int count_light(const sc_background *background, int k, int frames, int step, int reach)
{
    uint8_t last[3], next[3];
    bool ends = false;
    int count = 0;

    sc_find_background(background, sc_frame_time(k, frames), last);
    for (int i = 1; i <= reach; i++) {
        const int at = k + step * i;

        ends = ends || at < 0 || at >= frames;
        if (!ends) {
            sc_find_background(background, sc_frame_time(at, frames), next);
            ends = jumps(last, next);
        }
        if (!ends)
            memcpy(last, next, sizeof last);
        count += is_light(last);
    }
    return count;
}

double sc_find_dark_text(const sc_timeline *t, int k)
{
    const sc_background *background = t->looks.background;
    const int frames = t->animation.frames;
    const int reach = t->looks.fps > 4 ? t->looks.fps / 4 : 1; /* frames before and behind this */
    uint8_t own[3];
    int light;

    sc_find_background(background, sc_frame_time(k, frames), own);
    light = is_light(own);
    if (!background->track.count)
        return light;
    light += count_light(background, k, frames, -1, reach);
    light += count_light(background, k, frames, 1, reach);
    return (double)light / (2 * reach + 1);
}
