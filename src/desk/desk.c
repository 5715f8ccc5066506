/* SPDX-License-Identifier: BSD-3-Clause */
/* The thread that answers calls, one after the other. Calls that ask for news wait until there are
 * some; the picture is refined when nothing else is asked for. */
#include "desk.h"

#include "segcast/page.h"

#include <stdlib.h>
#include <unistd.h>

#define NEWS_MAX_S 20.0 /* so long a call waits; then it is answered, and the page asks again */
#define WAKE_S 0.04     /* it is looked so often whether those that wait can be answered */
#define REST_S 0.12 /* after the last change the picture is refined, if none follows meanwhile */

/* ---- what pages do ---- */

/* Show pictures of the size that a call asks for. @return false if it names none, or there is no
 * picture of that size. */
static bool resize(sc_desk *desk, sc_call *call)
{
    const sc_shown before = desk->shown;
    int size_px[2];

    if (!sc_desk_size(call->body, size_px))
        return false;
    if (!memcmp(size_px, desk->shown.size_px, sizeof size_px))
        return true;
    memcpy(desk->shown.size_px, size_px, sizeof size_px);
    if (sc_desk_follow(desk, &desk->steps.now) == SC_OK)
        return true;
    desk->shown = before;
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
    if (!strcmp(path, "light.environment"))
        return false;
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
static bool change(sc_desk *desk, sc_call *call)
{
    const json_t *body = call->body;
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
    desk->volumes.failed = false;
    desk->changed_s = sc_wall_s();
    return true;
}

/* A change whose picture is wanted at once. */
static void do_move(sc_desk *desk, sc_call *call)
{
    if (!resize(desk, call))
        sc_desk_refuse(desk, call, "there is no picture of this size");
    else if (change(desk, call))
        sc_desk_sketch(desk, call);
}

/* Go to the job as it was before a step, or after it. @return as change. */
static bool step(sc_desk *desk, sc_call *call)
{
    const bool back = !strcmp(call->verb, "undo");

    if (!sc_steps_go(&desk->steps, back))
        return true;
    if (sc_desk_follow(desk, &desk->steps.now) != SC_OK) {
        (void)sc_steps_go(&desk->steps, !back);
        sc_desk_refuse(desk, call, "the step could not be made");
        return false;
    }
    desk->revision++;
    desk->volumes.failed = false;
    desk->changed_s = sc_wall_s();
    return true;
}

static void do_edit(sc_desk *desk, sc_call *call)
{
    if (!strcmp(call->verb, "edit") ? change(desk, call) : step(desk, call))
        sc_http_answer_json(call, 200, json_pack("{s:i}", "revision", (int)desk->revision));
}

/* ---- calls ---- */

/* @return whether a call wants what is newer than what it has. */
static bool wants(const sc_desk *desk, const sc_call *call)
{
    const json_t *after = json_object_get(call->body, "after");

    return !json_is_integer(after) || json_integer_value(after) != desk->revision;
}

/* Let a call wait for news. */
static void wait_for_news(sc_desk *desk, sc_call *call)
{
    if (desk->waits.count == SC_WAITING_MAX) {
        sc_http_answer(call, 503, "text/plain", NULL, 0, NULL);
        return;
    }
    desk->waits.all[desk->waits.count++] = (sc_waiting){call, sc_wall_s()};
}

static void take(sc_desk *desk, sc_call *call)
{
    static const struct {
        const char *verb;
        void (*answer)(sc_desk *, sc_call *);
    } verbs[] = {
        {"move", do_move},       {"edit", do_edit},          {"undo", do_edit},
        {"redo", do_edit},       {"pick", sc_desk_pick},     {"slice", sc_desk_slice},
        {"save", sc_desk_save},  {"render", sc_desk_render}, {"rendering", sc_desk_rendering},
        {"film", sc_desk_film},  {"picture", wait_for_news}, {"sheet", wait_for_news},
        {"state", wait_for_news}};

    for (size_t i = 0; i < SC_COUNT_OF(verbs); i++) {
        if (!strcmp(verbs[i].verb, call->verb)) {
            if (verbs[i].answer != do_move && verbs[i].answer != wait_for_news)
                sc_desk_settle(desk);
            verbs[i].answer(desk, call);
            return;
        }
    }
    sc_http_answer(call, 404, "text/plain", NULL, 0, NULL);
}

/* Answer a call that waits, if there are news for it. @return whether it is answered. */
static bool tell_news(sc_desk *desk, const sc_waiting *w)
{
    const char *verb = w->call->verb;
    const bool rests = sc_wall_s() - desk->changed_s >= REST_S;

    if (rests)
        sc_desk_settle(desk);
    if (rests && wants(desk, w->call)) {
        if (!strcmp(verb, "state")) {
            sc_http_answer_json(w->call, 200, sc_desk_state(desk));
            return true;
        }
        if (!resize(desk, w->call)) {
            sc_desk_refuse(desk, w->call, "there is no picture of this size");
            return true;
        }
        return sc_desk_refine(desk, w->call);
    }
    if (sc_wall_s() - w->since_s < NEWS_MAX_S)
        return false;
    sc_http_answer(w->call, 204, "text/plain", NULL, 0, NULL);
    return true;
}

/* Answer those that wait, as far as there are news, until something else is asked for. */
static void tell_all(sc_desk *desk)
{
    for (int i = 0; i < desk->waits.count && !sc_http_waits(desk->http);) {
        if (tell_news(desk, &desk->waits.all[i]))
            desk->waits.all[i] = desk->waits.all[--desk->waits.count];
        else
            i++;
    }
}

/* ---- beginning and end ---- */

/* Answer calls until it is to end. */
static void serve(sc_desk *desk, const atomic_int *stop)
{
    const double idle_s = 60.0 * desk->plan->idle_min;

    while (!*stop && !sc_desk_is_asked_to_stop(desk) &&
           !(idle_s > 0 && sc_http_idle_s(desk->http) > idle_s)) {
        sc_call *call = sc_http_next(desk->http, WAKE_S);

        for (; call; call = sc_http_next(desk->http, 0))
            take(desk, call);
        if (sc_wall_s() - desk->changed_s > REST_S)
            sc_desk_begin_preparing(desk);
        if (sc_desk_take_prepared(desk))
            desk->revision++;
        tell_all(desk);
    }
    for (int i = 0; i < desk->waits.count; i++)
        sc_http_answer(desk->waits.all[i].call, 503, "text/plain", NULL, 0, NULL);
}

/* Load the job and serve it. */
static sc_status open_and_serve(sc_desk *desk, const atomic_int *stop)
{
    const sc_http_settings settings = {.listen = desk->plan->listen,
                                       .port = desk->plan->port,
                                       .page = sc_desk_html,
                                       .stage = desk->outer->stage,
                                       .may_interrupt = &desk->may_interrupt,
                                       .interrupt = desk->interrupt};
    sc_status status;

    SC_PASS(sc_http_start(desk->outer, &settings, &desk->http));
    if (!sc_http_print_address(desk->http, desk->outer))
        return SC_OK;
    desk->ctx.write = desk->outer->write; /* what is wrong with the job is told at the terminal */
    desk->ctx.user = desk->outer->user;
    sc_signals_expendable(true); /* a large volume takes its time */
    status = sc_desk_follow(desk, &desk->steps.now);
    sc_signals_expendable(false);
    desk->ctx.write = sc_desk_note;
    desk->ctx.user = &desk->notes;
    if (status != SC_OK)
        return status;
    sc_display_end_stage(&desk->app);
    desk->ctx.stage = NULL; /* what follows takes moments */
    desk->revision = 1;
    serve(desk, stop);
    return SC_OK;
}

sc_status sc_desk_serve(sc_app *app, const sc_desk_plan *plan)
{
    const atomic_int *stop = sc_signals_catch_stop();
    sc_desk own = {.app = *app,
                   .ctx = *app->ctx,
                   .outer = app->ctx,
                   .plan = plan,
                   .notes = {.list = json_array()}};
    sc_desk *desk = &own;
    sc_status status;

    desk->app.ctx = &desk->ctx;
    desk->interrupt = sc_signals_give_up();
    (void)setenv("SEGCAST_MPI", "no", 1); /* of films rendered here; before there are threads */
    sc_signals_stop_in_order(true);
    status = sc_comm_agree(app->comm, desk->notes.list ? SC_OK : SC_ERR_MEMORY);
    if (status == SC_OK && sc_comm_rank(app->comm) > 0)
        sc_desk_obey(desk, stop);
    else if (status == SC_OK)
        status = sc_desk_open_file(desk);
    if (status == SC_OK && sc_comm_rank(app->comm) == 0)
        status = open_and_serve(desk, stop);
    sc_desk_tell(desk, &(sc_order){.what = SC_ORDER_END});
    sc_http_stop(desk->http);
    sc_desk_end_rendering(desk);
    sc_desk_drop_preparing(desk);
    sc_desk_close(desk);
    sc_steps_clear(&desk->steps);
    json_decref(desk->notes.list);
    sc_free(desk->file.path);
    sc_free(desk->file.on_disk);
    return status;
}
