/* SPDX-License-Identifier: BSD-3-Clause */
/* Cuts rows of label tables in text into fields: words, pairs of lines, delimited columns, and the
 * free form of lists of classes. */
#include "tables/label_table.h"

#include <ctype.h>
#include <stdlib.h>

/* What may part the fields of a row. */
#define PARTING " \t,;|"

/* Cut the next line off. */
static char *cut_line(sc_text_reading *t)
{
    char *line = t->at;

    t->at = sc_label_cut_line(line);
    t->line++;
    return line;
}

/* ---- words ---- */

/* The next word of a line, which blanks or tabs separate, as a string of its own: the text is
 * cut behind it, and *at moves behind that. NULL at the end of the line. */
static char *next_word(char **at)
{
    char *word = *at + strspn(*at, " \t");

    *at = word + strcspn(word, " \t");
    if (**at)
        *(*at)++ = '\0';
    return *word ? word : NULL;
}

static bool is_number(const char *word)
{
    char *end;

    return word && isfinite(strtod(word, &end)) && end != word && !*end;
}

/* @return what stands in quotation marks at @p at, without the backslashes before quotation marks
 * in it; NULL if nothing does. */
static char *quoted(char *at)
{
    char *begin = strchr(at, '"'), *end = begin ? strrchr(begin + 1, '"') : NULL, *to;

    if (!end)
        return NULL;
    *end = '\0';
    to = ++begin;
    for (const char *from = begin; *from; from++) {
        if (from[0] != '\\' || from[1] != '"')
            *to++ = *from;
    }
    *to = '\0';
    return begin;
}

/* @return a name as it is meant: "_" stands for none; 3D Slicer reads blanks for underscores, and
 * drops quotation marks around it. */
static char *plain_name(char *name, bool is_slicer)
{
    const size_t bytes = strlen(name);

    if (is_slicer && bytes > 2 && *name == '\'' && name[bytes - 1] == '\'') {
        name[bytes - 1] = '\0';
        name++;
    }
    if (!strcmp(name, "_"))
        *name = '\0';
    for (char *c = name; *c && is_slicer; c++)
        *c = *c == '_' ? ' ' : *c;
    return name;
}

/* Cut a line into the fields of the columns from @p first on. */
static bool cut_words(sc_text_reading *t, char *line, size_t first)
{
    sc_row *row = &t->row;

    for (row->count = first; row->count < t->column_count; row->count++) {
        const bool is_name = t->columns[row->count] == SC_COLUMN_NAME;
        const bool is_quoted = is_name && row->count + 1 == t->column_count;
        char *word = is_quoted ? quoted(line) : next_word(&line);

        if (!word || (!is_name && !is_number(word)))
            break;
        row->fields[row->count] = is_name && !is_quoted ? plain_name(word, t->is_slicer) : word;
    }
    memcpy(row->columns, t->columns, sizeof t->columns);
    return row->count >= t->columns_least;
}

bool sc_row_cut_words(sc_text_reading *t)
{
    return cut_words(t, cut_line(t), 0);
}

/* ---- pairs of lines ---- */

/* Has a line five whole numbers, and nothing else? */
static bool has_numbers(const char *line)
{
    int end = -1;

    (void)sscanf(line, "%*18d %*18d %*18d %*18d %*18d %n", &end);
    return end >= 0 && !line[end];
}

/* Copy the line at @p text, without blanks at its end, to line[bytes]. @return the next one. */
static const char *copy_line(const char *text, char *line, size_t bytes)
{
    const size_t length = strcspn(text, "\r\n");

    snprintf(line, bytes, "%.*s", (int)(length < bytes ? length : bytes - 1), text);
    text += length;
    return text + (text[0] == '\r') + (text[text[0] == '\r'] == '\n');
}

bool sc_label_workbench_is(const char *text)
{
    char name[128], numbers[128];

    text = copy_line(text, name, sizeof name);
    (void)copy_line(text, numbers, sizeof numbers);
    return name[strspn(name, " \t")] && name[0] != '#' && !has_numbers(name) &&
           has_numbers(numbers);
}

char *sc_label_trim(char *text)
{
    size_t length;

    text += strspn(text, " \t\r\n");
    for (length = strlen(text); length && strchr(" \t\r\n", text[length - 1]);)
        text[--length] = '\0';
    return text;
}

bool sc_row_cut_pair(sc_text_reading *t)
{
    t->row.fields[0] = sc_label_trim(cut_line(t));
    t->row.fields[1] = t->at ? cut_line(t) : "";
    return has_numbers(t->row.fields[1]) && cut_words(t, (char *)t->row.fields[1], 1);
}

/* ---- delimited columns ---- */

/* Cut a copy of the line at @p line into t->headings. @return how many there are. */
static size_t cut_copy(const char *line, sc_text_reading *t)
{
    const size_t bytes = strcspn(line, "\r\n");
    char *at = t->heading_line;
    int lines = 0;

    if (bytes >= sizeof t->heading_line)
        return 0;
    memcpy(at, line, bytes);
    at[bytes] = '\0';
    return sc_delimited_record(&at, t->delimiter, t->headings, SC_COLUMNS_MAX, &lines);
}

/* Take the columns of @p t from a line of headings. */
static bool read_headings(const char *line, sc_text_reading *t)
{
    t->column_count = cut_copy(line, t);
    for (size_t i = 0; i < t->column_count; i++)
        t->columns[i] = sc_column_of(t->headings[i]);
    return sc_columns_settle(t->columns, t->column_count);
}

/* @return the comment in the line above @p row, without its "#"; NULL if there is none. */
static const char *comment_above(const char *text, const char *row)
{
    if (row > text && *--row == '\n' && row > text && row[-1] == '\r')
        row--;
    while (row > text && row[-1] != '\r' && row[-1] != '\n')
        row--;
    return *row == '#' ? row + strspn(row, "# \t") : NULL;
}

bool sc_headings_find(char *text, sc_text_reading *t)
{
    char *row = text + (sc_delimited_skip_comments(text, &t->line) - text);
    const char *lines[] = {row, comment_above(text, row)};

    for (int i = 0; i < 2; i++) {
        for (const char *d = SC_DELIMITERS; *d && lines[i]; d++) {
            t->delimiter = *d;
            if (!read_headings(lines[i], t))
                continue;
            t->at = i == 0 ? sc_delimited_next_line(row) : row;
            t->line += i == 0;
            return true;
        }
    }
    return false;
}

bool sc_headings_guess(char *text, sc_text_reading *t)
{
    static const sc_column columns[] = {SC_COLUMN_VALUE, SC_COLUMN_NAME, SC_COLUMN_RED,
                                        SC_COLUMN_GREEN, SC_COLUMN_BLUE, SC_COLUMN_ALPHA};

    t->line = 0;
    t->at = text + (sc_delimited_skip_comments(text, &t->line) - text);
    memcpy(t->columns, columns, sizeof columns);
    for (const char *d = SC_DELIMITERS; *d; d++) {
        size_t count, levels = 0;

        t->delimiter = *d;
        t->column_count = count = cut_copy(t->at, t);
        if (count < 2 || count > SC_COUNT_OF(columns) || !is_number(t->headings[0]) ||
            is_number(t->headings[1]))
            continue;
        for (size_t i = 2; i < count; i++)
            levels += is_number(t->headings[i]);
        if (count == 3 && *t->headings[2] == '#')
            t->columns[2] = SC_COLUMN_COLOR;
        if (count == 2 || t->columns[2] == SC_COLUMN_COLOR || (levels >= 3 && levels == count - 2))
            return true;
    }
    return false;
}

bool sc_row_cut_delimited(sc_text_reading *t)
{
    char *fields[SC_COLUMNS_MAX];
    const size_t count =
        sc_delimited_record(&t->at, t->delimiter, fields, SC_COLUMNS_MAX, &t->line);

    t->row.count = count < t->column_count ? count : t->column_count;
    memcpy(t->row.fields, fields, t->row.count * sizeof *fields);
    memcpy(t->row.columns, t->columns, sizeof t->columns);
    return true;
}

/* ---- lists of classes ---- */

static bool is_parting(char c)
{
    return c && strchr(PARTING, c);
}

/* Where a word of a line begins, and how long it is. */
typedef struct word {
    char *begin;
    size_t bytes;
} word;

/* Is the word a level of a colour, a whole number from 0 to 255? */
static bool is_level(const word *w)
{
    return w->bytes <= 3 && strspn(w->begin, "0123456789") >= w->bytes && atoi(w->begin) <= 255;
}

/* Find the colour that a row ends with: "#ff8000", or three or four numbers from 0 to 255. @param
 * words its words, the last one first. @return how many; 0 if there is none. */
static size_t find_color(char *row, word words[4])
{
    char *end = row + strlen(row);
    size_t count = 0;

    while (count < 4) {
        word *w = &words[count];

        while (end > row && is_parting(end[-1]))
            end--;
        for (w->begin = end; w->begin > row && !is_parting(w->begin[-1]);)
            w->begin--;
        w->bytes = (size_t)(end - w->begin);
        if (w->begin == row) /* the number of the label */
            break;
        if (!count && *w->begin == '#') {
            const bool is_known = w->bytes == 4 || w->bytes == 7 || w->bytes == 9;

            return is_known && strspn(w->begin + 1, "0123456789abcdefABCDEF") >= w->bytes - 1;
        }
        if (!is_level(w))
            break;
        count++;
        end = w->begin;
    }
    return count < 3 ? 0 : count;
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

bool sc_row_cut_class(sc_text_reading *t)
{
    char *line = cut_line(t), *at = line + strspn(line, " \t|\"'"), *name, *end;
    static const sc_column levels[] = {SC_COLUMN_RED, SC_COLUMN_GREEN, SC_COLUMN_BLUE,
                                       SC_COLUMN_OPACITY};
    size_t colors;
    word words[4];
    sc_row *row = &t->row;

    end = at + strspn(at, "+-");
    end += strspn(end, "0123456789");
    if (end == at || !*end || !strchr(" \t:,;=|\"'", *end))
        return false;
    colors = find_color(at, words);
    if (colors && words[colors - 1].begin <= end)
        colors = 0;
    row->count = 0;
    (void)sc_row_add(row, SC_COLUMN_VALUE, at);
    (void)sc_row_add(row, SC_COLUMN_NAME, "");
    for (size_t i = 0; i < colors; i++) {
        const word *w = &words[colors - 1 - i];

        w->begin[-1] = w->begin[w->bytes] = '\0';
        /* 0 is not taken for an opacity: some tables write transparency, in which it is opaque. */
        if (i < 3 || atoi(w->begin) > 0)
            (void)sc_row_add(row, colors == 1 ? SC_COLUMN_COLOR : levels[i], w->begin);
    }
    name = end + strspn(end, "\"'");
    name = cut_name(name + strspn(name, " \t:,;=|"));
    *end = '\0';
    if (name)
        row->fields[1] = colors ? last_column(name) : name;
    return name != NULL;
}

bool sc_class_is(char *line, bool *has_color, bool *more_fields)
{
    const char *at = line + strspn(line, " \t|\"'"), *second;
    const size_t digits = strspn(at, "0123456789");
    const size_t separates = strspn(at + digits, " \t:,;=|\"'");
    word words[4];

    at += digits + separates;
    *more_fields = *has_color = false;
    if (!digits || !separates || !(isalpha((unsigned char)*at) || *at & 0x80))
        return false;
    for (const char *d = ",;\t"; *d && !*more_fields; d++) {
        second = strchr(line, *d);
        second = second ? strchr(second + 1, *d) : NULL;
        *more_fields = second && second[1 + strspn(second + 1, PARTING)];
    }
    *has_color = find_color(line, words) > 0;
    *more_fields = *more_fields && !*has_color;
    return true;
}
