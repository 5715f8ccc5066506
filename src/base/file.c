/* SPDX-License-Identifier: BSD-3-Clause */
#include "segcast/base.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

sc_status sc_file_read(const sc_ctx *ctx, const char *path, size_t max_bytes, char **out,
                       size_t *out_bytes)
{
    FILE *stream = NULL;
    struct stat info;
    void *data = NULL;
    size_t bytes;
    sc_status status = SC_OK;

    if (stat(path, &info))
        return sc_fail(ctx, SC_ERR_MISSING, "%s: %s", path, strerror(errno));
    if (S_ISDIR(info.st_mode))
        return sc_fail(ctx, SC_ERR_MISSING, "%s: is a directory, expected a file", path);
    if (info.st_size < 0 || (uint64_t)info.st_size > max_bytes)
        return sc_fail(ctx, SC_ERR_DATA, "%s: has %lld bytes, expected at most %zu", path,
                       (long long)info.st_size, max_bytes);
    stream = fopen(path, "rb");
    if (!stream)
        return sc_fail(ctx, SC_ERR_MISSING, "%s: %s", path, strerror(errno));
    SC_TRY(sc_alloc(ctx, (size_t)info.st_size + 1, 1, &data));
    bytes = fread(data, 1, (size_t)info.st_size, stream);
    if (ferror(stream)) {
        status = sc_fail(ctx, SC_ERR_MISSING, "%s: cannot be read: %s", path, strerror(errno));
        goto out;
    }
    ((char *)data)[bytes] = '\0';
    *out = data;
    *out_bytes = bytes;
    data = NULL;
out:
    fclose(stream);
    sc_free(data);
    return status;
}

sc_status sc_file_map(const sc_ctx *ctx, const char *path, const void **out, size_t *out_bytes)
{
    const int file = open(path, O_RDONLY | O_CLOEXEC);
    struct stat info;
    void *data = MAP_FAILED;
    sc_status status = SC_OK;

    if (file < 0)
        return sc_fail(ctx, SC_ERR_MISSING, "%s: %s", path, strerror(errno));
    if (fstat(file, &info) == 0 && S_ISREG(info.st_mode) && info.st_size > 0)
        data = mmap(NULL, (size_t)info.st_size, PROT_READ, MAP_SHARED, file, 0);
    if (data == MAP_FAILED) {
        status = sc_fail(ctx, SC_ERR_MISSING, "%s: cannot be mapped into memory", path);
    } else {
        *out = data;
        *out_bytes = (size_t)info.st_size;
    }
    close(file);
    return status;
}

void sc_file_unmap(const void *data, size_t bytes)
{
    if (data)
        munmap((void *)(uintptr_t)data, bytes);
}

sc_status sc_temporary_name(const sc_ctx *ctx, const char *path, char **out)
{
    const char *slash = strrchr(path, '/');
    const char *name = slash ? slash + 1 : path;
    char host[64] = "host";
    sc_text text = {0};
    sc_status status;

    /* The host is part of the name, too: a node that lost its network may go on writing while the
     * batch system has begun the job again elsewhere. */
    gethostname(host, sizeof host - 1);
    status = sc_text_add(ctx, &text, "%.*s.%s.tmp.%s.%ld", (int)(name - path), path, name, host,
                         (long)getpid());
    if (status == SC_OK)
        *out = text.data;
    return status;
}

/* Read ".NAME.tmp.HOST.PID", where HOST may contain dots. @param here whether that is @p host.
 * @return PID, or 0 if @p name is not of this form. */
static long temporary_owner(const char *name, const char *host, bool *here)
{
    const char *mark = name[0] == '.' ? strstr(name, ".tmp.") : NULL;
    const char *dot = mark ? strrchr(mark + 5, '.') : NULL;
    char *end;
    long process;

    if (!dot || dot == mark + 5)
        return 0;
    process = strtol(dot + 1, &end, 10);
    *here = strlen(host) == (size_t)(dot - mark - 5) &&
            !memcmp(host, mark + 5, (size_t)(dot - mark - 5));
    return *end || end == dot + 1 ? 0 : process;
}

void sc_remove_temporaries(const char *directory, bool all)
{
    DIR *stream = opendir(directory);
    char host[64] = "host";
    const struct dirent *entry;

    gethostname(host, sizeof host - 1);
    while (stream && (entry = readdir(stream))) {
        bool here = false;
        const long process = temporary_owner(entry->d_name, host, &here);
        const bool gone = process > 0 && kill((pid_t)process, 0) != 0 && errno == ESRCH;

        if (process > 0 && (here ? gone : all))
            unlinkat(dirfd(stream), entry->d_name, 0);
    }
    if (stream)
        closedir(stream);
}

sc_status sc_outfile_open(const sc_ctx *ctx, const char *path, sc_outfile *out)
{
    sc_outfile file = {0};
    sc_text copy = {0};
    sc_status status;

    SC_TRY(sc_text_add(ctx, &copy, "%s", path));
    file.path = copy.data;
    SC_TRY(sc_temporary_name(ctx, path, &file.temporary));
    file.stream = fopen(file.temporary, "wb");
    if (!file.stream) {
        status = sc_fail(ctx, SC_ERR_CREATE, "%s: cannot be created: %s", path, sc_reason(errno));
        goto out;
    }
    *out = file;
    return SC_OK;
out:
    sc_free(file.temporary);
    sc_free(copy.data);
    return status;
}

void sc_outfile_discard(sc_outfile *file)
{
    if (file->stream)
        fclose(file->stream);
    if (file->temporary)
        unlink(file->temporary);
    sc_free(file->path);
    sc_free(file->temporary);
    *file = (sc_outfile){0};
}

sc_status sc_outfile_commit(const sc_ctx *ctx, sc_outfile *file)
{
    sc_status status = SC_OK;
    int error = 0;

    if (fflush(file->stream) || ferror(file->stream))
        error = errno ? errno : EIO;
    if (fclose(file->stream) && !error)
        error = errno;
    file->stream = NULL;
    if (error)
        status =
            sc_fail(ctx, SC_ERR_WRITE, "%s: cannot be written: %s", file->path, sc_reason(error));
    else
        status = sc_file_publish(ctx, file->temporary, file->path);
    if (status == SC_OK) {
        sc_free(file->temporary);
        file->temporary = NULL;
    }
    sc_outfile_discard(file);
    return status;
}

/* Flush a file or directory to disk. @return 0, or the errno of the failure. */
static int sync_path(const char *path, int flags)
{
    const int fd = open(path, flags);
    int failed;

    if (fd < 0)
        return errno;
    failed = fsync(fd) ? errno : 0;
    close(fd);
    return failed == EINVAL ? 0 : failed; /* some file systems cannot flush a directory */
}

sc_status sc_file_publish(const sc_ctx *ctx, const char *temporary, const char *path)
{
    const char *slash = strrchr(path, '/');
    sc_text directory = {0};
    sc_status status;
    int error;

    SC_TRY(sc_text_add(ctx, &directory, "%.*s", slash ? (int)(slash - path + 1) : 1,
                       slash ? path : "."));
    error = sync_path(temporary, O_RDONLY);
    if (!error && rename(temporary, path))
        error = errno;
    if (!error)
        error = sync_path(directory.data, O_RDONLY | O_DIRECTORY);
    if (error)
        status = sc_fail(ctx, SC_ERR_WRITE, "%s: cannot be written: %s", path, sc_reason(error));
out:
    sc_text_clear(&directory);
    return status;
}

sc_status sc_file_write(const sc_ctx *ctx, const char *path, const void *data, size_t bytes)
{
    sc_outfile file = {0};
    sc_status status = sc_outfile_open(ctx, path, &file);

    if (status != SC_OK)
        return status;
    if (bytes)
        fwrite(data, 1, bytes, file.stream);
    return sc_outfile_commit(ctx, &file);
}

sc_status sc_make_directory(const sc_ctx *ctx, const char *path)
{
    sc_text part = {0};
    struct stat info;
    sc_status status;

    SC_TRY(sc_text_add(ctx, &part, "%s", path));
    for (char *c = part.data + 1; c[-1]; c++) {
        const char end = *c;

        if (end != '/' && end != '\0')
            continue;
        *c = '\0';
        if (mkdir(part.data, 0777) && errno != EEXIST) {
            status = sc_fail(ctx, SC_ERR_CREATE, "%s: cannot be created: %s", part.data,
                             sc_reason(errno));
            goto out;
        }
        *c = end;
        if (!end)
            break;
    }
    if (stat(path, &info) || !S_ISDIR(info.st_mode))
        status = sc_fail(ctx, SC_ERR_CREATE, "%s: is not a directory", path);
out:
    sc_text_clear(&part);
    return status;
}

sc_status sc_path_join(const sc_ctx *ctx, const char *dir, const char *name, char **out)
{
    sc_text text = {0};
    sc_status status;

    if (name[0] == '/' || !dir || !dir[0])
        status = sc_text_add(ctx, &text, "%s", name);
    else
        status = sc_text_add(ctx, &text, "%s/%s", dir, name);
    if (status == SC_OK)
        *out = text.data;
    return status;
}
