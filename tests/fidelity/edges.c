/* SPDX-License-Identifier: BSD-3-Clause */
/* Sharp edges of thick tissue, as of a liver, and thin tissue that grows out of thick tissue, which
 * looks like one where it begins. */
#include "rulers.h"

#include <string.h>

enum {
    WIDTH = 90, /* voxels along x */
    EDGE = 60,  /* voxels along y and z */
    SLAB = 20,  /* voxels along y above which there is only what grows out of thick tissue */
    ACROSS = 17 /* ways to look for the edge, side by side */
};
/* Along the edge it is looked at so far to both sides of its middle, at places so far apart; it is
 * 35 voxels long to both sides. */
#define ALONG 28.0
#define APART 0.25
/* On the way from outside inwards: where it begins, ends, and its steps, before they are halved. */
#define FROM (-3.0)
#define TO 12.0
#define STEP 0.25

typedef struct edge_kind {
    const char *name;
    double angle_deg; /* of a wedge; 0: other tissue */
    bool is_gap;      /* the wedge is background in tissue */
} edge_kind;

static const edge_kind kinds[] = {{.name = "wedge of 40 degrees", .angle_deg = 40},
                                  {.name = "wedge of 70 degrees", .angle_deg = 70},
                                  {.name = "wedge of 100 degrees", .angle_deg = 100},
                                  {.name = "gap of 60 degrees", .angle_deg = 60, .is_gap = true},
                                  {.name = "sheet, tube and line on thick tissue"}};

size_t edge_count(void)
{
    return SC_COUNT_OF(kinds);
}

/* The middle of the edge, in voxels, and unit vectors along it, inwards and across. Its direction
 * is none of the grid's. */
static void find_frame(sc_vec3 *middle, sc_vec3 *along, sc_vec3 *inward, sc_vec3 *across)
{
    const sc_vec3 up = {0, 1, 0.1};

    *middle = (sc_vec3){45, 15, 30};
    *along = sc_vec3_unit((sc_vec3){1, 0.25, 0.15});
    *inward = sc_vec3_unit(sc_vec3_sub(up, sc_vec3_scale(*along, sc_vec3_dot(up, *along))));
    *across = sc_vec3_cross(*along, *inward);
}

/* Does the wedge hold a point? */
static bool in_wedge(double angle_deg, sc_vec3 p)
{
    sc_vec3 middle, along, inward, across;
    double in;

    find_frame(&middle, &along, &inward, &across);
    p = sc_vec3_sub(p, middle);
    in = sc_vec3_dot(p, inward);
    return in < 30 && fabs(sc_vec3_dot(p, along)) < 35 &&
           fabs(sc_vec3_dot(p, across)) < in * tan(angle_deg / 2 * M_PI / 180);
}

/* Is a point in the slab, or in the sheet two voxels thick, in the tube of radius 1.2, or in the
 * line that grow out of it? */
static bool in_growth(sc_vec3 p)
{
    const double sheet = (p.x - 20) * 0.96 + (p.z - 30) * 0.28;
    const double tube = hypot(p.x - 50 - 0.3 * (p.y - SLAB), p.z - 30 - 0.2 * (p.y - SLAB));

    if (p.y < SLAB)
        return p.y > 8 && p.x > 5 && p.x < 85 && p.z > 5 && p.z < 55;
    return p.y < 45 && ((fabs(sheet) < 1 && p.z > 12 && p.z < 48) || tube < 1.2 ||
                        (fabs(p.x - 75) < 0.6 && fabs(p.z - 30) < 0.6));
}

/* Make the volume of a kind, label 1. Caller owns @p out: sc_volume_clear. @return SC_ERR_MEMORY.
 */
static sc_status make_volume(const sc_ctx *ctx, const edge_kind *kind, sc_volume *out)
{
    SC_OWN(sc_volume_clear)
    sc_volume v = {
        .size = {WIDTH, EDGE, EDGE}, .label_bytes = 1, .label_count = 2, .oriented = true};
    uint8_t *ids;

    for (int i = 0; i < 3; i++)
        v.to_ras_mm.m[i][i] = 1;
    SC_PASS(sc_zalloc(ctx, sc_volume_voxels(&v), 1, &v.ids));
    SC_PASS(SC_ZALLOC(ctx, 2, &v.labels));
    v.labels[1] = (sc_label){.value = 1, .rgb = {200, 60, 60}, .opacity = -1, .name = "tissue"};
    ids = v.ids;
    for (size_t n = 0; n < sc_volume_voxels(&v); n++) {
        const sc_vec3 p = {(double)(n % WIDTH), (double)(n / WIDTH % EDGE),
                           (double)(n / WIDTH / EDGE)};

        ids[n] = kind->angle_deg > 0 ? in_wedge(kind->angle_deg, p) != kind->is_gap : in_growth(p);
    }
    SC_HAND_OVER(v, out);
    return SC_OK;
}

/* @return how far inwards from the true edge of label @p id the drawn one lies, in voxels, @p t
 * along it. */
static double edge_at(const stage *st, double t, int id)
{
    sc_vec3 middle, along, inward, across;
    double nearest = TO;

    find_frame(&middle, &along, &inward, &across);
    middle = sc_vec3_add(middle, sc_vec3_scale(along, t));
    for (int n = 0; n < ACROSS; n++) {
        const sc_vec3 from =
            sc_vec3_add(middle, sc_vec3_scale(across, 0.25 * (n - (ACROSS - 1) / 2)));
        double in = FROM;

        while (in < nearest && owner_at(st, sc_vec3_add(from, sc_vec3_scale(inward, in))) != id)
            in += STEP;
        for (double half = STEP / 2; half > 1e-3 && in < nearest; half /= 2)
            in += owner_at(st, sc_vec3_add(from, sc_vec3_scale(inward, in))) == id ? -half : half;
        nearest = fmin(nearest, in);
    }
    return nearest;
}

sc_status measure_edge(const sc_ctx *ctx, size_t n, const drawing *how, sharp_edge *out)
{
    const edge_kind *kind = &kinds[n];
    SC_OWN(sc_volume_clear) sc_volume volume = {0};
    SC_OWN(stage_close) stage st = {0};
    double sum = 0, squares = 0, kept = 0, all = 0;
    const uint8_t *ids;
    int places = 0;

    *out = (sharp_edge){.name = kind->name, .retreat = NAN, .wobble = NAN};
    SC_PASS(make_volume(ctx, kind, &volume));
    SC_PASS(stage_open(ctx, &volume, how, 1, 0.1, &st));
    for (double t = -ALONG; t <= ALONG && kind->angle_deg > 0; t += APART, places++) {
        const double in = edge_at(&st, t, !kind->is_gap);

        sum += in;
        squares += in * in;
    }
    if (places) {
        out->retreat = sum / places;
        out->wobble = sqrt(fmax(squares / places - out->retreat * out->retreat, 0));
    }
    ids = volume.ids;
    for (size_t i = 0; i < sc_volume_voxels(&volume); i++) {
        const sc_vec3 p = {(double)(i % WIDTH), (double)(i / WIDTH % EDGE),
                           (double)(i / WIDTH / EDGE)};

        if (ids[i] != kind->is_gap && (kind->angle_deg > 0 || p.y >= SLAB)) {
            all++;
            kept += owner_at(&st, p) == ids[i];
        }
    }
    out->voxels = kept / all;
    return SC_OK;
}
