/* SPDX-License-Identifier: BSD-3-Clause */
/* segcast init: write a job to begin with, with every tissue of a volume. */
#include "commands.h"
#include "init/init.h"
#include "segcast/store.h"

#include <stdlib.h>

/* ---- names of files ---- */

/* Remove from the name of a series, which may be a pattern, what stands for the number, and what is
 * before it: "heart-*" becomes "heart". */
static void strip_pattern(char *name)
{
    char *wild = strpbrk(name, "*?");

    while (wild > name && strchr("*?-_. ", wild[-1]))
        wild--;
    if (wild)
        *wild = '\0';
}

/* Make of @p name one that the job file, its directory and its video can have: one that is not
 * hidden, without what a shell or segcast reads as something else, without control characters, and
 * short enough for the endings that are added. */
static void make_plain(sc_text *name)
{
    enum { MOST_BYTES = SC_VIDEO_NAME_MAX - 5 }; /* no ending has more */
    const char *from = name->data + strspn(name->data, ".~- ");
    size_t used = 0;

    while (*from) {
        const size_t whole = sc_utf8_bytes(from), bytes = whole ? whole : 1;
        const bool is_odd = *from == '$' || sc_is_control(sc_utf8_code(from, bytes));

        if (used + bytes > MOST_BYTES)
            break;
        memmove(name->data + used, is_odd ? "_" : from, is_odd ? 1 : bytes);
        used += is_odd ? 1 : bytes;
        from += bytes;
    }
    name->data[used] = '\0';
    name->length_bytes = used;
}

/* Make the name of the volume's file without folder and endings, as make_plain leaves it; "volume"
 * if nothing is left, "phantom" for the phantom. Caller owns *out: sc_free. */
static sc_status make_stem(const sc_ctx *ctx, const char *volume, char **out)
{
    size_t end = strlen(volume), begin;
    SC_OWN(sc_text_clear) sc_text text = {0}, name = {0};

    while (end > 1 && volume[end - 1] == '/') /* of a directory */
        end--;
    for (begin = end; begin && volume[begin - 1] != '/';)
        begin--;
    SC_PASS(sc_text_add(ctx, &name, "%.*s", (int)(end - begin), volume + begin));

    if (sc_job_is_phantom(volume))
        SC_PASS(sc_text_add(ctx, &text, "phantom"));
    else
        SC_PASS(sc_text_add(ctx, &text, "%.*s",
                            (int)sc_volume_stem_bytes(name.data, name.length_bytes), name.data));
    strip_pattern(text.data);
    make_plain(&text);
    if (!text.length_bytes)
        SC_PASS(sc_text_add(ctx, &text, "volume"));
    SC_HAND_OVER(text.data, out);
    return SC_OK;
}

/* Append a path in quotes. @return SC_ERR_USAGE if no job can hold it. */
static sc_status add_quoted_path(const sc_ctx *ctx, const char *path, sc_text *out)
{
    for (const char *c = path; *c; c += sc_utf8_bytes(c)) {
        if (!sc_utf8_bytes(c))
            return sc_fail(ctx, SC_ERR_USAGE,
                           "%s: byte %zu of this path is not UTF-8, so that no job file can hold "
                           "it; rename the file or its directory (`segcast orbit` needs no job)",
                           path, (size_t)(c - path) + 1);
    }
    return sc_write_quoted(ctx, path, out);
}

/* Append the line of a key that holds a path: as the user has given it, if the job is written to
 * the working directory, to which it is relative then; else absolute. */
static sc_status add_path(const sc_ctx *ctx, const char *key, const char *path, bool is_here,
                          sc_text *out)
{
    SC_OWN(sc_free_at)
    char *absolute = is_here || sc_job_is_phantom(path) ? NULL : sc_volume_real_path(path);

    SC_PASS(sc_text_add(ctx, out, "%s: ", key));
    SC_PASS(add_quoted_path(ctx, absolute ? absolute : path, out));
    return sc_text_add(ctx, out, "\n");
}

/* ---- tissues ---- */

/* Append how a tissue looks at first: what the label table says; else opaque, and covers nearly
 * transparent, or hidden if another cover lies around them, as is what is left over. */
static sc_status add_look(const sc_ctx *ctx, const sc_label *label, int layer, sc_text *out)
{
    if (label->hidden)
        return sc_text_add(ctx, out, "visible: false");
    if (label->opacity >= 0)
        return sc_text_add(ctx, out, "opacity: %.3g", label->opacity);
    if (layer > 1)
        return sc_text_add(ctx, out, "visible: false");
    return sc_text_add(ctx, out, "opacity: %s", layer == 1 ? "0.12" : "1");
}

/* Append the line of a tissue: its look, and as a comment its colour, which follows from table and
 * appearance, its number, volume and thickness. */
static sc_status add_tissue(const sc_ctx *ctx, const sc_prepared *v, const sc_place *place,
                            int width, sc_text *out)
{
    const sc_label *label = &v->labels[place->id];
    const sc_label_stats *s = &v->stats[place->id];
    const double ml = (double)s->voxels * fabs(sc_affine_determinant(&v->to_ras_mm)) / 1000;
    const size_t begin = out->length_bytes;
    const bool by_name = sc_label_name_is_clear(v->labels, v->label_count, place->id);
    int used;

    SC_PASS(sc_text_add(ctx, out, "  "));
    if (by_name)
        SC_PASS(sc_write_quoted(ctx, label->name, out));
    else
        SC_PASS(sc_text_add(ctx, out, "%lld", (long long)label->value));
    used = (int)(out->length_bytes - begin);
    SC_PASS(sc_text_add(ctx, out, ":%*s{", used < width + 4 ? width + 4 - used + 1 : 1, ""));
    SC_PASS(add_look(ctx, label, place->layer, out));
    SC_PASS(sc_text_add(ctx, out, "}  # color: \"#%02x%02x%02x\", ", label->rgb[0], label->rgb[1],
                        label->rgb[2]));
    if (!by_name && label->name[0])
        SC_PASS(sc_write_quoted(ctx, label->name, out));
    SC_PASS(sc_text_add(ctx, out, "%slabel %lld, %.3g ml", !by_name && label->name[0] ? ", " : "",
                        (long long)label->value, ml));
    return s->thickness_mm > 0 ? sc_text_add(ctx, out, ", %.3g mm thick\n", s->thickness_mm)
                               : sc_text_add(ctx, out, "\n");
}

/* Append the map of tissues, with a comment before each system. */
static sc_status add_tissues(const sc_ctx *ctx, const sc_prepared *v, const sc_place *places,
                             int count, sc_text *out)
{
    enum { WIDTH_MAX = 40 };
    int width = 0, systems = 0;

    for (int i = 0; i < count; i++) {
        const int length = (int)strlen(v->labels[places[i].id].name);

        width = length > width && length <= WIDTH_MAX ? length : width;
        systems += i == 0 || places[i].system != places[i - 1].system;
    }
    SC_PASS(sc_text_add(ctx, out,
                        "\n# All tissues: opacity is a number from 0 to 1, or auto (by thickness); "
                        "visible: false hides one.\n"
                        "# Behind # stands the colour by table and appearance; color between the "
                        "braces gives another.\ntissues:%s\n",
                        count ? "" : " {}"));
    for (int i = 0; i < count; i++) {
        if (systems > 1 && (i == 0 || places[i].system != places[i - 1].system))
            SC_PASS(sc_text_add(ctx, out, "  # %s\n", sc_system_title(places[i].system)));
        SC_PASS(add_tissue(ctx, v, &places[i], width, out));
    }
    return SC_OK;
}

/* ---- the job ---- */

/* @return the value of the last option that sets the key @p path, or NULL. */
static const char *option_value(const sc_app *app, const char *path)
{
    const char *value = NULL;

    for (size_t i = 0; i < app->options.settings.count; i++) {
        if (!strcmp(app->options.settings.all[i].path, path))
            value = app->options.settings.all[i].value;
    }
    return value;
}

/* Append the line "  key: NAME", whose name is @p stem followed by @p ending. */
static sc_status add_name(const sc_ctx *ctx, const char *key, const char *stem, const char *ending,
                          sc_text *out)
{
    SC_OWN(sc_text_clear) sc_text name = {0};

    SC_PASS(sc_text_add(ctx, &name, "%s%s", stem, ending));
    SC_PASS(sc_text_add(ctx, out, "  %s: ", key));
    SC_PASS(sc_write_quoted(ctx, name.data, out));
    return sc_text_add(ctx, out, "\n");
}

/* Append the comments at the begin, with what to do next. @param path where the job is written. */
static sc_status add_comments(const sc_ctx *ctx, const char *path, sc_text *out)
{
    char shown[256]; /* in a comment, where a newline of the name would end it */
    const size_t bytes = sc_printable(path, shown, sizeof shown);
    const char *name = bytes < sizeof shown ? shown : "JOB.yaml";

    SC_PASS(sc_text_add(ctx, out,
                        "# A job to begin with, made by `segcast init`: change what you like.\n"));
    if (strcmp(path, "-"))
        SC_PASS(sc_text_add(ctx, out,
                            "#   segcast check %s                 tells all mistakes in it\n"
                            "#   segcast still %s -o picture.png  draws its first frame\n"
                            "#   segcast render %s                makes the video\n",
                            name, name, name));
    return sc_text_add(ctx, out, "# All keys: `segcast help keys`, or docs/job.md.\n\n");
}

/* @return what stands before the path of the volume: with `header` it is a map. */
static const char *volume_key(const sc_app *app)
{
    return option_value(app, "volume.header") ? "volume:\n  path" : "volume";
}

/* Append the line that the user says of the file, if there is one. */
static sc_status add_header(const sc_app *app, sc_text *out)
{
    const char *line = option_value(app, "volume.header");

    if (!line)
        return SC_OK;
    SC_PASS(sc_text_add(app->ctx, out, "  header: "));
    SC_PASS(sc_write_quoted(app->ctx, line, out));
    return sc_text_add(app->ctx, out, "\n");
}

/* Append the lines of a series of volumes: as the pattern @p pattern, if the job is written to the
 * working directory; else as a list of files. */
static sc_status add_series(const sc_app *app, const sc_job *job, const char *pattern, bool is_here,
                            sc_text *out)
{
    const sc_ctx *ctx = app->ctx;

    SC_PASS(sc_text_add(ctx, out, "%s: %s", volume_key(app), is_here ? "" : "["));
    if (is_here)
        SC_PASS(add_quoted_path(ctx, pattern, out));
    for (size_t i = 0; i < job->volume.phase_count && !is_here; i++) {
        SC_PASS(sc_text_add(ctx, out, "%s", i ? ", " : ""));
        SC_PASS(add_quoted_path(ctx, job->volume.phases[i].path, out));
    }
    SC_PASS(sc_text_add(ctx, out, "%s\n", is_here ? "" : "]"));
    SC_PASS(add_header(app, out));
    return sc_text_add(
        ctx, out, "cine: {bpm: %g}  # beats per minute: the %zu volumes are the phases of one\n",
        job->cine.cine.bpm, job->volume.phase_count);
}

/* Append everything before the tissues. @param path where the job is written. */
static sc_status add_head(const sc_app *app, const sc_job *job, const char *path, const char *stem,
                          sc_text *out)
{
    const sc_ctx *ctx = app->ctx;
    const bool is_here = !strchr(path, '/');
    const char *labels = option_value(app, "labels"), *format = option_value(app, "labels_format");
    const char *overlap = option_value(app, "overlap");
    const char *appearance = option_value(app, "appearance"), *look = option_value(app, "look");

    SC_PASS(add_comments(ctx, path, out));
    if (job->volume.phase_count)
        SC_PASS(add_series(app, job, app->options.input, is_here, out));
    else
        SC_PASS(add_path(ctx, volume_key(app), app->options.input, is_here, out));
    if (!job->volume.phase_count)
        SC_PASS(add_header(app, out));
    if (labels)
        SC_PASS(add_path(ctx, "labels", labels, is_here, out));
    if (format)
        SC_PASS(sc_text_add(ctx, out, "labels_format: %s\n", format));
    if (overlap)
        SC_PASS(sc_text_add(ctx, out, "overlap: %s\n", overlap));
    if (appearance)
        SC_PASS(sc_text_add(ctx, out, "appearance: %s\n", appearance));
    SC_PASS(sc_text_add(ctx, out, "look: %s  # or plain, cinematic, atlas, xray\n",
                        look ? look : "studio"));
    SC_PASS(sc_text_add(ctx, out, "\noutput:\n"));
    SC_PASS(add_name(ctx, "directory", stem, "-out", out));
    SC_PASS(add_name(ctx, "video", stem, ".mp4", out));
    return sc_text_add(ctx, out,
                       "  size: 1080p  # or 720p, 4k, square, vertical, [W, H]\n"
                       "  fps: 30\n");
}

/* Append everything after the tissues. */
static sc_status add_animation(const sc_ctx *ctx, sc_text *out)
{
    return sc_text_add(
        ctx, out,
        "\nanimation:\n"
        "  frames: 6s\n"
        "  camera:\n"
        "    orbit: {axis: superior, turns: 1, elevation: 15}\n"
        "    # zoom: {0%%: 1, 100%%: 1.2}\n"
        "  # A plane that moves from the front to the middle; what lies before it is cut away:\n"
        "  # clip:\n"
        "  #   - {normal: posterior, at: {20%%: 0%%, 80%%: 50%%}, except: []}  # what stays "
        "whole\n");
}

/* Append all tissues and the animation to a job for a volume of which all has been measured. */
static sc_status add_body(const sc_app *app, const sc_prepared *v, sc_text *out)
{
    SC_OWN(sc_free_at) sc_place *places = NULL;
    SC_OWN(sc_free_at) bool *hidden = NULL;
    SC_OWN(sc_free_at) int *layers = NULL;
    int count = 0;

    SC_PASS(SC_ZALLOC(app->ctx, (size_t)v->label_count, &hidden));
    SC_PASS(SC_ALLOC(app->ctx, (size_t)v->label_count, &layers));
    SC_PASS(sc_hidden_labels(app->ctx, v->labels, v->label_count, NULL, 0, hidden));
    SC_PASS(sc_name_covers(app->ctx, v, hidden, layers));
    SC_PASS(sc_places_find(app->ctx, v, layers, &places, &count));
    SC_PASS(add_tissues(app->ctx, v, places, count, out));
    return add_animation(app->ctx, out);
}

sc_status sc_init_write(sc_app *app, bool measures, sc_text *path, sc_text *out)
{
    SC_OWN(sc_session_clear) sc_session session = {0};
    SC_OWN(sc_input_clear) sc_input input = {.measure = true};
    SC_OWN(sc_volume_clear) sc_volume voxels = {0};
    SC_OWN(sc_free_at) char *stem = NULL;

    SC_PASS(make_stem(app->ctx, app->options.input, &stem));
    if (app->options.output)
        SC_PASS(sc_text_add(app->ctx, path, "%s", app->options.output));
    else
        SC_PASS(sc_text_add(app->ctx, path, "%s.yaml", stem));
    SC_PASS(sc_options_set_text(app->ctx, &app->options, "volume", app->options.input));
    SC_PASS(sc_expect_series(app));
    SC_PASS(sc_session_job(app, NULL, &session));
    if (strcmp(path->data, "-"))
        SC_PASS(sc_check_output(app, &session.job, path->data, false));
    SC_PASS(add_head(app, &session.job, path->data, stem, out));
    /* Of a series, the first phase tells enough. */
    SC_PASS(measures ? sc_input_load(app, &session.job, &session.times, &input)
                     : sc_input_look(app, &session.job, &input, &voxels));
    return add_body(app, &input.volume, out);
}

sc_status sc_cmd_init(sc_app *app)
{
    SC_OWN(sc_text_clear) sc_text text = {0}, path = {0};

    SC_PASS(sc_init_write(app, true, &path, &text));
    sc_display_end_stage(app);
    return sc_write_text(app, &text, path.data);
}
