/* SPDX-License-Identifier: BSD-3-Clause */
/* Writes the tree of a job as JSON. */
#include "key.h"

#include <stdlib.h>

/* @return the JSON value of a scalar: true, false or a number if it stands there without quotes,
 * else a string. The caller owns it; NULL: no memory. */
static json_t *scalar_to_json(const sc_yaml *node)
{
    const char *text = node->text;
    char *end;
    double number;

    if (!node->quoted && (!strcmp(text, "true") || !strcmp(text, "false")))
        return json_boolean(text[0] == 't');
    if (node->quoted || !text[0] || text[strspn(text, "0123456789+-.eE")])
        return json_string(text);
    number = strtod(text, &end);
    if (*end)
        return json_string(text);
    return strpbrk(text, ".eE") ? json_real(number) : json_integer(strtoll(text, NULL, 10));
}

json_t *sc_node_to_json(const sc_yaml *node)
{
    json_t *json;

    if (node->kind == SC_YAML_SCALAR)
        return scalar_to_json(node);
    json = node->kind == SC_YAML_MAP ? json_object() : json_array();
    for (size_t i = 0; i < node->count && json; i++) { /* the depth of a tree is bounded */
        const sc_yaml *item = node->items[i];
        const int failed = node->kind == SC_YAML_MAP
                               ? json_object_set_new(json, item->key, sc_node_to_json(item))
                               : json_array_append_new(json, sc_node_to_json(item));

        if (failed) {
            json_decref(json);
            json = NULL;
        }
    }
    return json;
}

sc_status sc_tree_to_json(const sc_ctx *ctx, const sc_yaml *root, sc_text *text)
{
    json_auto_t *json = sc_node_to_json(root);
    SC_OWN(sc_free_at) char *written = NULL;

    written = json ? json_dumps(json, JSON_COMPACT | JSON_REAL_PRECISION(17)) : NULL;
    return written ? sc_text_add(ctx, text, "%s", written)
                   : sc_fail(ctx, SC_ERR_MEMORY, "out of memory while a job was written as JSON");
}
