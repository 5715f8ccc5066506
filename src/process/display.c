/* SPDX-License-Identifier: BSD-3-Clause */
/* Shows what a command is at, from its first moment to its last: a thread of rank 0 looks at the
 * stage ten times a second, so that the functions that do the work need not care. The same thread
 * notices if the launcher is killed. */
#include "segcast/process.h"

#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

#define LOOK_INTERVAL_S 0.1  /* between two looks at the stage */
#define QUIET_BEGIN_S 0.3    /* what takes less than this is not shown */
#define WATCH_INTERVAL_S 2.0 /* between two calls of the watch, unless the stage changes */
enum { BAR_COLUMNS_MIN = 5, TEXT_BYTES = 512 };

struct sc_display {
    const sc_ctx *ctx;
    sc_terminal *terminal;
    const char *subject; /* what the command works on; shown behind the bar */
    double begin_s;
    pid_t launcher; /* of sc_display_start */
    pthread_t thread;
    pthread_mutex_t lock; /* of the members below */
    pthread_cond_t changed;
    bool ending;
    sc_watch_fn *watch;
    void *user;
    double watched_s;
    const char *watched_name; /* the stage at that time */
    double told_s;            /* when progress was last logged; of the thread */
    int columns;              /* of the terminal, when the bar was last shown; of the thread */
};

sc_stage_view sc_stage_look(const sc_ctx *ctx)
{
    sc_stage *stage = ctx->stage;
    const double now_s = sc_wall_s();
    sc_stage_view view = {.share = -1};
    uint64_t before;
    uint32_t turn;
    double elapsed_s;

    if (!stage || !(view.name = atomic_load(&stage->name)))
        return view;
    turn = atomic_load(&stage->turn);
    if ((turn & 0xffff) > 1)
        snprintf(view.text, sizeof view.text, "%s, phase %u of %u", view.name, turn >> 16,
                 turn & 0xffff);
    else
        snprintf(view.text, sizeof view.text, "%s", view.name);
    view.done = atomic_load(&stage->done);
    view.total = atomic_load(&stage->total);
    before = atomic_load(&stage->begun_with);
    elapsed_s = now_s - atomic_load(&stage->begin_s);
    view.elapsed_s = elapsed_s;
    if (view.total == 0)
        return view;
    view.done = view.done < view.total ? view.done : view.total;
    view.share = (double)view.done / (double)view.total;
    if (view.done > before && elapsed_s > 0) {
        view.rate = (double)(view.done - before) / elapsed_s;
        view.left_s = (double)(view.total - view.done) / view.rate;
    }
    return view;
}

/* Print a duration such as "1:23:45" or "23:45" into @p text. */
static void format_seconds(double seconds, char *text, size_t size)
{
    const long s = (long)(seconds + 0.5);

    if (s >= 3600)
        snprintf(text, size, "%ld:%02ld:%02ld", s / 3600, s / 60 % 60, s % 60);
    else
        snprintf(text, size, "%ld:%02ld", s / 60, s % 60);
}

/* Print how far a stage is into @p text: "12/240 frames  3.20/s  1:11 left", "42 %  0:05 left", or,
 * if that is not known, for how long it has been going on. */
static void format_progress(const sc_stage_view *view, char *text, size_t size)
{
    char time[32];

    format_seconds(view->rate > 0 ? view->left_s : view->elapsed_s, time, sizeof time);
    if (!strcmp(view->name, SC_STAGE_DRAWING))
        snprintf(text, size, "%llu/%llu frames  %.2f/s  %s%s", (unsigned long long)view->done,
                 (unsigned long long)view->total, view->rate, view->rate > 0 ? time : "?", " left");
    else if (view->share >= 0)
        snprintf(text, size, "%.0f %%  %s%s", 100 * view->share, time,
                 view->rate > 0 ? " left" : "");
    else
        snprintf(text, size, "%s", time);
}

void sc_progress_bar(int columns, double share, char bar[SC_BAR_BYTES])
{
    const int width = columns < SC_BAR_COLUMNS ? columns : SC_BAR_COLUMNS;
    int full;

    bar[0] = '\0';
    if (width < BAR_COLUMNS_MIN || !(share >= 0))
        return;
    full = (int)(width * (share < 1 ? share : 1));
    bar[0] = '[';
    memset(bar + 1, '#', (size_t)full);
    memset(bar + 1 + full, '.', (size_t)(width - full));
    memcpy(bar + 1 + width, "]  ", sizeof "]  ");
}

/* Draw the line of the progress: stage, bar, numbers, and what the command works on. In a narrow
 * terminal the bar is shorter, or left out; what still does not fit is cut off at the end. */
static void show_bar(sc_display *display, const sc_stage_view *view)
{
    char bar[SC_BAR_BYTES], numbers[128], text[TEXT_BYTES];

    format_progress(view, numbers, sizeof numbers);
    sc_progress_bar(display->columns - (int)strlen(view->text) - (int)strlen(numbers) - 6,
                    view->share, bar);
    snprintf(text, sizeof text, "%s  %s%s  %.200s", view->text, bar, numbers,
             display->subject ? display->subject : "");
    display->columns = sc_terminal_bar(display->terminal, text);
}

/* @return the interval at which progress is logged if there is no terminal: it grows with the
 * duration of the command. */
static double log_interval_s(double elapsed_s)
{
    return elapsed_s < 60 ? 5 : elapsed_s < 3600 ? 30 : 300;
}

/* Log how far the stage is. */
static void log_progress(const sc_display *display, const sc_stage_view *view)
{
    char left[32] = "?", numbers[128];

    if (!strcmp(view->name, SC_STAGE_DRAWING)) {
        if (view->rate > 0)
            format_seconds(view->left_s, left, sizeof left);
        sc_info(display->ctx, "%llu of %llu frames (%.0f %%), %.2f frames/s, %s left",
                (unsigned long long)view->done, (unsigned long long)view->total, 100 * view->share,
                view->rate, left);
        return;
    }
    format_progress(view, numbers, sizeof numbers);
    sc_info(display->ctx, "%s: %s", view->text, numbers);
}

/* Look at the stage once, and show it. */
static void look(sc_display *display)
{
    const double now_s = sc_wall_s(), elapsed_s = now_s - display->begin_s;
    const sc_stage_view view = sc_stage_look(display->ctx);

    if (!view.name || elapsed_s < QUIET_BEGIN_S) {
        if (!view.name)
            sc_terminal_clear(display->terminal);
    } else if (display->terminal->is_tty) {
        show_bar(display, &view);
    } else if (now_s - display->told_s > log_interval_s(elapsed_s)) {
        log_progress(display, &view);
        display->told_s = now_s;
    }
}

/* Call the watch if it is time. Needs the lock, so that it is not called when it is taken away. */
static void call_watch(sc_display *display)
{
    const double now_s = sc_wall_s();
    const sc_stage_view view = sc_stage_look(display->ctx);

    if (!display->watch || !view.name ||
        (view.name == display->watched_name && now_s - display->watched_s < WATCH_INTERVAL_S))
        return;
    display->watch(display->user, &view);
    display->watched_name = view.name;
    display->watched_s = now_s;
}

/* End the run in order if the launcher has been killed: MPI ends several ranks then, but a single
 * one would go on, and write to the folder in which the user may have begun anew. */
static void watch_launcher(sc_display *display)
{
    if (!display->launcher || getppid() == display->launcher)
        return;
    display->launcher = 0;
    sc_warn(display->ctx, "the launcher that started this process is gone (mpirun or the like was "
                          "killed), so this process stops, too");
    kill(getpid(), SIGTERM);
}

/* The thread: looks until it is to end. */
static void *run_display(void *user)
{
    sc_display *display = user;

    pthread_mutex_lock(&display->lock);
    while (!display->ending) {
        struct timespec until;

        call_watch(display);
        look(display);
        watch_launcher(display);
        clock_gettime(CLOCK_REALTIME, &until);
        until.tv_nsec += (long)(LOOK_INTERVAL_S * 1e9);
        until.tv_sec += until.tv_nsec / 1000000000;
        until.tv_nsec %= 1000000000;
        (void)pthread_cond_timedwait(&display->changed, &display->lock, &until);
    }
    pthread_mutex_unlock(&display->lock);
    return NULL;
}

sc_display *sc_display_start(const sc_app *app, pid_t launcher)
{
    sc_display *display = calloc(1, sizeof *display);
    sigset_t all, before;
    int error;

    if (!display)
        return NULL;
    display->ctx = app->ctx;
    display->terminal = app->terminal;
    display->subject = app->options.input;
    display->begin_s = display->told_s = app->begin_s;
    display->columns = 80;
    display->launcher = launcher;
    pthread_mutex_init(&display->lock, NULL);
    pthread_cond_init(&display->changed, NULL);
    /* Signals are for the other threads, which know what to do with them. */
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    error = pthread_create(&display->thread, NULL, run_display, display);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    if (!error)
        return display;
    free(display);
    return NULL;
}

void sc_display_watch(sc_display *display, sc_watch_fn *watch, void *user)
{
    if (!display)
        return;
    pthread_mutex_lock(&display->lock);
    display->watch = watch;
    display->user = user;
    display->watched_name = NULL;
    pthread_mutex_unlock(&display->lock);
}

void sc_display_stop(sc_display *display)
{
    if (!display)
        return;
    pthread_mutex_lock(&display->lock);
    display->ending = true;
    pthread_cond_signal(&display->changed);
    pthread_mutex_unlock(&display->lock);
    pthread_join(display->thread, NULL);
    pthread_cond_destroy(&display->changed);
    pthread_mutex_destroy(&display->lock);
    sc_terminal_clear(display->terminal);
    free(display);
}

void sc_display_end_stage(const sc_app *app)
{
    sc_stage_end(app->ctx);
    if (app->display)
        pthread_mutex_lock(&app->display->lock); /* it may be about to show the old stage */
    sc_terminal_clear(app->terminal);
    if (app->display)
        pthread_mutex_unlock(&app->display->lock);
}
