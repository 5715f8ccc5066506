/* SPDX-License-Identifier: BSD-3-Clause */
/* The lamp and the sky. */
#include "sky.h"

#include "directions.h"

#define PI 3.14159265358979323846
/* The radius of the lamp, as a tangent: as a window of two metres seen from three. */
#define LAMP_RADIUS 0.3

const float sc_lamp_direction[3] = {0.52F, 0.48F, 0.70655F};

void sc_lamp_point(const double point[2], double out[3])
{
    double n[3], t[3], b[3], disc[3], length = 0;

    for (int k = 0; k < 3; k++)
        n[k] = sc_lamp_direction[k];
    sc_frame_about(n, t, b);
    sc_cosine_direction(point, disc); /* whose shadow on the disc is even */
    for (int k = 0; k < 3; k++) {
        out[k] = n[k] + LAMP_RADIUS * (disc[0] * t[k] + disc[1] * b[k]);
        length += out[k] * out[k];
    }
    for (int k = 0; k < 3; k++)
        out[k] /= sqrt(length);
}

/* The density per solid angle of the directions of sc_lamp_point: even on the disc, which is seen
 * the smaller the farther from its middle. */
static double lamp_density(const double d[3])
{
    double cosine = 0, square = 0;

    for (int k = 0; k < 3; k++) {
        cosine += d[k] * sc_lamp_direction[k];
        square += (double)sc_lamp_direction[k] * sc_lamp_direction[k];
    }
    cosine /= sqrt(square);
    if (!(cosine > 0) || 1 / (cosine * cosine) - 1 > LAMP_RADIUS * LAMP_RADIUS)
        return 0;
    return 1 / (PI * LAMP_RADIUS * LAMP_RADIUS * cosine * cosine * cosine);
}

double sc_choose_light(const sc_march_light *light, const double point[2], double out[3])
{
    if (!(light->lamp > 0))
        return 0;
    sc_lamp_point(point, out);
    return sc_light_density(light, out);
}

double sc_light_density(const sc_march_light *light, const double d[3])
{
    return light->lamp > 0 ? lamp_density(d) : 0;
}

void sc_add_light_from(const sc_march_light *light, const double d[3], double sum[3])
{
    /* The lamp brings a surface that faces it as much as white gives back. */
    const double lamp = light->lamp > 0 ? PI * light->lamp * lamp_density(d) : 0;

    sc_add_sky(light, d, sum);
    for (int i = 0; i < 3; i++)
        sum[i] += lamp;
}
