/* SPDX-License-Identifier: BSD-3-Clause */
/* Study files: read by the same machinery as job files. Settings of jobs are kept as texts, which
 * the loading of a cell's job checks. */
#include "segcast/study_file.h"

#include "key.h"
#include "segcast/comm.h"

enum { STUDY_MAX_BYTES = 1 << 20, VALUES_MAX = 1000, RANKS_MAX = 1000000, THREADS_MAX = 4096 };

static const char *const placements[] = {[SC_COMM_PACKED] = "packed", [SC_COMM_SPREAD] = "spread"};

/* ---- texts of values ---- */

/* Can @p text stand in a flow of YAML without quotes? */
static bool is_plain(const sc_yaml *node)
{
    return !node->quoted && node->text[0] &&
           strspn(node->text,
                  "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_.%+/ ") ==
               strlen(node->text);
}

/* Append @p node as YAML in one line. */
static sc_status add_flow(const sc_ctx *ctx, const sc_yaml *node, sc_text *text)
{
    const bool is_map = node->kind == SC_YAML_MAP;

    if (node->kind == SC_YAML_SCALAR)
        return is_plain(node) ? sc_text_add(ctx, text, "%s", node->text)
                              : sc_write_quoted(ctx, node->text, text);
    SC_PASS(sc_text_add(ctx, text, is_map ? "{" : "["));
    for (size_t i = 0; i < node->count; i++) {
        SC_PASS(sc_text_add(ctx, text, "%s", i ? ", " : ""));
        if (is_map) {
            SC_PASS(sc_write_quoted(ctx, node->items[i]->key, text));
            SC_PASS(sc_text_add(ctx, text, ": "));
        }
        SC_PASS(add_flow(ctx, node->items[i], text));
    }
    return sc_text_add(ctx, text, is_map ? "}" : "]");
}

/* Copy the text of a single value, or write another one in one line. Caller owns *out. */
static sc_status text_of(const sc_ctx *ctx, const sc_yaml *node, char **out)
{
    SC_OWN(sc_text_clear) sc_text text = {0};

    if (node->kind == SC_YAML_SCALAR)
        return sc_text_copy(ctx, node->text, out);
    SC_PASS(add_flow(ctx, node, &text));
    SC_HAND_OVER(text.data, out);
    return SC_OK;
}

/* Copy a path of the study file, which is relative to that file. Caller owns *out. */
static sc_status path_of(const sc_ctx *ctx, const sc_yaml *node, const char *path, char **out)
{
    return sc_path_beside(ctx, node->origin, path, out);
}

/* ---- settings ---- */

static void clear_settings(sc_study_settings *settings)
{
    for (size_t i = 0; i < settings->count; i++) {
        sc_free((void *)(uintptr_t)settings->items[i].origin);
        sc_free((void *)(uintptr_t)settings->items[i].path);
        sc_free((void *)(uintptr_t)settings->items[i].value);
    }
    sc_free(settings->items);
    *settings = (sc_study_settings){.placement = -1};
}

/* Fill one setting of the job from @p node. Its texts are the caller's, also after an error. */
static sc_status fill_setting(const sc_ctx *ctx, const char *path, const sc_yaml *node,
                              sc_setting *out)
{
    const bool is_path = !strcmp(path, "volume") || !strcmp(path, "labels") ||
                         !strcmp(path, "color_by.values") || !strcmp(path, "image.path");
    SC_OWN(sc_text_clear) sc_text origin = {0}, copy = {0};
    char *value = NULL;

    SC_PASS(sc_text_add(ctx, &origin, "%s:%d: %s", node->origin, node->line, path));
    SC_PASS(sc_text_add(ctx, &copy, "%s", path));
    if (is_path && node->kind == SC_YAML_SCALAR && !sc_job_is_phantom(node->text))
        SC_PASS(path_of(ctx, node, node->text, &value));
    else
        SC_PASS(text_of(ctx, node, &value));
    *out = (sc_setting){.origin = origin.data,
                        .path = copy.data,
                        .value = value,
                        .literal = node->kind == SC_YAML_SCALAR};
    origin = copy = (sc_text){0};
    return SC_OK;
}

/* Read a whole number from 1 to @p most. */
static sc_status read_count(const sc_ctx *ctx, const sc_yaml *node, int most, int *out)
{
    const sc_key key = {.type = &sc_type_int, .low = 1, .high = most};

    return sc_type_int.read(ctx, &key, node, out);
}

/* Read what @p path, a key of the machine or of the job, is set to by @p node. @p out has room for
 * one setting more. */
static sc_status read_setting(const sc_ctx *ctx, const char *path, const sc_yaml *node,
                              sc_study_settings *out)
{
    sc_status status;

    if (!strcmp(path, "ranks"))
        return read_count(ctx, node, RANKS_MAX, &out->ranks);
    if (!strcmp(path, "threads"))
        return read_count(ctx, node, THREADS_MAX, &out->threads);
    if (!strcmp(path, "placement")) {
        for (size_t i = 0; i < SC_COUNT_OF(placements) && node->kind == SC_YAML_SCALAR; i++) {
            if (!strcmp(node->text, placements[i])) {
                out->placement = (int)i;
                return SC_OK;
            }
        }
        return sc_wrong_type(ctx, node, "packed or spread");
    }
    status = fill_setting(ctx, path, node, &out->items[out->count]);
    out->count += status == SC_OK;
    return status;
}

/* Can @p path be set: does it begin with a key of a job, or is it one of the machine? */
static sc_status check_path(const sc_ctx *ctx, const sc_yaml *node, const char *path)
{
    const char *words[64] = {"ranks", "threads", "placement"};
    size_t count = 3;
    sc_yaml unknown; /* borrows all of the node */
    char first[64];

    snprintf(first, sizeof first, "%.*s", (int)strcspn(path, "."), path);
    for (const sc_key *key = sc_job_keys; key->name && count < SC_COUNT_OF(words); key++)
        words[count++] = key->name;
    for (size_t i = 0; i < count; i++) {
        if (!strcmp(words[i], first) && (i >= 3 || !path[strlen(first)]))
            return SC_OK;
    }
    unknown = *node;
    unknown.key = first;
    return sc_unknown_word(ctx, &unknown, first, words, count);
}

/* Read a map of settings into @p out, which is empty. @return the first mistake; all are logged. */
static sc_status read_settings_of(const sc_ctx *ctx, const sc_yaml *node, sc_study_settings *out)
{
    sc_status status = SC_OK;

    *out = (sc_study_settings){.placement = -1};
    if (node->kind != SC_YAML_MAP)
        return sc_wrong_type(ctx, node, "a map of settings, such as {render.skip: leap}");
    SC_PASS(SC_ZALLOC(ctx, node->count, &out->items));
    for (size_t i = 0; i < node->count; i++) {
        const sc_yaml *item = node->items[i];
        sc_status found = check_path(ctx, item, item->key);

        if (found == SC_OK)
            found = read_setting(ctx, item->key, item, out);
        if (!sc_goes_on(&status, found))
            break;
    }
    return status;
}

/* sc_study_settings: the settings of all cells. */
static sc_status read_set(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    return read_settings_of(ctx, node, value);
}

/* Append a map of settings in one line. */
static sc_status add_settings(const sc_ctx *ctx, const sc_study_settings *settings, sc_text *text)
{
    const char *comma = "";

    SC_PASS(sc_text_add(ctx, text, "{"));
    for (size_t i = 0; i < settings->count; i++, comma = ", ") {
        const sc_setting *s = &settings->items[i];

        SC_PASS(sc_text_add(ctx, text, "%s", comma));
        SC_PASS(sc_write_quoted(ctx, s->path, text));
        SC_PASS(sc_text_add(ctx, text, ": "));
        SC_PASS(s->literal ? sc_write_quoted(ctx, s->value, text)
                           : sc_text_add(ctx, text, "%s", s->value));
    }
    if (settings->ranks) {
        SC_PASS(sc_text_add(ctx, text, "%sranks: %d", comma, settings->ranks));
        comma = ", ";
    }
    if (settings->threads) {
        SC_PASS(sc_text_add(ctx, text, "%sthreads: %d", comma, settings->threads));
        comma = ", ";
    }
    if (settings->placement >= 0)
        SC_PASS(sc_text_add(ctx, text, "%splacement: %s", comma, placements[settings->placement]));
    return sc_text_add(ctx, text, "}");
}

static sc_status write_set(const sc_ctx *ctx, const sc_key *key, const void *value, sc_text *text)
{
    return add_settings(ctx, value, text);
}

static const sc_value_type type_settings = {
    .name = "map of settings",
    .expected = "a map of settings",
    .read = read_set,
    .write = write_set,
    .schema = "{type: object}",
};

/* ---- axes ---- */

static void clear_axis(sc_study_axis *axis)
{
    for (int i = 0; i < axis->value_count; i++) {
        sc_free(axis->values[i].name);
        clear_settings(&axis->values[i].settings);
    }
    sc_free(axis->values);
    sc_free(axis->name);
    *axis = (sc_study_axis){0};
}

/* Read a value: of a list, what the key that names the axis is set to; of a map, settings under a
 * name. @param out owns what is read, also after an error. */
static sc_status read_value(const sc_ctx *ctx, const sc_yaml *axis, const sc_yaml *node,
                            sc_study_value *out)
{
    out->settings.placement = -1;
    if (axis->kind == SC_YAML_MAP) {
        SC_PASS(sc_text_copy(ctx, node->key, &out->name));
        return read_settings_of(ctx, node, &out->settings);
    }
    SC_PASS(text_of(ctx, node, &out->name));
    SC_PASS(SC_ZALLOC(ctx, 1, &out->settings.items));
    return read_setting(ctx, axis->key, node, &out->settings);
}

/* @return whether two of the first @p count values have one name. */
static bool is_doubled(const sc_study_axis *axis, int count)
{
    for (int i = 0; i < count; i++) {
        if (!strcmp(axis->values[i].name, axis->values[count].name))
            return true;
    }
    return false;
}

/* Read an axis into @p out, which owns what is read, also after an error. @return the first
 * mistake; all are logged. */
static sc_status read_axis(const sc_ctx *ctx, const sc_yaml *node, sc_study_axis *out)
{
    sc_status status = SC_OK;

    if (node->kind == SC_YAML_SCALAR)
        return sc_wrong_type(ctx, node,
                             "a list of values, such as [none, leap], or a map of names, each with "
                             "a map of settings");
    if (node->kind == SC_YAML_LIST)
        SC_PASS(check_path(ctx, node, node->key));
    if (node->count == 0)
        return sc_yaml_fail(ctx, node, "%s has no values, expected at least one", node->key);
    if (node->count > VALUES_MAX)
        return sc_yaml_fail(ctx, node, "%s has %zu values, expected at most %d", node->key,
                            node->count, VALUES_MAX);
    SC_PASS(sc_text_copy(ctx, node->key, &out->name));
    SC_PASS(SC_ZALLOC(ctx, node->count, &out->values));
    for (size_t i = 0; i < node->count; i++) {
        sc_status found = read_value(ctx, node, node->items[i], &out->values[i]);

        out->value_count++;
        if (found == SC_OK && is_doubled(out, (int)i))
            found = sc_yaml_fail(ctx, node->items[i], "%s has the value %s twice", node->key,
                                 out->values[i].name);
        if (!sc_goes_on(&status, found))
            break;
    }
    return status;
}

/* The axes of the whole sc_study @p value. */
static sc_status read_axes(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    sc_study *study = value;
    double cells = 1;
    sc_status status = SC_OK;

    if (node->kind != SC_YAML_MAP)
        return sc_wrong_type(ctx, node, key->type->expected);
    if (node->count > SC_STUDY_AXES_MAX)
        return sc_yaml_fail(ctx, node, "sweep has %zu axes, expected at most %d", node->count,
                            SC_STUDY_AXES_MAX);
    SC_PASS(SC_ZALLOC(ctx, node->count, &study->axes));
    for (size_t i = 0; i < node->count; i++) {
        const sc_status found = read_axis(ctx, node->items[i], &study->axes[i]);

        study->axis_count++;
        cells *= study->axes[i].value_count;
        if (!sc_goes_on(&status, found))
            break;
    }
    if (status == SC_OK && cells > SC_STUDY_CELLS_MAX)
        return sc_yaml_fail(ctx, node, "sweep has %.0f cells, expected at most %d", cells,
                            SC_STUDY_CELLS_MAX);
    return status;
}

static sc_status write_axes(const sc_ctx *ctx, const sc_key *key, const void *value, int indent,
                            unsigned parts, sc_text *text)
{
    const sc_study *study = value;

    SC_PASS(sc_text_add(ctx, text, study->axis_count ? " " : " {}"));
    for (int i = 0; i < study->axis_count; i++) {
        const sc_study_axis *axis = &study->axes[i];

        SC_PASS(sc_text_add(ctx, text, "\n%*s", indent + 2, ""));
        SC_PASS(sc_write_quoted(ctx, axis->name, text));
        SC_PASS(sc_text_add(ctx, text, ":"));
        for (int j = 0; j < axis->value_count; j++) {
            SC_PASS(sc_text_add(ctx, text, "\n%*s", indent + 4, ""));
            SC_PASS(sc_write_quoted(ctx, axis->values[j].name, text));
            SC_PASS(sc_text_add(ctx, text, ": "));
            SC_PASS(add_settings(ctx, &axis->values[j].settings, text));
        }
    }
    return sc_text_add(ctx, text, "\n");
}

static const sc_value_type type_axes = {
    .name = "map of axes",
    .expected = "a map of axes, such as {render.skip: [none, leap], ranks: [1, 2]}",
    .read = read_axes,
    .write_lines = write_axes,
    .schema = "{type: object}",
};

/* ---- the table ---- */

static const sc_choice subjects[] = {{"frames", SC_STUDY_FRAMES}, {"job", SC_STUDY_JOB}, {NULL, 0}};
static const sc_choice metrics[] = {{"cpu", SC_STUDY_CPU}, {"wall", SC_STUDY_WALL}, {NULL, 0}};

#define STUDY(member) offsetof(sc_study, member)

const sc_key sc_study_keys[] = {
    {"title", &sc_type_text, STUDY(title), "\"\"", .help = "title of the study, for its report",
     .bytes = sizeof(((sc_study *)0)->title)},
    {"job", &sc_type_text, STUDY(job), NULL,
     .help = "the job file that is measured; relative to the study file", .bytes = SC_PATH_BYTES,
     .without = "only what set says"},
    {"set", &type_settings, STUDY(set), NULL,
     .help = "keys of the job, and ranks, threads and placement, for all cells",
     .without = "nothing"},
    {"sweep", &type_axes, 0, NULL,
     .help = "the axes: a key of the job, ranks, threads or placement with a list of values; or a "
             "name with a map of names, each with a map of settings",
     .without = "one cell"},
    {"measure", &sc_type_choice, STUDY(measure), "frames",
     .help = "frames: drawing and gathering frames of a volume that is prepared already; job: "
             "everything from reading to the finished video",
     .choices = subjects},
    {"frames", &sc_type_text, STUDY(frames), "\"\"",
     .help =
         "which frames of the animation are drawn, such as 0-179:45; empty: four, evenly spread",
     .bytes = sizeof(((sc_study *)0)->frames)},
    {"metric", &sc_type_choice, STUDY(metric), "cpu",
     .help = "which time has to be exact: CPU seconds of all ranks, or wall time",
     .choices = metrics},
    {"precision", &sc_type_share, STUDY(precision), "2%",
     .help = "a cell is exact enough when half the 95 % confidence interval of its median is at "
             "most this share of the median"},
    {"least", &sc_type_int, STUDY(least), "6",
     .help = "measurements of each cell at least; fewer than 6 give no confidence interval",
     .low = 1, .high = 1000},
    {"most", &sc_type_int, STUDY(most), "30", .help = "measurements of each cell at most", .low = 1,
     .high = 1000},
    {"budget", &sc_type_duration, STUDY(budget_s), "10 min", .help = "time for the whole study"},
    {"seed", &sc_type_int, STUDY(seed), "1",
     .help = "of the random order in which cells are measured", .low = 0, .high = 2147483647},
    {0}};

/* ---- loading ---- */

/* Make the path of the job file relative to the working directory. */
static sc_status resolve_job(const sc_ctx *ctx, const sc_yaml *root, sc_study *study)
{
    const sc_yaml *node = sc_key_node(root, "job");
    SC_OWN(sc_free_at) char *path = NULL;

    if (!node || node->kind != SC_YAML_SCALAR || !study->job[0])
        return SC_OK;
    sc_note_where(node, study->job_where, sizeof study->job_where);
    SC_PASS(path_of(ctx, node, study->job, &path));
    if (strlen(path) >= sizeof study->job)
        return sc_yaml_fail(ctx, node, "the path has %zu characters, expected less than %d",
                            strlen(path), SC_PATH_BYTES);
    strcpy(study->job, path);
    return SC_OK;
}

/* After mistakes, remove the axes without values from a study, so that it has cells. */
static void drop_empty_axes(sc_study *study)
{
    int kept = 0;

    for (int i = 0; i < study->axis_count; i++) {
        if (study->axes[i].value_count)
            study->axes[kept++] = study->axes[i];
        else
            clear_axis(&study->axes[i]);
    }
    study->axis_count = kept;
}

sc_status sc_study_load(const sc_ctx *ctx, const char *path, sc_study *out)
{
    SC_OWN(sc_free_at) char *text = NULL;
    SC_OWN(sc_yaml_free_at) sc_yaml *root = NULL;
    SC_OWN(sc_study_clear) sc_study study = {.set.placement = -1};
    size_t bytes;
    sc_status status, mistakes = SC_OK;

    SC_PASS(sc_keys_set_defaults(ctx, sc_study_keys, &study));
    SC_PASS(sc_file_read(ctx, path, STUDY_MAX_BYTES, &text, &bytes));
    SC_PASS(sc_yaml_parse(ctx, path, text, bytes, &root));
    if (root->kind != SC_YAML_MAP)
        return sc_wrong_type(ctx, root, "a map of keys such as job and sweep");
    if (root->count == 0)
        return sc_fail(ctx, SC_ERR_DATA,
                       "%s: is empty; expected keys of a study, such as job and sweep", path);
    status = root->key_left_out ? SC_ERR_DATA : SC_OK;
    if (sc_goes_on(&status, sc_keys_read(ctx, sc_study_keys, root, &study)))
        (void)sc_goes_on(&status, resolve_job(ctx, root, &study));
    if (status == SC_OK && study.most < study.least)
        status = sc_yaml_fail(ctx, root, "most is %d and least is %d, expected most to be no less",
                              study.most, study.least);
    if (!sc_goes_on(&mistakes, status))
        return status;
    drop_empty_axes(&study);
    SC_HAND_OVER(study, out);
    return status;
}

void sc_study_clear(sc_study *study)
{
    for (int i = 0; i < study->axis_count; i++)
        clear_axis(&study->axes[i]);
    sc_free(study->axes);
    clear_settings(&study->set);
    *study = (sc_study){0};
}

sc_status sc_study_write(const sc_ctx *ctx, const sc_study *study, sc_text *text)
{
    return sc_keys_write(ctx, sc_study_keys, study, 0, false, text);
}

/* ---- cells ---- */

int sc_study_cells(const sc_study *study)
{
    int cells = 1;

    for (int i = 0; i < study->axis_count; i++)
        cells *= study->axes[i].value_count;
    return cells;
}

const sc_study_value *sc_study_value_of(const sc_study *study, int cell, int axis)
{
    for (int i = study->axis_count - 1; i > axis; i--)
        cell /= study->axes[i].value_count;
    return &study->axes[axis].values[cell % study->axes[axis].value_count];
}

/* Append the settings @p from to those of a cell, which has room for them. */
static void append(const sc_study_settings *from, sc_study_settings *to)
{
    for (size_t i = 0; i < from->count; i++)
        to->items[to->count++] = from->items[i];
    to->ranks = from->ranks ? from->ranks : to->ranks;
    to->threads = from->threads ? from->threads : to->threads;
    to->placement = from->placement >= 0 ? from->placement : to->placement;
}

sc_status sc_study_cell(const sc_ctx *ctx, const sc_study *study, int cell, sc_study_settings *out)
{
    sc_study_settings all = {.placement = SC_COMM_PACKED};
    size_t count = study->set.count;

    for (int i = 0; i < study->axis_count; i++)
        count += sc_study_value_of(study, cell, i)->settings.count;
    SC_PASS(SC_ZALLOC(ctx, count + 1, &all.items));
    append(&study->set, &all);
    for (int i = 0; i < study->axis_count; i++)
        append(&sc_study_value_of(study, cell, i)->settings, &all);
    *out = all;
    return SC_OK;
}
