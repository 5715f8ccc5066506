/* SPDX-License-Identifier: BSD-3-Clause */
/* Verbs as the key frames that they stand for. A verb stays as it is where key frames cannot say
 * the same, or would be rounded otherwise: the frames must be the same to the last bit. */
#include "panels.h"

/* Append a change by @p by to a track, of a value that was @p from before the first. @return false,
 * nothing appended, if it overlaps with the one before, is done at once, finds no room, or if the
 * sum is rounded. */
static bool add_ramp(double from, double by, double begin, double end, sc_ease ease,
                     sc_track *track)
{
    const sc_key_frame *last = track->count ? &track->keys[track->count - 1] : NULL;
    const double value = last ? last->value.x : from;

    if (!(begin < end) || (last && begin < last->at) || value + by - value != by ||
        track->count + 2 > SC_KEY_FRAMES_MAX)
        return false;
    if (!last || begin > last->at)
        track->keys[track->count++] = (sc_key_frame){.at = begin, .value = {value, 0, 0}};
    track->keys[track->count++] =
        (sc_key_frame){.at = end, .ease = ease, .value = {value + by, 0, 0}};
    return true;
}

/* Remove verbs from a job. @param kinds a bit for each sc_verb_kind that goes. */
static void drop_verbs(sc_job *job, unsigned kinds)
{
    int numbers[SC_VERBS_MAX];
    size_t verbs = 0, tissues = 0;

    for (size_t v = 0; v < job->verbs.count; v++) {
        numbers[v] = kinds >> job->verbs.list[v].kind & 1u ? -1 : (int)verbs;
        if (numbers[v] >= 0)
            job->verbs.list[verbs++] = job->verbs.list[v];
    }
    for (size_t i = 0; i < job->verbs.tissue_count; i++) {
        sc_named_tissue tissue = job->verbs.tissues[i];

        tissue.of = numbers[tissue.of];
        if (tissue.of >= 0)
            job->verbs.tissues[tissues++] = tissue;
    }
    job->verbs.count = verbs;
    job->verbs.tissue_count = tissues;
}

/* Let key frames of angle and elevation replace the verbs orbit of a job. Of an angle no more than
 * two numbers may be added up, because the sum of more depends on their order. */
static void expand_orbits(sc_job *job)
{
    sc_orbit *camera = &job->animation.camera;
    sc_track angle = {0}, elevation = {0};
    int summands = (camera->turns != 0) + (camera->angle_deg != 0);

    if (camera->fixed || camera->tracks.angle.count || camera->tracks.elevation.count)
        return;
    for (size_t v = 0; v < job->verbs.count; v++) {
        const sc_verb *verb = &job->verbs.list[v];

        if (verb->kind == SC_VERB_ROCK)
            return;
        if (verb->kind != SC_VERB_ORBIT)
            continue;
        summands += verb->angle_deg != 0;
        if (summands > 2 || !add_ramp(camera->angle_deg, verb->angle_deg, verb->begin, verb->end,
                                      verb->ease, &angle))
            return;
        if (verb->elevation_deg != 0 && !add_ramp(camera->elevation_deg, verb->elevation_deg,
                                                  verb->begin, verb->end, verb->ease, &elevation))
            return;
    }
    camera->tracks.angle = angle;
    camera->tracks.elevation = elevation;
    drop_verbs(job, 1u << SC_VERB_ORBIT);
}

/* Append the key frames of a pulse: one ramp down and one up for each repetition. @return as
 * add_ramp; false also for an ease whose way back differs from its way there. */
static bool add_pulse(const sc_change *f, sc_track *track)
{
    const double half = (f->end - f->begin) / (2 * f->times);
    bool done = f->ease.kind == SC_EASE_LINEAR || f->ease.kind == SC_EASE_SMOOTH;

    for (int i = 0; i < 2 * f->times && done; i++)
        done = add_ramp(1, i % 2 ? 1 - f->to.x : f->to.x - 1, f->begin + i * half,
                        i + 1 < 2 * f->times ? f->begin + (i + 1) * half : f->end, f->ease, track);
    return done;
}

/* Find the key frames of the opacities of tissues that the verbs of a panel change, all of which
 * have the opacity 1. @param tracks [fade_count], zeroed: one for each tissue, in their order.
 * @return whether all can be found. */
static bool find_opacities(const sc_panel *panel, sc_track *tracks)
{
    for (size_t i = 0; i < panel->looks.fade_count; i++) {
        const sc_change *f = &panel->looks.fades[i];
        const sc_tissue *t = &panel->looks.tissues[f->id];
        const double first = f->kind == SC_VERB_APPEAR ? 0 : 1;
        const bool is_pulse = f->kind == SC_VERB_PULSE;

        tracks += i && f->id != f[-1].id;
        if ((i && f->id == f[-1].id && (is_pulse || f[-1].kind == SC_VERB_PULSE)) || f->to.x > 1 ||
            t->opacity_auto || t->opacity != 1 || t->interior_opacity != 0 || t->opacity_track ||
            panel->volume.labels[f->id].value < 0 ||
            !(is_pulse ? add_pulse(f, tracks)
                       : add_ramp(first,
                                  f->to.x - (tracks->count ? tracks->keys[tracks->count - 1].value.x
                                                           : first),
                                  f->begin, f->end, f->ease, tracks)))
            return false;
    }
    return true;
}

/* Let key frames of the opacity of each tissue replace the verbs of a job that change it. @param
 * panel of that job. */
static sc_status expand_fades(const sc_ctx *ctx, const sc_panel *panel, sc_job *job)
{
    const size_t count = panel->looks.fade_count;
    SC_OWN(sc_free_at) sc_track *tracks = NULL;

    SC_PASS(SC_ZALLOC(ctx, count, &tracks));
    if (!count || !find_opacities(panel, tracks))
        return SC_OK;
    SC_PASS(SC_RESIZE(ctx, job->tissues.rule_count, job->tissues.rule_count + count,
                      &job->tissues.rules));
    SC_PASS(SC_RESIZE(ctx, job->tissues.track_count, job->tissues.track_count + count,
                      &job->tissues.tracks));
    for (size_t i = 0, at = 0; i < count; i++) {
        const int id = panel->looks.fades[i].id;
        sc_tissue_rule rule = {.has.opacity = true, .opacity = 1};

        if (i && id == panel->looks.fades[i - 1].id)
            continue;
        snprintf(rule.pattern, sizeof rule.pattern, "%lld",
                 (long long)panel->volume.labels[id].value);
        job->tissues.tracks[job->tissues.track_count++] = tracks[at++];
        rule.opacity_track = (int)job->tissues.track_count;
        job->tissues.rules[job->tissues.rule_count++] = rule;
    }
    drop_verbs(job, 1u << SC_VERB_FADE | 1u << SC_VERB_APPEAR | 1u << SC_VERB_PULSE);
    return SC_OK;
}

sc_status sc_session_expand(const sc_ctx *ctx, sc_session *session)
{
    sc_job *film = &session->job;
    const int count = film->film.shot_count ? session->panel_count : 1;

    for (int i = 0; i < count; i++) {
        sc_job *job = film->film.shot_count ? &film->film.shots[i].job : film;

        expand_orbits(job);
        if (!session->compare) /* whose volumes may have different tissues */
            SC_PASS(expand_fades(ctx, &session->panels[i], job));
    }
    return SC_OK;
}
