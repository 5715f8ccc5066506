/* SPDX-License-Identifier: BSD-3-Clause */
#include "yaml/yaml_words.h"

enum { SHOWN_BYTES = 24 }; /* so much of the text is quoted in a message */

/* What is said of a bracket that has no partner. */
static const char not_closed_map[] =
    "this { is not closed by }, or a comma is missing between its keys";
static const char not_closed_list[] =
    "this [ is not closed by ], or a comma is missing between its items";

/* What libyaml says, and what is meant by it. The first row that fits is taken: its parts occur in
 * libyaml's problem and in its context (NULL fits all). */
static const struct {
    const char *problem, *context;
    bool at_context; /* the mistake is where the context begins, not where it was noticed */
    const char *words;
} rows[] = {
    {NULL, "scanning an alias", true,
     "a name or value that begins with * needs quotes: \"*atri*\""},
    {NULL, "scanning an anchor", true, "a value that begins with & needs quotes"},
    {NULL, "tag", true, "a value that begins with ! needs quotes"},
    {"tag handle", NULL, true, "a value that begins with ! needs quotes"},
    {NULL, "directive", true, "a line that begins with % needs quotes"},
    {"YAML document", NULL, false, "expected no line of %YAML, or %YAML 1.1"},
    {"cannot start any token", NULL, false,
     "no key or value begins so; put it in quotes, and indent with blanks, not with tabs"},
    {"tab character", NULL, false, "a tab; indent with blanks"},
    {"mapping values are not allowed", NULL, false,
     "a second \": \" in one line, or a key that is indented more than the one above it; put a "
     "value that holds \": \" in quotes"},
    {"mapping keys are not allowed", NULL, false, "a \"? \" has no place here; put it in quotes"},
    {"block sequence entries", NULL, false,
     "an item of a list (\"- \") cannot follow here; begin it in a line of its own"},
    {"could not find expected ':'", NULL, true, "expected \"key: value\"; the colon is missing"},
    {"did not find expected key", NULL, false,
     "expected a key here; is the line indented like those above it, and does a quote end before "
     "its value does?"},
    {"',' or '}'", NULL, true, not_closed_map},
    {"',' or ']'", NULL, true, not_closed_list},
    {"expected '-' indicator", NULL, false,
     "expected the next item of the list (\"- \"); is the line indented like those above it?"},
    {"end of stream", "scalar", true, "this quote is never closed"},
    {"document indicator", "scalar", true, "this quote is never closed"},
    {"escape", NULL, false,
     "an unknown escape in double quotes; write \\\\ for a backslash, or use single quotes"},
    {"hexdecimal", NULL, false,
     "an unknown escape in double quotes; write \\\\ for a backslash, or use single quotes"},
    {"comment or line break", NULL, false, "behind | and > the text begins in the next line"},
    {"indentation", "block scalar", false,
     "behind | and > a number from 1 to 9 says how far the text is indented"},
    {"node content", NULL, false, "expected a value here; put it in quotes"},
    {"document start", NULL, false, "expected the end of the file: a job is one document"},
    {"control characters", NULL, false,
     "a control character; expected text (is this a job file, and saved as UTF-8?)"},
    {"UTF-8", NULL, false, "not UTF-8; save the file as UTF-8"},
    {"UTF-16", NULL, false, "not UTF-8; save the file as UTF-8"},
    {"surrogate", NULL, false, "not UTF-8; save the file as UTF-8"},
    {"Unicode", NULL, false, "not UTF-8; save the file as UTF-8"},
};

/* Does @p part occur in @p whole, which may be NULL? A part that is NULL occurs everywhere. */
static bool occurs(const char *part, const char *whole)
{
    return !part || (whole && strstr(whole, part));
}

/* @return the byte of text[bytes] at @p line and @p column, both from 0; columns count characters.
 */
static size_t byte_at(const char *text, size_t bytes, size_t line, size_t column)
{
    size_t at = 0;

    for (; line > 0 && at < bytes; at++)
        line -= text[at] == '\n';
    for (; column > 0 && at < bytes && text[at] != '\n'; column--)
        at += sc_utf8_bytes(text + at) ? sc_utf8_bytes(text + at) : 1;
    return at < bytes ? at : bytes;
}

/* Write line and column, from 0, of byte @p offset to *mark; the rest of it is not set. */
static void mark_of_byte(const char *text, size_t bytes, size_t offset, yaml_mark_t *mark)
{
    mark->line = mark->column = 0;
    for (size_t i = 0; i < offset && i < bytes; i++) {
        mark->line += text[i] == '\n';
        mark->column += ((unsigned char)text[i] & 0xc0) != 0x80;
        mark->column = text[i] == '\n' ? 0 : mark->column;
    }
}

/* Copy what stands at @p begin of text[bytes], to the end of its line at most, to
 * out[SHOWN_BYTES + 1]. */
static void quote(const char *text, size_t bytes, size_t begin, char *out)
{
    size_t used = 0;

    while (begin < bytes && text[begin] && text[begin] != '\n' && text[begin] != '\r') {
        const size_t whole = sc_utf8_bytes(text + begin), count = whole ? whole : 1;

        if (used + count > SHOWN_BYTES || begin + count > bytes)
            break;
        memcpy(out + used, text + begin, count);
        used += count;
        begin += count;
    }
    out[used] = '\0';
}

/* ---- slips that libyaml notices far behind their place ---- */

enum { FLOW_DEPTH = 32 }; /* of maps and lists in brackets; more are not looked at */

/* What of a text is open at its end. */
typedef struct open_flow {
    size_t begin[FLOW_DEPTH]; /* where each { and [ stands that is not closed */
    int depth;
    bool has_color;
    size_t color; /* where, within brackets, the # of a colour without quotes begins a comment */
} open_flow;

/* @return whether the # at @p at of text[end] begins a colour such as #ff0000, where a value is
 * expected. */
static bool is_color(const char *text, size_t end, size_t at, char before)
{
    size_t behind = at + 1;

    while (behind < end && strchr("0123456789abcdefABCDEF", text[behind]))
        behind++;
    return (before == ':' || before == '[') && behind - at > 3 &&
           (behind == end || strchr(" ,]}\r\n", text[behind]));
}

/* Find what is open at the end of text[end]. Texts in quotes and comments are skipped. */
static void scan_flow(const char *text, size_t end, open_flow *out)
{
    char quote = '\0', before = '\n'; /* the last character that is no blank */

    *out = (open_flow){0};
    for (size_t i = 0; i < end; i++) {
        const bool begins = strchr(":,[{-\n", before) != NULL;
        const char c = text[i], last = i ? text[i - 1] : '\n';

        if (quote) {
            const bool escapes =
                quote == '"' ? c == '\\' : c == '\'' && i + 1 < end && text[i + 1] == '\'';

            quote = c == quote && !escapes ? '\0' : quote;
            i += escapes;
        } else if (c == '#' && strchr(" \t\n[{,", last)) {
            if (out->depth && is_color(text, end, i, before)) {
                out->has_color = true;
                out->color = i;
            }
            while (i + 1 < end && text[i + 1] != '\n')
                i++;
            continue;
        } else if (begins && (c == '"' || c == '\'')) {
            quote = c;
        } else if ((c == '{' || c == '[') && (begins || out->depth) && out->depth < FLOW_DEPTH) {
            out->begin[out->depth++] = i;
        } else if ((c == '}' || c == ']') && out->depth) {
            out->depth--;
        }
        before = c == ' ' || c == '\t' || c == '\r' ? before : c;
    }
}

const char *sc_yaml_lost_blank(const char *line)
{
    static const char letters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_";
    const char *word = line + strspn(line, " -");
    const char *colon = word + strspn(word, letters);

    return colon > word && *colon == ':' && colon[1] && !strchr(" \t\r\n:", colon[1]) &&
                   strncmp(colon + 1, "//", 2) != 0
               ? colon + 1
               : NULL;
}

/* Find a line in which the blank behind a colon is missing: the line at byte @p at, or the last
 * before it that is not empty. @param begin where its key begins. @return false if there is none.
 */
static bool find_lost_blank(const char *text, size_t at, size_t *begin)
{
    for (int lines = 0; lines < 2; lines++) {
        while (at > 0 && text[at - 1] != '\n')
            at--;
        if (sc_yaml_lost_blank(text + at)) {
            *begin = at + strspn(text + at, " -");
            return true;
        }
        while (at > 0 && strchr(" \t\r\n", text[at - 1]))
            at--;
    }
    return false;
}

/* Find a slip behind which libyaml has stopped at byte @p at. @param begin where it is. @return
 * what to say of it, or NULL. */
static const char *find_slip(const char *text, size_t bytes, size_t at, const yaml_parser_t *parser,
                             size_t *begin)
{
    const char *problem = parser->problem ? parser->problem : "";
    open_flow flow;
    size_t end = bytes;

    while (end > 0 && strchr(" \t\r\n", text[end - 1]))
        end--;
    scan_flow(text, at, &flow);
    if (flow.has_color) {
        *begin = flow.color;
        return "in YAML a # begins a comment; put the colour in quotes";
    }
    if (flow.depth && at >= end && parser->context && strstr(parser->context, "flow")) {
        *begin = flow.begin[flow.depth - 1];
        return text[*begin] == '{' ? not_closed_map : not_closed_list;
    }
    if ((strstr(problem, "mapping values") || strstr(problem, "expected ':'")) &&
        find_lost_blank(text, at, begin))
        return "a blank is missing behind the colon";
    return NULL;
}

sc_status sc_yaml_explain(const sc_ctx *ctx, const char *origin, const char *text, size_t bytes,
                          const yaml_parser_t *parser)
{
    const char *problem = parser->problem ? parser->problem : "", *words = "it cannot be read here",
               *slip;
    yaml_mark_t mark = parser->problem_mark;
    char found[SHOWN_BYTES + 1];
    size_t at;

    if (parser->error == YAML_MEMORY_ERROR)
        return sc_fail(ctx, SC_ERR_MEMORY, "%s: out of memory", origin);
    for (size_t i = 0; i < SC_COUNT_OF(rows); i++) {
        if (!occurs(rows[i].problem, problem) || !occurs(rows[i].context, parser->context))
            continue;
        words = rows[i].words;
        if (rows[i].at_context && parser->context)
            mark = parser->context_mark;
        break;
    }
    if (parser->error == YAML_READER_ERROR)
        mark_of_byte(text, bytes, parser->problem_offset, &mark);
    at = byte_at(text, bytes, parser->problem_mark.line, parser->problem_mark.column);
    slip = parser->error == YAML_READER_ERROR ? NULL : find_slip(text, bytes, at, parser, &at);
    if (slip) {
        words = slip;
        mark_of_byte(text, bytes, at, &mark);
    }
    quote(text, bytes, byte_at(text, bytes, mark.line, mark.column), found);
    return sc_fail(ctx, SC_ERR_DATA, "%s:%zu:%zu: not YAML%s%s%s: %s", origin, mark.line + 1,
                   mark.column + 1, found[0] ? ": \"" : "", found, found[0] ? "\"" : "", words);
}
