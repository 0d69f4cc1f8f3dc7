// What the ruler and the protractor read, in words.
// Leaves to others: the numbers (gauge_numbers.js), where the words stand.
// Invariant: lengths in metres with millimetres, angles in degrees with tenths.

import { protractorReads, rulerReads } from "./gauge_numbers.js";

/** @typedef {import("./gauge_numbers.js").Gauge} Gauge */

/** @param {Text} text @param {Gauge} gauge @param {number[]} numbers */
export function readings(text, gauge, numbers) {
  if (gauge === "ruler")
    return text("measure.metres", { length: text.number(rulerReads(numbers).length, 3) });
  return text("degrees", { angle: text.number(protractorReads(numbers), 1) });
}

/**
 * A handle by its name, and where it is.
 * @param {Text} text @param {string} name @param {number[]} numbers
 */
export function shownIn(text, name, numbers) {
  const [x, y] = name === "b" ? numbers.slice(2) : numbers;
  const angle = name === "to" ? numbers[3] : numbers[2];
  const holes = { x: text.number(x, 3), y: text.number(y, 3), angle: text.number(angle, 1) };
  return text(`measure.handle.${name}`, holes);
}
