/* SPDX-License-Identifier: BSD-3-Clause */
/* Surfaces as tiles: of what is drawn, of the faces of voxels, and of meshes. */
#include "against.h"

#include <stdlib.h>
#include <string.h>

enum {
    LINES = 400000,
    CHUNK = 1000, /* lines that a thread does at a time */
    HALVINGS = 12
};

/* A line through a volume: the point at t mm is eye + t direction. */
typedef struct line {
    const stage *st;
    sc_vec3 eye, direction;
} line;

/* The label that owns the point of the line at @p t mm. */
static int owner_on(const line *l, double t)
{
    return owner_at(l->st, sc_vec3_along(l->eye, t, l->direction));
}

/* A point where the owner changes: between @p low, which @p left owns, and @p high, which another
 * label owns. On return they are so close that it does not matter which. */
static void close_in(const line *l, int left, double *low, double *high)
{
    for (int i = 0; i < HALVINGS; i++) {
        const double middle = (*low + *high) / 2;

        *(owner_on(l, middle) == left ? low : high) = middle;
    }
}

/* Lists of tiles for each tissue, and what the worker find_crossings needs. */
typedef struct search {
    const stage *st;
    const int *tissue_of;
    double step_mm; /* between looks at the owner: half the least edge of a voxel */
    double tile_mm; /* half the edge of a tile */
    struct found {
        tiles pieces;
        int *tissues; /* [pieces.capacity]: of each piece */
        size_t capacity;
    } * chunks; /* [LINES / CHUNK] */
} search;

/* Add a tile of the surface of the tissue @p owner to a chunk; nothing for a negative one. */
static void add_found(struct found *f, int owner, const tile *piece)
{
    if (owner < 0)
        return;
    tiles_add(&f->pieces, piece);
    if (f->capacity < f->pieces.capacity) {
        f->capacity = f->pieces.capacity;
        f->tissues = realloc(f->tissues, f->capacity * sizeof *f->tissues);
        if (!f->tissues)
            abort();
    }
    f->tissues[f->pieces.count - 1] = owner;
}

/* A square tile about @p middle that is perpendicular to @p normal; a point if that is 0. */
static tile square(sc_vec3 middle, sc_vec3 normal, double half_edge)
{
    const sc_vec3 unit = sc_vec3_unit(normal);
    tile t = {.middle = {(float)middle.x, (float)middle.y, (float)middle.z}};

    if (sc_vec3_length(unit) > 0.5) {
        const sc_vec3 a = sc_vec3_scale(sc_vec3_perpendicular(unit), half_edge);
        const sc_vec3 b = sc_vec3_cross(unit, a);

        memcpy(t.a, (float[3]){(float)a.x, (float)a.y, (float)a.z}, sizeof t.a);
        memcpy(t.b, (float[3]){(float)b.x, (float)b.y, (float)b.z}, sizeof t.b);
    }
    return t;
}

/* The normal, of any length and sign, of the surface that the line meets at @p t, where it leaves
 * what @p left owns: from where two lines close to it on either side meet the surface. 0 where
 * they do not. */
static sc_vec3 normal_at(const search *s, const line *l, double t, int left)
{
    const double aside = 0.2 * s->step_mm;
    const sc_vec3 u = sc_vec3_perpendicular(l->direction), v = sc_vec3_cross(l->direction, u);
    const sc_vec3 sides[2] = {u, v};
    sc_vec3 ways[2];

    for (int k = 0; k < 2; k++) {
        const line beside = {l->st, sc_vec3_along(l->eye, aside, sides[k]), l->direction};
        double low = t - 6 * aside, high = t + 6 * aside;

        if (owner_on(&beside, low) != left || owner_on(&beside, high) == left)
            return (sc_vec3){0};
        close_in(&beside, left, &low, &high);
        ways[k] = sc_vec3_along(sc_vec3_scale(sides[k], aside), low - t, l->direction);
    }
    return sc_vec3_cross(ways[0], ways[1]);
}

bool is_uniform(const stage *st, sc_vec3 p)
{
    const int x = (int)floor(p.x) + 1, y = (int)floor(p.y) + 1, z = (int)floor(p.z) + 1;
    const int *size = st->volume.size;
    sc_vertex lowest;

    if (x < 0 || y < 0 || z < 0 || x > size[0] || y > size[1] || z > size[2])
        return true;
    lowest = sc_vertex_at(&st->volume, x, y, z);
    return !lowest.outer && !lowest.inner && !sc_is_near(&st->volume, x, y, z);
}

/* Add all changes of owner along a line to @p f. */
static void walk(const search *s, const line *l, struct found *f)
{
    const sc_vec3 o = sc_affine_point(&l->st->to_voxel, l->eye);
    const sc_vec3 d = sc_affine_vector(&l->st->to_voxel, l->direction);
    const int *size = l->st->volume.size;
    const sc_box3 box = {{-1, -1, -1}, {size[0], size[1], size[2]}};
    double before = 0, end = 2 * l->st->reach_mm;
    bool was_uniform = true;
    int owner = 0;

    if (!sc_box3_clip_line(&box, o, d, &before, &end))
        return;
    for (double t = before; t < end + s->step_mm; t += s->step_mm) {
        const bool uniform = is_uniform(l->st, sc_vec3_along(o, t, d));
        const int here = uniform && was_uniform ? owner : owner_on(l, t);

        while (here != owner && owner_on(l, before) == owner) {
            double low = before, high = t;
            tile piece;

            close_in(l, owner, &low, &high);
            piece = square(sc_vec3_along(l->eye, low, l->direction), normal_at(s, l, low, owner),
                           s->tile_mm);
            add_found(f, s->tissue_of[owner], &piece);
            owner = owner_on(l, high);
            add_found(f, s->tissue_of[owner], &piece);
            before = high;
        }
        owner = here;
        was_uniform = uniform;
        before = t;
    }
}

/* Worker of sc_parallel_for: look along the lines of chunks [@p begin, @p end). @p user: a search.
 */
static void find_crossings(void *user, size_t begin, size_t end, int thread)
{
    const search *s = user;

    for (size_t n = begin; n < end; n++) {
        uint64_t seed = 104729 * (n + 1);

        for (int i = 0; i < CHUNK; i++) {
            line l = {.st = s->st};

            l.direction = random_line(s->st, &seed, &l.eye);
            walk(s, &l, &s->chunks[n]);
        }
    }
}

/* The shortest edge of a voxel in mm. */
static double least_edge(const sc_affine *to_ras_mm)
{
    double least = HUGE_VAL;

    for (int i = 0; i < 3; i++)
        least = fmin(least, sc_vec3_length(sc_affine_column(to_ras_mm, i)));
    return least;
}

sc_status add_drawn(const sc_ctx *ctx, const stage *st, const int *tissue_of, int threads,
                    tiles **out)
{
    /* Random lines through a ball meet a surface LINES / (2 pi reach^2) times in each mm2. */
    const double for_each_mm2 = LINES / (2 * M_PI * st->reach_mm * st->reach_mm);
    const size_t chunks = LINES / CHUNK;
    search s = {.st = st,
                .tissue_of = tissue_of,
                .step_mm = least_edge(&st->volume.to_ras_mm) / 2,
                .tile_mm = 1 / sqrt(for_each_mm2)};
    void *block;
    sc_status status;

    SC_TRY(sc_zalloc(ctx, chunks, sizeof *s.chunks, &block));
    s.chunks = block;
    sc_parallel_for(threads, chunks, 1, find_crossings, &s);
    for (size_t n = 0; n < chunks; n++) {
        for (size_t i = 0; i < s.chunks[n].pieces.count; i++)
            tiles_add(out[s.chunks[n].tissues[i]], &s.chunks[n].pieces.list[i]);
        tiles_free(&s.chunks[n].pieces);
        free(s.chunks[n].tissues);
    }
    sc_free(block);
out:
    return status;
}

/* Add the face of the voxel (@p x, @p y, @p z) towards the next one along @p axis, if it parts two
 * labels. */
static void add_face(const sc_volume *v, const int *tissue_of, const int at[3], int axis,
                     tiles **out)
{
    const sc_affine *m = &v->to_ras_mm;
    const int ids[2] = {id_at(v, at[0], at[1], at[2]),
                        id_at(v, at[0] + (axis == 0), at[1] + (axis == 1), at[2] + (axis == 2))};
    sc_vec3 p;
    tile face;

    if (ids[0] == ids[1])
        return;
    p = sc_affine_point(m, (sc_vec3){at[0] + 0.5 * (axis == 0), at[1] + 0.5 * (axis == 1),
                                     at[2] + 0.5 * (axis == 2)});
    memcpy(face.middle, (float[3]){(float)p.x, (float)p.y, (float)p.z}, sizeof face.middle);
    for (int i = 0; i < 3; i++) {
        face.a[i] = (float)(m->m[i][(axis + 1) % 3] / 2);
        face.b[i] = (float)(m->m[i][(axis + 2) % 3] / 2);
    }
    for (int k = 0; k < 2; k++) {
        if (tissue_of[ids[k]] >= 0)
            tiles_add(out[tissue_of[ids[k]]], &face);
    }
}

void add_faces(const sc_volume *v, const int *tissue_of, tiles **out)
{
    for (int z = -1; z < v->size[2]; z++) {
        for (int y = -1; y < v->size[1]; y++) {
            for (int x = -1; x < v->size[0]; x++) {
                for (int axis = 0; axis < 3; axis++)
                    add_face(v, tissue_of, (const int[3]){x, y, z}, axis, out);
            }
        }
    }
}

/* Add @p count tiles of a triangle, at random points of it, to @p out. */
static void tile_triangle(const mesh *m, const uint32_t corners[3], int count, double half_edge,
                          uint64_t *seed, tiles *out)
{
    const sc_vec3 a = m->vertices[corners[0]];
    const sc_vec3 ab = sc_vec3_sub(m->vertices[corners[1]], a);
    const sc_vec3 ac = sc_vec3_sub(m->vertices[corners[2]], a);
    const sc_vec3 normal = sc_vec3_cross(ab, ac);

    for (int i = 0; i < count; i++) {
        double u = random_of(seed), v = random_of(seed);
        tile piece;

        if (u + v > 1) {
            u = 1 - u;
            v = 1 - v;
        }
        piece = square(sc_vec3_along(sc_vec3_along(a, u, ab), v, ac), normal, half_edge);
        tiles_add(out, &piece);
    }
}

void add_mesh(const mesh *m, tiles *out)
{
    const double for_each_mm2 = 10;
    uint64_t seed = 41;
    double due = 0;

    for (size_t i = 0; i < m->triangle_count; i++) {
        const uint32_t *t = m->triangles[i];
        const sc_vec3 a = m->vertices[t[0]];
        const sc_vec3 cross =
            sc_vec3_cross(sc_vec3_sub(m->vertices[t[1]], a), sc_vec3_sub(m->vertices[t[2]], a));

        due += for_each_mm2 * sc_vec3_length(cross) / 2;
        tile_triangle(m, t, (int)due, 1 / sqrt(for_each_mm2), &seed, out);
        due -= floor(due);
    }
}
