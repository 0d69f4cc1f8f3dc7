// What is asked of the server for a fit: the measurements in its terms, where the search begins,
// and which numbers are to be found.
// Leaves to others: the table (fit_table.js), the choices (fits.js), the answer (fit_answer.js).
// Invariant: the pendulum is the document's.

import { DEGREE } from "../../angles.js";
import { pendulumOf, termOf } from "../../terms.js";
import { columnsLike } from "./fit_table.js";

/**
 * What has been chosen; columns: what they are, where the engine took them for something else;
 * places: whether the pivot's place, the turn, the tilt and the
 * distortion of the camera are sought as well; stage: the pendulum of the stage is fitted, though
 * the table has another number of arms; sigmas as typed, NaN for none, in the unit of the columns.
 * @typedef {{
 *   columns: import("./fit_table.js").Given, angle: string, place: string,
 *   down: boolean, origin: boolean, turned: boolean, tilt: boolean, distortion: boolean,
 *   stage: boolean,
 *   sigmaAngle: number, sigmaPlace: number, unknown: Set<string>,
 * }} Choices
 */

/**
 * A number that can be found. factor: what a value of the server is times to be shown.
 * @typedef {{
 *   id: string, vary: string, arm?: number | "cart", unit: string, factor: number,
 * }} Candidate
 */

/** Units a metre; of "px" it is not known. @type {Record<string, number>} */
export const PLACES = { m: 1, cm: 100, mm: 1000, px: NaN };

/** Units of what is found, and what rad are times to be shown. @type {Record<string, [string,
 * number]>} */
const UNITS = {
  length: ["m", 1],
  mass: ["kg", 1],
  rod: ["kg", 1],
  damping: ["N\u00b7m\u00b7s", 1],
  stiffness: ["N\u00b7m", 1],
  friction_torque: ["N\u00b7m", 1],
  drag: ["N\u00b7s/m", 1],
  drag_per_mass: ["1/s", 1],
  gravity: ["m/s\u00b2", 1],
  theta: ["\u00b0", 1 / DEGREE],
  thetad: ["\u00b0/s", 1 / DEGREE],
  zero: ["\u00b0", 1 / DEGREE],
  bias: ["\u00b0/s", 1 / DEGREE],
  bias_along: ["m/s\u00b2", 1],
  bias_across: ["m/s\u00b2", 1],
  phi: ["m", 1],
  phid: ["m/s", 1],
};

/**
 * A chain of equal arms that swings about as fast as what was measured.
 * @param {number} arms @param {number} gravity m/s^2
 * @param {import("./fit_table.js").FitTable} table @returns {Tree}
 */
export function plainTree(arms, gravity, { data }) {
  const { t, series } = data ?? { t: [], series: [] };
  const list = (series.find((one) => !("y" in one))?.values ?? []).map(Number);
  const mean = list.reduce((sum, one) => sum + one, 0) / list.length;
  const passed = t.filter((_, i) => i && list[i] > mean !== list[i - 1] > mean);
  const period = (2 * (passed[passed.length - 1] - passed[0])) / (passed.length - 1);
  const length = gravity * (period / (2 * Math.PI)) ** 2;
  const long = passed.length > 2 && length > 0.01 && length < 100 ? length : 0.5;
  const each = Number((long / arms).toPrecision(3));
  const row = (/** @type {number} */ value) => Array(arms).fill(value);
  return { length: row(each), mass: row(1), parent: row(0).map((_, k) => k), gravity };
}

/** @param {string} vary @param {number | "cart"} [arm] @returns {Candidate} */
const candidate = (vary, arm) => ({
  id: arm ? `${vary} ${arm}` : vary,
  vary,
  arm,
  unit: UNITS[vary][0],
  factor: UNITS[vary][1],
});

/** Whether an arm has a number, or can be given it. @param {Tree} tree @param {number} k */
const has = (tree, k) => ({
  length: true,
  mass: tree.mass[k] > 0,
  damping: !tree.pivot?.cart || Boolean(termOf(tree, "damping", k)),
  rod: Boolean(termOf(tree, "rod", k)),
  stiffness: Boolean(termOf(tree, "stiffness", k)),
  friction_torque: Boolean(termOf(tree, "friction", k)),
  drag: Boolean(termOf(tree, "drag", k)?.linear),
  theta: true,
  thetad: true,
});

/** What can be found of a pendulum and of its instruments, besides the camera. @param {Tree} tree
 * @param {import("./fit_table.js").FitTable} table */
export function candidatesOf(tree, table) {
  const arms = tree.length.flatMap((_, k) =>
    Object.entries(has(tree, k)).flatMap(([vary, there]) =>
      there ? [candidate(vary, k + 1)] : [],
    ),
  );
  const whole = tree.drag_per_mass ? ["gravity", "drag_per_mass"] : ["gravity"];
  /** @type {[string, RegExp][]} */
  const instruments = [
    ["zero", /^(theta|phi|joint) /],
    ["bias", /^thetad /],
    ["bias_along", /^along /],
    ["bias_across", /^across /],
  ];
  const added = instruments.flatMap(([vary, kind]) => {
    const measured = columnsLike(table, kind).map(({ is }) => Number(is.split(" ")[1]));
    return [...new Set(measured)].map((arm) => candidate(vary, arm));
  });
  const { cart } = tree.pivot ?? {};
  const numbers = cart ? ["mass", ...(cart.damping ? ["damping"] : []), "phi", "phid"] : [];
  const ofCart = numbers.map((vary) => candidate(vary, "cart"));
  return [...arms, ...ofCart, ...whole.map((vary) => candidate(vary)), ...added];
}

/** @param {Tree} tree lengths, friction and the start, of every arm; the start of a cart */
export const usual = (tree) =>
  tree.length
    .flatMap((_, k) => ["length", "damping", "theta", "thetad"].map((vary) => `${vary} ${k + 1}`))
    .concat(tree.pivot?.cart ? ["phi cart", "phid cart"] : []);

/**
 * The instants, s, and what was measured, in rad, rad/s or the table's unit of places.
 * @param {import("./fit_table.js").FitTable} table @param {Choices} choices
 */
export function measuredOf({ data }, { down }) {
  const series = (data?.series ?? []).map(({ values, sigma, ...of }) => {
    const [[kind, arm]] = Object.entries(of);
    const up = kind === "y" && down ? -1 : 1;
    const list = values.map((value) => (value === null ? null : up * value));
    return { kind, arm: Number(arm), values: list, sigma };
  });
  return { t: data?.t ?? [], series };
}

/** @typedef {ReturnType<typeof measuredOf>} Measured */

/** Series in rad or rad/s. */
const TURNS = /^(theta|phi|joint|thetad|amplitude)$/;

/** @param {string} kind of a series */
export const isPlace = (kind) => kind === "x" || kind === "y";

/**
 * The camera, null where no places were measured. Where it begins is taken from the data.
 * @param {Measured} measured @param {Choices} choices
 */
function cameraOf({ series }, { place, origin, turned, tilt, distortion }) {
  if (!series.some(({ kind }) => isPlace(kind))) return null;
  const scale = PLACES[place];
  const unknown = [
    ...(scale ? [] : ["scale"]),
    ...(origin ? ["origin"] : []),
    ...(turned ? ["rotation"] : []),
    ...(tilt ? ["tilt"] : []),
    ...(distortion ? ["distortion"] : []),
  ];
  return { ...(scale && { scale }), unknown };
}

/**
 * The body for POST /v1/fits.
 * @param {Tree} pendulum @param {import("./fit_table.js").FitTable} table
 * @param {Measured} measured @param {Choices} choices
 */
export function fitBody(pendulum, table, measured, choices) {
  const { angle, sigmaAngle, sigmaPlace, unknown } = choices;
  const camera = cameraOf(measured, choices);
  const turn = angle === "deg" ? DEGREE : 1;
  const series = measured.series.map(({ kind, arm, values, sigma: listed }) => {
    const typed = isPlace(kind) ? sigmaPlace : TURNS.test(kind) ? sigmaAngle * turn : NaN;
    const sigma = typed > 0 ? typed : listed;
    return { [kind]: kind === "cart" || arm, values, ...(sigma && { sigma }) };
  });
  const all = candidatesOf(pendulum, table);
  const named = all.map(({ vary, arm }) => (arm ? { vary, arm } : { vary }));
  // starts are taken from the data, and sought unless they are fixed
  const start = (/** @type {number} */ k) => /^(theta|phi)/.test(all[k].vary);
  return {
    pendulum: pendulumOf(pendulum),
    ...(camera && { camera }),
    data: { t: measured.t, series },
    unknowns: named.filter((_, k) => unknown.has(all[k].id)),
    fixed: named.filter((_, k) => start(k) && !unknown.has(all[k].id)),
  };
}

/**
 * What is found, in the order of the answer: those of the request, then the camera's.
 * @param {ReturnType<typeof fitBody>} body @param {string} unit of places
 * @returns {Candidate[]}
 */
export function foundOf({ unknowns, camera }, unit) {
  const own = unknowns.map(({ vary, arm }) => candidate(vary, arm));
  /** @type {Record<string, Candidate[]>} */
  const more = {
    scale: [{ id: "scale", vary: "scale", unit: `${unit}/m`, factor: 1 }],
    rotation: [{ id: "rotation", vary: "rotation", unit: "\u00b0", factor: 1 / DEGREE }],
    origin: ["origin_x", "origin_y"].map((vary) => ({ id: vary, vary, unit, factor: 1 })),
    tilt: ["x", "y"].map((id) => ({ id: `tilt_${id}`, vary: "tilt", unit: "1/m", factor: 1 })),
    distortion: [{ id: "distortion", vary: "distortion", unit: "%", factor: 100 }],
  };
  return [...own, ...(camera?.unknown ?? []).flatMap((name) => more[name])];
}
