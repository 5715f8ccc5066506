/* SPDX-License-Identifier: BSD-3-Clause */
/* Films of shots in job files: what shots take from the film, where they lie in it, and what is
 * refused. */
#include "check.h"

#include "key.h"
#include "segcast/job.h"

#include <unistd.h>

/* Load the job file @p text. */
static sc_status load(const char *text, long *budget, sc_job *job)
{
    const sc_job_sources sources = {.path = "shots.yaml"};
    sc_ctx ctx = *listening_anew();
    sc_status status;

    write_text("shots.yaml", text);
    *job = (sc_job){0};
    ctx.alloc_budget = budget;
    status = sc_job_load(&ctx, &sources, job);
    unlink("shots.yaml");
    return status;
}

static const char film[] =
    "volume: phantom\n"
    "output: {fps: 10}\n"
    "render: {quality: draft, cap_outline: 0.5, stage: floor}\n"
    "tissues: {aorta: {color: red, opacity: 0.5}, \"*\": {opacity: 1}}\n"
    "overlays: {time: top, caption: {0s: none, 1s: first, 2s: none}}\n"
    "animation:\n"
    "  frames: 4 s\n"
    "  camera: {orbit: {turns: 2, elevation: 30}}\n"
    "  clip: [{normal: left, at: {1s: 0%, 2s: 50%}}]\n"
    "shots:\n"
    "  - {card: [A film, of shots], tissues: {aorta: {opacity: 0.75}}, "
    "animation: {frames: 12}}\n"
    "  - {name: One, transition: fade 1 s}\n"
    "  - name: Two\n"
    "    transition: cross_fade 5f\n"
    "    render: {quality: film}\n"
    "    tissues: {aorta: {opacity: 0.25}}\n"
    "    overlays: {caption: second}\n"
    "    animation: {frames: 21, camera: {fixed: {position_mm: [1, 2, 3], target_mm: [0, 0, 0]}}, "
    "clip: []}\n"
    "  - {name: Three, animation: {frames: 10 s, slices: through}, fade_out: 0.5 s}\n"
    "light: {method: global}\n";

/* What the text of film means. */
static void expect_film(const sc_job *job)
{
    static const int firsts[4] = {0, 12, 47, 68}, frames[4] = {12, 40, 21, 100};
    const sc_job *two = &job->film.shots[2].job;

    assert_int_equal(job->film.shot_count, 4);
    assert_int_equal(job->animation.frames, 168);
    for (int i = 0; i < 4; i++) {
        assert_int_equal(job->film.shots[i].span.first, firsts[i]);
        assert_int_equal(job->film.shots[i].span.frames, frames[i]);
        assert_int_equal(job->film.shots[i].job.animation.frames, frames[i]);
    }
    assert_true(job->film.shots[0].has_card && job->film.shots[0].card.has_subtitle);
    assert_int_equal(job->film.shots[0].job.tissues.rule_count,
                     1); /* its own, and none of the film */
    assert_string_equal(job->film.shots[0].card.title, "A film");
    assert_string_equal(job->film.shots[3].name, "Three");
    assert_int_equal(job->film.shots[1].span.transition_frames, 10);
    assert_int_equal(job->film.shots[2].span.transition_frames, 5);
    assert_int_equal(job->film.shots[3].span.fade_out_frames, 5);
    /* maps are merged key by key */
    assert_int_equal(two->render.quality, SC_QUALITY_FILM);
    assert_near(two->render.cap_outline, 0.5, 0);
    assert_int_equal(two->overlays.time, SC_PLACE_TOP);
    assert_int_equal(job->film.shots[1].job.render.quality, SC_QUALITY_DRAFT);
    assert_int_equal(job->film.shots[3].job.output.layout, SC_LAYOUT_VIEWS);
    assert_int_equal(two->output.layout, SC_LAYOUT_PICTURE);
    /* of keys that exclude each other that of the shot wins */
    assert_true(two->animation.camera.fixed && !job->film.shots[1].job.animation.camera.fixed);
    assert_near(job->film.shots[3].job.animation.camera.turns, 2, 0);
    /* lists are replaced */
    assert_int_equal(two->overlay_lists.caption_count, 1);
    assert_string_equal(two->overlay_lists.captions[0].text, "second");
    assert_int_equal(two->animation.sweep_count, 0);
    assert_int_equal(job->film.shots[3].job.animation.sweep_count, 1);
    /* tissues come behind those of the film */
    assert_int_equal(two->tissues.rule_count, 3);
    assert_string_equal(two->tissues.rules[2].pattern, "aorta");
    assert_true(two->tissues.rules[2].has.opacity && !two->tissues.rules[2].has.color);
    assert_near(two->tissues.rules[2].opacity, 0.25, 0);
    /* times count from the beginning of the shot */
    assert_near(job->film.shots[1].job.animation.sweeps[0].at_track.keys[0].at, 10.0 / 39, 1e-9);
    assert_near(job->film.shots[3].job.animation.sweeps[0].at_track.keys[0].at, 10.0 / 99, 1e-9);
    assert_near(job->film.shots[3].job.overlay_lists.captions[0].end, 20.0 / 99, 1e-9);
}

TEST(a_shot_has_the_keys_of_its_film)
{
    sc_job job, again;
    sc_text written = {0}, twice = {0};

    /* The film's keys have times behind the end of the first shot, which need other ones there. */
    assert_int_equal(load(film, NULL, &job), SC_ERR_DATA);
    assert_non_null(
        strstr(said.text, "shots.yaml:5: caption: 2s is behind the end of the animation"));
    assert_non_null(strstr(said.text, "1.2 s, by shots.yaml:11")); /* the shot that is too short */
    sc_job_clear(&job);
    {
        char text[sizeof film + 64];
        const char *at = strstr(film, "animation: {frames: 12}");

        snprintf(text, sizeof text, "%.*soverlays: {caption: none}, animation: {frames: 12}%s",
                 (int)(at - film), film, at + strlen("animation: {frames: 12}"));
        assert_ok(load(text, NULL, &job));
    }
    expect_film(&job);
    assert_ok(sc_job_write(&quiet, &job, false, &written));
    assert_ok(load(written.data, NULL, &again));
    expect_film(&again);
    assert_ok(sc_job_write(&quiet, &again, false, &twice));
    assert_string_equal(written.data, twice.data);
    sc_text_clear(&written);
    sc_text_clear(&twice);
    assert_ok(sc_job_write(&quiet, &job, true, &written));
    assert_ok(sc_job_write(&quiet, &again, true, &twice));
    assert_string_equal(written.data, twice.data);
    assert_null(strstr(written.data, "early_termination")); /* pictures do not depend on it */
    sc_text_clear(&written);
    sc_text_clear(&twice);
    sc_job_clear(&job);
    sc_job_clear(&again);
}

/* One message each, with its line; the job begins with two lines. */
TEST(wrong_shots_are_refused)
{
    static const struct {
        const char *shots, *message;
    } cases[] = {
        {"[]", "yaml:3: shots has 0 items, expected 1 to 100"},
        {"{}", "yaml:3: shots is a map, expected a list of shots"},
        {"[3]", "yaml:3: is \"3\", expected a shot"},
        {"\n- {nmae: x}", "yaml:4: unknown key \"nmae\"; did you mean \"name\"?"},
        {"\n- {volume: x}", "yaml:4: volume holds for the whole film"},
        {"\n- {farm: {tile: 8}}", "yaml:4: farm holds for the whole film"},
        {"\n- {shots: []}", "yaml:4: shots holds for the whole film"},
        {"\n- name: a\n  output: {size: 3}", "yaml:5: output holds for the whole film"},
        {"\n- {render: {smooth: 2}}", "yaml:4: smooth holds for the whole film"},
        {"\n- {tissues: {\"*\": {smooth: 2}}}", "yaml:4: smooth holds for the whole film"},
        {"\n- {render: {background: none}}", "yaml:4: background: either all shots have none"},
        {"\n- {transition: dissolve}", "yaml:4: transition is \"dissolve\", expected cut, cross"},
        {"\n- {}\n- transition: {}", "yaml:5: transition is a map, expected cut, cross_fade"},
        {"\n- {}\n- {transition: fade 1s 2s}", "yaml:5: transition is \"fade 1s 2s\", expected"},
        {"\n- {}\n- {transition: fade}", "yaml:5: transition is \"fade\", expected cut"},
        {"\n- {}\n- {transition: fade 0f}", "yaml:5: transition is \"fade 0f\", expected cut"},
        {"\n- {transition: cross_fade 1s}", "yaml:4: the first shot has a cross-fade"},
        {"\n- {}\n- {transition: fade 1ms}", "yaml:5: the transition of shot 2 is 0.001 s, which"},
        {"\n- {}\n- {animation: {frames: 9}, transition: cross_fade 1s}",
         "yaml:5: shot 2 has 9 frames (0.9 s), but the transitions at its beginning and its end "
         "take 10"},
        {"\n- {animation: {frames: 4}}\n- {transition: fade 1s}", "yaml:4: shot 1 has 4 frames"},
        {"\n- {animation: {frames: 9}}\n- {animation: {frames: 9}, transition: fade 1s}\n"
         "- {transition: cross_fade 500ms}",
         "yaml:5: shot 2 has 9 frames"},
        {"\n- {fade_out: 1s}\n- {transition: fade 1s}",
         "yaml:4: shot 1 has a fade_out, but shot 2 follows with a fade"},
        {"\n- {fade_out: 1ms}", "yaml:4: the fade_out of shot 1 is 0.001 s, which"},
        {"\n- {animation: {frames: 9}, transition: fade 1s, fade_out: 500ms}",
         "yaml:4: shot 1 has 9 frames"},
        {"\n- {card: {}}\n- {}", "yaml:4: card is a map, expected a title"},
        {"\n- {card: [a, b, c]}\n- {}", "yaml:4: card is [a, b, c], expected a title"},
        {"\n- {card: \"\"}\n- {}", "yaml:4: card has no value, expected a title"},
        {"\n- {card: \"\\u05e9\"}\n- {}", "yaml:4: card has, as its character 1, U+05E9"},
        {"\n- {card: a}", "yaml:4: all shots are title cards"},
        {"\n- {animation: {frames: 0}}", "yaml:4: frames is \"0\", expected a number from 1"},
        {"\n- {animation: {frames: 1000000}}\n- {animation: {frames: 1000000}}",
         "yaml:4: the shots have 2000000 frames, expected at most 1000000"},
    };

    for (size_t i = 0; i < SC_COUNT_OF(cases); i++) {
        char text[512];
        sc_job job;
        sc_status status;

        snprintf(text, sizeof text, "volume: phantom\noutput: {fps: 10}\nshots: %s\n",
                 cases[i].shots);
        status = load(text, NULL, &job);
        sc_job_clear(&job);
        if (status != SC_ERR_DATA || said.errors != 1 || !strstr(said.text, cases[i].message))
            fail_msg("status %d, \"%s\"; expected \"%s\"", status, said.text, cases[i].message);
    }
}

/* A mistake of the film is found again in each of its shots, but told once. */
TEST(a_mistake_of_the_film_is_told_once)
{
    SC_OWN(sc_job_clear) sc_job job = {0};

    assert_int_equal(load("volume: phantom\nrender: {quality: best}\nanimation: {clip: 3}\n"
                          "shots: [{name: a}, {name: b}, {card: c}]\n",
                          NULL, &job),
                     SC_ERR_DATA);
    assert_int_equal(said.errors, 2);
    assert_non_null(strstr(said.text, "yaml:3: clip is \"3\""));
}

TEST(no_allocation_that_fails_is_lost)
{
    sc_status status = SC_ERR_MEMORY;

    for (long n = 0; status != SC_ERR_DATA; n += 3) {
        long budget = n;
        SC_OWN(sc_job_clear) sc_job job = {0};

        status = load(film, &budget, &job);
        assert_true(status == SC_ERR_MEMORY || status == SC_ERR_DATA);
    }
}

/* Each key of the file can be given to a shot, or is marked as one of the whole film. */
TEST(every_key_is_of_the_film_or_of_shots)
{
    for (const sc_key *key = sc_job_keys; key->name; key++) {
        const sc_key *mine = sc_key_find(sc_shot_keys, key->name);

        if (key->scope.of_film != !mine || (mine && !mine->scope.of_job))
            fail_msg("%s", key->name);
    }
}

RUN_TESTS(NULL, NULL)
