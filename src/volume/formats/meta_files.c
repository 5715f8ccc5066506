/* SPDX-License-Identifier: BSD-3-Clause */
/* Voxels of a MetaImage in a file for each slice, or as decimal digits. Source: the documentation
 * of MetaIO in ITK, and its reader for what that leaves open: the numbers of a pattern are the
 * first, the last and the step; files of LIST have one axis less than the volume. */
#include "formats/meta_files.h"

#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { FILES_MAX = 65536 };

/* ---- one file for each slice ---- */

/* The files of the slices, in the order of the slices. */
typedef struct slice_files {
    sc_text paths;  /* each with a NUL byte behind it */
    size_t *begins; /* [count] the offset in paths of the path of each slice; owned */
    int count;
    bool compressed;
    int64_t header_bytes; /* as in sc_meta_series */
} slice_files;

static void release_files(void *data)
{
    slice_files *files = data;

    sc_text_clear(&files->paths);
    sc_free(files->begins);
    sc_free(files);
}

bool sc_meta_is_series(const char *names)
{
    return strchr(names, '%') || !strncmp(names, "LIST", 4);
}

/* Where the voxels of a slice begin in its file of @p bytes bytes. @return -1 if the file is too
 * short for @p slice_bytes. */
static int64_t slice_begin(const slice_files *files, uint64_t bytes, uint64_t slice_bytes)
{
    const uint64_t begin = files->header_bytes == SC_META_AT_END
                               ? (bytes >= slice_bytes ? bytes - slice_bytes : bytes + 1)
                               : (uint64_t)files->header_bytes;

    if (files->compressed)
        return files->header_bytes > 0 ? files->header_bytes : 0;
    return begin > bytes || bytes - begin < slice_bytes ? -1 : (int64_t)begin;
}

/* Add the file with the name @p name. */
static sc_status add_file(const sc_ctx *ctx, const char *header, const char *name,
                          const sc_source *source, slice_files *files)
{
    const uint64_t slice_bytes =
        (uint64_t)source->size[0] * (uint64_t)source->size[1] * sc_voxel_type_bytes(source->type);
    char *path = NULL;
    uint64_t bytes;
    sc_status status;

    if (files->count == source->size[2])
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: ElementDataFile names more than %d files; expected one for each of the "
                       "slices, of which DimSize tells %d",
                       header, files->count, source->size[2]);
    SC_TRY(sc_data_file(ctx, header, "ElementDataFile", name, &path, &bytes));
    if (slice_begin(files, bytes, slice_bytes) < 0) {
        status = sc_fail(ctx, SC_ERR_DATA,
                         "%s: %s has %" PRIu64 " bytes, fewer than its slice of %d x %d voxels has "
                         "(%" PRIu64 ")",
                         header, path, bytes, source->size[0], source->size[1], slice_bytes);
        goto out;
    }
    files->begins[files->count++] = files->paths.length_bytes;
    status = sc_text_add(ctx, &files->paths, "%s%c", path, '\0');
out:
    sc_free(path);
    return status;
}

/* Add the files of LIST: names, one a line. */
static sc_status add_list(const sc_ctx *ctx, const char *header, const sc_meta_series *series,
                          const sc_source *source, slice_files *files)
{
    if (series->names[4 + strspn(series->names + 4, " \t")] &&
        strtol(series->names + 4, NULL, 10) != 2)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: ElementDataFile is \"%.80s\"; expected LIST or LIST 2, a file for each "
                       "slice",
                       header, series->names);
    for (char *line = series->list, *next; line && *line; line = next) {
        char *end = line + strcspn(line, "\n");

        next = *end ? end + 1 : NULL;
        while (end > line && strchr(" \t\r\n", end[-1]))
            end--;
        *end = '\0';
        line += strspn(line, " \t");
        if (*line)
            SC_PASS(add_file(ctx, header, line, source, files));
    }
    return SC_OK;
}

/* Add the files of a pattern: "slice%03d.raw FIRST LAST STEP"; without LAST as many as there are
 * slices, without FIRST from 1 on. */
static sc_status add_pattern(const sc_ctx *ctx, const char *header, const sc_meta_series *series,
                             const sc_source *source, slice_files *files)
{
    char *numbers = series->names + strcspn(series->names, " \t");
    long long first = 1, last = 0, step = 1;
    sc_name_pattern pattern;
    sc_text name = {0};
    sc_status status = SC_OK;
    int given;

    if (*numbers)
        *numbers++ = '\0';
    given = sscanf(numbers, "%11lld %11lld %11lld", &first, &last, &step);
    if (given < 2)
        last = first + source->size[2] - 1;
    if (step == 0 || (last - first) / step + 1 != source->size[2])
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: ElementDataFile is \"%.80s %.80s\", which names %lld files; expected "
                       "one for each of the %d slices of DimSize: first number, last number, step",
                       header, series->names, numbers, step ? (last - first) / step + 1 : 0,
                       source->size[2]);
    if (!sc_name_pattern_read(series->names, &pattern))
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: ElementDataFile is \"%.80s\"; expected a pattern such as "
                       "\"slice%%03d.raw 1 20 1\"",
                       header, series->names);
    for (int i = 0; i < source->size[2] && status == SC_OK; i++) {
        status = sc_name_pattern_write(ctx, &pattern, first + i * step, &name);
        if (status == SC_OK)
            status = add_file(ctx, header, name.data, source, files);
    }
    sc_text_clear(&name);
    return status;
}

/* Read one slice from its file to @p out. */
static sc_status read_slice(const sc_ctx *ctx, const sc_source *source, int index, char *out)
{
    const slice_files *files = source->data;
    char *path = files->paths.data + files->begins[index];
    sc_source slice = {.size = {source->size[0], source->size[1], 1},
                       .type = source->type,
                       .slope = 1,
                       .encoding = files->compressed ? SC_ENCODING_ZLIB : SC_ENCODING_PLAIN,
                       .file = path};
    const size_t each = sc_voxel_type_bytes(source->type), all = sc_source_voxels(&slice);
    SC_OWN(sc_stream_close_at) sc_voxel_stream *stream = NULL;
    struct stat info;
    int64_t begin;

    if (stat(path, &info))
        return sc_fail(ctx, sc_input_status(errno), "%s: %s", path, strerror(errno));
    begin = slice_begin(files, (uint64_t)info.st_size, (uint64_t)all * each);
    if (begin < 0)
        return sc_fail(ctx, SC_ERR_DATA, "%s: has become too short for its slice", path);
    slice.offset_bytes = (uint64_t)begin;
    SC_PASS(sc_stream_open(ctx, path, &slice, &stream));
    for (size_t done = 0, count; done < all; done += count) {
        const void *raw;

        SC_PASS(sc_stream_next_raw(stream, &raw, &count));
        memcpy(out + done * each, raw, count * each);
    }
    return SC_OK;
}

/* sc_slices_fn of a series. */
static sc_status read_slices(const sc_ctx *ctx, const char *path, const sc_source *source,
                             int first, int count, void *out)
{
    const size_t slice_bytes =
        (size_t)source->size[0] * (size_t)source->size[1] * sc_voxel_type_bytes(source->type);

    (void)path; /* a message names the file of the slice */
    for (int i = 0; i < count; i++)
        SC_PASS(read_slice(ctx, source, first + i, (char *)out + (size_t)i * slice_bytes));
    return SC_OK;
}

sc_status sc_meta_open_series(const sc_ctx *ctx, const char *header, const sc_meta_series *series,
                              sc_source *source)
{
    void *block = NULL, *begins = NULL;
    slice_files *files;
    sc_status status;

    if (source->size[2] > FILES_MAX)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: DimSize tells %d slices, each in a file of its own; expected at most "
                       "%d: save the volume as one file",
                       header, source->size[2], FILES_MAX);
    SC_TRY(sc_zalloc(ctx, 1, sizeof *files, &block));
    files = block;
    files->compressed = series->compressed;
    files->header_bytes = series->header_bytes;
    SC_TRY(sc_alloc(ctx, (size_t)source->size[2], sizeof *files->begins, &begins));
    files->begins = begins;
    SC_TRY(
        (strchr(series->names, '%') ? add_pattern : add_list)(ctx, header, series, source, files));
    if (files->count < source->size[2]) {
        status = sc_fail(ctx, SC_ERR_DATA,
                         "%s: ElementDataFile names %d files; expected one for each of the slices, "
                         "of which DimSize tells %d",
                         header, files->count, source->size[2]);
        goto out;
    }
    SC_TRY(sc_path_join(ctx, "", files->paths.data, &source->file));
    for (int i = 0; i < files->count; i++)
        SC_TRY(sc_text_add(ctx, &source->data_files, "%s%c", files->paths.data + files->begins[i],
                           '\0'));
    source->encoding = SC_ENCODING_SLICES;
    source->slices = 1;
    source->read_slices = read_slices;
    source->data = files;
    source->release = release_files;
    block = NULL;
out:
    if (block)
        release_files(block);
    return status;
}

/* ---- decimal digits ---- */

/* Where reading numbers has got to. */
typedef struct number_file {
    FILE *stream; /* NULL before the first slice */
} number_file;

static void release_numbers(void *data)
{
    number_file *numbers = data;

    if (numbers->stream)
        fclose(numbers->stream);
    sc_free(numbers);
}

/* sc_slices_fn of decimal digits. */
static sc_status read_numbers(const sc_ctx *ctx, const char *path, const sc_source *source,
                              int first, int count, void *out)
{
    const size_t slice = (size_t)source->size[0] * (size_t)source->size[1];
    number_file *numbers = source->data;
    double *values = out;

    if (!numbers->stream)
        numbers->stream = fopen(source->file, "rb");
    if (!numbers->stream ||
        (first == 0 && fseeko(numbers->stream, (off_t)source->offset_bytes, SEEK_SET)))
        return sc_fail(ctx, sc_input_status(errno), "%s: %s", source->file, strerror(errno));
    for (size_t i = 0; i < slice * (size_t)count; i++) {
        if (fscanf(numbers->stream, "%lf", &values[i]) != 1)
            return sc_fail(ctx, SC_ERR_DATA,
                           "%s: voxel %zu of %zu: %s; expected numbers with blanks between them",
                           path, (size_t)first * slice + i, sc_source_voxels(source),
                           feof(numbers->stream)     ? "the file ends"
                           : ferror(numbers->stream) ? strerror(errno)
                                                     : "is no number");
    }
    return SC_OK;
}

sc_status sc_meta_open_text(const sc_ctx *ctx, sc_source *source)
{
    void *block;

    SC_PASS(sc_zalloc(ctx, 1, sizeof(number_file), &block));
    source->encoding = SC_ENCODING_SLICES;
    source->type = SC_VOXEL_DOUBLE;
    source->swapped = false;
    source->slices = 1;
    source->read_slices = read_numbers;
    source->data = block;
    source->release = release_numbers;
    return SC_OK;
}
