/* SPDX-License-Identifier: BSD-3-Clause */
/* The functions of libav that video calls, in one table: all that segcast-libav.so holds. */
#include "libav.h"

const sc_libav sc_libav_functions = {.bytes = sizeof(sc_libav),
                                     .av = LIBAVFORMAT_VERSION_INT,
                                     .av_codec = LIBAVCODEC_VERSION_INT,
#define ENTRY(name) .name = (name),
                                     SC_LIBAV_FUNCTIONS(ENTRY) SC_LIBAVFILTER_FUNCTIONS(ENTRY)
#undef ENTRY
};
