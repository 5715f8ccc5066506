/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  A job: what is to be drawn, from which volume and to where, read from a YAML file, the
 * environment and the command line, and written back as resolved. Local functions; nothing is
 * collective. */
#ifndef SEGCAST_JOB_H
#define SEGCAST_JOB_H

#include "segcast/annotate.h"
#include "segcast/color_by.h"
#include "segcast/farm.h"
#include "segcast/render.h"
#include "segcast/timeline.h"

/** Longest path in a job, terminator included, the most frames of an animation, and the most phases
 * of a beat. */
enum { SC_PATH_BYTES = 4096, SC_JOB_FRAMES_MAX = 1000000, SC_PHASES_MAX = 1000 };

/** Columns of a table of values by key frames. */
typedef struct sc_column_track {
    sc_track
        steps; /**< their values are indices of columns: 0, 1, 2 … in x; count 0: there are none */
    char columns[SC_KEY_FRAMES_MAX][SC_NAME_BYTES]; /**< [steps.count] headings */
} sc_column_track;

/** Whether frames are also written one by one. */
typedef enum sc_frames_kind { SC_FRAMES_NONE, SC_FRAMES_PNG } sc_frames_kind;

/** What a frame shows: one picture, three slices beside it, or several volumes side by side or on
 * both sides of a divider (views.h). */
typedef enum sc_layout { SC_LAYOUT_PICTURE, SC_LAYOUT_VIEWS, SC_LAYOUT_COMPARE } sc_layout;

/* Members that hold an enum are of type int: the table of keys stores numbers there. */

/** What is written, and where. */
typedef struct sc_output {
    char directory[SC_PATH_BYTES];
    char video[SC_PATH_BYTES]; /**< name in the directory, or "none" */
    char title[256];           /**< of the film, in the video's metadata; empty: none */
    char author[256];          /**< likewise */
    int size_px[2];            /**< width, height */
    int fps;
    int frames;      /**< sc_frames_kind */
    int codec;       /**< sc_codec */
    int crf, preset; /**< for the encoder; sc_job_preset gives the preset's name */
    int layout;      /**< sc_layout; it follows from compare and animation.slices */
} sc_output;

/** What pictures are for: more rays for each pixel make them better, and take longer. */
typedef enum sc_quality { SC_QUALITY_DRAFT, SC_QUALITY_FILM, SC_QUALITY_STILL } sc_quality;
/** Added to an sc_opacity_rule: by the thickness at each point, instead of the mean of the tissue.
 */
enum { SC_OPACITY_LOCAL = 2 };
/** How faces cut by clip planes are drawn. */
typedef enum sc_caps { SC_CAPS_NONE, SC_CAPS_SOLID } sc_caps;

/** A picture in place of the sky. */
typedef struct sc_environment {
    char file[SC_PATH_BYTES]; /**< empty: none */
    double turn_deg;          /**< by which it is turned to the right */
} sc_environment;

/** How pictures are drawn; see sc_render_settings. */
typedef struct sc_render_options {
    int surface;            /**< sc_surface */
    int skip;               /**< sc_skip */
    int cpu;                /**< index into sc_cpu_names */
    int caps;               /**< sc_caps */
    int stage;              /**< sc_ground */
    bool early_termination; /**< rays end behind what is opaque, instead of going on to their end */
    int quality;            /**< sc_quality */
    int auto_opacity;       /**< sc_opacity_rule, and SC_OPACITY_LOCAL */
    sc_vec3 smooth;         /**< see sc_prepare_settings; or auto, on the grid of the drawing:
                                 sc_smooth_is_auto */
    double step_voxels, cap_outline;
    sc_background background;
} sc_render_options;

/** Along all axes: the strength of smoothing is chosen by the volume. */
#define SC_SMOOTH_IS_AUTO (-1)
/** @return whether a job's strength of smoothing is auto. */
static inline bool sc_smooth_is_auto(sc_vec3 smooth)
{
    return smooth.x < 0;
}

/** Who encodes: rank 0 alone, or all ranks, each a GOP at a time; auto chooses by their number. The
 *  bytes of the video are the same. With gather, ranks draw frames, and some of them encode. */
typedef enum sc_encode {
    SC_ENCODE_AUTO,
    SC_ENCODE_ROOT,
    SC_ENCODE_SEGMENTS,
    SC_ENCODE_GATHER
} sc_encode;

/** How the work is shared out between ranks; see sc_farm. */
typedef struct sc_farm_options {
    int partition; /**< sc_partition */
    int tile_px;
    int encode; /**< sc_encode */
    bool share; /**< ranks on rank 0's node draw into its memory */
} sc_farm_options;

/** Tissues that a job keeps of its volume, or makes one of. */
typedef struct sc_volume_tissue {
    char pattern[SC_NAME_BYTES]; /**< as sc_tissue_rule.pattern */
    char into[SC_NAME_BYTES];    /**< name of the tissue that it becomes a part of; empty: it is
                                      kept, and what no pattern keeps is left out */
    char where[SC_WHERE_BYTES];  /**< "file:line" for messages; may be empty */
} sc_volume_tissue;

/** Which part of the volume a job reads and draws. */
typedef struct sc_box {
    int kind;           /**< sc_read_box */
    int voxels[3][2];   /**< SC_READ_VOXELS: as sc_read_choice.voxels */
    sc_vec3 corners[2]; /**< SC_READ_MM: as sc_read_choice.corners */
    bool visible;       /**< of that, only what lies around the tissues that are shown */
    double margin_mm;   /**< with so much around them */
} sc_box;

/** The most subjects of a comparison: the volume of the job and others. */
enum { SC_SUBJECTS_MAX = 4 };
/** A volume that is compared with that of the job. */
typedef struct sc_subject {
    char volume[SC_PATH_BYTES]; /**< as sc_volume_options.path */
    char labels[SC_PATH_BYTES]; /**< likewise; empty: that of the job */
    char image[SC_PATH_BYTES];  /**< its grey volume; empty: that of the job; "none": it has none */
    bool has_name;
    char name[SC_CAPTION_BYTES]; /**< as sc_caption.text, if has_name */
    char where[SC_WHERE_BYTES];  /**< "file:line" for messages; may be empty */
} sc_subject;
/** Where subjects stand: all with the middle of what is shown of them in one point, or as their
 * files place them. */
typedef enum sc_align { SC_ALIGN_CENTER, SC_ALIGN_NONE } sc_align;
/** A comparison of the volume of the job, its first subject, with others: all are drawn in the same
 * way, at the same scale, from the same camera. */
typedef struct sc_comparison {
    sc_subject others[SC_SUBJECTS_MAX - 1]; /**< [count] of them */
    int count;
    bool has_name;
    char name[SC_CAPTION_BYTES]; /**< of the first subject, if has_name */
    char where[SC_WHERE_BYTES];  /**< of the comparison, for messages */
    int align;                   /**< sc_align */
    bool has_divider;            /**< both subjects fill the picture, one beside the other */
    double divider; /**< where the first ends, as a share of the width of the picture, 0 to 1 */
    sc_track divider_track; /**< key frames; if it has any, they replace divider */
} sc_comparison;

/** The volume of one phase of a beat. */
typedef struct sc_volume_path {
    char path[SC_PATH_BYTES];
    int phase; /**< as of sc_read_choice: which of those in the file, from 1; 0: it holds one */
} sc_volume_path;

/** How a series of volumes is shown. */
typedef struct sc_cine_options {
    sc_cine cine;
    char phases[256]; /**< a list of phases, written like one of frames; empty once a job is loaded
                           whose phases are files */
    char where[SC_WHERE_BYTES]; /**< "file:line" of the series, for messages; may be empty */
} sc_cine_options;

/** The grey volume of a job. */
typedef struct sc_grey_options {
    char path[SC_PATH_BYTES];
    bool window_auto; /**< shown.window is to be found in the image */
    sc_grey_tracks shown;
} sc_grey_options;

/** Sets of values for keys that a job does not give; they are in the job once it is loaded. */
typedef enum sc_look_name {
    SC_LOOK_PLAIN,
    SC_LOOK_STUDIO,
    SC_LOOK_CINEMATIC,
    SC_LOOK_ATLAS,
    SC_LOOK_XRAY
} sc_look_name;

/** The volume of a job, and what of it is read. */
typedef struct sc_volume_options {
    char path[SC_PATH_BYTES];  /**< or "phantom", or "phantom:WxDxH"; of a series that of the first
                                    phase */
    sc_volume_path *phases;    /**< [phase_count], owned: the volumes of a series, in their order */
    size_t phase_count;        /**< 0: there is one volume */
    sc_volume_tissue *tissues; /**< [tissue_count], owned: first those that become parts of others,
                                    then those that are kept */
    size_t tissue_count;
    sc_box box;
    char header[160];      /**< as sc_read_choice.header */
    double threshold;      /**< as sc_read_choice.threshold */
    int level;             /**< of resolution, 0 the finest */
    int phase;             /**< as of sc_read_choice; of a series that of the first phase */
    double resample_mm[3]; /**< along x, y, z; if given.volume_size, not read */
    int size[3];           /**< if given.volume_size: voxels along x, y, z, by nearest label */
    bool is_replaced;      /**< a setting replaced the path to which other keys of volume belong */
    char labels[SC_PATH_BYTES];                 /**< label table; empty: from the volume */
    int labels_format;                          /**< sc_table_format */
    int overlap;                                /**< sc_overlap */
    char overlap_names[SC_OVERLAP_NAMES_BYTES]; /**< SC_OVERLAP_NAMES: as of sc_read_choice */
    int appearance;                             /**< sc_appearance */
} sc_volume_options;

/** What a job says of tissues of its volume. */
typedef struct sc_tissue_options {
    sc_tissue_rule *rules; /**< [rule_count], owned */
    size_t rule_count;
    size_t film_rules; /**< of a shot's job: how many of the rules are the film's; they come first.
                            0 for a job that is not a shot's */
    sc_track *tracks;  /**< [track_count], owned: key frames of the rules; those of colours are of
                            levels of sRGB */
    size_t track_count;
    sc_clip_exception *exceptions; /**< [exception_count], owned */
    size_t exception_count;
} sc_tissue_options;

/** The verbs of an animation. */
typedef struct sc_verb_options {
    sc_verb *list; /**< [count], owned */
    size_t count;
    sc_named_tissue *tissues; /**< [tissue_count], owned, in the order of the verbs */
    size_t tissue_count;
} sc_verb_options;

/** The shots of a film, and the duration of its animation. */
typedef struct sc_film_options {
    struct sc_shot *shots; /**< [shot_count], owned: then the film consists of them,
                                animation.frames is its length, and the rest of animation and
                                overlays the default */
    size_t shot_count;
    double duration_s; /**< if given.duration */
} sc_film_options;

/** Which keys stand in a job. Members for a key that does not are not to be read. */
typedef struct sc_given_keys {
    bool cine; /**< then there are two phases or more */
    bool box, header, level, threshold, resample, volume_size; /**< of volume; volume_size is a way
                                                                    of resample */
    bool phase;                               /**< volume.phase stands in the job itself */
    bool merge, keep, verbs, captions, shots; /**< these lists, even if they are empty */
    bool names, legend_tissues;               /**< likewise, of overlays */
    bool logo, color_by, image;               /**< overlays.logo, color_by, image */
    bool compare;                             /**< several volumes are compared */
    bool duration; /**< of animation.frames; false once a job is loaded */
} sc_given_keys;

/** "file:line: key" of keys that are judged after the job is loaded, for messages; may be empty. */
typedef struct sc_key_lines {
    char volume[SC_WHERE_BYTES], image[SC_WHERE_BYTES], tissues[SC_WHERE_BYTES];
    char volume_box[SC_WHERE_BYTES]; /**< of header, level or box */
    char directory[SC_WHERE_BYTES], video[SC_WHERE_BYTES], size[SC_WHERE_BYTES],
        fps[SC_WHERE_BYTES];                  /**< of output */
    char zoom[SC_WHERE_BYTES];                /**< of animation.camera */
    char clip[SC_PLANES_MAX][SC_WHERE_BYTES]; /**< of each plane of animation.clip */
} sc_key_lines;

/** The light of a job. */
typedef struct sc_light_options {
    sc_lighting constant;
    sc_light_tracks tracks; /**< which replace members of it */
    sc_environment environment;
} sc_light_options;

/** A job. Plain data but for its arrays, so that it can be sent to other ranks. */
typedef struct sc_job {
    sc_volume_options volume;
    sc_given_keys given;
    sc_key_lines lines;
    sc_cine_options cine;
    int look; /**< sc_look_name */
    sc_comparison compare;
    sc_color_by color_by;
    sc_column_track color_columns; /**< key frames, which replace color_by.column; values between
                                        two of them lie between those of their columns */
    sc_grey_options image;
    sc_output output;
    sc_render_options render;
    sc_light_options light;
    sc_animation animation;
    sc_verb_options verbs;
    sc_overlays overlays;
    sc_overlay_lists overlay_lists;
    sc_farm_options farm;
    sc_tissue_options tissues;
    sc_film_options film;
} sc_job;

/** How long something of a film takes. */
typedef struct sc_length {
    double value;
    bool in_frames; /**< false: in seconds */
} sc_length;

/** How a shot follows the one before: by a cut, unless one of the others is chosen. */
typedef struct sc_shot_transition {
    sc_transition kind;
    sc_length length; /**< unless it is a cut */
} sc_shot_transition;

/** A shot of a film. */
typedef struct sc_shot {
    sc_job job;     /**< what is drawn in it, resolved: the keys of the film and of the shot. What
                         holds for the whole film (sc_key_scope.of_film) is in the film's job. It has no
                         shots. Has to be the first member */
    char name[256]; /**< empty: none */
    sc_shot_transition transition;
    bool has_fade_out; /**< it fades to the background at its end */
    sc_length fade_out;
    bool has_card; /**< it shows the card, and no volume */
    sc_card card;
    sc_shot_span span;          /**< when in the film it is shown */
    char where[SC_WHERE_BYTES]; /**< "file:line" for messages; may be empty */
} sc_shot;

/* ---- times ---- */

/** Read a time: minutes and seconds, "0:10", or hours, too, "1:00:10", or a number with its unit
 * ms, s, min, or without one, which is seconds, too. @return false if @p text is anything else. */
bool sc_parse_seconds(const char *text, double *seconds);

/** A key and its value from outside of the job file. All strings are borrowed. */
typedef struct sc_setting {
    const char *origin; /**< what messages name, for example "--zoom 2" */
    const char *path;   /**< "render.quality" */
    const char *value;  /**< YAML, or any text if literal is set */
    bool literal;       /**< the value is used as it is, without being parsed as YAML */
} sc_setting;

/** Where the parts of a job come from. The later of these win: the defaults of the table,
 * `defaults`, the file, the environment, `settings`. */
typedef struct sc_job_sources {
    const char *path;           /**< job file; NULL: none */
    const char *text;           /**< what stands in it, which is not read then; NULL: it is read */
    const char *name;           /**< what messages call a job without a file; NULL: command line */
    const sc_setting *defaults; /**< [default_count] */
    size_t default_count;
    const sc_setting *settings; /**< [setting_count], of the command line */
    size_t setting_count;
    const char *const *environment; /**< "SEGCAST_RENDER_QUALITY=draft", ended by NULL; or NULL */
    bool no_video;     /**< no video is made: the job may ask for one that cannot be made */
    bool check_inputs; /**< a volume or label table that does not exist is a mistake of the job */
} sc_job_sources;

/** Read, check and resolve a job. Paths to something that exists become absolute; other paths of
 * the file become relative to the working directory. All mistakes are logged, each with file and
 * line, as far as the text can be read as YAML; the first of them is returned.
 *  @param out written also after SC_ERR_USAGE, SC_ERR_DATA or SC_ERR_MISSING: all that was right,
 * so that the caller can look for mistakes against the volume; it must not be drawn then.
 *  @return SC_ERR_USAGE, SC_ERR_DATA or SC_ERR_MISSING; SC_ERR_MEMORY, with @p out untouched.
 * Caller owns: sc_job_clear. */
SC_MUST_USE sc_status sc_job_load(const sc_ctx *ctx, const sc_job_sources *sources, sc_job *out);
/** Free the arrays; harmless on a zeroed struct. */
void sc_job_clear(sc_job *job);
/** How many arrays a job has. */
enum { SC_JOB_ARRAYS = 10 };
/** @return array number @p i of a job. @param count how many elements it has, @param bytes and of
 * what size. */
void *sc_job_array(const sc_job *job, int i, size_t *count, size_t *bytes);
/** Let array number @p i of a job, which may point anywhere, be another one of as many elements. */
void sc_job_set_array(sc_job *job, int i, void *array);
/** Append the job to @p text as YAML, every key with its value; sc_job_load reads it back as the
 * same job. @param identity only keys on which the pictures depend. @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_job_write(const sc_ctx *ctx, const sc_job *job, bool identity,
                                   sc_text *text);
/** Append a table of all key frames of a job to @p out: a line for each, of its parameter (as for
 *  --set, with the first one only), its frame, its value, and its ease unless that is linear; shot
 * by shot. Nothing if there are none. @param most lines that are shown; then one says how many more
 *  there are. @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_job_list_key_frames(const sc_ctx *ctx, const sc_job *job, int most,
                                             sc_text *out);
/** Append the job to @p text as a JSON object with the keys and values that sc_job_write writes:
 *  numbers and truth values as such, all others as strings. @return SC_ERR_MEMORY; SC_ERR_DATA, not
 * logged, if a path is not UTF-8. */
SC_MUST_USE sc_status sc_job_write_json(const sc_ctx *ctx, const sc_job *job, sc_text *text);
/** Append what stands in a job to @p text as JSON: the keys that its sources give, as they write
 * them, in their order, without defaults. @return as sc_job_load, but what the values are is not
 * checked; SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_job_write_tree(const sc_ctx *ctx, const sc_job_sources *sources,
                                        sc_text *text);
/** Append the text of a job file in which the value of a key is another one, and all else stands as
 * it did: comments, order, quotes. @param text read before without a mistake. @param setting its
 * value is written between braces if there are some. @return SC_ERR_USAGE for a path that is none;
 * SC_ERR_DATA; SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_job_rewrite(const sc_ctx *ctx, const char *text, const sc_setting *setting,
                                     sc_text *out);
/** @return whether a frame of the job, or of one of its shots, has the layout views. */
bool sc_job_has_views(const sc_job *job);
/** Append @p value to @p text as a value or key of YAML: in double quotes, with all escapes that
 *  YAML needs. @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_write_quoted(const sc_ctx *ctx, const char *value, sc_text *text);
/** @return the rule of automatic opacity, without SC_OPACITY_LOCAL. */
static inline sc_opacity_rule sc_job_opacity_rule(const sc_job *job)
{
    return (sc_opacity_rule)(job->render.auto_opacity & ~SC_OPACITY_LOCAL);
}
/** @return the word of farm.encode for one of its values. */
const char *sc_job_encode_word(int encode);
/** @return the name of the encoder preset, for example "medium". */
const char *sc_job_preset(const sc_job *job);
/** @return whether sc_job.volume.path names the built-in phantom, and not a file. */
bool sc_job_is_phantom(const char *volume);

/* ---- the table of keys ---- */

/** A row of the table. Strings are borrowed for the time of the call. */
typedef struct sc_key_info {
    const char *path;     /**< "animation.clip.N.plane.at": N is an index, NAME a tissue */
    const char *help;     /**< one line, without a full stop */
    const char *option;   /**< command-line option that sets the key; NULL: none */
    const char *argument; /**< what the option's help calls its value */
    const char *commands; /**< names of the commands that have the option, separated by spaces */
    bool is_value;        /**< a value can stand there, not only a map */
} sc_key_info;
/** Call @p visit for every row, maps before their keys. Stops at the first error and returns it. */
SC_MUST_USE sc_status sc_job_each_key(const sc_ctx *ctx,
                                      sc_status (*visit)(void *user, const sc_key_info *info),
                                      void *user);

/** How sc_keys_describe describes the keys. */
typedef enum sc_keys_format {
    SC_KEYS_TABLE,    /**< for people, at a terminal */
    SC_KEYS_JSON,     /**< an array with an object for each key */
    SC_KEYS_MARKDOWN, /**< docs/job.md */
    SC_KEYS_SCHEMA,   /**< JSON schema (draft 7) of a job file */
    SC_KEYS_STUDY,    /**< JSON schema (draft 7) of a study file */
    SC_KEYS_MAN       /**< segcast-job(5) */
} sc_keys_format;
/** Append a description of all keys to @p out. @param prefix only keys whose path begins with it;
 * NULL: all. It is used by SC_KEYS_TABLE and SC_KEYS_JSON only. @return SC_ERR_USAGE if no key
 * begins with it, SC_ERR_MEMORY. Caller owns: sc_text_clear, also after an error. */
SC_MUST_USE sc_status sc_keys_describe(const sc_ctx *ctx, const char *prefix, sc_keys_format format,
                                       sc_text *out);

/* ---- frame lists ---- */

/** Read a list such as "0-35:2,40": whole numbers in [0, total), each once, in rising order
 * (grammar: IntRangeExpr of the Open Job Description). @param text NULL: all frames.
 *  @return SC_ERR_USAGE. Caller owns *out: sc_free. */
SC_MUST_USE sc_status sc_frames_parse(const sc_ctx *ctx, const char *text, int total, int **out,
                                      int *count);

/** Read a list as of sc_frames_parse, in the order in which it names the numbers. @param text not
 *  NULL. @return SC_ERR_USAGE, SC_ERR_MEMORY. Caller owns *out: sc_free. */
SC_MUST_USE sc_status sc_frames_parse_order(const sc_ctx *ctx, const char *text, int total,
                                            int **out, int *count);

/** List the frames of slice @p i of @p n, in rising order. A slice holds whole GOPs of @p gop
 * frames, so that no two slices share one. @param total frames of the animation. @return
 * SC_ERR_MEMORY. Caller owns *out: sc_free. */
SC_MUST_USE sc_status sc_frames_slice(const sc_ctx *ctx, int i, int n, int gop, int total,
                                      int **out, int *count);

#endif
