/* SPDX-License-Identifier: BSD-3-Clause */
/* Prepares volumes for drawing, and makes the rays and lines that measure them. */
#include "fidelity.h"

#include <string.h>

uint64_t random_bits_of(uint64_t *seed)
{
    uint64_t z = *seed += 0x9e3779b97f4a7c15u; /* splitmix64 */

    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

double random_of(uint64_t *seed)
{
    return (double)(random_bits_of(seed) >> 11) * 0x1p-53;
}

void make_ray(const stage *st, sc_vec3 eye, sc_vec3 direction, sc_ray *ray)
{
    const double shift = st->kernel->surface == SC_SURFACE_VOXEL ? 1.5 : 1;
    const sc_vec3 o = sc_affine_point(&st->to_voxel, eye);
    const sc_vec3 d = sc_affine_vector(&st->to_voxel, direction);
    const int *size = st->volume.size;
    const sc_box3 box = {{-2, -2, -2}, {size[0] + 1, size[1] + 1, size[2] + 1}};
    double begin = 0, end = 2 * st->reach_mm;
    const bool meets = sc_box3_clip_line(&box, o, d, &begin, &end);

    *ray = (sc_ray){.origin = {(float)(o.x + shift), (float)(o.y + shift), (float)(o.z + shift)},
                    .direction = {(float)d.x, (float)d.y, (float)d.z},
                    .toward_eye = {(float)-direction.x, (float)-direction.y, (float)-direction.z},
                    .clip_sets = 1,
                    .part_count = {meets}};
    ray->parts[0][0].begin_mm = (float)begin;
    ray->parts[0][0].end_mm = (float)end;
    ray->parts[0][0].first = (int32_t)ceil(begin / (double)st->march.step_mm);
    ray->parts[0][0].last = (int32_t)(end / (double)st->march.step_mm);
    ray->parts[0][0].cap_plane = -1;
}

sc_vec3 random_direction(uint64_t *seed)
{
    const double z = 2 * random_of(seed) - 1, angle = 2 * M_PI * random_of(seed);
    const double across = sqrt(1 - z * z);

    return (sc_vec3){across * cos(angle), across * sin(angle), z};
}

sc_vec3 random_line(const stage *st, uint64_t *seed, sc_vec3 *eye)
{
    const sc_vec3 d = random_direction(seed), side = sc_vec3_perpendicular(d);
    const double r = st->reach_mm * sqrt(random_of(seed));
    const double angle = 2 * M_PI * random_of(seed);
    const sc_vec3 through = sc_vec3_along(st->middle_mm, r, sc_vec3_rotate(side, d, angle));

    *eye = sc_vec3_along(through, -st->reach_mm, d);
    return d;
}

int id_at(const sc_volume *v, int x, int y, int z)
{
    const size_t at = ((size_t)z * (size_t)v->size[1] + (size_t)y) * (size_t)v->size[0] + (size_t)x;

    if (x < 0 || y < 0 || z < 0 || x >= v->size[0] || y >= v->size[1] || z >= v->size[2])
        return 0;
    return v->label_bytes == 1 ? ((const uint8_t *)v->ids)[at] : ((const uint16_t *)v->ids)[at];
}

bool is_uniform(const stage *st, sc_vec3 p)
{
    const int x = (int)floor(p.x) + 1, y = (int)floor(p.y) + 1, z = (int)floor(p.z) + 1;
    const int *size = st->volume.size;
    sc_vertex lowest;

    if (x < 0 || y < 0 || z < 0 || x > size[0] || y > size[1] || z > size[2])
        return true;
    lowest = sc_vertex_at(&st->volume, x, y, z);
    return !lowest.outer && !lowest.inner && !sc_is_near(&st->volume, x, y, z);
}

int owner_at(const stage *st, sc_vec3 mm)
{
    const sc_vec3 p = sc_affine_point(&st->to_voxel, mm);
    const float point[3] = {(float)(p.x + 1), (float)(p.y + 1), (float)(p.z + 1)};
    const sc_prepared *v = &st->volume;
    const int x = (int)floor(p.x + 0.5), y = (int)floor(p.y + 0.5), z = (int)floor(p.z + 0.5);

    if (st->kernel->surface == SC_SURFACE_SMOOTH)
        return (int)sc_kernel_owner(v, point);
    return (int)sc_id_at_vertex(v, x + 1, y + 1, z + 1);
}

/* Fill in all of the stage that follows from its volume and masks: kernel, geometry, and a march
 * with flat light. @p reach, @p step_mm as of stage_open. */
static void set_stage(stage *st, sc_surface surface, double reach, double step_mm)
{
    const sc_prepared *v = &st->volume;
    const sc_vec3 corner = {v->size[0] - 1, v->size[1] - 1, v->size[2] - 1};
    const sc_vec3 low = sc_affine_point(&v->to_ras_mm, (sc_vec3){0, 0, 0});
    const sc_vec3 high = sc_affine_point(&v->to_ras_mm, corner);

    st->kernel = sc_kernel_find(surface, SC_SKIP_INTERIOR, v, NULL);
    (void)sc_affine_invert(&v->to_ras_mm, &st->to_voxel);
    st->middle_mm = sc_vec3_scale(sc_vec3_add(low, high), 0.5);
    st->reach_mm = 0.5 * reach * sc_vec3_length(sc_vec3_sub(high, low));
    st->march = (sc_march){
        .volume = v,
        .marked = {.masks = st->cells,
                   .row = sc_framed_row(v->bricks),
                   .layer = sc_framed_layer(v->bricks)},
        .box_low = {-1.5f, -1.5f, -1.5f},
        .box_high = {(float)v->size[0] + 2.5f, (float)v->size[1] + 2.5f, (float)v->size[2] + 2.5f},
        .tissues = st->tissues,
        .step_mm = (float)step_mm,
        .opaque_below = SC_OPAQUE,
        .light = {.flat = true}};
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            st->march.grid_per_mm[i][j] = (float)st->to_voxel.m[i][j];
    }
}

/* Copy a volume, on the grid of its drawing if that is asked for. Caller owns *out, which must be
 * zero, even after an error: sc_volume_clear. @return SC_ERR_MEMORY. */
static sc_status copy_resampled(const sc_ctx *ctx, const sc_volume *volume, const drawing *how,
                                sc_volume *out)
{
    const size_t bytes = sc_volume_voxels(volume) * (size_t)volume->label_bytes;
    const size_t label_bytes = (size_t)volume->label_count * sizeof *volume->labels;
    sc_drawn_grid grid;
    void *block;

    *out = *volume;
    out->ids = out->labels = NULL;
    out->table = out->absent = out->outside = (sc_label_table){0}; /* not needed here */
    SC_PASS(sc_alloc(ctx, bytes, 1, &out->ids));
    memcpy(out->ids, volume->ids, bytes);
    SC_PASS(sc_alloc(ctx, label_bytes, 1, &block));
    out->labels = memcpy(block, volume->labels, label_bytes);
    if (how->resample) {
        SC_PASS(sc_find_drawn_grid(ctx, out, how->threads, &grid));
        SC_PASS(sc_resample(ctx, out, &grid, how->threads));
    }
    return SC_OK;
}

sc_status stage_open(const sc_ctx *ctx, const sc_volume *volume, const drawing *how, double reach,
                     double step_mm, stage *st)
{
    const sc_prepare_settings settings = {.smooth = {how->smooth, how->smooth, how->smooth},
                                          .threads = how->threads};
    const size_t labels = (size_t)volume->label_count;
    SC_OWN(sc_volume_clear) sc_volume resampled = {0};
    sc_preparation *preparation = NULL;
    SC_OWN(sc_free_at) uint8_t *show = NULL;
    size_t bytes;
    sc_status status;

    *st = (stage){.voxels = volume};
    (void)sc_affine_invert(&volume->to_ras_mm, &st->to_measured);
    SC_TRY(copy_resampled(ctx, volume, how, &resampled));
    SC_TRY(sc_prepare(ctx, &resampled, &settings, &preparation));
    bytes = sc_preparation_bytes(preparation);
    SC_TRY(sc_alloc(ctx, bytes, 1, &st->block));
    sc_preparation_pack(preparation, st->block);
    SC_TRY(sc_prepared_view(ctx, st->block, bytes, &st->volume));
    SC_TRY(SC_ZALLOC(ctx, labels, &show));
    SC_TRY(SC_ZALLOC(ctx, labels, &st->tissues));
    for (size_t id = 0; id < labels; id++) {
        show[id] = id ? SC_SHOW_BOUNDARY : 0;
        st->tissues[id] = (sc_march_tissue){.boundary_alpha = 1,
                                            .cap_alpha = 1,
                                            .thickness_factor = 1,
                                            .show = show[id],
                                            .shininess = 1};
    }
    SC_TRY(sc_team_open(ctx, NULL, how->threads, NULL, &st->team));
    if (how->surface == SC_SURFACE_SMOOTH)
        SC_TRY(sc_visible_cells(ctx, st->team, &st->volume, show, &st->cells));
    else
        SC_TRY(sc_visible_masks(ctx, st->team, &st->volume, show, &st->cells));
    set_stage(st, how->surface, reach, step_mm);
out:
    sc_preparation_free(preparation);
    return status;
}

void stage_close(stage *st)
{
    sc_free(st->block);
    sc_team_close(st->team);
    sc_free(st->tissues);
    *st = (stage){0};
}
