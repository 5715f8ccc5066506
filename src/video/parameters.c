/* SPDX-License-Identifier: BSD-3-Clause */
/* The parameter sets of H.264 (Rec. ITU-T H.264, 7.3.1 and 7.3.2.1), H.265 (Rec. ITU-T
 * H.265, 7.3.1) and AV1 (AV1 Bitstream & Decoding Process Specification, 5.3) as x264, x265 and
 * libaom write them.
 */
#include "internal.h"

enum { NAL_SEQUENCE_SET = 7, NAL_PICTURE_SET = 8 };
/* Of H.265: the types of NAL units, and the first byte of an OBU of AV1 that holds a sequence
 * header with its length. */
enum { H265_VIDEO_SET = 32, H265_SEQUENCE_SET = 33, H265_PICTURE_SET = 34, OBU_SEQUENCE = 0x0a };

/* The bits of a NAL unit behind its first byte. Beyond the end all are 0. */
typedef struct bits {
    const uint8_t *bytes;
    size_t count, at; /* in bits */
} bits;

static unsigned read_bit(bits *b)
{
    const size_t at = b->at++;

    return at < b->count ? b->bytes[at / 8] >> (7 - at % 8) & 1u : 0;
}

static unsigned read_bits(bits *b, int count)
{
    unsigned value = 0;

    for (int i = 0; i < count; i++)
        value = value << 1 | read_bit(b);
    return value;
}

/* @return an unsigned Exp-Golomb number; UINT32_MAX if it has more than 16 bits, which none that is
 * read here has. */
static unsigned read_golomb(bits *b)
{
    int zeros = 0;

    while (!read_bit(b)) {
        if (++zeros > 16)
            return UINT32_MAX;
    }
    return (1u << zeros) - 1 + read_bits(b, zeros);
}

/* Read what precedes log2_max_frame_num in a sequence parameter set. @return whether it is that of
 * 8 bits, 4:2:0, without scaling matrices. */
static bool read_format(bits *b)
{
    const unsigned profile = read_bits(b, 8);

    read_bits(b, 16); /* constraints and level */
    if (read_golomb(b) > 31)
        return false; /* number of the set */
    if (profile == 66 || profile == 77 || profile == 88)
        return true; /* these have nothing else */
    return profile == 100 && read_golomb(b) == 1 && read_golomb(b) == 0 && read_golomb(b) == 0 &&
           read_bits(b, 2) == 0;
}

/* @return whether a sequence parameter set says how pictures are ordered without a list of offsets
 * (pic_order_cnt_type 1): libavformat reads as many as are announced, which may be four billion.
 * x264 writes types 0 and 2. */
static bool is_sane_sequence_set(const uint8_t *nal, size_t bytes)
{
    bits b = {nal + 1, (bytes - 1) * 8, 0};
    unsigned order;

    if (!read_format(&b) || read_golomb(&b) > 12)
        return false;
    order = read_golomb(&b);
    if ((order != 0 && order != 2) || b.at > b.count)
        return false;
    /* A byte behind two zeros, which keeps parameters from looking like a start code, would have
     * shifted what was read. x264 writes none before the size of the picture. */
    for (size_t i = 0; i + 1 < b.at / 8; i++) {
        if (b.bytes[i] == 0 && b.bytes[i + 1] == 0)
            return false;
    }
    return true;
}

/* @return where the next start code, 0 0 1, begins in bytes[at, end), or @p end. */
static size_t find_start(const uint8_t *bytes, size_t at, size_t end)
{
    while (at + 3 <= end && memcmp(bytes + at, "\0\0\1", 3) != 0)
        at++;
    return at + 3 <= end ? at : end;
}

/* @return whether these are parameter sets of H.264 behind start codes. */
static bool is_sane_h264(const void *extradata, size_t bytes)
{
    const uint8_t *data = extradata;
    size_t at = find_start(data, 0, bytes);
    int sequence_sets = 0, picture_sets = 0;

    if (at > 1 || (at == 1 && data[0] != 0)) /* a start code of three bytes, or of four */
        return false;
    while (at < bytes) {
        const size_t begin = at + 3, end = find_start(data, begin, bytes);

        if (end <= begin)
            return false;
        if (data[begin] >> 7 == 0 && (data[begin] & 31) == NAL_SEQUENCE_SET) {
            if (!is_sane_sequence_set(data + begin, end - begin))
                return false;
            sequence_sets++;
        } else if (data[begin] >> 7 == 0 && (data[begin] & 31) == NAL_PICTURE_SET) {
            picture_sets++;
        } else {
            return false;
        }
        at = end;
    }
    return sequence_sets == 1 && picture_sets >= 1;
}

/* @return whether these are one set of each kind of H.265 behind start codes, in their order.
 * libavformat parses them with limits of its own. */
static bool is_sane_h265(const uint8_t *data, size_t bytes)
{
    size_t at = find_start(data, 0, bytes);
    int expected = H265_VIDEO_SET;

    if (at > 1 || (at == 1 && data[0] != 0)) /* a start code of three bytes, or of four */
        return false;
    while (at < bytes) {
        const size_t begin = at + 3, end = find_start(data, begin, bytes);

        if (end < begin + 3 || data[begin] != expected << 1 || expected > H265_PICTURE_SET)
            return false;
        expected++;
        at = end;
    }
    return expected > H265_PICTURE_SET;
}

/* @return whether these are one OBU with a sequence header of AV1. */
static bool is_sane_av1(const uint8_t *data, size_t bytes)
{
    return bytes > 2 && bytes < 128 && data[0] == OBU_SEQUENCE && data[1] == bytes - 2;
}

bool sc_has_sane_parameters(int codec_id, const void *extradata, size_t bytes)
{
    switch (codec_id) {
    case AV_CODEC_ID_H264:
        return is_sane_h264(extradata, bytes);
    case AV_CODEC_ID_HEVC:
        return is_sane_h265(extradata, bytes);
    case AV_CODEC_ID_AV1:
        return is_sane_av1(extradata, bytes);
    default:
        return bytes == 0;
    }
}
