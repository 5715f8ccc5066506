/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to render: the tile that a thread draws, and the rays that it sends out. */
#ifndef SC_RENDER_TILE_H
#define SC_RENDER_TILE_H

#include "internal.h"

/* The frame being drawn, which all threads share. Pointers are borrowed. */
typedef struct sc_frame {
    sc_renderer *renderer;
    const sc_scene *scene;
    const sc_viewport *viewport;
    sc_image *image;
    sc_lens lens;
    sc_cover cover;         /* a copy of renderer->cover.map */
    sc_pixel_state nothing; /* what a pixel without a ray has seen */
    int tiles_x;            /* tiles in a row of tiles */
    int column0, column1;   /* columns [column0, column1) of the viewport are to be drawn */
    int row0, row1;         /* rows [row0, row1) of the viewport are to be drawn */
} sc_frame;

/* Rays waiting to be marched together, or where parts are apart only where they go, and for each
 * the index of its pixel in sc_tile.pixels. */
typedef struct sc_batch {
    sc_ray rays[SC_RAY_BATCH];
    sc_aim aims[SC_APART_BATCH];
    sc_radiance light[SC_APART_BATCH]; /* what they bring back */
    sc_radiance
        white[SC_RAY_BATCH]; /* room for what they bring back where the far end fades to white */
    uint32_t target[SC_APART_BATCH];
    size_t count, most; /* how many there are, and at most can be: set by the caller */
} sc_batch;

/* A tile, pixels [x0, x1) by [y0, y1) of the viewport, and what a thread needs to draw it. */
typedef struct sc_tile {
    const sc_frame *f;
    int x0, y0, x1, y1;
    sc_pixel_state *pixels;    /* [y1 - y0 + 2][stride]: with a border one pixel wide; borrowed */
    sc_blurred_pixel *blurred; /* the same of a picture with an aperture, instead */
    int stride;
    int thread; /* that draws it */
    sc_march_counters counters;
    sc_batch rays;
} sc_tile;

/* ---- tile.c ---- */

/* @return the index in the arrays of a tile of a pixel of it, or of its border. */
static inline uint32_t sc_tile_index(const sc_tile *t, int x_px, int y_px)
{
    return (uint32_t)((y_px - t->y0 + 1) * t->stride + (x_px - t->x0 + 1));
}
/* Can a pixel of the viewport, or of a border around it, show a tissue? */
bool sc_may_show_tissue(const sc_frame *f, int x_px, int y_px);
/* Can it show anything? */
bool sc_may_show(const sc_frame *f, int x_px, int y_px);
/* Add a ray to those waiting, for which there is room, unless it meets nothing, nor has a grey
 * volume behind it. @param target index of its pixel in the arrays of the tile. */
void sc_tile_add_ray(sc_tile *t, const sc_aim *aim, uint32_t target);
/* March the rays waiting into t->rays.light and add to the tile's counters. The caller empties the
 * batch. */
void sc_tile_march(sc_tile *t);
/* @return the share of what is behind the picture that a ray hides; 0 with a background. */
float sc_cover_of(const sc_renderer *r, const sc_radiance *light);

/* ---- aperture.c ---- */

/* Make the samples of a renderer whose scenes have apertures: sets r->room.lens_samples and
 * r->room.blurred.
 * @return SC_ERR_MEMORY. */
sc_status sc_lens_samples_make(const sc_ctx *ctx, sc_renderer *r);
/* Does light come by paths in the present view, whose scene is @p scene? */
static inline bool sc_traces_paths(const sc_renderer *r, const sc_scene *scene)
{
    return r->light.traces && !r->hurries && !scene->slice && !scene->inside;
}
/* Does a scene have many rays in each pixel: does it show what is not in focus blurred, or light by
 * paths? */
static inline bool sc_is_blurred(const sc_renderer *r, const sc_scene *scene)
{
    return r->room.lens_samples && (scene->camera.aperture_mm > 0 || sc_traces_paths(r, scene));
}
/* Draw a tile of such a scene into the image. */
void sc_tile_draw_blurred(sc_tile *t);

#endif
