/* SPDX-License-Identifier: BSD-3-Clause */
/* Files that the ranks of a node share: nothing of them stays behind, whenever a process is killed.
 */
#include "check.h"

#include "comm_ops.h"
#include "segcast/team.h"
#include "shared_file.h"

#include <dirent.h>
#include <errno.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

static char folder[] = "shared-XXXXXX";

/* @return the number of files in the folder, hidden ones included. */
static int count_files(void)
{
    DIR *stream = opendir(folder);
    const struct dirent *entry;
    int count = 0;

    assert_non_null(stream);
    while ((entry = readdir(stream)))
        count += strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0;
    closedir(stream);
    return count;
}

/* Make a file in a process of its own, which then ends by @p number; 0: as a signal handler ends
 * it. */
static void make_and_die(int number)
{
    const pid_t child = fork();
    int status;

    assert_true(child >= 0);
    if (child == 0) {
        sc_shared_name name;
        int file;

        if (sc_shared_file_make(folder, 1000, 0, &name, &file) != SC_OK)
            _exit(1);
        if (number)
            raise(number);
        sc_unfinished_remove();
        _exit(75);
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(number ? WIFSIGNALED(status) : WIFEXITED(status) && WEXITSTATUS(status) == 75);
}

TEST(what_a_killed_process_left_is_cleared_by_the_next)
{
    sc_shared_name name;
    int file;

    make_and_die(0); /* Ctrl-C */
    assert_int_equal(count_files(), 0);
    make_and_die(SIGKILL);
    assert_int_equal(count_files(), 1);
    assert_int_equal(sc_shared_file_make(folder, 1000, 0, &name, &file), SC_OK);
    assert_int_equal(count_files(), 1); /* its own */
    make_and_die(SIGKILL);
    assert_int_equal(count_files(), 2); /* that of a process that lives stays */
    sc_shared_file_remove(&name);
    sc_shared_file_remove(&name); /* the second time does nothing */
    close(file);
    assert_int_equal(sc_shared_file_make(folder, 1000, 0, &name, &file), SC_OK);
    sc_shared_file_remove(&name);
    close(file);
    assert_int_equal(count_files(), 0);
    assert_int_equal(rmdir(folder), 0);
}

/* A single process holds blocks in files where that is preferred, and in memory where they have no
 * room. */
TEST(blocks_are_files_where_that_is_preferred)
{
    const sc_ctx silent = {.rank = 0};
    sc_comm *comm;
    sc_shared *shared;
    sc_team *team;
    void *array;

    assert_int_equal(mkdir(folder, 0777), 0);
    assert_int_equal(sc_comm_self_open(&silent, &comm), SC_OK);
    for (int prefers = 0; prefers < 2; prefers++) {
        sc_comm_prefer_files(comm, prefers);
        assert_int_equal(sc_shared_alloc(&silent, comm, 5000, folder, &shared), SC_OK);
        assert_int_equal(sc_shared_place_of(shared),
                         prefers ? SC_SHARED_IN_FILE : SC_SHARED_IN_MEMORY);
        for (int i = 0; i < 5000; i++)
            assert_int_equal(((char *)sc_shared_data(shared))[i], 0);
        memset(sc_shared_data(shared), 1, 5000);
        sc_shared_free(shared);
        assert_int_equal(sc_team_open(&silent, comm, 2, folder, &team), SC_OK);
        assert_int_equal(sc_team_ranks(team), 1);
        assert_int_equal(sc_team_alloc(&silent, team, 1000, 4, &array), SC_OK);
        memset(array, 1, 4000);
        sc_team_close(team);
        assert_int_equal(count_files(), 0); /* they have no names */
    }
    assert_int_equal(sc_shared_alloc(&silent, comm, 5000, "no-such-folder", &shared), SC_OK);
    assert_int_equal(sc_shared_place_of(shared), SC_SHARED_IN_MEMORY);
    assert_int_equal(sc_shared_file_error(shared), ENOENT);
    sc_shared_free(shared);
    assert_int_equal(sc_shared_alloc(&silent, comm, 5000, NULL, &shared), SC_OK);
    assert_int_equal(sc_shared_place_of(shared), SC_SHARED_IN_MEMORY);
    sc_shared_free(shared);
    sc_comm_close(comm);
    assert_int_equal(rmdir(folder), 0);
}

/* @return the resident bytes of files in this process; 0 where the system does not tell. Its own
 * memory does not count: the address sanitizer reads some for all that is written. */
static size_t resident_bytes(void)
{
    FILE *stream = fopen("/proc/self/statm", "r");
    unsigned long all, with_own, resident = 0;

    if (!stream)
        return 0;
    if (fscanf(stream, "%lu %lu %lu", &all, &with_own, &resident) != 3)
        resident = 0;
    fclose(stream);
    return resident * (size_t)sysconf(_SC_PAGESIZE);
}

/* What is not needed for now leaves the memory of the process, if it is in a file, and is there
 * again when it is read. */
TEST(what_is_not_needed_leaves_the_memory)
{
    enum { BYTES = 48 << 20, MOST = 8 << 20 };
    const sc_ctx silent = {.rank = 0};
    sc_comm *comm;
    sc_shared *shared;
    sc_team *team;
    size_t before, used;
    void *array;

    assert_int_equal(mkdir(folder, 0777), 0);
    assert_int_equal(sc_comm_self_open(&silent, &comm), SC_OK);
    sc_comm_prefer_files(comm, true);
    before = resident_bytes();
    assert_int_equal(sc_shared_alloc(&silent, comm, BYTES, folder, &shared), SC_OK);
    memset(sc_shared_data(shared), 5, BYTES);
    assert_int_equal(sc_team_open(&silent, comm, 1, folder, &team), SC_OK);
    assert_int_equal(sc_team_alloc(&silent, team, BYTES, 1, &array), SC_OK);
    memset(array, 7, BYTES);
    used = resident_bytes();
    assert_true(!used || used > before + 2 * BYTES - MOST);
    sc_shared_advise(shared, SC_MEMORY_NOT_NEEDED);
    sc_team_advise(team, SC_MEMORY_NOT_NEEDED);
    assert_true(resident_bytes() <= before + MOST);
    sc_shared_advise(shared, SC_MEMORY_NEEDED_SOON);
    for (int i = 0; i < BYTES; i += 4093) {
        assert_int_equal(((char *)sc_shared_data(shared))[i], 5);
        assert_int_equal(((char *)array)[i], 7);
    }
    sc_team_close(team);
    sc_shared_free(shared);

    sc_comm_prefer_files(comm, false); /* what is in memory alone stays there */
    assert_int_equal(sc_shared_alloc(&silent, comm, BYTES, folder, &shared), SC_OK);
    memset(sc_shared_data(shared), 3, BYTES);
    sc_shared_advise(shared, SC_MEMORY_NOT_NEEDED);
    for (int i = 0; i < BYTES; i += 4093)
        assert_int_equal(((char *)sc_shared_data(shared))[i], 3);
    sc_shared_free(shared);
    assert_int_equal(sc_comm_agree_room(comm, folder, 1), SC_OK);
    assert_int_equal(sc_comm_agree_room(comm, folder, (uint64_t)1 << 60), SC_ERR_MEMORY);
    sc_comm_close(comm);
    assert_int_equal(rmdir(folder), 0);
}

/* Why there is no file tells errno. */
TEST(a_folder_without_room_is_told)
{
    sc_shared_name name;
    int file;

    errno = 0;
    assert_int_equal(sc_shared_file_make("/tmp", (size_t)1 << 60, 0, &name, &file), SC_ERR_MEMORY);
    assert_int_equal(errno, ENOSPC);
    assert_int_equal(sc_shared_file_make("no-such-folder", 1, 0, &name, &file), SC_ERR_CREATE);
    assert_int_equal(errno, ENOENT);
}

int main(void)
{
    if (!mkdtemp(folder))
        return 1;
    return run_all_tests(NULL, NULL);
}
