/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  The command line: the options of each command, read strictly and all mistakes told; help,
 *  manual, completions and version, from the tables of commands, options and keys. It does not
 *  know what commands do. */
#ifndef SEGCAST_CLI_H
#define SEGCAST_CLI_H

#include "segcast/job.h"

/** The most settings of a command line, and the most options of a command. */
enum { SC_SETTINGS_MAX = 256, SC_OPTIONS_MAX = 64 };
/** A sheet of one picture for each value of an option. */
typedef struct sc_sheet {
    const char *name;         /**< --sheet views, looks */
    const char *option;       /**< view, look */
    const char *const *words; /**< [count]: the values, as the option takes them */
    int count;
} sc_sheet;
/** The most pictures on a sheet that segcast still draws. */
enum { SC_PICTURES_MAX = 1000 };
/** How a moment of the film is given: not at all, in seconds, or as a share of the film. */
typedef enum sc_moment { SC_MOMENT_NONE, SC_MOMENT_SECONDS, SC_MOMENT_SHARE } sc_moment;

/** Which part of a film a command draws. */
typedef struct sc_part_options {
    const char *frames;  /**< --frames */
    int slice, slices;   /**< --slice I/N; slices 0: not given */
    double time_limit_s; /**< --time-limit; 0: none */
} sc_part_options;

/** What segcast still draws. */
typedef struct sc_still_options {
    long frame;            /**< --frame; -1: not given */
    sc_moment moment;      /**< --time */
    double moment_at;      /**< where that is: in seconds, or a share from 0 to 1 */
    int pictures;          /**< --sheet N; 0: not given */
    bool slices;           /**< --sheet slices */
    const sc_sheet *sheet; /**< --sheet views, looks; NULL: neither */
} sc_still_options;

/** What segcast convert makes. */
typedef struct sc_convert_options {
    const char *to;          /**< format of a table or of a centre line */
    const char *begin, *end; /**< of a centre line */
    const char *tissue;      /**< patterns of tissues: those of a mesh, or along a centre line */
    const char *simplify;    /**< of a mesh */
    bool middles;            /**< of a centre line */
    bool ct;                 /**< of the phantom: its synthetic CT image */
    int beating;             /**< of the phantom: phases of its beat; 0: not given */
} sc_convert_options;

/** What segcast plan assumes. */
typedef struct sc_plan_options {
    int nodes, ranks; /**< 0: not given */
    bool calibrate;
} sc_plan_options;

/** What segcast check does. */
typedef struct sc_check_options {
    bool fast, expand;
} sc_check_options;

/** What segcast help shows. */
typedef struct sc_help_options {
    bool help, version; /**< --help, --version of any command */
    bool markdown;      /**< also of segcast report */
    bool clear;         /**< of the cache */
    bool study;         /**< --study-schema */
    bool schema, man, bash, zsh, fish;
} sc_help_options;

/** How segcast desk serves. */
typedef struct sc_desk_options {
    const char *listen;
    int port, idle_min; /**< --port and --idle; 0: not given */
} sc_desk_options;

/** Keys of the job that the command line sets. */
typedef struct sc_settings {
    sc_setting all[SC_SETTINGS_MAX];
    size_t count;
    sc_setting defaults[8]; /**< values that the command sets unless the job file has the key */
    size_t default_count;
} sc_settings;

/** How much of the machine may be used. */
typedef struct sc_limits {
    int threads;               /**< --threads or SEGCAST_THREADS; 0: not given */
    uint64_t max_memory_bytes; /**< --max-memory or SEGCAST_MAX_MEMORY; 0: not given */
} sc_limits;

/** Texts that sc_options_clear frees. */
typedef struct sc_owned_texts {
    char *all[SC_SETTINGS_MAX]; /**< [count] */
    size_t count;
} sc_owned_texts;

/** The command line as read. Pointers lead into argv, into static text, or into owned.all. NULL:
 * not given. */
typedef struct sc_options {
    const char *input;         /**< the argument: a job, volume, directory, command or key */
    const char *const *inputs; /**< all arguments, of a command that takes several: [input_count] */
    int input_count;
    const char *output; /**< -o */
    sc_limits limits;
    bool json, quiet, resume, overwrite;
    bool scan;     /**< the command reads all voxels, and tells all mistakes against them */
    bool no_video; /**< the command makes no video, even if the job names one */
    sc_part_options part;
    sc_still_options still;
    sc_convert_options convert;
    sc_plan_options plan;
    sc_check_options check;
    sc_help_options help;
    sc_desk_options desk;
    sc_settings settings;
    sc_owned_texts owned;
} sc_options;

/** What a command gets: the business of whoever makes the table of commands. */
typedef struct sc_app sc_app;

/** A row of the table of commands. */
typedef struct sc_command {
    const char *group; /**< what a person wants who looks for it; NULL: as the row before */
    const char *name;
    const char *argument; /**< such as "JOB.yaml"; "[COMMAND]": may be left out; "DIR...": there may
                           * be several; "[A [B]]": up to two */
    const char *help;     /**< one line */
    const char *details;  /**< further sentences for its help and manual; or NULL */
    sc_status (*execute)(sc_app *app);
    bool by_all; /**< all ranks execute it together; else rank 0 alone, but for --calibrate */
} sc_command;

/** @return the row of @p commands with that name, or NULL. */
const sc_command *sc_command_find(const sc_command *commands, const char *name);
/** Log that there is no such command, with the nearest name; or, if @p name is a file, with the
 * command that takes it. @p name NULL: none was given. @return SC_ERR_USAGE. */
sc_status sc_command_unknown(const sc_ctx *ctx, const sc_command *commands, const char *name);

/* ---- input.c: what users have given instead of what a command takes ---- */

/** @return whether a path names a volume, or a directory, which may hold masks: by the end of the
 * name, else by the first bytes. */
bool sc_input_is_volume(const char *path);
/** @return whether it is a job file by its name, or text, or not there. */
bool sc_input_may_be_job(const char *path);
/** @return whether @p path is named like a job file. */
bool sc_input_is_job(const char *path);
/** Log, where the first word of the command line is a job, a volume or a folder, which command
 * takes it. It may look into the file. @return SC_ERR_USAGE; SC_OK, with nothing logged, for
 * another word.
 */
sc_status sc_input_as_command(const sc_ctx *ctx, const char *name);
/** Log that the argument is a volume where the command takes a job, or the other way round, or a
 * file where it takes a folder, and which command takes it. It may look into the file. @param input
 * NULL: there is no argument. @return SC_ERR_USAGE; SC_OK if nothing is known against the argument.
 */
sc_status sc_input_check(const sc_ctx *ctx, const sc_command *command, const char *input);

/** A row of the table of options. Several rows may have one name, for different commands. */
typedef struct sc_option sc_option;
struct sc_option {
    const char *name;
    char letter;          /**< 0: none */
    const char *argument; /**< what help calls its value; NULL: takes none */
    const char *help;
    const char *commands; /**< names of the commands that have it, separated by spaces; NULL: all */
    /** Check the value and store it in @p options. */
    sc_status (*store)(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                       const char *value);
    size_t offset; /**< for store_text and store_flag: of the member of sc_options to be set */
    char key[64];  /**< path of the key that the option sets; "": none */
};
/** The options of a command: its own, and those that stand in rows of the job's table of keys. */
typedef struct sc_option_list {
    sc_option rows[SC_OPTIONS_MAX];
    size_t count;
} sc_option_list;
/** List the options of @p command; status also accepts those of render, which are not listed.
 * @return SC_ERR_MEMORY, or SC_ERR_INTERNAL for too many. */
sc_status sc_options_list(const sc_ctx *ctx, const sc_command *command, sc_option_list *out);
/** Append the options of a command that the list does not hold yet, judged by their names. @return
 * as sc_options_list. */
sc_status sc_options_list_more(const sc_ctx *ctx, const char *command, sc_option_list *list);

/** The commands that have an option. */
typedef struct sc_option_owners {
    const char *option; /**< its name; borrowed */
    char commands[256]; /**< their names, separated by spaces; empty: there are none */
} sc_option_owners;
/** Find the commands that have an option. @return SC_ERR_MEMORY. */
sc_status sc_options_find_owners(const sc_ctx *ctx, const char *option, sc_option_owners *out);

/** Read argv[2...] as the options and the argument of @p command (getopt_long: options may stand
 * behind the argument, and "--" ends them; but names of options have to be written in full, so that
 * an option of a later version cannot change what a command line means). @return SC_ERR_USAGE, with
 * all mistakes logged; @p out gets what was right then, too. Owner: sc_options_clear. */
sc_status sc_options_parse(const sc_ctx *ctx, const sc_command *command, int argc, char **argv,
                           sc_options *out);
void sc_options_clear(sc_options *options);
/** Append a command line, which was read without a mistake, as it can be shown to anybody: names of
 * files and directories, and texts, are replaced by what help calls them. @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_command_shown(const sc_ctx *ctx, const sc_command *command, int argc,
                                       char *const *argv, sc_text *text);
/** Has the command the option --threads? */
bool sc_command_has_threads(const sc_command *command);
/** Add a setting of the job, as if --set had been given. Both texts are copied; @p value is used as
 * it is, not as YAML. */
sc_status sc_options_set_text(const sc_ctx *ctx, sc_options *options, const char *key,
                              const char *value);
/** As sc_options_set_text; messages of the value begin with @p origin, such as "--output x.mp4". */
sc_status sc_options_set_as(const sc_ctx *ctx, sc_options *options, const char *origin,
                            const char *key, const char *value);
/** Add a default of the command, which holds if the job does not set the key. Both texts are
 * borrowed. @return SC_ERR_INTERNAL if there are more than sc_settings.defaults holds. */
sc_status sc_options_default(const sc_ctx *ctx, sc_options *options, const char *key,
                             const char *value);

/** The exit code of a return code, after sysexits.h, and its meaning; 75 asks a batch system to run
 * the job again. */
typedef struct sc_exit_code {
    sc_status status;
    int code;
    const char *meaning;
} sc_exit_code;
extern const sc_exit_code sc_exit_codes[]; /**< ended by a row without a meaning */
/** @return the exit code of the process for a return code. */
int sc_exit_code_of(sc_status status);

/* ---- help.c, completion.c: texts made from these tables ---- */

void sc_print_help(const sc_command *commands, FILE *stream);
sc_status sc_print_command_help(const sc_ctx *ctx, const sc_command *command, FILE *stream);
/** Print the manual page segcast(1) in roff. */
sc_status sc_print_manual(const sc_ctx *ctx, const sc_command *commands, FILE *stream);
/** Print a script that completes the command line. @param shell "bash", "zsh" or "fish". */
sc_status sc_print_completion(const sc_ctx *ctx, const sc_command *commands, const char *shell,
                              FILE *stream);

/* ---- version.c ---- */

/** Print the version, the commit, the compiler and the libraries. */
void sc_print_version(FILE *stream);
/** @return how segcast was built, as a JSON object: `compiler`, `build_type`, `processor`,
 * `options` and `libraries`, the latter with the versions that they had then. Static text. */
const char *sc_build_json(void);
/** @return the version of segcast. */
const char *sc_version(void);
/** @return the commit of these sources, or "unknown". */
const char *sc_commit(void);

#endif
