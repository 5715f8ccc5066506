/* SPDX-License-Identifier: BSD-3-Clause */
/* The cells of a study: which job each of them is, and whether it can run here. */
#include "study/study.h"

#include "segcast/kernel.h"

#include <errno.h>
#include <unistd.h>

enum { SPREAD_FRAMES = 4 }; /* frames that are measured unless the study lists them */

void sc_study_clear_cells(sc_study_state *state)
{
    sc_free(state->cells);
    sc_free(state->told);
    sc_free(state->work);
    sc_free(state->made_from);
    sc_design_clear(&state->design);
    sc_study_clear(&state->study);
}

/* ---- settings ---- */

static void clear_settings(sc_study_settings *settings)
{
    sc_free(settings->items);
}

sc_status sc_study_cell_options(const sc_study_state *state, int cell, sc_options *options)
{
    const sc_options *given = &state->app->options;
    SC_OWN(clear_settings) sc_study_settings settings = {.count = 0};

    SC_PASS(sc_study_cell(state->app->ctx, &state->study, cell, &settings));
    if (settings.count + given->settings.count >= SC_SETTINGS_MAX)
        return sc_fail(state->app->ctx, SC_ERR_USAGE,
                       "a cell has %zu settings, expected at most %d",
                       settings.count + given->settings.count, SC_SETTINGS_MAX - 1);
    options->settings.count = 0;
    for (size_t i = 0; i < settings.count; i++)
        options->settings.all[options->settings.count++] = settings.items[i];
    for (size_t i = 0; i < given->settings.count; i++)
        options->settings.all[options->settings.count++] = given->settings.all[i];
    if (state->cpu && state->cells[cell].any_cpu)
        options->settings.all[options->settings.count++] =
            (sc_setting){.origin = "render.cpu", .path = "render.cpu", .value = state->cpu};
    return SC_OK;
}

/* Load the job of a cell, alone on rank 0. Caller owns *out: sc_job_clear. */
static sc_status load_job(const sc_study_state *state, int cell, sc_job *out)
{
    SC_OWN(sc_free_at) sc_options *options = NULL;
    sc_job_sources sources;
    sc_status status;

    SC_PASS(SC_ALLOC(state->app->ctx, 1, &options));
    *options = state->app->options;
    SC_PASS(sc_study_cell_options(state, cell, options));
    sources = (sc_job_sources){.path = state->study.job[0] ? state->study.job : NULL,
                               .name = state->app->options.input,
                               .settings = options->settings.all,
                               .setting_count = options->settings.count,
                               .environment = state->app->environment,
                               .check_inputs = true};
    status = sc_job_load(state->app->ctx, &sources, out);
    if (status != SC_OK)
        sc_job_clear(out);
    return status;
}

/* ---- what a job's keys stand for ---- */

/* Add to @p hash the YAML of a job. */
static sc_status hash_job(const sc_ctx *ctx, const sc_job *job, bool identity, uint64_t *hash)
{
    SC_OWN(sc_text_clear) sc_text text = {0};

    SC_PASS(sc_job_write(ctx, job, identity, &text));
    *hash = sc_hash_bytes(text.data, text.length_bytes, *hash);
    return SC_OK;
}

/* Hash what the prepared volume depends on: the volume, its table, the tissues, and some of the
 * keys of render. */
static sc_status hash_volume(const sc_ctx *ctx, const sc_job *job, uint64_t *out)
{
    sc_job part = *job;

    part.output = (sc_output){.fps = 1, .size_px = {16, 16}};
    part.light.constant = (sc_lighting){0};
    part.light.tracks = (sc_light_tracks){0};
    part.animation = (sc_animation){.frames = 1};
    part.farm = (sc_farm_options){.tile_px = 8};
    part.tissues.exceptions = NULL;
    part.tissues.exception_count = 0;
    part.given.verbs = false;
    part.render.skip = 0;
    part.render.cpu = 0;
    part.render.early_termination = true;
    part.render.caps = 0;
    part.render.stage = 0;
    part.render.quality = 0;
    part.render.step_voxels = 1;
    part.render.cap_outline = 0;
    part.render.background = (sc_background){.is_auto = true};
    *out = 1;
    return hash_job(ctx, &part, false, out);
}

/* @return a hash of key frames of columns, if there are any. */
static uint64_t hash_columns(const sc_column_track *track, uint64_t hash)
{
    for (int i = 0; i < track->steps.count; i++) {
        const sc_key_frame *key = &track->steps.keys[i];
        const int kind = key->ease.kind;

        hash = sc_hash_bytes(track->columns[i], strlen(track->columns[i]), hash);
        hash = sc_hash_bytes(&key->at, sizeof key->at, hash);
        hash = sc_hash_bytes(&kind, sizeof kind, hash);
        hash = sc_hash_bytes(key->ease.bezier, sizeof key->ease.bezier, hash);
    }
    return hash;
}

/* Hash what the pictures depend on, and which frames are measured; count these. */
static sc_status hash_picture(const sc_study_state *state, const sc_job *job, uint64_t *out,
                              int32_t *frame_count)
{
    SC_OWN(sc_free_at) int *frames = NULL;
    int count;
    uint64_t hash = 2;

    SC_PASS(hash_job(state->app->ctx, job, true, &hash));
    hash = sc_hash_bytes(job->volume.path, strlen(job->volume.path), hash);
    for (size_t i = 1; i < job->volume.phase_count; i++)
        hash = sc_hash_bytes(job->volume.phases[i].path, strlen(job->volume.phases[i].path), hash);
    hash = sc_hash_bytes(job->volume.labels, strlen(job->volume.labels), hash);
    hash = sc_hash_bytes(job->volume.size, sizeof job->volume.size, hash);
    hash = sc_hash_bytes(job->volume.resample_mm, sizeof job->volume.resample_mm, hash);
    hash = sc_hash_bytes(&job->color_by.measure, sizeof job->color_by.measure, hash);
    hash = sc_hash_bytes(job->color_by.table, strlen(job->color_by.table), hash);
    hash = sc_hash_bytes(job->image.path, strlen(job->image.path), hash);
    hash = sc_hash_bytes(job->color_by.column, strlen(job->color_by.column), hash);
    hash = hash_columns(&job->color_columns, hash);
    SC_PASS(sc_study_frames(state, job, &frames, &count));
    *out = sc_hash_bytes(frames, (size_t)count * sizeof *frames, hash);
    *frame_count = count;
    return SC_OK;
}

sc_status sc_study_frames(const sc_study_state *state, const sc_job *job, int **out, int *count)
{
    const sc_ctx *ctx = state->app->ctx;
    const int total = job->animation.frames;
    const sc_ctx silent = {.rank = 0};
    const bool whole = state->whole_jobs;
    const int spread = whole || total < SPREAD_FRAMES ? total : SPREAD_FRAMES;
    sc_status status;

    if (state->study.frames[0] && !whole) {
        status = sc_frames_parse(&silent, state->study.frames, total, out, count);
        if (status == SC_ERR_USAGE)
            return sc_fail(
                ctx, SC_ERR_DATA,
                "%s: frames is \"%s\", expected frames of the animation, 0 to %d, such as 0-179:45",
                state->app->options.input, state->study.frames, total - 1);
        if (status == SC_OK && *count > SC_STUDY_FRAMES_MAX) {
            sc_free(*out);
            *out = NULL;
            return sc_fail(ctx, SC_ERR_USAGE, "frames lists %d frames, expected at most %d", *count,
                           SC_STUDY_FRAMES_MAX);
        }
        return status;
    }
    SC_PASS(SC_ALLOC(ctx, (size_t)spread, out));
    for (int i = 0; i < spread; i++)
        (*out)[i] = (int)((int64_t)total * i / spread);
    *count = spread;
    return SC_OK;
}

/* ---- cells ---- */

/* Has no cell before this one the same volume, with the same tissues? */
static bool has_new_volume(const sc_study_state *state, int cell)
{
    for (int i = 0; i < cell; i++) {
        if (state->cells[i].volume_key == state->cells[cell].volume_key)
            return false;
    }
    return true;
}

/* Can this build and processor draw as @p job says, by the variant that it names? @param cpu the
 * best variant that the cells before have that name none: made one that this cell has, too. */
static void look_for_kernel(const sc_job *job, sc_cell_info *info, const char **cpu)
{
    const char *name = sc_cpu_names[job->render.cpu];
    const bool wide = sc_skip_is_wide((sc_skip)job->render.skip);
    const sc_kernel *kernel;

    info->any_cpu = wide && job->render.cpu == 0;
    kernel = sc_kernel_find((sc_surface)job->render.surface, (sc_skip)job->render.skip, NULL,
                            info->any_cpu ? *cpu : name);
    info->runs_here =
        kernel && sc_cpu_has(name) && (!wide || info->any_cpu || strcmp(kernel->cpu, name) == 0);
    if (info->any_cpu && kernel)
        *cpu = kernel->cpu;
}

/* Fill in what is known of a cell, and add it to the hash of the study. @param cpu see
 * look_for_kernel. */
static sc_status fill_cell(sc_study_state *state, int cell, uint64_t *hash, const char **cpu)
{
    const sc_app *app = state->app;
    sc_cell_info *info = &state->cells[cell];
    SC_OWN(clear_settings) sc_study_settings settings = {.count = 0};
    SC_OWN(sc_job_clear) sc_job job = {0};
    sc_status mistakes;

    SC_PASS(sc_study_cell(app->ctx, &state->study, cell, &settings));
    info->ranks = settings.ranks ? settings.ranks : sc_comm_size(app->comm);
    info->threads = settings.threads ? settings.threads : app->threads;
    info->placement = settings.placement;
    SC_PASS(load_job(state, cell, &job));
    SC_PASS(hash_volume(app->ctx, &job, &info->volume_key));
    mistakes = has_new_volume(state, cell) ? sc_check_job_tissues(state->app, &job) : SC_OK;
    SC_PASS(hash_picture(state, &job, &info->picture, &info->frames));
    SC_PASS(hash_job(app->ctx, &job, false, hash));
    *hash = sc_hash_bytes(&info->picture, sizeof info->picture, *hash);
    *hash = sc_hash_bytes(&settings.ranks, sizeof settings.ranks, *hash);
    *hash = sc_hash_bytes(&settings.threads, sizeof settings.threads, *hash);
    look_for_kernel(&job, info, cpu);
    info->runs_here = info->runs_here && info->ranks <= sc_comm_size(app->comm) &&
                      (!settings.threads || info->threads <= sc_usable_cores());
    return mistakes;
}

void sc_study_why_not(const sc_study_state *state, int cell, char *text, size_t size)
{
    const sc_cell_info *info = &state->cells[cell];

    if (info->ranks > sc_comm_size(state->app->comm))
        snprintf(text, size, "needs %d ranks, and this allocation has %d", info->ranks,
                 sc_comm_size(state->app->comm));
    else if (info->threads > sc_usable_cores())
        snprintf(text, size, "needs %d threads a rank, and a rank may use %d cores here",
                 info->threads, sc_usable_cores());
    else
        snprintf(text, size, "this build has no such kernel, or this processor cannot run it");
}

/* Name the axes and values of the study in state->design. */
static sc_status fill_design(sc_study_state *state)
{
    const sc_ctx *ctx = state->app->ctx;
    const sc_study *study = &state->study;

    state->design.whole_jobs = study->measure == SC_STUDY_JOB;
    state->design.by_wall = study->metric == SC_STUDY_WALL;
    SC_PASS(sc_text_copy(ctx, study->title, &state->design.title));
    SC_PASS(SC_ZALLOC(ctx, (size_t)study->axis_count + 1, &state->design.axes));
    for (int i = 0; i < study->axis_count; i++) {
        const sc_study_axis *from = &study->axes[i];
        sc_design_axis *axis = &state->design.axes[i];

        state->design.axis_count++;
        SC_PASS(SC_ZALLOC(ctx, (size_t)from->value_count, &axis->values));
        SC_PASS(sc_text_copy(ctx, from->name, &axis->name));
        for (; axis->value_count < from->value_count; axis->value_count++)
            SC_PASS(sc_text_copy(ctx, from->values[axis->value_count].name,
                                 &axis->values[axis->value_count]));
    }
    return SC_OK;
}

/* Fill state->design and state->cells. @return the first mistake; all are logged. */
static sc_status fill_cells(sc_study_state *state)
{
    const sc_ctx *ctx = state->app->ctx;
    const char *best = sc_kernel_find(SC_SURFACE_SMOOTH, SC_SKIP_LEAP, NULL, NULL)->cpu,
               *cpu = best;
    uint64_t hash = (uint64_t)state->study.measure;
    sc_status mistakes = SC_OK;

    SC_PASS(fill_design(state));
    state->cell_count = sc_study_cells(&state->study);
    SC_PASS(SC_ZALLOC(ctx, (size_t)state->cell_count, &state->cells));
    SC_PASS(SC_ZALLOC(ctx, (size_t)state->cell_count, &state->told));
    for (int i = 0; i < state->cell_count; i++) {
        if (!sc_goes_on(&mistakes, fill_cell(state, i, &hash, &cpu)))
            break;
    }
    state->design.hash = hash;
    if (strcmp(cpu, best) == 0)
        return mistakes;
    state->cpu = cpu;
    sc_info(ctx,
            "all cells are drawn by kernels for %s, the best that each of their skip methods has; "
            "render.cpu names others",
            cpu);
    return mistakes;
}

/* @return whether one of the settings is about the volume. */
static bool sets_volume(const sc_study_settings *settings)
{
    for (size_t i = 0; i < settings->count; i++) {
        if (!strncmp(settings->items[i].path, "volume", strlen("volume")))
            return true;
    }
    return false;
}

/* After mistakes in the study's file: is enough of it left for looking at the jobs of its cells? */
static bool has_jobs(const sc_study *study)
{
    bool found = study->job[0] || sets_volume(&study->set);

    for (int i = 0; i < study->axis_count; i++) {
        for (int v = 0; v < study->axes[i].value_count; v++)
            found = found || sets_volume(&study->axes[i].values[v].settings);
    }
    return found;
}

/* @return SC_ERR_MISSING, logged, if the study names a job file that does not exist. */
static sc_status check_job_file(const sc_study_state *state)
{
    const sc_study *study = &state->study;

    if (!study->job[0] || access(study->job, F_OK) == 0)
        return SC_OK;
    return sc_fail(state->app->ctx, sc_input_status(errno), "%s%sjob: %s: %s", study->job_where,
                   study->job_where[0] ? ": " : "", study->job, strerror(errno));
}

/* List the cells, and tell each mistake of their jobs once, although many cells may have it.
 * @return the first mistake, also of the command line and of the study's file. */
static sc_status list_cells(sc_study_state *state)
{
    sc_app *app = state->app, own = *app;
    sc_once once;
    sc_ctx ctx = sc_ctx_once(app->ctx, &once);
    sc_status status = app->mistake, found;

    if (!sc_goes_on(&status, state->mistake) ||
        (state->mistake != SC_OK && !has_jobs(&state->study)))
        return status;
    found = check_job_file(state);
    own.ctx = &ctx;
    state->app = &own;
    if (sc_goes_on(&status, found) && found == SC_OK)
        (void)sc_goes_on(&status, fill_cells(state));
    state->app = app;
    sc_once_end(&once, "the study's jobs");
    return status;
}

sc_status sc_study_note_inputs(sc_study_state *state)
{
    SC_OWN(sc_made_from_clear) sc_made_from from = {.app = state->app};
    sc_ctx quiet = sc_quiet(state->app->ctx); /* what is to be said of the jobs was said */
    sc_study_state silent = *state;
    sc_app app = *state->app;
    sc_text text = {0};

    app.ctx = &quiet;
    silent.app = &app;
    for (int i = 0; i < state->cell_count; i++) {
        SC_OWN(sc_job_clear) sc_job job = {0};

        if (!has_new_volume(state, i))
            continue;
        SC_PASS(load_job(&silent, i, &job));
        SC_PASS(sc_made_from_add(&from, &job));
    }
    SC_PASS(sc_made_from_text(&from, &text));
    state->made_from = text.data;
    return SC_OK;
}

sc_status sc_study_list_cells(sc_study_state *state)
{
    sc_app *app = state->app;
    const bool first = sc_comm_rank(app->comm) == 0;
    int32_t count;
    uint8_t whole_jobs = state->study.measure == SC_STUDY_JOB;

    sc_comm_broadcast(app->comm, &whole_jobs, sizeof whole_jobs);
    state->whole_jobs = whole_jobs != 0;
    SC_PASS(sc_comm_agree(app->comm, first ? list_cells(state) : SC_OK));
    count = state->cell_count;
    sc_comm_broadcast(app->comm, &count, sizeof count);
    SC_PASS(SC_BROADCAST(app, (size_t)count, &state->cells));
    state->cell_count = count;
    return SC_OK;
}
