/* SPDX-License-Identifier: BSD-3-Clause */
/* Included before everything else in the sources that test_complexity counts. The compiler counts
 * the blocks of code that run; functions of the C library run without blocks of ours, so that they
 * count the bytes that they look at. sscanf looks for the end of the whole string before it reads.
 */
#ifndef SC_TEST_COUNTED_H
#define SC_TEST_COUNTED_H

#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

extern uint64_t sc_test_operations;

static inline size_t counted(size_t bytes)
{
    sc_test_operations += bytes;
    return bytes;
}

static inline size_t counted_strlen(const char *s)
{
    return counted(strlen(s));
}

static inline size_t common(const char *a, const char *b, size_t most)
{
    size_t i = 0;

    while (i < most && a[i] && a[i] == b[i])
        i++;
    return counted(i);
}

static inline int counted_strcmp(const char *a, const char *b)
{
    common(a, b, SIZE_MAX);
    return strcmp(a, b);
}

static inline int counted_strncmp(const char *a, const char *b, size_t n)
{
    common(a, b, n);
    return strncmp(a, b, n);
}

static inline int counted_memcmp(const void *a, const void *b, size_t n)
{
    counted(n);
    return memcmp(a, b, n);
}

static inline void *counted_memcpy(void *to, const void *from, size_t n)
{
    counted(n);
    return memcpy(to, from, n);
}

static inline void *counted_memmove(void *to, const void *from, size_t n)
{
    counted(n);
    return memmove(to, from, n);
}

static inline void *counted_memset(void *to, int c, size_t n)
{
    counted(n);
    return memset(to, c, n);
}

static inline char *counted_strstr(const char *s, const char *part)
{
    const char *found = strstr(s, part);

    counted(found ? (size_t)(found - s) : strlen(s));
    return (char *)(uintptr_t)found;
}

static inline char *counted_strchr(const char *s, int c)
{
    const char *found = strchr(s, c);

    counted(found ? (size_t)(found - s) : strlen(s));
    return (char *)(uintptr_t)found;
}

static inline char *counted_strrchr(const char *s, int c)
{
    counted(strlen(s));
    return (char *)(uintptr_t)strrchr(s, c);
}

static inline size_t counted_strspn(const char *s, const char *set)
{
    return counted(strspn(s, set));
}

static inline size_t counted_strcspn(const char *s, const char *set)
{
    return counted(strcspn(s, set));
}

static inline int counted_vsnprintf(char *to, size_t n, const char *fmt, va_list args)
    __attribute__((format(printf, 3, 0)));
static inline int counted_vsnprintf(char *to, size_t n, const char *fmt, va_list args)
{
    const int bytes = vsnprintf(to, n, fmt, args);

    counted(bytes > 0 ? (size_t)bytes : 0);
    return bytes;
}

#undef strlen
#undef strcmp
#undef strncmp
#undef memcmp
#undef memcpy
#undef memmove
#undef memset
#undef strstr
#undef strchr
#undef strrchr
#undef strspn
#undef strcspn
#undef vsnprintf
#undef sscanf
#define strlen counted_strlen
#define strcmp counted_strcmp
#define strncmp counted_strncmp
#define memcmp counted_memcmp
#define memcpy counted_memcpy
#define memmove counted_memmove
#define memset counted_memset
#define strstr counted_strstr
#define strchr counted_strchr
#define strrchr counted_strrchr
#define strspn counted_strspn
#define strcspn counted_strcspn
#define vsnprintf counted_vsnprintf
#define sscanf(s, ...) (counted(strlen(s)), sscanf(s, __VA_ARGS__))

#endif
