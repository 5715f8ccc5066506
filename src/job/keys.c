/* SPDX-License-Identifier: BSD-3-Clause */
/* Reading and writing a map by the rows of its table. */
#include "key.h"
#include "yaml/yaml_words.h"

static void *value_of(const sc_key *key, void *base)
{
    return (char *)base + key->offset;
}

static const void *stored_value(const sc_key *key, const void *base)
{
    return (const char *)base + key->offset;
}

const sc_key *sc_key_find(const sc_key *keys, const char *name)
{
    for (; keys->name; keys++) {
        if (!strcmp(keys->name, name))
            return keys;
    }
    return NULL;
}

sc_status sc_key_unknown(const sc_ctx *ctx, const sc_key *keys, const sc_yaml *node)
{
    const char *names[64], *value = sc_yaml_lost_blank(node->key);
    size_t count = 0;

    if (node->key_told)
        return SC_ERR_DATA;
    if (value)
        return sc_yaml_fail(ctx, node, "\"%s\": " SC_LOST_BLANK, node->key,
                            (int)(value - node->key), node->key, value);
    for (; keys[count].name && count < SC_COUNT_OF(names); count++)
        names[count] = keys[count].name;
    return sc_unknown_word(ctx, node, node->key, names, count);
}

/* Store the default of one row, which is read as if it stood in a file. A map without a default of
 * its own gets those of its rows. */
static sc_status set_default(const sc_ctx *ctx, const sc_key *key, void *to)
{
    SC_OWN(sc_yaml_free_at) sc_yaml *node = NULL;

    if (key->type->container == SC_CONTAINER_MAP && !key->fallback)
        return sc_keys_set_defaults(ctx, key->keys, value_of(key, to));
    if (!key->fallback)
        return SC_OK;
    SC_PASS(sc_yaml_parse(ctx, key->name, key->fallback, strlen(key->fallback), &node));
    return key->type->read(ctx, key, node, value_of(key, to));
}

sc_status sc_keys_set_defaults(const sc_ctx *ctx, const sc_key *keys, void *to)
{
    for (; keys->name; keys++)
        SC_PASS(set_default(ctx, keys, to));
    return SC_OK;
}

/* @return the name of a key of the same alternative among the first @p count items of @p node, or
 * NULL. */
static const char *excluded_by(const sc_key *keys, const sc_key *key, const sc_yaml *node,
                               size_t count)
{
    for (size_t i = 0; i < count && key->alternative; i++) {
        const sc_key *other = sc_key_find(keys, node->items[i]->key);

        if (other && other != key && other->alternative &&
            !strcmp(other->alternative, key->alternative))
            return other->name;
    }
    return NULL;
}

/* Is one of the unknown keys of the map @p node likely to be @p name, misspelt? */
static bool is_misspelt(const sc_key *keys, const char *name, const sc_yaml *node)
{
    for (size_t i = 0; i < node->count; i++) {
        if (!sc_key_find(keys, node->items[i]->key) &&
            sc_nearest_word(node->items[i]->key, &name, 1))
            return true;
    }
    return false;
}

/* Is one of the unknown keys of the map @p node like none of @p keys? It may stand for any of an
 * alternative. */
static bool has_stray(const sc_key *keys, const sc_yaml *node)
{
    for (size_t i = 0; i < node->count; i++) {
        const sc_key *key = keys;

        while (key->name && strcmp(key->name, node->items[i]->key) != 0 &&
               !sc_nearest_word(node->items[i]->key, &key->name, 1))
            key++;
        if (!key->name)
            return true;
    }
    return false;
}

/* Does @p node hold the key, or another one of its alternative, perhaps misspelt? */
static bool is_given(const sc_key *keys, const sc_key *key, const sc_yaml *node)
{
    const sc_key *all = keys;

    if (key->alternative && has_stray(all, node))
        return true;
    for (; keys->name; keys++) {
        const bool stands_for_it = keys == key || (key->alternative && keys->alternative &&
                                                   !strcmp(key->alternative, keys->alternative));

        if (stands_for_it &&
            (sc_yaml_member(node, keys->name) || is_misspelt(all, keys->name, node)))
            return true;
    }
    return false;
}

/* Log all required keys that the map @p node lacks; of several of one alternative only the first,
 * and none that stands there misspelt, which has been told. @return as sc_yaml_fail, or SC_OK. */
static sc_status check_required(const sc_ctx *ctx, const sc_key *keys, const sc_yaml *node)
{
    const char *told = "";
    sc_status status = SC_OK;

    for (const sc_key *key = keys; key->name; key++) {
        const char *name = key->alternative ? key->alternative : key->name;

        if (!key->required || is_given(keys, key, node) || !strcmp(name, told))
            continue;
        told = name;
        (void)sc_goes_on(&status, sc_yaml_fail(ctx, node, "%s%sthe key \"%s\" is missing: %s",
                                               node->key ? node->key : "", node->key ? ": " : "",
                                               name, key->help));
    }
    return status;
}

/* Read item @p index of the map @p node into @p to. */
static sc_status read_item(const sc_ctx *ctx, const sc_key *keys, const sc_yaml *node, size_t index,
                           void *to)
{
    const sc_yaml *item = node->items[index];
    const sc_key *key = sc_key_find(keys, item->key);
    const char *other;
    sc_status status;

    if (!key)
        return sc_key_unknown(ctx, keys, item);
    other = excluded_by(keys, key, node, index);
    if (other)
        return sc_yaml_fail(ctx, item, "both \"%s\" and \"%s\" are given, expected one of them",
                            other, key->name);
    status = key->type->read(ctx, key, item, value_of(key, to));
    if (status == SC_OK && key->given)
        *((bool *)to + key->given - 1) = true;
    return status;
}

sc_status sc_keys_read(const sc_ctx *ctx, const sc_key *keys, const sc_yaml *node, void *to)
{
    sc_status status = SC_OK;

    for (size_t i = 0; i < node->count; i++) {
        if (!sc_goes_on(&status, read_item(ctx, keys, node, i, to)))
            return status;
    }
    (void)sc_goes_on(&status, check_required(ctx, keys, node));
    return status;
}

/* @return whether a struct holds a value of @p key that has to be written. A row that has no
 * `given` flag is always written, unless the user gave another of the keys that exclude it. */
static bool is_present(const sc_key *keys, const sc_key *key, const void *from)
{
    if (key->given)
        return *((const bool *)from + key->given - 1);
    for (; keys->name && key->alternative; keys++) {
        if (keys->given && keys->alternative && !strcmp(keys->alternative, key->alternative) &&
            *((const bool *)from + keys->given - 1))
            return false;
    }
    return true;
}

sc_status sc_keys_write(const sc_ctx *ctx, const sc_key *keys, const void *from, int indent,
                        unsigned parts, sc_text *text)
{
    for (const sc_key *key = keys; key->name; key++) {
        if ((parts & SC_WRITE_IDENTITY && key->scope.outside_identity) ||
            (parts & SC_WRITE_SHOT && key->scope.of_film) || !is_present(keys, key, from))
            continue;
        SC_PASS(sc_text_add(ctx, text, "%*s%s:", indent, "", key->name));
        if (key->type->write_lines) {
            SC_PASS(key->type->write_lines(ctx, key, stored_value(key, from), indent, parts, text));
        } else if (key->type->write) {
            SC_PASS(sc_text_add(ctx, text, " "));
            SC_PASS(key->type->write(ctx, key, stored_value(key, from), text));
            SC_PASS(sc_text_add(ctx, text, "\n"));
        } else {
            SC_PASS(sc_text_add(ctx, text, "\n"));
            SC_PASS(
                sc_keys_write(ctx, key->keys, stored_value(key, from), indent + 2, parts, text));
        }
    }
    return SC_OK;
}

sc_status sc_keys_write_flow(const sc_ctx *ctx, const sc_key *keys, const void *from, sc_text *text)
{
    const char *comma = "{";

    for (const sc_key *key = keys; key->name; key++) {
        if (!is_present(keys, key, from))
            continue;
        SC_PASS(sc_text_add(ctx, text, "%s%s: ", comma, key->name));
        SC_PASS(key->type->write(ctx, key, stored_value(key, from), text));
        comma = ", ";
    }
    return sc_text_add(ctx, text, "%s}", comma[0] == '{' ? "{" : "");
}
