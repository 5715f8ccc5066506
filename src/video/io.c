/* SPDX-License-Identifier: BSD-3-Clause */
/* Files as libav writes and reads them: libav gets functions instead of a name, so that it neither
 * opens a file by itself, such as one that a damaged video names, nor takes a name such as
 * "http:a.mp4" for an address. */
#include "internal.h"

#include <errno.h>
#include <sys/stat.h>
#include <unistd.h>

enum { BUFFER_BYTES = 1 << 16 };

/* A place in a file from which libav reads: a video, or what it has itself written, since it moves
 * the pictures of an MP4 file in order to put the index before them. */
typedef struct reader {
    FILE *stream; /* borrowed */
    int64_t at;
} reader;

#if LIBAVFORMAT_VERSION_MAJOR >= 61
typedef const uint8_t written_byte;
#else
typedef uint8_t written_byte;
#endif

/* Write @p size bytes to the sc_outfile @p user. @return @p size, or libav's code of an error. */
static int write_bytes(void *user, written_byte *bytes, int size)
{
    const sc_outfile *file = user;
    const int before = errno; /* which sc_av_result looks at */

    errno = 0;
    if (fwrite(bytes, 1, (size_t)size, file->stream) != (size_t)size)
        return AVERROR(errno ? errno : EIO);
    errno = before;
    return size;
}

/* Find where a move within @p stream leads. @param at the position so far. @return the new
 * position, for AVSEEK_SIZE the size of the file, or libav's code of an error. */
static int64_t place_of(FILE *stream, int64_t at, int64_t offset, int whence)
{
    struct stat info;

    if (fstat(fileno(stream), &info))
        return AVERROR(errno);
    switch (whence & ~AVSEEK_FORCE) {
    case AVSEEK_SIZE:
        return info.st_size;
    case SEEK_SET:
        return offset;
    case SEEK_CUR:
        return at + offset;
    case SEEK_END:
        return info.st_size + offset;
    default:
        return AVERROR(EINVAL);
    }
}

/* Move the sc_outfile @p user; see place_of. */
static int64_t seek_output(void *user, int64_t offset, int whence)
{
    const sc_outfile *file = user;
    const int64_t place = place_of(file->stream, ftello(file->stream), offset, whence);

    if (place < 0 || (whence & ~AVSEEK_FORCE) == AVSEEK_SIZE)
        return place;
    return fseeko(file->stream, (off_t)place, SEEK_SET) ? AVERROR(errno) : place;
}

/* Read up to @p size bytes for the reader @p user. @return how many, or libav's code of the end or
 * an error. */
static int read_bytes(void *user, uint8_t *bytes, int size)
{
    reader *r = user;
    const ssize_t count = pread(fileno(r->stream), bytes, (size_t)size, (off_t)r->at);

    if (count < 0)
        return AVERROR(errno);
    r->at += count;
    return count ? (int)count : AVERROR_EOF;
}

/* Move the reader @p user; see place_of. */
static int64_t seek_reader(void *user, int64_t offset, int whence)
{
    reader *r = user;
    const int64_t place = place_of(r->stream, r->at, offset, whence);

    if (place >= 0 && (whence & ~AVSEEK_FORCE) != AVSEEK_SIZE)
        r->at = place;
    return place;
}

/* @return a new reader at the begin of @p stream, which stays borrowed; NULL if there is no memory.
 * Caller owns it: free_reader. */
static AVIOContext *make_reader(FILE *stream)
{
    unsigned char *buffer = sc_av->av_malloc(BUFFER_BYTES);
    reader *r = sc_av->av_mallocz(sizeof *r);
    AVIOContext *context = NULL;

    if (r && buffer) {
        r->stream = stream;
        context =
            sc_av->avio_alloc_context(buffer, BUFFER_BYTES, 0, r, read_bytes, NULL, seek_reader);
    }
    if (!context) {
        sc_av->av_free(buffer);
        sc_av->av_free(r);
    }
    return context;
}

/* For AVFormatContext.io_open: open the file that is being written a second time, for reading.
 * Nothing else is opened. */
static int open_reader(AVFormatContext *format, AVIOContext **out, const char *url, int flags,
                       AVDictionary **options)
{
    const sc_outfile *file = format->opaque;

    *out = NULL;
    if (flags & AVIO_FLAG_WRITE)
        return AVERROR(EPERM);
    *out = make_reader(file->stream);
    return *out ? 0 : AVERROR(ENOMEM);
}

/* For AVFormatContext.io_open of a file that is read: a video consists of one file. */
static int open_nothing(AVFormatContext *format, AVIOContext **out, const char *url, int flags,
                        AVDictionary **options)
{
    *out = NULL;
    return AVERROR(EPERM);
}

/* Free what make_reader has made; NULL is allowed. */
static void free_reader(AVIOContext *context)
{
    if (!context)
        return;
    sc_av->av_freep(&context->opaque);
    sc_av->av_freep(&context->buffer);
    sc_av->avio_context_free(&context);
}

#if LIBAVFORMAT_VERSION_MAJOR >= 59
static int close_reader(AVFormatContext *format, AVIOContext *context)
{
    free_reader(context);
    return 0;
}
#else
static void close_reader(AVFormatContext *format, AVIOContext *context)
{
    free_reader(context);
}
#endif

bool sc_output_begin(AVFormatContext *format, sc_outfile *file)
{
    unsigned char *buffer = sc_av->av_malloc(BUFFER_BYTES);

    setvbuf(file->stream, NULL, _IONBF, 0); /* libav has a buffer; a reader must find all of it */
    if (buffer)
        format->pb = sc_av->avio_alloc_context(buffer, BUFFER_BYTES, 1, file, NULL, write_bytes,
                                               seek_output);
    if (!format->pb) {
        sc_av->av_free(buffer);
        return false;
    }
    format->flags |= AVFMT_FLAG_CUSTOM_IO;
    format->opaque = file;
    format->io_open = open_reader;
#if LIBAVFORMAT_VERSION_MAJOR >= 59
    format->io_close2 = close_reader;
#else
    format->io_close = close_reader;
#endif
    return true;
}

int sc_output_end(AVFormatContext *format)
{
    int error;

    if (!format || !format->pb)
        return 0;
    sc_av->avio_flush(format->pb);
    error = format->pb->error;
    sc_av->av_freep(&format->pb->buffer);
    sc_av->avio_context_free(&format->pb);
    return error;
}

AVFormatContext *sc_input_begin(FILE *stream)
{
    AVFormatContext *format = sc_av->avformat_alloc_context();

    if (!format)
        return NULL;
    format->pb = make_reader(stream);
    if (!format->pb) {
        sc_av->avformat_free_context(format);
        return NULL;
    }
    format->flags |= AVFMT_FLAG_CUSTOM_IO;
    format->io_open = open_nothing;
    return format;
}

int sc_input_open(AVFormatContext **format, const char *name)
{
    AVIOContext *input = (*format)->pb;
    const int error = sc_av->avformat_open_input(format, name, NULL, NULL);

    if (error < 0)
        free_reader(input); /* libav has freed all but this, and set *format to NULL */
    return error;
}

void sc_input_end(AVFormatContext **format)
{
    AVIOContext *input = *format ? (*format)->pb : NULL;

    sc_av->avformat_close_input(format);
    free_reader(input);
}
