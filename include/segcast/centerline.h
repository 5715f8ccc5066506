/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Centre lines of vessels and chambers: the way through the middle of tissues, from the distance
 *  of their voxels to the border. One thread does the work, and the result depends on the voxels
 *  and the request alone, so that it is the same bits wherever it is found. */
#ifndef SEGCAST_CENTERLINE_H
#define SEGCAST_CENTERLINE_H

#include "segcast/volume.h"

/** What share of the radius a smoothed centre line keeps from the border, unless the user says
 *  otherwise. A macro, so that documents can quote it. */
#define SC_CLEARANCE 0.5

/** A point of a centre line. */
typedef struct sc_centerline_point {
    sc_vec3 at_mm;    /**< RAS */
    double radius_mm; /**< of a ball around it that reaches the middle of the nearest voxel outside,
                           from the distances at the voxels around: on the phantom 0.3 to 0.5
                           voxels less than the true radius */
} sc_centerline_point;

/** A centre line. Zero-initialise; sc_centerline_clear frees. */
typedef struct sc_centerline {
    sc_centerline_point *points; /**< [count], evenly spaced along the line; owned */
    size_t count;                /**< at least 2 */
    double length_mm;            /**< along the line */
    bool ends_at_wall;           /**< straight on from its end the tissues end within two radii */
    int parts; /**< how many pieces that do not touch the tissues are in; the line lies in one */
} sc_centerline;

/** What is asked for. Borrows everything. */
typedef struct sc_centerline_request {
    const sc_volume *volume;
    const int *order; /**< [label_count] by dense id: 0 for labels that the line must not enter;
                           for all others 1 or more: where there are no points, the line begins in
                           the tissue with the lower number, and within one at its upper end */
    const sc_vec3 *through; /**< [through_count] points in RAS mm, each within the tissues: the line
                                 leads from the first through all others to the last. With one, it
                                 ends at the place farthest from there; with none, it connects the
                                 two ends that are farthest from each other of the largest piece
                                 that has a voxel of each number of the order */
    size_t through_count;
    double clearance; /**< 0 to 1: a line that is smoothed keeps this share of the distance from the
                           border that it has in the middle of the tissue */
    const char *const *names; /**< [greatest of the order] the tissues of each number of it, for
                                   messages; NULL: they are not named one by one */
    const char *what;         /**< the tissues, for messages, such as "aorta" in quotes */
    const char *where;        /**< "file:line" for messages; may be empty */
} sc_centerline_request;

/** Find a centre line. It begins and ends where a ball fits into the tissue, so about a radius
 *  before the end of a vessel, also if points are given: these are moved to the middle of the
 *  tissue around them.
 *
 *  The distance of each voxel to the border is exact (sc_distance_pass; it takes the axes of the
 *  volume to be perpendicular). The ends are farthest from each other along ways within the tissue.
 *  Between them the line is the cheapest way from voxel to voxel (Dijkstra 1959), a millimetre
 *  costing the inverse cube of the distance to the border, as for the minimal paths of Deschamps
 *  and Cohen 2001, "Fast extraction of minimal paths in 3D images and applications to virtual
 *  endoscopy". It is smoothed by a moving average over a third of the radius to both sides, twice.
 *  @param out caller owns: sc_centerline_clear. @return SC_ERR_DATA, logged: the volume has no
 *  voxel of these tissues, a point lies outside of them, there is no way between two points, or
 *  without points between two numbers of the order (with where the tissue ends), or the line is
 *  shorter than a voxel; SC_ERR_SYSTEM if it takes more than ctx->memory_max_bytes; SC_ERR_MEMORY.
 *  Any thread. */
SC_MUST_USE sc_status sc_centerline_find(const sc_ctx *ctx, const sc_centerline_request *request,
                                         sc_centerline *out);
/** Find the middle of tissues: of the places where they are thickest, with at least 0.9 of the
 *  greatest distance to their border, the one nearest to their center of mass. Of the request only
 * the volume, its order and the texts for messages are used.
 *  @param out RAS mm. @return SC_ERR_DATA, logged: the volume has no voxel of these tissues;
 *  SC_ERR_SYSTEM and SC_ERR_MEMORY as of sc_centerline_find. Any thread. */
SC_MUST_USE sc_status sc_centerline_middle(const sc_ctx *ctx, const sc_centerline_request *request,
                                           sc_vec3 *out);
/** Free the points and set the line to zero. A zeroed line is allowed. */
void sc_centerline_clear(sc_centerline *line);

#endif
