/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to render: what its files share. */
#ifndef SC_RENDER_INTERNAL_H
#define SC_RENDER_INTERNAL_H

#include "gather.h"
#include "segcast/render.h"
#include "sky.h"

/* What the ray through the middle of a pixel has seen, and what its other rays add. A tone is the
 * square root of linear light, over the background (over black, if there is none): differences of
 * it are nearly those the eye sees. Normal, label and signature are those of sc_radiance. */
typedef struct sc_pixel_state {
    float tone[3];
    float added[3]; /* if sampled: the sum of what each ray of the pixel adds to the background */
    float cover;    /* without a background: share of what lies behind the picture that is hidden */
    float added_cover; /* if sampled: the sum of that of each ray */
    float normal[3];
    uint32_t label, signature;
    bool nothing; /* nothing but background was seen */
    bool sampled; /* the pixel has several rays */
} sc_pixel_state;

/* What the rays of a pixel have seen from all over the aperture: sums over them of linear light and
 * of the share of what lies behind the picture that they hide, and the least and the greatest of
 * their tones and of that share. */
typedef struct sc_blurred_pixel {
    float light[3], cover;
    float low[4], high[4];
    int rays; /* how many there were */
} sc_blurred_pixel;

enum { SC_LENS_BLOCK = 4 /* edge of a square of pixels whose samples are points of one net */ };
/* Where a ray of a picture with an aperture goes: a point in the pixel, and one in the square
 * around the aperture, each in 2^-16 of the edge. */
typedef struct sc_lens_sample {
    uint16_t at[4];
} sc_lens_sample;

/* What of a tissue changes from frame to frame, as it is when it does not. */
typedef struct sc_full_look {
    double opacity, interior_opacity;
    float rgb[3];  /* linear */
    uint8_t show;  /* SC_SHOW_* */
    uint8_t group; /* as of sc_tissue.fade_group */
    uint8_t clip_set;
} sc_full_look;

/* How tissues fade. Owns mixed; the arrays of filled belong to the team, base to it or to the
 * volume. */
typedef struct sc_fades {
    bool are_set;             /* the tissues of the march may be other than their full looks */
    int groups;               /* how many: the highest number of a group; 0: nothing fades */
    const uint8_t (*base)[2]; /* sc_occlusion.filled with every tissue as it is ... */
    const uint8_t (*filled[SC_FADE_GROUPS_MAX])[2]; /* ... and of what each group adds to it */
    uint8_t (*mixed)[2];                   /* what is left of the base; NULL without occlusion */
    int mixed_weights[SC_FADE_GROUPS_MAX]; /* what of each group is taken away in mixed, 256ths */
} sc_fades;

/* A box in which something is visible: a block of bricks, or what of a brick is visible. */
typedef struct sc_block {
    float x, y, z;      /* its middle, in voxel coordinates */
    uint8_t extents[4]; /* along x, y, z, in voxels; then nothing */
} sc_block;

enum {
    SC_COVER_SIDE = 512 /* at most this many squares along a side of the map */,
    SC_COVER_SHIFT = 2 /* squares have an edge of 2^2 pixels, or more if they would be too many */
};
/* Which pixels of a view can show anything, and not nearer than where: a map of squares of pixels,
 * with one more row and column of squares on every side of the view. */
typedef struct sc_cover {
    int columns, rows, shift; /* squares of 2^shift pixels */
    const uint8_t *squares;   /* [rows][columns], 0 where nothing can be seen, else a level: nothing
                                 is met nearer than it is from the eye; borrowed */
    double near_mm, level_mm; /* the distance from the eye of level 1, and from a level to the next;
                                 both 0 if no distances are known */
} sc_cover;

/* The floor, and its grid of points, a square: see floor.c. */
typedef struct sc_floor {
    bool is_shown;           /* in the present view */
    double radius_mm;        /* of the curve in which it rises behind the body; 0: it does not */
    double foot_mm;          /* where that begins: RAS y */
    sc_vec3 middle;          /* of the grid, RAS mm */
    double half_mm;          /* half of its edge */
    const float (*light)[3]; /* [SC_FLOOR_SIDE][SC_FLOOR_SIDE] share of the light that there would
                                be without tissues; borrowed from gather */
} sc_floor;

/* What is derived from the volume for its tissues. The team holds it, down to the cells, unless it
 * is borrowed from volume->stored. */
typedef struct sc_derived {
    const uint64_t *visible;  /* masks of sc_visible_masks (voxel) or sc_visible_cells (smooth) */
    const uint8_t *distances; /* SC_SKIP_LEAP only, else NULL */
    sc_pyramid pyramid;       /* SC_SKIP_OCTREE only, else empty; its masks are those of visible */
    uint8_t *cell_distances;  /* SC_SKIP_PROXIMITY and SC_SKIP_CHESSBOARD only, else NULL */
    const uint32_t *cell_start;  /* as of sc_cells: smooth and wide kernels only, else NULL */
    const sc_packed_cell *cells; /* the same */
    sc_occlusion occlusion;      /* empty if the light does without; see also sc_renderer.fades */
    bool shows_inner;            /* surfaces between two tissues can be seen */
} sc_derived;

/* Where anything can be visible; the team holds both arrays. */
typedef struct sc_bounds {
    sc_block *blocks; /* [block_count] */
    size_t block_count;
    bool has_tight_blocks; /* blocks are boxes around what is visible in each brick: many more, but
                              fewer rays miss. So it is with parts, whose edges are longer */
    const sc_vec3 *hull;   /* [hull_count], see sc_renderer_hull */
    size_t hull_count;
    sc_box3 hull_box; /* in mm */
} sc_bounds;

/* The map of a view, which the bands of one frame share. */
typedef struct sc_kept_cover {
    uint8_t *squares; /* room for them: [SC_COVER_SIDE][SC_COVER_SIDE]; owned */
    sc_cover map;     /* the one in that room, and what it is a map of */
    sc_scene scene;
    sc_viewport viewport;
    bool covers_all; /* the map is of no use: any pixel may show something; see sc_decide_cover() */
} sc_kept_cover;

/* The volume in space. */
typedef struct sc_volume_space {
    sc_affine to_voxel; /* from RAS mm to voxel coordinates */
    sc_box3 box;        /* in voxels: the box that rays are marched within */
    sc_vec3 middle_mm;  /* middle and radius of the sphere around the volume */
    double radius_mm;
} sc_volume_space;

/* The grey volume of the settings. */
typedef struct sc_grey_march {
    sc_march_grey march;
    sc_march_backdrop backdrop; /* for the present view, if its look has one */
    sc_backdrop_fn *follow_backdrop;
    sc_affine to_grey; /* from RAS mm to its voxels */
    bool is_behind;    /* the present view shows it behind the tissues, in any pixel */
} sc_grey_march;

/* Light from all around. */
typedef struct sc_light_around {
    sc_sky sky;                  /* owned */
    bool traces;                 /* light comes by paths, where the view allows: sc_traces_paths */
    sc_march traced;             /* what paths march through, of the present view */
    uint32_t (*path_numbers)[2]; /* as of sc_path_numbers_make; NULL: no paths are traced; owned */
    sc_gather *gather;           /* NULL: light from all around is not gathered; owned */
    sc_floor floor;
} sc_light_around;

/* What rays are blended with behind all tissues, in the present view. */
typedef struct sc_behind {
    sc_march on_white; /* without a background, and if the far end fades: march, fading to white */
    float tone[3];     /* of the background, black if there is none: the square roots of linear
                          light, with which rays are blended */
    uint8_t empty[4];  /* the background as a pixel, sRGB, or as one of alpha 0 */
} sc_behind;

/* Memory in which threads draw; owned, but pixels may be those of settings.lender. */
typedef struct sc_thread_room {
    sc_render_stats *stats;       /* [threads], of the present frame */
    sc_render_span *spans;        /* [threads] */
    sc_pixel_state *pixels;       /* [threads][(tile + 2)^2]: a tile within a frame of one pixel */
    sc_blurred_pixel *blurred;    /* the same of pictures with an aperture, else NULL */
    sc_lens_sample *lens_samples; /* [SC_LENS_BLOCK^2][settings.lens_samples]: of each pixel of a
                                     square of them; NULL if there are none */
} sc_thread_room;

/* Owns what its pointers point to, except the volume and the kernel. */
struct sc_renderer {
    sc_render_settings settings;
    bool hurries;              /* see sc_renderer_hurry */
    const sc_prepared *volume; /* borrowed */
    const sc_kernel *kernel;   /* of the constant table */
    sc_march march;            /* points to the members below; light, background, depth cue and clip
                                  planes are set for each view */
    sc_march_tissue *tissues;  /* [label_count] */
    sc_full_look *looks;       /* [label_count] */
    bool colors_are_set;       /* the colours of tissues may be other than those of looks */
    sc_fades fades;
    struct sc_parts *parts; /* NULL: no tissue moves */
    sc_team *team;
    sc_derived derived;
    sc_bounds bounds;
    sc_volume_space space;
    sc_grey_march grey;
    sc_light_around light;
    sc_behind behind;
    sc_kept_cover cover;
    sc_srgb_table srgb; /* from linear light to levels of a pixel */
    sc_thread_room room;
};

/* @return whether what is being drawn is to be given up: see sc_render_settings. */
static inline bool sc_is_given_up(const sc_renderer *r)
{
    return r->settings.work.give_up && *r->settings.work.give_up;
}

/* What all rays of a view share. Its vectors are in voxels: the eye's position, and directions per
 * mm. */
typedef struct sc_lens {
    const sc_renderer *renderer;
    const sc_scene *scene;
    double px_scale;     /* from pixels to the unit of sc_camera.half_height */
    double middle_px[2]; /* of the viewport */
    double shift;        /* from voxels to the coordinates of sc_ray.origin */
    bool from_eye; /* rays begin at the eye; else where they enter the sphere around the volume */
    sc_vec3 eye, forward, right, up;
} sc_lens;

/* Fill in the lens of one view. Renderer and scene stay borrowed as long as it is used, the
 * viewport does not. */
void sc_lens_init(sc_lens *lens, const sc_renderer *r, const sc_scene *scene,
                  const sc_viewport *viewport);
/* Where a ray begins and where it goes: from a point of the aperture, as shares of its radius to
 * the right and up (0 without one), through a point of the viewport, in pixels from its upper left
 * corner. */
typedef struct sc_aim {
    double x_px, y_px, right, up;
    int number; /* of the ray among those of its square of SC_LENS_BLOCK pixels, if it has many */
} sc_aim;

/* Where and which way a ray of a picture looks. */
typedef struct sc_sight {
    double aside[2]; /* from the eye to its beginning, to the right and up, in mm */
    /* its direction along those of the camera, not of unit length in a perspective view */
    double across, upward, ahead;
    double shorten;            /* what makes it a unit vector */
    sc_vec3 eye_mm, direction; /* its beginning and direction, RAS; direction of unit length */
} sc_sight;

/* @return the line of sight of a ray. */
sc_sight sc_line_of_sight(const sc_lens *lens, const sc_aim *aim);
/* A ray that may begin anywhere. */
typedef struct sc_line {
    sc_vec3 from_mm, direction; /* RAS; direction of unit length */
    float ends_below;           /* as of sc_ray */
} sc_line;

/* Fill in *@p ray: origin, direction and the parts that each clip set keeps. @return false if no
 * part of it is kept within the sphere around the volume; *@p ray must then not be marched. */
bool sc_make_ray(const sc_lens *lens, const sc_aim *aim, sc_ray *ray);
/* The same for a line. */
bool sc_make_ray_from(const sc_lens *lens, const sc_line *line, sc_ray *ray);

/* Set r->grey from the settings, if they have a grey volume. @return SC_ERR_DATA if its geometry is
 * singular. */
sc_status sc_fill_grey(const sc_ctx *ctx, sc_renderer *r);
/* Derive from the grey volume what its backdrop is drawn from, if any frame shows one: sets
 * r->grey.backdrop, but for what depends on the view. Collective in r->team. @return SC_ERR_MEMORY.
 */
sc_status sc_find_backdrop(const sc_ctx *ctx, sc_renderer *r);
/* Set what of the grey volume the pictures of a scene show: in r->march, and r->grey.is_behind. */
void sc_set_grey(sc_renderer *r, const sc_scene *scene);
/* Put the grey volume, a slice of it or the backdrop, behind what the rays of a view bring back, if
 * r->grey.is_behind. @param aims, light [count] of the rays. */
void sc_put_grey_behind(const sc_lens *lens, const sc_aim *aims, size_t count, sc_radiance *light);
/* Is anything seen behind the tissues, in any pixel of the present view? */
static inline bool sc_shows_behind(const sc_renderer *r)
{
    return r->grey.is_behind || r->light.floor.is_shown;
}

/* Place the floor below all that is visible. */
void sc_floor_place(sc_renderer *r);
/* @return whether a line of sight meets the floor from above: sets *at, RAS mm, and the normal
 * there. */
bool sc_floor_meets(const sc_floor *f, const sc_sight *sight, sc_vec3 *at, double normal[3]);
/* Put a point of the floor, with a share of its light, behind what a ray brings back. */
void sc_floor_show(const sc_renderer *r, const float share[3], sc_radiance *light);
/* Put the floor behind what the rays of a view bring back, by light that was gathered. */
void sc_put_floor_behind(const sc_lens *lens, const sc_aim *aims, size_t count, sc_radiance *light);

enum {
    SC_RAY_BATCH = 256,   /* rays that are marched together */
    SC_APART_BATCH = 1024 /* rays that are followed through parts together: few of them meet each
                             part, and they should fill the SIMD lanes */
};

/* What a thread needs to follow a batch of rays through the parts. */
typedef struct sc_part_room {
    /* of those that are marched next, through one part */
    sc_ray rays[SC_RAY_BATCH];
    sc_way part_ways[SC_RAY_BATCH],
        again[SC_RAY_BATCH]; /* again: for a march that fades to white */
    sc_radiance light[SC_RAY_BATCH];
    uint32_t target[SC_RAY_BATCH]; /* the index of each in the batch */
    /* by index */
    sc_radiance
        white[SC_APART_BATCH];      /* what the rays bring back where the far end fades to white */
    uint64_t left[SC_APART_BATCH];  /* the parts, as bits, that they may still meet ... */
    uint64_t known[SC_APART_BATCH]; /* ... and those whose next surface has been found: of the
                                       others the ways have a bound */
    int8_t part[SC_APART_BATCH];    /* of the surface that they have passed last; -1: none */
    uint8_t turns[SC_APART_BATCH];  /* how often that has been another part than before */
    int after[SC_APART_BATCH];      /* the next ray that waits for the same part; -1: none */
    sc_way *ways;                   /* [parts][SC_APART_BATCH] */
} sc_part_room;

/* A part: tissues that move together, which are drawn as if there were no others. */
typedef struct sc_part {
    sc_renderer *renderer; /* of these tissues alone; NULL: there are none. It borrows the team and
                              what does not depend on the tissues */
    int label;             /* one of its tissues, dense id */
    double amount;         /* of its tissues: the sum of opacity times voxels */
    const uint8_t (*filled)[2]; /* what it fills of the occlusion by itself; of the team */
    uint8_t (*mixed)[2];        /* what is left of the occlusion of all, and its own; owned */
    int mixed_weights[2 + SC_FADE_GROUPS_MAX]; /* by which it was mixed */
    /* of the present view */
    bool is_shown;
    sc_scene scene; /* with the camera as it stands to the tissues where they are in the volume */
    sc_lens lens;
    sc_cover cover; /* a copy of renderer->cover.map */
} sc_part;

/* The parts of the tissues. Owns what its pointers point to, unless they say otherwise. */
typedef struct sc_parts {
    int count;                  /* of list: the highest number of a part, plus 1 */
    sc_part list[SC_PARTS_MAX]; /* by sc_tissue.part */
    sc_part_room *rooms;        /* [threads] */
    sc_way *ways;               /* [threads][count][SC_APART_BATCH] */
    uint64_t *met;              /* room for a map: [SC_COVER_SIDE][SC_COVER_SIDE] */
    /* of the present view */
    bool are_apart;  /* some part is moved: rays are followed through each */
    sc_cover layout; /* that of the maps of all parts; its squares are those of the whole */
    int shown_count;
    int shown[SC_PARTS_MAX]; /* [shown_count]: those to draw, the nearest first. In their maps taken
                                together, met holds the parts of each square, as bits */
} sc_parts;

/* Make the parts of the tissues, if any can move: sets r->parts. What does not depend on them is
 * that of @p r, which is complete but for this. Collective in r->team. @return SC_ERR_MEMORY; what
 * has been made stays with the renderer. */
sc_status sc_parts_make(const sc_ctx *ctx, sc_renderer *r, const sc_tissue *tissues);
/* Free r->parts, unless it is NULL. */
void sc_parts_free(sc_renderer *r);
/* Set the colours of r->tissues. @param colors as of sc_scene.colors. */
void sc_set_colors(sc_renderer *r, const float (*colors)[3]);
/* Set the clip sets of r->tissues: sets that are the same in the scene become one, so that seams of
 * tissues which the same planes cut are smooth even if others cut them in other frames. */
void sc_set_clip_sets(sc_renderer *r, const sc_scene *scene);
/* @return bytes of memory that the rank has for itself because of the parts. */
uint64_t sc_parts_bytes(const sc_renderer *r);
/* Set all parts up for a view, for which @p r has been set up, if any is moved: what of r->parts
 * depends on the view. */
void sc_parts_begin(sc_renderer *r, const sc_scene *scene, const sc_viewport *viewport);
/* Does a view show parts that are moved? */
static inline bool sc_parts_apart(const sc_renderer *r)
{
    return r->parts && r->parts->are_apart;
}

/* March @p count rays, at most SC_RAY_BATCH. Without a background, where the far end fades, what
 * fades lets through what is behind the picture. @param white room for [count]. @param counters is
 * added to. */
void sc_march_rays(const sc_renderer *r, const sc_ray *rays, size_t count, sc_radiance *out,
                   sc_radiance *white, sc_march_counters *counters);
/* The same for rays of a view whose parts are apart: what a ray meets in them is blended in its
 * order along the ray. @param aims [count] of the rays, at most SC_APART_BATCH. @param lines NULL;
 * or [count], in place of aims: through r->light.traced. @param thread whose room is used. */
void sc_march_apart(const sc_renderer *r, const sc_aim *aims, const sc_line *lines, size_t count,
                    int thread, sc_radiance *out, sc_march_counters *counters);

/* Does the far end fade into a background that is not there? */
static inline bool sc_fades_away(const sc_renderer *r)
{
    return r->settings.transparent && r->march.light.cue > 0;
}

/* Set r->tissues and r->looks from @p tissues, and for each label (dense id) what of it is shown in
 * @p show and, if anything, its opacity in @p opacity, else 0. Background is never shown. */
void sc_fill_tissues(sc_renderer *r, const sc_tissue *tissues, uint8_t *show, float *opacity);
/* Set the sphere around the volume, and the box that rays are marched within: for SC_SKIP_NONE the
 * whole volume, else the bounding box of what is visible.
 * That is a voxel wider than the last cell that matters, so that it ends within none of these.
 * r->tissues has been filled. */
void sc_fill_boxes(sc_renderer *r);
/* Set r->cover.covers_all: true if the map of pixels that can show anything must not be used. The
 * map holds all pixels behind which the masks mark something: a boundary, if boundaries are shown,
 * for every visible tissue ends somewhere. It must not be used for tissues that show only their
 * interior, because a cut face may show a part of them that is not marked; nor for SC_SKIP_NONE,
 * which uses nothing that preprocessing has found. */
void sc_decide_cover(sc_renderer *r);
/* Derive from the volume which cells or voxels are visible and what follows from them: masks,
 * packed cells, and what the skip method knows. @param show [label_count] what of each label is
 * shown. Collective in r->team. @return SC_ERR_MEMORY; what has been set stays with the renderer.
 */
sc_status sc_find_visible(const sc_ctx *ctx, sc_renderer *r, const uint8_t *show);
/* Set r->cover.map to the map of a view, unless it is that already. */
void sc_cover_view(sc_renderer *r, const sc_scene *scene, const sc_viewport *viewport);

/* Alpha of one crossing or sample of an opacity, 0 to 1. Opacity is given per crossing of a
 * smooth surface, but per voxel length for the voxel surface, which takes samples step_voxels
 * apart. */
static inline float sc_alpha_of(const sc_render_settings *s, double opacity)
{
    return s->surface == SC_SURFACE_SMOOTH ? (float)opacity
                                           : (float)(1 - pow(1 - opacity, s->step_voxels));
}

/* Find what each group of tissues that fade alike adds to the occlusion: sets r->fades, from
 * r->looks and r->derived.occlusion. Collective in r->team. @return SC_ERR_MEMORY. */
sc_status sc_find_fades(const sc_ctx *ctx, sc_renderer *r);
/* Set what of the tissues a scene says: how far they have faded, their colours, what cuts them. */
void sc_begin_tissues(sc_renderer *r, const sc_scene *scene);
/* Set light, background, clip planes and the width of rims in r->march, for a picture of @p
 * height_px that shows
 * @p scene. */
void sc_begin_scene(sc_renderer *r, const sc_scene *scene, int height_px);
/* Set what of r->tissues, of the march and of the occlusion depends on how far tissues have faded.
 * @param factors as of sc_scene.fades. */
void sc_set_fades(sc_renderer *r, const float *factors);
/* @return bytes of memory that the rank has for itself because of the fades. */
uint64_t sc_fades_bytes(const sc_renderer *r);

/* Find the blocks that hold something visible, from r->derived.visible: sets r->bounds.blocks and
 * r->bounds.block_count. Collective in r->team. @return SC_ERR_MEMORY. */
sc_status sc_find_blocks(const sc_ctx *ctx, sc_renderer *r);

/* The index in the map of the square of a pixel, which is one of the viewport, or of a border as
 * wide as a square around it. */
static inline int sc_cover_square(const sc_cover *cover, int x_px, int y_px)
{
    return ((y_px >> cover->shift) + 1) * cover->columns + (x_px >> cover->shift) + 1;
}

#endif
