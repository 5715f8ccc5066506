/* SPDX-License-Identifier: BSD-3-Clause */
/* Rows of the camera and of the slices. */
#include "key.h"
#include "segcast/timeline.h"

static const sc_choice projections[] = {
    {"perspective", SC_PERSPECTIVE}, {"orthographic", SC_ORTHOGRAPHIC}, {NULL, 0}};

/* ---- camera ---- */

static const sc_key ramp_keys[] = {{"from", &sc_type_real, offsetof(sc_ramp, from), "1",
                                    .help = "scale at the beginning", .low = 0.01, .high = 1000},
                                   {"to", &sc_type_real, offsetof(sc_ramp, to), "1",
                                    .help = "scale at the end", .low = 0.01, .high = 1000},
                                   {"during", &sc_type_span, offsetof(sc_ramp, begin), "[0%, 100%]",
                                    .help = "part of the animation in which the scale changes"},
                                   {"ease", &sc_type_ease, offsetof(sc_ramp, ease), "linear",
                                    .help = "how the change begins and ends"},
                                   {0}};

/* Read a map of ramp_keys, or a number that holds for the whole animation, into an sc_ramp; or key
 * frames into its track. */
static sc_status read_zoom(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    sc_ramp *zoom = value;
    sc_status status;

    if (node->kind == SC_YAML_LIST)
        return sc_read_track(ctx, key, node, (sc_track *)((char *)value + key->track));
    if (node->kind == SC_YAML_MAP)
        return sc_keys_read(ctx, key->keys, node, zoom);
    status = sc_read_real(ctx, node, key->low, key->high, &zoom->from);
    if (status == SC_OK)
        zoom->to = zoom->from;
    return status;
}

static sc_status write_zoom(const sc_ctx *ctx, const sc_key *key, const void *value, int indent,
                            sc_text *text)
{
    const sc_track *track = (const sc_track *)((const char *)value + key->track);

    (void)indent;
    return track->count ? sc_write_track(ctx, key, track, text)
                        : sc_keys_write_flow(ctx, key->keys, value, text);
}

static json_t *zoom_schema(const sc_key *key)
{
    return json_pack("{s:[{s:s, s:f, s:f}, o, o]}", "anyOf", "type", "number", "minimum", key->low,
                     "maximum", key->high, sc_keys_schema(key->keys), sc_track_schema(key));
}

const sc_value_type sc_type_zoom = {
    .name = "number, map or key frames",
    .expected = "a number, {from, to, during, ease} or key frames",
    .read = read_zoom,
    .write = write_zoom,
    .schema = zoom_schema,
    .container = SC_CONTAINER_MAP,
};

#define CAMERA(member) offsetof(sc_orbit, member)
/* The value of sc_key.track of a member of sc_orbit. */
#define TRACK(member, name) (offsetof(sc_orbit, name) - offsetof(sc_orbit, member))
#define FOV_HELP "vertical angle of view; for projection: perspective"

static const sc_key orbit_keys[] = {
    {"axis", &sc_type_direction, CAMERA(axis), "superior",
     .help = "axis about which the camera turns; it points up in the picture", .low = -1e6,
     .high = 1e6, .option = &(const sc_key_option){"axis", "WORD", "orbit still"}},
    {"turns", &sc_type_real, CAMERA(turns), "1",
     .help = "number of turns; negative ones go the other way", .low = -1000, .high = 1000,
     .alternative = "turns or angle", .option = &(const sc_key_option){"turns", "N", "orbit"}},
    {"angle", &sc_type_tracked, CAMERA(angle_deg), NULL,
     .help = "how far the camera has turned from where it began, instead of turns", .low = -36000,
     .high = 36000, .unit = "degrees", .track = TRACK(angle_deg, angle_track),
     .given = SC_GIVEN(sc_orbit, has_angle), .without = "turns", .alternative = "turns or angle"},
    {"elevation", &sc_type_tracked, CAMERA(elevation_deg), "15",
     .help = "angle of the camera above the plane of the turn; beyond 90 it comes down behind, the "
             "picture upside down",
     .low = -360, .high = 360, .unit = "degrees", .track = TRACK(elevation_deg, elevation_track)},
    {"start", &sc_type_real, CAMERA(start_deg), "0",
     .help = "where the turn begins: 0 is in front of the patient, 90 at the patient's left",
     .low = -3600, .high = 3600, .unit = "degrees"},
    {"target_mm", &sc_type_tracked_point, CAMERA(target_mm), NULL,
     .help = "point that the camera looks at", .low = -1e6, .high = 1e6, .unit = "mm",
     .track = TRACK(target_mm, target_track), .given = SC_GIVEN(sc_orbit, has_target),
     .without = "so that what is visible stays in the middle"},
    {"distance_mm", &sc_type_tracked, CAMERA(distance_mm), NULL,
     .help = "distance of the camera from its target", .low = 1e-3, .high = 1e6, .unit = "mm",
     .track = TRACK(distance_mm, distance_track), .given = SC_GIVEN(sc_orbit, has_distance),
     .without = "so that what is visible fits into all frames"},
    {"fov", &sc_type_tracked, CAMERA(fov_deg), "30", .help = FOV_HELP, .low = 0.1, .high = 170,
     .unit = "degrees", .track = TRACK(fov_deg, fov_track)},
    {0}};

static const sc_key fixed_keys[] = {
    {"position_mm", &sc_type_tracked_point, CAMERA(position_mm), NULL,
     .help = "where the camera stands", .low = -1e6, .high = 1e6, .unit = "mm", .required = true,
     .track = TRACK(position_mm, position_track)},
    {"target_mm", &sc_type_tracked_point, CAMERA(target_mm), NULL,
     .help = "point that the camera looks at", .low = -1e6, .high = 1e6, .unit = "mm",
     .required = true, .track = TRACK(target_mm, target_track)},
    {"up", &sc_type_tracked_direction, CAMERA(up), "superior",
     .help = "direction that points up in the picture", .low = -1e6, .high = 1e6,
     .track = TRACK(up, up_track)},
    {"fov", &sc_type_tracked, CAMERA(fov_deg), "30", .help = FOV_HELP, .low = 0.1, .high = 170,
     .unit = "degrees", .track = TRACK(fov_deg, fov_track)},
    {0}};

const sc_key sc_camera_keys[] = {
    {"orbit", &sc_type_flow_map, 0, NULL, .help = "a camera that turns about what is visible",
     .keys = orbit_keys, .alternative = "orbit or fixed"},
    {"fixed", &sc_type_flow_map, 0, NULL,
     .help = "a camera without an orbit, which stands still or goes by key frames",
     .keys = fixed_keys, .alternative = "orbit or fixed", .given = SC_GIVEN(sc_orbit, fixed)},
    {"projection", &sc_type_choice, CAMERA(projection), "perspective",
     .help = "perspective, or orthographic: parallel rays", .choices = projections},
    {"zoom", &sc_type_zoom, CAMERA(zoom), NULL,
     .help = "scale of the picture: a number, or a map or key frames for one that changes",
     .low = 0.01, .high = 1000, .track = TRACK(zoom, zoom_track), .keys = ramp_keys,
     .shorthand = "from", .option = &(const sc_key_option){"zoom", "FACTOR", "orbit still"}},
    {0}};

/* ---- slices ---- */

const sc_key sc_slices_keys[] = {
    {"point_mm", &sc_type_tracked_point, offsetof(sc_slices, point_mm), NULL,
     .track = offsetof(sc_slices, point_track) - offsetof(sc_slices, point_mm),
     .help = "where the three slices cross", .low = -1e6, .high = 1e6, .unit = "mm",
     .given = SC_GIVEN(sc_slices, has_point), .without = "the slices move, by from and to",
     .option = &(const sc_key_option){"point", "R,A,S", "still"}},
    {"from", &sc_type_share, offsetof(sc_slices, share.from), "0%",
     .help = "where the slices begin, as a share of the way through what is visible"},
    {"to", &sc_type_share, offsetof(sc_slices, share.to), "100%", .help = "where the slices end"},
    {"during", &sc_type_span, offsetof(sc_slices, share.begin), "[0%, 100%]",
     .help = "part of the animation in which the slices move"},
    {"ease", &sc_type_ease, offsetof(sc_slices, share.ease), "linear",
     .help = "how the movement begins and ends"},
    {0}};
