/* SPDX-License-Identifier: BSD-3-Clause */
/* The functions of libav, or of libavfilter, that video calls, in one table each: all that
 * segcast-libav.so and segcast-libavfilter.so hold. */
#include "libav.h"

#define ENTRY(name) .name = (name),
#ifndef SC_FILTERS_ALONE
const sc_libav sc_libav_functions = {.bytes = sizeof(sc_libav),
                                     .av = LIBAVFORMAT_VERSION_INT,
                                     .av_codec = LIBAVCODEC_VERSION_INT,
                                     SC_LIBAV_FUNCTIONS(ENTRY)};
#endif
#ifndef SC_FILTERS_APART
const sc_libavfilter sc_libavfilter_functions = {.bytes = sizeof(sc_libavfilter),
                                                 .av = LIBAVFILTER_VERSION_INT,
                                                 SC_LIBAVFILTER_FUNCTIONS(ENTRY)};
#endif
