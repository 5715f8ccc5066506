/* SPDX-License-Identifier: BSD-3-Clause */
/* The labels of several volumes that are compared: each volume gets those that only others have,
 * without voxels, so that the rules of the job mean the same tissues in all. */
#include "panels.h"

#include <stdlib.h>

/* A tissue of some subject. */
typedef struct entry {
    const sc_label *label;
    const sc_label *named; /* the first with a name, if that one has none; else NULL */
    sc_tissue_owner owner;
} entry;

/* All tissues of the subjects, each once. */
typedef struct catalog {
    entry *entries; /* [count], with room for the labels of all subjects; owned */
    const entry **by_name, **by_value; /* [indexed]: the first so many of them, sorted; owned */
    int count, indexed;
} catalog;

static void clear_catalog(catalog *c)
{
    sc_free(c->entries);
    sc_free(c->by_name);
    sc_free(c->by_value);
}

static int compare_names(const void *a, const void *b)
{
    return strcmp((*(const entry *const *)a)->label->name, (*(const entry *const *)b)->label->name);
}

static int compare_values(const void *a, const void *b)
{
    const int64_t x = (*(const entry *const *)a)->label->value;
    const int64_t y = (*(const entry *const *)b)->label->value;

    return (x > y) - (x < y);
}

/* Sort all entries that there are, by the names that they have by now. */
static void make_index(catalog *c)
{
    for (int i = 0; i < c->count; i++) {
        entry *e = &c->entries[i];

        e->label = e->named ? e->named : e->label;
        c->by_name[i] = c->by_value[i] = e;
    }
    c->indexed = c->count;
    if (c->count) {
        qsort(c->by_name, (size_t)c->count, sizeof(const entry *), compare_names);
        qsort(c->by_value, (size_t)c->count, sizeof(const entry *), compare_values);
    }
}

/* @return the index of an entry with the name of a label, or else, where one of the two has no
 * name, with its number; -1 if there is none among those that are indexed. */
static int find(const catalog *c, const sc_label *label)
{
    const entry wanted = {.label = label}, *key = &wanted, *const *found = NULL;
    const size_t count = (size_t)c->indexed;

    if (label->name[0] && count)
        found = bsearch(&key, c->by_name, count, sizeof key, compare_names);
    if (found)
        return (int)(*found - c->entries);
    found = count ? bsearch(&key, c->by_value, count, sizeof key, compare_values) : NULL;
    while (found && found > c->by_value && !compare_values(found - 1, &key))
        found--;
    for (; found && found < c->by_value + count && !compare_values(found, &key); found++) {
        if (!label->name[0] || !(*found)->label->name[0])
            return (int)(*found - c->entries);
    }
    return -1;
}

/* Add the tissues of subject @p s to those that are known. @param numbers [label_count] the index
 * of the entry of each of its labels. */
static void add_subject(const sc_prepared *v, int s, catalog *c, int *numbers)
{
    make_index(c);
    for (int id = 1; id < v->label_count; id++) {
        const int known = find(c, &v->labels[id]);
        const int at = known < 0 ? c->count++ : known;
        entry *e = &c->entries[at];

        if (known < 0)
            *e = (entry){&v->labels[id], NULL, {s, id, v->stats[id].voxels > 0}};
        else if (!e->owner.has_voxels && v->stats[id].voxels)
            e->owner = (sc_tissue_owner){s, id, true};
        if (!e->label->name[0] && !e->named && v->labels[id].name[0])
            e->named = &v->labels[id];
        numbers[id] = at;
    }
}

/* Give an array of @p count elements of @p size bytes room for @p more, zeroed. @param owned where
 * the new one is noted, to be freed. @param array the address of the pointer to it; NULL stays. */
static sc_status extend(const sc_ctx *ctx, int count, int more, size_t size, void **owned,
                        void *array)
{
    void *from;

    memcpy(&from, array, sizeof from);
    if (!from)
        return SC_OK;
    SC_PASS(sc_zalloc(ctx, (size_t)count + (size_t)more, size, owned));
    memcpy(*owned, from, (size_t)count * size);
    memcpy(array, owned, sizeof *owned);
    return SC_OK;
}

/* Give the volume of a subject the tissues that only others have, and the names of others to those
 * of its own that lack one. @param numbers [label_count] as of add_subject. */
static sc_status join(const sc_ctx *ctx, const catalog *c, const int *numbers, sc_panel *subject,
                      sc_joined *out)
{
    sc_prepared *v = &subject->volume;
    const int own = v->label_count;
    int more = c->count;
    sc_label *labels;
    sc_label_stats *stats;
    sc_tissue_owner *owners;
    SC_OWN(sc_free_at) bool *has = NULL;

    SC_PASS(SC_ZALLOC(ctx, (size_t)c->count, &has));
    for (int id = 1; id < own; id++) {
        more -= !has[numbers[id]];
        has[numbers[id]] = true;
    }
    SC_PASS(extend(ctx, own, more, sizeof *v->labels, &out->owned[0], &v->labels));
    SC_PASS(extend(ctx, own, more, sizeof *v->stats, &out->owned[1], &v->stats));
    SC_PASS(extend(ctx, own, more, sizeof *v->how.smooth, &out->owned[2], &v->how.smooth));
    SC_PASS(extend(ctx, own, more, sizeof *v->how.hidden, &out->owned[3], &v->how.hidden));
    SC_PASS(extend(ctx, own, more, sizeof *v->stored.opacity, &out->owned[4], &v->stored.opacity));
    SC_PASS(SC_ZALLOC(ctx, (size_t)own + (size_t)more, &owners));
    labels = out->owned[0];
    stats = out->owned[1];
    out->owned[5] = owners;
    for (int id = 1; id < own; id++) {
        const entry *e = &c->entries[numbers[id]];

        owners[id] = e->owner;
        if (!labels[id].name[0])
            memcpy(labels[id].name, e->label->name, sizeof labels[id].name);
    }
    for (int i = 0, id = own; i < c->count; i++) {
        if (has[i])
            continue;
        labels[id] = *c->entries[i].label;
        stats[id] = (sc_label_stats){.high = {-1, -1, -1}};
        owners[id++] = c->entries[i].owner;
    }
    out->added = more;
    v->label_count = own + more;
    subject->group.owners = owners;
    return SC_OK;
}

sc_status sc_join_labels(const sc_ctx *ctx, sc_panel *subjects, int count, sc_joined *out)
{
    SC_OWN(clear_catalog) catalog c = {0};
    SC_OWN(sc_free_at) int *numbers = NULL;
    size_t all = 0, at = 0;

    for (int s = 0; s < count; s++)
        all += (size_t)subjects[s].volume.label_count;
    SC_PASS(SC_ZALLOC(ctx, all, &numbers)); /* of all labels of all subjects */
    SC_PASS(SC_ALLOC(ctx, all, &c.entries));
    SC_PASS(SC_ALLOC(ctx, all, &c.by_name));
    SC_PASS(SC_ALLOC(ctx, all, &c.by_value));
    for (int s = 0; s < count; s++) {
        add_subject(&subjects[s].volume, s, &c, numbers + at);
        at += (size_t)subjects[s].volume.label_count;
    }
    make_index(&c); /* with the names that the last one has given */
    at = 0;
    for (int s = 0; s < count; s++) {
        const size_t own = (size_t)subjects[s].volume.label_count; /* before others join */

        SC_PASS(join(ctx, &c, numbers + at, &subjects[s], &out[s]));
        at += own;
    }
    return SC_OK;
}

void sc_joined_clear(sc_joined *joined)
{
    for (size_t i = 0; i < SC_COUNT_OF(joined->owned); i++)
        sc_free(joined->owned[i]);
    *joined = (sc_joined){0};
}
