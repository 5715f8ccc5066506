/* SPDX-License-Identifier: BSD-3-Clause */
#include "app.h"

#include <string.h>
#include <unistd.h>

/* The only mutable global variable of segcast: a signal handler can reach nothing else. */
static volatile sig_atomic_t stop_requested;

/* The first signal asks for a stop. After it, INT or TERM ends the process with exit code 75. */
static void on_signal(int number)
{
    if (stop_requested && number != SIGUSR1)
        _exit(75);
    stop_requested = 1;
}

const volatile sig_atomic_t *sc_signals_install(void)
{
    struct sigaction action;

    memset(&action, 0, sizeof action);
    action.sa_handler = on_signal;
    action.sa_flags = SA_RESTART;
    sigemptyset(&action.sa_mask);
    sigaction(SIGUSR1, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    sigaction(SIGINT, &action, NULL);
    return &stop_requested;
}
