/* SPDX-License-Identifier: BSD-3-Clause */
/* The files that belong to the installed program. */
#include "segcast/base.h"

#include <unistd.h>

void sc_program_find(const char *name, char *path, size_t bytes)
{
    static const char *const places[] = {"", SC_PROGRAMS_FROM_BIN "/"};
    char self[4096];
    const ssize_t length = readlink("/proc/self/exe", self, sizeof self - 1);
    const char *slash;

    self[length > 0 ? length : 0] = '\0';
    slash = strrchr(self, '/');
    for (size_t i = 0; i < SC_COUNT_OF(places) && slash; i++) {
        const int used =
            snprintf(path, bytes, "%.*s%s%s", (int)(slash + 1 - self), self, places[i], name);

        if (used >= 0 && (size_t)used < bytes && access(path, F_OK) == 0)
            return;
    }
    snprintf(path, bytes, "%s/%s", SC_PROGRAMS_INSTALLED, name);
}
