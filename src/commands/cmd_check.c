/* SPDX-License-Identifier: BSD-3-Clause */
/* segcast check: whether a job can run, found without preparing its volume, so that it may be
 * called on a login node. */
#include "commands.h"
#include "label_report.h"
#include "render/run.h"

/* List the corners, in RAS mm, of the boxes that hold the voxels of the visible tissues of a phase,
 * or of that of its volume if no voxels were read. @param points room for 8 for each label. @return
 * how many there are. */
static size_t list_corners(const sc_tissue *tissues, const sc_prepared *v, sc_vec3 *points)
{
    const bool scanned = v->stats[0].voxels > 0 || v->stats[v->label_count - 1].voxels > 0;
    size_t found = 0;

    for (int id = scanned ? 1 : 0; id < (scanned ? v->label_count : 1); id++) {
        const sc_label_stats *s = &v->stats[id];

        if (scanned && (!s->voxels || !tissues[id].visible ||
                        tissues[id].opacity + tissues[id].interior_opacity <= 0))
            continue;
        for (int corner = 0; corner < 8; corner++) {
            double at[3];

            for (int i = 0; i < 3; i++) {
                const int low = scanned ? s->low[i] : 0,
                          high = scanned ? s->high[i] : v->size[i] - 1;

                at[i] = corner >> i & 1 ? high + 0.5 : low - 0.5;
            }
            points[found++] = sc_affine_point(&v->to_ras_mm, (sc_vec3){at[0], at[1], at[2]});
        }
    }
    return found;
}

/* A sc_points_fn: the same for all phases of a panel. */
static sc_status find_corners(const sc_app *app, const sc_panel *panel, sc_vec3 **out,
                              size_t *count)
{
    const sc_tissue *tissues = panel->looks.tissues;
    size_t labels = (size_t)panel->volume.label_count, found = 0;

    for (int i = 1; i < panel->phases; i++)
        labels += (size_t)panel->inputs->all[i].volume.label_count;
    SC_PASS(SC_ALLOC(app->ctx, labels * 8, out));
    found = list_corners(tissues, &panel->volume, *out);
    for (int i = 1; i < panel->phases; i++)
        found += list_corners(tissues, &panel->inputs->all[i].volume, *out + found);
    *count = found;
    return SC_OK;
}

/* Refuse a job whose render.cpu names a variant that this build or this processor lacks. */
static sc_status check_cpu(const sc_app *app, const sc_job *job)
{
    const char *cpu = sc_cpu_names[job->render.cpu];

    return cpu ? sc_cpu_check(app->ctx, cpu) : SC_OK;
}

/* Print the size of each volume that is compared. */
static void print_subjects(const sc_session *session)
{
    for (int s = 0; session->compare && s < session->inputs->count; s++) {
        const int *size = session->inputs->all[s].volume.size;

        printf("  ");
        sc_print(stdout, sc_subject_name(session, s));
        printf(": %d x %d x %d voxels\n", size[0], size[1], size[2]);
    }
}

/* Print how many phases there are, and how many beats the film shows. */
static void print_phases(const sc_session *session)
{
    const sc_job *job = &session->job;
    const sc_cine *cine = &job->cine.cine;
    const double beats = job->animation.frames * cine->bpm / (60.0 * job->output.fps);
    const bool ends = cine->beats && beats > cine->beats;
    char between[48] = "";

    if (!job->volume.phase_count)
        return;
    if (cine->between)
        snprintf(between, sizeof between, ", and %d between each two", cine->between);
    printf("phases: %d volumes of this size%s, %g beats a minute: the film shows %.4g beat%s%s\n",
           session->inputs->count, between, cine->bpm, ends ? cine->beats : beats,
           (ends ? cine->beats : beats) == 1 ? "" : "s", ends ? ", and then the last phase" : "");
}

/* Print all key frames with the frames that their times mean, up to KEY_FRAMES_SHOWN. */
static sc_status print_key_frames(const sc_app *app, const sc_job *job)
{
    enum { KEY_FRAMES_SHOWN = 100 };
    SC_OWN(sc_text_clear) sc_text text = {0};
    sc_status status = sc_job_list_key_frames(app->ctx, job, KEY_FRAMES_SHOWN, &text);

    if (status == SC_OK && text.length_bytes)
        printf("key frames: parameter, frame (the first is 0), value, ease\n");
    for (char *line = text.data; status == SC_OK && line && *line;) {
        char *end = line + strcspn(line, "\n");

        *end = '\0';
        sc_print(stdout, line);
        putchar('\n');
        line = end + 1;
    }
    return status;
}

/* After mistakes, because of which nothing was lettered: read the logo, so that its mistake is
 * told, too. */
static sc_status check_logo(const sc_app *app, const sc_job *job)
{
    SC_OWN(sc_image_clear) sc_image logo = {0};
    sc_status status = SC_OK;

    if (job->overlays.logo[0] && !job->film.shot_count)
        status = sc_image_load_png(app->ctx, job->overlays.logo, &logo);
    return status;
}

/* Read what stands in place of the sky. */
static sc_status check_light(const sc_app *app, const sc_job *job)
{
    SC_OWN(sc_panorama_clear) sc_panorama map = {0};

    return sc_environment_load(app->ctx, job, &map);
}

/* Check all of a job that depends on its volumes, of which the panels are made. */
static sc_status check_panels(sc_app *app, sc_session *session)
{
    const sc_prepared *v = sc_session_view(session);

    if (session->job.film.shot_count) /* those of all shots, not only of the first that has any */
        SC_PASS(sc_check_tissues(app->ctx, &session->job, v->labels, v->label_count));
    SC_PASS(sc_session_tissues(app, session));
    return sc_session_timelines(app, session, find_corners);
}

/* Check a job against its volumes and images. @return as check_all. */
static sc_status check_volumes(sc_app *app, sc_session *session)
{
    sc_status status;

    SC_PASS(sc_inputs_inspect(app, &session->job, app->options.check.fast, &session->inputs));
    SC_PASS(sc_session_panels(app, session));
    status = check_panels(app, session);
    (void)sc_goes_on(&status, sc_session_check_grey(app, session));
    return status;
}

/* Check a job, which has been read, against this build, this machine and its volume. @return the
 * first mistake; all are logged, each once. */
static sc_status check_all(const sc_app *app, sc_session *session)
{
    const sc_job *job = &session->job;
    const bool is_elsewhere = app->options.output != NULL;
    sc_once once;
    sc_ctx ctx = sc_ctx_once(app->ctx, &once);
    sc_app own = *app;
    sc_status first = check_cpu(app, job);

    own.ctx = &ctx;
    (void)sc_goes_on(&first, sc_run_check_encoder(&ctx, job));
    (void)sc_goes_on(&first, sc_run_check_encode_key(&ctx, job));
    (void)sc_goes_on(
        &first, sc_check_directory(&ctx, is_elsewhere ? "--output" : job->lines.directory,
                                   is_elsewhere ? app->options.output : job->output.directory));
    if (first == SC_OK)
        sc_warn_of_outputs(&own, job);
    for (size_t i = 0; i < job->film.shot_count; i++)
        (void)sc_goes_on(&first, check_light(&own, &job->film.shots[i].job));
    if (!job->film.shot_count)
        (void)sc_goes_on(&first, check_light(&own, job));
    (void)sc_goes_on(&first, check_volumes(&own, session));
    if (first != SC_OK)
        (void)sc_goes_on(&first, check_logo(&own, job));
    return first;
}

/* Print the job with verbs as key frames. */
static sc_status print_expanded(const sc_app *app, sc_session *session)
{
    SC_OWN(sc_text_clear) sc_text text = {0};

    SC_PASS(sc_session_expand(app->ctx, session));
    SC_PASS(sc_job_write(app->ctx, &session->job, false, &text));
    fputs(text.data, stdout);
    return SC_OK;
}

sc_status sc_cmd_check(sc_app *app)
{
    SC_OWN(sc_session_clear) sc_session session = {0};
    const sc_job *job = &session.job;
    const sc_prepared *volume;
    SC_OWN(sc_label_source_clear) sc_label_source source = {0};
    SC_OWN(sc_label_report_clear) sc_label_report report = {0};
    sc_status status;

    app->options.scan = !app->options.check.fast;
    SC_TRY(sc_session_job(app, app->options.input, &session));
    app->label_source = &source;
    SC_TRY(check_all(app, &session));
    volume = sc_session_view(&session);
    SC_TRY(sc_label_report_make(app->ctx, &source, volume,
                                !app->options.check.fast && !job->volume.tissue_count, &report));
    sc_display_end_stage(app);
    if (app->options.check.expand) {
        status = print_expanded(app, &session);
        goto out;
    }
    sc_print(stdout, app->options.input);
    printf(": ok: %d frames of %d x %d, volume of %d x %d x %d voxels with %d label%s%s\n",
           job->animation.frames, job->output.size_px[0], job->output.size_px[1], volume->size[0],
           volume->size[1], volume->size[2], volume->label_count - 1,
           volume->label_count == 2 ? "" : "s",
           app->options.check.fast ? " in its tables (the voxels were not read)" : "");
    print_subjects(&session);
    print_phases(&session);
    SC_TRY(print_key_frames(app, job));
    sc_label_report_print(&report, stdout);
out:
    app->label_source = NULL;
    return status;
}
