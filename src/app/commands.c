/* SPDX-License-Identifier: BSD-3-Clause */
/* The table of commands, and that of exit codes. */
#include "app.h"

#include <string.h>

const sc_command sc_commands[] = {
    {"render", "JOB.yaml", "make the video and the frames of a job",
     "Runs alone or under mpirun or srun. The output folder holds the video, manifest.jsonl "
     "(hashes of "
     "job, volume and frames), status.json (progress), stats.json and frames.csv (times), "
     "trace.json and "
     "job.yaml (the job as resolved). A folder that holds a run is refused without --resume or "
     "--overwrite.",
     sc_cmd_render, true},
    {"check", "JOB.yaml", "say whether a job can run",
     "Reads the job file, the label table and the labels of the volume; draws nothing.",
     sc_cmd_check, false},
    {"plan", "JOB.yaml", "frames, memory and estimated core hours of a job",
     "Measured on a few small frames of the job itself.", sc_cmd_plan, false},
    {"still", "JOB.yaml", "draw one frame of a job as PNG", NULL, sc_cmd_still, false},
    {"views", "VOLUME", "draw the three regular slices beside the picture as PNG", NULL,
     sc_cmd_views, false},
    {"orbit", "VOLUME", "make a video of a volume without a job file",
     "Leaves nothing but the video.", sc_cmd_orbit, true},
    {"info", "VOLUME", "geometry, labels, boundary voxels, thickness and surface of a volume", NULL,
     sc_cmd_info, false},
    {"prepare", "VOLUME|JOB.yaml", "prepare a volume as a file that later jobs map",
     "A prepared file holds one strength of smoothing and one set of hidden tissues; give the job "
     "instead of the volume to get the file that fits the job.",
     sc_cmd_prepare, false},
    {"join", "DIR", "make the video of a job whose frames were drawn in slices", NULL, sc_cmd_join,
     false},
    {"verify", "DIR", "check every frame and the video of a finished job against the manifest",
     NULL, sc_cmd_verify, false},
    {"phantom", "", "write the built-in synthetic heart", NULL, sc_cmd_phantom, false},
    {"keys", "[PREFIX]", "list the keys of a job file: type, range, default and meaning",
     "With a prefix, such as render or animation.camera, only the keys below it.", sc_cmd_keys,
     false},
    {"help", "[COMMAND]", "explain a command", NULL, sc_cmd_help, false},
    {0}};

const sc_command *sc_command_find(const char *name)
{
    for (const sc_command *command = sc_commands; command->name; command++) {
        if (!strcmp(name, command->name))
            return command;
    }
    return NULL;
}

sc_status sc_command_unknown(const sc_ctx *ctx, const char *name)
{
    const char *names[SC_COUNT_OF(sc_commands)], *nearest;

    if (!name)
        return sc_fail(ctx, SC_ERR_USAGE, "no command; try `segcast --help`");
    for (size_t i = 0; i < SC_COUNT_OF(sc_commands); i++)
        names[i] = sc_commands[i].name;
    nearest = sc_nearest_word(name, names, SC_COUNT_OF(sc_commands));
    return sc_fail(ctx, SC_ERR_USAGE, "unknown command \"%s\"; %s%s%s", name,
                   nearest ? "did you mean \"" : "try `segcast --help`", nearest ? nearest : "",
                   nearest ? "\"?" : "");
}

const sc_exit_code sc_exit_codes[] = {{SC_OK, 0, "complete"},
                                      {SC_ERR_USAGE, 64, "wrong use: command line or settings"},
                                      {SC_ERR_DATA, 65, "an input is broken"},
                                      {SC_ERR_MISSING, 66, "an input is missing"},
                                      {SC_ERR_INTERNAL, 70, "internal error"},
                                      {SC_ERR_MEMORY, 70, "out of memory"},
                                      {SC_ERR_CREATE, 73, "an output cannot be created"},
                                      {SC_ERR_WRITE, 74, "an output cannot be written"},
                                      {SC_ERR_INCOMPLETE, 75, "incomplete: run again"},
                                      {0}};

int sc_exit_code_of(sc_status status)
{
    for (const sc_exit_code *row = sc_exit_codes; row->meaning; row++) {
        if (row->status == status)
            return row->code;
    }
    return 70;
}
