/* SPDX-License-Identifier: BSD-3-Clause */
/* The bar that shows progress on a terminal. */
#include "check.h"

#include "segcast/process.h"

/* Check the bar for @p columns and @p share. It is drawn into memory of its own, so that a
 * sanitizer sees what is written behind it. */
static void check_bar(int columns, double share)
{
    const int width = columns < SC_BAR_COLUMNS ? columns : SC_BAR_COLUMNS;
    const int full = (int)(width * (share < 1 ? share : 1));
    char *memory = malloc(SC_BAR_BYTES + 1);

    assert_non_null(memory);
    memory[SC_BAR_BYTES] = '|';
    sc_progress_bar(columns, share, memory);
    assert_int_equal(memory[SC_BAR_BYTES], '|');
    if (columns < 5 || share < 0) {
        assert_string_equal(memory, "");
    } else {
        assert_int_equal(strlen(memory), width + 4);
        assert_int_equal(strspn(memory + 1, "#"), full);
        assert_int_equal(strspn(memory + 1 + full, "."), width - full);
        assert_string_equal(memory + 1 + width, "]  ");
    }
    free(memory);
}

TEST(bar_fits_and_shows_the_share)
{
    static const double shares[] = {-1, 0, 0.01, 0.3, 0.999, 1, 1.5};

    for (int columns = -20; columns <= 200; columns++)
        for (size_t i = 0; i < SC_COUNT_OF(shares); i++)
            check_bar(columns, shares[i]);
}

TEST(bar_looks_as_expected)
{
    char bar[SC_BAR_BYTES];

    sc_progress_bar(10, 0.35, bar);
    assert_string_equal(bar, "[###.......]  ");
    sc_progress_bar(80, 1, bar);
    assert_string_equal(bar, "[##############################]  ");
}

/* A stage that is done for one of several phases says for which. */
TEST(stages_say_for_which_phase_they_are)
{
    sc_stage stage = {.name = NULL};
    const sc_ctx ctx = {.stage = &stage};

    assert_null(sc_stage_look(&ctx).name);
    sc_stage_begin(&ctx, "preparing", 0, 0);
    assert_string_equal(sc_stage_look(&ctx).text, "preparing");
    sc_stage_turn(&ctx, 3, 20);
    assert_string_equal(sc_stage_look(&ctx).text, "preparing, phase 3 of 20");
    sc_stage_begin(&ctx, "sharing", 0, 0); /* the next stage is done for the same */
    assert_string_equal(sc_stage_look(&ctx).text, "sharing, phase 3 of 20");
    sc_stage_turn(&ctx, 1, 1);
    assert_string_equal(sc_stage_look(&ctx).text, "sharing");
    sc_stage_turn(&ctx, 0, 0);
    assert_string_equal(sc_stage_look(&ctx).text, "sharing");
}

RUN_TESTS(NULL, NULL)
