/* SPDX-License-Identifier: BSD-3-Clause */
/* Videos are written and decoded again; number of frames, size, times and colours are compared. And
 * the files that remain when a video is not finished. */
#include "check.h"

#include "segcast/video.h"

#include <malloc.h>
#include <pthread.h>
#include <sys/stat.h>
#include <unistd.h>

enum { FRAMES = 45 };

/* A grey ramp above four patches of known colour, with a black bar at the bottom that moves with k.
 */
static sc_image test_picture(int width, int height, int k)
{
    static const uint8_t colors[4][3] = {
        {200, 30, 40}, {40, 180, 60}, {50, 60, 200}, {250, 240, 90}};
    sc_image image;

    assert_ok(sc_image_init(&quiet, width, height, &image));
    for (int y = 0; y < height; y++) {
        for (int x = 0; x < width; x++) {
            uint8_t *p = image.rgb + ((size_t)y * (size_t)width + (size_t)x) * 3;

            if (y < height / 2)
                memset(p, 255 * x / width, 3);
            else
                memcpy(p, colors[4 * x / width], 3);
            if (y > height - 8 && x / 4 == k)
                memset(p, 0, 3);
        }
    }
    return image;
}

typedef struct decoded {
    int count, width, height;
    int largest_error; /* largest error of all colours compared, in levels of 8 bits */
} decoded;

static sc_status compare_frame(void *user, int k, double time_s, const sc_image *image)
{
    decoded *d = user;
    SC_OWN(sc_image_clear) sc_image want = test_picture(image->width_px, image->height_px, k);

    assert_near(time_s, k / 24.0, 5.1e-3); /* as sc_video_time_error_s says of GIF */
    d->count = k + 1;
    d->width = image->width_px;
    d->height = image->height_px;
    /* Only the middle of each patch is compared: chroma is stored at half the resolution. */
    for (int patch = 0; patch < 4; patch++) {
        const int x = (2 * patch + 1) * image->width_px / 8, y = 3 * image->height_px / 4;
        const size_t at = ((size_t)y * (size_t)image->width_px + (size_t)x) * 3;

        for (int c = 0; c < 3; c++) {
            const int step = abs(image->rgb[at + (size_t)c] - want.rgb[at + (size_t)c]);

            d->largest_error = step > d->largest_error ? step : d->largest_error;
        }
    }
    return SC_OK;
}

/* A video of each kind. */
typedef struct kind {
    const char *name;
    sc_codec codec;
} kind;
static const kind kinds[] = {
    {"v.mp4", SC_CODEC_AUTO},  {"v.mkv", SC_CODEC_AUTO}, {"v.webm", SC_CODEC_AUTO},
    {"v.mov", SC_CODEC_AUTO},  {"v.mp4", SC_CODEC_H265}, {"v.mkv", SC_CODEC_H265},
    {"v.mov", SC_CODEC_H265},  {"v.mp4", SC_CODEC_AV1},  {"v.mkv", SC_CODEC_AV1},
    {"v.webm", SC_CODEC_AV1},  {"v.mkv", SC_CODEC_VP9},  {"v.mov", SC_CODEC_H264},
    {"v.webp", SC_CODEC_AUTO}, {"v.gif", SC_CODEC_AUTO}};

/* @return whether this libavcodec can encode it; says so if not. */
static bool can_encode(const kind *k)
{
    const bool can = sc_video_check_encoder(&quiet, k->name, k->codec) == SC_OK;

    if (!can)
        print_message("not tested: no encoder of %s\n", sc_video_codec_name(k->name, k->codec));
    return can;
}

/* Which sizes libav takes is known without it: those of av_image_check_size. */
TEST(sizes_are_those_of_libav)
{
    assert_true(sc_video_size_ok("a.mp4", 16384, 16128));
    assert_false(sc_video_size_ok("a.mp4", 16384, 16129)); /* becomes even */
    assert_true(sc_video_size_ok("a.mp4", 16129, 16382));
    assert_false(sc_video_size_ok("a.mp4", 16385, 64));
}

static void write_kind(const char *path, sc_codec codec, int width, int height, int frames,
                       bool complete)
{
    const sc_video_settings settings = {.width_px = width,
                                        .height_px = height,
                                        .fps = 24,
                                        .codec = codec,
                                        .crf = 16,
                                        .preset = "fast"};
    sc_video_writer *writer;

    assert_ok(sc_video_writer_open(&quiet, path, &settings, &writer));
    for (int k = 0; k < frames; k++) {
        SC_OWN(sc_image_clear) sc_image image = test_picture(width, height, k);

        assert_ok(sc_video_writer_push(&quiet, writer, &image));
    }
    assert_ok(sc_video_writer_finish(&quiet, writer, complete, true));
    sc_video_writer_close(writer);
}

static void write_video(const char *path, int width, int height, int frames, bool complete)
{
    write_kind(path, SC_CODEC_AUTO, width, height, frames, complete);
}

static const sc_video_settings untitled = {.title = NULL};

TEST(every_container_decodes_to_what_was_pushed)
{
    for (size_t i = 0; i < SC_COUNT_OF(kinds); i++) {
        const char *name = kinds[i].name;
        decoded d = {0};

        if (!can_encode(&kinds[i]))
            continue;
        write_kind(name, kinds[i].codec, 192, 120, FRAMES, true);
        assert_ok(sc_video_decode(&quiet, name, compare_frame, &d));
        assert_int_equal(d.count, FRAMES);
        assert_int_equal(d.width, 192);
        if (d.largest_error > 12)
            fail_msg("%s of %s: a colour differs by %d levels, at most 12 are allowed", name,
                     sc_video_codec_name(name, kinds[i].codec), d.largest_error);
        unlink(name);
    }
}

/* The alpha of pixel @p i of frame @p k of the transparent film, of 64 x 48 pixels: dots, half
 * transparent, empty. */
static uint8_t alpha_of(int i, int k)
{
    const int x = i % 64, y = i / 64;

    return x < 32 ? (x * x + 3 * y * y + x * y + k) % 7 < 3 ? 0 : 255 : x < 43 ? 100 : 0;
}

/* What a transparent film may lose, in levels. */
typedef struct alpha_check {
    int alpha, color; /* largest errors that are allowed */
    int count;        /* frames so far */
} alpha_check;

/* For sc_video_decode: compare a frame of the transparent film, and count it. */
static sc_status compare_alpha(void *user, int k, double time_s, const sc_image *image)
{
    alpha_check *check = user;

    assert_true(image->alpha);
    for (int i = 0; i < 64 * 48; i++) {
        const uint8_t *p = image->rgb + 4 * (size_t)i;
        const int alpha = alpha_of(i, k);

        assert_true(abs(p[3] - alpha) <= check->alpha);
        for (int c = 0; c < 3 && alpha; c++) /* nothing of what is transparent is mixed in */
            assert_true(abs(p[c] - (c == 0 ? 200 : 180 - 60 * c)) <= check->color);
    }
    check->count++;
    return SC_OK;
}

static void write_transparent(const char *path)
{
    const sc_video_settings settings = {
        .width_px = 64, .height_px = 48, .fps = 4, .crf = 1, .preset = "fast", .alpha = true};
    sc_video_writer *writer;
    SC_OWN(sc_image_clear) sc_image image = {0};

    assert_ok(sc_image_init_alpha(&quiet, 64, 48, true, &image));
    assert_ok(sc_video_writer_open(&quiet, path, &settings, &writer));
    for (int k = 0; k < 6; k++) {
        for (int i = 0; i < 64 * 48; i++) {
            const uint8_t alpha = alpha_of(i, k);
            const uint8_t seen[4] = {200, 120, 60, alpha}, nothing[4] = {0, 0, 0, 0};

            memcpy(image.rgb + 4 * (size_t)i, alpha ? seen : nothing, 4);
        }
        assert_ok(sc_video_writer_push(&quiet, writer, &image));
    }
    assert_ok(sc_video_writer_finish(&quiet, writer, true, true));
    sc_video_writer_close(writer);
}

/* Each frame of an animated WebP says (bit 1 of the last byte of its head) that it is not laid over
 * the one before it; those of the film change in each. */
static void frames_replace_each_other(const char *path)
{
    enum { HEAD_BYTES = 8, FLAGS_AT = 15 };
    SC_OWN(sc_free_at) char *data = NULL;
    size_t bytes;
    int frames = 0;

    assert_ok(sc_file_read(&quiet, path, 1 << 24, &data, &bytes));
    for (size_t i = 0; i + HEAD_BYTES + FLAGS_AT < bytes; i++) {
        if (memcmp(data + i, "ANMF", 4) != 0)
            continue;
        assert_int_equal(data[i + HEAD_BYTES + FLAGS_AT], 2);
        frames++;
    }
    assert_int_equal(frames, 6);
}

/* What is transparent is black in the frames. */
TEST(a_transparent_film_keeps_its_alpha)
{
    static const struct {
        kind kind;
        int alpha, color;
    } cases[] = {{{"t.mov", SC_CODEC_AUTO}, 1, 6},
                 {{"t.webm", SC_CODEC_AUTO}, 12, 6},
                 {{"t.webp", SC_CODEC_AUTO}, 1, 12}};
    const sc_video_settings settings = {
        .width_px = 64, .height_px = 48, .fps = 4, .crf = 18, .preset = "fast", .alpha = true};
    sc_encoder *encoder;

    for (size_t i = 0; i < SC_COUNT_OF(cases); i++) {
        alpha_check check = {cases[i].alpha, cases[i].color, 0};

        if (!can_encode(&cases[i].kind))
            continue;
        write_transparent(cases[i].kind.name);
        assert_ok(sc_video_decode(&quiet, cases[i].kind.name, compare_alpha, &check));
        assert_int_equal(check.count, 6);
        if (!strcmp(cases[i].kind.name, "t.webp"))
            frames_replace_each_other(cases[i].kind.name);
        unlink(cases[i].kind.name);
    }
    assert_int_equal(sc_encoder_open(&quiet, "t.mp4", &settings, &encoder), SC_ERR_USAGE);
}

/* The encoder gets no black where nothing is seen: rows have one lightness, and so have rows
 * without tissue above and below. Planes are of 16 bits, that of the lightness first. */
TEST(what_is_transparent_has_the_colour_beside_it)
{
    const sc_video_settings settings = {
        .width_px = 64, .height_px = 48, .fps = 4, .crf = 18, .preset = "fast", .alpha = true};
    sc_encoder *encoder;
    SC_OWN(sc_image_clear) sc_image image = {0};
    const char *picture;
    uint16_t first, other;

    assert_ok(sc_image_init_alpha(&quiet, 64, 48, true, &image));
    memset(image.rgb, 0, sc_image_bytes(&image));
    for (int i = 64 * 10; i < 64 * 30; i++) {
        const uint8_t seen[4] = {200, 120, 60, 255};

        if (i % 64 >= 20 && i % 64 < 30)
            memcpy(image.rgb + 4 * (size_t)i, seen, 4);
    }
    assert_ok(sc_encoder_open(&quiet, "t.mov", &settings, &encoder));
    picture = sc_encoder_convert(encoder, &image);
    assert_int_equal(sc_picture_bytes("t.mov", &settings), 64 * 48 * 2 * 4);
    memcpy(&first, picture, 2);
    assert_in_range(first, 400, 700); /* of 10 bits; black is 64 */
    for (size_t i = 1; i < 64 * 48; i++) {
        memcpy(&other, picture + 2 * i, 2);
        assert_int_equal(other, first);
    }
    sc_encoder_close(encoder);
}

/* Keep the number of a frame of 64 x 64 pixels, and compare it with what was pushed. */
typedef struct picked {
    int numbers[8], count;
} picked;

static sc_status pick_frame(void *user, int k, double time_s, const sc_image *image)
{
    picked *p = user;
    decoded d = {.count = k};

    assert_ok(compare_frame(&d, k, time_s, image));
    assert_true(d.largest_error <= 12);
    p->numbers[p->count++] = k;
    return SC_OK;
}

/* Frames that begin a GOP and others, near and far, the first and the last; those beyond are left
 * out. */
TEST(single_frames_are_found)
{
    static const int wanted[] = {0, 5, 24, 71, 99, 100, 150};

    for (size_t i = 0; i < SC_COUNT_OF(kinds); i++) {
        picked p = {.count = 0};

        if (!can_encode(&kinds[i]))
            continue;
        write_kind(kinds[i].name, kinds[i].codec, 192, 120, 100, true);
        assert_ok(sc_video_pick(&quiet, kinds[i].name, 24, wanted, 7, pick_frame, &p));
        assert_int_equal(p.count, 5);
        assert_memory_equal(p.numbers, wanted, 5 * sizeof(int));
        unlink(kinds[i].name);
    }
    {
        picked p = {.count = 0};

        assert_int_equal(sc_video_pick(&quiet, "nowhere.mp4", 24, wanted, 7, pick_frame, &p),
                         SC_ERR_MISSING);
    }
}

TEST(odd_sizes_are_padded_not_scaled)
{
    decoded d = {0};

    write_video("v.mp4", 191, 119, 3, true);
    assert_ok(sc_video_decode(&quiet, "v.mp4", compare_frame, &d));
    assert_int_equal(d.width, 192);
    assert_int_equal(d.height, 120);
    unlink("v.mp4");
}

/* Let malloc fill fresh memory with @p byte (0: not at all), so that a read of uninitialised memory
 * changes the bytes of a video. */
static void fill_fresh_memory(int byte)
{
#ifdef __GLIBC__
    mallopt(M_MMAP_THRESHOLD, 1 << 30);
    mallopt(M_PERTURB, byte);
#else
#endif
}

/* Two videos of the same frames, with @p codec, are the same byte for byte; that they hold their
 * index, in MP4, is left to the caller. @return the bytes, of sc_file_read. */
static char *equal_bytes(const kind *of, size_t *bytes)
{
    char *a, *b;
    size_t b_bytes;

    fill_fresh_memory(85);
    write_kind(of->name, of->codec, 192, 120, FRAMES, true);
    assert_ok(sc_file_read(&quiet, of->name, 1 << 26, &a, bytes));
    fill_fresh_memory(170);
    write_kind(of->name, of->codec, 192, 120, FRAMES, true);
    fill_fresh_memory(0);
    assert_ok(sc_file_read(&quiet, of->name, 1 << 26, &b, &b_bytes));
    assert_int_equal(*bytes, b_bytes);
    assert_memory_equal(a, b, b_bytes);
    sc_free(b);
    unlink(of->name);
    return a;
}

TEST_OF_THREADS(equal_frames_give_equal_bytes_and_the_index_comes_first)
{
    for (size_t i = 0; i < SC_COUNT_OF(kinds); i++) {
        size_t bytes, moov = 0, mdat = 0;
        SC_OWN(sc_free_at) char *video = NULL;

        if (!can_encode(&kinds[i]))
            continue;
        video = equal_bytes(&kinds[i], &bytes);
        for (size_t at = 0; at + 4 < bytes; at++) {
            moov = !moov && !memcmp(video + at, "moov", 4) ? at : moov;
            mdat = !mdat && !memcmp(video + at, "mdat", 4) ? at : mdat;
        }
        if (!strcmp(kinds[i].name, "v.mp4"))
            assert_true(moov && mdat && moov < mdat);
    }
}

static bool exists(const char *path)
{
    struct stat info;

    return !stat(path, &info);
}

TEST(an_unfinished_video_never_bears_the_final_name)
{
    const sc_video_settings settings = {
        .width_px = 64, .height_px = 64, .fps = 24, .crf = 16, .preset = "fast"};
    decoded d = {0};
    sc_video_writer *writer;
    SC_OWN(sc_image_clear) sc_image image = test_picture(64, 64, 0);

    assert_ok(sc_video_writer_open(&quiet, "w.mp4", &settings, &writer));
    assert_ok(sc_video_writer_push(&quiet, writer, &image));
    assert_false(exists("w.mp4"));
    sc_video_writer_close(writer);
    assert_false(exists("w.mp4"));
    write_video("w.mp4", 192, 120, 5, false);
    assert_false(exists("w.mp4"));
    assert_ok(sc_video_decode(&quiet, "w.partial.mp4", compare_frame, &d));
    assert_int_equal(d.count, 5);
    unlink("w.partial.mp4");
    write_video("w.mp4", 192, 120, 3, true); /* a partial video must not replace a complete one */
    write_video("w.mp4", 192, 120, 5, false);
    assert_ok(sc_video_decode(&quiet, "w.mp4", compare_frame, &d));
    assert_int_equal(d.count, 3);
    unlink("w.mp4");
    unlink("w.partial.mp4");
    assert_int_equal(sc_video_writer_open(&quiet, "no/such/w.mp4", &settings, &writer),
                     SC_ERR_CREATE);
    assert_int_equal(sc_video_writer_open(&quiet, "w.avi", &settings, &writer), SC_ERR_USAGE);
}

/* Two GOPs that are encoded by two encoders, the second one first, join to the same video that one
 * encoder writes. */
static void join_gops(const kind *of)
{
    const sc_video_settings settings = {.width_px = 192,
                                        .height_px = 120,
                                        .fps = 24,
                                        .codec = of->codec,
                                        .crf = 16,
                                        .preset = "fast"};
    const char *name = of->name;
    const int gop_frames = sc_video_gop_frames(&settings);
    sc_segment segments[2];
    sc_segment_info info;
    sc_encoder *encoder;
    sc_muxer *muxer;
    char *a, *b;
    size_t a_bytes, b_bytes;

    for (int g = 1; g >= 0; g--) {
        assert_ok(sc_encoder_open(&quiet, name, &settings, &encoder));
        for (int k = g * gop_frames; k < (g + 1) * gop_frames && k < FRAMES; k++) {
            SC_OWN(sc_image_clear) sc_image image = test_picture(192, 120, k);

            assert_ok(
                sc_encoder_push(&quiet, encoder, sc_encoder_convert(encoder, &image), (uint64_t)k));
        }
        assert_ok(sc_encoder_finish(&quiet, encoder, 7, g * gop_frames, &segments[g]));
        sc_encoder_close(encoder);
        assert_true(sc_segment_inspect(&segments[g], &info));
        assert_int_equal(info.identity, 7);
        assert_int_equal(info.first_frame, g * gop_frames);
        assert_int_equal(info.frame_count, g ? FRAMES - gop_frames : gop_frames);
    }
    assert_ok(sc_muxer_open(&quiet, name, &settings, &muxer));
    assert_ok(sc_muxer_add(&quiet, muxer, &segments[0]));
    assert_ok(sc_muxer_add(&quiet, muxer, &segments[1]));
    assert_false(exists(name));
    assert_ok(sc_muxer_finish(&quiet, muxer, name, true));
    sc_muxer_close(muxer);
    assert_ok(sc_file_read(&quiet, name, 1 << 26, &a, &a_bytes));
    write_kind(name, of->codec, 192, 120, FRAMES, true);
    assert_ok(sc_file_read(&quiet, name, 1 << 26, &b, &b_bytes));
    assert_int_equal(a_bytes, b_bytes);
    assert_memory_equal(a, b, a_bytes);
    sc_free(a);
    sc_free(b);
    unlink(name);
    for (int g = 0; g < 2; g++)
        sc_segment_free(&segments[g]);
}

TEST(separately_encoded_gops_join_to_the_same_bytes)
{
    for (size_t i = 0; i < SC_COUNT_OF(kinds); i++) {
        if (can_encode(&kinds[i]))
            join_gops(&kinds[i]);
    }
}

TEST(a_damaged_segment_is_refused)
{
    const sc_video_settings settings = {
        .width_px = 64, .height_px = 64, .fps = 24, .crf = 16, .preset = "fast"};
    SC_OWN(sc_image_clear) sc_image image = test_picture(64, 64, 3);
    sc_segment segment, shorter;
    sc_segment_info info;
    sc_encoder *encoder;
    sc_muxer *muxer;

    assert_ok(sc_encoder_open(&quiet, "t.webm", &settings, &encoder));
    assert_ok(sc_encoder_push(&quiet, encoder, sc_encoder_convert(encoder, &image), 1));
    assert_ok(sc_encoder_finish(&quiet, encoder, 0, 0, &segment));
    sc_encoder_close(encoder);
    assert_true(sc_segment_inspect(&segment, &info));
    for (size_t at = 0; at < segment.bytes; at += 1 + at / 9) {
        ((char *)segment.data)[at] ^= 64;
        assert_false(sc_segment_inspect(&segment, &info));
        ((char *)segment.data)[at] ^= 64;
        shorter = (sc_segment){segment.data, at};
        assert_false(sc_segment_inspect(&shorter, &info));
    }
    ((char *)segment.data)[segment.bytes / 2] ^= 1;
    assert_ok(sc_muxer_open(&quiet, "t.webm", &untitled, &muxer));
    assert_int_equal(sc_muxer_add(&quiet, muxer, &segment), SC_ERR_DATA);
    sc_muxer_close(muxer);
    assert_false(exists("t.webm"));
    sc_segment_free(&segment);
}

/* Encode a second of large frames on a thread: glibc gives it an arena of its own, in which large
 * blocks soon find no room; malloc then sets errno, and succeeds with another arena. The writer
 * must not take that for a lack of memory. @param user sc_status: the first error. */
static void *write_large(void *user)
{
    const sc_video_settings settings = {
        .width_px = 1920, .height_px = 1080, .fps = 24, .crf = 16, .preset = "fast"};
    sc_status *status = user;
    SC_OWN(sc_image_clear) sc_image image = test_picture(settings.width_px, settings.height_px, 0);
    sc_video_writer *writer = NULL;

    *status = sc_video_writer_open(&quiet, "large.mp4", &settings, &writer);
    for (int k = 0; k < 25 && *status == SC_OK; k++)
        *status = sc_video_writer_push(&quiet, writer, &image);
    if (*status == SC_OK)
        *status = sc_video_writer_finish(&quiet, writer, true, true);
    sc_video_writer_close(writer);
    return NULL;
}

TEST_OF_THREADS(large_frames_are_encoded_on_any_thread)
{
    pthread_t thread;
    sc_status written = SC_ERR_INTERNAL;

    assert_int_equal(pthread_create(&thread, NULL, write_large, &written), 0);
    assert_int_equal(pthread_join(thread, NULL), 0);
    assert_ok(written);
    unlink("large.mp4");
}

RUN_TESTS(NULL, NULL)
