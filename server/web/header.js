// The line at the top: the page's name, undo and redo, language and theme.
// Leaves to others: what these change.
// Invariant: a button that would do nothing is disabled.

import { createBag, h, icon, iconButton } from "./dom.js";
import { LANGUAGES } from "./text.js";
import { theme } from "./theme.js";

export function mountHeader(element, app) {
  const { store, text } = app;
  const bag = createBag();
  const undo = iconButton("undo", text("undo"), () => app.undo());
  const redo = iconButton("redo", text("redo"), () => app.redo());
  const shade = iconButton("dark", text("theme"), () => theme.toggle());
  const tongue = h("select", { "aria-label": text("language"), on: { change: () => app.speak(tongue.value) } },
    ...LANGUAGES.map((name) => h("option", { value: name, selected: name === text.language }, text(`language.${name}`))));
  const title = h("h1", {}, text("name"));
  element.append(title, h("div", { class: "tools" }, undo, redo, tongue, shade));

  const buttons = () => {
    undo.disabled = !store.canUndo();
    redo.disabled = !store.canRedo();
  };
  const look = () => shade.replaceChildren(icon(theme.dark ? "light" : "dark"));
  bag(store.subscribe(buttons));
  bag(theme.subscribe(look));
  buttons();
  look();
  return { destroy: () => { bag.end(); element.replaceChildren(); } };
}
