/* SPDX-License-Identifier: BSD-3-Clause */
/* Which dataset of a file is the volume, and how it is stored. */
#include "program.h"

#include <stdio.h>
#include <string.h>

enum {
    NAMED = 10,         /* datasets that a message names */
    LOOKED_AT = 100000, /* objects of a file, before the search ends */
    DEPTH_MOST = 64     /* of groups in groups: opening one passes through all above it */
};

/* ---- types ---- */

/* Find as which type the voxels of a dataset are read. @return the library's type, 0 if they are no
 * numbers. */
static hid_t number_type(hid_t dataset, sc_hdf5_type *out)
{
    const hid_t type = H5Dget_type(dataset);
    const H5T_class_t class = H5Tget_class(type);
    const hid_t base = class == H5T_ENUM ? H5Tget_super(type) : H5Tcopy(type);
    const size_t bytes = H5Tget_size(base);
    const bool is_signed = class != H5T_BITFIELD && H5Tget_sign(base) == H5T_SGN_2;
    const int width = bytes <= 1 ? 0 : bytes <= 2 ? 1 : bytes <= 4 ? 2 : 3; /* 1 << width bytes */
    const hid_t integers[4][2] = {{H5T_NATIVE_UINT8, H5T_NATIVE_INT8},
                                  {H5T_NATIVE_UINT16, H5T_NATIVE_INT16},
                                  {H5T_NATIVE_UINT32, H5T_NATIVE_INT32},
                                  {H5T_NATIVE_UINT64, H5T_NATIVE_INT64}};
    const hid_t bits[4] = {H5T_NATIVE_B8, H5T_NATIVE_B16, H5T_NATIVE_B32, H5T_NATIVE_B64};
    hid_t found = 0;

    if (type < 0 || bytes < 1 || bytes > 8) {
        found = 0;
    } else if (class == H5T_FLOAT) {
        *out = bytes <= 4 ? SC_HDF5_FLOAT : SC_HDF5_DOUBLE;
        found = bytes <= 4 ? H5T_NATIVE_FLOAT : H5T_NATIVE_DOUBLE;
    } else if (class == H5T_INTEGER || class == H5T_ENUM || class == H5T_BITFIELD) {
        *out = (sc_hdf5_type)(2 * width + !is_signed);
        found = class == H5T_BITFIELD ? bits[width] : integers[width][is_signed];
    }
    H5Tclose(base);
    H5Tclose(type);
    return found;
}

/* Write what a dataset holds to text[64], for messages. */
static void describe_type(hid_t dataset, char text[64])
{
    static const char *const names[] = {"integers",     "floats", "times",       "texts",
                                        "bits",         "bytes",  "records",     "references",
                                        "enumerations", "lists",  "small arrays"};
    const hid_t type = H5Dget_type(dataset);
    const int class = (int)H5Tget_class(type);

    snprintf(text, 64, "%s of %zu bytes",
             class >= 0 && class < (int)(sizeof names / sizeof *names) ? names[class] : "something",
             type >= 0 ? H5Tget_size(type) : 0);
    H5Tclose(type);
}

/* ---- dimensions ---- */

/* Read the dimensions of a dataset. @return false if they are none of an array, or too many. */
static bool read_dims(hid_t dataset, int *rank, hsize_t dims[RANK_MAX])
{
    const hid_t space = H5Dget_space(dataset);
    const int found =
        H5Sget_simple_extent_type(space) == H5S_SIMPLE ? H5Sget_simple_extent_ndims(space) : 0;
    const bool fits = found >= 1 && found <= RANK_MAX;

    *rank = fits ? found : 0;
    if (fits)
        H5Sget_simple_extent_dims(space, dims, NULL);
    H5Sclose(space);
    return fits;
}

/* Write the dimensions to text[128], as "10 x 20 x 30". */
static void describe_dims(int rank, const hsize_t *dims, char text[128])
{
    size_t used = 0;

    snprintf(text, 128, "no array");
    for (int i = 0; i < rank; i++)
        used += (size_t)snprintf(text + used, 128 - used, "%s%llu", i ? " x " : "",
                                 (unsigned long long)(dims[i] % 1000000000000));
}

/* Read the names of the axes, slowest first, as ilastik and vigra write them: the attribute
 * axistags, JSON with "key" for each axis. @return how many there are. */
static int read_axis_tags(hid_t dataset, char names[RANK_MAX])
{
    char text[16384];
    int count = 0;

    if (!read_text(dataset, "axistags", text, sizeof text))
        return 0;
    for (const char *at = strstr(text, "\"key\""); at && count < RANK_MAX;
         at = strstr(at, "\"key\"")) {
        at += strlen("\"key\"");
        at += strspn(at, " \t\n:\"");
        names[count++] = *at;
    }
    return count;
}

/* Find the dimensions that are x, y and z by the names of all, of which others have one entry. */
static bool axes_by_names(volume *v, const char names[RANK_MAX])
{
    int found = 0;

    for (int i = v->rank - 1; i >= 0; i--) {
        if (names[i] == 'x' || names[i] == 'y' || names[i] == 'z') {
            if (found == 3 || memchr(v->names, names[i], (size_t)found))
                return false;
            v->axis[found] = i;
            v->names[found++] = names[i];
        } else if (v->dims[i] != 1) {
            return false;
        }
    }
    return found == 3;
}

/* Find the dimensions that are z, y and x without names: those that are left when dimensions of one
 * entry, first at the beginning, then at the end, are left out. */
static bool axes_by_order(volume *v)
{
    int first = 0, count = v->rank;

    while (count > 3 && v->dims[first] == 1) {
        first++;
        count--;
    }
    while (count > 3 && v->dims[first + count - 1] == 1)
        count--;
    for (int i = 0; i < 3 && count == 3; i++) {
        v->axis[i] = first + 2 - i;
        v->names[i] = "xyz"[i];
    }
    return count == 3;
}

/* Find which dimensions of v are x, y, z. */
static bool find_axes(volume *v)
{
    char names[RANK_MAX];
    const int named = read_axis_tags(v->dataset, names);

    return named == v->rank ? axes_by_names(v, names) : axes_by_order(v);
}

/* ---- storage ---- */

/* Say which filter of a dataset this library lacks. @return false always. */
static bool say_filter(H5Z_filter_t filter, const char *name, const char *path, answer *a)
{
    static const struct {
        H5Z_filter_t filter;
        const char *name;
    } known[] = {{H5Z_FILTER_SZIP, "szip"}, {305, "LZO"},   {307, "bzip2"},        {32000, "LZF"},
                 {32001, "Blosc"},          {32004, "LZ4"}, {32008, "bitshuffle"}, {32013, "ZFP"},
                 {32015, "Zstandard"},      {32017, "SZ"},  {32026, "Blosc2"}};

    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        name = known[i].filter == filter ? known[i].name : name;
    return say(a, SC_HDF5_DAMAGED,
               "the dataset %.200s is packed by filter %d (%.60s), which the HDF5 library of "
               "segcast has not; pack it anew by gzip, where the filter is: h5repack -f GZIP=4 "
               "FILE NEW",
               path, (int)filter, name[0] ? name : "unknown");
}

/* Check how the dataset is stored, and find the size of its chunks. */
static bool check_storage(const char *path, volume *v, answer *a)
{
    const hid_t creation = H5Dget_create_plist(v->dataset);
    const H5D_layout_t layout = H5Pget_layout(creation);
    hsize_t chunk[RANK_MAX];
    bool done = true;

    if (layout == H5D_VIRTUAL || H5Pget_external_count(creation) > 0)
        done = say(a, SC_HDF5_DAMAGED,
                   "the dataset %.200s has its voxels in other files (%s), which are not read; "
                   "expected all in one file: copy it, for example with h5py",
                   path, layout == H5D_VIRTUAL ? "a virtual dataset" : "external storage");
    for (unsigned i = 0, count = (unsigned)H5Pget_nfilters(creation); i < count && done; i++) {
        size_t values = 0;
        unsigned flags;
        char name[64] = "";
        const H5Z_filter_t filter =
            H5Pget_filter2(creation, i, &flags, &values, NULL, sizeof name, name, NULL);

        name[sizeof name - 1] = '\0';
        if (filter < 0)
            keep_reason(a);
        if (filter < 0)
            done = say_library(a, "the filters of its dataset cannot be read");
        else if (H5Zfilter_avail(filter) <= 0)
            done = say_filter(filter, name, path, a);
    }
    if (done && layout == H5D_CHUNKED && H5Pget_chunk(creation, RANK_MAX, chunk) == v->rank) {
        const hid_t type = H5Dget_type(v->dataset);

        v->chunk_bytes = (double)H5Tget_size(type);
        H5Tclose(type);
        for (int i = 0; i < v->rank; i++)
            v->chunk_bytes *= (double)chunk[i];
        for (int i = 0; i < 3; i++)
            v->chunk[i] = chunk[v->axis[i]];
    }
    H5Pclose(creation);
    return done;
}

bool volume_open(hid_t file, const char *path, volume *v, answer *a)
{
    char dims[128], type[64];

    v->dataset = open_object(file, path, a);
    if (v->dataset < 0)
        return say_library(a, "its dataset cannot be opened");
    v->memory_type = number_type(v->dataset, &v->type);
    if (!read_dims(v->dataset, &v->rank, v->dims) || !v->memory_type || !find_axes(v)) {
        describe_dims(v->rank, v->dims, dims);
        describe_type(v->dataset, type);
        return say(a, SC_HDF5_DAMAGED,
                   "the dataset %.200s holds %s (%s), expected integers along z, y and x, the last "
                   "the fastest, and one entry along any other axis",
                   path, dims, type);
    }
    v->each = H5Tget_size(v->memory_type);
    for (int i = 0; i < 3; i++)
        a->head.size[i] = v->dims[v->axis[i]];
    a->head.type = (uint32_t)v->type;
    return check_storage(path, v, a);
}

void volume_close(volume *v)
{
    if (v->dataset > 0)
        H5Oclose(v->dataset);
    v->dataset = 0;
}

/* ---- search ---- */

/* What was found of one kind of datasets. */
typedef struct finds {
    size_t count;
    char first[SC_HDF5_TEXT_BYTES / 2];
    char list[SC_HDF5_TEXT_BYTES / 2]; /* the paths of the first of them */
} finds;

typedef struct search {
    answer *a;
    const char *group; /* where it is done, with a slash at its end */
    finds labels, fractions;
    size_t looked_at;
    bool has_ended_early;
} search;

static void note(finds *f, const char *group, const char *name)
{
    const size_t used = strlen(f->list);

    if (f->count == 0)
        snprintf(f->first, sizeof f->first, "%s%s", group, name);
    if (f->count < NAMED)
        snprintf(f->list + used, sizeof f->list - used, "%s%.60s%.100s", used ? ", " : "", group,
                 name);
    f->count++;
}

/* Is it a dataset that could be a volume? @param is_float of fractions. */
static bool could_be_volume(hid_t dataset, bool *is_float)
{
    volume v = {.dataset = dataset};
    sc_hdf5_type type;

    if (!number_type(dataset, &type) || !read_dims(dataset, &v.rank, v.dims) || !find_axes(&v))
        return false;
    *is_float = type >= SC_HDF5_FLOAT;
    return true;
}

/* @return how many groups a path passes through. */
static int depth_of(const char *path)
{
    int depth = 0;

    while ((path = strchr(path, '/'))) {
        depth++;
        path++;
    }
    return depth;
}

/* For H5Ovisit: note the object, if it could be the volume. @param user a search. */
static herr_t look_at(hid_t root, const char *name, const H5O_info_t *info, void *user)
{
    search *s = user;
    bool is_float;
    hid_t dataset;

    s->has_ended_early = ++s->looked_at > LOOKED_AT || depth_of(name) > DEPTH_MOST;
    if (s->has_ended_early)
        return 1;
    if (info->type != H5O_TYPE_DATASET)
        return 0;
    dataset = open_object(root, name, s->a);
    if (dataset >= 0 && could_be_volume(dataset, &is_float))
        note(is_float ? &s->fractions : &s->labels, s->group, strcmp(name, ".") ? name : "");
    if (dataset >= 0)
        H5Oclose(dataset);
    return 0;
}

/* Find the only volume in the group @p name, which is open. @p out may be @p name. */
static bool search_group(hid_t group, const char *name, char *out, answer *a)
{
    static search s;
    char prefix[1024];
    const size_t length = strlen(name);
    const finds *f = &s.labels;

    snprintf(prefix, sizeof prefix, "%s%s", name, name[length - 1] == '/' ? "" : "/");
    s.group = prefix;
    s.a = a;
    if (H5Ovisit(group, H5_INDEX_NAME, H5_ITER_INC, look_at, &s) < 0) {
        keep_reason(a);
        return say_library(a, "its groups cannot be read");
    }
    if (f->count == 0)
        f = &s.fractions;
    if (f->count == 1) {
        snprintf(out, SC_HDF5_TEXT_BYTES, "%s", f->first);
        a->head.flags |= SC_HDF5_ONLY;
        return true;
    }
    if (f->count == 0)
        return say(
            a, SC_HDF5_MISSING,
            "holds no dataset of integers along three axes in %.200s%s, expected a volume of "
            "labels",
            prefix,
            s.has_ended_early ? " that can be found without a long search: say FILE:/PATH" : "");
    return say(a, SC_HDF5_MISSING,
               "holds %zu volumes: %.2000s%s; say behind the file which one is wanted: FILE:%.200s",
               f->count, f->list, f->count > NAMED ? ", ..." : "", f->first);
}

/* Is there a path in the file, all parts of it links within? */
static bool has_path(hid_t file, const char *path, bool *leads_out)
{
    char piece[SC_HDF5_TEXT_BYTES];

    *leads_out = false;
    for (size_t end = 1; path[end - 1]; end++) {
        H5L_info_t info;

        if (path[end] && path[end] != '/')
            continue;
        snprintf(piece, sizeof piece, "%.*s", (int)end, path);
        if (!strcmp(piece, "/"))
            continue;
        if (H5Lget_info(file, piece, &info, H5P_DEFAULT) < 0)
            return false;
        *leads_out = info.type == H5L_TYPE_EXTERNAL;
        if (*leads_out || !path[end])
            return !*leads_out;
    }
    return true;
}

/* Say why there is no object of the path that is wanted. @return false always. */
static bool say_missing(const char *wanted, bool is_link, bool leads_out, answer *a)
{
    if (leads_out)
        return say(a, SC_HDF5_DAMAGED,
                   "%.200s leads to another file (an external link), which is not read; give that "
                   "file",
                   wanted);
    if (is_link)
        return say(a, SC_HDF5_DAMAGED,
                   "%.200s is a link to what is not there, to itself or to another file", wanted);
    return say(a, SC_HDF5_MISSING, "holds no %.200s; `segcast info FILE` names what it holds",
               wanted);
}

bool find_dataset(hid_t file, const char *wanted, char *out, answer *a)
{
    static const char *const usual[] = {"/ITKImage/0/VoxelData", "/minc-2.0/image/0/image"};
    bool leads_out = false, is_there, done;
    hid_t object;
    H5I_type_t kind;

    for (size_t i = 0; i < sizeof usual / sizeof *usual && !wanted[0]; i++)
        wanted = has_path(file, usual[i], &leads_out) ? usual[i] : wanted;
    wanted = wanted[0] ? wanted : "/";
    is_there = has_path(file, wanted, &leads_out);
    if (!is_there || H5Oexists_by_name(file, wanted, H5P_DEFAULT) <= 0)
        return say_missing(wanted, is_there, leads_out, a);
    object = open_object(file, wanted, a);
    if (object < 0)
        return say_library(a, "what is wanted of it cannot be opened");
    kind = H5Iget_type(object);
    snprintf(out, SC_HDF5_TEXT_BYTES, "%s%s", wanted[0] == '/' ? "" : "/", wanted);
    done =
        kind == H5I_DATASET ||
        (kind == H5I_GROUP ? search_group(object, out, out, a)
                           : say(a, SC_HDF5_MISSING, "%.200s is no dataset and no group", wanted));
    H5Oclose(object);
    return done;
}
