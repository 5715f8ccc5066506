/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Floor 4: the animation: frame number -> scene, as closed functions of the number. Pure. */
#ifndef SEGCAST_TIMELINE_H
#define SEGCAST_TIMELINE_H

#include "segcast/scene.h"

typedef enum sc_ease { SC_EASE_LINEAR, SC_EASE_SMOOTH, SC_EASE_IN, SC_EASE_OUT } sc_ease;

/** A place along a direction: a share of what is shown, or millimetres. */
typedef struct sc_plane_position {
    double value;
    bool percent; /**< of the way through the visible tissues; else mm along the normal in RAS */
} sc_plane_position;

/** A value that goes from one end to the other during a part of the animation. */
typedef struct sc_ramp {
    double from, to;
    double begin, end; /**< part of the animation, 0 to 1 */
    sc_ease ease;
} sc_ramp;

typedef struct sc_orbit {
    bool fixed;   /**< a still camera; then position, target and up count */
    sc_vec3 axis; /**< unit; up in the picture */
    double turns;
    double elevation_deg, start_deg;
    bool has_target, has_distance;
    sc_vec3 position_mm, target_mm, up;
    double distance_mm;
    double fov_deg; /**< vertical */
    sc_projection projection;
    sc_ramp zoom;
} sc_orbit;

typedef struct sc_sweep {
    sc_vec3 normal; /**< unit, towards what is kept */
    sc_plane_position from, to;
    double begin, end;
    sc_ease ease;
} sc_sweep;

/** The point that the slices of the three regular views go through. */
typedef struct sc_slices {
    bool has_point;
    sc_vec3 point_mm; /**< fixed, if given */
    sc_ramp share; /**< else a share, 0 to 1, of the way through what is shown, along R, A and S */
} sc_slices;

typedef struct sc_animation {
    int frames;
    sc_orbit camera;
    sc_sweep sweeps[SC_PLANES_MAX];
    int sweep_count;
    sc_clip_mode clip_mode;
    sc_slices slices;
} sc_animation;

/** An animation with everything measured that it left open: framing, places in mm. */
typedef struct sc_timeline {
    sc_animation animation;
    double from_mm[SC_PLANES_MAX], to_mm[SC_PLANES_MAX];
    double half_height; /**< before zoom */
    uint32_t clip_sets[SC_CLIP_SETS_MAX];
    int clip_set_count;
    sc_vec3 low_mm, high_mm; /**< box of what is shown */
} sc_timeline;

/** Resolve against what is shown. Framing is that of the whole orbit and of the unclipped
 *  tissues, so that the picture does not breathe. @param points corners of the visible tissues
 *  (sc_hull_points); with none, a box of 1 mm at the origin is framed. */
void sc_timeline_resolve(const sc_animation *animation, const sc_vec3 *points, size_t point_count,
                         double aspect, sc_timeline *out);
/** The scene of frame @p k in [0, frames). A full orbit of N frames turns by 360 k / N degrees:
 *  no frame comes twice. Ramps reach their end in the last frame. */
sc_scene sc_timeline_scene(const sc_timeline *timeline, int k);

/** The point that the slices go through in frame @p k. */
sc_vec3 sc_timeline_point(const sc_timeline *timeline, int k);

double sc_ease_value(sc_ease ease, double u);
/** Direction in RAS of an anatomical word ("left", "superior", ...). @return false if none. */
bool sc_anatomical_direction(const char *word, sc_vec3 *out);
/** The words, for messages. */
const char *const *sc_anatomical_words(size_t *count);

#endif
