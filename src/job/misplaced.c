/* SPDX-License-Identifier: BSD-3-Clause */
/* Keys of a job that stand in a wrong map, such as frames outside of animation. */
#include "key.h"

/* Append to @p places all places of the key @p name that are @p depth maps below the table @p keys,
 * such as "animation.frames or output.frames". @param path that of the table, with a dot at its
 * end; unchanged afterwards. */
static sc_status add_places(const sc_ctx *ctx, const sc_key *keys, const char *name, int depth,
                            sc_text *path, sc_text *places)
{
    const size_t length = path->length_bytes;
    sc_status status = SC_OK;

    if (!depth)
        return sc_key_find(keys, name)
                   ? sc_text_add(ctx, places, "%s%.*s%s", places->length_bytes ? " or " : "",
                                 (int)length, length ? path->data : "", name)
                   : SC_OK;
    for (; keys->name && status == SC_OK; keys++) {
        const bool is_dict = keys->type->container == SC_CONTAINER_DICT;

        if (!is_dict && keys->type->container != SC_CONTAINER_MAP)
            continue;
        SC_TRY(sc_text_add(ctx, path, "%s.%s", keys->name, is_dict ? "NAME." : ""));
        status = add_places(ctx, keys->keys, name, depth - 1, path, places);
        path->length_bytes = length;
    }
out:
    return status;
}

/* Log where a key belongs that its own map does not know. @return SC_OK, nothing logged, if no map
 * of a job has such a key. */
static sc_status tell_places(const sc_ctx *ctx, sc_yaml *node)
{
    sc_text path = {0}, places = {0};
    sc_status status = SC_OK;

    for (int depth = 0; depth < 4 && !places.length_bytes; depth++)
        SC_TRY(add_places(ctx, sc_job_keys, node->key, depth, &path, &places));
    node->key_told = places.length_bytes != 0;
    if (node->key_told)
        status = sc_yaml_fail(ctx, node, "unknown key \"%s\" here; did you mean %s?", node->key,
                              places.data);
out:
    sc_text_clear(&path);
    sc_text_clear(&places);
    return status;
}

/* Is the key of @p node like one of the table @p keys? */
static bool is_near(const sc_key *keys, const sc_yaml *node)
{
    for (; keys->name; keys++) {
        if (sc_nearest_word(node->key, &keys->name, 1))
            return true;
    }
    return false;
}

/* Look for misplaced keys in the map @p node, whose table is @p keys, and in the maps below it. */
static sc_status look_into(const sc_ctx *ctx, const sc_key *keys, const sc_yaml *node)
{
    sc_status status = SC_OK;

    for (size_t i = 0; i < node->count; i++) {
        sc_yaml *item = node->items[i];
        const sc_key *key = sc_key_find(keys, item->key);
        sc_status found = SC_OK;

        if (!key && !is_near(keys, item))
            found = tell_places(ctx, item);
        else if (key && key->type->container == SC_CONTAINER_MAP && item->kind == SC_YAML_MAP)
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
