/* SPDX-License-Identifier: BSD-3-Clause */
/* The directories and files of a Zarr store on disk. A store comes from anywhere: no link in it is
 * followed, so that it cannot make segcast read other files of the machine, and only regular files
 * are opened. */
#include "zarr.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const char *const meta_names[] = {"zarr.json", ".zarray", ".zgroup"};

bool sc_zarr_is_node(const char *path)
{
    for (size_t i = 0; i < SC_COUNT_OF(meta_names); i++) {
        char file[4096];
        struct stat info;

        if (snprintf(file, sizeof file, "%s/%s", path, meta_names[i]) < (int)sizeof file &&
            !stat(file, &info))
            return true;
    }
    return false;
}

/* Open the directory or file @p name, a path with "/", below @p directory, part by part, because
 * O_NOFOLLOW concerns the last part only. @return the descriptor, or -1 with errno. */
static int open_below(int directory, const char *name, int flags)
{
    int at = directory;

    for (;;) {
        const size_t length = strcspn(name, "/");
        const bool last = !name[length];
        char part[256];
        int next, error;

        if (length >= sizeof part) {
            errno = ENAMETOOLONG;
            next = -1;
        } else {
            memcpy(part, name, length);
            part[length] = '\0';
            next = openat(at, part,
                          O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK |
                              (last ? flags : O_DIRECTORY));
        }
        error = errno;
        if (at != directory)
            close(at);
        errno = error;
        if (next < 0 || last)
            return next;
        at = next;
        name += length + 1;
    }
}

int sc_zarr_open_file(int directory, const char *name, uint64_t *bytes)
{
    const int fd = open_below(directory, name, 0);
    struct stat info;

    if (fd < 0)
        return -1;
    if (fstat(fd, &info) || !S_ISREG(info.st_mode)) {
        close(fd);
        errno = EINVAL;
        return -1;
    }
    *bytes = (uint64_t)info.st_size;
    return fd;
}

/* Read the JSON file @p name in the directory of @p node. *out stays NULL if there is none. Caller
 * owns *out. */
static sc_status read_json(const sc_ctx *ctx, const sc_zarr_node *node, const char *name,
                           json_t **out)
{
    uint64_t bytes;
    const int fd = sc_zarr_open_file(node->fd, name, &bytes);
    json_error_t error;
    void *text;
    ssize_t got = 0;
    size_t done = 0;
    sc_status status;

    if (fd < 0 && errno == ENOENT)
        return SC_OK;
    if (fd < 0)
        return sc_fail(ctx,
                       errno == EINVAL || errno == ELOOP ? SC_ERR_DATA : sc_input_status(errno),
                       "%s/%s: %s; expected a regular file: links in a Zarr store are not followed",
                       node->path, name, errno == EINVAL ? "is none" : strerror(errno));
    if (bytes > SC_ZARR_JSON_BYTES_MAX) {
        close(fd);
        return sc_fail(ctx, SC_ERR_DATA, "%s/%s: has %llu bytes, expected at most %d", node->path,
                       name, (unsigned long long)bytes, SC_ZARR_JSON_BYTES_MAX);
    }
    status = sc_alloc(ctx, (size_t)bytes + 1, 1, &text);
    while (status == SC_OK && done < bytes &&
           (got = read(fd, (char *)text + done, (size_t)bytes - done)) > 0)
        done += (size_t)got;
    close(fd);
    if (status != SC_OK)
        return status;
    *out = json_loadb(text, done, 0, &error);
    sc_free(text);
    if (*out && json_is_object(*out))
        return SC_OK;
    if (!*out && json_error_code(&error) == json_error_out_of_memory)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", node->path);
    return *out ? sc_fail(ctx, SC_ERR_DATA, "%s/%s: is no JSON object", node->path, name)
                : sc_fail(ctx, SC_ERR_DATA, "%s/%s:%d: is no JSON: %s", node->path, name,
                          error.line, error.text);
}

/* Read the metadata of a node whose directory is open. */
static sc_status read_node(const sc_ctx *ctx, sc_zarr_node *node)
{
    sc_status status = SC_OK;

    for (size_t i = 0; i < SC_COUNT_OF(meta_names) && !node->meta; i++) {
        node->meta_name = meta_names[i];
        SC_TRY(read_json(ctx, node, node->meta_name, &node->meta));
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
        SC_TRY(read_json(ctx, node, ".zattrs", &node->attributes));
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
out:
    return status;
}

sc_status sc_zarr_node_open(const sc_ctx *ctx, const char *path, sc_zarr_node *out)
{
    sc_zarr_node node = {.fd = open(path, O_RDONLY | O_CLOEXEC | O_DIRECTORY)};
    sc_status status;

    if (node.fd < 0)
        return sc_fail(ctx, sc_input_status(errno), "%s: %s", path, strerror(errno));
    SC_TRY(sc_text_copy(ctx, path, &node.path));
    SC_TRY(read_node(ctx, &node));
    *out = node;
    node = (sc_zarr_node){.fd = -1};
out:
    sc_zarr_node_clear(&node);
    return status;
}

sc_status sc_zarr_node_open_below(const sc_ctx *ctx, const sc_zarr_node *parent, const char *name,
                                  sc_zarr_node *out)
{
    const char *why = sc_bad_name(name);
    sc_zarr_node node = {.fd = -1};
    sc_status status;

    if (why)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: its metadata name \"%s\": %s; expected the name of a directory in it",
                       parent->path, name, why);
    SC_TRY(sc_path_join(ctx, parent->path, name, &node.path));
    node.fd = open_below(parent->fd, name, O_DIRECTORY);
    if (node.fd < 0) {
        status = sc_fail(ctx, errno == ENOENT ? SC_ERR_MISSING : SC_ERR_DATA,
                         "%s: %s, but %s names it; expected a directory, no link", node.path,
                         errno == ENOENT ? "is not there" : "is no directory", parent->path);
        goto out;
    }
    SC_TRY(read_node(ctx, &node));
    *out = node;
    node = (sc_zarr_node){.fd = -1};
out:
    sc_zarr_node_clear(&node);
    return status;
}

bool sc_zarr_has(const sc_zarr_node *parent, const char *name)
{
    const int fd = sc_bad_name(name) ? -1 : open_below(parent->fd, name, O_DIRECTORY);
    bool found = false;

    for (size_t i = 0; i < SC_COUNT_OF(meta_names) && fd >= 0 && !found; i++) {
        struct stat info;

        found = !fstatat(fd, meta_names[i], &info, AT_SYMLINK_NOFOLLOW) && S_ISREG(info.st_mode);
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
