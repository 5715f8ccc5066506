/* SPDX-License-Identifier: BSD-3-Clause */
/* Lists without repetitions: names, and the lines of files. */
#include "internal.h"

#include <stdlib.h>

/* An open-addressing hash table finds lines by their name, so that the time to read a list grows
 * with its length and not with the square of it. Whoever forges a manifest cannot choose names that
 * share a slot, since the seed of the hash is random.
 *
 * @return the number of the slot where the search for @p name begins. The list has slots. */
static size_t first_slot(const sc_file_lines *l, const char *name)
{
    return sc_hash_bytes(name, strlen(name), l->slots.seed) & (l->slots.count - 1);
}

/* @return the number of the slot that follows @p slot in a search. */
static size_t next_slot(const sc_file_lines *l, size_t slot)
{
    return (slot + 1) & (l->slots.count - 1);
}

/* @return the number of the slot that holds @p name, or of the free one where it belongs. The list
 * has slots. */
static size_t slot_of(const sc_file_lines *l, const char *name)
{
    size_t slot = first_slot(l, name);

    while (l->slots.at[slot] && strcmp(l->lines[l->slots.at[slot] - 1].name, name) != 0)
        slot = next_slot(l, slot);
    return slot;
}

/* @return the number of the line with this name, or -1. */
static int find(const sc_file_lines *l, const char *name)
{
    return l->slots.at ? l->slots.at[slot_of(l, name)] - 1 : -1;
}

/* Fill the slots anew, after lines were moved. */
static void fill_slots(sc_file_lines *l)
{
    if (!l->slots.at)
        return;
    memset(l->slots.at, 0, l->slots.count * sizeof *l->slots.at);
    for (int i = 0; i < l->count; i++)
        l->slots.at[slot_of(l, l->lines[i].name)] = i + 1;
}

/* Make room for one more line, and twice as many slots as lines. @return SC_ERR_MEMORY, with
 * nothing changed but, perhaps, more room. */
static sc_status grow(const sc_ctx *ctx, sc_file_lines *l)
{
    const int larger = l->capacity ? 2 * l->capacity : 16; /* a power of two */
    int *slots;

    if (l->count < l->capacity)
        return SC_OK;
    SC_PASS(SC_RESIZE(ctx, (size_t)l->count, (size_t)larger, &l->lines));
    SC_PASS(SC_ALLOC(ctx, 2 * (size_t)larger, &slots));
    sc_free(l->slots.at);
    l->capacity = larger;
    l->slots = (sc_name_slots){slots, 2 * (size_t)larger, sc_hash_seed()};
    fill_slots(l);
    return SC_OK;
}

/* Free a slot. Those behind it that were put there because it was taken move up: a search ends at
 * the first free slot. */
static void free_slot(sc_file_lines *l, size_t slot)
{
    size_t hole = slot;

    for (size_t s = next_slot(l, slot); l->slots.at[s]; s = next_slot(l, s)) {
        const size_t home = first_slot(l, l->lines[l->slots.at[s] - 1].name);
        const size_t mask = l->slots.count - 1;

        if (((s - home) & mask) < ((s - hole) & mask))
            continue; /* its search begins behind the hole */
        l->slots.at[hole] = l->slots.at[s];
        hole = s;
    }
    l->slots.at[hole] = 0;
}

sc_status sc_file_lines_put(const sc_ctx *ctx, sc_file_lines *files, const char *name,
                            uint64_t bytes, uint64_t hash)
{
    int at = find(files, name);
    char *copy;

    if (at < 0) {
        SC_PASS(grow(ctx, files));
        SC_PASS(sc_text_copy(ctx, name, &copy));
        at = files->count++;
        files->lines[at].name = copy;
        files->slots.at[slot_of(files, name)] = at + 1;
    }
    files->lines[at].bytes = bytes;
    files->lines[at].hash = hash;
    return SC_OK;
}

bool sc_file_lines_has(const sc_file_lines *files, const char *name)
{
    return find(files, name) >= 0;
}

void sc_file_lines_remove(sc_file_lines *files, const char *name)
{
    const int at = find(files, name), last = files->count - 1;
    char *removed;

    if (at < 0)
        return;
    removed = files->lines[at].name;
    free_slot(files, slot_of(files, name));
    if (at < last) {
        files->slots.at[slot_of(files, files->lines[last].name)] = at + 1;
        files->lines[at] = files->lines[last];
    }
    files->count--;
    sc_free(removed);
}

/* For qsort. */
static int compare(const void *a, const void *b)
{
    return strcmp(((const sc_file_line *)a)->name, ((const sc_file_line *)b)->name);
}

void sc_file_lines_sort(sc_file_lines *files)
{
    if (files->count > 1)
        qsort(files->lines, (size_t)files->count, sizeof *files->lines, compare);
    fill_slots(files);
}

void sc_file_lines_clear(sc_file_lines *files)
{
    for (int i = 0; i < files->count; i++)
        sc_free(files->lines[i].name);
    sc_free(files->lines);
    sc_free(files->slots.at);
    *files = (sc_file_lines){0};
}

sc_status sc_names_add(const sc_ctx *ctx, sc_names *names, const char *name)
{
    return sc_file_lines_put(ctx, names, name, 0, 0);
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
    char name[17];
    int at;

    name_text(hash, name);
    at = find(jobs, name);
    return at >= 0 && jobs->lines[at].bytes == bytes;
}
