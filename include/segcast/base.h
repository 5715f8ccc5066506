/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  Floor 0: status codes, context (log and allocation budget), memory, text, files, clocks,
 * threads.
 *
 *  Conventions of every segcast header:
 *  - A fallible function returns sc_status. Outputs come last and are written only on success.
 *  - Whoever decides an error logs it, once, with sc_fail(); everyone above only forwards it.
 *  - Functions are local (not collective) and safe to call from several threads on distinct
 *    objects, unless their comment says otherwise.
 */
#ifndef SEGCAST_BASE_H
#define SEGCAST_BASE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

/** Result of a fallible function. The order matters: ranks agree on the smallest (comm.h). */
typedef enum sc_status {
    SC_OK = 0,
    SC_ERR_INCOMPLETE = -1, /**< stopped early on request; run again */
    SC_ERR_USAGE = -2,      /**< the request itself is wrong: command line, job file */
    SC_ERR_DATA = -3,       /**< an input exists and is broken */
    SC_ERR_MISSING = -4,    /**< an input is not there or cannot be opened */
    SC_ERR_CREATE = -5,     /**< an output cannot be created */
    SC_ERR_WRITE = -6,      /**< an output cannot be written, e.g. the disk is full */
    SC_ERR_MEMORY = -7,     /**< out of memory, or a size that overflows */
    SC_ERR_INTERNAL = -8    /**< our own bug, or a library's */
} sc_status;

#define SC_MUST_USE __attribute__((warn_unused_result))
#define SC_PRINTF(fmt, first) __attribute__((format(printf, fmt, first)))

/** Forward an error to the label `out`, which a function using this must have, with `status`. */
#define SC_TRY(call)                                                                               \
    do {                                                                                           \
        status = (call);                                                                           \
        if (status != SC_OK)                                                                       \
            goto out;                                                                              \
    } while (0)

#define SC_COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))

typedef enum sc_log_level { SC_LOG_ERROR, SC_LOG_WARN, SC_LOG_INFO, SC_LOG_DEBUG } sc_log_level;

/** What a call needs from its surroundings: where messages go and how often memory may be had.
 *  Borrowed by every function that takes it; may be shared by threads. */
typedef struct sc_ctx {
    sc_log_level level; /**< messages above this level are dropped */
    int rank;           /**< rank named in messages; negative: not named */
    /** Receives one finished message without newline. NULL: messages are dropped. */
    void (*write)(void *user, sc_log_level level, const char *text);
    void *user;
    /** NULL, or how many allocations still succeed: tests fail the n-th on purpose. */
    long *alloc_budget;
} sc_ctx;

/** Log an error and return @p status, to be used as `return sc_fail(...)`. */
sc_status sc_fail(const sc_ctx *ctx, sc_status status, const char *fmt, ...) SC_PRINTF(3, 4);
void sc_warn(const sc_ctx *ctx, const char *fmt, ...) SC_PRINTF(2, 3);
void sc_info(const sc_ctx *ctx, const char *fmt, ...) SC_PRINTF(2, 3);
/** Writer for sc_ctx.write: "segcast: error: text" to standard error. */
void sc_log_to_stderr(void *user, sc_log_level level, const char *text);

/** Product of two sizes. @return false on overflow, @p out untouched. */
bool sc_mul_size(size_t a, size_t b, size_t *out);

/** Allocate @p count elements of @p size bytes, aligned to 64 bytes, not initialised.
 *  @return SC_ERR_MEMORY (logged) on overflow or shortage. Caller owns: sc_free. */
SC_MUST_USE sc_status sc_alloc(const sc_ctx *ctx, size_t count, size_t size, void **out);
/** The same, zeroed. */
SC_MUST_USE sc_status sc_zalloc(const sc_ctx *ctx, size_t count, size_t size, void **out);
/** Free what sc_alloc gave; NULL is allowed. */
void sc_free(void *ptr);

/** Growing text; zero-initialise, then sc_text_clear. Always terminated once written to. */
typedef struct sc_text {
    char *data;
    size_t length_bytes, capacity_bytes;
} sc_text;
SC_MUST_USE sc_status sc_text_add(const sc_ctx *ctx, sc_text *text, const char *fmt, ...)
    SC_PRINTF(3, 4);
void sc_text_clear(sc_text *text);

/** The candidate nearest to @p word by edit distance, or NULL if none is near (a third of its
 *  length). @p candidates: array of @p count strings, NULLs skipped. Result is borrowed. */
const char *sc_nearest_word(const char *word, const char *const *candidates, size_t count);

/** Read a whole file. @return SC_ERR_MISSING if it cannot be opened (or is a directory),
 *  SC_ERR_DATA over @p max_bytes. Output is terminated with NUL; caller owns: sc_free. */
SC_MUST_USE sc_status sc_file_read(const sc_ctx *ctx, const char *path, size_t max_bytes,
                                   char **out, size_t *out_bytes);

/** Map a whole file to be read; what is not touched is not read. The file must not change while it
 *  is mapped. @return SC_ERR_MISSING. Caller owns: sc_file_unmap. */
SC_MUST_USE sc_status sc_file_map(const sc_ctx *ctx, const char *path, const void **out,
                                  size_t *out_bytes);
void sc_file_unmap(const void *data, size_t bytes);

/** An output that appears under its name only when complete: written to a temporary name in the
 *  same directory, then fsync and rename. */
typedef struct sc_outfile {
    FILE *stream;    /**< open for writing until commit or discard */
    char *path;      /**< final name */
    char *temporary; /**< name while unfinished: ".name.tmp.PID" beside it */
} sc_outfile;
/** @return SC_ERR_CREATE (logged). */
SC_MUST_USE sc_status sc_outfile_open(const sc_ctx *ctx, const char *path, sc_outfile *out);
/** Flush, fsync, rename. On failure nothing stays under either name. @return SC_ERR_WRITE. */
SC_MUST_USE sc_status sc_outfile_commit(const sc_ctx *ctx, sc_outfile *file);
/** Remove the temporary file; harmless after commit and on a zeroed struct. */
void sc_outfile_discard(sc_outfile *file);
/** The temporary name for @p path. Caller owns: sc_free. */
SC_MUST_USE sc_status sc_temporary_name(const sc_ctx *ctx, const char *path, char **out);
/** Remove temporary files in @p directory that killed processes left: those of this host whose
 *  process is gone, and with @p all those of other hosts, too. */
void sc_remove_temporaries(const char *directory, bool all);
/** fsync and rename a finished temporary file, and fsync its directory. @return SC_ERR_WRITE. */
SC_MUST_USE sc_status sc_file_publish(const sc_ctx *ctx, const char *temporary, const char *path);
/** Write @p bytes under @p path as one sc_outfile. */
SC_MUST_USE sc_status sc_file_write(const sc_ctx *ctx, const char *path, const void *data,
                                    size_t bytes);
/** Make a directory and its parents. @return SC_ERR_CREATE. */
SC_MUST_USE sc_status sc_make_directory(const sc_ctx *ctx, const char *path);
/** "dir/name", or @p name itself if absolute or @p dir is empty. Caller owns: sc_free. */
SC_MUST_USE sc_status sc_path_join(const sc_ctx *ctx, const char *dir, const char *name,
                                   char **out);

double sc_wall_s(void);       /**< monotonic time */
double sc_cpu_s(void);        /**< user and system time of this process, all threads */
double sc_thread_cpu_s(void); /**< of the calling thread */
uint64_t sc_peak_rss(void);   /**< largest resident set of this process so far, in bytes */
void sc_sleep_s(double seconds);

/** Body of a parallel loop: items [begin, end), run by thread @p thread of the team. */
typedef void sc_range_fn(void *user, size_t begin, size_t end, int thread);
/** Run @p body over [0, count) in chunks of @p chunk items on @p threads threads, handed out
 *  dynamically. The only use of OpenMP: results must not depend on the order of the chunks. */
void sc_parallel_for(int threads, size_t count, size_t chunk, sc_range_fn *body, void *user);
/** Threads a team would have by default (OMP_NUM_THREADS or the cores this process may use). */
int sc_default_threads(void);
/** Cores this process may run on. */
int sc_usable_cores(void);
/** Which those are, as bits; those beyond the last bit are left out. */
enum { SC_CORE_WORDS = 16 };
typedef struct sc_core_set {
    uint64_t words[SC_CORE_WORDS];
} sc_core_set;
sc_core_set sc_core_set_of_process(void);
/** Memory of the machine, as far as its control group lets us have it. */
uint64_t sc_machine_memory(void);
/** Room for memory that processes share, in bytes; the largest number if that cannot be told. */
uint64_t sc_machine_shared_room(void);

#endif
