/* SPDX-License-Identifier: BSD-3-Clause */
/* How the chambers of the phantom contract in the course of a beat. The times are shares of a beat
 * at rest, after the diagram of C. J. Wiggers (1921, "Studies on the consecutive phases of the
 * cardiac cycle"), as textbooks of physiology have it. */
#include "phantom/phantom_model.h"

/* The ventricles eject between the first two of these, rest contracted, fill quickly up to the
 * third and fourth, rest again, and are filled by the atria from the fifth on. */
#define EJECTION_BEGIN 0.06
#define EJECTION_END 0.38
#define FILLING_BEGIN 0.46
#define FILLING_END 0.64
#define ATRIAL_BEGIN 0.82

/* How far the ventricles are still contracted between the quick filling and that by the atria. */
#define DIASTASIS 0.25

/* From 0 at @p begin to 1 at @p end, with a slope of 0 at both. */
static double step(double at, double begin, double end)
{
    const double u = fmin(fmax((at - begin) / (end - begin), 0), 1);

    return u * u * (3 - 2 * u);
}

sc_beat sc_beat_at(double phase)
{
    const double at = phase - floor(phase), atrial_peak = (ATRIAL_BEGIN + 1) / 2;

    return (sc_beat){.ventricles = step(at, EJECTION_BEGIN, EJECTION_END) -
                                   (1 - DIASTASIS) * step(at, FILLING_BEGIN, FILLING_END) -
                                   DIASTASIS * step(at, ATRIAL_BEGIN, 1),
                     .atria = step(at, ATRIAL_BEGIN, atrial_peak) - step(at, atrial_peak, 1)};
}
