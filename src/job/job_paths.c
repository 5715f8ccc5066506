/* SPDX-License-Identifier: BSD-3-Clause */
/* The paths of a job: found from where they are written, and made absolute. */
#include "key.h"
#include "segcast/job.h"
#include "segcast/volume.h"

#include <ctype.h>
#include <errno.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

/* The characters of the name of a variable. */
#define WORD "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_"

bool sc_job_is_phantom(const char *volume)
{
    return !strcmp(volume, "phantom") || !strncmp(volume, "phantom:", 8);
}

/* @return the value of HOME, or NULL. @param environment as of sc_job_sources. */
static const char *home_of(const char *const *environment)
{
    for (; environment && *environment; environment++) {
        if (!strncmp(*environment, "HOME=", 5))
            return *environment + 5;
    }
    return NULL;
}

/* @return where in a path something stands that only a shell replaces: "~" at its beginning, or a
 * variable such as $HOME or ${HOME}; NULL: nowhere. */
static const char *shell_part(const char *path)
{
    if (path[0] == '~')
        return path;
    for (const char *c = strchr(path, '$'); c; c = strchr(c + 1, '$')) {
        if (isalpha((unsigned char)c[1]) || c[1] == '_' || c[1] == '{')
            return c;
    }
    return NULL;
}

/* Log that a part of a path was not replaced. @param part as of shell_part. @return as
 * sc_yaml_fail.
 */
static sc_status refuse_shell(const sc_ctx *ctx, const sc_job_sources *sources, const sc_yaml *node,
                              const char *key, const char *path, const char *part)
{
    const char *home = home_of(sources->environment);
    const size_t length = *part == '~'     ? 1
                          : part[1] == '{' ? strcspn(part, "}") + (strchr(part, '}') != NULL)
                                           : 1 + strspn(part + 1, WORD);

    if (home && *part == '~' && (!path[1] || path[1] == '/'))
        return sc_yaml_fail(
            ctx, node,
            "%s is \"%s\", but only a shell replaces \"~\", and only outside of quotes; write %s%s",
            key, path, home, path + 1);
    return sc_yaml_fail(ctx, node,
                        "%s is \"%s\", but only a shell replaces \"%.*s\", and only outside of "
                        "%squotes; write the whole path",
                        key, path, (int)length, part, *part == '~' ? "" : "single ");
}

sc_status sc_path_beside(const sc_ctx *ctx, const char *file, const char *path, char **out)
{
    const char *slash = file ? strrchr(file, '/') : NULL;
    SC_OWN(sc_text_clear) sc_text directory = {0};

    if (slash)
        SC_PASS(sc_text_add(ctx, &directory, "%.*s", slash > file ? (int)(slash - file) : 1, file));
    return sc_path_join(ctx, directory.data, path, out);
}

/* Write @p path, as it stands in @p node, to *out: in the job file it is relative to that file, in
 * a setting to the working directory. Caller owns *out: sc_free. */
static sc_status locate(const sc_ctx *ctx, const sc_job_sources *sources, const sc_yaml *node,
                        const char *path, char **out)
{
    return sc_path_beside(ctx, node->line > 0 ? sources->path : NULL, path, out);
}

/* Refuse an input that cannot be read, or is not of the kind that is expected. @param shown the
 * path for messages. */
static sc_status check_input(const sc_ctx *ctx, const sc_yaml *node, const char *key,
                             sc_path_use use, const char *path, const char *shown)
{
    char file[SC_PATH_BYTES];
    struct stat info;

    snprintf(file, sizeof file, "%.*s", (int)sc_volume_file_length(path), path);
    if (stat(file, &info) ||
        access(file,
               S_ISDIR(info.st_mode) ? R_OK | X_OK : R_OK)) /* a directory is looked through */
        return sc_tell_missing(ctx, node, key, shown, errno);
    if (S_ISDIR(info.st_mode) && use == SC_PATH_FILE)
        return sc_tell_input(ctx, node, key, shown, SC_ERR_MISSING,
                             "is a directory, expected a file");
    if (!S_ISDIR(info.st_mode) && !S_ISREG(info.st_mode))
        return sc_tell_input(ctx, node, key, shown, SC_ERR_MISSING,
                             "is a pipe or a device, expected a file; write it to a file first");
    return SC_OK;
}

sc_status sc_resolve_path(const sc_ctx *ctx, const sc_job_sources *sources, const sc_yaml *node,
                          const char *key, sc_path_use use, char *path)
{
    const bool is_input = use != SC_PATH_OUTPUT;
    SC_OWN(sc_free_at) char *joined = NULL, *absolute = NULL;
    bool no_memory;
    int error;

    if (!node || !path[0])
        return SC_OK;
    SC_PASS(locate(ctx, sources, node, path, &joined));
    absolute = is_input ? sc_volume_real_path(joined) : realpath(joined, NULL);
    error = absolute ? 0 : errno;
    no_memory = error && sc_input_status(error) == SC_ERR_MEMORY;
    if (!absolute && !no_memory && shell_part(path) && (!is_input || sources->check_inputs))
        return refuse_shell(ctx, sources, node, key, path, shell_part(path));
    if (no_memory || (!absolute && is_input && sources->check_inputs))
        return sc_tell_missing(ctx, node, key, joined, error);
    if (strlen(absolute ? absolute : joined) >= SC_PATH_BYTES)
        return sc_yaml_fail(ctx, node, "the path has %zu characters, expected less than %d",
                            strlen(absolute ? absolute : joined), SC_PATH_BYTES);
    strcpy(path, absolute ? absolute : joined);
    return is_input && sources->check_inputs ? check_input(ctx, node, key, use, path, joined)
                                             : SC_OK;
}

/* Find the files of a pattern that the job @p job has as its volume. */
static sc_status find_series(const sc_ctx *ctx, const sc_job_sources *sources, const sc_yaml *node,
                             const char *key, sc_job *job)
{
    SC_OWN(sc_free_at) char *joined = NULL;
    SC_OWN(sc_text_clear) sc_text pattern = {0};
    size_t directory;

    SC_PASS(locate(ctx, sources, node, job->volume.path, &joined));
    if (access(joined, F_OK) == 0) /* a file may have such a name */
        return sc_resolve_path(ctx, sources, node, key, SC_PATH_INPUT, job->volume.path);
    /* The directory of the job file is no pattern, whatever its name. */
    directory = strlen(joined) - strlen(job->volume.path);
    for (size_t i = 0; joined[i]; i++)
        SC_PASS(sc_text_add(ctx, &pattern, "%s%c",
                            i < directory && strchr("*?[]\\", joined[i]) ? "\\" : "", joined[i]));
    SC_PASS(sc_series_find(ctx, node, key, pattern.data, job));
    strcpy(job->volume.path, job->volume.phases[0].path);
    return SC_OK;
}

sc_status sc_resolve_volume(const sc_ctx *ctx, const sc_job_sources *sources, const sc_yaml *node,
                            const char *key, sc_job *job)
{
    sc_status status = SC_OK;

    if (!job->volume.phase_count)
        return node && sources->check_inputs && strpbrk(job->volume.path, "*?")
                   ? find_series(ctx, sources, node, key, job)
                   : sc_resolve_path(ctx, sources, node, key, SC_PATH_INPUT, job->volume.path);
    for (size_t i = 0; i < job->volume.phase_count; i++) {
        if (!sc_goes_on(&status, sc_resolve_path(ctx, sources, node->items[i], key, SC_PATH_INPUT,
                                                 job->volume.phases[i].path)))
            break;
    }
    strcpy(job->volume.path, job->volume.phases[0].path);
    return status;
}
