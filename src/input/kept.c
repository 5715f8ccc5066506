/* SPDX-License-Identifier: BSD-3-Clause */
/* Volumes that were prepared are kept in a directory of the user, so that the next command that
 * draws the same voxels need not prepare them again. A preparation is a function of the voxels, of
 * their geometry, of its settings and of the program alone: a hash of these names the file. So
 * another name, colour, opacity or cut finds it again, and whatever changes a voxel does not. */
#include "recipe.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

/* So many bytes are kept, some ten volumes of everyday size; those not used for longest leave. */
#define KEPT_BYTES_MOST ((uint64_t)4 << 30)
/* What takes less CPU seconds to prepare is not worth the disk, unless the user names a directory
 * for it: there it is kept whatever the machine does meanwhile. */
#define WORTH_CPU_S 0.5
#define ENDING ".segc"
/* Of the light that was gathered in such a volume: render/gather_kept.c. */
#define LIGHT_ENDING ".light"
enum { HASH_DIGITS = 32 };

/* ---- names ---- */

/* @return whether this process belongs to a job of a batch system: it runs on a node whose disks
 * are not the user's. */
static bool is_in_batch(void)
{
    static const char *const names[] = {"SLURM_JOB_ID", "PBS_JOBID", "LSB_JOBID", "SGE_TASK_ID"};
    bool found = false;

    for (size_t i = 0; i < SC_COUNT_OF(names); i++)
        found = found || getenv(names[i]);
    return found;
}

sc_status sc_kept_directory(const sc_ctx *ctx, char **out)
{
    const sc_ctx quiet = sc_quiet(ctx);
    const char *given = getenv("SEGCAST_CACHE");
    sc_status status;

    *out = NULL;
    if (given ? !strcmp(given, "off") || !given[0] : is_in_batch())
        return SC_OK;
    if (given)
        return sc_path_join(ctx, NULL, given, out);
    status = sc_cache_path(&quiet, "prepared", out);
    return status == SC_ERR_MEMORY ? status : SC_OK; /* without a home nothing is kept */
}

/* @return @p hash, with @p bytes bytes at @p data added. */
static uint64_t add(uint64_t hash, const void *data, size_t bytes)
{
    return sc_hash_bytes(data, bytes, hash);
}

/* @return a hash of all that a preparation depends on but its voxels. */
static uint64_t hash_of_settings(const sc_ctx *ctx, const sc_input *input, const sc_edited *edited)
{
    const sc_volume *v = &edited->volume;
    const sc_prepare_settings *s = &edited->settings;
    const int32_t numbers[] = {v->size[0],     v->size[1],         v->size[2],      v->label_bytes,
                               v->label_count, v->oriented,        v->numbered,     s->resampled,
                               s->as_drawn,    s->local_thickness, edited->resample};
    const size_t labels = (size_t)v->label_count;
    struct stat program;
    uint64_t hash = add(0, sc_version(), strlen(sc_version()));

    if (!stat("/proc/self/exe", &program)) { /* another build may prepare in another way */
        hash = add(hash, &program.st_size, sizeof program.st_size);
        hash = add(hash, &program.st_mtim, sizeof program.st_mtim);
    }
    hash = add(hash, numbers, sizeof numbers);
    if (edited->resample) /* with less memory, to another grid */
        hash = add(hash, &ctx->memory_max_bytes, sizeof ctx->memory_max_bytes);
    if (edited->resample && input->drawn_known)
        hash = add(hash, &input->drawn, sizeof input->drawn);
    hash = add(hash, &v->to_ras_mm, sizeof v->to_ras_mm);
    hash = add(hash, &s->smooth, sizeof s->smooth);
    hash = add(hash, s->tissue_smooth, labels * sizeof *s->tissue_smooth);
    return add(hash, s->hidden, labels * sizeof *s->hidden);
}

sc_status sc_kept_path(const sc_ctx *ctx, const sc_input *input, const sc_edited *edited,
                       char **out)
{
    const sc_volume *v = &edited->volume;
    const size_t bytes = sc_volume_voxels(v) * (size_t)v->label_bytes;
    const uint64_t hash = hash_of_settings(ctx, input, edited);
    char name[HASH_DIGITS + sizeof ENDING];
    SC_OWN(sc_free_at) char *directory = NULL;

    *out = NULL;
    SC_PASS(sc_kept_directory(ctx, &directory));
    if (!directory)
        return SC_OK;
    snprintf(name, sizeof name, "%016llx%016llx" ENDING,
             (unsigned long long)add(hash, v->ids, bytes),
             (unsigned long long)add(~hash, v->ids, bytes));
    return sc_path_join(ctx, directory, name, out);
}

/* ---- finding ---- */

/* @return whether @p info is of a regular file of this user: others could have put anything there.
 */
static bool is_own_file(const struct stat *info)
{
    return S_ISREG(info->st_mode) && info->st_uid == geteuid();
}

/* Map the file @p path on this rank and all others. @return whether it is a preparation of the
 * volume of @p edited, which is known on rank 0 alone. Collective. */
static bool map_kept(const sc_app *app, const char *path, const sc_edited *edited, sc_input *input)
{
    sc_ctx silent = sc_quiet(app->ctx);
    const sc_volume *v = &edited->volume;
    sc_prepared *found = &input->volume;
    struct stat info;

    silent.write = NULL; /* without the file the volume is prepared anew */
    /* The file that was opened: another process may have put a new one in its place. */
    return sc_map_prepared(app, &silent, path, &input->kept, found) == SC_OK &&
           !fstat(input->kept->file, &info) && is_own_file(&info) &&
           (sc_comm_rank(app->comm) > 0 ||
            (found->label_count == v->label_count && found->label_bytes == v->label_bytes));
}

sc_status sc_kept_find(const sc_app *app, const sc_edited *edited, char **path, sc_input *input,
                       bool *found)
{
    const bool first = sc_comm_rank(app->comm) == 0;
    char shared[SC_PATH_BYTES] = ""; /* as systems open */
    struct stat info;
    bool good;
    uint64_t hash;

    *found = false;
    if (first && *path && !lstat(*path, &info) && is_own_file(&info))
        snprintf(shared, sizeof shared, "%s", *path);
    sc_comm_broadcast(app->comm, shared, sizeof shared);
    if (!shared[0])
        return SC_OK;
    sc_stage_begin(app->ctx, "checking what was prepared", 0, 0);
    good = map_kept(app, shared, edited, input);
    hash = input->volume.file_hash;
    sc_comm_broadcast(app->comm, &hash, sizeof hash);
    if (sc_comm_agree(app->comm, good && hash == input->volume.file_hash ? SC_OK : SC_ERR_DATA) ==
        SC_OK) {
        SC_PASS(sc_share_labels(app, edited->volume.labels, input));
        input->bytes = input->kept->bytes;
        /* It is used now. If that cannot be noted, it is only removed from the cache earlier. What
         * is noted is not the time of a change, by which those who map it know one. */
        if (first)
            (void)!futimens(input->kept->file, (const struct timespec[]){{.tv_nsec = UTIME_NOW},
                                                                         {.tv_nsec = UTIME_OMIT}});
        *found = true;
        return SC_OK;
    }
    sc_unmap_prepared(&input->kept);
    input->volume = (sc_prepared){0};
    /* What is broken, or of another layout, is prepared anew and replaced. It is not removed:
     * another process may just have replaced it. */
    if (first && good) { /* other nodes do not see it */
        sc_free(*path);
        *path = NULL;
    }
    return SC_OK;
}

/* ---- keeping ---- */

/* A file that is kept. */
typedef struct kept_file {
    char name[HASH_DIGITS + sizeof LIGHT_ENDING];
    uint64_t bytes;
    struct timespec used;
    bool is_light;
} kept_file;

/* For qsort: the one that was not used for longest first. */
static int by_use(const void *a, const void *b)
{
    const struct timespec *x = &((const kept_file *)a)->used, *y = &((const kept_file *)b)->used;

    return x->tv_sec != y->tv_sec ? (x->tv_sec > y->tv_sec) - (x->tv_sec < y->tv_sec)
                                  : (x->tv_nsec > y->tv_nsec) - (x->tv_nsec < y->tv_nsec);
}

/* @return whether an entry of the directory is a file that is kept: one of this user with a name as
 * sc_kept_path makes it. */
static bool is_kept(int directory, const char *name, kept_file *out)
{
    struct stat info;

    if (strspn(name, "0123456789abcdef") != HASH_DIGITS)
        return false;
    out->is_light = !strcmp(name + HASH_DIGITS, LIGHT_ENDING);
    if ((!out->is_light && strcmp(name + HASH_DIGITS, ENDING) != 0) ||
        fstatat(directory, name, &info, AT_SYMLINK_NOFOLLOW) || !S_ISREG(info.st_mode) ||
        info.st_uid != geteuid())
        return false;
    strcpy(out->name, name); /* which has room for it */
    out->bytes = (uint64_t)info.st_size;
    out->used = info.st_atim;
    return true;
}

/* List the files that are kept. @return SC_ERR_MEMORY. Caller owns *out: sc_free. */
static sc_status list_kept(const sc_ctx *ctx, DIR *stream, kept_file **out, size_t *count)
{
    const struct dirent *entry;
    size_t room = 0;

    *count = 0;
    *out = NULL;
    while ((entry = readdir(stream))) {
        kept_file file;

        if (!is_kept(dirfd(stream), entry->d_name, &file))
            continue;
        SC_PASS(SC_GROW(ctx, *count, &room, out));
        (*out)[(*count)++] = file;
    }
    if (*count)
        qsort(*out, *count, sizeof **out, by_use);
    return SC_OK;
}

sc_status sc_kept_trim(const sc_ctx *ctx, const char *directory, uint64_t most_bytes, int *files,
                       uint64_t *bytes)
{
    DIR *stream = opendir(directory);
    kept_file *all = NULL;
    size_t count, i = 0;
    sc_status status;

    *files = 0;
    *bytes = 0;
    if (!stream)
        return SC_OK; /* nothing was kept so far */
    SC_TRY(list_kept(ctx, stream, &all, &count));
    for (size_t k = 0; k < count; k++)
        *bytes += all[k].bytes;
    for (; i<count && * bytes> most_bytes; i++) {
        if (!unlinkat(dirfd(stream), all[i].name, 0) || errno == ENOENT)
            *bytes -= all[i].bytes;
    }
    for (; i < count; i++)
        *files += !all[i].is_light;
out:
    sc_free(all);
    closedir(stream);
    return status;
}

/* Make the directory of @p path, for this user alone if there is none, and room in it for @p bytes
 * bytes. @return why not: static text, or NULL. */
static const char *make_room(const sc_ctx *ctx, const char *path, uint64_t bytes)
{
    const char *slash = strrchr(path, '/');
    char *directory = slash ? strndup(path, (size_t)(slash - path)) : NULL;
    const char *why = "out of memory";
    struct statvfs disk;
    uint64_t kept;
    int files;
    bool is_new;

    if (!directory)
        return why;
    is_new = access(directory, F_OK) != 0;
    if (sc_make_directory(ctx, directory) != SC_OK)
        why = "its directory cannot be made";
    else if (sc_kept_trim(ctx, directory, KEPT_BYTES_MOST - bytes, &files, &kept) != SC_OK)
        why = "out of memory";
    else if (!statvfs(directory, &disk) && disk.f_bavail * disk.f_frsize < 2 * bytes)
        why = "its disk is nearly full";
    else
        why = NULL;
    if (!why) {
        sc_remove_temporaries(directory, false);
        if (is_new) /* the modes of a directory of the user stay as they are */
            (void)!chmod(directory, 0700);
    }
    free(directory);
    return why;
}

/* Write a preparation to @p path. @return whether it is there. */
static bool save(const sc_ctx *ctx, const char *path, const sc_preparation *preparation)
{
    const uint64_t bytes = sc_preparation_file_bytes(preparation);
    sc_ctx silent = sc_quiet(ctx);
    const char *why;

    if (bytes > KEPT_BYTES_MOST / 2)
        return false;
    silent.write = NULL; /* the reason is told below, and is no error */
    why = make_room(&silent, path, bytes);
    if (!why && sc_preparation_save(&silent, preparation, path, true, false) != SC_OK)
        why = "it cannot be written";
    if (why)
        sc_info(
            ctx,
            "%s: what was prepared is not kept for the next command, as %s; SEGCAST_CACHE names "
            "another directory, or off",
            path, why);
    return !why;
}

bool sc_kept_add(const sc_app *app, const char *path, sc_preparation *preparation, double cpu_s)
{
    const bool first = sc_comm_rank(app->comm) == 0;
    /* where others prepare, there is neither */
    bool is_kept = path && (getenv("SEGCAST_CACHE") || cpu_s >= WORTH_CPU_S);

    sc_comm_broadcast(app->comm, &is_kept, sizeof is_kept);
    if (!is_kept)
        return false;
    /* Without what is derived, for which the memory may be too small, the file serves as well. */
    if (preparation)
        (void)!sc_preparation_derive(app->ctx, preparation, NULL);
    if (first)
        is_kept = save(app->ctx, path, preparation);
    sc_comm_broadcast(app->comm, &is_kept, sizeof is_kept);
    return is_kept;
}
