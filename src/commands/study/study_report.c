/* SPDX-License-Identifier: BSD-3-Clause */
/* The page of a study in its directory. */
#include "segcast/report.h"
#include "study/study.h"

#include <sys/stat.h>
#include <unistd.h>

sc_status sc_study_write_page(const sc_ctx *ctx, const char *directory,
                              const sc_measurements *measurements)
{
    sc_text text = {0};
    struct stat info;
    char *path = NULL;
    sc_status status;

    SC_TRY(sc_path_join(ctx, directory, SC_STUDY_PAGE, &path));
    if (!lstat(path, &info) && !S_ISREG(info.st_mode)) {
        status = sc_fail(ctx, SC_ERR_CREATE,
                         "%s: was not made by segcast; move it away, so that the page of the study "
                         "can have this name",
                         path);
        goto out;
    }
    SC_TRY(sc_report_study(ctx, directory, measurements, &text));
    status = sc_file_write(ctx, path, text.data, text.length_bytes);
out:
    sc_text_clear(&text);
    sc_free(path);
    return status;
}

sc_status sc_study_is_in(const sc_ctx *ctx, const char *directory, bool *out)
{
    char *path = NULL, *manifest = NULL;
    bool found = false;
    sc_status status;

    SC_TRY(sc_path_join(ctx, directory, SC_STUDY_MEASUREMENTS, &path));
    SC_TRY(sc_path_join(ctx, directory, "manifest.jsonl", &manifest));
    SC_TRY(sc_measurements_begin(ctx, path, &found));
    /* without a run beside it, the file is a study's even if its first line is damaged */
    *out = found || (access(path, F_OK) == 0 && access(manifest, F_OK) != 0);
out:
    sc_free(path);
    sc_free(manifest);
    return status;
}

sc_status sc_study_read(const sc_ctx *ctx, const char *directory, sc_measurements *out)
{
    char *path = NULL;
    uint64_t whole;
    sc_status status = sc_path_join(ctx, directory, SC_STUDY_MEASUREMENTS, &path);

    if (status == SC_OK)
        status = sc_measurements_read(ctx, path, out, &whole);
    sc_free(path);
    return status;
}
