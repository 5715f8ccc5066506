/* SPDX-License-Identifier: BSD-3-Clause */
/* What the fuzz targets share. A target is a file fuzz_NAME.c with the function that libFuzzer
 * calls for every input. The same file, linked with replay.c, runs the kept inputs in corpus/NAME
 * with any compiler. */
#ifndef SC_FUZZ_H
#define SC_FUZZ_H

#include "segcast/base.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Called once before the first input; most targets do without. */
int LLVMFuzzerInitialize(int *argc, char ***argv);
/* Try one input of @p size bytes, borrowed. @return 0. A crash, or an untrue FUZZ_CHECK, is a
 * finding. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* What has to hold for every input; otherwise the process aborts, which is a finding. */
#define FUZZ_CHECK(condition)                                                                      \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            fprintf(stderr, "%s:%d: not true: %s\n", __FILE__, __LINE__, #condition);              \
            abort();                                                                               \
        }                                                                                          \
    } while (0)

/* Look at every byte of a message, which must be printable, and drop it; with FUZZ_TELL in the
 * environment, show it. */
static inline void fuzz_hear(void *user, sc_log_level level, const char *text)
{
    for (const char *at = text; *at; at++)
        FUZZ_CHECK((unsigned char)*at >= ' ' && *at != 0x7f);
    if (getenv("FUZZ_TELL"))
        sc_log_to_stderr(NULL, level, text);
}

/* The context of all calls: messages are made, and a volume may take 16 MiB: more would take longer
 * than the 5 s that an input may with the instruments of the fuzzer on a busy machine. */
static const sc_ctx fuzz_ctx = {
    .level = SC_LOG_INFO, .write = fuzz_hear, .memory_max_bytes = 16u << 20};

static char fuzz_folder[512]; /* of this process; empty: not made yet */

static inline void fuzz_remove_folder(void)
{
    char command[600];

    snprintf(command, sizeof command, "rm -rf '%s'", fuzz_folder);
    if (system(command))
        fprintf(stderr, "%s: cannot be removed\n", fuzz_folder);
}

/* @return "PARENT/NAME" in static memory, for two names at a time. */
static inline const char *fuzz_join(const char *parent, const char *name)
{
    static char paths[2][600];
    static int next;
    char *path = paths[next++ % 2];

    snprintf(path, sizeof paths[0], "%s/%s", parent, name);
    return path;
}

/* @return "FOLDER/NAME", as fuzz_join. The folder is made in TMPDIR, or /tmp, and removed when the
 * process ends in order. */
static inline const char *fuzz_path(const char *name)
{
    if (!fuzz_folder[0]) {
        const char *parent = getenv("TMPDIR");

        snprintf(fuzz_folder, sizeof fuzz_folder, "%s/segcast-fuzz-XXXXXX",
                 parent && *parent ? parent : "/tmp");
        FUZZ_CHECK(mkdtemp(fuzz_folder));
        atexit(fuzz_remove_folder);
    }
    return fuzz_join(fuzz_folder, name);
}

/* @return the path, as fuzz_join, of a file that takes long to make, and that the processes of
 * tools/fuzz leave to each other in FUZZ_KEPT: libFuzzer starts a new one for some hundred inputs.
 * Without FUZZ_KEPT, fuzz_path. */
static inline const char *fuzz_kept_path(const char *name)
{
    const char *folder = getenv("FUZZ_KEPT");

    return folder && *folder ? fuzz_join(folder, name) : fuzz_path(name);
}

/* Write a file into that folder, without flushing it to disk. @return its path, as fuzz_path. */
static inline const char *fuzz_write(const char *name, const void *data, size_t bytes)
{
    const char *path = fuzz_path(name);
    FILE *stream = fopen(path, "wb");

    FUZZ_CHECK(stream);
    FUZZ_CHECK(fwrite(data, 1, bytes, stream) == bytes);
    FUZZ_CHECK(fclose(stream) == 0);
    return path;
}

/* Split an input at its first two NUL bytes. Parts that are not there are empty. */
static inline void fuzz_split(const uint8_t *data, size_t size, const uint8_t *parts[3],
                              size_t sizes[3])
{
    for (int i = 0; i < 3; i++) {
        const uint8_t *end = size && i < 2 ? memchr(data, 0, size) : NULL;

        parts[i] = data;
        sizes[i] = end ? (size_t)(end - data) : size;
        data += sizes[i] + !!end;
        size -= sizes[i] + !!end;
    }
}

/* A part of a file that inputs may change. */
typedef struct fuzz_region {
    size_t at, bytes;
} fuzz_region;

/* Change a valid file as an input says: the input is a sequence of changes, each of one byte that
 * chooses the region, three for the place in it (the lowest first; beyond the end it begins anew),
 * one for the number of new bytes less one (modulo 8), and the new bytes. */
static inline void fuzz_patch(void *file, const fuzz_region *regions, size_t count,
                              const uint8_t *data, size_t size)
{
    while (size > 5) {
        const fuzz_region *region = &regions[data[0] % count];
        const size_t at = data[1] + data[2] * 256u + data[3] * 65536u;
        const size_t wanted = 1 + data[4] % 8u;
        const size_t bytes = wanted < size - 5 ? wanted : size - 5;

        for (size_t i = 0; i < bytes && region->bytes; i++)
            ((uint8_t *)file)[region->at + (at + i) % region->bytes] = data[5 + i];
        data += 5 + bytes;
        size -= 5 + bytes;
    }
}

#endif
