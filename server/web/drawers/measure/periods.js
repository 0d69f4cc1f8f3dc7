// The swings of an arm, read off its motion: when it passes hanging in one direction, and how long
// it takes from one such passage to the next.
// Leaves to others: the samples (track.js), how it is shown (measure.js).
// Invariant: a passage lies between two samples and is found on the curve that the stage draws.

import { DEGREE, foldedTheta } from "../../angles.js";
import { termsOf } from "../../terms.js";
import { anglesAt } from "../../track.js";

const HALVINGS = 40;
const STILL = 1e-9; // degrees: what rounding makes of an arm that hangs at rest
const ALIKE = 1e-3; // of the period, up to which swings are as long as each other
const PERIODIC = 0.02; // of the period: where swings differ by more there is none

/** quick: it moves too far from one sample to the next for its swings to be told.
 * @typedef {{times: number[], amplitude: number, over: boolean, quick: boolean}} Swings */

/**
 * When an arm passes hanging, s since the start, in the direction in which it does so more often
 * (counterclockwise, where both are alike); how far it swings, degrees; whether it turns over.
 * @param {Track} track @param {number} arm from 1 @returns {Swings}
 */
export function swingsOf(track, arm) {
  const { n, count, columns, doc } = track;
  const phi = new Float64Array(n);
  const place = { index: 0, fraction: 0 };
  const at = (/** @type {number} */ time) => {
    anglesAt(track, time, place, phi);
    return foldedTheta(phi[arm - 1]);
  };
  const [right, left] = [/** @type {number[]} */ ([]), /** @type {number[]} */ ([])];
  let amplitude = 0;
  let over = false;
  let before = NaN;
  let fastest = 0; // rad/s
  for (let i = 0; i < count; i++) {
    const theta = foldedTheta(columns.phi[i * n + arm - 1]);
    amplitude = Math.max(amplitude, Math.abs(theta));
    fastest = Math.max(fastest, Math.abs(columns.phid[i * n + arm - 1]));
    // where it goes over the top the angle jumps from one end to the other
    const jumps = Math.abs(theta - before) >= 180;
    over ||= jumps;
    if (!jumps && i && before < 0 !== theta < 0) {
      let [low, high] = [(i - 1) * doc.span.step, i * doc.span.step];
      for (let turn = 0; turn < HALVINGS; turn++) {
        const middle = (low + high) / 2;
        if (at(middle) < 0 === before < 0) low = middle;
        else high = middle;
      }
      (theta < 0 ? left : right).push(high);
    }
    before = theta;
  }
  const times = left.length > right.length + 1 ? left : right;
  // fewer than six samples a swing: what is seen may be another, slower one
  const quick = amplitude >= STILL && fastest * doc.span.step > Math.min(amplitude * DEGREE, 1);
  return { times: quick || amplitude < STILL ? [] : times, amplitude, over, quick };
}

/**
 * The mean time from one passage to the next, the shortest and the longest, and whether they are
 * equal enough to be a period; null where there are fewer than two passages.
 * @param {number[]} times
 */
export function periodOf(times) {
  if (times.length < 2) return null;
  const each = times.slice(1).map((time, i) => time - times[i]);
  const mean = (times[times.length - 1] - times[0]) / each.length;
  const [least, most] = [Math.min(...each), Math.max(...each)];
  return { mean, count: each.length, least, most, periodic: most - least < PERIODIC * mean };
}

/**
 * A period, with the figures that the swings have in common, and of how many swings it is the mean;
 * where the swings differ, that there is none.
 * @param {NonNullable<ReturnType<typeof periodOf>>} found @param {Text} text
 */
export function periodWords({ count, mean, least, most, periodic }, text) {
  const range = { count, least: text.number(least, 2), most: text.number(most, 2) };
  if (!periodic) return { period: text("measure.notPeriodic", range), swings: "" };
  const alike = most - least < ALIKE * mean;
  return {
    period: text("seconds", { time: text.number(mean, alike ? 4 : 2) }),
    swings: text(alike ? "measure.alike" : "measure.unlike", range),
  };
}

/**
 * Why an arm has no period, in words.
 * @param {Swings} swings @param {Track} track @param {Text} text
 */
export const noPeriodOf = ({ quick }, { doc }, text) =>
  text(quick ? "measure.tooQuick" : "measure.noSwing", { step: text.short(doc.span.step) });

/**
 * How far from hanging an arm comes, in words.
 * @param {Swings} swings @param {Text} text
 */
export const farthestOf = ({ amplitude, over }, text) =>
  over ? text("measure.over") : text("degrees", { angle: text.number(amplitude, 1) });

/**
 * 2 pi sqrt(l/g), s: of small swings of a mass on a single ideal arm; NaN of any other pendulum.
 * @param {Tree} tree
 */
export const formulaOf = (tree) =>
  tree.length.length === 1 && tree.gravity > 0 && !Object.keys(termsOf(tree)).length
    ? 2 * Math.PI * Math.sqrt(tree.length[0] / tree.gravity)
    : NaN;
