/* SPDX-License-Identifier: BSD-3-Clause */
/* Strengths of smoothing: one number, or three along the axes of the volume. */
#include "key.h"
#include "segcast/job.h"

/* The value of a macro as a string literal. */
#define TEXT(macro) TEXT_OF(macro)
#define TEXT_OF(number) #number

#define STRENGTHS                                                                                  \
    "a number from 0 to " TEXT(SC_SMOOTH_MAX) ", or three such in a list, along the axes of the "  \
                                              "volume"

/* Is @p node a list, or a text with commas between numbers? */
static bool is_list(const sc_yaml *node)
{
    return node->kind == SC_YAML_LIST ||
           (node->kind == SC_YAML_SCALAR && strchr(node->text, ',') != NULL);
}

/* sc_vec3: a number, which is meant for all axes, or a list of three. */
static sc_status read_strength(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                               void *value)
{
    double along[3];

    if (is_list(node))
        SC_PASS(sc_read_numbers(ctx, key, node, 3, along));
    else if (!sc_parse_number(node, &along[0]) || !(along[0] >= key->low && along[0] <= key->high))
        return sc_wrong_type(ctx, node, key->type->expected);
    else
        along[1] = along[2] = along[0];
    *(sc_vec3 *)value = (sc_vec3){along[0], along[1], along[2]};
    return SC_OK;
}

/* As one number if all three are the same, else as "[x, y, z]". */
static sc_status write_strength(const sc_ctx *ctx, const sc_key *key, const void *value,
                                sc_text *text)
{
    const sc_vec3 *s = value;

    if (sc_strength_is_same(*s, (sc_vec3){s->x, s->x, s->x}))
        return sc_write_number(ctx, s->x, 1, "", text);
    return sc_write_numbers(ctx, (double[]){s->x, s->y, s->z}, 3, text);
}

/* What read_strength reads, or "auto", which is stored as SC_SMOOTH_IS_AUTO along all axes. */
static sc_status read_smooth(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    if (node->kind != SC_YAML_SCALAR || strcmp(node->text, "auto") != 0)
        return read_strength(ctx, key, node, value);
    *(sc_vec3 *)value = (sc_vec3){SC_SMOOTH_IS_AUTO, SC_SMOOTH_IS_AUTO, SC_SMOOTH_IS_AUTO};
    return SC_OK;
}

static sc_status write_smooth(const sc_ctx *ctx, const sc_key *key, const void *value,
                              sc_text *text)
{
    return sc_smooth_is_auto(*(const sc_vec3 *)value) ? sc_text_add(ctx, text, "auto")
                                                      : write_strength(ctx, key, value, text);
}

const sc_value_type sc_type_strength = {
    .name = "number or [x, y, z]",
    .expected = STRENGTHS,
    .read = read_strength,
    .write = write_strength,
    .schema = "{anyOf: [" SC_SCHEMA_NUMBER ", " SC_SCHEMA_LIST(SC_SCHEMA_NUMBER, 3) "]}",
};
const sc_value_type sc_type_smooth = {
    .name = "number, [x, y, z] or auto",
    .expected = "auto, " STRENGTHS,
    .read = read_smooth,
    .write = write_smooth,
    .schema =
        "{anyOf: [" SC_SCHEMA_NUMBER ", " SC_SCHEMA_LIST(SC_SCHEMA_NUMBER, 3) ", {enum: [auto]}]}",
};
