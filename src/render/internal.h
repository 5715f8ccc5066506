/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to render. */
#ifndef SC_RENDER_INTERNAL_H
#define SC_RENDER_INTERNAL_H

#include "segcast/render.h"

/* What a ray through the middle of a pixel has seen; then what the pixel gets. */
typedef struct sc_glimpse {
    float rgb[3];  /* linear, over the background */
    float tone[3]; /* its square root: nearly as the eye sees it */
    float normal[3];
    uint32_t label, signature;
    bool nothing; /* but background */
    bool sampled; /* rgb is the sum of more rays, less the background */
} sc_glimpse;

/* Middle of a block of bricks with something visible, in voxels. */
typedef struct sc_block {
    float x, y, z;
} sc_block;

/* Which pixels of a view can show anything, in squares, with one more on every side. */
enum { SC_COVER_SIDE = 512 /* no more squares than that along a side */, SC_COVER_SHIFT = 3 };
typedef struct sc_cover {
    int columns, rows, shift; /* squares of 2^shift pixels */
    const uint8_t *cells;     /* [rows][columns] */
} sc_cover;

struct sc_renderer {
    sc_render_settings settings;
    const sc_prepared *volume;
    const sc_kernel *kernel;
    sc_march march;
    sc_march_tissue *tissues;
    uint64_t *visible;
    uint8_t *distances;
    sc_cells cells;
    sc_occlusion occlusion;
    sc_block *blocks; /* [block_count] */
    size_t block_count;
    bool covers_all;     /* pixels without anything visible behind them may show something, too */
    uint8_t *cover;      /* room for the cells of a view: [SC_COVER_SIDE][SC_COVER_SIDE] */
    sc_cover last_cover; /* the cells hold this one, of these: bands of one frame share it */
    sc_scene last_scene;
    sc_viewport last_viewport;
    sc_vec3 *hull;
    size_t hull_count;
    sc_box3 hull_box; /* in mm */
    sc_affine to_voxel;
    sc_box3 box;       /* in voxels: what the kernel has to look at */
    sc_vec3 middle_mm; /* the sphere around the volume */
    double radius_mm;
    sc_srgb_table srgb;
    float background[3];    /* linear */
    uint8_t empty[3];       /* the same, as a pixel */
    sc_render_stats *stats; /* [threads]; of the frame in work */
    sc_render_span *spans;  /* [threads] */
    sc_glimpse *glimpses;   /* [threads][(tile + 2)^2]: a tile within a frame of one pixel */
};

/* What all rays of a view share. Vectors: per mm, in voxels. */
typedef struct sc_lens {
    const sc_renderer *renderer;
    const sc_scene *scene;
    double px_scale; /* from pixels to the units of the camera's half_height */
    double middle_px[2], shift;
    bool from_eye;
    sc_vec3 eye, forward, right, up;
} sc_lens;

void sc_lens_init(sc_lens *lens, const sc_renderer *r, const sc_scene *scene,
                  const sc_viewport *viewport);
/* A ray through a point of the viewport, in pixels from its upper left corner. @return false if it
 * meets nothing. */
bool sc_make_ray(const sc_lens *lens, double x_px, double y_px, sc_ray *ray);

/* Find the blocks, from the masks. */
sc_status sc_find_blocks(const sc_ctx *ctx, sc_renderer *r);
/* @p cells: room for them, borrowed by @p cover. */
void sc_cover_init(sc_cover *cover, const sc_renderer *r, const sc_scene *scene,
                   const sc_viewport *viewport, uint8_t *cells);

static inline bool sc_is_covered(const sc_cover *cover, int x_px, int y_px)
{
    return cover->cells[((y_px >> cover->shift) + 1) * cover->columns + (x_px >> cover->shift) + 1];
}

#endif
