/* SPDX-License-Identifier: BSD-3-Clause */
/* Verbs of a job: what happens to tissues, to the camera or to clip planes in a part of the
 * animation. */
#include "key.h"
#include "segcast/job.h"

/* What a verb of the file is read into. The list of its tissues goes to the job. */
typedef struct verb_entry {
    sc_verb verb;
    sc_job *job;  /* borrowed */
    int index;    /* of the verb in the job */
    bool chooses; /* fly: it says where the way leads through its tissues */
    int held;     /* hold: always the orbit */
} verb_entry;

#define VERB(member) offsetof(verb_entry, verb.member)

/* ---- types of values ---- */

/* Read one tissue, or a list of them. @p value is the whole verb_entry. @return the first mistake;
 * all are logged. */
static sc_status read_verb_tissues(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                                   void *value)
{
    const verb_entry *entry = value;

    if (node->kind == SC_YAML_MAP || !sc_yaml_length(node))
        return sc_wrong_type(ctx, node, key->type->expected);
    return sc_read_tissues(ctx, key, node, entry->index, &entry->job->verbs.tissues,
                           &entry->job->verbs.tissue_count);
}

static sc_status write_verb_tissues(const sc_ctx *ctx, const sc_key *key, const void *value,
                                    sc_text *text)
{
    const verb_entry *entry = value;

    return sc_write_tissues(ctx, entry->job->verbs.tissues, entry->job->verbs.tissue_count,
                            entry->index, text);
}

static const sc_value_type type_verb_tissues = {
    .name = "tissues",
    .expected = "a tissue or a list of tissues: names, globs or label numbers",
    .read = read_verb_tissues,
    .write = write_verb_tissues,
    .schema = SC_SCHEMA_TISSUES,
};

/* Read an opacity from 0 to 1, or with a % sign what the tissue's own is multiplied by. @p value is
 * the whole verb_entry. */
static sc_status read_target(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    sc_verb *verb = &((verb_entry *)value)->verb;
    double target;
    const char *unit;

    if (!sc_parse_position(node, &target, &unit) || *unit == 'm' || target < 0 ||
        target > (*unit ? 1000 : 1))
        return sc_wrong_type(ctx, node, key->type->expected);
    verb->to_factor = *unit == '%';
    verb->to = verb->to_factor ? target / 100 : target;
    return SC_OK;
}

static sc_status write_target(const sc_ctx *ctx, const sc_key *key, const void *value,
                              sc_text *text)
{
    const sc_verb *verb = &((const verb_entry *)value)->verb;

    return sc_write_number(ctx, verb->to, verb->to_factor ? 100 : 1, verb->to_factor ? "%" : "",
                           text);
}

static const sc_value_type type_target = {
    .name = "opacity or share",
    .expected = "an opacity from 0 to 1, or a share of the tissue's own from 0% to 1000%",
    .read = read_target,
    .write = write_target,
    .schema = "{anyOf: [{type: number, minimum: 0, maximum: 1}, {type: string, pattern: '^[0-9.]+ "
              "*%$'}]}",
};

/* Read a list of points. @p value is the whole verb_entry. @return the first mistake. */
static sc_status read_points(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    sc_verb *verb = &((verb_entry *)value)->verb;
    const sc_key point = {
        .name = key->name, .type = &sc_type_point, .low = key->low, .high = key->high};

    if (node->kind != SC_YAML_LIST || !node->count || node->items[0]->kind != SC_YAML_LIST)
        return sc_wrong_type(ctx, node, key->type->expected);
    if (node->count > SC_THROUGH_MAX)
        return sc_yaml_fail(ctx, node, "there are %zu points, expected at most %d", node->count,
                            SC_THROUGH_MAX);
    verb->fly.through_count = (int)node->count; /* also after a mistake: then no more is said */
    for (size_t i = 0; i < node->count; i++) {
        const sc_yaml named = sc_yaml_item(node, i);

        SC_PASS(sc_type_point.read(ctx, &point, &named, &verb->fly.through[i]));
        if (i && sc_vec3_length(sc_vec3_sub(verb->fly.through[i], verb->fly.through[i - 1])) < 1e-9)
            return sc_yaml_fail(ctx, &named, "points %zu and %zu are the same, expected others", i,
                                i + 1);
    }
    return SC_OK;
}

static sc_status write_points(const sc_ctx *ctx, const sc_key *key, const void *value,
                              sc_text *text)
{
    const sc_verb *verb = &((const verb_entry *)value)->verb;

    for (int i = 0; i < verb->fly.through_count; i++) {
        SC_PASS(sc_text_add(ctx, text, "%s", i ? ", " : "["));
        SC_PASS(sc_type_point.write(ctx, key, &verb->fly.through[i], text));
    }
    return sc_text_add(ctx, text, "%s]", verb->fly.through_count ? "" : "[");
}

#define POINTS_SCHEMA                                                                              \
    "{type: array, minItems: 1, maxItems: $points_most, items: " SC_SCHEMA_LIST(SC_SCHEMA_NUMBER,  \
                                                                                3) "}"

/* Read where the way through tissues leads: points, or middles. */
static sc_status read_through(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                              void *value)
{
    bool *middles = &((verb_entry *)value)->verb.fly.middles;

    *middles = node->kind == SC_YAML_SCALAR && !strcmp(node->text, "middles");
    return *middles ? SC_OK : read_points(ctx, key, node, value);
}

static sc_status write_through(const sc_ctx *ctx, const sc_key *key, const void *value,
                               sc_text *text)
{
    return ((const verb_entry *)value)->verb.fly.middles ? sc_text_add(ctx, text, "middles")
                                                         : write_points(ctx, key, value, text);
}

static const sc_value_type type_through = {
    .name = "points or middles",
    .expected = "middles, or a list of points in RAS millimetres, such as [[0, 0, 10], [5, 0, 40]]",
    .read = read_through,
    .write = write_through,
    .schema = "{anyOf: [{const: middles}, " POINTS_SCHEMA "]}",
};

/* Read tissues, or the points of a curve. */
static sc_status read_fly(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    sc_verb *verb = &((verb_entry *)value)->verb;

    verb->fly.has_tissues =
        node->kind != SC_YAML_LIST || !node->count || node->items[0]->kind != SC_YAML_LIST;
    return (verb->fly.has_tissues ? read_verb_tissues : read_points)(ctx, key, node, value);
}

static sc_status write_fly(const sc_ctx *ctx, const sc_key *key, const void *value, sc_text *text)
{
    const bool has_tissues = ((const verb_entry *)value)->verb.fly.has_tissues;

    return (has_tissues ? write_verb_tissues : write_points)(ctx, key, value, text);
}

static const sc_value_type type_fly = {
    .name = "tissues or points",
    .expected = "a tissue, a list of tissues, or a list of points in RAS millimetres, such as [[0, "
                "0, 10], [5, 0, 40]]",
    .read = read_fly,
    .write = write_fly,
    .schema = "{anyOf: [" SC_SCHEMA_TISSUES ", " POINTS_SCHEMA "]}",
};

/* ---- rows ---- */

#define ORDER(word, order) {word, SC_ORDER_##order},
static const sc_choice orders[] = {{"list", SC_ORDER_LIST},
                                   {"largest", SC_ORDER_LARGEST},
                                   {"smallest", SC_ORDER_SMALLEST},
                                   SC_DIRECTION_WORDS(ORDER){NULL, 0}};

static const char *const held[] = {"orbit", NULL};

/* The verbs that have a key: bits by sc_verb_kind, for sc_key_scope.verbs. */
#define OF(kind) (1u << SC_VERB_##kind)

#define KINDS                                                                                      \
    "fade, appear, pulse, orbit, rock, zoom, dolly, hold, frame, fly, turn or "                    \
    "explode"
#define KIND .alternative = KINDS, .required = true
#define KIND_OF_TISSUES(kind, what)                                                                \
    {                                                                                              \
        kind, &type_verb_tissues, 0, NULL, .help = (what), KIND                                    \
    }
#define KIND_OF_ANGLE(kind, what)                                                                  \
    {                                                                                              \
        kind, &sc_type_real, VERB(angle_deg), NULL, .help = (what), .low = -36000, .high = 36000,  \
                                                    .unit = "degrees", KIND                        \
    }

/* First the kinds of verbs, by sc_verb_kind, each with what it is about as its value; then what
 * says more of them. */
const sc_key sc_verb_keys[] = {
    KIND_OF_TISSUES("fade", "tissues that come to another opacity, and keep it"),
    KIND_OF_TISSUES("appear",
                    "tissues that appear, one after the other; before, they are not seen"),
    KIND_OF_TISSUES("pulse", "tissues that become fainter and return"),
    KIND_OF_ANGLE("orbit", "how far the camera turns about the axis of the orbit, beside what it "
                           "does anyway; it stays there"),
    KIND_OF_ANGLE("rock", "how far the camera swings to each side"),
    {"zoom", &sc_type_real, VERB(to), NULL,
     .help = "scale of the picture in the end, to which it changes evenly to the eye; 1: as framed",
     .low = 0.01, .high = 1000, KIND},
    {"dolly", &sc_type_real, VERB(to), NULL,
     .help = "what the distance of the camera from its target is multiplied by: 0.5 is half as far",
     .low = 0.01, .high = 100, KIND},
    {"hold", &sc_type_choice, offsetof(verb_entry, held), NULL,
     .help = "the orbit pauses; it turns faster in the rest of the time, just as far",
     .words = held, KIND},
    KIND_OF_TISSUES(
        "frame", "tissues that come to fill the picture, and go on to, however the camera turns"),
    {"fly", &type_fly, 0, NULL,
     .help = "a flight of the camera along the centre line of tissues, vessels and chambers, or "
             "along a smooth curve through points in RAS mm; before, the camera is where it would "
             "be without, and afterwards it stays at the end",
     .low = -1e6, .high = 1e6, KIND},
    KIND_OF_ANGLE("turn", "how far a clip plane turns about a line, right-handed"),
    KIND_OF_TISSUES("explode", "tissues that move apart, and show what they hide"),
    {"to", &type_target, 0, "0",
     .help = "fade, pulse: the opacity that tissues come to, from 0 to 1, or a share of their own, "
             "such as 30%",
     .scope.verbs = OF(FADE) | OF(PULSE)},
    {"order", &sc_type_choice, VERB(order), "list",
     .help = "appear: which comes first: as listed, the largest, the smallest, or on the way "
             "towards a direction",
     .choices = orders, .scope.verbs = OF(APPEAR)},
    {"stagger", &sc_type_share, VERB(stagger), "100%",
     .help = "appear: how much of the time that one tissue takes passes before the next begins; "
             "0%: all appear together",
     .scope.verbs = OF(APPEAR)},
    {"times", &sc_type_int, VERB(times), "1",
     .help = "pulse, rock: how often, there and back, or to both sides and back", .low = 1,
     .high = 1000, .scope.verbs = OF(PULSE) | OF(ROCK)},
    {"elevation", &sc_type_real, VERB(elevation_deg), "0",
     .help = "orbit, rock: how far the camera rises, or swings up and down", .low = -36000,
     .high = 36000, .unit = "degrees", .scope.verbs = OF(ORBIT) | OF(ROCK)},
    {"soft", &sc_type_share, VERB(soft), "20%",
     .help = "hold: share of its time, up to 50%, in which the camera comes to rest, and in which "
             "it starts again",
     .scope.verbs = OF(HOLD)},
    {"through", &type_through, 0, NULL, .given = SC_GIVEN(verb_entry, chooses),
     .without = "from one end of the tissues to the other",
     .help = "fly: points in the tissues, in RAS mm, that choose the branch; or middles: the way "
             "leads from the middle of the first tissue, where it is thickest, to that of the "
             "next, in their order, to the last",
     .low = -1e6, .high = 1e6, .scope.verbs = OF(FLY)},
    {"ahead", &sc_type_share, VERB(fly.ahead), "10%",
     .help = "fly: how far ahead of itself the camera looks, as a share of the way",
     .scope.verbs = OF(FLY)},
    {"clearance", &sc_type_share, VERB(fly.clearance), "50%",
     .help = "fly: share of the distance between the middle of the tissues and their border which "
             "the smoothed way keeps from that border",
     .scope.verbs = OF(FLY)},
    {"fov", &sc_type_real, VERB(fly.fov_deg), "80", .help = "fly: vertical field of view", .low = 1,
     .high = 170, .unit = "degrees", .scope.verbs = OF(FLY)},
    {"plane", &sc_type_int, VERB(plane), "1",
     .help = "turn: number of the clip plane, counted from 1 in the order of clip; a box counts as "
             "six: left, right, back, front, bottom, top",
     .low = 1, .high = SC_PLANES_MAX, .scope.verbs = OF(TURN)},
    {"axis", &sc_type_direction, VERB(line.axis), NULL,
     .given = SC_GIVEN(verb_entry, verb.line.has_axis),
     .without = "turn: upwards in the picture, or for a plane across that to the front; explode: "
                "away from the center",
     .help = "turn: direction of the line; explode: direction in which all move, by so many mm, or "
             "by a share of the distance of each from the center along it",
     .low = -1e6, .high = 1e6, .scope.verbs = OF(TURN) | OF(EXPLODE)},
    {"center", &sc_type_point, VERB(line.point_mm), NULL,
     .given = SC_GIVEN(verb_entry, verb.line.has_point), .without = "the middle of what is visible",
     .help = "turn, explode: a point of the line; the point from which tissues move apart",
     .low = -1e6, .high = 1e6, .unit = "mm", .scope.verbs = OF(TURN) | OF(EXPLODE)},
    {"by", &sc_type_plane_position, VERB(by), "50%",
     .help = "explode: how far they move: mm, or a share of the distance of each from the center; "
             "below 0: the other way",
     .scope.verbs = OF(EXPLODE)},
    {"together", &sc_type_bool, VERB(together), "false",
     .help = "explode: they move as one, as if they were a single tissue; else each by itself",
     .scope.verbs = OF(EXPLODE)},
    {"during", &sc_type_span, VERB(begin), "[0%, 100%]",
     .help = "part of the animation in which it happens; what has changed stays so afterwards"},
    {"ease", &sc_type_ease, VERB(ease), "smooth", .help = "how the change begins and ends",
     .scope.verbs = ~OF(HOLD)},
    {0}};

/* The rows of one kind of verb: a table, which ends as any. */
typedef struct kind_rows {
    sc_key rows[SC_COUNT_OF(sc_verb_keys)];
} kind_rows;

static kind_rows rows_of(sc_verb_kind kind)
{
    kind_rows out = {0};
    size_t count = 0;

    for (const sc_key *row = sc_verb_keys; row->name; row++) {
        const bool is_kind = row->alternative != NULL;

        if (is_kind ? row == &sc_verb_keys[kind]
                    : !row->scope.verbs || row->scope.verbs & 1u << kind)
            out.rows[count++] = *row;
    }
    return out;
}

/* ---- reading ---- */

/* Find the one key of an entry of the list that names a verb. @return as sc_yaml_fail. */
static sc_status find_kind(const sc_ctx *ctx, const sc_key *keys, const sc_yaml *node,
                           const sc_yaml **named, sc_verb_kind *kind)
{
    int kinds = 0;
    sc_status status = SC_OK;

    if (node->kind != SC_YAML_MAP)
        return sc_wrong_type(ctx, node, "a verb such as {fade: skin, to: 0, during: [2s, 4s]}");
    for (size_t i = 0; i < node->count; i++) {
        const sc_key *key = sc_key_find(keys, node->items[i]->key);

        if (key && key->alternative) {
            kinds++;
            *kind = (sc_verb_kind)(key - keys);
            *named = node->items[i];
        }
    }
    for (size_t i = 0; i < node->count && !kinds; i++) {
        if (!sc_key_find(keys, node->items[i]->key)) /* it may be the verb, misspelt */
            (void)sc_goes_on(&status, sc_key_unknown(ctx, keys, node->items[i]));
    }
    if (kinds == 1 || status != SC_OK)
        return status;
    return sc_yaml_fail(ctx, node, "a verb has one of the keys " KINDS);
}

/* Read one entry of the list into the next verb of the job, for which there is room. */
static sc_status read_entry(const sc_ctx *ctx, const sc_key *keys, const sc_yaml *node, sc_job *job)
{
    verb_entry entry = {.job = job, .index = (int)job->verbs.count};
    const sc_yaml *named = NULL;
    kind_rows table;
    sc_status status;

    SC_PASS(find_kind(ctx, keys, node, &named, &entry.verb.kind));
    table = rows_of(entry.verb.kind);
    SC_TRY(sc_keys_set_defaults(ctx, table.rows, &entry));
    sc_note_where(named, entry.verb.where, sizeof entry.verb.where);
    SC_TRY(sc_keys_read(ctx, table.rows, node, &entry));
out:
    job->verbs.list[job->verbs.count++] = entry.verb;
    return status;
}

/* Read the list of verbs. @p value is the whole sc_job. @return the first mistake; all are logged.
 */
static sc_status read_verbs(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    sc_job *job = value;
    sc_status status = SC_OK;

    if (node->kind != SC_YAML_LIST)
        return sc_wrong_type(ctx, node, key->type->expected);
    if (node->count > SC_VERBS_MAX)
        return sc_yaml_fail(ctx, node, "there are %zu verbs, expected at most %d", node->count,
                            SC_VERBS_MAX);
    SC_PASS(SC_ZALLOC(ctx, node->count, &job->verbs.list));
    for (size_t i = 0; i < node->count; i++) {
        if (!sc_goes_on(&status, read_entry(ctx, key->keys, node->items[i], job)))
            break;
    }
    return status;
}

/* ---- writing ---- */

/* Write the verbs of the sc_job @p value, one to a line. */
static sc_status write_verbs(const sc_ctx *ctx, const sc_key *key, const void *value, int indent,
                             unsigned parts, sc_text *text)
{
    sc_job job = *(const sc_job *)value; /* borrows the arrays; they are only read */

    SC_PASS(sc_text_add(ctx, text, job.verbs.count ? " " : " []"));
    for (size_t i = 0; i < job.verbs.count; i++) {
        const verb_entry entry = {
            .verb = job.verbs.list[i],
            .job = &job,
            .index = (int)i,
            .chooses = job.verbs.list[i].fly.has_tissues &&
                       (job.verbs.list[i].fly.middles || job.verbs.list[i].fly.through_count)};
        const kind_rows table = rows_of(entry.verb.kind);

        SC_PASS(sc_text_add(ctx, text, "\n%*s- ", indent + 2, ""));
        SC_PASS(sc_keys_write_flow(ctx, table.rows, &entry, text));
    }
    return sc_text_add(ctx, text, "\n");
}

const sc_value_type sc_type_verbs = {
    .name = "list of verbs",
    .expected = "a list of verbs, such as - {fade: skin, to: 0, during: [2s, 4s]}",
    .read = read_verbs,
    .write_lines = write_verbs,
    .schema = "{type: array, maxItems: $verbs_most, items: $keys}",
    .container = SC_CONTAINER_LIST,
};
