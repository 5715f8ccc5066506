/* SPDX-License-Identifier: BSD-3-Clause */
/* What the outputs of a job will be, told before anything is drawn, with warnings. */
#include "render/run.h"

/* @return what stands between a place and its message. */
static const char *colon_after(const char *where)
{
    return where[0] ? ": " : "";
}

/* Tell how large a GIF or WebP becomes, and warn of what the format of the video does to it:
 * pictures that no player has to know, times that a GIF cannot count, sizes that nobody wants in
 * slides. */
static void tell_of_video(const sc_app *app, const sc_job *job)
{
    static const double large_bytes = 20e6;
    const char *video = job->output.video;
    const sc_video_settings settings = sc_run_video_settings(job);
    const double bytes = sc_video_bytes_guess(video, &settings, job->animation.frames);
    const bool is_large = bytes > large_bytes || settings.height_px >= 1080;

    if (sc_video_beyond_levels(video, &settings))
        sc_warn(app->ctx,
                "%s%soutput.size is %d x %d: that is more than the 35.7 million pixels for which "
                "%s has levels, so that players may refuse %s; 8k (7680x4320) is within them",
                job->lines.size, colon_after(job->lines.size), settings.width_px,
                settings.height_px, sc_video_codec_name(video, settings.codec), video);
    if (sc_video_counts_hundredths(video) && 100 % settings.fps != 0)
        sc_warn(app->ctx,
                "%s%soutput.fps is %d: a GIF counts in hundredths of a second, so that frames of "
                "%s are shown for %d or %d of them; 20, 25 and 50 frames per second are even",
                job->lines.fps, colon_after(job->lines.fps), settings.fps, video,
                100 / settings.fps, 100 / settings.fps + 1);
    if (bytes > 0 && is_large)
        sc_warn(app->ctx,
                "%s%s%s: %d frames of %d x %d take about %.0f MB (an estimate; segcast plan draws "
                "some and tells better); smaller or fewer frames make it fit for slides and pages, "
                "and a video (.mp4, .webm) is far smaller",
                job->lines.video, colon_after(job->lines.video), video, job->animation.frames,
                settings.width_px, settings.height_px, bytes / 1e6);
    else if (bytes > 0)
        sc_info(app->ctx,
                "%s: %d frames of %d x %d take about %.*f MB (an estimate; segcast plan draws some "
                "and tells better)",
                video, job->animation.frames, settings.width_px, settings.height_px,
                bytes < 1e6 ? 2 : 1, bytes / 1e6);
}

void sc_warn_of_outputs(const sc_app *app, const sc_job *job)
{
    if (sc_run_has_video(job))
        tell_of_video(app, job);
    else if (job->output.frames == SC_FRAMES_NONE)
        sc_warn(app->ctx,
                "%s%soutput.video and output.frames are both none: the frames are drawn and their "
                "hashes are kept, but no picture is",
                job->lines.video, colon_after(job->lines.video));
}
