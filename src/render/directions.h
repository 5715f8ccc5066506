/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to render: directions in which light is gathered, from a low-discrepancy set. Their bits
 * are the same on every host: only integers, and operations that IEEE 754 rounds exactly, make
 * them. */
#ifndef SC_RENDER_DIRECTIONS_H
#define SC_RENDER_DIRECTIONS_H

#include <stdint.h>

/* Point @p index of the first two dimensions of Sobol's sequence (Sobol 1967), scrambled by nested
 * permutations (Owen 1995) of @p seed, each coordinate in [0, 1), to @p out. Any aligned run of 2^n
 * points of one seed is a net: every box of area 2^-n whose sides are powers of two holds one of
 * them. */
void sc_sobol_point(uint32_t index, uint32_t seed, double out[2]);
/* The unit vector about the z axis, with a density as its cosine, that belongs to a point of the
 * unit square, to @p out (Shirley and Chiu 1997). */
void sc_cosine_direction(const double point[2], double out[3]);
/* Sine and cosine of an angle from -pi to pi, in radians. */
void sc_sine_cosine(double angle, double *sine, double *cosine);
/* @return the angle from the direction of @p x to (@p x, @p y), a part of a turn, -1/2 to 1/2. */
double sc_part_of_turn(double y, double x);
/* Where among @p count points, a power of two, stands the one at place @p index of another order:
 * halves, halves of these and so on are swapped by @p seed, so that aligned runs stay such. It lets
 * a net of points lie in several squares without that those belong together. */
uint32_t sc_shuffled(uint32_t index, uint32_t count, uint32_t seed);
/* A hash of two numbers, of which all bits are as good as random. */
uint32_t sc_mix(uint32_t a, uint32_t b);
/* Two unit vectors across the unit vector @p n and across each other (Duff et al. 2017), to @p t
 * and @p b. */
void sc_frame_about(const double n[3], double t[3], double b[3]);

#endif
