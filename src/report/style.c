/* SPDX-License-Identifier: BSD-3-Clause */
/* How pages look: on screens of any width, light and dark, and on paper. */
#include "internal.h"

/* From the palette of tissues: at least 0.085 apart for every kind of vision, and neighbours in a
 * stack of phases 0.12 (sc_color_contrast; tests/unit/test_report.c). */
const uint8_t sc_series_colors[SC_SERIES_COLORS][3] = {
    {162, 76, 97},   {111, 140, 58}, {151, 164, 243}, {73, 105, 174},
    {210, 121, 106}, {127, 107, 3},  {211, 161, 80},  {140, 146, 154}};

const char *sc_phase_word(sc_phase phase)
{
    static const char *const words[SC_PHASE_COUNT] = {"reading", "preparing", "sharing",
                                                      "drawing", "gathering", "encoding",
                                                      "writing", "waiting"};

    return words[phase];
}

int sc_phase_color(sc_phase phase)
{
    return (int)phase; /* SC_PHASE_IDLE is the last of both */
}

const char sc_page_style[] =
    ":root { --page: #fcfcfa; --ink: #1d2126; --soft: #5b636d; --line: #d9dcdf; --card: #f3f3f0; "
    "--link: #24559c; }\n"
    "@media (prefers-color-scheme: dark) { :root { --page: #181b1f; --ink: #e6e8ea; "
    "--soft: #a2aab3; --line: #363c44; --card: #20242a; --link: #8fb8f0; } }\n"
    "* { box-sizing: border-box; }\n"
    "html { background: var(--page); color: var(--ink); font: 16px/1.5 system-ui, sans-serif; "
    "-webkit-text-size-adjust: 100%; text-size-adjust: 100%; }\n"
    "body { margin: 0; }\n"
    "main { max-width: 68rem; margin: 0 auto; padding: 1.5rem 1rem 4rem; "
    "overflow-wrap: anywhere; }\n"
    "h1 { font-size: 1.6rem; line-height: 1.25; margin: 0 0 .75rem; overflow-wrap: anywhere; }\n"
    "h2 { font-size: 1.15rem; margin: 2.5rem 0 .5rem; padding-top: .75rem; "
    "border-top: 1px solid var(--line); }\n"
    "p { max-width: 46rem; margin: .5rem 0; overflow-wrap: anywhere; }\n"
    "p.lead { font-size: 1.15rem; }\n"
    "p.note, figcaption, caption { color: var(--soft); font-size: .875rem; }\n"
    "a { color: var(--link); }\n"
    "a:focus-visible, summary:focus-visible, video:focus-visible { outline: 2px solid var(--link); "
    "outline-offset: 2px; }\n"
    "code, pre { font: .85em/1.5 ui-monospace, monospace; }\n"
    "code { background: var(--card); padding: .1em .3em; border-radius: 3px; }\n"
    "pre { background: var(--card); padding: 1rem; border-radius: 4px; white-space: pre-wrap; "
    "overflow-wrap: anywhere; margin: .5rem 0; }\n"
    "dl { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(20rem, 100%), 1fr)); "
    "gap: 0 2rem; margin: .75rem 0; }\n"
    "dl div { display: flex; justify-content: space-between; gap: 1rem; padding: .3rem 0; "
    "border-bottom: 1px solid var(--line); }\n"
    "dt { color: var(--soft); flex: none; }\n"
    "dd { margin: 0; text-align: right; overflow-wrap: anywhere; "
    "font-variant-numeric: tabular-nums; }\n"
    "table.data { border-collapse: collapse; width: 100%; margin: .75rem 0; "
    "font-variant-numeric: tabular-nums; font-size: .9rem; }\n"
    "caption { text-align: left; padding-bottom: .25rem; }\n"
    ".data th, .data td { text-align: right; padding: .3rem .5rem; vertical-align: top; "
    "border-bottom: 1px solid var(--line); overflow-wrap: anywhere; font-weight: normal; }\n"
    ".data td.n { overflow-wrap: normal; }\n"
    ".data th[scope=row], .data th:first-child { text-align: left; padding-left: 0; }\n"
    ".wide th:first-child { min-width: 6.5rem; }\n"
    ".data thead th { color: var(--soft); overflow-wrap: normal; }\n"
    "figure { margin: 1rem 0; }\n"
    "figcaption { margin-bottom: .5rem; }\n"
    "svg { display: block; overflow: visible; }\n"
    "svg text { fill: var(--soft); stroke: none; font-size: 12px; "
    "font-variant-numeric: tabular-nums; }\n"
    ".plot { height: 13rem; width: calc(100% - 4rem); margin: .5rem .75rem 2.75rem 3.25rem; }\n"
    ".grid { stroke: var(--line); stroke-width: 1; shape-rendering: crispEdges; }\n"
    ".line { fill: none; stroke-width: 2; vector-effect: non-scaling-stroke; "
    "stroke-linejoin: round; stroke-linecap: round; }\n"
    ".dots { fill: none; stroke-width: 5; stroke-linecap: round; vector-effect: "
    "non-scaling-stroke; "
    "opacity: .8; }\n"
    ".dot { fill: none; stroke: var(--ink); opacity: .7; }\n"
    ".interval { stroke: var(--ink); stroke-width: 1.5; }\n"
    ".dashed { stroke-dasharray: 5 4; }\n"
    ".band { stroke: none; opacity: .3; }\n"
    ".mark { stroke: var(--soft); stroke-width: 1; stroke-dasharray: 2 3; }\n"
    ".bar, .strip path { stroke: none; }\n"
    ".row { display: grid; grid-template-columns: 11rem minmax(0, 1fr) 5.5rem; gap: 0 .75rem; "
    "align-items: center; padding: 2px 0; font-size: .875rem; break-inside: avoid; }\n"
    ".row > span { overflow-wrap: anywhere; line-height: 1.3; }\n"
    ".row .value { font-variant-numeric: tabular-nums; text-align: right; }\n"
    ".strip { width: 100%; height: 1.15rem; background: var(--card); }\n"
    ".thin .row { padding: 1px 0; font-size: .75rem; grid-template-columns: 11rem minmax(0, 1fr); "
    "}\n"
    ".thin .strip { height: .8rem; }\n"
    ".scale { width: 100%; height: 2.5rem; }\n"
    ".legend { list-style: none; display: flex; flex-wrap: wrap; gap: .25rem 1.25rem; padding: 0; "
    "margin: .5rem 0; font-size: .875rem; }\n"
    ".legend svg { display: inline-block; width: .8rem; height: .8rem; margin-right: .4rem; }\n"
    ".film { display: grid; gap: 4px; margin: 0 .75rem 0 3.25rem; }\n"
    ".film figure { margin: 0; text-align: center; min-width: 0; }\n"
    ".film img { width: 100%; height: auto; display: block; }\n"
    "video { display: block; max-width: 100%; height: auto; background: var(--card); }\n"
    "@media (max-width: 40rem) {\n"
    ".row { grid-template-columns: minmax(0, 1fr) auto; padding: .3rem 0; }\n"
    ".row svg { grid-column: 1 / -1; grid-row: 2; }\n"
    ".thin .row { grid-template-columns: minmax(0, 1fr); }\n"
    ".film figure:nth-child(even) { display: none; }\n"
    ".film { grid-template-columns: repeat(4, minmax(0, 1fr)) !important; }\n"
    "}\n"
    "@media (max-width: 50rem) {\n"
    ".wide thead { display: none; }\n"
    ".wide, .wide caption, .wide tbody, .wide tr, .wide th, .wide td { display: block; }\n"
    ".wide tr { padding: .5rem 0; border-bottom: 1px solid var(--line); }\n"
    ".wide td, .wide th[scope=row] { border: 0; padding: .1rem 0; text-align: right; }\n"
    ".wide th[scope=row] { text-align: left; font-weight: 600; }\n"
    ".wide td::before { content: attr(data-head); float: left; color: var(--soft); "
    "padding-right: 1rem; }\n"
    ".wide td::after { content: \"\"; display: block; clear: both; }\n"
    "}\n"
    "@media print {\n"
    ":root { --page: #fff; --ink: #000; --soft: #444; --line: #bbb; --card: #f3f3f3; "
    "--link: #000; }\n"
    "html { font-size: 10pt; print-color-adjust: exact; -webkit-print-color-adjust: exact; }\n"
    "main { padding: 0; max-width: none; }\n"
    "video, .screen { display: none; }\n"
    "h2 { break-after: avoid; }\n"
    "figure, tr, dl div { break-inside: avoid; }\n"
    "}\n";
