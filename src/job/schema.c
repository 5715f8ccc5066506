/* SPDX-License-Identifier: BSD-3-Clause */
#include "schema.h"

#include "segcast/timeline.h"

#include <stdlib.h>
#include <string.h>

static void *place(const sc_field *field, void *base)
{
    return (char *)base + field->offset;
}

static const void *source(const sc_field *field, const void *base)
{
    return (const char *)base + field->offset;
}

sc_status sc_wrong_type(const sc_ctx *ctx, const sc_yaml *node, const char *expected)
{
    static const char *const kinds[] = {"a value", "a map", "a list"};

    if (node->kind == SC_YAML_SCALAR)
        return sc_yaml_fail(ctx, node, "%s%sis \"%s\", expected %s", node->key ? node->key : "",
                            node->key ? " " : "", node->text, expected);
    return sc_yaml_fail(ctx, node, "%s%sis %s, expected %s", node->key ? node->key : "",
                        node->key ? " " : "", kinds[node->kind], expected);
}

sc_status sc_unknown_word(const sc_ctx *ctx, const sc_yaml *node, const char *word,
                          const char *const *words, size_t count)
{
    const char *nearest = sc_nearest_word(word, words, count);
    char all[512] = "";

    if (nearest)
        return sc_yaml_fail(ctx, node, "unknown %s \"%s\"; did you mean \"%s\"?",
                            node->key && strcmp(node->key, word) ? node->key : "key", word,
                            nearest);
    for (size_t i = 0; i < count; i++) {
        const size_t used = strlen(all);

        snprintf(all + used, sizeof all - used, "%s%s", i ? ", " : "", words[i]);
    }
    return sc_yaml_fail(ctx, node, "unknown %s \"%s\"; expected one of: %s",
                        node->key && strcmp(node->key, word) ? node->key : "key", word, all);
}

sc_status sc_parse_real(const sc_ctx *ctx, const sc_yaml *node, double low, double high,
                        double *out)
{
    char range[96], *end;
    double value;

    snprintf(range, sizeof range, "a number from %g to %g", low, high);
    if (node->kind != SC_YAML_SCALAR)
        return sc_wrong_type(ctx, node, range);
    value = strtod(node->text, &end);
    if (end == node->text || *end || !(value >= low && value <= high))
        return sc_wrong_type(ctx, node, range);
    *out = value;
    return SC_OK;
}

static sc_status parse_bool(const sc_ctx *ctx, const sc_field *field, const sc_yaml *node, void *to)
{
    const bool yes = node->kind == SC_YAML_SCALAR && !strcmp(node->text, "true");

    if (!yes && (node->kind != SC_YAML_SCALAR || strcmp(node->text, "false")))
        return sc_wrong_type(ctx, node, field->type->expected);
    *(bool *)place(field, to) = yes;
    return SC_OK;
}

static sc_status write_bool(const sc_ctx *ctx, const sc_field *field, const void *from, int indent,
                            sc_text *text)
{
    (void)indent;
    return sc_text_add(ctx, text, *(const bool *)source(field, from) ? "true" : "false");
}

static sc_status parse_int(const sc_ctx *ctx, const sc_field *field, const sc_yaml *node, void *to)
{
    double value = 0;
    sc_status status = sc_parse_real(ctx, node, field->low, field->high, &value);

    if (status != SC_OK)
        return status;
    if (value != (int)value)
        return sc_wrong_type(ctx, node, field->type->expected);
    *(int *)place(field, to) = (int)value;
    return SC_OK;
}

static sc_status write_int(const sc_ctx *ctx, const sc_field *field, const void *from, int indent,
                           sc_text *text)
{
    (void)indent;
    return sc_text_add(ctx, text, "%d", *(const int *)source(field, from));
}

static sc_status parse_real(const sc_ctx *ctx, const sc_field *field, const sc_yaml *node, void *to)
{
    return sc_parse_real(ctx, node, field->low, field->high, place(field, to));
}

static sc_status write_real(const sc_ctx *ctx, const sc_field *field, const void *from, int indent,
                            sc_text *text)
{
    (void)indent;
    return sc_text_add(ctx, text, "%.12g", *(const double *)source(field, from));
}

static sc_status parse_text(const sc_ctx *ctx, const sc_field *field, const sc_yaml *node, void *to)
{
    const size_t size = (size_t)field->high;

    if (node->kind != SC_YAML_SCALAR)
        return sc_wrong_type(ctx, node, field->type->expected);
    if (strlen(node->text) >= size)
        return sc_yaml_fail(ctx, node, "%s has %zu characters, expected less than %zu", field->name,
                            strlen(node->text), size);
    strcpy(place(field, to), node->text);
    return SC_OK;
}

static sc_status write_text(const sc_ctx *ctx, const sc_field *field, const void *from, int indent,
                            sc_text *text)
{
    sc_status status = sc_text_add(ctx, text, "\"");

    (void)indent;
    for (const char *c = source(field, from); *c && status == SC_OK; c++)
        status = sc_text_add(ctx, text, *c == '"' || *c == '\\' ? "\\%c" : "%c", *c);
    return status == SC_OK ? sc_text_add(ctx, text, "\"") : status;
}

static sc_status parse_choice(const sc_ctx *ctx, const sc_field *field, const sc_yaml *node,
                              void *to)
{
    size_t count = 0;

    if (node->kind != SC_YAML_SCALAR)
        return sc_wrong_type(ctx, node, field->type->expected);
    for (; field->choices[count]; count++) {
        if (!strcmp(node->text, field->choices[count])) {
            *(int *)place(field, to) = (int)count;
            return SC_OK;
        }
    }
    return sc_unknown_word(ctx, node, node->text, field->choices, count);
}

static sc_status write_choice(const sc_ctx *ctx, const sc_field *field, const void *from,
                              int indent, sc_text *text)
{
    (void)indent;
    return sc_text_add(ctx, text, "%s", field->choices[*(const int *)source(field, from)]);
}

static sc_status parse_numbers(const sc_ctx *ctx, const sc_field *field, const sc_yaml *node,
                               size_t count, double *out)
{
    sc_status status = SC_OK;

    if (node->kind != SC_YAML_LIST || node->count != count)
        return sc_wrong_type(ctx, node, field->type->expected);
    for (size_t i = 0; i < count && status == SC_OK; i++)
        status = sc_parse_real(ctx, node->items[i], field->low, field->high, &out[i]);
    return status;
}

static sc_status parse_color(const sc_ctx *ctx, const sc_field *field, const sc_yaml *node,
                             void *to)
{
    uint8_t *rgb = place(field, to);
    unsigned r, g, b;
    int used = 0;

    if (node->kind == SC_YAML_LIST && node->count == 3) {
        for (int i = 0; i < 3; i++) {
            double level;
            sc_status status = sc_parse_real(ctx, node->items[i], 0, 255, &level);

            if (status != SC_OK)
                return status;
            rgb[i] = (uint8_t)level;
        }
        return SC_OK;
    }
    if (node->kind != SC_YAML_SCALAR || strlen(node->text) != 7 ||
        sscanf(node->text, "#%2x%2x%2x%n", &r, &g, &b, &used) != 3 || used != 7)
        return sc_wrong_type(ctx, node, field->type->expected);
    rgb[0] = (uint8_t)r;
    rgb[1] = (uint8_t)g;
    rgb[2] = (uint8_t)b;
    return SC_OK;
}

static sc_status write_color(const sc_ctx *ctx, const sc_field *field, const void *from, int indent,
                             sc_text *text)
{
    const uint8_t *rgb = source(field, from);

    (void)indent;
    return sc_text_add(ctx, text, "[%d, %d, %d]", rgb[0], rgb[1], rgb[2]);
}

static sc_status parse_size(const sc_ctx *ctx, const sc_field *field, const sc_yaml *node, void *to)
{
    double size[2] = {0};
    sc_status status = parse_numbers(ctx, field, node, 2, size);

    for (int i = 0; i < 2 && status == SC_OK; i++) {
        if (size[i] != (int)size[i])
            return sc_wrong_type(ctx, node->items[i], "a whole number of pixels");
        ((int *)place(field, to))[i] = (int)size[i];
    }
    return status;
}

static sc_status write_size(const sc_ctx *ctx, const sc_field *field, const void *from, int indent,
                            sc_text *text)
{
    const int *size = source(field, from);

    (void)indent;
    return sc_text_add(ctx, text, "[%d, %d]", size[0], size[1]);
}

static sc_status parse_point(const sc_ctx *ctx, const sc_field *field, const sc_yaml *node,
                             void *to)
{
    double p[3] = {0};
    sc_status status = parse_numbers(ctx, field, node, 3, p);

    if (status == SC_OK)
        *(sc_vec3 *)place(field, to) = (sc_vec3){p[0], p[1], p[2]};
    return status;
}

static sc_status write_point(const sc_ctx *ctx, const sc_field *field, const void *from, int indent,
                             sc_text *text)
{
    const sc_vec3 *p = source(field, from);

    (void)indent;
    return sc_text_add(ctx, text, "[%.12g, %.12g, %.12g]", p->x, p->y, p->z);
}

static sc_status parse_direction(const sc_ctx *ctx, const sc_field *field, const sc_yaml *node,
                                 void *to)
{
    sc_vec3 *direction = place(field, to);
    size_t count;
    const char *const *words = sc_anatomical_words(&count);
    sc_status status;

    if (node->kind == SC_YAML_SCALAR) {
        if (sc_anatomical_direction(node->text, direction))
            return SC_OK;
        return sc_unknown_word(ctx, node, node->text, words, count);
    }
    status = parse_point(ctx, field, node, to);
    if (status != SC_OK)
        return status;
    if (sc_vec3_length(*direction) < 1e-9)
        return sc_yaml_fail(ctx, node, "%s has length zero, expected a direction", field->name);
    *direction = sc_vec3_unit(*direction);
    return SC_OK;
}

static sc_status parse_map(const sc_ctx *ctx, const sc_field *field, const sc_yaml *node, void *to)
{
    if (node->kind != SC_YAML_MAP)
        return sc_wrong_type(ctx, node, field->type->expected);
    return sc_fields_parse(ctx, field->fields, node, place(field, to));
}

const sc_field_type sc_type_bool = {"true or false", parse_bool, write_bool, NULL};
const sc_field_type sc_type_int = {"a whole number", parse_int, write_int, NULL};
const sc_field_type sc_type_real = {"a number", parse_real, write_real, NULL};
const sc_field_type sc_type_text = {"a text", parse_text, write_text, NULL};
const sc_field_type sc_type_choice = {"a word", parse_choice, write_choice, NULL};
const sc_field_type sc_type_color = {"\"#rrggbb\" or [red, green, blue] from 0 to 255", parse_color,
                                     write_color, NULL};
const sc_field_type sc_type_size = {"[width, height] in pixels", parse_size, write_size, NULL};
const sc_field_type sc_type_point = {"[x, y, z]", parse_point, write_point, NULL};
const sc_field_type sc_type_direction = {"an anatomical word or [x, y, z]", parse_direction,
                                         write_point, NULL};
const sc_field_type sc_type_map = {"a map of keys", parse_map, NULL, NULL};

static sc_status unknown_key(const sc_ctx *ctx, const sc_field *fields, const sc_yaml *node)
{
    const char *names[64];
    size_t count = 0;

    for (; fields[count].name && count < SC_COUNT_OF(names); count++)
        names[count] = fields[count].name;
    return sc_unknown_word(ctx, node, node->key, names, count);
}

sc_status sc_fields_parse(const sc_ctx *ctx, const sc_field *fields, const sc_yaml *node, void *to)
{
    for (size_t i = 0; i < node->count; i++) {
        const sc_field *field = fields;
        sc_status status;

        while (field->name && strcmp(field->name, node->items[i]->key))
            field++;
        if (!field->name)
            return unknown_key(ctx, fields, node->items[i]);
        status = field->type->parse(ctx, field, node->items[i], to);
        if (status != SC_OK)
            return status;
    }
    return SC_OK;
}

sc_status sc_fields_write(const sc_ctx *ctx, const sc_field *fields, const void *from, int indent,
                          bool identity, sc_text *text)
{
    sc_status status = SC_OK;

    for (const sc_field *field = fields; field->name && status == SC_OK; field++) {
        if ((identity && field->aside) || (field->type->absent && field->type->absent(field, from)))
            continue;
        status = sc_text_add(ctx, text, "%*s%s:", indent, "", field->name);
        if (status != SC_OK)
            return status;
        if (field->type == &sc_type_map) {
            status = sc_text_add(ctx, text, "\n");
            if (status == SC_OK)
                status = sc_fields_write(ctx, field->fields, source(field, from), indent + 2,
                                         identity, text);
            continue;
        }
        status = sc_text_add(ctx, text, " ");
        if (status == SC_OK)
            status = field->type->write(ctx, field, from, indent, text);
        if (status == SC_OK)
            status = sc_text_add(ctx, text, "\n");
    }
    return status;
}

sc_status sc_fields_write_flow(const sc_ctx *ctx, const sc_field *fields, const void *from,
                               sc_text *text)
{
    const char *comma = "{";
    sc_status status = SC_OK;

    for (const sc_field *field = fields; field->name && status == SC_OK; field++) {
        if (field->type->absent && field->type->absent(field, from))
            continue;
        status = sc_text_add(ctx, text, "%s%s: ", comma, field->name);
        if (status == SC_OK)
            status = field->type->write(ctx, field, from, 0, text);
        comma = ", ";
    }
    return status == SC_OK ? sc_text_add(ctx, text, "}") : status;
}
