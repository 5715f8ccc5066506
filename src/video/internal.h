/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to video: containers, and how segments are built and read. */
#ifndef SC_VIDEO_INTERNAL_H
#define SC_VIDEO_INTERNAL_H

#include "libav.h"
#include "segcast/video.h"

/* A kind of video file, and a codec that segcast can put into it. */
typedef struct sc_container {
    const char *extension;       /* end of the file name, e.g. ".mp4" */
    sc_codec choice;             /* the codec as users name it */
    const char *muxer, *encoder; /* their names in libav */
    const char *name;            /* of the codec, for messages */
    enum AVCodecID codec;
    bool global_header; /* parameter sets belong into the container's header, not into the stream */
    int crf_least;      /* of its encoder */
    uint32_t tag;       /* libav's codec_tag in the container; 0: its default */
    /* libav's formats of the pictures that the encoder gets, opaque and with alpha; the latter is
     * AV_PIX_FMT_NONE where the codec has no transparency. */
    enum AVPixelFormat opaque, alpha;
} sc_container;

/* @return the container that the extension of @p path names, in any case, with this codec, from a
 * static table; NULL for another extension or none, or a codec that it does not hold. */
const sc_container *sc_container_find(const char *path, sc_codec codec);
/* Log that a video named @p path cannot be, by its extension or by the codec that is asked for.
 * @return SC_ERR_USAGE. */
sc_status sc_container_fail(const sc_ctx *ctx, const char *path);
/* @return the format of the pictures that the encoder of a video gets. */
enum AVPixelFormat sc_container_pixels(const sc_container *container, bool alpha);
/* Log "PATH: WHAT: REASON" with libav's text for its @p error. @return @p status, or SC_ERR_MEMORY
 * if that is the error. */
sc_status sc_av_fail(const sc_ctx *ctx, sc_status status, const char *path, const char *what,
                     int error);

/* Some functions of libav go on without what they found no memory for: a name or a setting is
 * missing in the video then. errno tells, if it is 0 before they are called. @return
 * AVERROR(ENOMEM) if so, otherwise @p error, which is their result. Only for functions that
 * allocate little: malloc of glibc sets errno also when a large block found no room in the first
 * of its arenas and was then allocated in another. */
int sc_av_result(int error);
/* As sc_av_result, for functions that report every error but not its cause, such as those that
 * encode: @return @p error as it is if it is 0 or more, AVERROR(EAGAIN) or AVERROR_EOF. */
int sc_av_error(int error);

/* Let libav write to @p file, which stays borrowed until sc_output_end. libav opens no file by
 * itself then. @return false if there is no memory. */
bool sc_output_begin(AVFormatContext *format, sc_outfile *file);
/* Write what libav still holds, and end what sc_output_begin began. Does nothing without it.
 * @return 0, or libav's code of the first error in writing. */
int sc_output_end(AVFormatContext *format);
/* Let libav read a video from @p stream, which stays borrowed until sc_input_end. libav opens no
 * file by itself then. @return what sc_input_open takes; NULL if there is no memory. Caller owns
 * it: sc_input_end. */
AVFormatContext *sc_input_begin(FILE *stream);
/* Find out the format of the video and read its header. @param name for libav, which also looks at
 * its extension. @return 0, or libav's code of an error: *format is NULL then, all of it freed. */
int sc_input_open(AVFormatContext **format, const char *name);
/* Free what sc_input_begin has made, and set *format to NULL, which is allowed. */
void sc_input_end(AVFormatContext **format);

/* @return whether the extradata of a codec (an AVCodecID) are what its encoder writes: of H.264 and
 * H.265 parameter sets behind start codes, which libavformat can read in a moment; of AV1 a
 * sequence header; nothing of the others. */
bool sc_has_sane_parameters(int codec_id, const void *extradata, size_t bytes);

/* The content of a segment while its GOP is encoded; owns both arrays. Zero-initialise, then
 * sc_segment_clear. */
typedef struct sc_segment_builder {
    char *packets;          /* packet_count times a packet_head (segment.c) and its data */
    size_t bytes, capacity; /* of packets: used, allocated */
    uint64_t *hashes;       /* [hash_capacity], the first frames of which are used */
    int frames, hash_capacity, packet_count;
} sc_segment_builder;

/* Append the hash of the next frame. @return SC_ERR_MEMORY, the builder unchanged. */
sc_status sc_segment_add_hash(const sc_ctx *ctx, sc_segment_builder *b, uint64_t hash);
/* The bytes before the alpha of a picture in what libav calls the block's additional data: their
 * number, in the byte order of the network. */
enum { SC_BLOCK_NUMBER_BYTES = 8 };
/* Append a copy of a packet, with its additional data; packets come in the order of decoding.
 * @return SC_ERR_MEMORY, the builder unchanged. */
sc_status sc_segment_add_packet(const sc_ctx *ctx, sc_segment_builder *b, const AVPacket *packet);
/* Make the segment *out from what was added and from what a muxer has to know of @p codec,
 * which is open; the builder is unchanged. @p name is that of the video, for messages. @return
 * SC_ERR_INTERNAL unless there is one packet for each frame, SC_ERR_MEMORY. Caller owns *out:
 * sc_segment_free. */
sc_status sc_segment_build(const sc_ctx *ctx, const sc_segment_builder *b,
                           const AVCodecContext *codec, const char *name, uint64_t identity,
                           int first_frame, sc_segment *out);
/* Empty the builder; its memory is kept for the next GOP. */
void sc_segment_reset(sc_segment_builder *b);
/* Free the memory of the builder and zero it. A zeroed builder is allowed. */
void sc_segment_clear(sc_segment_builder *b);

/* What a muxer has to know of the codec. */
typedef struct sc_segment_codec {
    int codec_id; /* libav's enum AVCodecID */
    int width_px, height_px, fps;
    int reorder;           /* how many frames decoding is ahead of display */
    const void *extradata; /* the parameter sets, borrowed */
    size_t extradata_bytes;
} sc_segment_codec;
/* Fill *out from a segment that sc_segment_inspect has accepted; extradata is borrowed from the
 * segment. */
void sc_segment_describe(const sc_segment *segment, sc_segment_codec *out);
/* A packet in a segment, whose data it borrows. */
typedef struct sc_segment_packet {
    int64_t pts; /* in frames from the beginning of the segment, in the order of showing */
    int flags;   /* libav's of a packet */
    const void *data;
    const void *alpha; /* the alpha of the picture, a picture by itself; only of VP9 */
    size_t bytes, alpha_bytes;
} sc_segment_packet;
/* Read the packet at offset *at (0 for the first one) of a segment that sc_segment_inspect has
 * accepted, and move *at behind it. @return false at the end; nothing is written then but *at. */
bool sc_segment_next(const sc_segment *segment, size_t *at, sc_segment_packet *out);

/* Texts for the metadata of a file, each may be empty. */
typedef struct sc_metadata {
    char title[1024], author[1024], comment[128];
} sc_metadata;

/* ---- animated WebP files ---- */

/* @return whether these are a WebP file of one picture, as libwebp writes it. */
bool sc_webp_is_picture(const void *data, size_t bytes);

/* Writes an animated WebP file, which is shown again and again. The members above the line are set
 * by the caller before sc_webp_begin. */
typedef struct sc_webp {
    FILE *stream; /* open for writing at its begin; borrowed */
    int width_px, height_px, fps;
    bool alpha;
    /* ---- */
    uint64_t bytes; /* written so far */
    int64_t frames;
    bool has_metadata;
} sc_webp;
/* Begin the file. @param path for messages. @return SC_ERR_WRITE. */
sc_status sc_webp_begin(const sc_ctx *ctx, sc_webp *w, const char *path);
/* Append a frame, a picture as of sc_webp_is_picture. @return SC_ERR_WRITE, also beyond 4 GiB. */
sc_status sc_webp_add(const sc_ctx *ctx, sc_webp *w, const char *path, const void *data,
                      size_t bytes);
/* Complete the file. @return SC_ERR_WRITE, SC_ERR_MEMORY. */
sc_status sc_webp_end(const sc_ctx *ctx, sc_webp *w, const char *path, const sc_metadata *about);

/* Reads an animated WebP file as sc_webp writes it. */
typedef struct sc_webp_reader {
    FILE *stream;             /* borrowed */
    int64_t bytes, at, first; /* length of the file; place of the next chunk, and of the first */
    int64_t time_ms;          /* when the next frame begins */
    bool alpha;
    uint8_t canvas[18]; /* the VP8X chunk of a picture of this size */
} sc_webp_reader;
/* Begin to read. @return false if it is no animated WebP file. */
bool sc_webp_open(sc_webp_reader *r, FILE *stream);
/* Go back to the first frame. */
void sc_webp_rewind(sc_webp_reader *r);
/* Fill @p packet with the next frame, a WebP file of one picture, with its time in milliseconds.
 * @return 0, AVERROR_EOF behind the last one, AVERROR_INVALIDDATA, AVERROR(ENOMEM). */
int sc_webp_read(sc_webp_reader *r, AVPacket *packet);

/* ---- GIF ---- */

/* @return whether libavfilter can be loaded, and libav has all that a GIF needs. */
bool sc_gif_is_possible(void);
/* Makes a GIF of frames in FFV1. */
typedef struct sc_gif sc_gif;
/* Begin; a file is made beside @p path, which stays borrowed, as @p ctx does, and which is removed
 * at the end. @return SC_ERR_CREATE, SC_ERR_MEMORY. Caller owns *out: sc_gif_close. */
sc_status sc_gif_open(const sc_ctx *ctx, const char *path, sc_gif **out);
/* Take the next frame, a packet of FFV1, and look at its colours. @param codec of the segment in
 * which it is; its size and frame rate are those of the film. @return SC_ERR_DATA, SC_ERR_WRITE,
 * SC_ERR_MEMORY, SC_ERR_INTERNAL. */
sc_status sc_gif_add(sc_gif *gif, const sc_segment_codec *codec, const void *data, size_t bytes);
/* Write all frames, at least one, to @p format, a muxer of GIF that is open for writing. A stage of
 * its own, as long as all sc_gif_add. @return as sc_gif_add. */
sc_status sc_gif_finish(sc_gif *gif, AVFormatContext *format);
/* Close and free. NULL is allowed. */
void sc_gif_close(sc_gif *gif);
SC_CLOSE_AT(sc_gif_close, sc_gif)
/* Write title, author and comment before the end of a complete GIF, as comments. @return
 * SC_ERR_WRITE. */
sc_status sc_gif_describe(const sc_ctx *ctx, const char *path, FILE *stream,
                          const sc_metadata *about);

#endif
