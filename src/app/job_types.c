/* SPDX-License-Identifier: BSD-3-Clause */
/* Types of job keys that only a job has: tissues, cameras, clip planes. */
#include "job_fields.h"

#include <stdlib.h>
#include <string.h>

const char *const sc_ease_names[] = {"linear", "smooth", "in", "out", NULL};
const char *const sc_projection_names[] = {"perspective", "orthographic", NULL};

static void note_where(const sc_yaml *node, char *where, size_t size)
{
    if (node->line > 0)
        snprintf(where, size, "%.130s:%d", node->origin, node->line);
    else
        snprintf(where, size, "%.150s", node->origin);
}

/* ---- places and spans ---- */

/* "40%" -> 40, percent; "12" or "12 mm" -> 12. */
static sc_status parse_place(const sc_ctx *ctx, const sc_field *field, const sc_yaml *node,
                             void *to)
{
    sc_place *place = (sc_place *)((char *)to + field->offset);
    double value = 0;
    char *end = NULL;

    if (node->kind == SC_YAML_SCALAR)
        value = strtod(node->text, &end);
    if (!end || end == node->text || !isfinite(value) || fabs(value) > 1e6)
        return sc_wrong_type(ctx, node, field->type->expected);
    end += strspn(end, " ");
    if (*end && strcmp(end, "%") && strcmp(end, "mm"))
        return sc_wrong_type(ctx, node, field->type->expected);
    *place = (sc_place){.value = value, .percent = *end == '%'};
    return SC_OK;
}

static sc_status write_place(const sc_ctx *ctx, const sc_field *field, const void *from, int indent,
                             sc_text *text)
{
    const sc_place *place = (const sc_place *)((const char *)from + field->offset);

    (void)indent;
    return sc_text_add(ctx, text, "%.12g%s", place->value, place->percent ? "%" : " mm");
}

/* Two shares of the animation, from and to, as two doubles. */
static sc_status parse_span(const sc_ctx *ctx, const sc_field *field, const sc_yaml *node, void *to)
{
    double *span = (double *)((char *)to + field->offset);
    sc_place ends[2] = {0};
    const sc_field each[2] = {{.type = field->type, .offset = 0}, {.type = field->type}};

    if (node->kind != SC_YAML_LIST || node->count != 2)
        return sc_wrong_type(ctx, node, field->type->expected);
    for (int i = 0; i < 2; i++) {
        sc_status status = parse_place(ctx, &each[i], node->items[i], &ends[i]);

        if (status != SC_OK)
            return status;
        if (!ends[i].percent || ends[i].value < 0 || ends[i].value > 100 ||
            (i && ends[1].value < ends[0].value))
            return sc_wrong_type(ctx, node->items[i], field->type->expected);
        span[i] = ends[i].value / 100;
    }
    return SC_OK;
}

static sc_status write_span(const sc_ctx *ctx, const sc_field *field, const void *from, int indent,
                            sc_text *text)
{
    const double *span = (const double *)((const char *)from + field->offset);

    (void)indent;
    return sc_text_add(ctx, text, "[%.12g%%, %.12g%%]", 100 * span[0], 100 * span[1]);
}

const sc_field_type sc_type_place = {"a place such as 40% or 12 mm", parse_place, write_place,
                                     NULL};
const sc_field_type sc_type_span = {"two rising shares of the animation, such as [0%, 50%]",
                                    parse_span, write_span, NULL};

/* ---- camera ---- */

static const sc_field ramp_fields[] = {
    {.name = "from",
     .type = &sc_type_real,
     .offset = offsetof(sc_ramp, from),
     .low = 0.01,
     .high = 1000},
    {.name = "to",
     .type = &sc_type_real,
     .offset = offsetof(sc_ramp, to),
     .low = 0.01,
     .high = 1000},
    {.name = "during", .type = &sc_type_span, .offset = offsetof(sc_ramp, begin)},
    {.name = "ease",
     .type = &sc_type_choice,
     .offset = offsetof(sc_ramp, ease),
     .choices = sc_ease_names},
    {0}};

static sc_status parse_zoom(const sc_ctx *ctx, const sc_field *field, const sc_yaml *node, void *to)
{
    sc_ramp *zoom = (sc_ramp *)((char *)to + field->offset);
    sc_status status;

    if (node->kind == SC_YAML_MAP)
        return sc_fields_parse(ctx, ramp_fields, node, zoom);
    status = sc_parse_real(ctx, node, 0.01, 1000, &zoom->from);
    zoom->to = zoom->from;
    return status;
}

static sc_status write_zoom(const sc_ctx *ctx, const sc_field *field, const void *from, int indent,
                            sc_text *text)
{
    (void)indent;
    return sc_fields_write_flow(ctx, ramp_fields, (const char *)from + field->offset, text);
}

const sc_field_type sc_type_zoom = {"a number or {from, to, during, ease}", parse_zoom, write_zoom,
                                    NULL};

static bool no_target(const sc_field *field, const void *from)
{
    (void)field;
    return !((const sc_orbit *)from)->has_target;
}

static bool no_distance(const sc_field *field, const void *from)
{
    (void)field;
    return !((const sc_orbit *)from)->has_distance;
}

static sc_status parse_target(const sc_ctx *ctx, const sc_field *field, const sc_yaml *node,
                              void *to)
{
    ((sc_orbit *)to)->has_target = true;
    return sc_type_point.parse(ctx, field, node, to);
}

static sc_status parse_distance(const sc_ctx *ctx, const sc_field *field, const sc_yaml *node,
                                void *to)
{
    ((sc_orbit *)to)->has_distance = true;
    return sc_type_real.parse(ctx, field, node, to);
}

static sc_status write_target(const sc_ctx *ctx, const sc_field *field, const void *from,
                              int indent, sc_text *text)
{
    return sc_type_point.write(ctx, field, from, indent, text);
}

static sc_status write_distance(const sc_ctx *ctx, const sc_field *field, const void *from,
                                int indent, sc_text *text)
{
    return sc_type_real.write(ctx, field, from, indent, text);
}

static const sc_field_type type_target = {"[x, y, z]", parse_target, write_target, no_target};
static const sc_field_type type_distance = {"a number", parse_distance, write_distance,
                                            no_distance};

#define FOV_FIELD                                                                                  \
    {                                                                                              \
        .name = "fov", .type = &sc_type_real, .offset = offsetof(sc_orbit, fov_deg), .low = 0.1,   \
        .high = 170                                                                                \
    }

static const sc_field orbit_fields[] = {{.name = "axis",
                                         .type = &sc_type_direction,
                                         .offset = offsetof(sc_orbit, axis),
                                         .low = -1e6,
                                         .high = 1e6},
                                        {.name = "turns",
                                         .type = &sc_type_real,
                                         .offset = offsetof(sc_orbit, turns),
                                         .low = -1000,
                                         .high = 1000},
                                        {.name = "elevation",
                                         .type = &sc_type_real,
                                         .offset = offsetof(sc_orbit, elevation_deg),
                                         .low = -89.9,
                                         .high = 89.9},
                                        {.name = "start",
                                         .type = &sc_type_real,
                                         .offset = offsetof(sc_orbit, start_deg),
                                         .low = -3600,
                                         .high = 3600},
                                        {.name = "target_mm",
                                         .type = &type_target,
                                         .offset = offsetof(sc_orbit, target_mm),
                                         .low = -1e6,
                                         .high = 1e6},
                                        {.name = "distance_mm",
                                         .type = &type_distance,
                                         .offset = offsetof(sc_orbit, distance_mm),
                                         .low = 1e-3,
                                         .high = 1e6},
                                        FOV_FIELD,
                                        {0}};

static const sc_field fixed_fields[] = {{.name = "position_mm",
                                         .type = &sc_type_point,
                                         .offset = offsetof(sc_orbit, position_mm),
                                         .low = -1e6,
                                         .high = 1e6},
                                        {.name = "target_mm",
                                         .type = &sc_type_point,
                                         .offset = offsetof(sc_orbit, target_mm),
                                         .low = -1e6,
                                         .high = 1e6},
                                        {.name = "up",
                                         .type = &sc_type_direction,
                                         .offset = offsetof(sc_orbit, up),
                                         .low = -1e6,
                                         .high = 1e6},
                                        FOV_FIELD,
                                        {0}};

static sc_status parse_orbit(const sc_ctx *ctx, const sc_field *field, const sc_yaml *node,
                             void *to)
{
    if (node->kind != SC_YAML_MAP)
        return sc_wrong_type(ctx, node, field->type->expected);
    if (((sc_orbit *)to)->fixed)
        return sc_yaml_fail(ctx, node, "camera holds both orbit and fixed, expected one");
    return sc_fields_parse(ctx, orbit_fields, node, to);
}

static sc_status parse_fixed(const sc_ctx *ctx, const sc_field *field, const sc_yaml *node,
                             void *to)
{
    sc_orbit *camera = to;
    sc_status status;

    if (node->kind != SC_YAML_MAP)
        return sc_wrong_type(ctx, node, field->type->expected);
    if (!sc_yaml_member(node, "position_mm") || !sc_yaml_member(node, "target_mm"))
        return sc_yaml_fail(ctx, node, "a fixed camera needs position_mm and target_mm");
    camera->fixed = true;
    status = sc_fields_parse(ctx, fixed_fields, node, to);
    if (status == SC_OK &&
        sc_vec3_length(sc_vec3_sub(camera->position_mm, camera->target_mm)) < 1e-6)
        return sc_yaml_fail(ctx, node, "position_mm and target_mm are the same point");
    return status;
}

static bool is_fixed(const sc_field *field, const void *from)
{
    (void)field;
    return ((const sc_orbit *)from)->fixed;
}

static bool is_orbit(const sc_field *field, const void *from)
{
    return !is_fixed(field, from);
}

static sc_status write_orbit(const sc_ctx *ctx, const sc_field *field, const void *from, int indent,
                             sc_text *text)
{
    (void)field;
    (void)indent;
    return sc_fields_write_flow(ctx, orbit_fields, from, text);
}

static sc_status write_fixed(const sc_ctx *ctx, const sc_field *field, const void *from, int indent,
                             sc_text *text)
{
    (void)field;
    (void)indent;
    return sc_fields_write_flow(ctx, fixed_fields, from, text);
}

const sc_field_type sc_type_orbit = {"{axis, turns, elevation, ...}", parse_orbit, write_orbit,
                                     is_fixed};
const sc_field_type sc_type_fixed = {"{position_mm, target_mm, up, fov}", parse_fixed, write_fixed,
                                     is_orbit};

/* ---- clip planes ---- */

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
        note_where(item, exception->where, sizeof exception->where);
        job->exception_count++;
    }
    return SC_OK;
}

static sc_status parse_clip_item(const sc_ctx *ctx, const sc_yaml *item, sc_job *job)
{
    static const char *const words[] = {"sweep", "plane", "except"};
    sc_sweep *sweep = &job->animation.sweeps[job->animation.sweep_count];
    const sc_yaml *moving = sc_yaml_member(item, "sweep"), *still = sc_yaml_member(item, "plane");
    const sc_yaml *body = moving ? moving : still;
    sc_status status;

    if (item->kind != SC_YAML_MAP)
        return sc_wrong_type(ctx, item, "{sweep: {...}} or {plane: {...}}");
    for (size_t i = 0; i < item->count; i++) {
        const char *key = item->items[i]->key;

        if (strcmp(key, "sweep") && strcmp(key, "plane") && strcmp(key, "except"))
            return sc_unknown_word(ctx, item->items[i], key, words, SC_COUNT_OF(words));
    }
    if (!moving == !still || body->kind != SC_YAML_MAP)
        return sc_yaml_fail(ctx, item, "a clip item holds either a sweep or a plane");
    if (!sc_yaml_member(body, "normal"))
        return sc_yaml_fail(ctx, body, "a clip plane needs a normal, towards what is kept");
    *sweep = (sc_sweep){.from = {0, true}, .to = {50, true}, .end = 1};
    if (still)
        sweep->from = (sc_place){50, true};
    status = sc_fields_parse(ctx, moving ? sweep_fields : plane_fields, body, sweep);
    if (status != SC_OK)
        return status;
    if (still)
        sweep->to = sweep->from;
    if (sc_yaml_member(item, "except"))
        status =
            parse_exceptions(ctx, sc_yaml_member(item, "except"), job->animation.sweep_count, job);
    job->animation.sweep_count++;
    return status;
}

static sc_status parse_clip(const sc_ctx *ctx, const sc_field *field, const sc_yaml *node, void *to)
{
    sc_status status = SC_OK;

    if (node->kind != SC_YAML_LIST)
        return sc_wrong_type(ctx, node, field->type->expected);
    if (node->count > SC_PLANES_MAX)
        return sc_yaml_fail(ctx, node, "%zu clip planes, expected at most %d", node->count,
                            SC_PLANES_MAX);
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

const sc_field_type sc_type_clip = {"a list of sweeps and planes", parse_clip, write_clip, NULL};

/* ---- tissues ---- */

static sc_status parse_opacity(const sc_ctx *ctx, const sc_field *field, const sc_yaml *node,
                               void *to)
{
    sc_tissue_rule *rule = to;

    (void)field;
    rule->has_opacity = true;
    rule->opacity_auto = node->kind == SC_YAML_SCALAR && !strcmp(node->text, "auto");
    if (rule->opacity_auto)
        return SC_OK;
    if (node->kind == SC_YAML_SCALAR && (node->text[0] < '0' || node->text[0] > '9') &&
        node->text[0] != '.')
        return sc_wrong_type(ctx, node, "auto or a number from 0 to 1");
    return sc_parse_real(ctx, node, 0, 1, &rule->opacity);
}

static sc_status write_opacity(const sc_ctx *ctx, const sc_field *field, const void *from,
                               int indent, sc_text *text)
{
    const sc_tissue_rule *rule = from;

    (void)field;
    (void)indent;
    if (rule->opacity_auto)
        return sc_text_add(ctx, text, "auto");
    return sc_text_add(ctx, text, "%.12g", rule->opacity);
}

static bool no_opacity(const sc_field *field, const void *from)
{
    (void)field;
    return !((const sc_tissue_rule *)from)->has_opacity;
}

static sc_status parse_rule_color(const sc_ctx *ctx, const sc_field *field, const sc_yaml *node,
                                  void *to)
{
    ((sc_tissue_rule *)to)->has_color = true;
    return sc_type_color.parse(ctx, field, node, to);
}

static sc_status write_rule_color(const sc_ctx *ctx, const sc_field *field, const void *from,
                                  int indent, sc_text *text)
{
    return sc_type_color.write(ctx, field, from, indent, text);
}

static bool no_color(const sc_field *field, const void *from)
{
    (void)field;
    return !((const sc_tissue_rule *)from)->has_color;
}

static sc_status parse_visible(const sc_ctx *ctx, const sc_field *field, const sc_yaml *node,
                               void *to)
{
    ((sc_tissue_rule *)to)->has_visible = true;
    return sc_type_bool.parse(ctx, field, node, to);
}

static bool no_visible(const sc_field *field, const void *from)
{
    (void)field;
    return !((const sc_tissue_rule *)from)->has_visible;
}

static sc_status write_visible(const sc_ctx *ctx, const sc_field *field, const void *from,
                               int indent, sc_text *text)
{
    return sc_type_bool.write(ctx, field, from, indent, text);
}

static sc_status parse_interior(const sc_ctx *ctx, const sc_field *field, const sc_yaml *node,
                                void *to)
{
    ((sc_tissue_rule *)to)->has_interior_opacity = true;
    return sc_type_real.parse(ctx, field, node, to);
}

static sc_status write_interior(const sc_ctx *ctx, const sc_field *field, const void *from,
                                int indent, sc_text *text)
{
    return sc_type_real.write(ctx, field, from, indent, text);
}

static bool no_interior(const sc_field *field, const void *from)
{
    (void)field;
    return !((const sc_tissue_rule *)from)->has_interior_opacity;
}

static const sc_field_type type_opacity = {"auto or a number from 0 to 1", parse_opacity,
                                           write_opacity, no_opacity};
static const sc_field_type type_rule_color = {"\"#rrggbb\" or [red, green, blue] from 0 to 255",
                                              parse_rule_color, write_rule_color, no_color};
static const sc_field_type type_visible = {"true or false", parse_visible, write_visible,
                                           no_visible};
static const sc_field_type type_interior = {"a number", parse_interior, write_interior,
                                            no_interior};

static const sc_field rule_fields[] = {
    {.name = "color", .type = &type_rule_color, .offset = offsetof(sc_tissue_rule, rgb)},
    {.name = "opacity", .type = &type_opacity},
    {.name = "interior_opacity",
     .type = &type_interior,
     .offset = offsetof(sc_tissue_rule, interior_opacity),
     .low = 0,
     .high = 1},
    {.name = "visible", .type = &type_visible, .offset = offsetof(sc_tissue_rule, visible)},
    {0}};

static sc_status parse_tissues(const sc_ctx *ctx, const sc_field *field, const sc_yaml *node,
                               void *to)
{
    sc_job *job = to;
    void *rules;
    sc_status status;

    if (node->kind != SC_YAML_MAP)
        return sc_wrong_type(ctx, node, field->type->expected);
    status = sc_zalloc(ctx, node->count, sizeof *job->rules, &rules);
    if (status != SC_OK)
        return status;
    job->rules = rules;
    for (size_t i = 0; i < node->count && status == SC_OK; i++) {
        const sc_yaml *item = node->items[i];
        sc_tissue_rule *rule = &job->rules[job->rule_count++];

        if (strlen(item->key) >= SC_NAME_BYTES)
            return sc_yaml_fail(ctx, item, "a tissue's name has %zu characters", strlen(item->key));
        if (item->kind != SC_YAML_MAP)
            return sc_wrong_type(ctx, item, "{color, opacity, interior_opacity, visible}");
        strcpy(rule->pattern, item->key);
        note_where(item, rule->where, sizeof rule->where);
        status = sc_fields_parse(ctx, rule_fields, item, rule);
    }
    return status;
}

static sc_status write_tissues(const sc_ctx *ctx, const sc_field *field, const void *from,
                               int indent, sc_text *text)
{
    const sc_job *job = from;
    sc_status status = sc_text_add(ctx, text, "%s", job->rule_count ? "" : "{}");

    (void)field;
    for (size_t i = 0; i < job->rule_count && status == SC_OK; i++) {
        SC_TRY(sc_text_add(ctx, text, "\n%*s\"%s\": ", indent + 2, "", job->rules[i].pattern));
        status = sc_fields_write_flow(ctx, rule_fields, &job->rules[i], text);
    }
out:
    return status;
}

const sc_field_type sc_type_tissues = {"a map of tissues", parse_tissues, write_tissues, NULL};
