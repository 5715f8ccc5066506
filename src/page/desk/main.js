// SPDX-License-Identifier: BSD-3-Clause
// The desk: what stands where.
import { el } from "./dom.js";
import { desk, on, begin, ask, say } from "./server.js";
import { placePicture } from "./view.js";

const status = document.getElementById("status");
on("status", (text, kind) => { status.textContent = text; status.className = kind; });

const button = (text, title, act) => {
  const made = el("button", { type: "button", title, "aria-label": title }, text);
  made.addEventListener("click", act);
  return made;
};
const undo = button("↶", "Undo (Ctrl+Z)", () => ask("undo"));
const redo = button("↷", "Redo (Ctrl+Y)", () => ask("redo"));
const name = el("h1", {}, "segcast desk");
document.getElementById("bar").append(name, undo, redo);
addEventListener("keydown", (event) => {
  if (!(event.ctrlKey || event.metaKey) || event.target.matches("input[type=text], input[type=search], textarea")) return;
  if (event.key === "z" && !event.shiftKey) undo.click();
  else if (event.key === "y" || (event.key === "Z" || event.key === "z") && event.shiftKey) redo.click();
  else return;
  event.preventDefault();
});
on("state", (state) => {
  name.textContent = state.name;
  document.title = `${state.name} – segcast desk`;
  undo.disabled = !state.undo;
  redo.disabled = !state.redo;
  if (state.notes.length) say(state.notes.join("\n"), "warn");
});
placePicture(document.getElementById("stage"));
begin();
