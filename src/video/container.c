/* SPDX-License-Identifier: BSD-3-Clause */
/* The kinds of video files, and their names. */
#include "internal.h"

#include <limits.h>
#include <math.h>
#include <strings.h>

/* With crf 0, x264 and x265 lose nothing, which the profiles that all players know do not have. */
#define H264                                                                                       \
    .choice = SC_CODEC_H264, .encoder = "libx264", .name = "H.264", .codec = AV_CODEC_ID_H264,     \
    .global_header = true, .crf_least = 1, .opaque = AV_PIX_FMT_YUV420P, .alpha = AV_PIX_FMT_NONE
#define H265                                                                                       \
    .choice = SC_CODEC_H265, .encoder = "libx265", .name = "H.265", .codec = AV_CODEC_ID_HEVC,     \
    .global_header = true, .crf_least = 1, .opaque = AV_PIX_FMT_YUV420P, .alpha = AV_PIX_FMT_NONE
/* Not SVT-AV1, which is faster, but writes to standard error and refuses sides below 64 pixels. */
#define AV1                                                                                        \
    .choice = SC_CODEC_AV1, .encoder = "libaom-av1", .name = "AV1", .codec = AV_CODEC_ID_AV1,      \
    .global_header = true, .opaque = AV_PIX_FMT_YUV420P, .alpha = AV_PIX_FMT_NONE
#define VP9                                                                                        \
    .choice = SC_CODEC_VP9, .encoder = "libvpx-vp9", .name = "VP9", .codec = AV_CODEC_ID_VP9,      \
    .opaque = AV_PIX_FMT_YUV420P, .alpha = AV_PIX_FMT_YUVA420P
#define PRORES                                                                                     \
    .choice = SC_CODEC_PRORES, .encoder = "prores_ks", .name = "ProRes 4444",                      \
    .codec = AV_CODEC_ID_PRORES, .tag = MKTAG('a', 'p', '4', 'h'),                                 \
    .opaque = AV_PIX_FMT_YUV444P10LE, .alpha = AV_PIX_FMT_YUVA444P10LE

/* Every frame by itself. libwebp converts the colours, which are of BT.601 in WebP. */
#define WEBP                                                                                       \
    .choice = SC_CODEC_WEBP, .encoder = "libwebp", .name = "WebP", .codec = AV_CODEC_ID_WEBP,      \
    .opaque = AV_PIX_FMT_BGRA, .alpha = AV_PIX_FMT_BGRA

/* Segments hold what the GIF is made of at the end, without losses: FFV1, which takes a frame by
 * itself, needs 150 kB for one of 1280 x 720, half of PNG. */
#define GIF                                                                                        \
    .choice = SC_CODEC_GIF, .encoder = "ffv1", .name = "GIF", .codec = AV_CODEC_ID_FFV1,           \
    .opaque = AV_PIX_FMT_BGRA, .alpha = AV_PIX_FMT_NONE

/* The first row of an extension holds the codec that is usual for it. Apple's players know H.265 by
 * the tag hvc1, with the parameter sets in the header of the file alone. */
static const sc_container containers[] = {
    {.extension = ".mp4", .muxer = "mp4", H264},
    {.extension = ".mp4", .muxer = "mp4", H265, .tag = MKTAG('h', 'v', 'c', '1')},
    {.extension = ".mp4", .muxer = "mp4", AV1},
    {.extension = ".mkv", .muxer = "matroska", H264},
    {.extension = ".mkv", .muxer = "matroska", H265},
    {.extension = ".mkv", .muxer = "matroska", AV1},
    {.extension = ".mkv", .muxer = "matroska", VP9},
    {.extension = ".webm", .muxer = "webm", VP9},
    {.extension = ".webm", .muxer = "webm", AV1},
    {.extension = ".mov", .muxer = "mov", PRORES},
    {.extension = ".mov", .muxer = "mov", H264},
    {.extension = ".mov", .muxer = "mov", H265, .tag = MKTAG('h', 'v', 'c', '1')},
    {.extension = ".webp", .muxer = "webp", WEBP}, /* by webp.c */
    {.extension = ".gif", .muxer = "gif", GIF},    /* by gif.c */
};

const sc_container *sc_container_find(const char *path, sc_codec codec)
{
    const char *dot = strrchr(path, '.');

    for (size_t i = 0; dot && i < SC_COUNT_OF(containers); i++) {
        if (!strcasecmp(dot, containers[i].extension) &&
            (codec == SC_CODEC_AUTO || codec == containers[i].choice))
            return &containers[i];
    }
    return NULL;
}

bool sc_video_name_ok(const char *path)
{
    return sc_container_find(path, SC_CODEC_AUTO) != NULL;
}

bool sc_video_codec_ok(const char *path, sc_codec codec)
{
    return sc_container_find(path, codec) != NULL;
}

const char *sc_video_codec_words(const char *path)
{
    const sc_container *container = sc_container_find(path, SC_CODEC_AUTO);
    const char *extension = container ? container->extension : "";

    return !strcmp(extension, ".mp4")    ? "h264, h265 or av1"
           : !strcmp(extension, ".mkv")  ? "h264, h265, av1 or vp9"
           : !strcmp(extension, ".webm") ? "vp9 or av1"
           : !strcmp(extension, ".mov")  ? "prores, h264 or h265"
           : !strcmp(extension, ".webp") ? "webp"
           : !strcmp(extension, ".gif")  ? "gif"
                                         : "";
}

int sc_video_crf_least(const char *path, sc_codec codec)
{
    const sc_container *container = sc_container_find(path, codec);

    return container ? container->crf_least : 0;
}

const char *sc_video_codec_name(const char *path, sc_codec codec)
{
    const sc_container *container = sc_container_find(path, codec);

    return container ? container->name : "unknown";
}

int sc_video_codec_id(const char *path, sc_codec codec)
{
    const sc_container *container = sc_container_find(path, codec);

    return container ? (int)container->codec : 0;
}

bool sc_video_has_alpha(const char *path, sc_codec codec)
{
    const sc_container *container = sc_container_find(path, codec);

    return container && container->alpha != AV_PIX_FMT_NONE;
}

sc_status sc_container_fail(const sc_ctx *ctx, const char *path)
{
    if (sc_video_name_ok(path))
        return sc_fail(ctx, SC_ERR_USAGE, "%s: expected a codec that it can hold: %s", path,
                       sc_video_codec_words(path));
    return sc_fail(ctx, SC_ERR_USAGE, "%s: the name of a video must end in " SC_VIDEO_EXTENSIONS,
                   path);
}

enum AVPixelFormat sc_container_pixels(const sc_container *container, bool alpha)
{
    return alpha ? container->alpha : container->opaque;
}

/* @return whether this libav has what a kind of video needs. */
static bool is_possible(const sc_container *container)
{
    return sc_libav_is_here() && sc_av->avcodec_find_encoder_by_name(container->encoder) &&
           (container->choice != SC_CODEC_GIF || sc_gif_is_possible());
}

void sc_video_kinds(char *text, size_t size)
{
    size_t used = 0;

    text[0] = '\0';
    for (size_t i = 0; i < SC_COUNT_OF(containers) && used < size; i++) {
        if (is_possible(&containers[i]))
            used += (size_t)snprintf(text + used, size - used, "%s%s (%s)", used ? ", " : "",
                                     containers[i].extension, containers[i].name);
    }
}

sc_status sc_video_check_encoder(const sc_ctx *ctx, const char *path, sc_codec codec)
{
    const sc_container *container = sc_container_find(path, codec);
    char kinds[512];

    if (!container)
        return SC_OK;
    SC_PASS(sc_libav_load(ctx, path));
    if (is_possible(container))
        return SC_OK;
    sc_video_kinds(kinds, sizeof kinds);
    return sc_fail(ctx, SC_ERR_CREATE,
                   "%s: this libavcodec has no encoder %s for %s%s; it has what these need: %s; or "
                   "choose video: none with frames: png",
                   path, container->encoder, container->name,
                   container->choice == SC_CODEC_GIF ? ", or libavfilter is not here" : "",
                   kinds[0] ? kinds : "none");
}

bool sc_video_size_ok(const char *path, int width_px, int height_px)
{
    const int side_max_px = sc_video_side_max_px(path);
    /* As av_image_check_size, which is not asked: pictures without a video need no libav. It takes
     * pixels for 8 bytes each, and allows for 128 more along each side. */
    const int64_t bytes = 8 * (((width_px + 1) & ~1) + 128LL) * (((height_px + 1) & ~1) + 128LL);

    return width_px <= side_max_px && height_px <= side_max_px && bytes < INT_MAX;
}

/* @return the codec that is usual for a video named @p path; SC_CODEC_AUTO for another name. */
static sc_codec choice_of(const char *path)
{
    const sc_container *container = sc_container_find(path, SC_CODEC_AUTO);

    return container ? container->choice : SC_CODEC_AUTO;
}

int sc_video_side_max_px(const char *path)
{
    return choice_of(path) == SC_CODEC_WEBP ? 16382 : 16384;
}

int sc_video_fps_max(const char *path)
{
    switch (choice_of(path)) {
    case SC_CODEC_WEBP:
        return 60;
    case SC_CODEC_GIF:
        return 50;
    default:
        return 1000;
    }
}

bool sc_video_counts_hundredths(const char *path)
{
    return choice_of(path) == SC_CODEC_GIF;
}

double sc_video_time_error_s(const char *path)
{
    return sc_video_counts_hundredths(path) ? 5.1e-3 : 1e-3;
}

double sc_video_bytes_guess(const char *video, const sc_video_settings *settings, int frames)
{
    static const double gif_px = 0.1, webp_px = 0.025, lossless_px = 0.15; /* bytes per pixel */
    const double pixels = (double)settings->width_px * settings->height_px * frames;

    switch (choice_of(video)) {
    case SC_CODEC_GIF:
        return gif_px * pixels;
    case SC_CODEC_WEBP: /* webp_px was measured at crf 18 */
        return pixels *
               (settings->crf == 0 ? lossless_px : webp_px * exp2((18 - settings->crf) / 10.0));
    default:
        return 0;
    }
}

double sc_video_segment_share(const char *video)
{
    return choice_of(video) == SC_CODEC_GIF ? 0.6 : 1;
}

bool sc_video_beyond_levels(const char *video, const sc_video_settings *settings)
{
    /* Levels 6.2 of H.265 and VP9 and 6.3 of AV1; 6.2 of H.264 has 139264 blocks of 16 x 16. */
    static const double most_px = 35651584;
    const sc_container *container = sc_container_find(video, settings->codec);

    return container && container->choice <= SC_CODEC_VP9 &&
           (double)settings->width_px * settings->height_px > most_px;
}

void sc_video_libraries(char *text, size_t size)
{
    unsigned format, codec;

    if (!sc_libav_is_here()) {
        snprintf(text, size, "cannot be loaded");
        return;
    }
    format = sc_av->avformat_version();
    codec = sc_av->avcodec_version();
    snprintf(text, size, "libavformat %u.%u.%u, libavcodec %u.%u.%u", format >> 16,
             format >> 8 & 255, format & 255, codec >> 16, codec >> 8 & 255, codec & 255);
}

sc_status sc_video_partial_name(const sc_ctx *ctx, const char *path, sc_text *out)
{
    const char *dot = strrchr(path, '.');

    return sc_text_add(ctx, out, "%.*s.partial%s", (int)(dot - path), path, dot);
}
