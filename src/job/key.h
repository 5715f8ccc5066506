/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to job: the rows of the tables that describe a job file, and the types of their values.
 *
 * A table is an array of sc_key, ended by a row without a name; it describes one map of the file
 * and is read into one C struct. Reading, defaults, writing, settings of the command line and of
 * the environment, `segcast keys`, the JSON schema and the manual page all walk the same rows. */
#ifndef SC_JOB_KEY_H
#define SC_JOB_KEY_H

#include "yaml_tree.h"

#include <jansson.h>

typedef struct sc_key sc_key;

/* How a value holds further values. */
typedef enum sc_container {
    SC_CONTAINER_NONE, /* a value, or a list of fixed length that is set as a whole */
    SC_CONTAINER_MAP,  /* the keys of sc_key.keys */
    SC_CONTAINER_LIST, /* any number of maps with the keys of sc_key.keys, addressed by index */
    SC_CONTAINER_DICT  /* names that the user chooses, each with a map of the keys of sc_key.keys */
} sc_container;

/* A type of value. All functions get the address of the value itself. */
typedef struct sc_value_type {
    const char *name;     /* for listings, for example "whole number" */
    const char *expected; /* for error messages, for example "a whole number" */
    /* Check @p node and store it; logs what is wrong with file and line. */
    sc_status (*read)(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value);
    /* Write the value as YAML that `read` accepts. @p indent: of the line that holds the key. */
    sc_status (*write)(const sc_ctx *ctx, const sc_key *key, const void *value, int indent,
                       sc_text *text);
    /* What an editor may accept: a JSON schema of the value; NULL when out of memory. */
    json_t *(*schema)(const sc_key *key);
    sc_container container;
} sc_value_type;

/* A word of the job file and the number that stands for it in the struct. */
typedef struct sc_choice {
    const char *word; /* NULL ends a list */
    int value;
} sc_choice;

/* A command-line option that sets the key. */
typedef struct sc_key_option {
    const char *name, *argument, *commands;
} sc_key_option;

struct sc_key {
    const char *name; /* NULL ends a table */
    const sc_value_type *type;
    size_t offset;        /* of the value in the struct of the table */
    const char *fallback; /* the default as YAML; NULL: nothing is stored without the key */
    const char *help;     /* one line, without a full stop */
    double low, high;     /* range of numbers */
    size_t bytes;         /* of the buffer of a text */
    const char *unit;     /* of a number, for listings */
    const sc_choice *choices;
    const char *const *words; /* instead of choices: the value is the index; ended by NULL */
    const sc_key *keys;       /* of a container */
    size_t given; /* 1 + offset of a bool that tells whether the key was given; 0: none */
    const char *alternative; /* keys of one table with the same word here exclude each other */
    const char *without; /* for listings: what happens without the key, where there is no default */
    const sc_key_option *option; /* NULL: none */
    const char *shorthand;       /* of a map: a single value stands for a map with this key */
    bool required;               /* with an alternative: one of its keys is */
    bool outside_identity;       /* the pictures do not depend on it: not part of the job's hash */
};

/* offset for sc_key.given */
#define SC_GIVEN(type, member) (offsetof(type, member) + 1)

extern const sc_value_type sc_type_bool, sc_type_int, sc_type_real, sc_type_text, sc_type_choice,
    sc_type_color, sc_type_size, sc_type_point, sc_type_direction, sc_type_map, sc_type_flow_map;
/* Types of parts of the animation and of tissues. */
extern const sc_value_type sc_type_plane_position, sc_type_span, sc_type_zoom, sc_type_clip,
    sc_type_tissues, sc_type_share;

/* The tables: of the whole file (into sc_job), and those that several files use. */
extern const sc_key sc_job_keys[], sc_camera_keys[], sc_slices_keys[], sc_clip_keys[],
    sc_tissue_keys[];
extern const sc_choice sc_ease_choices[];

/* ---- keys.c ---- */

/* Store the defaults of all rows, nested maps included, into @p to. */
sc_status sc_keys_set_defaults(const sc_ctx *ctx, const sc_key *keys, void *to);
/* Read the map @p node into @p to. Keys that are unknown, missing though required, or exclude each
 * other are errors. Values are stored as they are read: after an error @p to is partly changed. */
sc_status sc_keys_read(const sc_ctx *ctx, const sc_key *keys, const sc_yaml *node, void *to);
/* Is there a value of @p key in the struct @p from that has to be written? */
bool sc_key_is_present(const sc_key *keys, const sc_key *key, const void *from);
/* Write a line "key: value" for each row that is present. @p identity: only for rows on which the
 * pictures depend. */
sc_status sc_keys_write(const sc_ctx *ctx, const sc_key *keys, const void *from, int indent,
                        bool identity, sc_text *text);
/* Write "{key: value, ...}" in one line. */
sc_status sc_keys_write_flow(const sc_ctx *ctx, const sc_key *keys, const void *from,
                             sc_text *text);
/* The row of that name, or NULL. */
const sc_key *sc_key_find(const sc_key *keys, const char *name);
/* Log that @p node has a key that no row of @p keys has, with the nearest name. */
sc_status sc_key_unknown(const sc_ctx *ctx, const sc_key *keys, const sc_yaml *node);

/* ---- settings.c ---- */

/* Put "key.path" with the value @p text, which is YAML, into the tree of a job file. Keys of the
 * path are rows of @p keys; elements with dots or spaces stand in double quotes. A map is merged
 * into what is there key by key, all else is replaced; a key that excludes others removes them; the
 * index after the last item of a list appends. @p origin is borrowed by the tree, and named by
 * later messages. */
sc_status sc_setting_apply(const sc_ctx *ctx, const sc_key *keys, sc_yaml *root, const char *origin,
                           const char *path, const char *text);
/* The same, with @p text as a single value that needs no quoting. */
sc_status sc_setting_apply_text(const sc_ctx *ctx, const sc_key *keys, sc_yaml *root,
                                const char *origin, const char *path, const char *text);
/* The path that the rest of an environment variable names, such as RENDER_SAMPLES: case is ignored,
 * and "_" stands for ".". @return false if no row has that name or @p size is too small. */
bool sc_setting_path(const sc_key *keys, const char *variable, char *path, size_t size);

/* ---- values.c: building blocks for further types ---- */

sc_status sc_read_real(const sc_ctx *ctx, const sc_yaml *node, double low, double high,
                       double *out);
sc_status sc_wrong_type(const sc_ctx *ctx, const sc_yaml *node, const char *expected);
sc_status sc_unknown_word(const sc_ctx *ctx, const sc_yaml *node, const char *word,
                          const char *const *words, size_t count);
/* Write @p value in double quotes, with all escapes that YAML needs. */
sc_status sc_write_quoted(const sc_ctx *ctx, const char *value, sc_text *text);
/* "file:line" of a node, for messages after the tree is gone. */
void sc_note_where(const sc_yaml *node, char *where, size_t size);

/* ---- schema.c ---- */

/* The JSON schema of a map with the rows of @p keys; NULL when out of memory. */
json_t *sc_keys_schema(const sc_key *keys);

#endif
