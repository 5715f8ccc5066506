/* SPDX-License-Identifier: BSD-3-Clause */
/* What the machine has, as far as this process may use it. */
#define _GNU_SOURCE /* sched_getaffinity */
#include "segcast/base.h"

#include <sched.h>
#include <sys/statvfs.h>
#include <unistd.h>

sc_core_set sc_core_set_of_process(void)
{
    sc_core_set out = {{0}};
#ifdef __linux__
    cpu_set_t set;

    if (sched_getaffinity(0, sizeof set, &set) == 0) {
        for (int i = 0; i < 64 * SC_CORE_WORDS && i < CPU_SETSIZE; i++) {
            if (CPU_ISSET(i, &set))
                out.words[i / 64] |= (uint64_t)1 << (i % 64);
        }
        return out;
    }
#endif
    for (int i = 0; i < sc_usable_cores() && i < 64 * SC_CORE_WORDS; i++)
        out.words[i / 64] |= (uint64_t)1 << (i % 64);
    return out;
}

/* The number in a file, or @p otherwise if it holds none. */
static uint64_t number_in(const char *path, uint64_t otherwise)
{
    FILE *stream = fopen(path, "r");
    unsigned long long value;
    const bool ok = stream && fscanf(stream, "%llu", &value) == 1;

    if (stream)
        fclose(stream);
    return ok ? value : otherwise;
}

uint64_t sc_machine_memory(void)
{
    const uint64_t pages = (uint64_t)sysconf(_SC_PHYS_PAGES);
    uint64_t bytes = pages * (uint64_t)sysconf(_SC_PAGESIZE), limit;

    limit = number_in("/sys/fs/cgroup/memory.max", bytes);
    limit = number_in("/sys/fs/cgroup/memory/memory.limit_in_bytes", limit);
    return limit < bytes ? limit : bytes;
}

uint64_t sc_machine_shared_room(void)
{
    struct statvfs info;

    if (statvfs("/dev/shm", &info))
        return UINT64_MAX;
    return (uint64_t)info.f_bavail * info.f_frsize;
}
