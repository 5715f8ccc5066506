/* SPDX-License-Identifier: BSD-3-Clause */
/* Decodes a video, to check what was written. */
#include "internal.h"

#include <errno.h>

/* The state of decoding a video. sc_video_decode frees what is not borrowed; each may be NULL. */
typedef struct decoder {
    const sc_ctx *ctx;
    const char *path; /* borrowed, as is ctx */
    FILE *file;
    AVFormatContext *format; /* reads from file; NULL for animated WebP */
    sc_webp_reader webp;     /* reads from file then; libavformat does not */
    AVCodecContext *codec;
    AVStream *stream;     /* the video stream, borrowed from format; NULL as that */
    AVRational time_base; /* of the times of packets and frames, in seconds */
    AVFrame *frame;       /* decoded last */
    AVPacket *packet;
    int format_of_first;       /* pixel format of the first frame */
    struct SwsContext *scaler; /* made for the first frame, as is image */
    sc_image image;            /* frame as sRGB, with alpha if the video has it */
    int count;                 /* frames passed on so far */
} decoder;

/* Log what is wrong with the file. @return SC_ERR_DATA always. */
static sc_status fail_data(const decoder *d, const char *what)
{
    return sc_fail(d->ctx, SC_ERR_DATA, "%s: %s", d->path, what);
}

/* @return the decoder of a stream, or NULL. Of those for VP9 only that of libvpx gives alpha. */
static const AVCodec *find_decoder(const AVStream *stream)
{
    const AVDictionaryEntry *alpha = sc_av->av_dict_get(stream->metadata, "alpha_mode", NULL, 0);
    const AVCodec *libvpx = stream->codecpar->codec_id == AV_CODEC_ID_VP9 && alpha
                                ? sc_av->avcodec_find_decoder_by_name("libvpx-vp9")
                                : NULL;

    return libvpx ? libvpx : sc_av->avcodec_find_decoder(stream->codecpar->codec_id);
}

/* Find the best video stream of the file: sets format, stream and time_base. @return
 * SC_ERR_MISSING, SC_ERR_DATA, SC_ERR_MEMORY. */
static sc_status open_stream(decoder *d)
{
    int index, error;

    d->format = sc_input_begin(d->file);
    if (!d->format)
        return sc_fail(d->ctx, SC_ERR_MEMORY, "%s: there is no memory to read it", d->path);
    error = sc_input_open(&d->format, d->path);
    if (error < 0)
        return sc_av_fail(d->ctx, SC_ERR_MISSING, d->path, "cannot be opened as a video", error);
    if (sc_av->avformat_find_stream_info(d->format, NULL) < 0)
        return fail_data(d, "holds no stream that can be read");
    index = sc_av->av_find_best_stream(d->format, AVMEDIA_TYPE_VIDEO, -1, -1, NULL, 0);
    if (index < 0)
        return fail_data(d, "holds no video stream");
    d->stream = d->format->streams[index];
    d->time_base = d->stream->time_base;
    return SC_OK;
}

/* Open the file and the decoder of its best video stream: sets all members but scaler and
 * image. @return SC_ERR_MISSING, SC_ERR_DATA, SC_ERR_MEMORY; the caller frees what was opened. */
static sc_status open_decoder(decoder *d)
{
    const AVCodec *codec;

    d->file = fopen(d->path, "rb");
    if (!d->file)
        return sc_fail(d->ctx, SC_ERR_MISSING, "%s: cannot be opened: %s", d->path,
                       strerror(errno));
    if (sc_webp_open(&d->webp, d->file)) {
        d->time_base = (AVRational){1, 1000};
        codec = sc_av->avcodec_find_decoder(AV_CODEC_ID_WEBP);
    } else {

        SC_PASS(open_stream(d));
        codec = find_decoder(d->stream);
    }
    d->codec = codec ? sc_av->avcodec_alloc_context3(codec) : NULL;
    d->frame = sc_av->av_frame_alloc();
    d->packet = sc_av->av_packet_alloc();
    if (!d->codec || !d->frame || !d->packet ||
        (d->stream && sc_av->avcodec_parameters_to_context(d->codec, d->stream->codecpar) < 0) ||
        sc_av->avcodec_open2(d->codec, codec, NULL) < 0)
        return fail_data(d, "libavcodec cannot decode its codec");
    return SC_OK;
}

/* Read the next packet of any stream into d->packet. @param wanted whether it is of the video.
 * @return 0, or libav's code of the end or an error. */
static int read_packet(decoder *d, bool *wanted)
{
    const int error =
        d->stream ? sc_av->av_read_frame(d->format, d->packet) : sc_webp_read(&d->webp, d->packet);

    *wanted = error >= 0 && (!d->stream || d->packet->stream_index == d->stream->index);
    return error;
}

/* @return the colours of the frames for swscale: BT.709, but of WebP BT.601. */
static const int *coefficients_of(const decoder *d)
{
    return sc_av->sws_getCoefficients(d->stream ? SWS_CS_ITU709 : SWS_CS_ITU601);
}

/* Convert d->frame to d->image, which the first call makes in the size of the frame; all others
 * have this size. @return SC_ERR_MEMORY, SC_ERR_DATA. */
static sc_status to_rgb(decoder *d)
{
    const AVFrame *f = d->frame;
    const int *colors = coefficients_of(d);
    const AVPixFmtDescriptor *pixels = sc_av->av_pix_fmt_desc_get(f->format);
    /* A GIF here has no transparent pixels but those that stay as they were. */
    const bool alpha =
        pixels && (pixels->flags & AV_PIX_FMT_FLAG_ALPHA) && d->codec->codec_id != AV_CODEC_ID_GIF;
    uint8_t *planes[1];
    int stride[1];

    if (!d->scaler) {

        SC_PASS(sc_image_init_alpha(d->ctx, f->width, f->height, alpha, &d->image));
        d->scaler = sc_av->sws_getContext(f->width, f->height, f->format, f->width, f->height,
                                          alpha ? AV_PIX_FMT_RGBA : AV_PIX_FMT_RGB24,
                                          SWS_BICUBIC | SWS_ACCURATE_RND, NULL, NULL, NULL);
        if (!d->scaler)
            return fail_data(d, "its pixel format cannot be converted");
        sc_av->sws_setColorspaceDetails(d->scaler, colors, 0, colors, 1, 0, 1 << 16, 1 << 16);
        d->format_of_first = f->format;
    }
    if (f->width != d->image.width_px || f->height != d->image.height_px ||
        f->format != d->format_of_first)
        return fail_data(d, "a frame has another size or pixel format than the first");
    planes[0] = d->image.rgb;
    stride[0] = d->image.width_px * (int)sc_pixel_bytes(d->image.alpha);
    sc_av->sws_scale(d->scaler, (const uint8_t *const *)f->data, f->linesize, 0, f->height, planes,
                     stride);
    return SC_OK;
}

/* Pass all frames that the codec has ready to @p on_frame, and count them. @return the error of
 * @p on_frame or of to_rgb, or SC_ERR_DATA. */
static sc_status receive_frames(decoder *d, sc_video_frame_fn *on_frame, void *user)
{
    int error = 0;

    while ((error = sc_av->avcodec_receive_frame(d->codec, d->frame)) >= 0) {
        const double time_s = (double)d->frame->best_effort_timestamp * av_q2d(d->time_base);

        SC_PASS(to_rgb(d));
        SC_PASS(on_frame(user, d->count++, time_s, &d->image));
    }
    if (error != AVERROR(EAGAIN) && error != AVERROR_EOF)
        SC_PASS(fail_data(d, "a frame cannot be decoded"));
    return SC_OK;
}

/* Free what sc_video_decode and sc_video_pick have opened. */
static void close_decoder(decoder *d)
{
    if (!sc_av) /* it could not be loaded */
        return;
    sc_image_clear(&d->image);
    sc_av->sws_freeContext(d->scaler);
    sc_av->av_frame_free(&d->frame);
    sc_av->av_packet_free(&d->packet);
    sc_av->avcodec_free_context(&d->codec);
    sc_input_end(&d->format);
    if (d->file)
        fclose(d->file);
}

sc_status sc_video_decode(const sc_ctx *ctx, const char *path, sc_video_frame_fn *on_frame,
                          void *user)
{
    SC_OWN(close_decoder) decoder d = {.ctx = ctx, .path = path};
    bool wanted;
    int end;

    SC_PASS(sc_libav_load(ctx, path));
    SC_PASS(open_decoder(&d));
    while ((end = read_packet(&d, &wanted)) >= 0) {
        const bool cut = wanted && (d.packet->flags & AV_PKT_FLAG_CORRUPT);
        const int error = wanted ? sc_av->avcodec_send_packet(d.codec, d.packet) : 0;

        sc_av->av_packet_unref(d.packet);
        if (error < 0 || cut)
            return fail_data(&d, cut ? "a frame is cut off" : "a frame cannot be decoded");
        SC_PASS(receive_frames(&d, on_frame, user));
    }
    if (end != AVERROR_EOF)
        return fail_data(&d, "cannot be read to its end");
    sc_av->avcodec_send_packet(d.codec, NULL);
    return receive_frames(&d, on_frame, user);
}

/* ---- single frames ---- */

/* Seek to the GOP in which a frame is; in WebP, whose frames are all decoded, to the first. */
static sc_status seek(decoder *d, int fps, int frame)
{
    const int64_t time = sc_av->av_rescale_q(frame, (AVRational){1, fps}, d->time_base);

    if (!d->stream) {
        sc_webp_rewind(&d->webp);
        sc_av->avcodec_flush_buffers(d->codec);
        return SC_OK;
    }
    if (sc_av->av_seek_frame(d->format, d->stream->index, time, AVSEEK_FLAG_BACKWARD) < 0)
        return fail_data(d, "cannot be read from a frame in the middle on");
    sc_av->avcodec_flush_buffers(d->codec);
    return SC_OK;
}

/* Decode the next frame into d->frame. @param number its number, or -1 behind the last one.
 * @return SC_ERR_DATA. */
static sc_status next_frame(decoder *d, int fps, int *number)
{
    bool wanted;
    int error;

    while ((error = sc_av->avcodec_receive_frame(d->codec, d->frame)) == AVERROR(EAGAIN)) {
        if (read_packet(d, &wanted) < 0) {
            sc_av->avcodec_send_packet(d->codec, NULL); /* so that it gives what it still holds */
            continue;
        }
        error = wanted ? sc_av->avcodec_send_packet(d->codec, d->packet) : 0;
        sc_av->av_packet_unref(d->packet);
        if (error < 0)
            return fail_data(d, "a frame cannot be decoded");
    }
    *number = -1;
    if (error == AVERROR_EOF)
        return SC_OK;
    if (error < 0)
        return fail_data(d, "a frame cannot be decoded");
    *number = (int)sc_av->av_rescale_q(d->frame->best_effort_timestamp, d->time_base,
                                       (AVRational){1, fps});
    return SC_OK;
}

sc_status sc_video_pick(const sc_ctx *ctx, const char *path, int fps, const int *frames, int count,
                        sc_video_frame_fn *on_frame, void *user)
{
    SC_OWN(close_decoder) decoder d = {.ctx = ctx, .path = path};
    int at = -1; /* number of the frame in d.frame; -1: none */

    SC_PASS(sc_libav_load(ctx, path));
    SC_PASS(open_decoder(&d));
    for (int i = 0; i < count; i++) {
        /* The frames of a GIF are changes of those before them. */
        const bool can_skip = d.codec->codec_id != AV_CODEC_ID_GIF || at >= frames[i];

        if (can_skip && (at < 0 || frames[i] - at > fps)) {
            SC_PASS(seek(&d, fps, frames[i]));
            at = -1;
        }
        do
            SC_PASS(next_frame(&d, fps, &at));
        while (at >= 0 && at < frames[i]);
        if (at < 0)
            continue; /* it is not there, nor are those that follow */
        SC_PASS(to_rgb(&d));
        SC_PASS(on_frame(user, at, (double)at / fps, &d.image));
    }
    return SC_OK;
}
