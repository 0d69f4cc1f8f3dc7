// Any quantity of the motion over any other, with the values at the pointer and two cursors with
// their differences.
// Leaves to others: the quantities (table_file.js), the curve (plot.js).
// Invariant: every value shown is one of a sample.

import { createBag, h } from "../../dom.js";
import { button, choice, figure, later } from "./kit.js";
import { createPlot, nearest } from "./plot.js";
import { columnsOf } from "./table_file.js";

/**
 * The chart while it is there; x, y: which columns; row: the sample that is told; marks: the
 * cursors' samples.
 * @typedef {{
 *   app: App, x: number, y: number, row: number, marks: {A: number, B: number}, shown: boolean,
 *   plot: import("./plot.js").PlotPart, table: HTMLElement, picks: HTMLElement,
 *   columns: import("./table_file.js").TableColumn[],
 *   curve: {xs: ArrayLike<number>, ys: ArrayLike<number>, colour: string},
 * }} AnyChart
 */

/** @param {AnyChart} any */
function fill(any) {
  const { app, plot } = any;
  const { motion, text } = app;
  if (!any.shown || !motion.count) return;
  any.columns = columnsOf(motion, text);
  const list = (/** @type {number} */ which) =>
    Float64Array.from({ length: motion.count }, (_, i) => any.columns[which].value(i));
  any.x = Math.min(any.x, any.columns.length - 1);
  any.y = Math.min(any.y, any.columns.length - 1);
  showPicks(any);
  const label = `${any.columns[any.y].head}; ${any.columns[any.x].head}`;
  any.curve = { xs: list(any.x), ys: list(any.y), colour: "--accent" };
  plot.set({ curves: [any.curve] }, label);
  follow(any);
}

/** The choices of both axes, which depend on the arms. @param {AnyChart} any */
function showPicks(any) {
  const { app, picks, columns } = any;
  const heads = columns.map(({ head }) => head).join();
  if (picks.dataset.heads === heads) return;
  picks.dataset.heads = heads;
  const options = columns.map(({ head }, value) => ({ value, words: head }));
  const axis = (/** @type {"x" | "y"} */ name) => {
    const pick = choice(app.text(`measure.${name}`), options, any[name], (value) => {
      any[name] = Number(value);
      any.marks = { A: -1, B: -1 };
      fill(any);
    });
    pick.select.dataset.axis = name;
    return pick.element;
  };
  picks.replaceChildren(axis("y"), axis("x"));
}

/** The values at the clock and at the cursors. @param {AnyChart} any */
function follow(any) {
  const { app, columns, plot, table, marks } = any;
  const { motion, clock, text } = app;
  if (!any.shown || !columns.length || !motion.count) return;
  any.row = Math.min(Math.round(clock.time / motion.doc.span.step), motion.count - 1);
  // the time comes first, unless it is one of the two
  const told = [...new Set([0, any.x, any.y])];
  const values = (/** @type {number} */ row) => told.map((k) => columns[k].value(row));
  plot.mark(columns[any.x].value(any.row), columns[any.y].value(any.row));
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
  const head = told.map((k) => h("th", { scope: "col" }, columns[k].head));
  table.replaceChildren(
    h("table", {}, h("thead", {}, h("tr", {}, h("td", {}), ...head)), h("tbody", {}, ...rows)),
  );
}

/** @param {App} app */
export function createAnyChart(app) {
  const { motion, clock, text } = app;
  const bag = createBag();
  const region = { class: "scroll", tabindex: 0, role: "region" };
  /** @type {AnyChart} */
  const any = {
    app,
    x: 0,
    y: 1,
    row: 0,
    marks: { A: -1, B: -1 },
    shown: false,
    plot: createPlot(text, 220),
    curve: { xs: [], ys: [], colour: "" },
    table: h("div", { ...region, "aria-label": text("plots.values"), "data-any": "values" }),
    picks: h("div", { class: "any-picks" }),
    columns: [],
  };
  const cursor = (/** @type {"A" | "B"} */ name) =>
    button(
      text("measure.cursor", { name }),
      () => {
        any.marks[name] = any.row;
        follow(any);
      },
      { "data-cursor": name },
    );
  const soon = later(() => fill(any));
  bag(soon.end);
  bag(motion.subscribe((_, what) => what === "complete" && soon()));
  bag(clock.subscribe(() => follow(any)));
  bag.on(any.plot.element, "pointermove", (event) => {
    const row = nearest(any.plot.far(event), any.curve.xs, any.curve.ys);
    if (!clock.playing && row >= 0) clock.seek(row * motion.doc.span.step);
  });
  bag(any.plot.destroy);
  const row = h("div", { class: "row" }, cursor("A"), cursor("B"));
  return {
    element: h("div", {}, any.picks, any.plot.element, row, any.table),
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
