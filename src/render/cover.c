/* SPDX-License-Identifier: BSD-3-Clause */
/* Which parts of a picture can show anything: all blocks of the volume that hold something visible
 * are projected onto a coarse map of the screen, with a margin. Pixels outside of it need no rays.
 */
#include "internal.h"

#include <string.h>

enum {
    BLOCK = 2,   /* bricks along each edge of a block that is not tight */
    LEVELS = 255 /* of distances that squares can have */
};

/* How much further than its block what is visible may reach, in voxels: with a tight one cells not
 * at all, but for the rounding of a ray, and the voxels of the voxel surface by half of their edge.
 */
#define CELL_MARGIN 0.25
#define VOXEL_MARGIN 0.75
#define WIDE_MARGIN 1.0
/* The same for the rounding of a projection, in pixels. */
#define TIGHT_MARGIN_PX 0.0625
#define WIDE_MARGIN_PX 1.0

/* What is visible in brick (x, y, z), as a mask; in the block whose lowest brick that is, unless
 * blocks are tight: then only whether it is 0 has a meaning. Bricks beyond the volume are passed
 * over. */
static uint64_t visible_in(const sc_renderer *r, int x, int y, int z)
{
    const int edge = r->bounds.has_tight_blocks ? 1 : BLOCK;
    const int nx = r->volume->bricks[0], ny = r->volume->bricks[1], nz = r->volume->bricks[2];
    const int row = sc_framed_row(r->volume->bricks), layer = sc_framed_layer(r->volume->bricks);
    uint64_t any = 0;

    for (int dz = 0; dz < edge && z + dz < nz; dz++) {
        for (int dy = 0; dy < edge && y + dy < ny; dy++) {
            for (int dx = 0; dx < edge && x + dx < nx; dx++)
                any |= r->derived.visible[sc_framed_index(row, layer, x + dx, y + dy, z + dz)];
        }
    }
    return any;
}

/* The block whose lowest brick is (x, y, z), and which is not tight. */
static sc_block wide_block(int x, int y, int z)
{
    const float half = BLOCK * 0.5f;

    return (sc_block){((float)x + half) * SC_BRICK - 1, /* vertex - 1 */
                      ((float)y + half) * SC_BRICK - 1,
                      ((float)z + half) * SC_BRICK - 1,
                      {BLOCK * SC_BRICK, BLOCK * SC_BRICK, BLOCK * SC_BRICK}};
}

/* First and last place of a brick along an axis with something visible. @param places of the brick
 * [SC_BRICK], as bits. */
static inline void find_ends(unsigned places, int ends[2])
{
    ends[0] = __builtin_ctz(places);
    ends[1] = 31 - __builtin_clz(places);
}

/* The box around what is visible in brick (x, y, z). @param mask of it, not 0. */
static sc_block tight_block(int x, int y, int z, uint64_t mask)
{
    const uint64_t rows = mask | mask >> 32, row = rows | rows >> 16; /* of all layers together */
    const unsigned all = (unsigned)(row | row >> 8);
    unsigned places[3] = {(all | all >> 4) & 15, 0, 0};
    int ends[3][2];
    sc_block block = {0};

    for (int i = 0; i < SC_BRICK; i++) {
        places[1] |= (row >> 4 * i & 15) ? 1u << i : 0;
        places[2] |= (mask >> 16 * i & 0xffff) ? 1u << i : 0;
    }
    for (int i = 0; i < 3; i++) {
        find_ends(places[i], ends[i]);
        block.extents[i] = (uint8_t)(ends[i][1] - ends[i][0] + 1);
    }
    /* cells reach from their lowest vertex to the next; vertex - 1 is the voxel */
    block.x = (float)(x * SC_BRICK - 1) + (float)(ends[0][0] + ends[0][1] + 1) * 0.5f;
    block.y = (float)(y * SC_BRICK - 1) + (float)(ends[1][0] + ends[1][1] + 1) * 0.5f;
    block.z = (float)(z * SC_BRICK - 1) + (float)(ends[2][0] + ends[2][1] + 1) * 0.5f;
    return block;
}

/* A search for blocks, as its threads share it. */
typedef struct block_finder {
    const sc_renderer *renderer;
    uint64_t *counts; /* [layers of blocks], of the team: how many each layer has */
    sc_block *blocks; /* NULL as long as they are only counted */
} block_finder;

/* Count the blocks of layers [begin, end), or store them at their places, in the order z, y, x; an
 * sc_range_fn on a block_finder. */
static void find_in_layers(void *user, size_t begin, size_t end, int thread)
{
    const block_finder *f = user;
    const sc_renderer *r = f->renderer;
    const int *bricks = r->volume->bricks;
    const int edge = r->bounds.has_tight_blocks ? 1 : BLOCK;

    for (size_t layer = begin; layer < end; layer++) {
        const int z = (int)layer * edge;
        uint64_t before = 0, found = 0;

        for (size_t i = 0; f->blocks && i < layer; i++)
            before += f->counts[i];
        for (int y = 0; y < bricks[1]; y += edge) {
            for (int x = 0; x < bricks[0]; x += edge) {
                const uint64_t mask = visible_in(r, x, y, z);

                if (!mask)
                    continue;
                if (f->blocks)
                    f->blocks[before + found] = r->bounds.has_tight_blocks
                                                    ? tight_block(x, y, z, mask)
                                                    : wide_block(x, y, z);
                found++;
            }
        }
        if (!f->blocks)
            f->counts[layer] = found;
    }
}

sc_status sc_find_blocks(const sc_ctx *ctx, sc_renderer *r)
{
    const int edge = r->bounds.has_tight_blocks ? 1 : BLOCK;
    const size_t layers = (size_t)((r->volume->bricks[2] + edge - 1) / edge);
    block_finder finder = {.renderer = r};
    size_t found = 0;
    void *block, *counts = NULL;
    sc_status status;

    SC_TRY(sc_team_alloc(ctx, r->team, layers, sizeof *finder.counts, &counts));
    finder.counts = counts;
    sc_team_for(r->team, layers, 1, find_in_layers, &finder);
    for (size_t i = 0; i < layers; i++)
        found += finder.counts[i];
    SC_TRY(sc_team_alloc(ctx, r->team, found, sizeof *r->bounds.blocks, &block));
    finder.blocks = block;
    sc_team_for(r->team, layers, 1, find_in_layers, &finder);
    r->bounds.blocks = finder.blocks;
    r->bounds.block_count = found;
out:
    sc_team_free(r->team, counts);
    return status;
}

/* One axis of the camera as a function of the voxel: position in mm = dot(axis, voxel) + offset.
 * And how far a block reaches along it to either side of its middle: its margin, and so much for
 * each voxel of its extents. */
typedef struct screen_axis {
    double x, y, z, offset;
    double margin, reach[3];
} screen_axis;

/* One axis of the camera: the unit vector @p direction in RAS, from the position of the camera. */
static screen_axis make_axis(const sc_renderer *r, const sc_camera *c, sc_vec3 direction)
{
    const sc_affine *to_mm = &r->volume->to_ras_mm;
    const double margin = !r->bounds.has_tight_blocks                ? WIDE_MARGIN
                          : r->settings.surface == SC_SURFACE_SMOOTH ? CELL_MARGIN
                                                                     : VOXEL_MARGIN;
    screen_axis a = {sc_vec3_dot(direction, sc_affine_column(to_mm, 0)),
                     sc_vec3_dot(direction, sc_affine_column(to_mm, 1)),
                     sc_vec3_dot(direction, sc_affine_column(to_mm, 2)),
                     0,
                     0,
                     {0}};

    a.offset = sc_vec3_dot(direction,
                           sc_vec3_sub(sc_affine_point(to_mm, (sc_vec3){0, 0, 0}), c->position_mm));
    a.reach[0] = fabs(a.x) / 2;
    a.reach[1] = fabs(a.y) / 2;
    a.reach[2] = fabs(a.z) / 2;
    a.margin = margin * (fabs(a.x) + fabs(a.y) + fabs(a.z));
    return a;
}

/* Position in mm of the middle of a block along the axis. */
static inline double along(const screen_axis *a, const sc_block *b)
{
    return a->x * (double)b->x + a->y * (double)b->y + a->z * (double)b->z + a->offset;
}

/* How far a block reaches along the axis to either side of its middle, in mm. */
static inline double reach_of(const screen_axis *a, const sc_block *b)
{
    return a->margin + a->reach[0] * b->extents[0] + a->reach[1] * b->extents[1] +
           a->reach[2] * b->extents[2];
}

/* The squares of the map between the two positions @p ends, in mm along one axis of the screen.
 * Each is projected with the factor (pixels per mm) of the near or far side of the block,
 * whichever makes the interval larger, with a little to spare. @param middle of the viewport, in
 * pixels. @param px edge of a square. @param count squares along the axis. @param out first and
 * last square; the first is greater if none is on the map. */
static inline void squares_between(const double ends[2], const double factors[2], double middle,
                                   double margin_px, double px, int count, int out[2])
{
    const double from = middle + ends[0] * factors[ends[0] < 0 ? 0 : 1];
    const double to = middle + ends[1] * factors[ends[1] > 0 ? 0 : 1];
    const double first = (from - margin_px) / px + 1, last = (to + margin_px) / px + 1;

    out[0] = first > 0 ? (int)fmin(first, count) : 0;
    out[1] = last < count - 1 ? (int)fmax(last, -1) : count - 1;
}

/* Let the levels of a map be those of distances between the ends of what is visible, unless some of
 * that may be beside the eye or behind it: then the eye can be within a tissue, of which a clip
 * plane shows what lies before its marked boundary. Elsewhere a ray meets the boundary of a tissue
 * before all else of it. @param deep the axis of the direction of view. A point at this position
 * along it is at least as far from the eye. */
static void set_levels(sc_cover *cover, const sc_renderer *r, const screen_axis *deep)
{
    const sc_vec3 middle = sc_vec3_scale(sc_vec3_add(r->space.box.low, r->space.box.high), 0.5);
    const sc_vec3 half = sc_vec3_scale(sc_vec3_sub(r->space.box.high, r->space.box.low), 0.5);
    /* Each block has something of the box in it, and may reach beyond by its own depth; half as
     * much more for safety. */
    const sc_block largest = wide_block(0, 0, 0);
    const double reach = fabs(deep->x) * half.x + fabs(deep->y) * half.y + fabs(deep->z) * half.z +
                         3 * reach_of(deep, &largest);
    const double at = deep->x * middle.x + deep->y * middle.y + deep->z * middle.z + deep->offset;

    if (!(at - reach > 0))
        return;
    cover->near_mm = at - reach;
    cover->level_mm = 2 * reach / LEVELS;
}

/* The level of a block whose nearest corner is at @p near_mm along the direction of view. */
static inline uint8_t level_of(const sc_cover *cover, double near_mm)
{
    const double level = cover->level_mm > 0 ? 1 + (near_mm - cover->near_mm) / cover->level_mm : 1;

    return (uint8_t)fmin(fmax(level, 1), LEVELS);
}

/* Set squares of a map to a level, unless they have one that is nearer. @param columns, rows first
 * and last. */
static inline void set_squares(const sc_cover *cover, uint8_t *squares, const int columns[2],
                               const int rows[2], uint8_t level)
{
    for (int row = rows[0]; row <= rows[1]; row++) {
        uint8_t *to = squares + row * cover->columns;

        for (int column = columns[0]; column <= columns[1]; column++)
            to[column] = !to[column] || level < to[column] ? level : to[column];
    }
}

/* A map for the viewport with every square set to @p value: as fine as fits @p squares, which
 * has room for SC_COVER_SIDE^2 of them and is borrowed. */
static sc_cover empty_cover(const sc_viewport *viewport, uint8_t *squares, uint8_t value)
{
    const int side =
        viewport->width_px > viewport->height_px ? viewport->width_px : viewport->height_px;
    sc_cover cover = {.squares = squares, .shift = SC_COVER_SHIFT};

    while ((side >> cover.shift) + 3 > SC_COVER_SIDE)
        cover.shift++;
    cover.columns = (viewport->width_px >> cover.shift) + 3;
    cover.rows = (viewport->height_px >> cover.shift) + 3;
    memset(squares, value, (size_t)cover.columns * (size_t)cover.rows);
    return cover;
}

/* @return by how much what lies between two depths is blurred, in pixels to each side: the most is
 * at one of them. @param factors pixels per mm there. */
static double blur_px(const sc_camera *c, double scale, const double factors[2])
{
    const double sharp = c->aperture_mm > 0 ? scale / c->focus_mm : 0;

    return c->aperture_mm / 2 * fmax(fabs(sharp - factors[0]), fabs(sharp - factors[1]));
}

/* Make the map of a view from r->bounds.blocks. Where r->cover.covers_all, all of it is set to
 * level 1, of no known distance. */
static void make_cover(sc_renderer *r, const sc_scene *scene, const sc_viewport *viewport)
{
    sc_cover *cover = &r->cover.map;
    const sc_camera *c = &scene->camera;
    const screen_axis right = make_axis(r, c, c->right),
                      down = make_axis(r, c, sc_vec3_scale(c->up, -1)),
                      deep = make_axis(r, c, c->forward);
    const double scale = viewport->height_px / (2 * c->half_height);
    const double least_px = r->bounds.has_tight_blocks ? TIGHT_MARGIN_PX : WIDE_MARGIN_PX;
    const bool is_all = r->cover.covers_all || c->projection == SC_EQUIRECTANGULAR;

    *cover = empty_cover(viewport, r->cover.squares, is_all);
    if (!is_all)
        set_levels(cover, r, &deep);
    for (size_t i = 0; i < r->bounds.block_count && !is_all; i++) {
        const sc_block *block = &r->bounds.blocks[i];
        const double x = along(&right, block), y = along(&down, block), z = along(&deep, block);
        const double aside = reach_of(&right, block), below = reach_of(&down, block);
        const double behind = reach_of(&deep, block);
        const double across[2] = {x - aside, x + aside}, downward[2] = {y - below, y + below};
        double factors[2] = {
            scale, scale}; /* from mm to pixels, at the near and the far side of the block */
        double margin_px = least_px;
        int columns[2], rows[2];

        if (c->projection == SC_PERSPECTIVE) {
            if (z + behind < 0)
                continue;
            if (z - behind < 1e-3 * behind) { /* the eye is in the block, or nearly so */
                *cover = empty_cover(viewport, r->cover.squares, 1);
                return;
            }
            factors[0] = scale / (z - behind);
            factors[1] = scale / (z + behind);
            margin_px += blur_px(c, scale, factors);
        }
        squares_between(across, factors, viewport->width_px / 2.0, margin_px, 1 << cover->shift,
                        cover->columns, columns);
        squares_between(downward, factors, viewport->height_px / 2.0, margin_px, 1 << cover->shift,
                        cover->rows, rows);
        set_squares(cover, r->cover.squares, columns, rows, level_of(cover, z - behind));
    }
}

void sc_cover_view(sc_renderer *r, const sc_scene *scene, const sc_viewport *viewport)
{
    /* Equal bytes are equal scenes; should only padding differ, the map is made once more in vain.
     * NOLINTNEXTLINE(bugprone-suspicious-memory-comparison) */
    if (!memcmp(&r->cover.scene, scene, sizeof r->cover.scene) &&
        !memcmp(&r->cover.viewport, viewport, sizeof r->cover.viewport))
        return;
    make_cover(r, scene, viewport);
    r->cover.scene = *scene;
    r->cover.viewport = *viewport;
}
