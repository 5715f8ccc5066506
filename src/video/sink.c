/* SPDX-License-Identifier: BSD-3-Clause */
#include "internal.h"

sc_status sc_sink_push(const sc_ctx *ctx, sc_sink *sink, int k, const sc_image *image)
{
    return sink->ops->push(ctx, sink, k, image);
}

sc_status sc_sink_finish(const sc_ctx *ctx, sc_sink *sink, bool complete)
{
    return sink->ops->finish(ctx, sink, complete);
}

void sc_sink_close(sc_sink *sink)
{
    if (sink)
        sink->ops->close(sink);
}
