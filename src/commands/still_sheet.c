/* SPDX-License-Identifier: BSD-3-Clause */
/* segcast still --sheet N, views and looks: small pictures on one sheet, of frames of the whole
 * film, of what is seen from several places, or as each look draws it. */
#include "commands.h"
#include "segcast/annotate.h"

#include <math.h>

enum {
    PICTURE_AREA = 320 * 180, /* pixels of a picture, about */
    CAPTION_PX = 24,          /* height of the line below a picture */
    GAP_PX = 12,              /* between pictures, and around them */
    CELL_PX = 160             /* a cell is at least so wide, for its caption */
};

/* The colour of the sheet, which shows through pictures without a background. */
static const uint8_t paper[3] = {236, 236, 236};

/* How the pictures stand on the sheet. */
typedef struct grid {
    int columns, rows;
    int cell_px[2]; /* with caption and gap */
    int picture_px[2];
    int sheet_px[2];
} grid;

/* Find the size of a picture that looks as those of the job, with about PICTURE_AREA pixels; a
 * smaller one stays as it is. */
static void shrink(const int size_px[2], int out[2])
{
    const double scale = fmin(1, sqrt(PICTURE_AREA / ((double)size_px[0] * size_px[1])));

    for (int i = 0; i < 2; i++)
        out[i] = (int)fmax(16, floor(size_px[i] * scale + 0.5));
}

static grid make_grid(const int picture_px[2], int columns, int count)
{
    grid g = {.columns = columns,
              .rows = (count + columns - 1) / columns,
              .picture_px = {picture_px[0], picture_px[1]}};

    g.cell_px[0] = (picture_px[0] > CELL_PX ? picture_px[0] : CELL_PX) + GAP_PX;
    g.cell_px[1] = picture_px[1] + CAPTION_PX + GAP_PX;
    g.sheet_px[0] = g.columns * g.cell_px[0] + GAP_PX;
    g.sheet_px[1] = g.rows * g.cell_px[1] + GAP_PX;
    return g;
}

/* Choose the grid on which @p count pictures leave few places empty, on a sheet about as wide as a
 * screen: the ten views stand in two rows of five, as two of twelve places look like something that
 * lacks. */
static grid choose_grid(const int picture_px[2], int count)
{
    grid best = make_grid(picture_px, 1, count);
    double least = HUGE_VAL;

    for (int columns = 1; columns <= count; columns++) {
        const grid g = make_grid(picture_px, columns, count);
        const double empty = 4 * ((double)g.columns * g.rows / count - 1);
        const double shape = fabs(log((double)g.sheet_px[0] / g.sheet_px[1] / 1.6));

        if (shape + empty < least) {
            least = shape + empty;
            best = g;
        }
    }
    return best;
}

/* List the frames of the sheet: those of --frames, or --sheet of them evenly from the first to the
 * last, or the first of each shot, which are the views or looks. Caller owns *out, also after an
 * error: sc_free. */
static sc_status choose_frames(const sc_app *app, const sc_job *job, int **out, int *count)
{
    const sc_options *o = &app->options;
    const int total = job->animation.frames,
              n = o->still.pictures < total ? o->still.pictures : total;

    if (o->part.frames) {
        SC_PASS(sc_frames_parse(app->ctx, o->part.frames, total, out, count));
        if (*count <= SC_PICTURES_MAX)
            return SC_OK;
        return sc_fail(app->ctx, SC_ERR_USAGE,
                       "--frames names %d frames, expected at most %d on a sheet; take every "
                       "tenth, for example 0-%d:10",
                       *count, SC_PICTURES_MAX, total - 1);
    }
    SC_PASS(SC_ALLOC(app->ctx, (size_t)n, out));
    for (int i = 0; i < n; i++)
        (*out)[i] = o->still.sheet ? job->film.shots[i].span.first
                    : n > 1        ? (int)floor((double)i * (total - 1) / (n - 1) + 0.5)
                                   : 0;
    *count = n;
    return SC_OK;
}

/* Where picture number @p i stands on the sheet. */
static void find_place(const grid *g, int i, int at_px[2])
{
    at_px[0] =
        GAP_PX + i % g->columns * g->cell_px[0] + (g->cell_px[0] - GAP_PX - g->picture_px[0]) / 2;
    at_px[1] = GAP_PX + i / g->columns * g->cell_px[1];
}

/* Draw each of the @p count frames and copy it to its place on the sheet. */
static sc_status draw_pictures(sc_app *app, sc_session *session, const grid *g, const int *frames,
                               int count, sc_image *sheet)
{
    const size_t row_bytes = 3 * (size_t)g->picture_px[0];
    SC_OWN(sc_image_clear) sc_image picture = {0};
    sc_render_stats stats;
    int at_px[2];

    sc_stage_begin(app->ctx, SC_STAGE_DRAWING, 0, (uint64_t)count);
    for (int i = 0; i < count; i++) {
        sc_image_clear(&picture);
        SC_PASS(sc_session_image(app, session, &picture));
        SC_PASS(sc_session_draw(app, session, frames[i], NULL, &picture, &stats));
        sc_image_flatten(&picture, paper);
        find_place(g, i, at_px);
        for (int y = 0; y < g->picture_px[1]; y++)
            memcpy(sheet->rgb +
                       3 * ((size_t)(at_px[1] + y) * (size_t)sheet->width_px + (size_t)at_px[0]),
                   picture.rgb + (size_t)y * row_bytes, row_bytes);
        sc_stage_add(app->ctx, 1);
    }
    return SC_OK;
}

/* Write number and time of each frame, or the option that gets each picture, below it. */
static sc_status draw_captions(const sc_app *app, const grid *g, const int *frames, int count,
                               int fps, sc_image *sheet)
{
    const sc_letters letters = {13, {40, 40, 40}, {paper[0], paper[1], paper[2]}};
    const uint8_t line[3] = {150, 150, 150};
    const sc_sheet *of = app->options.still.sheet;
    sc_overlay *overlay;
    char caption[64];
    int at_px[2];

    SC_PASS(sc_overlay_begin(app->ctx, sheet, &overlay));
    for (int i = 0; i < count; i++) {
        char time[SC_TIME_CODE_BYTES];

        find_place(g, i, at_px);
        sc_time_code(frames[i], fps, time);
        if (of)
            snprintf(caption, sizeof caption, "--%s %s", of->option, of->words[i]);
        else
            snprintf(caption, sizeof caption, "%d   %s", frames[i], time);
        sc_overlay_frame(overlay, at_px[0] - 0.5, at_px[1] - 0.5, g->picture_px[0] + 1,
                         g->picture_px[1] + 1, 1, line);
        sc_overlay_text(overlay, at_px[0] + 0.5 * g->picture_px[0],
                        at_px[1] + g->picture_px[1] + 0.5 * CAPTION_PX, 0, 0, &letters, caption);
    }
    return sc_overlay_finish(app->ctx, overlay);
}

sc_status sc_draw_sheet(sc_app *app, const char *job_path, const char *path)
{
    SC_OWN(sc_session_clear) sc_session session = {0};
    sc_job *job = &session.job;
    SC_OWN(sc_image_clear) sc_image sheet = {0};
    SC_OWN(sc_free_at) int *frames = NULL;
    int count = 0;
    grid g;

    SC_PASS(sc_session_job(app, job_path, &session));
    SC_PASS(sc_check_output(app, &session.job, path, true));
    SC_PASS(choose_frames(app, job, &frames, &count));
    shrink(job->output.size_px, job->output.size_px);
    for (size_t i = 0; i < job->film.shot_count; i++) {
        job->film.shots[i].job.animation.camera.alone = app->options.still.sheet != NULL;
    }
    g = choose_grid(job->output.size_px, count);
    SC_PASS(sc_session_volume(app, &session));
    SC_PASS(sc_image_init(app->ctx, g.sheet_px[0], g.sheet_px[1], &sheet));
    memset(sheet.rgb, paper[0], sc_image_bytes(&sheet));
    SC_PASS(draw_pictures(app, &session, &g, frames, count, &sheet));
    SC_PASS(draw_captions(app, &g, frames, count, job->output.fps, &sheet));
    SC_PASS(sc_image_save_png(app->ctx, &sheet, path, app->options.overwrite));
    if (app->options.still.sheet)
        sc_info(app->ctx, "%s: %d %s, %d x %d pixels each", path, count,
                app->options.still.sheet->name, g.picture_px[0], g.picture_px[1]);
    else
        sc_info(app->ctx, "%s: %d of %d frames, %d x %d pixels each", path, count,
                job->animation.frames, g.picture_px[0], g.picture_px[1]);
    sc_display_end_stage(app);
    sc_print_made(path);
    return SC_OK;
}
