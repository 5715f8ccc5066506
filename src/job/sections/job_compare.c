/* SPDX-License-Identifier: BSD-3-Clause */
/* The volumes that a job compares, and how they are shown together. */
#include "key.h"
#include "segcast/job.h"

/* ---- the other volumes ---- */

#define SUBJECT(member) offsetof(sc_subject, member)

static const sc_key subject_keys[] = {
    {"volume", &sc_type_text, SUBJECT(volume), NULL,
     .help = "a path, phantom, or for example phantom:128x96x128", .bytes = SC_PATH_BYTES,
     .required = true},
    {"labels", &sc_type_text, SUBJECT(labels), "\"\"",
     .help = "label table of this volume; empty: as that of the job's own", .bytes = SC_PATH_BYTES},
    {"image", &sc_type_text, SUBJECT(image), "\"\"",
     .help = "grey volume of this volume, such as its own CT, shown as image says; none: it has "
             "none; empty: that of the job",
     .bytes = SC_PATH_BYTES},
    {"name", &sc_type_caption_text, SUBJECT(name), NULL, .help = "what stands below its picture",
     .given = SC_GIVEN(sc_subject, has_name), .without = "the name of its file"},
    {0}};

/* Read one subject, a map or a path, into the next one, for which there is room. */
static sc_status read_subject(const sc_ctx *ctx, const sc_key *keys, const sc_yaml *node,
                              sc_comparison *compare)
{
    sc_subject *subject = &compare->others[compare->count];
    sc_status status = SC_OK;

    *subject = (sc_subject){0};
    SC_PASS(sc_keys_set_defaults(ctx, keys, subject));
    sc_note_where(node, subject->where, sizeof subject->where);
    if (node->kind == SC_YAML_MAP)
        status = sc_keys_read(ctx, keys, node, subject);
    else
        status = sc_type_text.read(ctx, &keys[0], node, subject->volume);
    if (status == SC_OK && !subject->volume[0]) {
        const sc_yaml *path = sc_yaml_member(node, "volume");

        status = sc_wrong_type(ctx, path ? path : node, "a path");
    }
    compare->count++; /* also after a mistake, so that the next one keeps its place in the list */
    return status;
}

/* Read a path, or a list of subjects. @p value is the whole sc_comparison. @return the first
 * mistake; all are logged. */
static sc_status read_subjects(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                               void *value)
{
    const bool is_one = node->kind == SC_YAML_SCALAR;
    const size_t count = is_one ? 1 : node->count;
    sc_comparison *compare = value;
    sc_status status = SC_OK;

    if (node->kind == SC_YAML_MAP)
        return sc_wrong_type(ctx, node, key->type->expected);
    if (count < 1 || count >= SC_SUBJECTS_MAX)
        return sc_yaml_fail(
            ctx, node,
            "%s has %zu volumes, expected 1 to %d, which are shown beside that of the job",
            key->name, count, SC_SUBJECTS_MAX - 1);
    compare->count = 0;
    for (size_t i = 0; i < count; i++) {
        if (!sc_goes_on(&status,
                        read_subject(ctx, key->keys, is_one ? node : node->items[i], compare)))
            break;
    }
    return status;
}

/* Write the subjects as a list in one line. */
static sc_status write_subjects(const sc_ctx *ctx, const sc_key *key, const void *value,
                                sc_text *text)
{
    const sc_comparison *compare = value;

    SC_PASS(sc_text_add(ctx, text, "["));
    for (int i = 0; i < compare->count; i++) {
        SC_PASS(sc_text_add(ctx, text, "%s", i ? ", " : ""));
        SC_PASS(sc_keys_write_flow(ctx, key->keys, &compare->others[i], text));
    }
    return sc_text_add(ctx, text, "]");
}

static const sc_value_type type_subjects = {
    .name = "path or list of volumes",
    .expected =
        "the path of a volume, or a list of volumes, such as - {volume: after.nrrd, name: after}",
    .read = read_subjects,
    .write = write_subjects,
    .schema = "{anyOf: [{type: string}, {type: array, minItems: 1, maxItems: $others_most, items: "
              "{anyOf: [{type: string}, $keys]}}]}",
    .container = SC_CONTAINER_LIST,
};

/* ---- rows ---- */

static const sc_choice aligns[] = {{"center", SC_ALIGN_CENTER}, {"none", SC_ALIGN_NONE}, {NULL, 0}};

#define COMPARE(member) offsetof(sc_comparison, member)

const sc_key sc_compare_keys[] = {
    {"with", &type_subjects, 0, NULL,
     .help = "the other volumes, each a path or a map: up to three; merge, keep, box, tissues and "
             "all else of the job hold for them, too",
     .keys = subject_keys, .required = true, .scope.outside_identity = true},
    {"name", &sc_type_caption_text, COMPARE(name), NULL,
     .help = "what stands below the picture of the job's own volume",
     .given = SC_GIVEN(sc_comparison, has_name), .scope.outside_identity = true,
     .without = "the name of its file"},
    {"align", &sc_type_choice, COMPARE(align), "center",
     .help = "center: the middles of what is shown of the volumes are brought to one point; none: "
             "they lie as their files place them",
     .choices = aligns},
    {"divider", &sc_type_tracked_share, COMPARE(divider), NULL,
     .help = "instead of side by side: two volumes in one picture, the job's own left of an "
             "upright line and the other right of it; where the line stands, as a share of the "
             "width from the left",
     .track = offsetof(sc_comparison, divider_track) - offsetof(sc_comparison, divider),
     .given = SC_GIVEN(sc_comparison, has_divider), .without = "side by side"},
    {0}};
