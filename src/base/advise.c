/* SPDX-License-Identifier: BSD-3-Clause */
#define _DEFAULT_SOURCE /* madvise: posix_madvise ignores that memory is not needed */
#include "segcast/base.h"

#include <sys/mman.h>

void sc_file_advise(const void *data, size_t bytes, sc_memory_use use)
{
    const int advice = use == SC_MEMORY_NEEDED_SOON ? MADV_WILLNEED : MADV_DONTNEED;

    if (data) /* should it fail, memory is used for longer, or the file is read later */
        (void)madvise((void *)(uintptr_t)data, bytes, advice);
}
