/* SPDX-License-Identifier: BSD-3-Clause */
/* The volume of a job: read by rank 0, and brought to the grid on which it was drawn. */
#include "needs.h"

#include "segcast/phantom.h"
#include "segcast/resample.h"

#include <string.h>

sc_status sc_phantom_size(const sc_ctx *ctx, const char *key, const char *volume, int size[3])
{
    int used = 0;

    size[0] = SC_PHANTOM_WIDTH;
    size[1] = SC_PHANTOM_DEPTH;
    size[2] = SC_PHANTOM_HEIGHT;
    if (strcmp(volume, "phantom") &&
        (sscanf(volume, "phantom:%dx%dx%d%n", &size[0], &size[1], &size[2], &used) != 3 ||
         volume[used]))
        return sc_fail(ctx, SC_ERR_USAGE,
                       "%s is \"%s\", expected phantom or for example phantom:128x96x128", key,
                       volume);
    return SC_OK;
}

/* Voxelise the phantom at the size in @p text. Caller owns *out: sc_volume_clear. */
static sc_status make_phantom(const sc_app *app, const char *text, sc_volume *out)
{
    sc_phantom *phantom = NULL;
    int size[3];
    sc_status status;

    SC_TRY(sc_phantom_size(app->ctx, "volume", text, size));
    SC_TRY(sc_volume_memory_check(app->ctx, text, size, 0));
    SC_TRY(sc_phantom_new(app->ctx, &phantom));
    status = sc_phantom_volume(app->ctx, phantom, size, app->threads, out);
out:
    sc_phantom_free(phantom);
    return status;
}

sc_status sc_color_tissues(const sc_app *app, const sc_job *job, sc_volume *volume)
{
    const sc_appearance appearance = (sc_appearance)job->appearance;
    int cover;
    sc_status status;

    if (!sc_volume_lacks_colors(volume, appearance))
        return SC_OK;
    SC_TRY(sc_find_outer_cover(app->ctx, volume, &cover));
    SC_TRY(sc_volume_color(app->ctx, volume, cover, appearance, app->threads));
out:
    return status;
}

sc_status sc_copy_prepared(const sc_ctx *ctx, const sc_prepared *from, sc_volume *out)
{
    sc_volume v = sc_volume_of_prepared(from);
    void *labels;
    sc_status status;

    v.ids = NULL;
    v.labels = NULL;
    SC_TRY(sc_alloc(ctx, sc_volume_voxels(&v), (size_t)v.label_bytes, &v.ids));
    memcpy(v.ids, from->ids, sc_volume_voxels(&v) * (size_t)v.label_bytes);
    SC_TRY(sc_alloc(ctx, (size_t)v.label_count, sizeof *v.labels, &labels));
    v.labels = labels;
    memcpy(v.labels, from->labels, (size_t)v.label_count * sizeof *v.labels);
    *out = v;
    return SC_OK;
out:
    sc_volume_clear(&v);
    return status;
}

/* As sc_check_tissues, of one job, or of one shot, whose rules from the film have been checked. */
static sc_status check_tissues_of(const sc_ctx *ctx, const sc_job *job, const sc_prepared *view)
{
    const sc_status rules = sc_tissue_rules_check(ctx, view, job->rules + job->film_rules,
                                                  job->rule_count - job->film_rules);
    sc_status exceptions = SC_OK, verbs = SC_OK, overlays = SC_OK;

    if (rules == SC_OK || rules == SC_ERR_DATA)
        exceptions = sc_clip_exceptions_check(ctx, view, job->exceptions, job->exception_count);
    if (exceptions == SC_OK || exceptions == SC_ERR_DATA)
        verbs = sc_verb_tissues_check(ctx, view, job->verb_tissues, job->verb_tissue_count);
    if (verbs == SC_OK || verbs == SC_ERR_DATA)
        overlays =
            sc_overlay_tissues_check(ctx, view, job->overlay_tissues, job->overlay_tissue_count);
    verbs = overlays < verbs ? overlays : verbs;
    exceptions = verbs < exceptions ? verbs : exceptions;
    return exceptions < rules ? exceptions : rules;
}

sc_status sc_check_tissues(const sc_ctx *ctx, const sc_job *job, const sc_label *labels,
                           int label_count)
{
    const sc_prepared view = {.label_count = label_count, .labels = labels};
    sc_once once; /* mistakes of keys of the film are in all shots */
    const sc_ctx telling = sc_ctx_once(ctx, &once);
    sc_status status = check_tissues_of(&telling, job, &view);

    for (size_t i = 0; i < job->shot_count; i++) {
        if (!sc_goes_on(&status, check_tissues_of(&telling, &job->shots[i].job, &view)))
            break;
    }
    return status;
}

/* Bring the volume to the number of voxels that the job asks for. */
static sc_status resize_volume(const sc_app *app, const sc_job *job, sc_volume *volume)
{
    const double old_bytes = (double)sc_volume_voxels(volume) * volume->label_bytes;
    sc_status status;

    SC_TRY(sc_volume_memory_check(app->ctx, job->volume, job->volume_size, old_bytes));
    SC_TRY(sc_resample_nearest(app->ctx, volume, job->volume_size, app->threads));
out:
    return status;
}

/* As sc_check_tissues, in a run, too, of which otherwise only the first error is shown. */
static sc_status check_all_tissues(const sc_app *app, const sc_job *job, const sc_volume *volume)
{
    const bool one_error = app->terminal->one_error;
    sc_status status;

    app->terminal->one_error = false;
    status = sc_check_tissues(app->ctx, job, volume->labels, volume->label_count);
    app->terminal->one_error = one_error;
    return status;
}

/* Get the volume of the job, with the names of its label table: from the mapped file, made as
 * phantom, or read. Refuses a job that names tissues which the volume has not. @param colored give
 * colours to tissues that lack them. */
static sc_status read_volume(const sc_app *app, const sc_session *session, bool colored,
                             sc_volume *volume)
{
    const sc_job *job = &session->job;
    sc_input_place place;
    const sc_ctx ctx = sc_ctx_of_input(app->ctx, job->volume_where, job->volume, &place);
    sc_read_choice choice;
    sc_keeping keeping;
    sc_status status;

    if (session->given) { /* it was read, edited and named as its neighbours */
        *volume = *session->given;
        *session->given = (sc_volume){0};
        return SC_OK;
    }
    SC_TRY(sc_read_choice_of(app, job, &keeping, &choice));
    if (session->mapped) /* it is to be prepared with other settings */
        SC_TRY(sc_copy_prepared(app->ctx, &session->volume, volume));
    else if (sc_job_is_phantom(job->volume))
        SC_TRY(make_phantom(app, job->volume, volume));
    else
        SC_TRY(sc_volume_read_by(&ctx, job->volume, &choice, volume));
    if (job->has_volume_size)
        SC_TRY(resize_volume(app, job, volume));
    SC_TRY(sc_apply_labels(app, job, volume, NULL));
    SC_TRY(sc_edit_volume(app, job, colored, volume));
    if (colored && !session->mapped) /* in a prepared file, colours have been found */
        SC_TRY(sc_color_tissues(app, job, volume));
    if (volume->label_count == 1)
        sc_warn(app->ctx, "%s: holds background only; there is nothing to see", job->volume);
    if (!job->has_compare) /* otherwise another subject may have what this one lacks */
        status = check_all_tissues(app, job, volume);
out:
    return status;
}

/* Tell how the grid on which surfaces are found differs from that of the file. */
static void tell_grid(const sc_app *app, const char *path, const sc_volume *v,
                      const sc_drawn_grid *grid)
{
    char text[320];

    sc_drawn_grid_text(grid, text, sizeof text);
    sc_info(app->ctx, "%s: %s; surfaces are found on %d x %d x %d voxels", path, text, v->size[0],
            v->size[1], v->size[2]);
}

sc_status sc_session_resample(const sc_app *app, const sc_session *session,
                              const sc_drawn_grid *measured, sc_volume_input *input)
{
    const sc_ctx silent = {.rank = 0, .memory_max_bytes = app->ctx->memory_max_bytes};
    const char *path = session->job.volume;
    sc_volume *volume = &input->volume;
    sc_drawn_grid grid;
    double bytes;
    int size[3];
    sc_status status;

    sc_stage_begin(app->ctx, "measuring the grid", 0, 0);
    if (session->drawn_known)
        grid = session->drawn;
    else if (measured)
        grid = *measured;
    else
        SC_TRY(sc_find_drawn_grid(app->ctx, volume, app->threads, &grid));
    input->drawn = grid;
    input->drawn_known = true;
    SC_TRY(sc_resample_bytes(app->ctx, volume, &grid, app->threads, &bytes));
    sc_resampled_size(volume, &grid, size);
    input->resample = false;
    input->settings.as_drawn = !sc_is_resampled(&grid);
    if (sc_volume_memory_check(&silent, path, size, bytes) != SC_OK) {
        sc_warn(app->ctx,
                "%s: --max-memory leaves no room for layers between its slices, nor to move "
                "those back that jump, so slices will show as steps",
                path);
        for (int i = 0; i < 3; i++) { /* copied voxels alone are removed */
            grid.split[i] = 1;
            grid.moved[i] = 0;
        }
    }
    input->settings.resampled = sc_is_resampled(&grid);
    if (!input->settings.resampled)
        return SC_OK;
    sc_stage_begin(app->ctx, "resampling", 0, 0);
    SC_TRY(sc_resample(app->ctx, volume, &grid, app->threads));
    tell_grid(app, path, volume, &grid);
out:
    return status;
}

sc_status sc_session_read(const sc_app *app, const sc_session *session, sc_volume_input *out,
                          sc_rank_record *times)
{
    const double wall_s = sc_wall_s(), cpu_s = sc_cpu_s();
    const bool resampled = (session->mapped || session->as_given) && session->volume.resampled;
    sc_volume *volume = &out->volume;
    sc_needs n = {0};
    sc_status status;

    SC_TRY(read_volume(app, session, !session->is_later_phase, volume));
    SC_TRY(sc_needs_find(app, session, volume->labels, volume->label_count, &n));
    out->hidden = n.hidden;
    out->tissue_smooth = n.tissue_smooth;
    out->resample = n.resample && !resampled && !session->as_given;
    sc_volume_hide(volume, n.hidden, app->threads);
    out->settings = (sc_prepare_settings){.smooth = n.smooth,
                                          .tissue_smooth = n.tissue_smooth,
                                          .resampled = resampled,
                                          .as_drawn = session->as_given && session->volume.as_drawn,
                                          .local_thickness = n.local_thickness,
                                          .hidden = n.hidden,
                                          .threads = app->threads};
    sc_add_time(app, times, SC_PHASE_READ, wall_s, cpu_s);
out:
    return status;
}

sc_status sc_session_voxels(const sc_app *app, const sc_session *session, sc_volume *out)
{
    return read_volume(app, session, false, out);
}

void sc_volume_input_clear(sc_volume_input *input)
{
    sc_volume_clear(&input->volume);
    sc_free(input->hidden);
    sc_free(input->tissue_smooth);
    *input = (sc_volume_input){0};
}

sc_status sc_session_prepare(const sc_app *app, const sc_session *session, sc_volume_input *input,
                             sc_preparation **preparation)
{
    sc_status status;

    SC_TRY(sc_session_read(app, session, input, NULL));
    if (input->resample)
        SC_TRY(sc_session_resample(app, session, NULL, input));
    status = sc_prepare(app->ctx, &input->volume, &input->settings, preparation);
out:
    return status;
}
