// What the colours say: the scale of the forces with its numbers and its sign in words, and the
// switches of what is seen.
// Leaves to others: the colours (palette.js), the scale's end (camera.js).
// Invariant: its colours are those of the arms.

import { createBag, h, iconButton } from "./dom.js";
import { isBeside } from "./state.js";

/** The legend's parts. @param {App} app */
function partsOf({ store, text, edits }) {
  const view = () => store.get().view;
  const turnArrows = () => store.set({ view: { arrows: !view().arrows } });
  const turnPalette = () =>
    store.set({ view: { palette: view().palette === "safe" ? "paper" : "safe" } });
  const swatch = h("span", { class: "swatch" });
  const label = text("legend.palette");
  const attributes = {
    "data-act": "palette",
    "aria-label": label,
    title: label,
    on: { click: turnPalette },
  };
  return {
    bar: h("div", { class: "legend-bar", "aria-hidden": "true" }),
    ticks: [0, 1, 2, 3, 4].map(() => h("span")),
    arrows: iconButton("arrows", text("legend.arrows"), turnArrows, { "data-act": "arrows" }),
    swatch,
    swap: iconButton("swap", text("stage.other"), edits.swap, { "data-act": "swap" }),
    palette: h("button", { type: "button", class: "icon-button", ...attributes }, swatch),
  };
}

/** @param {App} app @param {Look} look @param {ReturnType<typeof partsOf>} parts */
function fill({ store, text }, look, { bar, ticks, arrows, swatch, palette, swap }) {
  const { bins } = look.colours;
  const [low, none, high] = [bins[0], bins[bins.length >> 1], bins[bins.length - 1]];
  bar.style.backgroundImage = `linear-gradient(90deg, ${bins.join(", ")})`;
  swatch.style.backgroundImage = `linear-gradient(90deg, ${low} 0 33%, ${none} 33% 66%, ${high} 66%)`;
  ticks.forEach((tick, i) => {
    const value = look.most * (i / 2 - 1);
    tick.textContent = look.most ? text.short(value, 3) + (i === 4 ? "\u00a0N" : "") : "";
  });
  const { view } = store.get();
  document.documentElement.dataset.palette = view.palette;
  arrows.setAttribute("aria-pressed", String(view.arrows));
  palette.setAttribute("aria-pressed", String(view.palette === "paper"));
  swap.hidden = !store.get().ghosts.some(isBeside);
}

/** @param {HTMLElement} element @param {App} app @param {Look} look */
export function mountLegend(element, app, look) {
  const { store, text } = app;
  const bag = createBag();
  const parts = partsOf(app);
  const tension = h("span", {}, text("legend.tension"));
  const compression = h("span", {}, text("legend.compression"));
  const scale = h(
    "div",
    { class: "legend-scale" },
    parts.bar,
    h("div", { class: "legend-ticks" }, ...parts.ticks),
    h("div", { class: "legend-words" }, tension, compression),
  );
  const attributes = { class: "legend", role: "group", "aria-label": text("legend") };
  element.append(h("div", attributes, scale, parts.swap, parts.arrows, parts.palette));
  const show = () => fill(app, look, parts);
  bag(
    store.subscribe((doc, before) => {
      if (doc.view !== before.view || doc.ghosts !== before.ghosts) show();
    }),
  );
  show();
  return { show, destroy: bag.end };
}
