/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  How segcast and the program segcast-hdf5 talk, which reads HDF5 files in a process of its own,
 *  since the library behind it crashes on damaged files.
 *
 *  The program is started with the file open for reading as descriptor 0, a pipe to segcast as
 *  descriptor 1, and these arguments: the process id of segcast; the memory in bytes that it may
 *  use, 0 for no limit; the path of a dataset or group in the file, "" for any; and, if voxels are
 *  wanted and not their description alone, 6 numbers: first and number of voxels along x, y, z.
 *  It answers with a sc_hdf5_answer and its text; then come the voxels that were asked for, x
 *  fastest, in the byte order of the machine, in blocks: a number of bytes, as an integer of 64
 * bits, and then these bytes. A block with the number 0 says that the rest cannot be read; a second
 *  sc_hdf5_answer follows it, whose text is the reason. Both programs are of one build. What comes
 * through the pipe is to be trusted no more than the file. */
#ifndef SEGCAST_HDF5_H
#define SEGCAST_HDF5_H

#include <stdint.h>

/** The name of the program. */
#define SC_HDF5_PROGRAM "segcast-hdf5"
/** The first bytes of an answer; changes with its form. */
#define SC_HDF5_MAGIC "SCHDF5\n\1"

enum {
    SC_HDF5_MAGIC_BYTES = 8,
    SC_HDF5_TEXT_BYTES = 4096,    /**< most bytes of a text */
    SC_HDF5_ARGUMENTS = 4,        /**< without voxels, the name of the program included */
    SC_HDF5_CPU_S = 60,           /**< CPU time that the program may take without voxels */
    SC_HDF5_BYTES_PER_S = 2000000 /**< voxels that it has to deliver at least beyond that */
};

/** What an answer says. */
typedef enum sc_hdf5_kind {
    SC_HDF5_VOLUME = 1, /**< a volume; the text is the path of its dataset */
    SC_HDF5_DAMAGED,    /**< the file cannot be read; the text says why */
    SC_HDF5_MISSING,    /**< it does not hold what is wanted; the text says what it holds */
    SC_HDF5_LIMIT       /**< a limit of memory is in the way; the text says which */
} sc_hdf5_kind;

/** How a voxel is stored in the stream. */
typedef enum sc_hdf5_type {
    SC_HDF5_INT8,
    SC_HDF5_UINT8,
    SC_HDF5_INT16,
    SC_HDF5_UINT16,
    SC_HDF5_INT32,
    SC_HDF5_UINT32,
    SC_HDF5_INT64,
    SC_HDF5_UINT64,
    SC_HDF5_FLOAT,
    SC_HDF5_DOUBLE,
    SC_HDF5_TYPES /**< how many there are */
} sc_hdf5_type;

/** What is known of a volume: bits. */
enum {
    SC_HDF5_ONLY = 1,     /**< nobody named the dataset; it is the only one that fits */
    SC_HDF5_SPACED = 2,   /**< the file gives the spacing */
    SC_HDF5_ORIENTED = 4, /**< it says where left and front are */
    SC_HDF5_FLAGS = 7     /**< all of them */
};

/** The head of the stream. Numbers are in the byte order of the machine; there is no padding. */
typedef struct sc_hdf5_answer {
    char magic[SC_HDF5_MAGIC_BYTES]; /**< SC_HDF5_MAGIC */
    uint32_t kind;                   /**< a sc_hdf5_kind; what follows is 0 but for a volume */
    uint32_t text_bytes;             /**< of the text behind this head, without a NUL byte */
    uint32_t type;                   /**< a sc_hdf5_type */
    uint32_t flags;                  /**< SC_HDF5_ONLY and so on */
    uint64_t size[3];                /**< voxels of the whole dataset along x (fastest), y, z */
    double to_ras_mm[3][4];          /**< from voxel indices to patient space, RAS mm */
    double slope, intercept;         /**< label = slope * stored + intercept */
} sc_hdf5_answer;

#endif
