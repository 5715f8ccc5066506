/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Floor 2: where finished frames go: a video file, a sequence of PNG files. A sink is a table of
 *  functions; frames are pushed in order. Files appear under their name only when complete. */
#ifndef SEGCAST_VIDEO_H
#define SEGCAST_VIDEO_H

#include "segcast/image.h"

typedef struct sc_sink sc_sink;

typedef struct sc_video_settings {
    int width_px, height_px;
    int fps;
    int crf;            /**< constant rate factor of the encoder, 0 (lossless) to 51 */
    const char *preset; /**< encoder's speed, e.g. "medium" */
} sc_video_settings;

/** A video: .mp4 and .mkv hold H.264, .webm VP9. Plays everywhere: yuv420p, bt709, limited range,
 *  even size, index first, closed groups of pictures of one second. The bytes depend on the frames
 *  and settings alone. @return SC_ERR_USAGE for another ending, SC_ERR_CREATE. */
SC_MUST_USE sc_status sc_sink_open_video(const sc_ctx *ctx, const char *path,
                                         const sc_video_settings *settings, sc_sink **out);
/** PNG files @p directory/000000.png and so on, numbered by frame. */
SC_MUST_USE sc_status sc_sink_open_png(const sc_ctx *ctx, const char *directory, sc_sink **out);

/** Take frame @p k. @return SC_ERR_WRITE. */
SC_MUST_USE sc_status sc_sink_push(const sc_ctx *ctx, sc_sink *sink, int k, const sc_image *image);
/** Finish and publish the output; what is not @p complete is published as "name.partial.mp4", so
 *  that nothing half-done bears the final name. The sink stays to be closed.
 *  @return SC_ERR_WRITE. */
SC_MUST_USE sc_status sc_sink_finish(const sc_ctx *ctx, sc_sink *sink, bool complete);
/** Close; what was not finished leaves nothing behind. NULL is allowed. */
void sc_sink_close(sc_sink *sink);

/** Is the ending of @p path one that sc_sink_open_video takes? */
bool sc_video_name_ok(const char *path);
/** Versions of the video libraries into @p text. */
void sc_video_libraries(char *text, size_t size);

/** One decoded frame at a time, for checks: opens @p path, calls @p take for each frame in order
 *  as sRGB. @return SC_ERR_MISSING, SC_ERR_DATA, or what @p take returned. */
typedef sc_status sc_video_take_fn(void *user, int k, double time_s, const sc_image *image);
SC_MUST_USE sc_status sc_video_decode(const sc_ctx *ctx, const char *path, sc_video_take_fn *take,
                                      void *user);

#endif
