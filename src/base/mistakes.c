/* SPDX-License-Identifier: BSD-3-Clause */
/* Messages that are told once, however often their mistake is found. */
#include "segcast/base.h"

/* For sc_ctx.write, with an sc_once as user. */
static void pass_once(void *user, sc_log_level level, const char *text)
{
    sc_once *once = user;
    const uint64_t hash = sc_hash_bytes(text, strlen(text), 0);

    for (int i = 0; level == SC_LOG_ERROR && i < once->errors && i < SC_MISTAKES_MAX; i++) {
        if (once->told[i] == hash)
            return;
    }
    if (level == SC_LOG_ERROR && ++once->errors > SC_MISTAKES_MAX)
        return;
    if (level == SC_LOG_ERROR)
        once->told[once->errors - 1] = hash;
    if (once->to->write)
        once->to->write(once->to->user, level, text);
}

sc_ctx sc_ctx_once(const sc_ctx *to, sc_once *once)
{
    sc_ctx ctx = *to;

    *once = (sc_once){.to = to};
    ctx.write = pass_once;
    ctx.user = once;
    return ctx;
}

void sc_once_end(const sc_once *once, const char *what)
{
    if (once->errors > SC_MISTAKES_MAX)
        sc_warn(once->to, "%d further mistakes of %s are not shown", once->errors - SC_MISTAKES_MAX,
                what);
}
