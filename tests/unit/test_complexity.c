/* SPDX-License-Identifier: BSD-3-Clause */
/* Every parser, and the search for copied voxels, at n and at 2n: twice the input costs less than
 * 2.5 times the operations. Operations are counted, not timed: blocks of code that ran in base,
 * volume, job, store, study, that search and the options, and bytes that functions of the C library
 * looked at for them (tests/support/counted.h). What libyaml, jansson and zlib do inside is not
 * counted. */
#include "check.h"

#include "internal.h"
#include "segcast/cli.h"
#include "segcast/job.h"
#include "segcast/measurements.h"
#include "segcast/resample.h"
#include "segcast/study.h"
#include "segcast/study_file.h"
#include "segcast/value_table.h"
#include "segcast/volume.h"

#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

uint64_t sc_test_operations;

void __sanitizer_cov_trace_pc(void);
void __sanitizer_cov_trace_pc(void)
{
    sc_test_operations++;
}

/* One input: writes it, with @p n parts, and parses it. */
typedef struct parser {
    const char *name;
    void (*parse)(const struct parser *p, int n);
    const char *head, *part,
        *tail; /* part is a format with the number of the part, twice at most */
    sc_table_format format;
    sc_status wanted;
    int n; /* parts of the shorter input */
} parser;

/* A context that drops its messages, but makes them. */
static void drop(void *user, sc_log_level level, const char *text)
{
}
static const sc_ctx ctx = {.level = SC_LOG_INFO, .write = drop};

#pragma GCC diagnostic ignored "-Wformat-nonliteral"

/* Write head, n parts and tail to @p path, and behind them @p voxels bytes of voxels. */
static void write_input(const parser *p, int n, int voxels, const char *path)
{
    FILE *file = fopen(path, "wb");

    assert_non_null(file);
    fputs(p->head, file);
    for (int i = 0; i < n; i++)
        fprintf(file, p->part, i + 1, i + 1, i + 1);
    fputs(p->tail, file);
    for (int i = 0; i < voxels; i++)
        fputc(i % 5, file);
    fclose(file);
}

/* Read the labels in the header of a volume, or the whole of one with so many labels. */
static void read_header(const parser *p, const char *path)
{
    SC_OWN(sc_volume_clear) sc_volume scan = {0};

    sc_test_operations = 0;
    assert_int_equal(
        sc_volume_read_by(&ctx, path, &(sc_read_choice){.depth = SC_READ_HEADER}, &scan),
        p->wanted);
}

static void read_volume(const parser *p, const char *path, int labels)
{
    SC_OWN(sc_volume_clear) sc_volume v = {0};

    sc_test_operations = 0;
    assert_int_equal(sc_volume_read(&ctx, path, &v), p->wanted);
    if (labels)
        assert_int_equal(v.label_count, labels);
}

static void parse_table(const parser *p, int n)
{
    SC_OWN(sc_label_table_clear) sc_label_table table = {0};

    write_input(p, n, 0, "c.txt");
    sc_test_operations = 0;
    assert_int_equal(sc_label_table_read(&ctx, "c.txt", p->format, &table), p->wanted);
    unlink("c.txt");
}

static void parse_volume(const parser *p, int n)
{
    write_input(p, n, 64, "c.vol");
    read_header(p, "c.vol");
    unlink("c.vol");
}

/* A list of data files: names of the same file, n times. */
static void parse_list(const parser *p, int n)
{
    char head[512];
    parser list = *p;
    FILE *file = fopen("c.raw", "wb");

    assert_non_null(file);
    fputc('x', file);
    fclose(file);
    snprintf(head, sizeof head, p->head, n);
    list.head = head;
    parse_volume(&list, n);
    unlink("c.raw");
}

/* Voxels of a NRRD with encoding ascii, or in another format: n rows of 1,600. */
static void parse_numbers(const parser *p, int n)
{
    char head[512];
    FILE *file = fopen("c.vol", "wb");

    assert_non_null(file);
    snprintf(head, sizeof head, p->head, n);
    fputs(head, file);
    for (int i = 0; i < n * 1600; i++)
        fputs(p->part, file);
    fclose(file);
    read_volume(p, "c.vol", 0);
    unlink("c.vol");
}

static void parse_nifti(const parser *p, int n)
{
    unsigned char h[352] = {0};
    const int32_t size = 348;
    const int16_t dim[] = {3, 16, 16, (int16_t)n}, type[] = {2, 8};
    const float pixdim[] = {1, 1, 1, 1}, offset = 352;
    gzFile file = gzopen("c.nii.gz", "wb");

    memcpy(h, &size, 4);
    memcpy(h + 40, dim, sizeof dim);
    memcpy(h + 70, type, sizeof type);
    memcpy(h + 76, pixdim, sizeof pixdim);
    memcpy(h + 108, &offset, 4);
    memcpy(h + 344, "n+1", 4);
    gzwrite(file, h, sizeof h);
    for (int i = 0; i < n * 256; i++)
        gzputc(file, i / 3 % 7);
    gzclose(file);
    read_volume(p, "c.nii.gz", 0);
    unlink("c.nii.gz");
}

static void parse_values(const parser *p, int n)
{
    SC_OWN(sc_value_table_clear) sc_value_table table = {0};

    write_input(p, n, 0, "c.csv");
    sc_test_operations = 0;
    assert_int_equal(sc_value_table_read(&ctx, "c.csv", "", &table), p->wanted);
    unlink("c.csv");
}

static void parse_study(const parser *p, int n)
{
    SC_OWN(sc_study_clear) sc_study study = {0};

    write_input(p, n, 0, "c.yaml");
    sc_test_operations = 0;
    assert_int_equal(sc_study_load(&ctx, "c.yaml", &study), p->wanted);
    unlink("c.yaml");
}

static void parse_measurements(const parser *p, int n)
{
    SC_OWN(sc_measurements_clear) sc_measurements read = {0};
    uint64_t bytes = 0;

    write_input(p, n, 0, "c.jsonl");
    sc_test_operations = 0;
    assert_int_equal(sc_measurements_read(&ctx, "c.jsonl", &read, &bytes), p->wanted);
    assert_int_equal(read.count, n);
    unlink("c.jsonl");
}

/* A directory of n masks of two voxels. */
static void parse_masks(const parser *p, int n)
{
    char path[64];

    mkdir("c.masks", 0777);
    for (int i = 0; i < n; i++) {
        snprintf(path, sizeof path, "c.masks/t%d.nrrd", i * 7919 % n);
        write_text(path, "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: ascii\n\n"
                         "0 1 0 0 0 1 0 0\n");
    }
    read_volume(p, "c.masks", 0);
    assert_int_equal(system("rm -r c.masks"), 0);
}

/* A store of OME-Zarr whose attributes have n parts. */
static void parse_zarr(const parser *p, int n)
{
    mkdir("c.zarr", 0777);
    mkdir("c.zarr/0", 0777);
    write_text("c.zarr/.zgroup", "{\"zarr_format\": 2}");
    write_text("c.zarr/0/.zarray",
               "{\"zarr_format\": 2, \"shape\": [4, 4, 4], \"chunks\": [4, 4, 4], \"dtype\": "
               "\"|u1\", \"compressor\": null, \"fill_value\": 0, \"order\": \"C\", \"filters\": "
               "null}");
    write_input(p, n, 0, "c.zarr/.zattrs");
    read_header(p, "c.zarr");
    assert_int_equal(system("rm -r c.zarr"), 0);
}

/* A volume of Neuroglancer with the properties of n segments. */
static void parse_properties(const parser *p, int n)
{
    mkdir("c.pc", 0777);
    mkdir("c.pc/s", 0777);
    mkdir("c.pc/p", 0777);
    write_text("c.pc/info",
               "{\"@type\": \"neuroglancer_multiscale_volume\", \"data_type\": \"uint8\", "
               "\"num_channels\": 1, \"segment_properties\": \"p\", \"scales\": [{\"key\": "
               "\"s\", \"size\": [4, 4, 4], \"encoding\": \"raw\", \"chunk_sizes\": [[4, 4, 4]], "
               "\"resolution\": [1, 1, 1]}]}");
    write_input(p, n, 0, "c.pc/p/info");
    read_header(p, "c.pc");
    assert_int_equal(system("rm -r c.pc"), 0);
}

/* Put a number of 8 bytes, the least first. */
static void put64(uint64_t number, FILE *file)
{
    for (int i = 0; i < 8; i++)
        fputc((int)(number >> 8 * i & 255), file);
}

/* A volume of Neuroglancer whose n chunks lie in one minishard. */
static void parse_shard(const parser *p, int n)
{
    enum { CHUNK_BYTES = 4 };
    char info[512];
    FILE *file;

    mkdir("c.pc", 0777);
    mkdir("c.pc/s", 0777);
    snprintf(info, sizeof info, p->head, n * CHUNK_BYTES);
    write_text("c.pc/info", info);
    file = fopen("c.pc/s/0.shard", "wb");
    assert_non_null(file);
    put64((uint64_t)n * CHUNK_BYTES, file);
    put64((uint64_t)n * (CHUNK_BYTES + 24), file);
    for (int i = 0; i < n * CHUNK_BYTES; i++)
        fputc(i / 3 % 7, file);
    for (int i = 0; i < 3 * n; i++) /* numbers, places, bytes */
        put64(i < n ? i > 0 : i < 2 * n ? 0 : CHUNK_BYTES, file);
    fclose(file);
    read_volume(p, "c.pc", 7);
    assert_int_equal(system("rm -r c.pc"), 0);
}

/* A volume of Neuroglancer whose n chunks lie by turns in two minishards, whose indices have 500 n
 * entries each: longer ones than were once remembered. */
static void parse_minishards(const parser *p, int n)
{
    const int chunk_bytes = 4, entries = 500 * n;
    const uint64_t begin = (uint64_t)n * (uint64_t)chunk_bytes, bytes = (uint64_t)entries * 24;
    char info[512];
    FILE *file;

    mkdir("c.pc", 0777);
    mkdir("c.pc/s", 0777);
    snprintf(info, sizeof info, p->head, n * chunk_bytes);
    write_text("c.pc/info", info);
    file = fopen("c.pc/s/0.shard", "wb");
    assert_non_null(file);
    for (uint64_t i = 0; i < 4; i++)
        put64(begin + (i + 1) / 2 * bytes, file);
    for (int i = 0; i < n * chunk_bytes; i++)
        fputc(i / 3 % 7, file);
    for (int m = 0; m < 2; m++) {
        for (int i = 0; i < 3 * entries; i++) { /* numbers, places, bytes */
            const int k = i % entries, of_volume = k < n / 2 ? chunk_bytes : 0;

            if (i < entries)
                put64((uint64_t)(k ? 2 : m), file);
            else if (i < 2 * entries)
                put64((uint64_t)(k ? of_volume : m * chunk_bytes), file);
            else
                put64((uint64_t)of_volume, file);
        }
    }
    fclose(file);
    read_volume(p, "c.pc", 7);
    assert_int_equal(system("rm -r c.pc"), 0);
}

/* @return the check sum CRC-32C of @p bytes bytes of 0 with a 1 in every 16th, from the ninth on.
 */
static uint32_t crc_of_index(size_t bytes)
{
    uint32_t sum = UINT32_MAX;

    for (size_t i = 0; i < bytes; i++) {
        sum ^= i % 16 == 8;
        for (int k = 0; k < 8; k++)
            sum = sum >> 1 ^ (sum & 1 ? 0x82f63b78 : 0);
    }
    return ~sum;
}

/* A volume of Zarr whose 4 n chunks lie by turns in two shards, with room for 1,000 n each. */
static void parse_zarr_shards(const parser *p, int n)
{
    const size_t chunks = 1000 * (size_t)n;
    const uint32_t sum = crc_of_index(16 * chunks);
    const char *const names[] = {"c.zarr/c/0/0/0", "c.zarr/c/0/0/1"};
    char text[1024];

    mkdir("c.zarr", 0777);
    mkdir("c.zarr/c", 0777);
    mkdir("c.zarr/c/0", 0777);
    mkdir("c.zarr/c/0/0", 0777);
    snprintf(text, sizeof text, p->head, n, n * 500);
    write_text("c.zarr/zarr.json", text);
    for (int i = 0; i < 2; i++) {
        FILE *file = fopen(names[i], "wb");

        assert_non_null(file);
        fputc(i + 1, file);
        for (size_t k = 0; k < chunks; k++) {
            put64(0, file);
            put64(1, file);
        }
        for (int k = 0; k < 4; k++)
            fputc((int)(sum >> 8 * k & 255), file);
        fclose(file);
    }
    read_volume(p, "c.zarr", 3);
    for (int i = 0; i < 2; i++)
        unlink(names[i]);
    assert_int_equal(system("rm -r c.zarr"), 0);
}

/* Put a number of @p bytes bytes, the greatest first. */
static void put_big(uint32_t number, int bytes, FILE *file)
{
    for (int i = bytes - 1; i >= 0; i--)
        fputc((int)(number >> 8 * i & 255), file);
}

static void parse_mgh(const parser *p, int n)
{
    const uint32_t head[] = {1, 16, 16, (uint32_t)n, 1, 0, 0}; /* version, size, frames, type, - */
    FILE *file = fopen("c.mgh", "wb");

    assert_non_null(file);
    for (size_t i = 0; i < SC_COUNT_OF(head); i++)
        put_big(head[i], 4, file);
    for (int i = 28; i < 284; i++)
        fputc(0, file);
    for (int i = 0; i < n * 256; i++)
        fputc(i / 3 % 7, file);
    fclose(file);
    read_volume(p, "c.mgh", 0);
    unlink("c.mgh");
}

/* Put a number of @p bytes bytes, the least first. */
static void put_little(uint32_t number, int bytes, FILE *file)
{
    for (int i = 0; i < bytes; i++)
        fputc((int)(number >> 8 * i & 255), file);
}

/* Put an entry of a TIFF directory with one number. */
static void put_entry(uint32_t tag, uint32_t type, uint32_t number, FILE *file)
{
    put_little(tag, 2, file);
    put_little(type, 2, file);
    put_little(1, 4, file);
    put_little(number, 4, file);
}

/* A TIFF of n pages of 8 x 8 voxels, each with a directory in front of it. */
static void parse_tiff(const parser *p, int n)
{
    enum { LONG = 4, PAGE_BYTES = 2 + 7 * 12 + 4 + 64 };
    FILE *file = fopen("c.tif", "wb");
    SC_OWN(sc_volume_clear) sc_volume v = {0};

    assert_non_null(file);
    fwrite("II*\0\x08\0\0\0", 8, 1, file);
    for (int i = 0; i < n; i++) {
        const uint32_t begin = 8 + (uint32_t)i * PAGE_BYTES;

        put_little(7, 2, file);
        put_entry(256, LONG, 8, file);                       /* width */
        put_entry(257, LONG, 8, file);                       /* height */
        put_entry(258, LONG, 8, file);                       /* bits */
        put_entry(262, LONG, 1, file);                       /* 0 is black */
        put_entry(273, LONG, begin + PAGE_BYTES - 64, file); /* where the pixels are */
        put_entry(278, LONG, 8, file);                       /* all rows in one strip */
        put_entry(279, LONG, 64, file);                      /* of so many bytes */
        put_little(i + 1 < n ? begin + PAGE_BYTES : 0, 4, file);
        for (int k = 0; k < 64; k++)
            fputc((i + k) / 3 % 7, file);
    }
    fclose(file);
    sc_test_operations = 0;
    assert_int_equal(sc_volume_read(&ctx, "c.tif", &v), p->wanted);
    assert_int_equal(v.size[2], n);
    unlink("c.tif");
}

/* Put an element of a DICOM data set, in the explicit form, the least byte first, with a text of an
 * even number of bytes as its value; "SQ": without a value, which follows up to a delimiter. */
static void put_dicom(uint32_t group, uint32_t element, const char *kind, const char *text,
                      FILE *file)
{
    const bool sequence = !strcmp(kind, "SQ");

    put_little(group, 2, file);
    put_little(element, 2, file);
    fputs(kind, file);
    put_little(sequence ? 0 : (uint32_t)strlen(text), 2, file);
    if (sequence)
        put_little(UINT32_MAX, 4, file);
    fputs(text, file);
}

/* Begin or end an item of a sequence (e000, e00d), or end a sequence (e0dd). */
static void put_item(uint32_t element, FILE *file)
{
    put_little(0xfffe, 2, file);
    put_little(element, 2, file);
    put_little(element == 0xe000 ? UINT32_MAX : 0, 4, file);
}

static void put_dicom_number(uint32_t group, uint32_t element, uint32_t number, FILE *file)
{
    put_little(group, 2, file);
    put_little(element, 2, file);
    fputs("US", file);
    put_little(2, 2, file);
    put_little(number, 2, file);
}

/* The segments of a DICOM segmentation, and what its frames share. */
static void put_segments(int n, FILE *file)
{
    char name[32];

    put_dicom(0x62, 2, "SQ", "", file);
    for (int i = 0; i < n; i++) {
        snprintf(name, sizeof name, "t%07d", i);
        put_item(0xe000, file);
        put_dicom_number(0x62, 4, (uint32_t)i + 1, file);
        put_dicom(0x62, 5, "LO", name, file);
        put_item(0xe00d, file);
    }
    put_item(0xe0dd, file);
    put_dicom(0x5200, 0x9229, "SQ", "", file);
    put_item(0xe000, file);
    put_dicom(0x20, 0x9116, "SQ", "", file);
    put_item(0xe000, file);
    put_dicom(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0 ", file);
    put_item(0xe00d, file);
    put_item(0xe0dd, file);
    put_dicom(0x28, 0x9110, "SQ", "", file);
    put_item(0xe000, file);
    put_dicom(0x18, 0x50, "DS", "1 ", file);
    put_dicom(0x28, 0x30, "DS", "1\\1 ", file);
    put_item(0xe00d, file);
    put_item(0xe0dd, file);
    put_item(0xe00d, file);
    put_item(0xe0dd, file);
}

/* The frame of each segment: where it lies, and its pixels. */
static void put_frames(int n, FILE *file)
{
    char place[32];

    put_dicom(0x5200, 0x9230, "SQ", "", file);
    for (int i = 0; i < n; i++) {
        snprintf(place, sizeof place, "0\\0\\%06d", i * 7919 % n);
        put_item(0xe000, file);
        put_dicom(0x20, 0x9113, "SQ", "", file);
        put_item(0xe000, file);
        put_dicom(0x20, 0x32, "DS", place, file);
        put_item(0xe00d, file);
        put_item(0xe0dd, file);
        put_dicom(0x62, 0xa, "SQ", "", file);
        put_item(0xe000, file);
        put_dicom_number(0x62, 0xb, (uint32_t)i + 1, file);
        put_item(0xe00d, file);
        put_item(0xe0dd, file);
        put_item(0xe00d, file);
    }
    put_item(0xe0dd, file);
    put_little(0x7fe0, 2, file);
    put_little(0x10, 2, file);
    fputs("OB", file);
    put_little(0, 2, file);
    put_little((uint32_t)n * 8, 4, file);
    for (int i = 0; i < n * 8; i++)
        fputc(15, file);
}

/* A DICOM segmentation of n segments, each with one frame of 8 x 8 pixels. */
static void parse_dicom(const parser *p, int n)
{
    char frames[32];
    FILE *file = fopen("c.dcm", "wb");
    SC_OWN(sc_volume_clear) sc_volume v = {0};

    assert_non_null(file);
    for (int i = 0; i < 128; i++)
        fputc(0, file);
    fputs("DICM", file);
    put_dicom(2, 2, "UI", "1.2.840.10008.5.1.4.1.1.66.4", file);
    put_dicom(2, 0x10, "UI", "1.2.840.10008.1.2.1 ", file);
    put_dicom(8, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.66.4", file);
    put_dicom(8, 0x60, "CS", "SEG ", file);
    put_dicom_number(0x28, 2, 1, file);
    put_dicom(0x28, 4, "CS", "MONOCHROME2 ", file);
    snprintf(frames, sizeof frames, "%06d", n);
    put_dicom(0x28, 8, "IS", frames, file);
    put_dicom_number(0x28, 0x10, 8, file);
    put_dicom_number(0x28, 0x11, 8, file);
    put_dicom_number(0x28, 0x100, 1, file);
    put_dicom_number(0x28, 0x101, 1, file);
    put_dicom_number(0x28, 0x102, 0, file);
    put_dicom_number(0x28, 0x103, 0, file);
    put_dicom(0x62, 1, "CS", "BINARY", file);
    put_segments(n, file);
    put_frames(n, file);
    fclose(file);
    sc_test_operations = 0;
    assert_int_equal(sc_volume_read(&ctx, "c.dcm", &v), p->wanted);
    assert_int_equal(v.label_count, n + 1);
    unlink("c.dcm");
}

/* Labels of @p count voxels of a row: @p pattern again and again, or random ones if it is empty. */
static void fill_row(uint8_t *ids, int count, const char *pattern, uint32_t *seed)
{
    const int length = (int)strlen(pattern);

    for (int i = 0; i < count; i++) {
        *seed = *seed * 1664525u + 1013904223u;
        ids[i] = length ? (uint8_t)(pattern[i % length] - '0') : (uint8_t)(*seed >> 24) % 5;
    }
}

/* Look for copied voxels along a row of n: the first half as head says, the rest as part does. */
static void find_copies(const parser *p, int n)
{
    sc_volume v = {.size = {n, 1, 1},
                   .to_ras_mm = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}},
                   .label_bytes = 1,
                   .label_count = 5,
                   .ids = calloc((size_t)n, 1)};
    const double wanted = p->tail[0] ? atof(p->tail) : 1;
    sc_drawn_grid grid;
    uint32_t seed = 1;

    assert_non_null(v.ids);
    fill_row(v.ids, n / 2, p->head, &seed);
    fill_row((uint8_t *)v.ids + n / 2, n - n / 2, p->part, &seed);
    sc_test_operations = 0;
    assert_int_equal(sc_find_drawn_grid(&ctx, &v, 1, &grid), p->wanted);
    assert_true(fabs(grid.copies[0] - wanted) < 0.001);
    free(v.ids);
}

/* Put layers between thick slices of n pixels in all, in which n / 40 labels are scattered. */
static void split_scattered(const parser *p, int n)
{
    SC_OWN(sc_volume_clear)
    sc_volume v = {.size = {40, n / 240, 6},
                   .to_ras_mm = {{{0.2, 0, 0, 0}, {0, 0.2, 0, 0}, {0, 0, 1, 0}}},
                   .label_bytes = 2,
                   .label_count = n / 40};
    const sc_drawn_grid grid = {.copies = {1, 1, 1}, .drawn_mm = {0.2, 0.2, 1}, .split = {1, 1, 5}};
    const size_t voxels = sc_volume_voxels(&v);
    uint32_t seed = 1;

    assert_int_equal(sc_alloc(&ctx, voxels, 2, &v.ids), SC_OK);
    for (size_t i = 0; i < voxels; i++) {
        seed = seed * 1664525 + 1013904223;
        ((uint16_t *)v.ids)[i] = (uint16_t)((seed >> 8) % (uint32_t)v.label_count);
    }
    sc_test_operations = 0;
    assert_int_equal(sc_resample(&ctx, &v, &grid, 1), p->wanted);
}

/* Load a job; what it says may be wrong, but it is parsed to its end. */
static void load(const sc_job_sources *sources, sc_status wanted)
{
    SC_OWN(sc_job_clear) sc_job job = {0};

    sc_test_operations = 0;
    assert_int_equal(sc_job_load(&ctx, sources, &job), wanted);
}

static void parse_job(const parser *p, int n)
{
    const sc_job_sources sources = {.path = "c.yaml"};

    write_input(p, n, 0, "c.yaml");
    load(&sources, p->wanted);
    unlink("c.yaml");
}

/* n settings, as of --set, or with wanted SC_OK and an empty part one setting with n members. */
static void parse_settings(const parser *p, int n)
{
    sc_setting *settings = calloc((size_t)n, sizeof *settings);
    char(*paths)[64] = calloc((size_t)n, sizeof *paths);
    const sc_job_sources sources = {.settings = settings, .setting_count = (size_t)n};

    assert_true(settings && paths);
    settings[0] = (sc_setting){"--set", "volume", "phantom", false};
    for (int i = 1; i < n; i++) {
        snprintf(paths[i], sizeof paths[i], p->part, i, i);
        settings[i] = (sc_setting){"--set", paths[i], p->tail, false};
    }
    load(&sources, p->wanted);
    free(settings);
    free(paths);
}

/* n variables of the environment. */
static void parse_environment(const parser *p, int n)
{
    const char **environment = calloc((size_t)n + 2, sizeof *environment);
    char(*texts)[64] = calloc((size_t)n, sizeof *texts);
    const sc_job_sources sources = {.environment = environment};

    assert_true(environment && texts);
    environment[0] = "SEGCAST_VOLUME=phantom";
    for (int i = 0; i < n; i++) {
        snprintf(texts[i], sizeof texts[i], p->part, i, i);
        environment[i + 1] = texts[i];
    }
    load(&sources, p->wanted);
    free(environment);
    free(texts);
}

/* n options of the command line, and as many settings. */
static void parse_options(const parser *p, int n)
{
    static const sc_command command = {.name = "render", .argument = "JOB.yaml"};
    char **argv = calloc((size_t)n + 4, sizeof *argv);
    char(*texts)[64] = calloc((size_t)n, sizeof *texts);
    SC_OWN(sc_options_clear) sc_options options = {0};

    assert_true(argv && texts);
    argv[0] = (char[]){"segcast"};
    argv[1] = (char[]){"render"};
    for (int i = 0; i < n; i++) {
        snprintf(texts[i], sizeof texts[i], p->part, i, i);
        argv[i + 2] = texts[i];
    }
    argv[n + 2] = (char[]){"job.yaml"};
    optind = 1; /* getopt_long begins anew */
    sc_test_operations = 0;
    assert_int_equal(sc_options_parse(&ctx, &command, n + 3, argv, &options), p->wanted);
    free(argv);
    free(texts);
}

/* A manifest with n lines of frames, n lines of files, or n names in its head: those that `part`
 * makes. */
static void parse_manifest(const parser *p, int n)
{
    const sc_store_job job = {
        .version = "1", .frames = n, .video = "none", .settings = {.width_px = 1, .height_px = 1}};
    SC_OWN(sc_manifest_data_clear) sc_manifest_data data = {.frames = n}, read = {.frames = n};
    char name[64];

    data.lines = calloc((size_t)n, sizeof *data.lines);
    read.lines = calloc((size_t)n, sizeof *read.lines);
    assert_true(data.lines && read.lines);
    for (int i = 0; i < n; i++) {
        snprintf(name, sizeof name, p->part, i * 7919 % n);
        if (!strcmp(p->head, "frames"))
            data.lines[i] = (sc_frame_line){true, {.frame = i}};
        else if (!strcmp(p->head, "files"))
            assert_ok(sc_file_lines_put(&ctx, &data.files, name, 1, 2));
        else
            assert_ok(sc_names_add(&ctx, &data.owned, name));
    }
    assert_ok(sc_manifest_create(&ctx, "c.jsonl", &job, &data, NULL, true, NULL, NULL));
    sc_test_operations = 0;
    assert_int_equal(sc_manifest_read(&ctx, "c.jsonl", &read), p->wanted);
    assert_true(read.closed);
    assert_true(read.count == n || read.files.count == n || read.owned.count == n);
    free(data.lines);
    free(read.lines);
    data.lines = read.lines = NULL;
    unlink("c.jsonl");
}

/* Write a line with the proof that the lines of a manifest have; @p text lacks its closing brace.
 */
static void write_proved(FILE *file, const sc_text *text, uint64_t *chain)
{
    *chain = sc_hash_bytes(text->data, text->length_bytes, *chain);
    fprintf(file, "%s,\"line\":\"%016llx\"}\n", text->data, (unsigned long long)*chain);
}

/* A forged manifest: n names in its head, or n lines of files or of texts of job.yaml, in falling
 * order. segcast itself writes them in rising order. */
static void parse_forged_manifest(const parser *p, int n)
{
    const bool names = !strcmp(p->head, "names"), jobs = !strcmp(p->head, "jobs");
    SC_OWN(sc_manifest_data_clear) sc_manifest_data read = {.frames = n};
    FILE *file = fopen("c.jsonl", "w");
    sc_text line = {0};
    uint64_t chain = 0;

    assert_non_null(file);
    assert_ok(sc_text_add(&ctx, &line,
                          "{\"schema\":\"segcast-manifest-3\",\"version\":\"1\","
                          "\"job_hash\":\"%016x\",\"volume_hash\":\"%016x\",\"frames\":1,"
                          "\"size\":[1,1],\"owns\":[",
                          1, 2));
    for (int i = names ? n : 0; i > 0; i--)
        assert_ok(sc_text_add(&ctx, &line, "\"stats.%06d.json\"%s", i, i > 1 ? "," : ""));
    assert_ok(sc_text_add(&ctx, &line, "]"));
    write_proved(file, &line, &chain);
    for (int i = names ? 0 : n; i > 0; i--) {
        char name[32] = "job.yaml";

        if (!jobs)
            snprintf(name, sizeof name, "stats.%06d.json", i);
        sc_text_clear(&line);
        assert_ok(
            sc_text_add(&ctx, &line, "{\"file\":\"%s\",\"bytes\":1,\"hash\":\"%016x\"", name, i));
        write_proved(file, &line, &chain);
    }
    sc_text_clear(&line);
    fclose(file);
    sc_test_operations = 0;
    assert_int_equal(sc_manifest_read(&ctx, "c.jsonl", &read), p->wanted);
    assert_int_equal(names ? read.owned.count : jobs ? read.jobs.count : read.files.count, n);
    unlink("c.jsonl");
}

/* Statistics of n runs, each of which drew a frame, read again into what they gave. */
static void parse_statistics(const parser *p, int n)
{
    SC_OWN(sc_history_clear) sc_history history = {0};
    FILE *file = fopen("c.json", "w");

    assert_non_null(file);
    fputs("{\"job_hash\": \"0000000000000001\", \"volume_hash\": \"0000000000000002\", \"runs\": [",
          file);
    for (int i = 0; i < n; i++)
        fprintf(file,
                "%s{\"id\": \"%016x\", \"ended\": true, \"hosts\": [\"a\"], \"ranks\": 1, "
                "\"nodes\": 1, "
                "\"threads\": 1, \"wall_s\": 1, \"cpu_s\": 1, \"farm_wall_s\": 1, \"frames\": 1}",
                i ? "," : "", i * 7919 % n);
    fputs("], \"frames\": [", file);
    for (int i = 0; i < n; i++)
        fprintf(file,
                "%s{\"frame\": %d, \"run\": %d, \"rank\": 0, \"render_wall_s\": 1, "
                "\"render_cpu_s\": 1, \"wait_s\": 0, \"rays\": 1, \"samples\": 1, "
                "\"contributions\": 1, \"hash\": \"%016x\"}",
                i ? "," : "", i * 7919 % n, i, i);
    fputs("]}", file);
    fclose(file);
    sc_test_operations = 0;
    for (int time = 0; time < 2; time++)
        assert_int_equal(sc_history_read(&ctx, "c.json", &(sc_job_hashes){1, 2}, &history),
                         p->wanted);
    assert_int_equal(history.run_count, n);
    assert_int_equal(history.frame_count, n);
    unlink("c.json");
}

#define NRRD                                                                                       \
    "NRRD0005\ntype: uint8\ndimension: 3\nspace: RAS\nsizes: 4 4 4\n"                              \
    "space directions: (1,0,0) (0,1,0) (0,0,1)\nencoding: raw\n"
#define META "NDims = 3\nDimSize = 4 4 4\nElementType = MET_UCHAR\n"
#define LOCAL "ElementDataFile = LOCAL\n"

static const parser parsers[] = {
    {"table of Slicer", parse_table, "", "%d name_%d 1 2 3 255\n", "", SC_TABLE_SLICER, SC_OK,
     3000},
    {"table of FreeSurfer", parse_table, "", "%d name-%d 1 2 3 0\n", "", SC_TABLE_FREESURFER, SC_OK,
     3000},
    {"table of ITK-SNAP", parse_table, "", "%d 1 2 3 1 1 1 \"name %d\"\n", "", SC_TABLE_ITKSNAP,
     SC_OK, 3000},
    {"table to be guessed", parse_table, "", "%d name_%d 1 2 3 255\n", "", SC_TABLE_AUTO, SC_OK,
     3000},
    {"table with names in quotes to be guessed", parse_table, "# x\n", "%d 1 2 3 1 1 1 \"n %d\"\n",
     "", SC_TABLE_AUTO, SC_OK, 3000},
    {"table of columns", parse_table, "value,name,color\n", "%d,\"name %d\",#010203\n", "",
     SC_TABLE_AUTO, SC_OK, 3000},
    {"quotation mark without end", parse_table, "value,name\n1,\"", "n%d\n", "", SC_TABLE_AUTO,
     SC_OK, 3000},
    {"table in JSON", parse_table, "[", "{\"value\": %d, \"name\": \"n%d\"},", "0]", SC_TABLE_AUTO,
     SC_OK, 3000},
    {"names in JSON", parse_table, "{", "\"n%d\": %d,", "\"x\": 1}", SC_TABLE_AUTO, SC_OK, 3000},
    {"comments of a table", parse_table, "", "# a comment %d\n", "1 a 1 2 3\n", SC_TABLE_AUTO,
     SC_OK, 3000},
    {"lines of another form", parse_table, "1 a 1 2 3\n", "nonsense %d\n", "", SC_TABLE_AUTO, SC_OK,
     3000},
    {"lines that end with CR", parse_table, "", "%d name_%d 1 2 3 255\r", "", SC_TABLE_AUTO, SC_OK,
     3000},
    {"table of one line", parse_table, "1 ", "n%d", " 1 2 3 255\n", SC_TABLE_AUTO, SC_OK, 30000},
    {"names that are no UTF-8", parse_table, "", "%d \xff\xfe 1 2 3 255\n", "", SC_TABLE_AUTO,
     SC_OK, 3000},
    {"table in XML", parse_table, "<LabelTable>", "<Label Key=\"%d\" Red=\"1\">n %d</Label>\n",
     "</LabelTable>", SC_TABLE_XML, SC_HAVE_EXPAT ? SC_OK : SC_ERR_DATA, 3000},
    {"segments", parse_volume, NRRD, "Segment%d_ID:=s%d\nSegment%d_Name:=n\n", "\n", 0, SC_OK,
     3000},
    {"other keys of NRRD", parse_volume, NRRD, "key %d:=value %d\n", "\n", 0, SC_OK, 3000},
    {"comments of NRRD", parse_volume, NRRD, "# comment %d\n", "\n", 0, SC_OK, 3000},
    {"one key again and again", parse_volume, NRRD, "Segment0_ID:=s%d\n", "\n", 0, SC_OK, 3000},
    {"a long value", parse_volume, NRRD "Segment0_ID:=", "%d \\n ", "\n\n", 0, SC_OK, 30000},
    {"a long field", parse_volume, NRRD "content: ", "%d ", "\n\n", 0, SC_OK, 30000},
    {"lines that are no fields", parse_volume, NRRD, "nonsense %d\n", "\n", 0, SC_ERR_DATA, 3000},
    {"no empty line", parse_volume, NRRD, "key %d:=value\r", "", 0, SC_ERR_DATA, 3000},
    {"list of data files", parse_list,
     "NRRD0005\ntype: uint8\ndimension: 3\nspace: RAS\nsizes: 1 1 %d\n"
     "space directions: (1,0,0) (0,1,0) (0,0,1)\nencoding: raw\ndata file: LIST\n",
     "c.raw\n", "\n", 0, SC_OK, 500},
    {"numbers of encoding ascii", parse_numbers,
     "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 100 %d 16\nencoding: ascii\n\n", "3 ", "", 0,
     SC_OK, 1000},
    {"voxels of NRRD", parse_numbers,
     "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 100 %d 16\nencoding: raw\n\n", "3", "", 0, SC_OK,
     10000},
    {"voxels of MetaImage", parse_numbers,
     "NDims = 3\nDimSize = 100 %d 16\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n", "3", "",
     0, SC_OK, 10000},
    {"voxels of NIfTI", parse_nifti, "", "", "", 0, SC_OK, 10000},
    {"comments of MetaImage", parse_volume, META, "Comment = %d\n", LOCAL, 0, SC_OK, 3000},
    {"a long line of MetaImage", parse_volume, META "Comment = ", "%d ", "\n" LOCAL, 0, SC_OK,
     30000},
    {"tissues", parse_job, "volume: phantom\ntissues:\n", "  t%d: {opacity: 0.5}\n", "", 0, SC_OK,
     2000},
    {"key frames of colors", parse_job, "volume: phantom\ntissues:\n",
     "  t%d: {color: {0%%: red, 100%%: blue}}\n", "", 0, SC_OK, 700},
    {"unknown keys", parse_job, "volume: phantom\n", "key%d: %d\n", "", 0, SC_ERR_DATA, 2000},
    {"wrong values", parse_job, "volume: phantom\ntissues:\n", "  t%d: {opacity: %d}\n", "", 0,
     SC_ERR_DATA, 2000},
    {"one key twice at the end", parse_job, "volume: phantom\ntissues:\n", "  t%d: {}\n",
     "  t1: {}\n", 0, SC_ERR_DATA, 2000},
    {"items of a list", parse_job, "volume: [", "%d, ", "1]\n", 0, SC_ERR_DATA, 20000},
    {"a long text", parse_job, "volume: phantom\noutput: {title: \"", "%d ", "\"}\n", 0,
     SC_ERR_DATA, 30000},
    {"captions", parse_job, "volume: phantom\noverlays:\n  caption:\n", "    %df: a\n", "", 0,
     SC_ERR_DATA, 2000},
    {"shots", parse_job, "volume: phantom\nshots:\n", "  - {name: a%d, animation: {frames: 3}}\n",
     "", 0, SC_ERR_DATA, 1000},
    {"keys of shots", parse_job,
     "volume: phantom\nshots:\n  - animation: {frames: 3}\n    tissues:\n",
     "      t%d: {opacity: 0.5}\n", "", 0, SC_OK, 2000},
    {"key frames", parse_job, "volume: phantom\nlight:\n  key:\n", "    %df: 0.5\n", "", 0,
     SC_ERR_DATA, 2000},
    {"verbs", parse_job, "volume: phantom\nanimation:\n  verbs:\n", "    - {fade: t%d, to: 0.5}\n",
     "", 0, SC_ERR_DATA, 1000},
    {"tissues of a verb", parse_job, "volume: phantom\nanimation: {verbs: [{fade: [", "t%d, ",
     "a], to: 0.5}]}\n", 0, SC_OK, 2000},
    {"tissues to keep", parse_job, "volume: {path: phantom, keep: [", "t%d, ", "a]}\n", 0, SC_OK,
     2000},
    {"tissues to merge", parse_job, "volume:\n  path: phantom\n  merge:\n", "    m%d: [a%d, b%d]\n",
     "", 0, SC_OK, 2000},
    {"tissues of the legend", parse_job, "volume: phantom\noverlays: {legend: {top: [", "t%d, ",
     "a]}}\n", 0, SC_OK, 2000},
    {"phases of a beat", parse_job, "cine: {bpm: 60}\nvolume: [", "p%d.nrrd, ", "a.nrrd]\n", 0,
     SC_OK, 400},
    {"too many phases", parse_job, "cine: {bpm: 60}\nvolume: [", "p%d.nrrd, ", "a.nrrd]\n", 0,
     SC_ERR_DATA, 2000},
    {"chosen phases", parse_job, "cine: {bpm: 60, phases: [", "%d, ", "1]}\nvolume: [a, b]\n", 0,
     SC_ERR_DATA, 2000},
    {"volumes to compare", parse_job, "volume: phantom\ncompare: {with: [", "v%d.nrrd, ",
     "a.nrrd]}\n", 0, SC_ERR_DATA, 2000},
    {"exceptions of a clip plane", parse_job,
     "volume: phantom\nanimation: {clip: [{normal: left, at: 50%, except: [", "t%d, ", "a]}]}\n", 0,
     SC_OK, 2000},
    {"settings", parse_settings, "", "tissues.t%d.opacity", "0.5", 0, SC_OK, 2000},
    {"settings of one key", parse_settings, "", "render.quality", "still", 0, SC_OK, 2000},
    {"settings that name no key", parse_settings, "", "nothing%d", "4", 0, SC_ERR_USAGE, 2000},
    {"variables of the environment", parse_environment, "", "SEGCAST_RENDER_QUALITY=still", "", 0,
     SC_OK, 2000},
    {"variables that name no key", parse_environment, "", "SEGCAST_%d_X=4", "", 0, SC_OK, 2000},
    {"frames of a manifest", parse_manifest, "frames", "%d", "", 0, SC_OK, 3000},
    {"files of a manifest", parse_manifest, "files", "stats.%d.json", "", 0, SC_OK, 3000},
    {"names in the head of a manifest", parse_manifest, "names", "stats.%d.json", "", 0, SC_OK,
     3000},
    {"files of a forged manifest", parse_forged_manifest, "files", "", "", 0, SC_OK, 3000},
    {"texts of the job in a forged manifest", parse_forged_manifest, "jobs", "", "", 0, SC_OK,
     3000},
    {"names in the head of a forged manifest", parse_forged_manifest, "names", "", "", 0, SC_OK,
     3000},
    {"values of tissues", parse_values, "name,mm\n", "t%d,1.5\n", "", 0, SC_OK, 3000},
    {"values of tissues by number", parse_values, "index\tvolume\n", "%d\t%d\n", "", 0, SC_OK,
     3000},
    {"columns of a table of values", parse_values, "name,mm", ",c%d", "\na,1\n", 0, SC_ERR_DATA,
     1500},
    {"values that are no numbers", parse_values, "name,mm\n", ",%d\n", "a,1\n", 0, SC_OK, 3000},
    {"masks of a directory", parse_masks, "", "", "", 0, SC_OK, 200},
    {"labels of OME-Zarr", parse_zarr,
     "{\"multiscales\": [{\"axes\": [{\"name\": \"z\"}, {\"name\": \"y\"}, {\"name\": \"x\"}], "
     "\"datasets\": [{\"path\": \"0\"}]}], \"image-label\": {\"properties\": [",
     "{\"label-value\": %d, \"name\": \"n%d\"},", "{\"label-value\": 0}]}}", 0, SC_OK, 3000},
    {"levels of OME-Zarr", parse_zarr,
     "{\"multiscales\": [{\"axes\": [{\"name\": \"z\"}, {\"name\": \"y\"}, {\"name\": \"x\"}], "
     "\"datasets\": [{\"path\": \"0\"}",
     ",{\"path\": \"%d\"}", "]}]}", 0, SC_OK, 3000},
    {"properties of segments", parse_properties,
     "{\"@type\": \"neuroglancer_segment_properties\", \"inline\": {\"ids\": [", "\"%d\",",
     "\"999999\"], \"properties\": []}}", 0, SC_OK, 3000},
    {"chunks of a minishard", parse_shard,
     "{\"data_type\": \"uint8\", \"num_channels\": 1, \"scales\": [{\"key\": \"s\", \"size\": "
     "[%d, 1, 1], \"encoding\": \"raw\", \"chunk_sizes\": [[4, 1, 1]], \"resolution\": [1, 1, 1], "
     "\"sharding\": {\"@type\": \"neuroglancer_uint64_sharded_v1\", \"hash\": \"identity\", "
     "\"preshift_bits\": 0, \"minishard_bits\": 0, \"shard_bits\": 0}}]}",
     "", "", 0, SC_OK, 2000},
    {"chunks by turns in two minishards", parse_minishards,
     "{\"data_type\": \"uint8\", \"num_channels\": 1, \"scales\": [{\"key\": \"s\", \"size\": "
     "[%d, 1, 1], \"encoding\": \"raw\", \"chunk_sizes\": [[4, 1, 1]], \"resolution\": [1, 1, 1], "
     "\"sharding\": {\"@type\": \"neuroglancer_uint64_sharded_v1\", \"hash\": \"identity\", "
     "\"preshift_bits\": 0, \"minishard_bits\": 1, \"shard_bits\": 0}}]}",
     "", "", 0, SC_OK, 100},
    {"chunks by turns in two shards of Zarr", parse_zarr_shards,
     "{\"zarr_format\": 3, \"node_type\": \"array\", \"shape\": [1, %d, 4], \"data_type\": "
     "\"uint8\", \"fill_value\": 0, \"chunk_grid\": {\"name\": \"regular\", \"configuration\": "
     "{\"chunk_shape\": [1, %d, 2]}}, \"chunk_key_encoding\": {\"name\": \"default\"}, "
     "\"codecs\": [{\"name\": \"sharding_indexed\", \"configuration\": {\"chunk_shape\": [1, 1, "
     "1], \"codecs\": [{\"name\": \"bytes\"}], \"index_codecs\": [{\"name\": \"bytes\", "
     "\"configuration\": {\"endian\": \"little\"}}, {\"name\": \"crc32c\"}]}}]}",
     "", "", 0, SC_OK, 20},
#if SC_HAVE_TIFF
    {"pages of TIFF", parse_tiff, "", "", "", 0, SC_OK, 8000},
#endif
#if SC_HAVE_DICOM
    {"segments and frames of DICOM", parse_dicom, "", "", "", 0, SC_OK, 8000},
#endif
    {"voxels of MGH", parse_mgh, "", "", "", 0, SC_OK, 5000},
    {"values of an axis of a study", parse_study, "set: {volume: phantom}\nsweep: {output.crf: [",
     "%d, ", "1]}\n", 0, SC_ERR_DATA, 2000},
    {"axes of a study", parse_study, "set: {volume: phantom}\nsweep:\n", "  a%d: [%d]\n", "", 0,
     SC_ERR_DATA, 2000},
    {"settings of a study", parse_study, "set:\n  volume: phantom\n", "  k%d: %d\n", "", 0,
     SC_ERR_DATA, 2000},
    {"measurements", parse_measurements,
     "{\"schema\":\"segcast-study-1\",\"study\":\"c8d8dd75985d3986\",\"title\":\"small\","
     "\"measure\":\"frames\",\"metric\":\"cpu\",\"axes\":[{\"name\":\"ranks\",\"values\":[\"1\","
     "\"2\"]}]}\n",
     "{\"measurement\":{\"cell\":0,\"round\":%d,\"passes\":3,\"frames\":2,\"ranks\":1,\"nodes\":1,"
     "\"threads\":2,\"begin_unix_s\":1795386060,\"wall_s\":0.03,\"cpu_s\":0.01,\"draw_cpu_s\":0.01,"
     "\"draw_most_s\":0.02,\"draw_mean_s\":0.02,\"idle_mean_s\":0.003,\"gather_mean_s\":3e-5,"
     "\"accept_s\":2e-6,\"read_s\":0.7,\"prepare_s\":0.8,\"share_s\":0.1,\"prepare_cpu_s\":0.5,"
     "\"derive_s\":0.2,\"derive_cpu_s\":0.06,\"rays\":3833,\"samples\":93319,\"contributions\":"
     "10418,"
     "\"peak_rss_most_bytes\":31604736,\"peak_rss_sum_bytes\":31604736,\"prepared_bytes\":36736,"
     "\"energy_j\":-1.0,\"pixels_hash\":\"47c157909320e184\"}}\n",
     "", 0, SC_OK, 1000},
    {"statistics of many runs", parse_statistics, "", "", "", 0, SC_OK, 3000},
    {"voxels that all differ", find_copies, "12", "12", "1", 0, SC_OK, 3000},
    {"voxels drawn at random", find_copies, "", "", "1", 0, SC_OK, 3000},
    {"voxels copied twice", find_copies, "1122", "1122", "2", 0, SC_OK, 4000},
    {"voxels copied 2.5 times", find_copies, "11222", "11222", "2.5", 0, SC_OK, 4000},
    {"voxels copied 3.5 times, a half of them", find_copies, "1112222", "", "1", 0, SC_OK, 4200},
    {"voxels copied in two ways", find_copies, "11222", "1112222", "1", 0, SC_OK, 4200},
    {"labels scattered over thick slices", split_scattered, "", "", "", 0, SC_OK, 4800},
    {"options", parse_options, "", "--set=tissues.t%d.opacity=0.5", "", 0, SC_OK, 100},
    {"options of one kind", parse_options, "", "--quiet", "", 0, SC_OK, 4000},
};

TEST(twice_the_input_costs_twice_the_operations)
{
    int failed = 0;

    for (size_t i = 0; i < SC_COUNT_OF(parsers); i++) {
        const parser *p = &parsers[i];
        uint64_t once, twice;
        double ratio;

        p->parse(p, p->n);
        once = sc_test_operations;
        p->parse(p, 2 * p->n);
        twice = sc_test_operations;
        ratio = (double)twice / (double)once;
        print_message("%-42s %9llu %10llu  %.2f\n", p->name, (unsigned long long)once,
                      (unsigned long long)twice, ratio);
        if (!(ratio < 2.5) || once < (uint64_t)p->n)
            failed++;
    }
    assert_int_equal(failed, 0);
}

RUN_TESTS(NULL, NULL)
