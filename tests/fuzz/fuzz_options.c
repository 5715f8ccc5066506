/* SPDX-License-Identifier: BSD-3-Clause */
/* The input is a command line, one word a line: the command, then options and arguments. The job
 * that the options alone make is loaded, too, and so are lists of frames. Lines that begin with
 * SEGCAST_ are the environment. */
#include "commands.h"
#include "fuzz.h"

#include <getopt.h>

enum { WORDS_MAX = 64 };

/* Load the job of the options, and read the list of frames. */
static void use(const sc_options *options, const char *const *environment)
{
    const sc_job_sources sources = {.settings = options->settings.all,
                                    .setting_count = options->settings.count,
                                    .defaults = options->settings.defaults,
                                    .default_count = options->settings.default_count,
                                    .environment = environment};
    SC_OWN(sc_job_clear) sc_job job = {0};
    int *frames, count;

    if (sc_job_load(&fuzz_ctx, &sources, &job) == SC_OK)
        FUZZ_CHECK(job.volume.path[0]);
    if (options->part.frames &&
        sc_frames_parse(&fuzz_ctx, options->part.frames, 1000, &frames, &count) == SC_OK) {
        FUZZ_CHECK(count > 0 && count <= 1000);
        for (int i = 0; i < count; i++)
            FUZZ_CHECK(frames[i] >= (i ? frames[i - 1] + 1 : 0) && frames[i] < 1000);
        sc_free(frames);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char *text = malloc(size + 1), *words[WORDS_MAX + 2] = {(char[]){"segcast"}};
    const char *environment[WORDS_MAX + 1] = {NULL};
    int argc = 1, variables = 0;
    SC_OWN(sc_options_clear) sc_options options = {0};
    const sc_command *command;

    FUZZ_CHECK(text);
    memcpy(text, data, size);
    text[size - (size && data[size - 1] == '\n')] = '\0';
    text[size] = '\0';
    for (char *word = text, *end; word && argc + variables < WORDS_MAX; word = end) {
        end = strchr(word, '\n');
        if (end)
            *end++ = '\0';
        if (!strncmp(word, "SEGCAST_", 8))
            environment[variables++] = word;
        else
            words[argc++] = word;
    }
    command = argc > 1 ? sc_command_find(sc_commands, words[1]) : NULL;
    optind = 0; /* getopt_long begins anew */
    if (command && sc_options_parse(&fuzz_ctx, command, argc, words, &options) == SC_OK)
        use(&options, environment);
    free(text);
    return 0;
}
