/* SPDX-License-Identifier: BSD-3-Clause */
/* Loading libav: once, when the first video is written, read or asked about. */
#include "libav.h"

#include <dlfcn.h>
#include <errno.h>
#include <pthread.h>

#pragma weak sc_libav_functions
#pragma weak sc_libavfilter_functions

const sc_libav *sc_av;
const sc_libavfilter *sc_filters;

enum { PATH_BYTES = 4096, REASON_BYTES = 1024 };
/* How loading went. Libraries are loaded for a process, not for a part of it, so that this, sc_av
 * and sc_filters are its own, too; nothing of it changes once they are. */
static struct {
    pthread_once_t once, filters_once;
    char reason[REASON_BYTES]; /* why libav could not be loaded */
    bool no_memory;
} loading = {PTHREAD_ONCE_INIT, PTHREAD_ONCE_INIT, "", false};

/* Load a file of segcast. @return its table @p symbol, or NULL, and dlerror says why. */
static const void *load_file(const char *name, const char *symbol)
{
    char path[PATH_BYTES];
    void *file;

    sc_program_find(name, path, sizeof path);
    errno = 0;
    file = dlopen(path, RTLD_LAZY | RTLD_LOCAL); /* stays loaded to the end of the process */
    return file ? dlsym(file, symbol) : NULL;
}

static void load(void)
{
    const sc_libav *functions = &sc_libav_functions;

    if (!functions) {
        functions = load_file(SC_LIBAV_FILE, "sc_libav_functions");
        if (!functions) {
            const char *error;

            loading.no_memory = errno == ENOMEM;
            error = dlerror();
            snprintf(loading.reason, sizeof loading.reason, "%s", error ? error : "unknown reason");
        }
    }
    if (functions &&
        (functions->bytes != sizeof *functions || functions->av != LIBAVFORMAT_VERSION_INT ||
         functions->av_codec != LIBAVCODEC_VERSION_INT)) {
        snprintf(loading.reason, sizeof loading.reason, "%s belongs to another build of segcast",
                 SC_LIBAV_FILE);
        functions = NULL;
    }
    sc_av = functions;
    if (functions)
        functions->av_log_set_level(AV_LOG_FATAL); /* whoever calls libav says what is wrong */
}

bool sc_libav_is_here(void)
{
    return pthread_once(&loading.once, load) == 0 && sc_av;
}

sc_status sc_libav_load(const sc_ctx *ctx, const char *path)
{
    if (sc_libav_is_here())
        return SC_OK;
    if (loading.no_memory)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", path);
    return sc_fail(ctx, SC_ERR_CREATE,
                   "%s: %s, by which segcast writes and reads videos, cannot be loaded: %s; "
                   "install segcast anew, or choose video: none with frames: png",
                   path, SC_LIBAV_FILE, loading.reason);
}

static void load_filters(void)
{
    const sc_libavfilter *functions = &sc_libavfilter_functions;

    if (!functions)
        functions = load_file("segcast-libavfilter.so", "sc_libavfilter_functions");
    if (functions && functions->bytes == sizeof *functions &&
        functions->av == LIBAVFILTER_VERSION_INT)
        sc_filters = functions;
}

bool sc_libavfilter_is_here(void)
{
    return pthread_once(&loading.filters_once, load_filters) == 0 && sc_filters;
}
