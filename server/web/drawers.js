// The drawers beside the stage (below it on a phone): one open at a time, its files loaded when it
// is opened first.
// Leaves to others: their insides (gallery.js, drawers/*.js).
// Invariant: which one is open is view.drawer of the document; a drawer that is hidden is told so;
// one whose files do not come says so, and is built when they do.

import { said } from "./client.js";
import { createBag, h, icon, iconButton } from "./dom.js";
import presets from "./gallery.js";
import { DRAWERS } from "./state.js";

/** Words that a drawer has beside those of all. @type {Record<string, string[]>} */
const WORDS = {
  physics: ["physics"],
  compare: ["physics"],
  control: ["physics"],
  measure: ["measure"],
  plots: ["measure"],
  class: ["class"],
  worksheet: ["class"],
};

const IN_CLASS = ["class", "worksheet"];

/**
 * The drawers while they are there; open: promises of those that have been opened, null where its
 * files did not come.
 * @typedef {{
 *   app: App, element: HTMLElement, open: Map<string, Promise<Drawer | null>>, tabs: Map<string,
 *   HTMLButtonElement>,
 *   panels: Map<string, HTMLElement>, scrolled: Map<string, number>, shown: string | null,
 * }} Chest
 */

/**
 * The examples are part of the page: on a wide screen they lie open from the start.
 * @param {App} app @param {string} id @returns {Promise<DrawerPart>}
 */
async function partOf({ files, text }, id) {
  if (id === presets.id) return presets;
  const words = WORDS[id] ?? [];
  const [{ default: part }] = await Promise.all([
    files.script(`drawers/${id}.js`),
    ...["drawers", ...words].map((name) => text.part(name)),
  ]);
  return part;
}

/**
 * In words, with a button that tries again.
 * @param {Chest} chest @param {string} id @param {any} error
 */
function missing(chest, id, error) {
  const { text } = chest.app;
  const attributes = {
    type: "button",
    class: "button",
    "data-again": id,
    on: { click: () => anew(chest, id) },
  };
  const words = said(error.kind ? error : { kind: "page" }, text);
  const fault = h("p", { class: "fault", role: "alert" }, words);
  chest.panels.get(id)?.replaceChildren(fault, h("button", attributes, text("again")));
}

/**
 * @param {Chest} chest @param {string} id @param {HTMLElement} panel @returns {Promise<Drawer |
 * null>}
 */
async function mount(chest, id, panel) {
  panel.setAttribute("aria-busy", "true");
  panel.replaceChildren();
  try {
    const part = await partOf(chest.app, id);
    return await part.mount(panel, chest.app);
  } catch (error) {
    missing(chest, id, error);
    return null;
  } finally {
    panel.removeAttribute("aria-busy");
  }
}

/** @param {Chest} chest @param {string} id @param {HTMLElement} panel */
function opened(chest, id, panel) {
  const coming = chest.open.get(id) ?? mount(chest, id, panel);
  chest.open.set(id, coming);
  return coming;
}

/**
 * Shows or hides a drawer that has been opened, or is now.
 * @param {Chest} chest @param {string} id @param {boolean} shown
 */
async function show(chest, id, shown) {
  const { open, panels, app } = chest;
  const panel = panels.get(id);
  if (!panel) return;
  panel.hidden = !shown;
  const coming = shown ? opened(chest, id, panel) : open.get(id);
  const drawer = await coming;
  // by now another one may be open, or this one tried again
  if (open.get(id) !== coming) return;
  if (!drawer) open.delete(id);
  else if (app.store.get().view.drawer === id) drawer.show();
  else drawer.hide();
}

/** Tries again what did not come. @param {Chest} chest @param {string | null} id */
function anew(chest, id) {
  const { open, app } = chest;
  if (id && app.store.get().view.drawer === id && !open.has(id)) show(chest, id, true);
}

/** @param {Chest} chest @param {Doc} doc */
function follow(chest, doc) {
  const wanted = doc.view.drawer;
  const { scrolled, shown } = chest;
  const place = chest.element.querySelector(".panels");
  // each drawer is found again where it was left, another one at its beginning
  if (place && shown) scrolled.set(shown, place.scrollTop);
  chest.shown = wanted;
  chest.element.classList.toggle("open", wanted !== null);
  for (const [id, tab] of chest.tabs) {
    const chosen = id === wanted;
    tab.setAttribute("aria-selected", String(chosen));
    tab.tabIndex = chosen || (wanted === null && id === DRAWERS[0]) ? 0 : -1;
    if (chosen || chest.open.has(id)) show(chest, id, chosen);
  }
  if (place && wanted && wanted !== shown && scrolled.size)
    place.scrollTop = scrolled.get(wanted) ?? 0;
}

/** A drawer's tab and its place. @param {Chest} chest @param {string} id */
function addTab({ app, tabs, panels }, id) {
  const { store, text } = app;
  const toggle = () => store.set({ view: { drawer: store.get().view.drawer === id ? null : id } });
  const words = text(`drawer.${id}`);
  const links = {
    id: `tab-${id}`,
    "aria-controls": `panel-${id}`,
    "data-tab": id,
    "data-words": words,
  };
  tabs.set(
    id,
    h("button", { type: "button", role: "tab", ...links, on: { click: toggle } }, words),
  );
  const back = { id: `panel-${id}`, "aria-labelledby": `tab-${id}`, "data-drawer": id };
  panels.set(id, h("div", { role: "tabpanel", ...back, hidden: true, tabindex: -1 }));
}

/**
 * The names in the order that their reader needs: in a class its drawers come first; a pupil's
 * worksheet lies in that of the class.
 */
function orderOf() {
  const { room } = document.documentElement.dataset;
  const first = room ? IN_CLASS : [];
  const all = [...first, ...DRAWERS.filter((id) => !first.includes(id))];
  return room === "pupil" ? all.filter((id) => id !== "worksheet") : all;
}

/** @param {Chest} chest @param {HTMLElement} list */
function arrange({ tabs }, list) {
  list.replaceChildren(...orderOf().map((id) => /** @type {HTMLElement} */ (tabs.get(id))));
}

/**
 * On a small screen the names have one row: a key opens all of them, and another closes the drawer.
 * @param {Chest} chest
 */
function keysOf({ app, element, tabs }) {
  const { store, text } = app;
  const open = (/** @type {boolean} */ on) => {
    element.classList.toggle("menu", on);
    menu.setAttribute("aria-expanded", String(on));
  };
  const turn = () => open(!element.classList.contains("menu"));
  const attributes = {
    type: "button",
    class: "button menu-key",
    "data-act": "menu",
    on: { click: turn },
  };
  const menu = h("button", { ...attributes, "aria-expanded": "false" }, icon("menu"), text("menu"));
  const shut = () => {
    store.set({ view: { drawer: null } });
    tabs.get(DRAWERS[0])?.focus();
  };
  const close = iconButton("close", text("close"), shut, { class: "icon-button close-key" });
  return { menu, close, open };
}

/** Arrows walk the tabs. @param {Chest} chest @param {KeyboardEvent} event */
function walk({ tabs }, event) {
  const steps = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
  if (!steps) return;
  event.preventDefault();
  event.stopPropagation();
  const keys = orderOf().map((id) => /** @type {HTMLElement} */ (tabs.get(id)));
  const at = keys.findIndex((tab) => tab === document.activeElement);
  keys[(at + steps + keys.length) % keys.length].focus();
}

/** @param {HTMLElement} element @param {App} app */
export function mountDrawers(element, app) {
  const { store, client, text } = app;
  const bag = createBag();
  /** @type {Chest} */
  const chest = {
    ...{ app, element, open: new Map(), tabs: new Map(), panels: new Map() },
    ...{ scrolled: new Map(), shown: null },
  };
  for (const id of DRAWERS) addTab(chest, id);
  const attributes = { class: "tabs", role: "tablist", "aria-label": text("drawers") };
  const list = h("div", attributes);
  arrange(chest, list);
  const { menu, close, open } = keysOf(chest);
  element.append(
    h("div", { class: "rail-row" }, list, menu, close),
    h("div", { class: "panels" }, ...chest.panels.values()),
  );
  element.setAttribute("aria-label", text("drawers"));

  bag.on(list, "keydown", (event) => walk(chest, event));
  bag.on(document, "pendulumd-room", () => arrange(chest, list));
  // whoever waits for files may have them when the server is back
  bag(client.watch(({ kind }) => kind === "well" && anew(chest, store.get().view.drawer)));
  bag(
    store.subscribe((doc, before) => {
      if (doc.view.drawer === before.view.drawer) return;
      open(false);
      follow(chest, doc);
    }),
  );
  follow(chest, store.get());
  return {
    destroy() {
      bag.end();
      for (const coming of chest.open.values()) coming.then((drawer) => drawer?.destroy());
      element.replaceChildren();
    },
  };
}
