/* SPDX-License-Identifier: BSD-3-Clause */
/* The names of the files in the directory of a job. */
#include "internal.h"

#include <dirent.h>
#include <errno.h>
#include <stdarg.h>
#include <stdlib.h>

void sc_store_path(const char *directory, char out[SC_FILE_BYTES], const char *fmt, ...)
{
    const int used = snprintf(out, SC_FILE_BYTES, "%s/", directory);
    va_list args;

    va_start(args, fmt);
    if (used < SC_FILE_BYTES)
        vsnprintf(out + used, (size_t)(SC_FILE_BYTES - used), fmt, args);
    va_end(args);
}

void sc_store_manifest_path(const sc_store *store, char out[SC_FILE_BYTES])
{
    if (store->role.slice)
        sc_store_path(store->directory, out, "manifest.%s.jsonl", store->role.slice);
    else
        sc_store_path(store->directory, out, "manifest.jsonl");
}

/* The records of a run beside job.yaml: "STEM.ENDING", or of a slice S "STEM.S.ENDING". */
static const struct {
    const char *stem, *ending;
} records[] = {{"status", "json"},
               {"stats", "json"},
               {"frames", "csv"},
               {"trace", "json"},
               {"report", "html"}};

/* @return whether @p name is "STEM.ENDING" or, with a non-empty S, "STEM.S.ENDING". */
static bool is_record(const char *name, const char *stem, const char *ending)
{
    const size_t length = strlen(name), stem_length = strlen(stem), end_length = strlen(ending);

    return length > stem_length + end_length && !strncmp(name, stem, stem_length) &&
           name[stem_length] == '.' && !strcmp(name + length - end_length, ending) &&
           name[length - end_length - 1] == '.' &&
           (length == stem_length + 1 + end_length || length > stem_length + 2 + end_length);
}

bool sc_is_manifest_name(const char *name)
{
    return is_record(name, "manifest", "jsonl");
}

/* Does the text hold a character that terminals obey instead of showing it? */
static bool holds_control(const char *text)
{
    for (; *text; text++) {
        if ((unsigned char)*text < 0x20 || *text == 0x7f)
            return true;
    }
    return false;
}

bool sc_store_video_ok(const char *name)
{
    return strlen(name) <= SC_VIDEO_NAME_MAX && !strchr(name, '/') && name[0] != '.' &&
           !holds_control(name) && sc_video_name_ok(name);
}

bool sc_own_name(const char *name)
{
    if (!strcmp(name, "frames/") || !strcmp(name, "segments/") || !strcmp(name, SC_OWN_PNG) ||
        !strcmp(name, SC_OWN_SEGMENTS) || !strcmp(name, "job.yaml") || !strcmp(name, SC_CRATE_NAME))
        return true;
    if (strchr(name, '/') || name[0] == '.' || strlen(name) >= 256 || holds_control(name))
        return false;
    for (size_t i = 0; i < SC_COUNT_OF(records); i++) {
        if (is_record(name, records[i].stem, records[i].ending))
            return true;
    }
    return sc_video_name_ok(name);
}

/* @return how many characters of six digits or more the name begins with, with the number in
 * @p out; 0 if there are less or more than nine. */
static size_t leading_number(const char *name, long *out)
{
    const size_t digits = strspn(name, "0123456789");

    if (digits < 6 || digits > 9)
        return 0;
    *out = strtol(name, NULL, 10);
    return digits;
}

bool sc_is_frame_name(const char *name, int frames)
{
    long frame = 0;
    const size_t digits = leading_number(name, &frame);

    return digits && !strcmp(name + digits, ".png") && frame < frames &&
           (digits == 6 || name[0] != '0');
}

bool sc_is_segment_name(const char *name)
{
    long gop;
    const size_t digits = leading_number(name, &gop);
    const char *extension = strrchr(name, '.');

    return digits && name[digits] == '.' &&
           (!strcmp(name + digits, ".seg") ||
            (!strcmp(extension, ".part") && extension > name + digits + 1));
}

sc_status sc_each_record(const sc_ctx *ctx, const char *slice, void *user,
                         sc_status (*each)(const sc_ctx *ctx, void *user, const char *name))
{
    SC_PASS(each(ctx, user, "job.yaml"));
    SC_PASS(each(ctx, user, SC_CRATE_NAME));
    for (size_t i = 0; i < SC_COUNT_OF(records); i++) {
        SC_OWN(sc_text_clear) sc_text name = {0};

        SC_PASS(sc_text_add(ctx, &name, "%s%s%s.%s", records[i].stem, slice ? "." : "",
                            slice ? slice : "", records[i].ending));
        SC_PASS(each(ctx, user, name.data));
    }
    return SC_OK;
}

sc_status sc_each_file(const sc_ctx *ctx, const char *directory,
                       bool (*is_wanted)(const char *name), void *user, sc_each_file_fn *each)
{
    char path[SC_FILE_BYTES];
    struct dirent **names;
    const int count = scandir(directory, &names, NULL, alphasort);
    sc_status status = SC_OK;

    if (count < 0 && errno != ENOENT && errno != ENOTDIR)
        return sc_fail(ctx, sc_input_status(errno), "%s: cannot be listed: %s", directory,
                       sc_reason(errno));
    for (int i = 0; i < count; i++) {
        if (status == SC_OK && is_wanted(names[i]->d_name)) {
            sc_store_path(directory, path, "%s", names[i]->d_name);
            status = each(ctx, user, path, names[i]->d_name);
        }
        free(names[i]);
    }
    if (count >= 0)
        free(names);
    return status;
}
