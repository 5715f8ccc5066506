/* SPDX-License-Identifier: BSD-3-Clause */
/* What a job changes of its volume before anything else is done with it: tissues are merged or left
 * out, and parts cut off. The same is done to what a scan of the voxels has found. */
#include "recipe.h"

#include "segcast/grey.h"

/* ---- tissues ---- */

/* Room for what becomes of each label: see sc_relabel_make. */
typedef struct plan {
    int *into;          /* [count], owned */
    const char **names; /* [count], owned */
    int count;
} plan;

static void clear_plan(plan *p)
{
    sc_free(p->into);
    sc_free(p->names);
}

/* Make a plan in which every label becomes background, if @p nothing, or else itself. Caller owns:
 * clear_plan, also after an error. */
static sc_status make_plan(const sc_recipe *s, bool nothing, plan *out)
{
    const sc_ctx *ctx = s->app->ctx;

    *out = (plan){.count = s->volume->label_count};
    SC_PASS(SC_ZALLOC(ctx, (size_t)out->count, &out->into));
    SC_PASS(SC_ZALLOC(ctx, (size_t)out->count, &out->names));
    for (int id = 0; id < out->count; id++)
        out->into[id] = nothing ? 0 : id;
    return SC_OK;
}

/* Give it the labels of a plan. */
static sc_status do_plan(const sc_recipe *s, const plan *p)
{
    SC_OWN(sc_relabel_clear) sc_relabel relabel = {0};

    SC_PASS(sc_relabel_make(s->app->ctx, s->volume->labels, p->count, p->into, p->names, &relabel));
    return sc_volume_relabel(s->app->ctx, s->volume, &relabel, s->app->threads);
}

/* Note in group[id] that the labels which row @p row of the job's tissues means become a part of
 * what row @p first names: 1 + first. Those that are part of something else already are refused. */
static sc_status group_labels(const sc_recipe *s, size_t row, size_t first, int *group)
{
    const sc_volume_tissue *all = s->job->volume.tissues, *tissue = &all[row];
    const sc_volume *v = s->volume;
    const sc_prepared view = {.label_count = v->label_count, .labels = v->labels};
    const sc_pattern pattern = sc_pattern_of(tissue->pattern);
    const sc_match best = sc_pattern_match(v->labels, v->label_count, &pattern);

    SC_PASS(sc_pattern_check(s->app->ctx, &view, tissue->pattern, tissue->where));
    for (int id = 1; id < v->label_count && best != SC_MATCH_NONE; id++) {
        if (sc_label_match(&v->labels[id], &pattern) != best)
            continue;
        if (group[id] && group[id] != (int)first + 1)
            return sc_fail(s->app->ctx, SC_ERR_DATA,
                           "%s: \"%s\" (label %lld) cannot become a part of \"%s\", since it is "
                           "one of \"%s\"; expected each tissue under one name of volume.merge",
                           tissue->where, v->labels[id].name, (long long)v->labels[id].value,
                           tissue->into, all[group[id] - 1].into);
        group[id] = (int)first + 1;
    }
    return SC_OK;
}

/* Plan what becomes of the labels of one group: the least of them stands for all. A name that
 * another tissue has is refused. @param first the row that names it. */
static sc_status plan_group(const sc_recipe *s, size_t first, const int *group, bool tell, plan *p)
{
    const sc_volume_tissue *tissue = &s->job->volume.tissues[first];
    const sc_label *labels = s->volume->labels;
    int least = 0, parts = 0;

    for (int id = 1; id < p->count; id++) {
        if (group[id] == (int)first + 1) {
            least = least ? least : id;
            p->into[id] = least;
            p->names[least] = tissue->into;
            parts++;
        } else if (!strcmp(labels[id].name, tissue->into)) {
            return sc_fail(s->app->ctx, SC_ERR_DATA,
                           "%s: the volume has a tissue \"%s\" already (label %lld), which is not "
                           "among those that become it; list it, too, or choose another name",
                           tissue->where, tissue->into, (long long)labels[id].value);
        }
    }
    if (tell)
        sc_info(s->app->ctx, "volume.merge: \"%s\" is made of %d tissue%s", tissue->into, parts,
                parts == 1 ? "" : "s");
    return SC_OK;
}

/* Log all patterns of volume.keep that match none of the @p count labels.
 * @return SC_ERR_DATA if there is one. */
static sc_status check_kept(const sc_recipe *s, const sc_label *labels, int count)
{
    const sc_prepared view = {.label_count = count, .labels = labels};
    sc_status status = SC_OK;

    for (size_t i = 0; i < s->job->volume.tissue_count; i++) {
        const sc_volume_tissue *tissue = &s->job->volume.tissues[i];

        if (!tissue->into[0] &&
            !sc_goes_on(&status,
                        sc_pattern_check(s->app->ctx, &view, tissue->pattern, tissue->where)))
            break;
    }
    return status;
}

/* Log the mistakes of volume.keep after one of volume.merge, so that all are told in one go: among
 * the labels of the volume, and those that volume.merge would have made of them. */
static sc_status check_kept_unmerged(const sc_recipe *s)
{
    const sc_volume *v = s->volume;
    const size_t rows = s->job->volume.tissue_count;
    int count = v->label_count;
    SC_OWN(sc_free_at) sc_label *labels = NULL;

    SC_PASS(SC_ZALLOC(s->app->ctx, (size_t)count + rows, &labels));
    memcpy(labels, v->labels, (size_t)count * sizeof *labels);
    for (size_t i = 0; i < rows && s->job->volume.tissues[i].into[0]; i++) {
        sc_label *made = &labels[count++];

        made->value = INT64_MIN; /* the number of none */
        snprintf(made->name, sizeof made->name, "%s", s->job->volume.tissues[i].into);
    }
    return check_kept(s, labels, count);
}

/* Do what volume.merge says; those tissues stand first in the job. @return the first mistake; all
 * are logged, also those of volume.keep then. */
static sc_status merge_tissues(const sc_recipe *s)
{
    const sc_volume_tissue *all = s->job->volume.tissues;
    const size_t count = s->job->volume.tissue_count;
    size_t first = 0;
    sc_status status = SC_OK;
    SC_OWN(sc_free_at) int *group = NULL;
    SC_OWN(clear_plan) plan p = {0};

    SC_PASS(make_plan(s, false, &p));
    SC_PASS(SC_ZALLOC(s->app->ctx, (size_t)p.count, &group));
    for (size_t row = 0; row < count && all[row].into[0]; row++) {
        first = strcmp(all[row].into, all[first].into) != 0 ? row : first;
        if (!sc_goes_on(&status, group_labels(s, row, first, group)))
            return status;
    }
    for (size_t row = 0; row < count && all[row].into[0]; row++) {
        if (row == 0 || strcmp(all[row].into, all[row - 1].into) != 0)
            (void)sc_goes_on(&status, plan_group(s, row, group, s->tell && status == SC_OK, &p));
    }
    if (status != SC_OK && s->job->given.keep)
        (void)sc_goes_on(&status, check_kept_unmerged(s));
    SC_PASS(status);
    return do_plan(s, &p);
}

/* Do what volume.keep says. @return the first mistake; all are logged. */
static sc_status keep_tissues(const sc_recipe *s)
{
    const sc_volume_tissue *all = s->job->volume.tissues;
    const sc_label *labels = s->volume->labels;
    int kept = 0;
    SC_OWN(clear_plan) plan p = {0};

    SC_PASS(make_plan(s, true, &p));
    SC_PASS(check_kept(s, labels, p.count));
    for (size_t i = 0; i < s->job->volume.tissue_count; i++) {
        const sc_pattern pattern = sc_pattern_of(all[i].pattern);
        const sc_match best = sc_pattern_match(labels, p.count, &pattern);

        if (all[i].into[0])
            continue;
        for (int id = 1; id < p.count && best != SC_MATCH_NONE; id++) {
            if (sc_label_match(&labels[id], &pattern) == best)
                p.into[id] = id;
        }
    }
    for (int id = 1; id < p.count; id++)
        kept += p.into[id] == id;
    if (s->tell)
        sc_info(s->app->ctx, "volume.keep: %d of %d tissues are kept", kept, p.count - 1);
    return do_plan(s, &p);
}

/* ---- what is lost ---- */

/* Find which labels have voxels: *out is bool[label_count]. Caller owns it: sc_free. */
static sc_status find_present(const sc_recipe *s, void **out)
{
    const sc_volume *v = s->volume;
    const size_t voxels = v->ids ? sc_volume_voxels(v) : 0;
    bool *present;

    SC_PASS(sc_zalloc(s->app->ctx, (size_t)v->label_count, sizeof *present, out));
    present = *out;
    for (size_t i = 0; i < voxels; i++)
        present[sc_volume_id(v, i)] = true;
    for (int id = 0; id < v->label_count && v->tallies; id++)
        present[id] = v->tallies[id].voxels > 0;
    return SC_OK;
}

/* Warn of the tissues that had voxels and have none any more. @param before of find_present.
 * @param key of the job that did it. @param advice what would keep them. */
static sc_status tell_lost(const sc_recipe *s, const bool *before, const char *key,
                           const char *advice)
{
    const sc_volume *v = s->volume;
    SC_OWN(sc_text_clear) sc_text names = {0};
    int lost = 0;
    SC_OWN(sc_free_at) void *after = NULL;

    SC_PASS(find_present(s, &after));
    for (int id = 1; id < v->label_count; id++) {
        if (before[id] && !((const bool *)after)[id])
            SC_PASS(sc_label_list_add(s->app->ctx, &names, (size_t)lost++, &v->labels[id]));
    }
    if (lost)
        sc_warn(s->app->ctx, "%s: no voxel is left of %d tissue%s: %s; %s", key, lost,
                lost == 1 ? "" : "s", names.data, advice);
    return SC_OK;
}

/* ---- what is drawn ---- */

/* Set shown[id] for all tissues that the job, or one of its shots, shows. @param shown
 * [label_count] of the volume, zeroed. */
static sc_status find_shown(const sc_recipe *s, bool *shown)
{
    const sc_volume *v = s->volume;
    const sc_job *job = s->job;
    SC_OWN(sc_free_at) bool *hidden = NULL;

    SC_PASS(SC_ZALLOC(s->app->ctx, (size_t)v->label_count, &hidden));
    for (size_t i = 0; i == 0 || i < job->film.shot_count; i++) {
        const sc_job *one = job->film.shot_count ? &job->film.shots[i].job : job;

        SC_PASS(sc_hidden_labels(s->app->ctx, v->labels, v->label_count, one->tissues.rules,
                                 one->tissues.rule_count, hidden));
        for (int id = 1; id < v->label_count; id++)
            shown[id] = shown[id] || !hidden[id];
    }
    return SC_OK;
}

/* Beyond the border of a volume a tissue goes on, for the filters of its surface: one that only
 * touches the border of the part has a flat face there with sharp edges. So many voxels around it
 * stay, whatever the margin, that the filters reach no further. */
enum {
    SURROUND_VOXELS = 6,
    STEP_VOXELS = 2 /* boxes leave out multiples of it: borders are computed in cells of so many */
};

/* Find the box of the tissues that the job shows, with its margin, within the volume; *empty is set
 * if there are none. */
static sc_status box_of_visible(const sc_recipe *s, sc_voxel_box *out, bool *empty)
{
    const sc_volume *v = s->volume;
    sc_voxel_box box = {{v->size[0], v->size[1], v->size[2]}, {-1, -1, -1}};
    SC_OWN(sc_free_at) bool *shown = NULL;

    SC_PASS(SC_ZALLOC(s->app->ctx, (size_t)v->label_count, &shown));
    SC_PASS(find_shown(s, shown));
    if (v->ids)
        box = sc_volume_box(v, shown);
    for (int id = 1; id < v->label_count && v->tallies; id++) {
        const sc_label_tally *tally = &v->tallies[id];

        for (int axis = 0; axis < 3 && shown[id] && tally->voxels; axis++) {
            box.low[axis] = tally->low[axis] < box.low[axis] ? tally->low[axis] : box.low[axis];
            box.high[axis] =
                tally->high[axis] > box.high[axis] ? tally->high[axis] : box.high[axis];
        }
    }
    *empty = box.high[0] < 0;
    for (int axis = 0; axis < 3; axis++) {
        const sc_vec3 edge = {v->to_ras_mm.m[0][axis], v->to_ras_mm.m[1][axis],
                              v->to_ras_mm.m[2][axis]};
        const double margin =
            fmax(SURROUND_VOXELS, ceil(s->job->volume.box.margin_mm / sc_vec3_length(edge) - 1e-6));

        box.low[axis] = (int)fmax(0, box.low[axis] - margin);
        box.high[axis] = (int)fmin(v->size[axis] - 1, box.high[axis] + margin);
        if (!*empty) {
            box.low[axis] -= box.low[axis] % STEP_VOXELS;
            box.high[axis] += (v->size[axis] - 1 - box.high[axis]) % STEP_VOXELS;
        }
    }
    *out = box;
    return SC_OK;
}

/* Refuse a box in which a computed volume has no voxel. */
static sc_status fail_outside(const sc_recipe *s)
{
    const sc_volume *v = s->volume;
    const sc_box3 all = sc_grid_box_mm(v->size, &v->to_ras_mm);
    return sc_fail(s->app->ctx, SC_ERR_DATA,
                   "%s: box: the volume has no voxel in the box; it reaches from [%.4g, %.4g, "
                   "%.4g] to [%.4g, %.4g, %.4g] in RAS mm",
                   s->job->lines.volume_box, all.low.x, all.low.y, all.low.z, all.high.x,
                   all.high.y, all.high.z);
}

/* Leave what is visible, or, of a computed volume, what lies between two corners. */
static sc_status crop_volume(const sc_recipe *s, bool to_visible)
{
    sc_volume *v = s->volume;
    const int before[3] = {v->size[0], v->size[1], v->size[2]};
    bool empty = false;
    sc_voxel_box box;
    SC_OWN(sc_free_at) void *present = NULL;

    if (to_visible)
        SC_PASS(box_of_visible(s, &box, &empty));
    else
        box = sc_voxels_between(v->size, &v->to_ras_mm, s->job->volume.box.corners);
    if (empty)
        return SC_OK; /* nothing is shown: that is told elsewhere */
    for (int axis = 0; axis < 3; axis++) {
        if (box.low[axis] > box.high[axis])
            return fail_outside(s);
    }
    if (s->tell)
        SC_PASS(find_present(s, &present));
    sc_volume_crop(v, &box);
    if (s->tell)
        sc_info(s->app->ctx, "volume.box: %d x %d x %d of %d x %d x %d voxels are drawn",
                v->size[0], v->size[1], v->size[2], before[0], before[1], before[2]);
    if (s->tell && !to_visible)
        SC_PASS(tell_lost(s, present, "volume.box", "a larger box keeps more"));
    return SC_OK;
}

/* ---- resample ---- */

/* Bring what a scan has found to another grid, about: how many voxels labels have there is only
 * known from the voxels. */
static void scale_tallies(sc_volume *v, const int size[3], const sc_affine *to_ras_mm)
{
    double ratio = 1;

    for (int i = 0; i < 3; i++)
        ratio *= (double)size[i] / v->size[i];
    for (int id = 0; id < v->label_count && v->tallies; id++) {
        sc_label_tally *tally = &v->tallies[id];

        for (int i = 0; i < 3 && tally->voxels; i++) {
            const double scale = (double)size[i] / v->size[i];

            tally->low[i] = (int)fmin(tally->low[i] * scale, size[i] - 1);
            tally->high[i] = (int)fmin(ceil((tally->high[i] + 1) * scale), size[i]) - 1;
        }
        tally->voxels = (uint64_t)ceil((double)tally->voxels * ratio);
    }
    memcpy(v->size, size, sizeof v->size);
    v->to_ras_mm = *to_ras_mm;
}

/* @return whether resampling may lose a tissue of which a scan found so many voxels, if the new
 * ones are @p scale[i] times as many along axis i: it is smaller than one of them, or so thin along
 * an axis that it nowhere fills half of one, so that others have more votes everywhere. */
static bool may_vanish(const sc_label_tally *tally, const double scale[3])
{
    bool is_thin = false;

    for (int i = 0; i < 3; i++)
        is_thin = is_thin || (tally->high[i] + 1 - tally->low[i]) * scale[i] < 0.5;
    return tally->voxels > 0 &&
           (is_thin || (double)tally->voxels * scale[0] * scale[1] * scale[2] < 1);
}

/* Warn of tissues that resampling may lose, as far as a scan of the voxels tells. @param scale how
 * many new voxels there are for an old one along each axis. */
static sc_status tell_small(const sc_recipe *s, const double scale[3])
{
    const sc_volume *v = s->volume;
    SC_OWN(sc_text_clear) sc_text names = {0};
    int small = 0;

    for (int id = 1; id < v->label_count && v->tallies; id++) {
        if (may_vanish(&v->tallies[id], scale))
            SC_PASS(sc_label_list_add(s->app->ctx, &names, (size_t)small++, &v->labels[id]));
    }
    if (small)
        sc_warn(s->app->ctx,
                "volume.resample: no voxel may be left of %d tissue%s, smaller than one of the new "
                "voxels or thinner than half of one: %s; a smaller spacing keeps more",
                small, small == 1 ? "" : "s", names.data);
    return SC_OK;
}

/* Do what volume.resample says. */
static sc_status resample_volume(const sc_recipe *s)
{
    const double *mm = s->job->volume.resample_mm;
    sc_volume *v = s->volume;
    const sc_volume before = *v;
    const double old_bytes = (double)sc_volume_voxels(v) * v->label_bytes;
    SC_OWN(sc_free_at) void *present = NULL;
    sc_affine to_ras_mm;
    double old_mm[3], scale[3];
    int size[3];

    for (int i = 0; i < 3; i++)
        old_mm[i] = sc_vec3_length(sc_affine_column(&v->to_ras_mm, i));
    sc_resample_votes_grid(v, mm, size, &to_ras_mm);
    SC_PASS(sc_volume_memory_check(s->app->ctx, s->job->volume.path, size, old_bytes));
    SC_PASS(sc_geometry_check(s->app->ctx, s->job->volume.path, size, &to_ras_mm));
    if (s->tell)
        sc_info(s->app->ctx,
                "volume.resample: from %d x %d x %d voxels of %.4g x %.4g x %.4g mm to %d x %d x "
                "%d of %.4g x %.4g x %.4g mm",
                before.size[0], before.size[1], before.size[2], old_mm[0], old_mm[1], old_mm[2],
                size[0], size[1], size[2], mm[0], mm[1], mm[2]);
    if (!v->ids) {
        for (int i = 0; i < 3; i++)
            scale[i] = (double)size[i] / before.size[i];
        if (s->tell)
            SC_PASS(tell_small(s, scale));
        scale_tallies(v, size, &to_ras_mm);
        return SC_OK;
    }
    SC_PASS(find_present(s, &present));
    SC_PASS(sc_resample_votes(s->app->ctx, v, mm, s->app->threads));
    if (s->tell)
        SC_PASS(tell_lost(s, present, "volume.resample",
                          "they are thin or small: a smaller spacing keeps more"));
    return SC_OK;
}

/* ---- all of it ---- */

bool sc_edits_volume(const sc_job *job)
{
    return job->volume.tissue_count || job->given.level || job->given.phase || job->given.box ||
           (job->given.resample && !job->given.volume_size) || job->given.header ||
           job->given.threshold;
}

void sc_forget_volume_edits(sc_job *job)
{
    job->volume.tissue_count = 0; /* they are freed with the job: copies of it may share them */
    job->volume.box = (sc_box){0};
    job->volume.level = job->volume.phase = 0;
    job->given.merge = job->given.keep = job->given.header = false;
    job->given.threshold = false;
    job->given.level = job->given.box = job->given.phase = false;
    job->given.resample = job->given.volume_size; /* which is done with prepared files, too */
}

/* @return the dense id of a value that a volume has. */
static int id_of(const sc_volume *volume, int64_t value)
{
    const sc_label *label = value ? sc_volume_label(volume, value) : NULL;

    return label ? (int)(label - volume->labels) : 0;
}

/* sc_read_choice.leave_out: the rows of tissues that volume.keep does not name, so that those that
 * are kept share what they cover among each other. The job is done with a volume that has one voxel
 * of each tissue. @param user the recipe. */
static sc_status leave_out(void *user, const sc_label_table *table, bool numbered, bool *left_out)
{
    const sc_recipe *wanted = user;
    sc_ctx silent = sc_quiet(wanted->app->ctx);
    sc_app quieter = *wanted->app;
    SC_OWN(sc_volume_clear)
    sc_volume each = {.size = {0, 1, 1}, .label_bytes = 2, .label_count = 1, .numbered = numbered};
    sc_recipe r = {.app = &quieter, .job = wanted->job, .volume = &each};
    SC_OWN(sc_free_at) int *ids = NULL;
    sc_status status;

    quieter.ctx = &silent;
    quieter.label_source = NULL;
    SC_TRY(SC_ZALLOC(&silent, 1, &each.labels));
    SC_TRY(sc_volume_add_labels(&silent, &each, table));
    each.size[0] = each.label_count;
    SC_TRY(sc_alloc(&silent, (size_t)each.label_count, sizeof(uint16_t), &each.ids));
    SC_TRY(SC_ALLOC(&silent, table->count + 1, &ids));
    for (int id = 0; id < each.label_count; id++)
        ((uint16_t *)each.ids)[id] = (uint16_t)id;
    for (size_t i = 0; i < table->count; i++)
        ids[i] = id_of(&each, table->rows[i].value);
    SC_TRY(sc_name_labels(&r));
    if (r.job->given.merge)
        SC_TRY(merge_tissues(&r));
    SC_TRY(keep_tissues(&r));
    for (size_t i = 0; i < table->count; i++)
        left_out[i] = ((const uint16_t *)each.ids)[ids[i]] == 0;
out:
    return sc_is_of_input(status) ? SC_OK : status; /* mistakes are told when the volume is read */
}

sc_status sc_read_choice_of(sc_recipe *r, sc_read_choice *out)
{
    const sc_app *app = r->app;
    const sc_job *job = r->job;
    const bool is_computed = sc_job_is_phantom(job->volume.path);
    sc_read_choice choice = {.depth = r->depth,
                             .overlap = (sc_overlap)job->volume.overlap,
                             .overlap_names = job->volume.overlap_names,
                             .level = job->volume.level,
                             .phase = job->volume.phase,
                             .store = app->phase_store,
                             .box = (sc_read_box)job->volume.box.kind,
                             .overlaps = app->overlaps,
                             .threshold =
                                 job->given.threshold ? fmax(job->volume.threshold, 1e-9) : 0,
                             .header = job->given.header ? job->volume.header : NULL,
                             .where = job->lines.volume_box};

    if (is_computed && choice.box == SC_READ_MM)
        choice.box = SC_READ_ALL; /* the rest is left out of it when it is edited */
    if (is_computed && (choice.level || choice.phase || choice.box != SC_READ_ALL || choice.header))
        return sc_fail(app->ctx, SC_ERR_DATA,
                       "%s: %s is for files, and %s is computed; expected two corners in mm for a "
                       "part of it, and phantom:128x96x128 for another resolution",
                       job->lines.volume_box,
                       choice.level    ? "level"
                       : choice.phase  ? "phase"
                       : choice.header ? "header"
                                       : "a box",
                       job->volume.path);
    choice.user = r;
    choice.leave_out = job->given.keep ? leave_out : NULL;
    memcpy(choice.voxels, job->volume.box.voxels, sizeof choice.voxels);
    memcpy(choice.corners, job->volume.box.corners, sizeof choice.corners);
    *out = choice;
    return SC_OK;
}

sc_status sc_edit_volume(sc_recipe *r)
{
    const sc_job *job = r->job;
    const bool knows_voxels = r->volume->ids || r->volume->tallies;

    if (job->given.merge)
        SC_PASS(merge_tissues(r));
    if (job->given.keep)
        SC_PASS(keep_tissues(r));
    if (job->volume.box.kind == SC_READ_MM && sc_job_is_phantom(job->volume.path))
        SC_PASS(crop_volume(r, false));
    if (job->volume.box.visible && knows_voxels)
        SC_PASS(crop_volume(r, true));
    return job->given.resample && !job->given.volume_size ? resample_volume(r) : SC_OK;
}
