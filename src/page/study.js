// SPDX-License-Identifier: BSD-3-Clause
// The page of a study: which values are fastest, how it scales, what limited it, how exactly that is known.
import { digits, el, fixed, note, percent, plural, prose, section, size, sources, table } from "./dom.js";
import { axisAround, axisDoubling, axisTo, band, chart, dots, legend, line, plot } from "./chart.js";
import { coreChart } from "./run.js";

const MOST = { curves: 7, charts: 24, bars: 60 }; // that are shown
const LIMITS = {
  draw: "drawing itself: more cores, fewer pixels or a faster `render.skip` make it faster",
  cores: "cores: threads that drew had a core only a part of the time, or waited for each other at the end of a frame; " +
    "give each thread a core of its own (fewer ranks or `--threads`, `mpirun --map-by slot:PE=THREADS`)",
  start: "reading and preparing the volume: `segcast convert` does it once for all runs, and longer films need it only once",
  encode: "encoding and writing on rank 0: `farm.encode: segments` lets all ranks encode",
  wait: "waiting: ranks had no work unit for more than 15 % of the time; more frames for each rank, or " +
    "`farm.partition: tiles`, help" };

// ---- cells and their names ----

const stride = ({ axes }, axis) => axes.slice(axis + 1).reduce((product, { values }) => product * values.length, 1);
const indexOf = (data, cell, axis) => Math.floor(cell / stride(data, axis)) % data.axes[axis].values.length;
const valueName = ({ name, values }, i) =>
  (values[i].trim() !== "" && Number.isFinite(Number(values[i])) ? `${name}\u00a0${values[i]}` : values[i]);
// What tells a cell from others: its values of all axes with several, without one of them.
const cellName = (data, cell, without = -1, alone = "the only cell") => {
  const parts = data.axes.map((axis, a) => (axis.values.length > 1 ? valueName(axis, indexOf(data, cell, a)) : null));
  return parts.filter((part, a) => part !== null && a !== without).join(", ") || alone;
};
// The cells that differ only in the value of an axis: [first cell, its cells by value, of which some may be missing]...
const groupsBy = (data, axis) => {
  const groups = new Map();
  for (const cell of data.cells) {
    const i = axis < 0 ? 0 : indexOf(data, cell.cell, axis), first = axis < 0 ? cell.cell : cell.cell - i * stride(data, axis);
    if (!groups.has(first)) groups.set(first, []);
    groups.get(first)[i] = cell;
  }
  return [...groups];
};
const timeOf = (data, cell) => (data.by_wall ? cell?.wall : cell?.cpu);
const unitOf = (data) => (data.by_wall ? "seconds a frame" : "CPU seconds a frame");
const overlap = (a, b) => a.low === null || b.low === null || (a.low <= b.high && b.low <= a.high);
const shownOf = (shown, count, what) =>
  (shown < count ? note(`The first ${shown} of ${count} ${what} are shown; cells.csv has all.`) : null);

// ---- what it says ----

// In which combinations of the other axes which value of the series is fastest.
const contest = (data) => {
  const axis = data.axes[data.series], wins = axis.values.map(() => []);
  let close = 0, count = 0;
  for (const [, cells] of groupsBy(data, data.series)) {
    const times = cells.map((cell, value) => ({ ...timeOf(data, cell), value })).filter((time) => time);
    const [first, second] = times.sort((a, b) => a.median - b.median);
    if (!second) continue;
    count++;
    close += overlap(first, second);
    wins[first.value].push(cells[0] ? timeOf(data, cells[0]).median / first.median : null);
  }
  if (!count) return [];
  const best = wins.reduce((most, all, i) => (all.length > wins[most].length ? i : most), 0);
  const ratios = wins[best].filter((ratio) => best && ratio).sort((a, b) => a - b).map((ratio) => fixed(ratio, 2));
  const [low, high] = [ratios[0], ratios.at(-1)], where = wins[best].length === count ? "all" : `${wins[best].length} of`;
  return [
    el("p", { class: "lead" },
      el("strong", {}, `${axis.name}: ${axis.values[best]} ${close === count ? "has the lowest median" : "is fastest"}`),
      count > 1 ? ` in ${where} ${count} combinations of the other axes` : "",
      low ? `, ${low === high ? low : `${low} to ${high}`} times as fast as ${axis.values[0]}` : "", "."),
    close ? el("p", {}, `In ${close} of ${count} the confidence intervals of the two fastest overlap: `,
      "which of the two is faster remains open there.") : null];
};

const state = (data) => {
  const known = data.cells.filter((cell) => timeOf(data, cell).precision !== null);
  const [widest] = known.toSorted((a, b) => timeOf(data, b).precision - timeOf(data, a).precision);
  const without = data.cells.length - known.length, mismatch = data.mismatch?.map((cell) => cellName(data, cell));
  return [
    el("p", {}, `${data.count} measurements of ${data.measured} of ${data.cell_count} cells. `, data.complete
      ? "The study is complete."
      : ["The study is not complete: the same command with ", el("code", {}, "--resume"), " goes on."]),
    widest ? el("p", {}, `Medians are known to ${percent(timeOf(data, widest).precision)} or better (half the 95 % `,
      `confidence interval; the widest is that of ${cellName(data, widest.cell)}).`) : null,
    without ? el("p", {}, `${plural(without, "cell")} had too few measurements for a confidence interval.`) : null,
    data.measured ? el("p", {}, mismatch
      ? `The pixels do not agree: those of ${mismatch[0]} are others than those of ${mismatch[1]}.`
      : "All pixels agree, bit for bit, wherever they have to.") : null];
};

const limits = (data) => section("What limited the cells", el("ul", {}, Object.entries(LIMITS).map(([key, words]) => {
  const count = data.cells.filter(({ limit }) => limit === key).length;
  return count ? el("li", {}, `${count === data.cells.length ? "all " : ""}${count} by `, prose(words), ".") : null;
})));

// A row for each combination of the other axes, a column for each value of the series.
const methods = (data) => {
  const { name, values } = data.axes[data.series];
  const entry = (number, ratio, precision, bold) => {
    const notes = [ratio && `${fixed(ratio, 2)} times`, precision && `± ${percent(precision)}`].filter((part) => part);
    return [bold ? el("b", {}, number) : number, notes.length ? el("small", {}, notes.join(", ")) : null];
  };
  const rows = groupsBy(data, data.series).map(([first, cells]) => {
    const [fastest] = cells.filter((cell) => cell).map((cell) => timeOf(data, cell)).sort((a, b) => a.median - b.median);
    return [cellName(data, first, data.series, "the study"), ...values.map((_, i) => {
      const time = timeOf(data, cells[i]), ratio = i && cells[0] ? timeOf(data, cells[0]).median / time?.median : null;
      return time ? entry(digits(time.median), ratio, time.precision, time === fastest || overlap(time, fastest)) : null;
    })];
  });
  if (data.paper) rows.unshift(["the paper, its heart and computer", ...values.map((value) => data.paper[value]
    ? entry(fixed(data.paper[value], 1), value === "none" ? null : data.paper.none / data.paper[value]) : null)]);
  const words = `Median of the ${unitOf(data)}, half its confidence interval, and how many times as fast as ${values[0]}`;
  return section(`Values of ${name}`, table(words, ["", ...values], rows),
    note("Bold: the fastest of a row, and what its confidence interval does not tell apart from it."));
};

// ---- charts ----

const scaling = (data) => {
  const curves = groupsBy(data, data.scale).map(([first, cells]) => ({ name: cellName(data, first, data.scale, "all cells"),
    cells: cells.filter((cell) => cell?.speedup).sort((a, b) => a.workers - b.workers) })).filter(({ cells }) => cells.length);
  const shown = curves.slice(0, MOST.curves), all = shown.flatMap(({ cells }) => cells);
  if (!all.length) return null;
  const from = Math.min(...all.map((cell) => cell.workers)), to = Math.max(...all.map((cell) => cell.workers));
  const single = (cell, key) => cell.times.map((time) => cell[key][0] * cell.wall.median / time);
  const spread = (key) => all.flatMap((cell) => [...cell[key], ...single(cell, key)]), speedups = spread("speedup");
  const draw = (caption, key, y, ideal) => plot(caption, "The table of scaling holds the numbers.", "ranks times threads",
    axisDoubling(from, to), y, [line([[from, 1], [to, ideal]], 7, "dashed"), ...shown.flatMap(({ cells }, i) => [
      band(cells.map((cell) => [cell.workers, cell[key][1], cell[key][2]]), i),
      line(cells.map((cell) => [cell.workers, cell[key][0]]), i),
      dots(cells.flatMap((cell) => single(cell, key).map((value) => [cell.workers, value])), i)])]);
  return section("Scaling", legend(shown.map(({ name }, i) => [name, i])),
    draw("Speed-up against the fewest workers, in rays per second of wall time; the dashed line is ideal", "speedup",
      axisDoubling(Math.min(1, ...speedups), Math.max(to / from, ...speedups)), to / from),
    draw("Efficiency: speed-up for each worker; the dashed line is ideal", "efficiency",
      axisAround(Math.max(1, ...spread("efficiency")), 5), 1),
    note("Dots are single measurements. A band holds all quotients of two times of which each lies in the 95 % confidence ",
      "interval of its median. Both axes of the first plot are logarithmic."),
    shownOf(shown.length, curves.length, "curves"));
};

const bars = (data) => {
  const groups = groupsBy(data, data.series), unit = unitOf(data);
  const row = (first, cell, i) => {
    const label = data.series < 0 ? cellName(data, first) : valueName(data.axes[data.series], i), time = timeOf(data, cell);
    if (!time) return { label, value: "–", words: "not measured" };
    return { label, bars: [[0, time.median, 3]], dots: cell.times, value: digits(time.median),
      interval: time.low === null ? null : [time.low, time.high],
      words: `median ${digits(time.median)} of ${cell.n} measurements, from ${digits(time.least)} to ${digits(time.most)}` };
  };
  return section("Time of a frame", groups.slice(0, MOST.charts).map(([first, cells]) => {
    const name = cellName(data, first, data.series, ""), axis = data.axes[data.series] ?? { values: [null] };
    const most = axis.values.map((_, i) => timeOf(data, cells[i])?.most ?? 0);
    return chart(`${name}${name ? ": " : ""}${unit}; less is better`, unit, axisTo(Math.max(...most), 6),
      axis.values.map((_, i) => row(first, cells[i], i)));
  }),
  note("Bars are medians, circles single measurements, and the line is the 95 % confidence interval of the median."),
  shownOf(MOST.charts, groups.length, "charts"));
};

// ---- tables ----

const range = ({ low, high }) => (low === null ? null : `${digits(low)} to ${digits(high)}`);
// Columns: [head, value of a cell]; those of which no cell has a value are left out.
const cellTable = (data, caption, columns) => {
  const shown = columns.filter(([, value]) => data.cells.some((cell) => value(cell) !== null));
  return table(caption, ["Cell", ...shown.map(([head]) => head)],
    data.cells.map((cell) => [cellName(data, cell.cell), ...shown.map(([, value]) => value(cell))]));
};
const tables = (data) => section("All cells",
  cellTable(data, "Times of a frame, in seconds", [["n", (cell) => cell.n],
    ...[["CPU time", "cpu"], ["Wall time", "wall"]].flatMap(([head, key]) => [[head, (cell) => digits(cell[key].median)],
      ["95 % interval", (cell) => range(cell[key])], ["Quartiles", (cell) => cell[key].quartiles.map(digits).join(", ")]])]),
  note("The 95 % confidence interval of the median reaches from one measurement to another, chosen by their ranks ",
    "(binomial distribution). CPU time is that of all ranks, waiting included."),
  data.cells.some((cell) => cell.base !== cell.cell) ? cellTable(data, "Speed-up in rays per second of wall time", [
    ["Nodes", (cell) => cell.nodes], ["Ranks", (cell) => cell.ranks], ["Threads", (cell) => cell.threads],
    ["Beside", (cell) => (cell.base === cell.cell ? "itself" : cellName(data, cell.base))],
    ["Speed-up", (cell) => cell.speedup && fixed(cell.speedup[0], 2)],
    ["Efficiency", (cell) => cell.efficiency && fixed(cell.efficiency[0], 3)],
    ["Serial share (Karp-Flatt)", (cell) => (cell.base === cell.cell ? null : fixed(cell.serial_share, 3))],
    ["CPU time per ray, of the base", (cell) => fixed(cell.cost, 2)], ["Imbalance", (cell) => percent(cell.imbalance)],
    ["Frames per s", (cell) => digits(cell.frames_per_s)]]) : null,
  cellTable(data, "Work, preparation and memory, of the measurement nearest to the median", [
    ["Mrays per CPU s", (cell) => digits(cell.mrays_per_cpu_s)],
    ["Samples per ray", (cell) => fixed(cell.samples_per_ray, 1)],
    ["Contributions per ray", (cell) => fixed(cell.contributions_per_ray, 2)],
    ["Preparation, s", (cell) => fixed(cell.start_s, 3)], ["Of that, for this cell alone, s", (cell) => fixed(cell.derive_s, 3)],
    ["Prepared volume", (cell) => size(cell.prepared_bytes)], ["Peak memory of a rank", (cell) => size(cell.peak_rss_most_bytes)],
    ["Of all ranks", (cell) => size(cell.peak_rss_sum_bytes)],
    ["Energy of a frame, J", (cell) => (cell.energy_j === null ? null : digits(cell.energy_j))]]),
  shownOf(data.cells.length, data.measured, "cells"));

const machines = ({ runs, run_count: count }) => section("Where it was measured", table(
  runs.length < count ? "The last runs of segcast study" : "Runs of segcast study",
  ["Begin", "Host", "Processor", "Nodes", "Ranks", "Cores of rank 0", "Kernel", "MPI", "segcast", "Batch job"],
  runs.map((run) => [run.begin, run.host, run.processor, run.nodes, run.ranks, run.cores, run.kernel || null, run.mpi,
    `${run.version}, commit ${run.commit ?? "unknown"}`, run.batch_job || null])));

const skipped = ({ missing, skipped: all }) => missing || all.length ? section("Not measured",
  missing ? el("p", {}, `${plural(missing, "cell")} not yet.`) : null,
  el("ul", {}, all.map(({ count, reason }) => el("li", {}, `${count}: ${reason}`)))) : null;

const FILES_OF_STUDY = { measurements: "every measurement", cells: "a row for each cell, with all columns",
  extrap: "every measurement in the format of Extra-P", study: "the study as read, which can be measured again" };
const measured = (data) => [
  data.series >= 0 ? methods(data) : null, data.scale >= 0 ? scaling(data) : bars(data), limits(data),
  section("Where the time went", coreChart(data.cells.slice(0, MOST.bars).map((cell) => [cellName(data, cell.cell), cell.core])),
    shownOf(MOST.bars, data.cells.length, "cells"),
    note("Of the measurement of each cell that is nearest to the median. Cores: ranks times threads. The number at the end ",
      "is the share of drawing.")),
  tables(data)];
export const study = (data) => [
  data.measured && data.series >= 0 ? contest(data) : [], state(data), data.measured ? measured(data) : [],
  machines(data), skipped(data), sources(data.settings, data.files, FILES_OF_STUDY)];
