/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to commands: the commands, and what several of them need. */
#ifndef SC_COMMANDS_COMMANDS_H
#define SC_COMMANDS_COMMANDS_H

#include "segcast/film.h"
#include "segcast/json_values.h"

/* Warn of a run that keeps no picture. Not collective. */
void sc_warn_of_outputs(const sc_app *app, const sc_job *job);
/* Write the name of the processor as the system has it into @p text; empty if it has none. */
void sc_processor_name(char *text, int size);
/* @return the id that the batch system has given to this job, or NULL. */
const char *sc_batch_job(void);

/* Print on one line as JSON what `segcast --version` prints, the options of the build, and the
 * libraries that it was built with. @return SC_ERR_MEMORY. */
sc_status sc_print_version_json(const sc_ctx *ctx);

/* ---- output.c: the files that a job reads ---- */

/* Called with a file or directory that a job reads, and what it is, in words (static). Both are
 * borrowed. */
typedef struct sc_input_visit {
    sc_status (*each)(void *user, const char *use, const char *path, bool is_volume);
    void *user;
} sc_input_visit;
/* Visit all that a job reads, also what is not there, such as a phantom, in the order of its keys.
 * Not collective. @return the first error of the visit. */
sc_status sc_each_input(const sc_app *app, const sc_job *job, const sc_input_visit *visit);

/* ---- made_from.c: what a film or a study is made from ---- */

/* All that jobs read. Zero-initialise but for the first two; on rank 0: sc_made_from_clear. */
typedef struct sc_made_from {
    const sc_app *app;
    uint64_t store_most_bytes; /* see sc_volume_files */
    json_t *inputs;            /* by their paths */
} sc_made_from;
/* Note what a job reads, but for what was noted before; reads it all. @return SC_ERR_MEMORY. */
sc_status sc_made_from_add(sc_made_from *m, const sc_job *job);
/* Write it, with the command, as sc_run_record says. @return SC_ERR_MEMORY. */
sc_status sc_made_from_text(const sc_made_from *m, sc_text *out);
void sc_made_from_clear(sc_made_from *m);

/* ---- output.c: the file that a command is to write ---- */

/* Check, before any work, that @p path can become the output file of a command: nothing has this
 * name, or with --overwrite a regular file at most, which is none of the inputs. @param job
 * NULL: the command has no inputs. @param can_replace the command has the option --overwrite. Not
 * collective. @return SC_ERR_CREATE, SC_ERR_MEMORY. */
sc_status sc_check_output(const sc_app *app, const sc_job *job, const char *path, bool can_replace);
/* Check, without writing anything, whether a directory can be made or written to, as far as that
 * can be known. @param where what names it, for the message; may be empty. @return SC_ERR_CREATE.
 */
sc_status sc_check_directory(const sc_ctx *ctx, const char *where, const char *directory);
/* Check that a name ends in @p ending, which says what is written, in upper or lower case. @param
 * kind what is written, for the message. @return SC_ERR_USAGE. */
sc_status sc_check_ending(const sc_ctx *ctx, const char *path, const char *ending,
                          const char *kind);
/* Print the path of what a command has made, on a line of its own: as it is for scripts, and on a
 * terminal so that it is not obeyed. */
void sc_print_made(const char *path);
/* Print an object, which is taken, to standard output; as sc_json_add_text. */
sc_status sc_print_json(const sc_ctx *ctx, json_t *json, size_t flags, const char *what);
/* Write a text to the file @p path and print that path, or to standard output for "-". Not
 * collective. @return SC_ERR_CREATE, SC_ERR_WRITE, SC_ERR_MEMORY. */
sc_status sc_write_text(const sc_app *app, const sc_text *text, const char *path);

/* ---- what segcast convert writes, each to app->options.output; @return as the command ---- */

/* The tissues of --tissue. Zero-initialise; owns text. */
enum { SC_TISSUES_MAX = 64 };
typedef struct sc_tissue_list {
    sc_text text;
    const char *names[SC_TISSUES_MAX]; /* [count] names, globs and label numbers, in text */
    size_t count;
} sc_tissue_list;
/* Take the value of --tissue apart at commas. @return SC_ERR_USAGE, SC_ERR_MEMORY. Caller owns *out
 * also after an error: sc_tissue_list_clear. */
sc_status sc_tissue_list_read(const sc_ctx *ctx, const char *tissues, sc_tissue_list *out);
void sc_tissue_list_clear(sc_tissue_list *list);
/* A label table in the format of another program. */
sc_status sc_convert_table(sc_app *app);
/* The centre line of a vessel. */
sc_status sc_convert_line(sc_app *app);
/* The surfaces of tissues as a mesh, in the format that the name of the file tells. */
sc_status sc_convert_mesh(sc_app *app);
/* The built-in heart, or the phases of its beat. */
sc_status sc_convert_phantom(sc_app *app);
/* The prepared volume of the job file @p job; NULL: of app->options.input, which is a volume. */
sc_status sc_convert_prepared(sc_app *app, const char *job);
/* segcast still with --sheet N or --frames: small pictures of frames on one sheet. @param job_path
 * NULL: there is no job file, only settings. @return as the command. */
sc_status sc_draw_sheet(sc_app *app, const char *job_path, const char *path);

/* ---- the commands: rows of sc_commands, by their names ---- */

extern const sc_command sc_commands[]; /* ended by a row without a name */

sc_status sc_cmd_render(sc_app *app);
sc_status sc_cmd_join(sc_app *app);
sc_status sc_cmd_report(sc_app *app);
sc_status sc_cmd_verify(sc_app *app);
sc_status sc_cmd_status(sc_app *app);
sc_status sc_cmd_study(sc_app *app);
sc_status sc_cmd_orbit(sc_app *app);
sc_status sc_cmd_still(sc_app *app);
sc_status sc_cmd_check(sc_app *app);
sc_status sc_cmd_plan(sc_app *app);
sc_status sc_cmd_info(sc_app *app);
sc_status sc_cmd_init(sc_app *app);
sc_status sc_cmd_desk(sc_app *app);
sc_status sc_cmd_convert(sc_app *app);
sc_status sc_cmd_help(sc_app *app);

#endif
