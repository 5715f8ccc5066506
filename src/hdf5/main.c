/* SPDX-License-Identifier: BSD-3-Clause */
/* segcast-hdf5: reads one volume of a HDF5 file for segcast, in a process of its own, whose limits
 * of memory, CPU time and files it sets before it looks at the file. */
#define _GNU_SOURCE /* close_range */
#include "program.h"

#include <errno.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#ifdef __GLIBC__
#include <malloc.h>
#endif
#ifdef __linux__
#include <sys/prctl.h>
#endif

enum {
    FIRST_FREE = 3,  /* descriptor: the file, the pipe and /dev/null are those before it */
    DESCRIPTORS = 4, /* so that the library can open the file, and nothing else */
    CHUNK_MOST_BYTES = 32 << 20, /* whose memory is kept for others; the most that glibc allows */
    DESCRIPTORS_MAX = 4096       /* where the system cannot close all of them by one call */
};
#define ADDRESSES_BYTES                                                                            \
    ((rlim_t)1 << 30) /* for libraries, and for what the file says of itself                       \
                       */

/* ---- what is said ---- */

bool say(answer *a, sc_hdf5_kind kind, const char *format, ...)
{
    va_list values;

    va_start(values, format);
    vsnprintf(a->text, sizeof a->text, format, values);
    va_end(values);
    a->head.kind = (uint32_t)kind;
    return false;
}

/* For H5Ewalk2: copy the text of the error in which the others began. @param user answer.why. */
static herr_t keep_first(unsigned number, const H5E_error2_t *error, void *user)
{
    if (number == 0 && error->desc)
        snprintf(user, sizeof((answer *)NULL)->why, "%s", error->desc);
    return 0;
}

void keep_reason(answer *a)
{
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_first, a->why);
}

bool say_library(answer *a, const char *what)
{
    return say(a, SC_HDF5_DAMAGED, "%s: %s; the file is damaged or cut short: get it anew", what,
               a->why[0] ? a->why : "the HDF5 library does not say why");
}

bool send_bytes(const void *bytes, size_t count)
{
    const char *at = bytes;

    while (count) {
        const ssize_t sent = write(STDOUT_FILENO, at, count);

        if (sent < 0 && errno == EINTR)
            continue;
        if (sent <= 0)
            return false;
        at += sent;
        count -= (size_t)sent;
    }
    return true;
}

/* Send head and text. @return false if segcast is gone. */
static bool send_answer(answer *a)
{
    memcpy(a->head.magic, SC_HDF5_MAGIC, SC_HDF5_MAGIC_BYTES);
    a->head.text_bytes = (uint32_t)strlen(a->text);
    return send_bytes(&a->head, sizeof a->head) && send_bytes(a->text, a->head.text_bytes);
}

/* ---- limits ---- */

static void limit(int resource, rlim_t value)
{
    struct rlimit now;

    if (!getrlimit(resource, &now) && now.rlim_max != RLIM_INFINITY && now.rlim_max < value)
        value = now.rlim_max;
    (void)setrlimit(resource, &(struct rlimit){value, value}); /* to lower it is always allowed */
}

void limit_memory(double bytes)
{
#if !SC_SANITIZED /* sanitizers need many addresses */
    if (bytes < 1e18)
        limit(RLIMIT_AS, (rlim_t)bytes);
#else
#endif
}

/* Take from the process what it does not need to read its file. @param voxel_bytes of the part that
 * is wanted. */
static void set_limits(uint64_t memory_bytes, double voxel_bytes)
{
    const double cpu_s = SC_HDF5_CPU_S + voxel_bytes / SC_HDF5_BYTES_PER_S;

#ifdef CLOSE_RANGE_UNSHARE
    close_range(FIRST_FREE, ~0U, 0);
#else
    for (int fd = FIRST_FREE; fd < DESCRIPTORS_MAX; fd++)
        close(fd);
#endif
    limit(RLIMIT_CORE, 0);
    limit(RLIMIT_FSIZE, 0);
    limit(RLIMIT_NOFILE, DESCRIPTORS);
    limit(RLIMIT_CPU, cpu_s < 1e9 ? (rlim_t)cpu_s : (rlim_t)1e9);
    if (memory_bytes)
        limit_memory((double)memory_bytes + ADDRESSES_BYTES);
}

/* Let the process end when segcast does. @return false if it is gone already. */
static bool follow(const char *parent)
{
#ifdef __linux__
    if (prctl(PR_SET_PDEATHSIG, SIGKILL))
        return false;
    return getppid() == (pid_t)strtol(parent, NULL, 10);
#else
    (void)parent; /* it ends when it writes to the pipe */
    return true;
#endif
}

/* ---- the program ---- */

/* Open the file for reading, as descriptor 0 is. @return below 0, said, if it cannot be. */
static hid_t open_file(answer *a)
{
    const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    hid_t file = -1;

#if H5_VERSION_GE(1, 10, 7)
    H5Pset_file_locking(access, true, true); /* some file systems of clusters have no locks */
#endif
    if (access >= 0)
        file = H5Fopen("/dev/fd/0", H5F_ACC_RDONLY, access);
    keep_reason(a);
    H5Pclose(access);
    if (file < 0 && strstr(a->why, "unable to lock file"))
        say(a, SC_HDF5_DAMAGED,
            "another program has it open for writing; run again when that has closed it");
    else if (file < 0)
        say_library(a, "cannot be opened as HDF5");
    return file;
}

/* Read what is wanted. @param p NULL: the description alone. */
static bool serve(const char *wanted, const part *p, uint64_t memory_bytes, answer *a)
{
    char path[SC_HDF5_TEXT_BYTES];
    volume v = {0};
    const hid_t file = open_file(a);
    bool done = file >= 0 && find_dataset(file, wanted, path, a) &&
                volume_open(file, path, &v, a) && find_geometry(file, path, &v, a);

    for (int i = 0; i < 3 && done && p; i++) {
        if (p->low[i] >= v.dims[v.axis[i]] || p->count[i] > v.dims[v.axis[i]] - p->low[i])
            done = say(a, SC_HDF5_DAMAGED, "has become smaller while it was read");
    }
    if (done) {
        a->head.kind = SC_HDF5_VOLUME;
        snprintf(a->text, sizeof a->text, "%s", path);
        done = send_answer(a);
        if (done && p && !send_voxels(&v, p, memory_bytes, a)) {
            const uint64_t no_more = 0;

            done = false;
            (void)send_bytes(&no_more, sizeof no_more); /* why follows; it is all the same if not */
        }
    }
    volume_close(&v);
    return done;
}

/* Read the numbers of a part. @return false if they are none. */
static bool read_part(char **arguments, part *out)
{
    for (int i = 0; i < 3; i++) {
        out->low[i] = strtoull(arguments[2 * i], NULL, 10);
        out->count[i] = strtoull(arguments[2 * i + 1], NULL, 10);
        if (out->count[i] == 0)
            return false;
    }
    return true;
}

int main(int argc, char **argv)
{
    const bool voxels = argc == SC_HDF5_ARGUMENTS + 6;
    static answer a;
    uint64_t memory_bytes;
    part p = {{0}, {0}};

    if ((argc != SC_HDF5_ARGUMENTS && !voxels) ||
        (voxels && !read_part(argv + SC_HDF5_ARGUMENTS, &p))) {
        fprintf(stderr, "%s is started by segcast, in order to read HDF5 files\n", SC_HDF5_PROGRAM);
        return 64;
    }
    if (!follow(argv[1]))
        return 1;
    memory_bytes = strtoull(argv[2], NULL, 10);
    set_limits(memory_bytes, 8.0 * (double)p.count[0] * (double)p.count[1] * (double)p.count[2]);
#ifdef __GLIBC__ /* memory of chunks is used again, not given back and got anew for each */
    mallopt(M_MMAP_THRESHOLD, CHUNK_MOST_BYTES);
    mallopt(M_TRIM_THRESHOLD, CHUNK_MOST_BYTES);
#endif
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    H5PLset_loading_state(0); /* filters from directories that the environment names */
    if (!register_lzf())
        return 1;
    if (serve(argv[3], voxels ? &p : NULL, memory_bytes, &a))
        return 0;
    return a.head.kind == SC_HDF5_VOLUME || !send_answer(&a);
}
