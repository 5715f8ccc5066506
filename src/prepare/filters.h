/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to prepare: the filters of memberships, from which tables are made, and the records that
 * follow from what they give. All functions are pure, and may be called by any thread. */
#ifndef SC_PREPARE_FILTERS_H
#define SC_PREPARE_FILTERS_H

#include "internal.h"

/* One value for each of the four vertices of a brick along x. */
typedef float sc_quad __attribute__((vector_size(16)));

enum { SC_WEIGHT_LEAST = 3 }; /* of SC_WEIGHT_MAX: a label owns all its voxels' centres */

/* Tissue counts as thin where the gradient, as a share of that at a flat interface, is weaker than
 * THIN_FROM. A narrower filter is blended in from there, and replaces the wide one at THIN_ALL. */
#define SC_THIN_FROM 0.45f
#define SC_THIN_ALL 0.30f
/* Vertices of tissue beside the background take over its gradient where its border is flat: partly
 * where the gradient is longer than FLAT_FROM, and fully from FLAT_ALL on, as a share of its length
 * beside a plane that leaves as much background around. In a narrow gap between tissues, where the
 * surface has an edge, or where two tissues meet in a sharp valley, it is shorter. */
#define SC_FLAT_FROM 0.92f
#define SC_FLAT_ALL 0.97f
/* What is left of the length of a gradient that should hardly count at the surface. With less,
 * light is uneven at the bottom of valleys. */
#define SC_SEAM_LENGTH 0.3f
/* Standard deviations of the filter for normals, and of that where tissue is thin, in reference
 * voxels. */
#define SC_NORMAL_WIDTH 2.35
#define SC_NARROW_WIDTH 1.5

/* Write the length of a voxel along each axis in reference voxels, cubes of the same volume, to @p
 * steps. With it the smoothing is isotropic in millimetres. The lengths are limited, because along
 * a coarse axis the filter must still reach the next voxels, and along a fine one little of it may
 * lie outside the window. */
void sc_filter_steps(const sc_volume *v, double steps[3]);

/* The filter for weights of one strength. */
typedef struct sc_weight_filter {
    double steps[3]; /* lengths of a voxel, stretched along axes that are smoothed less */
    double strength; /* by which all lengths of the filter are multiplied: that of the axis which is
                        smoothed most */
    int dimensions;  /* axes along which anything is smoothed at all, 0 to 3 */
} sc_weight_filter;
/* @return the filter. @param steps of sc_filter_steps. @param strength along each axis; along one
 * that is too weak to reach the next voxel, nothing is smoothed. */
sc_weight_filter sc_weight_filter_of(const double steps[3], sc_vec3 strength);
/* @return the value of the filter, not normalised, at the sum of the squares of the three distances
 * along the axes, each in voxels times steps of @p f; 0 beyond its reach. */
double sc_weight_filter_at(const sc_weight_filter *f, double square);

/* Filters have a table for all rows of vertices that are equally far from the middle. @return the
 * index of the table for the squared distance @p square, which is appended to @p squares [*count]
 * if it is new; the caller has room for it. */
int sc_filter_table_of(double *squares, int *count, double square);

/* Write the taps of a Gaussian along one axis, of sum 1, and those of its derivative, with which an
 * interface across the axis has a gradient of 1. The Gaussian is lowered so that it ends at zero.
 * @param radius in vertices. @param step of sc_filter_steps for the axis. @param width standard
 * deviation in reference voxels. @param value, slope [2 * radius + 1]. */
void sc_normal_taps(int radius, double step, double width, float *value, float *slope);

/* Beyond the border of the volume filters see copies of the last voxels, as if all went straight on
 * there; so a surface that meets the border at an angle would be lit as if it bent towards it. Here
 * it is taken to go on as it does inside: multiply the gradient of a vertex along each axis, in
 * place, by what the copies keep from it where memberships rise evenly; only within a voxel of the
 * last one, and where two labels meet in the last layer around: a surface that only runs beside the
 * border stays as it is.
 * @param voxel of the vertex, -1 to the size along each axis. @param slope taps of sc_normal_taps
 * along each axis, [2 * radius + 1]. */
void sc_gradient_at_border(const sc_volume *v, const int voxel[3], int radius,
                           const float *const slope[3], float gradient[3]);
/* @return whether filters of a radius reach beyond the border of the volume from a brick. @param
 * low its lowest grid vertex. */
bool sc_is_by_border(const sc_volume *v, const int low[3], int radius);

/* Write the map from gradients per reference voxel along the axes of the grid to RAS, for
 * sc_field_record, to @p to_mm. @param steps of sc_filter_steps. */
void sc_gradient_to_mm(const sc_volume *v, const double steps[3], double to_mm[3][3]);
/* @return the vertex record of a weight and an outward gradient. A gradient of no length gets the
 * direction z and the least strength. */
uint32_t sc_field_record(const double to_mm[3][3], int weight, const float outward[3]);

/* @return the Euclidean length. */
static inline float sc_gradient_length(const float v[3])
{
    return sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/* @return how flat the surface is at a vertex of tissue beside the background, 0 to 1: the share in
 * which the gradient of the background there tells the normal of the surface. Near another tissue
 * the gradient of the vertex's own label tells about both borders, and leans.
 * @param background its gradient. @param membership of the background at the vertex, smoothed by
 * the same Gaussian. */
static inline float sc_flat_share(const float background[3], float membership)
{
    /* Beside a plane a smoothed membership m has a gradient that falls off with 4 m (1 - m); this
     * polynomial is right to 1 % from m = 0.15 on. */
    const float even = 4 * membership * (1 - membership), odd = 1 - even;
    const float flat = even * (1 + 0.188f * odd + 0.22f * odd * odd);
    const float share = (sc_gradient_length(background) - SC_FLAT_FROM * flat) /
                        ((SC_FLAT_ALL - SC_FLAT_FROM) * flat + 1e-6f);

    return share > 0 ? share < 1 ? share : 1 : 0;
}

/* Mend the gradient @p own of a vertex of tissue beside the background, outward from its label, in
 * place. If no other tissue is beside it, it takes over that of the background, reversed. Else it
 * is needed for the border between the tissues, and is shortened, so that it hardly counts at the
 * surface. Both in the share of sc_flat_share. @param background outward from the background. */
static inline void sc_mend_beside_background(const float background[3], float membership,
                                             bool at_seam, float own[3])
{
    const float share = sc_flat_share(background, membership);

    for (int i = 0; i < 3; i++)
        own[i] = at_seam ? own[i] * (1 - share * (1 - SC_SEAM_LENGTH))
                         : own[i] + share * (-background[i] - own[i]);
}

/* @return in which share a narrower filter replaces one that gives a gradient of this length. */
static inline float sc_thin_share(float length)
{
    const float share = (SC_THIN_FROM - length) / (SC_THIN_FROM - SC_THIN_ALL);

    return share < 0 ? 0 : share < 1 ? share : 1;
}

#endif
