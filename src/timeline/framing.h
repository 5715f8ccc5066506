/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to timeline: framing, which places the camera so that the visible tissues stay in the
 * picture throughout an orbit and fill it. */
#ifndef SC_TIMELINE_FRAMING_H
#define SC_TIMELINE_FRAMING_H

#include "motion.h"

/* Write the extent of the points along a unit direction, in mm from the origin, to *low and *high;
 * -0.5 and 0.5 if there are none. */
void sc_extent(const sc_vec3 *points, size_t count, sc_vec3 direction, double *low, double *high);
/* Set target_mm and distance_mm of an orbit where they are left open, so that every point stays in
 * the picture, and *half_height (see sc_camera). A still camera is left as it is. The distance of
 * an orthographic camera, which does not change the picture, is always set, to one outside of the
 * tissues; a given one determines *half_height. @param sights [sight_count] the directions of view
 * in which the points are to stay in the picture (sc_sights_of). @param aspect width of the picture
 * divided by its height. */
void sc_frame_orbit(sc_orbit *orbit, const sc_sight *sights, int sight_count, const sc_vec3 *points,
                    size_t count, double aspect, double *half_height);
/* @return sc_camera.half_height, with a margin of 5 %, of a perspective picture that holds all
 * points in all sights, seen from @p distance_mm off @p target_mm. They all lie before the camera.
 */
double sc_fit_height(const sc_sight *sights, int sight_count, sc_vec3 target_mm, double distance_mm,
                     const sc_vec3 *points, size_t count, double aspect);

#endif
