/* SPDX-License-Identifier: BSD-3-Clause */
/* The rows of label tables, of whatever format, and what a volume takes from them. */
#include "source.h"

void sc_name_read(const char *from, char *out, sc_name_count *count)
{
    const bool whole = sc_copy_name(from, out, SC_NAME_BYTES);

    if (!whole && count->mended++ == 0)
        memcpy(count->first, out, SC_NAME_BYTES);
}

double sc_level_mend(double level, double most, bool whole, sc_name_count *count)
{
    if ((level < 0 || level > most || (whole && level != floor(level))) && count->levels++ == 0)
        count->first_level = level;
    level = level < 0 ? 0 : level > most ? most : level;
    return whole ? floor(level + 0.5) : level;
}

void sc_name_warn(const sc_ctx *ctx, const char *path, const sc_name_count *count)
{
    if (count->levels)
        sc_warn(
            ctx,
            "%s: %d level%s of colour or opacity cannot be as they are, such as %g; they are "
            "brought into the range of the format, and rounded where it has whole numbers from 0 "
            "to 255",
            path, count->levels, count->levels == 1 ? "" : "s", count->first_level);
    if (count->mended)
        sc_warn(ctx,
                "%s: %d name%s not UTF-8 or longer than %d bytes, such as \"%s\"; what is no "
                "UTF-8 is shown as U+FFFD, and what is too long is left out: save the table as "
                "UTF-8, with shorter names",
                path, count->mended, count->mended == 1 ? " is" : "s are", SC_NAME_BYTES - 1,
                count->first);
}

void sc_label_table_clear(sc_label_table *table)
{
    sc_free(table->rows);
    *table = (sc_label_table){0};
}

sc_status sc_label_table_add(const sc_ctx *ctx, sc_label_table *table, const sc_label *row)
{
    SC_PASS(SC_GROW(ctx, table->count, &table->capacity, &table->rows));
    table->rows[table->count++] = *row;
    return SC_OK;
}

sc_label *sc_volume_label(const sc_volume *volume, int64_t value)
{
    int low = 1, high = volume->label_count - 1; /* all but background are sorted */

    while (low <= high) {
        const int middle = (low + high) / 2;

        if (volume->labels[middle].value == value)
            return &volume->labels[middle];
        if (volume->labels[middle].value < value)
            low = middle + 1;
        else
            high = middle - 1;
    }
    return NULL;
}

void sc_volume_apply_table(sc_volume *volume, const sc_label_table *table)
{
    for (size_t i = table->count; i-- > 0;) { /* backwards: the first row of a value wins */
        const sc_label *row = &table->rows[i];
        sc_label *label = sc_volume_label(volume, row->value);

        if (!label)
            continue;
        if (row->name[0])
            memcpy(label->name, row->name, sizeof label->name);
        if (row->has_color) {
            memcpy(label->rgb, row->rgb, sizeof label->rgb);
            label->has_color = true;
        }
        label->opacity = row->opacity >= 0 ? row->opacity : label->opacity;
        label->hidden = row->hidden;
    }
}
