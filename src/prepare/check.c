/* SPDX-License-Identifier: BSD-3-Clause */
/* Checks what a prepared file holds. A checksum tells accidents, not forgeries: whatever the
 * kernels use as an index or compute with is examined before they see it. */
#include "internal.h"

#include <string.h>

/* Log that @p path holds something that segcast never writes. @return SC_ERR_DATA. */
static sc_status refuse(const sc_ctx *ctx, const char *path, const char *what)
{
    return sc_fail(ctx, SC_ERR_DATA,
                   "%s: %s, although its checksum is right: segcast has not written this; prepare "
                   "it again",
                   path, what);
}

/* Is @p value a finite number from @p low to @p high? */
static bool is_within(double value, double low, double high)
{
    return value >= low && value <= high; /* false for what is no number */
}

/* Is the bool at @p address 0 or 1? To read another value as a bool would be undefined. */
static bool is_bool(const void *address)
{
    unsigned char byte;

    memcpy(&byte, address, 1);
    return byte <= 1;
}

/* @return what is wrong with a label, or NULL. @param before the one before it; NULL: it is the
 * first, the background. */
static const char *wrong_with_label(const sc_label *label, const sc_label *before)
{
    char copy[SC_NAME_BYTES];

    if (before ? !label->value || (before->value && label->value <= before->value)
               : label->value != 0)
        return "its labels are not in order";
    if (!memchr(label->name, '\0', sizeof label->name) ||
        !sc_copy_name(label->name, copy, sizeof copy) || strcmp(copy, label->name) != 0)
        return "a label has a name that is no text";
    if (!is_bool(&label->has_color) || !is_bool(&label->hidden))
        return "a label has a flag that is neither 0 nor 1";
    if (!is_within((double)label->opacity, -1e30, 1))
        return "a label has an opacity beyond 1";
    return NULL;
}

/* @return what is wrong with the measurements of a label, or NULL. */
static const char *wrong_with_stats(const sc_prepared *v, const sc_label_stats *stats,
                                    uint64_t voxels)
{
    if (stats->voxels > voxels || stats->boundary_voxels > stats->voxels)
        return "a label has more voxels than the volume";
    if (!is_within(stats->thickness_mm, 0, 1e30) || !is_within(stats->surface_mm2, 0, 1e30))
        return "a label has a thickness or surface that is no length or area";
    if (!is_within(stats->shown, 0, 1) || stats->cover_layer < 0 ||
        stats->cover_layer > SC_COVERS_MAX)
        return "a label lies further outside than can be";
    for (int i = 0; i < 3; i++) {
        /* the box of a label without voxels, which nothing has made larger */
        if (!stats->voxels && stats->low[i] == INT32_MAX && stats->high[i] == -1)
            continue;
        if (stats->low[i] < 0 || stats->low[i] > stats->high[i] || stats->high[i] >= v->size[i])
            return "a label lies outside of the volume";
    }
    return NULL;
}

/* @return the largest dense id in the volume. */
static unsigned largest_id(const sc_prepared *v, size_t voxels)
{
    unsigned largest = 0;

    if (v->label_bytes == 1) {
        const uint8_t *ids = v->ids;
        uint8_t most = 0; /* of the width of the ids, so that many are compared at a time */

        for (size_t i = 0; i < voxels; i++)
            most = ids[i] > most ? ids[i] : most;
        largest = most;
    } else {
        const uint16_t *ids = v->ids;
        uint16_t most = 0;

        for (size_t i = 0; i < voxels; i++)
            most = ids[i] > most ? ids[i] : most;
        largest = most;
    }
    return largest;
}

/* @return the vertices of a brick that belong to the grid of a volume of @p size voxels, as bits.
 * @param low its lowest vertex. */
static uint64_t bits_of_grid(const int size[3], const int low[3])
{
    uint64_t bits = 0;

    if (low[0] + SC_BRICK <= size[0] + 2 && low[1] + SC_BRICK <= size[1] + 2 &&
        low[2] + SC_BRICK <= size[2] + 2)
        return ~0ull;
    for (int bit = 0; bit < SC_BRICK_VERTICES; bit++) {
        if (low[0] + sc_bit_x(bit) < size[0] + 2 && low[1] + sc_bit_y(bit) < size[1] + 2 &&
            low[2] + sc_bit_z(bit) < size[2] + 2)
            bits |= 1ull << bit;
    }
    return bits;
}

/* @return what is wrong with masks of vertices [bricks z][y][x] and where in an array what belongs
 * to each brick begins, or NULL: it follows that of the brick before, and there is as much as there
 * are bits. @param count how much there is of all. */
static const char *wrong_with_masks(const sc_prepared *v, const uint64_t *masks,
                                    const uint32_t *start, uint64_t count)
{
    uint64_t marked = 0;
    size_t brick = 0;

    for (int z = 0; z < v->bricks[2]; z++) {
        for (int y = 0; y < v->bricks[1]; y++) {
            for (int x = 0; x < v->bricks[0]; x++, brick++) {
                const int low[3] = {x * SC_BRICK, y * SC_BRICK, z * SC_BRICK};

                if (start[brick] != marked)
                    return "a brick has its vertices in the wrong place";
                if (masks[brick] & ~bits_of_grid(v->size, low))
                    return "a vertex outside of the grid is marked";
                marked += masks[brick] ? sc_count_bits(masks[brick]) : 0;
            }
        }
    }
    return marked == count ? NULL : "it has not as many vertex records as marked vertices";
}

/* @return what is wrong with the vertex records of a field, or NULL. A value of 0 would leave a
 * cell without any vote. @param least of a value. */
static const char *wrong_with_border(const sc_prepared *v, const sc_border *b, int least)
{
    unsigned wrong = 0;

    for (uint64_t i = 0; i < b->count; i++) {
        const int value = sc_record_value(b->records[i]);

        wrong |= (unsigned)(value == 0) | (unsigned)(value < least) |
                 (unsigned)(sc_record_tissue(b->records[i]) >= SC_TISSUE_CODES);
    }
    return wrong ? "a vertex record has no value, or no tissue"
                 : wrong_with_masks(v, b->masks, b->start, b->count);
}

/* @return whether nothing is marked in @p count masks, whose cells begin at @p at. */
static bool is_empty(const uint64_t *masks, const uint32_t *start, size_t count, uint64_t at)
{
    uint64_t wrong = 0;

    for (size_t i = 0; i < count; i++)
        wrong |= masks[i] | (start[i] ^ at);
    return !wrong;
}

/* @return the largest label of the packed cells that are stored. */
static unsigned largest_label(const sc_stored *stored)
{
    unsigned largest = 0;

    for (size_t i = 0; i < stored->cell_count; i++) {
        const unsigned low = stored->cells[i].labels & 0xffff,
                       high = stored->cells[i].labels >> SC_CELL_LABEL_BITS;

        largest = low > largest ? low : largest;
        largest = high > largest ? high : largest;
    }
    return largest;
}

/* @return what is wrong with the cells that are stored, or NULL: only cells of the label grid are
 * marked, each brick's packed cells follow those of the brick before it, and their labels are in
 * the table. What else the packed cells hold is only computed with, to numbers that stay small, and
 * distances only lead to other bricks further along a ray. */
static const char *wrong_with_cells(const sc_prepared *v)
{
    const size_t row = (size_t)sc_framed_row(v->bricks), nx = (size_t)v->bricks[0];
    const size_t layer = (size_t)sc_framed_layer(v->bricks);
    const uint64_t *masks = v->stored.masks;
    const uint32_t *start = v->stored.cell_start;
    const int fewer[3] = {v->size[0] - 1, v->size[1] - 1, v->size[2] - 1}; /* cells than vertices */
    uint64_t cells = 0, outside = 0;
    size_t at = 0;

    /* What lies between the rows of bricks is the frame. */
    for (int z = 0; z < v->bricks[2]; z++) {
        for (int y = 0; y < v->bricks[1]; y++) {
            const size_t begin = ((size_t)z + 1) * layer + ((size_t)y + 1) * row + 1;

            if (!is_empty(masks + at, start + at, begin - at, cells))
                return "a cell outside of the grid is marked";
            for (size_t x = 0; x < nx; x++) {
                const uint64_t mask = masks[begin + x];
                const int low[3] = {(int)x * SC_BRICK, y * SC_BRICK, z * SC_BRICK};

                outside |=
                    (mask ? mask & ~bits_of_grid(fewer, low) : 0) | (start[begin + x] ^ cells);
                cells += mask ? sc_count_bits(mask) : 0;
            }
            at = begin + nx;
        }
    }
    if (!is_empty(masks + at, start + at, layer * ((size_t)v->bricks[2] + 2) - at, cells))
        return "a cell outside of the grid is marked";
    if (outside)
        return "a brick has its cells in the wrong place";
    if (cells != v->stored.cell_count)
        return "it has not as many cells as are marked";
    return largest_label(&v->stored) < (unsigned)v->label_count
               ? NULL
               : "a cell has a label that is not in its table";
}

/* @return what is wrong with the points of the hull that are stored, or NULL: all lie within the
 * sphere around the volume, as far as rounding allows. */
static const char *wrong_with_hull(const sc_prepared *v)
{
    const sc_vec3 low = {-0.5, -0.5, -0.5};
    const sc_vec3 high = {v->size[0] - 0.5, v->size[1] - 0.5, v->size[2] - 0.5};
    const sc_vec3 middle =
        sc_affine_point(&v->to_ras_mm, sc_vec3_scale(sc_vec3_add(low, high), 0.5));
    double radius_mm = 0;

    for (int i = 0; i < 4; i++) {
        const sc_vec3 corner = {i & 1 ? low.x : high.x, i & 2 ? low.y : high.y, high.z};
        const sc_vec3 apart = sc_vec3_sub(sc_affine_point(&v->to_ras_mm, corner), middle);

        radius_mm = fmax(radius_mm, sc_vec3_length(apart));
    }
    radius_mm += 1e-6 * (radius_mm + sc_vec3_length(middle));
    for (size_t i = 0; i < v->stored.hull_count; i++) {
        if (!is_within(sc_vec3_length(sc_vec3_sub(v->stored.hull[i], middle)), 0, radius_mm))
            return "a point of its hull lies outside of the volume";
    }
    return NULL;
}

sc_status sc_check_prepared(const sc_ctx *ctx, const char *path, const sc_prepared *v)
{
    const size_t voxels = (size_t)v->size[0] * (size_t)v->size[1] * (size_t)v->size[2];
    const char *wrong = NULL;

    SC_PASS(sc_geometry_check(ctx, path, v->size, &v->to_ras_mm));
    for (int id = 0; id < v->label_count && !wrong; id++) {
        wrong = wrong_with_label(&v->labels[id], id ? &v->labels[id - 1] : NULL);
        if (!wrong)
            wrong = wrong_with_stats(v, &v->stats[id], voxels);
        if (!wrong && !(is_within(v->how.smooth[id].x, 0, SC_SMOOTH_MAX) &&
                        is_within(v->how.smooth[id].y, 0, SC_SMOOTH_MAX) &&
                        is_within(v->how.smooth[id].z, 0, SC_SMOOTH_MAX)))
            wrong = "a strength of smoothing is out of range";
        if (!wrong && v->how.hidden[id] > 1)
            wrong = "a label is neither hidden nor shown";
    }
    if (!wrong && largest_id(v, voxels) >= (unsigned)v->label_count)
        wrong = "a voxel has a label that is not in its table";
    if (!wrong)
        wrong = wrong_with_masks(v, v->boundary.masks, v->boundary.start, v->boundary.count);
    if (!wrong)
        wrong = wrong_with_border(v, &v->outer, -SC_VALUE_MAX);
    if (!wrong)
        wrong = wrong_with_border(v, &v->inner, 1);
    if (!wrong && v->stored.masks)
        wrong = wrong_with_cells(v);
    if (!wrong && v->stored.masks)
        wrong = wrong_with_hull(v);
    return wrong ? refuse(ctx, path, wrong) : SC_OK;
}
