/* SPDX-License-Identifier: BSD-3-Clause */
/* Short sorted lists: names, and the lines of files. */
#include "internal.h"

#include <string.h>

/* A list of either kind: elements of @p size bytes each, in the order of strcmp of their names. The
 * name, a text that the list owns, is the first member of each. */
typedef struct list {
    void *elements; /* [capacity], the first `count` are used; owned */
    int count, capacity;
    size_t size; /* of an element, in bytes */
} list;

static list list_of_names(const sc_names *names)
{
    return (list){names->names, names->count, names->capacity, sizeof *names->names};
}

static list list_of_lines(const sc_file_lines *files)
{
    return (list){files->lines, files->count, files->capacity, sizeof *files->lines};
}

/* Put a changed list back into the struct that it came from. */
static void store_names(const list *l, sc_names *names)
{
    *names = (sc_names){l->elements, l->count, l->capacity};
}

static void store_lines(const list *l, sc_file_lines *files)
{
    *files = (sc_file_lines){l->elements, l->count, l->capacity};
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

/* @return where @p name stands in the list, or has to be inserted; *found says which. */
static int place_of(const list *l, const char *name, bool *found)
{
    int low = 0, high = l->count;

    *found = false;
    while (low < high) {
        const int middle = low + (high - low) / 2;
        const int order = strcmp(name_of(l, middle), name);

        if (order == 0) {
            *found = true;
            return middle;
        }
        if (order < 0)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* Make room for one more element. @return SC_ERR_MEMORY, with nothing changed. */
static sc_status grow(const sc_ctx *ctx, list *l)
{
    const int larger = l->capacity ? 2 * l->capacity : 16;
    void *block;
    sc_status status;

    if (l->count < l->capacity)
        return SC_OK;
    status = sc_alloc(ctx, (size_t)larger, l->size, &block);
    if (status != SC_OK)
        return status;
    if (l->count)
        memcpy(block, l->elements, (size_t)l->count * l->size);
    sc_free(l->elements);
    l->elements = block;
    l->capacity = larger;
    return SC_OK;
}

/* Insert an element with a copy of @p name, unless there is one. *at receives its place; the other
 * members of a new one are zero. @return SC_ERR_MEMORY, with the list as it was. */
static sc_status put(const sc_ctx *ctx, list *l, const char *name, int *at)
{
    sc_text copy = {0};
    bool found;
    sc_status status;

    *at = place_of(l, name, &found);
    if (found)
        return SC_OK;
    SC_TRY(grow(ctx, l));
    SC_TRY(sc_text_add(ctx, &copy, "%s", name));
    memmove(element(l, *at + 1), element(l, *at), (size_t)(l->count - *at) * l->size);
    memset(element(l, *at), 0, l->size);
    memcpy(element(l, *at), &copy.data, sizeof copy.data);
    l->count++;
out:
    return status;
}

/* Remove the element with this name, if there is one. */
static void take_out(list *l, const char *name)
{
    bool found;
    const int at = place_of(l, name, &found);

    if (!found)
        return;
    sc_free(name_of(l, at));
    l->count--;
    memmove(element(l, at), element(l, at + 1), (size_t)(l->count - at) * l->size);
}

/* Free everything that the list owns. */
static void free_list(const list *l)
{
    for (int i = 0; i < l->count; i++)
        sc_free(name_of(l, i));
    sc_free(l->elements);
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
    bool found;

    place_of(&l, name, &found);
    return found;
}

void sc_names_remove(sc_names *names, const char *name)
{
    list l = list_of_names(names);

    take_out(&l, name);
    store_names(&l, names);
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

void sc_file_lines_clear(sc_file_lines *files)
{
    const list l = list_of_lines(files);

    free_list(&l);
    *files = (sc_file_lines){0};
}
