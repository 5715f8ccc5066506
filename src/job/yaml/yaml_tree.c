/* SPDX-License-Identifier: BSD-3-Clause */
#include "yaml/yaml_tree.h"

#include "yaml/yaml_words.h"

#include <jansson.h>
#include <stdarg.h>
#include <stdlib.h>

enum { DEPTH_MAX = 12, NODES_MAX = 100000, DIRECTIVES_MAX = 16 };

/* The state of parsing one text. */
typedef struct reader {
    const sc_ctx *ctx;
    const char *origin, *text;
    size_t bytes; /* of the text */
    yaml_parser_t parser;
    int depth, nodes;
    bool key_left_out; /* a member was left out for a mistake in its key, which was logged */
} reader;

void sc_yaml_free(sc_yaml *node)
{
    if (!node)
        return;
    for (size_t i = 0; i < node->count; i++)
        sc_yaml_free(node->items[i]);
    sc_free(node->items);
    json_decref(node->index);
    sc_free(node->key);
    sc_free(node->text);
    sc_free(node);
}

sc_status sc_yaml_fail(const sc_ctx *ctx, const sc_yaml *node, const char *fmt, ...)
{
    const sc_status status = node->line > 0 ? SC_ERR_DATA : SC_ERR_USAGE;
    char short_text[256], *long_text = NULL;
    va_list args, again;
    int bytes;

    va_start(args, fmt);
    va_copy(again, args);
    bytes = vsnprintf(short_text, sizeof short_text, fmt, args);
    if (bytes >= (int)sizeof short_text && (long_text = malloc((size_t)bytes + 1)))
        vsnprintf(long_text, (size_t)bytes + 1, fmt, again);
    va_end(again);
    va_end(args);
    if (node->line > 0)
        (void)sc_fail(ctx, status, "%s:%d: %s", node->origin, node->line,
                      long_text ? long_text : short_text);
    else
        (void)sc_fail(ctx, status, "%s: %s", node->origin, long_text ? long_text : short_text);
    free(long_text);
    return status;
}

/* An empty node without key and text. @p origin is borrowed. Caller owns: sc_yaml_free. */
static sc_status new_node(const sc_ctx *ctx, sc_yaml_kind kind, const char *origin, int line,
                          sc_yaml **out)
{
    SC_PASS(SC_ZALLOC(ctx, 1, out));
    **out = (sc_yaml){.kind = kind, .origin = origin, .line = line};
    return SC_OK;
}

/* Make room for one more child. */
static sc_status grow(const sc_ctx *ctx, sc_yaml *parent)
{
    const size_t capacity = parent->capacity ? 2 * parent->capacity : 8;

    if (parent->count < parent->capacity)
        return SC_OK;
    SC_PASS(SC_RESIZE(ctx, parent->count, capacity, &parent->items));
    parent->capacity = capacity;
    return SC_OK;
}

/* Note under which key the next child of a map will be found: so the time of a map grows with its
 * length, not with the square of it. */
static sc_status note_key(const sc_ctx *ctx, sc_yaml *map, const char *key)
{
    if (!map->index)
        map->index = json_object();
    return json_object_set_new_nocheck(map->index, key, json_integer((json_int_t)map->count))
               ? sc_fail(ctx, SC_ERR_MEMORY, "out of memory for a map")
               : SC_OK;
}

sc_status sc_yaml_append(const sc_ctx *ctx, sc_yaml *parent, sc_yaml *child)
{
    sc_status status = grow(ctx, parent);

    if (status == SC_OK && parent->kind == SC_YAML_MAP)
        status = note_key(ctx, parent, child->key);
    if (status != SC_OK) {
        sc_yaml_free(child);
        return status;
    }
    parent->items[parent->count++] = child;
    return SC_OK;
}

sc_yaml *sc_yaml_member(const sc_yaml *map, const char *key)
{
    const size_t index = sc_yaml_index(map, key);

    return index < map->count ? map->items[index] : NULL;
}

/* The next event of libyaml, which the caller has to delete; logs why the text is not YAML. */
static sc_status next_event(reader *r, yaml_event_t *event)
{
    if (yaml_parser_parse(&r->parser, event))
        return SC_OK;
    return sc_yaml_explain(r->ctx, r->origin, r->text, r->bytes, &r->parser);
}

/* Copy a scalar of libyaml. A tag, which would be lost, and a NUL byte ("\0" in double quotes),
 * behind which everything would be lost, is refused. Caller owns *out: sc_free. */
static sc_status copy_scalar(const reader *r, const yaml_event_t *event, char **out)
{
    const char *text = (const char *)event->data.scalar.value;

    if (event->data.scalar.tag)
        return sc_fail(r->ctx, SC_ERR_DATA,
                       "%s:%zu: tags (%s) are not allowed; a value that begins with ! needs quotes",
                       r->origin, event->start_mark.line + 1, (const char *)event->data.scalar.tag);
    if (strlen(text) != event->data.scalar.length)
        return sc_fail(r->ctx, SC_ERR_DATA,
                       "%s:%zu: \"%s\\0...\" holds a NUL byte (\\0); no key and no value has one; "
                       "write \\\\ for a backslash",
                       r->origin, event->start_mark.line + 1, text);
    return sc_text_copy(r->ctx, text, out);
}

static sc_status build(reader *r, const yaml_event_t *event, sc_yaml **out);

/* Log that aliases, such as a glob without quotes, are refused. @return SC_ERR_DATA always. */
static sc_status refuse_alias(const reader *r, const yaml_event_t *event)
{
    const char *name = (const char *)event->data.alias.anchor;

    return sc_fail(
        r->ctx, SC_ERR_DATA,
        "%s:%zu: aliases (*%s) are not allowed; a name that begins with * needs quotes: \"*%s\"",
        r->origin, event->start_mark.line + 1, name, name);
}

/* @return where in a plain key a map or a list opens and does not close, as in "aorta {opacity" or
 * "output:{fps": the colon before it is missing, or the blank behind the colon. NULL: nowhere. */
static const char *opened_in_key(const yaml_event_t *event)
{
    const char *key = (const char *)event->data.scalar.value;
    const char *open = key + strcspn(key, "{[");

    return event->data.scalar.style == YAML_PLAIN_SCALAR_STYLE && open > key &&
                   strchr(" :", open[-1]) && !strpbrk(open, "}]")
               ? open
               : NULL;
}

/* Check a key of @p map: a single value. One that another member has, or behind which a colon is
 * missing, is logged, and *key stays NULL: the reading goes on, so that all mistakes are told, but
 * the member is to be left out. Caller owns *key: sc_free. The event stays with the caller. */
static sc_status build_key(reader *r, yaml_event_t *event, sc_yaml *map, char **key)
{
    const int line = (int)event->start_mark.line + 1;
    const sc_yaml *first;
    const char *open, *text;

    if (event->type == YAML_ALIAS_EVENT)
        return refuse_alias(r, event);
    if (event->type != YAML_SCALAR_EVENT)
        return sc_fail(r->ctx, SC_ERR_DATA,
                       "%s:%d: a key must be a plain word; is a bracket or a quote missing?",
                       r->origin, line);
    text = (const char *)event->data.scalar.value;
    first = sc_yaml_member(map, text);
    open = opened_in_key(event);
    if (first)
        (void)sc_fail(r->ctx, SC_ERR_DATA, "%s:%d: key \"%s\" is given twice (first in line %d)",
                      r->origin, line, text, first->line);
    else if (open && open[-1] == ':')
        (void)sc_fail(r->ctx, SC_ERR_DATA, "%s:%d: \"%s\": " SC_LOST_BLANK, r->origin, line, text,
                      (int)(open - text), text, open);
    else if (open)
        (void)sc_fail(r->ctx, SC_ERR_DATA,
                      "%s:%d: \"%s\": a colon is missing before \"%c\"; expected \"%.*s: %s\"",
                      r->origin, line, text, *open, (int)(open - text - 1), text, open);
    r->key_left_out = r->key_left_out || first || open;
    return first || open ? SC_OK : copy_scalar(r, event, key);
}

/* Append the children of a map or list to @p parent, up to the event that ends it. */
static sc_status build_children(reader *r, sc_yaml *parent, yaml_event_type_t end)
{
    sc_status status = SC_OK;

    while (status == SC_OK) {
        yaml_event_t event;
        sc_yaml *child = NULL;
        char *key = NULL;

        SC_PASS(next_event(r, &event));
        if (event.type == end) {
            yaml_event_delete(&event);
            return SC_OK;
        }
        if (parent->kind == SC_YAML_MAP) {
            status = build_key(r, &event, parent, &key);
            yaml_event_delete(&event);
            if (status == SC_OK)
                status = next_event(r, &event);
            if (status != SC_OK) {
                sc_free(key);
                return status;
            }
        }
        status = build(r, &event, &child);
        yaml_event_delete(&event);
        if (status != SC_OK || !child) {
            sc_free(key);
            return status;
        }
        if (parent->kind == SC_YAML_MAP && !key) {
            sc_yaml_free(child); /* its key is a mistake */
            continue;
        }
        child->key = key;
        status = sc_yaml_append(r->ctx, parent, child);
    }
    return status;
}

/* Build the node that begins with @p event, with all below it. Caller owns *out: sc_yaml_free. */
static sc_status build(reader *r, const yaml_event_t *event, sc_yaml **out)
{
    const int line = (int)event->start_mark.line + 1;
    SC_OWN(sc_yaml_free_at) sc_yaml *node = NULL;

    if (event->type == YAML_ALIAS_EVENT)
        return refuse_alias(r, event);
    if (++r->nodes > NODES_MAX)
        return sc_fail(r->ctx, SC_ERR_DATA, "%s:%d: more than %d values", r->origin, line,
                       NODES_MAX);
    if (++r->depth > DEPTH_MAX)
        return sc_fail(r->ctx, SC_ERR_DATA, "%s:%d: nested more than %d deep", r->origin, line,
                       DEPTH_MAX);
    if (event->type == YAML_SCALAR_EVENT) {
        SC_PASS(new_node(r->ctx, SC_YAML_SCALAR, r->origin, line, &node));
        node->quoted = event->data.scalar.style != YAML_PLAIN_SCALAR_STYLE;
        SC_PASS(copy_scalar(r, event, &node->text));
    } else if (event->type == YAML_MAPPING_START_EVENT) {
        SC_PASS(new_node(r->ctx, SC_YAML_MAP, r->origin, line, &node));
        SC_PASS(build_children(r, node, YAML_MAPPING_END_EVENT));
    } else {
        SC_PASS(new_node(r->ctx, SC_YAML_LIST, r->origin, line, &node));
        SC_PASS(build_children(r, node, YAML_SEQUENCE_END_EVENT));
    }
    r->depth--;
    SC_HAND_OVER(node, out);
    return SC_OK;
}

/* Get the next event and drop it; it must be of the given type. @param what the message if it is
 * not. */
static sc_status expect(reader *r, yaml_event_type_t type, const char *what)
{
    yaml_event_t event;
    sc_status status = SC_OK;

    SC_PASS(next_event(r, &event));
    if (event.type != type)
        status = sc_fail(r->ctx, SC_ERR_DATA, "%s:%d: %s", r->origin,
                         (int)event.start_mark.line + 1, what);
    yaml_event_delete(&event);
    return status;
}

/* Read the whole text: no document, which gives an empty map, or one. Caller owns *out. */
static sc_status parse_document(reader *r, sc_yaml **out)
{
    yaml_event_t event;
    SC_OWN(sc_yaml_free_at) sc_yaml *root = NULL;
    sc_status status;

    SC_PASS(expect(r, YAML_STREAM_START_EVENT, "expected a YAML text"));
    SC_PASS(next_event(r, &event));
    if (event.type == YAML_STREAM_END_EVENT) {
        yaml_event_delete(&event);
        return new_node(r->ctx, SC_YAML_MAP, r->origin, 1, out);
    }
    yaml_event_delete(&event);
    SC_PASS(next_event(r, &event));
    status = build(r, &event, &root);
    yaml_event_delete(&event);
    SC_PASS(status);
    SC_PASS(expect(r, YAML_DOCUMENT_END_EVENT, "expected the end of the document"));
    SC_PASS(expect(r, YAML_STREAM_END_EVENT, "a second document begins; expected one"));
    root->key_left_out = r->key_left_out;
    SC_HAND_OVER(root, out);
    return SC_OK;
}

/* Refuse a text with more than a few directives of YAML (%TAG), which no job needs: libyaml
 * compares each with all before it. */
static sc_status check_directives(const reader *r)
{
    const char *line = r->text, *end = r->text + r->bytes;
    int directives = 0;

    for (int number = 1; line; number++) {
        const char *next = memchr(line, '\n', (size_t)(end - line));

        directives += line < end && *line == '%';
        if (directives > DIRECTIVES_MAX)
            return sc_fail(r->ctx, SC_ERR_DATA,
                           "%s:%d: more than %d lines that begin with %%, expected keys of a job",
                           r->origin, number, DIRECTIVES_MAX);
        line = next ? next + 1 : NULL;
    }
    return SC_OK;
}

sc_status sc_yaml_parse(const sc_ctx *ctx, const char *origin, const char *text, size_t bytes,
                        sc_yaml **out)
{
    reader r = {.ctx = ctx, .origin = origin, .text = text, .bytes = bytes};
    sc_status status;

    if (!yaml_parser_initialize(&r.parser))
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", origin);
    yaml_parser_set_input_string(&r.parser, (const unsigned char *)text, bytes);
    status = check_directives(&r);
    if (status == SC_OK)
        status = parse_document(&r, out);
    yaml_parser_delete(&r.parser);
    return status;
}

size_t sc_yaml_index(const sc_yaml *map, const char *key)
{
    const json_t *at = json_object_get(map->index, key);

    return at ? (size_t)json_integer_value(at) : map->count;
}

void sc_yaml_remove(sc_yaml *parent, size_t index)
{
    if (parent->index)
        (void)json_object_del(parent->index, parent->items[index]->key);
    sc_yaml_free(parent->items[index]);
    parent->count--;
    memmove(parent->items + index, parent->items + index + 1,
            (parent->count - index) * sizeof *parent->items);
    for (size_t i = index; i < parent->count && parent->index; i++)
        (void)json_integer_set(json_object_get(parent->index, parent->items[i]->key),
                               (json_int_t)i);
}

sc_status sc_yaml_scalar(const sc_ctx *ctx, const char *origin, const char *text, sc_yaml **out)
{
    SC_OWN(sc_yaml_free_at) sc_yaml *node = NULL;

    SC_PASS(new_node(ctx, SC_YAML_SCALAR, origin, 0, &node));
    SC_PASS(sc_text_copy(ctx, text, &node->text));
    SC_HAND_OVER(node, out);
    return SC_OK;
}

sc_status sc_yaml_add(const sc_ctx *ctx, sc_yaml *parent, sc_yaml_kind kind, const char *key,
                      const char *origin)
{
    SC_OWN(sc_yaml_free_at) sc_yaml *child = NULL;
    sc_yaml *added;

    SC_PASS(new_node(ctx, kind, origin, 0, &child));
    if (key)
        SC_PASS(sc_text_copy(ctx, key, &child->key));
    SC_HAND_OVER(child, &added);
    return sc_yaml_append(ctx, parent, added);
}

sc_status sc_yaml_copy(const sc_ctx *ctx, const sc_yaml *node, sc_yaml **out)
{
    SC_OWN(sc_yaml_free_at) sc_yaml *copy = NULL;
    sc_yaml *child;

    SC_PASS(new_node(ctx, node->kind, node->origin, node->line, &copy));
    copy->quoted = node->quoted;
    if (node->key)
        SC_PASS(sc_text_copy(ctx, node->key, &copy->key));
    if (node->text)
        SC_PASS(sc_text_copy(ctx, node->text, &copy->text));
    for (size_t i = 0; i < node->count; i++) { /* the depth of a tree is bounded */
        SC_PASS(sc_yaml_copy(ctx, node->items[i], &child));
        SC_PASS(sc_yaml_append(ctx, copy, child));
    }
    SC_HAND_OVER(copy, out);
    return SC_OK;
}
