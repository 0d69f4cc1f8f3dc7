// The line at the top: the page's name, what is shown, a new pendulum, undo and redo, help, the
// reference, language and theme.
// Leaves to others: what these change.
// Invariant: a button that would do nothing is disabled.

import { createBag, h, icon, iconButton } from "./dom.js";
import { DOCS } from "./root.js";
import { LANGUAGES } from "./text/languages.js";

const KEYS = ["tab", "turn", "length", "mass", "add", "delete", "trail", "enter", "space", "undo"];

/** What can be done, and with which keys. @param {App} app */
function helpOf({ text, offline }) {
  const without = h("p", { class: "quiet", "data-offline": "" });
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
    h("p", { class: "quiet" }, text("help.paper"), " ", h("a", { href: DOCS }, text("help.docs"))),
    without,
  );
  dialog.addEventListener("click", (event) => event.target === dialog && dialog.close());
  const show = () => {
    without.textContent = text(`offline.${offline.kind}`);
    dialog.showModal();
  };
  return { dialog, show };
}

/** The two buttons of the history. @param {App} app */
function historyOf({ text, undo, redo }) {
  return {
    undo: iconButton("undo", text("undo"), () => undo(), { "data-act": "undo" }),
    redo: iconButton("redo", text("redo"), () => redo(), { "data-act": "redo" }),
  };
}

/** The choice of a language. @param {App} app */
function tongueOf({ text, speak }) {
  const options = Object.entries(LANGUAGES).map(([id, name]) => {
    const attributes = { value: id, selected: id === text.language, lang: id };
    // closed, the select is as wide as the short name
    return h("option", attributes, `${id.toUpperCase()}\u2003${name}`);
  });
  const change = () => speak(tongue.value);
  const tongue = h(
    "select",
    { class: "tongue", "aria-label": text("language"), on: { change } },
    ...options,
  );
  return tongue;
}

/**
 * On a phone a key opens what else the head has, and a press elsewhere closes it.
 * @param {App} app @param {HTMLElement} element @param {Bag} bag
 */
function moreOf({ text }, element, bag) {
  const open = (/** @type {boolean} */ on) => {
    element.classList.toggle("more", on);
    key.setAttribute("aria-expanded", String(on));
  };
  const turn = () => open(!element.classList.contains("more"));
  const key = iconButton("more", text("more"), turn, { "data-act": "more" });
  open(false);
  bag.on(document, "pointerdown", ({ target }) => key.contains(target) || leave(target));
  const used = (/** @type {MouseEvent} */ { target }) =>
    /** @type {Element} */ (target).closest(".rest .icon-button") && open(false);
  bag.on(element, "click", used, { capture: true });
  bag.on(element, "keydown", ({ key: name }) => name === "Escape" && open(false));
  const leave = (/** @type {Element} */ target) => target.closest?.(".rest") || open(false);
  return key;
}

/** What is shown, in words. @param {Text} text @param {Doc} doc */
export function titleOf(text, { preset, title }) {
  return preset && text.has(`preset.${preset}`) ? text(`preset.${preset}`) : title;
}

/** @param {HTMLElement} element @param {App} app */
export function mountHeader(element, app) {
  const { store, text, theme } = app;
  const bag = createBag();
  const help = helpOf(app);
  const { undo, redo } = historyOf(app);
  const shade = iconButton("dark", text("theme"), () => theme.toggle(), { "data-act": "theme" });
  const title = h("p", { class: "title" });
  const docs = h("a", { class: "docs-link", href: DOCS, title: text("help.docs") }, text("docs"));
  const begin = {
    type: "button",
    class: "button",
    "data-act": "new",
    on: { click: () => app.edits.begin() },
  };
  const ask = iconButton("help", text("help.title"), help.show, { "data-act": "help" });
  const anew = h("button", begin, text("new"));
  const rest = h("div", { class: "rest" }, redo, ask, docs, tongueOf(app), shade);
  const tools = h("div", { class: "tools" }, anew, undo, moreOf(app, element, bag), rest);
  element.append(h("h1", {}, text("name")), title, tools, help.dialog);

  /** @param {Doc} doc */
  function show(doc) {
    undo.disabled = !store.canUndo();
    redo.disabled = !store.canRedo();
    title.textContent = titleOf(text, doc);
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
