/* SPDX-License-Identifier: BSD-3-Clause */
/* What is written onto the pictures of a panel: made by rank 0, which has the fonts and the
 * files, and sent to all others. */
#include "panels.h"

#include "segcast/views.h"

sc_annotations sc_panel_annotations(const sc_panel *panel)
{
    const sc_job *job = &panel->job;
    const int *size_px = job->output.size_px;
    sc_annotations out = {.overlays = &job->overlays,
                          .lists = job->overlay_lists,
                          .volume = &panel->volume,
                          .tissues = panel->looks.tissues,
                          .timeline = &panel->timeline,
                          .within = {0, 0, size_px[0], size_px[1]},
                          .fps = job->output.fps,
                          .first_frame = panel->shot ? panel->shot->span.first : 0,
                          .card = panel->shot && panel->shot->has_card ? &panel->shot->card : NULL,
                          .scale = panel->looks.scale.is_used ? &panel->looks.scale : NULL,
                          .logo = panel->text.logo,
                          .lettering = panel->text.lettering,
                          .names = panel->text.names,
                          .divided_px = panel->place.is_divided ? size_px[0] : 0,
                          .is_behind_divider = panel->group.index > 0};

    memcpy(out.nameless, panel->nameless, sizeof out.nameless);
    if (job->output.layout == SC_LAYOUT_VIEWS)
        out.within = sc_views_space(size_px[0], size_px[1]);
    if (panel->place.space.width_px)
        out.within = out.space = panel->place.space;
    if (panel->place.within.width_px)
        out.within = panel->place.within;
    return out;
}

/* Send a block of rank 0, and of how many bytes it is. @param block as of sc_broadcast_array.
 * Collective. */
static sc_status share_block(sc_app *app, void *block, uint64_t bytes)
{
    sc_comm_broadcast(app->comm, &bytes, sizeof bytes);
    return sc_broadcast_array(app, block, bytes, 1);
}

/* Fill panel->text.logo from the file of the job. Collective. */
static sc_status share_logo(sc_app *app, const sc_annotations *annotations, sc_panel *panel)
{
    const bool first = sc_comm_rank(app->comm) == 0;
    sc_image *logo = &panel->text.logo;
    uint8_t *pixels;
    sc_status status = SC_OK;

    if (first)
        status = sc_annotations_logo(app->ctx, annotations, logo);
    SC_PASS(sc_comm_agree(app->comm, status));
    pixels = logo->rgb;
    sc_comm_broadcast(app->comm, logo, sizeof *logo);
    logo->rgb = pixels; /* that which was received is an address of rank 0 */
    return sc_broadcast_array(app, &logo->rgb, sc_image_bytes(logo), 1);
}

/* Fill panel->text.names. Collective. */
static sc_status share_names(sc_app *app, const sc_annotations *annotations, sc_panel *panel)
{
    const bool first = sc_comm_rank(app->comm) == 0;
    sc_status status = SC_OK;

    sc_stage_begin(app->ctx, "placing the names", 0, 0);
    if (first)
        status = sc_annotations_plan_names(app->ctx, annotations, app->threads, &panel->text.names);
    SC_PASS(sc_comm_agree(app->comm, status));
    return share_block(app, &panel->text.names, first ? panel->text.names->bytes : 0);
}

sc_status sc_panel_letter(sc_app *app, sc_panel *panel)
{
    sc_annotations annotations = sc_panel_annotations(panel), over;
    const bool first = sc_comm_rank(app->comm) == 0;
    sc_status status = SC_OK;

    if (!sc_annotations_any(&annotations))
        return SC_OK;
    annotations.told = &app->font_told;
    if (first)
        status = sc_annotations_letter(app->ctx, &annotations, &panel->text.lettering);
    SC_PASS(sc_comm_agree(app->comm, status));
    SC_PASS(share_block(app, &panel->text.lettering, first ? panel->text.lettering->bytes : 0));
    if (panel->job.overlays.logo[0])
        SC_PASS(share_logo(app, &annotations, panel));
    annotations = sc_panel_annotations(panel);
    if (panel->group.front && panel->phases) {
        over = sc_panel_annotations(panel->group.front);
        annotations.over = &over;
    }
    if (sc_annotations_names(&annotations) && panel->volume.ids)
        return share_names(app, &annotations, panel);
    return SC_OK;
}
