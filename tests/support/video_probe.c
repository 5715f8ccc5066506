/* SPDX-License-Identifier: BSD-3-Clause */
/* video_probe VIDEO [K OUT.png] decodes a video, prints the number of its frames, their size and
 * the time of the last one, and writes frame K as PNG. */
#include "segcast/video.h"

#include <stdlib.h>

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

int main(int argc, char **argv)
{
    const sc_ctx ctx = {.level = SC_LOG_INFO, .write = sc_log_to_stderr};
    probe p = {
        .ctx = &ctx, .wanted = argc > 3 ? atoi(argv[2]) : -1, .out = argc > 3 ? argv[3] : NULL};

    if (argc < 2 || sc_video_decode(&ctx, argv[1], on_frame, &p) != SC_OK)
        return 1;
    printf("%d frames of %d x %d, last at %.4f s\n", p.frames, p.width_px, p.height_px, p.last_s);
    return 0;
}
