/* SPDX-License-Identifier: BSD-3-Clause */
/* Label tables of volumes whose labels segcast has numbered itself: masks of a directory have names
 * and no numbers, so the rows of a table are found by their names. */
#include "segcast/volume.h"

#include <stdlib.h>

/* A label with a name. */
typedef struct named {
    char words[SC_NAME_BYTES]; /* as names are compared */
    const char *name;          /* as it is written; borrowed */
    int id;
} named;

/* For qsort and bsearch of named: by the words of the names. */
static int by_words(const void *a, const void *b)
{
    return strcmp(((const named *)a)->words, ((const named *)b)->words);
}

/* @return the id of the label that the name @p wanted means: of several with the same words that
 * which is written like it, or else one that no row has yet; 0: none. @param taken by dense id. */
static int find_name(const named *names, size_t count, const named *wanted, const bool *taken)
{
    const named *found = count ? bsearch(wanted, names, count, sizeof *names, by_words) : NULL;
    int id = 0;

    while (found && found > names && !by_words(found - 1, wanted))
        found--;
    for (; found && found < names + count && !by_words(found, wanted); found++) {
        if (!strcmp(found->name, wanted->name))
            return taken[found->id] ? 0 : found->id;
        if (!id && !taken[found->id])
            id = found->id;
    }
    return id;
}

sc_status sc_label_table_match(const sc_ctx *ctx, const sc_label *labels, int label_count,
                               const sc_label_table *table, int *label_of, size_t *found)
{
    SC_OWN(sc_free_at) bool *taken = NULL;
    SC_OWN(sc_free_at) named *names = NULL;
    size_t count = 0;

    SC_PASS(SC_ZALLOC(ctx, (size_t)label_count, &taken));
    SC_PASS(SC_ALLOC(ctx, (size_t)label_count, &names));
    for (int id = 1; id < label_count; id++) {
        if (!labels[id].name[0])
            continue;
        sc_words_of_name(labels[id].name, names[count].words);
        names[count].name = labels[id].name;
        names[count++].id = id;
    }
    qsort(names, count, sizeof *names, by_words);
    *found = 0;
    for (size_t i = 0; i < table->count; i++) {
        named wanted = {.name = table->rows[i].name};

        sc_words_of_name(wanted.name, wanted.words);
        label_of[i] = wanted.words[0] ? find_name(names, count, &wanted, taken) : 0;
        taken[label_of[i]] = label_of[i] != 0;
        *found += label_of[i] != 0;
    }
    return SC_OK;
}

/* A number, and whose it is: a row of a table, or a label. */
typedef struct numbered {
    int64_t value;
    size_t row;
    int id; /* of the label; 0: none */
} numbered;

/* For qsort of numbered: rising by number, of one number in the order of the rows. */
static int by_number(const void *a, const void *b)
{
    const numbered *x = a, *y = b;

    if (x->value != y->value)
        return (x->value > y->value) - (x->value < y->value);
    return (x->row > y->row) - (x->row < y->row);
}

/* Set numbers[id].value of all labels: that of the row that names it, if it is the first row of
 * this number, which is the one that counts; else the least one from 1 on that no row has.
 * @param rows [row_count], sorted. */
static void choose_numbers(const numbered *rows, size_t row_count, numbered *numbers, int count)
{
    int64_t next = 1;
    size_t at = 0;

    for (int id = 0; id < count; id++)
        numbers[id] = (numbered){.id = id};
    for (size_t i = 0; i < row_count; i++) {
        if (rows[i].id && (i == 0 || rows[i].value != rows[i - 1].value))
            numbers[rows[i].id].value = rows[i].value;
    }
    for (int id = 1; id < count; id++) {
        if (numbers[id].value) /* no row has the number 0, that of background */
            continue;
        for (; at < row_count && rows[at].value <= next; at++)
            next += rows[at].value == next;
        numbers[id].value = next++;
    }
}

sc_status sc_relabel_by_table(const sc_ctx *ctx, const sc_label *labels, int label_count,
                              const sc_label_table *table, const int *label_of, sc_relabel *out)
{
    SC_OWN(sc_relabel_clear) sc_relabel made = {.label_count = label_count};
    SC_OWN(sc_free_at) numbered *rows = NULL, *numbers = NULL;

    SC_PASS(SC_ALLOC(ctx, table->count + 1, &rows));
    SC_PASS(SC_ALLOC(ctx, (size_t)label_count, &numbers));
    SC_PASS(SC_ZALLOC(ctx, (size_t)label_count, &made.to));
    SC_PASS(SC_ALLOC(ctx, (size_t)label_count, &made.labels));
    for (size_t i = 0; i < table->count; i++)
        rows[i] = (numbered){table->rows[i].value, i, label_of[i]};
    qsort(rows, table->count, sizeof *rows, by_number);
    choose_numbers(rows, table->count, numbers, label_count);
    qsort(numbers + 1, (size_t)label_count - 1, sizeof *numbers, by_number);
    for (int id = 0; id < label_count; id++) {
        made.to[numbers[id].id] = id;
        made.labels[id] = labels[numbers[id].id];
        made.labels[id].value = numbers[id].value;
    }
    SC_HAND_OVER(made, out);
    return SC_OK;
}

void sc_label_table_number(const sc_label *labels, const int *label_of, sc_label_table *table)
{
    size_t count = 0;

    for (size_t i = 0; i < table->count; i++) {
        if (!label_of[i])
            continue;
        table->rows[count] = table->rows[i];
        table->rows[count++].value = labels[label_of[i]].value;
    }
    table->count = count;
}
