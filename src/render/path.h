/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to render: light by paths, which is what light gathered at vertices is measured by.
 *
 * A path begins at the eye and goes from surface to surface: the very ones that the kernels show,
 * which find them. A surface that lets light through ends a ray by chance, as often as it hides
 * what is behind. At each a ray goes to the lamp, and one on in a direction in which much light
 * comes back; both see lamp and sky, and each counts by how likely it was that it would be chosen
 * (Veach and Guibas 1995). The mean over more and more paths has no error left.
 *
 * Every number by chance is a pure function of frame, pixel, number of the path and use, so that
 * pictures do not depend on who draws which part of them. */
#ifndef SC_RENDER_PATH_H
#define SC_RENDER_PATH_H

#include "tile.h"

/* Make the numbers by which paths are chosen, if there are any: sets r->light.path_numbers. @return
 * SC_ERR_MEMORY. */
sc_status sc_path_numbers_make(const sc_ctx *ctx, sc_renderer *r);
/* @return the bytes of them. */
uint64_t sc_path_numbers_bytes(const sc_renderer *r);
/* Set what paths march through from r->march, of the present view. */
void sc_paths_begin(sc_renderer *r);
/* Follow a path along each ray of a tile that waits, into t->rays.light. */
void sc_tile_trace(sc_tile *t);

/* The share that a face reflects of what comes straight, for a highlight of strength 1: tissue,
 * which is mostly water, reflects 2 to 4 %, and with a soft lamp those are the highlights of
 * light.method: global of 0.15 to 0.3. */
#define SC_FACE_SHARE 0.14
/* The same of a coat, as of glTF: its index of refraction is 1.5; and the width of its facets, for
 * a roughness of 0.1. */
#define SC_COAT_SHARE 0.04
#define SC_COAT_WIDTH 0.01

/* A face of a surface, which is rough (Walter et al. 2007, GGX). */
typedef struct sc_facets {
    double straight, along; /* share of the light that they reflect that comes straight, and along
                               the face; 0: there are none */
    double width;           /* above 0, to 1 */
} sc_facets;

/* How a surface reflects light: diffusely from its body, and by microfacets from its rough face and
 * from the coat above. Directions lead away from the surface, in a frame whose third axis is its
 * normal. */
typedef struct sc_reflector {
    double albedo[3]; /* of what is below the face, 0 to 1 */
    sc_facets face, coat;
    double out[3]; /* the direction of the reflected light; its third component is above 0 */
} sc_reflector;

/* @return the reflector of a tissue that goes towards @p out. @param rgb linear. */
sc_reflector sc_reflector_of(const sc_march_tissue *tissue, const double rgb[3],
                             const double out[3]);
/* What of the radiance that comes from direction @p in goes on, times the cosine, to @p share.
 * @return the density, per solid angle, with which sc_reflector_choose chooses it. */
double sc_reflector_share(const sc_reflector *s, const double in[3], double share[3]);
/* Choose a direction by three numbers from 0 to 1, to @p in; it may lead below the face. */
void sc_reflector_choose(const sc_reflector *s, double which, const double point[2], double in[3]);

#endif
