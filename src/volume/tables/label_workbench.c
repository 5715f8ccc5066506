/* SPDX-License-Identifier: BSD-3-Clause */
/* Label lists of Connectome Workbench (wb_command -volume-label-import): two lines for a label, the
 * name, and then its key and the levels of red, green, blue and opacity, from 0 to 255. */
#include "tables/label_table.h"

#include <string.h>

/* Read five whole numbers, and nothing else, from a line. */
static bool read_numbers(const char *line, long long out[5])
{
    int end = -1;

    return sscanf(line, "%18lld %18lld %18lld %18lld %18lld %n", &out[0], &out[1], &out[2], &out[3],
                  &out[4], &end) == 5 &&
           end >= 0 && !line[end];
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
    long long unused[5];

    text = copy_line(text, name, sizeof name);
    (void)copy_line(text, numbers, sizeof numbers);
    return name[strspn(name, " \t")] && name[0] != '#' && !read_numbers(name, unused) &&
           read_numbers(numbers, unused);
}

/* Read the two lines of a label. @return false if the second has not its form. */
static bool read_label(char *name, const char *numbers, sc_label *row, sc_name_count *names)
{
    size_t length = strlen(name);
    long long number[5];

    *row = (sc_label){.opacity = -1, .has_color = true};
    if (!numbers || !read_numbers(numbers, number))
        return false;
    while (length && strchr(" \t", name[length - 1]))
        name[--length] = '\0';
    sc_name_read(name + strspn(name, " \t"), row->name, names);
    row->value = number[0];
    for (int i = 0; i < 3; i++)
        row->rgb[i] = (uint8_t)sc_level_mend((double)number[i + 1], 255, true, names);
    row->opacity = (float)(sc_level_mend((double)number[4], 255, true, names) / 255);
    row->hidden = row->opacity == 0;
    row->opacity = row->opacity < 1 ? row->opacity : -1; /* full opacity counts as not given */
    return true;
}

sc_status sc_label_workbench_parse(const sc_ctx *ctx, const char *path, char *text,
                                   sc_label_table *table)
{
    sc_name_count names = {0};
    bool has_rows = false;
    int number = 0;
    sc_status status = SC_OK;

    for (char *line = text, *next; line && status == SC_OK; line = next) {
        char *numbers = sc_label_cut_line(line);
        sc_label row;

        number++;
        next = numbers;
        if (!line[strspn(line, " \t")])
            continue;
        next = numbers ? sc_label_cut_line(numbers) : NULL;
        if (!read_label(line, numbers, &row, &names))
            return sc_fail(
                ctx, SC_ERR_DATA,
                "%s:%d: is \"%.80s\", expected the key of the label \"%.80s\" and its red, "
                "green, blue and opacity from 0 to 255, such as: 1 255 0 0 255",
                path, number + 1, numbers ? numbers : "", line);
        number++;
        has_rows = true;
        if (row.value && table->count == SC_TABLE_ROWS_MAX)
            return sc_fail(ctx, SC_ERR_DATA, "%s:%d: more than %d labels", path, number,
                           SC_TABLE_ROWS_MAX);
        if (row.value) /* background is never shown */
            status = sc_label_table_add(ctx, table, &row);
    }
    if (status == SC_OK && !has_rows)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: has no labels; expected two lines for each, its name "
                       "and its key with a colour",
                       path);
    if (status == SC_OK)
        sc_name_warn(ctx, path, &names);
    return status;
}
