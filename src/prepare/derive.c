/* SPDX-License-Identifier: BSD-3-Clause */
/* What a prepared file holds beside the prepared volume: that from which pictures are drawn as long
 * as every tissue is shown, which jobs do not need to derive then. */
#include "internal.h"

#include <string.h>

sc_prepared sc_preparation_view(const sc_preparation *p)
{
    const sc_volume *v = p->volume;
    sc_prepared view = {.label_bytes = v->label_bytes,
                        .label_count = v->label_count,
                        .oriented = v->oriented,
                        .numbered = v->numbered,
                        .to_ras_mm = v->to_ras_mm,
                        .volume_hash = p->volume_hash,
                        .boundary.voxel_count = p->boundary_count,
                        .boundary.count = p->near_count,
                        .ids = v->ids,
                        .labels = v->labels,
                        .stats = p->stats,
                        .boundary.masks = p->near,
                        .boundary.start = p->near_start,
                        .outer = p->outer,
                        .inner = p->inner,
                        .thickness = p->thickness,
                        .how = {.smooth = p->smooth,
                                .resampled = p->settings.resampled,
                                .as_drawn = p->settings.as_drawn,
                                .hidden = p->hidden},
                        .stored = p->stored};

    memcpy(view.size, v->size, sizeof view.size);
    memcpy(view.bricks, p->bricks, sizeof view.bricks);
    return view;
}

void sc_free_stored(sc_preparation *p)
{
    sc_team_free_const(p->team, p->stored.masks);
    sc_team_free_const(p->team, p->stored.cell_start);
    sc_team_free_const(p->team, p->stored.cells);
    sc_team_free_const(p->team, p->stored.distances);
    sc_team_free_const(p->team, p->stored.hull);
    sc_team_free_const(p->team, p->stored.occlusion);
    sc_team_free_const(p->team, p->stored.opacity);
    p->stored = (sc_stored){0};
}

/* Derive the occlusion: p->stored.occlusion and opacity. Parameters and return code are those of
 * sc_preparation_derive. */
static sc_status derive_occlusion(const sc_ctx *ctx, sc_preparation *p, const sc_prepared *view,
                                  const float *opacity)
{
    const size_t labels = (size_t)view->label_count;
    sc_occlusion occlusion;
    void *kept;

    SC_PASS(sc_team_alloc(ctx, p->team, labels, sizeof *opacity, &kept));
    p->stored.opacity = kept;
    if (sc_team_is_first(p->team))
        memcpy(kept, opacity, labels * sizeof *opacity);
    SC_PASS(sc_occlusion_build(ctx, p->team, view, opacity, &occlusion));
    p->stored.occlusion = occlusion.filled;
    return SC_OK;
}

sc_status sc_preparation_derive(const sc_ctx *ctx, sc_preparation *p, const float *opacity)
{
    const sc_prepared view = sc_preparation_view(p);
    const size_t labels = (size_t)view.label_count;
    void *show = NULL;
    uint64_t *masks;
    uint8_t *distances;
    sc_vec3 *hull;
    sc_cells cells;
    sc_status status;

    sc_stage_begin(ctx, "deriving", 0, 0);
    SC_TRY(sc_team_alloc(ctx, p->team, labels, 1, &show));
    if (sc_team_is_first(p->team))
        memset((uint8_t *)show + 1, SC_SHOW_BOUNDARY, labels - 1);
    SC_TRY(sc_team_agree(p->team, SC_OK));
    SC_TRY(sc_visible_cells(ctx, p->team, &view, show, &masks));
    p->stored.masks = masks;
    SC_TRY(sc_cells_build(ctx, p->team, &view, masks, &cells));
    p->stored.cell_start = cells.start;
    p->stored.cells = cells.cells;
    p->stored.cell_count = cells.count;
    SC_TRY(sc_brick_distances(ctx, p->team, view.bricks, masks, &distances));
    p->stored.distances = distances;
    SC_TRY(sc_hull_points(ctx, p->team, &view, show, &hull, &p->stored.hull_count));
    p->stored.hull = hull;
    if (opacity)
        SC_TRY(derive_occlusion(ctx, p, &view, opacity));
out:
    if (status != SC_OK)
        sc_free_stored(p);
    sc_team_free(p->team, show);
    return status;
}
