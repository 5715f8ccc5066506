/* SPDX-License-Identifier: BSD-3-Clause */
/* The key frames of a job as a table. They are looked for in what the job is written as, so that it
 * lists all that have any, whatever they are of. */
#include "segcast/job.h"
#include "yaml/yaml_tree.h"

#include <math.h>
#include <stdlib.h>

enum {
    PATH_BYTES = 256,
    WIDTH = 40 /* of the column of parameters */
};

/* The table while it is made. */
typedef struct lister {
    const sc_ctx *ctx;
    sc_text *out;
    int frames;     /* of the animation */
    int rows, most; /* that there are so far; that are shown */
    char path[PATH_BYTES];
} lister;

/* @return whether a node is a track: a written one begins with a time, as a share. */
static bool is_track(const sc_yaml *node)
{
    char *end;

    return node->kind == SC_YAML_MAP && node->count > 0 &&
           (strtod(node->items[0]->key, &end), end != node->items[0]->key && !strcmp(end, "%"));
}

/* Append a value: a number, a text, or a list of such. */
static sc_status add_value(const lister *l, const sc_yaml *node)
{
    char *end;

    if (node->kind == SC_YAML_SCALAR) {
        const double number = strtod(node->text, &end);

        if (end != node->text && !*end)
            return sc_text_add(l->ctx, l->out, "%.6g", number);
        return strchr(node->text, '\n') ? sc_write_quoted(l->ctx, node->text, l->out)
                                        : sc_text_add(l->ctx, l->out, "%s", node->text);
    }
    SC_PASS(sc_text_add(l->ctx, l->out, "["));
    for (size_t i = 0; i < node->count; i++) {
        SC_PASS(sc_text_add(l->ctx, l->out, "%s", i ? ", " : ""));
        SC_PASS(add_value(l, node->items[i]));
    }
    return sc_text_add(l->ctx, l->out, "]");
}

/* Append the rows of one track, as far as they are shown. */
static sc_status add_track(lister *l, const sc_yaml *track)
{
    for (size_t i = 0; i < track->count; i++) {
        const sc_yaml *key = track->items[i], *ease = sc_yaml_member(key, "ease");
        const double frame = strtod(key->key, NULL) / 100 * (l->frames - 1);

        if (l->rows++ >= l->most)
            continue;
        /* to a thousandth: times were rounded down when they became shares */
        SC_PASS(sc_text_add(l->ctx, l->out, "  %-*s %8.8g  ", WIDTH, i ? "" : l->path,
                            floor(frame * 1000 + 0.5) / 1000));
        SC_PASS(add_value(l, ease ? sc_yaml_member(key, "value") : key));
        if (ease && i > 0) {
            SC_PASS(sc_text_add(l->ctx, l->out, "  "));
            SC_PASS(add_value(l, ease));
        }
        SC_PASS(sc_text_add(l->ctx, l->out, "\n"));
    }
    return SC_OK;
}

/* Append the rows of all tracks in and below a node, which has the path l->path. */
static sc_status walk(lister *l, const sc_yaml *node)
{
    const size_t length = strlen(l->path);
    char *end = l->path + length;
    const size_t room = sizeof l->path - length;

    if (is_track(node))
        return add_track(l, node);
    for (size_t i = 0; i < node->count; i++) {
        const sc_yaml *item = node->items[i];
        const char *dot = length ? "." : "";

        if (!item->key)
            snprintf(end, room, "%s%zu", dot, i);
        else if (strpbrk(item->key, ". "))
            snprintf(end, room, "%s\"%s\"", dot, item->key);
        else
            snprintf(end, room, "%s%s", dot, item->key);
        SC_PASS(walk(l, item));
    }
    *end = '\0';
    return SC_OK;
}

/* Write a job and parse what was written. */
static sc_status parse_written(const sc_ctx *ctx, const sc_job *job, sc_yaml **out)
{
    SC_OWN(sc_text_clear) sc_text text = {0};

    SC_PASS(sc_job_write(ctx, job, true, &text));
    return sc_yaml_parse(ctx, "job", text.data, text.length_bytes, out);
}

/* Add copies of what @p from has and the map @p to has not, in it and, @p levels deep, in its maps.
 */
static sc_status add_missing(const sc_ctx *ctx, sc_yaml *to, const sc_yaml *from, int levels)
{
    for (size_t i = 0; i < from->count; i++) {
        const sc_yaml *item = from->items[i];
        sc_yaml *there = sc_yaml_member(to, item->key), *copy;

        if (there) {
            SC_PASS(levels > 0 ? add_missing(ctx, there, item, levels - 1) : SC_OK);
            continue;
        }
        SC_PASS(sc_yaml_copy(ctx, item, &copy));
        SC_PASS(sc_yaml_append(ctx, to, copy));
    }
    return SC_OK;
}

/* Append the rows of a job without shots, or of one shot with all that it has of its film. */
static sc_status list_one(lister *l, const sc_job *job)
{
    sc_job whole = *job, film = *job;
    SC_OWN(sc_yaml_free_at) sc_yaml *root = NULL, *film_root = NULL;

    whole.film.shot_count = film.film.shot_count = 0;
    film.tissues.rule_count = job->tissues.film_rules;
    film.tissues.film_rules = 0;
    l->frames = job->animation.frames;
    SC_PASS(parse_written(l->ctx, &whole, &root));
    if (film.tissues
            .rule_count) { /* the shot may have rules of the same tissues, which go before */
        SC_PASS(parse_written(l->ctx, &film, &film_root));
        SC_PASS(add_missing(l->ctx, sc_yaml_member(root, "tissues"),
                            sc_yaml_member(film_root, "tissues"), 1));
    }
    return walk(l, root);
}

/* Append the rows of a shot, below its number and name, if it has any. */
static sc_status list_shot(lister *l, const sc_shot *shot, size_t i)
{
    const char *name = shot->name;
    const size_t before = l->out->length_bytes;
    size_t heading;

    SC_PASS(sc_text_add(l->ctx, l->out, " shot %zu%s%s%s\n", i + 1, name[0] ? " (" : "", name,
                        name[0] ? ")" : ""));
    heading = l->out->length_bytes;
    for (size_t k = before; k + 1 < heading; k++) { /* a name of two lines is told in one */
        if (l->out->data[k] == '\n')
            l->out->data[k] = ' ';
    }
    SC_PASS(list_one(l, &shot->job));
    if (l->out->length_bytes == heading) { /* it has none, or none that is shown */
        l->out->length_bytes = before;
        l->out->data[before] = '\0';
    }
    return SC_OK;
}

sc_status sc_job_list_key_frames(const sc_ctx *ctx, const sc_job *job, int most, sc_text *out)
{
    lister l = {.ctx = ctx, .out = out, .most = most};

    if (!job->film.shot_count)
        SC_PASS(list_one(&l, job));
    for (size_t i = 0; i < job->film.shot_count; i++)
        SC_PASS(list_shot(&l, &job->film.shots[i], i));
    if (l.rows > most)
        return sc_text_add(ctx, out, "  and %d more\n", l.rows - most);
    return SC_OK;
}
