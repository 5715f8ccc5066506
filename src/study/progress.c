/* SPDX-License-Identifier: BSD-3-Clause */
/* Writes status.json, which tells users and scripts how far a run is. */
#include "segcast/json_values.h"
#include "segcast/study.h"

sc_status sc_progress_write(const sc_ctx *ctx, const char *path, const sc_progress_report *report)
{
    json_t *json = json_pack("{s:s, s:s, s:i, s:i, s:f, s:f, s:f}", "schema", "segcast-status-1",
                             "state", report->state, "done", report->done, "total", report->total,
                             "elapsed_s", report->elapsed_s, "frames_per_s", report->frames_per_s,
                             "remaining_s", report->remaining_s);
    SC_OWN(sc_text_clear) sc_text text = {0};

    if (json && report->phase)
        json_object_set_new(json, "phase", json_string(report->phase));
    if (json && report->run)
        json_object_set_new(json, "run", json_string(report->run));
    if (json && report->phase && report->phase_share >= 0)
        json_object_set_new(json, "phase_share", json_real(report->phase_share));
    SC_PASS(sc_json_add_text(ctx, json, JSON_INDENT(2), path, &text));
    return sc_file_write(ctx, path, text.data, text.length_bytes);
}
