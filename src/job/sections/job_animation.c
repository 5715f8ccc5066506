/* SPDX-License-Identifier: BSD-3-Clause */
/* Rows of the camera, the length of the animation, and the value of the slices. */
#include "key.h"
#include "segcast/job.h"

static const sc_choice projections[] = {{"perspective", SC_PERSPECTIVE},
                                        {"orthographic", SC_ORTHOGRAPHIC},
                                        {"equirectangular", SC_EQUIRECTANGULAR},
                                        {NULL, 0}};

/* ---- focus ---- */

/* sc_optics: middle, the name of a tissue, or a point. */
static sc_status read_focus(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    sc_optics *o = value;

    if (node->kind == SC_YAML_LIST) {
        o->focus = SC_FOCUS_POINT;
        return sc_type_point.read(ctx, key, node, &o->focus_mm);
    }
    o->focus = SC_FOCUS_MIDDLE;
    if (node->kind == SC_YAML_SCALAR && !strcmp(node->text, "middle"))
        return SC_OK;
    o->focus = SC_FOCUS_TISSUE;
    return sc_read_tissue(ctx, key, node, o->pattern, o->where);
}

static sc_status write_focus(const sc_ctx *ctx, const sc_key *key, const void *value, sc_text *text)
{
    const sc_optics *o = value;
    const char *comma = "";

    if (o->focus == SC_FOCUS_POINT)
        return sc_type_point.write(ctx, key, &o->focus_mm, text);
    return o->focus == SC_FOCUS_MIDDLE ? sc_text_add(ctx, text, "middle")
                                       : sc_write_item(ctx, &comma, o->pattern, text);
}

static const sc_value_type focus_type = {
    .name = "middle, tissue or [R, A, S]",
    .expected = "middle, the name or the number of a tissue, or a point [R, A, S]",
    .read = read_focus,
    .write = write_focus,
    .schema = "{anyOf: [" SC_SCHEMA_TISSUE ", $point]}",
};

/* ---- camera ---- */

#define CAMERA(member) offsetof(sc_orbit, member)
/* The value of sc_key.track of a member of sc_orbit. */
#define TRACK(member, name) (offsetof(sc_orbit, name) - offsetof(sc_orbit, member))

static const sc_key orbit_keys[] = {
    {"axis", &sc_type_direction, CAMERA(axis), "superior",
     .help = "axis about which the camera turns; it points up in the picture", .low = -1e6,
     .high = 1e6, .option = &(const sc_key_option){"axis", "WORD", "orbit still"}},
    {"turns", &sc_type_real, CAMERA(turns), "1",
     .help = "number of turns; negative ones go the other way; 0 where angle has key frames, "
             "unless it is given",
     .low = -1000, .high = 1000, .option = &(const sc_key_option){"turns", "N", "orbit"}},
    {"angle", &sc_type_tracked, CAMERA(angle_deg), "0",
     .help = "where the camera is, or begins to turn: 0 is in front of the patient, 90 at the "
             "patient's left",
     .low = -36000, .high = 36000, .unit = "degrees", .track = TRACK(angle_deg, tracks.angle)},
    {"elevation", &sc_type_tracked, CAMERA(elevation_deg), "15",
     .help = "angle of the camera above the plane of the turn; beyond 90 it comes down behind, the "
             "picture upside down",
     .low = -360, .high = 360, .unit = "degrees", .track = TRACK(elevation_deg, tracks.elevation)},
    {"target_mm", &sc_type_tracked_point, CAMERA(target_mm), NULL,
     .help = "point that the camera looks at", .low = -1e6, .high = 1e6, .unit = "mm",
     .track = TRACK(target_mm, tracks.target), .given = SC_GIVEN(sc_orbit, has_target),
     .without = "so that what is visible stays in the middle"},
    {"distance_mm", &sc_type_tracked, CAMERA(distance_mm), NULL,
     .help = "distance of the camera from its target", .low = 1e-3, .high = 1e6, .unit = "mm",
     .track = TRACK(distance_mm, tracks.distance), .given = SC_GIVEN(sc_orbit, has_distance),
     .without = "so that what is visible fits into all frames"},
    {0}};

static const sc_key fixed_keys[] = {
    {"position_mm", &sc_type_tracked_point, CAMERA(position_mm), NULL,
     .help = "where the camera stands", .low = -1e6, .high = 1e6, .unit = "mm", .required = true,
     .track = TRACK(position_mm, tracks.position)},
    {"target_mm", &sc_type_tracked_point, CAMERA(target_mm), NULL,
     .help = "point that the camera looks at", .low = -1e6, .high = 1e6, .unit = "mm",
     .required = true, .track = TRACK(target_mm, tracks.target)},
    {"up", &sc_type_tracked_direction, CAMERA(up), "superior",
     .help = "direction that points up in the picture", .low = -1e6, .high = 1e6,
     .track = TRACK(up, tracks.up)},
    {0}};

const sc_key sc_camera_keys[] = {
    {"orbit", &sc_type_flow_map, 0, NULL, .help = "a camera that turns about what is visible",
     .keys = orbit_keys, .alternative = "orbit or fixed"},
    {"fixed", &sc_type_flow_map, 0, NULL,
     .help = "a camera without an orbit, which stands still or goes by key frames",
     .keys = fixed_keys, .alternative = "orbit or fixed", .given = SC_GIVEN(sc_orbit, fixed)},
    {"projection", &sc_type_choice, CAMERA(projection), "perspective",
     .help = "perspective; orthographic: parallel rays; or equirectangular: all 360 degrees around "
             "the camera, for a size twice as wide as high",
     .choices = projections},
    {"fov", &sc_type_tracked, CAMERA(fov_deg), "30",
     .help = "vertical angle of view; for projection: perspective", .low = 0.1, .high = 170,
     .unit = "degrees", .track = TRACK(fov_deg, tracks.fov)},
    {"zoom", &sc_type_tracked, CAMERA(zoom), "1", .help = "scale of the picture; 1: as framed",
     .low = 0.01, .high = 1000, .track = TRACK(zoom, tracks.zoom),
     .option = &(const sc_key_option){"zoom", "FACTOR", "orbit still"}},
    {"aperture_mm", &sc_type_real, CAMERA(optics.aperture_mm), "0",
     .help = "diameter of the lens: the larger, the more is blurred what is nearer or farther than "
             "the focus; 0: everything is sharp; for projection: perspective",
     .high = 1e4, .unit = "mm"},
    {"focus", &focus_type, CAMERA(optics), "middle",
     .help = "what is sharp with an aperture: the middle of what is visible, a tissue, or a point",
     .low = -1e6, .high = 1e6},
    {"shutter", &sc_type_real, CAMERA(optics.shutter), "0",
     .help = "how long the shutter is open, as a share of the time from a frame to the next: what "
             "moves is blurred; 0: nothing is, 0.5: as films are used to",
     .high = 1},
    {0}};

/* ---- how long ---- */

/* A number of frames, or a time, which sc_job_check turns into one. @p value is the whole sc_job.
 */
static sc_status read_frames(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    sc_job *job = value;
    double number;
    sc_status status;

    if (sc_parse_number(node, &number))
        return sc_type_int.read(ctx, key, node, &job->animation.frames);
    status = sc_type_duration.read(ctx, key, node, &job->film.duration_s);
    job->given.duration = status == SC_OK;
    return status;
}

static sc_status write_frames(const sc_ctx *ctx, const sc_key *key, const void *value,
                              sc_text *text)
{
    return sc_type_int.write(ctx, key, &((const sc_job *)value)->animation.frames, text);
}

const sc_value_type sc_type_frames = {
    .name = "whole number or time",
    .expected = "a number of frames, or a time such as 10s, 1.5 min, 500 ms or 0:10",
    .read = read_frames,
    .write = write_frames,
    .schema = "{anyOf: [$int, {type: string, pattern: '^([0-9.]+ "
              "*(ms|s|min)|([0-9]+:)?[0-9]+:[0-5][0-9](\\.[0-9]*)?)$'}]}",
};

/* ---- slices ---- */

static const sc_key point_row = {.name = "slices",
                                 .type = &sc_type_tracked_point,
                                 .low = -1e6,
                                 .high = 1e6,
                                 .track = offsetof(sc_slices, point_track) -
                                          offsetof(sc_slices, point_mm)};
static const sc_key share_row = {.name = "slices",
                                 .type = &sc_type_tracked_share,
                                 .track =
                                     offsetof(sc_slices, share_track) - offsetof(sc_slices, share)};

/* @return whether a value, or the first of a track, is a point. */
static bool is_point(const sc_yaml *node)
{
    while (node->kind == SC_YAML_MAP && node->count)
        node = sc_yaml_member(node, "value") ? sc_yaml_member(node, "value") : node->items[0];
    return node->kind == SC_YAML_LIST || (node->kind == SC_YAML_SCALAR && strchr(node->text, ','));
}

/* sc_slices: none, through, a share, a point, or a track of such. */
static sc_status read_slices(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    static const sc_track all = {2, {{.at = 0}, {.at = 1, .value = {1, 0, 0}}}};
    const char *word = node->kind == SC_YAML_SCALAR ? node->text : "";
    sc_slices *slices = value;

    slices->are_shown = strcmp(word, "none") != 0;
    if (!strcmp(word, "through"))
        slices->share_track = all;
    if (!slices->are_shown || slices->share_track.count)
        return SC_OK;
    slices->has_point = is_point(node);
    return slices->has_point ? point_row.type->read(ctx, &point_row, node, &slices->point_mm)
                             : share_row.type->read(ctx, &share_row, node, &slices->share);
}

static sc_status write_slices(const sc_ctx *ctx, const sc_key *key, const void *value,
                              sc_text *text)
{
    const sc_slices *slices = value;

    if (!slices->are_shown)
        return sc_text_add(ctx, text, "none");
    return slices->has_point ? point_row.type->write(ctx, &point_row, &slices->point_mm, text)
                             : share_row.type->write(ctx, &share_row, &slices->share, text);
}

/* For editors: a share or a point. */
static const sc_value_type type_place = {.schema = "{anyOf: [$share, $point]}"};

const sc_value_type sc_type_slices = {
    .name = "none, through, share, [R, A, S] or key frames",
    .expected = "none, through, a share such as 40%, a point [R, A, S], or key frames of such",
    .read = read_slices,
    .write = write_slices,
    .of_key_frames = &type_place,
    .schema = "{anyOf: [{enum: [none, through]}, $share, $point, $track]}",
};
