// Plots: the energies, any two quantities, and small multiples on the same time axis (angles,
// velocities, forces, the energy's drift), and exports.
// Leaves to others: the charts (chart.js), what they show (plot_data.js), two quantities
// (any_chart.js), pictures for paper (picture.js).
// Invariant: every number shown is a sample of the server's; files of numbers are asked from the
// server.

import { foldedTheta, thetaOf } from "../angles.js";
import { createBag, h, iconButton } from "../dom.js";
import { createAnyChart, panelOf } from "./kit/any_chart.js";
import { createGroup } from "./kit/chart.js";
import { numbersAsFiles } from "./kit/files_of_numbers.js";
import { armLook, button, figure, later, save, swatch, toggle } from "./kit/kit.js";
import { pngOf, svgOf } from "./kit/picture.js";
import {
  ENERGIES,
  PER_ARM,
  columnOf,
  driftOf,
  energiesIn,
  folded,
  panelsOf,
} from "./kit/plot_data.js";

const FEW = 8; // so many arms are shown at first
const READABLE_MS = 120; // numbers that change faster cannot be read
const HEADS = ["", "\u03b8, \u00b0", "\u03c9, rad/s", "F, N"];

/**
 * The charts of a number of arms.
 * @typedef {{perArm: Chart[], energy: Chart, drift: Chart}} Charts
 */

/**
 * The drawer while it is there; made: what depends on the number of arms; arms: of
 * how many the charts are; hidden: arms that are not drawn, from 0; fold: angles have no full
 * turns; told: when the numbers were written last.
 * @typedef {ReturnType<typeof partsOf> & {
 *   app: App, group: ChartGroup, made: Bag, charts: Charts | null, shown: boolean, stale: boolean,
 *   arms: number, hidden: Set<number>, fold: boolean, told: number,
 *   own: ReturnType<typeof createAnyChart>,
 * }} View
 */

/** @param {Text} text */
function partsOf(text) {
  const table = h("div", {
    class: "scroll",
    tabindex: 0,
    role: "region",
    "aria-label": text("plots.values"),
  });
  const summary = h("summary", {});
  return {
    first: h("div", { class: "charts" }),
    place: h("div", { class: "charts" }),
    legend: h("div", { class: "chips", role: "group", "aria-label": text("plots.arms") }),
    status: h("p", { class: "quiet", role: "status" }),
    table,
    summary,
    numbers: h("details", { class: "numbers" }, summary, table),
  };
}

/**
 * A title and a place for a chart. @param {Text} text @param {HTMLElement} place @param {string} id
 */
function chartPlace(text, place, id) {
  const label = text("plots.label", { what: text(`plots.${id}`) });
  const host = h("div", { class: "chart", role: "img", "aria-label": label, "data-chart": id });
  place.append(h("h3", { class: "chart-title" }, text(`plots.${id}`)), host);
  return host;
}

/** One chip an arm: whether it is drawn. @param {View} view */
function showChips(view) {
  const { app, legend, hidden } = view;
  const chip = (/** @type {number} */ k) => {
    const { name, dash } = armLook(k + 1);
    const label = app.text("arm.name", { arm: k + 1 });
    const turn = (/** @type {boolean} */ on) => {
      if (on) hidden.delete(k);
      else hidden.add(k);
      for (const chart of view.charts?.perArm ?? []) chart.show(k, on);
    };
    const names = { "data-arm": k + 1, title: label, "aria-label": label };
    const key = toggle(swatch(name, dash), !hidden.has(k), turn, names);
    key.append(String(k + 1));
    return key;
  };
  legend.replaceChildren(...Array.from({ length: view.arms }, (_, k) => chip(k)));
}

/** @param {Text} text @param {Chart} energy */
function energyChips(text, energy) {
  const row = h("div", { class: "chips", role: "group", "aria-label": text("plots.energies") });
  ENERGIES.forEach(({ id, colour }, i) => {
    const key = toggle(swatch(colour), true, (on) => energy.show(i, on), { "data-energy": id });
    key.append(text(`plots.${id}`));
    row.append(key);
  });
  return row;
}

/** Another number of arms: the first few are shown. @param {View} view */
function settleArms(view) {
  const { motion } = view.app;
  if (motion.n === view.arms) return;
  view.arms = motion.n;
  view.hidden = new Set(Array.from({ length: view.arms }, (_, k) => k).filter((k) => k >= FEW));
}

/** The charts over time. @param {View} view */
function buildCharts(view) {
  const { app, group, first, place, hidden } = view;
  const { text } = app;
  const series = Array.from({ length: view.arms }, (_, k) => ({
    colour: armLook(k + 1).name,
    dash: armLook(k + 1).dash,
    shown: !hidden.has(k),
    name: String(k + 1),
  }));
  // the chips above have whole words
  const short = (/** @type {string} */ id) => `${text(`plots.${id}`).slice(0, 3)}.`;
  const energies = ENERGIES.map((one) => ({ ...one, name: short(one.id) }));
  const energyPlace = chartPlace(text, first, "energy");
  const energy = group.add(energyPlace, { series: energies });
  energyPlace.before(energyChips(text, energy));
  const perArm = PER_ARM.map(({ id, column }) =>
    group.add(chartPlace(text, place, id), { series, degrees: column === "phi" }),
  );
  const ink = [{ colour: "--ink" }];
  const drift = group.add(chartPlace(text, place, "drift"), { series: ink });
  for (const chart of [...perArm, energy, drift]) view.made(() => group.remove(chart));
  return { perArm, energy, drift };
}

/** All charts anew, for another number of arms. @param {View} view @returns {Charts} */
function build(view) {
  view.made.end();
  view.first.replaceChildren();
  view.place.replaceChildren();
  settleArms(view);
  showChips(view);
  view.charts = buildCharts(view);
  return view.charts;
}

/** What there is of the motion, into all charts. @param {View} view */
function fill(view) {
  const { motion } = view.app;
  view.stale = !view.shown;
  if (!view.shown) return;
  const charts = view.charts && view.arms === motion.n ? view.charts : build(view);
  const { columns, count, n } = motion;
  if (!count) return;
  const t = motion.t.slice(0, count);
  PER_ARM.forEach(({ column, shown }, i) => {
    const curves = Array.from({ length: n }, (_, k) =>
      columnOf(columns[column], n, k, count, shown),
    );
    const turned = view.fold && column === "phi" ? curves.map(folded) : curves;
    charts.perArm[i].set([t, ...turned]);
  });
  charts.energy.set([t, ...energiesIn(motion)]);
  charts.drift.set([t, driftOf(columns.energy_total, count)]);
  follow(view);
}

/** The numbers of all arms at an instant. @param {View} view @param {Instant} now */
function tableOf({ app: { text }, fold }, now) {
  const theta = fold ? foldedTheta : thetaOf;
  const cell = (/** @type {number} */ value) => h("td", {}, figure(text, value, 5));
  const heads = HEADS.map((words) => (words ? h("th", { scope: "col" }, words) : h("td", {})));
  const rows = Array.from(now.phi, (phi, k) => {
    const name = h("th", { scope: "row" }, text("arm.name", { arm: k + 1 }));
    return h("tr", {}, name, cell(theta(phi)), cell(now.phid[k]), cell(now.lambda[k]));
  });
  return h("table", {}, h("thead", {}, h("tr", {}, ...heads)), h("tbody", {}, ...rows));
}

/** The clock's time, in the numbers. @param {View} view */
function follow(view) {
  const { app, charts, summary, table, numbers } = view;
  const { motion, clock, text } = app;
  if (!view.shown || !motion.count || !charts) return;
  if (clock.playing && performance.now() - view.told < READABLE_MS) return;
  view.told = performance.now();
  summary.textContent = text("plots.numbers", {
    time: text.number((motion.doc.span.start ?? 0) + clock.time, 2),
  });
  if (numbers.open) table.replaceChildren(tableOf(view, motion.at(clock.time)));
}

/** @param {View} view @param {string} ending "svg" or "png" */
async function savePicture({ app, group, hidden, fold, own, status }, ending) {
  const { motion, clock, store, text } = app;
  const seen = group.zoomed ?? /** @type {[number, number]} */ ([0, clock.duration]);
  const pair = panelOf(motion, text, own.names, fold);
  const panels = panelsOf(motion, text, seen, hidden, fold, pair);
  const svg = svgOf(panels, `${store.get().title || text("name")}. ${text("plots.title")}`, text);
  const blob = ending === "svg" ? new Blob([svg], { type: "image/svg+xml" }) : await pngOf(svg);
  const name = `pendulum.${ending}`;
  save(blob, name);
  status.textContent = text("plots.saved", { name });
}

/** Angles without full turns; larger for those in the last row. @param {View} view */
function lookKeys(view) {
  const { app, own, place } = view;
  const fold = (/** @type {boolean} */ on) => {
    view.fold = on;
    own.fold(on);
    fill(view);
  };
  const enlarge = (/** @type {boolean} */ on) =>
    place.closest("[data-drawer]")?.classList.toggle("far", on);
  return [
    toggle(app.text("plots.fold"), view.fold, fold, { "data-plots": "fold" }),
    toggle(app.text("plots.large"), false, enlarge, { "data-plots": "large" }),
  ];
}

/** @param {View} view */
function toolbarOf(view) {
  const { group } = view;
  const { text } = view.app;
  const out = text("plots.zoomOut");
  const wide = { class: "icon-button", "aria-label": out, title: out };
  return h(
    "div",
    { class: "row" },
    iconButton("plus", text("plots.zoomIn"), () => group.magnify(0.5)),
    button("\u2212", () => group.magnify(2), wide),
    button(text("plots.zoomAll"), () => group.zoom()),
    ...lookKeys(view),
  );
}

/**
 * Buttons that save, behind a word.
 * @param {Text} text @param {string} word @param {HTMLElement[]} buttons
 */
function savers(text, word, buttons) {
  const attributes = { class: "row", role: "group", "aria-label": text("kit.save") };
  return h("div", attributes, h("span", { class: "quiet" }, text(word)), ...buttons);
}

/** @param {HTMLElement} element @param {View} view */
function lay(element, view) {
  const { app, legend, first, place, own, numbers, status } = view;
  const { text } = app;
  const pictures = ["png", "svg"].map((ending) =>
    button(ending.toUpperCase(), () => savePicture(view, ending), { "data-save": ending }),
  );
  element.append(
    h("h2", {}, text("drawer.plots")),
    toolbarOf(view),
    first,
    h("h3", { class: "chart-title" }, text("plots.own")),
    own.element,
    legend,
    place,
    h("p", { class: "quiet" }, text("plots.hint")),
    numbers,
    savers(text, "plots.picture", pictures),
    numbersAsFiles(app, status),
    status,
  );
}

/** @param {View} view @param {Bag} bag */
function listen(view, bag) {
  const { app, group } = view;
  const soon = later(() => fill(view));
  bag(soon.end);
  bag(
    app.motion.subscribe((_, what) => {
      if (what === "begin" && group.zoomed) group.zoom();
      if (what === "rows" || what === "complete") soon();
    }),
  );
  bag(app.clock.subscribe(() => follow(view)));
  bag.on(view.numbers, "toggle", () => {
    view.told = 0;
    follow(view);
  });
}

/** @param {HTMLElement} element @param {App} app @returns {Drawer} */
function mount(element, app) {
  const group = createGroup(app);
  const bag = createBag();
  const state = { shown: false, stale: true, arms: 0, hidden: new Set(), fold: true, told: 0 };
  const own = createAnyChart(app);
  /** @type {View} */
  const view = { ...partsOf(app.text), app, group, made: createBag(), charts: null, own, ...state };
  bag(own.destroy);
  lay(element, view);
  listen(view, bag);
  return {
    show() {
      view.shown = true;
      if (view.stale) fill(view);
      follow(view);
      own.show();
    },
    hide() {
      view.shown = false;
      own.hide();
    },
    destroy() {
      bag.end();
      view.made.end();
      group.destroy();
      element.replaceChildren();
    },
  };
}

/** @type {DrawerPart} */
export default { id: "plots", title: (text) => text("drawer.plots"), mount };
