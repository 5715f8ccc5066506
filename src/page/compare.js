// SPDX-License-Identifier: BSD-3-Clause
// Pages that compare runs, or studies, in several directories.
import { digits, el, fixed, note, percent, prose, section, size, table } from "./dom.js";
import { axisTo, chart, legend, stack } from "./chart.js";
import { PHASES, phaseChart } from "./run.js";

// A bar for each run, but none for those that drew nothing. parts: [value of a run, colour, name]...
const barsOf = (heading, caption, unit, runs, parts, format = (value) => fixed(value, 2)) => {
  const values = runs.map((run) => (run.drew ? parts.map(([value, color, name]) => [value(run), color, name]) : []));
  const sums = values.map((all) => all.reduce((sum, [value]) => sum + value, 0));
  return section(heading, parts.length > 1 ? legend(parts.map(([, color, name]) => [name, color])) : null,
    chart(caption, unit, axisTo(Math.max(...sums), 6), runs.map(({ name, drew }, i) => ({ label: name, bars: stack(values[i]),
      words: values[i].map(([value, , words]) => `${words} ${format(value)}`).join(", ") || "no frames",
      value: drew ? format(sums[i]) : "no frames" }))));
};

export const compareRuns = ({ runs, differing, common }) => {
  const drew = runs.filter((run) => run.drew).sort((a, b) => b.frames_per_s - a.frames_per_s);
  const [fastest, slowest] = [drew[0], drew.at(-1)], [drawing, drawn] = PHASES.render, [encoding, encoded] = PHASES.encode;
  return [
    el("p", { class: "lead" }, !fastest ? "No run has ended yet." : drew.length === 1
      ? `Only ${fastest.name} has drawn frames: ${fixed(fastest.frames_per_s, 2)} per second.`
      : [el("strong", {}, `${fastest.name} is fastest`), `: ${fixed(fastest.frames_per_s, 2)} frames per second, `,
        `${fixed(fastest.frames_per_s / slowest.frames_per_s, 2)} times as many as ${slowest.name}.`]),
    el("p", {}, differing
      ? `They have drawn different pictures: frame ${differing.frame} of ${differing.name} is another one than that of ` +
        `${runs[0].name}.`
      : common ? "All have drawn the same pictures, as far as they have drawn the same frames."
        : "No frame was drawn in two of them."),
    barsOf("Speed", "Frames per second of the last run; more is better", "frames per second", runs,
      [[(run) => run.frames_per_s, drawn, "frames per second"]]),
    barsOf("Cost of a frame", "CPU seconds of a frame; less is better", "CPU seconds", runs,
      [[(run) => run.draw_cpu_s, drawn, drawing], [(run) => run.encode_cpu_s, encoded, encoding]], digits),
    section("Phases", phaseChart("Wall seconds of each phase on the rank on which it took longest",
      runs.map(({ name, wall_s }) => ({ label: name, wall_s })))),
    barsOf("Memory", "Peak memory of the rank that took most; less is better", "MB", runs,
      [[(run) => run.peak_rss_bytes / 1e6, drawn, "MB"]], (value) => fixed(value, 0)),
    section("What limited them", el("ul", {}, drew.map((run) => el("li", {}, `${run.name}: `, prose(run.limit), ".")))),
    section("All figures", table("The last run in each directory",
      ["Directory", "Nodes", "Ranks", "Threads", "Frames", "Wall time, s", "CPU time, s", "Frames per s", "CPU s a frame",
        "Mrays per CPU s", "Imbalance", "Peak memory"],
      runs.map(({ run, ...one }) => [one.name, run.nodes, run.ranks, run.threads, run.frames, fixed(run.wall_s, 2),
        fixed(run.cpu_s, 2), fixed(one.frames_per_s, 2), digits(one.draw_cpu_s + one.encode_cpu_s),
        fixed(one.mrays_per_cpu_s, 2), percent(one.imbalance), size(one.peak_rss_bytes)])))];
};

const besides = (first, { name, beside }) => !beside.common ? `${first} and ${name} have no measured cell of the same name.` : [
  el("strong", {}, `${name} takes ${fixed(beside.mean, 3)} times the time of ${first}`),
  `, in the geometric mean over ${beside.common} cells of the same name; farthest apart are cells with `,
  `${fixed(beside.farthest, 3)} times. The confidence intervals of ${beside.apart} of them do not overlap. `,
  beside.other_pixels ? `${beside.other_pixels} of them have other pixels.` : "All of them have the same pixels."];

export const compareStudies = ({ studies, cells, cell_count, unit }) => [
  studies.slice(1).map((study, i) => el("p", { class: i ? "" : "lead" }, besides(studies[0].name, study))),
  cells.length ? section("All cells",
    table(unit, ["Cell", ...studies.map(({ name }) => name), "Last over first"], cells.map(({ name, times }) => [name,
      ...times.map((time) => time && digits(time)), times.at(-1) ? fixed(times.at(-1) / times[0], 3) : null])),
    cells.length < cell_count ? note(`The first ${cells.length} of ${cell_count} cells are shown.`) : null) : null,
  section("Where they were measured", table("The last run of each study",
    ["Directory", "Title", "Begin", "Host", "Processor", "Ranks", "Cores of rank 0", "Kernel", "segcast", "Measurements", "State"],
    studies.map(({ name, title, run, count, complete }) => [name, title, run?.begin, run?.host, run?.processor, run?.ranks,
      run?.cores, run?.kernel || null, run ? `${run.version}, commit ${run.commit ?? "unknown"}` : null, count,
      complete ? "complete" : "incomplete"])))];
