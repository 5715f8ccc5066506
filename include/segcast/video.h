/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Encoding, joining and decoding of videos; the only user of libav. A video consists of closed
 *  groups of pictures (GOPs) of one second. Each GOP is encoded by itself (sc_encoder) to a
 * segment, which can be kept in a file or sent to another rank. Segments are joined to a video
 * without being encoded again (sc_muxer), so the bytes of a video do not depend on who encoded
 * which GOP, or when. sc_video_writer does both for frames that come in order.
 *
 *  Frame numbers count from 0. Output files appear under their name only when they are complete. */
#ifndef SEGCAST_VIDEO_H
#define SEGCAST_VIDEO_H

#include "segcast/image.h"

/** What encodes a video; SC_CODEC_AUTO: what is usual for the extension of its name. */
typedef enum sc_codec {
    SC_CODEC_AUTO,
    SC_CODEC_H264,
    SC_CODEC_H265,
    SC_CODEC_AV1,
    SC_CODEC_VP9,
    SC_CODEC_PRORES,
    SC_CODEC_WEBP,
    SC_CODEC_GIF
} sc_codec;

/** The most chapters of a video. */
enum { SC_CHAPTERS_MAX = 100 };
/** A chapter: a part of the video with a name. */
typedef struct sc_video_chapter {
    int first, end;   /**< its frames are [first, end) */
    const char *name; /**< UTF-8, borrowed */
} sc_video_chapter;

/** How a video is encoded. */
typedef struct sc_video_settings {
    int width_px, height_px; /**< of the frames; odd sides are padded to even ones in the video */
    int fps;                 /**< frames per second, a whole number */
    sc_codec codec;          /**< one that the container of the video holds */
    int crf;                 /**< constant rate factor of the encoder, sc_video_crf_least to 51 */
    const char *preset;      /**< speed of the encoder, e.g. "medium"; borrowed; for H.264, H.265 */
    const char *title;       /**< of the film, in the metadata of the file; borrowed; NULL: none */
    const char *author;      /**< likewise */
    const char *version; /**< of segcast, with the hashes in the metadata; borrowed; NULL: neither
                              it nor they are written */
    uint64_t job_hash, volume_hash; /**< of what the film shows */
    bool alpha;                     /**< frames have alpha, which the codec has to hold */
    bool spherical; /**< frames show all directions (equirectangular), which is noted in files whose
                         format can say so, for players */
    int chapter_count;
    sc_video_chapter chapters[SC_CHAPTERS_MAX]; /**< [chapter_count] of them, which follow one
                                                     another; players can jump to each */
} sc_video_settings;

/* ---- segments: GOPs that are encoded independently ---- */

/** @return the number of frames of a GOP, one second of @p settings->fps; the last GOP of a
 *  video may be shorter. */
int sc_video_gop_frames(const sc_video_settings *settings);

/** One encoded GOP. The bytes hold the packets, what a muxer has to know of the codec, the hashes
 * of the frames, the identity of the job, and a hash of all this, by which damage is detected.
 * Numbers are in the byte order of the machine; a machine of the other order refuses the segment.
 */
typedef struct sc_segment {
    void *data;   /**< of sc_alloc, owned; NULL: empty */
    size_t bytes; /**< length of data */
} sc_segment;
/** Free the bytes of a segment; it is empty then. An empty segment is allowed. */
void sc_segment_free(sc_segment *segment);
/** What a segment says of itself. */
typedef struct sc_segment_info {
    uint64_t identity;            /**< of the job, as given to sc_encoder_finish */
    int first_frame;              /**< number in the video, as given to sc_encoder_finish */
    int frame_count;              /**< from 1 to fps */
    int width_px, height_px, fps; /**< of the video: sides are even */
    int codec;                    /**< what encoded it, as sc_video_codec_id says */
    /** frame_count numbers of type uint64_t, the hashes given to sc_encoder_push; borrowed from the
     *  segment. Not aligned: to be read with memcpy. */
    const void *hashes;
} sc_segment_info;
/** Verify the hash of a segment, and that what it holds can be a GOP: codec, sizes, number, order
 *  and lengths of its packets; and read its head. @return false if the bytes are damaged,
 *  truncated, forged, or not a segment; @p out is untouched then. */
bool sc_segment_inspect(const sc_segment *segment, sc_segment_info *out);

/** Encodes one GOP after the other. The bytes of a segment depend on the pictures of its GOP and on
 *  the settings alone. Threads: libav starts some of its own; one call at a time per encoder. */
typedef struct sc_encoder sc_encoder;
/** Open an encoder, and the codec, so that a codec that is missing is noticed before any frame
 *  is drawn. @param video name of the video; its extension chooses container and codec
 *  (sc_video_name_ok). No file is made. @param settings copied; the texts in it stay borrowed
 *  until sc_encoder_close. @return SC_ERR_USAGE for another extension, SC_ERR_CREATE if this
 *  libavcodec has no encoder for it or does not accept the settings, SC_ERR_MEMORY. Caller owns
 *  *out: sc_encoder_close. */
SC_MUST_USE sc_status sc_encoder_open(const sc_ctx *ctx, const char *video,
                                      const sc_video_settings *settings, sc_encoder **out);
/** Close and free; a GOP that was begun is lost. NULL is allowed. */
void sc_encoder_close(sc_encoder *encoder);
SC_CLOSE_AT(sc_encoder_close, sc_encoder)
/** @return the bytes of a converted picture: the planes Y, U and V of yuv420p, tightly packed, with
 *  the sides of the frame rounded up to even numbers. */
size_t sc_picture_bytes(const char *video, const sc_video_settings *settings);
/** Convert a frame from sRGB to the picture that the encoder compresses: yuv420p in BT.709,
 *  limited range. @param image as large as the settings say. @return the picture,
 *  sc_picture_bytes long, borrowed from the encoder until the next call. */
const void *sc_encoder_convert(sc_encoder *encoder, const sc_image *image);
/** Encode the next picture of the GOP; the first one begins a GOP. Returns when the codec
 *  accepts the next; its packets may come later. @param picture sc_picture_bytes long, of
 *  sc_encoder_convert of any encoder with these settings; copied. @param hash sc_image_hash of
 *  the frame, to be kept in the segment. @return SC_ERR_CREATE, SC_ERR_MEMORY, SC_ERR_INTERNAL;
 *  the GOP is unusable then: sc_encoder_drop. */
SC_MUST_USE sc_status sc_encoder_push(const sc_ctx *ctx, sc_encoder *encoder, const void *picture,
                                      uint64_t hash);
/** @return the number of pictures pushed into the GOP so far; 0 between two GOPs. */
int sc_encoder_count(const sc_encoder *encoder);
/** End the GOP, which has at least one picture, wait until all of it is encoded, and write it to
 *  *out with @p identity (of the job) and @p first_frame (number in the video) in its head. The
 *  encoder is ready for the next GOP, after an error, too; *out is untouched then. @return
 *  SC_ERR_INTERNAL, SC_ERR_MEMORY. Caller owns *out: sc_segment_free. */
SC_MUST_USE sc_status sc_encoder_finish(const sc_ctx *ctx, sc_encoder *encoder, uint64_t identity,
                                        int first_frame, sc_segment *out);
/** Discard the GOP that was begun, if any. */
void sc_encoder_drop(sc_encoder *encoder);

/** Joins segments, in the order in which they are added, to a video file. The index comes first
 *  (MP4) and every frame has its exact time. The bytes depend on the segments and what
 *  is written into the metadata alone. */
typedef struct sc_muxer sc_muxer;
/** Create the file under a temporary name beside @p path, whose extension chooses the container.
 *  @param settings title, author, version, hashes and alpha are read; borrowed during the call.
 * @return SC_ERR_USAGE for another extension, SC_ERR_CREATE, SC_ERR_MEMORY. Caller owns *out:
 * sc_muxer_close, also after sc_muxer_finish. */
SC_MUST_USE sc_status sc_muxer_open(const sc_ctx *ctx, const char *path,
                                    const sc_video_settings *settings, sc_muxer **out);
/** Append a segment, which is not needed afterwards. Its first_frame is not looked at: the
 *  frames follow those before them. @return SC_ERR_DATA if it is damaged or was made with
 *  another encoder or other settings than the first one, SC_ERR_WRITE, SC_ERR_MEMORY. After an
 *  error the muxer can only be closed. */
SC_MUST_USE sc_status sc_muxer_add(const sc_ctx *ctx, sc_muxer *muxer, const sc_segment *segment);
/** Complete the file, flush it to disk, and rename it to @p path, which lies in the directory given
 *  to sc_muxer_open. At least one segment was added. @param replace as of sc_outfile_open. @return
 *  SC_ERR_WRITE, SC_ERR_CREATE if the name is taken; the muxer can only be closed then. */
SC_MUST_USE sc_status sc_muxer_finish(const sc_ctx *ctx, sc_muxer *muxer, const char *path,
                                      bool replace);
/** Close and free; a file that was not finished is removed. NULL is allowed. */
void sc_muxer_close(sc_muxer *muxer);
SC_CLOSE_AT(sc_muxer_close, sc_muxer)

/* ---- a video from frames in order ---- */

/** Writes one video file from frames that come in order. */
typedef struct sc_video_writer sc_video_writer;
/** Create the video under a temporary name beside @p path. Unless the settings name a codec, .mp4
 *  and .mkv hold H.264, .webm holds VP9, .mov ProRes 4444. @param settings as of sc_encoder_open.
 * @return SC_ERR_USAGE for another extension, SC_ERR_CREATE, SC_ERR_MEMORY. Caller owns *out:
 * sc_video_writer_close. */
SC_MUST_USE sc_status sc_video_writer_open(const sc_ctx *ctx, const char *path,
                                           const sc_video_settings *settings,
                                           sc_video_writer **out);
/** Encode the next frame; the last one of a GOP writes the GOP to the file. @param image as
 *  large as the settings say. @return SC_ERR_WRITE, or as sc_encoder_push; after an error the
 *  writer can only be closed. */
SC_MUST_USE sc_status sc_video_writer_push(const sc_ctx *ctx, sc_video_writer *writer,
                                           const sc_image *image);
/** Complete the file, of at least one frame; the writer can only be closed then. @param complete
 *  false: not all frames came, and the file is named sc_video_partial_name, so that an incomplete
 *  video never bears the final name; with a number if that name is taken and must not be replaced.
 *  This name is logged. @param replace as of sc_outfile_open. @return SC_ERR_WRITE, SC_ERR_CREATE
 *  if the name is taken, SC_ERR_INTERNAL, SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_video_writer_finish(const sc_ctx *ctx, sc_video_writer *writer,
                                             bool complete, bool replace);
/** Close and free; what was not finished leaves no file behind. NULL is allowed. */
void sc_video_writer_close(sc_video_writer *writer);
SC_CLOSE_AT(sc_video_writer_close, sc_video_writer)

/** Append "dir/name.partial.mp4" to @p out for "dir/name.mp4". @p path must have an extension.
 *  @return SC_ERR_MEMORY. Caller owns @p out: sc_text_clear. */
SC_MUST_USE sc_status sc_video_partial_name(const sc_ctx *ctx, const char *path, sc_text *out);
/** The extensions of videos, for messages. */
#define SC_VIDEO_EXTENSIONS ".mp4, .mkv, .webm, .mov, .webp or .gif"
/** @return true if the extension of @p path names a container that can be written, one of
 *  SC_VIDEO_EXTENSIONS in any case. */
bool sc_video_name_ok(const char *path);
/** @return the codecs that a video named @p path can have, as words of output.codec for messages
 *  ("h264, h265 or av1"). Static text; "" for another extension. */
const char *sc_video_codec_words(const char *path);
/** @return whether a video named @p path can have this codec. */
bool sc_video_codec_ok(const char *path, sc_codec codec);
/** @return the least crf that the encoder of a video takes: 1 for H.264 and H.265, 0 for the
 * others, among them ProRes, which does not read it. */
int sc_video_crf_least(const char *path, sc_codec codec);
/** @return the name of the codec of a video, for messages. Static text. */
const char *sc_video_codec_name(const char *path, sc_codec codec);
/** @return a number by which the segments of a codec are known: that of sc_segment_info; 0 for a
 *  video that cannot be. */
int sc_video_codec_id(const char *path, sc_codec codec);
/** Check that this libavcodec has the encoder of a video; a name or codec that cannot be is none of
 *  its business. @return SC_ERR_CREATE, logged, with what it has. */
SC_MUST_USE sc_status sc_video_check_encoder(const sc_ctx *ctx, const char *path, sc_codec codec);
/** @return whether a video holds pictures with alpha. */
bool sc_video_has_alpha(const char *path, sc_codec codec);
/** @return whether a video named @p path takes frames of this size: sides of up to
 *  sc_video_side_max_px pixels, but both cannot have that many. */
bool sc_video_size_ok(const char *path, int width_px, int height_px);
/** @return the largest side of a video named @p path, in pixels: an even number. */
int sc_video_side_max_px(const char *path);
/** @return the most frames per second of a video named @p path: 60 for WebP and 50 for GIF, since
 *  browsers show shorter frames longer; as many as libav takes for the others. */
int sc_video_fps_max(const char *path);
/** @return whether a video named @p path, a GIF, counts times in hundredths of a second. */
bool sc_video_counts_hundredths(const char *path);
/** @return the longest time in seconds by which a frame of a video named @p path may be shown too
 *  early or too late: half of the unit in which its format counts. */
double sc_video_time_error_s(const char *path);
/** @return a lower bound of the bytes that the encoder of a video named @p video works with. It was
 * measured at 1280 x 720, with libx264 and libvpx, and at 7680 x 4320 with libx265 and libaom, too:
 * they hold the frames of a GOP that they look ahead at. ProRes encodes each frame by itself, and
 * has three copies of it here. */
double sc_video_encoder_bytes_least(const char *video, const sc_video_settings *settings);
/** @return about how many bytes a GIF or an animated WebP of @p frames frames has, by what turning
 *  tissues on a white background took for a pixel; twice or half as many is usual. 0 for other
 *  videos, which are small beside them. */
double sc_video_bytes_guess(const char *video, const sc_video_settings *settings, int frames);
/** @return how many bytes of the finished video there are for a byte of its segments: less than 1
 *  for GIF, whose segments lose nothing, 1 for the others. */
double sc_video_segment_share(const char *video);
/** @return whether the pictures are larger than any level of the codec of the video allows, so that
 *  players may refuse them: 35.7 million pixels for H.264, H.265, AV1 and VP9. */
bool sc_video_beyond_levels(const char *video, const sc_video_settings *settings);
/** Write the kinds of videos that this libav can encode into @p text, as ".mp4 (H.264), ...", cut
 * to
 *  @p size bytes with its NUL. */
void sc_video_kinds(char *text, size_t size);
/** Write the versions of the libav libraries in use into @p text, which is cut to @p size bytes
 *  with its NUL. */
void sc_video_libraries(char *text, size_t size);

/* ---- reading a video back ---- */

/** Receives frame number @p k, from 0, shown at @p time_s, as sRGB; @p image is borrowed for the
 *  call. Anything but SC_OK ends the decoding. */
typedef sc_status sc_video_frame_fn(void *user, int k, double time_s, const sc_image *image);
/** Decode a video, to check what was written: call @p on_frame for each frame in the order in
 *  which they are shown. A file that was cut between two frames gives fewer of them, which the
 *  caller has to count; all frames have the size of the first. @return SC_ERR_MISSING if it cannot
 * be opened, SC_ERR_DATA if it is damaged, SC_ERR_MEMORY, or what @p on_frame returned, which ends
 * the decoding. */
SC_MUST_USE sc_status sc_video_decode(const sc_ctx *ctx, const char *path,
                                      sc_video_frame_fn *on_frame, void *user);
/** Decode the frames @p frames [count], in rising order, of a video of @p fps frames per second,
 * and call @p on_frame for each, with its number: between them the file is skipped as far as its
 * GOPs allow it, so that a frame that begins a GOP costs one frame, and any other at most a GOP. A
 * file that is shorter gives fewer of them. @return as sc_video_decode. */
SC_MUST_USE sc_status sc_video_pick(const sc_ctx *ctx, const char *path, int fps, const int *frames,
                                    int count, sc_video_frame_fn *on_frame, void *user);

#endif
