// Worksheet: five steps that set the stage, ask a question, and see when it is done.
// Leaves to others: all that is done in a step is done with the stage and the other drawers.
// Invariant: a step is done when the page is in the state it asks for; what was done stays done
// (kept in the browser).

import { createBag, h } from "../dom.js";
import { keep as browser } from "../keep.js";
import { PAPER } from "../state.js";
import { still } from "../screen.js";
import { button } from "./kit.js";

const KEPT = "pendulumd.worksheet";
const HANGING = -Math.PI / 2;
const SPAN = { stop: 20, step: 0.01 };

/**
 * What a step looks at to see whether it is done.
 * @typedef {{doc: Doc, clock: Clock, motion: Motion, cause: Cause | null}} Seen
 */

/**
 * @typedef {{id: string, drawer: string, set: {pendulum: Tree, initial: State}, done: (seen: Seen)
 * => boolean}} Step
 */

/**
 * The drawer while it is there; step: which is shown; done: those that have been; staged: whether
 * it has set the stage.
 * @typedef {{
 *   app: App, step: number, done: Set<string>, staged: boolean, list: HTMLElement, body:
 *   HTMLElement, mark: HTMLElement,
 * }} View
 */

/** A start at rest. @param {...number} degrees from hanging @returns {State} */
const at = (...degrees) => ({
  phi: degrees.map((angle) => HANGING + (angle * Math.PI) / 180),
  phid: degrees.map(() => 0),
});
/** @param {...number} mass @returns {Tree} */
const chain = (...mass) => ({
  length: mass.map(() => 1),
  mass,
  parent: mass.map((_, k) => k),
  gravity: 9.81,
});

/** @type {Step[]} */
const STEPS = [
  {
    id: "single",
    drawer: "modes",
    set: { pendulum: chain(1), initial: at(20) },
    done: ({ doc: { pendulum } }) =>
      pendulum.length.length === 1 && Math.abs(pendulum.length[0] - 4) < 0.2,
  },
  {
    id: "double",
    drawer: "plots",
    set: { pendulum: chain(1, 1), initial: at(90, 90) },
    done: ({ doc: { pendulum } }) =>
      pendulum.mass.length === 2 && pendulum.mass[1] <= 0.1 * pendulum.mass[0] * (1 + 1e-9),
  },
  {
    id: "chaos",
    drawer: "compare",
    set: { pendulum: chain(1, 1), initial: at(120, 120) },
    done: ({ doc }) => doc.ghosts.some((ghost) => !ghost.method),
  },
  {
    id: "modes",
    drawer: "modes",
    set: { pendulum: chain(1, 1), initial: at(12, -4) },
    done: ({ cause }) => cause?.label === "mode",
  },
  {
    id: "forces",
    drawer: "plots",
    set: { pendulum: PAPER.pendulum, initial: PAPER.initial },
    done: ({ doc, clock, motion }) => {
      const stands = !clock.playing && clock.time > 0 && motion.count > 0;
      return (
        doc.pendulum === PAPER.pendulum &&
        stands &&
        motion.at(clock.time).lambda.some((force) => force > 0)
      );
    },
  },
];

/** What the browser has kept: {step, done}. */
function readKept() {
  try {
    const { step = 0, done = [] } = JSON.parse(browser.get(KEPT) ?? "null") ?? {};
    const known = done.filter((/** @type {unknown} */ id) => STEPS.some((one) => one.id === id));
    return { step: STEPS[step] ? step : 0, done: new Set(known) };
  } catch {
    return { step: 0, done: new Set() };
  }
}

/** @param {View} view */
const keep = ({ step, done }) => browser.set(KEPT, JSON.stringify({ step, done: [...done] }));

/** Sets the stage as the step begins. @param {View} view */
function stage(view) {
  const { store, clock } = view.app;
  const { set } = STEPS[view.step];
  const plain = {
    title: "",
    preset: null,
    method: "taylor",
    rtol: null,
    atol: null,
    precision: "double",
    ghosts: [],
  };
  const shown = { trails: [set.pendulum.length.length], selected: 0 };
  store.set({ ...set, span: SPAN, ...plain, view: shown }, { label: "worksheet" });
  view.staged = true;
  if (!still.matches) clock.play();
}

/**
 * @param {View} view @param {number} step @param {boolean} focus whether the step's key gets the
 * focus
 */
function go(view, step, focus = false) {
  view.step = Math.max(0, Math.min(STEPS.length - 1, step));
  keep(view);
  stage(view);
  show(view);
  const key = view.list.children[view.step].firstElementChild;
  if (focus) /** @type {HTMLElement} */ (key).focus();
}

/** @param {View} view */
function showList(view) {
  const { app, list, done, step } = view;
  const { text } = app;
  const keys = STEPS.map(({ id }, i) => {
    const ready = done.has(id);
    const attributes = {
      type: "button",
      "data-step": i + 1,
      class: ready ? "step-key done" : "step-key",
      "aria-current": i === step ? "step" : null,
      on: { click: () => go(view, i, true) },
    };
    const number = h(
      "span",
      { class: "step-number", "aria-hidden": "true" },
      ready ? "\u2713" : String(i + 1),
    );
    const said = ready ? h("span", { class: "unseen" }, `, ${text("worksheet.done")}`) : null;
    return h("li", {}, h("button", attributes, number, text(`worksheet.${id}.name`), said));
  });
  list.replaceChildren(...keys);
}

/** @param {View} view */
function showMark({ app, mark, done, step }) {
  const ready = done.has(STEPS[step].id);
  mark.textContent = ready ? `\u2713 ${app.text("worksheet.done")}` : app.text("worksheet.open");
  mark.classList.toggle("done", ready);
}

/** The buttons of a step: set the stage, open its drawer, go on, go back. @param {View} view */
function buttonsOf(view) {
  const { app, step } = view;
  const { text, store } = app;
  const { drawer } = STEPS[step];
  const name = text("worksheet.openDrawer", { drawer: text(`drawer.${drawer}`) });
  const last = step === STEPS.length - 1;
  return {
    set: button(text("worksheet.stage"), () => stage(view), {
      class: "button main",
      "data-worksheet": "stage",
    }),
    open: button(name, () => store.set({ view: { drawer } }), { "data-worksheet": "open" }),
    back: button(text("worksheet.back"), () => go(view, step - 1), {
      disabled: step === 0,
      "data-worksheet": "back",
    }),
    next: button(text("worksheet.next"), () => go(view, step + 1), {
      disabled: last,
      "data-worksheet": "next",
    }),
  };
}

/** @param {View} view */
function show(view) {
  const { app, body, mark, step } = view;
  const { text } = app;
  const words = (/** @type {string} */ part) => text(`worksheet.${STEPS[step].id}.${part}`);
  showList(view);
  showMark(view);
  const { set, open, back, next } = buttonsOf(view);
  const count = text("worksheet.step", { step: step + 1, count: STEPS.length });
  const answer = h("summary", {}, text("worksheet.answer"));
  body.replaceChildren(
    h("p", { class: "quiet" }, count),
    h("h3", {}, words("title")),
    h("p", {}, words("text")),
    h("div", { class: "row" }, set),
    h("h4", {}, text("worksheet.question")),
    h("p", {}, words("question")),
    h("h4", {}, text("worksheet.do")),
    h("p", {}, words("do")),
    h("div", { class: "row" }, open),
    mark,
    h("details", {}, answer, h("p", {}, words("answer"))),
    h("div", { class: "row ends" }, back, next),
  );
}

/** Looks whether the present step is done now. @param {View} view @param {Cause | null} cause */
function look(view, cause = null) {
  const { app, step, done, staged } = view;
  const { store, clock, motion } = app;
  const one = STEPS[step];
  if (!staged || done.has(one.id) || cause?.label === "worksheet") return;
  if (!one.done({ doc: store.get(), clock, motion, cause })) return;
  done.add(one.id);
  keep(view);
  showList(view);
  showMark(view);
  app.announce(app.text("worksheet.said", { step: step + 1 }));
}

/** Arrows walk the list of steps. @param {HTMLElement} list @param {KeyboardEvent} event */
function walk(list, event) {
  const move = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
  if (!move) return;
  event.preventDefault();
  event.stopPropagation();
  const keys = [...list.querySelectorAll("button")];
  const from = keys.findIndex((key) => key === document.activeElement);
  keys[(from + move + keys.length) % keys.length].focus();
}

/** @param {View} view @param {Bag} bag */
function follow(view, bag) {
  const { store, clock } = view.app;
  bag.on(view.list, "keydown", (event) => walk(view.list, event));
  bag(store.subscribe((_doc, _before, cause) => look(view, cause)));
  let { playing } = clock;
  bag(
    clock.subscribe(() => {
      // what it needs to stand still for
      if (clock.playing !== playing || !clock.playing) look(view);
      playing = clock.playing;
    }),
  );
}

/** @param {HTMLElement} element @param {App} app @returns {Drawer} */
function mount(element, app) {
  const { text } = app;
  const bag = createBag();
  const list = h("ol", { class: "steps" });
  const body = h("div", { class: "step" });
  const mark = h("p", { class: "mark", role: "status" });
  const view = { app, ...readKept(), staged: false, list, body, mark };
  follow(view, bag);
  element.append(
    h("h2", {}, text("drawer.worksheet")),
    h("p", { class: "quiet" }, text("worksheet.intro")),
    h("nav", { "aria-label": text("worksheet.steps") }, list),
    body,
  );
  show(view);
  return {
    show() {},
    hide() {},
    destroy: () => {
      bag.end();
      element.replaceChildren();
    },
  };
}

/** @type {DrawerPart} */
export default { id: "worksheet", title: (text) => text("drawer.worksheet"), mount };
