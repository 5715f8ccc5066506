/* SPDX-License-Identifier: BSD-3-Clause */
/* Surface area per label by Crofton's formula: how often lines of the grid in 13 directions cross
 * the label's surface, weighted by the solid angle each direction stands for (Ohser and Muecklich
 * 2000, "Statistical Analysis of Microstructures", chapter 4; the weights are integrated here, so
 * that any spacing and any shear is right). */
#include "internal.h"

enum { DIRECTIONS = 13, SPHERE_POINTS = 20000 };

static const int directions[DIRECTIONS][3] = {
    {1, 0, 0}, {0, 1, 0},  {0, 0, 1}, {1, 1, 0},  {1, -1, 0}, {1, 0, 1}, {1, 0, -1},
    {0, 1, 1}, {0, 1, -1}, {1, 1, 1}, {1, 1, -1}, {1, -1, 1}, {-1, 1, 1}};

typedef struct surface_counter {
    const sc_preparation *p;
    uint64_t (*crossings)[DIRECTIONS]; /* [threads][label_count] */
    int thread;
} surface_counter;

static bool differs(const sc_volume *v, const sc_boundary_voxel *voxel, const int d[3], int sign)
{
    const int x = voxel->x + sign * d[0], y = voxel->y + sign * d[1], z = voxel->z + sign * d[2];

    if (x < 0 || y < 0 || z < 0 || x >= v->size[0] || y >= v->size[1] || z >= v->size[2])
        return true;
    return sc_id_at(v, ((size_t)z * (size_t)v->size[1] + (size_t)y) * (size_t)v->size[0] +
                           (size_t)x) != voxel->id;
}

static void count_crossings(void *user, const sc_boundary_voxel *voxel)
{
    const surface_counter *c = user;
    uint64_t *crossings =
        c->crossings[(size_t)c->thread * (size_t)c->p->volume->label_count + voxel->id];

    for (int i = 0; i < DIRECTIONS; i++)
        crossings[i] += (uint64_t)differs(c->p->volume, voxel, directions[i], 1) +
                        (uint64_t)differs(c->p->volume, voxel, directions[i], -1);
}

static void count_in_bricks(void *user, size_t begin, size_t end, int thread)
{
    surface_counter mine = *(const surface_counter *)user;

    mine.thread = thread;
    sc_each_boundary(mine.p, begin, end, count_crossings, &mine);
}

/* Share of all directions nearest to each of the 13, times the area one line stands for. */
static void area_per_crossing(const sc_affine *to_mm, double out[DIRECTIONS])
{
    const double volume = fabs(sc_affine_determinant(to_mm));
    const double golden = 3.883222077450933; /* 2 pi (1 - 1 / golden ratio) */
    sc_vec3 unit[DIRECTIONS];
    int nearest[DIRECTIONS] = {0};

    for (int i = 0; i < DIRECTIONS; i++) {
        const sc_vec3 step = {directions[i][0], directions[i][1], directions[i][2]};
        const sc_vec3 mm = sc_affine_vector(to_mm, step);

        unit[i] = sc_vec3_unit(mm);
        out[i] = volume / sc_vec3_length(mm);
    }
    for (int n = 0; n < SPHERE_POINTS; n++) {
        const double z = 1 - (2.0 * n + 1) / SPHERE_POINTS, r = sqrt(1 - z * z);
        const sc_vec3 point = {r * cos(golden * n), r * sin(golden * n), z};
        int best = 0;

        for (int i = 1; i < DIRECTIONS; i++) {
            if (fabs(sc_vec3_dot(point, unit[i])) > fabs(sc_vec3_dot(point, unit[best])))
                best = i;
        }
        nearest[best]++;
    }
    for (int i = 0; i < DIRECTIONS; i++) /* area = 2 x mean over directions of crossings x area */
        out[i] *= 2.0 * nearest[i] / SPHERE_POINTS;
}

sc_status sc_measure_surface(const sc_ctx *ctx, sc_preparation *p)
{
    const size_t labels = (size_t)p->volume->label_count;
    surface_counter counter = {.p = p};
    double area[DIRECTIONS];
    void *block = NULL;
    sc_status status =
        sc_zalloc(ctx, labels * (size_t)p->threads, sizeof *counter.crossings, &block);

    if (status != SC_OK)
        return status;
    counter.crossings = block;
    sc_parallel_for(p->threads, p->brick_count, 4096, count_in_bricks, &counter);
    area_per_crossing(&p->volume->to_ras_mm, area);
    for (size_t id = 0; id < labels; id++) {
        for (int i = 0; i < DIRECTIONS; i++) {
            uint64_t crossings = 0;

            for (int thread = 0; thread < p->threads; thread++)
                crossings += counter.crossings[(size_t)thread * labels + id][i];
            p->stats[id].surface_mm2 += (double)crossings * area[i];
        }
    }
    sc_free(block);
    return SC_OK;
}
