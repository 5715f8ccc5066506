/* SPDX-License-Identifier: BSD-3-Clause */
/* What lies between two phases of a series, against shapes that are known. */
#include "check.h"

#include "segcast/phantom.h"
#include "segcast/resample.h"

#include <math.h>

enum { SIDE = 40, VOXELS = SIDE * SIDE * SIDE };

static const int phantom_size[3] = {90, 63, 93};

/* The phantom at a phase of its beat. Caller owns it. */
static sc_volume phantom_at(double phase)
{
    SC_OWN(sc_phantom_free_at) sc_phantom *phantom = NULL;
    sc_volume v = {0};

    assert_ok(sc_phantom_new_beating(&quiet, phase, &phantom));
    assert_ok(sc_phantom_volume(&quiet, phantom, phantom_size, 2, &v));
    return v;
}

static sc_volume copy_of(const sc_volume *v)
{
    const size_t bytes = sc_volume_voxels(v) * (size_t)v->label_bytes;
    sc_volume copy = *v;

    copy.ids = malloc(bytes);
    assert_non_null(copy.ids);
    memcpy(copy.ids, v->ids, bytes);
    return copy;
}

static int id_at(const sc_volume *v, size_t at)
{
    return ((const uint8_t *)v->ids)[at];
}

/* How many voxels differ. */
static size_t differing(const sc_volume *a, const sc_volume *b)
{
    size_t count = 0;

    for (size_t i = 0; i < sc_volume_voxels(a); i++)
        count += id_at(a, i) != id_at(b, i);
    return count;
}

/* The sum over all labels of how many voxels more or less they have. */
static double volume_error(const sc_volume *a, const sc_volume *b)
{
    double count[256] = {0}, sum = 0;

    for (size_t i = 0; i < sc_volume_voxels(a); i++) {
        count[id_at(a, i)]++;
        count[id_at(b, i)]--;
    }
    for (int id = 0; id < 256; id++)
        sum += fabs(count[id]);
    return sum;
}

/* Halfway between two phases of the phantom, while it moves evenly, and from the last phase to the
 * first of the next beat, the labels are nearer to the truth than those of the phase that would be
 * held. */
TEST(a_beat_is_met_better_than_by_holding)
{
    static const double phases[] = {0.15, 0.25, 0.55, 0.85};
    size_t held = 0, moved = 0;
    double held_volume = 0, moved_volume = 0;

    for (size_t i = 0; i < SC_COUNT_OF(phases); i++) {
        sc_volume a = phantom_at(phases[i]), b = phantom_at(phases[i] + 0.05);
        sc_volume truth = phantom_at(phases[i] + 0.025), middle = copy_of(&a);
        SC_OWN(sc_between_free_at) sc_between *between = NULL;

        assert_ok(sc_between_find(&quiet, &a, &b, 2, &between));
        sc_between_at(between, 0.5, &middle);
        held += differing(&a, &truth);
        moved += differing(&middle, &truth);
        held_volume += volume_error(&a, &truth);
        moved_volume += volume_error(&middle, &truth);
        free(middle.ids);
        sc_volume_clear(&truth);
        sc_volume_clear(&a);
        sc_volume_clear(&b);
    }
    print_message("voxels that differ from the truth: held %zu, moved %zu; of volumes: held %.0f, "
                  "moved %.0f\n",
                  held, moved, held_volume, moved_volume);
    assert_true(1.6 * (double)moved < (double)held);
    assert_true(1.6 * moved_volume < held_volume);
}

/* A cube of background in which the layers [first, first + thick) along x are of label 2, and all
 * before them of label 1; behind them is label 3. */
static sc_volume wall_at(int first, int thick, uint8_t ids[VOXELS], sc_label labels[4])
{
    sc_volume v = {.size = {SIDE, SIDE, SIDE},
                   .label_bytes = 1,
                   .ids = ids,
                   .label_count = 4,
                   .labels = labels,
                   .to_ras_mm = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}}};

    for (int i = 0; i < VOXELS; i++) {
        const int x = i % SIDE, y = i / SIDE % SIDE;
        const bool inside = y > 4 && y < SIDE - 5;

        ids[i] = (uint8_t)(!inside ? 0 : x < first ? 1 : x < first + thick ? 2 : 3);
    }
    return v;
}

/* A wall that moves by more than its thickness is whole at all moments, and moves evenly. */
TEST(a_thin_wall_moves_whole)
{
    static uint8_t ids[4][VOXELS];
    sc_label labels[4] = {{.value = 0}, {.value = 1}, {.value = 2}, {.value = 3}};
    const sc_volume a = wall_at(10, 2, ids[0], labels), b = wall_at(20, 2, ids[1], labels);
    SC_OWN(sc_between_free_at) sc_between *between = NULL;

    assert_ok(sc_between_find(&quiet, &a, &b, 1, &between));
    for (int step = 0; step <= 10; step++) {
        const sc_volume truth = wall_at(10 + step, 2, ids[2], labels);
        sc_volume v = wall_at(10, 2, ids[3], labels);

        sc_between_at(between, step / 10.0, &v);
        if (differing(&v, &truth))
            print_error("%zu voxels differ at step %d\n", differing(&v, &truth), step);
        assert_int_equal(differing(&v, &truth), 0);
    }
}

/* Fill a cube with a ball of label 1 of a radius in voxels, in a shell of label 2, in label 3. */
static sc_volume shell_at(double radius, uint8_t ids[VOXELS], sc_label labels[4])
{
    sc_volume v = wall_at(0, 0, ids, labels);

    for (int i = 0; i < VOXELS; i++) {
        const int row = i / SIDE, slice = row / SIDE;
        const double x = i % SIDE - 19.5, y = row % SIDE - 19.5, z = slice - 19.5;
        const double r = sqrt(x * x + y * y + z * z);

        ids[i] = (uint8_t)(r < radius ? 1 : r < radius + 2 ? 2 : 3);
    }
    return v;
}

/* A thin shell that grows by more than its thickness keeps its inside and its outside apart. */
TEST(a_thin_shell_grows_whole)
{
    static const int steps[3] = {1, SIDE, SIDE * SIDE};
    static uint8_t ids[3][VOXELS];
    sc_label labels[4] = {{.value = 0}, {.value = 1}, {.value = 2}, {.value = 3}};
    const sc_volume a = shell_at(8, ids[0], labels), b = shell_at(14, ids[1], labels);
    SC_OWN(sc_between_free_at) sc_between *between = NULL;

    assert_ok(sc_between_find(&quiet, &a, &b, 1, &between));
    for (int step = 1; step < 10; step++) {
        sc_volume v = shell_at(8, ids[2], labels);
        int leaks = 0;

        sc_between_at(between, step / 10.0, &v);
        for (int i = 0; i < VOXELS - steps[2]; i++) {
            for (int k = 0; k < 3; k++)
                leaks += ids[2][i] + ids[2][i + steps[k]] == 4 && ids[2][i] != 2;
        }
        if (leaks)
            print_error("%d leaks at step %d\n", leaks, step);
        assert_int_equal(leaks, 0);
    }
}

/* At the ends are the two phases, little else than what changes is touched, and nothing depends on
 * threads. */
TEST_OF_THREADS(ends_are_the_phases)
{
    sc_volume a = phantom_at(0), b = phantom_at(0.2), first = copy_of(&a), other = copy_of(&a);
    sc_between *between = NULL, *again = NULL;
    size_t carried;

    assert_ok(sc_between_find(&quiet, &a, &b, 1, &between));
    assert_ok(sc_between_find(&quiet, &a, &b, 3, &again));
    sc_between_at(between, 0, &first);
    assert_int_equal(differing(&first, &a), 0);
    sc_between_at(between, 1, &first);
    assert_int_equal(differing(&first, &b), 0);
    for (int step = 1; step < 10; step += 2) {
        const double t = step / 10.0;

        sc_between_at(between, t, &first);
        sc_between_at(again, t, &other);
        assert_int_equal(differing(&first, &other), 0);
        carried = 0;
        for (size_t i = 0; i < sc_volume_voxels(&a); i++)
            carried += id_at(&a, i) == id_at(&b, i) && id_at(&first, i) != id_at(&a, i);
        assert_true(carried < sc_volume_voxels(&a) / 200); /* thin tissue that passes by */
    }
    sc_between_free(between);
    sc_between_free(again);
    assert_ok(sc_between_find(&quiet, &a, &a, 2, &between)); /* nothing moves */
    sc_between_at(between, 0.5, &other);
    sc_between_free(between);
    free(first.ids);
    free(other.ids);
    sc_volume_clear(&a);
    sc_volume_clear(&b);
}

/* What the search takes is refused if it may not be used, before it is allocated. */
TEST(the_limit_of_memory_holds)
{
    const sc_volume a = phantom_at(0), b = phantom_at(0.2);
    const size_t voxels = sc_volume_voxels(&a);
    const sc_ctx low = {.memory_max_bytes = voxels + 1000},
                 middle = {.memory_max_bytes = 6 * voxels};
    const sc_ctx high = {.memory_max_bytes = 60 * voxels};
    sc_between *between = NULL;
    sc_volume mine[2] = {a, b};

    assert_int_equal(sc_between_find(&low, &a, &b, 1, &between), SC_ERR_SYSTEM); /* the changes */
    assert_int_equal(sc_between_find(&middle, &a, &b, 1, &between), SC_ERR_SYSTEM); /* the box */
    assert_null(between);
    assert_ok(sc_between_find(&high, &a, &b, 1, &between));
    sc_between_free(between);
    sc_volume_clear(&mine[0]);
    sc_volume_clear(&mine[1]);
}

RUN_TESTS(NULL, NULL)
