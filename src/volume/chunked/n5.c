/* SPDX-License-Identifier: BSD-3-Clause */
/* Which dataset of a store of N5 is shown, what attributes say of its geometry, and the header of
 * its blocks. Levels of resolution are datasets s0, s1, ... of one group, as n5-viewer, Paintera,
 * BigDataViewer and CellMap write them; attributes name x first. */
#include "bytes.h"
#include "chunked/zarr.h"

#include <errno.h>
#include <float.h>
#include <stdlib.h>
#include <unistd.h>

enum {
    LEVELS_MAX = 32, /* more are not looked for */
    GROUPS_MAX = 8   /* levels of nested groups that are searched */
};

/* ---- geometry ---- */

/* Log what is wrong with the attribute @p key. @return SC_ERR_DATA always. */
static sc_status refuse(const sc_ctx *ctx, const char *path, const char *key, const char *expected)
{
    return sc_chunk_refuse_key(ctx, path, "attributes.json", key, expected);
}

/* Read a list of @p count numbers to out[count]; @p positive: all above 0. A longer list counts as
 * far, as those of channels do that the array has not. */
static bool read_numbers(const json_t *list, int count, bool positive, double *out)
{
    return sc_chunk_numbers(list, count, positive ? DBL_TRUE_MIN : -DBL_MAX, DBL_MAX, out);
}

/* Read "transform", of the level itself, whose lists follow the axes that it names. */
static sc_status read_transform(const sc_ctx *ctx, const json_t *transform, sc_zarr_choice *out)
{
    const json_t *axes = json_object_get(transform, "axes");
    const json_t *units = json_object_get(transform, "units");
    const int count = (int)json_array_size(axes);
    double scale[SC_ZARR_RANK_MAX], shift[SC_ZARR_RANK_MAX] = {0};
    const json_t *translate = json_object_get(transform, "translate");

    if (count < 1 || count > SC_ZARR_RANK_MAX ||
        !read_numbers(json_object_get(transform, "scale"), count, true, scale) ||
        (translate && !read_numbers(translate, count, false, shift)))
        return refuse(ctx, out->array.path, "transform",
                      "\"axes\", and for each a number above 0 in \"scale\" and one in "
                      "\"translate\"");
    for (int i = 0; i < count; i++) {
        const char *name = json_string_value(json_array_get(axes, (size_t)i));
        const char *unit = json_string_value(json_array_get(units, (size_t)i));

        for (int k = 0; k < out->axes && name; k++) {
            if (strcmp(out->names[k], name) != 0)
                continue;
            out->scale[k] = scale[i];
            out->shift[k] = shift[i];
            out->unit_mm[k] = unit ? sc_length_unit_mm(unit) : 0;
        }
    }
    out->scaled = true;
    return SC_OK;
}

/* Where the size of the finest voxels stands. */
typedef struct n5_spacing {
    const char *key;    /* NULL: nowhere */
    const json_t *list; /* along x, y, z */
    const char *unit;   /* of all axes; NULL: of each, or none */
    const json_t *units;
} n5_spacing;

/* Find the size of voxels in the attributes of a dataset or group. */
static n5_spacing find_spacing(const json_t *attributes)
{
    static const char *const keys[] = {"pixelResolution", "resolution"};

    for (size_t i = 0; i < SC_COUNT_OF(keys); i++) {
        const json_t *value = json_object_get(attributes, keys[i]);
        const json_t *list = json_is_object(value) ? json_object_get(value, "dimensions") : value;

        if (value)
            return (n5_spacing){.key = keys[i],
                                .list = list,
                                .unit = json_string_value(json_object_get(value, "unit")),
                                .units = json_object_get(attributes, "units")};
    }
    return (n5_spacing){0};
}

/* Find how many of the finest voxels lie in one of a level along x, y, z: in its own attributes, or
 * for all levels in those of its group. *key is where. @return NULL: nowhere. */
static const json_t *find_factors(const json_t *dataset, const json_t *group, int level,
                                  const char **key)
{
    static const char *const keys[] = {"downsamplingFactors", "scales"};
    const json_t *own = json_object_get(dataset, keys[0]);

    *key = keys[0];
    for (size_t i = 0; i < SC_COUNT_OF(keys) && !own; i++) {
        *key = keys[i];
        own = json_array_get(json_object_get(group, keys[i]), (size_t)level);
    }
    return own;
}

/* Set the geometry of the dataset of @p out, the level @p level of a group with the attributes
 * @p group, which may be NULL. Of more than three dimensions the first three are x, y and z. */
static sc_status read_geometry(const sc_ctx *ctx, const json_t *group, int level,
                               sc_zarr_choice *out)
{
    const json_t *own = out->array.attributes, *transform = json_object_get(own, "transform");
    n5_spacing spacing = find_spacing(own);
    const char *path = out->array.path, *factor_key;
    const json_t *factors = find_factors(own, group, level, &factor_key);
    const json_t *offset = json_object_get(own, "offset");
    double size[3], by[3] = {1, 1, 1}, shift[3] = {0};
    const int rank = (int)json_array_size(json_object_get(own, "dimensions"));
    const int count = rank < 3 ? rank : 3;

    if (rank < 2 || rank > SC_ZARR_RANK_MAX) /* sc_zarr_array_read refuses it */
        return SC_OK;
    out->named = true;
    out->axes = rank;
    for (int i = 0; i < count; i++)
        snprintf(out->names[rank - 1 - i], sizeof out->names[0], "%c", "xyz"[i]);
    if (transform)
        return read_transform(ctx, transform, out);
    if (!spacing.key)
        spacing = find_spacing(group);
    if (!offset)
        offset = json_object_get(group, "offset");
    if (factors && !read_numbers(factors, count, true, by))
        return refuse(ctx, path, factor_key, "a number above 0 for each axis");
    if (!spacing.key)
        return SC_OK;
    if (!read_numbers(spacing.list, count, true, size))
        return refuse(ctx, path, spacing.key, "a number above 0 for each axis");
    if (offset && !read_numbers(offset, count, false, shift))
        return refuse(ctx, path, "offset", "a number for each axis");
    for (int i = 0; i < count; i++) {
        const char *unit = spacing.unit
                               ? spacing.unit
                               : json_string_value(json_array_get(spacing.units, (size_t)i));

        out->scale[rank - 1 - i] = size[i] * by[i];
        out->shift[rank - 1 - i] = shift[i] + size[i] * (by[i] - 1) / 2;
        out->unit_mm[rank - 1 - i] = unit ? sc_length_unit_mm(unit) : 0;
    }
    out->scaled = true;
    return SC_OK;
}

/* ---- choosing ---- */

static void level_name(int level, char out[16])
{
    snprintf(out, 16, "s%d", level);
}

static bool has_level(const sc_zarr_node *group, int level)
{
    char name[16];

    level_name(level, name);
    return level < LEVELS_MAX && sc_zarr_has(group, name);
}

/* Count the directories in a group, and copy the name of the first, by its bytes, to @p first. */
static sc_status count_below(const sc_ctx *ctx, const sc_zarr_node *group, char first[256],
                             size_t *count)
{
    SC_OWN(sc_entries_clear) sc_entries entries = {0};

    SC_PASS(sc_entries_list(ctx, group->path, &entries));
    for (int i = 0; i < entries.count; i++) {
        const char *name = entries.list[i]->d_name;
        const int below = sc_chunk_open_directory(group->fd, name);

        if (below < 0)
            continue;
        close(below);
        if ((*count)++ == 0)
            snprintf(first, 256, "%s", name);
    }
    return SC_OK;
}

/* Go down from *node, a group, to a dataset or a group of levels, as long as there is one way; a
 * group of Paintera has its labels in "data". */
static sc_status go_down(const sc_ctx *ctx, sc_zarr_node *node)
{
    for (int depth = 0; !node->is_array && !has_level(node, 0); depth++) {
        const bool paintera = json_object_get(node->attributes, "painteraData") != NULL;
        char name[256] = "data";
        size_t count = paintera;
        sc_zarr_node below = {.fd = -1};

        if (!paintera)
            SC_PASS(count_below(ctx, node, name, &count));
        if (count == 0 || depth == GROUPS_MAX)
            return sc_fail(ctx, SC_ERR_DATA,
                           "%s: is a group of N5 without a dataset (no \"dimensions\" in an "
                           "attributes.json); give the path of a dataset, or get the store anew",
                           node->path);
        if (count > 1)
            return sc_fail(ctx, SC_ERR_DATA,
                           "%s: is a group of N5 with %zu groups or datasets; give the path of "
                           "one, such as %s/%s",
                           node->path, count, node->path, name);
        SC_PASS(sc_zarr_node_open_below(ctx, node, name, &below));
        sc_zarr_node_clear(node);
        *node = below;
    }
    return SC_OK;
}

/* Open the level of a group that is wanted. */
static sc_status choose_level(const sc_ctx *ctx, const sc_zarr_node *group, int level,
                              sc_zarr_choice *out)
{
    char name[16];
    int levels = 0;

    while (has_level(group, levels))
        levels++;
    if (level >= levels)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: has no resolution level %d, expected 0, the finest (s0), to %d",
                       group->path, level, levels - 1);
    level_name(level, name);
    SC_PASS(sc_zarr_node_open_below(ctx, group, name, &out->array));
    SC_PASS(read_geometry(ctx, group->attributes, level, out));
    if (level + 1 == levels)
        return SC_OK;
    level_name(level + 1, name);
    return sc_path_join(ctx, group->path, name, &out->coarser);
}

/* Read the geometry of the dataset that the user has given. If it is a level, it may stand in the
 * group above. */
static sc_status look_above(const sc_ctx *ctx, sc_zarr_choice *out)
{
    SC_OWN(sc_free_at) char *real = realpath(out->array.path, NULL);
    SC_OWN(sc_zarr_node_clear) sc_zarr_node group = {.fd = -1};
    char *slash = real ? strrchr(real, '/') : NULL, *end = NULL;
    const long level = slash && slash[1] == 's' ? strtol(slash + 2, &end, 10) : 0;

    if (!real && errno == ENOMEM)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", out->array.path);
    if (!end || *end || end == slash + 2 || slash == real || level < 0 || level >= LEVELS_MAX)
        return read_geometry(ctx, NULL, 0, out);
    *slash = '\0';
    if (!sc_n5_is_node(real))
        return read_geometry(ctx, NULL, 0, out);
    SC_PASS(sc_zarr_node_open(ctx, real, &group));
    return read_geometry(ctx, group.attributes, (int)level, out);
}

sc_status sc_n5_choose(const sc_ctx *ctx, const char *path, int level, sc_zarr_choice *out)
{
    SC_OWN(sc_zarr_choice_clear) sc_zarr_choice choice = {.array.fd = -1};
    SC_OWN(sc_zarr_node_clear) sc_zarr_node node = {.fd = -1};

    SC_PASS(sc_zarr_node_open(ctx, path, &node));
    SC_PASS(go_down(ctx, &node));
    if (!node.is_array) {
        SC_PASS(choose_level(ctx, &node, level, &choice));
    } else if (level) {
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: is a dataset, and thus one resolution; expected level 0, or the path "
                       "of the group with s0, s1, ...",
                       node.path);
    } else {
        choice.array = node;
        node = (sc_zarr_node){.fd = -1};
        SC_PASS(look_above(ctx, &choice));
    }
    if (json_is_true(json_object_get(choice.array.attributes, "isLabelMultiset")))
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: holds label multisets, several labels for each voxel, which are not "
                       "read; expected one label for each, as `paintera-convert to-scalar` writes",
                       choice.array.path);
    *out = choice;
    choice = (sc_zarr_choice){.array.fd = -1};
    return SC_OK;
}

/* ---- blocks ---- */

bool sc_n5_block_read(const sc_zarr_array *array, const size_t at[SC_ZARR_RANK_MAX],
                      const unsigned char *packed, size_t packed_bytes,
                      int64_t shape[SC_ZARR_RANK_MAX], size_t *begin, char why[SC_CHUNK_WHY_BYTES])
{
    *begin = 4 + 4 * (size_t)array->rank;
    if (packed_bytes < *begin || sc_number_at(packed, 2, true) != 0 ||
        sc_number_at(packed + 2, 2, true) != (uint64_t)array->rank) {
        snprintf(why, SC_CHUNK_WHY_BYTES,
                 "does not begin as a block of N5 with %d dimensions and one value for each voxel",
                 array->rank);
        return false;
    }
    for (int i = 0; i < array->rank; i++) {
        const int64_t left = array->shape[i] - (int64_t)at[i] * array->chunk[i];
        const int64_t least = left < array->chunk[i] ? left : array->chunk[i];

        shape[i] = (int64_t)sc_number_at(packed + 4 + 4 * (array->rank - 1 - i), 4, true);
        if (shape[i] < least || shape[i] > array->chunk[i]) {
            snprintf(why, SC_CHUNK_WHY_BYTES,
                     "has %lld voxels along dimension %d, expected %lld to %lld",
                     (long long)shape[i], array->rank - 1 - i, (long long)least,
                     (long long)array->chunk[i]);
            return false;
        }
    }
    return true;
}
