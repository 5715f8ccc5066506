/* SPDX-License-Identifier: BSD-3-Clause */
/* The records of vertices near borders: values and gradients of both fields at each. */
#include "border/border_group.h"

enum {
    HALO = 3, /* voxels around a group that gradients come from */
    WIDE = SC_CUBE + 2 * HALO,
    FLAT = WIDE - 4,                /* edge of what has been blurred twice */
    QUARTERS = SC_CUBE_QUARTERS + 2 /* edge of the quarters that a group lies between */
};

/* A field around a group, and the same blurred, for gradients. */
typedef struct group_field {
    float at[WIDE * WIDE * WIDE], once[(WIDE - 2) * (WIDE - 2) * (WIDE - 2)],
        flat[FLAT * FLAT * FLAT];
    sc_wide_slope wide[QUARTERS * QUARTERS * QUARTERS];
    bool is_wide; /* any of these has a share */
} group_field;

/* Where a vertex lies between quarters. */
typedef struct quarter_place {
    int low[3];     /* the lower quarter */
    float share[3]; /* of the next one */
} quarter_place;

/* @return where voxel @p voxel lies between the quarters of the cubes. */
static inline quarter_place place_of(const sc_borders *b, const int voxel[3])
{
    quarter_place out;

    for (int i = 0; i < 3; i++) {
        const int eighths = 2 * (voxel[i] + b->phase[i]) + 5; /* of a quarter, from one before */

        out.low[i] = eighths / 8 - 1;
        out.share[i] = (float)(eighths % 8) * (1.0f / 8);
    }
    return out;
}

/* Read the gradients of the filtered field of @p label at the quarters between which a group lies,
 * whose lowest voxel is @p voxel; beyond the volume those of the nearest ones. @return whether any
 * has a share. */
static bool read_wide_slopes(const sc_borders *b, uint32_t label, const int voxel[3],
                             sc_wide_slope *out)
{
    const quarter_place first = place_of(b, voxel);
    bool any = false;

    for (int n = 0; n < QUARTERS * QUARTERS * QUARTERS; n++) {
        const int place[3] = {n % QUARTERS, n / QUARTERS % QUARTERS, n / (QUARTERS * QUARTERS)};
        int at[3], cube[3];
        uint32_t tile;

        for (int i = 0; i < 3; i++) {
            const int quarters = (b->p->volume->size[i] + b->phase[i] + 3) / 4;

            at[i] = sc_nearest_voxel(first.low[i] + place[i], quarters);
            cube[i] = at[i] / SC_CUBE_QUARTERS;
            at[i] %= SC_CUBE_QUARTERS;
        }
        tile = sc_tile_of(b, sc_brick_index(b->cubes, cube[0], cube[1], cube[2]), label);
        out[n] = (sc_wide_slope){.share = 0};
        if (!b->quarters.wide || tile >= SC_BESIDE(0))
            continue;
        out[n] = b->quarters.wide[tile & ~SC_MIRRORED]
                                 [(at[2] * SC_CUBE_QUARTERS + at[1]) * SC_CUBE_QUARTERS + at[0]];
        for (int i = 0; i < 3 && tile & SC_MIRRORED; i++)
            out[n].slope[i] = -out[n].slope[i];
        any = any || out[n].share > 0;
    }
    return any;
}

/* Read the field of @p label around a group. @return false if its border is out of reach. */
SC_WIDE_VECTORS static bool read_group(const sc_record_writer *w, uint32_t label, const int low[3],
                                       group_field *out)
{
    const int voxel[3] = {low[0] - 1 - HALO, low[1] - 1 - HALO, low[2] - 1 - HALO};

    if (!sc_read_field(w->b, label, voxel, WIDE, out->at))
        return false;
    sc_binomial(out->at, WIDE, out->once);
    sc_binomial(out->once, WIDE - 2, out->flat);
    out->is_wide = read_wide_slopes(w->b, label, (const int[3]){low[0] - 1, low[1] - 1, low[2] - 1},
                                    out->wide);
    return true;
}

/* Blend the gradient at a vertex of a group with that of the filtered field, in the share in which
 * that is the one for normals. @param low, voxel the lowest voxel of the group, and that of the
 * vertex. */
static inline void blend_wide(const sc_record_writer *w, const group_field *f, const int low[3],
                              const int voxel[3], float slope[3])
{
    typedef float four __attribute__((vector_size(sizeof(sc_wide_slope))));
    const quarter_place first = place_of(w->b, low), place = place_of(w->b, voxel);
    four sum = {0};
    sc_wide_slope wide;

    for (int n = 0; n < 8; n++) {
        const int corner[3] = {n & 1, n >> 1 & 1, n >> 2};
        float weight = 1;
        int at = 0;
        four here;

        for (int i = 2; i >= 0; i--) {
            at = at * QUARTERS + place.low[i] - first.low[i] + corner[i];
            weight *= corner[i] ? place.share[i] : 1 - place.share[i];
        }
        memcpy(&here, &f->wide[at], sizeof here);
        sum += weight * here;
    }
    memcpy(&wide, &sum, sizeof wide);
    for (int i = 0; i < 3; i++)
        slope[i] += wide.share * (wide.slope[i] - slope[i]);
}

/* @return a record of the field at vertex @p at of a group whose lowest vertex is @p low.
 * @param value of the record. */
static uint32_t pack(const sc_record_writer *w, const group_field *f, const int low[3],
                     const int at[3], int code, int value)
{
    const float *flat = f->flat + ((at[2] + 1) * FLAT + at[1] + 1) * FLAT + at[0] + 1;
    const int lowest[3] = {low[0] - 1, low[1] - 1, low[2] - 1};
    const int voxel[3] = {lowest[0] + at[0], lowest[1] + at[1], lowest[2] + at[2]};
    float slope[3] = {0.5f * (flat[1] - flat[-1]), 0.5f * (flat[FLAT] - flat[-FLAT]),
                      0.5f * (flat[FLAT * FLAT] - flat[-FLAT * FLAT])};
    sc_vec3 outward = {0, 0, 0};

    if (f->is_wide)
        blend_wide(w, f, lowest, voxel, slope);
    for (int i = 0; i < 3; i++) {
        const double *row = w->to_voxel.m[i];

        outward = sc_vec3_along(outward, -(double)slope[i], (sc_vec3){row[0], row[1], row[2]});
    }
    return sc_record_pack(value, outward,
                          sqrtf(slope[0] * slope[0] + slope[1] * slope[1] + slope[2] * slope[2])) |
           (uint32_t)code << SC_RECORD_TISSUE_SHIFT;
}

/* Write the records of the outer field of a group. */
static void write_outer(const sc_record_writer *w, const int low[3], group_field *f)
{
    if (!read_group(w, 0, low, f))
        return;
    for (int n = 0; n < SC_GROUP_BRICKS; n++) {
        const size_t brick = sc_brick_of_group(w, low, n);
        uint32_t *record;

        if (brick == SIZE_MAX || !w->p->outer.masks[brick])
            continue;
        record = (uint32_t *)(uintptr_t)w->p->outer.records + w->p->outer.start[brick];
        for (uint64_t left = w->p->outer.masks[brick]; left; left &= left - 1) {
            const int bit = __builtin_ctzll(left);
            const int at[3] = {n % SC_GROUP_EDGE * SC_BRICK + sc_bit_x(bit),
                               n / SC_GROUP_EDGE % SC_GROUP_EDGE * SC_BRICK + sc_bit_y(bit),
                               n / (SC_GROUP_EDGE * SC_GROUP_EDGE) * SC_BRICK + sc_bit_z(bit)};
            const float value = f->at[((at[2] + HALO) * WIDE + at[1] + HALO) * WIDE + at[0] + HALO];

            *record++ =
                pack(w, f, low, at, w->codes[w->number[brick] - 1][bit], sc_outer_value(value));
        }
    }
}

/* A vertex of a group with a record of the inner field. */
typedef struct inner_vertex {
    uint32_t *record;
    uint16_t label; /* its tissue; 0 if it has none */
    uint8_t at[3], code, value;
} inner_vertex;

/* List the vertices of a group that have a record of the inner field, to @p out. @return how many
 * there are. */
static int list_inner(const sc_record_writer *w, const int low[3], const sc_group_ids *ids,
                      inner_vertex out[SC_TILE_VOXELS])
{
    int count = 0;

    for (int n = 0; n < SC_GROUP_BRICKS; n++) {
        const size_t brick = sc_brick_of_group(w, low, n);
        uint32_t *record;

        if (brick == SIZE_MAX || !w->p->inner.masks[brick])
            continue;
        record = (uint32_t *)(uintptr_t)w->p->inner.records + w->p->inner.start[brick];
        for (uint64_t left = w->p->inner.masks[brick]; left; left &= left - 1) {
            const int bit = __builtin_ctzll(left);
            const int x = n % SC_GROUP_EDGE * SC_BRICK + sc_bit_x(bit),
                      y = n / SC_GROUP_EDGE % SC_GROUP_EDGE * SC_BRICK + sc_bit_y(bit),
                      z = n / (SC_GROUP_EDGE * SC_GROUP_EDGE) * SC_BRICK + sc_bit_z(bit);
            const uint8_t code = w->codes[w->number[brick] - 1][bit];

            out[count++] = (inner_vertex){.record = record++,
                                          .label = sc_id_around(ids, x, y, z, code),
                                          .at = {(uint8_t)x, (uint8_t)y, (uint8_t)z},
                                          .code = code,
                                          .value = w->inner[w->number[brick] - 1][bit]};
        }
    }
    return count;
}

/* Write the records of the inner field of those of @p count vertices of a group that have the
 * tissue @p label. @return the least larger one that some have; UINT16_MAX if there is none. */
static uint16_t write_inner(const sc_record_writer *w, uint16_t label, const int low[3],
                            const sc_group_ids *ids, const inner_vertex *vertices, int count,
                            group_field *f)
{
    uint16_t next = UINT16_MAX;

    if (label && !read_group(w, label, low, f)) {
        memset(f->flat, 0, sizeof f->flat);
        f->is_wide = false;
    }
    for (int i = 0; i < count; i++) {
        const inner_vertex *v = &vertices[i];
        const int at[3] = {v->at[0], v->at[1], v->at[2]};
        const int voxel[3] = {low[0] + at[0] - 1, low[1] + at[1] - 1, low[2] + at[2] - 1};
        int value = v->value;
        float values[2];

        next = v->label > label && v->label < next ? v->label : next;
        if (v->label != label)
            continue;
        if (!label) { /* no vote */
            *v->record = sc_record_pack(1, (sc_vec3){0, 0, 0}, 0) | (uint32_t)SC_TISSUE_OWN
                                                                        << SC_RECORD_TISSUE_SHIFT;
            continue;
        }
        if (!value) {
            (void)sc_largest_tissue(w->b, ids, at, voxel, values);
            value = sc_inner_value(values);
        }
        *v->record = pack(w, f, low, at, v->code, value);
    }
    return next;
}

/* Write the records of groups [begin, end); an sc_range_fn on a writer. */
SC_WIDE_VECTORS static void write_groups(void *user, size_t begin, size_t end, int thread)
{
    const sc_record_writer *w = user;
    const uint64_t *masks[2] = {w->p->outer.masks, w->p->inner.masks};
    const uint64_t *inner[2] = {w->p->inner.masks, w->p->inner.masks};
    inner_vertex vertices[SC_TILE_VOXELS];
    group_field f;

    for (size_t group = begin; group < end; group++) {
        sc_group_ids ids;
        int low[3], voxel[3], count;

        if (!sc_begin_group(w, masks, group, low))
            continue;
        for (int i = 0; i < 3; i++)
            voxel[i] = low[i] - 1;
        write_outer(w, low, &f);
        if (!sc_begin_group(w, inner, group, low))
            continue;
        sc_read_group_ids(w->p->volume, voxel, &ids);
        count = list_inner(w, low, &ids, vertices);
        for (uint16_t id = 0; id != UINT16_MAX;)
            id = write_inner(w, id, low, &ids, vertices, count, &f);
    }
}

/* Find the bricks that hold or touch a vertex near a border, of the rows [begin, end) of bricks; an
 * sc_range_fn on a writer. */
static void want_bricks(void *user, size_t begin, size_t end, int thread)
{
    const sc_record_writer *w = user;
    const int *bricks = w->p->bricks;

    for (size_t row = begin; row < end; row++) {
        uint64_t *wanted = w->wanted + row * (size_t)bricks[0], before = 0;

        for (int n = 0; n < 9; n++) {
            const int y = (int)row % bricks[1] + n % 3 - 1, z = (int)row / bricks[1] + n / 3 - 1;

            if (y < 0 || z < 0 || y >= bricks[1] || z >= bricks[2])
                continue;
            for (int x = 0; x < bricks[0]; x++)
                wanted[x] |= w->p->near[sc_brick_index(bricks, x, y, z)];
        }
        for (int x = 0; x < bricks[0]; x++) {
            const uint64_t here = wanted[x];

            wanted[x] |= before | (x + 1 < bricks[0] ? wanted[x + 1] : 0);
            before = here;
        }
    }
}

sc_status sc_write_records(const sc_ctx *ctx, sc_preparation *p, const sc_borders *b)
{
    sc_record_writer w = {.b = b, .p = p};
    void *wanted = NULL, *sides = NULL, *codes = NULL, *inner = NULL;
    uint32_t *number = NULL;
    uint64_t count;
    sc_status status;

    (void)sc_affine_invert(&p->volume->to_ras_mm, &w.to_voxel); /* geometry has been checked */
    for (int i = 0; i < 3; i++)
        w.groups[i] = (p->bricks[i] + SC_GROUP_EDGE - 1) / SC_GROUP_EDGE;
    SC_TRY(sc_team_alloc(ctx, p->team, p->brick_count, sizeof *w.wanted, &wanted));
    w.wanted = wanted;
    sc_team_for(p->team, (size_t)p->bricks[1] * (size_t)p->bricks[2], 16, want_bricks, &w);
    SC_TRY(sc_number_bricks(ctx, p, w.wanted, &number, &count));
    w.number = number;
    SC_TRY(sc_team_alloc(ctx, p->team, count + 1, sizeof *w.sides, &sides));
    w.sides = sides;
    SC_TRY(sc_team_alloc(ctx, p->team, count + 1, sizeof *w.codes, &codes));
    w.codes = codes;
    SC_TRY(sc_team_alloc(ctx, p->team, count + 1, sizeof *w.inner, &inner));
    w.inner = inner;
    sc_find_sides(ctx, &w);
    SC_TRY(sc_mark_borders(ctx, &w));
    sc_team_stage_for(ctx, SC_WORTH_BORDERS / 2, p->team, sc_brick_count(w.groups), 4, write_groups,
                      &w);
out:
    sc_team_free(p->team, number);
    sc_team_free(p->team, wanted);
    sc_team_free(p->team, sides);
    sc_team_free(p->team, codes);
    sc_team_free(p->team, inner);
    return status;
}
