/* SPDX-License-Identifier: BSD-3-Clause */
/* What went wrong with chunks, and where these are in files that hold many of them, and an index:
 * all chunks that are to be read are found before the first, side by side by several threads, in
 * the order of the files, so that each index is read once. */
#include "chunked/chunks.h"

#include <errno.h>
#include <stdlib.h>
#include <unistd.h>

const char sc_chunk_no_memory[] = "out of memory";

bool sc_chunk_note(sc_chunk_failure *failure, sc_status status, const char *why)
{
    if (failure->now < failure->chunk) {
        failure->chunk = failure->now;
        failure->status = status;
        memcpy(failure->file, failure->key, sizeof failure->file);
        snprintf(failure->why, sizeof failure->why, "%s", why);
    }
    return false;
}

bool sc_chunk_note_unopened(sc_chunk_failure *failure)
{
    return sc_chunk_note(
        failure, errno == EACCES ? SC_ERR_MISSING : SC_ERR_DATA,
        errno == ELOOP || errno == ENOTDIR || errno == EINVAL
            ? "is no regular file; links in the directory of a volume are not followed"
        : errno == EACCES ? "may not be read"
                          : "cannot be opened");
}

sc_status sc_chunked_failed(const sc_ctx *ctx, const sc_chunked *chunked)
{
    const sc_chunk_failure *worst = chunked->failures;

    for (int i = 1; i < chunked->threads; i++) {
        if (chunked->failures[i].chunk < worst->chunk)
            worst = &chunked->failures[i];
    }
    if (worst->chunk == SIZE_MAX)
        return SC_OK;
    return sc_fail(ctx, worst->status, "%s/%s: %s", chunked->path, worst->file, worst->why);
}

void sc_chunked_box(const sc_chunked *chunked, size_t first[3], size_t count[3])
{
    for (int i = 0; i < 3; i++) {
        first[i] = chunked->low[i] / chunked->chunk[i];
        count[i] = (chunked->low[i] + chunked->part[i] - 1) / chunked->chunk[i] - first[i] + 1;
    }
}

/* The chunks while they are looked for. */
typedef struct finding {
    const sc_chunked *chunked;
    const sc_chunk_wanted *wanted; /* by files and parts */
    const size_t *files;           /* the first chunk of each file, and the end of the last */
    size_t first[3], count[3];     /* of chunks along x, y, z */
} finding;

/* Compare two chunks for qsort: by file, then by part, then by number. */
static int by_place(const void *a, const void *b)
{
    const sc_chunk_wanted *p = a, *q = b;

    if (p->file != q->file)
        return p->file < q->file ? -1 : 1;
    if (p->part != q->part)
        return p->part < q->part ? -1 : 1;
    return (p->chunk > q->chunk) - (p->chunk < q->chunk);
}

/* Write which chunk an item is to @p number. */
static void number_of(const finding *f, size_t item, size_t number[3])
{
    number[0] = f->first[0] + item % f->count[0];
    number[1] = f->first[1] + item / f->count[0] % f->count[1];
    number[2] = f->first[2] + item / f->count[0] / f->count[1];
}

/* Find the chunks wanted[first, end), which are in one file. */
static void find_in_file(const finding *f, size_t first, size_t end, sc_chunk_failure *failure)
{
    const sc_chunked *chunked = f->chunked;
    const char *wrong = NULL;
    size_t number[3], behind;
    uint64_t left;
    int fd;

    number_of(f, f->wanted[first].item, number);
    chunked->name(chunked->user, number, failure->key);
    fd = sc_chunk_open_file(chunked->directory, failure->key, &left);
    if (fd < 0) { /* a file that is not there has no chunk */
        if (errno != ENOENT)
            (void)sc_chunk_note_unopened(failure);
        return;
    }
    for (; first < end && !wrong; first = behind) {
        behind = first + 1;
        while (behind < end && f->wanted[behind].part == f->wanted[first].part)
            behind++;
        wrong = chunked->finder->find(chunked->user, fd, f->wanted + first, behind - first, &left,
                                      chunked->places);
    }
    close(fd);
    if (wrong)
        (void)sc_chunk_note(failure, wrong == sc_chunk_no_memory ? SC_ERR_MEMORY : SC_ERR_DATA,
                            wrong);
}

/* sc_range_fn: look into files; @p user is a finding. */
static void find_in_files(void *user, size_t begin, size_t end, int thread)
{
    const finding *f = user;
    sc_chunk_failure *failure = &f->chunked->failures[thread];

    for (size_t file = begin; file < end; file++) {
        failure->now = file;
        find_in_file(f, f->files[file], f->files[file + 1], failure);
    }
}

sc_status sc_chunked_find(const sc_ctx *ctx, sc_chunked *chunked)
{
    finding f = {.chunked = chunked};
    SC_OWN(sc_free_at) sc_chunk_wanted *wanted = NULL;
    SC_OWN(sc_free_at) size_t *files = NULL;
    size_t count, file_count = 0, number[3];

    sc_chunked_box(chunked, f.first, f.count);
    count = f.count[0] * f.count[1] * f.count[2];
    SC_PASS(SC_ALLOC(ctx, count, &wanted));
    SC_PASS(SC_ALLOC(ctx, count + 1, &files));
    SC_PASS(SC_ALLOC(ctx, count, &chunked->places));
    for (size_t i = 0; i < count; i++) {
        number_of(&f, i, number);
        chunked->finder->want(chunked->user, number, &wanted[i]);
        wanted[i].item = i;
        chunked->places[i] = (sc_chunk_place){.bytes = UINT64_MAX};
    }
    qsort(wanted, count, sizeof *wanted, by_place);
    for (size_t i = 0; i < count; i++) {
        if (i == 0 || wanted[i - 1].file != wanted[i].file)
            files[file_count++] = i;
    }
    files[file_count] = count;
    f.wanted = wanted;
    f.files = files;
    sc_parallel_for(chunked->threads, file_count, 1, find_in_files, &f);
    return sc_chunked_failed(ctx, chunked);
}
