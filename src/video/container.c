/* SPDX-License-Identifier: BSD-3-Clause */
/* The kinds of video files, their names, and the messages of libav. */
#include "internal.h"

#include <errno.h>

#include <libavformat/avformat.h>
#include <libavutil/imgutils.h>
#include <string.h>
#include <strings.h>

static const sc_container containers[] = {
    /* With 0, x264 loses nothing, which the profile that all players know does not have. */
    {".mp4", "mp4", "libx264", "H.264", AV_CODEC_ID_H264, true, 1, 0, AV_PIX_FMT_YUV420P,
     AV_PIX_FMT_NONE},
    {".mkv", "matroska", "libx264", "H.264", AV_CODEC_ID_H264, true, 1, 0, AV_PIX_FMT_YUV420P,
     AV_PIX_FMT_NONE},
    {".webm", "webm", "libvpx-vp9", "VP9", AV_CODEC_ID_VP9, false, 0, 0, AV_PIX_FMT_YUV420P,
     AV_PIX_FMT_NONE},
    {".mov", "mov", "prores_ks", "ProRes 4444", AV_CODEC_ID_PRORES, false, 0,
     MKTAG('a', 'p', '4', 'h'), AV_PIX_FMT_YUV444P10LE, AV_PIX_FMT_YUVA444P10LE},
};

const sc_container *sc_container_find(const char *path)
{
    const char *dot = strrchr(path, '.');

    for (size_t i = 0; dot && i < SC_COUNT_OF(containers); i++) {
        if (!strcasecmp(dot, containers[i].extension))
            return &containers[i];
    }
    return NULL;
}

bool sc_video_name_ok(const char *path)
{
    return sc_container_find(path) != NULL;
}

int sc_video_crf_least(const char *path)
{
    const sc_container *container = sc_container_find(path);

    return container ? container->crf_least : 0;
}

const char *sc_video_codec_name(const char *path)
{
    const sc_container *container = sc_container_find(path);

    return container ? container->name : "unknown";
}

bool sc_video_has_alpha(const char *path)
{
    const sc_container *container = sc_container_find(path);

    return container && container->alpha != AV_PIX_FMT_NONE;
}

enum AVPixelFormat sc_container_pixels(const sc_container *container, bool alpha)
{
    return alpha ? container->alpha : container->opaque;
}

sc_status sc_video_check_encoder(const sc_ctx *ctx, const char *path)
{
    const sc_container *container = sc_container_find(path);
    sc_text others = {0};
    sc_status status = SC_OK;

    if (!container || avcodec_find_encoder_by_name(container->encoder))
        return SC_OK;
    for (size_t i = 0; i < SC_COUNT_OF(containers); i++) {
        if (avcodec_find_encoder_by_name(containers[i].encoder))
            SC_TRY(sc_text_add(ctx, &others, "%s%s (%s)", others.length_bytes ? ", " : "",
                               containers[i].extension, containers[i].name));
    }
    status = sc_fail(ctx, SC_ERR_CREATE,
                     "%s: this libavcodec has no encoder %s for %s; it has what these need: %s; or "
                     "choose video: none with frames: png",
                     path, container->encoder, container->name,
                     others.length_bytes ? others.data : "none");
out:
    sc_text_clear(&others);
    return status;
}

bool sc_video_size_ok(int width_px, int height_px)
{
    av_log_set_level(AV_LOG_FATAL); /* the caller says what is wrong */
    return av_image_check_size((unsigned)(width_px + 1) & ~1u, (unsigned)(height_px + 1) & ~1u, 0,
                               NULL) >= 0;
}

void sc_video_libraries(char *text, size_t size)
{
    const unsigned format = avformat_version(), codec = avcodec_version();

    snprintf(text, size, "libavformat %u.%u.%u, libavcodec %u.%u.%u", format >> 16,
             format >> 8 & 255, format & 255, codec >> 16, codec >> 8 & 255, codec & 255);
}

sc_status sc_av_fail(const sc_ctx *ctx, sc_status status, const char *path, const char *what,
                     int error)
{
    char reason[128] = "unknown";

    if (error == AVERROR(ENOMEM))
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", path);
    if (error == AVERROR(EFBIG))
        snprintf(reason, sizeof reason, "%s", sc_reason(EFBIG));
    else
        av_strerror(error, reason, sizeof reason);
    return sc_fail(ctx, status, "%s: %s: %s", path, what, reason);
}

int sc_av_result(int error)
{
    return errno == ENOMEM ? AVERROR(ENOMEM) : error;
}

int sc_av_error(int error)
{
    return error < 0 && error != AVERROR(EAGAIN) && error != AVERROR_EOF ? sc_av_result(error)
                                                                         : error;
}

sc_status sc_video_partial_name(const sc_ctx *ctx, const char *path, sc_text *out)
{
    const char *dot = strrchr(path, '.');

    return sc_text_add(ctx, out, "%.*s.partial%s", (int)(dot - path), path, dot);
}
