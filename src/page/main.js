// SPDX-License-Identifier: BSD-3-Clause
// Draws the page from its data.
import { el } from "./dom.js";
import { run } from "./run.js";
import { study } from "./study.js";
import { compareRuns, compareStudies } from "./compare.js";

const data = JSON.parse(document.getElementById("data").textContent);
document.title = data.title;
document.querySelector("main").replaceChildren(el("h1", {}, data.title),
  ...{ run, study, runs: compareRuns, studies: compareStudies }[data.kind](data).flat(Infinity).filter((part) => part));
