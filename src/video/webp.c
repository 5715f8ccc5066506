/* SPDX-License-Identifier: BSD-3-Clause */
/* Animated WebP files (WebP Container Specification, developers.google.com/speed/webp/docs/
 * riff_container): written from frames that are WebP files of one picture each, and taken apart
 * into such. Every frame fills the canvas and replaces the one before it, so that any can be
 * decoded by itself; libavformat's muxer would lay transparent frames over each other. */
#include "internal.h"

#include <errno.h>
#include <limits.h>

enum {
    TAG_BYTES = 4,
    HEAD_BYTES = 8,       /* of a chunk: its tag and its length */
    FILE_HEAD_BYTES = 12, /* "RIFF", length, "WEBP" */
    CANVAS_BYTES = 10,    /* the data of VP8X */
    LOOP_BYTES = 6,       /* the data of ANIM */
    FRAME_BYTES = 16,     /* the data of ANMF before the picture */
    FLAG_ANIMATION = 0x02,
    FLAG_XMP = 0x04,
    FLAG_ALPHA = 0x10,
    DO_NOT_BLEND = 0x02 /* of a frame */
};

static void put_16(uint8_t *to, unsigned value)
{
    to[0] = (uint8_t)value;
    to[1] = (uint8_t)(value >> 8);
}

static void put_24(uint8_t *to, unsigned value)
{
    put_16(to, value);
    to[2] = (uint8_t)(value >> 16);
}

static void put_32(uint8_t *to, uint32_t value)
{
    put_16(to, value & 0xffff);
    put_16(to + 2, value >> 16);
}

static uint32_t get_24(const uint8_t *from)
{
    return from[0] | (uint32_t)from[1] << 8 | (uint32_t)from[2] << 16;
}

static uint32_t get_32(const uint8_t *from)
{
    return get_24(from) | (uint32_t)from[3] << 24;
}

/* Begin a chunk at @p to: its tag and the length of its data. */
static void put_head(uint8_t *to, const char *tag, uint32_t bytes)
{
    memcpy(to, tag, TAG_BYTES);
    put_32(to + TAG_BYTES, bytes);
}

/* ---- pictures ---- */

/* A chunk of a picture; data are borrowed. */
typedef struct chunk {
    const uint8_t *tag; /* where it begins */
    const uint8_t *data;
    uint32_t bytes; /* of the data */
} chunk;

/* Read the chunk at offset *at of @p data, of @p bytes bytes, and move *at behind it and its
 * padding. @return false if there is no whole one. */
static bool next_chunk(const uint8_t *data, size_t bytes, size_t *at, chunk *out)
{
    uint32_t length;

    if (*at > bytes || bytes - *at < HEAD_BYTES)
        return false;
    length = get_32(data + *at + TAG_BYTES);
    if (length > bytes - *at - HEAD_BYTES)
        return false;
    *out = (chunk){data + *at, data + *at + HEAD_BYTES, length};
    *at += HEAD_BYTES + (size_t)length + (length & 1);
    return true;
}

static bool is_tag(const chunk *c, const char *tag)
{
    return !memcmp(c->tag, tag, TAG_BYTES);
}

bool sc_webp_is_picture(const void *data, size_t bytes)
{
    const uint8_t *file = data;
    size_t at = FILE_HEAD_BYTES;
    int pictures = 0;
    chunk c;

    if (bytes < FILE_HEAD_BYTES || memcmp(file, "RIFF", TAG_BYTES) != 0 ||
        memcmp(file + HEAD_BYTES, "WEBP", TAG_BYTES) != 0)
        return false;
    while (at < bytes) {
        if (!next_chunk(file, bytes, &at, &c) ||
            !(is_tag(&c, "VP8X") || is_tag(&c, "ALPH") || is_tag(&c, "VP8 ") || is_tag(&c, "VP8L")))
            return false;
        pictures += is_tag(&c, "VP8 ") || is_tag(&c, "VP8L");
    }
    return pictures == 1;
}

/* ---- writing ---- */

static sc_status fail_writing(const sc_ctx *ctx, const char *path)
{
    return sc_fail(ctx, SC_ERR_WRITE, "%s: cannot be written: %s", path, sc_reason(errno));
}

sc_status sc_webp_begin(const sc_ctx *ctx, sc_webp *w, const char *path)
{
    /* The head is written again when all is known. */
    static const uint8_t room[FILE_HEAD_BYTES + 2 * HEAD_BYTES + CANVAS_BYTES + LOOP_BYTES] = {0};

    w->bytes = sizeof room;
    if (fwrite(room, 1, sizeof room, w->stream) != sizeof room)
        return fail_writing(ctx, path);
    return SC_OK;
}

/* Write @p bytes bytes, and a byte more if their number is odd. @return false with errno set. */
static bool write_padded(sc_webp *w, const void *data, size_t bytes)
{
    w->bytes += bytes + (bytes & 1);
    return fwrite(data, 1, bytes, w->stream) == bytes && (!(bytes & 1) || fputc(0, w->stream) >= 0);
}

/* When frame @p k begins, in milliseconds. */
static int64_t begin_ms(int64_t k, int fps)
{
    return (k * 1000 + fps / 2) / fps;
}

sc_status sc_webp_add(const sc_ctx *ctx, sc_webp *w, const char *path, const void *data,
                      size_t bytes)
{
    uint8_t head[HEAD_BYTES + FRAME_BYTES] = {0};
    size_t at = FILE_HEAD_BYTES, picture_bytes = 0;
    bool ok;
    chunk c;

    while (next_chunk(data, bytes, &at, &c))
        picture_bytes += is_tag(&c, "VP8X") ? 0 : HEAD_BYTES + c.bytes + (c.bytes & 1);
    if (w->bytes + picture_bytes + sizeof head > UINT32_MAX - (1 << 16))
        return sc_fail(ctx, SC_ERR_WRITE,
                       "%s: frame %lld does not fit: a WebP file holds at most 4 GiB; choose fewer "
                       "or smaller frames, a larger crf, or a video (.webm)",
                       path, (long long)w->frames);
    put_head(head, "ANMF", (uint32_t)(FRAME_BYTES + picture_bytes));
    put_24(head + HEAD_BYTES + 6, (unsigned)w->width_px - 1);
    put_24(head + HEAD_BYTES + 9, (unsigned)w->height_px - 1);
    put_24(head + HEAD_BYTES + 12,
           (unsigned)(begin_ms(w->frames + 1, w->fps) - begin_ms(w->frames, w->fps)));
    head[HEAD_BYTES + 15] = DO_NOT_BLEND;
    ok = write_padded(w, head, sizeof head);
    for (at = FILE_HEAD_BYTES; ok && next_chunk(data, bytes, &at, &c);) {
        if (!is_tag(&c, "VP8X"))
            ok = write_padded(w, c.tag, HEAD_BYTES + (size_t)c.bytes);
    }
    w->frames++;
    return ok ? SC_OK : fail_writing(ctx, path);
}

/* Append a text as the content of an XML element. */
static sc_status add_escaped(const sc_ctx *ctx, sc_text *xml, const char *text)
{
    for (const char *c = text; *c; c++)
        SC_PASS(*c == '&'   ? sc_text_add(ctx, xml, "&amp;")
                : *c == '<' ? sc_text_add(ctx, xml, "&lt;")
                : *c == '>' ? sc_text_add(ctx, xml, "&gt;")
                            : sc_text_add(ctx, xml, "%c", *c));
    return SC_OK;
}

/* Append an element of Dublin Core, whose values stand in a list of kind @p list, unless @p text is
 * empty. */
static sc_status add_element(const sc_ctx *ctx, sc_text *xml, const char *name, const char *list,
                             const char *text)
{
    const char *language = strcmp(list, "Alt") ? "" : " xml:lang=\"x-default\"";

    if (!text[0])
        return SC_OK;
    SC_PASS(sc_text_add(ctx, xml, "<dc:%s><rdf:%s><rdf:li%s>", name, list, language));
    SC_PASS(add_escaped(ctx, xml, text));
    return sc_text_add(ctx, xml, "</rdf:li></rdf:%s></dc:%s>", list, name);
}

/* Write title, author and comment as XMP. Does nothing if all are empty. */
static sc_status write_metadata(const sc_ctx *ctx, sc_webp *w, const char *path,
                                const sc_metadata *about)
{
    uint8_t head[HEAD_BYTES];
    SC_OWN(sc_text_clear) sc_text xml = {0};

    if (!about->title[0] && !about->author[0] && !about->comment[0])
        return SC_OK;
    SC_PASS(
        sc_text_add(ctx, &xml,
                    "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\"><rdf:RDF "
                    "xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\"><rdf:Description "
                    "xmlns:dc=\"http://purl.org/dc/elements/1.1/\">"));
    SC_PASS(add_element(ctx, &xml, "title", "Alt", about->title));
    SC_PASS(add_element(ctx, &xml, "creator", "Seq", about->author));
    SC_PASS(add_element(ctx, &xml, "description", "Alt", about->comment));
    SC_PASS(sc_text_add(ctx, &xml, "</rdf:Description></rdf:RDF></x:xmpmeta>"));
    put_head(head, "XMP ", (uint32_t)xml.length_bytes);
    w->has_metadata = true;
    if (!write_padded(w, head, sizeof head) || !write_padded(w, xml.data, xml.length_bytes))
        return fail_writing(ctx, path);
    return SC_OK;
}

sc_status sc_webp_end(const sc_ctx *ctx, sc_webp *w, const char *path, const sc_metadata *about)
{
    uint8_t head[FILE_HEAD_BYTES + 2 * HEAD_BYTES + CANVAS_BYTES + LOOP_BYTES] = {0};
    uint8_t *canvas = head + FILE_HEAD_BYTES, *loop = canvas + HEAD_BYTES + CANVAS_BYTES;

    SC_PASS(write_metadata(ctx, w, path, about));
    put_head(head, "RIFF", (uint32_t)(w->bytes - HEAD_BYTES));
    memcpy(head + HEAD_BYTES, "WEBP", TAG_BYTES);
    put_head(canvas, "VP8X", CANVAS_BYTES);
    canvas[HEAD_BYTES] =
        (uint8_t)(FLAG_ANIMATION | (w->alpha ? FLAG_ALPHA : 0) | (w->has_metadata ? FLAG_XMP : 0));
    put_24(canvas + HEAD_BYTES + 4, (unsigned)w->width_px - 1);
    put_24(canvas + HEAD_BYTES + 7, (unsigned)w->height_px - 1);
    put_head(loop, "ANIM", LOOP_BYTES); /* shown again and again: the number of times is 0 */
    if (fflush(w->stream) || fseeko(w->stream, 0, SEEK_SET) ||
        fwrite(head, 1, sizeof head, w->stream) != sizeof head || fflush(w->stream))
        return fail_writing(ctx, path);
    return SC_OK;
}

/* ---- reading ---- */

bool sc_webp_open(sc_webp_reader *r, FILE *stream)
{
    uint8_t head[FILE_HEAD_BYTES + HEAD_BYTES + CANVAS_BYTES];
    const uint8_t *canvas = head + FILE_HEAD_BYTES;

    *r = (sc_webp_reader){.stream = stream};
    if (fread(head, 1, sizeof head, stream) != sizeof head ||
        memcmp(head, "RIFF", TAG_BYTES) != 0 || memcmp(head + HEAD_BYTES, "WEBPVP8X", 8) != 0 ||
        !(canvas[HEAD_BYTES] & FLAG_ANIMATION))
        return false;
    r->bytes = (int64_t)get_32(head + TAG_BYTES) + HEAD_BYTES;
    r->at = (int64_t)sizeof head;
    r->first = r->at;
    r->alpha = canvas[HEAD_BYTES] & FLAG_ALPHA;
    memcpy(r->canvas, canvas, sizeof r->canvas);
    r->canvas[HEAD_BYTES] = r->alpha ? FLAG_ALPHA : 0;
    return true;
}

void sc_webp_rewind(sc_webp_reader *r)
{
    r->at = r->first;
    r->time_ms = 0;
}

/* Fill @p packet with a frame, whose ANMF chunk has @p bytes bytes of data from the place of the
 * file on: the picture as a file of its own. @return 0, or libav's code of an error. */
static int read_frame(sc_webp_reader *r, uint32_t bytes, AVPacket *packet)
{
    const size_t room = FILE_HEAD_BYTES + sizeof r->canvas;
    uint8_t head[FRAME_BYTES];
    int error;

    if (bytes <= FRAME_BYTES || bytes > INT_MAX / 2 ||
        fread(head, 1, sizeof head, r->stream) != sizeof head)
        return AVERROR_INVALIDDATA;
    bytes -= FRAME_BYTES;
    error = sc_av->av_new_packet(packet, (int)(room + bytes));
    if (error < 0)
        return error;
    put_head(packet->data, "RIFF", (uint32_t)(room + bytes - HEAD_BYTES));
    memcpy(packet->data + HEAD_BYTES, "WEBP", TAG_BYTES);
    memcpy(packet->data + FILE_HEAD_BYTES, r->canvas, sizeof r->canvas);
    packet->pts = packet->dts = r->time_ms;
    packet->duration = get_24(head + 12);
    packet->flags = AV_PKT_FLAG_KEY;
    r->time_ms += packet->duration;
    if (fread(packet->data + room, 1, bytes, r->stream) == bytes)
        return 0;
    sc_av->av_packet_unref(packet);
    return AVERROR_INVALIDDATA;
}

int sc_webp_read(sc_webp_reader *r, AVPacket *packet)
{
    uint8_t head[HEAD_BYTES];

    while (r->at < r->bytes) {
        uint32_t bytes;
        bool is_frame;

        if (fseeko(r->stream, (off_t)r->at, SEEK_SET) ||
            fread(head, 1, sizeof head, r->stream) != sizeof head)
            return AVERROR_INVALIDDATA;
        bytes = get_32(head + TAG_BYTES);
        is_frame = !memcmp(head, "ANMF", TAG_BYTES);
        r->at += HEAD_BYTES + (int64_t)bytes + (bytes & 1);
        if (r->at > r->bytes)
            return AVERROR_INVALIDDATA;
        if (is_frame)
            return read_frame(r, bytes, packet);
    }
    return AVERROR_EOF;
}
