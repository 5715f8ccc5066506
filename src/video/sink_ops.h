/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to video: the table each kind of sink fills in. */
#ifndef SC_VIDEO_SINK_OPS_H
#define SC_VIDEO_SINK_OPS_H

#include "segcast/video.h"

typedef struct sc_sink_ops {
    sc_status (*push)(const sc_ctx *ctx, sc_sink *sink, int k, const sc_image *image);
    sc_status (*finish)(const sc_ctx *ctx, sc_sink *sink, bool complete);
    void (*close)(sc_sink *sink);
} sc_sink_ops;

/* First member of every sink's struct. */
struct sc_sink {
    const sc_sink_ops *ops;
};

#endif
