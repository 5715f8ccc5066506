/* SPDX-License-Identifier: BSD-3-Clause */
/* What pages of the desk have changed: the later change of a key replaces the earlier, and each
 * step is undone and done again. */
#include "check.h"

#include "desk.h"

/* State what the changes are, as "key=value ...". */
static void are(const sc_edits *edits, const char *expected)
{
    SC_OWN(sc_text_clear) sc_text text = {0};

    assert_int_equal(sc_text_add(listening_anew(), &text, "%s", ""), SC_OK);
    for (size_t i = 0; i < edits->count; i++)
        assert_int_equal(sc_text_add(listening_anew(), &text, "%s%s=%s", i ? " " : "",
                                     edits->all[i].path, edits->all[i].value),
                         SC_OK);
    assert_string_equal(text.data, expected);
}

TEST(a_change_replaces_those_of_its_key_and_within_it)
{
    sc_edits edits = {0};

    assert_int_equal(sc_edits_add(listening_anew(), &edits, "a.b", "1"), SC_OK);
    assert_int_equal(sc_edits_add(listening_anew(), &edits, "a.bc", "2"), SC_OK);
    assert_int_equal(sc_edits_add(listening_anew(), &edits, "c[0].at", "3"), SC_OK);
    assert_int_equal(sc_edits_add(listening_anew(), &edits, "a.b", "4"), SC_OK);
    are(&edits, "a.bc=2 c[0].at=3 a.b=4");
    assert_int_equal(sc_edits_add(listening_anew(), &edits, "c", "[]"), SC_OK);
    are(&edits, "a.bc=2 a.b=4 c=[]");
    assert_int_equal(sc_edits_add(listening_anew(), &edits, "a.b", NULL), SC_OK);
    are(&edits, "a.bc=2 c=[]");
    sc_edits_clear(&edits);
}

/* Take a step that sets a key. */
static void step(sc_steps *steps, const char *group, const char *value)
{
    sc_edits next = {0};

    assert_int_equal(sc_edits_copy(listening_anew(), &steps->now, &next), SC_OK);
    assert_int_equal(sc_edits_add(listening_anew(), &next, "k", value), SC_OK);
    sc_steps_begin(steps, group, &next);
}

TEST(steps_are_undone_and_done_again)
{
    sc_steps *steps = calloc(1, sizeof *steps);

    step(steps, "", "1");
    step(steps, "drag", "2");
    step(steps, "drag", "3");
    are(&steps->now, "k=3");
    assert_true(sc_steps_go(steps, true));
    are(&steps->now, "k=1"); /* a drag is one step */
    assert_true(sc_steps_go(steps, true));
    are(&steps->now, "");
    assert_false(sc_steps_go(steps, true));
    assert_true(sc_steps_go(steps, false) && sc_steps_go(steps, false));
    are(&steps->now, "k=3");
    assert_false(sc_steps_go(steps, false));
    assert_true(sc_steps_go(steps, true));
    step(steps, "drag", "4"); /* what was undone is gone; another drag is another step */
    assert_false(sc_steps_go(steps, false));
    assert_true(sc_steps_go(steps, true));
    are(&steps->now, "k=1");
    for (int i = 0; i < 2 * SC_STEPS_MAX; i++)
        step(steps, "", i % 2 ? "a" : "b");
    assert_int_equal(steps->undo_count, SC_STEPS_MAX);
    sc_steps_clear(steps);
    free(steps);
}

RUN_TESTS(NULL, NULL)
