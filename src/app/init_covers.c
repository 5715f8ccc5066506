/* SPDX-License-Identifier: BSD-3-Clause */
/* Which tissues of a volume enclose and hide the others: skin, or what a segmentation calls
 * "other". */
#include "init.h"

#include <ctype.h>
#include <string.h>

static char lower(char c)
{
    return (char)tolower((unsigned char)c);
}

void sc_plain_words(const char *name, char *to)
{
    size_t used = 0;

    for (; *name && used + 1 < SC_NAME_BYTES; name++) {
        const char c = lower(*name);

        if (!strchr(" _-.,;:/()[]", c))
            to[used++] = c;
        else if (used > 0 && to[used - 1] != ' ')
            to[used++] = ' ';
    }
    while (used > 0 && to[used - 1] == ' ')
        used--;
    to[used] = '\0';
}

bool sc_word_begins(const char *words, const char *beginning)
{
    const char *at = words;

    while ((at = strstr(at, beginning)) != NULL) {
        if (at == words || at[-1] == ' ')
            return true;
        at++;
    }
    return false;
}

/* Does the name say that a tissue is the outside, or what is left over? */
static bool is_named_as_cover(const char *name)
{
    static const char *const beginnings[] = {"other",   "skin",       "unknown",  "background",
                                             "unclass", "unlabel",    "rest of",  "remain",
                                             "outside", "exterior",   "undefin",  "soft tissue",
                                             "subcut",  "body trunc", "body extr"};
    char words[SC_NAME_BYTES];

    sc_plain_words(name, words);
    for (size_t i = 0; i < SC_COUNT_OF(beginnings); i++) {
        if (sc_word_begins(words, beginnings[i]))
            return true;
    }
    return !strcmp(words, "body") || !strcmp(words, "head") || !strcmp(words, "rest");
}

/* What rays along the axes of the volume meet, in both directions. */
typedef struct tally {
    uint64_t hides; /* rays that meet this tissue first, and another one behind it */
    uint64_t only;  /* rays that meet this tissue alone */
} tally;

static int id_at(const sc_prepared *v, size_t index)
{
    return v->label_bytes == 1 ? ((const uint8_t *)v->ids)[index]
                               : ((const uint16_t *)v->ids)[index];
}

/* Follow a ray of @p count voxels from @p index on. @param removed tissues through which it passes.
 * @return whether it meets anything. */
static bool follow(const sc_prepared *v, const bool *removed, size_t index, ptrdiff_t step,
                   int count, tally *tallies)
{
    int first = 0;

    for (int i = 0; i < count; i++, index += (size_t)step) {
        const int id = id_at(v, index);

        if (id == 0 || removed[id] || id == first)
            continue;
        if (first) {
            tallies[first].hides++;
            return true;
        }
        first = id;
    }
    if (first)
        tallies[first].only++;
    return first != 0;
}

/* Send rays along @p axis in both directions. @return how many of them meet anything. */
static uint64_t send_rays(const sc_prepared *v, int axis, const bool *removed, tally *tallies)
{
    enum { RAYS = 160 }; /* along each of the other two axes, at most */
    const size_t strides[3] = {1, (size_t)v->size[0], (size_t)v->size[0] * (size_t)v->size[1]};
    const int a = (axis + 1) % 3, b = (axis + 2) % 3, count = v->size[axis];
    const int step_a = v->size[a] / RAYS + 1, step_b = v->size[b] / RAYS + 1;
    const ptrdiff_t step = (ptrdiff_t)strides[axis];
    uint64_t met = 0;

    for (int i = 0; i < v->size[a]; i += step_a) {
        for (int j = 0; j < v->size[b]; j += step_b) {
            const size_t begin = (size_t)i * strides[a] + (size_t)j * strides[b];
            const size_t end = begin + (size_t)(count - 1) * strides[axis];

            met += follow(v, removed, begin, step, count, tallies);
            met += follow(v, removed, end, -step, count, tallies);
        }
    }
    return met;
}

/* @return the tissue that hides others on the largest share of the rays that meet others at all, if
 * that share is at least @p least; otherwise 0. @param tallies room for label_count. */
static int find_cover(const sc_prepared *v, const bool *removed, double least, tally *tallies)
{
    uint64_t met = 0;
    double most = least;
    int best = 0;

    memset(tallies, 0, (size_t)v->label_count * sizeof *tallies);
    for (int axis = 0; axis < 3; axis++)
        met += send_rays(v, axis, removed, tallies);
    for (int id = 1; id < v->label_count; id++) {
        const uint64_t others = met - tallies[id].only; /* rays that meet another tissue */
        const double share = others ? (double)tallies[id].hides / (double)others : 0;

        if (share >= most && others * 50 > met) {
            most = share;
            best = id;
        }
    }
    return best;
}

sc_status sc_find_covers(const sc_ctx *ctx, const sc_prepared *volume, const bool *hidden,
                         int *layers)
{
    enum { LAYERS_MAX = 5 };
    const double least = 0.55; /* of the rays: skin and skull hide more, half of a brain less */
    const size_t count = (size_t)volume->label_count;
    bool *removed;
    void *flags = NULL, *tallies = NULL;
    int layer = 0;
    sc_status status;

    SC_TRY(sc_alloc(ctx, count, sizeof *removed, &flags));
    SC_TRY(sc_alloc(ctx, count, sizeof(tally), &tallies));
    removed = flags;
    for (size_t id = 0; id < count; id++) {
        removed[id] = hidden[id];
        layers[id] = 0;
    }
    while (layer < LAYERS_MAX) {
        const int cover = find_cover(volume, removed, least, tallies);

        if (!cover)
            break;
        layers[cover] = ++layer;
        removed[cover] = true;
    }
    for (size_t id = 1; id < count && count > 2; id++) {
        if (!layers[id] && !hidden[id] && is_named_as_cover(volume->labels[id].name))
            layers[id] = layer + 1;
    }
out:
    sc_free(flags);
    sc_free(tallies);
    return status;
}
