/* SPDX-License-Identifier: BSD-3-Clause */
#include "segcast/base.h"

#include <math.h>

sc_length_unit sc_length_unit_for(double finest_mm)
{
    static const sc_length_unit units[] = {{"mm", 1}, {"um", 1e-3}, {"nm", 1e-6}};
    size_t i = 0;

    /* Slightly less than a tenth, so that a rounded 0.1 mm is still one. */
    while (i + 1 < SC_COUNT_OF(units) && finest_mm > 0 && finest_mm < 0.0999 * units[i].mm)
        i++;
    return units[i];
}

double sc_round_length_mm(double most_mm)
{
    const double decade = pow(10, floor(log10(most_mm)));

    if (!(most_mm > 0))
        return 0;
    return most_mm >= 5 * decade ? 5 * decade : most_mm >= 2 * decade ? 2 * decade : decade;
}

double sc_no_negative_zero(double value, int decimals)
{
    double least = 0.5; /* half of the last digit: what is less is rounded to zero */

    for (int i = 0; i < decimals; i++)
        least /= 10;
    return -least < value && value < least ? 0 : value;
}

const char *sc_size_text(double bytes, char text[24])
{
    static const char *const units[] = {"KiB", "MiB", "GiB"};
    double value = bytes / 1024;
    size_t unit = 0;

    while (value >= 1024 && unit + 1 < SC_COUNT_OF(units)) {
        value /= 1024;
        unit++;
    }
    snprintf(text, 24, "%.*f %s", value < 10 ? 2 : value < 100 ? 1 : 0, value, units[unit]);
    return text;
}
