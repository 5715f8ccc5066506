/* SPDX-License-Identifier: BSD-3-Clause */
/* Seams: where two tissues that touch meet the background. The true borders are planes of any tilt,
 * and the seam between the tissues, as seen from outside, is compared with the line in which the
 * planes meet. The bounds are what is reached today. */
#include "check.h"

#include "segcast/kernel.h"

#include "shapes.h"

enum { SIDE = 40, PLANES = 24, PLACES = 40, ABOVE = 2 };

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

/* Set @p march so that rays see the two tissues of @p v, opaque and without light. */
static void see_tissues(const sc_prepared *v, sc_march_tissue tissues[3], sc_march *march)
{
    *march = (sc_march){
        .volume = v, .tissues = tissues, .light = {.flat = true}, .opaque_below = SC_OPAQUE};
    for (int i = 0; i < 3; i++) {
        march->box_high[i] = SIDE + 1;
        march->grid_per_mm[i][i] = 1;
        tissues[i] = (sc_march_tissue){
            .boundary_alpha = i ? 1 : 0, .cap_alpha = 1, .show = i ? SC_SHOW_BOUNDARY : 0};
    }
}

/* Go from above @p p, outside, against the normal of the outer plane. @return what is seen. */
static sc_radiance look(const sc_march *march, sc_vec3 p)
{
    const sc_kernel *kernel = sc_kernel_find(SC_SURFACE_SMOOTH, SC_SKIP_NONE, march->volume, NULL);
    const sc_vec3 from = sc_vec3_along(p, ABOVE, outer);
    /* The grid has one vertex more on the low side. */
    const sc_ray ray = {.origin = {(float)from.x + 1, (float)from.y + 1, (float)from.z + 1},
                        .direction = {(float)-outer.x, (float)-outer.y, (float)-outer.z},
                        .toward_eye = {(float)outer.x, (float)outer.y, (float)outer.z},
                        .clip_sets = 1,
                        .part_count = {1},
                        .parts = {{{.end_mm = 2 * ABOVE, .cap_plane = -1}}}};
    sc_march_counters counters = {0};
    sc_radiance seen;

    kernel->march(march, &ray, NULL, 1, &seen, &counters);
    return seen;
}

/* @return the label that is seen first from above @p p, and how far below the plane, to @p depth.
 */
static uint32_t meet(const sc_march *march, sc_vec3 p, double *depth)
{
    const sc_radiance seen = look(march, p);

    *depth = (double)seen.depth_mm - ABOVE;
    return seen.label;
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
    sc_march_tissue tissues[3];
    sc_march march;
    const sc_vec3 along = sc_vec3_unit(sc_vec3_cross(outer, inner)),
                  across = sc_vec3_cross(along, outer);
    const double slope = sc_vec3_dot(across, inner);
    sc_vec3 middle = inner_at;

    see_tissues(v, tissues, &march);
    middle = sc_vec3_along(middle, -height(middle, outer_at, outer), outer);
    middle = sc_vec3_along(middle, -height(middle, inner_at, inner) / slope, across);
    for (int i = 0; i < PLACES; i++) {
        const sc_vec3 p = sc_vec3_along(middle, 20 * number(seed) - 10, along);
        double found = 0, low = 0;

        for (int step = -60; step < 60; step++) { /* adds up how far label 1 reaches */
            const double t = 0.05 * (step + 0.5);
            const uint32_t owner = meet(&march, sc_vec3_along(p, slope > 0 ? t : -t, across), &low);

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

/* Directions, places and a volume of @p id_of for the next case. The caller clears the volume. */
static sc_volume next_case(uint64_t *seed, int (*id_of)(double x, double y, double z))
{
    do {
        outer = direction(seed);
        inner = direction(seed);
    } while (fabs(sc_vec3_dot(outer, inner)) > 0.7);
    outer_at = inner_at =
        (sc_vec3){0.5 * SIDE + number(seed), 0.5 * SIDE + number(seed), 0.5 * SIDE + number(seed)};
    return shape_volume((const int[3]){SIDE, SIDE, SIDE}, (const double[3]){1, 1, 1}, 1, 3, id_of);
}

static void seams_are_straight(void **state)
{
    seam all = {{0, 0}, {0, 0}, {0, 0}};
    uint64_t seed = 7;

    (void)state;
    for (int i = 0; i < PLANES; i++) {
        sc_volume v = next_case(&seed, two_tissues);
        prepared_copy p = prepare_copy(&v, 2);

        measure(&p.view, &seed, &all);
        sc_free(p.block);
        sc_volume_clear(&v);
    }
    printf("seams: %.3f voxels off, %.3f about their mean place; surface beside them %.3f\n",
           rms(all.position), rms(all.teeth), rms(all.depth));
    assert_true(rms(all.position) < 0.345);
    assert_true(rms(all.teeth) < 0.165);
    assert_true(rms(all.depth) < 0.22);
}

/* The owner of the point that lies @p depth below @p p. */
static uint32_t owner_below(const sc_prepared *v, sc_vec3 p, double depth)
{
    const sc_vec3 at = sc_vec3_along(p, -depth, outer);

    return sc_kernel_owner(v, (const float[3]){(float)at.x + 1, (float)at.y + 1, (float)at.z + 1});
}

/* Where another tissue is seen than the one behind, rays still meet that one: a translucent coat
 * lets them through to it. */
static void what_is_behind_a_coat_is_met(void **state)
{
    uint64_t seed = 5;
    int coats = 0;

    (void)state;
    for (int i = 0; i < PLANES / 4; i++) {
        sc_volume v = next_case(&seed, two_tissues);
        prepared_copy p = prepare_copy(&v, 2);
        sc_march_tissue tissues[3];
        sc_march march;

        see_tissues(&p.view, tissues, &march);
        tissues[2].boundary_alpha = 0.25f;
        for (int k = 0; k < 100 * PLACES; k++) {
            const sc_vec3 from = {inner_at.x + 16 * number(&seed) - 8,
                                  inner_at.y + 16 * number(&seed) - 8,
                                  inner_at.z + 16 * number(&seed) - 8};
            const sc_vec3 at = sc_vec3_along(from, -height(from, outer_at, outer), outer);
            double depth, past;

            if (meet(&march, at, &depth) != 2 || owner_below(&p.view, at, depth + 0.01) != 1)
                continue;
            coats++;
            tissues[2].show = 0; /* what is seen then is the surface of the owner, as deep */
            assert_int_equal(meet(&march, at, &past), 1);
            assert_true(past - depth < 0.05);
            tissues[2].show = SC_SHOW_BOUNDARY;
            assert_true(look(&march, at).transmittance < SC_OPAQUE);
        }
        sc_free(p.block);
        sc_volume_clear(&v);
    }
    assert_true(coats > 20);
}

/* A sheet one voxel thick, label 2, that reaches the background with its edge. */
static int sheet_on_edge(double x, double y, double z)
{
    const sc_vec3 p = {x, y, z};

    if (height(p, outer_at, outer) > 0)
        return 0;
    return fabs(height(p, inner_at, inner)) <= 0.5 * (fabs(inner.x) + fabs(inner.y) + fabs(inner.z))
               ? 2
               : 1;
}

/* The edge of a thin sheet is nowhere lost, and is seen nearly as wide as the sheet is there. */
static void thin_sheets_keep_their_edges(void **state)
{
    uint64_t seed = 11;
    double owned = 0, seen = 0;

    (void)state;
    for (int i = 0; i < PLANES; i++) {
        sc_volume v = next_case(&seed, sheet_on_edge);
        prepared_copy p = prepare_copy(&v, 2);
        sc_march_tissue tissues[3];
        sc_march march;
        const sc_vec3 along = sc_vec3_unit(sc_vec3_cross(outer, inner));

        see_tissues(&p.view, tissues, &march);
        for (int k = 0; k < PLACES; k++) {
            const sc_vec3 from = sc_vec3_along(inner_at, 16 * number(&seed) - 8, along);
            int owns = 0, sees = 0;

            for (int step = -60; step < 60; step++) {
                const sc_vec3 at =
                    sc_vec3_along(from, 0.05 * (step + 0.5), sc_vec3_cross(along, outer));
                double depth;

                sees += meet(&march, at, &depth) == 2;
                owns += owner_below(&p.view, at, depth + 0.01) == 2;
            }
            assert_true(sees > 0 || owns == 0);
            owned += owns;
            seen += sees;
        }
        sc_free(p.block);
        sc_volume_clear(&v);
    }
    printf("edges of sheets: %.3f of their width are seen\n", seen / owned);
    assert_true(seen / owned > 0.86 && seen / owned < 1.05);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(seams_are_straight),
                                       cmocka_unit_test(what_is_behind_a_coat_is_met),
                                       cmocka_unit_test(thin_sheets_keep_their_edges)};

    return RUN(tests);
}
