/* SPDX-License-Identifier: BSD-3-Clause */
/* The input is a file of measurements. All that a study makes of one that is accepted can be made:
 * results, tables and pages, also beside itself. */
#include "fuzz.h"
#include "segcast/report.h"

/* Make all that follows from measurements. */
static void use(const sc_measurements *read)
{
    const sc_measurements both[2] = {*read, *read};
    const char *const names[2] = {"first", "second"};
    sc_cell_result *results;
    sc_text text = {0};

    FUZZ_CHECK(sc_cell_results(&fuzz_ctx, read, &results) == SC_OK);
    FUZZ_CHECK(sc_cells_write_csv(&fuzz_ctx, read, results, fuzz_path("cells.csv")) == SC_OK);
    FUZZ_CHECK(sc_cells_write_extrap(&fuzz_ctx, read, fuzz_path("extrap.jsonl")) == SC_OK);
    sc_free(results);
    FUZZ_CHECK(sc_report_study(&fuzz_ctx, "study", read, &text) == SC_OK);
    sc_text_clear(&text);
    FUZZ_CHECK(sc_report_study_markdown(&fuzz_ctx, read, &text) == SC_OK);
    sc_text_clear(&text);
    FUZZ_CHECK(sc_report_compare_studies(&fuzz_ctx, names, both, 2, &text) == SC_OK);
    sc_text_clear(&text);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const char *path = fuzz_write("measurements.jsonl", data, size);
    SC_OWN(sc_measurements_clear) sc_measurements read = {0};
    uint64_t whole_bytes = 0;
    const sc_status status = sc_measurements_read(&fuzz_ctx, path, &read, &whole_bytes);

    FUZZ_CHECK(status == SC_OK || status == SC_ERR_DATA);
    if (status == SC_OK) {
        FUZZ_CHECK(whole_bytes <= size);
        use(&read);
    }
    return 0;
}
