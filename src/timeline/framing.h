/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to timeline: framing, which places the camera so that the visible tissues stay in the
 * picture throughout an orbit and fill it. */
#ifndef SC_TIMELINE_FRAMING_H
#define SC_TIMELINE_FRAMING_H

#include "segcast/timeline.h"

/* The extent of the points along a unit direction; from -0.5 to 0.5 if there are none. */
void sc_extent(const sc_vec3 *points, size_t count, sc_vec3 direction, double *low, double *high);
/* Fill in the target and the distance of an orbit where they are left open, and half_height (see
 * sc_camera). */
void sc_frame_orbit(sc_orbit *orbit, const sc_vec3 *points, size_t count, double aspect,
                    double *half_height);
/* The direction from the target to the camera at angle 0, perpendicular to the axis: to the front
 * of the patient, or above where the axis itself points nearly that way. */
sc_vec3 sc_orbit_reference(sc_vec3 axis);

#endif
