/* SPDX-License-Identifier: BSD-3-Clause */
/* Names of tissues as they are compared, and which labels a name or a glob means. */
#include "segcast/volume.h"

#include <ctype.h>
#include <fnmatch.h>
#include <stdlib.h>

/* Copy a string, ASCII letters in lower case, to @p to, which has SC_NAME_BYTES; what does not fit
 * is left out. */
static void lower(const char *from, char *to)
{
    size_t i = 0;

    for (; from[i] && i + 1 < SC_NAME_BYTES; i++)
        to[i] = (char)tolower((unsigned char)from[i]);
    to[i] = '\0';
}

/* Make every run of blanks, "_" and "-" in @p text a single blank, and remove those at its ends.
 * What stands in brackets, as in a glob, stays as it is if @p is_glob. */
static void join_words(char *text, bool is_glob)
{
    char *to = text;
    bool in_brackets = false;

    for (const char *from = text; *from; from++) {
        in_brackets = is_glob && (*from == '[' || (in_brackets && *from != ']'));
        if (in_brackets || !strchr(" \t_-", *from))
            *to++ = *from;
        else if (to > text && to[-1] != ' ')
            *to++ = ' ';
    }
    if (to > text && to[-1] == ' ' && !is_glob)
        to--;
    *to = '\0';
}

void sc_words_of_name(const char *name, char out[SC_NAME_BYTES])
{
    lower(name, out);
    join_words(out, false);
}

sc_status sc_label_list_add(const sc_ctx *ctx, sc_text *list, size_t before, const sc_label *label)
{
    enum { LISTED_MAX = 8 };
    const char *comma = before ? ", " : "";

    if (before > LISTED_MAX)
        return SC_OK;
    if (before == LISTED_MAX)
        return sc_text_add(ctx, list, ", ...");
    if (label->name[0])
        return sc_text_add(ctx, list, "%s\"%s\"", comma, label->name);
    return sc_text_add(ctx, list, "%slabel %lld", comma, (long long)label->value);
}

sc_pattern sc_pattern_of(const char *text)
{
    sc_pattern p = {.is_glob = strpbrk(text, "*?[") != NULL,
                    .is_all = *text && !text[strspn(text, "*")]};
    char *end;

    p.number = strtoll(text, &end, 10);
    p.is_number = end != text && !*end;
    snprintf(p.text, sizeof p.text, "%s", text);
    lower(text, p.folded);
    lower(text, p.words);
    join_words(p.words, p.is_glob);
    return p;
}

sc_match sc_label_match(const sc_label *label, const sc_pattern *p)
{
    char name[SC_NAME_BYTES];

    if (p->is_number)
        return label->value == p->number ? SC_MATCH_EXACT : SC_MATCH_NONE;
    if (p->is_all)
        return SC_MATCH_EXACT;
    if (!label->name[0])
        return SC_MATCH_NONE;
    if (!strcmp(label->name, p->text))
        return SC_MATCH_EXACT;
    lower(label->name, name);
    if (!strcmp(name, p->folded) || (p->is_glob && fnmatch(p->folded, name, 0) == 0))
        return SC_MATCH_CASE;
    sc_words_of_name(label->name, name);
    if (!strcmp(name, p->words) || (p->is_glob && fnmatch(p->words, name, 0) == 0))
        return SC_MATCH_WORDS;
    return SC_MATCH_NONE;
}

bool sc_label_name_is_clear(const sc_label *labels, int label_count, int id)
{
    const sc_pattern pattern = sc_pattern_of(labels[id].name);

    if (!labels[id].name[0] || pattern.is_number || pattern.is_glob)
        return false;
    for (int other = 1; other < label_count; other++) {
        if (other != id && sc_label_match(&labels[other], &pattern) == SC_MATCH_EXACT)
            return false;
    }
    return true;
}

sc_match sc_pattern_match(const sc_label *labels, int label_count, const sc_pattern *pattern)
{
    sc_match best = SC_MATCH_NONE;

    for (int id = 1; id < label_count && best < SC_MATCH_EXACT; id++) {
        const sc_match match = sc_label_match(&labels[id], pattern);

        best = match > best ? match : best;
    }
    return best;
}
