// SPDX-License-Identifier: BSD-3-Clause
// The film: its length, the place at which it is looked at, key frames, ready moves, playing.
import { el } from "./dom.js";
import { desk, on, change, isMoving, say } from "./server.js";
import { flow, given, here, isTime, isTrack, keyAt, prefix, timeOf, timeText, trackText } from "./keys.js";
import { button, choice, field } from "./parts.js";
import { selection, tissueOf } from "./tissues.js";
import { now } from "./view.js";

const EASES = ["linear", "smooth", "in", "out", "in-out", "hold"];

// ---- place and length ----

const head = el("input", { type: "range", min: 0, step: 1, id: "playhead", "aria-label": "Frame" });
const clock = el("output", { id: "clock" });
head.addEventListener("input", () => { stop(); go(+head.value); });
const go = (frame) => {
  desk.state.frame = frame;
  drawClock();
  change([], "", frame);
};
const drawClock = () => {
  const { frame, frames, fps } = desk.state;
  head.max = frames - 1;
  head.value = frame;
  clock.textContent = `${(frame / fps).toFixed(2)} s · ${frame} of ${frames}`;
  cursor.style.left = `${100 * here()}%`;
};
const frames = el("input", { type: "text", size: 6, id: "length" });
frames.addEventListener("change", () => change([[`${prefix()}animation.frames`, frames.value]]));

// ---- playing ----

let playing = 0;
const stop = () => { playing = 0; play.textContent = "▶"; };
const play = button("▶", "Play or stop", () => {
  if (playing) { stop(); return; }
  playing = performance.now() - 1000 * (desk.state.frame >= desk.state.frames - 1 ? 0 : desk.state.frame) / desk.state.fps;
  play.textContent = "■";
  step();
});
const step = () => {
  if (!playing) return;
  const at = Math.floor((performance.now() - playing) / 1000 * desk.state.fps);
  if (at >= desk.state.frames) { go(desk.state.frames - 1); stop(); return; }
  if (!isMoving() && at !== desk.state.frame) go(at);
  setTimeout(step, 8);
};

// ---- tracks ----

const trackRows = el("div", { id: "tracks" });
const cursor = el("div", { id: "cursor" });
const titles = [[/camera\.(orbit|fixed)\.(.*)$/, "camera $2"], [/camera\.(.*)$/, "camera $1"], [/clip\[(\d+)\]\.(.*)$/, (_, i, key) => `plane ${+i + 1} ${key}`],
  [/tissues\."?(.*?)"?\.(\w+)$/, "$1 $2"], [/^animation\./, ""]];
const titleOf = (path) => {
  for (const [pattern, words] of titles) if (pattern.test(path)) return path.replace(new RegExp(`^.*?${pattern.source}`), words).replace(/_mm$/, "").replace(/_/g, " ");
  return path;
};
// All values of the job that have key frames: [path, track].
const tracksIn = (node, path, out = []) => {
  if (Array.isArray(node)) node.forEach((item, i) => tracksIn(item, `${path}[${i}]`, out));
  else if (isTrack(node)) {
    const names = Object.keys(node), times = names.filter(isTime);
    if (times.length && times.length >= names.length - 1) out.push([path, node]);
    else for (const name of names) tracksIn(node[name], path ? `${path}.${/^\w+$/.test(name) ? name : `"${name}"`}` : name, out);
  }
  return out;
};
let chosen = null; // { path, time }
const write = (path, track, group = "") => change([[path, trackText(track)]], group);

const drawKey = (path, track, time) => {
  const share = timeOf(time);
  const key = el("button", { type: "button", class: "key", style: `left: ${100 * share}%`, title: `${titleOf(path)} at ${time}`, "aria-label": `Key of ${titleOf(path)} at ${time}`, "aria-pressed": chosen?.path === path && chosen.time === time });
  let drag = null;
  key.addEventListener("pointerdown", (event) => { key.setPointerCapture(event.pointerId); drag = { x: event.clientX, to: share }; });
  key.addEventListener("pointermove", (event) => {
    if (!drag) return;
    drag.to = Math.max(0, Math.min(1, share + (event.clientX - drag.x) / key.parentElement.clientWidth));
    key.style.left = `${100 * drag.to}%`;
  });
  const drop = () => {
    const to = drag?.to;
    drag = null;
    if (to === undefined || Math.abs(to - share) * key.parentElement.clientWidth < 3) { choose(path, time); return; }
    moveKey(path, track, time, to);
  };
  key.addEventListener("pointerup", drop);
  key.addEventListener("keydown", (event) => {
    const by = { ArrowLeft: -0.01, ArrowRight: 0.01 }[event.key];
    if (by) moveKey(path, track, time, Math.max(0, Math.min(1, share + by)));
    else if (event.key === "Delete" || event.key === "Backspace") removeKey(path, track, time);
    else if (event.key === "Enter" || event.key === " ") choose(path, time);
    else return;
    event.preventDefault();
  });
  return key;
};
const moveKey = (path, track, time, to) => {
  const { [time]: value, ...rest } = track, text = timeText(to);
  chosen = { path, time: text };
  write(path, { ...rest, [text]: value });
};
const removeKey = (path, track, time) => {
  const { [time]: value, ...rest } = track;
  chosen = null;
  const left = Object.keys(rest).filter(isTime);
  if (left.length) write(path, rest);
  else change([[path, flow(isTrack(value) ? value.value : value)]]);
};
const choose = (path, time) => {
  chosen = { path, time };
  go(Math.round(timeOf(time) * (desk.state.frames - 1)));
  drawTracks();
};

const editor = el("div", { class: "line", id: "key" });
const drawEditor = () => {
  const track = chosen && given(chosen.path), entry = isTrack(track) ? track[chosen.time] : undefined;
  if (entry === undefined) { editor.replaceChildren(); return; }
  const value = el("input", { type: "text", size: 12, value: flow(isTrack(entry) ? entry.value : entry), "aria-label": "Value of the key" });
  const set = (next) => write(chosen.path, { ...track, [chosen.time]: next });
  value.addEventListener("change", () => change([[chosen.path, trackText({ ...track, [chosen.time]: "@@" }).replace('"@@"', isTrack(entry) ? flow({ ...entry, value: "@@" }).replace('"@@"', value.value) : value.value)]]));
  const ease = choice("Ease of the way to this key", EASES.filter((word) => word !== "hold").map((word) => [word, word]), (word) => set({ value: isTrack(entry) ? entry.value : entry, ease: word }), isTrack(entry) ? entry.ease ?? "linear" : "linear");
  editor.replaceChildren(el("strong", {}, titleOf(chosen.path)), ` at ${chosen.time} `, field("value", value), field("ease", ease),
    button("remove key", "Remove this key", () => removeKey(chosen.path, track, chosen.time), { class: "small" }));
};

// A verb of the animation as a bar.
const drawVerb = (verb, i) => {
  const name = Object.keys(verb).find((key) => !["during", "ease", "to", "order", "stagger", "times", "elevation", "soft", "through", "ahead", "at"].includes(key)) ?? "verb";
  const [begin, end] = (verb.during ?? ["0%", "100%"]).map((time) => timeOf(String(time)));
  const list = `${prefix()}animation.verbs`;
  return el("div", { class: "track" }, el("span", { title: `${name}` }, `${name} ${[verb[name]].flat().join(", ")}`),
    el("div", { class: "way" }, el("i", { style: `left: ${100 * begin}%; width: ${Math.max(0.5, 100 * (end - begin))}%` })),
    button("×", `Remove ${name}`, () => change([[list, flow(given(list).filter((_, k) => k !== i))]]), { class: "small" }));
};
const drawTracks = () => {
  const root = desk.state.job;
  if (!root) return;
  const own = prefix() ? root.shots[desk.state.shot] : root;
  const found = tracksIn({ light: own.light, render: own.render, tissues: own.tissues, animation: { ...own.animation, verbs: undefined } }, "").map(([path, track]) => [prefix() + path, track]);
  trackRows.replaceChildren(...found.map(([path, track]) => el("div", { class: "track" }, el("span", { title: path }, titleOf(path.slice(prefix().length))),
    el("div", { class: "way" }, Object.keys(track).filter(isTime).map((time) => drawKey(path, track, time))))), ...(own.animation?.verbs ?? []).map(drawVerb));
  drawEditor();
};

// ---- setting keys ----

// What can get a key: its path, and its value now.
const settable = () => {
  const o = now(), camera = `${prefix()}animation.camera.`, r = (v) => Array.isArray(v) ? v.map((x) => Number(x.toFixed(2))) : Number(v.toFixed(4));
  const all = { zoom: [["zoom", o.zoom]], view: o.fixed ? [["fixed.position_mm", desk.view.camera.position], ["fixed.target_mm", o.target]] : [["orbit.angle", o.angle], ["orbit.elevation", o.elevation]],
    centre: [[o.fixed ? "fixed.target_mm" : "orbit.target_mm", o.target]] };
  const out = Object.fromEntries(Object.entries(all).map(([name, list]) => [name, list.map(([key, value]) => [camera + key, r(value)])]));
  const tissue = tissueOf(selection.id);
  if (tissue) {
    out["opacity of the tissue"] = [[`${prefix()}tissues.${tissue.key}.opacity`, r(tissue.opacity)]];
    out["visible or not"] = [[`${prefix()}tissues.${tissue.key}.visible`, tissue.visible]];
  }
  (given(`${prefix()}animation.clip`) ?? []).forEach((plane, i) => {
    const seen = desk.view.planes.find((one) => one.index === i);
    if (!plane.box && seen) out[`plane ${i + 1}`] = [[`${prefix()}animation.clip[${i}].at`, `${(-seen.offset).toFixed(1)} mm`]];
  });
  return out;
};
// Where there are no key frames yet, the first key is at the place that is looked at, and alone.
const setKey = (name) => {
  const edits = (settable()[name] ?? []).map(([path, value]) => {
    const old = given(path), track = isTrack(old) ? old : {};
    const at = keyAt(track) ?? timeText(here()), before = track[at];
    return [path, trackText({ ...track, [at]: isTrack(before) ? { ...before, value } : value })];
  });
  if (name === "view" && !desk.state.orbit.fixed && desk.state.orbit.turns) {
    edits.push([`${prefix()}animation.camera.orbit.turns`, 0]);
    edits[0][1] = edits[0][1].replace(/: (-?[\d.]+)(?=[^:]*$)/, (_, v) => `: ${Number((+v + desk.state.orbit.turned).toFixed(2))}`);
  }
  if (edits.length) change(edits);
};
const what = choice("What gets a key", [["view", "view"]], () => {});
const drawWhat = () => {
  if (!desk.state || !desk.view) return;
  const names = Object.keys(settable());
  if (names.join() === [...what.options].map((option) => option.value).join()) return;
  const value = what.value;
  what.replaceChildren(...names.map((name) => el("option", { value: name }, name)));
  what.value = names.includes(value) ? value : names[0];
};

// ---- ready moves ----

const addVerb = (verb) => {
  const list = given(`${prefix()}animation.verbs`) ?? [];
  change([list.length ? [`${prefix()}animation.verbs[${list.length}]`, flow(verb)] : [`${prefix()}animation.verbs`, flow([verb])]]);
};
const during = () => { const at = here() < 0.9 ? here() : 0; return [timeText(at), timeText(Math.min(1, at + 0.4))]; };
const named = () => {
  const tissue = tissueOf(selection.id);
  if (!tissue) say("Select a tissue first.", "warn");
  return tissue && [tissue.key.startsWith('"') ? tissue.name : tissue.label];
};
const MOVES = {
  "turn once": () => change([[`${prefix()}animation.camera.orbit.turns`, 1]]),
  "stand still": () => change([[`${prefix()}animation.camera.orbit.turns`, 0]]),
  rock: () => addVerb({ rock: 20, during: during() }),
  "sweep a plane": () => {
    const entry = { normal: "posterior", at: { "0%": "0%", "100%": "50%", ease: "smooth" } }, list = given(`${prefix()}animation.clip`) ?? [];
    change([list.length ? [`${prefix()}animation.clip[${list.length}]`, flow(entry)] : [`${prefix()}animation.clip`, flow([entry])]]);
  },
  "frame the tissue": () => named() && addVerb({ frame: named(), during: during() }),
  "fly through the tissue": () => named() && addVerb({ fly: named(), during: during() }),
  "fade the tissue": () => named() && addVerb({ fade: named(), to: 0.1, during: during() }),
  "tissues appear": () => addVerb({ appear: ["*"], order: "largest", during: ["0%", "60%"] }),
};
const moves = choice("Ready moves", [["", "ready moves …"], ...Object.keys(MOVES).map((name) => [name, name])], (name, select) => { MOVES[name]?.(); select.value = ""; });

export const filmPanel = el("section", { id: "timeline", "aria-label": "The film" },
  el("div", { class: "line" }, play, head, clock, field("length", frames)),
  el("div", { class: "line" }, button("◆ set a key", "Set a key of this at the place that is looked at", () => setKey(what.value)), what, moves, editor),
  el("div", { id: "lanes" }, trackRows, el("div", { class: "track", id: "ruler", "aria-hidden": "true" }, el("span", {}), el("div", { class: "way" }, cursor))));
on("state", (state) => {
  if (!playing) drawClock();
  if (document.activeElement !== frames) frames.value = given(`${prefix()}animation.frames`) ?? state.frames;
  drawWhat();
  drawTracks();
});
selection.listeners.push(drawWhat);
on("picture", drawWhat);
addEventListener("keydown", (event) => {
  if (event.key === " " && event.target === document.body) { play.click(); event.preventDefault(); }
});
