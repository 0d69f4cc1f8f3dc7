// A map of flips in numbers: for every start of two arms, when an arm first turns over.
// Leaves to others: asking for it strip by strip (flipmap.js), drawing it (flipmap_paint.js).
// Invariant: what is known of a point is the server's number; the rest of the start is as when the
// map was begun.

import { stateOf } from "../../state.js";
import { pendulumOf } from "../../terms.js";
import { figure } from "../kit/kit.js";

const DEGREE = Math.PI / 180;
const HANGING = -Math.PI / 2;

/**
 * What is asked for: two arms, how many points a side, how many seconds.
 * @typedef {{across: number, up: number, count: number, duration: number}} Wish
 */

/**
 * A map: the pendulum and the start it was begun with, and of every point row by row from below:
 * when an arm turns over (below zero: none does), which, and whether its motion failed. The first
 * `done` points are known.
 * @typedef {Wish & {
 *   pendulum: Tree, initial: State, times: Float64Array, arms: Uint16Array, failed: Uint8Array,
 *   done: number,
 * }} FlipMap
 */

/** A point of a map, from the left and from below. @typedef {{i: number, j: number}} Point */

/** @param {Doc} doc @param {Wish} wish @returns {FlipMap} of which nothing is known */
export function createMap({ pendulum, initial }, wish) {
  const points = wish.count ** 2;
  const times = new Float64Array(points).fill(NaN);
  return {
    pendulum,
    initial,
    ...wish,
    times,
    arms: new Uint16Array(points),
    failed: new Uint8Array(points),
    done: 0,
  };
}

/**
 * The angle of place i of `count` from -180 to 180 degrees, as the server counts it.
 * @param {number} i @param {number} count
 */
export const angleAt = (i, count) => -180 + (360 * i) / (count - 1);

/** @param {number} arm @param {number} start @param {number} stop @param {number} count */
const axis = (arm, start, stop, count) => ({ vary: "theta", arm, start, stop, count, unit: "deg" });

/**
 * The body for /v1/ensembles of rows `row` ... row + rows - 1 from below; of all of them without.
 * @param {FlipMap} map @param {number} row @param {number} rows
 */
export function bodyOf(map, row = 0, rows = map.count) {
  const { pendulum, initial, across, up, count, duration } = map;
  const strip = axis(up, angleAt(row, count), angleAt(row + rows - 1, count), rows);
  return {
    pendulum: pendulumOf(pendulum),
    initial: stateOf(pendulum, initial),
    grid: [axis(across, -180, 180, count), strip],
    duration,
    observables: ["first_flip"],
  };
}

/**
 * The server's answer for the rows from `row` on.
 * @param {FlipMap} map @param {number} row @param {import("../kit/kit.js").Table} table
 */
export function takeRows(map, row, { columns, count }) {
  const from = row * map.count;
  map.times.set(columns.first_flip_time.subarray(0, count), from);
  map.arms.set(columns.first_flip_arm.subarray(0, count), from);
  map.failed.set(columns.status.subarray(0, count), from);
  map.done = from + count;
}

/**
 * The scale: from the earliest flip there is to the duration, by logarithms.
 * @param {FlipMap} map
 */
export function earliest(map) {
  let least = map.duration;
  for (const time of map.times) if (time > 0 && time < least) least = time;
  return Math.max(least, map.duration / 100);
}

/** The point nearest to a start. @param {FlipMap} map @param {State} start @returns {Point} */
export function nearestPoint(map, { phi }) {
  const most = map.count - 1;
  const near = (/** @type {number} */ arm) => {
    const angle = (phi[arm - 1] - HANGING) / DEGREE;
    const inside = ((((angle + 180) % 360) + 360) % 360) - 180;
    return Math.max(0, Math.min(most, Math.round(((inside + 180) / 360) * most)));
  };
  return { i: near(map.across), j: near(map.up) };
}

/** The start that a point stands for. @param {FlipMap} map @param {Point} point @returns {State} */
export function startOf(map, { i, j }) {
  const phi = [...map.initial.phi];
  phi[map.across - 1] = HANGING + angleAt(i, map.count) * DEGREE;
  phi[map.up - 1] = HANGING + angleAt(j, map.count) * DEGREE;
  return { phi, phid: map.initial.phid };
}

/** @param {FlipMap} map @param {Point} point @param {Text} text */
function whatAt(map, { i, j }, text) {
  const at = j * map.count + i;
  if (at >= map.done) return text("compare.unknown");
  if (map.failed[at]) return text("compare.failed");
  if (map.times[at] < 0) return text("compare.never", { time: text.short(map.duration) });
  return text("compare.flips", { arm: map.arms[at], time: figure(text, map.times[at], 3) });
}

/** A point in words. @param {FlipMap} map @param {Point} point @param {Text} text */
export function wordsOf(map, point, text) {
  return text("compare.point", {
    a: map.across,
    b: map.up,
    x: text.number(angleAt(point.i, map.count), 1),
    y: text.number(angleAt(point.j, map.count), 1),
    what: whatAt(map, point, text),
  });
}
