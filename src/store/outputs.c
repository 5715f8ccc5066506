/* SPDX-License-Identifier: BSD-3-Clause */
/* Verifies finished files against the hashes that the manifest names. */
#include "internal.h"

#include <errno.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

/* Files are hashed in pieces of this size, each seeded with the hash of what precedes it. */
enum { PIECE_BYTES = 1 << 20 };

uint64_t sc_store_hash_bytes(const void *data, size_t bytes)
{
    uint64_t hash = 0;

    for (size_t at = 0; at < bytes; at += PIECE_BYTES) {
        const size_t left = bytes - at;

        hash =
            sc_hash_bytes((const char *)data + at, left < PIECE_BYTES ? left : PIECE_BYTES, hash);
    }
    return hash;
}

/* Fill @p buffer, of PIECE_BYTES, from @p fd as far as the file goes. @return how many bytes were
 * read, less than PIECE_BYTES at the end of the file only; -1 for an error, in errno. */
static ssize_t read_piece(int fd, char *buffer)
{
    size_t used = 0;

    while (used < PIECE_BYTES) {
        const ssize_t more = read(fd, buffer + used, PIECE_BYTES - used);

        if (more < 0 && errno == EINTR)
            continue;
        if (more < 0)
            return -1;
        if (more == 0)
            break;
        used += (size_t)more;
    }
    return (ssize_t)used;
}

sc_status sc_store_hash_file(const sc_ctx *ctx, const char *path, uint64_t *bytes, uint64_t *hash)
{
    const int fd = open(path, O_RDONLY | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK);
    struct stat info;
    void *buffer = NULL;
    uint64_t chain = 0, size = 0;
    ssize_t more;
    sc_status status;

    if (fd < 0)
        return sc_fail(ctx, sc_input_status(errno), "%s: cannot be opened: %s", path,
                       sc_reason(errno));
    if (fstat(fd, &info) || !S_ISREG(info.st_mode)) {
        status = sc_fail(ctx, SC_ERR_MISSING, "%s: is not a file", path);
        goto out;
    }
    SC_TRY(sc_alloc(ctx, PIECE_BYTES, 1, &buffer));
    do {
        more = read_piece(fd, buffer);
        if (more > 0)
            chain = sc_hash_bytes(buffer, (size_t)more, chain);
        size += more > 0 ? (uint64_t)more : 0;
    } while (more == PIECE_BYTES);
    if (more < 0) {
        status = sc_fail(ctx, SC_ERR_MISSING, "%s: cannot be read: %s", path, sc_reason(errno));
        goto out;
    }
    *bytes = size;
    *hash = chain;
out:
    sc_free(buffer);
    close(fd);
    return status;
}

sc_status sc_verify_file(const sc_ctx *ctx, const char *path, uint64_t bytes, uint64_t hash,
                         bool *out)
{
    const sc_ctx quiet = sc_quiet(ctx);
    struct stat info;
    uint64_t size = 0, found = 0;
    sc_status status = SC_ERR_MISSING;

    if (!lstat(path, &info) && (uint64_t)info.st_size == bytes)
        status = sc_store_hash_file(&quiet, path, &size, &found);
    if (status != SC_OK && !sc_is_of_input(status))
        return status;
    *out = status == SC_OK && size == bytes && found == hash;
    return SC_OK;
}

/* The parameters of sc_verify_png_files, for its threads. */
typedef struct png_check {
    sc_ctx ctx; /* says nothing: the caller tells what went wrong first */
    const char *directory;
    sc_frame_line *lines;
    bool *out;
    _Atomic int failed; /* a return code: the last failure of the machine, or SC_OK */
} png_check;

/* Verify one PNG file; see sc_verify_png_files. @return SC_ERR_MISSING, SC_ERR_DATA if it is not
 * right, or another code if that could not be found out. */
static sc_status verify_png(const sc_ctx *ctx, const char *path, sc_done_frame *done)
{
    uint64_t bytes, hash;
    SC_OWN(sc_image_clear) sc_image image = {0};

    SC_PASS(sc_store_hash_file(ctx, path, &bytes, &hash));
    if (done->png_bytes && (bytes != done->png_bytes || hash != done->png_hash))
        return SC_ERR_DATA;
    SC_PASS(sc_image_load_png(ctx, path, &image));
    if (sc_image_hash(&image) != done->hash)
        return SC_ERR_DATA;
    done->png_bytes = bytes;
    done->png_hash = hash;
    return SC_OK;
}

/* For sc_parallel_for with a png_check as user: set out[k] for the frames k of [begin, end). */
static void verify_png_range(void *user, size_t begin, size_t end, int thread)
{
    png_check *check = user;

    for (size_t k = begin; k < end; k++) {
        char path[SC_FILE_BYTES];
        sc_status status;

        if (!check->lines[k].known)
            continue;
        sc_store_path(check->directory, path, "frames/%06d.png", (int)k);
        status = verify_png(&check->ctx, path, &check->lines[k].done);
        check->out[k] = status == SC_OK;
        if (status != SC_OK && !sc_is_of_input(status))
            check->failed = status;
    }
}

sc_status sc_verify_png_files(const sc_ctx *ctx, const char *directory, sc_frame_line *lines,
                              int frames, int threads, bool *out)
{
    png_check check = {{.alloc_budget = ctx->alloc_budget}, directory, lines, out, SC_OK};

    memset(out, 0, (size_t)frames * sizeof *out);
    sc_stage_for(ctx, (uint64_t)frames, threads, (size_t)frames, 1, verify_png_range, &check);
    if (check.failed == SC_ERR_MEMORY)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s/frames: out of memory while it is verified",
                       directory);
    return check.failed == SC_OK ? SC_OK
                                 : sc_fail(ctx, (sc_status)check.failed,
                                           "%s/frames: its files cannot be verified: the machine "
                                           "fails to open or to read them",
                                           directory);
}
