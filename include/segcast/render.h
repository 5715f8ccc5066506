/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Draws frames: a frame is divided into tiles, which threads claim one after the other. The pixels
 * do not depend on the number of threads, on the size of tiles, on the skip method, or on the
 * variant of the kernels. */
#ifndef SEGCAST_RENDER_H
#define SEGCAST_RENDER_H

#include <stdatomic.h>

#include "segcast/grey.h"
#include "segcast/image.h"
#include "segcast/kernel.h"
#include "segcast/panorama.h"

enum { SC_SAMPLES_MAX = 8 };

/** How a grey volume is shown. */
typedef struct sc_grey_look {
    sc_grey_window window; /**< where scenes have a look of their own, one as dark as the darkest of
                                theirs, and as narrow as the narrowest */
    double caps;   /**< 0 to 1: its share in the colour of cut faces; 0: it is not shown there */
    double slices; /**< 0 to 1: its share in the colour of tissues on slices, beside which it is all
                        there is; 0: slices do not show it */
    double backdrop; /**< opacity, 0 to 1, of 10 mm of what is white, behind the tissues; darker
                          values have less, and black none. 0: none of it is drawn. Where scenes
                        have a look of their own, 0 only if it is 0 in all of them */
} sc_grey_look;

/** How many rays are sent. */
typedef struct sc_sampling {
    int samples;      /**< in a pixel that gets more than one, 1 to SC_SAMPLES_MAX; 1: every pixel
                           gets one */
    int lens_samples; /**< in a pixel of a scene whose camera has an aperture, or whose light is
                           path-traced: a power of two; 0: there is no such scene */
    bool everywhere;  /**< true: every pixel gets that many rays; false: only pixels that differ
                           from a neighbour do, all others one */
    bool to_the_end;  /**< rays go on behind what is opaque: the same picture, more work */
} sc_sampling;

/** Who does the work of drawing. All pointers are borrowed. */
typedef struct sc_render_work {
    int tile_px; /**< edge of a tile, at least 1 */
    int threads; /**< that draw a frame, at least 1 */
    /** NULL, or a flag that a signal handler may set: then the rest of a frame is left out, and
     * what is drawn is of no use. */
    const atomic_int *give_up;
    /** NULL, or the communicator whose ranks make a renderer each, with the same settings but for
     * the threads: those of a node derive together what they draw from, and share it. */
    sc_comm *comm;
    const char *folder; /**< as of sc_team_open; not read without comm */
    /** NULL, or a renderer with the same threads and tiles that never draws at the same time: the
     *  memory in which it draws tiles is used, too, until sc_renderer_free. */
    const struct sc_renderer *lender;
} sc_render_work;

/** What all frames of a renderer share. Only sc_renderer_new reads the text @p cpu points to. */
typedef struct sc_render_settings {
    int width_px, height_px;
    sc_surface surface;
    sc_skip skip;
    const char *cpu; /**< variant of the kernels, one of sc_cpu_names; NULL: the best that this
                          processor can run */
    sc_sampling sampling;
    double step_voxels;     /**< distance between samples, in voxel lengths (the smallest spacing);
                                 voxel surface only */
    bool caps;              /**< cut faces are drawn solid */
    sc_ground floor;        /**< on which shadows fall, by light that is gathered or by paths */
    double cap_outline;     /**< width of lines between tissues on cut faces, in voxels; 0: none */
    const sc_grey *grey;    /**< NULL, or a grey volume that cut faces and slices show; borrowed */
    sc_grey_look grey_look; /**< not read without */
    sc_lighting light;      /**< where scenes have a look of their own: sc_light_of_all of them */
    /** NULL, or what stands in place of the sky where light is gathered or comes by paths;
     *  borrowed. And by how much it is turned about the axis of the body, to its right. */
    const sc_panorama *environment;
    double environment_turn_deg;
    bool
        local_thickness; /**< automatic opacity follows the local thickness, not the label's mean */
    sc_opacity_rule opacity_rule; /**< of the tissues, for their local thickness */
    uint8_t background[3];        /**< sRGB; not read if transparent */
    bool transparent;             /**< there is no background: images have alpha (sc_image) */
    sc_render_work work;
} sc_render_settings;

/** Draws frames of one volume with one set of tissues and settings. */
typedef struct sc_renderer sc_renderer;

/** The work and the time that a frame took. */
typedef struct sc_render_stats {
    sc_march_counters counters;
    double wall_s, cpu_s; /**< cpu: of all threads that drew */
} sc_render_stats;
/** Add the work and the times of @p more to @p sum. */
void sc_render_stats_add(sc_render_stats *sum, const sc_render_stats *more);

/** Make a renderer: finds what is visible, and derives from the volume all that does not change
 *  from frame to frame. Starts settings->work.threads threads during the call. With
 * settings->work.comm collective among the ranks of a node, which all get the same return code;
 * SC_ERR_MEMORY also means that they can share no memory, and each may try again without
 * settings->work.comm. @param settings copied. @param volume stays borrowed until sc_renderer_free.
 * @param tissues [label_count of the volume], by dense id; copied. @param out caller owns:
 * sc_renderer_free; written only on success. @return SC_ERR_MEMORY; SC_ERR_DATA if the geometry of
 * the volume is singular; SC_ERR_USAGE if this processor cannot run the variant settings->cpu. A
 * volume too large for wide kernels is no error: those of SC_SKIP_INTERIOR then draw it (see
 *  sc_renderer_kernel). */
SC_MUST_USE sc_status sc_renderer_new(const sc_ctx *ctx, const sc_render_settings *settings,
                                      const sc_prepared *volume, const sc_tissue *tissues,
                                      sc_renderer **out);
/** How much of the light that is gathered differs between the scenes of a renderer. */
typedef enum sc_light_change {
    SC_LIGHT_STAYS,    /**< nothing: the camera may */
    SC_LIGHT_NEW_SUMS, /**< what light comes along the rays, as where a plane moves */
    SC_LIGHT_NEW_RAYS  /**< the rays themselves, as where tissue fades */
} sc_light_change;
/** @return how much differs between the light of two scenes of a film. @param label_count of the
 *  volume. @param floor as of sc_render_settings. Pure. */
sc_light_change sc_light_between(const sc_scene *a, const sc_scene *b, int label_count, bool floor);
/** With light.method SC_LIGHT_GLOBAL: prepare to gather light, and as far as the frames have it in
 *  common do so for a first scene, with all ranks that made the renderer together, which are then
 *  done with it and hold it once. Frames that are drawn without have no light from the sky. To be
 *  called before the first frame, by all these ranks; more calls do nothing. @param first that of a
 * frame which is neither a slice nor within a vessel. @param change the most that any two scenes of
 * the renderer differ by. @param prepared the file of the cache that holds the prepared volume:
 * where nothing differs, one rank alone keeps the light beside it, and finds what was kept; NULL:
 * none. @return SC_ERR_MEMORY, the same on all these ranks: SC_LIGHT_NEW_RAYS shares less. */
SC_MUST_USE sc_status sc_renderer_gather(const sc_ctx *ctx, sc_renderer *r, const sc_scene *first,
                                         sc_light_change change, const char *prepared);
/** Free a renderer and everything it owns, on this rank alone; NULL is allowed. The volume stays
 * the caller's. */
void sc_renderer_free(sc_renderer *renderer);
/** Tell the system whether this rank will soon draw with the renderer, or not for a while: see
 *  sc_team_advise, for what was derived from the volume. The volume itself is the caller's. Not
 *  while a frame is being drawn. */
void sc_renderer_advise(sc_renderer *renderer, sc_memory_use use);
/** Points in RAS mm among which are all corners of the convex hull of what is visible, for
 *  framing: @p count of them, 0 if nothing is visible. They stay owned by the renderer. */
const sc_vec3 *sc_renderer_hull(const sc_renderer *renderer, size_t *count);
/** The kernel that the renderer uses; an entry of the constant table of kernels. Its skip method
 *  may differ from that of the settings if the volume is too large. */
const sc_kernel *sc_renderer_kernel(const sc_renderer *renderer);
/** Bytes of memory that every rank has for itself to draw, beside the prepared volume. */
uint64_t sc_renderer_bytes(const sc_renderer *renderer);
/** Bytes of what was derived from the volume: the ranks of a node hold them once, if the renderer
 *  was made with settings->work.comm. */
uint64_t sc_renderer_derived_bytes(const sc_renderer *renderer);

/** A rectangle of a picture: x_px and y_px are its upper left corner. */
typedef struct sc_viewport {
    int x_px, y_px, width_px, height_px;
} sc_viewport;
/** Rows [first, end) of a picture, from the top. */
typedef struct sc_rows {
    int first, end;
} sc_rows;
/** Columns [first, end) of a picture, from the left. */
typedef struct sc_columns_px {
    int first, end;
} sc_columns_px;
/** Draw a scene into @p part, a rectangle that must lie within @p image (NULL: all of it); the
 *  vertical field of view fills its height. Blocks until it is drawn; cannot fail. @param columns,
 *  rows of the image, outside of which nothing is drawn; NULL: all. A pixel does not depend on
 * which others are drawn. @param image sRGB; pixels outside of that stay as they are. @param stats
 *  overwritten; all 0 if nothing is left. Threads: a renderer draws one frame at a time, on the
 *  threads of its settings. */
void sc_render_view(sc_renderer *renderer, const sc_scene *scene, const sc_viewport *part,
                    const sc_columns_px *columns, const sc_rows *rows, sc_image *image,
                    sc_render_stats *stats);

/** Let a renderer draw in a hurry, or not any more: one ray in each pixel, and no light is
 * gathered. Nothing that it has kept of the last scene counts then. Not while a frame is being
 * drawn. */
void sc_renderer_hurry(sc_renderer *renderer, bool hurries);
/** What is seen in a point of a picture. */
typedef struct sc_pick {
    int id;        /**< dense id of the tissue that is seen first; 0: none */
    sc_vec3 at_mm; /**< where, RAS; not set if there is none */
} sc_pick;
/** Find what the ray through a point of a picture of @p size_px meets first. @param x_px, y_px from
 *  the upper left corner. Threads: as sc_render_view. */
sc_pick sc_render_pick(sc_renderer *renderer, const sc_scene *scene, const int size_px[2],
                       double x_px, double y_px);

/** Count what the ray through the middle of each pixel takes, in a picture of the scene of any
 * size. Rays are marched one by one, so that wide kernels take longer for each than in a frame.
 * Blocks until it is done; cannot fail. @param out [height_px][width_px], overwritten; 0 where
 * nothing can be seen. @param stats overwritten: the sums. Threads: as sc_render_view. */
void sc_render_counts(sc_renderer *renderer, const sc_scene *scene, int width_px, int height_px,
                      sc_march_counters *out, sc_render_stats *stats);

/** When a thread began and ended to draw, by sc_wall_s(): the beginning of its first and the end
 *  of its last work, of all frames in between. Both 0 if it did not draw. */
typedef struct sc_render_span {
    double begin_s, end_s;
} sc_render_span;
/** Copy to @p out [threads of the settings] when each thread drew since the last call, and start
 *  anew. Not while a frame is being drawn. */
void sc_renderer_spans(sc_renderer *renderer, sc_render_span *out);

#endif
