/* SPDX-License-Identifier: BSD-3-Clause */
#include "app.h"

void sc_terminal_clear(sc_terminal *terminal)
{
    if (terminal->bar_shown)
        fprintf(stderr, "\r\033[K");
    terminal->bar_shown = false;
}

void sc_terminal_bar(sc_terminal *terminal, const char *text)
{
    if (terminal->quiet)
        return;
    fprintf(stderr, "\r%s\033[K", text);
    fflush(stderr);
    terminal->bar_shown = true;
}

void sc_terminal_write(void *user, sc_log_level level, const char *text)
{
    sc_terminal *terminal = user;

    if (terminal->quiet && level > SC_LOG_WARN)
        return;
    if (level == SC_LOG_ERROR && __atomic_fetch_add(&terminal->errors, 1, __ATOMIC_RELAXED) > 0 &&
        terminal->one_error)
        return;
    sc_terminal_clear(terminal);
    sc_log_to_stderr(NULL, level, text);
}
