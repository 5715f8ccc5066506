/* SPDX-License-Identifier: BSD-3-Clause */
/* Words in the names of tissues, and the layers of those that lie around the others or are left
 * over.
 */
#include "init/init.h"

#include <ctype.h>

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

sc_status sc_name_covers(const sc_ctx *ctx, const sc_prepared *volume, const bool *hidden,
                         int *layers)
{
    const sc_volume view = {.size = {volume->size[0], volume->size[1], volume->size[2]},
                            .label_bytes = volume->label_bytes,
                            .ids = (void *)volume->ids, /* which are only read */
                            .label_count = volume->label_count};
    const int count = volume->label_count;
    int deepest = 0;
    sc_status status = sc_find_covers(ctx, &view, hidden, layers, NULL);

    for (int id = 1; id < count && status == SC_OK; id++)
        deepest = layers[id] > deepest ? layers[id] : deepest;
    for (int id = 1; id < count && count > 2 && status == SC_OK; id++) {
        const sc_name_role role = sc_name_role_of(volume->labels[id].name);

        if (role == SC_NAME_REST && hidden[id])
            layers[id] = deepest ? deepest + 1 : 2;
        else if (role == SC_NAME_OUTSIDE && !hidden[id] && !layers[id])
            layers[id] = deepest + 1;
    }
    return status;
}
