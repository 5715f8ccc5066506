/* SPDX-License-Identifier: BSD-3-Clause */
/* Tissues of a job: rules by name, glob or label number. */
#include "job_fields.h"

#include <string.h>

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

#define HAS_FIELD(name, member, of)                                                                \
    static sc_status parse_##name(const sc_ctx *ctx, const sc_field *field, const sc_yaml *node,   \
                                  void *to)                                                        \
    {                                                                                              \
        ((sc_tissue_rule *)to)->member = true;                                                     \
        return (of).parse(ctx, field, node, to);                                                   \
    }                                                                                              \
    static sc_status write_##name(const sc_ctx *ctx, const sc_field *field, const void *from,      \
                                  int indent, sc_text *text)                                       \
    {                                                                                              \
        return (of).write(ctx, field, from, indent, text);                                         \
    }                                                                                              \
    static bool no_##name(const sc_field *field, const void *from)                                 \
    {                                                                                              \
        (void)field;                                                                               \
        return !((const sc_tissue_rule *)from)->member;                                            \
    }

/* Types that also note that the key was given. */
HAS_FIELD(color, has_color, sc_type_color)
HAS_FIELD(visible, has_visible, sc_type_bool)
HAS_FIELD(interior, has_interior_opacity, sc_type_real)
HAS_FIELD(diffuse, has_diffuse, sc_type_real)
HAS_FIELD(specular, has_specular, sc_type_real)
HAS_FIELD(shininess, has_shininess, sc_type_int)

static const sc_field_type type_opacity = {"auto or a number from 0 to 1", parse_opacity,
                                           write_opacity, no_opacity};
static const sc_field_type type_color = {"\"#rrggbb\" or [red, green, blue] from 0 to 255",
                                         parse_color, write_color, no_color};
static const sc_field_type type_visible = {"true or false", parse_visible, write_visible,
                                           no_visible};
static const sc_field_type type_interior = {"a number", parse_interior, write_interior,
                                            no_interior};
static const sc_field_type type_diffuse = {"a number", parse_diffuse, write_diffuse, no_diffuse};
static const sc_field_type type_specular = {"a number", parse_specular, write_specular,
                                            no_specular};
static const sc_field_type type_shininess = {"a whole number", parse_shininess, write_shininess,
                                             no_shininess};

static const sc_field rule_fields[] = {
    {.name = "color", .type = &type_color, .offset = offsetof(sc_tissue_rule, rgb)},
    {.name = "opacity", .type = &type_opacity},
    {.name = "interior_opacity",
     .type = &type_interior,
     .offset = offsetof(sc_tissue_rule, interior_opacity),
     .low = 0,
     .high = 1},
    {.name = "visible", .type = &type_visible, .offset = offsetof(sc_tissue_rule, visible)},
    {.name = "diffuse",
     .type = &type_diffuse,
     .offset = offsetof(sc_tissue_rule, material.diffuse),
     .low = 0,
     .high = 2},
    {.name = "specular",
     .type = &type_specular,
     .offset = offsetof(sc_tissue_rule, material.specular),
     .low = 0,
     .high = 2},
    {.name = "shininess",
     .type = &type_shininess,
     .offset = offsetof(sc_tissue_rule, material.shininess),
     .low = 1,
     .high = 1000},
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
            return sc_wrong_type(ctx, item, "{color, opacity, visible, ...}");
        strcpy(rule->pattern, item->key);
        sc_note_where(item, rule->where, sizeof rule->where);
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
