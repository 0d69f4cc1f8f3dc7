// Any quantity of the motion over any other, with the values at the pointer and two cursors with
// their differences.
// Leaves to others: the quantities (table_file.js), the curve (plot.js).
// Invariant: every value shown is one of a sample.

import { createBag, h } from "../../dom.js";
import { button, choice, figure, later } from "./kit.js";
import { createPlot, nearest } from "./plot.js";
import { folded, paperColour } from "./plot_data.js";
import { columnsOf } from "./table_file.js";

/** The phase portrait of arm 1: the columns across and upwards. */
export const PORTRAIT = ["theta_1", "omega_1"];

/** Whether a column is an angle. @param {{id: string}} column */
const isAngle = ({ id }) => id.startsWith("theta_");

/**
 * Two columns of the motion by their names; time and the angle of arm 1 where it has them not.
 * Angles are without full turns if `fold` is set.
 * @param {Motion} motion @param {Text} text @param {string[]} names @param {boolean} fold
 */
function pairOf(motion, text, names, fold) {
  const columns = columnsOf(motion, text);
  const chosen = names.map((name, i) => columns.find(({ id }) => id === name) ?? columns[i]);
  const [xs, ys] = chosen.map((column) => {
    const list = Float64Array.from({ length: motion.count }, (_, i) => column.value(i));
    return fold && isAngle(column) ? folded(list) : list;
  });
  const degrees = ["x", "y"].filter((_, i) => isAngle(chosen[i])).join("");
  const [x, y] = chosen.map(({ head }) => head);
  return { columns, chosen, xs, ys, degrees, title: text("plots.own.label", { x, y }) };
}

/**
 * Two quantities as a panel for paper.
 * @param {Motion} motion @param {Text} text @param {string[]} names @param {boolean} fold
 * @returns {import("./picture.js").Panel}
 */
export function panelOf(motion, text, names, fold) {
  const { xs, ys, degrees, title } = pairOf(motion, text, names, fold);
  const series = [{ name: "", colour: paperColour("--arm-1"), xs, ys }];
  return { title, degrees, height: 300, series };
}

/**
 * The chart while it is there; names: which columns, across and upwards; row: the sample that is
 * told; marks: the cursors' samples.
 * @typedef {{
 *   app: App, names: string[], fold: boolean, row: number, marks: {A: number, B: number},
 *   shown: boolean, plot: import("./plot.js").PlotPart, table: HTMLElement, picks: HTMLElement,
 *   pair: ReturnType<typeof pairOf> | null, cursors: HTMLDetailsElement,
 * }} AnyChart
 */

/** @param {AnyChart} any */
function fill(any) {
  const { app, plot, names, fold } = any;
  const { motion, text } = app;
  if (!any.shown || !motion.count) return;
  any.pair = pairOf(motion, text, names, fold);
  showPicks(any, any.pair);
  const { xs, ys, degrees, title } = any.pair;
  plot.set({ curves: [{ xs, ys, colour: "--accent" }], degrees }, title);
  follow(any);
}

/**
 * The choices of both axes, which depend on the arms.
 * @param {AnyChart} any @param {ReturnType<typeof pairOf>} pair
 */
function showPicks(any, { columns, chosen }) {
  const { app, picks } = any;
  const heads = columns.map(({ head }) => head).join();
  if (picks.dataset.heads === heads) return;
  picks.dataset.heads = heads;
  const options = columns.map(({ id, head }) => ({ value: id, words: head }));
  const axis = (/** @type {"x" | "y"} */ name, /** @type {number} */ i) => {
    const pick = choice(app.text(`measure.${name}`), options, chosen[i].id, (value) => {
      any.names[i] = value;
      any.marks = { A: -1, B: -1 };
      fill(any);
    });
    pick.select.dataset.axis = name;
    return pick.element;
  };
  picks.replaceChildren(axis("y", 1), axis("x", 0));
}

/** The values at the clock and at the cursors. @param {AnyChart} any */
function follow(any) {
  const { app, pair, plot, table, marks } = any;
  const { motion, clock, text } = app;
  if (!any.shown || !pair || !motion.count) return;
  any.row = Math.min(Math.round(clock.time / motion.doc.span.step), motion.count - 1);
  plot.mark(pair.xs[any.row], pair.ys[any.row]);
  if (!any.cursors.open) return;
  // the time comes first, unless it is one of the two
  const told = [...new Set([pair.columns[0], ...pair.chosen])];
  const values = (/** @type {number} */ row) => told.map(({ value }) => value(row));
  const line = (/** @type {string} */ name, /** @type {number[]} */ list) =>
    h(
      "tr",
      {},
      h("th", { scope: "row" }, name),
      ...list.map((v) => h("td", {}, figure(text, v, 6))),
    );
  const { A, B } = marks;
  const rows = [line(text("measure.now"), values(any.row))];
  if (A >= 0 && A < motion.count) rows.push(line("A", values(A)));
  if (B >= 0 && B < motion.count) rows.push(line("B", values(B)));
  if (rows.length === 3) {
    const [from, to] = [values(A), values(B)];
    rows.push(
      line(
        text("measure.difference"),
        to.map((value, i) => value - from[i]),
      ),
    );
  }
  const head = told.map((column) => h("th", { scope: "col" }, column.head));
  table.replaceChildren(
    h("table", {}, h("thead", {}, h("tr", {}, h("td", {}), ...head)), h("tbody", {}, ...rows)),
  );
}

/** The cursors' buttons and the table. @param {AnyChart} any */
function cursorsOf(any) {
  const { app, table, cursors } = any;
  const cursor = (/** @type {"A" | "B"} */ name) => {
    const set = () => {
      any.marks[name] = any.row;
      follow(any);
    };
    return button(app.text("measure.cursor", { name }), set, { "data-cursor": name });
  };
  const summary = h("summary", {}, app.text("measure.cursors"));
  cursors.append(summary, h("div", { class: "row" }, cursor("A"), cursor("B")), table);
}

/** @param {App} app */
export function createAnyChart(app) {
  const { motion, clock, text } = app;
  const bag = createBag();
  const region = { class: "scroll", tabindex: 0, role: "region" };
  /** @type {AnyChart} */
  const any = {
    ...{ app, names: [...PORTRAIT], fold: true, row: 0, marks: { A: -1, B: -1 }, shown: false },
    plot: createPlot(text, 220),
    pair: null,
    table: h("div", { ...region, "aria-label": text("plots.values"), "data-any": "values" }),
    picks: h("div", { class: "any-picks" }),
    cursors: h("details", { class: "numbers" }),
  };
  const { plot, picks, cursors } = any;
  cursorsOf(any);
  const soon = later(() => fill(any));
  bag(soon.end);
  bag(motion.subscribe((_, what) => (what === "rows" || what === "complete") && soon()));
  bag(clock.subscribe(() => follow(any)));
  bag.on(cursors, "toggle", () => follow(any));
  bag.on(plot.element, "pointermove", (event) => {
    const row = any.pair ? nearest(plot.far(event), any.pair.xs, any.pair.ys) : -1;
    if (!clock.playing && row >= 0) clock.seek(row * motion.doc.span.step);
  });
  bag(plot.destroy);
  return {
    element: h("section", { "data-part": "any" }, picks, plot.element, cursors),
    names: any.names,
    /** Angles without full turns, or with them. @param {boolean} on */
    fold(on) {
      any.fold = on;
      fill(any);
    },
    show() {
      any.shown = true;
      fill(any);
    },
    hide() {
      any.shown = false;
    },
    destroy: bag.end,
  };
}
