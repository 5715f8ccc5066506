/* SPDX-License-Identifier: BSD-3-Clause */
/* crash_points N HOW DIR COMMAND...: run the command, and kill it (SIGKILL) at the N-th system
 * call, from 1, that changes DIR (an absolute path) or a file in it: creating, writing, flushing,
 * renaming, removing. HOW is "before": the call is not made; or "torn": of a write only the first
 * half reaches the file. So what stays is what a prefix of all changes gives. Exits with 0 if the
 * command was killed, with 3 if it ended before that, and then prints its exit code and the number
 * of calls. */
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/wait.h>
#include <unistd.h>

enum { PATH_BYTES = 4096 };

/* Where a system call names what it changes. */
typedef enum target {
    NOTHING,
    DESCRIPTOR, /* the first argument is a descriptor */
    WRITES,     /* so, and it appends bytes */
    PATH,       /* the first argument is a path */
    PATH_AT,    /* the first is the descriptor of a folder, the second a path in it */
    CREATES_AT, /* so, if the flags, the third, have O_CREAT */
} target;

/* @return what the system call @p number changes. */
static target target_of(uint64_t number)
{
    switch (number) {
    case SYS_write:
    case SYS_writev:
    case SYS_pwrite64:
        return WRITES;
    case SYS_fsync:
    case SYS_fdatasync:
    case SYS_ftruncate:
        return DESCRIPTOR;
    case SYS_openat:
        return CREATES_AT;
    case SYS_renameat2:
    case SYS_unlinkat:
    case SYS_mkdirat:
    case SYS_linkat:
        return PATH_AT;
#ifdef SYS_rename
    case SYS_rename:
    case SYS_unlink:
    case SYS_mkdir:
    case SYS_rmdir:
    case SYS_link:
        return PATH;
    case SYS_renameat:
        return PATH_AT;
#endif
    default:
        return NOTHING;
    }
}

/* Read the path of an open file of a process into @p path. @return false if there is none. */
static bool path_of(pid_t thread, int fd, char path[PATH_BYTES])
{
    char link[64];
    ssize_t length;

    if (fd == AT_FDCWD)
        snprintf(link, sizeof link, "/proc/%d/cwd", (int)thread);
    else
        snprintf(link, sizeof link, "/proc/%d/fd/%d", (int)thread, fd);
    length = readlink(link, path, PATH_BYTES - 1);
    if (length < 0)
        return false;
    path[length] = '\0';
    return true;
}

/* Read a text out of the memory of a process. */
static bool text_of(pid_t thread, uint64_t address, char text[PATH_BYTES])
{
    const struct iovec to = {text, PATH_BYTES}, from = {(void *)(uintptr_t)address, PATH_BYTES};
    ssize_t bytes = process_vm_readv(thread, &to, 1, &from, 1, 0);

    if (bytes < 0) { /* the text may end shortly before memory that is not there */
        const struct iovec less = {(void *)(uintptr_t)address, 4096 - address % 4096};

        bytes = process_vm_readv(thread, &to, 1, &less, 1, 0);
    }
    return bytes > 0 && memchr(text, '\0', (size_t)bytes);
}

/* @return whether the call, at whose entry the thread stands, changes something at or below @p
 * directory. @p path receives what. */
static bool changes(pid_t thread, const struct __ptrace_syscall_info *info, const char *directory,
                    char path[PATH_BYTES])
{
    const uint64_t *args = info->entry.args;
    const target what = target_of(info->entry.nr);
    char name[PATH_BYTES], folder[PATH_BYTES];
    const size_t length = strlen(directory);
    int fd = (int)args[0];

    switch (what) {
    case NOTHING:
        return false;
    case DESCRIPTOR:
    case WRITES:
        if (!path_of(thread, fd, path))
            return false;
        break;
    case PATH:
    case PATH_AT:
    case CREATES_AT:
        if (what == CREATES_AT && !(args[2] & O_CREAT))
            return false;
        if (!text_of(thread, args[what == PATH ? 0 : 1], name))
            return false;
        fd = what == PATH ? AT_FDCWD : fd;
        if (name[0] == '/')
            snprintf(path, PATH_BYTES, "%s", name);
        else if (!path_of(thread, fd, folder) ||
                 snprintf(path, PATH_BYTES, "%s/%s", folder, name) >= PATH_BYTES)
            return false;
        break;
    }
    return !strncmp(path, directory, length) && (path[length] == '/' || path[length] == '\0');
}

/* What the tracer is to do, and how far it is. */
typedef struct tracer {
    long wanted, count; /* kill at the call number `wanted`, from 1; calls so far */
    bool torn;
    const char *directory;
    pid_t process;         /* the command */
    pid_t writer;          /* the thread whose write is to be cut in half when it is done, or 0 */
    char path[PATH_BYTES]; /* of the file that it writes */
} tracer;

/* Cut what the last write of @p bytes bytes has appended in half. */
static void cut_in_half(const tracer *t, int64_t bytes)
{
    struct stat info;

    if (bytes > 1 && !stat(t->path, &info) && S_ISREG(info.st_mode) && info.st_size >= bytes &&
        truncate(t->path, info.st_size - bytes / 2))
        exit(2);
}

/* Handle the entry into or the exit from a system call. @return true if the command was killed. */
static bool on_call(tracer *t, pid_t thread)
{
    struct __ptrace_syscall_info info;

    if (ptrace(PTRACE_GET_SYSCALL_INFO, thread, (void *)sizeof info, &info) < 0)
        return false;
    if (info.op == PTRACE_SYSCALL_INFO_EXIT && thread == t->writer) {
        kill(t->process, SIGKILL);
        cut_in_half(t, info.exit.rval);
        return true;
    }
    if (info.op != PTRACE_SYSCALL_INFO_ENTRY || t->writer ||
        !changes(thread, &info, t->directory, t->path) || ++t->count != t->wanted)
        return false;
    if (t->torn && target_of(info.entry.nr) == WRITES) {
        t->writer = thread;
        return false;
    }
    kill(t->process, SIGKILL);
    return true;
}

/* Let the command run on until it ends or is killed. @return its exit code, or -1. */
static int trace(tracer *t)
{
    bool killed = false;
    int result;
    pid_t thread;

    while ((thread = waitpid(-1, &result, __WALL)) > 0 || errno == EINTR) {
        int deliver = 0;

        if (thread <= 0)
            continue;
        if (WIFEXITED(result) || WIFSIGNALED(result)) {
            if (thread == t->process)
                return WIFEXITED(result) && !killed ? WEXITSTATUS(result) : -1;
            continue;
        }
        if (WSTOPSIG(result) == (SIGTRAP | 0x80))
            killed = killed || on_call(t, thread);
        else if (WSTOPSIG(result) != SIGTRAP && WSTOPSIG(result) != SIGSTOP)
            deliver = WSTOPSIG(result);
        ptrace(PTRACE_SYSCALL, thread, NULL, (void *)(intptr_t)deliver);
    }
    return -1;
}

int main(int argc, char **argv)
{
    tracer t = {.wanted = argc > 4 ? strtol(argv[1], NULL, 10) : 0};
    int code;

    if (t.wanted < 1 || argv[3][0] != '/')
        return 2;
    t.torn = !strcmp(argv[2], "torn");
    t.directory = argv[3];
    t.process = fork();
    if (t.process == 0) {
        if (ptrace(PTRACE_TRACEME, 0, NULL, NULL) == 0 && raise(SIGSTOP) == 0)
            execvp(argv[4], argv + 4);
        _exit(2);
    }
    if (t.process < 0 || waitpid(t.process, &code, 0) != t.process || !WIFSTOPPED(code))
        return 2;
    if (ptrace(PTRACE_SETOPTIONS, t.process, NULL,
               (void *)(PTRACE_O_TRACESYSGOOD | PTRACE_O_TRACECLONE | PTRACE_O_TRACEFORK |
                        PTRACE_O_TRACEVFORK | PTRACE_O_EXITKILL)) < 0)
        return 2;
    ptrace(PTRACE_SYSCALL, t.process, NULL, NULL);
    code = trace(&t);
    if (code < 0)
        return 0;
    printf("exit code %d after %ld changes\n", code, t.count);
    return 3;
}
