/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  The animation: which scene each frame shows. A scene is a closed function of the frame's number
 *  and depends on no other frame, so that frames can be drawn in any order and by any rank. All
 *  functions are pure and may be called by any thread; none can fail. */
#ifndef SEGCAST_TIMELINE_H
#define SEGCAST_TIMELINE_H

#include "segcast/color_by.h"

/** The ways from one value to another: evenly, starting and ending slowly, starting slowly, ending
 * slowly, or along a curve. */
typedef enum sc_ease_kind {
    SC_EASE_LINEAR,
    SC_EASE_SMOOTH,
    SC_EASE_IN,
    SC_EASE_OUT,
    SC_EASE_BEZIER
} sc_ease_kind;

/** How a value moves from its begin to its end. It never turns back on the way. */
typedef struct sc_ease {
    sc_ease_kind kind;
    double bezier[4]; /**< of SC_EASE_BEZIER: the inner points (x1, y1) and (x2, y2) of a cubic
                           Bezier curve from (0, 0) to (1, 1), x the time and y the share of the
                         way; each from 0 to 1 */
} sc_ease;

/** The most key frames of one value. */
enum { SC_KEY_FRAMES_MAX = 64 };

/** A value at a time. */
typedef struct sc_key_frame {
    double at;     /**< 0 is the first frame of the animation and 1 the last; below 0 only in what a
                        film says outside of its shots: minus a time in seconds, which each shot
                        turns into a share of itself */
    sc_ease ease;  /**< of the change that ends here; that of the first is not used */
    sc_vec3 value; /**< of a number: x, and the others are 0 */
} sc_key_frame;

/** A value by key frames: constant before the first and after the last of them. */
typedef struct sc_track {
    int count;                            /**< 0: there are none, the value is constant */
    sc_key_frame keys[SC_KEY_FRAMES_MAX]; /**< [count] of them, by rising time, no two at one */
} sc_track;

/** Key frames of the light; those that have any replace the member of sc_lighting of that name. */
typedef struct sc_light_tracks {
    sc_track ambient, key, head, occlusion, shadows, edges, depth_cue;
} sc_light_tracks;

/** The colour behind the tissues. */
typedef struct sc_background {
    uint8_t rgb[3]; /**< sRGB; where is_auto is set, to be filled in by sc_choose_background */
    bool is_auto;
    bool is_none; /**< there is none: pictures have alpha; rgb is white then, for what is drawn over
                       the picture */
    sc_track track; /**< key frames, of levels of sRGB; if there are any, rgb is the first, and
                         is_auto and is_none are false */
} sc_background;

/** How much is shown of a grey volume, and in which window. */
typedef struct sc_grey_tracks {
    sc_grey_window window;
    sc_track window_track; /**< key frames of level (x) and width (y); if there are any, window is
                                the first */
    double caps, slices, backdrop;                     /**< as of sc_grey_look */
    sc_track caps_track, slices_track, backdrop_track; /**< key frames, which replace them */
} sc_grey_tracks;

/** Where a clip plane lies along its normal. */
typedef struct sc_plane_position {
    double value;
    bool percent; /**< true: the value is a share, in percent, of the way through the visible
                       tissues; false: mm along the normal from the origin of RAS space */
} sc_plane_position;

/** What a camera with an aperture is focused on. */
typedef enum sc_focus {
    SC_FOCUS_MIDDLE, /**< on what is visible, half way between its middle and its near side */
    SC_FOCUS_POINT,
    SC_FOCUS_TISSUE /**< the same of one tissue, which may be moved */
} sc_focus;
/** What of a picture is sharp: what is in focus, and what does not move while it is taken. */
typedef struct sc_optics {
    double aperture_mm; /**< diameter of the lens; 0: everything is in focus */
    double shutter; /**< how long it is open, as a share of the time from a frame to the next, in
                         whose middle the frame is, 0 to 1; 0: only for a moment */
    sc_focus focus;
    sc_vec3 focus_mm;            /**< the point, RAS; in a timeline the middle of what it is on */
    sc_vec3 half_mm;             /**< in a timeline: half the edges of the box around that, RAS */
    int tissue;                  /**< of SC_FOCUS_TISSUE, in a timeline: a dense id */
    char pattern[SC_NAME_BYTES]; /**< of SC_FOCUS_TISSUE: as sc_tissue_rule.pattern */
    char where[SC_WHERE_BYTES];  /**< "file:line" for messages; may be empty */
} sc_optics;

/** Key frames of a camera; those that have any replace the member of sc_orbit of that name. */
typedef struct sc_orbit_tracks {
    sc_track angle, elevation, target, distance, fov, zoom;
    sc_track position, up; /**< of a still camera, as is target */
} sc_orbit_tracks;

/** The way of the camera: an orbit about an axis, or a still camera. */
typedef struct sc_orbit {
    bool fixed;           /**< a still camera at position_mm, which looks at target_mm; by key
                               frames it goes its way without an orbit */
    sc_vec3 axis;         /**< of an orbit: unit, RAS; points upwards in the picture */
    double turns;         /**< during the whole animation, right-handed about the axis, from the
                               angle on */
    double angle_deg;     /**< right-handed about the axis; 0 is in front of the patient, where
                               possible */
    double elevation_deg; /**< of the camera above the plane of the orbit; beyond 90 it comes down
                               behind, with the picture upside down */
    bool has_target, has_distance; /**< false: follows from the framing */
    bool alone;                    /**< only the first frame is drawn: the framing is for that one,
                                        and what is visible lies in the middle of its picture */
    sc_vec3 position_mm, up;       /**< of a still camera */
    sc_vec3 target_mm;             /**< what the camera looks at, and the centre of an orbit */
    double distance_mm;            /**< from the target to the camera of an orbit */
    double fov_deg;                /**< vertical field of view */
    sc_projection projection;
    double zoom; /**< scales the picture; above 0; 1: as framed */
    sc_optics optics;
    sc_orbit_tracks tracks;
} sc_orbit;

/** A clip plane, which may move along its normal. */
typedef struct sc_sweep {
    sc_vec3 normal;       /**< unit, towards what is kept */
    sc_plane_position at; /**< where it lies; of at_track the first */
    /** Key frames of which tissues it does not cut (sc_clip_exception.span): when they are. 0:
     * there are none, the tissues are the same in all frames. */
    int except_count;
    double except_at[SC_CLIP_SPANS_MAX]; /**< [except_count], rising, as of sc_key_frame.at */
    bool has_active, active;             /**< whether it cuts is given, and does it */
    sc_track active_track;               /**< key frames of it: x is 1 while it cuts, else 0; each
                                              holds until the next */
    /** Key frames of where the plane lies: x and, if y is 1, in percent, as of sc_plane_position.
     * In a timeline x is in mm: along
     * the normal from the origin or, where the normal has key frames, from the pivot. */
    sc_track at_track;
    sc_track normal_track; /**< key frames; normal is the first. No direction is the opposite of the
                                one before */
    bool has_point;        /**< only if the normal has key frames and at_track has none: the plane
                                always contains point_mm, and turns about it */
    sc_vec3 point_mm;      /**< RAS; in a timeline the pivot: without has_point, the middle of what
                                is visible */
} sc_sweep;

/** The point in which the slices of the three regular views meet. */
typedef struct sc_slices {
    bool is_given, are_shown;
    bool has_point;
    sc_vec3 point_mm;     /**< where it stays, if has_point */
    sc_track point_track; /**< key frames, if has_point; if there are any, they replace it */
    double share;         /**< otherwise it is there, or at its key frames: on the diagonal of the
                               box of the visible tissues, 0 is the right, posterior, inferior
                               corner, 1 the opposite one */
    sc_track share_track;
} sc_slices;

/** What a verb does: first those of the opacity of tissues, then those of the camera, then that of
 * clip planes, then those that move tissues. */
typedef enum sc_verb_kind {
    SC_VERB_FADE,   /**< it moves to another one, and stays there */
    SC_VERB_APPEAR, /**< tissues that are not seen before appear, all or one after the other */
    SC_VERB_PULSE,  /**< it goes to another one and back, several times */
    SC_VERB_ORBIT,  /**< the camera turns by an angle, beside what it does anyway */
    SC_VERB_ROCK,   /**< it swings to both sides and returns, several times */
    SC_VERB_ZOOM,   /**< the scale of the picture moves to another one */
    SC_VERB_DOLLY,  /**< the camera goes nearer to its target, or away from it */
    SC_VERB_HOLD,   /**< an orbit pauses, and turns faster in the rest of the time */
    SC_VERB_FRAME,  /**< tissues come to fill the picture */
    SC_VERB_FLY,    /**< the camera flies along a line, within vessels and chambers */
    SC_VERB_TURN,   /**< a clip plane turns about a line */
    SC_VERB_EXPLODE /**< tissues move apart, and stay there */
} sc_verb_kind;

/** @return whether a verb is a move (sc_move): of the camera, or of a clip plane. */
static inline bool sc_verb_is_move(sc_verb_kind kind)
{
    return kind >= SC_VERB_ORBIT && kind <= SC_VERB_TURN;
}
/** @return whether a verb changes the opacity of tissues. */
static inline bool sc_verb_fades(sc_verb_kind kind)
{
    return kind <= SC_VERB_PULSE;
}

/** In which order tissues appear. Those of a direction begin with the tissue whose middle is the
 * furthest from there, so that the order runs that way. */
typedef enum sc_verb_order {
    SC_ORDER_LIST, /**< in the order of the job; of one pattern by rising label number */
    SC_ORDER_LARGEST,
    SC_ORDER_SMALLEST, /**< the first, by the number of voxels */
    SC_ORDER_RIGHT,
    SC_ORDER_LEFT,
    SC_ORDER_ANTERIOR,
    SC_ORDER_POSTERIOR,
    SC_ORDER_SUPERIOR,
    SC_ORDER_INFERIOR
} sc_verb_order;

/** All words for directions, each as WORD(word, order): of several for one direction first the one
 * that is written and listed. Signed axes are those of RAS. */
#define SC_DIRECTION_WORDS(WORD)                                                                   \
    WORD("right", RIGHT)                                                                           \
    WORD("left", LEFT)                                                                             \
    WORD("anterior", ANTERIOR)                                                                     \
    WORD("posterior", POSTERIOR)                                                                   \
    WORD("superior", SUPERIOR)                                                                     \
    WORD("inferior", INFERIOR)                                                                     \
    WORD("front", ANTERIOR)                                                                        \
    WORD("back", POSTERIOR)                                                                        \
    WORD("ventral", ANTERIOR)                                                                      \
    WORD("dorsal", POSTERIOR)                                                                      \
    WORD("cranial", SUPERIOR)                                                                      \
    WORD("caudal", INFERIOR)                                                                       \
    WORD("head", SUPERIOR)                                                                         \
    WORD("feet", INFERIOR)                                                                         \
    WORD("top", SUPERIOR)                                                                          \
    WORD("bottom", INFERIOR)                                                                       \
    WORD("x", RIGHT)                                                                               \
    WORD("-x", LEFT)                                                                               \
    WORD("y", ANTERIOR)                                                                            \
    WORD("-y", POSTERIOR)                                                                          \
    WORD("z", SUPERIOR)                                                                            \
    WORD("-z", INFERIOR)

/** The most verbs of an animation. */
enum { SC_VERBS_MAX = 100 };

/** The most points that a verb fly names. */
enum { SC_THROUGH_MAX = 64 };

/** A direction and a point that a verb may have. */
typedef struct sc_verb_line {
    bool has_axis, has_point; /**< the job gives them */
    sc_vec3 axis, point_mm;   /**< RAS; axis of unit length */
} sc_verb_line;

/** The way of a fly, and how the camera looks on it. */
typedef struct sc_fly {
    sc_vec3 through[SC_THROUGH_MAX]; /**< [through_count] points, RAS mm: of the curve or, with
                                        tissues, of the centre line of these */
    int through_count;
    bool has_tissues; /**< the way leads through tissues, not along points alone */
    bool middles;     /**< from the middle of a tissue to that of the next */
    double clearance; /**< sc_centerline_request.clearance */
    double ahead;     /**< 0 to 1: how far ahead the camera looks, as a share of its way */
    double fov_deg;   /**< vertical field of view */
} sc_fly;

/** A verb as the job asks for it; its tissues are listed apart from it. */
typedef struct sc_verb {
    sc_verb_kind kind;
    double begin, end; /**< when: 0 is the first frame of the animation and 1 the last; if they are
                            equal, it is done at once */
    sc_ease ease;
    double to;      /**< fade, pulse: an opacity from 0 to 1, or a factor; zoom: the scale; dolly:
                         what the distance is multiplied by */
    bool to_factor; /**< true: "to" multiplies the opacity of the tissue; false: it replaces it */
    sc_verb_order order; /**< appear */
    double stagger; /**< appear, 0 to 1: how much of the time that one takes passes before the next
                         begins; 1: one after the other, 0: all at once */
    int times;      /**< pulse, rock: how often, at least 1 */
    double angle_deg, elevation_deg; /**< orbit: how far the camera turns and rises; turn: how far
                                        the plane turns (angle_deg); rock: how far the camera
                                        swings to each side, up and down */
    int plane;                       /**< turn: the number of the clip plane, from 1 */
    bool together;                   /**< explode: the tissues move as one */
    sc_verb_line line;    /**< turn: the line about which the plane turns; explode: tissues move
                               along its axis, or away from its point; one of them is given */
    sc_plane_position by; /**< explode: how far, in mm, or in percent of the distance of a tissue's
                               middle from that point */
    double soft; /**< hold, 0 to 0.5: share of the time in which the camera comes to rest, and in
                      which it starts again */
    sc_fly fly;
    char where[SC_WHERE_BYTES]; /**< "file:line" for messages; may be empty */
} sc_verb;

/** A place on the way of a camera that flies, and how it looks from there. */
typedef struct sc_way_point {
    sc_vec3 at_mm;       /**< RAS */
    double around_mm;    /**< radius of the space around it; 0: not known */
    sc_vec3 forward, up; /**< unit, perpendicular */
} sc_way_point;
/** Places of one way, and points of a curve between two that it passes through. */
enum { SC_WAY_POINTS = 2049, SC_WAY_STEPS = 64 };

/** What a verb does to the camera, or to a clip plane. */
typedef struct sc_move {
    sc_verb verb;
    /** Of a frame: corners of its tissues, RAS mm, borrowed while a timeline is resolved. Of a fly,
     * the line that the camera follows; see sc_way_make. */
    const sc_vec3 *points;
    size_t point_count;
    const double *around_mm; /**< of a fly, with the points: see sc_way_make */
    int way;                 /**< of a fly, in a timeline: its index among the ways */
    /** Of a frame, in a timeline: what the camera looks at in the end, from where, and how much of
     * it it shows, as of sc_timeline.half_height; the last of a fly, too. */
    sc_vec3 target_mm;
    double distance_mm, half_height;
} sc_move;

/** Tissues that a job names for something. */
typedef struct sc_named_tissue {
    int of;                      /**< for what: the index of a verb, or an sc_tissue_use */
    char pattern[SC_NAME_BYTES]; /**< as sc_tissue_rule.pattern */
    char where[SC_WHERE_BYTES];  /**< "file:line" for messages; may be empty */
} sc_named_tissue;

/** The verbs of an animation with their tissues, and the key frames of tissues. Borrows all. */
typedef struct sc_verbs {
    const sc_verb *verbs; /**< [verb_count] */
    size_t verb_count;
    const sc_named_tissue *list; /**< [list_count], of verbs by their index, in their order */
    size_t list_count;
    const sc_track *tracks; /**< those that tissues name by their numbers; NULL: none does */
} sc_verbs;

/** What one verb does to one tissue; or what the offset of the tissue does, or the way from one of
 * its key frames to the next. */
typedef struct sc_change {
    int id; /**< dense id */
    sc_verb_kind kind;
    double begin, end; /**< when: 0 is the first frame of the animation and 1 the last; if they are
                            equal, it is done at once */
    sc_ease ease;
    sc_vec3 to;    /**< of SC_VERB_EXPLODE the final offset from its place, RAS mm; of other kinds
                      x is the final factor of its opacity, at least 0 */
    int times;     /**< pulse */
    bool replaces; /**< the opacity is the same then, whatever the key frames say that the tissue
                      has */
} sc_change;

/** An animation as the job asks for it. */
typedef struct sc_animation {
    int frames; /**< how many, at least 1 */
    sc_orbit camera;
    sc_sweep sweeps[SC_PLANES_MAX]; /**< [sweep_count] of them; sweep i moves plane i */
    int sweep_count;
    sc_clip_mode clip_mode;
    sc_slices slices;
    const sc_move *moves;  /**< [move_count] in any order, borrowed while a timeline is resolved */
    int move_count;        /**< at most SC_VERBS_MAX */
    const sc_vec3 *framed; /**< [framed_count] points that the camera shows as long as nothing else
                                is said, borrowed as the moves; NULL: the visible tissues */
    size_t framed_count;
} sc_animation;

/** What the looks of a film, and of its tissues, follow from. Borrows all; where light is NULL,
 * scenes have no look. */
typedef struct sc_looks {
    const sc_tissue *tissues; /**< [label_count] by dense id */
    int label_count;
    const sc_track *tissue_tracks; /**< those that tissues name by their numbers; NULL: none does */
    const sc_track *color_tones;   /**< the tones of those that are of colours, at the same numbers;
                                        NULL: none is */
    const sc_change *fades;        /**< [fade_count] of sc_verbs_resolve */
    size_t fade_count;
    const sc_change *shifts; /**< [shift_count] of sc_explodes_resolve */
    size_t shift_count;
    const double
        *column_values; /**< values that colours follow, [column_steps->count][label_count];
                             NULL: they follow none, or the same in all frames */
    const sc_track *column_steps; /**< which of these rows, from 0, and on the way to the next */
    const sc_color_scale *scale;
    const float *level_linear;           /**< [256]: levels of sRGB in linear light */
    const sc_lighting *light;            /**< what holds where there are no key frames */
    const sc_light_tracks *light_tracks; /**< those */
    const sc_background *background;     /**< whose colour is chosen */
    const sc_grey_tracks *grey;
    sc_grey_window grey_window; /**< in which the grey volume is shown, without key frames */
    int fps;
    const double *divider; /**< see sc_scene.divider; NULL: there is none */
    const sc_track *divider_track;
} sc_looks;

/** An animation in which all that depends on the volume is filled in: the framing of the camera and
 *  the positions of the planes in mm. Owns no memory. */
typedef struct sc_timeline {
    sc_animation animation;      /**< its camera has a target and a distance now */
    double at_mm[SC_PLANES_MAX]; /**< where planes lie along their normals, by sc_sweep.at */
    double half_height;          /**< as of sc_camera, before the zoom */
    sc_looks looks;              /**< set by the caller */
    sc_clip_set clip_sets[SC_CLIP_SETS_MAX]; /**< [clip_set_count] */
    int clip_set_count;
    sc_vec3 low_mm, high_mm;     /**< bounding box of the visible tissues, RAS */
    sc_move moves[SC_VERBS_MAX]; /**< [animation.move_count] of them, by the time at which they
                                      begin */
    const sc_way_point *ways;    /**< [SC_WAY_POINTS] for each fly, borrowed; set by the caller */
} sc_timeline;

/** Find the tissues of verb @p v that can be seen: out[id] is set for these and cleared for all
 * others. @param out [label_count] by dense id. @return how many there are. */
int sc_verb_members(const sc_prepared *volume, const sc_tissue *tissues, const sc_verbs *verbs,
                    size_t v, bool *out);

/** Find what verbs do to each tissue; those that move the camera do nothing.
 *  @param tissues [label_count] by dense id, resolved; fade_group of all is set, by verbs and key
 *  frames.
 *  @param out [*count], by rising id and, of one tissue, by the time at which they begin. Caller
 *  owns: sc_free.
 *  @return SC_ERR_DATA if nothing of the tissues of a verb is visible (all are logged);
 * SC_ERR_MEMORY. Nothing is written to @p out then. */
SC_MUST_USE sc_status sc_verbs_resolve(const sc_ctx *ctx, const sc_prepared *volume,
                                       sc_tissue *tissues, const sc_verbs *verbs, sc_change **out,
                                       size_t *count);

/** Find how the verbs explode and offsets move each tissue, and which move together: sets part of
 *  all.
 *  @param tissues [label_count] by dense id, resolved. @param verbs have passed sc_verbs_resolve.
 *  @param out [*count], as of sc_verbs_resolve. @return SC_ERR_DATA if there are more than
 * SC_PARTS_MAX parts (logged), SC_ERR_MEMORY. Nothing is written to @p out then. */
SC_MUST_USE sc_status sc_explodes_resolve(const sc_ctx *ctx, const sc_prepared *volume,
                                          sc_tissue *tissues, const sc_verbs *verbs,
                                          sc_change **out, size_t *count);
/** @return corner @p i, as of sc_box3_corner, of the box around a tissue in its place, RAS mm. */
sc_vec3 sc_tissue_corner(const sc_prepared *volume, int id, int i);
/** Find the corners of the boxes around tissues where each shift has brought them when it ends.
 *  @param shifts [count] of sc_explodes_resolve. @param out room for 8 @p count points, RAS mm. */
void sc_shifts_reach(const sc_prepared *volume, const sc_change *shifts, size_t count,
                     sc_vec3 *out);
/** Find the corners of the boxes around those tissues that are away from their places at a time, 0
 *  to 1, where they are then. @param shifts, out as of sc_shifts_reach.
 *  @return the number of points: 8 for each of these tissues. */
size_t sc_shifts_reach_at(const sc_prepared *volume, const sc_change *shifts, size_t count,
                          double time, sc_vec3 *out);
/** Find a smooth curve through points: a centripetal Catmull-Rom spline. @param through [count], at
 *  least 2, RAS mm, no two after each other the same. @param out room for
 *  (count - 1) SC_WAY_STEPS + 1 points. @return how many there are. */
size_t sc_way_curve(const sc_vec3 *through, int count, sc_vec3 *out);
/** Find the way of a camera along a line, of even speed. It looks at a place further along the
 *  line; what is up is carried along without turning about the direction of view (parallel
 *  transport), so that the picture never flips. It begins with the patient's head, or front, up.
 *  @param points [count] of the line, at least 1, RAS mm. @param around_mm [count] the radius of
 * the space around each, of which the mean over a part of the line is taken, so that it changes
 *  smoothly; NULL: not known. @param ahead how far ahead it looks, as a
 *  share of the line, 0 to 1. @param out [SC_WAY_POINTS]. */
void sc_way_make(const sc_vec3 *points, const double *around_mm, size_t count, double ahead,
                 sc_way_point *out);

/** Write a copy of @p animation to @p out, with what it leaves open filled in from the extent of
 * the visible tissues, and with its moves, which it does not point to any more. One framing holds
 * for the whole orbit, and for the tissues as they are without clip planes, so that the scale of
 * the picture stays the same. There is one clip set, which holds all planes; the caller replaces
 * clip_sets where tissues are excepted.
 *  @param points among which are the corners of the visible tissues (sc_hull_points); with none, a
 *  box of 1 mm at the origin is framed. @param aspect width of the picture divided by its height.
 */
void sc_timeline_resolve(const sc_animation *animation, const sc_vec3 *points, size_t point_count,
                         double aspect, sc_timeline *out);
/** @return the scene of frame @p k in [0, frames); between two frames @p k is not whole, and with a
 * shutter the first and the last are open beyond their times, where what has an end stays as it is
 * there. Its slice is false. It holds the planes that
 * cut then alone, in their order. An orbit of one turn in N
 * frames stands at 360 k / N degrees, so that no direction comes twice when the video loops. Ramps
 * reach their end in the last frame. @param room as of the label count of sc_looks, for colours,
 * opacities and places of tissues, which the scene borrows; NULL: it says nothing of these. */
sc_scene sc_timeline_scene(const sc_timeline *timeline, double k, const sc_scene_room *room);
/** @return at how many moments a frame with motion blur is drawn: so often that what is visible
 * moves by about a pixel at most from one to the next, but not more than SC_MOMENTS_MAX times; 1 if
 * the shutter is not open, or nothing moves. A power of two, if the camera has an aperture. It
 * depends on the scenes alone. What only changes its colour or opacity does not move: its mean is
 * as it is in the middle. @param points [count] some of what is visible, RAS mm, among them its
 * outermost.
 * @param height_px of the picture in space. */
int sc_timeline_moments(const sc_timeline *timeline, int k, const sc_vec3 *points, size_t count,
                        int height_px);
enum { SC_MOMENTS_MAX = 64 };
/** @return the time, as a frame that need not be whole, of moment @p i of @p moments of frame @p k.
 */
double sc_timeline_moment(const sc_timeline *timeline, int k, int i, int moments);

/** @return the share of its way, 0 to 1, that what happens in the part [begin, end] of an animation
 * (see sc_verb) has covered at a time, 0 to 1. */
double sc_progress(double begin, double end, sc_ease ease, double at);
/** @return how much of the way is done, 0 to 1. @param u how much of the time has passed, 0 to 1;
 * not clamped. */
double sc_ease_value(sc_ease ease, double u);
/** @return the number that a track gives at a time, 0 to 1; without key frames @p constant. */
double sc_number_at(const sc_track *track, double constant, double at);
/** The same for all three numbers of a track. */
sc_vec3 sc_value_at(const sc_track *track, sc_vec3 constant, double at);
/** @return the greatest number, at least 0, of a track; without key frames @p constant. */
double sc_track_most(const sc_track *track, double constant);
/** @return the value of the last key frame that is not behind a time, or of the first: of values
 * that jump, such as true and false. @param at the time, 0 to 1. */
sc_vec3 sc_track_step(const sc_track *track, double at);
/** @return the value of a track that has key frames. @param at the time, 0 to 1. */
sc_vec3 sc_track_value(const sc_track *track, double at);
/** Turn key frames of colours, whose values are levels of sRGB, into such of tones: the square
 * roots of linear light. So that all ranks mix the same bits, one of them turns them, and sends
 * them. */
void sc_track_tones(const sc_track *levels, sc_track *tones);
/** Find the colour of a track of tones, in linear light. Tones are mixed as rays are blended, so
 * that the way from one colour to another looks even. @param at the time, 0 to 1. */
void sc_track_color(const sc_track *tones, double at, float linear[3]);
/** Find where a camera without an orbit (sc_orbit.fixed) is by its key frames alone, without the
 * verbs that move it. Without key frames of up it is upright at the key frames, and does not flip
 * where it looks along up. @param at the time, from 0, the beginning of the film, to 1, its end.
 * @param position_mm, target_mm, up the results, as the members of sc_orbit with these names. */
void sc_fixed_camera_at(const sc_orbit *camera, double at, sc_vec3 *position_mm, sc_vec3 *target_mm,
                        sc_vec3 *up);
/** @return the light at a time, 0 to 1. @param light what holds where there are no key
 * frames. */
sc_lighting sc_light_at(const sc_lighting *light, const sc_light_tracks *tracks, double at);
/** @return the light by which a renderer of all frames is made: @p light with the strongest
 * occlusion and the darkest shadows of any of them. */
sc_lighting sc_light_of_all(const sc_lighting *light, const sc_light_tracks *tracks);
/** @return the value of a track of unit directions, no two of which that follow each other are
 * opposite: each turns to the next the shortest way, evenly but for the ease. @param at the time, 0
 * to 1. */
sc_vec3 sc_track_direction(const sc_track *track, double at);
/** @return the time of frame @p k of @p frames: 0 for the first, 1 for the last. @param k need not
 * be whole. */
double sc_frame_time(double k, int frames);
/** @return the unit direction, in RAS, of SC_ORDER_RIGHT to SC_ORDER_INFERIOR. */
sc_vec3 sc_order_direction(sc_verb_order order);
/** Find the unit direction, in RAS, that one of SC_DIRECTION_WORDS stands for, case ignored.
 * @return false if it is no such word; @p out is not written then. */
bool sc_anatomical_direction(const char *word, sc_vec3 *out);
/** @return SC_DIRECTION_WORDS, [*count], for messages; static. */
const char *const *sc_anatomical_words(size_t *count);

/* ---- shots ---- */

/** The most shots of a film. */
enum { SC_SHOTS_MAX = 100 };

/** How a shot follows the one before it. */
typedef enum sc_transition {
    SC_TRANSITION_CUT,        /**< at once */
    SC_TRANSITION_CROSS_FADE, /**< its beginning lies over the end of the other, and replaces it
                                   step by step */
    SC_TRANSITION_FADE /**< the other fades to the background, and then it appears from there */
} sc_transition;

/** When a shot is seen. */
typedef struct sc_shot_span {
    int frames; /**< of the shot, at least 1 */
    sc_transition transition;
    int transition_frames; /**< at least 1, but 0 of a cut; of a cross-fade as many of both shots,
                                which are shown at the same time; of a fade, half of them belong to
                                the shot before, if there is one, and the rest to this one */
    int fade_out_frames;   /**< in which it fades to the background at its end; only if a cut or
                                the end of the film follows */
    int first;             /**< frame of the film that is the shot's first: of sc_shots_place */
} sc_shot_span;

/** Fill in where the shots [count] begin, one after the other. The first does not begin with a
 *  cross-fade. @return how many frames the film has. */
int sc_shots_place(sc_shot_span *shots, int count);
/** @return how many frames of shot @p i of @p count belong to the transitions at its beginning and
 *  its end: it must have at least as many, so that no more than two shots meet in a frame. */
int sc_shot_transitions(const sc_shot_span *shots, int count, int i);

/** What a frame of a film shows. */
typedef struct sc_film_frame {
    int shot, frame;          /**< index of the shot, and number of the frame within it */
    int before, before_frame; /**< in a cross-fade: the same of the shot before; otherwise -1, 0 */
    float share; /**< of the shot's picture, more than 0, up to 1; the rest is that of the shot
                      before, or, without one, the background */
} sc_film_frame;
/** @return what frame @p k of a film shows: a closed function of k. @param shots [count], placed.
 */
sc_film_frame sc_film_frame_at(const sc_shot_span *shots, int count, int k);

/* ---- beats ---- */

/** How the phases of a beating heart, which are volumes of the same grid, follow each other. */
typedef struct sc_cine {
    double bpm;  /**< beats per minute, above 0; in one, all phases are shown */
    int beats;   /**< after so many the last phase stays; 0: they go on and on */
    int between; /**< number of interpolated phases after each phase of the files; those after the
                      last lead to the first of the next beat. When the beats have ended, the last
                      phase of the files stays, not an interpolated one */
} sc_cine;
/** @return which phase, from 0, frame @p k of a film shows: a closed function of k. Phase p of n is
 *  shown from p / n of a beat on. @param phases at least 1, interpolated ones among them. @param
 * fps frames per second. */
int sc_cine_phase(const sc_cine *cine, int phases, int fps, int k);

#endif
