/* SPDX-License-Identifier: BSD-3-Clause */
/* A library for LD_PRELOAD that lets the n-th call of one kind fail in a program, once or from
 * there on. It is told by environment variables what to do; without FAULT_KIND it only counts.
 *
 *   FAULT_KIND    alloc, write, sync, rename, open, map or thread: see `kinds` below
 *   FAULT_AT      the number of the call that fails, from 1
 *   FAULT_MODE    once (default), or on: all later calls of the kind fail, too
 *   FAULT_ERROR   ENOMEM, ENOSPC, EIO, EMFILE or EAGAIN; SHORT: half of what was to be written is
 *                 written; KILL: the process is killed instead of doing the call
 *   FAULT_RANK    only the MPI process of this rank has faults (default: all)
 *   FAULT_WITHIN  BEGIN-END, offsets of code in the program, in hexadecimal: only calls count that
 * are made while a function between them works (default: all) FAULT_REPORT  a file, to which are
 * appended: where the fault was, and at exit the numbers of calls of each kind; the rank, if any,
 * is added to its name FAULT_SITES   N: each call is reported, too, as "site KIND NUMBER STACK",
 * where STACK is a hash of the return addresses out to the N-th in the program itself; it is the
 * same for calls that come the same way, in this process
 *
 * Which calls count: those of the program itself and of the libraries that it calls, so that a
 * fault number means the same in each run. Each call is judged by the return addresses on its
 * stack. From the innermost on, the C library is passed over; then
 *
 *   a call from the program itself counts;
 *   a call from MPI and what belongs to it, from libgomp (which ends the process without memory),
 *   or from a library that was loaded later (the plug-ins of MPI) does not count; but those that
 *   segcast loads itself, libav and what it depends on, do, once they are loaded: constructors of
 *   foreign libraries end the process without memory;
 *   a call from any other library counts if the program is found further out before MPI is, or if
 *   neither is found: then it is a thread of that library (the encoder has some).
 *
 * Nothing counts before the first call of the program itself: those are constructors of libraries.
 * Streams and descriptors up to 2 never fail, because messages go there. A call that the C library
 * makes to itself cannot be seen; that is why fwrite, fflush, fclose and their kind are handled
 * instead of the write() in them: a failing one sets the error mark of its stream. */
#define _GNU_SOURCE
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <execinfo.h>
#include <fcntl.h>
#include <limits.h>
#include <link.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

/* ---- what is in memory where ---- */

typedef enum owner { OWNER_OTHER, OWNER_PROGRAM, OWNER_LIBRARY, OWNER_C } owner;

/* The code of an executable or library. */
typedef struct object {
    uintptr_t from, to, base;
    owner owner;
    const char *name; /* borrowed from the loader */
} object;

enum { OBJECTS_MAX = 512, FRAMES_MAX = 64 };
static object objects[OBJECTS_MAX];
static int object_count;

/* @return whether @p name begins with one of the words. */
static bool begins(const char *name, const char *const *words)
{
    for (; *words; words++) {
        if (!strncmp(name, *words, strlen(*words)))
            return true;
    }
    return false;
}

/* @return to whom a library belongs, by the name of its file. */
static owner owner_of(const char *name)
{
    static const char *const c_library[] = {"libc.so",  "libc-",    "libpthread", "ld-linux",
                                            "libm.so",  "libgcc_s", "libdl",      "linux-vdso",
                                            "libfault", NULL};
    static const char *const others[] = {"libmpi",  "libopen-", "libpmi", "libhwloc", "libevent",
                                         "libucp",  "libucs",   "libuct", "libucm",   "libfabric",
                                         "libgomp", "libomp",   NULL};

    return begins(name, c_library) ? OWNER_C : begins(name, others) ? OWNER_OTHER : OWNER_LIBRARY;
}

/* For dl_iterate_phdr: note the code of one executable or library unless it is known. The first is
 * the program. @param user whose a library is, an owner; NULL: by its name. */
static int note_object(struct dl_phdr_info *info, size_t size, void *user)
{
    const char *slash = strrchr(info->dlpi_name, '/');
    const char *name = slash ? slash + 1 : info->dlpi_name;
    const owner *given = user;

    (void)size;
    for (int i = 0; i < object_count; i++) {
        if (objects[i].base == info->dlpi_addr)
            return 0;
    }
    for (int i = 0; i < info->dlpi_phnum && object_count < OBJECTS_MAX; i++) {
        const ElfW(Phdr) *part = &info->dlpi_phdr[i];

        if (part->p_type == PT_LOAD && (part->p_flags & PF_X)) {
            const uintptr_t from = info->dlpi_addr + part->p_vaddr;

            objects[object_count++] = (object){from, from + part->p_memsz, info->dlpi_addr,
                                               given     ? *given
                                               : name[0] ? owner_of(name)
                                                         : OWNER_PROGRAM,
                                               name[0] ? name : "segcast"};
        }
    }
    return 0;
}

/* @return the object that holds @p address, or NULL. */
static const object *object_at(const void *address)
{
    const uintptr_t at = (uintptr_t)address;

    for (int i = 0; i < object_count; i++) {
        if (at >= objects[i].from && at < objects[i].to)
            return &objects[i];
    }
    return NULL;
}

static owner owner_at(const void *address)
{
    const object *found = object_at(address);

    return found ? found->owner : OWNER_OTHER;
}

/* ---- the settings, and the numbers of calls ---- */

typedef enum kind {
    KIND_ALLOC,  /* malloc, calloc, realloc, posix_memalign, aligned_alloc, memalign */
    KIND_WRITE,  /* write, pwrite, writev, fwrite, fputs, fputc, fprintf, fflush, fclose, ftruncate,
                    posix_fallocate */
    KIND_SYNC,   /* fsync, fdatasync */
    KIND_RENAME, /* rename, renameat */
    KIND_OPEN,   /* open, openat, creat, fopen, fdopen, opendir, mkdir */
    KIND_MAP,    /* mmap */
    KIND_THREAD, /* pthread_create */
    KIND_COUNT
} kind;

static const char *const kinds[KIND_COUNT] = {"alloc", "write", "sync",  "rename",
                                              "open",  "map",   "thread"};
enum { ERROR_SHORT = -1, ERROR_KILL = -2 };

static atomic_long calls[KIND_COUNT];
static atomic_bool armed;           /* the program itself has made a call */
static bool ready;                  /* the constructor has run */
static int fault_kind = KIND_COUNT; /* none */
static long fault_at = -1;
static bool fault_on;
static int fault_error = EIO;
static long site_depth;                        /* 0: sites are not reported */
static unsigned long within_begin, within_end; /* offsets in the program; 0: everywhere */
static char report[4096];
static __thread bool busy; /* within this library: what it calls does not count */

/* Append to the report, without any function that could fail or count here. */
static void tell(const char *text)
{
    const int file =
        report[0] ? (int)syscall(SYS_openat, AT_FDCWD, report, O_WRONLY | O_CREAT | O_APPEND, 0666)
                  : -1;

    if (file < 0)
        return;
    (void)!syscall(SYS_write, file, text, strlen(text));
    syscall(SYS_close, file);
}

/* Report a fault with the innermost return addresses: "segcast+OFFSET" in the program (for
 * addr2line), "LIBRARY:FUNCTION" elsewhere, where FUNCTION is the last public one before the
 * address. */
static void tell_fault(kind what, const char *function, long number)
{
    void *frames[FRAMES_MAX];
    char text[4096];
    const int count = backtrace(frames, FRAMES_MAX);
    int used = snprintf(text, sizeof text, "fault %s %ld %s", kinds[what], number, function);

    for (int i = 0; i < count && used < (int)sizeof text - 300; i++) {
        const object *found = object_at(frames[i]);
        Dl_info info = {0};

        if (!found || found->owner == OWNER_C)
            continue;
        if (found->owner == OWNER_PROGRAM)
            used += snprintf(text + used, sizeof text - (size_t)used, " segcast+0x%lx",
                             (unsigned long)((uintptr_t)frames[i] - found->base));
        else
            used += snprintf(text + used, sizeof text - (size_t)used, " %.*s:%.80s",
                             (int)strcspn(found->name, "."), found->name,
                             dladdr(frames[i], &info) && info.dli_sname ? info.dli_sname : "?");
    }
    snprintf(text + used, sizeof text - (size_t)used, "\n");
    tell(text);
}

/* Report the number of a call, and a hash (FNV-1a) of the way to it. */
static void tell_site(kind what, long number)
{
    void *frames[FRAMES_MAX];
    char text[80];
    uint64_t hash = 14695981039346656037u;
    const int count = backtrace(frames, FRAMES_MAX);

    for (int i = 0, depth = 0; i < count && depth < site_depth; i++) {
        depth += owner_at(frames[i]) == OWNER_PROGRAM;
        for (int bit = 0; bit < 64; bit += 8)
            hash = (hash ^ ((uintptr_t)frames[i] >> bit & 255)) * 1099511628211u;
    }
    snprintf(text, sizeof text, "site %s %ld %016lx\n", kinds[what], number, (unsigned long)hash);
    tell(text);
}

/* @return whether a call counts that returns to @p address; see the top of this file. */
static bool counts(const void *address)
{
    void *frames[FRAMES_MAX];
    owner found = owner_at(address);
    int count;

    if (found == OWNER_PROGRAM)
        return true;
    if (found == OWNER_OTHER || !armed)
        return false;
    count = backtrace(frames, FRAMES_MAX);
    for (int i = 0; i < count; i++) {
        const owner here = owner_at(frames[i]);

        if (here == OWNER_C)
            continue;
        if (here != OWNER_LIBRARY)
            return here == OWNER_PROGRAM;
        found = here;
    }
    return found == OWNER_LIBRARY;
}

/* @return whether one of the functions works that FAULT_WITHIN names. */
static bool is_within(void)
{
    void *frames[FRAMES_MAX];
    const int count = within_end ? backtrace(frames, FRAMES_MAX) : 0;

    for (int i = 0; i < count; i++) {
        const object *found = object_at(frames[i]);
        const unsigned long offset = found ? (uintptr_t)frames[i] - found->base : 0;

        if (found && found->owner == OWNER_PROGRAM && offset > within_begin && offset <= within_end)
            return true;
    }
    return !within_end;
}

/* Count a call that counts, and decide whether it is to fail. @return as fault. */
static int fault_of_counted(kind what, const char *function)
{
    const long number = atomic_fetch_add(&calls[what], 1) + 1;

    if (site_depth > 0)
        tell_site(what, number);
    if (what != (kind)fault_kind || (fault_on ? number < fault_at : number != fault_at))
        return 0;
    if (number == fault_at)
        tell_fault(what, function, number);
    if (fault_error == ERROR_KILL)
        kill(getpid(), SIGKILL);
    return fault_error;
}

/* Count a call, and decide whether it is to fail. @param address where it returns to. @return the
 * errno with which to fail, ERROR_SHORT, or 0. Leaves errno alone. */
static int fault(kind what, const char *function, const void *address)
{
    const int before = errno;
    int error = 0;

    if (!ready || busy)
        return 0;
    busy = true;
    if (counts(address)) {
        armed = true;
        if (is_within())
            error = fault_of_counted(what, function);
    }
    busy = false;
    errno = before;
    return error;
}

/* Count a call of the function that contains this macro. */
#define FAULT(what) fault(what, __func__, __builtin_return_address(0))

/* ---- beginning and end ---- */

/* @return the error that a word stands for. */
static int error_named(const char *word)
{
    static const struct {
        const char *word;
        int error;
    } errors[] = {{"ENOMEM", ENOMEM},  {"ENOSPC", ENOSPC}, {"EIO", EIO},
                  {"EMFILE", EMFILE},  {"EAGAIN", EAGAIN}, {"SHORT", ERROR_SHORT},
                  {"KILL", ERROR_KILL}};

    for (size_t i = 0; i < sizeof errors / sizeof *errors; i++) {
        if (!strcmp(errors[i].word, word))
            return errors[i].error;
    }
    return EIO;
}

/* @return the rank that an MPI launcher has given to this process, or NULL. */
static const char *own_rank(void)
{
    const char *rank = getenv("OMPI_COMM_WORLD_RANK");

    return rank ? rank : getenv("PMI_RANK");
}

__attribute__((constructor)) static void begin(void)
{
    void *frames[4];
    const char *what = getenv("FAULT_KIND"), *at = getenv("FAULT_AT"), *on = getenv("FAULT_MODE");
    const char *error = getenv("FAULT_ERROR"), *only = getenv("FAULT_RANK");
    const char *file = getenv("FAULT_REPORT"), *rank = own_rank();
    const char *sites = getenv("FAULT_SITES"), *within = getenv("FAULT_WITHIN");
    const char *program = program_invocation_short_name;

    /* The variables reach the launcher, its daemons and shells as well: they are left alone. */
    if (strncmp(program, "segcast", 7))
        return;
    (void)backtrace(frames, 4); /* the first call loads a library */
    dl_iterate_phdr(note_object, NULL);
    if (file)
        snprintf(report, sizeof report, "%s%s%s", file, rank ? "." : "", rank ? rank : "");
    for (int i = 0; what && i < KIND_COUNT; i++) {
        if (!strcmp(kinds[i], what))
            fault_kind = i;
    }
    if (only && rank && strcmp(only, rank))
        fault_kind = KIND_COUNT;
    fault_at = at ? atol(at) : -1;
    fault_on = on && !strcmp(on, "on");
    fault_error = error ? error_named(error) : EIO;
    site_depth = sites ? atol(sites) : 0;
    if (within && sscanf(within, "%lx-%lx", &within_begin, &within_end) != 2)
        within_end = ULONG_MAX;
    ready = true;
}

__attribute__((destructor)) static void end(void)
{
    char text[512];
    int used = 0;

    if (!ready)
        return;
    ready = false;
    for (int i = 0; i < KIND_COUNT; i++)
        used += snprintf(text + used, sizeof text - (size_t)used, "calls %s %ld\n", kinds[i],
                         (long)calls[i]);
    tell(text);
}

/* The function that this library hides. */
#define REAL(result, name, ...)                                                                    \
    static result (*real)(__VA_ARGS__);                                                            \
    if (!real)                                                                                     \
    real = (result(*)(__VA_ARGS__))dlsym(RTLD_NEXT, name)

/* ---- memory: dlsym allocates, so that these use the names that glibc has for this purpose ---- */

extern void *__libc_malloc(size_t bytes);
extern void *__libc_calloc(size_t count, size_t size);
extern void *__libc_realloc(void *block, size_t bytes);
extern void *__libc_memalign(size_t alignment, size_t bytes);

/* Fail as functions do that return a pointer. */
#define FAIL_NULL(what)                                                                            \
    do {                                                                                           \
        const int error_ = FAULT(what);                                                            \
        if (error_) {                                                                              \
            errno = error_ > 0 ? error_ : EIO;                                                     \
            return NULL;                                                                           \
        }                                                                                          \
    } while (0)

void *malloc(size_t bytes)
{
    FAIL_NULL(KIND_ALLOC);
    return __libc_malloc(bytes);
}

void *calloc(size_t count, size_t size)
{
    FAIL_NULL(KIND_ALLOC);
    return __libc_calloc(count, size);
}

void *realloc(void *block, size_t bytes)
{
    if (bytes > 0)
        FAIL_NULL(KIND_ALLOC);
    return __libc_realloc(block, bytes);
}

void *memalign(size_t alignment, size_t bytes)
{
    FAIL_NULL(KIND_ALLOC);
    return __libc_memalign(alignment, bytes);
}

void *aligned_alloc(size_t alignment, size_t bytes)
{
    FAIL_NULL(KIND_ALLOC);
    return __libc_memalign(alignment, bytes);
}

int posix_memalign(void **out, size_t alignment, size_t bytes)
{
    void *block = FAULT(KIND_ALLOC) ? NULL : __libc_memalign(alignment, bytes);

    if (!block) {
        errno = ENOMEM; /* as glibc does, although POSIX does not ask for it */
        return ENOMEM;
    }
    *out = block;
    return 0;
}

/* ---- libraries that segcast loads itself ---- */

void *dlopen(const char *name, int flags)
{
    static owner plug_in = OWNER_OTHER;
    const char *slash = name ? strrchr(name, '/') : NULL;
    const bool of_segcast = ready && slash && !strncmp(slash + 1, "segcast-", 8);
    const bool before = busy;
    void *file;
    REAL(void *, "dlopen", const char *, int);

    if (!of_segcast)
        return real(name, flags);
    busy = true;
    dl_iterate_phdr(note_object, &plug_in); /* what MPI has loaded so far */
    file = real(name, flags);
    dl_iterate_phdr(note_object, NULL);
    busy = before;
    return file;
}

/* ---- descriptors ---- */

/* Fail as functions do that return a number. */
#define FAIL_NUMBER(what, file)                                                                    \
    do {                                                                                           \
        const int error_ = (file) > 2 ? FAULT(what) : 0;                                           \
        if (error_) {                                                                              \
            errno = error_ > 0 ? error_ : EIO;                                                     \
            return -1;                                                                             \
        }                                                                                          \
    } while (0)

/* As FAIL_NUMBER, for a function that writes @p bytes: of a short one half is done. */
#define FAIL_WRITE(file, bytes)                                                                    \
    do {                                                                                           \
        const int error_ = (file) > 2 ? FAULT(KIND_WRITE) : 0;                                     \
        if (error_ == ERROR_SHORT) {                                                               \
            bytes = (bytes + 1) / 2;                                                               \
        } else if (error_) {                                                                       \
            errno = error_;                                                                        \
            return -1;                                                                             \
        }                                                                                          \
    } while (0)

ssize_t write(int file, const void *data, size_t bytes)
{
    FAIL_WRITE(file, bytes);
    return syscall(SYS_write, file, data, bytes);
}

ssize_t pwrite(int file, const void *data, size_t bytes, off_t at)
{
    FAIL_WRITE(file, bytes);
    return syscall(SYS_pwrite64, file, data, bytes, at);
}

ssize_t pwrite64(int file, const void *data, size_t bytes, off64_t at)
{
    FAIL_WRITE(file, bytes);
    return syscall(SYS_pwrite64, file, data, bytes, at);
}

ssize_t writev(int file, const struct iovec *parts, int count)
{
    FAIL_NUMBER(KIND_WRITE, file);
    return syscall(SYS_writev, file, parts, count);
}

int ftruncate(int file, off_t bytes)
{
    FAIL_NUMBER(KIND_WRITE, file);
    return (int)syscall(SYS_ftruncate, file, bytes);
}

int posix_fallocate(int file, off_t from, off_t bytes)
{
    const int error = FAULT(KIND_WRITE);
    REAL(int, "posix_fallocate", int, off_t, off_t);

    return error ? (error > 0 ? error : ENOSPC) : real(file, from, bytes);
}

int fsync(int file)
{
    FAIL_NUMBER(KIND_SYNC, file);
    return (int)syscall(SYS_fsync, file);
}

int fdatasync(int file)
{
    FAIL_NUMBER(KIND_SYNC, file);
    return (int)syscall(SYS_fdatasync, file);
}

int rename(const char *from, const char *to)
{
    FAIL_NUMBER(KIND_RENAME, INT_MAX);
    return (int)syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0);
}

int renameat(int from_folder, const char *from, int to_folder, const char *to)
{
    FAIL_NUMBER(KIND_RENAME, INT_MAX);
    return (int)syscall(SYS_renameat2, from_folder, from, to_folder, to, 0);
}

/* The permissions that follow the flags of open if it makes a file. */
#define READ_MODE(flags, mode)                                                                     \
    do {                                                                                           \
        va_list list_;                                                                             \
        if (!((flags) & (O_CREAT | O_TMPFILE)))                                                    \
            break;                                                                                 \
        va_start(list_, flags);                                                                    \
        mode = va_arg(list_, mode_t);                                                              \
        va_end(list_);                                                                             \
    } while (0)

int open(const char *path, int flags, ...)
{
    mode_t mode = 0;

    READ_MODE(flags, mode);
    FAIL_NUMBER(KIND_OPEN, INT_MAX);
    return (int)syscall(SYS_openat, AT_FDCWD, path, flags, mode);
}

int open64(const char *path, int flags, ...)
{
    mode_t mode = 0;

    READ_MODE(flags, mode);
    FAIL_NUMBER(KIND_OPEN, INT_MAX);
    return (int)syscall(SYS_openat, AT_FDCWD, path, flags, mode);
}

int openat(int folder, const char *path, int flags, ...)
{
    mode_t mode = 0;

    READ_MODE(flags, mode);
    FAIL_NUMBER(KIND_OPEN, INT_MAX);
    return (int)syscall(SYS_openat, folder, path, flags, mode);
}

int openat64(int folder, const char *path, int flags, ...)
{
    mode_t mode = 0;

    READ_MODE(flags, mode);
    FAIL_NUMBER(KIND_OPEN, INT_MAX);
    return (int)syscall(SYS_openat, folder, path, flags, mode);
}

int mkdir(const char *path, mode_t mode)
{
    FAIL_NUMBER(KIND_OPEN, INT_MAX);
    return (int)syscall(SYS_mkdirat, AT_FDCWD, path, mode);
}

DIR *opendir(const char *path)
{
    REAL(DIR *, "opendir", const char *);

    FAIL_NULL(KIND_OPEN);
    return real(path);
}

void *mmap(void *at, size_t bytes, int protection, int flags, int file, off_t offset)
{
    const int error = FAULT(KIND_MAP);

    if (error) {
        errno = error > 0 ? error : ENOMEM;
        return MAP_FAILED;
    }
    return (void *)syscall(SYS_mmap, at, bytes, protection, flags, file, offset);
}

void *mmap64(void *at, size_t bytes, int protection, int flags, int file, off64_t offset)
{
    const int error = FAULT(KIND_MAP);

    if (error) {
        errno = error > 0 ? error : ENOMEM;
        return MAP_FAILED;
    }
    return (void *)syscall(SYS_mmap, at, bytes, protection, flags, file, offset);
}

int pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*run)(void *),
                   void *user)
{
    const int error = FAULT(KIND_THREAD);
    REAL(int, "pthread_create", pthread_t *, const pthread_attr_t *, void *(*)(void *), void *);

    return error ? EAGAIN : real(thread, attributes, run, user);
}

/* ---- streams ---- */

enum { ERROR_MARK = 0x20 }; /* glibc: _IO_ERR_SEEN in FILE._flags, which ferror() tests */

FILE *fopen(const char *path, const char *mode)
{
    REAL(FILE *, "fopen", const char *, const char *);

    FAIL_NULL(KIND_OPEN);
    return real(path, mode);
}

FILE *fopen64(const char *path, const char *mode)
{
    REAL(FILE *, "fopen64", const char *, const char *);

    FAIL_NULL(KIND_OPEN);
    return real(path, mode);
}

FILE *fdopen(int file, const char *mode)
{
    REAL(FILE *, "fdopen", int, const char *);

    FAIL_NULL(KIND_OPEN);
    return real(file, mode);
}

/* Count a function that writes to a stream on a file. @return 0, or the errno to fail with, which
 * is set, as is the mark of the stream; ERROR_SHORT is like no room. */
static int stream_fault(FILE *stream, const char *function, const void *address)
{
    int error = stream && fileno(stream) > 2 ? fault(KIND_WRITE, function, address) : 0;

    if (!error)
        return 0;
    error = error > 0 ? error : ENOSPC;
    stream->_flags |= ERROR_MARK;
    errno = error;
    return error;
}

#define STREAM_FAULT(stream) stream_fault(stream, __func__, __builtin_return_address(0))

size_t fwrite(const void *data, size_t size, size_t count, FILE *stream)
{
    REAL(size_t, "fwrite", const void *, size_t, size_t, FILE *);

    if (STREAM_FAULT(stream)) {
        const int error = errno;
        const size_t written = fault_error == ERROR_SHORT ? real(data, size, count / 2, stream) : 0;

        errno = error;
        return written;
    }
    return real(data, size, count, stream);
}

int fputs(const char *text, FILE *stream)
{
    REAL(int, "fputs", const char *, FILE *);

    return STREAM_FAULT(stream) ? EOF : real(text, stream);
}

int fputc(int letter, FILE *stream)
{
    REAL(int, "fputc", int, FILE *);

    return STREAM_FAULT(stream) ? EOF : real(letter, stream);
}

int vfprintf(FILE *stream, const char *format, va_list list)
{
    REAL(int, "vfprintf", FILE *, const char *, va_list);

    return STREAM_FAULT(stream) ? -1 : real(stream, format, list);
}

int fprintf(FILE *stream, const char *format, ...)
{
    REAL(int, "vfprintf", FILE *, const char *, va_list);
    va_list list;
    int written;

    if (STREAM_FAULT(stream))
        return -1;
    va_start(list, format);
    written = real(stream, format, list);
    va_end(list);
    return written;
}

int fflush(FILE *stream)
{
    REAL(int, "fflush", FILE *);

    return STREAM_FAULT(stream) ? EOF : real(stream);
}

/* The stream is closed, also if that fails. What it held is lost then, as on a full disk. */
int fclose(FILE *stream)
{
    const bool writes = stream && (fcntl(fileno(stream), F_GETFL) & O_ACCMODE) != O_RDONLY;
    const int error = writes ? STREAM_FAULT(stream) : 0;
    REAL(int, "fclose", FILE *);
    int closed = real(stream);

    if (error) {
        errno = error;
        closed = EOF;
    }
    return closed;
}
