/* SPDX-License-Identifier: BSD-3-Clause */
/* The grid of a volume, measured by the ranks of a team together: the same as by one rank alone,
 * and no rank that waits for another which has no memory. The ranks are threads here. */
#include "check.h"

#include "segcast/resample.h"
#include "shapes.h"
#include "thread_team.h"

typedef struct scenario {
    const sc_volume *volume;
    sc_drawn_grid grids[THREAD_RANKS_MAX]; /* what each rank has found */
} scenario;

/* Measure the grid of the volume of a scenario; a team_work_fn. */
static sc_status measure(const sc_ctx *ctx, sc_comm *comm, sc_team *team, void *user)
{
    scenario *s = user;

    return sc_find_drawn_grid_together(ctx, team, s->volume, &s->grids[sc_comm_rank(comm)]);
}

/* @return @p at moved by up to 2 voxels, to and fro, by the number of the slice. */
static double jumped(double at, double z)
{
    uint64_t seed = 7 + (uint64_t)z;

    random_bits(&seed);
    return at + (double)(random_bits(&seed) >> 62) - 1.5;
}

static int ball_id(double x, double y, double z)
{
    return hypot(hypot(x - 30.4, y - 31.1), z - 29.7) < 22 ? 1 + (x > y) : 0;
}

static int jumping_id(double x, double y, double z)
{
    return ball_id(jumped(x, z), jumped(y, z + 100), z / 4);
}

static int copied_id(double x, double y, double z)
{
    return ball_id(floor(x / 2) * 2, floor(y / 3) * 3, z);
}

TEST(any_ranks_measure_the_same_grid)
{
    static int (*const ids[3])(double, double, double) = {ball_id, jumping_id, copied_id};
    const double spacing_mm[3] = {1, 1, 1};
    int moved = 0, copied = 0;

    for (int i = 0; i < 3; i++) {
        const int size[3] = {65, 64, ids[i] == jumping_id ? 240 : 66};
        SC_OWN(sc_volume_clear)
        sc_volume volume = shape_volume(size, spacing_mm, 1 + i % 2, 4, ids[i]);
        sc_drawn_grid alone;

        assert_ok(sc_find_drawn_grid(&quiet, &volume, 1, &alone));
        moved += alone.moved[2] > 0;
        copied += alone.copies[0] > 1;
        for (int ranks = 1; ranks <= 3; ranks++) {
            scenario s = {.volume = &volume};
            thread_team team = {.work = measure, .user = &s, .threads = 1 + ranks % 2};

            assert_ok(run_team(&team, ranks));
            for (int rank = 0; rank < ranks; rank++)
                assert_memory_equal(&s.grids[rank], &alone, sizeof alone);
        }
    }
    /* The volumes were good for something. */
    assert_true(moved && copied);
}

TEST(a_rank_without_memory_ends_all)
{
    static int (*const ids[2])(double, double, double) = {jumping_id, copied_id};
    const double spacing_mm[3] = {1, 1, 1};

    for (int i = 0; i < 2; i++) {
        const int size[3] = {65, 64, ids[i] == jumping_id ? 240 : 66};
        SC_OWN(sc_volume_clear) sc_volume volume = shape_volume(size, spacing_mm, 1, 4, ids[i]);
        scenario s = {.volume = &volume};
        thread_team team = {.work = measure, .user = &s, .threads = 1};

        fail_every_allocation(&team, NULL);
    }
}

RUN_TESTS(NULL, NULL)
