/* SPDX-License-Identifier: BSD-3-Clause */
/* Smoother normals where a surface is flat at a larger scale. Segmentations often have finer voxels
 * than the images they were drawn on, and the steps of those images show as rings in the light. The
 * directions of each label are summed over each brick, the sums are spread over neighbouring
 * bricks, and every vertex interpolates them from the 27 bricks around it by a quadratic B-spline;
 * together that is a filter with a standard deviation of 4.6 vertices. The two sides of a sheet,
 * whose directions are opposite, are summed apart. Where the directions of a side agree, their mean
 * has nearly the length 1, and it replaces the direction of the vertex. Over a bend or a thin tube
 * the mean is shorter, and at the rim of a sheet it is not like the direction of the vertex, which
 * then keeps its own.
 *
 * Vertices of tissue beside the background and no other tissue count, with their directions
 * reversed, to the background's side, and get its mean. So both sides of a surface have one mean,
 * and where another tissue begins the border towards that does not make it lean. */
#include "internal.h"

#include <string.h>

enum {
    ENTRIES = 6, /* sides of labels in a brick that are summed; those of a seventh are left out */
    SPREADS = 2  /* times that the sums are spread, each by (1 2 1) / 4 along every axis */
};

/* The mean is blended in from the length AGREE_LEAST on, and from AGREE_ALL on it replaces the
 * vertex's own direction. */
#define AGREE_LEAST 0.90f
#define AGREE_ALL 0.965f
/* No mean is blended in if its cosine to the vertex's own direction is ALIKE_LEAST or less; from
 * ALIKE_ALL on, all of it is. */
#define ALIKE_LEAST 0.2f
#define ALIKE_ALL 0.5f

/* The x, y and z of a sum of directions, and how many they are. */
typedef float quad __attribute__((vector_size(16)));

/* The sum of the unit directions of one side of a label in a brick, and their number, which is a
 * fraction after spreading; count 0: a free entry, whose other fields are not used. A label has at
 * most two sides in a brick: directions within 90 degrees of the sum of the first, and the rest. */
typedef struct entry {
    float sum[3], count;
    uint32_t label;
} entry;

/* What the threads share. The arrays are of the team. */
typedef struct polish {
    const sc_preparation *p; /* borrowed; its records are changed */
    uint32_t *slot; /* [bricks]: where a brick's entries are; all bricks without any share slot 0 */
    size_t slot_count;
    entry *entries, *spread; /* [slot_count][ENTRIES]: the sums, and room for the next spreading.
                                Used entries come first; slot 0 has none. */
    float weights[SC_BRICK_VERTICES][27]; /* B-spline: of the 27 bricks around a vertex */
} polish;

/* Write the unit direction of a record's gradient, RAS, to @p out. */
static void direction_of(uint32_t record, float out[3])
{
    sc_record_normal(record & SC_RECORD_DIRECTION_BITS, out);
}

/* Does a brick hold vertices outside of the volume, or voxels at its border? */
static bool at_border(const sc_preparation *p, const int low[3])
{
    for (int i = 0; i < 3; i++) {
        if (low[i] < 2 || low[i] + SC_BRICK > p->volume->size[i])
            return true;
    }
    return false;
}

/* Write the dense ids of a brick's vertices near an interface to @p labels, by bit; what is written
 * for other vertices says nothing. */
static void labels_of(const sc_preparation *p, size_t brick, uint16_t labels[SC_BRICK_VERTICES])
{
    const sc_volume *v = p->volume;
    const size_t row = (size_t)v->size[0], layer = row * (size_t)v->size[1];
    size_t first;
    int low[3];

    sc_brick_low(p->bricks, brick, low);
    first = ((size_t)low[2] - 1) * layer + ((size_t)low[1] - 1) * row + (size_t)low[0] - 1;
    if (!at_border(p, low)) {
        for (int bit = 0; bit < SC_BRICK_VERTICES; bit++)
            labels[bit] =
                (uint16_t)sc_id_at(v, first + (size_t)sc_bit_z(bit) * layer +
                                          (size_t)sc_bit_y(bit) * row + (size_t)sc_bit_x(bit));
        return;
    }
    for (uint64_t left = p->near[brick]; left; left &= left - 1) {
        const int bit = __builtin_ctzll(left);

        labels[bit] =
            (uint16_t)sc_id_or_background(p->volume, low[0] + sc_bit_x(bit) - 1,
                                          low[1] + sc_bit_y(bit) - 1, low[2] + sc_bit_z(bit) - 1);
    }
}

static float dot(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Find the entry of a brick to which the direction @p n of a vertex of a label belongs: of the
 * label's sides, the one whose sum has the larger dot product with it. If there is only one, and
 * that product is negative, a free entry is the second side. The label is written to a free entry;
 * it stays free until the caller raises its count. @return NULL if all ENTRIES are taken. */
static entry *entry_for(entry *entries, uint32_t label, const float n[3])
{
    entry *best = NULL;

    for (int i = 0; i < ENTRIES; i++) {
        entry *e = &entries[i];

        if (e->count == 0) {
            if (best && dot(best->sum, n) >= 0)
                return best;
            e->label = label;
            return e;
        }
        if (e->label != label)
            continue;
        if (best) /* the second side */
            return dot(e->sum, n) > dot(best->sum, n) ? e : best;
        best = e;
    }
    return best;
}

/* @return those of a brick's vertices near an interface whose records have a direction: not those
 * outside of the volume, nor voxels at its border with nothing else around them. */
static uint64_t directed(const sc_preparation *p, size_t brick)
{
    const int *size = p->volume->size;
    size_t index = p->near_start[brick];
    uint64_t mask = p->near[brick];
    int low[3];

    sc_brick_low(p->bricks, brick, low);
    if (!at_border(p, low))
        return mask;
    for (uint64_t left = mask; left; left &= left - 1, index++) {
        const int bit = __builtin_ctzll(left), x = low[0] + sc_bit_x(bit),
                  y = low[1] + sc_bit_y(bit), z = low[2] + sc_bit_z(bit);
        const bool inside = x > 0 && y > 0 && z > 0 && x <= size[0] && y <= size[1] && z <= size[2];
        const uint32_t record = sc_record_read(p->records, index);

        if (!inside || sc_record_length_code(record) == SC_RECORD_SHORTEST)
            mask &= ~(1ull << bit);
    }
    return mask;
}

/* For each of a brick's vertices near an interface, by bit: write the label to whose side its
 * direction counts to @p labels. @return those of which it counts reversed: vertices of tissue that
 * count to the background's side. */
static uint64_t find_owners(const sc_preparation *p, size_t brick,
                            uint16_t labels[SC_BRICK_VERTICES])
{
    uint64_t reversed, at_seam;
    int low[3];

    sc_brick_low(p->bricks, brick, low);
    reversed = p->near[brick] & sc_beside_background(p->volume, low, &at_seam);
    reversed &= ~at_seam;
    labels_of(p, brick, labels);
    for (uint64_t left = reversed; left; left &= left - 1)
        labels[__builtin_ctzll(left)] = 0;
    return reversed;
}

/* Write the unit direction of the record at an index, RAS, to @p out, reversed if asked for. */
static void owned_direction(const sc_preparation *p, size_t index, bool reversed, float out[3])
{
    direction_of(sc_record_read(p->records, index), out);
    for (int i = 0; i < 3 && reversed; i++)
        out[i] = -out[i];
}

/* Add the directions of a brick's vertices to its entries, @p entries [ENTRIES]. */
static void sum_brick(const polish *w, size_t brick, entry *entries)
{
    const uint64_t near = w->p->near[brick];
    uint16_t labels[SC_BRICK_VERTICES];
    const uint64_t reversed = find_owners(w->p, brick, labels);

    for (uint64_t left = directed(w->p, brick); left; left &= left - 1) {
        const int bit = __builtin_ctzll(left);
        const size_t index = w->p->near_start[brick] + sc_brick_rank(near, bit);
        entry *e;
        float n[3];

        owned_direction(w->p, index, reversed >> bit & 1, n);
        e = entry_for(entries, labels[bit], n);
        if (!e)
            continue;
        for (int i = 0; i < 3; i++)
            e->sum[i] += n[i];
        e->count++;
    }
}

/* Fill the entries of bricks [begin, end); an sc_range_fn on a polish. They must be zero before. */
static void sum_bricks(void *user, size_t begin, size_t end, int thread)
{
    const polish *w = user;

    (void)thread;
    for (size_t brick = begin; brick < end; brick++) {
        if (w->slot[brick])
            sum_brick(w, brick, w->entries + (size_t)w->slot[brick] * ENTRIES);
    }
}

/* Point @p out at the entries [ENTRIES] of each of the 27 bricks around a brick, x fastest; out[13]
 * is the brick itself. Bricks outside of the volume get slot 0, without entries. */
static void find_neighbours(const polish *w, size_t brick, const entry *out[27])
{
    const sc_preparation *p = w->p;
    const size_t row = (size_t)p->bricks[0], layer = row * (size_t)p->bricks[1];
    bool inner = true;
    int at[3];

    sc_brick_at(p->bricks, brick, at);
    for (int i = 0; i < 3; i++)
        inner = inner && at[i] > 0 && at[i] + 1 < p->bricks[i];
    for (size_t n = 0; n < 27 && inner; n++)
        out[n] =
            w->entries +
            ENTRIES *
                (size_t)w->slot[brick - layer - row - 1 + n / 9 * layer + n / 3 % 3 * row + n % 3];
    for (int n = 0; n < 27 && !inner; n++) {
        const int x = at[0] + n % 3 - 1, y = at[1] + n / 3 % 3 - 1, z = at[2] + n / 9 - 1;
        const bool inside =
            x >= 0 && y >= 0 && z >= 0 && x < p->bricks[0] && y < p->bricks[1] && z < p->bricks[2];
        const size_t slot = inside ? w->slot[sc_brick_index(p->bricks, x, y, z)] : 0;

        out[n] = w->entries + slot * ENTRIES;
    }
}

/* @return what a brick's @p entries [ENTRIES] hold of the side of a label that has the directions
 * of @p side, an entry of a brick beside it: the sum of those that are not opposed to it, as x, y,
 * z and count. */
static quad same_side(const entry *entries, const entry *side)
{
    quad out = {0, 0, 0, 0};

    for (int i = 0; i < ENTRIES && entries[i].count > 0; i++) {
        const entry *e = &entries[i];

        if (e->label == side->label && dot(e->sum, side->sum) > 0)
            out += (quad){e->sum[0], e->sum[1], e->sum[2], e->count};
    }
    return out;
}

/* Spread the sums once: write to spread, for each of the entries of bricks [begin, end), the sum of
 * its side over the 27 bricks around, weighted by (1 2 1) / 4 along every axis. An sc_range_fn on a
 * polish. */
static void spread_bricks(void *user, size_t begin, size_t end, int thread)
{
    static const float share[3] = {0.25f, 0.5f, 0.25f};
    const polish *w = user;

    (void)thread;
    for (size_t brick = begin; brick < end; brick++) {
        const size_t first = (size_t)w->slot[brick] * ENTRIES;
        const entry *around[27];

        if (!first)
            continue;
        find_neighbours(w, brick, around);
        for (int i = 0; i < ENTRIES; i++) {
            const entry *side = &w->entries[first + (size_t)i];
            quad sum = {0, 0, 0, 0};

            for (int n = 0; n < 27 && side->count > 0; n++)
                sum += share[n % 3] * share[n / 3 % 3] * share[n / 9] * same_side(around[n], side);
            w->spread[first + (size_t)i] =
                (entry){.sum = {sum[0], sum[1], sum[2]}, .count = sum[3], .label = side->label};
        }
    }
}

/* Write the sums of the side of a label in the 27 bricks around to @p out; see same_side. */
static void gather_side(const entry *const around[27], const entry *side, quad out[27])
{
    for (int n = 0; n < 27; n++)
        out[n] = same_side(around[n], side);
}

/* @return 0 up to @p least, 1 from @p all on, and a smooth step between; 0 for NaN. */
static float smooth_step(float x, float least, float all)
{
    const float t = (x - least) / (all - least);

    if (!(t > 0))
        return 0;
    return t < 1 ? t * t * (3 - 2 * t) : 1;
}

/* Find the mean direction around the vertex of bit @p bit. @param own its own direction. @param
 * sums of gather_side, for the vertex's side. @param out the unit mean; not written if the share is
 * 0. @return the share, 0 to 1, in which it replaces the vertex's own; 0 where the directions do
 * not agree, or there are none. */
static float mean_direction(const polish *w, int bit, const float own[3], const quad sums[27],
                            float out[3])
{
    quad total = {0};
    float length, agree;

    for (int n = 0; n < 27; n++)
        total += w->weights[bit][n] * sums[n];
    length = sqrtf(total[0] * total[0] + total[1] * total[1] + total[2] * total[2]);
    agree = smooth_step(length / total[3], AGREE_LEAST, AGREE_ALL);
    if (!(agree > 0))
        return 0;
    for (int i = 0; i < 3; i++)
        out[i] = total[i] / length;
    return agree * smooth_step(dot(own, out), ALIKE_LEAST, ALIKE_ALL);
}

/* @return how strongly the directions of a label are smoothed, 0 to 1: as much as its surface along
 * the axis of the least strength. Those of the background are smoothed as much as those of any
 * label. */
static double strength_of(const sc_preparation *p, uint32_t label)
{
    double strength = 0;

    for (int k = 0; k < p->kind_count; k++) {
        if (label == 0 || k == p->kind_of[label])
            strength = fmax(strength, sc_least_strength(p->kinds[k]));
    }
    return strength < 1 ? strength : 1;
}

/* Smooth the direction in record @p index, of the vertex of bit @p bit: turn it towards the mean of
 * its side around it, by the share of mean_direction times the strength of the smoothing. Weight
 * and length in the record stay. @param smooth of strength_of, and @param sums of gather_side, for
 * the vertex's side. @param reversed whether its direction counts reversed there. */
static void polish_vertex(const polish *w, int bit, size_t index, double smooth,
                          const quad sums[27], bool reversed)
{
    const uint32_t old = sc_record_read(w->p->records, index);
    float own[3], mean[3] = {0, 0, 0};
    double share, sign = reversed ? -1 : 1;
    sc_vec3 mixed;
    uint32_t smoothed;

    owned_direction(w->p, index, reversed, own);
    share = smooth * (double)mean_direction(w, bit, own, sums, mean);
    if (!(share > 0))
        return;
    mixed = (sc_vec3){sign * (own[0] + share * (mean[0] - own[0])),
                      sign * (own[1] + share * (mean[1] - own[1])),
                      sign * (own[2] + share * (mean[2] - own[2]))};
    smoothed = (sc_record_pack(0, mixed, 1) & SC_RECORD_DIRECTION_BITS) |
               (old & ~(uint32_t)SC_RECORD_DIRECTION_BITS);
    sc_record_write(w->p->records, index, smoothed);
}

/* Find the vertices of each side of each label in a brick. @param entries [ENTRIES] of the brick.
 * @param out [ENTRIES] the vertices, by bit, of each entry; a vertex is in one at most. @return
 * those whose directions count reversed. */
static uint64_t find_sides(const polish *w, size_t brick, entry *entries, uint64_t out[ENTRIES])
{
    uint16_t labels[SC_BRICK_VERTICES];
    const uint64_t reversed = find_owners(w->p, brick, labels);

    memset(out, 0, ENTRIES * sizeof *out);
    for (uint64_t left = directed(w->p, brick); left; left &= left - 1) {
        const int bit = __builtin_ctzll(left);
        const size_t index = w->p->near_start[brick] + sc_brick_rank(w->p->near[brick], bit);
        const entry *e;
        float n[3];

        owned_direction(w->p, index, reversed >> bit & 1, n);
        e = entry_for(entries, labels[bit], n);
        if (e && e->count > 0)
            out[e - entries] |= 1ull << bit;
    }
    return reversed;
}

/* Smooth the directions in the records of all vertices of a brick near an interface, one side of a
 * label at a time. */
static void polish_brick(const polish *w, size_t brick)
{
    entry *entries = w->entries + (size_t)w->slot[brick] * ENTRIES;
    const entry *around[27];
    uint64_t vertices[ENTRIES], reversed;

    find_neighbours(w, brick, around);
    reversed = find_sides(w, brick, entries, vertices);
    for (int i = 0; i < ENTRIES; i++) {
        const double smooth = vertices[i] ? strength_of(w->p, entries[i].label) : 0;
        quad sums[27];

        if (!(smooth > 0))
            continue;
        gather_side(around, &entries[i], sums);
        for (uint64_t mask = vertices[i]; mask; mask &= mask - 1) {
            const int bit = __builtin_ctzll(mask);

            polish_vertex(w, bit, w->p->near_start[brick] + sc_brick_rank(w->p->near[brick], bit),
                          smooth, sums, reversed >> bit & 1);
        }
    }
}

/* Smooth the directions in the records of bricks [begin, end); an sc_range_fn on a polish. */
static void polish_bricks(void *user, size_t begin, size_t end, int thread)
{
    const polish *w = user;

    (void)thread;
    for (size_t brick = begin; brick < end; brick++) {
        if (w->slot[brick])
            polish_brick(w, brick);
    }
}

/* Give a slot to each brick with a vertex near an interface, and allocate zeroed entries for them.
 * Returns SC_ERR_MEMORY; what has been allocated until then is in @p w, for the caller to free. */
static sc_status allocate(const sc_ctx *ctx, polish *w)
{
    uint64_t used = 0;
    void *block;
    sc_status status;

    SC_TRY(sc_number_bricks(ctx, w->p, &w->slot, &used));
    w->slot_count = 1 + (size_t)used;
    SC_TRY(sc_team_alloc(ctx, w->p->team, w->slot_count * ENTRIES, sizeof(entry), &block));
    w->entries = block;
    SC_TRY(sc_team_alloc(ctx, w->p->team, w->slot_count * ENTRIES, sizeof(entry), &block));
    w->spread = block;
out:
    return status;
}

/* Fill w->weights with the weights of the quadratic B-spline, which add up to 1 for each vertex. */
static void fill_weights(polish *w)
{
    float along[SC_BRICK][3];

    for (int i = 0; i < SC_BRICK; i++) {
        const float t = ((float)i + 0.5f) / SC_BRICK - 0.5f;

        along[i][0] = 0.5f * (0.5f - t) * (0.5f - t);
        along[i][1] = 0.75f - t * t;
        along[i][2] = 0.5f * (0.5f + t) * (0.5f + t);
    }
    for (int bit = 0; bit < SC_BRICK_VERTICES; bit++) {
        for (int n = 0; n < 27; n++)
            w->weights[bit][n] = along[sc_bit_x(bit)][n % 3] * along[sc_bit_y(bit)][n / 3 % 3] *
                                 along[sc_bit_z(bit)][n / 9];
    }
}

sc_status sc_polish_fields(const sc_ctx *ctx, sc_preparation *p)
{
    polish w = {.p = p};
    const uint64_t each = SC_WORTH_POLISH / (SPREADS + 2); /* there are so many loops */
    sc_status status;

    if (!sc_is_smoothed(p))
        return SC_OK;
    SC_TRY(allocate(ctx, &w));
    fill_weights(&w);
    sc_team_stage_for(ctx, each, p->team, p->brick_count, 4096, sum_bricks, &w);
    for (int i = 0; i < SPREADS; i++) {
        entry *swap = w.entries;

        sc_team_stage_for(ctx, each, p->team, p->brick_count, 4096, spread_bricks, &w);
        w.entries = w.spread;
        w.spread = swap;
    }
    sc_team_stage_for(ctx, each, p->team, p->brick_count, 4096, polish_bricks, &w);
out:
    sc_team_free(p->team, w.slot);
    sc_team_free(p->team, w.entries);
    sc_team_free(p->team, w.spread);
    return status;
}
