/* SPDX-License-Identifier: BSD-3-Clause */
#include "app.h"

#include <string.h>

static const sc_command commands[] = {
    {"render", "JOB.yaml", "make the video and frames of a job", sc_run_render, true},
    {"check", "JOB.yaml", "say whether a job can run", sc_run_check, false},
    {"plan", "JOB.yaml", "frames, memory and estimated core hours of a job", sc_run_plan, false},
    {"still", "JOB.yaml", "draw one frame of a job as PNG", sc_run_still, false},
    {"views", "VOLUME", "draw the three regular views beside the picture as PNG", sc_run_views,
     false},
    {"orbit", "VOLUME", "make a video of a volume without a job file", sc_run_orbit, true},
    {"info", "VOLUME", "geometry, labels, boundary, thickness and surface", sc_run_info, false},
    {"prepare", "VOLUME|JOB.yaml", "prepare a volume, as a job needs it, as a file to be mapped",
     sc_run_prepare, false},
    {"join", "DIR", "make the video of a job whose frames were drawn in slices", sc_run_join,
     false},
    {"verify", "DIR", "prove every frame and the video of a finished job", sc_run_verify, false},
    {"phantom", "", "write the built-in synthetic heart", sc_run_phantom, false},
};

const sc_command *sc_command_find(const char *name)
{
    for (size_t i = 0; i < SC_COUNT_OF(commands); i++) {
        if (!strcmp(name, commands[i].name))
            return &commands[i];
    }
    return NULL;
}

sc_status sc_command_unknown(const sc_ctx *ctx, const char *name)
{
    const char *names[SC_COUNT_OF(commands)], *nearest;

    if (!name)
        return sc_fail(ctx, SC_ERR_USAGE, "no command; try `segcast --help`");
    for (size_t i = 0; i < SC_COUNT_OF(commands); i++)
        names[i] = commands[i].name;
    nearest = sc_nearest_word(name, names, SC_COUNT_OF(commands));
    return sc_fail(ctx, SC_ERR_USAGE, "unknown command \"%s\"; %s%s%s", name,
                   nearest ? "did you mean \"" : "try `segcast --help`", nearest ? nearest : "",
                   nearest ? "\"?" : "");
}

void sc_print_help(FILE *stream)
{
    fprintf(stream, "Videos of segmented volumes, ray-cast on CPUs under MPI and OpenMP.\n\n"
                    "usage: segcast COMMAND ...   alone, or under mpirun or srun\n\n");
    for (size_t i = 0; i < SC_COUNT_OF(commands); i++)
        fprintf(stream, "  segcast %-8s %-9s %s\n", commands[i].name, commands[i].arguments,
                commands[i].help);
    fprintf(stream, "\n  segcast COMMAND --help    its options\n"
                    "  segcast --version         version, commit, compiler, libraries\n\n"
                    "exit codes: 0 complete; 64 usage; 65 bad data; 66 input missing; 70 internal;"
                    "\n  73/74 output cannot be created/written; 75 incomplete, run again\n");
}
