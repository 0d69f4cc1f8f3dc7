// Measure: the true period beside the formula's, a stopwatch, arrows at the tips, a motion without
// end, a film of it; fits to measurements.
// Leaves to others: reading periods (periods.js), the parts (stopwatch.js, recorder.js), drawing
// arrows (paint_vectors.js), what is loaded when it is opened (film.js, fits.js).
// Invariant: what is measured is the motion that is shown.

import { createBag, h } from "../dom.js";
import { VECTORS } from "../paint_vectors.js";
import { createGauges } from "./measure/gauge_fields.js";
import { createHearing } from "./measure/hear.js";
import { choice, later, swatch, tick } from "./kit/kit.js";
import { lazyPart } from "./kit/lazy.js";
import { takeMeasurements } from "./fits/measurements.js";
import {
  farthestOf,
  formulaOf,
  noPeriodOf,
  periodOf,
  periodWords,
  swingsOf,
} from "./measure/periods.js";
import { recordButton } from "./measure/recorder.js";
import { createStopwatch } from "./measure/stopwatch.js";

/**
 * The drawer while it is there; arm: the one whose swings are told.
 * @typedef {{app: App, arm: number, shown: boolean, period: HTMLElement, picks: HTMLElement}} View
 */

/** A line of what has been read. @param {string} name @param {string} value @param {string} id */
const line = (name, value, id) => [h("dt", {}, name), h("dd", { "data-read": id }, value)];

/** The swings of the chosen arm. @param {View} view */
function showPeriod({ app, arm, shown, period }) {
  const { motion, text } = app;
  if (!shown || !motion.complete || arm > motion.n) return;
  const swings = swingsOf(motion.track, arm);
  const found = periodOf(swings.times);
  const formula = formulaOf(motion.doc.pendulum);
  const words = found ? periodWords(found, text) : null;
  const none = noPeriodOf(swings, motion.track, text);
  const rows = line(text("measure.true"), words?.period ?? none, "period");
  if (words?.swings) rows.push(...line("", words.swings, "swings"));
  if (Number.isFinite(formula)) {
    const seconds = text("seconds", { time: text.number(formula, 4) });
    rows.push(...line(text("measure.formula"), seconds, "formula"));
  } else if (motion.n > 1) rows.push(...line("", text("measure.modes"), "modes"));
  if (found?.periodic && !swings.over && Number.isFinite(formula)) {
    const percent = text.number((found.mean / formula - 1) * 100, 2);
    rows.push(...line(text("measure.longer"), text("measure.percent", { percent }), "longer"));
  }
  rows.push(...line(text("measure.amplitude"), farthestOf(swings, text), "amplitude"));
  period.replaceChildren(...rows);
}

/** The choice of an arm, where there is one. @param {View} view */
function showPicks(view) {
  const { app, picks } = view;
  const n = app.store.get().pendulum.length.length;
  view.arm = Math.min(app.store.get().view.selected || view.arm, n);
  const arms = Array.from({ length: n }, (_, k) => ({
    value: k + 1,
    words: app.text("arm.name", { arm: k + 1 }),
  }));
  const pick = choice(app.text("measure.of"), arms, view.arm, (value) => {
    view.arm = Number(value);
    showPeriod(view);
  });
  pick.select.dataset.measure = "arm";
  picks.replaceChildren(...(n > 1 ? [pick.element] : []));
}

/** Which arrows, and how long. @param {App} app */
function arrowsOf({ store, text }) {
  const { vectors, vectorScale } = store.get().view;
  const ticks = Object.entries(VECTORS).map(([name, [colour]]) => {
    const one = tick(text(`measure.${name}`), vectors.includes(name), (on) => {
      const others = store.get().view.vectors.filter((other) => other !== name);
      store.set({ view: { vectors: on ? [...others, name] : others } });
    });
    one.box.dataset.vector = name;
    one.element.append(swatch(colour));
    return one.element;
  });
  const input = () => store.set({ view: { vectorScale: 2 ** Number(scale.value) } });
  const range = { type: "range", min: -2, max: 2, step: 0.25, value: Math.log2(vectorScale) };
  const scale = h("input", { ...range, "data-vector": "scale", on: { input } });
  const label = h("label", { class: "choice" }, h("span", {}, text("measure.scale")), scale);
  return h("div", {}, h("div", { class: "vector-ticks" }, ...ticks), label);
}

/** @param {Text} text @param {string} id @param {...HTMLElement} children */
const section = (text, id, ...children) =>
  h("section", { "data-part": id }, h("h3", {}, text(`measure.${id}.title`)), ...children);

/**
 * The place of the fits; take() reads a table that waits, and shows it.
 * @param {App} app
 */
function fitsOf(app) {
  const part = lazyPart(app, "fits/fits", app.text("measure.fits"), true);
  const take = async () => {
    const words = takeMeasurements(app);
    if (words === null) return;
    const fits = await part.open();
    fits.read(words);
    part.element.scrollIntoView({ block: "start" });
  };
  return { ...part, take };
}

/** Whether it goes on, and a film of it. @param {App} app */
function runningOf(app) {
  const { store, text } = app;
  const status = h("p", { class: "quiet", role: "status" });
  const recorder = recordButton(app, status);
  const endless = tick(text("measure.endless"), store.get().view.endless, (on) =>
    store.set({ view: { endless: on } }),
  );
  endless.box.dataset.measure = "endless";
  const record = h("div", { class: "row" }, recorder.element);
  return { elements: [endless.element, record, status], destroy: recorder.destroy };
}

/** @param {HTMLElement} element @param {App} app @returns {Drawer} */
function mount(element, app) {
  const { store, motion, text } = app;
  const bag = createBag();
  const period = h("dl", { class: "readout" });
  /** @type {View} */
  const view = { app, arm: 1, shown: false, period, picks: h("div", {}) };
  const watch = createStopwatch(app);
  const hearing = createHearing(app, () => view.arm);
  const running = runningOf(app);
  const film = lazyPart(app, "film/film", text("measure.own"));
  const gauges = createGauges(app);
  const fits = fitsOf(app);
  const trials = lazyPart(app, "measure/trials", text("measure.trials"));
  element.append(
    h("h2", {}, text("drawer.measure")),
    section(text, "period", view.picks, period),
    section(text, "watch", watch.element),
    section(text, "hear", hearing.element),
    section(text, "arrows", arrowsOf(app)),
    section(text, "gauges", gauges.element),
    section(text, "run", ...running.elements),
    trials.element,
    film.element,
    fits.element,
  );
  const soon = later(() => showPeriod(view));
  bag(soon.end);
  bag(motion.subscribe((_, what) => what === "complete" && soon()));
  bag(
    store.subscribe((doc, before) => {
      if (view.shown && app.measurements) fits.take();
      if (doc.pendulum === before.pendulum && doc.view.selected === before.view.selected) return;
      showPicks(view);
      soon();
    }),
  );
  for (const part of [watch, hearing, gauges, running, trials, film, fits]) bag(part.destroy);
  showPicks(view);
  return {
    show() {
      view.shown = true;
      hearing.show(true);
      showPeriod(view);
      fits.take();
    },
    hide() {
      view.shown = false;
      hearing.show(false);
      film.hide();
    },
    destroy() {
      bag.end();
      element.replaceChildren();
    },
  };
}

/** @type {DrawerPart} */
export default { id: "measure", title: (text) => text("drawer.measure"), mount };
