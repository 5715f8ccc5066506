/* SPDX-License-Identifier: BSD-3-Clause */
/* The files of volumes that are directories. Such a directory comes from anywhere: no link in it is
 * followed, so that it cannot make segcast read other files of the machine, and only regular files
 * are opened. */
#include "chunked/chunks.h"
#include "tables/label_table.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

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

sc_status sc_chunk_read_json(const sc_ctx *ctx, int directory, const char *path, const char *name,
                             json_t **out)
{
    uint64_t bytes;
    const int fd = sc_chunk_open_file(directory, name, &bytes);
    json_error_t error;
    void *text;
    ssize_t got = 0;
    size_t done = 0;
    sc_status status;

    if (fd < 0 && errno == ENOENT)
        return SC_OK;
    if (fd < 0)
        return sc_fail(ctx,
                       errno == EINVAL || errno == ELOOP ? SC_ERR_DATA : sc_input_status(errno),
                       "%s/%s: %s; expected a regular file: links in the directory of a volume are "
                       "not followed",
                       path, name, errno == EINVAL ? "is none" : strerror(errno));
    if (bytes > SC_CHUNK_JSON_BYTES_MAX) {
        close(fd);
        return sc_fail(ctx, SC_ERR_DATA, "%s/%s: has %llu bytes, expected at most %d", path, name,
                       (unsigned long long)bytes, SC_CHUNK_JSON_BYTES_MAX);
    }
    status = sc_alloc(ctx, (size_t)bytes + 1, 1, &text);
    while (status == SC_OK && done < bytes &&
           (got = read(fd, (char *)text + done, (size_t)bytes - done)) > 0)
        done += (size_t)got;
    close(fd);
    if (status != SC_OK)
        return status;
    *out = json_loadb(text, done, 0, &error);
    sc_free(text);
    if (*out && json_is_object(*out))
        return SC_OK;
    if (!*out && sc_json_lacks_memory(&error))
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", path);
    return *out ? sc_fail(ctx, SC_ERR_DATA, "%s/%s: is no JSON object", path, name)
                : sc_fail(ctx, SC_ERR_DATA, "%s/%s:%d: is no JSON: %s", path, name, error.line,
                          error.text);
}
