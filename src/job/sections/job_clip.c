/* SPDX-License-Identifier: BSD-3-Clause */
/* Clip planes of a job, and boxes, which are six planes. */
#include "key.h"
#include "segcast/job.h"

/* ---- rows ---- */

#define PLANE(member) offsetof(plane_entry, member)
/* What an entry of the list is read into, and a plane is written from. */
typedef struct plane_entry {
    sc_sweep sweep;
    bool has_point, has_box;
    sc_vec3 point_mm;
    sc_plane_position from[3], to[3]; /* of a box: two corners, along R, A and S */
    const sc_yaml *except;            /* borrowed; NULL: none */
    const sc_job *job;                /* for writing: its exceptions are those of the plane */
    int plane;                        /* which it is */
} plane_entry;

/* ---- values of a plane that may have key frames ---- */

/* A position that is a value of key frames: see sc_sweep.at_track. */
static sc_status read_key_position(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                                   void *value)
{
    sc_plane_position position;

    SC_PASS(sc_type_plane_position.read(ctx, key, node, &position));
    *(sc_vec3 *)value = (sc_vec3){position.value, position.percent, 0};
    return SC_OK;
}

static sc_plane_position position_of(sc_vec3 value)
{
    return (sc_plane_position){.value = value.x, .percent = value.y > 0};
}

static sc_status write_key_position(const sc_ctx *ctx, const sc_key *key, const void *value,
                                    sc_text *text)
{
    const sc_plane_position position = position_of(*(const sc_vec3 *)value);

    return sc_type_plane_position.write(ctx, key, &position, text);
}

static const sc_value_type type_key_position = {
    .name = "position",
    .expected = "a position such as 40% or 12 mm",
    .read = read_key_position,
    .write = write_key_position,
    .schema = "$position",
};

/* A position, a point, or key frames of positions; @p value is the whole plane_entry. */
static sc_status read_at(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    plane_entry *entry = value;
    sc_sweep *sweep = &entry->sweep;
    sc_status status;

    entry->has_point = node->kind == SC_YAML_LIST;
    if (entry->has_point)
        return sc_type_point.read(ctx, key, node, &entry->point_mm);
    if (!sc_is_track(node))
        return sc_type_plane_position.read(ctx, key, node, &sweep->at);
    status = sc_read_track(ctx, key, node, &sweep->at_track);
    if (status == SC_OK)
        sweep->at = position_of(sweep->at_track.keys[0].value);
    return status;
}

static sc_status write_at(const sc_ctx *ctx, const sc_key *key, const void *value, sc_text *text)
{
    const plane_entry *entry = value;
    const sc_sweep *sweep = &entry->sweep;

    if (entry->has_point)
        return sc_type_point.write(ctx, key, &entry->point_mm, text);
    return sweep->at_track.count ? sc_write_track(ctx, key, &sweep->at_track, text)
                                 : sc_type_plane_position.write(ctx, key, &sweep->at, text);
}

static const sc_value_type type_at = {
    .name = "position, [R, A, S] or key frames",
    .expected = "a position such as 40% or 12 mm, or a point of the plane, [R, A, S] in mm",
    .of_key_frames = &type_key_position,
    .read = read_at,
    .write = write_at,
    .schema = "{anyOf: [$position, $point, $track]}",
};

/* ---- boxes ---- */

/* Read corner @p c of a box, a list of three positions. */
static sc_status read_corner(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, size_t c,
                             sc_plane_position along[3])
{
    sc_status status = SC_OK;

    for (size_t i = 0; i < 3 && status == SC_OK; i++) {
        const sc_key each = {.name = key->name, .type = &sc_type_plane_position};
        sc_yaml item = *node->items[c]->items[i];

        item.key = node->key; /* for messages */
        status = each.type->read(ctx, &each, &item, &along[i]);
    }
    return status;
}

/* @p value is the whole plane_entry. */
static sc_status read_corners(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                              void *value)
{
    plane_entry *box = value;
    const bool are_two = node->kind == SC_YAML_LIST && node->count == 2;
    sc_status status;

    for (size_t i = 0; i < 2; i++) {
        if (!are_two || node->items[i]->kind != SC_YAML_LIST || node->items[i]->count != 3)
            return sc_wrong_type(ctx, node, key->type->expected);
    }
    status = read_corner(ctx, key, node, 0, box->from);
    (void)sc_goes_on(&status, read_corner(ctx, key, node, 1, box->to));
    for (int i = 0; i < 3 && status == SC_OK; i++) {
        const sc_plane_position low = box->from[i], high = box->to[i];

        if (low.percent == high.percent && low.value >= high.value)
            return sc_yaml_fail(ctx, node, "the box is empty along its axis %d: from %g to %g",
                                i + 1, low.value, high.value);
    }
    return status;
}

/* It has no write function, because a box is written as its six planes. */
static const sc_value_type type_corners = {
    .name = "two corners",
    .expected = "two corners along R, A and S, such as [[0%, 25%, 0%], [100%, 100%, 10 mm]]",
    .read = read_corners,
    .schema = SC_SCHEMA_LIST(SC_SCHEMA_LIST("$position", 3), 2),
};

/* ---- exceptions ---- */

static sc_status read_list(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    if (node->kind != SC_YAML_LIST)
        return sc_wrong_type(ctx, node, key->type->expected);
    return sc_yaml_copy(ctx, node, (sc_yaml **)value);
}

#define LIST_SCHEMA "{type: array, items: {type: string}}"

static const sc_value_type type_key_list = {
    .name = "list of tissues",
    .expected = "a list of tissues, such as [aorta] or []",
    .steps = true,
    .read = read_list,
    .schema = LIST_SCHEMA,
};

static const sc_key except_key = {.name = "except", .type = &type_key_list};

/* Keep the node, which read_entry reads for each plane of the entry. */
static sc_status keep_except(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    if (node->kind == SC_YAML_SCALAR)
        return sc_wrong_type(ctx, node, key->type->expected);
    ((plane_entry *)value)->except = node;
    return SC_OK;
}

/* Write the exceptions of one plane, in one of its spans, as a list in one line. */
static sc_status write_exceptions(const sc_ctx *ctx, const sc_job *job, int plane, int span,
                                  sc_text *text)
{
    const char *comma = "";

    SC_PASS(sc_text_add(ctx, text, "["));
    for (size_t e = 0; e < job->tissues.exception_count; e++) {
        if (job->tissues.exceptions[e].plane == plane && job->tissues.exceptions[e].span == span)
            SC_PASS(sc_write_item(ctx, &comma, job->tissues.exceptions[e].pattern, text));
    }
    return sc_text_add(ctx, text, "]");
}

/* Write the exceptions of the plane_entry @p value: a list of tissues, or a track of such. */
static sc_status write_except(const sc_ctx *ctx, const sc_key *key, const void *value,
                              sc_text *text)
{
    const plane_entry *entry = value;
    const sc_job *job = entry->job;
    const sc_sweep *sweep = &entry->sweep;
    const int plane = entry->plane;

    if (!sweep->except_count)
        return write_exceptions(ctx, job, plane, 0, text);
    for (int i = 0; i < sweep->except_count; i++) {
        SC_PASS(sc_text_add(ctx, text, i ? ", " : "{"));
        SC_PASS(sc_write_number(ctx, sweep->except_at[i], 100, "%: ", text));
        SC_PASS(write_exceptions(ctx, job, plane, i, text));
    }
    return sc_text_add(ctx, text, "}");
}

static const sc_value_type type_except = {
    .name = "list of tissues, or key frames",
    .expected = "a list of tissues, or key frames of such",
    .read = keep_except,
    .write = write_except,
    .of_key_frames = &type_key_list,
    .schema = "{anyOf: [" LIST_SCHEMA ", $track]}",
};

const sc_key sc_clip_keys[] = {
    {"normal", &sc_type_tracked_direction, PLANE(sweep.normal), NULL,
     .help = "direction towards what the plane keeps", .low = -1e6, .high = 1e6, .required = true,
     .track = offsetof(sc_sweep, normal_track) - offsetof(sc_sweep, normal),
     .alternative = "normal or box"},
    {"box", &type_corners, 0, NULL,
     .help = "instead of one plane six around what is kept: its corner at the patient's left, back "
             "and feet, and that at the right, front and head",
     .given = SC_GIVEN(plane_entry, has_box), .alternative = "normal or box", .required = true},
    {"at", &type_at, 0, "50%",
     .help =
         "where the plane stands: a share of the way through what is visible, mm along its normal, "
         "or a point of it in patient coordinates, as segcast still --sheet slices prints them",
     .low = -1e6, .high = 1e6},
    {"active", &sc_type_tracked_bool, PLANE(sweep.active), NULL,
     .help = "whether the plane, or the box, cuts; may have key frames, such as {0s: false, 2s: "
             "true, 5s: false}",
     .track = offsetof(sc_sweep, active_track) - offsetof(sc_sweep, active),
     .given = SC_GIVEN(plane_entry, sweep.has_active), .without = "true"},
    {"except", &type_except, 0, NULL,
     .help = "tissues that stay whole: names, globs or label numbers; may have key frames",
     .without = "none"},
    {0}};

/* ---- reading ---- */

/* Append the tissues of @p list to job->tissues.exceptions: the plane number @p plane of
 * job->animation.sweeps does not cut them in its span number @p span. @return the first mistake;
 * all are logged. */
static sc_status read_exceptions(const sc_ctx *ctx, const sc_yaml *list, int plane, int span,
                                 sc_job *job)
{
    static const sc_value_type type = {.expected = "the name of a tissue, or key frames alone"};
    sc_status status = SC_OK;

    SC_PASS(SC_RESIZE(ctx, job->tissues.exception_count, job->tissues.exception_count + list->count,
                      &job->tissues.exceptions));
    for (size_t i = 0; i < list->count; i++) {
        const sc_yaml item = sc_yaml_item(list, i);
        sc_clip_exception *to = &job->tissues.exceptions[job->tissues.exception_count];
        const sc_status found =
            sc_read_tissue(ctx, &(sc_key){.type = &type}, &item, to->pattern, to->where);

        to->plane = plane;
        to->span = span;
        job->tissues.exception_count += found == SC_OK;
        if (!sc_goes_on(&status, found))
            break;
    }
    return status;
}

/* Read the exceptions of the plane with that index: a list of tissues, or a track of such lists.
 * @return the first mistake; all are logged. */
static sc_status read_except(const sc_ctx *ctx, const sc_yaml *node, int plane, sc_job *job)
{
    sc_sweep *sweep = &job->animation.sweeps[plane];
    sc_yaml *lists[SC_CLIP_SPANS_MAX] = {NULL};
    sc_key_frame frames[SC_CLIP_SPANS_MAX];
    const sc_track_room room = {frames, lists, sizeof *lists, &sweep->except_count,
                                SC_CLIP_SPANS_MAX};
    sc_status status;

    if (node->kind == SC_YAML_LIST)
        return read_exceptions(ctx, node, plane, 0, job);
    status = sc_read_key_frames(ctx, &except_key, node, &room);
    for (int i = 0; i < SC_CLIP_SPANS_MAX; i++) {
        if (lists[i] && i < sweep->except_count) {
            sweep->except_at[i] = frames[i].at;
            (void)sc_goes_on(&status, read_exceptions(ctx, lists[i], plane, i, job));
        }
        sc_yaml_free(lists[i]);
    }
    return status;
}

/* Append a plane to job->animation.sweeps. */
static void add_plane(plane_entry *entry, sc_job *job)
{
    sc_sweep *sweep = &entry->sweep;

    if (entry->has_point)
        sweep->at = (sc_plane_position){.value = sc_vec3_dot(sweep->normal, entry->point_mm)};
    if (entry->has_point && sweep->normal_track.count) {
        sweep->has_point = true;
        sweep->point_mm = entry->point_mm;
    }
    job->animation.sweeps[job->animation.sweep_count++] = *sweep;
}

/* Append six planes whose normals point into the box to job->animation.sweeps. */
static void add_box(const plane_entry *box, sc_job *job)
{
    static const sc_vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    sc_sweep sweep = box->sweep; /* when it is active */

    for (int i = 0; i < 6; i++) {
        const sc_plane_position low = box->from[i / 2], high = box->to[i / 2];
        const sc_plane_position back = {high.percent ? 100 - high.value : -high.value,
                                        high.percent};

        sweep.normal = i % 2 ? sc_vec3_scale(axes[i / 2], -1) : axes[i / 2];
        sweep.at = i % 2 ? back : low;
        job->animation.sweeps[job->animation.sweep_count++] = sweep;
    }
}

/* Append the planes of one entry of the list to the job. @param to the entry, as it was read. */
static sc_status read_planes(const sc_ctx *ctx, const sc_key *keys, const sc_yaml *entry,
                             plane_entry *to, sc_job *job)
{
    SC_PASS(sc_keys_set_defaults(ctx, keys, to));
    SC_PASS(sc_keys_read(ctx, keys, entry, to));
    if (to->has_box && sc_yaml_member(entry, "at"))
        return sc_yaml_fail(
            ctx, sc_yaml_member(entry, "at"),
            "at: it is for a plane; expected its normal instead of a box, or no at");
    if (job->animation.sweep_count + (to->has_box ? 6 : 1) > SC_PLANES_MAX)
        return sc_yaml_fail(ctx, entry, "more than %d clip planes (a box counts as six)",
                            SC_PLANES_MAX);
    if (to->has_box)
        add_box(to, job);
    else
        add_plane(to, job);
    return SC_OK;
}

/* Append the planes and the exceptions of one entry of the list to the job. The exceptions are read
 * even if the planes are wrong, so that mistakes in both are told; they are those of plane 0 then.
 */
static sc_status read_entry(const sc_ctx *ctx, const sc_key *keys, const sc_yaml *entry,
                            sc_job *job)
{
    const int first = job->animation.sweep_count;
    plane_entry read = {0};
    int last, plane;
    sc_status status;

    if (entry->kind != SC_YAML_MAP)
        return sc_wrong_type(ctx, entry, "{normal: left, at: 40%} or {box: [[...], [...]]}");
    status = read_planes(ctx, keys, entry, &read, job);
    last = job->animation.sweep_count - 1;
    for (int i = first; i <= last; i++)
        sc_note_where(entry, job->lines.clip[i], sizeof job->lines.clip[i]);
    plane = last < first ? 0 : first;
    do {
        if (read.except && !sc_goes_on(&status, read_except(ctx, read.except, plane, job)))
            return status;
    } while (status == SC_OK && ++plane <= last);
    return status;
}

/* Read the list of clip entries. @p value is the whole sc_job: planes go to animation.sweeps,
 * tissues to exceptions. @return the first mistake; all are logged. */
static sc_status read_clip(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    sc_status status = SC_OK;

    if (node->kind != SC_YAML_LIST)
        return sc_wrong_type(ctx, node, key->type->expected);
    for (size_t i = 0; i < node->count; i++) {
        if (!sc_goes_on(&status, read_entry(ctx, key->keys, node->items[i], value)))
            break;
    }
    return status;
}

/* ---- writing ---- */

/* Write every plane with the tissues that it leaves whole. @p value is the whole sc_job. */
static sc_status write_clip(const sc_ctx *ctx, const sc_key *key, const void *value, int indent,
                            unsigned parts, sc_text *text)
{
    const sc_job *job = value;

    SC_PASS(sc_text_add(ctx, text, job->animation.sweep_count ? " " : " []"));
    for (int i = 0; i < job->animation.sweep_count; i++) {
        const sc_sweep *sweep = &job->animation.sweeps[i];
        const plane_entry entry = {.sweep = *sweep,
                                   .has_point = sweep->has_point,
                                   .point_mm = sweep->point_mm,
                                   .job = job,
                                   .plane = i};

        SC_PASS(sc_text_add(ctx, text, "\n%*s- ", indent + 2, ""));
        SC_PASS(sc_keys_write_flow(ctx, key->keys, &entry, text));
    }
    return sc_text_add(ctx, text, "\n");
}

const sc_value_type sc_type_clip = {
    .name = "list of planes",
    .expected = "a list of planes and boxes",
    .read = read_clip,
    .write_lines = write_clip,
    .schema = "{type: array, items: $keys}",
    .container = SC_CONTAINER_LIST,
};
