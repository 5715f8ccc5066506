/* SPDX-License-Identifier: BSD-3-Clause */
/* The volume of a job: its path, and which part of it is read and drawn. Which tissues are kept and
 * merged is in job_volume_tissues.c. */
#include "key.h"
#include "segcast/job.h"

#include <math.h>

/* ---- parts of a volume ---- */

/* Read "visible", "visible+5mm" or "visible + 5 mm". @return whether it is one of them. */
static bool read_visible(char *text, double *margin_mm)
{
    static const char word[] = "visible";
    sc_yaml margin = {.kind = SC_YAML_SCALAR};
    const char *unit;

    *margin_mm = 0;
    if (strncmp(text, word, strlen(word)) != 0)
        return false;
    text += strlen(word);
    text += strspn(text, " ");
    if (!*text)
        return true;
    margin.text = text + 1 + strspn(text + 1, " ");
    return *text == '+' && *margin.text >= '0' && *margin.text <= '9' &&
           sc_parse_position(&margin, margin_mm, &unit) && *unit == 'm';
}

/* Read "[[x, y, z], [x, y, z]]", in mm. */
static sc_status read_corners(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                              sc_vec3 corners[2])
{
    sc_vec3 read[2];

    if (node->kind != SC_YAML_LIST || node->count != 2)
        return sc_wrong_type(ctx, node, key->type->expected);
    for (size_t i = 0; i < 2; i++) {
        const sc_yaml named = sc_yaml_item(node, i);

        if (named.kind != SC_YAML_LIST)
            return sc_wrong_type(ctx, node, key->type->expected);
        SC_PASS(key->type->read(ctx, key, &named, &read[i]));
    }
    memcpy(corners, read, sizeof read);
    return SC_OK;
}

/* ---- phase and box ---- */

/* Read which phase of a file is meant, counted from 0. */
static sc_status read_phase(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    SC_PASS(sc_type_int.read(ctx, key, node, value));
    ++*(int *)value;
    return SC_OK;
}

static sc_status write_phase(const sc_ctx *ctx, const sc_key *key, const void *value, sc_text *text)
{
    return sc_text_add(ctx, text, "%d", *(const int *)value - 1);
}

static const sc_value_type type_phase = {
    .name = "whole number",
    .expected = "a whole number, 0 for the first phase",
    .read = read_phase,
    .write = write_phase,
    .schema = "$int",
};

/* The range of the corners of a box. */
static const sc_key mm_key = {
    .name = "box", .type = &sc_type_point, .low = -1e6, .high = 1e6, .unit = "mm"};

/* Read two voxels along each axis. */
static sc_status read_voxels(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                             int box[3][2])
{
    double pair[2];

    for (size_t i = 0; i < 3; i++) {
        const sc_yaml named = sc_yaml_item(node, i);

        if (named.kind != SC_YAML_LIST)
            return sc_wrong_type(ctx, node, key->type->expected);
        SC_PASS(sc_read_numbers(ctx, key, &named, 2, pair));
        if (pair[0] != floor(pair[0]) || pair[1] != floor(pair[1]) || pair[0] >= pair[1])
            return sc_wrong_type(ctx, node, key->type->expected);
        box[i][0] = (int)pair[0];
        box[i][1] = (int)pair[1];
    }
    return SC_OK;
}

/* Read two voxels along each axis, or two corners in mm; or what is visible, alone or behind one of
 * these. */
static sc_status read_box(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    sc_job *job = value;
    const sc_yaml *last =
        node->kind == SC_YAML_LIST && node->count ? node->items[node->count - 1] : node;
    sc_yaml box = *node;

    job->volume.box = (sc_box){.visible = last->kind == SC_YAML_SCALAR};
    if (job->volume.box.visible && !read_visible(last->text, &job->volume.box.margin_mm))
        return sc_wrong_type(ctx, node, key->type->expected);
    if (last == node && job->volume.box.visible)
        return SC_OK;
    box.count -= job->volume.box.visible;
    if (box.kind != SC_YAML_LIST || (box.count != 2 && box.count != 3))
        return sc_wrong_type(ctx, node, key->type->expected);
    job->volume.box.kind = box.count == 2 ? SC_READ_MM : SC_READ_VOXELS;
    return box.count == 2 ? read_corners(ctx, &mm_key, &box, job->volume.box.corners)
                          : read_voxels(ctx, key, &box, job->volume.box.voxels);
}

static sc_status write_box(const sc_ctx *ctx, const sc_key *key, const void *value, sc_text *text)
{
    const sc_box *box = &((const sc_job *)value)->volume.box;
    const sc_vec3 *a = &box->corners[0], *b = &box->corners[1];
    const int(*v)[2] = box->voxels;

    if (box->kind == SC_READ_MM)
        SC_PASS(sc_text_add(ctx, text, "[[%.17g, %.17g, %.17g], [%.17g, %.17g, %.17g]", a->x, a->y,
                            a->z, b->x, b->y, b->z));
    if (box->kind == SC_READ_VOXELS)
        SC_PASS(sc_text_add(ctx, text, "[[%d, %d], [%d, %d], [%d, %d]", v[0][0], v[0][1], v[1][0],
                            v[1][1], v[2][0], v[2][1]));
    if (box->visible)
        SC_PASS(
            sc_text_add(ctx, text, "%svisible + %.17g mm", box->kind ? ", " : "", box->margin_mm));
    return sc_text_add(ctx, text, box->kind ? "]" : "");
}

#define VISIBLE "{type: string, pattern: '^visible *([+] *[0-9][0-9.e+-]* *mm)?$'}"
#define AXIS SC_SCHEMA_LIST("{type: integer, minimum: $low, maximum: $high}", 2)
#define CORNER SC_SCHEMA_LIST("{type: number, minimum: -1000000, maximum: 1000000}", 3)

static const sc_value_type type_box = {
    .name = "voxels, corners in mm, visible + mm",
    .expected =
        "visible, visible + 5 mm, two corners in RAS mm: [[x, y, z], [x, y, z]], or [[x0, x1], "
        "[y0, y1], [z0, z1]]: along each axis the first voxel, and the one behind the last",
    .read = read_box,
    .write = write_box,
    .schema = "{anyOf: [" VISIBLE ", {type: array, minItems: 2, maxItems: 4, items: {anyOf: [" AXIS
              ", " CORNER ", " VISIBLE "]}}]}",
};

/* ---- resample ---- */

/* One spacing for all axes, or three; or a number of voxels along each, such as 40x30x40. */
static sc_status read_resample(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                               void *value)
{
    const bool is_one = node->kind == SC_YAML_SCALAR;
    sc_job *job = value;
    double spacing_mm[3];

    job->given.volume_size = is_one && sc_parse_voxels(node->text, job->volume.size);
    if (job->given.volume_size)
        return SC_OK;
    if (!is_one && (node->kind != SC_YAML_LIST || node->count != 3))
        return sc_wrong_type(ctx, node, key->type->expected);
    for (int i = 0; i < 3; i++) {
        const char *unit;

        if (!sc_parse_position(is_one ? node : node->items[i], &spacing_mm[i], &unit) ||
            *unit == '%' || !(spacing_mm[i] >= key->low && spacing_mm[i] <= key->high))
            return sc_wrong_type(ctx, node, key->type->expected);
    }
    memcpy(job->volume.resample_mm, spacing_mm, sizeof spacing_mm);
    return SC_OK;
}

static sc_status write_resample(const sc_ctx *ctx, const sc_key *key, const void *value,
                                sc_text *text)
{
    const sc_job *job = value;
    const double *mm = job->volume.resample_mm;
    const int *size = job->volume.size;

    if (job->given.volume_size)
        return sc_text_add(ctx, text, "%dx%dx%d", size[0], size[1], size[2]);
    if (mm[0] == mm[1] && mm[1] == mm[2])
        return sc_text_add(ctx, text, "%.17g mm", mm[0]);
    return sc_text_add(ctx, text, "[%.17g, %.17g, %.17g]", mm[0], mm[1], mm[2]);
}

static const sc_value_type type_resample = {
    .name = "mm, three of them, or XxYxZ voxels",
    .expected = "a spacing from 1e-06 to 1000 mm, such as 0.5 mm, or three along the axes of the "
                "volume: [0.5, 0.5, 1]; or up to 4096 voxels along each, such as 40x30x40",
    .read = read_resample,
    .write = write_resample,
    .schema = "{anyOf: [{type: string, pattern: '^[0-9][0-9.e+-]* "
              "*mm$|^[0-9]+x[0-9]+x[0-9]+$'}, " SC_SCHEMA_NUMBER
              ", {type: array, minItems: 3, maxItems: 3, items: {type: [number, string]}}]}",
};

/* ---- the volume ---- */

/* Read a path, or a list of them, which are the phases of the sc_job @p value. */
static sc_status read_path(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    sc_job *job = value;
    sc_status status = SC_OK;

    if (node->kind == SC_YAML_MAP)
        return sc_wrong_type(ctx, node, key->type->expected);
    if (node->kind != SC_YAML_LIST)
        return sc_type_text.read(ctx, key, node, job->volume.path);
    SC_PASS(sc_series_alloc(ctx, node, node->count, job));
    for (size_t i = 0; i < node->count; i++) {
        const sc_yaml named = sc_yaml_item(node, i);

        if (named.kind != SC_YAML_SCALAR || !named.text[0])
            (void)sc_goes_on(&status, sc_wrong_type(ctx, &named, "the path of a volume"));
        else
            (void)sc_goes_on(&status,
                             sc_type_text.read(ctx, key, &named, job->volume.phases[i].path));
    }
    snprintf(job->volume.path, sizeof job->volume.path, "%s", job->volume.phases[0].path);
    return status;
}

/* Append the path of the volume, or a list of those of the phases. */
static sc_status write_path(const sc_ctx *ctx, const sc_key *key, const void *value, sc_text *text)
{
    const sc_job *job = value;

    if (!job->volume.phase_count || job->volume.phases[0].phase) /* one file */
        return sc_type_text.write(ctx, key, job->volume.path, text);
    SC_PASS(sc_text_add(ctx, text, "["));
    for (size_t i = 0; i < job->volume.phase_count; i++) {
        SC_PASS(sc_text_add(ctx, text, "%s", i ? ", " : ""));
        SC_PASS(sc_write_quoted(ctx, job->volume.phases[i].path, text));
    }
    return sc_text_add(ctx, text, "]");
}

#define PATH_SCHEMA "{anyOf: [{type: string}, {type: array, minItems: 1, items: {type: string}}]}"

static const sc_value_type type_path = {
    .name = "text or list",
    .expected = "the path of a volume, or a list of paths",
    .read = read_path,
    .write = write_path,
    .schema = PATH_SCHEMA,
};

const sc_key sc_volume_keys[] = {
    {"path", &type_path, 0, NULL,
     .help = "a file (NRRD, NIfTI, MGH, MetaImage, TIFF, AmiraMesh, DICOM SEG, HDF5 as FILE:/PATH, "
             "or prepared), a Zarr or N5 store, a volume of Neuroglancer, a directory of masks or "
             "of slices (PNG, TIFF), phantom, or for example phantom:128x96x128; for cine a list "
             "of them, a pattern such as heart_*.nrrd, or a file with all phases (4-D)",
     .bytes = SC_PATH_BYTES, .required = true},
    {"header", &sc_type_text, offsetof(sc_job, volume.header), NULL,
     .help = "what the file does not say, or says wrongly: the spacing of its voxels with a unit "
             "(mm), and where x, y and z lead, such as \"0.5x0.5x2 um LPS\"; of a file without a "
             "header first type and size, and as far as needed big for numbers with the highest "
             "byte first, and skip N for N bytes before them: \"uint16 512x512x300 0.5x0.5x1 mm "
             "LPS big skip 1024\"; such a file may be packed by gzip",
     .bytes = sizeof(((sc_job *)0)->volume.header), .given = SC_GIVEN(sc_job, given.header),
     .without = "what the file says",
     .option = &(const sc_key_option){"header", "LINE", LABEL_COMMANDS}},
    {"level", &sc_type_int, offsetof(sc_job, volume.level), NULL,
     .help = "of an image of OME-Zarr, N5 or Neuroglancer: which of its resolutions is read, 0 the "
             "finest",
     .low = 0, .high = 63, .given = SC_GIVEN(sc_job, given.level), .without = "the finest"},
    {"phase", &type_phase, offsetof(sc_job, volume.phase), NULL,
     .help =
         "of a file that holds several volumes, one for each time (4-D NIfTI or NRRD, a Zarr store "
         "with an axis t): which is read, counted from 0; with cine all are shown instead",
     .low = 0, .high = 2147483646, .given = SC_GIVEN(sc_job, given.phase),
     .without = "the file holds one"},
    {"threshold", &sc_type_share, offsetof(sc_job, volume.threshold), NULL,
     .help = "of a directory of soft masks, which hold probabilities or degrees: a voxel belongs "
             "to a tissue from this share of the largest value of its file on",
     .low = 0.001, .high = 1, .given = SC_GIVEN(sc_job, given.threshold),
     .without = "masks hold one value beside 0"},
    {"box", &type_box, 0, NULL,
     .help =
         "the part of the file that is read, in voxels of the level: the first along each axis, "
         "and the one behind the last; or by two corners in RAS mm, between which the centres of "
         "its voxels lie. Of Zarr, N5, Neuroglancer and HDF5 only the chunks in it are read. "
         "visible + 5 mm: the part that is drawn, the voxels around the tissues that are shown, "
         "with a margin; less memory, and less time to prepare; also as the last item of a box",
     .low = 0, .high = 2147483647, .given = SC_GIVEN(sc_job, given.box), .without = "all of it"},
    {"merge", &sc_type_merged_tissues, 0, NULL,
     .help =
         "tissues that become one: as if they had been drawn with one label. The name is that of "
         "the map, the number the least of theirs, the colour that of the first that has one",
     .given = SC_GIVEN(sc_job, given.merge), .without = "every tissue is by itself"},
    {"keep", &sc_type_kept_tissues, 0, NULL,
     .help = "tissues that are kept, merged ones under their new name; all others are left out, as "
             "if they had never been drawn",
     .given = SC_GIVEN(sc_job, given.keep), .without = "all"},
    {"resample", &type_resample, 0, NULL,
     .help = "voxels of this spacing instead, finer or coarser, each with the label that has the "
             "largest vote around it, so that borders stay smooth; one for all axes of the volume "
             "or three. Or so many voxels, such as 128x96x128, each with the label nearest to its "
             "centre, and drawn as these are: for studies of how cost grows with the volume",
     .low = 1e-6, .high = 1e3, .unit = "mm", .given = SC_GIVEN(sc_job, given.resample),
     .without = "the voxels of the file"},
    {0}};

/* A path, a list of paths, or a map of sc_volume_keys. */
static sc_status read_volume(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    if (node->kind == SC_YAML_MAP) {
        const sc_yaml *path = sc_yaml_member(node, "path");

        ((sc_job *)value)->volume.is_replaced = node->line && path && !path->line;
        return sc_keys_read(ctx, key->keys, node, value);
    }
    return read_path(ctx, &key->keys[0], node, value);
}

/* As a path, where nothing is changed of the volume. */
static sc_status write_volume(const sc_ctx *ctx, const sc_key *key, const void *value,
                              sc_text *text)
{
    const sc_job *job = value;

    if (!job->volume.tissue_count && !job->given.level && !job->given.phase &&
        !job->given.resample && !job->given.box && !job->given.header && !job->given.threshold)
        return write_path(ctx, &key->keys[0], job, text);
    return sc_keys_write_flow(ctx, key->keys, value, text);
}

const sc_value_type sc_type_volume = {
    .name = "text, list or map",
    .expected = "the path of a volume, a list of paths, or a map with path, header, level, phase, "
                "threshold, box, merge, keep and resample",
    .read = read_volume,
    .write = write_volume,
    .schema = "{anyOf: [" PATH_SCHEMA ", $keys]}",
    .container = SC_CONTAINER_MAP,
};
