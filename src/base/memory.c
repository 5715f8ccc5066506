/* SPDX-License-Identifier: BSD-3-Clause */
#define _DEFAULT_SOURCE /* madvise */
#include "segcast/base.h"

#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>
#ifdef __GLIBC__
#include <malloc.h>
#if __GLIBC_PREREQ(2, 33)
#define HAS_MALLINFO2
#endif
#endif

enum {
    ALIGNMENT_BYTES = 64,
    HUGE_PAGE_BYTES = 1 << 21,
    LARGE_BYTES = 1 << 23 /* of blocks that lie in huge pages, where the system has any */
};

bool sc_mul_size(size_t a, size_t b, size_t *out)
{
    if (b != 0 && a > SIZE_MAX / b)
        return false;
    *out = a * b;
    return true;
}

sc_status sc_alloc(const sc_ctx *ctx, size_t count, size_t size, void *out)
{
    size_t bytes;
    void *ptr = NULL;

    if (!sc_mul_size(count, size, &bytes) || bytes > SIZE_MAX / 2)
        return sc_fail(ctx, SC_ERR_MEMORY, "a size overflows: %zu elements of %zu bytes", count,
                       size);
    bytes = bytes ? bytes : 1;
    if (ctx && ctx->alloc_budget && --*ctx->alloc_budget < 0)
        return sc_fail(ctx, SC_ERR_MEMORY, "out of memory: %zu bytes were needed", bytes);
    if (posix_memalign(&ptr, bytes < LARGE_BYTES ? ALIGNMENT_BYTES : HUGE_PAGE_BYTES, bytes))
        return sc_fail(ctx, SC_ERR_MEMORY, "out of memory: %zu bytes were needed", bytes);
#ifdef MADV_HUGEPAGE
    if (bytes >= LARGE_BYTES) /* fewer page faults and address translations: a hint */
        (void)madvise(ptr, bytes, MADV_HUGEPAGE);
#endif
    memcpy(out, &ptr, sizeof ptr); /* pointers of all types are alike: POSIX */
    return SC_OK;
}

/* Set a new block to zero. Linux takes the whole pages of a large one back and gives zeros when
 * they are accessed: those that never are take no memory. */
static void clear(char *block, size_t bytes)
{
#if defined(__linux__) && defined(MADV_DONTNEED)
    const size_t page = (size_t)sysconf(_SC_PAGESIZE);
    const size_t before = (page - (uintptr_t)block % page) % page;
    const size_t whole = bytes > before ? (bytes - before) / page * page : 0;

    if (whole >= LARGE_BYTES && !madvise(block + before, whole, MADV_DONTNEED)) {
        memset(block, 0, before);
        memset(block + before + whole, 0, bytes - before - whole);
        return;
    }
#endif
    memset(block, 0, bytes);
}

sc_status sc_zalloc(const sc_ctx *ctx, size_t count, size_t size, void *out)
{
    char *block = NULL;

    SC_PASS(sc_alloc(ctx, count, size, &block));
    clear(block, count * size);
    memcpy(out, &block, sizeof block);
    return SC_OK;
}

sc_status sc_resize(const sc_ctx *ctx, size_t count, size_t room, size_t size, void *array)
{
    void *old, *block = NULL;

    SC_PASS(sc_alloc(ctx, room, size, &block));
    memcpy(&old, array, sizeof old);
    if (count)
        memcpy(block, old, count * size);
    memcpy(array, &block, sizeof block);
    free(old);
    return SC_OK;
}

sc_status sc_grow(const sc_ctx *ctx, size_t count, size_t *room, size_t size, void *array)
{
    const size_t more = *room ? 2 * *room : 16;

    if (count < *room)
        return SC_OK;
    SC_PASS(sc_resize(ctx, count, more, size, array));
    *room = more;
    return SC_OK;
}

void sc_free(void *ptr)
{
    free(ptr);
}

void sc_free_at(void *pointer)
{
    void *ptr;

    memcpy(&ptr, pointer, sizeof ptr);
    free(ptr);
}

void sc_heap_return_large_blocks(void)
{
#ifdef __GLIBC__
    enum { RETURNED_BYTES = 1 << 20 };

    (void)mallopt(M_MMAP_THRESHOLD, RETURNED_BYTES);
#endif
}

uint64_t sc_heap_bytes(void)
{
#ifdef HAS_MALLINFO2
    const struct mallinfo2 info = mallinfo2();

    return (uint64_t)info.uordblks + (uint64_t)info.hblkhd;
#else
    return 0;
#endif
}
