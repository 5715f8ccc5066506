/* SPDX-License-Identifier: BSD-3-Clause */
/* Video files by libav. Settings that decide whether a video plays everywhere, with its colours,
 * stand in fill_codec() and open_scaler(). */
#include "sink_ops.h"

#include <errno.h>
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/cpu.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

/* x264's bytes depend on its number of threads: fixed, so that every machine writes the same. */
enum { ENCODER_THREADS = 2 };

typedef struct container {
    const char *ending, *muxer, *encoder;
    enum AVCodecID codec;
} container;

static const container containers[] = {
    {".mp4", "mp4", "libx264", AV_CODEC_ID_H264},
    {".mkv", "matroska", "libx264", AV_CODEC_ID_H264},
    {".webm", "webm", "libvpx-vp9", AV_CODEC_ID_VP9},
};

typedef struct video_sink {
    sc_sink base;
    char *path, *temporary;
    bool finished;
    int64_t frames;
    AVFormatContext *format;
    AVCodecContext *codec;
    AVStream *stream;
    AVFrame *frame;
    AVPacket *packet;
    struct SwsContext *scaler;
    sc_image padded; /* the picture with even sides */
} video_sink;

static const container *find_container(const char *path)
{
    const char *dot = strrchr(path, '.');

    for (size_t i = 0; dot && i < SC_COUNT_OF(containers); i++) {
        if (!strcasecmp(dot, containers[i].ending))
            return &containers[i];
    }
    return NULL;
}

bool sc_video_name_ok(const char *path)
{
    return find_container(path) != NULL;
}

void sc_video_libraries(char *text, size_t size)
{
    const unsigned format = avformat_version(), codec = avcodec_version();

    snprintf(text, size, "libavformat %u.%u.%u, libavcodec %u.%u.%u", format >> 16,
             format >> 8 & 255, format & 255, codec >> 16, codec >> 8 & 255, codec & 255);
}

static sc_status av_failed(const sc_ctx *ctx, sc_status status, const char *path, const char *what,
                           int error)
{
    char reason[128] = "unknown";

    av_strerror(error, reason, sizeof reason);
    return sc_fail(ctx, status, "%s: %s: %s", path, what, reason);
}

/* x264 r3095's macroblock tree reads beyond a row in its AVX-512 code, unless the picture's width
 * is a multiple of 256: what the bytes of a video are then depends on what the heap held. Its AVX2
 * code does not; every CPU with AVX-512 has that. (Found and shown with MALLOC_PERTURB_.) */
static void avoid_unsteady_code(AVCodecContext *codec)
{
    if (av_get_cpu_flags() & AV_CPU_FLAG_AVX512)
        av_opt_set(codec->priv_data, "x264-params", "asm=avx2", 0);
}

static void fill_codec(AVCodecContext *codec, const sc_video_settings *settings,
                       const AVOutputFormat *muxer)
{
    codec->width = (settings->width_px + 1) & ~1;
    codec->height = (settings->height_px + 1) & ~1;
    codec->pix_fmt = AV_PIX_FMT_YUV420P;
    codec->time_base = (AVRational){1, settings->fps};
    codec->framerate = (AVRational){settings->fps, 1};
    codec->sample_aspect_ratio = (AVRational){1, 1};
    codec->gop_size = settings->fps;
    codec->color_primaries = AVCOL_PRI_BT709;
    codec->color_trc = AVCOL_TRC_BT709;
    codec->colorspace = AVCOL_SPC_BT709;
    codec->color_range = AVCOL_RANGE_MPEG;
    codec->chroma_sample_location = AVCHROMA_LOC_LEFT;
    codec->thread_count = ENCODER_THREADS;
    codec->flags |= AV_CODEC_FLAG_CLOSED_GOP | AV_CODEC_FLAG_BITEXACT;
    if (muxer->flags & AVFMT_GLOBALHEADER)
        codec->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    av_opt_set_int(codec->priv_data, "crf", settings->crf, 0);
    if (codec->codec_id == AV_CODEC_ID_H264) {
        av_opt_set(codec->priv_data, "preset", settings->preset, 0);
        av_opt_set(codec->priv_data, "profile", "high", 0);
        avoid_unsteady_code(codec);
    } else {
        codec->bit_rate = 0; /* constant quality */
        av_opt_set(codec->priv_data, "deadline", "good", 0);
        av_opt_set_int(codec->priv_data, "cpu-used", 4, 0);
    }
}

static sc_status open_codec(const sc_ctx *ctx, video_sink *sink, const container *kind,
                            const sc_video_settings *settings)
{
    const AVCodec *encoder = avcodec_find_encoder_by_name(kind->encoder);
    int error;

    if (!encoder)
        return sc_fail(ctx, SC_ERR_CREATE,
                       "%s: this libavcodec has no encoder %s; choose another kind of video, or "
                       "frames: png",
                       sink->path, kind->encoder);
    sink->codec = avcodec_alloc_context3(encoder);
    sink->stream = avformat_new_stream(sink->format, NULL);
    if (!sink->codec || !sink->stream)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", sink->path);
    fill_codec(sink->codec, settings, sink->format->oformat);
    error = avcodec_open2(sink->codec, encoder, NULL);
    if (error < 0)
        return av_failed(ctx, SC_ERR_CREATE, sink->path, "the encoder cannot be opened", error);
    sink->stream->time_base = sink->codec->time_base;
    sink->stream->avg_frame_rate = sink->codec->framerate;
    if (avcodec_parameters_from_context(sink->stream->codecpar, sink->codec) < 0)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", sink->path);
    return SC_OK;
}

/* RGB to bt709, limited range; swscale would take BT.601. */
static sc_status open_scaler(const sc_ctx *ctx, video_sink *sink)
{
    const int width = sink->codec->width, height = sink->codec->height;
    const int *bt709 = sws_getCoefficients(SWS_CS_ITU709);

    sink->scaler = sws_getContext(
        width, height, AV_PIX_FMT_RGB24, width, height, AV_PIX_FMT_YUV420P,
        SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INP | SWS_BITEXACT, NULL, NULL, NULL);
    sink->frame = av_frame_alloc();
    sink->packet = av_packet_alloc();
    if (!sink->scaler || !sink->frame || !sink->packet ||
        sws_setColorspaceDetails(sink->scaler, bt709, 1, bt709, 0, 0, 1 << 16, 1 << 16) < 0)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", sink->path);
    sink->frame->format = AV_PIX_FMT_YUV420P;
    sink->frame->width = width;
    sink->frame->height = height;
    sink->frame->colorspace = AVCOL_SPC_BT709;
    sink->frame->color_range = AVCOL_RANGE_MPEG;
    sink->frame->color_primaries = AVCOL_PRI_BT709;
    sink->frame->color_trc = AVCOL_TRC_BT709;
    if (av_frame_get_buffer(sink->frame, 0) < 0)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", sink->path);
    return sc_image_init(ctx, width, height, &sink->padded);
}

static sc_status open_file(const sc_ctx *ctx, video_sink *sink)
{
    AVDictionary *options = NULL;
    int error = avio_open(&sink->format->pb, sink->temporary, AVIO_FLAG_WRITE);

    if (error < 0)
        return av_failed(ctx, SC_ERR_CREATE, sink->path, "cannot be created", error);
    sink->format->flags |= AVFMT_FLAG_BITEXACT;
    av_dict_set(&options, "movflags", "+faststart", 0);
    error = avformat_write_header(sink->format, &options);
    av_dict_free(&options);
    if (error < 0)
        return av_failed(ctx, SC_ERR_CREATE, sink->path, "cannot be created", error);
    return SC_OK;
}

/* Write what the encoder has ready. */
static sc_status drain(const sc_ctx *ctx, video_sink *sink)
{
    for (;;) {
        int error = avcodec_receive_packet(sink->codec, sink->packet);

        if (error == AVERROR(EAGAIN) || error == AVERROR_EOF)
            return SC_OK;
        if (error >= 0) {
            sink->packet->stream_index = sink->stream->index;
            sink->packet->duration = 1;
            av_packet_rescale_ts(sink->packet, sink->codec->time_base, sink->stream->time_base);
            error = av_interleaved_write_frame(sink->format, sink->packet);
        }
        if (error >= 0 && sink->format->pb->error < 0)
            error = sink->format->pb->error;
        if (error < 0)
            return av_failed(ctx, SC_ERR_WRITE, sink->path, "cannot be written", error);
    }
}

/* Copy with the last column and row doubled where a side is odd. */
static void pad(const sc_image *image, sc_image *padded)
{
    const size_t from = (size_t)image->width_px * 3, to = (size_t)padded->width_px * 3;

    for (int y = 0; y < padded->height_px; y++) {
        const int source = y < image->height_px ? y : image->height_px - 1;
        uint8_t *row = padded->rgb + (size_t)y * to;

        memcpy(row, image->rgb + (size_t)source * from, from);
        if (to > from)
            memcpy(row + from, row + from - 3, 3);
    }
}

static sc_status video_push(const sc_ctx *ctx, sc_sink *base, int k, const sc_image *image)
{
    video_sink *sink = (video_sink *)base;
    const uint8_t *planes[1] = {sink->padded.rgb};
    const int stride[1] = {sink->padded.width_px * 3};
    int error;

    (void)k; /* frames come in order; a slice of an animation begins at time 0 */
    if (av_frame_make_writable(sink->frame) < 0)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", sink->path);
    pad(image, &sink->padded);
    sws_scale(sink->scaler, planes, stride, 0, sink->padded.height_px, sink->frame->data,
              sink->frame->linesize);
    sink->frame->pts = sink->frames++;
    error = avcodec_send_frame(sink->codec, sink->frame);
    if (error < 0)
        return av_failed(ctx, SC_ERR_INTERNAL, sink->path, "cannot be encoded", error);
    return drain(ctx, sink);
}

static sc_status video_finish(const sc_ctx *ctx, sc_sink *base, bool complete)
{
    video_sink *sink = (video_sink *)base;
    const char *dot = strrchr(sink->path, '.');
    int error = avcodec_send_frame(sink->codec, NULL);
    sc_text partial = {0};
    sc_status status;

    if (error < 0)
        return av_failed(ctx, SC_ERR_INTERNAL, sink->path, "cannot be encoded", error);
    SC_TRY(drain(ctx, sink));
    error = av_write_trailer(sink->format);
    if (error >= 0)
        error = avio_closep(&sink->format->pb);
    if (error < 0) {
        status = av_failed(ctx, SC_ERR_WRITE, sink->path, "cannot be written", error);
        goto out;
    }
    SC_TRY(sc_text_add(ctx, &partial, "%.*s.partial%s", (int)(dot - sink->path), sink->path, dot));
    SC_TRY(sc_file_publish(ctx, sink->temporary, complete ? sink->path : partial.data));
    sink->finished = true;
out:
    sc_text_clear(&partial);
    return status;
}

static void video_close(sc_sink *base)
{
    video_sink *sink = (video_sink *)base;

    if (sink->format && sink->format->pb)
        avio_closep(&sink->format->pb);
    if (sink->temporary && !sink->finished)
        unlink(sink->temporary);
    avcodec_free_context(&sink->codec);
    avformat_free_context(sink->format);
    av_frame_free(&sink->frame);
    av_packet_free(&sink->packet);
    sws_freeContext(sink->scaler);
    sc_image_clear(&sink->padded);
    sc_free(sink->path);
    sc_free(sink->temporary);
    sc_free(sink);
}

static const sc_sink_ops video_ops = {
    .push = video_push, .finish = video_finish, .close = video_close};

sc_status sc_sink_open_video(const sc_ctx *ctx, const char *path, const sc_video_settings *settings,
                             sc_sink **out)
{
    const container *kind = find_container(path);
    video_sink *sink = NULL;
    sc_text copy = {0};
    void *block = NULL;
    sc_status status;

    if (!kind)
        return sc_fail(ctx, SC_ERR_USAGE, "%s: a video ends in .mp4, .mkv or .webm", path);
    av_log_set_level(AV_LOG_FATAL); /* errors are told by us, once */
    SC_TRY(sc_zalloc(ctx, 1, sizeof *sink, &block));
    sink = block;
    sink->base.ops = &video_ops;
    SC_TRY(sc_text_add(ctx, &copy, "%s", path));
    sink->path = copy.data;
    SC_TRY(sc_temporary_name(ctx, path, &sink->temporary));
    if (avformat_alloc_output_context2(&sink->format, NULL, kind->muxer, sink->temporary) < 0) {
        status =
            sc_fail(ctx, SC_ERR_CREATE, "%s: this libavformat cannot write %s", path, kind->muxer);
        goto out;
    }
    SC_TRY(open_codec(ctx, sink, kind, settings));
    SC_TRY(open_scaler(ctx, sink));
    SC_TRY(open_file(ctx, sink));
    *out = &sink->base;
    return SC_OK;
out:
    if (sink)
        video_close(&sink->base);
    return status;
}
