/* SPDX-License-Identifier: BSD-3-Clause */
/* Series of volumes as phases of a beat: their order, what jobs say of them, and which phase a
 * frame shows. */
#include "check.h"

#include "key.h"
#include "segcast/job.h"

#include <sys/stat.h>
#include <unistd.h>

/* Frames show the phases in their order, each from its share of the beat on. */
TEST(phases_follow_each_other)
{
    const sc_cine cine = {.bpm = 60};

    for (int k = 0; k < 90; k++) /* 30 frames for a beat of 10 phases: 3 for each */
        assert_int_equal(sc_cine_phase(&cine, 10, 30, k), k / 3 % 10);
    for (int k = 0; k < 50; k++) /* more phases than frames: some are left out */
        assert_int_equal(sc_cine_phase(&cine, 20, 10, k), 2 * k % 20);
    assert_int_equal(sc_cine_phase(&cine, 1, 30, 17), 0);
}

/* Rates that are no binary fractions: a frame on the beginning of a phase shows it. */
TEST(rates_are_exact)
{
    for (int bpm10 = 1; bpm10 < 2000; bpm10 += 7) {
        const sc_cine cine = {.bpm = bpm10 / 10.0};

        for (int k = 0; k < 2000; k += 13) {
            const long long passed = (long long)k * bpm10 * 10 / (10 * 60 * 25);

            assert_int_equal(sc_cine_phase(&cine, 10, 25, k), passed % 10);
        }
    }
}

/* After the last beat the last phase stays. */
TEST(beats_end)
{
    const sc_cine cine = {.bpm = 120, .beats = 2};

    assert_int_equal(sc_cine_phase(&cine, 5, 20, 9), 4);
    assert_int_equal(sc_cine_phase(&cine, 5, 20, 10), 0);
    assert_int_equal(sc_cine_phase(&cine, 5, 20, 19), 4);
    for (int k = 20; k < 100; k++)
        assert_int_equal(sc_cine_phase(&cine, 5, 20, k), 4);
}

/* Phases that lie behind the last, towards the next beat, are not what stays. */
TEST(beats_end_with_a_phase_of_a_file)
{
    const sc_cine cine = {.bpm = 60, .beats = 2, .between = 2}, on = {.bpm = 60, .between = 2};

    for (int k = 0; k < 24; k++) { /* 4 phases, with 8 between: 12 frames for a beat */
        assert_int_equal(sc_cine_phase(&on, 12, 12, k), k % 12);
        assert_int_equal(sc_cine_phase(&cine, 12, 12, k), k < 21 ? k % 12 : 9);
    }
    assert_int_equal(sc_cine_phase(&cine, 12, 12, 100), 9);
}

TEST(names_sort_by_numbers)
{
    static const char *const names[] = {"heart-2.nrrd",   "heart-9.nrrd",  "heart-10.nrrd",
                                        "heart-010.nrrd", "heart-11.nrrd", "heart-100.nrrd",
                                        "heart-a.nrrd",   "heart-a1",      "heart-a1b"};
    static const size_t count = SC_COUNT_OF(names);

    for (size_t i = 0; i < count; i++) {
        for (size_t j = 0; j < count; j++) {
            const int order = sc_natural_order(names[i], names[j]);

            if (i == j)
                assert_int_equal(order, 0);
            else if ((i == 2 && j == 3) ||
                     (i == 3 && j == 2)) /* the same number: any order, but one */
                assert_true(order == -sc_natural_order(names[j], names[i]) || order != 0);
            else
                assert_true((order < 0) == (i < j));
        }
    }
}

/* Load the job @p text in an empty directory that holds the files of @p names, separated by blanks;
 * "@" before one: a link to nowhere. */
static sc_status load(const char *names, const char *text, sc_job *job)
{
    const sc_job_sources sources = {.path = "cine-files/job.yaml", .check_inputs = true};
    const sc_ctx *ctx = listening_anew();
    char copy[512], path[600];
    sc_status status;

    assert_int_equal(system("rm -rf cine-files"), 0);
    assert_int_equal(mkdir("cine-files", 0777), 0);
    snprintf(copy, sizeof copy, "%s", names);
    for (char *name = strtok(copy, " "); name; name = strtok(NULL, " ")) {
        snprintf(path, sizeof path, "cine-files/%s", *name == '@' ? name + 1 : name);
        if (*name == '@') {
            assert_int_equal(symlink("nowhere", path), 0);
            continue;
        }
        write_text(path, "");
    }
    write_text("cine-files/job.yaml", text);
    *job = (sc_job){0};
    status = sc_job_load(ctx, &sources, job);
    assert_int_equal(system("rm -rf cine-files"), 0);
    return status;
}

/* The job is refused with @p message. */
static void expect_refused(const char *names, const char *text, const char *message)
{
    SC_OWN(sc_job_clear) sc_job job = {0};
    const sc_status status = load(names, text, &job);

    if (status == SC_OK || !strstr(said.text, message))
        print_error("expected \"%s\", found \"%s\"\n", message, said.text);
    assert_int_not_equal(status, SC_OK);
    assert_non_null(strstr(said.text, message));
}

/* A pattern finds the files in the order of their numbers, and a list keeps its own. */
TEST(series_are_found)
{
    sc_job job;

    assert_int_equal(load("p10 p0 p5 p15", "volume: p*\ncine: {bpm: 72.5, loop: 3}\n", &job),
                     SC_OK);
    assert_int_equal(job.volume.phase_count, 4);
    assert_non_null(strstr(job.volume.phases[1].path, "/cine-files/p5"));
    assert_non_null(strstr(job.volume.phases[3].path, "/cine-files/p15"));
    assert_string_equal(job.volume.path, job.volume.phases[0].path);
    assert_true(job.given.cine && job.cine.cine.bpm == 72.5 && job.cine.cine.beats == 3);
    sc_job_clear(&job);
    assert_int_equal(load("a b c", "volume: {path: [c, a, b]}\ncine: {loop: false}\n", &job),
                     SC_OK);
    assert_int_equal(job.volume.phase_count, 3);
    assert_non_null(strstr(job.volume.phases[0].path, "/c"));
    assert_non_null(strstr(job.volume.phases[2].path, "/b"));
    assert_int_equal(job.cine.cine.beats, 1);
    sc_job_clear(&job);
    assert_int_equal(load("p*", "volume: p*\n", &job), SC_OK); /* a file with such a name */
    assert_int_equal(job.volume.phase_count, 0);
    sc_job_clear(&job);
}

/* Chosen phases stay, and the job as resolved is the same. */
TEST(phases_are_chosen)
{
    SC_OWN(sc_job_clear) sc_job job = {0}, again = {0};
    SC_OWN(sc_text_clear) sc_text text = {0};

    assert_int_equal(
        load("p1 p2 p3 p4 p5 p6",
             "volume: p*\ncine: {phases: \"0-4:2,5\"}\nshots: [{name: a}, {name: b}]\n", &job),
        SC_OK);
    assert_int_equal(job.volume.phase_count, 4);
    assert_non_null(strstr(job.volume.phases[1].path, "/p3"));
    assert_non_null(strstr(job.volume.phases[3].path, "/p6"));
    assert_int_equal(job.film.shots[1].job.volume.phase_count, 4);
    assert_int_equal(sc_job_write(&listening, &job, false, &text), SC_OK);
    assert_int_equal(load("p1 p2 p3 p4 p5 p6", text.data, &again), SC_OK);
    assert_int_equal(again.volume.phase_count, 4);
    assert_memory_equal(again.volume.phases, job.volume.phases, 4 * sizeof *job.volume.phases);
}

/* Phases are shown in the order in which they are chosen; the first of them is the volume. */
TEST(chosen_phases_keep_their_order)
{
    static const char order[] = "4612";
    SC_OWN(sc_job_clear) sc_job job = {0};

    assert_int_equal(load("p1 p2 p3 p4 p5 p6", "volume: p*\ncine: {phases: \"3-5:2,0,1\"}\n", &job),
                     SC_OK);
    assert_int_equal(job.volume.phase_count, 4);
    for (int i = 0; i < 4; i++)
        assert_int_equal(strrchr(job.volume.phases[i].path, 'p')[1], order[i]);
    assert_string_equal(job.volume.path, job.volume.phases[0].path);
}

TEST(mistakes_are_told)
{
    expect_refused("p1 p2", "volume: p*\n",
                   "job.yaml:1: volume is a series of 2 files; expected cine");
    expect_refused(
        "p1 p2", "volume: p1\ncine: {bpm: 60}\n",
        "job.yaml:2: cine: volume is one file, which holds one volume; expected a series");
    expect_refused("p1", "volume: p*\ncine: {}\n", "job.yaml:2: cine: there is one phase");
    expect_refused("q1", "volume: p*\ncine: {}\n", "job.yaml:1: volume: no file matches p*");
    expect_refused("q1", "volume: '*/*/*/p*'\ncine: {}\n",
                   "job.yaml:1: volume: */*/*/p* has wildcards in 4 parts of the path, expected at "
                   "most 2; name the directories");
    expect_refused("p1 p2 p4", "volume: p*\ncine: {}\n",
                   "job.yaml:1: volume: there is no file between p2 and p4");
    expect_refused("p0 p20 p30", "volume: p*\ncine: {}\n", "there is no file between p0 and p20");
    expect_refused("p1 p01 p2", "volume: p*\ncine: {}\n", "have the same number");
    expect_refused("p-00 p-01 p-02 p-03 p-3", "volume: p*\ncine: {}\n",
                   "p-03 and p-3 have the same number");
    expect_refused("p1 p2 q1", "volume: \"?*1\"\ncine: {}\n", "differ in more than one number");
    expect_refused("p1a1 p1a2 p2a2", "volume: p*\ncine: {}\n", "differ in more than one number");
    expect_refused("p1 p2", "volume: [p1, p3]\ncine: {}\n", "cine-files/p3: No such file");
    expect_refused("p1 @p2 p3", "volume: p*\ncine: {}\n",
                   "job.yaml:1: volume: cine-files/p2: No such file");
    expect_refused("p1", "volume: []\ncine: {}\n", "volume has 0 phases");
    expect_refused("p1", "volume: [p1, [p2]]\ncine: {}\n", "expected the path of a volume");
    expect_refused("p1 p2", "volume: p*\ncine: {phases: 0-2}\n",
                   "phases is \"0-2\", expected numbers from 0 to 1");
    expect_refused("p1 p2", "volume: p*\ncine: {phases: \"1,0,1\"}\n",
                   "phases is \"1,0,1\", expected numbers from 0 to 1, such as 0-1, each once");
    expect_refused("p1 p2", "volume: p*\ncine: {loop: often}\n", "loop is \"often\"");
    expect_refused("p1 p2", "volume: p*\ncine: {loop: 0}\n", "loop is \"0\"");
    expect_refused("p1 p2", "volume: p*\ncine: {bpm: 0}\n", "bpm is \"0\"");
    expect_refused("p1 p2", "volume: {path: p*, box: visible}\ncine: {}\n",
                   "box: what is visible is another part of each phase");
    expect_refused("p1 p2", "volume: p*\nshots: [{cine: {}}, {}]\ncine: {}\n",
                   "cine holds for the whole film");
}

RUN_TESTS(NULL, NULL)
