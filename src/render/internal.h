/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to render. */
#ifndef SC_RENDER_INTERNAL_H
#define SC_RENDER_INTERNAL_H

#include "segcast/render.h"

/* What a ray through the middle of a pixel has seen. */
typedef struct sc_glimpse {
    float rgb[3]; /* linear, over the background */
    float normal[3];
    uint32_t label, signature;
} sc_glimpse;

struct sc_renderer {
    sc_render_settings settings;
    const sc_prepared *volume;
    const sc_kernel *kernel;
    sc_march march;
    sc_march_tissue *tissues;
    uint64_t *visible;
    uint8_t *distances;
    sc_occlusion occlusion;
    sc_vec3 *hull;
    size_t hull_count;
    sc_box3 hull_box; /* in mm */
    sc_affine to_voxel;
    sc_box3 whole, box; /* in voxels: the volume; what the kernel has to look at */
    sc_srgb_table srgb;
    float background[3];    /* linear */
    sc_render_stats *stats; /* [threads]; of the frame in work */
    sc_glimpse *glimpses;   /* [threads][(tile + 2)^2]: a tile within a frame of one pixel */
};

/* A ray through a point of the viewport, in pixels from its upper left corner. @return false if it
 * meets nothing. */
bool sc_make_ray(const sc_renderer *r, const sc_scene *scene, const sc_viewport *viewport,
                 double x_px, double y_px, sc_ray *ray);

#endif
