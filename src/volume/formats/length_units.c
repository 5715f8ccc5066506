/* SPDX-License-Identifier: BSD-3-Clause */
/* Units of length as OME-XML, OME-Zarr, ImageJ, ITK and users of NRRD name them, also in the
 * plural. Sources: the enumeration UnitsLength of the OME data model (2016-06); the units of
 * UDUNITS-2 that OME-Zarr 0.4 lists for axes of space; ImageJ's ij/measure/Calibration.java. */
#include "source.h"

typedef struct unit {
    const char *name;
    double value; /* in mm, or in s */
} unit;

/* @return the value of a unit, also in the plural; 0 if none is called so. */
static double find(const unit *units, size_t count, const char *name)
{
    const size_t length = strlen(name);
    const size_t singular = length > 4 && name[length - 1] == 's' ? length - 1 : length;

    for (size_t i = 0; i < count; i++) {
        if (strlen(units[i].name) == singular && !memcmp(name, units[i].name, singular))
            return units[i].value;
    }
    return 0;
}

double sc_time_unit_s(const char *name)
{
    static const unit units[] = {{"s", 1},       {"sec", 1},
                                 {"second", 1},  {"ms", 1e-3},
                                 {"msec", 1e-3}, {"millisecond", 1e-3},
                                 {"minute", 60}, {"microsecond", 1e-6},
                                 {"hour", 3600}, {"day", 86400}};

    return find(units, SC_COUNT_OF(units), name);
}

double sc_length_unit_mm(const char *name)
{
    static const unit units[] = {{"mm", 1},           {"millimeter", 1},    {"millimetre", 1},
                                 {"um", 1e-3},        {"\xc2\xb5m", 1e-3}, /* U+00B5, micro sign */
                                 {"\xce\xbcm", 1e-3},                      /* U+03BC, Greek mu */
                                 {"\xb5m", 1e-3}, /* the micro sign in Latin-1 */
                                 {"\\u00B5m", 1e-3},  {"\\u00b5m", 1e-3},   {"micron", 1e-3},
                                 {"inches", 25.4},    {"micrometer", 1e-3}, {"micrometre", 1e-3},
                                 {"nm", 1e-6},        {"nanometer", 1e-6},  {"nanometre", 1e-6},
                                 {"\xc3\x85", 1e-7}, /* U+00C5, angstrom */
                                 {"angstrom", 1e-7},  {"pm", 1e-9},         {"picometer", 1e-9},
                                 {"cm", 10},          {"centimeter", 10},   {"centimetre", 10},
                                 {"dm", 100},         {"decimeter", 100},   {"m", 1000},
                                 {"meter", 1000},     {"metre", 1000},      {"km", 1e6},
                                 {"kilometer", 1e6},  {"in", 25.4},         {"inch", 25.4},
                                 {"ft", 304.8},       {"foot", 304.8},      {"yd", 914.4},
                                 {"yard", 914.4}};

    return find(units, SC_COUNT_OF(units), name);
}

void sc_warn_without_spacing(const sc_ctx *ctx, const char *path, const char *key)
{
    sc_warn(ctx,
            "%s: does not give the spacing of its voxels along all axes (%s); where it is missing, "
            "1 mm is taken",
            path, key);
}
