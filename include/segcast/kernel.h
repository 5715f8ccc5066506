/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  The ray march, as a table of kernels: functions that follow rays through a prepared volume and
 *  return the light that comes along them. A kernel allocates nothing, reads no files and uses
 *  neither threads nor MPI. The plain C kernels of SC_SKIP_NONE are the specification: every other
 *  kernel, for whatever instruction set, must return the same bits.
 *
 *  Grid coordinates: grid vertex (x, y, z) lies at x, y, z, and the centre of voxel v at v + 1,
 *  because the label grid is one vertex wider than the volume on every side. */
#ifndef SEGCAST_KERNEL_H
#define SEGCAST_KERNEL_H

#include "segcast/scene.h"

typedef enum sc_surface {
    SC_SURFACE_VOXEL, /**< samples along the ray take the label of the nearest voxel (paper) */
    SC_SURFACE_SMOOTH /**< interfaces lie where another label gets the largest trilinear vote */
} sc_surface;

typedef enum sc_skip {
    SC_SKIP_NONE, /**< every sample or cell is classified from the labels alone (paper: plain) */
    SC_SKIP_INTERIOR, /**< only those that preprocessing has marked are (paper: accelerated) */
    /* The rest are wide: the same, many rays side by side, with steps across empty space. */
    SC_SKIP_OCTREE,     /**< by a pyramid of binary volumes (Levoy 1990) */
    SC_SKIP_PROXIMITY,  /**< by city-block distances of cells (Cohen and Sheffer 1994) */
    SC_SKIP_CHESSBOARD, /**< by chessboard distances of cells (Sramek 1994) */
    SC_SKIP_LEAP        /**< by chessboard distances of bricks */
} sc_skip;

/** @return whether the kernels of a skip method are wide: they follow many rays side by side, and
 *  there is one for each variant. */
static inline bool sc_skip_is_wide(sc_skip skip)
{
    return skip > SC_SKIP_INTERIOR;
}

/** @return whether a skip method needs sc_marked.cell_distances. */
static inline bool sc_skip_has_cell_distances(sc_skip skip)
{
    return skip == SC_SKIP_PROXIMITY || skip == SC_SKIP_CHESSBOARD;
}

/** What a kernel knows of a label. Opacities (alpha) and the weights of the light are 0 to 1. */
typedef struct sc_march_tissue {
    float rgb[3];           /**< linear light */
    float boundary_alpha;   /**< of one crossing (smooth) or one sample (voxel) */
    float interior_alpha;   /**< of one sample; voxel only */
    float cap_alpha;        /**< opacity of a cut face, 0 to 1: below 1 only while the tissue fades,
                                 and 0 if it is not shown at all */
    float thickness_factor; /**< with by_thickness: what sc_march.thickness_alpha is multiplied by:
                                 1, but less or more while the tissue fades */
    float specular;         /**< weight of the highlight, and its exponent */
    int shininess;
    float face, roughness, coat; /**< for paths: strength of the highlight of the face, width of its
                                      facets, above 0, to 1, and share that is coated */
    uint8_t show;                /**< SC_SHOW_* */
    uint8_t clip_set;            /**< index into sc_ray.parts: which clip planes cut the tissue */
    bool by_thickness; /**< alpha follows the local thickness: see sc_march.thickness_alpha */
} sc_march_tissue;

/** The light of a frame. Directions are unit vectors in RAS, towards the light. */
typedef struct sc_march_light {
    bool flat; /**< unlit: surfaces have plain colours without shading and depth cue; edges still
                    applies to them, and the depth cue to cut faces */
    float key_direction[3], fill_direction[3];
    float ambient, key, fill, head; /**< intensities: from everywhere, from the key light, from the
                                         fill light, and from the eye */
    float sky;                      /**< intensity of the sky; 0: no light is gathered */
    bool has_map; /**< a picture of all directions stands in place of the sky: then the light of
                     all of it on a surface, of intensity 1, is for each component the first
                     number of around, and the normal times the others */
    float around[3][4];
    float lamp;      /**< intensity of the lamp that stands to the volume, gathered */
    float lamp_mm;   /**< the light from the eye falls off with the square of the distance, beyond
                        about so much: to a half there. What it throws back, as ambient light, falls
                        off   with the distance. 0: neither does */
    float edges;     /**< 0 to 1: how much more opaque a surface gets when seen from the side */
    float occlusion; /**< 0 to 1: how dark places enclosed by tissue get */
    float shadow;    /**< 0 to 1: how dark the shadows of the key light are; 0: it casts none */
    float cue;       /**< 0 to 1: share of the background colour at cue_far_mm and beyond */
    float cue_near_mm,
        cue_far_mm;   /**< distances from the eye between which that share grows from 0 */
    float cue_rgb[3]; /**< the background, linear */
} sc_march_light;

/** The sky, which is fixed to the volume: its radiance in a direction whose cosine with the
 * superior one is u is SC_SKY_MEAN + SC_SKY_UP u, times the intensity of the frame. */
#define SC_SKY_MEAN 0.7f
#define SC_SKY_UP 0.6f
/** Light as an integer: each component as a square root in 1023rds of SC_AROUND_ROOT, from the
 * lowest bits on. */
#define SC_AROUND_ROOT 1.5f
enum { SC_AROUND_BITS = 10, SC_AROUND_MASK = 1023 };

/** @return linear light, packed. */
static inline uint32_t sc_around_pack(const float rgb[3])
{
    uint32_t packed = 0;

    for (int i = 0; i < 3; i++) {
        const float root =
            sqrtf(rgb[i] > 0 ? rgb[i] : 0) * (SC_AROUND_MASK / SC_AROUND_ROOT) + 0.5f;

        packed |= (root < SC_AROUND_MASK ? (uint32_t)root : SC_AROUND_MASK) << SC_AROUND_BITS * i;
    }
    return packed;
}

enum { SC_GREY_STEPS = 256 /**< of the table from a place in a window to a tone */ };

/** A grey volume (CT, MR) that colours cut faces, sampled trilinearly between the centres of its
 *  voxels. The caller owns the codes. */
typedef struct sc_march_grey {
    const uint16_t *codes;   /**< as of sc_grey */
    int size[3];             /**< voxels along x (fastest), y, z */
    float from_grid[3][4];   /**< grid coordinates of the labels -> voxel of the grey volume */
    float black, white_less; /**< place in the window: (code - black) * white_less, 0 black to 1 */
    float tones[SC_GREY_STEPS + 1]; /**< square roots of linear light, of black to white */
} sc_march_grey;

enum { SC_BACKDROP_STEPS = 1024 /**< of the tables from a place in a window */ };

/** A grey volume as a translucent volume: a sample is taken in the middle of each step along a ray,
 *  the last of which is shorter. The caller owns what the pointers point to. */
typedef struct sc_march_backdrop {
    const sc_march_grey *grey; /**< its from_grid and tones are not read */
    float step_mm;
    /** Two tables over the window, from its lower end to its upper one; a value of the image takes
     *  the nearest entry. alphas: the opacity of one step, 0 to 1. tones: the light that one step
     *  adds, which is its opacity times the square root of linear light. Both begin with 0. */
    float alphas[SC_BACKDROP_STEPS + 1], tones[SC_BACKDROP_STEPS + 1];
    float cue;         /**< most share, 0 to 1, in which the depth cue replaces the backdrop by what
                            is behind the picture */
    float cue_near_mm; /**< distance from the eye up to which that share is 0 */
    float cue_per_mm;  /**< 1 / the mm beyond that in which the share rises from 0 to cue */
    const uint8_t *distances; /**< sc_brick_distances of the bricks that hold 4 x 4 x 4 cells
                                 between centres of voxels; those are empty in which no place in the
                                 window is above 0 at any point. Wide kernels only */
    int bricks[3];            /**< along x, y, z */
} sc_march_backdrop;

/** One ray through a backdrop. */
typedef struct sc_backdrop_ray {
    float origin[3];              /**< in voxels of the grey volume */
    float direction[3];           /**< in voxels per mm */
    float base_mm;                /**< distance of the origin from the eye */
    int stretches;                /**< 0 to 2: how many parts of the ray the clip planes leave */
    float begin_mm[2], end_mm[2]; /**< of each, in order along the ray, from its origin */
} sc_backdrop_ray;

/** What a ray through a backdrop brings back. */
typedef struct sc_backdrop_light {
    float tone;          /**< square root of linear light, times the opacity */
    float transmittance; /**< share of what is behind the picture that is seen */
} sc_backdrop_light;

/** A ray is opaque when its transmittance is below this: what is still behind would change a pixel
 * by less than a quarter of a level of 8 bits, and is not blended. */
#define SC_OPAQUE (1.0f / 1024)

/** Which voxels or cells are marked, since something can be seen in them, and how far rays may leap
 *  where none is. All pointers are borrowed. Kernels of SC_SKIP_NONE do not read it. */
typedef struct sc_marked {
    const uint64_t *masks; /**< of sc_visible_masks (voxel) or sc_visible_cells (smooth).
                                SC_SKIP_OCTREE: followed by the upper levels of the pyramid, see
                                sc_pyramid_build */
    int row, layer;        /**< steps in the array of masks from a brick to the next along y, z */
    const uint8_t *distances;      /**< sc_brick_distances of the masks; SC_SKIP_LEAP only */
    const sc_pyramid *pyramid;     /**< of the masks; SC_SKIP_OCTREE only */
    const uint8_t *cell_distances; /**< sc_cell_distances of the masks, by the method's metric;
                                        SC_SKIP_PROXIMITY and SC_SKIP_CHESSBOARD only */
    const uint32_t *cell_start;    /**< sc_cells.start of the masks; smooth and wide kernels only */
    const sc_packed_cell *cells;   /**< sc_cells.cells; smooth and wide kernels only */
} sc_marked;

/** The clip planes of a frame. */
typedef struct sc_march_planes {
    bool cut_away; /**< true: only what every plane removes is cut away; false: what any removes */
    int count;
    float normals[SC_PLANES_MAX][3];   /**< RAS, towards what is kept */
    float equations[SC_PLANES_MAX][4]; /**< {a, b, c, d}: the point (x, y, z) in grid coordinates
                                            lies a x + b y + c z + d mm on the kept side */
} sc_march_planes;

/** How cut faces are drawn. */
typedef struct sc_march_cut_faces {
    bool are_drawn; /**< in the colour of their tissue: cap_alpha */
    bool only;      /**< nothing else is drawn: a slice */
    const sc_march_grey
        *grey;        /**< what they show beside their tissue's colour; NULL: nothing; borrowed */
    float grey_share; /**< 0 to 1: of it in their colour */
    float outline;    /**< half the width of the lines between tissues, in voxels; 0: no lines;
                           smooth only */
    float rim_mm, rim_per_mm; /**< how wide the picture asks their dark rims to be: so much, and so
                                   much for each mm from the eye; both 0: as the blur of the
                                   occlusion gives them; smooth only */
} sc_march_cut_faces;

/** What all rays of a frame share. The caller fills it in and owns what the pointers point to;
 *  kernels only read it. */
typedef struct sc_march {
    const sc_prepared *volume;
    sc_marked marked;
    float box_low[3], box_high[3];  /**< in grid coordinates: rays are marched only within this box,
                                         which holds all that can be seen and reaches at most 3
                                         vertices beyond those of the volume */
    const sc_march_tissue *tissues; /**< [label_count of the volume], by dense id */
    float step_mm;                  /**< distance between samples; voxel only */
    sc_march_light light;
    const sc_occlusion *occlusion; /**< NULL: none */
    const uint32_t *around[2]; /**< [count of volume->outer, of volume->inner]: the light from all
                                    around at each vertex that has a record, as of sc_around_pack.
                                    NULL: it is not known, and the sky and the occlusion tell it */
    float around_share; /**< 0 to 1: how much of the light around is told by it where it is known */
    float thickness_alpha[256]; /**< boundary alpha for each code of sc_prepared.thickness */
    float grid_per_mm[3][3];    /**< matrix: RAS vector in mm -> grid coordinates */
    float opaque_below; /**< a ray ends when its transmittance is below this: SC_OPAQUE (early ray
                             termination, Levoy 1990); 0: it goes on to its end, which takes longer
                             and gives the same bits */
    sc_march_cut_faces cut_faces;
    float voxel_mm; /**< mean length of the edges of a voxel */
    sc_march_planes planes;
} sc_march;

/** A part of a ray that the clip planes of one clip set leave. For the voxel surface the samples k
 *  with first <= k < last are kept; sample k lies (k + 1/2) step_mm from the origin. */
typedef struct sc_ray_part {
    float begin_mm, end_mm; /**< from the ray's origin */
    int32_t first, last;    /**< voxel only */
    int8_t cap_plane;       /**< the clip plane at which the part begins; -1: none */
} sc_ray_part;

/** One ray. The caller fills in all that its surface model reads; parts beyond part_count and
 *  clip sets beyond clip_sets are not read. */
typedef struct sc_ray {
    float origin[3];     /**< in grid coordinates; voxel surface: plus 1/2, so that truncation
                              rounds to the nearest vertex */
    float direction[3];  /**< in grid coordinates per mm */
    float toward_eye[3]; /**< unit, RAS */
    float base_mm;       /**< distance of the origin from the eye */
    float ends_below;    /**< 0; or a transmittance, at least SC_OPAQUE: the ray ends at the surface
                              behind which less than that is left, and brings back that surface
                              alone: label, depth and normal, and its colour, in a march that is
                              flat. With a number by chance, from 0 to 1, it is each surface by the
                              share that this hides of what is behind the picture */
    uint8_t clip_sets;   /**< how many there are */
    uint8_t part_count[SC_CLIP_SETS_MAX];   /**< by clip set: 0, 1 or 2 */
    sc_ray_part parts[SC_CLIP_SETS_MAX][2]; /**< by clip set, in order along the ray */
} sc_ray;

/** How far a ray has come that is followed piece by piece, because there is something else along
 * it: it stops before a surface that the caller has not let it pass yet, and goes on from there in
 *  another call, with the bits that it would have without stops. Surfaces in one cell (smooth), and
 *  cut faces at one distance, are passed together: the first of them decides. */
typedef struct sc_way {
    /* set by the caller for each call */
    float before_mm; /**< the next surface is passed only if it is nearer to the eye than this, */
    float limit_mm;  /**< and once one has been passed, each other one only if nearer than this */
    /* set by the call */
    float next_mm; /**< distance from the eye of the surface before which the ray has stopped;
                        HUGE_VALF: it has met all there is, or is opaque, and needs no other call */
    bool passed;   /**< the call has passed a surface */
    /* where to go on; only kernels read it, see sc_way_begin() */
    bool walks;          /**< the ray has stopped within a stretch; else before its cut face */
    int8_t axis;         /**< smooth: axis of the grid plane at t_mm; -1: none */
    float from_mm, t_mm; /**< smooth: end of the stretch before, and the present distance */
    int32_t at[3]; /**< smooth: the present cell; voxel: the present sample, and the one at which
                        the part before ended */
} sc_way;

/** @return the way of a ray that has yet to begin. */
static inline sc_way sc_way_begin(void)
{
    return (sc_way){.axis = -1, .from_mm = -HUGE_VALF, .at = {0, INT32_MIN, 0}};
}

/** What a ray brings back: its light, and which surfaces it met, so that neighbouring rays can be
 *  compared. */
typedef struct sc_radiance {
    float rgb[3];        /**< square roots of linear light, premultiplied */
    float transmittance; /**< share of the light from behind all tissue that gets through */
    float depth_mm;      /**< of the first surface, from the eye; HUGE_VALF: none */
    float normal[3];     /**< of the first surface, unit, RAS, towards the eye */
    uint32_t label;      /**< dense id of the tissue seen first; 0: none */
    uint32_t signature;  /**< hash of the tissues that hide a noticeable share of what is behind, in
                               their order along the ray */
} sc_radiance;

/** @return what a ray that has met nothing brings back. */
static inline sc_radiance sc_no_light(void)
{
    return (sc_radiance){.transmittance = 1, .depth_mm = HUGE_VALF};
}

/** Counts of the work done. They depend on the scene alone, not on threads or time. */
typedef struct sc_march_counters {
    uint64_t rays;        /**< rays marched */
    uint64_t cell_visits; /**< cells (smooth) or samples (voxel) examined */
    uint64_t brick_steps; /**< steps across empty space of more than one cell: across bricks, or
                               what the skip method has instead; wide kernels only */
    uint64_t
        contributions; /**< additions of colour: by crossings (up to two each), samples and caps */
} sc_march_counters;

/** Add every count of @p from to that of @p to. */
static inline void sc_add_counters(sc_march_counters *to, const sc_march_counters *from)
{
    to->rays += from->rays;
    to->cell_visits += from->cell_visits;
    to->brick_steps += from->brick_steps;
    to->contributions += from->contributions;
}

/** March @p count rays, each by itself; cannot fail. @param march with the members that the skip
 *  method and the surface need. @param ways [count], updated: how far the rays have come, and how
 *  far they go; NULL: from their beginnings to their ends. @param out [count], in the order of the
 *  rays: with @p ways added to, in the state in which the call before has left it, or at the
 *  beginning sc_no_light(); else overwritten. @param counters is added to. Threads: any number at
 *  once, each with its own @p ways, @p out and @p counters. */
typedef void sc_march_fn(const sc_march *march, const sc_ray *rays, sc_way *ways, size_t count,
                         sc_radiance *out, sc_march_counters *counters);

/** One kernel of the table. */
typedef struct sc_kernel {
    const char *name; /**< surface/skip, e.g. "smooth/leap" */
    sc_surface surface;
    sc_skip skip;
    const char *cpu; /**< instruction set: one of sc_cpu_names */
    sc_march_fn *march;
} sc_kernel;

/** Names of the variants (instruction sets) of the kernels: "auto", which stands for the best that
 *  this processor can run, then all there are on some processor, best first, plain C ("c") last.
 *  NULL ends the list. Generated from the list in src/kernel/CMakeLists.txt. */
extern const char *const sc_cpu_names[];
/** @return whether this build has the variant @p name, which must not be NULL, and this
 *  processor can run it; true for "auto", false for names that do not exist. */
bool sc_cpu_has(const char *name);
/** @return SC_OK if sc_cpu_has() the variant @p name, which must not be NULL; else SC_ERR_USAGE,
 * with a message that tells whether the build or the processor lacks it. */
sc_status sc_cpu_check(const sc_ctx *ctx, const char *name);
/** Find the kernel for a surface and a skip method: of the variant @p cpu, or, for a method that
 *  has none of it in this build, of the next one in sc_cpu_names that it has. There is only plain C
 *  of SC_SKIP_NONE and SC_SKIP_INTERIOR, for which @p cpu is ignored; AVX2 and plain C of
 *  SC_SKIP_OCTREE, SC_SKIP_PROXIMITY and SC_SKIP_CHESSBOARD, and nothing if SC_RIVALS is off.
 *  @param volume NULL: any that is not too large. @param cpu one of sc_cpu_names; NULL is "auto".
 * @return an entry of a constant table, or NULL if there is none, this processor cannot run @p cpu,
 * or the volume is too large for it: wide kernels address masks and distances by offsets of 31
 * bits, and those of the voxel surface labels and vertex records, too. No message is written. */
const sc_kernel *sc_kernel_find(sc_surface surface, sc_skip skip, const sc_prepared *volume,
                                const char *cpu);
/** The label that owns a point by the rule of the smooth surface: the one with the largest vote;
 *  of equal votes the lowest id. @param point in grid coordinates. @return dense id; 0
 *  (background) outside of the grid. Threads: any number at once. */
uint32_t sc_kernel_owner(const sc_prepared *volume, const float point[3]);
/** Edges of a cell: edge 4 d + a + 2 b leads along axis d, at a of the next axis and b of the one
 *  after that, in cyclic order; corners: x + 2 y + 4 z. */
enum { SC_CELL_EDGES = 12, SC_CELL_CORNERS = 8, SC_CELL_POINTS_MAX = 4 };
/** Where the smooth surface passes through a cell: a point for each part of it that is not joined
 * to another within the cell. */
typedef struct sc_cell_points {
    int count;                        /**< of the points, 0 to SC_CELL_POINTS_MAX */
    uint32_t owners[SC_CELL_CORNERS]; /**< dense ids: sc_kernel_vertex_owner */
    int8_t of_edge[SC_CELL_EDGES];   /**< the point of the part that crosses the edge; -1: none does
                                          as both ends have one owner */
    float at[SC_CELL_POINTS_MAX][3]; /**< in voxels from the lowest vertex, 0 to 1: on the surface,
                                        or where more than two labels meet */
    float normals[SC_CELL_POINTS_MAX][3]; /**< RAS, unit length, from the lower of two labels to the
                                           other; 0 where more meet, or at a face of the volume */
} sc_cell_points;
/** @return the dense id of the label that owns a grid vertex; 0 outside of the volume. Threads: any
 *  number at once. */
uint32_t sc_kernel_vertex_owner(const sc_prepared *volume, int x, int y, int z);
/** Find the points of a cell. Two cells agree about a face that they share: the edges of it that
 * have one point in one of them have one point in the other. @param q its lowest grid vertex, 0 to
 * the size of the volume along each axis. @param placed false: at and normals are not wanted.
 * Threads: any number at once. */
void sc_kernel_cell_points(const sc_prepared *volume, const int q[3], bool placed,
                           sc_cell_points *out);
/** The colour that march->grey, which must not be NULL, has at a point of a slice, beside all
 * tissues: as that of a cut face there, with the depth cue. @param point in grid coordinates.
 * @param depth_mm from the eye. @param tone [3] square roots of linear light; written only if there
 * is one.
 *  @return whether the point lies within the grey volume. Threads: any number at once. */
bool sc_kernel_grey(const sc_march *march, const float point[3], float depth_mm, float tone[3]);
/** Follow @p count rays through a backdrop, each by itself; cannot fail. @param out [count],
 *  overwritten, in the order of the rays. Threads: any number at once. */
typedef void sc_backdrop_fn(const sc_march_backdrop *backdrop, const sc_backdrop_ray *rays,
                            size_t count, sc_backdrop_light *out);
/** Find the kernel for backdrops. @param skip wide kernels pass over empty bricks, the others,
 *  which are plain C, do not; all return the same bits. @param size of the grey volume; wide
 * kernels reach its codes by offsets of 31 bits, and two along x at once: larger and thinner ones
 * are left to plain C. @param cpu as of sc_kernel_find; this processor must have it. */
sc_backdrop_fn *sc_backdrop_find(sc_skip skip, const int size[3], const char *cpu);
/** A ray that looks for tissue. */
typedef struct sc_gather_ray {
    float origin[3];    /**< in grid coordinates */
    float direction[3]; /**< in vertices, of about unit length */
} sc_gather_ray;
/** The vertex on the side of tissue that such a ray meets first. */
typedef struct sc_gather_hit {
    int32_t at[3]; /**< its grid coordinates; the first is -1 if there is none */
} sc_gather_hit;
/** What they look for it in. The caller owns what the pointers point to. */
typedef struct sc_gather_march {
    const sc_prepared *volume;
    const uint64_t *masks; /**< the vertices on the side of tissue that is shown, and not cut away;
                                with a frame, as of sc_visible_cells */
    const uint8_t *distances; /**< sc_brick_distances of the masks */
    int row, layer;           /**< steps in these arrays from a brick to the next along y and z */
    float box_low[3], box_high[3]; /**< in grid coordinates plus 1/2: rays end outside of it */
    float step[3][3]; /**< the vector, RAS, from a vertex to the next along each axis, in voxels */
} sc_gather_march;
/** Follow @p count rays, each by itself, up to the first vertex that they meet; cannot fail. @param
 *  out [count], overwritten. Threads: any number at once. */
typedef void sc_gather_fn(const sc_gather_march *march, const sc_gather_ray *rays, size_t count,
                          sc_gather_hit *out);
/** @return the variant @p cpu, as of sc_kernel_find, of it, which this processor must have. All of
 * them give the same bits. */
sc_gather_fn *sc_gather_find(const char *cpu);
/** All kernels of this build, also those that this processor cannot run. @return a constant
 *  table of *@p count entries. */
const sc_kernel *sc_kernel_all(size_t *count);

#endif
