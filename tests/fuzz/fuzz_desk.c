/* SPDX-License-Identifier: BSD-3-Clause */
/* The input is what is asked of the desk, one request a line: "verb body" as a page asks, or, from
 * the first letter "!" on, method, address, Host, Origin, Content-Length and body, between tabs,
 * "-" for none. In place of libmicrohttpd, which reads from sockets, stands what is below; the
 * secret is 32 zeros, and waiting takes no time. Every request is answered once, and nothing
 * without the secret and the right Host and Origin; only job files are written. */
#include "fuzz.h"
#include "segcast/desk.h"

#include <dirent.h>
#include <errno.h>
#include <jansson.h>
#include <microhttpd.h>
#include <pthread.h>
#include <spawn.h>
#include <stdarg.h>

#define SECRET "00000000000000000000000000000000"
#define HOST "127.0.0.1:1"

enum { REQUESTS_MAX = 16 };

struct MHD_Connection {
    char *method, *url, *host, *origin, *length, *body;
    void *call, *mark; /* of the server */
    int code;          /* 0: not answered */
    bool is_suspended, is_closed;
};
struct MHD_Response {
    char *data;
    size_t bytes;
    bool is_owned, is_json;
};
struct MHD_Daemon {
    int socket;
    MHD_AccessHandlerCallback handler;
    MHD_RequestCompletedCallback completed;
    MHD_NotifyConnectionCallback notify;
    void *user;
};

static struct MHD_Connection requests[REQUESTS_MAX];
static int request_count;
static struct MHD_Daemon server;
static _Atomic double waited_s; /* as far as the server knows */
static sc_comm *comm;

/* ---- in place of the system ---- */

double __real_sc_wall_s(void);
double __wrap_sc_wall_s(void);
int __wrap_pthread_cond_timedwait(pthread_cond_t *condition, pthread_mutex_t *lock,
                                  const struct timespec *until);
ssize_t __wrap_getrandom(void *bytes, size_t count, unsigned flags);
int __wrap_posix_spawn(pid_t *process, const char *path, const posix_spawn_file_actions_t *actions,
                       const posix_spawnattr_t *attributes, char *const words[],
                       char *const environment[]);

double __wrap_sc_wall_s(void)
{
    return __real_sc_wall_s() + waited_s;
}

int __wrap_pthread_cond_timedwait(pthread_cond_t *condition, pthread_mutex_t *lock,
                                  const struct timespec *until)
{
    waited_s = waited_s + 0.2;
    return ETIMEDOUT;
}

ssize_t __wrap_getrandom(void *bytes, size_t count, unsigned flags)
{
    memset(bytes, 0, count);
    return (ssize_t)count;
}

int __wrap_posix_spawn(pid_t *process, const char *path, const posix_spawn_file_actions_t *actions,
                       const posix_spawnattr_t *attributes, char *const words[],
                       char *const environment[])
{
    return ENOENT; /* it would be this program */
}

/* ---- in place of libmicrohttpd ---- */

/* The request ends. When all have, the desk does. */
static void finish(struct MHD_Connection *c)
{
    bool all = true;

    c->is_closed = true;
    server.completed(server.user, c, &c->call, MHD_REQUEST_TERMINATED_COMPLETED_OK);
    FUZZ_CHECK(!c->call);
    server.notify(server.user, c, &c->mark, MHD_CONNECTION_NOTIFY_CLOSED);
    for (int i = 0; i < request_count; i++)
        all = all && requests[i].is_closed;
    if (all)
        *(atomic_int *)(uintptr_t)sc_signals_catch_stop() = 1;
}

/* Hand over a part of the body, or its end. @return whether the request goes on. */
static bool hand_over(struct MHD_Connection *c, const char *data, size_t bytes)
{
    const enum MHD_Result result =
        server.handler(server.user, c, c->url, c->method, "HTTP/1.1", data, &bytes, &c->call);

    if (result == MHD_YES && !c->code)
        return true;
    finish(c);
    return false;
}

static void ask(struct MHD_Connection *c)
{
    const size_t bytes = strlen(c->body), half = bytes / 2;

    server.notify(server.user, c, &c->mark, MHD_CONNECTION_NOTIFY_STARTED);
    if (!hand_over(c, NULL, 0) || (half && !hand_over(c, c->body, half)) ||
        (bytes > half && !hand_over(c, c->body + half, bytes - half)) || !hand_over(c, NULL, 0))
        return;
    FUZZ_CHECK(c->is_suspended);
}

struct MHD_Daemon *MHD_start_daemon(unsigned flags, uint16_t port, MHD_AcceptPolicyCallback accept,
                                    void *accept_user, MHD_AccessHandlerCallback handler,
                                    void *user, ...)
{
    va_list options;
    int option;

    server = (struct MHD_Daemon){.socket = -1, .handler = handler, .user = user};
    va_start(options, user);
    while ((option = va_arg(options, int)) != MHD_OPTION_END) {
        if (option == MHD_OPTION_LISTEN_SOCKET) {
            server.socket = va_arg(options, int);
        } else if (option == MHD_OPTION_NOTIFY_COMPLETED) {
            server.completed = va_arg(options, MHD_RequestCompletedCallback);
            (void)va_arg(options, void *);
        } else if (option == MHD_OPTION_NOTIFY_CONNECTION) {
            server.notify = va_arg(options, MHD_NotifyConnectionCallback);
            (void)va_arg(options, void *);
        } else if (option == MHD_OPTION_CONNECTION_MEMORY_LIMIT) {
            (void)va_arg(options, size_t);
        } else {
            (void)va_arg(options, unsigned);
        }
    }
    va_end(options);
    FUZZ_CHECK(server.completed && server.notify);
    for (int i = 0; i < request_count; i++)
        ask(&requests[i]);
    return &server;
}

MHD_socket MHD_quiesce_daemon(struct MHD_Daemon *daemon)
{
    return daemon->socket;
}

void MHD_stop_daemon(struct MHD_Daemon *daemon)
{
    for (int i = 0; i < request_count; i++)
        FUZZ_CHECK(requests[i].is_closed);
}

const char *MHD_lookup_connection_value(struct MHD_Connection *c, enum MHD_ValueKind kind,
                                        const char *key)
{
    const char *value = !strcmp(key, "Host")     ? c->host
                        : !strcmp(key, "Origin") ? c->origin
                                                 : c->length;

    return value && strcmp(value, "-") != 0 ? value : NULL;
}

const union MHD_ConnectionInfo *MHD_get_connection_info(struct MHD_Connection *c,
                                                        enum MHD_ConnectionInfoType type, ...)
{
    static union MHD_ConnectionInfo info;

    if (type == MHD_CONNECTION_INFO_SOCKET_CONTEXT)
        info.socket_context = c->mark;
    else
        info.connect_fd = -1;
    return &info;
}

void MHD_suspend_connection(struct MHD_Connection *c)
{
    FUZZ_CHECK(!c->is_suspended && !c->code);
    c->is_suspended = true;
}

void MHD_resume_connection(struct MHD_Connection *c)
{
    FUZZ_CHECK(c->is_suspended && !c->code);
    c->is_suspended = false;
    FUZZ_CHECK(!hand_over(c, NULL, 0) && c->code);
}

struct MHD_Response *MHD_create_response_from_buffer(size_t size, void *buffer,
                                                     enum MHD_ResponseMemoryMode mode)
{
    struct MHD_Response *response = calloc(1, sizeof *response);

    FUZZ_CHECK(response);
    *response = (struct MHD_Response){buffer, size, mode == MHD_RESPMEM_MUST_FREE, false};
    return response;
}

enum MHD_Result MHD_add_response_header(struct MHD_Response *response, const char *header,
                                        const char *content)
{
    FUZZ_CHECK(!content[strcspn(content, "\r\n")]);
    response->is_json = response->is_json || !strcmp(content, "application/json");
    return MHD_YES;
}

/* @return whether a request may be answered with what only the owner may see. */
static bool is_own(const struct MHD_Connection *c)
{
    return !strncmp(c->url, "/" SECRET "/", sizeof SECRET + 1) &&
           (!strncmp(c->host, "127.0.0.1", 9) || !strncmp(c->host, "localhost", 9) ||
            !strncmp(c->host, "[::1]", 5)) &&
           (strcmp(c->origin, "-") != 0
                ? !strncmp(c->origin, "http://", 7) && !strcmp(c->origin + 7, c->host)
                : !strcmp(c->method, "GET"));
}

enum MHD_Result MHD_queue_response(struct MHD_Connection *c, unsigned code,
                                   struct MHD_Response *response)
{
    FUZZ_CHECK(!c->code && code >= 200 && code != 500);
    c->code = (int)code;
    FUZZ_CHECK(code != 200 || is_own(c));
    if (response->is_json) {
        json_t *json = json_loadb(response->data, response->bytes, 0, NULL);

        FUZZ_CHECK(json);
        json_decref(json);
    }
    return MHD_YES;
}

void MHD_destroy_response(struct MHD_Response *response)
{
    if (response->is_owned)
        free(response->data);
    free(response);
}

/* ---- inputs ---- */

/* @return what stands before a tab, which ends there; *at goes behind it. */
static char *field(char **at)
{
    static char nothing[] = "";
    char *begin = *at ? *at : nothing, *tab = strchr(begin, '\t');

    *at = tab ? tab + 1 : NULL;
    if (tab)
        *tab = '\0';
    return begin;
}

/* Read a request from a line, in which its parts end. */
static struct MHD_Connection read_request(char *line, char url[100])
{
    static char post[] = "POST", host[] = HOST, origin[] = "http://" HOST, none[] = "-";
    struct MHD_Connection c = {0};

    if (line[0] == '!') {
        line++;
        c.method = field(&line);
        c.url = field(&line);
        c.host = field(&line);
        c.origin = field(&line);
        c.length = field(&line);
        c.body = field(&line);
        return c;
    }
    c = (struct MHD_Connection){.method = post,
                                .url = url,
                                .host = host,
                                .origin = origin,
                                .length = none,
                                .body = strchr(line, ' ')};
    if (c.body)
        *c.body++ = '\0';
    else
        c.body = strchr(line, '\0');
    snprintf(url, 100, "/" SECRET "/%.60s", line);
    return c;
}

/* Look at what was written beside the job, and remove it. */
static void check_files(void)
{
    DIR *folder = opendir(fuzz_folder);
    struct dirent *entry;

    FUZZ_CHECK(folder);
    while ((entry = readdir(folder)) != NULL) {
        const char *ending = strrchr(entry->d_name, '.');

        if (!strcmp(entry->d_name, ".") || !strcmp(entry->d_name, "..") ||
            !strcmp(entry->d_name, "prepared"))
            continue;
        FUZZ_CHECK(ending && entry->d_name[0] != '.' &&
                   (!strcmp(ending, ".yaml") || !strcmp(ending, ".yml") ||
                    !strcmp(entry->d_name, "volume.seg.nrrd")));
        FUZZ_CHECK(!unlinkat(dirfd(folder), entry->d_name, 0));
    }
    closedir(folder);
}

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    FUZZ_CHECK(freopen("/dev/null", "w", stdout)); /* where addresses are printed */
    FUZZ_CHECK(!setenv("SEGCAST_CACHE", fuzz_kept_path("prepared"), 1)); /* it is prepared once */
    FUZZ_CHECK(sc_comm_open(&fuzz_ctx, false, &comm) == SC_OK);
    return 0;
}

/* Write a small volume with three tissues. */
static void write_volume(void)
{
    static const char head[] =
        "NRRD0004\ntype: uchar\ndimension: 3\nspace: left-posterior-superior\nsizes: 12 10 12\n"
        "space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nkinds: domain domain "
        "domain\nencoding: raw\nSegment0_Name:=aorta\nSegment0_LabelValue:=1\n"
        "Segment1_Name:=epicardial fat\nSegment1_LabelValue:=2\nSegment2_Name:=wall\n"
        "Segment2_LabelValue:=3\n\n";
    static char file[sizeof head - 1 + 12 * 10 * 12];

    memcpy(file, head, sizeof head - 1);
    for (int k = 0; k < 12 * 10 * 12; k++) {
        const int x = k % 12, y = k / 12 % 10, z = k / 120;
        const bool inside = x > 1 && x < 10 && y > 1 && y < 8 && z > 1 && z < 10;

        file[sizeof head - 1 + (size_t)k] = (char)(inside ? x < 5 ? 1 : z < 6 ? 2 : 3 : 0);
    }
    (void)fuzz_write("volume.seg.nrrd", file, sizeof file);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const char job[] =
        "volume: volume.seg.nrrd\n"
        "output: {size: [32, 24], video: none} # small\n"
        "tissues: {\"epicardial fat\": {visible: false}}\n"
        "animation: {frames: 4, clip: [{normal: left}], camera: {zoom: {0%: 1, "
        "100%: 2},\n  orbit: {turns: 0, target_mm: [-6, -5, 6], "
        "distance_mm: 40}}}\n";
    const char *const environment[] = {NULL};
    static char urls[REQUESTS_MAX][100];
    char *text = malloc(size + 1);
    sc_ctx ctx = fuzz_ctx;
    sc_terminal terminal = {0};
    sc_app app = {
        .ctx = &ctx, .comm = comm, .terminal = &terminal, .environment = environment, .threads = 1};
    const sc_desk_plan plan = {.path = fuzz_write("job.yaml", job, sizeof job - 1), .text = job};

    FUZZ_CHECK(text);
    write_volume();
    memcpy(text, data, size);
    text[size] = '\0';
    request_count = 0;
    for (char *line = text, *end; line && request_count < REQUESTS_MAX; line = end) {
        end = strchr(line, '\n');
        if (end)
            *end++ = '\0';
        requests[request_count] = read_request(line, urls[request_count]);
        request_count++;
    }
    *(atomic_int *)(uintptr_t)sc_signals_catch_stop() = 0;
    FUZZ_CHECK(sc_desk_serve(&app, &plan) == SC_OK);
    check_files();
    free(text);
    return 0;
}
