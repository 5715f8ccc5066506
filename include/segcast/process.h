/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  What every command gets, and the process in which it is executed: how it was started, its ranks
 *  and threads, signals, standard streams, progress and deadline. */
#ifndef SEGCAST_PROCESS_H
#define SEGCAST_PROCESS_H

#include "segcast/cli.h"
#include "segcast/comm.h"
#include "segcast/lettering.h"
#include "segcast/study.h"
#include "segcast/terminal.h"
#include "segcast/volume.h"

#include <sys/types.h>

/** As sc_comm_agree, for what all ranks do in the same way, so that rank 0 alone logs errors in it:
 * a rank that has failed for want of memory, which it can do alone, says so. Collective. */
sc_status sc_agree_aloud(const struct sc_app *app, sc_status mine);
/** Send an array of rank 0, @p count elements of @p size bytes, to the other ranks. @param array
 * the address of a pointer of any type, which on rank 0 points to the array, and stays what it was;
 * elsewhere it becomes a copy, which they own, or NULL after an error. */
sc_status sc_broadcast_array(sc_app *app, void *array, size_t count, size_t size);
/** The same for an array of what the pointer at @p array points to. */
#define SC_BROADCAST(app, count, array) sc_broadcast_array(app, array, count, sizeof **(array))
typedef struct sc_display sc_display; /**< shows the progress */

/** The stage in which frames are drawn; its progress is shown in frames. */
#define SC_STAGE_DRAWING "drawing"
/** What a stage says of itself at a moment. */
typedef struct sc_stage_view {
    const char *name;     /**< NULL: there is no stage, and all else is 0 */
    char text[64];        /**< the name, and which of several phases of a series it is for */
    uint64_t done, total; /**< total 0: unknown */
    double share;         /**< 0 to 1; -1: unknown */
    double elapsed_s;     /**< since the stage began */
    double rate, left_s;  /**< per second, and what is left; both 0 while that is unknown */
} sc_stage_view;
/** @return what ctx->stage is now. Any thread. */
sc_stage_view sc_stage_look(const sc_ctx *ctx);
/** A bar of at most 30 columns, as many as there are for it: "[###...]  "; empty if that are fewer
 * than 5, or if @p share, 0 to 1, is negative: unknown. */
enum { SC_BAR_COLUMNS = 30, SC_BAR_BYTES = SC_BAR_COLUMNS + sizeof "[]  " };
/** Fill a bar: see SC_BAR_COLUMNS. */
void sc_progress_bar(int columns, double share, char bar[SC_BAR_BYTES]);
/** Called now and then with the stage, from another thread. */
typedef void sc_watch_fn(void *user, const sc_stage_view *view);

/** The label table of a job or of its volume, and where it was read. */
typedef struct sc_label_source {
    sc_label_table table;     /**< owned */
    char path[SC_PATH_BYTES]; /**< empty: there is none */
} sc_label_source;

/** What every command gets. */
struct sc_app {
    sc_ctx *ctx;                    /**< with which it logs */
    sc_comm *comm;                  /**< the ranks that take part in it */
    sc_terminal *terminal;          /**< standard error */
    const char *const *environment; /**< the variables, ended by NULL */
    const sc_command *commands;     /**< the table; ended by a row without a name */
    sc_options options;             /**< of the command line */
    int argc;                       /**< the words of the command line, */
    char *const *argv;              /**< [argc], as main got them */
    sc_status mistake;             /**< SC_ERR_USAGE: the command line has a mistake, which is told;
                                      the job that is read returns it, once the job's are told, too */
    int threads;                   /**< number of threads of this rank */
    bool measures;                 /**< what it costs to prepare is measured: nothing that was kept
                                      from an earlier command is used */
    double begin_s;                /**< when the process began, by sc_wall_s */
    sc_trace *trace;               /**< where sc_add_time adds events; borrowed, or NULL */
    sc_display *display;           /**< shows the progress; NULL: not on this rank */
    sc_phase_store *phase_store;   /**< where phases of one file are kept while they are read, on
                                      rank 0; NULL: there are none; borrowed */
    sc_label_source *label_source; /**< where the table of the job is kept; NULL: nowhere */
    sc_overlap_list *overlaps;     /**< where it is noted which tissues of the volume overlap; NULL:
                                      nowhere; borrowed */
    sc_font_told font_told;        /**< what was told about fonts */
};

/** Read the options and the argument of a command into app->options. After a mistake in them the
 * command is to be begun all the same if its job can be looked at, so that the mistakes of that are
 * told, too: app->mistake ends it then. @param ctx logs on rank 0 alone. Collective. @return
 * SC_ERR_USAGE, logged; SC_ERR_MEMORY. */
sc_status sc_read_command_line(sc_app *app, const sc_ctx *ctx, const sc_command *command, int argc,
                               char **argv);
/** Keep a mistake in the use of a command, which was told, until the job that is read returns it.
 * @return SC_OK; another error at once. */
static inline sc_status sc_defer(sc_app *app, sc_status found)
{
    return sc_goes_on(&app->mistake, found) ? SC_OK : found;
}

/** Begin to show the stages of app->ctx on standard error: on a terminal as a bar, elsewhere as a
 * line now and then; not if app->terminal is quiet. @return NULL if there is no memory or thread
 * for that: then the command goes on without. Ended by sc_display_stop.
 * @param launcher the parent of this process if that is a launcher of parallel programs, else 0:
 * when it is gone, the command is stopped as by TERM. */
sc_display *sc_display_start(const sc_app *app, pid_t launcher);
/** Call @p watch every two seconds, and when another stage has begun; never more than one call at a
 * time. NULL: no longer; when this returns, no call is going on. display NULL is allowed. */
void sc_display_watch(sc_display *display, sc_watch_fn *watch, void *user);
/** Stop showing progress, and free @p display. NULL is allowed. */
void sc_display_stop(sc_display *display);
/** End the stage and remove its progress from the terminal: before a result is printed. */
void sc_display_end_stage(const sc_app *app);

/** Find out from the environment whether this process has to start MPI: because a launcher such as
 * mpirun or srun has started it as one of several, or because SEGCAST_MPI says so. @return
 * SC_ERR_USAGE, logged, if that variable holds something else than yes, no or auto. */
sc_status sc_launch_mode(const sc_ctx *ctx, bool *use_mpi);
/** @return SC_ERR_USAGE, logged, if a launcher has started several processes that are not connected
 * by MPI, and SEGCAST_MPI is not "no": each would be rank 0 of 1, and they would overwrite each
 * other's files. */
sc_status sc_check_communicator(const sc_ctx *ctx, const sc_comm *comm);
/** Start MPI, if sc_launch_mode says so, or work alone. @return as sc_launch_mode and sc_comm_open.
 * Caller owns *out: sc_comm_close. */
sc_status sc_launch(const sc_ctx *ctx, sc_comm **out);
/** Execute a command on those ranks that take part in it, with as many threads as are sensible and
 * the system allows, and show its progress. Collective. @return as the command, or SC_ERR_SYSTEM,
 * logged, if not even the fewest threads can be started. */
sc_status sc_execute(sc_app *app, const sc_command *command);

/** Open the browser of the user at @p address, if there is a display and the user is not connected
 * by SSH. Other users see what programs are started with, so the browser is given a file that only
 * this one can read, and which leads there. @param file its name, to be removed by the caller;
 * empty: there is none, as no browser can be opened. */
void sc_browser_open(const char *address, char file[SC_PATH_BYTES]);
/** @return the folder for files that ranks share where /dev/shm has no room. */
const char *sc_temporary_folder(void);
/** Make the path of the file or directory @p name in the directory in which segcast keeps what it
 * may lose, of this user: below XDG_CACHE_HOME, or else HOME/.cache. Nothing needs to be there.
 * @return SC_ERR_CREATE if neither is an absolute path; SC_ERR_MEMORY. Caller owns *out: sc_free.
 */
SC_MUST_USE sc_status sc_cache_path(const sc_ctx *ctx, const char *name, char **out);
/** Add to @p times, unless it is NULL, what @p phase took since the given times of sc_wall_s and
 * sc_cpu_s; and to the trace, for a phase before the drawing. Not collective. */
void sc_add_time(const sc_app *app, sc_rank_record *times, sc_phase phase, double wall_s,
                 double cpu_s);
/** Open those of the standard streams on /dev/null that are closed, so that no file that is opened
 * later gets what is meant for them. @return false if that fails. */
bool sc_open_standard_streams(void);
/** If the limit of the stack is below what segcast needs, raise it for this process, and for
 * threads that are started afterwards. @return SC_ERR_SYSTEM, logged, if the system refuses that.
 */
sc_status sc_ensure_stack(const sc_ctx *ctx);
/** Write what standard output still holds. @return @p status; SC_ERR_WRITE, logged, instead of a
 * less severe one if not everything could be written since the process began. */
sc_status sc_finish_standard_output(const sc_ctx *ctx, sc_status status);

/** Log a table of ranks, hosts, threads, cores and memory, and a warning where threads have to
 * share cores, with the options of mpirun and srun that help. Collective. */
sc_status sc_report_placement(sc_app *app);
/** @return the time, by sc_wall_s, at which the run has to end: a margin before the end of Slurm's
 * allocation or of the time limit of the command line, whichever comes first; 0: no limit. */
double sc_deadline_s(const sc_app *app);

/** A file that is mapped into memory, for the message when it is changed meanwhile. */
typedef struct sc_watched_file {
    char *name;                /**< its path, printable */
    const char *begin;         /**< where it is mapped */
    size_t bytes;              /**< its length */
    int file;                  /**< it is open as this */
    sc_file_identity identity; /**< when it was mapped */
} sc_watched_file;
/** @return whether something has written into the file since it was mapped, as far as this machine
 *  knows: of files on network file systems it may hear seconds later. Async-signal-safe. */
bool sc_watched_file_is_changed(const sc_watched_file *file);

/** Install the handlers of all signals. Has to be called before anything else. From then on:
 * - INT, TERM and HUP end the process as sc_signals_stop_in_order says.
 * - USR1 is remembered for sc_signals_catch_stop. Until the first call of sc_signals_stop_in_order
 *   nothing has been drawn, so USR1 ends the process as TERM does. A USR1 that came before
 *   sc_signals_tell, or while it was blocked, ends the process in sc_signals_tell.
 * - SIGXFSZ is ignored: writing beyond the limit of file sizes fails with EFBIG.
 * - SIGXCPU, at the limit of CPU time, prints a message and ends the process with exit code 71.
 * - SIGBUS, when a page of a memory-mapped file cannot be read (the file was truncated, or its disk
 *   failed), prints a message and ends the process with exit code 74. So does SIGSEGV, if the file
 *   that is watched has been written into.
 * - SIGPIPE, when nobody reads standard output or standard error any more, removes unfinished files
 *   and ends the process. After sc_signals_catch_stop was called it is ignored. */
void sc_signals_install(void);
/** Let the process end with a message that names the file, and exit code 74, when it reads memory
 * of
 * @p file that has been cut off; without this the message names no file. One file at a time: the
 * last one. @param file borrowed until sc_signals_forget_file. Any thread. */
void sc_signals_watch_file(const sc_watched_file *file);
/** Before the memory of @p file is unmapped: nothing if it is not the one that is watched. */
void sc_signals_forget_file(const sc_watched_file *file);
/** Say how signals are answered on standard error. @param tells not at all, if false.
 * @param is_tty it is a terminal, which may show progress. */
void sc_signals_tell(bool tells, bool is_tty);
/** Handle the limit of CPU time like USR1, too: @return a flag that is 0, or the number of the
 * first signal that has asked for a stop, one that came before this call included. */
const atomic_int *sc_signals_catch_stop(void);
/** Whether the first INT, TERM or HUP only sets the flag of sc_signals_catch_stop. Otherwise, and
 * if it is the second, it ends the process at once, with exit code 75, after sc_unfinished_remove.
 */
void sc_signals_stop_in_order(bool in_order);
/** @return a flag that is set a quarter of a second after the first INT, TERM or HUP, and again and
 * again: somebody waits for the end of the process, and what was begun is to be given up. A command
 * may set it for its own reasons, too. */
atomic_int *sc_signals_give_up(void);
/** Say that something begins, or ends, that cannot be given up, such as encoding and writing a
 * frame, but that a later run can make again: if it has not ended about three quarters of a second
 * after the first INT, TERM or HUP, the process ends as after the second. Threads: any; what
 * several have begun is counted. */
void sc_signals_expendable(bool begins);

#endif
