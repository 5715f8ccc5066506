/* SPDX-License-Identifier: BSD-3-Clause */
/* Values of the light: where the lamp stands, and the picture of the sky. */
#include "key.h"
#include "segcast/job.h"

#include <math.h>
#include <string.h>

/* Read a sc_lamp: to what it is fixed, body or camera; angle, elevation, width and height. */
static sc_status read_lamp(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    const sc_key any = {.type = key->type, .low = -360, .high = 360};
    const char *to = node->kind == SC_YAML_MAP && node->count == 1 ? node->items[0]->key : "";
    const bool follows = !strcmp(to, "camera");
    double n[4];

    if (!follows && strcmp(to, "body") != 0)
        return sc_wrong_type(ctx, node, key->type->expected);
    SC_PASS(sc_read_numbers(ctx, &any, node->items[0], 4, n));
    if (!(fabs(n[1]) <= 90))
        return sc_yaml_fail(ctx, node, "the elevation of the lamp is %g, expected -90 to 90", n[1]);
    if (!(n[2] > 0 && n[2] <= key->high && n[3] > 0 && n[3] <= key->high))
        return sc_yaml_fail(ctx, node,
                            "the lamp is %g wide and %g high, expected angles above 0, up to %g "
                            "degrees",
                            n[2], n[3], key->high);
    *(sc_lamp *)value = (sc_lamp){true, follows, n[0], n[1], n[2], n[3]};
    return SC_OK;
}

static sc_status write_lamp(const sc_ctx *ctx, const sc_key *key, const void *value, sc_text *text)
{
    const sc_lamp *lamp = value;

    SC_PASS(sc_text_add(ctx, text, "{%s: ", lamp->follows ? "camera" : "body"));
    SC_PASS(sc_write_numbers(
        ctx, (double[]){lamp->angle_deg, lamp->elevation_deg, lamp->width_deg, lamp->height_deg}, 4,
        text));
    return sc_text_add(ctx, text, "}");
}

#define NUMBERS SC_SCHEMA_LIST("{type: number, minimum: -360, maximum: 360}", 4)

const sc_value_type sc_type_lamp = {
    .name = "{body or camera: [angle, elevation, width, height]}",
    .expected = "{body: [angle, elevation, width, height]}, in degrees, or {camera: [...]}",
    .read = read_lamp,
    .write = write_lamp,
    .schema = "{type: object, properties: {body: " NUMBERS ", camera: " NUMBERS
              "}, additionalProperties: false, minProperties: 1, maxProperties: 1}",
};

/* Read a sc_environment: the path of a picture, or a map from it to the angle of its turn. */
static sc_status read_environment(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                                  void *value)
{
    sc_environment *environment = value;
    sc_yaml path = *node;

    environment->turn_deg = 0;
    if (node->kind == SC_YAML_MAP) {
        if (node->count != 1)
            return sc_wrong_type(ctx, node, key->type->expected);
        SC_PASS(sc_read_real(ctx, node->items[0], key->low, key->high, &environment->turn_deg));
        path = *node->items[0];
        path.text = node->items[0]->key;
    }
    return sc_type_text.read(ctx, key, &path, environment->file);
}

static sc_status write_environment(const sc_ctx *ctx, const sc_key *key, const void *value,
                                   sc_text *text)
{
    const sc_environment *environment = value;

    if (environment->turn_deg == 0)
        return sc_type_text.write(ctx, key, environment->file, text);
    SC_PASS(sc_text_add(ctx, text, "{"));
    SC_PASS(sc_type_text.write(ctx, key, environment->file, text));
    SC_PASS(sc_text_add(ctx, text, ": "));
    SC_PASS(sc_write_number(ctx, environment->turn_deg, 1, "", text));
    return sc_text_add(ctx, text, "}");
}

const sc_value_type sc_type_environment = {
    .name = "text, or {text: degrees}",
    .expected = "the path of a Radiance file, or {room.hdr: 90}",
    .read = read_environment,
    .write = write_environment,
    .schema = "{anyOf: [{type: string}, {type: object, additionalProperties: " SC_SCHEMA_NUMBER
              ", minProperties: 1, maxProperties: 1}]}",
};
