/* SPDX-License-Identifier: BSD-3-Clause */
/* Settings of the command line and of the environment, put into the tree of a job file before it is
 * read, so that they are checked in the same way as the file. */
#include "key.h"

#include <stdlib.h>
#include <strings.h>

/* A position on the way along a path: a node of the tree, and the rows that describe what it holds.
 */
typedef struct position {
    sc_yaml *node;
    const sc_key *keys;     /* the table of the map that the node is, or of the maps in it */
    sc_container container; /* what kind of container the node is */
    sc_shorthand shorthand;
    bool added; /* the node was missing in the tree; a single value has no text yet */
} position;

/* Make a tree that was parsed from a setting one of that setting: messages name @p origin, which is
 * borrowed, instead of a line. */
static void forget_lines(sc_yaml *node, const char *origin)
{
    node->line = 0;
    node->origin = origin;
    for (size_t i = 0; i < node->count; i++)
        forget_lines(node->items[i], origin);
}

/* Remove the members of @p map that exclude @p key, which is a row of @p keys. */
static void remove_alternatives(sc_yaml *map, const sc_key *keys, const sc_key *key)
{
    for (size_t i = 0; i < map->count && key->alternative;) {
        const sc_key *other = sc_key_find(keys, map->items[i]->key);

        if (other && other != key && other->alternative &&
            !strcmp(other->alternative, key->alternative))
            sc_yaml_remove(map, i);
        else
            i++;
    }
}

static sc_status merge(const sc_ctx *ctx, const sc_key *keys, sc_container container,
                       sc_yaml *parent, size_t index, sc_yaml *value);

/* Merge the map @p value into the map @p old, key by key. @param keys, container as of merge.
 * Takes ownership of @p value, also after an error. */
static sc_status merge_members(const sc_ctx *ctx, const sc_key *keys, sc_container container,
                               sc_yaml *old, sc_yaml *value)
{
    SC_OWN(sc_yaml_free_at) sc_yaml *owned = value;

    for (size_t i = 0; i < owned->count; i++) {
        sc_yaml *member = owned->items[i];
        const sc_key *key = container == SC_CONTAINER_MAP ? sc_key_find(keys, member->key) : NULL;
        size_t at;

        owned->items[i] = NULL;
        if (key)
            remove_alternatives(old, keys, key);
        at = sc_yaml_index(old, member->key);
        if (at < old->count)
            SC_PASS(merge(ctx, key ? key->keys : keys,
                          key ? key->type->container : SC_CONTAINER_MAP, old, at, member));
        else
            SC_PASS(sc_yaml_append(ctx, old, member));
    }
    return SC_OK;
}

/* Replace item @p index of @p parent by @p value, or merge it in key by key if both are maps.
 * @param keys, container as of sc_key: what the item is. Takes ownership of @p value, also after an
 * error. */
static sc_status merge(const sc_ctx *ctx, const sc_key *keys, sc_container container,
                       sc_yaml *parent, size_t index, sc_yaml *value)
{
    sc_yaml *old = parent->items[index];

    if (old->kind != SC_YAML_MAP || value->kind != SC_YAML_MAP || !keys ||
        container == SC_CONTAINER_NONE) {
        sc_free(value->key); /* a member that is merged has the same one */
        value->key = old->key;
        old->key = NULL;
        sc_yaml_free(old);
        parent->items[index] = value;
        return SC_OK;
    }
    return merge_members(ctx, keys, container, old, value);
}

sc_status sc_settings_merge(const sc_ctx *ctx, const sc_key *keys, sc_yaml *root, sc_yaml *value)
{
    return merge_members(ctx, keys, SC_CONTAINER_MAP, root, value);
}

/* @return the length of an index in brackets, such as "[12]", that @p text begins with; 0 if it
 * does not. Other brackets belong to the name of a tissue. */
static size_t bracketed(const char *text)
{
    const size_t digits = *text == '[' ? strspn(text + 1, "0123456789") : 0;
    const char *close = text + 1 + digits;

    return digits && *close == ']' && (!close[1] || close[1] == '.' || close[1] == '[') ? digits + 2
                                                                                        : 0;
}

/* @return the length of the name that @p path begins with: up to a dot or an index in brackets. */
static size_t name_length(const char *path)
{
    size_t length = strcspn(path, ".[");

    while (path[length] == '[' && !bracketed(path + length))
        length += 1 + strcspn(path + length + 1, ".[");
    return length;
}

const char *sc_setting_element(const char *path, char *element, size_t size)
{
    const size_t index = bracketed(path);
    const bool is_quoted = *path == '"';
    const char *close = is_quoted ? strchr(path + 1, '"') : NULL;
    const size_t around = is_quoted || index; /* characters before the element, and behind it */
    size_t length;

    if (is_quoted && !close)
        return NULL;
    length = is_quoted ? (size_t)(close - path - 1) : index ? index - 2 : name_length(path);
    if (length == 0 || length >= size)
        return NULL;
    memcpy(element, path + around, length);
    element[length] = '\0';
    path += length + 2 * around;
    if (*path && *path != '.' && !bracketed(path))
        return NULL;
    return *path == '.' ? path + 1 : path;
}

/* @return the row that @p element names; NULL if there is none, which is logged. */
static const sc_key *find_row(const sc_ctx *ctx, const position *at, const char *element,
                              const char *origin)
{
    const sc_key *key = sc_key_find(at->keys, element);

    if (!key) {
        char name[256];
        sc_yaml unknown = {.origin = origin, .key = name};

        snprintf(name, sizeof name, "%s", element);
        (void)sc_tell_misplaced_key(ctx, &unknown);
        (void)sc_key_unknown(ctx, at->keys, &unknown);
    }
    return key;
}

/* Find the index of the list item that @p element names. It may be the one after the last item,
 * which the caller then appends. */
static sc_status find_item(const sc_ctx *ctx, sc_yaml *list, const char *element,
                           const char *origin, size_t *index)
{
    char *end;
    const long number = strtol(element, &end, 10);

    if (*end || end == element || number < 0 || (size_t)number > list->count)
        return sc_fail(ctx, SC_ERR_USAGE,
                       "%s: \"%s\" is not an item of a list of %zu; expected a number from 0, or "
                       "%zu to append one",
                       origin, element, list->count, list->count);
    *index = (size_t)number;
    return SC_OK;
}

/* Turn a single value into the map that it stands for, with the value under the key @p name:
 * volume: a.nrrd becomes volume: {path: a.nrrd}. */
static sc_status expand_shorthand(const sc_ctx *ctx, sc_yaml *node, const char *name,
                                  const char *origin)
{
    SC_OWN(sc_free_at) char *text = node->text;

    node->text = NULL;
    node->kind = SC_YAML_MAP;
    SC_PASS(sc_yaml_add(ctx, node, SC_YAML_SCALAR, name, origin));
    SC_HAND_OVER(text, &node->items[0]->text);
    node->items[0]->line = node->line;
    node->items[0]->origin = node->origin;
    return SC_OK;
}

/* Describe in @p member what @p element names in the map, list or dictionary @p at; its node is
 * left NULL. Members of a map that exclude it are removed from the tree. */
static sc_status find_member(const sc_ctx *ctx, const position *at, const char *element,
                             const char *origin, position *member)
{
    const sc_key *key;

    if (at->container == SC_CONTAINER_NONE)
        return sc_fail(ctx, SC_ERR_USAGE, "%s: \"%s\" leads into a single value", origin, element);
    *member = (position){.keys = at->keys, .container = SC_CONTAINER_MAP};
    if (at->container != SC_CONTAINER_MAP)
        return SC_OK;
    key = find_row(ctx, at, element, origin);
    if (!key)
        return SC_ERR_USAGE;
    remove_alternatives(at->node, at->keys, key);
    *member = (position){
        .keys = key->keys, .container = key->type->container, .shorthand = key->shorthand};
    return SC_OK;
}

/* Move *at to its member of that name, which is added to the tree if it is missing. @param index of
 * the member in the node from which *at moved. */
static sc_status enter(const sc_ctx *ctx, position *at, const char *element, const char *origin,
                       size_t *index)
{
    static const sc_yaml_kind kinds[] = {[SC_CONTAINER_NONE] = SC_YAML_SCALAR,
                                         [SC_CONTAINER_MAP] = SC_YAML_MAP,
                                         [SC_CONTAINER_LIST] = SC_YAML_LIST,
                                         [SC_CONTAINER_DICT] = SC_YAML_MAP};
    const bool is_list = at->container == SC_CONTAINER_LIST;
    position member;

    SC_PASS(find_member(ctx, at, element, origin, &member));
    if (at->node->kind == SC_YAML_SCALAR && at->shorthand.key)
        SC_PASS(expand_shorthand(ctx, at->node, at->shorthand.key, origin));
    if (at->node->kind != kinds[at->container])
        return sc_fail(ctx, SC_ERR_USAGE, "%s: \"%s\" leads into a value that is no %s", origin,
                       element, is_list ? "list" : "map");
    *index = sc_yaml_index(at->node, element);
    if (is_list)
        SC_PASS(find_item(ctx, at->node, element, origin, index));
    member.added = *index == at->node->count;
    if (member.added)
        SC_PASS(
            sc_yaml_add(ctx, at->node, kinds[member.container], is_list ? NULL : element, origin));
    member.node = at->node->items[*index];
    *at = member;
    return SC_OK;
}

/* Set the member @p name of @p map to @p value, a single value. Takes ownership of @p value, also
 * after an error. */
static sc_status set_member(const sc_ctx *ctx, sc_yaml *map, const char *name, const char *origin,
                            sc_yaml *value)
{
    const size_t index = sc_yaml_index(map, name);
    sc_status status = SC_OK;

    if (index == map->count)
        status = sc_yaml_add(ctx, map, SC_YAML_SCALAR, name, origin);
    if (status == SC_OK)
        return merge(ctx, NULL, SC_CONTAINER_NONE, map, index, value);
    sc_yaml_free(value);
    return status;
}

/* Put @p value at @p path of the tree; takes ownership of it, also after an error, and leaves no
 * nodes in the tree then that were added on the way: further mistakes are looked for in it. */
static sc_status put(const sc_ctx *ctx, const sc_key *keys, sc_yaml *root, const char *origin,
                     const char *path, sc_yaml *value)
{
    position at = {.node = root, .keys = keys, .container = SC_CONTAINER_MAP};
    char element[256];
    sc_yaml *grown = NULL; /* the first node that got a member on the way, its last one */
    sc_status status;

    for (;;) {
        sc_yaml *parent = at.node;
        size_t index = 0;

        path = sc_setting_element(path, element, sizeof element);
        if (!path) {
            status =
                sc_fail(ctx, SC_ERR_USAGE,
                        "%s: expected key.path=value, where each key has at most %zu characters",
                        origin, sizeof element - 1);
            break;
        }
        status = enter(ctx, &at, element, origin, &index);
        if (status != SC_OK)
            break;
        if (at.added && !grown)
            grown = parent;
        if (!*path && at.shorthand.keeps && at.node->kind == SC_YAML_MAP && !at.added &&
            value->kind == SC_YAML_SCALAR)
            return set_member(ctx, at.node, at.shorthand.key, origin, value);
        if (!*path)
            return merge(ctx, at.keys, at.container, parent, index, value);
    }
    if (grown)
        sc_yaml_remove(grown, grown->count - 1);
    sc_yaml_free(value);
    return status;
}

sc_status sc_setting_apply_text(const sc_ctx *ctx, const sc_key *keys, sc_yaml *root,
                                const char *origin, const char *path, const char *text)
{
    sc_yaml *node = NULL;

    SC_PASS(sc_yaml_scalar(ctx, origin, text, &node));
    return put(ctx, keys, root, origin, path, node);
}

sc_status sc_setting_apply(const sc_ctx *ctx, const sc_key *keys, sc_yaml *root, const char *origin,
                           const char *path, const char *text)
{
    sc_yaml *node = NULL;
    sc_status status;

    /* A colour, which YAML would read as a comment; or no value, which YAML would read as a map. */
    if (text[0] == '#' || !text[strspn(text, " \t")])
        return sc_setting_apply_text(ctx, keys, root, origin, path, text);
    status = sc_yaml_parse(ctx, origin, text, strlen(text), &node);
    if (status != SC_OK) /* a setting is wrong, not a file */
        return status == SC_ERR_DATA ? SC_ERR_USAGE : status;
    if (node->key_left_out) {
        sc_yaml_free(node);
        return SC_ERR_USAGE;
    }
    forget_lines(node, origin);
    return put(ctx, keys, root, origin, path, node);
}

/* ---- names of environment variables ---- */

/* Does @p name begin with @p key, case ignored, and then end or continue with "_"? @return the
 * length of the key, or 0. */
static size_t match_key(const char *name, const char *key)
{
    const size_t length = strlen(key);

    if (strncasecmp(name, key, length) != 0 || (name[length] && name[length] != '_'))
        return 0;
    return length;
}

/* Does @p name begin with an index, such as 0 in 0_PLANE_AT? @return its length, or 0. */
static size_t match_index(const char *name)
{
    const size_t length = strspn(name, "0123456789");

    return name[length] && name[length] != '_' ? 0 : length;
}

/* Append to @p path the keys that @p name spells, starting with one of @p keys. Because names of
 * keys hold "_" themselves, each row that fits is tried. @return false, with @p path as it was, if
 * none leads to the end of the name. */
static bool find_path(const sc_key *keys, const char *name, char *path, size_t size)
{
    const size_t used = strlen(path);

    for (; keys->name; keys++) {
        const char *rest = name + match_key(name, keys->name);

        if (rest == name)
            continue;
        if ((size_t)snprintf(path + used, size - used, "%s%s", used ? "." : "", keys->name) >=
            size - used)
            return false;
        if (!*rest)
            return true;
        rest++;
        if (keys->type->container == SC_CONTAINER_LIST && match_index(rest)) {
            const size_t digits = match_index(rest), end = strlen(path);

            if ((size_t)snprintf(path + end, size - end, ".%.*s", (int)digits, rest) >= size - end)
                return false;
            rest += digits;
            if (!*rest)
                return true;
            rest++;
        } else if (keys->type->container != SC_CONTAINER_MAP) {
            path[used] = '\0';
            continue; /* the name of a tissue cannot be recognised in that of a variable */
        }
        if (find_path(keys->keys, rest, path, size))
            return true;
        path[used] = '\0';
    }
    return false;
}

bool sc_setting_path(const sc_key *keys, const char *variable, char *path, size_t size)
{
    path[0] = '\0';
    return find_path(keys, variable, path, size);
}
