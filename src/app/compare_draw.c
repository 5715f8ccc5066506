/* SPDX-License-Identifier: BSD-3-Clause */
/* Drawing several volumes in one picture, beside each other or on both sides of a divider. */
#include "compare.h"

#include <string.h>

/* Draw @p columns, NULL: all, of subject @p s with its names, and add what that took to @p stats.
 */
static sc_status draw_subject(const sc_app *app, const sc_compare *c, int s, const sc_scene *scene,
                              const sc_columns_px *columns, const sc_rows *rows, sc_image *image,
                              sc_render_stats *stats)
{
    const sc_session *subject = &c->parts[s], *plate = sc_compare_plate(c, s);
    const sc_annotations names = sc_session_annotations(subject);
    const sc_annotations name = sc_session_annotations(plate);
    sc_render_stats more;
    sc_status status;

    sc_render_columns(subject->renderer, scene, &subject->panel, columns, rows, image, &more);
    sc_render_stats_add(stats, &more);
    SC_TRY(sc_annotations_draw(app->ctx, &names, scene, image, rows));
    status = sc_annotations_draw(app->ctx, &name, scene, image, rows);
out:
    return status;
}

/* Copy the columns from @p first on of @p rows of a picture. */
static void copy_columns(const sc_image *from, int first, const sc_rows *rows, sc_image *to)
{
    const size_t bytes = sc_pixel_bytes(to->alpha), width = (size_t)to->width_px;

    for (int y = rows->first; y < rows->end && first < to->width_px; y++) {
        const size_t at = ((size_t)y * width + (size_t)first) * bytes;

        memcpy(to->rgb + at, from->rgb + at, (width - (size_t)first) * bytes);
    }
}

/* Draw the line of the divider at column @p x, as long as the pictures are high. @param dark_text
 * as of sc_scene: the line has the colour of text. */
static void draw_line(const sc_session *front, double dark_text, int x, const sc_rows *rows,
                      sc_image *image)
{
    const int width = image->height_px / 360 > 1 ? image->height_px / 360 : 1;
    const int halo = width / 2 > 1 ? width / 2 : 1, height = front->panel.height_px;
    const uint8_t level = (uint8_t)(255 + dark_text * (24 - 255) + 0.5);
    const uint8_t halo_level = (uint8_t)(24 + 255 - level);
    const uint8_t rgb[3] = {level, level, level};
    const uint8_t halo_rgb[3] = {halo_level, halo_level, halo_level};

    sc_overlay_fill(image, &(sc_viewport){x - width / 2 - halo, 0, width + 2 * halo, height},
                    halo_rgb, 217, rows);
    sc_overlay_fill(image, &(sc_viewport){x - width / 2, 0, width, height}, rgb, 255, rows);
}

/* Draw both subjects beside a divider. @param scenes of both. */
static sc_status draw_divided(const sc_app *app, sc_compare *c, const sc_scene *scenes,
                              const sc_rows *rows, sc_image *image, sc_render_stats *stats)
{
    const int x = sc_divider_px(scenes->divider, image->width_px);
    const sc_columns_px left = {0, x}, right = {x, image->width_px};
    sc_status status = SC_OK;

    if (x > 0)
        SC_TRY(draw_subject(app, c, 0, &scenes[0], &left, rows, image, stats));
    if (x < image->width_px) {
        if (!c->other.rgb)
            SC_TRY(sc_image_init_alpha(app->ctx, image->width_px, image->height_px, image->alpha,
                                       &c->other));
        sc_draw_background(&scenes[1], rows, &c->other);
        SC_TRY(draw_subject(app, c, 1, &scenes[1], &right, rows, &c->other, stats));
        copy_columns(&c->other, x, rows, image);
    }
    if (x > 0 && x < image->width_px)
        draw_line(sc_compare_front(c), scenes->dark_text, x, rows, image);
out:
    return status;
}

sc_status sc_compare_draw(const sc_app *app, sc_session *session, int k, const sc_rows *rows,
                          sc_image *image, sc_render_stats *stats)
{
    sc_compare *c = session->compare;
    const sc_annotations over = sc_session_annotations(sc_compare_front(c));
    sc_scene scenes[SC_SUBJECTS_MAX] = {{0}};
    const int first = rows && rows->first > 0 ? rows->first : 0;
    const sc_rows part = {first,
                          rows && rows->end < image->height_px ? rows->end : image->height_px};
    sc_status status = SC_OK;

    *stats = (sc_render_stats){0};
    for (int s = 0; s < c->count; s++)
        scenes[s] = sc_session_scene_at(&c->parts[s], k);
    sc_draw_background(scenes, &part, image);
    if (session->job.compare.has_divider)
        SC_TRY(draw_divided(app, c, scenes, &part, image, stats));
    for (int s = 0; s < c->count && !session->job.compare.has_divider; s++)
        SC_TRY(draw_subject(app, c, s, &scenes[s], NULL, &part, image, stats));
    status = sc_annotations_draw(app->ctx, &over, scenes, image, &part);
out:
    return status;
}

/* Count the work of the pixels of one subject between two columns of a picture. @param room for the
 * pixels of its @p panel. */
static void count_subject(const sc_session *subject, const sc_scene *scene,
                          const sc_viewport *panel, const sc_columns_px *columns, int width_px,
                          sc_march_counters *room, sc_march_counters *out, sc_render_stats *stats)
{
    sc_render_stats more;

    sc_render_counts(subject->renderer, scene, panel->width_px, panel->height_px, room, &more);
    sc_render_stats_add(stats, &more);
    for (int y = 0; y < panel->height_px; y++) {
        for (int x = 0; x < panel->width_px; x++) {
            const int column = panel->x_px + x;

            if (column >= columns->first && column < columns->end)
                out[(size_t)(panel->y_px + y) * (size_t)width_px + (size_t)column] =
                    room[(size_t)y * (size_t)panel->width_px + (size_t)x];
        }
    }
}

void sc_compare_counts(sc_session *session, int k, const int size_px[2], sc_march_counters *out,
                       sc_render_stats *stats)
{
    const sc_ctx silent = {.rank = 0};
    const size_t pixels = (size_t)size_px[0] * (size_t)size_px[1];
    sc_places places;
    void *room = NULL;

    *stats = (sc_render_stats){0};
    memset(out, 0, pixels * sizeof *out);
    sc_place_subjects(&session->job, session->compare->captions, size_px, &places);
    if (sc_alloc(&silent, pixels, sizeof *out, &room) != SC_OK)
        return; /* a picture of the work without any */
    for (int s = 0; s < session->compare->count; s++) {
        const bool divided = session->job.compare.has_divider;
        const sc_scene scene = sc_session_scene_at(&session->compare->parts[s], k);
        const int x = sc_divider_px(scene.divider, size_px[0]);
        const sc_columns_px columns = {divided && s ? x : 0, divided && !s ? x : size_px[0]};

        count_subject(&session->compare->parts[s], &scene, &places.panels[s], &columns, size_px[0],
                      room, out, stats);
    }
    sc_free(room);
}
