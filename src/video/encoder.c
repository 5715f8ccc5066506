/* SPDX-License-Identifier: BSD-3-Clause */
/* Encodes pictures to packets with libav, one closed GOP after the other. Every GOP is encoded by a
 * codec context of its own, so its bytes depend on its pictures alone, not on who encodes it, or
 * when. fill_codec() and open_scaler() hold the settings with which a video plays in all players
 * and has the right colours. */
#include "internal.h"

#include <errno.h>

/* The bytes that x264 writes depend on its number of threads. Therefore this number is the same on
 * every machine. */
enum { ENCODER_THREADS = 2 };

struct sc_encoder {
    char *name; /* the file name of the video, for messages */
    const sc_container *container;
    sc_video_settings settings; /* texts borrowed from the caller */
    AVCodecContext *codec;      /* made anew for each GOP; NULL between two GOPs */
    AVFrame *frame;             /* what is given to the codec, which may keep a reference to it */
    AVFrame *converted; /* where swscale writes. Its rows are aligned, because swscale writes
                           beyond the ends of rows that are not. */
    AVPacket *packet;
    struct SwsContext *scaler;
    enum AVPixelFormat pixels;  /* of frame and converted */
    sc_image padded;            /* the frame, padded to even sides */
    uint8_t *yuv;               /* the result of sc_encoder_convert */
    sc_segment_builder segment; /* packets and hashes of the GOP that is being encoded */
};

/* The AVX-512 code of x264 r3095 (macroblock tree) reads uninitialised memory at some frame sizes,
 * for example 192 x 120 and 320 x 180, so that the bytes of a video depend on what the heap held
 * before. Therefore its AVX2 code is used instead. test_video.c detects the error by filling fresh
 * memory with different bytes (M_PERTURB). */
static int avoid_x264_avx512(AVCodecContext *codec)
{
    return sc_av->av_get_cpu_flags() & AV_CPU_FLAG_AVX512
               ? sc_av->av_opt_set(codec->priv_data, "x264-params", "asm=avx2", 0)
               : 0;
}

/* x265 orders its pictures by up to this many, with B frames as references of others. libavcodec
 * does not tell. */
enum { X265_REORDER = 2 };

/* What x265 is told beyond its preset: nothing in the stream about x265 itself; GOPs that end by
 * themselves; one thread, since what it writes depends on their number; and B frames in the order
 * of X265_REORDER, whatever the preset says. */
#define X265_PARAMETERS                                                                            \
    "log-level=none:info=0:open-gop=0:pools=none:frame-threads=1:wpp=0:b-pyramid=1:bframes=4:"     \
    "repeat-headers=0"

/* Set quality and speed of an encoder by crf. @return 0, or libav's code of an error. */
static int choose_quality(AVCodecContext *codec, const sc_video_settings *settings)
{
    void *const own = codec->priv_data;
    int error = codec->codec_id == AV_CODEC_ID_HEVC
                    ? sc_av->av_opt_set_double(own, "crf", settings->crf, 0)
                    : sc_av->av_opt_set_int(own, "crf", settings->crf, 0);

    switch (codec->codec_id) {
    case AV_CODEC_ID_H264:
        error = error < 0 ? error : sc_av->av_opt_set(own, "preset", settings->preset, 0);
        error = error < 0 ? error : sc_av->av_opt_set(own, "profile", "high", 0);
        return error < 0 ? error : avoid_x264_avx512(codec);
    case AV_CODEC_ID_HEVC:
        error = error < 0 ? error : sc_av->av_opt_set(own, "preset", settings->preset, 0);
        return error < 0 ? error : sc_av->av_opt_set(own, "x265-params", X265_PARAMETERS, 0);
    case AV_CODEC_ID_AV1:
        codec->thread_count = 1;
        error = error < 0 ? error : sc_av->av_opt_set_int(own, "cpu-used", 6, 0);
        return error < 0 ? error : sc_av->av_opt_set_int(own, "row-mt", 0, 0);
    default:                 /* VP9 */
        codec->bit_rate = 0; /* 0 selects constant quality, by crf */
        error = error < 0 ? error : sc_av->av_opt_set(own, "deadline", "good", 0);
        /* Colours and alpha are encoded apart, and one packet of each is needed for each frame. */
        if (error >= 0 && settings->alpha)
            error = sc_av->av_opt_set_int(own, "auto-alt-ref", 0, 0);
        return error < 0 ? error : sc_av->av_opt_set_int(own, "cpu-used", 4, 0);
    }
}

/* Set the quality of WebP, which has no crf but a quality from 0 to 100: 100 for 1, 88 for 18, 0
 * for
 * 51. 0 loses nothing. @return 0, or libav's code of an error. */
static int choose_webp(AVCodecContext *codec, const sc_video_settings *settings)
{
    const double quality = 100 - settings->crf * settings->crf / (51.0 * 51.0 / 100);

    codec->thread_count = 1;
    return settings->crf == 0 ? sc_av->av_opt_set_int(codec->priv_data, "lossless", 1, 0)
                              : sc_av->av_opt_set_double(codec->priv_data, "quality", quality, 0);
}

/* Set all settings of @p codec, which is allocated for the container's encoder and not yet
 * open. An odd side is rounded up to an even one. @return 0, or libav's code of an error: a video
 * without one of the settings would have other bytes. */
static int fill_codec(AVCodecContext *codec, const sc_video_settings *settings,
                      const sc_container *container)
{
    int error;

    codec->width = (settings->width_px + 1) & ~1;
    codec->height = (settings->height_px + 1) & ~1;
    codec->pix_fmt = sc_container_pixels(container, settings->alpha);
    codec->time_base = (AVRational){1, settings->fps};
    codec->framerate = (AVRational){settings->fps, 1};
    codec->sample_aspect_ratio = (AVRational){1, 1};
    codec->gop_size = sc_video_gop_frames(settings);
    codec->color_primaries = AVCOL_PRI_BT709;
    codec->color_trc = AVCOL_TRC_BT709;
    codec->colorspace = AVCOL_SPC_BT709;
    codec->color_range = AVCOL_RANGE_MPEG;
    codec->chroma_sample_location = AVCHROMA_LOC_LEFT;
    codec->thread_count = ENCODER_THREADS;
    codec->flags |= AV_CODEC_FLAG_CLOSED_GOP | AV_CODEC_FLAG_BITEXACT;
    if (container->global_header)
        codec->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    if (codec->codec_id == AV_CODEC_ID_PRORES) {
        codec->thread_type = FF_THREAD_SLICE;
        error = sc_av->av_opt_set(codec->priv_data, "profile", "4444", 0);
        return error < 0 ? error
                         : sc_av->av_opt_set_int(codec->priv_data, "alpha_bits",
                                                 settings->alpha ? 16 : 0, 0);
    }
    if (codec->codec_id == AV_CODEC_ID_FFV1) {
        codec->thread_count = 1;
        codec->gop_size = 1; /* every frame by itself */
        codec->level = 1;    /* the version of FFV1: with the head in the frames */
        return 0;
    }
    return codec->codec_id == AV_CODEC_ID_WEBP ? choose_webp(codec, settings)
                                               : choose_quality(codec, settings);
}

/* Make and open e->codec for the next GOP. @return SC_ERR_CREATE, SC_ERR_MEMORY; e->codec may
 * be allocated then, and sc_encoder_drop frees it. */
static sc_status open_codec(const sc_ctx *ctx, sc_encoder *e)
{
    const AVCodec *codec = sc_av->avcodec_find_encoder_by_name(e->container->encoder);
    int error;

    SC_PASS(sc_video_check_encoder(ctx, e->name, e->settings.codec));
    e->codec = sc_av->avcodec_alloc_context3(codec);
    if (!e->codec)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", e->name);
    error = fill_codec(e->codec, &e->settings, e->container);
    errno = 0;
    if (error >= 0)
        error = sc_av_error(sc_av->avcodec_open2(e->codec, codec, NULL));
    if (error < 0)
        return sc_av_fail(ctx, SC_ERR_CREATE, e->name, "the encoder cannot be opened", error);
    if (e->codec->codec_id == AV_CODEC_ID_HEVC)
        e->codec->has_b_frames = X265_REORDER;
    /* libavcodec does not notice that x264 found no memory for the headers. Those of AV1 come with
     * the first packet. */
    if (e->container->global_header && e->codec->codec_id != AV_CODEC_ID_AV1 &&
        e->codec->extradata_size <= 0)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", e->name);
    return SC_OK;
}

/* Make e->scaler, frame, converted and packet; e->padded has its size already. The conversion
 * is set to BT.709 of limited range, since the default of swscale is BT.601. @return
 * SC_ERR_MEMORY; sc_encoder_close frees what was made. */
static sc_status open_scaler(const sc_ctx *ctx, sc_encoder *e)
{
    const int width = e->padded.width_px, height = e->padded.height_px;
    const int *bt709 = sc_av->sws_getCoefficients(SWS_CS_ITU709);

    e->pixels = sc_container_pixels(e->container, e->settings.alpha);
    e->scaler = sc_av->sws_getContext(
        width, height, e->settings.alpha ? AV_PIX_FMT_RGBA : AV_PIX_FMT_RGB24, width, height,
        e->pixels, SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INP | SWS_BITEXACT, NULL, NULL,
        NULL);
    e->converted = sc_av->av_frame_alloc();
    e->frame = sc_av->av_frame_alloc();
    e->packet = sc_av->av_packet_alloc();
    if (!e->scaler || !e->frame || !e->converted || !e->packet ||
        sc_av->sws_setColorspaceDetails(e->scaler, bt709, 1, bt709, 0, 0, 1 << 16, 1 << 16) < 0)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", e->name);
    e->frame->format = e->pixels;
    e->frame->width = width;
    e->frame->height = height;
    e->frame->colorspace = AVCOL_SPC_BT709;
    e->frame->color_range = AVCOL_RANGE_MPEG;
    e->frame->color_primaries = AVCOL_PRI_BT709;
    e->frame->color_trc = AVCOL_TRC_BT709;
    e->converted->format = e->frame->format;
    e->converted->width = width;
    e->converted->height = height;
    if (sc_av->av_frame_get_buffer(e->frame, 0) < 0 ||
        sc_av->av_frame_get_buffer(e->converted, 0) < 0)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", e->name);
    return SC_OK;
}

sc_status sc_encoder_open(const sc_ctx *ctx, const char *video, const sc_video_settings *settings,
                          sc_encoder **out)
{
    const sc_container *container = sc_container_find(video, settings->codec);
    SC_OWN(sc_encoder_close_at) sc_encoder *e = NULL;
    sc_text name = {0};

    if (!container)
        return sc_container_fail(ctx, video);
    SC_PASS(sc_libav_load(ctx, video));
    SC_PASS(SC_ZALLOC(ctx, 1, &e));
    e->container = container;
    e->settings = *settings;
    if (settings->alpha && container->alpha == AV_PIX_FMT_NONE)
        return sc_fail(ctx, SC_ERR_USAGE, "%s: %s has no transparency", video, container->name);
    SC_PASS(sc_text_add(ctx, &name, "%s", video));
    e->name = name.data;
    SC_PASS(sc_image_init_alpha(ctx, (settings->width_px + 1) & ~1, (settings->height_px + 1) & ~1,
                                settings->alpha, &e->padded));
    SC_PASS(sc_alloc(ctx, sc_picture_bytes(video, settings), 1, &e->yuv));
    SC_PASS(open_scaler(ctx, e));
    SC_PASS(open_codec(ctx, e)); /* so that a missing encoder is noticed before anything is drawn */
    SC_HAND_OVER(e, out);
    return SC_OK;
}

size_t sc_picture_bytes(const char *video, const sc_video_settings *settings)
{
    const sc_container *container = sc_container_find(video, settings->codec);
    const int bytes = container && sc_libav_is_here()
                          ? sc_av->av_image_get_buffer_size(
                                sc_container_pixels(container, settings->alpha),
                                (settings->width_px + 1) & ~1, (settings->height_px + 1) & ~1, 1)
                          : 0;

    return bytes > 0 ? (size_t)bytes : 0;
}

int sc_video_gop_frames(const sc_video_settings *settings)
{
    return settings->fps;
}

double sc_video_encoder_bytes_least(const char *video, const sc_video_settings *settings)
{
    const sc_container *container = sc_container_find(video, settings->codec);
    static const double fixed_bytes = 30, frame_bytes = 2.4; /* for each pixel */
    enum { FRAMES_AHEAD = 30, FRAMES_AHEAD_ULTRAFAST = 7 };
    const int most = strcmp(settings->preset, "ultrafast") ? FRAMES_AHEAD : FRAMES_AHEAD_ULTRAFAST;
    const int gop = sc_video_gop_frames(settings);
    double share = 1;

    if (container && (container->codec == AV_CODEC_ID_PRORES ||
                      container->codec == AV_CODEC_ID_WEBP || container->codec == AV_CODEC_ID_FFV1))
        return 3 * (double)sc_picture_bytes(video, settings);
    if (container && container->codec == AV_CODEC_ID_AV1)
        share = 0.9;
    if (settings->alpha) /* that of VP9 has an encoder of its own */
        share = 1.5;
    return share * settings->width_px * settings->height_px *
           (fixed_bytes + frame_bytes * (gop < most ? gop : most));
}

/* Copy the colours of @p count pixels with alpha, all transparent, and leave their alpha. */
static void copy_colors(const uint8_t *from, uint8_t *to, int count)
{
    for (int x = 0; x < count; x++)
        memcpy(to + 4 * (size_t)x, from + 4 * (size_t)x, 3);
}

/* Give what is transparent in a row of @p count pixels with alpha the colour of the nearest pixel
 * to its left that is not, or else to its right: a codec that loses something would mix the colours
 * at borders with black. @return false if all of it is transparent. */
static bool spread_row(uint8_t *row, int count)
{
    int first = 0;

    while (first < count && row[4 * first + 3] == 0)
        first++;
    if (first == count)
        return false;
    for (int x = 0; x < first; x++)
        memcpy(row + 4 * (size_t)x, row + 4 * (size_t)first, 3);
    for (int x = first + 1; x < count; x++) {
        if (row[4 * x + 3] == 0)
            memcpy(row + 4 * (size_t)x, row + 4 * (size_t)(x - 1), 3);
    }
    return true;
}

/* Spread the colours of a picture with alpha over what is transparent, row by row; a row without
 * any gets those of the row before it, or of the first that has some. */
static void spread_colors(sc_image *image)
{
    const size_t row_bytes = 4 * (size_t)image->width_px;
    int first = -1;

    for (int y = 0; y < image->height_px; y++) {
        uint8_t *row = image->rgb + (size_t)y * row_bytes;

        if (spread_row(row, image->width_px))
            first = first < 0 ? y : first;
        else if (first >= 0)
            copy_colors(row - row_bytes, row, image->width_px);
    }
    for (int y = first - 1; y >= 0; y--)
        copy_colors(image->rgb + (size_t)first * row_bytes, image->rgb + (size_t)y * row_bytes,
                    image->width_px);
}

/* Copy a frame into @p padded, which has its size rounded up to even numbers; where a side is
 * odd, its last column or row is repeated. */
static void pad(const sc_image *image, sc_image *padded)
{
    const size_t bytes = sc_pixel_bytes(padded->alpha);
    const size_t from = (size_t)image->width_px * bytes, to = (size_t)padded->width_px * bytes;

    for (int y = 0; y < padded->height_px; y++) {
        const int source = y < image->height_px ? y : image->height_px - 1;
        uint8_t *row = padded->rgb + (size_t)y * to;

        memcpy(row, image->rgb + (size_t)source * from, from);
        if (to > from)
            memcpy(row + from, row + from - bytes, bytes);
    }
    if (padded->alpha)
        spread_colors(padded);
}

/* Write the addresses and strides, in bytes, of the planes Y, U, V and alpha in the tightly packed
 * picture @p yuv to @p planes and @p strides. */
static void find_planes(const sc_encoder *e, uint8_t *yuv, uint8_t *planes[4], int strides[4])
{
    sc_av->av_image_fill_arrays(planes, strides, yuv, e->pixels, e->padded.width_px,
                                e->padded.height_px, 1);
}

const void *sc_encoder_convert(sc_encoder *e, const sc_image *image)
{
    const uint8_t *from[1] = {e->padded.rgb};
    const int stride[1] = {e->padded.width_px * (int)sc_pixel_bytes(e->padded.alpha)};
    uint8_t *planes[4];
    int strides[4];

    pad(image, &e->padded);
    sc_av->sws_scale(e->scaler, from, stride, 0, e->padded.height_px, e->converted->data,
                     e->converted->linesize);
    find_planes(e, e->yuv, planes, strides);
    sc_av->av_image_copy(planes, strides, (const uint8_t **)e->converted->data,
                         e->converted->linesize, e->pixels, e->padded.width_px,
                         e->padded.height_px);
    return e->yuv;
}

/* Keep the sequence header that libaom sends beside the packet with the first key frame as the
 * extradata of the codec. Does nothing if there is none. @return SC_ERR_MEMORY. */
static sc_status keep_header(const sc_ctx *ctx, sc_encoder *e)
{
    const AVPacketSideData *header = NULL;

    for (int i = 0; i < e->packet->side_data_elems; i++) {
        if (e->packet->side_data[i].type == AV_PKT_DATA_NEW_EXTRADATA)
            header = &e->packet->side_data[i];
    }
    if (!header || e->codec->extradata)
        return SC_OK;
    e->codec->extradata = sc_av->av_mallocz((size_t)header->size + AV_INPUT_BUFFER_PADDING_SIZE);
    if (!e->codec->extradata)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", e->name);
    memcpy(e->codec->extradata, header->data, (size_t)header->size);
    e->codec->extradata_size = (int)header->size;
    return SC_OK;
}

/* Move the packets that the codec has ready into e->segment; it may have none. @return
 * SC_ERR_INTERNAL, SC_ERR_MEMORY. */
static sc_status receive_packets(const sc_ctx *ctx, sc_encoder *e)
{
    for (;;) {
        int error;
        sc_status status;

        errno = 0;
        error = sc_av_error(sc_av->avcodec_receive_packet(e->codec, e->packet));
        if (error == AVERROR(EAGAIN) || error == AVERROR_EOF)
            return SC_OK;
        if (error < 0)
            return sc_av_fail(ctx, SC_ERR_INTERNAL, e->name, "cannot be encoded", error);
        status = keep_header(ctx, e);
        if (status == SC_OK)
            status = sc_segment_add_packet(ctx, &e->segment, e->packet);
        sc_av->av_packet_unref(e->packet);
        if (status != SC_OK)
            return status;
    }
}

sc_status sc_encoder_push(const sc_ctx *ctx, sc_encoder *e, const void *picture, uint64_t hash)
{
    uint8_t *planes[4];
    int strides[4], error;

    if (!e->codec)
        SC_PASS(open_codec(ctx, e));
    SC_PASS(sc_segment_add_hash(ctx, &e->segment, hash));
    if (sc_av->av_frame_make_writable(e->frame) < 0)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", e->name);
    find_planes(e, (uint8_t *)(uintptr_t)picture, planes, strides);
    sc_av->av_image_copy(e->frame->data, e->frame->linesize, (const uint8_t **)planes, strides,
                         e->pixels, e->padded.width_px, e->padded.height_px);
    e->frame->pts = e->segment.frames - 1;
    errno = 0;
    error = sc_av_error(sc_av->avcodec_send_frame(e->codec, e->frame));
    return error < 0 ? sc_av_fail(ctx, SC_ERR_INTERNAL, e->name, "cannot be encoded", error)
                     : receive_packets(ctx, e);
}

int sc_encoder_count(const sc_encoder *e)
{
    return e->segment.frames;
}

sc_status sc_encoder_finish(const sc_ctx *ctx, sc_encoder *e, uint64_t identity, int first_frame,
                            sc_segment *out)
{
    int error;
    sc_status status;

    errno = 0;
    error = sc_av_error(sc_av->avcodec_send_frame(e->codec, NULL));
    if (error < 0) {
        status = sc_av_fail(ctx, SC_ERR_INTERNAL, e->name, "cannot be encoded", error);
        goto out;
    }
    SC_TRY(receive_packets(ctx, e));
    SC_TRY(sc_segment_build(ctx, &e->segment, e->codec, e->name, identity, first_frame, out));
out:
    sc_encoder_drop(e);
    return status;
}

void sc_encoder_drop(sc_encoder *e)
{
    sc_av->avcodec_free_context(&e->codec);
    sc_segment_reset(&e->segment);
}

void sc_encoder_close(sc_encoder *e)
{
    if (!e)
        return;
    sc_av->avcodec_free_context(&e->codec);
    sc_av->av_frame_free(&e->frame);
    sc_av->av_frame_free(&e->converted);
    sc_av->av_packet_free(&e->packet);
    sc_av->sws_freeContext(e->scaler);
    sc_segment_clear(&e->segment);
    sc_image_clear(&e->padded);
    sc_free(e->yuv);
    sc_free(e->name);
    sc_free(e);
}
