/* SPDX-License-Identifier: BSD-3-Clause */
/* A video from frames that come in order: each GOP is encoded and appended to the file. */
#include "internal.h"

#include <sys/stat.h>

struct sc_video_writer {
    char *path;     /* the name of the complete video; owned, as are encoder and muxer */
    int gop_frames; /* of each GOP but the last */
    sc_encoder *encoder;
    sc_muxer *muxer;
};

/* Encode the GOP that was begun, of at least one frame, to its end, and append it to the file.
 * Its identity and first frame are 0, since nobody reads them. @return the errors of
 * sc_encoder_finish and sc_muxer_add. */
static sc_status end_gop(const sc_ctx *ctx, sc_video_writer *writer)
{
    SC_OWN(sc_segment_free) sc_segment segment = {0};

    SC_PASS(sc_encoder_finish(ctx, writer->encoder, 0, 0, &segment));
    return sc_muxer_add(ctx, writer->muxer, &segment);
}

sc_status sc_video_writer_push(const sc_ctx *ctx, sc_video_writer *writer, const sc_image *image)
{
    sc_status status =
        sc_encoder_push(ctx, writer->encoder, sc_encoder_convert(writer->encoder, image), 0);

    if (status == SC_OK && sc_encoder_count(writer->encoder) == writer->gop_frames)
        status = end_gop(ctx, writer);
    return status;
}

/* Find the name of an incomplete video: that of sc_video_partial_name, or with a number, as in
 * "x.partial-2.mp4", if it is taken and @p replace is false. Caller owns *out: sc_text_clear, also
 * after an error. */
static sc_status free_partial_name(const sc_ctx *ctx, const char *path, bool replace, sc_text *out)
{
    SC_OWN(sc_text_clear) sc_text first = {0};
    struct stat info;
    const char *dot;

    SC_PASS(sc_video_partial_name(ctx, path, &first));
    SC_PASS(sc_text_add(ctx, out, "%s", first.data));
    dot = strrchr(first.data, '.');
    for (int number = 2; !replace && !lstat(out->data, &info); number++) {
        sc_text_clear(out);
        SC_PASS(
            sc_text_add(ctx, out, "%.*s-%d%s", (int)(dot - first.data), first.data, number, dot));
    }
    return SC_OK;
}

sc_status sc_video_writer_finish(const sc_ctx *ctx, sc_video_writer *writer, bool complete,
                                 bool replace)
{
    SC_OWN(sc_text_clear) sc_text partial = {0};

    if (sc_encoder_count(writer->encoder) > 0)
        SC_PASS(end_gop(ctx, writer));
    if (!complete)
        SC_PASS(free_partial_name(ctx, writer->path, replace, &partial));
    SC_PASS(sc_muxer_finish(ctx, writer->muxer, complete ? writer->path : partial.data, replace));
    if (!complete)
        sc_info(ctx, "%s: holds the frames so far", partial.data);
    return SC_OK;
}

void sc_video_writer_close(sc_video_writer *writer)
{
    if (!writer)
        return;
    sc_muxer_close(writer->muxer);
    sc_encoder_close(writer->encoder);
    sc_free(writer->path);
    sc_free(writer);
}

sc_status sc_video_writer_open(const sc_ctx *ctx, const char *path,
                               const sc_video_settings *settings, sc_video_writer **out)
{
    SC_OWN(sc_video_writer_close_at) sc_video_writer *writer = NULL;

    SC_PASS(SC_ZALLOC(ctx, 1, &writer));
    writer->gop_frames = sc_video_gop_frames(settings);
    SC_PASS(sc_text_copy(ctx, path, &writer->path));
    SC_PASS(sc_encoder_open(ctx, path, settings, &writer->encoder));
    SC_PASS(sc_muxer_open(ctx, path, settings, &writer->muxer));
    SC_HAND_OVER(writer, out);
    return SC_OK;
}
