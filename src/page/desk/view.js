// SPDX-License-Identifier: BSD-3-Clause
// The picture, and what a hand does in it.
import { el } from "./dom.js";
import { desk, on, change, ask, isMoving } from "./server.js";
import { add, sub, scale, dot, cross, unit, rotate, length } from "./vector.js";
import { flow, keyed, prefix } from "./keys.js";

export const canvas = el("canvas", { id: "picture", tabindex: "0", role: "img", "aria-label": "The picture. Arrow keys turn it, plus and minus zoom, Shift with arrow keys moves it." });
export const layer = el("div", { id: "layer" });
const holder = el("div", { id: "holder" }, canvas, layer);

// ---- showing ----

on("picture", (picture, final) => {
  const context = canvas.getContext("2d");
  if (canvas.width !== desk.size[0] || canvas.height !== desk.size[1]) [canvas.width, canvas.height] = desk.size;
  context.imageSmoothingQuality = "high";
  context.clearRect(0, 0, canvas.width, canvas.height);
  context.drawImage(picture, 0, 0, canvas.width, canvas.height);
  picture.close();
  canvas.dataset.kind = final ? "final" : "sketch";
  canvas.dataset.revision = desk.view.revision;
});

const PIXELS_MOST = 2.2e6; // of a picture: more are hardly seen, and take their time
const fit = () => {
  const room = holder.parentElement.getBoundingClientRect();
  if (room.width < 16 || room.height < 16) return;
  const [w, h] = desk.state?.size ?? [16, 9];
  const shown = Math.min(room.width / w, room.height / h);
  const dense = Math.min(devicePixelRatio || 1, Math.sqrt(PIXELS_MOST / (shown * shown * w * h)));
  const size = [Math.max(16, Math.round(w * shown * dense)), Math.max(16, Math.round(h * shown * dense))];
  holder.style.width = `${size[0] / dense}px`;
  holder.style.height = `${size[1] / dense}px`;
  if (desk.size && desk.size[0] === size[0] && desk.size[1] === size[1]) return;
  desk.size = size;
  if (desk.state) change([], "");
};

// ---- the camera ----

const camera = () => `${prefix()}animation.camera.`;
// What a hand has done since the server told its state last.
let orbit = null;
export const now = () => {
  if (!orbit || (!isMoving() && desk.state.revision >= desk.revision)) orbit = structuredClone(desk.state.orbit);
  return orbit;
};

const set = (values, group) => {
  const kind = now().fixed ? "fixed." : "orbit.";
  const names = { angle: "orbit.angle", elevation: "orbit.elevation", target: `${kind}target_mm`, distance: "orbit.distance_mm",
    position: "fixed.position_mm", up: "fixed.up", zoom: "zoom" };
  const edits = [];
  for (const [name, value] of Object.entries(values)) {
    const plain = typeof value === "number" ? Number(value.toFixed(name === "zoom" ? 4 : 2)) : value.map((v) => Number(v.toFixed(name === "up" ? 5 : 2)));
    now()[name] = value;
    edits.push(keyed(camera() + names[name], typeof plain === "number" ? plain : flow(plain)));
  }
  change(edits, group);
};

const target = () => now().target;
const distance = () => {
  const c = desk.view.camera, o = now();
  if (o.fixed) return length(sub(c.position, o.target));
  return c.orthographic ? c.halfHeight * o.zoom / Math.tan(o.fov * Math.PI / 360) : o.distance;
};
// Half the height of what the picture shows at the target, in mm.
const reach = () => desk.view.camera.halfHeight * (desk.view.camera.orthographic ? 1 : length(sub(desk.view.camera.position, target())));

export const turn = (right, up, group = "turn") => {
  const o = now();
  if (!o.fixed) {
    set({ angle: o.angle - right, elevation: Math.max(-90, Math.min(90, o.elevation + up)) }, group);
    return;
  }
  const c = desk.view.camera, away = sub(o.position ?? c.position, o.target);
  const axis = o.up ?? c.up;
  const level = (v) => rotate(rotate(v, unit(axis), -right * Math.PI / 180), c.right, -up * Math.PI / 180);
  set({ position: add(o.target, level(away)) }, group);
};
export const pan = (x, y, group = "pan") => {
  const c = desk.view.camera, by = add(scale(c.right, -x * reach()), scale(c.up, y * reach()));
  if (now().fixed) set({ position: add(now().position ?? c.position, by), target: add(target(), by) }, group);
  else set({ target: add(target(), by), distance: distance() }, group);
};
// Zoom so that the point (x, y) of the picture, from its middle in halves of its height, stays.
export const zoom = (factor, x = 0, y = 0, group = "zoom") => {
  const o = now(), to = Math.max(0.01, Math.min(1000, o.zoom * factor));
  const share = 1 - o.zoom / to;
  if (o.fixed || (Math.abs(x) < 0.02 && Math.abs(y) < 0.02)) {
    set({ zoom: to }, group);
    return;
  }
  const c = desk.view.camera, by = add(scale(c.right, x * reach() * share), scale(c.up, -y * reach() * share));
  set({ zoom: to, target: add(target(), by), distance: distance() }, group);
};
// Look from a side: an angle about the patient and one above.
export const look = (angle, elevation) => set({ angle: angle - (desk.state.orbit.turned ?? 0), elevation }, "");

// ---- gestures ----

const place = (event) => {
  const box = canvas.getBoundingClientRect();
  return [(event.clientX - box.left - box.width / 2) / (box.height / 2), (event.clientY - box.top - box.height / 2) / (box.height / 2)];
};
export const pixel = (event) => {
  const box = canvas.getBoundingClientRect();
  return { x: (event.clientX - box.left) * canvas.width / box.width, y: (event.clientY - box.top) * canvas.height / box.height, size: desk.size };
};
let touches = new Map(), gesture = 0, moved = false;

const picked = [];
export const onPick = (listener) => picked.push(listener);
const pick = async (event, kind) => {
  const found = await ask("pick", pixel(event));
  if (found) picked.forEach((listener) => listener(found, kind, event));
};

canvas.addEventListener("pointerdown", (event) => {
  if (!desk.view) return;
  canvas.setPointerCapture(event.pointerId);
  touches.set(event.pointerId, place(event));
  gesture++;
  moved = false;
});
canvas.addEventListener("pointermove", (event) => {
  const before = touches.get(event.pointerId);
  if (!before || !desk.view) return;
  const here = place(event), x = here[0] - before[0], y = here[1] - before[1];
  if (!moved && Math.hypot(x, y) * canvas.clientHeight / 2 < 3) return;
  moved = true;
  touches.set(event.pointerId, here);
  if (touches.size > 1) {
    const other = [...touches].find(([id]) => id !== event.pointerId)[1];
    const factor = Math.hypot(here[0] - other[0], here[1] - other[1]) / Math.max(0.01, Math.hypot(before[0] - other[0], before[1] - other[1]));
    zoom(factor, other[0], other[1], `pinch ${gesture}`);
    pan(x / 2, y / 2, `pinch ${gesture}`);
  } else if (event.shiftKey || event.buttons & 6) {
    pan(x, y, `pan ${gesture}`);
  } else {
    turn(x * 90, y * 90, `turn ${gesture}`);
  }
});
const lift = (event) => {
  if (touches.delete(event.pointerId) && !moved && event.type === "pointerup") pick(event, "click");
};
canvas.addEventListener("pointerup", lift);
canvas.addEventListener("pointercancel", lift);
canvas.addEventListener("contextmenu", (event) => event.preventDefault());
let wheeled = 0;
canvas.addEventListener("wheel", (event) => {
  event.preventDefault();
  if (!desk.view) return;
  if (performance.now() - wheeled > 600) gesture++;
  wheeled = performance.now();
  zoom(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), ...place(event), `wheel ${gesture}`);
}, { passive: false });
canvas.addEventListener("dblclick", async (event) => {
  const found = await ask("pick", pixel(event));
  if (!found?.id) return;
  const by = sub(found.at, target());
  if (now().fixed) set({ target: found.at, position: add(now().position ?? desk.view.camera.position, by) }, "");
  else set({ target: found.at, distance: distance() }, "");
});
canvas.addEventListener("keydown", (event) => {
  const step = event.ctrlKey ? 1 : 5, way = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
  if (!desk.view) return;
  if (way && event.shiftKey) pan(way[0] * step / 50, way[1] * step / 50, "keys");
  else if (way) turn(way[0] * step, way[1] * step, "keys");
  else if (event.key === "+" || event.key === "=") zoom(1.1, 0, 0, "keys");
  else if (event.key === "-") zoom(1 / 1.1, 0, 0, "keys");
  else return;
  event.preventDefault();
});

// ---- where a point is in the picture ----

// A point in RAS mm, as pixels of the layer over the picture; null: behind the eye.
export const project = (point) => {
  const c = desk.view.camera, way = sub(point, c.position), deep = dot(way, c.forward);
  if (!c.orthographic && deep <= 0) return null;
  const half = layer.clientHeight / 2, px = half / (c.halfHeight * (c.orthographic ? 1 : deep));
  return [layer.clientWidth / 2 + dot(way, c.right) * px, half - dot(way, c.up) * px];
};
// How many mm a pixel of the layer is at a point.
export const perPixel = (point) => {
  const c = desk.view.camera;
  return 2 * c.halfHeight * (c.orthographic ? 1 : Math.max(1e-6, dot(sub(point, c.position), c.forward))) / layer.clientHeight;
};

export const placePicture = (where) => {
  where.append(holder);
  new ResizeObserver(fit).observe(where);
  on("state", fit);
  fit();
};
