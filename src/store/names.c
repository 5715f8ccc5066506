/* SPDX-License-Identifier: BSD-3-Clause */
/* Short sorted lists: names, and the lines of files. */
#include "internal.h"

#include <stdlib.h>
#include <string.h>

/* Make room for one more element of @p size bytes at *array, which has *capacity of them and uses
 * @p count. @return SC_ERR_MEMORY, with nothing changed. */
static sc_status grow(const sc_ctx *ctx, void **array, int count, int *capacity, size_t size)
{
    const int larger = *capacity ? 2 * *capacity : 16;
    void *block;
    sc_status status;

    if (count < *capacity)
        return SC_OK;
    status = sc_alloc(ctx, (size_t)larger, size, &block);
    if (status != SC_OK)
        return status;
    if (count)
        memcpy(block, *array, (size_t)count * size);
    sc_free(*array);
    *array = block;
    *capacity = larger;
    return SC_OK;
}

/* @return where @p name stands in the sorted list, or has to be inserted; *found says which. */
static int place_of(const sc_names *names, const char *name, bool *found)
{
    int at = 0, order = 1;

    while (at < names->count && (order = strcmp(names->names[at], name)) < 0)
        at++;
    *found = at < names->count && order == 0;
    return at;
}

sc_status sc_names_add(const sc_ctx *ctx, sc_names *names, const char *name)
{
    sc_text copy = {0};
    void *array = names->names;
    bool found;
    const int at = place_of(names, name, &found);
    sc_status status = SC_OK;

    if (found)
        return SC_OK;
    SC_TRY(grow(ctx, &array, names->count, &names->capacity, sizeof *names->names));
    names->names = array;
    SC_TRY(sc_text_add(ctx, &copy, "%s", name));
    memmove(names->names + at + 1, names->names + at,
            (size_t)(names->count - at) * sizeof *names->names);
    names->names[at] = copy.data;
    names->count++;
out:
    return status;
}

bool sc_names_has(const sc_names *names, const char *name)
{
    bool found;

    place_of(names, name, &found);
    return found;
}

void sc_names_remove(sc_names *names, const char *name)
{
    bool found;
    const int at = place_of(names, name, &found);

    if (!found)
        return;
    sc_free(names->names[at]);
    names->count--;
    memmove(names->names + at, names->names + at + 1,
            (size_t)(names->count - at) * sizeof *names->names);
}

void sc_names_clear(sc_names *names)
{
    for (int i = 0; i < names->count; i++)
        sc_free(names->names[i]);
    sc_free(names->names);
    *names = (sc_names){0};
}

/* @return where the line of file @p name stands, or has to be inserted; *found says which. */
static int line_of(const sc_file_lines *files, const char *name, bool *found)
{
    int at = 0, order = 1;

    while (at < files->count && (order = strcmp(files->lines[at].name, name)) < 0)
        at++;
    *found = at < files->count && order == 0;
    return at;
}

sc_status sc_file_lines_put(const sc_ctx *ctx, sc_file_lines *files, const char *name,
                            uint64_t bytes, uint64_t hash)
{
    sc_text copy = {0};
    void *array = files->lines;
    bool found;
    const int at = line_of(files, name, &found);
    sc_status status = SC_OK;

    if (!found) {
        SC_TRY(grow(ctx, &array, files->count, &files->capacity, sizeof *files->lines));
        files->lines = array;
        SC_TRY(sc_text_add(ctx, &copy, "%s", name));
        memmove(files->lines + at + 1, files->lines + at,
                (size_t)(files->count - at) * sizeof *files->lines);
        files->lines[at].name = copy.data;
        files->count++;
    }
    files->lines[at].bytes = bytes;
    files->lines[at].hash = hash;
out:
    return status;
}

void sc_file_lines_remove(sc_file_lines *files, const char *name)
{
    bool found;
    const int at = line_of(files, name, &found);

    if (!found)
        return;
    sc_free(files->lines[at].name);
    files->count--;
    memmove(files->lines + at, files->lines + at + 1,
            (size_t)(files->count - at) * sizeof *files->lines);
}

void sc_file_lines_clear(sc_file_lines *files)
{
    for (int i = 0; i < files->count; i++)
        sc_free(files->lines[i].name);
    sc_free(files->lines);
    *files = (sc_file_lines){0};
}
