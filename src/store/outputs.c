/* SPDX-License-Identifier: BSD-3-Clause */
/* Verifies finished files against the hashes that the manifest names. */
#include "internal.h"

#include <string.h>

bool sc_verify_file(const char *path, uint64_t bytes, uint64_t hash)
{
    const sc_ctx silent = {.rank = 0};
    const void *data;
    size_t size;
    bool same;

    if (sc_file_map(&silent, path, &data, &size) != SC_OK)
        return false;
    same = size == bytes && sc_hash_bytes(data, size, 0) == hash;
    sc_file_unmap(data, size);
    return same;
}

/* The parameters of sc_verify_png_files, for its threads. */
typedef struct png_check {
    const char *directory;
    const sc_frame_line *lines;
    bool *out;
} png_check;

/* For sc_parallel_for with a png_check as user: set out[k] for the frames k of [begin, end) whose
 * files can be read; the others keep their false. */
static void verify_png_range(void *user, size_t begin, size_t end, int thread)
{
    const sc_ctx silent = {.rank = 0};
    const png_check *check = user;

    (void)thread;
    for (size_t k = begin; k < end; k++) {
        char path[2 * SC_NAME_BYTES];
        sc_image image;

        snprintf(path, sizeof path, "%s/frames/%06d.png", check->directory, (int)k);
        if (!check->lines[k].known || sc_image_load_png(&silent, path, &image) != SC_OK)
            continue;
        check->out[k] = sc_image_hash(&image) == check->lines[k].done.hash;
        sc_image_clear(&image);
    }
}

void sc_verify_png_files(const char *directory, const sc_frame_line *lines, int frames, int threads,
                         bool *out)
{
    png_check check = {directory, lines, out};

    memset(out, 0, (size_t)frames * sizeof *out);
    sc_parallel_for(threads, (size_t)frames, 1, verify_png_range, &check);
}
