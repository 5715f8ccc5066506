/* SPDX-License-Identifier: BSD-3-Clause */
/* Pictures to packets by libav, one closed group of pictures after the other. Every group has an
 * encoder of its own: its bytes depend on its pictures alone, whoever encodes it and whenever.
 * Settings that decide whether a video plays everywhere, with its colours, stand in fill_codec()
 * and open_scaler(). */
#include "internal.h"

#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/cpu.h>
#include <libavutil/imgutils.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
#include <string.h>
#include <strings.h>

/* x264's bytes depend on its number of threads: fixed, so that every machine writes the same. */
enum { ENCODER_THREADS = 2 };

static const sc_container containers[] = {
    {".mp4", "mp4", "libx264", AV_CODEC_ID_H264, true},
    {".mkv", "matroska", "libx264", AV_CODEC_ID_H264, true},
    {".webm", "webm", "libvpx-vp9", AV_CODEC_ID_VP9, false},
};

struct sc_encoder {
    char *name; /* of the video, for messages */
    const sc_container *kind;
    sc_video_settings settings;
    AVCodecContext *codec; /* of the group in work, or NULL */
    AVFrame *frame;        /* for the encoder, which may hold on to it */
    AVFrame *converted;    /* by swscale, which writes beyond the ends of unaligned rows */
    AVPacket *packet;
    struct SwsContext *scaler;
    sc_image padded; /* the picture with even sides */
    uint8_t *yuv;    /* the last one converted, planes tightly packed */
    sc_segment_builder segment;
};

const sc_container *sc_container_find(const char *path)
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
    return sc_container_find(path) != NULL;
}

void sc_video_libraries(char *text, size_t size)
{
    const unsigned format = avformat_version(), codec = avcodec_version();

    snprintf(text, size, "libavformat %u.%u.%u, libavcodec %u.%u.%u", format >> 16,
             format >> 8 & 255, format & 255, codec >> 16, codec >> 8 & 255, codec & 255);
}

sc_status sc_av_failed(const sc_ctx *ctx, sc_status status, const char *path, const char *what,
                       int error)
{
    char reason[128] = "unknown";

    av_strerror(error, reason, sizeof reason);
    return sc_fail(ctx, status, "%s: %s: %s", path, what, reason);
}

/* x264 r3095's macroblock tree reads memory that nobody wrote in its AVX-512 code, at some sizes
 * (seen at 192 x 120 and 320 x 180): what the bytes of a video are then depends on what the heap
 * held. Its AVX2 code does not; every CPU with AVX-512 has that. (Found and shown with
 * MALLOC_PERTURB_.) */
static void avoid_unsteady_code(AVCodecContext *codec)
{
    if (av_get_cpu_flags() & AV_CPU_FLAG_AVX512)
        av_opt_set(codec->priv_data, "x264-params", "asm=avx2", 0);
}

static void fill_codec(AVCodecContext *codec, const sc_video_settings *settings,
                       const sc_container *kind)
{
    codec->width = (settings->width_px + 1) & ~1;
    codec->height = (settings->height_px + 1) & ~1;
    codec->pix_fmt = AV_PIX_FMT_YUV420P;
    codec->time_base = (AVRational){1, settings->fps};
    codec->framerate = (AVRational){settings->fps, 1};
    codec->sample_aspect_ratio = (AVRational){1, 1};
    codec->gop_size = sc_video_group(settings);
    codec->color_primaries = AVCOL_PRI_BT709;
    codec->color_trc = AVCOL_TRC_BT709;
    codec->colorspace = AVCOL_SPC_BT709;
    codec->color_range = AVCOL_RANGE_MPEG;
    codec->chroma_sample_location = AVCHROMA_LOC_LEFT;
    codec->thread_count = ENCODER_THREADS;
    codec->flags |= AV_CODEC_FLAG_CLOSED_GOP | AV_CODEC_FLAG_BITEXACT;
    if (kind->global_header)
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

static sc_status open_codec(const sc_ctx *ctx, sc_encoder *e)
{
    const AVCodec *codec = avcodec_find_encoder_by_name(e->kind->encoder);
    int error;

    if (!codec)
        return sc_fail(ctx, SC_ERR_CREATE,
                       "%s: this libavcodec has no encoder %s; choose another kind of video, or "
                       "frames: png",
                       e->name, e->kind->encoder);
    e->codec = avcodec_alloc_context3(codec);
    if (!e->codec)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", e->name);
    fill_codec(e->codec, &e->settings, e->kind);
    error = avcodec_open2(e->codec, codec, NULL);
    if (error < 0)
        return sc_av_failed(ctx, SC_ERR_CREATE, e->name, "the encoder cannot be opened", error);
    return SC_OK;
}

/* RGB to bt709, limited range; swscale would take BT.601. */
static sc_status open_scaler(const sc_ctx *ctx, sc_encoder *e)
{
    const int width = e->padded.width_px, height = e->padded.height_px;
    const int *bt709 = sws_getCoefficients(SWS_CS_ITU709);

    e->scaler = sws_getContext(width, height, AV_PIX_FMT_RGB24, width, height, AV_PIX_FMT_YUV420P,
                               SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INP | SWS_BITEXACT,
                               NULL, NULL, NULL);
    e->converted = av_frame_alloc();
    e->frame = av_frame_alloc();
    e->packet = av_packet_alloc();
    if (!e->scaler || !e->frame || !e->converted || !e->packet ||
        sws_setColorspaceDetails(e->scaler, bt709, 1, bt709, 0, 0, 1 << 16, 1 << 16) < 0)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", e->name);
    e->frame->format = AV_PIX_FMT_YUV420P;
    e->frame->width = width;
    e->frame->height = height;
    e->frame->colorspace = AVCOL_SPC_BT709;
    e->frame->color_range = AVCOL_RANGE_MPEG;
    e->frame->color_primaries = AVCOL_PRI_BT709;
    e->frame->color_trc = AVCOL_TRC_BT709;
    e->converted->format = e->frame->format;
    e->converted->width = width;
    e->converted->height = height;
    if (av_frame_get_buffer(e->frame, 0) < 0 || av_frame_get_buffer(e->converted, 0) < 0)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", e->name);
    return SC_OK;
}

sc_status sc_encoder_open(const sc_ctx *ctx, const char *video, const sc_video_settings *settings,
                          sc_encoder **out)
{
    const sc_container *kind = sc_container_find(video);
    sc_encoder *e = NULL;
    sc_text name = {0};
    void *block = NULL;
    sc_status status;

    if (!kind)
        return sc_fail(ctx, SC_ERR_USAGE, "%s: a video ends in .mp4, .mkv or .webm", video);
    av_log_set_level(AV_LOG_FATAL); /* errors are told by us, once */
    SC_TRY(sc_zalloc(ctx, 1, sizeof *e, &block));
    e = block;
    e->kind = kind;
    e->settings = *settings;
    SC_TRY(sc_text_add(ctx, &name, "%s", video));
    e->name = name.data;
    SC_TRY(sc_image_init(ctx, (settings->width_px + 1) & ~1, (settings->height_px + 1) & ~1,
                         &e->padded));
    SC_TRY(sc_alloc(ctx, sc_picture_bytes(settings), 1, &block));
    e->yuv = block;
    SC_TRY(open_scaler(ctx, e));
    SC_TRY(open_codec(ctx, e)); /* an encoder that is not there is told of before the work */
    *out = e;
    return SC_OK;
out:
    sc_encoder_close(e);
    return status;
}

size_t sc_picture_bytes(const sc_video_settings *settings)
{
    const size_t width = (size_t)(settings->width_px + 1) / 2;
    const size_t height = (size_t)(settings->height_px + 1) / 2;

    return width * height * 6;
}

int sc_video_group(const sc_video_settings *settings)
{
    return settings->fps;
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

/* Where the planes of a tightly packed picture lie. */
static void find_planes(const sc_encoder *e, uint8_t *yuv, uint8_t *planes[4], int strides[4])
{
    av_image_fill_arrays(planes, strides, yuv, AV_PIX_FMT_YUV420P, e->padded.width_px,
                         e->padded.height_px, 1);
}

const void *sc_encoder_convert(sc_encoder *e, const sc_image *image)
{
    const uint8_t *from[1] = {e->padded.rgb};
    const int stride[1] = {e->padded.width_px * 3};
    uint8_t *planes[4];
    int strides[4];

    pad(image, &e->padded);
    sws_scale(e->scaler, from, stride, 0, e->padded.height_px, e->converted->data,
              e->converted->linesize);
    find_planes(e, e->yuv, planes, strides);
    av_image_copy(planes, strides, (const uint8_t **)e->converted->data, e->converted->linesize,
                  AV_PIX_FMT_YUV420P, e->padded.width_px, e->padded.height_px);
    return e->yuv;
}

/* Keep what the encoder has ready. */
static sc_status drain(const sc_ctx *ctx, sc_encoder *e)
{
    for (;;) {
        const int error = avcodec_receive_packet(e->codec, e->packet);
        sc_status status;

        if (error == AVERROR(EAGAIN) || error == AVERROR_EOF)
            return SC_OK;
        if (error < 0)
            return sc_av_failed(ctx, SC_ERR_INTERNAL, e->name, "cannot be encoded", error);
        status = sc_segment_add(ctx, &e->segment, e->packet);
        av_packet_unref(e->packet);
        if (status != SC_OK)
            return status;
    }
}

sc_status sc_encoder_push(const sc_ctx *ctx, sc_encoder *e, const void *picture, uint64_t hash)
{
    uint8_t *planes[4];
    int strides[4], error;
    sc_status status;

    if (!e->codec)
        SC_TRY(open_codec(ctx, e));
    SC_TRY(sc_segment_note(ctx, &e->segment, hash));
    if (av_frame_make_writable(e->frame) < 0) {
        status = sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", e->name);
        goto out;
    }
    find_planes(e, (uint8_t *)(uintptr_t)picture, planes, strides);
    av_image_copy(e->frame->data, e->frame->linesize, (const uint8_t **)planes, strides,
                  AV_PIX_FMT_YUV420P, e->padded.width_px, e->padded.height_px);
    e->frame->pts = e->segment.frames - 1;
    error = avcodec_send_frame(e->codec, e->frame);
    status = error < 0 ? sc_av_failed(ctx, SC_ERR_INTERNAL, e->name, "cannot be encoded", error)
                       : drain(ctx, e);
out:
    return status;
}

int sc_encoder_count(const sc_encoder *e)
{
    return e->segment.frames;
}

sc_status sc_encoder_finish(const sc_ctx *ctx, sc_encoder *e, uint64_t identity, int first_frame,
                            sc_segment *out)
{
    sc_status status;
    const int error = avcodec_send_frame(e->codec, NULL);

    if (error < 0)
        return sc_av_failed(ctx, SC_ERR_INTERNAL, e->name, "cannot be encoded", error);
    SC_TRY(drain(ctx, e));
    SC_TRY(sc_segment_build(ctx, &e->segment, e->codec, e->name, identity, first_frame, out));
out:
    sc_encoder_drop(e);
    return status;
}

void sc_encoder_drop(sc_encoder *e)
{
    avcodec_free_context(&e->codec);
    sc_segment_reset(&e->segment);
}

void sc_encoder_close(sc_encoder *e)
{
    if (!e)
        return;
    avcodec_free_context(&e->codec);
    av_frame_free(&e->frame);
    av_frame_free(&e->converted);
    av_packet_free(&e->packet);
    sws_freeContext(e->scaler);
    sc_segment_clear(&e->segment);
    sc_image_clear(&e->padded);
    sc_free(e->yuv);
    sc_free(e->name);
    sc_free(e);
}
