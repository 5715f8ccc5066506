/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to desk: what pages ask over HTTP, as calls that one thread answers one after the other.
 */
#ifndef SC_DESK_HTTP_H
#define SC_DESK_HTTP_H

#include "segcast/base.h"

#include <jansson.h>

/* Digits of the secret in the address. */
enum { SC_SECRET_DIGITS = 32 };

/* What a page asks for. Between sc_http_next and sc_http_answer it belongs to the thread that
 * answers, which reads the first two members. */
typedef struct sc_call {
    char verb[24]; /* such as "move" */
    json_t *body;  /* an object: what it is asked with */
    struct sc_http *http;
    struct MHD_Connection *connection;
    struct sc_call *next;
    char *text; /* of the body */
    size_t bytes, room;
    bool is_queued;
    int code; /* of the answer */
    struct MHD_Response *answer;
} sc_call;

/* The server: a thread of its own reads requests, refuses those without the secret, of other pages,
 * or malformed, and queues the others. */
typedef struct sc_http sc_http;

/* How to serve. All borrowed. */
typedef struct sc_http_settings {
    const char *listen;              /* address of this machine, or unix:PATH; NULL: 127.0.0.1 */
    int port;                        /* 0: one that is free */
    const char *page;                /* HTML */
    const sc_stage *stage;           /* whose progress is told while no call can be answered */
    const atomic_int *may_interrupt; /* when this is set, ... */
    atomic_int *interrupt;           /* ... this is set as somebody asks for anything but news */
} sc_http_settings;

/* Begin to serve. @return SC_ERR_CREATE, logged, if the port is in use or the address not of this
 * machine; SC_ERR_SYSTEM, SC_ERR_MEMORY. Caller owns *out: sc_http_stop. */
sc_status sc_http_start(const sc_ctx *ctx, const sc_http_settings *settings, sc_http **out);
/* End: all calls that were not answered are. NULL is allowed. */
void sc_http_stop(sc_http *http);
SC_CLOSE_AT(sc_http_stop, sc_http)
/* Print the address to standard output, tell how to reach it from another machine, and open the
 * browser. @return false if it cannot be printed, which is told when the program ends. */
bool sc_http_print_address(sc_http *http, const sc_ctx *ctx);
/* @return the seconds since a page has asked for something but news. */
double sc_http_idle_s(const sc_http *http);

/* @return the next call, waiting at most @p wait_s, less than a second, for one; NULL: none. */
sc_call *sc_http_next(sc_http *http, double wait_s);
/* @return whether a call waits that asks for something but news. */
bool sc_http_waits(sc_http *http);
/* Answer with @p data, of malloc, which is freed. @param code of HTTP. @param type such as
 * "image/png". @param view one line of JSON that goes with it as a header; NULL: none. */
void sc_http_answer(sc_call *call, int code, const char *type, void *data, size_t bytes,
                    const char *view);
/* Answer with JSON, whose reference is taken; NULL: there was no memory. */
void sc_http_answer_json(sc_call *call, int code, json_t *json);

#endif
