/* SPDX-License-Identifier: BSD-3-Clause */
/* Loading a job: its sources are merged into one tree, which is then read by the table of keys. */
#include "segcast/job.h"

#include "describe.h"

enum { JOB_MAX_BYTES = 1 << 20 };

/* Put settings into the tree, the later over the earlier. @param only_missing skip those whose key
 * the tree has already. @return the first mistake; all are logged. */
static sc_status apply_settings(const sc_ctx *ctx, const sc_setting *settings, size_t count,
                                bool only_missing, sc_yaml *root)
{
    sc_status status = SC_OK;

    for (size_t i = 0; i < count; i++) {
        const sc_setting *s = &settings[i];

        if (only_missing && sc_key_node(root, s->path))
            continue;
        if (!sc_goes_on(&status, (s->literal ? sc_setting_apply_text : sc_setting_apply)(
                                     ctx, sc_job_keys, root, s->origin, s->path, s->value)))
            break;
    }
    return status;
}

enum { VARIABLES_MAX = 256, VARIABLE_BYTES = 96 };

/* The names of all environment variables of keys. */
typedef struct variables {
    char names[VARIABLES_MAX][VARIABLE_BYTES];
    size_t count;
} variables;

/* Add the name of the variable of a row. For sc_keys_walk, with variables as user. */
static sc_status add_variable(const sc_ctx *ctx, void *user, const sc_key_visit *visit)
{
    variables *v = user;

    if (v->count == VARIABLES_MAX)
        return SC_OK;
    sc_key_variable(visit->path, v->names[v->count], VARIABLE_BYTES);
    v->count += v->names[v->count][0] != '\0';
    return SC_OK;
}

/* Warn of an environment variable that names no key, with the nearest that does. */
static sc_status warn_of_variable(const sc_ctx *ctx, const char *name)
{
    const char *candidates[VARIABLES_MAX], *nearest;
    SC_OWN(sc_free_at) variables *v = NULL;

    SC_PASS(SC_ZALLOC(ctx, 1, &v));
    SC_PASS(sc_keys_walk(ctx, add_variable, v));
    for (size_t i = 0; i < v->count; i++)
        candidates[i] = v->names[i];
    nearest = sc_nearest_word(name, candidates, v->count);
    sc_warn(ctx, "environment variable %s names no key of a job and is not used%s%s%s", name,
            nearest ? "; did you mean " : "", nearest ? nearest : "", nearest ? "?" : "");
    return SC_OK;
}

/* Put every variable that begins with SEGCAST_ into the tree. One that names no key is warned of
 * and skipped: it may belong to another program. @return the first mistake; all are logged. */
static sc_status apply_environment(const sc_ctx *ctx, const char *const *environment, sc_yaml *root)
{
    static const char prefix[] = "SEGCAST_";
    sc_status status = SC_OK;

    for (; environment && *environment; environment++) {
        const char *entry = *environment, *equals = strchr(entry, '=');
        char name[256] = "", path[256];
        size_t length;

        if (strncmp(entry, prefix, sizeof prefix - 1) || !equals)
            continue;
        length = (size_t)(equals - entry);
        if (length >= sizeof name) { /* no key has such a long path */
            sc_warn(ctx, "environment variable %.*s names no key of a job and is not used",
                    (int)length, entry);
            continue;
        }
        memcpy(name, entry, length);
        if (!strcmp(name, "SEGCAST_THREADS") || !strcmp(name, "SEGCAST_MAX_MEMORY") ||
            !strcmp(name, "SEGCAST_MPI") || !strcmp(name, "SEGCAST_CACHE"))
            continue; /* options of the command line, how to start, what is kept: not keys */
        if (!sc_goes_on(&status,
                        sc_setting_path(sc_job_keys, name + sizeof prefix - 1, path, sizeof path)
                            ? sc_setting_apply(ctx, sc_job_keys, root, entry, path, equals + 1)
                            : warn_of_variable(ctx, name)))
            break;
    }
    return status;
}

/* ---- loading ---- */

/* Read the job file into a tree, an empty one if there is no file. @p text holds the file, which
 * stays with the caller, also after an error. */
static sc_status read_root(const sc_ctx *ctx, const sc_job_sources *sources, char **text,
                           sc_yaml **out)
{
    const char *origin = sources->path   ? sources->path
                         : sources->name ? sources->name
                                         : "command line";
    size_t bytes = 0;

    if (sources->path && !sources->text)
        SC_PASS(sc_file_read(ctx, sources->path, JOB_MAX_BYTES, text, &bytes));
    else if (sources->text)
        bytes = strlen(sources->text);
    SC_PASS(sc_yaml_parse(ctx, origin,
                          sources->text ? sources->text
                          : *text       ? *text
                                        : "",
                          bytes, out));
    if (!sources->path)
        (*out)->line = 0;
    if ((*out)->kind != SC_YAML_MAP)
        return sc_wrong_type(ctx, *out, "a map of keys such as volume and output");
    return SC_OK;
}

/* If a job has shots, take what only they need out of its tree: *base becomes a copy of the tree
 * without the list of shots, and the tree itself loses what each of them has for itself. */
static sc_status part_shots(const sc_ctx *ctx, sc_yaml *root, sc_yaml **base)
{
    static const char *const defaults[] = {"animation", "overlays"};

    if (!sc_yaml_member(root, "shots"))
        return SC_OK;
    SC_PASS(sc_yaml_copy(ctx, root, base));
    sc_yaml_remove(*base, sc_yaml_index(*base, "shots"));
    for (size_t i = 0; i < SC_COUNT_OF(defaults); i++) {
        const size_t at = sc_yaml_index(root, defaults[i]);

        if (at < root->count)
            sc_yaml_remove(root, at);
    }
    return SC_OK;
}

/* Put all sources into the tree of the job file and read it into @p job, which holds the defaults.
 * @return the first mistake; all are logged. */
static sc_status read_job(const sc_ctx *ctx, const sc_job_sources *sources, sc_yaml *root,
                          sc_job *job)
{
    sc_status status = root->key_left_out ? SC_ERR_DATA : SC_OK;
    sc_yaml *base = NULL;
    sc_clock clock;

    if (sc_goes_on(&status,
                   apply_settings(ctx, sources->defaults, sources->default_count, true, root)) &&
        sc_goes_on(&status, apply_environment(ctx, sources->environment, root)) &&
        sc_goes_on(&status,
                   apply_settings(ctx, sources->settings, sources->setting_count, false, root)) &&
        sc_goes_on(&status, part_shots(ctx, root, &base)) &&
        sc_goes_on(&status, sc_look_apply(ctx, root)) &&
        sc_goes_on(&status, sc_tell_misplaced(ctx, root))) {
        sc_clock_start(job, base != NULL, root, &clock);
        if (sc_goes_on(&status, sc_keys_read(ctx, sc_job_keys, root, job)) &&
            sc_goes_on(&status, sc_job_check(ctx, sources, root, job)) && base)
            (void)sc_goes_on(
                &status, sc_shots_resolve(ctx, sources, base, sc_yaml_member(root, "shots"), job));
    }
    sc_yaml_free(base);
    return status;
}

sc_status sc_job_load(const sc_ctx *ctx, const sc_job_sources *sources, sc_job *out)
{
    sc_once once; /* a mistake of a key of the film is found again in each of its shots */
    const sc_ctx counting = sc_ctx_once(ctx, &once);
    SC_OWN(sc_free_at) char *text = NULL;
    SC_OWN(sc_yaml_free_at) sc_yaml *root = NULL;
    SC_OWN(sc_job_clear) sc_job job = {0};
    sc_status status, first = SC_OK;

    SC_PASS(sc_keys_set_defaults(ctx, sc_job_keys, &job));
    SC_PASS(read_root(&counting, sources, &text, &root));
    status = read_job(&counting, sources, root, &job);
    sc_once_end(&once, "the job");
    if (sc_goes_on(&first, status))
        SC_HAND_OVER(job, out);
    return status;
}

#define ARRAY(member, number)                                                                      \
    {                                                                                              \
        offsetof(sc_job, member), offsetof(sc_job, number), sizeof *((sc_job *)0)->member          \
    }

static const struct {
    size_t array, count; /* where the job has its address, and its number of elements */
    size_t bytes;        /* of an element */
} arrays[SC_JOB_ARRAYS] = {ARRAY(tissues.rules, tissues.rule_count),
                           ARRAY(tissues.exceptions, tissues.exception_count),
                           ARRAY(verbs.list, verbs.count),
                           ARRAY(verbs.tissues, verbs.tissue_count),
                           ARRAY(overlay_lists.captions, overlay_lists.caption_count),
                           ARRAY(overlay_lists.tissues, overlay_lists.tissue_count),
                           ARRAY(volume.tissues, volume.tissue_count),
                           ARRAY(film.shots, film.shot_count),
                           ARRAY(volume.phases, volume.phase_count),
                           ARRAY(tissues.tracks, tissues.track_count)};

void *sc_job_array(const sc_job *job, int i, size_t *count, size_t *bytes)
{
    void *array;

    memcpy(&array, (const char *)job + arrays[i].array, sizeof array);
    memcpy(count, (const char *)job + arrays[i].count, sizeof *count);
    *bytes = arrays[i].bytes;
    return array;
}

void sc_job_set_array(sc_job *job, int i, void *array)
{
    memcpy((char *)job + arrays[i].array, &array, sizeof array);
}

void sc_job_clear(sc_job *job)
{
    size_t count, bytes;

    for (size_t i = 0; i < job->film.shot_count && job->film.shots; i++)
        sc_job_clear(&job->film.shots[i].job); /* which has no shots */
    for (int i = 0; i < SC_JOB_ARRAYS; i++)
        sc_free(sc_job_array(job, i, &count, &bytes));
    *job = (sc_job){0};
}

sc_status sc_job_write_tree(const sc_ctx *ctx, const sc_job_sources *sources, sc_text *out)
{
    SC_OWN(sc_free_at) char *text = NULL;
    SC_OWN(sc_yaml_free_at) sc_yaml *root = NULL;

    SC_PASS(read_root(ctx, sources, &text, &root));
    SC_PASS(apply_settings(ctx, sources->defaults, sources->default_count, true, root));
    SC_PASS(apply_settings(ctx, sources->settings, sources->setting_count, false, root));
    return sc_tree_to_json(ctx, root, out);
}

bool sc_job_has_views(const sc_job *job)
{
    bool has_views = job->output.layout == SC_LAYOUT_VIEWS && !job->film.shot_count;

    for (size_t i = 0; i < job->film.shot_count; i++)
        has_views = has_views || job->film.shots[i].job.output.layout == SC_LAYOUT_VIEWS;
    return has_views;
}

sc_status sc_job_write(const sc_ctx *ctx, const sc_job *job, bool identity, sc_text *text)
{
    return sc_keys_write(ctx, sc_job_keys, job, 0, identity ? SC_WRITE_IDENTITY : SC_WRITE_ALL,
                         text);
}

sc_status sc_job_write_json(const sc_ctx *ctx, const sc_job *job, sc_text *text)
{
    SC_OWN(sc_text_clear) sc_text yaml = {0};
    SC_OWN(sc_yaml_free_at) sc_yaml *root = NULL;

    SC_PASS(sc_job_write(ctx, job, false, &yaml));
    SC_PASS(sc_yaml_parse(ctx, "job", yaml.data, yaml.length_bytes, &root));
    return sc_tree_to_json(ctx, root, text);
}
