/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Standard error as the user sees it: messages, and on a terminal the progress below them. */
#ifndef SEGCAST_TERMINAL_H
#define SEGCAST_TERMINAL_H

#include "segcast/base.h"

#include <pthread.h>

/** Standard error, which shows messages and, if it is a terminal, a line with the progress below
 * them. Several threads may call its functions. */
typedef struct sc_terminal {
    bool is_tty;    /**< whether it is a terminal */
    bool quiet;     /**< no progress, and no messages but errors and warnings */
    bool one_error; /**< only the first error is printed: what fails after it follows from it */
    int errors;     /**< how many there were; atomic, since several threads log */
    pthread_mutex_t lock; /**< of what is written */
    int shown_columns;    /**< width of the progress that stands there, 0: none; at most this */
} sc_terminal;
/** A function for sc_ctx.write, with an sc_terminal as user: prints the message above the progress.
 */
void sc_terminal_write(void *user, sc_log_level level, const char *text);
/** Show @p text as progress instead of an earlier one, as far as it fits into one line. Does
 * nothing if quiet. @return how many columns there are. */
int sc_terminal_bar(sc_terminal *terminal, const char *text);
/** Remove the progress. */
void sc_terminal_clear(sc_terminal *terminal);

#endif
