/* SPDX-License-Identifier: BSD-3-Clause */
/* Surface area and mean thickness per label. The area is the sum over the faces between its voxels
 * and those of other labels, each face counting as its projection onto the smoothed surface,
 * |normal . area vector|. The steps of a staircase therefore do not add to the area, and for a
 * plane of any direction the sum is exact. Faces at the border of the volume are flat and count in
 * full.
 *
 * The normal is that in the middle of a face, from the gradients at the voxels on both sides. That
 * of the inner side alone makes balls too small, by 0.4 divided by their radius in voxels, and that
 * of the outer side as much too large. Gradients are added, so that the clear one beside a sheet
 * one voxel thick outweighs the short one within. */
#include "internal.h"

enum { UNITS_PER_FACE = 1 << 20 }; /* of the largest face of a voxel */

/* The sums that are being computed. Each thread has a copy, with its own sums. */
typedef struct surface_sum {
    const sc_preparation *p; /* borrowed; near and the records must be filled */
    sc_vec3 face[3];         /* area vector of the faces across each axis, mm2 */
    double units_per_mm2;
    uint64_t *sums; /* [threads][label_count], or those of a thread: areas in whole units, because
                       sums of integers do not depend on the order in which threads add to them */
} surface_sum;

/* @return the gradient at a voxel, RAS, of any length, none without a record: that of the inner
 * field if @p inner, else of the outer one; where only the other one has a record, of that. */
static sc_vec3 gradient_at(const sc_preparation *p, const int voxel[3], bool inner)
{
    const int x = voxel[0] + 1, y = voxel[1] + 1, z = voxel[2] + 1, bit = sc_brick_bit(x, y, z);
    const size_t brick = sc_brick_index(p->bricks, sc_brick_of(x), sc_brick_of(y), sc_brick_of(z));
    uint32_t record = sc_border_record(inner ? &p->inner : &p->outer, brick, bit);
    float out[3];

    if (!record)
        record = sc_border_record(inner ? &p->outer : &p->inner, brick, bit);
    if (!record)
        return (sc_vec3){0, 0, 0};
    sc_record_octant(record, out);
    return sc_vec3_scale((sc_vec3){out[0], out[1], out[2]}, sc_record_eighths(record));
}

/* @return the projected area, in whole units, of the face across @p axis between a voxel and the
 * next one, which has another label. Without a normal it counts in full. @param inner neither is
 * background. */
static uint64_t area_of_face(const surface_sum *s, const int voxel[3], int axis, bool inner)
{
    const int next[3] = {voxel[0] + (axis == 0), voxel[1] + (axis == 1), voxel[2] + (axis == 2)};
    const sc_vec3 here = gradient_at(s->p, voxel, inner), there = gradient_at(s->p, next, inner);
    /* In the inner field each points away from its own tissue. */
    const sc_vec3 sum = sc_vec3_along(here, sc_vec3_dot(here, there) < 0 ? -1 : 1, there);
    const double length = sc_vec3_length(sum);
    const double mm2 =
        length > 0 ? fabs(sc_vec3_dot(sum, s->face[axis])) / length : sc_vec3_length(s->face[axis]);

    return (uint64_t)(mm2 * s->units_per_mm2 + 0.5);
}

/* Add to the sums the faces across each axis between a voxel and the next one, and those of a voxel
 * at the border of the volume. */
static void add_faces(const surface_sum *s, const int voxel[3])
{
    const sc_volume *v = s->p->volume;
    const size_t strides[3] = {1, (size_t)v->size[0], (size_t)v->size[0] * (size_t)v->size[1]};
    const size_t index =
        (size_t)voxel[2] * strides[2] + (size_t)voxel[1] * strides[1] + (size_t)voxel[0];
    const uint32_t id = sc_volume_id(v, index);

    for (int axis = 0; axis < 3; axis++) {
        const bool is_last = voxel[axis] + 1 == v->size[axis];
        const int ends = is_last + (voxel[axis] == 0);
        const uint32_t next = is_last ? id : sc_volume_id(v, index + strides[axis]);

        if (ends)
            s->sums[id] +=
                (uint64_t)(ends * sc_vec3_length(s->face[axis]) * s->units_per_mm2 + 0.5);
        if (next != id) {
            const uint64_t area = area_of_face(s, voxel, axis, id && next);

            s->sums[id] += area;
            s->sums[next] += area;
        }
    }
}

/* Add the faces of bricks [begin, end) to the sums of the thread; an sc_range_fn on a surface_sum.
 */
static void add_bricks(void *user, size_t begin, size_t end, int thread)
{
    surface_sum mine = *(const surface_sum *)user;
    const sc_volume *v = mine.p->volume;

    mine.sums += (size_t)thread * (size_t)v->label_count;
    for (size_t brick = begin; brick < end; brick++) {
        int low[3];

        sc_brick_low(mine.p->bricks, brick, low);
        for (uint64_t left = mine.p->near[brick]; left; left &= left - 1) {
            const int bit = __builtin_ctzll(left);
            const int voxel[3] = {low[0] + sc_bit_x(bit) - 1, low[1] + sc_bit_y(bit) - 1,
                                  low[2] + sc_bit_z(bit) - 1};

            if (voxel[0] >= 0 && voxel[1] >= 0 && voxel[2] >= 0 && voxel[0] < v->size[0] &&
                voxel[1] < v->size[1] && voxel[2] < v->size[2])
                add_faces(&mine, voxel);
        }
    }
}

sc_status sc_measure_surface(const sc_ctx *ctx, sc_preparation *p)
{
    const sc_affine *to_mm = &p->volume->to_ras_mm;
    const size_t labels = (size_t)p->volume->label_count;
    const double voxel_mm3 = fabs(sc_affine_determinant(to_mm));
    surface_sum s = {.p = p};
    SC_OWN(sc_free_at) uint64_t *sums = NULL;
    void *all;
    double largest_mm2 = 0;

    SC_PASS(sc_team_agree(p->team, SC_ZALLOC(ctx, labels * (size_t)p->settings.threads, &sums)));
    s.sums = sums;
    for (int axis = 0; axis < 3; axis++) {
        s.face[axis] = sc_vec3_cross(sc_affine_column(to_mm, (axis + 1) % 3),
                                     sc_affine_column(to_mm, (axis + 2) % 3));
        largest_mm2 = fmax(largest_mm2, sc_vec3_length(s.face[axis]));
    }
    s.units_per_mm2 = UNITS_PER_FACE / largest_mm2;
    sc_team_stage_for(ctx, SC_WORTH_SURFACE, p->team, p->brick_count, 4096, add_bricks, &s);
    for (size_t i = labels; i < labels * (size_t)p->settings.threads; i++)
        s.sums[i % labels] += s.sums[i];
    SC_PASS(sc_team_collect(ctx, p->team, s.sums, labels * sizeof *s.sums, &all));
    for (size_t id = 1; id < labels; id++) {
        sc_label_stats *stats = &p->stats[id];
        uint64_t units = 0; /* whole numbers first: their sum does not depend on who has added */

        for (size_t rank = 0; rank < (size_t)sc_team_ranks(p->team); rank++)
            units += ((const uint64_t *)all)[rank * labels + id];
        stats->surface_mm2 = (double)units / s.units_per_mm2;
        if (units)
            stats->thickness_mm = 2 * voxel_mm3 * (double)stats->voxels / stats->surface_mm2;
    }
    sc_team_free(p->team, all);
    return SC_OK;
}
