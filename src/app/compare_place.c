/* SPDX-License-Identifier: BSD-3-Clause */
/* Where the subjects of a comparison stand: in space, and in the picture; and what they are called
 * there. */
#include "compare.h"
#include "segcast/views.h"

#include <math.h>
#include <string.h>
#include <strings.h>

/* ---- in space ---- */

/* Let a box hold the box of voxels from @p low to @p high of a volume. */
static void hold(const sc_prepared *v, const int low[3], const int high[3], sc_box3 *box)
{
    for (int corner = 0; corner < 8; corner++) {
        const sc_vec3 at =
            sc_affine_point(&v->to_ras_mm, (sc_vec3){corner & 1 ? high[0] + 0.5 : low[0] - 0.5,
                                                     corner & 2 ? high[1] + 0.5 : low[1] - 0.5,
                                                     corner & 4 ? high[2] + 0.5 : low[2] - 0.5});

        box->low =
            (sc_vec3){fmin(box->low.x, at.x), fmin(box->low.y, at.y), fmin(box->low.z, at.z)};
        box->high =
            (sc_vec3){fmax(box->high.x, at.x), fmax(box->high.y, at.y), fmax(box->high.z, at.z)};
    }
}

/* Find the middle, RAS mm, of the box around the tissues that a subject shows; of its whole volume
 * if it shows none, or if its voxels were not read. */
static sc_status find_middle(const sc_ctx *ctx, const sc_session *subject, sc_vec3 *out)
{
    const sc_prepared *v = &subject->volume;
    const int first[3] = {0, 0, 0}, last[3] = {v->size[0] - 1, v->size[1] - 1, v->size[2] - 1};
    sc_box3 box = {{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
    bool unused;
    void *hidden = NULL;
    sc_status status;

    SC_TRY(sc_zalloc(ctx, (size_t)v->label_count, sizeof(bool), &hidden));
    SC_TRY(sc_hidden_labels(ctx, v->labels, v->label_count, subject->job.rules,
                            subject->job.rule_count, hidden, &unused));
    for (int id = 1; id < v->label_count; id++) {
        if (!((const bool *)hidden)[id] && v->stats[id].voxels)
            hold(v, v->stats[id].low, v->stats[id].high, &box);
    }
    if (box.low.x > box.high.x)
        hold(v, first, last, &box);
    *out = sc_vec3_scale(sc_vec3_add(box.low, box.high), 0.5);
out:
    sc_free(hidden);
    return status;
}

/* Move the view of a volume. */
static sc_status move(const sc_ctx *ctx, sc_vec3 by_mm, sc_prepared *v, sc_joined *joined)
{
    sc_stored *stored = &v->stored;
    sc_vec3 *hull;
    void *block;
    sc_status status;

    if (sc_vec3_length(by_mm) == 0)
        return SC_OK;
    v->to_ras_mm.m[0][3] += by_mm.x;
    v->to_ras_mm.m[1][3] += by_mm.y;
    v->to_ras_mm.m[2][3] += by_mm.z;
    if (!stored->hull)
        return SC_OK;
    status = sc_alloc(ctx, stored->hull_count, sizeof *hull, &block);
    if (status != SC_OK)
        return status;
    joined->owned[6] = hull = block;
    for (size_t i = 0; i < stored->hull_count; i++)
        hull[i] = sc_vec3_add(stored->hull[i], by_mm);
    stored->hull = hull;
    return SC_OK;
}

sc_status sc_align_subjects(sc_app *app, sc_session *subjects, int count, sc_joined *joined)
{
    const bool first = sc_comm_rank(app->comm) == 0;
    sc_vec3 middles[SC_SUBJECTS_MAX] = {{0, 0, 0}};
    sc_status status = SC_OK;

    if (subjects[0].job.compare.align == SC_ALIGN_NONE)
        return SC_OK;
    for (int s = 0; s < count && first && status == SC_OK; s++)
        status = find_middle(app->ctx, &subjects[s], &middles[s]);
    SC_TRY(sc_comm_agree(app->comm, status));
    sc_comm_broadcast(app->comm, middles, sizeof middles);
    for (int s = 1; s < count && status == SC_OK; s++)
        status =
            move(app->ctx, sc_vec3_sub(middles[0], middles[s]), &subjects[s].volume, &joined[s]);
    status = sc_comm_agree(app->comm, status);
out:
    return status;
}

/* ---- in the picture ---- */

#define BELOW 2.2 /* height for a line of text below a picture, in font sizes */

int sc_place_subjects(const sc_job *job, const int size_px[2], sc_viewport *out)
{
    const double text_px = fmax(9, job->overlays.text_percent / 100 * size_px[1]);
    const int below_px = (int)fmin(ceil(BELOW * text_px), size_px[1] / 4.0);

    if (!job->compare.has_divider) {
        sc_place_panels(size_px, sc_subject_count(job), below_px, out);
        return below_px;
    }
    for (int s = 0; s < sc_subject_count(job); s++)
        out[s] = (sc_viewport){0, 0, size_px[0], size_px[1] - below_px};
    return below_px;
}

int sc_divider_px(const sc_job *job, int k, int width_px)
{
    const sc_comparison *compare = &job->compare;
    const double share =
        sc_ramp_value(&compare->divider, &compare->divider_track, k, job->animation.frames);

    return (int)floor(fmin(fmax(share, 0), 1) * width_px + 0.5);
}

/* ---- names ---- */

void sc_name_of_file(const char *volume, char out[SC_CAPTION_BYTES])
{
    static const char *const endings[] = {".gz",   ".nii",  ".seg", ".nrrd", ".nhdr",
                                          ".mgz",  ".mgh",  ".mha", ".mhd",  ".tif",
                                          ".tiff", ".zarr", ".ome", ".segc"};
    enum { LONGEST = 60 };
    size_t end = strlen(volume), begin, used = 0, bytes;

    while (end > 1 && volume[end - 1] == '/')
        end--;
    for (begin = end; begin > 0 && volume[begin - 1] != '/';)
        begin--;
    for (size_t i = 0; i < SC_COUNT_OF(endings); i++) {
        const size_t length = strlen(endings[i]);

        if (end - begin > length && !strncasecmp(volume + end - length, endings[i], length)) {
            end -= length;
            i = (size_t)-1; /* it may have another one before that */
        }
    }
    for (size_t at = begin; at < end && used < LONGEST; at += bytes) {
        const size_t whole = sc_utf8_bytes(volume + at);

        bytes = whole ? whole : 1;
        if (!whole || sc_font_refuses(sc_utf8_code(volume + at, bytes))) {
            out[used++] = '?';
            continue;
        }
        memcpy(out + used, volume + at, bytes);
        used += bytes;
    }
    out[used] = '\0';
}
