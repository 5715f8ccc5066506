/* SPDX-License-Identifier: BSD-3-Clause */
#include "segcast/base.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>

/* Format a message with the rank in front of it, as vsnprintf: what does not fit into text[size] is
 * left out. @return how many bytes the whole message has. */
static size_t format(const sc_ctx *ctx, char *text, size_t size, const char *fmt, va_list args)
    SC_PRINTF(4, 0);

static size_t format(const sc_ctx *ctx, char *text, size_t size, const char *fmt, va_list args)
{
    int used = 0, count;

    if (ctx->rank > 0)
        used = snprintf(text, size, "rank %d: ", ctx->rank);
    count = vsnprintf(text + used, size - (size_t)used, fmt, args);
    return (size_t)used + (count > 0 ? (size_t)count : 0);
}

/* Format a message and pass it to ctx->write, unless its level is above that of the context. What
 * a terminal would obey in it, such as an escape code from a file's name, is passed on as
 * sc_printable shows it. Long messages are cut only where memory is out. */
static void emit(const sc_ctx *ctx, sc_log_level level, const char *fmt, va_list args)
    SC_PRINTF(3, 0);

static void emit(const sc_ctx *ctx, sc_log_level level, const char *fmt, va_list args)
{
    enum { SHORT_BYTES = 2048 }; /* messages up to this length need no allocation */
    char text[SHORT_BYTES], shown[SHORT_BYTES];
    char *long_text = NULL, *long_shown = NULL;
    const char *message = text;
    va_list again;
    size_t bytes;

    if (!ctx || !ctx->write || level > ctx->level)
        return;
    va_copy(again, args);
    bytes = format(ctx, text, sizeof text, fmt, args);
    if (bytes >= sizeof text && (long_text = malloc(bytes + 1))) {
        format(ctx, long_text, bytes + 1, fmt, again);
        message = long_text;
    }
    va_end(again);
    bytes = sc_printable(message, shown, sizeof shown);
    if (bytes >= sizeof shown && (long_shown = malloc(bytes + 1)))
        sc_printable(message, long_shown, bytes + 1);
    ctx->write(ctx->user, level, long_shown ? long_shown : shown);
    free(long_text);
    free(long_shown);
}

sc_ctx sc_quiet(const sc_ctx *ctx)
{
    sc_ctx quiet = *ctx;

    quiet.quiet_about_input = true;
    quiet.level = SC_LOG_ERROR;
    quiet.stage = NULL;
    return quiet;
}

bool sc_is_of_input(sc_status status)
{
    return status == SC_ERR_MISSING || status == SC_ERR_DATA;
}

sc_status sc_fail(const sc_ctx *ctx, sc_status status, const char *fmt, ...)
{
    va_list args;

    if (ctx && ctx->quiet_about_input && sc_is_of_input(status))
        return status;
    va_start(args, fmt);
    emit(ctx, SC_LOG_ERROR, fmt, args);
    va_end(args);
    return status;
}

sc_status sc_memory_check(const sc_ctx *ctx, double bytes, const char *advice, const char *fmt, ...)
{
    const double limit = (double)ctx->memory_max_bytes, gib = 1024.0 * 1024 * 1024;
    char what[4352];
    va_list args;

    if (limit == 0 || bytes <= limit)
        return SC_OK;
    va_start(args, fmt);
    vsnprintf(what, sizeof what, fmt, args);
    va_end(args);
    return sc_fail(ctx, SC_ERR_SYSTEM,
                   "%s %s of memory, more than the limit of %s; %sraise the limit where there is "
                   "more memory: --max-memory %.0fG",
                   what, sc_size_text(bytes, (char[24]){0}), sc_size_text(limit, (char[24]){0}),
                   advice, ceil(bytes / gib));
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

const char *sc_reason(int error)
{
    return error == EFBIG ? "the limit of file sizes is reached (ulimit -f)"
           : error == ENOSPC
               ? "No space left on device; make room, then run again (render with --resume)"
           : error == EDQUOT
               ? "Disk quota exceeded; make room, then run again (render with --resume)"
               : strerror(error);
}

void sc_log_to_stderr(void *user, sc_log_level level, const char *text)
{
    static const char *const names[] = {"error: ", "warning: ", "", "debug: "};

    fprintf(stderr, "segcast: %s%s\n", names[level], text);
}
