/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to render: lamp and sky, which stand to the volume and send light from far away. A vector
 * is a direction towards the light: unit, RAS. */
#ifndef SC_RENDER_SKY_H
#define SC_RENDER_SKY_H

#include "segcast/render.h"

/* The lamp of a view: a rectangle, or a disc. It is part of the name of kept light, byte by byte.
 */
typedef struct sc_lamp_frame {
    double middle[3], right[3], up[3]; /* directions, RAS; right and up of a rectangle only */
    double half[2];                    /* of its width and height, as tangents; 0: it is a disc */
    double turn, tilt;                 /* for points of a rectangle: see sc_lamp_point */
    double density;     /* probability density of such points' directions, per steradian */
    double mean_cosine; /* between the middle and the directions to all points: so much of what
                           would come to a surface from its middle alone comes from all of it */
} sc_lamp_frame;

enum { SC_SKY_COLUMNS = 64, SC_SKY_ROWS = 32 };
/* A picture of all directions in place of the sky. As much light comes from all of it together as
 * from the sky. Without a picture map is NULL, and nothing else is set. */
typedef struct sc_sky {
    sc_lamp_frame lamp;     /* of the present view, by sc_lamp_place; the rest is of all of them */
    const sc_panorama *map; /* borrowed */
    float gain;             /* what its pixels are multiplied by */
    double turn;            /* part of a turn by which it is turned to the right of the body */
    float *rows;            /* [height + 1] light of the rows above each, from 0 to 1; owned */
    float *columns;         /* [height][width + 1] the same in each row; owned */
    float coarse[SC_SKY_ROWS][SC_SKY_COLUMNS][3]; /* the picture, blurred */
    float around[3][4]; /* the light of all of it on a surface, by component: the mean, and what is
                           multiplied by the normal */
} sc_sky;

/* Make the sky of a picture. @param map NULL: there is none. @param turn_deg by which it is turned.
 * @return SC_ERR_MEMORY. Caller owns *out: sc_sky_clear. */
sc_status sc_sky_init(const sc_ctx *ctx, const sc_panorama *map, double turn_deg, sc_sky *out);
void sc_sky_clear(sc_sky *sky);
/* @return the bytes that it has allocated. */
uint64_t sc_sky_bytes(const sc_sky *sky);

/* Place the lamp for a view. */
void sc_lamp_place(sc_sky *sky, const sc_lamp *lamp, const sc_camera *camera);
/* The direction to the point of the lamp that belongs to a point of the unit square, to @p out. */
void sc_lamp_point(const sc_lamp_frame *lamp, const double point[2], double out[3]);
/* The radiance of the sky of intensity 1 in a direction, to @p out: blurred, for few rays that
 * stand for many. */
void sc_sky_blurred(const sc_sky *sky, const float d[3], float out[3]);
/* Add the radiance of lamp and sky in a direction, by their intensities in @p light, to @p sum. */
void sc_add_light_from(const sc_sky *sky, const sc_march_light *light, const double d[3],
                       double sum[3]);
/* Choose a direction from which much light comes, by a number from 0 to 1 and a point of the unit
 * square, to @p out. @return its density per solid angle; 0 if none is better than any other. */
double sc_choose_light(const sc_sky *sky, const sc_march_light *light, double which,
                       const double point[2], double out[3]);
/* @return the density with which sc_choose_light chooses a direction. */
double sc_light_density(const sc_sky *sky, const sc_march_light *light, const double d[3]);

#endif
