/* SPDX-License-Identifier: BSD-3-Clause */
/* Which phases of a series are in the memory of a rank. Where they are held in files, of which each
 * rank maps all, only those count from which frames are being drawn: what was read of a phase
 * leaves the memory of the rank when others are drawn, and the system begins to fetch the next one.
 * No rank waits for another: each tells the system what itself needs. */
#include "phases.h"

int sc_session_phase_count(const sc_session *session)
{
    return session->phases ? session->phases->count + 1 : 1;
}

const sc_prepared *sc_session_phase_volume(const sc_session *session, int phase)
{
    return phase ? &session->phases->all[phase - 1].volume : &session->volume;
}

sc_renderer *sc_session_phase_renderer(const sc_session *session, int phase)
{
    if (phase == 0)
        return session->renderer;
    return session->phase_renderers ? session->phase_renderers[phase - 1] : NULL;
}

int sc_session_phase_at(const sc_session *session, int k)
{
    const int first = session->shot ? session->shot->span.first : 0;
    const sc_job *job = &session->job;

    return session->phases ? sc_cine_phase(&job->cine.cine, sc_session_phase_count(session),
                                           job->output.fps, first + k)
                           : 0;
}

/* Tell the system what becomes of the volume of a phase, and of what @p renderer, unless it is
 * NULL, has derived from it. */
static void advise(const sc_phases *phases, int phase, sc_renderer *renderer, sc_memory_use use)
{
    const sc_session *one = phase ? &phases->all[phase - 1] : NULL;
    sc_shared *shared = one ? one->shared : phases->first_shared;

    if (shared)
        sc_shared_advise(shared, use);
    if (one)
        sc_file_advise(one->mapped, one->mapped_bytes, use);
    else
        sc_file_advise(phases->first_mapped, phases->first_mapped_bytes, use);
    if (renderer)
        sc_renderer_advise(renderer, use);
}

void sc_session_unload_phase(const sc_session *session, int phase)
{
    if (session->phases)
        advise(session->phases, phase, sc_session_phase_renderer(session, phase),
               SC_MEMORY_NOT_NEEDED);
}

/* Note that a frame is drawn from a phase: what has not been used for longest is unloaded. */
static void load(sc_phases *phases, int phase, sc_renderer *renderer)
{
    sc_loaded_phase *loaded = phases->loaded, out;
    int at = 0;

    while (at < SC_PHASES_LOADED - 1 && loaded[at].renderer != renderer && loaded[at].renderer)
        at++;
    out = loaded[at];
    for (; at > 0; at--)
        loaded[at] = loaded[at - 1];
    loaded[0] = (sc_loaded_phase){renderer, phase};
    if (out.renderer && out.renderer != renderer)
        advise(phases, out.phase, out.renderer, SC_MEMORY_NOT_NEEDED);
}

sc_renderer *sc_session_begin_frame(const sc_session *session, int k)
{
    const int phase = sc_session_phase_at(session, k), next = sc_session_phase_at(session, k + 1);
    sc_renderer *renderer = sc_session_phase_renderer(session, phase);
    sc_phases *phases = session->phases;

    if (!phases)
        return renderer;
    load(phases, phase, renderer);
    if (next != phase) /* which a rank that draws whole GOPs draws next */
        advise(phases, next, sc_session_phase_renderer(session, next), SC_MEMORY_NEEDED_SOON);
    return renderer;
}

void sc_phases_unload(sc_phases *phases)
{
    if (!phases)
        return;
    for (int i = 0; i < SC_PHASES_LOADED; i++) {
        const sc_loaded_phase out = phases->loaded[i];

        phases->loaded[i] = (sc_loaded_phase){0};
        if (out.renderer)
            advise(phases, out.phase, out.renderer, SC_MEMORY_NOT_NEEDED);
    }
}

double sc_session_loaded_share(const sc_session *session)
{
    const int count = sc_session_phase_count(session);

    return count > SC_PHASES_LOADED && session->phases->in_files ? (double)SC_PHASES_LOADED / count
                                                                 : 1;
}
