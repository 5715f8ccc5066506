/* SPDX-License-Identifier: BSD-3-Clause */
/* Volumes of a file for each slice, whatever the format of these files is. */
#include "source.h"

void sc_slice_files_clear(sc_slice_files *files)
{
    for (size_t i = 0; i < files->count; i++)
        sc_free(files->paths[i]);
    sc_free(files->paths);
    *files = (sc_slice_files){0};
}

/* For sc_voxel_reader.release. */
static void release(void *data)
{
    sc_slice_files_clear(data);
    sc_free(data);
}

/* sc_slices_fn: one slice at a time. */
static sc_status read_slice(const sc_ctx *ctx, const char *path, const sc_source *source, int first,
                            int count, void *out)
{
    const sc_slice_files *files = source->reader.data;
    const char *file = files->paths[first];
    const int *size = source->size;
    const size_t each = sc_voxel_type_bytes(source->type);
    SC_OWN(sc_source_clear) sc_source slice = {.slope = 1};
    SC_OWN(sc_stream_close_at) sc_voxel_stream *stream = NULL;
    sc_ctx errors = *ctx; /* what is warned of one slice, is so of all */
    const void *raw;

    (void)path; /* messages name the file of the slice */
    errors.level = SC_LOG_ERROR;
    SC_PASS(files->open(&errors, files, (size_t)first, &slice));
    if (slice.size[0] != size[0] || slice.size[1] != size[1] || slice.size[2] != 1 ||
        slice.type != source->type)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s has %d x %d x %d pixels of %zu bytes, but %s %d x %d of %zu; expected "
                       "the slices of one volume, all of one size and type",
                       file, slice.size[0], slice.size[1], slice.size[2],
                       sc_voxel_type_bytes(slice.type), files->paths[0], size[0], size[1], each);
    SC_PASS(sc_stream_open(&errors, file, &slice, &stream));
    for (size_t done = 0, some; done < sc_source_voxels(&slice); done += some) {
        SC_PASS(sc_stream_next_raw(stream, &raw, &some));
        memcpy((unsigned char *)out + done * each, raw, some * each);
    }
    return SC_OK;
}

sc_status sc_slice_files_use(const sc_ctx *ctx, sc_slice_files *files, sc_source *source)
{
    sc_slice_files *data;

    for (size_t i = 0; i < files->count; i++)
        SC_PASS(sc_text_add(ctx, &source->stored.data_files, "%s%c", files->paths[i], '\0'));
    SC_PASS(SC_ZALLOC(ctx, 1, &data));
    SC_HAND_OVER(*files, data);
    source->reader.data = data;
    source->reader.release = release;
    source->stored.encoding = SC_ENCODING_SLICES;
    source->reader.read_slices = read_slice;
    source->reader.slices = 1;
    return SC_OK;
}
