/* SPDX-License-Identifier: BSD-3-Clause */
/* What the argument of a command is, in order to tell users who give a volume where a job is
 * expected, or a file where a command is, which command they want. */
#include "segcast/cli.h"
#include "segcast/volume.h"

#include <sys/stat.h>
#include <unistd.h>

/* What a path names, or would name if it existed. */
typedef enum kind {
    KIND_UNKNOWN,
    KIND_JOB,
    KIND_VOLUME,
    KIND_DIRECTORY,
    KIND_FILE, /* text, which may be a job */
    KIND_OTHER /* neither, but the readers of volumes say what it is */
} kind;

/* @return what @p path names: by the end of the name, else by the first bytes. @param exists
 * whether there is such a file or directory. */
static kind kind_of(const char *path, bool *exists)
{
    static const char *const jobs[] = {".yaml", ".yml"};
    /* unknown to sc_volume_stem_bytes: volumes, and files that their readers refuse with advice */
    static const char *const others[] = {".h5", ".hdf5", ".mnc", ".mrml"};
    const size_t length = strlen(path);
    struct stat info;

    *exists = stat(path, &info) == 0;
    if (*exists && S_ISDIR(info.st_mode))
        return KIND_DIRECTORY;
    if (!*exists && path[sc_volume_file_length(path)]) { /* a path inside a file */
        *exists = true;
        return KIND_VOLUME;
    }
    if (sc_stem_length(path, jobs, SC_COUNT_OF(jobs)))
        return KIND_JOB;
    if (sc_volume_stem_bytes(path, length) < length ||
        sc_stem_length(path, others, SC_COUNT_OF(others)))
        return KIND_VOLUME;
    if (!*exists || !S_ISREG(info.st_mode))
        return KIND_UNKNOWN;
    switch (sc_file_kind_of(path)) {
    case SC_FILE_VOLUME:
        return KIND_VOLUME;
    case SC_FILE_OTHER:
        return KIND_OTHER;
    case SC_FILE_TEXT:
        break;
    }
    return KIND_FILE;
}

bool sc_input_is_volume(const char *path)
{
    bool exists;
    const kind what = kind_of(path, &exists);

    return what == KIND_VOLUME || what == KIND_DIRECTORY;
}

bool sc_input_may_be_job(const char *path)
{
    bool exists;
    const kind what = kind_of(path, &exists);

    return what == KIND_JOB || what == KIND_FILE || what == KIND_UNKNOWN;
}

bool sc_input_is_job(const char *path)
{
    bool exists;

    return kind_of(path, &exists) == KIND_JOB;
}

sc_status sc_input_as_command(const sc_ctx *ctx, const char *name)
{
    bool exists;
    const kind what = kind_of(name, &exists);
    const char *is = exists ? "is" : "is named like";

    if (what == KIND_JOB)
        return sc_fail(ctx, SC_ERR_USAGE,
                       "\"%s\" %s a job file, not a command: `segcast render %s` makes its video, "
                       "`segcast check %s` says whether it can run",
                       name, is, name, name);
    if (what == KIND_VOLUME)
        return sc_fail(
            ctx, SC_ERR_USAGE,
            "\"%s\" %s a volume, not a command: `segcast orbit %s` makes a video of it, `segcast "
            "info %s` tells what it holds, `segcast init %s` writes a job file for it",
            name, is, name, name, name);
    if (what == KIND_DIRECTORY)
        return sc_fail(ctx, SC_ERR_USAGE,
                       "\"%s\" is a directory, not a command: `segcast status %s` and `segcast "
                       "verify %s` tell of the job in it; if it holds masks of tissues, `segcast "
                       "orbit %s` makes a video of it",
                       name, name, name, name);
    return SC_OK;
}

/* For a command that takes a volume: the one that does the same with a job. */
static const char *job_command_for(const char *name)
{
    static const char *const pairs[][2] = {
        {"orbit", "render"}, {"info", "check"}, {"init", "check"}};

    for (size_t i = 0; i < SC_COUNT_OF(pairs); i++) {
        if (!strcmp(name, pairs[i][0]))
            return pairs[i][1];
    }
    return "render";
}

/* Is there a manifest in the directory, as in one that a job has made? */
static bool holds_run(const char *directory)
{
    char path[SC_PATH_BYTES];
    const int length = snprintf(path, sizeof path, "%s/manifest.jsonl", directory);

    return length < (int)sizeof path && access(path, F_OK) == 0;
}

sc_status sc_input_check(const sc_ctx *ctx, const sc_command *command, const char *input)
{
    const bool takes_job = strstr(command->argument, "JOB"),
               takes_volume = strstr(command->argument, "VOLUME"),
               takes_directory = strstr(command->argument, "DIR");
    bool exists = false;
    const kind what = input ? kind_of(input, &exists) : KIND_UNKNOWN;

    if (what == KIND_VOLUME && takes_job && !takes_volume)
        return sc_fail(
            ctx, SC_ERR_USAGE,
            "segcast %s takes a job file, but \"%s\" %s a volume: `segcast orbit %s` makes a video "
            "of it without a job, `segcast init %s` writes a job file for it",
            command->name, input, exists ? "is" : "is named like", input, input);
    if (what == KIND_DIRECTORY && takes_job && !takes_volume && !takes_directory)
        return sc_fail(
            ctx, SC_ERR_USAGE,
            "segcast %s takes a job file, but \"%s\" is a directory: if it holds masks of tissues, "
            "`segcast orbit %s` makes a video of it without a job, and `segcast init %s` writes a "
            "job file for it; if a job has made it, give that job",
            command->name, input, input, input);
    if (what == KIND_DIRECTORY && takes_job && takes_volume && holds_run(input))
        return sc_fail(ctx, SC_ERR_USAGE,
                       "segcast %s takes a job file or a volume, but \"%s\" is the directory that "
                       "a job has made: `segcast %s %s/job.yaml` takes that job",
                       command->name, input, command->name, input);
    if (what == KIND_JOB && takes_volume && !takes_job)
        return sc_fail(
            ctx, SC_ERR_USAGE,
            "segcast %s takes a volume, but \"%s\" %s a job file: `segcast %s %s` takes one",
            command->name, input, exists ? "is" : "is named like", job_command_for(command->name),
            input);
    if (takes_directory && !takes_job && exists && what != KIND_DIRECTORY && what != KIND_UNKNOWN)
        return sc_fail(ctx, SC_ERR_USAGE,
                       "segcast %s takes the directory that a job has made (its output.directory), "
                       "but \"%s\" is a file",
                       command->name, input);
    return SC_OK;
}
