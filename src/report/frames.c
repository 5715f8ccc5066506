/* SPDX-License-Identifier: BSD-3-Clause */
/* The cost of the frames along the film, with some of them below the curve. */
#include "internal.h"

#include "segcast/video.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum {
    POINTS = 600, /* most points of the curve */
    PATH_BYTES = 4096
};

/* A film of more GOPs than this shows frames that begin one: they can be decoded alone, and are
 * near enough to the places at which they stand. */
enum { MANY_GOPS = 24 };

/* ---- the curve ---- */

/* The points of the curve; those of a part of the film without any frame are NaN. */
typedef struct curve {
    double x[POINTS], mean[POINTS], low[POINTS], high[POINTS];
    int count;
    int frames_each; /* frames of the film that a point stands for */
} curve;

/* @return whether the cost of a frame is known: a frame that an accident has left has none. */
static bool is_known(const sc_past_frame *past)
{
    return past->result.render_cpu_s > 0;
}

/* Fill the curve. */
static void fill_curve(const sc_history *history, int frames, curve *c)
{
    int at = 0;

    c->frames_each = (frames + POINTS - 1) / POINTS;
    c->count = (frames + c->frames_each - 1) / c->frames_each;
    for (int i = 0; i < c->count; i++) {
        const int end = (i + 1) * c->frames_each;
        int found = 0;

        c->x[i] = i * c->frames_each + 0.5 * (c->frames_each - 1);
        c->mean[i] = c->low[i] = c->high[i] = NAN;
        for (; at < history->frame_count && history->frames[at].result.frame < end; at++) {
            const double cost = history->frames[at].result.render_cpu_s;

            if (!is_known(&history->frames[at]))
                continue;
            c->low[i] = found && c->low[i] < cost ? c->low[i] : cost;
            c->high[i] = found && c->high[i] > cost ? c->high[i] : cost;
            c->mean[i] = found ? c->mean[i] + (cost - c->mean[i]) / (found + 1) : cost;
            found++;
        }
    }
}

/* Fill bands between the lowest and the highest cost, without those parts of which none is known.
 */
static void draw_bands(sc_plot *plot, const curve *c)
{
    for (int i = 0, end; i < c->count; i = end) {
        end = i + 1;
        if (!isfinite(c->mean[i]))
            continue;
        while (end < c->count && isfinite(c->mean[end]))
            end++;
        sc_plot_band(plot, &c->x[i], &c->low[i], &c->high[i], end - i,
                     sc_phase_color(SC_PHASE_RENDER));
    }
}

/* Describe the costs in words. @return the highest one, 0 if none is known. */
static double describe(const sc_history *history, char *text, size_t size)
{
    const sc_past_frame *least = NULL, *most = NULL;
    double sum = 0;
    int known = 0;

    for (int i = 0; i < history->frame_count; i++) {
        const sc_past_frame *past = &history->frames[i];

        if (!is_known(past))
            continue;
        least = least && least->result.render_cpu_s <= past->result.render_cpu_s ? least : past;
        most = most && most->result.render_cpu_s >= past->result.render_cpu_s ? most : past;
        sum += past->result.render_cpu_s;
        known++;
    }
    text[0] = '\0';
    if (known)
        snprintf(text, size, "Least %.3f s (frame %d), most %.3f s (frame %d), mean %.3f s.",
                 least->result.render_cpu_s, least->result.frame, most->result.render_cpu_s,
                 most->result.frame, sum / known);
    return most ? most->result.render_cpu_s : 0;
}

/* Draw the curve, with marks at the @p marks [count]. */
static void draw_curve(sc_page *page, const sc_run_stats *stats, int frames, const double *marks,
                       int count, curve *c)
{
    char words[160];
    const double most = describe(&stats->history, words, sizeof words);
    const sc_plot_words plot_words = {"CPU seconds of drawing each frame", words, "frame"};
    sc_plot plot;

    if (most <= 0) {
        sc_page_add(page, "<p>No run has measured a frame.</p>\n");
        return;
    }
    fill_curve(&stats->history, frames, c);
    plot = sc_plot_begin(page, &plot_words, sc_axis_to(frames, 6, true), sc_axis_make(0, most, 4));
    if (c->frames_each > 1)
        draw_bands(&plot, c);
    sc_plot_marks(&plot, marks, count);
    sc_plot_line(&plot, c->x, c->mean, c->count, sc_phase_color(SC_PHASE_RENDER), false);
    sc_plot_end(&plot);
}

/* ---- cost against what was met ---- */

/* Add the plot of what each frame cost against how many boundary voxels its rays met: one dot for
 * each frame that was measured, of many every so many. */
static void draw_dots(sc_page *page, const sc_history *history)
{
    const int every = (history->frame_count + POINTS - 1) / POINTS;
    double x[POINTS], y[POINTS], most[2] = {0, 0}, sums[2] = {0, 0}, squares[3] = {0, 0, 0};
    sc_plot_words words = {"CPU seconds of drawing each frame against the boundary voxels that its "
                           "rays met (contributions)",
                           "", "contributions, in millions"};
    char text[160];
    sc_plot plot;
    int count = 0;

    for (int i = 0; i < history->frame_count && count < POINTS; i += every) {
        const sc_past_frame *past = &history->frames[i];

        if (!past->measured || !is_known(past))
            continue;
        x[count] = (double)past->result.contributions / 1e6;
        y[count] = past->result.render_cpu_s;
        most[0] = fmax(most[0], x[count]);
        most[1] = fmax(most[1], y[count]);
        sums[0] += x[count];
        sums[1] += y[count];
        squares[0] += x[count] * x[count];
        squares[1] += y[count] * y[count];
        squares[2] += x[count] * y[count];
        count++;
    }
    if (count < 2)
        return;
    for (int i = 0; i < 2; i++)
        squares[i] -= sums[i] * sums[i] / count;
    squares[2] -= sums[0] * sums[1] / count;
    snprintf(text, sizeof text, "%d frames; the coefficient of correlation is %.2f.", count,
             squares[0] > 0 && squares[1] > 0 ? squares[2] / sqrt(squares[0] * squares[1]) : 0);
    words.description = text;
    plot = sc_plot_begin(page, &words, sc_axis_make(0, most[0], 6), sc_axis_make(0, most[1], 4));
    sc_plot_points(&plot, x, y, count, sc_phase_color(SC_PHASE_RENDER));
    sc_plot_end(&plot);
    sc_page_add(page, "<p class=\"note\">%s</p>\n", text);
}

/* ---- the pictures ---- */

/* Frames that are shown, in rising order. */
typedef struct gallery {
    sc_page *page;
    sc_status status;               /* of what was done with a picture */
    int wanted[SC_REPORT_PICTURES]; /* numbers, the first `count` */
    int count;
    int shown[SC_REPORT_PICTURES];       /* the first `found` */
    sc_image images[SC_REPORT_PICTURES]; /* of those, small; owned */
    int found;
} gallery;

/* Choose the frames: in the middle of equal parts of the film. */
static void choose_frames(const sc_report_run *run, gallery *g)
{
    const int gop = run->fps > 0 ? run->fps : 1;

    g->count = run->frames < SC_REPORT_PICTURES ? run->frames : SC_REPORT_PICTURES;
    for (int i = 0; i < g->count; i++) {
        const int middle = (int)((2 * i + 1) * (long)run->frames / (2 * g->count));

        g->wanted[i] = run->frames / gop > MANY_GOPS ? middle / gop * gop : middle;
    }
}

/* Make @p out from @p image, smaller: each pixel is the mean of those that it covers, with
 * white behind what is transparent. */
static sc_status shrink(const sc_ctx *ctx, const sc_image *image, sc_image *out)
{
    const int side = image->width_px > image->height_px ? image->width_px : image->height_px;
    const double scale = side > SC_REPORT_PICTURE_SIDE ? (double)SC_REPORT_PICTURE_SIDE / side : 1;
    const int width = (int)fmax(1, scale * image->width_px + 0.5);
    const int height = (int)fmax(1, scale * image->height_px + 0.5);
    const size_t bytes = sc_pixel_bytes(image->alpha);
    const sc_status status = sc_image_init(ctx, width, height, out);

    for (int p = 0; p < width * height && status == SC_OK; p++) {
        const int x0 = (int)((long)(p % width) * image->width_px / width);
        const int x1 = (int)((long)(p % width + 1) * image->width_px / width);
        const int y0 = (int)((long)(p / width) * image->height_px / height);
        const int y1 = (int)((long)(p / width + 1) * image->height_px / height);
        const int pixels = (x1 - x0) * (y1 - y0);
        long sum[3] = {0};

        for (int y = y0; y < y1; y++) {
            for (int x = x0; x < x1; x++) {
                const uint8_t *rgb =
                    image->rgb + bytes * ((size_t)y * (size_t)image->width_px + (size_t)x);
                const int alpha = image->alpha ? rgb[3] : 255;

                for (int c = 0; c < 3; c++)
                    sum[c] += (rgb[c] * alpha + 255 * (255 - alpha) + 127) / 255;
            }
        }
        for (int c = 0; c < 3; c++)
            out->rgb[3 * p + c] = (uint8_t)((sum[c] + pixels / 2) / pixels);
    }
    return status;
}

/* For sc_video_pick, with a gallery as user: keep a frame. */
static sc_status keep_frame(void *user, int k, double time_s, const sc_image *image)
{
    gallery *g = user;

    (void)time_s;
    if (g->found == SC_REPORT_PICTURES)
        return SC_OK;
    g->status = shrink(g->page->ctx, image, &g->images[g->found]);
    if (g->status == SC_OK)
        g->shown[g->found++] = k;
    return g->status;
}

/* Read the frames from the video @p path. */
static void read_video(gallery *g, const char *path, int fps)
{
    const sc_ctx looking = sc_quiet(g->page->ctx);
    const sc_status status = sc_video_pick(&looking, path, fps, g->wanted, g->count, keep_frame, g);

    if (status != SC_OK && !sc_is_of_input(status))
        g->status = status;
}

/* Read those of the frames that are there as PNG files. */
static void read_png_files(gallery *g, const char *directory)
{
    const sc_ctx looking = sc_quiet(g->page->ctx);

    for (int i = 0; i < g->count && g->status == SC_OK; i++) {
        char path[PATH_BYTES];
        sc_image image = {0};
        sc_status status;

        snprintf(path, sizeof path, "%s/frames/%06d.png", directory, g->wanted[i]);
        status = sc_image_load_png_alpha(&looking, path, &image);
        if (status == SC_OK)
            (void)keep_frame(g, g->wanted[i], 0, &image); /* its error is in g->status */
        else if (!sc_is_of_input(status))
            g->status = status;
        sc_image_clear(&image);
    }
}

/* Find the pictures: in the video, in what there is of it, or in PNG files. */
static void read_pictures(const sc_report_run *run, gallery *g)
{
    char path[PATH_BYTES];
    sc_text partial = {0};
    const bool has_video = strcmp(run->video, "none") != 0;

    snprintf(path, sizeof path, "%s/%s", run->directory, run->video);
    if (has_video && access(path, R_OK) == 0)
        read_video(g, path, run->fps);
    if (has_video && g->found == 0 && g->status == SC_OK && !run->slice) {
        g->status = sc_video_partial_name(g->page->ctx, path, &partial);
        if (g->status == SC_OK && access(partial.data, R_OK) == 0)
            read_video(g, partial.data, run->fps);
        sc_text_clear(&partial);
    }
    if (g->found == 0 && run->png)
        read_png_files(g, run->directory);
}

/* Add a picture to the page. */
static void add_picture(gallery *g, int i)
{
    sc_page *page = g->page;
    const sc_image *image = &g->images[i];
    char *data = NULL;
    size_t bytes = 0;

    g->status = sc_image_compress_png(page->ctx, image, "a small picture", &data, &bytes);
    if (g->status != SC_OK)
        return;
    sc_page_add(page,
                "<figure><img alt=\"frame %d\" width=\"%d\" height=\"%d\" "
                "src=\"data:image/png;base64,",
                g->shown[i], image->width_px, image->height_px);
    sc_page_base64(page, data, bytes);
    sc_page_add(page, "\"/><figcaption>%d</figcaption></figure>\n", g->shown[i]);
    free(data);
}

void sc_report_frames(sc_page *page, const sc_report_run *run, const sc_run_stats *stats)
{
    gallery g = {.page = page, .status = page->status};
    double marks[SC_REPORT_PICTURES];
    void *block = NULL;

    sc_page_section(page, "Cost along the film");
    if (g.status == SC_OK)
        g.status = sc_alloc(page->ctx, 1, sizeof(curve), &block);
    if (g.status != SC_OK)
        goto out;
    choose_frames(run, &g);
    read_pictures(run, &g);
    for (int i = 0; i < g.found; i++)
        marks[i] = g.shown[i];
    draw_curve(page, stats, run->frames, marks, g.found, block);
    if (g.found)
        sc_page_add(page,
                    "<div class=\"film\" style=\"grid-template-columns: repeat(%d, minmax(0, "
                    "1fr))\">\n",
                    g.found);
    for (int i = 0; i < g.found && g.status == SC_OK; i++)
        add_picture(&g, i);
    if (g.found)
        sc_page_add(page, "</div>\n");
    draw_dots(page, &stats->history);
out:
    if (page->status == SC_OK)
        page->status = g.status;
    for (int i = 0; i < g.found; i++)
        sc_image_clear(&g.images[i]);
    sc_free(block);
    sc_page_section_end(page);
}
