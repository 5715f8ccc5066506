/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to prepare: the fields from which borders are drawn, while they are being computed.
 *
 * Of all surfaces that could have been drawn as the voxels of a volume, the smoothest that has
 * their volume is looked for. There is a field for background against all tissue (label 0,
 * positive on the side of tissue), and one for each tissue against the other tissues, in which
 * the background has no say (positive in the tissue). All lengths are counted in voxels: a field
 * is about the distance to the border, with 1 for the length of a voxel along the normal.
 *
 * Fields are kept in tiles, one for each pair of a field and a block of SC_CUBE voxels along each
 * axis in whose reach a border of the field lies. What holds beyond is a constant: sc_far_kind.
 * A tile has cells of two voxels along each axis, and quarters of four. Every number in a tile is a
 * function of the labels within a bounded distance and of nothing else, whatever the order in which
 * tiles are done. */
#ifndef SC_PREPARE_BORDER_H
#define SC_PREPARE_BORDER_H

#include "internal.h"

#define SC_ALWAYS_INLINE static inline __attribute__((always_inline))
/* A function that is compiled twice: for any processor, and for those with wider vectors, which
 * take it when the program starts. Both give the same bits. Sanitizers run before that could be
 * chosen. */
#if defined __x86_64__ && defined __ELF__ && defined __GNUC__ && !defined __clang__ &&             \
    !defined __AVX2__ && !defined __SANITIZE_ADDRESS__ && !defined __SANITIZE_THREAD__
#define SC_WIDE_VECTORS __attribute__((target_clones("avx2", "default")))
#else
#define SC_WIDE_VECTORS
#endif

_Static_assert(SC_LABELS_MAX <= 0xfffe, "SC_TWO_TISSUES and SC_NO_LABEL are no ids");
enum {
    SC_CUBE = 16,         /* voxels along an edge of a block */
    SC_CUBE_CELLS = 8,    /* cells along it */
    SC_CUBE_QUARTERS = 4, /* quarters */
    SC_TILE_VOXELS = SC_CUBE * SC_CUBE * SC_CUBE,
    SC_TILE_CELLS = SC_CUBE_CELLS * SC_CUBE_CELLS * SC_CUBE_CELLS,
    SC_TILE_QUARTERS = SC_CUBE_QUARTERS * SC_CUBE_QUARTERS * SC_CUBE_QUARTERS,
    SC_REACH = 5, /* distances count up to so many voxels */
    SC_REACH_SQUARED = SC_REACH * SC_REACH,
    SC_NO_LABEL = 0xffff,    /* of voxels beyond the volume */
    SC_TWO_TISSUES = 0xfffe, /* of sc_cube.tissue */
    SC_MANY_TISSUES = 0xffff
};
/* The value of a field where its border is out of reach. */
#define SC_FAR (SC_REACH - 0.5f)

/* What is known of the voxels within SC_REACH of a block. */
typedef struct sc_cube {
    uint16_t tissue; /* the only tissue; 0 for none, SC_TWO_TISSUES or SC_MANY_TISSUES */
    uint16_t second; /* of two tissues the one with the larger label; of many SC_NO_LABEL where
                        there are too many for fields */
} sc_cube;

/* The labels of a cube of SC_SUB voxels along each axis. */
enum { SC_SUB = SC_REACH - 1, SC_SUB_LABELS = 3 };
typedef struct sc_sub_labels {
    uint16_t count; /* SC_SUB_LABELS + 1: there are more than fit */
    uint16_t ids[SC_SUB_LABELS];
} sc_sub_labels;

/* The gradient of the filtered field of a quarter (border_quarters.c), in voxels. */
typedef struct sc_wide_slope {
    float slope[3];
    float share; /* in which it is the one for normals, 0 to 1 */
} sc_wide_slope;

/* What lies beside a tile instead of another one, in sc_tiles.beside. */
enum {
    SC_BESIDE_CONSTANTS = 4, /* so many of the largest numbers */
    SC_BESIDE_FREE = 0,      /* counted from there: a field that is 0, */
    SC_BESIDE_HIGH = 1,      /* SC_FAR, */
    SC_BESIDE_LOW = 2,       /* -SC_FAR, */
    SC_BESIDE_VOLUME = 3     /* or nothing, beyond the volume */
};
/* Of a tile in sc_tiles.beside: it is that of the opposite field. In a block with two tissues
 * only the field of the one with the smaller label has a tile: that of the other is the same,
 * negated, to the last bit. */
#define SC_MIRRORED 0x80000000u
#define SC_BESIDE(what) (UINT32_MAX - SC_BESIDE_CONSTANTS + 1 + (uint32_t)(what))

/* Cubes of SC_SUB voxels. */
typedef struct sc_sub_cubes {
    int size[3];           /* how many along x, y, z */
    sc_sub_labels *lists;  /* [size z][y][x] */
    uint16_t (*blocks)[2]; /* [size z][y][x]: tissues that fill 3 x 3 x 3 voxels around a voxel
                              of the cube; 0: none; SC_NO_LABEL: there are more than two */
} sc_sub_cubes;

/* Which tiles there are. */
typedef struct sc_tiles {
    size_t count;
    uint16_t *labels;       /* [count]: whose field it is; rising within a block */
    uint32_t *cube_of;      /* [count] */
    uint32_t (*beside)[27]; /* tiles of the same field around a tile, itself in the middle, in the
                               order of x, y, z; or SC_BESIDE */
} sc_tiles;

/* What is known of the quarters of tiles. */
typedef struct sc_quarters {
    float (*missing)[SC_TILE_QUARTERS]; /* volume that is missing of a quarter, */
    float (*area)[SC_TILE_QUARTERS]; /* and the area over which that is to be spread, in voxels */
    sc_wide_slope (*wide)[SC_TILE_QUARTERS]; /* gradients of the filtered field */
} sc_quarters;

/* The tiles of a volume and their arrays, of the team, all by number of the tile. */
typedef struct sc_borders {
    sc_preparation *p; /* borrowed */
    int cubes[3];
    int phase[3]; /* voxels of the first cube along each axis that lie before the volume: cubes
                     lie at fixed places of the patient */
    size_t cube_count;
    sc_cube *around; /* [cube_count] */
    sc_sub_cubes subs;
    uint32_t *start; /* [cube_count + 1]: number of the block's first tile */
    sc_tiles tiles;
    int8_t (*squares)[SC_TILE_VOXELS]; /* squared distance to the other side, with the sign of the
                                          field; 0 where the field is free */
    int16_t (*fine)[SC_TILE_VOXELS];   /* the field at voxels, in units of 1 / SC_FINE_STEPS; before
                                          there is any, the memory of data, box and spare */
    float (*data)[SC_TILE_CELLS];      /* the distance to the border */
    float (*box)[SC_TILE_CELLS];       /* how far the field may be from the data */
    float (*spare[2])[SC_TILE_CELLS];  /* of no use but to the stage that writes it */
    float (*value)[SC_TILE_CELLS];     /* the field at cells */
    uint8_t *still;                    /* 1 if no cell of the tile moves */
    float strength;                    /* of the smoothing of all tissues, */
    float (*strengths)[SC_TILE_CELLS]; /* or at each cell; NULL if all are the same */
    float (*coarse)[SC_TILE_CELLS];    /* share, 0 to 1, in which cells alone make the field */
    sc_quarters quarters;
} sc_borders;
#define SC_FINE_STEPS 1024.0f

/* @return the constant, of SC_BESIDE_*, that the field of @p label is in a block without a tile of
 * it. */
static inline int sc_far_kind(const sc_borders *b, size_t block, uint32_t label)
{
    const uint32_t tissue = b->around[block].tissue;

    if (!label)
        return tissue ? SC_BESIDE_HIGH : SC_BESIDE_LOW;
    if (tissue == SC_MANY_TISSUES && b->around[block].second == SC_NO_LABEL)
        return SC_BESIDE_FREE;
    return tissue == label ? SC_BESIDE_HIGH : tissue ? SC_BESIDE_LOW : SC_BESIDE_FREE;
}

/* @return what sc_tiles.beside says of the field of @p label in a block: the number of its tile,
 * that of the opposite field with SC_MIRRORED, or a constant. */
static inline uint32_t sc_tile_of(const sc_borders *b, size_t block, uint32_t label)
{
    for (uint32_t tile = b->start[block]; tile < b->start[block + 1]; tile++) {
        if (b->tiles.labels[tile] == label)
            return tile;
    }
    if (label && b->around[block].tissue == SC_TWO_TISSUES && b->around[block].second == label)
        return (b->start[block + 1] - 1) | SC_MIRRORED;
    return SC_BESIDE(sc_far_kind(b, block, label));
}

/* Write the lowest voxel of a block to @p low. */
static inline void sc_cube_low(const sc_borders *b, size_t block, int low[3])
{
    sc_brick_at(b->cubes, block, low);
    for (int i = 0; i < 3; i++)
        low[i] = low[i] * SC_CUBE - b->phase[i];
}

/* What numbers are multiplied by that are read from a tile: floats, and by 0 or -1 for 1 or -1,
 * whole numbers. */
#define SC_TIMES(value, by) ((value) * (by))
#define SC_SIGNED(value, by) (((value) ^ (by)) - (by))

/* Define a function that reads the numbers of a tile with @p each elements along each axis, a power
 * of two, and @p halo more on every side, 8 at most, to @p out, [each + 2 halo] along each axis. @p
 * array is by number of the tile, and has room for one tile more, as reads go beyond the last one.
 * @p constants [SC_BESIDE_CONSTANTS] stand for tiles that do not exist. Numbers are converted to
 * @p wide first, for which processors have an instruction. @p plain and @p mirror are the factors
 * that
 * @p times gets for numbers of the field and of the opposite one. */
/* NOLINTBEGIN(bugprone-macro-parentheses): arguments are types and names */
#define SC_DEFINE_READ_TILE(name, type, each, wide, result, times, plain, mirror)                  \
    typedef type name##_from __attribute__((vector_size(4 * sizeof(type))));                       \
    typedef wide name##_wide __attribute__((vector_size(4 * sizeof(wide))));                       \
    typedef result name##_to __attribute__((vector_size(4 * sizeof(result))));                     \
                                                                                                   \
    SC_ALWAYS_INLINE void name##_part(const type *from, result by, int count, result *out)         \
    {                                                                                              \
        for (int x = 0; x < count; x += 4) {                                                       \
            name##_from four;                                                                      \
            name##_to product;                                                                     \
                                                                                                   \
            memcpy(&four, from + x, sizeof four);                                                  \
            product = times(                                                                       \
                __builtin_convertvector(__builtin_convertvector(four, name##_wide), name##_to),    \
                by);                                                                               \
            memcpy(out + x, &product, (count - x < 4 ? count - x : 4) * sizeof *out);              \
        }                                                                                          \
    }                                                                                              \
                                                                                                   \
    typedef type name##_row_from __attribute__((vector_size((each) * sizeof(type))));              \
    typedef wide name##_row_wide __attribute__((vector_size((each) * sizeof(wide))));              \
    typedef result name##_row_to __attribute__((vector_size((each) * sizeof(result))));            \
                                                                                                   \
    SC_ALWAYS_INLINE void name##_row(const type *from, result by, result *out)                     \
    {                                                                                              \
        name##_row_from row;                                                                       \
        name##_row_to product;                                                                     \
                                                                                                   \
        memcpy(&row, from, sizeof row);                                                            \
        product = times(                                                                           \
            __builtin_convertvector(__builtin_convertvector(row, name##_row_wide), name##_row_to), \
            by);                                                                                   \
        memcpy(out, &product, sizeof product);                                                     \
    }                                                                                              \
                                                                                                   \
    SC_ALWAYS_INLINE void name(const sc_borders *b, const type *array, size_t tile, int halo,      \
                               const type constants[SC_BESIDE_CONSTANTS], result *out)             \
    {                                                                                              \
        const int edge = (each) + 2 * halo;                                                        \
        const result factors[2] = {(plain), (mirror)};                                             \
        const int ends[4] = {-halo, 0, (each), (each) + halo};                                     \
        type rows[SC_BESIDE_CONSTANTS][(each) + 8];                                                \
        const type *from[27];                                                                      \
        result by[27];                                                                             \
        int step[27];                                                                              \
                                                                                                   \
        for (int i = 0; i < SC_BESIDE_CONSTANTS * ((each) + 8); i++)                               \
            rows[i / ((each) + 8)][i % ((each) + 8)] = constants[i / ((each) + 8)];                \
        for (int n = 0; n < 27; n++) {                                                             \
            const uint32_t other = b->tiles.beside[tile][n];                                       \
            const bool constant = other >= SC_BESIDE(0);                                           \
                                                                                                   \
            from[n] = constant                                                                     \
                          ? rows[other - SC_BESIDE(0)]                                             \
                          : array + (size_t)(other & ~SC_MIRRORED) * (each) * (each) * (each);     \
            by[n] = factors[!constant && other & SC_MIRRORED];                                     \
            step[n] = constant ? 0 : (each);                                                       \
        }                                                                                          \
        for (int k = 0; k < 9; k++) {                                                              \
            const type *const *three = from + 3 * k;                                               \
            const int *steps = step + 3 * k;                                                       \
            const result *factor = by + 3 * k;                                                     \
                                                                                                   \
            for (int z = ends[k / 3]; z < ends[k / 3 + 1]; z++) {                                  \
                for (int y = ends[k % 3]; y < ends[k % 3 + 1]; y++) {                              \
                    const int row = (z & ((each)-1)) * (each) + (y & ((each)-1));                  \
                    result *to = out + ((z + halo) * edge + y + halo) * edge;                      \
                                                                                                   \
                    name##_part(three[0] + row * steps[0] + (each)-halo, factor[0], halo, to);     \
                    name##_row(three[1] + row * steps[1], factor[1], to + halo);                   \
                    name##_part(three[2] + row * steps[2], factor[2], halo, to + halo + (each));   \
                }                                                                                  \
            }                                                                                      \
        }                                                                                          \
    }
/* NOLINTEND(bugprone-macro-parentheses) */
SC_DEFINE_READ_TILE(sc_read_tile_cells, float, SC_CUBE_CELLS, float, float, SC_TIMES, 1, -1)
SC_DEFINE_READ_TILE(sc_read_tile_shares, float, SC_CUBE_CELLS, float, float, SC_TIMES, 1, 1)
SC_DEFINE_READ_TILE(sc_read_tile_volumes, float, SC_CUBE_QUARTERS, float, float, SC_TIMES, 1, -1)
SC_DEFINE_READ_TILE(sc_read_tile_areas, float, SC_CUBE_QUARTERS, float, float, SC_TIMES, 1, 1)
SC_DEFINE_READ_TILE(sc_read_tile_fine, int16_t, SC_CUBE, int32_t, float, SC_TIMES,
                    1 / SC_FINE_STEPS, -1 / SC_FINE_STEPS)
SC_DEFINE_READ_TILE(sc_read_tile_squares, int8_t, SC_CUBE, int8_t, int8_t, SC_SIGNED, 0, -1)

/* Let the numbers of a region go on linearly beyond [begin, end) along an axis. */
void sc_extrapolate_along(float *region, int edge, int axis, int begin, int end);
/* Where the region around a tile reaches beyond the volume, let its numbers go on linearly.
 * @param each elements along an edge of a block. */
void sc_extrapolate(const sc_borders *b, size_t tile, int each, int halo, float *region);

/* Read the field at cells around a tile. @param array of cells. */
SC_ALWAYS_INLINE void sc_read_cells(const sc_borders *b, const float (*array)[SC_TILE_CELLS],
                                    size_t tile, int halo, float *out)
{
    static const float constants[SC_BESIDE_CONSTANTS] = {0, SC_FAR, -SC_FAR, 0};

    sc_read_tile_cells(b, array[0], tile, halo, constants, out);
    sc_extrapolate(b, tile, SC_CUBE_CELLS, halo, out);
}

/* @return @p value, or the end of [low, high] beyond which it lies. */
static inline float sc_clip(float value, float low, float high)
{
    const float above = value < low ? low : value;

    return above > high ? high : above;
}

/* @return a number of the array fine, to the nearest step. */
static inline int16_t sc_to_fine(float value)
{
    const float steps = value * SC_FINE_STEPS;

    return (int16_t)(steps + copysignf(0.5f, steps));
}

/* The inverse of sc_to_fine. */
static inline float sc_of_fine(int16_t fine)
{
    return (float)fine * (1 / SC_FINE_STEPS);
}

/* Read the field at voxels around a tile. */
SC_ALWAYS_INLINE void sc_read_voxels(const sc_borders *b, size_t tile, int halo, float *out)
{
    static const int16_t constants[SC_BESIDE_CONSTANTS] = {0, (int16_t)(SC_FAR * SC_FINE_STEPS),
                                                           -(int16_t)(SC_FAR * SC_FINE_STEPS), 0};

    sc_read_tile_fine(b, b->fine[0], tile, halo, constants, out);
    sc_extrapolate(b, tile, SC_CUBE, halo, out);
}

/* @return the strength of the smoothing at a cell of a tile: 1 for a drawn step of two voxels. */
static inline float sc_strength_at(const sc_borders *b, size_t tile, int cell)
{
    return b->strengths ? b->strengths[tile][cell] : b->strength;
}

/* @return the share, 0 to 1, of the box of voxels that a strength leaves. */
static inline float sc_voxel_share(float strength)
{
    return strength < 0.5f ? 2 * strength : 1;
}

/* @return the share, 0 to 1, in which cells may make the field at a strength. */
static inline float sc_cell_share(float strength)
{
    const float share = 2 * strength - 1;

    return share < 0 ? 0 : share > 1 ? 1 : share;
}

/* Write the distances of a row of voxels to the border of a field, by their numbers in
 * sc_borders.squares. @param count a multiple of eight. */
SC_ALWAYS_INLINE void sc_distances_of(const int8_t *squares, int count, float *out)
{
    typedef int8_t bytes __attribute__((vector_size(8)));
    typedef float floats __attribute__((vector_size(8 * sizeof(float))));

    for (int x = 0; x < count; x += 8) {
        bytes eight;
        floats wide;

        memcpy(&eight, squares + x, sizeof eight);
        wide = __builtin_convertvector(eight, floats);
        memcpy(out + x, &wide, sizeof wide);
    }
    for (int x = 0; x < count; x++) /* no branch: it is vectorized */
        out[x] = copysignf(1, out[x]) * (sqrtf(fabsf(out[x])) - 0.5f);
}

/* Do cells alone make the field of all of a tile? */
static inline bool sc_is_coarse(const sc_borders *b, size_t tile)
{
    int32_t fine = 0;

    for (int i = 0; i < SC_TILE_CELLS; i++)
        fine |= b->coarse[tile][i] < 1;
    return !fine;
}

/* Half the box of a field, where cells and where voxels make it, in voxels, at strength 1. The
 * latter leaves voxels a little on their side. */
#define SC_CELL_BOX 1.0f
#define SC_VOXEL_BOX 0.45f
/* Fields are smoothed within so many voxels of the border; */
#define SC_BAND 4.0f
/* Where the field is free, as wide as its whole numbers allow (sc_to_fine: 32 voxels, from SC_FAR
 * on); and where it does not move, since its border is out of reach. */
#define SC_BOX_FREE 27.0f
#define SC_BOX_FROZEN 0.0f

/* Write sums of three neighbours along x, the middle one times @p middle and the others times @p
 * beside, to @p out. @param rows [less][edge]; @p out [less][less], two less. Rows follow each
 * other, so that all sums are found side by side; those across two rows are of no use. */
SC_ALWAYS_INLINE void sc_sum_rows(const float *rows, int edge, float beside, float middle,
                                  float *out)
{
    const int less = edge - 2;
    float sums[24 * 24];

    for (int i = 0; i < less * edge - 2; i++)
        sums[i] = beside * (rows[i] + rows[i + 2]) + middle * rows[i + 1];
    for (int y = 0; y < less; y++) { /* in parts, as long ones are copied a word at a time */
        for (int x = 0; x < less; x += 4)
            memcpy(out + y * less + (x > less - 4 ? less - 4 : x),
                   sums + y * edge + (x > less - 4 ? less - 4 : x), 4 * sizeof *out);
    }
}

/* Filter a region of @p edge elements along each axis by the binomial 1-2-1, to @p out, with two
 * elements less along each axis; it may be @p in. Loops have constant lengths once it is inlined.
 */
SC_ALWAYS_INLINE void sc_binomial(const float *in, int edge, float *out)
{
    enum { MOST = 24 };
    const int layer = edge * edge, less = edge - 2;
    float plane[MOST * MOST], rows[MOST * MOST];

    for (int z = 0; z < less; z++) {
        const float *low = in + (size_t)(z * layer), *middle = low + layer, *high = middle + layer;

        for (int i = 0; i < layer; i++)
            plane[i] = 0.25f * (low[i] + high[i]) + 0.5f * middle[i];
        for (int i = 0; i < less * edge; i++)
            rows[i] = 0.25f * (plane[i] + plane[i + 2 * edge]) + 0.5f * plane[i + edge];
        sc_sum_rows(rows, edge, 0.25f, 0.5f, out + (size_t)(z * less * less));
    }
}

/* Numbers of two vectors of four, by their places in both. Clang has no __builtin_shuffle, and GCC
 * before 12 nothing else. */
#if defined __clang__ || __GNUC__ >= 12
#define SC_SHUFFLE(a, c, ...) __builtin_shufflevector(a, c, __VA_ARGS__)
#else
typedef int32_t sc_four_places __attribute__((vector_size(4 * sizeof(int32_t))));
#define SC_SHUFFLE(a, c, ...) __builtin_shuffle(a, c, (sc_four_places){__VA_ARGS__})
#endif

/* Interpolate between five cells of a row: to eight voxels, or twice @p count if that is less. */
SC_ALWAYS_INLINE void sc_upsample_four(const float *row, int count, float *out)
{
    typedef float four __attribute__((vector_size(4 * sizeof(float))));
    four low, high, even, odd, pairs[2];

    memcpy(&low, row, sizeof low);
    memcpy(&high, row + 1, sizeof high);
    even = 0.75f * low + 0.25f * high;
    odd = 0.25f * low + 0.75f * high;
    pairs[0] = SC_SHUFFLE(even, odd, 0, 4, 1, 5);
    pairs[1] = SC_SHUFFLE(even, odd, 2, 6, 3, 7);
    memcpy(out, pairs, (size_t)(count < 4 ? 2 * count : 8) * sizeof *out);
}

/* Interpolate a region of @p edge cells to twice as many voxels, less two: number i of the result
 * lies between cells i / 2 and i / 2 + 1. */
SC_ALWAYS_INLINE void sc_upsample(const float *in, int edge, float *out)
{
    enum { MOST = 16 };
    const int twice = 2 * edge - 2, layer = edge * edge;
    float plane[MOST * MOST], rows[2][MOST * MOST + 4]; /* reads go beyond the last row */

    for (int z = 0; z < twice; z++) {
        const float share = z & 1 ? 0.75f : 0.25f; /* of the next cell */
        const float *low = in + (size_t)(z / 2 * layer), *high = low + layer;

        for (int i = 0; i < layer; i++)
            plane[i] = (1 - share) * low[i] + share * high[i];
        for (int i = 0; i < layer - edge; i++) {
            rows[0][i] = 0.75f * plane[i] + 0.25f * plane[i + edge];
            rows[1][i] = 0.25f * plane[i] + 0.75f * plane[i + edge];
        }
        for (int y = 0; y < twice; y++) {
            const float *row = rows[y & 1] + y / 2 * edge;
            float *to = out + (z * twice + y) * twice;

            for (int x = 0; x + 1 < edge; x += 4)
                sc_upsample_four(row + x, edge - 1 - x, to + 2 * x);
        }
    }
}

/* Undo along all axes what averaging to cells and interpolating between them take: by 1 - 1/8 of
 * the second difference. @param edge of @p in; of @p out two less. */
SC_ALWAYS_INLINE void sc_sharpen(const float *in, int edge, float *out)
{
    const int less = edge - 2, layer = edge * edge;
    float plane[16 * 16], rows[16 * 16];

    for (int z = 0; z < less; z++) {
        const float *low = in + z * layer, *middle = low + layer, *high = middle + layer;

        for (int i = 0; i < layer; i++)
            plane[i] = 1.25f * middle[i] - 0.125f * (low[i] + high[i]);
        for (int i = 0; i < less * edge; i++)
            rows[i] = 1.25f * plane[i + edge] - 0.125f * (plane[i] + plane[i + 2 * edge]);
        sc_sum_rows(rows, edge, -0.125f, 1.25f, out + (size_t)(z * less * less));
    }
}

/* Least area of the border in a quarter, in voxels, on which anything is spread. */
#define SC_LEAST_AREA 0.32f

/* Write how far the border is to be moved at the cells of a tile and one more on every side, by
 * what is missing around, b->missing and area. @param blurs passes of the binomial over quarters, 3
 * at most. */
SC_ALWAYS_INLINE void sc_find_moves(const sc_borders *b, size_t tile, int blurs, float *out)
{
    enum { MOST = 3 * SC_CUBE_QUARTERS, LEFT = SC_CUBE_QUARTERS + 2 };
    static const float none[SC_BESIDE_CONSTANTS] = {0, 0, 0, 0};
    float volume[MOST * MOST * MOST], area[MOST * MOST * MOST];

    sc_read_tile_volumes(b, b->quarters.missing[0], tile, blurs + 1, none, volume);
    sc_read_tile_areas(b, b->quarters.area[0], tile, blurs + 1, none, area);
    for (int i = 0; i < blurs; i++) {
        sc_binomial(volume, SC_CUBE_QUARTERS + 2 * (blurs + 1 - i), volume);
        sc_binomial(area, SC_CUBE_QUARTERS + 2 * (blurs + 1 - i), area);
    }
    for (int i = 0; i < LEFT * LEFT * LEFT; i++)
        volume[i] /= area[i] > SC_LEAST_AREA ? area[i] : SC_LEAST_AREA;
    sc_upsample(volume, LEFT, out);
}

/* How long the loops over tiles take that take long, as parts of SC_WORTH_FIELDS. */
enum {
    SC_WORTH_TILES = 1000,
    SC_WORTH_DISTANCES = 6000,
    SC_WORTH_WEIGHING = 3000,
    SC_WORTH_STEPS = 4800,
    SC_WORTH_VOLUME = 5600,
    SC_WORTH_REFINING = 5000,
    SC_WORTH_LINKS = 800,
    SC_WORTH_SIDES = 3800
};
_Static_assert(SC_WORTH_TILES + SC_WORTH_DISTANCES + SC_WORTH_WEIGHING + SC_WORTH_STEPS +
                       SC_WORTH_VOLUME + SC_WORTH_REFINING + SC_WORTH_LINKS + SC_WORTH_SIDES ==
                   SC_WORTH_FIELDS,
               "progress ends at 100 %");

/* Cells of a block and so many more on every side. */
enum {
    SC_SLENDER_HALO = 2,
    SC_SLENDER_EDGE = SC_CUBE_CELLS + 2 * SC_SLENDER_HALO,
    SC_SLENDER_CELLS = SC_SLENDER_EDGE * SC_SLENDER_EDGE * SC_SLENDER_EDGE
};
/* Find the tissues that fill three voxels along each axis anywhere: blocks. */
sc_status sc_find_blocks_of_three(const sc_ctx *ctx, sc_borders *b);
/* Write 1 to @p out for cells in or beside which there is slender tissue (border_slender.c), 0 for
 * others; all 0 around a block of voxels where only one tissue is. Needs lists and blocks. */
void sc_find_slender(const sc_borders *b, size_t block, uint8_t out[SC_SLENDER_CELLS]);

/* The stages, in their order; collective in the team. Return SC_ERR_MEMORY. */
sc_status sc_find_tiles(const sc_ctx *ctx, sc_borders *b);
sc_status sc_measure_distances(const sc_ctx *ctx, sc_borders *b);
/* Find what lies beside each tile: beside. */
sc_status sc_find_beside(const sc_ctx *ctx, sc_borders *b);
sc_status sc_smooth_cells(const sc_ctx *ctx, sc_borders *b);
sc_status sc_keep_volume_of_cells(const sc_ctx *ctx, sc_borders *b);
/* Find wide, too. Writes over missing and area. */
sc_status sc_smooth_quarters(const sc_ctx *ctx, sc_borders *b);
/* box is of no use afterwards. */
sc_status sc_weigh_cells(const sc_ctx *ctx, sc_borders *b);
/* Writes over data, box and spare. */
void sc_smooth_voxels(const sc_ctx *ctx, sc_borders *b);
/* Instead of the stages before, where nothing is smoothed: let data be the field of cells, which
 * decide nowhere. */
sc_status sc_take_data(const sc_ctx *ctx, sc_borders *b);
void sc_keep_volume_of_voxels(const sc_ctx *ctx, sc_borders *b);
/* Keep tissue one voxel thick together (border_links.c): fine. */
void sc_keep_links(const sc_ctx *ctx, sc_borders *b);
/* Make the records of a preparation from its fields. */
sc_status sc_write_records(const sc_ctx *ctx, sc_preparation *p, const sc_borders *b);

#endif
