/* SPDX-License-Identifier: BSD-3-Clause */
/* Standard error as the user sees it: messages, and below them one line for the progress. */
#include "segcast/terminal.h"

#include <stdlib.h>
#include <sys/ioctl.h>
#include <unistd.h>

enum { COLUMNS_DEFAULT = 80, LINE_BYTES = 1024 };

/* @return how many columns the terminal has now; users may change that at any time. */
static int columns_now(void)
{
    struct winsize size;
    const char *given = getenv("COLUMNS");

    if (!ioctl(STDERR_FILENO, TIOCGWINSZ, &size) && size.ws_col > 0)
        return size.ws_col;
    return given && atoi(given) > 0 ? atoi(given) : COLUMNS_DEFAULT;
}

/* Copy as much of @p text to @p out as has room in @p columns columns. A character beyond ASCII
 * counts as two columns: some are as wide as that, and which ones terminals do not agree upon.
 * @return how many columns the result has at most. */
static int fit(const char *text, int columns, char out[LINE_BYTES])
{
    size_t used = 0;
    int width = 0;

    while (*text) {
        const size_t bytes = sc_utf8_bytes(text);
        const int wide = bytes == 1 ? 1 : 2;

        if (bytes == 0 || width + wide > columns || used + bytes >= LINE_BYTES)
            break;
        memcpy(out + used, text, bytes);
        used += bytes;
        width += wide;
        text += bytes;
    }
    out[used] = '\0';
    return width;
}

/* Remove the line of the progress. If the terminal was made narrower meanwhile, the line has been
 * broken into several. Needs the lock. */
static void clear(sc_terminal *terminal)
{
    const int columns = columns_now();
    const int above = terminal->shown_columns > 0 ? (terminal->shown_columns - 1) / columns : 0;

    if (terminal->shown_columns > 0 && above > 0)
        fprintf(stderr, "\033[%dA", above);
    if (terminal->shown_columns > 0)
        fprintf(stderr, "\r\033[J");
    terminal->shown_columns = 0;
}

void sc_terminal_clear(sc_terminal *terminal)
{
    pthread_mutex_lock(&terminal->lock);
    clear(terminal);
    fflush(stderr);
    pthread_mutex_unlock(&terminal->lock);
}

int sc_terminal_bar(sc_terminal *terminal, const char *text)
{
    char shown[4 * LINE_BYTES], line[LINE_BYTES];
    int columns, width;

    if (terminal->quiet)
        return COLUMNS_DEFAULT;
    pthread_mutex_lock(&terminal->lock);
    /* The last column stays free: some terminals begin a new line when it is filled. */
    columns = columns_now() - 1;
    sc_printable(text, shown, sizeof shown);
    width = fit(shown, columns, line);
    if (terminal->shown_columns > columns)
        clear(terminal);
    fprintf(stderr, "\r%s\033[K", line);
    terminal->shown_columns = width;
    fflush(stderr);
    pthread_mutex_unlock(&terminal->lock);
    return columns;
}

void sc_terminal_write(void *user, sc_log_level level, const char *text)
{
    sc_terminal *terminal = user;

    if (terminal->quiet && level > SC_LOG_WARN)
        return;
    if (level == SC_LOG_ERROR && __atomic_fetch_add(&terminal->errors, 1, __ATOMIC_RELAXED) > 0 &&
        terminal->one_error)
        return;
    pthread_mutex_lock(&terminal->lock);
    clear(terminal);
    sc_log_to_stderr(NULL, level, text);
    pthread_mutex_unlock(&terminal->lock);
}
