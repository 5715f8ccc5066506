/* SPDX-License-Identifier: BSD-3-Clause */
/* What a renderer derives from the volume and from what of each label is shown: the looks of the
 * tissues, the box that rays are marched within, masks, and what follows from these. */
#include "internal.h"
#include "path.h"

#include <string.h>

/* How a tissue takes part in the picture: SC_SHOW_* bits, 0 if it is not visible. The smooth
 * surface has no interior. */
static uint8_t shown(const sc_render_settings *s, const sc_tissue *tissue)
{
    const bool interior = tissue->interior_opacity > 0 && s->surface == SC_SURFACE_VOXEL;

    if (!tissue->visible)
        return 0;
    return (uint8_t)((tissue->opacity > 0 ? SC_SHOW_BOUNDARY : 0) |
                     (interior ? SC_SHOW_INTERIOR : 0));
}

/* Set the highlights of a tissue. Kernels draw one Blinn-Phong lobe for face and coat: its strength
 * is the sum of theirs, its width the mean of their GGX widths, weighted by strength; the exponent
 * follows from the width (Walter et al. 2007). */
static void set_highlight(const sc_material *material, sc_march_tissue *to)
{
    const double coat = material->coat * (SC_COAT_SHARE / SC_FACE_SHARE);
    const double both = material->specular + coat;
    double width;

    to->face = (float)material->specular;
    to->roughness = (float)(material->roughness * material->roughness);
    to->coat = (float)material->coat;
    to->specular = (float)both;
    width = coat > 0 ? (material->specular * to->roughness + coat * SC_COAT_WIDTH) / both
                     : to->roughness;
    to->shininess = (int)fmax(lround(2 / (width * width) - 2), 1);
}

void sc_fill_tissues(sc_renderer *r, const sc_tissue *tissues, uint8_t *show, float *opacity)
{
    const sc_render_settings *s = &r->settings;

    for (int id = 0; id < r->volume->label_count; id++) {
        sc_march_tissue *to = &r->tissues[id];

        memcpy(to->rgb, tissues[id].rgb_linear, sizeof to->rgb);
        to->boundary_alpha = sc_alpha_of(s, tissues[id].opacity);
        to->interior_alpha = sc_alpha_of(s, tissues[id].interior_opacity);
        to->thickness_factor = 1;
        set_highlight(&tissues[id].material, to);
        to->show = show[id] = id ? shown(s, &tissues[id]) : 0;
        to->cap_alpha = !id || show[id] ? 1 : 0;
        to->clip_set = tissues[id].clip_set;
        to->by_thickness = s->local_thickness && tissues[id].opacity_auto && !tissues[id].is_cover;
        opacity[id] = show[id] ? (float)tissues[id].opacity : 0;
        r->looks[id] = (sc_full_look){.opacity = tissues[id].opacity,
                                      .interior_opacity = tissues[id].interior_opacity,
                                      .show = show[id],
                                      .group = show[id] ? tissues[id].fade_group : 0,
                                      .clip_set = tissues[id].clip_set};
        memcpy(r->looks[id].rgb, tissues[id].rgb_linear, sizeof r->looks[id].rgb);
    }
}

void sc_fill_boxes(sc_renderer *r)
{
    const sc_prepared *v = r->volume;
    double low[3], high[3];

    r->space.box = (sc_box3){{-2, -2, -2}, {v->size[0] + 1, v->size[1] + 1, v->size[2] + 1}};
    r->space.middle_mm = sc_affine_point(
        &v->to_ras_mm, sc_vec3_scale(sc_vec3_add(r->space.box.low, r->space.box.high), 0.5));
    for (int corner = 0; corner < 8; corner++) {
        const sc_vec3 at = {corner & 1 ? r->space.box.high.x : r->space.box.low.x,
                            corner & 2 ? r->space.box.high.y : r->space.box.low.y,
                            corner & 4 ? r->space.box.high.z : r->space.box.low.z};
        const sc_vec3 apart = sc_vec3_sub(sc_affine_point(&v->to_ras_mm, at), r->space.middle_mm);

        r->space.radius_mm = fmax(r->space.radius_mm, sc_vec3_length(apart));
    }
    if (r->settings.skip == SC_SKIP_NONE)
        return;
    for (int i = 0; i < 3; i++) {
        low[i] = v->size[i];
        high[i] = -1;
    }
    for (int id = 1; id < v->label_count; id++) {
        for (int i = 0; i < 3 && r->tissues[id].show; i++) {
            low[i] = fmin(low[i], v->stats[id].low[i] - 2);
            high[i] = fmax(high[i], v->stats[id].high[i] + 2);
        }
    }
    r->space.box = (sc_box3){{low[0], low[1], low[2]}, {high[0], high[1], high[2]}};
}

void sc_decide_cover(sc_renderer *r)
{
    r->cover.covers_all = r->settings.skip == SC_SKIP_NONE;
    for (int id = 1; id < r->volume->label_count; id++)
        r->cover.covers_all = r->cover.covers_all || r->tissues[id].show == SC_SHOW_INTERIOR;
}

/* Make what the skip method knows of empty space, from @p masks, which become r->derived.visible.
 * Collective in r->team. @return SC_ERR_MEMORY; what has been set stays with the renderer. */
static sc_status find_empty(const sc_ctx *ctx, sc_renderer *r, uint64_t *masks)
{
    const sc_prepared *v = r->volume;
    uint8_t *distances;

    switch (r->kernel->skip) {
    case SC_SKIP_LEAP:
        SC_PASS(sc_brick_distances(ctx, r->team, v->bricks, masks, &distances));
        r->derived.distances = distances;
        break;
    case SC_SKIP_OCTREE:
        SC_PASS(sc_pyramid_build(ctx, r->team, v, &masks, &r->derived.pyramid));
        break;
    case SC_SKIP_PROXIMITY:
        SC_PASS(sc_cell_distances(ctx, r->team, v, masks, SC_METRIC_CITY_BLOCK,
                                  &r->derived.cell_distances));
        break;
    case SC_SKIP_CHESSBOARD:
        SC_PASS(sc_cell_distances(ctx, r->team, v, masks, SC_METRIC_CHESSBOARD,
                                  &r->derived.cell_distances));
        break;
    case SC_SKIP_NONE:
    case SC_SKIP_INTERIOR:
        break;
    }
    r->derived.visible = masks;
    return SC_OK;
}

sc_status sc_find_visible(const sc_ctx *ctx, sc_renderer *r, const uint8_t *show)
{
    const sc_prepared *v = r->volume;
    uint64_t *masks;

    if (r->settings.surface == SC_SURFACE_SMOOTH)
        SC_PASS(sc_visible_cells(ctx, r->team, v, show, &masks));
    else
        SC_PASS(sc_visible_masks(ctx, r->team, v, show, &masks));
    if (sc_skip_is_wide(r->kernel->skip) && r->kernel->surface == SC_SURFACE_SMOOTH) {
        sc_cells cells;

        SC_PASS(sc_cells_build(ctx, r->team, v, masks, &cells));
        r->derived.cell_start = cells.start;
        r->derived.cells = cells.cells;
    }
    return find_empty(ctx, r, masks);
}
