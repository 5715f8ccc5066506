/* SPDX-License-Identifier: BSD-3-Clause */
/* Write the prepared volume to a file; jobs that map it start without preparing. */
#include "commands.h"
#include "segcast/resample.h"

#define ENDING ".segc"

/* Find the opacity of each label, for the light that is derived for the job. Caller owns *out:
 * sc_free. */
static sc_status find_opacity(const sc_app *app, const sc_job *job, const sc_prepared *view,
                              float **out)
{
    const size_t labels = (size_t)view->label_count;
    SC_OWN(sc_free_at) sc_tissue *tissues = NULL;
    SC_OWN(sc_free_at) float *opacity = NULL;

    SC_PASS(SC_ZALLOC(app->ctx, labels, &tissues));
    SC_PASS(SC_ZALLOC(app->ctx, labels, &opacity));
    sc_transfer_resolve(view, job->tissues.rules, job->tissues.rule_count, sc_job_opacity_rule(job),
                        tissues);
    for (int id = 1; id < view->label_count; id++)
        opacity[id] = tissues[id].visible ? (float)tissues[id].opacity : 0;
    SC_HAND_OVER(opacity, out);
    return SC_OK;
}

/* Prepare the volume of a job, and write it to @p path. For
 * surfaces that are smooth, what pictures are drawn from is derived, too. @param opacity as of
 * find_opacity: filled by the first phase, by which the tissues of all look. */
static sc_status prepare_file(sc_app *app, const sc_job *job, sc_input *input, const char *path,
                              float **opacity)
{
    const double wall_s = sc_wall_s(), cpu_s = sc_cpu_s();
    SC_OWN(sc_edited_clear) sc_edited edited = {0};
    sc_preparation *preparation = NULL;
    sc_status status;

    SC_TRY(sc_input_prepare(app, job, input, &edited, &preparation));
    input->drawn = edited.drawn;
    input->drawn_known = edited.drawn_known;
    input->volume = sc_preparation_view(preparation);
    if (job->render.surface == SC_SURFACE_SMOOTH) {
        if (!*opacity)
            SC_TRY(find_opacity(app, job, &input->volume, opacity));
        SC_TRY(sc_preparation_derive(app->ctx, preparation, *opacity));
    }
    SC_TRY(sc_preparation_save(app->ctx, preparation, path, app->options.overwrite, true));
    sc_info(app->ctx, "%s: %.1f MB, prepared in %.2f s, %.2f CPU s", path,
            (double)sc_preparation_file_bytes(preparation) * 1e-6, sc_wall_s() - wall_s,
            sc_cpu_s() - cpu_s);
    sc_display_end_stage(app);
    sc_print_made(path);
out:
    input->volume = (sc_prepared){0};
    sc_preparation_free(preparation);
    return status;
}

/* Refuse to write @p path if the volume that it would hold is prepared already. */
static sc_status check_input(const sc_app *app, const sc_job *job, const char *volume,
                             const char *path)
{
    const sc_status status = sc_check_output(app, job, path, true);

    if (status == SC_OK && sc_is_prepared_file(volume))
        return sc_fail(app->ctx, SC_ERR_USAGE, "%s: is a prepared file already", volume);
    return status;
}

/* What is prepared of a series: so many phases, each of which is followed by those between it and
 * the next, so that @p each come of one. */
typedef struct series {
    sc_app *app; /* with a store for the phases of one file */
    const sc_job *job;
    sc_input first;   /* how it was drawn */
    const char *path; /* of the files, without the number of the phase */
    int count, each;
    float *opacity; /* as of prepare_file; owned */
} series;

/* Write the path of the file of a phase, those between counted. @param text the caller clears it.
 */
static sc_status find_path(const series *s, int phase, sc_text *text)
{
    sc_text_clear(text);
    return sc_phase_path(s->app->ctx, s->path, ENDING, phase, s->count * s->each, text);
}

/* Prepare a phase of the input, and write it to its file. */
static sc_status prepare_phase(series *s, int phase)
{
    sc_input one;
    sc_job job;
    SC_OWN(sc_text_clear) sc_text name = {0};

    sc_stage_turn(s->app->ctx, phase * s->each + 1, s->count * s->each);
    SC_PASS(find_path(s, phase * s->each, &name));
    sc_job_of_input(s->job, phase, &job);
    sc_input_begin_phase(&s->first, &one);
    one.is_later_phase = false; /* each file has colours, so that it can be used alone */
    SC_PASS(prepare_file(s->app, &job, &one, name.data, &s->opacity));
    s->first = one;
    return SC_OK;
}

/* Map the file of a phase that was prepared. Caller owns *out and *bytes: sc_file_unmap. */
static sc_status map_phase(const series *s, int phase, const void **out, size_t *bytes,
                           sc_prepared *view)
{
    SC_OWN(sc_text_clear) sc_text name = {0};
    const void *mapped = NULL;
    sc_status status;

    SC_TRY(find_path(s, phase * s->each, &name));
    SC_TRY(sc_file_map(s->app->ctx, name.data, &mapped, bytes));
    SC_TRY(sc_prepared_file_view(s->app->ctx, name.data, mapped, *bytes, view));
    *out = mapped;
    mapped = NULL;
out:
    sc_file_unmap(mapped, mapped ? *bytes : 0);
    return status;
}

/* Prepare the phases between phase @p phase and the next one, whose files are there, and write them
 * to theirs. */
static sc_status prepare_gap(series *s, int phase)
{
    const sc_ctx *ctx = s->app->ctx;
    const void *mapped[2] = {NULL, NULL};
    size_t bytes[2] = {0, 0};
    sc_prepared ends[2];
    SC_OWN(sc_between_free_at) sc_between *between = NULL;
    SC_OWN(sc_volume_clear) sc_volume volume = {0};
    SC_OWN(sc_text_clear) sc_text name = {0};
    sc_volume low, high;
    sc_job job;
    sc_status status;

    sc_stage_turn(ctx, phase * s->each + 2, s->count * s->each);
    sc_stage_begin(ctx, "interpolating phases", 0, 0);
    for (int i = 0; i < 2; i++)
        SC_TRY(map_phase(s, (phase + i) % s->count, &mapped[i], &bytes[i], &ends[i]));
    if (phase + 1 < s->count) /* all before this one are as the first */
        SC_TRY(sc_check_phase(ctx, s->job, &ends[0], &ends[1], phase + 1, true));
    sc_job_of_input(s->job, phase, &job);
    low = sc_volume_of_prepared(&ends[0]);
    high = sc_volume_of_prepared(&ends[1]);
    SC_TRY(sc_between_find(ctx, &low, &high, s->app->threads, &between));
    for (int i = 1; i < s->each; i++) {
        sc_input one;

        sc_stage_turn(ctx, phase * s->each + i + 1, s->count * s->each);
        SC_TRY(find_path(s, phase * s->each + i, &name));
        SC_TRY(sc_copy_prepared(ctx, &ends[0], &volume));
        sc_between_at(between, (double)i / s->each, &volume);
        sc_input_begin_between(&ends[0], &s->first, &one);
        one.given = &volume;
        SC_TRY(prepare_file(s->app, &job, &one, name.data, &s->opacity));
    }
out:
    for (int i = 0; i < 2; i++)
        sc_file_unmap(mapped[i], bytes[i]);
    return status;
}

/* Prepare each phase of a job, and those between them if the job has any, and write it
 * to a file of its own: @p path with the number of the phase. */
static sc_status prepare_phases(sc_app *app, const sc_job *job, const char *path)
{
    sc_app own;
    series s = {.app = &own,
                .job = job,
                .path = path,
                .count = (int)job->volume.phase_count,
                .each = 1 + job->cine.cine.between};
    SC_OWN(sc_text_clear) sc_text name = {0};
    sc_status status;

    SC_TRY(sc_begin_phase_store(app, job, &own));
    for (int i = 0; i < s.count * s.each; i++) { /* all are checked before the first is made */
        SC_TRY(find_path(&s, i, &name));
        SC_TRY(check_input(app, job, job->volume.phases[i / s.each].path, name.data));
    }
    for (int i = 0; i < s.count; i++)
        SC_TRY(prepare_phase(&s, i));
    for (int i = 0; i < s.count && s.each > 1; i++)
        SC_TRY(prepare_gap(&s, i));
out:
    sc_stage_turn(app->ctx, 0, 0);
    sc_phase_store_free(own.phase_store);
    sc_free(s.opacity);
    return status;
}

sc_status sc_convert_prepared(sc_app *app, const char *job)
{
    const char *path = app->options.output;
    SC_OWN(sc_session_clear) sc_session session = {0};
    sc_input input = {0};
    SC_OWN(sc_free_at) float *opacity = NULL;

    if (!job) {
        SC_PASS(sc_options_set_text(app->ctx, &app->options, "volume", app->options.input));
        SC_PASS(sc_expect_series(app));
    }
    SC_PASS(sc_session_job(app, job, &session));
    if (session.job.volume.phase_count)
        return prepare_phases(app, &session.job, path);
    SC_PASS(check_input(app, &session.job, session.job.volume.path, path));
    return prepare_file(app, &session.job, &input, path, &opacity);
}
