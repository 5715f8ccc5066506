/* SPDX-License-Identifier: BSD-3-Clause */
/* The files of volumes that are directories. Such a directory comes from anywhere: no link in it is
 * followed, so that it cannot make segcast read other files of the machine, and only regular files
 * are opened. */
#include "chunked/chunks.h"
#include "tables/label_table.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

/* Open the directory or file @p name, a path with "/", below @p directory, part by part, because
 * O_NOFOLLOW concerns the last part only. @return the descriptor, or -1 with errno. */
static int open_below(int directory, const char *name, int flags)
{
    int at = directory;

    for (;;) {
        const size_t length = strcspn(name, "/");
        const bool last = !name[length];
        char part[256];
        int next, error;

        if (length >= sizeof part) {
            errno = ENAMETOOLONG;
            next = -1;
        } else {
            memcpy(part, name, length);
            part[length] = '\0';
            next = openat(at, part,
                          O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK |
                              (last ? flags : O_DIRECTORY));
        }
        error = errno;
        if (at != directory)
            close(at);
        errno = error;
        if (next < 0 || last)
            return next;
        at = next;
        name += length + 1;
    }
}

int sc_chunk_open_directory(int directory, const char *name)
{
    return open_below(directory, name, O_DIRECTORY);
}

int sc_chunk_open_file(int directory, const char *name, uint64_t *bytes)
{
    const int fd = open_below(directory, name, 0);
    struct stat info;

    if (fd < 0)
        return -1;
    if (fstat(fd, &info) || !S_ISREG(info.st_mode)) {
        close(fd);
        errno = EINVAL;
        return -1;
    }
    *bytes = (uint64_t)info.st_size;
    return fd;
}

bool sc_chunk_read_at(int fd, uint64_t begin, size_t bytes, unsigned char *out)
{
    size_t done = 0;

    while (done < bytes) {
        const ssize_t got = pread(fd, out + done, bytes - done, (off_t)(begin + done));

        if (got < 0 && errno == EINTR)
            continue;
        if (got <= 0) {
            errno = got < 0 ? errno : 0;
            return false;
        }
        done += (size_t)got;
    }
    return true;
}

bool sc_chunk_inflate(const unsigned char *in, size_t in_bytes, unsigned char *out, size_t most,
                      size_t *bytes, char why[SC_CHUNK_WHY_BYTES])
{
    z_stream z = {.next_in = (unsigned char *)(uintptr_t)in,
                  .avail_in = (uInt)in_bytes,
                  .next_out = out,
                  .avail_out = (uInt)most};
    int result =
        in_bytes > UINT_MAX || most > UINT_MAX ? Z_BUF_ERROR : inflateInit2(&z, MAX_WBITS + 32);

    if (result != Z_OK) {
        snprintf(why, SC_CHUNK_WHY_BYTES, "gzip: out of memory");
        return false;
    }
    result = inflate(&z, Z_FINISH);
    *bytes = most - z.avail_out;
    if (result != Z_STREAM_END)
        snprintf(why, SC_CHUNK_WHY_BYTES, "gzip: %s",
                 z.msg             ? z.msg
                 : z.avail_in == 0 ? "ends too early"
                                   : "unpacks to more bytes than are expected");
    inflateEnd(&z);
    return result == Z_STREAM_END;
}

sc_status sc_chunk_open_below(const sc_ctx *ctx, int directory, const char *path, const char *from,
                              const char *name, char **full, int *fd)
{
    const char *why = name ? sc_bad_name(name) : "no name";

    if (why)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s/%s names \"%s\": %s; expected the name of a directory in it", path, from,
                       name ? name : "", why);
    SC_PASS(sc_path_join(ctx, path, name, full));
    *fd = open_below(directory, name, O_DIRECTORY);
    if (*fd >= 0)
        return SC_OK;
    return sc_fail(ctx, errno == ENOENT ? SC_ERR_MISSING : SC_ERR_DATA,
                   "%s: %s, but %s/%s names it; expected a directory, no link", *full,
                   errno == ENOENT ? "is not there" : "is no directory", path, from);
}

/* Read the whole file @p fd of @p bytes bytes, and close it. */
static sc_status read_whole(const sc_ctx *ctx, const char *path, const char *name, int fd,
                            uint64_t bytes, char **out)
{
    sc_status status = SC_OK;

    if (bytes > SC_CHUNK_JSON_BYTES_MAX)
        status = sc_fail(ctx, SC_ERR_DATA, "%s/%s: has %llu bytes, expected at most %d", path, name,
                         (unsigned long long)bytes, SC_CHUNK_JSON_BYTES_MAX);
    else
        status = sc_alloc(ctx, (size_t)bytes + 1, 1, out);
    if (status == SC_OK && !sc_chunk_read_at(fd, 0, (size_t)bytes, (unsigned char *)*out))
        status = sc_fail(ctx, SC_ERR_WRITE, "%s/%s: cannot be read: %s", path, name,
                         errno ? sc_reason(errno) : "has become shorter");
    close(fd);
    return status;
}

sc_status sc_chunk_read_json(const sc_ctx *ctx, int directory, const char *path, const char *name,
                             json_t **out)
{
    uint64_t bytes;
    const int fd = sc_chunk_open_file(directory, name, &bytes);
    SC_OWN(sc_free_at) char *text = NULL;
    json_error_t error;

    if (fd < 0 && errno == ENOENT)
        return SC_OK;
    if (fd < 0)
        return sc_fail(ctx,
                       errno == EINVAL || errno == ELOOP ? SC_ERR_DATA : sc_input_status(errno),
                       "%s/%s: %s; expected a regular file: links in the directory of a volume are "
                       "not followed",
                       path, name, errno == EINVAL ? "is none" : strerror(errno));
    SC_PASS(read_whole(ctx, path, name, fd, bytes, &text));
    *out = sc_json_load(text, (size_t)bytes, &error);
    if (*out && json_is_object(*out))
        return SC_OK;
    if (!*out && sc_json_lacks_memory(&error))
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", path);
    return *out ? sc_fail(ctx, SC_ERR_DATA, "%s/%s: is no JSON object", path, name)
                : sc_fail(ctx, SC_ERR_DATA, "%s/%s:%d: is no JSON: %s", path, name, error.line,
                          error.text);
}

sc_status sc_chunk_refuse_key(const sc_ctx *ctx, const char *path, const char *name,
                              const char *key, const char *expected)
{
    return sc_fail(ctx, SC_ERR_DATA, "%s/%s: \"%s\" is not as expected: %s", path, name, key,
                   expected);
}

bool sc_chunk_numbers(const json_t *list, int count, double least, double most, double *out)
{
    bool good = json_array_size(list) >= (size_t)count;

    for (int i = 0; i < count && good; i++) {
        const json_t *number = json_array_get(list, (size_t)i);

        out[i] = json_number_value(number);
        good = json_is_number(number) && out[i] >= least && out[i] <= most;
    }
    return good;
}

sc_status sc_chunk_describe_level(const sc_ctx *ctx, sc_text *levels, size_t i, const char *name,
                                  const json_t *size)
{
    SC_OWN(sc_free_at) char *text = size ? json_dumps(size, JSON_ENCODE_ANY) : NULL;

    return sc_text_add(ctx, levels, "%s%zu (\"%.80s\"%s%.60s)", i ? ", " : "", i, name ? name : "",
                       text ? " of " : "", text ? text : "");
}

sc_status sc_chunk_refuse_level(const sc_ctx *ctx, const char *path, int level, size_t count,
                                const sc_text *levels)
{
    return sc_fail(ctx, SC_ERR_DATA,
                   "%s: has no resolution level %d, expected one of %zu: %s; 0 is the finest", path,
                   level, count, levels->data ? levels->data : "none");
}
