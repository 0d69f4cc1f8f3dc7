// The pendulums that were made in this browser, newest first, each as a small picture; a click puts
// one on the stage, as it was left.
// Leaves to others: keeping them (journal.js), drawing one (preset_picture.js).
// Invariant: what is taken from the list is taken by hand; what another tab has made is shown when
// the examples are opened next.

import { h, iconButton } from "../dom.js";
import { createPicture, pose } from "../preset_picture.js";
import { button, cssValue } from "./kit/kit.js";

/** @typedef {import("../journal.js").Entry} Entry */

/** @param {App} app @param {Entry} entry */
function choose({ store, clock, announce, text, yours }, entry) {
  const patch = yours.patch(entry);
  if (!patch) return;
  const view = { ...patch.view, drawer: store.get().view.drawer };
  store.set({ ...patch, view }, { label: "yours" });
  announce(text("said.preset", { name: nameOf(text, entry) }));
  clock.play();
}

/** @param {Text} text @param {Entry} entry */
function nameOf(text, { scene, when }) {
  const time = new Date(when).toLocaleString(text.language, {
    weekday: "short",
    hour: "2-digit",
    minute: "2-digit",
  });
  return String(scene.title || "") || text("yours.from", { time });
}

/** @param {App} app @param {HTMLElement} place @param {Entry} entry */
function cardOf(app, place, entry) {
  const { text, yours } = app;
  const n = entry.scene.request.pendulum.length.length;
  const canvas = h("canvas", { "aria-hidden": "true" });
  const name = nameOf(text, entry);
  const on = { click: () => choose(app, entry) };
  const key = h(
    "button",
    { type: "button", class: "preset", "data-yours": entry.id, on },
    canvas,
    h("span", { class: "preset-name" }, name),
    h("span", { class: "quiet" }, text.count("presets.arms", n)),
  );
  const remove = () => {
    yours.keep(yours.list().filter(({ id }) => id !== entry.id));
    fillYours(app, place);
    place.querySelector("button")?.focus();
  };
  const close = iconButton("close", text("yours.remove", { name }), remove);
  const draw = () => {
    const { request } = entry.scene;
    const colours = {
      pivot: cssValue("--faint"),
      line: cssValue("--quiet"),
      mass: cssValue("--mass"),
    };
    createPicture(canvas, pose({ ...request, name, title: name, description: "", n }))(0, colours);
  };
  return { element: h("div", { class: "yours-card" }, key, close), draw };
}

/** @param {App} app @param {HTMLElement} place */
export default function fillYours(app, place) {
  const { text, yours } = app;
  const entries = yours.list().filter((entry) => yours.patch(entry));
  place.replaceChildren();
  if (!entries.length) return;
  const cards = entries.map((entry) => cardOf(app, place, entry));
  const clear = () => {
    yours.keep([]);
    fillYours(app, place);
  };
  place.append(
    h("h3", {}, text("yours.title")),
    h("p", { class: "quiet" }, text("yours.words")),
    h("div", { class: "gallery yours" }, ...cards.map(({ element }) => element)),
    h("p", {}, button(text("yours.clear"), clear, { "data-act": "forget" })),
    h("h3", {}, text("presets.ours")),
  );
  for (const { draw } of cards) draw();
}
