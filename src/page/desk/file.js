// SPDX-License-Identifier: BSD-3-Clause
// Saving the job, and rendering it.
import { el } from "./dom.js";
import { desk, on, ask, post, say, wait } from "./server.js";
import { button, dialog, field } from "./parts.js";

// ---- what would change ----

// Lines of two texts: [" ", both], ["-", only the first], ["+", only the second].
const compare = (a, b) => {
  const table = Array.from({ length: a.length + 1 }, () => new Uint16Array(b.length + 1)), out = [];
  for (let i = a.length - 1; i >= 0; i--)
    for (let j = b.length - 1; j >= 0; j--) table[i][j] = a[i] === b[j] ? table[i + 1][j + 1] + 1 : Math.max(table[i + 1][j], table[i][j + 1]);
  let i = 0, j = 0;
  while (i < a.length || j < b.length) {
    if (i < a.length && j < b.length && a[i] === b[j]) { out.push([" ", a[i]]); i++; j++; }
    else if (j >= b.length || (i < a.length && table[i + 1][j] >= table[i][j + 1])) out.push(["-", a[i++]]);
    else out.push(["+", b[j++]]);
  }
  return out;
};
const difference = (old, now) => {
  const lines = compare(old.split("\n"), now.split("\n"));
  const near = lines.map((_, i) => lines.slice(Math.max(0, i - 2), i + 3).some(([mark]) => mark !== " "));
  return el("pre", { class: "difference", id: "difference" }, lines.flatMap(([mark, text], i) => {
    if (!near[i]) return near[i - 1] ? [el("span", {}, "…")] : [];
    return [el("span", { class: { "+": "more", "-": "less" }[mark] ?? "" }, `${mark} ${text}`)];
  }));
};

// ---- saving ----

const save = async (name) => {
  const answer = await ask("save", name ? { name } : {});
  if (!answer) return false;
  if (answer.saved) say(`Saved: ${answer.path}`);
  if (answer.saved) return true;
  return new Promise((done) => {
    const box = dialog(`Save ${answer.path}?`, el("p", {}, "These lines of the file change:"), difference(answer.old, answer.new));
    let result = false;
    box.append(el("div", { class: "line end" }, button("Cancel", "Cancel", () => box.close()), button("Save", "Save these changes", async () => {
      const next = await ask("save", { ...(name ? { name } : {}), confirm: answer.confirm });
      result = Boolean(next?.saved);
      if (next) say(...(result ? [`Saved: ${next.path}`] : ["The file was changed meanwhile; save again.", "warn"]));
      box.close();
    }, { id: "confirm", class: "main" })));
    box.addEventListener("close", () => done(result));
    box.querySelector("#confirm").focus();
  });
};
const saveAs = () => {
  const name = el("input", { type: "text", value: desk.state.name, size: 30 });
  const box = dialog("Save as", field("name, in the same directory", name), el("div", { class: "line end" }, button("Cancel", "Cancel", () => box.close()),
    button("Save", "Save", async () => { box.close(); await save(name.value); }, { class: "main" })));
};

// ---- rendering ----

const quoted = (path) => (/^[\w./-]+$/.test(path) ? path : `'${path.replace(/'/g, "'\\''")}'`);
const copy = async (text) => {
  try {
    await navigator.clipboard.writeText(text);
    say(`Copied: ${text}`);
  } catch {
    say(text);
  }
};
const commands = () => {
  const path = quoted(desk.state.path), lines = [`segcast render ${path}`, `sbatch --nodes=2 jobs/slurm/requeue.sbatch ${path} -o ${path.replace(/\.ya?ml'?$/, "")}-out`];
  const box = dialog("Render the job", ...(desk.state.unsaved ? [el("p", { class: "banner" }, "There are changes that are not saved.")] : []),
    ...lines.map((line) => el("div", { class: "line" }, el("code", {}, line), button("Copy", `Copy ${line}`, () => copy(line), { class: "small" }))),
    el("div", { class: "line end" }, button("Close", "Close", () => box.close()), button("Render here", "Render here", () => { box.close(); renderHere(false); }, { class: "main", id: "here" })));
};
const renderHere = async (overwrite) => {
  if (desk.state.unsaved && !await save()) return;
  if (!await ask("render", { overwrite })) return;
  watch();
};

const watch = async () => {
  for (;;) {
    const now = await ask("rendering");
    if (!now) return;
    if (!now.runs) { ended(now); return; }
    const { done, total, remaining_s } = now.status ?? {};
    say(total ? `Rendering: ${done} of ${total} frames${remaining_s ? `, about ${Math.ceil(remaining_s)} s left` : ""}` : "Rendering …");
    await wait(700);
  }
};
const ended = async (now) => {
  if (now.exit) {
    const taken = now.exit === 73;
    const box = dialog(taken ? "The directory holds a run" : "Rendering has failed", el("p", {}, now.said),
      el("div", { class: "line end" }, button("Close", "Close", () => box.close()), ...(taken ? [button("Begin anew", "Remove that run and render anew", () => { box.close(); renderHere(true); }, { class: "main" })] : [])));
    say("");
    return;
  }
  say(`Rendered: ${now.directory}`);
  const answer = await post("film", {});
  if (answer.headers.get("Content-Type") === "application/json") return;
  const film = URL.createObjectURL(await answer.blob()), moving = answer.headers.get("Content-Type").startsWith("video");
  const box = dialog("The film", moving ? el("video", { src: film, controls: "", autoplay: "", loop: "", id: "made" }) : el("img", { src: film, alt: "The film", id: "made" }),
    el("p", {}, now.directory), el("div", { class: "line end" }, button("Close", "Close", () => box.close())));
  box.addEventListener("close", () => URL.revokeObjectURL(film));
};

const saveButton = button("Save", "Save the job (Ctrl+S)", () => save(), { id: "save" });
export const fileButtons = [saveButton, button("Save as …", "Save under another name", saveAs), button("Render …", "Render the film", commands, { id: "render" })];
addEventListener("keydown", (event) => {
  if ((event.ctrlKey || event.metaKey) && event.key === "s") { event.preventDefault(); save(); }
});
on("state", (state) => { saveButton.classList.toggle("main", state.unsaved); });
addEventListener("beforeunload", (event) => { if (desk.state?.unsaved && desk.state.undo) event.preventDefault(); });
