/* SPDX-License-Identifier: BSD-3-Clause */
/* The files that the header of a volume names for its voxels. A volume comes from anywhere, so that
 * its header must not make segcast read another file of the machine, wait on standard input or
 * open a device: a name, also an absolute one or one with "..", leads to a regular file in the
 * folder of the header or below it. */
#include "compressed_file.h"
#include "source.h"

#include <errno.h>
#include <stdlib.h>
#include <sys/stat.h>

enum { PATTERN_WIDTH_MAX = 100 };

sc_status sc_read_header_bytes(const sc_ctx *ctx, const char *path, const char *format, void *out,
                               size_t bytes, size_t least, size_t *count)
{
    SC_OWN(sc_compressed_close) sc_compressed_file *file = NULL;

    SC_PASS(sc_compressed_open(ctx, path, 0, SC_COMPRESSION_GZIP, &file));
    *count = sc_compressed_read(file, out, bytes);
    SC_PASS(sc_compressed_check(ctx, file));
    if (*count < least)
        return sc_fail(ctx, SC_ERR_DATA, "%s: ends after %zu bytes, expected a header of %zu (%s)",
                       path, *count, least, format);
    return SC_OK;
}

bool sc_voxel_type_named(const char *name, const char *const *names, sc_voxel_type *out)
{
    static const char *const usual[SC_VOXEL_TYPES] = {"int8",    "uint8",  "int16", "uint16",
                                                      "int32",   "uint32", "int64", "uint64",
                                                      "float32", "float64"};

    names = names ? names : usual;
    for (int i = 0; name && i < SC_VOXEL_TYPES; i++) {
        if (names[i] && !strcmp(name, names[i])) {
            *out = (sc_voxel_type)i;
            return true;
        }
    }
    return false;
}

bool sc_voxel_type_coded(int code, const int codes[SC_VOXEL_TYPES], sc_voxel_type *out)
{
    for (int i = 0; i < SC_VOXEL_TYPES; i++) {
        if (code >= 0 && codes[i] == code) {
            *out = (sc_voxel_type)i;
            return true;
        }
    }
    return false;
}

bool sc_voxel_type_fits(sc_voxel_type type, int64_t value)
{
    static const int64_t lowest[] = {INT8_MIN, 0, INT16_MIN, 0, INT32_MIN, 0, INT64_MIN, 0};
    static const int64_t highest[] = {INT8_MAX,  UINT8_MAX,  INT16_MAX, UINT16_MAX,
                                      INT32_MAX, UINT32_MAX, INT64_MAX, INT64_MAX};

    return value >= lowest[type] && value <= highest[type];
}

bool sc_voxel_type_is_integer(sc_voxel_type type)
{
    return type != SC_VOXEL_FLOAT && type != SC_VOXEL_DOUBLE;
}

/* @return why no file can be called @p name; NULL if one can. */
static const char *why_no_file(const char *name)
{
    if (!name[0])
        return "no name";
    if (!strcmp(name, "-"))
        return "standard input";
    for (const char *c = name; *c; c++) {
        if ((unsigned char)*c < ' ' || *c == 127)
            return "not a name of a file: it holds a control character";
    }
    return NULL;
}

/* @return how @p name may leave the folder that it is relative to; NULL if it does not. */
static const char *why_outside(const char *name)
{
    if (name[0] == '/')
        return "an absolute path";
    for (const char *part = name; part; part = strchr(part, '/')) {
        part += *part == '/';
        if (!strncmp(part, "..", 2) && (!part[2] || part[2] == '/'))
            return "outside the header's directory";
    }
    return NULL;
}

const char *sc_bad_name(const char *name)
{
    const char *why = why_outside(name);

    return why ? why : why_no_file(name);
}

/* Is the file whose path without links is @p file in the folder @p folder or below it? */
static bool is_below(const char *file, const char *folder)
{
    SC_OWN(sc_free_at) char *real = folder ? realpath(folder, NULL) : NULL;
    const size_t length = real ? strlen(real) : 0;

    return real && !strncmp(file, real, length) &&
           (file[length] == '/' || (length && real[length - 1] == '/'));
}

sc_status sc_data_file(const sc_ctx *ctx, const char *header, const char *field, const char *name,
                       char **out, uint64_t *bytes)
{
    static const char advice[] = "expected the name of a file in the directory of the header: put "
                                 "both into one directory, or "
                                 "save the volume as one file (.nrrd, .mha, .nii.gz)";
    const char *why = why_no_file(name), *outside = why_outside(name);
    SC_OWN(sc_free_at)
    char *own = NULL, *target = NULL, *others = NULL, *joined = NULL, *real = NULL;
    struct stat info;
    bool below;

    if (why)
        return sc_fail(ctx, SC_ERR_DATA, "%s: %s is \"%s\": %s; %s", header, field, name, why,
                       advice);
    SC_PASS(sc_folder_of(ctx, header, &own));
    target = realpath(header, NULL); /* where the header lies if the user has named a link to it */
    if (target)
        SC_PASS(sc_folder_of(ctx, target, &others));
    for (int i = 0; i < 2 && !real; i++) {
        const char *folder = i ? others : own;

        if (!folder)
            break;
        sc_free(joined);
        joined = NULL;
        SC_PASS(
            sc_path_join(ctx, *name == '/' || !strcmp(folder, ".") ? "" : folder, name, &joined));
        real = realpath(joined, NULL);
    }
    below = real && (is_below(real, own) || is_below(real, others));
    if (outside && !below) /* whether there is such a file is nobody's business */
        return sc_fail(ctx, SC_ERR_DATA, "%s: %s is \"%s\": %s; %s", header, field, name, outside,
                       advice);
    if (!real || stat(real, &info))
        return sc_fail(ctx, SC_ERR_DATA, "%s: the file of its voxels, %s: %s", header,
                       joined ? joined : name, strerror(errno));
    if (!below)
        return sc_fail(ctx, SC_ERR_DATA, "%s: %s is \"%s\", a link out of the directory to %s; %s",
                       header, field, name, real, advice);
    if (!S_ISREG(info.st_mode))
        return sc_fail(ctx, SC_ERR_DATA, "%s: %s is \"%s\", which is no regular file; %s", header,
                       field, name, advice);
    *bytes = (uint64_t)info.st_size;
    SC_HAND_OVER(joined, out);
    return SC_OK;
}

static int is_shown(const struct dirent *entry)
{
    return entry->d_name[0] != '.';
}

static int by_bytes(const struct dirent **a, const struct dirent **b)
{
    return strcmp((*a)->d_name, (*b)->d_name);
}

sc_status sc_entries_list(const sc_ctx *ctx, const char *directory, sc_entries *out)
{
    out->count = scandir(directory, &out->list, is_shown, by_bytes);
    if (out->count >= 0)
        return SC_OK;
    out->count = 0;
    return sc_fail(ctx, sc_input_status(errno), "%s: %s", directory, strerror(errno));
}

void sc_entries_clear(sc_entries *entries)
{
    for (int i = 0; i < entries->count; i++)
        free(entries->list[i]);
    free(entries->list);
    *entries = (sc_entries){0};
}

bool sc_name_pattern_read(char *text, sc_name_pattern *out)
{
    char *percent = strchr(text, '%'), *end;
    unsigned long width;

    if (!percent)
        return false;
    width = strtoul(percent + 1, &end, 10);
    if (*end != 'd' || strchr(end, '%') || width > PATTERN_WIDTH_MAX)
        return false;
    out->zeros = percent[1] == '0';
    out->width = (int)width;
    *percent = '\0';
    out->before = text;
    out->after = end + 1;
    return true;
}

sc_status sc_name_pattern_write(const sc_ctx *ctx, const sc_name_pattern *pattern, long long number,
                                sc_text *name)
{
    name->length_bytes = 0;
    return sc_text_add(ctx, name, pattern->zeros ? "%s%0*lld%s" : "%s%*lld%s", pattern->before,
                       pattern->width, number, pattern->after);
}

sc_status sc_check_file_bytes(const sc_ctx *ctx, const char *path, double needed)
{
    const bool packed = sc_is_gzip(path, 0);
    uint64_t bytes;

    SC_PASS(sc_input_bytes(ctx, path, &bytes));
    if (needed > (double)bytes * (packed ? SC_DEFLATE_RATIO_MAX : 1))
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: the header promises %.0f bytes, more than the file can hold (%llu%s)",
                       path, needed, (unsigned long long)bytes, packed ? ", compressed" : "");
    return SC_OK;
}
