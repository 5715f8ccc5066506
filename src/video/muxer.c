/* SPDX-License-Identifier: BSD-3-Clause */
/* Joins segments to a video file; nothing is encoded again. */
#include "internal.h"

#include <errno.h>

struct sc_muxer {
    char *path;      /* given to sc_muxer_open; owned */
    sc_outfile file; /* zero once it has got its final name */
    const sc_container *container;
    bool alpha;     /* the pictures have it */
    bool spherical; /* they show all directions */
    bool begun;     /* the header of the file has been written */
    AVFormatContext *format;
    AVStream *stream;       /* borrowed from format; NULL until begun */
    AVPacket *packet;       /* scratch of add_packet */
    sc_segment_codec codec; /* that of the first segment; extradata is borrowed from the stream */
    int64_t frames;         /* number of frames in the segments that are complete so far */
    int64_t packets;        /* number of packets written so far */
    sc_metadata about;
    sc_gif *gif;  /* writes the frames of a GIF at the end; NULL for others; owned */
    bool is_webp; /* webp writes the file, not libav */
    sc_webp webp;
};

/* Copy a text without control characters; NULL gives "". */
static void copy_text(const char *text, char *to, size_t bytes)
{
    (void)sc_copy_name(text ? text : "", to, bytes);
}

/* Gather the metadata: title and author, and what the film was made of, by hashes, so that nothing
 * of a patient is told. */
static void describe(const sc_video_settings *settings, sc_metadata *about)
{
    copy_text(settings->title, about->title, sizeof about->title);
    copy_text(settings->author, about->author, sizeof about->author);
    if (settings->version)
        snprintf(about->comment, sizeof about->comment,
                 "segcast %.60s, job %016llx, volume %016llx", settings->version,
                 (unsigned long long)settings->job_hash, (unsigned long long)settings->volume_hash);
}

/* Set one text of the metadata of libav, unless it is empty. @return false when out of memory. */
static bool set_text(AVFormatContext *format, const char *name, const char *text)
{
    return !text[0] || sc_av->av_dict_set(&format->metadata, name, text, 0) >= 0;
}

/* Add a chapter. libav frees what is added, with the format. @return false when out of memory. */
static bool add_chapter(AVFormatContext *format, const sc_video_chapter *chapter, int fps)
{
    AVChapter **grown =
        sc_av->av_realloc_array(format->chapters, format->nb_chapters + 1, sizeof *grown);
    AVChapter *added = grown ? sc_av->av_mallocz(sizeof *added) : NULL;
    char clean[1024];

    if (grown)
        format->chapters = grown;
    if (!added)
        return false;
    *added = (AVChapter){.id = (int)format->nb_chapters + 1,
                         .time_base = {1, fps},
                         .start = chapter->first,
                         .end = chapter->end};
    format->chapters[format->nb_chapters++] = added;
    (void)sc_copy_name(chapter->name, clean, sizeof clean);
    return sc_av->av_dict_set(&added->metadata, "title", clean, 0) >= 0;
}

/* Add all chapters of the settings. @return false when out of memory. */
static bool add_chapters(AVFormatContext *format, const sc_video_settings *settings)
{
    for (int i = 0; i < settings->chapter_count; i++) {
        if (!add_chapter(format, &settings->chapters[i], settings->fps))
            return false;
    }
    return true;
}

/* Make m->format, which writes to m->file. @return SC_ERR_CREATE, SC_ERR_MEMORY. */
static sc_status open_format(const sc_ctx *ctx, sc_muxer *m, const sc_video_settings *settings)
{
    int error;

    m->packet = sc_av->av_packet_alloc();
    errno = 0;
    error = m->packet ? sc_av->avformat_alloc_output_context2(&m->format, NULL, m->container->muxer,
                                                              m->path)
                      : AVERROR(ENOMEM);
    if (sc_av_result(error) == AVERROR(ENOMEM))
        return sc_av_fail(ctx, SC_ERR_MEMORY, m->path, "cannot be created", AVERROR(ENOMEM));
    if (error < 0)
        return sc_fail(ctx, SC_ERR_CREATE, "%s: this libavformat cannot write %s", m->path,
                       m->container->muxer);
    if (!sc_output_begin(m->format, &m->file) || !set_text(m->format, "title", m->about.title) ||
        !set_text(m->format, "artist", m->about.author) ||
        !set_text(m->format, "comment", m->about.comment) || !add_chapters(m->format, settings))
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", m->path);
    return SC_OK;
}

sc_status sc_muxer_open(const sc_ctx *ctx, const char *path, const sc_video_settings *settings,
                        sc_muxer **out)
{
    const sc_container *container = sc_container_find(path, settings->codec);
    SC_OWN(sc_muxer_close_at) sc_muxer *m = NULL;

    if (!container)
        return sc_container_fail(ctx, path);
    SC_PASS(sc_libav_load(ctx, path));
    SC_PASS(SC_ZALLOC(ctx, 1, &m));
    m->container = container;
    m->alpha = settings->alpha;
    m->spherical = settings->spherical;
    SC_PASS(sc_text_copy(ctx, path, &m->path));
    SC_PASS(sc_outfile_open(ctx, path, true, &m->file));
    describe(settings, &m->about);
    m->is_webp = container->codec == AV_CODEC_ID_WEBP;
    if (!m->is_webp)
        SC_PASS(open_format(ctx, m, settings));
    if (container->choice == SC_CODEC_GIF)
        SC_PASS(sc_gif_open(ctx, m->path, &m->gif));
    SC_HAND_OVER(m, out);
    return SC_OK;
}

/* Note in the metadata of m->stream that its pictures show all directions, with the direction of
 * view in their middle. MP4 and Matroska hold that; for MP4 libav asks to allow what is not in its
 * standard. @return false when out of memory. */
static bool note_spherical(sc_muxer *m)
{
    size_t bytes;
    AVSphericalMapping *mapping = sc_av->av_spherical_alloc(&bytes);

    if (!mapping)
        return false;
    mapping->projection = AV_SPHERICAL_EQUIRECTANGULAR;
    m->format->strict_std_compliance = FF_COMPLIANCE_UNOFFICIAL;
#if SC_HAVE_CODED_SIDE_DATA
    if (sc_av->av_packet_side_data_add(&m->stream->codecpar->coded_side_data,
                                       &m->stream->codecpar->nb_coded_side_data,
                                       AV_PKT_DATA_SPHERICAL, mapping, bytes, 0))
        return true;
#else
    if (sc_av->av_stream_add_side_data(m->stream, AV_PKT_DATA_SPHERICAL, (uint8_t *)mapping,
                                       bytes) >= 0)
        return true;
#endif
    sc_av->av_free(mapping);
    return false;
}

/* Make m->stream, describe it as the first segment does, which goes to m->codec, and write the
 * header of the file. @return SC_ERR_WRITE, SC_ERR_MEMORY. */
static sc_status begin(const sc_ctx *ctx, sc_muxer *m, const sc_segment *segment)
{
    AVCodecParameters *p;
    AVDictionary *options = NULL;
    int error;

    sc_segment_describe(segment, &m->codec);
    m->stream = sc_av->avformat_new_stream(m->format, NULL);
    p = m->stream ? m->stream->codecpar : NULL;
    if (p)
        p->extradata = sc_av->av_mallocz(m->codec.extradata_bytes + AV_INPUT_BUFFER_PADDING_SIZE);
    if (!p || !p->extradata || (m->spherical && !note_spherical(m)))
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", m->path);
    memcpy(p->extradata, m->codec.extradata, m->codec.extradata_bytes);
    p->extradata_size = (int)m->codec.extradata_bytes;
    m->codec.extradata = p->extradata;
    p->codec_type = AVMEDIA_TYPE_VIDEO;
    p->codec_id = (enum AVCodecID)m->codec.codec_id;
    p->codec_tag = m->container->tag;
    p->format = sc_container_pixels(m->container, m->alpha);
    /* Editors look for 32 bits, with alpha, in the header of the file. */
    p->bits_per_coded_sample = m->codec.codec_id == AV_CODEC_ID_PRORES ? m->alpha ? 32 : 24 : 0;
    p->width = m->codec.width_px;
    p->height = m->codec.height_px;
    p->sample_aspect_ratio = m->stream->sample_aspect_ratio = (AVRational){1, 1};
    p->color_primaries = AVCOL_PRI_BT709;
    p->color_trc = AVCOL_TRC_BT709;
    p->color_space = AVCOL_SPC_BT709;
    p->color_range = AVCOL_RANGE_MPEG;
    p->chroma_location = AVCHROMA_LOC_LEFT;
    p->video_delay = m->codec.reorder;
    m->stream->time_base = (AVRational){1, m->codec.fps};
    m->stream->avg_frame_rate = m->stream->r_frame_rate = (AVRational){m->codec.fps, 1};
    m->format->flags |= AVFMT_FLAG_BITEXACT;
    errno = 0;
    error = sc_av->av_dict_set(&options, "movflags", "+faststart", 0);
    if (error >= 0)
        error = sc_av_result(sc_av->avformat_write_header(m->format, &options));
    sc_av->av_dict_free(&options);
    if (error < 0)
        return sc_av_fail(ctx, SC_ERR_WRITE, m->path, "cannot be written", error);
    m->begun = true;
    return SC_OK;
}

/* Begin a WebP file, of the size that the first segment has, which goes to m->codec, or a GIF, of
 * which nothing can be written yet. @return SC_ERR_WRITE. */
static sc_status begin_pictures(const sc_ctx *ctx, sc_muxer *m, const sc_segment *segment)
{
    sc_segment_describe(segment, &m->codec);
    m->codec.extradata_bytes = 0; /* there are none, and they would be borrowed */
    m->begun = true;
    if (m->gif)
        return SC_OK;
    m->webp = (sc_webp){.stream = m->file.stream,
                        .width_px = m->codec.width_px,
                        .height_px = m->codec.height_px,
                        .fps = m->codec.fps,
                        .alpha = m->alpha};
    return sc_webp_begin(ctx, &m->webp, m->path);
}

/* Can packets of both be decoded by one decoder? True if all members, extradata byte by byte,
 * are the same. */
static bool same_codec(const sc_segment_codec *a, const sc_segment_codec *b)
{
    return a->codec_id == b->codec_id && a->width_px == b->width_px &&
           a->height_px == b->height_px && a->fps == b->fps && a->reorder == b->reorder &&
           a->extradata_bytes == b->extradata_bytes &&
           !memcmp(a->extradata, b->extradata, a->extradata_bytes);
}

/* Append the alpha of a picture to m->packet. @return false when out of memory. */
static bool add_alpha(sc_muxer *m, const sc_segment_packet *from)
{
    uint8_t *to =
        sc_av->av_packet_new_side_data(m->packet, AV_PKT_DATA_MATROSKA_BLOCKADDITIONAL,
                                       (unsigned)(SC_BLOCK_NUMBER_BYTES + from->alpha_bytes));

    if (!to)
        return false;
    memset(to, 0, SC_BLOCK_NUMBER_BYTES);
    to[SC_BLOCK_NUMBER_BYTES - 1] = 1; /* number 1 holds alpha */
    memcpy(to + SC_BLOCK_NUMBER_BYTES, from->alpha, from->alpha_bytes);
    return true;
}

/* Write a packet of the segment that follows the m->frames frames so far. Packets come in the order
 * of decoding, one for each frame. So the time of decoding, in frames, is the number of packets
 * before it, less the number of frames by which decoding has to run ahead. @return SC_ERR_WRITE,
 * SC_ERR_MEMORY. */
static sc_status add_packet(const sc_ctx *ctx, sc_muxer *m, const sc_segment_packet *from)
{
    int error = sc_av->av_new_packet(m->packet, (int)from->bytes);

    if (error < 0)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", m->path);
    memcpy(m->packet->data, from->data, from->bytes);
    if (from->alpha_bytes && !add_alpha(m, from)) {
        sc_av->av_packet_unref(m->packet);
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", m->path);
    }
    m->packet->stream_index = m->stream->index;
    m->packet->flags = from->flags;
    m->packet->pts = m->frames + from->pts;
    m->packet->dts = m->packets++ - m->codec.reorder;
    m->packet->duration = 1;
    sc_av->av_packet_rescale_ts(m->packet, (AVRational){1, m->codec.fps}, m->stream->time_base);
    errno = 0;
    error = sc_av_error(sc_av->av_interleaved_write_frame(m->format, m->packet));
    if (error >= 0 && m->format->pb->error < 0)
        error = m->format->pb->error;
    return error < 0 ? sc_av_fail(ctx, SC_ERR_WRITE, m->path, "cannot be written", error) : SC_OK;
}

sc_status sc_muxer_add(const sc_ctx *ctx, sc_muxer *m, const sc_segment *segment)
{
    sc_segment_info info;
    sc_segment_codec codec;
    sc_segment_packet packet;
    size_t at = 0;

    if (!sc_segment_inspect(segment, &info))
        return sc_fail(ctx, SC_ERR_DATA, "%s: a segment is damaged", m->path);
    if (!m->begun)
        SC_PASS(m->is_webp || m->gif ? begin_pictures(ctx, m, segment) : begin(ctx, m, segment));
    sc_segment_describe(segment, &codec);
    if (!same_codec(&m->codec, &codec))
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: the segment that begins at frame %d was made by another encoder or "
                       "with other settings than the segments before it",
                       m->path, info.first_frame);
    while (sc_segment_next(segment, &at, &packet))
        SC_PASS(m->is_webp ? sc_webp_add(ctx, &m->webp, m->path, packet.data, packet.bytes)
                : m->gif   ? sc_gif_add(m->gif, &m->codec, packet.data, packet.bytes)
                           : add_packet(ctx, m, &packet));
    m->frames += info.frame_count;
    return SC_OK;
}

/* Complete what libav writes. @return SC_ERR_WRITE, SC_ERR_MEMORY. */
static sc_status end_format(const sc_ctx *ctx, sc_muxer *m)
{
    int error;

    errno = 0;
    error = sc_av_result(sc_av->av_write_trailer(m->format));
    if (error >= 0)
        error = sc_output_end(m->format);
    return error < 0 ? sc_av_fail(ctx, SC_ERR_WRITE, m->path, "cannot be written", error) : SC_OK;
}

sc_status sc_muxer_finish(const sc_ctx *ctx, sc_muxer *m, const char *path, bool replace)
{
    if (m->gif)
        SC_PASS(sc_gif_finish(m->gif, m->format));
    SC_PASS(m->is_webp ? sc_webp_end(ctx, &m->webp, m->path, &m->about) : end_format(ctx, m));
    if (m->gif)
        SC_PASS(sc_gif_describe(ctx, m->path, m->file.stream, &m->about));
    SC_PASS(sc_outfile_rename(ctx, &m->file, path));
    m->file.replace = replace;
    return sc_outfile_commit(ctx, &m->file);
}

void sc_muxer_close(sc_muxer *m)
{
    if (!m)
        return;
    (void)sc_output_end(m->format);
    sc_outfile_discard(&m->file);
    sc_av->avformat_free_context(m->format);
    sc_av->av_packet_free(&m->packet);
    sc_gif_close(m->gif);
    sc_free(m->path);
    sc_free(m);
}
