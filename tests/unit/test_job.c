/* SPDX-License-Identifier: BSD-3-Clause */
/* Job files: what is read, what is refused, and the messages. */
#include "check.h"

#include "describe.h"

#include <ctype.h>
#include <sys/stat.h>
#include <unistd.h>

/* Load the job file @p text. @p setting: "key.path=value" or NULL. @p variable: of the environment,
 * or NULL. */
static sc_status load(const char *text, const char *setting, const char *variable, sc_job *job)
{
    const char *environment[] = {variable, NULL};
    char path[256] = "";
    sc_setting settings[1] = {{.origin = setting, .path = path}};
    const sc_job_sources sources = {.path = "job.yaml",
                                    .settings = settings,
                                    .setting_count = setting != NULL,
                                    .environment = variable ? environment : NULL};
    const sc_ctx *ctx = listening_anew();
    sc_status status;

    if (setting) {
        const char *equals = strrchr(setting, '=');

        snprintf(path, sizeof path, "%.*s", (int)(equals - setting), setting);
        settings[0].value = equals + 1;
    }
    write_text("job.yaml", text);
    *job = (sc_job){0};
    status = sc_job_load(ctx, &sources, job);
    unlink("job.yaml");
    if (status != SC_OK) /* what was right of it, which no caller looks at */
        sc_job_clear(job);
    return status;
}

static void refuses(const char *text, const char *message)
{
    sc_job job;
    const sc_status status = load(text, NULL, NULL, &job);

    if (status != SC_ERR_DATA || said.errors != 1 || !strstr(said.text, message))
        fail_msg("status %d, \"%s\"; expected \"%s\"", status, said.text, message);
}

/* What is no YAML is told by line and column, with what stands there and what to write instead, not
 * in the words of libyaml. */
TEST(what_is_no_yaml_is_told_in_words_of_the_user)
{
    static const char in_quotes[] = "put it in quotes", indented[] = "indented like those above";

    refuses(
        "volume: phantom\ntissues:\n  *atri*: {}\n",
        "job.yaml:3:3: not YAML: \"*atri*: {}\": a name or value that begins with * needs quotes");
    refuses("volume: phantom\ntissues:\n  *: {}\n", "job.yaml:3:3: not YAML: \"*: {}\": a name or");
    refuses("volume: phantom\ntissues:\n  *atrium: {}\n", "needs quotes: \"*atrium\"");
    refuses("volume: @x\n", "job.yaml:1:9: not YAML: \"@x\": no key or value begins so");
    refuses("volume: %x\n", in_quotes);
    refuses("volume: phantom\noutput:\n\tfps: 3\n", "not with tabs");
    refuses("volume: !x phantom\n", "a value that begins with ! needs quotes");
    refuses("volume: phantom\n  bad indent: 1\n", "job.yaml:2:13: not YAML: \": 1\": a second");
    refuses("volume: a: b\n", "put a value that holds \": \" in quotes");
    refuses("volume: phantom\noutput: {fps: 3\nrender: {}\n",
            "job.yaml:2:9: not YAML: \"{fps: 3\": this { is not closed");
    refuses("volume: phantom\noutput: {size: [3, 4}\n", "this [ is not closed by ]");
    refuses("# caf\xc3\xa9\nvolume: \"phantom\n",
            "job.yaml:2:9: not YAML: \"\"phantom\": this quote");
    refuses("volume: phantom\noutput\nrender: {}\n",
            "job.yaml:2:1: not YAML: \"output\": expected \"key");
    refuses("volume: phantom\noutput:\n    fps: 3\n  size: 4\n", indented);
    refuses("volume: phantom\nanimation:\n   - a\n  - b\n", indented);
    refuses("volume: \"a\\q\"\n", "an unknown escape in double quotes");
    refuses("volume: - y\n", "an item of a list");
    refuses("volume: |x\n  phantom\n", "begins in the next line");
    refuses("volume: \"\xc3\xa9\" \x01\n", "job.yaml:1:");
    refuses("volume: phantom\nlabels: \xff\n", "job.yaml:2:9: not YAML: \"\\xff\": not UTF-8");
    refuses("volume: phantom\n...\nfoo\n", "a job is one document");
    refuses("%YAML 9.1\nvolume: phantom\n", "%YAML 1.1");
    refuses("%\n%\n%\n%\n%\n%\n%\n%\n%\n%\n%\n%\n%\n%\n%\n%\n%\n",
            "more than 16 lines that begin with %");
}

/* A NUL byte would end the text there, so that a value is silently another one. */
TEST(a_nul_byte_is_refused_with_its_line)
{
    refuses("volume: phantom\nlabels: \"heart.ctbl\\0.txt\"\n",
            "job.yaml:2: \"heart.ctbl\\0...\" holds a NUL byte");
    refuses("volume: phantom\n\"labels\\0\": x\n", "job.yaml:2: \"labels\\0...\" holds a NUL byte");
}

/* @return whether two jobs change their volume in the same way. */
static bool same_edits(const sc_job *a, const sc_job *b)
{
    if (a->volume.tissue_count != b->volume.tissue_count || a->given.keep != b->given.keep ||
        a->given.merge != b->given.merge || a->given.resample != b->given.resample ||
        memcmp(a->volume.resample_mm, b->volume.resample_mm, sizeof a->volume.resample_mm) != 0 ||
        a->given.box != b->given.box || a->volume.box.kind != b->volume.box.kind ||
        a->volume.box.visible != b->volume.box.visible ||
        a->volume.box.margin_mm != b->volume.box.margin_mm || a->volume.level != b->volume.level ||
        a->given.volume_size != b->given.volume_size ||
        memcmp(a->volume.size, b->volume.size, sizeof a->volume.size) != 0 ||
        memcmp(a->volume.box.voxels, b->volume.box.voxels, sizeof a->volume.box.voxels) != 0 ||
        memcmp(a->volume.box.corners, b->volume.box.corners, sizeof a->volume.box.corners) != 0)
        return false;
    for (size_t i = 0; i < a->volume.tissue_count; i++) {
        if (strcmp(a->volume.tissues[i].pattern, b->volume.tissues[i].pattern) != 0 ||
            strcmp(a->volume.tissues[i].into, b->volume.tissues[i].into) != 0)
            return false;
    }
    return true;
}

/* A volume may be a map; what it says comes back from the text that is written of it. */
TEST(what_is_changed_of_a_volume_is_read_and_written)
{
    static const char *const jobs[] = {
        "volume: {path: phantom}\n",
        "volume: {path: phantom, keep: aorta}\n",
        "volume: {path: phantom, keep: [aorta, 12, \"left *\"], box: visible}\n",
        "volume: {keep: [b], path: phantom, merge: {b: [aorta, 'l\"eft'], walls: '*wall'}}\n",
        "volume: {path: phantom, box: [[0, 7], [3, 4], [1, 9], visible + 2.5 mm]}\n",
        "volume: {path: phantom, box: [[-1, 2.25, 3], [10, -20, 30], visible]}\n",
        "volume: {path: phantom, resample: 30x20x10}\n",
        "volume: {path: phantom, level: 2, box: [[0, 7], [3, 4], [128, 2147483647]]}\n",
        "volume: {path: phantom, box: visible, resample: 0.25 mm}\n",
        "volume: {path: phantom, resample: [0.5, 1, 2 mm]}\n",
        "volume: {path: phantom, box: [[-1, 2.25, 3], [10, -20, 30]]}\n"};

    for (size_t i = 0; i < SC_COUNT_OF(jobs); i++) {
        SC_OWN(sc_text_clear) sc_text written = {0};
        SC_OWN(sc_job_clear) sc_job job = {0}, again = {0};

        assert_ok(load(jobs[i], NULL, NULL, &job));
        assert_string_equal(job.volume.path, "phantom");
        assert_ok(sc_job_write(&quiet, &job, false, &written));
        assert_ok(load(written.data, NULL, NULL, &again));
        assert_true(same_edits(&job, &again));
        if (i == 3) { /* those that are kept stand last, whatever came first */
            assert_int_equal(job.volume.tissue_count, 4);
            assert_string_equal(job.volume.tissues[3].pattern, "b");
            assert_string_equal(job.volume.tissues[3].into, "");
            assert_string_equal(job.volume.tissues[2].into, "walls");
        }
    }
    refuses("volume: {keep: aorta}\n", "the key \"path\" is missing");
    refuses("volume: {path: phantom, keep: []}\n", "expected a list of tissues");
    refuses("volume: {path: phantom, merge: [a]}\n", "expected {name: [tissues], ...}");
    refuses("volume: {path: phantom, merge: {\"\": [a]}}\n", "name of a merged tissue has 0 bytes");
    refuses("volume: {path: phantom, merge: {\"8\": [a]}}\n", "merged tissue is the number 8");
    refuses("volume: {path: phantom, merge: {a: {b: c}}}\n", "expected {name: [tissues], ...}");
    refuses("volume: {path: phantom, box: visible+5}\n", "box is \"visible+5\", expected visible");
    refuses("volume: {path: phantom, box: visible+-5mm}\n", "expected visible");
    refuses("volume: {path: phantom, box: visible+1e99 mm}\n", "expected visible");
    refuses("volume: {path: phantom, box: visible + 0x10 mm}\n", "expected visible");
    refuses("volume: {path: phantom, box: [1, 2]}\n", "expected visible");
    refuses("volume: {path: phantom, box: [[1, 2, 3], [4, .nan, 5]]}\n", "expected");
}

/* A map finds its members by a hash table: all of them, and one that is given twice. */
TEST(a_long_map_finds_all_its_members)
{
    enum { MEMBERS = 5000 };
    static char text[MEMBERS * 24 + 64];
    size_t used = (size_t)snprintf(text, sizeof text, "volume: phantom\ntissues:\n");
    SC_OWN(sc_job_clear) sc_job job = {0};

    for (int i = 0; i < MEMBERS; i++)
        used += (size_t)snprintf(text + used, sizeof text - used, "  t%d: {opacity: 0.5}\n", i);
    assert_ok(load(text, NULL, NULL, &job));
    assert_int_equal(job.tissues.rule_count, MEMBERS);
    for (int i = 0; i < MEMBERS; i++)
        assert_int_equal(atoi(job.tissues.rules[i].pattern + 1), i);
    snprintf(text + used, sizeof text - used, "  t77: {}\n");
    refuses(text, "job.yaml:5003: key \"t77\" is given twice (first in line 80)");
}

TEST(mistakes_are_named_with_line_and_nearest_name)
{
    refuses("volume: phantom\noutptu: {}\n", "job.yaml:2: unknown key \"outptu\"; did you mean "
                                             "\"output\"?");
    refuses("volume: phantom\noutput:\n  crf: 99\n", "job.yaml:3: crf is \"99\", expected a "
                                                     "number from 0 to 51");
    refuses("volume: phantom\noutput: {crf: 1.5}\n", "expected a whole number");
    refuses("volume: phantom\nrender: {skip: interor}\n", "job.yaml:2: unknown skip \"interor\"; "
                                                          "did you mean \"interior\"?");
    refuses("volume: phantom\nvolume: x\n", "job.yaml:2: key \"volume\" is given twice (first in "
                                            "line 1)");
    refuses("volume: &a phantom\nlabels: *a\n", "job.yaml:2: aliases");
    refuses("output: {fps: 25}\n", "the key \"volume\" is missing");
    refuses("volume: phantom\nrender: {smooth: 3}\n",
            "smooth is \"3\", expected auto, a number from 0 to 2.5, or three such in a list");
    refuses("volume: phantom\nrender: {mode: paper}\n", "unknown key \"mode\"");
    refuses("volume: phantom\nlight: {ambiant: 1}\n", "did you mean \"ambient\"?");
    refuses("volume: phantom\nanimation: {clip: [{normal: [0, 0, 0]}]}\n", "normal");
    refuses("volume: phantom\nanimation: {clip: [{box: [[50%, 0%, 0%], [40%, 100%, "
            "100%]]}]}\n",
            "the box is empty along its axis 1");
    refuses("volume: phantom\nanimation: {clip: [{box: [[0%,0%,0%],[1%,1%,1%]]}, {box: "
            "[[0%,0%,0%],[1%,1%,1%]]}, {box: "
            "[[0%,0%,0%],[1%,1%,1%]]}]}\n",
            "more than 16 clip planes");
    refuses("- 1\n- 2\n", "expected a map of keys");
    refuses("volume: phantom\n---\nvolume: x\n", "a second document");
    refuses("volume: [1, 2]\n", "volume is a series of 2 files; expected cine");
    refuses("volume: phantom\noutput: {size: [100]}\n", "expected [width, height]");
    refuses("volume: phantom\noutput: {size: [100, 8]}\n",
            "size is [100, 8], expected [width, height] or WxH in pixels");
    refuses("volume: phantom\noutput: {video: film.avi}\n", "job.yaml:2: video is \"film.avi\"");
    refuses("volume: phantom\ntissues: {a: {opacity: 2}}\n", "a number from 0 to 1");
    refuses("volume: phantom\ntissues: {a: {opacity: atuo}}\n",
            "auto, a number from 0 to 1, or key frames");
    refuses("volume: phantom\ntissues: {a: {colour: red}}\n", "did you mean \"color\"?");
    refuses("volume: phantom\ntissues: {a: {color: rde}}\n", "did you mean \"red\"?");
    refuses("volume: phantom\ntissues: {a: {color: '#-1-1-1'}}\n", "#rrggbb");
    refuses("volume: phantom\nanimation: {camera: {orbit: {axis: superoir}}}\n",
            "did you mean \"superior\"?");
    refuses("volume: phantom\nanimation: {camera: {orbit: {axis: [0, 0, 0]}}}\n", "length zero");
    refuses("volume: phantom\nanimation: {camera: {fixed: {up: left, target_mm: [1, 2, 3]}}}\n",
            "fixed: the key \"position_mm\" is missing");
    refuses("volume: phantom\nanimation:\n  clip:\n    - {at: 0%}\n",
            "job.yaml:4: the key \"normal or box\" is missing");
    refuses("volume: phantom\nanimation: {clip: [{normal: [0, 0, 0], at: {0%: 0%, 100%: "
            "50%}}]}\n",
            "length zero");
    refuses("volume: phantom\nanimation: {clip: [{normla: left}]}\n", "did you mean \"normal\"?");
    refuses("volume: phantom\nanimation: {clip: [{normal: left, at: {0%: 0%, 100%: half}}]}\n",
            "a position such as 40% or 12 mm");
}

/* Load a job file with several mistakes, with a wrong setting beside it. @return how many errors
 * are logged. */
static int count_mistakes(const char *text, const char *setting, sc_status expected)
{
    SC_OWN(sc_job_clear) sc_job job = {0};

    assert_int_equal(load(text, setting, NULL, &job), expected);
    return said.errors;
}

/* All mistakes of a job are told in one go: reading goes on after each of them. */
TEST(all_mistakes_are_told)
{
    assert_int_equal(count_mistakes("volum: phantom\noutput: {fps: fast, size: [640], x: 1}\n"
                                    "tissues: {a: {color: rde, opactiy: 1}, b: 3}\n",
                                    NULL, SC_ERR_DATA),
                     7);
    assert_int_equal(
        count_mistakes("volume: phantom\nanimation:\n  frames: 0\n  clip:\n"
                       "    - {at: {0%: 0, 1%: 0.6}, except: [a, [b], {c: 1}]}\n"
                       "    - {normla: left, except: 3}\n    - {box: [[1, 2, 3], [0%, 0%, 0%]]}\n",
                       NULL, SC_ERR_DATA),
        9);
    assert_int_equal(
        count_mistakes("volume: phantom\nlight: {key: 9}\n", "rendr.x=1", SC_ERR_USAGE), 2);
    /* Behind a key that is given twice, too, in the file and in a setting. */
    assert_int_equal(count_mistakes("volume: phantom\nvolume: x\nlight: {key: 9, key: 8, fil: 1}\n"
                                    "tissues: {a: {color: rde}, a: {color: red}}\n",
                                    "output={fps: 1, fps: 2}", SC_ERR_DATA),
                     7);
    assert_int_equal(count_mistakes("volume: phantom\noutput: {video: a.avi}\nlight: {key: 9}\n",
                                    "animation.frames=0", SC_ERR_DATA),
                     3);
}

/* Of very many mistakes only the first are shown, and their number is told. */
TEST(the_number_of_messages_is_bounded)
{
    SC_OWN(sc_text_clear) sc_text text = {0};

    assert_ok(sc_text_add(&quiet, &text, "volume: phantom\n"));
    for (int i = 0; i < 500; i++)
        assert_ok(sc_text_add(&quiet, &text, "key%d: 1\n", i));
    assert_int_equal(count_mistakes(text.data, NULL, SC_ERR_DATA), 50);
    assert_non_null(strstr(said.text, "450 further mistakes of the job are not shown"));
}

/* Ways to write the same color, size or length give the same job, and so the same identity. */
TEST(values_are_written_in_many_ways)
{
    static const char *const same[][2] = {
        {"render: {background: [255, 51, 51]}", "render: {background: [1.0, .2, .2]}"},
        {"render: {background: [255, 0, 0]}", "render: {background: red}"},
        {"render: {background: [255, 0, 0]}", "render: {background: '#f00'}"},
        {"render: {background: [255, 0, 0]}", "render: {background: \"#FF0000\"}"},
        {"render: {background: [139, 0, 0]}", "render: {background: Dark Red}"},
        {"render: {background: [1, 2, 3]}", "render: {background: '#010203'}"},
        {"render: {background: [0, 0, 0]}", "render: {background: [0.0, 0, 0]}"},
        {"output: {size: [1920, 1080]}", "output: {size: 1080p}"},
        {"output: {size: [1080, 1920]}", "output: {size: portrait}"},
        {"output: {size: [1920, 1080]}", "output: {size: 1920 \xc3\x97 1080}"},
        {"output: {size: [640, 480]}", "output: {size: 640*480}"},
        {"output: {size: [3840, 2160]}", "output: {size: 4K}"},
        {"output: {size: [1080, 1920]}", "output: {size: vertical}"},
        {"output: {size: [640, 480]}", "output: {size: 640 x 480}"},
        {"animation: {frames: 300}", "animation: {frames: 10s}"},
        {"animation: {frames: 15}", "animation: {frames: 500 ms}"},
        {"output: {fps: 24}\nanimation: {frames: 2160}",
         "animation: {frames: 1.5min}\noutput: {fps: 24}"},
    };
    sc_job job;

    for (size_t i = 0; i < SC_COUNT_OF(same); i++) {
        char text[2][256];
        sc_text written[2] = {{0}, {0}};

        for (int j = 0; j < 2; j++) {
            snprintf(text[j], sizeof text[j], "volume: phantom\n%s\n", same[i][j]);
            if (load(text[j], NULL, NULL, &job) != SC_OK || said.errors)
                fail_msg("%s: %s", text[j], said.text);
            assert_ok(sc_job_write(&quiet, &job, true, &written[j]));
            sc_job_clear(&job);
        }
        assert_string_equal(written[0].data, written[1].data);
        sc_text_clear(&written[0]);
        sc_text_clear(&written[1]);
    }
}

/* What was silently taken for something else is refused, with what was meant. */
TEST(what_is_meant_otherwise_is_told)
{
    sc_job job;

    refuses("volume: phantom\nanimation: {camera: {orbit: {turns: 360}}}\n",
            "360 degrees are turns: 1");
    refuses("volume: phantom\nanimation: {clip: [{normal: left, at: {0%: 0%, 100%: 60}}]}\n",
            "60% or 60 mm");
    refuses("volume: phantom\nanimation: {clip: [{normal: left, at: {0%: 0%, 100%: 0.6}}]}\n",
            "60% or 0.6 mm");
    refuses("volume: phantom\nanimation: {camera: {orbit: {}, fixed: {position_mm: [1, 2, 3], "
            "target_mm: [0, 0, 0]}}}\n",
            "both \"orbit\" and \"fixed\" are given");
    refuses("volume: phantom\nanimation: {frames: 1 ms}\n", "makes 0 frames");
    refuses("volume: phantom\nrender: {background: [1.0, .2, 200]}\n", "not both");
    refuses("volume: phantom\nrender: {background: #ff0000\n }\n", "needs quotes");
    refuses("volume: phantom\noutput: {directory: ~/out}\n", "only a shell replaces");
    assert_ok(load("volume: phantom\nrender: {background: [1, 0, 0]}\n", NULL, NULL, &job));
    assert_non_null(strstr(said.text, "almost black"));
    sc_job_clear(&job);
    assert_ok(load("volume: phantom\n", "tissues.a.color=#ff0000", NULL, &job));
    assert_int_equal(job.tissues.rules[0].rgb[0], 255);
    sc_job_clear(&job);
    assert_ok(load("volume: phantom\nanimation: {frames: 9}\n", "animation.frames=1s", NULL, &job));
    assert_int_equal(job.animation.frames, 30);
    sc_job_clear(&job);
    assert_ok(load("volume: phantom\nanimation: {camera: {orbit: {turns: 3}}, frames: 3}\n", NULL,
                   NULL, &job));
    sc_job_clear(&job);
}

TEST(nesting_is_bounded)
{
    char text[400] = "volume: ";
    sc_job job;

    for (int i = 0; i < 100; i++)
        strcat(text, "[");
    assert_int_equal(load(text, NULL, NULL, &job), SC_ERR_DATA);
    assert_non_null(strstr(said.text, "nested more than"));
}

static const char full[] =
    "volume: data/heart.nrrd\nlabels: /abs/heart.ctbl\n"
    "output: {directory: out, size: [640, 480], fps: 25, video: a.mkv, frames: png}\n"
    "render: {skip: none, background: \"#102030\", caps: none, quality: draft, step: 0.25}\n"
    "tissues:\n  \"myo*\": {color: [1, 2, 3], opacity: 0.35}\n  7: {visible: false}\n"
    "animation:\n  frames: 12\n"
    "  camera: {orbit: {axis: left, turns: 2, target_mm: [1, 2, 3]}, projection: orthographic,"
    " zoom: {0%: 1, 100%: 2, ease: in}}\n"
    "  clip_mode: cut\n  clip:\n"
    "    - {normal: anterior, at: {20%: 10%, 80%: -4 mm}, "
    "except: [coronary*, \"9\"]}\n    - {normal: [0, 3, 4], at: 50%, active: {1f: "
    "true, 50%: false}}\n"
    "  verbs:\n"
    "    - {fade: \"myo*\", to: 0.25, during: [1f, 5f], ease: linear}\n"
    "    - {appear: [9, \"a: b\"], order: cranial, stagger: 40%}\n"
    "    - {pulse: [7], to: 30%, times: 2}\n"
    "    - {frame: [4], ease: [0, 0.25, 0.5, 1]}\n"
    "    - {orbit: 30, elevation: -4}\n"
    "    - {rock: 5, times: 3}\n    - {zoom: 3}\n"
    "overlays:\n  time: top-right\n  caption:\n"
    "    top-left: {0f: none, 1f: \"a\\nb: \\\"c\\\"\", 5f: none}\n"
    "    bottom: The heart\n"
    "farm: {tile: 16}\n";

static void expect_verbs(const sc_job *job)
{
    assert_int_equal(job->verbs.count, 7);
    assert_int_equal(job->verbs.tissue_count, 5);
    assert_string_equal(job->verbs.tissues[0].pattern, "myo*");
    assert_string_equal(job->verbs.tissues[2].pattern, "a: b");
    assert_int_equal(job->verbs.tissues[2].of, 1);
    assert_int_equal(job->verbs.tissues[3].of, 2);
    assert_int_equal(job->verbs.list[0].kind, SC_VERB_FADE);
    assert_near(job->verbs.list[0].to, 0.25, 0);
    assert_true(!job->verbs.list[0].to_factor);
    assert_near(job->verbs.list[0].begin, 1 / 11.0, 1e-10);
    assert_int_equal(job->verbs.list[0].ease.kind, SC_EASE_LINEAR);
    assert_int_equal(job->verbs.list[1].kind, SC_VERB_APPEAR);
    assert_int_equal(job->verbs.list[1].order, SC_ORDER_SUPERIOR);
    assert_near(job->verbs.list[1].stagger, 0.4, 1e-12);
    assert_int_equal(job->verbs.list[1].ease.kind, SC_EASE_SMOOTH);
    assert_int_equal(job->verbs.list[2].times, 2);
    assert_true(job->verbs.list[2].to_factor);
    assert_near(job->verbs.list[2].to, 0.3, 1e-12);
    assert_int_equal(job->verbs.list[3].kind, SC_VERB_FRAME);
    assert_int_equal(job->verbs.list[3].ease.kind, SC_EASE_BEZIER);
    assert_near(job->verbs.list[3].ease.bezier[1], 0.25, 0);
    assert_near(job->verbs.list[4].angle_deg, 30, 0);
    assert_near(job->verbs.list[4].elevation_deg, -4, 0);
    assert_int_equal(job->verbs.list[5].times, 3);
    assert_near(job->verbs.list[6].to, 3, 0);
}

static void expect_overlays(const sc_job *job)
{
    assert_int_equal(job->overlays.time, SC_PLACE_TOP_RIGHT);
    assert_int_equal(job->overlays.scale_bar, SC_PLACE_NONE);
    assert_string_equal(job->overlays.font, "DejaVu Sans");
    assert_int_equal(job->overlay_lists.caption_count, 2);
    assert_string_equal(job->overlay_lists.captions[1].text, "The heart");
    assert_int_equal(job->overlay_lists.captions[1].place, SC_PLACE_BOTTOM);
    assert_string_equal(job->overlay_lists.captions[0].text, "a\nb: \"c\"");
    assert_int_equal(job->overlay_lists.captions[0].place, SC_PLACE_TOP_LEFT);
    assert_near(job->overlay_lists.captions[0].begin, 1 / 11.0, 1e-10);
    assert_near(job->overlay_lists.captions[0].end, 5 / 11.0, 1e-10);
}

static void expect_full(const sc_job *job)
{
    assert_int_equal(job->output.size_px[1], 480);
    assert_int_equal(job->output.frames, SC_FRAMES_PNG);
    assert_int_equal(job->render.skip, SC_SKIP_NONE);
    assert_int_equal(job->render.background.rgb[2], 0x30);
    assert_int_equal(job->tissues.rule_count, 2);
    assert_string_equal(job->tissues.rules[1].pattern, "7");
    assert_true(job->tissues.rules[1].has.visible && !job->tissues.rules[1].visible);
    assert_near(job->animation.camera.axis.x, -1, 0);
    assert_true(job->animation.camera.has_target);
    assert_int_equal(job->animation.camera.projection, SC_ORTHOGRAPHIC);
    assert_near(job->animation.camera.tracks.zoom.keys[1].value.x, 2, 0);
    assert_int_equal(job->animation.clip_mode, SC_CLIP_CUT);
    assert_int_equal(job->animation.sweep_count, 2);
    assert_true(job->animation.sweeps[0].at.percent);
    assert_near(job->animation.sweeps[0].at_track.keys[0].at, 0.2, 1e-12);
    assert_near(job->animation.sweeps[1].normal.z, 0.8, 1e-12);
    assert_true(!job->animation.sweeps[0].has_active && job->animation.sweeps[1].has_active);
    assert_int_equal(job->animation.sweeps[1].active_track.count, 2);
    assert_near(job->animation.sweeps[1].active_track.keys[0].at, 1 / 11.0, 1e-10);
    assert_near(job->animation.sweeps[1].active_track.keys[0].value.x, 1, 0);
    assert_int_equal(job->tissues.exception_count, 2);
    assert_string_equal(job->tissues.exceptions[0].pattern, "coronary*");
    expect_verbs(job);
    expect_overlays(job);
}

TEST(wrong_captions_are_refused)
{
    static const struct {
        const char *captions, *message;
    } cases[] = {
        {"[a, b]", "caption is [a, b], expected a text, key frames such as"},
        {"{tpo: a}", "unknown caption \"tpo\"; did you mean \"top\"?"},
        {"{top: a, tpo: b}", "unknown caption \"tpo\"; did you mean \"top\"?"},
        {"{1s: a, top: b}", "caption: \"top\" is no time of the animation"},
        {"{top: [a]}", "caption"},
        {"{}", "caption has 0 key frames"},
        {"\"\"", "caption has no value, expected a text, or none"},
        {"\"bell \\a\"", "as its character 6, U+0007, which is a control character"},
        {"\"\\u202eabc\"", "U+202E, which is a control character"},
        {"\"\\u05d0\"", "U+05D0, which is of a script that is written from right to left"},
        {"\"1\\n2\\n3\\n4\\n5\\n6\\n7\\n8\\n9\"", "has 9 lines, expected at most 8"},
        {"{0s: none, 10.1%: a, 10.2%: none}", "is shown in no frame"},
        {"{2s: a, 1s: b}", "caption: the key frame at 1s does not come after that at 2s"},
        {"{0s: none, 5s: a, 99s: none}", "99s is behind the end of the animation"},
    };
    char text[256];

    for (size_t i = 0; i < SC_COUNT_OF(cases); i++) {
        snprintf(text, sizeof text, "volume: phantom\noverlays: {caption: %s}\n",
                 cases[i].captions);
        refuses(text, cases[i].message);
    }
    refuses("volume: phantom\noverlays: {time: middle}\n", "time");
    refuses("volume: phantom\noverlays: {font: \"\"}\n", "expected the name of a family of fonts");
}

/* A text that is too long is told by its length, and not shown. */
TEST(long_captions_are_refused)
{
    char text[10100] = "volume: phantom\noverlays: {caption: ";
    const size_t begin = strlen(text);

    memset(text + begin, 'a', 10000);
    strcpy(text + begin + 10000, "}\n");
    refuses(text, "caption has 10000 bytes, expected at most 511");
}

TEST(wrong_verbs_are_refused)
{
    static const struct {
        const char *verb, *message;
    } cases[] = {
        {"{fad: aorta}", "job.yaml:4: unknown key \"fad\"; did you mean \"fade\"?"},
        {"{to: 0}", "job.yaml:4: a verb has one of the keys fade, appear, pulse"},
        {"{fade: []}", "fade is [], expected a tissue or a list of tissues"},
        {"{fade: {a: 1}}", "expected a tissue or a list of tissues"},
        {"{fade: [a, [b]]}", "expected a tissue or a list of tissues"},
        {"{fade: a, to: 2}", "to is \"2\", expected an opacity from 0 to 1"},
        {"{fade: a, to: -10%}", "to is \"-10%\", expected an opacity from 0 to 1"},
        {"{fade: a, to: 1001%}", "to is \"1001%\", expected an opacity from 0 to 1"},
        {"{fade: a, to: \"%\"}", "to is \"%\", expected an opacity"},
        {"{appear: a, stager: 1}", "unknown key \"stager\"; did you mean \"stagger\""},
        {"{fade: a, stagger: 10%}", "unknown key \"stagger\""},
        {"{appear: a, order: upwards}", "order"},
        {"{appear: a, stagger: 0.5}", "stagger is \"0.5\", expected a share"},
        {"{pulse: a, times: 0}", "times is"},
        {"fade", "expected a verb such as"},
        {"{fade: a, pulse: a}", "job.yaml:4: a verb has one of the keys fade, appear"},
        {"{rock: 40000}", "rock is \"40000\", expected a number from -36000 to 36000"},
        {"{rock: 20, times: 0}", "times is \"0\", expected a number from 1 to 1000"},
        {"{zoom: 0}", "zoom is \"0\", expected a number from 0.01 to 1000"},
        {"{dolly: 50%}", "dolly is \"50%\", expected a number from 0.01 to 100"},
        {"{hold: orbit, during: [2s, 3s], soft: 60%}", "job.yaml:4: hold: soft is more than 50%"},
        {"{hold: camera, during: [1s, 2s]}", "hold"},
        {"{hold: orbit, soft: 0%}", "job.yaml:4: hold: it lasts for the whole animation"},
        {"{hold: orbit}", "job.yaml:4: hold: it lasts for the whole animation"},
        {"{fade: a, during: [2s, 70s]}", "70s is behind the end of the animation"},
    };
    char text[256];

    for (size_t i = 0; i < SC_COUNT_OF(cases); i++) {
        snprintf(text, sizeof text, "volume: phantom\nanimation:\n  verbs:\n  - %s\n",
                 cases[i].verb);
        refuses(text, cases[i].message);
    }
    refuses("volume: phantom\nanimation:\n  verbs:\n  - {hold: orbit, during: [1s, 3s]}\n"
            "  - {hold: orbit, during: [2s, 4s]}\n",
            "job.yaml:5: hold: it overlaps with another hold");
    refuses("volume: phantom\nanimation:\n  verbs:\n  - {fly: aorta, during: [0%, 60%]}\n"
            "  - {fly: aorta, during: [50%, 90%]}\n",
            "job.yaml:5: fly: it overlaps with another fly");
    refuses("volume: phantom\nanimation:\n  camera: {orbit: {turns: 0}}\n  verbs:\n"
            "  - {hold: orbit, during: [1s, 3s]}\n",
            "job.yaml:5: hold: the camera does not turn by itself");
    refuses("volume: phantom\nanimation:\n  camera: {projection: orthographic}\n  verbs:\n"
            "  - {dolly: 0.5}\n",
            "job.yaml:5: dolly: it changes nothing in an orthographic picture");
    refuses("volume: phantom\nanimation: {verbs: {}}\n",
            "verbs is a map, expected a list of verbs");
    refuses("volume: phantom\nanimation: {verbs: [fade]}\n", "expected a verb such as {fade: skin");
}

/* Times are shares of the way from the first frame to the last: frame k of N is at k / (N - 1). */
TEST(parts_of_the_animation_may_be_times)
{
    static const struct {
        const char *part;
        double begin, end; /* in frames, of 101 */
    } cases[] = {
        {"[20%, 80%]", 20, 80},    {"[30f, 60 frames]", 30, 60}, {"[0f, 1 frame]", 0, 1},
        {"[1s, 2.5 s]", 10, 25},   {"[500ms, 0:10]", 5, 100},    {"[0:01.5, 0.15 min]", 15, 90},
        {"[10%, 10.1s]", 10, 100}, {"[100f, 101f]", 100, 100},   {"[0:00, 0:00:05]", 0, 50}};

    for (size_t i = 0; i < SC_COUNT_OF(cases); i++) {
        char text[256];
        SC_OWN(sc_job_clear) sc_job job = {0}, again = {0};
        SC_OWN(sc_text_clear) sc_text written = {0};

        snprintf(text, sizeof text,
                 "volume: phantom\noutput: {fps: 10}\nanimation: {frames: 10.1s, verbs: ["
                 "{zoom: 2, during: %s}]}\n",
                 cases[i].part);
        assert_int_equal(load(text, NULL, NULL, &job), SC_OK);
        assert_near(job.verbs.list[0].begin, cases[i].begin / 100, 1e-11);
        assert_near(job.verbs.list[0].end, cases[i].end / 100, 1e-11);
        assert_true(job.verbs.list[0].begin <=
                    cases[i].begin / 100); /* a jump there is not a frame late */
        assert_ok(sc_job_write(&quiet, &job, false, &written));
        assert_int_equal(load(written.data, NULL, NULL, &again), SC_OK);
        assert_near(again.verbs.list[0].begin, job.verbs.list[0].begin, 0);
        assert_near(again.verbs.list[0].end, job.verbs.list[0].end, 0);
    }
}

TEST(wrong_times_are_refused)
{
    static const char *const wrong[] = {
        "[1, 2]",       "[3s, 1s]",    "[1:5, 0:09]", "[0:60, 0:09]",      "[-1s, 2s]",
        "[1.2.3s, 4s]", "[1e1f, 12f]", "[1 h, 2 h]",  "[1:0:00, 1:00:01]", "[50%, 1s]"};
    char text[256];

    for (size_t i = 0; i < SC_COUNT_OF(wrong); i++) {
        snprintf(text, sizeof text,
                 "volume: phantom\nanimation: {frames: 900, verbs: [{zoom: 2, during: %s}]}\n",
                 wrong[i]);
        refuses(text, "expected two rising times of the animation");
    }
    refuses("volume: phantom\noutput: {fps: 25}\nanimation:\n  frames: 50\n  verbs:\n"
            "  - {zoom: 2, during: [1s, 3s]}\n",
            "job.yaml:6: during: 3s is behind the end of the animation, which has 50 frames at 25 "
            "frames per second: 2 s");
}

/* Load a job of 101 frames with that camera, whose map ends in the text, and write it as resolved;
 * the test fails if it is refused. */
static void load_camera(const char *camera, sc_text *written, sc_job *job)
{
    char text[512];

    snprintf(text, sizeof text, "volume: phantom\nanimation: {frames: 101, camera: {%s}\n", camera);
    assert_ok(load(text, NULL, NULL, job));
    assert_ok(sc_job_write(&quiet, job, false, written));
}

TEST(values_of_the_camera_may_have_key_frames)
{
    static const char camera[] =
        "orbit: {angle: {10f: 5, 0:02: {value: -7.5, ease: smooth}, 100%: {value: 9, ease: [0.1, "
        "0, 1, 0.5]}}, elevation: {0s: 130}, target_mm: {500ms: [1, 2, 3], 50%: [4, 5, 6]}, "
        "distance_mm: 200}, fov: {0%: 20}, zoom: {20%: 1, 40%: 3, ease: out}}";
    sc_text text = {0}, twice = {0};
    sc_job job, again;

    load_camera(camera, &text, &job);
    assert_ok(load(text.data, NULL, NULL, &again));
    assert_ok(sc_job_write(&quiet, &again, false, &twice));
    assert_string_equal(text.data, twice.data);
    for (const sc_job *j = &job; j; j = j == &job ? &again : NULL) {
        const sc_orbit *o = &j->animation.camera;

        assert_true(o->has_target && o->has_distance);
        assert_int_equal(o->tracks.angle.count, 3);
        assert_near(o->tracks.angle.keys[0].at, 0.1, 1e-10);
        assert_near(o->tracks.angle.keys[1].at, 0.6, 1e-10);
        assert_near(o->tracks.angle.keys[1].value.x, -7.5, 0);
        assert_int_equal(o->tracks.angle.keys[0].ease.kind, SC_EASE_LINEAR);
        assert_int_equal(o->tracks.angle.keys[1].ease.kind, SC_EASE_SMOOTH);
        assert_int_equal(o->tracks.angle.keys[2].ease.kind, SC_EASE_BEZIER);
        assert_near(o->tracks.angle.keys[2].ease.bezier[3], 0.5, 0);
        assert_int_equal(o->tracks.elevation.count, 1);
        assert_int_equal(o->tracks.target.count, 2);
        assert_near(o->tracks.target.keys[0].at, 0.15, 1e-10);
        assert_near(o->tracks.target.keys[1].value.z, 6, 0);
        assert_int_equal(o->tracks.distance.count, 0);
        assert_near(o->distance_mm, 200, 0);
        assert_int_equal(o->tracks.zoom.count, 2);
    }
    sc_text_clear(&text);
    sc_text_clear(&twice);
    sc_job_clear(&job);
    sc_job_clear(&again);
    load_camera("orbit: {}}, verbs: [{hold: orbit, during: [20%, 30%], soft: 10%}, {dolly: 0.25}]",
                &text, &job);
    assert_non_null(strstr(text.data, "- {hold: orbit, soft: 10%, during: [20%, 30%]}\n    - "
                                      "{dolly: 0.25, during: [0%, 100%], ease: smooth}"));
    sc_text_clear(&text);
    sc_job_clear(&job);
    load_camera("orbit: {angle: 30, target_mm: [1, 2, 3]}}", &text, &job);
    assert_true(job.animation.camera.angle_deg == 30 && job.animation.camera.turns == 1);
    sc_text_clear(&text);
    sc_job_clear(&job);
}

/* Parts of jobs with key frames beside those of the camera, and how they are written again. */
static const struct {
    const char *part, *written;
} scene_parts[] = {
    {"light: {key: {10f: 0.5, 100%: 1, ease: in}, head: 0.25, "
     "depth_cue: {0:01: 1}}",
     "  key: {10%: 0.5, 100%: {value: 1, ease: in}}\n"
     "  head: 0.25\n"},
    {"tissues: {aorta: {color: {50%: red, 2s: [1, 2, 3], ease: out}, "
     "opacity: 1}, \"*\": {color: blue}, wall: {color: {0:01: red}}}",
     "  \"aorta\": {color: {50%: [255, 0, 0], 60%: {value: [1, 2, 3], ease: out}}, opacity: 1}\n  "
     "\"*\": {color: [0, 0, 255]}\n  \"wall\": {color: {30%: [255, 0, 0]}}\n"},
    {"tissues: {aorta: {opacity: {1s: 1, 50%: 0.25, ease: smooth}, "
     "visible: {0%: false, 30f: true}, offset: {0s: [0, 0, 0], 3s: [10, 0, -5], ease: out}}, wall: "
     "{opacity: auto, visible: false, "
     "offset: "
     "[1, 2, 3]}}",
     "  \"aorta\": {opacity: {30%: 1, 50%: {value: 0.25, ease: smooth}}, visible: {0%: false, 30%: "
     "true}, offset: {0%: [0, 0, 0], 90%: {value: [10, 0, -5], ease: out}}}\n  \"wall\": "
     "{opacity: auto, visible: false, offset: [1, 2, 3]}\n"},
    {"light: {shadows: {0%: false, 100%: 0.5, ease: in}}",
     "  shadows: {0%: false, 100%: {value: 0.5, ease: in}}\n"},
    {"light: {shadows: 0.25}", "  shadows: 0.25\n"},
    {"tissues: {2s: {opacity: {1s: 1, 2s: 0}}, 50%: {visible: false}}",
     "  \"2s\": {opacity: {30%: 1, 60%: 0}}\n  \"50%\": {visible: false}\n"},
    {"tissues: {aorta: {interior_opacity: auto}}", "  \"aorta\": {interior_opacity: auto}\n"},
    {"image: {path: phantom, caps: {0s: 0, 3s: 1}}", "  caps: {0%: 0, 90%: 1}\n  slices: "
                                                     "0.7"},
    {"animation: {frames: 101, clip: [{normal: left, except: {0%: [aorta, \"l*\"], 1s: "
     "[], 60f: [wall]}}]}",
     "at: 50%, except: {0%: [\"aorta\", \"l*\"], 30%: [], 60%: [\"wall\"]}}\n"},
    {"animation: {frames: 101, clip: [{normal: left, at: {1s: 10%, 2s: -12 mm, ease: "
     "smooth}, except: [aorta]}, {normal: {0%: left, 50f: [0, 2, 0]}, active: false}, {normal: "
     "{50%: feet}, "
     "at: [1, 2, 3]}, {normal: head}], slices: {10f: [1, 2, 3]}}",
     "- {normal: [-1, 0, 0], at: {30%: 10%, 60%: {value: -12 mm, ease: smooth}}, "
     "except: [\"aorta\"]}\n    - {normal: {0%: [-1, 0, 0], 50%: [0, 1, 0]}, at: 50%, "
     "active: false, except: []}\n    - {normal: {50%: [0, 0, -1]}, at: "
     "[1, 2, 3], except: []}\n    - {normal: [0, 0, 1], at: 50%, except: []}"},
    {"animation: {frames: 101, clip: [{normal: left, at: {0%: 0%, 100%: 50%}, active: {1s: "
     "true, 2s: false}}]}",
     "at: {0%: 0%, 100%: 50%}, active: {30%: true, 60%: false}, except: []}\n"},
    {"animation: {frames: 101, slices: {10f: [1, 2, 3]}}", "slices: {10%: [1, 2, 3]}"},
    {"animation: {frames: 101, camera: {fixed: {position_mm: {0s: [1, 2, 3], 2s: [1, 2, 4]}, "
     "target_mm: [0, 0, 0], up: {0s: left, 60f: head, ease: out}}}}",
     "fixed: {position_mm: {0%: [1, 2, 3], 60%: [1, 2, 4]}, target_mm: [0, 0, 0], up: {0%: [-1, 0, "
     "0], 60%: {value: [0, 0, 1], ease: out}}}\n    projection: perspective\n    fov: 30\n"},
    {"render: {background: {0s: white, 2s: {value: \"#102030\", ease: smooth}, 99f: [1.0, 0, 0]}}",
     "  background: {0%: [255, 255, 255], 60%: {value: [16, 32, 48], ease: smooth}, 99%: [255, 0, "
     "0]}\n"},
};

TEST(values_of_the_scene_may_have_key_frames)
{
    char text[2048];

    for (size_t i = 0; i < SC_COUNT_OF(scene_parts); i++) {
        SC_OWN(sc_text_clear) sc_text first = {0}, twice = {0};
        SC_OWN(sc_job_clear) sc_job job = {0}, again = {0};

        snprintf(text, sizeof text, "volume: phantom\n%s\n%s", scene_parts[i].part,
                 strstr(scene_parts[i].part, "animation:") ? "" : "animation: {frames: 101}\n");
        assert_ok(load(text, NULL, NULL, &job));
        assert_ok(sc_job_write(&quiet, &job, false, &first));
        if (!strstr(first.data, scene_parts[i].written))
            fail_msg("%s is not in\n%s", scene_parts[i].written, first.data);
        assert_ok(load(first.data, NULL, NULL, &again));
        assert_ok(sc_job_write(&quiet, &again, false, &twice));
        assert_string_equal(first.data, twice.data);
    }
}

TEST(wrong_key_frames_of_the_scene_are_refused)
{
    static const char *const cases[][2] = {
        {"light: {key: {1s: 1, 10f: 2}}",
         "job.yaml:2: key: the key frame at 10f does not come after that at 1s"},
        {"light: {occlusion: {0s: 1.5}}", "is \"1.5\", expected a number from 0 to 1"},
        {"light: {head: {70s: 1}}", "70s is behind the end of the animation"},
        {"render: {background: {0s: white, 1s: auto}}",
         "job.yaml:2: background at 1s is \"auto\", expected a colour in key frames: auto and none "
         "hold"},
        {"render: {background: {0s: none}}", "is \"none\", expected a colour"},
        {"render: {background: {0s: bleu}}",
         "unknown background at 0s \"bleu\"; did you mean \"blue\"?"},
        {"tissues: {aorta: {color: {1s: red, 2s: auto}}}",
         "is \"auto\", expected a colour in key frames"},
        {"tissues: {aorta: {interior_opacity: {1s: 1}}}",
         "interior_opacity is a map, expected a number from 0 to 1"},
        {"tissues: {aorta: {opacity: {1s: 1, 2s: 2}}}",
         "job.yaml:2: opacity at 2s is \"2\", expected a number from 0 to 1"},
        {"tissues: {aorta: {opacity: {1s: auto}}}", "is \"auto\", expected a number from 0 to 1"},
        {"tissues: {aorta: {opacity: {2s: 0, 1s: 1}}}",
         "opacity: the key frame at 1s does not come after that at 2s"},
        {"tissues: {aorta: {visible: {1s: true, 2s: 0.5}}}", "is \"0.5\", expected true or false"},
        {"tissues: {aorta: {visible: {1s: {value: true, ease: smooth}}}}",
         "visible at 1s is a map, expected true or false"},
        {"tissues: {aorta: {offset: {1s: 3}}}", "is \"3\", expected [R, A, S]"},
        {"tissues: {aorta: {offset: 3 mm}}", "offset is \"3 mm\", expected [R, A, S]"},
        {"animation: {clip: [{normal: left, except: {1s: aorta}}]}",
         "is \"aorta\", expected a list of tissues, such as [aorta] or []"},
        {"animation: {clip: [{normal: left, except: {1s: [], 30f: []}}]}",
         "except: the key frame at 30f does not come after that at 1s"},
        {"light: {shadows: 1.5}", "shadows is \"1.5\", expected true, false, a number from 0 to 1"},
        {"tissues: {aorta: {color: {90s: red}}}", "90s is behind the end"},
        {"animation: {clip: [{normal: {0s: left, 1s: head, 2s: feet}}]}",
         "job.yaml:2: normal: the directions of key frames 2 and 3 are opposite, so that no way"},
        {"animation: {clip: [{normal: left, at: {1s: 10}}]}",
         "is \"10\", expected a unit behind the number: 10% or 10 mm"},
        {"animation: {clip: [{normal: left, at: {1s: 1%, 30f: 2%}}]}",
         "at: the key frame at 30f does not come after that at 1s"},
        {"animation: {clip: [{normal: {0s: lft}}]}",
         "unknown normal at 0s \"lft\"; did you mean \"left\"?"},
        {"animation: {slices: {0s: [3]}}", "slices at 0s is [3], expected [R, A"},
        {"animation: {slices: {0s: 3}}", "slices at 0s is \"3\", expected a share"},
        {"animation: {frames: 11, camera: {fixed: {position_mm: {0%: [10, 0, 0], 100%: [-10, 0, "
         "0]}, target_mm: [0, 0, 0]}}}",
         "job.yaml:2: position_mm and target_mm are the same point in frame 5"},
        {"animation: {camera: {fixed: {position_mm: [1, 2, 3], target_mm: [0, 0, 0], up: {0s: "
         "head, 1s: feet}}}}",
         "up: the directions of key frames 1 and 2 are opposite"},
        {"render: {background: {}}", "background has 0 key frames, expected 1 to 64"},
        {"render: {background: [1, 2]}", "background is [1, 2], expected auto, none, a name such"},
        {"light: {method: {0s: flat}}", "method is a map, expected a word"},
        {"light: {shadows: {0s: dark}}",
         "is \"dark\", expected true, false, or a number from 0 to 1"},
    };
    char text[512];

    for (size_t i = 0; i < SC_COUNT_OF(cases); i++) {
        snprintf(text, sizeof text, "volume: phantom\n%s\n", cases[i][0]);
        refuses(text, cases[i][1]);
    }
}

TEST(wrong_key_frames_are_refused)
{
    static const struct {
        const char *camera, *message;
    } cases[] = {
        {"elevation: {1s: 1, 500ms: 2}",
         "job.yaml:4: elevation: the key frame at 500ms does not come after that at 1s"},
        {"distance_mm: {0s: 1, 1s: 2, 30f: 3}",
         "distance_mm: the key frame at 30f does not come after that at 1s; expected rising times"},
        {"angle: {1s: 1, 70s: 2}", "70s is behind the end of the animation"},
        {"angle: {1: 1}", "angle: \"1\" is no time of the animation with its unit"},
        {"angle: {0s: {}}", "the key \"value\" is missing"},
        {"angle: {0s: {value: 0, eas: in}}", "unknown key \"eas\"; did you mean \"ease\"?"},
        {"angle: {0s: {value: 0, ease: smoth}}",
         "unknown ease \"smoth\"; did you mean \"smooth\"?"},
        {"angle: {0s: {value: 0, ease: [0, 0, 1, 1.5]}}",
         "ease is [0, 0, 1, 1.5], expected linear, smooth, in, out, or the points"},
        {"angle: {0s: {value: 0, ease: [0, 0, 1]}}", "expected linear, smooth, in, out, or"},
        {"angle: {0s: x}", "is \"x\", expected a number from -36000 to 36000"},
        {"angle: {}", "angle has 0 key frames, expected 1 to 64"},
        {"angle: {ease: in}", "angle has 0 key frames, expected 1 to 64"},
        {"angle: [1, 2]", "angle is [1, 2], expected a number from -36000 to 36000"},
        {"angle: {at: 1s}", "angle: \"at\" is no time of the animation"},
        {"target_mm: [1, 2]", "target_mm"},
        {"target_mm: {0s: 3}", "target_mm at 0s is \"3\""},
    };
    char text[512];

    for (size_t i = 0; i < SC_COUNT_OF(cases); i++) {
        snprintf(text, sizeof text, "volume: phantom\nanimation:\n  camera:\n    orbit: {%s}\n",
                 cases[i].camera);
        refuses(text, cases[i].message);
    }
}

/* A job that is written as resolved and read again is the same job. */
TEST(a_resolved_job_reads_back_the_same)
{
    SC_OWN(sc_job_clear) sc_job job = {0}, again = {0};
    SC_OWN(sc_text_clear) sc_text text = {0}, twice = {0};

    assert_ok(load(full, NULL, NULL, &job));
    expect_full(&job);
    assert_ok(sc_job_write(&quiet, &job, false, &text));
    assert_ok(load(text.data, NULL, NULL, &again));
    expect_full(&again);
    assert_ok(sc_job_write(&quiet, &again, false, &twice));
    assert_string_equal(text.data, twice.data);
}

TEST(the_command_line_beats_the_environment_beats_the_file)
{
    static const char text[] = "volume: phantom\nrender: {quality: draft}\n";
    sc_job job;

    assert_ok(load(text, NULL, NULL, &job));
    assert_int_equal(job.render.quality, SC_QUALITY_DRAFT);
    sc_job_clear(&job);
    assert_ok(load(text, NULL, "SEGCAST_RENDER_QUALITY=film", &job));
    assert_int_equal(job.render.quality, SC_QUALITY_FILM);
    sc_job_clear(&job);
    assert_ok(load(text, "render.quality=still", "SEGCAST_RENDER_QUALITY=film", &job));
    assert_int_equal(job.render.quality, SC_QUALITY_STILL);
    sc_job_clear(&job);
    assert_ok(load(text, "tissues.\"left atrium\".opacity=0.25", NULL, &job));
    assert_string_equal(job.tissues.rules[0].pattern, "left atrium");
    sc_job_clear(&job);
    assert_ok(load(full, "animation.clip.1.at=30%", NULL, &job));
    assert_near(job.animation.sweeps[1].at.value, 30, 0);
    sc_job_clear(&job);
    assert_int_equal(load(text, "render.quality=best", NULL, &job), SC_ERR_USAGE);
    assert_non_null(strstr(said.text, "render.quality=best"));
    assert_int_equal(load(text, "render.qaulity=film", NULL, &job), SC_ERR_USAGE);
    assert_int_equal(load(full, "animation.clip.5.at=30%", NULL, &job), SC_ERR_USAGE);
    assert_ok(load(text, NULL, "SEGCAST_RENDER_QAULITY=film", &job));
    assert_non_null(strstr(said.text, "names no key"));
    sc_job_clear(&job);
}

/* ---- the table of keys ---- */

/* Checks of one row, and the number of rows seen. */
static sc_status check_row(const sc_ctx *ctx, void *user, const sc_key_visit *visit)
{
    const sc_key *key = visit->key;
    char variable[256], path[256];
    size_t used = 0;

    ++*(int *)user;
    if (!key->help || !key->help[0] || key->help[strlen(key->help) - 1] == '.')
        fail_msg("%s: help \"%s\"", visit->path, key->help ? key->help : "");
    if (!key->keys && !key->required && !key->fallback && !key->without)
        fail_msg("%s: neither a default nor what happens without it", visit->path);
    if (key->type == &sc_type_choice && !key->words == !key->choices)
        fail_msg("%s: expected either words or choices", visit->path);
    for (const char *c = visit->path; *c; c++)
        variable[used++] = (char)(*c == '.' ? '_' : *c == 'N' ? '0' : toupper((unsigned char)*c));
    variable[used] = '\0';
    if (strstr(visit->path, ".NAME"))
        return SC_OK;
    assert_true(sc_setting_path(sc_job_keys, variable, path, sizeof path));
    for (char *c = path; *c; c++)
        *c = (char)(*c == '0' ? 'N' : *c);
    assert_string_equal(path, visit->path);
    return SC_OK;
}

/* Each row of the table has a help text and an environment variable, which names this row again. */
TEST(every_row_is_complete)
{
    int rows = 0;

    assert_ok(sc_keys_walk(&quiet, check_row, &rows));
    assert_true(rows > 80);
}

/* The text of a job as resolved, from the job file @p text and one setting or variable. */
static void resolve(const char *text, const char *setting, const char *variable, sc_text *out)
{
    SC_OWN(sc_job_clear) sc_job job = {0};

    sc_text_clear(out);
    if (load(text, setting, variable, &job) != SC_OK)
        fail_msg("%s %s: %s", setting ? setting : "", variable ? variable : "", said.text);
    assert_ok(sc_job_write(&quiet, &job, false, out));
}

/* Check that a setting of the command line, an environment variable and a line of the file give the
 * same job. */
static void expect_same_job(const char *setting, const char *variable, const char *file)
{
    SC_OWN(sc_text_clear) sc_text a = {0}, b = {0};

    resolve(file, NULL, NULL, &a);
    if (setting) {
        resolve("volume: phantom\n", setting, NULL, &b);
        assert_string_equal(a.data, b.data);
    }
    if (variable) {
        resolve("volume: phantom\n", NULL, variable, &b);
        assert_string_equal(a.data, b.data);
    }
}

TEST(nested_keys_are_set_in_every_way)
{
    expect_same_job("animation.camera.orbit.axis=left", "SEGCAST_ANIMATION_CAMERA_ORBIT_AXIS=left",
                    "volume: phantom\nanimation: {camera: {orbit: {axis: left}}}\n");
    expect_same_job("animation.camera.zoom=3", "SEGCAST_ANIMATION_CAMERA_ZOOM=3",
                    "volume: phantom\nanimation: {camera: {zoom: 3}}\n");
    expect_same_job(
        "animation.camera.fixed={position_mm: [1,2,3], target_mm: [4,5,6]}",
        "SEGCAST_ANIMATION_CAMERA_FIXED={position_mm: [1,2,3], target_mm: [4,5,6]}",
        "volume: phantom\nanimation: {camera: {fixed: {position_mm: [1,2,3], target_mm: "
        "[4,5,6]}}}\n");
    expect_same_job("animation.clip.0={normal: left, at: 10%}",
                    "SEGCAST_ANIMATION_CLIP_0={normal: left, at: 10%}",
                    "volume: phantom\nanimation: {clip: [{normal: left, at: 10%}]}\n");
    expect_same_job("animation.slices=[1, 2, 3]", "SEGCAST_ANIMATION_SLICES=1,2,3",
                    "volume: phantom\nanimation: {slices: [1, 2, 3]}\n");
    expect_same_job("tissues.7.opacity=0.5", "SEGCAST_TISSUES={7: {opacity: 0.5}}",
                    "volume: phantom\ntissues: {7: {opacity: 0.5}}\n");
    expect_same_job("output={fps: 25}", "SEGCAST_OUTPUT={fps: 25}",
                    "volume: phantom\noutput: {fps: 25}\n");
    expect_same_job("output.size=640x480", "SEGCAST_OUTPUT_SIZE=640x480",
                    "volume: phantom\noutput: {size: [640, 480]}\n");
}

/* Check that the setting, applied to the job file @p before, gives the job of the file @p after. */
static void expect_change(const char *before, const char *setting, const char *after)
{
    SC_OWN(sc_text_clear) sc_text a = {0}, b = {0};

    resolve(after, NULL, NULL, &a);
    resolve(before, setting, NULL, &b);
    assert_string_equal(a.data, b.data);
}

TEST(settings_merge_maps_and_replace_alternatives)
{
    expect_change("volume: phantom\noutput: {fps: 25, crf: 20}\n", "output={crf: 30}",
                  "volume: phantom\noutput: {fps: 25, crf: 30}\n");
    expect_change("volume: {path: phantom, keep: [a], box: visible}\n", "volume=phantom:20x20x20",
                  "volume: {path: phantom:20x20x20, keep: [a], box: visible}\n");
    expect_change("volume: phantom\n", "volume=phantom:20x20x20", "volume: phantom:20x20x20\n");
    expect_change("animation: {camera: {zoom: {0%: 1, 100%: 3}}}\nvolume: phantom\n",
                  "animation.camera.zoom=2", "volume: phantom\nanimation: {camera: {zoom: 2}}\n");
    expect_change("volume: phantom\ntissues: {a: {opacity: 1}, b: {opacity: 1}}\n",
                  "tissues={b: {visible: false}, c: {opacity: 0}}",
                  "volume: phantom\ntissues: {a: {opacity: 1}, b: {opacity: 1, visible: false}, c: "
                  "{opacity: 0}}\n");
    expect_change("volume: phantom\nanimation: {camera: {fixed: {position_mm: [1,2,3], target_mm: "
                  "[0,0,0]}}}\n",
                  "animation.camera.orbit.turns=2",
                  "volume: phantom\nanimation: {camera: {orbit: {turns: 2}}}\n");
    expect_change("volume: phantom\nanimation: {camera: {zoom: {0s: 1, 1s: 2}}}\n",
                  "animation.camera.zoom={2s: 3}",
                  "volume: phantom\nanimation: {camera: {zoom: {2s: 3}}}\n");
    expect_change(
        "volume: phantom\nanimation: {clip: [{normal: left, except: [a]}]}\n",
        "animation.clip[0]={box: [[0%, 0%, 0%], [40%, 100%, 100%]]}",
        "volume: phantom\nanimation: {clip: [{box: [[0%, 0%, 0%], [40%, 100%, 100%]], except: "
        "[a]}]}\n");
    expect_change("volume: phantom\nanimation: {clip: [{normal: left, at: {0%: 0%, 100%: 50%}}]}\n",
                  "animation.clip[1].normal=right",
                  "volume: phantom\nanimation: {clip: [{normal: left, at: {0%: 0%, 100%: 50%}}, "
                  "{normal: right}]}\n");
    expect_change("volume: phantom\nanimation: {clip: [{normal: left, at: {0%: 0%, 100%: 50%}}]}\n",
                  "animation.clip=[]", "volume: phantom\nanimation: {clip: []}\n");
}

/* A point of a plane in patient coordinates, instead of a position along its normal. */
TEST(a_plane_may_be_given_by_a_point)
{
    expect_change("volume: phantom\nanimation: {clip: [{normal: [0, 3, 4], at: [9, 10, "
                  "20]}]}\n",
                  NULL, "volume: phantom\nanimation: {clip: [{normal: [0, 3, 4], at: 22 mm}]}\n");
}

/* Names of tissues may hold characters that have a meaning in YAML. */
TEST(every_text_is_written_so_that_it_can_be_read)
{
    static const char text[] = "volume: phantom\ntissues: {'a \"b\" \\c: #': {opacity: 1}}\n"
                               "animation: {clip: [{normal: left, except: ['\"\\', "
                               "\"\\x01\\n\"]}]}\n";
    SC_OWN(sc_job_clear) sc_job job = {0}, again = {0};
    SC_OWN(sc_text_clear) sc_text written = {0};

    assert_ok(load(text, NULL, NULL, &job));
    assert_ok(sc_job_write(&quiet, &job, false, &written));
    if (load(written.data, NULL, NULL, &again) != SC_OK)
        fail_msg("%s: %s", said.text, written.data);
    assert_string_equal(again.tissues.rules[0].pattern, "a \"b\" \\c: #");
    assert_string_equal(again.tissues.exceptions[0].pattern, "\"\\");
    assert_string_equal(again.tissues.exceptions[1].pattern, "\x01\n");
}

/* Only "phantom" and "phantom:WxDxH" stand for the phantom; the name of a file may begin in the
 * same way. */
TEST(a_file_named_like_the_phantom_is_a_file)
{
    const sc_job_sources sources = {.path = "jobs-below/job.yaml"};
    SC_OWN(sc_job_clear) sc_job job = {0};

    mkdir("jobs-below", 0777);
    write_text("jobs-below/job.yaml", "volume: phantom.nrrd\n");
    assert_ok(sc_job_load(&listening, &sources, &job));
    assert_string_equal(job.volume.path, "jobs-below/phantom.nrrd");
    unlink("jobs-below/job.yaml");
    rmdir("jobs-below");
    assert_true(sc_job_is_phantom("phantom") && sc_job_is_phantom("phantom:9x9x9"));
    assert_false(sc_job_is_phantom("phantom.nrrd") || sc_job_is_phantom("phantoms/a.nrrd"));
}

TEST(no_allocation_that_fails_is_lost)
{
    static const sc_setting settings[] = {
        {"a", "animation.clip.0", "{normal: right, at: 10%}", false},
        {"b", "tissues.\"left atrium\".opacity", "0.5", true},
        {"c", "animation.camera.fixed", "{position_mm: [1, 2, 3], target_mm: [0, 0, 0]}", false},
        {"d", "output", "{fps: 24, size: [64, 64]}", false},
    };
    static const char *const environment[] = {"SEGCAST_ANIMATION_CAMERA_ZOOM=2", NULL};
    const sc_job_sources sources = {.path = "job2.yaml",
                                    .settings = settings,
                                    .setting_count = SC_COUNT_OF(settings),
                                    .environment = environment};

    write_text("job2.yaml", full);
    for (long n = 0;; n++) {
        long budget = n;
        sc_ctx ctx = *listening_anew();
        SC_OWN(sc_job_clear) sc_job job = {0};
        SC_OWN(sc_text_clear) sc_text text = {0};
        sc_status status;

        ctx.alloc_budget = &budget;
        status = sc_job_load(&ctx, &sources, &job);
        if (status == SC_OK)
            status = sc_job_write(&ctx, &job, false, &text);
        if (status == SC_OK)
            break;
        assert_int_equal(status, SC_ERR_MEMORY);
    }
    unlink("job2.yaml");
}

/* The same for a job with mistakes: they are told, or there is no memory. */
TEST(no_allocation_that_fails_hides_a_mistake)
{
    static const sc_setting settings[] = {{"a", "animation.clip.7", "{normal: up}", false},
                                          {"b", "tissues.x.color", "#12", false}};
    static const char *const environment[] = {"SEGCAST_RENDER_QAULITY=2", "HOME=/home/x", NULL};
    const sc_job_sources sources = {.path = "job3.yaml",
                                    .settings = settings,
                                    .setting_count = SC_COUNT_OF(settings),
                                    .environment = environment,
                                    .check_inputs = true};
    sc_status status = SC_ERR_MEMORY;

    write_text(
        "job3.yaml",
        "volume: ~/none.nrrd\nlabels: none.ctbl\nligth: {}\noutput: {size: 9, directory: ~/o}\n"
        "tissues: {a: {color: rde}, b: 3}\nanimation:\n  frames: 1 ms\n"
        "  clip:\n    - {at: 3, except: [a, [b]]}\n    - {box: [[1], [2]]}\n");
    for (long n = 0; status == SC_ERR_MEMORY; n++) {
        long budget = n;
        sc_ctx ctx = *listening_anew();
        SC_OWN(sc_job_clear) sc_job job = {0};

        ctx.alloc_budget = &budget;
        status = sc_job_load(&ctx, &sources, &job);
        assert_true(status == SC_ERR_MEMORY || status == SC_ERR_USAGE);
        assert_true(said.errors > 0);
    }
    unlink("job3.yaml");
}

static void expect_frames(const char *text, int total, int count, int first, int last)
{
    int *frames, found;

    assert_ok(sc_frames_parse(&quiet, text, total, &frames, &found));
    assert_int_equal(found, count);
    assert_int_equal(frames[0], first);
    assert_int_equal(frames[count - 1], last);
    sc_free(frames);
}

/* A box becomes six planes whose normals point inwards. */
TEST(a_box_is_six_planes)
{
    SC_OWN(sc_job_clear) sc_job job = {0};

    assert_ok(load("volume: phantom\nanimation: {clip: [{box: [[10%, 5 mm, 0%], [60%, 30 "
                   "mm, 100%]], except: [a, b]}]}\n",
                   NULL, NULL, &job));
    assert_int_equal(job.animation.sweep_count, 6);
    assert_int_equal(job.tissues.exception_count, 12);
    assert_true(job.animation.sweeps[0].normal.x == 1 && job.animation.sweeps[0].at.value == 10);
    assert_true(job.animation.sweeps[1].normal.x == -1 && job.animation.sweeps[1].at.value == 40);
    assert_true(job.animation.sweeps[3].normal.y == -1 && job.animation.sweeps[3].at.value == -30 &&
                !job.animation.sweeps[3].at.percent);
}

TEST(ranges_of_frames)
{
    static const char *const bad[] = {"", "a", "3-", "5-2", "0-10:0", "0-3,2", "10", "-1", "1,,2"};
    int *frames, found;

    expect_frames(NULL, 10, 10, 0, 9);
    expect_frames("0-9:3", 10, 4, 0, 9);
    expect_frames("7, 1 - 3", 10, 4, 1, 7);
    expect_frames("1-2:9223372036854775807", 10, 1, 1, 1); /* adding the step must not overflow */
    for (size_t i = 0; i < SC_COUNT_OF(bad); i++)
        assert_int_equal(sc_frames_parse(&quiet, bad[i], 10, &frames, &found), SC_ERR_USAGE);
}

/* A setting that leads nowhere leaves nothing in the job that further mistakes are looked for in.
 */
TEST(a_setting_within_a_single_value_is_refused)
{
    static const char *const settings[] = {"volume.x=2", "output.video.a.b=2",
                                           "tissues.t.opacity.x=2", "animation.clip.0.at.x=2"};
    sc_job job;

    for (size_t i = 0; i < SC_COUNT_OF(settings); i++) {
        const char *text = i ? "volume: phantom\n" : "output: {directory: a}\n";

        assert_int_equal(load(text, settings[i], NULL, &job), SC_ERR_USAGE);
        assert_int_equal(said.errors, i ? 1 : 2); /* the first job has no volume */
        sc_job_clear(&job);
    }
}

RUN_TESTS(NULL, NULL)
