// SPDX-License-Identifier: BSD-3-Clause
// Elements, numbers, tables. What comes from the data becomes the text of elements or of attributes, never HTML.

const build = (element, attributes, children) => {
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined));
  return element;
};
export const el = (tag, attributes, ...children) => build(document.createElement(tag), attributes, children);
export const svg = (tag, attributes, ...children) =>
  build(document.createElementNS("http://www.w3.org/2000/svg", tag), attributes, children);

// Text in which what stands between backquotes is code.
export const prose = (text) => text.split("`").map((part, i) => (i % 2 ? el("code", {}, part) : part));
export const section = (heading, ...children) => el("section", {}, el("h2", {}, heading), ...children);
export const note = (...children) => el("p", { class: "note" }, ...children);

// ---- numbers ----

export const fixed = (value, decimals) => value.toFixed(decimals);
// With four digits that count.
export const digits = (value) => String(Number(value.toPrecision(4)));
export const percent = (share, decimals = 1) => `${fixed(100 * share, decimals)}\u00a0%`;
export const plural = (count, word) => `${count} ${word}${count === 1 ? "" : "s"}`;
export const size = (bytes) => {
  const units = ["bytes", "kB", "MB", "GB", "TB"];
  let unit = 0;
  for (; bytes >= 999.5 && unit + 1 < units.length; unit++) bytes /= 1000;
  return `${fixed(bytes, unit && bytes < 99.95 ? 1 : 0)}\u00a0${units[unit]}`;
};

// ---- tables and lists ----

// Numbers and short words, within which no line may break.
const isShort = (value) => typeof value !== "string" || value.length <= 10 || /^\d.{0,30}$/.test(value);
// On narrow screens each row of many columns becomes a block, with the heads before the values.
export const table = (caption, heads, rows) =>
  el("table", { class: heads.length > 4 ? "wide" : "" },
    el("caption", {}, caption),
    el("thead", {}, el("tr", {}, heads.map((head) => el("th", { scope: "col" }, head)))),
    el("tbody", {}, rows.map((row) => el("tr", {}, row.map((value, i) =>
      i ? el("td", { "data-head": heads[i], class: isShort(value) ? "n" : "" }, value ?? "–") :
        el("th", { scope: "row" }, value))))));

// Pairs of name and value, without those of which the value is unknown.
export const facts = (pairs) =>
  el("dl", {}, pairs.filter(([, value]) => value).map(([name, value]) =>
    el("div", {}, el("dt", {}, name), el("dd", {}, value))));

export const link = (name) =>
  el("a", { href: name.split("/").map((part) => encodeURIComponent(part)).join("/") }, el("bdi", {}, name));

// The text of the job or of the study, and the files beside the page.
export const sources = (settings, files, what) => section("Settings and files",
  settings === null ? null : el("details", {}, el("summary", {}, "All settings"), el("pre", {}, settings)),
  el("ul", {}, files.map((name) => el("li", {}, link(name), ": ", what[name.split(".")[0]]))));
