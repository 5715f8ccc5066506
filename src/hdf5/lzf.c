/* SPDX-License-Identifier: BSD-3-Clause */
/* The filter LZF, which the HDF5 library itself has not, but h5py writes. Source of the format:
 * LibLZF (Marc Lehmann), the comments of lzf_d.c; the filter: h5py's lzf_filter.c, whose parameters
 * are two versions and the bytes of a chunk. */
#include "program.h"

#include <stdlib.h>
#include <string.h>

enum { LZF = 32000, LITERALS = 32, LONG = 7, LENGTH_SHIFT = 5, CHUNK_BYTES = 2 };

/* Unpack LZF: a byte below 32 is followed by one more bytes than it says; of another, the upper 3
 * bits are a length, 7 with one more byte, and the lower 5 with the next byte how far back to copy
 * from. @return how many bytes there are; 0 if the input is damaged, or has more than @p room. */
static size_t unpack(const unsigned char *in, size_t count, unsigned char *out, size_t room)
{
    const unsigned char *const end = in + count;
    size_t used = 0;

    while (in < end) {
        const unsigned control = *in++;
        size_t length = control >> LENGTH_SHIFT, back;

        if (control < LITERALS) {
            length = (size_t)control + 1;
            if ((size_t)(end - in) < length || room - used < length)
                return 0;
            memcpy(out + used, in, length);
            in += length;
            used += length;
            continue;
        }
        if (length == LONG)
            length += in < end ? *in++ : 0;
        length += 2;
        if (in == end)
            return 0;
        back = ((size_t)(control % LITERALS) << 8) + *in++ + 1;
        if (back > used || room - used < length)
            return 0;
        for (size_t i = 0; i < length; i++, used++) /* it may copy what it has just written */
            out[used] = out[used - back];
    }
    return used;
}

/* H5Z_func_t. @return the bytes of the chunk; 0: failure. */
static size_t filter(unsigned flags, size_t count, const unsigned values[], size_t bytes,
                     size_t *buffer_bytes, void **buffer)
{
    const size_t room = count > CHUNK_BYTES ? values[CHUNK_BYTES] : 0;
    void *out;
    size_t used;

    if (!(flags & H5Z_FLAG_REVERSE) || room == 0)
        return 0;
    out = H5allocate_memory(room, true);
    used = out ? unpack(*buffer, bytes, out, room) : 0;
    if (used < room) { /* the library would read on behind it */
        H5free_memory(out);
        return 0;
    }
    H5free_memory(*buffer);
    *buffer = out;
    *buffer_bytes = room;
    return used;
}

bool register_lzf(void)
{
    static const H5Z_class2_t lzf = {.version = H5Z_CLASS_T_VERS,
                                     .id = LZF,
                                     .decoder_present = 1,
                                     .name = "LZF",
                                     .filter = filter};

    return H5Zregister(&lzf) >= 0;
}
