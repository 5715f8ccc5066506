// SPDX-License-Identifier: BSD-3-Clause
// Buttons, choices, panels, dialogs.
import { el } from "./dom.js";

export const button = (text, title, act, more = {}) => {
  const made = el("button", { type: "button", title, "aria-label": title, ...more }, text);
  made.addEventListener("click", act);
  return made;
};
export const choice = (label, options, act, value) => {
  const made = el("select", { "aria-label": label }, options.map(([key, text]) => el("option", { value: key }, text)));
  if (value !== undefined) made.value = value;
  made.addEventListener("change", () => act(made.value, made));
  return made;
};
export const field = (label, ...controls) => el("label", { class: "field" }, el("span", {}, label), ...controls);

// Tabs: [[name, element], ...]; arrow keys go from one to the next.
export const tabs = (where, pages) => {
  const heads = pages.map(([name, page], i) => {
    const head = el("button", { type: "button", role: "tab", id: `tab-${name}` }, name);
    page.id ||= `page-${name}`;
    head.setAttribute("aria-controls", page.id);
    page.setAttribute("role", "tabpanel");
    page.setAttribute("aria-labelledby", head.id);
    head.addEventListener("click", () => show(i));
    return head;
  });
  const show = (shown) => {
    heads.forEach((head, i) => {
      head.setAttribute("aria-selected", i === shown);
      head.tabIndex = i === shown ? 0 : -1;
      pages[i][1].dataset.shown = i === shown;
    });
    where.dataset.tab = pages[shown][0];
  };
  const list = el("div", { role: "tablist", class: "tabs" }, heads);
  list.addEventListener("keydown", (event) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    const next = (heads.indexOf(document.activeElement) + step + heads.length) % heads.length;
    show(next);
    heads[next].focus();
  });
  where.prepend(list);
  show(0);
  return show;
};

export const dialog = (title, ...children) => {
  const made = el("dialog", { "aria-label": title }, el("h2", {}, title), ...children);
  document.body.append(made);
  made.addEventListener("close", () => made.remove());
  made.showModal();
  return made;
};

// A part of a panel that is made anew when its data change, unless a hand is in it.
export const keepFocus = (where, make) => {
  const name = document.activeElement?.dataset?.name;
  const inside = name && where.contains(document.activeElement);
  make();
  if (inside) where.querySelector(`[data-name=${CSS.escape(name)}]`)?.focus();
};
