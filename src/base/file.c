/* SPDX-License-Identifier: BSD-3-Clause */
#include "segcast/base.h"

#include <errno.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

sc_status sc_input_status(int error)
{
    switch (error) {
    case ENOENT:
    case ENOTDIR:
    case EISDIR:
    case EACCES:
    case EPERM:
    case ELOOP:
    case ENAMETOOLONG:
        return SC_ERR_MISSING;
    case ENOMEM:
        return SC_ERR_MEMORY;
    default:
        return SC_ERR_WRITE;
    }
}

void sc_fclose_at(FILE **stream)
{
    if (*stream)
        fclose(*stream);
}

sc_status sc_file_read(const sc_ctx *ctx, const char *path, size_t max_bytes, char **out,
                       size_t *out_bytes)
{
    SC_OWN(sc_fclose_at) FILE *stream = NULL;
    SC_OWN(sc_free_at) char *data = NULL;
    struct stat info;
    size_t bytes;

    if (stat(path, &info))
        return sc_fail(ctx, sc_input_status(errno), "%s: %s", path, strerror(errno));
    if (S_ISDIR(info.st_mode))
        return sc_fail(ctx, SC_ERR_MISSING, "%s: is a directory, expected a file", path);
    if (!S_ISREG(info.st_mode)) /* opening a pipe would wait for its writer */
        return sc_fail(ctx, SC_ERR_MISSING,
                       "%s: is a pipe or a device, expected a file; write it to a file first",
                       path);
    if (info.st_size < 0 || (uint64_t)info.st_size > max_bytes)
        return sc_fail(ctx, SC_ERR_DATA, "%s: has %lld bytes, expected at most %zu", path,
                       (long long)info.st_size, max_bytes);
    stream = fopen(path, "rb");
    if (!stream)
        return sc_fail(ctx, sc_input_status(errno), "%s: %s", path, strerror(errno));
    SC_PASS(SC_ALLOC(ctx, (size_t)info.st_size + 1, &data));
    bytes = fread(data, 1, (size_t)info.st_size, stream);
    if (ferror(stream))
        return sc_fail(ctx, sc_input_status(errno), "%s: cannot be read: %s", path,
                       strerror(errno));
    data[bytes] = '\0';
    SC_HAND_OVER(data, out);
    *out_bytes = bytes;
    return SC_OK;
}

sc_status sc_file_map(const sc_ctx *ctx, const char *path, const void **out, size_t *out_bytes)
{
    sc_file_identity identity;
    int file = -1;

    SC_PASS(sc_file_map_identified(ctx, path, out, out_bytes, &identity, &file));
    close(file);
    return SC_OK;
}

bool sc_file_identify(int file, sc_file_identity *out)
{
    struct stat info;

    *out = (sc_file_identity){0};
    if (fstat(file, &info))
        return false;
    *out = (sc_file_identity){(uint64_t)info.st_dev, (uint64_t)info.st_ino, (uint64_t)info.st_size,
                              (uint64_t)info.st_mtim.tv_sec, (uint64_t)info.st_mtim.tv_nsec};
    return true;
}

sc_status sc_file_map_identified(const sc_ctx *ctx, const char *path, const void **out,
                                 size_t *out_bytes, sc_file_identity *identity, int *out_file)
{
    const int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    struct stat info;
    void *data = MAP_FAILED;
    sc_status status = SC_OK;
    int error = 0;

    if (file < 0)
        return sc_fail(ctx, sc_input_status(errno), "%s: %s", path, strerror(errno));
    if (fstat(file, &info) == 0 && S_ISREG(info.st_mode) && info.st_size > 0 &&
        sc_file_identify(file, identity)) {
        data = mmap(NULL, (size_t)info.st_size, PROT_READ, MAP_SHARED, file, 0);
        error = data == MAP_FAILED ? errno : 0;
    }
    if (data == MAP_FAILED) {
        status = sc_fail(ctx, error ? sc_input_status(error) : SC_ERR_MISSING,
                         "%s: cannot be mapped into memory: %s", path,
                         error ? strerror(error) : "it is empty, or not a regular file");
    } else {
        *out = data;
        *out_bytes = (size_t)info.st_size;
        *out_file = file;
        return SC_OK;
    }
    close(file);
    return status;
}

void sc_file_unmap(const void *data, size_t bytes)
{
    if (data)
        munmap((void *)(uintptr_t)data, bytes);
}

sc_status sc_make_directory(const sc_ctx *ctx, const char *path)
{
    SC_OWN(sc_text_clear) sc_text part = {0};
    struct stat info;

    SC_PASS(sc_text_add(ctx, &part, "%s", path));
    for (char *c = part.data + 1; c[-1]; c++) {
        const char end = *c;

        if (end != '/' && end != '\0')
            continue;
        *c = '\0';
        if (mkdir(part.data, 0777) && errno != EEXIST)
            return sc_fail(ctx, SC_ERR_CREATE, "%s: cannot be created: %s", part.data,
                           sc_reason(errno));
        *c = end;
        if (!end)
            break;
    }
    if (stat(path, &info) || !S_ISDIR(info.st_mode))
        return sc_fail(ctx, SC_ERR_CREATE, "%s: is not a directory", path);
    return SC_OK;
}

const char *sc_file_name(const char *path)
{
    const char *slash = strrchr(path, '/');

    return slash ? slash + 1 : path;
}

sc_status sc_folder_of(const sc_ctx *ctx, const char *path, char **out)
{
    const char *slash = strrchr(path, '/');
    sc_text text = {0};

    SC_PASS(sc_text_add(ctx, &text, "%.*s", slash ? (int)(slash - path) + (slash == path) : 1,
                        slash ? path : "."));
    *out = text.data;
    return SC_OK;
}

sc_status sc_path_join(const sc_ctx *ctx, const char *dir, const char *name, char **out)
{
    sc_text text = {0};

    if (name[0] == '/' || !dir || !dir[0])
        return sc_text_copy(ctx, name, out);
    SC_PASS(sc_text_add(ctx, &text, "%s/%s", dir, name));
    *out = text.data;
    return SC_OK;
}
