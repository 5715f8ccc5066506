/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Floor 3: what is shown and from where: transfer function, camera, clip planes. All positions
 *  in patient millimetres, RAS+. Values, free to copy; pure functions, any thread. */
#ifndef SEGCAST_SCENE_H
#define SEGCAST_SCENE_H

#include "segcast/prepare.h"

/* ---- transfer function (paper, section 2.1) ---- */

/** How a surface answers to light. */
typedef struct sc_material {
    double diffuse;  /**< share of the tissue's colour */
    double specular; /**< strength of the highlight */
    int shininess;   /**< its exponent (Blinn-Phong): the larger, the smaller the highlight */
} sc_material;

/** A user's wish for the tissues whose name or number matches. */
typedef struct sc_tissue_rule {
    char pattern[SC_NAME_BYTES]; /**< a name, a glob (* ? [...]), or a label number */
    char where[160];             /**< "file:line" for messages; may be empty */
    bool has_color, has_opacity, has_interior_opacity, has_visible;
    bool has_diffuse, has_specular, has_shininess;
    bool visible;
    bool opacity_auto; /**< opacity from measured thickness */
    uint8_t rgb[3];
    double opacity, interior_opacity; /**< 0 to 1 */
    sc_material material;
} sc_tissue_rule;

/** How one label looks. */
typedef struct sc_tissue {
    bool visible;
    double opacity; /**< of the boundary, 0 to 1: per crossing (smooth), per voxel length (voxel) */
    bool opacity_auto;       /**< it was found from the thickness */
    double interior_opacity; /**< of interior voxels, per voxel length */
    bool interior_given;     /**< a rule has set it */
    float rgb_linear[3];
    sc_material material;
    uint8_t clip_group; /**< which planes cut it: sc_scene.groups */
} sc_tissue;

/** Does @p label match a pattern? Numbers match the value, "*" every label, all else the name,
 *  case ignored. */
bool sc_label_matches(const sc_label *label, const char *pattern);
/** Log that @p pattern matches no label, with the nearest name. @return SC_ERR_DATA. */
sc_status sc_tissue_unknown(const sc_ctx *ctx, const sc_prepared *volume, const char *pattern,
                            const char *where);
/** Opacity of each label after its thickness: thicker tissues are more opaque, on a logarithmic
 *  scale between the thinnest and the thickest of @p shown. */
double sc_auto_opacity(double thickness_mm, double thinnest_mm, double thickest_mm);
/** Looks of all labels: table of the volume, then the rules in order (later ones win).
 *  @param out [label_count] by dense id. @return SC_ERR_DATA (logged, with the nearest name) for
 *  a rule that matches no label. */
SC_MUST_USE sc_status sc_transfer_resolve(const sc_ctx *ctx, const sc_prepared *volume,
                                          const sc_tissue_rule *rules, size_t rule_count,
                                          sc_tissue *out);

/** Which labels the table and the rules leave unseen, hidden or of no opacity: these are treated as
 *  background, so that surfaces do not show where tissues meet that nobody sees.
 *  @param hidden [label_count] by dense id. @param needs_thickness whether some opacity follows the
 *  thickness. */
void sc_hidden_labels(const sc_label *labels, int label_count, const sc_tissue_rule *rules,
                      size_t rule_count, bool *hidden, bool *needs_thickness);
/** Thickness of the thinnest and the thickest of the visible tissues: the ends of the scale of
 *  sc_auto_opacity. Both 0 if none is visible. */
void sc_thickness_range(const sc_prepared *volume, const sc_tissue *tissues, double *thinnest_mm,
                        double *thickest_mm);

/* ---- light ---- */

/** Light of the whole picture; the lamps move with the camera. Strengths of light are shares. */
typedef struct sc_lighting {
    bool flat;        /**< no light at all: plain colours, as in the paper */
    double ambient;   /**< from everywhere */
    double key;       /**< from above the viewer's left shoulder */
    double fill;      /**< from the right, weaker */
    double head;      /**< from the eye */
    double occlusion; /**< 0 to 1: how dark what is enclosed by tissue gets */
    bool shadows;     /**< soft shadows of the key light */
    double edges;     /**< 0 to 1: how much opacity grows where a surface is seen from the side */
    double depth_cue; /**< 0 to 1: how much the far end fades into the background */
} sc_lighting;
/** What looks good without any wish. */
sc_lighting sc_lighting_default(void);

/* ---- camera ---- */

typedef enum sc_projection { SC_PERSPECTIVE, SC_ORTHOGRAPHIC } sc_projection;

typedef struct sc_camera {
    sc_projection projection;
    sc_vec3 position_mm;
    sc_vec3 right, up, forward; /**< unit, orthogonal */
    double half_height;         /**< of the picture: tangent (perspective) or mm */
} sc_camera;

/** Look from @p position to @p target with @p up upwards in the picture. */
sc_camera sc_camera_look(sc_vec3 position_mm, sc_vec3 target_mm, sc_vec3 up,
                         sc_projection projection, double half_height);
/* ---- clip planes (paper, section 2.2) ---- */

enum { SC_PLANES_MAX = 16, SC_GROUPS_MAX = 8 };

/** Keeps what has normal . p + offset >= 0. */
typedef struct sc_plane {
    sc_vec3 normal; /**< unit */
    double offset_mm;
} sc_plane;

typedef enum sc_clip_mode {
    SC_CLIP_KEEP, /**< keep what all planes keep */
    SC_CLIP_CUT   /**< remove only what every plane removes: a wedge, a corner */
} sc_clip_mode;

/** Part of a ray that is kept; a begin made by a plane names it, else -1. */
typedef struct sc_interval {
    double begin_mm, end_mm;
    int begin_plane;
} sc_interval;

/** Kept parts, in order along the ray, of [begin, end] after clipping by those planes whose bit
 *  is set in @p which. @param out room for 2. @return how many. */
int sc_clip_ray(const sc_plane *planes, uint32_t which, sc_clip_mode mode, sc_vec3 origin_mm,
                sc_vec3 direction, double begin_mm, double end_mm, sc_interval out[2]);

/** A tissue that a plane leaves whole. */
typedef struct sc_clip_exception {
    int plane;
    char pattern[SC_NAME_BYTES]; /**< as sc_tissue_rule.pattern */
    char where[160];
} sc_clip_exception;

/** Sort labels into groups by the planes that cut them: fills clip_group of each tissue, and the
 *  planes of each group as bits. @param groups room for SC_GROUPS_MAX. @return SC_ERR_DATA for an
 *  exception that matches no label, SC_ERR_USAGE for more than SC_GROUPS_MAX different sets. */
SC_MUST_USE sc_status sc_clip_groups(const sc_ctx *ctx, const sc_prepared *volume, int plane_count,
                                     const sc_clip_exception *exceptions, size_t exception_count,
                                     sc_tissue *tissues, uint32_t *groups, int *group_count);

/** Everything that changes from frame to frame. */
typedef struct sc_scene {
    sc_camera camera;
    sc_plane planes[SC_PLANES_MAX];
    int plane_count;
    sc_clip_mode clip_mode;
    /** Planes that cut the tissues of each clip group, as bits. */
    uint32_t groups[SC_GROUPS_MAX];
    int group_count;
    bool slice; /**< nothing but the cut faces: a slice through the volume */
} sc_scene;

#endif
