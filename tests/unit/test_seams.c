/* SPDX-License-Identifier: BSD-3-Clause */
/* Seams: where two tissues that touch meet the background. The true borders are planes of any tilt,
 * and the seam between the tissues, as seen from outside, is compared with the line in which the
 * planes meet. The bounds are what is reached today. */
#include "check.h"

#include "segcast/kernel.h"

#include "shapes.h"

enum { SIDE = 40, PLANES = 24, PLACES = 40, NEAR_STEPS = 400 };

/* The planes of the current case, through points near the middle: the tissues lie below the first,
 * and label 1 of them below the second, label 2 above. */
static sc_vec3 outer, inner, outer_at, inner_at;

static double height(sc_vec3 p, sc_vec3 at, sc_vec3 normal)
{
    return sc_vec3_dot(sc_vec3_sub(p, at), normal);
}

static int two_tissues(double x, double y, double z)
{
    const sc_vec3 p = {x, y, z};

    return height(p, outer_at, outer) > 0 ? 0 : height(p, inner_at, inner) > 0 ? 2 : 1;
}

/* A number in [0, 1), the same ones in every run. */
static double number(uint64_t *seed)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(*seed >> 40) / (double)(1 << 24);
}

static sc_vec3 direction(uint64_t *seed)
{
    for (;;) {
        const sc_vec3 d = {2 * number(seed) - 1, 2 * number(seed) - 1, 2 * number(seed) - 1};
        const double length = sc_vec3_length(d);

        if (length > 0.1 && length < 1)
            return sc_vec3_unit(d);
    }
}

static uint32_t owner_of(const sc_prepared *v, sc_vec3 p)
{
    /* The grid has one vertex more on the low side. */
    return sc_kernel_owner(v, (const float[3]){(float)p.x + 1, (float)p.y + 1, (float)p.z + 1});
}

/* Go from @p p, outside, against the normal of the outer plane. @return the first label that is
 * met, and how far below the plane, to @p depth. */
static uint32_t meet(const sc_prepared *v, sc_vec3 p, double *depth)
{
    for (int i = 0; i < NEAR_STEPS; i++) {
        const double at = 2 - 0.01 * i;
        const uint32_t owner = owner_of(v, sc_vec3_along(p, at, outer));

        if (owner) {
            *depth = -at;
            return owner;
        }
    }
    return 0;
}

/* Sums of squares, and of how many. */
typedef struct squares {
    double sum, count;
} squares;

static void add(squares *s, double x)
{
    s->sum += x * x;
    s->count++;
}

static double rms(squares s)
{
    return sqrt(s.sum / s.count);
}

/* What is measured of seams, in voxels. */
typedef struct seam {
    squares position; /* how far it lies from the true line */
    squares teeth;    /* ... and from its own mean place beside the same planes */
    squares depth;    /* how deep the surface lies below the true one, within half a voxel of it */
} seam;

/* Measure the seam of the current planes at places along it. */
static void measure(const sc_prepared *v, uint64_t *seed, seam *out)
{
    double all[PLACES], mean = 0;
    const sc_vec3 along = sc_vec3_unit(sc_vec3_cross(outer, inner)),
                  across = sc_vec3_cross(along, outer);
    const double slope = sc_vec3_dot(across, inner);
    sc_vec3 middle = inner_at;

    middle = sc_vec3_along(middle, -height(middle, outer_at, outer), outer);
    middle = sc_vec3_along(middle, -height(middle, inner_at, inner) / slope, across);
    for (int i = 0; i < PLACES; i++) {
        const sc_vec3 p = sc_vec3_along(middle, 20 * number(seed) - 10, along);
        double found = 0, low = 0;

        for (int step = -60; step < 60; step++) { /* adds up how far label 1 reaches */
            const double t = 0.05 * (step + 0.5);
            const uint32_t owner = meet(v, sc_vec3_along(p, slope > 0 ? t : -t, across), &low);

            assert_true(owner == 1 || owner == 2);
            found += owner == 1 ? 0.05 : 0;
            if (fabs(t) < 0.5)
                add(&out->depth, low);
        }
        add(&out->position, found - 3);
        all[i] = found;
        mean += found / PLACES;
    }
    for (int i = 0; i < PLACES; i++)
        add(&out->teeth, all[i] - mean);
}

static void seams_are_straight(void **state)
{
    seam all = {{0, 0}, {0, 0}, {0, 0}};
    uint64_t seed = 7;

    (void)state;
    for (int i = 0; i < PLANES; i++) {
        sc_volume v;
        prepared_copy p;

        do {
            outer = direction(&seed);
            inner = direction(&seed);
        } while (fabs(sc_vec3_dot(outer, inner)) > 0.7);
        outer_at = inner_at = (sc_vec3){0.5 * SIDE + number(&seed), 0.5 * SIDE + number(&seed),
                                        0.5 * SIDE + number(&seed)};
        v = shape_volume((const int[3]){SIDE, SIDE, SIDE}, (const double[3]){1, 1, 1}, 1, 3,
                         two_tissues);
        p = prepare_copy(&v, 2);
        measure(&p.view, &seed, &all);
        sc_free(p.block);
        sc_volume_clear(&v);
    }
    printf("seams: %.3f voxels off, %.3f about their mean place; surface beside them %.3f\n",
           rms(all.position), rms(all.teeth), rms(all.depth));
    assert_true(rms(all.position) < 0.40);
    assert_true(rms(all.teeth) < 0.21);
    assert_true(rms(all.depth) < 0.22);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(seams_are_straight)};

    return RUN(tests);
}
