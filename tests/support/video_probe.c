/* SPDX-License-Identifier: BSD-3-Clause */
/* video_probe VIDEO [K OUT.png] decodes a video, prints the number of its frames, their size and
 * the time of the last one, and writes frame K as PNG. video_probe VIDEO chapters prints begin, end
 * (in seconds) and name of each chapter. */
#include "segcast/video.h"

#include <libavformat/avformat.h>
#include <stdlib.h>
#include <string.h>

typedef struct probe {
    const sc_ctx *ctx;
    int frames, width_px, height_px, wanted;
    double last_s;
    const char *out;
} probe;

static sc_status on_frame(void *user, int k, double time_s, const sc_image *image)
{
    probe *p = user;

    p->frames = k + 1;
    p->width_px = image->width_px;
    p->height_px = image->height_px;
    p->last_s = time_s;
    return k == p->wanted ? sc_image_save_png(p->ctx, image, p->out, true) : SC_OK;
}

static int print_chapters(const char *path)
{
    AVFormatContext *format = NULL;

    if (avformat_open_input(&format, path, NULL, NULL) < 0)
        return 1;
    for (unsigned i = 0; i < format->nb_chapters; i++) {
        const AVChapter *c = format->chapters[i];
        const AVDictionaryEntry *title = av_dict_get(c->metadata, "title", NULL, 0);

        printf("%.3f %.3f %s\n", (double)c->start * av_q2d(c->time_base),
               (double)c->end * av_q2d(c->time_base), title ? title->value : "");
    }
    avformat_close_input(&format);
    return 0;
}

int main(int argc, char **argv)
{
    const sc_ctx ctx = {.level = SC_LOG_INFO, .write = sc_log_to_stderr};
    probe p = {
        .ctx = &ctx, .wanted = argc > 3 ? atoi(argv[2]) : -1, .out = argc > 3 ? argv[3] : NULL};

    if (argc == 3 && !strcmp(argv[2], "chapters"))
        return print_chapters(argv[1]);
    if (argc < 2 || sc_video_decode(&ctx, argv[1], on_frame, &p) != SC_OK)
        return 1;
    printf("%d frames of %d x %d, last at %.4f s\n", p.frames, p.width_px, p.height_px, p.last_s);
    return 0;
}
