/* SPDX-License-Identifier: BSD-3-Clause */
/* The server; the only user of libmicrohttpd. A thread of that library reads requests. A request is
 * "POST /SECRET/VERB" with an object of JSON, or "GET /SECRET/", the page. Everything else is
 * refused before its body is read. A request that is queued is suspended until it is answered. */
#include "http.h"

#include "segcast/process.h"

#include <arpa/inet.h>
#include <errno.h>
#include <microhttpd.h>
#include <netdb.h>
#include <pthread.h>
#include <stdlib.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

enum {
    BODY_MAX_BYTES = 1 << 18, /* of a request: some thousand changes of a job */
    CONNECTIONS_MAX = 512,    /* more are not accepted */
    STRANGERS_MAX = 256,      /* open connections that have not sent the secret yet */
    QUIET_MAX_S = 30,         /* a connection that sends nothing for so long is closed */
    FORWARDED_PORT = 8765     /* that ssh listens to for a Unix socket, if none was chosen */
};

/* A connection, from when it is accepted to when it is closed. */
typedef struct stranger {
    struct stranger *next;
    int socket;
} stranger;

struct sc_http {
    struct MHD_Daemon *daemon;
    sc_http_settings settings;
    char secret[SC_SECRET_DIGITS + 1];
    char page_file[SC_PATH_BYTES]; /* see sc_browser_open */
    int port;
    _Atomic double active_s;
    stranger *strangers; /* those that have not shown the secret yet, the newest first */
    int stranger_count;
    pthread_mutex_t lock; /* of all below */
    pthread_cond_t queued;
    sc_call *first, **last;
};

/* ---- who may ask ---- */

/* @return whether @p text begins with the secret. The time does not tell how much of it is right.
 */
static bool has_secret(const sc_http *http, const char *text)
{
    unsigned differ = 0;

    if (strnlen(text, SC_SECRET_DIGITS) < SC_SECRET_DIGITS) /* its length is no secret */
        return false;
    for (size_t i = 0; i < SC_SECRET_DIGITS; i++)
        differ |= (unsigned)(text[i] ^ http->secret[i]);
    return differ == 0;
}

/* @return whether the value of a Host header, with or without a port, names this machine by a name
 * that no other can have: another name could be that of a foreign page that leads here. */
static bool is_own_host(const sc_http *http, const char *host)
{
    const char *const names[] = {"localhost", "127.0.0.1", "[::1]", http->settings.listen};

    for (size_t i = 0; host && i < SC_COUNT_OF(names); i++) {
        const size_t length = names[i] ? strlen(names[i]) : 0;

        if (length && !strncmp(host, names[i], length) &&
            (!host[length] ||
             (host[length] == ':' && !host[length + 1 + strspn(host + length + 1, "0123456789")])))
            return true;
    }
    return false;
}

/* @return whether a request comes from the page of this server, not from a foreign one. */
static bool is_own_origin(struct MHD_Connection *connection, const char *host, bool is_post)
{
    static const char scheme[] = "http://";
    const char *origin = MHD_lookup_connection_value(connection, MHD_HEADER_KIND, "Origin");

    if (!origin)
        return !is_post;
    return !strncmp(origin, scheme, sizeof scheme - 1) && !strcmp(origin + sizeof scheme - 1, host);
}

/* @return the code by which a request is refused before its body is read; 0: it is not. */
static int refusal(const sc_http *http, struct MHD_Connection *connection, const char *url,
                   const char *method)
{
    const char *host = MHD_lookup_connection_value(connection, MHD_HEADER_KIND, "Host");
    const char *length = MHD_lookup_connection_value(connection, MHD_HEADER_KIND, "Content-Length");
    const bool is_post = !strcmp(method, "POST"), is_get = !strcmp(method, "GET");

    if (!is_own_host(http, host) || !is_own_origin(connection, host, is_post) || url[0] != '/' ||
        !has_secret(http, url + 1) || url[1 + SC_SECRET_DIGITS] != '/')
        return MHD_HTTP_FORBIDDEN;
    if (!is_post && !is_get)
        return MHD_HTTP_METHOD_NOT_ALLOWED;
    if (is_get && url[2 + SC_SECRET_DIGITS])
        return MHD_HTTP_NOT_FOUND;
    if (length && (strlen(length) > 9 || atol(length) > BODY_MAX_BYTES))
        return MHD_HTTP_CONTENT_TOO_LARGE;
    return 0;
}

/* ---- strangers ---- */

/* Take a connection from the list, if it is there. */
static void unlist(sc_http *http, const stranger *s)
{
    for (stranger **at = &http->strangers; *at; at = &(*at)->next) {
        if (*at == s) {
            *at = s->next;
            http->stranger_count--;
            return;
        }
    }
}

/* Note that a connection begins or ends. With too many strangers, the oldest has to go: so the room
 * that a browser needs is never taken by connections that send a byte now and then. */
static void on_connection(void *user, struct MHD_Connection *connection, void **mine,
                          enum MHD_ConnectionNotificationCode code)
{
    sc_http *http = user;
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD);
    stranger *s = *mine;

    if (code != MHD_CONNECTION_NOTIFY_STARTED) {
        unlist(http, s);
        free(s);
        return;
    }
    s = calloc(1, sizeof *s);
    *mine = s;
    if (!s || !info)
        return;
    *s = (stranger){http->strangers, info->connect_fd};
    http->strangers = s;
    if (++http->stranger_count <= STRANGERS_MAX)
        return;
    while (s->next)
        s = s->next;
    (void)shutdown(s->socket, SHUT_RDWR);
    unlist(http, s);
}

/* ---- answers ---- */

/* @return a response; NULL: no memory. @param mode who owns the data. */
static struct MHD_Response *make_response(const char *type, const void *data, size_t bytes,
                                          enum MHD_ResponseMemoryMode mode)
{
    const char *const headers[][2] = {
        {"Content-Type", type},
        {"Cache-Control", "no-store"},
        {"X-Content-Type-Options", "nosniff"},
        {"X-Frame-Options", "DENY"},
        {"Referrer-Policy", "no-referrer"},
        {"Cross-Origin-Resource-Policy", "same-origin"},
        {"Content-Security-Policy",
         "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src blob: "
         "data:; media-src blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; "
         "frame-ancestors 'none'"}};
    struct MHD_Response *response =
        MHD_create_response_from_buffer(bytes, (void *)(uintptr_t)data, mode);

    for (size_t i = 0; response && i < SC_COUNT_OF(headers); i++)
        MHD_add_response_header(response, headers[i][0], headers[i][1]);
    return response;
}

/* Send a response, which is taken; NULL: close the connection. */
static enum MHD_Result send_response(struct MHD_Connection *connection, int code,
                                     struct MHD_Response *response)
{
    enum MHD_Result result = MHD_NO;

    if (response) {
        result = MHD_queue_response(connection, (unsigned)code, response);
        MHD_destroy_response(response);
    }
    return result;
}

/* Refuse a request, without words: who has the secret does not need them. */
static enum MHD_Result refuse(struct MHD_Connection *connection, int code)
{
    struct MHD_Response *response =
        make_response("text/plain", "refused\n", 8, MHD_RESPMEM_PERSISTENT);

    if (response)
        MHD_add_response_header(response, "Connection", "close");
    return send_response(connection, code, response);
}

/* Make an answer of @p data, of malloc, which is freed. */
static void make_answer(sc_call *call, int code, const char *type, void *data, size_t bytes)
{
    call->code = code;
    call->answer = make_response(type, data, data ? bytes : 0, MHD_RESPMEM_MUST_FREE);
    if (!call->answer)
        free(data);
}

void sc_http_answer(sc_call *call, int code, const char *type, void *data, size_t bytes,
                    const char *view)
{
    make_answer(call, code, type, data, bytes);
    if (call->answer && view)
        MHD_add_response_header(call->answer, "X-View", view);
    MHD_resume_connection(call->connection); /* from here on it is the other thread's */
}

/* @return JSON, whose reference is taken, as text, which the caller frees; NULL: no memory. */
static char *text_of(json_t *json)
{
    char *text = json ? json_dumps(json, JSON_COMPACT | JSON_REAL_PRECISION(12)) : NULL;

    json_decref(json);
    return text;
}

void sc_http_answer_json(sc_call *call, int code, json_t *json)
{
    char *text = text_of(json);

    sc_http_answer(call, text ? code : MHD_HTTP_INTERNAL_SERVER_ERROR, "application/json", text,
                   text ? strlen(text) : 0, NULL);
}

/* ---- calls ---- */

static void free_call(sc_call *call)
{
    json_decref(call->body);
    free(call->text);
    if (call->answer)
        MHD_destroy_response(call->answer);
    free(call);
}

/* Send the answer of a call. */
static enum MHD_Result send_answer(sc_call *call)
{
    struct MHD_Response *answer = call->answer;

    call->answer = NULL;
    return send_response(call->connection, call->code, answer);
}

/* Only asks for news: nothing that is being drawn has to stop for it, and nobody does anything. */
static bool is_poll(const char *verb)
{
    return !strcmp(verb, "picture") || !strcmp(verb, "state") || !strcmp(verb, "sheet");
}

/* Queue a call whose body is complete. */
static enum MHD_Result queue_call(sc_call *call)
{
    sc_http *http = call->http;
    bool is_news;

    call->body = json_loadb(call->text ? call->text : "{}", call->text ? call->bytes : 2, 0, NULL);
    if (!json_is_object(call->body))
        return refuse(call->connection, MHD_HTTP_BAD_REQUEST);
    call->is_queued = true;
    is_news = is_poll(call->verb);
    if (!is_news)
        http->active_s = sc_wall_s();
    MHD_suspend_connection(call->connection);
    pthread_mutex_lock(&http->lock);
    *http->last = call;
    http->last = &call->next;
    pthread_cond_signal(&http->queued);
    pthread_mutex_unlock(&http->lock);
    if (!is_news && *http->settings.may_interrupt) /* see sc_http_waits: after it was queued */
        *http->settings.interrupt = 1;
    return MHD_YES;
}

/* Answer what the thread that draws is not needed for: how far it is. */
static enum MHD_Result send_progress(sc_call *call)
{
    const sc_ctx ctx = {.stage = (sc_stage *)(uintptr_t)call->http->settings.stage};
    const sc_stage_view view = sc_stage_look(&ctx);
    char *text = text_of(json_pack("{s:s, s:f, s:f}", "stage", view.name ? view.text : "", "share",
                                   view.share, "left_s", view.left_s));

    make_answer(call, MHD_HTTP_OK, "application/json", text, text ? strlen(text) : 0);
    return send_answer(call);
}

/* Keep a part of a body. */
static bool add_body(sc_call *call, const char *data, size_t bytes)
{
    if (bytes > BODY_MAX_BYTES - call->bytes)
        return false;
    if (call->bytes + bytes > call->room) {
        const size_t room = 2 * (call->bytes + bytes);
        char *text = realloc(call->text, room);

        if (!text)
            return false;
        call->text = text;
        call->room = room;
    }
    memcpy(call->text + call->bytes, data, bytes);
    call->bytes += bytes;
    return true;
}

/* Begin a request: its head is complete. */
static enum MHD_Result begin_call(sc_http *http, struct MHD_Connection *connection, const char *url,
                                  const char *method, void **mine)
{
    const int code = refusal(http, connection, url, method);
    const char *verb = url + 2 + SC_SECRET_DIGITS;
    const union MHD_ConnectionInfo *info;
    sc_call *call;

    if (code)
        return refuse(connection, code);
    info = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_SOCKET_CONTEXT);
    if (info)
        unlist(http, info->socket_context);
    if (!strcmp(method, "GET"))
        return send_response(connection, MHD_HTTP_OK,
                             make_response("text/html; charset=utf-8", http->settings.page,
                                           strlen(http->settings.page), MHD_RESPMEM_PERSISTENT));
    if (strlen(verb) >= sizeof call->verb ||
        verb[strspn(verb, "abcdefghijklmnopqrstuvwxyz")] != '\0')
        return refuse(connection, MHD_HTTP_NOT_FOUND);
    call = calloc(1, sizeof *call);
    if (!call)
        return MHD_NO;
    call->http = http;
    call->connection = connection;
    strcpy(call->verb, verb);
    *mine = call;
    return MHD_YES;
}

/* The callback of the library: called when the head of a request is there, with each part of its
 * body, when that is complete, and when the connection is resumed. */
static enum MHD_Result on_request(void *user, struct MHD_Connection *connection, const char *url,
                                  const char *method, const char *version, const char *data,
                                  size_t *bytes, void **mine)
{
    sc_call *call = *mine;

    if (!call)
        return begin_call(user, connection, url, method, mine);
    if (*bytes) {
        const bool fits = add_body(call, data, *bytes);

        *bytes = 0;
        return fits ? MHD_YES : MHD_NO;
    }
    if (call->is_queued)
        return send_answer(call);
    if (!strcmp(call->verb, "progress"))
        return send_progress(call);
    return queue_call(call);
}

/* The callback for the end of a request, however it ends. */
static void on_completed(void *user, struct MHD_Connection *connection, void **mine,
                         enum MHD_RequestTerminationCode code)
{
    if (*mine)
        free_call(*mine);
    *mine = NULL;
}

sc_call *sc_http_next(sc_http *http, double wait_s)
{
    struct timespec until;
    sc_call *call;

    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_nsec += (long)(wait_s * 1e9);
    until.tv_sec += until.tv_nsec / 1000000000;
    until.tv_nsec %= 1000000000;
    pthread_mutex_lock(&http->lock);
    while (!http->first && !pthread_cond_timedwait(&http->queued, &http->lock, &until))
        (void)unlink(http->page_file);
    call = http->first;
    if (call) {
        http->first = call->next;
        if (!http->first)
            http->last = &http->first;
        call->next = NULL;
    }
    pthread_mutex_unlock(&http->lock);
    return call;
}

bool sc_http_waits(sc_http *http)
{
    bool waits = false;

    pthread_mutex_lock(&http->lock);
    for (const sc_call *call = http->first; call; call = call->next)
        waits = waits || !is_poll(call->verb);
    pthread_mutex_unlock(&http->lock);
    return waits;
}

double sc_http_idle_s(const sc_http *http)
{
    return sc_wall_s() - http->active_s;
}

/* ---- beginning and end ---- */

/* Make a secret of random digits. */
static sc_status make_secret(const sc_ctx *ctx, char out[SC_SECRET_DIGITS + 1])
{
    unsigned char bytes[SC_SECRET_DIGITS / 2];

    if (getrandom(bytes, sizeof bytes, 0) != (ssize_t)sizeof bytes)
        return sc_fail(ctx, SC_ERR_SYSTEM, "the system gives no random numbers: %s",
                       sc_reason(errno));
    for (size_t i = 0; i < sizeof bytes; i++)
        snprintf(out + 2 * i, 3, "%02x", bytes[i]);
    return SC_OK;
}

/* @return the path of the Unix socket that is listened to; NULL: it is none. */
static const char *unix_path(const sc_http_settings *s)
{
    return s->listen && !strncmp(s->listen, "unix:", 5) ? s->listen + 5 : NULL;
}

/* Find the address that is listened to, a Unix socket. One that no process listens to any more is
 * removed. */
static sc_status find_path(const sc_ctx *ctx, const char *path, struct sockaddr_un *out)
{
    struct stat info;
    int file;

    if (!path[0] || strlen(path) >= sizeof out->sun_path)
        return sc_fail(ctx, SC_ERR_USAGE,
                       "--listen is \"unix:%s\", expected a path of 1 to %zu bytes", path,
                       sizeof out->sun_path - 1);
    out->sun_family = AF_UNIX;
    strcpy(out->sun_path, path);
    if (lstat(path, &info) || !S_ISSOCK(info.st_mode))
        return SC_OK;
    file = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (file >= 0 && connect(file, (struct sockaddr *)out, sizeof *out) && errno == ECONNREFUSED)
        (void)unlink(path);
    if (file >= 0)
        close(file);
    return SC_OK;
}

/* Find the address that is listened to, of this machine. */
static sc_status find_address(const sc_ctx *ctx, const sc_http_settings *s,
                              struct sockaddr_storage *out)
{
    const char *host = s->listen ? s->listen : "127.0.0.1";
    const struct addrinfo hints = {.ai_family = AF_UNSPEC,
                                   .ai_socktype = SOCK_STREAM,
                                   .ai_flags = AI_NUMERICHOST | AI_NUMERICSERV | AI_PASSIVE};
    struct addrinfo *found = NULL;
    char port[16];

    snprintf(port, sizeof port, "%d", s->port);
    if (getaddrinfo(host, port, &hints, &found))
        return sc_fail(ctx, SC_ERR_USAGE,
                       "--listen is \"%s\", expected an address of this machine, such as "
                       "127.0.0.1 or ::1, or unix:PATH",
                       host);
    memcpy(out, found->ai_addr, found->ai_addrlen);
    freeaddrinfo(found);
    return SC_OK;
}

/* Open the listening socket. Only the user who runs the desk may connect to a Unix socket. */
static sc_status open_socket(const sc_ctx *ctx, const sc_http_settings *s, int *out)
{
    const char *path = unix_path(s);
    struct sockaddr_storage address = {0};
    const int yes = 1;
    socklen_t bytes;
    char name[200];
    int file, error;

    SC_PASS(path ? find_path(ctx, path, (struct sockaddr_un *)&address)
                 : find_address(ctx, s, &address));
    bytes = address.ss_family == AF_UNIX    ? sizeof(struct sockaddr_un)
            : address.ss_family == AF_INET6 ? sizeof(struct sockaddr_in6)
                                            : sizeof(struct sockaddr_in);
    file = socket(address.ss_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (file >= 0)
        (void)setsockopt(file, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    if (file >= 0 && !bind(file, (struct sockaddr *)&address, bytes) &&
        !(path && chmod(path, S_IRUSR | S_IWUSR)) && !listen(file, SOMAXCONN)) {
        *out = file;
        return SC_OK;
    }
    error = errno;
    if (file >= 0)
        close(file);
    if (path)
        snprintf(name, sizeof name, "%s", path);
    else
        snprintf(name, sizeof name, "port %d of %s", s->port, s->listen ? s->listen : "127.0.0.1");
    if (error == EADDRINUSE)
        return sc_fail(ctx, SC_ERR_CREATE,
                       path ? "%s is there already, perhaps as the socket of another desk"
                            : "%s is used by another program, perhaps another desk; give another "
                              "--port, or none for one that is free",
                       name);
    return sc_fail(ctx, SC_ERR_CREATE, "%s: cannot be listened to: %s", name, sc_reason(error));
}

/* @return the port of a socket; 0: unknown. */
static int port_of(int file)
{
    struct sockaddr_storage address;
    socklen_t bytes = sizeof address;

    if (getsockname(file, (struct sockaddr *)&address, &bytes))
        return 0;
    return address.ss_family == AF_INET6 ? ntohs(((struct sockaddr_in6 *)&address)->sin6_port)
                                         : ntohs(((struct sockaddr_in *)&address)->sin_port);
}

/* Let the library serve a socket, which is the library's then. By poll: with epoll it would not see
 * the end of a connection that comes with its last bytes, and keep it until it was quiet for long.
 */
static sc_status start_daemon(const sc_ctx *ctx, sc_http *http, int file)
{
    http->port = !unix_path(&http->settings) ? port_of(file)
                 : http->settings.port       ? http->settings.port
                                             : FORWARDED_PORT;
    http->daemon = MHD_start_daemon(
        MHD_USE_POLL_INTERNAL_THREAD | MHD_ALLOW_SUSPEND_RESUME, 0, NULL, NULL, on_request, http,
        MHD_OPTION_LISTEN_SOCKET, file, MHD_OPTION_CONNECTION_LIMIT, (unsigned)CONNECTIONS_MAX,
        MHD_OPTION_CONNECTION_TIMEOUT, (unsigned)QUIET_MAX_S, MHD_OPTION_NOTIFY_COMPLETED,
        on_completed, http, MHD_OPTION_NOTIFY_CONNECTION, on_connection, http,
        MHD_OPTION_CONNECTION_MEMORY_LIMIT, (size_t)(32 << 10), MHD_OPTION_END);
    if (!http->daemon) {
        close(file);
        return sc_fail(ctx, SC_ERR_SYSTEM, "the server cannot be started: %s", sc_reason(errno));
    }
    return SC_OK;
}

sc_status sc_http_start(const sc_ctx *ctx, const sc_http_settings *settings, sc_http **out)
{
    SC_OWN(sc_http_stop_at) sc_http *http = NULL;
    int file = -1;

    SC_PASS(SC_ZALLOC(ctx, 1, &http));
    http->settings = *settings;
    http->last = &http->first;
    http->active_s = sc_wall_s();
    pthread_mutex_init(&http->lock, NULL);
    pthread_cond_init(&http->queued, NULL);
    SC_PASS(make_secret(ctx, http->secret));
    SC_PASS(open_socket(ctx, settings, &file));
    SC_PASS(start_daemon(ctx, http, file));
    SC_HAND_OVER(http, out);
    return SC_OK;
}

void sc_http_stop(sc_http *http)
{
    sc_call *call;

    if (!http)
        return;
    if (http->daemon)
        close(MHD_quiesce_daemon(http->daemon));
    if (http->page_file[0])
        (void)unlink(http->page_file);
    while ((call = sc_http_next(http, 0)) != NULL)
        sc_http_answer(call, MHD_HTTP_SERVICE_UNAVAILABLE, "text/plain", NULL, 0, NULL);
    if (http->daemon) {
        MHD_stop_daemon(http->daemon);
        if (unix_path(&http->settings))
            (void)unlink(unix_path(&http->settings));
    }
    pthread_mutex_destroy(&http->lock);
    pthread_cond_destroy(&http->queued);
    sc_free(http);
}

bool sc_http_print_address(sc_http *http, const sc_ctx *ctx)
{
    const char *path = unix_path(&http->settings);
    const char *host = http->settings.listen && !path ? http->settings.listen : "127.0.0.1";
    const bool is_six = strchr(host, ':') != NULL;
    char name[SC_HOST_BYTES], at[100], address[200];
    SC_OWN(sc_free_at) char *whole = path ? realpath(path, NULL) : NULL;

    sc_host_name(name);
    snprintf(at, sizeof at, "%s%s%s:%d", is_six ? "[" : "", host, is_six ? "]" : "", http->port);
    if (strcmp(host, "127.0.0.1") != 0 && strcmp(host, "::1") != 0)
        sc_warn(
            ctx,
            "others can connect to %s, unencrypted: whoever reads the address on its way sees and "
            "changes the job; without --listen only this machine can, and ssh -L leads there",
            host);
    snprintf(address, sizeof address, "http://%s/%s/", at, http->secret);
    if (puts(address) < 0 || fflush(stdout))
        return false;
    if (!path)
        sc_browser_open(address, http->page_file);
    sc_info(ctx,
            "the desk is at this address%s; from another machine: ssh -L %d:%s %s, and then "
            "the same address there. Ctrl-C ends it",
            path ? ", once a tunnel leads to its socket, which only you can use" : "", http->port,
            path ? (whole ? whole : path) : at, name);
    return true;
}
