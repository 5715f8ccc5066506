/* SPDX-License-Identifier: BSD-3-Clause */
#include "segcast/base.h"

#include <ctype.h>
#include <stdarg.h>
#include <strings.h>

/* Make room for @p more_bytes characters and the NUL byte behind them. */
static sc_status reserve(const sc_ctx *ctx, sc_text *text, size_t more_bytes)
{
    const size_t needed = text->length_bytes + more_bytes + 1;
    size_t capacity = text->capacity_bytes ? text->capacity_bytes : 256;
    void *data;

    if (needed <= text->capacity_bytes)
        return SC_OK;
    while (capacity < needed)
        capacity *= 2;
    SC_PASS(sc_alloc(ctx, capacity, 1, &data));
    if (text->length_bytes)
        memcpy(data, text->data, text->length_bytes);
    sc_free(text->data);
    text->data = data;
    text->capacity_bytes = capacity;
    return SC_OK;
}

sc_status sc_text_add(const sc_ctx *ctx, sc_text *text, const char *fmt, ...)
{
    va_list args, again;
    sc_status status;
    int count;

    va_start(args, fmt);
    va_copy(again, args);
    count = vsnprintf(NULL, 0, fmt, args);
    status = count < 0 ? sc_fail(ctx, SC_ERR_INTERNAL, "cannot format text")
                       : reserve(ctx, text, (size_t)count);
    if (status == SC_OK) {
        vsnprintf(text->data + text->length_bytes, (size_t)count + 1, fmt, again);
        text->length_bytes += (size_t)count;
    }
    va_end(again);
    va_end(args);
    return status;
}

sc_status sc_text_add_field(const sc_ctx *ctx, sc_text *text, const char *field,
                            const char *special)
{
    if (special && !strpbrk(field, special))
        return sc_text_add(ctx, text, "%s", field);
    SC_PASS(sc_text_add(ctx, text, "\""));
    for (; *field; field++)
        SC_PASS(sc_text_add(ctx, text, *field == '"' ? "\"\"" : "%c", *field));
    return sc_text_add(ctx, text, "\"");
}

sc_status sc_text_copy(const sc_ctx *ctx, const char *from, char **out)
{
    sc_text text = {0};

    SC_PASS(sc_text_add(ctx, &text, "%s", from));
    *out = text.data;
    return SC_OK;
}

void sc_text_clear(sc_text *text)
{
    sc_free(text->data);
    *text = (sc_text){0};
}

enum { WORD_MAX = 64 };

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

static bool same_letter(char a, char b)
{
    return tolower((unsigned char)a) == tolower((unsigned char)b);
}

/* Levenshtein distance over the first WORD_MAX characters, case ignored. */
static size_t edit_distance(const char *a, const char *b)
{
    const size_t columns = least(strlen(b), WORD_MAX);
    size_t row[WORD_MAX + 1];

    for (size_t j = 0; j <= columns; j++)
        row[j] = j;
    for (size_t i = 0; a[i] && i < WORD_MAX; i++) {
        size_t diagonal = row[0];

        row[0] = i + 1;
        for (size_t j = 0; j < columns; j++) {
            const size_t change = diagonal + !same_letter(a[i], b[j]);

            diagonal = row[j + 1];
            row[j + 1] = least(change, least(row[j], diagonal) + 1);
        }
    }
    return row[columns];
}

size_t sc_stem_length(const char *name, const char *const *endings, size_t count)
{
    const size_t length = strlen(name);

    for (size_t i = 0; i < count; i++) {
        const size_t n = strlen(endings[i]);

        if (length > n && !strcasecmp(name + length - n, endings[i]))
            return length - n;
    }
    return 0;
}

const char *sc_nearest_word(const char *word, const char *const *candidates, size_t count)
{
    const char *best = NULL;
    size_t best_distance = strlen(word) / 3 + 2;

    for (size_t i = 0; i < count; i++) {
        size_t distance;

        if (!candidates[i])
            continue;
        distance = edit_distance(word, candidates[i]);
        if (distance < best_distance) {
            best_distance = distance;
            best = candidates[i];
        }
    }
    return best;
}

/* Append @p word to the @p found words of @p out, unless it is among them. @return how many there
 * are then. */
static size_t add_different(const char *word, const char **out, size_t found)
{
    for (size_t i = 0; i < found; i++) {
        if (!strcmp(out[i], word))
            return found;
    }
    out[found] = word;
    return found + 1;
}

/* Is @p part a part of @p word, ASCII case ignored? An empty one is not. */
static bool is_part(const char *part, const char *word)
{
    const size_t length = strlen(part);

    for (; length > 0 && strlen(word) >= length; word++) {
        size_t i = 0;

        while (i < length && same_letter(part[i], word[i]))
            i++;
        if (i == length)
            return true;
    }
    return false;
}

size_t sc_nearest_words(const char *word, const char *const *candidates, size_t count, size_t most,
                        const char **out)
{
    const char *nearest = sc_nearest_word(word, candidates, count);
    const size_t least_distance = nearest ? edit_distance(word, nearest) : 0;
    size_t found = 0;

    for (size_t more = 0; nearest && more < 2; more++) {
        for (size_t i = 0; i < count && found < most; i++) {
            if (candidates[i] && edit_distance(word, candidates[i]) == least_distance + more)
                found = add_different(candidates[i], out, found);
        }
    }
    for (size_t i = 0; !nearest && i < count && found < most; i++) {
        if (candidates[i] && is_part(word, candidates[i]))
            found = add_different(candidates[i], out, found);
    }
    return found;
}
