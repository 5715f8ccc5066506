/* SPDX-License-Identifier: BSD-3-Clause */
/* The input is the stats.json of a run, and behind a line "----" its trace.json. The page of the
 * run can be made if the statistics are accepted, and one that compares it with itself. */
#include "fuzz.h"
#include "segcast/report.h"

static const char divider[] = "\n----\n";

/* @return where the divider begins, or @p size. */
static size_t find_divider(const uint8_t *data, size_t size)
{
    const size_t bytes = sizeof divider - 1;

    for (size_t at = 0; at + bytes <= size; at++) {
        if (!memcmp(data + at, divider, bytes))
            return at;
    }
    return size;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const size_t stats = find_divider(data, size);
    const size_t trace = stats < size ? stats + sizeof divider - 1 : size;
    sc_text page = {0};
    sc_status status;

    (void)fuzz_write("stats.json", data, stats);
    (void)fuzz_write("trace.json", data + trace, size - trace);
    status = sc_report_make(
        &fuzz_ctx,
        &(sc_report_run){
            .directory = fuzz_folder, .title = "", .video = "none", .frames = 5, .fps = 30},
        &page);
    FUZZ_CHECK(status == SC_OK || status == SC_ERR_DATA);
    sc_text_clear(&page);
    if (status == SC_OK) {
        const char *const directories[2] = {fuzz_folder, fuzz_folder};

        FUZZ_CHECK(sc_report_compare(&fuzz_ctx, directories, 2, &page) == SC_OK);
        sc_text_clear(&page);
    }
    return 0;
}
