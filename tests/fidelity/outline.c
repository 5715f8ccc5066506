/* SPDX-License-Identifier: BSD-3-Clause */
/* Finds points of the drawn surface between background and tissue, and of the seams on it. */
#include "rulers.h"

#include <stdlib.h>
#include <string.h>

enum {
    MARGIN = 10, /* voxels from the faces of the volume */
    HALVINGS = 12
};
/* A ray that looks for the tissue starts so far outside of the surface, in voxels; between two
 * lines the surface may lie as much deeper or less. */
#define OUTSIDE 1.5

/* What the worker search_layers needs, and a place for what each layer has. */
typedef struct search {
    const stage *st;
    sc_affine to_ras_mm, to_drawn; /* from voxels of the volume, to mm and to voxels of the stage */
    double spacing[3];
    bool is_same_grid;
    struct {
        wobble_points outline, seams;
    } * layers; /* [size[2]] */
} search;

/* A place on a line along an axis through voxel centres, in voxels. */
typedef struct place {
    double at[3];
    int axis, outward; /* 1 or -1: the way along the axis to the background */
} place;

void wobble_add(wobble_points *to, const wobble_point *p)
{
    if (to->count == to->capacity) {
        to->capacity = to->capacity ? 2 * to->capacity : 256;
        to->list = realloc(to->list, to->capacity * sizeof *to->list);
        if (!to->list)
            abort();
    }
    to->list[to->count++] = *p;
}

/* A point in voxels, in mm. */
static sc_vec3 mm_of(const search *s, const double at[3])
{
    return sc_affine_point(&s->to_ras_mm, (sc_vec3){at[0], at[1], at[2]});
}

/* Does tissue own the point? */
static bool is_tissue(const search *s, const double at[3])
{
    return owner_at(s->st, mm_of(s, at)) != 0;
}

/* The tissue that a ray meets first which starts at @p from, in background, on the way inward; how
 * many voxels away to @p depth. 0 if it starts in tissue or meets none within twice OUTSIDE. */
static uint32_t seen_from(const search *s, const place *from, double *depth)
{
    const sc_vec3 column = sc_affine_column(&s->to_ras_mm, from->axis);
    const sc_vec3 direction = sc_vec3_unit(sc_vec3_scale(column, -from->outward));
    const sc_vec3 eye = mm_of(s, from->at);
    sc_march_counters counters = {0};
    sc_radiance light;
    sc_ray ray;

    if (is_tissue(s, from->at))
        return 0;
    make_ray(s->st, eye, direction, &ray);
    s->st->kernel->march(&s->st->march, &ray, NULL, 1, &light, &counters);
    *depth = (double)light.depth_mm / s->spacing[from->axis];
    return *depth <= 2 * OUTSIDE ? light.label : 0;
}

/* The place @p share of the way from a surface point to the next line along @p across, OUTSIDE
 * voxels in front of a surface that changes by @p rise voxels outward on the way. */
static place in_front(const place *surface, int across, double share, double rise)
{
    place p = *surface;

    p.at[across] += share;
    p.at[p.axis] += p.outward * (OUTSIDE + share * rise);
    return p;
}

/* Look for a seam between a point of the surface and the next line along @p across, by halving the
 * way between them, and add it to @p to. @p own: the tissue seen at the point. */
static void find_seam(const search *s, const place *surface, int across, uint32_t own,
                      wobble_points *to)
{
    place from = in_front(surface, across, 1, 0);
    double low = 0, high = 1, depth, rise;
    uint32_t other = seen_from(s, &from, &depth);

    if (!other || other == own)
        return;
    rise = OUTSIDE - depth;
    if (fabs(rise) * s->spacing[surface->axis] > s->spacing[across])
        return;
    for (int i = 0; i < HALVINGS; i++) {
        const double middle = (low + high) / 2;
        uint32_t seen;

        from = in_front(surface, across, middle, rise);
        seen = seen_from(s, &from, &depth);
        if (seen != own && seen != other)
            return;
        *(seen == own ? &low : &high) = middle;
    }
    from.at[from.axis] -= from.outward * depth;
    wobble_add(to, &(wobble_point){.at = {(float)from.at[0], (float)from.at[1], (float)from.at[2]},
                                   .pair = own < other ? own << 16 | other : other << 16 | own});
}

/* Add the point between @p low and @p high on a line along @p axis, one of which tissue owns and
 * the other not, and the seams beside it. */
static void add_point(const search *s, int axis, const double low[3], const double high[3], int z)
{
    place p = {.at = {low[0], low[1], low[2]}, .axis = axis, .outward = is_tissue(s, low) ? 1 : -1};
    double a = low[axis], b = high[axis], depth;
    uint32_t own;
    place from;

    for (int i = 0; i < HALVINGS; i++) {
        p.at[axis] = (a + b) / 2;
        *(is_tissue(s, p.at) == (p.outward > 0) ? &a : &b) = p.at[axis];
    }
    wobble_add(&s->layers[z].outline,
               &(wobble_point){.at = {(float)p.at[0], (float)p.at[1], (float)p.at[2]}});
    from = in_front(&p, axis, 0, 0);
    own = seen_from(s, &from, &depth);
    if (!own || fabs(depth - OUTSIDE) > 0.1)
        return;
    for (int k = 1; k < 3; k++)
        find_seam(s, &p, (axis + k) % 3, own, &s->layers[z].seams);
}

/* Does a single label own everything between the voxel @p at and the next one along each axis?
 * False if the volume is drawn on another grid. */
static bool is_plain(const search *s, const int at[3])
{
    const sc_vec3 inside = {at[0] + 0.25, at[1] + 0.25, at[2] + 0.25};

    return s->is_same_grid && is_uniform(s->st, sc_affine_point(&s->to_drawn, inside));
}

/* Look at the way from the voxel @p at to the next one along @p axis, if that is not too near a
 * face of the volume. */
static void search_step(const search *s, const int at[3], int axis)
{
    double low[3] = {at[0], at[1], at[2]}, high[3] = {at[0], at[1], at[2]};

    if (at[axis] + 1 >= s->st->voxels->size[axis] - MARGIN)
        return;
    for (int half = 0; half < 2; half++) {
        high[axis] = low[axis] + 0.5;
        if (is_tissue(s, low) != is_tissue(s, high))
            add_point(s, axis, low, high, at[2]);
        low[axis] = high[axis];
    }
}

/* Worker of sc_parallel_for: search layers [@p begin, @p end) of voxels. */
static void search_layers(void *user, size_t begin, size_t end, int thread)
{
    const search *s = user;
    const int *size = s->st->voxels->size;

    for (int z = (int)begin; z < (int)end; z++) {
        if (z < MARGIN || z >= size[2] - MARGIN)
            continue;
        for (int y = MARGIN; y < size[1] - MARGIN; y++) {
            for (int x = MARGIN; x < size[0] - MARGIN; x++) {
                const int at[3] = {x, y, z};

                for (int axis = 0; axis < 3 && !is_plain(s, at); axis++)
                    search_step(s, at, axis);
            }
        }
    }
}

/* Append all of @p from to @p to and free it. */
static void move_points(wobble_points *from, wobble_points *to)
{
    for (size_t i = 0; i < from->count; i++)
        wobble_add(to, &from->list[i]);
    free(from->list);
    *from = (wobble_points){0};
}

void wobble_find(const stage *st, int threads, wobble_points *outline, wobble_points *seams)
{
    const size_t layers = (size_t)st->voxels->size[2];
    search s = {.st = st, .to_ras_mm = st->voxels->to_ras_mm};

    s.to_drawn = sc_affine_compose(&st->to_voxel, &s.to_ras_mm);
    for (int i = 0; i < 3; i++)
        s.spacing[i] = sc_vec3_length(sc_affine_column(&s.to_ras_mm, i));
    s.is_same_grid = !memcmp(st->volume.size, st->voxels->size, sizeof st->volume.size);
    s.layers = calloc(layers, sizeof *s.layers);
    if (!s.layers)
        abort();
    sc_parallel_for(threads, layers, 1, search_layers, &s);
    for (size_t z = 0; z < layers; z++) {
        move_points(&s.layers[z].outline, outline);
        move_points(&s.layers[z].seams, seams);
    }
    free(s.layers);
}
