/* SPDX-License-Identifier: BSD-3-Clause */
/* segcast phantom: the synthetic heart as a file. */
#include "app.h"

#include "segcast/phantom.h"

sc_status sc_cmd_phantom(sc_app *app)
{
    const char *path = app->options.output ? app->options.output : "phantom.nrrd";
    int size[3] = {SC_PHANTOM_WIDTH, SC_PHANTOM_DEPTH, SC_PHANTOM_HEIGHT}, used = 0;
    sc_phantom *phantom = NULL;
    sc_volume volume = {0};
    sc_status status;

    if (app->options.size &&
        (sscanf(app->options.size, "%dx%dx%d%n", &size[0], &size[1], &size[2], &used) != 3 ||
         app->options.size[used]))
        return sc_fail(app->ctx, SC_ERR_USAGE, "--size is \"%s\", expected for example 128x96x128",
                       app->options.size);
    SC_TRY(sc_check_ending(app->ctx, path, ".nrrd", "a volume in the format NRRD"));
    SC_TRY(sc_check_output(app, NULL, path, true));
    if (size[0] > 0 && size[1] > 0 && size[2] > 0)
        SC_TRY(sc_volume_memory_check(app->ctx, "--size", size, 0));
    SC_TRY(sc_phantom_new(app->ctx, &phantom));
    SC_TRY(sc_phantom_volume(app->ctx, phantom, size, app->threads, &volume));
    SC_TRY(sc_volume_save_nrrd(app->ctx, &volume, path, app->options.overwrite));
    sc_display_end_stage(app);
    sc_print_made(path);
out:
    sc_volume_clear(&volume);
    sc_phantom_free(phantom);
    return status;
}
