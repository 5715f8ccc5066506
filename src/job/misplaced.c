/* SPDX-License-Identifier: BSD-3-Clause */
/* Keys of a job that stand in a wrong map, such as frames outside of animation. */
#include "key.h"

/* If more maps than this have a key, such as "name", the message does not guess which was meant. */
enum { PLACES_TOLD = 3 };

/* Append to @p places all places of the key @p name that are @p depth maps below the table @p keys,
 * such as "animation.frames or output.frames", and count them. @param path that of the table, with
 * a dot at its end; unchanged afterwards. */
static sc_status add_places(const sc_ctx *ctx, const sc_key *keys, const char *name, int depth,
                            sc_text *path, sc_text *places, int *count)
{
    const size_t length = path->length_bytes;
    sc_status status = SC_OK;

    if (!depth) {
        if (!sc_key_find(keys, name))
            return SC_OK;
        return sc_text_add(ctx, places, "%s%.*s%s", (*count)++ ? " or " : "", (int)length,
                           length ? path->data : "", name);
    }
    for (; keys->name && status == SC_OK; keys++) {
        const bool is_dict = keys->type->container == SC_CONTAINER_DICT;

        if (!is_dict && keys->type->container != SC_CONTAINER_MAP)
            continue;
        SC_PASS(sc_text_add(ctx, path, "%s.%s", keys->name, is_dict ? "NAME." : ""));
        status = add_places(ctx, keys->keys, name, depth - 1, path, places, count);
        path->length_bytes = length;
    }
    return status;
}

sc_status sc_tell_misplaced_key(const sc_ctx *ctx, sc_yaml *node)
{
    SC_OWN(sc_text_clear) sc_text path = {0}, places = {0};
    int count = 0;

    for (int depth = 0; depth < 4 && !count; depth++)
        SC_PASS(add_places(ctx, sc_job_keys, node->key, depth, &path, &places, &count));
    node->key_told = count > 0 && count <= PLACES_TOLD;
    if (node->key_told)
        return sc_yaml_fail(ctx, node, "unknown key \"%s\" here; did you mean %s?", node->key,
                            places.data);
    return SC_OK;
}

/* Look for misplaced keys in the map @p node, whose table is @p keys, and in the maps below it. */
static sc_status look_into(const sc_ctx *ctx, const sc_key *keys, const sc_yaml *node)
{
    sc_status status = SC_OK;

    for (size_t i = 0; i < node->count; i++) {
        sc_yaml *item = node->items[i];
        const sc_key *key = sc_key_find(keys, item->key);
        sc_status found = SC_OK;

        if (!key)
            found = sc_tell_misplaced_key(ctx, item);
        else if (key->type->container == SC_CONTAINER_MAP && item->kind == SC_YAML_MAP)
            found = look_into(ctx, key->keys, item);
        if (!sc_goes_on(&status, found))
            return status;
    }
    return status;
}

sc_status sc_tell_misplaced(const sc_ctx *ctx, const sc_yaml *root)
{
    return look_into(ctx, sc_job_keys, root);
}
