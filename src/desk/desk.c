/* SPDX-License-Identifier: BSD-3-Clause */
/* The thread that answers calls, one after the other. Calls that ask for news wait until there are
 * some; the picture is refined when nothing else is asked for. */
#include "desk.h"

#include "segcast/page.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum {
    WAITING_MAX = 64, /* calls that wait for news: as many pages may look on */
    NEWS_MAX_S = 20   /* so long one waits; then it is answered without, and the page asks again */
};
#define WAKE_S 0.04 /* it is looked so often whether those that wait can be answered */
#define REST_S 0.12 /* after the last change the picture is refined, if none follows meanwhile */

/* A call that waits for news. */
typedef struct waiting {
    sc_call *call;
    double since_s;
} waiting;

/* What the thread that answers has at hand. */
typedef struct clerk {
    sc_desk desk;
    waiting waits[WAITING_MAX];
    int count;
    double changed_s; /* when something was changed for the last time */
} clerk;

/* ---- what pages do ---- */

/* Show pictures of the size that a call asks for. @return false if it names none, or there is no
 * picture of that size. */
static bool resize(sc_desk *desk, sc_call *call)
{
    int before[2], size_px[2];

    if (!sc_desk_size(sc_call_body(call), size_px))
        return false;
    if (!memcmp(size_px, desk->shown.size_px, sizeof size_px))
        return true;
    memcpy(before, desk->shown.size_px, sizeof before);
    memcpy(desk->shown.size_px, size_px, sizeof size_px);
    if (sc_desk_follow(desk, &desk->steps.now) == SC_OK)
        return true;
    memcpy(desk->shown.size_px, before, sizeof before);
    return false;
}

/* @return a value of JSON as YAML, of which JSON is a part; the caller frees it; NULL: no memory.
 */
static char *to_yaml(const json_t *value)
{
    return json_is_string(value) ? strdup(json_string_value(value))
                                 : json_dumps(value, JSON_ENCODE_ANY | JSON_REAL_PRECISION(9));
}

/* @return whether pages may change a key: none that names a file. */
static bool is_open(const char *path)
{
    static const char *const keys[] = {"animation.", "tissues.", "light.",      "render.",
                                       "appearance", "look",     "output.size", "output.fps"};
    int shot, used = 0;

    if (sscanf(path, "shots[%d].%n", &shot, &used) == 1)
        path += used;
    for (size_t i = 0; i < SC_COUNT_OF(keys); i++) {
        if (!strncmp(path, keys[i], strlen(keys[i])))
            return true;
    }
    return false;
}

/* Add the pairs of key and value that a call holds. */
static sc_status add_pairs(const sc_ctx *ctx, const json_t *pairs, sc_edits *edits)
{
    for (size_t i = 0; i < json_array_size(pairs); i++) {
        const json_t *pair = json_array_get(pairs, i);
        const char *path = json_string_value(json_array_get(pair, 0));
        const bool removes = json_is_null(json_array_get(pair, 1));
        char *value = removes ? NULL : to_yaml(json_array_get(pair, 1));
        sc_status status = SC_ERR_DATA;

        if (path && (value || removes) && !is_open(path))
            status = sc_fail(ctx, SC_ERR_USAGE, "\"%s\": pages do not change this key", path);
        else if (path && (value || removes))
            status = sc_edits_add(ctx, edits, path, value);
        free(value);
        if (status != SC_OK)
            return status == SC_ERR_DATA
                       ? sc_fail(ctx, status, "a change is a pair of a key and a value")
                       : status;
    }
    return SC_OK;
}

/* Change the job as a call says. @return false, and the call is answered, if that cannot be. */
static bool change(clerk *c, sc_call *call)
{
    sc_desk *desk = &c->desk;
    const json_t *body = sc_call_body(call);
    const json_t *pairs = json_object_get(body, "edits");
    const char *group = json_string_value(json_object_get(body, "group"));
    SC_OWN(sc_edits_clear) sc_edits next = {0};
    bool done = false;

    desk->frame = sc_desk_frame(desk, body);
    if (json_array_size(pairs)) {
        sc_status status = sc_edits_copy(&desk->ctx, &desk->steps.now, &next);

        json_array_clear(desk->notes.list);
        desk->notes.errors = 0;
        if (status == SC_OK)
            status = add_pairs(&desk->ctx, pairs, &next);
        if (status == SC_OK && group && *group)
            status = sc_desk_nudge(desk, pairs, &next, &done);
        if (status == SC_OK && !done)
            status = sc_desk_follow(desk, &next);
        if (status != SC_OK) {
            sc_desk_refuse(desk, call, "the change could not be made");
            return false;
        }
        sc_steps_begin(&desk->steps, group ? group : "", &next);
    }
    desk->revision++;
    desk->preparing_failed = false;
    c->changed_s = sc_wall_s();
    return true;
}

static void answer_revision(const sc_desk *desk, sc_call *call)
{
    sc_http_answer_json(call, 200, json_pack("{s:i}", "revision", (int)desk->revision));
}

/* A change whose picture is wanted at once. */
static void do_move(clerk *c, sc_call *call)
{
    if (!resize(&c->desk, call))
        sc_desk_refuse(&c->desk, call, "there is no picture of this size");
    else if (change(c, call))
        sc_desk_sketch(&c->desk, call);
}

static void do_edit(clerk *c, sc_call *call)
{
    if (change(c, call))
        answer_revision(&c->desk, call);
}

/* Go to the job as it was before a step, or after it. */
static void do_step(clerk *c, sc_call *call)
{
    const bool back = !strcmp(sc_call_verb(call), "undo");
    sc_desk *desk = &c->desk;

    if (sc_steps_go(&desk->steps, back)) {
        if (sc_desk_follow(desk, &desk->steps.now) != SC_OK) {
            (void)sc_steps_go(&desk->steps, !back);
            sc_desk_refuse(desk, call, "the step could not be made");
            return;
        }
        desk->revision++;
        desk->preparing_failed = false;
        c->changed_s = sc_wall_s();
    }
    answer_revision(desk, call);
}

/* ---- calls ---- */

/* @return whether a call wants what is newer than what it has. */
static bool wants(const clerk *c, const sc_call *call)
{
    const json_t *after = json_object_get(sc_call_body(call), "after");

    return !json_is_integer(after) || json_integer_value(after) != c->desk.revision;
}

/* Let a call wait for news. */
static void wait_for_news(clerk *c, sc_call *call)
{
    if (c->count == WAITING_MAX) {
        sc_http_answer(call, 503, "text/plain", NULL, 0, NULL);
        return;
    }
    c->waits[c->count++] = (waiting){call, sc_wall_s()};
}

static void take(clerk *c, sc_call *call)
{
    static const struct {
        const char *verb;
        void (*answer)(clerk *, sc_call *); /* or: */
        void (*pass)(sc_desk *, sc_call *);
    } verbs[] = {{"move", do_move, NULL},
                 {"edit", do_edit, NULL},
                 {"undo", do_step, NULL},
                 {"redo", do_step, NULL},
                 {"pick", NULL, sc_desk_pick},
                 {"slice", NULL, sc_desk_slice},
                 {"save", NULL, sc_desk_save},
                 {"render", NULL, sc_desk_render},
                 {"rendering", NULL, sc_desk_rendering},
                 {"film", NULL, sc_desk_film},
                 {"picture", wait_for_news, NULL},
                 {"sheet", wait_for_news, NULL},
                 {"state", wait_for_news, NULL}};

    for (size_t i = 0; i < SC_COUNT_OF(verbs); i++) {
        if (!strcmp(verbs[i].verb, sc_call_verb(call))) {
            if (verbs[i].answer != do_move && verbs[i].answer != wait_for_news)
                sc_desk_settle(&c->desk);
            if (verbs[i].answer)
                verbs[i].answer(c, call);
            else
                verbs[i].pass(&c->desk, call);
            return;
        }
    }
    sc_http_answer(call, 404, "text/plain", NULL, 0, NULL);
}

/* Answer a call that waits, if there are news for it. @return whether it is answered. */
static bool tell_news(clerk *c, const waiting *w)
{
    const char *verb = sc_call_verb(w->call);
    const bool rests = sc_wall_s() - c->changed_s >= REST_S;

    if (rests)
        sc_desk_settle(&c->desk);
    if (rests && wants(c, w->call)) {
        if (!strcmp(verb, "state")) {
            sc_http_answer_json(w->call, 200, sc_desk_state(&c->desk));
            return true;
        }
        if (!strcmp(verb, "picture") && !resize(&c->desk, w->call)) {
            sc_desk_refuse(&c->desk, w->call, "there is no picture of this size");
            return true;
        }
        return sc_desk_refine(&c->desk, w->call);
    }
    if (sc_wall_s() - w->since_s < NEWS_MAX_S)
        return false;
    sc_http_answer(w->call, 204, "text/plain", NULL, 0, NULL);
    return true;
}

/* Answer those that wait, as far as there are news, until something else is asked for. */
static void tell_all(clerk *c)
{
    for (int i = 0; i < c->count && !sc_http_waits(c->desk.http);) {
        if (tell_news(c, &c->waits[i]))
            c->waits[i] = c->waits[--c->count];
        else
            i++;
    }
}

/* ---- beginning and end ---- */

/* Answer calls until it is to end. */
static void serve(clerk *c, const atomic_int *stop)
{
    const double idle_s = 60.0 * c->desk.plan->idle_min;

    while (!*stop && !(idle_s > 0 && sc_http_idle_s(c->desk.http) > idle_s)) {
        sc_call *call = sc_http_next(c->desk.http, WAKE_S);

        for (; call; call = sc_http_next(c->desk.http, 0))
            take(c, call);
        if (sc_wall_s() - c->changed_s > REST_S)
            sc_desk_begin_preparing(&c->desk);
        if (sc_desk_take_prepared(&c->desk))
            c->desk.revision++;
        tell_all(c);
    }
    for (int i = 0; i < c->count; i++)
        sc_http_answer(c->waits[i].call, 503, "text/plain", NULL, 0, NULL);
}

/* Load the job and serve it. */
static sc_status open_and_serve(clerk *c, const atomic_int *stop)
{
    sc_desk *desk = &c->desk;
    const sc_http_settings settings = {.listen = desk->plan->listen,
                                       .port = desk->plan->port,
                                       .page = sc_desk_html,
                                       .stage = desk->outer->stage,
                                       .may_interrupt = &desk->may_interrupt,
                                       .interrupt = &desk->interrupt};
    sc_status status;

    SC_PASS(sc_http_start(desk->outer, &settings, &desk->http));
    if (!sc_http_print_address(desk->http, desk->outer))
        return SC_OK;
    desk->ctx.write = desk->outer->write; /* what is wrong with the job is told at the terminal */
    desk->ctx.user = desk->outer->user;
    status = sc_desk_follow(desk, &desk->steps.now);
    desk->ctx.write = sc_desk_note;
    desk->ctx.user = &desk->notes;
    if (status != SC_OK)
        return status;
    sc_display_end_stage(&desk->app);
    desk->ctx.stage = NULL; /* what follows takes moments */
    desk->revision = 1;
    serve(c, stop);
    return SC_OK;
}

sc_status sc_desk_serve(sc_app *app, const sc_desk_plan *plan)
{
    const atomic_int *stop = sc_signals_catch_stop();
    clerk *c = NULL;
    sc_desk *desk;
    sc_status status;

    SC_PASS(SC_ZALLOC(app->ctx, 1, &c));
    desk = &c->desk;
    desk->outer = app->ctx;
    desk->ctx = *app->ctx;
    desk->app = *app;
    desk->app.ctx = &desk->ctx;
    desk->plan = plan;
    desk->give_up = &desk->interrupt;
    desk->notes.list = json_array();
    sc_signals_stop_in_order(true);
    status = desk->notes.list ? sc_desk_open_file(desk)
                              : sc_fail(app->ctx, SC_ERR_MEMORY, "out of memory");
    if (status == SC_OK)
        status = open_and_serve(c, stop);
    sc_http_stop(desk->http);
    sc_desk_drop_preparing(desk);
    sc_desk_close(desk);
    sc_steps_clear(&desk->steps);
    json_decref(desk->notes.list);
    sc_desk_end_rendering(desk);
    sc_free(desk->file.path);
    sc_free(desk->file.on_disk);
    sc_free(c);
    return status;
}
