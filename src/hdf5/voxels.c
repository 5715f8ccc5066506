/* SPDX-License-Identifier: BSD-3-Clause */
/* The voxels of a dataset, some slices at a time. */
#include "program.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define SLAB_BYTES ((double)(4 << 20)) /* at least so much at a time, where chunks allow it */
#define SLAB_MOST_BYTES 2147483648.0   /* whole chunks or not: more stands still for too long */
#define BASE_BYTES 268435456.0 /* libraries, and what of the file's own structure is in memory */
#define CHUNK_COPIES 8         /* filters double what they unpack to while it does not fit */
#define CHUNK_NOTES_BYTES 8192 /* what the library notes of a chunk that it is going to read */

/* How many slices are read at a time: whole layers of chunks, so that each chunk is unpacked once,
 * unless these need more than half of the memory. */
static hsize_t slab_slices(const volume *v, const part *p, uint64_t memory_bytes)
{
    const double slice_bytes = (double)p->count[0] * (double)p->count[1] * (double)v->each;
    const double layer = v->chunk[2] ? (double)v->chunk[2] : 1;
    double most_bytes = SLAB_MOST_BYTES;
    double slices = layer * (floor(SLAB_BYTES / (slice_bytes * layer)) + 1);

    if (memory_bytes && (double)memory_bytes / 2 < most_bytes)
        most_bytes = (double)memory_bytes / 2;
    if (slices * slice_bytes > most_bytes)
        slices = floor(most_bytes / slice_bytes);
    if (slices < 1)
        slices = 1;
    return slices < (double)p->count[2] ? (hsize_t)slices : p->count[2];
}

/* Let the process take no more memory than slices and chunks of the sizes that the file promises
 * need, so that a chunk which unpacks to more is an error. */
static void expect_no_more(const volume *v, const part *p, hsize_t slices)
{
    double bytes =
        BASE_BYTES + (double)slices * (double)p->count[0] * (double)p->count[1] * (double)v->each;
    double chunks = v->chunk_bytes > 0;

    for (int i = 0; i < 3 && chunks > 0; i++)
        chunks *= (i < 2 ? (double)p->count[i] : (double)slices) / (double)v->chunk[i] + 2;
    bytes += CHUNK_COPIES * v->chunk_bytes + CHUNK_NOTES_BYTES * chunks;
    limit_memory(bytes);
}

/* Say that the next slices cannot be read. @return false always. */
static bool say_unread(const volume *v, hsize_t first, hsize_t count, answer *a)
{
    char what[160];

    keep_reason(a);
    snprintf(what, sizeof what, "slices %llu to %llu (of the axis %c) cannot be read",
             (unsigned long long)first, (unsigned long long)(first + count - 1), v->names[2]);
    return say_library(a, what);
}

bool send_voxels(const volume *v, const part *p, uint64_t memory_bytes, answer *a)
{
    const hsize_t slices = slab_slices(v, p, memory_bytes);
    const size_t slice_bytes = (size_t)(p->count[0] * p->count[1]) * v->each;
    const hid_t space = H5Dget_space(v->dataset);
    const hsize_t end = p->low[2] + p->count[2];
    hsize_t start[RANK_MAX] = {0}, count[RANK_MAX];
    void *slab;
    bool done = true;

    expect_no_more(v, p, slices);
    slab = malloc((size_t)slices * slice_bytes);
    if (!slab)
        done = say(a, SC_HDF5_LIMIT,
                   "%llu slices of %zu bytes, which are read at a time, do not fit into memory",
                   (unsigned long long)slices, slice_bytes);
    for (int i = 0; i < v->rank; i++)
        count[i] = 1;
    for (int i = 0; i < 2; i++) {
        start[v->axis[i]] = p->low[i];
        count[v->axis[i]] = p->count[i];
    }
    for (hsize_t z = p->low[2], more; z < end && done; z += more) {
        uint64_t bytes;
        hid_t memory;

        more = slices - (v->chunk[2] ? z % v->chunk[2] % slices : 0); /* up to the end of a chunk */
        more = end - z < more ? end - z : more;
        start[v->axis[2]] = z;
        count[v->axis[2]] = more;
        memory = H5Screate_simple(v->rank, count, NULL);
        if (H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, count, NULL) < 0 ||
            H5Dread(v->dataset, v->memory_type, memory, space, H5P_DEFAULT, slab) < 0)
            done = say_unread(v, z, more, a);
        H5Sclose(memory);
        bytes = more * slice_bytes;
        done = done && send_bytes(&bytes, sizeof bytes) && send_bytes(slab, (size_t)bytes);
    }
    free(slab);
    H5Sclose(space);
    return done;
}
