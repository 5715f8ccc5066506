/* SPDX-License-Identifier: BSD-3-Clause */
#define _GNU_SOURCE /* getentropy, with glibc in <unistd.h> */
#include "shared_file.h"

#include <errno.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/statvfs.h>
#include <unistd.h>

bool sc_shared_folder_has_room(const char *folder, size_t bytes, size_t spare)
{
    struct statvfs info;
    uint64_t room;

    if (statvfs(folder, &info))
        return true;
    room = (uint64_t)info.f_bavail * info.f_frsize;
    return bytes <= room - (spare < room / 2 ? spare : room / 2);
}

sc_status sc_shared_file_make(const char *folder, size_t bytes, size_t spare_bytes,
                              sc_shared_name *name, int *out)
{
    char host[SC_HOST_BYTES];
    uint64_t random;
    int length, file;

    sc_remove_temporaries(folder, false);
    if (!sc_shared_folder_has_room(folder, bytes, spare_bytes)) {
        errno = ENOSPC;
        return SC_ERR_MEMORY;
    }
    if (getentropy(&random, sizeof random))
        return SC_ERR_CREATE;
    memset(name, 0, sizeof *name);
    sc_host_name(host);
    length = snprintf(name->path, sizeof name->path, "%s/.segcast.tmp.%s.%ld.%016llx", folder, host,
                      (long)getpid(), (unsigned long long)random);
    if (length < 0 || (size_t)length >= sizeof name->path) {
        errno = ENAMETOOLONG;
        return SC_ERR_CREATE;
    }
    name->unfinished = sc_unfinished_add(name->path);
    file = open(name->path, O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
    if (file < 0) {
        const int error = errno;

        sc_unfinished_drop(name->unfinished);
        errno = error;
        return SC_ERR_CREATE;
    }
    *out = file;
    return SC_OK;
}

sc_status sc_shared_file_open(const sc_shared_name *name, int *out)
{
    const int file = open(name->path, O_RDWR | O_NOFOLLOW | O_CLOEXEC);

    if (file < 0)
        return SC_ERR_MISSING;
    *out = file;
    return SC_OK;
}

void sc_shared_file_remove(sc_shared_name *name)
{
    if (!name->path[0])
        return;
    unlink(name->path);
    sc_unfinished_drop(name->unfinished);
    *name = (sc_shared_name){.unfinished = -1};
}

sc_status sc_shared_file_reserve(int file, size_t bytes)
{
    int error;

    do
        error = posix_fallocate(file, 0, (off_t)bytes);
    while (error == EINTR);
    errno = error;
    return error ? SC_ERR_MEMORY : SC_OK;
}

sc_status sc_shared_file_map(int file, size_t bytes, void **out)
{
    void *data = mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);

    if (data == MAP_FAILED)
        return SC_ERR_MEMORY;
    *out = data;
    return SC_OK;
}
