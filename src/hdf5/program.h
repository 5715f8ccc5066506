/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to the program segcast-hdf5, which has one thread and serves one file. */
#ifndef SC_HDF5_PROGRAM_H
#define SC_HDF5_PROGRAM_H

#include "segcast/hdf5.h"

#include <stdbool.h>
#include <stddef.h>

#include <hdf5.h>

enum { RANK_MAX = 8 /* most dimensions of a dataset that is looked at */ };

/* What is said to segcast. The head and the text are sent when all of it is known. */
typedef struct answer {
    sc_hdf5_answer head;
    char text[SC_HDF5_TEXT_BYTES];
    char why[256]; /* of keep_reason */
} answer;

/* A dataset that holds a volume. Zero-initialise; volume_close closes. */
typedef struct volume {
    hid_t dataset;     /* 0: none */
    hid_t memory_type; /* as which voxels are read; 0: none */
    int rank;          /* dimensions of the dataset, with those of one entry */
    hsize_t dims[RANK_MAX];
    int axis[3];   /* the dimensions along which x (fastest), y and z of the stream go */
    char names[3]; /* what the file calls them: 'x', 'y', 'z' */
    size_t each;   /* bytes of a voxel in the stream */
    sc_hdf5_type type;
    hsize_t chunk[3];   /* voxels of a chunk along x, y, z; 0: no chunks */
    double chunk_bytes; /* of a chunk, unpacked, of the type that is stored; 0: no chunks */
} volume;

/* Which voxels are wanted. */
typedef struct part {
    hsize_t low[3], count[3]; /* along x, y, z */
} part;

/* Set what is said: a kind other than SC_HDF5_VOLUME, and why. @return false always. */
bool say(answer *a, sc_hdf5_kind kind, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
/* Keep the library's own message about the call that has just failed, until say_library: its next
 * call forgets it. */
void keep_reason(answer *a);
/* Say that the library failed to do @p what, and why. @return false always. */
bool say_library(answer *a, const char *what);

/* Find the dataset that is wanted in the open file, and describe it. @param wanted its path, or of
 * the group in which the only one is; "" for any. @param out its path [SC_HDF5_TEXT_BYTES].
 * @return false with an answer that says why not. */
bool find_dataset(hid_t file, const char *wanted, char *out, answer *a);
/* Open the dataset @p path and check that it holds a volume. @return false, said; what was opened
 * volume_close closes. */
bool volume_open(hid_t file, const char *path, volume *v, answer *a);
void volume_close(volume *v);
/* Find the geometry and the scale of the volume: to_ras_mm, flags, slope and intercept of the
 * answer. @return false, said, for damage. */
bool find_geometry(hid_t file, const char *path, const volume *v, answer *a);
/* Send the voxels of a part to segcast. @param memory_bytes as the argument of the program.
 * @return false, said, if they cannot be read; also if segcast is gone. */
bool send_voxels(const volume *v, const part *p, uint64_t memory_bytes, answer *a);
/* Let the process have no more than so many bytes of addresses; it may have less already. */
void limit_memory(double bytes);
/* Send bytes to segcast. @return false if it is gone. */
bool send_bytes(const void *bytes, size_t count);

/* Give the library the filter LZF. @return false if it does not take it. */
bool register_lzf(void);

/* Read an attribute of an object as numbers. @return how many there are, at most @p most; 0 for
 * none, or of another type. */
int read_numbers(hid_t object, const char *name, int most, double *out);
/* Read an attribute that is a text to out[size]. @return false if there is none. */
bool read_text(hid_t object, const char *name, char *out, size_t size);
/* Open an object of the file by its path, without following links to other files. @return below 0,
 * with the reason kept, if it cannot be. */
hid_t open_object(hid_t file, const char *path, answer *a);

#endif
