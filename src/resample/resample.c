/* SPDX-License-Identifier: BSD-3-Clause */
/* The grid on which a volume is drawn, and the steps that lead there. */
#include "internal.h"

#include <stdarg.h>

enum { MOST_LAYERS = 15 }; /* into which a drawn voxel is split */
/* Drawn voxels are split until they are at most so many times as long as the shortest. */
#define LONGEST_LAYER 1.5
/* Beyond this ratio of lengths a spacing is in a wrong unit, and layers would tell nothing. */
#define MOST_RATIO 100.0

/* Write how many slices across each axis of a view jump to @p moved. @return SC_ERR_MEMORY. */
static sc_status count_moved(const sc_ctx *ctx, sc_team *team, const drawn_view *view, int moved[3])
{
    for (int axis = 0; axis < 3; axis++) {
        SC_OWN(sc_free_at) int *places = NULL;

        SC_PASS(sc_team_agree(team, SC_ALLOC(ctx, 2 * (size_t)view->size[axis], &places)));
        SC_PASS(sc_resample_find_moved(ctx, team, view, axis, places, &moved[axis]));
    }
    return SC_OK;
}

sc_status sc_find_drawn_grid(const sc_ctx *ctx, const sc_volume *volume, int threads,
                             sc_drawn_grid *out)
{
    sc_team *team = NULL;
    sc_status status = sc_team_open(ctx, NULL, threads, NULL, &team);

    if (status == SC_OK)
        status = sc_find_drawn_grid_together(ctx, team, volume, out);
    sc_team_close(team);
    return status;
}

sc_status sc_find_drawn_grid_together(const sc_ctx *ctx, sc_team *team, const sc_volume *volume,
                                      sc_drawn_grid *out)
{
    sc_drawn_grid grid = {.copies = {1, 1, 1}, .split = {1, 1, 1}};
    SC_OWN(sc_drawn_view_clear) drawn_view view = {0};
    double shortest = HUGE_VAL;

    SC_PASS(sc_resample_find_copies(ctx, team, volume, &grid));
    for (int i = 0; i < 3; i++) {
        grid.drawn_mm[i] = grid.copies[i] * sc_vec3_length(sc_affine_column(&volume->to_ras_mm, i));
        if (volume->size[i] > 1)
            shortest = fmin(shortest, grid.drawn_mm[i]);
    }
    for (int i = 0; i < 3; i++) {
        const double ratio = grid.drawn_mm[i] / shortest;

        while (volume->size[i] > 1 && ratio > SC_THICK_RATIO && ratio <= MOST_RATIO &&
               ratio / grid.split[i] > LONGEST_LAYER && grid.split[i] < MOST_LAYERS)
            grid.split[i] += 2;
    }
    SC_PASS(sc_team_agree(team, sc_drawn_view_make(ctx, volume, &grid, &view)));
    SC_PASS(count_moved(ctx, team, &view, grid.moved));
    *out = grid;
    return SC_OK;
}

/* Does sc_resample change the grid itself, not only labels on it? */
static bool is_other_grid(const sc_drawn_grid *grid)
{
    for (int i = 0; i < 3; i++) {
        if (grid->copies[i] > 1 || grid->split[i] > 1)
            return true;
    }
    return false;
}

bool sc_is_resampled(const sc_drawn_grid *grid)
{
    return is_other_grid(grid) || grid->moved[0] || grid->moved[1] || grid->moved[2];
}

/* Append words to @p text, which holds @p length bytes, behind a comma if there is anything. */
SC_PRINTF(4, 5)
static void append(char *text, size_t bytes, size_t *length, const char *format, ...)
{
    va_list arguments;

    va_start(arguments, format);
    if (*length > 0 && *length < bytes)
        *length += (size_t)snprintf(text + *length, bytes - *length, "; ");
    if (*length < bytes)
        *length += (size_t)vsnprintf(text + *length, bytes - *length, format, arguments);
    va_end(arguments);
}

void sc_drawn_grid_text(const sc_drawn_grid *grid, char *text, size_t bytes)
{
    const double *mm = grid->drawn_mm, *copies = grid->copies;
    size_t length = 0;

    text[0] = '\0';
    if (copies[0] > 1 || copies[1] > 1 || copies[2] > 1)
        append(text, bytes, &length,
               "drawn at %.3g x %.3g x %.3g mm, stored at %.3g x %.3g x %.3g mm", mm[0], mm[1],
               mm[2], mm[0] / copies[0], mm[1] / copies[1], mm[2] / copies[2]);
    for (int i = 0; i < 3; i++) {
        if (grid->split[i] > 1)
            append(text, bytes, &length, "each slice along %c becomes %d layers", "xyz"[i],
                   grid -> split[i]);
        if (grid->moved[i])
            append(text, bytes, &length, "%d slices along %c jump and are moved back",
                   grid->moved[i], "xyz"[i]);
    }
}

void sc_resampled_size(const sc_volume *volume, const sc_drawn_grid *grid, int size[3])
{
    for (int i = 0; i < 3; i++)
        size[i] = sc_resample_drawn_within(volume->size[i], grid->copies[i], grid->phase[i]) *
                  grid->split[i];
}

/* Scale size, spacing and the boxes of labels along an axis: @p factor old voxels become one. */
static void scale_axis(sc_volume *v, sc_label_tally *boxes, int axis, double factor, int size)
{
    v->size[axis] = size;
    for (int i = 0; i < 3; i++)
        v->to_ras_mm.m[i][axis] *= factor;
    for (int id = 0; id < v->label_count; id++) {
        boxes[id].low[axis] = (int)fmin(boxes[id].low[axis] / factor, size - 1);
        boxes[id].high[axis] = (int)fmin((boxes[id].high[axis] + 1) / factor, size - 1);
    }
}

sc_status sc_resample_bytes(const sc_ctx *ctx, const sc_volume *volume, const sc_drawn_grid *grid,
                            int threads, double *out)
{
    sc_volume v = *volume; /* of which only size and geometry are used */
    const sc_drawn_grid whole = {.copies = {grid->copies[0], grid->copies[1], grid->copies[2]},
                                 .phase = {grid->phase[0], grid->phase[1], grid->phase[2]},
                                 .split = {1, 1, 1}};
    SC_OWN(sc_free_at) sc_label_tally *boxes = NULL;
    double most = 0; /* of the steps, one after the other */
    int size[3];

    sc_resampled_size(volume, &whole, size);
    if (grid->moved[0] || grid->moved[1] || grid->moved[2])
        most = (double)size[0] * size[1] * size[2] * volume->label_bytes;
    if (grid->split[0] > 1 || grid->split[1] > 1 || grid->split[2] > 1) {
        SC_PASS(sc_resample_find_boxes(ctx, volume, threads, &boxes));
        for (int i = 0; i < 3; i++)
            scale_axis(&v, boxes, i, grid->copies[i], size[i]);
    }
    for (int i = 0; i < 3; i++) {
        if (grid->split[i] == 1)
            continue;
        most = fmax(most, sc_resample_split_bytes(&v, boxes, i, threads));
        scale_axis(&v, boxes, i, 1.0 / grid->split[i], v.size[i] * grid->split[i]);
    }
    *out = most;
    return SC_OK;
}

sc_status sc_resample(const sc_ctx *ctx, sc_volume *volume, const sc_drawn_grid *grid, int threads)
{
    for (int axis = 0; axis < 3; axis++) {
        if (grid->copies[axis] > 1)
            SC_PASS(sc_resample_remove_copies(ctx, volume, axis, grid->copies[axis],
                                              grid->phase[axis]));
    }
    for (int axis = 0; axis < 3; axis++) {
        if (grid->moved[axis])
            SC_PASS(sc_resample_move_slices(ctx, volume, axis, threads));
    }
    for (int axis = 0; axis < 3; axis++) {
        if (grid->split[axis] > 1)
            SC_PASS(sc_resample_split_slices(ctx, volume, axis, grid->split[axis], threads));
    }
    return SC_OK;
}
