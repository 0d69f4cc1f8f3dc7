// The fields of a method: which one, its tolerances, the digits that it computes in.
// Leaves to others: what these change (state.js), what they cost (method.js).
// Invariant: a field shows the document's choice, also one that is not among those offered.

import { h } from "../../dom.js";
import { isStatic } from "../../root.js";
import { choice, figure } from "../kit/kit.js";

/**
 * A method's default tolerance, the finest that is offered, and what the absolute one is of it.
 * @typedef {{rtol: number, finest: number, divisor: number}} Tolerances
 */

/** @type {Record<string, Tolerances | null>} */
const METHODS = {
  taylor: { rtol: 1e-12, finest: 1e-16, divisor: Infinity },
  ode23: { rtol: 1e-3, finest: 1e-13, divisor: 1000 },
  rkf45: { rtol: 1e-9, finest: 1e-14, divisor: 1000 },
  rk8pd: { rtol: 1e-9, finest: 1e-14, divisor: 1000 },
  msadams: { rtol: 1e-9, finest: 1e-14, divisor: 1000 },
  symplectic: null,
  radau: { rtol: 1e-9, finest: 1e-14, divisor: 1e6 },
  linear: null,
};
/** What a server alone has. */
const SERVED = ["rkf45", "rk8pd", "msadams", "extended"];
/** @param {string} value */
const isHere = (value) => !isStatic || !SERVED.includes(value);
/** What taylor computes in. @type {Record<string, Partial<Tolerances>>} */
const DIGITS = { double: {}, extended: { rtol: 1e-28 } };
const TOLERANCES = [1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-9, 1e-10, 1e-12, 1e-13, 1e-14, 1e-16];
const ABSOLUTE = [0, 1e-3, 1e-6, 1e-9, 1e-12, 1e-15, 1e-18];

/** @param {Doc} doc @returns {Tolerances | null} */
function tolerancesOf({ method, precision }) {
  const known = METHODS[method];
  return known && { ...known, ...(method === "taylor" && DIGITS[precision]) };
}

/**
 * What is offered, with the document's own value among it.
 * @param {number[]} values @param {number | null} value
 */
function withOwn(values, value) {
  return value === null || values.includes(value)
    ? values
    : [...values, value].sort((a, b) => b - a);
}

/**
 * A tolerance to choose, or the method's own.
 * @param {App} app @param {"rtol" | "atol"} key @param {number | null} value @param {number[]}
 * values @param {number} usual
 */
function toleranceField({ store, text }, key, value, values, usual) {
  const own = { value: "", words: text("method.default", { value: figure(text, usual, 2) }) };
  const list = withOwn(values, value).map((one) => ({ value: one, words: figure(text, one, 2) }));
  const field = choice(text(`method.${key}`), [own, ...list], value ?? "", (chosen) =>
    store.set({ [key]: chosen === "" ? null : Number(chosen) }, { label: "tolerance" }),
  );
  field.select.dataset[key] = "";
  return field.element;
}

/** @param {App} app @param {Doc} doc @param {Tolerances} known */
function toleranceFields(app, doc, { rtol, finest, divisor }) {
  const relative = TOLERANCES.filter((value) => value >= finest);
  return [
    toleranceField(app, "rtol", doc.rtol, relative, rtol),
    toleranceField(app, "atol", doc.atol, ABSOLUTE, (doc.rtol ?? rtol) / divisor),
  ];
}

/** @param {App} app @param {Doc} doc */
function methodField({ store, text }, doc) {
  const methods = Object.keys(METHODS)
    .filter(isHere)
    .map((value) => ({ value, words: text(`method.${value}`) }));
  const field = choice(text("drawer.method"), methods, doc.method, (method) =>
    store.set({ method, rtol: null, atol: null, precision: "double" }, { label: "method" }),
  );
  field.select.dataset.method = "";
  return field.element;
}

/** @param {App} app @param {Doc} doc */
function precisionField({ store, text }, doc) {
  const list = Object.keys(DIGITS)
    .filter(isHere)
    .map((value) => ({ value, words: text(`method.${value}`) }));
  const field = choice(text("method.precision"), list, doc.precision, (precision) =>
    store.set({ precision, rtol: null, atol: null }, { label: "method" }),
  );
  field.select.dataset.precision = "";
  return field.element;
}

/**
 * All fields of the document's method into their place; the focus stays on the field that had it.
 * @param {App} app @param {HTMLElement} place @param {Doc} doc
 */
export function showFields(app, place, doc) {
  const known = tolerancesOf(doc);
  /** @type {HTMLElement[]} */
  const rows = [methodField(app, doc)];
  if (known) rows.push(...toleranceFields(app, doc, known));
  else rows.push(h("p", { class: "quiet" }, app.text("method.none")));
  if (doc.method === "taylor") rows.push(precisionField(app, doc));
  const active = /** @type {HTMLElement | null} */ (document.activeElement);
  const focused = active && place.contains(active) ? Object.keys(active.dataset)[0] : null;
  place.replaceChildren(...rows);
  const again = focused ? place.querySelector(`[data-${focused}]`) : null;
  /** @type {HTMLElement | null} */ (again)?.focus();
}
