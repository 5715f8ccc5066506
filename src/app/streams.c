/* SPDX-License-Identifier: BSD-3-Clause */
/* The standard streams: open when the process begins, and written to the end when it ends. */
#include "app.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
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
