/* SPDX-License-Identifier: BSD-3-Clause */
/* How a surface gives light back along paths. */
#include "directions.h"
#include "path.h"

#define PI 3.14159265358979323846
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

/* @return the share of light that facets reflect, by the cosine at which it comes (Schlick 1994).
 */
static double fresnel(const sc_facets *f, double cosine)
{
    const double less = 1 - fmin(fmax(cosine, 0), 1), square = less * less;

    return f->straight + (f->along - f->straight) * square * square * less;
}

/* @return how likely it is that the face is chosen. @param coat set to that of the coat. */
static double face_chance(const sc_reflector *s, double *coat)
{
    const double over = fresnel(&s->coat, s->out[2]);
    const double face = (1 - over) * fresnel(&s->face, s->out[2]);
    const double below = (s->albedo[0] + s->albedo[1] + s->albedo[2]) / 3 * (1 - over - face);
    const double all = face + below + over;

    *coat = over > 0 ? over / all : 0;
    return face > 0 ? face / all : 0;
}

/* @return what of a rough face lies in the shadow of the rest, seen from @p w: Smith's lambda. */
static double hidden(const sc_facets *f, const double w[3])
{
    const double across = (w[0] * w[0] + w[1] * w[1]) / (w[2] * w[2]);

    return (sqrt(1 + f->width * f->width * across) - 1) / 2;
}

sc_reflector sc_reflector_of(const sc_march_tissue *tissue, const double rgb[3],
                             const double out[3])
{
    const double face = fmin(SC_FACE_SHARE * tissue->face, 1);
    sc_reflector s = {.face = {face, fmin(face / FACE_WHOLE, 1), tissue->roughness},
                      .coat = {SC_COAT_SHARE * tissue->coat, tissue->coat, SC_COAT_WIDTH},
                      .out = {out[0], out[1], fmax(out[2], 1e-3)}};

    make_unit(s.out);
    for (int i = 0; i < 3; i++)
        s.albedo[i] = fmin(rgb[i], 1);
    return s;
}

/* @return the share that facets send on, times the cosine. @param density set to that of the
 * directions that are chosen by normals that are seen. */
static double reflect(const sc_facets *f, const double out[3], const double in[3], double *density)
{
    const double square = f->width * f->width, lambda = hidden(f, out);
    double half[3], normals;

    *density = 0;
    if (!(f->straight > 0))
        return 0;
    for (int i = 0; i < 3; i++)
        half[i] = out[i] + in[i];
    make_unit(half);
    normals = half[2] * half[2] * (square - 1) + 1;
    normals = square / (PI * normals * normals);
    *density = normals / (4 * out[2] * (1 + lambda));
    return fresnel(f, dot(out, half)) * normals / (4 * out[2] * (1 + lambda + hidden(f, in)));
}

/* @return the share of even light that comes to what is below the face from all around. */
static double let_in(const sc_reflector *s)
{
    const double face = 1 - s->face.straight, coat = 1 - s->coat.straight;
    const double face_more = s->face.along - s->face.straight;
    const double coat_more = s->coat.along - s->coat.straight;

    return face * coat - (coat_more * face + face_more * coat) / 21 + face_more * coat_more / 66;
}

double sc_reflector_share(const sc_reflector *s, const double in[3], double share[3])
{
    double coat_chance, face_density, coat_density, face, coat, through, below;
    const double chance = face_chance(s, &coat_chance);

    share[0] = share[1] = share[2] = 0;
    if (!(in[2] > 0))
        return 0;
    /* What is below gets what coat and face let in, and it comes out again through them, on the way
     * both to and fro; that is divided by the mean of one of them, so that white below the face
     * gives back all that comes in (Kelemen and Szirmay-Kalos 2001). */
    through = (1 - fresnel(&s->coat, s->out[2])) * (1 - fresnel(&s->coat, in[2]));
    below = (1 - fresnel(&s->face, s->out[2])) * (1 - fresnel(&s->face, in[2])) * through * in[2] /
            (PI * let_in(s));
    face = through * reflect(&s->face, s->out, in, &face_density);
    coat = reflect(&s->coat, s->out, in, &coat_density);
    for (int i = 0; i < 3; i++)
        share[i] = s->albedo[i] * below + face + coat;
    return chance * face_density + coat_chance * coat_density +
           (1 - chance - coat_chance) * in[2] / PI;
}

void sc_reflector_choose(const sc_reflector *s, double which, const double point[2], double in[3])
{
    double coat_chance;
    const double chance = face_chance(s, &coat_chance);
    const double width = which < chance ? s->face.width : s->coat.width;
    double seen[3] = {width * s->out[0], width * s->out[1], s->out[2]};
    double sine, cosine, half[3], around, along;

    if (!(which < chance + coat_chance)) {
        sc_cosine_direction(point, in);
        return;
    }
    /* A normal of those that are seen (Dupuy and Benyoub 2023). */
    make_unit(seen);
    sc_sine_cosine(2 * PI * point[0] - PI, &sine, &cosine);
    half[2] = (1 - point[1]) * (1 + seen[2]) - seen[2];
    around = sqrt(fmin(fmax(1 - half[2] * half[2], 0), 1));
    half[0] = (around * cosine + seen[0]) * width;
    half[1] = (around * sine + seen[1]) * width;
    half[2] += seen[2];
    make_unit(half);
    along = 2 * dot(s->out, half);
    for (int i = 0; i < 3; i++)
        in[i] = along * half[i] - s->out[i];
}
