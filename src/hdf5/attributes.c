/* SPDX-License-Identifier: BSD-3-Clause */
/* Attributes of objects, and objects by their paths. */
#include "program.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* For H5Pset_elink_cb: no link to another file is followed. */
static herr_t refuse_link(const char *file, const char *group, const char *other,
                          const char *object, unsigned *flags, hid_t access, void *user)
{
    return -1;
}

hid_t open_object(hid_t file, const char *path, answer *a)
{
    const hid_t access = H5Pcreate(H5P_LINK_ACCESS);
    hid_t object = -1;

    if (H5Pset_elink_cb(access, refuse_link, NULL) >= 0)
        object = H5Oopen(file, path, access);
    if (object < 0)
        keep_reason(a);
    H5Pclose(access);
    return object;
}

/* Open an attribute of a class of types, and find how many values it has. @return below 0 if there
 * is none. */
static hid_t open_attribute(hid_t object, const char *name, bool is_text, hid_t *type,
                            hssize_t *count)
{
    hid_t attribute, space;
    H5T_class_t class;

    if (H5Aexists(object, name) <= 0)
        return -1;
    attribute = H5Aopen(object, name, H5P_DEFAULT);
    if (attribute < 0)
        return -1;
    *type = H5Aget_type(attribute);
    class = H5Tget_class(*type);
    space = H5Aget_space(attribute);
    *count = H5Sget_simple_extent_npoints(space);
    H5Sclose(space);
    if (is_text ? class == H5T_STRING : class == H5T_INTEGER || class == H5T_FLOAT)
        return attribute;
    H5Tclose(*type);
    H5Aclose(attribute);
    return -1;
}

int read_numbers(hid_t object, const char *name, int most, double *out)
{
    hssize_t count = 0;
    hid_t type;
    const hid_t attribute = open_attribute(object, name, false, &type, &count);

    if (attribute < 0)
        return 0;
    if (count < 1 || count > most || H5Aread(attribute, H5T_NATIVE_DOUBLE, out) < 0)
        count = 0;
    H5Tclose(type);
    H5Aclose(attribute);
    return (int)count;
}

bool read_text(hid_t object, const char *name, char *out, size_t size)
{
    hssize_t count = 0;
    hid_t type;
    const hid_t attribute = open_attribute(object, name, true, &type, &count);
    char *text = NULL;
    bool done = false;

    if (attribute < 0)
        return false;
    if (count == 1 && H5Tis_variable_str(type) > 0) {
        done = H5Aread(attribute, type, &text) >= 0 && text;
        if (done)
            snprintf(out, size, "%s", text);
        H5free_memory(text);
    } else if (count == 1 && H5Tget_size(type) < size) {
        done = H5Aread(attribute, type, out) >= 0;
        out[done ? H5Tget_size(type) : 0] = '\0'; /* texts of a fixed length may have no end */
    }
    H5Tclose(type);
    H5Aclose(attribute);
    return done;
}
