// SPDX-License-Identifier: BSD-3-Clause
// The film: its length, the place at which it is looked at, key frames, ready moves, playing.
import { el } from "./dom.js";
import { desk, on, change, isMoving, post, say } from "./server.js";
import { addTo, flow, given, here, isTime, isTrack, keyAt, prefix, timeOf, timeText, trackText } from "./keys.js";
import { button, choice, dialog, field, keepFocus } from "./parts.js";
import { nameInJob, selection, tissueOf } from "./tissues.js";
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

// ---- sheet ----

const SHEET_MOST = 12, SHEET_PIXELS = 320 * 180;
// Small pictures of frames from all of the film, one after the other; each leads to its frame.
const showSheet = async () => {
  const { frames, fps, size } = desk.state, count = Math.min(SHEET_MOST, frames), small = Math.min(1, Math.sqrt(SHEET_PIXELS / (size[0] * size[1])));
  const cells = Array.from({ length: count }, (_, i) => Math.round(i * (frames - 1) / Math.max(1, count - 1))).map((frame) => {
    const picture = el("img", { alt: "", width: Math.max(16, Math.round(size[0] * small)), height: Math.max(16, Math.round(size[1] * small)) });
    return { frame, picture, cell: button(picture, `Go to frame ${frame}`, () => { box.close(); go(frame); }, { class: "cell" }) };
  });
  cells.forEach(({ frame, cell }) => cell.append(el("span", {}, `${frame} · ${(frame / fps).toFixed(2)} s`)));
  const box = dialog("The film", el("div", { id: "sheet" }, cells.map(({ cell }) => cell)), el("div", { class: "line end" }, button("Close", "Close", () => box.close())));
  for (const { frame, picture } of cells) {
    const answer = box.open && await post("sheet", { frame, size: [picture.width, picture.height] });
    if (!answer || answer.headers.get("Content-Type") !== "image/png") return;
    picture.src = URL.createObjectURL(await answer.blob());
    picture.onload = () => URL.revokeObjectURL(picture.src);
  }
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

// Let a button be dragged along its way, or moved by arrow keys, within limits: show(to) while it is dragged, drop(to) then.
const slides = (part, share, [low, high], show, drop, act, remove) => {
  const within = (to) => Math.max(low, Math.min(high, to));
  let held = null;
  part.addEventListener("pointerdown", (event) => { part.setPointerCapture(event.pointerId); held = { x: event.clientX, to: share }; });
  part.addEventListener("pointermove", (event) => {
    if (!held) return;
    held.to = within(share + (event.clientX - held.x) / part.parentElement.clientWidth);
    show(held.to);
  });
  part.addEventListener("pointerup", () => {
    const to = held?.to ?? share;
    held = null;
    if (Math.abs(to - share) * part.parentElement.clientWidth < 3) act();
    else drop(to);
  });
  part.addEventListener("keydown", (event) => {
    const by = { ArrowLeft: -0.01, ArrowRight: 0.01 }[event.key];
    if (by) drop(within(share + by));
    else if (event.key === "Delete" || event.key === "Backspace") remove();
    else if (event.key === "Enter" || event.key === " ") act();
    else return;
    event.preventDefault();
  });
};
const drawKey = (path, track, time, i) => {
  const share = timeOf(time);
  const key = el("button", { type: "button", class: "key", style: `left: ${100 * share}%`, title: `${titleOf(path)} at ${time}`, "aria-label": `Key of ${titleOf(path)} at ${time}`, "aria-pressed": chosen?.path === path && chosen.time === time, "data-name": `${path} ${i}` });
  slides(key, share, [0, 1], (to) => { key.style.left = `${100 * to}%`; }, (to) => moveKey(path, track, time, to),
    () => choose(path, time), () => removeKey(path, track, time));
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

// A verb of the animation as a bar, which is dragged in time; so are its ends.
const drawVerb = (verb, i) => {
  const name = Object.keys(verb).find((key) => !["during", "ease", "to", "order", "stagger", "times", "elevation", "soft", "through", "ahead", "at"].includes(key)) ?? "verb";
  const [begin, end] = (verb.during ?? ["0%", "100%"]).map((time) => timeOf(String(time)));
  const list = `${prefix()}animation.verbs`, remove = () => change([[list, flow(given(list).filter((_, k) => k !== i))]]);
  const bar = el("button", { type: "button", class: "bar", title: `${name}: drag it in time`, "aria-label": `${name}, from ${timeText(begin)} to ${timeText(end)}`, "data-name": `verb ${i}` });
  const ends = ["begin", "end"].map((side) => el("button", { type: "button", class: "edge", title: `${name}: its ${side}`, "aria-label": `${side} of ${name}`, "data-name": `verb ${i} ${side}` }));
  const show = (from, to) => {
    Object.assign(bar.style, { left: `${100 * from}%`, width: `${Math.max(0.5, 100 * (to - from))}%` });
    ends.forEach((part, side) => { part.style.left = `${100 * (side ? to : from)}%`; });
  };
  const set = (from, to) => change([[`${list}[${i}].during`, flow([timeText(from), timeText(to)])]]);
  const visit = () => go(Math.round(begin * (desk.state.frames - 1)));
  show(begin, end);
  slides(bar, begin, [0, 1 - (end - begin)], (at) => show(at, at + end - begin), (at) => set(at, at + end - begin), visit, remove);
  slides(ends[0], begin, [0, end], (at) => show(at, end), (at) => set(at, end), visit, remove);
  slides(ends[1], end, [begin, 1], (at) => show(begin, at), (at) => set(begin, at), visit, remove);
  return el("div", { class: "track" }, el("span", { title: name }, button("×", `Remove ${name}`, remove, { class: "small" }), ` ${name} ${[verb[name]].flat().join(", ")}`),
    el("div", { class: "way" }, bar, ends));
};
const drawTracks = () => {
  const root = desk.state.job;
  if (!root) return;
  const own = prefix() ? root.shots[desk.state.shot] : root;
  const found = tracksIn({ light: own.light, render: own.render, tissues: own.tissues, animation: { ...own.animation, verbs: undefined } }, "").map(([path, track]) => [prefix() + path, track]);
  keepFocus(trackRows, () => trackRows.replaceChildren(...found.map(([path, track]) => el("div", { class: "track" }, el("span", { title: path }, titleOf(path.slice(prefix().length))),
    el("div", { class: "way" }, Object.keys(track).filter(isTime).map((time, i) => drawKey(path, track, time, i))))), ...(own.animation?.verbs ?? []).map(drawVerb)));
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

const addVerb = (verb) => addTo(`${prefix()}animation.verbs`, verb);
const during = () => { const at = here() < 0.9 ? here() : 0; return [timeText(at), timeText(Math.min(1, at + 0.4))]; };
const named = () => {
  const tissue = tissueOf(selection.id);
  if (!tissue) say("Select a tissue first.", "warn");
  return tissue && [nameInJob(tissue)];
};
const MOVES = {
  "turn once": () => change([[`${prefix()}animation.camera.orbit.turns`, 1]]),
  "stand still": () => change([[`${prefix()}animation.camera.orbit.turns`, 0]]),
  rock: () => addVerb({ rock: 20, during: during() }),
  "sweep a plane": () => addTo(`${prefix()}animation.clip`, { normal: "posterior", at: { "0%": "0%", "100%": "50%", ease: "smooth" } }),
  "frame the tissue": () => named() && addVerb({ frame: named(), during: during() }),
  "fly through the tissue": () => named() && addVerb({ fly: named(), during: during() }),
  "fade the tissue": () => named() && addVerb({ fade: named(), to: 0.1, during: during() }),
  "tissues appear": () => addVerb({ appear: ["*"], order: "largest", during: ["0%", "60%"] }),
};
const moves = choice("Ready moves", [["", "ready moves …"], ...Object.keys(MOVES).map((name) => [name, name])], (name, select) => { MOVES[name]?.(); select.value = ""; });

export const filmPanel = el("section", { id: "timeline", "aria-label": "The film" },
  el("div", { class: "line" }, play, head, clock, field("length", frames), button("sheet", "Small pictures of all of the film", showSheet)),
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
