/* SPDX-License-Identifier: BSD-3-Clause */
/* What the signals do that ask a run to stop, or that tell of a limit of the system. */
#include "segcast/process.h"

#include <errno.h>
#include <signal.h>
#include <sys/time.h>
#include <sys/uio.h>
#include <unistd.h>

/* Mutable global variables: a signal handler can reach nothing else. Beside these there are only
 * the unfinished files in base/outfile.c. */
static atomic_int stop_requested; /* 0, or the number of the first such signal */
static atomic_int stops_in_order; /* see sc_signals_stop_in_order */
static atomic_int may_keep;       /* sc_signals_stop_in_order(true) was called at least once */
static atomic_int answers;        /* sc_signals_tell was called */
static atomic_int gives_up;       /* see sc_signals_give_up */
static atomic_int tells_of_stop;  /* see sc_signals_tell */
static atomic_int runs;           /* sc_signals_catch_stop was called */
static atomic_int expendable;     /* see sc_signals_expendable */
static atomic_int alarms; /* how often the timer has come since the first INT and the like */
static atomic_int is_terminal;

static bool lost_memory_told;
/* The mapped file that on_lost_memory can name; borrowed, NULL: none. */
static _Atomic(const sc_watched_file *) watched;

/* How long what was begun has after INT and the like until it is given up; with what follows, the
 * process ends within a second. What cannot be given up has until the third alarm. */
enum { GIVE_UP_AFTER_US = 250000, LAST_ALARM = 3 };

/* Print a text to standard error. A signal handler may call it. */
static void tell(const char *text)
{
    static const char clear[] = "\r\033[K";
    const int error = errno;

    if (tells_of_stop && ((is_terminal && write(STDERR_FILENO, clear, sizeof clear - 1) < 0) ||
                          write(STDERR_FILENO, text, strlen(text)) < 0))
        tells_of_stop = 0; /* the terminal is gone */
    errno = error;
}

/* Let SIGALRM come when what was begun is to be given up, and then again and again. */
static void arm_timer(void)
{
    const struct itimerval after = {.it_value = {.tv_usec = GIVE_UP_AFTER_US},
                                    .it_interval = {.tv_usec = GIVE_UP_AFTER_US}};

    if (setitimer(ITIMER_REAL, &after, NULL)) /* a mere call of the system: handlers may make it */
        gives_up = 1;
}

/* End the process with exit code 75 from a signal handler; no unfinished file stays. */
static void stop_at_once(void)
{
    sc_unfinished_remove();
    tell("segcast: stopped on request\n");
    _exit(75);
}

static void on_alarm(int number)
{
    gives_up = 1;
    if (++alarms >= LAST_ALARM && expendable > 0)
        stop_at_once();
}

/* Does a request to stop end the process at once? INT, TERM and HUP do so if it is the second
 * request, or if nothing can be lost by that; USR1 if there is nothing yet that it could spare. */
static bool ends_at_once(int number, bool is_urgent)
{
    return is_urgent ? stop_requested || !stops_in_order
                     : number == SIGUSR1 && answers && !may_keep;
}

/* Make a note of the request to stop, or end the process with exit code 75. */
static void on_stop(int number)
{
    const bool is_urgent = number == SIGINT || number == SIGTERM || number == SIGHUP;

    if (ends_at_once(number, is_urgent))
        stop_at_once();
    if (stop_requested)
        return;
    stop_requested = number;
    if (is_urgent)
        arm_timer();
    tell(
        is_urgent
            ? "segcast: stopping; what is drawn is kept. Ctrl-C again stops at once\n"
            : "segcast: stopping when the frames that were begun are done; Ctrl-C stops at once\n");
}

/* A command other than those that can stop in order has used up its CPU time. */
static void on_cpu_limit(int number)
{
    static const char text[] = "segcast: error: the limit of CPU time is reached (ulimit -t)\n";

    sc_unfinished_remove();
    if (write(STDERR_FILENO, text, sizeof text - 1) < 0)
        _exit(71); /* nobody can be told */
    _exit(71);
}

/* Who read standard output or standard error is gone. A run goes on without: what it draws goes to
 * files, and what it cannot print at its end is an error then. All else ends as it does in other
 * programs, but leaves no unfinished files. */
static void on_lost_reader(int number)
{
    if (runs)
        return;
    sc_unfinished_remove();
    signal(number, SIG_DFL);
    raise(number); /* comes when this handler returns */
}

bool sc_watched_file_is_changed(const sc_watched_file *file)
{
    sc_file_identity now;

    return sc_file_identify(file->file, &now) && memcmp(&now, &file->identity, sizeof now) != 0;
}

/* Memory that a file or shared memory stands behind is gone: the file was cut off meanwhile, its
 * disk failed, or there is no room for a page. Whatever reads there cannot go on. Or what a file
 * holds has been changed, and led beyond all memory. */
static void on_lost_memory(int number, siginfo_t *info, void *context)
{
    static const char file[] = "segcast: error: ",
                      lost[] =
                          ": cannot be read any more: the file was changed while it was mapped "
                          "into memory, or its disk failed; run again when it is whole\n",
                      other[] =
                          "segcast: error: a file that is mapped into memory was cut off meanwhile "
                          "or cannot be read, or there is no room for shared memory (/dev/shm)\n";
    const char *at = info->si_addr;
    const sc_watched_file *w = watched;
    const bool known = w && (number == SIGSEGV ? sc_watched_file_is_changed(w)
                                               : at >= w->begin && at < w->begin + w->bytes);
    const struct iovec parts[] = {{(void *)(uintptr_t)file, sizeof file - 1},
                                  {w ? w->name : NULL, w ? strlen(w->name) : 0},
                                  {(void *)(uintptr_t)lost, sizeof lost - 1}};

    if (number == SIGSEGV && !known) { /* an error inside segcast */
        signal(SIGSEGV, SIG_DFL);      /* comes again when this handler returns */
        return;
    }
    if (__atomic_test_and_set(&lost_memory_told, __ATOMIC_RELAXED))
        pause(); /* another thread tells it, and ends the process */
    sc_unfinished_remove();
    if (known ? writev(STDERR_FILENO, parts, 3) < 0
              : write(STDERR_FILENO, other, sizeof other - 1) < 0)
        _exit(74); /* nobody can be told */
    _exit(74);
}

void sc_signals_watch_file(const sc_watched_file *file)
{
    watched = file;
}

void sc_signals_forget_file(const sc_watched_file *file)
{
    const sc_watched_file *expected = file;

    atomic_compare_exchange_strong(&watched, &expected, NULL);
}

/* Let @p handler handle the signal @p number; calls of the system that it interrupts go on. */
static void handle(int number, void (*handler)(int))
{
    struct sigaction action;

    memset(&action, 0, sizeof action);
    action.sa_handler = handler;
    action.sa_flags = SA_RESTART;
    sigemptyset(&action.sa_mask);
    sigaction(number, &action, NULL);
}

void sc_signals_install(void)
{
    struct sigaction bus;
    struct sigaction before;
    sigset_t set;

    memset(&bus, 0, sizeof bus);
    bus.sa_sigaction = on_lost_memory;
    bus.sa_flags = SA_SIGINFO;
    sigemptyset(&bus.sa_mask);
    sigaction(SIGBUS, &bus, NULL);
    if (!sigaction(SIGSEGV, NULL, &before) && before.sa_handler == SIG_DFL) /* no sanitizer */
        sigaction(SIGSEGV, &bus, NULL);
    handle(SIGUSR1, on_stop);
    handle(SIGTERM, on_stop);
    handle(SIGINT, on_stop);
    if (!sigaction(SIGHUP, NULL, &before) && before.sa_handler != SIG_IGN) /* not under nohup */
        handle(SIGHUP, on_stop);
    if (!sigaction(SIGPIPE, NULL, &before) && before.sa_handler != SIG_IGN)
        handle(SIGPIPE, on_lost_reader);
    handle(SIGALRM, on_alarm);
    handle(SIGXCPU, on_cpu_limit);
    handle(SIGXFSZ, SIG_IGN);
    sigemptyset(&set);
    sigaddset(&set, SIGUSR1);
    sigprocmask(SIG_UNBLOCK, &set, NULL);
}

void sc_signals_tell(bool tells, bool is_tty)
{
    is_terminal = is_tty;
    tells_of_stop = tells;
    answers = 1;
    if (stop_requested == SIGUSR1 && !may_keep) /* it came before it could be answered */
        stop_at_once();
}

const atomic_int *sc_signals_catch_stop(void)
{
    handle(SIGXCPU, on_stop);
    runs = 1;
    return &stop_requested;
}

void sc_signals_stop_in_order(bool in_order)
{
    stops_in_order = in_order;
    may_keep = may_keep || in_order;
}

atomic_int *sc_signals_give_up(void)
{
    return &gives_up;
}

void sc_signals_expendable(bool begins)
{
    expendable += begins ? 1 : -1;
}
