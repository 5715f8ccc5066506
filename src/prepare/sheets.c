/* SPDX-License-Identifier: BSD-3-Clause */
/* Sheets of tissue one voxel thick, such as a skin, keep what lies behind them from showing
 * through.
 *
 * The filter of fields.c takes nearly all weight from a label that is thinner than the filter, and
 * between the centres of its voxels its neighbours would own the points: the sheet would be full of
 * holes. So the weights of its voxels are raised here until no gap is left.
 *
 * Which voxels: a voxel belongs to a sheet if those of its 26 neighbours that carry other labels
 * fall into two or more parts that touch its faces and are not connected with each other by faces.
 * Around a voxel of a thin tube, or at the border of something thick, they are connected. A sheet
 * that no path of voxels joined by faces can cross (a 6-separating one) may have voxels that could
 * be spared one at a time, so voxels of the same label beside those of the sheet count as well.
 *
 * How far: the largest vote lets no ray through a sheet if every corner of a cell that carries the
 * sheet's label weighs at least RATIO_APART times as much as any other corner. That is the smallest
 * ratio with which, in each of the 256 patterns of sheet and no sheet at the corners of a cell, the
 * parts that the pattern keeps apart own regions that do not touch. Where both sides of the sheet
 * carry one label, their votes add up, and the ratio has to be RATIO_SAME; then the weights of the
 * others are lowered, too. Both ratios come from trying all patterns, as tests/unit/test_sheets.c
 * does; a little is added for the rounding of weights. */
#include "internal.h"

#define RATIO_APART 0.65f
#define RATIO_SAME 1.30f

enum {
    AROUND = SC_AROUND,
    CENTRE = SC_AROUND_CENTRE,
    SAME = 0x80,  /* of a mark: both sides of the sheet have a label in common */
    WEIGHT = 0x7f /* of a mark: the new weight */
};
/* Those of AROUND, as bits, that lie beside a face. */
#define FACES (1u << 4 | 1u << 10 | 1u << 12 | 1u << 14 | 1u << 16 | 1u << 22)

/* What the threads share. The arrays are of the team. */
typedef struct sheets {
    sc_preparation *p; /* borrowed; its records are changed by the last pass */
    uint8_t *marks;    /* [near_count]: 0, or the new weight of a voxel of a sheet, and SAME */
    uint8_t *weights;  /* [near_count]: the new weight of a vertex, or 0 if it keeps its own */
    uint8_t *found;    /* [brick_count]: 1 if a brick has marks */
} sheets;

/* Does (x, y, z) lie in the volume? */
static bool in_volume(const sc_volume *v, int x, int y, int z)
{
    return x >= 0 && y >= 0 && z >= 0 && x < v->size[0] && y < v->size[1] && z < v->size[2];
}

/* Does the voxel (x, y, z) lie inside of the volume, with all its neighbours? */
static bool is_inner(const sc_volume *v, int x, int y, int z)
{
    return x > 0 && y > 0 && z > 0 && x < v->size[0] - 1 && y < v->size[1] - 1 &&
           z < v->size[2] - 1;
}

/* Write the labels of the voxel (x, y, z) and its neighbours to @p ids [AROUND]; outside of the
 * volume, those of the nearest voxels. */
static void fetch_around(const sc_volume *v, int x, int y, int z, uint32_t *ids)
{
    const size_t row = (size_t)v->size[0], layer = row * (size_t)v->size[1];
    size_t low;

    if (!is_inner(v, x, y, z)) {
        for (int i = 0; i < AROUND; i++)
            ids[i] = sc_id_or_nearest(v, x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1);
        return;
    }
    low = (size_t)(z - 1) * layer + (size_t)(y - 1) * row + (size_t)(x - 1);
    for (size_t dz = 0; dz < 3; dz++) {
        for (size_t dy = 0; dy < 3; dy++) {
            for (size_t dx = 0; dx < 3; dx++)
                *ids++ = sc_id_at(v, low + dz * layer + dy * row + dx);
        }
    }
}

/* May a voxel, an sc_boundary_voxel, be one of a sheet? False if fewer than two of the voxels that
 * share a face with it carry another label, as on most of a smooth surface; quick to tell. */
static bool may_be_sheet(const sc_volume *v, const sc_boundary_voxel *voxel)
{
    const size_t row = (size_t)v->size[0], layer = row * (size_t)v->size[1];
    size_t at;

    if (!is_inner(v, voxel->x, voxel->y, voxel->z))
        return true;
    at = (size_t)voxel->z * layer + (size_t)voxel->y * row + (size_t)voxel->x;
    return (sc_id_at(v, at - 1) != voxel->id) + (sc_id_at(v, at + 1) != voxel->id) +
               (sc_id_at(v, at - row) != voxel->id) + (sc_id_at(v, at + row) != voxel->id) +
               (sc_id_at(v, at - layer) != voxel->id) + (sc_id_at(v, at + layer) != voxel->id) >
           1;
}

/* @return the index of the record of voxel (x, y, z), which must be near an interface. */
static size_t record_index(const sc_preparation *p, int x, int y, int z)
{
    const size_t brick =
        sc_brick_index(p->bricks, sc_brick_of(x + 1), sc_brick_of(y + 1), sc_brick_of(z + 1));

    return p->near_start[brick] + sc_brick_rank(p->near[brick], sc_brick_bit(x + 1, y + 1, z + 1));
}

/* Is the voxel at @p at near an interface? False outside of the grid. */
static bool is_near(const sc_preparation *p, const int at[3])
{
    for (int i = 0; i < 3; i++) {
        if (at[i] < -1 || at[i] > p->volume->size[i])
            return false;
    }
    return p->near[sc_brick_index(p->bricks, sc_brick_of(at[0] + 1), sc_brick_of(at[1] + 1),
                                  sc_brick_of(at[2] + 1))] >>
               sc_brick_bit(at[0] + 1, at[1] + 1, at[2] + 1) &
           1;
}

/* @return the weight, from the fields, of the voxel beside (x, y, z) that has index @p i in an
 * array of AROUND; outside of the volume, that of the nearest voxel. It must be near an interface,
 * as every neighbour with another label is. */
static int weight_beside(const sc_preparation *p, int x, int y, int z, int i)
{
    const int *size = p->volume->size;
    const size_t index = record_index(p, sc_nearest_voxel(x + i % 3 - 1, size[0]),
                                      sc_nearest_voxel(y + i / 3 % 3 - 1, size[1]),
                                      sc_nearest_voxel(z + i / 9 - 1, size[2]));

    return (int)sc_record_weight(sc_record_read(p->records, index));
}

/* The weights of the neighbours of a voxel that carry other labels. */
typedef struct weights_around {
    int largest;
    float mean; /* of those that share a face with the voxel */
} weights_around;

/* @return the weights around the voxel (x, y, z). @param ids of fetch_around. */
static weights_around weights_of_others(const sc_preparation *p, int x, int y, int z,
                                        const uint32_t ids[AROUND])
{
    weights_around out = {0, 0};
    int count = 0;

    for (int i = 0; i < AROUND; i++) {
        int weight;

        if (ids[i] == ids[CENTRE])
            continue;
        weight = weight_beside(p, x, y, z, i);
        out.largest = weight > out.largest ? weight : out.largest;
        if (FACES >> i & 1) {
            out.mean += (float)weight;
            count++;
        }
    }
    out.mean /= (float)(count ? count : 1);
    return out;
}

/* @return the least weight that is @p ratio times @p other or more, SC_WEIGHT_MAX at most. */
static int at_least(float ratio, int other)
{
    const int weight = (int)ceilf(ratio * (float)other);

    return weight < SC_WEIGHT_MAX ? weight : SC_WEIGHT_MAX;
}

/* @return the mark of a voxel, an sc_boundary_voxel: 0 unless it is one of a sheet that weighs too
 * little. The new weight is that of the voxels beside it, so that the surface lies midway, or more
 * where the ratio asks for it. */
static uint8_t mark_of(const sc_preparation *p, const sc_boundary_voxel *voxel)
{
    const int old = (int)sc_record_weight(sc_record_read(p->records, voxel->record));
    uint32_t ids[AROUND];
    weights_around others;
    int apart, weight;

    if (!may_be_sheet(p->volume, voxel))
        return 0;
    fetch_around(p->volume, voxel->x, voxel->y, voxel->z, ids);
    apart = sc_sheet_keeps_apart(ids);
    if (!apart)
        return 0;
    others = weights_of_others(p, voxel->x, voxel->y, voxel->z, ids);
    weight = at_least(apart & SC_APART_SAME_LABEL ? RATIO_SAME : RATIO_APART, others.largest);
    weight = weight > (int)(others.mean + 0.5f) ? weight : (int)(others.mean + 0.5f);
    weight = weight > old ? weight : old;
    return (uint8_t)(weight | (apart & SC_APART_SAME_LABEL ? SAME : 0));
}

/* Mark one voxel; an sc_boundary_fn on sheets. */
static void mark_voxel(void *user, const sc_boundary_voxel *voxel)
{
    const sheets *s = user;

    s->marks[voxel->record] = mark_of(s->p, voxel);
}

/* Fill the marks of bricks [begin, end), and found; an sc_range_fn on sheets. */
static void mark_bricks(void *user, size_t begin, size_t end, int thread)
{
    sheets *s = user;

    (void)thread;
    sc_each_boundary(s->p, begin, end, mark_voxel, s);
    for (size_t brick = begin; brick < end; brick++) {
        const size_t first = s->p->near_start[brick];
        const unsigned count = sc_count_bits(s->p->near[brick]);

        for (unsigned i = 0; i < count && !s->found[brick]; i++)
            s->found[brick] = s->marks[first + i] != 0;
    }
}

/* @return those vertices of a brick that touch the brick beside it at (@p dx, @p dy, @p dz), each
 * -1 to 1; all, if that is the brick itself. */
static uint64_t facing(int dx, int dy, int dz)
{
    uint64_t bits = ~0ull;

    bits &= dx < 0 ? SC_BRICK_LOW_X : dx > 0 ? SC_BRICK_LOW_X << (SC_BRICK - 1) : ~0ull;
    bits &= dy < 0 ? SC_BRICK_LOW_Y : dy > 0 ? SC_BRICK_LOW_Y << (SC_BRICK - 1) * SC_BRICK : ~0ull;
    bits &= dz < 0   ? SC_BRICK_LOW_Z
            : dz > 0 ? SC_BRICK_LOW_Z << (SC_BRICK - 1) * SC_BRICK_LAYER
                     : ~0ull;
    return bits;
}

/* @return the vertices of a brick near an interface that may touch a marked one: those of the
 * brick, if it has marks, and those that face a brick with marks. */
static uint64_t near_marks(const sheets *s, size_t brick)
{
    const int *bricks = s->p->bricks;
    uint64_t bits = 0;
    int at[3];

    sc_brick_at(bricks, brick, at);
    for (int i = 0; i < AROUND; i++) {
        const int dx = i % 3 - 1, dy = i / 3 % 3 - 1, dz = i / 9 - 1;
        const int x = at[0] + dx, y = at[1] + dy, z = at[2] + dz;

        if (x >= 0 && y >= 0 && z >= 0 && x < bricks[0] && y < bricks[1] && z < bricks[2] &&
            s->found[sc_brick_index(bricks, x, y, z)])
            bits |= facing(dx, dy, dz);
    }
    return bits & s->p->near[brick];
}

/* @return the weight of a vertex at voxel (x, y, z) that has no mark of its own. Beside a sheet of
 * its own label it is raised as that is. Beside one of another label that has the same label on
 * both sides it is lowered. Elsewhere it stays @p old. */
static int weight_beside_sheet(const sheets *s, int x, int y, int z, int old)
{
    uint32_t ids[AROUND];
    int raised = 0, limit = SC_WEIGHT_MAX;

    fetch_around(s->p->volume, x, y, z, ids);
    for (int i = 0; i < AROUND; i++) {
        const int at[3] = {x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1};
        const int mark = is_near(s->p, at) ? s->marks[record_index(s->p, at[0], at[1], at[2])] : 0;
        const int weight = mark & WEIGHT;

        if (mark && ids[i] == ids[CENTRE])
            raised = weight > raised ? weight : raised;
        else if (mark & SAME && (int)((float)weight / RATIO_SAME) < limit)
            limit = (int)((float)weight / RATIO_SAME);
    }
    if (raised) {
        const int least = at_least(RATIO_APART, weights_of_others(s->p, x, y, z, ids).largest);

        raised = raised > least ? raised : least;
        return raised > old ? raised : old;
    }
    limit = limit < old ? limit : old;
    return limit > 1 ? limit : 1;
}

/* Find the new weights of the vertices of a brick. Those of vertices outside of the volume are not
 * used. */
static void weigh_brick(sheets *s, size_t brick)
{
    const sc_preparation *p = s->p;
    int low[3];

    sc_brick_low(p->bricks, brick, low);
    for (uint64_t left = near_marks(s, brick); left; left &= left - 1) {
        const int bit = __builtin_ctzll(left);
        const size_t index = p->near_start[brick] + sc_brick_rank(p->near[brick], bit);
        const int old = (int)sc_record_weight(sc_record_read(p->records, index));
        const int x = low[0] + sc_bit_x(bit) - 1, y = low[1] + sc_bit_y(bit) - 1,
                  z = low[2] + sc_bit_z(bit) - 1;

        if (!in_volume(p->volume, x, y, z))
            continue;
        if (s->marks[index])
            s->weights[index] = s->marks[index] & WEIGHT;
        else
            s->weights[index] = (uint8_t)weight_beside_sheet(s, x, y, z, old);
    }
}

/* Find the new weights of bricks [begin, end); an sc_range_fn on sheets. */
static void weigh_bricks(void *user, size_t begin, size_t end, int thread)
{
    sheets *s = user;

    (void)thread;
    for (size_t brick = begin; brick < end; brick++) {
        if (s->p->near[brick])
            weigh_brick(s, brick);
    }
}

/* Write the new weights to the records. */
static void store_bricks(void *user, size_t begin, size_t end, int thread)
{
    const sheets *s = user;

    (void)thread;
    for (size_t brick = begin; brick < end; brick++) {
        const size_t first = s->p->near_start[brick];
        const unsigned count = sc_count_bits(s->p->near[brick]);

        for (size_t i = first; i < first + count; i++) {
            const uint32_t old = sc_record_read(s->p->records, i);

            if (s->weights[i])
                sc_record_write(s->p->records, i,
                                (old & ~(uint32_t)SC_RECORD_WEIGHT_MASK) | s->weights[i]);
        }
    }
}

sc_status sc_close_sheets(const sc_ctx *ctx, sc_preparation *p)
{
    sheets s = {.p = p};
    const uint64_t each = SC_WORTH_SHEETS / 3; /* there are so many loops */
    void *block;
    sc_status status;

    if (!sc_is_smoothed(p))
        return SC_OK;
    SC_TRY(sc_team_alloc(ctx, p->team, p->near_count, 1, &block));
    s.marks = block;
    SC_TRY(sc_team_alloc(ctx, p->team, p->near_count, 1, &block));
    s.weights = block;
    SC_TRY(sc_team_alloc(ctx, p->team, p->brick_count, 1, &block));
    s.found = block;
    sc_team_stage_for(ctx, each, p->team, p->brick_count, 4096, mark_bricks, &s);
    sc_team_stage_for(ctx, each, p->team, p->brick_count, 4096, weigh_bricks, &s);
    sc_team_stage_for(ctx, each, p->team, p->brick_count, 4096, store_bricks, &s);
out:
    sc_team_free(p->team, s.marks);
    sc_team_free(p->team, s.weights);
    sc_team_free(p->team, s.found);
    return status;
}
