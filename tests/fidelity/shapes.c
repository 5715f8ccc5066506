/* SPDX-License-Identifier: BSD-3-Clause */
/* The table of shapes, and the exact distances to their surfaces. */
#include "fidelity.h"

#include <string.h>

#define MAJOR 40.0 /* radius of the tori's middle line */

#define TORUS(label, r)                                                                            \
    {                                                                                              \
        .name = label, .size = {112, 112, 112}, .radius = r,                                       \
        .volume = 2 * M_PI * M_PI * MAJOR * (r) * (r), .voxel_mm = 1                               \
    }

static const double radii[3] = {52, 46, 58};

const shape shapes[] = {
    {.name = "ellipsoid",
     .size = {144, 144, 144},
     .volume = 4.0 / 3 * M_PI * 52 * 46 * 58,
     .voxel_mm = 1},
    TORUS("torus-6", 6.0),
    TORUS("torus-3", 3.0),
    TORUS("torus-1.5", 1.5),
    TORUS("torus-1", 1.0),
    {.name = "phantom", .size = {SC_PHANTOM_WIDTH, SC_PHANTOM_DEPTH, SC_PHANTOM_HEIGHT}}};
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

/* The middle of a shape, in mm. */
static sc_vec3 middle_of(const shape *s)
{
    return (sc_vec3){s->size[0] / 2 - 0.7, s->size[1] / 2 + 0.13, s->size[2] / 2 - 0.29};
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
        double value = -1, slope = 0;

        for (int k = 0; k < 3; k++) {
            const double f = q[k] / (a[k] + t);

            value += a[k] * f * f;
            slope -= 2 * a[k] * f * f / (a[k] + t);
        }
        t -= value / (slope < 0 ? slope : -1e-12);
        t = fmax(t, -0.9 * radii[1] * radii[1]);
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

double shape_distance(const shape *s, int label, sc_vec3 p, sc_vec3 *normal)
{
    double distance;
    sc_vec3 n;

    if (s->phantom)
        return sc_phantom_distance(s->phantom, label, p, normal) / s->voxel_mm;
    p = tilt(sc_vec3_sub(p, middle_of(s)), -1);
    distance = s->radius > 0 ? torus(s->radius, p, &n) : ellipsoid(p, &n);
    *normal = tilt(n, 1);
    return distance;
}

int shape_owner(const shape *s, sc_vec3 p, double *border)
{
    sc_vec3 normal;
    int owner;

    if (!s->phantom) {
        const double distance = shape_distance(s, 1, p, &normal);

        *border = fabs(distance);
        return distance < 0;
    }
    /* The distance to the phantom's surface takes long to compute: compare the owners of points
     * half a voxel away in 26 directions instead. */
    owner = sc_phantom_owner(s->phantom, p);
    *border = HUGE_VAL;
    for (int n = 0; n < 27 && *border > 0.5; n++) {
        const sc_vec3 d = sc_vec3_unit((sc_vec3){n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1});

        if (sc_phantom_owner(s->phantom, sc_vec3_along(p, 0.5 * s->voxel_mm, d)) != owner)
            *border = 0.5;
    }
    return owner;
}

sc_vec3 shape_middle(const shape *s, double u)
{
    const sc_vec3 p = {MAJOR * cos(2 * M_PI * u), MAJOR * sin(2 * M_PI * u), 0};

    return sc_vec3_add(tilt(p, 1), middle_of(s));
}

/* Worker of sc_parallel_for: set the labels of layers [@p begin, @p end) along z. @p user: two
 * pointers, to the volume and to the shape. */
static void fill_layers(void *user, size_t begin, size_t end, int thread)
{
    sc_volume *v = ((void **)user)[0];
    const shape *s = ((void **)user)[1];
    uint8_t *ids = v->ids;

    (void)thread;
    for (size_t z = begin; z < end; z++) {
        for (int y = 0; y < v->size[1]; y++) {
            for (int x = 0; x < v->size[0]; x++) {
                sc_vec3 normal;
                const size_t at =
                    (z * (size_t)v->size[1] + (size_t)y) * (size_t)v->size[0] + (size_t)x;

                ids[at] = shape_distance(s, 1, (sc_vec3){x, y, (double)z}, &normal) < 0;
            }
        }
    }
}

sc_status shape_volume(const sc_ctx *ctx, const shape *s, int threads, sc_volume *out)
{
    sc_volume v = {.label_bytes = 1, .label_count = 2, .oriented = true};
    void *user[2] = {&v, (void *)(uintptr_t)s}, *block;
    sc_status status;

    if (s->phantom)
        return sc_phantom_volume(ctx, s->phantom, s->size, threads, out);
    memcpy(v.size, s->size, sizeof v.size);
    SC_TRY(sc_alloc(ctx, sc_volume_voxels(&v), 1, &v.ids));
    SC_TRY(sc_zalloc(ctx, 2, sizeof(sc_label), &block));
    v.labels = block;
    v.labels[1] = (sc_label){.value = 1, .rgb = {200, 80, 60}, .opacity = -1};
    strcpy(v.labels[1].name, s->name);
    for (int i = 0; i < 3; i++)
        v.to_ras_mm.m[i][i] = 1;
    sc_parallel_for(threads, (size_t)v.size[2], 1, fill_layers, user);
    *out = v;
    v = (sc_volume){0};
out:
    sc_volume_clear(&v);
    return status;
}
