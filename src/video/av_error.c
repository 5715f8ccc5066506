/* SPDX-License-Identifier: BSD-3-Clause */
/* The errors of libav, as messages and return codes. */
#include "internal.h"

#include <errno.h>

sc_status sc_av_fail(const sc_ctx *ctx, sc_status status, const char *path, const char *what,
                     int error)
{
    char reason[128] = "unknown";

    if (error == AVERROR(ENOMEM))
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", path);
    if (error == AVERROR(EFBIG))
        snprintf(reason, sizeof reason, "%s", sc_reason(EFBIG));
    else
        sc_av->av_strerror(error, reason, sizeof reason);
    return sc_fail(ctx, status, "%s: %s: %s", path, what, reason);
}

int sc_av_result(int error)
{
    return errno == ENOMEM ? AVERROR(ENOMEM) : error;
}

int sc_av_error(int error)
{
    return error < 0 && error != AVERROR(EAGAIN) && error != AVERROR_EOF ? sc_av_result(error)
                                                                         : error;
}
