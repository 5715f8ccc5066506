/* SPDX-License-Identifier: BSD-3-Clause */
/* The panels of a session: one for a job; one for each shot; or for a comparison those of the
 * subjects, which have one camera, framed on all of them, one light and the same clip planes and
 * verbs. What is written below the pictures of subjects, and over the whole of them, has panels of
 * its own, too, which draw nothing else. */
#include "panels.h"

/* Give a panel the volumes that it shows. @param count of them, the first of which is @p input. */
static void show(sc_session *session, int input, int count, sc_panel *panel)
{
    panel->inputs = session->inputs;
    panel->input = input;
    panel->phases = count;
    panel->give_up = session->give_up;
    panel->volume = session->inputs->all[input].volume;
}

/* ---- one, and shots ---- */

/* Leave out of a title card what belongs to a volume. */
static void strip_card(sc_job *job)
{
    sc_overlays *o = &job->overlays;

    o->scale_bar = o->color_bar = o->orientation = o->legend = SC_PLACE_NONE;
    job->overlay_lists.tissue_count = 0;
    job->output.layout = SC_LAYOUT_PICTURE;
}

/* @return the number of frames of the cross-fade with which a shot begins; 0: it does otherwise. */
static int cross_fade_frames(const sc_shot *shot)
{
    return shot->span.transition == SC_TRANSITION_CROSS_FADE ? shot->span.transition_frames : 0;
}

/* Begin the panel of a job or of one shot, NULL: there are none. */
static void begin_shot(sc_session *session, const sc_shot *shot, sc_panel *out)
{
    const sc_job *film = &session->job;

    *out =
        (sc_panel){.job = shot ? shot->job : *film, .shot = shot, .group = {out, 1, 0, NULL, NULL}};
    show(session, 0, session->inputs->count, out);
    if (!shot)
        return;
    /* The command may have changed what holds for the whole film. */
    out->job.output = film->output;
    out->job.output.layout = shot->job.output.layout;
    out->job.farm = film->farm;
    out->job.render.cpu = film->render.cpu;
    out->job.render.skip = film->render.skip;
    out->nameless[0] = cross_fade_frames(shot) / 2;
    if (shot + 1 < film->film.shots + film->film.shot_count)
        out->nameless[1] = (cross_fade_frames(shot + 1) + 1) / 2;
    if (shot->has_card) {
        strip_card(&out->job);
        out->phases = 0;
    }
}

/* ---- subjects ---- */

/* Note what is written below the picture of each subject. */
static void name_subjects(const sc_job *job, sc_compare *c)
{
    const sc_comparison *compare = &job->compare;

    for (int s = 0; s < sc_subject_count(job); s++) {
        const sc_subject *other = s ? &compare->others[s - 1] : NULL;
        const char *name = other && other->has_name      ? other->name
                           : !other && compare->has_name ? compare->name
                                                         : NULL;
        sc_caption *caption = &c->captions[s];

        *caption =
            (sc_caption){.end = SC_CAPTION_STAYS, .place = SC_PLACE_BOTTOM, .may_be_cut = true};
        if (compare->has_divider)
            caption->place = s ? SC_PLACE_BOTTOM_RIGHT : SC_PLACE_BOTTOM_LEFT;
        if (name)
            strcpy(caption->text, name);
        else
            sc_name_of_file(other ? other->volume : job->volume.path, caption->text);
        strcpy(caption->where, other ? other->where : compare->where);
    }
}

/* Leave out of a job what is written onto pictures, and the layout, which is that of the whole. */
static void strip(sc_job *job)
{
    sc_overlays *o = &job->overlays;

    o->time = o->scale_bar = o->color_bar = o->orientation = o->legend = SC_PLACE_NONE;
    o->logo[0] = '\0';
    job->overlay_lists.caption_count = job->overlay_lists.tissue_count = 0;
    job->output.layout = SC_LAYOUT_PICTURE;
}

/* Begin the panel of a subject, which draws its picture, and the names of its tissues. */
static void begin_subject(sc_session *session, int s, sc_viewport space, sc_panel *out)
{
    *out = (sc_panel){.place = {.space = space, .is_divided = session->job.compare.has_divider}};
    sc_job_of_input(&session->job, s, &out->job);
    strip(&out->job);
    out->job.overlay_lists.tissue_count = session->job.overlay_lists.tissue_count;
    out->job.overlay_lists.tissues = session->job.overlay_lists.tissues;
    sc_job_keep_tissues(&out->job, SC_USE_NAMES);
    out->job.output.size_px[0] = space.width_px;
    out->job.output.size_px[1] = space.height_px;
    show(session, s, 1, out);
}

/* Begin the panel that writes below the picture of subject @p s. The font keeps its size in pixels,
 * which would follow the height of the part in which it writes. */
static void begin_plate(const sc_session *session, int s, const sc_places *places, sc_panel *out)
{
    *out = (sc_panel){.job = session->job,
                      .place = {.space = places->panels[s], .within = places->panels[s]}};
    strip(&out->job);
    out->place.within.height_px += places->below_px;
    out->job.overlays.text_percent = 100 * places->text_px / out->place.within.height_px;
    out->job.overlay_lists.captions = &session->compare->captions[s];
    out->job.overlay_lists.caption_count = 1;
}

/* Begin the panel that writes over the whole picture, but for the lowest row of names. */
static void begin_front(const sc_session *session, const sc_places *places, sc_panel *out)
{
    const int *size_px = session->job.output.size_px;

    *out = (sc_panel){.job = session->job,
                      .place = {.space = places->panels[0],
                                .within = {0, 0, size_px[0], size_px[1] - places->below_px}}};
    out->job.output.layout = SC_LAYOUT_PICTURE;
    out->job.overlays.text_percent *= (double)size_px[1] / out->place.within.height_px;
    out->job.overlays.logo_percent *= (double)size_px[1] / out->place.within.height_px;
    sc_job_keep_tissues(&out->job, SC_USE_LEGEND);
}

/* Begin the panels of a comparison. */
static void begin_subjects(sc_session *session)
{
    const sc_job *job = &session->job;
    const int count = sc_subject_count(job);
    sc_panel *all = session->panels;
    sc_places places;

    name_subjects(job, session->compare);
    sc_place_subjects(job, session->compare->captions, job->output.size_px, &places);
    for (int s = 0; s < count; s++) {
        begin_subject(session, s, places.panels[s], &all[s]);
        begin_plate(session, s, &places, &all[count + s]);
    }
    begin_front(session, &places, &all[2 * count]);
    for (int i = 0; i <= 2 * count; i++)
        all[i].group = (sc_panel_group){all, count, i < count ? i : -1, NULL, &all[2 * count]};
}

const char *sc_subject_name(const sc_session *session, int i)
{
    return session->compare->captions[i].text;
}

/* Tell which tissues a subject lacks, or how many if they are many. */
static sc_status tell_lacking(const sc_ctx *ctx, const sc_session *session, int s)
{
    enum { MOST = 6 };
    const sc_compare *c = session->compare;
    const sc_prepared *v = &session->panels[s].volume;
    const int added = c->joined[s].added;
    SC_OWN(sc_text_clear) sc_text text = {0};

    for (int i = 0; i < added && i < MOST; i++) {
        const sc_label *label = &v->labels[v->label_count - added + i];

        SC_PASS(sc_text_add(ctx, &text, "%s", i ? ", " : ""));
        if (label->name[0])
            SC_PASS(sc_text_add(ctx, &text, "\"%s\"", label->name));
        else
            SC_PASS(sc_text_add(ctx, &text, "label %lld", (long long)label->value));
    }
    if (added > MOST)
        SC_PASS(sc_text_add(ctx, &text, " and %d more", added - MOST));
    if (added)
        sc_info(ctx, "compare: \"%s\" lacks tissues that others have: %s", c->captions[s].text,
                text.data);
    return SC_OK;
}

/* Bring the subjects together. */
static sc_status join_subjects(sc_app *app, sc_session *session)
{
    const int count = sc_subject_count(&session->job);
    sc_joined *joined = session->compare->joined;
    sc_status status = SC_OK;

    SC_PASS(sc_comm_agree(app->comm, sc_join_labels(app->ctx, session->panels, count, joined)));
    for (int s = 0; s < count && sc_comm_rank(app->comm) == 0 && status == SC_OK; s++)
        status = tell_lacking(app->ctx, session, s);
    SC_PASS(sc_comm_agree(app->comm, status));
    return sc_align_subjects(app, session->panels, count, joined);
}

/* ---- all of them ---- */

/* Make room for the panels of a session. */
static sc_status make_room(const sc_ctx *ctx, sc_session *session)
{
    const sc_job *job = &session->job;
    const int shots = (int)job->film.shot_count, subjects = sc_subject_count(job);
    const size_t count = (size_t)(shots ? shots : subjects > 1 ? 2 * subjects + 1 : 1);

    if (subjects > 1)
        SC_PASS(SC_ZALLOC(ctx, 1, &session->compare));
    if (shots)
        SC_PASS(SC_ALLOC(ctx, count, &session->spans));
    SC_PASS(SC_ZALLOC(ctx, count, &session->panels));
    session->panel_count = (int)count;
    return SC_OK;
}

sc_status sc_session_panels(sc_app *app, sc_session *session)
{
    const sc_job *job = &session->job;

    SC_PASS(sc_comm_agree(app->comm, make_room(app->ctx, session)));
    if (sc_comm_rank(app->comm) == 0)
        sc_mixer_init(&session->mixer);
    sc_comm_broadcast(app->comm, &session->mixer, sizeof session->mixer);
    if (session->compare) {
        begin_subjects(session);
        return join_subjects(app, session);
    }
    for (int i = 0; i < session->panel_count; i++)
        begin_shot(session, job->film.shot_count ? &job->film.shots[i] : NULL, &session->panels[i]);
    for (int i = 0; i < (int)job->film.shot_count; i++)
        session->spans[i] = job->film.shots[i].span;
    return SC_OK;
}

/* Free what a panel owns. On this rank alone. */
static void clear(sc_panel *panel)
{
    if (!panel->borrows_renderers) {
        for (int i = panel->phases - 1; panel->renderers && i >= 0; i--)
            sc_renderer_free(panel->renderers[i]); /* the first lends to the others */
        sc_free(panel->renderers);
    }
    if (panel->phases) /* what only writes borrows them */
        sc_free(panel->looks.tissues);
    sc_free(panel->looks.fades);
    sc_scene_room_clear(&panel->room);
    sc_free(panel->looks.color_tones);
    sc_free(panel->looks.column_values);
    sc_free(panel->looks.shifts);
    sc_free(panel->ways);
    sc_free(panel->text.lettering);
    sc_free(panel->text.names);
    sc_image_clear(&panel->text.logo);
}

void sc_panels_free(sc_session *session)
{
    const int count = session->panel_count;

    for (int i = 0; i < count; i++)
        clear(&session->panels[i]); /* those that lend renderers do not use them any more */
    for (int i = 0; i < count; i++) {
        sc_panorama_clear(&session->panels[i].environment);
        sc_shared_free(session->panels[i].grey.codes);
    }
    for (int s = 0; session->compare && s < SC_SUBJECTS_MAX; s++)
        sc_joined_clear(&session->compare->joined[s]);
    if (session->compare)
        sc_free(session->compare->stats);
    sc_free(session->compare);
    sc_free(session->spans);
    sc_free(session->panels);
}
