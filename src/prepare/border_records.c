/* SPDX-License-Identifier: BSD-3-Clause */
/* The records of vertices from the fields of borders: on which side a vertex lies, which tissue it
 * has, and values and gradients of both fields. A vertex may come to lie on another side than its
 * voxel, or get another tissue, one of those around it: about one in a hundred does. Beyond the
 * volume fields go on linearly, so that what ends at its border ends round.
 *
 * This is done for groups of bricks of SC_CUBE vertices along each axis. Vertex q is voxel q - 1.
 */
#include "border.h"

enum {
    BRICKS = SC_CUBE / SC_BRICK, /* along an edge of a group */
    GROUP_BRICKS = BRICKS * BRICKS * BRICKS,
    IDS = SC_CUBE + 2, /* edge of the labels of a group and those around */
    ID_ROW = 24,       /* room for a row of them */
    HALO = 3,          /* voxels around a group that gradients come from */
    WIDE = SC_CUBE + 2 * HALO,
    FLAT = WIDE - 4, /* edge of what has been blurred twice */
    BEFORE = 2,      /* voxels before a group from which its field goes on beyond the volume */
    SIDED = SC_CUBE + BEFORE,
    QUARTERS = SC_CUBE_QUARTERS + 2, /* edge of the quarters that a group lies between */
    AROUND = SC_TISSUE_CODES
};

/* How much farther than half a voxel beyond its last voxels tissue ends that goes on beyond the
 * volume, in voxels, about. */
#define LIFT 0.25f

/* What the threads share. */
typedef struct writer {
    const sc_borders *b;
    sc_preparation *p;
    sc_affine to_voxel; /* RAS mm -> voxel */
    int groups[3];
    uint64_t *wanted; /* [brick_count]: not 0 for bricks that hold, or touch, a vertex near one */
    const uint32_t *number;
    sc_brick_sides *sides;
    uint8_t (*codes)[SC_BRICK_VERTICES];
    uint8_t (*inner)[SC_BRICK_VERTICES]; /* value of the record; 0 if it has not been found */
} writer;

/* Labels of a group and around it; beyond the volume those of the nearest voxels. */
typedef struct group_ids {
    uint16_t at[IDS][IDS][ID_ROW];
} group_ids;

/* The places of the 3x3x3, as of sc_tissue_code: those that share a face first, then an edge, then
 * a corner. */
static const uint8_t nearest_first[AROUND] = {13, 4,  10, 12, 14, 16, 22, 1, 3, 5,  7,  9,  11, 15,
                                              17, 19, 21, 23, 25, 0,  2,  6, 8, 18, 20, 24, 26};

/* Raise the outer field of a region beyond the volume by LIFT, so that what goes on there is cut
 * off by the face of the volume, and what only touches it ends round. */
static void lift_beyond(const sc_borders *b, const int low[3], int edge, float *region)
{
    const int *size = b->p->volume->size;
    bool inside = true;

    for (int i = 0; i < 3; i++)
        inside = inside && low[i] >= 0 && low[i] + edge <= size[i];
    for (int i = 0; i < edge * edge * edge && !inside; i++) {
        const int x = low[0] + i % edge, y = low[1] + i / edge % edge,
                  z = low[2] + i / (edge * edge);

        if (x < 0 || y < 0 || z < 0 || x >= size[0] || y >= size[1] || z >= size[2])
            region[i] += LIFT;
    }
}

/* @return the number that the constant of sc_borders.beside stands for; 0 for a tile. */
static float constant_of(uint32_t beside)
{
    return beside == SC_BESIDE(SC_BESIDE_HIGH)  ? SC_FAR
           : beside == SC_BESIDE(SC_BESIDE_LOW) ? -SC_FAR
                                                : 0;
}

/* Read the part of a region that lies in the cube at @p at, in cubes. @return whether it has a tile
 * of the field of @p label. */
static bool read_cube(const sc_borders *b, uint32_t label, const int at[3], const int low[3],
                      int edge, float *out)
{
    const uint32_t tile = sc_tile_of(b, sc_brick_index(b->cubes, at[0], at[1], at[2]), label);
    const bool is = tile < SC_BESIDE(0);
    const float sign = is && tile & SC_MIRRORED ? -1 / SC_FINE_STEPS : 1 / SC_FINE_STEPS;
    const float far = constant_of(tile);
    int begin[3], end[3];

    for (int i = 0; i < 3; i++) {
        const int first = at[i] * SC_CUBE - b->phase[i];

        begin[i] = first > low[i] ? first : low[i];
        end[i] = first + SC_CUBE < low[i] + edge ? first + SC_CUBE : low[i] + edge;
    }
    for (int z = begin[2]; z < end[2]; z++) {
        for (int y = begin[1]; y < end[1]; y++) {
            float *to = out + ((z - low[2]) * edge + y - low[1]) * edge + begin[0] - low[0];
            const int16_t *from =
                b->fine[is ? tile & ~SC_MIRRORED : 0] +
                ((z + b->phase[2]) % SC_CUBE * SC_CUBE + (y + b->phase[1]) % SC_CUBE) * SC_CUBE +
                (begin[0] + b->phase[0]) % SC_CUBE;

            for (int x = 0; x < end[0] - begin[0]; x++)
                to[x] = is ? sign * (float)from[x] : far;
        }
    }
    return is;
}

/* Read numbers of the field of @p label, of the @p edge voxels along each axis from @p low on, to
 * @p out, beyond the volume going on linearly. @return false if its border is out of reach of all
 * of them. */
static bool read_field(const sc_borders *b, uint32_t label, const int low[3], int edge, float *out)
{
    const int *size = b->p->volume->size;
    int first[3], count[3];
    bool any = false;

    for (int i = 0; i < 3; i++) {
        const int high = low[i] + edge - 1 < size[i] ? low[i] + edge - 1 : size[i] - 1;

        first[i] = ((low[i] < 0 ? 0 : low[i]) + b->phase[i]) / SC_CUBE;
        count[i] = (high + b->phase[i]) / SC_CUBE - first[i] + 1;
    }
    for (int n = 0; n < count[0] * count[1] * count[2]; n++) {
        const int at[3] = {first[0] + n % count[0], first[1] + n / count[0] % count[1],
                           first[2] + n / (count[0] * count[1])};

        any = read_cube(b, label, at, low, edge, out) || any;
    }
    for (int axis = 0; axis < 3 && any; axis++) {
        const int begin = low[axis] < 0 ? -low[axis] : 0;
        const int end = low[axis] + edge < size[axis] ? edge : size[axis] - low[axis];

        if (begin > 0 || end < edge)
            sc_extrapolate_along(out, edge, axis, begin, end);
    }
    if (any && !label)
        lift_beyond(b, low, edge, out);
    return any;
}

/* @return the value of the field of @p label at a voxel. @param place its index within the block.
 */
static float value_at(const sc_borders *b, size_t block, int place, uint32_t label)
{
    const uint32_t tile = sc_tile_of(b, block, label);

    if (tile >= SC_BESIDE(0))
        return constant_of(tile);
    return tile & SC_MIRRORED ? -sc_of_fine(b->fine[tile & ~SC_MIRRORED][place])
                              : sc_of_fine(b->fine[tile][place]);
}

/* Read the labels of a group whose lowest voxel is @p low, and of those around. */
static void read_ids(const sc_volume *v, const int low[3], group_ids *out)
{
    for (int k = 0; k < IDS * IDS; k++) {
        const int y = sc_nearest_voxel(low[1] + k % IDS - 1, v->size[1]);
        const int z = sc_nearest_voxel(low[2] + k / IDS - 1, v->size[2]);
        const size_t row = ((size_t)z * (size_t)v->size[1] + (size_t)y) * (size_t)v->size[0];
        uint16_t *to = out->at[k / IDS][k % IDS];

        if (low[0] >= 1 && low[0] - 1 + ID_ROW <= v->size[0]) {
            sc_copy_ids(v, row + (size_t)(low[0] - 1), ID_ROW, to);
            continue;
        }
        for (int x = 0; x < IDS; x++)
            to[x] =
                (uint16_t)sc_id_at(v, row + (size_t)sc_nearest_voxel(low[0] + x - 1, v->size[0]));
    }
}

/* Where the places of codes stand in the labels of a group, from the lowest around a vertex on. */
#define PLACE(code) (((code) / 9 * IDS + (code) / 3 % 3) * ID_ROW + (code) % 3)
static const int places[AROUND] = {PLACE(0),  PLACE(1),  PLACE(2),  PLACE(3),  PLACE(4),  PLACE(5),
                                   PLACE(6),  PLACE(7),  PLACE(8),  PLACE(9),  PLACE(10), PLACE(11),
                                   PLACE(12), PLACE(13), PLACE(14), PLACE(15), PLACE(16), PLACE(17),
                                   PLACE(18), PLACE(19), PLACE(20), PLACE(21), PLACE(22), PLACE(23),
                                   PLACE(24), PLACE(25), PLACE(26)};

/* @return the label at the place of @p code from vertex (x, y, z) of a group. */
static inline uint16_t id_around(const group_ids *ids, int x, int y, int z, int code)
{
    return (&ids->at[0][0][0])[(z * IDS + y) * ID_ROW + x + places[code]];
}

/* @return the places, as bits by their codes, from which a step along an axis, away from the
 * vertex, leads to that of @p code; unless it is a corner, its own, too. */
static inline uint32_t places_before(int code)
{
    return 1u << (code - sc_tissue_step(code, 0)) | 1u << (code - 3 * sc_tissue_step(code, 1)) |
           1u << (code - 9 * sc_tissue_step(code, 2));
}

/* @return the code of the tissue that has the largest number at vertex @p at of a group, of those
 * around it; of equal ones the nearest. A vertex in the background takes only tissues that steps
 * through background lead to: numbers there go on freely from the tissue, and what lies beneath a
 * skin one voxel thick would show through it. @param voxel of the vertex.
 * @param values [2] set to the two largest numbers of all tissues around; -2 SC_FAR if there is
 * none. */
static int largest_tissue(const sc_borders *b, const group_ids *ids, const int at[3],
                          const int voxel[3], float values[2])
{
    const uint16_t own = id_around(ids, at[0], at[1], at[2], SC_TISSUE_OWN);
    uint32_t open = own ? UINT32_MAX : 1u << SC_TISSUE_OWN; /* places that have been reached */
    uint16_t seen[AROUND];
    float numbers[AROUND], most = -2 * SC_FAR;
    int count = 0, best = SC_TISSUE_OWN, within[3], cube[3], place;
    size_t block;

    for (int i = 0; i < 3; i++) { /* beyond the volume the nearest voxel */
        within[i] = sc_nearest_voxel(voxel[i], b->p->volume->size[i]) + b->phase[i];
        cube[i] = within[i] / SC_CUBE;
        within[i] %= SC_CUBE;
    }
    block = sc_brick_index(b->cubes, cube[0], cube[1], cube[2]);
    place = (within[2] * SC_CUBE + within[1]) * SC_CUBE + within[0];
    values[0] = values[1] = most;
    for (int k = 0; k < AROUND; k++) {
        const int code = nearest_first[k];
        const uint16_t id = id_around(ids, at[0], at[1], at[2], code);
        const bool reached = open & places_before(code);
        int i = 0;

        if (!id) {
            open |= (uint32_t)reached << code;
            continue;
        }
        while (i < count && seen[i] != id)
            i++;
        if (i == count) {
            const float value = value_at(b, block, place, id);
            const float less = value < values[0] ? value : values[0];

            seen[count] = id;
            numbers[count++] = value;
            values[0] = value > values[0] ? value : values[0];
            values[1] = less > values[1] ? less : values[1];
        }
        if (reached && numbers[i] > most) {
            most = numbers[i];
            best = code;
        }
    }
    return best;
}

/* Eight ids, side by side. */
typedef uint16_t eight_ids __attribute__((vector_size(8 * sizeof(uint16_t))));

static inline eight_ids lesser(eight_ids a, eight_ids c)
{
    const eight_ids is = (eight_ids)(a < c);

    return (a & is) | (c & ~is);
}

static inline eight_ids larger(eight_ids a, eight_ids c)
{
    return ~lesser(~a, ~c);
}

/* Write, for the bricks of a group, masks of the vertices around which there is tissue, and of
 * those around which there are different ones. */
static void find_tissues(const group_ids *ids, uint64_t any[GROUP_BRICKS],
                         uint64_t several[GROUP_BRICKS])
{
    enum { EIGHT = 8, PER_EIGHT = EIGHT / SC_BRICK };
    eight_ids least[SC_CUBE / EIGHT][IDS][IDS]; /* less 1, so that none is larger than all */
    eight_ids most[SC_CUBE / EIGHT][IDS][IDS];

    for (int k = 0; k < SC_CUBE / EIGHT * IDS * IDS; k++) {
        const int y = k % IDS, z = k / IDS % IDS, part = k / (IDS * IDS);
        eight_ids row[3];

        for (int x = 0; x < 3; x++)
            memcpy(&row[x], ids->at[z][y] + EIGHT * part + x, sizeof row[x]);
        least[part][z][y] = lesser(lesser(row[0] - 1, row[1] - 1), row[2] - 1);
        most[part][z][y] = larger(larger(row[0], row[1]), row[2]);
    }
    memset(any, 0, GROUP_BRICKS * sizeof *any);
    memset(several, 0, GROUP_BRICKS * sizeof *several);
    for (int k = 0; k < SC_CUBE / EIGHT * SC_CUBE * SC_CUBE; k++) {
        const int y = k % SC_CUBE, z = k / SC_CUBE % SC_CUBE, part = k / (SC_CUBE * SC_CUBE);
        const int brick = (z / SC_BRICK * BRICKS + y / SC_BRICK) * BRICKS + PER_EIGHT * part;
        eight_ids low = (eight_ids){0} - 1, high = {0};
        uint32_t none, same;

        for (int n = 0; n < 9; n++) {
            low = lesser(low, least[part][z + n / 3][y + n % 3]);
            high = larger(high, most[part][z + n / 3][y + n % 3]);
        }
        low = (low + 1) ^ high;
        none = sc_equal_bits((const uint16_t *)&high, 0);
        same = sc_equal_bits((const uint16_t *)&low, 0);
        for (int i = 0; i < PER_EIGHT; i++) {
            const int bit = sc_brick_bit(0, y, z), first = i * SC_BRICK;

            any[brick + i] |= (uint64_t)(~none >> first & SC_BRICK_ROW_BITS) << bit;
            several[brick + i] |= (uint64_t)(~same >> first & SC_BRICK_ROW_BITS) << bit;
        }
    }
}

/* Write the lowest vertex of a group to @p low. @return whether any of its bricks is wanted. */
static bool begin_group(const writer *w, const uint64_t *masks[2], size_t group, int low[3])
{
    bool any = false;

    sc_brick_at(w->groups, group, low);
    for (int i = 0; i < 3; i++)
        low[i] *= SC_CUBE;
    for (int n = 0; n < GROUP_BRICKS; n++) {
        const int x = low[0] / SC_BRICK + n % BRICKS, y = low[1] / SC_BRICK + n / BRICKS % BRICKS,
                  z = low[2] / SC_BRICK + n / (BRICKS * BRICKS);

        if (x < w->p->bricks[0] && y < w->p->bricks[1] && z < w->p->bricks[2]) {
            const size_t brick = sc_brick_index(w->p->bricks, x, y, z);

            any = any || masks[0][brick] || masks[1][brick];
        }
    }
    return any;
}

/* @return the brick of number @p n of a group, or SIZE_MAX if there is none. */
static size_t brick_of_group(const writer *w, const int low[3], int n)
{
    const int x = low[0] / SC_BRICK + n % BRICKS, y = low[1] / SC_BRICK + n / BRICKS % BRICKS,
              z = low[2] / SC_BRICK + n / (BRICKS * BRICKS);

    if (x >= w->p->bricks[0] || y >= w->p->bricks[1] || z >= w->p->bricks[2])
        return SIZE_MAX;
    return sc_brick_index(w->p->bricks, x, y, z);
}

/* @return the value of a record of the outer field. */
static inline int outer_value(float field)
{
    const float steps = field * SC_BORDER_STEPS;
    const int value = (int)(steps < 0 ? steps - 0.5f : steps + 0.5f);

    return value > SC_VALUE_MAX    ? SC_VALUE_MAX
           : value < -SC_VALUE_MAX ? -SC_VALUE_MAX
           : value                 ? value
                                   : 1;
}

/* @return whether outer_value is positive. */
static inline bool is_tissue(float field)
{
    return field * SC_BORDER_STEPS - 0.5f > -1;
}

/* @return the value of a record of the inner field. @param values of largest_tissue. */
static inline uint8_t inner_value(const float values[2])
{
    const int value = outer_value(0.5f * (values[0] - values[1]));

    return (uint8_t)(value < 1 ? 1 : value);
}

/* @return the place of vertex @p at of a group in the field that find_brick reads. */
static inline int sided(const int at[3])
{
    return ((at[2] + BEFORE) * SIDED + at[1] + BEFORE) * SIDED + at[0] + BEFORE;
}

/* Find sides and codes of one brick of a group. @param field [SIDED] along each axis, of the outer
 * field from BEFORE voxels before the group on; NULL: sides are those of the labels. */
static void find_brick(const writer *w, const group_ids *ids, const int low[3], int n,
                       const float *field, uint64_t any, uint64_t several)
{
    const size_t brick = brick_of_group(w, low, n);
    const int corner[3] = {n % BRICKS * SC_BRICK, n / BRICKS % BRICKS * SC_BRICK,
                           n / (BRICKS * BRICKS) * SC_BRICK};
    uint8_t *codes;
    uint8_t *inner;
    sc_brick_sides sides = {0, 0};

    if (brick == SIZE_MAX || !w->number[brick])
        return;
    codes = w->codes[w->number[brick] - 1];
    inner = w->inner[w->number[brick] - 1];
    for (int row = 0; row < SC_BRICK_LAYER; row++) {
        const int at[3] = {corner[0], corner[1] + row % SC_BRICK, corner[2] + row / SC_BRICK};
        const uint16_t *own = ids->at[at[2] + 1][at[1] + 1] + at[0] + 1;

        for (int x = 0; x < SC_BRICK; x++)
            sides.tissue |= (uint64_t)(field ? is_tissue(field[sided(at) + x]) : own[x] != 0)
                            << (row * SC_BRICK + x);
    }
    memset(codes, SC_TISSUE_OWN, SC_BRICK_VERTICES);
    for (uint64_t left = any; left; left &= left - 1) {
        const int bit = __builtin_ctzll(left);
        const int at[3] = {corner[0] + sc_bit_x(bit), corner[1] + sc_bit_y(bit),
                           corner[2] + sc_bit_z(bit)};
        const int voxel[3] = {low[0] + at[0] - 1, low[1] + at[1] - 1, low[2] + at[2] - 1};
        float values[2];

        if (several >> bit & 1) {
            codes[bit] = (uint8_t)largest_tissue(w->b, ids, at, voxel, values);
            inner[bit] = inner_value(values);
        } else if (!ids->at[at[2] + 1][at[1] + 1][at[0] + 1]) {
            for (int k = 1; codes[bit] == SC_TISSUE_OWN; k++)
                codes[bit] = id_around(ids, at[0], at[1], at[2], nearest_first[k])
                                 ? nearest_first[k]
                                 : SC_TISSUE_OWN;
        }
        sides.moved |= (uint64_t)(codes[bit] != SC_TISSUE_OWN) << bit;
    }
    w->sides[w->number[brick] - 1] = sides;
}

/* Find sides and codes of groups [begin, end); an sc_range_fn on a writer. */
SC_WIDE_VECTORS static void find_groups(void *user, size_t begin, size_t end, int thread)
{
    const writer *w = user;
    const uint64_t *masks[2] = {w->wanted, w->wanted};

    (void)thread;
    for (size_t group = begin; group < end; group++) {
        uint64_t any[GROUP_BRICKS], several[GROUP_BRICKS];
        float field[SIDED * SIDED * SIDED];
        group_ids ids;
        int low[3], voxel[3], before[3];
        bool is;

        if (!begin_group(w, masks, group, low))
            continue;
        for (int i = 0; i < 3; i++) {
            voxel[i] = low[i] - 1;
            before[i] = voxel[i] - BEFORE;
        }
        read_ids(w->p->volume, voxel, &ids);
        find_tissues(&ids, any, several);
        is = read_field(w->b, 0, before, SIDED, field);
        for (int n = 0; n < GROUP_BRICKS; n++)
            find_brick(w, &ids, low, n, is ? field : NULL, any[n], several[n]);
    }
}

/* A field around a group, and the same blurred, for gradients. */
typedef struct group_field {
    float at[WIDE * WIDE * WIDE], once[(WIDE - 2) * (WIDE - 2) * (WIDE - 2)],
        flat[FLAT * FLAT * FLAT];
    sc_wide_slope wide[QUARTERS * QUARTERS * QUARTERS];
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
 * whose lowest voxel is @p voxel; beyond the volume those of the nearest ones. */
static void read_wide_slopes(const sc_borders *b, uint32_t label, const int voxel[3],
                             sc_wide_slope *out)
{
    const quarter_place first = place_of(b, voxel);

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
        if (tile >= SC_BESIDE(0))
            continue;
        out[n] = b->wide[tile & ~SC_MIRRORED]
                        [(at[2] * SC_CUBE_QUARTERS + at[1]) * SC_CUBE_QUARTERS + at[0]];
        for (int i = 0; i < 3 && tile & SC_MIRRORED; i++)
            out[n].slope[i] = -out[n].slope[i];
    }
}

/* Read the field of @p label around a group. @return false if its border is out of reach. */
static bool read_group(const writer *w, uint32_t label, const int low[3], group_field *out)
{
    const int voxel[3] = {low[0] - 1 - HALO, low[1] - 1 - HALO, low[2] - 1 - HALO};

    if (!read_field(w->b, label, voxel, WIDE, out->at))
        return false;
    sc_binomial(out->at, WIDE, out->once);
    sc_binomial(out->once, WIDE - 2, out->flat);
    read_wide_slopes(w->b, label, (const int[3]){low[0] - 1, low[1] - 1, low[2] - 1}, out->wide);
    return true;
}

/* Blend the gradient at a vertex of a group with that of the filtered field, in the share in which
 * that is the one for normals. @param low, voxel the lowest voxel of the group, and that of the
 * vertex. */
static inline void blend_wide(const writer *w, const group_field *f, const int low[3],
                              const int voxel[3], float slope[3])
{
    const quarter_place first = place_of(w->b, low), place = place_of(w->b, voxel);
    sc_wide_slope wide = {.share = 0};

    for (int n = 0; n < 8; n++) {
        const int corner[3] = {n & 1, n >> 1 & 1, n >> 2};
        float weight = 1;
        int at = 0;

        for (int i = 2; i >= 0; i--) {
            at = at * QUARTERS + place.low[i] - first.low[i] + corner[i];
            weight *= corner[i] ? place.share[i] : 1 - place.share[i];
        }
        for (int i = 0; i < 3; i++)
            wide.slope[i] += weight * f->wide[at].slope[i];
        wide.share += weight * f->wide[at].share;
    }
    for (int i = 0; i < 3; i++)
        slope[i] += wide.share * (wide.slope[i] - slope[i]);
}

/* @return a record of the field at vertex @p at of a group whose lowest vertex is @p low.
 * @param value of the record. */
static uint32_t pack(const writer *w, const group_field *f, const int low[3], const int at[3],
                     int code, int value)
{
    const float *flat = f->flat + ((at[2] + 1) * FLAT + at[1] + 1) * FLAT + at[0] + 1;
    const int lowest[3] = {low[0] - 1, low[1] - 1, low[2] - 1};
    const int voxel[3] = {lowest[0] + at[0], lowest[1] + at[1], lowest[2] + at[2]};
    float slope[3] = {0.5f * (flat[1] - flat[-1]), 0.5f * (flat[FLAT] - flat[-FLAT]),
                      0.5f * (flat[FLAT * FLAT] - flat[-FLAT * FLAT])};
    sc_vec3 outward = {0, 0, 0};

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
static void write_outer(const writer *w, const int low[3], group_field *f)
{
    if (!read_group(w, 0, low, f))
        return;
    for (int n = 0; n < GROUP_BRICKS; n++) {
        const size_t brick = brick_of_group(w, low, n);
        uint32_t *record;

        if (brick == SIZE_MAX || !w->p->outer.masks[brick])
            continue;
        record = (uint32_t *)(uintptr_t)w->p->outer.records + w->p->outer.start[brick];
        for (uint64_t left = w->p->outer.masks[brick]; left; left &= left - 1) {
            const int bit = __builtin_ctzll(left);
            const int at[3] = {n % BRICKS * SC_BRICK + sc_bit_x(bit),
                               n / BRICKS % BRICKS * SC_BRICK + sc_bit_y(bit),
                               n / (BRICKS * BRICKS) * SC_BRICK + sc_bit_z(bit)};
            const float value = f->at[((at[2] + HALO) * WIDE + at[1] + HALO) * WIDE + at[0] + HALO];

            *record++ =
                pack(w, f, low, at, w->codes[w->number[brick] - 1][bit], outer_value(value));
        }
    }
}

/* Write the records of the inner field, of vertices with the tissue @p label, of a group. */
static void write_inner(const writer *w, uint32_t label, const int low[3], const group_ids *ids,
                        group_field *f)
{
    const bool is = read_group(w, label, low, f);

    if (!is) {
        memset(f->flat, 0, sizeof f->flat);
        memset(f->wide, 0, sizeof f->wide);
    }
    for (int n = 0; n < GROUP_BRICKS; n++) {
        const size_t brick = brick_of_group(w, low, n);
        uint32_t *record;

        if (brick == SIZE_MAX || !w->p->inner.masks[brick])
            continue;
        record = (uint32_t *)(uintptr_t)w->p->inner.records + w->p->inner.start[brick];
        for (uint64_t left = w->p->inner.masks[brick]; left; left &= left - 1, record++) {
            const int bit = __builtin_ctzll(left);
            const int at[3] = {n % BRICKS * SC_BRICK + sc_bit_x(bit),
                               n / BRICKS % BRICKS * SC_BRICK + sc_bit_y(bit),
                               n / (BRICKS * BRICKS) * SC_BRICK + sc_bit_z(bit)};
            const int voxel[3] = {low[0] + at[0] - 1, low[1] + at[1] - 1, low[2] + at[2] - 1};
            const int code = w->codes[w->number[brick] - 1][bit];
            int value = w->inner[w->number[brick] - 1][bit];
            float values[2];

            if (id_around(ids, at[0], at[1], at[2], code) != label)
                continue;
            if (!value) {
                (void)largest_tissue(w->b, ids, at, voxel, values);
                value = inner_value(values);
            }
            *record = pack(w, f, low, at, code, value);
        }
    }
}

/* Write records without a vote for the vertices of a group: those keep them that have no tissue. */
static void clear_inner(const writer *w, const int low[3])
{
    const uint32_t none = sc_record_pack(1, (sc_vec3){0, 0, 0}, 0) | (uint32_t)SC_TISSUE_OWN
                                                                         << SC_RECORD_TISSUE_SHIFT;

    for (int n = 0; n < GROUP_BRICKS; n++) {
        const size_t brick = brick_of_group(w, low, n);
        uint32_t *record;

        if (brick == SIZE_MAX)
            continue;
        record = (uint32_t *)(uintptr_t)w->p->inner.records + w->p->inner.start[brick];
        for (unsigned i = 0; i < sc_count_bits(w->p->inner.masks[brick]); i++)
            record[i] = none;
    }
}

/* @return the least label around a group that is larger than @p last; UINT16_MAX if there is none.
 */
static uint16_t next_label(const group_ids *ids, uint16_t last)
{
    uint16_t next = UINT16_MAX;

    for (int k = 0; k < IDS * IDS; k++) {
        for (int x = 0; x < IDS; x++) {
            const uint16_t id = ids->at[k / IDS][k % IDS][x];

            next = id > last && id < next ? id : next;
        }
    }
    return next;
}

/* Write the records of groups [begin, end); an sc_range_fn on a writer. */
SC_WIDE_VECTORS static void write_groups(void *user, size_t begin, size_t end, int thread)
{
    const writer *w = user;
    const uint64_t *masks[2] = {w->p->outer.masks, w->p->inner.masks};
    const uint64_t *inner[2] = {w->p->inner.masks, w->p->inner.masks};
    group_field f;

    (void)thread;
    for (size_t group = begin; group < end; group++) {
        group_ids ids;
        int low[3], voxel[3];

        if (!begin_group(w, masks, group, low))
            continue;
        for (int i = 0; i < 3; i++)
            voxel[i] = low[i] - 1;
        write_outer(w, low, &f);
        if (!begin_group(w, inner, group, low))
            continue;
        clear_inner(w, low);
        read_ids(w->p->volume, voxel, &ids);
        for (uint16_t id = next_label(&ids, 0); id != UINT16_MAX; id = next_label(&ids, id))
            write_inner(w, id, low, &ids, &f);
    }
}

/* Find the bricks that hold or touch a vertex near a border, of the rows [begin, end) of bricks; an
 * sc_range_fn on a writer. */
static void want_bricks(void *user, size_t begin, size_t end, int thread)
{
    const writer *w = user;
    const int *bricks = w->p->bricks;

    (void)thread;
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

/* Make the records of a preparation from its fields. */
static sc_status write_records(const sc_ctx *ctx, sc_preparation *p, const sc_borders *b)
{
    writer w = {.b = b, .p = p};
    void *wanted = NULL, *sides = NULL, *codes = NULL, *inner = NULL;
    uint32_t *number = NULL;
    uint64_t count;
    sc_fields fields;
    sc_status status;

    (void)sc_affine_invert(&p->volume->to_ras_mm, &w.to_voxel); /* geometry has been checked */
    for (int i = 0; i < 3; i++)
        w.groups[i] = (p->bricks[i] + BRICKS - 1) / BRICKS;
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
    sc_team_stage_for(ctx, SC_WORTH_SIDES, p->team, sc_brick_count(w.groups), 4, find_groups, &w);
    fields = (sc_fields){
        .number = number, .sides = w.sides, .codes = (const uint8_t(*)[SC_BRICK_VERTICES])codes};
    SC_TRY(sc_mark_borders(ctx, p, &fields));
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

/* Free the arrays of the fields. */
static void clear_borders(sc_borders *b)
{
    void *const arrays[] = {b->around,    b->start,   b->labels, b->cube_of, b->beside, b->squares,
                            b->data,      b->value,   b->box,    b->dead,    b->still,  b->coarse,
                            b->strengths, b->missing, b->area,   b->fine,    b->wide};

    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        sc_team_free(b->p->team, arrays[i]);
}

/* Free an array that no later stage reads. */
static void drop(void **array, const sc_preparation *p)
{
    sc_team_free(p->team, *array);
    *array = NULL;
}

sc_status sc_smooth_borders(const sc_ctx *ctx, sc_preparation *p)
{
    sc_borders b = {.p = p};
    sc_status status;

    SC_TRY(sc_find_tiles(ctx, &b));
    SC_TRY(sc_measure_distances(ctx, &b));
    SC_TRY(sc_smooth_cells(ctx, &b));
    SC_TRY(sc_keep_volume_of_cells(ctx, &b));
    SC_TRY(sc_smooth_quarters(ctx, &b));
    SC_TRY(sc_weigh_cells(ctx, &b));
    drop((void **)&b.data, p);
    drop((void **)&b.box, p);
    SC_TRY(sc_smooth_voxels(ctx, &b));
    drop((void **)&b.value, p);
    sc_keep_volume_of_voxels(ctx, &b);
    sc_keep_links(ctx, &b);
    drop((void **)&b.squares, p);
    SC_TRY(write_records(ctx, p, &b));
out:
    clear_borders(&b);
    return status;
}
