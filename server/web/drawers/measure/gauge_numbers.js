// The ruler and the protractor as numbers: what they read, where they lie at first, where a hand
// that is near a joint means the joint.
// Leaves to others: strokes (paint_gauges.js), hands and keys (gauges.js), fields
// (gauge_fields.js).
// Invariant: places are metres from where the pivot stands at first, to the right and upwards;
// directions are degrees from hanging, counterclockwise.

import { foldedTheta, phiOf } from "../../angles.js";

const NEAR = 12; // pixels, up to which a joint is meant

/**
 * The names of a gauge's four numbers.
 * @type {Record<Gauge, string[]>}
 */
export const NUMBERS = {
  ruler: ["ax", "ay", "bx", "by"],
  protractor: ["cx", "cy", "from", "to"],
};

/** @typedef {"ruler" | "protractor"} Gauge */

/** @param {number[]} ruler */
export function rulerReads([ax, ay, bx, by]) {
  return { length: Math.hypot(bx - ax, by - ay), across: bx - ax, up: by - ay };
}

/**
 * From the first leg to the second, degrees in (-180, 180], counterclockwise.
 * @param {number[]} protractor
 */
export const protractorReads = ([, , from, to]) => foldedTheta(phiOf(to - from));

/** A step of 1, 2 or 5 times a power of ten that is at least so large. @param {number} least */
export function roundStep(least) {
  const power = 10 ** Math.floor(Math.log10(least));
  const factor = [1, 2, 5, 10].find((many) => many * power >= least * (1 - 1e-9)) ?? 10;
  return Number((factor * power).toPrecision(1));
}

/** As many digits as a place on the stage has. @param {number} metres @param {number} scale */
export function tidied(metres, scale) {
  const digit = roundStep(0.5 / scale);
  return Number((Math.round(metres / digit) * digit).toPrecision(10));
}

/**
 * Where a gauge lies at first: the ruler level below the middle of what is seen, the protractor at
 * the pivot.
 * @param {Gauge} gauge @param {Seen} seen @returns {number[]}
 */
export function laid(gauge, { left, right, up, down }) {
  if (gauge === "protractor") return [0, 0, 0, 45];
  const step = roundStep((right - left) / 6);
  const [x, y] = [(left + right) / 2, (up + 2 * down) / 3];
  const low = Math.round(y / step) * step;
  const start = Math.round(x / step - 1) * step;
  return [start, low, start + 2 * step, low].map((value) => Number(value.toPrecision(10)));
}

/**
 * The joints and tips that are seen, metres. @param {Shape} shape @returns {number[][]}
 */
function joints({ n, x, y, fromX, fromY, pivot }) {
  const list = [[pivot.x, pivot.y]];
  for (let k = 0; k < n; k++) list.push([x[k], y[k]], [fromX[k], fromY[k]]);
  return list;
}

/**
 * The joint that a hand is near, none if it is near to none.
 * @param {Look} look @param {number[]} at @returns {number[] | null}
 */
function jointNear({ shape, camera }, [x, y]) {
  /** @type {number[] | null} */
  let best = null;
  let least = NEAR / camera.scale;
  for (const [jx, jy] of joints(shape)) {
    const far = Math.hypot(jx - x, jy - y);
    if (far < least) [best, least] = [[jx, jy], far];
  }
  return best;
}

/**
 * The place that is meant by a place of a hand, metres: the nearest joint where one is near.
 * @param {Look} look @param {number[]} at
 */
export function meant(look, at) {
  return jointNear(look, at) ?? at.map((metres) => tidied(metres, look.camera.scale));
}

/**
 * The direction of a leg that leads to a hand: in tenths of a degree, or through the joint that is
 * near.
 * @param {Look} look @param {number[]} corner @param {number[]} at
 */
export function leg(look, [cx, cy], at) {
  const joint = jointNear(look, at);
  const [x, y] = joint ?? at;
  if (x === cx && y === cy) return null;
  const theta = foldedTheta(Math.atan2(y - cy, x - cx));
  return joint ? theta : Math.round(theta * 10) / 10;
}

/**
 * Where a leg ends that is so long.
 * @param {number[]} corner @param {number} theta @param {number} long
 */
export function legEnd([cx, cy], theta, long) {
  const phi = phiOf(theta);
  return [cx + long * Math.cos(phi), cy + long * Math.sin(phi)];
}
