// SPDX-License-Identifier: BSD-3-Clause
// Keys of the job, and key frames.
import { desk, change } from "./server.js";

// What stands in the job at a path such as "animation.clip[0].at"; undefined: nothing.
export const given = (path, tree = desk.state.job) => {
  const parts = path.match(/"[^"]*"|[^.[\]]+/g) ?? [];
  return parts.reduce((node, part) => node?.[part.replace(/^"|"$/g, "")], tree);
};
// What it is worth, also if a look or nothing gives it.
export const worth = (path) => given(path, desk.state.values);
// With several shots, keys of the animation are those of the shot that is looked at.
export const prefix = () => (desk.state.job?.shots ? `shots[${desk.state.shot}].` : "");

// The planes of the job, with the number that the first plane of each has in the scene, in which a box is six.
export const planes = () => {
  let scene = 0;
  return (given(`${prefix()}animation.clip`) ?? []).map((entry, i) => {
    const made = { entry, i, scene, name: `${entry.box ? "Box" : "Plane"} ${i + 1}` };
    scene += entry.box ? 6 : 1;
    return made;
  });
};

export const isTrack = (value) => value !== null && typeof value === "object" && !Array.isArray(value);
// The time that a key frame names, as a share of the animation.
export const timeOf = (text) => {
  const { frames, fps } = desk.state, last = Math.max(1, frames - 1);
  const clock = /^(?:(\d+):)?(\d+):([\d.]+)$/.exec(text);
  const number = parseFloat(text);
  if (clock) return ((+(clock[1] ?? 0) * 60 + +clock[2]) * 60 + +clock[3]) * fps / last;
  if (/%\s*$/.test(text)) return number / 100;
  if (/ms\s*$/.test(text)) return number / 1000 * fps / last;
  if (/min\s*$/.test(text)) return number * 60 * fps / last;
  if (/f(rames?)?\s*$/.test(text)) return number / last;
  return number * fps / last;
};
export const here = () => desk.state.frame / Math.max(1, desk.state.frames - 1);
export const timeText = (share) => `${Number((100 * share).toFixed(2))}%`;
// A value as YAML between braces: quotes only where they are needed.
export const flow = (value) => {
  if (Array.isArray(value)) return `[${value.map(flow).join(", ")}]`;
  if (value !== null && typeof value === "object") return `{${Object.entries(value).map(([k, v]) => `${flow(k)}: ${flow(v)}`).join(", ")}}`;
  if (typeof value !== "string") return JSON.stringify(value);
  return /^-?[\w.][\w.%+/-]*( [\w.%+/-]+)*$/.test(value) && !/^(true|false|yes|no|on|off|null|y|n)$/i.test(value) ? value : JSON.stringify(value);
};
// Key frames as the job writes them: { time: value } or { time: { value, ease } }; what is no time, such as ease, stays behind.
export const isTime = (text) => /^[\d.:]+ *(%|s|ms|min|f|frames?)?$/.test(text);
export const trackText = (track) => flow(Object.fromEntries([
  ...Object.entries(track).filter(([k]) => isTime(k)).sort((a, b) => timeOf(a[0]) - timeOf(b[0])),
  ...Object.entries(track).filter(([k]) => !isTime(k))]));
// The key of a track at the time that is looked at; undefined: there is none.
export const keyAt = (track, share = here()) => Object.keys(track).find((time) => isTime(time) && Math.abs(timeOf(time) - share) < 0.5 / Math.max(1, desk.state.frames - 1));
// A change of a key: where the key has key frames, of that at the time that is looked at.
export const keyed = (path, value) => {
  const old = given(path);
  if (!isTrack(old)) return [path, value];
  const at = keyAt(old), before = at ? old[at] : undefined;
  const track = { ...old, [at ?? timeText(here())]: isTrack(before) ? { ...before, value } : value };
  return [path, trackText(track)];
};
// Add an entry to a list of the job, which may not be there yet.
export const addTo = (path, entry) => {
  const list = given(path) ?? [];
  change([list.length ? [`${path}[${list.length}]`, flow(entry)] : [path, flow([entry])]]);
};
