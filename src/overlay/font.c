/* SPDX-License-Identifier: BSD-3-Clause */
/* Fonts: fontconfig finds their files, cairo reads outlines from them. Nothing of the system's
 * settings for hinting and smoothing is asked for. */
#include "font.h"

#include <cairo-ft.h>
#include <fontconfig/fontconfig.h>

#include <strings.h>

enum {
    FONTS_MAX = 64,             /* that stand in for one another */
    FONTCONFIG_BYTES = 32 << 20 /* more than it needs to read its configuration and caches */
};

struct sc_font {
    FcConfig *config;
    FcFontSet *sorted; /* best first, borrowed by the rest */
    struct {
        const FcCharSet *characters;
        const char *file;
        int index; /* of the font in its file */
        cairo_font_face_t *face;
    } fonts[FONTS_MAX];
    int count;
    bool failed; /* an outline could not be had, for want of memory */
};

/* ---- finding ---- */

/* @return whether @p family stands for whatever font the system prefers. */
static bool is_generic(const char *family)
{
    static const char *const generic[] = {"sans-serif", "sans", "serif", "monospace"};

    for (size_t i = 0; i < SC_COUNT_OF(generic); i++) {
        if (!strcasecmp(family, generic[i]))
            return true;
    }
    return false;
}

/* @return whether the font of a pattern is of @p family, by any of its names. */
static bool is_of_family(const FcPattern *pattern, const char *family)
{
    FcChar8 *name;

    for (int i = 0; FcPatternGetString(pattern, FC_FAMILY, i, &name) == FcResultMatch; i++) {
        if (!strcasecmp((const char *)name, family))
            return true;
    }
    return is_generic(family);
}

/* Log that there is no such family, with the nearest of those that there are, or some of them. */
static sc_status no_such_family(const sc_ctx *ctx, const sc_font *font, const char *family,
                                const char *where)
{
    enum { NAMES_MAX = 1024, SHOWN = 12 };
    const char *names[NAMES_MAX], *nearest;
    FcPattern *any = FcPatternCreate();
    FcObjectSet *wanted = FcObjectSetBuild(FC_FAMILY, (char *)NULL);
    FcFontSet *list = FcFontList(font->config, any, wanted);
    SC_OWN(sc_text_clear) sc_text text = {0};
    size_t count = 0;
    sc_status status = SC_ERR_MEMORY;

    for (int i = 0; list && i < list->nfont && count < NAMES_MAX; i++) {
        FcChar8 *name;

        if (FcPatternGetString(list->fonts[i], FC_FAMILY, 0, &name) == FcResultMatch)
            names[count++] = (const char *)name;
    }
    nearest = sc_nearest_word(family, names, count);
    for (size_t i = 0; !nearest && i < count && i < SHOWN; i++)
        SC_TRY(sc_text_add(ctx, &text, "%s%s", i ? ", " : "", names[i]));
    if (nearest)
        status = sc_fail(ctx, SC_ERR_DATA, "%s%sthere is no font \"%s\" here; did you mean \"%s\"?",
                         where, where[0] ? ": " : "", family, nearest);
    else
        status = sc_fail(ctx, SC_ERR_DATA,
                         "%s%sthere is no font \"%s\" here; expected a family such as %s", where,
                         where[0] ? ": " : "", family, text.data ? text.data : "sans-serif");
out:
    if (list)
        FcFontSetDestroy(list);
    FcObjectSetDestroy(wanted);
    FcPatternDestroy(any);
    return status;
}

/* Fill font->sorted with the fonts that fit best. @return false if there is no memory. */
static bool sort_fonts(sc_font *font, const char *family)
{
    FcPattern *pattern = FcPatternCreate();
    FcResult result = FcResultMatch;
    bool ok = pattern && FcPatternAddString(pattern, FC_FAMILY, (const FcChar8 *)family) &&
              FcPatternAddInteger(pattern, FC_WEIGHT, FC_WEIGHT_BOLD) &&
              FcPatternAddBool(pattern, FC_OUTLINE, FcTrue) &&
              FcConfigSubstitute(font->config, pattern, FcMatchPattern);

    if (ok) {
        FcDefaultSubstitute(pattern);
        font->sorted = FcFontSort(font->config, pattern, FcTrue, NULL, &result);
        ok = font->sorted && result != FcResultOutOfMemory;
    }
    if (pattern)
        FcPatternDestroy(pattern);
    return ok;
}

/* Add a font of the sorted ones, unless it has no outlines. */
static void add_font(sc_font *font, const FcPattern *pattern)
{
    FcBool has_outlines = FcFalse;
    FcCharSet *characters;
    FcChar8 *file;
    int index = 0;

    if (font->count == FONTS_MAX ||
        FcPatternGetBool(pattern, FC_OUTLINE, 0, &has_outlines) != FcResultMatch || !has_outlines ||
        FcPatternGetCharSet(pattern, FC_CHARSET, 0, &characters) != FcResultMatch ||
        FcPatternGetString(pattern, FC_FILE, 0, &file) != FcResultMatch)
        return;
    (void)FcPatternGetInteger(pattern, FC_INDEX, 0, &index);
    font->fonts[font->count].characters = characters;
    font->fonts[font->count].file = (const char *)file;
    font->fonts[font->count++].index = index;
}

/* Free what find_fonts has found. */
static void forget_fonts(sc_font *font)
{
    if (font->sorted)
        FcFontSetDestroy(font->sorted);
    if (font->config)
        FcConfigDestroy(font->config);
    font->sorted = NULL;
    font->config = NULL;
    font->count = 0;
}

/* Look for the fonts of this machine. @return false if there is no memory. */
static bool find_fonts(sc_font *font, const char *family)
{
    forget_fonts(font);
    font->config = FcInitLoadConfigAndFonts();
    if (!font->config || !sort_fonts(font, family))
        return false;
    for (int i = 0; i < font->sorted->nfont; i++)
        add_font(font, font->sorted->fonts[i]);
    return true;
}

static bool is_found(const sc_font *font, const char *family)
{
    return font->count && is_of_family(font->sorted->fonts[0], family);
}

/* Find out whether there is memory for what fontconfig reads. Without it fontconfig 2.14 may wait
 * for ever for a lock of its own, which it does not release then (FcCacheInsert). */
static sc_status check_memory(const sc_ctx *ctx)
{
    void *block;
    const sc_status status = sc_alloc(ctx, FONTCONFIG_BYTES, 1, &block);

    if (status == SC_OK)
        sc_free(block);
    return status;
}

sc_status sc_font_open(const sc_ctx *ctx, const char *family, const char *where, sc_font **out)
{
    sc_font *font;
    bool found;
    sc_status status = SC_OK;

    SC_PASS(check_memory(ctx));
    SC_PASS(SC_ZALLOC(ctx, 1, &font));
    found = find_fonts(font, family);
    if (found &&
        !is_found(font, family)) /* without memory fontconfig leaves out fonts, in silence */
        found = find_fonts(font, family);
    if (!found)
        status = sc_fail(ctx, SC_ERR_MEMORY, "finding a font: out of memory");
    else if (!font->count)
        status = sc_fail(ctx, SC_ERR_SYSTEM,
                         "fontconfig finds no font on this machine, so no text can be drawn; "
                         "install one (Debian: fonts-dejavu-core), or leave out overlays");
    else if (!is_found(font, family))
        status = no_such_family(ctx, font, family, where);
    if (status != SC_OK) {
        sc_font_close(font);
        return status;
    }
    *out = font;
    return SC_OK;
}

void sc_font_close(sc_font *font)
{
    if (!font)
        return;
    for (int i = 0; i < font->count; i++) {
        if (font->fonts[i].face)
            cairo_font_face_destroy(font->fonts[i].face);
    }
    forget_fonts(font);
    sc_free(font);
}

const char *sc_font_file(const sc_font *font)
{
    return font->fonts[0].file;
}

/* ---- characters ---- */

/* @return the index of the first font that has the character; -1 if none has. */
static int find_font(const sc_font *font, unsigned code)
{
    for (int i = 0; i < font->count; i++) {
        if (FcCharSetHasChar(font->fonts[i].characters, code))
            return i;
    }
    return -1;
}

bool sc_font_has(const sc_font *font, unsigned code)
{
    return find_font(font, code) >= 0;
}

const char *sc_font_refuses(unsigned code)
{
    /* Blocks of Unicode 15 whose scripts run from right to left, and those of the scripts of India
     * and of South East Asia whose signs are put together. */
    static const unsigned from_right[][2] = {
        {0x590, 0x8ff}, {0xfb1d, 0xfdff}, {0xfe70, 0xfeff}, {0x10800, 0x10fff}, {0x1e800, 0x1efff}};
    static const unsigned joined[][2] = {{0x900, 0xdff},   {0xf00, 0xfff},   {0x1000, 0x109f},
                                         {0x1780, 0x17ff}, {0x1800, 0x18af}, {0xa840, 0xaaff}};

    if (sc_is_control(code))
        return "is a control character";
    for (size_t i = 0; i < SC_COUNT_OF(from_right); i++) {
        if (code >= from_right[i][0] && code <= from_right[i][1])
            return "is of a script that is written from right to left, which is not supported";
    }
    for (size_t i = 0; i < SC_COUNT_OF(joined); i++) {
        if (code >= joined[i][0] && code <= joined[i][1])
            return "is of a script whose letters join, which is not supported";
    }
    return NULL;
}

/* ---- outlines ---- */

/* Make the face of the font number @p index, unless it is there. @return false if there is no
 * memory. */
static bool make_face(sc_font *font, int index)
{
    FcPattern *pattern;
    cairo_font_face_t *face = NULL;

    if (font->fonts[index].face)
        return true;
    pattern = FcPatternCreate();
    if (pattern && FcPatternAddString(pattern, FC_FILE, (const FcChar8 *)font->fonts[index].file) &&
        FcPatternAddInteger(pattern, FC_INDEX, font->fonts[index].index))
        face = cairo_ft_font_face_create_for_pattern(pattern);
    if (pattern)
        FcPatternDestroy(pattern);
    if (!face || cairo_font_face_status(face) != CAIRO_STATUS_SUCCESS) {
        cairo_font_face_destroy(face);
        return false;
    }
    font->fonts[index].face = face;
    return true;
}

/* @return the font number @p index at a size; NULL without memory, which the font remembers. Caller
 * owns: cairo_scaled_font_destroy. */
static cairo_scaled_font_t *scale_font(sc_font *font, int index, double size_px)
{
    cairo_font_options_t *options;
    cairo_scaled_font_t *scaled;
    cairo_matrix_t size, none;

    if (!make_face(font, index)) {
        font->failed = true;
        return NULL;
    }
    options = cairo_font_options_create();
    cairo_font_options_set_antialias(options, CAIRO_ANTIALIAS_GRAY);
    cairo_font_options_set_hint_style(options, CAIRO_HINT_STYLE_NONE);
    cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
    cairo_matrix_init_scale(&size, size_px, size_px);
    cairo_matrix_init_identity(&none);
    scaled = cairo_scaled_font_create(font->fonts[index].face, &size, &none, options);
    if (cairo_font_options_status(options) != CAIRO_STATUS_SUCCESS ||
        cairo_scaled_font_status(scaled) != CAIRO_STATUS_SUCCESS) {
        font->failed = true;
        cairo_scaled_font_destroy(scaled);
        scaled = NULL;
    }
    cairo_font_options_destroy(options);
    return scaled;
}

/* Append the outlines of text that one font has, from @p x on. @return how far it reaches. */
static double outline_run(sc_font *font, int index, const char *text, size_t bytes, double size_px,
                          double x, cairo_t *cairo)
{
    cairo_scaled_font_t *scaled = scale_font(font, index, size_px);
    cairo_glyph_t *glyphs = NULL;
    cairo_text_extents_t extents = {0};
    int count = 0;

    if (!scaled)
        return x;
    if (cairo_scaled_font_text_to_glyphs(scaled, x, 0, text, (int)bytes, &glyphs, &count, NULL,
                                         NULL, NULL) == CAIRO_STATUS_SUCCESS) {
        cairo_scaled_font_glyph_extents(scaled, glyphs, count, &extents);
        if (cairo) {
            cairo_set_scaled_font(cairo, scaled);
            cairo_glyph_path(cairo, glyphs, count);
        }
        cairo_glyph_free(glyphs);
    } else {
        font->failed = true;
    }
    font->failed = font->failed || cairo_scaled_font_status(scaled) != CAIRO_STATUS_SUCCESS;
    cairo_scaled_font_destroy(scaled);
    return x + extents.x_advance;
}

double sc_font_outline(sc_font *font, const char *text, size_t bytes, double size_px,
                       cairo_t *cairo)
{
    size_t begin = 0, at = 0;
    int index = 0;
    double x = 0;

    while (at < bytes) {
        const size_t length = sc_utf8_bytes(text + at);
        const int found = find_font(font, sc_utf8_code(text + at, length ? length : 1));
        const int next = found < 0 ? 0 : found; /* the first font has a box for it */

        if (next != index && at > begin) {
            x = outline_run(font, index, text + begin, at - begin, size_px, x, cairo);
            begin = at;
        }
        index = next;
        at += length ? length : 1;
    }
    return at > begin ? outline_run(font, index, text + begin, at - begin, size_px, x, cairo) : x;
}

double sc_font_width_px(sc_font *font, const char *text, size_t bytes, double size_px)
{
    return sc_font_outline(font, text, bytes, size_px, NULL);
}

double sc_font_ascent(sc_font *font, double size_px)
{
    cairo_scaled_font_t *scaled = scale_font(font, 0, size_px);
    cairo_font_extents_t extents = {0};

    if (!scaled)
        return 0;
    cairo_scaled_font_extents(scaled, &extents);
    cairo_scaled_font_destroy(scaled);
    return extents.ascent;
}

bool sc_font_failed(const sc_font *font)
{
    return font->failed;
}
