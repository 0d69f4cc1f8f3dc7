// The drawers beside the stage (below it on a phone): one open at a time, its libraries loaded when it is opened first.
// Leaves to others: their insides (gallery.js, drawers/*.js).
// Invariant: which one is open is view.drawer of the document; a drawer that is hidden is told so; one whose files do not come
// says so, and is built when they do.

import { said } from "./client.js";
import { createBag, h } from "./dom.js";
import compare from "./drawers/compare.js";
import equations from "./drawers/equations.js";
import method from "./drawers/method.js";
import modes from "./drawers/modes.js";
import plots from "./drawers/plots.js";
import share from "./drawers/share.js";
import worksheet from "./drawers/worksheet.js";
import presets from "./gallery.js";
import { DRAWERS } from "./state.js";

const PARTS = { presets, plots, modes, compare, method, equations, share, worksheet };

export function mountDrawers(element, app) {
  const { store, client, text } = app;
  const bag = createBag();
  const open = new Map(); // id -> a promise of the drawer, null where its files did not come
  const tabs = new Map();
  const list = h("div", { class: "tabs", role: "tablist", "aria-label": text("drawers") });
  const panels = h("div", { class: "panels" });
  element.append(list, panels);
  element.setAttribute("aria-label", text("drawers"));

  for (const id of DRAWERS) {
    const tab = h(
      "button",
      {
        type: "button",
        role: "tab",
        id: `tab-${id}`,
        "aria-controls": `panel-${id}`,
        "data-tab": id,
        "data-words": text(`drawer.${id}`),
        on: { click: () => toggle(id) },
      },
      text(`drawer.${id}`),
    );
    tabs.set(id, tab);
    list.append(tab);
    panels.append(
      h("div", {
        role: "tabpanel",
        id: `panel-${id}`,
        "aria-labelledby": `tab-${id}`,
        "data-drawer": id,
        hidden: true,
        tabindex: -1,
      }),
    );
  }

  function toggle(id) {
    store.set({ view: { drawer: store.get().view.drawer === id ? null : id } });
  }

  /** In words, with a button that tries again. */
  function missing(id, panel, error) {
    const again = h(
      "button",
      { type: "button", class: "button", "data-again": id, on: { click: () => anew(id) } },
      text("again"),
    );
    panel.replaceChildren(h("p", { class: "fault", role: "alert" }, said(error, text)), again);
  }

  async function mount(id, panel) {
    panel.setAttribute("aria-busy", "true");
    panel.replaceChildren();
    try {
      return await PARTS[id].mount(panel, app);
    } catch (error) {
      missing(id, panel, error.kind ? error : Object.assign(error, { kind: "page" }));
      return null;
    } finally {
      panel.removeAttribute("aria-busy");
    }
  }

  async function show(id, shown) {
    const panel = document.getElementById(`panel-${id}`);
    panel.hidden = !shown;
    if (shown && !open.has(id)) open.set(id, mount(id, panel));
    const coming = open.get(id);
    const drawer = await coming;
    // by now another one may be open, or this one tried again
    if (open.get(id) !== coming) return;
    if (!drawer) open.delete(id);
    else if (store.get().view.drawer === id) drawer.show();
    else drawer.hide();
  }

  function anew(id) {
    if (id && store.get().view.drawer === id && !open.has(id)) show(id, true);
  }

  function follow(doc) {
    const wanted = doc.view.drawer;
    element.classList.toggle("open", wanted !== null);
    for (const [id, tab] of tabs) {
      const chosen = id === wanted;
      tab.setAttribute("aria-selected", chosen);
      tab.tabIndex = chosen || (wanted === null && id === DRAWERS[0]) ? 0 : -1;
      if (chosen || open.has(id)) show(id, chosen);
    }
  }

  bag.on(list, "keydown", (event) => {
    const steps = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
    if (!steps) return;
    event.preventDefault();
    event.stopPropagation();
    const at = DRAWERS.findIndex((id) => tabs.get(id) === document.activeElement);
    tabs.get(DRAWERS[(at + steps + DRAWERS.length) % DRAWERS.length]).focus();
  });
  // whoever waits for files may have them when the server is back
  bag(client.watch(({ kind }) => kind === "well" && anew(store.get().view.drawer)));
  bag(store.subscribe((doc, before) => doc.view.drawer !== before.view.drawer && follow(doc)));
  follow(store.get());
  return {
    destroy() {
      bag.end();
      for (const coming of open.values()) coming.then((drawer) => drawer?.destroy());
      element.replaceChildren();
    },
  };
}
