/* SPDX-License-Identifier: BSD-3-Clause */
/* What the subjects of a comparison have in common: the looks of their tissues, and the camera. */
#include "app.h"

int sc_subject_count(const sc_job *job)
{
    return job->has_compare ? 1 + job->compare.count : 1;
}

/* Give a tissue the look of another one. Which planes cut it and what verbs do to it stays. */
static void take_look(const sc_tissue *from, sc_tissue *to)
{
    const sc_tissue own = *to;

    *to = *from;
    to->clip_set = own.clip_set;
    to->fade_group = own.fade_group;
    to->part = own.part;
}

void sc_take_looks(sc_session *session)
{
    for (int id = 1; session->owners && id < session->volume.label_count; id++) {
        const sc_tissue_owner *owner = &session->owners[id];

        if (owner->subject < session->subject)
            take_look(&session->subjects[owner->subject].tissues[owner->id], &session->tissues[id]);
    }
}

const sc_session *sc_framed_with(const sc_session *session, int i)
{
    if (!session->subjects)
        return i == 0 ? session : NULL;
    return i < session->subject_count ? &session->subjects[i] : NULL;
}
