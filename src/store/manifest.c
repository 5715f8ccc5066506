/* SPDX-License-Identifier: BSD-3-Clause */
/* Writes and reads the lines of a manifest, each a JSON object. */
#include "internal.h"

#include <errno.h>
#include <jansson.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#define SCHEMA "segcast-manifest-3"
enum { MANIFEST_MAX_BYTES = 1 << 30 }; /* about seven million lines */
enum { OWNED_MAX = 1 << 16 }; /* names of files in a manifest: the records of 16,000 slices */
/* A line ends with this, the hash of what stands before it, and a newline. */
#define PROOF ",\"line\":\"%016llx\"}"
enum { PROOF_BYTES = 9 + 16 + 2 };
/* The file of which a manifest may name several texts. */
static const char job_name[] = "job.yaml";

struct sc_manifest_writer {
    FILE *stream;   /* open for appending */
    char *path;     /* owned; for messages */
    uint64_t chain; /* the hash of the last line, which seeds that of the next */
};

/* ---- writing ---- */

/* @return a hash as a text of 16 hexadecimal digits: JSON numbers cannot hold 64 bits exactly. */
static json_t *hash_to_json(uint64_t value)
{
    return json_sprintf("%016llx", (unsigned long long)value);
}

/* Append @p line with its proof, which goes on the chain. Takes ownership of @p line, of which NULL
 * stands for no memory. @return SC_ERR_WRITE, SC_ERR_MEMORY. */
static sc_status add_line(const sc_ctx *ctx, sc_manifest_writer *m, json_t *line)
{
    SC_OWN(sc_free_at) char *text = NULL;
    size_t bytes;

    errno = 0;
    text = line ? json_dumps(line, JSON_COMPACT) : NULL;
    json_decref(line);
    if (!text || errno == ENOMEM) /* jansson leaves out what it has no memory for */
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", m->path);
    bytes = strlen(text) - 1; /* without the brace at the end, which is part of the proof */
    m->chain = sc_hash_bytes(text, bytes, m->chain);
    if (fprintf(m->stream, "%.*s" PROOF "\n", (int)bytes, text, (unsigned long long)m->chain) < 0)
        return sc_fail(ctx, SC_ERR_WRITE, "%s: cannot be written: %s", m->path, sc_reason(errno));
    return SC_OK;
}

/* The functions *_to_json return a new reference that the caller owns, or NULL if there is no
 * memory.
 *
 * Make the first line: schema, version, both hashes, number of frames, their size, and what segcast
 * makes in the directory. */
static json_t *head_to_json(const sc_store_job *job, const sc_names *owned)
{
    json_t *names = json_array();

    for (int i = 0; i < owned->count && names; i++) {
        if (json_array_append_new(names, json_string(owned->lines[i].name))) {
            json_decref(names);
            return NULL;
        }
    }
    return json_pack("{s:s, s:s, s:o, s:o, s:i, s:[i,i], s:o}", "schema", SCHEMA, "version",
                     job->version, "job_hash", hash_to_json(job->job_hash), "volume_hash",
                     hash_to_json(job->volume_hash), "frames", job->frames, "size",
                     job->settings.width_px, job->settings.height_px, "owns", names);
}

/* Make the line of a frame: number, hash, rank and CPU time, and of its PNG file size and hash. */
static json_t *frame_to_json(const sc_done_frame *done)
{
    if (!done->png_bytes)
        return json_pack("{s:i, s:o, s:i, s:f}", "frame", done->frame, "hash",
                         hash_to_json(done->hash), "rank", done->rank, "render_cpu_s",
                         done->render_cpu_s);
    return json_pack("{s:i, s:o, s:i, s:f, s:I, s:o}", "frame", done->frame, "hash",
                     hash_to_json(done->hash), "rank", done->rank, "render_cpu_s",
                     done->render_cpu_s, "png_bytes", (json_int_t)done->png_bytes, "png_hash",
                     hash_to_json(done->png_hash));
}

/* Make the line that says that all outputs are there, with size and hash of the video. */
static json_t *end_to_json(const sc_store_job *job, const sc_manifest_end *end)
{
    if (!strcmp(job->video, "none"))
        return json_pack("{s:b, s:i}", "complete", 1, "frames", job->frames);
    return json_pack("{s:b, s:i, s:s, s:I, s:o}", "complete", 1, "frames", job->frames, "video",
                     job->video, "video_bytes", (json_int_t)end->video_bytes, "video_hash",
                     hash_to_json(end->video_hash));
}

/* Append the line of a file. */
static sc_status add_file(const sc_ctx *ctx, sc_manifest_writer *m, const char *name,
                          uint64_t bytes, uint64_t hash)
{
    return add_line(ctx, m,
                    json_pack("{s:s, s:I, s:o}", "file", name, "bytes", (json_int_t)bytes, "hash",
                              hash_to_json(hash)));
}

/* Append the lines of @p files. */
static sc_status add_files(const sc_ctx *ctx, sc_manifest_writer *m, const sc_file_lines *files)
{
    for (int i = 0; i < files->count; i++)
        SC_PASS(
            add_file(ctx, m, files->lines[i].name, files->lines[i].bytes, files->lines[i].hash));
    return SC_OK;
}

/* Append the last line; @p files is how many lines of files there are. */
static sc_status add_last(const sc_ctx *ctx, sc_manifest_writer *m, int files)
{
    return add_line(ctx, m, json_pack("{s:b, s:i}", "end", 1, "files", files));
}

/* Hand what was appended to the system. */
static sc_status flush(const sc_ctx *ctx, const sc_manifest_writer *m)
{
    return fflush(m->stream)
               ? sc_fail(ctx, SC_ERR_WRITE, "%s: cannot be written: %s", m->path, sc_reason(errno))
               : SC_OK;
}

/* Write all lines of a new manifest; parameters as of sc_manifest_create. */
static sc_status write_lines(const sc_ctx *ctx, sc_manifest_writer *m, const sc_store_job *job,
                             const sc_manifest_data *data, const bool *keep, bool close)
{
    SC_PASS(add_line(ctx, m, head_to_json(job, &data->owned)));
    for (int k = 0; k < job->frames && data->lines; k++) {
        if (data->lines[k].known && (!keep || keep[k]))
            SC_PASS(add_line(ctx, m, frame_to_json(&data->lines[k].done)));
    }
    if (data->end.known)
        SC_PASS(add_line(ctx, m, end_to_json(job, &data->end)));
    SC_PASS(add_files(ctx, m, &data->files));
    for (int i = 0; i < data->jobs.count; i++)
        SC_PASS(add_file(ctx, m, job_name, data->jobs.lines[i].bytes, data->jobs.lines[i].hash));
    return close ? add_last(ctx, m, data->files.count + data->jobs.count) : SC_OK;
}

sc_status sc_manifest_create(const sc_ctx *ctx, const char *path, const sc_store_job *job,
                             sc_manifest_data *data, const bool *keep, bool close, sc_file_id *id,
                             sc_manifest_writer **out)
{
    SC_OWN(sc_manifest_close_at) sc_manifest_writer *manifest = NULL;
    SC_OWN(sc_outfile_discard) sc_outfile file = {0};
    struct stat info = {0};
    sc_file_id made;
    sc_status status;

    SC_PASS(SC_ZALLOC(ctx, 1, &manifest));
    SC_PASS(sc_text_copy(ctx, path, &manifest->path));
    SC_PASS(sc_outfile_open(ctx, path, true, &file));
    manifest->stream = file.stream;
    sc_file_lines_sort(&data->owned);
    sc_file_lines_sort(&data->files);
    sc_file_lines_sort(&data->jobs);
    status = write_lines(ctx, manifest, job, data, keep, close);
    manifest->stream = NULL; /* the file's own, closed by commit */
    SC_PASS(status);
    (void)fstat(fileno(file.stream), &info);
    made = (sc_file_id){info.st_dev, info.st_ino};
    status = sc_outfile_commit(ctx, &file);
    if (id && sc_file_has_id(path, &made)) /* flushing its directory may have failed */
        *id = made;
    SC_PASS(status);
    if (!out)
        return SC_OK;
    manifest->stream = fopen(path, "a");
    if (!manifest->stream)
        return sc_fail(ctx, SC_ERR_CREATE, "%s: cannot be opened: %s", path, sc_reason(errno));
    SC_HAND_OVER(manifest, out);
    return SC_OK;
}

sc_status sc_fail_no_run(const sc_ctx *ctx, const char *directory)
{
    return sc_fail(
        ctx, SC_ERR_MISSING, "%s: %s; expected the output directory of segcast render", directory,
        access(directory, F_OK) ? strerror(errno) : "holds no run: it has no manifest.jsonl");
}

bool sc_file_has_id(const char *path, const sc_file_id *id)
{
    struct stat info;

    return !lstat(path, &info) && (uint64_t)info.st_dev == id->device &&
           (uint64_t)info.st_ino == id->inode;
}

sc_status sc_manifest_add_frame(const sc_ctx *ctx, sc_manifest_writer *manifest,
                                const sc_done_frame *done)
{
    SC_PASS(add_line(ctx, manifest, frame_to_json(done)));
    return flush(ctx, manifest);
}

sc_status sc_manifest_add_job(const sc_ctx *ctx, sc_manifest_writer *manifest, uint64_t bytes,
                              uint64_t hash)
{
    SC_PASS(add_file(ctx, manifest, job_name, bytes, hash));
    return flush(ctx, manifest);
}

sc_status sc_manifest_add_close(const sc_ctx *ctx, sc_manifest_writer *manifest,
                                const sc_file_lines *files)
{
    SC_PASS(add_files(ctx, manifest, files));
    SC_PASS(add_last(ctx, manifest, files->count));
    return flush(ctx, manifest);
}

sc_status sc_manifest_sync(const sc_ctx *ctx, sc_manifest_writer *manifest)
{
    if (!manifest)
        return SC_OK;
    if (fflush(manifest->stream) || (fsync(fileno(manifest->stream)) && errno != EINVAL))
        return sc_fail(ctx, SC_ERR_WRITE, "%s: cannot be written: %s", manifest->path,
                       sc_reason(errno));
    return SC_OK;
}

void sc_manifest_close(sc_manifest_writer *manifest)
{
    if (!manifest)
        return;
    if (manifest->stream)
        fclose(manifest->stream);
    sc_free(manifest->path);
    sc_free(manifest);
}

/* ---- reading ----
 *
 * A line that proves itself may still have been forged: the functions below return false, with
 * their output untouched, for whatever segcast does not write. */

/* Read 16 hexadecimal digits in lower case. */
static bool get_hash(const json_t *line, const char *key, uint64_t *out)
{
    const char *text = json_string_value(json_object_get(line, key));

    if (!text || strlen(text) != 16 || strspn(text, "0123456789abcdef") != 16)
        return false;
    *out = strtoull(text, NULL, 16);
    return true;
}

/* Read a whole number from @p low to @p high. */
static bool get_number(const json_t *value, long long low, long long high, long long *out)
{
    const long long number = json_integer_value(value);

    if (!json_is_integer(value) || number < low || number > high)
        return false;
    *out = number;
    return true;
}

/* Read the first line into data->head, and what it says to be segcast's into data->owned.
 * @return false, with head.problem set, if it cannot be that of a manifest; SC_ERR_MEMORY through
 * @p status. */
static bool read_head(const sc_ctx *ctx, const json_t *line, sc_manifest_data *data,
                      sc_status *status)
{
    const char *schema = json_string_value(json_object_get(line, "schema"));
    const char *version = json_string_value(json_object_get(line, "version"));
    const json_t *size = json_object_get(line, "size"), *owns = json_object_get(line, "owns");
    sc_manifest_head head = {.known = true};
    long long frames, width, height;

    data->head.problem = "its first line is not that of a manifest";
    if (!schema || strcmp(schema, SCHEMA) != 0 || !version ||
        strlen(version) >= sizeof head.version || !get_hash(line, "job_hash", &head.job_hash) ||
        !get_hash(line, "volume_hash", &head.volume_hash) ||
        !get_number(json_object_get(line, "frames"), 1, SC_STORE_FRAMES_MAX, &frames) ||
        !get_number(json_array_get(size, 0), 1, 1 << 20, &width) ||
        !get_number(json_array_get(size, 1), 1, 1 << 20, &height) || !json_is_array(owns) ||
        json_array_size(owns) > OWNED_MAX)
        return false;
    strcpy(head.version, version);
    head.frames = (int)frames;
    head.size_px[0] = (int)width;
    head.size_px[1] = (int)height;
    for (size_t i = 0; i < json_array_size(owns) && *status == SC_OK; i++) {
        const char *name = json_string_value(json_array_get(owns, i));

        if (!name || !sc_own_name(name))
            return false;
        *status = sc_names_add(ctx, &data->owned, name);
    }
    data->head = head;
    return *status == SC_OK;
}

/* Read the line that says that all outputs are there. */
static bool read_end(const json_t *line, sc_manifest_end *out)
{
    const json_t *name = json_object_get(line, "video");
    const char *video = json_string_value(name);
    sc_manifest_end end = {.known = true};
    long long bytes;

    if (name) {
        if (!video || json_string_length(name) != strlen(video) || !sc_store_video_ok(video) ||
            !get_number(json_object_get(line, "video_bytes"), 1, INT64_MAX, &bytes) ||
            !get_hash(line, "video_hash", &end.video_hash))
            return false;
        strcpy(end.video, video);
        end.video_bytes = (uint64_t)bytes;
    }
    *out = end;
    return true;
}

/* Read the line of a file other than a video or a frame into data->files, or data->jobs. */
static bool read_file(const sc_ctx *ctx, const json_t *line, sc_manifest_data *data,
                      sc_status *status)
{
    const char *name = json_string_value(json_object_get(line, "file"));
    long long bytes;
    uint64_t hash;

    if (!name || strchr(name, '/') || !sc_own_name(name) ||
        !get_number(json_object_get(line, "bytes"), 0, INT64_MAX, &bytes) ||
        !get_hash(line, "hash", &hash) || data->files.count >= OWNED_MAX ||
        data->jobs.count >= OWNED_MAX)
        return false;
    *status = !strcmp(name, job_name)
                  ? sc_job_texts_put(ctx, &data->jobs, (uint64_t)bytes, hash)
                  : sc_file_lines_put(ctx, &data->files, name, (uint64_t)bytes, hash);
    return *status == SC_OK;
}

/* Read the line of a frame into data->lines, if that is not NULL, and count it. Without these lines
 * the head says how many frames there are. */
static bool read_frame(const json_t *line, sc_manifest_data *data)
{
    const json_t *seconds = json_object_get(line, "render_cpu_s");
    sc_done_frame done = {.render_cpu_s = json_number_value(seconds)};
    long long frame, rank, bytes = 0;

    if (!get_number(json_object_get(line, "frame"), 0,
                    (data->lines ? data->frames : data->head.frames) - 1, &frame) ||
        !get_number(json_object_get(line, "rank"), 0, INT32_MAX, &rank) ||
        !get_hash(line, "hash", &done.hash) || !json_is_number(seconds) ||
        !(done.render_cpu_s >= 0 && done.render_cpu_s < 1e12))
        return false;
    if (json_object_get(line, "png_bytes") &&
        (!get_number(json_object_get(line, "png_bytes"), 1, INT64_MAX, &bytes) ||
         !get_hash(line, "png_hash", &done.png_hash)))
        return false;
    done.frame = (int)frame;
    done.rank = (int)rank;
    done.png_bytes = (uint64_t)bytes;
    if (data->lines)
        data->lines[frame] = (sc_frame_line){true, done};
    data->count++;
    return true;
}

/* Put the line number @p number, from 1, into @p data. */
static bool read_line(const sc_ctx *ctx, const json_t *line, int number, sc_manifest_data *data,
                      sc_status *status)
{
    if (number == 1)
        return read_head(ctx, line, data, status);
    if (data->closed)
        return false; /* nothing follows the last line */
    if (json_is_true(json_object_get(line, "complete")))
        return read_end(line, &data->end);
    if (json_object_get(line, "file"))
        return read_file(ctx, line, data, status);
    if (json_is_true(json_object_get(line, "end"))) {
        data->closed = true;
        return true;
    }
    return read_frame(line, data);
}

/* @return whether the @p bytes at @p text are a whole line, without its newline: they end with the
 * proof of what stands before it. *chain, the hash of the line before it, is replaced then. */
static bool proves_itself(const char *text, size_t bytes, uint64_t *chain)
{
    char proof[PROOF_BYTES + 1];
    uint64_t hash;

    if (bytes <= PROOF_BYTES)
        return false;
    hash = sc_hash_bytes(text, bytes - PROOF_BYTES, *chain);
    snprintf(proof, sizeof proof, PROOF, (unsigned long long)hash);
    if (memcmp(text + bytes - PROOF_BYTES, proof, PROOF_BYTES) != 0)
        return false;
    *chain = hash;
    return true;
}

/* Read lines from @p text into @p data, at most @p lines of them. */
static sc_status read_text(const sc_ctx *ctx, const char *text, size_t bytes, int lines,
                           sc_manifest_data *data)
{
    const char *const end = text + bytes;
    uint64_t chain = 0;
    sc_status status = SC_OK;

    for (int number = 1; number <= lines && text < end && status == SC_OK; number++) {
        const char *newline = memchr(text, '\n', (size_t)(end - text));
        const size_t length = (size_t)((newline ? newline : end) - text);
        json_t *line = NULL;
        bool ok = newline && proves_itself(text, length, &chain);

        if (ok)
            line = json_loadb(text, length, 0, NULL);
        ok = ok && line && read_line(ctx, line, number, data, &status);
        json_decref(line);
        if (!ok) {
            /* A line that was cut off by an accident has no newline. If a whole line without its
             * newline is followed by something else, the newline was changed. Nothing follows the
             * last line. */
            if (newline || data->closed || (length > 0 && proves_itself(text, length - 1, &chain)))
                data->damaged_line = number;
            break; /* whatever follows a damaged line is ignored, too */
        }
        text = newline + 1;
    }
    return status;
}

/* Set what a manifest replaces in @p data. */
static void begin(sc_manifest_data *data)
{
    data->head = (sc_manifest_head){.problem = "its first line is damaged, or not of a manifest"};
    data->closed = false;
    data->damaged_line = 0;
}

/* Set head.problem if the text[bytes] is of another format of manifests. */
static void name_other_format(const char *text, size_t bytes, sc_manifest_data *data)
{
    static const char any[] = "{\"schema\":\"segcast-manifest-",
                      ours[] = "{\"schema\":\"" SCHEMA "\"";

    if (!data->head.known && bytes >= sizeof ours && !memcmp(text, any, sizeof any - 1) &&
        memcmp(text, ours, sizeof ours - 1) != 0)
        data->head.problem = "was written by another version of segcast";
}

sc_status sc_manifest_read(const sc_ctx *ctx, const char *path, sc_manifest_data *data)
{
    SC_OWN(sc_free_at) char *text = NULL;
    size_t bytes;
    sc_status status;

    SC_PASS(sc_file_read(ctx, path, MANIFEST_MAX_BYTES, &text, &bytes));
    begin(data);
    status = read_text(ctx, text, bytes, INT32_MAX, data);
    name_other_format(text, bytes, data);
    return status;
}

/* Read the beginning of a file, up to the end of its first line at least; a line of more than
 * HEAD_MAX_BYTES is cut. @return SC_ERR_MISSING if it cannot be opened or is no regular file (a
 * pipe would keep the caller waiting), SC_ERR_MEMORY. Caller owns *out: sc_free. */
static sc_status read_first_line(const sc_ctx *ctx, const char *path, char **out, size_t *bytes)
{
    enum { FIRST_BYTES = 1 << 14, HEAD_MAX_BYTES = 1 << 24 };
    struct stat info;
    SC_OWN(sc_fclose_at) FILE *stream = NULL;
    SC_OWN(sc_free_at) char *text = NULL;
    size_t used = 0;

    if (stat(path, &info) || (S_ISREG(info.st_mode) && !(stream = fopen(path, "rb"))))
        return sc_fail(ctx, sc_input_status(errno), "%s: cannot be opened: %s", path,
                       sc_reason(errno));
    if (!stream)
        return sc_fail(ctx, SC_ERR_MISSING, "%s: is not a file", path);
    for (size_t room = FIRST_BYTES; room <= HEAD_MAX_BYTES; room *= 2) {
        SC_PASS(SC_RESIZE(ctx, used, room, &text));
        used += fread(text + used, 1, room - used, stream);
        if (used < room || memchr(text, '\n', used))
            break;
    }
    *bytes = used;
    SC_HAND_OVER(text, out);
    return SC_OK;
}

sc_status sc_manifest_read_head(const sc_ctx *ctx, const char *path, sc_manifest_data *data)
{
    SC_OWN(sc_free_at) char *text = NULL;
    size_t bytes = 0;
    sc_status status;

    SC_PASS(read_first_line(ctx, path, &text, &bytes));
    begin(data);
    status = read_text(ctx, text, bytes, 1, data);
    name_other_format(text, bytes, data);
    return status;
}

void sc_manifest_data_clear(sc_manifest_data *data)
{
    sc_file_lines_clear(&data->owned);
    sc_file_lines_clear(&data->files);
    sc_file_lines_clear(&data->jobs);
}
