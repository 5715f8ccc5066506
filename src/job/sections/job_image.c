/* SPDX-License-Identifier: BSD-3-Clause */
/* The grey volume (CT, MR) of a job: which file, and how much of it is shown where. */
#include "key.h"
#include "segcast/job.h"

/* Level and width, as x and y of a point. */
static sc_status read_pair(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    double numbers[2];

    if (node->kind != SC_YAML_LIST || node->count != 2 ||
        !sc_parse_number(node->items[0], &numbers[0]) ||
        !sc_parse_number(node->items[1], &numbers[1]))
        return sc_wrong_type(ctx, node, key->type->expected);
    if (!(numbers[1] > 0) || numbers[1] > 1e30 || numbers[0] > 1e30 || numbers[0] < -1e30)
        return sc_yaml_fail(
            ctx, node,
            "%s is [%.12g, %.12g], expected [level, width] with a width above 0, such as [40, 400]",
            key->name, numbers[0], numbers[1]);
    *(sc_vec3 *)value = (sc_vec3){numbers[0], numbers[1], 0};
    return SC_OK;
}

static sc_status write_pair(const sc_ctx *ctx, const sc_key *key, const void *value, sc_text *text)
{
    const sc_vec3 *pair = value;

    return sc_text_add(ctx, text, "[%.17g, %.17g]", pair->x, pair->y);
}

#define PAIR_SCHEMA SC_SCHEMA_LIST("{type: number}", 2)

static const sc_value_type type_pair = {
    .name = "[level, width]",
    .expected = "level and width of the values from black to white, such as [40, 400]",
    .read = read_pair,
    .write = write_pair,
    .schema = PAIR_SCHEMA,
};

/* "auto", level and width, or key frames of these. @p value is the whole sc_grey_options. */
static sc_status read_window(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    sc_grey_options *image = value;
    sc_vec3 first = {0, 0, 0};

    image->window_auto = node->kind == SC_YAML_SCALAR && !strcmp(node->text, "auto");
    if (image->window_auto)
        return SC_OK;
    if (sc_is_track(node)) {
        SC_PASS(sc_read_track(ctx, key, node, &image->shown.window_track));
        first = image->shown.window_track.keys[0].value;
    } else {
        SC_PASS(read_pair(ctx, key, node, &first));
    }
    image->shown.window = (sc_grey_window){first.x, first.y};
    return SC_OK;
}

static sc_status write_window(const sc_ctx *ctx, const sc_key *key, const void *value,
                              sc_text *text)
{
    const sc_grey_options *image = value;
    const sc_vec3 pair = {image->shown.window.level, image->shown.window.width, 0};

    if (image->shown.window_track.count)
        return sc_write_track(ctx, key, &image->shown.window_track, text);
    return image->window_auto ? sc_text_add(ctx, text, "auto") : write_pair(ctx, key, &pair, text);
}

static const sc_value_type type_window = {
    .name = "auto, [level, width] or key frames",
    .of_key_frames = &type_pair,
    .expected = "auto, level and width of the values from black to white, such as [40, 400], or "
                "key frames such as {0s: [40, 400], 4s: [300, 1500]}",
    .read = read_window,
    .write = write_window,
    .schema = "{anyOf: [{enum: [auto]}, " PAIR_SCHEMA ", $track]}",
};

#define IMAGE(member) offsetof(sc_grey_options, member)
/* A share, which may have key frames. */
#define SHARE(member)                                                                              \
    &sc_type_tracked, IMAGE(shown.member),                                                         \
        .track = IMAGE(shown.member##_track) - IMAGE(shown.member)

const sc_key sc_image_keys[] = {
    {"path", &sc_type_text, IMAGE(path), NULL,
     .help = "a grey volume in a format of label volumes, placed by its own geometry; phantom: a "
             "synthetic CT image of the phantom; phantom:WxDxH: with so many voxels",
     .bytes = SC_PATH_BYTES, .required = true, .scope.outside_identity = true,
     .scope.of_film = true, .without = "none",
     .option = &(const sc_key_option){"image", "FILE", "orbit still"}},
    {"window", &type_window, 0, "auto",
     .help = "values from black to white, as viewers count them: the middle, and the difference of "
             "the ends; auto: from the 1st to the 99th percentile of what the tissues hold",
     .scope.of_film = true},
    {"caps", SHARE(caps), .fallback = "0.7",
     .help = "share of the image in the colour of faces that clip planes cut into tissues; 0: it "
             "is not shown there",
     .low = 0, .high = 1},
    {"slices", SHARE(slices), .fallback = "0.7",
     .help = "share of the image in the colour of tissues on slices (animation.slices), which show "
             "nothing else beside them; 0: slices do not show it",
     .low = 0, .high = 1},
    {"backdrop", SHARE(backdrop), .fallback = "0",
     .help = "opacity of 10 mm of what is white, as a translucent volume behind all tissues; "
             "darker values have less, black has none; 0: it is not shown there",
     .low = 0, .high = 1},
    {0}};
