/* SPDX-License-Identifier: BSD-3-Clause */
/* A series of volumes that is shown as the phases of a beat. */
#include "key.h"
#include "segcast/job.h"

#include <string.h>

/* true: on and on; false: once; a whole number: so many times. @p value is sc_cine.beats. */
static sc_status read_loop(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    double beats;

    if (sc_parse_number(node, &beats)) {
        if (!(beats >= key->low && beats <= key->high) || beats != (int)beats)
            return sc_wrong_type(ctx, node, key->type->expected);
        *(int *)value = (int)beats;
        return SC_OK;
    }
    if (node->kind != SC_YAML_SCALAR || (strcmp(node->text, "true") && strcmp(node->text, "false")))
        return sc_wrong_type(ctx, node, key->type->expected);
    *(int *)value = !strcmp(node->text, "false");
    return SC_OK;
}

static sc_status write_loop(const sc_ctx *ctx, const sc_key *key, const void *value, int indent,
                            sc_text *text)
{
    const int beats = *(const int *)value;

    (void)key;
    (void)indent;
    return beats ? sc_text_add(ctx, text, "%d", beats) : sc_text_add(ctx, text, "true");
}

static json_t *loop_schema(const sc_key *key)
{
    return json_pack("{s:[{s:s}, {s:s, s:i, s:i}]}", "anyOf", "type", "boolean", "type", "integer",
                     "minimum", (int)key->low, "maximum", (int)key->high);
}

static const sc_value_type type_loop = {
    .name = "true, false or number",
    .expected = "true, false, or how many beats are shown",
    .read = read_loop,
    .write = write_loop,
    .schema = loop_schema,
};

const sc_key sc_cine_keys[] = {
    {"bpm", &sc_type_real, offsetof(sc_cine_options, cine.bpm), "60",
     .help = "beats per minute; in one, all phases are shown", .low = 0.1, .high = 1000},
    {"loop", &type_loop, offsetof(sc_cine_options, cine.beats), "true",
     .help = "true: beat follows beat; false, or a number: after one, or so many, the last phase "
             "stays",
     .low = 1, .high = 1000000},
    {"phases", &sc_type_text, offsetof(sc_cine_options, phases), "\"\"",
     .help = "those that are shown, in this order, counted from 0: 0-9, 0-18:2, or 5-9,0-4",
     .bytes = sizeof(((sc_cine_options *)0)->phases), .without = "all"},
    {0}};

/* Leave only those phases that cine.phases names, in its order. What it names is then forgotten:
 * the job as resolved lists the files. */
static sc_status select_phases(const sc_ctx *ctx, const sc_yaml *root, sc_job *job)
{
    const sc_ctx silent = {.rank = ctx->rank, .alloc_budget = ctx->alloc_budget};
    int *chosen = NULL, count = 0;
    sc_volume_path *all = job->phases;
    void *block;
    sc_status status;

    if (!job->cine.phases[0])
        return SC_OK;
    status =
        sc_frames_parse_order(&silent, job->cine.phases, (int)job->phase_count, &chosen, &count);
    if (status == SC_ERR_USAGE)
        return sc_yaml_fail(ctx, sc_yaml_member(sc_yaml_member(root, "cine"), "phases"),
                            "phases is \"%s\", expected numbers from 0 to %zu, such as 0-%zu, each "
                            "once: there are %zu volumes",
                            job->cine.phases, job->phase_count - 1, job->phase_count - 1,
                            job->phase_count);
    if (status != SC_OK)
        return sc_fail(ctx, status, "out of memory while phases were chosen");
    SC_TRY(sc_alloc(ctx, (size_t)count, sizeof *all, &block));
    job->phases = block;
    for (int i = 0; i < count; i++)
        job->phases[i] = all[chosen[i]];
    sc_free(all);
    job->phase_count = (size_t)count;
    strcpy(job->volume, job->phases[0].path);
    job->cine.phases[0] = '\0';
out:
    sc_free(chosen);
    return status;
}

sc_status sc_cine_check(const sc_ctx *ctx, const sc_yaml *root, sc_job *job)
{
    const sc_yaml *cine = sc_yaml_member(root, "cine"), *volume = sc_yaml_member(root, "volume");
    sc_status status;

    if (!job->volume[0])
        return SC_OK; /* which has been told */
    if (job->phase_count && !cine)
        return sc_yaml_fail(ctx, volume,
                            "volume is a series of %zu files; expected cine, such as cine: {bpm: "
                            "60}, which shows them as the phases of a beat, or one of the files",
                            job->phase_count);
    if (!job->phase_count && cine)
        return sc_yaml_fail(ctx, cine,
                            "cine: volume is one file; expected a series of phases, such as "
                            "volume: heart_*.nrrd, or a list of files");
    if (!job->has_cine) /* which may have a mistake of its own */
        return SC_OK;
    SC_TRY(select_phases(ctx, root, job));
    if (job->phase_count < 2)
        return sc_yaml_fail(ctx, cine, "cine: there is one phase, expected 2 or more");
    if (job->crop.kind == SC_CROP_VISIBLE)
        return sc_yaml_fail(ctx, volume,
                            "crop: what is visible is another part of each phase; expected a box, "
                            "which is the same for all: crop: [[x, y, z], [x, y, z]]");
    sc_note_where(volume, job->cine.where, sizeof job->cine.where);
out:
    return status;
}
