/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Videos, encoded group by group and joined; a sink does both with frames in order. Files
 *  appear under their name only when complete. */
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

/* ---- groups of pictures, encoded apart from each other ---- */

/** Frames of one group: what is encoded, kept, proven and joined as one. A closed group of pictures
 *  of one second; the last of a video may be shorter. */
int sc_video_group(const sc_video_settings *settings);

/** An encoded group as bytes that prove themselves, to be kept in a file or sent. */
typedef struct sc_segment {
    void *data;
    size_t bytes;
} sc_segment;
void sc_segment_free(sc_segment *segment);
/** What a segment says of itself. */
typedef struct sc_segment_info {
    uint64_t identity; /**< of the job, as given to sc_encoder_finish */
    int first_frame, frame_count;
    const void *hashes; /**< of the pictures: frame_count times uint64_t, not aligned; borrowed */
} sc_segment_info;
/** @return false if the bytes are torn, or no segment. */
bool sc_segment_inspect(const sc_segment *segment, sc_segment_info *out);

/** Encodes one group after the other; a group's bytes depend on its pictures and the settings
 *  alone. Threads: has some of its own; one call at a time. */
typedef struct sc_encoder sc_encoder;
/** For the kind of video that the name @p video ends in. @return SC_ERR_USAGE for another ending,
 *  SC_ERR_CREATE if libav has no encoder for it. */
SC_MUST_USE sc_status sc_encoder_open(const sc_ctx *ctx, const char *video,
                                      const sc_video_settings *settings, sc_encoder **out);
void sc_encoder_close(sc_encoder *encoder);
/** Bytes of a picture as the encoder takes it: yuv420p, bt709, limited range, even sides. */
size_t sc_picture_bytes(const sc_video_settings *settings);
/** @return the picture of @p image, borrowed until the next call. */
const void *sc_encoder_convert(sc_encoder *encoder, const sc_image *image);
/** The next picture of the group; @p hash of its pixels goes into the segment. */
SC_MUST_USE sc_status sc_encoder_push(const sc_ctx *ctx, sc_encoder *encoder, const void *picture,
                                      uint64_t hash);
/** Pictures of the group so far. */
int sc_encoder_count(const sc_encoder *encoder);
/** End the group, which has at least one picture. Caller owns: sc_segment_free. */
SC_MUST_USE sc_status sc_encoder_finish(const sc_ctx *ctx, sc_encoder *encoder, uint64_t identity,
                                        int first_frame, sc_segment *out);
/** Give the group up. */
void sc_encoder_drop(sc_encoder *encoder);

/** Joins segments to a file that appears when it is finished. Plays everywhere: index first, exact
 *  times. The bytes depend on the segments alone. @return SC_ERR_USAGE for another ending,
 *  SC_ERR_CREATE. Caller owns: sc_muxer_close, also after sc_muxer_finish. */
typedef struct sc_muxer sc_muxer;
SC_MUST_USE sc_status sc_muxer_open(const sc_ctx *ctx, const char *path, sc_muxer **out);
/** @return SC_ERR_DATA if the segment is torn or of another encoder, SC_ERR_WRITE. */
SC_MUST_USE sc_status sc_muxer_add(const sc_ctx *ctx, sc_muxer *muxer, const sc_segment *segment);
/** Complete and publish, as @p path or as another name in its folder; at least one segment was
 *  added. @return SC_ERR_WRITE. */
SC_MUST_USE sc_status sc_muxer_finish(const sc_ctx *ctx, sc_muxer *muxer, const char *path);
void sc_muxer_close(sc_muxer *muxer);

/* ---- a video from frames in order ---- */

/** A video: .mp4 and .mkv hold H.264, .webm VP9; frames are encoded and joined as above.
 *  @return SC_ERR_USAGE for another ending, SC_ERR_CREATE. */
SC_MUST_USE sc_status sc_sink_open_video(const sc_ctx *ctx, const char *path,
                                         const sc_video_settings *settings, sc_sink **out);

/** Take the next frame. @return SC_ERR_WRITE. */
SC_MUST_USE sc_status sc_sink_push(const sc_ctx *ctx, sc_sink *sink, const sc_image *image);
/** Finish and publish the output; what is not @p complete is published as "name.partial.mp4", so
 *  that nothing half-done bears the final name. The sink stays to be closed.
 *  @return SC_ERR_WRITE. */
SC_MUST_USE sc_status sc_sink_finish(const sc_ctx *ctx, sc_sink *sink, bool complete);
/** Close; what was not finished leaves nothing behind. NULL is allowed. */
void sc_sink_close(sc_sink *sink);

/** "dir/name.partial.mp4" of "dir/name.mp4". */
SC_MUST_USE sc_status sc_partial_name(const sc_ctx *ctx, const char *path, sc_text *out);
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
