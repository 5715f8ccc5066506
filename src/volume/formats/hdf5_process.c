/* SPDX-License-Identifier: BSD-3-Clause */
/* The program segcast-hdf5 as a process of its own: started, listened to, and ended. */
#define _GNU_SOURCE /* pipe2, F_SETPIPE_SZ */
#include "formats/hdf5_process.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ; /* passed on as it is: where the libraries of the program are */

enum {
    PIPE_BYTES = 1 << 20,
    HIGH = 10, /* lowest descriptor that is given to a new process: none that it is to have */
    PATH_BYTES = 4096,
    ARGUMENTS = SC_HDF5_ARGUMENTS + 6
};
#define SILENCE_S 60.0
#define LAST_S 2.0 /* from the end of the pipe to that of the process */

/* ---- start ---- */

/* The words with which the program is started. */
typedef struct words {
    char numbers[ARGUMENTS][24];
    char *list[ARGUMENTS + 1]; /* ends with NULL */
} words;

static void make_words(const sc_ctx *ctx, const char *inside, const int (*voxels)[2], words *w)
{
    *w = (words){0};
    snprintf(w->numbers[0], sizeof w->numbers[0], "%s", SC_HDF5_PROGRAM);
    snprintf(w->numbers[1], sizeof w->numbers[1], "%ld", (long)getpid());
    snprintf(w->numbers[2], sizeof w->numbers[2], "%llu",
             (unsigned long long)ctx->memory_max_bytes);
    for (int i = 0; i < 6 && voxels; i++)
        snprintf(w->numbers[SC_HDF5_ARGUMENTS + i], sizeof w->numbers[0], "%d",
                 voxels[i / 2][i % 2]);
    for (int i = 0; i < (voxels ? ARGUMENTS : SC_HDF5_ARGUMENTS); i++)
        w->list[i] = w->numbers[i];
    w->list[3] = (char *)(uintptr_t)inside; /* posix_spawn does not write there */
}

/* Start the program with its three descriptors; signals are as in any new process, and Ctrl-C does
 * not reach it, so that nobody takes its end for a crash. @return an errno. */
static int spawn(const char *program, words *w, int file, int pipe_end, pid_t *pid)
{
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    sigset_t none, all;
    int error = posix_spawn_file_actions_init(&actions);

    if (error)
        return error;
    error = posix_spawnattr_init(&attributes);
    if (error) {
        posix_spawn_file_actions_destroy(&actions);
        return error;
    }
    sigemptyset(&none);
    sigfillset(&all);
    error = posix_spawn_file_actions_adddup2(&actions, file, STDIN_FILENO);
    error = error ? error : posix_spawn_file_actions_adddup2(&actions, pipe_end, STDOUT_FILENO);
    error =
        error ? error
              : posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    error = error ? error : posix_spawnattr_setsigmask(&attributes, &none);
    error = error ? error : posix_spawnattr_setsigdefault(&attributes, &all);
    error = error ? error : posix_spawnattr_setpgroup(&attributes, 0);
    error = error ? error
                  : posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK |
                                                              POSIX_SPAWN_SETSIGDEF |
                                                              POSIX_SPAWN_SETPGROUP);
    error = error ? error : posix_spawn(pid, program, &actions, &attributes, w->list, environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    return error;
}

/* Make a pipe whose ends no other program gets, and which none of the descriptors 0 to 2 is. */
static bool make_pipe(int ends[2])
{
    int made[2];
    int error;

    ends[0] = ends[1] = -1;
    if (pipe(made))
        return false;
    for (int i = 0; i < 2; i++)
        ends[i] = fcntl(made[i], F_DUPFD_CLOEXEC, HIGH);
    error = errno;
    close(made[0]);
    close(made[1]);
#ifdef F_SETPIPE_SZ
    (void)fcntl(ends[0], F_SETPIPE_SZ, PIPE_BYTES); /* fewer changes of context; else as it is */
#endif
    errno = error;
    return ends[0] >= 0 && ends[1] >= 0;
}

sc_status sc_hdf5_begin(const sc_ctx *ctx, const char *path, int file, const char *inside,
                        const int (*voxels)[2], sc_hdf5_process *process)
{
    char program[PATH_BYTES];
    int copy, ends[2] = {-1, -1};
    double bytes = 0;
    words w;
    int error = 0;

    sc_program_find(SC_HDF5_PROGRAM, program, sizeof program);
    make_words(ctx, inside, voxels, &w);
    *process = (sc_hdf5_process){.out = -1, .path = path};
    copy = fcntl(file, F_DUPFD_CLOEXEC, HIGH);
    if (copy < 0 || !make_pipe(ends))
        error = errno;
    else
        error = spawn(program, &w, copy, ends[1], &process->pid);
    if (copy >= 0)
        close(copy);
    if (ends[1] >= 0)
        close(ends[1]);
    if (error) {
        if (ends[0] >= 0)
            close(ends[0]);
        *process = (sc_hdf5_process){.out = -1, .path = path};
        return sc_fail(ctx, SC_ERR_SYSTEM,
                       "%s: the program that reads HDF5, %s, cannot be started: %s; install "
                       "segcast again, with it",
                       path, program, sc_reason(error));
    }
    process->out = ends[0];
    if (voxels)
        bytes = 8.0 * voxels[0][1] * voxels[1][1] * voxels[2][1];
    process->silence_s = SILENCE_S + bytes / SC_HDF5_BYTES_PER_S;
    return SC_OK;
}

/* ---- end ---- */

/* Wait until the process has ended. @return its status as of waitpid; -1 if nobody knows it. */
static int wait_for(sc_hdf5_process *process, int options)
{
    int status = -1;
    pid_t ended;

    do
        ended = waitpid(process->pid, &status, options);
    while (ended < 0 && errno == EINTR);
    if (ended != 0)
        process->pid = 0;
    return ended > 0 ? status : -1;
}

void sc_hdf5_end(sc_hdf5_process *process)
{
    if (process->pid > 0)
        (void)wait_for(process, WNOHANG);
    if (process->pid > 0) {
        kill(process->pid, SIGKILL);
        (void)wait_for(process, 0);
    }
    if (process->out >= 0)
        close(process->out);
    process->out = -1;
}

/* Log why the process has sent too little, and end it. @return SC_ERR_DATA, or SC_ERR_SYSTEM if the
 * file is not to blame. */
static sc_status tell_end(const sc_ctx *ctx, sc_hdf5_process *process)
{
    static const char advice[] = "the file is damaged, or meets a bug of the library; get it anew, "
                                 "or write its labels in another format, such as NRRD";
    const double begin_s = sc_wall_s();
    int status = -1;

    close(process->out);
    process->out = -1;
    while (process->pid > 0 && sc_wall_s() - begin_s < LAST_S) {
        status = wait_for(process, WNOHANG);
        if (process->pid > 0)
            sc_sleep_s(0.005);
    }
    sc_hdf5_end(process); /* which goes on although it has closed the pipe */
    if (status >= 0 && WIFSIGNALED(status) &&
        (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL))
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: the HDF5 library was ended (signal %d) by a limit of CPU time or "
                       "memory, which the file exceeds; %s",
                       process->path, WTERMSIG(status), advice);
    if (status >= 0 && WIFSIGNALED(status))
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: the HDF5 library crashed (signal %d) while it read the file; %s",
                       process->path, WTERMSIG(status), advice);
    if (status >= 0 && WIFEXITED(status) && WEXITSTATUS(status) >= 126)
        return sc_fail(ctx, SC_ERR_SYSTEM,
                       "%s: the program that reads HDF5, %s, ended with exit code %d before it "
                       "began; are its libraries here (ldd)?",
                       process->path, SC_HDF5_PROGRAM, WEXITSTATUS(status));
    return sc_fail(ctx, SC_ERR_DATA, "%s: the HDF5 library ended too early; %s", process->path,
                   advice);
}

/* Log that the process has sent what it should not, and end it. @return SC_ERR_DATA always. */
static sc_status tell_nonsense(const sc_ctx *ctx, sc_hdf5_process *process, const char *what)
{
    sc_hdf5_end(process);
    return sc_fail(ctx, SC_ERR_DATA,
                   "%s: the program that reads HDF5 has answered with %s; the file is damaged, or "
                   "segcast is installed in parts of different versions",
                   process->path, what);
}

/* ---- what it sends ---- */

/* Read @p bytes bytes to @p out. @return false with *status, logged; the process has ended. */
static bool read_bytes(const sc_ctx *ctx, sc_hdf5_process *process, size_t bytes, void *out,
                       sc_status *status)
{
    const double begin_s = sc_wall_s();
    unsigned char *to = out;

    while (bytes) {
        struct pollfd wait = {.fd = process->out, .events = POLLIN};
        ssize_t got = -1;
        int ready;

        do {
            const double left_s = process->silence_s - (sc_wall_s() - begin_s);

            ready = poll(&wait, 1, left_s > 0 ? (int)fmin(left_s * 1000 + 1, 1e9) : 0);
        } while (ready < 0 && (errno == EINTR || errno == EAGAIN));
        if (ready == 0) {
            sc_hdf5_end(process);
            *status = sc_fail(ctx, SC_ERR_DATA,
                              "%s: the HDF5 library was awaited for %.0f s in vain; the file is "
                              "damaged, or its disk does not answer",
                              process->path, process->silence_s);
            return false;
        }
        if (ready > 0)
            got = read(process->out, to, bytes);
        if (got < 0 && errno == EINTR)
            continue;
        if (got <= 0) {
            *status = tell_end(ctx, process);
            return false;
        }
        to += got;
        bytes -= (size_t)got;
    }
    return true;
}

/* @return why an answer of a volume is none; NULL if nothing is wrong. */
static const char *why_nonsense(const sc_hdf5_answer *answer)
{
    const double most = 1e300;

    if (answer->type >= SC_HDF5_TYPES || answer->flags & ~(unsigned)SC_HDF5_FLAGS)
        return "an unknown type of voxels";
    for (int i = 0; i < 3; i++) {
        if (answer->size[i] > INT64_MAX)
            return "a negative size";
    }
    for (int i = 0; i < 12; i++) {
        if (!(fabs(answer->to_ras_mm[i / 4][i % 4]) < most))
            return "a geometry that is not finite";
    }
    if (!(fabs(answer->slope) < most) || !(fabs(answer->intercept) < most))
        return "a scale that is not finite";
    return NULL;
}

sc_status sc_hdf5_read_answer(const sc_ctx *ctx, sc_hdf5_process *process, sc_hdf5_answer *answer,
                              char text[SC_HDF5_TEXT_BYTES + 1])
{
    static const sc_status codes[] = {[SC_HDF5_DAMAGED] = SC_ERR_DATA,
                                      [SC_HDF5_MISSING] = SC_ERR_MISSING,
                                      [SC_HDF5_LIMIT] = SC_ERR_SYSTEM};
    const char *why;
    sc_status status;

    if (!read_bytes(ctx, process, sizeof *answer, answer, &status))
        return status;
    if (memcmp(answer->magic, SC_HDF5_MAGIC, SC_HDF5_MAGIC_BYTES) != 0 ||
        answer->text_bytes > SC_HDF5_TEXT_BYTES || answer->kind < SC_HDF5_VOLUME ||
        answer->kind > SC_HDF5_LIMIT)
        return tell_nonsense(ctx, process, "what is none");
    if (!read_bytes(ctx, process, answer->text_bytes, text, &status))
        return status;
    text[answer->text_bytes] = '\0';
    if (answer->kind != SC_HDF5_VOLUME) {
        sc_hdf5_end(process);
        return sc_fail(ctx, codes[answer->kind], "%s: %s", process->path, text);
    }
    why = why_nonsense(answer);
    return why ? tell_nonsense(ctx, process, why) : SC_OK;
}

/* Read how long the next block of voxels is, of which at most @p most bytes are awaited in all. */
static sc_status next_block(const sc_ctx *ctx, sc_hdf5_process *process)
{
    char text[SC_HDF5_TEXT_BYTES + 1];
    sc_hdf5_answer answer;
    sc_status status = SC_OK;

    if (!read_bytes(ctx, process, sizeof process->block_bytes, &process->block_bytes, &status))
        return status;
    if (process->block_bytes)
        return SC_OK;
    status = sc_hdf5_read_answer(ctx, process, &answer, text); /* why there is none */
    return status == SC_OK ? tell_nonsense(ctx, process, "a volume in the place of voxels")
                           : status;
}

sc_status sc_hdf5_read_voxels(const sc_ctx *ctx, sc_hdf5_process *process, size_t bytes, void *out)
{
    unsigned char *to = out;
    sc_status status = SC_OK;

    while (bytes) {
        size_t part;

        if (!process->block_bytes)
            SC_PASS(next_block(ctx, process));
        part = process->block_bytes < bytes ? (size_t)process->block_bytes : bytes;
        if (!read_bytes(ctx, process, part, to, &status))
            return status;
        to += part;
        bytes -= part;
        process->block_bytes -= part;
    }
    return SC_OK;
}
