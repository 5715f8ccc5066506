// SPDX-License-Identifier: BSD-3-Clause
// The page of a run: what it did, what limited it, where the time went.
import { digits, el, facts, fixed, link, note, percent, plural, prose, section, size, sources, table } from "./dom.js";
import { axisAround, axisLog, axisTo, band, chart, dots, legend, line, marks, plot, stack } from "./chart.js";

// What phases and causes are called, and their colours.
export const PHASES = { read: ["reading", 0], prepare: ["preparing", 1], share: ["sharing", 2], render: ["drawing", 3],
  gather: ["gathering", 4], encode: ["encoding", 5], write: ["writing", 6], idle: ["waiting", 7] };
const CAUSES = { draw_s: ["drawing", 3], read_s: ["reading", 0], prepare_s: ["preparing", 1], share_s: ["sharing the volume", 2],
  gather_s: ["passing messages", 4], encode_s: ["encoding and writing", 5],
  threads_s: ["threads waiting for each other or for a core", 6], wait_s: ["waiting for other ranks", 7],
  idle_s: ["idle, without a work unit", 7], other_s: ["all else", "x"] };
const EVENTS = { read: ["reading", "r", 0], prepare: ["preparing", "p", 1], share: ["sharing", "s", 2], draw: ["drawing", "d", 3],
  encode: ["encoding", "e", 5], finish: ["completing", "f", 6] };

// Rows of {label, parts: [length, colour, words]...} as stacked bars; value: what stands at the end of a row.
const stackChart = (caption, unit, axis, rows, value) => chart(caption, unit, axis, rows.map(({ label, parts }) => ({ label,
  bars: stack(parts), value: value(parts), words: parts.filter(([length]) => length > 0).map(([, , words]) => words).join(", ") })));
// One row for each [label, core time]: 100 % of the time of its cores, split by cause.
export const coreChart = (rows) => [
  legend(Object.values(CAUSES).filter(([, color]) => color !== "x")),
  stackChart("Where the time of the cores went: what is not drawing is overhead", "percent", axisTo(100, 5),
    rows.map(([label, time]) => {
      const sum = Object.keys(CAUSES).reduce((all, key) => all + time[key], 0) || 1;
      return { label, parts: Object.entries(CAUSES).map(([key, [word, color]]) =>
        [100 * time[key] / sum, color, `${word} ${percent(time[key] / sum)}`]) };
    }), ([[drawing]]) => percent(drawing / 100))];
// One row for each {label, wall_s}: the wall seconds of its phases.
export const phaseChart = (caption, rows) => {
  const parts = ({ wall_s }) => Object.values(PHASES).map(([word, color], i) =>
    [wall_s[i], color, `${word} ${fixed(wall_s[i], 2)} s`]);
  const sum = (all) => all.reduce((seconds, [length]) => seconds + length, 0);
  return [legend(Object.values(PHASES)),
    stackChart(caption, "seconds", axisTo(Math.max(...rows.map((row) => sum(parts(row)))), 6),
      rows.map((row) => ({ label: row.label, parts: parts(row) })), (all) => `${fixed(sum(all), 2)} s`)];
};

const rankName = (data, rank, host) => `rank ${rank}${data.run.nodes > 1 ? ` on ${host}` : ""}`;

const summary = (data) => {
  const { run, phases } = data, lead = (...children) => el("p", { class: "lead" }, ...children);
  const again = ["The same command with ", el("code", {}, "--resume"), " goes on."];
  if (!run.ended)
    return lead("The last run was killed, or goes on still: it has measured nothing yet. If it was killed: ", again);
  if (!run.frames) return lead("The last run drew no frame.");
  const slowest = data.cost?.slowest.map(([frame, cpu_s]) => `${frame} (${digits(cpu_s)} CPU s)`) ?? [];
  return [
    lead(`${plural(run.frames, "frame")} in ${fixed(run.wall_s, 1)} s: ${fixed(data.frames_per_s, 2)} frames per second. `,
      el("strong", {}, "Limited by ", prose(data.limit), ".")),
    el("p", {}, `Drawing took ${digits(phases.render.cpu_s / run.frames)} CPU seconds a frame, encoding `,
      `${digits(phases.encode.cpu_s / run.frames)}. Worker threads waited for work ${percent(data.waiting, 0)} of the time.`,
      run.ranks > 1 ? ` The busiest rank drew ${percent(data.imbalance, 0)} longer than the mean of all.` : "",
      slowest.length > 1 ? ` The slowest frames were ${slowest.join(", ")}.` : ""),
    data.slice ? el("p", {}, `This is slice ${data.slice}: its frames are a part of the film's ${data.frames}.`) : null,
    !data.slice && data.there < data.frames
      ? el("p", {}, `The film is incomplete: ${data.there} of ${data.frames} frames are drawn. `, again) : null];
};

const film = (data) => data.video ? section("The film",
  el("video", { controls: "", preload: "metadata", title: data.video, src: link(data.video).getAttribute("href") }),
  el("p", {}, link(data.video), `: ${data.frames} frames at ${data.fps} per second`)) : null;

const figures = ({ run, memory, ...data }) => section("The run", facts([
  ["Begin", run.begin], ["Host of rank 0", run.host], ["Processor", run.processor], ["Kernel", run.kernel],
  ["Nodes", String(run.nodes)], ["Ranks", String(run.ranks)], ["Threads of a rank", String(run.threads)], ["MPI", run.mpi],
  ["Batch job", run.batch_job],
  ...(run.ended ? [["Frames drawn", String(run.frames)], ["Wall time", `${fixed(run.wall_s, 2)} s`],
    ["CPU time", `${fixed(run.cpu_s, 2)} s`], ["Frames per second", fixed(data.frames_per_s, 3)],
    ["Million rays per CPU second", fixed(data.mrays_per_cpu_s, 2)], ["Imbalance of ranks", percent(data.imbalance)],
    ["Peak memory of a rank", size(memory.peak_rss_bytes)]] : []),
  ["Volume", size(memory.volume_bytes)], ["Prepared volume", size(memory.prepared_bytes)],
  ["Derived from it for drawing", size(memory.derived_bytes)],
  ["segcast", data.version + (run.commit ? `, commit ${run.commit}` : "")]]));

const phases = (data) => {
  const { core_s, ...causes } = data.core_time, { ranks } = data;
  return section("Where the time went",
    coreChart([["all ranks", causes]]),
    table("Time of all cores: wall time, ranks and threads multiplied", ["Cause", "Core time, s", "Share"],
      Object.entries(CAUSES).map(([key, [word]]) => [word, fixed(causes[key], 2), percent(causes[key] / (core_s || 1))])),
    phaseChart("Wall seconds of each rank by phase",
      ranks.map(({ rank, host, wall_s }) => ({ label: rankName(data, rank, host), wall_s }))),
    ranks.length < data.run.ranks ? note(`${ranks.length} of ${data.run.ranks} ranks are shown, at even distances.`) : null,
    note("Rank 0 encodes, writes and passes messages beside drawing, so its bar may be longer than the run."),
    table("Phases of all ranks", ["Phase", "Wall time of the slowest rank, s", "CPU time of all ranks, s"],
      Object.entries(data.phases).map(([key, { wall_s, cpu_s }]) => [PHASES[key][0], fixed(wall_s, 2), fixed(cpu_s, 2)])));
};

const activity = (data) => {
  const { activity: all } = data;
  if (typeof all === "string") return section("Ranks over time", el("p", {}, all));
  const colors = Object.fromEntries(Object.values(EVENTS).map(([, letter, color]) => [letter, color]));
  const rows = all.rows.map(({ rank, host, thread, seconds, strip: parts }) => {
    const did = Object.entries(EVENTS).filter(([key]) => seconds[key] > 0);
    return { label: `${rankName(data, rank, host)}, ${thread === null ? "encoding" : `thread ${thread}`}`, strip: parts, colors,
      words: did.map(([key, [word]]) => `${word} ${fixed(seconds[key], 2)} s`).join(", ") || "nothing" };
  });
  return section("Ranks over time",
    legend(Object.values(EVENTS).map(([word, , color]) => [word, color])),
    chart("What each thread did when", "seconds since the run began", axisTo(data.run.wall_s, 6), rows, "thin"),
    all.shown < all.threads ? note(`${all.shown} of ${all.threads} threads are shown, at even distances.`) : null,
    note("Where several things were done in one part of the time, the most frequent is shown. trace.json holds all ",
      `${all.events} events; ui.perfetto.dev and chrome://tracing show it.`));
};

const cost = (data) => {
  const { cost: all, pictures, dots: met } = data, drawn = PHASES.render[1];
  if (!all) return section("Cost along the film", el("p", {}, "No run has measured a frame."));
  const place = (i) => i * all.each + 0.5 * (all.each - 1), most = (i) => Math.max(...met.points.map((at) => at[i]));
  const [first, last] = [all.least, all.slowest[0]].map(([frame, cpu_s]) => `${digits(cpu_s)} s (frame ${frame})`);
  const correlation = met && `${met.points.length} frames; the coefficient of correlation is ${fixed(met.correlation, 2)}.`;
  return section("Cost along the film",
    plot("CPU seconds of drawing each frame", `Least ${first}, most ${last}, mean ${digits(all.mean_s)} s.`, "frame",
      axisTo(data.frames, 6, true), axisAround(all.slowest[0][1], 4), [
        band(all.each > 1 ? all.low.map((low, i) => [place(i), low, all.high[i]]) : [], drawn),
        marks(pictures.map(({ frame }) => frame)), line(all.mean.map((mean, i) => [place(i), mean]), drawn)]),
    el("div", { class: "film", style: `--pictures: ${pictures.length}` }, pictures.map(({ frame, width, height, png }) =>
      el("figure", {}, el("img", { alt: `frame ${frame}`, width, height, src: `data:image/png;base64,${png}` }),
        el("figcaption", {}, frame)))),
    met ? [plot("CPU seconds of drawing each frame against the boundary voxels that its rays met (contributions)", correlation,
      "contributions, in millions", axisAround(most(0), 6), axisAround(most(1), 4), [dots(met.points, drawn)]),
    note(correlation)] : null);
};

// ---- heat pictures ----

// From dark to light, in equal steps of lightness; what has no work is grey.
const SCALE = [[32, 26, 70], [84, 44, 125], [156, 56, 120], [219, 92, 86], [246, 156, 76], [250, 226, 140]];
const heatColor = (at) => {
  const place = Math.min(Math.max(at, 0), 0.9999) * (SCALE.length - 1), below = Math.floor(place);
  return SCALE[below].map((value, c) => value + (place - below) * (SCALE[below + 1][c] - value));
};
// The picture's grey values are logarithms of counts, in steps of a sixteenth of a doubling; 0 is nothing.
const paint = async (canvas, { png, low, high }) => {
  const image = new Image();
  image.src = `data:image/png;base64,${png}`;
  await image.decode();
  const context = canvas.getContext("2d"), first = Math.log2(low), range = Math.max(Math.log2(high) - first, 0.01);
  context.drawImage(image, 0, 0);
  const pixels = context.getImageData(0, 0, canvas.width, canvas.height);
  for (let i = 0; i < pixels.data.length; i += 4)
    pixels.data.set(pixels.data[i] ? heatColor(((pixels.data[i] - 1) / 16 - first) / range) : [128, 132, 138], i);
  context.putImageData(pixels, 0, 0);
};
const heat = ({ heat: all }) => all ? section("Work of each pixel",
  el("div", { class: "heats" }, all.kinds.map((kind) => {
    const words = `Frame ${all.frame}: ${kind.name} per pixel, from ${fixed(kind.low, 0)} to ${fixed(kind.high, 0)}, median ` +
      `${fixed(kind.median, 0)}, where there are any; none in ${percent(kind.none, 0)} of the pixels (grey)`;
    const canvas = el("canvas", { role: "img", "aria-label": words, width: all.width, height: all.height });
    paint(canvas, kind);
    return el("figure", { class: "heat" }, el("figcaption", {}, words), canvas, chart("", `${kind.name} per pixel`,
      axisLog(kind.low, kind.high), [{ label: "", words: "the colours from few to many" }], "thin ramp"));
  })),
  note("Samples are cells or samples of a ray that were examined, and contributions boundary voxels that it met. The frame is ",
    "one whose work is near the mean. It was drawn once more for this page, after the run, with one ray through the middle of ",
    `each of ${all.width} x ${all.height} pixels, in ${digits(all.cpu_s)} CPU seconds.`)) : null;

const runs = ({ runs: all, run_count: count }) => section("Runs on this job",
  table(all.length < count ? "The last runs; stats.json has all of them" : "All runs",
    ["Begin", "Host", "Nodes", "Ranks", "Threads", "Frames", "Wall time, s", "CPU time, s", "State"],
    all.map((one) => [one.begin, one.host + (one.hosts > 1 ? " and others" : ""), one.nodes, one.ranks, one.threads, one.frames,
      fixed(one.wall_s, 2), fixed(one.cpu_s, 2), one.ended ? "ended" : "killed, or goes on still"])));

const FILES_OF_RUN = { stats: "all measurements", frames: "one line for each frame", trace: "what each thread did when",
  manifest: "hashes of the job, the frames and the files", job: "the job with all its settings" };
export const run = (data) => [summary(data), film(data), figures(data), data.run.ended ? phases(data) : null, activity(data),
  cost(data), heat(data), runs(data), sources(data.settings, data.files, FILES_OF_RUN)];
