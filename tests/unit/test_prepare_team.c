/* SPDX-License-Identifier: BSD-3-Clause */
/* Volumes prepared by the ranks of a team together: the same bytes as by one rank alone, and no
 * rank that waits for another which has no memory. The ranks are threads here. */
#include "check.h"

#include "shapes.h"
#include "thread_team.h"

/* More bricks than a thread claims at a time, and areas that binary fractions do not hold. */
static const int size[3] = {62, 60, 100};
static const double spacing_mm[3] = {0.7, 1.1, 1.3};

static int random_id(double x, double y, double z)
{
    uint64_t seed = 1 + (uint64_t)(x / 5) * 7919 + (uint64_t)(y / 4) * 104729 + (uint64_t)(z / 9);

    random_bits(&seed);
    return (int)(random_bits(&seed) >> 60) % 4;
}

/* Bands of random labels, at least one among the bricks that a thread takes at a time. */
static int random_bands(double x, double y, double z)
{
    return fmod(z, 40) < 10 ? random_id(x, y, z) : 0;
}

typedef struct scenario {
    const sc_volume *volume;
    sc_prepare_settings settings;
    void *block; /* what was prepared, of @p bytes: rank 0 allocates it, and the test frees it */
    size_t bytes;
} scenario;

/* Pack a preparation to s->block by all ranks together. */
static void pack(scenario *s, sc_comm *comm, sc_team *team, const sc_preparation *p)
{
    if (sc_comm_rank(comm) == 0) {
        s->bytes = sc_preparation_bytes(p);
        assert_ok(sc_zalloc(&quiet, s->bytes, 1, &s->block));
    }
    assert_ok(sc_team_agree(team, SC_OK));
    assert_int_equal(sc_preparation_bytes(p), s->bytes);
    sc_preparation_pack_together(p, s->block);
}

/* Prepare the volume of a scenario; a team_work_fn. */
static sc_status prepare(const sc_ctx *ctx, sc_comm *comm, sc_team *team, void *user)
{
    scenario *s = user;
    sc_prepare_settings settings = s->settings;
    sc_volume volume = *s->volume;
    sc_preparation *p = NULL;
    sc_status status;

    settings.team = team;
    if (sc_comm_rank(comm) > 0)
        volume.labels = NULL; /* which the first rank alone needs */
    SC_TRY(sc_prepare(ctx, &volume, &settings, &p));
    pack(s, comm, team, p);
out:
    sc_preparation_free(p);
    return status;
}

/* Compare what 1, 2 and 3 ranks prepare with what one prepares without a team. */
static void compare(const sc_volume *volume, sc_prepare_settings settings)
{
    SC_OWN(clear_copy) prepared_copy alone = {0};

    settings.threads = 1;
    alone = prepare_as(volume, &settings);
    for (int ranks = 1; ranks <= 3; ranks++) {
        scenario s = {.volume = volume, .settings = settings};
        thread_team team = {.work = prepare, .user = &s, .threads = 1 + ranks % 2};

        assert_ok(run_team(&team, ranks));
        assert_int_equal(s.bytes, alone.bytes);
        assert_memory_equal(s.block, alone.block, alone.bytes);
        sc_free(s.block);
    }
}

TEST(any_ranks_prepare_the_same_bytes)
{
    static const sc_vec3 strengths[4] = {{0}, {1, 1, 1}, {2, 2, 2}, {0.5, 0.5, 0.5}};
    const sc_prepare_settings all = {.smooth = {1, 1, 1}, .local_thickness = true};
    sc_prepare_settings wide = all;

    wide.tissue_smooth = strengths;
    for (int label_bytes = 1; label_bytes <= 2; label_bytes++) {
        SC_OWN(sc_volume_clear)
        sc_volume volume = shape_volume(size, spacing_mm, label_bytes, 4, random_bands);

        compare(&volume, label_bytes == 1 ? all : wide);
        if (label_bytes == 1)
            compare(&volume, (sc_prepare_settings){.smooth = {0}});
    }
}

static void free_block(void *user)
{
    scenario *s = user;

    sc_free(s->block);
    s->block = NULL;
}

TEST(a_rank_without_memory_ends_all)
{
    const int small[3] = {9, 8, 10};
    SC_OWN(sc_volume_clear) sc_volume volume = shape_volume(small, spacing_mm, 1, 4, random_id);
    scenario s = {.volume = &volume, .settings = {.smooth = {1, 1, 1}, .local_thickness = true}};
    thread_team team = {.work = prepare, .user = &s, .threads = 1};

    fail_every_allocation(&team, free_block);
}

RUN_TESTS(NULL, NULL)
