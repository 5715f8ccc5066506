/* SPDX-License-Identifier: BSD-3-Clause */
/* Which array of a Zarr store is shown, and what OME-Zarr 0.4 and 0.5 say of it: axes with units,
 * scales and translations, names and colours of labels. */
#include "chunked/zarr.h"
#include "tables/label_table.h"

#include <errno.h>
#include <float.h>
#include <stdlib.h>

enum { NAMES_SHOWN = 12 };

/* @return what OME-Zarr says in the attributes of a node: below "ome" since 0.5. NULL: nothing. */
static const json_t *ome_of(const sc_zarr_node *node)
{
    const json_t *ome = json_object_get(node->attributes, "ome");

    return ome ? ome : node->attributes;
}

void sc_zarr_choice_clear(sc_zarr_choice *choice)
{
    sc_zarr_node_clear(&choice->array);
    sc_label_table_clear(&choice->table);
    sc_free(choice->coarser);
}

/* Log what is wrong with OME's key @p key of a group. @return SC_ERR_DATA always. */
static sc_status refuse(const sc_ctx *ctx, const sc_zarr_node *group, const char *key,
                        const char *expected)
{
    return sc_fail(ctx, SC_ERR_DATA, "%s/%s: \"%s\" of OME-Zarr is not as expected: %s",
                   group->path, group->attributes_name, key, expected);
}

/* ---- geometry ---- */

/* Read the axes: names in 0.3, objects since 0.4. */
static sc_status read_axes(const sc_ctx *ctx, const sc_zarr_node *group, const json_t *axes,
                           sc_zarr_choice *out)
{
    const size_t count = json_array_size(axes);

    if (count < 2 || count > 5)
        return refuse(ctx, group, "axes", "2 to 5 axes, each with a name");
    for (size_t i = 0; i < count; i++) {
        const json_t *axis = json_array_get(axes, i);
        const json_t *name = json_is_string(axis) ? axis : json_object_get(axis, "name");
        const char *text = json_string_value(name);
        const char *unit = json_string_value(json_object_get(axis, "unit"));

        if (!text || strlen(text) >= sizeof out->names[i])
            return refuse(ctx, group, "axes", "2 to 5 axes, each with a name");
        snprintf(out->names[i], sizeof out->names[i], "%s", text);
        out->unit_mm[i] = unit ? sc_length_unit_mm(unit) : 0;
        out->unit_s[i] = unit ? sc_time_unit_s(unit) : 0;
    }
    out->axes = (int)count;
    out->named = true;
    return SC_OK;
}

/* Apply a list of transformations, "scale" and "translation", to those so far. */
static sc_status read_transformations(const sc_ctx *ctx, const sc_zarr_node *group,
                                      const json_t *list, sc_zarr_choice *out)
{
    for (size_t i = 0; i < json_array_size(list); i++) {
        const json_t *step = json_array_get(list, i);
        const char *type = json_string_value(json_object_get(step, "type"));
        const bool scale = type && !strcmp(type, "scale");
        const bool shift = type && !strcmp(type, "translation");
        double values[SC_ZARR_RANK_MAX];

        if (type && !strcmp(type, "identity"))
            continue;
        if ((!scale && !shift) ||
            json_array_size(json_object_get(step, type)) != (size_t)out->axes ||
            !sc_chunk_numbers(json_object_get(step, type), out->axes, -DBL_MAX, DBL_MAX, values))
            return refuse(ctx, group, "coordinateTransformations",
                          "a \"scale\" or \"translation\" with a number for each axis");
        for (int k = 0; k < out->axes; k++) {
            if (scale && values[k] < 0)
                return sc_fail(
                    ctx, SC_ERR_DATA,
                    "%s/%s: the \"scale\" of axis \"%s\" is %g, expected the distance of "
                    "voxels, a number above 0: an axis cannot be mirrored by it",
                    group->path, group->attributes_name, out->names[k], values[k]);
            out->scale[k] *= scale ? values[k] : 1;
            out->shift[k] = scale ? out->shift[k] * values[k] : out->shift[k] + values[k];
        }
        out->scaled = out->scaled || scale;
    }
    return SC_OK;
}

/* The path of dataset @p i of @p image; NULL if it has none. */
static const char *dataset_path(const json_t *image, size_t i)
{
    return json_string_value(
        json_object_get(json_array_get(json_object_get(image, "datasets"), i), "path"));
}

/* Read what the entry @p image of multiscales says of its dataset @p level. */
static sc_status read_image(const sc_ctx *ctx, const sc_zarr_node *group, const json_t *image,
                            size_t level, sc_zarr_choice *out)
{
    const json_t *axes = json_object_get(image, "axes");
    const json_t *dataset = json_array_get(json_object_get(image, "datasets"), level);
    const char *next = dataset_path(image, level + 1);

    if (next && !out->coarser)
        SC_PASS(sc_path_join(ctx, group->path, next, &out->coarser));
    if (!axes) /* 0.1 and 0.2: always t, c, z, y, x, without spacing */
        return SC_OK;
    SC_PASS(read_axes(ctx, group, axes, out));
    for (int i = 0; i < out->axes; i++) {
        out->scale[i] = 1;
        out->shift[i] = 0;
    }
    SC_PASS(read_transformations(ctx, group, json_object_get(dataset, "coordinateTransformations"),
                                 out));
    return read_transformations(ctx, group, json_object_get(image, "coordinateTransformations"),
                                out);
}

/* ---- labels ---- */

/* Append names and colours of a label image, if its group has some. */
static sc_status read_labels(const sc_ctx *ctx, const sc_zarr_node *group, sc_label_table *table)
{
    const json_t *labels = json_object_get(ome_of(group), "image-label");
    SC_OWN(sc_free_at) char *path = NULL;

    if (json_array_size(json_object_get(labels, "colors")) == 0 &&
        json_array_size(json_object_get(labels, "properties")) == 0)
        return SC_OK;
    SC_PASS(sc_path_join(ctx, group->path, group->attributes_name, &path));
    return sc_label_json_read(ctx, path, group->attributes, table);
}

/* ---- choosing ---- */

/* Append the strings of @p list to @p text, as "name, name". */
static sc_status list_names(const sc_ctx *ctx, const json_t *list, sc_text *text)
{
    const size_t count = json_array_size(list);

    for (size_t i = 0; i < count && i < NAMES_SHOWN; i++) {
        const char *name = json_string_value(json_array_get(list, i));

        SC_PASS(sc_text_add(ctx, text, "%s%s", i ? ", " : "", name ? name : "?"));
    }
    if (count > NAMES_SHOWN)
        SC_PASS(sc_text_add(ctx, text, ", and %zu more", count - NAMES_SHOWN));
    return SC_OK;
}

/* Open the one label image that the group @p labels names. */
static sc_status only_label(const sc_ctx *ctx, const sc_zarr_node *labels, sc_zarr_node *out)
{
    const json_t *list = json_object_get(ome_of(labels), "labels");
    const char *name = json_string_value(json_array_get(list, 0));
    SC_OWN(sc_text_clear) sc_text names = {0};

    if (json_array_size(list) == 1 && name)
        return sc_zarr_node_open_below(ctx, labels, name, out);
    SC_PASS(list_names(ctx, list, &names));
    if (json_array_size(list) < 2)
        return refuse(ctx, labels, "labels", "the names of label images in this group");
    else
        return sc_fail(
            ctx, SC_ERR_DATA, "%s: holds %zu label images: %s; give the path of one, such as %s/%s",
            labels->path, json_array_size(list), names.data, labels->path, name ? name : "NAME");
    return SC_OK;
}

/* Replace *node by the node below it called @p name, or by its only label image. */
static sc_status descend(const sc_ctx *ctx, const char *name, sc_zarr_node *node)
{
    sc_zarr_node below = {.fd = -1};
    const sc_status status =
        name ? sc_zarr_node_open_below(ctx, node, name, &below) : only_label(ctx, node, &below);

    if (status != SC_OK)
        return status;
    sc_zarr_node_clear(node);
    *node = below;
    return SC_OK;
}

/* Has an image a group "labels" that names no label image? Writers make it for labels to come. */
static bool has_empty_labels(const sc_ctx *ctx, const sc_zarr_node *image)
{
    const sc_ctx quiet = sc_quiet(ctx);
    sc_zarr_node labels = {.fd = -1};
    const json_t *list = NULL;
    bool empty;

    if (sc_zarr_node_open_below(&quiet, image, "labels", &labels) == SC_OK)
        list = json_object_get(ome_of(&labels), "labels");
    empty = json_is_array(list) && json_array_size(list) == 0;
    sc_zarr_node_clear(&labels);
    return empty;
}

/* Log that a group holds no image. @return SC_ERR_DATA always. */
static sc_status refuse_group(const sc_ctx *ctx, const sc_zarr_node *group)
{
    if (json_object_get(ome_of(group), "plate") || json_object_get(ome_of(group), "well"))
        return sc_fail(
            ctx, SC_ERR_DATA,
            "%s: is a plate or a well of OME-Zarr with many images; give the path of one "
            "of them, such as %s/A/1/0/labels/NAME",
            group->path, group->path);
    if (json_object_get(ome_of(group), "bioformats2raw.layout") && sc_zarr_has(group, "1"))
        return sc_fail(
            ctx, SC_ERR_DATA,
            "%s: holds several images of bioformats2raw; give the path of one, such as %s/0",
            group->path, group->path);
    return sc_fail(ctx, SC_ERR_DATA,
                   "%s: is a group of Zarr without images (no \"multiscales\" or \"labels\" of "
                   "OME-Zarr); give the path of an array or a label image in it",
                   group->path);
}

/* Go down from *node, a group, to a group with "multiscales" of labels where there is one: an image
 * has its label images in the group "labels". */
static sc_status find_image(const sc_ctx *ctx, sc_zarr_node *node)
{
    bool in_labels = false;
    sc_status status = SC_OK;

    for (int depth = 0; depth < 4 && status == SC_OK && !node->is_array; depth++) {
        const json_t *ome = ome_of(node);
        const bool image = json_array_size(json_object_get(ome, "multiscales")) > 0;

        if (image && (in_labels || json_object_get(ome, "image-label")))
            return SC_OK;
        if (!image && json_array_size(json_object_get(ome, "labels")) > 0) {
            in_labels = true;
            status = descend(ctx, NULL, node);
        } else if (sc_zarr_has(node, "labels") && !(image && has_empty_labels(ctx, node))) {
            status = descend(ctx, "labels", node);
        } else if (image) {
            return SC_OK; /* not marked as labels; most often they are all the same */
        } else if (json_object_get(ome, "bioformats2raw.layout") && sc_zarr_has(node, "0") &&
                   !sc_zarr_has(node, "1")) {
            status = descend(ctx, "0", node);
        } else {
            return refuse_group(ctx, node);
        }
    }
    return status;
}

/* Find the image of the group whose dataset is called @p name. @return NULL if there is none;
 * *level is the number of the dataset. */
static const json_t *image_of(const sc_zarr_node *group, const char *name, size_t *level)
{
    const json_t *images = json_object_get(ome_of(group), "multiscales");

    for (size_t i = 0; i < json_array_size(images); i++) {
        const json_t *image = json_array_get(images, i);

        for (*level = 0; dataset_path(image, *level); (*level)++) {
            if (!strcmp(dataset_path(image, *level), name))
                return image;
        }
    }
    return NULL;
}

/* If the directory in which the array @p path lies is a group whose multiscales name it, read what
 * that says. No group, or another one, is no error. */
static sc_status look_above(const sc_ctx *ctx, const char *path, sc_zarr_choice *out)
{
    SC_OWN(sc_free_at) char *real = realpath(path, NULL);
    char *slash = real ? strrchr(real, '/') : NULL;
    SC_OWN(sc_zarr_node_clear) sc_zarr_node group = {.fd = -1};
    const json_t *image;
    size_t level;

    if (!real && errno == ENOMEM)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", path);
    if (!slash || slash == real)
        return SC_OK;
    *slash = '\0';
    if (!sc_zarr_is_node(real))
        return SC_OK;
    SC_PASS(sc_zarr_node_open(ctx, real, &group));
    image = image_of(&group, slash + 1, &level);
    if (image) {
        SC_PASS(read_image(ctx, &group, image, level, out));
        SC_PASS(read_labels(ctx, &group, &out->table));
    }
    return SC_OK;
}

/* Log that @p image has no dataset @p level, with those that it has. @return SC_ERR_DATA;
 * SC_ERR_MEMORY. */
static sc_status refuse_level(const sc_ctx *ctx, const sc_zarr_node *group, const json_t *image,
                              int level)
{
    SC_OWN(sc_text_clear) sc_text levels = {0};

    for (size_t i = 0; i < NAMES_SHOWN && dataset_path(image, i); i++) {
        const sc_ctx quiet = sc_quiet(ctx);
        SC_OWN(sc_zarr_node_clear) sc_zarr_node node = {.fd = -1};

        (void)sc_zarr_node_open_below(&quiet, group, dataset_path(image, i), &node);
        SC_PASS(sc_chunk_describe_level(ctx, &levels, i, dataset_path(image, i),
                                        json_object_get(node.meta, "shape")));
    }
    return sc_chunk_refuse_level(ctx, group->path, level,
                                 json_array_size(json_object_get(image, "datasets")), &levels);
}

/* Open the dataset @p level of the image that the group @p node holds. */
static sc_status choose_level(const sc_ctx *ctx, const sc_zarr_node *node, int level,
                              sc_zarr_choice *choice)
{
    const json_t *image = json_array_get(json_object_get(ome_of(node), "multiscales"), 0);
    const char *path = dataset_path(image, (size_t)level);

    if (!dataset_path(image, 0))
        return refuse(ctx, node, "multiscales", "datasets, each with a path");
    if (!path)
        return refuse_level(ctx, node, image, level);
    SC_PASS(read_image(ctx, node, image, (size_t)level, choice));
    SC_PASS(read_labels(ctx, node, &choice->table));
    SC_PASS(sc_zarr_node_open_below(ctx, node, path, &choice->array));
    if (!choice->array.is_array)
        return refuse(ctx, node, "multiscales", "datasets whose paths lead to arrays");
    return SC_OK;
}

sc_status sc_zarr_choose(const sc_ctx *ctx, const char *path, int level, sc_zarr_choice *out)
{
    SC_OWN(sc_zarr_choice_clear) sc_zarr_choice choice = {.array.fd = -1};
    SC_OWN(sc_zarr_node_clear) sc_zarr_node node = {.fd = -1};

    SC_PASS(sc_zarr_node_open(ctx, path, &node));
    if (!node.is_array)
        SC_PASS(find_image(ctx, &node));
    if (node.is_array && level)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: is an array, and thus one resolution; expected level 0, or the path "
                       "of the image that it belongs to",
                       node.path);
    if (node.is_array) {
        SC_PASS(look_above(ctx, node.path, &choice));
        choice.array = node;
        node = (sc_zarr_node){.fd = -1};
    } else {
        SC_PASS(choose_level(ctx, &node, level, &choice));
    }
    *out = choice;
    choice = (sc_zarr_choice){.array.fd = -1};
    return SC_OK;
}
