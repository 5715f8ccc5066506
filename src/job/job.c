/* SPDX-License-Identifier: BSD-3-Clause */
#include "segcast/job.h"

#include "job_fields.h"
#include "segcast/video.h"
#include "segcast/volume.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { JOB_MAX_BYTES = 1 << 20 };

static void set_defaults(sc_job *job)
{
    *job = (sc_job){
        .output = {.directory = "segcast-out",
                   .video = "video.mp4",
                   .size_px = {1280, 720},
                   .fps = 30,
                   .crf = 18,
                   .preset = 5},
        .render = {.surface = SC_SURFACE_SMOOTH,
                   .smooth = 1,
                   .skip = SC_SKIP_LEAP,
                   .caps = 1,
                   .samples = 4,
                   .step_voxels = 0.5,
                   .background = {255, 255, 255}},
        .light = sc_lighting_default(),
        .farm = {.tile_px = 32, .share = true},
        .animation = {.frames = 180,
                      .camera = {.axis = {0, 0, 1},
                                 .turns = 1,
                                 .elevation_deg = 15,
                                 .fov_deg = 30,
                                 .up = {0, 0, 1},
                                 .zoom = {1, 1, 0, 1, 0}},
                      .slices = {.share = {0, 1, 0, 1, 0}}},
    };
}

/* A mode sets other defaults for the keys that are not given. */
static sc_status apply_mode(const sc_ctx *ctx, const sc_yaml *root, sc_job *job)
{
    const sc_yaml *render = sc_yaml_member(root, "render");
    const sc_yaml *mode =
        render && render->kind == SC_YAML_MAP ? sc_yaml_member(render, "mode") : NULL;
    const sc_field *field = NULL;
    sc_status status;

    if (!mode)
        return SC_OK;
    for (field = sc_job_fields; strcmp(field->name, "render"); field++) {
    }
    for (field = field->fields; strcmp(field->name, "mode"); field++) {
    }
    status = field->type->parse(ctx, field, mode, &job->render);
    if (status != SC_OK || job->render.mode == SC_MODE_STANDARD)
        return status;
    job->render.surface = SC_SURFACE_VOXEL;
    job->render.skip = job->render.mode == SC_MODE_PAPER ? SC_SKIP_NONE : SC_SKIP_INTERIOR;
    job->render.samples = 1;
    job->light.flat = true;
    return SC_OK;
}

/* One "key.path=value", parsed like a piece of the job file. */
static sc_status apply_setting(const sc_ctx *ctx, sc_yaml *root, const char *origin,
                               const char *path, const char *value)
{
    sc_yaml *node = NULL;
    sc_status status = sc_yaml_parse(ctx, origin, value, strlen(value), &node);

    if (status != SC_OK)
        return SC_ERR_USAGE;
    node->line = 0;
    for (size_t i = 0; i < node->count; i++)
        node->items[i]->line = 0;
    return sc_yaml_set(ctx, root, path, node);
}

static sc_status apply_command_line(const sc_ctx *ctx, const sc_job_sources *sources, sc_yaml *root)
{
    sc_status status = SC_OK;

    for (size_t i = 0; i < sources->setting_count && status == SC_OK; i++) {
        const char *setting = sources->settings[i], *equals = strchr(setting, '=');
        char path[512];

        if (!equals || (size_t)(equals - setting) >= sizeof path)
            return sc_fail(ctx, SC_ERR_USAGE, "--set %s: expected key.path=value", setting);
        snprintf(path, sizeof path, "%.*s", (int)(equals - setting), setting);
        status = apply_setting(ctx, root, setting, path, equals + 1);
    }
    return status;
}

/* Does @p name begin with a key, case ignored, and end or go on with "_"? @return its length. */
static size_t match_key(const char *name, const char *key)
{
    const size_t length = strlen(key);

    if (strncasecmp(name, key, length) != 0 || (name[length] && name[length] != '_'))
        return 0;
    return length;
}

/* SEGCAST_RENDER_SAMPLES names render.samples. */
static bool find_path(const sc_field *fields, const char *name, char *path, size_t size)
{
    for (const sc_field *field = fields; field->name; field++) {
        const size_t length = match_key(name, field->name), used = strlen(path);

        if (!length || !name[length] == (field->fields != NULL))
            continue;
        snprintf(path + used, size - used, "%s%s", used ? "." : "", field->name);
        if (!name[length] || find_path(field->fields, name + length + 1, path, size))
            return true;
        path[used] = '\0';
    }
    return false;
}

static sc_status apply_environment(const sc_ctx *ctx, const sc_job_sources *sources, sc_yaml *root)
{
    static const char prefix[] = "SEGCAST_";
    sc_status status = SC_OK;

    for (const char *const *entry = sources->environment; entry && *entry && status == SC_OK;
         entry++) {
        const char *equals = strchr(*entry, '=');
        char name[256], path[256] = "";

        if (strncmp(*entry, prefix, sizeof prefix - 1) || !equals ||
            (size_t)(equals - *entry) >= sizeof name)
            continue;
        snprintf(name, sizeof name, "%.*s", (int)(equals - *entry), *entry);
        if (!strcmp(name, "SEGCAST_THREADS"))
            continue; /* an option of the command line, not of the job */
        if (find_path(sc_job_fields, name + sizeof prefix - 1, path, sizeof path))
            status = apply_setting(ctx, root, *entry, path, equals + 1);
        else
            sc_warn(ctx, "environment variable %s names no key of a job and is not used", name);
    }
    return status;
}

/* A path of the job file is relative to the job file; one of an option, to where we are. What
 * exists is kept as an absolute path, so that the job as resolved can be read from anywhere. */
static sc_status resolve_path(const sc_ctx *ctx, const sc_job_sources *sources, const sc_yaml *node,
                              char *path)
{
    const char *slash = sources->path ? strrchr(sources->path, '/') : NULL;
    char directory[SC_PATH_BYTES] = "", *joined = NULL, *absolute;
    const char *result;
    sc_status status;

    if (!node || !path[0])
        return SC_OK;
    if (node->line > 0 && slash)
        snprintf(directory, sizeof directory, "%.*s", (int)(slash - sources->path), sources->path);
    status = sc_path_join(ctx, directory, path, &joined);
    if (status != SC_OK)
        return status;
    absolute = realpath(joined, NULL);
    result = absolute ? absolute : joined;
    if (strlen(result) >= SC_PATH_BYTES)
        status = sc_yaml_fail(ctx, node, "the path is too long");
    else
        strcpy(path, result);
    free(absolute);
    sc_free(joined);
    return status;
}

static sc_status check(const sc_ctx *ctx, const sc_job_sources *sources, const sc_yaml *root,
                       sc_job *job)
{
    const sc_yaml *output = sc_yaml_member(root, "output");
    const sc_yaml *video = output ? sc_yaml_member(output, "video") : NULL;
    const sc_yaml *directory = output ? sc_yaml_member(output, "directory") : NULL;
    sc_status status;

    if (!job->volume[0])
        return sc_yaml_fail(ctx, root, "no volume is named; expected volume: FILE or phantom");
    if (strcmp(job->output.video, "none") &&
        (!sc_video_name_ok(job->output.video) || strchr(job->output.video, '/')))
        return sc_yaml_fail(ctx, video ? video : root,
                            "video is \"%s\", expected a name ending in .mp4, .mkv or .webm, "
                            "without a folder, or none",
                            job->output.video);
    if (strncmp(job->volume, "phantom", 7))
        SC_TRY(resolve_path(ctx, sources, sc_yaml_member(root, "volume"), job->volume));
    SC_TRY(resolve_path(ctx, sources, sc_yaml_member(root, "labels"), job->labels));
    status = resolve_path(ctx, sources, directory, job->output.directory);
out:
    return status;
}

static sc_status read_root(const sc_ctx *ctx, const sc_job_sources *sources, char **text,
                           sc_yaml **out)
{
    const char *origin = sources->path ? sources->path : "command line";
    size_t bytes = 0;
    sc_status status = SC_OK;

    if (sources->path)
        SC_TRY(sc_file_read(ctx, sources->path, JOB_MAX_BYTES, text, &bytes));
    SC_TRY(sc_yaml_parse(ctx, origin, *text ? *text : "", bytes, out));
    if ((*out)->kind != SC_YAML_MAP)
        status = sc_wrong_type(ctx, *out, "a map of keys such as volume and output");
out:
    return status;
}

sc_status sc_job_load(const sc_ctx *ctx, const sc_job_sources *sources, sc_job *out)
{
    char *text = NULL;
    sc_yaml *root = NULL;
    sc_job job;
    sc_status status;

    set_defaults(&job);
    SC_TRY(read_root(ctx, sources, &text, &root));
    SC_TRY(apply_environment(ctx, sources, root));
    SC_TRY(apply_command_line(ctx, sources, root));
    SC_TRY(apply_mode(ctx, root, &job));
    SC_TRY(sc_fields_parse(ctx, sc_job_fields, root, &job));
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
    return sc_fields_write(ctx, sc_job_fields, job, 0, identity, text);
}
