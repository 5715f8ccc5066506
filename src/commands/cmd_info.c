/* SPDX-License-Identifier: BSD-3-Clause */
/* segcast info: what is in a volume. */
#include "commands.h"
#include "label_report.h"
#include "segcast/resample.h"

typedef struct info {
    const sc_prepared *volume;
    const sc_tissue *tissues;
    const sc_label_report *report; /* on its label table */
    const sc_overlap_list *overlaps;
    double spacing_mm[3], voxel_mm3;
    sc_length_unit unit; /* lengths are printed in this unit */
    sc_drawn_grid drawn; /* how its voxels were drawn */
    char axes[4];        /* patient direction of each voxel axis, e.g. "LPS"; "?" if unknown */
    int phases;          /* volumes in the file */
    int phase;           /* which of them this is, from 0 */
    double step_s;       /* from one phase to the next; 0: not known */
} info;

/* @return the patient direction that is nearest to @p d: R, L, A, P, S or I. */
static char axis_letter(sc_vec3 d)
{
    const double x = fabs(d.x), y = fabs(d.y), z = fabs(d.z);

    if (x >= y && x >= z)
        return d.x > 0 ? 'R' : 'L';
    if (y >= z)
        return d.y > 0 ? 'A' : 'P';
    return d.z > 0 ? 'S' : 'I';
}

/* Collect what is printed. The result borrows both arguments. */
static info gather(const sc_prepared *volume, const sc_tissue *tissues)
{
    info out = {.volume = volume,
                .tissues = tissues,
                .voxel_mm3 = fabs(sc_affine_determinant(&volume->to_ras_mm))};

    for (int i = 0; i < 3; i++) {
        const sc_vec3 column = sc_affine_column(&volume->to_ras_mm, i);

        out.spacing_mm[i] = sc_vec3_length(column);
        out.axes[i] = volume->oriented ? axis_letter(column) : '?';
    }
    out.unit =
        sc_length_unit_for(fmin(out.spacing_mm[0], fmin(out.spacing_mm[1], out.spacing_mm[2])));
    return out;
}

static json_t *label_json(const info *in, int id)
{
    const sc_label *label = &in->volume->labels[id];
    const sc_label_stats *stats = &in->volume->stats[id];

    return json_pack("{s:I, s:s, s:[i,i,i], s:b, s:f, s:I, s:I, s:f, s:f, s:f}", "value",
                     (json_int_t)label->value, "name", label->name, "color", label->rgb[0],
                     label->rgb[1], label->rgb[2], "visible", in->tissues[id].visible, "opacity",
                     in->tissues[id].opacity, "voxels", (json_int_t)stats->voxels,
                     "boundary_voxels", (json_int_t)stats->boundary_voxels, "volume_mm3",
                     (double)stats->voxels * in->voxel_mm3, "thickness_mm", stats->thickness_mm,
                     "surface_mm2", stats->surface_mm2);
}

/* @return the pairs of tissues that overlap as an array of JSON, or NULL without memory. */
static json_t *overlaps_json(const sc_overlap_list *list)
{
    json_t *array = json_array();

    for (size_t i = 0; i < list->count; i++) {
        const sc_overlap_pair *pair = &list->pairs[i];

        array = sc_json_with(array, json_pack("{s:s, s:s, s:I}", "shown",
                                              list->tissues.rows[pair->winner].name, "covered",
                                              list->tissues.rows[pair->loser].name, "voxels",
                                              (json_int_t)pair->voxels));
    }
    return array;
}

/* Print the object that `info --json` promises to standard output. @return SC_ERR_MEMORY:
 * nothing is printed then, rather than an object that lacks a label. */
static sc_status print_json(const sc_ctx *ctx, const info *in)
{
    const sc_prepared *v = in->volume;
    json_t *labels = json_array(), *matrix = json_array(), *json;

    for (int row = 0; row < 3; row++) {
        const double *m = v->to_ras_mm.m[row];

        matrix = sc_json_with(matrix, json_pack("[f,f,f,f]", m[0], m[1], m[2], m[3]));
    }
    for (int id = 0; id < v->label_count; id++)
        labels = sc_json_with(labels, label_json(in, id));
    json = json_pack(
        "{s:s, s:i, s:i, s:f, s:[i,i,i], s:[f,f,f], s:[f,f,f], s:[i,i,i], s:s, s:b, s:o, s:I, s:o, "
        "s:o, s:o}",
        "schema", "segcast-info-1", "phases", in->phases, "phase", in->phase, "phase_step_s",
        in->step_s, "size", v->size[0], v->size[1], v->size[2], "spacing_mm", in->spacing_mm[0],
        in->spacing_mm[1], in->spacing_mm[2], "drawn_mm", in->drawn.drawn_mm[0],
        in->drawn.drawn_mm[1], in->drawn.drawn_mm[2], "moved_slices", in->drawn.moved[0],
        in->drawn.moved[1], in->drawn.moved[2], "axes", in->axes, "oriented", v->oriented,
        "to_ras_mm", matrix, "boundary_voxels", (json_int_t)v->boundary.voxel_count, "labels",
        labels, "label_table", sc_label_report_json(in->report), "overlaps",
        overlaps_json(in->overlaps));
    return sc_print_json(ctx, json, JSON_INDENT(1) | JSON_REAL_PRECISION(17), "labels");
}

/* Print size, axes and matrix, in lines of the text output. */
static void print_geometry(const info *in)
{
    const sc_prepared *v = in->volume;
    const double mm = in->unit.mm;

    printf("size      %d x %d x %d voxels of %.4g x %.4g x %.4g %s\n", v->size[0], v->size[1],
           v->size[2], in->spacing_mm[0] / mm, in->spacing_mm[1] / mm, in->spacing_mm[2] / mm,
           in->unit.name);
    printf("axes      %s%s\n", in->axes,
           v->oriented ? "" : "  (the file does not say; taken as RAS)");
    for (int row = 0; row < 3; row++) {
        double m[4];

        for (int i = 0; i < 4; i++)
            m[i] = sc_no_negative_zero(v->to_ras_mm.m[row][i] / mm, 4);
        printf("%s %s%10.4f %10.4f %10.4f %12.4f\n", row ? "      " : "to RAS",
               row ? "  " : in->unit.name, m[0], m[1], m[2], m[3]);
    }
}

/* Print how many volumes the file holds, if there are several. */
static void print_phases(const info *in)
{
    if (in->phases == 1)
        return;
    printf("phases    %d", in->phases);
    if (in->step_s > 0)
        printf(", %.4g s apart: %.4g beats a minute", in->step_s, 60 / (in->step_s * in->phases));
    printf("; this is phase %d (--set volume.phase=N: another)\n", in->phase);
}

/* Print which tissues overlap, if any do. */
static void print_overlaps(const sc_overlap_list *list)
{
    enum { PAIRS_SHOWN = 12 };

    if (!list->count)
        return;
    printf("\n%10s  %11s  tissues that overlap\n", "", "voxels");
    for (size_t i = 0; i < list->count && i < PAIRS_SHOWN; i++) {
        const sc_overlap_pair *pair = &list->pairs[i];

        printf("%10s  %11llu  shown as ", "", (unsigned long long)pair->voxels);
        sc_print(stdout, list->tissues.rows[pair->winner].name);
        printf(", and not as ");
        sc_print(stdout, list->tissues.rows[pair->loser].name);
        printf("\n");
    }
    if (list->count > PAIRS_SHOWN)
        printf("%10s  and %zu more pairs (--json has all)\n", "", list->count - PAIRS_SHOWN);
}

/* Print geometry and a table of labels for people to standard output. */
static void print_text(const info *in)
{
    const sc_prepared *v = in->volume;
    const double voxels = (double)v->size[0] * v->size[1] * v->size[2];
    const bool in_mm = in->unit.mm == 1; /* if so, areas are printed in square centimetres */
    const double area_mm2 = in_mm ? 100 : in->unit.mm * in->unit.mm;

    print_geometry(in);
    print_phases(in);
    if (sc_is_resampled(&in->drawn)) {
        char text[320];

        sc_drawn_grid_text(&in->drawn, text, sizeof text);
        printf("drawing   %s\n", text);
    }
    printf("labels    %d, and background\n", v->label_count - 1);
    printf("boundary  %llu voxels, %.2f %% of all\n\n", (unsigned long long)v->boundary.voxel_count,
           100 * (double)v->boundary.voxel_count / voxels);
    printf("%10s  %11s %9s %7s %s %6s %s2 %8s  %s\n", "label", "voxels", "boundary", "thick.",
           in->unit.name, "area", in_mm ? "cm" : in->unit.name, "opacity", "name");
    for (int id = 0; id < v->label_count; id++) {
        const sc_label_stats *s = &v->stats[id];

        printf("%10lld  %11llu", (long long)v->labels[id].value, (unsigned long long)s->voxels);
        if (id == 0) {
            printf("%43sbackground\n", "");
            continue;
        }
        printf(" %7.1f %% %10.2f %9.1f %8.2f  ",
               s->voxels ? 100.0 * (double)s->boundary_voxels / (double)s->voxels : 0,
               s->thickness_mm / in->unit.mm, s->surface_mm2 / area_mm2, in->tissues[id].opacity);
        sc_print(stdout, v->labels[id].name);
        printf("%s\n", in->tissues[id].visible ? "" : "  (hidden)");
    }
    print_overlaps(in->overlaps);
    if (in->report->owned)
        printf("\n");
    sc_label_report_print(in->report, stdout);
}

/* Of a file of several phases describe the first, unless another is asked for. */
static sc_status choose_phase(sc_app *app, info *in)
{
    in->phases = 1;
    SC_PASS(sc_volume_phases(app->ctx, app->options.input, &in->phases, &in->step_s));
    if (in->phases > 1)
        return sc_options_default(app->ctx, &app->options, "volume.phase", "0");
    return SC_OK;
}

sc_status sc_cmd_info(sc_app *app)
{
    SC_OWN(sc_session_clear) sc_session session = {0};
    SC_OWN(sc_label_source_clear) sc_label_source source = {0};
    SC_OWN(sc_label_report_clear) sc_label_report report = {0};
    SC_OWN(sc_overlap_list_clear) sc_overlap_list overlaps = {0};
    info in, file = {0};
    const sc_prepared *volume;
    sc_volume view;
    sc_status status;

    SC_TRY(sc_options_set_text(app->ctx, &app->options, "volume", app->options.input));
    SC_TRY(choose_phase(app, &file));
    SC_TRY(sc_session_job(app, NULL, &session));
    session.measure = true;
    app->label_source = &source;
    app->overlaps = &overlaps;
    SC_TRY(sc_session_load(app, &session));
    SC_TRY(sc_session_panels(app, &session));
    SC_TRY(sc_session_tissues(app, &session));
    volume = sc_session_view(&session);
    SC_TRY(
        sc_label_report_make(app->ctx, &source, volume, !session.job.volume.tissue_count, &report));
    in = gather(volume, session.panels[0].looks.tissues);
    in.report = &report;
    in.overlaps = &overlaps;
    in.phases = file.phases;
    in.step_s = file.step_s;
    in.phase = session.job.volume.phase ? session.job.volume.phase - 1 : 0;
    view = sc_volume_of_prepared(volume);
    sc_stage_begin(app->ctx, "measuring the grid", 0, 0);
    SC_TRY(sc_find_drawn_grid(app->ctx, &view, app->threads, &in.drawn));
    sc_display_end_stage(app);
    if (app->options.json)
        status = print_json(app->ctx, &in);
    else
        print_text(&in);
out:
    app->label_source = NULL;
    app->overlaps = NULL;
    return status;
}
