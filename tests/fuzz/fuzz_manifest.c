/* SPDX-License-Identifier: BSD-3-Clause */
/* The input is a manifest without the proofs of its lines: each line that ends with "}" gets its
 * own. */
#include "../../src/store/internal.h"
#include "fuzz.h"

enum { FRAMES = 6 };

/* Append the lines of the input to @p text, with proofs. */
static void prove(const uint8_t *data, size_t size, sc_text *text)
{
    uint64_t chain = 0;

    for (size_t at = 0, length; at < size; at += length + 1) {
        const char *line = (const char *)data + at;
        const char *end = memchr(line, '\n', size - at);
        const bool proven = end && end > line && end[-1] == '}';
        const size_t kept = (end ? (size_t)(end - line) : size - at) - proven;

        length = kept + proven;
        if (memchr(line, 0, length))
            return; /* sc_text holds text; NUL bytes are tried by unit.store */
        FUZZ_CHECK(sc_text_add(&fuzz_ctx, text, "%.*s", (int)kept, line) == SC_OK);
        chain = sc_hash_bytes(line, kept, chain);
        if (proven)
            FUZZ_CHECK(sc_text_add(&fuzz_ctx, text, ",\"line\":\"%016llx\"}",
                                   (unsigned long long)chain) == SC_OK);
        FUZZ_CHECK(sc_text_add(&fuzz_ctx, text, end ? "\n" : "%s", "") == SC_OK);
    }
}

/* What is read is within range, and no name leads out of the directory. */
static void check(const sc_manifest_data *data)
{
    for (int i = 0; i < data->owned.count; i++)
        FUZZ_CHECK(sc_own_name(data->owned.lines[i].name));
    for (int i = 0; i < data->files.count; i++)
        FUZZ_CHECK(sc_own_name(data->files.lines[i].name));
    for (int k = 0; k < FRAMES; k++)
        FUZZ_CHECK(!data->lines[k].known || data->lines[k].done.frame == k);
    if (data->head.known)
        FUZZ_CHECK(data->head.frames > 0 && data->head.frames <= SC_STORE_FRAMES_MAX);
    if (data->end.known && data->end.video[0])
        FUZZ_CHECK(!strchr(data->end.video, '/') && sc_own_name(data->end.video));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    sc_frame_line lines[FRAMES] = {{.known = false}};
    SC_OWN(sc_manifest_data_clear) sc_manifest_data read = {.lines = lines, .frames = FRAMES};
    SC_OWN(sc_text_clear) sc_text text = {0}, names = {0};
    sc_store_job job = {.video = "none"};
    sc_store_report report;
    char version[64];
    const char *path;

    prove(data, size, &text);
    path = fuzz_write("manifest.jsonl", text.data ? text.data : "", text.length_bytes);
    FUZZ_CHECK(sc_manifest_read(&fuzz_ctx, path, &read) == SC_OK);
    check(&read);
    FUZZ_CHECK(sc_store_status(&fuzz_ctx, fuzz_folder, NULL, 0, &report) == SC_OK);
    FUZZ_CHECK(read.head.known || report.condition != SC_STORE_COMPLETE);
    if (sc_store_identify(&fuzz_ctx, fuzz_folder, &job, version) == SC_OK)
        FUZZ_CHECK(read.head.known && job.frames == read.head.frames);
    if (sc_store_verify_records(&fuzz_ctx, fuzz_folder, &names) == SC_OK)
        FUZZ_CHECK(read.closed);
    return 0;
}
