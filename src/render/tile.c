/* SPDX-License-Identifier: BSD-3-Clause */
/* The rays of a tile: which are worth marching, and marching those that wait. */
#include "path.h"

void sc_tile_march(sc_tile *t)
{
    const sc_renderer *r = t->f->renderer;

    if (sc_traces_paths(r, t->f->scene))
        sc_tile_trace(t);
    else if (sc_parts_apart(r))
        sc_march_apart(r, t->rays.aims, NULL, t->rays.count, t->thread, t->rays.light,
                       &t->counters);
    else
        sc_march_rays(r, t->rays.rays, t->rays.count, t->rays.light, t->rays.white, &t->counters);
    if (r->grey.is_behind)
        sc_put_grey_behind(&t->f->lens, t->rays.aims, t->rays.count, t->rays.light);
    if (r->light.floor.is_shown && r->light.floor.light)
        sc_put_floor_behind(&t->f->lens, t->rays.aims, t->rays.count, t->rays.light);
}

bool sc_may_show_tissue(const sc_frame *f, int x_px, int y_px)
{
    const sc_parts *parts = f->renderer->parts;

    if (sc_parts_apart(f->renderer))
        return parts->met[sc_cover_square(&parts->layout, x_px, y_px)];
    return f->cover.squares[sc_cover_square(&f->cover, x_px, y_px)];
}

bool sc_may_show(const sc_frame *f, int x_px, int y_px)
{
    return sc_shows_behind(f->renderer) || sc_may_show_tissue(f, x_px, y_px);
}

/* A ray that meets no tissue: nothing of it is kept. */
static const sc_ray empty_ray = {.direction = {1, 0, 0}};

void sc_tile_add_ray(sc_tile *t, const sc_aim *aim, uint32_t target)
{
    const sc_frame *f = t->f;
    sc_batch *rays = &t->rays;

    rays->aims[rays->count] = *aim;
    rays->target[rays->count] = target;
    if (!sc_parts_apart(f->renderer) &&
        ((sc_shows_behind(f->renderer) &&
          !sc_may_show_tissue(f, (int)floor(aim->x_px), (int)floor(aim->y_px))) ||
         !sc_make_ray(&f->lens, aim, &rays->rays[rays->count]))) {
        if (!sc_shows_behind(f->renderer))
            return;
        rays->rays[rays->count] = empty_ray;
    }
    rays->count++;
}

float sc_cover_of(const sc_renderer *r, const sc_radiance *light)
{
    return r->settings.transparent ? 1 - light->transmittance : 0;
}
