/* SPDX-License-Identifier: BSD-3-Clause */
/* Rows of the camera and of the slices, and the types of value that only an animation has. */
#include "key.h"
#include "segcast/timeline.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const sc_choice sc_ease_choices[] = {{"linear", SC_EASE_LINEAR},
                                     {"smooth", SC_EASE_SMOOTH},
                                     {"in", SC_EASE_IN},
                                     {"out", SC_EASE_OUT},
                                     {NULL, 0}};
static const sc_choice projections[] = {
    {"perspective", SC_PERSPECTIVE}, {"orthographic", SC_ORTHOGRAPHIC}, {NULL, 0}};

/* ---- positions of planes, and parts of the animation ---- */

/* Read a number and, behind it, its unit. @param unit "%", "mm", or "" if there is none. @return
 * false if @p node is anything else. */
static bool parse_position(const sc_yaml *node, double *number, const char **unit)
{
    char *end;

    if (node->kind != SC_YAML_SCALAR)
        return false;
    *number = strtod(node->text, &end);
    if (end == node->text || !isfinite(*number) || fabs(*number) > 1e6)
        return false;
    *unit = end + strspn(end, " ");
    return !**unit || !strcmp(*unit, "%") || !strcmp(*unit, "mm");
}

/* Read a plane position: "40%" is 40 percent; "12 mm" is 12 mm. A number without a unit is refused:
 * it would be millimetres to some users and percent to others. */
static sc_status read_plane_position(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                                     void *value)
{
    double number;
    const char *unit;

    if (!parse_position(node, &number, &unit))
        return sc_wrong_type(ctx, node, key->type->expected);
    if (!*unit) {
        char expected[128];
        const bool is_share = number > 0 && number < 1;

        snprintf(expected, sizeof expected, "a unit behind the number: %.12g%% or %.12g mm",
                 is_share ? 100 * number : number, number);
        return sc_wrong_type(ctx, node, expected);
    }
    *(sc_plane_position *)value = (sc_plane_position){.value = number, .percent = *unit == '%'};
    return SC_OK;
}

/* Write what read_plane_position reads: "40%" or "12 mm". */
static sc_status write_plane_position(const sc_ctx *ctx, const sc_key *key, const void *value,
                                      int indent, sc_text *text)
{
    const sc_plane_position *position = value;

    (void)key;
    (void)indent;
    return sc_text_add(ctx, text, "%.12g%s", position->value, position->percent ? "%" : " mm");
}

static json_t *plane_position_schema(const sc_key *key)
{
    (void)key;
    return json_pack("{s:s, s:s}", "type", "string", "pattern",
                     "^-?[0-9.]+([eE][-+]?[0-9]+)? *(%|mm)$");
}

static json_t *share_schema(const sc_key *key)
{
    (void)key;
    return json_pack("{s:s, s:s}", "type", "string", "pattern", "^[0-9.]+ *%$");
}

/* Read a share from 0% to 100%, which is stored as a double from 0 to 1. */
static sc_status read_share(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    double number;
    const char *unit;

    if (!parse_position(node, &number, &unit) || *unit != '%' || number < 0 || number > 100)
        return sc_wrong_type(ctx, node, key->type->expected);
    *(double *)value = number / 100;
    return SC_OK;
}

static sc_status write_share(const sc_ctx *ctx, const sc_key *key, const void *value, int indent,
                             sc_text *text)
{
    (void)key;
    (void)indent;
    return sc_text_add(ctx, text, "%.12g%%", 100 * *(const double *)value);
}

/* Read begin and end of a part of the animation: two shares, stored as two doubles in a row. Other
 * times have become shares before (sc_times_resolve). */
static sc_status read_span(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    double span[2];

    if (node->kind != SC_YAML_LIST || node->count != 2)
        return sc_wrong_type(ctx, node, key->type->expected);
    for (int i = 0; i < 2; i++) {
        const char *unit;

        if (!parse_position(node->items[i], &span[i], &unit) || *unit != '%' || span[i] < 0 ||
            span[i] > 100)
            return sc_wrong_type(ctx, node, key->type->expected);
        span[i] /= 100;
    }
    if (span[1] < span[0])
        return sc_wrong_type(ctx, node, key->type->expected);
    memcpy(value, span, sizeof span);
    return SC_OK;
}

/* Write two doubles from 0 to 1 as "[20%, 80%]". */
static sc_status write_span(const sc_ctx *ctx, const sc_key *key, const void *value, int indent,
                            sc_text *text)
{
    const double *span = value;

    (void)key;
    (void)indent;
    return sc_text_add(ctx, text, "[%.12g%%, %.12g%%]", 100 * span[0], 100 * span[1]);
}

static json_t *span_schema(const sc_key *key)
{
    (void)key;
    return json_pack("{s:s, s:{s:s, s:s}, s:i, s:i}", "type", "array", "items", "type", "string",
                     "pattern", "^([0-9.]+ *(%|f|frames?|s|ms|min)|[0-9]+:[0-5][0-9](\\.[0-9]+)?)$",
                     "minItems", 2, "maxItems", 2);
}

/* Read a time: a number and, behind it, ms, s, min or nothing, which is seconds too. It is stored
 * as a double, in seconds. */
static sc_status read_duration(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                               void *value)
{
    static const struct {
        const char *name;
        double seconds;
    } units[] = {{"", 1}, {"s", 1}, {"ms", 1e-3}, {"min", 60}};
    char *end = NULL;
    double number = 0;

    if (node->kind == SC_YAML_SCALAR)
        number = strtod(node->text, &end);
    if (!end || end == node->text || !(number > 0 && number <= 1e6))
        return sc_wrong_type(ctx, node, key->type->expected);
    end += strspn(end, " ");
    for (size_t i = 0; i < SC_COUNT_OF(units); i++) {
        if (!strcmp(end, units[i].name)) {
            *(double *)value = number * units[i].seconds;
            return SC_OK;
        }
    }
    return sc_wrong_type(ctx, node, key->type->expected);
}

static sc_status write_duration(const sc_ctx *ctx, const sc_key *key, const void *value, int indent,
                                sc_text *text)
{
    (void)key;
    (void)indent;
    return sc_text_add(ctx, text, "%.12g s", *(const double *)value);
}

static json_t *duration_schema(const sc_key *key)
{
    (void)key;
    return json_pack("{s:[{s:s}, {s:s, s:s}]}", "anyOf", "type", "number", "type", "string",
                     "pattern", "^[0-9.]+ *(ms|s|min)?$");
}

const sc_value_type sc_type_duration = {
    .name = "time",
    .expected = "a time such as 10s, 1.5 min or 500 ms",
    .read = read_duration,
    .write = write_duration,
    .schema = duration_schema,
};
const sc_value_type sc_type_plane_position = {
    .name = "position",
    .expected = "a position such as 40% or 12 mm",
    .read = read_plane_position,
    .write = write_plane_position,
    .schema = plane_position_schema,
};
const sc_value_type sc_type_share = {
    .name = "share",
    .expected = "a share from 0% to 100%, with its % sign",
    .read = read_share,
    .write = write_share,
    .schema = share_schema,
};
const sc_value_type sc_type_span = {
    .name = "[begin, end]",
    .expected = "two rising times of the animation, such as [0%, 50%], [1.5s, 0:10] or [0f, 45f]",
    .read = read_span,
    .write = write_span,
    .schema = span_schema,
};

/* ---- camera ---- */

static const sc_key ramp_keys[] = {{"from", &sc_type_real, offsetof(sc_ramp, from), "1",
                                    .help = "scale at the beginning", .low = 0.01, .high = 1000},
                                   {"to", &sc_type_real, offsetof(sc_ramp, to), "1",
                                    .help = "scale at the end", .low = 0.01, .high = 1000},
                                   {"during", &sc_type_span, offsetof(sc_ramp, begin), "[0%, 100%]",
                                    .help = "part of the animation in which the scale changes"},
                                   {"ease", &sc_type_choice, offsetof(sc_ramp, ease), "linear",
                                    .help = "how the change begins and ends",
                                    .choices = sc_ease_choices},
                                   {0}};

/* Read a map of ramp_keys, or a number that holds for the whole animation, into an sc_ramp. */
static sc_status read_zoom(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    sc_ramp *zoom = value;
    sc_status status;

    if (node->kind == SC_YAML_MAP)
        return sc_keys_read(ctx, key->keys, node, zoom);
    status = sc_read_real(ctx, node, key->low, key->high, &zoom->from);
    if (status == SC_OK)
        zoom->to = zoom->from;
    return status;
}

static sc_status write_zoom(const sc_ctx *ctx, const sc_key *key, const void *value, int indent,
                            sc_text *text)
{
    (void)indent;
    return sc_keys_write_flow(ctx, key->keys, value, text);
}

static json_t *zoom_schema(const sc_key *key)
{
    return json_pack("{s:[{s:s, s:f, s:f}, o]}", "anyOf", "type", "number", "minimum", key->low,
                     "maximum", key->high, sc_keys_schema(key->keys));
}

const sc_value_type sc_type_zoom = {
    .name = "number or map",
    .expected = "a number or {from, to, during, ease}",
    .read = read_zoom,
    .write = write_zoom,
    .schema = zoom_schema,
    .container = SC_CONTAINER_MAP,
};

#define CAMERA(member) offsetof(sc_orbit, member)
#define FOV_HELP "vertical angle of view; for projection: perspective"

static const sc_key orbit_keys[] = {
    {"axis", &sc_type_direction, CAMERA(axis), "superior",
     .help = "axis about which the camera turns; it points up in the picture", .low = -1e6,
     .high = 1e6, .option = &(const sc_key_option){"axis", "WORD", "orbit"}},
    {"turns", &sc_type_real, CAMERA(turns), "1",
     .help = "number of turns; negative ones go the other way", .low = -1000, .high = 1000,
     .option = &(const sc_key_option){"turns", "N", "orbit"}},
    {"elevation", &sc_type_real, CAMERA(elevation_deg), "15",
     .help = "angle of the camera above the plane of the turn", .low = -89.9, .high = 89.9,
     .unit = "degrees", .option = &(const sc_key_option){"elevation", "DEGREES", "orbit"}},
    {"start", &sc_type_real, CAMERA(start_deg), "0",
     .help = "where the turn begins: 0 is in front of the patient, 90 at the patient's left",
     .low = -3600, .high = 3600, .unit = "degrees"},
    {"target_mm", &sc_type_point, CAMERA(target_mm), NULL, .help = "point that the camera looks at",
     .low = -1e6, .high = 1e6, .unit = "mm", .given = SC_GIVEN(sc_orbit, has_target),
     .without = "so that what is visible stays in the middle"},
    {"distance_mm", &sc_type_real, CAMERA(distance_mm), NULL,
     .help = "distance of the camera from its target", .low = 1e-3, .high = 1e6, .unit = "mm",
     .given = SC_GIVEN(sc_orbit, has_distance),
     .without = "so that what is visible fits into all frames"},
    {"fov", &sc_type_real, CAMERA(fov_deg), "30", .help = FOV_HELP, .low = 0.1, .high = 170,
     .unit = "degrees"},
    {0}};

static const sc_key fixed_keys[] = {
    {"position_mm", &sc_type_point, CAMERA(position_mm), NULL, .help = "where the camera stands",
     .low = -1e6, .high = 1e6, .unit = "mm", .required = true},
    {"target_mm", &sc_type_point, CAMERA(target_mm), NULL, .help = "point that the camera looks at",
     .low = -1e6, .high = 1e6, .unit = "mm", .required = true},
    {"up", &sc_type_direction, CAMERA(up), "superior",
     .help = "direction that points up in the picture", .low = -1e6, .high = 1e6},
    {"fov", &sc_type_real, CAMERA(fov_deg), "30", .help = FOV_HELP, .low = 0.1, .high = 170,
     .unit = "degrees"},
    {0}};

const sc_key sc_camera_keys[] = {
    {"orbit", &sc_type_flow_map, 0, NULL, .help = "a camera that turns about what is visible",
     .keys = orbit_keys, .alternative = "orbit or fixed"},
    {"fixed", &sc_type_flow_map, 0, NULL, .help = "a camera that stands still", .keys = fixed_keys,
     .alternative = "orbit or fixed", .given = SC_GIVEN(sc_orbit, fixed)},
    {"projection", &sc_type_choice, CAMERA(projection), "perspective",
     .help = "perspective, or orthographic: parallel rays", .choices = projections},
    {"zoom", &sc_type_zoom, CAMERA(zoom), NULL,
     .help = "scale of the picture: a number, or a map for one that changes", .low = 0.01,
     .high = 1000, .keys = ramp_keys, .shorthand = "from",
     .option = &(const sc_key_option){"zoom", "FACTOR", "orbit"}},
    {0}};

/* ---- slices ---- */

const sc_key sc_slices_keys[] = {
    {"point_mm", &sc_type_point, offsetof(sc_slices, point_mm), NULL,
     .help = "where the three slices cross, in all frames", .low = -1e6, .high = 1e6, .unit = "mm",
     .given = SC_GIVEN(sc_slices, has_point), .without = "the slices move, by from and to",
     .option = &(const sc_key_option){"point", "R,A,S", "views"}},
    {"from", &sc_type_share, offsetof(sc_slices, share.from), "0%",
     .help = "where the slices begin, as a share of the way through what is visible"},
    {"to", &sc_type_share, offsetof(sc_slices, share.to), "100%", .help = "where the slices end"},
    {"during", &sc_type_span, offsetof(sc_slices, share.begin), "[0%, 100%]",
     .help = "part of the animation in which the slices move"},
    {"ease", &sc_type_choice, offsetof(sc_slices, share.ease), "linear",
     .help = "how the movement begins and ends", .choices = sc_ease_choices},
    {0}};
