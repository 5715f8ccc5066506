// SPDX-License-Identifier: BSD-3-Clause
// The desk: what stands where.
import { el } from "./dom.js";
import { desk, on, begin, ask, change, say } from "./server.js";
import { given, worth } from "./keys.js";
import { button, choice, field, tabs } from "./parts.js";
import { look, onPick, placePicture } from "./view.js";
import { tissuePanel } from "./tissues.js";
import { cutPanel } from "./cut.js";
import { goTo, slicePanel } from "./slices.js";
import { filmPanel } from "./film.js";
import { fileButtons } from "./file.js";

const status = document.getElementById("status");
on("status", (text, kind) => { status.textContent = text; status.className = kind; });

// ---- the bar ----

const undo = button("↶", "Undo (Ctrl+Z)", () => ask("undo"), { id: "undo" });
const redo = button("↷", "Redo (Ctrl+Y)", () => ask("redo"), { id: "redo" });
const title = el("h1", {}, "segcast desk");
const VIEWS = { front: [0, 0], left: [90, 0], back: [180, 0], right: [-90, 0], above: [0, 90], below: [0, -90] };
const views = choice("Look from a side", [["", "look from …"], ...Object.keys(VIEWS).map((side) => [side, side])], (side, select) => { if (side) look(...VIEWS[side]); select.value = ""; });
const notes = button("", "What `segcast check` tells", () => say(desk.state.notes.join("\n"), "warn"), { class: "small", hidden: "" });
document.getElementById("bar").append(title, undo, redo, views, notes, el("span", { class: "space" }), ...fileButtons);
addEventListener("keydown", (event) => {
  if (!(event.ctrlKey || event.metaKey) || event.target.matches("input[type=text], input[type=search], textarea")) return;
  if (event.key === "z" && !event.shiftKey) undo.click();
  else if (event.key === "y" || ((event.key === "Z" || event.key === "z") && event.shiftKey)) redo.click();
  else return;
  event.preventDefault();
});

// ---- light and size ----

const key = (path, fallback) => given(path) ?? fallback;
const light = choice("Light", [["plain", "plain"], ["global", "gathered from all around"], ["flat", "none"]], (value) => change([["light.method", value]]));
const shadows = el("input", { type: "range", min: 0, max: 1, step: 0.05 });
shadows.addEventListener("input", () => change([["light.shadows", +shadows.value]], "shadows"));
const background = choice("Background", [["auto", "automatic"], ["white", "white"], ["black", "black"], ["\"#20242c\"", "slate"], ["none", "none"]], (value) => change([["render.background", value]]));
const shape = choice("Size of the film", [["720p", "1280 × 720"], ["1080p", "1920 × 1080"], ["4k", "3840 × 2160"], ["square", "1080 × 1080"], ["vertical", "1080 × 1920"]], (value) => change([["output.size", value]]));
const fps = el("input", { type: "number", min: 1, max: 120, step: 1 });
fps.addEventListener("change", () => change([["output.fps", +fps.value]]));
const lookChoice = choice("Look", ["plain", "studio", "cinematic", "atlas", "xray"].map((name) => [name, name]), (value) => change([["look", value]]));
const lookPanel = el("section", { class: "panel" }, field("look", lookChoice), field("light", light), field("shadows", shadows), field("background", background), field("film", shape), field("frames per second", fps));
on("state", (state) => {
  light.value = worth("light.method");
  if (document.activeElement !== shadows) shadows.value = Number(worth("light.shadows"));
  lookChoice.value = String(key("look", "plain"));
  background.value = String(worth("render.background"));
  shape.value = ["720p", "1080p", "4k", "square", "vertical"].find((name) => name === key("output.size")) ?? { "1280 720": "720p", "1920 1080": "1080p", "3840 2160": "4k", "1080 1080": "square", "1080 1920": "vertical" }[state.size.join(" ")] ?? "";
  if (document.activeElement !== fps) fps.value = state.fps;
});

// ---- all of it ----

on("state", (state) => {
  title.textContent = state.name;
  title.title = state.path;
  document.title = `${state.unsaved ? "• " : ""}${state.name} – segcast desk`;
  undo.disabled = !state.undo;
  redo.disabled = !state.redo;
  notes.hidden = !state.notes.length;
  notes.textContent = `${state.notes.length} note${state.notes.length === 1 ? "" : "s"}`;
});
onPick((found, kind) => { if (found.id) goTo(found.at); });
placePicture(document.getElementById("stage"));
const filmPlace = document.getElementById("film"), tools = document.getElementById("tools"), sidePlace = document.getElementById("side");
const pages = [["Tissues", tissuePanel], ["Cut", cutPanel], ["Look", lookPanel]];
// On narrow screens slices and film are pages, too.
const narrow = matchMedia("(max-width: 50rem)");
const arrange = () => {
  tools.replaceChildren(...pages.map(([, page]) => page));
  if (narrow.matches) tools.append(slicePanel, filmPanel);
  else { sidePlace.append(slicePanel); filmPlace.append(filmPanel); }
  for (const panel of [slicePanel, filmPanel]) ["role", "aria-labelledby", "data-shown"].forEach((name) => panel.removeAttribute(name));
  tabs(tools, narrow.matches ? [...pages, ["Slices", slicePanel], ["Film", filmPanel]] : pages);
};
narrow.addEventListener("change", arrange);
arrange();
begin();
