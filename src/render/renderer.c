/* SPDX-License-Identifier: BSD-3-Clause */
/* Creation of a renderer: everything that does not change from frame to frame. */
#include "path.h"

#include <string.h>

/* The length of a voxel: the smallest spacing, in mm. */
static double voxel_length_mm(const sc_prepared *volume)
{
    double least = HUGE_VAL;

    for (int i = 0; i < 3; i++)
        least = fmin(least, sc_vec3_length(sc_affine_column(&volume->to_ras_mm, i)));
    return least;
}

/* Set r->march.thickness_alpha, by automatic opacity; to be called after fill_march, which
 * clears it. */
static void fill_thickness(sc_renderer *r, const sc_tissue *tissues)
{
    const sc_opacity_scale scale =
        sc_local_opacity_scale(sc_opacity_scale_of(r->volume, tissues, r->settings.opacity_rule));

    for (int code = 0; code < 256; code++)
        r->march.thickness_alpha[code] =
            sc_alpha_of(&r->settings, sc_auto_opacity(&scale, sc_thickness_mm(code)));
}

/* Set all of r->march that does not change from frame to frame, from the other members of the
 * renderer, which must be complete. */
static void fill_march(sc_renderer *r)
{
    const sc_render_settings *s = &r->settings;
    const sc_lighting *l = &s->light;
    const sc_prepared *v = r->volume;

    r->march = (sc_march){
        .volume = v,
        .marked.masks = r->derived.visible,
        .marked.distances = r->derived.distances,
        .marked.pyramid = &r->derived.pyramid,
        .marked.cell_distances = r->derived.cell_distances,
        /* grid coordinates are those of voxels plus one */
        .box_low = {(float)r->space.box.low.x + 1, (float)r->space.box.low.y + 1,
                    (float)r->space.box.low.z + 1},
        .box_high = {(float)r->space.box.high.x + 1, (float)r->space.box.high.y + 1,
                     (float)r->space.box.high.z + 1},
        .marked.cell_start = r->derived.cell_start,
        .marked.cells = r->derived.cells,
        .marked.row = sc_framed_row(v->bricks),
        .marked.layer = sc_framed_layer(v->bricks),
        .tissues = r->tissues,
        .step_mm = (float)(s->step_voxels * voxel_length_mm(v)),
        .light = {.flat = l->method == SC_LIGHT_FLAT},
        .occlusion = r->derived.occlusion.filled ? &r->derived.occlusion : NULL,
        .around_share = 1,
        .opaque_below = s->sampling.to_the_end ? 0 : SC_OPAQUE,
        .cut_faces = {.are_drawn = s->caps, .outline = (float)(s->cap_outline / 2)},
    };
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            r->march.grid_per_mm[i][j] = (float)r->space.to_voxel.m[i][j];
    }
}

/* Set r->bounds.hull_box to the bounding box of r->bounds.hull; it is inside out if there are no
 * points. */
static void measure_hull(sc_renderer *r)
{
    r->bounds.hull_box = SC_BOX3_EMPTY;
    for (size_t i = 0; i < r->bounds.hull_count; i++)
        sc_box3_hold(&r->bounds.hull_box, r->bounds.hull[i]);
}

/* Can the renderer use what is stored with the volume? That was made for this surface and skip
 * method, with every tissue shown. */
static bool has_stored(const sc_renderer *r, const uint8_t *show)
{
    const sc_prepared *v = r->volume;
    bool all = v->stored.masks && r->kernel->surface == SC_SURFACE_SMOOTH &&
               r->kernel->skip == SC_SKIP_LEAP;

    for (int id = 1; id < v->label_count; id++)
        all = all && (show[id] & SC_SHOW_BOUNDARY || !v->stats[id].voxels);
    return all;
}

/* Set of the renderer what find_hull_and_visible() derives to what is stored with the volume. */
static void use_stored(sc_renderer *r)
{
    const sc_stored *stored = &r->volume->stored;

    r->bounds.hull = stored->hull;
    r->bounds.hull_count = stored->hull_count;
    r->derived.visible = stored->masks;
    r->derived.cell_start = stored->cell_start;
    r->derived.cells = stored->cells;
    r->derived.distances = stored->distances;
}

/* Derive from the volume which cells or voxels are visible, what follows from them, and the hull.
 * Parameters and return code are those of derive(). */
static sc_status find_hull_and_visible(const sc_ctx *ctx, sc_renderer *r, const uint8_t *show)
{
    sc_vec3 *hull;

    SC_PASS(sc_hull_points(ctx, r->team, r->volume, show, &hull, &r->bounds.hull_count));
    r->bounds.hull = hull;
    return sc_find_visible(ctx, r, show);
}

/* Derive from the volume what the march needs and what does not change from frame to frame, as far
 * as it is not stored: masks (r->derived.visible), what follows from them (distances, cells,
 * blocks), the hull with its box, which is that of the visible voxels for either surface, and the
 * occlusion.
 * @param show what of each label is shown. @param opacity of each label, as of sc_occlusion_build.
 * Collective in r->team. @return SC_ERR_MEMORY; what has been set stays with the renderer. */
static sc_status derive(const sc_ctx *ctx, sc_renderer *r, const uint8_t *show,
                        const float *opacity)
{
    const sc_lighting *light = &r->settings.light;
    const sc_prepared *v = r->volume;

    if (has_stored(r, show))
        use_stored(r);
    else
        SC_PASS(find_hull_and_visible(ctx, r, show));
    measure_hull(r);
    sc_floor_place(r);
    if (light->method != SC_LIGHT_FLAT && (light->occlusion > 0 || light->shadows > 0))
        SC_PASS(sc_occlusion_build(ctx, r->team, v, opacity, &r->derived.occlusion));
    SC_PASS(sc_find_fades(ctx, r));
    SC_PASS(sc_find_backdrop(ctx, r));
    sc_decide_cover(r);
    if (!r->cover.covers_all)
        SC_PASS(sc_find_blocks(ctx, r));
    return SC_OK;
}

/* Allocate what depends on the settings and the number of labels: tissues, and per thread stats,
 * spans and pixels, and room for the map. @return SC_ERR_MEMORY; sc_renderer_free frees what
 * there is. */
static sc_status allocate(const sc_ctx *ctx, sc_renderer *r)
{
    const size_t threads = (size_t)r->settings.work.threads,
                 side = (size_t)r->settings.work.tile_px + 2;

    SC_PASS(SC_ALLOC(ctx, (size_t)r->volume->label_count, &r->tissues));
    SC_PASS(SC_ZALLOC(ctx, (size_t)r->volume->label_count, &r->looks));
    SC_PASS(SC_ZALLOC(ctx, threads, &r->room.stats));
    SC_PASS(SC_ZALLOC(ctx, threads, &r->room.spans));
    if (r->settings.work.lender) {
        r->room.pixels = r->settings.work.lender->room.pixels;
    } else {
        SC_PASS(SC_ALLOC(ctx, threads * side * side, &r->room.pixels));
    }
    SC_PASS(sc_lens_samples_make(ctx, r));
    SC_PASS(sc_path_numbers_make(ctx, r));
    return sc_alloc(ctx, SC_COVER_SIDE, SC_COVER_SIDE, &r->cover.squares);
}

/* Set r->kernel. A volume that is too large for the wide kernels is marched by those of
 * SC_SKIP_INTERIOR. @return SC_ERR_USAGE, with a message, if this processor cannot run
 * settings.cpu. */
static sc_status find_kernel(const sc_ctx *ctx, sc_renderer *r)
{
    const sc_render_settings *s = &r->settings;

    r->kernel = sc_kernel_find(s->surface, s->skip, r->volume, s->cpu);
    if (!r->kernel && s->cpu)
        SC_PASS(sc_cpu_check(ctx, s->cpu));
    if (!r->kernel)
        r->kernel = sc_kernel_find(s->surface, SC_SKIP_INTERIOR, r->volume, NULL);
    return SC_OK;
}

/* Make what a rank of the team has for itself: all but what is derived from the volume. @param
 * show, opacity [label_count], filled: see derive(). @return as of sc_renderer_new; what has been
 * set stays with the renderer. */
static sc_status begin(const sc_ctx *ctx, sc_renderer *r, const sc_tissue *tissues, uint8_t *show,
                       float *opacity)
{
    if (!sc_affine_invert(&r->volume->to_ras_mm, &r->space.to_voxel))
        return sc_fail(ctx, SC_ERR_DATA, "the geometry of the volume is singular");
    SC_PASS(find_kernel(ctx, r));
    SC_PASS(allocate(ctx, r));
    sc_fill_tissues(r, tissues, show, opacity);
    sc_fill_boxes(r);
    sc_srgb_table_init(&r->srgb);
    SC_PASS(
        sc_sky_init(ctx, r->settings.environment, r->settings.environment_turn_deg, &r->light.sky));
    return sc_fill_grey(ctx, r);
}

/* @return whether light is gathered: for smooth surfaces, if the kernel that does it can reach all
 * of the volume, as one of those that draw can. */
static bool gathers_light(const sc_renderer *r)
{
    return r->settings.light.method == SC_LIGHT_GLOBAL &&
           r->settings.surface == SC_SURFACE_SMOOTH &&
           sc_kernel_find(SC_SURFACE_SMOOTH, SC_SKIP_LEAP, r->volume, NULL);
}

/* @return whether surfaces between two tissues can be seen but where they are cut: some tissue lets
 * light through, fades, moves away, or is spared by a plane that cuts others. */
static bool shows_inner(const sc_renderer *r, const sc_tissue *tissues)
{
    int clip_set = -1;

    for (int id = 1; id < r->volume->label_count; id++) {
        if (!r->volume->stats[id].voxels || !r->looks[id].show)
            continue;
        if (r->looks[id].opacity < 1 || r->looks[id].group || tissues[id].part ||
            (clip_set >= 0 && tissues[id].clip_set != clip_set))
            return true;
        clip_set = tissues[id].clip_set;
    }
    return false;
}

sc_status sc_renderer_new(const sc_ctx *ctx, const sc_render_settings *settings,
                          const sc_prepared *volume, const sc_tissue *tissues, sc_renderer **out)
{
    const size_t labels = (size_t)volume->label_count;
    sc_team *team = NULL;
    sc_renderer *r = NULL;
    SC_OWN(sc_free_at) uint8_t *show = NULL;
    SC_OWN(sc_free_at) float *opacity = NULL;
    sc_status status;

    SC_TRY(sc_team_open(ctx, settings->work.comm, settings->work.threads, settings->work.folder,
                        &team));
    status = SC_ZALLOC(ctx, 1, &r);
    if (status == SC_OK)
        status = SC_ALLOC(ctx, labels, &show);
    if (status == SC_OK)
        status = SC_ALLOC(ctx, labels, &opacity);
    if (status == SC_OK) {
        r->settings = *settings;
        r->volume = volume;
        r->light.traces = settings->light.method == SC_LIGHT_PATH;
        status = begin(ctx, r, tissues, show, opacity);
    }
    /* No rank begins what all do together before all have come as far. */
    SC_TRY(sc_team_agree(team, status));
    r->team = team;
    team = NULL;
    SC_TRY(derive(ctx, r, show, opacity));
    fill_march(r);
    fill_thickness(r, tissues);
    r->derived.shows_inner = shows_inner(r, tissues);
    SC_TRY(sc_parts_make(ctx, r, tissues));
    *out = r;
    r = NULL;
out:
    sc_renderer_free(r);
    sc_team_close(team);
    return status;
}

/* @return on all ranks of the team what the first one passes. Collective. */
static bool all_can(const sc_renderer *r, bool first_can)
{
    return sc_team_agree(r->team, first_can || !sc_team_is_first(r->team) ? SC_OK : SC_ERR_DATA) ==
           SC_OK;
}

/* Light that takes less CPU seconds to gather is not worth the disk. */
#define LIGHT_WORTH_CPU_S 0.3

sc_status sc_renderer_gather(const sc_ctx *ctx, sc_renderer *r, const sc_scene *first,
                             sc_light_change change, const char *prepared)
{
    SC_OWN(sc_free_at) char *path = NULL;
    sc_status status;
    double begin_s;

    if (!gathers_light(r) || r->light.gather)
        return SC_OK;
    sc_begin_tissues(r, first);
    sc_begin_scene(r, first, r->settings.height_px);
    status = change == SC_LIGHT_STAYS ? sc_gather_kept_path(ctx, r, first, prepared, &path) : SC_OK;
    SC_PASS(sc_team_agree(r->team, status));
    if (all_can(r, path)) {
        SC_PASS(sc_gather_new_kept(ctx, r, &r->light.gather));
        if (all_can(r, sc_team_is_first(r->team) && sc_gather_load(r->light.gather, path)))
            return SC_OK;
        sc_gather_free(r->light.gather);
        r->light.gather = NULL;
    }
    begin_s = sc_cpu_s();
    sc_stage_begin(ctx, "gathering light", 0, SC_GATHER_RAYS);
    SC_PASS(sc_gather_new(ctx, r, change, &r->light.gather));
    sc_begin_scene(r, first, r->settings.height_px);
    sc_gather_first(ctx, r->light.gather, r, first);
    if (path && sc_cpu_s() - begin_s > LIGHT_WORTH_CPU_S)
        sc_gather_save(ctx, r->light.gather, path);
    return SC_OK;
}

void sc_renderer_free(sc_renderer *r)
{
    if (!r)
        return;
    sc_parts_free(r);
    sc_gather_free(r->light.gather);
    sc_team_close(r->team);
    sc_free(r->tissues);
    sc_free(r->looks);
    sc_free(r->fades.mixed);
    sc_free(r->cover.squares);
    sc_free(r->room.stats);
    sc_free(r->room.spans);
    sc_free(r->room.blurred);
    sc_free(r->room.lens_samples);
    sc_free(r->light.path_numbers);
    sc_sky_clear(&r->light.sky);
    if (!r->settings.work.lender)
        sc_free(r->room.pixels);
    sc_free(r);
}

void sc_renderer_advise(sc_renderer *renderer, sc_memory_use use)
{
    sc_team_advise(renderer->team, use);
}

const sc_vec3 *sc_renderer_hull(const sc_renderer *renderer, size_t *count)
{
    *count = renderer->bounds.hull_count;
    return renderer->bounds.hull;
}

const sc_kernel *sc_renderer_kernel(const sc_renderer *renderer)
{
    return renderer->kernel;
}

uint64_t sc_renderer_bytes(const sc_renderer *r)
{
    const size_t side = (size_t)r->settings.work.tile_px + 2;
    const size_t threads = (size_t)r->settings.work.threads;

    return sizeof *r + (size_t)r->volume->label_count * (sizeof *r->tissues + sizeof *r->looks) +
           sc_fades_bytes(r) + sc_parts_bytes(r) + sc_gather_bytes(r->light.gather) +
           (size_t)SC_COVER_SIDE * SC_COVER_SIDE +
           threads * (sizeof *r->room.stats + sizeof *r->room.spans) +
           (r->settings.work.lender ? 0 : threads * side * side * sizeof *r->room.pixels) +
           (r->room.blurred ? threads * side * side * sizeof *r->room.blurred : 0) +
           (size_t)SC_LENS_BLOCK * SC_LENS_BLOCK * (size_t)r->settings.sampling.lens_samples *
               sizeof *r->room.lens_samples +
           sc_path_numbers_bytes(r) + sc_sky_bytes(&r->light.sky);
}

uint64_t sc_renderer_derived_bytes(const sc_renderer *r)
{
    return sc_team_bytes(r->team);
}
