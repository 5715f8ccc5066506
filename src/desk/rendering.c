/* SPDX-License-Identifier: BSD-3-Clause */
/* Renders the saved job by a process of its own, as a user would, while the desk goes on. */
#include "desk.h"

#include <errno.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

enum {
    FILM_MAX_BYTES = 1 << 29, /* of a video that is sent to a page */
    SAID_MAX_BYTES = 4000,    /* of what is told of a run that has failed */
    STATUS_MAX_BYTES = 1 << 16
};

/* Note whether the run has ended. */
static void look(sc_rendering *r)
{
    int status;

    if (!r->process || waitpid(r->process, &status, WNOHANG) != r->process)
        return;
    r->process = 0;
    r->exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

/* Start the program anew. */
static sc_status start(sc_desk *desk, bool overwrites)
{
    sc_rendering *r = &desk->rendering;
    char *const arguments[] = {
        "segcast", "render", desk->file.path, "--quiet", overwrites ? "--overwrite" : NULL, NULL};
    posix_spawn_file_actions_t actions;
    int error;

    if (r->said)
        fclose(r->said);
    r->said = tmpfile();
    if (!r->said)
        return sc_fail(&desk->ctx, SC_ERR_CREATE, "a temporary file cannot be made: %s",
                       sc_reason(errno));
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", 0, 0);
    posix_spawn_file_actions_adddup2(&actions, fileno(r->said), STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, fileno(r->said), STDERR_FILENO);
    error = posix_spawn(&r->process, "/proc/self/exe", &actions, NULL, arguments, environ);
    posix_spawn_file_actions_destroy(&actions);
    if (!error)
        return SC_OK;
    r->process = 0;
    return sc_fail(&desk->ctx, SC_ERR_SYSTEM, "segcast cannot be started: %s", sc_reason(error));
}

void sc_desk_render(sc_desk *desk, sc_call *call)
{
    json_array_clear(desk->notes.list);
    desk->notes.errors = 0;
    look(&desk->rendering);
    if (desk->rendering.process)
        sc_desk_refuse(desk, call, "the job is being rendered already");
    else if (!desk->file.on_disk)
        sc_desk_refuse(desk, call, "the job has not been saved yet");
    else if (start(desk, json_is_true(json_object_get(call->body, "overwrite"))) != SC_OK)
        sc_desk_refuse(desk, call, "the job could not be started");
    else
        sc_http_answer_json(call, 200, json_pack("{s:b}", "started", 1));
}

/* @return what the run has said, its end; NULL: no memory. */
static json_t *said(FILE *file)
{
    char text[SAID_MAX_BYTES + 1], shown[4 * SAID_MAX_BYTES];
    size_t bytes;
    long end;

    if (!file || fseek(file, 0, SEEK_END) || (end = ftell(file)) < 0)
        return json_string("");
    if (fseek(file, end > SAID_MAX_BYTES ? end - SAID_MAX_BYTES : 0, SEEK_SET))
        return json_string("");
    bytes = fread(text, 1, SAID_MAX_BYTES, file);
    text[bytes] = '\0';
    for (char *c = text; *c; c++)
        *c = *c == '\n' ? ' ' : *c;
    sc_printable(text, shown, sizeof shown);
    return json_string(shown);
}

/* @return the file @p name of the output directory, in memory; NULL: there is none. The caller
 * frees it. */
static char *read_output(const sc_desk *desk, const char *name, size_t most, size_t *bytes)
{
    const sc_ctx quiet = sc_quiet(&desk->ctx);
    char path[2 * SC_PATH_BYTES], *data = NULL;

    snprintf(path, sizeof path, "%s/%s", desk->sessions.now->job.output.directory, name);
    return sc_file_read(&quiet, path, most, &data, bytes) == SC_OK ? data : NULL;
}

void sc_desk_rendering(sc_desk *desk, sc_call *call)
{
    sc_rendering *r = &desk->rendering;
    size_t bytes = 0;
    char *status = read_output(desk, "status.json", STATUS_MAX_BYTES, &bytes);
    json_t *json = status && r->process ? json_loadb(status, bytes, 0, NULL) : NULL;

    look(r);
    sc_free(status);
    sc_http_answer_json(
        call, 200,
        json_pack("{s:b, s:b, s:i, s:o, s:s, s:o}", "started", r->said != NULL, "runs",
                  r->process != 0, "exit", r->exit_code, "said", said(r->said), "directory",
                  desk->sessions.now->job.output.directory, "status", json ? json : json_null()));
}

void sc_desk_film(sc_desk *desk, sc_call *call)
{
    const char *name = desk->sessions.now->job.output.video, *ending = strrchr(name, '.');
    const bool is_webm = ending && (!strcmp(ending, ".webm") || !strcmp(ending, ".mkv"));
    const bool is_image = ending && (!strcmp(ending, ".gif") || !strcmp(ending, ".webp"));
    size_t bytes = 0;
    char *data = read_output(desk, name, FILM_MAX_BYTES, &bytes);

    if (data)
        sc_http_answer(call, 200,
                       is_image  ? "image/gif"
                       : is_webm ? "video/webm"
                                 : "video/mp4",
                       data, bytes, NULL);
    else
        sc_desk_refuse(desk, call, "there is no video yet");
}

void sc_desk_end_rendering(sc_desk *desk)
{
    sc_rendering *r = &desk->rendering;

    look(r);
    if (r->process) {
        int status;

        kill(r->process, SIGTERM);
        (void)waitpid(r->process, &status, 0);
    }
    if (r->said)
        fclose(r->said);
}
