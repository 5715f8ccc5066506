/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to phases.c and phase_memory.c: what a session of a series holds. */
#ifndef SC_APP_PHASES_H
#define SC_APP_PHASES_H

#include "app.h"

/* So many phases are loaded at once while frames are drawn: that of the frame, and one more, which
 * is that of the other shot under a cross-fade, or else of the frame before. */
enum { SC_PHASES_LOADED = 2 };

/* A phase from which this rank has drawn. */
typedef struct sc_loaded_phase {
    sc_renderer *renderer; /* NULL: none; borrowed */
    int phase;
} sc_loaded_phase;

struct sc_phases {
    int count;       /* of sessions: one less than there are phases */
    sc_session *all; /* [count], owned; all[i] is that of phase i + 1 */
    /* What holds the volume of the first phase, which is that of the session itself. Borrowed. */
    sc_shared *first_shared;
    const void *first_mapped;
    size_t first_mapped_bytes;
    sc_loaded_phase loaded[SC_PHASES_LOADED]; /* the last one first */
    bool in_files; /* the volumes, and what is derived from them, are held in files */
};

#endif
