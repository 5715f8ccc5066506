// SPDX-License-Identifier: BSD-3-Clause
// Three slices beside the picture, which meet in one point.
import { el, svg } from "./dom.js";
import { desk, on, post } from "./server.js";
import { add, sub, scale, dot } from "./vector.js";
import { seenPlanes, movePlane } from "./cut.js";

const NAMES = ["transverse", "coronal", "sagittal"], AXES = [2, 1, 0], LETTERS = ["RLAP", "RLSI", "APSI"];
const COLORS = ["#d04034", "#34963e", "#2c68ce"];
let point = null;
const slices = NAMES.map((name, which) => {
  const canvas = el("canvas", {}), lines = svg("svg", { "aria-hidden": "true" });
  const box = el("figure", { class: "slice", tabindex: 0, role: "slider", "aria-label": `${name} slice`, style: `--own: ${COLORS[which]}` }, canvas, lines,
    el("figcaption", {}, name), ...[..."lrtb"].map((side, i) => el("b", { class: `letter ${side}` }, LETTERS[which][i])));
  return { which, name, canvas, lines, box, view: null, busy: false, again: false, shown: "" };
});
export const slicePanel = el("section", { id: "slices", "aria-label": "Three slices" }, slices.map((slice) => slice.box));

// ---- drawing ----

const load = async (slice) => {
  const box = slice.box.getBoundingClientRect();
  if (box.width < 40 || box.height < 40 || !desk.state || !point) return;
  const dense = Math.min(2, devicePixelRatio || 1), size = [Math.round(box.width * dense), Math.round(box.height * dense)];
  const wanted = `${desk.revision} ${size} ${point[AXES[slice.which]].toFixed(2)}`;
  if (wanted === slice.shown) return;
  if (slice.busy) { slice.again = true; return; }
  slice.busy = true;
  try {
    const answer = await post("slice", { which: slice.which, size, point });
    if (answer.headers.has("X-View")) {
      slice.view = JSON.parse(answer.headers.get("X-View"));
      slice.shown = wanted;
      const picture = await createImageBitmap(await answer.blob());
      [slice.canvas.width, slice.canvas.height] = size;
      slice.canvas.getContext("2d").drawImage(picture, 0, 0);
      picture.close();
      drawLines(slice);
    }
  } catch { /* the poll tells it */ }
  slice.busy = false;
  if (slice.again) { slice.again = false; load(slice); }
};
const loadAll = () => slices.forEach(load);

// ---- places ----

const scaleOf = (slice) => slice.box.clientHeight / (2 * slice.view.camera.halfHeight);
const toPixel = (slice, at) => {
  const c = slice.view.camera, way = sub(at, c.position), px = scaleOf(slice);
  return [slice.box.clientWidth / 2 + dot(way, c.right) * px, slice.box.clientHeight / 2 - dot(way, c.up) * px];
};
const toPoint = (slice, x, y) => {
  const c = slice.view.camera, px = scaleOf(slice);
  const at = add(c.position, add(scale(c.right, (x - slice.box.clientWidth / 2) / px), scale(c.up, (slice.box.clientHeight / 2 - y) / px)));
  return at.map((v, i) => (i === AXES[slice.which] ? point[i] : v));
};
const limit = (at) => at.map((v, i) => Math.max(desk.state.low[i], Math.min(desk.state.high[i], v)));

const drawLines = (slice) => {
  if (!slice.view || !point) return;
  const { clientWidth: w, clientHeight: h } = slice.box, [x, y] = toPixel(slice, point), c = slice.view.camera;
  const upright = slices.find((other) => Math.abs(c.right[AXES[other.which]]) > 0.5).which, level = slices.find((other) => Math.abs(c.up[AXES[other.which]]) > 0.5).which;
  const cuts = seenPlanes().flatMap(({ seen }) => {
    const n = [dot(seen.normal, c.right), dot(seen.normal, c.up)], size = Math.hypot(...n);
    if (size < 1e-3) return [];
    const from = limitOnSlice(slice, seen, n, size), way = [-n[1] / size, n[0] / size], far = 2 * (w + h);
    return [svg("line", { x1: from[0] - way[0] * far, y1: from[1] + way[1] * far, x2: from[0] + way[0] * far, y2: from[1] - way[1] * far, class: "cut" })];
  });
  slice.lines.replaceChildren(...cuts,
    svg("line", { x1: x, x2: x, y1: 0, y2: h, stroke: COLORS[upright] }), svg("line", { x1: 0, x2: w, y1: y, y2: y, stroke: COLORS[level] }));
  slice.box.setAttribute("aria-valuenow", point[AXES[slice.which]].toFixed(1));
  slice.box.setAttribute("aria-valuetext", `${point[AXES[slice.which]].toFixed(1)} mm`);
  slice.box.querySelector("figcaption").textContent = `${slice.name} ${point[AXES[slice.which]].toFixed(1)} mm`;
};
// The pixel of the line of a plane that is nearest to the cross-hair.
const limitOnSlice = (slice, seen, n, size) => {
  const away = (dot(seen.normal, point) + seen.offset) / (size * size), px = scaleOf(slice), [x, y] = toPixel(slice, point);
  return [x - n[0] * away * px, y + n[1] * away * px];
};

// ---- hands ----

const setPoint = (at) => {
  point = limit(at);
  slices.forEach(drawLines);
  loadAll();
};
slices.forEach((slice) => {
  const axis = AXES[slice.which];
  let held = null;
  const at = (event) => { const box = slice.box.getBoundingClientRect(); return [event.clientX - box.left, event.clientY - box.top]; };
  slice.box.addEventListener("pointerdown", (event) => {
    if (!slice.view) return;
    slice.box.setPointerCapture(event.pointerId);
    const here = at(event), c = slice.view.camera;
    // A plane whose line is near is taken; else the cross-hair.
    held = seenPlanes().find(({ seen }) => {
      const n = [dot(seen.normal, c.right), dot(seen.normal, c.up)], size = Math.hypot(...n);
      return size > 0.1 && Math.abs(dot(seen.normal, toPoint(slice, ...here)) + seen.offset) / size * scaleOf(slice) < 6;
    }) ?? "cross";
    if (held === "cross") setPoint(toPoint(slice, ...here));
    else held = { ...held, group: `slice ${performance.now()}` };
  });
  slice.box.addEventListener("pointermove", (event) => {
    if (!held) return;
    const there = toPoint(slice, ...at(event));
    if (held === "cross") setPoint(there);
    else movePlane(held.plane, dot(held.seen.normal, there), held.group);
  });
  const drop = () => { held = null; };
  slice.box.addEventListener("pointerup", drop);
  slice.box.addEventListener("pointercancel", drop);
  const step = (by) => setPoint(point.map((v, i) => (i === axis ? v + by : v)));
  slice.box.addEventListener("wheel", (event) => { event.preventDefault(); if (point) step(-Math.sign(event.deltaY) * (event.shiftKey ? 5 : 1)); }, { passive: false });
  slice.box.addEventListener("keydown", (event) => {
    const by = { ArrowUp: 1, ArrowRight: 1, ArrowDown: -1, ArrowLeft: -1, PageUp: 10, PageDown: -10 }[event.key];
    if (!by || !point) return;
    step(by);
    event.preventDefault();
  });
  new ResizeObserver(() => { drawLines(slice); load(slice); }).observe(slice.box);
});
on("state", (state) => {
  point ??= scale(add(state.low, state.high), 0.5);
  slices.forEach((slice) => {
    slice.box.setAttribute("aria-valuemin", state.low[AXES[slice.which]].toFixed(1));
    slice.box.setAttribute("aria-valuemax", state.high[AXES[slice.which]].toFixed(1));
  });
});
on("picture", (picture, final) => { slices.forEach(drawLines); if (final) loadAll(); });
export const goTo = (at) => { if (at) setPoint(at); };
