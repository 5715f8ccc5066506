/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to render: light from all around, gathered in the volume at the vertices near its
 * surfaces, from which the kernels interpolate it (kernel/around.h). It follows from what is shown
 * and from the clip planes, not from the camera: a film that turns around a volume pays once.
 *
 * The places are vertices on the side of tissue beside which a surface passes, about every other
 * one, so that each vertex is one or has one beside it. Each stands for the point of the surface
 * nearest to it. What the rays from there meet is noted as the place there. The light at a place is
 * the sum over its rays: light of the sky and the lamp for rays that meet nothing, and light of the
 * place that they have met for the others, which is found in a few iterations. docs/light.md tells
 * more, and whose methods these are.
 *
 * What clip planes keep that cut all tissues alike is convex, apart from being tissue: rays are
 * traced without such planes, once, and a place that was cut away is free. */
#ifndef SC_RENDER_GATHER_H
#define SC_RENDER_GATHER_H

#include "segcast/render.h"
#include "sky.h"

struct sc_renderer;

enum {
    SC_GATHER_PARTS = 64,      /* of the net of directions: one for each of 4 x 4 x 4 vertices */
    SC_GATHER_DIRECTIONS = 32, /* of each place, all around; */
    SC_GATHER_LAMP = 16,       /* further ones, to the lamp */
    SC_GATHER_RAYS = SC_GATHER_DIRECTIONS + SC_GATHER_LAMP,
    SC_GATHER_FREE = -1,  /* a ray that meets nothing ... */
    SC_GATHER_LOST = -2,  /* ... and one whose hit has no place */
    SC_GATHER_FIELDS = 2, /* the outer and the inner one */
    SC_FLOOR_SIDE = 256,  /* points along a side of the grid on the floor; */
    SC_FLOOR_PARTS = 8    /* parts of the net in a row of them */
};

/* What of one field is gathered. The team owns masks and start; without masks nothing is. */
typedef struct sc_gather_field {
    const sc_border *border; /* of the volume */
    uint64_t *masks;         /* [bricks z][y][x]: the vertices that are places */
    uint64_t *thinned;       /* the same, while they are being found; else NULL */
    uint32_t *start;         /* [bricks z][y][x] and one more: number of its first place */
    uint32_t *around;        /* [border->count] for the kernels: see sc_march.around */
} sc_gather_field;

/* The vertices of a brick on the side of tissue that have one label. */
typedef struct sc_gather_part {
    uint64_t mask;
    uint16_t label; /* dense id */
} sc_gather_part;

/* A place where light is gathered. */
typedef struct sc_gather_place {
    float at[3];     /* where rays begin, in grid coordinates */
    float normal[3]; /* unit, RAS */
    uint16_t tissue; /* dense id */
    uint8_t part;    /* of the net of directions */
} sc_gather_place;

/* Places on the floor. */
typedef struct sc_gather_floor {
    size_t first;      /* number of the first of these places; the count of all without a floor */
    float (*light)[3]; /* [SC_FLOOR_SIDE][SC_FLOOR_SIDE] see sc_floor.light */
    /* the light that a point gets if nothing blocks its rays. Points of a row that are
     * SC_FLOOR_PARTS apart get the same, since their normals and ray directions are the same. */
    float free[SC_FLOOR_SIDE][SC_FLOOR_PARTS][3];
} sc_gather_floor;

/* What rays can meet. */
typedef struct sc_gather_targets {
    uint32_t *first_part;  /* [bricks z][y][x] and one more: where the parts of a brick begin */
    sc_gather_part *parts; /* of all bricks */
    uint64_t *shown;       /* masks of the vertices that may be shown */
    uint8_t *far;          /* sc_brick_distances of these */
    uint64_t *occupied;    /* as of sc_gather_march: what could be met when the hits were found */
    uint8_t *distances;    /* the same */
    bool *absent;        /* [SC_GATHER_RAYS][label_count]: what rays of a direction pass through */
    bool *absent_before; /* that of the hits */
    uint32_t *cuts;      /* [label_count] which planes cut a tissue, as bits */
} sc_gather_targets;

/* The rays that are traced now. */
typedef struct sc_gather_batch {
    const bool *absent; /* [label_count] of their direction; borrowed */
    size_t first;       /* place from which on they are traced */
    int direction;
} sc_gather_batch;

/* Light of each place, linear: [count] of each. */
typedef struct sc_gather_light {
    float (*sky)[3];       /* straight from the sky and the lamp */
    float (*all)[3];       /* all of it */
    float (*radiosity)[3]; /* what the place gives back */
    bool *gone;            /* it is cut away */
} sc_gather_light;

/* The scene for which hits and light were found, as far as they depend on one. */
typedef struct sc_gather_known {
    bool is_known;  /* there has been one */
    bool is_convex; /* what its planes keep is convex, and the same for all tissues */
    float sky_strength, lamp_strength; /* intensities */
    sc_lamp_frame lamp;                /* where the lamp stands; its rays go there */
    bool lamp_moves;                   /* these are traced anew, whatever else is not */
    sc_scene scene;                    /* only its planes and clip sets are read */
    sc_march_tissue *tissues;          /* [label_count] as the march had them */
} sc_gather_known;

/* Light that is gathered. What does not depend on a scene is made by the ranks of the team, which
 * owns it, together. So are the hits, unless a frame may need rays of its own; and so is the light,
 * unless a frame may need its own sums: then each rank has arrays for itself. */
typedef struct sc_gather {
    const struct sc_renderer *renderer; /* borrowed */
    sc_light_change change;             /* how much differs between the frames */
    bool together;                      /* loops are those of the team now */
    bool is_kept;                       /* the light was read, and there is nothing else */
    sc_gather_field fields[SC_GATHER_FIELDS];
    size_t count; /* of places: those of the outer field come first, points of the floor last */
    sc_gather_floor floor;
    sc_gather_place *places;
    /* [SC_GATHER_PARTS] those all around about the z axis, those to the lamp as they are, RAS */
    float (*directions)[SC_GATHER_RAYS][3];
    sc_gather_targets targets;
    sc_gather_march march; /* borrows them */
    sc_gather_fn *follow;
    sc_gather_batch batch;
    int32_t *hits[SC_GATHER_RAYS]; /* [count] the place that a ray meets; SC_GATHER_FREE, _LOST */
    sc_gather_light light;
    sc_gather_known known;
} sc_gather;

/* Find the places at which the light of a renderer is gathered, and what its rays can meet, and
 * make room for the rest. Collective in its team. @return SC_ERR_MEMORY. Caller owns *out:
 * sc_gather_free. */
sc_status sc_gather_new(const sc_ctx *ctx, const struct sc_renderer *r, sc_light_change change,
                        sc_gather **out);
/* Begin one whose light was gathered before: sc_gather_load, by the first rank of the team. For
 * scenes between which light stays. Collective. @return SC_ERR_MEMORY. Caller owns *out. */
sc_status sc_gather_new_kept(const sc_ctx *ctx, const struct sc_renderer *r, sc_gather **out);
/* Write the name of the file in which the light of a scene, for which @p r has been set up, is kept
 * to *out, NULL: nowhere. @param prepared that of the prepared volume in the cache; NULL: none.
 * Caller owns *out: sc_free. */
sc_status sc_gather_kept_path(const sc_ctx *ctx, const struct sc_renderer *r, const sc_scene *scene,
                              const char *prepared, char **out);
/* Read light from such a file. @return whether it was there, and whole. */
bool sc_gather_load(sc_gather *g, const char *path);
/* Write light to such a file; if that cannot be done, there is none. */
void sc_gather_save(const sc_ctx *ctx, const sc_gather *g, const char *path);
/* Free it; NULL is allowed. */
void sc_gather_free(sc_gather *g);
/* @return the bytes of memory that the rank has for it. */
uint64_t sc_gather_bytes(const sc_gather *g);
/* Gather the light of a scene, for which @p r has been set up, as far as it differs from that of
 * the last one, by all threads of the renderer; and set the light around of r->march. */
void sc_gather_scene(sc_gather *g, struct sc_renderer *r, const sc_scene *scene);

/* Do the same for the first scene together with the other ranks, as far as its arrays are the
 * team's. Collective. @param ctx as of sc_gather_trace. */
void sc_gather_first(const sc_ctx *ctx, sc_gather *g, struct sc_renderer *r, const sc_scene *scene);

/* Find the places, and what rays can meet: arrays of the team. Collective. @return SC_ERR_MEMORY.
 */
sc_status sc_gather_find_places(const sc_ctx *ctx, sc_gather *g);
sc_status sc_gather_find_parts(const sc_ctx *ctx, sc_gather *g);
/* Replace the counts that bricks have, and that of one more, which is 0, by the sum of @p first and
 * those before. Collective. @return the sum of all. */
uint32_t sc_gather_number(const sc_gather *g, uint32_t first, uint32_t *counts);
/* @return whether gathering is to be given up, as the frame is; not while others would wait. */
bool sc_gather_ends(const sc_gather *g);
/* Call @p body for all of [0, count): together, or by the threads of this rank alone. */
void sc_gather_for(sc_gather *g, size_t count, size_t chunk, sc_range_fn *body);
/* Follow the rays of all places through what @p scene shows: sets g->hits. @param again the hits
 * are those of g->known.scene, which shows the same tissues, cut in the same way: directions whose
 * rays pass through the same tissues as then are not traced again. @param first number of the place
 * from which on rays are followed. @param ctx its stage counts the rays of a place; NULL: there is
 * none. */
void sc_gather_trace(const sc_ctx *ctx, sc_gather *g, const sc_scene *scene, bool again,
                     size_t first);
/* @return how many rays each place has: none goes to a lamp that is out. */
static inline int sc_gather_rays(const sc_gather *g)
{
    return g->known.lamp_strength > 0 ? SC_GATHER_RAYS : SC_GATHER_DIRECTIONS;
}
/* Find the light of all places from what their rays have met, and spread it to the vertices: sets
 * the light of g->fields. */
void sc_gather_sum(sc_gather *g);
/* The direction number @p i, less than SC_GATHER_RAYS, of a place, unit, RAS, to @p out. */
void sc_gather_direction(const sc_gather *g, const sc_gather_place *p, int i, float out[3]);

/* Fill in points [begin, end) of the floor, and spread their light, each an sc_range_fn on a
 * gather. */
void sc_floor_points(void *user, size_t begin, size_t end, int thread);
void sc_floor_spread(void *user, size_t begin, size_t end, int thread);

/* @return the number of the place at vertex @p q, which is one of the grid; SC_GATHER_LOST if there
 * is none. */
int32_t sc_gather_place_at(const sc_gather *g, const sc_gather_field *f, const int q[3]);

static inline float sc_dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

#endif
