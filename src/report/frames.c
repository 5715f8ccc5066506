/* SPDX-License-Identifier: BSD-3-Clause */
/* The cost of the frames along the film, with some of them below the curve. */
#include "internal.h"
#include "segcast/video.h"

#include <math.h>
#include <unistd.h>

enum {
    POINTS = 600,  /* most points of the curve */
    DOTS = 300,    /* most frames in the plot of cost against contributions */
    SLOWEST = 3,   /* frames that are named */
    MANY_GOPS = 24 /* a film of more GOPs shows frames that begin one: they can be decoded
                      alone, and are near enough to the places at which they stand */
};

/* ---- cost ---- */

/* @return whether the cost of a frame is known: a frame that an accident has left has none. */
static bool is_known(const sc_past_frame *past)
{
    return past->result.render_cpu_s > 0;
}

/* Set the mean, the lowest and the highest cost of each part of the film: NaN where none is known.
 */
static sc_status set_curve(const sc_ctx *ctx, const sc_history *history, int frames, json_t *cost)
{
    const int each = (frames + POINTS - 1) / POINTS, count = (frames + each - 1) / each;
    static const char *const keys[] = {"mean", "low", "high"};
    enum { CURVES = SC_COUNT_OF(keys) };
    json_t *curves[CURVES] = {json_array(), json_array(), json_array()};
    int at = 0;
    sc_status status;

    for (int i = 0; i < count; i++) {
        double sum = 0, low = INFINITY, high = -INFINITY;
        int found = 0;

        for (; at < history->frame_count && history->frames[at].result.frame < (i + 1) * each;
             at++) {
            const double cpu_s = history->frames[at].result.render_cpu_s;

            if (!is_known(&history->frames[at]))
                continue;
            low = fmin(low, cpu_s);
            high = fmax(high, cpu_s);
            sum += cpu_s;
            found++;
        }
        curves[0] = sc_json_with(curves[0], sc_json_number(sum / found));
        curves[1] = sc_json_with(curves[1], sc_json_number(low));
        curves[2] = sc_json_with(curves[2], sc_json_number(high));
    }
    status = sc_json_set(ctx, cost, "each", json_integer(each));
    for (int i = 0; i < CURVES; i++) {
        const sc_status one = sc_json_set(ctx, cost, keys[i], curves[i]);

        status = status == SC_OK ? one : status;
    }
    return status;
}

/* @return a frame with its cost. */
static json_t *frame_json(const sc_past_frame *past)
{
    return json_pack("[i, f]", past->result.frame, past->result.render_cpu_s);
}

/* Set `cost`, unless no frame was measured. */
static sc_status add_cost(const sc_ctx *ctx, const sc_history *history, int frames, json_t *data)
{
    const sc_past_frame *slowest[SLOWEST + 1] = {0}, *least = NULL;
    json_auto_t *json = json_object(), *names = json_array();
    double sum = 0;
    int known = 0;

    for (int i = 0; i < history->frame_count; i++) {
        const sc_past_frame *past = &history->frames[i];
        int at = known < SLOWEST ? known : SLOWEST;

        if (!is_known(past))
            continue;
        for (; at > 0 && slowest[at - 1]->result.render_cpu_s < past->result.render_cpu_s; at--)
            slowest[at] = slowest[at - 1];
        slowest[at] = past;
        least = least && least->result.render_cpu_s <= past->result.render_cpu_s ? least : past;
        sum += past->result.render_cpu_s;
        known++;
    }
    if (known == 0)
        return SC_OK;
    for (int i = 0; i < known && i < SLOWEST; i++)
        names = sc_json_with(names, frame_json(slowest[i]));
    SC_PASS(set_curve(ctx, history, frames, json));
    SC_PASS(sc_json_set(ctx, json, "slowest", json_incref(names)));
    SC_PASS(sc_json_set(ctx, json, "least", frame_json(least)));
    SC_PASS(sc_json_set(ctx, json, "mean_s", json_real(sum / known)));
    return sc_json_set(ctx, data, "cost", json_incref(json));
}

/* Set `dots`: what each frame that was measured cost, of many every so many, against how many
 * boundary voxels its rays met, in millions. */
static sc_status add_dots(const sc_ctx *ctx, const sc_history *history, json_t *data)
{
    const int every = (history->frame_count + DOTS - 1) / DOTS;
    double sums[2] = {0, 0}, squares[3] = {0, 0, 0};
    json_auto_t *points = json_array();
    int count = 0;

    for (int i = 0; i < history->frame_count; i += every) {
        const sc_past_frame *past = &history->frames[i];
        const double x = (double)past->result.contributions / 1e6, y = past->result.render_cpu_s;

        if (!past->measured || !is_known(past))
            continue;
        points = sc_json_with(points, json_pack("[f, f]", x, y));
        sums[0] += x;
        sums[1] += y;
        squares[0] += x * x;
        squares[1] += y * y;
        squares[2] += x * y;
        count++;
    }
    for (int i = 0; i < 2 && count; i++)
        squares[i] -= sums[i] * sums[i] / count;
    squares[2] -= count ? sums[0] * sums[1] / count : 0;
    if (count < 2)
        return SC_OK;
    return sc_json_set(ctx, data, "dots",
                       json_pack("{s:O, s:f}", "points", points, "correlation",
                                 squares[0] > 0 && squares[1] > 0
                                     ? squares[2] / sqrt(squares[0] * squares[1])
                                     : 0.0));
}

/* ---- the pictures ---- */

/* Frames that are shown, in rising order. */
typedef struct gallery {
    const sc_ctx *ctx;
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

    SC_PASS(sc_image_init(ctx, width, height, out));
    for (int p = 0; p < width * height; p++) {
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
    return SC_OK;
}

/* For sc_video_pick, with a gallery as user: keep a frame. */
static sc_status keep_frame(void *user, int k, double time_s, const sc_image *image)
{
    gallery *g = user;

    if (g->found == SC_REPORT_PICTURES)
        return SC_OK;
    g->status = shrink(g->ctx, image, &g->images[g->found]);
    if (g->status == SC_OK)
        g->shown[g->found++] = k;
    return g->status;
}

/* Read the frames from the video @p path. */
static void read_video(gallery *g, const char *path, int fps)
{
    const sc_ctx looking = sc_quiet(g->ctx);
    const sc_status status = sc_video_pick(&looking, path, fps, g->wanted, g->count, keep_frame, g);

    if (status != SC_OK && !sc_is_of_input(status))
        g->status = status;
}

/* Read those of the frames that are there as PNG files. */
static void read_png_files(gallery *g, const char *directory)
{
    const sc_ctx looking = sc_quiet(g->ctx);

    for (int i = 0; i < g->count && g->status == SC_OK; i++) {
        char path[SC_REPORT_PATH_BYTES];
        SC_OWN(sc_image_clear) sc_image image = {0};
        sc_status status;

        snprintf(path, sizeof path, "%s/frames/%06d.png", directory, g->wanted[i]);
        status = sc_image_load_png(&looking, path, &image);
        if (status == SC_OK)
            (void)keep_frame(g, g->wanted[i], 0, &image); /* its error is in g->status */
        else if (!sc_is_of_input(status))
            g->status = status;
    }
}

/* Find the pictures: in the video, in what there is of it, or in PNG files. */
static void read_pictures(const sc_report_run *run, gallery *g)
{
    char path[SC_REPORT_PATH_BYTES];
    sc_text partial = {0};
    const bool has_video = strcmp(run->video, "none") != 0;

    snprintf(path, sizeof path, "%s/%s", run->directory, run->video);
    if (has_video && access(path, R_OK) == 0)
        read_video(g, path, run->fps);
    if (has_video && g->found == 0 && g->status == SC_OK && !run->slice) {
        g->status = sc_video_partial_name(g->ctx, path, &partial);
        if (g->status == SC_OK && access(partial.data, R_OK) == 0)
            read_video(g, partial.data, run->fps);
        sc_text_clear(&partial);
    }
    if (g->found == 0 && run->png)
        read_png_files(g, run->directory);
}

sc_status sc_report_frames(const sc_ctx *ctx, const sc_report_run *run, const sc_run_stats *stats,
                           json_t *data)
{
    gallery g = {.ctx = ctx};
    json_t *pictures = json_array(), *png = NULL;
    sc_status status;

    SC_TRY(add_cost(ctx, &stats->history, run->frames, data));
    SC_TRY(add_dots(ctx, &stats->history, data));
    choose_frames(run, &g);
    read_pictures(run, &g);
    SC_TRY(g.status);
    for (int i = 0; i < g.found; i++) {
        SC_TRY(sc_json_png(ctx, &g.images[i], &png));
        pictures = sc_json_with(pictures, json_pack("{s:i, s:i, s:i, s:o}", "frame", g.shown[i],
                                                    "width", g.images[i].width_px, "height",
                                                    g.images[i].height_px, "png", png));
    }
    status = sc_json_set(ctx, data, "pictures", pictures ? json_incref(pictures) : NULL);
out:
    json_decref(pictures);
    for (int i = 0; i < g.found; i++)
        sc_image_clear(&g.images[i]);
    return status;
}
