/* SPDX-License-Identifier: BSD-3-Clause */
/* What stands in a directory is judged by its contents, also where its checksums are right: forged
 * segments, partial GOPs and manifests are refused, and nothing is touched outside the directory.
 */
#include "check.h"

#include "../../src/store/internal.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

enum { WIDTH = 32, HEIGHT = 24, FPS = 4, FRAMES = 6 };

static const sc_video_settings untitled = {.title = NULL};

static const sc_video_settings settings = {
    .width_px = WIDTH, .height_px = HEIGHT, .fps = FPS, .crf = 20, .preset = "fast"};
static char folder[sizeof "/dev/shm/segcast-store-XXXXXX"];
static const int all_frames[FRAMES] = {0, 1, 2, 3, 4, 5};

/* The job of all tests. */
static sc_store_job make_job(void)
{
    return (sc_store_job){.version = "1.2",
                          .job_hash = 17,
                          .volume_hash = 4,
                          .frames = FRAMES,
                          .video = "v.mp4",
                          .png = true,
                          .settings = settings,
                          .threads = 1};
}

/* Remove the folder with all that is in it, and make it anew. */
static void empty_folder(void)
{
    char command[128];

    snprintf(command, sizeof command, "rm -rf %s && mkdir %s", folder, folder);
    assert_int_equal(system(command), 0);
}

/* "FOLDER/NAME" in static memory. */
static const char *in_folder(const char *name)
{
    static char paths[4][512];
    static int next;
    char *path = paths[next++ % 4];

    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

static sc_image make_picture(int k)
{
    sc_image image;

    assert_ok(sc_image_init(&quiet, WIDTH, HEIGHT, &image));
    for (int i = 0; i < WIDTH * HEIGHT * 3; i++)
        image.rgb[i] = (uint8_t)(i * (k + 3) / 7);
    return image;
}

static sc_store *open_store(sc_store_mode mode)
{
    const sc_store_job job = make_job();
    sc_store *store;

    assert_ok(sc_store_open(&quiet, folder, &job, all_frames, FRAMES, NULL, mode, &store));
    return store;
}

/* Add the frames [first, end) that are not there, as rank 0 does. */
static void add_frames(sc_store *store, int first, int end)
{
    for (int k = first; k < end; k++) {
        SC_OWN(sc_image_clear) sc_image image = make_picture(k);
        const sc_done_frame done = {.frame = k, .hash = sc_image_hash(&image)};

        if (!sc_store_has(store, k))
            assert_ok(sc_store_add_frame(&quiet, store, &done, &image));
    }
}

/* Write the records, finish and seal. */
static void finish(sc_store *store)
{
    static const char *const records[] = {"status.json", "stats.json", "frames.csv", "trace.json",
                                          "report.html"};
    int missing;

    assert_ok(sc_store_write_job(&quiet, store, "job.yaml", 8));
    assert_ok(sc_store_finish(&quiet, store, &missing));
    assert_int_equal(missing, 0);
    for (size_t i = 0; i < SC_COUNT_OF(records); i++)
        assert_ok(sc_file_write(&quiet, in_folder(records[i]), records[i], strlen(records[i])));
    assert_ok(sc_store_seal(&quiet, store));
    sc_store_close(store);
}

/* Draw the job into the emptied folder. */
static void make_finished(void)
{
    sc_store *store;

    empty_folder();
    store = open_store(SC_STORE_NEW);
    add_frames(store, 0, FRAMES);
    finish(store);
}

/* Write a file without flushing it to disk, which sc_file_write does and takes long. */
static void write_quickly(const char *path, const void *data, size_t bytes)
{
    FILE *stream = fopen(path, "wb");

    assert_non_null(stream);
    assert_int_equal(fwrite(data, 1, bytes, stream), bytes);
    assert_int_equal(fclose(stream), 0);
}

static char *read_all(const char *path, size_t *bytes)
{
    char *data;

    assert_ok(sc_file_read(&quiet, path, (size_t)1 << 30, &data, bytes));
    return data;
}

/* ---- segments ---- */

static sc_segment make_segment(int first)
{
    sc_encoder *encoder;
    sc_segment segment;

    assert_ok(sc_encoder_open(&quiet, "v.mp4", &settings, &encoder));
    for (int k = first; k < first + FPS; k++) {
        SC_OWN(sc_image_clear) sc_image image = make_picture(k);

        assert_ok(sc_encoder_push(&quiet, encoder, sc_encoder_convert(encoder, &image),
                                  sc_image_hash(&image)));
    }
    assert_ok(sc_encoder_finish(&quiet, encoder, 99, first, &segment));
    sc_encoder_close(encoder);
    return segment;
}

/* Make the hash in the head of a segment that of its bytes. */
static void repair(sc_segment *segment)
{
    const uint64_t hash = sc_hash_bytes((char *)segment->data + 16, segment->bytes - 16, 0);

    memcpy((char *)segment->data + 8, &hash, sizeof hash);
}

/* Where the numbers of the head lie in a segment: those of 32 bits from codec_id on. */
enum { AT_BYTES = 16, AT_CODEC = 36, AT_EXTRADATA = 68, HEAD_BYTES = 72 };

TEST(forged_segments)
{
    static const int32_t values[] = {INT32_MIN, -1, 0, 1, 3, 5, 17, 255, 1 << 16, INT32_MAX};
    sc_segment good = make_segment(0), forged;
    sc_segment_info info;

    assert_true(sc_segment_inspect(&good, &info));
    assert_int_equal(info.fps, FPS);
    assert_int_equal(info.width_px, WIDTH);
    forged = (sc_segment){malloc(good.bytes), good.bytes};
    for (size_t at = AT_CODEC; at <= AT_EXTRADATA; at += 4) {
        for (size_t i = 0; i < SC_COUNT_OF(values); i++) {
            int32_t old;

            memcpy(forged.data, good.data, good.bytes);
            memcpy(&old, (char *)forged.data + at, 4);
            memcpy((char *)forged.data + at, &values[i], 4);
            repair(&forged);
            if (!sc_segment_inspect(&forged, &info) || values[i] == old)
                continue;
            /* What is accepted is within range; the store compares it with the job. */
            assert_true(info.frame_count == FPS && info.fps >= FPS && info.first_frame >= 0);
            assert_true(info.width_px > 0 && info.height_px > 0);
        }
    }
    free(forged.data);
    sc_segment_free(&good);
}

/* The bits of a parameter set of H.264, written one after the other. */
typedef struct bits {
    uint8_t bytes[64];
    int count;
} bits;

static void put_bit(bits *b, int bit)
{
    b->bytes[b->count / 8] |= (uint8_t)(bit << (7 - b->count % 8));
    b->count++;
}

/* Append an unsigned Exp-Golomb number. */
static void put_golomb(bits *b, uint32_t number)
{
    const uint64_t code = (uint64_t)number + 1;
    int length = 0;

    while (code >> (length + 1))
        length++;
    for (int i = 0; i < length; i++)
        put_bit(b, 0);
    for (int i = length; i >= 0; i--)
        put_bit(b, (int)(code >> i & 1));
}

/* What a forged sequence parameter set says. */
typedef struct parameters {
    int type;        /* of the NAL unit: 7 is right */
    int profile;     /* 100: High */
    int scaling;     /* 1: a scaling matrix follows, which does not */
    uint32_t order;  /* pic_order_cnt_type: 0 to 2 */
    uint32_t cycle;  /* of type 1: how many offsets follow, which do not */
    bool no_picture; /* without a picture parameter set */
} parameters;

/* Write extradata of H.264 to out[128]: both parameter sets, each behind a start code. @return
 * their length in bytes. */
static size_t make_extradata(const parameters *p, uint8_t *out)
{
    static const uint8_t picture[] = {0, 0, 0, 1, 0x68, 0xeb, 0xe3, 0xcb, 0x22, 0xc0};
    uint8_t head[] = {0, 0, 0, 1, 0, 0, 0, 31};
    bits b = {.count = 0};
    size_t used = sizeof head;
    int zeros = 0;

    head[4] = (uint8_t)(0x60 | p->type);
    head[5] = (uint8_t)p->profile;
    memcpy(out, head, sizeof head);
    put_golomb(&b, 0); /* number of the set */
    if (p->profile == 100) {
        put_golomb(&b, 1); /* chroma format 4:2:0 */
        put_golomb(&b, 0); /* 8 bits, twice */
        put_golomb(&b, 0);
        put_bit(&b, 0);
        put_bit(&b, p->scaling);
    }
    put_golomb(&b, 0); /* log2 of the most frame numbers */
    put_golomb(&b, p->order);
    if (p->order == 1) {
        put_bit(&b, 0);
        put_golomb(&b, 0);
        put_golomb(&b, 0);
        put_golomb(&b, p->cycle);
    } else if (p->order == 0) {
        put_golomb(&b, 2);
    }
    put_golomb(&b, 3); /* reference frames */
    put_bit(&b, 0);    /* no gaps */
    put_golomb(&b, 1); /* 2 x 2 macroblocks */
    put_golomb(&b, 1);
    put_bit(&b, 1); /* frames */
    put_bit(&b, 1); /* direct_8x8_inference */
    put_bit(&b, 0); /* no cropping */
    put_bit(&b, 0); /* no VUI */
    put_bit(&b, 1); /* the end */
    for (int i = 0; i < (b.count + 7) / 8; i++) {
        if (zeros >= 2 && b.bytes[i] <= 3) { /* what would look like a start code */
            out[used++] = 3;
            zeros = 0;
        }
        zeros = b.bytes[i] ? 0 : zeros + 1;
        out[used++] = b.bytes[i];
    }
    if (!p->no_picture) {
        memcpy(out + used, picture, sizeof picture);
        used += sizeof picture;
    }
    return used;
}

/* A segment with other extradata than @p good. */
static sc_segment with_extradata(const sc_segment *good, const void *extradata, size_t bytes)
{
    const size_t before = HEAD_BYTES + FPS * 8;
    sc_segment out;
    uint32_t old, now = (uint32_t)bytes;
    uint64_t all;

    memcpy(&old, (char *)good->data + AT_EXTRADATA, sizeof old);
    all = good->bytes - old + bytes;
    out = (sc_segment){malloc(all), all};
    assert_non_null(out.data);
    memcpy(out.data, good->data, before);
    memcpy((char *)out.data + before, extradata, bytes);
    memcpy((char *)out.data + before + bytes, (char *)good->data + before + old,
           good->bytes - before - old);
    memcpy((char *)out.data + AT_BYTES, &all, sizeof all);
    memcpy((char *)out.data + AT_EXTRADATA, &now, sizeof now);
    repair(&out);
    return out;
}

/* Parameter sets that x264 does not write are refused: libavformat would read as many numbers as
 * they promise, for hours. */
TEST(forged_parameters)
{
    static const struct {
        parameters parameters;
        bool right;
    } cases[] = {
        {{7, 100, 0, 0, 0, false}, true},          {{7, 100, 0, 2, 0, false}, true},
        {{7, 66, 0, 2, 0, false}, true},           {{7, 77, 0, 0, 0, false}, true},
        {{7, 100, 0, 1, 100000000, false}, false}, {{7, 100, 0, 1, 0, false}, false},
        {{7, 66, 0, 1, 100000000, false}, false},  {{7, 100, 0, 3, 0, false}, false},
        {{7, 100, 1, 0, 0, false}, false},         {{7, 101, 0, 0, 0, false}, false},
        {{7, 100, 0, 0, 0, true}, false},          {{6, 100, 0, 0, 0, false}, false},
        {{8, 100, 0, 0, 0, false}, false},
    };
    SC_OWN(sc_segment_free) sc_segment good = make_segment(0);
    sc_segment_info info;

    for (size_t i = 0; i < SC_COUNT_OF(cases); i++) {
        uint8_t extradata[128];
        const size_t bytes = make_extradata(&cases[i].parameters, extradata);
        sc_segment forged = with_extradata(&good, extradata, bytes);

        if (sc_segment_inspect(&forged, &info) != cases[i].right)
            fail_msg("parameters %zu are %s", i, cases[i].right ? "refused" : "accepted");
        free(forged.data);
        /* Cut off anywhere, they are refused, or what is left of them is right. */
        for (size_t cut = 0; cut < bytes; cut++) {
            forged = with_extradata(&good, extradata, cut);
            if (sc_segment_inspect(&forged, &info) && !cases[i].right)
                fail_msg("the first %zu bytes of parameters %zu are accepted", cut, i);
            free(forged.data);
        }
    }
}

/* Segments with random changes and the right hash are refused, or joined, but never crash. */
TEST(random_segments)
{
    const char *rounds = getenv("SEGCAST_TEST_ROUNDS");
    const int count = rounds ? atoi(rounds) : 400;
    sc_segment good = make_segment(0), forged = {malloc(good.bytes), good.bytes};
    uint64_t seed = 4711;
    int accepted = 0;

    empty_folder();
    for (int i = 0; i < count; i++) {
        const int changes = 1 + (int)(random_bits(&seed) % 3);
        sc_muxer *muxer;
        sc_status status;

        memcpy(forged.data, good.data, good.bytes);
        forged.bytes = good.bytes;
        for (int k = 0; k < changes; k++) {
            const size_t within = random_bits(&seed) % 2 ? HEAD_BYTES + FPS * 8 + 80 : good.bytes;

            ((uint8_t *)forged.data)[16 + random_bits(&seed) % (within - 16)] =
                (uint8_t)random_bits(&seed);
        }
        if (i % 5 == 0) { /* cut, too, with the length in the head right */
            const uint64_t bytes = HEAD_BYTES + random_bits(&seed) % (good.bytes - HEAD_BYTES);

            memcpy((char *)forged.data + AT_BYTES, &bytes, sizeof bytes);
            forged.bytes = bytes;
        }
        repair(&forged);
        assert_ok(sc_muxer_open(&quiet, in_folder("v.mp4"), &untitled, &muxer));
        status = sc_muxer_add(&quiet, muxer, &forged);
        if (status == SC_OK)
            accepted += sc_muxer_finish(&quiet, muxer, in_folder("v.mp4"), true) == SC_OK;
        sc_muxer_close(muxer);
    }
    assert_true(accepted > 0 && accepted < count);
    free(forged.data);
    sc_segment_free(&good);
}

/* ---- partial GOPs ---- */

/* The path of the only file in segments/ that ends with @p ending. */
static void find_file(const char *ending, char path[512])
{
    FILE *stream;
    char command[256];

    snprintf(command, sizeof command, "ls %s/segments/*%s", folder, ending);
    stream = popen(command, "r");
    assert_non_null(stream);
    assert_non_null(fgets(path, 512, stream));
    path[strcspn(path, "\n")] = '\0';
    pclose(stream);
}

/* Draw two frames into the emptied folder, which stay in a partial GOP: the file @p path. */
static void make_partial(char path[512])
{
    sc_store *store;

    empty_folder();
    store = open_store(SC_STORE_NEW);
    add_frames(store, 0, 2);
    sc_store_close(store);
    find_file(".part", path);
}

/* Resume, give all frames, and check that the video becomes @p video, [@p bytes]. */
static void resume_to(const char *video, size_t bytes)
{
    sc_store *store = open_store(SC_STORE_RESUME);
    size_t found;
    SC_OWN(sc_free_at) char *again = NULL;

    add_frames(store, 0, FRAMES);
    finish(store);
    again = read_all(in_folder("v.mp4"), &found);
    assert_int_equal(found, bytes);
    assert_memory_equal(again, video, bytes);
}

/* Pictures with the right hash that are of no frame, or of another size, are not used; the result
 * has the same bytes. */
TEST(forged_pictures)
{
    static const int64_t values[] = {INT64_MIN, -1, 0, 1, 5, 6, 1 << 30, INT64_MAX};
    const size_t head_bytes = 48, picture = sc_picture_bytes("v.mp4", &settings);
    size_t bytes, video_bytes;
    char path[512], *part, *video;

    make_finished();
    video = read_all(in_folder("v.mp4"), &video_bytes);
    for (size_t at = 16; at < head_bytes; at += 8) {
        for (size_t i = at / 8 % 2; i < SC_COUNT_OF(values); i += 2) {
            uint64_t hash;

            make_partial(path);
            part = read_all(path, &bytes);
            assert_int_equal(bytes, 2 * (head_bytes + picture));
            memcpy(part + at, &values[i], 8);
            hash = sc_hash_bytes(part + 16, head_bytes - 16, 0);
            hash = sc_hash_bytes(part + head_bytes, picture, hash);
            memcpy(part + 8, &hash, 8);
            assert_ok(sc_file_write(&quiet, path, part, bytes));
            sc_free(part);
            resume_to(video, video_bytes);
        }
    }
    sc_free(video);
}

/* A file of pictures that another run has removed after this one found it ends this run, which can
 * be begun again. */
TEST(pictures_that_are_gone)
{
    sc_status status = SC_OK;
    sc_store *store;
    char path[512];

    make_partial(path);
    assert_int_equal(rename(path, in_folder("segments/000000.host.1.part")), 0);
    store = open_store(SC_STORE_RESUME);
    assert_int_equal(unlink(in_folder("segments/000000.host.1.part")), 0);
    for (int k = 2; k < FRAMES && status == SC_OK; k++) {
        SC_OWN(sc_image_clear) sc_image image = make_picture(k);
        const sc_done_frame done = {.frame = k, .hash = sc_image_hash(&image)};

        status = sc_store_add_frame(&quiet, store, &done, &image);
    }
    assert_int_equal(status, SC_ERR_INCOMPLETE);
    sc_store_close(store);
}

/* A picture in which a byte has changed is not used, wherever that byte is; the result has the same
 * bytes. */
TEST(damaged_pictures)
{
    const size_t head_bytes = 48, picture = sc_picture_bytes("v.mp4", &settings);
    const size_t places[] = {8,
                             15,
                             40,
                             head_bytes,
                             head_bytes + picture / 2,
                             head_bytes + picture - 1,
                             2 * head_bytes + 2 * picture - 1};
    size_t bytes, video_bytes;
    char path[512], *part, *video;

    make_finished();
    video = read_all(in_folder("v.mp4"), &video_bytes);
    for (size_t i = 0; i < SC_COUNT_OF(places); i++) {
        make_partial(path);
        part = read_all(path, &bytes);
        assert_int_equal(bytes, 2 * (head_bytes + picture));
        part[places[i]] ^= (char)0x80;
        assert_ok(sc_file_write(&quiet, path, part, bytes));
        sc_free(part);
        resume_to(video, video_bytes);
    }
    sc_free(video);
}

/* A process that has the number of one that was killed while it wrote does not append behind what
 * that one has left. */
TEST(torn_tail)
{
    sc_store *store;
    char path[512];
    struct stat info;

    make_partial(path);
    assert_int_equal(stat(path, &info), 0);
    assert_int_equal(truncate(path, info.st_size - 100), 0);
    store = open_store(SC_STORE_RESUME);
    assert_true(sc_store_has(store, 0));
    assert_false(sc_store_has(store, 1));
    add_frames(store, 1, 3);
    sc_store_close(store);
    store = open_store(SC_STORE_RESUME);
    for (int k = 0; k < 3; k++)
        assert_true(sc_store_has(store, k));
    sc_store_close(store);
}

/* ---- manifests ---- */

/* Write manifest.jsonl with these lines, each with its proof. */
static void write_manifest(const char *const *lines, size_t count)
{
    SC_OWN(sc_text_clear) sc_text text = {0};
    uint64_t chain = 0;

    for (size_t i = 0; i < count; i++) {
        const size_t bytes = strlen(lines[i]) - 1;

        chain = sc_hash_bytes(lines[i], bytes, chain);
        assert_ok(sc_text_add(&quiet, &text, "%.*s,\"line\":\"%016llx\"}\n", (int)bytes, lines[i],
                              (unsigned long long)chain));
    }
    write_quickly(in_folder("manifest.jsonl"), text.data, text.length_bytes);
}

#define HEAD(owns, rest)                                                                           \
    "{\"schema\":\"segcast-manifest-3\",\"version\":\"1.2\",\"job_hash\":\"0000000000000011\","    \
    "\"volume_hash\":\"0000000000000004\"," rest ",\"owns\":[" owns "]}"
#define SIZES "\"frames\":6,\"size\":[32,24]"

/* First lines that prove themselves and say what cannot be. */
TEST(forged_heads)
{
    static const char *const heads[] = {
        HEAD("\"../v.mp4\"", SIZES),
        HEAD("\"/etc/v.mp4\"", SIZES),
        HEAD("\"patient7.nrrd\"", SIZES),
        HEAD("\"frames/../../v.mp4\"", SIZES),
        HEAD("\"frames/000001.png\"", SIZES),
        HEAD("\".profile\"", SIZES),
        HEAD("\".mp4\"", SIZES),
        HEAD("17", SIZES),
        HEAD("", "\"frames\":0,\"size\":[32,24]"),
        HEAD("", "\"frames\":1000001,\"size\":[32,24]"),
        HEAD("", "\"frames\":4294967302,\"size\":[32,24]"),
        HEAD("", "\"frames\":6,\"size\":[32]"),
        HEAD("", "\"frames\":6,\"size\":[-32,24]"),
        HEAD("", "\"frames\":6.5,\"size\":[32,24]"),
        "{\"schema\":\"segcast-manifest-3\"}",
        "{\"schema\":17}",
        "[1,2]",
        "{}",
    };
    sc_store_report report;

    for (size_t i = 0; i < SC_COUNT_OF(heads); i++) {
        sc_store_job job = make_job();
        sc_store *store;
        char version[64];

        empty_folder();
        write_quickly(in_folder("v.mp4"), "mine", 4);
        write_manifest(&heads[i], 1);
        for (int mode = SC_STORE_NEW; mode <= SC_STORE_OVERWRITE; mode++) {
            assert_int_equal(sc_store_check(&quiet, folder, &job, NULL, (sc_store_mode)mode),
                             SC_ERR_CREATE);
            assert_int_equal(sc_store_open(&quiet, folder, &job, all_frames, 1, NULL,
                                           (sc_store_mode)mode, &store),
                             SC_ERR_CREATE);
        }
        assert_int_equal(sc_store_identify(&quiet, folder, &job, version), SC_ERR_DATA);
        assert_ok(sc_store_status(&quiet, folder, NULL, 0, &report));
        assert_int_equal(report.condition, SC_STORE_DAMAGED);
    }
}

/* Further lines that prove themselves and say what cannot be: reading ends there, as with damage.
 */
TEST(forged_lines)
{
    static const char *const forged[] = {
        "{\"frame\":6,\"hash\":\"0000000000000001\",\"rank\":0,\"render_cpu_s\":0}",
        "{\"frame\":-1,\"hash\":\"0000000000000001\",\"rank\":0,\"render_cpu_s\":0}",
        "{\"frame\":4294967296,\"hash\":\"0000000000000001\",\"rank\":0,\"render_cpu_s\":0}",
        "{\"frame\":1,\"hash\":\"1\",\"rank\":0,\"render_cpu_s\":0}",
        "{\"frame\":1,\"hash\":\"00000000000000zz\",\"rank\":0,\"render_cpu_s\":0}",
        "{\"frame\":1,\"hash\":\"0000000000000001\",\"rank\":-1,\"render_cpu_s\":0}",
        "{\"frame\":1,\"hash\":\"0000000000000001\",\"rank\":0,\"render_cpu_s\":-1}",
        "{\"frame\":1,\"hash\":\"0000000000000001\",\"rank\":0,\"render_cpu_s\":0,\"png_bytes\":-"
        "1}",
        "{\"complete\":true,\"video\":\"../v.mp4\",\"video_bytes\":4,\"video_hash\":"
        "\"0000000000000001\"}",
        "{\"complete\":true,\"video\":\"v.mp4\",\"video_bytes\":-4,\"video_hash\":"
        "\"0000000000000001\"}",
        "{\"complete\":true,\"video\":\"v.mp4\\u0000/\",\"video_bytes\":4,\"video_hash\":"
        "\"0000000000000001\"}",
        "{\"file\":\"../job.yaml\",\"bytes\":4,\"hash\":\"0000000000000001\"}",
        "{\"file\":\"frames/\",\"bytes\":4,\"hash\":\"0000000000000001\"}",
        "{\"file\":\"notes.txt\",\"bytes\":4,\"hash\":\"0000000000000001\"}",
        "{\"file\":\"job.yaml\",\"bytes\":-1,\"hash\":\"0000000000000001\"}",
        "{\"something\":1}",
    };

    for (size_t i = 0; i < SC_COUNT_OF(forged); i++) {
        const char *const lines[] = {HEAD("\"v.mp4\"", SIZES), forged[i]};
        sc_frame_line frames[FRAMES] = {{.known = false}};
        SC_OWN(sc_manifest_data_clear) sc_manifest_data data = {.lines = frames, .frames = FRAMES};

        empty_folder();
        write_manifest(lines, 2);
        assert_ok(sc_manifest_read(&quiet, in_folder("manifest.jsonl"), &data));
        assert_true(data.head.known);
        assert_int_equal(data.damaged_line, 2);
        assert_false(data.end.known);
        assert_int_equal(data.count + data.files.count + data.jobs.count, 0);
    }
}

/* The names that a manifest may give to segcast's files. */
TEST(own_names)
{
    static const char *const right[] = {
        "v.mp4",          "v.MKV",       "a b.webm",        "frames/",         "frames/*.png",
        "segments/*",     "job.yaml",    "status.json",     "stats.0of2.json", "frames.csv",
        "trace.a_b.json", "report.html", "report.0of2.html"};
    static const char *const wrong[] = {"",
                                        ".",
                                        "..",
                                        "../v.mp4",
                                        "a/v.mp4",
                                        "/v.mp4",
                                        ".v.mp4",
                                        "job.yaml/",
                                        "jobs.yaml",
                                        "stats.csv",
                                        "statsx.json",
                                        "stats..json",
                                        "volume.nrrd",
                                        "segments",
                                        "frames/1.png",
                                        "status.a/b.json",
                                        "stats.\x1b[31m.json",
                                        "a\nb.mp4"};

    for (size_t i = 0; i < SC_COUNT_OF(right); i++)
        assert_true(sc_own_name(right[i]));
    for (size_t i = 0; i < SC_COUNT_OF(wrong); i++)
        assert_false(sc_own_name(wrong[i]));
    assert_true(sc_is_segment_name("000001.seg") && sc_is_segment_name("000001.a.b.7.part"));
    assert_false(sc_is_segment_name("000001.part") || sc_is_segment_name("000001-notes.seg") ||
                 sc_is_segment_name("1.seg") || sc_is_segment_name("000001.seg.nrrd"));
    assert_true(sc_is_frame_name("000005.png", 6));
    assert_false(sc_is_frame_name("000006.png", 6) || sc_is_frame_name("0000005.png", 6) ||
                 sc_is_frame_name("5.png", 6));
}

/* Every byte of a manifest is proven: another one there is damage, and a shorter file is unfinished
 * or damaged. */
TEST(manifest_bytes)
{
    sc_store_report report;
    size_t bytes;
    SC_OWN(sc_free_at) char *text = NULL;

    make_finished();
    text = read_all(in_folder("manifest.jsonl"), &bytes);
    for (size_t at = 0; at < bytes; at++) {
        for (int bit = 0; bit < 8; bit += 5) {
            text[at] ^= (char)(1 << bit);
            write_quickly(in_folder("manifest.jsonl"), text, bytes);
            assert_ok(sc_store_status(&quiet, folder, NULL, 0, &report));
            if (report.condition != SC_STORE_DAMAGED)
                fail_msg("bit %d of byte %zu of the manifest is not proven", bit, at);
            text[at] ^= (char)(1 << bit);
        }
    }
    for (size_t length = 0; length < bytes; length += 7) {
        write_quickly(in_folder("manifest.jsonl"), text, length);
        assert_ok(sc_store_status(&quiet, folder, NULL, 0, &report));
        assert_int_not_equal(report.condition, SC_STORE_COMPLETE);
    }
}

/* A directory of another job, version, size or volume is refused to a run that would go on. */
TEST(other_jobs)
{
    empty_folder();
    sc_store_close(open_store(SC_STORE_NEW));
    for (int i = 0; i < 5; i++) {
        sc_store_job job = make_job();
        sc_store *store;

        job.version = i == 0 ? "1.3" : job.version;
        job.job_hash += i == 1;
        job.volume_hash += i == 2;
        job.frames += i == 3;
        job.settings.width_px += 2 * (i == 4);
        assert_int_equal(
            sc_store_open(&quiet, folder, &job, all_frames, 1, NULL, SC_STORE_RESUME, &store),
            SC_ERR_CREATE);
    }
}

/* The slices of a job add their records to what the manifests name: the first line of a thousandth
 * one is long, and still read. */
TEST(long_heads)
{
    enum { NAMES = 5000 };
    const sc_store_job job = make_job();
    SC_OWN(sc_manifest_data_clear) sc_manifest_data data = {.frames = 0}, again = {.frames = 0};
    const char *path = in_folder("manifest.jsonl");

    empty_folder();
    for (int i = 0; i < NAMES; i++) {
        char name[64];

        snprintf(name, sizeof name, "stats.%dof5000.json", i * 7 % NAMES);
        assert_ok(sc_names_add(&quiet, &data.owned, name));
    }
    assert_ok(sc_manifest_create(&quiet, path, &job, &data, NULL, false, NULL, NULL));
    for (int i = 1; i < NAMES; i++)
        assert_true(strcmp(data.owned.lines[i - 1].name, data.owned.lines[i].name) < 0);
    assert_ok(sc_manifest_read_head(&quiet, path, &again));
    assert_true(again.head.known);
    assert_int_equal(again.owned.count, NAMES);
}

/* @return whether a list has exactly those of the names "0" to "count - 1" for which `wanted` is
 * set. */
static bool has_exactly(const sc_names *names, const bool *wanted, int count)
{
    int wanted_count = 0;

    for (int i = 0; i < count; i++) {
        char name[16];

        snprintf(name, sizeof name, "%d", i);
        if (sc_file_lines_has(names, name) != wanted[i])
            return false;
        wanted_count += wanted[i];
    }
    return names->count == wanted_count;
}

/* Names are added, found and removed in any order, with few and with many in the list; sorting
 * changes nothing but the order. */
TEST(lists_of_names)
{
    enum { NAMES = 100, STEPS = 3000 };
    SC_OWN(sc_file_lines_clear) sc_names names = {0};
    bool wanted[NAMES] = {false};
    uint32_t random = 1;

    assert_false(sc_file_lines_has(&names, "0"));
    sc_file_lines_remove(&names, "0");
    sc_file_lines_sort(&names);
    for (int step = 0; step < STEPS; step++) {
        char name[16];
        int i;

        random = random * 1664525 + 1013904223;
        i = (int)((random >> 16) % NAMES);
        snprintf(name, sizeof name, "%d", i);
        wanted[i] = (random >> 8) % STEPS > (uint32_t)step;
        if (wanted[i])
            assert_ok(sc_names_add(&quiet, &names, name));
        else
            sc_file_lines_remove(&names, name);
        if (step % 10 == 0)
            sc_file_lines_sort(&names);
        for (int k = 1; step % 10 == 0 && k < names.count; k++)
            assert_true(strcmp(names.lines[k - 1].name, names.lines[k].name) < 0);
        assert_true(has_exactly(&names, wanted, NAMES));
    }
}

/* Open the finished directory again. */
static sc_status open_again(const sc_ctx *ctx, const sc_store_job *job)
{
    sc_store *store = NULL;
    const sc_status status =
        sc_store_open(ctx, folder, job, all_frames, FRAMES, NULL, SC_STORE_RESUME, &store);

    if (status == SC_OK)
        assert_true(sc_store_is_complete(store));
    sc_store_close(store);
    return status;
}

static sc_status verify_records(const sc_ctx *ctx, const sc_store_job *job)
{
    SC_OWN(sc_text_clear) sc_text names = {0};
    const sc_status status = sc_store_verify_records(ctx, folder, &names);

    return status;
}

static sc_status verify_outputs(const sc_ctx *ctx, const sc_store_job *job)
{
    return sc_store_verify(ctx, folder, job);
}

/* Without memory nobody can say that a file is not what the manifest names: whichever allocation
 * fails, that is what is told, once, and no warning of a file. */
TEST(want_of_memory)
{
    sc_status (*const calls[])(const sc_ctx *, const sc_store_job *) = {open_again, verify_records,
                                                                        verify_outputs};
    const sc_store_job job = make_job();

    make_finished();
    for (size_t i = 0; i < SC_COUNT_OF(calls); i++) {
        sc_status status = SC_ERR_MEMORY;

        for (long n = 0; status != SC_OK; n++) {
            long budget = n;
            sc_ctx ctx = *listening_anew();

            ctx.alloc_budget = &budget;
            status = calls[i](&ctx, &job);
            assert_int_equal(said.errors, status != SC_OK);
            if (status != SC_OK)
                assert_int_equal(status, SC_ERR_MEMORY);
            else
                assert_string_equal(said.text, "");
        }
    }
}

/* A pipe that has the name of a manifest keeps nobody waiting. */
TEST(pipes)
{
    sc_store_job job = make_job();
    char version[64];

    empty_folder();
    assert_int_equal(mkfifo(in_folder("manifest.jsonl"), 0600), 0);
    assert_int_equal(mkfifo(in_folder("manifest.x.jsonl"), 0600), 0);
    alarm(20); /* ends the test if one of them waits */
    assert_int_equal(sc_store_identify(&quiet, folder, &job, version), SC_ERR_MISSING);
    assert_int_equal(sc_store_check(&quiet, folder, &job, NULL, SC_STORE_NEW), SC_ERR_CREATE);
    unlink(in_folder("manifest.jsonl"));
    assert_int_equal(sc_store_identify(&quiet, folder, &job, version), SC_ERR_MISSING);
    assert_ok(sc_store_check(&quiet, folder, &job, NULL, SC_STORE_NEW));
    alarm(0);
}

/* A directory that cannot be listed is an output that cannot be made, not an input that is missing.
 */
TEST(unlistable)
{
    const sc_store_job job = make_job();

    empty_folder();
    assert_int_equal(symlink("loop", in_folder("loop")), 0);
    assert_int_equal(sc_store_check(&quiet, in_folder("loop"), &job, NULL, SC_STORE_NEW),
                     SC_ERR_CREATE);
}

/* A run that cannot begin, because a file has appeared after sc_store_check, leaves that file. */
TEST(refused_begin)
{
    static const char *const names[] = {"status.json", "job.yaml"};
    const sc_store_job job = make_job();
    sc_store_begun begun;

    for (size_t i = 0; i < SC_COUNT_OF(names); i++) {
        empty_folder();
        write_quickly(in_folder(names[i]), "mine", 4);
        assert_int_equal(sc_store_begin(&quiet, folder, &job, NULL, SC_STORE_NEW, &begun),
                         SC_ERR_CREATE);
        assert_int_equal(access(in_folder(names[i]), F_OK), 0);
        assert_int_not_equal(access(in_folder("manifest.jsonl"), F_OK), 0);
    }
}

/* A run that another one has replaced accepts nothing more, and completes nothing: neither while it
 * draws, nor at its end, nor between the film and its records. The other one goes on with what both
 * have made. */
TEST(the_last_run_in_a_directory_has_it)
{
    for (int stage = 0; stage < 3; stage++) {
        SC_OWN(sc_image_clear) sc_image image = make_picture(FRAMES - 1);
        const sc_done_frame done = {.frame = FRAMES - 1, .hash = sc_image_hash(&image)};
        sc_store *first, *second;
        int missing;

        empty_folder();
        first = open_store(SC_STORE_NEW);
        add_frames(first, 0, stage == 0 ? FRAMES - 1 : FRAMES);
        if (stage == 2) {
            assert_ok(sc_store_finish(&quiet, first, &missing));
            assert_false(sc_store_is_replaced(first));
            second = open_store(SC_STORE_OVERWRITE);
        } else {
            second = open_store(SC_STORE_RESUME);
        }
        assert_true(sc_store_is_replaced(first) && !sc_store_is_replaced(second));
        if (stage == 0)
            assert_int_equal(sc_store_add_frame(&quiet, first, &done, &image), SC_ERR_INCOMPLETE);
        assert_int_equal(stage == 2 ? sc_store_seal(&quiet, first)
                                    : sc_store_finish(&quiet, first, &missing),
                         SC_ERR_INCOMPLETE);
        add_frames(second, 0, FRAMES);
        finish(second);
        sc_store_close(first);
        sc_store_close(open_store(SC_STORE_RESUME));
    }
}

/* A segment, and pictures of another, that a replaced run has written beside a sealed manifest are
 * of its job: a run that goes on removes them, and one that begins anew is not stopped by them. A
 * file of another job under such a name is in the way, and stays. */
TEST(late_segments_are_removed)
{
    static const char *const names[] = {"segments/000000.seg", "segments/000001.host.1.part"};
    const sc_store_job job = make_job();
    char path[512], *data[2];
    size_t bytes[2];
    sc_segment other = make_segment(0);
    sc_store *store;

    make_partial(path);
    data[1] = read_all(path, &bytes[1]);
    store = open_store(SC_STORE_RESUME);
    add_frames(store, 0, FPS);
    data[0] = read_all(in_folder(names[0]), &bytes[0]);
    add_frames(store, FPS, FRAMES);
    finish(store);
    for (int anew = 0; anew < 2; anew++) {
        assert_int_equal(mkdir(in_folder("segments"), 0777), 0);
        for (int i = 0; i < 2; i++)
            write_quickly(in_folder(names[i]), data[i], bytes[i]);
        store = open_store(anew ? SC_STORE_OVERWRITE : SC_STORE_RESUME);
        assert_int_equal(sc_store_is_complete(store), !anew);
        assert_int_equal(access(in_folder(names[0]), F_OK), -1);
        assert_int_equal(access(in_folder(names[1]), F_OK), -1);
        if (anew) {
            add_frames(store, 0, FRAMES);
            finish(store);
        } else {
            sc_store_close(store);
        }
    }
    assert_int_equal(mkdir(in_folder("segments"), 0777), 0);
    write_quickly(in_folder(names[0]), other.data, other.bytes);
    assert_int_equal(
        sc_store_open(&quiet, folder, &job, all_frames, FRAMES, NULL, SC_STORE_OVERWRITE, &store),
        SC_ERR_CREATE);
    assert_int_equal(access(in_folder(names[0]), F_OK), 0);
    for (int i = 0; i < 2; i++)
        sc_free(data[i]);
    sc_segment_free(&other);
}

/* ---- job.yaml ---- */

/* Open the folder for one of two slices, of three frames each. */
static sc_store *open_slice(const sc_ctx *ctx, int slice)
{
    static const char *const names[] = {"0of2", "1of2"};
    const sc_store_job job = make_job();
    sc_store *store;

    assert_ok(sc_store_open(ctx, folder, &job, all_frames + FRAMES / 2 * slice, FRAMES / 2,
                            names[slice], SC_STORE_RESUME, &store));
    return store;
}

/* @return whether a file of the folder holds this text; NULL: it is not there. */
static bool holds(const char *name, const char *text)
{
    size_t bytes = 0;
    SC_OWN(sc_free_at) char *data = NULL;
    bool same;

    if (access(in_folder(name), F_OK) != 0)
        return !text;
    data = read_all(in_folder(name), &bytes);
    same = text && bytes == strlen(text) && !memcmp(data, text, bytes);
    return same;
}

/* Slices that begin at the same moment write job.yaml in turn, also if each writes another text,
 * and has read the manifests before the other noted its own; what somebody else has put there is
 * kept, once. */
TEST(job_of_slices)
{
    sc_store *a, *b;

    empty_folder();
    a = open_slice(&listening, 0);
    b = open_slice(&listening, 1);
    assert_ok(sc_store_write_job(&listening, a, "one", 3));
    assert_ok(sc_store_write_job(&listening, b, "two", 3));
    assert_ok(sc_store_write_job(&listening, a, "one", 3));
    assert_string_equal(said.text, "");
    assert_true(holds("job.yaml", "one") && holds("job.yaml.changed", NULL));
    sc_store_close(a);
    sc_store_close(b);
    write_quickly(in_folder("job.yaml"), "mine", 4);
    a = open_slice(&listening, 0);
    b = open_slice(&listening, 1);
    assert_string_equal(said.text, "");
    assert_ok(sc_store_write_job(&listening, b, "two", 3));
    assert_ok(sc_store_write_job(&listening, a, "one", 3));
    assert_int_equal(said.warnings, 1);
    assert_non_null(strstr(said.text, "job.yaml: was changed after segcast had made it; that file "
                                      "is now"));
    assert_true(holds("job.yaml", "one") && holds("job.yaml.changed", "mine"));
    assert_true(holds("job.yaml.changed-2", NULL));
    sc_store_close(a);
    sc_store_close(b);
}

/* Every text of job.yaml is in the manifest and on disk before the file holds it. */
TEST(job_is_noted_first)
{
    sc_manifest_data data = {.frames = FRAMES};
    sc_store *store;

    empty_folder();
    store = open_slice(&listening, 0);
    assert_int_equal(mkdir(in_folder("job.yaml"), 0777), 0); /* so that it cannot be written */
    assert_int_equal(sc_store_write_job(&listening, store, "one", 3), SC_ERR_WRITE);
    sc_store_close(store);
    assert_int_equal(rmdir(in_folder("job.yaml")), 0);
    assert_ok(sc_manifest_read(&quiet, in_folder("manifest.0of2.jsonl"), &data));
    assert_true(sc_job_texts_have(&data.jobs, 3, sc_store_hash_bytes("one", 3)));
    sc_manifest_data_clear(&data);
    /* The manifest of the next run of the slice names it, too. */
    store = open_slice(&listening, 0);
    sc_store_close(store);
    assert_ok(sc_manifest_read(&quiet, in_folder("manifest.0of2.jsonl"), &data));
    assert_true(sc_job_texts_have(&data.jobs, 3, sc_store_hash_bytes("one", 3)));
    sc_manifest_data_clear(&data);
}

/* What is not segcast's at the end of a job is left out of what the manifest proves, and stays:
 * that which was given as the job, whoever wrote it, and what its user has changed meanwhile. */
TEST(job_of_others_is_not_proven)
{
    for (int given = 0; given < 2; given++) {
        sc_store_job job = make_job();
        SC_OWN(sc_manifest_data_clear) sc_manifest_data data = {.frames = FRAMES};
        sc_store *store;
        const sc_ctx *ctx = listening_anew();
        int missing;

        empty_folder();
        store = open_store(SC_STORE_NEW);
        assert_ok(sc_store_write_job(ctx, store, "one", 3));
        sc_store_close(store);
        job.keeps_job = given;
        assert_ok(
            sc_store_open(ctx, folder, &job, all_frames, FRAMES, NULL, SC_STORE_RESUME, &store));
        add_frames(store, 0, FRAMES);
        if (!given)
            write_quickly(in_folder("job.yaml"), "mine", 4);
        assert_ok(sc_store_finish(ctx, store, &missing));
        assert_ok(sc_store_seal(ctx, store));
        sc_store_close(store);
        assert_int_equal(said.warnings, !given);
        assert_true(given || strstr(said.text, "job.yaml: is missing, or not what segcast has"));
        assert_true(holds("job.yaml", given ? "one" : "mine"));
        assert_ok(sc_manifest_read(&quiet, in_folder("manifest.jsonl"), &data));
        assert_true(data.closed && sc_file_lines_has(&data.owned, "job.yaml"));
        assert_int_equal(data.jobs.count, 0);
    }
}

static int make_folder(void **state)
{
    /* in memory where there is such a place: files are forced to the disk a thousand times */
    snprintf(folder, sizeof folder, "%s/segcast-store-XXXXXX",
             access("/dev/shm", W_OK) == 0 ? "/dev/shm" : "/tmp");
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state)
{
    char command[128];

    snprintf(command, sizeof command, "rm -rf %s", folder);
    return system(command);
}

RUN_TESTS(make_folder, remove_folder)
