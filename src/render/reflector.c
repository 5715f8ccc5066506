/* SPDX-License-Identifier: BSD-3-Clause */
/* How a surface gives light back along paths. */
#include "directions.h"
#include "path.h"

#define PI 3.14159265358979323846
/* The share that a face reflects of what comes straight, for a highlight of strength 1: tissue,
 * which is mostly water, reflects 2 to 4 %, and with a soft lamp those are the highlights of
 * light.method: global of 0.15 to 0.3. */
#define FACE_SHARE 0.14
/* From this share on all is reflected of what comes along the face; of less, less is. */
#define FACE_WHOLE 0.02

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void make_unit(double v[3])
{
    const double length = sqrt(dot(v, v));

    for (int i = 0; i < 3; i++)
        v[i] /= length;
}

/* @return the share that the face reflects of what comes along it. */
static double whole(const sc_reflector *s)
{
    return fmin(s->face / FACE_WHOLE, 1);
}

/* @return the share of light that the face reflects, by the cosine at which it comes (Schlick
 * 1994). */
static double fresnel(const sc_reflector *s, double cosine)
{
    const double less = 1 - fmin(fmax(cosine, 0), 1), square = less * less;

    return s->face + (whole(s) - s->face) * square * square * less;
}

/* @return how likely it is that the face is chosen. */
static double face_chance(const sc_reflector *s)
{
    const double face = fresnel(s, s->out[2]);
    const double below = (s->albedo[0] + s->albedo[1] + s->albedo[2]) / 3 * (1 - face);

    return face > 0 ? face / (face + below) : 0;
}

/* @return what of a rough face lies in the shadow of the rest, seen from @p w: Smith's lambda. */
static double hidden(const sc_reflector *s, const double w[3])
{
    const double across = (w[0] * w[0] + w[1] * w[1]) / (w[2] * w[2]);

    return (sqrt(1 + s->roughness * s->roughness * across) - 1) / 2;
}

sc_reflector sc_reflector_of(const sc_march_tissue *tissue, const double rgb[3],
                             const double out[3])
{
    sc_reflector s = {.face = fmin(FACE_SHARE * tissue->specular, 1),
                      .roughness = tissue->roughness,
                      .out = {out[0], out[1], fmax(out[2], 1e-3)}};

    make_unit(s.out);
    for (int i = 0; i < 3; i++)
        s.albedo[i] = fmin(rgb[i] * tissue->diffuse, 1);
    return s;
}

double sc_reflector_share(const sc_reflector *s, const double in[3], double share[3])
{
    const double chance = face_chance(s), square = s->roughness * s->roughness;
    /* What the face lets in comes out again through it, on the way both to and fro; the last factor
     * is 1 over the mean of one of them, so that white below the face gives back all that comes in
     * (Kelemen and Szirmay-Kalos 2001). */
    const double below = (1 - fresnel(s, s->out[2])) * (1 - fresnel(s, in[2])) * in[2] /
                         (PI * (1 - s->face - (whole(s) - s->face) / 21));
    double half[3], normals, seen, face, lambda;

    for (int i = 0; i < 3; i++)
        share[i] = in[2] > 0 ? s->albedo[i] * below : 0;
    if (!(in[2] > 0))
        return 0;
    if (!(chance > 0))
        return in[2] / PI;
    for (int i = 0; i < 3; i++)
        half[i] = s->out[i] + in[i];
    make_unit(half);
    normals = half[2] * half[2] * (square - 1) + 1;
    normals = square / (PI * normals * normals);
    lambda = hidden(s, s->out);
    seen = normals / (4 * s->out[2] * (1 + lambda)); /* the density of the normals that are seen */
    face = fresnel(s, dot(s->out, half)) * normals / (4 * s->out[2] * (1 + lambda + hidden(s, in)));
    for (int i = 0; i < 3; i++)
        share[i] += face;
    return chance * seen + (1 - chance) * in[2] / PI;
}

void sc_reflector_choose(const sc_reflector *s, double which, const double point[2], double in[3])
{
    double seen[3] = {s->roughness * s->out[0], s->roughness * s->out[1], s->out[2]};
    double sine, cosine, half[3], around, along;

    if (!(which < face_chance(s))) {
        sc_cosine_direction(point, in);
        return;
    }
    /* A normal of those that are seen (Dupuy and Benyoub 2023). */
    make_unit(seen);
    sc_sine_cosine(2 * PI * point[0] - PI, &sine, &cosine);
    half[2] = (1 - point[1]) * (1 + seen[2]) - seen[2];
    around = sqrt(fmin(fmax(1 - half[2] * half[2], 0), 1));
    half[0] = (around * cosine + seen[0]) * s->roughness;
    half[1] = (around * sine + seen[1]) * s->roughness;
    half[2] += seen[2];
    make_unit(half);
    along = 2 * dot(s->out, half);
    for (int i = 0; i < 3; i++)
        in[i] = along * half[i] - s->out[i];
}
