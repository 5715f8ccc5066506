/* SPDX-License-Identifier: BSD-3-Clause */
/* Clip planes of a job: sweeps, still planes, and boxes as shorthand for six of them. */
#include "job_fields.h"

#include <stdlib.h>
#include <string.h>

static const sc_field sweep_fields[] = {
    {.name = "normal",
     .type = &sc_type_direction,
     .offset = offsetof(sc_sweep, normal),
     .low = -1e6,
     .high = 1e6},
    {.name = "from", .type = &sc_type_place, .offset = offsetof(sc_sweep, from)},
    {.name = "to", .type = &sc_type_place, .offset = offsetof(sc_sweep, to)},
    {.name = "during", .type = &sc_type_span, .offset = offsetof(sc_sweep, begin)},
    {.name = "ease",
     .type = &sc_type_choice,
     .offset = offsetof(sc_sweep, ease),
     .choices = sc_ease_names},
    {0}};

static const sc_field plane_fields[] = {
    {.name = "normal",
     .type = &sc_type_direction,
     .offset = offsetof(sc_sweep, normal),
     .low = -1e6,
     .high = 1e6},
    {.name = "at", .type = &sc_type_place, .offset = offsetof(sc_sweep, from)},
    {0}};

static sc_status parse_exceptions(const sc_ctx *ctx, const sc_yaml *list, int plane, sc_job *job)
{
    void *grown;
    sc_status status;

    if (list->kind != SC_YAML_LIST)
        return sc_wrong_type(ctx, list, "a list of tissues");
    status = sc_zalloc(ctx, job->exception_count + list->count, sizeof *job->exceptions, &grown);
    if (status != SC_OK)
        return status;
    if (job->exception_count)
        memcpy(grown, job->exceptions, job->exception_count * sizeof *job->exceptions);
    sc_free(job->exceptions);
    job->exceptions = grown;
    for (size_t i = 0; i < list->count; i++) {
        const sc_yaml *item = list->items[i];
        sc_clip_exception *exception = &job->exceptions[job->exception_count];

        if (item->kind != SC_YAML_SCALAR || strlen(item->text) >= SC_NAME_BYTES)
            return sc_wrong_type(ctx, item, "the name of a tissue");
        exception->plane = plane;
        strcpy(exception->pattern, item->text);
        sc_note_where(item, exception->where, sizeof exception->where);
        job->exception_count++;
    }
    return SC_OK;
}

static sc_status too_many(const sc_ctx *ctx, const sc_yaml *node)
{
    return sc_yaml_fail(ctx, node, "more than %d clip planes (a box counts as six)", SC_PLANES_MAX);
}

/* A moving or a still plane. */
static sc_status parse_plane(const sc_ctx *ctx, const sc_yaml *body, bool moving, sc_job *job)
{
    sc_sweep sweep = {.from = {moving ? 0 : 50, true}, .to = {50, true}, .end = 1};
    sc_status status;

    if (job->animation.sweep_count >= SC_PLANES_MAX)
        return too_many(ctx, body);
    if (!sc_yaml_member(body, "normal"))
        return sc_yaml_fail(ctx, body, "a clip plane needs a normal, towards what is kept");
    status = sc_fields_parse(ctx, moving ? sweep_fields : plane_fields, body, &sweep);
    if (status != SC_OK)
        return status;
    if (!moving)
        sweep.to = sweep.from;
    job->animation.sweeps[job->animation.sweep_count++] = sweep;
    return SC_OK;
}

/* Three places, along the axes to the right, anterior and superior. */
static sc_status parse_corner(const sc_ctx *ctx, const sc_yaml *node, sc_place out[3])
{
    sc_status status = SC_OK;

    if (!node)
        return SC_OK;
    if (node->kind != SC_YAML_LIST || node->count != 3)
        return sc_wrong_type(ctx, node, "three places along R, A and S, such as [0%, 25%, 10 mm]");
    for (size_t i = 0; i < 3 && status == SC_OK; i++) {
        const sc_field field = {.type = &sc_type_place, .offset = i * sizeof(sc_place)};

        status = sc_type_place.parse(ctx, &field, node->items[i], out);
    }
    return status;
}

/* Six planes whose normals point into the box. */
static sc_status parse_box(const sc_ctx *ctx, const sc_yaml *body, sc_job *job)
{
    static const char *const words[] = {"from", "to"};
    static const sc_vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    sc_place low[3] = {{0, true}, {0, true}, {0, true}};
    sc_place high[3] = {{100, true}, {100, true}, {100, true}};
    sc_status status;

    for (size_t i = 0; i < body->count; i++) {
        if (strcmp(body->items[i]->key, "from") && strcmp(body->items[i]->key, "to"))
            return sc_unknown_word(ctx, body->items[i], body->items[i]->key, words, 2);
    }
    if (job->animation.sweep_count + 6 > SC_PLANES_MAX)
        return too_many(ctx, body);
    SC_TRY(parse_corner(ctx, sc_yaml_member(body, "from"), low));
    SC_TRY(parse_corner(ctx, sc_yaml_member(body, "to"), high));
    for (int i = 0; i < 3; i++) {
        const sc_place back = {high[i].percent ? 100 - high[i].value : -high[i].value,
                               high[i].percent};

        if (low[i].percent == high[i].percent && low[i].value >= high[i].value)
            return sc_yaml_fail(ctx, body, "the box is empty along its axis %d: from %g to %g",
                                i + 1, low[i].value, high[i].value);
        job->animation.sweeps[job->animation.sweep_count++] =
            (sc_sweep){.normal = axes[i], .from = low[i], .to = low[i], .end = 1};
        job->animation.sweeps[job->animation.sweep_count++] =
            (sc_sweep){.normal = sc_vec3_scale(axes[i], -1), .from = back, .to = back, .end = 1};
    }
out:
    return status;
}

static sc_status parse_clip_item(const sc_ctx *ctx, const sc_yaml *item, sc_job *job)
{
    static const char *const words[] = {"sweep", "plane", "box", "except"};
    const int first = job->animation.sweep_count;
    const sc_yaml *except = NULL, *body = NULL;
    sc_status status = SC_OK;

    if (item->kind != SC_YAML_MAP)
        return sc_wrong_type(ctx, item, "{sweep: {...}}, {plane: {...}} or {box: {...}}");
    for (size_t i = 0; i < item->count; i++) {
        const sc_yaml *member = item->items[i];
        size_t word = 0;

        while (word < SC_COUNT_OF(words) && strcmp(member->key, words[word]))
            word++;
        if (word == SC_COUNT_OF(words))
            return sc_unknown_word(ctx, member, member->key, words, SC_COUNT_OF(words));
        if (word < 3 && (body || member->kind != SC_YAML_MAP))
            return sc_yaml_fail(ctx, item, "a clip item holds either a sweep, a plane or a box");
        if (word < 3)
            body = member;
        else
            except = member;
    }
    if (!body)
        return sc_yaml_fail(ctx, item, "a clip item holds either a sweep, a plane or a box");
    status = body->key[0] == 'b' ? parse_box(ctx, body, job)
                                 : parse_plane(ctx, body, body->key[0] == 's', job);
    for (int plane = first; except && plane < job->animation.sweep_count && status == SC_OK;
         plane++)
        status = parse_exceptions(ctx, except, plane, job);
    return status;
}

static sc_status parse_clip(const sc_ctx *ctx, const sc_field *field, const sc_yaml *node, void *to)
{
    sc_status status = SC_OK;

    if (node->kind != SC_YAML_LIST)
        return sc_wrong_type(ctx, node, field->type->expected);
    for (size_t i = 0; i < node->count && status == SC_OK; i++)
        status = parse_clip_item(ctx, node->items[i], to);
    return status;
}

static sc_status write_clip(const sc_ctx *ctx, const sc_field *field, const void *from, int indent,
                            sc_text *text)
{
    const sc_job *job = from;
    sc_status status = sc_text_add(ctx, text, "%s", job->animation.sweep_count ? "" : "[]");

    (void)field;
    for (int i = 0; i < job->animation.sweep_count && status == SC_OK; i++) {
        const char *comma = "";

        SC_TRY(sc_text_add(ctx, text, "\n%*s- sweep: ", indent + 2, ""));
        SC_TRY(sc_fields_write_flow(ctx, sweep_fields, &job->animation.sweeps[i], text));
        SC_TRY(sc_text_add(ctx, text, "\n%*sexcept: [", indent + 4, ""));
        for (size_t e = 0; e < job->exception_count; e++) {
            if (job->exceptions[e].plane != i)
                continue;
            SC_TRY(sc_text_add(ctx, text, "%s\"%s\"", comma, job->exceptions[e].pattern));
            comma = ", ";
        }
        status = sc_text_add(ctx, text, "]");
    }
out:
    return status;
}

const sc_field_type sc_type_clip = {"a list of sweeps, planes and boxes", parse_clip, write_clip,
                                    NULL};
