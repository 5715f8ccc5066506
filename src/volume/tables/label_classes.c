/* SPDX-License-Identifier: BSD-3-Clause */
/* Lists of classes: a number and a name a line, however they are parted, and perhaps a colour.
 * Among them are the tables of MRtrix, which have a short name, a long one, and four numbers. */
#include "tables/label_table.h"

#include <ctype.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* What may part the fields of a row. */
#define PARTING " \t,;|"

static bool is_parting(char c)
{
    return c && strchr(PARTING, c);
}

/* Read the word from @p begin to @p end as a level of a colour. */
static bool read_level(const char *begin, const char *end, float *level)
{
    const size_t digits = strspn(begin, "0123456789");

    if (!digits || digits > 3 || begin + digits != end)
        return false;
    *level = (float)atoi(begin);
    return *level <= 255;
}

/* @return where the colour begins that a row ends with, "#ff8000" or three or four numbers from 0
 * to 255, without the blanks before it; NULL if there is none. @param level red, green, blue and
 * opacity, NAN if that is not given. */
static const char *find_color(const char *row, float level[4])
{
    const char *end = row + strlen(row), *first = NULL;
    float numbers[4]; /* from the last on */
    size_t count = 0;

    while (count < 4) {
        const char *begin;

        while (end > row && is_parting(end[-1]))
            end--;
        for (begin = end; begin > row && !is_parting(begin[-1]);)
            begin--;
        if (begin == row) /* the number of the label */
            break;
        if (!count && *begin == '#' && end - begin < 10) {
            char digits[10];

            snprintf(digits, sizeof digits, "%.*s", (int)(end - begin - 1), begin + 1);
            level[3] = NAN;
            return sc_hexadecimal_read(digits, level) ? begin : NULL;
        }
        if (!read_level(begin, end, &numbers[count]))
            break;
        count++;
        first = end = begin;
    }
    if (count < 3)
        return NULL;
    for (size_t i = 0; i < 4; i++)
        level[i] = i < count ? numbers[count - 1 - i] : NAN;
    return first;
}

/* Cut the name at @p name: behind its closing quote, if it begins with one, else before the next
 * bar and before commas and blanks at its end. @return where it begins; NULL if there is none, or
 * if it is a number. */
static char *cut_name(char *name)
{
    const char quote = *name == '"' || *name == '\'' ? *name : '\0';
    char *end;

    name += quote != '\0';
    if (!*name || strspn(name, "0123456789.+- \t,;|\"'") == strlen(name))
        return NULL;
    end = name + strcspn(name, quote == '"' ? "\"" : quote ? "'" : "|");
    while (!quote && end > name && strchr(" \t,;", end[-1]))
        end--;
    *end = '\0';
    return name;
}

/* @return the last column of a name that consists of several: short and long names, between which
 * there is a tab, or more than one blank. */
static char *last_column(char *name)
{
    char *last = name;

    for (char *at = name; *at; at++) {
        const bool parted = *at == '\t' || (at[0] == ' ' && at[1] == ' ');

        if (parted && at[strspn(at, " \t")])
            last = at + strspn(at, " \t");
    }
    return last;
}

bool sc_class_parse(char *line, sc_label *row, sc_name_count *names)
{
    char *at = line + strspn(line, " \t|\"'"), *end, *name;
    float level[4];
    const char *color;

    errno = 0;
    row->value = strtoll(at, &end, 10);
    if (end == at || errno || !*end || !strchr(" \t:,;=|\"'", *end) ||
        llabs(row->value) > (1LL << 53))
        return false;
    color = find_color(at, level);
    if (color && color > end) {
        at[color - at] = '\0';
        for (int i = 0; i < 3; i++)
            row->rgb[i] = (uint8_t)level[i];
        row->has_color = true;
        /* 0 is not taken for an opacity: some tables write transparency, in which it is opaque. */
        if (level[3] > 0 && level[3] < 255)
            row->opacity = level[3] / 255;
    }
    end += strspn(end, "\"'");
    name = cut_name(end + strspn(end, " \t:,;=|"));
    if (!name)
        return false;
    sc_name_read(row->has_color ? last_column(name) : name, row->name, names);
    return true;
}

bool sc_class_is(const char *line, bool *has_color, bool *more_fields)
{
    const size_t blanks = strspn(line, " \t|\"'"), digits = strspn(line + blanks, "0123456789");
    const char *at = line + blanks + digits;
    const size_t separates = strspn(at, " \t:,;=|\"'");
    float level[4];

    *more_fields = *has_color = false;
    if (!digits || !separates || !(isalpha((unsigned char)at[separates]) || at[separates] & 0x80))
        return false;
    for (const char *d = ",;\t"; *d && !*more_fields; d++) {
        const char *first = strchr(line, *d), *second = first ? strchr(first + 1, *d) : NULL;

        *more_fields = second && second[1 + strspn(second + 1, PARTING)];
    }
    *has_color = find_color(line, level) != NULL;
    *more_fields = *more_fields && !*has_color;
    return true;
}
