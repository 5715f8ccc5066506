/* SPDX-License-Identifier: BSD-3-Clause */
/* Checks after all keys of a job have been read: what no single row can know, and paths. */
#include "key.h"
#include "segcast/job.h"
#include "segcast/store.h"

#include <math.h>

const sc_yaml *sc_key_node(const sc_yaml *root, const char *path)
{
    char key[64];

    while (root && *path) {
        const size_t length = strcspn(path, ".");

        snprintf(key, sizeof key, "%.*s", (int)length, path);
        root = sc_yaml_member(root, key);
        path += length + (path[length] == '.');
    }
    return root;
}

/* ---- values that depend on each other ---- */

/* A video of pictures without a background, whose format must hold alpha. */
static sc_status check_alpha(const sc_ctx *ctx, const sc_yaml *root, const sc_job *job)
{
    const char *video = job->output.video;
    const sc_codec codec = (sc_codec)job->output.codec;

    if (!job->render.background.is_none || sc_video_has_alpha(video, codec))
        return SC_OK;
    return sc_yaml_fail(
        ctx, sc_key_node(root, "render.background"),
        "background is \"none\", but the video %s is %s, which has no transparency; expected "
        "output.video: none with output.frames: png, or a name ending in .webp, .webm or .mkv "
        "(with codec: vp9), or .mov (with codec: prores)",
        video, sc_video_codec_name(video, codec));
}

/* Size and frame rate, which the format of the video limits. */
static sc_status check_limits(const sc_ctx *ctx, const sc_yaml *root, const sc_job *job)
{
    const char *video = job->output.video;
    char expected[SC_PATH_BYTES + 160];
    sc_status status = SC_OK;

    if (!sc_video_size_ok(video, job->output.size_px[0], job->output.size_px[1])) {
        snprintf(expected, sizeof expected,
                 "at most %d pixels for a side and 264 million in all for the video %s, or video: "
                 "none with frames: png",
                 sc_video_side_max_px(video), video);
        (void)sc_goes_on(&status, sc_wrong_type(ctx, sc_key_node(root, "output.size"), expected));
    }
    if (job->output.fps > sc_video_fps_max(video)) {
        snprintf(expected, sizeof expected,
                 "at most %d for the video %s: programs show shorter frames of its format too long",
                 sc_video_fps_max(video), video);
        (void)sc_goes_on(&status, sc_wrong_type(ctx, sc_key_node(root, "output.fps"), expected));
    }
    return status;
}

/* The video: a name that it can have, and what its encoder takes. */
static sc_status check_video(const sc_ctx *ctx, const sc_job_sources *sources, const sc_yaml *root,
                             const sc_job *job)
{
    const char *video = job->output.video;
    const sc_codec codec = (sc_codec)job->output.codec;
    sc_status status = SC_OK;

    if (!strcmp(video, "none"))
        return SC_OK;
    if (!sc_store_video_ok(video))
        return sc_wrong_type(ctx, sc_key_node(root, "output.video"),
                             "a name ending in " SC_VIDEO_EXTENSIONS
                             ", of at most 140 bytes, without a directory, control characters or a "
                             "dot at the beginning; or none (PowerPoint and phones play .mp4)");
    if (!sc_video_codec_ok(video, codec))
        return sc_yaml_fail(
            ctx, sc_key_node(root, "output.codec"),
            "%s cannot hold this codec; expected auto, %s, or another name of the video", video,
            sc_video_codec_words(video));
    if (!sources->no_video)
        (void)sc_goes_on(&status, check_alpha(ctx, root, job));
    if (job->output.crf < sc_video_crf_least(video, codec))
        (void)sc_goes_on(
            &status,
            sc_wrong_type(
                ctx, sc_key_node(root, "output.crf"),
                "a number from 1 to 51 for H.264 and H.265; without losses there is frames: png"));
    (void)sc_goes_on(&status, check_limits(ctx, root, job));
    return status;
}

/* Not more different strengths of smoothing than tables are made for. */
static sc_status check_strengths(const sc_ctx *ctx, const sc_yaml *root, const sc_job *job)
{
    const sc_vec3 first = sc_smooth_is_auto(job->render.smooth)
                              ? (sc_vec3){SC_SMOOTH_AUTO, SC_SMOOTH_AUTO, SC_SMOOTH_AUTO}
                              : job->render.smooth;
    size_t count = 1;

    for (size_t i = 0; i < job->tissues.rule_count; i++) {
        bool is_new = job->tissues.rules[i].has.smooth &&
                      !sc_strength_is_same(job->tissues.rules[i].smooth, first);

        for (size_t j = 0; j < i && is_new; j++)
            is_new =
                !job->tissues.rules[j].has.smooth ||
                !sc_strength_is_same(job->tissues.rules[i].smooth, job->tissues.rules[j].smooth);
        count += is_new;
    }
    if (count <= SC_SMOOTH_KINDS_MAX)
        return SC_OK;
    return sc_yaml_fail(ctx, sc_key_node(root, "tissues"),
                        "tissues and render.smooth have %zu different strengths of smoothing, "
                        "expected at most %d; give some of them the same",
                        count, SC_SMOOTH_KINDS_MAX);
}

/* The value of @p key, a path that has to lead somewhere, must not be empty. */
static sc_status check_not_empty(const sc_ctx *ctx, const sc_yaml *root, const char *key)
{
    const sc_yaml *node = sc_key_node(root, key);
    const bool is_empty = node && node->kind == SC_YAML_SCALAR && !node->text[0];

    return is_empty ? sc_wrong_type(ctx, node, "a path") : SC_OK;
}

/* A camera without an orbit needs a direction of view, in all frames. Not checked after another
 * mistake in it. */
static sc_status check_fixed(const sc_ctx *ctx, const sc_yaml *root, const sc_job *job)
{
    const sc_orbit *camera = &job->animation.camera;
    const bool moves = camera->tracks.position.count || camera->tracks.target.count;
    char when[48] = "";

    for (int k = 0; camera->fixed && k < (moves ? job->animation.frames : 1); k++) {
        sc_vec3 position_mm, target_mm, up;

        sc_fixed_camera_at(camera, sc_frame_time(k, job->animation.frames), &position_mm,
                           &target_mm, &up);
        if (sc_vec3_length(sc_vec3_sub(position_mm, target_mm)) >= 1e-6)
            continue;
        if (moves)
            snprintf(when, sizeof when, " in frame %d", k);
        return sc_yaml_fail(ctx, sc_key_node(root, "animation.camera.fixed"),
                            "position_mm and target_mm are the same point%s", when);
    }
    return SC_OK;
}

/* A picture of all directions is twice as wide as high. */
static sc_status check_projection(const sc_ctx *ctx, const sc_yaml *root, const sc_job *job)
{
    const int *size_px = job->output.size_px;

    if (job->animation.camera.projection != SC_EQUIRECTANGULAR || size_px[0] == 2 * size_px[1])
        return SC_OK;
    return sc_yaml_fail(ctx, sc_key_node(root, "animation.camera.projection"),
                        "projection: an equirectangular picture is twice as wide as high, but "
                        "output.size is %d x %d; expected for example size: [%d, %d]",
                        size_px[0], size_px[1], 2 * (size_px[0] / 2), size_px[0] / 2);
}

/* ---- verbs of the camera ---- */

/* Log what is wrong with a verb. */
static sc_status fail_verb(const sc_ctx *ctx, const sc_verb *verb, const char *text)
{
    return sc_fail(ctx, SC_ERR_DATA, "%s%s%s", verb->where, verb->where[0] ? ": " : "", text);
}

/* Does a verb overlap in time with one of the same kind before it? */
static bool overlaps(const sc_job *job, size_t index)
{
    const sc_verb *verb = &job->verbs.list[index];
    bool any = false;

    for (const sc_verb *other = job->verbs.list; other < verb; other++)
        any = any ||
              (other->kind == verb->kind && other->begin < verb->end && verb->begin < other->end);
    return any;
}

/* A hold needs an orbit that turns in the rest of the time, and a time of its own. */
static sc_status check_hold(const sc_ctx *ctx, const sc_job *job, size_t index)
{
    const sc_orbit *camera = &job->animation.camera;
    const sc_verb *hold = &job->verbs.list[index];

    if (camera->fixed || camera->turns == 0)
        return fail_verb(ctx, hold,
                         "hold: the camera does not turn by itself; expected an orbit with turns, "
                         "whose turning it can pause");
    if (hold->soft > 0.5)
        return fail_verb(ctx, hold,
                         "hold: soft is more than 50%, so that the camera would start again before "
                         "it stands; expected 0% to 50%");
    if (hold->end - hold->begin >= 1)
        return fail_verb(ctx, hold,
                         "hold: it lasts for the whole animation, so that there is no time to "
                         "turn; expected a part of it, or turns: 0");
    if (overlaps(job, index))
        return fail_verb(ctx, hold,
                         "hold: it overlaps with another hold; expected one that begins when the "
                         "other has ended, or one for both");
    return SC_OK;
}

/* Warn of verbs that do nothing, because the camera flies or stands where a flight has ended. */
static void warn_of_flight(const sc_ctx *ctx, const sc_job *job, const sc_verb *fly)
{
    const unsigned stilled = 1u << SC_VERB_ORBIT | 1u << SC_VERB_ROCK | 1u << SC_VERB_FRAME |
                             1u << SC_VERB_DOLLY | 1u << SC_VERB_HOLD;

    for (size_t i = 0; i < job->verbs.count; i++) {
        const sc_verb *verb = &job->verbs.list[i];

        if (stilled >> verb->kind & 1u && verb->begin >= fly->begin)
            sc_warn(ctx,
                    "%s%s%s: it does nothing, because the camera flies by then, or stays where the "
                    "flight has ended; another shot may begin with it",
                    verb->where, verb->where[0] ? ": " : "", sc_verb_keys[verb->kind].name);
    }
}

/* A fly needs a way, and a time of its own. */
static sc_status check_fly(const sc_ctx *ctx, const sc_job *job, size_t index)
{
    const sc_verb *fly = &job->verbs.list[index];
    int tissues = 0;

    for (size_t i = 0; i < job->verbs.tissue_count; i++)
        tissues += job->verbs.tissues[i].of == (int)index;
    if (fly->fly.middles && tissues < 2)
        return fail_verb(ctx, fly,
                         "fly: from middle to middle there have to be two tissues or more; "
                         "expected for example fly: [left atrium, left ventricle]");
    if (overlaps(job, index))
        return fail_verb(ctx, fly,
                         "fly: it overlaps with another fly; expected one that begins when the "
                         "other has ended");
    warn_of_flight(ctx, job, fly);
    if (fly->fly.has_tissues || fly->fly.through_count > 1)
        return SC_OK;
    return fail_verb(ctx, fly, "fly: it has no way; expected tissues, or two points or more");
}

/* A turn needs its clip plane. */
static sc_status check_plane(const sc_ctx *ctx, const sc_job *job, const sc_verb *verb)
{
    const int planes = job->animation.sweep_count;
    char text[200];

    snprintf(text, sizeof text,
             "turn: there is no clip plane %d; expected 1 to %d, the number of a plane of "
             "animation.clip (a box counts as six)",
             verb->plane, planes);
    if (!planes)
        snprintf(
            text, sizeof text,
            "turn: the job has no clip plane; expected one in animation.clip, which then turns");
    return verb->plane > planes ? fail_verb(ctx, verb, text) : SC_OK;
}

/* A turn needs a line about which turning changes something. A plane that has turned before may
 * have any direction. */
static sc_status check_turn(const sc_ctx *ctx, const sc_job *job, size_t index)
{
    const sc_verb *turn = &job->verbs.list[index];
    const sc_status status = check_plane(ctx, job, turn);
    bool turned;

    if (status != SC_OK)
        return status;
    turned = job->animation.sweeps[turn->plane - 1].normal_track.count > 0;
    for (size_t i = 0; i < job->verbs.count; i++)
        turned = turned || (i != index && job->verbs.list[i].kind == SC_VERB_TURN &&
                            job->verbs.list[i].plane == turn->plane);
    if (!turned && turn->line.has_axis &&
        sc_vec3_length(
            sc_vec3_cross(turn->line.axis, job->animation.sweeps[turn->plane - 1].normal)) < 1e-6)
        return fail_verb(ctx, turn,
                         "turn: the axis is the normal of the plane, so that turning changes "
                         "nothing; expected another one");
    return SC_OK;
}

/* Verbs that the camera or the planes of the job cannot do. Not checked after another mistake in
 * them. */
static sc_status check_verbs(const sc_ctx *ctx, const sc_job *job)
{
    const sc_orbit *camera = &job->animation.camera;
    sc_status status = SC_OK;

    for (size_t i = 0; i < job->verbs.count; i++) {
        const sc_verb *verb = &job->verbs.list[i];

        if (verb->kind == SC_VERB_HOLD)
            (void)sc_goes_on(&status, check_hold(ctx, job, i));
        if (verb->kind == SC_VERB_FLY)
            (void)sc_goes_on(&status, check_fly(ctx, job, i));
        if (verb->kind == SC_VERB_TURN)
            (void)sc_goes_on(&status, check_turn(ctx, job, i));
        if (verb->kind == SC_VERB_DOLLY && camera->projection == SC_ORTHOGRAPHIC)
            (void)sc_goes_on(&status,
                             fail_verb(ctx, verb,
                                       "dolly: it changes nothing in an orthographic picture; "
                                       "expected the verb zoom, or projection: perspective"));
    }
    return status;
}

/* Turn a duration into a number of frames. */
static sc_status apply_duration(const sc_ctx *ctx, const sc_yaml *root, sc_job *job)
{
    const double frames = floor(job->film.duration_s * job->output.fps + 0.5);

    if (!job->given.duration)
        return SC_OK;
    job->given.duration = false;
    if (frames < 1 || frames > SC_JOB_FRAMES_MAX)
        return sc_yaml_fail(
            ctx, sc_key_node(root, "animation.frames"),
            "frames is %g s, which makes %.0f frames at %d frames per second, expected 1 to %d",
            job->film.duration_s, frames, job->output.fps, SC_JOB_FRAMES_MAX);
    job->animation.frames = (int)frames;
    return SC_OK;
}

/* Leave the turning to key frames of the angle; and refuse a number of turns that is meant in
 * degrees: one that is as large as angles are, and makes the camera turn so far between two frames
 * that no turning can be seen. */
static sc_status check_turns(const sc_ctx *ctx, const sc_yaml *root, sc_job *job)
{
    const sc_yaml *node = sc_key_node(root, "animation.camera.orbit.turns");
    const double turns = job->animation.camera.turns;
    const double step_deg = 360 * fabs(turns) / job->animation.frames;

    if (!node && job->animation.camera.tracks.angle.count)
        job->animation.camera.turns = 0;
    if (!node || fabs(turns) < 45 || step_deg < 22.5)
        return SC_OK;
    return sc_yaml_fail(
        ctx, node,
        "turns is %g, so that the camera would turn by %.0f degrees from each frame to the next; "
        "expected a number of turns, not of degrees: %g degrees are turns: %.6g",
        turns, step_deg, turns, turns / 360);
}

/* Refuse a column without a table. */
static sc_status check_color_by(const sc_ctx *ctx, const sc_yaml *root, const sc_job *job)
{
    const sc_color_by *by = &job->color_by;

    if (!by->has_measure || (!by->column[0] && !job->color_columns.steps.count))
        return SC_OK;
    return sc_yaml_fail(ctx, sc_key_node(root, "color_by.column"),
                        "column is \"%s\", but the values are a measure, and come from no "
                        "table; expected the path of one as values, or no column",
                        by->column[0] ? by->column : job->color_columns.columns[0]);
}

/* @return the node of @p key, such as "volume", of the comparison's subject @p i (of
 * sc_comparison.others); NULL if there is none. */
static const sc_yaml *compare_node(const sc_yaml *root, int i, const char *key)
{
    const sc_yaml *list = sc_key_node(root, "compare.with");
    const sc_yaml *node = list && list->kind == SC_YAML_LIST ? list->items[i] : list;

    if (node && node->kind == SC_YAML_MAP)
        return sc_yaml_member(node, key);
    return strcmp(key, "volume") != 0 ? NULL : node;
}

/* Choose the layout, and refuse what a comparison cannot have by its number of volumes. */
static sc_status check_compare(const sc_ctx *ctx, const sc_yaml *root, sc_job *job)
{
    sc_status status = SC_OK;

    if (job->animation.slices.are_shown)
        job->output.layout = SC_LAYOUT_VIEWS;
    if (!job->given.compare)
        return SC_OK;
    sc_note_where(sc_key_node(root, "compare"), job->compare.where, sizeof job->compare.where);
    job->output.layout = SC_LAYOUT_COMPARE;
    for (int i = 0; i < job->compare.count && !job->given.image; i++) {
        if (job->compare.others[i].image[0])
            (void)sc_goes_on(
                &status,
                sc_yaml_fail(ctx, compare_node(root, i, "image"),
                             "image: the job itself has none, which says how it is shown; expected "
                             "for example image: {path: before.nii.gz} at the top of the job"));
    }
    if (job->compare.has_divider && job->compare.count > 1)
        (void)sc_goes_on(&status,
                         sc_yaml_fail(ctx, sc_key_node(root, "compare.divider"),
                                      "divider: it parts two volumes, but there are %d; expected "
                                      "one volume under compare.with, or no divider",
                                      job->compare.count + 1));
    return status;
}

/* Refuse values that do not go together. */
static sc_status check_together(const sc_ctx *ctx, const sc_yaml *root, const sc_job *job)
{
    static const char projection[] = "animation.camera.projection";
    static const char aperture[] = "animation.camera.aperture_mm";
    const sc_orbit *camera = &job->animation.camera;
    const bool compares = job->given.compare, slices = job->animation.slices.are_shown;
    const bool all_around = camera->projection == SC_EQUIRECTANGULAR;
    const bool has_shadows = job->render.surface == SC_SURFACE_SMOOTH &&
                             (job->light.constant.method == SC_LIGHT_GLOBAL ||
                              job->light.constant.method == SC_LIGHT_PATH);
    const struct {
        bool is_made;
        const char *key, *text;
    } mistakes[] = {
        {job->overlays.color_bar && !sc_color_by_any(&job->color_by), "overlays.color_bar",
         "color_bar: tissues are not coloured by values; expected color_by, such as color_by: "
         "{values: thickness}"},
        {compares && slices, "animation.slices",
         "slices: a comparison has none; expected slices: none, or no compare"},
        {compares && job->given.shots, "compare",
         "compare: a film of shots shows one volume; expected a job without shots, or no compare"},
        {compares && job->volume.phase_count, "compare",
         "compare: a series of volumes (cine) cannot be compared; expected one volume, or no "
         "compare"},
        {compares && job->given.color_by, "compare",
         "compare: tissues that are coloured by values (color_by) cannot be compared; expected no "
         "color_by, or no compare"},
        {camera->optics.aperture_mm > 0 && camera->projection == SC_ORTHOGRAPHIC, aperture,
         "aperture_mm: an orthographic picture is sharp everywhere; expected projection: "
         "perspective, or aperture_mm: 0"},
        {camera->optics.aperture_mm > 0 && all_around, aperture,
         "aperture_mm: an equirectangular picture is sharp everywhere; expected projection: "
         "perspective, or aperture_mm: 0"},
        {all_around && compares, projection,
         "projection: an equirectangular picture fills the frame; expected no compare, or another "
         "projection"},
        {all_around && slices && !compares, projection,
         "projection: an equirectangular picture fills the frame; expected no slices, or another "
         "projection"},
        {all_around && job->overlays.scale_bar, "overlays.scale_bar",
         "scale_bar: an equirectangular picture has no scale; expected scale_bar: none"},
        {job->render.stage != SC_GROUND_NONE && !has_shadows, "render.stage",
         "stage: no shadow would fall on it; expected light.method: global or path, surface: "
         "smooth, or stage: none"}};
    sc_status status = SC_OK;

    for (size_t i = 0; i < SC_COUNT_OF(mistakes); i++) {
        if (mistakes[i].is_made)
            (void)sc_goes_on(&status, sc_yaml_fail(ctx, sc_key_node(root, mistakes[i].key), "%s",
                                                   mistakes[i].text));
    }
    return status;
}

/* ---- the whole job ---- */

/* Resolve the paths of the volumes that are compared, of their label tables and of their grey
 * volumes. @return the first mistake; all are logged. */
static sc_status resolve_subjects(const sc_ctx *ctx, const sc_job_sources *sources,
                                  const sc_yaml *root, sc_job *job)
{
    sc_status status = SC_OK;

    for (int i = 0; i < job->compare.count; i++) {
        sc_subject *subject = &job->compare.others[i];

        const struct {
            const char *key;
            char *path;
            sc_path_use use;
            bool is_path;
        } paths[] = {
            {"volume", subject->volume, SC_PATH_INPUT, !sc_job_is_phantom(subject->volume)},
            {"labels", subject->labels, SC_PATH_FILE, true},
            {"image", subject->image, SC_PATH_INPUT,
             !sc_job_is_phantom(subject->image) && strcmp(subject->image, "none") != 0}};

        for (size_t p = 0; p < SC_COUNT_OF(paths); p++) {
            if (paths[p].is_path &&
                !sc_goes_on(&status,
                            sc_resolve_path(ctx, sources, compare_node(root, i, paths[p].key),
                                            paths[p].key, paths[p].use, paths[p].path)))
                return status;
        }
    }
    return status;
}

/* Is a key at the top of the file misspelt that says where the names of the tissues come from? */
static bool is_source_misspelt(const sc_yaml *root)
{
    static const char *const sources[] = {"volume", "labels", "labels_format"};

    for (size_t i = 0; i < root->count; i++) {
        if (!sc_key_find(sc_job_keys, root->items[i]->key) &&
            sc_nearest_word(root->items[i]->key, sources, SC_COUNT_OF(sources)))
            return true;
    }
    return false;
}

/* @return the key whose value is the path of the volume. */
static const char *volume_key(const sc_yaml *root)
{
    const sc_yaml *volume = sc_yaml_member(root, "volume");

    return volume && volume->kind == SC_YAML_MAP ? "volume.path" : "volume";
}

/* As sc_resolve_path, of the value of @p key in the tree @p root. */
static sc_status resolve_key(const sc_ctx *ctx, const sc_job_sources *sources, const sc_yaml *root,
                             const char *key, sc_path_use use, char *path)
{
    return sc_resolve_path(ctx, sources, sc_key_node(root, key), key, use, path);
}

/* Note where keys stand that messages name later. */
static void note_places(const sc_yaml *root, sc_job *job)
{
    const struct {
        const char *key;
        char *where;
        bool with_key; /* as sc_note_key, else as sc_note_where */
    } places[] = {{volume_key(root), job->lines.volume, true},
                  {"image.path", job->lines.image, true},
                  {"output.directory", job->lines.directory, true},
                  {"output.video", job->lines.video, false},
                  {"output.size", job->lines.size, false},
                  {"output.fps", job->lines.fps, false},
                  {"tissues", job->lines.tissues, false},
                  {"volume.phase", job->lines.volume_box, false},
                  {"volume.level", job->lines.volume_box, false},
                  {"volume.box", job->lines.volume_box, false},
                  {"volume.header", job->lines.volume_box, false},
                  {"animation.camera.zoom", job->lines.zoom, false}};

    for (size_t i = 0; i < SC_COUNT_OF(places); i++) {
        const sc_yaml *node = sc_key_node(root, places[i].key);

        if (node && places[i].with_key)
            sc_note_key(node, places[i].key, places[i].where, SC_WHERE_BYTES);
        else if (node)
            sc_note_where(node, places[i].where, SC_WHERE_BYTES);
    }
}

/* Resolve the path of a file, which may stand in a map: the logo at its place. */
static sc_status resolve_or_first(const sc_ctx *ctx, const sc_job_sources *sources,
                                  const sc_yaml *root, const char *key, char *path)
{
    const sc_yaml *node = sc_key_node(root, key);

    if (node && node->kind == SC_YAML_MAP)
        node = node->count ? node->items[0] : NULL;
    return sc_resolve_path(ctx, sources, node, key, SC_PATH_FILE, path);
}

sc_status sc_job_check(const sc_ctx *ctx, const sc_job_sources *sources, const sc_yaml *root,
                       sc_job *job)
{
    sc_status status = SC_OK, inputs = SC_OK;

    note_places(root, job);
    (void)sc_goes_on(&status, check_not_empty(ctx, root, volume_key(root)));
    (void)sc_goes_on(&status, check_not_empty(ctx, root, "output.directory"));
    (void)sc_goes_on(&status, check_video(ctx, sources, root, job));
    (void)sc_goes_on(&status, check_fixed(ctx, root, job));
    (void)sc_goes_on(&status, apply_duration(ctx, root, job));
    (void)sc_goes_on(&status, check_turns(ctx, root, job));
    if (status == SC_OK)
        (void)sc_goes_on(&status, check_verbs(ctx, job));
    (void)sc_goes_on(&status, check_strengths(ctx, root, job));
    (void)sc_goes_on(&status, sc_captions_check(ctx, job));
    if (!sc_job_is_phantom(job->volume.path))
        inputs = sc_resolve_volume(ctx, sources, sc_key_node(root, volume_key(root)),
                                   volume_key(root), job);
    if (inputs == SC_OK)
        (void)sc_goes_on(&status, sc_cine_check(ctx, sources, root, job));
    if (sc_goes_on(&status, inputs))
        (void)sc_goes_on(
            &inputs, resolve_key(ctx, sources, root, "labels", SC_PATH_FILE, job->volume.labels));
    if (!sc_goes_on(&status, inputs))
        return status;
    (void)sc_goes_on(&status,
                     resolve_or_first(ctx, sources, root, "overlays.logo", job->overlays.logo));
    if (!job->color_by.has_measure)
        (void)sc_goes_on(&status, resolve_key(ctx, sources, root, "color_by.values", SC_PATH_FILE,
                                              job->color_by.table));
    if (!sc_job_is_phantom(job->image.path))
        (void)sc_goes_on(
            &status, resolve_key(ctx, sources, root, "image.path", SC_PATH_INPUT, job->image.path));
    (void)sc_goes_on(&status, resolve_or_first(ctx, sources, root, "light.environment",
                                               job->light.environment.file));
    (void)sc_goes_on(&status, check_color_by(ctx, root, job));
    (void)sc_goes_on(&status, resolve_subjects(ctx, sources, root, job));
    (void)sc_goes_on(&status, check_compare(ctx, root, job));
    (void)sc_goes_on(&status, check_projection(ctx, root, job));
    (void)sc_goes_on(&status, check_together(ctx, root, job));
    if (inputs != SC_OK || is_source_misspelt(root))
        job->volume.path[0] = '\0'; /* so that nobody looks for its tissues */
    (void)sc_goes_on(&status, resolve_key(ctx, sources, root, "output.directory", SC_PATH_OUTPUT,
                                          job->output.directory));
    return status;
}
