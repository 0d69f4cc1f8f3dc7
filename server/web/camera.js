// How much of the plane the stage shows: all that the motion reaches, in steps, so that it seldom
// changes.
// Leaves to others: drawing. Scale of the forces' colours: the same idea, for the same reason.
// Invariant: what is shown follows from the motion and the stage's size alone, not from what was
// shown before.

import { tips } from "./tree.js";

const LOOKS = 500; // samples that are looked at, at most
const STEPS = 6; // the box grows in sixths of the reach

/**
 * The least box around the pivot, in steps of the reach, that holds the motion: {side, up, down} in
 * metres.
 * @param {Track} track @param {number[]} rows @param {number} reach @param {Float64Array} x @param
 * {Float64Array} y @returns {Box}
 */
export function boxOf(track, rows, reach, x, y) {
  const tree = track.doc.pendulum;
  const box = { side: 0, up: 0, down: 0 };
  /** @param {ArrayLike<number>} phi @param {number} offset */
  const look = (phi, offset) => {
    tips(tree, rows, phi, offset, x, y);
    for (let k = 0; k < track.n; k++) {
      box.side = Math.max(box.side, Math.abs(x[k]));
      box.up = Math.max(box.up, y[k]);
      box.down = Math.max(box.down, -y[k]);
    }
  };
  look(track.initial.phi, 0);
  const stride = Math.ceil(track.count / LOOKS);
  for (let i = 0; i < track.count; i += stride) look(track.columns.phi, i * track.n);
  /** @param {number} value */
  const stepped = (value) =>
    Math.min(STEPS, Math.ceil((value / reach) * STEPS - 1e-6)) * (reach / STEPS);
  return {
    side: Math.max(stepped(box.side), reach / 2),
    up: stepped(box.up),
    down: Math.max(stepped(box.down), reach / 2),
  };
}

/**
 * Where the pivot is, and how many pixels a metre has, so that the box fills the place.
 * @param {Box} box @param {number} width @param {number} height @param {{left: number, right:
 * number, top: number, bottom: number}} margin @param {Camera} camera
 */
export function aim(box, width, height, margin, camera) {
  const across = width - margin.left - margin.right;
  const along = height - margin.top - margin.bottom;
  camera.scale = Math.max(1, Math.min(across / (2 * box.side), along / (box.up + box.down)));
  camera.x = margin.left + across / 2;
  camera.y = margin.top + (along - camera.scale * (box.up + box.down)) / 2 + camera.scale * box.up;
}

/** A round number that is not below the value. @param {number} value */
export function roundUp(value) {
  if (!(value > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(value));
  const digit = [1, 1.5, 2, 3, 4, 6, 8].find((one) => one * power >= value * 0.999) ?? 10;
  return Number((digit * power).toPrecision(3));
}

/**
 * The end of the colours' scale: what 95 of 100 forces stay below, rounded up.
 * @param {Track} track
 */
export function forceScale(track) {
  const { lambda } = track.columns;
  if (!track.count || !lambda) return 0;
  const count = track.count * track.n;
  const stride = Math.max(1, Math.floor(count / 5000)) | 1;
  const looked = new Float64Array(Math.ceil(count / stride));
  for (let i = 0, from = 0; from < count; i++, from += stride) looked[i] = Math.abs(lambda[from]);
  looked.sort();
  return roundUp(looked[Math.floor(looked.length * 0.95)]);
}
