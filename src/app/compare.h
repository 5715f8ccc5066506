/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to app: what is made for a comparison of several volumes. */
#ifndef SC_APP_COMPARE_H
#define SC_APP_COMPARE_H

#include "app.h"

/* What the volume of one subject got beside its own. */
typedef struct sc_joined {
    void *owned[7]; /* arrays that its view points to; freed by sc_joined_clear */
    int added;      /* tissues that only others have */
} sc_joined;

/* What a session has where several volumes are compared. */
struct sc_compare {
    int count;                         /* of subjects */
    sc_session *parts;                 /* [part_count(count)], owned: subjects, then what is written
                                          below each, then what is written over all */
    sc_joined joined[SC_SUBJECTS_MAX]; /* of the subjects */
    sc_label_stats *stats;             /* of all tissues, for what is written over all; owned */
    sc_caption captions[SC_SUBJECTS_MAX]; /* the names of the subjects */
    sc_overlay_tissue *tissues[2];        /* by sc_tissue_use: those of the job; owned */
    size_t tissue_counts[2];
    sc_image other; /* the second subject, beside a divider; empty until it is needed */
};

/* @return the session that writes below the picture of subject @p i. */
static inline sc_session *sc_compare_plate(const sc_compare *c, int i)
{
    return &c->parts[c->count + i];
}

/* @return the session that writes over the whole picture. */
static inline sc_session *sc_compare_front(const sc_compare *c)
{
    return &c->parts[2 * c->count];
}

/* ---- compare_labels.c ---- */

/* Give the view of each subject's volume the labels that only others have, without voxels, behind
 * its own, and fill session->owners. The views stay valid until sc_joined_clear. Not collective;
 * the same on all ranks. @param out [count], zeroed; to be cleared also after an error. @return
 * SC_ERR_MEMORY. */
sc_status sc_join_labels(const sc_ctx *ctx, sc_session *subjects, int count, sc_joined *out);
void sc_joined_clear(sc_joined *joined);

/* ---- compare_place.c ---- */

/* Move the volumes of the subjects as compare.align says: only their views change. @param joined
 * [count] as of sc_join_labels. Collective. @return SC_ERR_MEMORY. */
sc_status sc_align_subjects(sc_app *app, sc_session *subjects, int count, sc_joined *joined);
/* Where the subjects lie in a picture. */
typedef struct sc_places {
    sc_viewport panels[SC_SUBJECTS_MAX]; /* of each */
    int below_px;                        /* height that is free below each, for the names */
    double text_px; /* size of the font of the names: smaller than that of other text if they are
                       long */
} sc_places;
/* Find where the pictures of the subjects lie in one of @p size_px. @param names [sc_subject_count]
 * what is written below them. Whatever fonts there are, the result is the same. */
void sc_place_subjects(const sc_job *job, const sc_caption *names, const int size_px[2],
                       sc_places *out);
/* Find what is written below a subject of which the job gives no name: the name of its file,
 * without what tells its format. */
void sc_name_of_file(const char *volume, char out[SC_CAPTION_BYTES]);

#endif
