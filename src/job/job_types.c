/* SPDX-License-Identifier: BSD-3-Clause */
/* Types of job keys that only a job has: places, spans and cameras. */
#include "job_fields.h"

#include <stdlib.h>
#include <string.h>

const char *const sc_ease_names[] = {"linear", "smooth", "in", "out", NULL};
const char *const sc_projection_names[] = {"perspective", "orthographic", NULL};

void sc_note_where(const sc_yaml *node, char *where, size_t size)
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

/* ---- slices ---- */

static sc_status parse_point(const sc_ctx *ctx, const sc_field *field, const sc_yaml *node,
                             void *to)
{
    ((sc_slices *)to)->has_point = true;
    return sc_type_point.parse(ctx, field, node, to);
}

static sc_status write_point(const sc_ctx *ctx, const sc_field *field, const void *from, int indent,
                             sc_text *text)
{
    return sc_type_point.write(ctx, field, from, indent, text);
}

static bool no_point(const sc_field *field, const void *from)
{
    (void)field;
    return !((const sc_slices *)from)->has_point;
}

static const sc_field_type type_point = {"[x, y, z]", parse_point, write_point, no_point};

/* A share of what is shown, written as 40%. */
static sc_status parse_share(const sc_ctx *ctx, const sc_field *field, const sc_yaml *node,
                             void *to)
{
    const sc_field each = {.type = &sc_type_place};
    sc_place place = {0};
    sc_status status = parse_place(ctx, &each, node, &place);

    if (status != SC_OK)
        return status;
    if (!place.percent || place.value < 0 || place.value > 100)
        return sc_wrong_type(ctx, node, field->type->expected);
    *(double *)((char *)to + field->offset) = place.value / 100;
    return SC_OK;
}

static sc_status write_share(const sc_ctx *ctx, const sc_field *field, const void *from, int indent,
                             sc_text *text)
{
    (void)indent;
    return sc_text_add(ctx, text, "%.12g%%",
                       100 * *(const double *)((const char *)from + field->offset));
}

static const sc_field_type type_share = {"a share from 0% to 100%", parse_share, write_share, NULL};

static const sc_field slice_fields[] = {
    {.name = "point_mm",
     .type = &type_point,
     .offset = offsetof(sc_slices, point_mm),
     .low = -1e6,
     .high = 1e6},
    {.name = "from", .type = &type_share, .offset = offsetof(sc_slices, share.from)},
    {.name = "to", .type = &type_share, .offset = offsetof(sc_slices, share.to)},
    {.name = "during", .type = &sc_type_span, .offset = offsetof(sc_slices, share.begin)},
    {.name = "ease",
     .type = &sc_type_choice,
     .offset = offsetof(sc_slices, share.ease),
     .choices = sc_ease_names},
    {0}};

static sc_status parse_slices(const sc_ctx *ctx, const sc_field *field, const sc_yaml *node,
                              void *to)
{
    if (node->kind != SC_YAML_MAP)
        return sc_wrong_type(ctx, node, field->type->expected);
    return sc_fields_parse(ctx, slice_fields, node, (char *)to + field->offset);
}

static sc_status write_slices(const sc_ctx *ctx, const sc_field *field, const void *from,
                              int indent, sc_text *text)
{
    (void)indent;
    return sc_fields_write_flow(ctx, slice_fields, (const char *)from + field->offset, text);
}

const sc_field_type sc_type_slices = {"{point_mm} or {from, to, during, ease}", parse_slices,
                                      write_slices, NULL};
