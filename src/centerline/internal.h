/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to centerline: the voxels of the tissues, and the ways between them. */
#ifndef SC_CENTERLINE_INTERNAL_H
#define SC_CENTERLINE_INTERNAL_H

#include "segcast/centerline.h"

/* No voxel. */
#define SC_NO_VOXEL UINT32_MAX

/* The voxels of the tissues, numbered in the order in which they lie in memory, within their box
 * with a frame of one voxel that is outside. Owns the arrays; free with sc_region_clear. */
typedef struct sc_region {
    const sc_centerline_request *request; /* borrowed */
    int low[3], size[3];                  /* of the box in voxels, with its frame */
    size_t stride[3];                     /* in the box, from a voxel to the next along each axis */
    double step_mm[3], least_mm;          /* length of a voxel along each axis; the shortest */
    uint32_t count;                       /* of the voxels */
    uint32_t *number; /* [size z][size y][size x]: 1 + number of the voxel; 0: outside */
    uint32_t *place;  /* [count]: index in the box */
    float *depth_mm;  /* [count]: distance to the middle of the nearest voxel outside */
    uint32_t *part;   /* [count]: which piece it belongs to, from 0 */
    uint32_t parts, largest_part;
    int offset[26];       /* to the 26 neighbours, in the box */
    double length_mm[26]; /* how far they are */
} sc_region;

/* Find the voxels, their depths and pieces. @return SC_ERR_DATA if there are none, SC_ERR_SYSTEM if
 * they take too much memory, SC_ERR_MEMORY. Caller owns *out also after an error: sc_region_clear.
 */
sc_status sc_region_make(const sc_ctx *ctx, const sc_centerline_request *request, sc_region *out);
void sc_region_clear(sc_region *region);
/* @return where the middle of a voxel is, RAS mm. */
sc_vec3 sc_region_point(const sc_region *region, uint32_t voxel);
/* @return the voxel in which a point of voxel coordinates lies; SC_NO_VOXEL: outside. */
uint32_t sc_region_voxel(const sc_region *region, sc_vec3 at);
/* @return the depth at a point of voxel coordinates, in mm, between those of the voxels around. */
double sc_region_depth(const sc_region *region, sc_vec3 at);
/* @return the voxel nearest to a point in RAS mm, of one piece or, if @p part is SC_NO_VOXEL, of
 * all. */
uint32_t sc_region_nearest(const sc_region *region, sc_vec3 point_mm, uint32_t part);
/* @return the middle of the tissue near a voxel: of all voxels in sight of it the one whose depth
 * is the greatest after half the distance from there has been taken off, so that one goes to the
 * axis of a vessel, and from its end about a radius inwards, but not along it. */
uint32_t sc_region_middle(const sc_region *region, uint32_t voxel);

/* @return the place of a voxel's tissue in the order of the request. */
int sc_region_order(const sc_region *region, uint32_t voxel);

/* ---- pieces.c ---- */

/* Choose the piece in which the line between its two ends lies: the largest of those that hold a
 * voxel of each number of the order that there is. @return SC_ERR_DATA if there is none, logged;
 * SC_ERR_MEMORY. */
sc_status sc_piece_choose(const sc_ctx *ctx, const sc_region *region, uint32_t *part);

/* A search for cheapest ways: zero-initialise; free with sc_search_clear. */
typedef struct sc_search {
    double *cost;     /* [count]: of the way from the start; HUGE_VAL: not reached */
    uint32_t *from;   /* [count]: the voxel before it on that way */
    uint32_t *heap;   /* [count]: reached voxels whose cost is not final, the least first */
    uint32_t *slot;   /* [count]: where in the heap they are */
    uint32_t waiting; /* how many are in the heap */
} sc_search;
sc_status sc_search_open(const sc_ctx *ctx, const sc_region *region, sc_search *search);
void sc_search_clear(sc_search *search);
/* Find the cheapest ways from @p start to all voxels of its piece, or only until @p end is reached
 * if it is not SC_NO_VOXEL. @param is_short a millimetre costs 1; otherwise it costs the more the
 * nearer to the border it is. @return the voxel that was reached last: @p end, or the farthest. */
uint32_t sc_search_run(sc_search *search, const sc_region *region, uint32_t start, uint32_t end,
                       bool is_short);

#endif
