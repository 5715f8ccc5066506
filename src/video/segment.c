/* SPDX-License-Identifier: BSD-3-Clause */
/* The bytes of an encoded GOP: a head, the hashes of its frames, the codec's extradata, the
 * packets. The hash in the head covers everything behind it. Numbers are in the byte order of the
 * machine, which is good enough because segments exist only until the job is complete; a machine of
 * the other byte order refuses them. */
#include "internal.h"

#define MAGIC "segcast\x02"
enum { BYTE_ORDER_MARK = 0x01020304 };
/* What a segment may hold at most: a GOP is one second of video. */
enum { FPS_MAX = 1000, SIDE_MAX_PX = 1 << 15, REORDER_MAX = 16, EXTRADATA_MAX_BYTES = 1 << 20 };

/* How a segment begins. */
typedef struct segment_head {
    char magic[8];
    uint64_t hash;       /* hash of everything behind this field */
    uint64_t bytes;      /* length of the whole segment */
    uint64_t identity;   /* of the job */
    uint32_t byte_order; /* BYTE_ORDER_MARK, as the machine that made it writes it */
    int32_t codec_id, width_px, height_px, fps, reorder;
    int32_t first_frame, frame_count, packet_count;
    uint32_t extradata_bytes;
} segment_head; /* followed by hashes[frame_count], extradata, packets */

/* How each packet begins; its data follow. */
typedef struct packet_head {
    int64_t pts;           /* in frames from the beginning of the segment */
    uint32_t flags, bytes; /* libav's AV_PKT_FLAG_*; length of the data */
    uint32_t alpha_bytes;  /* length of the alpha behind the data; 0: none */
    uint32_t unused;       /* 0 */
} packet_head;

/* Make room for @p needed bytes in the array at @p data, the address of a pointer of any type,
 * which has room for *capacity bytes; the first @p used are kept. @return SC_ERR_MEMORY, nothing
 * changed. */
static sc_status grow(const sc_ctx *ctx, void *data, size_t used, size_t *capacity, size_t needed)
{
    size_t larger = *capacity ? *capacity : 4096;

    if (needed <= *capacity)
        return SC_OK;
    while (larger < needed)
        larger *= 2;
    SC_PASS(sc_resize(ctx, used, larger, 1, data));
    *capacity = larger;
    return SC_OK;
}

sc_status sc_segment_add_hash(const sc_ctx *ctx, sc_segment_builder *b, uint64_t hash)
{
    size_t capacity = (size_t)b->hash_capacity * sizeof hash;
    const size_t used = (size_t)b->frames * sizeof hash;

    SC_PASS(grow(ctx, &b->hashes, used, &capacity, used + sizeof hash));
    b->hash_capacity = (int)(capacity / sizeof hash);
    b->hashes[b->frames++] = hash;
    return SC_OK;
}

/* @return the alpha of the picture in a packet, behind its number; NULL if there is none. */
static const AVPacketSideData *alpha_of(const AVPacket *packet)
{
    for (int i = 0; i < packet->side_data_elems; i++) {
        const AVPacketSideData *data = &packet->side_data[i];

        if (data->type == AV_PKT_DATA_MATROSKA_BLOCKADDITIONAL &&
            (size_t)data->size > SC_BLOCK_NUMBER_BYTES)
            return data;
    }
    return NULL;
}

sc_status sc_segment_add_packet(const sc_ctx *ctx, sc_segment_builder *b, const AVPacket *packet)
{
    const AVPacketSideData *alpha = alpha_of(packet);
    const packet_head head = {.pts = packet->pts,
                              .flags = (uint32_t)packet->flags,
                              .bytes = (uint32_t)packet->size,
                              .alpha_bytes =
                                  alpha ? (uint32_t)(alpha->size - SC_BLOCK_NUMBER_BYTES) : 0};
    const size_t more = sizeof head + head.bytes + head.alpha_bytes;

    SC_PASS(grow(ctx, &b->packets, b->bytes, &b->capacity, b->bytes + more));
    memcpy(b->packets + b->bytes, &head, sizeof head);
    memcpy(b->packets + b->bytes + sizeof head, packet->data, head.bytes);
    if (alpha)
        memcpy(b->packets + b->bytes + sizeof head + head.bytes,
               alpha->data + SC_BLOCK_NUMBER_BYTES, head.alpha_bytes);
    b->bytes += more;
    b->packet_count++;
    return SC_OK;
}

/* The hash that belongs into the head of the segment @p data of @p bytes bytes. */
static uint64_t hash_of(const char *data, size_t bytes)
{
    const size_t from = offsetof(segment_head, bytes);

    return sc_hash_bytes(data + from, bytes - from, 0);
}

sc_status sc_segment_build(const sc_ctx *ctx, const sc_segment_builder *b,
                           const AVCodecContext *codec, const char *name, uint64_t identity,
                           int first_frame, sc_segment *out)
{
    segment_head head = {.magic = MAGIC,
                         .identity = identity,
                         .byte_order = BYTE_ORDER_MARK,
                         .codec_id = (int32_t)codec->codec_id,
                         .width_px = codec->width,
                         .height_px = codec->height,
                         .fps = codec->framerate.num,
                         .reorder = codec->has_b_frames,
                         .first_frame = first_frame,
                         .frame_count = b->frames,
                         .packet_count = b->packet_count,
                         .extradata_bytes = (uint32_t)codec->extradata_size};
    const size_t hash_bytes = (size_t)b->frames * sizeof *b->hashes;
    char *to;

    if (b->packet_count != b->frames)
        return sc_fail(
            ctx, SC_ERR_INTERNAL,
            "%s: the encoder made %d packets from %d frames; one packet for each was expected",
            name, b->packet_count, b->frames);
    head.bytes = sizeof head + hash_bytes + head.extradata_bytes + b->bytes;
    SC_PASS(SC_ALLOC(ctx, head.bytes, &to));
    memcpy(to, &head, sizeof head);
    memcpy(to + sizeof head, b->hashes, hash_bytes);
    if (head.extradata_bytes)
        memcpy(to + sizeof head + hash_bytes, codec->extradata, head.extradata_bytes);
    memcpy(to + head.bytes - b->bytes, b->packets, b->bytes);
    head.hash = hash_of(to, head.bytes);
    memcpy(to, &head, sizeof head);
    *out = (sc_segment){.data = to, .bytes = head.bytes};
    return SC_OK;
}

void sc_segment_reset(sc_segment_builder *b)
{
    b->bytes = 0;
    b->frames = b->packet_count = 0;
}

void sc_segment_clear(sc_segment_builder *b)
{
    sc_free(b->packets);
    sc_free(b->hashes);
    *b = (sc_segment_builder){0};
}

void sc_segment_free(sc_segment *segment)
{
    sc_free(segment->data);
    *segment = (sc_segment){0};
}

/* Where the codec's extradata lie in a segment, whose head is @p head; borrowed. */
static const char *extradata_of(const sc_segment *segment, const segment_head *head)
{
    return (const char *)segment->data + sizeof *head + (size_t)head->frame_count * 8;
}

bool sc_segment_next(const sc_segment *segment, size_t *at, sc_segment_packet *out)
{
    segment_head head;
    packet_head packet;
    const char *data;

    memcpy(&head, segment->data, sizeof head);
    if (*at == 0)
        *at = (size_t)(extradata_of(segment, &head) - (const char *)segment->data) +
              head.extradata_bytes;
    if (*at + sizeof packet > segment->bytes)
        return false;
    memcpy(&packet, (const char *)segment->data + *at, sizeof packet);
    if (*at + sizeof packet + packet.bytes + packet.alpha_bytes > segment->bytes)
        return false;
    data = (const char *)segment->data + *at + sizeof packet;
    *out = (sc_segment_packet){.pts = packet.pts,
                               .flags = (int)packet.flags,
                               .data = data,
                               .alpha = data + packet.bytes,
                               .bytes = packet.bytes,
                               .alpha_bytes = packet.alpha_bytes};
    *at += sizeof packet + packet.bytes + packet.alpha_bytes;
    return true;
}

/* @return whether segcast encodes with this codec. */
static bool is_known(int codec_id)
{
    return codec_id == AV_CODEC_ID_H264 || codec_id == AV_CODEC_ID_HEVC ||
           codec_id == AV_CODEC_ID_AV1 || codec_id == AV_CODEC_ID_VP9 ||
           codec_id == AV_CODEC_ID_PRORES || codec_id == AV_CODEC_ID_WEBP ||
           codec_id == AV_CODEC_ID_FFV1;
}

/* @return whether the numbers in the head of a segment can be those of a GOP. */
static bool is_sane(const segment_head *head)
{
    return is_known(head->codec_id) && head->width_px >= 1 && head->width_px <= SIDE_MAX_PX &&
           head->height_px >= 1 && head->height_px <= SIDE_MAX_PX && head->fps >= 1 &&
           head->fps <= FPS_MAX && head->reorder >= 0 && head->reorder <= REORDER_MAX &&
           head->first_frame >= 0 && head->first_frame <= INT32_MAX - FPS_MAX &&
           head->frame_count >= 1 && head->frame_count <= head->fps &&
           head->frame_count == head->packet_count &&
           head->extradata_bytes <= EXTRADATA_MAX_BYTES &&
           (uint64_t)head->frame_count * 8 + head->extradata_bytes + sizeof *head <= head->bytes;
}

/* @return whether the packets of a segment, whose head is sane, fill it exactly, begin with a key
 * frame, and show each frame of the GOP once and none before it can be decoded. */
static bool has_sane_packets(const sc_segment *segment, const segment_head *head)
{
    const int known_flags = AV_PKT_FLAG_KEY | AV_PKT_FLAG_DISPOSABLE;
    bool shown[FPS_MAX] = {false};
    sc_segment_packet p;
    size_t at = 0;

    for (int i = 0; i < head->packet_count; i++) {
        if (!sc_segment_next(segment, &at, &p) || p.bytes < 1 || p.bytes > INT32_MAX / 2 ||
            (p.flags & ~known_flags) || (i == 0 && !(p.flags & AV_PKT_FLAG_KEY)) || p.pts < 0 ||
            p.pts >= head->frame_count || p.pts < i - head->reorder || shown[p.pts] ||
            p.alpha_bytes > (head->codec_id == AV_CODEC_ID_VP9 ? INT32_MAX / 2 : 0) ||
            (head->codec_id == AV_CODEC_ID_WEBP && !sc_webp_is_picture(p.data, p.bytes)))
            return false;
        shown[p.pts] = true;
    }
    return at == segment->bytes;
}

bool sc_segment_inspect(const sc_segment *segment, sc_segment_info *out)
{
    segment_head head;

    if (segment->bytes < sizeof head)
        return false;
    memcpy(&head, segment->data, sizeof head);
    if (memcmp(head.magic, MAGIC, sizeof head.magic) != 0 || head.byte_order != BYTE_ORDER_MARK ||
        head.bytes != segment->bytes || !is_sane(&head) ||
        hash_of(segment->data, segment->bytes) != head.hash ||
        !sc_has_sane_parameters(head.codec_id, extradata_of(segment, &head),
                                head.extradata_bytes) ||
        !has_sane_packets(segment, &head))
        return false;
    *out = (sc_segment_info){.identity = head.identity,
                             .width_px = head.width_px,
                             .height_px = head.height_px,
                             .fps = head.fps,
                             .codec = head.codec_id,
                             .first_frame = head.first_frame,
                             .frame_count = head.frame_count,
                             .hashes = (const void *)((const char *)segment->data + sizeof head)};
    return true;
}

void sc_segment_describe(const sc_segment *segment, sc_segment_codec *out)
{
    segment_head head;

    memcpy(&head, segment->data, sizeof head);
    *out = (sc_segment_codec){.codec_id = head.codec_id,
                              .width_px = head.width_px,
                              .height_px = head.height_px,
                              .fps = head.fps,
                              .reorder = head.reorder,
                              .extradata = extradata_of(segment, &head),
                              .extradata_bytes = head.extradata_bytes};
}
