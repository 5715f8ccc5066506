/* SPDX-License-Identifier: BSD-3-Clause */
/* What in a directory belongs to segcast. A manifest names in its first line everything that its
 * run is going to make, before the run makes it, and after the run has made sure that none of it
 * was there. So whatever bears one of these names later was made by segcast, whenever the run
 * ended; all other files are foreign, and never changed or removed. */
#include "internal.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

/* Something that is there under a name that a run is going to use. */
typedef struct obstacle {
    char name[300];   /* in the directory */
    char owner[300];  /* the name under which a manifest would own it; "": none can */
    const char *what; /* what it is, in words; static */
} obstacle;

/* All of them; of the files in a folder only the first that is like it. */
typedef struct search {
    const sc_store_place *place;
    sc_names *owned;               /* what manifests name */
    obstacle found[24];            /* the first `count` are used */
    int count, others;             /* others: how many more there are that need not be looked at */
    bool has_frames, has_segments; /* the folders exist */
    bool vanished;                 /* a manifest was removed while it was to be read */
    uint64_t identity;             /* of the job of manifest.jsonl; 0: there is none */
} search;

/* Append an obstacle; one that has the same owner as an earlier one is only counted. */
static void add_obstacle(search *s, const char *name, const char *owner, const char *what)
{
    obstacle *o = &s->found[s->count];

    for (int i = 0; i < s->count; i++) {
        if (!strcmp(s->found[i].owner, owner)) {
            s->others += owner[0] == '\0';
            return;
        }
    }
    if (s->count == (int)SC_COUNT_OF(s->found))
        return; /* cannot happen: there are fewer owners */
    snprintf(o->name, sizeof o->name, "%s", name);
    snprintf(o->owner, sizeof o->owner, "%s", owner);
    o->what = what;
    s->count++;
}

/* @return in words what a file is that is not of the kind that was expected. */
static const char *kind_of(const struct stat *info)
{
    return S_ISLNK(info->st_mode)   ? "a symbolic link"
           : S_ISDIR(info->st_mode) ? "a directory"
           : S_ISREG(info->st_mode) ? "a file"
                                    : "a special file";
}

/* Look whether a file of this name is in the directory. */
static void look_for_file(search *s, const char *name, const char *owner)
{
    char path[SC_FILE_BYTES];
    struct stat info;

    sc_store_path(s->place->directory, path, "%s", name);
    if (lstat(path, &info))
        return;
    add_obstacle(s, name, S_ISREG(info.st_mode) ? owner : "", kind_of(&info));
}

/* For sc_each_record with a search as user: look whether a record is there. */
static sc_status look_for_record(const sc_ctx *ctx, void *user, const char *name)
{
    look_for_file(user, name, name);
    return SC_OK;
}

/* Open a folder of the directory for listing. @p exists receives whether it is there; a link or
 * file of its name becomes an obstacle. @return NULL unless it can be listed. */
static DIR *open_folder(search *s, const char *name, bool *exists)
{
    char path[SC_FILE_BYTES];
    struct stat info;
    int fd;
    DIR *stream;

    sc_store_path(s->place->directory, path, "%s", name);
    *exists = lstat(path, &info) == 0;
    if (!*exists)
        return NULL;
    if (!S_ISDIR(info.st_mode)) {
        add_obstacle(s, name, "", kind_of(&info));
        return NULL;
    }
    fd = open(path, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    stream = fd < 0 ? NULL : fdopendir(fd);
    if (!stream && fd >= 0)
        close(fd);
    if (!stream)
        add_obstacle(s, name, "", "a directory that cannot be listed");
    return stream;
}

/* Look at the files in frames/ (with @p segments, in segments/): those with names of frames
 * (segments) belong to segcast if a manifest says so; in segments/ no others may be. Hidden files
 * are none of ours, and in nobody's way. */
static void look_into_folder(search *s, const char *folder, bool segments, bool *exists)
{
    DIR *stream = open_folder(s, folder, exists);
    const struct dirent *entry;

    while (stream && (entry = readdir(stream))) {
        const char *name = entry->d_name;
        const bool ours =
            segments ? sc_is_segment_name(name) : sc_is_frame_name(name, s->place->frames);
        const char *owner = segments ? SC_OWN_SEGMENTS : SC_OWN_PNG;
        struct stat info;
        char path[300];

        if (name[0] == '.' || (!segments && !ours) ||
            fstatat(dirfd(stream), name, &info, AT_SYMLINK_NOFOLLOW))
            continue;
        snprintf(path, sizeof path, "%s/%s", folder, name);
        add_obstacle(s, path, ours && S_ISREG(info.st_mode) ? owner : "", kind_of(&info));
    }
    if (stream)
        closedir(stream);
}

/* For sc_each_file with a search as user: read what a manifest names into s->owned. A file that is
 * none is foreign, and an obstacle if it has the name of this run's manifest. */
static sc_status read_owned(const sc_ctx *ctx, void *user, const char *path, const char *name)
{
    const sc_ctx quiet = sc_quiet(ctx);
    search *s = user;
    sc_manifest_data data = {.owned = *s->owned};
    sc_store probe = {.role.slice = s->place->slice};
    char own[SC_FILE_BYTES];
    struct stat info;
    sc_status status;

    sc_store_manifest_path(&probe, own);
    if (lstat(path, &info)) {
        s->vanished = true; /* the process that completed the job has removed it */
        return SC_OK;
    }
    if (!S_ISREG(info.st_mode)) {
        if (!strcmp(name, own + 1))
            add_obstacle(s, name, "", kind_of(&info));
        return SC_OK;
    }
    status = sc_manifest_read_head(&quiet, path, &data);
    *s->owned = data.owned;
    if (status == SC_OK && data.head.known && !strcmp(name, "manifest.jsonl"))
        s->identity = sc_identity_of(data.head.job_hash, data.head.volume_hash, data.head.frames,
                                     data.head.version);
    if (status == SC_ERR_MISSING && access(path, F_OK) != 0)
        return SC_OK;
    if (status == SC_OK && !data.head.known && !strcmp(name, own + 1))
        return sc_fail(ctx, SC_ERR_CREATE,
                       "%s: %s; segcast cannot know which files here are its own: choose another "
                       "directory with -o, or move them away",
                       path, data.head.problem);
    return status == SC_ERR_MISSING
               ? sc_fail(ctx, SC_ERR_CREATE, "%s: cannot be read: %s", path, sc_reason(errno))
               : status;
}

/* @return whether the file @p name of segments/ is of the job of manifest.jsonl, by what
 * it holds. */
static bool is_of_job(const search *s, const char *name)
{
    const sc_ctx silent = {.rank = 0};
    sc_segment segment = {0};
    sc_segment_info info;
    char path[SC_FILE_BYTES];
    SC_OWN(sc_free_at) char *data = NULL;

    sc_store_path(s->place->directory, path, "segments/%s", name);
    if (strstr(name, ".part"))
        return sc_is_partial_of(path, s->identity);
    if (sc_file_read(&silent, path, SC_SEGMENT_MAX_BYTES, &data, &segment.bytes) != SC_OK)
        return false;
    segment.data = data;
    return sc_segment_inspect(&segment, &info) && info.identity == s->identity;
}

/* A run that another one has replaced may still give a segment its name when that has completed the
 * job, whose manifest does not name segments any more. Own segments/ if all in it are of its job.
 */
static sc_status own_late_segments(const sc_ctx *ctx, search *s)
{
    bool exists, ours = true;
    DIR *stream;
    const struct dirent *entry;

    if (!s->has_segments || !s->identity || sc_file_lines_has(s->owned, SC_OWN_SEGMENTS))
        return SC_OK;
    stream = open_folder(s, "segments", &exists);
    while (stream && ours && (entry = readdir(stream)))
        ours = !sc_is_segment_name(entry->d_name) || is_of_job(s, entry->d_name);
    if (stream)
        closedir(stream);
    if (!stream || !ours)
        return SC_OK;
    SC_PASS(sc_names_add(ctx, s->owned, "segments/"));
    return sc_names_add(ctx, s->owned, SC_OWN_SEGMENTS);
}

/* Fill s->found. What manifests name is read after the files were looked at: a run that began
 * meanwhile has named its files before it made them. */
static sc_status find_obstacles(const sc_ctx *ctx, search *s, const char *partial)
{
    const sc_store_place *place = s->place;
    const bool has_video = strcmp(place->video, "none") != 0;

    if (has_video) {
        look_for_file(s, place->video, place->video);
        look_for_file(s, partial, partial);
        look_into_folder(s, "segments", true, &s->has_segments);
    }
    if (place->png)
        look_into_folder(s, "frames", false, &s->has_frames);
    if (!place->joins)
        SC_PASS(sc_each_record(ctx, place->slice, s, look_for_record));
    if (place->fresh)
        return SC_OK;
    SC_PASS(sc_each_file(ctx, place->directory, sc_is_manifest_name, s, read_owned));
    if (s->vanished) /* for a manifest that says the same and was not listed yet */
        SC_PASS(sc_each_file(ctx, place->directory, sc_is_manifest_name, s, read_owned));
    return own_late_segments(ctx, s);
}

/* For sc_each_record with an sc_names as user. */
static sc_status own(const sc_ctx *ctx, void *user, const char *name)
{
    return sc_names_add(ctx, user, name);
}

/* Add to s->owned what this run is going to make. A folder that was there before, unowned, is not
 * made, and will not be removed. */
static sc_status own_what_is_made(const sc_ctx *ctx, search *s, const char *partial)
{
    const sc_store_place *place = s->place;

    if (!place->joins)
        SC_PASS(sc_each_record(ctx, place->slice, s->owned, own));
    if (place->png && !s->has_frames)
        SC_PASS(sc_names_add(ctx, s->owned, "frames/"));
    if (place->png)
        SC_PASS(sc_names_add(ctx, s->owned, SC_OWN_PNG));
    if (!strcmp(place->video, "none"))
        return SC_OK;
    if (!s->has_segments)
        SC_PASS(sc_names_add(ctx, s->owned, "segments/"));
    SC_PASS(sc_names_add(ctx, s->owned, SC_OWN_SEGMENTS));
    SC_PASS(sc_names_add(ctx, s->owned, place->video));
    return sc_names_add(ctx, s->owned, partial);
}

/* @return SC_ERR_CREATE, with a message, if the name of the video cannot be used. */
static sc_status check_video_name(const sc_ctx *ctx, const sc_store_place *place)
{
    if (!strcmp(place->video, "none") || sc_store_video_ok(place->video))
        return SC_OK;
    return sc_fail(
        ctx, SC_ERR_CREATE,
        "%s: a video cannot have this name; expected at most %d bytes, ending in "
        ".mp4, .mkv, .webm or .mov, without a directory or control characters, and without a "
        "dot at the beginning",
        place->video, SC_VIDEO_NAME_MAX);
}

sc_status sc_store_check_place(const sc_ctx *ctx, const sc_store_place *place, sc_names *owned,
                               bool *more)
{
    search s = {.place = place, .owned = owned};
    SC_OWN(sc_text_clear) sc_text partial = {0};
    const obstacle *first = NULL;
    int foreign = 0, named;
    sc_status status;

    SC_PASS(check_video_name(ctx, place));
    SC_PASS(sc_text_add(ctx, &partial, "%s", ""));
    if (strcmp(place->video, "none") != 0)
        SC_PASS(sc_video_partial_name(ctx, place->video, &partial));
    status = find_obstacles(ctx, &s, partial.data);
    if (status != SC_OK) /* what cannot be listed is an output */
        return status == SC_ERR_MISSING ? SC_ERR_CREATE : status;
    for (int i = 0; i < s.count; i++) {
        const bool ours = s.found[i].owner[0] && sc_file_lines_has(owned, s.found[i].owner);

        first = ours || first ? first : &s.found[i];
        foreign += !ours;
    }
    if (first) {
        char rest[48] = "";

        if (foreign + s.others > 1)
            snprintf(rest, sizeof rest, " (and %d more)", foreign + s.others - 1);
        return sc_fail(ctx, SC_ERR_CREATE,
                       "%s/%s%s: is %s that was not made by segcast, and in the way; choose "
                       "another directory with -o, or move it away",
                       place->directory, first->name, rest, first->what);
    }
    named = owned->count;
    status = own_what_is_made(ctx, &s, partial.data);
    *more = owned->count > named;
    return status;
}
