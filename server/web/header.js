// The line at the top: the page's name, what is shown, a new pendulum, undo and redo, help, the reference, language and theme.
// Leaves to others: what these change.
// Invariant: a button that would do nothing is disabled.

import { createBag, h, icon, iconButton } from "./dom.js";
import { LANGUAGES } from "./text.js";
import { theme } from "./theme.js";

const KEYS = ["tab", "turn", "length", "mass", "add", "delete", "trail", "enter", "space", "undo"];

/** What can be done, and with which keys. */
function helpOf(text) {
  const dialog = h("dialog", { class: "help", "aria-labelledby": "help-title" });
  dialog.append(
    h(
      "div",
      { class: "dialog-head" },
      h("h2", { id: "help-title" }, text("help.title")),
      iconButton("close", text("close"), () => dialog.close()),
    ),
    h("p", {}, text("help.hand")),
    h(
      "dl",
      {},
      ...KEYS.flatMap((key) => [
        h("dt", {}, text(`help.${key}.key`)),
        h("dd", {}, text(`help.${key}`)),
      ]),
    ),
    h(
      "p",
      { class: "quiet" },
      text("help.paper"),
      " ",
      h("a", { href: "/docs" }, text("help.docs")),
    ),
  );
  dialog.addEventListener("click", (event) => event.target === dialog && dialog.close());
  return dialog;
}

export function mountHeader(element, app) {
  const { store, text } = app;
  const bag = createBag();
  const help = helpOf(text);
  const undo = iconButton("undo", text("undo"), () => app.undo(), { "data-act": "undo" });
  const redo = iconButton("redo", text("redo"), () => app.redo(), { "data-act": "redo" });
  const shade = iconButton("dark", text("theme"), () => theme.toggle(), { "data-act": "theme" });
  const tongue = h(
    "select",
    {
      class: "tongue",
      "aria-label": text("language"),
      on: { change: () => app.speak(tongue.value) },
    },
    ...LANGUAGES.map((name) =>
      h(
        "option",
        { value: name, selected: name === text.language, title: text(`language.${name}`) },
        name.toUpperCase(),
      ),
    ),
  );
  const title = h("p", { class: "title" });
  const docs = h(
    "a",
    { class: "docs-link", href: "/docs", title: text("help.docs") },
    text("docs"),
  );
  element.append(
    h("h1", {}, text("name")),
    title,
    h(
      "div",
      { class: "tools" },
      h(
        "button",
        {
          type: "button",
          class: "button",
          "data-act": "new",
          on: { click: () => app.edits.begin() },
        },
        text("new"),
      ),
      undo,
      redo,
      iconButton("help", text("help.title"), () => help.showModal(), { "data-act": "help" }),
      docs,
      tongue,
      shade,
    ),
    help,
  );

  function show(doc) {
    undo.disabled = !store.canUndo();
    redo.disabled = !store.canRedo();
    const preset =
      doc.preset && text.has(`preset.${doc.preset}`) ? text(`preset.${doc.preset}`) : "";
    title.textContent = preset || doc.title;
  }

  const look = () => shade.replaceChildren(icon(theme.dark ? "light" : "dark"));
  bag(store.subscribe(show));
  bag(theme.subscribe(look));
  show(store.get());
  look();
  return {
    destroy: () => {
      bag.end();
      element.replaceChildren();
    },
  };
}
