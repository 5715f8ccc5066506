/* SPDX-License-Identifier: BSD-3-Clause */
/* What a process needs from its first moment on: standard streams, which are written to the end
 * when it ends, and a stack that is large enough. */
#define _GNU_SOURCE /* pthread_setattr_default_np */
#include "segcast/process.h"

#include <errno.h>
#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

bool sc_open_standard_streams(void)
{
    for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; fd++) {
        /* open takes the lowest number that is free, which is fd */
        if (fcntl(fd, F_GETFD) < 0 && open("/dev/null", O_RDWR) != fd)
            return false;
    }
    return true;
}

/* In KiB: what the functions of segcast and its libraries need, with room to spare. */
enum { STACK_KIB = 4096 };

sc_status sc_ensure_stack(const sc_ctx *ctx)
{
    const rlim_t needed = (rlim_t)STACK_KIB << 10;
    struct rlimit limit;
    pthread_attr_t attributes;

    if (getrlimit(RLIMIT_STACK, &limit) || limit.rlim_cur == RLIM_INFINITY ||
        limit.rlim_cur >= needed)
        return SC_OK;
    if (limit.rlim_max != RLIM_INFINITY && limit.rlim_max < needed)
        return sc_fail(ctx, SC_ERR_SYSTEM,
                       "the stack is limited to %llu KiB, and cannot be enlarged; expected %d KiB "
                       "or more: raise the hard limit, which `ulimit -H -s` shows",
                       (unsigned long long)limit.rlim_max >> 10, STACK_KIB);
    limit.rlim_cur = needed;
    if (setrlimit(RLIMIT_STACK, &limit))
        return sc_fail(
            ctx, SC_ERR_SYSTEM,
            "the limit of the stack cannot be raised to %d KiB: %s; raise it with `ulimit -s %d`",
            STACK_KIB, sc_reason(errno), STACK_KIB);
#ifdef __GLIBC__
    /* glibc took the default size of the stacks of threads from the limit when the process began.
     */
    if (!pthread_attr_init(&attributes)) {
        if (!pthread_attr_setstacksize(&attributes, needed))
            (void)pthread_setattr_default_np(&attributes);
        (void)pthread_attr_destroy(&attributes);
    }
#else
#endif
    return SC_OK;
}

sc_status sc_finish_standard_output(const sc_ctx *ctx, sc_status status)
{
    const bool failed_before = ferror(stdout);

    errno = 0;
    if (!fflush(stdout) && !failed_before)
        return status;
    (void)sc_fail(ctx, SC_ERR_WRITE, "standard output: cannot be written%s%s", errno ? ": " : "",
                  errno ? sc_reason(errno) : "");
    return status < SC_ERR_WRITE ? status : SC_ERR_WRITE;
}
