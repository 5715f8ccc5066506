/* SPDX-License-Identifier: BSD-3-Clause */
/* The input is what a page of the desk asks for, as the line "key.path=value", and a job file
 * behind it. What is not a change of the file is refused, and a second change of the same key to
 * the same value changes nothing more. */
#include "fuzz.h"
#include "segcast/job.h"

/* @return whether the text is a job file, apart from its values. */
static bool is_job(const char *text)
{
    const sc_job_sources sources = {.path = "job.yaml", .text = text};
    SC_OWN(sc_text_clear) sc_text tree = {0};

    return sc_job_write_tree(&fuzz_ctx, &sources, &tree) == SC_OK;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    SC_OWN(sc_free_at) char *input = NULL;
    SC_OWN(sc_text_clear) sc_text once = {0}, twice = {0};
    sc_setting setting = {.origin = "the input"};
    char *text, *value;

    FUZZ_CHECK(SC_ALLOC(&fuzz_ctx, size + 1, &input) == SC_OK);
    memcpy(input, data, size);
    input[size] = '\0';
    text = strchr(input, '\n');
    value = strchr(input, '=');
    if (!text || !value || value > text || strlen(input) < size)
        return 0;
    *text++ = '\0';
    *value++ = '\0';
    setting.path = input;
    setting.value = value;
    if (!is_job(text) || sc_job_rewrite(&fuzz_ctx, text, &setting, &once) != SC_OK ||
        !is_job(once.data))
        return 0;
    if (sc_job_rewrite(&fuzz_ctx, once.data, &setting, &twice) == SC_OK)
        FUZZ_CHECK(strlen(twice.data) <= strlen(once.data) + strlen(value) + 64);
    return 0;
}
