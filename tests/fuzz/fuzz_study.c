/* SPDX-License-Identifier: BSD-3-Clause */
/* The input is a study file. What segcast writes of a study that it accepts is accepted, too, and
 * is the same study. The settings of its first and last cells can be made. */
#include "fuzz.h"
#include "segcast/study_file.h"

/* Make the settings of a cell. */
static void make_cell(const sc_study *study, int cell)
{
    sc_study_settings settings = {0};

    for (int axis = 0; axis < study->axis_count; axis++)
        FUZZ_CHECK(sc_study_value_of(study, cell, axis));
    FUZZ_CHECK(sc_study_cell(&fuzz_ctx, study, cell, &settings) == SC_OK);
    sc_free(settings.items);
}

/* Load the study @p path, and write all of it. @return false if it is refused. */
static bool load(const char *path, sc_text *text)
{
    SC_OWN(sc_study_clear) sc_study study = {0};
    const sc_status status = sc_study_load(&fuzz_ctx, path, &study);

    FUZZ_CHECK(status != SC_ERR_INTERNAL && status != SC_ERR_MEMORY);
    if (status == SC_OK) {
        FUZZ_CHECK(sc_study_cells(&study) >= 1);
        make_cell(&study, 0);
        make_cell(&study, sc_study_cells(&study) - 1);
        FUZZ_CHECK(sc_study_write(&fuzz_ctx, &study, text) == SC_OK);
    }
    return status == SC_OK;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    SC_OWN(sc_text_clear) sc_text first = {0}, again = {0};

    if (load(fuzz_write("study.yaml", data, size), &first)) {
        FUZZ_CHECK(load(fuzz_write("again.yaml", first.data, first.length_bytes), &again));
        if (getenv("FUZZ_TELL"))
            fprintf(stderr, "first:\n%sagain:\n%s", first.data, again.data);
        FUZZ_CHECK(!strcmp(first.data, again.data));
    }
    return 0;
}
