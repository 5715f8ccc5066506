/* SPDX-License-Identifier: BSD-3-Clause */
/* What a job wants written onto its pictures. */
#include "key.h"
#include "segcast/job.h"

#include <math.h>

/* ---- the font ---- */

/* char[64] of sc_overlays.font, and its line. @p value is the whole sc_job. */
static sc_status read_font(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    sc_overlays *overlays = &((sc_job *)value)->overlays;

    if (node->kind != SC_YAML_SCALAR || !node->text[0] ||
        strlen(node->text) >= sizeof overlays->font)
        return sc_wrong_type(ctx, node, key->type->expected);
    strcpy(overlays->font, node->text);
    if (node->origin) /* not the default */
        sc_note_where(node, overlays->font_where, sizeof overlays->font_where);
    return SC_OK;
}

static sc_status write_font(const sc_ctx *ctx, const sc_key *key, const void *value, sc_text *text)
{
    return sc_write_quoted(ctx, ((const sc_job *)value)->overlays.font, text);
}

static const sc_value_type type_font = {
    .name = "text",
    .expected = "the name of a family of fonts, such as DejaVu Sans, of at most 63 bytes",
    .read = read_font,
    .write = write_font,
    .schema = "{type: string}",
};

/* ---- captions ---- */

/* Log why a character cannot be drawn. @param at which it is, counted from 1. */
static sc_status refuse_character(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                                  unsigned code, size_t at, const char *why)
{
    return sc_yaml_fail(ctx, node, "%s has, as its character %zu, U+%04X, which %s", key->name, at,
                        code, why);
}

/* char[SC_CAPTION_BYTES]: a text whose characters can be drawn, lines separated by \n. */
static sc_status read_caption_text(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                                   void *value)
{
    size_t lines = 1, at = 0, characters = 0;

    if (node->kind != SC_YAML_SCALAR || !node->text[strspn(node->text, " \n")])
        return sc_wrong_type(ctx, node, key->type->expected);
    if (strlen(node->text) >= SC_CAPTION_BYTES)
        return sc_yaml_fail(ctx, node, "%s has %zu bytes, expected at most %d", key->name,
                            strlen(node->text), SC_CAPTION_BYTES - 1);
    for (size_t bytes; node->text[at]; at += bytes ? bytes : 1) {
        unsigned code;
        const char *why;

        bytes = sc_utf8_bytes(node->text + at);
        code = sc_utf8_code(node->text + at, bytes ? bytes : 1);
        characters++;
        lines += code == '\n' && node->text[at + 1];
        why = bytes ? sc_font_refuses(code) : "is no character of UTF-8";
        if (why && code != '\n')
            return refuse_character(ctx, key, node, code, characters, why);
    }
    if (lines > SC_CAPTION_LINES_MAX)
        return sc_yaml_fail(ctx, node, "%s has %zu lines, expected at most %d", key->name, lines,
                            SC_CAPTION_LINES_MAX);
    strcpy(value, node->text);
    return SC_OK;
}

static sc_status write_caption_text(const sc_ctx *ctx, const sc_key *key, const void *value,
                                    sc_text *text)
{
    return sc_write_quoted(ctx, value, text);
}

const sc_value_type sc_type_caption_text = {
    .name = "text",
    .expected = "a text that is not empty",
    .read = read_caption_text,
    .write = write_caption_text,
    .schema = "{type: string}",
};

#define PLACES(name)                                                                               \
    {"top-left", SC_PLACE_TOP_LEFT}, {"top", SC_PLACE_TOP}, {"top-right", SC_PLACE_TOP_RIGHT},     \
        {"bottom-left", SC_PLACE_BOTTOM_LEFT}, {"bottom", SC_PLACE_BOTTOM},                        \
        {"bottom-right", SC_PLACE_BOTTOM_RIGHT},                                                   \
    {                                                                                              \
        NULL, 0                                                                                    \
    }

static const sc_choice caption_places[] = {PLACES()};
static const sc_choice places[] = {{"none", SC_PLACE_NONE}, PLACES()};

/* ---- tissues of an overlay ---- */

/* @return the overlay whose tissues a row lists. */
static int use_of(const sc_key *key)
{
    return strcmp(key->name, "names") == 0 ? SC_USE_NAMES : SC_USE_LEGEND;
}

/* Read "none", "all", a tissue or a list of tissues. @p value is the whole sc_job. @return the
 * first mistake; all are logged. */
static sc_status read_overlay_tissues(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                                      void *value)
{
    const char *word = node->kind == SC_YAML_SCALAR ? node->text : "";
    const bool may_be_none = use_of(key) == SC_USE_NAMES;
    sc_job *job = value;

    if (node->kind == SC_YAML_MAP || (!sc_yaml_length(node) && !may_be_none))
        return sc_wrong_type(ctx, node, key->type->expected);
    if (!strcmp(word, "none"))
        return may_be_none ? SC_OK : sc_wrong_type(ctx, node, key->type->expected);
    SC_PASS(sc_read_tissues(ctx, key, node, use_of(key), &job->overlay_lists.tissues,
                            &job->overlay_lists.tissue_count));
    if (!strcmp(word, "all"))
        strcpy(job->overlay_lists.tissues[job->overlay_lists.tissue_count - 1].pattern, "*");
    return SC_OK;
}

static sc_status write_overlay_tissues(const sc_ctx *ctx, const sc_key *key, const void *value,
                                       sc_text *text)
{
    const sc_job *job = value;

    return sc_write_tissues(ctx, job->overlay_lists.tissues, job->overlay_lists.tissue_count,
                            use_of(key), text);
}

static const sc_value_type type_named_tissues = {
    .name = "none, all or tissues",
    .expected = "none, all, or a list of tissues: names, globs or label numbers",
    .read = read_overlay_tissues,
    .write = write_overlay_tissues,
    .schema = "{anyOf: [" SC_SCHEMA_TISSUE ", {type: array, items: " SC_SCHEMA_TISSUE "}]}",
};

/* ---- what stands at a place ---- */

/* Read the place of @p node, a map with one place and what stands there. @param item set to that,
 * called as the map is. @param place set to an sc_overlay_place. */
static sc_status read_place(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                            sc_yaml *item, int *place)
{
    const sc_key row = {.name = key->name, .choices = caption_places};
    sc_yaml word = *node;

    if (node->count != 1)
        return sc_wrong_type(ctx, node, key->type->expected);
    *item = *node->items[0];
    word.kind = SC_YAML_SCALAR;
    word.text = item->key;
    word.count = 0;
    item->key = node->key;
    return sc_type_choice.read(ctx, &row, &word, place);
}

/* @return the word of a place. */
static const char *place_word(int place)
{
    return caption_places[place - SC_PLACE_TOP_LEFT].word;
}

/* The schema of a map with up to @p most places. @param what the schema of what stands there. */
#define SCHEMA_PLACES(what, most)                                                                  \
    "{type: object, properties: {top-left: " what ", top: " what ", top-right: " what              \
    ", bottom-left: " what ", bottom: " what ", bottom-right: " what                               \
    "}, additionalProperties: false, minProperties: 1, maxProperties: " #most "}"

/* A place, or one with the tissues of the legend. @p value is the whole sc_job. */
static sc_status read_legend(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    sc_job *job = value;
    sc_yaml tissues;

    job->given.legend_tissues = node->kind == SC_YAML_MAP;
    if (!job->given.legend_tissues)
        return sc_type_choice.read(ctx, key, node, &job->overlays.legend);
    SC_PASS(read_place(ctx, key, node, &tissues, &job->overlays.legend));
    return read_overlay_tissues(ctx, key, &tissues, value);
}

static sc_status write_legend(const sc_ctx *ctx, const sc_key *key, const void *value,
                              sc_text *text)
{
    const sc_job *job = value;

    if (!job->given.legend_tissues)
        return sc_type_choice.write(ctx, key, &job->overlays.legend, text);
    SC_PASS(sc_text_add(ctx, text, "{%s: ", place_word(job->overlays.legend)));
    SC_PASS(write_overlay_tissues(ctx, key, value, text));
    return sc_text_add(ctx, text, "}");
}

static const sc_value_type type_legend = {
    .name = "place, or {place: tissues}",
    .expected = "none, a place such as top-left, or {top-left: [aorta, \"*atrium\"]}",
    .read = read_legend,
    .write = write_legend,
    .schema = "{anyOf: [$choice, " SCHEMA_PLACES(SC_SCHEMA_TISSUES, 1) "]}",
};

/* A path, or a place with one. @p value is the whole sc_job. */
static sc_status read_logo(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    sc_overlays *overlays = &((sc_job *)value)->overlays;
    sc_yaml path = *node;

    overlays->logo_place = SC_PLACE_TOP_RIGHT;
    if (node->kind == SC_YAML_MAP)
        SC_PASS(read_place(ctx, key, node, &path, &overlays->logo_place));
    return sc_type_text.read(ctx, key, &path, overlays->logo);
}

static sc_status write_logo(const sc_ctx *ctx, const sc_key *key, const void *value, sc_text *text)
{
    const sc_overlays *overlays = &((const sc_job *)value)->overlays;

    SC_PASS(sc_text_add(ctx, text, "{%s: ", place_word(overlays->logo_place)));
    SC_PASS(sc_type_text.write(ctx, key, overlays->logo, text));
    return sc_text_add(ctx, text, "}");
}

static const sc_value_type type_logo = {
    .name = "text, or {place: text}",
    .expected = "the path of a PNG file, or {bottom-left: logo.png}",
    .read = read_logo,
    .write = write_logo,
    .schema = "{anyOf: [{type: string}, " SCHEMA_PLACES("$text", 1) "]}",
};

/* ---- captions ---- */

/* A text of a sc_caption, which is empty for none, and its line. */
static sc_status read_line(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node, void *value)
{
    sc_caption *caption = value;

    caption->text[0] = '\0';
    sc_note_where(node, caption->where, sizeof caption->where);
    if (node->kind == SC_YAML_SCALAR && !strcmp(node->text, "none"))
        return SC_OK;
    return read_caption_text(ctx, key, node, caption->text);
}

static const sc_value_type type_line = {
    .name = "text",
    .expected = "a text, or none",
    .steps = true,
    .read = read_line,
    .schema = "{type: string}",
};
static const sc_key line_key = {.name = "caption", .type = &type_line};

/* The key frames of the captions at one place. */
typedef struct caption_track {
    int count;
    sc_key_frame frames[SC_CAPTIONS_MAX];
    sc_caption captions[SC_CAPTIONS_MAX];
} caption_track;

/* Append the texts of @p track that stand at @p place to the captions of the job. */
static sc_status add_captions(const sc_ctx *ctx, const caption_track *track, int place, sc_job *job)
{
    const size_t count = (size_t)track->count;

    SC_PASS(SC_RESIZE(ctx, job->overlay_lists.caption_count,
                      job->overlay_lists.caption_count + count, &job->overlay_lists.captions));
    for (size_t i = 0; i < count; i++) {
        sc_caption *caption = &job->overlay_lists.captions[job->overlay_lists.caption_count];

        *caption = track->captions[i];
        caption->place = place;
        caption->begin = i ? track->frames[i].at : 0;
        caption->end = i + 1 < count ? track->frames[i + 1].at : SC_CAPTION_STAYS;
        job->overlay_lists.caption_count += caption->text[0] != 0;
    }
    return SC_OK;
}

/* Read a text that stands at a place, or key frames of such. */
static sc_status read_at_place(const sc_ctx *ctx, const sc_yaml *node, int place, sc_job *job)
{
    SC_OWN(sc_free_at) caption_track *track = NULL;

    SC_PASS(SC_ZALLOC(ctx, 1, &track));
    track->count = 1;
    if (sc_is_track(node))
        SC_PASS(sc_read_key_frames(ctx, &line_key, node,
                                   &(sc_track_room){track->frames, track->captions,
                                                    sizeof *track->captions, &track->count,
                                                    SC_CAPTIONS_MAX}));
    else
        SC_PASS(read_line(ctx, &line_key, node, &track->captions[0]));
    return add_captions(ctx, track, place, job);
}

/* Read a text or key frames of texts, or such for each place. @p value is the whole sc_job. @return
 * the first mistake; all are logged. */
static sc_status read_captions(const sc_ctx *ctx, const sc_key *key, const sc_yaml *node,
                               void *value)
{
    const bool has_places =
        node->kind == SC_YAML_MAP && node->count && !strchr("0123456789.", node->items[0]->key[0]);
    sc_status status = SC_OK;

    if (node->kind == SC_YAML_LIST)
        return sc_wrong_type(ctx, node, key->type->expected);
    if (!has_places)
        return read_at_place(ctx, node, SC_PLACE_BOTTOM, value);
    for (size_t i = 0; i < node->count; i++) {
        sc_yaml one = *node, item;
        int place;
        sc_status found;

        one.items += i;
        one.count = 1;
        found = read_place(ctx, key, &one, &item, &place);
        if (found == SC_OK)
            found = read_at_place(ctx, &item, place, value);
        if (!sc_goes_on(&status, found))
            break;
    }
    return status;
}

/* Write the captions at a place as key frames. @param comma what stands before them. */
static sc_status write_at_place(const sc_ctx *ctx, const sc_job *job, int place, const char *comma,
                                sc_text *text)
{
    const char *between = "{";
    double end = 0;

    SC_PASS(sc_text_add(ctx, text, "%s%s: ", comma, place_word(place)));
    for (size_t i = 0; i < job->overlay_lists.caption_count; i++) {
        const sc_caption *caption = &job->overlay_lists.captions[i];

        if (caption->place != place)
            continue;
        SC_PASS(sc_text_add(ctx, text, "%s", between));
        if (caption->begin > end)
            SC_PASS(sc_write_number(ctx, end, 100, "%: none, ", text));
        SC_PASS(sc_write_number(ctx, caption->begin, 100, "%: ", text));
        SC_PASS(sc_write_quoted(ctx, caption->text, text));
        end = caption->end;
        between = ", ";
    }
    if (end < SC_CAPTION_STAYS) {
        SC_PASS(sc_text_add(ctx, text, ", "));
        SC_PASS(sc_write_number(ctx, end, 100, "%: none", text));
    }
    return sc_text_add(ctx, text, "}");
}

static sc_status write_captions(const sc_ctx *ctx, const sc_key *key, const void *value,
                                sc_text *text)
{
    const sc_job *job = value;
    const char *comma = "{";

    if (!job->overlay_lists.caption_count)
        return sc_text_add(ctx, text, "none");
    for (size_t i = 0; i < job->overlay_lists.caption_count;
         i++) { /* those of a place stand together */
        if (i && job->overlay_lists.captions[i].place == job->overlay_lists.captions[i - 1].place)
            continue;
        SC_PASS(write_at_place(ctx, job, job->overlay_lists.captions[i].place, comma, text));
        comma = ", ";
    }
    return sc_text_add(ctx, text, "}");
}

static const sc_value_type type_captions = {
    .name = "text, key frames, or {place: these}",
    .expected =
        "a text, key frames such as {0s: The heart, 4s: none}, or {top: a text or key frames}",
    .read = read_captions,
    .write = write_captions,
    .of_key_frames = &type_line,
    .schema = "{anyOf: [{type: string}, $track, " SCHEMA_PLACES("{anyOf: [{type: string}, $track]}",
                                                                6) "]}",
};

/* @return whether the caption is shown in a frame, as far as that is known: seconds of a film,
 * below 0, are those of its shots. */
static bool is_ever_shown(const sc_caption *caption, int frames)
{
    const int k = (int)ceil(caption->begin * (frames - 1) - 1e-6);

    return caption->begin < 0 || caption->end < 0 ||
           sc_caption_is_shown(caption, sc_frame_time(k < frames - 1 ? k : frames - 1, frames));
}

sc_status sc_captions_check(const sc_ctx *ctx, const sc_job *job)
{
    sc_status status = SC_OK;

    for (size_t i = 0; i < job->overlay_lists.caption_count; i++) {
        if (!is_ever_shown(&job->overlay_lists.captions[i], job->animation.frames))
            (void)sc_goes_on(&status,
                             sc_fail(ctx, SC_ERR_DATA,
                                     "%s: this caption is shown in no frame: its time "
                                     "falls between two of the %d frames; make it longer",
                                     job->overlay_lists.captions[i].where, job->animation.frames));
    }
    return status;
}

/* ---- rows ---- */

#define OVERLAYS(member) offsetof(sc_job, overlays.member)
_Static_assert(sizeof(((sc_overlays *)0)->logo) == SC_PATH_BYTES, "a path of a job fits");

/* Offsets into sc_job, because captions are an array of it. */
const sc_key sc_overlays_keys[] = {
    {"font", &type_font, 0, "DejaVu Sans",
     .help = "family of the font of all text on pictures, in bold; other fonts stand in for "
             "characters that it lacks"},
    {"text_size", &sc_type_real, OVERLAYS(text_percent), "2.8",
     .help =
         "size of the font, in percent of the height of the picture; captions are a quarter larger",
     .low = 1, .high = 20, .unit = "percent"},
    {"caption", &type_captions, 0, NULL,
     .help = "text that is shown, below, or key frames of texts: {0s: The heart, 4s: none}; or "
             "{top: text or key frames, ...}, for each corner or middle of an edge; \\n in double "
             "quotes begins a new line, and lines that are too long are broken",
     .without = "none", .given = SC_GIVEN(sc_job, given.captions)},
    {"time", &sc_type_choice, OVERLAYS(time), "none",
     .help = "where the time code stands: minutes, seconds and hundredths", .choices = places},
    {"scale_bar", &sc_type_choice, OVERLAYS(scale_bar), "none",
     .help = "where a bar of a round length stands: exact with projection: orthographic, otherwise "
             "at the depth of the middle of what is visible",
     .choices = places},
    {"color_bar", &sc_type_choice, OVERLAYS(color_bar), "none",
     .help = "where the colours of values (color_by) stand, with their title, the least and the "
             "greatest value",
     .choices = places},
    {"orientation", &sc_type_choice, OVERLAYS(orientation), "none",
     .help = "where a cube stands that is turned as the patient is, with letters for right, left, "
             "anterior, posterior, superior and inferior",
     .choices = places},
    {"legend", &type_legend, 0, "none",
     .help = "where the names and colours of the tissues stand, each as opaque as it is shown; of "
             "all, or {top-left: [aorta, \"*atrium\"]}: of these alone",
     .choices = places},
    {"names", &type_named_tissues, 0, NULL,
     .help = "tissues whose names stand beside the picture in space, with lines that lead to them: "
             "none, all, or a list of names, globs or label numbers",
     .without = "none", .given = SC_GIVEN(sc_job, given.names)},
    {"names_size", &sc_type_real, OVERLAYS(names_percent), "2.4",
     .help = "size of the font of these names, in percent of the height of the picture", .low = 1,
     .high = 20, .unit = "percent"},
    {"logo", &type_logo, 0, NULL,
     .help = "a picture in a corner: a PNG file, at the upper right, or {bottom-left: logo.png}",
     .bytes = SC_PATH_BYTES, .without = "none", .scope.outside_identity = true,
     .given = SC_GIVEN(sc_job, given.logo)},
    {"logo_size", &sc_type_real, OVERLAYS(logo_percent), "10",
     .help = "height of the logo, in percent of that of the picture; it is never enlarged",
     .low = 1, .high = 100, .unit = "percent"},
    {0}};
