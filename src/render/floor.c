/* SPDX-License-Identifier: BSD-3-Clause */
/* The floor below the tissues, which has the colour of the background but for the shadows on it and
 * the light that tissues throw there: so no horizon is seen. It is flat, or rises behind the body
 * in a quarter of a circle to an upright wall; it has no end, and gives nothing back to them. Its
 * light is gathered at points of a grid, as that of tissues at vertices; what is kept of each is
 * how it differs from what it would be without tissues, exactly 1 where nothing is in the way. */
#include "directions.h"
#include "gather.h"
#include "internal.h"

#include <stdlib.h>

enum {
    SIDE = SC_FLOOR_SIDE,
    REACH = 4 /* a point gets the mean of those less far away than this */
};
/* The points lie so much nearer to each other in the middle than they would be if they lay evenly:
 * there the shadows are sharp. */
#define DENSE 3.0
/* From this share of the way to the border on shadows fade, so that none ends there at once. */
#define FADE_FROM 0.7
/* The radius of the curve of a cove, as a share of the height of what stands before it. */
#define CURVE_SHARE 0.35
#define QUARTER_TURN 1.57079632679489661923

void sc_floor_place(sc_renderer *r)
{
    const sc_box3 *box = &r->bounds.hull_box;
    const double x = box->high.x - box->low.x, y = box->high.y - box->low.y;
    const double height = box->high.z - box->low.z;

    /* The lamp is as high as it is far to the side: so are shadows as long as tissues are high. */
    r->light.floor = (sc_floor){
        .middle = {(box->low.x + box->high.x) / 2, (box->low.y + box->high.y) / 2, box->low.z},
        .half_mm = 0.5 * fmax(x, y) + 1.3 * height,
        .foot_mm = box->low.y};
    if (r->settings.floor == SC_GROUND_COVE) {
        r->light.floor.radius_mm = CURVE_SHARE * height;
        r->light.floor.half_mm += 0.7 * height; /* as on the wall, too */
    }
}

/* @return a point of the floor. @param x, y where it lies if the floor is rolled out. @param normal
 * set to that there. */
static sc_vec3 roll_up(const sc_floor *f, double x, double y, double normal[3])
{
    const double behind = f->radius_mm > 0 ? fmax(f->foot_mm - y, 0) : 0;
    const double turn = behind > 0 ? fmin(behind / f->radius_mm, QUARTER_TURN) : 0;
    const double above = behind - turn * f->radius_mm; /* the end of the curve */

    normal[0] = 0;
    sc_sine_cosine(turn, &normal[1], &normal[2]);
    return (sc_vec3){x, y + behind - f->radius_mm * normal[1],
                     f->middle.z + f->radius_mm * (1 - normal[2]) + above};
}

/* @return the opposite: the y of a point of the floor if that is rolled out. */
static double roll_out(const sc_floor *f, const sc_vec3 *at)
{
    const double above = at->z - f->middle.z - f->radius_mm; /* the end of the curve */

    if (!(f->radius_mm > 0 && at->y < f->foot_mm))
        return at->y;
    return f->foot_mm - (above > 0 ? QUARTER_TURN * f->radius_mm + above
                                   : 4 * QUARTER_TURN * f->radius_mm *
                                         sc_part_of_turn(f->foot_mm - at->y, -above));
}

/* @return where a coordinate of the grid, -1 to 1, lies on the way from the middle to the border,
 * -1 to 1. */
static double spread_out(double at)
{
    return at * (1 + (DENSE - 1) * fabs(at)) / DENSE;
}

/* @return the opposite. */
static double draw_in(double place)
{
    const double d = DENSE - 1, root = sqrt(1 + 4 * d * DENSE * fabs(place));

    return copysign((root - 1) / (2 * d), place);
}

void sc_floor_points(void *user, size_t begin, size_t end, int thread)
{
    const sc_gather *g = user;
    const sc_renderer *r = g->renderer;
    const sc_floor *f = &r->light.floor;

    for (size_t i = begin; i < end; i++) {
        const uint32_t at[2] = {(uint32_t)(i % SIDE), (uint32_t)(i / SIDE)};
        sc_gather_place *p = &g->places[g->floor.first + i];
        double n[3];
        const sc_vec3 mm =
            roll_up(f, f->middle.x + f->half_mm * spread_out(2.0 * at[0] / (SIDE - 1) - 1),
                    f->middle.y + f->half_mm * spread_out(2.0 * at[1] / (SIDE - 1) - 1), n);
        const sc_vec3 voxel = sc_affine_point(&r->space.to_voxel, mm);

        *p = (sc_gather_place){.normal = {0, (float)n[1], (float)n[2]}};
        p->at[0] = (float)(voxel.x + 1);
        p->at[1] = (float)(voxel.y + 1);
        p->at[2] = (float)(voxel.z + 1);
        for (int bit = 0; bit < 6; bit++)
            p->part |= (uint8_t)((at[bit % 2] >> (bit / 2) & 1) << bit);
    }
}

void sc_floor_spread(void *user, size_t begin, size_t end, int thread)
{
    const sc_gather *g = user;

    for (size_t i = begin; i < end; i++) {
        const int x = (int)(i % SIDE), y = (int)(i / SIDE);
        const double aside = fmax(fabs(spread_out(2.0 * x / (SIDE - 1) - 1)),
                                  fabs(spread_out(2.0 * y / (SIDE - 1) - 1)));
        const double fade = fmin((1 - aside) / (1 - FADE_FROM), 1);
        float light[3] = {0}, whole[3] = {0};

        for (int k = 0; k < (2 * REACH - 1) * (2 * REACH - 1); k++) {
            const int dx = k % (2 * REACH - 1) - REACH + 1, dy = k / (2 * REACH - 1) - REACH + 1;
            const float weight = (float)((REACH - abs(dx)) * (REACH - abs(dy)));
            size_t at;

            if (x + dx < 0 || y + dy < 0 || x + dx >= SIDE || y + dy >= SIDE)
                continue;
            at = g->floor.first + (size_t)((y + dy) * SIDE + x + dx);
            for (int c = 0; c < 3; c++) {
                light[c] += weight * g->light.all[at][c];
                whole[c] += weight * g->floor.free[y + dy][(x + dx) % SC_FLOOR_PARTS][c];
            }
        }
        for (int c = 0; c < 3; c++)
            g->floor.light[i][c] = whole[c] > 0 ? 1 + (float)fade * (light[c] / whole[c] - 1) : 1;
    }
}

/* Where a cove curves from its floor to its wall, find the point of the curve that a line of sight
 * reaches. @param at set to the point. @param normal set to the normal of the curve there.
 * @return whether the line reaches the upper side of the curve. */
static bool meet_curve(const sc_floor *f, const sc_sight *sight, sc_vec3 *at, double normal[3])
{
    const sc_vec3 *d = &sight->direction;
    const double y = sight->eye_mm.y - f->foot_mm;
    const double z = sight->eye_mm.z - f->middle.z - f->radius_mm;
    const double square = d->y * d->y + d->z * d->z, half = y * d->y + z * d->z;
    const double root = half * half - square * (y * y + z * z - f->radius_mm * f->radius_mm);

    if (!(root > 0 && sqrt(root) > half))
        return false;
    *at = sc_vec3_along(sight->eye_mm, (sqrt(root) - half) / square, *d);
    normal[1] = (f->foot_mm - at->y) / f->radius_mm;
    normal[2] = (f->middle.z + f->radius_mm - at->z) / f->radius_mm;
    return true;
}

bool sc_floor_meets(const sc_floor *f, const sc_sight *sight, sc_vec3 *at, double normal[3])
{
    const double wall = f->foot_mm - f->radius_mm;
    double far = (f->middle.z - sight->eye_mm.z) / sight->direction.z;
    bool meets = sight->direction.z < 0 && far > 0;

    normal[0] = normal[1] = 0;
    normal[2] = 1;
    if (f->radius_mm > 0) {
        const double to_wall = (wall - sight->eye_mm.y) / sight->direction.y;

        if (!(sight->eye_mm.z > f->middle.z && sight->eye_mm.y > wall))
            return false; /* from below, or from behind */
        if (sight->direction.y < 0 && !(meets && far < to_wall)) {
            far = to_wall;
            meets = true;
            normal[1] = 1;
            normal[2] = 0;
        }
    }
    *at = sc_vec3_along(sight->eye_mm, far, sight->direction);
    if (meets && f->radius_mm > 0 && at->y < f->foot_mm && at->z < f->middle.z + f->radius_mm)
        meets = meet_curve(f, sight, at, normal);
    return meets;
}

/* The share of light at a point of the floor, to @p out. @return false where it is that without
 * tissues. */
static bool floor_light(const sc_floor *f, const sc_vec3 *at, float out[3])
{
    const double place[2] = {(at->x - f->middle.x) / f->half_mm,
                             (roll_out(f, at) - f->middle.y) / f->half_mm};
    const float(*from)[3] = f->light;
    int low[2];
    float share[2];

    for (int i = 0; i < 2; i++) {
        const double grid = (draw_in(place[i]) + 1) / 2 * (SIDE - 1);

        if (!(grid >= 0 && grid < SIDE - 1))
            return false;
        low[i] = (int)grid;
        share[i] = (float)(grid - low[i]);
    }
    from += low[1] * SIDE + low[0];
    for (int c = 0; c < 3; c++) {
        const float near = from[0][c] + share[0] * (from[1][c] - from[0][c]);
        const float next = from[SIDE][c] + share[0] * (from[SIDE + 1][c] - from[SIDE][c]);

        out[c] = near + share[1] * (next - near);
    }
    return out[0] != 1 || out[1] != 1 || out[2] != 1;
}

void sc_floor_show(const sc_renderer *r, const float share[3], sc_radiance *light)
{
    for (int c = 0; c < 3 && !r->settings.transparent; c++)
        light->rgb[c] += light->transmittance * sqrtf(share[c]) * r->behind.tone[c];
    /* What is behind a transparent picture is darkened, as by a veil. */
    light->transmittance *=
        r->settings.transparent ? fminf(sqrtf((share[0] + share[1] + share[2]) / 3), 1) : 0;
}

void sc_put_floor_behind(const sc_lens *lens, const sc_aim *aims, size_t count, sc_radiance *light)
{
    const sc_renderer *r = lens->renderer;

    for (size_t i = 0; i < count; i++) {
        const sc_sight sight = sc_line_of_sight(lens, &aims[i]);
        sc_vec3 at;
        double normal[3];
        float share[3];

        if (light[i].transmittance > 0 && sc_floor_meets(&r->light.floor, &sight, &at, normal) &&
            floor_light(&r->light.floor, &at, share))
            sc_floor_show(r, share, &light[i]);
    }
}
