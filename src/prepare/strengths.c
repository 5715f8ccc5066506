/* SPDX-License-Identifier: BSD-3-Clause */
/* How strongly the surfaces of each label are smoothed. */
#include "internal.h"

/* @return below 0 if @p a is weaker than @p b, above 0 if it is stronger, 0 if they are the same.
 * That with the smaller sum is the weaker one; of equal sums, that which is smaller along the first
 * axis in which they differ. */
static int compare(sc_vec3 a, sc_vec3 b)
{
    const double differences[4] = {(a.x + a.y + a.z) - (b.x + b.y + b.z), a.x - b.x, a.y - b.y,
                                   a.z - b.z};

    for (int i = 0; i < 4; i++) {
        if (differences[i] < 0 || differences[i] > 0)
            return differences[i] < 0 ? -1 : 1;
    }
    return 0;
}

/* Put a strength among p->kinds, unless it is there. @return false if there is no room. */
static bool add_kind(sc_preparation *p, sc_vec3 strength)
{
    int at = 0;

    while (at < p->kind_count && compare(p->kinds[at], strength) < 0)
        at++;
    if (at < p->kind_count && compare(p->kinds[at], strength) == 0)
        return true;
    if (p->kind_count == SC_SMOOTH_KINDS_MAX)
        return false;
    for (int i = p->kind_count; i > at; i--)
        p->kinds[i] = p->kinds[i - 1];
    p->kinds[at] = strength;
    p->kind_count++;
    return true;
}

sc_status sc_find_strengths(const sc_ctx *ctx, sc_preparation *p)
{
    const sc_prepare_settings *s = &p->settings;
    const size_t labels = (size_t)p->volume->label_count;
    bool all_fit = true;

    SC_PASS(SC_ZALLOC(ctx, labels, &p->smooth));
    for (size_t id = 1; id < labels; id++) {
        p->smooth[id] = s->tissue_smooth ? s->tissue_smooth[id] : s->smooth;
        all_fit = all_fit && (p->hidden[id] || add_kind(p, p->smooth[id]));
    }
    if (!all_fit)
        return sc_fail(ctx, SC_ERR_DATA,
                       "tissues have more than %d different strengths of smoothing; give some of "
                       "them the same",
                       SC_SMOOTH_KINDS_MAX);
    if (p->kind_count == 0) /* nothing but background and hidden labels */
        p->kinds[p->kind_count++] = s->smooth;
    return SC_OK;
}
