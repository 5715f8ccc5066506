/* SPDX-License-Identifier: BSD-3-Clause */
/* Study files: what is read, which cells follow from it, and what is refused. */
#include "check.h"

#include "segcast/comm.h"
#include "segcast/study_file.h"

#include <unistd.h>

static sc_status load(const char *text, sc_study *study)
{
    const sc_ctx *ctx = listening_anew();
    sc_status status;

    write_text("study.yaml", text);
    *study = (sc_study){0};
    status = sc_study_load(ctx, "study.yaml", study);
    unlink("study.yaml");
    return status;
}

static void refuses(const char *text, const char *message)
{
    SC_OWN(sc_study_clear) sc_study study = {0};
    const sc_status status = load(text, &study);

    if (status != SC_ERR_DATA || said.errors != 1 || !strstr(said.text, message))
        fail_msg("status %d, \"%s\"; expected \"%s\"", status, said.text, message);
}

static const char two_axes[] =
    "job: jobs/heart.yaml\n"
    "set: {volume: heart.nrrd, tissues: {\"*\": {opacity: 1}}, threads: 2}\n"
    "sweep:\n"
    "  render.skip: [none, leap]\n"
    "  layers:\n"
    "    few: {render.quality: draft}\n"
    "    all: {render.quality: still, threads: 1, placement: spread}\n"
    "    none: {}\n"
    "precision: 5%\n"
    "budget: 2 min\n";

TEST(cells_are_all_combinations)
{
    SC_OWN(sc_study_clear) sc_study study = {0};
    sc_study_settings cell;

    assert_int_equal(load(two_axes, &study), SC_OK);
    assert_int_equal(sc_study_cells(&study), 6);
    assert_string_equal(sc_study_value_of(&study, 4, 0)->name, "leap");
    assert_string_equal(sc_study_value_of(&study, 4, 1)->name, "all");
    assert_int_equal(sc_study_cell(&listening, &study, 4, &cell), SC_OK);
    assert_int_equal(cell.count, 4);
    assert_string_equal(cell.items[0].path, "volume");
    assert_string_equal(cell.items[0].value, "heart.nrrd");
    assert_string_equal(cell.items[1].value, "{\"*\": {\"opacity\": 1}}");
    assert_string_equal(cell.items[2].path, "render.skip");
    assert_string_equal(cell.items[2].value, "leap");
    assert_string_equal(cell.items[2].origin, "study.yaml:4: render.skip");
    assert_string_equal(cell.items[3].value, "still");
    assert_int_equal(cell.threads, 1); /* the value of an axis wins over what holds for all */
    assert_int_equal(cell.ranks, 0);
    assert_int_equal(cell.placement, SC_COMM_SPREAD);
    sc_free(cell.items);
    assert_int_equal(sc_study_cell(&listening, &study, 0, &cell), SC_OK);
    assert_int_equal(cell.threads, 2);
    assert_int_equal(cell.placement, SC_COMM_PACKED);
    sc_free(cell.items);
    assert_true(study.budget_s == 120 && study.precision > 0.0499 && study.precision < 0.0501);
}

TEST(paths_are_relative_to_the_file)
{
    sc_study study;
    sc_study_settings cell;

    (void)!system("mkdir -p sub");
    write_text("sub/study.yaml", "job: a.yaml\nsweep: {volume: [phantom:16x16x16, b.nrrd]}\n");
    assert_int_equal(sc_study_load(&listening, "sub/study.yaml", &study), SC_OK);
    assert_string_equal(study.job, "sub/a.yaml");
    assert_int_equal(sc_study_cell(&listening, &study, 0, &cell), SC_OK);
    assert_string_equal(cell.items[0].value, "phantom:16x16x16");
    sc_free(cell.items);
    assert_int_equal(sc_study_cell(&listening, &study, 1, &cell), SC_OK);
    assert_string_equal(cell.items[0].value, "sub/b.nrrd");
    sc_free(cell.items);
    sc_study_clear(&study);
    (void)!system("rm -r sub");
}

TEST(what_is_written_is_read_as_the_same)
{
    sc_study study;
    SC_OWN(sc_text_clear) sc_text first = {0}, second = {0};

    assert_int_equal(load(two_axes, &study), SC_OK);
    assert_int_equal(sc_study_write(&listening, &study, &first), SC_OK);
    sc_study_clear(&study);
    assert_int_equal(load(first.data, &study), SC_OK);
    assert_int_equal(sc_study_cells(&study), 6);
    assert_int_equal(sc_study_write(&listening, &study, &second), SC_OK);
    assert_string_equal(first.data, second.data);
    sc_study_clear(&study);
}

TEST(mistakes_are_told)
{
    refuses("sweep: {render.skip: []}\n", "study.yaml:1: render.skip has no values");
    refuses("sweep: {rank: [1, 2]}\n", "unknown key \"rank\"; did you mean \"ranks\"?");
    refuses("sweep: {ranks: [0]}\n", "expected a number from 1");
    refuses("sweep: {ranks: [1.5]}\n", "expected a whole number");
    refuses("sweep: {placement: [loose]}\n", "expected packed or spread");
    refuses("sweep: {ranks: 2}\n", "expected a list of values");
    refuses("sweep: {ranks: [2, 2]}\n", "ranks has the value 2 twice");
    refuses("sweep: {a: {b: 1}}\n", "expected a map of settings");
    refuses("sweep: {a: {b: {c: 1}}}\n", "\"c\"");
    refuses("set: {rendr.skip: leap}\n", "did you mean \"render\"?");
    refuses("measure: time\n", "expected one of: frames, job");
    refuses("swep: {}\n", "did you mean \"sweep\"?");
    refuses("least: 9\nmost: 8\n", "most is 8 and least is 9");
    refuses("[1, 2]\n", "expected a map of keys");
}

TEST(too_many_cells_are_refused)
{
    SC_OWN(sc_text_clear) sc_text text = {0};
    const sc_ctx ctx = quiet;

    assert_int_equal(sc_text_add(&ctx, &text, "sweep:\n"), SC_OK);
    for (int axis = 0; axis < 2; axis++) {
        assert_int_equal(sc_text_add(&ctx, &text, "  axis%d:\n", axis), SC_OK);
        for (int i = 0; i < 101; i++)
            assert_int_equal(sc_text_add(&ctx, &text, "    v%d: {threads: 1}\n", i), SC_OK);
    }
    refuses(text.data, "sweep has 10201 cells, expected at most 10000");
}

RUN_TESTS(NULL, NULL)
