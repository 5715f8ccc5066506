/* SPDX-License-Identifier: BSD-3-Clause */
/* Lamp and sky. */
#include "sky.h"

#include "directions.h"

#include <string.h>

#define PI 3.14159265358979323846
/* The radius of the disc, as a tangent: as a window of two metres seen from three. */
#define LAMP_RADIUS 0.3

/* The direction to the middle of the disc: before the volume, high up and to its right, as that of
 * the viewer stands who looks at it from before; and sc_lamp_frame.mean_cosine. */
static const float disc_direction[3] = {0.52F, 0.48F, 0.70655F};
#define DISC_MEAN_COSINE 0.97846F

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Sine and cosine of any angle, to @p out. */
static void sine_cosine_deg(double angle_deg, double out[2])
{
    const double turns = angle_deg / 360;

    sc_sine_cosine(2 * PI * (turns - floor(turns + 0.5)), &out[0], &out[1]);
}

/* @return the arc tangent of @p y / @p x. */
static double arc(double y, double x)
{
    return 2 * PI * sc_part_of_turn(y, x);
}

void sc_lamp_place(sc_sky *sky, const sc_lamp *lamp, const sc_camera *camera)
{
    const sc_vec3 *r = &camera->right, *u = &camera->up, *f = &camera->forward;
    const double axes[2][3][3] = {{{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}, /* front, left, up; */
                                  {{-f->x, -f->y, -f->z}, {r->x, r->y, r->z}, {u->x, u->y, u->z}}};
    const double(*to)[3] = axes[lamp->follows];
    double angle[2], elevation[2], width[2], height[2], a, b, aside, above;
    sc_lamp_frame *out = &sky->lamp;

    *out = (sc_lamp_frame){.mean_cosine = DISC_MEAN_COSINE};
    for (int i = 0; i < 3; i++)
        out->middle[i] = disc_direction[i];
    if (!lamp->is_given)
        return;
    sine_cosine_deg(lamp->angle_deg, angle);
    sine_cosine_deg(lamp->elevation_deg, elevation);
    sine_cosine_deg(lamp->width_deg / 2, width);
    sine_cosine_deg(lamp->height_deg / 2, height);
    for (int i = 0; i < 3; i++) {
        const double level = angle[1] * to[0][i] + angle[0] * to[1][i];

        out->middle[i] = elevation[1] * level + elevation[0] * to[2][i];
        out->right[i] = angle[1] * to[1][i] - angle[0] * to[0][i];
        out->up[i] = elevation[1] * to[2][i] - elevation[0] * level;
    }
    a = out->half[0] = width[0] / width[1];
    b = out->half[1] = height[0] / height[1];
    /* Its solid angle, and the same with each direction weighted by its cosine (Lambert 1760). */
    aside = sqrt(1 + a * a);
    above = sqrt(1 + b * b);
    out->turn = 2 * arc(a * b, sqrt(1 + a * a + b * b));
    out->tilt = b / above;
    out->density = 1 / (2 * out->turn);
    out->mean_cosine = 2 * (a / aside * arc(b, aside) + b / above * arc(a, above)) * out->density;
}

void sc_lamp_point(const sc_lamp_frame *lamp, const double point[2], double out[3])
{
    double t[3], b[3], at[3], length;

    if (lamp->half[0] > 0) {
        /* even in solid angle (Urena et al. 2013), about the middle */
        double sine, cosine, x, far, y;

        sc_sine_cosine((point[0] - 0.5) * lamp->turn, &sine, &cosine);
        x = sine / lamp->tilt;
        at[0] = x / sqrt(1 - x * x);
        far = sqrt(1 + at[0] * at[0]);
        y = (2 * point[1] - 1) * lamp->half[1] / sqrt(far * far + lamp->half[1] * lamp->half[1]);
        at[1] = y * far / sqrt(1 - y * y);
        for (int k = 0; k < 3; k++)
            out[k] = lamp->middle[k] + at[0] * lamp->right[k] + at[1] * lamp->up[k];
    } else {
        sc_frame_about(lamp->middle, t, b);
        sc_cosine_direction(point, at); /* whose shadow on the disc is even */
        for (int k = 0; k < 3; k++)
            out[k] = lamp->middle[k] + LAMP_RADIUS * (at[0] * t[k] + at[1] * b[k]);
    }
    length = sqrt(dot(out, out));
    for (int k = 0; k < 3; k++)
        out[k] /= length;
}

/* The density per solid angle of the directions of sc_lamp_point: of a disc even on it, which is
 * seen the smaller the farther from its middle. */
static double lamp_density(const sc_lamp_frame *lamp, const double d[3])
{
    const double cosine = dot(d, lamp->middle) / sqrt(dot(lamp->middle, lamp->middle));

    if (!(cosine > 0))
        return 0;
    if (lamp->half[0] > 0)
        return fabs(dot(d, lamp->right)) <= lamp->half[0] * cosine &&
                       fabs(dot(d, lamp->up)) <= lamp->half[1] * cosine
                   ? lamp->density
                   : 0;
    if (1 / (cosine * cosine) - 1 > LAMP_RADIUS * LAMP_RADIUS)
        return 0;
    return 1 / (PI * LAMP_RADIUS * LAMP_RADIUS * cosine * cosine * cosine);
}

/* ---- pictures ---- */

/* The direction to a point of a picture, by its place from left to right and from above to below, 0
 * to 1, to @p out: the middle of the picture stands before the body, and its right side to the
 * right. */
static void direction_to(const sc_sky *sky, double x, double y, double out[3])
{
    double turn = x - 0.5 + sky->turn, sine, cosine, level;

    turn -= floor(turn + 0.5);
    sc_sine_cosine(2 * PI * turn, &sine, &cosine);
    sc_sine_cosine(PI * y, &level, &out[2]);
    out[0] = level * sine;
    out[1] = level * cosine;
}

/* The place of a direction in a picture of @p width x @p height pixels, to @p out: column, row. */
static void place_of(const sc_sky *sky, const double d[3], int width, int height, int out[2])
{
    double x = sc_part_of_turn(d[0], d[1]) + 0.5 - sky->turn;
    const double y = 2 * sc_part_of_turn(sqrt(d[0] * d[0] + d[1] * d[1]), d[2]);

    x -= floor(x);
    out[0] = (int)(x * width);
    out[1] = (int)(y * height);
    out[0] = out[0] < width ? out[0] : width - 1;
    out[1] = out[1] < 0 ? 0 : out[1] < height ? out[1] : height - 1;
}

/* @return the solid angle of a pixel of a row of a picture of @p width x @p height. */
static double pixel_angle(int y, int width, int height)
{
    double sine, upper, lower;

    sc_sine_cosine(PI * y / height, &sine, &upper);
    sc_sine_cosine(PI * (y + 1) / height, &sine, &lower);
    return 2 * PI / width * (upper - lower);
}

/* What a pixel of the blurred picture sends before it is blurred, and from where. */
typedef struct blurred_pixel {
    double light[3], d[3];
} blurred_pixel;
enum { BLUR_POWER = 8 };

/* Sum up the light of the picture, and where it comes from: sets gain and around. @param sent all
 * 0.
 */
static void measure(sc_sky *sky, blurred_pixel sent[SC_SKY_ROWS * SC_SKY_COLUMNS])
{
    const sc_panorama *map = sky->map;
    double mean = 0;

    for (int y = 0; y < map->height_px; y++) {
        const double angle = pixel_angle(y, map->width_px, map->height_px);

        for (int x = 0; x < map->width_px; x++) {
            const float *rgb = map->rgb[(size_t)y * (size_t)map->width_px + (size_t)x];
            double d[3];
            int at[2];

            direction_to(sky, (x + 0.5) / map->width_px, (y + 0.5) / map->height_px, d);
            place_of(sky, d, SC_SKY_COLUMNS, SC_SKY_ROWS, at);
            for (int i = 0; i < 3; i++) {
                const double light = angle * rgb[i] / (4 * PI);

                mean += light / 3;
                sent[at[1] * SC_SKY_COLUMNS + at[0]].light[i] += angle * rgb[i];
                sky->around[i][0] += (float)light;
                for (int k = 0; k < 3; k++) /* 3 of the slope, 2/3 of the cosine around a normal */
                    sky->around[i][k + 1] += (float)(2 * light * d[k]);
            }
        }
    }
    for (int i = 0; i < SC_SKY_ROWS * SC_SKY_COLUMNS; i++) {
        const int column = i % SC_SKY_COLUMNS, row = i / SC_SKY_COLUMNS;

        direction_to(sky, (column + 0.5) / SC_SKY_COLUMNS, (row + 0.5) / SC_SKY_ROWS, sent[i].d);
    }
    sky->gain = (float)(SC_SKY_MEAN / mean);
    for (int i = 0; i < 12; i++)
        sky->around[i / 4][i % 4] *= sky->gain;
}

/* Set the blurred picture from what each of its pixels sends, which is in @p sent: the mean around
 * each direction, weighted by a power of the cosine. Its width, 20 degrees, is that which each of
 * the 32 rays of a place stands for: with less the light of small lamps is spotted. */
static void blur(sc_sky *sky, const blurred_pixel sent[SC_SKY_ROWS * SC_SKY_COLUMNS])
{
    for (int to = 0; to < SC_SKY_ROWS * SC_SKY_COLUMNS; to++) {
        const int y = to / SC_SKY_COLUMNS, x = to % SC_SKY_COLUMNS;
        double d[3], sum[3] = {0}, weights = 0;

        direction_to(sky, (x + 0.5) / SC_SKY_COLUMNS, (y + 0.5) / SC_SKY_ROWS, d);
        for (int from = 0; from < SC_SKY_ROWS * SC_SKY_COLUMNS; from++) {
            const blurred_pixel *p = &sent[from];
            double weight = d[0] * p->d[0] + d[1] * p->d[1] + d[2] * p->d[2];

            if (!(weight > 0))
                continue;
            for (int power = 1; power < BLUR_POWER; power *= 2)
                weight *= weight;
            weights += weight * pixel_angle(from / SC_SKY_COLUMNS, SC_SKY_COLUMNS, SC_SKY_ROWS);
            for (int i = 0; i < 3; i++)
                sum[i] += weight * p->light[i];
        }
        for (int i = 0; i < 3; i++)
            sky->coarse[y][x][i] = (float)(sky->gain * sum[i] / weights);
    }
}

/* Set rows and columns: how much light comes from the pixels before each, from 0 to 1. A little is
 * added to every pixel, so that each may be chosen. */
static void set_sums(sc_sky *sky)
{
    const int width = sky->map->width_px, height = sky->map->height_px;
    const float least = 0.01F * SC_SKY_MEAN / sky->gain;

    sky->rows[0] = 0;
    for (int y = 0; y < height; y++) {
        float *sums = sky->columns + (size_t)y * (size_t)(width + 1);
        const float(*rgb)[3] = (const float(*)[3])sky->map->rgb + (size_t)y * (size_t)width;
        double sum = 0;

        sums[0] = 0;
        for (int x = 0; x < width; x++) {
            sum += rgb[x][0] + rgb[x][1] + rgb[x][2] + least;
            sums[x + 1] = (float)sum;
        }
        sky->rows[y + 1] = sky->rows[y] + (float)(sum * pixel_angle(y, width, height));
        for (int x = 1; x <= width; x++)
            sums[x] /= (float)sum;
    }
    for (int y = 1; y <= height; y++)
        sky->rows[y] /= sky->rows[height];
}

sc_status sc_sky_init(const sc_ctx *ctx, const sc_panorama *map, double turn_deg, sc_sky *out)
{
    SC_OWN(sc_free_at) blurred_pixel *sent = NULL;
    sc_sky *sky = out;

    *sky = (sc_sky){0};
    if (!map || !map->rgb)
        return SC_OK;
    SC_PASS(SC_ZALLOC(ctx, SC_SKY_ROWS * SC_SKY_COLUMNS, &sent));
    SC_PASS(SC_ALLOC(ctx, (size_t)map->height_px + 1, &sky->rows));
    SC_PASS(SC_ALLOC(ctx, (size_t)map->height_px * ((size_t)map->width_px + 1), &sky->columns));
    sky->map = map;
    sky->turn = turn_deg / 360;
    measure(sky, sent);
    blur(sky, sent);
    set_sums(sky);
    return SC_OK;
}

void sc_sky_clear(sc_sky *sky)
{
    sc_free(sky->rows);
    sc_free(sky->columns);
}

uint64_t sc_sky_bytes(const sc_sky *sky)
{
    const sc_panorama *map = sky->map;

    return map ? ((uint64_t)map->height_px * ((uint64_t)map->width_px + 2) + 1) * sizeof(float) : 0;
}

/* @return which of @p count parts of a running sum holds @p at, 0 to 1; *@p at becomes its place
 * within that, 0 to 1. */
static int find_part(const float *sums, int count, double *at)
{
    int low = 0, high = count;

    while (high - low > 1) {
        const int middle = (low + high) / 2;

        if (sums[middle] <= *at)
            low = middle;
        else
            high = middle;
    }
    *at = (*at - sums[low]) / (sums[low + 1] - sums[low]);
    return low;
}

/* @return the density of the directions that are chosen by a picture. */
static double map_density(const sc_sky *sky, const double d[3])
{
    const int width = sky->map->width_px, height = sky->map->height_px;
    const float *sums;
    int at[2];

    place_of(sky, d, width, height, at);
    sums = sky->columns + (size_t)at[1] * (size_t)(width + 1) + at[0];
    return ((double)sky->rows[at[1] + 1] - sky->rows[at[1]]) * ((double)sums[1] - sums[0]) /
           pixel_angle(at[1], width, height);
}

/* Choose a direction by a picture. */
static void choose_by_map(const sc_sky *sky, const double point[2], double out[3])
{
    const int width = sky->map->width_px, height = sky->map->height_px;
    double x = point[0], y = point[1], sine, upper, lower, scale;
    const int row = find_part(sky->rows, height, &y);
    const int column = find_part(sky->columns + (size_t)row * (size_t)(width + 1), width, &x);

    direction_to(sky, (column + x) / width, (row + 0.5) / height, out);
    /* evenly in solid angle */
    sc_sine_cosine(PI * row / height, &sine, &upper);
    sc_sine_cosine(PI * (row + 1) / height, &sine, &lower);
    lower = upper + y * (lower - upper);
    scale = sqrt(fmax(1 - lower * lower, 0) / fmax(1 - out[2] * out[2], 1e-12));
    out[0] *= scale;
    out[1] *= scale;
    out[2] = lower;
}

/* ---- both ---- */

void sc_sky_blurred(const sc_sky *sky, const float d[3], float out[3])
{
    const double at[3] = {d[0], d[1], d[2]};
    int pixel[2];

    for (int i = 0; i < 3; i++)
        out[i] = SC_SKY_MEAN + SC_SKY_UP * d[2];
    if (!sky->map)
        return;
    place_of(sky, at, SC_SKY_COLUMNS, SC_SKY_ROWS, pixel);
    memcpy(out, sky->coarse[pixel[1]][pixel[0]], 3 * sizeof *out);
}

void sc_add_light_from(const sc_sky *sky, const sc_march_light *light, const double d[3],
                       double sum[3])
{
    /* The lamp brings a surface that faces it as much as white gives back. */
    const double lamp = light->lamp > 0 ? PI * light->lamp * lamp_density(&sky->lamp, d) : 0;
    double rgb[3];

    rgb[0] = rgb[1] = rgb[2] = SC_SKY_MEAN + SC_SKY_UP * d[2];
    if (sky->map) {
        int at[2];

        place_of(sky, d, sky->map->width_px, sky->map->height_px, at);
        for (int i = 0; i < 3; i++)
            rgb[i] = sky->gain *
                     sky->map->rgb[(size_t)at[1] * (size_t)sky->map->width_px + (size_t)at[0]][i];
    }
    for (int i = 0; i < 3; i++)
        sum[i] += lamp + light->sky * rgb[i];
}

/* @return how often the lamp is chosen: the sky without a picture is as bright all around that
 * nothing has to be chosen in it. */
static double lamp_chance(const sc_sky *sky, const sc_march_light *light)
{
    if (!sky->map)
        return light->lamp > 0 ? 1 : 0;
    return light->lamp / (light->lamp + SC_SKY_MEAN * light->sky);
}

double sc_choose_light(const sc_sky *sky, const sc_march_light *light, double which,
                       const double point[2], double out[3])
{
    const double chance = lamp_chance(sky, light);

    if (which < chance)
        sc_lamp_point(&sky->lamp, point, out);
    else if (sky->map)
        choose_by_map(sky, point, out);
    else
        return 0;
    return sc_light_density(sky, light, out);
}

double sc_light_density(const sc_sky *sky, const sc_march_light *light, const double d[3])
{
    const double chance = lamp_chance(sky, light);

    return (chance > 0 ? chance * lamp_density(&sky->lamp, d) : 0) +
           (sky->map ? (1 - chance) * map_density(sky, d) : 0);
}
