/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to render: what its files share. */
#ifndef SC_RENDER_INTERNAL_H
#define SC_RENDER_INTERNAL_H

#include "segcast/render.h"

/* What the ray through the middle of a pixel has seen, and the colour the pixel gets. */
typedef struct sc_pixel_state {
    float rgb[3];  /* linear, composited over the background */
    float tone[3]; /* square root of rgb: differences of it are nearly those the eye sees */
    float normal[3];
    uint32_t label, signature;
    bool nothing; /* nothing but background was seen */
    bool
        sampled; /* rgb is the sum over the rays of the pixel of what each adds to the background */
} sc_pixel_state;

/* Middle, in voxels, of a block of bricks that holds something visible. */
typedef struct sc_block {
    float x, y, z;
} sc_block;

/* Which pixels of a view can show anything: a map of squares of pixels, with one more row and
 * column of squares on every side of the view. */
enum {
    SC_COVER_SIDE = 512 /* at most this many squares along a side of the map */,
    SC_COVER_SHIFT = 3
};
typedef struct sc_cover {
    int columns, rows, shift; /* squares of 2^shift pixels */
    const uint8_t *squares;   /* [rows][columns], 1 where something may be seen */
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
    bool covers_all; /* the map is of no use: any pixel may show something; see decide_cover() */
    uint8_t *cover;  /* room for the squares of a map: [SC_COVER_SIDE][SC_COVER_SIDE] */
    sc_cover last_cover; /* the map in that room, which the bands of one frame share ... */
    sc_scene last_scene; /* ... and what it is a map of */
    sc_viewport last_viewport;
    sc_vec3 *hull;
    size_t hull_count;
    sc_box3 hull_box; /* in mm */
    sc_affine to_voxel;
    sc_box3 box;       /* in voxels: the box that rays are marched within */
    sc_vec3 middle_mm; /* middle and radius of the sphere around the volume */
    double radius_mm;
    sc_srgb_table srgb;
    float background[3];    /* linear */
    uint8_t empty[3];       /* the background as a pixel, sRGB */
    sc_render_stats *stats; /* [threads], of the present frame */
    sc_render_span *spans;  /* [threads] */
    sc_pixel_state *pixels; /* [threads][(tile + 2)^2]: a tile within a frame of one pixel */
};

/* What all rays of a view share. Its vectors are in voxels: the eye's position, and directions per
 * mm. */
typedef struct sc_lens {
    const sc_renderer *renderer;
    const sc_scene *scene;
    double px_scale; /* from pixels to the unit of sc_camera.half_height */
    double middle_px[2];
    double shift;  /* from voxels to the coordinates of sc_ray.origin */
    bool from_eye; /* rays begin at the eye; else where they enter the sphere around the volume */
    sc_vec3 eye, forward, right, up;
} sc_lens;

void sc_lens_init(sc_lens *lens, const sc_renderer *r, const sc_scene *scene,
                  const sc_viewport *viewport);
/* Make the ray through a point of the viewport, in pixels from its upper left corner. @return false
 * if no part of it is kept within the sphere around the volume. */
bool sc_make_ray(const sc_lens *lens, double x_px, double y_px, sc_ray *ray);

/* Find the blocks that hold something visible, from the masks. */
sc_status sc_find_blocks(const sc_ctx *ctx, sc_renderer *r);
/* Make the map of a view. @param squares room for it: [SC_COVER_SIDE][SC_COVER_SIDE], borrowed by
 * the map. */
void sc_cover_init(sc_cover *cover, const sc_renderer *r, const sc_scene *scene,
                   const sc_viewport *viewport, uint8_t *squares);

/* Can the pixel show anything? */
static inline bool sc_is_covered(const sc_cover *cover, int x_px, int y_px)
{
    return cover
        ->squares[((y_px >> cover->shift) + 1) * cover->columns + (x_px >> cover->shift) + 1];
}

#endif
