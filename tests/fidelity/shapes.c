/* SPDX-License-Identifier: BSD-3-Clause */
/* The table of shapes, and the exact distances to their surfaces. */
#include "fidelity.h"

#include <string.h>

#define MAJOR 40.0 /* radius of the tori's middle line */

/* Members of a shape that is an ellipsoid, or a torus whose tube has the radius r. */
#define ELLIPSOID .volume = 4.0 / 3 * M_PI * 52 * 46 * 58
#define TORUS(r) .radius = (r), .volume = 2 * M_PI * M_PI * MAJOR * (r) * (r)
/* How a shape is voxelised: with voxels that are as high as wide; in slices six times as thick as
 * their voxels are wide; with voxels of 4 mm that are copied up, some of them flipped; with voxels
 * half as high again as wide. */
#define CUBES(n) .size = {n, n, n}, .slice_mm = 1, .copied = 1, .unit_mm = 1
#define SLICES .size = {144, 144, 24}, .slice_mm = 6, .copied = 1, .unit_mm = 1
#define COPIED(share)                                                                              \
    .size = {144, 144, 144}, .slice_mm = 1, .copied = 4, .flipped = (share), .unit_mm = 4
#define TALL .size = {144, 144, 96}, .slice_mm = 1.5, .copied = 1, .unit_mm = 1

static const double radii[3] = {52, 46, 58};

const shape shapes[] = {{.name = "ellipsoid", ELLIPSOID, CUBES(144)},
                        {.name = "torus-6", TORUS(6), CUBES(112)},
                        {.name = "torus-3", TORUS(3), CUBES(112)},
                        {.name = "torus-1.5", TORUS(1.5), CUBES(112)},
                        {.name = "torus-1", TORUS(1), CUBES(112)},
                        {.name = "ellipsoid-tall", ELLIPSOID, TALL},
                        {.name = "ellipsoid-slices", ELLIPSOID, SLICES},
                        {.name = "torus-18-slices", TORUS(18), SLICES},
                        {.name = "torus-12-slices", TORUS(12), SLICES},
                        {.name = "torus-6-slices", TORUS(6), SLICES},
                        {.name = "ellipsoid-copied", ELLIPSOID, COPIED(0)},
                        {.name = "torus-18-copied", TORUS(18), COPIED(0)},
                        {.name = "torus-12-copied", TORUS(12), COPIED(0)},
                        {.name = "torus-6-copied", TORUS(6), COPIED(0)},
                        {.name = "ellipsoid-noisy", ELLIPSOID, COPIED(0.1)},
                        {.name = "torus-18-noisy", TORUS(18), COPIED(0.1)},
                        {.name = "torus-12-noisy", TORUS(12), COPIED(0.1)}};
const size_t shape_count = SC_COUNT_OF(shapes);

const shape *shape_find(const char *name)
{
    for (size_t i = 0; i < shape_count; i++) {
        if (!strcmp(shapes[i].name, name))
            return &shapes[i];
    }
    return NULL;
}

/* Turn a vector from the axes of a shape to those of its volume (@p sign 1) or back (-1). Shapes
 * are tilted about all axes and off the grid, so that no symmetry makes errors look small. */
static sc_vec3 tilt(sc_vec3 v, double sign)
{
    const sc_vec3 axis = sc_vec3_unit((sc_vec3){0.43, -0.61, 0.37});

    return sc_vec3_rotate(v, axis, sign * 0.83);
}

/* The middle of a shape, in mm: that of its volume, moved by odd parts of a voxel. */
static sc_vec3 middle_of(const shape *s)
{
    const double along = (s->size[2] - 1) / 2.0 * s->slice_mm;

    return (sc_vec3){(s->size[0] - 1) / 2.0 - 0.2 * s->copied,
                     (s->size[1] - 1) / 2.0 + 0.63 * s->copied,
                     along + 0.21 * s->copied * s->slice_mm};
}

/* Signed distance of @p p, in the axes of the shape, to the ellipsoid, negative inside, and its
 * outward unit normal to @p normal: the foot point by Newton's method on the multiplier t of
 * foot = p a^2 / (a^2 + t). */
static double ellipsoid(sc_vec3 p, sc_vec3 *normal)
{
    const double a[3] = {radii[0] * radii[0], radii[1] * radii[1], radii[2] * radii[2]};
    const double q[3] = {p.x, p.y, p.z};
    double t = 0, foot[3];

    for (int i = 0; i < 30; i++) {
        const double before = t;
        double value = -1, slope = 0;

        for (int k = 0; k < 3; k++) {
            const double f = q[k] / (a[k] + t);

            value += a[k] * f * f;
            slope -= 2 * a[k] * f * f / (a[k] + t);
        }
        t -= value / (slope < 0 ? slope : -1e-12);
        t = fmax(t, -0.9 * radii[1] * radii[1]);
        if (fabs(t - before) < 1e-9) /* mm^2: of a distance, less than 1e-11 mm */
            break;
    }
    for (int k = 0; k < 3; k++)
        foot[k] = q[k] * a[k] / (a[k] + t);
    *normal = sc_vec3_unit((sc_vec3){foot[0] / a[0], foot[1] / a[1], foot[2] / a[2]});
    return sc_vec3_dot(sc_vec3_sub(p, (sc_vec3){foot[0], foot[1], foot[2]}), *normal);
}

/* Signed distance of @p p, in the axes of the shape, to a torus whose tube has the given radius,
 * negative inside, and its outward unit normal to @p normal. */
static double torus(double radius, sc_vec3 p, sc_vec3 *normal)
{
    const double across = hypot(p.x, p.y);
    const sc_vec3 line = across > 0 ? (sc_vec3){p.x / across * MAJOR, p.y / across * MAJOR, 0}
                                    : (sc_vec3){MAJOR, 0, 0};
    const sc_vec3 off = sc_vec3_sub(p, line);

    *normal = sc_vec3_unit(off);
    return sc_vec3_length(off) - radius;
}

double shape_distance(const shape *s, sc_vec3 p, sc_vec3 *normal)
{
    double distance;
    sc_vec3 n;

    p = tilt(sc_vec3_sub(p, middle_of(s)), -1);
    distance = s->radius > 0 ? torus(s->radius, p, &n) : ellipsoid(p, &n);
    *normal = tilt(n, 1);
    return distance / s->unit_mm;
}

sc_vec3 shape_middle(const shape *s, double u)
{
    const sc_vec3 p = {MAJOR * cos(2 * M_PI * u), MAJOR * sin(2 * M_PI * u), 0};

    return sc_vec3_add(tilt(p, 1), middle_of(s));
}

/* Worker of sc_parallel_for: set the labels of layers [@p begin, @p end) along z of a volume that
 * is to be copied up, or of one that is not. @p user: two pointers, to the volume and to the
 * shape. */
static void fill_layers(void *user, size_t begin, size_t end, int thread)
{
    sc_volume *v = ((void **)user)[0];
    const shape *s = ((void **)user)[1];
    const double offset = (s->copied - 1) / 2.0; /* of the middle of a voxel from its corner's */
    uint8_t *ids = v->ids;

    for (size_t z = begin; z < end; z++) {
        for (int y = 0; y < v->size[1]; y++) {
            for (int x = 0; x < v->size[0]; x++) {
                const sc_vec3 p = {x * s->copied + offset, y * s->copied + offset,
                                   (double)z * s->copied * s->slice_mm + offset};
                sc_vec3 normal;
                const size_t at =
                    (z * (size_t)v->size[1] + (size_t)y) * (size_t)v->size[0] + (size_t)x;

                ids[at] = shape_distance(s, p, &normal) < 0;
            }
        }
    }
}

/* Does the voxel (@p x, @p y, @p z) share a face with one of the other label? */
static bool is_at_border(const sc_volume *v, int x, int y, int z)
{
    const uint8_t *ids = v->ids;
    const size_t row = (size_t)v->size[0], layer = row * (size_t)v->size[1];
    const uint8_t own = ids[(size_t)z * layer + (size_t)y * row + (size_t)x];

    for (int n = 0; n < 6; n++) {
        const int side = n % 2 ? 1 : -1;
        const int i = x + side * (n / 2 == 0), j = y + side * (n / 2 == 1);
        const int k = z + side * (n / 2 == 2);

        if (i < 0 || j < 0 || k < 0 || i >= v->size[0] || j >= v->size[1] || k >= v->size[2])
            continue;
        if (ids[(size_t)k * layer + (size_t)j * row + (size_t)i] != own)
            return true;
    }
    return false;
}

sc_status flip_voxels(const sc_ctx *ctx, sc_volume *v, double share)
{
    SC_OWN(sc_free_at) uint8_t *flip = NULL;
    uint8_t *ids = v->ids;
    uint64_t seed = 31;
    size_t at = 0;

    SC_PASS(SC_ZALLOC(ctx, sc_volume_voxels(v), &flip));
    for (int z = 0; z < v->size[2]; z++) {
        for (int y = 0; y < v->size[1]; y++) {
            for (int x = 0; x < v->size[0]; x++, at++)
                flip[at] = is_at_border(v, x, y, z) && random_of(&seed) < share;
        }
    }
    for (size_t i = 0; i < at; i++)
        ids[i] ^= flip[i];
    return SC_OK;
}

/* Set the labels of @p v to those of @p coarse, each of whose voxels becomes @p copied of them
 * along each axis. */
static void copy_up(const sc_volume *coarse, int copied, sc_volume *v)
{
    const uint8_t *from = coarse->ids;
    uint8_t *to = v->ids;

    for (int z = 0; z < v->size[2]; z++) {
        for (int y = 0; y < v->size[1]; y++) {
            const int row = (z / copied * coarse->size[1] + y / copied) * coarse->size[0];

            for (int x = 0; x < v->size[0]; x++)
                *to++ = from[row + x / copied];
        }
    }
}

sc_status shape_volume(const sc_ctx *ctx, const shape *s, int threads, sc_volume *out)
{
    SC_OWN(sc_volume_clear) sc_volume v = {.label_bytes = 1, .label_count = 2, .oriented = true};
    SC_OWN(sc_volume_clear) sc_volume coarse = {.label_bytes = 1};
    void *user[2] = {&coarse, (void *)(uintptr_t)s};

    memcpy(v.size, s->size, sizeof v.size);
    for (int i = 0; i < 3; i++)
        coarse.size[i] = s->size[i] / s->copied;
    SC_PASS(sc_alloc(ctx, sc_volume_voxels(&v), 1, &v.ids));
    SC_PASS(sc_alloc(ctx, sc_volume_voxels(&coarse), 1, &coarse.ids));
    SC_PASS(SC_ZALLOC(ctx, 2, &v.labels));
    v.labels[1] = (sc_label){.value = 1, .rgb = {200, 80, 60}, .opacity = -1};
    strcpy(v.labels[1].name, s->name);
    for (int i = 0; i < 3; i++)
        v.to_ras_mm.m[i][i] = i == 2 ? s->slice_mm : 1;
    sc_parallel_for(threads, (size_t)coarse.size[2], 1, fill_layers, user);
    if (s->flipped > 0)
        SC_PASS(flip_voxels(ctx, &coarse, s->flipped));
    copy_up(&coarse, s->copied, &v);
    SC_HAND_OVER(v, out);
    return SC_OK;
}
