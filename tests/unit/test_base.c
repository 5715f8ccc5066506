/* SPDX-License-Identifier: BSD-3-Clause */
#include "check.h"

#include <sys/stat.h>
#include <unistd.h>

static void sizes_that_overflow_are_refused(void **state)
{
    size_t out = 7;
    void *ptr = NULL;

    (void)state;
    assert_true(sc_mul_size(1u << 20, 1u << 20, &out));
    assert_int_equal(out, 1ull << 40);
    assert_false(sc_mul_size(SIZE_MAX / 2, 3, &out));
    assert_int_equal(out, 1ull << 40);
    assert_int_equal(sc_alloc(&quiet, SIZE_MAX / 4, 8, &ptr), SC_ERR_MEMORY);
    assert_null(ptr);
}

static void the_nth_allocation_fails_on_purpose(void **state)
{
    long budget = 1;
    heard h;
    sc_ctx ctx = listening(&h);
    void *first = NULL, *second = NULL;

    (void)state;
    ctx.alloc_budget = &budget;
    assert_ok(sc_zalloc(&ctx, 3, 8, &first));
    assert_int_equal(((char *)first)[23], 0);
    assert_int_equal((uintptr_t)first % 64, 0);
    assert_int_equal(sc_alloc(&ctx, 3, 8, &second), SC_ERR_MEMORY);
    assert_int_equal(h.errors, 1);
    sc_free(first);
}

static void text_grows(void **state)
{
    sc_text text = {0};

    (void)state;
    for (int i = 0; i < 1000; i++)
        assert_ok(sc_text_add(&quiet, &text, "%d,", i));
    assert_int_equal(text.length_bytes, strlen(text.data));
    assert_memory_equal(text.data + text.length_bytes - 4, "999,", 5);
    sc_text_clear(&text);
    assert_null(text.data);
}

static void the_nearest_word_is_found(void **state)
{
    static const char *const words[] = {"opacity", NULL, "visible", "color"};

    (void)state;
    assert_string_equal(sc_nearest_word("opactiy", words, 4), "opacity");
    assert_string_equal(sc_nearest_word("Colour", words, 4), "color");
    assert_null(sc_nearest_word("background", words, 4));
}

/* The first value is that of the reference implementation of XXH3. */
static void hashes_are_the_same_everywhere_and_can_be_chained(void **state)
{
    const uint64_t first = sc_hash_bytes("abc", 3, 0);

    (void)state;
    assert_int_equal(sc_hash_bytes("", 0, 0), 0x2d06800538d394c2);
    assert_int_equal(sc_hash_bytes("abc", 3, 0), first);
    assert_int_not_equal(sc_hash_bytes("abd", 3, 0), first);
    assert_int_not_equal(sc_hash_bytes("abc", 3, first), first);
}

static bool exists(const char *path)
{
    struct stat info;

    return !stat(path, &info);
}

static void a_file_appears_only_when_complete(void **state)
{
    sc_outfile file = {0};
    char *text = NULL;
    size_t bytes;

    (void)state;
    unlink("whole.txt");
    assert_ok(sc_outfile_open(&quiet, "whole.txt", &file));
    fputs("contents", file.stream);
    assert_false(exists("whole.txt"));
    assert_ok(sc_outfile_commit(&quiet, &file));
    assert_true(exists("whole.txt"));
    assert_ok(sc_file_read(&quiet, "whole.txt", 100, &text, &bytes));
    assert_string_equal(text, "contents");
    sc_free(text);
    assert_int_equal(sc_file_read(&quiet, "whole.txt", 3, &text, &bytes), SC_ERR_DATA);
    unlink("whole.txt");
    assert_ok(sc_outfile_open(&quiet, "whole.txt", &file));
    sc_outfile_discard(&file);
    assert_false(exists("whole.txt"));
    assert_int_equal(sc_outfile_open(&quiet, "no/such/folder/file", &file), SC_ERR_CREATE);
    assert_int_equal(sc_file_read(&quiet, "/", 100, &text, &bytes), SC_ERR_MISSING);
}

static void a_full_disk_is_noticed(void **state)
{
    sc_outfile file = {0};
    heard h;
    sc_ctx ctx = listening(&h);

    (void)state;
    assert_ok(sc_outfile_open(&ctx, "full.bin", &file));
    fclose(file.stream);
    file.stream = fopen("/dev/full", "wb");
    if (!file.stream)
        skip();
    for (int i = 0; i < 100000; i++)
        fputc(i, file.stream);
    assert_int_equal(sc_outfile_commit(&ctx, &file), SC_ERR_WRITE);
    assert_int_equal(h.errors, 1);
    assert_non_null(strstr(h.text, "No space left"));
    assert_false(exists("full.bin"));
}

static void add_range(void *user, size_t begin, size_t end, int thread)
{
    (void)thread;
    for (size_t i = begin; i < end; i++)
        ((int *)user)[i]++;
}

static void a_parallel_loop_does_every_item_once(void **state)
{
    int counts[1000] = {0};

    (void)state;
    for (int threads = 1; threads <= 3; threads++)
        sc_parallel_for(threads, 1000, 7, add_range, counts);
    for (int i = 0; i < 1000; i++)
        assert_int_equal(counts[i], 3);
    sc_parallel_for(2, 0, 7, add_range, counts);
}

static void lengths_get_a_unit_that_fits(void **state)
{
    (void)state;
    assert_string_equal(sc_length_unit_for(0).name, "mm");
    assert_string_equal(sc_length_unit_for(0.33).name, "mm");
    assert_string_equal(sc_length_unit_for(0.1).name, "mm");
    assert_string_equal(sc_length_unit_for(0.02).name, "um");
    assert_string_equal(sc_length_unit_for(4e-6).name, "nm");
    assert_true(0.02 / sc_length_unit_for(0.02).mm > 19.99);
    assert_string_equal(sc_length_unit_for(1e-12).name, "nm");
}

static void zero_is_never_negative(void **state)
{
    char text[32];

    (void)state;
    snprintf(text, sizeof text, "%.1f", sc_no_negative_zero(-0.04, 1));
    assert_string_equal(text, "0.0");
    snprintf(text, sizeof text, "%.4f", sc_no_negative_zero(-0.0, 4));
    assert_string_equal(text, "0.0000");
    snprintf(text, sizeof text, "%.1f", sc_no_negative_zero(-0.06, 1));
    assert_string_equal(text, "-0.1");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sizes_that_overflow_are_refused),
        cmocka_unit_test(the_nth_allocation_fails_on_purpose),
        cmocka_unit_test(text_grows),
        cmocka_unit_test(the_nearest_word_is_found),
        cmocka_unit_test(hashes_are_the_same_everywhere_and_can_be_chained),
        cmocka_unit_test(a_file_appears_only_when_complete),
        cmocka_unit_test(a_full_disk_is_noticed),
        cmocka_unit_test(a_parallel_loop_does_every_item_once),
        cmocka_unit_test(lengths_get_a_unit_that_fits),
        cmocka_unit_test(zero_is_never_negative),
    };

    return RUN(tests);
}
