/* SPDX-License-Identifier: BSD-3-Clause */
/* Output files: written under a temporary name that nobody can guess, and given their name only
 * when they are complete. */
#define _GNU_SOURCE /* renameat2 */
#include "segcast/base.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

/* A temporary name is ".NAME.tmp.HOST.PID.RANDOM": NAME is cut, so that all of it is a name that
 * file systems accept, and RANDOM has this many hexadecimal digits. */
enum { NAME_PART_BYTES = 64, RANDOM_DIGITS = 16, TRIES = 100 };

_Static_assert(SC_HOST_BYTES > HOST_NAME_MAX, "every host name fits");

void sc_host_name(char out[SC_HOST_BYTES])
{
    memset(out, 0, SC_HOST_BYTES);
    if (gethostname(out, SC_HOST_BYTES - 1) || !out[0])
        strcpy(out, "host");
}

/* @return @p length, or less, so that the first bytes of @p text end between two characters of
 * UTF-8. */
static size_t cut_between_characters(const char *text, size_t length)
{
    while (length > 0 && ((unsigned char)text[length] & 0xc0) == 0x80)
        length--;
    return length;
}

/* Make a temporary name beside @p path, another one at each call. Caller owns *out: sc_free. */
static sc_status temporary_name(const sc_ctx *ctx, const char *path, char **out)
{
    const char *name = sc_file_name(path);
    size_t length = strlen(name);
    char host[SC_HOST_BYTES];
    uint64_t random;
    sc_text text = {0};

    if (getrandom(&random, sizeof random, 0) != (ssize_t)sizeof random)
        return sc_fail(ctx, SC_ERR_CREATE, "%s: cannot be created: no random numbers: %s", path,
                       sc_reason(errno));
    if (length > NAME_PART_BYTES)
        length = cut_between_characters(name, NAME_PART_BYTES);
    /* The host is part of the name, too: a node that lost its network may go on writing while the
     * batch system has begun the job again elsewhere. */
    sc_host_name(host);
    SC_PASS(sc_text_add(ctx, &text, "%.*s.%.*s.tmp.%s.%ld.%0*llx", (int)(name - path), path,
                        (int)length, name, host, (long)getpid(), RANDOM_DIGITS,
                        (unsigned long long)random));
    *out = text.data;
    return SC_OK;
}

/* Read ".NAME.tmp.HOST.PID.RANDOM", where NAME and HOST may contain dots. @param here whether
 * that is @p host. @return PID, or 0 if @p name is not of this form. */
static long temporary_owner(const char *name, const char *host, bool *here)
{
    const char *random = strrchr(name, '.'), *process, *mark, *begin = NULL;
    char *end;
    long number;

    if (name[0] != '.' || !random || strspn(random + 1, "0123456789abcdef") != RANDOM_DIGITS ||
        random[1 + RANDOM_DIGITS])
        return 0;
    for (process = random; process > name && process[-1] != '.'; process--)
        continue;
    number = strtol(process, &end, 10);
    if (process == name || end != random || *process < '1' || *process > '9')
        return 0;
    process--; /* the dot behind the host */
    for (mark = name + 1; (mark = strstr(mark, ".tmp.")) && mark + 5 < process; mark++)
        begin = mark + 5;
    if (!begin)
        return 0;
    *here = strlen(host) <= (size_t)(process - name - 5) &&
            !memcmp(process - strlen(host), host, strlen(host)) &&
            !memcmp(process - strlen(host) - 5, ".tmp.", 5);
    return number;
}

/* What /proc/PID/stat says of a process. */
typedef struct process_stat {
    char state;               /* 'Z': it has ended, and waits until its parent asks for its code */
    unsigned long flags;      /* of the kernel: PROCESS_EXITS */
    unsigned long long ticks; /* when it began, since the machine did: sysconf(_SC_CLK_TCK) */
} process_stat;
enum { PROCESS_EXITS = 4 }; /* PF_EXITING: it is being ended, which may take seconds */

/* @return false where that cannot be read. */
static bool read_process_stat(long number, process_stat *out)
{
    /* Spaces from the state, which follows the name, to the fields flags and starttime. */
    enum { FIELDS_TO_FLAGS = 6, FIELDS_TO_START = 13 };
    char path[64], text[1024], *at;
    size_t length = 0;
    FILE *stream;

    snprintf(path, sizeof path, "/proc/%ld/stat", number);
    stream = fopen(path, "r");
    if (stream) {
        length = fread(text, 1, sizeof text - 1, stream);
        fclose(stream);
    }
    text[length] = '\0';
    at = strrchr(text, ')'); /* the name before it may hold spaces */
    if (!at || sscanf(at, ") %c", &out->state) != 1)
        return false;
    for (int i = 0; i < 1 + FIELDS_TO_FLAGS && at; i++)
        at = strchr(at + 1, ' ');
    if (!at || sscanf(at, " %lu", &out->flags) != 1)
        return false;
    for (int i = 0; i < FIELDS_TO_START && at; i++)
        at = strchr(at + 1, ' ');
    return at && sscanf(at, " %llu", &out->ticks) == 1;
}

/* Did a process begin more than a moment after the time @p when of the clock? Then it has the
 * number of an earlier process that is gone. @return false also where that cannot be told. */
static bool began_after(const process_stat *process, const struct timespec *when)
{
    enum { MARGIN_S = 2 };
    struct timespec now, since_boot;

    if (clock_gettime(CLOCK_REALTIME, &now) || clock_gettime(CLOCK_BOOTTIME, &since_boot))
        return false;
    return (double)(now.tv_sec - since_boot.tv_sec) +
               (double)process->ticks / (double)sysconf(_SC_CLK_TCK) >
           (double)when->tv_sec + MARGIN_S;
}

/* Can the process @p number of this host not go on writing a file that was last written at the time
 * @p when? A process that was killed stays in the list of processes while the system takes its
 * memory back, and until its parent, which may be gone as well, asks for its exit code. */
static bool is_gone(long number, const struct timespec *when)
{
    process_stat process = {.state = 0};

    if (kill((pid_t)number, 0) != 0 && errno == ESRCH)
        return true;
    return read_process_stat(number, &process) &&
           (process.state == 'Z' || process.state == 'X' || (process.flags & PROCESS_EXITS) ||
            began_after(&process, when));
}

void sc_remove_temporaries(const char *directory, bool all)
{
    DIR *stream = opendir(directory);
    char host[SC_HOST_BYTES];
    const struct dirent *entry;

    sc_host_name(host);
    while (stream && (entry = readdir(stream))) {
        bool here = false;
        const long process = temporary_owner(entry->d_name, host, &here);
        struct stat info;

        if (process <= 0 || (!here && !all) ||
            fstatat(dirfd(stream), entry->d_name, &info, AT_SYMLINK_NOFOLLOW) ||
            !S_ISREG(info.st_mode))
            continue;
        if (!here || is_gone(process, &info.st_mtim))
            unlinkat(dirfd(stream), entry->d_name, 0);
    }
    if (stream)
        closedir(stream);
}

/* ---- files to be removed if a signal ends the process ---- */

/* Paths of files that are not complete. A signal handler reads them while other threads go on:
 * therefore they lie in memory that is never freed, and a slot is written only while it is
 * TAKEN. */
enum { UNFINISHED_MAX = 64 };
enum { SLOT_FREE, SLOT_TAKEN, SLOT_SET };
static struct {
    atomic_int state;
    char path[PATH_MAX];
} unfinished[UNFINISHED_MAX];
static atomic_int ending; /* sc_unfinished_remove was called */

/* Stand still while the process ends, so that nothing is made after it was cleaned up. */
static void wait_for_end(void)
{
    while (atomic_load(&ending))
        pause();
}

int sc_unfinished_add(const char *path)
{
    if (strlen(path) >= PATH_MAX)
        return -1;
    for (int i = 0; i < UNFINISHED_MAX; i++) {
        int expected = SLOT_FREE;

        if (!atomic_compare_exchange_strong(&unfinished[i].state, &expected, SLOT_TAKEN))
            continue;
        wait_for_end();
        strcpy(unfinished[i].path, path);
        atomic_store(&unfinished[i].state, SLOT_SET);
        return i;
    }
    return -1;
}

void sc_unfinished_drop(int number)
{
    if (number >= 0)
        atomic_store(&unfinished[number].state, SLOT_FREE);
}

void sc_unfinished_remove(void)
{
    atomic_store(&ending, 1);
    /* The second time for a file that another thread was about to open. */
    for (int time = 0; time < 2; time++) {
        for (int i = 0; i < UNFINISHED_MAX; i++) {
            if (atomic_load(&unfinished[i].state) == SLOT_SET && unlink(unfinished[i].path))
                (void)rmdir(unfinished[i].path);
        }
        if (time == 0)
            (void)poll(NULL, 0, 10);
    }
}

/* ---- writing ---- */

/* Open a new temporary file beside @p path for writing and reading. It is never one that was there
 * before, nor behind a symbolic link, so that whoever else may write to the directory can make it
 * neither change nor show other files. @param out_name caller owns: sc_free. @return SC_ERR_CREATE,
 * SC_ERR_MEMORY. @param out_number for sc_unfinished_drop. */
static sc_status open_temporary(const sc_ctx *ctx, const char *path, char **out_name, int *out_fd,
                                int *out_number)
{
    for (int i = 0; i < TRIES; i++) {
        char *name = NULL;
        int fd, error, number;

        SC_PASS(temporary_name(ctx, path, &name));
        number = sc_unfinished_add(name);
        fd = open(name, O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
        error = errno;
        if (fd >= 0) {
            *out_name = name;
            *out_fd = fd;
            *out_number = number;
            return SC_OK;
        }
        sc_unfinished_drop(number);
        sc_free(name);
        if (error != EEXIST)
            return sc_fail(ctx, SC_ERR_CREATE, "%s: cannot be created: %s", path, sc_reason(error));
    }
    return sc_fail(ctx, SC_ERR_CREATE, "%s: no free temporary name in %d tries", path, TRIES);
}

sc_status sc_outfile_open(const sc_ctx *ctx, const char *path, bool replace, sc_outfile *out)
{
    SC_OWN(sc_outfile_discard) sc_outfile file = {.replace = replace, .unfinished = -1};
    int fd = -1;

    SC_PASS(sc_text_copy(ctx, path, &file.path));
    SC_PASS(open_temporary(ctx, path, &file.temporary, &fd, &file.unfinished));
    file.stream = fdopen(fd, "w+b");
    if (!file.stream) {
        const int error = errno;

        close(fd);
        return sc_fail(ctx, SC_ERR_CREATE, "%s: cannot be created: %s", path, sc_reason(error));
    }
    SC_HAND_OVER(file, out);
    return SC_OK;
}

sc_status sc_outfile_rename(const sc_ctx *ctx, sc_outfile *file, const char *path)
{
    sc_text copy = {0};

    SC_PASS(sc_text_add(ctx, &copy, "%s", path));
    sc_free(file->path);
    file->path = copy.data;
    return SC_OK;
}

void sc_outfile_discard(sc_outfile *file)
{
    if (file->stream)
        fclose(file->stream);
    if (file->temporary) {
        unlink(file->temporary);
        sc_unfinished_drop(file->unfinished);
    }
    sc_free(file->path);
    sc_free(file->temporary);
    *file = (sc_outfile){0};
}

/* Give @p temporary the name @p path, unless that is taken. @return 0, or the errno of the failure:
 * EEXIST if it is taken. */
static int give_free_name(const char *temporary, const char *path)
{
    struct stat info;

    if (!renameat2(AT_FDCWD, temporary, AT_FDCWD, path, RENAME_NOREPLACE))
        return 0;
    if (errno != EINVAL && errno != ENOSYS)
        return errno;
    /* This file system cannot do it in one step (NFS). A second link is as good, where it has any.
     */
    if (!link(temporary, path)) {
        unlink(temporary);
        return 0;
    }
    if (errno == EEXIST || !lstat(path, &info))
        return EEXIST;
    return rename(temporary, path) ? errno : 0;
}

/* Flush the directory that holds @p path to disk, as far as the file system can and the user may
 * (who can make files also in a directory that may not be read). @return 0, or the errno of the
 * failure. */
static int sync_directory_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    char *directory = slash ? strndup(path, (size_t)(slash - path) + 1) : strdup(".");
    const int fd = directory ? open(directory, O_RDONLY | O_DIRECTORY | O_CLOEXEC) : -1;
    int failed = 0;

    if (fd < 0 || fsync(fd))
        failed = errno;
    if (fd >= 0)
        close(fd);
    free(directory);
    return failed == EINVAL || failed == EACCES ? 0 : failed;
}

sc_status sc_outfile_commit(const sc_ctx *ctx, sc_outfile *file)
{
    sc_status status = SC_OK;
    int error = 0;

    errno = 0;
    if (fflush(file->stream) || ferror(file->stream))
        error = errno ? errno : EIO;
    if (!error && !file->fleeting && fsync(fileno(file->stream)) && errno != EINVAL)
        error = errno;
    if (fclose(file->stream) && !error)
        error = errno;
    file->stream = NULL;
    if (!error && file->replace)
        error = rename(file->temporary, file->path) ? errno : 0;
    else if (!error)
        error = give_free_name(file->temporary, file->path);
    if (!error) {
        sc_unfinished_drop(file->unfinished);
        sc_free(file->temporary);
        file->temporary = NULL;
        error = file->fleeting ? 0 : sync_directory_of(file->path);
    }
    if (error == EEXIST && !file->replace)
        status = sc_fail(ctx, SC_ERR_CREATE,
                         "%s: a file of this name has appeared meanwhile, and stays; give another "
                         "name, or --overwrite to replace it",
                         file->path);
    else if (error)
        status =
            sc_fail(ctx, SC_ERR_WRITE, "%s: cannot be written: %s", file->path, sc_reason(error));
    sc_outfile_discard(file);
    return status;
}

sc_status sc_file_write(const sc_ctx *ctx, const char *path, const void *data, size_t bytes)
{
    sc_outfile file = {0};

    SC_PASS(sc_outfile_open(ctx, path, true, &file));
    if (bytes)
        fwrite(data, 1, bytes, file.stream);
    return sc_outfile_commit(ctx, &file);
}

/* ---- before the work ---- */

sc_status sc_outfile_check(const sc_ctx *ctx, const char *path, bool replace, const char *hint)
{
    SC_OWN(sc_free_at) char *directory = NULL;
    struct stat info;

    if (!*sc_file_name(path))
        return sc_fail(ctx, SC_ERR_CREATE, "\"%s\" is no name of a file to be written", path);
    if (!lstat(path, &info)) {
        if (!S_ISREG(info.st_mode))
            return sc_fail(ctx, SC_ERR_CREATE, "%s: is %s; segcast writes and replaces only files",
                           path,
                           S_ISDIR(info.st_mode)   ? "a directory"
                           : S_ISLNK(info.st_mode) ? "a symbolic link"
                                                   : "no regular file");
        if (!replace)
            return sc_fail(ctx, SC_ERR_CREATE,
                           "%s: exists, and is not replaced; give another name%s", path, hint);
    } else if (errno != ENOENT) {
        return sc_fail(ctx, SC_ERR_CREATE, "%s: cannot be created: %s", path, sc_reason(errno));
    }
    SC_PASS(sc_folder_of(ctx, path, &directory));
    if (access(directory, W_OK | X_OK))
        return sc_fail(ctx, SC_ERR_CREATE, "%s: cannot be created: %s: %s", path, directory,
                       sc_reason(errno));
    return SC_OK;
}

bool sc_same_file(const char *a, const char *b)
{
    struct stat first, second;

    return !stat(a, &first) && !stat(b, &second) && first.st_dev == second.st_dev &&
           first.st_ino == second.st_ino;
}
