/* SPDX-License-Identifier: BSD-3-Clause */
/* Opens the browser of the user at an address that nobody else may know. */
#include "segcast/process.h"

#include <fcntl.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

void sc_browser_open(const char *address, char file[SC_PATH_BYTES])
{
    const char *own = getenv("XDG_RUNTIME_DIR");
    const bool has_display = getenv("DISPLAY") || getenv("WAYLAND_DISPLAY");
    /* A shell, so that what it starts is not ours to wait for. */
    char *const words[] = {"sh", "-c", "command -v xdg-open && { xdg-open \"$0\" & }", file, NULL};
    posix_spawn_file_actions_t actions;
    pid_t process = -1;
    int page = -1, code = -1;

    snprintf(file, SC_PATH_BYTES, "%s/segcast-desk-%d.html",
             own && own[0] == '/' ? own : sc_temporary_folder(), (int)getpid());
    if (has_display && !getenv("SSH_CONNECTION"))
        page = open(file, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (page < 0) {
        file[0] = '\0';
        return;
    }
    posix_spawn_file_actions_init(&actions);
    for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; stream++)
        posix_spawn_file_actions_addopen(&actions, stream, "/dev/null", O_RDWR, 0);
    if (dprintf(page,
                "<!doctype html><meta charset=\"utf-8\"><meta http-equiv=\"refresh\" content=\"0; "
                "url=%s\"><a href=\"%s\">The desk</a>\n",
                address, address) > 0 &&
        posix_spawnp(&process, words[0], &actions, NULL, words, environ))
        process = -1;
    posix_spawn_file_actions_destroy(&actions);
    close(page);
    if (process < 0 || waitpid(process, &code, 0) != process || code) {
        (void)unlink(file);
        file[0] = '\0';
    }
}
