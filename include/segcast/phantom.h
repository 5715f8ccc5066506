/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  The phantom: a synthetic heart of closed analytic shapes in patient space (RAS+ mm), turned as
 * in a chest: apex to the left, front and below. */
#ifndef SEGCAST_PHANTOM_H
#define SEGCAST_PHANTOM_H

#include "segcast/grey.h"

/** The shapes and labels of the heart. */
typedef struct sc_phantom sc_phantom;

/** Default size of the phantom volume, in voxels along x, y, z. */
enum { SC_PHANTOM_WIDTH = 469, SC_PHANTOM_DEPTH = 325, SC_PHANTOM_HEIGHT = 487 };

/** Build the shapes. Immutable afterwards: any thread. @return SC_ERR_MEMORY. Caller owns *out:
 *  sc_phantom_free. */
SC_MUST_USE sc_status sc_phantom_new(const sc_ctx *ctx, sc_phantom **out);
/** The same at a moment of its beat: walls and chambers move by an analytic rule. The wall of the
 *  left ventricle keeps its volume to about a tenth while the chamber ejects 60 %; the atria fill
 *  as the planes of their valves descend.
 *  @param phase 0 at the end of diastole, where the heart is that of sc_phantom_new, to 1, where
 *  the next beat begins; any finite number. */
SC_MUST_USE sc_status sc_phantom_new_beating(const sc_ctx *ctx, double phase, sc_phantom **out);
/** Free the phantom; NULL is allowed. */
void sc_phantom_free(sc_phantom *phantom);
SC_CLOSE_AT(sc_phantom_free, sc_phantom)

/** @return the number of tissues; labels are 1 to this number. Where shapes overlap, the tissue
 *  with the lower label owns the points. */
int sc_phantom_tissue_count(const sc_phantom *phantom);
/** @return name, colour and label value of tissue @p label in [1, count], borrowed from the
 *  phantom. */
const sc_label *sc_phantom_label(const sc_phantom *phantom, int label);
/** Find the course of tube @p tube, from 0, of what tissue @p label, in [1, count], fills: the
 *  middle line of a vessel. Where tissues overlap, or tubes of one tissue meet, the surface is not
 *  that of the tube alone.
 *  @param points [*count] in RAS mm, borrowed from the phantom, joined by straight lines.
 *  @param radius_mm at the first and the last point; it changes evenly from point to point.
 *  @return false, with nothing written, if the tissue has no such tube. */
bool sc_phantom_tube(const sc_phantom *phantom, int label, int tube, const sc_vec3 **points,
                     int *count, double radius_mm[2]);

/** Voxelise: a voxel belongs to the tissue that owns its centre. The grid covers the same part
 *  of space at any size (voxels are 1/3 mm at the default size). @param size voxels along x, y,
 *  z, each 2 to 4096. @param threads as of sc_parallel_for. @return SC_ERR_USAGE for another
 *  size, SC_ERR_MEMORY. Caller owns *out: sc_volume_clear. */
SC_MUST_USE sc_status sc_phantom_volume(const sc_ctx *ctx, const sc_phantom *phantom,
                                        const int size[3], int threads, sc_volume *out);

/** Make a synthetic CT image of the heart: Hounsfield units as with contrast agent in the left
 *  heart, with noise; the same on every machine. @param grey its size is set, and its codes are
 *  allocated for it (sc_grey_bytes); gets the geometry of sc_phantom_volume, low and per_code.
 *  @param threads as of sc_parallel_for. @return SC_ERR_USAGE for a size that sc_phantom_volume
 *  refuses, SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_phantom_grey(const sc_ctx *ctx, const sc_phantom *phantom, int threads,
                                      sc_grey *grey);
/** The map from voxels to RAS mm of a phantom volume of a size. */
sc_affine sc_phantom_geometry(const int size[3]);

/** The labels of a phantom volume of @p size and where they lie, without making it: from a grid
 *  of at most 64 voxels along each axis, so that the bounding boxes are exact only to a voxel of
 *  that grid and the numbers of voxels are estimates. Size, threads and errors as of
 *  sc_phantom_volume. Caller owns *out, which has tallies: sc_volume_clear. */
SC_MUST_USE sc_status sc_phantom_scan_labels(const sc_ctx *ctx, const sc_phantom *phantom,
                                             const int size[3], int threads, sc_volume *out);

#endif
