// SPDX-License-Identifier: BSD-3-Clause
// Planes that cut: their list, and their handles in the picture.
import { el, svg } from "./dom.js";
import { desk, on, change } from "./server.js";
import { add, sub, scale, dot, cross, unit, length } from "./vector.js";
import { addTo, flow, given, keyed, planes, prefix } from "./keys.js";
import { button, choice, keepFocus } from "./parts.js";
import { layer, project, perPixel } from "./view.js";

const WORDS = { right: [1, 0, 0], left: [-1, 0, 0], anterior: [0, 1, 0], posterior: [0, -1, 0], superior: [0, 0, 1], inferior: [0, 0, -1] };
const clip = () => `${prefix()}animation.clip`;
const entries = () => given(clip()) ?? [];
const rounded = (v, decimals = 4) => v.map((x) => Number(x.toFixed(decimals)));
const millimetres = (mm) => `${mm.toFixed(1)} mm`;
const seenAs = (plane) => desk.view?.planes.find((seen) => !plane.entry.box && seen.index === plane.scene);
const middle = () => scale(add(desk.state.low, desk.state.high), 0.5);
// The point of a plane at which its handle is: that which is nearest to the middle of what is visible.
const anchor = (seen) => sub(middle(), scale(seen.normal, dot(seen.normal, middle()) + seen.offset));
const extent = (normal) => {
  const half = scale(sub(desk.state.high, desk.state.low), 0.5);
  const reach = Math.abs(normal[0]) * half[0] + Math.abs(normal[1]) * half[1] + Math.abs(normal[2]) * half[2];
  return [dot(normal, middle()) - reach, dot(normal, middle()) + reach];
};

// ---- changes ----

const addPlane = (normal) => addTo(clip(), { normal, at: "50%" });
export const movePlane = (plane, mm, group) => change([keyed(`${clip()}[${plane.i}].at`, millimetres(mm))], group);
const turnPlane = (plane, normal, point, group) => change([
  keyed(`${clip()}[${plane.i}].normal`, flow(rounded(unit(normal)))), keyed(`${clip()}[${plane.i}].at`, millimetres(dot(unit(normal), point)))], group);
const removePlane = (plane) => change([[clip(), flow(entries().filter((_, i) => i !== plane.i))]]);

// ---- the list ----

const list = el("ul", { class: "rows", id: "planes" });
const mode = choice("What several planes cut", [["keep", "Keep what all planes keep"], ["cut", "Cut away only what every plane removes"]],
  (value) => change([[`${prefix()}animation.clip_mode`, value]]));
export const cutPanel = el("section", { class: "panel" },
  el("div", { class: "line", role: "group", "aria-label": "Add a plane" }, "Add",
    button("left | right", "Add a sagittal plane", () => addPlane("left")),
    button("front | back", "Add a coronal plane", () => addPlane("posterior")),
    button("head | feet", "Add a transverse plane", () => addPlane("inferior")),
    button("box", "Add a box", () => addBox()),
    button("facing", "Add a plane that faces the viewer", () => addPlane(rounded(desk.view.camera.forward)))),
  mode, list,
  el("p", { class: "hint" }, "In the picture: drag the round handle to move a plane, its arrow to turn it."));

const wordOf = (normal) => Object.entries(WORDS).find(([, v]) => dot(v, normal) > 0.9999)?.[0] ?? "any";
// A box, whose corners are shares of what is visible, with a slider for each side.
const drawBox = (plane) => {
  const corners = plane.entry.box, shares = corners.flat().every((value) => /%$/.test(String(value)));
  return el("li", {}, el("div", { class: "line" }, el("strong", {}, plane.name), button("remove", `Remove ${plane.name}`, () => removePlane(plane), { class: "small" })),
    ...(shares ? ["left – right", "back – front", "feet – head"] : []).map((words, axis) => el("div", { class: "line" }, el("span", { class: "hint" }, words), corners.map((corner, end) => {
      const side = el("input", { type: "range", min: 0, max: 100, step: 1, value: parseFloat(corner[axis]), "aria-label": `Box, ${words}, ${end ? "end" : "begin"}`, "data-name": `box${plane.i}${axis}${end}` });
      side.addEventListener("input", () => {
        const next = corners.map((one) => [...one]), other = parseFloat(corners[1 - end][axis]);
        next[end][axis] = `${end ? Math.max(+side.value, other + 1) : Math.min(+side.value, other - 1)}%`;
        change([[`${clip()}[${plane.i}].box`, flow(next)]], `box ${plane.i} ${axis} ${end}`);
      });
      return side;
    }))));
};
const addBox = () => addTo(clip(), { box: [["20%", "20%", "20%"], ["80%", "80%", "80%"]] });
const drawPlane = (plane) => {
  const seen = seenAs(plane), { name } = plane;
  if (plane.entry.box) return drawBox(plane);
  const active = el("input", { type: "checkbox", "aria-label": `${name} cuts`, title: `${name} cuts`, "data-name": `active${plane.i}`, ...(seen ? { checked: "" } : {}) });
  active.addEventListener("change", () => change([keyed(`${clip()}[${plane.i}].active`, active.checked)]));
  const head = el("div", { class: "line" }, active, el("strong", {}, name));
  if (!seen) return el("li", {}, head, button("remove", `Remove ${name}`, () => removePlane(plane), { class: "small" }));
  const [low, high] = extent(seen.normal);
  const at = el("input", { type: "range", min: low.toFixed(1), max: high.toFixed(1), step: 0.1, value: (-seen.offset).toFixed(1), "aria-label": `Position of ${name}`, "data-name": `at${plane.i}` });
  const mm = el("output", {}, millimetres(-seen.offset));
  at.addEventListener("input", () => { mm.textContent = millimetres(+at.value); movePlane(plane, +at.value, `at ${plane.i}`); });
  const side = choice(`What ${name} keeps`, [...Object.keys(WORDS), "any"].map((word) => [word, word === "any" ? "any angle" : `keeps ${word}`]),
    (word) => word !== "any" && change([keyed(`${clip()}[${plane.i}].normal`, word), keyed(`${clip()}[${plane.i}].at`, millimetres(dot(WORDS[word], anchor(seen))))]), wordOf(seen.normal));
  side.dataset.name = `side${plane.i}`;
  head.append(side,
    button("flip", `Flip ${name}`, () => {
      const back = scale(seen.normal, -1), word = wordOf(back);
      change([keyed(`${clip()}[${plane.i}].normal`, word === "any" ? flow(rounded(back)) : word), keyed(`${clip()}[${plane.i}].at`, millimetres(seen.offset))]);
    }, { class: "small", "data-name": `flip${plane.i}` }),
    button("remove", `Remove ${name}`, () => removePlane(plane), { class: "small" }));
  return el("li", {}, head, el("div", { class: "line" }, at, mm));
};
const drawList = () => {
  if (!desk.state || list.contains(document.activeElement) && document.activeElement.matches(":active")) return;
  mode.hidden = entries().length < 2;
  mode.value = given(`${prefix()}animation.clip_mode`) ?? "keep";
  keepFocus(list, () => list.replaceChildren(...planes().map(drawPlane)));
};

// ---- handles ----

const handles = svg("svg", { id: "handles", "aria-hidden": "true" });
layer.append(handles);
let held = null; // { plane, kind, ... } while a hand drags
const ARROW_PX = 64;
const drawHandles = () => {
  if (!desk.state || !desk.view) return;
  handles.replaceChildren(...planes().flatMap((plane) => {
    const seen = seenAs(plane);
    const at = seen && project(anchor(seen));
    if (!at) return [];
    const tip = project(add(anchor(seen), scale(seen.normal, ARROW_PX * perPixel(anchor(seen)))));
    if (!tip) return [];
    return [svg("line", { x1: at[0], y1: at[1], x2: tip[0], y2: tip[1], class: "shaft" }),
      svg("circle", { cx: at[0], cy: at[1], r: 10, class: "grip", "data-plane": plane.i, "data-kind": "move" }),
      svg("circle", { cx: tip[0], cy: tip[1], r: 7, class: "tip", "data-plane": plane.i, "data-kind": "turn" })];
  }));
};
let drags = 0;
handles.addEventListener("pointerdown", (event) => {
  const { plane, kind } = event.target.dataset;
  if (!kind) return;
  event.preventDefault();
  handles.setPointerCapture(event.pointerId);
  const found = planes().find((one) => one.i === +plane), seen = seenAs(found);
  held = { plane: found, kind, seen, at: anchor(seen), from: [event.clientX, event.clientY], group: `plane ${++drags}` };
});
handles.addEventListener("pointermove", (event) => {
  if (!held) return;
  const c = desk.view.camera, { seen, at } = held, mm = perPixel(at);
  const by = add(scale(c.right, (event.clientX - held.from[0]) * mm), scale(c.up, (held.from[1] - event.clientY) * mm));
  if (held.kind === "move") {
    // As far along the normal as the hand has gone along what is seen of it; towards the viewer, upwards.
    const across = sub(seen.normal, scale(c.forward, dot(seen.normal, c.forward)));
    const way = length(across) > 0.1 ? dot(by, unit(across)) / Math.max(0.5, length(across)) : dot(by, c.up) * -Math.sign(dot(seen.normal, c.forward));
    movePlane(held.plane, -seen.offset + way, held.group);
    return;
  }
  const arm = ARROW_PX * mm, flat = add(scale(sub(seen.normal, scale(c.forward, dot(seen.normal, c.forward))), arm), by);
  const deep = Math.sqrt(Math.max(0, arm * arm - dot(flat, flat))) * (dot(seen.normal, c.forward) > 0 ? 1 : -1);
  turnPlane(held.plane, add(flat, scale(c.forward, deep)), at, held.group);
});
const release = () => { held = null; };
handles.addEventListener("pointerup", release);
handles.addEventListener("pointercancel", release);

on("state", () => { drawList(); drawHandles(); });
on("view", drawHandles);
new ResizeObserver(drawHandles).observe(layer);

// What slices show of the planes: [normal, offset, entry].
export const seenPlanes = () => planes().filter(seenAs).map((plane) => ({ plane, seen: seenAs(plane) }));
