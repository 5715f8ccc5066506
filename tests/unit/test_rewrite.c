/* SPDX-License-Identifier: BSD-3-Clause */
/* Changes of a job file that leave all else as it stands. */
#include "check.h"

#include "segcast/job.h"

/* State what a job file is after a change. */
static void becomes(const char *text, const char *path, const char *value, const char *expected)
{
    const sc_setting setting = {.origin = path, .path = path, .value = value};
    SC_OWN(sc_text_clear) sc_text out = {0};

    assert_int_equal(sc_job_rewrite(listening_anew(), text, &setting, &out), SC_OK);
    assert_string_equal(out.data, expected);
}

TEST(a_value_is_replaced_and_comments_stay)
{
    becomes("# mine\nvolume: a.nrrd  # here\n\noutput: {fps: 30} # fast\n", "output.fps", "25",
            "# mine\nvolume: a.nrrd  # here\n\noutput: {fps: 25} # fast\n");
    becomes("output:\n  fps: 30  # fast\n  # behind\n", "output.fps", "25",
            "output:\n  fps: 25  # fast\n  # behind\n");
    becomes("tissues:\n  \"left \\\"a\\\"\": {color: red} # r\xc3\xb6t\n  ä b: {opacity: 1}\n",
            "tissues.\"ä b\".opacity", "0.5",
            "tissues:\n  \"left \\\"a\\\"\": {color: red} # r\xc3\xb6t\n  ä b: {opacity: 0.5}\n");
}

TEST(a_key_is_added_where_its_map_ends)
{
    becomes("tissues:\n  aorta: {opacity: 1}  # big\n\n# the film\nanimation:\n  frames: 6s\n",
            "tissues.aorta.visible", "false",
            "tissues:\n  aorta: {opacity: 1, visible: false}  # big\n\n# the film\nanimation:\n  "
            "frames: 6s\n");
    becomes("tissues:\n  aorta: {opacity: 1}  # big\n\n# the film\nanimation:\n  frames: 6s\n",
            "tissues.\"left atrium\".color", "#ff0000",
            "tissues:\n  aorta: {opacity: 1}  # big\n  \"left atrium\": {color: \"#ff0000\"}\n\n# "
            "the film\nanimation:\n  frames: 6s\n");
    becomes("volume: phantom\n", "animation.camera.orbit.angle", "30",
            "volume: phantom\nanimation: {camera: {orbit: {angle: 30}}}\n");
    becomes("volume: phantom", "output.fps", "5", "volume: phantom\noutput: {fps: 5}");
    becomes("# nothing\n", "volume", "phantom", "# nothing\nvolume: phantom\n");
    becomes("tissues: {}\n", "tissues.\"*\".opacity", "1", "tissues: {\"*\": {opacity: 1}}\n");
    becomes("animation:\n", "animation.frames", "5", "animation: {frames: 5}\n");
}

TEST(lists_and_key_frames)
{
    becomes("animation:\n  clip:\n    - {normal: left, at: 50%}  # half\n", "animation.clip[0].at",
            "40%", "animation:\n  clip:\n    - {normal: left, at: 40%}  # half\n");
    becomes("animation:\n  clip:\n    - normal: left\n      at: 50%  # half\n",
            "animation.clip.1.normal", "up",
            "animation:\n  clip:\n    - normal: left\n      at: 50%  # half\n    - {normal: up}\n");
    becomes("animation:\n  frames: 9\n", "animation.clip[0].at", "40%",
            "animation:\n  frames: 9\n  clip: [{at: 40%}]\n");
    becomes("animation:\n  clip:\n    - normal: left  # a\n      at: 50%  # half\n  frames: 9\n",
            "animation.clip", "[]", "animation:\n  clip: []  # half\n  frames: 9\n");
    becomes("animation: {camera: {zoom: {0%: 1, 50%: 2}}}\n", "animation.camera.zoom",
            "{0%: 1, 50%: 2, 100%: 1}", "animation: {camera: {zoom: {0%: 1, 50%: 2, 100%: 1}}}\n");
    becomes("overlays:\n  captions:\n    - text: >\n        long\n        text\n  time: none\n",
            "overlays.captions[0].text", "a, b: c",
            "overlays:\n  captions:\n    - text: \"a, b: c\"\n  time: none\n");
}

TEST(what_is_no_path_is_refused)
{
    const sc_setting setting = {.origin = "a", .path = "a..b", .value = "1"};
    SC_OWN(sc_text_clear) sc_text out = {0};

    assert_int_equal(sc_job_rewrite(listening_anew(), "a: 1\n", &setting, &out), SC_ERR_USAGE);
}

RUN_TESTS(NULL, NULL)
