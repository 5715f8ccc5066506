/* SPDX-License-Identifier: BSD-3-Clause */
/* The synthetic heart as a file, or as one for each phase of its beat. */
#include "commands.h"

#include "segcast/phantom.h"

#define ENDING ".nrrd"
/* With this one, all phases of a beat are in one file. */
#define SERIES_ENDING ".seq.nrrd"
/* How long the beat takes whose phases are in one file. */
#define BEAT_S 1.0

/* Write the name of the file of phase @p phase of @p count to @p text: see sc_phase_path. With a
 * count of 0 it is @p path itself. */
static sc_status phase_path(const sc_ctx *ctx, const char *path, int phase, int count,
                            sc_text *text)
{
    return count == 0 ? sc_text_add(ctx, text, "%s", path)
                      : sc_phase_path(ctx, path, ENDING, phase, count, text);
}

/* Check that the files of all phases can be written, before any is made. */
static sc_status check_outputs(const sc_app *app, const char *path, int count)
{
    for (int phase = 0; phase == 0 || phase < count; phase++) {
        SC_OWN(sc_text_clear) sc_text name = {0};

        SC_PASS(phase_path(app->ctx, path, phase, count, &name));
        SC_PASS(sc_check_output(app, NULL, name.data, true));
    }
    return SC_OK;
}

/* Write the synthetic CT image of a heart. */
static sc_status write_image(const sc_app *app, const sc_phantom *phantom, const int size[3],
                             const char *path)
{
    sc_grey grey = {.size = {size[0], size[1], size[2]}};
    SC_OWN(sc_free_at) void *codes = NULL;

    SC_PASS(sc_alloc(app->ctx, sc_grey_bytes(&grey), 1, &codes));
    grey.codes = codes;
    SC_PASS(sc_phantom_grey(app->ctx, phantom, app->threads, &grey));
    return sc_grey_save_nrrd(app->ctx, &grey, path, app->options.overwrite);
}

/* Write the labels of a heart. */
static sc_status write_labels(const sc_app *app, const sc_phantom *phantom, const int size[3],
                              const char *path)
{
    SC_OWN(sc_volume_clear) sc_volume volume = {0};

    SC_PASS(sc_phantom_volume(app->ctx, phantom, size, app->threads, &volume));
    return sc_volume_save_nrrd(app->ctx, &volume, path, app->options.overwrite);
}

/* Make the heart at phase @p phase of @p count, of @p size voxels, and write it. */
static sc_status write_phase(sc_app *app, const char *path, const int size[3], int phase, int count)
{
    SC_OWN(sc_phantom_free_at) sc_phantom *phantom = NULL;
    SC_OWN(sc_text_clear) sc_text name = {0};

    SC_PASS(phase_path(app->ctx, path, phase, count, &name));
    SC_PASS(sc_phantom_new_beating(app->ctx, count ? (double)phase / count : 0, &phantom));
    SC_PASS((app->options.convert.ct ? write_image : write_labels)(app, phantom, size, name.data));
    sc_display_end_stage(app);
    sc_print_made(name.data);
    return SC_OK;
}

/* What the phases of a beat are made from. */
typedef struct beat {
    const sc_app *app;
    const int *size;
    int count;
} beat;

/* Make the heart at a phase; sc_volume_series.make of a beat. */
static sc_status make_phase(void *user, int phase, sc_volume *out)
{
    const beat *b = user;
    SC_OWN(sc_phantom_free_at) sc_phantom *phantom = NULL;

    SC_PASS(sc_phantom_new_beating(b->app->ctx, (double)phase / b->count, &phantom));
    return sc_phantom_volume(b->app->ctx, phantom, b->size, b->app->threads, out);
}

/* Write all phases of a beat to one file. */
static sc_status write_series(sc_app *app, const char *path, const int size[3], int count)
{
    beat b = {app, size, count};
    const sc_volume_series series = {count, BEAT_S / count, make_phase, &b};

    if (app->options.convert.ct)
        return sc_fail(
            app->ctx, SC_ERR_USAGE,
            "--ct: an image holds one volume, expected another name than %s, such as ct" ENDING
            " for a file for each phase",
            path);
    SC_PASS(sc_volume_save_series_nrrd(app->ctx, &series, path, app->options.overwrite));
    sc_display_end_stage(app);
    sc_print_made(path);
    sc_info(app->ctx,
            "it holds the phases of a beat: a job with volume: %s and cine: {} films them", path);
    return SC_OK;
}

sc_status sc_convert_phantom(sc_app *app)
{
    const char *path = app->options.output;
    const size_t length = strlen(path), ending = strlen(SERIES_ENDING);
    const bool in_one = app->options.convert.beating > 1 && length > ending &&
                        !strcmp(path + length - ending, SERIES_ENDING);
    const int phases = app->options.convert.beating, count = in_one ? 0 : phases;
    int size[3];

    SC_PASS(sc_phantom_size(app->ctx, "the argument", app->options.input, size));
    SC_PASS(sc_check_ending(app->ctx, path, ENDING, "a volume in the format NRRD"));
    SC_PASS(check_outputs(app, path, count));
    for (int i = 0; i < 3 && app->options.convert.ct; i++) {
        if (size[i] < 2 || size[i] > 4096)
            return sc_fail(app->ctx, SC_ERR_USAGE, "%s: expected 2 to 4096 voxels along each axis",
                           app->options.input);
    }
    if (size[0] > 0 && size[1] > 0 && size[2] > 0)
        SC_PASS(sc_volume_memory_check(app->ctx, app->options.input, size, 0));
    if (in_one)
        return write_series(app, path, size, phases);
    for (int phase = 0; phase == 0 || phase < count; phase++)
        SC_PASS(write_phase(app, path, size, phase, count));
    if (count > 1 && !app->options.convert.ct)
        sc_info(app->ctx,
                "these are the phases of a beat: a job with volume: %.*s-*" ENDING
                " and cine: {bpm: 60} films them",
                (int)(strlen(path) - strlen(ENDING)), path);
    return SC_OK;
}
