/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  The desk: a server on the machine where the data are, for a page in a browser in which a job is
 *  looked at and changed by hand. What a page changes are keys of the job, as by --set; pictures
 *  are drawn by the renderer, so that what is seen is what is rendered. */
#ifndef SEGCAST_DESK_H
#define SEGCAST_DESK_H

#include "segcast/film.h"

/** What is looked at, and how it is served. All borrowed. */
typedef struct sc_desk_plan {
    const char *path;    /**< of the job file, to which the desk saves; it need not be there yet */
    const char *text;    /**< what stands in it, or is to stand there */
    bool is_new;         /**< there is no file yet */
    const char *listen;  /**< address of this machine; NULL: only this machine can connect */
    int port;            /**< 0: one that is free */
    int idle_min;        /**< end when nobody has done anything for so many minutes; 0: never */
    const char *command; /**< how segcast was called, for commands that the page shows */
} sc_desk_plan;

/** Serve until INT, TERM or HUP, or for as long as the plan says. Prints the address to standard
 *  output. Collective: all ranks draw; of the plan, that of rank 0 counts. @return SC_OK when it
 * was asked to end; SC_ERR_CREATE if it cannot listen there; the errors of sc_session_job and
 * sc_session_volume of the job as it stands in the file, logged. */
SC_MUST_USE sc_status sc_desk_serve(sc_app *app, const sc_desk_plan *plan);

#endif
