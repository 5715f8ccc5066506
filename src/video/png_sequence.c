/* SPDX-License-Identifier: BSD-3-Clause */
#include "internal.h"

typedef struct png_sink {
    sc_sink base;
    char *directory;
} png_sink;

static sc_status png_push(const sc_ctx *ctx, sc_sink *base, int k, const sc_image *image)
{
    const png_sink *sink = (const png_sink *)base;
    sc_text path = {0};
    sc_status status = sc_text_add(ctx, &path, "%s/%06d.png", sink->directory, k);

    if (status == SC_OK)
        status = sc_image_save_png(ctx, image, path.data);
    sc_text_clear(&path);
    return status;
}

static sc_status png_finish(const sc_ctx *ctx, sc_sink *base, bool complete)
{
    (void)ctx;
    (void)base;
    (void)complete;
    return SC_OK; /* every frame is already in place */
}

static void png_close(sc_sink *base)
{
    sc_free(((png_sink *)base)->directory);
    sc_free(base);
}

static const sc_sink_ops png_ops = {.push = png_push, .finish = png_finish, .close = png_close};

sc_status sc_sink_open_png(const sc_ctx *ctx, const char *directory, sc_sink **out)
{
    png_sink *sink = NULL;
    sc_text copy = {0};
    void *block = NULL;
    sc_status status;

    SC_TRY(sc_make_directory(ctx, directory));
    SC_TRY(sc_zalloc(ctx, 1, sizeof *sink, &block));
    sink = block;
    SC_TRY(sc_text_add(ctx, &copy, "%s", directory));
    *sink = (png_sink){.base = {.ops = &png_ops}, .directory = copy.data};
    *out = &sink->base;
    return SC_OK;
out:
    sc_free(block);
    return status;
}
