// Equations: the pendulum's equations of motion as the paper prints them, and as programs to take away.
// Leaves to others: writing them (the server), setting them (KaTeX).
// Invariant: what is shown and copied is what the server wrote for the pendulum on the stage.

import { createBag, h, iconButton } from "../dom.js";
import { said } from "../client.js";
import { script, style } from "../files.js";
import { aborted, button, choice, copyButton, settled } from "./kit.js";

const PARTS = ["parameters", "z", "S", "B", "M", "aaa", "bbb"];
const EXPLICIT = 8; // written out by itself
const MOST = 20; // written out when asked for

async function mount(element, app) {
  const [{ default: katex }] = await Promise.all([script("lib/katex.js"), style("lib/katex.css")]);
  const { store, client, text } = app;
  const bag = createBag();
  const status = h("p", { class: "quiet", role: "status" });
  const formulas = h("div", {});
  const formPlace = h("div", { class: "row" });
  let shown = false;
  let form = null; // as the reader wants it; null: as suits the size
  let stop = null;
  let written = null; // {pendulum, initial, form, answer}

  const formOf = (n) => (n > MOST ? "compact" : (form ?? (n > EXPLICIT ? "compact" : "explicit")));

  function fields() {
    const n = store.get().pendulum.length.length;
    const pick = choice(
      text("equations.form"),
      ["explicit", "compact"].map((value) => ({ value, words: text(`equations.${value}`) })),
      formOf(n),
      (value) => {
        form = value;
        load();
      },
    );
    pick.select.dataset.form = "";
    pick.select.disabled = n > MOST;
    formPlace.replaceChildren(
      pick.element,
      enlarge,
      ...(n > MOST ? [h("span", { class: "quiet" }, text("equations.tooMany"))] : []),
    );
  }

  function show({ latex }) {
    formulas.replaceChildren(
      ...PARTS.filter((part) => latex[part]).map((part) => {
        const place = h("div", {
          class: "formula scroll",
          tabindex: 0,
          role: "region",
          "aria-label": text(`equations.${part}`),
        });
        katex.render(latex[part], place, {
          displayMode: true,
          fleqn: true,
          throwOnError: false,
          strict: "ignore",
          trust: false,
          maxExpand: 10000,
          maxSize: 50,
        });
        return h("section", { "data-part": part }, h("h3", {}, text(`equations.${part}`)), place);
      }),
    );
  }

  async function load() {
    if (!shown) return;
    const { pendulum, initial } = store.get();
    const wanted = formOf(pendulum.length.length);
    if (written?.pendulum === pendulum && written.initial === initial && written.form === wanted)
      return;
    stop?.abort();
    stop = new AbortController();
    try {
      const { length, mass, parent, gravity } = pendulum;
      const body = {
        pendulum: { length, mass, parent, gravity },
        initial: { phi: initial.phi, phid: initial.phid },
        form: wanted,
      };
      const answer = await client.equations(body, { signal: stop.signal });
      const same = written?.pendulum === pendulum && written.form === wanted;
      written = { pendulum, initial, form: wanted, answer };
      status.textContent = "";
      if (!same) show(answer);
    } catch (error) {
      if (!aborted(error)) status.textContent = said(error, text);
    }
  }

  /** One document of all formulas. */
  const latexOf = ({ latex }) =>
    PARTS.filter((part) => latex[part])
      .map((part) => `% ${part}\n\\[${latex[part]}\\]`)
      .join("\n\n");

  const copies = {
    latex: latexOf,
    matlab: ({ code }) => code.matlab,
    python: ({ code }) => code.python,
    curl: ({ curl }) => curl.replace(/http:\/\/127\.0\.0\.1:8080/, location.origin),
  };

  async function give(kind) {
    await load();
    return written ? copies[kind](written.answer) : "";
  }

  const sheet = h("div", {});
  const large = h(
    "dialog",
    { class: "large", "aria-label": text("drawer.equations") },
    iconButton("close", text("equations.close"), () => large.close(), { "data-large": "close" }),
    sheet,
  );
  const enlarge = button(
    text("equations.large"),
    () => {
      sheet.replaceChildren(formulas.cloneNode(true));
      large.showModal();
    },
    { "data-large": "open" },
  );

  const buttons = Object.keys(copies).map((kind) => {
    const key = copyButton(app, text(`equations.${kind}`), () => give(kind));
    key.dataset.copy = kind;
    return key;
  });

  element.append(
    h("h2", {}, text("drawer.equations")),
    h("p", { class: "quiet" }, text("equations.intro")),
    formPlace,
    h(
      "div",
      { class: "row", role: "group", "aria-label": text("equations.copy") },
      h("span", { class: "quiet" }, text("equations.copy")),
      ...buttons,
    ),
    h("p", { class: "quiet small" }, text("equations.copyHint")),
    status,
    formulas,
    large,
  );

  const soon = settled(load, 200);
  bag(soon.end);
  bag(() => stop?.abort());
  bag(
    store.subscribe((doc, before) => {
      if (doc.pendulum !== before.pendulum) fields();
      if (doc.pendulum !== before.pendulum || doc.initial !== before.initial) soon();
    }),
  );
  fields();

  return {
    show() {
      shown = true;
      load();
    },
    hide() {
      shown = false;
    },
    destroy() {
      bag.end();
      element.replaceChildren();
    },
  };
}

export default { id: "equations", title: (text) => text("drawer.equations"), mount };
