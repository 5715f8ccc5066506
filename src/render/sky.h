/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to render: the lamp and the sky, which stand to the volume, as everything that sends
 * light from far away. A vector is a direction towards the light: unit, RAS. */
#ifndef SC_RENDER_SKY_H
#define SC_RENDER_SKY_H

#include "segcast/render.h"

/* The direction to the middle of the lamp: before the volume, high up and to its right, as that of
 * the viewer stands who looks at it from before. */
extern const float sc_lamp_direction[3];

/* The direction to the point of the lamp, a disc, that belongs to a point of the unit square, to
 * @p out. */
void sc_lamp_point(const double point[2], double out[3]);

/* Add the radiance of the sky in a direction, by its intensity in @p light, to @p sum. */
static inline void sc_add_sky(const sc_march_light *light, const double d[3], double sum[3])
{
    for (int i = 0; i < 3; i++)
        sum[i] += light->sky * (SC_SKY_MEAN + SC_SKY_UP * d[2]);
}

/* Choose a direction from which much light comes, by a point of the unit square, to @p out. @return
 * its density per solid angle; 0 if none is better than any other. */
double sc_choose_light(const sc_march_light *light, const double point[2], double out[3]);
/* @return the density with which sc_choose_light chooses a direction. */
double sc_light_density(const sc_march_light *light, const double d[3]);
/* Add the radiance of lamp and sky in a direction to @p sum. */
void sc_add_light_from(const sc_march_light *light, const double d[3], double sum[3]);

#endif
