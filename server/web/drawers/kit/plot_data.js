// What the plots show, as lists: columns of the motion, its energies, and the panels of a picture
// for paper.
// Leaves to others: charts on the page (plots.js), any two quantities (any_chart.js), the picture
// (picture.js).
// Invariant: every number is a sample of the server's.

import { thetaOf } from "../../angles.js";
import { lowest } from "../../tree.js";
import { armLook } from "./kit.js";

const plain = (/** @type {number} */ value) => value;

/** What is shown of every arm: from which column, and in which unit. */
export const PER_ARM = [
  { id: "angles", column: "phi", shown: thetaOf },
  { id: "rates", column: "phid", shown: plain },
  { id: "forces", column: "lambda", shown: plain },
];
export const ENERGIES = [
  { id: "kinetic", colour: "--arm-2" },
  { id: "potential", colour: "--arm-1" },
  { id: "total", colour: "--ink" },
];

/** @typedef {import("./picture.js").Panel} Panel */

/**
 * Column k of a row-major table, of `count` rows.
 * @param {Float64Array} values @param {number} width @param {number} k @param {number} count
 * @param {(value: number) => number} shown
 */
export function columnOf(values, width, k, count, shown = plain) {
  const list = new Float64Array(count);
  for (let i = 0; i < count; i++) list[i] = shown(values[i * width + k]);
  return list;
}

/**
 * Angles in degrees without full turns; where one begins again there is a gap (NaN).
 * @param {Float64Array} list
 */
export function folded(list) {
  let before = NaN;
  return list.map((value) => {
    const theta = value - 360 * Math.ceil(value / 360 - 0.5);
    const jumps = Math.abs(theta - before) > 180;
    before = theta;
    return jumps ? NaN : theta;
  });
}

/**
 * The energies of a motion's samples, J, in the order of ENERGIES. The server counts the potential
 * energy from the pivot, the page from the lowest position.
 * @param {Motion} motion
 */
export function energiesIn({ columns, count, doc }) {
  const zero = lowest(doc.pendulum);
  return ENERGIES.map(({ id }) =>
    columnOf(columns[`energy_${id}`], 1, 0, count, (energy) =>
      id === "kinetic" ? energy : energy - zero,
    ),
  );
}

/**
 * How far the energy is from that of the start.
 * @param {Float64Array} total @param {number} count
 */
export const driftOf = (total, count) => total.slice(0, count).map((energy) => energy - total[0]);

/**
 * What of the time axis is seen: the samples inside, as a cut of any list.
 * @param {Motion} motion @param {[number, number]} x
 */
function cutOf(motion, [from, to]) {
  const t = motion.t.slice(0, motion.count);
  const first = t.findIndex((time) => time >= from);
  const last = t.findLastIndex((time) => time <= to) + 1;
  return {
    t: t.slice(first, last),
    cut: (/** @type {Float64Array} */ list) => list.slice(first, last),
  };
}

/** The colour of a custom property on paper. @param {string} name */
export function paperColour(name) {
  const style = getComputedStyle(document.documentElement);
  return style.getPropertyValue(name.replace("--arm", "--print-arm")).trim() || "#1c2330";
}

/**
 * The panels as they are seen: the same arms, the same time, and one of their own.
 * @param {Motion} motion @param {Text} text @param {[number, number]} x @param {Set<number>} hidden
 * arms, from 0 @param {boolean} fold @param {Panel} own
 */
export function panelsOf(motion, text, x, hidden, fold, own) {
  const { columns, count, n } = motion;
  const { t, cut } = cutOf(motion, x);
  const seen = Array.from({ length: n }, (_, k) => k).filter((k) => !hidden.has(k));
  /** @param {string} column @param {(value: number) => number} unit */
  const lines = (column, unit) =>
    seen.map((k) => {
      const { name, dash } = armLook(k + 1);
      const list = columnOf(columns[column], n, k, count, unit);
      const ys = cut(fold && column === "phi" ? folded(list) : list);
      return { name: String(k + 1), colour: paperColour(name), dash, xs: t, ys };
    });
  const lists = energiesIn(motion);
  const energies = ENERGIES.map(({ id, colour }, i) => {
    return { name: text(`plots.${id}`), colour: paperColour(colour), xs: t, ys: cut(lists[i]) };
  });
  const drift = {
    name: "",
    colour: "#1c2330",
    xs: t,
    ys: cut(driftOf(columns.energy_total, count)),
  };
  /** @type {Panel[]} */
  const panels = [
    { title: text("plots.energy"), x, series: energies },
    ...PER_ARM.map(({ id, column, shown }) => ({
      title: text(`plots.${id}`),
      x,
      degrees: column === "phi" ? "y" : "",
      series: lines(column, shown),
    })),
    { title: text("plots.drift"), x, series: [drift] },
    own,
  ];
  return panels.filter(({ series }) => series.length);
}
