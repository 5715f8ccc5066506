// SPDX-License-Identifier: BSD-3-Clause
// The list of tissues, and the one that is selected.
import { el, digits } from "./dom.js";
import { desk, on, change, isMoving, say } from "./server.js";
import { flow, given, keyed, planes, prefix } from "./keys.js";
import { button, choice, keepFocus } from "./parts.js";
import { onPick } from "./view.js";

export const selection = { id: 0, listeners: [] };
export const tissueOf = (id) => desk.state.tissues.find((tissue) => tissue.id === id);
export const selectTissue = (id) => {
  selection.id = id;
  selection.listeners.forEach((listener) => listener(tissueOf(id)));
};

const search = el("input", { type: "search", placeholder: "Search tissues", "aria-label": "Search tissues", id: "search" });
const tissueRows = el("ul", { class: "rows", id: "tissues" });
const detail = el("div", { class: "detail", id: "detail", role: "status" });
const banner = el("p", { class: "banner", hidden: "" });
const palette = choice("Colours of the tissues", [["table", "Colours of the table"], ["anatomy", "Colours of anatomy"], ["distinct", "Distinct colours"]],
  (value) => change([["appearance", value]]));
export const tissuePanel = el("section", { class: "panel" }, el("div", { class: "line" }, search, palette), banner, tissueRows, detail);

const setTissue = (tissue, name, value, group = "") => change([keyed(`${prefix()}tissues.${tissue.key}.${name}`, value)], group);

// ---- solo: what is hidden for it comes back ----

let solo = null; // { id, before: what stood in the job of each tissue that it has changed, by its key }
const visiblePath = (key) => `${prefix()}tissues.${key}.visible`;
const setSolo = (id) => {
  const back = (solo?.before ?? []).map(([key, value]) => [visiblePath(key), value]), was = solo?.id;
  const shown = new Set(solo?.before.filter(([, , visible]) => visible).map(([key]) => key));
  solo = null;
  if (was === id) { change(back); return; }
  const before = desk.state.tissues.filter((t) => (t.visible || shown.has(t.key)) !== (t.id === id))
    .map((t) => [t.key, back.find(([path]) => path === visiblePath(t.key))?.[1] ?? given(visiblePath(t.key)) ?? null, t.visible || shown.has(t.key)]);
  solo = { id, before, since: desk.state.revision };
  const edits = new Map(back);
  for (const [key] of before) edits.set(visiblePath(key), key === tissueOf(id).key);
  change([...edits]);
};

// ---- cuts ----

export const nameInJob = (tissue) => (tissue.key.startsWith('"') ? tissue.name : tissue.label);
const isNamedBy = (pattern, tissue) => String(pattern) === String(tissue.label) ||
  new RegExp(`^${String(pattern).replace(/[.+^${}()|[\]\\]/g, "\\$&").replace(/\*/g, ".*").replace(/\?/g, ".")}$`, "i").test(tissue.name);
// Let planes spare a tissue, or cut it; of a pattern that names it, the other tissues stay.
const spare = (tissue, spared, which) => {
  const others = (pattern) => (isNamedBy(pattern, tissue) ? desk.state.tissues.filter((one) => one.id !== tissue.id && isNamedBy(pattern, one)).map(nameInJob) : [pattern]);
  const edits = which.map(({ entry, i }) => {
    const except = [entry.except ?? []].flat();
    return [`${prefix()}animation.clip[${i}].except`, flow(spared ? [...new Set([...except, nameInJob(tissue)])] : except.flatMap(others))];
  });
  if (edits.length) change(edits);
  else say("There is no cut yet from which it could be exempt.", "warn");
};
// A choice whether a tissue stays whole where some planes cut; neither is chosen where that differs between them.
const exemption = (tissue, words, which) => {
  const spared = which.filter(({ scene }) => tissue.spared >> scene & 1).length;
  const made = el("input", { type: "checkbox", "data-name": `exempt ${words}`, ...(spared && spared === which.length ? { checked: "" } : {}) });
  made.indeterminate = spared > 0 && spared < which.length;
  made.addEventListener("change", () => spare(tissue, made.checked, which));
  return el("label", { class: "line" }, made, words);
};

// ---- tissueRows ----

const drawTissues = () => {
  const wanted = search.value.trim().toLowerCase();
  const shown = desk.state.tissues.filter((tissue) => tissue.name.toLowerCase().includes(wanted) || String(tissue.label) === wanted);
  banner.hidden = !solo;
  if (solo) banner.textContent = `Only ${tissueOf(solo.id)?.name} is shown.`;
  keepFocus(tissueRows, () => tissueRows.replaceChildren(...shown.map((tissue) => {
    const color = el("input", { type: "color", value: tissue.color, title: `Colour of ${tissue.name}`, "aria-label": `Colour of ${tissue.name}`, "data-name": `color${tissue.id}` });
    color.addEventListener("input", () => setTissue(tissue, "color", color.value, `color ${tissue.id}`));
    const seen = el("input", { type: "checkbox", title: `Show ${tissue.name}`, "aria-label": `Show ${tissue.name}`, "data-name": `seen${tissue.id}`, ...(tissue.visible ? { checked: "" } : {}) });
    seen.addEventListener("change", () => setTissue(tissue, "visible", seen.checked));
    const name = button(tissue.name, `Select ${tissue.name}`, () => selectTissue(tissue.id), { class: "name", "data-name": `name${tissue.id}`, "aria-pressed": tissue.id === selection.id });
    const only = button("solo", `Show only ${tissue.name}`, () => setSolo(tissue.id), { class: "small", "data-name": `solo${tissue.id}`, "aria-pressed": solo?.id === tissue.id });
    return el("li", { class: tissue.id === selection.id ? "selected" : "", "data-id": tissue.id }, seen, color, name, only);
  })));
  if (!shown.length) tissueRows.append(el("li", {}, "No tissue has this name."));
};

let slider = null; // the opacity that a hand moves just now
const drawDetail = (at) => {
  const tissue = tissueOf(selection.id);
  if (!tissue || slider) return;
  const opacity = el("input", { type: "range", min: 0, max: 1, step: 0.01, value: tissue.opacity, "aria-label": `Opacity of ${tissue.name}`, id: "opacity", "data-name": "opacity" });
  const number = el("output", {}, tissue.auto ? `${digits(tissue.opacity)} (automatic)` : digits(tissue.opacity));
  opacity.addEventListener("pointerdown", () => { slider = opacity; });
  opacity.addEventListener("pointerup", () => { slider = null; });
  opacity.addEventListener("input", () => {
    number.textContent = opacity.value;
    setTissue(tissue, "opacity", Number(opacity.value), `opacity ${tissue.id}`);
  });
  const auto = button("auto", "Opacity by thickness", () => setTissue(tissue, "opacity", "auto"), { "aria-pressed": tissue.auto, class: "small" });
  const cuts = planes();
  keepFocus(detail, () => detail.replaceChildren(el("h2", {}, el("i", { style: `background: ${tissue.color}` }), tissue.name),
    el("p", {}, `label ${tissue.label}${tissue.ml > 0 ? ` · ${digits(tissue.ml)} ml · ${digits(tissue.mm)} mm thick` : ""}`, at ? el("span", { id: "place" }, ` · at ${at.map((v) => v.toFixed(1)).join(", ")} mm`) : null),
    el("label", { class: "line" }, "Opacity", opacity, number, auto),
    el("div", { class: "line", role: "group" }, exemption(tissue, "stays whole where planes cut", cuts),
      cuts.length > 1 ? cuts.map((plane) => exemption(tissue, plane.name, [plane])) : [])));
};

search.addEventListener("input", drawTissues);
on("state", (state) => {
  // News from before it do not count.
  if (solo && !isMoving() && state.revision > solo.since && state.revision >= desk.revision && !solo.before.every(([key]) => state.tissues.some((t) => t.key === key && t.visible === (t.id === solo.id)))) solo = null;
  palette.value = state.job?.appearance ?? "table";
  drawTissues();
  drawDetail();
});
selection.listeners.push(() => { drawTissues(); drawDetail(); tissueRows.querySelector(".selected")?.scrollIntoView({ block: "nearest" }); });
onPick((found) => {
  selectTissue(found.id);
  if (found.id) drawDetail(found.at);
  else detail.replaceChildren();
});
