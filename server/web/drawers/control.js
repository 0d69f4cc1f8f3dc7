// Control: a sampled feedback that holds the pendulum at an equilibrium, hanging or upright; its
// weights by two sliders, its gains, letting it catch and let go, a map of the starts it catches.
// Leaves to others: the design (the server), what the numbers mean (control/control_design.js), the
// map (maps/map.js), pushing by hand (the stage).
// Invariant: a gain that is shown is the server's; the controller that acts is the document's.

import { said } from "../client.js";
import { createBag, h } from "../dom.js";
import {
  EXAMPLES,
  actuators,
  controlOf,
  designBody,
  poseOf,
  withControl,
} from "./control/control_design.js";
import { aborted, button, choice, figure, settled, tick, toggle } from "./kit/kit.js";

const PERIODS = [0.005, 0.01, 0.02, 0.05];
/** The sliders: powers of ten. */
const WEIGHTS = /** @type {const} */ (["deviation", "effort"]);

/**
 * The drawer while it is there; on: what is shown acts or is to act.
 * @typedef {{
 *   app: App, wish: import("./control/control_design.js").Wish, stop: AbortController | null,
 *   answer: any, fields: HTMLElement, pose: HTMLElement, facts: HTMLElement, status: HTMLElement,
 *   act: HTMLButtonElement, map: ReturnType<typeof import("./maps/map.js").default>,
 *   soon: Soon, wanted: boolean,
 * }} View
 */

/** @param {View} view */
const acts = ({ app }) => Boolean(app.store.get().pendulum.control);

/** The controller of the answer takes over, or lets go. @param {View} view @param {boolean} on */
function use({ app, answer, wish }, on) {
  const { live, motion, clock, store } = app;
  const acted = Boolean(store.get().pendulum.control);
  const { phi } = clock.time > 0 ? motion.at(clock.time) : store.get().initial;
  const control = on ? controlOf(answer, wish, phi) : undefined;
  // a pendulum that waits at its start has the controller from there on
  if (clock.time === 0 && !clock.playing)
    store.set({ pendulum: withControl(store.get().pendulum, control) }, { label: "control" });
  else live.change("control", (tree) => withControl(tree, control));
  store.settle();
  if (on && !acted) clock.play();
}

/** A design by the server; if it is to act, it takes over. @param {View} view */
async function design(view) {
  const { app, wish, status } = view;
  view.soon.end();
  view.stop?.abort();
  view.stop = new AbortController();
  try {
    const body = designBody(app.store.get().pendulum, wish);
    const reply = await app.client.post("/v1/controllers", body, { signal: view.stop.signal });
    view.answer = await reply.json();
    status.textContent = "";
    showFacts(view);
    if (view.wanted) use(view, true);
  } catch (error) {
    if (aborted(error)) return;
    view.answer = null;
    status.textContent = said(error, app.text);
    view.facts.replaceChildren();
  }
}

/** @param {View} view what has changed is designed anew */
function changed(view) {
  view.wanted = acts(view);
  view.soon();
}

/** The names of the state's numbers. @param {View} view */
function names({ app: { store, text } }) {
  const { length, pivot } = store.get().pendulum;
  const arms = length.map((_, k) => text("map.theta", { arm: k + 1 }));
  const rates = length.map((_, k) => text("map.thetad", { arm: k + 1 }));
  const cart = pivot?.cart ? [text("control.place"), text("control.speed")] : [];
  return [...arms, ...rates, ...cart];
}

/** @param {View} view */
function showFacts(view) {
  const { app, answer, facts, wish } = view;
  const { text } = app;
  const [{ law }] = answer.control;
  const rows = names(view).map((name, i) =>
    h(
      "tr",
      {},
      h("th", { scope: "row" }, name),
      h("td", { "data-gain": i }, figure(text, law.feedback.gains[i], 4)),
    ),
  );
  const { re, im } = answer.multipliers;
  const most = Math.max(
    ...re.map((/** @type {number} */ x, /** @type {number} */ i) => Math.hypot(x, im[i])),
  );
  const [{ phase, delay } = { phase: NaN, delay: NaN }] = answer.margins;
  const percent = text.short(100 * most ** (1 / wish.period), 2);
  const lines = [
    text(most < 1 ? "control.stable" : "control.unstable", { percent }),
    text("control.margins", {
      phase: figure(text, (phase * 180) / Math.PI, 2),
      delay: figure(text, 1000 * delay, 2),
    }),
  ];
  if (answer.unreachable.length) lines.push(text("control.unreachable"));
  const caption = h("caption", {}, text("control.gains"));
  facts.replaceChildren(
    h("div", { class: "scroll" }, h("table", {}, caption, h("tbody", {}, ...rows))),
    ...lines.map((line) => h("p", {}, line)),
  );
}

/** Which arms stand upright. @param {View} view */
function showPose(view) {
  const { app, wish, pose } = view;
  const { text, store, clock, motion } = app;
  const keys = wish.up.map((up, k) => {
    const words = text("control.up", { arm: k + 1 });
    return toggle(
      words,
      up,
      (on) => {
        wish.up[k] = on;
        changed(view);
      },
      { "data-up": k + 1 },
    );
  });
  const take = () => {
    const { phi } = clock.time > 0 ? motion.at(clock.time) : store.get().initial;
    wish.up = poseOf(phi);
    showPose(view);
    changed(view);
  };
  pose.replaceChildren(...keys, button(text("control.take"), take, { "data-control": "take" }));
}

/** A slider with its words. @param {View} view @param {typeof WEIGHTS[number]} name */
function sliderOf(view, name) {
  const { text } = view.app;
  const slider = h("input", {
    type: "range",
    min: -2,
    max: 2,
    step: 0.1,
    value: view.wish[name],
    "data-weight": name,
  });
  slider.addEventListener("input", () => {
    view.wish[name] = Number(slider.value);
    changed(view);
  });
  return h("label", { class: "choice" }, h("span", {}, text(`control.${name}`)), slider);
}

/** @param {View} view */
function showFields(view) {
  const { app, wish, fields } = view;
  const { text, store } = app;
  const { pendulum } = store.get();
  if (wish.up.length !== pendulum.length.length) wish.up = pendulum.length.map(() => true);
  const motors = actuators(pendulum);
  if (!motors.includes(wish.motor)) [wish.motor] = motors;
  /** @param {"motor" | "period"} name @param {{value: number, words: string}[]} options */
  const pick = (name, options) => {
    const made = choice(text(`control.${name}`), options, wish[name], (value) => {
      wish[name] = Number(value);
      changed(view);
    });
    made.select.dataset.control = name;
    return made.element;
  };
  const joint = (/** @type {number} */ arm) => text("control.joint", { arm });
  const seconds = (/** @type {number} */ value) => text("seconds", { time: text.short(value) });
  const limit = h("input", {
    type: "text",
    inputmode: "decimal",
    autocomplete: "off",
    value: wish.limit ? text.short(wish.limit) : "",
    "data-control": "limit",
  });
  limit.addEventListener("change", () => {
    const value = text.read(limit.value);
    wish.limit = value > 0 ? value : 0;
    changed(view);
  });
  const unit = wish.motor ? "N\u00b7m" : "N";
  const swing = tick(text("control.swing"), wish.swing, (on) => {
    wish.swing = on;
    changed(view);
  });
  swing.box.dataset.control = "swing";
  if (fields.contains(document.activeElement)) return;
  fields.replaceChildren(
    pick(
      "motor",
      motors.map((value) => ({ value, words: value ? joint(value) : text("control.cart") })),
    ),
    pick(
      "period",
      PERIODS.map((value) => ({ value, words: seconds(value) })),
    ),
    h("label", { class: "choice" }, h("span", {}, text("control.limit", { unit })), limit),
    ...WEIGHTS.map((name) => sliderOf(view, name)),
    // energy alone brings one arm up, and two arms near
    ...(pendulum.length.length <= 2 ? [swing.element] : []),
  );
}

/** @param {View} view */
function show(view) {
  const { app, act } = view;
  showFields(view);
  showPose(view);
  act.textContent = app.text(acts(view) ? "control.release" : "control.catch");
  act.setAttribute("aria-pressed", String(acts(view)));
}

/** @param {View} view @param {typeof EXAMPLES[number]} example */
function take(view, { pendulum, initial, wish }) {
  Object.assign(view.wish, wish, { up: pendulum.length.map(() => true) });
  const span = { stop: 20, step: 0.01 };
  const patch = { pendulum, initial, span, ghosts: [], method: "taylor", precision: "double" };
  view.app.clock.pause();
  view.app.store.set(patch, { label: "control" });
  view.app.clock.seek(0);
  view.wanted = true;
  design(view);
}

/** @param {HTMLElement} element @param {View} view */
function lay(element, view) {
  const { text } = view.app;
  const examples = EXAMPLES.map((example) =>
    button(text(`control.example.${example.name}`), () => take(view, example), {
      "data-example": example.name,
    }),
  );
  element.append(
    h("h2", {}, text("drawer.control")),
    h("p", { class: "quiet" }, text("control.intro")),
    h("div", { class: "chips", role: "group", "aria-label": text("drawer.presets") }, ...examples),
    h("h3", {}, text("control.pose")),
    view.pose,
    view.fields,
    h("div", { class: "row" }, view.act),
    view.status,
    view.facts,
    h("p", { class: "quiet" }, text("control.push")),
    view.map.element,
  );
}

/** @param {HTMLElement} element @param {App} app @returns {Promise<Drawer>} */
async function mount(element, app) {
  const bag = createBag();
  const { text, store } = app;
  const { default: mountMap } = await app.files.script("drawers/maps/map.js");
  const wish = { across: "theta1", up: "thetad1", what: "caught", duration: 10 };
  /** @type {View} */
  const view = {
    app,
    wish: { motor: 0, up: [], deviation: 0, effort: 0, period: 0.01, limit: 0, swing: false },
    stop: null,
    answer: null,
    fields: h("div", { class: "row" }),
    pose: h("div", { class: "chips", role: "group", "aria-label": text("control.pose") }),
    facts: h("div", { role: "status" }),
    status: h("p", { class: "quiet", role: "status" }),
    act: button("", () => press(), { "data-control": "act" }),
    map: mountMap(app, text("control.map"), text("control.mapIntro"), wish),
    soon: settled(() => design(view)),
    wanted: false,
  };
  const press = () => {
    if (acts(view)) return use(view, false);
    view.wanted = true;
    design(view);
  };
  lay(element, view);
  bag(view.soon.end);
  bag(() => view.stop?.abort());
  bag(
    store.subscribe((doc, before) => {
      if (doc.pendulum !== before.pendulum) show(view);
    }),
  );
  bag(view.map.destroy);
  show(view);
  changed(view);
  return {
    show: () => view.map.show(),
    hide() {},
    destroy() {
      bag.end();
      element.replaceChildren();
    },
  };
}

/** @type {DrawerPart} */
export default { id: "control", title: (text) => text("drawer.control"), mount };
