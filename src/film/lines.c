/* SPDX-License-Identifier: BSD-3-Clause */
/* Centre lines of tissues that are given by names. */
#include "panels.h"

/* Set order[id] to 1 + the index of the first pattern that the label fits, 0 for none. @param order
 * [label_count], zeroed. */
static sc_status find_order(const sc_ctx *ctx, const sc_volume *volume, const sc_line_wish *wish,
                            int *order)
{
    const sc_prepared view = {.label_count = volume->label_count, .labels = volume->labels};

    for (size_t i = 0; i < wish->pattern_count; i++) {
        const sc_pattern pattern = sc_pattern_of(wish->patterns[i]);
        const sc_match best = sc_pattern_match(volume->labels, volume->label_count, &pattern);

        SC_PASS(sc_pattern_check(ctx, &view, wish->patterns[i], wish->where));
        for (int id = 1; id < volume->label_count && best != SC_MATCH_NONE; id++) {
            if (!order[id] && sc_label_match(&volume->labels[id], &pattern) == best)
                order[id] = (int)i + 1;
        }
    }
    return SC_OK;
}

const sc_label *sc_hidden_on_line(const sc_prepared *v, const sc_line_wish *wish)
{
    for (size_t i = 0; i < wish->pattern_count; i++) {
        const sc_pattern pattern = sc_pattern_of(wish->patterns[i]);
        const sc_match best = sc_pattern_match(v->labels, v->label_count, &pattern);

        for (int id = 1; id < v->label_count && best != SC_MATCH_NONE; id++) {
            if (v->how.hidden[id] && sc_label_match(&v->labels[id], &pattern) == best)
                return &v->labels[id];
        }
    }
    return NULL;
}

sc_status sc_check_line_voxels(const sc_ctx *ctx, const char *path, const sc_prepared *v,
                               const sc_line_wish *wish)
{
    const sc_label *hidden = sc_hidden_on_line(v, wish);

    if (!hidden)
        return SC_OK;
    return sc_fail(ctx, SC_ERR_DATA,
                   "%s%s%s: was prepared while \"%s\" (label %lld) was hidden, so that it lacks "
                   "the voxels through which the line leads; prepare it with this tissue shown, or "
                   "give the volume that it was made from",
                   wish->where, wish->where[0] ? ": " : "", path, hidden->name,
                   (long long)hidden->value);
}

/* Find the middle of the tissues of each pattern. @param order as of find_order. @param points
 * [wish->pattern_count] room for them. */
static sc_status find_middles(const sc_ctx *ctx, const sc_volume *volume, const sc_line_wish *wish,
                              const int *order, sc_vec3 *points)
{
    SC_OWN(sc_text_clear) sc_text what = {0};
    SC_OWN(sc_free_at) int *only = NULL;

    SC_PASS(SC_ALLOC(ctx, (size_t)volume->label_count, &only));
    for (size_t i = 0; i < wish->pattern_count; i++) {
        sc_centerline_request request = {.volume = volume, .order = only, .where = wish->where};

        for (int id = 0; id < volume->label_count; id++)
            only[id] = order[id] == (int)i + 1;
        sc_text_clear(&what);
        SC_PASS(sc_text_add(ctx, &what, "\"%s\"", wish->patterns[i]));
        request.what = what.data;
        SC_PASS(sc_centerline_middle(ctx, &request, &points[i]));
    }
    return SC_OK;
}

/* Tell what was found. */
static void tell_line(const sc_ctx *ctx, const char *what, const sc_line_wish *wish,
                      const sc_centerline *line)
{
    double least = line->points[0].radius_mm, most = least;

    for (size_t i = 1; i < line->count; i++) {
        least = fmin(least, line->points[i].radius_mm);
        most = fmax(most, line->points[i].radius_mm);
    }
    sc_info(ctx, "%s%sthe centre line of %s is %.4g mm long, with a radius from %.3g to %.3g mm",
            wish->where, wish->where[0] ? ": " : "", what, line->length_mm, least, most);
    if (line->parts > 1 && !wish->through_count && !wish->middles)
        sc_info(ctx,
                "%s%s%s lies in %d pieces that do not touch: the line leads through the largest%s; "
                "points choose another",
                wish->where, wish->where[0] ? ": " : "", what, line->parts,
                wish->pattern_count > 1 ? " that has a part of each" : "");
}

sc_status sc_find_line(const sc_app *app, const sc_volume *volume, const sc_line_wish *wish,
                       sc_centerline *out)
{
    sc_centerline_request request = {.volume = volume,
                                     .through = wish->through,
                                     .through_count = wish->through_count,
                                     .clearance = wish->clearance,
                                     .names = wish->patterns,
                                     .where = wish->where};
    SC_OWN(sc_text_clear) sc_text what = {0};
    SC_OWN(sc_free_at) int *order = NULL;
    SC_OWN(sc_free_at) sc_vec3 *middles = NULL;

    SC_PASS(SC_ZALLOC(app->ctx, (size_t)volume->label_count, &order));
    SC_PASS(find_order(app->ctx, volume, wish, order));
    for (size_t i = 0; i < wish->pattern_count; i++)
        SC_PASS(sc_text_add(app->ctx, &what, "%s\"%s\"", i ? ", " : "", wish->patterns[i]));
    request.order = order;
    request.what = what.data;
    sc_stage_begin(app->ctx, "finding the centre line", 0, 0);
    if (wish->middles) {
        SC_PASS(SC_ALLOC(app->ctx, wish->pattern_count, &middles));
        SC_PASS(find_middles(app->ctx, volume, wish, order, middles));
        request.through = middles;
        request.through_count = wish->pattern_count;
    }
    SC_PASS(sc_centerline_find(app->ctx, &request, out));
    tell_line(app->ctx, what.data, wish, out);
    return SC_OK;
}
