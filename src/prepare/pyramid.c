/* SPDX-License-Identifier: BSD-3-Clause */
/* The pyramid of binary volumes (Levoy 1990, "Efficient ray tracing of volume data"): which cubes
 * of the grid hold anything that a picture can show. */
#include "segcast/prepare.h"

#include <string.h>

/* Set row, layer, origin and count of the pyramid of a volume, and the masks of each level along x,
 * y and z, without the frame, to @p sizes. */
static void lay_out(const sc_prepared *volume, sc_pyramid *y, int sizes[SC_PYRAMID_LEVELS][3])
{
    y->count = 0;
    for (int level = 0; level < SC_PYRAMID_LEVELS; level++) {
        int framed[3];

        for (int i = 0; i < 3; i++)
            sizes[level][i] =
                level ? (sizes[level - 1][i] + SC_BRICK - 1) / SC_BRICK : volume->bricks[i];
        y->row[level] = sc_framed_row(sizes[level]);
        y->layer[level] = sc_framed_layer(sizes[level]);
        y->origin[level] =
            (int32_t)y->count + sc_framed_index(y->row[level], y->layer[level], 0, 0, 0);
        sc_framed_size(sizes[level], framed);
        y->count += sc_brick_count(framed);
    }
}

/* Set the bits of the masks of @p level, above 0, which are zero before, from those of the level
 * below. @param size masks of the level below along x, y and z, without the frame. */
static void raise_level(const sc_pyramid *p, int level, const int size[3], uint64_t *masks)
{
    for (int z = 0; z < size[2]; z++) {
        for (int y = 0; y < size[1]; y++) {
            const uint64_t *below =
                masks + p->origin[level - 1] + z * p->layer[level - 1] + y * p->row[level - 1];
            uint64_t *above = masks + p->origin[level] + sc_brick_of(z) * p->layer[level] +
                              sc_brick_of(y) * p->row[level];

            for (int x = 0; x < size[0]; x++)
                above[sc_brick_of(x)] |= (uint64_t)(below[x] != 0) << sc_brick_bit(x, y, z);
        }
    }
}

/* What one thread does for the team. */
typedef struct pyramid_job {
    const sc_pyramid *pyramid;
    int sizes[SC_PYRAMID_LEVELS][3]; /* of lay_out */
    const uint64_t *lowest;          /* [lowest_count] masks of level 0 */
    size_t lowest_count;
    uint64_t *masks; /* of all levels; zero before */
} pyramid_job;

/* Fill in the masks; an sc_range_fn on a pyramid_job, for one item. */
static void raise_levels(void *user, size_t begin, size_t end, int thread)
{
    const pyramid_job *job = user;

    memcpy(job->masks, job->lowest, job->lowest_count * sizeof *job->masks);
    for (int level = 1; level < SC_PYRAMID_LEVELS; level++)
        raise_level(job->pyramid, level, job->sizes[level - 1], job->masks);
}

sc_status sc_pyramid_build(const sc_ctx *ctx, sc_team *team, const sc_prepared *volume,
                           uint64_t **masks, sc_pyramid *out)
{
    sc_pyramid p;
    pyramid_job job = {.pyramid = &p, .lowest = *masks};
    int framed[3];
    void *block;

    lay_out(volume, &p, job.sizes);
    sc_framed_size(volume->bricks, framed);
    job.lowest_count = sc_brick_count(framed);
    SC_PASS(sc_team_alloc(ctx, team, p.count, sizeof **masks, &block));
    job.masks = block;
    sc_team_for(team, 1, 1, raise_levels, &job);
    sc_team_free(team, *masks);
    *masks = block;
    *out = p;
    return SC_OK;
}
