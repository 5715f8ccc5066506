// SPDX-License-Identifier: BSD-3-Clause
// What is asked of the server: changes of the job, one at a time, of which the last wins; and news.

const address = location.pathname;
// The state of the job as the server tells it; what the last picture shows; the size of the picture; which revisions were
// shown: at all, as they stay, and in plain light.
export const desk = { state: null, view: null, size: null, revision: 0, seen: 0, plain: 0 };
const listeners = { state: [], view: [], picture: [], status: [] };
export const on = (what, listener) => listeners[what].push(listener);
// A mistake in one listener is told in the console, and hides nothing from the others.
const tell = (what, ...news) => listeners[what].forEach((listener) => {
  try {
    listener(...news);
  } catch (mistake) {
    reportError(mistake);
  }
});
export const say = (text, kind = "") => tell("status", text, kind);

export const wait = (ms) => new Promise((done) => setTimeout(done, ms));

export const post = (verb, body) => fetch(address + verb, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(body) });

// Ask for something whose answer is JSON; null after a mistake, which is told.
export const ask = async (verb, body = {}) => {
  try {
    const answer = await post(verb, body);
    const json = await answer.json();
    if (json.refused) say(json.notes.join("\n"), "error");
    return answer.ok && !json.refused ? json : null;
  } catch {
    say("The desk does not answer.", "error");
    return null;
  }
};

// Show a picture; what was refused is told instead.
const show = async (answer, final) => {
  if (!answer.headers.has("X-View")) {
    say((await answer.json()).notes.join("\n"), "error");
    return true;
  }
  const view = JSON.parse(answer.headers.get("X-View"));
  const picture = await createImageBitmap(await answer.blob());
  if (view.revision < desk.revision) return false; // something newer was shown meanwhile
  desk.revision = view.revision;
  desk.view = view;
  tell("view", view);
  tell("picture", picture, final && view.fits && !view.more);
  return true;
};

// ---- changes ----

let wanted = null, busy = false;
const pump = async () => {
  if (busy || !wanted) return;
  const move = { ...wanted, edits: [...(wanted.edits ?? [])], size: desk.size };
  wanted = null;
  busy = true;
  try {
    await show(await post("move", move), false);
  } catch {
    say("The desk does not answer.", "error");
  }
  busy = false;
  pump();
};
// Change keys of the job, [[path, value], ...]; group: changes of the same one are undone together.
export const change = (edits, group = "", frame = undefined) => {
  const all = new Map(wanted?.edits ?? []);
  for (const [path, value] of edits) all.set(path, value);
  wanted = { edits: all, group, frame: frame ?? wanted?.frame };
  pump();
};
export const isMoving = () => busy || wanted !== null;

// ---- news ----

// Ask again and again for what is newer than what there is.
const follow = async (verb, body, use) => {
  for (let fails = 0; ;) {
    // A browser has few connections to a server, for all its windows together.
    while (document.hidden) await new Promise((seen) => document.addEventListener("visibilitychange", seen, { once: true }));
    try {
      const answer = await post(verb, body());
      if (answer.status === 200) await use(answer);
      if (answer.status !== 200 && answer.status !== 204) await wait(500);
      if (fails) say("");
      fails = 0;
    } catch {
      say(fails ? "The desk does not answer; trying again." : "", "error");
      await wait(Math.min(4000, 250 * 2 ** fails++));
    }
  }
};

// Tell how far volume and light are prepared, until they are as the job asks.
let watching = false;
const isReady = () => desk.state?.fits && !desk.view?.more;
const progress = async () => {
  if (watching) return;
  watching = true;
  while (!isReady()) {
    try {
      const { stage, share } = await (await post("progress", {})).json();
      if (stage && !isReady()) say(`${stage}${share >= 0 ? ` ${Math.round(100 * share)} %` : ""} …`);
    } catch { /* the others tell it */ }
    await wait(250);
  }
  watching = false;
  say("");
};

export const begin = () => {
  progress();
  follow("state", () => ({ after: desk.state?.revision ?? 0 }), async (answer) => {
    const state = await answer.json(), before = new Set(desk.state?.tissues.map((tissue) => tissue.id));
    // Of a tissue that is shown again nothing is known until the volume is prepared anew.
    state.tissues = state.tissues.filter((tissue) => tissue.known || (!state.fits && before.has(tissue.id)));
    desk.state = state;
    tell("state", desk.state);
    if (!desk.state.fits) progress();
  });
  follow("picture", () => ({ after: desk.seen, plain: desk.plain, size: desk.size }), async (answer) => {
    if (!await show(answer, true)) return;
    if (!desk.view?.more) desk.seen = desk.revision;
    else {
      desk.plain = desk.revision;
      progress();
    }
  });
};
// The size of the picture is another one: draw it anew.
export const resized = () => { desk.seen = -1; };
