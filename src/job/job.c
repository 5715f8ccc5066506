/* SPDX-License-Identifier: BSD-3-Clause */
/* Loading a job: its sources are merged into one tree, which is then read by the table of keys. */
#include "segcast/job.h"

#include "describe.h"
#include "segcast/video.h"
#include "segcast/volume.h"

#include <stdlib.h>
#include <string.h>

enum { JOB_MAX_BYTES = 1 << 20 };

const sc_mode_default sc_mode_defaults[] = {{"paper", "render.surface", "voxel"},
                                            {"paper", "render.skip", "none"},
                                            {"paper", "render.samples", "1"},
                                            {"paper", "light.flat", "true"},
                                            {"paper-accelerated", "render.surface", "voxel"},
                                            {"paper-accelerated", "render.skip", "interior"},
                                            {"paper-accelerated", "render.samples", "1"},
                                            {"paper-accelerated", "light.flat", "true"},
                                            {0}};

/* @return the node at @p path, whose elements are keys without dots, or NULL if there is none. */
static const sc_yaml *find_node(const sc_yaml *root, const char *path)
{
    char key[64];

    while (root && *path) {
        const size_t length = strcspn(path, ".");

        snprintf(key, sizeof key, "%.*s", (int)length, path);
        root = sc_yaml_member(root, key);
        path += length + (path[length] == '.');
    }
    return root;
}

/* Put what render.mode implies into the tree, where it has no value for these keys yet. A mode that
 * is no word of the table is left to the reading of the tree. */
static sc_status apply_modes(const sc_ctx *ctx, sc_yaml *root)
{
    const sc_yaml *mode = find_node(root, "render.mode");
    sc_status status = SC_OK;

    for (const sc_mode_default *d = sc_mode_defaults; mode && d->mode && status == SC_OK; d++) {
        if (mode->kind == SC_YAML_SCALAR && !strcmp(mode->text, d->mode) &&
            !find_node(root, d->path))
            status = sc_setting_apply(ctx, sc_job_keys, root, "render.mode", d->path, d->value);
    }
    return status;
}

/* Put settings into the tree, the later over the earlier. @param only_missing skip those whose key
 * the tree has already. */
static sc_status apply_settings(const sc_ctx *ctx, const sc_setting *settings, size_t count,
                                bool only_missing, sc_yaml *root)
{
    sc_status status = SC_OK;

    for (size_t i = 0; i < count && status == SC_OK; i++) {
        const sc_setting *s = &settings[i];

        if (only_missing && find_node(root, s->path))
            continue;
        status = (s->literal ? sc_setting_apply_text : sc_setting_apply)(
            ctx, sc_job_keys, root, s->origin, s->path, s->value);
    }
    return status;
}

/* Put every variable that begins with SEGCAST_ into the tree. One that names no key is warned of
 * and skipped: it may belong to another program. */
static sc_status apply_environment(const sc_ctx *ctx, const char *const *environment, sc_yaml *root)
{
    static const char prefix[] = "SEGCAST_";
    sc_status status = SC_OK;

    for (; environment && *environment && status == SC_OK; environment++) {
        const char *entry = *environment, *equals = strchr(entry, '=');
        char name[256], path[256];

        if (strncmp(entry, prefix, sizeof prefix - 1) || !equals ||
            (size_t)(equals - entry) >= sizeof name)
            continue;
        snprintf(name, sizeof name, "%.*s", (int)(equals - entry), entry);
        if (!strcmp(name, "SEGCAST_THREADS"))
            continue; /* an option of the command line, not a key */
        if (sc_setting_path(sc_job_keys, name + sizeof prefix - 1, path, sizeof path))
            status = sc_setting_apply(ctx, sc_job_keys, root, entry, path, equals + 1);
        else
            sc_warn(ctx, "environment variable %s names no key of a job and is not used", name);
    }
    return status;
}

/* ---- checks after all keys have been read ---- */

bool sc_job_is_phantom(const char *volume)
{
    return !strcmp(volume, "phantom") || !strncmp(volume, "phantom:", 8);
}

/* Resolve @p path, which has room for SC_PATH_BYTES and was read from @p node (NULL: it is a
 * default). In the job file it is relative to that file, in a setting to the working directory. If
 * something exists there the path becomes absolute, so that the resolved job can be read from any
 * directory. */
static sc_status resolve_path(const sc_ctx *ctx, const sc_job_sources *sources, const sc_yaml *node,
                              char *path)
{
    const char *slash = sources->path ? strrchr(sources->path, '/') : NULL;
    char directory[SC_PATH_BYTES] = "", *joined = NULL, *absolute;
    const char *result;
    sc_status status;

    if (!node || !path[0])
        return SC_OK;
    if (node->line > 0 && slash) {
        if (slash - sources->path >= SC_PATH_BYTES)
            return sc_yaml_fail(ctx, node, "the path of the job file is longer than %d characters",
                                SC_PATH_BYTES - 1);
        snprintf(directory, sizeof directory, "%.*s", (int)(slash - sources->path), sources->path);
    }
    status = sc_path_join(ctx, directory, path, &joined);
    if (status != SC_OK)
        return status;
    absolute = realpath(joined, NULL);
    result = absolute ? absolute : joined;
    if (strlen(result) >= SC_PATH_BYTES)
        status = sc_yaml_fail(ctx, node, "the path has %zu characters, expected less than %d",
                              strlen(result), SC_PATH_BYTES);
    else
        strcpy(path, result);
    free(absolute);
    sc_free(joined);
    return status;
}

/* Check what no single row can, and resolve the paths of the job in place. @p root: the tree that
 * the job was read from, for line numbers. @return SC_ERR_DATA, or SC_ERR_USAGE for what a setting
 * said. */
static sc_status check(const sc_ctx *ctx, const sc_job_sources *sources, const sc_yaml *root,
                       sc_job *job)
{
    const sc_yaml *fixed = find_node(root, "animation.camera.fixed");
    const sc_orbit *camera = &job->animation.camera;
    sc_status status;

    if (strcmp(job->output.video, "none") &&
        (!sc_video_name_ok(job->output.video) || strchr(job->output.video, '/')))
        return sc_yaml_fail(ctx, find_node(root, "output.video"),
                            "video is \"%s\", expected a name ending in .mp4, .mkv or .webm, "
                            "without a folder, or none",
                            job->output.video);
    if (fixed && sc_vec3_length(sc_vec3_sub(camera->position_mm, camera->target_mm)) < 1e-6)
        return sc_yaml_fail(ctx, fixed, "position_mm and target_mm are the same point");
    if (!sc_job_is_phantom(job->volume))
        SC_TRY(resolve_path(ctx, sources, find_node(root, "volume"), job->volume));
    SC_TRY(resolve_path(ctx, sources, find_node(root, "labels"), job->labels));
    status = resolve_path(ctx, sources, find_node(root, "output.directory"), job->output.directory);
out:
    return status;
}

/* Read the job file into a tree, an empty one if there is no file. @p text holds the file, which
 * stays with the caller, also after an error. */
static sc_status read_root(const sc_ctx *ctx, const sc_job_sources *sources, char **text,
                           sc_yaml **out)
{
    const char *origin = sources->path ? sources->path : "command line";
    size_t bytes = 0;
    sc_status status = SC_OK;

    if (sources->path)
        SC_TRY(sc_file_read(ctx, sources->path, JOB_MAX_BYTES, text, &bytes));
    SC_TRY(sc_yaml_parse(ctx, origin, *text ? *text : "", bytes, out));
    if (!sources->path)
        (*out)->line = 0;
    if ((*out)->kind != SC_YAML_MAP)
        status = sc_wrong_type(ctx, *out, "a map of keys such as volume and output");
out:
    return status;
}

sc_status sc_job_load(const sc_ctx *ctx, const sc_job_sources *sources, sc_job *out)
{
    char *text = NULL;
    sc_yaml *root = NULL;
    sc_job job = {0};
    sc_status status;

    SC_TRY(sc_keys_set_defaults(ctx, sc_job_keys, &job));
    SC_TRY(read_root(ctx, sources, &text, &root));
    SC_TRY(apply_settings(ctx, sources->defaults, sources->default_count, true, root));
    SC_TRY(apply_environment(ctx, sources->environment, root));
    SC_TRY(apply_settings(ctx, sources->settings, sources->setting_count, false, root));
    SC_TRY(apply_modes(ctx, root));
    SC_TRY(sc_keys_read(ctx, sc_job_keys, root, &job));
    SC_TRY(check(ctx, sources, root, &job));
    *out = job;
    job = (sc_job){0};
out:
    sc_job_clear(&job);
    sc_yaml_free(root);
    sc_free(text);
    return status;
}

void sc_job_clear(sc_job *job)
{
    sc_free(job->rules);
    sc_free(job->exceptions);
    *job = (sc_job){0};
}

sc_status sc_job_write(const sc_ctx *ctx, const sc_job *job, bool identity, sc_text *text)
{
    return sc_keys_write(ctx, sc_job_keys, job, 0, identity, text);
}
