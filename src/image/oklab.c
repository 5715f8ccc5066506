/* SPDX-License-Identifier: BSD-3-Clause */
/* Colours as the eye sees them: coordinates in which equal distances look about equally large
 * (B. Ottosson 2020, "A perceptual color space for image processing", OKLab), with full colour
 * vision and with each of the three dichromacies (Machado, Oliveira and Fernandes 2009, "A
 * physiologically-based model for simulation of color vision deficiency", table 1, severity 1). */
#include "segcast/image.h"

#include <math.h>

/* From the linear light of sRGB to what an eye of each kind takes it for, linear again. */
static const double seen[SC_VISION_COUNT][3][3] = {
    [SC_VISION_FULL] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
    [SC_VISION_PROTANOPIA] = {{0.152286, 1.052583, -0.204868},
                              {0.114503, 0.786281, 0.099216},
                              {-0.003882, -0.048116, 1.051998}},
    [SC_VISION_DEUTERANOPIA] = {{0.367322, 0.860646, -0.227968},
                                {0.280085, 0.672501, 0.047413},
                                {-0.011820, 0.042940, 0.968881}},
    [SC_VISION_TRITANOPIA] = {{1.255528, -0.076749, -0.178779},
                              {-0.078411, 0.930809, 0.147602},
                              {0.004733, 0.691367, 0.303900}},
};

/* From linear light to the responses of the cones, and from their cube roots to OKLab. */
static const double to_cones[3][3] = {{0.4122214708, 0.5363325363, 0.0514459929},
                                      {0.2119034982, 0.6806995451, 0.1073969566},
                                      {0.0883024619, 0.2817188376, 0.6299787005}};
static const double to_lab[3][3] = {{0.2104542553, 0.7936177850, -0.0040720468},
                                    {1.9779984951, -2.4285922050, 0.4505937099},
                                    {0.0259040371, 0.7827717662, -0.8086757660}};

/* Multiply a matrix with a vector; @p out must be another one. */
static void multiply(const double m[3][3], const double v[3], double out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
}

void sc_oklab(const uint8_t rgb[3], sc_vision vision, double lab[3])
{
    double light[3], looks[3], cones[3];

    for (int i = 0; i < 3; i++)
        light[i] = sc_srgb_to_linear(rgb[i] / 255.0);
    multiply(seen[vision], light, looks);
    for (int i = 0; i < 3; i++) /* what the screen cannot show is the nearest that it can */
        looks[i] = fmin(fmax(looks[i], 0), 1);
    multiply(to_cones, looks, cones);
    for (int i = 0; i < 3; i++)
        cones[i] = cbrt(cones[i]);
    multiply(to_lab, cones, lab);
}

sc_seen_color sc_see_color(const uint8_t rgb[3])
{
    sc_seen_color out;

    for (int vision = 0; vision < SC_VISION_COUNT; vision++)
        sc_oklab(rgb, (sc_vision)vision, out.lab[vision]);
    return out;
}

double sc_color_distance(const sc_seen_color *a, const sc_seen_color *b, sc_vision vision)
{
    double squares = 0;

    for (int i = 0; i < 3; i++) {
        const double step = a->lab[vision][i] - b->lab[vision][i];

        squares += step * step;
    }
    return sqrt(squares);
}

double sc_color_contrast(const sc_seen_color *a, const sc_seen_color *b)
{
    double least = sc_color_distance(a, b, SC_VISION_FULL);

    for (int vision = SC_VISION_FULL + 1; vision < SC_VISION_COUNT; vision++)
        least = fmin(least, 1.5 * sc_color_distance(a, b, (sc_vision)vision));
    return least;
}
