/* SPDX-License-Identifier: BSD-3-Clause */
/* The identity of a job: a hash of all from which its pictures follow, but the volume. A directory
 * is continued, and its pictures count as done, only if the identity is the same. */
#include "render/run.h"

/* Append to @p text what happens to tissues, in the order in which it does. */
static sc_status add_changes(const sc_ctx *ctx, const sc_change *changes, size_t count,
                             sc_text *text)
{
    for (size_t i = 0; i < count; i++) {
        const sc_change *c = &changes[i];

        SC_PASS(sc_text_add(ctx, text, "%d %d %.17g %.17g %d %.17g %.17g %.17g %d\n", c->id,
                            (int)c->kind, c->begin, c->end, (int)c->ease.kind, c->to.x, c->to.y,
                            c->to.z, c->times));
        for (int j = 0; j < 4 && c->ease.kind == SC_EASE_BEZIER; j++)
            SC_PASS(sc_text_add(ctx, text, "%.17g\n", c->ease.bezier[j]));
    }
    return SC_OK;
}

/* Append to @p text where verbs bring the camera: to tissues that are chosen by their names. */
static sc_status add_moves(const sc_ctx *ctx, const sc_timeline *t, sc_text *text)
{
    for (int i = 0; i < t->animation.move_count; i++) {
        const sc_move *m = &t->moves[i];

        SC_PASS(sc_text_add(ctx, text, "%d %.17g %.17g %.17g %.17g %.17g\n", (int)m->verb.kind,
                            m->target_mm.x, m->target_mm.y, m->target_mm.z, m->distance_mm,
                            m->half_height));
    }
    return SC_OK;
}

/* @return the planes that cut a tissue, as bits; of key frames, those of the first. */
static uint32_t planes_of(const sc_panel *s, int id)
{
    const sc_clip_set *set = &s->timeline.clip_sets[s->looks.tissues[id].clip_set];
    uint32_t planes = 0;

    for (int i = 0; i < s->timeline.animation.sweep_count; i++)
        planes |= (uint32_t)(~set->spares[i] & 1) << i;
    return planes;
}

/* Append to @p text in which spans planes cut a tissue, of those whose exceptions have key frames.
 */
static sc_status add_spans(const sc_ctx *ctx, const sc_panel *s, int id, sc_text *text)
{
    const sc_clip_set *set = &s->timeline.clip_sets[s->looks.tissues[id].clip_set];

    for (int i = 0; i < s->timeline.animation.sweep_count; i++) {
        if (s->timeline.animation.sweeps[i].except_count)
            SC_PASS(sc_text_add(ctx, text, "%llx\n", (unsigned long long)set->spares[i]));
    }
    return SC_OK;
}

/* Append to @p text how each tissue looks and which planes cut it. Both may follow from names in a
 * label table, which the keys of the job do not hold. */
static sc_status add_tissues(const sc_ctx *ctx, const sc_panel *s, sc_text *text)
{
    for (int id = 1; id < s->volume.label_count; id++) {
        const sc_tissue *t = &s->looks.tissues[id];

        SC_PASS(sc_text_add(ctx, text, "%lld %d %.17g %d %.17g %.9g %.9g %.9g",
                            (long long)s->volume.labels[id].value, t->visible, t->opacity,
                            t->opacity_auto, t->interior_opacity, t->rgb_linear[0],
                            t->rgb_linear[1], t->rgb_linear[2]));
        SC_PASS(sc_text_add(ctx, text, " %.17g %.17g %.17g %x\n", t->material.specular,
                            t->material.roughness, t->material.coat, planes_of(s, id)));
        if (t->color_track || t->opacity_track || t->visible_track || t->offset_track)
            SC_PASS(sc_text_add(ctx, text, "%d %d %d %d\n", t->color_track, t->opacity_track,
                                t->visible_track, t->offset_track));
        SC_PASS(add_spans(ctx, s, id, text));
    }
    return SC_OK;
}

/* Append to @p text the values of key frames of columns, when they hold, and of which tissues the
 * colours follow them. */
static sc_status add_columns(const sc_ctx *ctx, const sc_panel *s, sc_text *text)
{
    const sc_track *steps = &s->job.color_columns.steps;
    const int count = s->volume.label_count;

    if (!s->looks.column_values)
        return SC_OK;
    for (int i = 0; i < steps->count; i++) {
        const sc_ease *ease = &steps->keys[i].ease;

        SC_PASS(sc_text_add(ctx, text, "%.17g %d %.17g %.17g %.17g %.17g\n", steps->keys[i].at,
                            (int)ease->kind, ease->bezier[0], ease->bezier[1], ease->bezier[2],
                            ease->bezier[3]));
        for (int id = 1; id < count; id++)
            SC_PASS(sc_text_add(ctx, text, "%.17g %d\n", s->looks.column_values[i * count + id],
                                s->looks.tissues[id].color_by_rule));
    }
    return SC_OK;
}

/* Append to @p text what the pictures of a panel follow from beside the keys of the job. */
static sc_status add_panel(const sc_ctx *ctx, const sc_panel *s, sc_text *text)
{
    const sc_lettering *letters = s->text.lettering;

    if (s->looks.tissues) /* it does not only write */
        SC_PASS(add_tissues(ctx, s, text));
    SC_PASS(add_changes(ctx, s->looks.fades, s->looks.fade_count, text));
    SC_PASS(add_changes(ctx, s->looks.shifts, s->looks.shift_count, text));
    SC_PASS(add_moves(ctx, &s->timeline, text));
    if (s->looks.scale.is_used) /* which the colour bar shows */
        SC_PASS(sc_text_add(ctx, text, "%.17g %.17g\n", s->looks.scale.low, s->looks.scale.high));
    SC_PASS(add_columns(ctx, s, text));
    if (s->environment.rgb)
        SC_PASS(sc_text_add(ctx, text, "%.17g %llx %d\n", s->job.light.environment.turn_deg,
                            (unsigned long long)sc_hash_bytes(s->environment.rgb,
                                                              (size_t)s->environment.width_px *
                                                                  (size_t)s->environment.height_px *
                                                                  sizeof *s->environment.rgb,
                                                              0),
                            s->environment.width_px));
    if (s->grey.grey.codes)
        SC_PASS(sc_text_add(ctx, text, "%llx %.17g %.17g\n", (unsigned long long)s->grey.hash,
                            s->grey.window.level, s->grey.window.width));
    if (s->text.logo.rgb)
        SC_PASS(sc_text_add(ctx, text, "%llx %d\n",
                            (unsigned long long)sc_image_hash(&s->text.logo),
                            s->job.overlays.logo_place));
    if (letters) /* their pixels, which follow from the font */
        SC_PASS(sc_text_add(ctx, text, "%llx\n",
                            (unsigned long long)sc_hash_bytes(letters, letters->bytes, 0)));
    return SC_OK;
}

sc_status sc_run_hash_job(sc_run *run, uint64_t *out)
{
    const sc_ctx *ctx = run->app->ctx;
    SC_OWN(sc_text_clear) sc_text text = {0};

    SC_PASS(sc_job_write(ctx, &run->session.job, true, &text));
    for (int i = 0; i < run->session.panel_count; i++)
        SC_PASS(add_panel(ctx, &run->session.panels[i], &text));
    *out = sc_hash_bytes(text.data, text.length_bytes, 0);
    return SC_OK;
}
