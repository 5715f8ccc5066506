/* SPDX-License-Identifier: BSD-3-Clause */
/* What the kernel counts of memory and energy. */
#include "segcast/base.h"

#include <stdlib.h>

void sc_peak_rss_restart(void)
{
    FILE *file = fopen("/proc/self/clear_refs", "w");

    if (file) {
        (void)fputs("5", file); /* see proc(5): reset the peak, where that is allowed */
        fclose(file);
    }
}

uint64_t sc_peak_rss_since(void)
{
    static const char key[] = "VmHWM:";
    FILE *file = fopen("/proc/self/status", "r");
    uint64_t kib = 0;
    char line[256];

    while (file && kib == 0 && fgets(line, sizeof line, file)) {
        if (!strncmp(line, key, sizeof key - 1))
            kib = strtoull(line + sizeof key - 1, NULL, 10);
    }
    if (file)
        fclose(file);
    return kib ? 1024 * kib : sc_peak_rss();
}

double sc_energy_j(void)
{
    double sum_j = 0;
    int packages = 0;

    for (;; packages++) {
        unsigned long long microjoules;
        char path[96];
        FILE *file;
        bool ok;

        snprintf(path, sizeof path, "/sys/class/powercap/intel-rapl:%d/energy_uj", packages);
        file = fopen(path, "r");
        ok = file && fscanf(file, "%llu", &microjoules) == 1;
        if (file)
            fclose(file);
        if (!ok)
            break;
        sum_j += (double)microjoules * 1e-6;
    }
    return packages ? sum_j : -1;
}
