/* SPDX-License-Identifier: BSD-3-Clause */
#include "version.h"

#include "segcast/cli.h"
#include "segcast/comm.h"
#include "segcast/video.h"
#include "segcast/volume.h"

const char *sc_version(void)
{
    return SC_VERSION;
}

const char *sc_commit(void)
{
    return SC_COMMIT;
}

const char *sc_build_json(void)
{
    return SC_BUILD_JSON;
}

void sc_print_version(FILE *stream)
{
    char mpi[256], video[256], kinds[512], volumes[256];

    sc_comm_library(mpi, sizeof mpi);
    sc_video_libraries(video, sizeof video);
    sc_video_kinds(kinds, sizeof kinds);
    sc_volume_formats(volumes, sizeof volumes);
    fprintf(stream,
            "segcast %s\ncommit   %s\ncompiler %s, %s\nMPI      %s\nlibav    %s\nvideos   "
            "%s\nvolumes  %s\n",
            SC_VERSION, SC_COMMIT, SC_COMPILER, SC_BUILD_TYPE, mpi, video, kinds, volumes);
}
