/* SPDX-License-Identifier: BSD-3-Clause */
/* The file that a command is to write: checked before any work, and told at the end. */
#include "commands.h"

#include <errno.h>
#include <sys/stat.h>
#include <unistd.h>
#ifdef __linux__
#include <linux/magic.h>
#include <sys/vfs.h>
#endif

/* Refuse the name of a file that a command reads, or that belongs to a volume which it reads.
 * @param input NULL or empty: there is none. */
static sc_status check_input(const sc_app *app, const char *path, const char *input, bool is_volume)
{
    bool reads = input && sc_same_file(input, path);

    if (input && is_volume && !reads)
        SC_PASS(sc_volume_reads(app->ctx, input, path, &reads));
    if (reads)
        return sc_fail(app->ctx, SC_ERR_CREATE,
                       "%s: is an input of this command (%s), which would be lost; give another "
                       "name for the output",
                       path, input);
    return SC_OK;
}

/* Pass on a file that a job reads, if there is one. */
static sc_status pass_on(const sc_input_visit *visit, const char *use, const char *path,
                         bool is_volume)
{
    return path && path[0] ? visit->each(visit->user, use, path, is_volume) : SC_OK;
}

/* Pass on a volume and its label table. @param labels the table that the job names; NULL or empty:
 * one beside the volume counts. */
static sc_status pass_on_volume(const sc_app *app, const sc_input_visit *visit, const char *volume,
                                const char *labels)
{
    sc_ctx quiet_ctx = sc_quiet(app->ctx);
    sc_app quiet = *app;
    char beside[SC_PATH_BYTES] = "";

    quiet.ctx = &quiet_ctx;
    if (volume && !(labels && *labels))
        sc_find_labels(&quiet, volume, beside);
    SC_PASS(pass_on(visit, "label volume", volume, true));
    return pass_on(visit, "label table", *beside ? beside : labels, false);
}

/* Pass on those files that each shot may have its own of. */
static sc_status pass_on_looks(const sc_input_visit *visit, const sc_job *job)
{
    SC_PASS(
        pass_on(visit, "table of values", job->given.color_by ? job->color_by.table : NULL, false));
    SC_PASS(pass_on(visit, "environment", job->light.environment.file, false));
    return pass_on(visit, "logo", job->overlays.logo, false);
}

sc_status sc_each_input(const sc_app *app, const sc_job *job, const sc_input_visit *visit)
{
    SC_PASS(pass_on_volume(app, visit, job->volume.path, job->volume.labels));
    SC_PASS(pass_on(visit, "grey volume", job->given.image ? job->image.path : NULL, true));
    for (size_t i = 0; i < job->volume.phase_count; i++)
        SC_PASS(pass_on(visit, "label volume of a phase", job->volume.phases[i].path, true));
    for (int i = 0; i < job->compare.count; i++) {
        SC_PASS(pass_on_volume(app, visit, job->compare.others[i].volume,
                               job->compare.others[i].labels));
        SC_PASS(pass_on(visit, "grey volume", job->compare.others[i].image, true));
    }
    SC_PASS(pass_on_looks(visit, job));
    for (size_t i = 0; i < job->film.shot_count; i++)
        SC_PASS(pass_on_looks(visit, &job->film.shots[i].job));
    return SC_OK;
}

/* For check_visited. */
typedef struct output_check {
    const sc_app *app;
    const char *path; /* of the output */
} output_check;

/* For sc_each_input with an output_check as user. */
static sc_status check_visited(void *user, const char *use, const char *path, bool is_volume)
{
    const output_check *check = user;

    return check_input(check->app, check->path, path, is_volume);
}

sc_status sc_check_output(const sc_app *app, const sc_job *job, const char *path, bool can_replace)
{
    output_check check = {app, path};
    const sc_input_visit visit = {check_visited, &check};

    if (access(path, F_OK) == 0) {
        SC_PASS(check_input(app, path, app->options.input, true));
        if (job)
            SC_PASS(sc_each_input(app, job, &visit));
    }
    return sc_outfile_check(app->ctx, path, app->options.overwrite,
                            can_replace ? ", or --overwrite to replace it" : "");
}

/* Does the file system of a directory take no files of its users? */
static bool takes_no_files(const char *directory)
{
#ifdef __linux__
    struct statfs info;

    return !statfs(directory, &info) &&
           (info.f_type == PROC_SUPER_MAGIC || info.f_type == SYSFS_MAGIC);
#else
    return false;
#endif
}

/* Find out why the directory @p path cannot be made or written to. @param path is cut to the part
 * that tells. @return NULL if it can, as far as that is known without trying. */
static const char *find_hindrance(char *path)
{
    const size_t length = strlen(path);
    struct stat info;

    for (;;) { /* up to what is there already */
        char *slash = strrchr(path, '/');

        if (!stat(path, &info))
            break;
        if (errno != ENOENT)
            return strerror(errno);
        if (slash && slash > path) /* also one at the end */
            *slash = '\0';
        else
            strcpy(path, slash ? "/" : ".");
    }
    if (!S_ISDIR(info.st_mode))
        return "is not a directory";
    if (access(path, W_OK | X_OK))
        return strerror(errno);
    return strlen(path) != length && takes_no_files(path) ? "takes no files" : NULL;
}

sc_status sc_check_directory(const sc_ctx *ctx, const char *where, const char *directory)
{
    SC_OWN(sc_free_at) char *path = NULL;
    const char *why;
    bool is_whole;

    SC_PASS(sc_text_copy(ctx, directory, &path));
    why = find_hindrance(path);
    is_whole = strcmp(path, directory) == 0;
    if (why)
        return sc_fail(ctx, SC_ERR_CREATE, "%s%s%s: cannot be written to%s%s: %s", where,
                       where[0] ? ": " : "", directory, is_whole ? "" : ": ", is_whole ? "" : path,
                       why);
    return SC_OK;
}

sc_status sc_check_ending(const sc_ctx *ctx, const char *path, const char *ending, const char *kind)
{
    if (sc_stem_length(path, &ending, 1))
        return SC_OK;
    return sc_fail(ctx, SC_ERR_USAGE, "%s: %s is written, expected a name ending in %s", path, kind,
                   ending);
}

void sc_print_made(const char *path)
{
    sc_print_path(stdout, path);
    printf("\n");
}

sc_status sc_print_json(const sc_ctx *ctx, json_t *json, size_t flags, const char *what)
{
    SC_OWN(sc_text_clear) sc_text text = {0};

    SC_PASS(sc_json_add_text(ctx, json, flags, what, &text));
    fputs(text.data, stdout);
    return SC_OK;
}

sc_status sc_write_text(const sc_app *app, const sc_text *text, const char *path)
{
    SC_OWN(sc_outfile_discard) sc_outfile file = {0};

    if (!strcmp(path, "-")) {
        fwrite(text->data, 1, text->length_bytes, stdout);
        return SC_OK;
    }
    SC_PASS(sc_outfile_open(app->ctx, path, app->options.overwrite, &file));
    fwrite(text->data, 1, text->length_bytes, file.stream);
    SC_PASS(sc_outfile_commit(app->ctx, &file));
    sc_print_made(path);
    return SC_OK;
}
