/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: lighting and compositing, shared by all march templates. Only + - * / and sqrt
 * are used, which IEEE defines to the last bit, so that every compiler and processor gives the same
 * results. */
#ifndef SC_KERNEL_SHADE_H
#define SC_KERNEL_SHADE_H

#include "segcast/kernel.h"

/* A surface that takes less than this share of the light does not enter a ray's signature. */
#define SC_SIGNIFICANT (1.0f / 32)

/* A component of a ray's direction smaller than this never leads across a grid plane; the distance
 * of such planes is then SC_NEVER_MM times the distance in the grid. */
#define SC_PARALLEL 1e-20f
#define SC_NEVER_MM 1e30f

/* The numbers below were chosen by eye. */

/* Normals that point away from the eye by more than this (a cosine) are reversed; see sc_face_eye.
 */
#define SC_AVERTED_MAX 0.35f
/* Ambient occlusion: what the blurs of a flat surface fill one blur's width above it, and the width
 * of the soft edge of clip planes there, in widths of the blur. */
#define SC_FLAT_FILLED 0.2f
#define SC_OCCLUSION_CLIP_WIDTHS 1.5f
/* Shadows. How far the way to the light begins from the surface, along the normal and then towards
 * the light, in widths of the narrow blur; the most steps, and the light below which it is all
 * absorbed; how much must be filled to absorb at all, how fast that grows, and the most that a step
 * absorbs. */
#define SC_SHADOW_LIFT_WIDTHS 0.6f
#define SC_SHADOW_START_WIDTHS 1.3f
#define SC_SHADOW_STEPS_MAX 96
#define SC_SHADOW_DARK 0.02f
#define SC_SHADOW_FILLED_MIN 0.1f
#define SC_SHADOW_GAIN 2
#define SC_SHADOW_STEP_MAX 0.6f

/* The rim of a cut face, by how steeply the share of the surroundings that is filled falls along
 * it, 1 at a straight border of thick tissue: it begins at SC_RIM_FROM, is darkest where the fall
 * is steeper by SC_RIM_RANGE or more, and takes this share of the light there. */
#define SC_RIM_FROM 0.6f
#define SC_RIM_RANGE 0.34f
#define SC_RIM_DARK 0.45f
/* By how much that share differs across a straight border, from half a width of the blur on one
 * side to half a width on the other. */
#define SC_RIM_STRAIGHT 0.383f
/* The rim of a face of the volume, by how steeply the share of the face around that is visible
 * tissue falls, 1 at a straight border: as SC_RIM_FROM and SC_RIM_RANGE. The share is taken over
 * SC_FACE_RIM_VOXELS to either side. */
#define SC_FACE_RIM_FROM 0.2f
#define SC_FACE_RIM_RANGE 0.6f
enum { SC_FACE_RIM_VOXELS = 3, SC_FACE_RIM_TAPS = 2 * SC_FACE_RIM_VOXELS };

/* A point on a surface that is to be lit. */
typedef struct sc_spot {
    float point[3];   /* in grid coordinates, without the 1/2 of the voxel surface */
    float normal[3];  /* unit, RAS, towards the eye */
    const float *eye; /* [3] unit, RAS, towards the eye; borrowed from the ray */
    float depth_mm;   /* from the eye */
    float rim;        /* share of its light that the rim of a cut face takes there, 0 elsewhere */
    float around[3];  /* the light that has been gathered there, if has_around; else 0 */
    bool has_around;
} sc_spot;

static inline float sc_dot3(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* @p x limited to [0, 1]; NaN stays NaN. */
static inline float sc_clamp01(float x)
{
    return x < 0 ? 0 : x > 1 ? 1 : x;
}

/* The distances in mm from a ray's origin at which it enters and leaves the box of the march, to
 * @p near and @p far; it misses the box unless *near < *far. They may be negative. @p shift:
 * what the coordinates of the origin are higher than grid coordinates. @p inverse: 1 /
 * direction, and SC_NEVER_MM where the ray runs parallel to the faces. */
static inline void sc_clip_to_box(const sc_march *m, const float origin[3], const float inverse[3],
                                  float shift, float *near, float *far)
{
    *near = -HUGE_VALF;
    *far = HUGE_VALF;
    for (int i = 0; i < 3; i++) {
        const float low = (m->box_low[i] + shift - origin[i]) * inverse[i];
        const float high = (m->box_high[i] + shift - origin[i]) * inverse[i];
        const float in = low < high ? low : high, out = low < high ? high : low;

        *near = in > *near ? in : *near;
        *far = out < *far ? out : *far;
    }
}

/* Turn the unit normal @p n towards the eye, in place. One that points away only slightly, as on
 * a silhouette, is made perpendicular to the line of sight instead of being reversed, which
 * would make the pixel flash. @p eye: unit, towards the eye. */
static inline void sc_face_eye(const float eye[3], float n[3])
{
    const float toward = sc_dot3(n, eye);
    float length;

    if (toward >= 0)
        return;
    if (toward < -SC_AVERTED_MAX) {
        for (int i = 0; i < 3; i++)
            n[i] = -n[i];
        return;
    }
    for (int i = 0; i < 3; i++)
        n[i] -= toward * eye[i];
    length = sqrtf(sc_dot3(n, n));
    for (int i = 0; i < 3; i++)
        n[i] /= length;
}

/* The normal of a face of the volume across axis @p axis, unit, RAS, towards the eye, to @p n. */
static inline void sc_face_normal(const sc_march *m, int axis, const float eye[3], float n[3])
{
    const float *row = m->grid_per_mm[axis];
    const float length = sqrtf(sc_dot3(row, row));
    const float side = sc_dot3(row, eye) < 0 ? -length : length;

    for (int i = 0; i < 3; i++)
        n[i] = row[i] / side;
}

/* The record whose gradient is the normal of the boundary voxel at vertex (x, y, z): that of the
 * outer field, else that of the inner one; 0 if it has neither. */
static inline uint32_t sc_voxel_record(const sc_prepared *v, int x, int y, int z)
{
    const size_t brick = sc_brick_index(v->bricks, sc_brick_of(x), sc_brick_of(y), sc_brick_of(z));
    const int bit = sc_brick_bit(x, y, z);
    const uint32_t outer = sc_border_record(&v->outer, brick, bit);

    return outer ? outer : sc_border_record(&v->inner, brick, bit);
}

/* The normal of a boundary voxel of the voxel surface, unit, RAS, to @p n: the direction of its
 * vertex record @p record (0: there is none), turned outward where the voxel (x, y, z) lies at the
 * border of the volume; that of the eye if there is neither. */
static inline void sc_voxel_normal(const sc_march *m, uint32_t record, const int voxel[3],
                                   const float eye[3], float n[3])
{
    float length;

    n[0] = n[1] = n[2] = 0;
    if (record)
        sc_record_normal(record, n);
    for (int i = 0; i < 3; i++) {
        const float *row = m->grid_per_mm[i];
        const float across = SC_RECORD_LENGTH_STEPS / sqrtf(sc_dot3(row, row));

        for (int k = 0; k < 3 && voxel[i] == 0; k++)
            n[k] -= row[k] * across;
        for (int k = 0; k < 3 && voxel[i] == m->volume->size[i] - 1; k++)
            n[k] += row[k] * across;
    }
    length = sqrtf(sc_dot3(n, n));
    for (int i = 0; i < 3; i++)
        n[i] = length > 0 ? n[i] / length : eye[i];
}

/* Opacity of a surface of @p label at the point @p at of the cell @p q, before sc_edge_alpha: where
 * it follows the thickness, interpolated between the corners that carry the label; else, and where
 * no corner has a weight, the tissue's boundary_alpha. */
static inline float sc_surface_alpha(const sc_march *m, const int q[3], uint32_t label,
                                     const float at[3])
{
    const sc_prepared *v = m->volume;
    float sum = 0, weights = 0;

    if (!m->tissues[label].by_thickness || !v->thickness)
        return m->tissues[label].boundary_alpha;
    for (int i = 0; i < 8; i++) {
        const int x = q[0] + (i & 1), y = q[1] + (i >> 1 & 1), z = q[2] + (i >> 2);
        const float weight =
            (i & 1 ? at[0] : 1 - at[0]) * (i & 2 ? at[1] : 1 - at[1]) * (i & 4 ? at[2] : 1 - at[2]);

        if (sc_id_at_vertex(v, x, y, z) != label || !sc_is_near(v, x, y, z))
            continue;
        weights += weight;
        sum += weight * m->thickness_alpha[v->thickness[sc_near_index(v, x, y, z)]];
    }
    return weights > 0 ? sum / weights * m->tissues[label].thickness_factor
                       : m->tissues[label].boundary_alpha;
}

/* @p x to the power @p n, by squaring; 1 for n = 0. n must not be negative. */
static inline float sc_power(float x, int n)
{
    float result = 1;

    for (; n; n >>= 1) {
        if (n & 1)
            result *= x;
        x *= x;
    }
    return result;
}

/* Roughly the share, 0 to 1, of the surroundings of a point (in grid coordinates) that the clip
 * planes have left; each plane has a soft edge, @p width_mm wide on either side. 1 without
 * planes. */
static inline float sc_share_kept(const sc_march *m, const float point[3], float width_mm)
{
    float kept = 1, removed = 1;

    for (int i = 0; i < m->planes.count; i++) {
        const float *p = m->planes.equations[i];
        const float mm = p[0] * point[0] + p[1] * point[1] + p[2] * point[2] + p[3];
        const float share = sc_clamp01(0.5f + 0.5f * mm / width_mm);

        kept *= share;
        removed *= 1 - share;
    }
    return m->planes.cut_away && m->planes.count ? 1 - removed : kept;
}

/* How much of the surroundings of a point (in grid coordinates) is filled with tissue, 0 to 1,
 * interpolated between the bricks of m->occlusion, which must not be NULL; 0 beyond them. @p
 * which: 0: by the narrow blur, 1: by the wide one. */
static inline float sc_filled(const sc_march *m, const float point[3], int which)
{
    const sc_occlusion *o = m->occlusion;
    const size_t row = (size_t)o->size[0], layer = row * (size_t)o->size[1];
    float at[3], upper[3], sum = 0;
    size_t base;
    int low[3];

    for (int i = 0; i < 3; i++) {
        at[i] = point[i] * (1.0f / SC_BRICK) + o->brick_offset;
        if (!(at[i] >= 0 && at[i] < (float)(o->size[i] - 1)))
            return 0;
        low[i] = (int)at[i];
        upper[i] = at[i] - (float)low[i];
    }
    base = (size_t)low[2] * layer + (size_t)low[1] * row + (size_t)low[0];
    for (int corner = 0; corner < 8; corner++) {
        const float weight = (corner & 1 ? upper[0] : 1 - upper[0]) *
                             (corner & 2 ? upper[1] : 1 - upper[1]) *
                             (corner & 4 ? upper[2] : 1 - upper[2]);
        const size_t index =
            base + (size_t)(corner & 1) + (corner & 2 ? row : 0) + (corner & 4 ? layer : 0);

        sum += weight * (float)o->filled[index][which];
    }
    return sum * (1.0f / 255);
}

/* The point, in grid coordinates, that lies @p mm from @p point in a direction in RAS, to @p
 * out. */
static inline void sc_move(const sc_march *m, const float point[3], const float direction[3],
                           float mm, float out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = point[i] + mm * sc_dot3(m->grid_per_mm[i], direction);
}

/* How much of the light from all around reaches a spot, 0 to 1: what is filled just above it by
 * either blur takes away, beyond what the blur of a flat surface itself leaves there
 * (SC_FLAT_FILLED). m->occlusion must not be NULL. */
static inline float sc_openness(const sc_march *m, const sc_spot *spot)
{
    const sc_occlusion *o = m->occlusion;
    float open = 1;

    for (int which = 0; which < 2; which++) {
        const float width_mm = (float)(which ? o->wide_mm : o->narrow_mm);
        float above[3], filled;

        sc_move(m, spot->point, spot->normal, width_mm, above);
        filled = sc_filled(m, above, which) *
                 sc_share_kept(m, above, SC_OCCLUSION_CLIP_WIDTHS * width_mm);
        open *= 1 - sc_clamp01((filled - SC_FLAT_FILLED) * (1 / (1 - SC_FLAT_FILLED)));
    }
    return open;
}

/* How much of the key light reaches a spot, 0 to 1: the narrow blur is sampled along the way to
 * the light, and tissue there absorbs light. Only the share m->light.shadow of the absorbed light
 * is taken away; with 1 the result is the same, to the last bit, as without that factor.
 * m->occlusion must not be NULL. */
static inline float sc_unshadowed(const sc_march *m, const sc_spot *spot)
{
    const sc_occlusion *o = m->occlusion;
    const float step_mm = (float)o->mm_per_step,
                start_mm = SC_SHADOW_START_WIDTHS * (float)o->narrow_mm;
    float through = 1, point[3];

    sc_move(m, spot->point, spot->normal, SC_SHADOW_LIFT_WIDTHS * (float)o->narrow_mm, point);
    for (int k = 0; k < SC_SHADOW_STEPS_MAX && through > SC_SHADOW_DARK; k++) {
        float at[3], filled;

        sc_move(m, point, m->light.key_direction, start_mm + (float)k * step_mm, at);
        filled = sc_filled(m, at, 0);
        if (filled > SC_SHADOW_FILLED_MIN)
            through *= 1 - SC_SHADOW_STEP_MAX *
                               sc_clamp01((filled - SC_SHADOW_FILLED_MIN) * SC_SHADOW_GAIN) *
                               sc_share_kept(m, at, (float)o->narrow_mm);
    }
    return through + (1 - m->light.shadow) * (1 - through);
}

/* Blend the linear colour @p rgb, in place, with the background by degree: by nothing up to
 * cue_near_mm from the eye, by the share light->cue from cue_far_mm on. */
static inline void sc_depth_cue(const sc_march_light *light, float depth_mm, float rgb[3])
{
    const float far = (depth_mm - light->cue_near_mm) / (light->cue_far_mm - light->cue_near_mm);
    const float share = light->cue * sc_clamp01(far);

    for (int i = 0; i < 3; i++)
        rgb[i] += share * (light->cue_rgb[i] - rgb[i]);
}

/* The light of the sky and of the lamp that reaches a spot, to @p out: the share @p known of what
 * has been gathered; the rest is that of the whole sky above the surface, as far as the spot is
 * open. @return how open, 0 to 1, it is by both: by the component of which least has been gathered.
 * @param open how open it is by the occlusion. @param lit set to the share of the lamp's light, at
 * most @p lamp, that arrives: all if half of it is there beside the light of the whole sky. */
static inline float sc_light_of_sky(const sc_march *m, const sc_spot *spot, float known, float open,
                                    float lamp, float *lit, float out[3])
{
    const sc_march_light *l = &m->light;
    float whole = l->sky * (SC_SKY_MEAN + SC_SKY_UP * (2.0f / 3) * spot->normal[2]);
    float least = spot->around[0], beyond;

    for (int i = 0; i < 3; i++) {
        const float mapped = l->sky * (l->around[i][0] + sc_dot3(l->around[i] + 1, spot->normal));

        whole = !l->has_map ? whole : mapped > 1e-6f ? mapped : 1e-6f;
        least = spot->around[i] < least ? spot->around[i] : least;
        out[i] = known * spot->around[i] + (1 - known) * (whole * open);
    }
    beyond = 2 * (least - whole);
    *lit = known * (beyond < lamp ? sc_clamp01(beyond / lamp) : 1) + (1 - known);
    return known * sc_clamp01(least / whole) + (1 - known) * open;
}

/* The linear colour of a tissue at a spot, to @p out: Blinn-Phong with a key light, a fill light
 * and one at the eye, then occlusion, shadow and depth cue as far as the frame has them. The
 * tissue's plain colour if the frame is unlit. */
static inline void sc_light(const sc_march *m, const sc_march_tissue *tissue, const sc_spot *spot,
                            float out[3])
{
    const sc_march_light *l = &m->light;
    const float known = spot->has_around ? m->around_share : 0;
    float key, fill, head, open = 1, lit = 1, h[3], shine = 0, length, sky[3] = {0};
    float near = 1, back = 1; /* of the light from the eye: what comes, and what is thrown back */

    if (l->flat) {
        for (int i = 0; i < 3; i++)
            out[i] = tissue->rgb[i];
        return;
    }
    key = sc_dot3(spot->normal, l->key_direction);
    fill = sc_dot3(spot->normal, l->fill_direction);
    head = sc_dot3(spot->normal, spot->eye);
    key = key > 0 ? key : 0;
    fill = fill > 0 ? fill : 0;
    head = head > 0 ? head : 0;
    if (m->occlusion && l->occlusion > 0 && known < 1)
        open = 1 - l->occlusion * (1 - sc_openness(m, spot));
    if (l->sky > 0)
        open = sc_light_of_sky(m, spot, known, open, l->key * key, &lit, sky);
    for (int i = 0; i < 3 && l->sky > 0; i++) /* the eye sees no shadow of the light beside it */
        sky[i] += l->head * head * (known * (1 - open));
    if (m->occlusion && l->shadow > 0 && key > 0)
        lit *= sc_unshadowed(m, spot);
    if (l->lamp_mm > 0) {
        near =
            l->lamp_mm * l->lamp_mm / (l->lamp_mm * l->lamp_mm + spot->depth_mm * spot->depth_mm);
        back = sqrtf(near);
    }
    for (int i = 0; i < 3; i++)
        h[i] = l->key_direction[i] + spot->eye[i];
    length = sqrtf(sc_dot3(h, h));
    if (length > 0 && key > 0)
        shine = sc_dot3(spot->normal, h) / length;
    shine = shine > 0 ? sc_power(shine, tissue->shininess) * near : 0;
    key *= 1 - known; /* the rest of the key light has been gathered */
    for (int i = 0; i < 3; i++) {
        const float around =
            (l->ambient * back + l->fill * fill + l->head * (head * near)) * open + sky[i];

        out[i] = tissue->rgb[i] * (1 - spot->rim) *
                     (around + l->key * key * lit * (0.5f + 0.5f * open)) +
                 tissue->specular * shine * lit * open;
    }
    if (l->cue > 0)
        sc_depth_cue(l, spot->depth_mm, out);
}

/* Two unit vectors, RAS, across the unit vector @p n and across each other, to @p out. */
static inline void sc_tangents(const float n[3], float out[2][3])
{
    const int least = n[0] * n[0] < n[1] * n[1]   ? n[0] * n[0] < n[2] * n[2] ? 0 : 2
                      : n[1] * n[1] < n[2] * n[2] ? 1
                                                  : 2;
    const int a = (least + 1) % 3, b = (least + 2) % 3;
    const float length = sqrtf(n[a] * n[a] + n[b] * n[b]);

    out[0][least] = 0;
    out[0][a] = n[b] / length;
    out[0][b] = -n[a] / length;
    for (int i = 0; i < 3; i++)
        out[1][i] = n[(i + 1) % 3] * out[0][(i + 2) % 3] - n[(i + 2) % 3] * out[0][(i + 1) % 3];
}

/* How dark the rim of a cut face is at a spot, 0 to SC_RIM_DARK: by how steeply what is filled
 * falls along the face. In the middle of a thin wall it falls to neither side, and at the borders
 * of one less steeply than at those of thick tissue; so thin walls keep their colour. m->occlusion
 * must not be NULL. */
static inline float sc_rim(const sc_march *m, const sc_march_tissue *tissue, const sc_spot *spot)
{
    const float solid = tissue->boundary_alpha > 0.05f ? tissue->boundary_alpha : 0.05f;
    const float half_mm = 0.5f * (float)m->occlusion->narrow_mm;
    float tangents[2][3], square = 0;

    sc_tangents(spot->normal, tangents);
    for (int i = 0; i < 2; i++) {
        float ends[2][3], fall;

        sc_move(m, spot->point, tangents[i], half_mm, ends[0]);
        sc_move(m, spot->point, tangents[i], -half_mm, ends[1]);
        fall = sc_filled(m, ends[0], 0) - sc_filled(m, ends[1], 0);
        square += fall * fall;
    }
    return SC_RIM_DARK * m->light.occlusion *
           sc_clamp01((sqrtf(square) / (SC_RIM_STRAIGHT * solid) - SC_RIM_FROM) *
                      (1 / SC_RIM_RANGE));
}

/* Are the rims of cut faces dark in this frame? */
static inline bool sc_has_rims(const sc_march *m)
{
    return m->occlusion && m->light.occlusion > 0 && !m->light.flat;
}

/* The vertices around the coordinate @p at, the first of which is *@p low, in the window (1 -
 * d^2 / r^2)^2 of the distance d: their weights, and the changes of these with @p at. */
static inline void sc_face_window(float at, int *low, float weights[SC_FACE_RIM_TAPS],
                                  float changes[SC_FACE_RIM_TAPS])
{
    const float scale = 1.0f / (SC_FACE_RIM_VOXELS * SC_FACE_RIM_VOXELS);

    *low = (int)floorf(at) - (SC_FACE_RIM_VOXELS - 1);
    for (int i = 0; i < SC_FACE_RIM_TAPS; i++) {
        const float d = (float)(*low + i) - at, left = 1 - d * d * scale;

        weights[i] = left * left;
        changes[i] = 4 * scale * d * left;
    }
}

/* How dark the rim is at a point on a face of the volume across axis @p axis, 0 to SC_RIM_DARK. A
 * surface often meets the face at a flat angle, so that sc_rim would see no rim; here the labels of
 * the face alone decide, those of the voxels that touch it. */
static inline float sc_face_rim(const sc_march *m, int axis, const float point[3])
{
    const sc_prepared *v = m->volume;
    const int across = axis == 0 ? 1 : 0, up = axis == 2 ? 1 : 2;
    float weights[2][SC_FACE_RIM_TAPS], changes[2][SC_FACE_RIM_TAPS], slope[2] = {0, 0};
    int low[2], at[3];

    at[axis] = point[axis] < 0.5f * (float)(v->size[axis] + 1) ? 1 : v->size[axis];
    sc_face_window(point[across], &low[0], weights[0], changes[0]);
    sc_face_window(point[up], &low[1], weights[1], changes[1]);
    for (int j = 0; j < SC_FACE_RIM_TAPS; j++) {
        float share = 0, change = 0;

        at[up] = low[1] + j;
        for (int i = 0; i < SC_FACE_RIM_TAPS; i++) {
            at[across] = low[0] + i;
            if (m->tissues[sc_id_at_vertex(v, at[0], at[1], at[2])].show & SC_SHOW_BOUNDARY) {
                share += weights[0][i];
                change += changes[0][i];
            }
        }
        slope[0] += change * weights[1][j];
        slope[1] += share * changes[1][j];
    }
    /* At a straight border the changes add up to 1, and the weights to 16 / 15 of the radius. */
    return SC_RIM_DARK * m->light.occlusion *
           sc_clamp01((sqrtf(slope[0] * slope[0] + slope[1] * slope[1]) *
                           (15.0f / (16 * SC_FACE_RIM_VOXELS)) -
                       SC_FACE_RIM_FROM) *
                      (1 / SC_FACE_RIM_RANGE));
}

/* The tone of a grey volume at a point in grid coordinates of the labels, to @p tone. The value is
 * interpolated first, and then brought into the window, so that borders stay where they are however
 * narrow it is. @return false outside of the outermost faces of its voxels. */
static inline bool sc_grey_tone(const sc_march_grey *g, const float point[3], float *tone)
{
    const size_t steps[3] = {1, (size_t)g->size[0], (size_t)g->size[0] * (size_t)g->size[1]};
    float share[3], sum = 0, place;
    size_t at = 0;
    int step;

    for (int i = 0; i < 3; i++) {
        const float *row = g->from_grid[i], last = (float)(g->size[i] - 1);
        float x = row[0] * point[0] + row[1] * point[1] + row[2] * point[2] + row[3];
        int low;

        if (!(x >= -0.5f && x <= last + 0.5f))
            return false;
        x = x < 0 ? 0 : x > last ? last : x; /* half a voxel beyond the outermost centres */
        low = (int)x;
        low = low > 0 && low == g->size[i] - 1 ? low - 1 : low;
        share[i] = x - (float)low;
        at += (size_t)low * steps[i];
    }
    for (int k = 0; k < 8; k++) {
        size_t corner = at;
        float weight = 1;

        for (int i = 0; i < 3; i++) {
            weight *= k >> i & 1 ? share[i] : 1 - share[i];
            corner += k >> i & 1 && g->size[i] > 1 ? steps[i] : 0;
        }
        sum += weight * (float)g->codes[corner];
    }
    place = sc_clamp01((sum - g->black) * g->white_less) * SC_GREY_STEPS;
    step = place < SC_GREY_STEPS ? (int)place : SC_GREY_STEPS - 1;
    *tone = g->tones[step] + (place - (float)step) * (g->tones[step + 1] - g->tones[step]);
    return true;
}

/* Write to @p own what a tissue is on a cut face that shows a grey volume: its colour is mixed with
 * the tone there, as contributions are, and it shines less, because a highlight is no value.
 * @return false, with @p own untouched, where there is no grey volume. */
static inline bool sc_grey_tissue(const sc_march *m, const sc_march_tissue *tissue,
                                  const float point[3], sc_march_tissue *own)
{
    float tone;

    if (!sc_grey_tone(m->cut_faces.grey, point, &tone))
        return false;
    *own = *tissue;
    for (int i = 0; i < 3; i++) {
        const float mixed =
            (1 - m->cut_faces.grey_share) * sqrtf(tissue->rgb[i]) + m->cut_faces.grey_share * tone;

        own->rgb[i] = mixed * mixed;
    }
    own->specular = (1 - m->cut_faces.grey_share) * tissue->specular;
    return true;
}

/* The linear colour of a cut face of a tissue, to @p out: lit like a surface, with the unit normal
 * of the clip plane, towards the eye, as that of the spot, and darker along its rim, which the
 * spot tells. Slices have the plain colour. Where there is a grey volume, it has its share of the
 * colour. @return whether there is one. */
static inline bool sc_light_cut(const sc_march *m, const sc_march_tissue *tissue,
                                const sc_spot *spot, float out[3])
{
    sc_march_tissue own;
    const bool shows_grey = m->cut_faces.grey && sc_grey_tissue(m, tissue, spot->point, &own);

    if (shows_grey)
        tissue = &own;
    if (m->cut_faces.only || m->light.flat) {
        for (int i = 0; i < 3; i++)
            out[i] = tissue->rgb[i];
        if (m->light.cue > 0)
            sc_depth_cue(&m->light, spot->depth_mm, out);
        return shows_grey;
    }
    sc_light(m, tissue, spot, out);
    return shows_grey;
}

/* Opacity of a surface seen at an angle, between @p alpha and 1: the flatter a ray meets a thin
 * shell, the longer its way through it. Opacities 0 and 1 stay as they are. @p toward: cosine
 * between normal and eye, of either sign. */
static inline float sc_edge_alpha(const sc_march_light *light, float alpha, float toward)
{
    const float side = 1 - (toward > 0 ? toward : -toward);
    const float grows = 4 * alpha < 1 ? 4 * alpha : 1;

    return 1 - (1 - alpha) * (1 - light->edges * grows * side * side * side);
}

/* Composite a surface of linear colour @p rgb behind what the ray has met so far (the over
 * operator, front to back): adds to light->rgb and lowers light->transmittance. Square roots are
 * blended, nearly as the eye sees them and as the levels of sRGB are: in linear light a half-opaque
 * tissue on white looks washed out, because half of the light is three fourths of the lightness.
 * Nothing is added behind what is opaque, which only rays meet that do not end there. @param
 * ends_below of the ray: if it is not 0, the surface replaces what the ray has met. */
static inline void sc_blend(sc_radiance *light, const float rgb[3], float alpha, float ends_below)
{
    const float share = ends_below > 0 ? 1 : light->transmittance * alpha;

    if (light->transmittance < SC_OPAQUE)
        return;
    for (int i = 0; i < 3; i++)
        light->rgb[i] = (ends_below > 0 ? 0 : light->rgb[i]) + share * sqrtf(rgb[i]);
    light->transmittance *= 1 - alpha;
}

/* Note a surface in light->signature, and the first one in light->label, depth_mm and normal as
 * well. A surface that takes less than SC_SIGNIFICANT of the light is ignored, but of a ray with
 * @p ends_below the last one is noted, whatever it takes. @p n: unit, towards the eye. To be called
 * before sc_blend, which lowers the transmittance. */
static inline void sc_remember_surface(sc_radiance *light, uint32_t label, float alpha,
                                       float depth_mm, const float n[3], float ends_below)
{
    if (!(ends_below > 0) && light->transmittance * alpha < SC_SIGNIFICANT)
        return;
    light->signature = light->signature * 31 + label + 1;
    if (light->label && !(ends_below > 0))
        return;
    light->label = label;
    light->depth_mm = depth_mm;
    for (int i = 0; i < 3; i++)
        light->normal[i] = n[i];
}

#endif
