/* SPDX-License-Identifier: BSD-3-Clause */
/* The file that keeps what segcast plan --calibrate has measured. */
#include "plan/calibration.h"

#include <errno.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#define SCHEMA_NAME "segcast-calibration-"
#define SCHEMA SCHEMA_NAME "1"
enum {
    BYTES_MOST = 65536,
    NAME_BYTES = 256,
    MARK_BYTES = 128 /* of the begin of a file, in which its schema stands */
};

sc_unit_costs sc_unit_costs_assumed(void)
{
    return (sc_unit_costs){.notice_s = 3e-4,
                           .message_s = 2e-5,
                           .latency_s = 2e-5,
                           .link_bytes_per_s = 1.2e9, /* 10 Gbit/s */
                           .copy_bytes_per_s = 5e9,
                           .file_bytes_per_s = 5e8};
}

/* The numbers of the file, and between what they must lie. */
static const struct {
    const char *name;
    size_t offset; /* of a double in sc_unit_costs */
    double least, most;
} numbers[] = {
    {"notice_s", offsetof(sc_unit_costs, notice_s), 1e-7, 1},
    {"message_s", offsetof(sc_unit_costs, message_s), 1e-8, 1},
    {"latency_s", offsetof(sc_unit_costs, latency_s), 1e-8, 1},
    {"link_bytes_per_s", offsetof(sc_unit_costs, link_bytes_per_s), 1e4, 1e13},
    {"copy_bytes_per_s", offsetof(sc_unit_costs, copy_bytes_per_s), 1e6, 1e14},
    {"file_bytes_per_s", offsetof(sc_unit_costs, file_bytes_per_s), 1e3, 1e13},
};

/* @return the number of that row in @p costs. */
static double *number_at(sc_unit_costs *costs, size_t row)
{
    return (double *)(void *)((char *)costs + numbers[row].offset);
}

/* @return a hash of processor and version, and of the numbers, as bytes of the struct. */
static uint64_t hash_of(const char *processor, const sc_unit_costs *costs)
{
    uint64_t hash = sc_hash_bytes(processor, strlen(processor), 0);

    hash = sc_hash_bytes(sc_version(), strlen(sc_version()), hash);
    for (size_t i = 0; costs && i < SC_COUNT_OF(numbers); i++)
        hash = sc_hash_bytes((const char *)costs + numbers[i].offset, sizeof(double), hash);
    return costs ? hash + costs->messages_measured + 2U * costs->network_measured : hash;
}

sc_status sc_calibration_path(const sc_ctx *ctx, char **out)
{
    char processor[NAME_BYTES], name[64];

    sc_processor_name(processor, sizeof processor);
    snprintf(name, sizeof name, "calibration-%016llx.json",
             (unsigned long long)hash_of(processor, NULL));
    return sc_cache_path(ctx, name, out);
}

/* ---- reading ---- */

/* Read the costs from JSON. @return what is wrong with it, or NULL. */
static const char *read_costs(const json_t *json, sc_unit_costs *out)
{
    char processor[NAME_BYTES];
    const char *text = json_string_value(json_object_get(json, "schema"));
    uint64_t hash;

    if (!text || strcmp(text, SCHEMA) != 0)
        return "it is no calibration of segcast";
    sc_processor_name(processor, sizeof processor);
    text = json_string_value(json_object_get(json, "processor"));
    if (!text || strcmp(text, processor) != 0)
        return "it is of another processor";
    text = json_string_value(json_object_get(json, "version"));
    if (!text || strcmp(text, sc_version()) != 0)
        return "it is of another version of segcast";
    for (size_t i = 0; i < SC_COUNT_OF(numbers); i++) {
        const double value = json_number_value(json_object_get(json, numbers[i].name));

        if (!(value >= numbers[i].least && value <= numbers[i].most))
            return "a number is missing or impossible";
        *number_at(out, i) = value;
    }
    out->messages_measured = json_is_true(json_object_get(json, "messages_measured"));
    out->network_measured = json_is_true(json_object_get(json, "network_measured"));
    return sc_json_hash(json_object_get(json, "hash"), &hash) && hash == hash_of(processor, out)
               ? NULL
               : "its hash does not fit";
}

/* @return why the file at @p path is not to be trusted, or NULL: it must be a regular file of this
 * user. @param missing whether there is none. */
static const char *look_at(const char *path, bool *missing)
{
    struct stat info;

    *missing = lstat(path, &info) != 0 && (errno == ENOENT || errno == ENOTDIR);
    if (*missing)
        return NULL;
    if (!S_ISREG(info.st_mode))
        return "it is no regular file";
    return info.st_uid == geteuid() ? NULL : "it belongs to another user";
}

/* @return why the file at @p path, which is there, is not one that segcast plan --calibrate has
 * written, by whatever version and even if it is damaged by now: its schema stands at its begin; or
 * NULL. */
static const char *look_for_mark(const char *path)
{
    char head[MARK_BYTES + 1] = "";
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
    const ssize_t count = fd >= 0 ? read(fd, head, MARK_BYTES) : -1;

    if (fd >= 0)
        close(fd);
    if (count < 0)
        return "it cannot be read";
    return strstr(head, "\"schema\": \"" SCHEMA_NAME) ? NULL : "it is no calibration of segcast";
}

/* Read the file at @p path. @return what is wrong with it, or NULL. */
static const char *read_file(const char *path, sc_unit_costs *out)
{
    const sc_ctx silent = {.rank = 0};
    SC_OWN(sc_free_at) char *text = NULL;
    const char *wrong = "it cannot be read";
    size_t bytes;

    if (sc_file_read(&silent, path, BYTES_MOST, &text, &bytes) == SC_OK) {
        json_t *json = json_loads(text, 0, NULL);

        wrong = json ? read_costs(json, out) : "it is damaged";
        json_decref(json);
    }
    return wrong;
}

sc_unit_costs sc_calibration_load(const sc_ctx *ctx)
{
    const sc_ctx silent = {.rank = ctx->rank};
    const sc_unit_costs assumed = sc_unit_costs_assumed();
    sc_unit_costs costs = assumed;
    SC_OWN(sc_free_at) char *path = NULL;
    const char *wrong, *foreign;
    bool missing;

    if (sc_calibration_path(&silent, &path) != SC_OK)
        return assumed; /* there is no cache, and so nothing in it */
    wrong = look_at(path, &missing);
    foreign = !missing && !wrong ? look_for_mark(path) : wrong;
    if (!missing && !foreign)
        wrong = read_file(path, &costs);
    costs.measured = !missing && !foreign && !wrong;
    if (foreign)
        sc_warn(ctx, "%s is not used: %s; move it away, and `segcast plan --calibrate` measures",
                path, foreign);
    else if (wrong)
        sc_warn(ctx, "%s is not used: %s; `segcast plan --calibrate` measures anew", path, wrong);
    return costs.measured ? costs : assumed;
}

/* ---- writing ---- */

sc_status sc_calibration_check(const sc_ctx *ctx, const char *path)
{
    bool missing;
    const char *foreign = look_at(path, &missing);

    if (!missing && !foreign)
        foreign = look_for_mark(path);
    if (missing || !foreign)
        return SC_OK;
    return sc_fail(ctx, SC_ERR_CREATE,
                   "%s: is in the way of what is measured, and not replaced: %s; move it away, or "
                   "set XDG_CACHE_HOME to another directory",
                   path, foreign);
}

sc_status sc_calibration_make_directory(const sc_ctx *ctx, const char *path)
{
    SC_OWN(sc_free_at) char *directory = NULL;
    char *end;

    SC_PASS(sc_text_copy(ctx, path, &directory));
    *strrchr(directory, '/') = '\0';
    end = strrchr(directory, '/');
    *end = '\0';
    if (directory[0])
        SC_PASS(sc_make_directory(ctx, directory));
    *end = '/';
    if (mkdir(directory, S_IRWXU) != 0 && errno != EEXIST)
        return sc_fail(ctx, SC_ERR_CREATE, "%s cannot be made: %s", directory, strerror(errno));
    return SC_OK;
}

sc_status sc_calibration_save(const sc_ctx *ctx, const sc_unit_costs *costs, const char *path)
{
    char processor[NAME_BYTES];
    sc_unit_costs copy = *costs;
    sc_outfile file = {0};
    json_t *json = NULL;
    SC_OWN(sc_text_clear) sc_text text = {0};

    sc_processor_name(processor, sizeof processor);
    json = json_pack("{s:s, s:s, s:s, s:b, s:b, s:o}", "schema", SCHEMA, "version", sc_version(),
                     "processor", processor, "messages_measured", costs->messages_measured,
                     "network_measured", costs->network_measured, "hash",
                     sc_json_of_hash(hash_of(processor, costs)));
    for (size_t i = 0; json && i < SC_COUNT_OF(numbers); i++)
        (void)json_object_set_new(json, numbers[i].name, json_real(*number_at(&copy, i)));
    /* 17 digits bring every number back exactly */
    SC_PASS(sc_json_add_text(ctx, json, JSON_INDENT(1) | JSON_REAL_PRECISION(17), path, &text));
    SC_PASS(sc_calibration_check(ctx, path)); /* it may have come meanwhile */
    SC_PASS(sc_outfile_open(ctx, path, true, &file));
    (void)fchmod(fileno(file.stream), S_IRUSR | S_IWUSR);
    fputs(text.data, file.stream); /* an error shows at the commit */
    return sc_outfile_commit(ctx, &file);
}
