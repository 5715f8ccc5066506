/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to video: containers, and segments being built. */
#ifndef SC_VIDEO_INTERNAL_H
#define SC_VIDEO_INTERNAL_H

#include "segcast/video.h"

#include <libavcodec/avcodec.h>

typedef struct sc_container {
    const char *ending, *muxer, *encoder;
    enum AVCodecID codec;
    bool global_header;
} sc_container;

/* By the ending of @p path, or NULL. */
const sc_container *sc_container_find(const char *path);
/* Log what libav says of @p error and return @p status. */
sc_status sc_av_failed(const sc_ctx *ctx, sc_status status, const char *path, const char *what,
                       int error);

/* Growing bytes of a segment. */
typedef struct sc_segment_builder {
    char *packets;
    size_t bytes, capacity;
    uint64_t *hashes; /* [frames] of the pictures */
    int frames, hash_capacity, packet_count;
} sc_segment_builder;

sc_status sc_segment_note(const sc_ctx *ctx, sc_segment_builder *b, uint64_t hash);
sc_status sc_segment_add(const sc_ctx *ctx, sc_segment_builder *b, const AVPacket *packet);
/* Everything the muxer has to know of @p codec, before what was added. */
sc_status sc_segment_build(const sc_ctx *ctx, const sc_segment_builder *b,
                           const AVCodecContext *codec, const char *name, uint64_t identity,
                           int first_frame, sc_segment *out);
/* Empty, memory kept. */
void sc_segment_reset(sc_segment_builder *b);
void sc_segment_clear(sc_segment_builder *b);

/* What a segment holds besides packets. */
typedef struct sc_segment_codec {
    int codec_id, width_px, height_px, fps, reorder;
    const void *extradata;
    size_t extradata_bytes;
} sc_segment_codec;
void sc_segment_describe(const sc_segment *segment, sc_segment_codec *out);
/* The packet at *at (0 to begin), its time in frames of the segment; @return false at the end. */
bool sc_segment_next(const sc_segment *segment, size_t *at, int64_t *pts, int *flags,
                     const void **data, size_t *bytes);

#endif
