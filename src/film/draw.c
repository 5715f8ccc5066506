/* SPDX-License-Identifier: BSD-3-Clause */
/* The picture of a frame: that of one panel, or of two mixed (shots), or of several beside each
 * other or on both sides of a divider (subjects). */
#include "panels.h"

#include "segcast/views.h"

double sc_space_aspect(const sc_job *job)
{
    const int *size_px = job->output.size_px;

    return job->output.layout == SC_LAYOUT_VIEWS ? sc_views_aspect(size_px[0], size_px[1])
                                                 : (double)size_px[0] / size_px[1];
}

sc_status sc_session_image(const sc_app *app, const sc_session *session, sc_image *out)
{
    const sc_job *job = &session->job;

    return sc_image_init_alpha(app->ctx, job->output.size_px[0], job->output.size_px[1],
                               job->render.background.is_none, out);
}

sc_scene sc_panel_scene(sc_panel *panel, int k)
{
    return sc_timeline_scene(&panel->timeline, k, &panel->room);
}

/* @return @p rows, NULL: all, as far as they are in a picture. */
static sc_rows rows_in(const sc_rows *rows, const sc_image *image)
{
    const int height = image->height_px;

    return rows ? (sc_rows){rows->first > 0 ? rows->first : 0,
                            rows->end < height ? rows->end : height}
                : (sc_rows){0, height};
}

/* Fill @p rows of a picture with the background of a frame. */
static void draw_background(const sc_scene *scene, const sc_rows *rows, sc_image *image)
{
    const size_t bytes = sc_pixel_bytes(image->alpha);
    uint8_t *to = image->rgb + (size_t)rows->first * (size_t)image->width_px * bytes;

    for (int i = 0; i < (rows->end - rows->first) * image->width_px; i++, to += bytes) {
        if (image->alpha)
            memset(to, 0, bytes);
        else
            memcpy(to, scene->look.background, bytes);
    }
}

/* Make the second picture of a session, beside @p image. */
static sc_status make_other(const sc_app *app, sc_session *session, const sc_image *image)
{
    return session->other.rgb ? SC_OK
                              : sc_image_init_alpha(app->ctx, image->width_px, image->height_px,
                                                    image->alpha, &session->other);
}

/* ---- motion blur ---- */

/* @return what the slices of a panel show. */
static sc_views views_of(const sc_panel *panel)
{
    return (sc_views){.low_mm = panel->timeline.low_mm,
                      .high_mm = panel->timeline.high_mm,
                      .oriented = panel->volume.oriented};
}

/* What is drawn of a panel. */
typedef struct drawn_part {
    const sc_columns_px *columns; /* of the picture, where they are few; NULL: all */
    sc_rows rows;
} drawn_part;

/* Draw a panel in space, with slices beside it if the job has them, without overlays. */
static sc_status draw_space(const sc_app *app, sc_renderer *renderer, const sc_panel *panel,
                            const sc_scene *scene, const drawn_part *what, sc_image *image,
                            sc_render_stats *stats)
{
    const sc_views views = views_of(panel);

    if (panel->job.output.layout == SC_LAYOUT_VIEWS)
        return sc_views_draw(app->ctx, renderer, &views, scene, &what->rows, image, stats);
    sc_render_view(renderer, scene, panel->place.space.width_px ? &panel->place.space : NULL,
                   what->columns, &what->rows, image, stats);
    return SC_OK;
}

/* Make what is needed to add pictures up, and let it be empty in some rows. */
static sc_status begin_sums(const sc_app *app, sc_session *session, const sc_rows *rows,
                            const sc_image *image)
{
    const size_t row = (size_t)image->width_px * sc_pixel_bytes(image->alpha);

    if (!session->light)
        SC_PASS(SC_ALLOC(app->ctx, row * (size_t)image->height_px, &session->light));
    if (!session->moment.rgb)
        SC_PASS(sc_image_init_alpha(app->ctx, image->width_px, image->height_px, image->alpha,
                                    &session->moment));
    for (size_t i = row * (size_t)rows->first; i < row * (size_t)rows->end; i++)
        session->light[i] = 0;
    return SC_OK;
}

/* Draw a panel as draw_space() does while its shutter is open: the mean of the linear light of
 * several moments, if it moves. @param scene of the frame; it is the same afterwards, in
 * panel->room. */
static sc_status draw_open(const sc_app *app, sc_session *session, sc_panel *panel,
                           const sc_scene *scene, const drawn_part *what, sc_image *image,
                           sc_render_stats *stats)
{
    sc_renderer *renderer = sc_panel_begin_frame(panel, scene->frame);
    const int height_px =
        panel->place.space.width_px ? panel->place.space.height_px : image->height_px;
    const int first = what->rows.first, end = what->rows.end;
    size_t points;
    const sc_vec3 *hull = sc_renderer_hull(renderer, &points);
    const int moments =
        sc_timeline_moments(&panel->timeline, scene->frame, hull, points, height_px);

    *stats = (sc_render_stats){0};
    if (moments == 1 || first >= end)
        return draw_space(app, renderer, panel, scene, what, image, stats);
    SC_PASS(begin_sums(app, session, &what->rows, image));
    for (int i = 0; i < moments; i++) {
        sc_scene at = sc_timeline_scene(
            &panel->timeline, sc_timeline_moment(&panel->timeline, scene->frame, i, moments),
            &panel->room);
        sc_render_stats more;

        at.moment = i;
        at.moments = moments;
        if (panel->place.space.width_px) /* beside others */
            memcpy(session->moment.rgb, image->rgb, sc_image_bytes(image));
        SC_PASS(draw_space(app, renderer, panel, &at, what, &session->moment, &more));
        sc_render_stats_add(stats, &more);
        sc_image_add(&session->mixer, &session->moment, first, end, session->light);
    }
    sc_image_mean(&session->mixer, session->light, moments, first, end, image);
    (void)sc_panel_scene(panel, scene->frame);
    return SC_OK;
}

/* ---- shots ---- */

/* Draw a panel that fills the picture. @param stats set, unlike those of subjects. */
static sc_status draw_shot(const sc_app *app, sc_session *session, sc_panel *panel,
                           const sc_scene *scene, const sc_rows *rows, sc_image *image,
                           sc_render_stats *stats)
{
    const sc_annotations annotations = sc_panel_annotations(panel);
    const drawn_part what = {NULL, rows_in(rows, image)};

    *stats = (sc_render_stats){0};
    if (!panel->phases) /* a title card */
        draw_background(scene, &what.rows, image);
    else
        SC_PASS(draw_open(app, session, panel, scene, &what, image, stats));
    return sc_annotations_draw(app->ctx, &annotations, scene, image, rows);
}

/* @return what frame @p k shows: as of sc_film_frame_at, also where there are no shots. */
static sc_film_frame shots_at(const sc_session *session, int k)
{
    return session->spans ? sc_film_frame_at(session->spans, session->panel_count, k)
                          : (sc_film_frame){.frame = k, .before = -1, .share = 1};
}

/* Draw the shot of a frame, and if it is mixed with the one that goes, that, too. */
static sc_status draw_shots(const sc_app *app, sc_session *session, int k, const sc_rows *rows,
                            sc_image *image, sc_render_stats *stats)
{
    const sc_rows part = rows_in(rows, image);
    const sc_film_frame at = shots_at(session, k);
    sc_panel *shot = &session->panels[at.shot], *before;
    sc_scene scene = sc_panel_scene(shot, at.frame);
    sc_render_stats more;

    SC_PASS(draw_shot(app, session, shot, &scene, rows, image, stats));
    if (at.before < 0 && at.share < 1)
        sc_image_fade(&session->mixer, scene.look.background, at.share, part.first, part.end,
                      image);
    if (at.before < 0)
        return SC_OK;
    before = &session->panels[at.before];
    scene = sc_panel_scene(before, at.before_frame);
    SC_PASS(make_other(app, session, image));
    SC_PASS(draw_shot(app, session, before, &scene, &part, &session->other, &more));
    sc_render_stats_add(stats, &more);
    sc_image_mix(&session->mixer, &session->other, at.share, part.first, part.end, image);
    return SC_OK;
}

/* ---- subjects ---- */

/* Draw @p columns, NULL: all, of subject @p s with its names, and add what that took to @p stats.
 */
static sc_status draw_subject(const sc_app *app, sc_session *session, int s, const sc_scene *scene,
                              const sc_columns_px *columns, const sc_rows *rows, sc_image *image,
                              sc_render_stats *stats)
{
    sc_panel *subject = &session->panels[s], *plate = subject + subject->group.count;
    const drawn_part what = {columns, rows_in(rows, image)};
    const sc_annotations names = sc_panel_annotations(subject);
    const sc_annotations name = sc_panel_annotations(plate);
    sc_render_stats more;

    SC_PASS(draw_open(app, session, subject, scene, &what, image, &more));
    sc_render_stats_add(stats, &more);
    SC_PASS(sc_annotations_draw(app->ctx, &names, scene, image, rows));
    return sc_annotations_draw(app->ctx, &name, scene, image, rows);
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
static void draw_line(const sc_panel *front, double dark_text, int x, const sc_rows *rows,
                      sc_image *image)
{
    const int width = image->height_px / 360 > 1 ? image->height_px / 360 : 1;
    const int halo = width / 2 > 1 ? width / 2 : 1, height = front->place.space.height_px;
    const uint8_t level = (uint8_t)(255 + dark_text * (24 - 255) + 0.5);
    const uint8_t halo_level = (uint8_t)(24 + 255 - level);
    const uint8_t rgb[3] = {level, level, level};
    const uint8_t halo_rgb[3] = {halo_level, halo_level, halo_level};

    sc_overlay_fill(image, &(sc_viewport){x - width / 2 - halo, 0, width + 2 * halo, height},
                    halo_rgb, 217, rows);
    sc_overlay_fill(image, &(sc_viewport){x - width / 2, 0, width, height}, rgb, 255, rows);
}

/* Draw both subjects beside a divider. @param scenes of both. */
static sc_status draw_divided(const sc_app *app, sc_session *session, const sc_scene *scenes,
                              const sc_rows *rows, sc_image *image, sc_render_stats *stats)
{
    const int x = sc_divider_px(scenes->divider, image->width_px);
    const sc_columns_px left = {0, x}, right = {x, image->width_px};

    if (x > 0)
        SC_PASS(draw_subject(app, session, 0, &scenes[0], &left, rows, image, stats));
    if (x < image->width_px) {
        SC_PASS(make_other(app, session, image));
        draw_background(&scenes[1], rows, &session->other);
        SC_PASS(draw_subject(app, session, 1, &scenes[1], &right, rows, &session->other, stats));
        copy_columns(&session->other, x, rows, image);
    }
    if (x > 0 && x < image->width_px)
        draw_line(session->panels[0].group.front, scenes->dark_text, x, rows, image);
    return SC_OK;
}

/* Draw all subjects of a comparison, and what is written over them. */
static sc_status draw_subjects(const sc_app *app, sc_session *session, int k, const sc_rows *rows,
                               sc_image *image, sc_render_stats *stats)
{
    const sc_panel_group *group = &session->panels[0].group;
    const sc_annotations over = sc_panel_annotations(group->front);
    const bool is_divided = session->job.compare.has_divider;
    const sc_rows part = rows_in(rows, image);
    sc_scene scenes[SC_SUBJECTS_MAX] = {{0}};

    *stats = (sc_render_stats){0};
    for (int s = 0; s < group->count; s++)
        scenes[s] = sc_panel_scene(&group->all[s], k);
    draw_background(scenes, &part, image);
    if (is_divided)
        SC_PASS(draw_divided(app, session, scenes, &part, image, stats));
    for (int s = 0; s < group->count && !is_divided; s++)
        SC_PASS(draw_subject(app, session, s, &scenes[s], NULL, &part, image, stats));
    return sc_annotations_draw(app->ctx, &over, scenes, image, &part);
}

/* ---- in a hurry ---- */

void sc_session_hurry(sc_session *session, bool hurries)
{
    for (int p = 0; p < session->panel_count; p++) {
        const sc_panel *panel = &session->panels[p];

        for (int i = 0; panel->renderers && i < panel->phases; i++)
            sc_renderer_hurry(panel->renderers[i], hurries);
    }
}

sc_panel *sc_session_panel(sc_session *session, int k, int *frame)
{
    const sc_film_frame at = shots_at(session, k);

    *frame = at.frame;
    return &session->panels[at.shot];
}

sc_status sc_session_sketch(const sc_app *app, sc_session *session, int k, const sc_rows *rows,
                            sc_image *image, sc_render_stats *stats)
{
    const sc_rows part = rows_in(rows, image);
    sc_panel *panel;
    sc_views views;
    sc_scene scene;

    if (session->compare)
        return draw_subjects(app, session, k, rows, image, stats);
    panel = sc_session_panel(session, k, &k);
    scene = sc_panel_scene(panel, k);
    views = views_of(panel);
    *stats = (sc_render_stats){0};
    if (!panel->phases)
        draw_background(&scene, &part, image);
    else if (panel->job.output.layout == SC_LAYOUT_PICTURE)
        sc_render_view(sc_panel_begin_frame(panel, k), &scene, NULL, NULL, &part, image, stats);
    else
        return sc_views_draw(app->ctx, sc_panel_begin_frame(panel, k), &views, &scene, &part, image,
                             stats);
    return SC_OK;
}

/* ---- frames ---- */

sc_status sc_session_draw(const sc_app *app, sc_session *session, int k, const sc_rows *rows,
                          sc_image *image, sc_render_stats *stats)
{
    return (session->compare ? draw_subjects : draw_shots)(app, session, k, rows, image, stats);
}

sc_status sc_session_draw_frame(const sc_app *app, sc_session *session, int k, const sc_rows *rows,
                                sc_image *image, sc_frame_result *result)
{
    sc_render_stats stats = {0};
    const sc_status status = sc_session_draw(app, session, k, rows, image, &stats);

    result->frame = k;
    result->render_wall_s = stats.wall_s;
    result->render_cpu_s = stats.cpu_s;
    result->rays = stats.counters.rays;
    result->samples = stats.counters.cell_visits;
    result->contributions = stats.counters.contributions;
    /* The renderer leaves tiles out when the frame is to be given up. */
    return status == SC_OK && *sc_signals_give_up() ? SC_ERR_INCOMPLETE : status;
}

/* ---- counts ---- */

/* Count the work of the pixels of one subject between two columns of a picture. @param room for the
 * pixels of its @p panel. */
static void count_subject(const sc_panel *subject, const sc_scene *scene, const sc_viewport *panel,
                          const sc_columns_px *columns, int width_px, sc_march_counters *room,
                          sc_march_counters *out, sc_render_stats *stats)
{
    sc_render_stats more;

    sc_render_counts(subject->renderers[0], scene, panel->width_px, panel->height_px, room, &more);
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

/* As sc_session_counts, of a comparison. */
static void count_subjects(sc_session *session, int k, const int size_px[2], sc_march_counters *out,
                           sc_render_stats *stats)
{
    const sc_ctx silent = {.rank = 0};
    const size_t pixels = (size_t)size_px[0] * (size_t)size_px[1];
    sc_places places;
    SC_OWN(sc_free_at) void *room = NULL;

    sc_place_subjects(&session->job, session->compare->captions, size_px, &places);
    if (sc_alloc(&silent, pixels, sizeof *out, &room) != SC_OK)
        return; /* a picture of the work without any */
    for (int s = 0; s < session->panels[0].group.count; s++) {
        const bool divided = session->job.compare.has_divider;
        const sc_scene scene = sc_panel_scene(&session->panels[s], k);
        const int x = sc_divider_px(scene.divider, size_px[0]);
        const sc_columns_px columns = {divided && s ? x : 0, divided && !s ? x : size_px[0]};

        count_subject(&session->panels[s], &scene, &places.panels[s], &columns, size_px[0], room,
                      out, stats);
    }
}

void sc_session_counts(sc_session *session, int k, const int size_px[2], sc_march_counters *out,
                       sc_render_stats *stats)
{
    const sc_film_frame at = shots_at(session, k);
    sc_panel *shot = &session->panels[at.shot];
    sc_scene scene;

    memset(out, 0, (size_t)size_px[0] * (size_t)size_px[1] * sizeof *out);
    *stats = (sc_render_stats){0};
    if (session->compare) {
        count_subjects(session, k, size_px, out, stats);
    } else if (shot->phases) { /* no title card */
        scene = sc_panel_scene(shot, at.frame);
        sc_render_counts(sc_panel_begin_frame(shot, at.frame), &scene, size_px[0], size_px[1], out,
                         stats);
    }
}
