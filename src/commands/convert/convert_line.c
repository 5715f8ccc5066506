/* SPDX-License-Identifier: BSD-3-Clause */
/* The centre line of a vessel. */
#include "commands.h"

#include <stdlib.h>
#include <strings.h>

/* What the command line asks for. Owns tissues. */
typedef struct wish {
    sc_tissue_list tissues; /* --tissue, taken apart */
    sc_vec3 through[2];
    sc_line_wish line;
} wish;

static void clear_wish(wish *w)
{
    sc_tissue_list_clear(&w->tissues);
}

/* Read three numbers with commas between them. */
static sc_status read_point(const sc_ctx *ctx, const char *option, const char *text, sc_vec3 *out)
{
    double at[3];
    const char *rest = text;

    for (int i = 0; i < 3; i++) {
        char *end;

        at[i] = strtod(rest, &end);
        if (end == rest || *end != (i < 2 ? ',' : '\0') || !(fabs(at[i]) <= 1e12))
            return sc_fail(ctx, SC_ERR_USAGE,
                           "%s is \"%s\", expected a point in RAS mm, for example 12.5,-3,40",
                           option, text);
        rest = end + 1;
    }
    *out = (sc_vec3){at[0], at[1], at[2]};
    return SC_OK;
}

/* Read the options of the command. Caller owns *w also after an error. */
static sc_status read_wish(const sc_app *app, wish *w)
{
    const sc_options *o = &app->options;

    SC_PASS(sc_tissue_list_read(app->ctx, o->convert.tissue, &w->tissues));
    w->line.patterns = w->tissues.names;
    w->line.pattern_count = w->tissues.count;
    if (o->convert.end && !o->convert.begin)
        return sc_fail(app->ctx, SC_ERR_USAGE,
                       "--end needs --begin: a line that ends at a point has to begin at one");
    w->line.middles = o->convert.middles;
    if (o->convert.middles && o->convert.begin)
        return sc_fail(app->ctx, SC_ERR_USAGE,
                       "--middles and --begin both say where the line leads; give one of them");
    if (o->convert.middles && w->line.pattern_count < 2)
        return sc_fail(app->ctx, SC_ERR_USAGE,
                       "--middles needs two tissues or more: --tissue A,B leads from the middle of "
                       "A to that of B");
    if (o->convert.begin)
        SC_PASS(read_point(app->ctx, "--begin", o->convert.begin,
                           &w->through[w->line.through_count++]));
    if (o->convert.end)
        SC_PASS(
            read_point(app->ctx, "--end", o->convert.end, &w->through[w->line.through_count++]));
    w->line.through = w->through;
    return SC_OK;
}

/* Choose the format by --to, or by the ending of the file: JSON, or else CSV. */
static sc_status choose_format(const sc_app *app, bool *as_json)
{
    const char *to = app->options.convert.to, *dot = strrchr(app->options.output, '.');

    if (to && strcasecmp(to, "csv") && strcasecmp(to, "json"))
        return sc_fail(app->ctx, SC_ERR_USAGE,
                       "--to is \"%s\", expected csv or json for a centre line", to);
    *as_json = to ? !strcasecmp(to, "json") : dot && !strcasecmp(dot, ".json");
    return SC_OK;
}

/* Append a number in mm, as the resolved job has them. */
static sc_status add_number(const sc_ctx *ctx, double value, const char *after, sc_text *text)
{
    return sc_text_add(ctx, text, "%.10g%s", value == 0 ? 0 : value, after);
}

/* Append the line as CSV, or as JSON. */
static sc_status print_line(const sc_ctx *ctx, const sc_centerline *line, bool json, sc_text *text)
{
    if (json)
        SC_PASS(
            sc_text_add(ctx, text,
                        "{\"schema\": \"segcast-path-1\", \"length_mm\": %.10g, \"pieces\": %d,\n"
                        " \"columns\": [\"x_mm\", \"y_mm\", \"z_mm\", \"radius_mm\"],\n"
                        " \"points\": [\n",
                        line->length_mm, line->parts));
    else
        SC_PASS(sc_text_add(ctx, text, "x_mm,y_mm,z_mm,radius_mm\n"));
    for (size_t i = 0; i < line->count; i++) {
        const sc_centerline_point *p = &line->points[i];
        const char *end = !json ? "\n" : i + 1 < line->count ? "],\n" : "]\n";

        if (json)
            SC_PASS(sc_text_add(ctx, text, "  ["));
        SC_PASS(add_number(ctx, p->at_mm.x, json ? ", " : ",", text));
        SC_PASS(add_number(ctx, p->at_mm.y, json ? ", " : ",", text));
        SC_PASS(add_number(ctx, p->at_mm.z, json ? ", " : ",", text));
        SC_PASS(add_number(ctx, p->radius_mm, end, text));
    }
    return json ? sc_text_add(ctx, text, " ]\n}\n") : SC_OK;
}

sc_status sc_convert_line(sc_app *app)
{
    const char *path = app->options.output;
    SC_OWN(sc_session_clear) sc_session session = {0};
    SC_OWN(sc_input_clear)
    sc_input input = {.measure = true}; /* so that a prepared file may lack tissues */
    SC_OWN(sc_centerline_clear) sc_centerline line = {0};
    SC_OWN(sc_volume_clear) sc_volume read = {0};
    sc_volume volume;
    SC_OWN(sc_text_clear) sc_text text = {0};
    sc_ctx quieter = *app->ctx; /* how a file was prepared does not matter here */
    sc_app mapping = *app;
    bool usable, as_json = false;
    SC_OWN(clear_wish) wish w = {.line = {.clearance = SC_CLEARANCE, .where = ""}};

    quieter.level = SC_LOG_ERROR;
    mapping.ctx = &quieter;
    SC_PASS(read_wish(app, &w));
    SC_PASS(choose_format(app, &as_json));
    SC_PASS(sc_options_set_text(app->ctx, &app->options, "volume", app->options.input));
    SC_PASS(sc_session_job(app, NULL, &session));
    if (strcmp(path, "-"))
        SC_PASS(sc_check_output(app, &session.job, path, true));
    sc_stage_begin(app->ctx, "reading", 0, 0);
    if (sc_is_prepared_file(session.job.volume.path)) {
        SC_PASS(sc_input_map(&mapping, &session.job, &input, &usable));
        SC_PASS(sc_check_line_voxels(app->ctx, session.job.volume.path, &input.volume, &w.line));
        volume = sc_volume_of_prepared(&input.volume);
    } else {
        SC_PASS(sc_input_voxels(app, &session.job, &input, &read));
        volume = read;
    }
    SC_PASS(sc_find_line(app, &volume, &w.line, &line));
    SC_PASS(print_line(app->ctx, &line, as_json, &text));
    sc_display_end_stage(app);
    return sc_write_text(app, &text, path);
}
