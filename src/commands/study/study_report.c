/* SPDX-License-Identifier: BSD-3-Clause */
/* The page of a study in its directory. */
#include "segcast/report.h"
#include "study/study.h"

#include <sys/stat.h>
#include <unistd.h>

sc_status sc_study_write_page(const sc_ctx *ctx, const char *directory,
                              const sc_measurements *measurements)
{
    SC_OWN(sc_text_clear) sc_text text = {0};
    struct stat info;
    SC_OWN(sc_free_at) char *path = NULL;

    SC_PASS(sc_path_join(ctx, directory, SC_STUDY_PAGE, &path));
    if (!lstat(path, &info) && !S_ISREG(info.st_mode))
        return sc_fail(ctx, SC_ERR_CREATE,
                       "%s: was not made by segcast; move it away, so that the page of the study "
                       "can have this name",
                       path);
    SC_PASS(sc_report_study(ctx, directory, measurements, &text));
    return sc_file_write(ctx, path, text.data, text.length_bytes);
}

sc_status sc_study_is_in(const sc_ctx *ctx, const char *directory, bool *out)
{
    SC_OWN(sc_free_at) char *path = NULL, *manifest = NULL;
    bool found = false;

    SC_PASS(sc_path_join(ctx, directory, SC_STUDY_MEASUREMENTS, &path));
    SC_PASS(sc_path_join(ctx, directory, "manifest.jsonl", &manifest));
    SC_PASS(sc_measurements_begin(ctx, path, &found));
    /* without a run beside it, the file is a study's even if its first line is damaged */
    *out = found || (access(path, F_OK) == 0 && access(manifest, F_OK) != 0);
    return SC_OK;
}

sc_status sc_study_read(const sc_ctx *ctx, const char *directory, sc_measurements *out)
{
    SC_OWN(sc_free_at) char *path = NULL;
    uint64_t whole;

    SC_PASS(sc_path_join(ctx, directory, SC_STUDY_MEASUREMENTS, &path));
    return sc_measurements_read(ctx, path, out, &whole);
}
