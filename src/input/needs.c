/* SPDX-License-Identifier: BSD-3-Clause */
/* What a job, or all shots of a film together, ask of the preparation of their volume. */
#include "recipe.h"

void sc_needs_clear(sc_needs *needs)
{
    sc_free(needs->hidden);
    sc_free(needs->tissue_smooth);
}

/* Add what one job, or one shot, needs. @param is_first hidden labels are those of this one;
 * otherwise they stay hidden only if this one hides them, too. */
static sc_status add_needs(const sc_app *app, const sc_job *job, const sc_label *labels,
                           int label_count, bool is_first, sc_needs *n)
{
    SC_OWN(sc_free_at) bool *hidden = NULL;

    SC_PASS(SC_ZALLOC(app->ctx, (size_t)label_count, &hidden));
    SC_PASS(sc_hidden_labels(app->ctx, labels, label_count, job->tissues.rules,
                             job->tissues.rule_count, hidden));
    for (int id = 0; id < label_count; id++)
        n->hidden[id] = (is_first || n->hidden[id]) && hidden[id];
    n->local_thickness = n->local_thickness || (job->render.auto_opacity & SC_OPACITY_LOCAL);
    return SC_OK;
}

sc_status sc_needs_find(const sc_app *app, const sc_job *job, bool measure, const sc_label *labels,
                        int label_count, sc_needs *out)
{
    const bool is_auto = sc_smooth_is_auto(job->render.smooth);
    SC_OWN(sc_needs_clear)
    sc_needs n = {.smooth = is_auto ? (sc_vec3){SC_SMOOTH_AUTO, SC_SMOOTH_AUTO, SC_SMOOTH_AUTO}
                                    : job->render.smooth,
                  .as_prepared = measure,
                  .resample = is_auto && job->render.surface == SC_SURFACE_SMOOTH && !measure &&
                              !job->given.volume_size,
                  .resize = job->given.volume_size};
    bool is_first = true;

    SC_PASS(SC_ZALLOC(app->ctx, (size_t)label_count, &n.hidden));
    SC_PASS(SC_ALLOC(app->ctx, (size_t)label_count, &n.tissue_smooth));
    sc_tissue_strengths(labels, label_count, job->tissues.rules, job->tissues.rule_count, n.smooth,
                        n.tissue_smooth);
    if (!job->film.shot_count)
        SC_PASS(add_needs(app, job, labels, label_count, true, &n));
    for (size_t i = 0; i < job->film.shot_count; i++) {
        if (job->film.shots[i].has_card)
            continue;
        SC_PASS(add_needs(app, &job->film.shots[i].job, labels, label_count, is_first, &n));
        is_first = false;
    }
    if (measure)
        memset(n.hidden, 0, (size_t)label_count * sizeof *n.hidden);
    memcpy(n.size, job->volume.size, sizeof n.size);
    SC_HAND_OVER(n, out);
    return SC_OK;
}

/* Append what a job says of its volumes, as it would be written: all but the keys that only the
 * drawing depends on. What tissues ask of the preparation is in the needs. */
static sc_status write_volumes(const sc_app *app, const sc_job *job, sc_text *out)
{
    static const char *const others[] = {
        "look:",     "output:",   "render:", "light:",   "animation:",
        "overlays:", "color_by:", "farm:",   "tissues:", "shots:"};
    SC_OWN(sc_text_clear) sc_text text = {0};
    bool counts = true;

    SC_PASS(sc_job_write(app->ctx, job, false, &text));
    for (const char *line = text.data, *end; line && *line; line = end) {
        end = strchr(line, '\n');
        end = end ? end + 1 : line + strlen(line);
        if (*line != ' ') { /* a key of the whole job */
            counts = true;
            for (size_t i = 0; i < SC_COUNT_OF(others); i++)
                counts = counts && strncmp(line, others[i], strlen(others[i])) != 0;
        }
        if (counts)
            SC_PASS(sc_text_add(app->ctx, out, "%.*s", (int)(end - line), line));
    }
    return SC_OK;
}

sc_status sc_inputs_fit(const sc_app *app, const sc_inputs *inputs, const sc_job *of,
                        const sc_job *job, bool *fits)
{
    const sc_prepared *v = &inputs->all[0].volume;
    const size_t labels = (size_t)v->label_count;
    SC_OWN(sc_text_clear) sc_text first = {0}, second = {0};
    SC_OWN(sc_needs_clear) sc_needs a = {0}, b = {0};

    SC_PASS(write_volumes(app, of, &first));
    SC_PASS(write_volumes(app, job, &second));
    SC_PASS(sc_needs_find(app, of, false, v->labels, v->label_count, &a));
    SC_PASS(sc_needs_find(app, job, false, v->labels, v->label_count, &b));
    *fits = !strcmp(first.data, second.data) && of->render.surface == job->render.surface &&
            a.resample == b.resample && a.local_thickness == b.local_thickness &&
            !memcmp(a.hidden, b.hidden, labels * sizeof *a.hidden) &&
            !memcmp(a.tissue_smooth, b.tissue_smooth, labels * sizeof *a.tissue_smooth) &&
            a.smooth.x == b.smooth.x && a.smooth.y == b.smooth.y && a.smooth.z == b.smooth.z;
    return SC_OK;
}
