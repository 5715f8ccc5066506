/* SPDX-License-Identifier: BSD-3-Clause */
/* GIF files: one palette of 256 colours for the whole film, so that none changes its shade from
 * frame to frame. It is known only when all frames were seen. So frames come as packets of FFV1,
 * which loses nothing, are decoded for libavfilter's palettegen and kept in a file without a name;
 * at the end they are decoded again, get the colours of the palette by paletteuse, and are encoded.
 * Colours between two of the palette are dithered by a fixed pattern (Bayer): one that depends on
 * neighbours would flicker. Memory: a few frames, and some bytes for each colour that occurs. */
#include "internal.h"

#include <errno.h>
#include <limits.h>

enum { BLOCK_MAX_BYTES = 255, EXTENSION = 0x21, COMMENT = 0xfe, TRAILER = 0x3b };

/* Write a text as a comment, in blocks with their lengths (GIF89a Specification, 24). @return false
 * with errno set. */
static bool write_comment(FILE *stream, const char *text)
{
    size_t left = strlen(text);
    bool ok = fputc(EXTENSION, stream) >= 0 && fputc(COMMENT, stream) >= 0;

    for (; ok && left > 0; text += BLOCK_MAX_BYTES) {
        const size_t bytes = left < BLOCK_MAX_BYTES ? left : BLOCK_MAX_BYTES;

        ok = fputc((int)bytes, stream) >= 0 && fwrite(text, 1, bytes, stream) == bytes;
        left -= bytes;
    }
    return ok && fputc(0, stream) >= 0;
}

sc_status sc_gif_describe(const sc_ctx *ctx, const char *path, FILE *stream,
                          const sc_metadata *about)
{
    const char *const texts[] = {about->title, about->author, about->comment};
    bool ok = !fseeko(stream, -1, SEEK_END);

    for (size_t i = 0; ok && i < SC_COUNT_OF(texts); i++)
        ok = !texts[i][0] || write_comment(stream, texts[i]);
    return ok && fputc(TRAILER, stream) >= 0 && !fflush(stream)
               ? SC_OK
               : sc_fail(ctx, SC_ERR_WRITE, "%s: cannot be written: %s", path, sc_reason(errno));
}

bool sc_gif_is_possible(void)
{
    return sc_libavfilter_is_here() && sc_filters->avfilter_get_by_name("palettegen") &&
           sc_filters->avfilter_get_by_name("paletteuse") &&
           sc_av->avcodec_find_encoder(AV_CODEC_ID_GIF) &&
           sc_av->avcodec_find_decoder(AV_CODEC_ID_FFV1);
}

/* Frames are shown at multiples of this. */
static const AVRational tick = {1, 100};

/* A graph of one filter: frames go into its sources and come out of its sink. */
typedef struct graph {
    AVFilterGraph *graph; /* NULL: not open */
    AVFilterContext *sources[2], *sink;
} graph;

struct sc_gif {
    const sc_ctx *ctx;
    const char *path;       /* for messages; borrowed, as is ctx */
    sc_outfile kept;        /* packets, each behind its length; never completed */
    AVCodecContext *reader; /* decodes them */
    AVCodecContext *writer; /* encodes the GIF */
    AVPacket *packet;
    AVFrame *frame;
    graph palette, colors; /* makes the palette; gives frames its colours */
    AVStream *stream;      /* of the GIF; borrowed */
    int fps;
    int64_t frames; /* seen so far */
};

static sc_status no_memory(const sc_gif *g)
{
    return sc_fail(g->ctx, SC_ERR_MEMORY, "%s: out of memory", g->path);
}

/* Log what libav could not do. */
static sc_status fail_av(const sc_gif *g, const char *what, int error)
{
    return sc_av_fail(g->ctx, SC_ERR_INTERNAL, g->path, what, error);
}

sc_status sc_gif_open(const sc_ctx *ctx, const char *path, sc_gif **out)
{
    SC_OWN(sc_gif_close_at) sc_gif *g = NULL;

    if (!sc_gif_is_possible())
        return sc_fail(ctx, SC_ERR_CREATE, "%s: libavfilter cannot be loaded", path);
    SC_PASS(SC_ZALLOC(ctx, 1, &g));
    g->ctx = ctx;
    g->path = path;
    g->packet = sc_av->av_packet_alloc();
    g->frame = sc_av->av_frame_alloc();
    if (!g->packet || !g->frame)
        return no_memory(g);
    SC_PASS(sc_outfile_open(ctx, path, true, &g->kept));
    SC_HAND_OVER(g, out);
    return SC_OK;
}

/* Add a source or the sink of @p kind under @p name to a graph. @return 0, or libav's code of an
 * error. */
static int add_end(graph *to, const char *kind, const char *name, const char *arguments,
                   AVFilterContext **out)
{
    return sc_filters->avfilter_graph_create_filter(out, sc_filters->avfilter_get_by_name(kind),
                                                    name, arguments, NULL, to->graph);
}

/* Make a graph of the filter @p name. @param second it has a second input, a palette. */
static sc_status open_graph(const sc_gif *g, const char *name, const char *arguments, bool second,
                            graph *out)
{
    const int width_px = g->reader->width, height_px = g->reader->height;
    AVFilterContext *filter = NULL;
    char frames[128], palette[128];
    int error;

    snprintf(frames, sizeof frames, "width=%d:height=%d:pix_fmt=%d:time_base=%d/%d", width_px,
             height_px, AV_PIX_FMT_RGB32, tick.num, tick.den);
    snprintf(palette, sizeof palette, "width=16:height=16:pix_fmt=%d:time_base=%d/%d",
             AV_PIX_FMT_RGB32, tick.num, tick.den);
    out->graph = sc_filters->avfilter_graph_alloc();
    if (!out->graph)
        return no_memory(g);
    out->graph->nb_threads = 1;
    error = add_end(out, name, "filter", arguments, &filter);
    error = error < 0 ? error : add_end(out, "buffer", "frames", frames, &out->sources[0]);
    error = error < 0 ? error : sc_filters->avfilter_link(out->sources[0], 0, filter, 0);
    if (second) {
        error = error < 0 ? error : add_end(out, "buffer", "palette", palette, &out->sources[1]);
        error = error < 0 ? error : sc_filters->avfilter_link(out->sources[1], 0, filter, 1);
    }
    error = error < 0 ? error : add_end(out, "buffersink", "sink", NULL, &out->sink);
    error = error < 0 ? error : sc_filters->avfilter_link(filter, 0, out->sink, 0);
    error = error < 0 ? error : sc_filters->avfilter_graph_config(out->graph, NULL);
    return error < 0 ? fail_av(g, "the filter of the palette cannot be made", error) : SC_OK;
}

/* Open the decoder of the packets, and the filter that makes the palette. */
static sc_status begin(sc_gif *g, const sc_segment_codec *codec)
{
    const AVCodec *ffv1 = sc_av->avcodec_find_decoder(AV_CODEC_ID_FFV1);
    int error;

    g->fps = codec->fps;
    g->reader = sc_av->avcodec_alloc_context3(ffv1);
    if (!g->reader)
        return no_memory(g);
    g->reader->width = codec->width_px;
    g->reader->height = codec->height_px;
    g->reader->thread_count = 1;
    error = sc_av->avcodec_open2(g->reader, ffv1, NULL);
    if (error < 0)
        return fail_av(g, "the decoder of FFV1 cannot be opened", error);
    return open_graph(g, "palettegen", "stats_mode=full", false, &g->palette);
}

/* Decode g->packet, of frame number @p k, to g->frame, and clear it. @return SC_ERR_DATA. */
static sc_status decode(sc_gif *g, int64_t k)
{
    int error = sc_av->avcodec_send_packet(g->reader, g->packet);

    sc_av->av_packet_unref(g->packet);
    error = error < 0 ? error : sc_av->avcodec_receive_frame(g->reader, g->frame);
    if (error < 0 || g->frame->width != g->reader->width || g->frame->format != AV_PIX_FMT_RGB32)
        return sc_fail(g->ctx, SC_ERR_DATA, "%s: frame %lld in a segment cannot be decoded",
                       g->path, (long long)k);
    g->frame->pts = sc_av->av_rescale_q(k, (AVRational){1, g->fps}, tick);
    g->frame->pict_type = AV_PICTURE_TYPE_NONE;
    return SC_OK;
}

sc_status sc_gif_add(sc_gif *g, const sc_segment_codec *codec, const void *data, size_t bytes)
{
    const uint32_t length = (uint32_t)bytes;
    int error;

    if (!g->reader)
        SC_PASS(begin(g, codec));
    if (fwrite(&length, 1, sizeof length, g->kept.stream) != sizeof length ||
        fwrite(data, 1, bytes, g->kept.stream) != bytes)
        return sc_fail(g->ctx, SC_ERR_WRITE,
                       "%s: the frames of which the GIF is made cannot be written beside it: %s",
                       g->path, sc_reason(errno));
    if (sc_av->av_new_packet(g->packet, (int)bytes) < 0)
        return no_memory(g);
    memcpy(g->packet->data, data, bytes);
    SC_PASS(decode(g, g->frames++));
    /* Pushed, or all frames would wait in the graph. */
    error = sc_filters->av_buffersrc_add_frame_flags(g->palette.sources[0], g->frame,
                                                     AV_BUFFERSRC_FLAG_PUSH);
    if (error < 0)
        return fail_av(g, "the colours of a frame cannot be counted", error);
    return SC_OK;
}

/* ---- the second time ---- */

/* Make the palette, and the filter that uses it. */
static sc_status make_palette(sc_gif *g)
{
    int error = sc_filters->av_buffersrc_add_frame(g->palette.sources[0], NULL);

    error = error < 0 ? error : sc_filters->av_buffersink_get_frame(g->palette.sink, g->frame);
    if (error < 0)
        return fail_av(g, "the palette cannot be made", error);
    sc_filters->avfilter_graph_free(&g->palette.graph);
    SC_PASS(open_graph(g, "paletteuse", "dither=bayer:bayer_scale=3", true, &g->colors));
    g->frame->pts = 0;
    error = sc_filters->av_buffersrc_add_frame(g->colors.sources[1], g->frame);
    error = error < 0 ? error : sc_filters->av_buffersrc_add_frame(g->colors.sources[1], NULL);
    if (error < 0)
        return fail_av(g, "the palette cannot be used", error);
    return SC_OK;
}

/* Open the encoder of the GIF, and write the head of the file. */
static sc_status begin_file(sc_gif *g, AVFormatContext *format)
{
    const AVCodec *gif = sc_av->avcodec_find_encoder(AV_CODEC_ID_GIF);
    int error;

    g->writer = sc_av->avcodec_alloc_context3(gif);
    g->stream = sc_av->avformat_new_stream(format, NULL);
    if (!g->writer || !g->stream)
        return no_memory(g);
    g->writer->width = g->reader->width;
    g->writer->height = g->reader->height;
    g->writer->pix_fmt = AV_PIX_FMT_PAL8;
    g->writer->time_base = g->stream->time_base = tick;
    g->writer->thread_count = 1;
    g->writer->flags |= AV_CODEC_FLAG_BITEXACT;
    format->flags |= AVFMT_FLAG_BITEXACT;
    error = sc_av->avcodec_open2(g->writer, gif, NULL);
    error =
        error < 0 ? error : sc_av->avcodec_parameters_from_context(g->stream->codecpar, g->writer);
    error = error < 0 ? error : sc_av->avformat_write_header(format, NULL);
    return error < 0 ? fail_av(g, "the encoder of GIF cannot be opened", error) : SC_OK;
}

/* Encode a frame with the colours of the palette, NULL for the end, and write what is ready. */
static sc_status encode(sc_gif *g, AVFormatContext *format, const AVFrame *frame)
{
    int error = sc_av->avcodec_send_frame(g->writer, frame);

    while (error >= 0) {
        error = sc_av->avcodec_receive_packet(g->writer, g->packet);
        if (error == AVERROR(EAGAIN) || error == AVERROR_EOF)
            return SC_OK;
        if (error < 0)
            break;
        sc_av->av_packet_rescale_ts(g->packet, tick, g->stream->time_base);
        g->packet->stream_index = g->stream->index;
        error = sc_av->av_write_frame(format, g->packet);
        sc_av->av_packet_unref(g->packet);
        if (error >= 0 && format->pb->error < 0)
            error = format->pb->error;
        if (error < 0)
            return sc_av_fail(g->ctx, SC_ERR_WRITE, g->path, "cannot be written", error);
    }
    return fail_av(g, "a frame cannot be encoded", error);
}

/* Encode all frames that come out of the filter. */
static sc_status encode_ready(sc_gif *g, AVFormatContext *format)
{
    int error = 0;
    sc_status status = SC_OK;

    while (status == SC_OK &&
           (error = sc_filters->av_buffersink_get_frame(g->colors.sink, g->frame)) >= 0) {
        status = encode(g, format, g->frame);
        sc_av->av_frame_unref(g->frame);
    }
    if (status == SC_OK && error != AVERROR(EAGAIN) && error != AVERROR_EOF)
        status = fail_av(g, "a frame cannot get the colours of the palette", error);
    return status;
}

/* Read the next packet that was kept into g->packet. */
static sc_status read_kept(sc_gif *g)
{
    uint32_t length;

    if (fread(&length, 1, sizeof length, g->kept.stream) != sizeof length || length > INT_MAX / 2 ||
        sc_av->av_new_packet(g->packet, (int)length) < 0 ||
        fread(g->packet->data, 1, length, g->kept.stream) != length)
        return sc_fail(g->ctx, SC_ERR_WRITE,
                       "%s: the frames that were kept beside it cannot be read again", g->path);
    return SC_OK;
}

sc_status sc_gif_finish(sc_gif *g, AVFormatContext *format)
{
    sc_stage_begin(g->ctx, "writing the GIF", 0, (uint64_t)g->frames);
    if (fflush(g->kept.stream) || fseeko(g->kept.stream, 0, SEEK_SET))
        return sc_fail(g->ctx, SC_ERR_WRITE, "%s: the frames beside it cannot be written: %s",
                       g->path, sc_reason(errno));
    SC_PASS(make_palette(g));
    SC_PASS(begin_file(g, format));
    for (int64_t k = 0; k < g->frames; k++) {
        int error;

        SC_PASS(read_kept(g));
        SC_PASS(decode(g, k));
        error = sc_filters->av_buffersrc_add_frame(g->colors.sources[0], g->frame);
        if (error < 0)
            return fail_av(g, "a frame cannot get the colours of the palette", error);
        SC_PASS(encode_ready(g, format));
        sc_stage_add(g->ctx, 1);
    }
    if (sc_filters->av_buffersrc_add_frame(g->colors.sources[0], NULL) < 0)
        return no_memory(g);
    SC_PASS(encode_ready(g, format));
    return encode(g, format, NULL);
}

void sc_gif_close(sc_gif *g)
{
    if (!g)
        return;
    sc_filters->avfilter_graph_free(&g->palette.graph);
    sc_filters->avfilter_graph_free(&g->colors.graph);
    sc_av->avcodec_free_context(&g->reader);
    sc_av->avcodec_free_context(&g->writer);
    sc_av->av_packet_free(&g->packet);
    sc_av->av_frame_free(&g->frame);
    sc_outfile_discard(&g->kept);
    sc_free(g);
}
