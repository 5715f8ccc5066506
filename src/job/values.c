/* SPDX-License-Identifier: BSD-3-Clause */
/* The types of values that any table may use. The comment of each read_... names the C type to
 * which its @p value points and what it accepts; what it refuses is logged with file and line, and
 * leaves the value as it was. write_... writes what read_... accepts. */
#include "key.h"
#include "segcast/job.h"
#include "segcast/timeline.h"
#include "yaml/yaml_words.h"

#include <math.h>
#include <stdlib.h>

enum { SHOWN_MAX = 60 }; /* bytes of a value that a message shows */

/* Append the value of @p node as it stood in the file to @p out, up to SHOWN_MAX bytes. */
static void show(const sc_yaml *node, char *out, size_t size)
{
    const size_t used = strlen(out);

    if (node->kind == SC_YAML_SCALAR) {
        snprintf(out + used, size - used, "%s", node->text);
    } else if (node->kind == SC_YAML_MAP) {
        snprintf(out + used, size - used, "{...}");
    } else {
        snprintf(out + used, size - used, "[");
        for (size_t i = 0; i < node->count && strlen(out) < SHOWN_MAX; i++) {
            strncat(out, i ? ", " : "", size - strlen(out) - 1);
            show(node->items[i], out, size);
        }
        strncat(out, "]", size - strlen(out) - 1);
    }
}

/* Cut @p text after SHOWN_MAX bytes, not within a character of UTF-8, and end it with dots. It has
 * room for 4 bytes more. */
static void shorten(char *text)
{
    size_t end = SHOWN_MAX;

    if (strlen(text) <= SHOWN_MAX)
        return;
    while (end > 0 && ((unsigned char)text[end] & 0xc0) == 0x80)
        end--;
    strcpy(text + end, "...");
}

sc_status sc_wrong_type(const sc_ctx *ctx, const sc_yaml *node, const char *expected)
{
    const char *key = node->key ? node->key : "", *blank = node->key ? " " : "";
    const char *lost = node->key || node->kind != SC_YAML_SCALAR || node->quoted
                           ? NULL
                           : sc_yaml_lost_blank(node->text);
    char value[2 * SHOWN_MAX + 8] = "";

    show(node, value, sizeof value);
    shorten(value);
    if (lost) /* the whole file, or an item of a list, where a map is expected */
        return sc_yaml_fail(ctx, node, "\"%s\": " SC_LOST_BLANK, value, (int)(lost - node->text),
                            node->text, lost);
    if (node->kind == SC_YAML_MAP)
        return sc_yaml_fail(ctx, node, "%s%sis a map, expected %s", key, blank, expected);
    if (node->kind == SC_YAML_LIST)
        return sc_yaml_fail(ctx, node, "%s%sis %s, expected %s", key, blank, value, expected);
    if (!node->text[0])
        return sc_yaml_fail(ctx, node, "%s%shas no value, expected %s", key, blank, expected);
    return sc_yaml_fail(ctx, node, "%s%sis \"%s\", expected %s", key, blank, value, expected);
}

sc_status sc_unknown_word(const sc_ctx *ctx, const sc_yaml *node, const char *word,
                          const char *const *words, size_t count)
{
    const char *nearest = sc_nearest_word(word, words, count);
    const char *what = node->key && strcmp(node->key, word) ? node->key : "key";
    SC_OWN(sc_text_clear) sc_text all = {0};

    if (nearest)
        return sc_yaml_fail(ctx, node, "unknown %s \"%s\"; did you mean \"%s\"?", what, word,
                            nearest);
    for (size_t i = 0; i < count; i++)
        SC_PASS(sc_text_add(ctx, &all, "%s%s", i ? ", " : "", words[i]));
    return sc_yaml_fail(ctx, node, "unknown %s \"%s\"; expected one of: %s", what, word,
                        all.data ? all.data : "");
}

sc_status sc_no_such_word(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                          const char *word, const char *const *words, size_t count)
{
    const char *nearest = sc_nearest_word(word, words, count);

    return nearest ? sc_yaml_fail(ctx, node, "unknown %s \"%.60s\"; did you mean \"%s\"?",
                                  key->name, node->text, nearest)
                   : sc_wrong_type(ctx, node, key->type->expected);
}

/* Copy @p text to out[size]. If it does not fit, three dots stand for what is left out: the
 * beginning if @p keep_end, else the end. No character of UTF-8 is cut in two. */
static void copy_shortened(const char *text, bool keep_end, char *out, size_t size)
{
    static const char dots[] = "...";
    const size_t length = strlen(text), kept = size - sizeof dots;
    size_t cut = keep_end ? length - kept : kept;

    if (length < size) {
        memcpy(out, text, length + 1);
    } else if (keep_end) {
        while (((unsigned char)text[cut] & 0xc0) == 0x80)
            cut++;
        strcpy(out, dots);
        strcpy(out + sizeof dots - 1, text + cut);
    } else {
        while (cut > 0 && ((unsigned char)text[cut] & 0xc0) == 0x80)
            cut--;
        memcpy(out, text, cut);
        strcpy(out + cut, dots);
    }
}

void sc_note_key(const sc_yaml *node, const char *key, char *where, size_t size)
{
    const bool in_file = node->line > 0;

    where[0] = '\0';
    if (in_file || strcmp(node->origin, key) != 0) /* else set by a command, from its argument */
        sc_note_where(node, where, size - strlen(key) - strlen(": "));
    if (in_file)
        snprintf(where + strlen(where), size - strlen(where), ": %s", key);
}

sc_status sc_tell_input(const sc_ctx *ctx, const sc_yaml *node, const char *key, const char *path,
                        sc_status status, const char *why)
{
    if (node->line > 0)
        return sc_fail(ctx, status, "%s:%d: %s: %s: %s", node->origin, node->line, key, path, why);
    if (!strcmp(node->origin, key)) /* set by a command, from its argument */
        return sc_fail(ctx, status, "%s: %s", path, why);
    return sc_fail(ctx, status, "%s: %s: %s", node->origin, path, why);
}

sc_status sc_tell_missing(const sc_ctx *ctx, const sc_yaml *node, const char *key, const char *path,
                          int error)
{
    return sc_tell_input(ctx, node, key, path, sc_input_status(error), strerror(error));
}

void sc_note_where(const sc_yaml *node, char *where, size_t size)
{
    enum { LINE_BYTES = 16 };
    const size_t room = node->line > 0 ? size - LINE_BYTES : size;

    copy_shortened(node->origin, node->line > 0, where, room);
    if (node->line > 0)
        snprintf(where + strlen(where), LINE_BYTES, ":%d", node->line);
}

/* ---- numbers ---- */

bool sc_parse_number(const sc_yaml *node, double *out)
{
    char *end;

    if (node->kind != SC_YAML_SCALAR)
        return false;
    *out = strtod(node->text, &end);
    return end != node->text && !*end && isfinite(*out);
}

sc_status sc_read_real(const sc_ctx *ctx, const sc_yaml *node, double low, double high, double *out)
{
    char range[96];
    double value;

    if (!sc_parse_number(node, &value) || !(value >= low && value <= high)) {
        snprintf(range, sizeof range, "a number from %g to %g", low, high);
        return sc_wrong_type(ctx, node, range);
    }
    *out = value;
    return SC_OK;
}

static sc_status read_real(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    return sc_read_real(ctx, node, key->low, key->high, value);
}

sc_status sc_write_number(const sc_ctx *ctx, double value, double scale, const char *unit,
                          sc_text *text)
{
    char digits[40];

    for (int count = 12; count <= 17; count++) { /* 17 are enough for any number */
        snprintf(digits, sizeof digits, "%.*g", count, value * scale);
        if (strtod(digits, NULL) / scale == value)
            break;
    }
    return sc_text_add(ctx, text, "%s%s", digits, unit);
}

sc_status sc_write_numbers(const sc_ctx *ctx, const double *values, size_t count, sc_text *text)
{
    for (size_t i = 0; i < count; i++) {
        SC_PASS(sc_text_add(ctx, text, i ? ", " : "["));
        SC_PASS(sc_write_number(ctx, values[i], 1, "", text));
    }
    return sc_text_add(ctx, text, "]");
}

static sc_status write_real(const sc_ctx *ctx, const sc_key *key, const void *value, sc_text *text)
{
    return sc_write_number(ctx, *(const double *)value, 1, "", text);
}

/* int: a whole number in the range of the row. */
static sc_status read_int(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    double number = 0;

    SC_PASS(sc_read_real(ctx, node, key->low, key->high, &number));
    if (number != (int)number)
        return sc_wrong_type(ctx, node, key->type->expected);
    *(int *)value = (int)number;
    return SC_OK;
}

static sc_status write_int(const sc_ctx *ctx, const sc_key *key, const void *value, sc_text *text)
{
    return sc_text_add(ctx, text, "%d", *(const int *)value);
}

/* ---- words and texts ---- */

/* bool: "true" or "false" and nothing else; YAML's "yes" and "on" are refused. */
static sc_status read_bool(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    const bool yes = node->kind == SC_YAML_SCALAR && !strcmp(node->text, "true");

    if (!yes && (node->kind != SC_YAML_SCALAR || strcmp(node->text, "false")))
        return sc_wrong_type(ctx, node, key->type->expected);
    *(bool *)value = yes;
    return SC_OK;
}

static sc_status write_bool(const sc_ctx *ctx, const sc_key *key, const void *value, sc_text *text)
{
    return sc_text_add(ctx, text, *(const bool *)value ? "true" : "false");
}

/* char[key->bytes]: a single value, refused if it is too long. */
static sc_status read_text(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    if (node->kind != SC_YAML_SCALAR)
        return sc_wrong_type(ctx, node, key->type->expected);
    if (strlen(node->text) >= key->bytes)
        return sc_yaml_fail(ctx, node, "%s has %zu characters, expected less than %zu", key->name,
                            strlen(node->text), key->bytes);
    strcpy(value, node->text);
    return SC_OK;
}

/* @return whether a character needs an escape in double quotes: YAML refuses it there, or reads it
 * as the end of a line. */
static bool needs_escape(unsigned code)
{
    return sc_is_control(code) || code == 0xfeff || code == 0xfffe || code == 0xffff;
}

sc_status sc_write_quoted(const sc_ctx *ctx, const char *value, sc_text *text)
{
    sc_status status = sc_text_add(ctx, text, "\"");

    for (const char *c = value; *c && status == SC_OK;) {
        const size_t whole = sc_utf8_bytes(c), bytes = whole ? whole : 1;
        const unsigned code = sc_utf8_code(c, bytes);

        if (*c == '"' || *c == '\\')
            status = sc_text_add(ctx, text, "\\%c", *c);
        else if (whole && needs_escape(code))
            status = sc_text_add(ctx, text, code < 0x100 ? "\\x%02x" : "\\u%04x", code);
        else
            status = sc_text_add(ctx, text, "%.*s", (int)bytes, c);
        c += bytes;
    }
    return status == SC_OK ? sc_text_add(ctx, text, "\"") : status;
}

sc_status sc_read_tissue(const sc_ctx *ctx, const sc_key *key, const sc_yaml *item,
                         char pattern[SC_NAME_BYTES], char where[SC_WHERE_BYTES])
{
    if (item->kind != SC_YAML_SCALAR || !item->text[0] || strlen(item->text) >= SC_NAME_BYTES)
        return sc_wrong_type(ctx, item, key->type->expected);
    strcpy(pattern, item->text);
    sc_note_where(item, where, SC_WHERE_BYTES);
    return SC_OK;
}

sc_status sc_write_item(const sc_ctx *ctx, const char **comma, const char *value, sc_text *text)
{
    SC_PASS(sc_text_add(ctx, text, "%s", *comma));
    *comma = ", ";
    return sc_write_quoted(ctx, value, text);
}

sc_status sc_read_tissues(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, int of,
                          sc_named_tissue **list, size_t *count)
{
    const size_t more = sc_yaml_length(node);
    sc_status status = SC_OK;

    SC_PASS(SC_RESIZE(ctx, *count, *count + more, list));
    for (size_t i = 0; i < more; i++) {
        const sc_yaml item = sc_yaml_item(node, i);
        sc_named_tissue *to = &(*list)[*count];
        const sc_status found = sc_read_tissue(ctx, key, &item, to->pattern, to->where);

        to->of = of;
        *count += found == SC_OK;
        if (!sc_goes_on(&status, found))
            break;
    }
    return status;
}

sc_status sc_write_tissues(const sc_ctx *ctx, const sc_named_tissue *list, size_t count, int of,
                           sc_text *text)
{
    const char *comma = "";

    SC_PASS(sc_text_add(ctx, text, "["));
    for (size_t i = 0; i < count; i++) {
        if (list[i].of == of)
            SC_PASS(sc_write_item(ctx, &comma, list[i].pattern, text));
    }
    return sc_text_add(ctx, text, "]");
}

static sc_status write_text(const sc_ctx *ctx, const sc_key *key, const void *value, sc_text *text)
{
    return sc_write_quoted(ctx, value, text);
}

/* The words of a choice. */
static size_t list_choices(const sc_key *key, const char **words)
{
    size_t count = 0;

    while ((words[count] = key->words ? key->words[count] : key->choices[count].word) != NULL)
        count++;
    return count;
}

/* @return what word number @p i of a choice stands for. */
static int choice_value(const sc_key *key, size_t i)
{
    return key->words ? (int)i : key->choices[i].value;
}

/* int: the number that stands for one of the words of the row. */
static sc_status read_choice(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    const char *words[SC_WORDS_MAX];
    const size_t count = list_choices(key, words);

    if (node->kind != SC_YAML_SCALAR)
        return sc_wrong_type(ctx, node, key->type->expected);
    for (size_t i = 0; i < count; i++) {
        if (!strcmp(node->text, words[i])) {
            *(int *)value = choice_value(key, i);
            return SC_OK;
        }
    }
    return sc_unknown_word(ctx, node, node->text, words, count);
}

/* @return SC_ERR_INTERNAL if no word stands for the number. */
static sc_status write_choice(const sc_ctx *ctx, const sc_key *key, const void *value,
                              sc_text *text)
{
    const char *words[SC_WORDS_MAX];
    const size_t count = list_choices(key, words);

    for (size_t i = 0; i < count; i++) {
        if (choice_value(key, i) == *(const int *)value)
            return sc_text_add(ctx, text, "%s", words[i]);
    }
    return sc_fail(ctx, SC_ERR_INTERNAL, "%s holds %d, which no word stands for", key->name,
                   *(const int *)value);
}

/* ---- lists of numbers ---- */

sc_status sc_read_numbers(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, size_t count,
                          double *out)
{
    if (node->kind == SC_YAML_SCALAR) {
        const char *at = node->text;

        for (size_t i = 0; i < count; i++) {
            char *end;

            out[i] = strtod(at, &end);
            if (end == at || *end != (i + 1 < count ? ',' : '\0') ||
                !(out[i] >= key->low && out[i] <= key->high))
                return sc_wrong_type(ctx, node, key->type->expected);
            at = end + 1;
        }
        return SC_OK;
    }
    if (node->kind != SC_YAML_LIST || node->count != count)
        return sc_wrong_type(ctx, node, key->type->expected);
    for (size_t i = 0; i < count; i++) {
        if (!sc_parse_number(node->items[i], &out[i]) ||
            !(out[i] >= key->low && out[i] <= key->high))
            return sc_wrong_type(ctx, node, key->type->expected);
    }
    return SC_OK;
}

/* sc_vec3: "[x, y, z]" or "x,y,z". */
static sc_status read_point(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    double p[3];

    SC_PASS(sc_read_numbers(ctx, key, node, 3, p));
    *(sc_vec3 *)value = (sc_vec3){p[0], p[1], p[2]};
    return SC_OK;
}

/* As "[x, y, z]". */
static sc_status write_point(const sc_ctx *ctx, const sc_key *key, const void *value, sc_text *text)
{
    const sc_vec3 *p = value;

    return sc_write_numbers(ctx, (double[]){p->x, p->y, p->z}, 3, text);
}

static size_t list_directions(const sc_key *key, const char **words)
{
    size_t count;
    const char *const *all = sc_anatomical_words(&count);

    memcpy(words, all, count * sizeof *words);
    return count;
}

/* sc_vec3 of length 1: an anatomical word, or three numbers that are not all 0, as read_point. */
static sc_status read_direction(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                                void *value)
{
    const char *words[SC_WORDS_MAX];
    sc_vec3 direction;

    if (node->kind == SC_YAML_SCALAR && !strchr(node->text, ',')) {
        if (sc_anatomical_direction(node->text, value))
            return SC_OK;
        return sc_unknown_word(ctx, node, node->text, words, list_directions(key, words));
    }
    SC_PASS(read_point(ctx, key, node, &direction));
    if (sc_vec3_length(direction) < 1e-9)
        return sc_yaml_fail(ctx, node, "%s has length zero, expected a direction", key->name);
    /* One that has been written by write_point stays as it is: the square of a unit vector's length
     * is rounded, so that dividing by it once more may change the last bit. */
    if (fabs(sc_vec3_dot(direction, direction) - 1) > 2e-15)
        direction = sc_vec3_unit(direction);
    *(sc_vec3 *)value = direction;
    return SC_OK;
}

const sc_value_type sc_type_bool = {
    .name = "true or false",
    .expected = "true or false",
    .read = read_bool,
    .write = write_bool,
    .schema = "{type: boolean}",
};
const sc_value_type sc_type_int = {
    .name = "whole number",
    .expected = "a whole number",
    .read = read_int,
    .write = write_int,
    .schema = "{type: integer, minimum: $low, maximum: $high}",
};
const sc_value_type sc_type_real = {
    .name = "number",
    .expected = "a number",
    .read = read_real,
    .write = write_real,
    .schema = SC_SCHEMA_NUMBER,
};
const sc_value_type sc_type_text = {
    .name = "text",
    .expected = "a text",
    .read = read_text,
    .write = write_text,
    .schema = "{type: string, maxLength: $bytes_most}",
};
const sc_value_type sc_type_choice = {
    .name = "word",
    .expected = "a word",
    .read = read_choice,
    .write = write_choice,
    .list_words = list_choices,
    .schema = "$words",
};
const sc_value_type sc_type_point = {
    .name = "[R, A, S]",
    .expected = "[R, A, S] in millimetres",
    .read = read_point,
    .write = write_point,
    .schema = "{anyOf: [" SC_SCHEMA_LIST(SC_SCHEMA_NUMBER, 3) ", {type: string}]}",
};
const sc_value_type sc_type_direction = {
    .name = "direction",
    .expected = "an anatomical word or [x, y, z]",
    .read = read_direction,
    .write = write_point,
    .list_words = list_directions,
    .schema = "{anyOf: [$words, " SC_SCHEMA_LIST(SC_SCHEMA_NUMBER, 3) "]}",
};
