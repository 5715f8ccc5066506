/* SPDX-License-Identifier: BSD-3-Clause */
/* What unit tests share: cmocka, contexts that drop or keep messages, random numbers. */
#ifndef SC_TEST_CHECK_H
#define SC_TEST_CHECK_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "segcast/base.h"

static const sc_ctx quiet = {.level = SC_LOG_ERROR};

/* @return whether a test may be one of several alike: where sanitizers watch, which find in one
 * what they find in the next, unless SC_TEST_ALL is set. */
static inline bool in_brief(void)
{
#ifdef SC_SANITIZED
    return !getenv("SC_TEST_ALL");
#else
    return false;
#endif
}

#define assert_near(a, b, eps)                                                                     \
    do {                                                                                           \
        const double near_a = (a), near_b = (b);                                                   \
        if (!(near_a - near_b <= (eps) && near_b - near_a <= (eps)))                               \
            fail_msg("%s = %.9g, expected %.9g within %.3g", #a, near_a, near_b, (double)(eps));   \
    } while (0)

/* xorshift64* (Vigna 2016): the same numbers on every machine. @p state is not 0. */
static inline uint64_t random_bits(uint64_t *state)
{
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    return *state * 0x2545f4914f6cdd1du;
}

static inline double random_real(uint64_t *state, double low, double high)
{
    return low + (high - low) * (double)(random_bits(state) >> 11) / 9007199254740992.0;
}

/* What a context has logged: the last message, and how many errors and warnings there were. */
typedef struct heard {
    char text[2048];
    int errors, warnings;
} heard;

static inline void hear(void *user, sc_log_level level, const char *text)
{
    heard *h = user;

    if (level == SC_LOG_ERROR)
        h->errors++;
    if (level == SC_LOG_WARN)
        h->warnings++;
    snprintf(h->text, sizeof h->text, "%s", text);
}

/* What `listening` has logged since the test began, or since listening_anew() was called. */
static heard said;
static const sc_ctx listening = {.level = SC_LOG_INFO, .write = hear, .user = &said};

/* @return the context that keeps its messages in said, which is emptied. */
static inline const sc_ctx *listening_anew(void)
{
    said = (heard){0};
    return &listening;
}

#define assert_ok(call)                                                                            \
    do {                                                                                           \
        const sc_status ok_ = (call);                                                              \
        if (ok_ != SC_OK)                                                                          \
            fail_msg("%s: status %d: %s", #call, ok_, said.text);                                  \
    } while (0)

/* Write a file that holds @p text, and behind it @p bytes bytes of @p data. */
static inline void write_bytes(const char *path, const char *text, const void *data, size_t bytes)
{
    FILE *file = fopen(path, "wb");

    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fwrite(data, 1, bytes, file), bytes);
    assert_int_equal(fclose(file), 0);
}

static inline void write_text(const char *path, const char *text)
{
    write_bytes(path, text, "", 0);
}

/* Numbers in the byte order of this machine, at any place in a header. */
static inline void put16(unsigned char *at, int value)
{
    memcpy(at, &(int16_t){(int16_t)value}, 2);
}

static inline void put32(unsigned char *at, int32_t value)
{
    memcpy(at, &value, 4);
}

static inline void put_real(unsigned char *at, float value)
{
    memcpy(at, &value, 4);
}

static inline int forget(void **state)
{
    said = (heard){0};
    return 0;
}

/* TEST(name) { ... } defines a test, TEST_OF_THREADS(name) { ... } one in which threads share what
 * they share in no other of its program: where the thread sanitizer watches, only these run, if
 * there are any and SC_TEST_ALL is not set. RUN_TESTS(setup, teardown), at the end of the file, a
 * main that runs all of them in their order; setup and teardown, of all together, may be NULL. A
 * main of its own calls run_all_tests. */
static struct CMUnitTest tests_here[64];
static bool tests_of_threads[64];
static size_t tests_here_count;

static inline void keep_test(const char *name, CMUnitTestFunction function, bool of_threads)
{
    if (tests_here_count == sizeof tests_here / sizeof tests_here[0])
        abort(); /* none is left out */
    tests_of_threads[tests_here_count] = of_threads;
    tests_here[tests_here_count++] =
        (struct CMUnitTest){.name = name, .test_func = function, .setup_func = forget};
}

#define TEST(name) SC_TEST(name, false)
#define TEST_OF_THREADS(name) SC_TEST(name, true)
#define SC_TEST(name, of_threads)                                                                  \
    static void name(void **);                                                                     \
    __attribute__((constructor)) static void keep_##name(void)                                     \
    {                                                                                              \
        keep_test(#name, name, of_threads);                                                        \
    }                                                                                              \
    static void name(__attribute__((unused)) void **state)

static inline int run_all_tests(CMFixtureFunction setup, CMFixtureFunction teardown)
{
#ifdef SC_SANITIZED_THREADS
    size_t of_threads = 0;

    for (size_t i = 0; i < tests_here_count && !getenv("SC_TEST_ALL"); i++) {
        if (tests_of_threads[i])
            tests_here[of_threads++] = tests_here[i];
    }
    tests_here_count = of_threads ? of_threads : tests_here_count;
#endif
    return _cmocka_run_group_tests("tests", tests_here, tests_here_count, setup, teardown);
}

#define RUN_TESTS(setup, teardown)                                                                 \
    int main(void)                                                                                 \
    {                                                                                              \
        return run_all_tests(setup, teardown);                                                     \
    }

#endif
