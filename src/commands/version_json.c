/* SPDX-License-Identifier: BSD-3-Clause */
/* segcast --version --json: what is needed to build the same program again. */
#include "commands.h"
#include "segcast/video.h"

#include <jansson.h>
#include <stdlib.h>

sc_status sc_print_version_json(const sc_ctx *ctx)
{
    char mpi[256], video[256], kinds[512], volumes[256];
    json_t *json = json_loads(sc_build_json(), 0, NULL), *runs;
    char *text;

    sc_comm_library(mpi, sizeof mpi);
    sc_video_libraries(video, sizeof video);
    sc_video_kinds(kinds, sizeof kinds);
    sc_volume_formats(volumes, sizeof volumes);
    runs = json_pack("{s:s, s:s, s:s, s:s, s:s, s:s, s:s}", "schema", "segcast-version-1",
                     "version", sc_version(), "commit", sc_commit(), "mpi", mpi, "libav", video,
                     "videos", kinds, "volumes", volumes);
    text = json && runs && !json_object_update_missing(runs, json) ? json_dumps(runs, JSON_COMPACT)
                                                                   : NULL;
    json_decref(json);
    json_decref(runs);
    if (!text)
        return sc_fail(ctx, SC_ERR_MEMORY, "out of memory while the version was written as JSON");
    printf("%s\n", text);
    free(text);
    return SC_OK;
}
