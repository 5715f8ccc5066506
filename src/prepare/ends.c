/* SPDX-License-Identifier: BSD-3-Clause */
/* Tissue that ends at the border of the volume, instead of being cut off by it.
 *
 * Nothing is known of what lies beyond the last layer of voxels, so surfaces go straight on to the
 * border of the volume, half a voxel farther, and are cut off there. But a ball that only touches
 * the border, as organs do in a volume that was cropped to their box, would end in a flange: its
 * last cross-section is a disc that is much smaller than the one before, and would go straight on.
 *
 * There the two tell where the tissue ends above the last layer. In each of them every point has a
 * signed distance to the outline of all tissue within the layer, positive inside: the outline is
 * where it is 0. If it falls from d1 to d0 from the last layer but one to the last, it falls to 0
 * at the height d0 / (d1 - d0), in layers, were its fall even (shape-based interpolation: Raya and
 * Udupa 1990, here beyond the last slice). Round ends fall faster. In a paraboloid the square of
 * the radius falls evenly, which makes the height (2 r - d0) / (2 r + d1 - d0) times as large,
 * where r, the radius, is the distance in the middle of the disc.
 *
 * So it is decided for each disc, which is all of one tissue that is connected within the last
 * layer, by the height of its middle, from the mean of what its outline moves by beside background.
 * Where that is well above half a layer, the tissue goes on beyond the border, and all of the disc
 * is a cut face. Otherwise the vertices beyond the border note the height, where it is below half a
 * layer (sc_record_pack_end), and the directions of the disc are turned to those of its end. In the
 * distances all tissues count as one: where one of them ends because another begins, it goes
 * straight on. */
#include "filters.h"
#include "internal.h"

enum {
    FACES = 6,
    DISCS_MAX = 1 << 16, /* a face with more of them is noise, and all of it is cut off */
    TILE = 64,  /* vertices of a face of the volume that are done at a time, along an axis */
    REACH = 12, /* voxels: so far distances are measured */
    BESIDE = 2, /* voxels: so far around a disc, vertices of the background may get a new direction;
                   at least TURNED */
    BLUR = 2,   /* voxels: radius of the filter that takes the steps out of distances */
    MARGIN = REACH + BLUR,
    SIDE = TILE + 2 * MARGIN
};

/* A disc is an end if its middle is so high above the last layer, in layers, or less. That of a
 * paraboloid that just reaches the border is 0.5. */
#define MIDDLE_MAX 0.65f
/* For so many voxels beside background, one of an end may be beside another tissue. */
#define TOUCHING_PART 4
/* By how many voxels the outline must move from layer to layer at a place for an end there: at the
 * first nothing is noted, from the second on all of it. */
#define MOVES_FROM 0.5f
#define MOVES_ALL 1.5f
/* The least depth that a voxel of tissue has in its layer, in voxels. */
#define DEPTH_LEAST 0.15f
/* Up to this distance outside of the outline, in voxels, the directions in the records of
 * background vertices are turned, too. */
#define TURNED 1.5f

/* A face of the volume, and how its layers of voxels lie in memory. */
typedef struct face {
    int axis, axes[2]; /* the axis across it, and those along it */
    int last, before;  /* planes along axis: the last layer of voxels, and the one before it */
    int beyond;        /* along axis: the vertex outside of the volume */
    float length[2];   /* of a voxel along axes, the shorter being 1 */
    int size[2];       /* voxels along axes; 0 if there are no two layers */
} face;

/* A disc: voxels of one tissue that are connected within the last layer. */
typedef struct disc {
    int square;   /* edge of the largest square that fits in, in voxels */
    int outline;  /* voxels beside background */
    int touching; /* voxels beside another tissue */
    double moves; /* sum of what it moves by at these, in voxels */
    float depth;  /* the largest distance from the outline */
    bool ends;
} disc;

/* What the threads share. */
typedef struct ends {
    const sc_preparation *p;
    double to_mm[3][3]; /* of sc_gradient_to_mm, for gradients per voxel */
} ends;

/* The work on one face. Its arrays are owned, and NULL if it has no two layers. */
typedef struct face_work {
    const ends *e;
    face face;
    int32_t *disc_of; /* [v][u] of the last layer: the number of the disc, counted from 1; 0:
                         background */
    int32_t *squares; /* [u]: scratch */
    disc *discs;      /* [DISCS_MAX + 1], by number */
    int disc_count;
} face_work;

/* Values in a window around a tile, [v][u]. */
typedef float window[SIDE][SIDE];

/* The work on one tile. */
typedef struct tile_work {
    uint8_t tissue[SIDE][SIDE]; /* 1 where a layer holds tissue */
    window last, before;        /* signed distances in the two layers, in voxels */
    window inside, scratch;
} tile_work;

/* Set the face across @p axis at the end @p side of it. */
static void set_face(const sc_preparation *p, int axis, int side, face *f)
{
    const sc_volume *v = p->volume;
    double length[2];

    f->axis = axis;
    f->axes[0] = axis == 0 ? 1 : 0;
    f->axes[1] = axis == 2 ? 1 : 2;
    f->last = side ? v->size[axis] - 1 : 0;
    f->before = side ? f->last - 1 : 1;
    f->beyond = side ? v->size[axis] + 1 : 0;
    for (int i = 0; i < 2; i++) {
        length[i] = sc_vec3_length(sc_affine_column(&v->to_ras_mm, f->axes[i]));
        f->size[i] = v->size[axis] > 1 ? v->size[f->axes[i]] : 0;
    }
    for (int i = 0; i < 2; i++)
        f->length[i] = (float)(length[i] / fmin(length[0], length[1]));
}

/* @return the dense id in plane @p plane along the axis of a face, at a place along its axes;
 * beyond the volume, that of the nearest voxel. */
static uint32_t id_in_plane(const ends *e, const face *f, int plane, int u, int v)
{
    int at[3];

    at[f->axis] = plane;
    at[f->axes[0]] = u;
    at[f->axes[1]] = v;
    return sc_id_or_nearest(e->p->volume, at[0], at[1], at[2]);
}

/* Read where there is tissue in plane @p plane along the axis of a face, around the tile at @p low
 * (voxels along its axes). */
static void fetch_tissue(const ends *e, const face *f, int plane, const int low[2], tile_work *w)
{
    for (int j = 0; j < SIDE; j++) {
        for (int i = 0; i < SIDE; i++)
            w->tissue[j][i] =
                id_in_plane(e, f, plane, low[0] - MARGIN + i, low[1] - MARGIN + j) != 0;
    }
}

/* Write the distance from each place of a window to the nearest one with @p kind (1: tissue, 0:
 * background) to @p out, in voxels, REACH at most: first the square of that along the rows, then
 * the least over the columns. */
static void find_distances(const face *f, const tile_work *w, int kind, window scratch, window out)
{
    for (int j = 0; j < SIDE; j++) {
        float near = REACH;

        for (int i = 0; i < SIDE; i++) {
            near = w->tissue[j][i] == kind ? 0 : fminf(near + f->length[0], REACH);
            scratch[j][i] = near;
        }
        for (int i = SIDE - 1; i >= 0; i--) {
            near = fminf(near + f->length[0], scratch[j][i]);
            scratch[j][i] = near;
        }
        for (int i = 0; i < SIDE; i++)
            scratch[j][i] *= scratch[j][i];
    }
    for (int j = 0; j < SIDE; j++) {
        for (int i = 0; i < SIDE; i++)
            out[j][i] = REACH * REACH;
        for (int k = -REACH; k <= REACH; k++) {
            const float apart = (float)k * f->length[1] * (float)k * f->length[1];

            if (j + k < 0 || j + k >= SIDE)
                continue;
            for (int i = 0; i < SIDE; i++)
                out[j][i] = fminf(out[j][i], scratch[j + k][i] + apart);
        }
        for (int i = 0; i < SIDE; i++)
            out[j][i] = sqrtf(out[j][i]);
    }
}

/* Smooth a window by binomial weights along both axes, but for its outermost places. */
static void blur(window values, window scratch)
{
    memcpy(scratch, values, sizeof(window));
    for (int j = 0; j < SIDE; j++) {
        for (int i = BLUR; i < SIDE - BLUR; i++)
            scratch[j][i] = (values[j][i - 2] + values[j][i + 2]) * 0.0625f +
                            (values[j][i - 1] + values[j][i + 1]) * 0.25f + values[j][i] * 0.375f;
    }
    for (int j = BLUR; j < SIDE - BLUR; j++) {
        for (int i = 0; i < SIDE; i++)
            values[j][i] = (scratch[j - 2][i] + scratch[j + 2][i]) * 0.0625f +
                           (scratch[j - 1][i] + scratch[j + 1][i]) * 0.25f + scratch[j][i] * 0.375f;
    }
}

/* Write the signed distances of the layer in w->tissue, positive in tissue, to @p out. The outline
 * is taken to lie half a voxel from the middles of voxels on its two sides. */
static void find_signed_distances(const face *f, tile_work *w, window out)
{
    find_distances(f, w, 1, w->scratch, out);
    find_distances(f, w, 0, w->scratch, w->inside);
    for (int j = 0; j < SIDE; j++) {
        for (int i = 0; i < SIDE; i++)
            out[j][i] = w->tissue[j][i] ? w->inside[j][i] - 0.5f : 0.5f - out[j][i];
    }
    blur(out, w->scratch);
}

/* How the tissue ends at a place of a window. */
typedef struct ending {
    float share; /* 0: it does not, and nothing else is set; 1: it does */
    float fall;  /* by how much the signed distance falls from the last layer to the border, if it
                    fell on as it does at its outline: for each layer, in voxels */
} ending;

/* @return how the tissue ends at a place. @param middle the distance in the middle of its disc. */
static ending find_ending(const tile_work *w, int i, int j, float middle)
{
    const float depth = w->last[j][i], moves = w->before[j][i] - depth;
    ending found = {.share = (moves - MOVES_FROM) / (MOVES_ALL - MOVES_FROM)};

    found.share = found.share < 0 ? 0 : found.share > 1 ? 1 : found.share;
    if (found.share == 0)
        return found;
    middle = fmaxf(middle, DEPTH_LEAST);
    found.fall = moves * (2 * middle + moves) / (2 * middle - fminf(depth, middle));
    return found;
}

/* @return at what height above the last layer, in layers, the tissue ends at a place of the window
 * that is tissue there; 0.5 or more: not before the border. */
static float height_of_end(const tile_work *w, int i, int j, const ending *at)
{
    return 0.5f + at->share * (fmaxf(w->last[j][i], DEPTH_LEAST) / at->fall - 0.5f);
}

/* Find the record of a vertex of the label grid. @return false if it has none. */
static bool find_record(const sc_preparation *p, const int vertex[3], size_t *index)
{
    const size_t brick = sc_brick_index(p->bricks, sc_brick_of(vertex[0]), sc_brick_of(vertex[1]),
                                        sc_brick_of(vertex[2]));
    const int bit = sc_brick_bit(vertex[0], vertex[1], vertex[2]);

    *index = p->near_start[brick] + sc_brick_rank(p->near[brick], bit);
    return p->near[brick] >> bit & 1;
}

/* Find the record of the vertex @p across along the axis of a face, in line with the voxel at @p at
 * of the face. @return false if it has none. */
static bool find_record_at(const ends *e, const face *f, const int at[2], int across, size_t *index)
{
    int vertex[3];

    vertex[f->axis] = across;
    vertex[f->axes[0]] = at[0] + 1;
    vertex[f->axes[1]] = at[1] + 1;
    return find_record(e->p, vertex, index);
}

/* Note in the record of the vertex beyond a voxel of a face at what height its tissue ends. */
static void note_height(const ends *e, const face *f, const int at[2], float height)
{
    const int steps = (int)(height * SC_RECORD_END_STEPS + 0.5f);
    size_t index;

    if (height < 0.5f && find_record_at(e, f, at, f->beyond, &index))
        sc_record_write(e->p->records, index, sc_record_pack_end(steps < 1 ? 1 : steps));
}

/* Turn the direction in the record of a voxel of a face towards that of the surface in which the
 * tissue ends. The filters, which see copies of the last layer beyond it, take that for a wall. */
static void turn_record(const ends *e, const face *f, const tile_work *w, int i, int j,
                        const int at[2], const ending *found)
{
    const float slope[2] = {(w->last[j][i + 1] - w->last[j][i - 1]) / 2,
                            (w->last[j + 1][i] - w->last[j - 1][i]) / 2};
    const float side = w->tissue[j][i] ? 1 : -1; /* outward from the label of the voxel */
    float outward[3], before[3];
    sc_vec3 mixed;
    uint32_t record, turned;
    size_t index;

    if (!find_record_at(e, f, at, f->last + 1, &index))
        return;
    record = sc_record_read(e->p->records, index);
    outward[f->axis] = side * (f->beyond ? found->fall : -found->fall);
    outward[f->axes[0]] = -side * slope[0];
    outward[f->axes[1]] = -side * slope[1];
    turned = sc_field_record(e->to_mm, 1, outward);
    sc_record_octant(turned, outward);
    sc_record_octant(record, before);
    mixed = sc_vec3_add(sc_vec3_scale(sc_vec3_unit((sc_vec3){outward[0], outward[1], outward[2]}),
                                      (double)found->share),
                        sc_vec3_scale(sc_vec3_unit((sc_vec3){before[0], before[1], before[2]}),
                                      1 - (double)found->share));
    if (!(sc_vec3_length(mixed) > 1e-3))
        return;
    turned = sc_record_pack(1, mixed, 1);
    sc_record_write(e->p->records, index,
                    (record & ~(uint32_t)SC_RECORD_DIRECTION_BITS) |
                        (turned & (uint32_t)SC_RECORD_DIRECTION_BITS));
}

/* Measure the signed distances in both layers around the tile at @p low, voxels along the axes of
 * the face; w->tissue becomes that of the last layer. */
static void measure_tile(const ends *e, const face *f, const int low[2], tile_work *w)
{
    fetch_tissue(e, f, f->before, low, w);
    find_signed_distances(f, w, w->before);
    fetch_tissue(e, f, f->last, low, w);
    find_signed_distances(f, w, w->last);
}

/* ---- discs ---- */

/* @return the root of a place in the forest of @p parents: see number_discs. */
static int32_t find_root(int32_t *parents, int32_t at)
{
    while (parents[at] != at) {
        parents[at] = parents[parents[at]];
        at = parents[at];
    }
    return at;
}

/* Join two trees: the root that comes first becomes that of both. */
static void join(int32_t *parents, int32_t a, int32_t b)
{
    a = find_root(parents, a);
    b = find_root(parents, b);
    if (a < b)
        parents[b] = a;
    else
        parents[a] = b;
}

/* Number the discs of a face, of voxels of one label that share an edge: w->disc_of and
 * w->disc_count. Each voxel first points to another one of its disc, the first to itself;
 * background to -1. */
static void number_discs(face_work *w)
{
    const face *f = &w->face;
    const int width = f->size[0];
    const int32_t count = (int32_t)(width * f->size[1]);
    int32_t *parents = w->disc_of;

    for (int32_t at = 0; at < count; at++) {
        const int u = at % width, v = at / width;
        const uint32_t id = id_in_plane(w->e, f, f->last, u, v);

        parents[at] = id ? at : -1;
        if (id && u > 0 && id_in_plane(w->e, f, f->last, u - 1, v) == id)
            join(parents, at, at - 1);
        if (id && v > 0 && id_in_plane(w->e, f, f->last, u, v - 1) == id)
            join(parents, at, at - width);
    }
    /* What a voxel points to has its number by then. */
    for (int32_t at = 0; at < count; at++)
        parents[at] = parents[at] < 0     ? 0
                      : parents[at] == at ? ++w->disc_count
                                          : parents[parents[at]];
}

/* Measure the largest square that fits in each disc, whose lower right corner is each voxel in
 * turn: one more than the least of those of the three voxels before it. */
static void measure_squares(face_work *w)
{
    const int width = w->face.size[0];

    memset(w->squares, 0, (size_t)width * sizeof *w->squares);
    for (int v = 0; v < w->face.size[1]; v++) {
        const int32_t *row = w->disc_of + (size_t)v * (size_t)width;
        int32_t before = 0, above_before = 0;

        for (int u = 0; u < width; u++) {
            const int32_t above = w->squares[u];
            int32_t least = above < before ? above : before;

            least = above_before < least ? above_before : least;
            before = row[u] ? least + 1 : 0;
            above_before = above;
            w->squares[u] = before;
            if (before > w->discs[row[u]].square)
                w->discs[row[u]].square = before;
        }
    }
}

/* @return the number of a disc that ends at a place, or at most @p around voxels from it along both
 * axes; 0: there is none. */
static int32_t disc_near(const face_work *w, int u, int v, int around)
{
    const int *size = w->face.size;

    for (int j = v - around; j <= v + around; j++) {
        for (int i = u - around; i <= u + around; i++) {
            const int32_t number = i < 0 || j < 0 || i >= size[0] || j >= size[1]
                                       ? 0
                                       : w->disc_of[(size_t)j * (size_t)size[0] + (size_t)i];

            if (number && w->discs[number].ends)
                return number;
        }
    }
    return 0;
}

/* Is a disc that ends, or before decide_discs may end, in the tile at @p low or beside it? */
static bool is_tile_needed(const face_work *w, const int low[2])
{
    const int *size = w->face.size;

    for (int v = low[1] - BESIDE; v < low[1] + TILE + BESIDE && v < size[1]; v++) {
        for (int u = low[0] - BESIDE; u < low[0] + TILE + BESIDE && u < size[0]; u++) {
            if (u >= 0 && v >= 0 &&
                w->discs[w->disc_of[(size_t)v * (size_t)size[0] + (size_t)u]].ends)
                return true;
        }
    }
    return false;
}

/* Is there another disc beside a voxel of one? */
static bool touches_another(const face_work *w, int u, int v)
{
    const int width = w->face.size[0], height = w->face.size[1];
    const int32_t *at = w->disc_of + (size_t)v * (size_t)width + u;

    return (u > 0 && at[-1] && at[-1] != *at) || (u < width - 1 && at[1] && at[1] != *at) ||
           (v > 0 && at[-width] && at[-width] != *at) ||
           (v < height - 1 && at[width] && at[width] != *at);
}

/* Add what the discs of a tile, which has been measured, are like to w->discs. */
static void add_tile(face_work *w, const int low[2], const tile_work *t)
{
    const int *size = w->face.size;

    for (int j = MARGIN; j < MARGIN + TILE && low[1] + j - MARGIN < size[1]; j++) {
        for (int i = MARGIN; i < MARGIN + TILE && low[0] + i - MARGIN < size[0]; i++) {
            const int u = low[0] + i - MARGIN, v = low[1] + j - MARGIN;
            disc *d = &w->discs[w->disc_of[(size_t)v * (size_t)size[0] + (size_t)u]];

            if (!t->tissue[j][i])
                continue;
            d->depth = fmaxf(d->depth, t->last[j][i]);
            d->touching += touches_another(w, u, v);
            if (t->tissue[j][i - 1] && t->tissue[j][i + 1] && t->tissue[j - 1][i] &&
                t->tissue[j + 1][i])
                continue;
            d->outline++;
            d->moves += (double)(t->before[j][i] - t->last[j][i]);
        }
    }
}

/* Decide which of the discs that may end do: see the top of this file. */
static void decide_discs(face_work *w)
{
    for (int n = 1; n <= w->disc_count; n++) {
        disc *d = &w->discs[n];
        const float moves = d->outline ? (float)(d->moves / d->outline) : 0;

        d->ends = d->ends && moves > MOVES_FROM && TOUCHING_PART * d->touching <= d->outline &&
                  d->depth * d->depth <= MIDDLE_MAX * moves * (2 * d->depth + moves);
    }
}

/* Note the ends of a tile, which has been measured, in the records. */
static void note_tile(const face_work *w, const int low[2], const tile_work *t)
{
    const face *f = &w->face;

    for (int j = MARGIN; j < MARGIN + TILE && low[1] + j - MARGIN < f->size[1]; j++) {
        for (int i = MARGIN; i < MARGIN + TILE && low[0] + i - MARGIN < f->size[0]; i++) {
            const int at[2] = {low[0] + i - MARGIN, low[1] + j - MARGIN};
            const int32_t number = disc_near(w, at[0], at[1], t->tissue[j][i] ? 0 : BESIDE);
            ending found;

            if (!number || t->last[j][i] < -TURNED)
                continue;
            found = find_ending(t, i, j, w->discs[number].depth);
            if (found.share == 0)
                continue;
            if (t->tissue[j][i])
                note_height(w->e, f, at, height_of_end(t, i, j, &found));
            /* A voxel at the border of two faces belongs to both, and stays as it is. */
            if (at[0] > 0 && at[1] > 0 && at[0] < f->size[0] - 1 && at[1] < f->size[1] - 1)
                turn_record(w->e, f, t, i, j, at, &found);
        }
    }
}

/* Do each tile of a face in which a disc may end, or ends: add what its discs are like, or note
 * their ends. */
static void each_tile(face_work *w, bool note)
{
    tile_work t;
    int low[2];

    for (low[1] = 0; low[1] < w->face.size[1]; low[1] += TILE) {
        for (low[0] = 0; low[0] < w->face.size[0]; low[0] += TILE) {
            if (!is_tile_needed(w, low))
                continue;
            measure_tile(w->e, &w->face, low, &t);
            if (note)
                note_tile(w, low, &t);
            else
                add_tile(w, low, &t);
        }
    }
}

/* Do one face. */
static void do_face(face_work *w)
{
    number_discs(w);
    if (w->disc_count > DISCS_MAX)
        return;
    memset(w->discs, 0, ((size_t)w->disc_count + 1) * sizeof *w->discs);
    measure_squares(w);
    for (int n = 1; n <= w->disc_count; n++)
        w->discs[n].ends = w->discs[n].square <= 2 * REACH;
    each_tile(w, false);
    decide_discs(w);
    each_tile(w, true);
}

/* Do faces [begin, end); an sc_range_fn on face_work [FACES]. */
static void do_faces(void *user, size_t begin, size_t end, int thread)
{
    face_work *works = user;

    (void)thread;
    for (size_t n = begin; n < end; n++) {
        if (works[n].discs)
            do_face(&works[n]);
    }
}

/* Note the end of a vertex that lies outside of the volume along more than one axis: the lowest of
 * those of the vertices beside it that do along one, as if these went straight on. */
static void note_corner(const ends *e, const int vertex[3])
{
    const sc_preparation *p = e->p;
    int lowest = SC_RECORD_END_MAX + 1;
    size_t index;

    for (int axis = 0; axis < 3; axis++) {
        int beside[3], height = 0;

        for (int i = 0; i < 3; i++)
            beside[i] =
                i == axis ? vertex[i] : 1 + sc_nearest_voxel(vertex[i] - 1, p->volume->size[i]);
        if (vertex[axis] == 1 + sc_nearest_voxel(vertex[axis] - 1, p->volume->size[axis]))
            continue;
        if (find_record(p, beside, &index))
            height = sc_record_end(sc_record_read(p->records, index));
        lowest = height && height < lowest ? height : lowest;
    }
    if (lowest <= SC_RECORD_END_MAX && find_record(p, vertex, &index))
        sc_record_write(p->records, index, sc_record_pack_end(lowest));
}

/* Do the vertices beyond the edges and corners of the volume; an sc_range_fn on ends, for one item.
 */
static void do_edges(void *user, size_t begin, size_t end, int thread)
{
    const ends *e = user;
    const int *size = e->p->volume->size;

    (void)begin;
    (void)end;
    (void)thread;
    for (int axis = 0; axis < 3; axis++) {
        const int a = (axis + 1) % 3, b = (axis + 2) % 3;
        int vertex[3];

        for (int n = 0; n < 4; n++) {
            vertex[a] = n & 1 ? size[a] + 1 : 0;
            vertex[b] = n & 2 ? size[b] + 1 : 0;
            for (vertex[axis] = 0; vertex[axis] <= size[axis] + 1; vertex[axis]++)
                note_corner(e, vertex);
        }
    }
}

/* Prepare the work on face number @p n of the volume: set the face, and allocate the arrays.
 * @return SC_ERR_MEMORY. */
static sc_status make_work(const sc_ctx *ctx, const ends *e, int n, face_work *w)
{
    const int *size = w->face.size;
    void *block;
    sc_status status = SC_OK;

    w->e = e;
    set_face(e->p, n / 2, n % 2, &w->face);
    if (size[0] == 0 || size[1] > INT32_MAX / size[0])
        return SC_OK;
    SC_TRY(sc_alloc(ctx, (size_t)size[0] * (size_t)size[1], sizeof *w->disc_of, &block));
    w->disc_of = block;
    SC_TRY(sc_alloc(ctx, (size_t)size[0], sizeof *w->squares, &block));
    w->squares = block;
    SC_TRY(sc_alloc(ctx, DISCS_MAX + 1, sizeof *w->discs, &block));
    w->discs = block;
out:
    return status;
}

sc_status sc_find_ends(const sc_ctx *ctx, sc_preparation *p)
{
    face_work works[FACES] = {{0}};
    ends e = {.p = p};
    sc_status status = SC_OK;

    if (!sc_is_smoothed(p))
        return SC_OK;
    sc_gradient_to_mm(p->volume, (const double[3]){1, 1, 1}, e.to_mm);
    for (int n = 0; n < FACES && status == SC_OK; n++)
        status = make_work(ctx, &e, n, &works[n]);
    SC_TRY(sc_team_agree(p->team, status));
    sc_team_stage_for(ctx, SC_WORTH_ENDS, p->team, FACES, 1, do_faces, works);
    sc_team_for(p->team, 1, 1, do_edges, &e);
out:
    for (int n = 0; n < FACES; n++) {
        sc_free(works[n].disc_of);
        sc_free(works[n].squares);
        sc_free(works[n].discs);
    }
    return status;
}
