/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to kernel: shade.h for one ray per SIMD lane. Each function v_x does the same operations
 * in the same order as sc_x of shade.h, where it is described, so that every lane gets the same
 * bits. In all of them @p on are the lanes in use: others read no memory, and unless a comment says
 * what they get, their results are meaningless. Labels are dense ids; colours are linear. */
#ifndef SC_KERNEL_LANES_SHADE_H
#define SC_KERNEL_LANES_SHADE_H

#include "lanes/lanes.h"
#include "shade.h"

#include <stddef.h>

/* What the ray of each lane brings back: see sc_radiance. */
typedef struct v_radiance {
    vf rgb[3], transmittance, depth_mm, normal[3];
    vi label, signature;
} v_radiance;

/* Points to be lit, and those parts of the light that do not depend on the tissue: a crossing
 * lights two tissues at the same point. The caller sets point, normal, eye, depth_mm and rim;
 * v_light_spot sets the rest. */
typedef struct v_spot {
    vf point[3], normal[3], eye[3], depth_mm, rim; /* see sc_spot */
    vf around[3]; /* in the lanes of has_around, else 0; v_light_spot makes it sc_light_of_sky */
    vm has_around;
    vf key, fill, head; /* cosines between the normal and the lights */
    vf open, lit;       /* how much of the light from all around, and of the key light, arrives */
    vf shine;           /* cosine of the highlight */
} v_spot;

/* The radiance with which every ray begins: no light, transmittance 1, no surface met. */
static inline v_radiance v_no_light(void)
{
    return (v_radiance){.transmittance = f_set(1), .depth_mm = f_set(HUGE_VALF)};
}

/* The radiance of one lane. */
static inline sc_radiance v_radiance_get_lane(const v_radiance *light, int lane)
{
    sc_radiance out = {.transmittance = light->transmittance[lane],
                       .depth_mm = light->depth_mm[lane],
                       .label = (uint32_t)light->label[lane],
                       .signature = (uint32_t)light->signature[lane]};

    for (int i = 0; i < 3; i++) {
        out.rgb[i] = light->rgb[i][lane];
        out.normal[i] = light->normal[i][lane];
    }
    return out;
}

/* Replace the radiance of one lane; the others stay as they are. */
static inline void v_radiance_set_lane(v_radiance *light, int lane, const sc_radiance *from)
{
    light->transmittance[lane] = from->transmittance;
    light->depth_mm[lane] = from->depth_mm;
    light->label[lane] = (int32_t)from->label;
    light->signature[lane] = (int32_t)from->signature;
    for (int i = 0; i < 3; i++) {
        light->rgb[i][lane] = from->rgb[i];
        light->normal[i][lane] = from->normal[i];
    }
}

/* Replace the radiance of the first @p count lanes. */
static inline void v_radiance_read(v_radiance *light, const sc_radiance *from, int count)
{
    for (int lane = 0; lane < count; lane++)
        v_radiance_set_lane(light, lane, &from[lane]);
}

/* The four bytes at @p offset of the sc_march_tissue of each label; 0 in lanes outside of @p on. */
static inline vi v_tissue_word(const sc_march *m, vi label, size_t offset, vm on)
{
    return i_gather(m->tissues, label * (int32_t)sizeof(sc_march_tissue) + (int32_t)offset, on);
}

/* The float at @p offset of the sc_march_tissue of each label; 0 in lanes outside of @p on. */
static inline vf v_tissue_floats(const sc_march *m, vi label, size_t offset, vm on)
{
    return (vf)v_tissue_word(m, label, offset, on);
}

/* show (lowest byte), clip_set and by_thickness of the tissues, read as one word, for the three
 * functions below; 0 in lanes outside of @p on. */
static inline vi v_tissue_bytes(const sc_march *m, vi label, vm on)
{
    return v_tissue_word(m, label, offsetof(sc_march_tissue, show), on);
}
_Static_assert(offsetof(sc_march_tissue, clip_set) == offsetof(sc_march_tissue, show) + 1 &&
                   offsetof(sc_march_tissue, by_thickness) == offsetof(sc_march_tissue, show) + 2 &&
                   sizeof(bool) == 1 &&
                   offsetof(sc_march_tissue, show) + 4 <= sizeof(sc_march_tissue),
               "v_tissue_bytes reads these three members, and no more than the structure");
_Static_assert(sizeof(sc_march_tissue) * 65536 < INT32_MAX,
               "offsets of tissues with labels of 16 bits fit 31 bits");

/* Lanes of @p on whose tissue shows @p kind, one of SC_SHOW_*. @param tissue_bytes of
 * v_tissue_bytes. */
static inline vm v_shows(vi tissue_bytes, int kind, vm on)
{
    return m_without(on, i_equal(tissue_bytes & kind, i_set(0)));
}

/* Lanes of @p on whose tissue belongs to one of the clip sets @p kept (bit i for clip set i). */
static inline vm v_in_kept_set(vi tissue_bytes, vi kept, vm on)
{
    return m_without(on, i_equal(kept >> (tissue_bytes >> 8 & 255) & 1, i_set(0)));
}

/* Lanes of @p on whose tissue has an opacity that follows its thickness. */
static inline vm v_by_thickness(vi tissue_bytes, vm on)
{
    return m_without(on, i_equal(tissue_bytes >> 16 & 255, i_set(0)));
}

_Static_assert(sizeof(((sc_ray *)0)->origin) == 3 * sizeof(float) &&
                   sizeof(((sc_ray *)0)->direction) == 3 * sizeof(float) &&
                   sizeof(((sc_ray *)0)->toward_eye) == 3 * sizeof(float) &&
                   sizeof(((sc_ray *)0)->base_mm) == sizeof(float) &&
                   sizeof(((sc_ray_part *)0)->begin_mm) == sizeof(float) &&
                   sizeof(((sc_ray_part *)0)->end_mm) == sizeof(float),
               "v_ray_floats reads these members as floats");
/* The float at @p offset of rays[lane] in each lane; 0 in lanes outside of @p on. */
static inline vf v_ray_floats(const sc_ray *rays, size_t offset, vm on)
{
    vi at;

    for (int lane = 0; lane < LANES; lane++)
        at[lane] = lane * (int32_t)sizeof(sc_ray);
    return f_gather(rays, at + (int32_t)offset, on);
}

/* The rays of a packet: members of sc_ray, and what a template derives from them. */
typedef struct v_ray {
    vf origin[3], direction[3], eye[3], base_mm; /* eye: sc_ray.toward_eye */
    vf ends_below;                               /* the transmittance below which the rays end */
    vm seeks;             /* those that look for the surface at which they do: see sc_ray */
    vf inverse[3];        /* 1 / direction */
    vm forward[3];        /* the coordinate grows along the ray, or does not change */
    vf mm_per_city_block; /* way by which the city-block distance from its begin grows by 1 */
} v_ray;

/* Load rays, but for what is derived. */
static inline void v_load_rays(const sc_march *m, const sc_ray *rays, vm on, v_ray *out)
{
    for (int i = 0; i < 3; i++) {
        const size_t at = sizeof(float) * (size_t)i;

        out->origin[i] = v_ray_floats(rays, offsetof(sc_ray, origin) + at, on);
        out->direction[i] = v_ray_floats(rays, offsetof(sc_ray, direction) + at, on);
        out->eye[i] = v_ray_floats(rays, offsetof(sc_ray, toward_eye) + at, on);
    }
    out->base_mm = v_ray_floats(rays, offsetof(sc_ray, base_mm), on);
    out->ends_below = v_ray_floats(rays, offsetof(sc_ray, ends_below), on);
    out->seeks = f_below(f_set(0), out->ends_below);
    out->ends_below = f_pick(f_below(out->ends_below, f_set(m->opaque_below)),
                             f_set(m->opaque_below), out->ends_below);
}

/* The 32 bits at @p offset of ways[lane] in each lane; 0 in lanes outside of @p on. */
static inline vi v_way_word(const sc_way *ways, size_t offset, vm on)
{
    vi at;

    for (int lane = 0; lane < LANES; lane++)
        at[lane] = lane * (int32_t)sizeof(sc_way);
    return i_gather(ways, at + (int32_t)offset, on);
}

/* Let rays that are followed piece by piece pass what they meet at the distances @p depth_mm from
 * the eye, or stop before it. @param limit_mm updated. @return the lanes of @p on that pass. */
static inline vm v_pass(sc_way *ways, vf depth_mm, vf *limit_mm, vm on)
{
    const vm pass = m_and(on, f_below(depth_mm, *limit_mm));

    for (uint32_t left = m_bits(pass); left; left &= left - 1)
        ways[__builtin_ctz(left)].passed = true;
    for (uint32_t left = m_bits(m_without(on, pass)); left; left &= left - 1) {
        const int lane = __builtin_ctz(left);

        ways[lane].next_mm = depth_mm[lane];
    }
    *limit_mm = f_pick(pass, (vf)v_way_word(ways, offsetof(sc_way, limit_mm), pass), *limit_mm);
    return pass;
}

/* Begin the parts of ways that a call of the kernel follows. @return how far they go for now. */
static inline vf v_begin_ways(sc_way *ways, int count, vm on)
{
    for (int lane = 0; lane < count; lane++) {
        ways[lane].next_mm = HUGE_VALF;
        ways[lane].passed = false;
    }
    return (vf)v_way_word(ways, offsetof(sc_way, before_mm), on);
}

/* See sc_clip_to_box: the distances in mm at which the rays enter and leave the box of the
 * march, to @p near and @p far. */
static inline void v_clip_to_box(const sc_march *m, const vf origin[3], const vf inverse[3],
                                 float shift, vf *near, vf *far)
{
    *near = f_set(-HUGE_VALF);
    *far = f_set(HUGE_VALF);
    for (int i = 0; i < 3; i++) {
        const vf low = (m->box_low[i] + shift - origin[i]) * inverse[i];
        const vf high = (m->box_high[i] + shift - origin[i]) * inverse[i];
        const vm upward = f_below(low, high);
        const vf in = f_pick(upward, low, high), out = f_pick(upward, high, low);

        *near = f_pick(f_below(*near, in), in, *near);
        *far = f_pick(f_below(out, *far), out, *far);
    }
}

/* See sc_face_eye: turn the unit normals @p n towards the eye, in place, in all lanes. */
static inline void v_face_eye(const vf eye[3], vf n[3])
{
    const vf toward = f_dot(n, eye);
    const vm over = f_below(toward, f_set(-SC_AVERTED_MAX)), averted = f_below(toward, f_set(0));
    vf flat[3], length;

    if (!m_any(averted))
        return;
    for (int i = 0; i < 3; i++)
        flat[i] = n[i] - toward * eye[i];
    length = f_length(flat);
    for (int i = 0; i < 3; i++)
        n[i] = f_pick(averted, f_pick(over, -n[i], flat[i] / length), n[i]);
}

/* See sc_power: x to the power n; 1 in lanes where n is 0. n must not be negative. */
static inline vf v_power(vf x, vi n)
{
    vf result = f_set(1);

    for (; m_any(i_below(i_set(0), n)); n >>= 1) {
        result = f_pick(i_equal(n & 1, i_set(1)), result * x, result);
        x *= x;
    }
    return result;
}

/* See sc_share_kept: the share of the surroundings of a point that the clip planes have left. */
static inline vf v_share_kept(const sc_march *m, const vf point[3], float width_mm)
{
    vf kept = f_set(1), removed = f_set(1);

    for (int i = 0; i < m->planes.count; i++) {
        const float *p = m->planes.equations[i];
        const vf mm = p[0] * point[0] + p[1] * point[1] + p[2] * point[2] + p[3];
        const vf share = f_clamp01(0.5f + 0.5f * mm / width_mm);

        kept *= share;
        removed *= 1 - share;
    }
    return m->planes.cut_away && m->planes.count ? 1 - removed : kept;
}

_Static_assert(sizeof(((sc_occlusion *)0)->filled[0]) == 2,
               "v_filled reads pairs of bytes: narrow in the lower, wide in the upper");
/* See sc_filled: how much of the surroundings of a point is filled, 0 to 1, by the narrow (@p
 * which 0) or the wide blur (1); 0 in lanes outside of @p on. */
static inline vf v_filled(const sc_march *m, const vf point[3], int which, vm on)
{
    const sc_occlusion *o = m->occlusion;
    const int row = o->size[0], layer = row * o->size[1];
    vf upper[3], sum = {0};
    vi base = {0};

    for (int i = 0; i < 3; i++) {
        const vf at = point[i] * (1.0f / SC_BRICK) + o->brick_offset;
        const vi low = i_of(at);

        on = m_and(on, m_and(f_at_most(f_set(0), at), f_below(at, f_set((float)(o->size[i] - 1)))));
        upper[i] = at - f_of(low);
        base += low * (i == 0 ? 1 : i == 1 ? row : layer);
    }
    for (int corner = 0; corner < 8; corner++) {
        const vf weight = (corner & 1 ? upper[0] : 1 - upper[0]) *
                          (corner & 2 ? upper[1] : 1 - upper[1]) *
                          (corner & 4 ? upper[2] : 1 - upper[2]);
        const int step = (corner & 1) + (corner & 2 ? row : 0) + (corner & 4 ? layer : 0);

        sum += weight * f_of(i_gather(o->filled, 2 * (base + step), on) >> (8 * which) & 255);
    }
    return f_pick(on, sum * (1.0f / 255), f_set(0));
}

/* See sc_move: the points that lie @p mm from @p point in a direction in RAS, to @p out. */
static inline void v_move(const sc_march *m, const vf point[3], const vf direction[3], vf mm,
                          vf out[3])
{
    for (int i = 0; i < 3; i++) {
        const float *row = m->grid_per_mm[i];

        out[i] =
            point[i] + mm * (row[0] * direction[0] + row[1] * direction[1] + row[2] * direction[2]);
    }
}

/* See sc_openness: how much of the light from all around reaches a spot; 1 in lanes outside of
 * @p on. */
static inline vf v_openness(const sc_march *m, const v_spot *spot, vm on)
{
    const sc_occlusion *o = m->occlusion;
    vf open = f_set(1);

    for (int which = 0; which < 2; which++) {
        const float width_mm = (float)(which ? o->wide_mm : o->narrow_mm);
        vf above[3], filled;

        v_move(m, spot->point, spot->normal, f_set(width_mm), above);
        filled = v_filled(m, above, which, on);
        if (m->planes.count)
            filled *= v_share_kept(m, above, SC_OCCLUSION_CLIP_WIDTHS * width_mm);
        open *= 1 - f_clamp01((filled - SC_FLAT_FILLED) * (1 / (1 - SC_FLAT_FILLED)));
    }
    return open;
}

/* See sc_unshadowed: how much of the key light reaches a spot; 1 in lanes outside of @p on. */
static inline vf v_unshadowed(const sc_march *m, const v_spot *spot, vm on)
{
    const sc_occlusion *o = m->occlusion;
    const float step_mm = (float)o->mm_per_step,
                start_mm = SC_SHADOW_START_WIDTHS * (float)o->narrow_mm;
    vf through = f_set(1), point[3], key[3];

    for (int i = 0; i < 3; i++)
        key[i] = f_set(m->light.key_direction[i]);
    v_move(m, spot->point, spot->normal, f_set(SC_SHADOW_LIFT_WIDTHS * (float)o->narrow_mm), point);
    for (int k = 0; k < SC_SHADOW_STEPS_MAX; k++) {
        vf at[3], filled, after;

        on = m_and(on, f_below(f_set(SC_SHADOW_DARK), through));
        if (!m_any(on))
            break;
        v_move(m, point, key, f_set(start_mm + (float)k * step_mm), at);
        filled = v_filled(m, at, 0, on);
        after = through * (1 - SC_SHADOW_STEP_MAX *
                                   f_clamp01((filled - SC_SHADOW_FILLED_MIN) * SC_SHADOW_GAIN) *
                                   v_share_kept(m, at, (float)o->narrow_mm));
        through = f_pick(m_and(on, f_below(f_set(SC_SHADOW_FILLED_MIN), filled)), after, through);
    }
    return through + (1 - m->light.shadow) * (1 - through);
}

/* See sc_light_of_sky: sets spot->around to the light of sky and lamp, spot->open and lit. */
static inline void v_light_of_sky(const sc_march *m, vf known, v_spot *spot)
{
    const sc_march_light *l = &m->light;
    vf whole = l->sky * (SC_SKY_MEAN + SC_SKY_UP * (2.0f / 3) * spot->normal[2]);
    vf least = spot->around[0], lamp = l->key * spot->key, beyond;

    for (int i = 0; i < 3; i++) {
        const float *by = l->around[i];

        if (l->has_map) {
            whole = l->sky * (by[0] + (by[1] * spot->normal[0] + by[2] * spot->normal[1] +
                                       by[3] * spot->normal[2]));
            whole = f_pick(f_below(f_set(1e-6f), whole), whole, f_set(1e-6f));
        }
        least = f_pick(f_below(spot->around[i], least), spot->around[i], least);
        spot->around[i] = known * spot->around[i] + (1 - known) * (whole * spot->open);
    }
    beyond = 2 * (least - whole);
    spot->lit =
        known * f_pick(f_below(beyond, lamp), f_clamp01(beyond / lamp), f_set(1)) + (1 - known);
    spot->open = known * f_clamp01(least / whole) + (1 - known) * spot->open;
}

/* The first half of sc_light, all that does not depend on the tissue: sets key, fill, head,
 * open, lit and shine of the spot. Does not change its other members. */
static inline void v_light_spot(const sc_march *m, v_spot *spot, vm on)
{
    const sc_march_light *l = &m->light;
    const vf known = f_pick(spot->has_around, f_set(m->around_share), f_set(0));
    vf direction[3], h[3], length;

    spot->key = spot->fill = spot->head = spot->shine = f_set(0);
    spot->open = spot->lit = f_set(1);
    if (l->flat)
        return;
    for (int i = 0; i < 3; i++) {
        direction[i] = f_set(l->key_direction[i]);
        h[i] = direction[i] + spot->eye[i];
    }
    spot->key = f_max0(f_dot(spot->normal, direction));
    for (int i = 0; i < 3; i++)
        direction[i] = f_set(l->fill_direction[i]);
    spot->fill = f_max0(f_dot(spot->normal, direction));
    spot->head = f_max0(f_dot(spot->normal, spot->eye));
    if (m->occlusion && l->occlusion > 0)
        spot->open =
            1 - l->occlusion *
                    (1 - v_openness(m, spot,
                                    m->around_share == 1 ? m_without(on, spot->has_around) : on));
    if (l->sky > 0)
        v_light_of_sky(m, known, spot);
    for (int i = 0; i < 3 && l->sky > 0; i++)
        spot->around[i] += l->head * spot->head * (known * (1 - spot->open));
    if (m->occlusion && l->shadow > 0)
        spot->lit *= v_unshadowed(m, spot, m_and(on, f_below(f_set(0), spot->key)));
    length = f_length(h);
    spot->shine = f_pick(m_and(f_below(f_set(0), length), f_below(f_set(0), spot->key)),
                         f_max0(f_dot(spot->normal, h) / length), f_set(0));
    spot->key *= 1 - known;
}

/* See sc_depth_cue: blend the colours @p rgb with the background, in place, by distance from the
 * eye. */
static inline void v_depth_cue(const sc_march_light *light, vf depth_mm, vf rgb[3])
{
    const vf far = (depth_mm - light->cue_near_mm) / (light->cue_far_mm - light->cue_near_mm);
    const vf share = light->cue * f_clamp01(far);

    for (int i = 0; i < 3; i++)
        rgb[i] += share * (light->cue_rgb[i] - rgb[i]);
}

/* The second half of sc_light: the colour of a tissue at a spot that v_light_spot has completed,
 * to @p out. */
static inline void v_light(const sc_march *m, vi label, const v_spot *spot, vm on, vf out[3])
{
    const sc_march_light *l = &m->light;
    vf shine, around, near = f_set(1), back = near;

    for (int i = 0; i < 3; i++)
        out[i] = v_tissue_floats(m, label,
                                 offsetof(sc_march_tissue, rgb) + (size_t)i * sizeof(float), on);
    if (l->flat)
        return;
    if (l->lamp_mm > 0) {
        near =
            l->lamp_mm * l->lamp_mm / (l->lamp_mm * l->lamp_mm + spot->depth_mm * spot->depth_mm);
        back = f_sqrt(near);
    }
    shine = v_tissue_floats(m, label, offsetof(sc_march_tissue, specular), on) *
            f_pick(f_below(f_set(0), spot->shine),
                   v_power(spot->shine,
                           v_tissue_word(m, label, offsetof(sc_march_tissue, shininess), on)) *
                       near,
                   f_set(0)) *
            spot->lit * spot->open;
    around =
        (l->ambient * back + l->fill * spot->fill + l->head * (spot->head * near)) * spot->open;
    for (int i = 0; i < 3; i++)
        out[i] = out[i] * (1 - spot->rim) *
                     ((l->sky > 0 ? around + spot->around[i] : around) +
                      l->key * spot->key * spot->lit * (0.5f + 0.5f * spot->open)) +
                 shine;
    if (l->cue > 0)
        v_depth_cue(l, spot->depth_mm, out);
}

/* See sc_edge_alpha: opacity of surfaces seen at an angle whose cosine is @p toward. */
static inline vf v_edge_alpha(const sc_march_light *light, vf alpha, vf toward)
{
    const vf side = 1 - f_pick(f_below(f_set(0), toward), toward, -toward);
    const vf grows = f_pick(f_below(4 * alpha, f_set(1)), 4 * alpha, f_set(1));

    return 1 - (1 - alpha) * (1 - light->edges * grows * side * side * side);
}

/* See sc_blend: composite surfaces behind what the rays have met; lanes outside of @p on keep
 * their light. @param seeks the lanes whose rays have ends_below. */
static inline void v_blend(v_radiance *light, const vf rgb[3], vf alpha, vm seeks, vm on)
{
    const vf share = f_pick(seeks, f_set(1), light->transmittance * alpha);

    on = m_and(on, f_at_most(f_set(SC_OPAQUE), light->transmittance));
    for (int i = 0; i < 3; i++)
        light->rgb[i] = f_pick(on, f_pick(seeks, f_set(0), light->rgb[i]) + share * f_sqrt(rgb[i]),
                               light->rgb[i]);
    light->transmittance = f_pick(on, light->transmittance * (1 - alpha), light->transmittance);
}

/* See sc_remember_surface: note a surface in the radiance, before v_blend; lanes outside of @p
 * on keep theirs. */
static inline void v_remember_surface(v_radiance *light, vi label, vf alpha, const v_spot *spot,
                                      vm seeks, vm on)
{
    vm first;

    on = m_without(on,
                   m_without(f_below(light->transmittance * alpha, f_set(SC_SIGNIFICANT)), seeks));
    light->signature = i_pick(on, (vi)((vu)light->signature * 31u) + label + 1, light->signature);
    first = m_and(on, m_or(seeks, i_equal(light->label, i_set(0))));
    light->label = i_pick(first, label, light->label);
    light->depth_mm = f_pick(first, spot->depth_mm, light->depth_mm);
    for (int i = 0; i < 3; i++)
        light->normal[i] = f_pick(first, spot->normal[i], light->normal[i]);
}

#endif
