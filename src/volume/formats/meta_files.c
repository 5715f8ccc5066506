/* SPDX-License-Identifier: BSD-3-Clause */
/* Voxels of a MetaImage in a file for each slice, or as decimal digits. Source: the documentation
 * of MetaIO in ITK, and its reader for what that leaves open: the numbers of a pattern are the
 * first, the last and the step; files of LIST have one axis less than the volume. */
#include "formats/meta_files.h"
#include "tables/label_table.h"

#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>

enum { FILES_MAX = 65536 };

/* ---- one file for each slice ---- */

bool sc_meta_is_series(const char *names)
{
    return strchr(names, '%') || !strncmp(names, "LIST", 4);
}

/* Where the voxels of a slice begin in its file of @p bytes bytes. @return -1 if the file is too
 * short for @p slice_bytes. */
static int64_t slice_begin(const sc_slice_files *files, uint64_t bytes, uint64_t slice_bytes)
{
    const uint64_t begin = files->header_bytes == SC_META_AT_END
                               ? (bytes >= slice_bytes ? bytes - slice_bytes : bytes + 1)
                               : (uint64_t)files->header_bytes;

    if (files->is_packed)
        return files->header_bytes > 0 ? files->header_bytes : 0;
    return begin > bytes || bytes - begin < slice_bytes ? -1 : (int64_t)begin;
}

/* Add the file with the name @p name. */
static sc_status add_file(const sc_ctx *ctx, const char *header, const char *name,
                          const sc_source *source, sc_slice_files *files)
{
    const uint64_t slice_bytes =
        (uint64_t)source->size[0] * (uint64_t)source->size[1] * sc_voxel_type_bytes(source->type);
    SC_OWN(sc_free_at) char *path = NULL;
    uint64_t bytes;

    if (files->count == (size_t)source->size[2])
        return sc_fail(
            ctx, SC_ERR_DATA,
            "%s: ElementDataFile names more than %zu files; expected one for each of the "
            "slices, of which DimSize tells %d",
            header, files->count, source->size[2]);
    SC_PASS(sc_data_file(ctx, header, "ElementDataFile", name, &path, &bytes));
    if (slice_begin(files, bytes, slice_bytes) < 0)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: %s has %" PRIu64 " bytes, fewer than its slice of %d x %d voxels has "
                       "(%" PRIu64 ")",
                       header, path, bytes, source->size[0], source->size[1], slice_bytes);
    SC_PASS(SC_GROW(ctx, files->count, &files->capacity, &files->paths));
    SC_HAND_OVER(path, &files->paths[files->count++]);
    return SC_OK;
}

/* Add the files of LIST: names, one a line. */
static sc_status add_list(const sc_ctx *ctx, const char *header, const sc_meta_series *series,
                          const sc_source *source, sc_slice_files *files)
{
    if (series->names[4 + strspn(series->names + 4, " \t")] &&
        strtol(series->names + 4, NULL, 10) != 2)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: ElementDataFile is \"%.80s\"; expected LIST or LIST 2, a file for each "
                       "slice",
                       header, series->names);
    for (char *line = series->list, *next; line && *line; line = next) {
        next = sc_label_cut_line(line);
        line = sc_label_trim(line);
        if (*line)
            SC_PASS(add_file(ctx, header, line, source, files));
    }
    return SC_OK;
}

/* Add the files of a pattern: "slice%03d.raw FIRST LAST STEP"; without LAST as many as there are
 * slices, without FIRST from 1 on. */
static sc_status add_pattern(const sc_ctx *ctx, const char *header, const sc_meta_series *series,
                             const sc_source *source, sc_slice_files *files)
{
    char *numbers = series->names + strcspn(series->names, " \t");
    long long first = 1, last = 0, step = 1;
    sc_name_pattern pattern;
    SC_OWN(sc_text_clear) sc_text name = {0};
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
    for (int i = 0; i < source->size[2]; i++) {
        SC_PASS(sc_name_pattern_write(ctx, &pattern, first + i * step, &name));
        SC_PASS(add_file(ctx, header, name.data, source, files));
    }
    return SC_OK;
}

/* Open one slice. @p files has the size of all in its own slice. */
static sc_status open_slice(const sc_ctx *ctx, const sc_slice_files *files, size_t i,
                            sc_source *out)
{
    SC_OWN(sc_source_clear)
    sc_source slice = {.size = {files->size[0], files->size[1], 1},
                       .type = files->type,
                       .slope = 1,
                       .stored.encoding = files->is_packed ? SC_ENCODING_ZLIB : SC_ENCODING_PLAIN};
    uint64_t bytes;
    int64_t begin;

    SC_PASS(sc_text_copy(ctx, files->paths[i], &slice.stored.file));
    SC_PASS(sc_input_bytes(ctx, slice.stored.file, &bytes));
    begin = slice_begin(files, bytes,
                        (uint64_t)sc_source_voxels(&slice) * sc_voxel_type_bytes(slice.type));
    if (begin < 0)
        return sc_fail(ctx, SC_ERR_DATA, "%s: has become too short for its slice",
                       slice.stored.file);
    slice.stored.offset_bytes = (uint64_t)begin;
    SC_HAND_OVER(slice, out);
    return SC_OK;
}

sc_status sc_meta_open_series(const sc_ctx *ctx, const char *header, const sc_meta_series *series,
                              sc_source *source)
{
    SC_OWN(sc_slice_files_clear)
    sc_slice_files files = {.open = open_slice,
                            .size = {source->size[0], source->size[1]},
                            .type = source->type,
                            .header_bytes = series->header_bytes,
                            .is_packed = series->compressed};

    if (source->size[2] > FILES_MAX)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: DimSize tells %d slices, each in a file of its own; expected at most "
                       "%d: save the volume as one file",
                       header, source->size[2], FILES_MAX);
    SC_PASS(
        (strchr(series->names, '%') ? add_pattern : add_list)(ctx, header, series, source, &files));
    if (files.count < (size_t)source->size[2])
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: ElementDataFile names %zu files; expected one for each of the slices, "
                       "of which DimSize tells %d",
                       header, files.count, source->size[2]);
    SC_PASS(sc_text_copy(ctx, files.paths[0], &source->stored.file));
    return sc_slice_files_use(ctx, &files, source);
}

/* ---- decimal digits ---- */

static void release_numbers(void *data)
{
    fclose(data);
}

/* sc_slices_fn of decimal digits: the data of the source are the open file. */
static sc_status read_numbers(const sc_ctx *ctx, const char *path, const sc_source *source,
                              int first, int count, void *out)
{
    const size_t slice = (size_t)source->size[0] * (size_t)source->size[1];
    double *values = out;

    if (first == 0 && fseeko(source->reader.data, (off_t)source->stored.offset_bytes, SEEK_SET))
        return sc_fail(ctx, sc_input_status(errno), "%s: %s", source->stored.file, strerror(errno));
    for (size_t i = 0; i < slice * (size_t)count; i++) {
        if (fscanf(source->reader.data, "%lf", &values[i]) != 1)
            return sc_fail(ctx, SC_ERR_DATA,
                           "%s: voxel %zu of %zu: %s; expected numbers with blanks between them",
                           path, (size_t)first * slice + i, sc_source_voxels(source),
                           feof(source->reader.data)     ? "the file ends"
                           : ferror(source->reader.data) ? strerror(errno)
                                                         : "is no number");
    }
    return SC_OK;
}

sc_status sc_meta_open_text(const sc_ctx *ctx, sc_source *source)
{
    FILE *stream;

    SC_PASS(sc_open_input(ctx, source->stored.file, &stream));
    source->stored.encoding = SC_ENCODING_SLICES;
    source->type = SC_VOXEL_DOUBLE;
    source->stored.swapped = false;
    source->reader.slices = 1;
    source->reader.read_slices = read_numbers;
    source->reader.data = stream;
    source->reader.release = release_numbers;
    return SC_OK;
}
