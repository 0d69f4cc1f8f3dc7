// The marks in a film: where tips are and when, two marks of a known distance, the pivot, what
// hangs straight below it; the same as places in metres, as a table, and kept in the browser.
// Leaves to others: the film's pictures (film_frames.js), marking (film_layer.js).
// Invariant: a mark is where it was set, in the film's own pixels and time; what is made of it
// follows from all marks each time anew.

import { keep } from "../../keep.js";
import { MARKS } from "../kit/table_file.js";

const KEPT = "pendulumd.films";
const FILMS = 8; // whose marks are kept
const SAME = 1e-4; // s, within which two times are of one picture

/** Pixels of the film: to the right, down from its upper left corner. @typedef {number[]} Spot */

/**
 * All marks of a film. slow: seconds of the film a second; rate: pictures a second, where the
 * browser does not tell their times; metres: between `one` and `two`; tips: of each arm [time,
 * across, down], in the order of the film's time.
 * @typedef {{
 *   name: string, size: number, width: number, height: number, duration: number, slow: number,
 *   rate: number, metres: number,
 *   fixed: {one?: Spot, two?: Spot, pivot?: Spot, below?: Spot}, tips: Record<string, number[][]>,
 * }} Marks
 */

/** A complex number. @typedef {[number, number]} Complex */

/** @param {Complex} a @param {Complex} b @returns {Complex} */
export const times = (a, b) => [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]];

/**
 * The marks of a film that has none yet.
 * @param {{name: string, size: number}} file
 * @param {{width: number, height: number, duration: number}} film @returns {Marks}
 */
export const noMarks = ({ name, size }, { width, height, duration }) => ({
  ...{ name, size, width, height, duration },
  ...{ slow: 1, rate: 30, metres: 1, fixed: {}, tips: {} },
});

/** @param {Marks} marks @param {number} arm @param {number} time s of the film */
export const tipAt = ({ tips }, arm, time) =>
  tips[arm]?.find((row) => Math.abs(row[0] - time) < SAME);

/**
 * Marks a tip, or (null) takes its mark away.
 * @param {Marks} marks @param {number} arm @param {number} time @param {Spot | null} spot
 */
export function setTip({ tips }, arm, time, spot) {
  const others = (tips[arm] ?? []).filter((row) => Math.abs(row[0] - time) >= SAME);
  if (spot) others.push([time, ...spot]);
  tips[arm] = others.sort((a, b) => a[0] - b[0]);
}

/** Pixels a metre; NaN where it is not known. @param {Marks} marks */
export function scaleOf({ fixed: { one, two }, metres }) {
  const far = one && two ? Math.hypot(one[0] - two[0], one[1] - two[1]) : 0;
  return far > 0 && metres > 0 ? far / metres : NaN;
}

/**
 * What is told of a place, a + b (across - i down) in `unit`: from the pivot, or from the lower
 * left corner where none is marked; y is up, against what hangs straight down.
 * @param {Marks} marks @returns {{a: Complex, b: Complex, unit: string}}
 */
export function placing(marks) {
  const { pivot = [0, marks.height], below } = marks.fixed;
  const scale = scaleOf(marks);
  const [across, down] = below ? [below[0] - pivot[0], below[1] - pivot[1]] : [0, 1];
  const far = Math.hypot(across, down) * (scale || 1) || 1;
  /** @type {Complex} */
  const b = [down / far, -across / far];
  const [x, y] = times(b, [pivot[0], -pivot[1]]);
  return { a: [-x, -y], b, unit: scale ? "m" : "px" };
}

/** Where a spot is: [x, y]. @param {ReturnType<typeof placing>} how @param {Spot} spot */
export function placeOf({ a, b }, [across, down]) {
  const [x, y] = times(b, [across, -down]);
  return [a[0] + x, a[1] + y];
}

/** The arms that have marks. @param {Marks} marks */
export const markedArms = ({ tips }) =>
  Object.keys(tips)
    .map(Number)
    .filter((arm) => tips[arm].length)
    .sort((a, b) => a - b);

/**
 * The marks of all tips as a table: a row a picture, an empty cell where a tip has no mark.
 * @param {Marks} marks @param {string} form of MARKS
 */
export function tableOf(marks, form) {
  const [decimal, between] = MARKS[form];
  const how = placing(marks);
  const arms = markedArms(marks);
  const all = arms.flatMap((arm) => marks.tips[arm].map(([time]) => time)).sort((a, b) => a - b);
  const when = all.filter((time, i) => !i || time - all[i - 1] >= SAME);
  const heads = arms.flatMap((arm) => [`x_${arm} in ${how.unit}`, `y_${arm} in ${how.unit}`]);
  const lines = [["t in s", ...heads].join(between)];
  for (const time of when) {
    const places = arms.flatMap((arm) => {
      const row = tipAt(marks, arm, time);
      return row ? placeOf(how, row.slice(1)) : [NaN, NaN];
    });
    const cells = [time / marks.slow, ...places].map((value) =>
      Number.isNaN(value) ? "" : String(Number(value.toPrecision(7))),
    );
    lines.push(cells.map((cell) => cell.replace(".", decimal)).join(between));
  }
  return `${lines.join("\r\n")}\r\n`;
}

/** The marks that are kept, the newest first. @returns {Marks[]} */
export function keptMarks() {
  try {
    const list = JSON.parse(keep.get(KEPT) ?? "[]");
    return Array.isArray(list) ? list.filter((one) => one?.name && one.fixed && one.tips) : [];
  } catch {
    return [];
  }
}

/** @param {{name: string, size: number}} a @param {{name: string, size: number}} b */
export const sameFilm = (a, b) => a.name === b.name && a.size === b.size;

/** @param {Marks} marks */
export function keepMarks(marks) {
  const others = keptMarks().filter((one) => !sameFilm(one, marks));
  keep.set(KEPT, JSON.stringify([marks, ...others].slice(0, FILMS)));
}
