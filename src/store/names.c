/* SPDX-License-Identifier: BSD-3-Clause */
/* Lists without repetitions: names, and the lines of files. */
#include "internal.h"

#include <stdlib.h>
#include <string.h>

/* A list of either kind: elements of @p size bytes each. The name, a text that the list owns, is
 * the first member of each. An open-addressing hash table finds elements by their name, so that the
 * time to read a list grows with its length and not with the square of it. Whoever forges a
 * manifest cannot choose names that share a slot, since the seed of the hash is random. */
typedef struct list {
    void *elements; /* [capacity], the first `count` are used; owned */
    int count, capacity;
    sc_name_slots slots;
    size_t size; /* of an element, in bytes */
} list;

static list list_of_names(const sc_names *names)
{
    return (list){names->names, names->count, names->capacity, names->slots, sizeof *names->names};
}

static list list_of_lines(const sc_file_lines *files)
{
    return (list){files->lines, files->count, files->capacity, files->slots, sizeof *files->lines};
}

/* Put a changed list back into the struct that it came from. */
static void store_names(const list *l, sc_names *names)
{
    *names = (sc_names){l->elements, l->count, l->capacity, l->slots};
}

static void store_lines(const list *l, sc_file_lines *files)
{
    *files = (sc_file_lines){l->elements, l->count, l->capacity, l->slots};
}

/* @return the element number @p at. */
static char *element(const list *l, int at)
{
    return (char *)l->elements + (size_t)at * l->size;
}

/* @return the name of the element number @p at. */
static char *name_of(const list *l, int at)
{
    char *name;

    memcpy(&name, element(l, at), sizeof name);
    return name;
}

/* @return the number of the slot where the search for @p name begins. The list has slots. */
static size_t first_slot(const list *l, const char *name)
{
    return sc_hash_bytes(name, strlen(name), l->slots.seed) & (l->slots.count - 1);
}

/* @return the number of the slot that follows @p slot in a search. */
static size_t next_slot(const list *l, size_t slot)
{
    return (slot + 1) & (l->slots.count - 1);
}

/* @return the number of the slot that holds @p name, or of the free one where it belongs. The list
 * has slots. */
static size_t slot_of(const list *l, const char *name)
{
    size_t slot = first_slot(l, name);

    while (l->slots.at[slot] && strcmp(name_of(l, l->slots.at[slot] - 1), name) != 0)
        slot = next_slot(l, slot);
    return slot;
}

/* @return the number of the element with this name, or -1. */
static int find(const list *l, const char *name)
{
    return l->slots.at ? l->slots.at[slot_of(l, name)] - 1 : -1;
}

/* Fill the slots anew, after elements were moved. */
static void fill_slots(list *l)
{
    if (!l->slots.at)
        return;
    memset(l->slots.at, 0, l->slots.count * sizeof *l->slots.at);
    for (int i = 0; i < l->count; i++)
        l->slots.at[slot_of(l, name_of(l, i))] = i + 1;
}

/* Make room for one more element, and twice as many slots as elements. @return SC_ERR_MEMORY, with
 * nothing changed. */
static sc_status grow(const sc_ctx *ctx, list *l)
{
    const int larger = l->capacity ? 2 * l->capacity : 16; /* a power of two */
    void *block = NULL, *slots = NULL;
    sc_status status = SC_OK;

    if (l->count < l->capacity)
        return SC_OK;
    SC_TRY(sc_alloc(ctx, (size_t)larger, l->size, &block));
    SC_TRY(sc_alloc(ctx, 2 * (size_t)larger, sizeof *l->slots.at, &slots));
    if (l->count)
        memcpy(block, l->elements, (size_t)l->count * l->size);
    sc_free(l->elements);
    sc_free(l->slots.at);
    l->elements = block;
    l->capacity = larger;
    l->slots = (sc_name_slots){slots, 2 * (size_t)larger, sc_hash_seed()};
    fill_slots(l);
    return SC_OK;
out:
    sc_free(block);
    return status;
}

/* Append an element with a copy of @p name, unless there is one. *at receives its number; the other
 * members of a new one are zero. @return SC_ERR_MEMORY, with the list as it was. */
static sc_status put(const sc_ctx *ctx, list *l, const char *name, int *at)
{
    sc_text copy = {0};
    sc_status status;

    *at = find(l, name);
    if (*at >= 0)
        return SC_OK;
    SC_TRY(grow(ctx, l));
    SC_TRY(sc_text_add(ctx, &copy, "%s", name));
    *at = l->count++;
    memset(element(l, *at), 0, l->size);
    memcpy(element(l, *at), &copy.data, sizeof copy.data);
    l->slots.at[slot_of(l, name)] = *at + 1;
out:
    return status;
}

/* Free a slot. Those behind it that were put there because it was taken move up: a search ends at
 * the first free slot. */
static void free_slot(list *l, size_t slot)
{
    size_t hole = slot;

    for (size_t s = next_slot(l, slot); l->slots.at[s]; s = next_slot(l, s)) {
        const size_t home = first_slot(l, name_of(l, l->slots.at[s] - 1));
        const size_t mask = l->slots.count - 1;

        if (((s - home) & mask) < ((s - hole) & mask))
            continue; /* its search begins behind the hole */
        l->slots.at[hole] = l->slots.at[s];
        hole = s;
    }
    l->slots.at[hole] = 0;
}

/* Remove the element with this name, if there is one. The last element takes its place. */
static void take_out(list *l, const char *name)
{
    const int at = find(l, name), last = l->count - 1;
    char *removed;

    if (at < 0)
        return;
    removed = name_of(l, at);
    free_slot(l, slot_of(l, name));
    if (at < last) {
        l->slots.at[slot_of(l, name_of(l, last))] = at + 1;
        memcpy(element(l, at), element(l, last), l->size);
    }
    l->count--;
    sc_free(removed);
}

/* For qsort: the order of the names with which two elements begin. */
static int compare(const void *a, const void *b)
{
    char *names[2];

    memcpy(&names[0], a, sizeof names[0]);
    memcpy(&names[1], b, sizeof names[1]);
    return strcmp(names[0], names[1]);
}

/* Put the elements into the order of strcmp of their names. */
static void sort(list *l)
{
    if (l->count > 1)
        qsort(l->elements, (size_t)l->count, l->size, compare);
    fill_slots(l);
}

/* Free everything that the list owns. */
static void free_list(const list *l)
{
    for (int i = 0; i < l->count; i++)
        sc_free(name_of(l, i));
    sc_free(l->elements);
    sc_free(l->slots.at);
}

sc_status sc_names_add(const sc_ctx *ctx, sc_names *names, const char *name)
{
    list l = list_of_names(names);
    int at;
    sc_status status = put(ctx, &l, name, &at);

    store_names(&l, names);
    return status;
}

bool sc_names_has(const sc_names *names, const char *name)
{
    const list l = list_of_names(names);

    return find(&l, name) >= 0;
}

void sc_names_remove(sc_names *names, const char *name)
{
    list l = list_of_names(names);

    take_out(&l, name);
    store_names(&l, names);
}

void sc_names_sort(sc_names *names)
{
    list l = list_of_names(names);

    sort(&l);
}

void sc_names_clear(sc_names *names)
{
    const list l = list_of_names(names);

    free_list(&l);
    *names = (sc_names){0};
}

sc_status sc_file_lines_put(const sc_ctx *ctx, sc_file_lines *files, const char *name,
                            uint64_t bytes, uint64_t hash)
{
    list l = list_of_lines(files);
    int at;
    sc_status status = put(ctx, &l, name, &at);

    store_lines(&l, files);
    if (status == SC_OK) {
        files->lines[at].bytes = bytes;
        files->lines[at].hash = hash;
    }
    return status;
}

void sc_file_lines_remove(sc_file_lines *files, const char *name)
{
    list l = list_of_lines(files);

    take_out(&l, name);
    store_lines(&l, files);
}

void sc_file_lines_sort(sc_file_lines *files)
{
    list l = list_of_lines(files);

    sort(&l);
}

void sc_file_lines_clear(sc_file_lines *files)
{
    const list l = list_of_lines(files);

    free_list(&l);
    *files = (sc_file_lines){0};
}

/* Write the name of a text among others into @p out. */
static void name_text(uint64_t hash, char out[17])
{
    snprintf(out, 17, "%016llx", (unsigned long long)hash);
}

sc_status sc_job_texts_put(const sc_ctx *ctx, sc_job_texts *jobs, uint64_t bytes, uint64_t hash)
{
    char name[17];

    name_text(hash, name);
    return sc_file_lines_put(ctx, jobs, name, bytes, hash);
}

bool sc_job_texts_have(const sc_job_texts *jobs, uint64_t bytes, uint64_t hash)
{
    const list l = list_of_lines(jobs);
    char name[17];
    int at;

    name_text(hash, name);
    at = find(&l, name);
    return at >= 0 && jobs->lines[at].bytes == bytes;
}
