/* SPDX-License-Identifier: BSD-3-Clause */
/* The session of the job as it is now. The volumes, and the renderers where nothing has changed
 * that they depend on, are kept from one change to the next. */
#include "desk.h"

sc_job_sources sc_desk_sources(const sc_desk *desk, const sc_edits *edits, sc_setting *settings)
{
    for (size_t i = 0; i < edits->count; i++)
        settings[i] = (sc_setting){
            .origin = edits->all[i].path, .path = edits->all[i].path, .value = edits->all[i].value};
    return (sc_job_sources){.path = desk->file.path,
                            .text = desk->plan->text,
                            .settings = settings,
                            .setting_count = edits->count,
                            .environment = desk->app.environment,
                            .no_video = true,
                            .check_inputs = true};
}

sc_status sc_desk_read(sc_desk *desk, const sc_edits *edits, sc_job *out)
{
    SC_OWN(sc_free_at) sc_setting *settings = NULL;
    sc_job_sources sources;

    SC_PASS(SC_ALLOC(&desk->ctx, edits->count + 1, &settings));
    sources = sc_desk_sources(desk, edits, settings);
    return sc_job_load(&desk->ctx, &sources, out);
}

/* Begin a session with the job of these edits at the size of the picture, on all ranks. */
static sc_status begin(sc_desk *desk, const sc_edits *edits, sc_session *out)
{
    const bool first = sc_comm_rank(desk->app.comm) == 0;

    *out = (sc_session){.times = {.threads = desk->app.threads}, .give_up = desk->interrupt};
    SC_PASS(sc_comm_agree(desk->app.comm, first ? sc_desk_read(desk, edits, &out->job) : SC_OK));
    memcpy(desk->size_px, out->job.output.size_px, sizeof desk->size_px);
    if (desk->shown.size_px[0])
        memcpy(out->job.output.size_px, desk->shown.size_px, sizeof desk->shown.size_px);
    return sc_job_share(&desk->app, &out->job);
}

/* Free a session at the address of its pointer. For SC_OWN. */
static void free_session(sc_session **session)
{
    if (*session)
        sc_session_clear(*session);
    sc_free(*session);
}

/* @return whether some panel of a session has made a renderer, and another has borrowed one from
 * the lender. */
static bool is_mixed(const sc_session *session)
{
    bool owns = false, borrows = false;

    for (int i = 0; i < session->panel_count; i++) {
        const sc_panel *panel = &session->panels[i];
        bool own = false;

        for (int j = 0; j < i; j++)
            own = own || session->panels[j].renderers == panel->renderers;
        owns = owns || (panel->renderers && !panel->borrows_renderers);
        borrows = borrows || (panel->borrows_renderers && !own);
    }
    return owns && borrows;
}

/* Let @p next be the session. It owns the volumes from now on if it has made renderers of its own.
 */
static void replace(sc_desk *desk, sc_session *next)
{
    if (desk->sessions.now != desk->sessions.base)
        free_session(&desk->sessions.now);
    desk->sessions.now = next;
    if (!next->lender || !sc_session_renderer(next, 0))
        return;
    sc_session_move_inputs(desk->sessions.base, next);
    next->lender = NULL;
    free_session(&desk->sessions.base);
    desk->sessions.base = next;
}

/* Make the session of the edits with the volumes of the base. @param borrows renderers, too. */
static sc_status make(sc_desk *desk, const sc_edits *edits, bool borrows, sc_session **out)
{
    SC_OWN(free_session) sc_session *next = NULL;
    const int panels = desk->sessions.base ? desk->sessions.base->panel_count : 0;
    sc_status status = SC_OK;

    SC_PASS(sc_comm_agree(desk->app.comm, SC_ZALLOC(&desk->ctx, 1, &next)));
    SC_PASS(begin(desk, edits, next));
    next->lender = desk->sessions.base;
    if (desk->sessions.base)
        status = sc_inputs_fit(&desk->app, desk->sessions.base->inputs, &desk->volumes.prepared,
                               &next->job, &desk->volumes.fit);
    SC_PASS(sc_comm_agree(desk->app.comm, status));
    if (desk->sessions.base && !borrows)
        desk->sessions.base->panel_count = 0;
    status = sc_session_volume(&desk->app, next);
    if (desk->sessions.base)
        desk->sessions.base->panel_count = panels;
    SC_PASS(status);
    *out = next;
    next = NULL;
    return SC_OK;
}

/* Note that the volumes are prepared as the job of @p edits asks. */
static sc_status note_prepared(sc_desk *desk, const sc_edits *edits)
{
    sc_session session = {0};

    SC_PASS(begin(desk, edits, &session));
    sc_job_clear(&desk->volumes.prepared);
    desk->volumes.prepared = session.job;
    desk->volumes.fit = true;
    return SC_OK;
}

/* As sc_desk_follow, when it was ordered. */
static sc_status follow(sc_desk *desk, const sc_edits *edits)
{
    sc_session *next = NULL;

    json_array_clear(desk->notes.list);
    desk->notes.errors = 0;
    SC_PASS(make(desk, edits, true, &next));
    if (desk->sessions.base && is_mixed(next)) {
        free_session(&next);
        SC_PASS(make(desk, edits, false, &next));
    }
    if (!desk->sessions.base) {
        desk->sessions.base = next;
        SC_PASS(note_prepared(desk, edits));
    }
    replace(desk, next);
    desk->sessions.is_nudged = false;
    desk->sessions.is_lit = next->job.light.constant.method < SC_LIGHT_GLOBAL;
    if (desk->frame >= next->job.animation.frames)
        desk->frame = next->job.animation.frames - 1;
    return SC_OK;
}

sc_status sc_desk_follow(sc_desk *desk, const sc_edits *edits)
{
    sc_desk_tell(desk, &(sc_order){.what = SC_ORDER_FOLLOW});
    return follow(desk, edits);
}

/* Free the sessions of a desk. */
static void free_sessions(sc_session *base, sc_session *now)
{
    if (now != base)
        free_session(&now);
    free_session(&base);
}

sc_status sc_desk_reload(sc_desk *desk)
{
    sc_session *base = desk->sessions.base, *now = desk->sessions.now;
    sc_status status;

    sc_desk_tell(desk, &(sc_order){.what = SC_ORDER_RELOAD});
    desk->sessions.base = desk->sessions.now = NULL;
    status = follow(desk, &desk->steps.now);
    if (status == SC_OK) {
        free_sessions(base, now);
    } else {
        free_sessions(desk->sessions.base, desk->sessions.now);
        desk->sessions.base = base;
        desk->sessions.now = now;
    }
    return status;
}

void sc_desk_close(sc_desk *desk)
{
    sc_job_clear(&desk->volumes.prepared);
    free_sessions(desk->sessions.base, desk->sessions.now);
    desk->sessions.base = desk->sessions.now = NULL;
}
