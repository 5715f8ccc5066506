/* SPDX-License-Identifier: BSD-3-Clause */
/* segcast convert: what is written is told by the ending of the file, and by the options. */
#include "commands.h"
#include "segcast/mesh.h"

#include <strings.h>

/* What segcast convert can write. */
typedef enum target {
    TARGET_TABLE,
    TARGET_LINE,
    TARGET_MESH,
    TARGET_PREPARED,
    TARGET_PHANTOM
} target;

/* Is the argument a job file, judged by the end of its name? */
static bool is_job(const char *path)
{
    const char *dot = strrchr(path, '.');

    return dot && (!strcmp(dot, ".yaml") || !strcmp(dot, ".yml"));
}

/* @return what the command line asks for. */
static target find_target(const sc_options *o)
{
    const char *dot = strrchr(o->output, '.');
    sc_mesh_format mesh;

    if (sc_mesh_format_of(o->output, &mesh))
        return TARGET_MESH;
    if (o->convert.tissue || o->convert.begin || o->convert.end || o->convert.middles)
        return TARGET_LINE;
    if (dot && !strcasecmp(dot, ".segc"))
        return TARGET_PREPARED;
    if (o->convert.ct || o->convert.beating || (dot && !strcasecmp(dot, ".nrrd") && !o->convert.to))
        return TARGET_PHANTOM;
    return TARGET_TABLE;
}

/* Refuse settings of a job, unless they are of the key @p allowed. */
static sc_status refuse_settings(const sc_app *app, const char *allowed)
{
    const sc_options *o = &app->options;

    for (size_t i = 0; i < o->settings.count; i++) {
        if (!allowed || strcmp(o->settings.all[i].path, allowed))
            return sc_fail(app->ctx, SC_ERR_USAGE, "%s: does not change what is written to %s",
                           o->settings.all[i].origin, o->output);
    }
    return SC_OK;
}

/* Refuse what the target does not take. */
static sc_status check_use(const sc_app *app, target wanted)
{
    const sc_options *o = &app->options;

    if (wanted != TARGET_PREPARED && is_job(o->input))
        return sc_fail(app->ctx, SC_ERR_USAGE,
                       "%s: is a job file, of which only a prepared file (-o FILE.segc) is made; "
                       "expected a volume or a label table",
                       o->input);
    if (wanted == TARGET_MESH && (o->convert.begin || o->convert.end || o->convert.middles))
        return sc_fail(app->ctx, SC_ERR_USAGE, "--%s is for a centre line, but %s is a mesh",
                       o->convert.begin ? "begin"
                       : o->convert.end ? "end"
                                        : "middles",
                       o->output);
    if (wanted != TARGET_MESH && o->convert.simplify)
        return sc_fail(app->ctx, SC_ERR_USAGE, "--simplify is for a mesh, but %s is none",
                       o->output);
    if (wanted != TARGET_TABLE && wanted != TARGET_LINE && o->convert.to)
        return sc_fail(app->ctx, SC_ERR_USAGE,
                       "--to names a format of label tables or centre lines, but %s is neither",
                       o->output);
    if (wanted != TARGET_PHANTOM && (o->convert.ct || o->convert.beating))
        return sc_fail(app->ctx, SC_ERR_USAGE, "--%s is for the phantom written as NRRD",
                       o->convert.ct ? "ct" : "beating");
    if (wanted == TARGET_PHANTOM && !sc_job_is_phantom(o->input))
        return sc_fail(app->ctx, SC_ERR_USAGE,
                       "%s: only the phantom is written as NRRD, and the input is %s; expected "
                       "phantom or for example phantom:128x96x128",
                       o->output, o->input);
    if (wanted == TARGET_PHANTOM)
        return refuse_settings(app, NULL);
    return wanted == TARGET_TABLE ? refuse_settings(app, "labels_format") : SC_OK;
}

sc_status sc_cmd_convert(sc_app *app)
{
    sc_options *o = &app->options;
    target wanted;

    if (!o->output)
        return sc_fail(app->ctx, SC_ERR_USAGE,
                       "no file to write: give one as -o FILE, whose ending tells what is written; "
                       "`segcast help convert` lists the endings");
    wanted = find_target(o);
    SC_PASS(check_use(app, wanted));
    if (wanted == TARGET_PREPARED)
        return sc_convert_prepared(app, is_job(o->input) ? o->input : NULL);
    SC_PASS(app->mistake);
    return wanted == TARGET_LINE      ? sc_convert_line(app)
           : wanted == TARGET_MESH    ? sc_convert_mesh(app)
           : wanted == TARGET_PHANTOM ? sc_convert_phantom(app)
                                      : sc_convert_table(app);
}
