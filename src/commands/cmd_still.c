/* SPDX-License-Identifier: BSD-3-Clause */
/* segcast still: one picture, drawn by one process. */
#include "commands.h"

#include <math.h>

/* Do the options ask for a sheet of several frames? */
static bool draws_sheet(const sc_options *o)
{
    return o->still.pictures || o->part.frames;
}

/* Do they name one frame? */
static bool is_of_moment(const sc_options *o)
{
    return o->still.frame >= 0 || o->still.moment != SC_MOMENT_NONE;
}

/* Refuse two options that exclude each other. */
static sc_status check_use(const sc_app *app)
{
    if (app->options.still.frame >= 0 && app->options.still.moment != SC_MOMENT_NONE)
        return sc_fail(app->ctx, SC_ERR_USAGE,
                       "--frame and --time both say which frame to draw; give one of them");
    if (draws_sheet(&app->options) && is_of_moment(&app->options))
        return sc_fail(app->ctx, SC_ERR_USAGE,
                       "--%s is for one picture, and --%s for a sheet of several; give one of them",
                       app->options.still.frame >= 0 ? "frame" : "time",
                       app->options.part.frames ? "frames" : "sheet");
    if (app->options.still.slices && app->options.part.frames)
        return sc_fail(app->ctx, SC_ERR_USAGE,
                       "--sheet slices is one picture, and --frames names several; give --sheet N "
                       "or one --frame");
    if (app->options.part.frames && app->options.still.pictures)
        return sc_fail(app->ctx, SC_ERR_USAGE,
                       "--frames and --sheet both say which frames to show; give one of them");
    return SC_OK;
}

/* Find the frame that --frame or --time asks for; 0 without either. A time is that of the nearest
 * frame: frame k of the film is shown from k / fps on. */
static sc_status find_frame(const sc_app *app, const sc_job *job, int *out)
{
    const sc_options *o = &app->options;
    const int frames = job->animation.frames;
    const double length_s = (double)frames / job->output.fps;
    double frame = o->still.frame > 0 ? (double)o->still.frame : 0;

    if (o->still.frame >= frames)
        return sc_fail(app->ctx, SC_ERR_USAGE,
                       "--frame %ld is not within the animation's frames 0-%d", o->still.frame,
                       frames - 1);
    if (o->still.moment == SC_MOMENT_SECONDS && o->still.moment_at > length_s * (1 + 1e-9))
        return sc_fail(app->ctx, SC_ERR_USAGE,
                       "--time is %.6g s, after the end of the film, which lasts %.6g s (frames "
                       "0-%d, %d per second)",
                       o->still.moment_at, length_s, frames - 1, job->output.fps);
    if (o->still.moment == SC_MOMENT_SECONDS)
        frame = floor(o->still.moment_at * job->output.fps + 0.5);
    else if (o->still.moment == SC_MOMENT_SHARE)
        frame = floor(o->still.moment_at * (frames - 1) + 0.5);
    *out = (int)fmin(frame, frames - 1);
    return SC_OK;
}

/* Is an option given that sets a key of the job, such as "--point "? */
static bool is_given(const sc_options *o, const char *option)
{
    for (size_t i = 0; i < o->settings.count; i++) {
        if (!strncmp(o->settings.all[i].origin, option, strlen(option)))
            return true;
    }
    return false;
}

/* Is one picture drawn, and not a frame of a film? Of a job, too, if --view says where the camera
 * stands. */
static bool is_alone(const sc_options *o, const char *job_path)
{
    return (!job_path || is_given(o, "--view ")) && !is_of_moment(o);
}

/* Draw the frame that was asked for of a job, write it to @p path as PNG and print the path. @param
 * job_path NULL: there is no job file, only settings. */
static sc_status draw_still(sc_app *app, const char *job_path, const char *path)
{
    SC_OWN(sc_session_clear) sc_session session = {0};
    SC_OWN(sc_image_clear) sc_image image = {0};
    sc_render_stats stats;
    int frame = 0;

    SC_PASS(sc_session_job(app, job_path, &session));
    session.job.animation.camera.alone = is_alone(&app->options, job_path);
    if (app->options.still.slices && session.job.output.layout != SC_LAYOUT_VIEWS)
        return sc_fail(app->ctx, SC_ERR_USAGE, "--sheet slices: the job says slices: none");
    SC_PASS(sc_check_output(app, &session.job, path, true));
    SC_PASS(find_frame(app, &session.job, &frame));
    SC_PASS(sc_session_volume(app, &session));
    SC_PASS(sc_session_image(app, &session, &image));
    SC_PASS(sc_session_draw(app, &session, frame, NULL, &image, &stats));
    SC_PASS(sc_image_save_png(app->ctx, &image, path, app->options.overwrite));
    sc_info(app->ctx,
            "%s: frame %d, drawn in %.3f s, %.3f CPU s; %llu rays, %llu samples; kernel %s", path,
            frame, stats.wall_s, stats.cpu_s, (unsigned long long)stats.counters.rays,
            (unsigned long long)stats.counters.cell_visits,
            sc_renderer_kernel(sc_session_renderer(&session, 0))->name);
    sc_display_end_stage(app);
    sc_print_made(path);
    return SC_OK;
}

/* Settings for a picture of a volume without a job, unless the user has given others: its size,
 * and, if no frame of a turn is asked for, a camera that does not turn. So the picture is framed
 * for itself, not for all that an orbit would show. */
static sc_status set_defaults(sc_app *app)
{
    const bool of_turn = is_of_moment(&app->options) || draws_sheet(&app->options);

    SC_PASS(sc_options_default(app->ctx, &app->options, "output.size", "[1440, 1080]"));
    SC_PASS(sc_options_default(app->ctx, &app->options, "look", "studio"));
    if (!of_turn)
        SC_PASS(sc_options_default(app->ctx, &app->options, "animation.camera.orbit.turns", "0"));
    return SC_OK;
}

/* Settings for the three slices beside the picture: through the middle, unless the user says
 * otherwise. */
static sc_status set_slices(sc_app *app)
{
    return sc_options_default(app->ctx, &app->options, "animation.slices", "50%");
}

sc_status sc_cmd_still(sc_app *app)
{
    const char *path = app->options.output ? app->options.output : "still.png";
    const char *job = app->options.input;

    if (!sc_input_may_be_job(job) || sc_job_is_phantom(job) ||
        (is_given(&app->options, "--header ") && !sc_input_is_job(job))) {
        SC_PASS(sc_options_set_text(app->ctx, &app->options, "volume", job));
        SC_PASS(sc_expect_series(app));
        SC_PASS(set_defaults(app));
        job = NULL;
    } else if (is_given(&app->options, "--tissue ")) {
        SC_PASS(sc_fail(
            app->ctx, SC_ERR_USAGE,
            "--tissue is for a volume; a job has the verb {frame: NAME, during: [0%%, 0%%]}"));
    }
    SC_PASS(sc_defer(app, sc_check_ending(app->ctx, path, ".png", "a picture in the format PNG")));
    SC_PASS(sc_defer(app, check_use(app)));
    if (app->options.still.slices)
        SC_PASS(set_slices(app));
    app->options.no_video = true;
    return draws_sheet(&app->options) ? sc_draw_sheet(app, job, path) : draw_still(app, job, path);
}
