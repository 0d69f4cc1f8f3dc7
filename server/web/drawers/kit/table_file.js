// The motion as a table for a pupil's spreadsheet: angles from hanging in degrees, places, forces
// and energies, with a name and a unit a column, and with the separators that the spreadsheet
// expects.
// Leaves to others: the samples (track.js), files for programs (files_of_numbers.js).
// Invariant: every number is a sample of the server's, or follows from the angles alone; nine
// digits.

import { thetaOf } from "../../angles.js";
import { cartAt } from "../../track.js";
import { createSpots, order, tips } from "../../tree.js";
import { ENERGIES, energiesIn } from "./plot_data.js";

/** How numbers and columns are told apart, by name. @type {Record<string, string[]>} */
export const MARKS = { comma: [",", ";"], point: [".", ","] };

/** What a spreadsheet of the browser's own language expects. */
export const ownMarks = () =>
  (0.5).toLocaleString(navigator.language).includes(",") ? "comma" : "point";

/** A text that is one cell. @param {string} words @param {string} between */
const cell = (words, between) =>
  /["\n]/.test(words) || words.includes(between) ? `"${words.replaceAll('"', '""')}"` : words;

/** @typedef {{id: string, head: string, value: (i: number) => number}} TableColumn */

/**
 * A column of each arm.
 * @param {number} n @param {Text} text @param {string} name
 * @param {(i: number, k: number) => number} value
 */
const perArm = (n, text, name, value) =>
  Array.from({ length: n }, (_, k) => ({
    id: `${name}_${k + 1}`,
    head: text(`table.${name}`, { arm: k + 1 }),
    value: (/** @type {number} */ i) => value(i, k),
  }));

/** Where the tips are at a sample; asked for row by row. @param {Motion} motion */
function placesOf({ track }) {
  const tree = track.doc.pendulum;
  const { start = 0, step } = track.doc.span;
  const rows = order(tree.parent);
  const spots = createSpots(track.n);
  let at = -1;
  return (/** @type {number} */ i) => {
    if (i !== at) {
      spots.cart = cartAt(track, i);
      tips(tree, rows, track.columns.phi, i * track.n, spots, start + i * step);
    }
    at = i;
    return spots;
  };
}

/** All columns of the motion. @param {Motion} motion @param {Text} text @returns {TableColumn[]} */
export function columnsOf(motion, text) {
  const { columns, n, t, doc } = motion;
  const { start = 0 } = doc.span;
  const places = placesOf(motion);
  const energies = energiesIn(motion);
  const cart = {
    id: "cart",
    head: text("table.cart"),
    value: (/** @type {number} */ i) => columns.cart_x[i],
  };
  return [
    { id: "time", head: text("table.time"), value: (i) => start + t[i] },
    ...perArm(n, text, "theta", (i, k) => thetaOf(columns.phi[i * n + k])),
    ...perArm(n, text, "omega", (i, k) => columns.phid[i * n + k]),
    ...perArm(n, text, "x", (i, k) => places(i).x[k]),
    ...perArm(n, text, "y", (i, k) => places(i).y[k]),
    ...perArm(n, text, "force", (i, k) => columns.lambda[i * n + k]),
    ...(columns.cart_x ? [cart] : []),
    ...ENERGIES.map(({ id }, k) => ({
      id,
      head: text(`table.${id}`),
      value: (/** @type {number} */ i) => energies[k][i],
    })),
  ];
}

/**
 * The table as a spreadsheet opens it: UTF-8 that says so, a row of names, a row a sample.
 * @param {Motion} motion @param {Text} text @param {string} marks of MARKS
 */
export function tableText(motion, text, marks) {
  const [decimal, between] = MARKS[marks];
  const list = columnsOf(motion, text);
  const lines = [list.map(({ head }) => cell(head, between)).join(between)];
  for (let i = 0; i < motion.count; i++) {
    const row = list.map(({ value }) => String(Number(value(i).toPrecision(9))));
    lines.push(row.map((number) => number.replace(".", decimal)).join(between));
  }
  return `\ufeff${lines.join("\r\n")}\r\n`;
}
