/* SPDX-License-Identifier: BSD-3-Clause */
/* A video from frames in order: groups are encoded as frames come, and added to the file. */
#include "internal.h"

#include <string.h>

struct sc_sink {
    char *path;
    int group;
    sc_encoder *encoder;
    sc_muxer *muxer;
};

static sc_status end_group(const sc_ctx *ctx, sc_sink *sink)
{
    sc_segment segment = {0};
    sc_status status = sc_encoder_finish(ctx, sink->encoder, 0, 0, &segment);

    if (status == SC_OK)
        status = sc_muxer_add(ctx, sink->muxer, &segment);
    sc_segment_free(&segment);
    return status;
}

sc_status sc_sink_push(const sc_ctx *ctx, sc_sink *sink, const sc_image *image)
{
    sc_status status =
        sc_encoder_push(ctx, sink->encoder, sc_encoder_convert(sink->encoder, image), 0);

    if (status == SC_OK && sc_encoder_count(sink->encoder) == sink->group)
        status = end_group(ctx, sink);
    return status;
}

sc_status sc_sink_finish(const sc_ctx *ctx, sc_sink *sink, bool complete)
{
    sc_text partial = {0};
    sc_status status = SC_OK;

    if (sc_encoder_count(sink->encoder) > 0)
        SC_TRY(end_group(ctx, sink));
    if (!complete)
        SC_TRY(sc_partial_name(ctx, sink->path, &partial));
    status = sc_muxer_finish(ctx, sink->muxer, complete ? sink->path : partial.data);
out:
    sc_text_clear(&partial);
    return status;
}

void sc_sink_close(sc_sink *sink)
{
    if (!sink)
        return;
    sc_muxer_close(sink->muxer);
    sc_encoder_close(sink->encoder);
    sc_free(sink->path);
    sc_free(sink);
}

sc_status sc_partial_name(const sc_ctx *ctx, const char *path, sc_text *out)
{
    const char *dot = strrchr(path, '.');

    return sc_text_add(ctx, out, "%.*s.partial%s", (int)(dot - path), path, dot);
}

sc_status sc_sink_open_video(const sc_ctx *ctx, const char *path, const sc_video_settings *settings,
                             sc_sink **out)
{
    sc_sink *sink = NULL;
    sc_text copy = {0};
    void *block = NULL;
    sc_status status;

    SC_TRY(sc_zalloc(ctx, 1, sizeof *sink, &block));
    sink = block;
    sink->group = sc_video_group(settings);
    SC_TRY(sc_text_add(ctx, &copy, "%s", path));
    sink->path = copy.data;
    SC_TRY(sc_encoder_open(ctx, path, settings, &sink->encoder));
    SC_TRY(sc_muxer_open(ctx, path, &sink->muxer));
    *out = sink;
    return SC_OK;
out:
    sc_sink_close(sink);
    return status;
}
