/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  What is shown in one frame and from where: the looks of the tissues (transfer function), the
 *  camera, the light and the clip planes. All positions are in patient millimetres, RAS+. The types
 *  are plain values, free to copy; the functions are pure and may be called by any thread. */
#ifndef SEGCAST_SCENE_H
#define SEGCAST_SCENE_H

#include "segcast/grey.h"
#include "segcast/prepare.h"

enum { SC_WHERE_BYTES = 192 }; /**< of "file:line: key" for messages, which is cut to fit */

/* ---- transfer function (paper, section 2.1) ---- */

/** How a surface reflects light; all are at least 0. */
typedef struct sc_material {
    double specular;  /**< strength of the highlight */
    double roughness; /**< of the face that it comes from, above 0, to 1: the square root of the
                           width of its facets (GGX); the larger, the wider the highlight */
    double coat;      /**< share of the surface that lies under a clear, smooth coat, to 1 */
} sc_material;
/** The material of tissues for which no rule says otherwise. Macros, so that the documents of the
 * job file can quote them. */
#define SC_MATERIAL_SPECULAR 0.14
#define SC_MATERIAL_ROUGHNESS 0.48
#define SC_MATERIAL_COAT 0

/** What a rule says anything about. */
typedef struct sc_rule_given {
    bool color, opacity, interior_opacity, visible;
    bool smooth, specular, roughness, coat, offset;
} sc_rule_given;

/** What the user wants of all tissues whose name or number matches a pattern. What the rule leaves
 *  open (its member of has is false) stays as it was. */
typedef struct sc_tissue_rule {
    char pattern[SC_NAME_BYTES]; /**< a name, a glob (* ? [...]), or a label number */
    char where[SC_WHERE_BYTES];  /**< "file:line" of the rule, for messages; may be empty */
    sc_rule_given has;
    bool visible;
    bool opacity_auto; /**< the opacity follows the measured thickness; opacity is not read */
    uint8_t rgb[3];
    double opacity;          /**< 0 to 1 */
    double interior_opacity; /**< 0 to 1; below 0: that of the boundary */
    sc_vec3 offset_mm;       /**< how far it is moved from its place, RAS */
    /** Numbers, from 1, of key frames in a list of the caller; 0: there are none, and the value is
     * the same in all frames. With key frames rgb is the first of them, opacity the greatest,
     * visible whether any of them is, and offset_mm not read. */
    int color_track, opacity_track, visible_track, offset_track;
    sc_vec3 smooth; /**< see sc_prepare_settings.tissue_smooth */
    sc_material material;
} sc_tissue_rule;

/** The look of one label. */
typedef struct sc_tissue {
    bool visible;   /**< false: nothing of it is shown, whatever its opacities */
    double opacity; /**< of the boundary, 0 to 1: per crossing (smooth), per voxel length (voxel) */
    bool opacity_auto; /**< the opacity follows from what was measured: sc_opacity_rule */
    bool is_cover;     /**< ... as of a cover, not by thickness */
    bool is_rest;      /**< hidden, because its name calls it left over and nothing else says how it
                            looks */
    bool color_given;  /**< a label table, a value or a rule has set the colour */
    bool color_by_rule;      /**< a rule has, which goes before values */
    double interior_opacity; /**< of interior voxels, per voxel length; 0 unless a rule sets it,
                                  below 0 as of sc_tissue_rule until a session resolves it */
    float rgb_linear[3];     /**< colour in linear light, 0 to 1; of key frames that of the first */
    int color_track;         /**< as of sc_tissue_rule */
    int opacity_track;       /**< likewise; 0 also if the greatest opacity is 0 */
    int visible_track, offset_track; /**< likewise */
    sc_vec3 offset_mm;               /**< as of sc_tissue_rule */
    sc_material material;
    uint8_t clip_set;   /**< which planes cut it: index into sc_scene_clip.sets */
    uint8_t fade_group; /**< 0: its opacity is the same in all frames; else 1 to SC_FADE_GROUPS_MAX:
                             the tissues of a group fade alike, or nearly so; only their shade on
                             others depends on it */
    uint8_t part;       /**< 0: it never moves; else 1 to SC_PARTS_MAX - 1: the tissues of a part
                             move together */
} sc_tissue;
/** The most groups of tissues that fade alike. Each takes 2 bytes for a brick of 64 voxels. */
enum { SC_FADE_GROUPS_MAX = 8 };
/** The most parts of the tissues that move each by itself, part 0 included, which does not move.
 * Each is drawn from masks and distances of its own, and rays are followed through each. */
enum { SC_PARTS_MAX = 33 };

/** Log what is wrong with a pattern: that it matches no label, with the nearest names, or that it
 *  is a name which fits labels of different names equally well. "*" is always right.
 *  @param where "file:line" of the pattern; may be empty, not NULL. @return SC_ERR_DATA, or
 *  SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_pattern_check(const sc_ctx *ctx, const sc_prepared *volume,
                                       const char *pattern, const char *where);
/** How automatic opacities follow from what was measured. */
typedef enum sc_opacity_rule {
    SC_OPACITY_MEASURED, /**< by mean thickness (sc_label_stats), from 0.5 at 1 mm to 0.95 at
                              15 mm; covers step back. In volumes of less than 100 mm both lengths
                            are shorter, in proportion */
    SC_OPACITY_PAPER     /**< from 0.3 for the thinnest visible tissue to 0.9 for the thickest
                              (paper, section 2.1) */
} sc_opacity_rule;
/** A logarithmic scale from thickness to opacity. */
typedef struct sc_opacity_scale {
    double least, most;       /**< opacities at its ends */
    double thin_mm, thick_mm; /**< thicknesses at its ends, both 0 if nothing was measured */
} sc_opacity_scale;
/** @return the scale of a rule. @param tissues [label_count] by dense id; only visible is read. */
sc_opacity_scale sc_opacity_scale_of(const sc_prepared *volume, const sc_tissue *tissues,
                                     sc_opacity_rule rule);
/** @return the opacity of a thickness, which is clamped to the scale; the most if the thickness is
 *  not known (0) or the scale has no length. */
double sc_auto_opacity(const sc_opacity_scale *scale, double thickness_mm);
/** @return the scale of tissues for local thicknesses: the thick end, which are tubes and chambers,
 *  lies at twice the thickness there, because that of a tube is its diameter, while the mean
 *  thickness of a label is the radius. A scale without a length stays. */
sc_opacity_scale sc_local_opacity_scale(sc_opacity_scale scale);
/** Find the looks of all labels: from the label table of the volume, then by the rules in order, of
 *  which later ones win; one that matches no label does nothing. @param out [label_count] by dense
 *  id; clip_set is set to 0, and the background is invisible. Tissues with opacity_auto get their
 *  opacity here, by the rule @p opacity. */
void sc_transfer_resolve(const sc_prepared *volume, const sc_tissue_rule *rules, size_t rule_count,
                         sc_opacity_rule opacity, sc_tissue *out);

/** Find the hidden labels: those that table and rules make invisible or give no opacity, and those
 *  that are left over by their names (sc_tissue.is_rest). They are
 *  treated as background, because otherwise surfaces would be drawn between a visible tissue and
 *  each of the tissues around it that nobody sees. A rule that matches no label is no error here.
 *  @param labels [label_count] by dense id.
 *  @param hidden [label_count] by dense id; false for the background. @return SC_ERR_MEMORY, with
 *  nothing written. */
SC_MUST_USE sc_status sc_hidden_labels(const sc_ctx *ctx, const sc_label *labels, int label_count,
                                       const sc_tissue_rule *rules, size_t rule_count,
                                       bool *hidden);
/** Find how strongly the surface of each label is smoothed (sc_prepare_settings.tissue_smooth). A
 *  rule that matches no label is no error here. @param labels [label_count] by dense id.
 *  @param smooth the strength of tissues for which no rule says otherwise. @param out
 * [label_count].
 */
void sc_tissue_strengths(const sc_label *labels, int label_count, const sc_tissue_rule *rules,
                         size_t rule_count, sc_vec3 smooth, sc_vec3 *out);
/** Choose the colour behind the tissues: white, or dark slate if tissues of nearly that colour are
 *  a quarter or more of what is seen from outside, so that they have an edge.
 *  @param tissues [label_count] by dense id. @param rgb sRGB. */
void sc_choose_background(const sc_prepared *volume, const sc_tissue *tissues, uint8_t rgb[3]);
/** Make those colours darker or lighter that nobody has given and that can hardly be told from the
 *  background (sc_color_contrast), just as much as is needed.
 *  @param tissues [label_count] by dense id. @param background sRGB. */
void sc_part_from_background(int label_count, const uint8_t background[3], sc_tissue *tissues);

/* ---- light ---- */

/** Where light comes from. */
typedef enum sc_light_method {
    SC_LIGHT_PLAIN,  /**< from lamps; occlusion and shadows are estimated */
    SC_LIGHT_FLAT,   /**< there is none: plain colours, as in the paper */
    SC_LIGHT_GLOBAL, /**< from a lamp and a sky that stand to the volume, whose light reaches
                        surfaces also by way of others; of smooth surfaces. Voxel surfaces: as plain
                      */
    SC_LIGHT_PATH    /**< the same light, found by following paths of it in each frame: the truth,
                        which takes a thousand times as long */
} sc_light_method;

/** Where a lamp stands, as far away as the sky, whose light is gathered or comes by paths. It is a
 *  rectangle of even brightness; if it is not given, a disc before the body. */
typedef struct sc_lamp {
    bool is_given, follows; /**< follows: it stands to the camera, else to the body */
    /** The direction to its middle, by the angles of the camera's orbit. Of a lamp that follows the
     * camera they are relative to the camera: at angle 0 it is behind it, at 90 to its right. */
    double angle_deg, elevation_deg;
    double width_deg, height_deg; /**< as seen from the tissues */
} sc_lamp;

/** The light of the whole picture. The lamps move with the camera, unless the light is global; a
 *  weak one from the right softens the shade of the key light. The strengths of ambient, key and
 *  head light are shares of full brightness. */
typedef struct sc_lighting {
    sc_light_method method; /**< the same in all frames of a renderer */
    sc_lamp lamp;           /**< the same */
    double ambient;         /**< the same from all directions */
    double key;             /**< from above the viewer's left shoulder */
    double head;            /**< from the eye */
    double occlusion;       /**< 0 to 1: how much cavities and folds are darkened */
    double shadows;         /**< 0 to 1: how dark the soft shadows of the key light are */
    double edges;     /**< 0 to 1: how much opacity grows where a surface is seen from the side */
    double depth_cue; /**< 0 to 1: how much the far end fades into the background */
} sc_lighting;

/** What stands below the tissues: nothing, a floor, or one that rises behind them. */
typedef enum sc_ground { SC_GROUND_NONE, SC_GROUND_FLOOR, SC_GROUND_COVE } sc_ground;

/* ---- camera ---- */

/** How points are projected into the picture. */
typedef enum sc_projection {
    SC_PERSPECTIVE,
    SC_ORTHOGRAPHIC,
    SC_EQUIRECTANGULAR /**< all directions: columns are longitudes about the up direction, rows are
                            latitudes, and the middle of the picture is the direction of view */
} sc_projection;

/** A camera. */
typedef struct sc_camera {
    sc_projection projection;
    sc_vec3 position_mm;
    sc_vec3 right, up, forward; /**< unit, orthogonal: of the picture, and the direction of view */
    double half_height; /**< half the height of the picture: the tangent of half the field of view
                             (perspective), mm (orthographic), or pi / 2 (equirectangular) */
    double aperture_mm; /**< diameter of the lens of a perspective view; 0: all is sharp */
    double focus_mm;    /**< with an aperture: how far from the eye along forward things are sharp;
                             above 0 */
} sc_camera;

/** @return a camera at @p position_mm that looks towards @p target_mm, a different point. @p up, of
 *  any length but zero, points upwards in the picture;
 *  where it is parallel to the direction of view, some perpendicular direction replaces it.
 *  @param half_height see sc_camera. */
sc_camera sc_camera_look(sc_vec3 position_mm, sc_vec3 target_mm, sc_vec3 up,
                         sc_projection projection, double half_height);

/* ---- clip planes (paper, section 2.2) ---- */

/** The most clip planes of a scene, and the most different sets of them. */
enum { SC_PLANES_MAX = 16, SC_CLIP_SETS_MAX = 8 };

/** A clip plane keeps the points p with normal . p + offset_mm >= 0. */
typedef struct sc_plane {
    sc_vec3 normal; /**< unit */
    double offset_mm;
} sc_plane;

/** What several clip planes keep together. */
typedef enum sc_clip_mode {
    SC_CLIP_KEEP, /**< keep what all planes keep */
    SC_CLIP_CUT   /**< remove only what every plane removes: a wedge, a corner */
} sc_clip_mode;

/** A part of a ray that the clip planes keep. */
typedef struct sc_interval {
    double begin_mm, end_mm; /**< distances from the origin of the ray */
    int begin_plane;         /**< index of the plane at which the part begins; -1: at none */
} sc_interval;

/** Clip the stretch [begin, end] of a ray by those planes whose bit is set in @p which; with no bit
 *  set all of it is kept. @param planes by bit of @p which.
 *  @param direction unit, RAS. @param out room for 2: the kept parts, in order along the ray.
 *  @return how many there are: 0 to 2; 0 also if begin_mm >= end_mm. */
int sc_clip_ray(const sc_plane *planes, uint32_t which, sc_clip_mode mode, sc_vec3 origin_mm,
                sc_vec3 direction, double begin_mm, double end_mm, sc_interval out[2]);

/** Tissues that one clip plane does not cut. */
typedef struct sc_clip_exception {
    int plane; /**< index of the plane */
    int span; /**< index of the key frame of the exceptions of the plane: it holds from there to the
                   next; 0 if they have none */
    char pattern[SC_NAME_BYTES]; /**< as sc_tissue_rule.pattern */
    char where[SC_WHERE_BYTES];  /**< "file:line" for messages; may be empty */
} sc_clip_exception;

/** Which clip planes cut the tissues of a clip set, and when. */
typedef struct sc_clip_set {
    uint64_t spares[SC_PLANES_MAX]; /**< of each plane: if bit s is set it does not cut them in span
                                       s, as of sc_clip_exception.span */
} sc_clip_set;
/** The most spans of the exceptions of a plane. */
enum { SC_CLIP_SPANS_MAX = 64 };

/** Find the clip sets: the different sets of clip planes by which tissues are cut. Tissues that are
 *  cut by the same planes at all times share one. All planes cut those of set 0 at all times, even
 * if there are none.
 *  @param tissues [label_count] by dense id; clip_set of all but the background is set.
 *  @param clip_sets room for SC_CLIP_SETS_MAX.
 *  @param clip_set_count how many sets there are, at least 1.
 *  @return SC_ERR_USAGE for more than SC_CLIP_SETS_MAX sets (logged), SC_ERR_MEMORY; @p
 * clip_set_count is not written then, the others may be in part. */
SC_MUST_USE sc_status sc_clip_sets_find(const sc_ctx *ctx, const sc_prepared *volume,
                                        const sc_clip_exception *exceptions, size_t exception_count,
                                        sc_tissue *tissues, sc_clip_set *clip_sets,
                                        int *clip_set_count);

/** What of the settings of a renderer may change from frame to frame. */
typedef struct sc_look {
    sc_lighting light;     /**< method as in the settings */
    uint8_t background[3]; /**< sRGB; not read if the settings are transparent */
    /** Shares, 0 to 1, of the grey volume in the colour of cut faces, and on slices, and the
     *  opacity of 10 mm of what is white in it, behind the tissues; not read without one. */
    double grey_caps, grey_slices, grey_backdrop;
    sc_grey_window grey_window; /**< in which it is shown; not read without one */
} sc_look;

/** The clip planes of a scene. */
typedef struct sc_scene_clip {
    sc_plane planes[SC_PLANES_MAX]; /**< [count] of them */
    int count;
    uint32_t which; /**< which planes of the film they are: bit i for plane i */
    sc_clip_mode mode;
    uint32_t sets[SC_CLIP_SETS_MAX]; /**< [set_count]: the planes of each clip set, as bits */
    int set_count;
} sc_scene_clip;

/** Everything that changes from frame to frame: all that is drawn of a frame follows from its
 * scene, and from what is the same in all frames. */
typedef struct sc_scene {
    double time;   /**< when it is shown: from 0, the first frame, to 1, the last */
    int frame;     /**< its number, for the time code, and for names, which are placed for the whole
                        film at once */
    bool has_look; /**< look is that of this frame; false: it is that of the renderer's settings */
    bool inside;   /**< the camera is within a vessel or chamber: all lamps are at the eye, and
                        nothing shades */
    bool slice;    /**< draw nothing but the cut faces: a slice through the volume */
    double around_mm;    /**< inside: radius of the space around the camera, which changes smoothly
                              from frame to frame; 0: it is not known */
    int moment, moments; /**< of the moments at which a frame with motion blur is drawn: which one
                              it is, and how many there are; 0 and 0: the only one */
    sc_camera camera;
    sc_look look;
    sc_scene_clip clip;
    double dark_text;   /**< as of sc_text_colors, for what is written over the picture */
    double divider;     /**< where the first of two subjects in one picture ends, as a share of its
                             width: sc_divider_px */
    sc_vec3 point_mm;   /**< in which the slices of the three regular views meet, RAS */
    const float *fades; /**< [label_count] by dense id: what the opacity of each tissue is
                             multiplied by, at least 0; opacities above 1 become 1. Those of fade
                             group 0 are 1. NULL: all are 1. Borrowed. */
    const float (*colors)[3];  /**< [label_count] by dense id: the colour of each tissue in linear
                                    light. NULL: the colours with which the renderer was made.
                                    Borrowed. */
    const sc_vec3 *offsets_mm; /**< [label_count] by dense id: how far each tissue is moved from its
                             place, RAS; those of a part (sc_tissue.part) alike, those of part 0
                             not. Clip planes move with the tissues that they cut. NULL: none is.
                             Borrowed. */
} sc_scene;

/** Room for what scenes say of tissues, which borrow it. */
typedef struct sc_scene_room {
    sc_vec3 *offsets_mm; /**< [label_count], as are the others: see sc_scene; owned */
    float (*colors)[3], *fades;
} sc_scene_room;
/** Make room for the tissues of a volume. @return SC_ERR_MEMORY. Caller owns *out:
 * sc_scene_room_clear. */
SC_MUST_USE sc_status sc_scene_room_init(const sc_ctx *ctx, int label_count, sc_scene_room *out);
/** Free the room; harmless on a zeroed struct. */
void sc_scene_room_clear(sc_scene_room *room);

/** What may differ between two scenes, as bits. */
enum {
    SC_CHANGED_CAMERA = 1,
    SC_CHANGED_CUTS = 2, /**< clip planes, slices, the divider */
    SC_CHANGED_LIGHT = 4,
    SC_CHANGED_GREY = 8,    /**< how the grey volume is shown */
    SC_CHANGED_COLORS = 16, /**< of tissues and of the background */
    SC_CHANGED_OPACITIES = 32,
    SC_CHANGED_PLACES = 64 /**< of tissues */
};
/** @return what differs between two scenes of a film, as bits; 0: their pictures are the same, but
 *  for what is written over them. @param label_count of the volume. */
unsigned sc_scene_changes(const sc_scene *a, const sc_scene *b, int label_count);

/** @return the column of a picture of @p width_px at which a divider stands. */
static inline int sc_divider_px(double divider, int width_px)
{
    return (int)floor(fmin(fmax(divider, 0), 1) * width_px + 0.5);
}

#endif
