/* SPDX-License-Identifier: BSD-3-Clause */
/* The JSON schema of a job file, from the rows of its tables: editors complete and check job files
 * with it. The schema knows which keys are required and which exclude each other; what depends on
 * the volume or on values of other keys is found by `segcast check`.
 *
 * All functions return new references, or NULL when out of memory: jansson accepts a NULL as part,
 * and then the whole becomes NULL, too. */
#include "key.h"

#include <math.h>

/* @return the default as JSON; NULL if there is none. */
static json_t *default_of(const sc_key *key)
{
    const sc_ctx silent = {.rank = 0};
    SC_OWN(sc_yaml_free_at) sc_yaml *node = NULL;

    return key->fallback && sc_yaml_parse(&silent, key->name, key->fallback, strlen(key->fallback),
                                          &node) == SC_OK
               ? sc_node_to_json(node)
               : NULL;
}

/* ---- schemas as text ---- */

static json_t *keys_of(const sc_key *key)
{
    return sc_keys_schema(key->keys);
}

/* The times of key frames, for editors. */
#define TIME_PATTERN "^([0-9.]+ *(%|f|frames?|s|ms|min)|([0-9]+:)?[0-9]+:[0-5][0-9](\\.[0-9]+)?)$"

static json_t *track_of(const sc_key *key)
{
    const sc_value_type *type = sc_type_of_frames(key);

    if (type->steps)
        return json_pack("{s:s, s:{s:o}, s:b}", "type", "object", "patternProperties", TIME_PATTERN,
                         sc_type_schema(type, key), "additionalProperties", 0);
    return json_pack("{s:s, s:{s:{s:[o, {s:s, s:{s:o, s:o}, s:[s], s:b}]}}, s:{s:o}, s:b}", "type",
                     "object", "patternProperties", TIME_PATTERN, "anyOf",
                     sc_type_schema(type, key), "type", "object", "properties", "value",
                     sc_type_schema(type, key), "ease", sc_type_schema(&sc_type_ease, key),
                     "required", "value", "additionalProperties", 0, "properties", "ease",
                     sc_type_schema(&sc_type_ease, key), "additionalProperties", 0);
}

static json_t *constant_of(const sc_key *key)
{
    return sc_type_schema(sc_constant_of(key), key);
}

/* Remove from the schema of a map what a shot cannot have. */
static void drop_film_keys(const sc_key *keys, json_t *schema)
{
    json_t *properties = json_object_get(schema, "properties");

    for (const sc_key *key = keys; key->name && properties; key++) {
        if (key->scope.of_film)
            json_object_del(properties, key->name);
        else if (key->keys && key->type->container == SC_CONTAINER_MAP)
            drop_film_keys(key->keys, json_object_get(properties, key->name));
        else if (key->keys && key->type->container == SC_CONTAINER_DICT)
            drop_film_keys(key->keys, json_object_get(json_object_get(properties, key->name),
                                                      "additionalProperties"));
    }
}

static json_t *shot_of(const sc_key *key)
{
    json_t *shot = sc_keys_schema(key->keys);

    drop_film_keys(key->keys, shot);
    return shot;
}

/* What a name in the text of a schema stands for: a type, or a function. */
static const struct {
    const char *name;
    const sc_value_type *type;
    json_t *(*make)(const sc_key *key);
} parts[] = {{"$bool", &sc_type_bool, NULL},
             {"$choice", &sc_type_choice, NULL},
             {"$constant", NULL, constant_of},
             {"$color", &sc_type_color, NULL},
             {"$duration", &sc_type_duration, NULL},
             {"$int", &sc_type_int, NULL},
             {"$keys", NULL, keys_of},
             {"$point", &sc_type_point, NULL},
             {"$position", &sc_type_plane_position, NULL},
             {"$share", &sc_type_share, NULL},
             {"$shot", NULL, shot_of},
             {"$text", &sc_type_text, NULL},
             {"$track", NULL, track_of}};

/* @return the schema of the words of a type. */
static json_t *words_of(const sc_value_type *type, const sc_key *key)
{
    const char *words[SC_WORDS_MAX];
    const size_t count = type->list_words(key, words);
    json_t *list = json_array();

    for (size_t i = 0; i < count; i++)
        json_array_append_new(list, json_string(words[i]));
    return json_pack("{s:o}", "enum", list);
}

/* @return what a name in the text of the schema of @p type stands for; NULL also if nothing has it.
 */
static json_t *named(const char *name, const sc_value_type *type, const sc_key *key)
{
    const struct {
        const char *name;
        double value;
    } numbers[] = {{"$low", key->low},
                   {"$high", key->high},
                   {"$bytes_most", (double)key->bytes - 1},
                   {"$points_most", SC_THROUGH_MAX},
                   {"$shots_most", SC_SHOTS_MAX},
                   {"$others_most", SC_SUBJECTS_MAX - 1},
                   {"$verbs_most", SC_VERBS_MAX}};

    if (!strcmp(name, "$words"))
        return words_of(type, key);
    for (size_t i = 0; i < SC_COUNT_OF(numbers); i++) {
        const double value = numbers[i].value;

        if (!strcmp(name, numbers[i].name))
            return value == floor(value) ? json_integer((json_int_t)value) : json_real(value);
    }
    for (size_t i = 0; i < SC_COUNT_OF(parts); i++) {
        if (!strcmp(name, parts[i].name))
            return parts[i].type ? sc_type_schema(parts[i].type, key) : parts[i].make(key);
    }
    return NULL;
}

static json_t *build(const sc_yaml *node, const sc_value_type *type, const sc_key *key)
{
    json_t *json;

    if (node->kind == SC_YAML_SCALAR)
        return node->text[0] == '$' ? named(node->text, type, key) : sc_node_to_json(node);
    json = node->kind == SC_YAML_MAP ? json_object() : json_array();
    for (size_t i = 0; i < node->count; i++) {
        json_t *item = build(node->items[i], type, key);

        if (node->kind == SC_YAML_MAP ? json_object_set_new(json, node->items[i]->key, item)
                                      : json_array_append_new(json, item)) {
            json_decref(json);
            return NULL;
        }
    }
    return json;
}

json_t *sc_type_schema(const sc_value_type *type, const sc_key *key)
{
    const sc_ctx silent = {.rank = 0};
    SC_OWN(sc_yaml_free_at) sc_yaml *node = NULL;

    return sc_yaml_parse(&silent, "schema", type->schema, strlen(type->schema), &node) == SC_OK
               ? build(node, type, key)
               : NULL;
}

/* ---- schemas of tables ---- */

/* The schema of one value, with its help and its default. */
static json_t *schema_of(const sc_key *key)
{
    json_t *schema = sc_type_schema(key->type, key);
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
