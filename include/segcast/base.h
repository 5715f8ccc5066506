/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  What every module uses: return codes, the context (log and allocation budget), memory, text,
 *  hashes, files, clocks, threads, and what the machine has.
 *
 *  These hold for every segcast header:
 *  - A function that can fail returns sc_status. Outputs come last and are written only on success.
 *  - Who decides that something is an error logs it, once, with sc_fail(); callers only forward the
 *    return code.
 *  - Functions are local (not collective), and may be called by several threads at a time on
 *    different objects, unless their comment says otherwise.
 *  - The standard headers below come with this one: files that have it do not name them again.
 */
#ifndef SEGCAST_BASE_H
#define SEGCAST_BASE_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

/** Return code of a function that can fail. The order matters: ranks agree on the smallest
 *  (sc_comm_agree), so that the most severe error wins. */
typedef enum sc_status {
    SC_OK = 0,
    SC_ERR_INCOMPLETE = -1, /**< stopped early on request; another run can continue */
    SC_ERR_USAGE = -2,      /**< the request itself is wrong: command line, settings */
    SC_ERR_DATA = -3,       /**< an input, also a job file, exists and is broken */
    SC_ERR_MISSING = -4,    /**< an input does not exist or cannot be opened */
    SC_ERR_CREATE = -5,     /**< an output cannot be created */
    SC_ERR_WRITE = -6,      /**< an output cannot be written, e.g. the disk is full; or an input
                                 is there, but reading fails */
    SC_ERR_SYSTEM = -7,     /**< a limit or failure of the system, e.g. of the number of threads */
    SC_ERR_MEMORY = -8,     /**< out of memory, or a size that overflows */
    SC_ERR_INTERNAL = -9    /**< a bug of segcast or of a library */
} sc_status;

/** Marks a function whose result must not be ignored: the compiler warns. */
#define SC_MUST_USE __attribute__((warn_unused_result))
/** Marks a function that formats like printf: parameter number @p fmt is the format, and its
 *  arguments begin at number @p first. The compiler checks them against each other. */
#define SC_PRINTF(fmt, first) __attribute__((format(printf, fmt, first)))

/** Call a function that can fail; on an error go to the label `out`. The calling function has this
 *  label and a variable `status`, which holds the return code. For functions that have something to
 *  undo there which SC_OWN cannot free: else SC_PASS is shorter. */
#define SC_TRY(call)                                                                               \
    do {                                                                                           \
        status = (call);                                                                           \
        if (status != SC_OK)                                                                       \
            goto out;                                                                              \
    } while (0)

/** Call a function that can fail; on an error return its code. What the function owns until then is
 *  freed by SC_OWN. */
#define SC_PASS(call)                                                                              \
    do {                                                                                           \
        const sc_status code_ = (call);                                                            \
        if (code_ != SC_OK)                                                                        \
            return code_;                                                                          \
    } while (0)

/** Marks local variables that own what @p clear frees: it is called with their address when the
 *  function is left, however that happens, the last one first. They have to be initialised; who
 *  passes on what one of them owns, zeroes it, as SC_HAND_OVER does. */
#define SC_OWN(clear) __attribute__((cleanup(clear)))
/* NOLINTBEGIN(bugprone-macro-parentheses): arguments are the names of a function and a type */
/** Define @p close with the ending _at, which closes at the address of a pointer: for SC_OWN. */
#define SC_CLOSE_AT(close, type)                                                                   \
    static inline void close##_at(type **pointer)                                                  \
    {                                                                                              \
        close(*pointer);                                                                           \
    }
/* NOLINTEND(bugprone-macro-parentheses) */
/** Let *@p to own what the variable @p owned does, which owns nothing any more. For types of which
 *  all bytes 0 own nothing: not where a file descriptor of 0 would be one. */
#define SC_HAND_OVER(owned, to)                                                                    \
    do {                                                                                           \
        *(to) = (owned);                                                                           \
        memset(&(owned), 0, sizeof(owned));                                                        \
    } while (0)

/** Number of elements of an array; wrong for a pointer. */
#define SC_COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))

/** How important a message is, the most important level first. */
typedef enum sc_log_level { SC_LOG_ERROR, SC_LOG_WARN, SC_LOG_INFO, SC_LOG_DEBUG } sc_log_level;

/** What a command is at. The functions sc_stage_* set it; any thread may read it at any time. */
typedef struct sc_stage {
    _Atomic(const char *)
        name; /**< such as "reading"; static text; NULL: nothing that takes long */
    _Atomic uint64_t begun_with; /**< what `done` was at the beginning of the stage */
    _Atomic uint64_t done;       /**< of `total`; may lie beyond it by rounding */
    _Atomic uint64_t total;      /**< 0: unknown */
    _Atomic double begin_s;      /**< when the stage began, by sc_wall_s */
    /** For which of several things of a kind this is done: `1 << 16 | 20` is the first of 20; 0:
     *  there is one */
    _Atomic uint32_t turn;
} sc_stage;

/** The context of a call: where messages go and, in tests, how many allocations still succeed. Each
 *  function that gets one borrows it. Several threads may use one if @p write allows that and
 *  alloc_budget is NULL. */
typedef struct sc_ctx {
    sc_log_level level; /**< messages above this level are dropped */
    int rank;           /**< messages begin with this rank if it is above 0 */
    /** Receives one finished message without newline, printable as of sc_printable. NULL:
     *  messages are dropped. */
    void (*write)(void *user, sc_log_level level, const char *text);
    void *user;
    /** NULL, or the number of allocations that still succeed: tests use it to let the n-th fail. */
    long *alloc_budget;
    /** What is wrong with an input (SC_ERR_MISSING, SC_ERR_DATA) is expected, and not logged; see
     *  sc_quiet. */
    bool quiet_about_input;
    /** Most memory in bytes that one volume may take while it is read and prepared; what needs more
     *  is refused before it is allocated (sc_volume_memory_check). 0: no limit. */
    uint64_t memory_max_bytes;
    int threads;     /**< threads that reading a volume may use; 0: one */
    sc_stage *stage; /**< where the work says what it is at, or NULL; borrowed */
} sc_ctx;

/** @return a context for looking at an input that may be missing or broken without anybody being
 *  told: it logs only failures of the machine, which the caller passes on (sc_is_of_input). */
sc_ctx sc_quiet(const sc_ctx *ctx);
/** @return whether a return code says that an input is missing or broken, not that a memory or
 *  another part of the machine failed. */
bool sc_is_of_input(sc_status status);
/** Log an error. @return @p status, so that it can be used as `return sc_fail(...)`. */
sc_status sc_fail(const sc_ctx *ctx, sc_status status, const char *fmt, ...) SC_PRINTF(3, 4);
/** Check that what takes @p bytes of memory is within sc_ctx.memory_max_bytes. @param advice what
 * else helps, ended by "or "; may be empty. @param fmt what takes the memory: "... takes about".
 * @return SC_ERR_SYSTEM, logged. */
SC_MUST_USE sc_status sc_memory_check(const sc_ctx *ctx, double bytes, const char *advice,
                                      const char *fmt, ...) SC_PRINTF(4, 5);
/** Log a warning. */
void sc_warn(const sc_ctx *ctx, const char *fmt, ...) SC_PRINTF(2, 3);
/** Log a message of level SC_LOG_INFO. */
void sc_info(const sc_ctx *ctx, const char *fmt, ...) SC_PRINTF(2, 3);
/** @return what an errno of a failed call means, for messages. Static text, or that of strerror(),
 *  which the next call may overwrite. */
const char *sc_reason(int error);
/** A function for sc_ctx.write: prints lines such as "segcast: error: text" to standard error. */
void sc_log_to_stderr(void *user, sc_log_level level, const char *text);

/* ---- mistakes of a user: all are told in one go, each once ---- */

/** The most mistakes that are told of an input; of more, at most their number is. */
enum { SC_MISTAKES_MAX = 50 };
/** Remember in *status the first mistake of a user, and tell whether to go on in order to find the
 *  others. @param status SC_OK, or the first mistake so far. @param found the return code of what
 *  was just done. @return false after an error that is no mistake of the user, such as
 *  SC_ERR_MEMORY, which *status becomes then. */
static inline bool sc_goes_on(sc_status *status, sc_status found)
{
    const bool is_mistake =
        found == SC_ERR_USAGE || found == SC_ERR_DATA || found == SC_ERR_MISSING;

    if (*status == SC_OK || (found != SC_OK && !is_mistake))
        *status = found;
    return found == SC_OK || is_mistake;
}
/** Passes the messages of a context on, but no error twice, and not more of them than
 *  SC_MISTAKES_MAX. The same error can be found in several places, such as in each shot. */
typedef struct sc_once {
    const sc_ctx *to;
    int errors;                     /**< how many there were, each counted once */
    uint64_t told[SC_MISTAKES_MAX]; /**< hashes of those that were passed on */
} sc_once;
/** @return a context as @p to, whose messages @p once passes on. Both are borrowed; for one thread.
 */
sc_ctx sc_ctx_once(const sc_ctx *to, sc_once *once);
/** Warn of how many errors were not passed on, if any. @param what they are mistakes of. */
void sc_once_end(const sc_once *once, const char *what);

/** Product of two sizes. @return false on overflow, @p out untouched. */
bool sc_mul_size(size_t a, size_t b, size_t *out);

/** Allocate @p count elements of @p size bytes, aligned to 64 bytes (a cache line, and the widest
 *  vector register), not initialised. @param out the address of a pointer of any type, which gets
 *  the block. @return SC_ERR_MEMORY, logged: the size overflows, or there is no memory. Caller owns
 *  *out: sc_free. */
SC_MUST_USE sc_status sc_alloc(const sc_ctx *ctx, size_t count, size_t size, void *out);
/** As sc_alloc, with all bytes 0. */
SC_MUST_USE sc_status sc_zalloc(const sc_ctx *ctx, size_t count, size_t size, void *out);
/** sc_alloc and sc_zalloc for an array of what the pointer at @p out points to. */
#define SC_ALLOC(ctx, count, out) sc_alloc(ctx, count, sizeof **(out), out)
#define SC_ZALLOC(ctx, count, out) sc_zalloc(ctx, count, sizeof **(out), out)
/** Give the array of sc_alloc at @p array, the address of a pointer of any type, room for @p room
 *  elements of @p size bytes; its first @p count are kept, the others are not initialised. The
 * array may be NULL, and may move. @return SC_ERR_MEMORY, nothing changed. */
SC_MUST_USE sc_status sc_resize(const sc_ctx *ctx, size_t count, size_t room, size_t size,
                                void *array);
/** Let the array have room for one element more than the @p count that are used: nothing to do, or
 *  twice as much as *room. @return as sc_resize. */
SC_MUST_USE sc_status sc_grow(const sc_ctx *ctx, size_t count, size_t *room, size_t size,
                              void *array);
/** Both for an array of what the pointer at @p array points to. */
#define SC_RESIZE(ctx, count, room, array) sc_resize(ctx, count, room, sizeof **(array), array)
#define SC_GROW(ctx, count, room, array) sc_grow(ctx, count, room, sizeof **(array), array)
/** Free what sc_alloc or malloc has given. NULL is allowed. */
void sc_free(void *ptr);
/** The same for what the pointer of any type points to that is at @p pointer. For SC_OWN. */
void sc_free_at(void *pointer);
/** Close the stream at @p stream unless it is NULL. For SC_OWN, of streams that are only read. */
void sc_fclose_at(FILE **stream);

/** A text that grows. Zero-initialise; ends with a NUL byte after the first sc_text_add. Owns its
 *  memory: sc_text_clear, or sc_free on data, which may be passed on. */
typedef struct sc_text {
    char *data;
    size_t length_bytes, capacity_bytes;
} sc_text;
/** Append formatted text. @return SC_ERR_MEMORY, with @p text untouched. */
SC_MUST_USE sc_status sc_text_add(const sc_ctx *ctx, sc_text *text, const char *fmt, ...)
    SC_PRINTF(3, 4);
/** Append a field of CSV, in quotation marks (RFC 4180) if it has one of the characters @p special;
 * NULL: always. @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_text_add_field(const sc_ctx *ctx, sc_text *text, const char *field,
                                        const char *special);
/** Copy a text. @return SC_ERR_MEMORY. Caller owns *out: sc_free. */
SC_MUST_USE sc_status sc_text_copy(const sc_ctx *ctx, const char *from, char **out);
/** Free the memory of @p text, which is empty then. */
void sc_text_clear(sc_text *text);

/** @return how many bytes the character at @p text has: 1 to 4 for a well-formed character of
 * UTF-8, 0 at the end of the text and for a byte that begins none. */
size_t sc_utf8_bytes(const char *text);
/** @return the number of the character that begins at @p text, which is @p bytes long, as of
 * sc_utf8_bytes; of a byte that begins none, with @p bytes 1, the byte. */
unsigned sc_utf8_code(const char *text, size_t bytes);
/** @return whether a terminal would obey the character of number @p code instead of showing it:
 * control characters, separators of lines, and what turns the direction of the text around, so that
 * it reads as something else. */
bool sc_is_control(unsigned code);
/** Write @p text to out[size] as a terminal shows it without obeying it: control characters and
 *  bytes that are not UTF-8 become for example \\x1b, characters that turn the direction of the
 * text around become \\u202e. What does not fit is left out at a whole character. @p text and @p
 * out do not overlap. @return how many bytes the whole result has, its NUL byte not counted. */
size_t sc_printable(const char *text, char *out, size_t size);
/** Print @p text to @p stream as sc_printable shows it. To be used for every name and path that
 * comes from the user or from a file. What sc_fail, sc_warn and sc_info log needs no call: they
 * pass their whole message through sc_printable. */
void sc_print(FILE *stream, const char *text);
/** Print a path that scripts may read: as sc_print does if @p stream is a terminal, otherwise
 *  unchanged. */
void sc_print_path(FILE *stream, const char *path);
/** Copy a name from a file to out[size] as valid UTF-8: bytes that are not UTF-8 become U+FFFD,
 *  control characters become blanks, and what does not fit is left out at a whole character. size
 *  is at least 1. @return false if bytes were replaced or left out, which is to be told. */
bool sc_copy_name(const char *from, char *out, size_t size);

/** @return the length of a name before the first of @p count endings that it has, case ignored; 0
 * if it has none of them, or is nothing else. */
size_t sc_stem_length(const char *name, const char *const *endings, size_t count);

/** @return the one of @p count @p candidates that is nearest to @p word by Levenshtein distance,
 *  ignoring case, or NULL if even that differs in more than a third of its letters and one. NULLs
 *  among the candidates are skipped. The result is borrowed from them. */
const char *sc_nearest_word(const char *word, const char *const *candidates, size_t count);

/** Find up to @p most different words among @p candidates that may be meant by @p word: the
 * nearest, as of sc_nearest_word, and those that differ by one letter more; or, if none is near,
 * those that hold @p word as a part. ASCII case is ignored. NULLs among the candidates are skipped.
 *  @param out room for @p most, at least 1; borrowed from the candidates, nearest first.
 *  @return how many there are. */
size_t sc_nearest_words(const char *word, const char *const *candidates, size_t count, size_t most,
                        const char **out);

/** Hash of @p bytes bytes (XXH3, 64 bits): the same on every machine. @param seed 0, or the hash of
 *  what precedes these bytes, so that several pieces get one hash. */
uint64_t sc_hash_bytes(const void *data, size_t bytes, uint64_t seed);
/** A SHA-256 as 64 hexadecimal digits, terminator included. */
enum { SC_SHA256_BYTES = 65 };
/** Compute the SHA-256 of a regular file, and its size. @return SC_ERR_MISSING, SC_ERR_WRITE if it
 * cannot be read, SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_sha256_file(const sc_ctx *ctx, const char *path, char out[SC_SHA256_BYTES],
                                     uint64_t *out_bytes);
/** The same of a text, which is not empty. */
SC_MUST_USE sc_status sc_sha256_text(const sc_ctx *ctx, const sc_text *text,
                                     char out[SC_SHA256_BYTES]);

/** A unit in which lengths are printed. */
typedef struct sc_length_unit {
    const char *name; /**< "mm", "um" or "nm" */
    double mm;        /**< the length of one unit, in mm */
} sc_length_unit;
/** @return the largest of millimetres, micrometres and nanometres in which @p finest_mm, the
 * smallest length that matters, is at least a tenth of a unit; millimetres for 0. */
sc_length_unit sc_length_unit_for(double finest_mm);
/** @return the longest length of 1, 2 or 5 times a power of ten that is at most @p most_mm; 0 if
 * that is not above 0. */
double sc_round_length_mm(double most_mm);
/** @return @p value, or 0 if it would be printed as zero with @p decimals digits behind the point:
 * so that nothing is printed as "-0.0". */
double sc_no_negative_zero(double value, int decimals);
/** Write a number of bytes with about three digits and its unit, such as "1.25 GiB", into @p text.
 * @return @p text. */
const char *sc_size_text(double bytes, char text[24]);

/** @return the return code for an input that cannot be opened or read with @p error, an errno:
 *  SC_ERR_MISSING if it is not there or may not be read, SC_ERR_MEMORY, and for all other reasons,
 *  such as a broken disk or too many open files, SC_ERR_WRITE. */
sc_status sc_input_status(int error);

/** Read a whole file. @p out holds its bytes and a NUL byte behind them. @return SC_ERR_MISSING if
 *  it cannot be opened or is no regular file, SC_ERR_DATA if it is longer than @p max_bytes. Caller
 * owns *out: sc_free. */
SC_MUST_USE sc_status sc_file_read(const sc_ctx *ctx, const char *path, size_t max_bytes,
                                   char **out, size_t *out_bytes);

/** Map a whole file into memory for reading; parts that are never accessed are never read from
 * disk. The file must not change meanwhile. @return SC_ERR_MISSING. Caller owns *out:
 * sc_file_unmap. */
SC_MUST_USE sc_status sc_file_map(const sc_ctx *ctx, const char *path, const void **out,
                                  size_t *out_bytes);
/** What tells a file of this machine from others, and from what it was before it was changed. Of
 *  64-bit numbers alone, so that it can be sent and compared as bytes. */
typedef struct sc_file_identity {
    uint64_t device, inode, bytes, changed_s, changed_ns;
} sc_file_identity;
/** Tell which file is open as @p file, and in which state. @return whether that is known; async-
 *  signal-safe. */
bool sc_file_identify(int file, sc_file_identity *out);
/** As sc_file_map, and tell which file it is. @param out_file receives the open file: while
 *  sc_file_identify tells the same of it, nothing has written into it. Caller owns: close. */
SC_MUST_USE sc_status sc_file_map_identified(const sc_ctx *ctx, const char *path, const void **out,
                                             size_t *out_bytes, sc_file_identity *identity,
                                             int *out_file);
/** End the mapping of sc_file_map: @p data and @p bytes are its outputs. NULL is allowed. */
void sc_file_unmap(const void *data, size_t bytes);

/** What a process is going to do with memory that is mapped from a file. */
typedef enum sc_memory_use {
    SC_MEMORY_NOT_NEEDED, /**< nothing for now: the system may use the room for something else */
    SC_MEMORY_NEEDED_SOON /**< to read it: the system may begin to fetch it from the file */
} sc_memory_use;
/** Tell the system what will be done with @p bytes bytes at @p data, the beginning of a mapping
 *  that shares its changes with its file (MAP_SHARED; so does sc_file_map). What it holds stays the
 *  same: what is not needed leaves the memory of this process at once, and is fetched again, from
 *  the file or from what the system keeps of it, when it is read. NULL is allowed. Threads: any. */
void sc_file_advise(const void *data, size_t bytes, sc_memory_use use);

/** Longest name of a host, terminator included. */
enum { SC_HOST_BYTES = 65 };
/** Write the name of this host to @p out; "host" if it has none. */
void sc_host_name(char out[SC_HOST_BYTES]);

/** An output file that gets its name only when it is complete: it is written under a temporary name
 *  in the same directory, ".NAME.tmp.HOST.PID.RANDOM", then flushed to disk (fsync) and renamed.
 *  The temporary file is always a new one: a file or symbolic link that is there is never opened.
 */
typedef struct sc_outfile {
    FILE *stream;    /**< open for writing and reading until commit or discard */
    char *path;      /**< final name */
    char *temporary; /**< name while unfinished */
    bool replace;    /**< a file that has the final name is replaced */
    bool fleeting;   /**< set by the caller: it need not survive a loss of power, so that nothing is
                          waited for */
    int unfinished;  /**< see sc_unfinished_drop */
} sc_outfile;
/** Begin an output file. @param replace false: a file of that name is an error of the commit.
 * @return SC_ERR_CREATE, SC_ERR_MEMORY. Caller owns *out: sc_outfile_commit or sc_outfile_discard.
 */
SC_MUST_USE sc_status sc_outfile_open(const sc_ctx *ctx, const char *path, bool replace,
                                      sc_outfile *out);
/** Choose another final name, in the same directory. @return SC_ERR_MEMORY, @p file unchanged. */
SC_MUST_USE sc_status sc_outfile_rename(const sc_ctx *ctx, sc_outfile *file, const char *path);
/** Complete @p file under its final name, and free it in any case. After an error the temporary
 * file is removed, and a file that had the final name before is untouched. @return SC_ERR_WRITE;
 * SC_ERR_CREATE if the name is taken and must not be. */
SC_MUST_USE sc_status sc_outfile_commit(const sc_ctx *ctx, sc_outfile *file);
/** Remove the temporary file and free @p file. Does nothing after a commit and on a zeroed struct.
 */
void sc_outfile_discard(sc_outfile *file);
/** Check, before any work is done, that @p path can become an output file: nothing has this name,
 *  or with @p replace a regular file at most, and its directory can be written to. @param hint what
 *  else can be done if the name is taken, for the end of the message. @return SC_ERR_CREATE,
 *  SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_outfile_check(const sc_ctx *ctx, const char *path, bool replace,
                                       const char *hint);
/** @return whether both paths lead to one file, by whatever symbolic or hard links. */
bool sc_same_file(const char *a, const char *b);
/** Remove all files that this process has not completed: those of sc_outfile, and those given to
 *  sc_unfinished_add. For a process that is to end at once: threads that begin a file afterwards
 *  stand still. A signal handler may call it. */
void sc_unfinished_remove(void);
/** Let sc_unfinished_remove remove @p path, too, a file or a directory that is empty then. The
 *  process has made it, or is going to. Nothing is done if the path is too long, or if there are
 * too many of them.
 *  @return the number for sc_unfinished_drop. */
int sc_unfinished_add(const char *path);
/** The file of this number stays. -1 is allowed. */
void sc_unfinished_drop(int number);
/** Remove temporary files that killed processes have left in @p directory: those of this host whose
 *  process has ended, even if it is still in the list of processes, or a later one has got its id.
 * @param all also all those of other hosts. */
void sc_remove_temporaries(const char *directory, bool all);
/** Write a whole file under @p path, by way of an sc_outfile; a file of that name is replaced.
 *  @return SC_ERR_CREATE, SC_ERR_WRITE. */
SC_MUST_USE sc_status sc_file_write(const sc_ctx *ctx, const char *path, const void *data,
                                    size_t bytes);
/** Make a directory and its parents, as far as they do not exist. @return SC_ERR_CREATE. */
SC_MUST_USE sc_status sc_make_directory(const sc_ctx *ctx, const char *path);
/** @return the name of a file in its path: what stands behind the last slash. */
const char *sc_file_name(const char *path);
/** Write the folder of a path, up to its last slash, "." without one. Caller owns *out: sc_free.
 * @return SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_folder_of(const sc_ctx *ctx, const char *path, char **out);
/** Make "dir/name", or a copy of @p name if that is absolute or @p dir is empty or NULL. Caller
 * owns *out: sc_free. */
SC_MUST_USE sc_status sc_path_join(const sc_ctx *ctx, const char *dir, const char *name,
                                   char **out);

/** Find a file that is installed with this program: @p name beside the program itself, as where it
 * is built, or in the directory of its helpers (libexec/segcast) as seen from there; else where
 * that directory was to be installed. Any thread. @param path takes its path, of less than @p bytes
 * bytes; nothing needs to be there. */
void sc_program_find(const char *name, char *path, size_t bytes);

double sc_wall_s(void);       /**< seconds since an arbitrary moment; never goes back */
double sc_cpu_s(void);        /**< CPU time of this process in seconds: all threads together */
double sc_thread_cpu_s(void); /**< CPU time of the calling thread in seconds */
uint64_t sc_peak_rss(void);   /**< largest resident set of this process so far, in bytes */
/** Begin to measure sc_peak_rss_since anew, where the system allows it. */
void sc_peak_rss_restart(void);
/** @return the largest resident set since sc_peak_rss_restart, in bytes; where the system does not
 *  tell, sc_peak_rss. */
uint64_t sc_peak_rss_since(void);
/** @return the energy in joules that the processors of this machine have used since some moment,
 *  by their own counters (RAPL); -1 where these cannot be read, which most systems allow only to
 *  administrators. The counters start anew from time to time: a difference below 0 is no result. */
double sc_energy_j(void);
/** Let free() give blocks of a megabyte and more back to the system, always. By default glibc keeps
 *  what has the size of a block that was freed before, and what remains between such blocks: up to
 *  25 % more memory, from run to run, for volumes that are loaded one after the other. Call it
 * once, before there are threads. */
void sc_heap_return_large_blocks(void);
/** @return the bytes that are allocated now by malloc and its like, those of libraries included; 0
 *  where the C library does not tell. Any thread. */
uint64_t sc_heap_bytes(void);
/** Let the calling thread sleep; a signal may end the sleep early. */
void sc_sleep_s(double seconds);

/** Threads that were started only to find out how many can be. */
typedef struct sc_thread_probe sc_thread_probe;
/** Start @p wanted threads that do nothing, or as many of them as the system allows. @param started
 *  how many there are now. @return SC_ERR_MEMORY. Caller owns *out: sc_thread_probe_end. */
SC_MUST_USE sc_status sc_thread_probe_start(const sc_ctx *ctx, int wanted, sc_thread_probe **out,
                                            int *started);
/** End the threads; returns when the last has ended. NULL is allowed. */
void sc_thread_probe_end(sc_thread_probe *probe);

/** Body of a parallel loop: does the items [begin, end). @param thread number of the thread that
 *  calls it, from 0: the index of memory that each thread has for itself. */
typedef void sc_range_fn(void *user, size_t begin, size_t end, int thread);
/** Call @p body for all of [0, count), in chunks of @p chunk items that @p threads threads claim
 * one after the other; returns when all items are done. Which thread does which chunk, and when,
 * differs from call to call, and results must not depend on it. */
void sc_parallel_for(int threads, size_t count, size_t chunk, sc_range_fn *body, void *user);
/** Say that the stage @p name begins. Functions that may take longer than a second begin a stage
 * each, for their parts or as a whole. @param name static text, as a participle: "reading".
 *  @param done, total how much of it is done already, and of how much; total 0: unknown.
 *  Threads: one at a time. Does nothing without ctx->stage. */
void sc_stage_begin(const sc_ctx *ctx, const char *name, uint64_t done, uint64_t total);
/** Say that this stage and those that follow are done for the thing with number @p number, from 1,
 *  of @p count things, such as the phases of a series, up to 65535; count 0: no longer for one of
 *  several. Threads: as of sc_stage_begin. Does nothing without ctx->stage. */
void sc_stage_turn(const sc_ctx *ctx, int number, int count);
/** Add @p count to what is done of the stage. Threads: any. */
void sc_stage_add(const sc_ctx *ctx, uint64_t count);
/** Say that nothing that takes long is being done. Threads: as of sc_stage_begin. */
void sc_stage_end(const sc_ctx *ctx);
/** As sc_parallel_for, as a part of the current stage: when all items are done, @p worth has been
 *  added to what is done of it, little by little. */
void sc_stage_for(const sc_ctx *ctx, uint64_t worth, int threads, size_t count, size_t chunk,
                  sc_range_fn *body, void *user);
/** @return how many threads to use by default: OMP_NUM_THREADS, or else the usable cores. */
int sc_default_threads(void);
/** @return how many cores this process may run on. */
int sc_usable_cores(void);
/** Cores as bits: core i is bit i % 64 of word i / 64. Cores beyond the last bit are left out. */
enum { SC_CORE_WORDS = 16 };
typedef struct sc_core_set {
    uint64_t words[SC_CORE_WORDS];
} sc_core_set;
/** @return the cores that this process may run on. */
sc_core_set sc_core_set_of_process(void);
/** @return the memory of the machine in bytes, or the limit of the control group (container, batch
 *  job) if that is lower. */
uint64_t sc_machine_memory(void);
/** @return the free room for memory that processes share (/dev/shm), in bytes; UINT64_MAX if that
 * is unknown. */
uint64_t sc_machine_shared_room(void);

#endif
