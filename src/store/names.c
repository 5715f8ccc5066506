/* SPDX-License-Identifier: BSD-3-Clause */
/* Lists without repetitions: names, and the lines of files. */
#include "internal.h"

#include <jansson.h>
#include <stdlib.h>

/* @return the number of the line with this name, or -1. The index keeps the time to read a list
 * from growing with the square of its length; its hashes are random, so that whoever forges a
 * manifest cannot choose names that take long. */
static int find(const sc_file_lines *l, const char *name)
{
    const json_t *at = json_object_get(l->index, name);

    return at ? (int)json_integer_value(at) : -1;
}

/* Note that the line of that name, which is in the index, stands at @p at. */
static void set_place(sc_file_lines *l, const char *name, int at)
{
    (void)json_integer_set(json_object_get(l->index, name), at);
}

/* Make room for one more line. @return SC_ERR_MEMORY, with nothing changed but, perhaps, more room.
 */
static sc_status grow(const sc_ctx *ctx, sc_file_lines *l)
{
    const int larger = l->capacity ? 2 * l->capacity : 16;

    if (!l->index)
        l->index = json_object();
    if (l->count < l->capacity)
        return SC_OK;
    SC_PASS(SC_RESIZE(ctx, (size_t)l->count, (size_t)larger, &l->lines));
    l->capacity = larger;
    return SC_OK;
}

sc_status sc_file_lines_put(const sc_ctx *ctx, sc_file_lines *files, const char *name,
                            uint64_t bytes, uint64_t hash)
{
    int at = find(files, name);
    char *copy;

    if (at < 0) {
        SC_PASS(grow(ctx, files));
        SC_PASS(sc_text_copy(ctx, name, &copy));
        at = files->count;
        if (json_object_set_new_nocheck(files->index, name, json_integer(at))) {
            sc_free(copy);
            return sc_fail(ctx, SC_ERR_MEMORY, "out of memory for the names of files");
        }
        files->lines[files->count++].name = copy;
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
    set_place(files, files->lines[last].name, at);
    files->lines[at] = files->lines[last];
    files->count--;
    (void)json_object_del(files->index, removed);
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
    for (int i = 0; i < files->count; i++)
        set_place(files, files->lines[i].name, i);
}

void sc_file_lines_clear(sc_file_lines *files)
{
    for (int i = 0; i < files->count; i++)
        sc_free(files->lines[i].name);
    sc_free(files->lines);
    json_decref(files->index);
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
