/* SPDX-License-Identifier: BSD-3-Clause */
/* The surfaces of tissues as a mesh, for other programs and for printing. */
#include "commands.h"
#include "segcast/mesh.h"

#include <math.h>
#include <stdlib.h>

/* Set wanted[id] for the tissues that a name of --tissue means. @param wanted [label_count]. */
static sc_status add_named(const sc_ctx *ctx, const sc_prepared *v, const char *name, bool *wanted)
{
    const sc_pattern pattern = sc_pattern_of(name);
    const sc_match best = sc_pattern_match(v->labels, v->label_count, &pattern);

    SC_PASS(sc_pattern_check(ctx, v, name, ""));
    for (int id = 1; id < v->label_count && best != SC_MATCH_NONE; id++) {
        if (sc_label_match(&v->labels[id], &pattern) != best)
            continue;
        if (v->how.hidden[id])
            return sc_fail(ctx, SC_ERR_DATA,
                           "--tissue %s: \"%s\" (label %lld) is hidden, by the label table or as "
                           "the file was prepared, and has no surface; show it by --set "
                           "'tissues={\"%lld\": {visible: true}}'",
                           name, v->labels[id].name, (long long)v->labels[id].value,
                           (long long)v->labels[id].value);
        wanted[id] = true;
    }
    return SC_OK;
}

/* Find the tissues that are to be written: those of --tissue, or else all that are shown. @param
 * wanted [label_count], zeroed. */
static sc_status find_wanted(const sc_app *app, const sc_prepared *v, const sc_tissue *looks,
                             bool *wanted)
{
    SC_OWN(sc_tissue_list_clear) sc_tissue_list list = {.count = 0};

    if (app->options.convert.tissue)
        SC_PASS(sc_tissue_list_read(app->ctx, app->options.convert.tissue, &list));
    for (size_t i = 0; i < list.count; i++)
        SC_PASS(add_named(app->ctx, v, list.names[i], wanted));
    for (int id = 1; id < v->label_count && !app->options.convert.tissue; id++)
        wanted[id] = looks[id].visible && !v->how.hidden[id];
    return SC_OK;
}

/* Refuse to write several tissues where only one has room. */
static sc_status check_format(const sc_app *app, const sc_prepared *v, sc_mesh_format format,
                              const bool *wanted)
{
    int count = 0;

    for (int id = 1; id < v->label_count; id++)
        count += wanted[id] ? 1 : 0;
    if (format != SC_MESH_STL || count <= 1)
        return SC_OK;
    return sc_fail(app->ctx, SC_ERR_USAGE,
                   "%s: an STL file holds one surface, without name and colour, but %d tissues are "
                   "to be written; choose one by --tissue NAME, or write .3mf, .glb or .ply",
                   app->options.output, count);
}

/* Set has[id] for the tissues that have triangles. @param has [label_count], zeroed. */
static void find_present(const sc_mesh *mesh, bool *has)
{
    for (size_t i = 0; i < mesh->triangle_count; i++)
        has[mesh->sides[i][0]] = has[mesh->sides[i][1]] = true;
}

/* Tell that a tissue has no triangle, because its few voxels are drawn as those around. That is an
 * error if it was asked for by name. @param voxels of the tissue. */
static sc_status tell_absent(const sc_app *app, const sc_mesh_tissue *tissue, uint64_t voxels)
{
    SC_OWN(sc_text_clear) sc_text why = {0};

    SC_PASS(sc_text_add(app->ctx, &why,
                        "\"%s\" (label %lld, %llu voxels) has no surface, as it is too small or "
                        "too thin for one (--set render.smooth=0 gives it that of its voxels)",
                        tissue->name, (long long)tissue->label, (unsigned long long)voxels));
    if (app->options.convert.tissue)
        return sc_fail(app->ctx, SC_ERR_DATA, "%s", why.data);
    sc_warn(app->ctx, "%s; it is left out", why.data);
    return SC_OK;
}

/* Describe the tissues for the writer: those that are wanted and have triangles. @param out
 * [label_count], zeroed. */
static sc_status describe(const sc_app *app, const sc_prepared *v, const sc_tissue *looks,
                          const bool *wanted, const sc_mesh *mesh, sc_mesh_tissue *out)
{
    SC_OWN(sc_free_at) sc_srgb_table *levels = NULL;
    SC_OWN(sc_free_at) bool *has = NULL;
    int count = 0;

    SC_PASS(SC_ALLOC(app->ctx, 1, &levels));
    SC_PASS(SC_ZALLOC(app->ctx, (size_t)v->label_count, &has));
    sc_srgb_table_init(levels);
    find_present(mesh, has);
    for (int id = 1; id < v->label_count; id++) {
        const sc_label *label = &v->labels[id];

        out[id].label = label->value;
        out[id].wanted = wanted[id] && has[id];
        if (label->name[0])
            snprintf(out[id].name, sizeof out[id].name, "%s", label->name);
        else
            snprintf(out[id].name, sizeof out[id].name, "label %lld", (long long)label->value);
        for (int i = 0; i < 3; i++) {
            out[id].rgb_linear[i] = looks[id].rgb_linear[i];
            out[id].rgb[i] = sc_srgb_level(levels, looks[id].rgb_linear[i]);
        }
        count += out[id].wanted ? 1 : 0;
        if (wanted[id] && !has[id])
            SC_PASS(tell_absent(app, &out[id], v->stats[id].voxels));
    }
    if (!count)
        return sc_fail(app->ctx, SC_ERR_DATA,
                       "%s: no tissue has a surface, so that there is no mesh to write",
                       app->options.input);
    return SC_OK;
}

/* Simplify the mesh if the command line says by how much. */
static sc_status simplify(const sc_app *app, sc_mesh *mesh)
{
    const char *text = app->options.convert.simplify;
    const size_t before = mesh->triangle_count;
    char *end = NULL;
    const double error_mm = text ? strtod(text, &end) : 0;

    if (!text)
        return SC_OK;
    if (end == text || *end || !(error_mm > 0 && error_mm < HUGE_VAL))
        return sc_fail(app->ctx, SC_ERR_USAGE,
                       "--simplify is \"%s\", expected a length in mm above 0, such as 0.1", text);
    SC_PASS(sc_mesh_simplify(app->ctx, mesh, error_mm));
    sc_info(app->ctx, "simplified by up to %s mm: %zu of %zu triangles are left", text,
            mesh->triangle_count, before);
    return SC_OK;
}

/* Make the mesh and write it. @param looks [label_count] of the tissues. */
static sc_status write_mesh(const sc_app *app, const sc_prepared *v, const sc_tissue *looks,
                            sc_mesh_format format)
{
    const size_t labels = (size_t)v->label_count;
    const double wall_s = sc_wall_s();
    SC_OWN(sc_mesh_clear) sc_mesh mesh = {.vertex_count = 0};
    SC_OWN(sc_free_at) bool *wanted = NULL;
    SC_OWN(sc_free_at) sc_mesh_tissue *tissues = NULL;
    SC_OWN(sc_outfile_discard) sc_outfile file = {0};

    SC_PASS(SC_ZALLOC(app->ctx, labels, &wanted));
    SC_PASS(SC_ZALLOC(app->ctx, labels, &tissues));
    SC_PASS(find_wanted(app, v, looks, wanted));
    SC_PASS(check_format(app, v, format, wanted));
    SC_PASS(sc_mesh_build(app->ctx, v, wanted, app->threads, &mesh));
    SC_PASS(simplify(app, &mesh));
    SC_PASS(describe(app, v, looks, wanted, &mesh, tissues));
    SC_PASS(sc_outfile_open(app->ctx, app->options.output, app->options.overwrite, &file));
    SC_PASS(sc_mesh_write(app->ctx, &mesh, tissues, v->label_count, format, app->options.output,
                          file.stream));
    SC_PASS(sc_outfile_commit(app->ctx, &file));
    sc_info(app->ctx, "%s: %zu triangles, made and written in %.2f s", app->options.output,
            mesh.triangle_count, sc_wall_s() - wall_s);
    return SC_OK;
}

sc_status sc_convert_mesh(sc_app *app)
{
    const char *path = app->options.output;
    SC_OWN(sc_session_clear) sc_session session = {0};
    SC_OWN(sc_input_clear) sc_input input = {0};
    SC_OWN(sc_free_at) sc_tissue *looks = NULL;
    sc_mesh_format format;

    if (!sc_mesh_format_of(path, &format))
        return sc_fail(app->ctx, SC_ERR_INTERNAL, "%s: is no mesh", path);
    SC_PASS(sc_options_set_text(app->ctx, &app->options, "volume", app->options.input));
    SC_PASS(sc_session_job(app, NULL, &session));
    SC_PASS(sc_check_output(app, &session.job, path, true));
    SC_PASS(sc_input_load(app, &session.job, &session.times, &input));
    SC_PASS(SC_ZALLOC(app->ctx, (size_t)input.volume.label_count, &looks));
    sc_transfer_resolve(&input.volume, session.job.tissues.rules, session.job.tissues.rule_count,
                        sc_job_opacity_rule(&session.job), looks);
    SC_PASS(write_mesh(app, &input.volume, looks, format));
    sc_display_end_stage(app);
    sc_print_made(path);
    return SC_OK;
}
