/* SPDX-License-Identifier: BSD-3-Clause */
/* The input is a job file. What segcast writes of a job that it accepts is accepted, too, and is
 * the same job: its identity, on which the pictures depend, and all of its keys. */
#include "fuzz.h"
#include "segcast/job.h"

/* Load the job @p path, and write its identity and all of it. @return false if it is refused. */
static bool load(const char *path, sc_text *identity, sc_text *whole)
{
    const sc_job_sources sources = {.path = path};
    SC_OWN(sc_job_clear) sc_job job = {0};
    const sc_status status = sc_job_load(&fuzz_ctx, &sources, &job);

    FUZZ_CHECK(status != SC_ERR_INTERNAL && status != SC_ERR_MEMORY);
    if (status == SC_OK) {
        /* The default lies in the working directory, what a file says beside that file. */
        if (job.output.directory[0] != '/')
            strcpy(job.output.directory, "/out");
        FUZZ_CHECK(sc_job_write(&fuzz_ctx, &job, true, identity) == SC_OK);
        FUZZ_CHECK(sc_job_write(&fuzz_ctx, &job, false, whole) == SC_OK);
    }
    return status == SC_OK;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    sc_text identity[2] = {{0}}, whole[2] = {{0}};

    if (load(fuzz_write("job.yaml", data, size), &identity[0], &whole[0])) {
        const char *path = fuzz_write("again.yaml", whole[0].data, whole[0].length_bytes);

        FUZZ_CHECK(load(path, &identity[1], &whole[1]));
        if (getenv("FUZZ_TELL"))
            fprintf(stderr, "first:\n%sagain:\n%s", whole[0].data, whole[1].data);
        FUZZ_CHECK(!strcmp(identity[0].data, identity[1].data));
        FUZZ_CHECK(!strcmp(whole[0].data, whole[1].data));
    }
    for (int i = 0; i < 2; i++) {
        sc_text_clear(&identity[i]);
        sc_text_clear(&whole[i]);
    }
    return 0;
}
