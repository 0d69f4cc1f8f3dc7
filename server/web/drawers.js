// The drawers beside the stage (below it on a phone): one open at a time, its module loaded when it is opened first.
// Leaves to others: their insides (drawers/*.js).
// Invariant: which one is open is view.drawer of the document; a drawer that is hidden is told so.

import { createBag, h } from "./dom.js";

export const DRAWERS = ["presets", "plots", "modes", "compare", "method", "equations", "share", "worksheet"];

export function mountDrawers(element, app) {
  const { store, text } = app;
  const bag = createBag();
  const open = new Map(); // id -> {panel, drawer}, drawer a promise
  const tabs = new Map();
  const list = h("div", { class: "tabs", role: "tablist", "aria-label": text("drawers") });
  const panels = h("div", { class: "panels" });
  element.append(list, panels);
  element.setAttribute("aria-label", text("drawers"));

  for (const id of DRAWERS) {
    const tab = h("button", { type: "button", role: "tab", id: `tab-${id}`, "aria-controls": `panel-${id}`, "data-tab": id, "data-words": text(`drawer.${id}`),
      on: { click: () => toggle(id) } }, text(`drawer.${id}`));
    tabs.set(id, tab);
    list.append(tab);
    panels.append(h("div", { role: "tabpanel", id: `panel-${id}`, "aria-labelledby": `tab-${id}`, "data-drawer": id, hidden: true, tabindex: -1 }));
  }

  function toggle(id) {
    store.set({ view: { drawer: store.get().view.drawer === id ? null : id } });
  }

  async function mount(id, panel) {
    const { default: drawer } = await import(id === "presets" ? "./gallery.js" : `./drawers/${id}.js`);
    return drawer.mount(panel, app);
  }

  async function show(id, shown) {
    const panel = document.getElementById(`panel-${id}`);
    panel.hidden = !shown;
    if (shown && !open.has(id)) {
      open.set(id, mount(id, panel));
      panel.setAttribute("aria-busy", "true");
    }
    const drawer = await open.get(id);
    panel.removeAttribute("aria-busy");
    // by now another one may be open
    if (!drawer) return;
    if (store.get().view.drawer === id) drawer.show();
    else drawer.hide();
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
  bag(store.subscribe((doc, before) => doc.view.drawer !== before.view.drawer && follow(doc)));
  follow(store.get());
  return {
    destroy() {
      bag.end();
      for (const drawer of open.values()) drawer.then((mounted) => mounted.destroy());
      element.replaceChildren();
    },
  };
}
