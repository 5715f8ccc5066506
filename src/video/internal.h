/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to video: containers, and how segments are built and read. */
#ifndef SC_VIDEO_INTERNAL_H
#define SC_VIDEO_INTERNAL_H

#include "segcast/video.h"

#include <libavcodec/avcodec.h>

/* A kind of video file. */
typedef struct sc_container {
    const char *extension;       /* end of the file name, e.g. ".mp4" */
    const char *muxer, *encoder; /* their names in libav */
    enum AVCodecID codec;
    bool global_header; /* parameter sets belong into the container's header, not into the stream */
} sc_container;

/* @return the container that the extension of @p path names, or NULL. */
const sc_container *sc_container_find(const char *path);
/* Log "PATH: WHAT: REASON" with libav's text for its @p error, and return @p status. */
sc_status sc_av_fail(const sc_ctx *ctx, sc_status status, const char *path, const char *what,
                     int error);

/* The content of a segment while its GOP is encoded. Zero-initialise; owns its memory:
 * sc_segment_clear. */
typedef struct sc_segment_builder {
    char *packets; /* packet_count times a packet_head (segment.c) and its data */
    size_t bytes, capacity;
    uint64_t *hashes; /* [frames] */
    int frames, hash_capacity, packet_count;
} sc_segment_builder;

/* Append the hash of the next frame. @return SC_ERR_MEMORY. */
sc_status sc_segment_add_hash(const sc_ctx *ctx, sc_segment_builder *b, uint64_t hash);
/* Append a packet; packets come in the order of decoding. @return SC_ERR_MEMORY. */
sc_status sc_segment_add_packet(const sc_ctx *ctx, sc_segment_builder *b, const AVPacket *packet);
/* Make a segment of what was added, and of what a muxer has to know of @p codec. @param name that
 * of the video, for messages. @return SC_ERR_INTERNAL if there is not one packet for each frame,
 * SC_ERR_MEMORY. Caller owns *out: sc_segment_free. */
sc_status sc_segment_build(const sc_ctx *ctx, const sc_segment_builder *b,
                           const AVCodecContext *codec, const char *name, uint64_t identity,
                           int first_frame, sc_segment *out);
/* Empty the builder; its memory is kept for the next GOP. */
void sc_segment_reset(sc_segment_builder *b);
void sc_segment_clear(sc_segment_builder *b);

/* What a muxer has to know of the codec. */
typedef struct sc_segment_codec {
    int codec_id, width_px, height_px, fps;
    int reorder; /* how many frames decoding is ahead of display */
    const void *extradata;
    size_t extradata_bytes;
} sc_segment_codec;
/* Read it from a segment that sc_segment_inspect has accepted; extradata is borrowed from the
 * segment.
 */
void sc_segment_describe(const sc_segment *segment, sc_segment_codec *out);
/* Read the packet at offset *at (0 for the first one) and move *at behind it. @p pts counts frames
 * from the beginning of the segment; @p data is borrowed from it. @return false at the end. */
bool sc_segment_next(const sc_segment *segment, size_t *at, int64_t *pts, int *flags,
                     const void **data, size_t *bytes);

#endif
