/* SPDX-License-Identifier: BSD-3-Clause */
/* Warnings of jobs that can run, but do not make what was probably meant. */
#include "app.h"
#include "run.h"

#include <math.h>
#include <string.h>

/* Warn of what the format of the video does to it: pictures that no player has to know, times that
 * a GIF cannot count, sizes that nobody wants in slides. */
static void warn_of_video(const sc_app *app, const sc_job *job)
{
    static const double large_bytes = 20e6;
    const char *video = job->output.video;
    const sc_video_settings settings = sc_run_video_settings(job);
    const double bytes = sc_video_bytes_guess(video, &settings, job->animation.frames);
    const bool is_large = bytes > large_bytes || settings.height_px >= 1080;

    if (sc_video_beyond_levels(video, &settings))
        sc_warn(
            app->ctx,
            "output.size is %d x %d: that is more than the 35.7 million pixels for which %s has "
            "levels, so that players may refuse %s; 8k (7680x4320) is within them",
            settings.width_px, settings.height_px, sc_video_codec_name(video, settings.codec),
            video);
    if (sc_video_counts_hundredths(video) && 100 % settings.fps != 0)
        sc_warn(
            app->ctx,
            "output.fps is %d: a GIF counts in hundredths of a second, so that frames of %s are "
            "shown for %d or %d of them; 20, 25 and 50 frames per second are even",
            settings.fps, video, 100 / settings.fps, 100 / settings.fps + 1);
    if (bytes > 0 && is_large)
        sc_warn(
            app->ctx,
            "%s: %d frames of %d x %d take about %.0f MB (an estimate; segcast plan draws some "
            "and tells better); smaller or fewer frames make it fit for slides and pages, and a "
            "video (.mp4, .webm) is far smaller",
            video, job->animation.frames, settings.width_px, settings.height_px, bytes / 1e6);
}

void sc_warn_of_outputs(const sc_app *app, const sc_job *job)
{
    if (sc_run_has_video(job))
        warn_of_video(app, job);
    else if (job->output.frames == SC_FRAMES_NONE)
        sc_warn(app->ctx, "output.video and output.frames are both none: the frames are drawn and "
                          "their hashes are kept, but no picture is");
}

/* ---- a zoom that crops ---- */

/* Is a point removed by a clip plane? Only for scenes in which all planes cut all tissues. */
static bool is_clipped(const sc_scene *scene, sc_vec3 p)
{
    for (int i = 0; i < scene->plane_count; i++) {
        if (sc_vec3_dot(scene->planes[i].normal, p) + scene->planes[i].offset_mm < 0)
            return true;
    }
    return false;
}

/* @return how far the points that are not clipped reach, as a multiple of half the picture: above 1
 * some are outside of it. @param step look at every so many points only. */
static double reach_of(const sc_scene *scene, bool clips, double aspect, const sc_vec3 *points,
                       size_t count, size_t step)
{
    const sc_camera *camera = &scene->camera;
    double most = 0;

    for (size_t i = 0; i < count; i += step) {
        const sc_vec3 d = sc_vec3_sub(points[i], camera->position_mm);
        const double depth = sc_vec3_dot(d, camera->forward);
        const double scale =
            camera->half_height * (camera->projection == SC_PERSPECTIVE ? depth : 1);
        double reach;

        if (clips && is_clipped(scene, points[i]))
            continue;
        reach =
            fmax(fabs(sc_vec3_dot(d, camera->right)) / aspect, fabs(sc_vec3_dot(d, camera->up)));
        most = fmax(most, scale > 0 ? reach / scale : HUGE_VAL);
    }
    return most;
}

void sc_warn_of_zoom(const sc_app *app, const sc_session *session, double aspect,
                     const sc_vec3 *points, size_t count)
{
    enum { FRAMES = 24, POINTS = 20000 }; /* at how many to look; all frames and points are alike */
    const sc_timeline *t = &session->timeline;
    const int frames = t->animation.frames;
    const bool clips = t->animation.clip_mode == SC_CLIP_KEEP && t->clip_set_count == 1;
    double worst = 1.005, worst_zoom = 1; /* a reach of less is within the rim of a tissue */
    int at = -1;

    if (t->animation.move_count || t->animation.camera.fov_track.count)
        return; /* what is left of the picture then is meant to be seen */
    for (int i = 0; i < FRAMES && i < frames; i++) {
        const int k = frames <= FRAMES ? i : (int)((double)i * (frames - 1) / (FRAMES - 1));
        const sc_scene scene = sc_timeline_scene(t, k);
        const double zoom = t->half_height / scene.camera.half_height;
        double reach;

        if (zoom <= 1)
            continue;
        reach = reach_of(&scene, clips, aspect, points, count, count / POINTS + 1);
        if (reach > worst && reach / zoom <= 1.005) { /* without the zoom it would fit */
            worst = reach;
            worst_zoom = zoom;
            at = k;
        }
    }
    if (at >= 0)
        sc_warn(app->ctx,
                "the zoom of %.3g crops what is shown, for example in frame %d; up to %.3g all of "
                "it would be in the picture there",
                worst_zoom, at + (session->shot ? session->shot->span.first : 0),
                floor(100 * worst_zoom / worst) / 100);
}
