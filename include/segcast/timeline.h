/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  The animation: which scene each frame shows. A scene is a closed function of the frame's number
 *  and depends on no other frame, so that frames can be drawn in any order and by any rank. All
 *  functions are pure and may be called by any thread; none can fail. */
#ifndef SEGCAST_TIMELINE_H
#define SEGCAST_TIMELINE_H

#include "segcast/scene.h"

/** How a value moves from its begin to its end: evenly, or starting or ending slowly. */
typedef enum sc_ease { SC_EASE_LINEAR, SC_EASE_SMOOTH, SC_EASE_IN, SC_EASE_OUT } sc_ease;

/** Where a clip plane lies along its normal. */
typedef struct sc_plane_position {
    double value;
    bool percent; /**< true: the value is a share, in percent, of the way through the visible
                       tissues; false: mm along the normal from the origin of RAS space */
} sc_plane_position;

/** A value that changes from one to another during a part of the animation, and stays constant
 *  before and after. */
typedef struct sc_ramp {
    double from, to;
    double begin, end; /**< the part: 0 is the first frame of the animation and 1 the last */
    sc_ease ease;
} sc_ramp;

/** The way of the camera: an orbit about an axis, or a still camera. */
typedef struct sc_orbit {
    bool fixed;           /**< a still camera at position_mm, which looks at target_mm */
    sc_vec3 axis;         /**< unit; points upwards in the picture */
    double turns;         /**< during the whole animation */
    double elevation_deg; /**< of the camera above the plane of the orbit */
    double start_deg; /**< where the orbit begins; 0 is in front of the patient, where possible */
    bool has_target, has_distance; /**< false: follows from the framing */
    sc_vec3 position_mm, up;       /**< of a still camera */
    sc_vec3 target_mm;
    double distance_mm; /**< from the target to the camera of an orbit */
    double fov_deg;     /**< vertical */
    sc_projection projection;
    sc_ramp zoom; /**< scales the picture; 1: as framed */
} sc_orbit;

/** A clip plane that moves along its normal. */
typedef struct sc_sweep {
    sc_vec3 normal; /**< unit, towards what is kept */
    sc_plane_position from, to;
    double begin, end; /**< as of sc_ramp */
    sc_ease ease;
} sc_sweep;

/** The point in which the slices of the three regular views meet. */
typedef struct sc_slices {
    bool has_point;
    sc_vec3 point_mm; /**< where it stays, if has_point */
    sc_ramp share;    /**< otherwise it moves along the diagonal of the box of the visible tissues:
                           0 is the right, posterior, inferior corner, 1 the opposite one */
} sc_slices;

/** An animation as the job asks for it. */
typedef struct sc_animation {
    int frames;
    sc_orbit camera;
    sc_sweep sweeps[SC_PLANES_MAX];
    int sweep_count;
    sc_clip_mode clip_mode;
    sc_slices slices;
} sc_animation;

/** An animation in which all that depends on the volume is filled in: the framing of the camera and
 *  the positions of the planes in mm. */
typedef struct sc_timeline {
    sc_animation animation;
    double from_mm[SC_PLANES_MAX], to_mm[SC_PLANES_MAX]; /**< plane positions along the normals */
    double half_height;                                  /**< as of sc_camera, before the zoom */
    uint32_t clip_sets[SC_CLIP_SETS_MAX];
    int clip_set_count;
    sc_vec3 low_mm, high_mm; /**< bounding box of the visible tissues, RAS */
} sc_timeline;

/** Fill in what an animation leaves open, from the extent of the visible tissues. One framing holds
 *  for the whole orbit, and for the tissues as they are without clip planes, so that the scale of
 *  the picture stays the same. All tissues share clip set 0, which holds all planes.
 *  @param points among which are the corners of the visible tissues (sc_hull_points); with none, a
 *  box of 1 mm at the origin is framed. @param aspect width by height of the picture. */
void sc_timeline_resolve(const sc_animation *animation, const sc_vec3 *points, size_t point_count,
                         double aspect, sc_timeline *out);
/** @return the scene of frame @p k in [0, frames). An orbit of one turn in N frames stands at
 *  360 k / N degrees, so that no direction comes twice when the video loops. Ramps reach their end
 *  in the last frame. */
sc_scene sc_timeline_scene(const sc_timeline *timeline, int k);

/** @return the point in which the slices of frame @p k meet, RAS. */
sc_vec3 sc_timeline_point(const sc_timeline *timeline, int k);

/** @param u how much of the time has passed, 0 to 1. @return how much of the way is done, 0 to 1.
 */
double sc_ease_value(sc_ease ease, double u);
/** Find the direction, in RAS, that an anatomical word stands for ("left", "superior", ...), case
 *  ignored. @return false if it is no such word; @p out is not written then. */
bool sc_anatomical_direction(const char *word, sc_vec3 *out);
/** @return the anatomical words, for messages. */
const char *const *sc_anatomical_words(size_t *count);

#endif
