/* SPDX-License-Identifier: BSD-3-Clause */
/* Several volumes in one picture. Each subject is a session with a volume of its own; the first
 * borrows that of the job. They have one camera, framed on all of them, one light and the same clip
 * planes and verbs. What is written below the pictures, and over the whole of them, has sessions of
 * its own, too, which draw nothing else. */
#include "compare.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* @return how many sessions there are for @p count subjects. */
static int part_count(int count)
{
    return 2 * count + 1;
}

sc_session *sc_compare_part(const sc_session *session, int i)
{
    const sc_compare *c = session->compare;

    return c && i < part_count(c->count) ? &c->parts[i] : NULL;
}

const char *sc_compare_name(const sc_session *session, int i)
{
    return session->compare->captions[i].text;
}

/* ---- making it ---- */

/* Note what is written below the picture of each subject. */
static void name_subjects(const sc_job *job, sc_compare *c)
{
    const sc_comparison *compare = &job->compare;

    for (int s = 0; s < c->count; s++) {
        const sc_subject *other = s ? &compare->others[s - 1] : NULL;
        const char *name = other && other->has_name      ? other->name
                           : !other && compare->has_name ? compare->name
                                                         : NULL;
        sc_caption *caption = &c->captions[s];

        *caption = (sc_caption){.end = 1, .place = SC_PLACE_BOTTOM, .may_be_cut = true};
        if (compare->has_divider)
            caption->place = s ? SC_PLACE_BOTTOM_RIGHT : SC_PLACE_BOTTOM_LEFT;
        if (name)
            strcpy(caption->text, name);
        else
            sc_name_of_file(other ? other->volume : job->volume, caption->text);
        strcpy(caption->where, other ? other->where : compare->where);
    }
}

/* Part the tissues that are chosen for overlays: names stand beside the tissues of each subject,
 * the legend is that of all. */
static sc_status part_tissues(const sc_ctx *ctx, const sc_job *job, sc_compare *c)
{
    void *block;
    sc_status status;

    for (int use = 0; use < 2; use++) {
        SC_TRY(sc_alloc(ctx, job->overlay_tissue_count, sizeof *c->tissues[use], &block));
        c->tissues[use] = block;
        for (size_t i = 0; i < job->overlay_tissue_count; i++) {
            if (job->overlay_tissues[i].use == use)
                c->tissues[use][c->tissue_counts[use]++] = job->overlay_tissues[i];
        }
    }
    status = SC_OK;
out:
    return status;
}

/* Leave out of a job what is written onto pictures, and the layout, which is that of the whole. */
static void strip(sc_job *job)
{
    sc_overlays *o = &job->overlays;

    o->time = o->scale_bar = o->color_bar = o->orientation = o->legend = SC_PLACE_NONE;
    o->logo[0] = '\0';
    job->caption_count = job->overlay_tissue_count = 0;
    job->output.layout = SC_LAYOUT_PICTURE;
}

/* Begin the session of a subject, which draws its picture, and the names of its tissues. */
static void begin_subject(const sc_session *session, const sc_compare *c, int s, sc_viewport panel,
                          sc_session *out)
{
    const sc_subject *other = s ? &session->job.compare.others[s - 1] : NULL;

    *out = (sc_session){.measure = session->measure,
                        .job = session->job,
                        .subjects = c->parts,
                        .subject_count = c->count,
                        .subject = s,
                        .front = sc_compare_front(c),
                        .panel = panel,
                        .times = {.threads = session->times.threads}};
    strip(&out->job);
    out->job.overlay_tissues = c->tissues[SC_USE_NAMES];
    out->job.overlay_tissue_count = c->tissue_counts[SC_USE_NAMES];
    out->job.output.size_px[0] = panel.width_px;
    out->job.output.size_px[1] = panel.height_px;
    if (other)
        strcpy(out->job.volume, other->volume);
    if (other)
        strcpy(out->job.volume_where, other->where);
    if (other && other->labels[0])
        strcpy(out->job.labels, other->labels);
    if (other && !strcmp(other->image, "none")) {
        out->job.has_image = false;
        out->job.image = (sc_grey_options){0};
    } else if (other && other->image[0]) {
        strcpy(out->job.image.path, other->image);
        snprintf(out->job.image_where, sizeof out->job.image_where, "%s", other->where);
    }
}

/* Begin the session that writes below the picture of subject @p s. The font keeps its size in
 * pixels, which would follow the height of the part in which it writes. */
static void begin_plate(const sc_session *session, sc_compare *c, int s, const sc_places *places,
                        sc_session *out)
{
    *out =
        (sc_session){.job = session->job, .panel = places->panels[s], .within = places->panels[s]};
    strip(&out->job);
    out->within.height_px += places->below_px;
    out->job.overlays.text_percent = 100 * places->text_px / out->within.height_px;
    out->job.captions = &c->captions[s];
    out->job.caption_count = 1;
}

/* Begin the session that writes over the whole picture, but for the lowest row of names. */
static void begin_front(const sc_session *session, const sc_compare *c, sc_viewport panel,
                        int below_px, sc_session *out)
{
    const int *size_px = session->job.output.size_px;

    *out = (sc_session){
        .job = session->job, .panel = panel, .within = {0, 0, size_px[0], size_px[1] - below_px}};
    out->job.output.layout = SC_LAYOUT_PICTURE;
    out->job.overlays.text_percent *= (double)size_px[1] / out->within.height_px;
    out->job.overlays.logo_percent *= (double)size_px[1] / out->within.height_px;
    out->job.overlay_tissues = c->tissues[SC_USE_LEGEND];
    out->job.overlay_tissue_count = c->tissue_counts[SC_USE_LEGEND];
}

/* Make the sessions of a comparison, without volumes. */
static sc_status new_compare(const sc_ctx *ctx, sc_session *session)
{
    const sc_job *job = &session->job;
    const int count = sc_subject_count(job);
    sc_places places;
    sc_compare *c;
    void *block;
    sc_status status;

    SC_TRY(sc_zalloc(ctx, 1, sizeof *c, &block));
    session->compare = c = block;
    SC_TRY(sc_zalloc(ctx, (size_t)part_count(count), sizeof *c->parts, &block));
    c->parts = block;
    c->count = count;
    SC_TRY(part_tissues(ctx, job, c));
    name_subjects(job, c);
    sc_place_subjects(job, c->captions, job->output.size_px, &places);
    for (int s = 0; s < count; s++) {
        begin_subject(session, c, s, places.panels[s], &c->parts[s]);
        begin_plate(session, c, s, &places, sc_compare_plate(c, s));
    }
    begin_front(session, c, places.panels[0], places.below_px, sc_compare_front(c));
    c->parts[0].mapped = session->mapped;
    c->parts[0].mapped_bytes = session->mapped_bytes;
    c->parts[0].volume = session->volume;
out:
    return status;
}

/* Tell which tissues a subject lacks, or how many if they are many. */
static sc_status tell_lacking(const sc_ctx *ctx, const sc_compare *c, int s)
{
    enum { MOST = 6 };
    const sc_prepared *v = &c->parts[s].volume;
    const int added = c->joined[s].added;
    sc_text text = {0};
    sc_status status = SC_OK;

    for (int i = 0; i < added && i < MOST; i++) {
        const sc_label *label = &v->labels[v->label_count - added + i];

        SC_TRY(sc_text_add(ctx, &text, "%s", i ? ", " : ""));
        if (label->name[0])
            SC_TRY(sc_text_add(ctx, &text, "\"%s\"", label->name));
        else
            SC_TRY(sc_text_add(ctx, &text, "label %lld", (long long)label->value));
    }
    if (added > MOST)
        SC_TRY(sc_text_add(ctx, &text, " and %d more", added - MOST));
    if (added)
        sc_info(ctx, "compare: \"%s\" lacks tissues that others have: %s", c->captions[s].text,
                text.data);
out:
    sc_text_clear(&text);
    return status;
}

/* Bring the subjects together when their volumes are there. */
static sc_status join_subjects(sc_app *app, sc_session *session)
{
    sc_compare *c = session->compare;
    sc_status status;

    SC_TRY(sc_comm_agree(app->comm, sc_join_labels(app->ctx, c->parts, c->count, c->joined)));
    for (int s = 0; s < c->count && sc_comm_rank(app->comm) == 0 && status == SC_OK; s++)
        status = tell_lacking(app->ctx, c, s);
    SC_TRY(sc_comm_agree(app->comm, status));
    status = sc_align_subjects(app, c->parts, c->count, c->joined);
out:
    return status;
}

/* Add what reading and preparing a subject took to the times of the whole. */
static void add_times(const sc_rank_record *from, sc_rank_record *to)
{
    for (int phase = 0; phase < SC_PHASE_COUNT; phase++) {
        to->phases[phase].wall_s += from->phases[phase].wall_s;
        to->phases[phase].cpu_s += from->phases[phase].cpu_s;
    }
}

sc_status sc_compare_load(sc_app *app, sc_session *session)
{
    sc_status status;

    SC_TRY(sc_comm_agree(app->comm, new_compare(app->ctx, session)));
    for (int s = 1; s < session->compare->count; s++) {
        SC_TRY(sc_session_load(app, &session->compare->parts[s]));
        add_times(&session->compare->parts[s].times, &session->times);
    }
    status = join_subjects(app, session);
out:
    return status;
}

sc_status sc_compare_inspect(sc_app *app, bool header_only, sc_session *session)
{
    sc_label_source *kept = app->label_source;
    sc_status status;

    app->label_source = NULL; /* it holds the table of the job's own volume */
    SC_TRY(new_compare(app->ctx, session));
    for (int s = 1; s < session->compare->count; s++)
        SC_TRY(sc_session_inspect(app, header_only, &session->compare->parts[s]));
    status = join_subjects(app, session);
out:
    app->label_source = kept;
    return status;
}

/* Give a subject the background that was chosen for the first one. */
static void share_background(const sc_session *first, sc_session *to)
{
    sc_background *background = &to->job.render.background;

    memmove(background->rgb, first->job.render.background.rgb, sizeof background->rgb);
    background->is_auto = false;
}

/* @return the subject before @p s that has the same grey volume; NULL: none. */
static const sc_session *lender_of(const sc_compare *c, int s)
{
    for (int i = 0; i < s; i++) {
        if (c->parts[i].job.has_image &&
            !strcmp(c->parts[i].job.image.path, c->parts[s].job.image.path))
            return &c->parts[i];
    }
    return NULL;
}

sc_status sc_compare_grey(sc_app *app, sc_session *session)
{
    sc_compare *c = session->compare;
    sc_status status = SC_OK;

    for (int s = 0; s < c->count; s++) {
        sc_session *subject = &c->parts[s];
        const sc_session *lender = lender_of(c, s);

        if (!subject->job.has_image)
            continue;
        if (lender)
            SC_TRY(sc_session_borrow_grey(app, lender, subject));
        else
            SC_TRY(sc_session_grey(app, subject));
        if (s > 0)
            continue;
        /* What is found for the first one holds for all, so that the same value looks the same. */
        for (int other = 1; other < c->count; other++) {
            c->parts[other].job.image.window_auto = false;
            c->parts[other].job.image.shown.window = subject->grey_window;
        }
    }
out:
    return status;
}

sc_status sc_compare_check_grey(const sc_app *app, const sc_session *session)
{
    sc_status status = SC_OK;

    for (int s = 0; s < session->compare->count && status == SC_OK; s++)
        status = sc_session_check_grey(app, &session->compare->parts[s]);
    return status;
}

sc_status sc_compare_tissues(sc_app *app, sc_session *session)
{
    sc_compare *c = session->compare;
    sc_status status = SC_OK;

    SC_TRY(sc_session_tissues(app, &c->parts[0]));
    for (int i = 1; i < part_count(c->count); i++)
        share_background(&c->parts[0], &c->parts[i]);
    for (int s = 1; s < c->count; s++)
        SC_TRY(sc_session_tissues(app, &c->parts[s]));
out:
    return status;
}

/* Find the box, in voxels of the volume @p to, of a tissue that only another one has. */
static sc_label_stats stats_for(const sc_prepared *from, const sc_label_stats *stats,
                                const sc_prepared *to)
{
    sc_label_stats out = *stats;
    sc_affine to_voxel;
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};

    if (!stats->voxels || !sc_affine_invert(&to->to_ras_mm, &to_voxel))
        return out;
    for (int corner = 0; corner < 8; corner++) {
        const sc_vec3 at = {corner & 1 ? stats->high[0] : stats->low[0],
                            corner & 2 ? stats->high[1] : stats->low[1],
                            corner & 4 ? stats->high[2] : stats->low[2]};
        const sc_vec3 there = sc_affine_point(&to_voxel, sc_affine_point(&from->to_ras_mm, at));
        const double place[3] = {there.x, there.y, there.z};

        for (int i = 0; i < 3; i++) {
            low[i] = fmin(low[i], place[i]);
            high[i] = fmax(high[i], place[i]);
        }
    }
    for (int i = 0; i < 3; i++) {
        out.low[i] = (int)floor(fmax(low[i], -1e6));
        out.high[i] = (int)ceil(fmin(high[i], 1e6));
    }
    return out;
}

/* Let what is written over all know the tissues of all subjects: as the first one does, but with
 * the extent of those that only others have. */
static sc_status fill_front(const sc_ctx *ctx, sc_compare *c)
{
    const sc_session *first = &c->parts[0];
    const int labels = first->volume.label_count, own = labels - c->joined[0].added;
    sc_session *front = sc_compare_front(c);
    void *block;
    const sc_status status = sc_alloc(ctx, (size_t)labels, sizeof *c->stats, &block);

    if (status != SC_OK)
        return status;
    c->stats = block;
    memcpy(c->stats, first->volume.stats, (size_t)labels * sizeof *c->stats);
    for (int id = own; id < labels; id++) {
        const sc_tissue_owner *owner = &first->owners[id];
        const sc_prepared *v = &c->parts[owner->subject].volume;

        c->stats[id] = stats_for(v, &v->stats[owner->id], &first->volume);
    }
    front->volume = first->volume;
    front->volume.ids = NULL; /* it has no names beside tissues */
    front->volume.stats = c->stats;
    front->tissues = first->tissues;
    return SC_OK;
}

sc_status sc_compare_timeline(sc_app *app, sc_session *session, const sc_vec3 *points, size_t count)
{
    sc_compare *c = session->compare;
    sc_session *first = &c->parts[0];
    sc_status status;

    SC_TRY(sc_session_timeline(app, first, points, count));
    first->is_divided = session->job.compare.has_divider;
    for (int i = 1; i < part_count(c->count); i++) {
        sc_session *part = &c->parts[i];

        part->timeline = first->timeline;
        part->is_divided = i < c->count && session->job.compare.has_divider;
        if (i < c->count)
            sc_session_looks(part);
    }
    SC_TRY(sc_comm_agree(app->comm, fill_front(app->ctx, c)));
    /* First what is written over all: the names of the subjects leave room for it. */
    SC_TRY(sc_session_letter(app, sc_compare_front(c)));
    for (int i = 0; i < part_count(c->count) - 1; i++)
        SC_TRY(sc_session_letter(app, &c->parts[i]));
out:
    return status;
}

/* List the corners of what all subjects show. Caller owns *out: sc_free. */
static sc_status gather_hulls(const sc_ctx *ctx, const sc_compare *c, sc_vec3 **out, size_t *count)
{
    size_t all = 0, each;
    void *block;
    sc_status status;

    for (int s = 0; s < c->count; s++) {
        (void)sc_renderer_hull(c->parts[s].renderer, &each);
        all += each;
    }
    status = sc_alloc(ctx, all, sizeof **out, &block);
    if (status != SC_OK)
        return status;
    *out = block;
    *count = 0;
    for (int s = 0; s < c->count; s++) {
        const sc_vec3 *hull = sc_renderer_hull(c->parts[s].renderer, &each);

        if (each)
            memcpy(*out + *count, hull, each * sizeof *hull);
        *count += each;
    }
    return SC_OK;
}

sc_status sc_compare_scene(sc_app *app, sc_session *session)
{
    sc_compare *c = session->compare;
    sc_vec3 *points = NULL;
    size_t count = 0;
    sc_status status;

    SC_TRY(sc_compare_tissues(app, session));
    for (int s = 0; s < c->count; s++)
        SC_TRY(sc_shot_renderer(app, &c->parts[s]));
    session->renderer = c->parts[0].renderer; /* for those who ask about drawing at all */
    session->borrows_renderer = true;
    SC_TRY(sc_comm_agree(app->comm, gather_hulls(app->ctx, c, &points, &count)));
    status = sc_compare_timeline(app, session, points, count);
out:
    sc_free(points);
    return status;
}

/* ---- what is told of it ---- */

uint64_t sc_session_volume_hash(const sc_session *session)
{
    const sc_compare *c = session->compare;
    uint64_t hashes[SC_SUBJECTS_MAX];

    if (!c)
        return sc_phases_hash(session);
    for (int s = 0; s < c->count; s++)
        hashes[s] = c->parts[s].volume.volume_hash;
    return sc_hash_bytes(hashes, (size_t)c->count * sizeof *hashes, 0);
}

uint64_t sc_session_prepared_bytes(const sc_session *session)
{
    const sc_compare *c = session->compare;
    uint64_t bytes = session->shared_bytes;

    for (int s = 1; c && s < c->count; s++)
        bytes += c->parts[s].shared_bytes;
    return bytes;
}

uint64_t sc_session_grey_bytes(const sc_session *session)
{
    const sc_compare *c = session->compare;
    uint64_t bytes = session->grey_codes ? sc_grey_bytes(&session->grey) : 0;

    for (int s = 0; c && s < c->count; s++)
        bytes += sc_session_grey_bytes(&c->parts[s]);
    return bytes;
}

/* ---- the end ---- */

void sc_compare_free(sc_session *session)
{
    sc_compare *c = session->compare;

    if (!c)
        return;
    if (c->parts && c->count)
        sc_compare_front(c)->tissues = NULL; /* they are the first subject's */
    for (int i = 0; c->parts && i < part_count(c->count); i++)
        sc_shot_clear(&c->parts[i]);
    for (int s = 1; s < c->count; s++)
        sc_session_clear_volume(&c->parts[s]);
    for (int s = 0; s < c->count; s++) {
        sc_shared_free(c->parts[s].grey_codes);
        sc_joined_clear(&c->joined[s]);
    }
    for (int use = 0; use < 2; use++)
        sc_free(c->tissues[use]);
    sc_free(c->parts);
    sc_free(c->stats);
    sc_image_clear(&c->other);
    sc_free(c);
    session->compare = NULL;
}
