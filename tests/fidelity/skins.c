/* SPDX-License-Identifier: BSD-3-Clause */
/* Closed skins, one voxel thick, round two tissues, and how many rays get through them. */
#include "fidelity.h"

#include <string.h>

enum { BATCH = 512, HALF_MM = 56, TISSUES = 2, SKIN = 3, BALLS = 6, PLANES = 9 };

/* Share of half a volume's diagonal that a ball round the bodies has as its radius. */
#define REACH 0.55

/* A random point of the cube from -1 to 1. */
static sc_vec3 random_point(uint64_t *seed)
{
    const double x = random_of(seed), y = random_of(seed), z = random_of(seed);

    return (sc_vec3){2 * x - 1, 2 * y - 1, 2 * z - 1};
}

/* The functions from here to rough() are about bodies within a ball of radius 50 about the origin:
 * below 0 inside of the body that @p seed chooses, about the distance from its surface near it.
 * @p scale: how many mm one of its units is long; @p p is in those units. */

/* An ellipsoid with radii of 46, 34 and 40, turned at random. */
static double ellipsoid(uint64_t seed, double scale, sc_vec3 p)
{
    const sc_vec3 axis = random_direction(&seed);
    const sc_vec3 q = sc_vec3_rotate(p, axis, 2 * M_PI * random_of(&seed));

    return 40 * (sc_vec3_length((sc_vec3){q.x / 46, q.y / 34, q.z / 40}) - 1);
}

/* Balls of different sizes, which overlap. */
static double balls(uint64_t seed, double scale, sc_vec3 p)
{
    double least = HUGE_VAL;

    for (int n = 0; n < BALLS; n++) {
        const sc_vec3 middle = sc_vec3_scale(random_point(&seed), 17);
        const double radius = 8 + 12 * random_of(&seed);

        least = fmin(least, sc_vec3_length(sc_vec3_sub(p, middle)) - radius);
    }
    return least;
}

/* A ball that planes of any tilt have cut off. */
static double cut_by_planes(uint64_t seed, double scale, sc_vec3 p)
{
    double most = sc_vec3_length(p) - 48;

    for (int n = 0; n < PLANES; n++) {
        const sc_vec3 normal = random_direction(&seed);

        most = fmax(most, sc_vec3_dot(p, normal) - 20 - 18 * random_of(&seed));
    }
    return most;
}

/* A random number from 0 to 1 that belongs to the point (@p x, @p y, @p z) of a lattice. */
static double noise_at(uint64_t seed, int x, int y, int z)
{
    uint64_t state =
        seed ^ (uint64_t)(x + 4096) << 40 ^ (uint64_t)(y + 4096) << 20 ^ (uint64_t)(z + 4096);

    return random_of(&state);
}

/* A ball roughened by noise: bumps 5 mm wide, interpolated between the points of a lattice. */
static double rough(uint64_t seed, double scale, sc_vec3 p)
{
    const sc_vec3 q = sc_vec3_scale(p, scale / 5);
    const int x = (int)floor(q.x), y = (int)floor(q.y), z = (int)floor(q.z);
    double noise = 0;

    for (int n = 0; n < 8; n++) {
        const int i = n & 1, j = n >> 1 & 1, k = n >> 2;

        noise += noise_at(seed, x + i, y + j, z + k) * fabs(q.x - x - 1 + i) *
                 fabs(q.y - y - 1 + j) * fabs(q.z - z - 1 + k);
    }
    return sc_vec3_length(p) - 42 + 10 * noise / scale;
}

/* Voxels that are cubes, and voxels six times as high as wide. */
#define CUBES .spacing = {1, 1, 1}, .scale = 1
#define SLICES .spacing = {1, 2.7, 6.4}, .scale = 2

const skin skins[] = {{.name = "skin-ellipsoid", .distance = ellipsoid, CUBES},
                      {.name = "skin-balls", .distance = balls, CUBES},
                      {.name = "skin-planes", .distance = cut_by_planes, CUBES},
                      {.name = "skin-rough", .distance = rough, .ragged = true, CUBES},
                      {.name = "skin-ellipsoid-slices", .distance = ellipsoid, SLICES},
                      {.name = "skin-balls-slices", .distance = balls, SLICES},
                      {.name = "skin-planes-slices", .distance = cut_by_planes, SLICES},
                      {.name = "skin-rough-slices", .distance = rough, .ragged = true, SLICES}};
const size_t skin_count = SC_COUNT_OF(skins);

const skin *skin_find(const char *name)
{
    for (size_t i = 0; i < skin_count; i++) {
        if (!strcmp(skins[i].name, name))
            return &skins[i];
    }
    return NULL;
}

/* Set the labels of @p v to those of the body of a skin: TISSUES inside, on either side of a wavy
 * plane, 0 outside. */
static void fill_body(const skin *k, uint64_t seed, sc_volume *v)
{
    uint64_t state = seed + 1, ragged = seed + 2;
    const sc_vec3 across = random_direction(&state);
    uint8_t *id = v->ids;

    for (int z = 0; z < v->size[2]; z++) {
        for (int y = 0; y < v->size[1]; y++) {
            for (int x = 0; x < v->size[0]; x++) {
                const sc_vec3 p =
                    sc_vec3_scale(sc_affine_point(&v->to_ras_mm, (sc_vec3){x, y, z}), 1 / k->scale);
                const double extra = k->ragged ? 1.2 * (random_of(&ragged) - 0.5) / k->scale : 0;
                const double side = sc_vec3_dot(p, across) + 4 * sin(p.x / 7) * cos(p.y / 5);

                *id++ = k->distance(seed, k->scale, p) + extra < 0 ? side < 0 ? 1 : TISSUES : 0;
            }
        }
    }
}

/* Does the voxel at @p at, which is not one of the outermost of its volume, share a face with one
 * that is set in @p is? */
static bool has_neighbour(const sc_volume *v, const uint8_t *is, size_t at)
{
    const size_t row = (size_t)v->size[0], layer = row * (size_t)v->size[1];

    return is[at - 1] || is[at + 1] || is[at - row] || is[at + row] || is[at - layer] ||
           is[at + layer];
}

/* Is the voxel at @p at one of the outermost of its volume? */
static bool is_outermost(const sc_volume *v, size_t at)
{
    const size_t row = (size_t)v->size[0], rows = (size_t)v->size[1];
    const size_t x = at % row, y = at / row % rows, z = at / (row * rows);

    return x == 0 || y == 0 || z == 0 || x + 1 == row || y + 1 == rows ||
           z + 1 == (size_t)v->size[2];
}

/* Turn the voxels of a body that share a face with the outside into skin; of a ragged one, half of
 * those skin voxels that then share no face with a tissue become outside again, as nothing needs
 * them. @p flags: room for two arrays of one byte for each voxel. */
static void add_skin(const skin *k, uint64_t seed, sc_volume *v, uint8_t *flags)
{
    const size_t voxels = sc_volume_voxels(v);
    uint8_t *ids = v->ids, *outside = flags, *inside = flags + voxels;
    uint64_t state = seed + 3;

    for (size_t at = 0; at < voxels; at++) {
        if (is_outermost(v, at))
            ids[at] = 0;
        outside[at] = !ids[at];
    }
    for (size_t at = 0; at < voxels; at++) {
        if (ids[at] && has_neighbour(v, outside, at))
            ids[at] = SKIN;
        inside[at] = ids[at] && ids[at] != SKIN;
    }
    for (size_t at = 0; at < voxels && k->ragged; at++) {
        if (ids[at] == SKIN && !has_neighbour(v, inside, at) && random_of(&state) < 0.5)
            ids[at] = 0;
    }
}

sc_status skin_volume(const sc_ctx *ctx, const skin *k, int variant, sc_volume *out)
{
    static const char *const names[] = {"", "one side", "other side", "skin"};
    const uint64_t seed = 1000 + 17 * (uint64_t)variant;
    SC_OWN(sc_volume_clear)
    sc_volume v = {.label_bytes = 1, .label_count = SKIN + 1, .oriented = true};
    SC_OWN(sc_free_at) uint8_t *flags = NULL;

    for (int i = 0; i < 3; i++) {
        v.size[i] = 2 * (int)(HALF_MM * k->scale / k->spacing[i]) + 1;
        v.to_ras_mm.m[i][i] = k->spacing[i];
        v.to_ras_mm.m[i][3] = -(v.size[i] / 2 + 0.23 * (i + 1)) * k->spacing[i];
    }
    SC_PASS(sc_alloc(ctx, sc_volume_voxels(&v), 1, &v.ids));
    SC_PASS(SC_ZALLOC(ctx, 2 * sc_volume_voxels(&v), &flags));
    SC_PASS(SC_ZALLOC(ctx, SKIN + 1, &v.labels));
    for (int id = 1; id <= SKIN; id++) {
        v.labels[id] = (sc_label){.value = id, .rgb = {200, (uint8_t)(60 * id), 60}, .opacity = -1};
        strcpy(v.labels[id].name, names[id]);
    }
    fill_body(k, seed, &v);
    add_skin(k, seed, &v, flags);
    SC_HAND_OVER(v, out);
    return SC_OK;
}

/* What a line passes through on its way from voxel to voxel. */
typedef enum way {
    WAY_NO_TISSUE,    /* background and skin alone */
    WAY_THROUGH_SKIN, /* another tissue, after a voxel of skin */
    WAY_BARE          /* another tissue, without skin before it: the skin is not closed there */
} way;

/* @return what the line from @p eye passes through, where @p id is the label of the skin. It goes
 * from voxel to voxel through their faces (Amanatides and Woo 1987). */
static way way_of(const stage *st, int id, sc_vec3 eye, sc_vec3 direction)
{
    const sc_vec3 o = sc_affine_point(&st->to_measured, eye);
    const sc_vec3 d = sc_affine_vector(&st->to_measured, direction);
    const int *size = st->voxels->size;
    const sc_box3 box = {{-0.5, -0.5, -0.5}, {size[0] - 0.5, size[1] - 0.5, size[2] - 0.5}};
    const double origin[3] = {o.x, o.y, o.z}, along[3] = {d.x, d.y, d.z};
    double begin = 0, end = 2 * st->reach_mm, next[3];
    int voxel[3];
    bool passed_skin = false;

    if (!sc_box3_clip_line(&box, o, d, &begin, &end))
        return WAY_NO_TISSUE;
    for (int i = 0; i < 3; i++) {
        const double at = origin[i] + begin * along[i];

        voxel[i] = (int)fmin(size[i] - 1, fmax(0, floor(at + 0.5)));
        next[i] = along[i] != 0 ? (voxel[i] + (along[i] > 0 ? 0.5 : -0.5) - origin[i]) / along[i]
                                : HUGE_VAL;
    }
    while (true) {
        const uint32_t here = (uint32_t)id_at(st->voxels, voxel[0], voxel[1], voxel[2]);
        const int axis = next[0] <= next[1] && next[0] <= next[2] ? 0 : next[1] <= next[2] ? 1 : 2;

        if (here && (int)here != id)
            return passed_skin ? WAY_THROUGH_SKIN : WAY_BARE;
        passed_skin = passed_skin || (int)here == id;
        if (next[axis] >= end)
            return WAY_NO_TISSUE;
        voxel[axis] += along[axis] > 0 ? 1 : -1;
        next[axis] += fabs(1 / along[axis]);
    }
}

/* What the worker leak_batches needs: the stage, the skin's dense id, and a place for what each
 * batch of rays has met. */
typedef struct leak_work {
    const stage *st;
    int id;
    leaks *batches;
} leak_work;

/* Worker of sc_parallel_for: march batches [@p begin, @p end) of BATCH rays. */
static void leak_batches(void *user, size_t begin, size_t end, int thread)
{
    const leak_work *w = user;

    for (size_t n = begin; n < end; n++) {
        uint64_t seed = 7919 * (n + 1);
        leaks *met = &w->batches[n];

        for (int i = 0; i < BATCH; i++) {
            sc_vec3 eye;
            const sc_vec3 direction = random_line(w->st, &seed, &eye);
            sc_march_counters counters = {0};
            sc_radiance light;
            const way through = way_of(w->st, w->id, eye, direction);
            sc_ray ray;

            if (through == WAY_BARE) {
                met->bare++;
                continue;
            }
            make_ray(w->st, eye, direction, &ray);
            w->st->kernel->march(&w->st->march, &ray, NULL, 1, &light, &counters);
            met->rays += through == WAY_THROUGH_SKIN;
            met->hits += light.label != 0;
            met->leaking += light.label != 0 && (int)light.label != w->id;
        }
    }
}

sc_status count_leaks(const sc_ctx *ctx, const sc_volume *volume, int id, const drawing *how,
                      double reach, size_t rays, leaks *out)
{
    const size_t batches = (rays + BATCH - 1) / BATCH;
    SC_OWN(stage_close) stage st = {0};
    leak_work w = {.st = &st, .id = id};
    SC_OWN(sc_free_at) void *block = NULL;

    SC_PASS(stage_open(ctx, volume, how, reach, 0.1, &st));
    SC_PASS(sc_zalloc(ctx, batches, sizeof *w.batches, &block));
    w.batches = block;
    sc_parallel_for(how->threads, batches, 8, leak_batches, &w);
    for (size_t n = 0; n < batches; n++) {
        out->bare += w.batches[n].bare;
        out->rays += w.batches[n].rays;
        out->hits += w.batches[n].hits;
        out->leaking += w.batches[n].leaking;
    }
    return SC_OK;
}

sc_status measure_skin(const sc_ctx *ctx, const skin *k, const drawing *how, size_t rays,
                       leaks *out)
{
    for (int n = 0; n < SKIN_VARIANTS; n++) {
        SC_OWN(sc_volume_clear) sc_volume volume = {0};

        SC_PASS(skin_volume(ctx, k, n, &volume));
        SC_PASS(count_leaks(ctx, &volume, SKIN, how, REACH, rays / SKIN_VARIANTS, out));
    }
    return SC_OK;
}
