/* SPDX-License-Identifier: BSD-3-Clause */
/* segcast --version --json: what is needed to build the same program again. */
#include "commands.h"
#include "segcast/video.h"

sc_status sc_print_version_json(const sc_ctx *ctx)
{
    char mpi[256], video[256], kinds[512], volumes[256];
    json_t *json = json_loads(sc_build_json(), 0, NULL), *runs;

    sc_comm_library(mpi, sizeof mpi);
    sc_video_libraries(video, sizeof video);
    sc_video_kinds(kinds, sizeof kinds);
    sc_volume_formats(volumes, sizeof volumes);
    runs = json_pack("{s:s, s:s, s:s, s:s, s:s, s:s, s:s}", "schema", "segcast-version-1",
                     "version", sc_version(), "commit", sc_commit(), "mpi", mpi, "libav", video,
                     "videos", kinds, "volumes", volumes);
    if (!json || json_object_update_missing(runs, json)) {
        json_decref(runs);
        runs = NULL;
    }
    json_decref(json);
    return sc_print_json(ctx, runs, JSON_COMPACT, "version");
}
