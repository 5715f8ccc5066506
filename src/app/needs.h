/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to app: what a job asks of the preparation of its volume. */
#ifndef SC_APP_NEEDS_H
#define SC_APP_NEEDS_H

#include "app.h"

/* What a job needs of a preparation; see sc_prepare_settings. */
typedef struct sc_needs {
    sc_vec3 smooth;
    sc_vec3 *tissue_smooth; /* [label_count], owned */
    bool as_prepared; /* accept a prepared file with any grid and strengths: it is only described */
    bool resample;    /* to the grid on which the volume was drawn */
    bool resize;      /* to volume_size, before anything else */
    int size[3];      /* that many voxels */
    bool local_thickness;
    bool *hidden; /* [label_count], owned: labels that become background */
} sc_needs;

/* Fill in what the job of a session, or each of its shots, needs. No label is hidden if
 * session->measure. Not collective. @return SC_ERR_MEMORY. Caller owns @p out: sc_needs_clear. */
sc_status sc_needs_find(const sc_app *app, const sc_session *session, const sc_label *labels,
                        int label_count, sc_needs *out);
/* Free the arrays of @p needs. */
void sc_needs_clear(sc_needs *needs);

#endif
