/* SPDX-License-Identifier: BSD-3-Clause */
/* One frame of a session without shots, or of one shot: what is shown in it, and its picture. */
#include "app.h"

#include "segcast/views.h"

#include <string.h>

double sc_session_aspect(const sc_session *session)
{
    const int *size_px = session->job.output.size_px;

    return session->job.output.layout == SC_LAYOUT_VIEWS ? sc_views_aspect(size_px[0], size_px[1])
                                                         : (double)size_px[0] / size_px[1];
}

sc_status sc_session_image(const sc_app *app, const sc_session *session, sc_image *out)
{
    const sc_job *job = &session->job;

    return sc_image_init_alpha(app->ctx, job->output.size_px[0], job->output.size_px[1],
                               job->render.background.is_none, out);
}

/* Fill session->frame_colors with the colours of frame @p k. */
static void find_colors(const sc_session *session, int k)
{
    const double at = sc_frame_time(k, session->job.animation.frames);

    for (int id = 0; id < session->volume.label_count; id++) {
        const sc_tissue *tissue = &session->tissues[id];

        if (tissue->color_track)
            sc_track_color(&session->color_tones[tissue->color_track - 1], at,
                           session->frame_colors[id]);
        else
            memcpy(session->frame_colors[id], tissue->rgb_linear, sizeof tissue->rgb_linear);
    }
    if (session->column_values)
        sc_column_colors(session, at);
}

/* @return whether the opacity of any tissue changes in the film. */
static bool fades(const sc_session *session)
{
    for (int id = 1; session->tissues && id < session->volume.label_count; id++) {
        if (session->tissues[id].fade_group)
            return true;
    }
    return false;
}

sc_scene sc_shot_scene(const sc_session *session, int k)
{
    sc_scene scene = sc_timeline_scene(&session->timeline, k);

    if (session->frame_colors) {
        find_colors(session, k);
        scene.colors = (const float(*)[3])session->frame_colors;
    }
    if (fades(session)) {
        sc_timeline_fades(&session->timeline, k, session->frame_fades, session->volume.label_count);
        scene.fades = session->frame_fades;
    }
    if (session->shift_count &&
        sc_timeline_offsets(&session->timeline, k, session->frame_offsets_mm,
                            session->volume.label_count))
        scene.offsets_mm = session->frame_offsets_mm;
    return scene;
}

void sc_draw_background(const sc_scene *scene, const sc_rows *rows, sc_image *image)
{
    const size_t bytes = sc_pixel_bytes(image->alpha);
    const int first = rows && rows->first > 0 ? rows->first : 0;
    const int end = rows && rows->end < image->height_px ? rows->end : image->height_px;
    uint8_t *to = image->rgb + (size_t)first * (size_t)image->width_px * bytes;

    for (int i = 0; i < (end - first) * image->width_px; i++, to += bytes) {
        if (image->alpha)
            memset(to, 0, bytes);
        else
            memcpy(to, scene->look.background, bytes);
    }
}

sc_status sc_shot_draw(const sc_app *app, sc_session *session, int k, const sc_rows *rows,
                       sc_image *image, sc_render_stats *stats)
{
    const sc_timeline *timeline = &session->timeline;
    const sc_scene scene = sc_shot_scene(session, k);
    const sc_annotations annotations = sc_session_annotations_at(session, &scene);
    sc_renderer *renderer = sc_session_begin_frame(session, k);
    sc_views views = {.point_mm = scene.point_mm,
                      .low_mm = timeline->low_mm,
                      .high_mm = timeline->high_mm,
                      .oriented = session->volume.oriented,
                      .dark_text = scene.dark_text};
    sc_status status;

    if (session->job.output.layout == SC_LAYOUT_PICTURE)
        sc_render_frame(renderer, &scene, rows, image, stats);
    else
        SC_TRY(sc_views_draw(app->ctx, renderer, &views, &scene, rows, image, stats));
    status = sc_annotations_draw(app->ctx, &annotations, k, &scene, image, rows);
out:
    return status;
}

void sc_shot_counts(sc_session *session, int k, const int size_px[2], sc_march_counters *out,
                    sc_render_stats *stats)
{
    const sc_scene scene = sc_shot_scene(session, k);

    sc_render_counts(sc_session_begin_frame(session, k), &scene, size_px[0], size_px[1], out,
                     stats);
}
