/* SPDX-License-Identifier: BSD-3-Clause */
/* A series of volumes that is shown as the phases of a beat. */
#include "key.h"
#include "segcast/job.h"
#include "segcast/volume.h"

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

static sc_status write_loop(const sc_ctx *ctx, const sc_key *key, const void *value, sc_text *text)
{
    const int beats = *(const int *)value;

    return beats ? sc_text_add(ctx, text, "%d", beats) : sc_text_add(ctx, text, "true");
}

static const sc_value_type type_loop = {
    .name = "true, false or number",
    .expected = "true, false, or how many beats are shown",
    .read = read_loop,
    .write = write_loop,
    .schema = "{anyOf: [{type: boolean}, {type: integer, minimum: $low, maximum: $high}]}",
};

const sc_key sc_cine_keys[] = {
    {"bpm", &sc_type_real, offsetof(sc_cine_options, cine.bpm), "60",
     .help = "beats per minute; in one, all phases are shown. Of a file that says how long its "
             "phases take (4-D), that is the default, if it makes 20 to 300 beats per minute",
     .low = 0.1, .high = 1000},
    {"loop", &type_loop, offsetof(sc_cine_options, cine.beats), "true",
     .help =
         "true: beat follows beat; false, or a number: after one, or so many, the last phase stays",
     .low = 1, .high = 1000000},
    {"between", &sc_type_int, offsetof(sc_cine_options, cine.between), "0",
     .help = "so many phases more between each two, and between the last and the first: borders "
             "move from the one to the other, instead of jumping; each is prepared as a phase is",
     .low = 0, .high = 100},
    {"phases", &sc_type_text, offsetof(sc_cine_options, phases), "\"\"",
     .help = "those that are shown, in this order, counted from 0: 0-9, 0-18:2, or 5-9,0-4",
     .bytes = sizeof(((sc_cine_options *)0)->phases), .without = "all"},
    {0}};

/* Leave only those phases that cine.phases names, in its order. What it names is then forgotten,
 * as the job as resolved lists the files, but not of phases that are in one file. */
static sc_status select_phases(const sc_ctx *ctx, const sc_yaml *root, sc_job *job)
{
    const sc_ctx silent = {.rank = ctx->rank, .alloc_budget = ctx->alloc_budget};
    SC_OWN(sc_free_at) int *chosen = NULL;
    int count = 0;
    sc_volume_path *all = job->volume.phases;
    sc_status status;

    if (!job->cine.phases[0])
        return SC_OK;
    status = sc_frames_parse_order(&silent, job->cine.phases, (int)job->volume.phase_count, &chosen,
                                   &count);
    if (status == SC_ERR_USAGE)
        return sc_yaml_fail(ctx, sc_yaml_member(sc_yaml_member(root, "cine"), "phases"),
                            "phases is \"%s\", expected numbers from 0 to %zu, such as 0-%zu, each "
                            "once: there are %zu phases",
                            job->cine.phases, job->volume.phase_count - 1,
                            job->volume.phase_count - 1, job->volume.phase_count);
    if (status != SC_OK)
        return sc_fail(ctx, status, "out of memory while phases were chosen");
    SC_PASS(SC_ALLOC(ctx, (size_t)count, &job->volume.phases));
    for (int i = 0; i < count; i++)
        job->volume.phases[i] = all[chosen[i]];
    sc_free(all);
    job->volume.phase_count = (size_t)count;
    strcpy(job->volume.path, job->volume.phases[0].path);
    if (!job->volume.phases[0].phase)
        job->cine.phases[0] = '\0';
    return SC_OK;
}

/* The beats per minute that are believed of a file: headers often hold a step of 1 s, or that of
 * the pictures of the scanner. */
#define BELIEVED_LEAST_BPM 20.0
#define BELIEVED_MOST_BPM 300.0

/* Let phases of a file follow each other in its own time, unless the job says how. */
static void choose_bpm(const sc_ctx *ctx, const sc_yaml *cine, double step_s, sc_job *job)
{
    const double bpm = step_s > 0 ? 60 / (step_s * (double)job->volume.phase_count) : 0;

    if (bpm <= 0 || sc_yaml_member(cine, "bpm"))
        return;
    if (bpm >= BELIEVED_LEAST_BPM && bpm <= BELIEVED_MOST_BPM) {
        job->cine.cine.bpm = bpm;
        sc_info(ctx, "%s: its phases are %.4g s apart: %.4g beats a minute (cine.bpm)",
                job->volume.path, step_s, bpm);
    } else {
        sc_info(ctx,
                "%s: its phases are said to be %.4g s apart, which makes %.4g beats a minute; "
                "taken as %g (cine.bpm)",
                job->volume.path, step_s, bpm, job->cine.cine.bpm);
    }
}

/* Make a phase of the job of each volume that its only file holds. *step_s receives the time
 * between them. */
static sc_status find_phases(const sc_ctx *ctx, const sc_yaml *volume, sc_job *job, double *step_s)
{
    int count = 1;

    SC_PASS(sc_volume_phases(ctx, job->volume.path, &count, step_s));
    if (count == 1)
        return SC_OK;
    if (job->given.phase)
        return sc_yaml_fail(ctx, volume,
                            "volume: phase chooses one of the %d phases of the file, and cine "
                            "shows all; expected one of the two, or cine.phases",
                            count);
    SC_PASS(sc_series_alloc(ctx, volume, (size_t)count, job));
    for (int i = 0; i < count; i++) {
        strcpy(job->volume.phases[i].path, job->volume.path);
        job->volume.phases[i].phase = i + 1;
    }
    return SC_OK;
}

sc_status sc_cine_check(const sc_ctx *ctx, const sc_job_sources *sources, const sc_yaml *root,
                        sc_job *job)
{
    const sc_yaml *cine = sc_yaml_member(root, "cine"), *volume = sc_yaml_member(root, "volume");
    double step_s = 0;

    if (!job->volume.path[0])
        return SC_OK; /* which has been told */
    if (job->volume.phase_count && !cine)
        return sc_yaml_fail(ctx, volume,
                            "volume is a series of %zu files; expected cine, such as cine: {bpm: "
                            "60}, which shows them as the phases of a beat, or one of the files",
                            job->volume.phase_count);
    if (!job->volume.phase_count && cine && sources->check_inputs &&
        !sc_job_is_phantom(job->volume.path))
        SC_PASS(find_phases(ctx, volume, job, &step_s));
    if (!job->volume.phase_count && cine)
        return sc_yaml_fail(
            ctx, cine,
            "cine: volume is one file, which holds one volume; expected a series of phases, such "
            "as volume: heart_*.nrrd, a list of files, or a file that holds several (4-D)");
    if (!job->given.cine) /* which may have a mistake of its own */
        return SC_OK;
    SC_PASS(select_phases(ctx, root, job));
    if (job->volume.phase_count < 2)
        return sc_yaml_fail(ctx, cine, "cine: there is one phase, expected 2 or more");
    if (job->volume.phase_count * (size_t)(1 + job->cine.cine.between) > SC_PHASES_MAX)
        return sc_yaml_fail(
            ctx, sc_yaml_member(cine, "between"),
            "cine: %zu phases, and %d between each two, are %zu; expected at most %d",
            job->volume.phase_count, job->cine.cine.between,
            job->volume.phase_count * (size_t)(1 + job->cine.cine.between), SC_PHASES_MAX);
    choose_bpm(ctx, cine, step_s, job);
    job->volume.phase = job->volume.phases[0].phase;
    if (job->volume.box.visible)
        return sc_yaml_fail(ctx, volume,
                            "box: what is visible is another part of each phase; expected a box, "
                            "which is the same for all: box: [[x, y, z], [x, y, z]]");
    sc_note_where(volume, job->cine.where, sizeof job->cine.where);
    return SC_OK;
}
