// How much of the plane the stage shows: all that the motion reaches, in steps, so that it seldom
// changes.
// Leaves to others: drawing. Scale of the forces' colours: the same idea, for the same reason.
// Invariant: what is shown follows from the motion and the stage's size alone, not from what was
// shown before.

import { centerOf, termOf } from "./terms.js";
import { cartAt } from "./track.js";
import { tips } from "./tree.js";

const LOOKS = 300; // samples that are looked at, at most
const STEPS = 6; // the box grows in sixths of the reach

/** @param {Box} box @param {number} x @param {number} y */
function widen(box, x, y) {
  box.side = Math.max(box.side, Math.abs(x));
  box.up = Math.max(box.up, y);
  box.down = Math.max(box.down, -y);
}

/**
 * Widens a box by all parts of a tree: its tips, joints beside them, the centers of its bodies.
 * @param {Box} box @param {Tree} tree @param {ArrayLike<number>} phi @param {number} offset
 * @param {Spots} spots
 */
export function widenBy(box, tree, phi, offset, { x, y, fromX, fromY }) {
  for (let k = 0; k < x.length; k++) {
    widen(box, x[k], y[k]);
    if (tree.at) widen(box, fromX[k], fromY[k]);
    const body = tree.body && termOf(tree, "body", k);
    if (!body) continue;
    const [along, across] = centerOf(body);
    const [cos, sin] = [Math.cos(phi[offset + k]), Math.sin(phi[offset + k])];
    widen(box, fromX[k] + along * cos - across * sin, fromY[k] + along * sin + across * cos);
  }
}

/**
 * The least box around the pivot, in steps of the reach, that holds the motion: {side, up, down} in
 * metres.
 * @param {Track} track @param {number[]} rows @param {number} reach @param {Spots} spots
 * @returns {Box}
 */
export function boxOf(track, rows, reach, spots) {
  const { pendulum: tree, span } = track.doc;
  const box = { side: 0, up: 0, down: 0 };
  const step = reach / STEPS;
  const most = tree.pivot?.cart ? Infinity : STEPS; // a cart goes where it will
  /** @param {ArrayLike<number>} phi @param {number} row */
  const look = (phi, row) => {
    spots.cart = cartAt(track, row);
    tips(tree, rows, phi, row * track.n, spots, (span.start ?? 0) + row * span.step);
    widenBy(box, tree, phi, row * track.n, spots);
  };
  look(track.initial.phi, 0);
  const stride = Math.ceil(track.count / LOOKS);
  for (let i = 0; i < track.count; i += stride) look(track.columns.phi, i);
  /** @param {number} value */
  const stepped = (value) => Math.min(most, Math.ceil((value / reach) * STEPS - 1e-6)) * step;
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
