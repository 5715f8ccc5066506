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

sc_status sc_shot_draw(const sc_app *app, sc_session *session, const sc_scene *scene,
                       const sc_rows *rows, sc_image *image, sc_render_stats *stats)
{
    const sc_timeline *timeline = &session->timeline;
    const sc_annotations annotations = sc_session_annotations(session);
    sc_renderer *renderer = sc_session_begin_frame(session, scene->frame);
    const sc_views views = {.low_mm = timeline->low_mm,
                            .high_mm = timeline->high_mm,
                            .oriented = session->volume.oriented};
    sc_status status;

    if (session->job.output.layout == SC_LAYOUT_PICTURE)
        sc_render_frame(renderer, scene, rows, image, stats);
    else
        SC_TRY(sc_views_draw(app->ctx, renderer, &views, scene, rows, image, stats));
    status = sc_annotations_draw(app->ctx, &annotations, scene, image, rows);
out:
    return status;
}
