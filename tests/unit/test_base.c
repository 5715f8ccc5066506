/* SPDX-License-Identifier: BSD-3-Clause */
#include "check.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

TEST(sizes_that_overflow_are_refused)
{
    size_t out = 7;
    void *ptr = NULL;

    assert_true(sc_mul_size(1u << 20, 1u << 20, &out));
    assert_int_equal(out, 1ull << 40);
    assert_false(sc_mul_size(SIZE_MAX / 2, 3, &out));
    assert_int_equal(out, 1ull << 40);
    assert_int_equal(sc_alloc(&quiet, SIZE_MAX / 4, 8, &ptr), SC_ERR_MEMORY);
    assert_null(ptr);
}

TEST(the_nth_allocation_fails_on_purpose)
{
    long budget = 1;
    sc_ctx ctx = *listening_anew();
    void *first = NULL, *second = NULL;

    ctx.alloc_budget = &budget;
    assert_ok(sc_zalloc(&ctx, 3, 8, &first));
    assert_int_equal(((char *)first)[23], 0);
    assert_int_equal((uintptr_t)first % 64, 0);
    assert_int_equal(sc_alloc(&ctx, 3, 8, &second), SC_ERR_MEMORY);
    assert_int_equal(said.errors, 1);
    sc_free(first);
}

TEST(sha256_is_that_of_the_standard)
{
    /* of the examples of FIPS 180-4, and of files whose end fits into a block just so, or not */
    static const struct {
        size_t count;
        const char *text, *sha256;
    } cases[] = {
        {1, "", "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"},
        {1, "abc", "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"},
        {1, "abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq",
         "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1"},
        {55, "a", "9f4390f8d30c2dd92ec9f095b65e2b9ae9b0a925a5258e241c9f1e910f734318"},
        {64, "a", "ffe054fe7ae0cb6dc65c3af9b61d5209f439851db43d0ba5997337df154668eb"},
        {1000000, "a", "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0"}};
    char out[SC_SHA256_BYTES];
    uint64_t bytes;

    for (size_t i = 0; i < SC_COUNT_OF(cases); i++) {
        FILE *file = fopen("sha256.txt", "w");

        assert_non_null(file);
        for (size_t n = 0; n < cases[i].count; n++)
            fputs(cases[i].text, file);
        fclose(file);
        assert_ok(sc_sha256_file(&quiet, "sha256.txt", out, &bytes));
        assert_string_equal(out, cases[i].sha256);
        assert_int_equal(bytes, cases[i].count * strlen(cases[i].text));
    }
    unlink("sha256.txt");
    assert_int_equal(sc_sha256_file(&quiet, "sha256.txt", out, &bytes), SC_ERR_MISSING);
}

TEST(text_grows)
{
    sc_text text = {0};

    for (int i = 0; i < 1000; i++)
        assert_ok(sc_text_add(&quiet, &text, "%d,", i));
    assert_int_equal(text.length_bytes, strlen(text.data));
    assert_memory_equal(text.data + text.length_bytes - 4, "999,", 5);
    sc_text_clear(&text);
    assert_null(text.data);
}

TEST(the_nearest_word_is_found)
{
    static const char *const words[] = {"opacity", NULL, "visible", "color"};

    assert_string_equal(sc_nearest_word("opactiy", words, 4), "opacity");
    assert_string_equal(sc_nearest_word("Colour", words, 4), "color");
    assert_null(sc_nearest_word("background", words, 4));
}

/* Several words that may be meant: the nearest, those nearly as near, else those that hold it. */
TEST(the_nearest_words_are_found)
{
    static const char *const words[] = {"rib 1", NULL, "rib 2", "rib 2", "left rib 10", "aorta"};
    const char *out[3];

    assert_int_equal(sc_nearest_words("rib 3", words, 6, 3, out), 2);
    assert_string_equal(out[0], "rib 1");
    assert_string_equal(out[1], "rib 2");
    assert_int_equal(sc_nearest_words("rib 3", words, 6, 1, out), 1);
    assert_int_equal(sc_nearest_words("AOR", words, 6, 3, out), 1);
    assert_string_equal(out[0], "aorta");
    assert_int_equal(sc_nearest_words("lung", words, 6, 3, out), 0);
    assert_int_equal(sc_nearest_words("", words, 6, 3, out), 0);
}

/* The first value is that of the reference implementation of XXH3. */
TEST(hashes_are_the_same_everywhere_and_can_be_chained)
{
    const uint64_t first = sc_hash_bytes("abc", 3, 0);

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

TEST(a_file_appears_only_when_complete)
{
    SC_OWN(sc_outfile_discard) sc_outfile file = {0};
    SC_OWN(sc_free_at) char *text = NULL;
    size_t bytes;

    unlink("whole.txt");
    assert_ok(sc_outfile_open(&quiet, "whole.txt", true, &file));
    fputs("contents", file.stream);
    assert_false(exists("whole.txt"));
    assert_ok(sc_outfile_commit(&quiet, &file));
    assert_true(exists("whole.txt"));
    assert_ok(sc_file_read(&quiet, "whole.txt", 100, &text, &bytes));
    assert_string_equal(text, "contents");
    assert_int_equal(sc_file_read(&quiet, "whole.txt", 3, &text, &bytes), SC_ERR_DATA);
    unlink("whole.txt");
    assert_ok(sc_outfile_open(&quiet, "whole.txt", true, &file));
    assert_false(exists("whole.txt"));
    assert_int_equal(sc_outfile_open(&quiet, "no/such/folder/file", true, &file), SC_ERR_CREATE);
    assert_int_equal(sc_file_read(&quiet, "/", 100, &text, &bytes), SC_ERR_MISSING);
}

/* The temporary file is one that nobody can have prepared, and the only one that is removed. */
TEST(a_temporary_file_is_new_and_removed)
{
    static const char *const kept[] = {".a.tmp",
                                       ".a.tmp.host.12",
                                       "a.tmp.host.12.0123456789abcdef",
                                       ".a.host.12.0123456789abcdef",
                                       ".a.tmp.host.x.0123456789abcdef",
                                       ".a.tmp.host.12.0123456789abcdeg",
                                       ".a.tmp.host.12.0123456789abcdef0"};
    static const char *const other = "temporaries/.a.tmp.no.such.host.12.0123456789abcdef";
    const struct timespec yesterday[2] = {{time(NULL) - 86400, 0}, {time(NULL) - 86400, 0}};
    char host[SC_HOST_BYTES], name[300];
    sc_outfile first = {0}, second = {0};
    struct stat info;

    mkdir("temporaries", 0777);
    assert_ok(sc_outfile_open(&quiet, "temporaries/a.txt", true, &first));
    assert_ok(sc_outfile_open(&quiet, "temporaries/a.txt", true, &second));
    assert_string_not_equal(first.temporary, second.temporary);
    assert_int_equal(strncmp(first.temporary, "temporaries/.a.txt.tmp.", 23), 0);
    assert_int_equal(lstat(first.temporary, &info), 0);
    assert_true(S_ISREG(info.st_mode));
    sc_remove_temporaries("temporaries", true); /* this process lives */
    assert_true(exists(first.temporary));
    assert_int_equal(utimensat(AT_FDCWD, first.temporary, yesterday, 0), 0);
    sc_remove_temporaries("temporaries",
                          false); /* one with the same number, before it, has made this */
    assert_false(exists(first.temporary));
    assert_true(exists(second.temporary));
    sc_outfile_discard(&first);
    sc_outfile_discard(&second);
    for (size_t i = 0; i < SC_COUNT_OF(kept); i++) {
        snprintf(name, sizeof name, "temporaries/%s", kept[i]);
        assert_ok(sc_file_write(&quiet, name, "x", 1));
    }
    assert_ok(sc_file_write(&quiet, other, "x", 1));
    sc_host_name(host);
    snprintf(name, sizeof name, "temporaries/.a.tmp.%s.999999999.0123456789abcdef", host);
    assert_ok(sc_file_write(&quiet, name, "x", 1));
    sc_remove_temporaries("temporaries", false);
    assert_false(exists(name));
    assert_true(exists(other));
    assert_int_equal(symlink("nowhere", name), 0);
    sc_remove_temporaries("temporaries", true);
    assert_false(exists(other));
    assert_int_equal(lstat(name, &info), 0); /* segcast makes no links */
    unlink(name);
    for (size_t i = 0; i < SC_COUNT_OF(kept); i++) {
        snprintf(name, sizeof name, "temporaries/%s", kept[i]);
        assert_true(exists(name));
        unlink(name);
    }
    assert_int_equal(rmdir("temporaries"), 0);
}

/* A process that was killed stays in the list of processes until its parent has asked for its exit
 * code: where nobody does, as long as the machine runs. */
TEST(a_temporary_file_of_a_process_that_ended_is_removed)
{
    sc_outfile file = {0};
    char host[SC_HOST_BYTES], name[300];
    int ready[2];
    siginfo_t info;
    pid_t child;
    char byte;

    mkdir("temporaries", 0777);
    assert_int_equal(pipe(ready), 0);
    child = fork();
    if (child == 0) {
        const bool made = sc_outfile_open(&quiet, "temporaries/a.txt", true, &file) == SC_OK;

        if (made && write(ready[1], "x", 1) == 1)
            pause();
        _exit(1);
    }
    assert_true(child > 0);
    assert_int_equal(read(ready[0], &byte, 1), 1);
    sc_remove_temporaries("temporaries", false);
    assert_int_equal(rmdir("temporaries"), -1); /* the process lives, and its file stays */
    kill(child, SIGKILL);
    /* It has ended, and stays in the list. */
    assert_int_equal(waitid(P_PID, (id_t)child, &info, WEXITED | WNOWAIT), 0);
    assert_int_equal(kill(child, 0), 0);
    sc_remove_temporaries("temporaries", false);
    assert_int_equal(rmdir("temporaries"), 0);
    /* The list of another host tells nothing of it. */
    mkdir("temporaries", 0777);
    sc_host_name(host);
    snprintf(name, sizeof name, "temporaries/.a.tmp.not.%s.%ld.0123456789abcdef", host,
             (long)child);
    assert_ok(sc_file_write(&quiet, name, "x", 1));
    sc_remove_temporaries("temporaries", false);
    assert_int_equal(unlink(name), 0);
    assert_int_equal(rmdir("temporaries"), 0);
    assert_int_equal(waitpid(child, NULL, 0), child);
    close(ready[0]);
    close(ready[1]);
}

/* A name that is taken stays as it is, unless it may be replaced; so do links and what they lead
 * to.
 */
TEST(a_name_that_is_taken_is_refused)
{
    sc_outfile file = {0};
    SC_OWN(sc_free_at) char *text = NULL;
    size_t bytes;

    unlink("taken.txt");
    unlink("link.txt");
    assert_ok(sc_outfile_check(&listening, "taken.txt", false, ""));
    assert_ok(sc_outfile_open(&listening, "taken.txt", false, &file));
    fputs("new", file.stream);
    assert_ok(sc_file_write(&listening, "taken.txt", "old", 3)); /* appears meanwhile */
    assert_int_equal(sc_outfile_commit(&listening, &file), SC_ERR_CREATE);
    assert_int_equal(said.errors, 1);
    assert_non_null(strstr(said.text, "--overwrite"));
    assert_ok(sc_file_read(&listening, "taken.txt", 100, &text, &bytes));
    assert_string_equal(text, "old");
    assert_int_equal(sc_outfile_check(&quiet, "taken.txt", false, ""), SC_ERR_CREATE);
    assert_ok(sc_outfile_check(&quiet, "taken.txt", true, ""));
    assert_int_equal(symlink("taken.txt", "link.txt"), 0);
    assert_int_equal(sc_outfile_check(&quiet, "link.txt", true, ""), SC_ERR_CREATE);
    assert_true(sc_same_file("taken.txt", "link.txt"));
    assert_false(sc_same_file("taken.txt", "."));
    assert_int_equal(sc_outfile_check(&quiet, ".", true, ""), SC_ERR_CREATE);
    assert_int_equal(sc_outfile_check(&quiet, "no/such/folder", true, ""), SC_ERR_CREATE);
    assert_int_equal(sc_outfile_check(&quiet, "", true, ""), SC_ERR_CREATE);
    assert_int_equal(sc_outfile_check(&quiet, "folder/", true, ""), SC_ERR_CREATE);
    unlink("taken.txt");
    unlink("link.txt");
}

TEST(a_full_disk_is_noticed)
{
    sc_outfile file = {0};

    assert_ok(sc_outfile_open(&listening, "full.bin", true, &file));
    fclose(file.stream);
    file.stream = fopen("/dev/full", "wb");
    if (!file.stream)
        skip();
    for (int i = 0; i < 100000; i++)
        fputc(i, file.stream);
    assert_int_equal(sc_outfile_commit(&listening, &file), SC_ERR_WRITE);
    assert_int_equal(said.errors, 1);
    assert_non_null(strstr(said.text, "No space left"));
    assert_false(exists("full.bin"));
}

static void add_range(void *user, size_t begin, size_t end, int thread)
{
    for (size_t i = begin; i < end; i++)
        ((int *)user)[i]++;
}

TEST(a_parallel_loop_does_every_item_once)
{
    int counts[1000] = {0};

    for (int threads = 1; threads <= 3; threads++)
        sc_parallel_for(threads, 1000, 7, add_range, counts);
    for (int i = 0; i < 1000; i++)
        assert_int_equal(counts[i], 3);
    sc_parallel_for(2, 0, 7, add_range, counts);
}

TEST(lengths_get_a_unit_that_fits)
{
    assert_string_equal(sc_length_unit_for(0).name, "mm");
    assert_string_equal(sc_length_unit_for(0.33).name, "mm");
    assert_string_equal(sc_length_unit_for(0.1).name, "mm");
    assert_string_equal(sc_length_unit_for(0.02).name, "um");
    assert_string_equal(sc_length_unit_for(4e-6).name, "nm");
    assert_true(0.02 / sc_length_unit_for(0.02).mm > 19.99);
    assert_string_equal(sc_length_unit_for(1e-12).name, "nm");
}

TEST(zero_is_never_negative)
{
    char text[32];

    snprintf(text, sizeof text, "%.1f", sc_no_negative_zero(-0.04, 1));
    assert_string_equal(text, "0.0");
    snprintf(text, sizeof text, "%.4f", sc_no_negative_zero(-0.0, 4));
    assert_string_equal(text, "0.0000");
    snprintf(text, sizeof text, "%.1f", sc_no_negative_zero(-0.06, 1));
    assert_string_equal(text, "-0.1");
}

/* For sc_ctx.write: copy the whole message to @p user. */
static void keep_all(void *user, sc_log_level level, const char *text)
{
    strcpy(user, text);
}

/* What a terminal would obey is shown as text; everything else stays as it is. */
TEST(text_from_files_is_shown_and_not_obeyed)
{
    static const struct {
        const char *from, *shown;
    } cases[] = {{"left atrium", "left atrium"},
                 {"\x1b[31mred\x07", "\\x1b[31mred\\x07"},
                 {"two\nlines\r\x7f", "two\\x0alines\\x0d\\x7f"},
                 {"c1 \xc2\x9b", "c1 \\u009b"}, /* an escape sequence in one character */
                 {"c1 \x9b", "c1 \\x9b"},       /* the same in one byte */
                 {"a\xe2\x80\xae"
                  "b",
                  "a\\u202eb"}, /* turns what follows around */
                 {"\xc3\xa9\xe5\xbf\x83\xf0\x9f\xab\x80", "\xc3\xa9\xe5\xbf\x83\xf0\x9f\xab\x80"},
                 {"cut \xc3", "cut \\xc3"}, /* ends inside a character */
                 {"\xc0\xaf\xed\xa0\x80\xf5", "\\xc0\\xaf\\xed\\xa0\\x80\\xf5"}, /* no UTF-8 */
                 {"%n%s", "%n%s"}};
    char out[256], small[8];

    for (size_t i = 0; i < SC_COUNT_OF(cases); i++) {
        assert_int_equal(sc_printable(cases[i].from, out, sizeof out), strlen(cases[i].shown));
        assert_string_equal(out, cases[i].shown);
    }
    assert_int_equal(sc_printable("abcd\x1b", small, sizeof small), 8);
    assert_string_equal(small, "abcd"); /* the next four bytes and a NUL byte have no room */
    assert_int_equal(sc_printable("\x1b"
                                  "abc",
                                  small, 4),
                     7);
    assert_string_equal(small, ""); /* not even the first character has room */
}

TEST(names_become_valid_utf8_and_end_at_a_whole_character)
{
    char out[8];

    assert_true(sc_copy_name("a\xc3\xa9z", out, sizeof out));
    assert_string_equal(out, "a\xc3\xa9z");
    assert_true(sc_copy_name("a\tb\x1b", out, sizeof out));
    assert_string_equal(out, "a b ");
    assert_false(sc_copy_name("a\xffz", out, sizeof out));
    assert_string_equal(out, "a\xef\xbf\xbdz");
    assert_false(sc_copy_name("123456\xc3\xa9", out, sizeof out));
    assert_string_equal(out, "123456");
}

/* Messages of any length arrive whole, and what a terminal would obey is shown. */
TEST(messages_are_never_cut_and_never_obeyed)
{
    enum { LONG = 30000 };
    static char path[LONG + 1], text[LONG + 64];
    const sc_ctx ctx = {.level = SC_LOG_INFO, .write = keep_all, .user = text, .rank = 3};

    memset(path, 'p', LONG);
    (void)sc_fail(&ctx, SC_ERR_DATA, "%s: %s", path, "wrong");
    assert_int_equal(strlen(text), strlen("rank 3: ") + LONG + strlen(": wrong"));
    memset(path, 'p', LONG);
    path[5] = '\x1b';
    path[10] = '\0';
    sc_warn(&ctx, "%s", path);
    assert_string_equal(text, "rank 3: ppppp\\x1bpppp");
}

/* A script gets a path as it is; a terminal, what it can show of it. */
TEST(a_terminal_shows_a_path_and_does_not_obey_it)
{
    static const char path[] = "\x1b[31mout.mp4";
    const int master = posix_openpt(O_RDWR | O_NOCTTY);
    char text[64] = "";
    FILE *stream = fopen("b.txt", "w+");

    assert_non_null(stream);
    sc_print_path(stream, path);
    rewind(stream);
    assert_non_null(fgets(text, sizeof text, stream));
    assert_string_equal(text, path);
    fclose(stream);
    unlink("b.txt");
    if (master < 0 || grantpt(master) || unlockpt(master))
        skip(); /* there are no terminals here */
    stream = fopen(ptsname(master), "w");
    assert_non_null(stream);
    sc_print_path(stream, path);
    fflush(stream);
    memset(text, 0, sizeof text);
    assert_true(read(master, text, sizeof text - 1) > 0);
    assert_string_equal(text, "\\x1b[31mout.mp4");
    fclose(stream);
    close(master);
}

/* Whoever may make files in a folder but not list it gets them all the same. */
TEST(a_folder_that_cannot_be_read_takes_files)
{
    enum { NOBODY = 65534 };
    const bool is_root = geteuid() == 0; /* may read everything */
    sc_status status;

    assert_int_equal(mkdir("write-only", 0700), 0);
    assert_int_equal(chmod("write-only", 0333), 0);
    if (is_root)
        assert_int_equal(seteuid(NOBODY), 0);
    status = sc_file_write(&quiet, "write-only/a.txt", "x", 1);
    if (is_root)
        assert_int_equal(seteuid(0), 0);
    assert_ok(status);
    assert_int_equal(access("write-only/a.txt", F_OK), 0);
    unlink("write-only/a.txt");
    rmdir("write-only");
}

TEST(sizes_have_three_digits_and_a_unit)
{
    char text[24];

    assert_string_equal(sc_size_text(512, text), "0.50 KiB");
    assert_string_equal(sc_size_text(1.73e6, text), "1.65 MiB");
    assert_string_equal(sc_size_text(64.0 * 1024 * 1024, text), "64.0 MiB");
    assert_string_equal(sc_size_text(3e12, text), "2794 GiB");
}

RUN_TESTS(NULL, NULL)
