/* SPDX-License-Identifier: BSD-3-Clause */
/* Tissues that fade, or change their colour or the planes that cut them: their opacities, and the
 * shade that they cast on others.
 *
 * What blurs the occlusion is linear in the opacities. So the occlusion of tissues that have faded
 * by some factors is that of all as they are, less what each of them adds to it times what is
 * missing of it. Tissues that fade alike form a group, for which that is computed once. */
#include "internal.h"

#include <string.h>

/* A factor beyond this changes the occlusion no further. */
#define MOST_FACTOR 16.0f
enum { WHOLE = 256 /* of the weights with which groups are taken away from the base */ };

/* @return the number of bricks in the occlusion. */
static size_t brick_count(const sc_occlusion *o)
{
    return sc_brick_count(o->size);
}

uint64_t sc_fades_bytes(const sc_renderer *r)
{
    return r->fades.mixed ? (brick_count(&r->derived.occlusion) + SC_GATHER_BYTES) * 2 : 0;
}

/* Find what group @p group adds to the occlusion. @param opacity room for [label_count]. */
static sc_status find_group(const sc_ctx *ctx, sc_renderer *r, int group, float *opacity)
{
    sc_occlusion added;

    for (int id = 0; id < r->volume->label_count; id++)
        opacity[id] = r->looks[id].group == group ? (float)r->looks[id].opacity : 0;
    SC_PASS(sc_occlusion_build(ctx, r->team, r->volume, opacity, &added));
    r->fades.filled[group - 1] = added.filled;
    return SC_OK;
}

sc_status sc_find_fades(const sc_ctx *ctx, sc_renderer *r)
{
    const size_t labels = (size_t)r->volume->label_count;
    sc_fades *fades = &r->fades;
    SC_OWN(sc_free_at) float *opacity = NULL;
    sc_status status;

    for (size_t id = 0; id < labels; id++)
        fades->groups = r->looks[id].group > fades->groups ? r->looks[id].group : fades->groups;
    fades->base = r->derived.occlusion.filled;
    if (!fades->groups || !fades->base)
        return SC_OK;
    status = SC_ALLOC(ctx, labels, &opacity);
    if (status == SC_OK)
        status =
            SC_ZALLOC(ctx, brick_count(&r->derived.occlusion) + SC_GATHER_BYTES, &fades->mixed);
    /* No rank begins what all do together before all have come as far. */
    SC_PASS(sc_team_agree(r->team, status));
    for (int group = 1; group <= fades->groups; group++)
        SC_PASS(find_group(ctx, r, group, opacity));
    return SC_OK;
}

/* ---- for each view ---- */

/* Mix bricks [begin, end) of the occlusion; an sc_range_fn on a renderer. */
static void mix_bricks(void *user, size_t begin, size_t end, int thread)
{
    const sc_renderer *r = user;
    const sc_fades *fades = &r->fades;
    const uint8_t *base = (const uint8_t *)(fades->base + begin);
    uint8_t *to = (uint8_t *)(fades->mixed + begin);
    const size_t count = 2 * (end - begin);
    enum { CHUNK = 1024 };
    int32_t sum[CHUNK];

    for (size_t at = 0; at < count; at += CHUNK) {
        const size_t n = count - at < CHUNK ? count - at : CHUNK;

        for (size_t i = 0; i < n; i++)
            sum[i] = base[at + i] * WHOLE + WHOLE / 2;
        for (int g = 0; g < fades->groups; g++) {
            const uint8_t *less = (const uint8_t *)(fades->filled[g] + begin) + at;
            const int32_t weight = fades->mixed_weights[g];

            for (size_t i = 0; i < n && weight; i++)
                sum[i] -= weight * less[i];
        }
        for (size_t i = 0; i < n; i++)
            to[at + i] = (uint8_t)(sum[i] < 0 ? 0 : sum[i] / WHOLE > 255 ? 255 : sum[i] / WHOLE);
    }
}

/* Find what of each group is taken away from the occlusion: the mean of its tissues, by how much of
 * them there is. @param weights [SC_FADE_GROUPS_MAX], in 256ths. @return whether it is anything. */
static bool find_weights(const sc_renderer *r, const float *factors, int *weights)
{
    double missing[SC_FADE_GROUPS_MAX] = {0}, all[SC_FADE_GROUPS_MAX] = {0};
    bool any = false;

    for (int id = 1; id < r->volume->label_count; id++) {
        const sc_full_look *look = &r->looks[id];
        const double amount = look->opacity * (double)r->volume->stats[id].voxels;

        if (!look->group)
            continue;
        missing[look->group - 1] += amount * (1 - fmin(factors[id], MOST_FACTOR));
        all[look->group - 1] += amount;
    }
    for (int g = 0; g < r->fades.groups; g++) {
        weights[g] = all[g] > 0 ? (int)floor(WHOLE * missing[g] / all[g] + 0.5) : 0;
        any = any || weights[g];
    }
    return any;
}

/* Set the occlusion of the march to what is left of it. Neighbouring views share it if they can. */
static void set_occlusion(sc_renderer *r, const float *factors)
{
    sc_fades *fades = &r->fades;
    int weights[SC_FADE_GROUPS_MAX] = {0};

    if (!fades->mixed)
        return;
    r->derived.occlusion.filled = fades->base;
    if (!factors || !find_weights(r, factors, weights))
        return;
    if (memcmp(weights, fades->mixed_weights, sizeof weights) != 0) {
        memcpy(fades->mixed_weights, weights, sizeof weights);
        sc_parallel_for(r->settings.work.threads, brick_count(&r->derived.occlusion), 16384,
                        mix_bricks, r);
    }
    r->derived.occlusion.filled = (const uint8_t(*)[2])fades->mixed;
}

/* Set what the march knows of one tissue. @param measured_max the largest of thickness_alpha. */
static void set_tissue(sc_renderer *r, int id, float factor, float measured_max)
{
    const sc_render_settings *s = &r->settings;
    const sc_full_look *look = &r->looks[id];
    sc_march_tissue *to = &r->tissues[id];

    to->boundary_alpha = sc_alpha_of(s, fmin(look->opacity * factor, 1));
    to->interior_alpha = sc_alpha_of(s, fmin(look->interior_opacity * factor, 1));
    to->cap_alpha = fminf(factor, 1);
    to->thickness_factor = factor * measured_max > 1 ? 1 / measured_max : factor;
    to->show = factor > 0 ? look->show : 0;
}

void sc_set_fades(sc_renderer *r, const float *factors)
{
    sc_fades *fades = &r->fades;
    float measured_max = 0;

    if (!fades->groups || (!factors && !fades->are_set))
        return;
    for (int code = 0; code < 256; code++)
        measured_max = fmaxf(measured_max, r->march.thickness_alpha[code]);
    for (int id = 1; id < r->volume->label_count; id++) {
        if (r->looks[id].group)
            set_tissue(r, id, factors ? factors[id] : 1, measured_max);
    }
    set_occlusion(r, factors);
    fades->are_set = factors != NULL;
}

void sc_set_colors(sc_renderer *r, const float (*colors)[3])
{
    if (!colors && !r->colors_are_set)
        return;
    for (int id = 1; id < r->volume->label_count; id++)
        memcpy(r->tissues[id].rgb, colors ? colors[id] : r->looks[id].rgb,
               sizeof r->tissues[id].rgb);
    r->colors_are_set = colors != NULL;
}

void sc_set_clip_sets(sc_renderer *r, const sc_scene *scene)
{
    uint8_t same[SC_CLIP_SETS_MAX];

    for (int g = 0; g < SC_CLIP_SETS_MAX; g++) {
        int first = 0;

        while (first < g &&
               (g >= scene->clip.set_count || scene->clip.sets[first] != scene->clip.sets[g]))
            first++;
        same[g] = (uint8_t)first;
    }
    for (int id = 1; id < r->volume->label_count; id++)
        r->tissues[id].clip_set = same[r->looks[id].clip_set];
}
