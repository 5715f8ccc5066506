/* SPDX-License-Identifier: BSD-3-Clause */
/* The documents of a job file: docs/job.md and segcast-job(5). Their tables come from the rows of
 * the keys; this file holds only what no row can say. */
#include "describe.h"

/* The rules that hold for all keys, one paragraph each; `text` in backquotes is code. */
static const char *const introduction[] = {
    "A job file is YAML with the keys below. Unknown keys, keys given twice, wrong types and "
    "values out of range are errors that name the file, the line, what stood there and the nearest "
    "valid name; aliases (`*name`) are refused. `segcast check JOB.yaml` tells all of them in one "
    "go, before a job is submitted. `segcast init VOLUME` writes a job to begin with.",
    "Every key can also be set on the command line, `--set render.quality=still`, and in the "
    "environment, `SEGCAST_RENDER_QUALITY=still`. The command line wins over the environment, that "
    "over the file, and the file over the defaults. The value is YAML. A map is merged into what "
    "is there; a list is replaced. Names with dots or spaces are quoted: `--set 'tissues.\"left "
    "atrium\".opacity=0.5'`. Items of a list have their index: `--set animation.clip.0.at=40%` or "
    "`animation.clip[0].at`; the index after the last one appends. Of keys that exclude each "
    "other, such as orbit and fixed, a setting removes the other.",
    "Paths in the file are relative to the file, those of settings to the working directory. `~` "
    "and variables such as `$HOME` are not replaced: shells do that, outside of quotes.",
    "A colour is a name of CSS (`red`, `dark orange`), `\"#f00\"` or `\"#ff0000\"` (in quotes, "
    "because in YAML # begins a comment), or a list of levels from 0 to 255, `[255, 128, 0]`, or "
    "of shares with a decimal point, `[1.0, 0.5, 0]`.",
    "Directions are words or vectors `[x, y, z]`. The words are `left`, `right`, `anterior` (or "
    "`ventral`, `front`), `posterior` (`dorsal`, `back`), `superior` (`cranial`, `head`, `top`), "
    "`inferior` (`caudal`, `feet`, `bottom`), and the axes `x`, `y`, `z`, `-x`, `-y`, `-z`. Points "
    "are `[R, A, S]`; both are in patient coordinates, RAS+ (right, anterior and superior are "
    "positive), in millimetres.",
    "Positions of planes are a share of the way through what is visible (`40%`) or millimetres "
    "along the plane's normal (`12 mm`, measured from the origin of the patient coordinates); a "
    "number without a unit is refused.",
    "`during: [20%, 80%]` is the part of the animation in which something changes. Both ends are "
    "shares of the animation (`20%`: 0% is its first frame, 100% its last), seconds (`1.5s`, "
    "`500ms`, `2 min`), minutes and seconds (`1:05`), or numbers of frames (`30f`), counted from "
    "its beginning.",
    "Tissues are named by their name, by a glob (`\"*atri*\"`) or by their label number. Case is "
    "ignored, and where no name fits exactly, also whether words are separated by blanks, `_` or "
    "`-`: left_atrium finds \"left atrium\". A name that could stand for several tissues is an "
    "error. Of several entries that match one tissue the later wins, key by key.",
};

/* ---- Markdown ---- */

/* Append a cell of a table. Bars, which would end the cell, and asterisks are escaped. */
static sc_status add_cell(const sc_ctx *ctx, const char *value, sc_text *out)
{
    for (; *value; value++)
        SC_PASS(sc_text_add(ctx, out, *value == '|' || *value == '*' ? "\\%c" : "%c", *value));
    return SC_OK;
}

/* Append a row of a Markdown table to the text @p user. A map at the top of the file begins a
 * section with a table of its own instead; maps below it are rows as keys are. */
static sc_status add_markdown_row(const sc_ctx *ctx, void *user, const sc_key_visit *visit)
{
    const sc_key *key = visit->key;
    sc_text *out = user;
    SC_OWN(sc_text_clear) sc_text values = {0};

    if (visit->depth == 0 && key->keys)
        SC_PASS(sc_text_add(ctx, out, "\n## %s\n\n%c%s.\n", key->name,
                            key->help[0] - ('a' <= key->help[0] && key->help[0] <= 'z' ? 32 : 0),
                            key->help + 1));
    if (visit->depth == 0 && (key->keys || key == sc_job_keys))
        SC_PASS(
            sc_text_add(ctx, out, "\n| key | value | default | meaning |\n|---|---|---|---|\n"));
    if (visit->depth == 0 && key->keys)
        return SC_OK;
    SC_PASS(sc_text_add(ctx, out, "| `%s` | ", visit->path));
    SC_PASS(sc_key_values(ctx, key, &values));
    SC_PASS(add_cell(ctx, values.data, out));
    SC_PASS(sc_text_add(ctx, out, " | "));
    SC_PASS(add_cell(ctx, sc_key_default(key), out));
    SC_PASS(sc_text_add(ctx, out, " | "));
    SC_PASS(add_cell(ctx, key->help, out));
    return sc_text_add(ctx, out, " |\n");
}

sc_status sc_keys_markdown(const sc_ctx *ctx, sc_text *out)
{
    SC_PASS(sc_text_add(ctx, out,
                        "<!-- Made by `segcast help keys --markdown` from the table of keys; do "
                        "not edit. -->\n# The job file\n"));
    for (size_t i = 0; i < SC_COUNT_OF(introduction); i++)
        SC_PASS(sc_text_add(ctx, out, "\n%s\n", introduction[i]));
    SC_PASS(sc_text_add(ctx, out, "\n## The file\n"));
    return sc_keys_walk(ctx, add_markdown_row, out);
}

/* ---- manual page ---- */

/* Append text for roff: hyphens become minus signs, backslashes are escaped, and text in backquotes
 * becomes bold. */
static sc_status add_roff(const sc_ctx *ctx, const char *text, sc_text *out)
{
    bool bold = false;

    for (; *text; text++) {
        if (*text == '`') {
            bold = !bold;
            SC_PASS(sc_text_add(ctx, out, bold ? "\\fB" : "\\fR"));
        } else if (*text == '-') {
            SC_PASS(sc_text_add(ctx, out, "\\-"));
        } else if (*text == '\\') {
            SC_PASS(sc_text_add(ctx, out, "\\e"));
        } else {
            SC_PASS(sc_text_add(ctx, out, "%c", *text));
        }
    }
    return SC_OK;
}

/* Append a paragraph of the manual page for one row to the text @p user. */
static sc_status add_man_row(const sc_ctx *ctx, void *user, const sc_key_visit *visit)
{
    const sc_key *key = visit->key;
    const char *value = sc_key_default(key);
    sc_text *out = user;
    SC_OWN(sc_text_clear) sc_text line = {0};

    SC_PASS(sc_text_add(ctx, &line, "`%s`\n%s", visit->path, key->help));
    SC_PASS(sc_text_add(ctx, &line, " ("));
    SC_PASS(sc_key_values(ctx, key, &line));
    if (value[0])
        SC_PASS(sc_text_add(ctx, &line, key->required ? " %s" : "; default: %s", value));
    SC_PASS(sc_text_add(ctx, &line, ")\n"));
    SC_PASS(sc_text_add(ctx, out, ".TP\n"));
    return add_roff(ctx, line.data, out);
}

sc_status sc_keys_man(const sc_ctx *ctx, sc_text *out)
{
    SC_PASS(sc_text_add(ctx, out,
                        ".TH SEGCAST\\-JOB 5 \"\" \"segcast\" \"File formats\"\n.SH NAME\n"
                        "segcast\\-job \\- job file of segcast(1)\n.SH DESCRIPTION\n"));
    for (size_t i = 0; i < SC_COUNT_OF(introduction); i++) {
        SC_PASS(add_roff(ctx, introduction[i], out));
        SC_PASS(sc_text_add(ctx, out, "\n.PP\n"));
    }
    SC_PASS(sc_text_add(ctx, out, ".SH KEYS\n"));
    SC_PASS(sc_keys_walk(ctx, add_man_row, out));
    return sc_text_add(ctx, out, ".SH SEE ALSO\nsegcast(1)\n");
}
