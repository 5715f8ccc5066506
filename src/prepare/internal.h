/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to prepare: a preparation in the making, before it is packed into one block, and the
 * stages that fill it. */
#ifndef SC_PREPARE_INTERNAL_H
#define SC_PREPARE_INTERNAL_H

#include "segcast/brick.h"
#include "segcast/prepare.h"

#include <string.h>
#ifdef __SSE2__
#include <emmintrin.h>
#endif

/* The arrays are NULL until their stage has run, and have the shapes of sc_prepared. Those of
 * bricks, vertices and voxels are the team's; all others are owned, and the same on all ranks. */
struct sc_preparation {
    const sc_volume *volume;      /* borrowed */
    sc_prepare_settings settings; /* its hidden and tissue_smooth are NULL, and threads is how many
                                     the team has on this rank */
    sc_team *team;                /* that of the settings, or own_team */
    sc_team *own_team;            /* owned: of this rank alone; NULL if the settings name a team */
    sc_vec3 *smooth;              /* [label_count] strength of each label; 0 for the background */
    sc_vec3 kinds[SC_SMOOTH_KINDS_MAX]; /* [kind_count], 1 at least: the different strengths, the
                                           weakest first */
    int kind_count;
    int bricks[3];
    size_t brick_count; /* product of bricks */
    uint64_t *near;
    uint32_t *near_start;
    uint8_t *thickness;     /* NULL unless settings.local_thickness */
    sc_border outer, inner; /* whose arrays are owned */
    uint64_t near_count, boundary_count;
    sc_label_stats *stats;
    uint64_t volume_hash; /* of the first rank; 0 on the others */
    uint8_t *hidden;      /* [label_count] */
    sc_stored stored;     /* of sc_preparation_derive; its arrays are the team's, and owned */
};

/* @return bits that tell which of eight labels are @p id, the first in the lowest bit. */
static inline uint32_t sc_equal_bits(const uint16_t ids[8], uint32_t id)
{
    uint32_t bits = 0;
#ifdef __SSE2__
    const __m128i same = _mm_cmpeq_epi16(_mm_loadu_si128((const __m128i *)(const void *)ids),
                                         _mm_set1_epi16((int16_t)id));

    bits = (uint32_t)_mm_movemask_epi8(_mm_packs_epi16(same, _mm_setzero_si128()));
#else
    for (int x = 0; x < 8; x++)
        bits |= (uint32_t)(ids[x] == id) << x;
#endif
    return bits;
}

/* The dense id of a voxel; background outside of the volume. */
static inline uint32_t sc_id_or_background(const sc_volume *v, int x, int y, int z)
{
    if (x < 0 || y < 0 || z < 0 || x >= v->size[0] || y >= v->size[1] || z >= v->size[2])
        return 0;
    return sc_volume_id(v, ((size_t)z * (size_t)v->size[1] + (size_t)y) * (size_t)v->size[0] +
                               (size_t)x);
}

/* @p at limited to the voxels of an axis, 0 to @p size - 1. */
static inline int sc_nearest_voxel(int at, int size)
{
    return at < 0 ? 0 : at >= size ? size - 1 : at;
}

/* The dense id of the voxel; outside of the volume, that of the nearest voxel: what touches the
 * border goes on there, so that it is cut off and not rounded. */
static inline uint32_t sc_id_or_nearest(const sc_volume *v, int x, int y, int z)
{
    return sc_id_or_background(v, sc_nearest_voxel(x, v->size[0]), sc_nearest_voxel(y, v->size[1]),
                               sc_nearest_voxel(z, v->size[2]));
}

/* How strongly surfaces are smoothed along the axis of the largest strength. */
static inline double sc_most_strength(sc_vec3 strength)
{
    return fmax(fmax(strength.x, strength.y), strength.z);
}

/* How strongly surfaces are smoothed, as the mean over the axes. */
static inline float sc_mean_strength(sc_vec3 strength)
{
    return (float)((strength.x + strength.y + strength.z) / 3);
}

/* Is any surface smoothed at all, and not crisp? */
static inline bool sc_is_smoothed(const sc_preparation *p)
{
    for (int k = 0; k < p->kind_count; k++) {
        if (sc_most_strength(p->kinds[k]) > 0)
            return true;
    }
    return false;
}

/* Check everything in a view of a prepared file that is used as an index or computed with: after
 * that the file can be drawn without a crash, whoever has written it. Its sizes and sections have
 * been checked before. @param path for messages. Reads all voxels. @return SC_ERR_DATA. */
sc_status sc_check_prepared(const sc_ctx *ctx, const char *path, const sc_prepared *view);

/* Free @p data, an array of the team that is only read by now; NULL is allowed. */
static inline void sc_team_free_const(sc_team *team, const void *data)
{
    sc_team_free(team, (void *)(uintptr_t)data);
}

/* Free the arrays of p->stored. */
void sc_free_stored(sc_preparation *p);

/* How long the stages take, as shares of their sum: roughly those of a large volume. */
enum {
    SC_WORTH_BOUNDARY = 30000,
    SC_WORTH_FIELDS = 30000,
    SC_WORTH_BORDERS = 10000,
    SC_WORTH_SURFACE = 1000,
    SC_WORTH_THICKNESS = 30000
};
/* The stages, in their order. Each allocates and fills what it names, in the preparation, and may
 * read what the ones before it filled. They are collective in the team, and block until its threads
 * are done. Returns on all ranks the same: SC_ERR_MEMORY; after an error the preparation can only
 * be freed. */

/* Find the vertices near an interface: near; and in stats all but thickness and surface, which are
 * set to 0. */
sc_status sc_find_boundary(const sc_ctx *ctx, sc_preparation *p);
/* Number the bricks whose mask of @p masks [brick_count] is not 0, in their order from 1 on:
 * allocate *out [brick_count], of the team, with 0 for all others, and set *count to how many there
 * are. Collective in the team. Returns SC_ERR_MEMORY. */
sc_status sc_number_bricks(const sc_ctx *ctx, const sc_preparation *p, const uint64_t *masks,
                           uint32_t **out, uint64_t *count);
/* Number the marked vertices of @p masks [brick_count] in the order of bricks and bits: allocate
 * *start [brick_count], of the team, with how many come before those of a brick, and set *count to
 * how many there are. Collective in the team. Returns SC_ERR_MEMORY, also for more than 32 bits can
 * count. */
sc_status sc_number_vertices(const sc_ctx *ctx, const sc_preparation *p, const uint64_t *masks,
                             uint32_t **start, uint64_t *count);
/* Number the boundary vertices: near_start, near_count and boundary_count. SC_ERR_MEMORY also if
 * there are more than 32 bits can count. */
sc_status sc_index_boundary(const sc_ctx *ctx, sc_preparation *p);
/* Find the strengths of smoothing: smooth, kinds and kind_count. SC_ERR_DATA, logged, for
 * more than SC_SMOOTH_KINDS_MAX different ones. */
sc_status sc_find_strengths(const sc_ctx *ctx, sc_preparation *p);
/* Make the records of both fields from the smoothest surfaces that could have been drawn as these
 * voxels (border.h): outer and inner. Needs near. */
sc_status sc_smooth_borders(const sc_ctx *ctx, sc_preparation *p);
/* Find the covers, and what is seen from outside: cover_layer and shown of stats. */
sc_status sc_measure_covers(const sc_ctx *ctx, sc_preparation *p);
/* Measure the surface and the mean thickness of each label: surface_mm2 and thickness_mm of stats.
 * Needs near and the records. */
sc_status sc_measure_surface(const sc_ctx *ctx, sc_preparation *p);
/* Measure the local thickness at each boundary voxel: thickness. */
sc_status sc_measure_thickness(const sc_ctx *ctx, sc_preparation *p);

#endif
