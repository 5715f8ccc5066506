/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to commands: what this machine takes for what a run does beside drawing and encoding, and
 * the file in the user's cache directory that keeps it. */
#ifndef SC_COMMANDS_CALIBRATION_H
#define SC_COMMANDS_CALIBRATION_H

#include "commands.h"

/* Unit costs, as sc_simulate takes them. */
typedef struct sc_unit_costs {
    double notice_s;         /* until a thread that sleeps notices a message, in the mean */
    double message_s;        /* CPU time of rank 0 for a message */
    double latency_s;        /* of a message between two nodes */
    double link_bytes_per_s; /* between two nodes */
    double copy_bytes_per_s; /* of one thread in memory */
    double file_bytes_per_s; /* written and flushed, in the cache directory */
    bool measured;           /* false: all are assumed */
    bool messages_measured;  /* message_s is measured, with at least two ranks, */
    bool network_measured;   /* and so are latency_s and link_bytes_per_s, with two nodes */
} sc_unit_costs;

/* @return costs of a usual machine of a cluster, for where nothing was measured. */
sc_unit_costs sc_unit_costs_assumed(void);

/* Find the file for this processor and version in the user's cache directory. @return SC_ERR_CREATE
 * if the environment names no such directory, SC_ERR_MEMORY. Caller owns *out: sc_free. */
sc_status sc_calibration_path(const sc_ctx *ctx, char **out);
/* Read the costs of this machine; not collective. What is damaged, or is not a file of this user
 * for this processor and version, is told in a warning. @return the assumed costs, if there is no
 * file or not such a one. */
sc_unit_costs sc_calibration_load(const sc_ctx *ctx);
/* Make the directory of the file at @p path, as far as it is not there: for the user alone. @return
 * SC_ERR_CREATE, SC_ERR_MEMORY. */
sc_status sc_calibration_make_directory(const sc_ctx *ctx, const char *path);
/* Refuse a file at @p path that segcast has not written for this user: a file of another program, a
 * link, a directory. @return SC_ERR_CREATE, logged. */
sc_status sc_calibration_check(const sc_ctx *ctx, const char *path);
/* Keep the costs; only the user may read the file. The directory must be there. @return
 * the error of sc_calibration_check, SC_ERR_CREATE, SC_ERR_WRITE, SC_ERR_MEMORY. */
sc_status sc_calibration_save(const sc_ctx *ctx, const sc_unit_costs *costs, const char *path);

/* ---- plan_calibrate.c ---- */

/* segcast plan --calibrate: measure the costs, keep and print them. Collective; @return the status
 * of the command, with everything logged. */
sc_status sc_calibrate(sc_app *app);

#endif
