/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to timeline: where a camera that turns stands, at any time of the animation; and what
 * else a scene is made of. */
#ifndef SC_TIMELINE_MOTION_H
#define SC_TIMELINE_MOTION_H

#include "segcast/timeline.h"

/* The most directions of view that a framing looks at. */
enum { SC_SIGHTS_MAX = 512 };

/* From where a camera that turns sees its target. */
typedef struct sc_sight {
    sc_vec3 away;                /* unit: from the target to the camera */
    sc_vec3 up;                  /* not parallel to away; points upwards in the picture */
    sc_vec3 target_mm;           /* of no meaning before it is known: sc_orbit.has_target */
    double distance_mm, tangent; /* the same for distance_mm; of half the field of view */
} sc_sight;

/* @return the unit direction from the target to the camera at angle 0, perpendicular to the unit @p
 * axis: to the front of the patient, or above where the axis itself points nearly that way. */
sc_vec3 sc_orbit_reference(sc_vec3 axis);
/* @return from where the camera sees its target in frame @p k, which need not be whole, as far as
 * key frames and the verbs orbit, rock and hold decide. */
sc_sight sc_sight_at(const sc_timeline *timeline, double k);
/* Set *out to the camera of a time, 0 to 1, if it flies then, and *around_mm as of sc_scene. @param
 * zoom what the picture is scaled by. @return false, with nothing written, if it does not. */
bool sc_fly_camera(const sc_timeline *timeline, double at, double zoom, sc_camera *out,
                   double *around_mm);
/* @return plane @p plane of the animation at a time, as its sweep and the verbs turn place it. */
sc_plane sc_plane_at(const sc_timeline *timeline, int plane, double at);
/* Fill @p out with the sights by which an orbit is framed: those of a whole turn, or of the part of
 * one that it covers; of a camera that moves in other ways, too, those of its frames or of enough
 * of them. @return how many there are. */
int sc_sights_of(const sc_timeline *timeline, sc_sight out[SC_SIGHTS_MAX]);
/* The same of the frames from @p first to @p last, which need not be whole. */
int sc_sights_between(const sc_timeline *timeline, double first, double last,
                      sc_sight out[SC_SIGHTS_MAX]);
/* @return how many of @p count changes, one or more, are those of the first one's tissue. */
size_t sc_changes_of_first(const sc_change *changes, size_t count);
/* @return whether @p count changes of two tissues are the same, their numbers to within 1e-9. */
bool sc_changes_same(const sc_change *a, const sc_change *b, size_t count);
/* What happens to tissues, while it is found. */
typedef struct sc_changes {
    sc_change *all; /* [count], with room for more; owned: sc_free */
    size_t count, room;
} sc_changes;
sc_status sc_changes_add(const sc_ctx *ctx, const sc_change *change, sc_changes *out);
/* Sort changes by their tissues and, of one tissue, by the time at which they begin; equal ones
 * keep their order. @return SC_ERR_MEMORY. */
sc_status sc_changes_sort(const sc_ctx *ctx, sc_changes *changes);
/* @return the key frames of number @p number, as of sc_tissue.opacity_track; NULL if that is 0. */
const sc_track *sc_track_number(const sc_track *tracks, int number);
/* Find the colour behind the tissues at a time. @param rgb sRGB. */
void sc_find_background(const sc_background *background, double at, uint8_t rgb[3]);
/* Fill @p out, as of sc_scene.fades, with what the opacities of tissues are multiplied by at a
 * time. Verbs of one tissue follow one another by the time at which they begin: a fade goes on from
 * where those before it have left the opacity, and a tissue is not seen before it appears, unless
 * another verb has been at work before. Pulses multiply. Key frames of the opacity come first:
 * verbs change what they give then, and a fade to an opacity, and not to a share of it, replaces
 * them. */
void sc_fades_at(const sc_looks *looks, double time, float *out);
/* Fill @p out, as of sc_scene.offsets_mm, with how far tissues are from their places at a time.
 * What several shifts do to a tissue adds up. @return whether any is moved. */
bool sc_offsets_at(const sc_looks *looks, double time, sc_vec3 *out);
/* @return how dark text is in frame @p k (sc_scene.dark_text). Where the background becomes dark or
 * light it changes within half a second; at once only if the background jumps. */
double sc_find_dark_text(const sc_timeline *timeline, int k);

#endif
