/* SPDX-License-Identifier: BSD-3-Clause */
/* Verbs of a job: what happens to tissues, to the camera or to clip planes in a part of the
 * animation. */
#include "key.h"
#include "segcast/job.h"

#include <string.h>

/* What a verb of the file is read into. The list of its tissues goes to the job. */
typedef struct verb_entry {
    sc_verb verb;
    sc_job *job; /* borrowed */
    int index;   /* of the verb in the job */
} verb_entry;

#define VERB(member) offsetof(verb_entry, verb.member)

/* ---- types of values ---- */

/* Append one tissue of the present verb to the job. */
static sc_status add_tissue(const sc_ctx *ctx, const sc_key *key, const sc_yaml *list,
                            const sc_yaml *item, const verb_entry *entry)
{
    sc_verb_tissue *to = &entry->job->verb_tissues[entry->job->verb_tissue_count];

    if (item->kind != SC_YAML_SCALAR || !item->text[0] || strlen(item->text) >= SC_NAME_BYTES) {
        sc_yaml named = *item;

        named.key = list->key; /* for the message: items of a list have no key of their own */
        return sc_wrong_type(ctx, &named, key->type->expected);
    }
    *to = (sc_verb_tissue){.verb = entry->index};
    strcpy(to->pattern, item->text);
    sc_note_where(item, to->where, sizeof to->where);
    entry->job->verb_tissue_count++;
    return SC_OK;
}

/* Read one tissue, or a list of them. @p value is the whole verb_entry. @return the first mistake;
 * all are logged. */
static sc_status read_verb_tissues(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                                   void *value)
{
    const verb_entry *entry = value;
    sc_job *job = entry->job;
    const bool is_one = node->kind == SC_YAML_SCALAR;
    const size_t count = is_one ? 1 : node->count;
    void *grown;
    sc_status status;

    if (node->kind == SC_YAML_MAP || !count)
        return sc_wrong_type(ctx, node, key->type->expected);
    status = sc_zalloc(ctx, job->verb_tissue_count + count, sizeof *job->verb_tissues, &grown);
    if (status != SC_OK)
        return status;
    if (job->verb_tissue_count)
        memcpy(grown, job->verb_tissues, job->verb_tissue_count * sizeof *job->verb_tissues);
    sc_free(job->verb_tissues);
    job->verb_tissues = grown;
    for (size_t i = 0; i < count; i++) {
        if (!sc_goes_on(&status, add_tissue(ctx, key, node, is_one ? node : node->items[i], entry)))
            break;
    }
    return status;
}

/* Write the tissues of the verb, [a, "b*"], as read_verb_tissues reads them. */
static sc_status write_verb_tissues(const sc_ctx *ctx, const sc_key *key, const void *value,
                                    int indent, sc_text *text)
{
    const verb_entry *entry = value;
    const char *comma = "[";
    sc_status status = SC_OK;

    (void)key;
    (void)indent;
    for (size_t i = 0; i < entry->job->verb_tissue_count; i++) {
        if (entry->job->verb_tissues[i].verb != entry->index)
            continue;
        SC_TRY(sc_text_add(ctx, text, "%s", comma));
        SC_TRY(sc_write_quoted(ctx, entry->job->verb_tissues[i].pattern, text));
        comma = ", ";
    }
    status = sc_text_add(ctx, text, "]");
out:
    return status;
}

static json_t *verb_tissues_schema(const sc_key *key)
{
    (void)key;
    return json_pack("{s:[{s:[ss]}, {s:s, s:i, s:{s:[ss]}}]}", "anyOf", "type", "string", "integer",
                     "type", "array", "minItems", 1, "items", "type", "string", "integer");
}

static const sc_value_type type_verb_tissues = {
    .name = "tissues",
    .expected = "a tissue or a list of tissues: names, globs or label numbers",
    .read = read_verb_tissues,
    .write = write_verb_tissues,
    .schema = verb_tissues_schema,
};

/* Read an opacity from 0 to 1, or with a % sign what the tissue's own is multiplied by. @p value is
 * the whole verb_entry. */
static sc_status read_target(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    verb_entry *entry = value;
    sc_yaml number = *node;
    char text[64] = "";
    size_t length = 0;
    double target;

    if (node->kind == SC_YAML_SCALAR) {
        length = strlen(node->text);
        snprintf(text, sizeof text, "%s", node->text);
        number.text = text;
    }
    entry->verb.to_factor = length > 1 && length < sizeof text && text[length - 1] == '%';
    if (entry->verb.to_factor)
        text[length - 1] = '\0';
    if (length >= sizeof text || !sc_parse_number(&number, &target) || target < 0 ||
        target > (entry->verb.to_factor ? 1000 : 1))
        return sc_wrong_type(ctx, node, key->type->expected);
    entry->verb.to = entry->verb.to_factor ? target / 100 : target;
    return SC_OK;
}

static sc_status write_target(const sc_ctx *ctx, const sc_key *key, const void *value, int indent,
                              sc_text *text)
{
    const sc_verb *verb = &((const verb_entry *)value)->verb;

    (void)key;
    (void)indent;
    return sc_write_number(ctx, verb->to, verb->to_factor ? 100 : 1, verb->to_factor ? "%" : "",
                           text);
}

static json_t *target_schema(const sc_key *key)
{
    (void)key;
    return json_pack("{s:[{s:s, s:i, s:i}, {s:s, s:s}]}", "anyOf", "type", "number", "minimum", 0,
                     "maximum", 1, "type", "string", "pattern", "^[0-9.]+ *%$");
}

static const sc_value_type type_target = {
    .name = "opacity or share",
    .expected = "an opacity from 0 to 1, or a share of the tissue's own from 0% to 1000%",
    .read = read_target,
    .write = write_target,
    .schema = target_schema,
};

/* Read a list of points. @p value is the whole verb_entry. @return the first mistake. */
static sc_status read_through(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                              void *value)
{
    sc_verb *verb = &((verb_entry *)value)->verb;
    const sc_key point = {
        .name = key->name, .type = &sc_type_point, .low = key->low, .high = key->high};
    sc_status status = SC_OK;

    if (node->kind != SC_YAML_LIST || !node->count || node->items[0]->kind != SC_YAML_LIST)
        return sc_wrong_type(ctx, node, key->type->expected);
    if (node->count > SC_THROUGH_MAX)
        return sc_yaml_fail(ctx, node, "there are %zu points, expected at most %d", node->count,
                            SC_THROUGH_MAX);
    verb->through_count = (int)node->count; /* also after a mistake: then no more is said */
    for (size_t i = 0; i < node->count; i++) {
        sc_yaml named = *node->items[i];

        named.key = node->key; /* for messages: items of a list have no key of their own */
        SC_TRY(sc_type_point.read(ctx, &point, &named, &verb->through[i]));
        if (i && sc_vec3_length(sc_vec3_sub(verb->through[i], verb->through[i - 1])) < 1e-9)
            return sc_yaml_fail(ctx, &named, "points %zu and %zu are the same, expected others", i,
                                i + 1);
    }
out:
    return status;
}

static sc_status write_through(const sc_ctx *ctx, const sc_key *key, const void *value, int indent,
                               sc_text *text)
{
    const sc_verb *verb = &((const verb_entry *)value)->verb;
    sc_status status = SC_OK;

    for (int i = 0; i < verb->through_count; i++) {
        SC_TRY(sc_text_add(ctx, text, "%s", i ? ", " : "["));
        SC_TRY(sc_type_point.write(ctx, key, &verb->through[i], indent, text));
    }
    status = sc_text_add(ctx, text, "%s]", verb->through_count ? "" : "[");
out:
    return status;
}

static json_t *through_schema(const sc_key *key)
{
    return json_pack("{s:s, s:i, s:i, s:o}", "type", "array", "minItems", 1, "maxItems",
                     SC_THROUGH_MAX, "items", sc_list_schema("number", key->low, key->high, 3));
}

static const sc_value_type type_through = {
    .name = "points",
    .expected = "a list of points in RAS millimetres, such as [[0, 0, 10], [5, 0, 40]]",
    .read = read_through,
    .write = write_through,
    .schema = through_schema,
};

/* ---- rows ---- */

static const sc_choice orders[] = {
    {"list", SC_ORDER_LIST},           {"largest", SC_ORDER_LARGEST},
    {"smallest", SC_ORDER_SMALLEST},   {"right", SC_ORDER_RIGHT},
    {"left", SC_ORDER_LEFT},           {"anterior", SC_ORDER_ANTERIOR},
    {"posterior", SC_ORDER_POSTERIOR}, {"superior", SC_ORDER_SUPERIOR},
    {"inferior", SC_ORDER_INFERIOR},   {NULL, 0}};

#define TISSUES_ROW                                                                                \
    {                                                                                              \
        "tissues", &type_verb_tissues, 0, NULL,                                                    \
            .help = "a tissue or a list of tissues: names, globs or label numbers",                \
            .required = true                                                                       \
    }
#define DURING_ROW(what)                                                                           \
    {                                                                                              \
        "during", &sc_type_span, VERB(begin), "[0%, 100%]",                                        \
            .help = "part of the animation in which " what                                         \
    }
#define EASE_ROW(fallback)                                                                         \
    {                                                                                              \
        "ease", &sc_type_ease, VERB(ease), fallback, .help = "how the change begins and ends"      \
    }

static const sc_key fade_keys[] = {
    TISSUES_ROW,
    {"to", &type_target, 0, "0",
     .help = "the opacity in the end, from 0 to 1, or a share of the tissue's own, such as 30%"},
    DURING_ROW("the opacity changes; it stays so afterwards"),
    EASE_ROW("smooth"),
    {0}};

static const sc_key appear_keys[] = {
    TISSUES_ROW,
    {"order", &sc_type_choice, VERB(order), "list",
     .help = "which comes first: as listed, the largest, the smallest, or on the way towards a "
             "direction",
     .choices = orders},
    {"stagger", &sc_type_share, VERB(stagger), "100%",
     .help = "how much of the time that one tissue takes passes before the next begins; 0%: all "
             "appear together"},
    DURING_ROW("they appear; before, they are not seen"),
    EASE_ROW("smooth"),
    {0}};

static const sc_key pulse_keys[] = {
    TISSUES_ROW,
    {"to", &type_target, 0, "20%",
     .help = "the opacity at the turning points, from 0 to 1, or a share of the tissue's own"},
    {"times", &sc_type_int, VERB(times), "3", .help = "how often it goes there and back", .low = 1,
     .high = 1000},
    DURING_ROW("the opacity changes"),
    EASE_ROW("smooth"),
    {0}};

/* ---- rows of verbs of the camera ---- */

#define ANGLE_ROW(fallback, what)                                                                  \
    {                                                                                              \
        "angle", &sc_type_real, VERB(angle_deg), fallback, .help = (what), .low = -36000,          \
                                                           .high = 36000, .unit = "degrees"        \
    }
#define ELEVATION_ROW(what)                                                                        \
    {                                                                                              \
        "elevation", &sc_type_real, VERB(elevation_deg), "0", .help = (what), .low = -36000,       \
                                                              .high = 36000, .unit = "degrees"     \
    }

static const sc_key orbit_keys[] = {
    ANGLE_ROW("0", "how far the camera turns about the axis of the orbit, beside what it does "
                   "anyway"),
    ELEVATION_ROW("how far it rises"),
    DURING_ROW("it turns; it stays there afterwards"),
    EASE_ROW("smooth"),
    {0}};

static const sc_key rock_keys[] = {ANGLE_ROW("20", "how far the camera swings to each side"),
                                   ELEVATION_ROW("how far it swings up and down"),
                                   {"times", &sc_type_int, VERB(times), "1",
                                    .help = "how often it swings to both sides and returns",
                                    .low = 1, .high = 1000},
                                   DURING_ROW("it swings"),
                                   EASE_ROW("smooth"),
                                   {0}};

static const sc_key zoom_keys[] = {
    {"to", &sc_type_real, VERB(to), NULL, .help = "scale of the picture in the end; 1: as framed",
     .low = 0.01, .high = 1000, .required = true},
    DURING_ROW("the scale changes, evenly to the eye; it stays so afterwards"),
    EASE_ROW("smooth"),
    {0}};

static const sc_key dolly_keys[] = {
    {"to", &sc_type_real, VERB(to), NULL,
     .help = "what the distance of the camera from its target is multiplied by: 0.5 is half as far",
     .low = 0.01, .high = 100, .required = true},
    DURING_ROW("it moves; it stays there afterwards"),
    EASE_ROW("smooth"),
    {0}};

static const sc_key hold_keys[] = {
    DURING_ROW("the orbit pauses; it turns faster in the rest of the time, just as far"),
    {"soft", &sc_type_share, VERB(soft), "20%",
     .help = "share of that part, up to 50%, in which the camera comes to rest, and in which it "
             "starts again"},
    {0}};

static const sc_key frame_keys[] = {
    TISSUES_ROW,
    DURING_ROW("the camera moves so that they fill the picture; they do so afterwards, however it "
               "turns"),
    EASE_ROW("smooth"),
    {0}};

static const sc_key fly_keys[] = {
    {"tissues", &type_verb_tissues, 0, NULL, .given = SC_GIVEN(verb_entry, verb.has_tissues),
     .without = "the way is a smooth curve through the points",
     .help = "tissues through the middle of which the camera flies, along their centre line"},
    {"through", &type_through, 0, NULL, .given = SC_GIVEN(verb_entry, verb.has_through),
     .without = "from one end of the tissues to the other",
     .help = "points of the way, in RAS mm: with tissues, in which they lie, those that choose the "
             "branch; without, of a smooth curve",
     .low = -1e6, .high = 1e6, .unit = "mm"},
    {"middles", &sc_type_bool, VERB(middles), "false",
     .help = "the way leads from the middle of the first of the tissues to that of the next, in "
             "their order, to the middle of the last; the middle is where a tissue is thickest"},
    {"ahead", &sc_type_share, VERB(ahead), "10%",
     .help = "how far ahead of itself the camera looks, as a share of the way"},
    {"clearance", &sc_type_share, VERB(clearance), "50%",
     .help = "share of the distance between the middle of the tissues and their border which the "
             "smoothed way keeps from that border"},
    {"fov", &sc_type_real, VERB(fov_deg), "80", .help = "vertical field of view of the flight",
     .low = 1, .high = 170, .unit = "degrees"},
    DURING_ROW("the camera flies; before, it is where it would be without, and afterwards it stays "
               "at the end"),
    EASE_ROW("smooth"),
    {0}};

#define PLANE_ROW                                                                                  \
    {                                                                                              \
        "plane", &sc_type_int, VERB(plane), "1",                                                   \
            .help = "number of the clip plane, counted from 1 in the order of clip; a box counts " \
                    "as six: left, right, back, front, bottom, top",                               \
            .low = 1, .high = SC_PLANES_MAX                                                        \
    }

static const sc_key sweep_verb_keys[] = {
    PLANE_ROW,
    {"to", &sc_type_plane_position, VERB(by), NULL,
     .help = "where the plane ends, from where it stands: a share of the way through what is "
             "visible, or mm along its normal",
     .required = true},
    DURING_ROW("it moves; it stays there afterwards"),
    EASE_ROW("smooth"),
    {0}};

static const sc_key turn_keys[] = {
    PLANE_ROW,
    {"angle", &sc_type_real, VERB(angle_deg), NULL,
     .help = "how far the plane turns about the axis, right-handed", .low = -36000, .high = 36000,
     .unit = "degrees", .required = true},
    {"axis", &sc_type_direction, VERB(axis), NULL, .given = SC_GIVEN(verb_entry, verb.has_axis),
     .without = "upwards in the picture; for a plane across that, to the front",
     .help = "direction of the line about which it turns", .low = -1e6, .high = 1e6},
    {"at_point", &sc_type_point, VERB(point_mm), NULL,
     .given = SC_GIVEN(verb_entry, verb.has_point), .without = "the middle of what is visible",
     .help = "a point of that line, in RAS mm", .low = -1e6, .high = 1e6, .unit = "mm"},
    DURING_ROW("it turns; it stays so afterwards"),
    EASE_ROW("smooth"),
    {0}};

static const sc_key explode_keys[] = {
    TISSUES_ROW,
    {"by", &sc_type_plane_position, VERB(by), "50%",
     .help = "how far they move: mm, or a share of the distance of each from the center; below 0: "
             "the other way"},
    {"center", &sc_type_point, VERB(point_mm), NULL, .given = SC_GIVEN(verb_entry, verb.has_point),
     .without = "the middle of what is visible",
     .help = "the point from which they move apart, in RAS mm", .low = -1e6, .high = 1e6,
     .unit = "mm"},
    {"along", &sc_type_direction, VERB(axis), NULL, .given = SC_GIVEN(verb_entry, verb.has_axis),
     .without = "away from the center, each in its own direction",
     .help = "direction in which all of them move: by so many mm, or by a share of the distance of "
             "each from the center along it",
     .low = -1e6, .high = 1e6},
    {"together", &sc_type_bool, VERB(together), "false",
     .help = "they move as one, as if they were a single tissue; else each by itself"},
    DURING_ROW("they move; they stay there afterwards"),
    EASE_ROW("smooth"),
    {0}};

#define KINDS                                                                                      \
    "fade, appear, pulse, orbit, rock, zoom, dolly, hold, frame, fly, sweep, turn or "             \
    "explode"
#define KIND_ROW(name, rows, what)                                                                 \
    {                                                                                              \
        name, &sc_type_map, 0, NULL, .help = (what), .keys = (rows), .alternative = KINDS,         \
                                     .required = true                                              \
    }

const sc_key sc_verb_keys[] = {
    KIND_ROW("fade", fade_keys, "tissues become more or less opaque, or disappear"),
    KIND_ROW("appear", appear_keys, "tissues appear, one after the other"),
    KIND_ROW("pulse", pulse_keys, "tissues become fainter and return, several times"),
    KIND_ROW("orbit", orbit_keys, "the camera turns by an angle"),
    KIND_ROW("rock", rock_keys, "the camera swings to both sides, several times"),
    KIND_ROW("zoom", zoom_keys, "the picture is scaled"),
    KIND_ROW("dolly", dolly_keys, "the camera comes nearer, or goes away"),
    KIND_ROW("hold", hold_keys, "the turning of the orbit pauses"),
    KIND_ROW("frame", frame_keys, "tissues come to fill the picture"),
    KIND_ROW("fly", fly_keys, "the camera flies through vessels and chambers, or along points"),
    KIND_ROW("sweep", sweep_verb_keys, "a clip plane moves along its normal"),
    KIND_ROW("turn", turn_keys, "a clip plane turns about a line"),
    KIND_ROW("explode", explode_keys, "tissues move apart, and show what they hide"),
    {0}};

/* @return the row of a kind of verb: its index in sc_verb_keys. */
static const sc_key *row_of(sc_verb_kind kind)
{
    return &sc_verb_keys[kind];
}

/* ---- reading ---- */

/* Find the row of the only key of an entry of the list, and the map that stands there. @return as
 * sc_yaml_fail. */
static sc_status find_kind(const sc_ctx *ctx, const sc_key *keys, const sc_yaml *node,
                           sc_verb_kind *kind)
{
    const sc_key *key;

    if (node->kind != SC_YAML_MAP || node->count != 1)
        return node->kind == SC_YAML_MAP
                   ? sc_yaml_fail(ctx, node, "a verb is one map: either " KINDS)
                   : sc_wrong_type(ctx, node, "{fade: {...}}, {appear: {...}} or another verb");
    key = sc_key_find(keys, node->items[0]->key);
    if (!key)
        return sc_key_unknown(ctx, keys, node->items[0]);
    *kind = (sc_verb_kind)(key - keys);
    return node->items[0]->kind == SC_YAML_MAP
               ? SC_OK
               : sc_wrong_type(ctx, node->items[0], key->type->expected);
}

/* Read one entry of the list into the next verb of the job, for which there is room. */
static sc_status read_entry(const sc_ctx *ctx, const sc_key *keys, const sc_yaml *node, sc_job *job)
{
    verb_entry entry = {.job = job, .index = (int)job->verb_count};
    sc_status status = find_kind(ctx, keys, node, &entry.verb.kind);

    if (status != SC_OK)
        return status;
    SC_TRY(sc_keys_set_defaults(ctx, row_of(entry.verb.kind)->keys, &entry));
    sc_note_where(node->items[0], entry.verb.where, sizeof entry.verb.where);
    SC_TRY(sc_keys_read(ctx, row_of(entry.verb.kind)->keys, node->items[0], &entry));
out:
    job->verbs[job->verb_count++] = entry.verb;
    return status;
}

/* Read the list of verbs. @p value is the whole sc_job. @return the first mistake; all are logged.
 */
static sc_status read_verbs(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    sc_job *job = value;
    void *block;
    sc_status status;

    if (node->kind != SC_YAML_LIST)
        return sc_wrong_type(ctx, node, key->type->expected);
    if (node->count > SC_VERBS_MAX)
        return sc_yaml_fail(ctx, node, "there are %zu verbs, expected at most %d", node->count,
                            SC_VERBS_MAX);
    status = sc_zalloc(ctx, node->count, sizeof *job->verbs, &block);
    if (status != SC_OK)
        return status;
    job->verbs = block;
    for (size_t i = 0; i < node->count; i++) {
        if (!sc_goes_on(&status, read_entry(ctx, key->keys, node->items[i], job)))
            break;
    }
    return status;
}

/* ---- writing ---- */

/* Write the verbs of the sc_job @p value, one to a line. */
static sc_status write_verbs(const sc_ctx *ctx, const sc_key *key, const void *value, int indent,
                             sc_text *text)
{
    sc_job job = *(const sc_job *)value; /* borrows the arrays; they are only read */
    sc_status status = sc_text_add(ctx, text, "%s", job.verb_count ? "" : "[]");

    (void)key;
    for (size_t i = 0; i < job.verb_count && status == SC_OK; i++) {
        const verb_entry entry = {.verb = job.verbs[i], .job = &job, .index = (int)i};
        const sc_key *row = row_of(entry.verb.kind);

        SC_TRY(sc_text_add(ctx, text, "\n%*s- %s: ", indent + 2, "", row->name));
        status = sc_keys_write_flow(ctx, row->keys, &entry, text);
    }
out:
    return status;
}

static json_t *verbs_schema(const sc_key *key)
{
    return json_pack("{s:s, s:i, s:o}", "type", "array", "maxItems", SC_VERBS_MAX, "items",
                     sc_keys_schema(key->keys));
}

const sc_value_type sc_type_verbs = {
    .name = "list of verbs",
    .expected = "a list of verbs, such as - fade: {tissues: skin, to: 0, during: [2s, 4s]}",
    .read = read_verbs,
    .write = write_verbs,
    .schema = verbs_schema,
    .container = SC_CONTAINER_LIST,
};
