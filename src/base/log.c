/* SPDX-License-Identifier: BSD-3-Clause */
#include "segcast/base.h"

#include <stdarg.h>

/* Format a message and pass it to ctx->write, unless its level is above that of the context. */
static void emit(const sc_ctx *ctx, sc_log_level level, const char *fmt, va_list args)
    SC_PRINTF(3, 0);

static void emit(const sc_ctx *ctx, sc_log_level level, const char *fmt, va_list args)
{
    char text[2048];
    int used = 0;

    if (!ctx || !ctx->write || level > ctx->level)
        return;
    if (ctx->rank > 0)
        used = snprintf(text, sizeof text, "rank %d: ", ctx->rank);
    vsnprintf(text + used, sizeof text - (size_t)used, fmt, args);
    ctx->write(ctx->user, level, text);
}

sc_status sc_fail(const sc_ctx *ctx, sc_status status, const char *fmt, ...)
{
    va_list args;

    va_start(args, fmt);
    emit(ctx, SC_LOG_ERROR, fmt, args);
    va_end(args);
    return status;
}

void sc_warn(const sc_ctx *ctx, const char *fmt, ...)
{
    va_list args;

    va_start(args, fmt);
    emit(ctx, SC_LOG_WARN, fmt, args);
    va_end(args);
}

void sc_info(const sc_ctx *ctx, const char *fmt, ...)
{
    va_list args;

    va_start(args, fmt);
    emit(ctx, SC_LOG_INFO, fmt, args);
    va_end(args);
}

void sc_log_to_stderr(void *user, sc_log_level level, const char *text)
{
    static const char *const names[] = {"error: ", "warning: ", "", "debug: "};

    (void)user;
    fprintf(stderr, "segcast: %s%s\n", names[level], text);
}
