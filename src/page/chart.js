// SPDX-License-Identifier: BSD-3-Clause
// Charts as SVG. They have no size of their own: positions are percents of their width and height, so that letters and
// lines stay as large as they are on a telephone and on a wide screen. What is stretched lies in an inner svg, 1000 wide
// and 1000 high. Colours are numbers of the style's --c0, --c1, ...
import { el, svg } from "./dom.js";

// ---- axes ----

const decimalsOf = (step) => Math.max(0, Math.min(9, -Math.floor(Math.log10(step) + 1e-9)));
const makeAxis = (low, high, step, log) => {
  const at = (value) => 100 * (log ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low));
  const ticks = [], first = log ? 2 ** Math.ceil(Math.log2(low) - 1e-9) : low;
  for (let i = 0; i < 50; i++) {
    const value = log ? first * step ** i : first + i * step;
    if (value > high * (1 + 1e-9)) break;
    ticks.push([at(value), log ? String(Number(value.toPrecision(3))) : value.toFixed(decimalsOf(step))]);
  }
  return { at: (value) => Number(at(value).toFixed(2)), ticks };
};
// From 0 to high, with about so many steps of 1, 2 or 5 times a power of ten.
export const axisTo = (high, ticks, whole = false) => {
  if (!(high > 0)) high = 1;
  const power = 10 ** Math.floor(Math.log10(high / ticks)), rest = high / ticks / power;
  const step = power * (rest < 1.5 ? 1 : rest < 3.5 ? 2 : rest < 7.5 ? 5 : 10);
  return makeAxis(0, high, whole ? Math.max(1, step) : step, false);
};
// As axisTo, up to the next tick.
export const axisAround = (high, ticks) => {
  const [, one] = axisTo(high, ticks).ticks.map(([, label]) => Number(label));
  return makeAxis(0, one * Math.ceil(high / one - 1e-9), one, false);
};
// Logarithmic: from the power of two below low to that above high.
export const axisDoubling = (low, high) => {
  const first = Math.floor(Math.log2(low) + 1e-9), last = Math.max(first + 1, Math.ceil(Math.log2(high) - 1e-9));
  return makeAxis(2 ** first, 2 ** last, 2 ** Math.ceil((last - first) / 10), true);
};
export const axisLog = (low, high) =>
  makeAxis(low, Math.max(high, 1.01 * low), 2 ** Math.max(1, Math.ceil(Math.log2(high / low) / 6)), true);

// ---- plots ----

const stretched = (width, height, ...children) =>
  svg("svg", { width: "100%", height: "100%", viewBox: `0 0 ${width} ${height}`, preserveAspectRatio: "none" }, children);
const path = (kind, property, color, d) => svg("path", { class: kind, style: `${property}: var(--c${color})`, d });
const layer = (...d) => stretched(1000, 1000, path(...d));
const label = (x, y, text, more) => svg("text", { x: `${x}%`, y: `${y}%`, ...more }, text);
const point = (axes, x, y) => `${(10 * axes.x.at(x)).toFixed(1)} ${(1000 - 10 * axes.y.at(y)).toFixed(1)} `;

// Layers of a plot: each is called with the axes. A line has a gap where y is null.
export const line = (points, color, more = "") => (axes) => {
  let drawn = "", pen = false;
  points.forEach(([x, y], i) => {
    const there = y !== null;
    if (there) drawn += (pen ? "" : "M") + point(axes, x, y);
    if (there && !pen && (points[i + 1]?.[1] ?? null) === null) drawn += "h0.1 "; // a point by itself, which round ends show
    pen = there;
  });
  return layer(`line ${more}`, "stroke", color, drawn);
};
export const band = (points, color) => (axes) => {
  const parts = [[]];
  for (const p of points) if (p[1] === null) parts.push([]); else parts.at(-1).push(p);
  const area = (part) => "M" + part.map(([x, , high]) => point(axes, x, high)).join("") +
    part.toReversed().map(([x, low]) => point(axes, x, low)).join("") + "z";
  return layer("band", "fill", color, parts.filter((part) => part.length).map(area).join(""));
};
export const dots = (points, color) => (axes) =>
  layer("dots", "stroke", color, points.map(([x, y]) => `M${point(axes, x, y)}h0`).join(""));
export const marks = (values) => ({ x }) =>
  values.map((value) => svg("line", { class: "mark", x1: `${x.at(value)}%`, x2: `${x.at(value)}%`, y1: 0, y2: "100%" }));

// words: what is seen, for those who cannot see it.
export const plot = (caption, words, xLabel, x, y, layers) =>
  el("figure", {}, el("figcaption", {}, caption),
    svg("svg", { class: "plot", role: "img", "aria-label": `${caption}. ${words}` },
      y.ticks.map(([at, text]) => [
        svg("line", { class: "grid", x1: 0, x2: "100%", y1: `${100 - at}%`, y2: `${100 - at}%` }),
        label(0, 100 - at, text, { dx: -8, dy: 4, "text-anchor": "end" })]),
      x.ticks.map(([at, text]) => label(at, 100, text, { dy: 18, "text-anchor": "middle" })),
      label(50, 100, xLabel, { dy: 38, "text-anchor": "middle" }),
      layers.map((draw) => draw({ x, y }))));

export const legend = (items) => el("ul", { class: "legend" },
  items.map(([name, color]) => el("li", {}, el("i", { style: `background: var(--c${color})` }), name)));

// ---- rows: bars with a common axis, or what threads did when ----

const rectangle = (axis, [from, to, color, title]) => svg("rect", { x: `${axis.at(from)}%`, height: "100%",
  width: `${Math.max(0, axis.at(to) - axis.at(from)).toFixed(2)}%`, style: `fill: var(--c${color})` },
title ? svg("title", {}, title) : null);
const interval = (axis, [low, high]) =>
  [[low, high, 50, 50], [low, low, 25, 75], [high, high, 25, 75]].map(([a, b, top, bottom]) =>
    svg("line", { class: "interval", x1: `${axis.at(a)}%`, x2: `${axis.at(b)}%`, y1: `${top}%`, y2: `${bottom}%` }));
// Parts that follow each other: [seconds, colour, name] become bars.
export const stack = (parts) => {
  let at = 0;
  return parts.map(([length, color, name]) => [at, (at += length), color, name]).filter(([from, to]) => to > from);
};
// One path for each kind of letter; where a capital letter begins something new, a thin gap is left.
const strip = (text, colors) => stretched(text.length, 1, Object.entries(colors).map(([kind, color]) => {
  const runs = [...text.matchAll(new RegExp(`[${kind}${kind.toUpperCase()}]${kind}*`, "g"))];
  const box = ({ index, 0: { length } }) => `M${index + (length > 3 ? 0.7 : 0)} 0V1H${index + length}V0z`;
  return path("", "fill", color, runs.map(box).join(""));
}));
// rows: {label, words, bars, dots, interval, strip, colors, value}.
export const chart = (caption, unit, axis, rows, thin = "") =>
  el("figure", { class: `rows ${thin}` }, el("figcaption", {}, caption),
    rows.map((row) => el("div", { class: "row" }, el("span", {}, row.label),
      svg("svg", { class: "strip", role: "img", "aria-label": `${row.label}: ${row.words ?? row.value}` },
        (row.bars ?? []).map((bar) => rectangle(axis, bar)),
        (row.dots ?? []).map((value) => svg("circle", { class: "dot", cx: `${axis.at(value)}%`, cy: "50%", r: 3 })),
        row.interval ? interval(axis, row.interval) : null,
        row.strip ? strip(row.strip, row.colors) : null),
      thin ? null : el("span", { class: "value" }, row.value))),
    el("div", { class: "row" }, el("span", {}), svg("svg", { class: "scale", "aria-hidden": "true" },
      axis.ticks.map(([at, text]) => [
        svg("line", { class: "grid", x1: `${at}%`, x2: `${at}%`, y1: 0, y2: 5 }),
        label(at, 0, text, { dy: 18, "text-anchor": at < 1 ? "start" : at > 96 ? "end" : "middle" })]),
      label(50, 0, unit, { class: "unit", dy: 35, "text-anchor": "middle" })), thin ? null : el("span", {})));
