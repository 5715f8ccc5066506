/* SPDX-License-Identifier: BSD-3-Clause */
/* The size of a picture: two numbers, or the name of a usual size; and that of a volume. */
#include "key.h"

#include <stdlib.h>
#include <strings.h>

static const struct {
    const char *name;
    int size_px[2];
} names[] = {{"4k", {3840, 2160}},       {"8k", {7680, 4320}},          {"2160p", {3840, 2160}},
             {"1440p", {2560, 1440}},    {"1080p", {1920, 1080}},       {"720p", {1280, 720}},
             {"480p", {854, 480}},       {"360p", {640, 360}},          {"hd", {1280, 720}},
             {"full-hd", {1920, 1080}},  {"vertical", {1080, 1920}},    {"square", {1080, 1080}},
             {"uhd", {3840, 2160}},      {"vertical-4k", {2160, 3840}}, {"portrait", {1080, 1920}},
             {"landscape", {1920, 1080}}};

/* The names of the table. */
static size_t list_names(const sc_key *key, const char **words)
{
    for (size_t i = 0; i < SC_COUNT_OF(names); i++)
        words[i] = names[i].name;
    return SC_COUNT_OF(names);
}

/* @return how many bytes the sign between two numbers has at @p text: x, X, * or the sign of
 * multiplication (U+00D7); 0: none. */
static size_t times_bytes(const char *text)
{
    return *text && strchr("xX*", *text) ? 1 : strncmp(text, "\xc3\x97", 2) ? 0 : 2;
}

/* Read @p count numbers, as "WxH"; blanks around the x are allowed. @return false if the text has
 * another form. */
static bool read_product(const char *text, int count, double *size)
{
    char *end;

    for (int i = 0; i < count; i++) {
        if (!*text || !strchr("0123456789", text[0]))
            return false;
        size[i] = (double)strtol(text, &end, 10);
        end += strspn(end, " ");
        if (i + 1 < count && !times_bytes(end))
            return false;
        text = end + (i + 1 < count ? times_bytes(end) : 0);
        text += strspn(text, " ");
    }
    return !*text;
}

/* Read a size given as one value: a name, or "WxH". */
static sc_status read_word(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                           double size[2])
{
    const char *words[SC_COUNT_OF(names)];

    if (read_product(node->text, 2, size))
        return SC_OK;
    for (size_t i = 0; i < SC_COUNT_OF(names); i++) {
        if (!strcasecmp(node->text, names[i].name)) {
            size[0] = names[i].size_px[0];
            size[1] = names[i].size_px[1];
            return SC_OK;
        }
    }
    (void)list_names(key, words);
    /* One or two letters would be near to every short name. */
    return sc_no_such_word(ctx, key, node, node->text, words,
                           strlen(node->text) > 2 ? SC_COUNT_OF(words) : 0);
}

/* Store @p count numbers as int, which they must be, within the range of the key. */
static sc_status store_whole(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, int count,
                             const double *size, int *out)
{
    for (int i = 0; i < count; i++) {
        if (!(size[i] >= key->low && size[i] <= key->high) || size[i] != (int)size[i])
            return sc_wrong_type(ctx, node, key->type->expected);
        out[i] = (int)size[i];
    }
    return SC_OK;
}

/* int[2], width and height in pixels: "[W, H]", "WxH", or a name. */
static sc_status read_size(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    double size[2] = {0};

    if (node->kind == SC_YAML_SCALAR)
        SC_PASS(read_word(ctx, key, node, size));
    else
        SC_PASS(sc_read_numbers(ctx, key, node, 2, size));
    return store_whole(ctx, key, node, 2, size, value);
}

/* As "[W, H]". */
static sc_status write_size(const sc_ctx *ctx, const sc_key *key, const void *value, sc_text *text)
{
    const int *size = value;

    return sc_text_add(ctx, text, "[%d, %d]", size[0], size[1]);
}

const sc_value_type sc_type_size = {
    .name = "[width, height]",
    .expected = "[width, height] or WxH in pixels, whole numbers from 16 to 16384, or a name such "
                "as 1080p, 4k, square or vertical",
    .read = read_size,
    .write = write_size,
    .list_words = list_names,
    .schema = "{anyOf: [" SC_SCHEMA_LIST(
        "{type: integer, minimum: $low, maximum: $high}",
        2) ", $words, {type: string, pattern: '^[0-9]+ *[xX*\u00d7] *[0-9]+$'}]}",
};

bool sc_parse_voxels(const char *text, int size[3])
{
    double read[3];

    if (!read_product(text, 3, read))
        return false;
    for (int i = 0; i < 3; i++) {
        if (!(read[i] >= 1 && read[i] <= 4096) || read[i] != (int)read[i])
            return false;
        size[i] = (int)read[i];
    }
    return true;
}
