/* SPDX-License-Identifier: BSD-3-Clause */
/* A video as a sink: groups are encoded as frames come, and added to the file. */
#include "internal.h"

#include <string.h>

typedef struct video_sink {
    sc_sink base;
    char *path;
    int group;
    sc_encoder *encoder;
    sc_muxer *muxer;
} video_sink;

static sc_status end_group(const sc_ctx *ctx, video_sink *sink)
{
    sc_segment segment = {0};
    sc_status status = sc_encoder_finish(ctx, sink->encoder, 0, 0, &segment);

    if (status == SC_OK)
        status = sc_muxer_add(ctx, sink->muxer, &segment);
    sc_segment_free(&segment);
    return status;
}

static sc_status video_push(const sc_ctx *ctx, sc_sink *base, int k, const sc_image *image)
{
    video_sink *sink = (video_sink *)base;
    sc_status status;

    (void)k; /* frames come in order; a slice of an animation begins at time 0 */
    status = sc_encoder_push(ctx, sink->encoder, sc_encoder_convert(sink->encoder, image), 0);
    if (status == SC_OK && sc_encoder_count(sink->encoder) == sink->group)
        status = end_group(ctx, sink);
    return status;
}

static sc_status video_finish(const sc_ctx *ctx, sc_sink *base, bool complete)
{
    video_sink *sink = (video_sink *)base;
    sc_status status = SC_OK;

    if (sc_encoder_count(sink->encoder) > 0)
        SC_TRY(end_group(ctx, sink));
    SC_TRY(sc_muxer_finish(ctx, sink->muxer));
    if (!complete) {
        sc_text partial = {0};

        status = sc_partial_name(ctx, sink->path, &partial);
        if (status == SC_OK)
            status = sc_file_publish(ctx, sink->path, partial.data);
        sc_text_clear(&partial);
    }
out:
    return status;
}

static void video_close(sc_sink *base)
{
    video_sink *sink = (video_sink *)base;

    sc_muxer_close(sink->muxer);
    sc_encoder_close(sink->encoder);
    sc_free(sink->path);
    sc_free(sink);
}

static const sc_sink_ops video_ops = {
    .push = video_push, .finish = video_finish, .close = video_close};

sc_status sc_partial_name(const sc_ctx *ctx, const char *path, sc_text *out)
{
    const char *dot = strrchr(path, '.');

    return sc_text_add(ctx, out, "%.*s.partial%s", (int)(dot - path), path, dot);
}

sc_status sc_sink_open_video(const sc_ctx *ctx, const char *path, const sc_video_settings *settings,
                             sc_sink **out)
{
    video_sink *sink = NULL;
    sc_text copy = {0};
    void *block = NULL;
    sc_status status;

    SC_TRY(sc_zalloc(ctx, 1, sizeof *sink, &block));
    sink = block;
    sink->base.ops = &video_ops;
    sink->group = sc_video_group(settings);
    SC_TRY(sc_text_add(ctx, &copy, "%s", path));
    sink->path = copy.data;
    SC_TRY(sc_encoder_open(ctx, path, settings, &sink->encoder));
    SC_TRY(sc_muxer_open(ctx, path, &sink->muxer));
    *out = &sink->base;
    return SC_OK;
out:
    if (sink)
        video_close(&sink->base);
    return status;
}
