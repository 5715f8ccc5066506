/* SPDX-License-Identifier: BSD-3-Clause */
/* Tissues of a job: rules by name, glob or label number. */
#include "key.h"
#include "segcast/job.h"

#include <math.h>

/* What an entry of the file is read into. */
typedef struct rule_entry {
    sc_tissue_rule rule;
    sc_track color_track, opacity_track, visible_track, offset_track;
} rule_entry;

/* Read a number, "auto" or key frames of numbers, of which the greatest becomes the opacity of the
 * rule. @param value the whole rule_entry (the offset of the row is 0), because "auto" is stored in
 * a flag of its own. */
static sc_status read_opacity(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                              void *value)
{
    rule_entry *entry = value;
    sc_tissue_rule *rule = &entry->rule;
    const bool is_auto = node->kind == SC_YAML_SCALAR && !strcmp(node->text, "auto");
    sc_status status = SC_OK;

    if (sc_is_track(node)) {
        status = sc_read_track(ctx, key, node, &entry->opacity_track);
        rule->opacity = 0;
        for (int i = 0; i < entry->opacity_track.count; i++)
            rule->opacity = fmax(rule->opacity, entry->opacity_track.keys[i].value.x);
        return status;
    }
    if (node->kind == SC_YAML_SCALAR && !is_auto && !strchr("0123456789.", node->text[0]))
        return sc_wrong_type(ctx, node, key->type->expected);
    if (!is_auto)
        status = sc_read_real(ctx, node, key->low, key->high, &rule->opacity);
    if (status == SC_OK)
        rule->opacity_auto = is_auto;
    return status;
}

/* Write what read_opacity reads: key frames, "auto" or a number. */
static sc_status write_opacity(const sc_ctx *ctx, const sc_key *key, const void *value,
                               sc_text *text)
{
    const rule_entry *entry = value;
    const sc_tissue_rule *rule = &entry->rule;

    if (entry->opacity_track.count)
        return sc_write_track(ctx, key, &entry->opacity_track, text);
    if (rule->opacity_auto)
        return sc_text_add(ctx, text, "auto");
    return sc_write_number(ctx, rule->opacity, 1, "", text);
}

static const sc_value_type type_opacity = {
    .name = "number, auto or key frames",
    .expected = "auto, a number from 0 to 1, or key frames such as {0s: 1, 4s: 0.2}",
    .read = read_opacity,
    .write = write_opacity,
    .schema = "{anyOf: [{anyOf: [" SC_SCHEMA_NUMBER ", {enum: [auto]}]}, $track]}",
};

/* double: a number, or auto, which is below 0. */
static sc_status read_interior(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                               void *value)
{
    if (node->kind != SC_YAML_SCALAR || strcmp(node->text, "auto"))
        return sc_type_real.read(ctx, key, node, value);
    *(double *)value = -1;
    return SC_OK;
}

static sc_status write_interior(const sc_ctx *ctx, const sc_key *key, const void *value,
                                sc_text *text)
{
    if (*(const double *)value < 0)
        return sc_text_add(ctx, text, "auto");
    return sc_type_real.write(ctx, key, value, text);
}

static const sc_value_type type_interior = {
    .name = "number or auto",
    .expected = "auto or a number from 0 to 1",
    .read = read_interior,
    .write = write_interior,
    .schema = "{anyOf: [" SC_SCHEMA_NUMBER ", {enum: [auto]}]}",
};

#define RULE(member) (offsetof(rule_entry, rule) + offsetof(sc_tissue_rule, member))
/* The value of a macro as a string literal. */
#define TEXT(macro) TEXT_OF(macro)
#define TEXT_OF(number) #number

#define HAS(member) .given = SC_GIVEN(rule_entry, rule.has.member)

const sc_key sc_tissue_keys[] = {
    {"color", &sc_type_tracked_color, RULE(rgb), NULL, .help = "colour of the tissue", HAS(color),
     .track = offsetof(rule_entry, color_track) - RULE(rgb),
     .without = "the label table's, else distinct colours"},
    {"opacity", &type_opacity, 0, NULL,
     .help = "opacity of its surface (voxel surface: per voxel length), or auto: see "
             "render.auto_opacity; may have key frames",
     .low = 0, .high = 1, HAS(opacity), .without = "the label table's, else auto"},
    {"interior_opacity", &type_interior, RULE(interior_opacity), NULL,
     .help = "opacity of its other voxels, per voxel length, or auto: that of its surface, as the "
             "paper draws without acceleration; only for surface: voxel",
     .low = 0, .high = 1, HAS(interior_opacity), .without = "0"},
    {"visible", &sc_type_tracked_bool, RULE(visible), NULL,
     .help = "whether the tissue is shown at all; may have key frames, at which it comes and goes",
     HAS(visible), .track = offsetof(rule_entry, visible_track) - RULE(visible),
     .without = "the label table's, else true"},
    {"offset", &sc_type_tracked_point, RULE(offset_mm), NULL,
     .help = "how far the tissue is moved from its place; may have key frames", .low = -1e6,
     .high = 1e6, .unit = "mm", HAS(offset),
     .track = offsetof(rule_entry, offset_track) - RULE(offset_mm), .without = "not at all"},
    {"smooth", &sc_type_strength, RULE(smooth), NULL,
     .help = "strength of the smoothing of its surface, as render.smooth; the border between two "
             "tissues has the weaker of theirs",
     .low = 0, .high = SC_SMOOTH_MAX, HAS(smooth), .without = "render.smooth",
     .scope.of_film = true},
    {"specular", &sc_type_real, RULE(material.specular), NULL, .help = "strength of highlights",
     .low = 0, .high = 2, HAS(specular), .without = TEXT(SC_MATERIAL_SPECULAR)},
    {"roughness", &sc_type_real, RULE(material.roughness), NULL,
     .help = "how rough its face is, as in Blender or glTF: the larger, the wider its highlights",
     .low = 0.1, .high = 1, HAS(roughness), .without = TEXT(SC_MATERIAL_ROUGHNESS)},
    {"coat", &sc_type_real, RULE(material.coat), NULL,
     .help = "a clear, smooth coat over it, as in Blender or glTF: sharp highlights, as of what is "
             "wet; by paths it mirrors sky and lamp, too",
     .low = 0, .high = 1, HAS(coat), .without = TEXT(SC_MATERIAL_COAT)},
    {0}};

/* The key frames of an entry, and where a rule has their numbers. */
static const struct {
    size_t track, number;
} tracks[] = {{offsetof(rule_entry, color_track), RULE(color_track)},
              {offsetof(rule_entry, opacity_track), RULE(opacity_track)},
              {offsetof(rule_entry, visible_track), RULE(visible_track)},
              {offsetof(rule_entry, offset_track), RULE(offset_track)}};

static sc_track *track_at(rule_entry *entry, size_t i)
{
    return (sc_track *)((char *)entry + tracks[i].track);
}

static int *number_at(rule_entry *entry, size_t i)
{
    return (int *)((char *)entry + tracks[i].number);
}

/* Append the key frames that an entry has to the list of the job. There is always room for a power
 * of two, so that the lists, which take kilobytes, are copied a few times only. */
static sc_status keep_tracks(const sc_ctx *ctx, rule_entry *entry, sc_job *job)
{
    for (size_t i = 0; i < SC_COUNT_OF(tracks); i++) {
        const size_t count = job->tissues.track_count;

        if (!track_at(entry, i)->count)
            continue;
        if (!(count & (count - 1)))
            SC_PASS(SC_RESIZE(ctx, count, count ? 2 * count : 1, &job->tissues.tracks));
        job->tissues.tracks[job->tissues.track_count++] = *track_at(entry, i);
        *number_at(entry, i) = (int)job->tissues.track_count;
    }
    return SC_OK;
}

/* Read the look of one tissue into @p rule, which is zero, and its key frames into the job. */
static sc_status read_rule(const sc_ctx *ctx, const sc_key *key, const sc_yaml *item, sc_job *job,
                           sc_tissue_rule *rule)
{
    rule_entry entry;
    sc_status status;

    if (!item->key[0])
        return sc_yaml_fail(ctx, item,
                            "a tissue has no name (\"\"), expected a name, a glob such as \"*\", "
                            "or the number of a label");
    if (strlen(item->key) >= SC_NAME_BYTES)
        return sc_yaml_fail(ctx, item, "a tissue's name has %zu bytes, expected less than %d",
                            strlen(item->key), SC_NAME_BYTES);
    strcpy(rule->pattern, item->key);
    sc_note_where(item, rule->where, sizeof rule->where);
    if (item->kind != SC_YAML_MAP)
        return sc_wrong_type(ctx, item, "{color, opacity, visible, ...}");
    entry = (rule_entry){.rule = *rule};
    status = sc_keys_read(ctx, key->keys, item, &entry);
    if (status == SC_OK)
        status = keep_tracks(ctx, &entry, job);
    *rule = entry.rule;
    return status;
}

/* Read a rule for each tissue of the map into job->tissues.rules, in the order of the file. @p
 * value is the whole sc_job. @return the first mistake; all are logged. */
static sc_status read_tissues(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                              void *value)
{
    sc_job *job = value;

    sc_status status = SC_OK;

    if (node->kind != SC_YAML_MAP)
        return sc_wrong_type(ctx, node, key->type->expected);
    SC_PASS(SC_ZALLOC(ctx, node->count, &job->tissues.rules));
    for (size_t i = 0; i < node->count; i++) {
        if (!sc_goes_on(&status, read_rule(ctx, key, node->items[i], job,
                                           &job->tissues.rules[job->tissues.rule_count])))
            break;
        if (job->tissues.rules[job->tissues.rule_count].pattern[0])
            job->tissues.rule_count++;
    }
    return status;
}

/* Write all rules of the sc_job @p value, but those that a shot has from its film, with the keys
 * that were given, each in a line of its own; "{}" where there are no rules. */
static sc_status write_tissues(const sc_ctx *ctx, const sc_key *key, const void *value, int indent,
                               unsigned parts, sc_text *text)
{
    const sc_job *job = value;
    rule_entry entry;

    SC_PASS(
        sc_text_add(ctx, text, job->tissues.rule_count > job->tissues.film_rules ? " " : " {}"));
    for (size_t i = job->tissues.film_rules; i < job->tissues.rule_count; i++) {
        SC_PASS(sc_text_add(ctx, text, "\n%*s", indent + 2, ""));
        SC_PASS(sc_write_quoted(ctx, job->tissues.rules[i].pattern, text));
        SC_PASS(sc_text_add(ctx, text, ": "));
        entry = (rule_entry){.rule = job->tissues.rules[i]};
        for (size_t t = 0; t < SC_COUNT_OF(tracks); t++) {
            if (*number_at(&entry, t))
                *track_at(&entry, t) = job->tissues.tracks[*number_at(&entry, t) - 1];
        }
        SC_PASS(sc_keys_write_flow(ctx, key->keys, &entry, text));
    }
    return sc_text_add(ctx, text, "\n");
}

const sc_value_type sc_type_tissues = {
    .name = "map of tissues",
    .expected = "a map of tissues",
    .read = read_tissues,
    .write_lines = write_tissues,
    .schema = "{type: object, additionalProperties: $keys}",
    .container = SC_CONTAINER_DICT,
};
