/* SPDX-License-Identifier: BSD-3-Clause */
/* The input is a list of changes (fuzz_patch) to a file of a partial GOP with three pictures,
 * behind a byte: how much of its end is cut off, in 1/255 of it. The hash of each picture is made
 * to fit. */
#include "../../src/store/internal.h"
#include "fuzz.h"

enum { FRAMES = 6, PICTURES = 3, PICTURE_BYTES = 96, HEAD_BYTES = 48, IDENTITY = 7 };
enum { RECORD_BYTES = HEAD_BYTES + PICTURE_BYTES };

/* Write a valid file: heads of magic, hash, identity, length, hash of the pixels and frame. */
static void make_valid(uint8_t *file)
{
    for (uint64_t k = 0; k < PICTURES; k++) {
        const uint64_t fields[] = {IDENTITY, PICTURE_BYTES, k * k, k};
        uint8_t *record = file + k * RECORD_BYTES;

        memcpy(record, "segpart\x01", 8);
        memcpy(record + 16, fields, sizeof fields);
        memset(record + HEAD_BYTES, (int)k, PICTURE_BYTES);
    }
}

static void repair(uint8_t *file)
{
    for (int k = 0; k < PICTURES; k++) {
        uint8_t *record = file + k * RECORD_BYTES;
        uint64_t hash = sc_hash_bytes(record + 16, HEAD_BYTES - 16, 0);

        hash = sc_hash_bytes(record + HEAD_BYTES, PICTURE_BYTES, hash);
        memcpy(record + 8, &hash, sizeof hash);
    }
}

/* Scan the file, and read back the pictures that it is said to hold. @return how many. */
static int scan(const char *path)
{
    uint8_t picture[PICTURE_BYTES];
    SC_OWN(sc_partial_close) sc_partial_gops partial = {0};
    int found = 0;

    FUZZ_CHECK(sc_partial_open(&fuzz_ctx, fuzz_folder, IDENTITY, PICTURE_BYTES, FRAMES, &partial) ==
               SC_OK);
    FUZZ_CHECK(sc_partial_scan(&fuzz_ctx, &partial, path, 0, FRAMES - 1) == SC_OK);
    for (int k = 0; k < FRAMES; k++) {
        if (partial.locations[k].file < 0)
            continue;
        FUZZ_CHECK(k < FRAMES - 1);
        FUZZ_CHECK(sc_partial_read(&fuzz_ctx, &partial, k, picture) == SC_OK);
        found++;
    }
    return found;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const fuzz_region regions[] = {{0, HEAD_BYTES},
                                   {RECORD_BYTES, HEAD_BYTES},
                                   {2 * RECORD_BYTES, HEAD_BYTES},
                                   {0, PICTURES * RECORD_BYTES}};
    uint8_t file[PICTURES * RECORD_BYTES] = {0};
    size_t bytes = sizeof file;

    make_valid(file);
    if (size)
        fuzz_patch(file, regions, SC_COUNT_OF(regions), data + 1, size - 1);
    repair(file);
    if (size)
        bytes -= bytes * data[0] / 255;
    FUZZ_CHECK(scan(fuzz_write("000000.host.1.part", file, bytes)) <= PICTURES);
    return 0;
}
