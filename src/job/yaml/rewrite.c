/* SPDX-License-Identifier: BSD-3-Clause */
/* Changes one value in the text of a job file and leaves all else as it stands: comments, order,
 * blank lines, quotes. The text is parsed for the places of its nodes. */
#include "key.h"
#include "yaml_words.h"

#include <ctype.h>
#include <stdlib.h>

enum { DEPTH_MAX = 24 }; /* elements of a path */

/* A text that is rewritten, and its nodes. */
typedef struct rewriting {
    const sc_ctx *ctx;
    const char *text;
    yaml_document_t document;
    char elements[DEPTH_MAX][256]; /* [depth] of the path */
    int depth;
    const char *value;
} rewriting;

/* A part of the text that is replaced, in bytes. */
typedef struct part {
    size_t begin, end;
} part;

/* @return the byte at which the character number @p index begins: libyaml counts characters. */
static size_t byte_of(const char *text, size_t index)
{
    const char *at = text;

    for (; index && *at; index--) {
        const size_t bytes = sc_utf8_bytes(at);

        at += bytes ? bytes : 1;
    }
    return (size_t)(at - text);
}

static yaml_node_t *node_at(rewriting *r, int number)
{
    return yaml_document_get_node(&r->document, number);
}

/* @return the last item of a collection; NULL: it has none. */
static yaml_node_t *last_item(rewriting *r, yaml_node_t *node)
{
    if (node->type == YAML_MAPPING_NODE &&
        node->data.mapping.pairs.top > node->data.mapping.pairs.start)
        return node_at(r, node->data.mapping.pairs.top[-1].value);
    if (node->type == YAML_SEQUENCE_NODE &&
        node->data.sequence.items.top > node->data.sequence.items.start)
        return node_at(r, node->data.sequence.items.top[-1]);
    return NULL;
}

/* @return whether a node is written with braces or brackets. */
static bool is_flow(const yaml_node_t *node)
{
    return (node->type == YAML_MAPPING_NODE &&
            node->data.mapping.style == YAML_FLOW_MAPPING_STYLE) ||
           (node->type == YAML_SEQUENCE_NODE &&
            node->data.sequence.style == YAML_FLOW_SEQUENCE_STYLE);
}

/* @return the byte behind what a node says: of a block, behind its last item, without comments. */
static size_t end_of(rewriting *r, yaml_node_t *node)
{
    yaml_node_t *last = is_flow(node) ? NULL : last_item(r, node);
    size_t end;

    if (last)
        return end_of(r, last);
    end = byte_of(r->text, node->end_mark.index);
    /* a block of text ends at the next line */
    while (node->type == YAML_SCALAR_NODE && end > 0 && isspace((unsigned char)r->text[end - 1]) &&
           node->end_mark.index > node->start_mark.index)
        end--;
    return end;
}

/* Append a value as it can stand between braces: as it is, unless YAML would read it otherwise. */
static sc_status add_value(const rewriting *r, sc_text *out)
{
    const char *value = r->value;
    const size_t plain =
        strspn(value, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.+-%/ ");

    if (value[0] == '{' || value[0] == '[' || value[0] == '"' ||
        (value[0] && !value[plain] && value[0] != '%' && value[0] != ' ' &&
         value[plain - 1] != ' '))
        return sc_text_add(r->ctx, out, "%s", value);
    return sc_write_quoted(r->ctx, value, out);
}

/* @return whether an element of a path is the index of an item of a list that is not there yet. */
static bool is_first_index(const char *element)
{
    return !strcmp(element, "0");
}

/* Append a key: with quotes, unless it is a word. */
static sc_status add_key(const rewriting *r, const char *key, sc_text *out)
{
    if (key[0] && !key[strspn(key, "abcdefghijklmnopqrstuvwxyz_0123456789")])
        return sc_text_add(r->ctx, out, "%s: ", key);
    SC_PASS(sc_write_quoted(r->ctx, key, out));
    return sc_text_add(r->ctx, out, ": ");
}

/* Append the value below the elements from number @p from on, in braces within braces. */
static sc_status add_nested(const rewriting *r, int from, sc_text *out)
{
    for (int i = from; i < r->depth; i++) {
        const bool is_item = is_first_index(r->elements[i]);

        SC_PASS(sc_text_add(r->ctx, out, is_item ? "[" : "{"));
        if (!is_item)
            SC_PASS(add_key(r, r->elements[i], out));
    }
    SC_PASS(add_value(r, out));
    for (int i = r->depth - 1; i >= from; i--)
        SC_PASS(sc_text_add(r->ctx, out, is_first_index(r->elements[i]) ? "]" : "}"));
    return SC_OK;
}

/* Find the member or item of @p node that element @p i names. @param key receives its key. @return
 * NULL: there is none. */
static yaml_node_t *find(rewriting *r, yaml_node_t *node, int i, yaml_node_t **key)
{
    const char *name = r->elements[i];

    *key = NULL;
    if (node->type == YAML_MAPPING_NODE) {
        for (yaml_node_pair_t *p = node->data.mapping.pairs.start; p < node->data.mapping.pairs.top;
             p++) {
            yaml_node_t *at = node_at(r, p->key);

            if (at->type == YAML_SCALAR_NODE && !strcmp((char *)at->data.scalar.value, name)) {
                *key = at;
                return node_at(r, p->value);
            }
        }
    }
    if (node->type == YAML_SEQUENCE_NODE) {
        const long index = strtol(name, NULL, 10);

        if (index >= 0 && index < node->data.sequence.items.top - node->data.sequence.items.start)
            return node_at(r, node->data.sequence.items.start[index]);
    }
    return NULL;
}

/* Replace the value of a node. @param key its key; NULL: it is an item. */
static sc_status replace_node(rewriting *r, yaml_node_t *node, yaml_node_t *key, int from, part *at,
                              sc_text *out)
{
    *at = (part){byte_of(r->text, node->start_mark.index), end_of(r, node)};
    if (key && (node->start_mark.line > key->end_mark.line || at->begin == at->end)) {
        at->begin = byte_of(r->text, key->end_mark.index);
        at->begin += strcspn(r->text + at->begin, ":") + 1;
        at->end = at->end > at->begin ? at->end : at->begin;
        SC_PASS(sc_text_add(r->ctx, out, " "));
    }
    return add_nested(r, from, out);
}

/* Add a member or item, from element @p from on, to a collection. */
static sc_status add_item(rewriting *r, yaml_node_t *node, int from, part *at, sc_text *out)
{
    const bool is_list = node->type == YAML_SEQUENCE_NODE;
    const bool is_empty = !last_item(r, node);

    if (is_flow(node)) {
        at->begin = at->end = byte_of(r->text, node->end_mark.index) - 1;
        SC_PASS(sc_text_add(r->ctx, out, is_empty ? "" : ", "));
    } else {
        at->begin = end_of(r, node);
        at->begin += strcspn(r->text + at->begin, "\n");
        at->end = at->begin;
        SC_PASS(sc_text_add(r->ctx, out, "\n%*s%s", (int)node->start_mark.column, "",
                            is_list ? "- " : ""));
    }
    if (!is_list)
        SC_PASS(add_key(r, r->elements[from], out));
    return add_nested(r, from + 1, out);
}

/* Find what is to be replaced, and by what. */
static sc_status find_change(rewriting *r, part *at, sc_text *out)
{
    yaml_node_t *node = yaml_document_get_root_node(&r->document), *key = NULL;
    const size_t length = strlen(r->text);

    if (!node) { /* nothing but comments */
        *at = (part){length, length};
        SC_PASS(sc_text_add(r->ctx, out, "%s", length && r->text[length - 1] != '\n' ? "\n" : ""));
        SC_PASS(add_key(r, r->elements[0], out));
        SC_PASS(add_nested(r, 1, out));
        return sc_text_add(r->ctx, out, "\n");
    }
    for (int i = 0; i < r->depth; i++) {
        yaml_node_t *next_key, *next = find(r, node, i, &next_key);

        if (!next && node->type == YAML_SCALAR_NODE)
            return replace_node(r, node, key, i, at, out);
        if (!next)
            return add_item(r, node, i, at, out);
        node = next;
        key = next_key;
    }
    return replace_node(r, node, key, r->depth, at, out);
}

/* Take the path apart. */
static sc_status read_path(rewriting *r, const char *path)
{
    for (; *path; r->depth++) {
        if (r->depth < DEPTH_MAX)
            path = sc_setting_element(path, r->elements[r->depth], sizeof r->elements[0]);
        if (r->depth == DEPTH_MAX || !path)
            return sc_fail(r->ctx, SC_ERR_USAGE, "this is no path of a key");
    }
    return SC_OK;
}

/* Parse the text, which was read before without a mistake. */
static sc_status load(rewriting *r)
{
    yaml_parser_t parser;
    int done;

    if (!yaml_parser_initialize(&parser))
        return sc_fail(r->ctx, SC_ERR_MEMORY, "out of memory");
    yaml_parser_set_input_string(&parser, (const unsigned char *)r->text, strlen(r->text));
    done = yaml_parser_load(&parser, &r->document);
    yaml_parser_delete(&parser);
    return done ? SC_OK : sc_fail(r->ctx, SC_ERR_DATA, "the job file cannot be read as YAML");
}

sc_status sc_job_rewrite(const sc_ctx *ctx, const char *text, const sc_setting *setting,
                         sc_text *out)
{
    SC_OWN(sc_text_clear) sc_text change = {0};
    SC_OWN(sc_free_at) rewriting *r = NULL;
    part at = {0, 0};
    sc_status status;

    SC_PASS(SC_ZALLOC(ctx, 1, &r));
    r->ctx = ctx;
    r->text = text;
    r->value = setting->value;
    SC_PASS(read_path(r, setting->path));
    SC_PASS(load(r));
    status = find_change(r, &at, &change);
    yaml_document_delete(&r->document);
    SC_PASS(status);
    return sc_text_add(ctx, out, "%.*s%s%s", (int)at.begin, text, change.data, text + at.end);
}
