/* SPDX-License-Identifier: BSD-3-Clause */
#include "directions.h"

#include <math.h>

#define QUARTER_PI 0.78539816339744830962

/* @return the bits of @p x in the reverse order. */
static uint32_t reverse(uint32_t x)
{
    x = (x >> 1 & 0x55555555u) | (x & 0x55555555u) << 1;
    x = (x >> 2 & 0x33333333u) | (x & 0x33333333u) << 2;
    x = (x >> 4 & 0x0f0f0f0fu) | (x & 0x0f0f0f0fu) << 4;
    x = (x >> 8 & 0x00ff00ffu) | (x & 0x00ff00ffu) << 8;
    return x >> 16 | x << 16;
}

uint32_t sc_mix(uint32_t a, uint32_t b)
{
    uint32_t x = a * 0x9e3779b1u ^ (b + 0x7f4a7c15u);

    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ x >> 16;
}

/* Permute the halves of [0, 1), the halves of these, and so on, by a hash of what lies above: one
 * bit after the other, from the highest, is flipped by a bit that depends on those above it alone.
 */
static uint32_t scramble(uint32_t x, uint32_t seed)
{
    uint32_t out = 0, above = 0;

    for (int bit = 31; bit >= 0; bit--) {
        const uint32_t flip = sc_mix(above + (1u << (31 - bit)), seed) & 1;

        out |= ((x >> bit & 1) ^ flip) << bit;
        above = above << 1 | (x >> bit & 1);
    }
    return out;
}

void sc_sobol_point(uint32_t index, uint32_t seed, double out[2])
{
    uint32_t y = 0, column = 1u << 31;

    for (uint32_t left = index; left; left >>= 1) {
        y ^= left & 1 ? column : 0;
        column ^= column >> 1;
    }
    out[0] = scramble(reverse(index), sc_mix(seed, 0)) * 0x1p-32;
    out[1] = scramble(y, sc_mix(seed, 1)) * 0x1p-32;
}

/* Sine and cosine of an angle of at most pi / 4, to the last digits of a float, by their series. */
static void sine_and_cosine(double angle, double *sine, double *cosine)
{
    const double x = angle * angle;

    *sine = angle * (1 - x / 6 * (1 - x / 20 * (1 - x / 42 * (1 - x / 72 * (1 - x / 110)))));
    *cosine = 1 - x / 2 * (1 - x / 12 * (1 - x / 30 * (1 - x / 56 * (1 - x / 90 * (1 - x / 132)))));
}

void sc_sine_cosine(double angle, double *sine, double *cosine)
{
    const double quarters = floor(angle / (2 * QUARTER_PI) + 0.5); /* -2 to 2 */
    double s, c;

    sine_and_cosine(angle - quarters * (2 * QUARTER_PI), &s, &c);
    *sine = quarters == 0 ? s : quarters == 1 ? c : quarters == -1 ? -c : -s;
    *cosine = quarters == 0 ? c : quarters == 1 ? -s : quarters == -1 ? s : -c;
}

double sc_part_of_turn(double y, double x)
{
    const double high = fmax(fabs(x), fabs(y)), low = fmin(fabs(x), fabs(y));
    double t = high > 0 ? low / high : 0, turn;

    /* the tangent of a quarter of the angle, at most pi / 16; then the series of its angle */
    for (int i = 0; i < 2; i++)
        t /= 1 + sqrt(1 + t * t);
    turn = 4 * t *
           (1 - t * t *
                    (1.0 / 3 -
                     t * t * (1.0 / 5 - t * t * (1.0 / 7 - t * t * (1.0 / 9 - t * t / 11))))) /
           (8 * QUARTER_PI);
    turn = fabs(y) > fabs(x) ? 0.25 - turn : turn;
    turn = x < 0 ? 0.5 - turn : turn;
    return y < 0 ? -turn : turn;
}

uint32_t sc_shuffled(uint32_t index, uint32_t count, uint32_t seed)
{
    return scramble(index, seed) & (count - 1);
}

void sc_cosine_direction(const double point[2], double out[3])
{
    const double a = 2 * point[0] - 1, b = 2 * point[1] - 1;
    double sine, cosine;

    /* Squares around the middle become circles; in each of four sectors the angle is at most pi
     * / 4. */
    if (a * a > b * b) {
        sine_and_cosine(QUARTER_PI * (b / a), &sine, &cosine);
        out[0] = a * cosine;
        out[1] = a * sine;
    } else {
        sine_and_cosine(b != 0 ? QUARTER_PI * (a / b) : 0, &sine, &cosine);
        out[0] = b * sine;
        out[1] = b * cosine;
    }
    out[2] = sqrt(fmax(1 - out[0] * out[0] - out[1] * out[1], 0));
}

void sc_frame_about(const double n[3], double t[3], double b[3])
{
    const double sign = n[2] < 0 ? -1 : 1;
    const double a = -1 / (sign + n[2]), c = n[0] * n[1] * a;

    t[0] = 1 + sign * n[0] * n[0] * a;
    t[1] = sign * c;
    t[2] = -sign * n[0];
    b[0] = c;
    b[1] = sign + n[1] * n[1] * a;
    b[2] = -n[1];
}
