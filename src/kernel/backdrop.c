/* SPDX-License-Identifier: BSD-3-Clause */
/* Rays through a grey volume that is translucent, one at a time in plain C: the specification of
 * the kernels for backdrops; and the choice between these. */
#include "variants.h"

#include "backdrop.h"

#include <string.h>

/* The value at a point, in codes, interpolated trilinearly. @param at in voxels; beyond the
 * outermost centres it is the nearest of these. */
static float value_at(const sc_march_grey *g, const float at[3])
{
    const size_t steps[3] = {1, (size_t)g->size[0], (size_t)g->size[0] * (size_t)g->size[1]};
    float share[3], corners[8];
    size_t first = 0;

    for (int i = 0; i < 3; i++) {
        const float last = (float)(g->size[i] - 1);
        const float x = at[i] < 0 ? 0 : at[i] < last ? at[i] : last;
        const int most = sc_lowest_max(g->size[i]);
        const int low = (int)x < most ? (int)x : most;

        share[i] = x - (float)low;
        first += (size_t)low * steps[i];
    }
    for (int k = 0; k < 8; k++) {
        size_t corner = first;

        for (int i = 0; i < 3; i++)
            corner += k >> i & 1 && g->size[i] > 1 ? steps[i] : 0;
        corners[k] = (float)g->codes[corner];
    }
    for (int half = 4, i = 0; half; half /= 2, i++) {
        for (int k = 0; k < half; k++)
            corners[k] = corners[2 * k] * (1 - share[i]) + corners[2 * k + 1] * share[i];
    }
    return corners[0];
}

/* What a ray has met so far. */
typedef struct passage {
    float tone, transmittance;
    float faded; /* share of what is behind the picture, by the depth cue */
} passage;

/* Follow a stretch of a ray. */
static void follow(const sc_march_backdrop *b, const sc_backdrop_ray *ray, int stretch, passage *p)
{
    const float begin = ray->begin_mm[stretch], length = ray->end_mm[stretch] - begin;
    const float steps_per_mm = 1 / b->step_mm;

    for (int k = 0; (float)k * b->step_mm < length && p->transmittance >= SC_OPAQUE; k++) {
        const float from = (float)k * b->step_mm, left = (length - from) * steps_per_mm;
        const float part = left < 1 ? left : 1; /* of a step */
        const float t = begin + (from + part * (0.5f * b->step_mm));
        const float at[3] = {ray->origin[0] + ray->direction[0] * t,
                             ray->origin[1] + ray->direction[1] * t,
                             ray->origin[2] + ray->direction[2] * t};
        const float value = value_at(b->grey, at);
        const float place =
            sc_clamp01((value - b->grey->black) * b->grey->white_less) * SC_BACKDROP_STEPS + 0.5f;
        const int index = place < SC_BACKDROP_STEPS ? (int)place : SC_BACKDROP_STEPS;
        const float alpha = b->alphas[index], share = p->transmittance * part;
        const float away = b->cue * sc_clamp01((ray->base_mm + t - b->cue_near_mm) * b->cue_per_mm);

        p->tone += share * b->tones[index] * (1 - away);
        p->faded += share * alpha * away;
        p->transmittance *= 1 - part * alpha;
    }
}

static void backdrop_plain(const sc_march_backdrop *backdrop, const sc_backdrop_ray *rays,
                           size_t count, sc_backdrop_light *out)
{
    for (size_t i = 0; i < count; i++) {
        passage p = {0, 1, 0};

        for (int k = 0; k < rays[i].stretches; k++)
            follow(backdrop, &rays[i], k, &p);
        out[i] = (sc_backdrop_light){p.tone, p.transmittance + p.faded};
    }
}

sc_backdrop_fn *sc_backdrop_find(sc_skip skip, const int size[3], const char *cpu)
{
    const bool any = !cpu || strcmp(cpu, "auto") == 0;
    const uint64_t codes = (uint64_t)size[0] * (uint64_t)size[1] * (uint64_t)size[2];

    if (!sc_skip_is_wide(skip) || size[0] < 2 || codes >= INT32_MAX / sizeof(uint16_t))
        return backdrop_plain;
#define CHOOSE(name, supported)                                                                    \
    if ((any || strcmp(cpu, #name) == 0) && (supported))                                           \
        return sc_backdrop_wide_##name;

    SC_EACH_BUILT_CPU(CHOOSE)
    return backdrop_plain;
}
