/* SPDX-License-Identifier: BSD-3-Clause */
/* The JSON schema of a job file, from the rows of its tables: editors complete and check job files
 * with it. The schema knows which keys are required and which exclude each other; what depends on
 * the volume or on values of other keys is found by `segcast check`.
 *
 * All functions return new references, or NULL when out of memory: jansson accepts a NULL as part,
 * and then the whole becomes NULL, too. */
#include "key.h"

/* @return the default as JSON; NULL if there is none. */
static json_t *default_of(const sc_key *key)
{
    const sc_ctx silent = {.rank = 0};
    sc_yaml *node = NULL;
    json_t *json = NULL;

    if (key->fallback &&
        sc_yaml_parse(&silent, key->name, key->fallback, strlen(key->fallback), &node) == SC_OK)
        json = sc_node_to_json(node);
    sc_yaml_free(node);
    return json;
}

/* The schema of one value, with its help and its default. */
static json_t *schema_of(const sc_key *key)
{
    json_t *schema = key->type->schema(key);
    char text[512];

    snprintf(text, sizeof text, "%s%s%s%s", key->help, key->unit ? " (" : "",
             key->unit ? key->unit : "", key->unit ? ")" : "");
    json_object_set_new(schema, "description", json_string(text));
    if (key->fallback)
        json_object_set_new(schema, "default", default_of(key));
    return schema;
}

static bool same_alternative(const sc_key *a, const sc_key *b)
{
    return a->alternative && b->alternative && !strcmp(a->alternative, b->alternative);
}

/* Append to @p all the conditions that one row sets for the whole map: that it is there, if it is
 * required, and that other rows of its alternative are not there. */
static void add_conditions(const sc_key *keys, const sc_key *key, json_t *all)
{
    json_t *any = json_array();

    for (const sc_key *other = keys; other->name; other++) {
        if (other != key && !same_alternative(key, other))
            continue;
        json_array_append_new(any, json_pack("{s:[s]}", "required", other->name));
        if (other > key)
            json_array_append_new(
                all, json_pack("{s:{s:[s, s]}}", "not", "required", key->name, other->name));
    }
    if (key->required)
        json_array_append_new(all, json_pack("{s:O}", "anyOf", any));
    json_decref(any);
}

json_t *sc_keys_schema(const sc_key *keys)
{
    json_t *properties = json_object(), *conditions = json_array(), *schema;

    for (const sc_key *key = keys; key->name; key++) {
        json_object_set_new(properties, key->name, schema_of(key));
        add_conditions(keys, key, conditions);
    }
    schema = json_pack("{s:s, s:b, s:o}", "type", "object", "additionalProperties", false,
                       "properties", properties);
    if (json_array_size(conditions) > 0)
        json_object_set(schema, "allOf", conditions);
    json_decref(conditions);
    return schema;
}
