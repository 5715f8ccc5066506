/* SPDX-License-Identifier: BSD-3-Clause */
/* Prepares volumes anew beside the thread that answers: a tissue that is hidden becomes background,
 * so that other surfaces are smoothed where it was, which takes seconds. */
#include "desk.h"

#include <pthread.h>

struct sc_preparing {
    pthread_t thread;
    atomic_int is_done;
    sc_desk desk; /* that of the thread: the job that it prepares for, and nothing that is served */
    sc_edits edits;
    sc_comm *alone; /* its communicator where there are other ranks, as only one thread calls MPI */
    sc_status status;
};

/* Body of the thread. */
static void *run(void *user)
{
    struct sc_preparing *p = user;

    p->status = sc_desk_follow(&p->desk, &p->edits);
    p->is_done = 1;
    return NULL;
}

/* Begin the desk of the thread. */
static sc_status begin(const sc_desk *desk, struct sc_preparing *p)
{
    sc_desk *own = &p->desk;

    own->outer = desk->outer;
    own->plan = desk->plan;
    own->shown = desk->shown;
    own->interrupt = desk->interrupt;
    own->ctx = desk->ctx;
    own->ctx.stage = desk->outer->stage;
    own->ctx.user = &own->notes;
    own->app = desk->app;
    own->app.ctx = &own->ctx;
    if (sc_comm_size(desk->app.comm) > 1) {
        SC_PASS(sc_comm_open(&desk->ctx, false, &p->alone));
        own->app.comm = p->alone;
    }
    own->notes.list = json_array();
    SC_PASS(own->notes.list ? SC_OK : SC_ERR_MEMORY);
    SC_PASS(sc_text_copy(&desk->ctx, desk->file.path, &own->file.path));
    return sc_edits_copy(&desk->ctx, &desk->steps.now, &p->edits);
}

/* Free a thread that has ended, or never begun, and what it has prepared. */
static void drop(struct sc_preparing *p)
{
    sc_desk_close(&p->desk);
    sc_edits_clear(&p->edits);
    json_decref(p->desk.notes.list);
    sc_free(p->desk.file.path);
    sc_comm_close(p->alone);
    sc_free(p);
}

/* @return whether what the thread prepares can be taken over: several ranks find it in the cache.
 */
static bool can_adopt(const sc_desk *desk)
{
    SC_OWN(sc_free_at) char *directory = NULL;

    return sc_comm_size(desk->app.comm) == 1 ||
           (sc_kept_directory(&desk->ctx, &directory) == SC_OK && directory);
}

void sc_desk_begin_preparing(sc_desk *desk)
{
    struct sc_preparing *p = NULL;

    if (desk->volumes.fit || desk->volumes.preparing || desk->volumes.failed)
        return;
    if (!can_adopt(desk)) {
        desk->volumes.failed = sc_desk_reload(desk) != SC_OK;
        desk->revision++;
        return;
    }
    desk->volumes.failed = SC_ZALLOC(&desk->ctx, 1, &p) != SC_OK;
    if (desk->volumes.failed)
        return;
    if (begin(desk, p) == SC_OK && !pthread_create(&p->thread, NULL, run, p)) {
        desk->volumes.preparing = p;
    } else {
        drop(p);
        desk->volumes.failed = true;
    }
}

/* Take over what was prepared if it is what the job asks for now: several ranks find it in the
 * cache. @return whether it is. */
static bool adopt(sc_desk *desk, struct sc_preparing *p)
{
    bool fits = false;

    if (sc_inputs_fit(&desk->app, p->desk.sessions.base->inputs, &p->desk.volumes.prepared,
                      &desk->sessions.now->job, &fits) != SC_OK ||
        !fits)
        return false;
    if (p->alone)
        return sc_desk_reload(desk) == SC_OK;
    sc_desk_close(desk);
    desk->sessions.base = desk->sessions.now = p->desk.sessions.base;
    desk->volumes.prepared = p->desk.volumes.prepared;
    desk->volumes.fit = true;
    p->desk.sessions.base = p->desk.sessions.now = NULL;
    p->desk.volumes.prepared = (sc_job){0};
    return true;
}

bool sc_desk_take_prepared(sc_desk *desk)
{
    struct sc_preparing *p = desk->volumes.preparing;
    bool adopted = false;

    if (!p || !p->is_done)
        return false;
    pthread_join(p->thread, NULL);
    desk->volumes.preparing = NULL;
    sc_display_end_stage(&p->desk.app);
    if (p->status == SC_OK)
        adopted = adopt(desk, p);
    else
        json_array_extend(desk->notes.list, p->desk.notes.list);
    desk->volumes.failed = p->status != SC_OK;
    drop(p);
    if (adopted) /* for the camera of now */
        (void)sc_desk_follow(desk, &desk->steps.now);
    return adopted || desk->volumes.failed;
}

void sc_desk_drop_preparing(sc_desk *desk)
{
    if (!desk->volumes.preparing)
        return;
    sc_signals_expendable(true);
    pthread_join(desk->volumes.preparing->thread, NULL);
    sc_signals_expendable(false);
    drop(desk->volumes.preparing);
    desk->volumes.preparing = NULL;
}
