/* SPDX-License-Identifier: BSD-3-Clause */
/* Where a film or a study comes from, as an RO-Crate: https://w3id.org/ro/crate/1.1, with the
 * profile https://w3id.org/ro/wfrun/process/0.5 for runs of a program. All functions *_json return
 * a new reference that the caller owns, or NULL if there is no memory. */
#define _GNU_SOURCE /* timegm, strptime */
#include "internal.h"
#include "segcast/json_values.h"
#include "segcast/store.h"

#include <math.h>
#include <time.h>

#define CRATE_SPECIFICATION "https://w3id.org/ro/crate/1.1"
#define CRATE_PROFILE "https://w3id.org/ro/wfrun/process/0.5"
#define CRATE_TERMS "https://w3id.org/ro/terms/workflow-run/context"

/* What files are for, by the beginning of their names up to the first dot. */
static const struct {
    const char *stem, *about;
} purposes[] = {{"job", "The job as it was resolved"},
                {"manifest", "What was made, with sizes and hashes, which segcast verify proves"},
                {"status", "How far the run came"},
                {"stats", "What the runs have measured"},
                {"frames", "What was measured of each frame"},
                {"trace", "What each thread did when"},
                {"measurements", "All measurements of the study, in the order of time"},
                {"cells", "What follows from the measurements for each cell"},
                {"extrap", "The measurements for Extra-P"},
                {"study", "The study as it was read"},
                {"report", "A page with what was measured"}};

/* Formats of files, by the end of their names. */
static const struct {
    const char *ending, *format;
} formats[] = {
    {".mp4", "video/mp4"},         {".mkv", "video/x-matroska"},    {".webm", "video/webm"},
    {".mov", "video/quicktime"},   {".gif", "image/gif"},           {".webp", "image/webp"},
    {".json", "application/json"}, {".jsonl", "application/jsonl"}, {".csv", "text/csv"},
    {".html", "text/html"},        {".yaml", "application/yaml"}};

/* What is being made. An array is NULL once there was no memory for it. */
typedef struct crate_draft {
    const sc_crate *crate;
    json_t *graph;    /* all entities */
    json_t *parts;    /* references to what belongs to the root */
    json_t *results;  /* references to what runs have made: the film */
    json_t *mentions; /* references to actions */
} crate_draft;

/* A reference to an entity. */
static json_t *reference_json(const char *id)
{
    return json_pack("{s:s}", "@id", id);
}

/* Add an entity to the graph, unless one of this id is there; takes it. */
static void add_entity(crate_draft *d, json_t *entity)
{
    const char *id = json_string_value(json_object_get(entity, "@id"));

    for (size_t i = 0; id && i < json_array_size(d->graph); i++) {
        if (!strcmp(id, json_string_value(json_object_get(json_array_get(d->graph, i), "@id")))) {
            json_decref(entity);
            return;
        }
    }
    d->graph = sc_json_with(d->graph, entity);
}

/* Add a reference to an array, unless it is there; NULL stays NULL. */
static void add_reference(json_t **to, const char *id)
{
    for (size_t i = 0; i < json_array_size(*to); i++) {
        if (!strcmp(id, json_string_value(json_object_get(json_array_get(*to, i), "@id"))))
            return;
    }
    *to = sc_json_with(*to, reference_json(id));
}

/* Format a time as ISO 8601, in UTC. */
static void format_time(time_t seconds, char out[32])
{
    struct tm utc;

    out[0] = '\0';
    if (gmtime_r(&seconds, &utc))
        strftime(out, 32, "%Y-%m-%dT%H:%M:%SZ", &utc);
}

bool sc_parse_time(const char *text, time_t *out)
{
    struct tm utc = {0};
    const bool is_time = strptime(text, "%Y-%m-%dT%H:%M:%SZ", &utc) != NULL;

    *out = timegm(&utc);
    return is_time;
}

/* Find when a run has ended, to the second. @return false if it has not, or if its times are not
 * what segcast writes. */
static bool end_of(const sc_run_entry *run, char out[32])
{
    time_t begin;

    out[0] = '\0';
    if (run->ended && sc_parse_time(run->begin, &begin))
        format_time(begin + (time_t)ceil(fmax(0, fmin(run->wall_s, 1e9))), out);
    return out[0] != '\0';
}

/* @return the licence of the film, which stands behind its author; NULL: none is stated. */
static const char *licence_of(const char *author)
{
    const char *found = NULL;

    for (const char *at = author; (at = strstr(at, "; ")) && at[2]; at += 2)
        found = at + 2;
    return found;
}

/* The licence: a reference to an entity if it is an address, or looks like an identifier of SPDX: a
 * word with a hyphen. Else words. */
static json_t *licence_json(crate_draft *d)
{
    const char *licence = licence_of(d->crate->author);
    const bool is_address =
        licence && (!strncmp(licence, "https://", 8) || !strncmp(licence, "http://", 7));
    const bool is_spdx = licence && !is_address && strlen(licence) < 64 && strchr(licence, '-') &&
                         !strpbrk(licence, " /:\"<>\\");
    char id[512];

    if (!licence)
        return json_string("No licence is stated. Ask the author before it is used.");
    if (!is_address && !is_spdx)
        return json_string(licence);
    snprintf(id, sizeof id, "%s%s", is_spdx ? "https://spdx.org/licenses/" : "", licence);
    add_entity(d,
               json_pack("{s:s, s:s, s:s}", "@id", id, "@type", "CreativeWork", "name", licence));
    return reference_json(id);
}

/* @return what @p name is for, or what the film is; static. */
static const char *purpose_of(const crate_draft *d, const char *name)
{
    if (!strcmp(name, d->crate->video))
        return "The film";
    if (!strcmp(name, "frames/"))
        return "The frames of the film";
    for (size_t i = 0; i < SC_COUNT_OF(purposes); i++) {
        const size_t length = strlen(purposes[i].stem);

        if (!strncmp(name, purposes[i].stem, length) && name[length] == '.')
            return purposes[i].about;
    }
    return "A part of the film, which is not finished";
}

/* Write the name of a file as an address that is relative to the directory. */
static void format_address(const char *name, char out[3 * 256])
{
    static const char plain[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~/";
    size_t used = 0;

    for (const char *c = name; *c && used + 4 < 3 * 256; c++)
        used +=
            (size_t)snprintf(out + used, 4, strchr(plain, *c) ? "%c" : "%%%02X", (unsigned char)*c);
    out[used] = '\0';
}

/* Add what was made in the directory. */
static void add_parts(crate_draft *d)
{
    const sc_text *names = &d->crate->parts;

    for (size_t at = 0; at < names->length_bytes; at += strlen(names->data + at) + 1) {
        const char *name = names->data + at;
        const size_t length = strlen(name);
        const bool is_directory = length > 0 && name[length - 1] == '/';
        const bool is_video = !strcmp(name, d->crate->video);
        char id[3 * 256];
        json_t *part;

        if (!strcmp(name, SC_CRATE_NAME)) /* which is no part of itself */
            continue;
        format_address(name, id);
        part =
            json_pack("{s:s, s:s, s:s, s:s}", "@id", id, "@type", is_directory ? "Dataset" : "File",
                      "name", name, "description", purpose_of(d, name));
        for (size_t f = 0; f < SC_COUNT_OF(formats); f++) {
            if (sc_stem_length(name, &formats[f].ending, 1))
                part = sc_json_with_key(part, "encodingFormat", json_string(formats[f].format));
        }
        if (is_video && d->crate->video_bytes)
            part =
                sc_json_with_key(part, "contentSize",
                                 json_sprintf("%llu", (unsigned long long)d->crate->video_bytes));
        add_entity(d, part);
        add_reference(&d->parts, id);
        if (is_video || is_directory)
            add_reference(&d->results, id);
    }
}

/* Add a value that describes a run, and a reference to it to @p to; takes the value. */
static void add_value(crate_draft *d, json_t **to, const char *id, const char *name, json_t *value)
{
    add_entity(d, json_pack("{s:s, s:s, s:s, s:o}", "@id", id, "@type", "PropertyValue", "name",
                            name, "value", value));
    add_reference(to, id);
}

/* Is it a SHA-256 in hexadecimal digits? */
static bool is_sha256(const char *text)
{
    return text && strlen(text) == SC_SHA256_BYTES - 1 &&
           strspn(text, "0123456789abcdef") == SC_SHA256_BYTES - 1;
}

/* Add an input, an element of `inputs` of a run, and a reference to it to @p objects. Its name is
 * left out, since names of files often hold those of persons. */
static void add_input(crate_draft *d, json_t **objects, const json_t *input, size_t number)
{
    const char *use = json_string_value(json_object_get(input, "use"));
    const char *sha256 = json_string_value(json_object_get(input, "sha256"));
    const json_t *bytes = json_object_get(input, "bytes"), *files = json_object_get(input, "files");
    const char *type = !is_sha256(sha256) ? "CreativeWork" : files ? "Dataset" : "File";
    char id[SC_SHA256_BYTES + 32];
    json_t *entity;

    if (!use)
        return;
    if (is_sha256(sha256))
        snprintf(id, sizeof id, "nih:sha-256;%s", sha256); /* RFC 6920: named by what it holds */
    else
        snprintf(id, sizeof id, "#input-%zu", number);
    entity = json_pack("{s:s, s:s, s:s}", "@id", id, "@type", type, "name", use);
    if (files)
        entity = sc_json_with_key(
            entity, "description",
            json_sprintf(
                "%lld files. The SHA-256 is that of the list \"SHA-256  ./NAME\" of all, as "
                "sha256sum prints it, in the order of their names",
                (long long)json_integer_value(files)));
    if (json_is_integer(bytes))
        entity = sc_json_with_key(entity, "contentSize",
                                  json_sprintf("%lld", (long long)json_integer_value(bytes)));
    if (is_sha256(sha256)) {
        entity = sc_json_with_key(entity, "sha256", json_string(sha256));
        add_reference(&d->parts, id);
    }
    add_entity(d, entity);
    add_reference(objects, id);
}

/* Add what all runs have in common of what they were made from: the hashes. */
static void add_hashes(crate_draft *d, json_t **objects)
{
    if (d->crate->job.volume)
        add_value(d, objects, "#volume-hash",
                  "XXH3 of the voxels, labels and geometry of the volumes",
                  sc_json_of_hash(d->crate->job.volume));
    add_value(d, objects, "#job-hash", "XXH3 of all keys of the job that pictures depend on",
              sc_json_of_hash(d->crate->job.job));
}

/* @return the id of the program that did a run; an entity of it is added. */
static const char *add_program(crate_draft *d, const sc_run_entry *run,
                               char id[SC_RUN_TEXT_BYTES + 16])
{
    json_t *program;

    snprintf(id, SC_RUN_TEXT_BYTES + 16, "#segcast%s%s", run->commit[0] ? "-" : "", run->commit);
    program = json_pack("{s:s, s:s, s:s, s:s}", "@id", id, "@type", "SoftwareApplication", "name",
                        "segcast", "softwareVersion", d->crate->version);
    if (run->commit[0])
        program = sc_json_with_key(program, "description",
                                   json_sprintf("Built from the commit %s", run->commit));
    add_entity(d, program);
    return id;
}

/* Add the action of a run. */
static void add_action(crate_draft *d, const sc_run_entry *run)
{
    const bool is_known = run->made_from != NULL;
    json_t *from = is_known ? json_loads(run->made_from, 0, NULL) : json_object();
    const char *command = json_string_value(json_object_get(from, "command"));
    const json_t *inputs = json_object_get(from, "inputs");
    json_t *objects = json_array(), *action;
    char id[32], program[SC_RUN_TEXT_BYTES + 16], end[32];

    snprintf(id, sizeof id, "#run-%016llx", (unsigned long long)run->id);
    for (size_t i = 0; i < json_array_size(inputs); i++)
        add_input(d, &objects, json_array_get(inputs, i), i + 1);
    add_hashes(d, &objects);
    action = json_pack(
        "{s:s, s:s, s:o, s:o, s:o, s:o, s:s, s:{s:s}}", "@id", id, "@type", "CreateAction", "name",
        json_sprintf("%d %s", run->frames, d->crate->done), "description",
        json_sprintf("Command: %s. Machine: %s, %d nodes, %d ranks, %d threads on rank 0. Kernel: "
                     "%s. MPI: %s.",
                     command ? command : "unknown", run->processor[0] ? run->processor : "unknown",
                     run->nodes, run->ranks, run->threads, run->kernel[0] ? run->kernel : "unknown",
                     run->mpi[0] ? run->mpi : "none"),
        "instrument", reference_json(add_program(d, run, program)), "object", objects, "startTime",
        run->begin, "actionStatus", "@id",
        run->ended ? "http://schema.org/CompletedActionStatus"
                   : "http://schema.org/ActiveActionStatus");
    if (end_of(run, end))
        action = sc_json_with_key(action, "endTime", json_string(end));
    if (json_array_size(d->results))
        action = sc_json_with_key(action, "result", json_copy(d->results));
    json_decref(from);
    add_entity(d, action);
    add_reference(&d->mentions, id);
}

/* The root entity. Takes the references of @p d. */
static json_t *root_json(crate_draft *d)
{
    const sc_crate *c = d->crate;
    const char *licence = licence_of(c->author);
    const size_t author_bytes = licence ? (size_t)(licence - 2 - c->author) : strlen(c->author);
    char published[32] = "";
    json_t *root;

    for (int i = 0; i < c->runs->run_count; i++) {
        char end[32];

        if (!end_of(&c->runs->runs[i], end))
            snprintf(end, sizeof end, "%.31s", c->runs->runs[i].begin);
        if (strcmp(end, published) > 0)
            strcpy(published, end);
    }
    if (!published[0]) /* the statistics are lost */
        format_time(time(NULL), published);
    published[strcspn(published, "T")] = '\0';
    root = json_pack("{s:s, s:s, s:{s:s}, s:s, s:o, s:s, s:o, s:o, s:o}", "@id", "./", "@type",
                     "Dataset", "conformsTo", "@id", CRATE_PROFILE, "name", c->name, "description",
                     json_sprintf("%s by segcast %s", c->about, c->version), "datePublished",
                     published, "license", licence_json(d), "hasPart", d->parts, "mentions",
                     d->mentions);
    if (author_bytes) {
        add_entity(d, json_pack("{s:s, s:s, s:s%}", "@id", "#author", "@type", "Person", "name",
                                c->author, author_bytes));
        root = sc_json_with_key(root, "author", reference_json("#author"));
    }
    return root;
}

/* Add the entities that all crates have. */
static void add_frame(crate_draft *d)
{
    add_entity(d, json_pack("{s:s, s:s, s:{s:s}, s:{s:s}}", "@id", SC_CRATE_NAME, "@type",
                            "CreativeWork", "conformsTo", "@id", CRATE_SPECIFICATION, "about",
                            "@id", "./"));
    add_entity(d, json_pack("{s:s, s:s, s:s, s:s}", "@id", CRATE_PROFILE, "@type", "CreativeWork",
                            "name", "Process Run Crate", "version", "0.5"));
}

sc_status sc_crate_make(const sc_ctx *ctx, const sc_crate *crate, sc_text *out)
{
    crate_draft d = {crate, json_array(), json_array(), json_array(), json_array()};
    json_t *root, *all;

    add_frame(&d);
    add_parts(&d);
    for (int i = 0; i < crate->runs->run_count; i++)
        add_action(&d, &crate->runs->runs[i]);
    root = root_json(&d);
    add_entity(&d, root);
    all = json_pack("{s:[s,s], s:o}", "@context", CRATE_SPECIFICATION "/context", CRATE_TERMS,
                    "@graph", d.graph);
    json_decref(d.results);
    return sc_json_add_text(ctx, all, JSON_INDENT(1), SC_CRATE_NAME, out);
}
