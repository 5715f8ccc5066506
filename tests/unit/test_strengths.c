/* SPDX-License-Identifier: BSD-3-Clause */
/* Smoothing by strengths that differ between tissues. */
#include "check.h"

#include "shapes.h"

#include <math.h>

static const double cube[3] = {1, 1, 1};

static sc_vec3 same(double strength)
{
    return (sc_vec3){strength, strength, strength};
}

/* Nine slabs along x. */
static int nine_slabs(double x, double y, double z)
{
    return 1 + (int)x / 4;
}

TEST(more_strengths_than_tables_are_refused)
{
    const int size[3] = {36, 6, 6};
    SC_OWN(sc_volume_clear) sc_volume volume = shape_volume(size, cube, 1, 10, nine_slabs);
    sc_vec3 each[10] = {{0, 0, 0}};
    bool hidden[10] = {false};
    sc_prepare_settings settings = {.tissue_smooth = each, .hidden = hidden, .threads = 1};
    sc_preparation *p;

    for (int id = 1; id < 10; id++)
        each[id] = same(0.2 * id);
    assert_int_equal(sc_prepare(&quiet, &volume, &settings, &p), SC_ERR_DATA);
    hidden[4] = true; /* what is hidden needs no tables */
    assert_ok(sc_prepare(&quiet, &volume, &settings, &p));
    sc_preparation_free(p);
}

RUN_TESTS(NULL, NULL)
