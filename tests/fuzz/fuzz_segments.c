/* SPDX-License-Identifier: BSD-3-Clause */
/* The input is a list of changes to a valid segment (fuzz_patch) behind a byte: how much of its end
 * is cut off, in 1/255 of it. Length and hash are made to fit. What is accepted is joined to a
 * video. */
#include "fuzz.h"
#include "segcast/video.h"

enum { WIDTH = 32, HEIGHT = 24, FPS = 4, AT_BYTES = 16, HEAD_BYTES = 72 };

static sc_segment valid;

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    const sc_video_settings settings = {
        .width_px = WIDTH, .height_px = HEIGHT, .fps = FPS, .crf = 20, .preset = "fast"};
    sc_encoder *encoder;
    SC_OWN(sc_image_clear) sc_image image = {0};

    FUZZ_CHECK(sc_encoder_open(&fuzz_ctx, "v.mp4", &settings, &encoder) == SC_OK);
    FUZZ_CHECK(sc_image_init(&fuzz_ctx, WIDTH, HEIGHT, &image) == SC_OK);
    for (int k = 0; k < FPS; k++) {
        for (int i = 0; i < WIDTH * HEIGHT * 3; i++)
            image.rgb[i] = (uint8_t)(i * (k + 3) / 7);
        FUZZ_CHECK(sc_encoder_push(&fuzz_ctx, encoder, sc_encoder_convert(encoder, &image),
                                   sc_image_hash(&image)) == SC_OK);
    }
    FUZZ_CHECK(sc_encoder_finish(&fuzz_ctx, encoder, 99, 0, &valid) == SC_OK);
    sc_encoder_close(encoder);
    return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const fuzz_region regions[] = {{AT_BYTES, HEAD_BYTES - AT_BYTES},
                                   {HEAD_BYTES, FPS * 8 + 128},
                                   {AT_BYTES, valid.bytes - AT_BYTES}};
    sc_segment forged = {malloc(valid.bytes), valid.bytes};
    const char *path = fuzz_path("v.mp4");
    sc_segment_info info;
    sc_muxer *muxer;
    uint64_t hash;

    FUZZ_CHECK(forged.data);
    memcpy(forged.data, valid.data, valid.bytes);
    if (size) {
        const uint64_t bytes = valid.bytes - (valid.bytes - HEAD_BYTES) * data[0] / 255;

        forged.bytes = bytes;
        if (data[0])
            memcpy((char *)forged.data + AT_BYTES, &bytes, sizeof bytes);
        fuzz_patch(forged.data, regions, SC_COUNT_OF(regions), data + 1, size - 1);
    }
    hash = sc_hash_bytes((char *)forged.data + 16, forged.bytes - 16, 0);
    memcpy((char *)forged.data + 8, &hash, sizeof hash);
    if (sc_segment_inspect(&forged, &info)) {
        FUZZ_CHECK(info.first_frame >= 0 && info.width_px > 0 && info.height_px > 0);
        FUZZ_CHECK(info.frame_count >= 1 && info.frame_count <= info.fps);
        FUZZ_CHECK(sc_muxer_open(&fuzz_ctx, path, &(sc_video_settings){.title = NULL}, &muxer) ==
                   SC_OK);
        if (sc_muxer_add(&fuzz_ctx, muxer, &forged) == SC_OK &&
            sc_muxer_finish(&fuzz_ctx, muxer, path, true) == SC_OK)
            unlink(path);
        sc_muxer_close(muxer);
    }
    free(forged.data);
    return 0;
}
