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
    double from, to;   /**< the values before and after the part */
    double begin, end; /**< the part: 0 is the first frame of the animation and 1 the last; if they
                            are equal, the value jumps there */
    sc_ease ease;
} sc_ramp;

/** The way of the camera: an orbit about an axis, or a still camera. */
typedef struct sc_orbit {
    bool fixed;           /**< a still camera at position_mm, which looks at target_mm */
    sc_vec3 axis;         /**< of an orbit: unit, RAS; points upwards in the picture */
    double turns;         /**< during the whole animation, right-handed about the axis */
    double elevation_deg; /**< of the camera above the plane of the orbit */
    double start_deg; /**< where the orbit begins; 0 is in front of the patient, where possible */
    bool has_target, has_distance; /**< false: follows from the framing */
    sc_vec3 position_mm, up;       /**< of a still camera */
    sc_vec3 target_mm;             /**< what the camera looks at, and the centre of an orbit */
    double distance_mm;            /**< from the target to the camera of an orbit */
    double fov_deg;                /**< vertical field of view */
    sc_projection projection;
    sc_ramp zoom; /**< scales the picture; above 0; 1: as framed */
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
    int frames; /**< how many, at least 1 */
    sc_orbit camera;
    sc_sweep sweeps[SC_PLANES_MAX]; /**< [sweep_count] of them; sweep i moves plane i */
    int sweep_count;
    sc_clip_mode clip_mode;
    sc_slices slices;
} sc_animation;

/** An animation in which all that depends on the volume is filled in: the framing of the camera and
 *  the positions of the planes in mm. Owns no memory. */
typedef struct sc_timeline {
    sc_animation animation; /**< its camera has a target and a distance now */
    double from_mm[SC_PLANES_MAX], to_mm[SC_PLANES_MAX]; /**< plane positions along the normals */
    double half_height;                                  /**< as of sc_camera, before the zoom */
    uint32_t clip_sets[SC_CLIP_SETS_MAX];                /**< as of sc_scene */
    int clip_set_count;
    sc_vec3 low_mm, high_mm; /**< bounding box of the visible tissues, RAS */
} sc_timeline;

/** Write a copy of @p animation to @p out, with what it leaves open filled in from the extent of
 * the visible tissues. One framing holds for the whole orbit, and for the tissues as they are
 * without clip planes, so that the scale of the picture stays the same. There is one clip set,
 * which holds all planes; the caller replaces clip_sets where tissues are excepted.
 *  @param points among which are the corners of the visible tissues (sc_hull_points); with none, a
 *  box of 1 mm at the origin is framed. @param aspect width of the picture divided by its height.
 */
void sc_timeline_resolve(const sc_animation *animation, const sc_vec3 *points, size_t point_count,
                         double aspect, sc_timeline *out);
/** @return the scene of frame @p k in [0, frames); its slice is false. An orbit of one turn in N
 * frames stands at 360 k / N degrees, so that no direction comes twice when the video loops. Ramps
 * reach their end in the last frame. */
sc_scene sc_timeline_scene(const sc_timeline *timeline, int k);

/** @return the point in which the slices of frame @p k in [0, frames) meet, RAS mm. */
sc_vec3 sc_timeline_point(const sc_timeline *timeline, int k);

/** @return how much of the way is done, 0 to 1. @param u how much of the time has passed, 0 to 1;
 * not clamped. */
double sc_ease_value(sc_ease ease, double u);
/** Find the unit direction, in RAS, that an anatomical word stands for ("left", "superior", ...),
 * case ignored. @return false if it is no such word; @p out is not written then. */
bool sc_anatomical_direction(const char *word, sc_vec3 *out);
/** @return the anatomical words, [*count], for messages; static. */
const char *const *sc_anatomical_words(size_t *count);

#endif
