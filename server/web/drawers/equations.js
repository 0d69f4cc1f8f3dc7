// Equations: the pendulum's equations of motion as the paper prints them, and as programs to take
// away.
// Leaves to others: writing them (the server), setting them (KaTeX).
// Invariant: what is shown and copied is what the server wrote for the pendulum on the stage.

import { said } from "../client.js";
import { createBag, h, iconButton } from "../dom.js";
import { ROOT } from "../root.js";
import { pendulumOf } from "../terms.js";
import { aborted, button, choice, copyButton, settled } from "./kit/kit.js";

const PARTS = ["parameters", "z", "S", "B", "M", "aaa", "bbb"];
const FORMS = ["explicit", "compact"];
const EXPLICIT = 8; // written out by itself
const MOST = 20; // written out when asked for
const SETTING = {
  displayMode: true,
  fleqn: true,
  throwOnError: false,
  strict: "ignore",
  trust: false,
  maxExpand: 10000,
  maxSize: 50,
};

/**
 * The server's answer.
 * @typedef {{latex: Record<string, string>, code: {matlab: string, python: string}, curl: string}}
 * Written
 */

/**
 * The drawer while it is there; form: as the reader wants it, null as suits the size; written: what
 * the server wrote, and for what.
 * @typedef {ReturnType<typeof partsOf> & {
 *   app: App, katex: any, shown: boolean, form: string | null, stop: AbortController | null,
 *   written: {pendulum: Tree, initial: State, form: string, answer: Written} | null,
 * }} View
 */

/** What can be taken away. @type {Record<string, (answer: Written) => string>} */
const COPIES = {
  latex: ({ latex }) =>
    PARTS.filter((part) => latex[part])
      .map((part) => `% ${part}\n\\[${latex[part]}\\]`)
      .join("\n\n"),
  matlab: ({ code }) => code.matlab,
  python: ({ code }) => code.python,
  curl: ({ curl }) => curl.replace(/http:\/\/127\.0\.0\.1:8080\//, ROOT),
};

/** @param {Text} text */
function partsOf(text) {
  const formulas = h("div", {});
  const sheet = h("div", {});
  const close = iconButton("close", text("close"), () => large.close(), {
    "data-large": "close",
  });
  const large = h(
    "dialog",
    { class: "large", "aria-label": text("drawer.equations") },
    close,
    sheet,
  );
  const show = () => {
    sheet.replaceChildren(formulas.cloneNode(true));
    large.showModal();
  };
  return {
    formulas,
    large,
    enlarge: button(text("equations.large"), show, { "data-large": "open" }),
    status: h("p", { class: "quiet", role: "status" }),
    formPlace: h("div", { class: "row" }),
  };
}

/** The form of so many arms. @param {View} view @param {number} n */
function formOf({ form }, n) {
  if (n > MOST) return "compact";
  return form ?? (n > EXPLICIT ? "compact" : "explicit");
}

/** @param {View} view */
function showForm(view) {
  const { app, formPlace, enlarge } = view;
  const { store, text } = app;
  const n = store.get().pendulum.length.length;
  const forms = FORMS.map((value) => ({ value, words: text(`equations.${value}`) }));
  const pick = choice(text("equations.form"), forms, formOf(view, n), (value) => {
    view.form = value;
    load(view);
  });
  pick.select.dataset.form = "";
  pick.select.disabled = n > MOST;
  formPlace.replaceChildren(pick.element, enlarge);
  if (n > MOST) formPlace.append(h("span", { class: "quiet" }, text("equations.tooMany")));
}

/** @param {View} view @param {Written} answer */
function show({ app, katex, formulas }, { latex }) {
  const sections = PARTS.filter((part) => latex[part]).map((part) => {
    const name = app.text(`equations.${part}`);
    const region = { class: "formula scroll", tabindex: 0, role: "region", "aria-label": name };
    const place = h("div", region);
    katex.render(latex[part], place, SETTING);
    return h("section", { "data-part": part }, h("h3", {}, name), place);
  });
  formulas.replaceChildren(...sections);
}

/** @param {View} view @param {Doc} doc @param {string} form */
async function write(view, { pendulum, initial }, form) {
  view.stop?.abort();
  view.stop = new AbortController();
  const start = { phi: initial.phi, phid: initial.phid };
  const body = { pendulum: pendulumOf(pendulum), initial: start, form };
  const answer = await view.app.client.equations(body, { signal: view.stop.signal });
  const same = view.written?.pendulum === pendulum && view.written.form === form;
  view.written = { pendulum, initial, form, answer };
  view.status.textContent = "";
  if (!same) show(view, answer);
}

/** The equations of the pendulum on the stage, where they are not here yet. @param {View} view */
async function load(view) {
  const { app, shown, written } = view;
  if (!shown) return;
  const doc = app.store.get();
  const form = formOf(view, doc.pendulum.length.length);
  const same = written?.pendulum === doc.pendulum && written.initial === doc.initial;
  if (same && written.form === form) return;
  try {
    await write(view, doc, form);
  } catch (error) {
    if (!aborted(error)) view.status.textContent = said(error, app.text);
  }
}

/** @param {View} view @param {string} kind */
async function give(view, kind) {
  await load(view);
  return view.written ? COPIES[kind](view.written.answer) : "";
}

/** @param {HTMLElement} element @param {View} view */
function lay(element, view) {
  const { app, formPlace, status, formulas, large } = view;
  const { text } = app;
  const buttons = Object.keys(COPIES).map((kind) => {
    const key = copyButton(app, text(`equations.${kind}`), () => give(view, kind));
    key.dataset.copy = kind;
    return key;
  });
  const group = { class: "row", role: "group", "aria-label": text("equations.copy") };
  element.append(
    h("h2", {}, text("drawer.equations")),
    h("p", { class: "quiet" }, text("equations.intro")),
    formPlace,
    h("div", group, h("span", { class: "quiet" }, text("equations.copy")), ...buttons),
    h("p", { class: "quiet small" }, text("equations.copyHint"), " ", text("angles.interface")),
    status,
    formulas,
    large,
  );
}

/** @param {HTMLElement} element @param {App} app @returns {Promise<Drawer>} */
async function mount(element, app) {
  const { files, store } = app;
  const coming = [files.script("lib/katex.js"), files.style("lib/katex.css")];
  const [{ default: katex }] = await Promise.all(coming);
  const bag = createBag();
  const state = { shown: false, form: null, stop: null, written: null };
  /** @type {View} */
  const view = { ...partsOf(app.text), app, katex, ...state };
  lay(element, view);
  const soon = settled(() => load(view), 200);
  bag(soon.end);
  bag(() => view.stop?.abort());
  bag(
    store.subscribe((doc, before) => {
      if (doc.pendulum !== before.pendulum) showForm(view);
      if (doc.pendulum !== before.pendulum || doc.initial !== before.initial) soon();
    }),
  );
  showForm(view);
  return {
    show() {
      view.shown = true;
      load(view);
    },
    hide() {
      view.shown = false;
    },
    destroy() {
      bag.end();
      element.replaceChildren();
    },
  };
}

/** @type {DrawerPart} */
export default { id: "equations", title: (text) => text("drawer.equations"), mount };
