/* SPDX-License-Identifier: BSD-3-Clause */
/* flip_bytes STEP CODE FILE COMMAND...: change one byte of the file at a time, at every STEP-th
 * place from a place that depends on the name of the file, and run the command each time. Prints
 * the places at which it did not exit with CODE, and at the end how many were tried; exits with 1
 * if there were such places. The file is as it was then. */
#include <fcntl.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

/* Run the command, with its output dropped. @return its exit code, or 128 and more for a signal. */
static int run(char **command)
{
    posix_spawn_file_actions_t actions;
    pid_t process;
    int result = 0;

    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
    if (posix_spawnp(&process, command[0], &actions, NULL, command, environ) ||
        waitpid(process, &result, 0) != process)
        exit(2);
    posix_spawn_file_actions_destroy(&actions);
    return WIFEXITED(result) ? WEXITSTATUS(result) : 128 + WTERMSIG(result);
}

/* Exchange the byte at @p at. */
static void put(int fd, off_t at, unsigned char byte)
{
    if (pwrite(fd, &byte, 1, at) != 1)
        exit(2);
}

int main(int argc, char **argv)
{
    const long step = argc > 4 ? strtol(argv[1], NULL, 10) : 0;
    const int code = argc > 4 ? atoi(argv[2]) : 0;
    struct stat info;
    long tried = 0, wrong = 0, first = 0;
    int fd;

    if (step < 1 || (fd = open(argv[3], O_RDWR)) < 0 || fstat(fd, &info))
        return 2;
    for (const char *c = argv[3]; *c; c++)
        first = (first * 31 + *c) % step;
    for (off_t at = first < info.st_size ? first : 0; at < info.st_size; at += step) {
        unsigned char byte;
        int found;

        if (pread(fd, &byte, 1, at) != 1)
            return 2;
        put(fd, at, byte ^ (unsigned char)(1 << at % 8));
        found = run(argv + 4);
        put(fd, at, byte);
        tried++;
        if (found != code) {
            printf("%s: byte %ld: exit code %d, expected %d\n", argv[3], (long)at, found, code);
            wrong++;
        }
    }
    printf("%s: %ld of %ld places tried, %ld wrong\n", argv[3], tried, (long)info.st_size, wrong);
    close(fd);
    return wrong > 0;
}
