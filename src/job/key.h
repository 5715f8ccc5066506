/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to job: the rows of the tables that describe a job file, and the types of their values.
 *
 * A table is an array of sc_key, ended by a row without a name; it describes one map of the file
 * and is read into one C struct. Reading, defaults, writing, settings of the command line and of
 * the environment, `segcast help keys`, the JSON schema and the manual page all walk the same rows.
 */
#ifndef SC_JOB_KEY_H
#define SC_JOB_KEY_H

#include "segcast/job.h"
#include "yaml/yaml_tree.h"

#include <jansson.h>

typedef struct sc_key sc_key;

enum { SC_WORDS_MAX = 160 }; /* of which a value may be one */

/* How a value holds further values. */
typedef enum sc_container {
    SC_CONTAINER_NONE, /* it holds none: a single value, or a list of fixed length */
    SC_CONTAINER_MAP,  /* a map with the keys of sc_key.keys */
    SC_CONTAINER_LIST, /* any number of maps with the keys of sc_key.keys, addressed by index */
    SC_CONTAINER_DICT  /* maps with the keys of sc_key.keys, under names that the user chooses */
} sc_container;

/* A type of value: how values are read, written and described. The argument @p value is the address
 * of the value itself in the struct of the table (its base plus sc_key.offset). */
typedef struct sc_value_type {
    const char *name;     /* for listings, for example "whole number" */
    const char *expected; /* for error messages, for example "a whole number" */
    /* Check @p node and store it in @p value; logs what is wrong with file and line. */
    sc_status (*read)(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value);
    const struct sc_value_type *of_key_frames; /* the type of the values of key frames, each in an
                                                  sc_vec3; NULL: a number */
    const struct sc_value_type *constant; /* of a value that may have key frames: its type without
                                             them; NULL: that of the values of key frames */
    /* Of such a value: set what follows for @p value from its key frames, which have been read.
     * NULL: nothing does. @return the mistake, which is logged. */
    sc_status (*take_track)(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value);
    bool steps; /* of values of key frames: there is nothing between two of them, so that the first
                   holds until the time of the second; there is no ease */
    /* Append the value to @p text as YAML that `read` accepts, in one line. NULL: the keys of the
     * map are written as lines of their own. */
    sc_status (*write)(const sc_ctx *ctx, const sc_key *key, const void *value, sc_text *text);
    /* The same for a value of many lines: it begins behind the colon of its key, before which stand
     * @p indent blanks, and its last line ends. @p parts as of sc_keys_write. NULL: write says how.
     */
    sc_status (*write_lines)(const sc_ctx *ctx, const sc_key *key, const void *value, int indent,
                             unsigned parts, sc_text *text);
    /* Fill @p words, which has room for SC_WORDS_MAX, with the words that the value may be, but for
     * those that the schema names itself. NULL: there are none. @return their number. */
    size_t (*list_words)(const sc_key *key, const char **words);
    /* The JSON schema of the value, by which editors check it: YAML, as of sc_type_schema. */
    const char *schema;
    sc_container container;
} sc_value_type;

/* A word of the job file and the number that stands for it in the struct. */
typedef struct sc_choice {
    const char *word; /* NULL ends a list */
    int value;
} sc_choice;

/* A command-line option that sets the key; see sc_key_info. */
typedef struct sc_key_option {
    const char *name, *argument, *commands;
} sc_key_option;

/* A single value that stands for a map. */
typedef struct sc_shorthand {
    const char *key; /* the value is that of this key, the only one of the map; NULL: none does */
    bool keeps;      /* a setting of a single value changes that key of a map, and keeps the others;
                        else it replaces the map */
} sc_shorthand;

/* What a key holds for. */
typedef struct sc_key_scope {
    bool outside_identity; /* pictures do not depend on it: it is not part of the identity */
    bool of_film;          /* it holds for the whole film: shots cannot have it for themselves */
    bool of_job;           /* of a shot: a key of the job, merged over that of the film */
    unsigned verbs; /* of a key of some verbs only: a bit for each sc_verb_kind that has it */
} sc_key_scope;

/* A row of a table: one key of a map. */
struct sc_key {
    const char *name; /* NULL ends a table */
    const sc_value_type *type;
    size_t offset;            /* where the value lies in the struct of the table */
    const char *fallback;     /* the default as YAML; NULL: nothing is stored without the key */
    const char *help;         /* one line, without a full stop */
    double low, high;         /* of numbers: the range allowed */
    size_t bytes;             /* of a text: size of its buffer in the struct */
    const char *unit;         /* of a number: its unit, for listings */
    const sc_choice *choices; /* of a choice: its words and their values */
    const char *const
        *words;         /* of a choice, instead: words whose value is their index, then NULL */
    const sc_key *keys; /* of a container: the table of the maps in it */
    size_t track; /* of a value that may have key frames: where its sc_track lies, counted from the
                     value */
    size_t given; /* SC_GIVEN: a bool that tells whether the key was given; 0: there is none */
    const char *alternative; /* keys of one table with the same word here exclude each other */
    const char *without; /* for listings: what happens without the key, where there is no default */
    const sc_key_option *option; /* NULL: none */
    sc_shorthand shorthand;
    bool required; /* the key, or another one of its alternative, must be given */
    sc_key_scope scope;
};

/* The value for sc_key.given: 1 plus the offset of the bool @p member. */
#define SC_GIVEN(type, member) (offsetof(type, member) + 1)

/* Types that any table may use (values.c, colors.c, sizes.c, maps.c). */
extern const sc_value_type sc_type_bool, sc_type_int, sc_type_real, sc_type_text, sc_type_choice,
    sc_type_color, sc_type_color_levels, sc_type_tracked_color, sc_type_background, sc_type_size,
    sc_type_point, sc_type_direction, sc_type_map, sc_type_flow_map;
/* Types that only the animation and the tissues use. */
extern const sc_value_type sc_type_plane_position, sc_type_duration, sc_type_span, sc_type_clip,
    sc_type_verbs, sc_type_tissues, sc_type_share, sc_type_smooth, sc_type_strength, sc_type_ease,
    sc_type_tracked, sc_type_tracked_point, sc_type_tracked_direction, sc_type_tracked_bool,
    sc_type_key_bool, sc_type_tracked_strength, sc_type_kept_tissues, sc_type_merged_tissues,
    sc_type_volume, sc_type_overlap, sc_type_caption_text, sc_type_tracked_share;
/* Types of the light. */
extern const sc_value_type sc_type_lamp, sc_type_environment;
/* Types of a film of shots. */
extern const sc_value_type sc_type_shots, sc_type_transition, sc_type_card, sc_type_length,
    sc_type_slices, sc_type_frames;

/* The commands with options about labels and how a volume is read. */
#define LABEL_COMMANDS "orbit still info init convert"

/* The tables: sc_job_keys describes the whole file and is read into sc_job; the others describe
 * maps in it. */
extern const sc_key sc_job_keys[], sc_volume_keys[], sc_camera_keys[], sc_clip_keys[],
    sc_verb_keys[], sc_tissue_keys[], sc_overlays_keys[], sc_color_by_keys[], sc_cine_keys[],
    sc_compare_keys[], sc_image_keys[], sc_shot_keys[];
/* The keys of a study file, read into sc_study. */
extern const sc_key sc_study_keys[];

/* ---- keys.c ---- */

/* Store the defaults of all rows, nested maps included, into @p to. */
sc_status sc_keys_set_defaults(const sc_ctx *ctx, const sc_key *keys, void *to);
/* Read the map @p node into @p to, which holds the defaults already (sc_keys_set_defaults). Keys
 * that are unknown, missing though required, or exclude each other are mistakes, as are values that
 * their type refuses. All of them are logged; the first is returned. Values are stored as they are
 * read: after a mistake @p to holds all that was right. */
sc_status sc_keys_read(const sc_ctx *ctx, const sc_key *keys, const sc_yaml *node, void *to);
/* Append to @p text a line "key: value" for each row that is present. @param indent blanks before
 * each key. @param parts SC_WRITE_*, added up. */
sc_status sc_keys_write(const sc_ctx *ctx, const sc_key *keys, const void *from, int indent,
                        unsigned parts, sc_text *text);
enum {
    SC_WRITE_ALL = 0,
    SC_WRITE_IDENTITY = 1, /* only rows on which the pictures depend */
    SC_WRITE_SHOT = 2      /* only rows that a shot may have for itself */
};
/* Append "{key: value, ...}", with each row that is present, to @p text in one line. */
sc_status sc_keys_write_flow(const sc_ctx *ctx, const sc_key *keys, const void *from,
                             sc_text *text);
/* @return the row of that name, or NULL. */
const sc_key *sc_key_find(const sc_key *keys, const char *name);
/* Log that no row of @p keys is named as the key of @p node, with the nearest name, unless
 * node->key_told. @return as sc_yaml_fail. */
sc_status sc_key_unknown(const sc_ctx *ctx, const sc_key *keys, const sc_yaml *node);

/* ---- job_json.c ---- */

/* @return a node, with all below it, as JSON; NULL when out of memory. */
json_t *sc_node_to_json(const sc_yaml *node);
/* Append a tree to @p text as JSON. @return SC_ERR_MEMORY. */
sc_status sc_tree_to_json(const sc_ctx *ctx, const sc_yaml *root, sc_text *text);

/* ---- misplaced.c ---- */

/* Log the keys in the maps of a job that belong into other maps, and mark them by key_told.
 * @return the first such mistake; SC_ERR_MEMORY. */
sc_status sc_tell_misplaced(const sc_ctx *ctx, const sc_yaml *root);
/* The same for one node, whose key its map does not know. @return SC_OK, nothing logged, if no map
 * of a job has that key, or many have it. */
sc_status sc_tell_misplaced_key(const sc_ctx *ctx, sc_yaml *node);

/* ---- job_check.c ---- */

/* @return the node at @p path, whose elements are keys without dots, or NULL if there is none. */
const sc_yaml *sc_key_node(const sc_yaml *root, const char *path);
struct sc_job;
struct sc_job_sources;
struct sc_track;
/* Check what no single row can, resolve the paths of the job in place, and turn its duration into
 * frames. @p root: the tree that the job was read from, for line numbers. @return the first
 * mistake, all are logged: SC_ERR_DATA, SC_ERR_USAGE for what a setting said, SC_ERR_MISSING for an
 * input that does not exist; or SC_ERR_MEMORY. */
sc_status sc_job_check(const sc_ctx *ctx, const struct sc_job_sources *sources, const sc_yaml *root,
                       struct sc_job *job);

/* ---- job_paths.c ---- */

/* What a path of a job leads to: an input that is a file or a directory, one that has to be a file,
 * or something that is to be written. */
typedef enum sc_path_use { SC_PATH_INPUT, SC_PATH_FILE, SC_PATH_OUTPUT } sc_path_use;
/* Join @p path to the directory of @p file, NULL: none. Caller owns *out: sc_free. @return
 * SC_ERR_MEMORY. */
sc_status sc_path_beside(const sc_ctx *ctx, const char *file, const char *path, char **out);
/* Resolve a path in place, which has room for SC_PATH_BYTES. In the job file it is relative to that
 * file, in a setting to the working directory. If something exists there the path becomes absolute,
 * so that the resolved job can be read from any directory. @param node where it stands; NULL: it is
 * a default, and stays. @param key for messages. @return SC_ERR_DATA, SC_ERR_USAGE of a setting,
 * SC_ERR_MISSING for an input that does not exist, cannot be read, or is no file, all logged;
 * SC_ERR_MEMORY. */
sc_status sc_resolve_path(const sc_ctx *ctx, const struct sc_job_sources *sources,
                          const sc_yaml *node, const char *key, sc_path_use use, char *path);

/* As sc_resolve_path, of the volume of @p job, @p node being its path or the list of its paths: a
 * list becomes the phases of the job, and, where inputs are to be looked at, a pattern; its volume
 * is the first of them then. */
sc_status sc_resolve_volume(const sc_ctx *ctx, const struct sc_job_sources *sources,
                            const sc_yaml *node, const char *key, struct sc_job *job);

/* ---- series.c ---- */

/* Compare two names such that numbers in them count as such: "p2" comes before "p10". @return as
 * strcmp. */
int sc_natural_order(const char *a, const char *b);
/* Make room for @p count phases of a job, whose paths are empty. @return SC_ERR_DATA or
 * SC_ERR_USAGE if there are too many, or none. */
sc_status sc_series_alloc(const sc_ctx *ctx, const sc_yaml *node, size_t count, struct sc_job *job);
/* Fill the phases of a job with the paths that match @p pattern (glob(3)), in the order of the one
 * number in which they differ. @param node, key for messages. @return SC_ERR_MISSING if there are
 * none; SC_ERR_DATA or SC_ERR_USAGE, all logged, if their order is not known or one is missing. */
sc_status sc_series_find(const sc_ctx *ctx, const sc_yaml *node, const char *key,
                         const char *pattern, struct sc_job *job);

/* ---- job_cine.c ---- */

/* Check that a series of volumes has its key cine, and the other way round, and leave those phases
 * that cine chooses. With cine, a file is opened in order to see whether it holds several, if
 * inputs are to be looked at. To be called when paths are resolved. @return the mistake, logged. */
sc_status sc_cine_check(const sc_ctx *ctx, const struct sc_job_sources *sources,
                        const sc_yaml *root, struct sc_job *job);

/* ---- job_overlays.c ---- */

/* Refuse captions that are shown in no frame.
 * @param job all of it, with its number of frames. @return SC_ERR_DATA, all are logged. */
sc_status sc_captions_check(const sc_ctx *ctx, const struct sc_job *job);

/* ---- sizes.c ---- */

/* Read "XxYxZ", whole numbers of voxels from 1 to 4096. @return false if @p text is anything else.
 */
bool sc_parse_voxels(const char *text, int size[3]);

/* ---- tracks.c ---- */

/* @return whether @p node, a value of a row that may have key frames, is a track: a map of times,
 * and perhaps an ease for all of them. */
bool sc_is_track(const sc_yaml *node);
/* Read a track into the sc_track of a row; their values are those of @p value, a row
 * of a number, a point or a colour. @return the first mistake; all are logged. */
sc_status sc_read_track(const sc_ctx *ctx, const sc_key *value, const sc_yaml *node,
                        struct sc_track *track);
/* Where the key frames of a track are stored: their times and eases, and their values. */
typedef struct sc_track_room {
    struct sc_key_frame *frames; /* [most] */
    void *values;                /* the first of them; they may lie in the key frames */
    size_t value_bytes;          /* from one value to the next */
    int *count, most;
} sc_track_room;
/* Read and write a track of any kind of value. @param key its row, but with the type of its values.
 */
sc_status sc_read_key_frames(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                             const sc_track_room *room);
sc_status sc_write_key_frames(const sc_ctx *ctx, const sc_key *key, const sc_track_room *room,
                              sc_text *text);
/* Append a track to @p text as sc_read_track reads it. */
sc_status sc_write_track(const sc_ctx *ctx, const sc_key *value, const struct sc_track *track,
                         sc_text *text);
/* @return the type of the values of key frames of a row, and that of its value without any. */
const sc_value_type *sc_type_of_frames(const sc_key *value);
const sc_value_type *sc_constant_of(const sc_key *key);
/* Read and write a value that may have key frames: for sc_value_type. */
sc_status sc_read_tracked(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value);
sc_status sc_write_tracked(const sc_ctx *ctx, const sc_key *key, const void *value, sc_text *text);
/* @return the track of a row of such a value. */
sc_track *sc_track_of(const sc_key *key, void *value);

/* ---- positions.c ---- */

/* Read a number and, behind it, its unit. @param unit "%", "mm", or "" if there is none. @return
 * false if @p node is anything else. */
bool sc_parse_position(const sc_yaml *node, double *number, const char **unit);
/* What a time is counted in. */
typedef enum sc_time_kind {
    SC_TIME_NONE, /* it is no time */
    SC_TIME_NUMBER,
    SC_TIME_FRAMES,
    SC_TIME_SECONDS
} sc_time_kind;
/* Read a time as sc_parse_seconds does, or a number of frames, "12f". @return what *amount is. */
sc_time_kind sc_time_of_text(const char *text, double *amount);
/* Read a time in seconds, above 0, of at most some eleven days. @return false if @p node is
 * anything else. */
bool sc_parse_duration(const sc_yaml *node, double *seconds);
/* Read a time of the animation. @param key the name of the value, for messages. @param at the share
 * of the animation, or of a film minus the seconds; also after a mistake. @param is_time false:
 * @p node is none, which the caller tells. @return the mistake that the time is behind the end,
 * logged. */
sc_status sc_read_time(const sc_ctx *ctx, const char *key, const sc_yaml *node, double *at,
                       bool *is_time);

/* ---- job_times.c ---- */

/* What turns times into shares of the animation. */
typedef struct sc_clock {
    bool is_film;          /* the shares are those of its shots: times become seconds */
    double frames, fps;    /* of the animation; both above 0 */
    const sc_yaml *length; /* where these frames are given, for messages; NULL: by default */
} sc_clock;
/* Set a clock by the tree @p root of a job, and give it to all of its nodes, which must not outlive
 * it. @param job holds the defaults. @param is_film it is a film without its shots, of which each
 * has shares of its own. */
void sc_clock_start(const struct sc_job *job, bool is_film, sc_yaml *root, sc_clock *clock);

/* ---- settings.c ---- */

/* Set @p path, such as "render.quality", to the value @p text, which is YAML, in the tree @p root
 * of a job file. Elements of the path are names of rows of @p keys; those with dots or spaces stand
 * in double quotes. A map is merged into one that is there key by key, everything else is replaced.
 * A key that excludes others removes them. The index after the last item of a list appends to it.
 * @param origin the setting's name in messages; borrowed for the life of the tree.
 * @return SC_ERR_USAGE if path or value are wrong, logged; SC_ERR_MEMORY. */
sc_status sc_setting_apply(const sc_ctx *ctx, const sc_key *keys, sc_yaml *root, const char *origin,
                           const char *path, const char *text);
/* The same, but @p text is not YAML: all of it is the text of a single value. */
sc_status sc_setting_apply_text(const sc_ctx *ctx, const sc_key *keys, sc_yaml *root,
                                const char *origin, const char *path, const char *text);
/* Find the path that an environment variable names. @param variable its name without the prefix,
 * such as RENDER_QUALITY: case is ignored, and "_" stands for ".". @param path room for @p size
 * bytes. @return false if no row has that name or the room is too small. */
bool sc_setting_path(const sc_key *keys, const char *variable, char *path, size_t size);

/* Merge the map @p value into the map @p root, which has the rows @p keys, as if it were a setting:
 * maps key by key, everything else is replaced, and a key that excludes others removes them. Takes
 * ownership of @p value, also after an error. @return SC_ERR_MEMORY. */
sc_status sc_settings_merge(const sc_ctx *ctx, const sc_key *keys, sc_yaml *root, sc_yaml *value);

/* ---- looks.c ---- */

/* Put the values of the look that the tree of a job names into it, but those of keys that it has.
 * @return SC_ERR_MEMORY. */
sc_status sc_look_apply(const sc_ctx *ctx, sc_yaml *root);

/* ---- shots.c ---- */

/* Read the shots of a job, whose own keys have been read, with what they take from the film, and
 * place them one after the other: job->animation.frames becomes the length of the film. @param base
 * the tree of the job without its shots, all else as it is written. @param shots the node of the
 * shots. @return the first mistake, all are logged, those of keys of the film once for each shot;
 * or SC_ERR_MEMORY. */
sc_status sc_shots_resolve(const sc_ctx *ctx, const struct sc_job_sources *sources,
                           const sc_yaml *base, const sc_yaml *shots, struct sc_job *job);

/* ---- values.c: building blocks for further types ---- */

/* Read a finite number. @return false if @p node is anything else; nothing is logged. */
bool sc_parse_number(const sc_yaml *node, double *out);
/* Read a number from @p low to @p high; anything else is logged as an error. */
sc_status sc_read_real(const sc_ctx *ctx, const sc_yaml *node, double low, double high,
                       double *out);
/* Append @p value * @p scale and @p unit, with as many digits, 12 or more, as it takes to read the
 * same @p value again. @param scale 1, or 100 of a share in percent. */
sc_status sc_write_number(const sc_ctx *ctx, double value, double scale, const char *unit,
                          sc_text *text);
/* Append "[a, b, c]", each as sc_write_number. */
sc_status sc_write_numbers(const sc_ctx *ctx, const double *values, size_t count, sc_text *text);
/* Read @p count numbers in the range of the row into @p out: a list "[a, b, c]", or one text with
 * commas between the numbers. */
sc_status sc_read_numbers(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, size_t count,
                          double *out);
/* Log what @p node is, the beginning of a long value, and what was expected. @return as
 * sc_yaml_fail. */
sc_status sc_wrong_type(const sc_ctx *ctx, const sc_yaml *node, const char *expected);
/* Log that @p word is not among @p words, with the nearest of them or all. @return as sc_yaml_fail.
 */
sc_status sc_unknown_word(const sc_ctx *ctx, const sc_yaml *node, const char *word,
                          const char *const *words, size_t count);
/* Log that @p node is none of the @p words, with the nearest of them; if none is near, what its
 * type expects. @param word the value as it was compared with them. @return as sc_yaml_fail. */
sc_status sc_no_such_word(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                          const char *word, const char *const *words, size_t count);
/* Store "file:line" of a node in @p where, for messages after the tree has been freed. Three dots
 * stand for the beginning of a path that is too long for where[size]. @p size is at least 32. */
void sc_note_where(const sc_yaml *node, char *where, size_t size);
/* Read the name of a tissue, a glob or the number of a label, and where it stands.
 * @return as sc_wrong_type if @p item is no such text, or an empty one. */
sc_status sc_read_tissue(const sc_ctx *ctx, const sc_key *key, const sc_yaml *item,
                         char pattern[SC_NAME_BYTES], char where[SC_WHERE_BYTES]);
/* Append a tissue or a list of tissues to *list [*count], all named for @p of. @return the first
 * mistake; all are logged. */
sc_status sc_read_tissues(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, int of,
                          sc_named_tissue **list, size_t *count);
/* Append those of list[count] that are named for @p of as a list, [a, "b*"]. */
sc_status sc_write_tissues(const sc_ctx *ctx, const sc_named_tissue *list, size_t count, int of,
                           sc_text *text);
/* Append an item of a list, a text in quotes. *comma stands before it: "" or "[" at first. */
sc_status sc_write_item(const sc_ctx *ctx, const char **comma, const char *value, sc_text *text);
/* Store "file:line: key" of a node in @p where, for messages of what its value names; of a setting
 * the setting, and nothing of one that a command has made of its argument. @p size is at least 96.
 */
void sc_note_key(const sc_yaml *node, const char *key, char *where, size_t size);
/* Log what is wrong with the file @p path, which the value of the key @p key names, with the line
 * where it has one. @return @p status. */
sc_status sc_tell_input(const sc_ctx *ctx, const sc_yaml *node, const char *key, const char *path,
                        sc_status status, const char *why);
/* Log that @p path, which the value of the key @p key names, cannot be found, with the line where
 * it has one. @param error the errno that tells why. @return as sc_input_status. */
sc_status sc_tell_missing(const sc_ctx *ctx, const sc_yaml *node, const char *key, const char *path,
                          int error);

/* Copy the first element of the path of a setting into @p element, which has room for @p size
 * bytes. @return the rest of the path, or NULL if the path is malformed or the element too long. */
const char *sc_setting_element(const char *path, char *element, size_t size);

/* ---- schema.c ---- */

/* @return a new JSON schema of a value of @p type in the row @p key: its YAML, in which $low and
 * $high stand for the range of the row, $words for those of the type, $keys for a map with the keys
 * of the row, $constant for a value without key frames, $track for key frames of it, and other
 * names for what the tables in schema.c say. NULL when out of memory. */
json_t *sc_type_schema(const sc_value_type *type, const sc_key *key);
/* Such texts, or parts of them: a value that may have key frames, a number in the range of the row,
 * a list of so many of something, a tissue, and a tissue or a list of some. */
#define SC_SCHEMA_TRACKED "{anyOf: [$constant, $track]}"
#define SC_SCHEMA_NUMBER "{type: number, minimum: $low, maximum: $high}"
#define SC_SCHEMA_LIST(item, count)                                                                \
    "{type: array, items: " item ", minItems: " #count ", maxItems: " #count "}"
#define SC_SCHEMA_TISSUE "{type: [string, integer]}"
#define SC_SCHEMA_TISSUES                                                                          \
    "{anyOf: [" SC_SCHEMA_TISSUE ", {type: array, minItems: 1, items: " SC_SCHEMA_TISSUE "}]}"
/* @return a new JSON schema of a map with the rows of @p keys; NULL when out of memory. */
json_t *sc_keys_schema(const sc_key *keys);

#endif
