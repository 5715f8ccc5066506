/* SPDX-License-Identifier: BSD-3-Clause */
#include "segcast/volume.h"

/* The mixing step of splitmix64 (Steele, Lea and Flood 2014, "Fast splittable pseudorandom number
 * generators"): every bit of the result depends on every bit of @p x. */
static uint64_t mix(uint64_t x)
{
    x ^= x >> 30;
    x *= 0xbf58476d1ce4e5b9u;
    x ^= x >> 27;
    x *= 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

/* One channel of a colour given as hue in [0, 1536), saturation and value in [0, 255], with
 * integers only, so that the colours are the same everywhere. The red, green and blue channels are
 * the same curve over the hue, shifted by @p offset. */
static uint8_t channel(int hue, int offset, int saturation, int value)
{
    const int h = (hue + offset) % 1536;
    int ramp = 255;

    if (h < 256)
        ramp = h;
    else if (h >= 768 && h < 1024)
        ramp = 1023 - h;
    else if (h >= 1024)
        ramp = 0;
    return (uint8_t)(value * (255 * 255 - saturation * (255 - ramp)) / (255 * 255));
}

void sc_label_hash_color(int64_t value, uint8_t rgb[3])
{
    const uint64_t bits = mix((uint64_t)value + 0x9e3779b97f4a7c15u);
    const int hue = (int)(bits % 1536);
    const int saturation = 120 + (int)((bits >> 16) % 96);
    const int brightness = 170 + (int)((bits >> 32) % 80);

    rgb[0] = channel(hue, 512, saturation, brightness);
    rgb[1] = channel(hue, 0, saturation, brightness);
    rgb[2] = channel(hue, 1024, saturation, brightness);
}
