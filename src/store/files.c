/* SPDX-License-Identifier: BSD-3-Clause */
/* The names of the files in the directory of a job. */
#include "internal.h"

#include <dirent.h>
#include <errno.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

void sc_store_path(const sc_store *store, char out[2 * SC_NAME_BYTES], const char *fmt, ...)
{
    const int used = snprintf(out, 2 * SC_NAME_BYTES, "%s/", store->directory);
    va_list args;

    va_start(args, fmt);
    vsnprintf(out + used, (size_t)(2 * SC_NAME_BYTES - used), fmt, args);
    va_end(args);
}

void sc_store_manifest_path(const sc_store *store, char out[2 * SC_NAME_BYTES])
{
    if (store->slice)
        sc_store_path(store, out, "manifest.%s.jsonl", store->slice);
    else
        sc_store_path(store, out, "manifest.jsonl");
}

bool sc_is_manifest_name(const char *name)
{
    const size_t length = strlen(name);

    return !strcmp(name, "manifest.jsonl") ||
           (length > 15 && !strncmp(name, "manifest.", 9) && !strcmp(name + length - 6, ".jsonl"));
}

sc_status sc_each_file(const sc_ctx *ctx, const char *directory, void *user, sc_each_file_fn *each)
{
    struct dirent **names;
    const int count = scandir(directory, &names, NULL, alphasort);
    sc_status status = SC_OK;

    if (count < 0 && errno != ENOENT && errno != ENOTDIR)
        return sc_fail(ctx, SC_ERR_MISSING, "%s: cannot be listed: %s", directory, strerror(errno));
    for (int i = 0; i < count; i++) {
        if (status == SC_OK && names[i]->d_name[0] != '.')
            status = each(ctx, user, names[i]->d_name);
        free(names[i]);
    }
    if (count >= 0)
        free(names);
    return status;
}
