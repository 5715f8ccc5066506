/* SPDX-License-Identifier: BSD-3-Clause */
/* The recipe by which a file becomes the labels that are prepared: its steps one after the other,
 * of which some may have been done before. */
#include "recipe.h"

#include "segcast/phantom.h"

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

/* Take the phantom at the size that the job names: its voxels, or a scan of them. */
static sc_status take_phantom(sc_recipe *r)
{
    const sc_ctx *ctx = r->app->ctx;
    SC_OWN(sc_phantom_free_at) sc_phantom *phantom = NULL;
    int size[3];

    SC_PASS(sc_phantom_size(ctx, "volume", r->job->volume.path, size));
    if (r->depth == SC_READ_IDS)
        SC_PASS(sc_volume_memory_check(ctx, r->job->volume.path, size, 0));
    SC_PASS(sc_phantom_new(ctx, &phantom));
    return (r->depth == SC_READ_IDS ? sc_phantom_volume : sc_phantom_scan_labels)(
        ctx, phantom, size, r->app->threads, r->volume);
}

sc_status sc_copy_prepared(const sc_ctx *ctx, const sc_prepared *from, sc_volume *out)
{
    SC_OWN(sc_volume_clear) sc_volume v = sc_volume_of_prepared(from);

    v.ids = NULL;
    v.labels = NULL;
    SC_PASS(sc_alloc(ctx, sc_volume_voxels(&v), (size_t)v.label_bytes, &v.ids));
    memcpy(v.ids, from->ids, sc_volume_voxels(&v) * (size_t)v.label_bytes);
    SC_PASS(SC_ALLOC(ctx, (size_t)v.label_count, &v.labels));
    memcpy(v.labels, from->labels, (size_t)v.label_count * sizeof *v.labels);
    SC_HAND_OVER(v, out);
    return SC_OK;
}

/* The labels among which tissues are looked for. */
typedef struct tissue_check {
    sc_ctx ctx;
    sc_prepared view;
} tissue_check;

/* An sc_pattern_fn; @p user is a tissue_check. */
static sc_status check_pattern(void *user, const char *pattern, const char *where)
{
    const tissue_check *c = user;

    return sc_pattern_check(&c->ctx, &c->view, pattern, where);
}

sc_status sc_check_tissues(const sc_ctx *ctx, const sc_job *job, const sc_label *labels,
                           int label_count)
{
    sc_once once; /* mistakes of keys of the film are in all shots */
    tissue_check c = {sc_ctx_once(ctx, &once), {.label_count = label_count, .labels = labels}};
    const sc_status status = sc_each_pattern(job, check_pattern, &c);

    sc_once_end(&once, "the job");
    return status;
}

/* ---- the steps ---- */

#define DONE(step) (1u << (step))

/* SC_STEP_TAKE. What is known of the volume already is noted as done. */
static sc_status take(sc_recipe *r)
{
    const sc_job *job = r->job;
    sc_input_place place;
    const sc_ctx ctx = sc_ctx_of_input(r->app->ctx, job->lines.volume, job->volume.path, &place);
    sc_read_choice choice;

    if (r->input->given) { /* it was read, edited and named as its neighbours */
        *r->volume = *r->input->given;
        *r->input->given = (sc_volume){0};
        r->done |= DONE(SC_STEP_HIDE) - 1;
        return SC_OK;
    }
    SC_PASS(sc_read_choice_of(r, &choice));
    if (r->input->mapped) { /* it is to be prepared with other settings; colours have been found */
        r->done |= DONE(SC_STEP_COLOR);
        return sc_copy_prepared(r->app->ctx, &r->input->volume, r->volume);
    }
    if (sc_job_is_phantom(job->volume.path))
        return take_phantom(r);
    return sc_volume_read_by(&ctx, job->volume.path, &choice, r->volume);
}

/* SC_STEP_RESIZE */
static sc_status resize(sc_recipe *r)
{
    const sc_job *job = r->job;
    const double old_bytes = (double)sc_volume_voxels(r->volume) * r->volume->label_bytes;

    if (!job->given.volume_size)
        return SC_OK;
    SC_PASS(sc_volume_memory_check(r->app->ctx, job->volume.path, job->volume.size, old_bytes));
    return sc_resample_nearest(r->app->ctx, r->volume, job->volume.size, r->app->threads);
}

/* SC_STEP_COLOR: give colours to tissues that no table gives one, or not one that the job wants. */
static sc_status color(sc_recipe *r)
{
    const sc_appearance appearance = (sc_appearance)r->job->volume.appearance;
    int cover;

    if (!sc_volume_lacks_colors(r->volume, appearance))
        return SC_OK;
    SC_PASS(sc_find_outer_cover(r->app->ctx, r->volume, &cover));
    return sc_volume_color(r->app->ctx, r->volume, cover, appearance, r->app->threads);
}

/* @return SC_ERR_DATA, logged, for a volume that looks like a CT or MR image, unless a name or a
 * key says that its values are tissues. */
static sc_status check_labels(const sc_recipe *r, const sc_volume *v)
{
    bool named = r->job->volume.labels[0] || r->job->tissues.rule_count || r->input->measure;

    for (int id = 1; id < v->label_count && !named; id++)
        named = v->labels[id].name[0];
    if (!v->looks_grey || named)
        return SC_OK;
    return sc_fail(r->app->ctx, SC_ERR_DATA,
                   "%s: would be drawn as %d tissues, one for each value; expected a segmentation, "
                   "beside which an image is shown (image.path, --image FILE). If these values are "
                   "labels, say so by a table of them (labels, --labels FILE) or a rule for them "
                   "(--set 'tissues={\"*\": {visible: true}}')",
                   r->job->volume.path, v->label_count - 1);
}

/* SC_STEP_CHECK: all mistakes in names of tissues are told, also in a run, of which otherwise only
 * the first error is shown. Those of a scan are looked for later. */
static sc_status check(sc_recipe *r)
{
    const sc_volume *v = r->volume;
    bool one_error;
    sc_status status;

    if (v->label_count == 1 && (v->ids || v->tallies))
        sc_warn(r->app->ctx, "%s: holds background only; there is nothing to see",
                r->job->volume.path);
    SC_PASS(check_labels(r, v));
    if (r->depth != SC_READ_IDS ||
        r->job->given.compare) /* another subject may have what this one lacks */
        return SC_OK;
    one_error = r->app->terminal->one_error;
    r->app->terminal->one_error = false;
    status = sc_check_tissues(r->app->ctx, r->job, v->labels, v->label_count);
    r->app->terminal->one_error = one_error;
    return status;
}

/* SC_STEP_HIDE */
static sc_status hide(sc_recipe *r)
{
    const sc_input *input = r->input;
    const bool resampled = (input->mapped || input->is_between) && input->volume.how.resampled;
    sc_edited *out = r->edited;
    sc_needs n = {0};

    SC_PASS(sc_needs_find(r->app, r->job, input->measure, r->volume->labels, r->volume->label_count,
                          &n));
    out->hidden = n.hidden;
    out->tissue_smooth = n.tissue_smooth;
    out->resample = n.resample && !resampled && !input->is_between;
    sc_volume_hide(r->volume, n.hidden, r->app->threads);
    out->settings =
        (sc_prepare_settings){.smooth = n.smooth,
                              .tissue_smooth = n.tissue_smooth,
                              .resampled = resampled,
                              .as_drawn = input->is_between && input->volume.how.as_drawn,
                              .local_thickness = n.local_thickness,
                              .hidden = n.hidden,
                              .threads = r->app->threads};
    return SC_OK;
}

/* Do all steps that are not done. @return the first error, logged. */
static sc_status follow(sc_recipe *r)
{
    static sc_status (*const steps[SC_STEP_COUNT])(sc_recipe *) = {[SC_STEP_TAKE] = take,
                                                                   [SC_STEP_RESIZE] = resize,
                                                                   [SC_STEP_NAME] = sc_name_labels,
                                                                   [SC_STEP_EDIT] = sc_edit_volume,
                                                                   [SC_STEP_COLOR] = color,
                                                                   [SC_STEP_CHECK] = check,
                                                                   [SC_STEP_HIDE] = hide};

    for (int i = 0; i < SC_STEP_COUNT; i++) {
        if (!(r->done & DONE(i)))
            SC_PASS(steps[i](r));
    }
    return SC_OK;
}

sc_status sc_input_read(const sc_app *app, const sc_job *job, const sc_input *input,
                        sc_rank_record *times, sc_edited *out)
{
    const double wall_s = sc_wall_s(), cpu_s = sc_cpu_s();
    sc_recipe r = {.app = app,
                   .job = job,
                   .input = input,
                   .volume = &out->volume,
                   .tell = !input->is_later_phase,
                   .edited = out,
                   .done = input->is_later_phase ? DONE(SC_STEP_COLOR) : 0};

    SC_PASS(follow(&r));
    sc_add_time(app, times, SC_PHASE_READ, wall_s, cpu_s);
    return SC_OK;
}

sc_status sc_input_voxels(const sc_app *app, const sc_job *job, const sc_input *input,
                          sc_volume *out)
{
    sc_recipe r = {.app = app,
                   .job = job,
                   .input = input,
                   .volume = out,
                   .done = DONE(SC_STEP_COLOR) | DONE(SC_STEP_HIDE)};

    return follow(&r);
}

sc_status sc_name_mapped(const sc_app *app, const sc_job *job, const sc_input *input,
                         sc_volume *labels)
{
    /* Colours were found when the file was prepared; others are found only if the job wants. */
    const bool colors = job->volume.appearance != SC_APPEARANCE_TABLE;
    sc_recipe r = {.app = app,
                   .job = job,
                   .input = input,
                   .volume = labels,
                   .is_fixed = true,
                   .done = ~DONE(SC_STEP_NAME) & ~(colors ? DONE(SC_STEP_COLOR) : 0)};

    return follow(&r);
}

sc_status sc_scan_labels(const sc_app *app, const sc_job *job, const sc_input *input,
                         bool header_only, sc_volume *out)
{
    sc_recipe r = {.app = app,
                   .job = job,
                   .input = input,
                   .volume = out,
                   .depth = header_only ? SC_READ_HEADER : SC_READ_TALLIES,
                   .tell = true,
                   .done = DONE(SC_STEP_RESIZE) | DONE(SC_STEP_COLOR) | DONE(SC_STEP_HIDE)};

    return follow(&r);
}

/* ---- the grid on which it was drawn ---- */

/* Tell how the grid on which surfaces are found differs from that of the file. */
static void tell_grid(const sc_app *app, const char *path, const sc_volume *v,
                      const sc_drawn_grid *grid)
{
    char text[320];

    sc_drawn_grid_text(grid, text, sizeof text);
    sc_info(app->ctx, "%s: %s; surfaces are found on %d x %d x %d voxels", path, text, v->size[0],
            v->size[1], v->size[2]);
}

sc_status sc_input_resample(const sc_app *app, const sc_job *job, const sc_input *input,
                            const sc_drawn_grid *measured, sc_edited *edited)
{
    const sc_ctx silent = {.rank = 0, .memory_max_bytes = app->ctx->memory_max_bytes};
    const char *path = job->volume.path;
    sc_volume *volume = &edited->volume;
    sc_drawn_grid grid;
    double bytes;
    int size[3];

    sc_stage_begin(app->ctx, "measuring the grid", 0, 0);
    if (input->drawn_known)
        grid = input->drawn;
    else if (measured)
        grid = *measured;
    else
        SC_PASS(sc_find_drawn_grid(app->ctx, volume, app->threads, &grid));
    edited->drawn = grid;
    edited->drawn_known = true;
    SC_PASS(sc_resample_bytes(app->ctx, volume, &grid, app->threads, &bytes));
    sc_resampled_size(volume, &grid, size);
    edited->resample = false;
    edited->settings.as_drawn = !sc_is_resampled(&grid);
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
    edited->settings.resampled = sc_is_resampled(&grid);
    if (!edited->settings.resampled)
        return SC_OK;
    sc_stage_begin(app->ctx, "resampling", 0, 0);
    SC_PASS(sc_resample(app->ctx, volume, &grid, app->threads));
    tell_grid(app, path, volume, &grid);
    return SC_OK;
}

void sc_edited_clear(sc_edited *edited)
{
    sc_volume_clear(&edited->volume);
    sc_free(edited->hidden);
    sc_free(edited->tissue_smooth);
    *edited = (sc_edited){0};
}

sc_status sc_input_prepare(const sc_app *app, const sc_job *job, const sc_input *input,
                           sc_edited *edited, sc_preparation **preparation)
{
    SC_PASS(sc_input_read(app, job, input, NULL, edited));
    if (edited->resample)
        SC_PASS(sc_input_resample(app, job, input, NULL, edited));
    return sc_prepare(app->ctx, &edited->volume, &edited->settings, preparation);
}
