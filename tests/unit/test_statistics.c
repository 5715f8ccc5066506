/* SPDX-License-Identifier: BSD-3-Clause */
/* Statistics of measurements: known values, and how often the interval holds the true median. */
#include "check.h"

#include "segcast/statistics.h"

#include <math.h>

TEST(known_values)
{
    const double values[] = {7, 1, 3, 5, 9, 11, 2};
    sc_statistics s;

    assert_ok(sc_statistics_of(&quiet, values, 7, &s));
    assert_near(s.median, 5, 0);
    assert_near(s.quartile_1, 2.5, 0);
    assert_near(s.quartile_3, 8, 0);
    assert_near(s.least, 1, 0);
    assert_near(s.most, 11, 0);
    assert_near(s.mean, 38.0 / 7, 1e-12);
    assert_true(s.has_interval);
    assert_near(s.low, 1, 0); /* of seven, the extremes: 1/128 of either side */
    assert_near(s.high, 11, 0);
    assert_near(sc_statistics_precision(&s), 1, 1e-12);
}

TEST(few_values_have_no_interval)
{
    const double values[] = {2, 1, 3, 4, 5};
    sc_statistics s;

    for (size_t count = 1; count <= 5; count++) {
        assert_ok(sc_statistics_of(&quiet, values, count, &s));
        assert_false(s.has_interval);
        assert_true(isinf(sc_statistics_precision(&s)));
    }
    assert_ok(sc_statistics_of(&quiet, values, 0, &s));
    assert_int_equal(s.count, 0);
}

/* The ranks of the interval for 6 to 20 values, from the table of the binomial distribution. */
TEST(ranks_are_those_of_the_table)
{
    static const int ranks[] = {1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 5, 5, 5, 6};
    double values[20];
    sc_statistics s;

    for (int i = 0; i < 20; i++)
        values[i] = i + 1;
    for (int count = 6; count <= 20; count++) {
        assert_ok(sc_statistics_of(&quiet, values, (size_t)count, &s));
        assert_near(s.low, ranks[count - 6], 0);
        assert_near(s.high, count + 1 - ranks[count - 6], 0);
    }
}

/* Of many samples of a skewed distribution at least 95 % enclose its median, with few values, with
 * many, and with so many that the approximation is used. */
TEST(the_interval_holds_the_median)
{
    static const size_t counts[] = {6, 15, 40, 1200};
    uint64_t seed = 7;
    static double values[1200];

    for (size_t c = 0; c < SC_COUNT_OF(counts); c++) {
        const int samples = 2000;
        int inside = 0;

        for (int i = 0; i < samples; i++) {
            sc_statistics s;

            for (size_t j = 0; j < counts[c]; j++)
                values[j] = -log(random_real(&seed, 1e-9, 1));
            assert_ok(sc_statistics_of(&quiet, values, counts[c], &s));
            inside += s.low <= log(2) && log(2) <= s.high;
        }
        assert_true(inside >= 0.94 * samples); /* 2,000 samples scatter by half a per cent */
        assert_true(inside <=
                    0.985 * samples); /* and the interval is not wider than it has to be */
    }
}

TEST(serial_share)
{
    assert_near(sc_karp_flatt(1, 1), 0, 0);
    assert_near(sc_karp_flatt(4, 4), 0, 1e-12);
    /* Amdahl's law with a serial share of 0.1 on 8 workers. */
    assert_near(sc_karp_flatt(1 / (0.1 + 0.9 / 8), 8), 0.1, 1e-12);
}

TEST(orders_are_random_and_the_same)
{
    int a[50], b[50], seen[50] = {0}, fixed = 0;

    sc_random_order(3, 50, a);
    sc_random_order(3, 50, b);
    assert_memory_equal(a, b, sizeof a);
    sc_random_order(4, 50, b);
    assert_memory_not_equal(a, b, sizeof a);
    for (int i = 0; i < 50; i++) {
        seen[a[i]]++;
        fixed += a[i] == i;
    }
    for (int i = 0; i < 50; i++)
        assert_int_equal(seen[i], 1);
    assert_true(fixed < 8);
}

RUN_TESTS(NULL, NULL)
