/* SPDX-License-Identifier: BSD-3-Clause */
/* Comparisons of several volumes: their keys, where they stand in the picture, and which tissues of
 * theirs are the same. */
#include "check.h"

#include "panels.h"
#include "segcast/views.h"

#include <unistd.h>

/* Load the job file @p text. */
static sc_status load(const char *text, sc_job *job)
{
    const sc_job_sources sources = {.path = "compare.yaml"};
    const sc_ctx *ctx = listening_anew();
    sc_status status;

    write_text("compare.yaml", text);
    *job = (sc_job){0};
    status = sc_job_load(ctx, &sources, job);
    unlink("compare.yaml");
    return status;
}

/* @return the column of a picture of @p width_px at which the divider of a job stands in frame @p
 * k.
 */
static int divider_px(const sc_job *job, int k, int width_px)
{
    const double at = sc_frame_time(k, job->animation.frames);

    return sc_divider_px(sc_number_at(&job->compare.divider_track, job->compare.divider, at),
                         width_px);
}

TEST(a_comparison_is_read_and_written)
{
    static const char text[] = "volume: phantom\n"
                               "animation: {frames: 4 s}\n"
                               "compare:\n"
                               "  name: before\n"
                               "  align: none\n"
                               "  with: [{volume: phantom:20x14x21, name: \"after\\nall\"}]\n"
                               "  divider: {1 s: 10%, 3 s: 75%, ease: smooth}\n";
    SC_OWN(sc_text_clear) sc_text written = {0}, twice = {0};
    SC_OWN(sc_job_clear) sc_job job = {0}, again = {0};

    assert_ok(load(text, &job));
    assert_int_equal(job.output.layout, SC_LAYOUT_COMPARE); /* which need not be said */
    assert_int_equal(sc_subject_count(&job), 2);
    assert_string_equal(job.compare.name, "before");
    assert_string_equal(job.compare.others[0].volume, "phantom:20x14x21");
    assert_string_equal(job.compare.others[0].name, "after\nall");
    assert_int_equal(job.compare.align, SC_ALIGN_NONE);
    assert_ok(sc_job_write(&quiet, &job, false, &written));
    assert_ok(load(written.data, &again));
    assert_ok(sc_job_write(&quiet, &again, false, &twice));
    assert_string_equal(written.data, twice.data);
    for (int k = 0; k < job.animation.frames; k++)
        assert_int_equal(divider_px(&job, k, 1000), divider_px(&again, k, 1000));
}

TEST(wrong_comparisons_are_refused)
{
    static const struct {
        const char *text, *message;
    } cases[] = {
        {"compare: {with: [phantom]}\nanimation: {slices: 50%}",
         "yaml:3: slices: a comparison has none"},
        {"compare: {name: a}", "yaml:2: compare: the key \"with\" is missing"},
        {"compare: {with: []}", "yaml:2: with has 0 volumes, expected 1 to 3"},
        {"compare: {with: [phantom, phantom, phantom, phantom]}", "with has 4 volumes"},
        {"compare: {with: {volume: phantom}}", "yaml:2: with is a map, expected the path of"},
        {"compare: {with: [{name: a}]}", "yaml:2: the key \"volume\" is missing"},
        {"compare: {with: phantom, divider: 0.5}",
         "divider is \"0.5\", expected a share from 0% to 100%"},
        {"compare: {with: [phantom, phantom],\n divider: 50%}", "yaml:3: divider: it parts two"},
        {"compare: {with: phantom, divider: {9s: 1%}}", "9s is behind the end"},
        {"compare: {with: phantom}\nshots: [{name: a}]",
         "yaml:2: compare: a film of shots shows one"},
        {"compare: {with: phantom}\ncolor_by: {values: volume}", "coloured by values"},
        {"shots: [{compare: {with: phantom}}]", "compare holds for the whole film"},
    };

    for (size_t i = 0; i < SC_COUNT_OF(cases); i++) {
        char text[512];
        SC_OWN(sc_job_clear) sc_job job = {0};

        snprintf(text, sizeof text, "volume: phantom\n%s\n", cases[i].text);
        assert_int_equal(load(text, &job), SC_ERR_DATA);
        if (said.errors != 1 || !strstr(said.text, cases[i].message))
            fail_msg("%s: %d errors: %s", cases[i].text, said.errors, said.text);
    }
}

TEST(the_divider_moves_as_the_job_says)
{
    static const struct {
        const char *divider;
        int first, middle, last;
    } cases[] = {{"50%", 320, 320, 320},
                 {"{0%: 25%, 50%: 75%}", 160, 480, 480},
                 {"{0%: 0%, 100%: 50%}", 0, 160, 320}};

    for (size_t i = 0; i < SC_COUNT_OF(cases); i++) {
        char text[256];
        SC_OWN(sc_job_clear) sc_job job = {0};

        snprintf(text, sizeof text,
                 "volume: phantom\nanimation: {frames: 11}\n"
                 "compare: {with: phantom, divider: %s}\n",
                 cases[i].divider);
        assert_ok(load(text, &job));
        assert_int_equal(divider_px(&job, 0, 640), cases[i].first);
        assert_int_equal(divider_px(&job, 5, 640), cases[i].middle);
        assert_int_equal(divider_px(&job, 10, 640), cases[i].last);
    }
}

/* Rows and columns, for pictures of several shapes. */
TEST(panels_are_as_large_as_can_be)
{
    static const struct {
        int size_px[2], count, columns, rows;
    } cases[] = {{{1920, 1080}, 2, 2, 1}, {{1920, 1080}, 3, 3, 1}, {{1920, 1080}, 4, 4, 1},
                 {{1600, 1200}, 4, 2, 2}, {{1080, 1920}, 2, 1, 2}, {{720, 2400}, 3, 1, 3},
                 {{1080, 1920}, 3, 2, 2}, {{1080, 1920}, 4, 2, 2}, {{1080, 1080}, 2, 2, 1},
                 {{1080, 1080}, 3, 2, 2}, {{3000, 500}, 4, 4, 1},  {{101, 57}, 4, 4, 1},
                 {{16, 16}, 4, 4, 1}};

    for (size_t i = 0; i < SC_COUNT_OF(cases); i++) {
        const int width = cases[i].size_px[0], height = cases[i].size_px[1];
        const int count = cases[i].count;
        const sc_caption names[4] = {{.text = "a"}, {.text = "b"}, {.text = "c"}, {.text = "d"}};
        sc_job job = {.given.compare = true, .compare = {.count = count - 1}};
        sc_places places;
        const sc_viewport *p = places.panels;
        int below;

        job.overlays.text_percent = 2.8;
        sc_place_subjects(&job, names, cases[i].size_px, &places);
        below = places.below_px;
        for (int s = 0; s < count; s++) {
            assert_int_equal(p[s].width_px, width / cases[i].columns);
            assert_int_equal(p[s].height_px, height / cases[i].rows - below);
            assert_true(p[s].x_px >= 0 && p[s].x_px + p[s].width_px <= width);
            assert_true(p[s].y_px >= 0 && p[s].y_px + p[s].height_px + below <= height);
            for (int t = 0; t < s; t++) /* no two overlap, nor one and what is below another */
                assert_true(p[t].x_px + p[t].width_px <= p[s].x_px ||
                            p[s].x_px + p[s].width_px <= p[t].x_px ||
                            p[t].y_px + p[t].height_px + below <= p[s].y_px);
        }
        if (count == 3 && cases[i].rows == 2) /* that of the last row stands in its middle */
            assert_int_equal(2 * p[2].x_px + p[2].width_px, width);
    }
}

/* Names of any length have room below the pictures, in letters that can be read. */
TEST(names_have_room_below_the_pictures)
{
    static const char *const names[] = {"before", "A name of twenty-five letters", "Two\nlines",
                                        "averyverylongwordthatdoesnotendsoonatall"};
    static const int size_px[2] = {1280, 720};
    sc_places places, before = {.text_px = 0};
    sc_caption captions[2] = {{.text = "a"}};
    sc_job job = {.given.compare = true, .compare = {.count = 1}};

    job.overlays.text_percent = 2.8;
    for (size_t i = 0; i < SC_COUNT_OF(names); i++) {
        snprintf(captions[1].text, sizeof captions[1].text, "%s", names[i]);
        sc_place_subjects(&job, captions, size_px, &places);
        assert_int_equal(places.panels[0].height_px, 720 - places.below_px);
        assert_true(places.below_px > 2 * places.text_px && places.below_px <= 720 / 3);
        assert_true(places.text_px >= 9 && places.text_px <= 0.028 * 720 + 1e-9);
        if (i == 1) /* it fits into one line of the usual size, in a panel of 640 pixels */
            assert_int_equal(places.below_px, before.below_px);
        if (i > 1)
            assert_true(places.below_px != before.below_px);
        before = places;
    }
    /* Panels of a narrow picture have smaller letters, before they have more lines. */
    sc_place_subjects(&job, captions, (const int[2]){400, 720}, &places);
    assert_true(places.text_px < 0.028 * 720);
}

TEST(files_have_short_names)
{
    static const char *const cases[][2] = {{"/data/a/heart.nii.gz", "heart"},
                                           {"Heart_2.seg.nrrd", "Heart 2"},
                                           {"masks/", "masks"},
                                           {"cells.ome.zarr/", "cells"},
                                           {"/x/v1.2.MHA", "v1.2"},
                                           {".nrrd", ".nrrd"},
                                           {"phantom:20x14x21", "phantom:20x14x21"},
                                           {"a\tb\xff.nrrd", "a?b?"}};
    char name[SC_CAPTION_BYTES], path[SC_PATH_BYTES];

    for (size_t i = 0; i < SC_COUNT_OF(cases); i++) {
        sc_name_of_file(cases[i][0], name);
        assert_string_equal(name, cases[i][1]);
    }
    memset(path, 'x', sizeof path);
    path[sizeof path - 1] = '\0';
    sc_name_of_file(path, name);
    assert_int_equal(strlen(name), 60);
}

/* A subject whose labels are @p labels [count], the background first. */
static sc_panel subject_of(sc_label *labels, sc_label_stats *stats, int count)
{
    static sc_vec3 smooth[8];
    static uint8_t hidden[8];

    return (sc_panel){.volume = {.label_count = count,
                                 .labels = labels,
                                 .stats = stats,
                                 .how = {.smooth = smooth, .hidden = hidden}}};
}

TEST(tissues_are_the_same_by_name_or_by_number)
{
    sc_label a[] = {{0}, {.value = 1, .name = "aorta"}, {.value = 2, .name = "fat"}, {.value = 7}};
    sc_label b[] = {{0}, {.value = 1, .name = "fat"}, {.value = 3, .name = "lung"}};
    sc_label c[] = {{0}, {.value = 2}, {.value = 3}, {.value = 7, .name = "bone"}, {.value = 9}};
    sc_label_stats full[8] = {{0}}, empty[8] = {{0}};
    sc_panel subjects[3];
    sc_joined joined[3] = {{{0}, 0}};
    sc_status status = SC_ERR_MEMORY;

    for (int i = 0; i < 8; i++)
        full[i] = (sc_label_stats){.voxels = 5};
    for (long n = 0; status == SC_ERR_MEMORY; n++) { /* no allocation that fails is lost */
        long budget = n;
        const sc_ctx ctx = {.alloc_budget = &budget};

        subjects[0] = subject_of(a, empty, 4);
        subjects[1] = subject_of(b, full, 3);
        subjects[2] = subject_of(c, full, 5);
        status = sc_join_labels(&ctx, subjects, 3, joined);
        for (int s = 0; s < 3 && status != SC_OK; s++)
            sc_joined_clear(&joined[s]);
    }
    assert_ok(status);
    /* a: lung and 9 are new; b: aorta, 7 and 9; c: aorta alone, as its 2 is fat, its 3 lung, and
     * its bone the 7 of a */
    assert_int_equal(joined[0].added, 2);
    assert_int_equal(joined[1].added, 3);
    assert_int_equal(joined[2].added, 1);
    assert_string_equal(subjects[0].volume.labels[4].name, "lung");
    assert_int_equal(subjects[0].volume.labels[5].value, 9);
    assert_string_equal(subjects[2].volume.labels[5].name, "aorta");
    /* Those without a name have that of others. */
    assert_string_equal(subjects[0].volume.labels[3].name, "bone");
    assert_string_equal(subjects[1].volume.labels[4].name, "bone");
    assert_string_equal(subjects[2].volume.labels[1].name, "fat");
    assert_string_equal(subjects[2].volume.labels[4].name, "");
    /* The owner is the first that has voxels. */
    assert_int_equal(subjects[0].group.owners[2].subject, 1);
    assert_int_equal(subjects[0].group.owners[2].id, 1);
    assert_int_equal(subjects[2].group.owners[1].subject, 1);
    assert_int_equal(subjects[2].group.owners[3].subject, 2);
    assert_int_equal(subjects[1].group.owners[3].subject, 0); /* no one has voxels of the aorta */
    assert_int_equal(subjects[0].volume.stats[4].voxels, 0);
    assert_true(subjects[0].volume.stats[4].low[0] > subjects[0].volume.stats[4].high[0]);
    for (int s = 0; s < 3; s++)
        sc_joined_clear(&joined[s]);
}

RUN_TESTS(NULL, NULL)
