// A table of trials: a row for each pendulum that was measured, by one button from what swings or
// typed; a law through the rows, with standard errors.
// Leaves to others: the law (the engine, POST /v1/trials), reading periods (periods.js).
// Invariant: a row counts if it has both numbers that the law needs.

import { said } from "../../client.js";
import { h } from "../../dom.js";
import { aborted, button, choice, copyButton, figure, settled } from "../kit/kit.js";
import { createPlot } from "../kit/plot.js";
import { periodOf, swingsOf } from "./periods.js";

/** @type {[string, string][]} */
const COLUMNS = [
  ["length", "m"],
  ["mass", "kg"],
  ["amplitude", "\u00b0"],
  ["period", "s"],
];
const CURVE = 60; // points of the law's curve
const UNITS = { gravity: "m/s\u00b2" };

/** Numbers by the names of columns; NaN for an empty cell.
 * @typedef {Record<string, number>} Trial */

/**
 * @typedef {ReturnType<typeof partsOf> & {
 *   app: App, rows: Trial[], law: string, x: string, y: string, stop: AbortController | null,
 *   soon: Soon, plot: ReturnType<typeof createPlot>,
 * }} View
 */

const partsOf = () => ({
  table: h("div", { class: "scroll", tabindex: 0, role: "region" }),
  choices: h("div", { class: "fit-options" }),
  status: h("p", { role: "status", "data-trials": "status" }),
  found: h("dl", { class: "readout", "data-trials": "found" }),
});

/** The row of the pendulum that swings, or null if it has no period. @param {App} app */
function rowOf({ motion }) {
  const { doc, track } = motion;
  if (motion.n !== 1 || !motion.complete) return null;
  const swings = swingsOf(track, 1);
  const found = periodOf(swings.times);
  if (!found?.periodic || swings.over) return null;
  const { length, mass } = doc.pendulum;
  const [amplitude, period] = [swings.amplitude, found.mean].map((x) => Number(x.toPrecision(6)));
  return { length: length[0], mass: mass[0], amplitude, period };
}

/** @param {View} view @param {number} i @param {string} name */
function cellOf({ app, rows, soon }, i, name) {
  const { text } = app;
  const shown = Number.isNaN(rows[i][name]) ? "" : figure(text, rows[i][name], 6);
  const label = `${i + 1}: ${text(`trials.${name}`)}`;
  const input = h("input", { type: "text", inputmode: "decimal", "aria-label": label });
  Object.assign(input, { value: shown, size: 7 });
  input.dataset.trial = `${name}-${i + 1}`;
  input.addEventListener("change", () => {
    const value = input.value.trim() ? text.read(input.value) : NaN;
    input.setAttribute("aria-invalid", String(input.value.trim() !== "" && !(value >= 0)));
    rows[i][name] = value;
    soon();
  });
  return h("td", {}, input);
}

/** @param {View} view */
function showTable(view) {
  const { app, rows, table, soon } = view;
  const { text } = app;
  const heads = COLUMNS.map(([name, unit]) =>
    h("th", { scope: "col" }, `${text(`trials.${name}`)}, ${unit}`),
  );
  const lines = rows.map((_, i) => {
    const cells = COLUMNS.map(([name]) => cellOf(view, i, name));
    const gone = () => {
      rows.splice(i, 1);
      showTable(view);
      soon();
    };
    const label = { "aria-label": text("trials.remove", { row: i + 1 }) };
    return h("tr", {}, ...cells, h("td", {}, button("\u00d7", gone, label)));
  });
  table.setAttribute("aria-label", text("trials.title"));
  table.replaceChildren(
    ...(rows.length ? [h("table", {}, h("tr", {}, ...heads, h("td", {})), ...lines)] : []),
  );
}

/** Which law, between which columns. @param {View} view */
function showChoices(view) {
  const { app, choices, law, soon } = view;
  const { text } = app;
  const pick = (
    /** @type {"law" | "x" | "y"} */ name,
    /** @type {string[]} */ list,
    /** @type {string} */ label,
  ) => {
    const options = list.map((value) => ({ value, words: text(`trials.${value}`) }));
    const one = choice(label, options, view[name], (value) => {
      view[name] = value;
      showChoices(view);
      soon();
    });
    one.select.dataset.trials = name;
    return one.element;
  };
  const names = COLUMNS.map(([name]) => name);
  choices.replaceChildren(
    pick("law", ["pendulum", "line", "power"], text("trials.law")),
    ...(law === "pendulum"
      ? []
      : [pick("x", names, text("measure.x")), pick("y", names, text("measure.y"))]),
  );
}

/** The law's curve from 0 to beyond the trials, as trials without y. @param {View} view
 * @param {Trial[]} used */
function curveOf({ x }, used) {
  const most = 1.1 * Math.max(...used.map((row) => row[x]));
  return Array.from({ length: CURVE }, (_, i) => ({ [x]: (most * (i + 1)) / CURVE }));
}

/** @param {View} view @param {any} answer @param {Trial[]} used @param {Trial[]} curve */
function showLaw(view, { unknowns, trials }, used, curve) {
  const { app, found, plot, x, y } = view;
  const { text } = app;
  const lines = Object.entries(unknowns).flatMap(([name, { value, error }]) => {
    const plus = error === null ? "" : ` \u00b1 ${figure(text, error, 2)}`;
    const unit = name === "gravity" ? ` ${UNITS.gravity}` : "";
    const digits = error > 0 ? Math.max(0, Math.min(8, 1 - Math.floor(Math.log10(error)))) : 4;
    const words = `${text.number(value, digits)}${plus}${unit}`;
    return [
      h("dt", {}, text(`trials.${name}`)),
      h("dd", { "data-found": name, "data-value": value }, words),
    ];
  });
  found.replaceChildren(...lines);
  const law = trials.slice(used.length);
  const xs = curve.map((one) => one[x]);
  const band = (/** @type {number} */ sign) =>
    law.map((/** @type {any} */ { fitted, error }) => fitted + sign * (error ?? NaN));
  const [axis, other] = [x, y].map((name) => {
    const unit = COLUMNS.find(([own]) => own === name)?.[1];
    return `${text(`trials.${name}`)}, ${unit}`;
  });
  const curves = [
    { xs, ys: law.map((/** @type {any} */ one) => one.fitted), colour: "--arm-1" },
    ...[-1, 1].map((sign) => ({ xs, ys: band(sign), colour: "--arm-1", dash: [4, 3] })),
    { xs: used.map((row) => row[x]), ys: used.map((row) => row[y]), colour: "--arm-2", dots: 3 },
  ];
  plot.set({ x: axis, y: other, curves, low: 0 }, text("trials.title"));
  plot.element.hidden = false;
}

/** Asks for the law. @param {View} view */
async function fit(view) {
  const { app, rows, law, x, y, status, found, plot } = view;
  const { client, text } = app;
  view.stop?.abort();
  const stop = (view.stop = new AbortController());
  const used = rows.filter((row) => row[x] > 0 && row[y] > 0);
  const few = new Set(used.map((row) => row[x])).size < (law === "pendulum" ? 1 : 2);
  found.replaceChildren();
  plot.element.hidden = true;
  status.textContent = rows.length && few ? text("trials.few") : "";
  if (few) return;
  const curve = curveOf(view, used);
  // an empty cell is null; an amplitude on an axis is in degrees, of which a law knows nothing
  const plain = [...used, ...curve].map((row) =>
    Object.fromEntries(Object.entries(row).map(([key, value]) => [key, value >= 0 ? value : null])),
  );
  try {
    const body = { law, ...(law !== "pendulum" && { x, y }), unit: "deg", trials: plain };
    showLaw(view, await client.trials(body, { signal: stop.signal }), used, curve);
  } catch (error) {
    if (!aborted(error)) status.textContent = said(error, text);
  }
}

/** The table as a spreadsheet takes it. @param {View} view */
const csvOf = ({ app, rows }) =>
  [
    COLUMNS.map(([name, unit]) => `${app.text(`trials.${name}`)} (${unit})`).join("\t"),
    ...rows.map((row) =>
      COLUMNS.map(([name]) => (Number.isNaN(row[name]) ? "" : app.text.number(row[name], 6))).join(
        "\t",
      ),
    ),
  ].join("\n");

/** @param {App} app */
export default async function mountTrials(app) {
  const { text, files } = app;
  await Promise.all([text.part("fits"), files.style("drawers/kit/curves.css")]);
  const view = /** @type {View} */ ({
    ...partsOf(),
    ...{ app, rows: (app.trials ??= []), law: "pendulum", x: "length", y: "period", stop: null },
    ...{ soon: settled(() => fit(view)), plot: createPlot(text, 220) },
  });
  const { rows, table, choices, status, found, plot, soon } = view;
  const add = (/** @type {Trial | null} */ row) => {
    if (!row) return (status.textContent = text("trials.none"));
    rows.push(row);
    showTable(view);
    soon();
  };
  const keys = [
    button(text("trials.add"), () => add(rowOf(app)), {
      class: "button main",
      "data-trials": "add",
    }),
    button(text("trials.empty"), () =>
      add(Object.fromEntries(COLUMNS.map(([name]) => [name, NaN]))),
    ),
    copyButton(app, text("trials.copy"), () => csvOf(view)),
  ];
  const intro = h("p", { class: "quiet" }, text("trials.intro"));
  const element = h("div", { class: "fit" }, intro, h("div", { class: "row" }, ...keys));
  element.append(table, choices, status, found, plot.element);
  showTable(view);
  showChoices(view);
  fit(view);
  return {
    element,
    destroy() {
      soon.end();
      view.stop?.abort();
      plot.destroy();
    },
  };
}
