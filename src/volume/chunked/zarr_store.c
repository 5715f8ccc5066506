/* SPDX-License-Identifier: BSD-3-Clause */
/* The directories and files of a store of Zarr or N5 on disk. */
#include "chunked/zarr.h"

#include <errno.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

static const char *const meta_names[] = {"zarr.json", ".zarray", ".zgroup"};

/* Is there a file or directory @p name in the directory @p path? */
static bool holds(const char *path, const char *name)
{
    char file[4096];
    struct stat info;

    return snprintf(file, sizeof file, "%s/%s", path, name) < (int)sizeof file &&
           !stat(file, &info);
}

bool sc_zarr_is_node(const char *path)
{
    for (size_t i = 0; i < SC_COUNT_OF(meta_names); i++) {
        if (holds(path, meta_names[i]))
            return true;
    }
    return false;
}

bool sc_n5_is_node(const char *path)
{
    const char *end = path + strlen(path);

    while (end > path + 1 && end[-1] == '/')
        end--;
    return !sc_zarr_is_node(path) &&
           (holds(path, "attributes.json") || holds(path, "s0/attributes.json") ||
            (end - path > 3 && !strncmp(end - 3, ".n5", 3) && holds(path, ".")));
}

/* Read the metadata of a node of N5, whose directory is open: a group may have none. */
static sc_status read_n5_node(const sc_ctx *ctx, sc_zarr_node *node)
{
    node->meta_name = node->attributes_name = "attributes.json";
    SC_PASS(sc_chunk_read_json(ctx, node->fd, node->path, node->meta_name, &node->meta));
    if (!node->meta)
        node->meta = json_object();
    if (!node->meta)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", node->path);
    node->attributes = json_incref(node->meta);
    node->is_array = json_object_get(node->meta, "dimensions") != NULL;
    return SC_OK;
}

/* Read the metadata of a node whose directory is open. */
static sc_status read_node(const sc_ctx *ctx, sc_zarr_node *node)
{
    if (node->version == SC_ZARR_N5)
        return read_n5_node(ctx, node);
    for (size_t i = 0; i < SC_COUNT_OF(meta_names) && !node->meta; i++) {
        node->meta_name = meta_names[i];
        SC_PASS(sc_chunk_read_json(ctx, node->fd, node->path, node->meta_name, &node->meta));
    }
    if (!node->meta)
        return sc_fail(
            ctx, SC_ERR_MISSING,
            "%s: holds neither zarr.json nor .zarray nor .zgroup, expected a group or an "
            "array of Zarr",
            node->path);
    node->version = strcmp(node->meta_name, "zarr.json") ? 2 : 3;
    node->is_array = !strcmp(node->meta_name, ".zarray");
    node->attributes_name = node->version == 2 ? ".zattrs" : "zarr.json";
    if (json_integer_value(json_object_get(node->meta, "zarr_format")) != node->version)
        return sc_fail(ctx, SC_ERR_DATA, "%s/%s: its \"zarr_format\" is not %d", node->path,
                       node->meta_name, node->version);
    if (node->version == 2) {
        SC_PASS(sc_chunk_read_json(ctx, node->fd, node->path, ".zattrs", &node->attributes));
    } else {
        const char *type = json_string_value(json_object_get(node->meta, "node_type"));

        if (!type || (strcmp(type, "array") && strcmp(type, "group")))
            return sc_fail(ctx, SC_ERR_DATA,
                           "%s/zarr.json: its \"node_type\" is \"%s\", expected \"array\" or "
                           "\"group\"",
                           node->path, type ? type : "");
        node->is_array = !strcmp(type, "array");
        node->attributes = json_incref(json_object_get(node->meta, "attributes"));
    }
    return SC_OK;
}

sc_status sc_zarr_node_open(const sc_ctx *ctx, const char *path, sc_zarr_node *out)
{
    SC_OWN(sc_zarr_node_clear)
    sc_zarr_node node = {.fd = open(path, O_RDONLY | O_CLOEXEC | O_DIRECTORY),
                         .version = sc_n5_is_node(path) ? SC_ZARR_N5 : 0};

    if (node.fd < 0)
        return sc_fail(ctx, sc_input_status(errno), "%s: %s", path, strerror(errno));
    SC_PASS(sc_text_copy(ctx, path, &node.path));
    SC_PASS(read_node(ctx, &node));
    *out = node;
    node = (sc_zarr_node){.fd = -1};
    return SC_OK;
}

sc_status sc_zarr_node_open_below(const sc_ctx *ctx, const sc_zarr_node *parent, const char *name,
                                  sc_zarr_node *out)
{
    SC_OWN(sc_zarr_node_clear)
    sc_zarr_node node = {.fd = -1, .version = parent->version == SC_ZARR_N5 ? SC_ZARR_N5 : 0};

    SC_PASS(sc_chunk_open_below(ctx, parent->fd, parent->path, parent->attributes_name, name,
                                &node.path, &node.fd));
    SC_PASS(read_node(ctx, &node));
    *out = node;
    node = (sc_zarr_node){.fd = -1};
    return SC_OK;
}

bool sc_zarr_has(const sc_zarr_node *parent, const char *name)
{
    const int fd = sc_bad_name(name) ? -1 : sc_chunk_open_directory(parent->fd, name);
    bool found = false;

    for (size_t i = 0; i < SC_COUNT_OF(meta_names) && fd >= 0 && !found; i++) {
        const char *file = parent->version == SC_ZARR_N5 ? "attributes.json" : meta_names[i];
        struct stat info;

        found = !fstatat(fd, file, &info, AT_SYMLINK_NOFOLLOW) && S_ISREG(info.st_mode);
    }
    if (fd >= 0)
        close(fd);
    return found;
}

void sc_zarr_node_clear(sc_zarr_node *node)
{
    if (node->fd >= 0)
        close(node->fd);
    sc_free(node->path);
    json_decref(node->meta);
    json_decref(node->attributes);
    *node = (sc_zarr_node){.fd = -1};
}
