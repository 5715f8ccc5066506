/* SPDX-License-Identifier: BSD-3-Clause */
/* What is written onto the pictures of a session: made by rank 0, which has the fonts and the
 * files, and sent to all others. */
#include "app.h"

#include "segcast/views.h"

#include <string.h>

sc_annotations sc_session_annotations(const sc_session *session)
{
    const sc_job *job = &session->job;
    const int *size_px = job->output.size_px;
    sc_annotations out = {.overlays = &job->overlays,
                          .captions = job->captions,
                          .caption_count = job->caption_count,
                          .chosen = job->overlay_tissues,
                          .chosen_count = job->overlay_tissue_count,
                          .volume = &session->volume,
                          .tissues = session->tissues,
                          .timeline = &session->timeline,
                          .within = {0, 0, size_px[0], size_px[1]},
                          .fps = job->output.fps,
                          .first_frame = session->shot ? session->shot->span.first : 0,
                          .card = session->shot && session->shot->has_card ? &session->shot->card
                                                                           : NULL,
                          .scale = session->scale.is_used ? &session->scale : NULL,
                          .logo = session->logo,
                          .lettering = session->lettering,
                          .names = session->names,
                          .divided_px = session->is_divided ? size_px[0] : 0,
                          .is_behind_divider = session->subject > 0};

    if (job->output.layout == SC_LAYOUT_VIEWS)
        out.within = sc_views_space(size_px[0], size_px[1]);
    if (session->panel.width_px)
        out.within = out.space = session->panel;
    if (session->within.width_px)
        out.within = session->within;
    return out;
}

/* Send a block of rank 0 to the others: *block becomes a copy there, which they own. @param bytes
 * its length; read on rank 0. Collective. */
static sc_status share_block(sc_app *app, void **block, uint64_t bytes)
{
    sc_comm_broadcast(app->comm, &bytes, sizeof bytes);
    return sc_broadcast_array(app, block, bytes, 1);
}

/* Fill session->logo from the file of the job. Collective. */
static sc_status share_logo(sc_app *app, const sc_annotations *annotations, sc_session *session)
{
    const bool first = sc_comm_rank(app->comm) == 0;
    sc_image *logo = &session->logo;
    void *pixels;
    sc_status status = SC_OK;

    if (first)
        status = sc_annotations_logo(app->ctx, annotations, logo);
    SC_TRY(sc_comm_agree(app->comm, status));
    pixels = logo->rgb;
    sc_comm_broadcast(app->comm, logo, sizeof *logo);
    logo->rgb = pixels; /* that which was received is an address of rank 0 */
    SC_TRY(sc_broadcast_array(app, &pixels, sc_image_bytes(logo), 1));
    logo->rgb = pixels;
out:
    return status;
}

/* Fill session->names. Collective. */
static sc_status share_names(sc_app *app, const sc_annotations *annotations, sc_session *session)
{
    const bool first = sc_comm_rank(app->comm) == 0;
    void *names;
    sc_status status = SC_OK;

    sc_stage_begin(app->ctx, "placing the names", 0, 0);
    if (first)
        status = sc_annotations_plan_names(app->ctx, annotations, app->threads, &session->names);
    SC_TRY(sc_comm_agree(app->comm, status));
    names = session->names;
    SC_TRY(share_block(app, &names, first ? session->names->bytes : 0));
    session->names = names;
out:
    return status;
}

sc_status sc_session_letter(sc_app *app, sc_session *session)
{
    sc_annotations annotations = sc_session_annotations(session), over;
    const bool first = sc_comm_rank(app->comm) == 0;
    void *lettering;
    sc_status status = SC_OK;

    if (!sc_annotations_any(&annotations))
        return SC_OK;
    annotations.told = &app->font_told;
    if (first)
        status = sc_annotations_letter(app->ctx, &annotations, &session->lettering);
    SC_TRY(sc_comm_agree(app->comm, status));
    lettering = session->lettering;
    SC_TRY(share_block(app, &lettering, first ? session->lettering->bytes : 0));
    session->lettering = lettering;
    if (session->job.overlays.logo[0])
        SC_TRY(share_logo(app, &annotations, session));
    annotations = sc_session_annotations(session);
    if (session->front) {
        over = sc_session_annotations(session->front);
        annotations.over = &over;
    }
    if (sc_annotations_names(&annotations) && session->volume.ids)
        status = share_names(app, &annotations, session);
out:
    return status;
}
