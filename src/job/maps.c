/* SPDX-License-Identifier: BSD-3-Clause */
/* The types of values that are maps of further keys. */
#include "key.h"

static sc_status read_map(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    if (node->kind != SC_YAML_MAP)
        return sc_wrong_type(ctx, node, key->type->expected);
    return sc_keys_read(ctx, key->keys, node, value);
}

static sc_status write_flow_map(const sc_ctx *ctx, const sc_key *key, const void *value,
                                sc_text *text)
{
    return sc_keys_write_flow(ctx, key->keys, value, text);
}

/* A map that is written as lines. It has no write function: sc_keys_write writes them. */
const sc_value_type sc_type_map = {
    .name = "map",
    .expected = "a map of keys",
    .read = read_map,
    .schema = "$keys",
    .container = SC_CONTAINER_MAP,
};
/* A map that is written in one line. */
const sc_value_type sc_type_flow_map = {
    .name = "map",
    .expected = "a map of keys",
    .read = read_map,
    .write = write_flow_map,
    .schema = "$keys",
    .container = SC_CONTAINER_MAP,
};
