/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to timeline: a view that holds everything throughout an orbit. */
#ifndef SC_TIMELINE_FRAMING_H
#define SC_TIMELINE_FRAMING_H

#include "segcast/timeline.h"

/* Extent of the points along a unit direction. */
void sc_extent(const sc_vec3 *points, size_t count, sc_vec3 direction, double *low, double *high);
/* Fill target, distance and half_height where the orbit leaves them open. */
void sc_frame_orbit(sc_orbit *orbit, const sc_vec3 *points, size_t count, double aspect,
                    double *half_height);
/* Direction from the target to the camera at angle 0, perpendicular to the axis: from the front
 * where that is possible, else from above. */
sc_vec3 sc_orbit_reference(sc_vec3 axis);

#endif
