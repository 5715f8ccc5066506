/* SPDX-License-Identifier: BSD-3-Clause */
/* Surface area per label: the sum over the faces between its voxels and those of other labels, each
 * face counting as its projection onto the smoothed surface, |normal . area vector|. The steps of a
 * staircase therefore do not add to the area, and for a plane of any direction the sum is exact.
 * Faces at the border of the volume are flat and count in full. */
#include "internal.h"

enum { UNITS_PER_FACE = 1 << 20 }; /* of the largest face of a voxel */

/* The sums that are being computed. Each thread has a copy, with its own number in thread. */
typedef struct surface_sum {
    const sc_preparation *p; /* borrowed; near and the records must be filled */
    sc_vec3 face[3];         /* area vector of the faces across each axis, mm2 */
    double units_per_mm2;
    uint64_t *sums; /* [threads][label_count]: areas in whole units, because sums of integers do not
                       depend on the order in which threads add to them */
    int thread;
} surface_sum;

/* Is the voxel the last one of the volume in the direction @p step (-1 or 1) along an axis? */
static bool is_last(const sc_volume *v, const sc_boundary_voxel *voxel, int axis, int step)
{
    const int at[3] = {voxel->x, voxel->y, voxel->z};

    return at[axis] == (step < 0 ? 0 : v->size[axis] - 1);
}

/* Does the neighbour one step (-1 or 1) along an axis lie in the volume and hold another label than
 * @p voxel? */
static bool differs(const sc_volume *v, const sc_boundary_voxel *voxel, int axis, int step)
{
    int at[3] = {voxel->x, voxel->y, voxel->z};

    at[axis] += step;
    if (at[axis] < 0 || at[axis] >= v->size[axis])
        return false;
    return sc_id_at(v, ((size_t)at[2] * (size_t)v->size[1] + (size_t)at[1]) * (size_t)v->size[0] +
                           (size_t)at[0]) != voxel->id;
}

/* Add the projected area of the faces of one boundary voxel, in whole units, to the sum of its
 * label; an sc_boundary_fn on a surface_sum. Without a normal, faces would count in full. */
static void add_faces(void *user, const sc_boundary_voxel *voxel)
{
    const surface_sum *s = user;
    const sc_volume *v = s->p->volume;
    const uint32_t outer = sc_border_record(&s->p->outer, voxel->brick, voxel->bit);
    const uint32_t record =
        outer ? outer : sc_border_record(&s->p->inner, voxel->brick, voxel->bit);
    float packed[3] = {0, 0, 0};
    sc_vec3 normal;
    double area_mm2 = 0;

    if (record)
        sc_record_normal(record, packed);
    normal = sc_vec3_unit((sc_vec3){packed[0], packed[1], packed[2]});
    for (int axis = 0; axis < 3; axis++) {
        const int faces = differs(v, voxel, axis, -1) + differs(v, voxel, axis, 1);
        const int ends = is_last(v, voxel, axis, -1) + is_last(v, voxel, axis, 1);
        const double across = sc_vec3_length(normal) > 0 ? fabs(sc_vec3_dot(normal, s->face[axis]))
                                                         : sc_vec3_length(s->face[axis]);

        area_mm2 += faces * across + ends * sc_vec3_length(s->face[axis]);
    }
    s->sums[(size_t)s->thread * (size_t)v->label_count + voxel->id] +=
        (uint64_t)(area_mm2 * s->units_per_mm2 + 0.5);
}

/* Add the boundary voxels of bricks [begin, end) to the sums of the thread; an sc_range_fn on a
 * surface_sum. */
static void add_bricks(void *user, size_t begin, size_t end, int thread)
{
    surface_sum mine = *(const surface_sum *)user;

    mine.thread = thread;
    sc_each_boundary(mine.p, begin, end, add_faces, &mine);
}

sc_status sc_measure_surface(const sc_ctx *ctx, sc_preparation *p)
{
    const sc_affine *to_mm = &p->volume->to_ras_mm;
    const size_t labels = (size_t)p->volume->label_count;
    surface_sum s = {.p = p};
    void *block = NULL, *all = NULL;
    double largest_mm2 = 0;
    sc_status status = sc_zalloc(ctx, labels * (size_t)p->settings.threads, sizeof *s.sums, &block);

    SC_TRY(sc_team_agree(p->team, status));
    s.sums = block;
    for (int axis = 0; axis < 3; axis++) {
        s.face[axis] = sc_vec3_cross(sc_affine_column(to_mm, (axis + 1) % 3),
                                     sc_affine_column(to_mm, (axis + 2) % 3));
        largest_mm2 = fmax(largest_mm2, sc_vec3_length(s.face[axis]));
    }
    s.units_per_mm2 = UNITS_PER_FACE / largest_mm2;
    sc_team_stage_for(ctx, SC_WORTH_SURFACE, p->team, p->brick_count, 4096, add_bricks, &s);
    for (size_t i = labels; i < labels * (size_t)p->settings.threads; i++)
        s.sums[i % labels] += s.sums[i];
    SC_TRY(sc_team_collect(ctx, p->team, s.sums, labels * sizeof *s.sums, &all));
    for (size_t id = 0; id < labels; id++) {
        uint64_t units = 0; /* whole numbers first: their sum does not depend on who has added */

        for (size_t rank = 0; rank < (size_t)sc_team_ranks(p->team); rank++)
            units += ((const uint64_t *)all)[rank * labels + id];
        p->stats[id].surface_mm2 = (double)units / s.units_per_mm2;
    }
out:
    sc_team_free(p->team, all);
    sc_free(block);
    return status;
}
