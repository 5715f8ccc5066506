/* SPDX-License-Identifier: BSD-3-Clause */
/* Writes status.json, which tells users and scripts how far a run is. */
#include "segcast/study.h"

#include <errno.h>
#include <jansson.h>
#include <stdlib.h>
#include <string.h>

sc_status sc_progress_write(const sc_ctx *ctx, const char *path, const sc_progress_report *report)
{
    json_auto_t *json = json_pack(
        "{s:s, s:s, s:i, s:i, s:f, s:f, s:f}", "schema", "segcast-status-1", "state", report->state,
        "done", report->done, "total", report->total, "elapsed_s", report->elapsed_s,
        "frames_per_s", report->frames_per_s, "remaining_s", report->remaining_s);
    SC_OWN(sc_free_at) char *text = NULL;

    if (json && report->phase)
        json_object_set_new(json, "phase", json_string(report->phase));
    if (json && report->run)
        json_object_set_new(json, "run", json_string(report->run));
    if (json && report->phase && report->phase_share >= 0)
        json_object_set_new(json, "phase_share", json_real(report->phase_share));
    errno = 0;
    text = json ? json_dumps(json, JSON_INDENT(2)) : NULL;
    if (!text || errno == ENOMEM) { /* jansson leaves out what it has no memory for */
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", path);
    }
    return sc_file_write(ctx, path, text, strlen(text));
}
