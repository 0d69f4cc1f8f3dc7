// What the colours say: the scale of the forces with its numbers and its sign in words, and the switches of what is seen.
// Leaves to others: the colours (paint.js), the scale's end (camera.js).
// Invariant: its colours are those of the arms.

import { createBag, h, iconButton } from "./dom.js";

export function mountLegend(element, app, look) {
  const { store, text } = app;
  const bag = createBag();
  const bar = h("div", { class: "legend-bar", "aria-hidden": "true" });
  const ticks = [0, 1, 2, 3, 4].map(() => h("span"));
  const arrows = iconButton(
    "arrows",
    text("legend.arrows"),
    () => store.set({ view: { arrows: !store.get().view.arrows } }),
    { "data-act": "arrows" },
  );
  const palette = h(
    "button",
    {
      type: "button",
      class: "icon-button",
      "data-act": "palette",
      "aria-label": text("legend.palette"),
      title: text("legend.palette"),
      on: {
        click: () =>
          store.set({ view: { palette: store.get().view.palette === "safe" ? "paper" : "safe" } }),
      },
    },
    h("span", { class: "swatch" }),
  );
  const legend = h(
    "div",
    { class: "legend", role: "group", "aria-label": text("legend") },
    h(
      "div",
      { class: "legend-scale" },
      bar,
      h("div", { class: "legend-ticks" }, ...ticks),
      h(
        "div",
        { class: "legend-words" },
        h("span", {}, text("legend.tension")),
        h("span", {}, text("legend.compression")),
      ),
    ),
    arrows,
    palette,
  );
  element.append(legend);

  function show() {
    const { bins } = look.colours;
    bar.style.backgroundImage = `linear-gradient(90deg, ${bins.join(", ")})`;
    palette.firstChild.style.backgroundImage = `linear-gradient(90deg, ${bins[0]} 0 33%, ${bins[bins.length >> 1]} 33% 66%, ${bins.at(-1)} 66%)`;
    ticks.forEach((tick, i) => {
      const value = look.most * (i / 2 - 1);
      tick.textContent = look.most ? text.short(value, 3) + (i === 4 ? "\u00a0N" : "") : "";
    });
    const { view } = store.get();
    document.documentElement.dataset.palette = view.palette;
    arrows.setAttribute("aria-pressed", view.arrows);
    palette.setAttribute("aria-pressed", view.palette === "paper");
  }

  bag(store.subscribe((doc, before) => doc.view !== before.view && show()));
  show();
  return { show, destroy: bag.end };
}
